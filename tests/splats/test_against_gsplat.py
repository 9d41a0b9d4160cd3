"""Projection, dilation and cut-offs are gsplat's: compared with its own torch implementation and the kernels' text."""

from __future__ import annotations

import re
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from later import later

from scenelang.backends.neural.splats import gaussians
from scenelang.backends.neural.splats.gaussians import Splats, project, view_of
from splats.drawing import a_camera, random_gaussians, splats_of

torch = later("torch")

if find_spec("gsplat") is None:
    pytest.skip("gsplat is not installed", allow_module_level=True)


@pytest.fixture(scope="module")
def theirs() -> Any:
    from gsplat.cuda import _torch_impl  # type: ignore[import-not-found, unused-ignore]

    return _torch_impl


def test_covariances_are_gsplats(theirs: Any) -> None:
    gaussians = random_gaussians(50)
    covariances, _ = theirs._quat_scale_to_covar_preci(gaussians.quaternions, gaussians.log_scales.exp())
    torch.testing.assert_close(gaussians.covariances, covariances)


@pytest.mark.parametrize("orthographic", [False, True])
@pytest.mark.parametrize("near", [False, True])
def test_the_projection_is_gsplats(theirs: Any, orthographic: bool, near: bool) -> None:
    """Also where the camera stands among the splats, so that some lie behind it or far outside the picture."""
    more = {"distance": 0.5, "fov": 70.0, "target": (0.0, 0.0, 0.0)} if near else {}
    camera = a_camera(90, 60, orthographic=orthographic, **more)
    one = splats_of(random_gaussians(400, seed=3))
    opaque = Splats(one.means, one.covariances, torch.ones(400, dtype=torch.float64), one.colors)
    view = view_of(camera, one.means)
    radii, centers, depths, conics, compensations = theirs._fully_fused_projection(
        one.means,
        one.covariances,
        view.world_to_camera[None],
        view.intrinsics[None],
        90,
        60,
        eps2d=gaussians.EPS2D,
        near_plane=gaussians.NEAR,
        far_plane=gaussians.FAR,
        calc_compensations=True,
        camera_model="ortho" if orthographic else "pinhole",
    )
    seen = project(opaque, view)
    at = seen.index
    more_seen = set((radii[0] > 0).all(-1).nonzero()[:, 0].tolist()) - set(at.tolist())
    assert not set(at.tolist()) - set((radii[0] > 0).all(-1).nonzero()[:, 0].tolist())
    size = torch.tensor([90.0, 60.0])
    for i in more_seen:  # theirs reaches 3.33 deviations, ours to where 1/255 is left: at most a pixel less
        center, reach = centers[0][i], radii[0][i] - 1
        assert ((center + reach <= 0.0) | (center - reach >= size)).any()
    torch.testing.assert_close(seen.centers, centers[0][at])
    torch.testing.assert_close(seen.depths, depths[0][at])
    torch.testing.assert_close(seen.conics, conics[0][at])
    fewer = radii[0][at].double() - seen.radii
    assert ((fewer == 0.0) | (fewer == 1.0)).all()
    assert (fewer == 0.0).double().mean() > 0.9
    assert (depths[0][at].diff() >= 0.0).all()
    thinned = project(one, view, antialiased=True)
    expected = one.opacities[thinned.index] * compensations[0][thinned.index]
    torch.testing.assert_close(thinned.opacities, expected)


def test_the_cut_offs_are_those_of_gsplats_kernels() -> None:
    found = find_spec("gsplat")
    assert found is not None
    assert found.origin is not None
    cuda = Path(found.origin).parent / "cuda"
    kernel = (cuda / "csrc" / "RasterizeToPixels3DGSFwd.cu").read_text()
    fused = (cuda / "csrc" / "ProjectionEWA3DGSFused.cu").read_text()
    least = re.search(r"ALPHA_THRESHOLD \((.+?)f / (.+?)f\)", (cuda / "include" / "Common.h").read_text())
    most, done = re.search(r"min\((0\.\d+)f, opac", kernel), re.search(r"next_T <= (1e-\d+)f", kernel)
    reach = re.search(r"extend = (3\.\d+)f", fused)
    assert least is not None
    assert most is not None
    assert done is not None
    assert reach is not None
    assert float(least[1]) / float(least[2].rstrip(".")) == gaussians.MIN_ALPHA
    assert float(most[1]) == gaussians.MAX_ALPHA
    assert float(done[1]) == gaussians.MIN_TRANSMITTANCE
    assert float(reach[1]) == gaussians._CUTOFF
    assert "sqrt(2.0f * __logf(opacity / ALPHA_THRESHOLD))" in fused


def test_radii_shrink_with_the_opacity() -> None:
    """To where the splat hides 1/255 of a pixel: half the deviations for the square root of the contrast."""
    one = splats_of(random_gaussians(50, seed=8))
    view = view_of(a_camera(400, 400), one.means)
    seen = project(one, view)
    a, b, c = seen.conics.unbind(-1)
    widths = (c / (a * c - b * b)).sqrt()
    expected = np.sqrt(2.0 * np.log(255.0 * seen.opacities.numpy())) * widths.numpy()
    np.testing.assert_array_equal(seen.radii[:, 0].numpy(), np.ceil(expected))
