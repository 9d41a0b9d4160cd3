"""Physics of scenes, the methods of ``Scene`` that need MuJoCo: what rests, the scene at rest, and its motion."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from scenelang.backends.base import Progress
from scenelang.grammar.diagnostics import SceneError, UsageError
from scenelang.grammar.settings import fits, typed

if TYPE_CHECKING:
    from scenelang.backends.physics.verdicts import PhysicsReport
    from scenelang.grammar.datum import Source
    from scenelang.interpreter.scene.declarations import Declaration
    from scenelang.interpreter.scene.entity import Scene as EntityScene
    from scenelang.scene import Scene
    from scenelang.session import Session

MAX_SPEED = 1e4  # scene units per second that a thing starts with


@dataclass(frozen=True, slots=True, eq=False)
class MovedScene:
    """A scene whose bodies have moved under gravity.

    Attributes
    ----------
    scene : Scene
        The scene at rest, or a 4D scene of its motion.
    report : PhysicsReport
        What became of each body.
    """

    scene: Scene
    report: PhysicsReport

    def __repr__(self) -> str:
        moved = sum(body.kind != "rests" for body in self.report.bodies)
        return f"<MovedScene: {moved:,} of {len(self.report.bodies):,} bodies moved>"


@typed
def physics(
    self: Scene,
    frame: int = 0,
    *,
    seconds: float = 1.5,
    metres_per_unit: float | None = None,
    progress: Progress | None = None,
) -> PhysicsReport:
    """Simulate a frame under gravity and return which bodies rest, move, tip over, fall or explode (docs/physics.md).

    Parameters
    ----------
    frame : int
        Frame of a 4D scene, counted from 0.
    seconds : float
        Simulated time.
    metres_per_unit : float, optional
        Scale; by default the diagonal of the scene is 2 m.
    progress : callable, optional
        Called with a fraction from 0 to 1; an exception raised by it ends the simulation.

    Raises
    ------
    SceneError
        If the scene cannot be simulated, or the packages of ``scenelang[physics]`` are missing.
    """
    from scenelang.backends.physics.verdicts import report_of

    self._frame(frame)
    return report_of(self.graph, frame, seconds, checked_scale(metres_per_unit), progress)


@typed
def settle(
    self: Scene, *, seconds: float = 5.0, metres_per_unit: float | None = None, progress: Progress | None = None
) -> MovedScene:
    """Return the first frame with its bodies where they come to rest. The arguments are those of ``physics``."""
    from scenelang.backends.physics.settling import settled

    found = settled(self.graph, seconds, checked_scale(metres_per_unit), progress)
    return MovedScene(replace(self, graph=found.scene, program=None), found.report)


@typed
def simulate(
    self: Scene,
    *,
    seconds: float = 2.0,
    fps: float = 24.0,
    metres_per_unit: float | None = None,
    velocities: Mapping[str, Sequence[float]] | None = None,
    progress: Progress | None = None,
) -> MovedScene:
    """Return the motion of the first frame as a 4D scene of ``fps`` frames per second.

    ``velocities`` are initial velocities by word, (x, y, z) in scene units per second, of all bodies with that word on
    their path. The other arguments are those of ``physics``.
    """
    from scenelang.backends.physics.settling import simulated

    for word, velocity in (velocities or {}).items():
        if len(velocity) != 3 or not all(fits(x, "float") and abs(x) <= MAX_SPEED for x in velocity):
            expected = f"three numbers of at most {MAX_SPEED:g}"
            raise SceneError("value", f"`velocities`: expected {expected} for {word!r}, got {velocity!r}")
    if not 0.0 < fps <= 1000.0:
        raise SceneError("value", f"`fps`: expected a number above 0, at most 1000, got {fps:g}")
    graph, report = simulated(self.graph, seconds, fps, checked_scale(metres_per_unit), velocities, progress)
    return MovedScene(replace(self, graph=graph, program=None), report)


def translated(session: Session, source: Source) -> Source:
    """Return the program that a language model's Python is translated to, which can be edited."""
    from scenelang.grammar.datum import Source

    translation = session.transpile(source)
    if not translation.ok:
        message = f"`settle` edits programs in the Scene Language, and `{source.name}` cannot be translated as a whole"
        raise UsageError("value", message, "write the scene instead: `-o OUT.json`")
    return Source(f"{source.name}.scene", translation.text)


def checked_scale(metres_per_unit: float | None) -> float | None:
    """Return a scale that can be used; raises SceneError("value")."""
    if metres_per_unit is not None and not 1e-9 <= metres_per_unit <= 1e9:
        raise SceneError("value", f"`metres_per_unit`: expected a number from 1e-9 to 1e9, got {metres_per_unit!r}")
    return metres_per_unit


def picture_finding(
    scene: EntityScene, path: Path, stated: Sequence[Declaration], geometry: bool,
    simulated: tuple[float | None, float | None] | None,
) -> bool:  # fmt: skip
    """Write a picture of the first declaration that does not hold, or else of the gravest finding of the geometry lint,
    or of a simulation of so many seconds and metres per unit; False if there is none."""
    from scenelang.backends.geometry.lint import picture_of_findings
    from scenelang.backends.geometry.relations import picture_of_declarations
    from scenelang.backends.physics.verdicts import SECONDS, picture_of_motion

    if picture_of_declarations(scene, stated, path):
        return True
    if geometry and picture_of_findings(scene, path):
        return True
    return simulated is not None and picture_of_motion(scene, path, simulated[0] or SECONDS, simulated[1])
