"""Pictures of splats: equal to the definition, whatever works them out, and so are the derivatives."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from later import later

from scenelang.backends.neural.splats import rasterise_numba, rasterise_torch
from scenelang.backends.neural.splats.gaussians import Splats, view_of
from scenelang.backends.neural.splats.rasterise import (
    EntityLabels,
    RasterisedImage,
    engine_for,
    rasterise,
    rasterise_by,
)
from scenelang.grammar.diagnostics import LimitError
from splats.drawing import a_camera, directly, random_gaussians, splats_of

torch = later("torch")


def engines() -> list[Any]:
    numba = pytest.param(rasterise_numba, id="numba", marks=pytest.mark.skipif(not has_numba(), reason="no numba"))
    return [pytest.param(rasterise_torch, id="torch"), numba]


def has_numba() -> bool:
    from importlib.util import find_spec

    return find_spec("numba") is not None


def drawn_by(engine: Any, splats: Splats, camera: Any, **more: Any) -> RasterisedImage:
    return rasterise_by(engine, splats, view_of(camera, splats.means), **more)


@pytest.mark.parametrize("engine", engines())
@pytest.mark.parametrize("antialiased", [False, True])
@pytest.mark.parametrize("orthographic", [False, True])
@pytest.mark.sampled(3)
def test_a_picture_is_the_definition(engine: Any, antialiased: bool, orthographic: bool) -> None:
    splats = splats_of(random_gaussians(60, seed=4))
    camera = a_camera(37, 29, orthographic=orthographic)
    color, alpha, depth = directly(splats, camera, antialiased)
    drawn = drawn_by(engine, splats, camera, antialiased=antialiased)
    np.testing.assert_allclose(drawn.color.numpy(), color, atol=1e-10)
    np.testing.assert_allclose(drawn.alpha.numpy(), alpha, atol=1e-10)
    np.testing.assert_allclose(drawn.depth.numpy(), depth, atol=1e-9)
    assert alpha.max() > 0.9


@pytest.mark.parametrize("engine", engines())
def test_near_and_wide_ones_are_as_defined(engine: Any) -> None:
    """The camera stands among them: some lie behind it, some far outside the picture, some fill it; many opaque."""
    one = random_gaussians(80, seed=5, size=0.3)
    splats = splats_of(type(one)(one.means, one.log_scales, one.quaternions, one.opacity_logits + 4.0, one.colors))
    camera = a_camera(33, 21, distance=0.4, fov=80.0, target=(0.0, 0.0, 0.0))
    color, alpha, _ = directly(splats, camera)
    drawn = drawn_by(engine, splats, camera)
    np.testing.assert_allclose(drawn.color.numpy(), color, atol=1e-10)
    np.testing.assert_allclose(drawn.alpha.numpy(), alpha, atol=1e-10)
    assert (alpha > 0.9998).any()


@pytest.mark.parametrize("engine", engines())
@pytest.mark.sampled(2)
def test_derivatives(engine: Any) -> None:
    """By means, covariances, opacities and colors, of color, alpha, depth and the entities' weights."""
    splats = splats_of(random_gaussians(6, seed=11, size=0.3))
    members = EntityLabels(torch.tensor([0, 1, 2, 0, 1, 2]), 3)
    camera = a_camera(7, 6)

    def picture(means: Any, spread: Any, opacities: Any, colors: Any) -> tuple[Any, ...]:
        even = (spread + spread.mT) / 2.0
        drawn = drawn_by(engine, Splats(means, even, opacities, colors), camera, labels=members)
        return drawn.color, drawn.alpha, drawn.depth, drawn.weights

    columns = (splats.means, splats.covariances, splats.opacities.clamp(0.1, 0.9), splats.colors)
    given = [column.clone().requires_grad_() for column in columns]
    assert torch.autograd.gradcheck(picture, given, eps=1e-7, atol=1e-5)


@pytest.mark.parametrize("antialiased", [False, True])
@pytest.mark.parametrize("dtype", ["float32", "float64"])
@pytest.mark.skipif(not has_numba(), reason="no numba")
def test_numba_and_torch_are_equal(antialiased: bool, dtype: str) -> None:
    kind = getattr(torch, dtype)
    within = 1e-10 if dtype == "float64" else 3e-4
    one = random_gaussians(500, seed=7, dtype=kind)
    splats = splats_of(type(one)(one.means, one.log_scales, one.quaternions, one.opacity_logits + 1.0, one.colors))
    members = EntityLabels(torch.arange(500) % 4, 4)
    camera = a_camera(61, 47)
    found = []
    for engine in (rasterise_torch, rasterise_numba):
        given = [c.detach().clone().requires_grad_() for c in (splats.means, splats.covariances, splats.opacities)]
        colors = splats.colors.clone().requires_grad_()
        drawn = drawn_by(engine, Splats(*given, colors), camera, antialiased=antialiased, labels=members)
        parts = (drawn.color, drawn.alpha, drawn.depth, drawn.weights)
        chance = torch.Generator().manual_seed(1)
        loss = sum((part * torch.randn(part.shape, generator=chance, dtype=kind)).sum() for part in parts)
        loss.backward()
        found.append([*parts, *((t.grad / t.grad.abs().max()) for t in (*given, colors))])
    for ours, other in zip(*found, strict=True):
        torch.testing.assert_close(ours, other, rtol=within, atol=within)


@pytest.mark.parametrize("engine", engines())
def test_the_entities_weights_are_the_alpha(engine: Any) -> None:
    splats = splats_of(random_gaussians(40, seed=9))
    number = torch.arange(40) % 3
    camera = a_camera(20, 20)
    drawn = drawn_by(engine, splats, camera, labels=EntityLabels(number, 3))
    assert drawn.weights is not None
    torch.testing.assert_close(drawn.weights.sum(-1), drawn.alpha)
    painted = Splats(splats.means, splats.covariances, splats.opacities, torch.eye(3, dtype=torch.float64)[number])
    torch.testing.assert_close(drawn.weights, drawn_by(engine, painted, camera).color)


@pytest.mark.parametrize("engine", engines())
def test_nothing_to_see_is_an_empty_picture(engine: Any) -> None:
    splats = splats_of(random_gaussians(5))
    camera = a_camera(9, 8)
    for none in (
        splats.take(slice(0, 0)),
        splats.transformed(torch.eye(3, dtype=torch.float64), torch.tensor([0.0, 0, 1e3])),
    ):
        drawn = drawn_by(engine, none, camera)
        assert drawn.color.shape == (8, 9, 3)
        assert not drawn.alpha.any()
        assert not drawn.depth.any()


@pytest.mark.parametrize("engine", engines())
def test_values_that_are_no_numbers_are_not_drawn(engine: Any) -> None:
    splats = splats_of(random_gaussians(6))
    splats.means[0, 0], splats.means[1, 2] = float("nan"), float("inf")
    splats.covariances[2, 0, 0], splats.covariances[3] = float("inf"), 1e300
    splats.opacities[4] = float("nan")
    drawn = drawn_by(engine, splats, a_camera(9, 8))
    assert torch.isfinite(drawn.color).all()


def test_the_engine_fits_the_machine() -> None:
    assert engine_for(torch.device("cpu")) is (rasterise_numba if has_numba() else rasterise_torch)
    assert engine_for(torch.device("cuda")) is rasterise_torch


def test_too_many_weights_are_refused() -> None:
    splats = splats_of(random_gaussians(3))
    view = view_of(a_camera(500, 500), splats.means)
    with pytest.raises(LimitError, match="entities"):
        rasterise(splats, view, labels=EntityLabels(torch.zeros(3, dtype=torch.int64), 100_000))


@pytest.mark.gpu
@pytest.mark.parametrize("antialiased", [False, True])
def test_gsplat_is_equal(antialiased: bool) -> None:
    pytest.importorskip("gsplat")
    if not torch.cuda.is_available():
        pytest.skip("no CUDA device")
    from scenelang.backends.neural.splats.rasterise import composite_on_cuda

    one = splats_of(random_gaussians(2_000, seed=2, dtype=torch.float32))
    found = []
    for own in (True, False):
        columns = [c.detach().cuda().requires_grad_() for c in (one.means, one.covariances, one.opacities, one.colors)]
        splats = Splats(*columns)
        view = view_of(a_camera(160, 120), splats.means)
        if own:
            drawn = rasterise_by(rasterise_torch, splats, view, antialiased)
            color, alpha, depth = drawn.color, drawn.alpha, drawn.depth * drawn.alpha
        else:
            color, depth, alpha = composite_on_cuda(splats, splats.colors, view, antialiased)
        (color.square().sum() + alpha.sum() + depth.sum()).backward()
        spread = columns[1].grad + columns[1].grad.mT  # gsplat's is of the upper triangle
        by = [columns[0].grad, spread, columns[2].grad, columns[3].grad]
        found.append([color, alpha, depth, *(g / g.abs().max() for g in by)])
    for ours, other in zip(*found, strict=True):
        assert (ours - other).abs().quantile(0.999) < 2e-3
