"""Gaussians and the law by which poses move them."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from later import later
from searching import many

from scenelang.backends.neural.splats.gaussians import (
    apply_pose,
    concatenate_gaussians,
    concatenate_splats,
    gaussians_from,
    quaternions_from,
    rotations,
)
from splats.drawing import random_gaussians, splats_of

torch = later("torch")

SEEDS = st.integers(0, 2**31)


def density(means: object, covariances: object, points: object) -> object:
    away = points - means  # type: ignore[operator]
    return torch.exp(-0.5 * torch.einsum("ni,nij,nj->n", away, torch.linalg.inv(covariances), away))


@settings(deadline=None, max_examples=many(50))
@given(SEEDS)
def test_a_posed_gaussian_has_at_posed_points_what_it_had(seed: int) -> None:
    """``G_t(t(x)) = G(x)`` for any invertible pose, mirrors and shear included."""
    gaussians = random_gaussians(5, seed)
    chance = torch.Generator().manual_seed(seed)
    matrix = torch.randn(3, 3, generator=chance, dtype=torch.float64) + 0.5 * torch.eye(3)
    if torch.linalg.cond(matrix) > 1e3:
        return
    place = torch.randn(3, generator=chance, dtype=torch.float64)
    points = gaussians.means + 0.2 * torch.randn(5, 3, generator=chance, dtype=torch.float64)
    moved = apply_pose(gaussians, matrix, place)
    before = density(gaussians.means, gaussians.covariances, points)
    after = density(moved.means, moved.covariances, points @ matrix.T + place)
    torch.testing.assert_close(after, before, rtol=1e-6, atol=1e-9)


@settings(deadline=None, max_examples=many(50))
@given(SEEDS, st.floats(0.01, 100.0))
def test_the_papers_form_is_equal_for_one_scale(seed: int, scale: float) -> None:
    gaussians = random_gaussians(4, seed)
    chance = torch.Generator().manual_seed(seed + 1)
    turn = rotations(torch.randn(1, 4, generator=chance, dtype=torch.float64))[0]
    shift = torch.randn(3, generator=chance, dtype=torch.float64)
    moved = apply_pose(gaussians, turn * scale, shift)
    own = rotations(gaussians.quaternions)
    papers = (turn @ own) @ torch.diag_embed(scale * gaussians.log_scales.exp())
    torch.testing.assert_close(moved.covariances, papers @ papers.mT)
    torch.testing.assert_close(moved.means, scale * gaussians.means @ turn.T + shift)
    assert moved.opacities.equal(gaussians.opacities)
    assert moved.colors is gaussians.colors


def test_the_papers_form_differs_for_unequal_scales() -> None:
    gaussians = random_gaussians(4)
    stretch = torch.diag(torch.tensor([1.0, 2.0, 3.0], dtype=torch.float64))
    papers = rotations(gaussians.quaternions) @ (stretch * gaussians.log_scales.exp()[:, None, :])
    moved = apply_pose(gaussians, stretch, torch.zeros(3, dtype=torch.float64))
    assert not torch.allclose(moved.covariances, papers @ papers.mT)


def test_poses_compose() -> None:
    gaussians = random_gaussians(6)
    first, second = torch.randn(2, 3, 3, generator=torch.Generator().manual_seed(3), dtype=torch.float64)
    place = torch.tensor([0.5, -1.0, 2.0], dtype=torch.float64)
    twice = apply_pose(gaussians, first, place).transformed(second, place)
    once = apply_pose(gaussians, second @ first, second @ place + place)
    torch.testing.assert_close(twice.means, once.means)
    torch.testing.assert_close(twice.covariances, once.covariances)


def test_derivatives_by_gaussians_and_pose() -> None:
    one = random_gaussians(2)

    def both(means: object, logs: object, turns: object, matrix: object, place: object) -> tuple[object, object]:
        moved = apply_pose(type(one)(means, logs, turns, one.opacity_logits, one.colors), matrix, place)  # type: ignore[arg-type]
        return moved.means, moved.covariances

    matrix = torch.randn(3, 3, dtype=torch.float64, generator=torch.Generator().manual_seed(1))
    place = torch.randn(3, dtype=torch.float64, generator=torch.Generator().manual_seed(2))
    given_ = [t.clone().requires_grad_() for t in (one.means, one.log_scales, one.quaternions, matrix, place)]
    assert torch.autograd.gradcheck(both, given_)


@settings(deadline=None, max_examples=many(50))
@given(SEEDS)
def test_quaternions_and_rotations(seed: int) -> None:
    turns = rotations(random_gaussians(8, seed).quaternions)
    torch.testing.assert_close(turns @ turns.mT, torch.eye(3, dtype=torch.float64).expand(8, 3, 3))
    assert (torch.linalg.det(turns) > 0.0).all()
    torch.testing.assert_close(rotations(quaternions_from(turns)), turns)


@pytest.mark.parametrize("axis", range(3))
def test_half_turns_have_quaternions(axis: int) -> None:
    signs = -torch.ones(3, dtype=torch.float64)
    signs[axis] = 1.0
    turn = torch.diag(signs)[None]
    torch.testing.assert_close(rotations(quaternions_from(turn)), turn)


def test_covariances_by_hand() -> None:
    """A quarter turn about z takes x to y."""
    one = random_gaussians(1)
    quarter = torch.tensor([[np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5)]], dtype=torch.float64)
    logs = torch.tensor([[2.0, 3.0, 5.0]], dtype=torch.float64).log()
    turned = type(one)(one.means, logs, quarter, one.opacity_logits, one.colors)
    torch.testing.assert_close(turned.covariances[0], torch.diag(torch.tensor([9.0, 4.0, 25.0], dtype=torch.float64)))


def test_posed_gaussians_are_gaussians_again() -> None:
    """Mirrored and sheared ones too."""
    matrix = torch.tensor([[-1.0, 0.5, 0.0], [0.0, 2.0, 0.3], [0.0, 0.0, 0.7]], dtype=torch.float64)
    moved = apply_pose(random_gaussians(20), matrix, torch.ones(3, dtype=torch.float64))
    again = gaussians_from(moved)
    torch.testing.assert_close(again.covariances, moved.covariances)
    torch.testing.assert_close(again.opacities, moved.opacities)


def test_parts_and_whole() -> None:
    splats = splats_of(random_gaussians(10))
    again = concatenate_splats([splats.take(slice(0, 4)), splats.take(torch.arange(4, 10))])
    assert again.covariances.equal(splats.covariances)
    assert len(random_gaussians(10).take(torch.arange(10) < 3)) == 3
    one = random_gaussians(10)
    both = concatenate_gaussians([one.take(slice(0, 4)), one.take(slice(4, 10))])
    assert both.quaternions.equal(one.quaternions)
    assert both.colors.equal(one.colors)
