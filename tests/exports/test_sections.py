"""Exports of scenes that are cut open, by `--section`."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support import evaluate

from exports.gltf_reader import Gltf
from scenelang.backends.base import BackendOptions
from scenelang.backends.exports.gltf import GLTF
from scenelang.backends.exports.mesh_files import STL
from scenelang.backends.exports.svg import SVG
from scenelang.backends.surfaces.appearance import look_of
from scenelang.backends.surfaces.cuts import cut, planes_of
from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.scene.entity import descendants

BALL = '(bind "ball" (lambda () (call "sphere" :radius 1 :color [.8 .2 .1])))'


def area_at(path: Path, axis: int, place: float) -> float:
    """The area of the triangles of an STL file in a plane across an axis."""
    kind = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("rest", "<u2")])
    corners = np.frombuffer(path.read_bytes()[84:], kind)["corners"].astype(float)
    flat = corners[(np.abs(corners[:, :, axis] - place) < 1e-5).all(axis=1)]
    return float(np.linalg.norm(np.cross(flat[:, 1] - flat[:, 0], flat[:, 2] - flat[:, 0]), axis=1).sum() / 2.0)


@pytest.mark.parametrize(("section", "axis", "place"), [("x=.6", 0, 0.6), ("-y=25%", 1, -0.5), ("z=0", 2, 0.0)])
def test_a_section_is_filled(section: str, axis: int, place: float, tmp_path: Path) -> None:
    STL.run(evaluate(BALL), tmp_path / "a.stl", BackendOptions(settings={"section": section}))
    assert area_at(tmp_path / "a.stl", axis, place) == pytest.approx(np.pi * (1.0 - place**2), rel=2e-3)


def test_the_side_that_is_named_is_left(tmp_path: Path) -> None:
    scene = evaluate(BALL)
    for section, low, high in (("x=.6", -1.0, 0.6), ("-x=.6", 0.6, 1.0)):
        GLTF.run(scene, tmp_path / "a.glb", BackendOptions(settings={"section": section}))
        x = np.concatenate([one.vertices for one in Gltf(tmp_path / "a.glb").seen()])[:, 0]
        assert [x.min(), x.max()] == pytest.approx([low, high], abs=1e-3)


def test_every_frame_is_cut(tmp_path: Path) -> None:
    moving = '(bind "b" (lambda () (frames (map (lambda (k) (transform (call "cube") (translate (vector k 0 0)))) (range 3)))))'
    GLTF.run(evaluate(moving), tmp_path / "a.glb", BackendOptions(settings={"section": "y=0"}))
    document = Gltf(tmp_path / "a.glb")
    for frame in range(3):
        points = np.concatenate([one.vertices for one in document.seen(frame / 24.0)])
        assert points[:, 1].max() == pytest.approx(0.0, abs=1e-6)
        assert points[:, 0].mean() == pytest.approx(frame, abs=1e-5)


@pytest.mark.parametrize(
    "given", [':texture "brick"', ':texture (texture "checker" :turn 30)', ':texture "wood" :color [.2 .3 .9]']
)
def test_a_texture_keeps_its_size_and_its_colors(given: str) -> None:
    """They follow from the size and the color of the whole, of which a part is left."""
    scene = evaluate(f'(bind "box" (lambda () (call "cube" :scale [4 1 1] {given})))')
    (whole,) = [look_of(entity) for entity in descendants(scene.root) if entity.is_primitive]
    parts = [look_of(entity) for entity in descendants(cut(scene, planes_of("x=-1.5")).root) if entity.is_primitive]
    assert [part for part in parts if part.texture is not None] == [whole]


def test_an_svg_takes_a_share_too_and_one_plane(tmp_path: Path) -> None:
    scene = evaluate(BALL)
    for section in ("y=0", "y=50%"):
        SVG.run(scene, tmp_path / f"{section}.svg", BackendOptions(settings={"section": section}))
    assert (tmp_path / "y=0.svg").read_text() == (tmp_path / "y=50%.svg").read_text()
    for wrong in ("x=0,y=0", "-x=0"):
        with pytest.raises(SceneError, match="one plane"):
            SVG.run(scene, tmp_path / "a.svg", BackendOptions(settings={"section": wrong}))


def test_what_cannot_be(tmp_path: Path) -> None:
    scene = evaluate(BALL)
    for settings, message in (
        ({"section": "x=0", "solid": True}, "opens bodies"),
        ({"section": "w=2"}, "no section"),
        ({"section": "x=9", "frame": None}, ""),
        ({"section": "-x=9"}, "leaves nothing"),
    ):
        given = {name: value for name, value in settings.items() if name != "frame"}
        if not message:
            GLTF.run(scene, tmp_path / "a.glb", BackendOptions(settings=given))
            continue
        with pytest.raises(SceneError, match=message):
            GLTF.run(scene, tmp_path / "b.glb", BackendOptions(settings=given))
    assert [path.name for path in tmp_path.iterdir()] == ["a.glb"]
