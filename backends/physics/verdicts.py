"""Verdicts on the bodies of a frame under gravity: whether each rests, moves, tips over, falls or explodes, and why.

Thresholds are relative to a body's own size, so that verdicts do not depend on the unit of a scene. Bodies that move
because their support does are reported with it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from scenelang.backends.base import Progress
from scenelang.backends.physics.colliders import FloatArray
from scenelang.backends.physics.dynamics import GRAVITY, Motion, simulate
from scenelang.backends.physics.grouping import BodySet, bodies_of
from scenelang.backends.surfaces.convex import beyond_edge, hull_of
from scenelang.backends.surfaces.marks import Marks
from scenelang.grammar.datum import Span
from scenelang.grammar.diagnostics import Diagnostic, SceneError
from scenelang.interpreter.scene.entity import Entity, Scene

SECONDS = 1.5  # simulated by default: a body falls 11 m, many times the 2 m of a scene without a scale
MOVES = 0.03  # of the body's longest side: less is not noticed in an image
TURNS = 15.0  # degrees about any axis
TIPS = 20.0  # degrees between the body's upright axis before and after
FALLS = 0.5  # of the body's height
_MAX_ENERGY_RATIO = 1.5  # of the energy of a fall from the top of the scene: overlaps that are pushed apart add energy
_MAX_DIAGNOSTICS = 50  # diagnostics; further bodies are counted in one
_PUSHED = "it slides or is pushed"  # reason of a body that moves although its support is wide enough
KINDS = ("explodes", "falls", "tips", "moves", "rests")


@dataclass(frozen=True, slots=True)
class BodyReport:
    """Verdict on one body.

    Attributes
    ----------
    words
        Words from the root to the entity that is the body.
    kind
        "rests", "moves", "tips", "falls" or "explodes".
    mass
        Mass in kg.
    fixed
        Whether it cannot move.
    size
        Longest side of its axis-aligned box, in scene units.
    center : (x, y, z)
        Center of mass at the start, in scene units.
    moved, drop, tilt
        Final distance of the center of mass from its start and its descent, in scene units; degrees by which the
        upright axis turned.
    when
        Seconds until it had moved noticeably, None if it rests.
    why
        Reason in words; empty if it rests.
    cause
        Number of the body whose motion takes it along, None if it has its own cause.
    place
        Source location of the body, None if unknown.
    note
        Why its place may be meant, as the facts of the frame say; "immersed" in what light passes, "narrow" if it has
        little balance.
    verdict
        How it cannot stay by the facts of the frame: "tips", "slides", "falls" or "floating"; empty if it can.
    farthest, turned
        Greatest distance of the center of mass from its start, and greatest rotation in degrees, at any time.
    """

    words: tuple[str, ...]
    kind: str
    mass: float
    fixed: bool
    size: float
    center: tuple[float, float, float]
    moved: float
    drop: float
    tilt: float
    when: float | None
    why: str
    cause: int | None = None
    place: Span | None = None
    farthest: float = 0.0
    turned: float = 0.0
    note: str = ""
    verdict: str = ""

    def data(self) -> dict[str, Any]:
        """Return the report as JSON data, without the place."""
        names = ("kind", "mass", "fixed", "size", "moved", "drop", "tilt", "when", "why", "cause", "farthest", "turned",
                 "note", "verdict")  # fmt: skip
        return {"words": list(self.words), **{name: getattr(self, name) for name in names}, "center": list(self.center)}


@dataclass(frozen=True, slots=True)
class PhysicsReport:
    """Verdicts on the bodies of a frame.

    Attributes
    ----------
    bodies
        One report per body, in depth-first order.
    seconds
        Simulated time.
    metres_per_unit, ground
        Scale, and height of the ground in scene units.
    """

    bodies: tuple[BodyReport, ...]
    seconds: float
    metres_per_unit: float
    ground: float

    @property
    def stable(self) -> bool:
        """Whether every body rests."""
        return all(body.kind == "rests" for body in self.bodies)

    def data(self) -> dict[str, Any]:
        """Return the report as JSON data."""
        return {
            "stable": self.stable, "seconds": self.seconds, "metres_per_unit": self.metres_per_unit,
            "ground": self.ground, "bodies": [body.data() for body in self.bodies],
        }  # fmt: skip


def report_of(
    scene: Scene,
    frame: int = 0,
    seconds: float = SECONDS,
    metres_per_unit: float | None = None,
    progress: Progress | None = None,
) -> PhysicsReport:
    """Simulate a frame and return the verdicts on its bodies; raises as ``bodies_of`` and ``simulate`` do."""
    bodies = bodies_of(scene.frames[frame], metres_per_unit)
    return reported(bodies, simulate(bodies, seconds, progress=progress), seconds)


def reported(bodies: BodySet, motion: Motion, seconds: float) -> PhysicsReport:
    """Return the verdicts on a motion."""
    fastest = _fastest(bodies, motion)
    reports: dict[int, BodyReport] = {}
    for number in np.argsort(motion.centers[-1, :, 1], kind="stable").tolist():  # supports before the bodies on them
        resting = [below for below in motion.landed[number] if below in reports and reports[below].kind == "rests"]
        reports[number] = _report(bodies, motion, number, fastest, resting)
    explained = _with_causes([reports[number] for number in range(len(reports))], motion)
    return PhysicsReport(tuple(explained), seconds, bodies.unit, bodies.ground)


def _report(bodies: BodySet, motion: Motion, number: int, fastest: float, resting: Sequence[int]) -> BodyReport:
    """Return the verdict on a body that comes to rest on ``resting``, bodies that do not move noticeably.

    Its sinking is measured relative to the lowest of these, so that courses of bricks with small gaps between them
    rest.
    """
    body = bodies.bodies[number]
    paths = motion.centers - motion.centers[0]
    path = paths[:, number].copy()
    sunk = min(resting, key=lambda below: float(paths[-1, below, 1]), default=None)
    if sunk is not None and paths[-1, sunk, 1] < 0.0:
        path[:, 1] = np.minimum(path[:, 1] - paths[:, sunk, 1], np.maximum(path[:, 1], 0.0))
    tilts = np.degrees(np.arccos(np.clip(motion.rotations[:, number, 1, 1], -1.0, 1.0)))
    turns = np.degrees(np.arccos(np.clip((np.trace(motion.rotations[:, number], axis1=1, axis2=2) - 1) / 2, -1.0, 1.0)))
    moved = np.linalg.norm(path, axis=1)
    # A ball that turns in place looks as before.
    noticed = (moved > MOVES * body.size) | ((turns > TURNS) & (moved > 1e-3 * body.size)) | (tilts > TIPS)
    drop, tilt = float(-paths[-1, number, 1]), float(tilts[-1])
    exploded = not body.fixed and (motion.broken is not None or motion.speeds[number] > fastest)
    when = None if body.fixed or not (noticed.any() or exploded) else float(motion.times[int(np.argmax(noticed))])
    kind = "rests"
    if when is not None:
        points, _ = motion.supports[number]
        lost = not len(points) and drop > MOVES * body.size
        aside = float(np.hypot(path[-1, 0], path[-1, 2]))
        falls = lost or drop > max(aside, FALLS * float(body.high[1] - body.low[1]))  # otherwise it slides down a slope
        kind = "explodes" if exploded else "falls" if falls else "tips" if tilt > TIPS else "moves"
    return BodyReport(
        body.words, kind, body.moments.mass, body.fixed, body.size, _triple(body.moments.center),
        float(np.linalg.norm(paths[-1, number])), drop, tilt, when, _why(bodies, motion, number, kind), None,
        bodies.place(body), float(moved.max()), float(turns.max()), body.note, body.verdict,
    )  # fmt: skip


def _triple(values: FloatArray) -> tuple[float, float, float]:
    """Return a vector (3,) as a tuple of floats."""
    x, y, z = values.tolist()
    return (x, y, z)


def _fastest(bodies: BodySet, motion: Motion) -> float:
    """Return the greatest speed that gravity and the initial velocities can give a body, with a margin."""
    top = max(float(body.high[1]) for body in bodies.bodies)
    bottom = min(float(motion.centers[:, :, 1].min()), bodies.ground)
    limit = motion.launch**2 + 2.0 * GRAVITY / bodies.unit * (top - bottom)
    return math.sqrt(_MAX_ENERGY_RATIO * limit)


def _why(bodies: BodySet, motion: Motion, number: int, kind: str) -> str:
    """Return the reason in words for the verdict on a body."""
    body = bodies.bodies[number]
    if kind == "rests":
        return ""
    if kind == "explodes":
        if motion.broken is not None:
            return "the simulation lost its numbers"
        return f"it reaches {motion.speeds[number]:.3g} units/s, more than any fall here: it starts inside something"
    points, _ = motion.supports[number]
    if not len(points):
        return "nothing carries it"
    beyond, _ = beyond_edge(points[:, [0, 2]], body.moments.center[[0, 2]])
    if beyond > 1e-3 * body.size:
        return f"its center of mass is {beyond:.3g} beyond the edge of what it stands on"
    if beyond > -1e-2 * body.size:
        return "its center of mass is above the edge of what it stands on"
    return _PUSHED


def _with_causes(reports: Sequence[BodyReport], motion: Motion) -> list[BodyReport]:
    """Return the reports, with the body that takes each along.

    A body that is well supported moves because one below it does. Times do not decide: of two bodies that topple
    together, the upper one moves first. A cause is lower than the body that it moves, so that causes form no cycle.
    """
    explained: list[BodyReport] = []
    for number, report in enumerate(reports):
        _, below = motion.supports[number]
        movers = [n for n in below if n >= 0 and reports[n].kind != "rests" and reports[n].center[1] < report.center[1]]
        if report.why != _PUSHED or not movers:
            explained.append(report)
            continue
        cause = min(movers, key=lambda other: (reports[other].when or 0.0, other))
        quoted = '"' + "/".join(reports[cause].words[-2:]) + '"'
        explained.append(replace(report, cause=cause, why=f"{quoted}, on which it stands, {reports[cause].kind}"))
    return explained


def marked_motion(
    scene: Scene, seconds: float = SECONDS, metres_per_unit: float | None = None
) -> tuple[Entity, Marks] | None:
    """Return the root of the scene, and marks on the worst moving body and its supports; None if all bodies rest."""
    bodies = bodies_of(scene.root, metres_per_unit)
    motion = simulate(bodies, seconds)
    reports = reported(bodies, motion, seconds).bodies
    moving = [number for number, body in enumerate(reports) if body.kind != "rests" and body.cause is None]
    if not moving:
        return None
    number = min(moving, key=lambda body: (KINDS.index(reports[body].kind), body))
    points, below = motion.supports[number]
    ranks = np.cumsum([node.entity.is_primitive for node in bodies.nodes]) - 1
    rows = [frozenset(int(ranks[bodies.parts[part].node]) for part in body.parts) for body in bodies.bodies]
    center = bodies.bodies[number].moments.center
    level = float(points[:, 1].max()) if len(points) else bodies.ground
    lines = [[center, [center[0], level, center[2]]]]
    corners = np.insert(hull_of(points[:, [0, 2]]), 1, level, axis=1) if len(points) else np.zeros((0, 3))
    lines += [[a, b] for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True)]
    supports = frozenset(row for support in below if support >= 0 for row in rows[support])
    return scene.root, Marks(rows[number], supports, corners, np.array(lines, np.float64), center[None])


# --- diagnostics ------------------------------------------------------------------------------------------------------


def check_physics(
    scene: Scene, seconds: float = SECONDS, metres_per_unit: float | None = None, progress: Progress | None = None
) -> list[Diagnostic]:
    """Return one warning for every kind of object that does not rest; only the first frame of a 4D scene is checked."""
    try:
        return diagnostics_of(report_of(scene, 0, seconds, metres_per_unit, progress))
    except SceneError as error:
        if error.name != "empty-scene":
            raise
        where = "frame 0, the only one that is simulated: " if scene.animated else ""
        return [Diagnostic("not-simulated", f"nothing was simulated: {where}{error.message}", None, error.hint)]


def diagnostics_of(report: PhysicsReport) -> list[Diagnostic]:
    """Return the warnings of a report, worst first, and notes on what rests though by the facts it cannot.

    Only bodies with their own cause are reported; equal ones share a warning.
    """
    groups: dict[tuple[str, tuple[str, ...]], list[int]] = {}
    for number, body in enumerate(report.bodies):
        if body.kind != "rests" and body.cause is None:
            groups.setdefault((body.kind, body.words), []).append(number)
    order = sorted(groups.items(), key=lambda group: (KINDS.index(group[0][0]), -len(group[1]), group[1][0]))
    shown = [_diagnostic(report, members) for _, members in order[:_MAX_DIAGNOSTICS]]
    if len(order) > _MAX_DIAGNOSTICS:
        rest = sum(len(members) for _, members in order[_MAX_DIAGNOSTICS:])
        shown.append(Diagnostic("body-moves", f"{rest} more bodies move, which are not shown"))
    resting: dict[tuple[str, tuple[str, ...]], list[BodyReport]] = {}
    for body in report.bodies:
        if body.kind == "rests" and body.verdict and not body.fixed:
            resting.setdefault((body.verdict, body.words), []).append(body)
    return [*shown, *[_at_rest(kind, alike) for (kind, _), alike in resting.items()][:_MAX_DIAGNOSTICS]]


def _at_rest(kind: str, bodies: Sequence[BodyReport]) -> Diagnostic:
    """Return the note on equal bodies that rest in the simulation, against the facts."""
    times = f" ({len(bodies)} times)" if len(bodies) > 1 else ""
    name = '"' + "/".join(bodies[0].words[-3:]) + '"'
    return Diagnostic("body-note", f"{name} rests{times}, but {_UNSTABLE[kind]}", bodies[0].place)


def _diagnostic(report: PhysicsReport, members: Sequence[int]) -> Diagnostic:
    """Return the warning about bodies of one kind and path, of which the one that moves most is described."""
    first = max((report.bodies[number] for number in members), key=lambda body: body.moved / body.size)
    times = f" ({len(members)} times)" if len(members) > 1 else ""
    name = '"' + "/".join(first.words[-3:]) + '"'
    motion = {
        "explodes": f"{name} flies apart from what it overlaps",
        "falls": f"{name} falls by {first.drop:.3g}",
        "tips": f"{name} tips over by {first.tilt:.0f} degrees",
        "moves": f"{name} {_motion(first)}",
    }[first.kind]
    message = f"{motion} after {first.when or 0.0:.2g} s{times}: {first.why}"
    followers = sum(1 for number in range(len(report.bodies)) if _root_cause(report.bodies, number) in members)
    if followers:
        message += f"; {followers} more {'body goes' if followers == 1 else 'bodies go'} with it"
    if first.note and first.kind != "explodes":
        return Diagnostic("body-note", f"{message}; it may be meant, or be narrowly balanced", first.place)
    return Diagnostic(f"body-{first.kind}", message, first.place, _HINTS[first.kind])


def _motion(body: BodyReport) -> str:
    """Return in words how far a body moves at most, even if it comes back in the end."""
    if body.moved > MOVES * body.size:
        return f"moves by {body.moved:.3g}"
    if body.farthest > MOVES * body.size:
        return f"moves by {body.farthest:.3g} and back"
    return f"turns by {body.turned:.0f} degrees"


def _root_cause(bodies: Sequence[BodyReport], number: int) -> int | None:
    """Return the first cause of a body's motion, None if it has none."""
    cause = bodies[number].cause
    while cause is not None and bodies[cause].cause is not None:
        cause = bodies[cause].cause
    return cause


_UNSTABLE = {
    "tips": "does not bear a shift of its center of mass by 1 % of its breadth",
    "slides": "stays only by friction of what presses it by chance",
    "falls": "nothing balances it",
    "floating": f"only after falling by less than {MOVES:.0%} of its size",
}
_HINTS = {
    "explodes": "move the overlapping parts apart, or make them one body with `:body #t`",
    "falls": "put it on something, join it to what holds it with `:body #t` around both, or give it `:fixed #t`",
    "tips": "move it over its support, widen the support, or give it `:fixed #t`",
    "moves": "level what carries it, raise its `:friction`, or give it `:fixed #t`",
}
