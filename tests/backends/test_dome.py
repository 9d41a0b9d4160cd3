"""The dome around a scene: its directions, its blurs and its light, against closed forms and Mitsuba."""

from __future__ import annotations

import numpy as np
import pytest

from scenelang.backends.surfaces.dome import UNIFORM, Dome, Panorama, Sky, Softbox, directions_of, panorama_of
from scenelang.backends.surfaces.environments import ENVIRONMENTS, studio_for

UP, DOWN = np.array([[0.0, 1.0, 0.0]]), np.array([[0.0, -1.0, 0.0]])


def random_directions(count: int = 500) -> np.ndarray:
    directions = np.random.default_rng(0).normal(size=(count, 3))
    return directions / np.linalg.norm(directions, axis=1, keepdims=True)


def test_a_uniform_dome_is_uniform_in_every_way() -> None:
    dome, at = Dome(panorama_of(UNIFORM, (0.5, 0.6, 0.7)), 33.0), random_directions()
    assert np.allclose(dome.radiance(at), [0.5, 0.6, 0.7])
    assert np.allclose(dome.radiance(at, np.linspace(0.0, 1.0, len(at))), [0.5, 0.6, 0.7])
    assert np.allclose(dome.irradiance(at, above=False), [0.5, 0.6, 0.7], atol=5e-3)
    # The upper half lights a surface by (1 + cos) / 2 of what the whole dome does.
    share = 0.5 + 0.5 * at[:, 1:2]
    assert np.allclose(dome.irradiance(at, above=True), share * [0.5, 0.6, 0.7], atol=8e-3)


@pytest.mark.parametrize("name", list(ENVIRONMENTS))
def test_an_environment_lights_the_ground_as_its_ambient_light_says(name: str) -> None:
    chosen = ENVIRONMENTS[name]
    dome = Dome(panorama_of(chosen.sky, chosen.ambient))
    assert np.allclose(dome.irradiance(UP, above=True), chosen.ambient, rtol=0.02)


def test_a_linear_gradient_has_the_irradiance_of_its_integral() -> None:
    height = directions_of(64)[:, :, 1:2]
    dome = Dome(Panorama(np.repeat(np.maximum(height, 0.0), 3, axis=2)))
    assert np.allclose(dome.irradiance(UP, above=False), 2.0 / 3.0, rtol=0.01)  # 2 * integral of c^2 over [0, 1]
    assert np.allclose(dome.irradiance(DOWN, above=False), 0.0, atol=0.01)


def test_softboxes_are_where_their_angles_say_and_turn_with_the_dome() -> None:
    sky = Sky((0.0,) * 3, (0.0,) * 3, (0.0,) * 3, (Softbox(90.0, 30.0, 10.0, 10.0, (1.0, 1.0, 1.0)),))
    toward = np.array([[np.cos(np.radians(30)), 0.5, 0.0]])  # azimuth 90 is +x
    panorama = panorama_of(sky, (1.0, 1.0, 1.0))
    assert Dome(panorama).radiance(toward)[0, 0] > 1.0
    assert Dome(panorama, 90.0).radiance(toward)[0, 0] == 0.0
    assert Dome(panorama, -90.0).radiance(np.array([[0.0, 0.5, np.cos(np.radians(30))]]))[0, 0] > 1.0


def test_a_blur_keeps_the_light_and_spreads_it() -> None:
    dome = Dome(panorama_of(ENVIRONMENTS["studio"].sky, (1.0, 1.0, 1.0)))
    at = directions_of(24).reshape(-1, 3)
    weight = np.sin(np.arccos(at[:, 1]))[:, None]
    spread = []
    for roughness in (0.0, 0.3, 0.7, 1.0):
        seen = dome.radiance(at, np.full(len(at), roughness))
        assert (seen * weight).sum() / weight.sum() == pytest.approx(
            (dome.radiance(at) * weight).sum() / weight.sum(), rel=0.03
        )
        spread.append(seen.std())
    assert spread == sorted(spread, reverse=True)


def test_mitsuba_sees_the_same_dome() -> None:
    mi = pytest.importorskip("mitsuba")
    mi.set_variant("scalar_rgb")
    from scenelang.backends.pictures.mitsuba_scene import around

    dome = studio_for(np.array([0.8, 0.0, 0.6]), "studio").dome
    emitter = mi.load_dict({"type": "envmap", "bitmap": mi.Bitmap(around(dome))})
    at, hit = random_directions(), mi.SurfaceInteraction3f()
    seen = []
    for direction in at:
        hit.wi = mi.Vector3f(*(-direction))
        seen.append(np.array(emitter.eval(hit)))
    assert np.abs(np.array(seen) - dome.radiance(at)).mean() < 2e-3


def test_the_studio_turns_with_the_camera() -> None:
    """A softbox that one camera sees ahead, to its right and above, another sees there, too."""
    for azimuth in (0.0, 40.0, 200.0):
        a = np.radians(azimuth)
        right, back = np.array([np.cos(a), 0.0, -np.sin(a)]), np.array([np.sin(a), 0.0, np.cos(a)])
        dome = studio_for(right, "studio").dome
        seen = [
            dome.radiance((x * right + y * np.array([0.0, 1.0, 0.0]) + z * back)[None])
            for x, y, z in ((1.0, 0.0, 0.0), (0.6, 0.8, 0.0), (0.0, 0.6, 0.8))
        ]
        if azimuth == 0.0:
            first = seen
        assert np.allclose(seen, first, atol=1e-6)
