"""Materials conserve energy: in a white furnace a white surface looks like what is around it.

The oracle is closed: whatever the shape, a surface that absorbs nothing is invisible in uniform light.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from scenelang.backends.pictures.mitsuba_materials import kind_of, surface
from scenelang.backends.surfaces.appearance import Look

mi = pytest.importorskip("mitsuba")

WHITE = (1.0, 1.0, 1.0)
ROUGHNESS = (0.0, 0.25, 0.4, 0.5, 0.6, 0.75, 0.9, 1.0)


def furnace(look: Look, samples: int = 300, size: int = 16) -> tuple[float, float]:
    """Return the mean radiance of a sphere in uniform light of radiance 1, and that of its middle."""
    mi.set_variant("scalar_rgb")
    mi.set_log_level(mi.LogLevel.Error)
    film = {"type": "hdrfilm", "width": size, "height": size, "rfilter": {"type": "box"}}
    scene: dict[str, Any] = {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": 60, "rr_depth": 60},
        "around": {"type": "constant", "radiance": 1.0},
        "ball": {"type": "sphere", "bsdf": surface(look)},
        "sensor": {
            "type": "orthographic",
            "film": film,
            "to_world": mi.ScalarTransform4f().look_at(origin=[0, 0, 5], target=[0, 0, 0], up=[0, 1, 0]),
        },
    }
    seen = np.array(mi.render(mi.load_dict(scene), spp=samples))[:, :, :3].mean(axis=2)
    row, column = np.mgrid[0:size, 0:size]
    away = np.hypot((row + 0.5) / size * 2 - 1, (column + 0.5) / size * 2 - 1)
    return float(seen[away < 0.97].mean()), float(seen[away < 0.4].mean())


@pytest.mark.parametrize("roughness", ROUGHNESS)
@pytest.mark.parametrize("metallic", [0.0, 0.5, 1.0])
def test_a_white_surface_returns_all_light(metallic: float, roughness: float) -> None:
    whole, middle = furnace(Look(WHITE, roughness=roughness, metallic=metallic))
    assert whole == pytest.approx(1.0, abs=0.03)
    assert middle == pytest.approx(1.0, abs=0.03)


@pytest.mark.parametrize("ior", [1.0, 1.33, 2.0, 4.0])
@pytest.mark.parametrize("roughness", [0.1, 0.5, 0.9])
def test_whatever_the_index_of_refraction(ior: float, roughness: float) -> None:
    assert furnace(Look(WHITE, roughness=roughness, ior=ior))[0] == pytest.approx(1.0, abs=0.03)


@pytest.mark.parametrize("ior", [1.33, 1.5, 2.0])
@pytest.mark.parametrize("roughness", [0.0, 0.25, 0.5, 0.75, 1.0])
def test_glass_returns_nine_tenths_or_more(ior: float, roughness: float) -> None:
    whole, middle = furnace(Look((1.0, 1.0, 1.0), roughness=roughness, ior=ior, opacity=0.0))
    assert whole == pytest.approx(1.0, abs=0.1)
    assert middle == pytest.approx(1.0, abs=0.15)


@pytest.mark.parametrize("look", [
    Look(WHITE, coat=1.0), Look(WHITE, sheen=1.0), Look(WHITE, roughness=0.5, metallic=1.0, coat=1.0, sheen=0.5),
])  # fmt: skip
def test_varnish_and_fabric_add_no_light(look: Look) -> None:
    assert furnace(look)[0] == pytest.approx(1.0, abs=0.03)


def test_a_rough_metal_keeps_its_color() -> None:
    rough, smooth = (furnace(Look((0.5, 0.5, 0.5), roughness=r, metallic=1.0))[0] for r in (1.0, 0.0))
    assert smooth == pytest.approx(0.5, abs=0.01)
    assert 0.5 * smooth < rough < smooth  # darker, because light that bounces twice is absorbed twice


def test_what_one_mesh_shares_is_its_kind() -> None:
    red = Look((1.0, 0.0, 0.0), opacity=0.5, roughness=0.3, material="plastic")
    assert kind_of(red) == kind_of(Look((0.0, 1.0, 0.0), roughness=0.3))
    assert kind_of(red) != kind_of(Look((1.0, 0.0, 0.0), roughness=0.4))
    assert kind_of(Look((1.0, 1.0, 1.0), opacity=0.2, ior=1.5)).opacity == 0.2
