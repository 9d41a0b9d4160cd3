"""The arrays of the playground against numpy: the same expressions over the same numbers."""

from __future__ import annotations

import importlib.util
import math
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from scenelang.playground import MissingError

FOLDER = Path(__file__).parents[2] / "scenelang" / "playground" / "numpy"


def _load() -> Any:
    """Import the arrays under a name of their own, beside numpy."""
    spec = importlib.util.spec_from_file_location(
        "pynumpy", FOLDER / "__init__.py", submodule_search_locations=[str(FOLDER)]
    )
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules["pynumpy"] = module
    spec.loader.exec_module(module)
    return module


pn = _load()


def plain(value: Any) -> Any:
    """Return a result of either library as nested lists with the kind of its elements."""
    if isinstance(value, tuple):
        return tuple(plain(each) for each in value)
    if isinstance(value, list):
        return [plain(each) for each in value]
    if hasattr(value, "tolist"):
        kind = value.dtype.kind if hasattr(value, "dtype") else ""
        return getattr(value, "shape", ()), {"u": "i"}.get(kind, kind), value.tolist()
    return (), {bool: "b", int: "i", float: "f"}.get(type(value), ""), value


def assert_same(mine: Any, theirs: Any) -> None:
    """Compare results; floats to the last bits, as sums are added in another order."""
    left, right = plain(mine), plain(theirs)
    assert str(type(left)) == str(type(right))
    _assert_equal(left, right)


def _assert_equal(left: Any, right: Any) -> None:
    if isinstance(right, (list, tuple)):
        assert len(left) == len(right), (left, right)
        for a, b in zip(left, right, strict=True):
            _assert_equal(a, b)
    elif isinstance(right, float) and isinstance(left, (int, float)):
        if math.isnan(right):
            assert math.isnan(left)
        else:
            assert left == pytest.approx(right, rel=1e-12, abs=1e-12)
    else:
        assert left == right


RANDOM = np.random.RandomState(7)
NUMBERS: dict[str, Any] = {
    "a": (RANDOM.rand(4, 3) * 4 - 2).tolist(),
    "b": (RANDOM.rand(4, 3) * 4 - 2).tolist(),
    "v": (RANDOM.rand(6) * 4 - 2).tolist(),
    "w": (RANDOM.rand(6) * 4 - 2).tolist(),
    "p": (RANDOM.rand(5, 3, 4) * 2 - 1).tolist(),
    "q": (RANDOM.rand(5, 4, 2) * 2 - 1).tolist(),
    "i": RANDOM.randint(-5, 6, 8).tolist(),
    "j": RANDOM.randint(0, 4, (3, 2)).tolist(),
    "t": (RANDOM.rand(4, 3) > 0.5).tolist(),
    "s": [[4.0, 1.0, 0.5], [1.0, 3.0, -0.2], [0.5, -0.2, 2.0]],
    "z": [0.0, -0.0, 1.0, -1.0, 2.5, -2.5, 0.5, 1e300],
}

# One expression a line, over the module ``n`` and the arrays above.
EXPRESSIONS = """
a + b
a - 1
2 * a
a / b
a // 0.7
a % 0.7
i % 3
i // 3
i / 2
i ** 2
a ** 2
v ** 3
-a
abs(i)
+a
a > b
a >= 0
a == a
a != b
i == 2
t & ~t
t | (a > 0)
t ^ t
i & 3
i << 2
i >> 1
~i
n.array([True, False]) + n.array([True, True])
n.array([1, 2, 3]) * 1.5
n.array([1, 2], n.float32) * 1.1
n.array([1, 2], n.float32) / 3
n.array([250, 10], n.uint8) + n.array([10, 1], n.uint8)
n.array([1.7, -1.7, 3.2]).astype(n.int64)
n.array([300, -1, 255]).astype(n.uint8)
n.array([0.1, 0.2]).astype(n.float32)
n.array([1, 0, 2]).astype(bool)
(a > 0).astype(float)
a.astype(n.float32).astype(n.float64)
a[0]
a[-1, 2]
a[1:3]
a[:, 1]
a[::-1]
a[::2, ::-1]
a[..., 0]
a[None]
a[:, None, :]
a[[0, 2]]
a[[0, 2], [1, 1]]
a[[[0], [1]], [0, 2]]
a[t]
a[a[:, 0] > 0]
a[:, [2, 0]]
p[:, [0, 2], 1]
p[[0, 1], :, [1, 2]]
p[0, [0, 1]]
p[1, ..., 2]
p[:, 1, None]
v[i % 6]
v[n.array([], int)]
p.T
p.transpose(1, 0, 2)
p.swapaxes(1, 2)
p.reshape(5, 12)
p.reshape(-1)
p.T.reshape(-1, 3)
p.T.reshape(4, -1)
a.ravel()
a.T.ravel()
a.flatten()
a.sum()
a.sum(axis=0)
a.sum(axis=1, keepdims=True)
p.sum(axis=(0, 2))
t.sum()
t.sum(axis=0)
i.sum()
a.mean()
a.mean(axis=1)
i.mean()
a.max()
a.min(axis=0)
p.max(axis=(1, 2))
a.argmax()
a.argmin(axis=1)
a.prod(axis=0)
i.prod()
a.cumsum()
a.cumsum(axis=1)
i.cumsum()
v.cumprod()
t.all(axis=0)
t.any()
t.all()
n.max(v, initial=10.0)
n.ptp(a, axis=0)
n.var(a, axis=0)
n.std(v)
n.median(v)
n.quantile(v, 0.3)
n.sort(a, axis=0)
n.sort(v)
n.argsort(v)
n.argsort(a, axis=1)
n.argsort(i, kind="stable")
n.lexsort((i[:4], i[4:]))
n.unique(i)
n.unique(i, return_index=True, return_inverse=True, return_counts=True)
n.unique(j, axis=0)
n.unique(n.array([[1, 2], [1, 2], [0, 5]]), axis=0, return_inverse=True)[0]
n.searchsorted([1.0, 2.0, 3.0], [0.5, 1.0, 2.5, 9.0])
n.searchsorted([1.0, 2.0, 3.0], 2.0, side="right")
n.bincount(j.ravel(), minlength=6)
n.bincount(j.ravel(), weights=v)
n.isin(i, [1, 2])
n.intersect1d(i, [1, 2, 5])
n.union1d(i, [9])
n.setdiff1d(i, [1, 2])
n.nonzero(t)
n.flatnonzero(t)
n.argwhere(t)
n.where(t, a, b)
n.where(a > 0, 1, 0)
n.where(a > 0, a, 0.0)
n.where(t)
n.count_nonzero(t)
n.concatenate([a, b])
n.concatenate([a, b], axis=1)
n.concatenate([p, p], axis=1)
n.concatenate([i, v])
n.stack([a, b])
n.stack([a, b], axis=-1)
n.stack([v, w], axis=1)
n.vstack([a, a[0]])
n.hstack([v, w])
n.hstack([a, b])
n.column_stack([v, w])
n.tile(v, 2)
n.tile(a, (2, 1))
n.tile([[1, 2]], (2, 3))
n.repeat(v, 2)
n.repeat(a, 2, axis=0)
n.repeat(v, [0, 1, 2, 0, 1, 1])
n.roll(v, 2)
n.roll(a, -1, axis=0)
n.roll(a, 1)
n.flip(a, 0)
n.take(a, [2, 0], axis=1)
n.take(v, [1, 1])
n.insert(v, 2, 9.0)
n.insert(a, 1, 5.0, axis=0)
n.append(v, 1.0)
n.delete(v, [0, 2])
n.delete(a, 1, axis=1)
n.split(v, 3)
n.split(v, [1, 4])
n.pad(a, ((1, 0), (0, 2)))
n.pad(v, 2, mode="edge")
n.pad(v, (1, 2), mode="wrap")
n.diff(v)
n.diff(a, axis=0)
n.diff(v, prepend=0.0)
n.clip(a, -0.5, 0.5)
v.clip(0.0)
n.clip(i, 0, None)
n.minimum(a, b)
n.maximum(a, 0)
n.minimum.reduce([v, w])
n.maximum.accumulate(v)
n.add.reduceat(v, [0, 2, 5])
n.add.reduceat(a, [0, 2], axis=0)
n.multiply.outer(v, w)
n.hypot(v, w)
n.arctan2(v, w)
n.copysign(v, -1)
n.mod(v, 1.0)
n.sqrt(n.abs(v))
n.sqrt(v)
n.cbrt(v)
n.sin(v)
n.cos(v)
n.tan(v)
n.arcsin(v / 3)
n.arccos(v / 3)
n.arccos(v)
n.arctan(v)
n.exp(v)
n.log(n.abs(v))
n.log(z)
n.log2(z)
n.log10(z)
n.sinh(v)
n.tanh(v)
n.degrees(v)
n.radians(v)
n.floor(z)
n.ceil(z)
n.trunc(z)
n.rint(z)
n.round(v, 2)
n.round(z)
n.round(n.array([1234.0, 1250.0]), -2)
n.sign(z)
n.sign(i)
n.square(v)
z / 0
0 / z
1 / z
n.isfinite(z / 0)
n.isnan(z / 0)
n.isinf(z / 0)
n.exp(z)
z * 1e300
n.nan_to_num(z / 0)
n.isclose(v, v + 1e-9)
n.allclose(v, w)
n.array_equal(v, v)
n.logical_and(t, a > 0)
n.logical_not(t)
n.logical_or(t, a > 0)
a @ s
s @ v[:3]
v @ w
p @ q
s @ p[0]
n.dot(a, s)
n.outer(v, w)
n.cross(a, b)
n.cross(a, [0.0, 0.0, 1.0])
n.einsum("ij,kj->ik", a, b)
n.einsum("ni,ni->n", a, b)
n.einsum("nij,njk->nik", p, q)
n.einsum("nij,nij->", p, p)
n.einsum("nkk->n", p[:, :3, :3])
n.einsum("nij,j->ni", p, v[:4])
n.einsum("n,ni,nj->ij", v[:4], a, b)
n.trace(s)
n.diagonal(s)
n.diagonal(p, axis1=1, axis2=2)
n.linalg.norm(v)
n.linalg.norm(a, axis=1)
n.linalg.norm(a, axis=1, keepdims=True)
n.linalg.norm(v, ord=1)
n.linalg.norm(v, ord=n.inf)
n.linalg.det(s)
n.linalg.det(p[:, :3, :3])
n.linalg.inv(s)
n.linalg.inv(p[:, :3, :3])
n.linalg.solve(s, v[:3])
n.linalg.solve(s, a[:3])
n.linalg.eigvalsh(s)
n.linalg.svd(a, compute_uv=False)
n.linalg.svd(p, compute_uv=False)
n.linalg.matrix_rank(s)
n.zeros((2, 3))
n.ones(3, int)
n.full((2, 2), 7)
n.full(3, [1.0, 2.0, 3.0])
n.eye(3)
n.eye(2, 3)
n.arange(5)
n.arange(2, 9, 3)
n.arange(0.0, 1.0, 0.3)
n.arange(5, dtype=float)
n.linspace(0, 1, 5)
n.linspace(0, 1, 4, endpoint=False)
n.linspace([0.0, 1.0], [1.0, 3.0], 3)
n.linspace([0.0, 1.0], [1.0, 3.0], 3, axis=1)
n.zeros_like(a)
n.full_like(i, 3)
n.ones_like(a, dtype=int)
n.fromiter((x for x in [1, 2]), n.int32)
n.frombuffer(bytes(range(16)), n.uint8)
n.frombuffer(n.array([1.5, -2.0]).tobytes())
n.array([1.5, 2.0], n.float32).view(n.uint32)
n.meshgrid([1, 2, 3], [4, 5])
n.meshgrid([1, 2, 3], [4, 5], indexing="ij")
n.indices((2, 3))
n.unravel_index(n.array([1, 5]), (2, 3))
n.ix_([0, 2], [1, 2])
a[n.ix_([0, 2], [1, 2])]
n.broadcast_shapes((3, 1), (4,))
n.broadcast_to(v, (2, 6))
n.broadcast_arrays(v[:3], a)
n.expand_dims(v, 0)
n.moveaxis(p, 0, 2)
n.squeeze(a[None])
n.atleast_2d(v)
n.interp([0.5, -9.0, 9.0, 1.5], [0.0, 1.0, 2.0], [0.0, 10.0, 0.0])
n.triu_indices(3, 1)
n.packbits([1, 0, 1, 1, 0, 0, 0, 0, 1])
n.array([[1, 2], [3, 4]]).tolist()
n.array(3.5)
n.array([], float).sum()
n.array([[1, 2, 3]]).size
n.array([a[0], b[0]])
n.array([True, False])
n.array([1, 2.5])
n.array(["x", "y"]) == "x"
n.result_type(n.float32, n.float64) == n.float64
n.shape(a)
n.iinfo(n.int32).max
n.finfo(float).eps
len(a)
[float(x) for x in v]
[row.tolist() for row in a]
float(v[0]) + int(i[0])
bool((a[0] == a[0]).all())
n.float64(3.0) / 0
n.float64(2.0) * v
n.array([5, 3, 9]).min().item()
n.percentile(v, 25)
n.average(v, weights=n.abs(w))
n.take_along_axis(a, n.argsort(a, axis=1), axis=1)
n.ascontiguousarray(a.T)
n.asarray(a) is a
n.ndim(a)
n.digitize(v, [-1.0, 0.0, 1.0])
""".strip().splitlines()


def _evaluate(expression: str, module: Any) -> Any:
    kinds = {"i": int, "j": int, "t": bool}
    names = {name: module.array(value, kinds.get(name, float)) for name, value in NUMBERS.items()}
    with np.errstate(all="ignore"):
        return eval(expression, {"n": module, "abs": abs, "float": float, "int": int, "bool": bool, "len": len}, names)


@pytest.mark.parametrize("expression", EXPRESSIONS)
def test_expression(expression: str) -> None:
    assert_same(_evaluate(expression, pn), _evaluate(expression, np))


def _assigned(module: Any, action: Callable[[Any, Any], None]) -> Any:
    array = module.array(NUMBERS["p"])
    action(module, array)
    return array


ASSIGNMENTS: list[Callable[[Any, Any], None]] = [
    lambda n, x: x.__setitem__(0, 1.0),
    lambda n, x: x.__setitem__((slice(None), slice(None), 3), x[:, :, 0]),
    lambda n, x: x.__setitem__((slice(None), [0, 2], 1), 5.0),
    lambda n, x: x.__setitem__(x > 0, 0.0),
    lambda n, x: x.__setitem__((..., [0, 1, 2], [0, 1, 2]), n.arange(3)),
    lambda n, x: x[1].__iadd__(10.0),
    lambda n, x: x[:, 0].__imul__(n.arange(5)[:, None]),
    lambda n, x: n.add.at(x.reshape(-1), [0, 0, 5], 1.0),
    lambda n, x: n.minimum.at(x.reshape(-1), n.array([1, 1]), n.array([-9.0, 3.0])),
    lambda n, x: n.putmask(x, x < 0, 7.0),
    lambda n, x: n.put(x, [0, 3], [8.0, 9.0]),
    lambda n, x: n.take(x[0], [1, 0, 2, 3], axis=1, out=x[1]),
    lambda n, x: n.matmul(x[:, :, :3], x[:, :3, :], out=x),
    lambda n, x: n.multiply(x[0], 2.0, out=x[4]),
    lambda n, x: x.sort(axis=1),
    lambda n, x: x.T[0].fill(4.0),
    lambda n, x: x.transpose(2, 0, 1).reshape(4, 15).__setitem__((0, 0), 99.0),
]


@pytest.mark.parametrize("number", range(len(ASSIGNMENTS)))
def test_assignment(number: int) -> None:
    """Views share memory where numpy's do, and only there."""
    assert_same(_assigned(pn, ASSIGNMENTS[number]), _assigned(np, ASSIGNMENTS[number]))


_SHAPES = st.lists(st.integers(1, 4), min_size=1, max_size=4)
_PARTS = st.one_of(
    st.integers(-1, 0),
    st.builds(slice, st.one_of(st.none(), st.integers(-4, 4)), st.none(), st.sampled_from([None, 1, 2, -1, -2])),
    st.none(),
    st.just(Ellipsis),
    st.lists(st.integers(-1, 0), min_size=1, max_size=3),
)


@settings(max_examples=300, deadline=None)
@given(_SHAPES, st.lists(_PARTS, min_size=1, max_size=4), st.booleans())
def test_index(shape: list[int], key: list[Any], turned: bool) -> None:
    """Any index selects what numpy's does, of views too."""
    if sum(part is Ellipsis for part in key) > 1:
        return
    theirs = np.arange(math.prod(shape)).reshape(shape)
    mine = pn.arange(math.prod(shape)).reshape(shape)
    if turned:
        theirs, mine = theirs.T, mine.T
    try:
        expected = theirs[tuple(key)]
    except IndexError:
        with pytest.raises(IndexError):
            mine[tuple(key)]
        return
    assert_same(mine[tuple(key)], expected)


@settings(max_examples=200, deadline=None)
@given(_SHAPES, st.permutations([0, 1, 2, 3]), st.data())
def test_reshape(shape: list[int], order: list[int], data: st.DataObject) -> None:
    """A reshaped view shares memory just where numpy's does."""
    axes = [axis for axis in order if axis < len(shape)]
    theirs = np.arange(float(math.prod(shape))).reshape(shape).transpose(axes)
    mine = pn.arange(math.prod(shape)).astype(float).reshape(shape).transpose(axes)
    size = math.prod(shape)
    first = data.draw(st.sampled_from([d for d in range(1, size + 1) if size % d == 0]))
    for array in (mine, theirs):
        array.reshape(first, -1)[0, 0] = -1.0
    assert_same(mine, theirs)


@pytest.mark.parametrize("seed", [0, 1, 42, 2**32 - 1])
def test_random_numbers_are_numpy_s(seed: int) -> None:
    """The legacy generator draws the same numbers, bit for bit, in any order of calls."""
    from pynumpy.random import RandomState  # type: ignore[import-not-found]

    mine, theirs = RandomState(seed), np.random.RandomState(seed)
    draws: list[Callable[[Any], Any]] = [
        lambda r: r.random(), lambda r: r.rand(3), lambda r: r.randn(3), lambda r: r.randint(5), lambda r: r.randint(2, 900, 4),
        lambda r: r.normal(2.0, 3.0), lambda r: r.uniform(-1.0, 4.0, 2), lambda r: r.permutation(7), lambda r: r.randint(0, 2**40),
        lambda r: r.choice(9, 4), lambda r: r.choice(9, 4, replace=False), lambda r: r.choice([1.5, 2.5], p=[0.2, 0.8]),
        lambda r: r.choice(4, 3, replace=False, p=[0.1, 0.2, 0.3, 0.4]), lambda r: r.normal(size=3), lambda r: r.random(),
    ]  # fmt: skip
    for draw in draws:
        a, b = draw(mine), draw(theirs)
        assert np.array_equal(np.asarray(a.tolist() if hasattr(a, "tolist") else a), np.asarray(b))


def test_singular_matrix() -> None:
    with pytest.raises(pn.linalg.LinAlgError):
        pn.linalg.inv([[1.0, 2.0], [2.0, 4.0]])


def test_vectors_of_a_decomposition() -> None:
    """Singular vectors are unique up to signs, so their product is compared."""
    for matrix in (NUMBERS["a"], NUMBERS["s"], np.array(NUMBERS["a"]).T.tolist(), [[1.0, 0.0], [0.0, 0.0]]):
        u, s, v = pn.linalg.svd(matrix, full_matrices=False)
        assert np.allclose((np.array(u.tolist()) * s.tolist()) @ np.array(v.tolist()), matrix)
        values, vectors = pn.linalg.eigh(np.array(NUMBERS["s"]).tolist())
        assert np.allclose(np.array(vectors.tolist()) * values.tolist() @ np.array(vectors.tolist()).T, NUMBERS["s"])


def test_missing_function() -> None:
    """What is missing is named, rather than taken for a wrong attribute."""
    with pytest.raises(MissingError, match=r"numpy\.fft"):
        _ = pn.fft
    assert not hasattr(pn, "fft")


def test_the_largest_unsigned_integers() -> None:
    """They are no negative ones: the casting of rays marks misses by them."""
    nothing = pn.uint64(0xFFFFFFFFFFFFFFFF)
    keys = pn.minimum(pn.full((3,), nothing), pn.array([5, 0xFFFFFFFFFFFFFFFF, 7], pn.uint64))
    assert keys.dtype == pn.uint64
    assert (keys == nothing).tolist() == [False, True, False]
    assert pn.where(keys == nothing, -1, (keys & pn.uint64(0xFFFFFFFF)).astype(pn.int64)).tolist() == [5, -1, 7]
