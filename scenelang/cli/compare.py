"""The command diff: what differs between the geometry of two scenes."""

from __future__ import annotations

import argparse
import math
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from scenelang.cli.options import UsageError, add_common, limits_of, session_of, whole
from scenelang.cli.output import print_json, report_run

if TYPE_CHECKING:
    from scenelang.interpreter.difference import FrameDifference, Sheet

_KINDS = ("moved", "recoloured", "missing", "extra")


def tolerance(text: str) -> float:
    """A part of the scene's size, more than 0 and less than 1."""
    try:
        value = float(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"`{text}` is no number") from None
    if not 0 < value < 1:
        raise argparse.ArgumentTypeError(f"`{text}` is not between 0 and 1")
    return value


def add_diff(subparsers: Any) -> None:
    parser = subparsers.add_parser("diff", help="what differs between the geometry of two scenes")
    parser.add_argument("a", metavar="A", help="a program, or a flattened scene (.json)")
    parser.add_argument("b", metavar="B", help="a program, or a flattened scene (.json)")
    parser.add_argument(
        "--tolerance", type=tolerance, default=1e-5, metavar="T",
        help="differences up to this part of the scene's size do not count (default 1e-5)",
    )  # fmt: skip
    parser.add_argument("--limit", type=whole, default=20, metavar="N", help="changes to print (default 20)")
    add_common(parser)
    parser.set_defaults(run=diff)


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


def diff(arguments: argparse.Namespace) -> int:
    from scenelang.interpreter.difference import compare_frames

    if arguments.a == arguments.b == "-":
        raise UsageError("file", "only one of the two can be standard input")
    sides: list[Sequence[Sheet]] = []
    for path in (arguments.a, arguments.b):
        sheets = _sheets(arguments, path)
        if sheets is None:
            return 1
        sides.append(sheets)
    frames_a, frames_b = sides
    changes: list[Change] = []
    matched = 0
    for number, (a, b) in enumerate(zip(frames_a, frames_b)):
        found = compare_frames(a, b, arguments.tolerance)
        matched += found.matched
        changes += _changes(number, a, b, found)
    _print(arguments, (len(frames_a), len(frames_b)), matched, changes)
    return 1 if changes or len(frames_a) != len(frames_b) else 0


def _sheets(arguments: argparse.Namespace, path: str) -> Sequence[Sheet] | None:
    """The frames of a program or a JSON file; None when the program is wrong, which is then said."""
    from scenelang.backends.exports.scene_json import holds_scene
    from scenelang.goldens import read_sheets
    from scenelang.interpreter.difference import sheet_of
    from scenelang.interpreter.flatten import flatten

    limit = limits_of(arguments).primitives
    if path.lower().endswith(".json") and not holds_scene(path):
        return read_sheets(path, limit)
    arguments.file = path  # what the shared options look at: embeddings lie beside it
    session = session_of(arguments)
    result = session.evaluate(session.source(path))
    report_run(arguments, result)
    if result.scene is None:
        return None
    return [sheet_of(frame) for frame in flatten(result.scene, limit).frames]


# --- what changed ------------------------------------------------------------------------------------------------


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


# --- saying it ---------------------------------------------------------------------------------------------------


def _print(arguments: argparse.Namespace, frames: tuple[int, int], matched: int, changes: list[Change]) -> None:
    counts = Counter(change.kind for change in changes)
    if arguments.json:
        numbers: dict[str, Any] = {kind: counts[kind] for kind in _KINDS}
        facts = {
            "equal": not changes and frames[0] == frames[1],
            "frames": {"a": frames[0], "b": frames[1]},
            "matched": matched,
        }
        print_json(facts | numbers | {"changes": [change.data() for change in changes]})
        return
    for line in _lines(frames, matched, counts, changes, arguments.limit):
        print(line)


def _lines(
    frames: tuple[int, int], matched: int, counts: Counter[str], changes: list[Change], limit: int
) -> Iterator[str]:
    of_frames = f" in {frames[0]} frames" if frames[0] == frames[1] > 1 else ""
    if not changes and frames[0] == frames[1]:
        yield f"equal: {matched:,} primitives{of_frames}"
        return
    told = [f"{matched:,} matched", *(f"{counts[kind]:,} {kind}" for kind in _KINDS if counts[kind])]
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
        yield f"  {label}{_told(change)}"
    if len(changes) > limit:
        yield f"... and {len(changes) - limit:,} more"


def _s(count: int) -> str:
    return "" if count == 1 else "s"


def _told(change: Change) -> str:
    """A change in one line, such as ``moved tower/step[3]: [0 1 0] -> [0 2 0]``."""
    side = change.before or change.after or {}
    start = f"{change.kind} {_clean(side['path'])}"
    if change.before is None or change.after is None:
        return f"{start} at {_point(side['at'])}"
    if change.kind == "recoloured":
        return f"{start} at {_point(side['at'])}: {_look(change.before)} -> {_look(change.after)}"
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


COMMANDS = (add_diff,)
