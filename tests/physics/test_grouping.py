"""Which parts are bodies, what they weigh, and what attributes change; colliders of posed primitives."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import manifold3d
import numpy as np
import pytest

import scenelang as sl
from scenelang.backends.physics.colliders import Collider, colliders_of, reach_of, trimmed, volume_of_collider
from scenelang.backends.physics.grouping import BodySet, bodies_of
from scenelang.interpreter.scene.primitives import shape_of

pytest.importorskip("mujoco")
EXAMPLES = Path(__file__).parents[2] / "examples"
CHAIR = """
(bind "leg" (lambda () (call "cube" :scale [.1 .5 .1])))
(bind "seat" (lambda () (call "cube" :scale [.6 .1 .6])))
(bind "chair" (lambda ()
  (union (for*/union ((x '(-.2 .2)) (z '(-.2 .2))) (transform (call "leg") (translate [x .25 z])))
         (transform (call "seat") (translate [0 .55 0])))))
(bind "cup" (lambda () (call "cylinder" :radius .05 :p1 [0 .1 0])))
"""


def bodies(text: str, unit: float | None = 1.0) -> BodySet:
    return bodies_of(sl.evaluate(text).root, unit)


def names(found: BodySet) -> list[str]:
    return [body.words[-1] for body in found.bodies]


@pytest.mark.parametrize(
    ("room", "expected"),
    [
        ('(call "chair")', ["chair"]),
        ('(call "chair") (transform (call "cup") (translate [0 .6 0]))', ["chair", "cup"]),
        ('(call "chair") (transform (call "chair") (translate [2 0 0]))', ["chair", "chair"]),
        # primitives in the root are bodies of their own while each of them stands
        ('(call "cube") (transform (call "cube" :scale .5) (translate [0 .75 0]))', ["cube", "cube"]),
        ('(call "cube") (transform (call "cube" :scale .5) (translate [.75 0 0]))', ["room"]),
        ('(call "cube") (transform (call "cube") (translate [0 1.2 0]))', ["cube", "cube"]),
        # what overlaps deeply is glued
        ('(call "chair") (transform (call "cup") (translate [0 .57 0]))', ["chair"]),
        ('(call "chair" :body #t) (transform (call "cup") (translate [0 .57 0]))', ["chair", "cup"]),
        ('(call "chair" :body #f)', ["leg", "leg", "leg", "leg", "seat"]),
        ('(call "chair" :body #f) (call "tree")', ["leg", "leg", "leg", "leg", "seat"]),
        ('(call "tree" :body #t)', ["tree"]),
    ],
)  # fmt: skip
def test_things(room: str, expected: list[str]) -> None:
    assert names(bodies(f'{CHAIR} (bind "room" (lambda () (union {room})))')) == expected


def test_an_arrangement_is_no_thing_and_a_thing_may_have_strays() -> None:
    chairs = (
        '(bind "chairs" (lambda () (for/union ((k (iota 3))) (transform (call "chair") (translate [(* 2 k) 0 0])))))'
    )
    assert names(bodies(f'{CHAIR} {chairs} (bind "room" (lambda () (call "chairs")))')) == ["chair"] * 3
    lost = '(bind "odd" (lambda () (union (call "chair") (transform (call "leg") (translate [0 2 0])))))'
    assert names(bodies(f'{CHAIR} {lost} (bind "room" (lambda () (call "odd")))')) == ["chair", "leg"]


@pytest.mark.slow
def test_the_chess_set() -> None:
    found = bodies_of(sl.load(EXAMPLES / "chessboard.scene").root)
    assert len(found.bodies) == 34  # the frame and the squares are two
    assert names(found).count("pawn") == 16


@pytest.mark.parametrize(
    ("given", "mass"),
    [("", 1000.0), (":density 500", 500.0), (':density "oak"', 700.0), (":mass 3", 3.0), (":mass 3 :density 7", 3.0)],
)
def test_mass(given: str, mass: float) -> None:
    found = bodies(f'(bind "a" (lambda () (call "cube" {given})))').bodies[0].moments
    assert found.mass == pytest.approx(mass)
    assert found.inertia == pytest.approx(np.eye(3) * mass / 6)


def test_attributes_of_calls_around_it_count_for_what_is_inside() -> None:
    text = '(bind "ball" (lambda (:color) (call "sphere" {}))) (bind "a" (lambda () (call "ball" :color [1 1 1] {})))'
    volume = 4 / 3 * math.pi
    assert bodies(text.format("", ":density 2")).bodies[0].moments.mass == pytest.approx(2 * volume)
    assert bodies(text.format(":density 3", ":density 2")).bodies[0].moments.mass == pytest.approx(3 * volume)
    assert bodies(text.format("", ":mass 5")).bodies[0].moments.mass == pytest.approx(5)
    assert bodies(text.format(":friction .1", ":friction .2")).frictions == (0.1,)
    assert bodies(text.format("", ":friction .2")).frictions == (0.2,)
    assert bodies(text.format("", ":fixed #t")).bodies[0].fixed
    assert bodies(text.format("", "")).frictions == (None,)


def test_masses_of_parts_add_up_and_shift_the_centre() -> None:
    text = """(bind "foot" (lambda () (call "cube")))
    (bind "lamp" (lambda () (union (call "foot" :mass 9) (transform (call "cube" :mass 1) (translate [0 1 0])))))
    (bind "a" (lambda () (call "lamp" {})))"""
    plain, whole = bodies(text.format("")).bodies[0].moments, bodies(text.format(":mass 20")).bodies[0].moments
    assert (plain.mass, whole.mass) == (pytest.approx(10.0), pytest.approx(20.0))
    assert plain.center == pytest.approx([0, 0.1, 0])
    assert whole.center == pytest.approx([0, 0.1, 0])
    # two cubes of 9 and 1 kg, each 1/6 about itself, with the theorem of parallel axes
    assert plain.inertia[0, 0] == pytest.approx(10 / 6 + 9 * 0.1**2 + 1 * 0.9**2)


def test_overlaps_count_once_and_units_scale() -> None:
    text = '(bind "a" (lambda () (union (call "cube") (transform (call "cube") (translate [.5 0 0])))))'
    assert bodies(text).bodies[0].moments.mass == pytest.approx(1500.0)
    assert bodies(text, 0.1).bodies[0].moments.mass == pytest.approx(1.5)


@pytest.mark.parametrize(
    ("text", "ground"),
    [
        ('(call "cube")', -0.5),
        ('(transform (call "cube") (translate [0 .5 0]))', 0.0),
        # a slab below is the ground, and holds what stands on it
        ('(transform (call "cube" :scale [9 1 9]) (translate [0 -.5 0])) (call "ball")', 0.0),
        # a trunk that goes into the ground at 0, on which something stands
        ('(transform (call "cube") (translate [0 .5 0])) (transform (call "post") (translate [3 -.3 0]))', 0.0),
    ],
)  # fmt: skip
def test_ground(text: str, ground: float) -> None:
    words = """(bind "post" (lambda () (call "cylinder" :radius .1 :p1 [0 2 0])))
    (bind "ball" (lambda () (transform (call "sphere" :radius .3) (translate [0 .3 0]))))"""
    found = bodies(f'{words} (bind "a" (lambda () (union {text})))')
    assert found.ground == pytest.approx(ground)


# --- colliders -------------------------------------------------------------------------------------------------------


def linear(*rows: float) -> np.ndarray:
    return np.column_stack([np.array(rows, np.float64).reshape(3, 3), [1.0, 2.0, 3.0]])


TURN = (math.cos(0.4), 0, math.sin(0.4), 0, 1, 0, -math.sin(0.4), 0, math.cos(0.4))
POSES = {
    "same": (1, 0, 0, 0, 1, 0, 0, 0, 1), "turned": TURN, "mirrored": (-1, 0, 0, 0, 1, 0, 0, 0, 1),
    "stretched": (2, 0, 0, 0, 1, 0, 0, 0, 0.5), "sheared": (1, 0.7, 0, 0, 1, 0, 0, 0, 1),
}  # fmt: skip
EXACT = {  # the kinds that each primitive has under the poses above
    "cube": ("box", "box", "box", "box", "mesh"),
    "sphere": ("sphere", "sphere", "sphere", "ellipsoid", "ellipsoid"),
    "cylinder": ("cylinder", "cylinder", "cylinder", "mesh", "mesh"),
    "capsule": ("capsule", "capsule", "capsule", "mesh", "mesh"),
    "cone": ("mesh",) * 5,
    "rounded-cube": ("mesh",) * 5,
}


@pytest.mark.parametrize("word", list(EXACT))
@pytest.mark.parametrize("pose", list(POSES))
def test_colliders_have_the_volume_and_the_box_of_the_primitive(word: str, pose: str) -> None:
    shape, world = shape_of(word, {}), linear(*POSES[pose])
    (found,) = colliders_of(shape, world)
    assert found.kind == EXACT[word][list(POSES).index(pose)]
    exact = found.kind != "mesh" or word == "cube"
    volume = shape.volume() * abs(np.linalg.det(world[:, :3]))
    assert volume_of(found) == pytest.approx(volume, rel=1e-9 if exact else 0.04)
    low, high = found.box()
    assert np.concatenate([low, high]) == pytest.approx(
        np.array(shape.box_under(world.ravel().tolist())), abs=1e-9 if exact else 0.03
    )


def volume_of(shape: Collider) -> float:
    a, b, c = shape.size.tolist()
    volumes: dict[str, Any] = {
        "box": lambda: 8 * a * b * c, "sphere": lambda: 4 / 3 * math.pi * a**3,
        "ellipsoid": lambda: 4 / 3 * math.pi * a * b * c, "cylinder": lambda: 2 * math.pi * a * a * b,
        "capsule": lambda: 2 * math.pi * a * a * b + 4 / 3 * math.pi * a**3,
        "mesh": lambda: manifold3d.Manifold.hull_points(np.ascontiguousarray(shape.vertices)).volume(),
    }  # fmt: skip
    return float(volumes[shape.kind]())


def test_a_torus_is_pieces_around_its_hole() -> None:
    shape = shape_of("torus", {"radius": 1.0})
    found = colliders_of(shape, linear(*POSES["same"]))
    assert sum(map(volume_of, found)) == pytest.approx(shape.volume(), rel=0.06)
    assert all(np.linalg.norm(piece.corners[:, [0, 2]] - [1.0, 3.0], axis=1).min() > 0.4 for piece in found)


@pytest.mark.slow
def test_solids_are_decomposed_once(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    from scenelang.backends.physics import colliders

    text = """(bind "frame" (lambda () (difference (call "cube" :scale [3 .5 3]) (call "cube" :scale [2 1 2]))))
    (bind "peg" (lambda () (call "cube" :scale [.5 .5 .5])))
    (bind "a" (lambda () (union (call "frame") (call "peg"))))"""
    for clear in (colliders._pieces_of, colliders._decomposed):
        clear.cache_clear()
    found = bodies(text)
    assert names(found) == ["frame", "peg"]
    assert len(found.parts[0].colliders) >= 4
    assert list((tmp_path / "scenelang" / "pieces").glob("*.npz"))
    monkeypatch.setattr(colliders, "_coacd", None)
    for clear in (colliders._pieces_of, colliders._decomposed):
        clear.cache_clear()
    assert len(bodies(text).parts[0].colliders) == len(found.parts[0].colliders)


def test_where_coacd_fails_a_mesh_is_halved(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    from scenelang.backends.physics import colliders

    monkeypatch.setattr(colliders.subprocess, "run", lambda *_, **__: None)  # it aborts before it writes
    for clear in (colliders._pieces_of, colliders._decomposed):
        clear.cache_clear()
    frame = '(difference (call "cube" :scale [3.1 .5 3]) (call "cube" :scale [2 1 1.9]))'
    (part,) = bodies(f'(bind "frame" (lambda () {frame}))').parts
    for clear in (colliders._pieces_of, colliders._decomposed):
        clear.cache_clear()
    assert 4 <= len(part.colliders) <= colliders.MAX_PIECES
    volume = 0.5 * (3.1 * 3 - 2 * 1.9)
    assert sum(map(volume_of, part.colliders)) == pytest.approx(volume, rel=0.06)
    assert all(np.abs(piece.corners[:, [0, 2]]).max() > 0.94 for piece in part.colliders)  # none fills the hole


@pytest.mark.parametrize("word", list(EXACT))
@pytest.mark.parametrize("along", [(0.0, 1.0, 0.0), (1.0, 0.0, 0.0), (0.48, -0.6, 0.64)])
def test_a_trimmed_collider_ends_at_the_plane(word: str, along: tuple[float, float, float]) -> None:
    (whole,) = colliders_of(shape_of(word, {}), linear(*POSES["turned"]))
    normal = np.array(along)
    top, bottom = reach_of(whole, normal), -reach_of(whole, -normal)
    level = bottom + 0.7 * (top - bottom)
    found = trimmed(whole, normal, level)
    assert found is not None
    assert reach_of(found, normal) == pytest.approx(level, abs=1e-9)
    assert -reach_of(found, -normal) == pytest.approx(bottom, abs=1e-9)
    other = trimmed(whole, -normal, -level)
    assert other is not None
    parts = volume_of_collider(found) + volume_of_collider(other)
    assert parts == pytest.approx(volume_of_collider(whole), rel=0.02)
    assert trimmed(whole, normal, bottom - 0.1) is None


PRESENT = """(bind "present" (lambda () (union (transform (call "cube" :scale [.3 .2 .3]) (translate [0 .1 0]))
  (transform (call "cube" :scale [.31 .214 .04]) (translate [0 .1 0])))))
(bind "desk" (lambda () (union (transform (call "cube" :scale [1 .1 1]) (translate [0 .45 0])) (call "cube" :scale [.2 .9 .2]))))
"""


@pytest.mark.parametrize(("at", "expected"), [(0.0, "rests"), (0.52, "falls"), (0.6, "falls")])
def test_a_thing_that_is_set_into_another_stands_on_it(at: float, expected: str) -> None:
    scene = sl.evaluate(
        f'{PRESENT} (bind "room" (lambda () (union (call "desk" :fixed #f) (transform (call "present") (translate [{at} .5 0])))))'
    )
    report = scene.physics()
    assert [body.words[-1] for body in report.bodies] == ["desk", "present"]
    assert report.bodies[1].kind in ({expected, "tips"} if expected == "falls" else {expected})


def test_overlaps_of_pieces_push_nothing_away() -> None:
    """Convex pieces bulge over a bowl's hollow, in which an orange lies."""
    text = """(bind "bowl" (lambda () (lathe '([0 0] [.12 0] [.3 .2] [.28 .2] [.11 .02] [0 .02]))))
    (bind "orange" (lambda () (call "sphere" :radius .1)))
    (bind "desk" (lambda () (call "cube" :scale [1 .1 1])))
    (bind "room" (lambda () (union (call "desk") (transform (call "bowl") (translate [0 .048 0]))
      (transform (call "orange") (translate [0 .166 0])))))"""
    report = sl.evaluate(text).physics()
    assert [(body.words[-1], body.kind) for body in report.bodies] == [
        ("desk", "rests"), ("bowl", "rests"), ("orange", "rests"),
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("thing", "place", "stays"),
    [
        ('"picture"', "[0 1.5 .06]", True),  # on the wall
        ('"picture" :fixed #f', "[0 1.5 .06]", False),
        ('"picture"', "[0 1.5 .5]", False),  # before it
        ('"tree"', "[2 .1 2]", False),
        ('"crate"', "[2 .1 2]", False),
        ('"star"', "[2 3 2]", True),  # in the sky
    ],
)  # fmt: skip
def test_what_is_mounted_or_rooted_stays(thing: str, place: str, stays: bool) -> None:
    slabs = " ".join(f'(bind "{word}" (lambda () (call "cube" :scale .2)))' for word in ("tree", "crate", "vase"))
    frames = " ".join(f'(bind "{word}" (lambda () (call "cube" :scale [.4 .3 .02])))' for word in ("picture", "star"))
    room = '(bind "room" (lambda () (union (call "cube" :scale [9 .02 9]) (transform (call "wall") (translate [0 1 0]))'
    found = bodies(
        f'{slabs} {frames} (bind "wall" (lambda () (call "cube" :scale [4 2 .1] :fixed #t)))'
        f'{room} (transform (call {thing}) (translate {place}))))) (scene "room")'
    )
    assert found.bodies[-1].fixed == stays


@pytest.mark.parametrize(
    ("lamp", "stays"),
    [
        ('(transform (call "rain-cloud") (translate [0 3 0]))', True),
        ('(transform (call "rain-cloud" :fixed #f) (translate [0 3 0]))', False),
        ('(transform (call "ball") (translate [0 3 0]))', False),
        ('(transform (call "ball" :floating #t) (translate [0 3 0]))', True),
        ('(transform (call "rain-cloud") (translate [0 .75 0]))', False),  # it stands on the seat
        ('(transform (call "rain-cloud") (translate [3 .15 0]))', False),  # and here on the ground
    ],
)
def test_what_flies_by_its_word_stays_in_the_air(lamp: str, stays: bool) -> None:
    words = (
        '(bind "rain-cloud" (lambda () (call "sphere" :radius .15))) (bind "ball" (lambda () (call "cube" :scale .3)))'
    )
    found = bodies(f'{CHAIR} {words} (bind "room" (lambda () (union (call "chair") {lamp}))) (scene "room")')
    assert [body.fixed for body in found.bodies] == [False, stays]


@pytest.mark.parametrize(("depth", "fixed"), [(0.03, False), (0.2, False)])
def test_what_is_set_into_the_ground_a_little_stands_on_it(depth: float, fixed: bool) -> None:
    """A snowman is not held by the snow that its lowest ball is in."""
    ball = '(transform (call "sphere" :radius .5) (translate [0 .5 0]))'
    text = f"""(bind "man" (lambda () {ball}))
    (bind "scene" (lambda () (union (transform (call "man") (translate [0 -{depth} 0])) (call "marker"))))
    (bind "marker" (lambda () (transform (call "cube") (translate [3 .5 0]))))
    (scene "scene")"""
    found = bodies(text)
    man = next(body for body in found.bodies if "man" in body.words)
    assert man.fixed is fixed
    low = min(float(shape.corners[:, 1].min()) for part in man.parts for shape in found.parts[part].colliders
              if shape.kind == "mesh") if not fixed else 0.0  # fmt: skip
    assert low == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize("slab", ['(transform (call "cube" :scale [4 .1 3]) (translate [0 -.05 0]))', ""])
def test_a_table_with_two_legs_in_the_floor_is_not_held_by_it(slab: str) -> None:
    table = """(bind "table" (lambda () (union (transform (call "cube" :scale [1 .04 .6]) (translate [0 .7 0]))
      (for*/union ((x '(-.45 .45)) (z '(-.25 .25)))
        (transform (call "cube" :scale [.05 .68 .05]) (translate (vector x .34 z)))))))"""
    tilted = '(transform (call "table") (@ (translate [1 0 0]) (rotate .3 [0 0 1])))'
    upright = '(transform (call "table") (translate [-1 0 0]))'
    found = bodies(f'{table} (bind "room" (lambda () (union {slab} {upright} {tilted})))')
    assert not any(body.fixed for body in found.bodies if body.words[-1] == "table")
    assert found.ground == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize(("arm", "fixed"), [(1.5, True), (0.0, False)])
def test_a_street_lamp_that_would_tip_is_anchored_in_the_ground(arm: float, fixed: bool) -> None:
    street = """(transform (call "cube" :scale [16 .2 16]) (translate [0 -.1 0]))
      (transform (call "cube" :scale [16 .15 2]) (translate [0 .075 -3]))"""
    beam = f'(call "cylinder" :radius .06 :p0 [0 3.9 0] :p1 [{arm} 3.9 0])' if arm else ""
    pole = f'(bind "lamp" (lambda () (union (call "cylinder" :radius .08 :p1 [0 4 0]) {beam})))'
    lamp = '(transform (call "lamp") (translate [0 0 3]))'
    found = bodies(f'{pole} (bind "street" (lambda () (union {street} {lamp})))')
    assert [body.fixed for body in found.bodies if "lamp" in body.words] == [fixed]


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e3])
def test_a_body_below_the_plane_lowers_the_ground_at_any_scale(scale: float) -> None:
    """The tolerance is a share of the largest part, not a length."""
    cube = f'(call "cube" :scale {0.1 * scale})'
    parts = "".join(f"(transform {cube} (translate [{x * scale} {y * scale} 0]))" for x, y in ((0, 0.05), (1, -0.1)))
    ground = bodies(f'(bind "room" (lambda () (union {parts})))').ground
    assert ground == pytest.approx(-0.15 * scale, rel=1e-6)
