"""Helpers that the builtins share: conversion to arrays, the items of sequences, equality and common errors."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, Any, TypeAlias

from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.loading import np
from scenelang.interpreter.runtime.procedures import array_rows, warn_set_order
from scenelang.interpreter.runtime.show import described, show
from scenelang.interpreter.runtime.show import from_numpy as from_numpy
from scenelang.interpreter.runtime.show import numbers_to_numpy as numbers_to_numpy
from scenelang.interpreter.runtime.types import vector_of
from scenelang.interpreter.scene import pose
from scenelang.interpreter.scene.entity import Entity
from scenelang.interpreter.values import values
from scenelang.interpreter.values.values import (
    NIL,
    Array,
    Embedding,
    HandleList,
    Keyword,
    Matrix,
    Mutable,
    MutableArray,
    MutableList,
    Pair,
    Record,
    Set,
    Symbol,
    Table,
    Vector,
    list_items,
    make_list,
)

if TYPE_CHECKING:
    import numpy.typing as npt

    from scenelang.interpreter.runtime.runtime import Runtime


Numpy: TypeAlias = "npt.NDArray[Any]"
ARRAYS = (Vector, Matrix, Array, MutableArray)
INT64 = 1 << 63  # integers of arrays are smaller
_MAX_DEPTH = 32  # of nested lists, and dimensions of an array
_MAX_FREE_ITEMS = 32  # of a vector that is read without charge


def is_array(value: Any) -> bool:
    """Return whether a value is an array, of whatever representation."""
    return isinstance(value, ARRAYS)


def to_numpy(rt: Runtime, value: Any, name: str = "array") -> Numpy:
    """Convert a number, an array or a nested list of numbers to a numpy array that cannot change later.

    ``name`` is the builtin that errors name. Raises SceneError for other values, and for lists of different lengths.
    """
    kind = type(value)
    if kind is int or kind is float:
        return numbers_to_numpy(value)
    if kind is Vector:
        if len(value) > _MAX_FREE_ITEMS:
            rt.charge(len(value) >> 5)
        return numbers_to_numpy(list(value))
    if kind is Matrix:
        return pose.to_array(value)
    if kind is Array:
        data: Numpy = value.data
        rt.charge(data.size >> 7)
        return data
    if kind is MutableArray:
        rt.read(value)
        rt.charge(value.data.size >> 4)
        return np.array(value.data)
    if kind is Pair or value is NIL or kind is MutableList:
        return _from_list(rt, value, name)
    raise not_numeric(name, value)


def not_numeric(name: str, value: Any) -> SceneError:
    """Return the error for an argument that is neither a number nor an array."""
    message = f"`{name}` expects numbers or arrays, got {described(value, 60)}"
    return SceneError("type", message)


def _from_list(rt: Runtime, value: Any, name: str) -> Numpy:
    """Convert nested lists of numbers and arrays to a numpy array."""
    nested = _nested(rt, value, name, 0)
    try:
        return numbers_to_numpy(nested)
    except ValueError:
        raise SceneError("value", f"`{name}` expects rows of equal length, got {show(value, 60)}") from None


def _nested(rt: Runtime, value: Any, name: str, depth: int) -> Any:
    """Return lists and arrays as Python lists; recursive, with a bounded depth."""
    kind = type(value)
    if kind is int or kind is float:
        return value
    if kind is Pair or value is NIL or kind is MutableList:
        if depth == _MAX_DEPTH:
            raise SceneError("value", f"`{name}` expects a list of at most {_MAX_DEPTH} levels, got a deeper one")
        if kind is MutableList:
            rt.read(value)
        members = value.items if kind is MutableList else _proper(rt, name, value)
        rt.charge(1 + len(members))
        return [_nested(rt, member, name, depth + 1) for member in members]
    if kind is Vector:
        rt.charge(len(value) >> 5)
        return list(value)
    if kind in ARRAYS:
        data = to_numpy(rt, value, name)
        rt.charge(data.size >> 5)
        return data.tolist()
    raise not_numeric(name, value)


def _proper(rt: Runtime, name: str, value: Any) -> list[Any]:
    """Return the items of a list; an improper one is an error."""
    members, tail = [], value
    while type(tail) is Pair:
        members.append(tail.car)
        tail = tail.cdr
    if tail is not NIL:
        rt.charge(len(members) >> 4)  # a program may catch the error
        raise improper(name, tail)
    return members


def from_flat(flat: list[Any], shape: tuple[int, ...]) -> Any:
    """Return the array of ``shape`` of the Python numbers ``flat``, in row-major order."""
    if len(shape) == 1:
        return vector_of(flat)
    return from_numpy(numbers_to_numpy(flat).reshape(shape))


def shape_of(value: Any) -> tuple[int, ...]:
    """Return the shape of a number or an array."""
    kind = type(value)
    if kind is Vector:
        return (len(value),)
    if kind is Matrix:
        return (4, 4)
    if kind is Array or kind is MutableArray:
        shape: tuple[int, ...] = value.data.shape
        return shape
    return ()


def flat_items(rt: Runtime, value: Any) -> list[Any]:
    """Return all numbers of an array as Python numbers, in row-major order."""
    if type(value) is Vector:
        return list(value)
    data = to_numpy(rt, value)
    rt.charge(data.size >> 5)
    return data.ravel().tolist()


def check_shape(rt: Runtime, shape: Sequence[int], name: str) -> tuple[int, ...]:
    """Return ``shape``; negative sides, too many dimensions and too many items are errors."""
    if len(shape) > _MAX_DEPTH:
        raise SceneError("value", f"`{name}` supports at most {_MAX_DEPTH} dimensions, got {len(shape)}")
    size = 1
    for side in shape:
        if side < 0:
            raise SceneError("value", f"`{name}` expects a shape without negative sides, got {_shape_text(shape)}")
        size *= side
    rt.meter.check_size(max(size, *shape) if shape else 1, "an array")
    return tuple(shape)


def shape_argument(rt: Runtime, value: Any, name: str) -> tuple[int, ...]:
    """Return the shape that an argument of the builtin ``name`` gives: a count, or a list or vector of counts.

    Raises SceneError("type") for other values, and the errors of ``check_shape``.
    """
    if type(value) in (int, float):
        sides = [value]
    elif type(value) is MutableList:
        rt.read(value)
        sides = value.items
    else:
        sides = list(value) if type(value) is Vector else list_items(value)
    rt.charge(len(sides) >> 4)
    counts = []
    for side in sides:
        if type(side) is float and side.is_integer():
            side = int(side)
        if type(side) is not int:
            raise SceneError("type", f"`{name}` expects a shape of whole numbers, got {show(value, 60)}")
        counts.append(side)
    if not counts and value is not NIL:
        raise SceneError("type", f"`{name}` expects a shape such as 3 or '(2 3), got {show(value, 60)}")
    return check_shape(rt, counts, name)


def _shape_text(shape: Sequence[int]) -> str:
    """Return a shape as the program would write it, for error messages."""
    return show(make_list(shape), 200)


def common_shape(rt: Runtime, name: str, *arrays: Numpy) -> tuple[int, ...]:
    """Return the shape of the result of an elementwise operation on arrays.

    Raises SceneError, which names the builtin ``name``, for shapes that cannot be broadcast.
    """
    try:
        shape = np.broadcast_shapes(*(array.shape for array in arrays))
    except ValueError:
        shapes = " and ".join(_shape_text(array.shape) for array in arrays)
        raise SceneError("value", f"`{name}` cannot broadcast arrays of the shapes {shapes}") from None
    return check_shape(rt, shape, name)


def largest(data: Numpy) -> int:
    """Return the largest absolute value in an integer array, as a Python integer."""
    if data.size == 0:
        return 0
    return max(abs(int(data.min())), abs(int(data.max())))


def without_overflow(data: Numpy, growth: int) -> Numpy:
    """Return ``data``, as floats if integers ``growth`` times as large would overflow."""
    if data.dtype.kind == "i" and largest(data) * growth >= INT64:
        return data.astype(np.float64)
    return data


def wrong_type(name: str, expected: str, value: Any, hint: str | None = None) -> SceneError:
    """Return the error for an argument ``value`` of the function ``name`` that is not ``expected``."""
    return SceneError("type", f"`{name}` expects {expected}, got {described(value, 60)}", hint=hint)


def not_a_sequence(name: str, value: Any) -> SceneError:
    """Return the error for a ``value`` that is not a sequence."""
    if type(value) is HandleList:
        return infinite_error(name)
    hint = "to get the list of its parts, write `(cdr entity)`" if type(value) is Entity else None
    return wrong_type(name, "a list or another sequence", value, hint)


def infinite_error(name: str) -> SceneError:
    """Return the error for the unbounded list of the root's handles."""
    message = f"`{name}` needs the whole list, but the root's list of handles is infinite"
    return SceneError("endless", message, hint="to use the first n handles, write `(list-head gamma n)`")


def improper(name: str, tail: Any) -> SceneError:
    """Return the error of the builtin ``name`` for a chain of pairs that ends in ``tail`` and not in the empty list."""
    if type(tail) is Matrix:
        hint = "a pair `(entity . matrix)` is not a list: write `(list pair)` or `(union pair)`"
    else:
        hint = "only a chain of pairs that ends in '() is a proper list"
    return SceneError("type", f"`{name}` expects a proper list, got one that ends in {show(tail, 40)}", hint=hint)


def kind_of(value: Any) -> str:
    """Return the word for a sequence in index errors."""
    if type(value) is str:
        return "string"
    if type(value) is Pair or value is NIL or type(value) is MutableList:
        return "list"
    if type(value) is Vector or (type(value) is MutableArray and value.data.ndim == 1):
        return "vector"
    return "array"


def bad_index(index: Any, length: int, kind: str) -> SceneError:
    """Return the error for an ``index`` outside a sequence of ``length``."""
    hint = None
    if length and index == length:
        hint = f"indices start at 0, so the last one is {length - 1}"
    return SceneError("index", f"index {show(index, 20)} is outside the {kind} of length {length}", hint=hint)


def empty_sequence(name: str, kind: str = "sequence") -> SceneError:
    """Return the error for an empty sequence, as an argument of the builtin ``name`` that expects a ``kind``."""
    return SceneError("index", f"`{name}` expects a {kind} with at least one item, got an empty one")


_BLOCK_ITEMS = 4096  # between two checks of the limits


def items(rt: Runtime, value: Any, name: str = "a sequence", ordered: bool = True) -> list[Any]:
    """Return the items of any sequence as a new Python list.

    Parameters
    ----------
    value
        List, array, string, table (its keys) or set; anything else raises SceneError("type").
    name
        Builtin that is named in errors.
    ordered
        Whether the result of the builtin depends on the order, which for a set of strings differs from Python's.
    """
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
        out = _other_items(rt, value, name, ordered=ordered)
    rt.charge(len(out) >> 2)
    return out


def _other_items(rt: Runtime, value: Any, name: str, *, ordered: bool) -> list[Any]:
    """Return the items of a matrix, array, table or set."""
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
            warn_set_order(rt, members)
        return members
    raise not_a_sequence(name, value)


def rows(rt: Runtime, value: Any) -> list[Any]:
    """Return the items of an array along its first axis."""
    data = to_numpy(rt, value)
    if data.ndim == 0:
        raise not_a_sequence("a sequence", value)
    return array_rows(rt, data)


def iterate(rt: Runtime, value: Any, name: str = "a sequence") -> Iterable[Any]:
    """Return the items of a sequence, as ``items`` does, for a loop that calls functions of the program.

    If such a function changes the size of the table or set that is iterated, the next step raises
    SceneError("changed").
    """
    if type(value) is Table or type(value) is Set:
        return _checked_members(value, items(rt, value, name))
    return items(rt, value, name)


def _checked_members(collection: Table | Set, members: list[Any]) -> Iterator[Any]:
    """Iterate over members; raise SceneError if the size of their collection changes."""
    count = len(members)
    for member in members:
        yield member
        if len(collection.entries) != count:
            kind = "table" if type(collection) is Table else "set"
            hint = "to modify it, iterate over a copy: `(->list ...)`"
            raise SceneError("changed", f"the {kind} was changed while it was being iterated", hint=hint)


def blocks(rt: Runtime, members: Sequence[Any]) -> Iterator[Sequence[Any]]:
    """Yield ``members`` in blocks, each charged in advance, for a loop that creates a value for every item."""
    for start in range(0, len(members), _BLOCK_ITEMS):
        block = members[start : start + _BLOCK_ITEMS]
        rt.charge(1 + (len(block) >> 3))
        yield block


def length(rt: Runtime, value: Any, name: str = "length") -> int:
    """Return the number of items of any sequence.

    ``name`` is the builtin that the error for anything else names. Of an array, the first axis counts.
    """
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
    """Return ``members`` as an immutable sequence of the kind of ``original``: string, array or list."""
    kind = type(original)
    rt.charge(len(members) >> 5)
    if kind is str:
        return "".join(members)
    if kind is Vector or (kind is MutableArray and original.data.ndim == 1):
        return vector_of(members)
    if kind in (Matrix, Array, MutableArray):
        if not members:
            return from_numpy(to_numpy(rt, original)[:0])
        return from_numpy(_stack_rows(rt, members))
    return make_list(members)


def _stack_rows(rt: Runtime, members: list[Any]) -> Numpy:
    """Return the array whose items along the first axis are ``members``, all of one shape."""
    first = to_numpy(rt, members[0])
    rt.meter.check_size(first.size * len(members), "an array")
    out = np.empty((len(members), *first.shape), first.dtype)
    for index, member in enumerate(members):
        if not index & 255:
            rt.charge(256 >> 2)
        out[index] = to_numpy(rt, member)
    return out


def record_read(rt: Runtime, *values: Any) -> None:
    """Record that the contents of those ``values`` that are mutable are read."""
    for value in values:
        if isinstance(value, Mutable):
            rt.read(value)


def same_value(rt: Runtime, a: Any, b: Any) -> bool:
    """Return whether two values are equal as in sets and tables: by structure, numbers by value."""
    record_read(rt, a, b)
    return values.equal(rt, a, b, typed=False)


_BY_VALUE = (int, float, str, Symbol, Keyword)


def identical(a: Any, b: Any) -> bool:
    """Return whether two values are the same for ``eq?``: the same object, or equal numbers or texts of one type."""
    return a is b or (type(a) is type(b) and type(a) in _BY_VALUE and a == b)


def is_true(value: Any) -> bool:
    """Return the truth value of a condition: only #f and none are false."""
    return value is not False and value is not None


_MUTABLE_COUNTERPARTS: dict[type, tuple[str, str]] = {
    Pair: ("a list", "a mutable list"),
    type(NIL): ("a list", "a mutable list"),
    Vector: ("a Vector", "a mutable array"),
    Matrix: ("a Matrix", "a mutable array"),
    Array: ("an Array", "a mutable array"),
    str: ("a String", "a mutable list of its characters"),
}


def cannot_change(name: str, value: Any, expected: str) -> SceneError:
    """Return the error for a ``value`` that is immutable, or of a type other than ``expected``."""
    kind = type(value)
    if kind in _MUTABLE_COUNTERPARTS:
        immutable, counterpart = _MUTABLE_COUNTERPARTS[kind]
        call = "`(mutable x)`" if kind is str else f"`({counterpart[2:].replace(' ', '-')} ...)` or `(mutable x)`"
        hint = f"use {counterpart}: {call}"
        return SceneError("immutable", f"`{name}` cannot modify {immutable}, which is immutable", hint=hint)
    if kind is Entity or kind is Embedding:
        immutable = "an Entity" if kind is Entity else "an Embedding"
        return SceneError(
            "immutable", f"`{name}` cannot modify {immutable}, which is immutable", hint="create a new one"
        )
    if kind is Record:
        hint = f"to assign its fields, use `set-{value.type.name}-...!`"
        return wrong_type(name, expected, value, hint)
    return wrong_type(name, expected, value)


def reorder(rt: Runtime, name: str, xs: Any, order: Any) -> None:
    """Replace the items of a mutable list or array by ``order(items)``; ``name`` is the builtin that errors name."""
    if type(xs) is MutableList:
        members = order(items(rt, xs, name))
        rt.write(xs)
        xs.items[:] = members
    elif type(xs) is MutableArray:
        members = [to_numpy(rt, row) for row in order(items(rt, xs, name))]
        rt.write(xs)
        rt.charge(len(members) >> 4)
        for index, row in enumerate(members):
            xs.data[index] = row
    else:
        raise cannot_change(name, xs, "a mutable list or a mutable array")
