"""What differs between two scenes, change by change: as data, and as people read it."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from scenelang.interpreter.difference import FrameDifference, Sheet
    from scenelang.interpreter.entity import Scene

TOLERANCE = 1e-5  # of the scene's size
_KINDS = ("moved", "recoloured", "resized", "missing", "extra")
_PAIRED = "resized"  # the kind that only ``paired_by_path`` makes
_AS_IT_IS: Mapping[str, str] = MappingProxyType({kind: kind for kind in _KINDS})
OF_AN_EDIT: Mapping[str, str] = MappingProxyType({**_AS_IT_IS, "missing": "removed", "extra": "added"})


@dataclass(frozen=True, slots=True)
class Change:
    """One difference. ``before`` and ``after`` say what there is on each side: place, colour or block, path."""

    kind: str
    frame: int
    word: str
    before: dict[str, Any] | None
    after: dict[str, Any] | None

    def data(self) -> dict[str, Any]:
        facts = {"change": self.kind, "frame": self.frame, "word": self.word}
        return facts | {name: side for name, side in (("a", self.before), ("b", self.after)) if side is not None}


@dataclass(frozen=True, slots=True)
class Changes:
    """All differences between the scenes A and B: ``frames`` of each, primitives that ``matched``, changes in the
    order of frames. Only frames that both have are compared."""

    frames: tuple[int, int]
    matched: int
    changes: tuple[Change, ...]

    @property
    def equal(self) -> bool:
        return not self.changes and self.frames[0] == self.frames[1]

    @property
    def counts(self) -> Counter[str]:
        """How many changes there are of each kind."""
        return Counter(change.kind for change in self.changes)

    def data(self, limit: int | None = None) -> dict[str, Any]:
        """The comparison as plain data, with at most ``limit`` changes, all where None."""
        counts = self.counts
        return {
            "equal": self.equal,
            "frames": {"a": self.frames[0], "b": self.frames[1]},
            "matched": self.matched,
            **{kind: counts[kind] for kind in _KINDS if counts[kind] or kind != _PAIRED},
            "changes": [change.data() for change in self.changes[:limit]],
        }


# --- what changed ------------------------------------------------------------------------------------------------


def sheets_of(scene: Scene, limit: int) -> list[Sheet]:
    """The frames of a scene, to be compared; raises LimitError for more than ``limit`` primitives."""
    from scenelang.interpreter.difference import sheet_of
    from scenelang.interpreter.flatten import flatten

    return [sheet_of(frame) for frame in flatten(scene, limit).frames]


def sheets_in(path: str, limit: int) -> list[Sheet] | None:
    """The frames of a flattened scene in a JSON file, None for a file of another kind; raises SceneError."""
    from scenelang.backends.exports.scene_json import holds_scene
    from scenelang.goldens import read_sheets

    return read_sheets(path, limit) if path.lower().endswith(".json") and not holds_scene(path) else None


def changes_between(frames_a: Sequence[Sheet], frames_b: Sequence[Sheet], tolerance: float = TOLERANCE) -> Changes:
    """What differs; up to ``tolerance`` of the scene's size nothing does. Raises SceneError for a scene whose
    coordinates are too large to compare."""
    from scenelang.interpreter.difference import compare_frames

    changes: list[Change] = []
    matched = 0
    for number, (a, b) in enumerate(zip(frames_a, frames_b)):
        found = compare_frames(a, b, tolerance)
        matched += found.matched
        changes += _changes(number, a, b, found)
    return Changes((len(frames_a), len(frames_b)), matched, tuple(changes))


def _changes(frame: int, a: Sheet, b: Sheet, found: FrameDifference) -> Iterator[Change]:
    rows_a = [*found.moved[:, 0].tolist(), *found.recolored[:, 0].tolist(), *found.missing.tolist()]
    rows_b = [*found.moved[:, 1].tolist(), *found.recolored[:, 1].tolist(), *found.extra.tolist()]
    before = [_side(a, row, label, found.places_a[row]) for row, label in zip(rows_a, a.labels(rows_a))]
    after = [_side(b, row, label, found.places_b[row]) for row, label in zip(rows_b, b.labels(rows_b))]
    moved, paired = len(found.moved), len(found.moved) + len(found.recolored)
    for i in range(paired):
        kind = "moved" if i < moved else "recoloured"
        yield Change(kind, frame, a.solid(rows_a[i]).word, before[i], after[i])
    for i in range(paired, len(rows_a)):
        yield Change("missing", frame, a.solid(rows_a[i]).word, before[i], None)
    for i in range(paired, len(rows_b)):
        yield Change("extra", frame, b.solid(rows_b[i]).word, None, after[i])


def _side(sheet: Sheet, row: int, label: str, place: Any) -> dict[str, Any]:
    solid = sheet.solid(row)
    look: dict[str, Any] = {"block": solid.look} if solid.is_block else {"color": list(solid.color)}
    return {"path": label, "at": place.tolist(), **look}


def paired_by_path(found: Changes) -> Changes:
    """The changes with a pair in place of what is missing and what is extra at one path, in order: a thing that has
    another size, or another place and look as well."""
    left: dict[tuple[int, str, str], list[Change]] = {}
    for change in found.changes:
        if change.kind == "extra":
            left.setdefault(_address(change), []).append(change)
    paired: list[Change] = []
    for change in found.changes:
        partners = left.get(_address(change), []) if change.kind == "missing" else []
        if partners:
            paired.append(Change(_PAIRED, change.frame, change.word, change.before, partners.pop(0).after))
        elif change.kind != "extra":
            paired.append(change)
    return Changes(found.frames, found.matched, (*paired, *(change for rest in left.values() for change in rest)))


def _address(change: Change) -> tuple[int, str, str]:
    """Frame, word and path, without the number among equal paths."""
    side = change.before or change.after or {}
    return change.frame, change.word, str(side.get("path", "")).partition("[")[0]


# --- saying it ---------------------------------------------------------------------------------------------------


def change_lines(found: Changes, limit: int, names: Mapping[str, str] = _AS_IT_IS) -> Iterator[str]:
    """The comparison as people read it, with at most ``limit`` changes, by word. ``names`` says what kinds of change
    are called."""
    frames, changes, counts = found.frames, found.changes, found.counts
    of_frames = f" in {frames[0]} frames" if frames[0] == frames[1] > 1 else ""
    if found.equal:
        yield f"equal: {found.matched:,} primitives{of_frames}"
        return
    told = [f"{found.matched:,} matched", *(f"{counts[kind]:,} {names[kind]}" for kind in _KINDS if counts[kind])]
    yield f"different: {', '.join(told)}{of_frames}"
    if frames[0] != frames[1]:
        yield f"A has {frames[0]:,} frame{_s(frames[0])}, B has {frames[1]:,}; the first {min(frames):,} were compared"
    ordered = sorted(changes, key=lambda change: (change.word, change.frame))
    word = None
    for change in ordered[:limit]:
        if change.word != word:
            word = change.word
            yield _clean(word)
        label = f"frame {change.frame}: " if max(frames) > 1 else ""
        yield f"  {label}{_told(change, names[change.kind])}"
    if len(changes) > limit:
        yield f"... and {len(changes) - limit:,} more"


def _s(count: int) -> str:
    return "" if count == 1 else "s"


def _told(change: Change, kind: str) -> str:
    """A change in one line, such as ``moved tower/step[3]: [0 1 0] -> [0 2 0]``."""
    side = change.before or change.after or {}
    start = f"{kind} {_clean(side['path'])}"
    if change.before is None or change.after is None:
        return f"{start} at {_point(side['at'])}"
    if change.kind == "recoloured":
        return f"{start} at {_point(side['at'])}: {_look(change.before)} -> {_look(change.after)}"
    if change.kind == _PAIRED:
        return f"{start} at {_point(change.after['at'])}"
    before, after = change.before["at"], change.after["at"]
    if _point(before) == _point(after):
        return f"{start} at {_point(before)}: turned"
    return f"{start}: {_point(before)} -> {_point(after)}"


def _look(side: dict[str, Any]) -> str:
    return _clean(side["block"]) if "block" in side else _point(side["color"])


def _point(numbers: Sequence[float]) -> str:
    return "[" + " ".join(f"{x + 0.0:.6g}" for x in map(_unsigned_zero, numbers)) + "]"


def _unsigned_zero(x: float) -> float:
    return 0.0 if math.isclose(x, 0.0, abs_tol=1e-12) else x


def _clean(text: str) -> str:
    """Text of a file as a terminal may see it."""
    return "".join(c if c.isprintable() else "\N{REPLACEMENT CHARACTER}" for c in text)
