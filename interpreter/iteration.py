"""Iterating and taking apart the language's sequences."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import islice
from typing import TYPE_CHECKING, Any

from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter import pose
from scenelang.interpreter.arrays import from_numpy
from scenelang.interpreter.show import show
from scenelang.interpreter.types import type_name
from scenelang.interpreter.values import (
    NIL,
    Array,
    HandleList,
    Matrix,
    MutableArray,
    MutableList,
    Pair,
    Set,
    Table,
    Vector,
)

if TYPE_CHECKING:
    from scenelang.interpreter.runtime import Runtime


_BLOCK = 1024  # items between two checks


def iterate(rt: Runtime, value: Any) -> Iterable[Any]:
    """What a ``for`` clause runs through: the items of a sequence, or 0 .. n-1 for a whole number n."""
    kind = type(value)
    if kind is Pair:
        return _list_iterator(value)
    if value is NIL:
        return ()
    if kind is Vector or kind is str:
        return value  # type: ignore[no-any-return]
    if kind is int:
        return range(value)
    if kind is MutableList:
        rt.read(value)
        return value.items  # type: ignore[no-any-return]
    if kind is Table:
        rt.read(value)
        rt.charge(len(value.entries) >> 4)
        return _unchanging(value, [key for key, _ in value.entries.values()])
    if kind is Set:
        rt.read(value)
        rt.charge(len(value.entries) >> 4)
        members = list(value.entries.values())
        warn_of_order(rt, members)
        return _unchanging(value, members)
    return rows(rt, value)


def warn_of_order(rt: Runtime, members: list[Any]) -> None:
    """Warn that the order of a set of strings is not Python's."""
    if len(members) > 1 and any(type(member) is str for member in members):
        rt.warn("set-order", "a set of strings is taken in the order of insertion, which Python does not keep")


def rows(rt: Runtime, value: Any) -> list[Any]:
    """The rows of an array of two or more dimensions."""
    if type(value) is Matrix:
        return [Vector(row) for row in pose.to_array(value).tolist()]
    if isinstance(value, (Array, MutableArray)):
        if isinstance(value, MutableArray):
            rt.read(value)
        return array_rows(rt, value.data)
    if type(value) is HandleList:
        raise SceneError("endless", "the root's list of handles has no end", "take some: `(list-head gamma n)`")
    raise SceneError("type", f"a sequence is wanted here, got {type_name(value)}: {show(value, 60)}")


def array_rows(rt: Runtime, data: Any) -> list[Any]:
    """The items of a numpy array along its first axis, as values."""
    if data.ndim == 1:
        rt.charge(data.size >> 6)
        numbers: list[Any] = data.tolist()
        return numbers
    out: list[Any] = []
    for start in range(0, len(data), _BLOCK):
        block = data[start : start + _BLOCK]
        rt.charge((len(block) >> 2) + (block.size >> 5) + 1)
        out += [Vector(row) for row in block.tolist()] if data.ndim == 2 else map(from_numpy, block)
    return out


def _list_iterator(value: Any) -> Iterator[Any]:
    while type(value) is Pair:
        yield value.car
        value = value.cdr
    if value is not NIL:
        raise SceneError("type", "a list is wanted here, got a pair whose tail is no list")


def _unchanging(collection: Any, members: list[Any]) -> Iterator[Any]:
    size = len(collection.entries)
    for member in members:
        if len(collection.entries) != size:
            raise SceneError("changed", "a table or set was changed while it was being iterated", "iterate a copy")
        yield member
    if members and len(collection.entries) != size:
        raise SceneError("changed", "a table or set was changed while it was being iterated", "iterate a copy")


def items_of(rt: Runtime, value: Any) -> list[Any]:
    """The items of a sequence as a new Python list, for patterns and builtins."""
    if type(value) is int:
        raise SceneError("type", f"a sequence is wanted here, got an Integer: {show(value, 60)}")
    out: list[Any] = []
    pending = iter(iterate(rt, value))
    while block := list(islice(pending, _BLOCK)):
        out += block
        if len(block) == _BLOCK:
            rt.charge(_BLOCK >> 4)
    return out
