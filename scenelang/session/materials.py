"""Instances of a scene by path, such as ``chair/leg[2]``: where they are, scenes of parts, and other materials."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from scenelang.grammar.diagnostics import SceneError
from scenelang.grammar.settings import fits
from scenelang.interpreter.scene.entity import Entity
from scenelang.interpreter.scene.primitives.base import color_of
from scenelang.interpreter.values.values import Embedding, Pair, Vector

if TYPE_CHECKING:
    pass

FloatArray = npt.NDArray[np.float64]


# --- materials -------------------------------------------------------------------------------------------------------


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

    Shared parts stay shared. Iterative, since deep graphs would exceed the recursion limit.
    """
    stack = [(entity, False)]
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
    own = entity.embedding
    embedding = Embedding(own.handle, own.text, {**own.attributes, **look}) if look else own
    shape = entity.shape
    if shape is not None and "color" in look:
        shape = replace(shape, color=color_of(entity.word, look["color"]))
    return Entity(entity.word, embedding, children, shape, entity.tainted, entity.call_sites)
