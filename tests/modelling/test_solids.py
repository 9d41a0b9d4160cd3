"""Solids: volumes, provenance of colors and words, exact bounds, sharing, errors, and what every backend makes of them."""

from __future__ import annotations

import itertools
import json
import math
import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import scenelang as sl
from scenelang.files.scene_json import read_scene, write_scene
from scenelang.grammar.diagnostics import LimitError, SceneError
from scenelang.interpreter.scene.bounds import entity_box
from scenelang.interpreter.scene.entity import Scene, count_words, descendants
from scenelang.interpreter.scene.modelling import computing
from scenelang.interpreter.scene.modelling.computing import computed, manifold_of
from scenelang.interpreter.scene.modelling.operations import from_plain, nodes_of, to_plain
from scenelang.interpreter.scene.modelling.solid import SolidShape

CUBE = '(call "cube" :color [.8 .2 .1])'
BALL = '(call "sphere" :radius .6 :color [.1 .2 .9])'


def scene_of(expression: str, before: str = "") -> Scene:
    return sl.evaluate(f'{before}\n(bind "it" (lambda () {expression}))').graph


def value_of(expression: str) -> Any:
    """The number that an expression has, as the size of a cube along x."""
    return entity_box(scene_of(f'(call "cube" :scale [{expression} 1 1])').root)[3] * 2.0  # type: ignore[index]


def solid_in(scene: Scene) -> SolidShape:
    (found,) = [e.shape for e in descendants(scene.root) if isinstance(e.shape, SolidShape)]
    return found


def volume(expression: str) -> float:
    return solid_in(scene_of(expression)).volume()


# --- volumes ---------------------------------------------------------------------------------------------------------


def random_parts(rng: np.random.Generator) -> str:
    """An operand: one of the primitives under a random affine pose, mirrored in half of the cases."""
    word = rng.choice(['(call "cube")', '(call "sphere" :radius .6)', '(call "cylinder" :radius .5)', '(call "torus" :radius .6)',
                       '(call "cone" :radius .6)', '(call "capsule" :radius .4)', '(call "rounded-cube")'])  # fmt: skip
    x, y, z = (round(float(v), 3) for v in rng.uniform(-0.25, 0.25, 3))
    sizes = [round(float(v), 3) for v in rng.uniform(0.6, 1.5, 3)]
    if rng.random() < 0.5:
        sizes[0] = -sizes[0]
    angle = round(float(rng.uniform(0, 6)), 3)
    pose = f"(@ (translate [{x} {y} {z}]) (rotate {angle} [1 {y} 2]) (scale [{sizes[0]} {sizes[1]} {sizes[2]}]))"
    return f"(transform {word} {pose})"


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.sampled(2)
def test_inclusion_and_exclusion(seed: int) -> None:
    rng = np.random.default_rng(seed)
    a, b = random_parts(rng), random_parts(rng)
    both = volume(f"(solid-union {a} {b})")
    shared = volume(f"(intersection {a} {b})")
    assert both + shared == pytest.approx(volume(f"(solid-union {a})") + volume(f"(solid-union {b})"), rel=1e-9)
    assert volume(f"(difference {a} {b})") == pytest.approx(volume(f"(solid-union {a})") - shared, rel=1e-9)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.sampled(2)
def test_de_morgan_on_points(seed: int) -> None:
    rng = np.random.default_rng(100 + seed)
    a, b = random_parts(rng), random_parts(rng)
    box = '(call "cube" :scale 8)'
    left = solid_in(scene_of(f"(difference {box} (solid-union {a} {b}))"))
    right = solid_in(scene_of(f"(intersection (difference {box} {a}) (difference {box} {b}))"))
    points = rng.uniform(-2, 2, (300, 3))
    assert (left.contains(points) == right.contains(points)).all()
    assert left.volume() == pytest.approx(right.volume(), rel=1e-9)


@pytest.mark.parametrize(
    ("expression", "expected"),
    [
        ("(hull (call \"cube\") (transform (call \"cube\") (translate [2 0 0])))", 3.0),
        ("(minkowski (call \"cube\") (call \"cube\" :scale [1 2 3]))", 2.0 * 3.0 * 4.0),
        ("(lathe [[1 0] [2 0] [2 1] [1 1]] :segments 512)", 3.0 * math.pi),
        ("(lathe [[1 0] [2 0] [2 1] [1 1]] :segments 512 :angle (/ pi 2))", 3.0 * math.pi / 4.0),
        ("(extrude [[0 0] [1 0] [0 1]] 4 :taper .5)", 4.0 / 3.0 * (0.5 + 0.25 + 0.125)),
        ("(extrude (list [[0 0] [3 0] [3 3] [0 3]] [[1 1] [1 2] [2 2] [2 1]]) 2)", 16.0),
        ("(cut-plane (call \"cube\" :scale 2) [1 1 0])", 4.0),
        ("(cut-plane (call \"cube\" :scale 2) [0 -3 0] [0 .5 0])", 6.0),
        ("(shell (call \"cube\" :scale 2) .5 :segments 8)", 7.0),
        ("(difference (call \"cube\" :scale 2) (call \"cylinder\" :radius .5 :p0 [0 -2 0] :p1 [0 2 0]) :segments 256)",
         8.0 - math.pi * 0.5),
    ],
)  # fmt: skip
def test_closed_forms(expression: str, expected: float) -> None:
    assert volume(expression) == pytest.approx(expected, rel=2e-3)


def test_twisted_extrusions_keep_their_volume() -> None:
    straight, twisted = (volume(f"(extrude [[0 0] [1 0] [1 1] [0 1]] 2 :twist {t} :slices 2000)") for t in (0, 3))
    assert twisted == pytest.approx(straight, rel=2e-3)
    assert entity_box(scene_of("(extrude [[-1 0] [1 0] [0 1]] 2 :center #t)").root) == (-1.0, 0.0, -1.0, 1.0, 1.0, 1.0)


@pytest.mark.parametrize(("angle", "sides"), [("pi", 32), ("(/ pi 32)", 1), ("(/ pi 16)", 2), ("1.6", 17)])
def test_parts_of_a_turn_fit_a_whole_one(angle: str, sides: int) -> None:
    """`:segments` are those of a full turn; a share that is not whole gets equal sides, too."""
    part = f"(lathe [[1 0] [2 0] [2 1] [0 1]] :segments 64 :angle {angle})"
    turn = value_of(f"(/ {angle} {sides})")
    assert volume(part) == pytest.approx(sides * math.sin(turn) * 11 / 6, rel=1e-6)


def test_rounding_keeps_the_size_and_takes_corners() -> None:
    whole = scene_of('(rounded (call "cube" :scale 2) .3 :segments 16)')
    assert entity_box(whole.root) == pytest.approx((-1, -1, -1, 1, 1, 1), abs=1e-6)
    assert 7.0 < solid_in(whole).volume() < 8.0
    assert not solid_in(whole).contains(np.array([[0.97, 0.97, 0.97]]))[0]


def test_split_gives_both_sides() -> None:
    parts = scene_of(f"(union (split {CUBE} {BALL}))")
    shapes = [e.shape for e in descendants(parts.root) if isinstance(e.shape, SolidShape)]
    assert sum(shape.volume() for shape in shapes) == pytest.approx(1.0)


@pytest.mark.parametrize("seed", range(6))
def test_poses_scale_volumes_and_change_nothing_else(seed: int) -> None:
    rng = np.random.default_rng(200 + seed)
    a, b = random_parts(rng), random_parts(rng)
    pose = "(@ (translate [3 1 2]) (rotate 1 [1 2 3]) (scale [2 -1.5 .7]))"
    whole = volume(f"(difference {a} {b})")
    assert volume(f"(difference (transform {a} {pose}) (transform {b} {pose}))") == pytest.approx(2.1 * whole, rel=1e-8)


# --- bounds ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(6))
def test_bounds_contain_the_surface_and_touch_it(seed: int) -> None:
    rng = np.random.default_rng(300 + seed)
    a, b = random_parts(rng), random_parts(rng)
    scene = scene_of(f"(transform (difference {a} {b}) (@ (rotate 1 [1 {seed} 2]) (scale [1 2 -1])))")
    box = np.array(entity_box(scene.root))
    points = sl.evaluate('(bind "a" (lambda () (call "cube")))') and _world_vertices(scene)
    assert box[:3] == pytest.approx(points.min(axis=0), abs=1e-12)
    assert box[3:] == pytest.approx(points.max(axis=0), abs=1e-12)


def _world_vertices(scene: Scene) -> np.ndarray:
    from scenelang.interpreter.scene.flatten import flatten_entity

    flat = flatten_entity(scene.root)
    (entity,) = flat.primitives
    assert isinstance(entity.shape, SolidShape)
    matrix = flat.matrices[0]
    return np.asarray(entity.shape.computed.mesh.vertices @ matrix[:, :3].T + matrix[:, 3])


# --- colors and words -----------------------------------------------------------------------------------------------


def areas_by_color(shape: SolidShape) -> dict[tuple[float, ...], float]:
    mesh = shape.computed.mesh
    a, b, c = (mesh.corners[:, k] for k in range(3))
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2.0
    assert mesh.colors is not None
    found: dict[tuple[float, ...], float] = {}
    for color, own in zip(map(tuple, mesh.colors.tolist()), area.tolist(), strict=True):
        found[color] = found.get(color, 0.0) + own
    return found


def test_faces_keep_the_colors_of_their_operands() -> None:
    drill = '(call "cube" :scale [.5 .5 3] :color [0 0 1])'
    found = areas_by_color(solid_in(scene_of(f'(difference (call "cube" :scale 2 :color [1 0 0]) {drill})')))
    assert found == {(1.0, 0.0, 0.0): pytest.approx(24.0 - 0.5), (0.0, 0.0, 1.0): pytest.approx(4.0)}


def test_a_color_of_the_result_replaces_those_of_operands_in_later_operations() -> None:
    inner = f"(difference {CUBE} {BALL} :color [0 1 0])"
    found = areas_by_color(solid_in(scene_of(f"(solid-union {inner} (transform {inner} (translate [3 0 0])) {CUBE})")))
    assert (0.0, 1.0, 0.0) in found
    assert (0.1, 0.2, 0.9) not in found


def test_one_solid_in_two_colors() -> None:
    drilled = f"(difference {CUBE} {BALL})"
    before = f"(define plain {drilled})\n(define green (difference {CUBE} {BALL} :color [0 1 0]))"
    scene = scene_of("(solid-union plain (transform green (translate [2 0 0])))", before)
    assert set(areas_by_color(solid_in(scene))) == {(0.8, 0.2, 0.1), (0.1, 0.2, 0.9), (0.0, 1.0, 0.0)}


def test_words_of_operands_are_parts_and_are_not_counted() -> None:
    before = f'(bind "plate" (lambda () {CUBE}))\n(bind "hole" (lambda () {BALL}))'
    scene = scene_of('(difference (call "plate") (call "hole"))', before)
    assert count_words(scene.root) == {"it": 1, "difference": 1}
    mesh = solid_in(scene).computed.mesh
    assert mesh.part is not None
    assert {mesh.part_words[k] for k in mesh.part.tolist()} == {"plate", "hole"}


def test_the_face_of_a_cut_belongs_to_what_is_cut() -> None:
    shape = solid_in(scene_of('(cut-plane (call "cube" :color [1 0 0]) [0 1 0])'))
    assert areas_by_color(shape) == {(1.0, 0.0, 0.0): pytest.approx(4.0)}
    assert shape.computed.mesh.part is None


def test_the_material_is_that_of_the_first_operand() -> None:
    scene = scene_of('(difference (call "cube" :metallic 1 :roughness .2) (call "sphere" :radius .6 :opacity .5))')
    (entity,) = [e for e in descendants(scene.root) if e.is_primitive]
    assert dict(entity.embedding.attributes) == {"metallic": 1, "roughness": 0.2, "color": (1.0, 1.0, 1.0)}


# --- sharing and data ------------------------------------------------------------------------------------------------


def test_equal_solids_are_one_entity_and_are_computed_once(monkeypatch: pytest.MonkeyPatch) -> None:
    scene = scene_of(
        "(for/union ((i (iota 5))) (transform (drilled .37) (translate [i 0 0])))",
        '(define (drilled r) (difference (call "cube" :scale .973) (call "sphere" :radius r)))',
    )
    (solid,) = [e for e in descendants(scene.root) if isinstance(e.shape, SolidShape)]
    count = itertools.count()
    made = computing._carried_out
    monkeypatch.setattr(computing, "_carried_out", lambda *a: (next(count), made(*a))[1])
    assert isinstance(solid.shape, SolidShape)
    computed(solid.shape.expression)
    computed(solid.shape.expression)
    assert next(count) == 3  # the cube, the sphere and the difference


def test_where_a_solid_is_made_does_not_change_it() -> None:
    first, second = scene_of(f"(difference {CUBE} {BALL})"), scene_of(f"\n\n (difference {CUBE}\n {BALL})")
    assert solid_in(first) == solid_in(second)
    assert solid_in(first) != solid_in(scene_of(f'(difference {CUBE} {BALL} {BALL} (call "cone"))'))


@pytest.mark.parametrize(
    "expression",
    [
        f"(difference {CUBE} {BALL} :segments 12)",
        f"(solid-union (difference {CUBE} {BALL} :color [0 1 0]) (lathe [[0 0] [1 0] [0 1]]))",
        "(extrude (list [[0 0] [3 0] [3 3] [0 3]] [[1 1] [1 2] [2 2] [2 1]]) 2 :twist .3)",
        '(rounded (call "torus" :radius .6) .02 :segments 4)',
    ],
)
def test_json_keeps_solids(tmp_path: Path, expression: str) -> None:
    scene = scene_of(expression)
    write_scene(scene, tmp_path / "a.json")
    again = read_scene(tmp_path / "a.json")
    assert solid_in(again) == solid_in(scene)
    assert entity_box(again.root) == entity_box(scene.root)


def test_malformed_solids_in_json_are_errors(tmp_path: Path) -> None:
    scene = scene_of(f"(difference {CUBE} {BALL})")
    write_scene(scene, tmp_path / "a.json")
    good = json.loads((tmp_path / "a.json").read_text())
    records = next(e["solid"] for e in good["entities"] if "solid" in e)
    for change in (
        lambda r: r[-1].update(operands=[[7, [0] * 12, None]]),
        lambda r: r[-1].update(operands=[[0, [0] * 11, None]]),
        lambda r: r[-1].update(color="red"),
        lambda r: r[-1].update(operation="erase"),
        lambda r: r[0].update(attributes={"scale": "wide"}),
        lambda r: r[-1].update(operation="extrude"),
        lambda r: r.clear(),
    ):
        bad = json.loads(json.dumps(good))
        change(next(e["solid"] for e in bad["entities"] if "solid" in e))
        (tmp_path / "b.json").write_text(json.dumps(bad))
        with pytest.raises(SceneError):
            entity_box(read_scene(tmp_path / "b.json").root)
    assert from_plain(to_plain(solid_in(scene).expression), lambda *a: _cube_or_ball(scene, *a)) is not None
    assert len(records) == 3


def _cube_or_ball(scene: Scene, word: str, attributes: Any, file: Any) -> Any:
    return next(n.shape for n in nodes_of(solid_in(scene).expression) if n.shape is not None and n.shape.word == word)


# --- errors ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("expression", "message"),
    [
        ('(difference (call "cube") (call "dragon"))', 'cannot use "dragon": it is a semantic primitive'),
        ('(hull (call "set-cuboid" :block-type "stone"))', "made of Minecraft blocks"),
        ('(solid-union (call "cube" :scale [1 0 1]))', "flat, so it has no volume"),
        ("(hull (union))", "an operand without primitives"),
        ('(difference (call "cube") :segments 2)', "expects 3 to 1,024 :segments, got 2"),
        ('(rounded (call "cube") -1)', "a positive number for the radius"),
        ('(rounded (call "cube") 3)', "no ball of radius 3 fits inside"),
        ('(cut-plane (call "cube") [0 0 0])', "the normal of `cut-plane` is zero"),
        ("(extrude [[0 0] [1 0]] 1)", "at least three points"),
        ("(extrude [[0 0 0] [1 0 0] [1 1 1]] 1)", "at least three points [x y]"),
        ("(lathe [[0 0] [1 0] [1 1]] :angle 0)", "an :angle above 0 up to a full turn"),
        ("(mesh [[0 0 0] [1 0 0] [0 1 0]] [[0 1 9]])", "indices below 3"),
        ("(intersection (call \"cube\") (transform (call \"cube\") (translate [5 0 0])))", "`intersection` leaves nothing"),
        ("(lathe [[-2 0] [-1 0] [-1 1]])", "on the left of the axis: no x is above 0"),
        ("(extrude [[0 0] [1 0] [1 1]] 1e300)", "a number below 1,000,000,000,000 for the height, got 1e+300"),
        ("(extrude [[0 0] [1e300 0] [1 1]] 1)", "coordinates below 1,000,000,000,000"),
        ("(extrude [[0 0] [inf 0] [1 1]] 1)", "expects finite points"),
        ("(extrude [[0 0] [1 0] [1 1]] 1 :taper 1e300)", "a number below 1,000,000,000,000 for :taper"),
    ],
)  # fmt: skip
def test_errors_say_what_is_wrong(expression: str, message: str) -> None:
    with pytest.raises(SceneError, match=re.escape(message)) as caught:
        entity_box(scene_of(expression).root)
    assert caught.value.span is not None


def test_too_many_triangles_are_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(computing, "MAX_TRIANGLES", 1000)
    with pytest.raises(LimitError, match="more than the limit of 1,000"):
        volume('(difference (call "cube") (call "sphere" :radius .61))')
    monkeypatch.setattr(computing, "MAX_PAIRS", 100)
    with pytest.raises(LimitError, match="pairs of faces"):
        volume('(minkowski (call "cube" :scale 1.234) (call "sphere" :radius .1))')


NOTHING = '(intersection (call "cube") (transform (call "cube") (translate [5 0 0])))'


@pytest.mark.parametrize(
    ("expression", "message", "at", "outer"),
    [
        (f'(difference {NOTHING} (call "sphere"))', "`intersection` leaves nothing", NOTHING, "difference"),
        (f"(cut-plane (transform (hull {NOTHING}) (scale 2)) [0 1 0])", "`intersection` leaves", NOTHING, "cut-plane"),
        ('(list-ref (split (call "cube") (call "cube" :scale 2)) 1)', "`split` leaves nothing outside of its tool",
         '(split (call "cube") (call "cube" :scale 2))', None),
        ('(list-ref (split (call "cube") (transform (call "cube") (translate [5 0 0]))) 0)',
         "`split` leaves nothing inside of its tool",
         '(split (call "cube") (transform (call "cube") (translate [5 0 0])))', None),
        ('(union (apply intersection (for/list ((i 3)) (transform (call "cube") (translate (vector (* 5 i) 0 0))))))',
         "`intersection` leaves nothing",
         '(apply intersection (for/list ((i 3)) (transform (call "cube") (translate (vector (* 5 i) 0 0)))))', None),
        ('(apply intersection (list (call "cube") (transform (call "cube") (translate [5 0 0]))))', "`intersection` leaves",
         '(apply intersection (list (call "cube") (transform (call "cube") (translate [5 0 0]))))', None),
    ],
)  # fmt: skip
def test_the_operation_that_leaves_nothing_is_named_at_its_place(
    expression: str, message: str, at: str, outer: str | None
) -> None:
    with pytest.raises(SceneError) as caught:
        entity_box(scene_of(expression).root)
    error = caught.value
    assert error.message.startswith(message)
    assert error.span is not None
    assert error.span.text == at
    assert [note.message for note in error.notes] == ([f"so `{outer}` leaves nothing"] if outer else [])


def test_a_large_twist_is_in_radians() -> None:
    with pytest.raises(LimitError, match="10,185,916,359 cross-sections") as caught:
        entity_box(scene_of("(extrude [[0 0] [1 0] [1 1]] 1 :twist 1e9)").root)
    assert ":twist is in radians" in str(caught.value.hint)


def test_too_many_triangles_have_a_place(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(computing, "MAX_TRIANGLES", 10)
    expression = '(hull (call "cube" :scale 1.2345) (transform (call "cube" :scale 2.3456) (rotate 1 [1 2 3])))'
    with pytest.raises(LimitError, match="more than the limit of 10") as caught:
        entity_box(scene_of(expression).root)
    assert caught.value.span is not None


def test_an_empty_intersection_can_be_tested() -> None:
    apart = '(intersection (call "cube") (transform (call "cube") (translate [5 0 0])))'
    scene = scene_of(f'(if (> (volume {apart}) 0) {apart} (call "sphere"))')
    assert count_words(scene.root) == {"it": 1, "sphere": 1}


# --- backends --------------------------------------------------------------------------------------------------------


def test_normals_are_smooth_on_curves_and_sharp_at_edges() -> None:
    mesh = solid_in(scene_of('(difference (call "cube" :scale 3) (call "sphere"))')).computed.mesh
    corners, normals = mesh.corners.reshape(-1, 3), mesh.shading[mesh.faces].reshape(-1, 3)
    on_ball = np.abs(np.linalg.norm(corners, axis=1) - 1.0) < 1e-6
    assert np.einsum("ni,ni->n", normals[on_ball], -corners[on_ball]).min() > 0.99
    assert (np.abs(normals[~on_ball]).max(axis=1) > 1.0 - 1e-9).all()


def test_drafts_show_the_same_with_and_without_the_sides_that_are_turned_away(monkeypatch: pytest.MonkeyPatch) -> None:
    from scenelang.interpreter.scene.primitives.forms import FACE, SMOOTH_FACE

    scene = sl.evaluate(f'(bind "it" (lambda () (difference {CUBE} {BALL})))')
    picture = scene.render(size=(64, 48)).pixels
    for form in (FACE, SMOOTH_FACE):
        monkeypatch.setattr(type(form), "is_one_sided", False)
    assert np.abs(picture.astype(int) - scene.render(size=(64, 48)).pixels).max() <= 1


def test_maps_have_the_parts(tmp_path: Path) -> None:
    before = f'(bind "plate" (lambda () {CUBE}))\n(bind "hole" (lambda () {BALL}))'
    scene = sl.evaluate(f'{before}\n(bind "it" (lambda () (difference (call "plate") (call "hole"))))')
    maps = scene.maps(size=(64, 48))
    words = np.array(maps["part"])
    assert set(np.unique(words)) == {-1, 0, 1}
    assert ((words >= 0) == (maps["instance"] >= 0)).all()
    blue = maps["albedo"][:, :, 2] > 0.5
    assert (words[blue] == words[blue][0]).all()
    assert (words[(words >= 0) & ~blue] != words[blue][0]).all()


@pytest.mark.parametrize("ending", ["glb", "obj", "stl", "ply", "usda", "xml"])
def test_every_export_has_them(tmp_path: Path, ending: str) -> None:
    scene = sl.evaluate(f'(bind "it" (lambda () (difference {CUBE} {BALL})))')
    scene.export(tmp_path / f"a.{ending}")
    if ending in ("glb", "obj", "stl", "ply"):
        import trimesh

        mesh = trimesh.load(tmp_path / f"a.{ending}", force="mesh")
        mesh.merge_vertices(merge_norm=True, merge_tex=True)
        assert mesh.volume == pytest.approx(solid_in(scene.graph).volume(), rel=1e-4)
        assert mesh.is_watertight


def test_films_compute_each_frame() -> None:
    scene = sl.evaluate(
        '(bind "it" (lambda () (frames (for/list ((i (iota 3))) '
        '(difference (call "cube") (transform (call "sphere" :radius .3) (translate [(* .3 i) .5 0])))))))'
    )
    volumes = {solid_in(Scene("it", [root], False)).volume() for root in scene.graph.frames}
    assert len(volumes) == 3
    assert manifold_of(solid_in(Scene("it", [scene.graph.frames[0]], False)).expression).manifold.num_tri() > 100


def test_scenes_with_other_solids_differ() -> None:
    first, same, other = (
        sl.evaluate(f'(bind "it" (lambda () (difference {CUBE} (call "sphere" :radius {radius}))))')
        for radius in (".6", ".6 ", ".61")
    )
    assert first.diff(same).equal
    assert not first.diff(other).equal
    turned = sl.evaluate(f'(bind "it" (lambda () (transform (difference {CUBE} {BALL}) (rotate 1 [0 1 0]))))')
    assert not first.diff(turned).equal


# --- measures --------------------------------------------------------------------------------------------------------


def log_of(expression: str) -> str:
    scene = sl.evaluate(f'(bind "it" (lambda () (print {expression}) (call "cube")))')
    return str(scene.log[0])


@pytest.mark.parametrize(
    ("expression", "expected"),
    [
        ('(volume (call "sphere" :radius 2))', 32.0 / 3.0 * math.pi),
        ('(volume (transform (call "cone" :radius 1) (scale [1 3 2])))', 2.0 * math.pi),
        ('(volume (union (call "cube") (call "cube")))', 1.0),
        ('(volume (union (call "cube") (transform (call "sphere") (translate [5 0 0]))))', 1.0 + 4.0 / 3.0 * math.pi),
        ('(surface-area (transform (call "sphere") (scale 2)))', 16.0 * math.pi),
        ("(volume (union))", 0.0),
    ],
)
def test_measures_of_primitives_are_exact(expression: str, expected: float) -> None:
    assert float(log_of(expression)) == pytest.approx(expected, rel=1e-9)


def test_moments_agree_with_trimesh() -> None:
    from trimesh.triangles import mass_properties

    shape = solid_in(scene_of(f"(difference {CUBE} (transform {BALL} (translate [.3 .2 .1])))"))
    expected = mass_properties(shape.computed.mesh.corners)
    text = f"(difference {CUBE} (transform {BALL} (translate [.3 .2 .1])))"
    assert json.loads(log_of(f"(centroid {text})").replace(" ", ",")) == pytest.approx(expected["center_mass"])
    inertia = np.array(json.loads(log_of(f"(inertia {text})").replace(" ", ",")))
    assert inertia == pytest.approx(expected["inertia"], abs=1e-12)


def test_the_inertia_of_parts_that_are_apart_is_that_of_their_union() -> None:
    parts = '(union (call "cube") (transform (call "cube" :scale [1 2 1]) (translate [3 0 1])))'
    joined = f"(solid-union {parts})"
    apart, whole = (np.array(json.loads(log_of(f"(inertia {text})").replace(" ", ","))) for text in (parts, joined))
    assert apart == pytest.approx(whole, rel=1e-12)


# --- limits ----------------------------------------------------------------------------------------------------------


def test_the_tool_of_a_sum_must_be_convex() -> None:
    with pytest.raises(SceneError, match="not convex"):
        volume('(minkowski (call "cube") (call "torus" :radius .3))')


def test_long_chains_are_neither_slow_nor_recursive(tmp_path: Path) -> None:
    scene = scene_of(
        "(chain 2000 (call \"cube\"))",
        "(define (chain n x) (if (= n 0) x (chain (- n 1) (difference x (transform (call \"cube\" :scale .01) (translate [(* .001 n) .5 0]))))))",
    )  # fmt: skip
    write_scene(scene, tmp_path / "a.json")
    assert solid_in(read_scene(tmp_path / "a.json")) == solid_in(scene)


@pytest.mark.slow
def test_commands_end_long_computations(tmp_path: Path) -> None:
    many = """
    (for/union ((i (iota 480)))
      (transform (call "sphere" :radius .3) (translate [(sin i) (cos i) (sin (* 3 i))])))"""
    (tmp_path / "a.scene").write_text(f'(bind "a" (lambda () (solid-union {many})))')
    (tmp_path / "b.scene").write_text(f'(bind "a" (lambda () {many}))')
    for command in (
        ["check", "--run", "a.scene"],
        ["render", "a.scene", "-o", "a.png"],
        ["export", "b.scene", "--solid", "-o", "a.stl"],
    ):
        words = [sys.executable, "-m", "scenelang", *command, "--max-seconds", ".3"]
        done = subprocess.run(words, capture_output=True, text=True, cwd=tmp_path)
        assert done.returncode == 1, command
        told = done.stderr + done.stdout
        assert "E507" in told, command
        assert "b.scene" in command or "--> a.scene:" in told, command
    assert {path.name for path in tmp_path.iterdir()} == {"a.scene", "b.scene"}


def test_too_many_triangles_are_refused_before_they_are_joined(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(computing, "_operated", lambda *_: pytest.fail("they are joined"))
    spheres = '(for/union ((i (iota 10000))) (transform (call "sphere") (translate [(* .1 i) 0 0])))'
    with pytest.raises(LimitError, match=r"triangles.* more than the limit"):
        _ = sl.evaluate(f'(bind "a" (lambda () (solid-union {spheres})))').bounds


def test_doubling_an_operand_takes_no_room() -> None:
    deep = "(define (deep n e) (if (= n 0) e (deep (- n 1) (solid-union e e))))"
    scene = sl.evaluate(f'{deep} (bind "a" (lambda () (deep 200 (call "cube"))))')
    assert scene.measure().volume == pytest.approx(1.0)


def test_operands_that_their_pose_makes_flat_are_refused(refuses: Callable[[str, str], str]) -> None:
    flat = '(transform (call "cube") (scale [1 0 1]))'
    assert "its pose makes it flat" in refuses("solid", f'(difference (call "cube") {flat})')
    assert sl.evaluate(f'(bind "a" (lambda () {flat}))').measure().volume == 0.0
    assert sl.evaluate(f'(bind "a" (lambda () (union (call "sphere") {flat})))').measure().volume > 4.0


def test_a_loft_that_is_turned_inside_out_has_no_volume(refuses: Callable[[str, str], str]) -> None:
    poses = "(list (translate [0 0 0]) (@ (translate [0 0 2]) (rotate pi [0 1 0])))"
    assert "no volume" in refuses("solid", f"(volume (loft (list (circle 1) (circle 1)) :poses {poses}))")


def test_corners_of_meshes_are_whole_numbers(refuses: Callable[[str, str], str]) -> None:
    told = refuses("value", "(mesh [[0 0 0] [1 0 0] [0 1 0] [0 0 1]] [[0 2 1] [0 1 3] [0 3 2.5] [1 2 3]])")
    assert "whole indices" in told


def test_solids_that_no_later_operation_needs_are_let_go(monkeypatch: pytest.MonkeyPatch) -> None:
    """A chain of thousands of operations would fill the memory with all of its intermediate solids."""
    monkeypatch.setattr(computing, "_manifolds", computing._TriangleCache(1))
    made, alive, most = computing._carried_out, 0, 0

    class Sources(dict[int, computing.FaceSource]):
        def __del__(self) -> None:
            nonlocal alive
            alive -= 1

    def counted(*arguments: Any) -> Any:
        nonlocal alive, most
        found = made(*arguments)
        alive += 1
        most = max(most, alive)
        return found._replace(sources=Sources(found.sources))

    monkeypatch.setattr(computing, "_carried_out", counted)
    moved = '(transform (call "cube" :scale .01) (translate (vector (* i .003) .512 0)))'
    chain = f'(fold (lambda (i acc) (solid-union acc {moved})) (call "cube") (range 40))'
    assert volume(chain) > 1
    assert most < 8


def test_profiles_as_large_as_no_number_are_refused(refuses: Callable[[str, str], str]) -> None:
    assert "within 1e+09" in refuses("value", '(svg-path "M0 0 h1e200 v1e200 h-1e200z")')


@pytest.mark.parametrize("shape", [
    '(call "cube" :scale 1e80)', '(call "cube" :scale 1e200)', '(call "sphere" :radius 1e65)', '(call "house" :scale 1e150)',
    '(union (call "cube") (transform (call "cube") (translate [1e160 0 0])))',
    '(solid-union (call "cube" :scale 1e160) (call "sphere" :radius 1e150))',
])  # fmt: skip
def test_measures_of_what_is_too_large_are_refused(shape: str) -> None:
    with pytest.raises(sl.SceneError, match="only what is within 1e\\+50 of the origin can be measured, got"):
        sl.evaluate(f'(bind "main" (lambda () {shape}))').measure()


@pytest.mark.parametrize(
    ("parts", "volume", "moment"),
    [
        ('(call "cube")', 1.0, 1.0 / 6.0),
        ('(call "sphere")', 4.0 * math.pi / 3.0, 8.0 * math.pi / 15.0),
        ('(union (call "cube") (transform (call "cube") (translate [.5 0 0])))', 1.5, 0.25),
    ],
)
def test_measures_of_what_is_far_away_are_those_of_what_is_near(parts: str, volume: float, moment: float) -> None:
    for place in ("1e9",) if "union" in parts else ("1e9", "1e20", "1e40"):  # poses of parts are added
        scene = sl.evaluate(f'(bind "it" (lambda () (transform {parts} (translate [{place} 0 (- {place})]))))')
        found = scene.measure()
        assert found.volume == pytest.approx(volume, rel=1e-9)
        assert found.moments[0] == pytest.approx(moment, rel=5e-3)
        assert found.centroid[0] == pytest.approx(float(place))


def test_solids_that_lose_their_size_in_their_coordinates_are_refused() -> None:
    far = '(solid-union (transform (call "cube") (translate [1e20 0 0])))'
    with pytest.raises(sl.SceneError, match=r"what is .* large and 1e\+20 away from its origin cannot be measured"):
        sl.evaluate(f'(bind "it" (lambda () {far}))').measure()


def test_measures_use_surfaces_that_are_known(monkeypatch: pytest.MonkeyPatch) -> None:
    from scenelang.interpreter.scene.modelling import computing

    program = '(bind "a" (lambda () (difference (call "cube") (call "sphere" :radius .4))))'
    scene = sl.evaluate(program)
    _ = scene.bounds
    monkeypatch.setattr(computing, "manifold_of", lambda _: pytest.fail("computed again"))
    measures = scene.measure()
    assert measures.volume == pytest.approx(1.0 - 4.0 / 3.0 * np.pi * 0.4**3, abs=0.01)


# --- places on surfaces ----------------------------------------------------------------------------------------------


def test_places_are_on_the_surface_by_area() -> None:
    scene = sl.evaluate(
        '(bind "it" (lambda () (scatter-on (call "cube" :scale .01) '
        '(transform (call "cube" :scale [4 1 1]) (scale [-1 1 2])) 4000)))'
    )
    matrices = scene.flatten().matrix
    points, up = matrices[:, :3, 3], matrices[:, :3, 1]
    half = np.array([2.0, 0.5, 1.0])
    axis = np.argmax(np.abs(up), axis=1)
    assert np.abs(points[np.arange(4000), axis] - np.sign(up[np.arange(4000), axis]) * half[axis]).max() < 1e-9
    areas = np.array([1.0 * 2.0, 4.0 * 2.0, 4.0 * 1.0])
    assert np.bincount(axis, minlength=3) / 4000 == pytest.approx(areas / areas.sum(), abs=0.03)
    assert np.linalg.det(matrices[:, :3, :3]) == pytest.approx(1.0)


def test_scattering_follows_the_seed() -> None:
    text = '(bind "it" (lambda () (scatter-on (call "cone") (call "torus") 5)))'
    first, same, other = (sl.evaluate(text, seed=seed) for seed in (1, 1, 2))
    assert first.diff(same).equal
    assert not first.diff(other).equal
