"""Other materials for the instances of a word."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from scenelang.grammar.diagnostics import SceneError
from scenelang.grammar.settings import fits
from scenelang.interpreter.scene.entity import Entity
from scenelang.interpreter.scene.primitives.base import color_of
from scenelang.interpreter.values.values import Embedding, Pair, Vector


def look_value(name: str, value: Any) -> Any:
    """Return the value of an attribute of a material from a plain Python value; raises SceneError."""
    if name == "color" and isinstance(value, str):
        from scenelang.stdlib.colors import color_of as named_color

        return named_color(value)
    if fits(value, "float"):
        return float(value)
    if isinstance(value, Sequence | np.ndarray) and all(fits(x, "float") for x in value):
        return Vector(float(x) for x in value)
    raise SceneError("value", f"`{name}`: expected a number or a vector, got {value!r}")


def restyled(entity: Entity, word: str, look: Mapping[str, Any], known: dict[tuple[int, bool], Entity]) -> Entity:
    """Copy the graph below ``entity`` and add the attributes ``look`` to everything at or below ``word``.

    Parameters
    ----------
    known
        Copies made so far, by entity and whether it is inside ``word``; entities that are shared stay shared.
    """
    stack = [(entity, False)]  # instead of recursion, because graphs can be deeper than Python's stack
    while stack:
        top, inherited = stack[-1]
        inside = inherited or top.word == word
        if (id(top), inherited) in known:
            stack.pop()
            continue
        waiting = [(part.car, inside) for part in top.children if (id(part.car), inside) not in known]
        if waiting:
            stack.extend(waiting)
            continue
        stack.pop()
        children = tuple(Pair(known[id(part.car), inside], part.cdr) for part in top.children)
        known[id(top), inherited] = _copy(top, children, look if inside else {})
    return known[id(entity), False]


def _copy(entity: Entity, children: tuple[Any, ...], look: Mapping[str, Any]) -> Entity:
    """Copy an entity with other children and attributes added; the color of its shape follows."""
    original = entity.embedding
    embedding = Embedding(original.handle, original.text, {**original.attributes, **look}) if look else original
    shape = entity.shape
    if shape is not None and "color" in look:
        shape = replace(shape, color=color_of(entity.word, look["color"]))
    return Entity(entity.word, embedding, children, shape, entity.tainted, entity.call_sites)
