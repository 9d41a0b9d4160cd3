"""Sections against closed forms: areas and volumes of cut solids, and what is kept, removed and filled."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from support import evaluate

import scenelang as sl
from scenelang.backends.surfaces.cuts import CutPlane, CutSurface, cut, planes_of
from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.scene.entity import Scene, descendants
from scenelang.interpreter.scene.flatten import flatten
from scenelang.interpreter.scene.primitives.mesh import areas_of

BALL = '(bind "it" (lambda () (call "sphere" :radius 1 :color [.8 .2 .1])))'


def surfaces(scene: Scene) -> list[tuple[np.ndarray, tuple[float, float, float]]]:
    """The world triangles and the color of each cut surface, in the order of the tree."""
    (frame,) = flatten(scene).frames
    found = []
    for index, matrix in zip(frame.index, frame.matrices, strict=True):
        shape = frame.primitives[index].shape
        if isinstance(shape, CutSurface):
            corners = shape.surface.corners @ matrix[:, :3].T + matrix[:, 3]
            found.append((corners, shape.color))
    return found


def volume(corners: np.ndarray) -> float:
    return float(np.einsum("ni,ni->n", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum() / 6.0)


def test_a_small_solid_in_a_large_scene_is_cut_through_its_middle() -> None:
    """The faces of nested solids are cut a little later each; the step was larger than a small solid."""
    text = '(union (call "sphere" :radius .02) (transform (call "cube" :scale 9) (translate [30 0 0])))'
    (ball, _), *_ = surfaces(cut(evaluate(f'(bind "it" (lambda () {text}))'), planes_of("z=0")))
    assert abs(ball[:, :, 2].max()) < 0.02 * 0.04


@pytest.mark.parametrize(("text", "height"), [("x=0.5", 1.5), ("-x=0.5", 0.5), ("z=75%", 1.5), ("y=-0.5", 0.5)])
def test_a_cut_ball_has_the_volume_of_its_cap(text: str, height: float) -> None:
    (ball, _), (face, _) = surfaces(cut(evaluate(BALL), planes_of(text)))
    expected = math.pi * height**2 * (3.0 - height) / 3.0
    assert volume(np.concatenate([ball, face])) == pytest.approx(expected, rel=2e-3)
    assert areas_of(face).sum() == pytest.approx(math.pi * 0.75, rel=2e-3)


def test_two_planes_remove_a_corner() -> None:
    scene = evaluate('(bind "it" (lambda () (call "cube" :scale 2)))')
    (cube, _), (face, _) = surfaces(cut(scene, planes_of("x=0,z=50%")))
    assert volume(np.concatenate([cube, face])) == pytest.approx(6.0)
    assert areas_of(face).sum() == pytest.approx(4.0)


def test_the_filling_is_darker_and_as_red() -> None:
    (_, color), (_, filling) = surfaces(cut(evaluate(BALL), planes_of("x=0")))
    assert color == (0.8, 0.2, 0.1)
    assert sum(filling) < 0.6 * sum(color)
    assert filling[0] / sum(filling) >= color[0] / sum(color)


def test_what_the_plane_misses_stays_itself() -> None:
    program = """
    (bind "far" (lambda () (call "sphere" :radius .2)))
    (bind "it" (lambda () (union (transform (call "far") (translate [-2 0 0])) (transform (call "far") (translate [2 0 0]))
                                 (call "cube"))))"""
    scene = evaluate(program)
    left = cut(scene, planes_of("x=0"))
    words = [entity.word for entity in descendants(left.root)]
    assert words.count("far") == 1
    assert any(entity is scene.root.children[0].car for entity in descendants(left.root))
    low, high = sl.Scene(left).bounds
    assert low[0] == pytest.approx(-2.2)
    assert high[0] == pytest.approx(0.0, abs=1e-6)


def test_poses_are_followed() -> None:
    program = """(bind "it" (lambda () (transform (call "cube" :scale [4 1 1])
      (@ (translate [0 0 3]) (rotate (/ pi 2) [0 1 0])))))"""
    scene = evaluate(program)
    (body, _), (face, _) = surfaces(cut(scene, planes_of("z=2")))
    assert volume(np.concatenate([body, face])) == pytest.approx(1.0)
    assert body[:, :, 2].max() <= 2.0 + 1e-9


def test_an_open_mesh_and_a_flat_one_have_no_filling() -> None:
    flat = evaluate('(bind "it" (lambda () (call "cube" :scale [1 0 1])))')
    ((sheet, _),) = surfaces(cut(flat, planes_of("x=0.25")))
    assert areas_of(sheet).sum() == pytest.approx(1.5)


@pytest.mark.parametrize("inner", ['(call "sphere" :radius .5 :color [0 0 1])',
                                   '(transform (call "sphere" :color [0 0 1]) (scale .5))'])  # fmt: skip
@pytest.mark.parametrize("is_first", [True, False])
def test_nested_solids_show_the_inner_face_before_the_outer(inner: str, is_first: bool) -> None:
    outer = '(call "sphere" :color [1 0 0])'
    both = f"{inner} {outer}" if is_first else f"{outer} {inner}"
    program = f'(bind "it" (lambda () (union {both})))'
    image = sl.Scene(cut(evaluate(program), planes_of("z=0"))).render(
        sl.Camera(azimuth=0, elevation=0), size=(64, 64), environment="flat", ground="none"
    )
    middle, ring = image.pixels[32, 32, :3].astype(int), image.pixels[32, 54, :3].astype(int)
    assert middle[2] > middle[0] + 50
    assert ring[0] > ring[2] + 50


def test_a_computed_solid_is_cut_in_its_colors() -> None:
    program = """(bind "it" (lambda () (solid-union (call "cube" :color [1 0 0])
      (transform (call "cube" :color [0 1 0]) (translate [1 0 0])))))"""
    (body, _), (face, _) = surfaces(cut(evaluate(program), planes_of("y=0")))
    assert volume(np.concatenate([body, face])) == pytest.approx(1.0)
    leaf = next(
        e for e in descendants(cut(evaluate(program), planes_of("y=0")).root) if isinstance(e.shape, CutSurface)
    )
    assert len(np.unique(leaf.shape.surface.colors, axis=0)) == 2


def test_smooth_normals_stay_smooth() -> None:
    left = cut(evaluate(BALL), planes_of("x=0.3"))
    mesh = next(entity.shape.surface for entity in descendants(left.root) if isinstance(entity.shape, CutSurface))
    assert mesh.normals is not None
    assert np.abs(mesh.normals - mesh.vertices).max() < 0.01  # of a unit ball at the origin


@pytest.mark.parametrize("text", ["", "x", "x=", "w=1", "x=1e999", "x=nan", "x=0,x=1", "x=0.2%%", "-", "x=1;y=2"])
def test_no_section(text: str) -> None:
    with pytest.raises(SceneError) as caught:
        planes_of(text)
    assert caught.value.hint


def test_planes() -> None:
    assert planes_of("x=0.2,-y=50%") == (CutPlane(0, 0.2), CutPlane(1, 0.5, True, True))


def test_nothing_left_is_an_error() -> None:
    with pytest.raises(SceneError, match="leaves nothing"):
        cut(evaluate(BALL), planes_of("x=-5"))


def test_a_plane_beside_the_scene_changes_nothing() -> None:
    scene = evaluate(BALL)
    assert cut(scene, planes_of("x=50")).root is scene.root


def test_meshes_of_a_section_are_exported_and_data_is_refused(tmp_path: Path) -> None:
    half = sl.Scene(evaluate(BALL)).cut("x=0")
    half.export(tmp_path / "a.obj")
    places = [
        list(map(float, line.split()[1:4]))
        for line in (tmp_path / "a.obj").read_text().splitlines()
        if line[:2] == "v "
    ]
    assert max(place[0] for place in places) == pytest.approx(0.0, abs=1e-6)
    assert min(place[0] for place in places) == pytest.approx(-1.0)
    with pytest.raises(SceneError, match="what a section left"):
        half.export(tmp_path / "a.json")
    assert not (tmp_path / "a.json").exists()
    for name, program in (("b", BALL), ("c", '(bind "it" (lambda () (call "cube" :scale 2)))')):
        sl.Scene(evaluate(program)).exploded(1.0).export(tmp_path / f"{name}.json")
