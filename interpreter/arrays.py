"""Array values: literals, and the way between the language's array types and numpy's."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter import pose
from scenelang.interpreter.show import show
from scenelang.interpreter.types import Reader, numbers_of, type_name
from scenelang.interpreter.values import Array, Matrix, MutableArray, MutableList, Pair, Vector

if TYPE_CHECKING:
    import numpy.typing as npt


def from_numpy(data: Any) -> Any:
    """The value that a numpy array is: a number, a Vector, a Matrix when it is a pose, else an Array."""
    data = np.asarray(data)
    if data.dtype.kind == "f":
        data = data.astype(np.float64, copy=False)
    elif data.dtype.kind in "biu":
        data = data.astype(np.int64, copy=False)
    if data.ndim == 0:
        return data.item()
    if data.ndim == 1:
        return Vector(data.tolist())
    if data.shape == (4, 4):
        matrix = pose.from_array(data)
        if matrix is not None:
            return matrix
    return Array(data.copy() if data.base is not None else data)


def numbers_to_numpy(numbers: Any) -> npt.NDArray[Any]:
    """Python numbers, nested or not, as int64 when all are integers that fit, else float64."""
    data = np.array(numbers)
    if data.dtype.kind in "iu" and data.dtype != np.uint64:
        return data.astype(np.int64, copy=False)
    if data.dtype == np.float64:
        return data
    try:
        return np.array(numbers, dtype=np.float64)
    except OverflowError:
        raise SceneError("domain", "an integer is too large to stand in an array") from None


def array_literal(items: Sequence[Any], reader: Reader | None = None) -> Any:
    """The value of ``[item ...]``: numbers, or arrays of one shape. Raises SceneError for anything else. ``reader`` is
    told of the mutable things among the items; a constant has none."""
    kinds = {type(item) for item in items}
    if kinds <= {float} or kinds == {int}:
        return Vector(items)
    for item in items:
        if type(item) not in (int, float) and not isinstance(
            item, (Vector, Matrix, Array, MutableArray, Pair, MutableList)
        ):
            what = f"an array holds numbers, got {type_name(item)}: {show(item, 60)}"
            raise SceneError("type", what, hint="a list of anything is `(list ...)`")
    try:
        if kinds == {int, float}:
            return Vector([float(item) for item in items])
        return from_numpy(numbers_to_numpy([_row(item, reader) for item in items]))
    except OverflowError:
        raise SceneError("domain", "an integer is too large to stand in an array of floats") from None
    except ValueError:
        raise SceneError("value", "the rows of an array must have one shape") from None


def _row(item: Any, reader: Reader | None) -> Any:
    if isinstance(item, (Array, MutableArray)):
        if reader is not None:
            reader.charge(item.data.size >> 5)
            if isinstance(item, MutableArray):
                reader.read(item)
        return item.data.tolist()
    if type(item) is Matrix:
        return pose.to_array(item).tolist()
    if type(item) in (int, float):
        return item
    numbers = numbers_of(item, reader)
    if numbers is None:
        raise SceneError("type", f"a row of an array holds numbers, got {show(item, 60)}")
    return numbers
