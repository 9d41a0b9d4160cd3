"""What a primitive asks for: the block and the properties that the program names, before anything is known of them."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from scenelang.backends.minecraft.block_names import without_number
from scenelang.backends.minecraft.blocks import AIR_STATE, NOTHING, BlockState
from scenelang.grammar.diagnostics import SceneError
from scenelang.grammar.source import Span
from scenelang.interpreter.entity import Entity
from scenelang.interpreter.plain import NotPlain, plain_value
from scenelang.interpreter.shapes import Kind

NAMESPACE = "minecraft:"
_WITH_STATE = re.compile(r"([^\[\]]+)\[([^\[\]]*)\]")  # as the game writes it: oak_log[axis=x]


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
    within = _WITH_STATE.fullmatch(name.strip())
    given = _pairs_of_text(within[2]) if within else {}
    state = tuple(sorted({**given, **properties_of(entity)}.items()))
    block = namespaced(within[1] if within else name)
    return AIR_STATE if block in NOTHING else BlockState(block, state)


def is_hollow(entity: Entity) -> bool:
    """Whether only the six faces are laid; raises SceneError("attribute") where ``:fill`` is neither true nor false."""
    fill = entity.embedding.attributes.get("fill")
    if fill is not None and not isinstance(fill, bool):
        raise _problem(entity, "fill", "#t or #f")
    return fill is False


def namespaced(name: str) -> str:
    """``Oak Planks`` as ``minecraft:oak_planks``: lower case, with underscores and the namespace; names with numbers,
    from before 1.13, as they are today."""
    plain = without_number(re.sub(r"\s+", "_", name.strip().lower()).removeprefix(NAMESPACE))
    return plain if ":" in plain else NAMESPACE + plain


def properties_of(entity: Entity) -> dict[str, str]:
    """The properties that ``:block-kwargs`` gives, values as the game writes them; raises SceneError("attribute")."""
    given = entity.embedding.attributes.get("block-kwargs")
    try:
        return _pairs(plain_value(given))
    except (NotPlain, ValueError):
        raise _problem(
            entity, "block-kwargs", 'an association list or table of properties, such as `\'(("facing" "north"))`'
        ) from None


def _pairs_of_text(text: str) -> dict[str, str]:
    pairs = [pair.partition("=") for pair in text.split(",") if pair.strip()]
    return {_text(name): _text(value) for name, _, value in pairs}


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
