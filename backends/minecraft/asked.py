"""What a primitive asks for: the block and the properties that the program names, before anything is known of them."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from scenelang.backends.minecraft.blocks import AIR_STATE, BlockState
from scenelang.grammar.diagnostics import SceneError
from scenelang.grammar.source import Span
from scenelang.interpreter.entity import Entity
from scenelang.interpreter.plain import NotPlain, plain_value
from scenelang.interpreter.shapes import Kind

NAMESPACE = "minecraft:"
_NAME = re.compile(r"([a-z0-9_.-]+:)?[a-z0-9_./-]+")


def asked_state(entity: Entity) -> BlockState:
    """The block that a "set-cuboid" or "delete-blocks" lays, with only the properties that the program gives.

    Raises SceneError("attribute"), with the place in the program, where ``:block-type`` or ``:block-kwargs`` is
    missing or none.
    """
    if entity.shape is not None and entity.shape.kind is Kind.VOID:
        return AIR_STATE
    name = entity.embedding.attributes.get("block-type")
    if not isinstance(name, str) or not name.strip():
        raise _problem(entity, "block-type", 'the name of a block, such as "stone"')
    return BlockState(namespaced(name), properties_of(entity))


def namespaced(name: str) -> str:
    """``Oak Planks`` as ``minecraft:oak_planks``: lower case, with underscores and the namespace."""
    plain = re.sub(r"\s+", "_", name.strip().lower())
    return plain if ":" in plain else NAMESPACE + plain


def is_name(name: str) -> bool:
    """True where the game could have a block of this name."""
    return _NAME.fullmatch(name) is not None


def properties_of(entity: Entity) -> tuple[tuple[str, str], ...]:
    """The properties that ``:block-kwargs`` gives, sorted by name, values as the game writes them."""
    given = entity.embedding.attributes.get("block-kwargs")
    try:
        pairs = _pairs(plain_value(given))
    except (NotPlain, ValueError):
        raise _problem(
            entity, "block-kwargs", 'an association list or table of properties, such as `\'(("facing" "north"))`'
        ) from None
    return tuple(sorted(pairs.items()))


def _pairs(given: Any) -> dict[str, str]:
    if given is None:
        return {}
    if isinstance(given, Mapping):
        return {_text(name): _text(value) for name, value in given.items()}
    if isinstance(given, list) and all(isinstance(pair, list) and len(pair) == 2 for pair in given):
        return {_text(name): _text(value) for name, value in given}
    raise ValueError


def _text(value: Any) -> str:
    """A name or value as the game writes it: ``true``, ``7``, ``north``."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float) and value.is_integer():
        value = int(value)
    if isinstance(value, (str, int)):
        return str(value).strip().lower().removeprefix(":")
    raise ValueError


def place_of(entity: Entity) -> Span | None:
    """Where the program made a primitive, the first of several places."""
    return entity.places[0] if entity.places else None


def _problem(entity: Entity, name: str, wanted: str) -> SceneError:
    message = f'the attribute `:{name}` of "{entity.word}" must be {wanted}'
    return SceneError("attribute", message, span=place_of(entity))
