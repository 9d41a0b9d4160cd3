"""Taking any sequence of the language apart, and putting one of the same kind together."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import Any

import numpy as np

from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.iteration import array_rows, warn_of_order
from scenelang.interpreter.runtime import Runtime
from scenelang.interpreter.types import vector_of
from scenelang.interpreter.values import (
    NIL,
    Array,
    Matrix,
    MutableArray,
    MutableList,
    Pair,
    Set,
    Table,
    Vector,
    make_list,
)
from scenelang.stdlib.arraydata import Numpy, from_numpy, to_numpy
from scenelang.stdlib.errors import improper, not_a_sequence

_BLOCK = 4096  # items between two checks


def items(rt: Runtime, value: Any, name: str = "a sequence", ordered: bool = True) -> list[Any]:
    """The items of any sequence as a new Python list; ``ordered``: whether their order shows in the result."""
    kind = type(value)
    if kind is Pair or value is NIL:
        out = []
        while type(value) is Pair:
            out.append(value.car)
            value = value.cdr
        if value is not NIL:
            rt.charge(len(out) >> 4)
            raise improper(name, value)
    elif kind is MutableList:
        rt.read(value)
        out = list(value.items)
    elif kind is Vector or kind is str:
        out = list(value)
    else:
        out = _other_items(rt, value, name, ordered)
    rt.charge(len(out) >> 2)
    return out


def _other_items(rt: Runtime, value: Any, name: str, ordered: bool) -> list[Any]:
    kind = type(value)
    if kind is Matrix:
        return [Vector(value[0:4]), Vector(value[4:8]), Vector(value[8:12]), Vector((0.0, 0.0, 0.0, 1.0))]
    if kind is Array or kind is MutableArray:
        return rows(rt, value)
    if kind is Table:
        rt.read(value)
        return [key for key, _ in value.entries.values()]
    if kind is Set:
        rt.read(value)
        members = list(value.entries.values())
        if ordered:
            warn_of_order(rt, members)
        return members
    raise not_a_sequence(name, value)


def rows(rt: Runtime, value: Any) -> list[Any]:
    """The items of an array along its first axis."""
    data = to_numpy(rt, value)
    if data.ndim == 0:
        raise not_a_sequence("a sequence", value)
    return array_rows(rt, data)


def iterate(rt: Runtime, value: Any, name: str = "a sequence") -> Iterable[Any]:
    """``items`` for loops that call the program's functions: a table or set must not change meanwhile."""
    if type(value) is Table or type(value) is Set:
        return _watched(value, items(rt, value, name))
    return items(rt, value, name)


def _watched(collection: Table | Set, members: list[Any]) -> Iterator[Any]:
    count = len(members)
    for member in members:
        yield member
        if len(collection.entries) != count:
            what = "table" if type(collection) is Table else "set"
            hint = "go through a copy: `(->list ...)`"
            raise SceneError("changed", f"the {what} was changed while it was being iterated", hint=hint)


def blocks(rt: Runtime, members: Sequence[Any]) -> Iterator[Sequence[Any]]:
    """``members`` in pieces, each charged before it is given, for a loop that makes something of every item."""
    for start in range(0, len(members), _BLOCK):
        block = members[start : start + _BLOCK]
        rt.charge(1 + (len(block) >> 3))
        yield block


def length(rt: Runtime, value: Any, name: str = "length") -> int:
    """The number of items of any sequence."""
    kind = type(value)
    if kind is Pair:
        count = 0
        while type(value) is Pair:
            count += 1
            value = value.cdr
        rt.charge(count >> 4)
        if value is not NIL:
            raise improper(name, value)
        return count
    if kind is Vector or kind is str:
        return len(value)
    if value is NIL:
        return 0
    if kind is Matrix:
        return 4
    if kind is Array:
        return len(value.data)
    if kind is MutableList:
        rt.read(value)
        return len(value.items)
    if kind is Table or kind is Set:
        rt.read(value)
        return len(value.entries)
    if kind is MutableArray and value.data.ndim:
        rt.read(value)
        return len(value.data)
    raise not_a_sequence(name, value)


def rebuild(rt: Runtime, original: Any, members: list[Any]) -> Any:
    """``members`` as an immutable sequence of the kind that ``original`` is: string, array or list."""
    kind = type(original)
    rt.charge(len(members) >> 5)
    if kind is str:
        return "".join(members)
    if kind is Vector or (kind is MutableArray and original.data.ndim == 1):
        return vector_of(members)
    if kind in (Matrix, Array, MutableArray):
        if not members:
            return from_numpy(to_numpy(rt, original)[:0])
        return from_numpy(_joined_rows(rt, members))
    return make_list(members)


def _joined_rows(rt: Runtime, members: list[Any]) -> Numpy:
    """The array whose items along the first axis are ``members``, all of one shape."""
    first = to_numpy(rt, members[0])
    rt.meter.check_size(first.size * len(members), "an array")
    out = np.empty((len(members), *first.shape), first.dtype)
    for index, member in enumerate(members):
        if not index & 255:
            rt.charge(256 >> 2)
        out[index] = to_numpy(rt, member)
    return out
