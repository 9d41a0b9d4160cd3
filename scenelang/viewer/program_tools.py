"""What the studio asks about a program besides its picture: edits, checks, measures, values, still images."""

from __future__ import annotations

import base64
import io
import struct
from collections.abc import Callable, Mapping
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from scenelang.backends.surfaces.solids import FloatArray
from scenelang.grammar.datum import Source
from scenelang.grammar.diagnostics import SceneError, capped
from scenelang.interpreter.inspection.instance_paths import Locator, outermost, primitive_ranges
from scenelang.interpreter.plugins import SERVICES
from scenelang.interpreter.scene.entity import Scene
from scenelang.session.checking import Examination
from scenelang.session.session import Session
from scenelang.viewer.workspace import OpenSession, Tools, diagnostic_data

if TYPE_CHECKING:
    from scenelang.backends.surfaces.distance import IntArray

TOOLS = ("change", "examine", "gap", "evaluate", "still")
_MAX_PAIRS = 4_000_000  # pairs of primitives of two objects whose boxes are compared
_BATCH_PAIRS = 2_000  # of which exact distances are computed at once, the nearest boxes first
_MAX_SIDE = 4_096  # pixels of a still image
_MAX_EXPRESSION = 20_000  # characters
_FRACTION = struct.Struct("=d")


class SharedProgress:
    """A fraction from 0 to 1 that a worker's process writes and the server reads; create it before the worker."""

    def __init__(self) -> None:
        import mmap  # which browsers lack

        self._memory = mmap.mmap(-1, _FRACTION.size)

    def write(self, fraction: float) -> None:
        """Set the fraction."""
        self._memory[:] = _FRACTION.pack(fraction)

    def read(self) -> float:
        """Return the fraction."""
        return float(_FRACTION.unpack(self._memory[:])[0])


def tools(open_session: OpenSession, report: Callable[[float], None] | None = None) -> Tools:
    """Create the functions of the studio that take a program, by the names of ``TOOLS``.

    ``report`` receives the progress of a still image.
    """
    functions: dict[str, Callable[[Session, Source, Mapping[str, Any]], dict[str, Any]]] = {
        "change": _changed, "examine": _examined, "gap": _gap, "evaluate": _evaluated,
        "still": partial(_still, report=report),
    }  # fmt: skip

    def use(tool: str, path: str, text: str, data: Mapping[str, Any]) -> dict[str, Any]:
        """Call a tool."""
        return functions[tool](open_session(path, {}), Source(path, text), data)

    return use


def _changed(session: Session, source: Source, data: Mapping[str, Any]) -> dict[str, Any]:
    """Change objects of a scene by an edit of its program, which evaluation proves.

    Returns the text after the edit, the line that it changed, and the numbers of instances and of other primitives that
    changed. Where nothing shares a change that is asked for all that share it, the text is None.
    """
    try:
        result = SERVICES.find("instance-edits")(session, source, data)
    except SceneError:
        if data.get("shared") is True:
            return {"text": None}
        raise
    return {"text": result.text, "line": result.line, "instances": result.instances, "others": result.others}


# --- checks of the geometry --------------------------------------------------------------------------------------


def _examined(session: Session, source: Source, data: Mapping[str, Any]) -> dict[str, Any]:
    """Check the geometry of a scene, as `check --geometry` does; edits that repair it have been tried."""
    examined = Examination(session, run=True, geometry=True, complete=True).of(source)
    marks = {} if examined.scene is None else _marks(examined.scene)
    findings = []
    for diagnostic in capped(examined.diagnostics):
        finding = diagnostic_data(diagnostic, source.name)
        if (diagnostic.name, diagnostic.message) in marks:
            finding["marks"] = marks[diagnostic.name, diagnostic.message]
        findings.append(finding)
    return {"diagnostics": findings}


def _marks(scene: Scene) -> dict[tuple[str, str], dict[str, Any]]:
    """Return where each finding is in the picture, by the name and the message of its diagnostic.

    Objects are ranges of the frame's primitives; points and lines are in the units of the scene.
    """
    marked = SERVICES.find("geometry-marks")(scene)
    return {
        (each.name, each.message): {"frame": each.frame, "objects": [_mark(m) for m in each.marks]} for each in marked
    }


def _mark(marks: Any) -> dict[str, Any]:
    """Return the marks of one object as JSON data."""
    return {
        "subject": _runs(marks.subject), "other": _runs(marks.other), "points": marks.points.tolist(),
        "lines": marks.lines.tolist(), "centers": marks.centers.tolist(),
    }  # fmt: skip


def _runs(rows: frozenset[int]) -> list[list[int]]:
    """Return sorted numbers as ranges [first, end)."""
    runs: list[list[int]] = []
    for row in sorted(rows):
        if runs and runs[-1][1] == row:
            runs[-1][1] = row + 1
        else:
            runs.append([row, row + 1])
    return runs


# --- measures ----------------------------------------------------------------------------------------------------


def _gap(session: Session, source: Source, data: Mapping[str, Any]) -> dict[str, Any]:
    """Return the shortest distance between two objects of a frame, 0 if they touch, and whether it is exact.

    Meshes and solids are measured by what the geometry checks take for them, so that theirs may be too short.
    """
    from scenelang.backends.surfaces.convex import bodies_of
    from scenelang.backends.surfaces.distance import Pairs, distances

    frame = data.get("frame", 0)
    scene = session.evaluate(source).require()
    if type(frame) is not int or not 0 <= frame < len(scene.frames):
        raise SceneError("value", "there is no such frame")
    bodies = bodies_of(scene.frames[frame])
    first, second = (_solids_of(scene, frame, data.get(name), bodies.row) for name in ("from", "to"))
    low, high = bodies.boxes
    lowest = _box_distances(low[first], high[first], low[second], high[second])
    distance = _least(
        lowest, lambda a, b: distances(Pairs(bodies.solids.take(first[a]), bodies.solids.take(second[b])))
    )
    return {"distance": distance, "exact": bool(bodies.exact[first].all() and bodies.exact[second].all())}


def _solids_of(scene: Scene, frame: int, path: Any, rows: IntArray) -> IntArray:
    """Return the positions of the solids of an object among those of a frame; raises SceneError if it has none."""
    if not isinstance(path, str):
        raise SceneError("value", "expected the paths of two objects")
    instances = list(outermost(Locator(scene, frame).find(path)))
    ranges = primitive_ranges(scene.frames[frame], instances)
    inside = np.zeros(len(rows), bool)
    for first, last in ranges:
        inside |= (rows >= first) & (rows < last)
    if not inside.any():
        raise SceneError("value", f"`{path}` has no geometry to measure")
    return np.flatnonzero(inside)


def _box_distances(low: FloatArray, high: FloatArray, other_low: FloatArray, other_high: FloatArray) -> FloatArray:
    """Return the distances (N, M) between N and M boxes, which are lower bounds of those of their contents."""
    if len(low) * len(other_low) > _MAX_PAIRS:
        raise SceneError("unsupported", "the objects have too many primitives to measure", "select parts of them")
    apart = np.maximum(other_low[None] - high[:, None], low[:, None] - other_high[None])
    return np.asarray(np.linalg.norm(np.maximum(apart, 0.0), axis=2), np.float64)


def _least(lowest: FloatArray, measured: Callable[[IntArray, IntArray], FloatArray]) -> float:
    """Return the least distance of all pairs, given lower bounds (N, M) and a function that measures some of them."""
    order = np.argsort(lowest, axis=None, kind="stable")
    bounds, best = lowest.ravel()[order], np.inf
    for start in range(0, len(order), _BATCH_PAIRS):
        if bounds[start] >= best:
            break
        a, b = np.unravel_index(order[start : start + _BATCH_PAIRS], lowest.shape)
        best = min(best, float(measured(a, b).min()))
    return best


# --- values ------------------------------------------------------------------------------------------------------


def _evaluated(session: Session, source: Source, data: Mapping[str, Any]) -> dict[str, Any]:
    """Evaluate an expression in the context of the program, as the REPL does after it has loaded the file."""
    text = data.get("expression")
    if not isinstance(text, str) or len(text) > _MAX_EXPRESSION:
        raise SceneError("value", f"expected an expression of at most {_MAX_EXPRESSION:,} characters")
    values, log, diagnostics = SERVICES.find("answer-in-program")(session, source, text)
    return {"values": values, "log": log, "diagnostics": [diagnostic_data(each) for each in capped(diagnostics)]}


# --- still images ------------------------------------------------------------------------------------------------


def _still(
    session: Session, source: Source, data: Mapping[str, Any], report: Callable[[float], None] | None
) -> dict[str, Any]:
    """Render a path-traced image of a scene from a camera, and return it as a PNG file in base 64."""
    from PIL import Image

    from scenelang.backends.pictures.declared import view_of
    from scenelang.backends.pictures.film import PictureOptions, draw, picture_backend

    size, frame, camera = [data.get("width"), data.get("height")], data.get("frame"), data.get("camera")
    width, height = (side if type(side) is int and 16 <= side <= _MAX_SIDE else 0 for side in size)
    if not (width and height):
        raise SceneError("value", f"the sides of an image are 16 to {_MAX_SIDE:,} pixels")
    if not isinstance(camera, str) or type(frame) is not int:
        raise SceneError("value", "expected a camera and a frame")
    if report is not None:
        report(0.0)
    backend = picture_backend("final")
    options = PictureOptions(
        width=width, height=height, camera=view_of(camera), frame=frame, progress=report,
        limit=session.options.limits.primitives, labels=False,
    )  # fmt: skip
    picture = draw(session.evaluate(source).require(), options, backend).picture
    file = io.BytesIO()
    Image.fromarray(picture).save(file, "png")
    return {"png": base64.b64encode(file.getvalue()).decode("ascii")}
