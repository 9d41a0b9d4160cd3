from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from scenelang.grammar.diagnostics import LimitError
from scenelang.interpreter.scene import pose
from scenelang.interpreter.values.values import IDENTITY, NIL, Array, Keyword, Matrix, Pair, Vector
from scenelang.stdlib.operands import from_numpy, to_numpy

from .conftest import Caller, new_runtime, scheme

CALL = Caller(new_runtime())
AXIS, ENDPOINT, ALL = Keyword("axis"), Keyword("endpoint"), Keyword("all")
GRID = Array(np.arange(24).reshape(2, 3, 4))


def array(value: Any) -> Any:
    return to_numpy(CALL.rt, value)


def test_normal_forms() -> None:
    assert from_numpy(np.float32(2)) == 2.0
    assert type(from_numpy(np.int32(2))) is int
    assert from_numpy(np.array([True, False])) == (1, 0)
    assert type(from_numpy(np.array([1, 2]))[0]) is int
    assert from_numpy(np.eye(4, dtype=int)) == IDENTITY
    assert type(from_numpy(np.ones((4, 4)))) is Array


def test_making(call: Caller) -> None:
    assert call("vector", 1, 2.5) == (1.0, 2.5)
    assert call("vector") == ()
    assert call("vector", [1, 2]) == (1, 2)
    assert call("array", [[1, 2], [3, 4]]).data.tolist() == [[1, 2], [3, 4]]
    assert type(call("array", [[1, 0, 0, 5], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])) is Matrix
    assert call("array", [Vector((1, 2)), Vector((3.0, 4.0))]).data.dtype == np.float64
    assert call("zeros", 2, 3).data.shape == (2, 3)
    assert call("zeros", [2, 3]).data.shape == (2, 3)
    assert call("zeros", Vector((2, 3))).data.shape == (2, 3)
    assert call("full", 2, 7) == (7, 7)
    assert type(call("eye", 4)) is Matrix
    assert "rows of equal length" in call.refuses("value", "array", [[1, 2], [3]])
    call.refuses("type", "array", ["a"])
    call.refuses("type", "vector", "abc")
    call.refuses("type", "array", 5)
    call.refuses("value", "zeros", -1)
    call.refuses("type", "zeros", 1.5)
    call.refuses("domain", "array", [10**400])


@pytest.mark.parametrize(
    ("name", "arguments"),
    [
        ("zeros", (10**12,)), ("ones", (scheme([10**6, 10**6]),)), ("full", (10**9, 1)), ("eye", (10**5,)),
        ("linspace", (0, 1, 10**9)), ("arange", (0, 1, 1e-12)), ("repeat", (Vector((1, 2)), 10**9)),
        ("zeros", (0, 10**30)),
    ],
)  # fmt: skip
def test_sizes_are_bounded(call: Caller, name: str, arguments: Any) -> None:
    with pytest.raises(LimitError):
        call(name, *arguments)


def test_products_are_bounded(call: Caller) -> None:
    column, row = call("reshape", call("zeros", 10**5), [-1, 1]), call("reshape", call("zeros", 10**5), [1, -1])
    for name in ("@", "*", "dot", "max"):
        with pytest.raises(LimitError):
            call(name, column, row)


@given(st.floats(-10, 10), st.floats(-10, 10), st.integers(0, 20), st.booleans())
def test_linspace(a: float, b: float, n: int, endpoint: bool) -> None:
    assert CALL("linspace", a, b, n, ENDPOINT, endpoint) == tuple(np.linspace(a, b, n, endpoint=endpoint).tolist())


@given(st.integers(-20, 20), st.integers(-20, 20), st.sampled_from([-3, -1, 1, 2, 0.5, 0.1, -0.3]))
def test_arange(a: int, b: int, step: Any) -> None:
    wanted = np.arange(a, b, step)
    assert CALL("arange", a, b, step) == tuple(wanted.tolist())


@given(
    st.tuples(*[st.one_of(st.integers(-1, 1), st.just("all"), st.tuples(st.integers(-3, 3), st.integers(-3, 3)))] * 3)
)
def test_slices_of_arrays(axes: Any) -> None:
    keys = tuple(slice(None) if a == "all" else slice(*a) if isinstance(a, tuple) else a for a in axes)
    arguments = [ALL if a == "all" else scheme(a) for a in axes]
    assert np.array_equal(array(CALL("slice", GRID, *arguments)), GRID.data[keys])


@given(st.integers(-3, 3), st.integers(-4, 4))
def test_ref_of_arrays(i: int, j: int) -> None:
    try:
        wanted = GRID.data[i, j]
    except IndexError:
        CALL.refuses("index", "ref", GRID, i, j)
    else:
        assert CALL("ref", GRID, i, j) == tuple(wanted.tolist())
        assert CALL("ref", GRID, i, j, -1) == wanted[-1]


def test_ref_of_poses(call: Caller) -> None:
    moved = pose.translation(1, 2, 3)
    assert call("ref", moved, 1, 3) == 2.0
    assert call("ref", moved, -1) == (0.0, 0.0, 0.0, 1.0)
    assert "axis 1" in call.refuses("index", "ref", moved, 0, 4)
    assert call.python("array-shape", moved) == [4, 4]
    assert call("length", moved) == 4


@pytest.mark.parametrize("axis", [None, 0, 1, -1])
@pytest.mark.parametrize(
    ("name", "function"),
    [("sum", np.sum), ("mean", np.mean), ("min", np.min), ("max", np.max), ("argmin", np.argmin), ("argmax", np.argmax),
     ("cumsum", np.cumsum), ("product", np.prod)],
)  # fmt: skip
def test_reductions(call: Caller, name: str, function: Any, axis: Any) -> None:
    data = np.array([[3, 1, 2], [-5, 0, 9]])
    for grid in (data, data / 4):
        got = call(name, Array(grid.copy()), *([] if axis is None else [AXIS, axis]))
        wanted = function(grid, axis=axis)
        assert np.array_equal(array(got), wanted)
        assert array(got).dtype.kind == np.asarray(wanted).dtype.kind


def test_reductions_of_lists(call: Caller) -> None:
    assert call("sum", [1, 2.5]) == 3.5
    assert call("sum", NIL) == 0
    assert call("sum", [Vector((1, 2)), Vector((3, 4))]) == (4, 6)
    assert call("sum", call("set", 1, 2)) == 3
    assert call("product", [2, 3.0]) == 6.0
    assert call("max", [3, 1, 4.5]) == 4.5
    assert call("min", 3, 2.0) == 2.0
    assert call("max", 7) == 7
    assert call("max", Vector((1, 5)), 3) == (3, 5)
    assert call("mean", [1, 2]) == 1.5
    for name in ("min", "max", "mean", "argmax"):
        call.refuses("index", name, NIL)
    assert "min-of" in call.refuses("type", "min", "a", "b")
    call.refuses("type", "sum", ["a"])
    call.refuses("index", "sum", GRID, AXIS, 3)


def test_large_integers(call: Caller) -> None:
    big = Array(np.full((2, 2), 1 << 62))
    assert call("sum", big) == float(1 << 64)
    assert call("product", big) == float(1 << 62) ** 4
    assert array(call("@", big, big)).dtype.kind == "f"
    assert call("sum", [1 << 62, 1 << 62]) == 1 << 63
    assert call("arange", 2**70, 2**70 + 1) in [(), (float(2**70),)]


def test_shaping(call: Caller) -> None:
    assert array(call("transpose", GRID)).shape == (4, 3, 2)
    assert array(call("reshape", GRID, [4, -1])).shape == (4, 6)
    assert call("reshape", GRID, -1) == tuple(range(24))
    assert call("flatten", GRID) == tuple(range(24))
    call.refuses("value", "reshape", GRID, [5, -1])
    call.refuses("value", "reshape", GRID, [-1, -1])
    assert array(call("stack-arrays", [Vector((1, 2)), Vector((3, 4))], AXIS, 1)).tolist() == [[1, 3], [2, 4]]
    assert call("concatenate", Vector((1,)), [2, 3.5]) == (1.0, 2.0, 3.5)
    call.refuses("value", "stack-arrays", Vector((1,)), Vector((1, 2)))
    call.refuses("value", "concatenate", GRID, GRID, AXIS, 7)


POSES = st.builds(
    lambda angle, axis, offset: pose.compose(pose.translation(*offset), pose.rotation(angle, axis, (0, 0, 0))),
    st.floats(-3, 3),
    st.sampled_from([(1, 0, 0), (0, 1, 0), (1, 1, 1)]),
    st.tuples(*[st.floats(-5, 5)] * 3),
)
POINTS = st.tuples(*[st.floats(-5, 5)] * 3).map(Vector)


@given(POSES, POSES, POINTS)
def test_poses(a: Matrix, b: Matrix, p: Vector) -> None:
    both = CALL("@", a, b)
    assert type(both) is Matrix
    assert np.allclose(array(both), array(a) @ array(b))
    moved = CALL("@", a, b, p)
    assert np.allclose(moved, (array(both) @ [*p, 1.0])[:3])
    back = CALL("@", CALL("inverse", both), moved)
    assert np.allclose(back, p)
    assert type(CALL("inverse", a)) is Matrix
    assert math.isclose(CALL("determinant", a), 1.0)


SHAPES = st.sampled_from([(2,), (3,), (2, 3), (3, 2), (2, 2, 3), (3, 3), (4, 4)])


@given(SHAPES, SHAPES)
def test_products_of_any_size(a: Any, b: Any) -> None:
    left, right = (np.arange(math.prod(shape), dtype=float).reshape(shape) + 1 for shape in (a, b))
    x, y = from_numpy(left.copy()), from_numpy(right.copy())
    for name, function in (("@", np.matmul), ("dot", np.dot)):
        try:
            wanted = function(left, right)
        except ValueError:
            CALL.refuses("value", name, x, y)
        else:
            assert np.allclose(array(CALL(name, x, y)), wanted)


def test_products(call: Caller) -> None:
    assert call("@", Vector((1, 2)), Vector((3, 4))) == 11
    assert call("@", IDENTITY, [1, 2, 3]) == (1.0, 2.0, 3.0)
    assert call("@", IDENTITY, Vector((1, 2, 3, 1))) == (1.0, 2.0, 3.0, 1.0)
    assert call("@", IDENTITY) is IDENTITY
    assert call("@", call("mutable", IDENTITY), Vector((1, 2, 3))) == (1.0, 2.0, 3.0)
    assert "(* x array)" in call.refuses("type", "@", 2, IDENTITY)
    call.refuses("type", "@", "a", IDENTITY)


@given(POINTS, POINTS)
def test_vectors(a: Vector, b: Vector) -> None:
    assert np.allclose(CALL("cross", a, b), np.cross(a, b))
    assert math.isclose(CALL("dot", a, b), float(np.dot(a, b)), abs_tol=1e-9)
    assert math.isclose(CALL("distance", a, b), math.dist(a, b), abs_tol=1e-12)
    assert math.isclose(CALL("norm", a), math.hypot(*a), abs_tol=1e-12)
    if CALL("norm", a) > 1e-100:
        assert math.isclose(CALL("norm", CALL("normalize", a)), 1.0)


def test_vector_errors(call: Caller) -> None:
    call.refuses("domain", "normalize", Vector((0, 0, 0)))
    call.refuses("value", "cross", Vector((1, 2)), Vector((1, 2)))
    call.refuses("value", "distance", Vector((1, 2)), Vector((1, 2, 3)))
    call.refuses("domain", "inverse", Array(np.zeros((2, 2))))
    call.refuses("domain", "solve", Array(np.zeros((2, 2))), Vector((1, 2)))
    call.refuses("type", "inverse", Vector((1, 2)))
    call.refuses("value", "solve", Array(np.eye(2)), Vector((1, 2, 3)))
    assert "(@ pose [0 0 0])" in call.refuses("type", "x-of", IDENTITY)
    call.refuses("index", "z-of", Vector((1, 2)))
    assert call("y-of", [1, 2]) == 2


def test_item_by_item(call: Caller) -> None:
    assert call("clip", Vector((-1, 5, 12)), 0, Vector((9, 9, 10))) == (0, 5, 10)
    assert call("interp", Vector((0, 1.5, 9)), [1, 2, 3], [10, 20, 30]) == (10.0, 15.0, 30.0)
    call.refuses("value", "interp", 1, [2, 1], [1, 2])
    call.refuses("value", "interp", 1, [1, 2], [1])
    assert call("where", [True, False], Vector((1, 2)), 9) == (1, 9)
    assert call("where", True, 1, 2) == 1
    assert call("where", Vector((0, 2)), 1, 2) == (2, 1)
    call.refuses("value", "where", [[True], [True, False]], 1, 2)


def test_deep_lists_are_no_arrays(call: Caller) -> None:
    deep: Any = NIL
    for _ in range(100_000):
        deep = Pair(deep, NIL)
    call.refuses("value", "array", deep)


def test_higher_dimensions_as_sequences(call: Caller) -> None:
    rows = call.python("->list", GRID)
    assert [type(row) for row in rows] == [Array, Array]
    assert array(call("reverse", GRID)).tolist() == GRID.data[::-1].tolist()
    assert array(call("take", GRID, 1)).shape == (1, 3, 4)
    assert array(call("take", GRID, 0)).shape == (0, 3, 4)
