"""Distances and depths of convex solids against closed forms and against dense sampling."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt
import pytest

from scenelang.backends.surfaces.distance import Pairs, boxes, depths, distances, neighbors
from scenelang.backends.surfaces.solids import PosedForms
from scenelang.interpreter.scene.primitives import standard_forms

Array = npt.NDArray[np.float64]
BALL, BLOCK, CYLINDER, CONE, TRIANGLE = standard_forms()
COUNT = 400


def poses(chance: np.random.Generator, count: int, apart: float) -> Array:
    """Sheared, turned and mirrored poses."""
    linear = chance.normal(size=(count, 3, 3)) * 0.5 + np.eye(3)
    return np.concatenate([linear, chance.normal(size=(count, 3, 1)) * apart], axis=2)


def forms(numbers: npt.NDArray[np.int64], matrices: Array) -> PosedForms:
    return PosedForms(standard_forms(), numbers.astype(np.int16), np.zeros((len(matrices), 0)), matrices)


def all_of(number: int, matrices: Array) -> PosedForms:
    return forms(np.full(len(matrices), number), matrices)


def random_pairs(seed: int, count: int = COUNT, apart: float = 2.0) -> Pairs:
    chance = np.random.default_rng(seed)
    kinds = chance.integers(0, 4, (2, count))
    return Pairs(forms(kinds[0], poses(chance, count, apart)), forms(kinds[1], poses(chance, count, apart)))


def directions(count: int) -> Array:
    points = np.random.default_rng(5).normal(size=(count, 3))
    return points / np.linalg.norm(points, axis=1, keepdims=True)


def widths(pairs: Pairs, i: int, along: Array) -> Array:
    """How far the second solid of pair ``i`` must move along each direction to leave the first one."""
    one = pairs.take(np.full(len(along), i))
    return np.einsum("ni,ni->n", one.difference(along), along)


def test_balls() -> None:
    chance = np.random.default_rng(1)
    radii = chance.uniform(0.2, 1.0, (2, COUNT))
    centers = chance.normal(size=(2, COUNT, 3))
    matrices = [np.concatenate([np.eye(3) * r[:, None, None], c[:, :, None]], axis=2) for r, c in zip(radii, centers)]
    pairs = Pairs(all_of(0, matrices[0]), all_of(0, matrices[1]))
    gap = np.linalg.norm(centers[0] - centers[1], axis=1) - radii.sum(axis=0)
    assert distances(pairs) == pytest.approx(np.maximum(gap, 0.0), abs=1e-6)
    depth, along = depths(pairs)
    assert depth[gap < 0] == pytest.approx(-gap[gap < 0], abs=1e-3)
    assert np.linalg.norm(along, axis=1) == pytest.approx(1.0)


def test_boxes_along_the_axes() -> None:
    chance = np.random.default_rng(2)
    half = chance.uniform(0.1, 1.0, (2, COUNT, 3))
    centers = chance.normal(size=(2, COUNT, 3)) * 1.5
    matrices = [np.concatenate([np.eye(3) * h[:, None, :], c[:, :, None]], axis=2) for h, c in zip(half, centers)]
    pairs = Pairs(all_of(1, matrices[0]), all_of(1, matrices[1]))
    apart = np.abs(centers[0] - centers[1]) - half.sum(axis=0)
    assert distances(pairs) == pytest.approx(np.linalg.norm(np.maximum(apart, 0.0), axis=1), abs=1e-6)
    inside = (apart < 0).all(axis=1)
    assert inside.any()
    assert depths(pairs)[0][inside] == pytest.approx(-apart[inside].max(axis=1), abs=1e-9)


@pytest.mark.parametrize("seed", range(4))
def test_all_solids_against_sampling(seed: int) -> None:
    pairs = random_pairs(seed, 60)
    gaps, (depth, _) = distances(pairs), depths(pairs)
    around = directions(6000)
    for i in range(len(pairs)):
        least = widths(pairs, i, around).min()
        if gaps[i] > 0:  # the distance is the greatest separation over all directions
            assert -1e-6 <= gaps[i] + least <= 0.05 * (1 + gaps[i])  # few directions meet a thin solid's edge
        else:
            assert least >= -1e-9
            assert 0 <= depth[i] <= least + 0.02  # sampling finds no less; the next test says that it is enough


@pytest.mark.parametrize("seed", range(4))
def test_moving_by_the_depth_parts_the_solids(seed: int) -> None:
    pairs = random_pairs(seed + 10, 200, 0.7)
    depth, along = depths(pairs)
    moved = pairs.b.matrices.copy()
    moved[:, :, 3] += along * (depth + 1e-3)[:, None]
    assert (distances(Pairs(pairs.a, replace(pairs.b, matrices=moved))) > 0).all()


def test_support_points_are_on_the_solids() -> None:
    pairs = random_pairs(3)
    along = directions(COUNT)
    matrices = pairs.a.matrices
    local = np.einsum("nij,nj->ni", np.linalg.inv(matrices[:, :, :3]), pairs.a.support(along) - matrices[:, :, 3])
    across = np.hypot(local[:, 0], local[:, 2])
    for form, inside in {
        BLOCK: np.abs(local).max(axis=1),
        BALL: np.linalg.norm(local, axis=1),
        CYLINDER: np.maximum(across, np.abs(local[:, 1])),
        CONE: across + (1 + local[:, 1]) / 2,
    }.items():
        assert (inside[pairs.a.forms == pairs.a.kinds.index(form)] <= 1 + 1e-9).all()


def test_neighbors_are_all_pairs_of_boxes_that_meet() -> None:
    pairs = random_pairs(4, 120, 4.0)
    low, high = boxes(pairs.a)
    found, complete = neighbors(low, high, 0.1, 10_000)
    expected = {
        (i, j)
        for i in range(120)
        for j in range(i + 1, 120)
        if (low[i] <= high[j] + 0.1).all() and (low[j] <= high[i] + 0.1).all()
    }
    assert complete
    assert set(map(tuple, found.tolist())) == expected
    few, complete = neighbors(low, high, 0.1, 5)
    assert len(few) == 5
    assert not complete


@pytest.mark.parametrize("count", [0, 1, 2, 300])
@pytest.mark.parametrize("spread", [0.5, 40.0, 1e9])
def test_neighbors_of_boxes_of_any_size(count: int, spread: float) -> None:
    """Sizes over twelve orders of magnitude, flat boxes, equal boxes, and what only touches."""
    chance = np.random.default_rng(count)
    center = np.round(chance.uniform(-spread, spread, (count, 3)), 1)
    half = np.round(10.0 ** chance.uniform(-9.0, 3.0, (count, 3)), 1)
    half[::7, 1] = 0.0
    low, high = (
        np.concatenate([center - half, center[:2] - half[:2]]),
        np.concatenate([center + half, center[:2] + half[:2]]),
    )
    found, complete = neighbors(low, high, 0.0, 10**6)
    meets = (low[:, None] <= high[None]).all(axis=2) & (low[None] <= high[:, None]).all(axis=2)
    first, second = np.nonzero(np.triu(meets, 1))
    assert complete
    np.testing.assert_array_equal(found, np.stack([first, second], axis=1))


def test_neighbors_of_many_boxes_take_time_in_proportion() -> None:
    """A cube of cells with a slab under all of them: no box is compared with a whole row of others."""
    import scenelang.backends.surfaces.distance as module

    counted = []
    original = np.repeat
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(module.np, "repeat", lambda *given: counted.append(len(found := original(*given))) or found)
        for side in (10, 20):
            counted.append(-1)
            grid = np.stack(np.meshgrid(*[np.arange(side)] * 3), -1).reshape(-1, 3).astype(float)
            low = np.concatenate([grid, [[0.0, -1.0, 0.0]]])
            high = np.concatenate([grid + 1.0, [[side, 0.0, side]]])
            pairs, _ = neighbors(low, high, 1e-3, 10**7)
            assert len(pairs) == (3 * side - 2) ** 3 // 2 - side**3 // 2 + side**2
    cut = counted.index(-1, 1)
    assert sum(counted[cut + 1 :]) < 12 * sum(counted[1:cut])  # 8 times as many boxes; comparing rows takes 32 times
