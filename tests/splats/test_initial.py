"""Primitives as Gaussians: where they lie, how many there are, what they share."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from later import later
from support import evaluate

from scenelang.backends.neural.splats.initial import (
    MIN_GAUSSIANS,
    cover_of,
    gaussians_of,
    sample_solid,
    sample_triangles,
)
from scenelang.grammar.diagnostics import LimitError
from scenelang.interpreter.scene.entity import Entity
from scenelang.interpreter.scene.flatten import flatten_entity
from scenelang.interpreter.scene.primitives import standard_forms
from scenelang.interpreter.scene.primitives.forms import CanonicalForm

torch = later("torch")

BALL, BLOCK, CYLINDER, CONE, TRIANGLE = standard_forms()


def root_of(body: str) -> Entity:
    return evaluate(f'(bind "a" (lambda () {body}))').root


RED_BALL = '(call "sphere" :radius 2 :color [1 0 0])'


@pytest.mark.parametrize(
    ("form", "half", "area"),
    [
        (BALL, (2.0, 2.0, 2.0), 16.0 * np.pi),
        (BLOCK, (1.0, 2.0, 3.0), 8.0 * (2.0 + 3.0 + 6.0)),
        (CYLINDER, (1.0, 3.0, 1.0), 2.0 * np.pi * (1.0 + 6.0)),
        (CONE, (3.0, 2.0, 3.0), np.pi * 3.0 * (3.0 + 5.0)),
        (BLOCK, (1.0, 0.0, 1.0), 8.0),
    ],
)
def test_points_lie_evenly_on_the_surface(form: CanonicalForm, half: Any, area: float) -> None:
    found = sample_solid(form, half, 600)
    assert len(found.points) == 600
    assert found.area == pytest.approx(area)
    np.testing.assert_allclose(np.linalg.norm(found.normals, axis=1), 1.0)
    x, y, z = found.points.T
    outside = {
        BALL: np.hypot(np.hypot(x, y), z) / 2.0,
        BLOCK: np.max(np.abs(found.points) / np.where(np.array(half) > 0.0, half, 1.0), axis=1),
        CYLINDER: np.maximum(np.hypot(x, z), np.abs(y) / (half[1] or 1.0)),
        CONE: np.where(y > -half[1] + 1e-9, np.hypot(x, z) / np.maximum(half[0] * (half[1] - y) / 4.0, 1e-12), 1.0),
    }[form]
    if half[1]:
        np.testing.assert_allclose(outside, 1.0, atol=1e-9)
    if not half[1]:
        return
    away = np.linalg.norm(found.points[:, None] - found.points[None], axis=2) + 1e9 * np.eye(600)
    nearest = away.min(axis=1) / np.sqrt(area / 600)
    assert 0.5 < nearest.mean() < 1.2  # random points have 0.5, a grid 1
    assert np.quantile(nearest, 0.02) > 0.15  # random points have 0.08


@pytest.mark.parametrize("form", [BALL, BLOCK, CYLINDER, CONE])
def test_normals_look_outwards(form: CanonicalForm) -> None:
    found = sample_solid(form, (1.0, 1.0, 1.0), 200)
    assert (np.einsum("ni,ni->n", found.normals, found.points + np.array([0.0, 0.3, 0.0])) > 0.0).all()


def test_points_on_triangles_are_as_many_as_their_areas() -> None:
    corners = np.array([[[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[5, 0, 0], [8, 0, 0], [5, 1, 0]], [[9, 9, 9]] * 3], float)
    found, which = sample_triangles(corners, 400)
    assert np.bincount(which).tolist() == [100, 300]
    assert found.area == pytest.approx(2.0)
    np.testing.assert_allclose(found.normals, np.tile([0.0, 0.0, 1.0], (400, 1)))
    assert (found.points[which == 0].sum(axis=1) <= 1.0 + 1e-12).all()
    assert not len(sample_triangles(corners[2:], 10)[0].points)


def test_the_same_seed_gives_the_same_gaussians() -> None:
    root = root_of(RED_BALL)
    first, again, other = gaussians_of(root, 200), gaussians_of(root, 200), gaussians_of(root, 200, seed=1)
    assert first.splats.means.equal(again.splats.means)
    assert not first.splats.means.equal(other.splats.means)


def test_gaussians_have_their_primitives_looks() -> None:
    root = root_of(
        '(union (call "sphere" :radius 1 :color [1 0 0]) (call "cube" :scale 1 :color [0 1 0] :opacity 0.5))'
    )
    made = gaussians_of(root, 2_000)
    number = {e.word: i for i, e in enumerate(flatten_entity(root).primitives)}
    ball, cube = (torch.from_numpy(made.instance == number[word]) for word in ("sphere", "cube"))
    assert made.splats.colors[ball].unique(dim=0).tolist() == [[1.0, 0.0, 0.0]]
    assert made.splats.colors[cube].unique(dim=0).tolist() == [[0.0, 1.0, 0.0]]
    assert made.splats.opacities[ball].min() > 0.9
    assert made.splats.opacities[cube].max() < 0.5
    assert 1_900 <= len(made.splats) <= 2_100
    assert ball.sum() / cube.sum() == pytest.approx(4.0 * np.pi / 6.0, rel=0.05)


def test_instances_of_one_primitive_share_their_gaussians() -> None:
    root = root_of(f"(let ((b {RED_BALL})) (union (transform b (translate [9 0 0])) (transform b (scale 2))))")
    frame = flatten_entity(root)
    made = gaussians_of(root, 500)
    if len(frame.primitives) == 1:
        first, second = (torch.from_numpy(made.instance == i) for i in (0, 1))
        near, far = made.splats.take(first), made.splats.take(second)
        shift = torch.tensor([9.0, 0.0, 0.0], dtype=torch.float64)
        torch.testing.assert_close((near.means - shift) * 2.0, far.means)
        torch.testing.assert_close(near.covariances * 4.0, far.covariances)
    assert made.count == 2


def test_every_primitive_has_some_and_none_that_is_not_seen() -> None:
    small = " ".join(f"(transform {RED_BALL} (@ (translate [{i} 0 0]) (scale 0.001)))" for i in range(5))
    root = root_of(f'(union (call "cube" :scale 100) {small} (call "cube" :opacity 0))')
    made = gaussians_of(root, 1_000)
    counts = np.bincount(made.instance, minlength=7)
    assert (counts > 0).sum() == 6
    assert counts[counts > 0].min() >= MIN_GAUSSIANS


def test_no_gaussian_of_a_solid_sticks_far_out() -> None:
    cover = cover_of(flatten_entity(root_of(RED_BALL)).primitives[0], 500)
    assert cover is not None
    away = cover.gaussians.means.norm(dim=1)
    assert away.max() <= 2.0 + 1e-9
    assert (away < 1.7).double().mean() == pytest.approx(0.1, abs=0.01)
    torch.testing.assert_close(
        cover.gaussians.axes[:450, :, 2],
        0.08 / 0.6 * cover.gaussians.axes[:450, :, 0].norm(dim=1)[:, None] * torch.from_numpy(cover.normals[:450]),
    )


def test_too_many_are_refused() -> None:
    with pytest.raises(LimitError, match="Gaussians"):
        gaussians_of(root_of(RED_BALL), 10_000_000)


def test_a_scene_of_nothing_has_none() -> None:
    assert not len(gaussians_of(root_of('(call "cube" :opacity 0)'), 100).splats)
