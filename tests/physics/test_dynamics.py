"""Simulations against closed forms: free fall, friction angles, overhanging stacks, rest; and what is out of range."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

import scenelang as sl
from scenelang.backends.physics.dynamics import GRAVITY, Motion, compiled, model_of, quaternion, simulate
from scenelang.backends.physics.grouping import BodySet, bodies_of
from scenelang.backends.physics.robots import roll_pitch_yaw
from scenelang.backends.surfaces.convex import beyond_edge

pytest.importorskip("mujoco")
EXAMPLES = Path(__file__).parents[2] / "examples"
SLOPE = """
(bind "plane" (lambda () (call "cube" :scale [6 .2 2])))
(bind "block" (lambda () (call "cube" :scale [.4 .2 .4])))
(bind "hill" (lambda ()
  (transform (union (call "plane" :fixed #t) (transform (call "block" :friction {mu}) (translate [0 .2 0])))
             (rotate {angle} [0 0 1]))))
"""


def bodies(text: str, unit: float | None = 1.0) -> BodySet:
    return bodies_of(sl.evaluate(text).root, unit)


def shift(motion: Motion, body: int = 0) -> np.ndarray:
    return np.asarray(motion.centers[-1, body] - motion.centers[0, body])


def test_free_fall() -> None:
    found = bodies('(bind "ball" (lambda () (call "sphere"))) (bind "floor" (lambda () (call "cube" :scale [3 1 3])))'
                   '(bind "a" (lambda () (union (call "floor") (transform (call "ball") (translate [0 30 0])))))')  # fmt: skip
    motion = simulate(found, 1.0)
    fall = motion.centers[:, 1, 1] - motion.centers[0, 1, 1]
    # the semi-implicit step adds half a step of velocity
    assert fall == pytest.approx(-GRAVITY / 2 * motion.times**2, abs=GRAVITY * motion.times[-1] / 500)
    assert np.abs(shift(motion, 1)[[0, 2]]).max() < 1e-9


@pytest.mark.parametrize(("mu", "share"), [(0.3, 0.9), (0.6, 0.9), (0.3, 1.1), (0.6, 1.1)])
def test_a_block_slides_where_the_slope_is_steeper_than_the_friction_angle(mu: float, share: float) -> None:
    angle = math.atan(mu) * share
    motion = simulate(bodies(SLOPE.format(mu=mu, angle=angle)), 1.0)
    slid = float(np.linalg.norm(shift(motion, 1)))
    expected = GRAVITY / 2 * (math.sin(angle) - mu * math.cos(angle))
    assert slid == pytest.approx(max(0.0, expected), rel=0.05, abs=2e-3)


def stack(count: int, share: float) -> str:
    """Bricks of length 1, each beyond the one below by ``share`` of what the harmonic series allows."""
    offsets = np.cumsum([0.0] + [share / (2 * (count - k)) for k in range(1, count)])
    parts = [f'(transform (call "brick") (translate [{x:.6f} {0.1 + 0.2 * k} 0]))' for k, x in enumerate(offsets)]
    return f'(bind "brick" (lambda () (call "cube" :scale [1 .2 .5]))) (bind "stack" (lambda () (union {" ".join(parts)})))'


@pytest.mark.parametrize("count", [2, 4, 6])
def test_an_overhanging_stack_topples_beyond_the_harmonic_limit(count: int) -> None:
    def tilt(share: float) -> float:
        upright = simulate(bodies(stack(count, share)), 2.0).rotations[-1, :, 1, 1]
        return float(np.degrees(np.arccos(np.clip(upright, -1.0, 1.0))).max())

    assert tilt(0.95) < 0.5
    assert tilt(1.05) > 10.0


@pytest.mark.parametrize(
    "shape",
    ['"cube"', '"sphere" :radius .5', '"cylinder" :radius .3', '"cone" :radius .5', '"capsule" :radius .5 :p1 [0 0 1]',
     '"torus" :radius .5', '"rounded-cube"'],
)  # fmt: skip
@pytest.mark.parametrize("size", [0.05, 1.0, 20.0])
@pytest.mark.sampled(3)
def test_what_rests_does_not_drift(shape: str, size: float) -> None:
    text = f"""(bind "thing" (lambda () (transform (call {shape}) (scale {size}))))
    (bind "a" (lambda () (on-top-of (call "thing") (transform (call "cube" :scale [9 1 9]) (scale {size})))))"""
    found = bodies(text)
    motion = simulate(found, 5.0)
    for number, body in enumerate(found.bodies):
        assert np.linalg.norm(shift(motion, number)) < 2e-3 * body.size


@pytest.mark.parametrize("angle", [0.0, 0.7])
def test_an_upright_cylinder_rests_on_a_plane_however_its_last_digits_are(angle: float) -> None:
    """Rounding that turns an axis by 1e-15 must not make contacts below the ground."""
    mujoco = pytest.importorskip("mujoco")
    text = '(bind "a" (lambda () (transform (call "cylinder" :radius .6 :p1 [0 .1 0]) (rotate {} [0 1 0]))))'
    found = bodies(text.format(angle))
    model, data = compiled(model_of(found))
    deepest = 0.0
    for tilt in np.linspace(1e-16, 4e-15, 40):
        data.qpos[3:7] = [1.0, tilt, tilt / 3, 0.0]
        data.qpos[2] = 0.05 - 1e-5
        mujoco.mj_kinematics(model, data)
        mujoco.mj_collision(model, data)
        deepest = min(deepest, *(float(contact.dist) for contact in data.contact))
    assert -2e-5 < deepest < 0.0


def test_courses_with_small_gaps_rest() -> None:
    text = """(bind "brick" (lambda () (call "cube" :scale [1 .5 .5])))
    (bind "wall" (lambda () (for/union ((k (iota 8))) (transform (call "brick") (translate (vector 0 (+ .25 (* {} k)) 0))))))"""
    assert {body.kind for body in sl.evaluate(text.format(0.51)).physics().bodies} == {"rests"}
    assert "falls" in {body.kind for body in sl.evaluate(text.format(0.6)).physics().bodies}


@pytest.mark.slow
def test_runs_are_equal() -> None:
    scene = sl.load(EXAMPLES / "jenga.scene")
    first, second = (simulate(bodies_of(scene.root), 0.5) for _ in range(2))
    assert np.array_equal(first.centers, second.centers)
    assert np.array_equal(first.rotations, second.rotations)


def test_a_unit_changes_nothing_by_default() -> None:
    small, large = (bodies(f'(bind "b" (lambda () (call "cube"))) (bind "a" (lambda () (transform (call "b") (scale {k}))))', None)
                    for k in (0.001, 1000.0))  # fmt: skip
    assert small.bodies[0].moments.mass == pytest.approx(large.bodies[0].moments.mass)
    assert small.unit == pytest.approx(1e6 * large.unit)


def test_velocities() -> None:
    found = bodies(stack(2, 0.2))
    motion = simulate(found, 0.1, velocities={"brick": (2.0, 0.0, 0.0)})
    assert shift(motion)[0] == pytest.approx(0.2 - GRAVITY * 0.6 * 0.005, abs=0.01)
    with pytest.raises(sl.SceneError, match='no body that can move has the word "brik"'):
        simulate(found, 0.1, velocities={"brik": (1.0, 0.0, 0.0)})


@pytest.mark.parametrize(("name", "limit"), [("chessboard", 0.01), ("jenga", 0.1)])
@pytest.mark.sampled(2)
def test_examples_settle_without_exploding(name: str, limit: float) -> None:
    report = sl.load(EXAMPLES / f"{name}.scene").physics()
    assert {body.kind for body in report.bodies} <= {"rests", "moves", "falls"}
    assert max(body.moved / body.size for body in report.bodies) < limit


@pytest.mark.parametrize(
    ("text", "error"),
    [
        ('(bind "a" (lambda () (call "cube" :mass 1e300)))', None),
        ('(bind "a" (lambda () (call "cube" :density 1e-300)))', "too light"),
        ('(bind "a" (lambda () (call "cube" :scale [1 0 1])))', "nothing that can be a rigid body"),
        ('(bind "a" (lambda () (call "cylinder" :p1 [0 0 0])))', "nothing that can be a rigid body"),
        ('(bind "a" (lambda () (transform (call "cube") (scale [1 1e-200 1]))))', "nothing that can be a rigid body"),
        ('(bind "a" (lambda () (transform (call "cube") (translate [1e200 0 0]))))', "too large or too far away"),
        ('(bind "a" (lambda () (call "chair")))', "nothing that can be a rigid body"),
        ('(bind "a" (lambda () (call "thing" :density "steal" :body #t)))', "no known substance"),
        ('(bind "a" (lambda () (call "thing" :body "x")))', "must be #t or #f"),
        ('(bind "a" (lambda () (call "cube" :opacity 0)))', "nothing that can be a rigid body"),
    ],
)  # fmt: skip
def test_out_of_range(text: str, error: str | None) -> None:
    scene = sl.evaluate(text)
    if error is None:
        assert all(math.isfinite(body.moved) for body in scene.physics().bodies)
        return
    with pytest.raises(sl.SceneError) as caught:
        scene.physics()
    assert error in caught.value.message


def test_blocks_are_refused() -> None:
    with pytest.raises(sl.SceneError, match="Minecraft blocks are no rigid bodies") as caught:
        sl.evaluate('(bind "a" (lambda () (call "set-cuboid" :block "stone" :scale [2 2 2])))').physics()
    assert caught.value.name == "unsupported"


def test_thin_and_tiny_parts_take_part_or_are_left_out() -> None:
    text = """(bind "sheet" (lambda () (transform (call "cube") (scale [1 1e-5 1]))))
    (bind "dot" (lambda () (call "sphere" :radius 1e-7)))
    (bind "a" (lambda () (union (call "sheet") (transform (call "dot") (translate [0 .1 0])) (call "cube"))))"""
    report = sl.evaluate(text).physics()
    assert all(math.isfinite(body.moved) for body in report.bodies)


def test_a_simulation_can_be_cancelled() -> None:
    def stop(share: float) -> None:
        if share > 0.1:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        sl.evaluate(stack(3, 0.5)).physics(progress=stop)


def test_quaternions_and_angles() -> None:
    rng = np.random.default_rng(1)
    for _ in range(200):
        rotation, _ = np.linalg.qr(rng.normal(size=(3, 3)))
        rotation *= np.sign(np.linalg.det(rotation))
        w, x, y, z = quaternion(rotation)
        made = np.array([
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ])  # fmt: skip
        assert made == pytest.approx(rotation, abs=1e-12)
        a, b, c = roll_pitch_yaw(rotation)
        rx = np.array([[1, 0, 0], [0, math.cos(a), -math.sin(a)], [0, math.sin(a), math.cos(a)]])
        ry = np.array([[math.cos(b), 0, math.sin(b)], [0, 1, 0], [-math.sin(b), 0, math.cos(b)]])
        rz = np.array([[math.cos(c), -math.sin(c), 0], [math.sin(c), math.cos(c), 0], [0, 0, 1]])
        assert rz @ ry @ rx == pytest.approx(rotation, abs=1e-9)


def test_distance_to_the_edge_of_a_support() -> None:
    square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [0.5, 0.5]])
    assert beyond_edge(square, np.array([0.5, 0.6]))[0] == pytest.approx(-0.4)
    assert beyond_edge(square, np.array([1.25, 0.5]))[0] == pytest.approx(0.25)
    assert beyond_edge(square, np.array([2.0, 2.0]))[0] == pytest.approx(math.sqrt(2))
    assert beyond_edge(square[:1], np.array([3.0, 4.0]))[0] == pytest.approx(5.0)
    assert beyond_edge(square[:2], np.array([0.5, 0.5]))[0] == pytest.approx(0.5)
