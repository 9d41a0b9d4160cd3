"""Between the language's arrays and numpy's: one way in, one way out."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.runtime.runtime import Runtime
from scenelang.interpreter.runtime.show import from_numpy as from_numpy
from scenelang.interpreter.runtime.show import numbers_to_numpy as numbers_to_numpy
from scenelang.interpreter.runtime.show import show
from scenelang.interpreter.runtime.types import type_name, vector_of
from scenelang.interpreter.runtime.values import (
    NIL,
    Array,
    Matrix,
    MutableArray,
    MutableList,
    Pair,
    Vector,
    list_items,
    make_list,
)
from scenelang.interpreter.scene import pose

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
