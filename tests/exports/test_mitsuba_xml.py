"""Mitsuba XML, loaded by Mitsuba and compared with ``flatten`` and with final pictures."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from exports.oracle import example
from scenelang.backends.base import BackendOptions
from scenelang.backends.mitsuba_export.mitsuba_xml import MITSUBA_XML
from scenelang.interpreter.scene.bounds import entity_box
from scenelang.interpreter.scene.entity import Scene
from scenelang.interpreter.scene.flatten import flatten


def loaded(scene: Scene, path: Path, **settings: Any) -> Any:
    import mitsuba as mi

    MITSUBA_XML.run(scene, path, BackendOptions(settings={k.replace("_", "-"): v for k, v in settings.items()}))
    mi.set_variant("scalar_rgb")
    return mi.load_file(str(path))


def box_of(mi_scene: Any) -> np.ndarray:
    """The box of all shapes but light and ground."""
    boxes = [shape.bbox() for shape in mi_scene.shapes() if shape.class_name() == "Instance" or shape.is_mesh()]
    return np.array([np.min([b.min for b in boxes], axis=0), np.max([b.max for b in boxes], axis=0)]).ravel()


@pytest.mark.parametrize(
    ("name", "settings"),
    [
        ("jenga.scene", {}),
        ("nesting-dolls.scene", {}),
        ("moai.scene", {"depth": 1}),
        ("menger-sponge.scene", {"instance_limit": 500}),
    ],
)
def test_bounds_and_counts(name: str, settings: dict[str, Any], tmp_path: Path) -> None:
    scene = example(name)
    made = loaded(scene, tmp_path / "a.xml", **settings)
    instances = [shape for shape in made.shapes() if shape.class_name() == "Instance"]
    if not settings:
        assert len(instances) == len(flatten(scene).frames[0])
    if "instance_limit" in settings:
        assert len(instances) == 400
    assert box_of(made) == pytest.approx(entity_box(scene.root), abs=0.01)  # Mitsuba turns boxes of groups


def test_what_is_hit_where(make: Any, tmp_path: Path) -> None:
    """Rays from all sides meet the same distances as with the surfaces of ``flatten``."""
    import mitsuba as mi
    import trimesh

    scene = make.odd()
    made = loaded(scene, tmp_path / "a.xml")
    from exports.oracle import expected
    from scenelang.backends.exports.plan import surface_of

    parts = []
    for one in expected(scene, 0, 192):
        surface = surface_of(one.entity, 192)
        assert surface is not None
        parts.append(trimesh.Trimesh(one.vertices, surface.faces, process=False))
    mesh = trimesh.util.concatenate(parts)
    rng = np.random.default_rng(0)
    chosen = mesh.triangles_center[rng.integers(len(mesh.faces), size=60)]
    hits = 0
    for target in chosen:
        origin = target + rng.normal(size=3) * 8.0
        direction = (target - origin) / np.linalg.norm(target - origin)
        found = made.ray_intersect(mi.Ray3f(origin.tolist(), direction.tolist()))
        assert found.is_valid()
        assert found.t <= np.linalg.norm(target - origin) + 0.02
        hits += abs(found.t - np.linalg.norm(target - origin)) < 0.02
    assert hits > 15  # the others are behind something


def test_it_draws_what_final_pictures_show(tmp_path: Path) -> None:
    import mitsuba as mi

    scene = example("strict.scene")
    made = loaded(scene, tmp_path / "a.xml")
    sensor = made.sensors()[0]
    film = mi.traverse(sensor)
    film["film.size"] = [80, 60]
    film.update()
    picture = np.array(mi.render(made, spp=32))
    from scenelang.backends.base import find

    final = find("mitsuba")
    final.run(scene, tmp_path / "b.exr", _picture_options())
    wanted = np.array(mi.Bitmap(str(tmp_path / "b.exr")).convert(mi.Bitmap.PixelFormat.RGB))
    near = np.s_[20:45, 20:60]  # where the light on the ground, which falls off in pictures alone, is all there
    assert np.abs(picture[near].mean(axis=(0, 1)) - wanted[near].mean(axis=(0, 1))).max() < 0.03


def _picture_options() -> Any:
    from scenelang.backends.pictures.film import PictureOptions

    return PictureOptions(width=80, height=60, settings={"samples": 32, "denoise": "off"})
