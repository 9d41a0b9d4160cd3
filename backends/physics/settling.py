"""Scenes whose bodies have moved: frames of a motion, the scene at rest, and the program that creates it.

The tree of entities stays as it is. An entity whose parts all belong to one body gets another pose in its parent, so
that its parts stay shared; only the entities above bodies are copied.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from scenelang.backends.base import Progress
from scenelang.backends.physics.colliders import FloatArray
from scenelang.backends.physics.dynamics import Motion, simulate
from scenelang.backends.physics.grouping import BodySet, bodies_of
from scenelang.backends.physics.verdicts import PhysicsReport, reported
from scenelang.grammar.datum import Source
from scenelang.grammar.diagnostics import SceneError
from scenelang.grammar.settings import fits
from scenelang.interpreter.scene.entity import Entity, Scene
from scenelang.interpreter.scene.flatten import flatten_entity
from scenelang.interpreter.values.values import Matrix, Pair

SETTLE_SECONDS = 5.0  # simulated by default until the scene is taken to be at rest
MAX_SPEED = 1e4  # scene units per second, of an initial velocity
# of a body's size, and in radians: a smaller change keeps the pose, since contacts give way by about as much
_MIN_MOTION = 1e-3
_MAX_TURN = 0.05  # of the largest entry of the pose's linear part: a body that turned more is not a mere translation
MAX_EDITS = 12  # literals that are tried, each of which takes an evaluation
_POSE_TOLERANCE = 1e-6  # relative, between the poses of the edited program and those of the settled scene


@dataclass(frozen=True, slots=True, eq=False)
class RestingScene:
    """A scene at rest.

    Attributes
    ----------
    scene
        The first frame of the scene with its bodies at rest.
    report
        Verdicts on the bodies.
    moved
        Numbers of the bodies that have other poses than before.
    """

    scene: Scene
    report: PhysicsReport
    moved: tuple[int, ...]


def settled(
    scene: Scene,
    seconds: float = SETTLE_SECONDS,
    metres_per_unit: float | None = None,
    progress: Progress | None = None,
) -> RestingScene:
    """Return the first frame of a scene at rest; raises as ``bodies_of`` and ``simulate`` do."""
    bodies = bodies_of(scene.root, metres_per_unit)
    motion = simulate(bodies, seconds, progress=progress)
    poses = final_poses(bodies, motion)
    root = moved_root(bodies, poses)
    return RestingScene(scene.with_frames([root], False), reported(bodies, motion, seconds), tuple(poses))


def simulated(
    scene: Scene,
    seconds: float,
    rate: float,
    metres_per_unit: float | None = None,
    velocities: Mapping[str, Sequence[float]] | None = None,
    progress: Progress | None = None,
) -> tuple[Scene, PhysicsReport]:
    """Return the motion of the first frame of a scene as a 4D scene of ``rate`` frames per second.

    ``velocities`` are initial velocities by word, in scene units per second. Raises SceneError("value") for a rate or a
    velocity that is out of range, and as ``bodies_of`` and ``simulate`` do.
    """
    for word, velocity in (velocities or {}).items():
        if len(velocity) != 3 or not all(fits(x, "float") and abs(x) <= MAX_SPEED for x in velocity):
            expected = f"three numbers of at most {MAX_SPEED:g}"
            raise SceneError("value", f"`velocities`: expected {expected} for {word!r}, got {velocity!r}")
    if not 0.0 < rate <= 1000.0:
        raise SceneError("value", f"`fps`: expected a number above 0, at most 1000, got {rate:g}")
    bodies = bodies_of(scene.root, metres_per_unit)
    motion = simulate(bodies, seconds, rate, velocities, progress)
    frames = [
        moved_root(bodies, {number: motion.pose(sample, number) for number in _free(bodies)})
        for sample in range(len(motion.times))
    ]
    return scene.with_frames(frames, True), reported(bodies, motion, seconds)


def _free(bodies: BodySet) -> list[int]:
    """Return the numbers of the bodies that can move."""
    return [number for number, body in enumerate(bodies.bodies) if not body.fixed]


def final_poses(bodies: BodySet, motion: Motion) -> dict[int, FloatArray]:
    """Return the motion (3, 4) of each body that moved, from its start to its final pose."""
    poses = {}
    for number in _free(bodies):
        pose = motion.pose(len(motion.times) - 1, number)
        shift = motion.centers[-1, number] - motion.centers[0, number]
        turn = np.abs(pose[:, :3] - np.eye(3)).max()
        if np.linalg.norm(shift) > _MIN_MOTION * bodies.bodies[number].size or turn > _MIN_MOTION:
            poses[number] = pose
    return poses


def moved_root(bodies: BodySet, poses: Mapping[int, FloatArray]) -> Entity:
    """Return the frame with the bodies moved by ``poses``, (3, 4) each in the world."""
    nodes = bodies.nodes
    inside = bodies.inside
    children: list[list[int]] = [[] for _ in nodes]
    for number in range(len(nodes) - 1, 0, -1):
        children[nodes[number].parent].append(number)
    changed: dict[int, Entity] = {}
    for number in _mixed(children, inside, poses):
        entity = nodes[number].entity
        pairs = [
            Pair(changed.get(child, part.car), _edge(bodies, child, part.cdr, inside[child], poses))
            for child, part in zip(reversed(children[number]), entity.children, strict=True)
        ]
        changed[number] = Entity(entity.word, entity.embedding, tuple(pairs), None, entity.tainted, entity.call_sites)
    return changed.get(0, nodes[0].entity)


def _mixed(
    children: Sequence[Sequence[int]], inside: Sequence[Collection[int]], poses: Collection[int]
) -> Iterator[int]:
    """Yield the nodes whose children need other poses, children before parents."""
    changed = [any(body in poses for body in bodies) for bodies in inside]
    for number in range(len(children) - 1, -1, -1):
        if children[number] and changed[number] and (number == 0 or len(inside[number]) > 1):
            yield number


def _edge(bodies: BodySet, node: int, pose: Matrix, inside: Collection[int], poses: Mapping[int, FloatArray]) -> Matrix:
    """Return the pose of a node in its parent, which does not move itself."""
    if len(inside) != 1 or (body := next(iter(inside))) not in poses:
        return pose
    parent, motion = np.eye(4), np.eye(4)
    parent[:3] = np.array(bodies.nodes[bodies.nodes[node].parent].world).reshape(3, 4)
    local = np.eye(4)
    local[:3] = np.array(pose).reshape(3, 4)
    motion[:3] = poses[body]
    # A parent with a flat pose is singular: its parts can only move in its plane, hence the pseudo-inverse.
    moved_pose = np.linalg.pinv(parent) @ motion @ parent @ local
    return Matrix(moved_pose[:3].ravel().tolist())


# --- edits of programs ------------------------------------------------------------------------------------------------

_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_TRANSLATE = re.compile(rf"\(translate\s+\[\s*({_NUMBER})\s+({_NUMBER})\s+({_NUMBER})\s*\]\s*\)")


@dataclass(frozen=True, slots=True)
class EditedProgram:
    """Program that places some bodies where they rest: its text, and the numbers of those bodies."""

    text: str
    bodies: tuple[int, ...]


def edited_program(
    source: Source, scene: Scene, metres_per_unit: float | None, outcome: RestingScene,
    evaluate: Callable[[Source], Scene | None],
) -> EditedProgram:  # fmt: skip
    """Return the program with literal translations changed, so that bodies start where they rest.

    A literal is changed if its vector occurs once in the text, is the offset of a body that moved without turning, and
    the edited program evaluates to exactly the settled scene as far as the edits go. Evaluation proves every edit; the
    provenance of poses would say more and is not recorded.
    """
    bodies = bodies_of(scene.root, metres_per_unit)
    text = source.text
    edits: dict[int, FloatArray] = {}
    for number in outcome.moved[:MAX_EDITS]:
        pose = _difference(bodies, outcome, number)
        if pose is None:
            continue
        trial = _with_literal(text, bodies, number, pose)
        if trial is None:
            continue
        changed, pose = trial
        edited = evaluate(Source(source.name, changed))
        if edited is not None and _is_same(edited.root, moved_root(bodies, {**edits, number: pose}), bodies.size):
            text, edits = changed, {**edits, number: pose}
    return EditedProgram(text, tuple(edits))


def _difference(bodies: BodySet, outcome: RestingScene, number: int) -> FloatArray | None:
    """Return the translation (3, 4) of a body from its start to its rest, None if it turned."""
    part = bodies.parts[bodies.bodies[number].parts[0]].node
    before = np.array(bodies.nodes[part].world).reshape(3, 4)
    after = _world_in(outcome.scene.root, bodies, part)
    if np.abs(before[:, :3] - after[:, :3]).max() > _MAX_TURN * np.abs(before[:, :3]).max():
        return None
    return np.column_stack([np.eye(3), after[:, 3] - before[:, 3]])


def _world_in(root: Entity, bodies: BodySet, node: int) -> FloatArray:
    """Return the world pose (3, 4) of the node in a tree of the same structure."""
    positions: list[int] = []
    while node > 0:
        parent = bodies.nodes[node].parent
        siblings = [other for other in range(parent + 1, node + 1) if bodies.nodes[other].parent == parent]
        positions.append(len(siblings) - 1)
        node = parent
    world, entity = np.eye(4), root
    for position in reversed(positions):
        local = np.eye(4)
        local[:3] = np.array(entity.children[position].cdr).reshape(3, 4)
        world, entity = world @ local, entity.children[position].car
    return world[:3]


def _with_literal(text: str, bodies: BodySet, number: int, pose: FloatArray) -> tuple[str, FloatArray] | None:
    """Return the text with the offset of a body changed, and the motion (3, 4) of the rounded numbers.

    None if the literal is not certain. Numbers are rounded to the digits that show at the size of the body, and those
    that change by less than a body at rest moves are kept, which hides how far contacts give way.
    """
    digits = math.ceil(-math.log10(2.0 * _MIN_MOTION * bodies.bodies[number].size))
    node, inside = bodies.bodies[number].node, set(bodies.bodies[number].parts)
    for at in _upwards(bodies, node, inside):
        parent = np.array(bodies.nodes[bodies.nodes[at].parent].world).reshape(3, 4)
        world = np.array(bodies.nodes[at].world).reshape(3, 4)
        inverse = np.linalg.pinv(parent[:, :3])
        offset = inverse @ (world[:, 3] - parent[:, 3])
        matches = [
            match for match in _TRANSLATE.finditer(text)
            if np.allclose([float(x) for x in match.groups()], offset, rtol=1e-9, atol=1e-12)
        ]  # fmt: skip
        if len(matches) == 1:
            motion = inverse @ pose[:, 3]
            is_still = (
                np.abs(motion) * np.linalg.norm(parent[:, :3], axis=0) <= _MIN_MOTION * bodies.bodies[number].size
            )
            new = [round(float(x), digits) + 0.0 for x in offset + np.where(is_still, 0.0, motion)]
            edit = f"(translate [{' '.join(f'{x:.12g}' for x in new)}])"
            shift = np.column_stack([np.eye(3), parent[:, :3] @ (np.array(new) - offset)])
            return text[: matches[0].start()] + edit + text[matches[0].end() :], shift
    return None


def _upwards(bodies: BodySet, node: int, inside: Collection[int]) -> Iterator[int]:
    """Yield a body's node and the nodes above it that contain nothing else."""
    while node > 0:
        yield node
        node = bodies.nodes[node].parent
        below = {i for i, part in enumerate(bodies.parts) if _is_below(bodies, part.node, node)}
        if not below <= set(inside):
            return


def _is_below(bodies: BodySet, node: int, above: int) -> bool:
    """Return whether a node is ``above`` or below it; nodes are in pre-order."""
    while node > above:
        node = bodies.nodes[node].parent
    return node == above


def _is_same(first: Entity, second: Entity, size: float) -> bool:
    """Return whether two frames place their primitives alike, for a scene of the given size."""
    a, b = flatten_entity(first).matrices, flatten_entity(second).matrices
    return a.shape == b.shape and bool(np.abs(a - b).max(initial=0.0) <= max(_POSE_TOLERANCE * size, 2e-6))
