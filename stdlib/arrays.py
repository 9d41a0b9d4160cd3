"""Builtins for arrays: creation, shape, reductions, elementwise functions and linear algebra."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.loading import np
from scenelang.interpreter.runtime.show import show
from scenelang.interpreter.runtime.types import Registry
from scenelang.interpreter.scene import pose
from scenelang.interpreter.values.values import (
    IDENTITY,
    NIL,
    Matrix,
    MutableArray,
    MutableList,
    Pair,
    Vector,
    make_list,
)
from scenelang.stdlib.numbers import add, bounded, check_operand, multiply
from scenelang.stdlib.operands import (
    INT64,
    Numpy,
    check_shape,
    common_shape,
    empty_sequence,
    from_numpy,
    is_array,
    items,
    largest,
    shape_argument,
    shape_of,
    to_numpy,
    without_overflow,
    wrong_type,
)

if TYPE_CHECKING:
    from scenelang.interpreter.runtime.runtime import Runtime

_NUMBERS = frozenset((int, float))

registry = Registry("arrays")

_BLOCK_ARRAYS = 1024  # that are joined between two checks of the limits
_MAX_DIMENSIONS = 32  # as many as older versions of numpy allow
_MAX_MASK_DEPTH = 8  # levels of lists of booleans
_MAX_EXACT = 1 << 62  # numbers of a range, and products, that are certainly within 64 bits


# --- creation --------------------------------------------------------------------------------------------------


@registry.define("array", "data::ArrayLike", "Array",
                 "Return an array of nested lists of numbers, or of arrays of one shape.",
                 ("(array '((1 2) (3 4)))", "[[1 2] [3 4]]"))  # fmt: skip
def array(rt: Runtime, data: Any) -> Any:
    result = to_numpy(rt, data, "array")
    if result.ndim == 0:
        raise wrong_type("array", "an array or a list", data, "for a vector of numbers, write `(vector x y z)`")
    return from_numpy(result)


@registry.define("vector", "numbers::ArrayLike ...", "Vector",
                 "Return the vector of the arguments; of one list, the vector of its items. The same as brackets.",
                 ("(list (vector 1 2 3) (vector '(1 2.5)))", "([1 2 3] [1.0 2.5])"))  # fmt: skip
def vector(rt: Runtime, *numbers: Any) -> Any:
    if len(numbers) == 1 and not isinstance(numbers[0], (int, float)):
        return array(rt, numbers[0])
    return from_numpy(to_numpy(rt, make_list(numbers), "vector"))


@registry.define("list->vector", "xs::Sequence", "Vector", "Return the vector of a list of numbers.",
                 ("(list->vector '(1 2 3))", "[1 2 3]"))  # fmt: skip
def list_to_vector(rt: Runtime, xs: Any) -> Any:
    return array(rt, xs)


def _constant_array(rt: Runtime, name: str, sides: tuple[Any, ...], value: float) -> Any:
    """Return an array of one number; the shape is given as one argument or as a count for each axis."""
    shape: Any = sides[0] if len(sides) == 1 else make_list(sides)
    return from_numpy(np.full(shape_argument(rt, shape, name), value))


@registry.define("zeros", "shape::ArrayLike more::Integer ...", "Array",
                 "Return an array of zeros, as Floats. The shape is a count, several counts, or a list of counts.",
                 ("(list (zeros 2) (zeros '(1 2)))", "([0.0 0.0] [[0.0 0.0]])"))  # fmt: skip
def zeros(rt: Runtime, *shape: Any) -> Any:
    return _constant_array(rt, "zeros", shape, 0.0)


@registry.define("ones", "shape::ArrayLike more::Integer ...", "Array", "Return an array of ones, as Floats.",
                 ("(ones 3)", "[1.0 1.0 1.0]"))  # fmt: skip
def ones(rt: Runtime, *shape: Any) -> Any:
    return _constant_array(rt, "ones", shape, 1.0)


@registry.define("full", "shape::ArrayLike value::Number", "Array", "Return an array filled with one number.",
                 ("(full '(2 2) 7)", "[[7 7] [7 7]]"))  # fmt: skip
def full(rt: Runtime, shape: Any, value: Any) -> Any:
    return from_numpy(np.full(shape_argument(rt, shape, "full"), to_numpy(rt, value)))


@registry.define("eye", "n::Integer [columns::Integer]", "Array", "Return the identity matrix with `n` rows.",
                 ("(eye 2)", "[[1.0 0.0] [0.0 1.0]]"))  # fmt: skip
def eye(rt: Runtime, n: int, columns: int | None = None) -> Any:
    height, width = check_shape(rt, (n, n if columns is None else columns), "eye")
    return from_numpy(np.eye(height, width))


@registry.define("linspace", "start::Number end::Number [count::Integer] [:endpoint::Boolean]", "Vector",
                 "Return `count` (default 50) evenly spaced numbers from `start` to `end`; `:endpoint #f` excludes "
                 "the end.",
                 ("(list (linspace 0 1 3) (linspace 0 1 2 :endpoint #f))", "([0.0 0.5 1.0] [0.0 0.5])"))  # fmt: skip
def linspace(rt: Runtime, start: Any, end: Any, count: int = 50, *, endpoint: bool = True) -> Any:
    check_shape(rt, (count,), "linspace")
    with np.errstate(all="ignore"):
        return from_numpy(np.linspace(float(start), float(end), count, endpoint=endpoint))


@registry.define("arange", "start::Number [end::Number] [step::Number]", "Vector",
                 "Return the numbers from `start` up to but excluding `end`, in steps of `step`; `(arange n)` starts "
                 "at 0. For a fractional step use `linspace`, which returns a given count.",
                 ("(list (arange 3) (arange 0 1 .25))", "([0 1 2] [0.0 0.25 0.5 0.75])"))  # fmt: skip
def arange(rt: Runtime, start: Any, end: Any = None, step: Any = 1) -> Any:
    if end is None:
        start, end = 0, start
    if step == 0:
        raise SceneError("value", "`arange` expects a step that is not 0")
    extent = (end - start) / step
    if not math.isfinite(extent):
        raise SceneError("value", f"`arange` expects finite bounds, got {show(start)} and {show(end)}")
    count = max(0, math.ceil(extent))
    check_shape(rt, (count,), "arange")
    if max(abs(start), abs(end), abs(step)) >= _MAX_EXACT:  # numpy would overflow silently
        start, end, step = float(start), float(end), float(step)
    try:
        return from_numpy(np.arange(start, end, step))
    except (ValueError, OverflowError):
        message = f"`arange` does not support the bounds {show(start)} and {show(end)} with a step of {show(step)}"
        raise SceneError("value", message) from None


# --- shape -----------------------------------------------------------------------------------------------------


@registry.define("array-shape", "array::Array", "List", "Return the number of items along every axis.",
                 ("(array-shape [[1 2 3] [4 5 6]])", "(2 3)"))  # fmt: skip
def array_shape(rt: Runtime, array: Any) -> Any:
    return make_list(shape_of(array))


@registry.define("transpose", "array::ArrayLike", "Array",
                 "Return the array with its axes reversed: rows become columns.",
                 ("(transpose [[1 2 3] [4 5 6]])", "[[1 4] [2 5] [3 6]]"))  # fmt: skip
def transpose(rt: Runtime, array: Any) -> Any:
    data = to_numpy(rt, array, "transpose")
    rt.charge(data.size >> 5)
    return from_numpy(data.T)


@registry.define("reshape", "array::ArrayLike shape::ArrayLike", "Array",
                 "Return the same numbers, in row-major order, in another shape; one side may be -1, to be inferred.",
                 ("(reshape [1 2 3 4 5 6] '(2 -1))", "[[1 2 3] [4 5 6]]"))  # fmt: skip
def reshape(rt: Runtime, array: Any, shape: Any) -> Any:
    data = to_numpy(rt, array, "reshape")
    rt.charge(data.size >> 5)
    given = [float(shape)] if type(shape) is int else to_numpy(rt, shape, "reshape").ravel().tolist()
    if not all(float(side).is_integer() for side in given):
        raise SceneError("value", f"`reshape` expects whole numbers for the shape, got {show(shape, 60)}")
    sides = list(map(int, given))
    if len(sides) > _MAX_DIMENSIONS:
        raise SceneError("value", f"`reshape` supports at most {_MAX_DIMENSIONS} dimensions, got {len(sides)}")
    known_size = math.prod(side for side in sides if side != -1)  # a single -1 is inferred, as by numpy
    if sides.count(-1) == 1 and known_size and data.size % known_size == 0:
        sides[sides.index(-1)] = data.size // known_size
    check_shape(rt, [max(side, 0) for side in sides], "reshape")
    if math.prod(sides) != data.size or min(sides, default=0) < 0:
        raise SceneError("value", f"cannot reshape an array of {data.size} numbers to the shape {show(shape, 60)}")
    return from_numpy(data.reshape(sides))


def _operands(rt: Runtime, name: str, arrays: tuple[Any, ...]) -> list[Numpy]:
    """Return the arrays given as arguments or in one list, as numpy arrays."""
    members = items(rt, arrays[0], name) if len(arrays) == 1 else list(arrays)
    if not members:
        raise empty_sequence(name)
    operands = []
    size = 0
    for member in members:
        rt.charge(1)
        operands.append(to_numpy(rt, member, name))
        size += operands[-1].size
        rt.meter.check_growth(size, "an array")
    rt.meter.check_size(size, "an array")
    return operands


@registry.define("stack-arrays", "arrays::ArrayLike ... [:axis::Integer]", "Array",
                 "Join arrays of one shape along a new axis (default: the first). One list of arrays is also accepted.",
                 ("(list (stack-arrays [1 2] [3 4]) (stack-arrays (list [1 2] [3 4]) :axis 1))",
                  "([[1 2] [3 4]] [[1 3] [2 4]])"))  # fmt: skip
def stack(rt: Runtime, *arrays: Any, axis: int = 0) -> Any:
    # `stack` itself is a combinator, which places objects on top of each other; given a list of arrays, it calls this.
    return _join(rt, "stack-arrays", np.stack, _operands(rt, "stack-arrays", arrays), axis)


@registry.define("concatenate", "arrays::ArrayLike ... [:axis::Integer]", "Array",
                 "Join arrays along an existing axis (default: the first). One list of arrays is also accepted.",
                 ("(concatenate [1 2] [3])", "[1 2 3]"))  # fmt: skip
def concatenate(rt: Runtime, *arrays: Any, axis: int = 0) -> Any:
    return _join(rt, "concatenate", np.concatenate, _operands(rt, "concatenate", arrays), axis)


def _join(rt: Runtime, name: str, join: Callable[..., Any], arrays: list[Numpy], axis: int) -> Any:
    """Join arrays block by block, then the blocks, so that the limits are checked in between."""
    joined = []
    try:
        for start in range(0, len(arrays), _BLOCK_ARRAYS):
            rt.charge(_BLOCK_ARRAYS >> 2)
            joined.append(join(arrays[start : start + _BLOCK_ARRAYS], axis=axis))
        return from_numpy(joined[0] if len(joined) == 1 else np.concatenate(joined, axis=axis))
    except ValueError:
        shapes = ", ".join(show(make_list(array.shape)) for array in arrays[:4])
        raise SceneError("value", f"`{name}` cannot join arrays of the shapes {shapes} along axis {axis}") from None


@registry.define("expand-dims", "array::ArrayLike axis::Integer ...", "Array",
                 "Return the array with sides of length 1 inserted at the places of the result that `axis` names.",
                 ("(array-shape (expand-dims [1 2 3] 1))", "(3 1)"))  # fmt: skip
def expand_dims(rt: Runtime, array: Any, *axes: int) -> Any:
    data = to_numpy(rt, array, "expand-dims")
    sides = data.ndim + len(axes)
    if sides > _MAX_DIMENSIONS:
        raise SceneError("value", f"`expand-dims` supports at most {_MAX_DIMENSIONS} dimensions, got {sides}")
    if any(not -sides <= axis < sides for axis in axes) or len({axis % sides for axis in axes}) < len(axes):
        raise SceneError("value", f"`expand-dims` expects different axes of {sides}, got {show(make_list(axes), 60)}")
    rt.charge(data.size >> 5)
    return from_numpy(np.expand_dims(data, axes))


# --- reductions ------------------------------------------------------------------------------------------------

_CONTAINERS = (Pair, type(NIL), MutableList)


def check_axis(name: str, data: Numpy, axis: int | None) -> int | None:
    """Return ``axis``; one outside the dimensions of ``data`` is an error."""
    if axis is not None and not -data.ndim <= axis < data.ndim:
        raise SceneError("index", f"`{name}` expects an axis from {-data.ndim} to {data.ndim - 1}, got {axis}")
    return axis


def _reduction(rt: Runtime, name: str, value: Any, axis: int | None, reduce: Callable[..., Any]) -> Any:
    """Return a numpy reduction over all items or along one axis."""
    data = to_numpy(rt, value, name)
    check_axis(name, data, axis)
    rt.charge(data.size >> 5)
    if data.size == 0 and name != "sum" and name != "product":
        raise empty_sequence(name)
    if name == "sum" or name == "cumsum":
        data = without_overflow(data, max(1, data.size))
    with np.errstate(all="ignore"):
        return from_numpy(reduce(data, axis=axis))


def _checked_product(data: Numpy, axis: int | None) -> Any:
    """Return ``np.prod``, in floats if integers would overflow."""
    floats = data.astype(float)
    if data.dtype.kind == "i" and np.max(np.prod(np.maximum(np.abs(floats), 1.0), axis=axis), initial=0.0) < _MAX_EXACT:
        return np.prod(data, axis=axis)
    return np.prod(floats, axis=axis)


def _fold(rt: Runtime, xs: Any, name: str, operation: Callable[..., Any], start: int) -> Any:
    """Return the sum or product of a list from the left, as Python does; its items may be arrays."""
    members = items(rt, xs, name)
    result: Any = start
    for position, item in enumerate(members):
        rt.charge(1)
        if position == 0:
            check_operand(name, item)
            result = item
        else:
            result = operation(rt, result, item)
    return result


@registry.define("sum", "xs::Sequence [:axis::Integer]", "Any",
                 "Return the sum of the items of a sequence; of an array, of all its numbers or along `:axis`.",
                 ("(list (sum '(1 2 3)) (sum [[1 2] [3 4]] :axis 0))", "(6 [4 6])"))  # fmt: skip
def sum_(rt: Runtime, xs: Any, *, axis: int | None = None) -> Any:
    if is_array(xs) or axis is not None:
        return _reduction(rt, "sum", xs, axis, np.sum)
    return _fold(rt, xs, "sum", add, 0)


@registry.define("product", "xs::Sequence [:axis::Integer]", "Any",
                 "Return the product of the items of a sequence; of an array, of all its numbers or along `:axis`.",
                 ("(product '(2 3 4))", "24"))  # fmt: skip
def product(rt: Runtime, xs: Any, *, axis: int | None = None) -> Any:
    if axis is not None or (is_array(xs) and type(xs) is not Vector):
        return _reduction(rt, "product", xs, axis, _checked_product)
    return bounded(_fold(rt, xs, "product", multiply, 1))


@registry.define("mean", "xs::ArrayLike [:axis::Integer]", "Any",
                 "Return the mean of the numbers of a list or an array, or along `:axis`.",
                 ("(list (mean '(1 2 6)) (mean [[1 2] [3 4]] :axis 1))", "(3.0 [1.5 3.5])"))  # fmt: skip
def mean(rt: Runtime, xs: Any, *, axis: int | None = None) -> Any:
    return _reduction(rt, "mean", xs, axis, np.mean)


def _extreme(rt: Runtime, name: str, values: tuple[Any, ...], axis: int | None, binary: str, reduction: str) -> Any:
    """Return the minimum or maximum of one sequence, of several numbers, or elementwise of arrays.

    ``binary`` and ``reduction`` are the names of numpy's functions.
    """
    if axis is None and len(values) > 1 and all(map(_NUMBERS.__contains__, map(type, values))):
        rt.charge(len(values) >> 3)
        return min(values) if name == "min" else max(values)
    if len(values) == 1:
        argument = values[0]
        if is_array(argument) or axis is not None:
            return _reduction(rt, name, argument, axis, getattr(np, reduction))
        if type(argument) is int or type(argument) is float:
            return argument
        values = tuple(items(rt, argument, name, ordered=False))
        rt.charge(len(values) >> 4)
        if not values:
            raise empty_sequence(name)
    for value in values:
        if type(value) is str:
            raise wrong_type(name, "numbers", value, f"for strings and lists, use `{name}-of`")
        check_operand(name, value)
    if any(is_array(value) for value in values):
        arrays = [to_numpy(rt, value, name) for value in values]
        common_shape(rt, name, *arrays)
        result = arrays[0]
        for other in arrays[1:]:
            rt.charge(1 + (other.size >> 6))
            result = getattr(np, binary)(result, other)
        return from_numpy(result)
    rt.charge(len(values) >> 3)
    return min(values) if name == "min" else max(values)


@registry.define("min", "values::Any more::Any ... [:axis::Integer]", "Any",
                 "Return the smallest of several numbers, or of the numbers of one sequence; of an array also along "
                 "`:axis`, of several arrays elementwise. `min-of` takes any values that have an order.",
                 ("(list (min 3 1 2) (min '(5 4)) (min [[1 2] [3 0]] :axis 0))", "(1 4 [1 0])"))  # fmt: skip
def min_(rt: Runtime, *values: Any, axis: int | None = None) -> Any:
    return _extreme(rt, "min", values, axis, "minimum", "min")


@registry.define("max", "values::Any more::Any ... [:axis::Integer]", "Any",
                 "Return the largest of several numbers, or of the numbers of one sequence; of an array also along "
                 "`:axis`, of several arrays elementwise. `max-of` takes any values that have an order.",
                 ("(list (max 3 1 2) (max '(5 4)) (max [1 5] [3 2]))", "(3 5 [3 5])"))  # fmt: skip
def max_(rt: Runtime, *values: Any, axis: int | None = None) -> Any:
    return _extreme(rt, "max", values, axis, "maximum", "max")


@registry.define("argmin", "xs::ArrayLike [:axis::Integer]", "Any",
                 "Return the index of the smallest number, counted row by row, or the indices along `:axis`.",
                 ("(argmin '(3 1 2))", "1"))  # fmt: skip
def argmin(rt: Runtime, xs: Any, *, axis: int | None = None) -> Any:
    return _reduction(rt, "argmin", xs, axis, np.argmin)


@registry.define("argmax", "xs::ArrayLike [:axis::Integer]", "Any",
                 "Return the index of the largest number, counted row by row, or the indices along `:axis`.",
                 ("(argmax [3 1 2])", "0"))  # fmt: skip
def argmax(rt: Runtime, xs: Any, *, axis: int | None = None) -> Any:
    return _reduction(rt, "argmax", xs, axis, np.argmax)


@registry.define("cumsum", "xs::ArrayLike [:axis::Integer]", "Array",
                 "Return the cumulative sums, of all numbers or along `:axis`.",
                 ("(cumsum '(1 2 3))", "[1 3 6]"))  # fmt: skip
def cumsum(rt: Runtime, xs: Any, *, axis: int | None = None) -> Any:
    data = to_numpy(rt, xs, "cumsum")
    return from_numpy(data) if data.size == 0 else _reduction(rt, "cumsum", xs, axis, np.cumsum)


# --- elementwise -----------------------------------------------------------------------------------------------


@registry.define("clip", "x::ArrayLike low::ArrayLike high::ArrayLike", "Any",
                 "Limit the numbers of an array to the range from `low` to `high`.",
                 ("(clip [-1 5 12] 0 10)", "[0 5 10]"))  # fmt: skip
def clip(rt: Runtime, x: Any, low: Any, high: Any) -> Any:
    arrays = [to_numpy(rt, value, "clip") for value in (x, low, high)]
    common_shape(rt, "clip", *arrays)
    return from_numpy(np.minimum(np.maximum(arrays[0], arrays[1]), arrays[2]))


@registry.define("array-map", "f::Function array::ArrayLike more::ArrayLike ...", "Array",
                 "Return the array of the results of `f` for every number of an array, or for the numbers of several "
                 "arrays of one shape (single numbers are broadcast); #t is 1 and #f is 0, so that a predicate makes "
                 "a mask for `where`.",
                 ("(list (array-map square [1 2 3]) (array-map > [1 5 3] 2))", "([1 4 9] [0 1 1])"))  # fmt: skip
def array_map(rt: Runtime, f: Any, array: Any, *more: Any) -> Any:
    arrays = [to_numpy(rt, value, "array-map") for value in (array, *more)]
    common_shape(rt, "array-map", *arrays)
    broadcast = np.broadcast_arrays(*arrays)
    rt.charge(broadcast[0].size >> 5)
    results = [_number(rt.apply(f, list(numbers))) for numbers in zip(*(a.ravel().tolist() for a in broadcast))]
    return from_numpy(np.array(results).reshape(broadcast[0].shape))


def _number(value: Any) -> Any:
    """Return a result of the function of ``array-map`` as a number."""
    if type(value) is bool:
        return int(value)
    if type(value) is int or type(value) is float:
        return value
    raise wrong_type("array-map", "a function that returns a number or a Boolean", value)


@registry.define("interp", "x::ArrayLike xs::ArrayLike ys::ArrayLike", "Any",
                 "Interpolate linearly at `x` between the points (xs, ys); `xs` must not decrease, and at equal ones "
                 "the last counts. Outside the range the first or last value is returned.",
                 ("(interp 1.5 '(1 2 3) '(10 20 40))", "15.0"))  # fmt: skip
def interp(rt: Runtime, x: Any, xs: Any, ys: Any) -> Any:
    points, positions, values = (to_numpy(rt, value, "interp") for value in (x, xs, ys))
    if positions.ndim != 1 or positions.shape != values.shape or not positions.size:
        raise SceneError("value", "`interp` expects equal numbers of xs and ys, at least one of each")
    if not (np.diff(positions) >= 0).all():
        raise SceneError("value", "`interp` expects xs in ascending order")
    return from_numpy(np.interp(points, positions, values))


def _mask(rt: Runtime, condition: Any, depth: int = 0) -> Any:
    """Return nested lists of booleans as nested Python lists."""
    if type(condition) is bool or condition is None:
        return bool(condition)
    if isinstance(condition, _CONTAINERS) and depth < _MAX_MASK_DEPTH:
        rt.charge(1)
        return [_mask(rt, item, depth + 1) for item in items(rt, condition, "where")]
    data = to_numpy(rt, condition, "where")
    rt.charge(data.size >> 5)
    return (data != 0).tolist()


@registry.define("where", "condition::Any a::Any b::Any", "Any",
                 "Return the array with the numbers of `a` where the condition is true, and of `b` elsewhere. The "
                 "condition is a list of booleans, or an array in which 0 is false.",
                 ("(let ((v [-1 5 -3])) (where (map positive? v) v 0))", "[0 5 0]"))  # fmt: skip
def where(rt: Runtime, condition: Any, a: Any, b: Any) -> Any:
    try:
        mask = np.array(_mask(rt, condition), dtype=bool)
    except ValueError:
        raise SceneError("value", "`where` expects a condition with rows of equal length") from None
    left, right = to_numpy(rt, a, "where"), to_numpy(rt, b, "where")
    common_shape(rt, "where", mask, left, right)
    return from_numpy(np.where(mask, left, right))


# --- coordinates -----------------------------------------------------------------------------------------------


def _coordinate(rt: Runtime, name: str, point: Any, index: int) -> Any:
    """Return one number of a point; a matrix is an error, because its first row is not a position."""
    if type(point) is not Vector:
        if type(point) is Matrix or (type(point) is MutableArray and point.data.ndim != 1):
            raise wrong_type(name, "a vector", point, "for the position of a pose, write `(@ pose [0 0 0])`")
        point = items(rt, point, name)
    if len(point) <= index:
        raise SceneError("index", f"`{name}` expects a vector of length {index + 1} or more, got length {len(point)}")
    return point[index]


@registry.define(
    "x-of", "point::Sequence", "Number", "Return the first coordinate, to the right.", ("(x-of [5 6 7])", "5")
)
def x_of(rt: Runtime, point: Any) -> Any:
    return _coordinate(rt, "x-of", point, 0)


@registry.define("y-of", "point::Sequence", "Number", "Return the second coordinate, upwards.", ("(y-of [5 6 7])", "6"))
def y_of(rt: Runtime, point: Any) -> Any:
    return _coordinate(rt, "y-of", point, 1)


@registry.define(
    "z-of", "point::Sequence", "Number", "Return the third coordinate, towards the viewer.", ("(z-of [5 6 7])", "7")
)
def z_of(rt: Runtime, point: Any) -> Any:
    return _coordinate(rt, "z-of", point, 2)


# --- linear algebra --------------------------------------------------------------------------------------------


def _shape(data: Numpy) -> str:
    """Return the shape of an array for a message."""
    return show(make_list(data.shape))


def matrix_product(rt: Runtime, a: Any, b: Any, name: str = "@") -> Any:
    """Return the product of two matrices or vectors; a pose transforms a point.

    Poses and points have a fast path, since they are most of what programs multiply.
    """
    if type(a) is Matrix:
        if type(b) is Matrix:
            return pose.compose(a, b)
        if type(b) is Vector and len(b) == 3:
            return Vector(map(float, pose.apply(a, b)))
    left, right = to_numpy(rt, a, name), to_numpy(rt, b, name)
    if left.shape == (4, 4) and right.shape == (3,):
        matrix = from_numpy(left)
        if type(matrix) is Matrix:
            return matrix_product(rt, matrix, Vector(right.tolist()))
    return _numpy_product(rt, name, np.matmul, left, right)


def _numpy_product(rt: Runtime, name: str, multiply: Callable[..., Any], left: Numpy, right: Numpy) -> Any:
    """Return a matrix product by numpy; its cost is charged first, and integers that might overflow become floats."""
    if not left.ndim or not right.ndim:
        hint = "to multiply an array by a number, write `(* x array)`"
        raise SceneError("type", f"`{name}` expects arrays, got a number", hint=hint)
    inner = left.shape[-1]
    if inner != right.shape[-2 if right.ndim > 1 else 0]:
        message = f"`{name}` cannot multiply arrays of the shapes {_shape(left)} and {_shape(right)}"
        hint = "the number of columns of the first must be the number of rows of the second"
        raise SceneError("value", message, hint=hint)
    size = max(1, left.size // max(1, inner)) * max(1, right.size // max(1, inner))
    rt.meter.check_size(size, "an array")
    rt.charge(size * inner >> (6 if left.dtype.kind == right.dtype.kind == "f" else 4))
    if left.dtype.kind == right.dtype.kind == "i" and largest(left) * largest(right) * max(1, inner) >= INT64:
        left = left.astype(float)
    try:
        with np.errstate(all="ignore"):
            return from_numpy(multiply(left, right))
    except ValueError:
        message = f"`{name}` cannot multiply arrays of the shapes {_shape(left)} and {_shape(right)}"
        raise SceneError("value", message) from None


@registry.define("@", "a::ArrayLike more::ArrayLike ...", "Any",
                 "Return the matrix product of any number of matrices: the pose `(@ A B)` applies B first. A pose "
                 "transforms a point: `(@ pose [x y z])`.",
                 ("(list (@ (translate [1 0 0]) [5 6 7]) (@ [[1 2] [3 4]] [1 1]))", "([6.0 6.0 7.0] [3 7])"),
                 "matmul")  # fmt: skip
def matmul(rt: Runtime, a: Any, *more: Any) -> Any:
    if not more and not is_array(a):
        return from_numpy(to_numpy(rt, a, "@"))
    for other in more:
        a = matrix_product(rt, a, other)
    return a


@registry.define("dot", "a::ArrayLike b::ArrayLike", "Any",
                 "Return the dot product of two vectors, or the product of two matrices.",
                 ("(dot [1 2 3] [4 5 6])", "32"))  # fmt: skip
def dot(rt: Runtime, a: Any, b: Any) -> Any:
    if type(a) is Vector and type(b) is Vector and len(a) == len(b) == 3:
        return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    return _numpy_product(rt, "dot", np.dot, to_numpy(rt, a, "dot"), to_numpy(rt, b, "dot"))


@registry.define("cross", "a::ArrayLike b::ArrayLike", "Array",
                 "Return the cross product, perpendicular to both vectors by the right-hand rule; of arrays that of "
                 "each row.",
                 ("(cross [1 0 0] [0 1 0])", "[0 0 1]"))  # fmt: skip
def cross(rt: Runtime, a: Any, b: Any) -> Any:
    if type(a) is Vector and type(b) is Vector:
        if len(a) != 3 or len(b) != 3:
            raise SceneError("value", f"`cross` expects two vectors of length 3, got lengths {len(a)} and {len(b)}")
        (ax, ay, az), (bx, by, bz) = a, b
        if type(ax) is type(bx) is float:  # all numbers of a vector have one type
            return Vector((ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx))
        return from_numpy(to_numpy(rt, Vector((ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx))))
    left, right = to_numpy(rt, a, "cross"), to_numpy(rt, b, "cross")
    for data, name in ((left, "a"), (right, "b")):
        if data.ndim == 0 or data.shape[-1] != 3:
            raise SceneError("type", f"`cross` expects vectors of length 3 for `{name}`, got the shape {_shape(data)}")
    rt.charge((left.size + right.size) >> 4)
    try:
        return from_numpy(np.cross(left, right))
    except ValueError:
        shapes = f"{_shape(left)}, {_shape(right)}"
        raise SceneError("value", f"`cross` cannot combine arrays of the shapes {shapes}") from None


def _flat(rt: Runtime, name: str, value: Any) -> list[float]:
    """Return all numbers of a vector or array."""
    flat: list[float] = list(value) if type(value) is Vector else to_numpy(rt, value, name).ravel().tolist()
    if len(flat) > 16:
        rt.charge(len(flat) >> 4)
    return flat


def _length(numbers: Sequence[float]) -> float:
    """Return the Euclidean norm; ``hypot`` is exact where squares overflow or vanish, but slower."""
    total = 0.0
    for number in numbers:
        total += float(number) * float(number)
    # Squares that overflow or underflow need `hypot`, which scales the numbers.
    return math.sqrt(total) if 1e-300 < total < math.inf else math.hypot(*numbers)


@registry.define("norm", "v::ArrayLike", "Float",
                 "Return the length of a vector: the square root of the sum of squares.",
                 ("(norm [3 4])", "5.0"))  # fmt: skip
def norm(rt: Runtime, v: Any) -> float:
    if type(v) is Vector and len(v) == 3:
        return _length(v)
    return _length(_flat(rt, "norm", v))


@registry.define("normalize", "v::Vector", "Vector", "Return the vector of length 1 in the same direction.",
                 ("(normalize [0 3 4])", "[0.0 0.6 0.8]"))  # fmt: skip
def normalize(rt: Runtime, v: Vector) -> Any:
    length = norm(rt, v)
    if length == 0.0:
        raise SceneError("domain", "`normalize` expects a vector of nonzero length")
    rt.charge(len(v) >> 4)
    return Vector([x / length for x in v])


@registry.define("distance", "a::ArrayLike b::ArrayLike", "Float", "Return the distance between two points.",
                 ("(distance [1 1 0] [4 5 0])", "5.0"))  # fmt: skip
def distance(rt: Runtime, a: Any, b: Any) -> float:
    left, right = _flat(rt, "distance", a), _flat(rt, "distance", b)
    if len(left) != len(right):
        message = f"`distance` expects points with equal numbers of coordinates, got {len(left)} and {len(right)}"
        raise SceneError("value", message)
    return _length([x - y for x, y in zip(left, right)])


# --- square matrices -------------------------------------------------------------------------------------------


def _square(rt: Runtime, name: str, value: Any) -> Numpy:
    """Return a square matrix of floats, after charging for a cubic algorithm on it."""
    data = to_numpy(rt, value, name)
    if data.ndim != 2 or data.shape[0] != data.shape[1]:
        raise wrong_type(name, "a square matrix", value)
    rt.charge(data.shape[0] ** 3 >> 6)
    return data.astype(float)


def _singular(name: str) -> SceneError:
    """Return the error for a matrix without an inverse."""
    return SceneError("domain", f"`{name}` expects an invertible matrix, got a singular one")


@registry.define("inverse", "matrix::ArrayLike", "Array",
                 "Return the inverse of a square matrix; of a pose, the inverse pose.",
                 ("(@ (inverse (translate [1 2 3])) [1 2 3])", "[0.0 0.0 0.0]"))  # fmt: skip
def inverse(rt: Runtime, matrix: Any) -> Any:
    data = _square(rt, "inverse", matrix)
    try:
        result = np.linalg.inv(data)
    except np.linalg.LinAlgError:
        raise _singular("inverse") from None
    if data.shape == (4, 4) and data[3].tolist() == [0, 0, 0, 1]:
        result[3] = (0, 0, 0, 1)  # exactly, so that the inverse of a pose is a pose
    return from_numpy(result)


@registry.define("determinant", "matrix::ArrayLike", "Float",
                 "Return the determinant: the factor by which a matrix scales volumes, negative for a reflection.",
                 ("(determinant [[2 0] [0 3]])", "6.0"))  # fmt: skip
def determinant(rt: Runtime, matrix: Any) -> Any:
    return float(np.linalg.det(_square(rt, "determinant", matrix)))


@registry.define("solve", "matrix::ArrayLike right::ArrayLike", "Array",
                 "Return the vector x with `(@ matrix x)` equal to `right`.",
                 ("(solve [[2 0] [0 4]] [2 2])", "[1.0 0.5]"))  # fmt: skip
def solve(rt: Runtime, matrix: Any, right: Any) -> Any:
    coefficients, right_side = _square(rt, "solve", matrix), to_numpy(rt, right, "solve")
    rows = coefficients.shape[0]
    if not right_side.ndim or right_side.shape[0] != rows:
        message = f"`solve` expects {rows} numbers on the right, got the shape {_shape(right_side)}"
        raise SceneError("value", message)
    try:
        return from_numpy(np.linalg.solve(coefficients, right_side))
    except np.linalg.LinAlgError:
        raise _singular("solve") from None


@registry.define("identity-pose", "", "Matrix", "Return the identity pose.", ("(equal? (identity-pose) (eye 4))", "#t"))
def identity_pose(rt: Runtime) -> Any:
    return IDENTITY
