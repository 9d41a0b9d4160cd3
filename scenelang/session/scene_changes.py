"""Comparison of two scenes as a list of changes, as data and as text."""

from __future__ import annotations

import json
import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, NoReturn

import numpy as np

from scenelang.backends.files import read_regular
from scenelang.backends.unreadable import unreadable
from scenelang.grammar.diagnostics import LimitError, SceneError
from scenelang.interpreter.inspection.difference import (
    ComparedFrame,
    ComparedSolid,
    compare_frames,
    compared_frame,
    solid_of,
)

if TYPE_CHECKING:
    from scenelang.interpreter.inspection.difference import ComparedFrame, FrameDifference
    from scenelang.interpreter.scene.entity import Scene


TOLERANCE = 1e-5  # relative to the scene's size, as in `interpreter/inspection/difference`
_MAX_FILE_SIZE = 128_000_000  # bytes; parsed data can take thirty times as much memory
_MAX_PATH_LENGTH = 1_000  # words
_HINT = "create one with `scenelang flatten FILE --json`"
_KINDS = ("moved", "recolored", "resized", "missing", "extra")
_PAIRED = "resized"  # this kind is only produced by ``paired_by_path``
_AS_IT_IS: Mapping[str, str] = MappingProxyType({kind: kind for kind in _KINDS})
OF_AN_EDIT: Mapping[str, str] = MappingProxyType({**_AS_IT_IS, "missing": "removed", "extra": "added"})


@dataclass(frozen=True, slots=True)
class Change:
    """A difference between two scenes.

    Attributes
    ----------
    kind
        One of moved, recolored, resized, missing and extra.
    frame, word
        Number of the frame, and word of the object.
    before, after
        Each side: position, color or block, path; None for the side that lacks the object.
    """

    kind: str
    frame: int
    word: str
    before: dict[str, Any] | None
    after: dict[str, Any] | None

    def data(self) -> dict[str, Any]:
        """Return the change as JSON data."""
        facts = {"change": self.kind, "frame": self.frame, "word": self.word}
        return facts | {name: side for name, side in (("a", self.before), ("b", self.after)) if side is not None}


@dataclass(frozen=True, slots=True, repr=False)
class Changes:
    """All differences between the scenes A and B.

    Attributes
    ----------
    frames
        Numbers of frames of A and B. Only frames that exist in both are compared.
    matched
        Number of equal primitives.
    changes
        Differences, ordered by frame.
    """

    frames: tuple[int, int]
    matched: int
    changes: tuple[Change, ...]

    @property
    def equal(self) -> bool:
        """Whether the scenes have equal primitives in as many frames."""
        return not self.changes and self.frames[0] == self.frames[1]

    @property
    def counts(self) -> Counter[str]:
        """Number of changes of each kind."""
        return Counter(change.kind for change in self.changes)

    def __repr__(self) -> str:
        if self.equal:
            return f"<Changes: none, {self.matched:,} primitives match>"
        counts = ", ".join(f"{count:,} {kind}" for kind, count in self.counts.items())
        return f"<Changes: {counts or 'number of frames'}; {self.matched:,} primitives match>"

    def data(self, limit: int | None = None) -> dict[str, Any]:
        """Return the comparison as JSON data, with at most ``limit`` changes (None: all)."""
        counts = self.counts
        return {
            "equal": self.equal,
            "frames": {"a": self.frames[0], "b": self.frames[1]},
            "matched": self.matched,
            **{kind: counts[kind] for kind in _KINDS if counts[kind] or kind != _PAIRED},
            "changes": [change.data() for change in self.changes[:limit]],
        }


# --- comparison --------------------------------------------------------------------------------------------------


def compared_frames(scene: Scene, limit: int) -> list[ComparedFrame]:
    """Flatten the frames of a scene for comparison; raises LimitError for more than ``limit`` primitives."""
    from scenelang.interpreter.scene.flatten import flatten

    return [compared_frame(frame) for frame in flatten(scene, limit).frames]


def compared_frames_in(path: str, limit: int) -> list[ComparedFrame] | None:
    """Read the frames of a flattened scene from a JSON file; None for another kind of file; raises SceneError."""
    from scenelang.files.scene_json import holds_scene

    return read_compared_frames(path, limit) if path.lower().endswith(".json") and not holds_scene(path) else None


def changes_between(
    frames_a: Sequence[ComparedFrame], frames_b: Sequence[ComparedFrame], tolerance: float = TOLERANCE
) -> Changes:
    """Compare frames pairwise.

    Parameters
    ----------
    tolerance
        Largest difference that is ignored, relative to the size of the scene.

    Raises
    ------
    SceneError
        If coordinates are too large to compare, or the tolerance is invalid.
    """
    if not tolerance >= 0.0:
        raise SceneError("value", f"`tolerance`: expected a number of at least 0, got {tolerance:g}")
    changes: list[Change] = []
    matched = 0
    for number, (a, b) in enumerate(zip(frames_a, frames_b)):
        difference = compare_frames(a, b, tolerance)
        matched += difference.matched
        changes += _changes(number, a, b, difference)
    return Changes((len(frames_a), len(frames_b)), matched, tuple(changes))


def _changes(frame: int, a: ComparedFrame, b: ComparedFrame, difference: FrameDifference) -> Iterator[Change]:
    """Yield the changes of a frame: moved and recolored primitives first, then missing, then extra ones."""
    rows_a = [*difference.moved[:, 0].tolist(), *difference.recolored[:, 0].tolist(), *difference.missing.tolist()]
    rows_b = [*difference.moved[:, 1].tolist(), *difference.recolored[:, 1].tolist(), *difference.extra.tolist()]
    before = [_side(a, row, label, difference.positions_a[row]) for row, label in zip(rows_a, a.labels(rows_a))]
    after = [_side(b, row, label, difference.positions_b[row]) for row, label in zip(rows_b, b.labels(rows_b))]
    moved, paired = len(difference.moved), len(difference.moved) + len(difference.recolored)
    for i in range(paired):
        kind = "moved" if i < moved else "recolored"
        yield Change(kind, frame, a.solid(rows_a[i]).word, before[i], after[i])
    for i in range(paired, len(rows_a)):
        yield Change("missing", frame, a.solid(rows_a[i]).word, before[i], None)
    for i in range(paired, len(rows_b)):
        yield Change("extra", frame, b.solid(rows_b[i]).word, None, after[i])


def _side(frame: ComparedFrame, row: int, label: str, place: Any) -> dict[str, Any]:
    """Describe a primitive as one side of a change."""
    solid = frame.solid(row)
    look: dict[str, Any] = {"block": solid.look} if solid.is_block else {"color": list(solid.color)}
    if solid.look and not solid.is_block:
        look["material"] = solid.look
    return {"path": label, "at": place.tolist(), **look}


def paired_by_path(comparison: Changes) -> Changes:
    """Combine removed and added primitives of the same path, in order, into one change.

    It is an object whose size, or both position and look, changed; the comparison matches only primitives that have one
    of these in common.
    """
    left: dict[tuple[int, str, str], list[Change]] = {}
    for change in comparison.changes:
        if change.kind == "extra":
            left.setdefault(_address(change), []).append(change)
    paired: list[Change] = []
    for change in comparison.changes:
        partners = left.get(_address(change), []) if change.kind == "missing" else []
        if partners:
            paired.append(Change(_PAIRED, change.frame, change.word, change.before, partners.pop(0).after))
        elif change.kind != "extra":
            paired.append(change)
    added = (change for rest in left.values() for change in rest)
    return Changes(comparison.frames, comparison.matched, (*paired, *added))


def _address(change: Change) -> tuple[int, str, str]:
    """Return frame, word and path of a change, without the index among equal paths."""
    side = change.before or change.after or {}
    return change.frame, change.word, str(side.get("path", "")).partition("[")[0]


# --- formatting --------------------------------------------------------------------------------------------------


def change_lines(comparison: Changes, limit: int, names: Mapping[str, str] = _AS_IT_IS) -> Iterator[str]:
    """Format a comparison, with at most ``limit`` changes grouped by word.

    Parameters
    ----------
    names
        Displayed verb of each kind of change, such as ``OF_AN_EDIT``.
    """
    frames, changes, counts = comparison.frames, comparison.changes, comparison.counts
    of_frames = f" in {frames[0]} frames" if frames[0] == frames[1] > 1 else ""
    if comparison.equal:
        yield f"equal: {comparison.matched:,} primitives{of_frames}"
        return
    parts = [f"{comparison.matched:,} matched", *(f"{counts[kind]:,} {names[kind]}" for kind in _KINDS if counts[kind])]
    yield f"different: {', '.join(parts)}{of_frames}"
    if frames[0] != frames[1]:
        yield f"A has {frames[0]:,} frame{_s(frames[0])}, B has {frames[1]:,}; the first {min(frames):,} were compared"
    ordered = sorted(changes, key=lambda change: (change.word, change.frame))
    word = None
    for change in ordered[:limit]:
        if change.word != word:
            word = change.word
            yield _clean(word)
        label = f"frame {change.frame}: " if max(frames) > 1 else ""
        yield f"  {label}{_change_line(change, names[change.kind])}"
    if len(changes) > limit:
        yield f"... and {len(changes) - limit:,} more"


def _s(count: int) -> str:
    """Return the plural ending for a count."""
    return "" if count == 1 else "s"


def _change_line(change: Change, kind: str) -> str:
    """Format a change as one line, such as ``moved tower/step[3]: [0 1 0] -> [0 2 0]``."""
    side = change.before or change.after or {}
    start = f"{kind} {_clean(side['path'])}"
    if change.before is None or change.after is None:
        return f"{start} at {_point(side['at'])}"
    if change.kind == "recolored":
        return f"{start} at {_point(side['at'])}: {_look(change.before)} -> {_look(change.after)}"
    if change.kind == _PAIRED:
        return f"{start} at {_point(change.after['at'])}"
    before, after = change.before["at"], change.after["at"]
    if _point(before) == _point(after):
        return f"{start} at {_point(before)}: rotated"
    return f"{start}: {_point(before)} -> {_point(after)}"


def _look(side: dict[str, Any]) -> str:
    """Format the block or the color of a side, with what else its material has."""
    if "block" in side:
        return _clean(side["block"])
    return " ".join([_point(side["color"]), *([_clean(side["material"])] if "material" in side else [])])


def _point(numbers: Sequence[float]) -> str:
    """Format numbers as a vector of the language."""
    return "[" + " ".join(f"{x + 0.0:.6g}" for x in map(_unsigned_zero, numbers)) + "]"


def _unsigned_zero(x: float) -> float:
    """Round what is nearly zero to zero, so that noise is not printed."""
    return 0.0 if math.isclose(x, 0.0, abs_tol=1e-12) else x


def _clean(text: str) -> str:
    """Replace unprintable characters, so that text from files cannot control the terminal."""
    return "".join(c if c.isprintable() else "\N{REPLACEMENT CHARACTER}" for c in text)


# Reader of flattened scenes in JSON: golden files of the corpus, and the output of ``flatten --json``.
#
# Both have the form ``{"frames": [{"primitives": [...]}, ...]}``. A primitive of a golden file has its attributes
# beside ``shape`` and ``matrix`` (4x4); one of ``flatten`` has ``word``, ``attributes`` and ``matrix``. The optional
# ``path`` lists the words from the root to the parent. Files are untrusted input: every defect is reported as a
# SceneError.


def read_compared_frames(path: str, limit: int) -> list[ComparedFrame]:
    """Read the frames of a file, with at most ``limit`` primitives in total; raises SceneError if it is malformed."""
    try:
        data = json.loads(_text(path), parse_constant=_refuse_constant)
        return _compared_frames(data, path, limit)
    except RecursionError:
        raise SceneError("file", f"{path} is nested too deeply for a flattened scene") from None
    except MemoryError:
        raise LimitError("memory", f"{path} does not fit into memory") from None
    except ValueError as error:  # includes malformed JSON
        raise SceneError("file", f"{path} is not a flattened scene: {error}", _HINT) from None


def _text(path: str) -> str:
    """Read a file as text; raises SceneError."""
    try:
        data = read_regular(path, _MAX_FILE_SIZE + 1)
    except (OSError, ValueError) as error:
        raise unreadable(path, path, getattr(error, "strerror", None) or "invalid path") from None
    if len(data) > _MAX_FILE_SIZE:
        raise SceneError("file", f"{path} exceeds the maximum size of {_MAX_FILE_SIZE:,} bytes")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise SceneError("encoding", f"{path} is not UTF-8 text") from None


def _refuse_constant(name: str) -> NoReturn:
    """Reject ``NaN`` and ``Infinity``, which Python's JSON reader accepts."""
    raise ValueError(f"invalid number {name}")


def _member(data: Any, name: str, where: str) -> list[Any]:
    """Return a member of JSON data that must be a list; raises ValueError."""
    value = data.get(name) if isinstance(data, dict) else None
    if not isinstance(value, list):
        raise ValueError(f'{where} has no list "{name}"')
    return value


def _compared_frames(data: Any, path: str, limit: int) -> list[ComparedFrame]:
    """Convert the JSON data of a file; raises ValueError if it is malformed, LimitError if it is too large."""
    frames = _member(data, "frames", "the file")
    lists = [_member(frame, "primitives", f"frames[{i}]") for i, frame in enumerate(frames)]
    total = sum(map(len, lists))
    if total > limit:
        message = f"{path} contains {total:,} primitives, which exceeds the limit of {limit:,}"
        raise LimitError("primitives", message, hint="raise it with --max-primitives")
    return [_compared_frame(primitives, i) for i, primitives in enumerate(lists)]


def _compared_frame(primitives: Sequence[Any], frame: int) -> ComparedFrame:
    """Convert the primitives of a frame; equal ones share a solid and a path."""
    solids: dict[ComparedSolid, int] = {}
    paths: dict[tuple[str, ...], int] = {}
    count = len(primitives)
    index, path_index = np.zeros(count, np.int64), np.zeros(count, np.int64)
    matrices = np.zeros((count, 3, 4))
    for i, primitive in enumerate(primitives):
        try:
            solid = _solid(primitive)
            index[i] = solids.setdefault(solid, len(solids))
            matrices[i] = _matrix(primitive.get("matrix"))
            path_index[i] = paths.setdefault(_path(primitive.get("path")), len(paths))
        except (ValueError, OverflowError) as error:
            raise ValueError(f"frames[{frame}].primitives[{i}] {error}") from None
    return ComparedFrame(tuple(solids), index, matrices, tuple(paths), path_index)


def _solid(primitive: Any) -> ComparedSolid:
    """Convert one primitive, of a golden file or of ``flatten``."""
    if not isinstance(primitive, dict):
        raise ValueError("is not a JSON object")
    attributes = primitive.get("attributes")
    if not attributes:  # golden files have the attributes beside the shape
        attributes = primitive
    if not isinstance(attributes, dict):
        raise ValueError("has `attributes` that are not a JSON object")
    word = primitive.get("shape") or primitive.get("word")
    if not isinstance(word, str):
        raise ValueError('has neither "shape" nor "word"')
    return solid_of(word, attributes, use_block_scale="block_type" not in primitive)


def _matrix(value: Any) -> list[list[float]]:
    """Return the upper three rows of a 4x4 matrix, given as rows or as 16 numbers; raises ValueError."""
    rows = value if isinstance(value, list) else []
    if len(rows) == 16:
        rows = [rows[i : i + 4] for i in range(0, 16, 4)]
    if len(rows) != 4 or not all(isinstance(row, list) and len(row) == 4 for row in rows):
        raise ValueError("has no 4x4 matrix")
    for row in rows:
        for number in row:
            if type(number) not in (int, float) or not math.isfinite(number):
                raise ValueError("has a matrix with invalid numbers")
    if rows[3] != [0, 0, 0, 1]:
        raise ValueError("has a matrix whose last row is not [0 0 0 1]")
    return rows[:3]


def _path(value: Any) -> tuple[str, ...]:
    """Return the words of a path, empty for None; raises ValueError."""
    if value is None:
        return ()
    if not isinstance(value, list) or len(value) > _MAX_PATH_LENGTH or not all(isinstance(word, str) for word in value):
        raise ValueError("has a path that is not a list of strings")
    return tuple(value)
