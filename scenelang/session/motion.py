"""Physics of scenes, the methods of ``Scene`` that need MuJoCo: what rests, the scene at rest, and its motion."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from scenelang.grammar.diagnostics import SceneError, UsageError

if TYPE_CHECKING:
    from scenelang.grammar.datum import Source
    from scenelang.interpreter.scene.declarations import Declaration
    from scenelang.interpreter.scene.entity import Scene as EntityScene
    from scenelang.session.session import Session

MAX_SPEED = 1e4  # scene units per second that a thing starts with


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
