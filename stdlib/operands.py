"""What the builtins do with their operands: arrays from numbers, the items of sequences, equality, shared errors."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.runtime import values
from scenelang.interpreter.runtime.procedures import array_rows, warn_set_order
from scenelang.interpreter.runtime.runtime import Runtime
from scenelang.interpreter.runtime.show import from_numpy as from_numpy
from scenelang.interpreter.runtime.show import numbers_to_numpy as numbers_to_numpy
from scenelang.interpreter.runtime.show import show
from scenelang.interpreter.runtime.types import type_name, vector_of
from scenelang.interpreter.runtime.values import (
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
from scenelang.interpreter.scene import pose
from scenelang.interpreter.scene.entity import Entity

if TYPE_CHECKING:
    import numpy.typing as npt


Numpy: TypeAlias = "npt.NDArray[Any]"
ARRAYS = (Vector, Matrix, Array, MutableArray)
INT64 = 1 << 63
_DEEPEST = 32
_FEW = 32  # items that are not charged


def is_array(value: Any) -> bool:
    return isinstance(value, ARRAYS)


def to_numpy(rt: Runtime, value: Any, name: str = "array") -> Numpy:
    """A number, an array or a nested list of numbers as a numpy array, never one that can still change."""
    kind = type(value)
    if kind is int or kind is float:
        return numbers_to_numpy(value)
    if kind is Vector:
        if len(value) > _FEW:
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
    message = f"`{name}` wants numbers or arrays, got {type_name(value)}: {show(value, 60)}"
    return SceneError("type", message)


def _from_list(rt: Runtime, value: Any, name: str) -> Numpy:
    nested = _nested(rt, value, name, 0)
    try:
        return numbers_to_numpy(nested)
    except ValueError:
        raise SceneError("value", f"`{name}` wants rows of one length, got {show(value, 60)}") from None


def _nested(rt: Runtime, value: Any, name: str, depth: int) -> Any:
    """Lists and arrays as Python lists; the depth is bounded, so recursion is safe."""
    kind = type(value)
    if kind is int or kind is float:
        return value
    if kind is Pair or value is NIL or kind is MutableList:
        if depth == _DEEPEST:
            raise SceneError("value", f"`{name}` got a list that is nested deeper than {_DEEPEST} levels")
        if kind is MutableList:
            rt.read(value)
        members = value.items if kind is MutableList else list_items(value)
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


def from_flat(flat: list[Any], shape: tuple[int, ...]) -> Any:
    """The array of ``shape`` that holds the Python numbers ``flat``, row by row."""
    if len(shape) == 1:
        return vector_of(flat)
    return from_numpy(numbers_to_numpy(flat).reshape(shape))


def shape_of(value: Any) -> tuple[int, ...]:
    """The shape of a number or an array."""
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
    """All numbers of an array as Python numbers, row by row."""
    if type(value) is Vector:
        return list(value)
    data = to_numpy(rt, value)
    rt.charge(data.size >> 5)
    return data.ravel().tolist()


def check_shape(rt: Runtime, shape: Sequence[int], name: str) -> tuple[int, ...]:
    """``shape`` when an array of it may be made; refuses negative sides and too many items."""
    if len(shape) > _DEEPEST:
        raise SceneError("value", f"`{name}` makes arrays of at most {_DEEPEST} dimensions, got {len(shape)}")
    size = 1
    for side in shape:
        if side < 0:
            raise SceneError("value", f"`{name}` got the shape {_shape_text(shape)}; a side cannot be negative")
        size *= side
    rt.meter.check_size(max(size, *shape) if shape else 1, "an array")
    return tuple(shape)


def shape_argument(rt: Runtime, value: Any, name: str) -> tuple[int, ...]:
    """A shape written as a count, or as a list or vector of counts."""
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
            raise SceneError("type", f"`{name}` wants a shape, whole numbers, got {show(value, 60)}")
        counts.append(side)
    if not counts and value is not NIL:
        raise SceneError("type", f"`{name}` wants a shape such as 3 or '(2 3), got {show(value, 60)}")
    return check_shape(rt, counts, name)


def _shape_text(shape: Sequence[int]) -> str:
    return show(make_list(shape), 200)


def common_shape(rt: Runtime, name: str, *arrays: Numpy) -> tuple[int, ...]:
    """The shape of an element-wise result; refuses shapes that do not broadcast."""
    try:
        shape = np.broadcast_shapes(*(array.shape for array in arrays))
    except ValueError:
        shapes = " and ".join(_shape_text(array.shape) for array in arrays)
        raise SceneError("value", f"`{name}` got arrays whose shapes do not fit together: {shapes}") from None
    return check_shape(rt, shape, name)


def largest(data: Numpy) -> int:
    """The largest absolute value in an integer array, as a Python integer."""
    if data.size == 0:
        return 0
    return max(abs(int(data.min())), abs(int(data.max())))


def without_overflow(data: Numpy, growth: int) -> Numpy:
    """``data``, as floats when integer results ``growth`` times as large would not fit."""
    if data.dtype.kind == "i" and largest(data) * growth >= INT64:
        return data.astype(np.float64)
    return data


def wrong_type(name: str, wanted: str, value: Any, hint: str | None = None) -> SceneError:
    """``value`` is not what the function ``name`` wants."""
    return SceneError("type", f"`{name}` wants {wanted}, got {type_name(value)}: {show(value, 60)}", hint=hint)


def not_a_sequence(name: str, value: Any) -> SceneError:
    """``value`` cannot be taken apart into items."""
    if type(value) is HandleList:
        return endless(name)
    hint = "the list of its parts is `(cdr entity)`" if type(value) is Entity else None
    return wrong_type(name, "a list or another sequence", value, hint)


def endless(name: str) -> SceneError:
    message = f"`{name}` would need the end of the root's list of handles, which has none"
    return SceneError("endless", message, hint="take as many as you need: `(list-head gamma n)`")


def improper(name: str, tail: Any) -> SceneError:
    """A chain of pairs does not end in the empty list."""
    if type(tail) is Matrix:
        hint = "a pair `(entity . matrix)` is not a list: wrap it with `(list pair)` or `(union pair)`"
    else:
        hint = "only a chain of pairs that ends in '() is a list"
    return SceneError("type", f"`{name}` wants a proper list, but this one ends in {show(tail, 40)}", hint=hint)


def kind_of(value: Any) -> str:
    """What an index error calls a sequence."""
    if type(value) is str:
        return "string"
    if type(value) is Pair or value is NIL or type(value) is MutableList:
        return "list"
    if type(value) is Vector or (type(value) is MutableArray and value.data.ndim == 1):
        return "vector"
    return "array"


def bad_index(index: Any, length: int, what: str) -> SceneError:
    """``index`` is outside a sequence of ``length``."""
    hint = None
    if length and index == length:
        hint = f"the first index is 0, the last {length - 1}"
    return SceneError("index", f"index {show(index, 20)} is outside the {what} of length {length}", hint=hint)


def empty_sequence(name: str, what: str = "sequence") -> SceneError:
    return SceneError("index", f"`{name}` wants a {what} with at least one item, but this one has length 0")


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
            warn_set_order(rt, members)
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


def note_read(rt: Runtime, *values: Any) -> None:
    """Note that the content of ``values`` is looked at, where it can change."""
    for value in values:
        if isinstance(value, Mutable):
            rt.read(value)


def same_value(rt: Runtime, a: Any, b: Any) -> bool:
    """Equality as sets and tables have it: by structure, numbers by value."""
    note_read(rt, a, b)
    return values.equal(rt, a, b, typed=False)


_BY_VALUE = (int, float, str, Symbol, Keyword)


def identical(a: Any, b: Any) -> bool:
    """``eq?``: the same object, or the same number or text."""
    return a is b or (type(a) is type(b) and type(a) in _BY_VALUE and a == b)


def is_true(value: Any) -> bool:
    """Truth as tests have it: only #f and none are false."""
    return value is not False and value is not None


_TWINS: dict[type, tuple[str, str]] = {
    Pair: ("a list", "a mutable list"),
    type(NIL): ("a list", "a mutable list"),
    Vector: ("a Vector", "a mutable array"),
    Matrix: ("a Matrix", "a mutable array"),
    Array: ("an Array", "a mutable array"),
    str: ("a String", "a mutable list of its characters"),
}


def cannot_change(name: str, value: Any, wanted: str) -> SceneError:
    """``value`` is immutable, or another kind of thing than ``wanted``."""
    kind = type(value)
    if kind in _TWINS:
        what, twin = _TWINS[kind]
        maker = "`(mutable x)`" if kind is str else f"`({twin[2:].replace(' ', '-')} ...)` or `(mutable x)`"
        hint = f"{maker} makes {twin}, which can be changed"
        return SceneError("immutable", f"`{name}` cannot change {what}", hint=hint)
    if kind is Entity or kind is Embedding:
        what = "an Entity" if kind is Entity else "an Embedding"
        return SceneError("immutable", f"`{name}` cannot change {what}", hint="make a new one instead")
    if kind is Record:
        hint = f"its fields are changed by `set-{value.type.name}-...!`"
        return wrong_type(name, wanted, value, hint)
    return wrong_type(name, wanted, value)


def reorder(rt: Runtime, name: str, xs: Any, order: Any) -> None:
    """Replace the items of a mutable list or array by ``order(items)``."""
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
