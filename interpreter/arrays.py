"""Array values: literals and the step from numpy back to the language's own array types."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter import pose
from scenelang.interpreter.show import show
from scenelang.interpreter.types import numbers_of, type_name
from scenelang.interpreter.values import Array, Matrix, MutableArray, Vector


def from_numpy(data: npt.NDArray[Any]) -> Any:
    """A number, Vector, Matrix (a 4x4 whose last row is 0 0 0 1) or Array."""
    if data.ndim == 0:
        return data.item()
    if data.ndim == 1:
        return Vector(data.tolist())
    return (pose.from_array(data) if data.shape == (4, 4) else None) or Array(data.copy())


def array_literal(items: Sequence[Any]) -> Any:
    """The value of ``[item ...]``: numbers, or arrays of one shape. Raises SceneError for anything else."""
    kinds = {type(item) for item in items}
    if kinds <= {float} or kinds == {int}:
        return Vector(items)
    if kinds == {int, float}:
        return Vector([float(item) for item in items])
    rows = [_row(item) for item in items]
    try:
        return from_numpy(np.array(rows))
    except (ValueError, OverflowError):
        raise SceneError("value", "the rows of an array must have one shape") from None


def _row(item: Any) -> npt.NDArray[Any]:
    if isinstance(item, (Array, MutableArray)):
        return item.data
    if type(item) is Matrix:
        return pose.to_array(item)
    numbers = numbers_of(item)
    if numbers is None:
        what = f"an array holds numbers, got {type_name(item)}: {show(item, 60)}"
        raise SceneError("type", what, hint="a list of anything is `(list ...)`")
    return np.array(numbers)
