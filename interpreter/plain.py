"""Attributes as plain data, for JSON and files: numbers, arrays, strings, booleans, lists, tables (language.md, 4)."""

from __future__ import annotations

import math
from typing import Any

from scenelang.interpreter import pose
from scenelang.interpreter.entity import Entity
from scenelang.interpreter.shapes import default_attributes
from scenelang.interpreter.values import (
    NIL,
    Array,
    Embedding,
    Keyword,
    Matrix,
    MutableArray,
    MutableList,
    Pair,
    Symbol,
    Table,
    Vector,
)

MAX_DEPTH = 100
MAX_ITEMS = 1_000_000


class NotPlain(Exception):
    """The value holds something that no file can: a function, an entity, nan, or nesting without end."""


def plain_value(value: Any, tagged: bool = False) -> Any:
    """``value`` as JSON data. ``tagged`` keeps arrays, tables and embeddings apart from lists, to read them back."""
    return _plain(value, tagged, 0, [MAX_ITEMS])


def _plain(value: Any, tagged: bool, depth: int, room: list[int]) -> Any:
    kind = type(value)
    room[0] -= 1
    if depth > MAX_DEPTH or room[0] < 0:
        raise NotPlain
    if value is None or kind in (str, int, bool):
        return value
    if kind is float:
        if not math.isfinite(value):
            raise NotPlain
        return value
    if kind in (Symbol, Keyword):
        return str(value)
    array = _array(value)
    if array is not None:
        return {"array": array} if tagged else array

    def inner(item: Any) -> Any:
        return _plain(item, tagged, depth + 1, room)

    if kind is Pair or value is NIL or kind is MutableList:
        return [inner(item) for item in _items(value)]
    if kind is Table:
        if tagged:
            return {"table": [[inner(key), inner(item)] for key, item in value.entries.values()]}
        return {str(inner(key)): inner(item) for key, item in value.entries.values()}
    if kind is Embedding:
        attributes = {name: inner(item) for name, item in value.attributes.items()}
        if tagged:
            return {"embedding": [value.handle, value.text, attributes]}
        return {"handle": value.handle, "text": value.text, "attributes": attributes}
    raise NotPlain


def _array(value: Any) -> Any:
    if type(value) is Vector:
        return list(value)
    if type(value) is Matrix:
        return pose.to_array(value).tolist()
    if isinstance(value, (Array, MutableArray)):
        return value.data.tolist()
    return None


def _items(value: Any) -> list[Any]:
    if type(value) is MutableList:
        return list(value.items)
    items = []
    while type(value) is Pair:
        items.append(value.car)
        value = value.cdr
    if value is not NIL:
        items.append(value)
    return items


def plain_attributes(entity: Entity) -> dict[str, Any]:
    """An entity's attributes as JSON data; what is not plain is left out."""
    found: dict[str, Any] = {}
    for name, value in entity.embedding.attributes.items():
        try:
            found[name] = plain_value(value)
        except NotPlain:
            continue
    return found


def primitive_attributes(entity: Entity) -> dict[str, Any]:
    """A primitive's attributes as JSON data, its geometry's defaults filled in; what is not plain is left out."""
    found = plain_attributes(entity)
    if entity.shape is not None:
        defaults = default_attributes(entity.shape)
        found = {**{k: v for k, v in defaults.items() if k not in found or k != "fill"}, **_kept(found, defaults)}
    return found


def _kept(found: dict[str, Any], defaults: dict[str, Any]) -> dict[str, Any]:
    """The given attributes that geometry does not normalise (``fill`` is the program's own)."""
    return {name: value for name, value in found.items() if name not in defaults or name == "fill"}
