"""A model of mistakes: plants them in programs that pass, and repairs them by what ``check --json`` says, nothing else.

Mistakes are drawn without a look at the checker: all that counts is that the scene is another one. A mistake counts as
detected if the checker says something new of it, and as repaired if the program makes the scene again that it made
before. No language model and no network are needed, and a seed gives the same mistakes on every machine.
"""

from __future__ import annotations

import hashlib
import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from difflib import SequenceMatcher
from functools import cache
from random import Random
from typing import TYPE_CHECKING, Any

import numpy as np

from scenelang.bench.mistake_kinds import KINDS, MistakeKind, Text, TextChange
from scenelang.grammar.datum import Source, TextEdit, with_edits
from scenelang.grammar.diagnostics import SceneError, capped, to_json
from scenelang.grammar.reader import lexemes
from scenelang.interpreter.scene.entity import Scene, count_words, primitive_count
from scenelang.interpreter.scene.flatten import FlatFrame, flatten_entity
from scenelang.interpreter.values.limits import Limits
from scenelang.session.checking import Examination
from scenelang.session.session import Options, Session, linted

if TYPE_CHECKING:
    import numpy.typing as npt

MAX_MISTAKES = 3
TURNS = 3  # of a repair, for mistakes that others hide
_LIMITS = Limits(steps=3_000_000, depth=5_000, seconds=20.0)
_MAX_TRIED = 12  # places of a program that a mistake of a kind is tried at
_MAX_PRIMITIVES = 3_000
_FRAMES = 4  # of a film, that are compared
_POSE = 1e-6  # of the scene's size
_SHADE = 0.006  # of a color: less than a byte shows
_MOVED = 0.03  # of the scene's size: how far a part may end from where it was
_NAME = "program.scene"


@dataclass(frozen=True, slots=True)
class PlantedMistake:
    """A mistake: its kind, the range of the sound program that it replaces, and the text before and after."""

    kind: str
    start: int
    end: int
    old: str
    new: str


@dataclass(frozen=True, slots=True)
class Mutated:
    """A program with mistakes, and the sound program, which may state a declaration besides what was given."""

    text: str
    mistakes: tuple[PlantedMistake, ...]
    sound: str


@dataclass(frozen=True, slots=True)
class MutationRow:
    """Mistakes of one kind: how many were planted, detected, repaired in one turn, and in at most three."""

    kind: str
    family: str
    tuned: bool
    planted: int
    detected: int
    one_turn: int
    all_turns: int

    @property
    def share(self) -> float:
        return self.one_turn / self.planted if self.planted else 0.0

    def data(self) -> dict[str, Any]:
        """Return the row as JSON data."""
        return {
            "kind": self.kind, "family": self.family, "split": "tuned" if self.tuned else "untouched",
            "planted": self.planted, "detected": self.detected, "repaired_in_one_turn": self.one_turn,
            "repaired": self.all_turns, "share": round(self.share, 4),
        }  # fmt: skip


@dataclass(frozen=True, slots=True)
class MutationReport:
    """What was repaired of the planted mistakes, by kind; ``programs`` and ``whole`` count programs, and those that
    make the same scene after one turn."""

    rows: tuple[MutationRow, ...]
    programs: int
    whole: int
    missed: tuple[tuple[str, str, str], ...] = ()

    def share(self, tuned: bool) -> float:
        """Return the share of the mistakes of one half of the kinds that is repaired in one turn."""
        rows = [row for row in self.rows if row.tuned is tuned]
        return sum(row.one_turn for row in rows) / max(sum(row.planted for row in rows), 1)

    def data(self) -> dict[str, Any]:
        """Return the report as JSON data."""
        halves = {"tuned": round(self.share(True), 4), "untouched": round(self.share(False), 4)}
        rows = [row.data() for row in self.rows]
        return {"rows": rows, "share": halves, "programs": self.programs, "repaired_programs": self.whole}

    def markdown(self) -> str:
        """Return the report as a table in Markdown."""
        lines = [
            "| kind | split | planted | detected | repaired | in three turns | share |",
            "|---|---|---|---|---|---|---|",
        ]
        for row in sorted(self.rows, key=lambda row: not row.tuned):
            split = "tuned" if row.tuned else "untouched"
            lines.append(
                f"| {row.kind} | {split} | {row.planted} | {row.detected} | {row.one_turn} | {row.all_turns}"
                f" | {row.share:.0%} |"
            )
        for tuned, split in ((True, "tuned"), (False, "untouched")):
            rows = [row for row in self.rows if row.tuned is tuned]
            planted, detected, one, every = (
                sum(getattr(row, name) for row in rows) for name in ("planted", "detected", "one_turn", "all_turns")
            )
            counts = f"{planted} | {detected} | {one} | {every}"
            lines.append(f"| **all** | {split} | {counts} | {self.share(tuned):.1%} |")
        return "\n".join(lines)


# --- scenes ----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class _Layout:
    """What is compared of a scene: for each compared frame its words, world matrices (N, 3, 4) and attributes."""

    frames: tuple[tuple[tuple[str, ...], npt.NDArray[np.float64], tuple[Mapping[str, Any], ...]], ...]
    count: int
    size: float


@dataclass(frozen=True, eq=False)
class _Outcome:
    """What a program makes; ``layout`` is None after an error, ``findings`` are names of findings about the scene."""

    layout: _Layout | None
    findings: Counter[str]


@cache
def _session() -> Session:
    return Session(Options(limits=_LIMITS))


@cache
def _language() -> tuple[frozenset[str], frozenset[str]]:
    """The names of builtins and forms, and of builtins with any number of arguments."""
    from scenelang.interpreter.expand.forms import INDENTS

    library = _session().library
    variadic = (name for name, builtin in library.builtins.items() if builtin.signature.rest is not None)
    return library.names | set(INDENTS), frozenset(variadic)


def _layout(scene: Scene) -> _Layout | None:
    roots = [
        scene.frames[i] for i in sorted({round(i * (len(scene.frames) - 1) / (_FRAMES - 1)) for i in range(_FRAMES)})
    ]
    if sum(map(primitive_count, roots)) > _MAX_PRIMITIVES * _FRAMES:
        return None
    frames = [flatten_entity(root) for root in roots]
    places = np.concatenate([frame.matrices[:, :, 3] for frame in frames])
    size = float(np.ptp(places, axis=0).max()) if len(places) else 0.0
    return _Layout(tuple(map(_frame, frames)), len(scene.frames), max(size, 1.0))


def _frame(frame: FlatFrame) -> tuple[tuple[str, ...], npt.NDArray[np.float64], tuple[Mapping[str, Any], ...]]:
    primitives = [frame.primitives[i] for i in frame.index]
    return tuple(p.word for p in primitives), frame.matrices, tuple(p.embedding.attributes for p in primitives)


def _is_same(a: _Layout | None, b: _Layout | None, distance: float = _POSE) -> bool:
    """Return whether two scenes are equal, but for how far things may have moved, in terms of the scene's size."""
    if a is None or b is None or a.count != b.count:
        return False
    for (words, matrices, attributes), (others, poses, values) in zip(a.frames, b.frames, strict=True):
        if words != others or not np.allclose(matrices, poses, rtol=0.0, atol=distance * a.size):
            return False
        seen = {(id(x), id(y)): (x, y) for x, y in zip(attributes, values, strict=True)}
        if not all(_are_equal(x, y) for x, y in seen.values()):
            return False
    return True


def _are_equal(a: Mapping[str, Any], b: Mapping[str, Any]) -> bool:
    return a.keys() == b.keys() and all(_is_equal_value(a[name], b[name]) for name in a)


def _is_equal_value(a: Any, b: Any) -> bool:
    try:
        x, y = np.asarray(a, dtype=float), np.asarray(b, dtype=float)
    except (TypeError, ValueError):
        return bool(a == b) or repr(a) == repr(b)
    return x.shape == y.shape and np.allclose(x, y, rtol=0.0, atol=_SHADE)


@cache
def _outcome(text: str, *, geometry: bool) -> _Outcome:
    result = _session().evaluate(Source(_NAME, text))
    if result.scene is None:
        return _Outcome(None, Counter())
    diagnostics = linted(result, *_lints(geometry=geometry))
    if any(d.is_error for d in diagnostics):
        return _Outcome(None, Counter())
    try:
        return _Outcome(_layout(result.scene), Counter(d.name for d in diagnostics))
    except SceneError:
        return _Outcome(None, Counter())


def _lints(*, geometry: bool) -> Iterator[Any]:
    from scenelang.backends.geometry.lint import check_geometry
    from scenelang.backends.geometry.relations import check_declarations

    yield check_declarations
    if geometry:
        yield check_geometry


# --- planting --------------------------------------------------------------------------------------------------------


def mutated(program: str, seed: int, count: int = 1, kinds: Sequence[str] | None = None) -> Mutated | None:
    """Plant mistakes in a program that makes a scene.

    Parameters
    ----------
    program
        The text of a program.
    seed
        The same seed plants the same mistakes.
    count
        How many mistakes, at different places; fewer are planted where the program has no place for more.
    kinds
        The kind of the first mistake, and of the others if there are as many; by default kinds are drawn at random.

    Returns
    -------
    Mutated or None
        None if the program has no place for a mistake of the first kind, or makes no scene.
    """
    sound = _outcome(program, geometry=False).layout
    if sound is None:
        return None
    pick = Random(f"{seed}:{hashlib.sha256(program.encode()).hexdigest()}")
    order = list(kinds) if kinds is not None else pick.sample(list(KINDS), len(KINDS))
    text = _text(program)
    changes: list[tuple[str, TextChange]] = []
    for kind in order:
        if len(changes) == count:
            break
        change = _planted(text, KINDS[kind], pick, [each for _, each in changes])
        if change is not None:
            changes.append((kind, change))
        elif kinds is not None and not changes:
            return None
    return _applied(program, changes) if changes else None


def _text(program: str) -> Text:
    result = _session().evaluate(Source(_NAME, program))
    assert result.scene is not None
    counts = count_words(result.scene.frames[0]) if not result.scene.animated else {}
    return Text(program, *_language(), counts)


def _planted(text: Text, kind: MistakeKind, pick: Random, others: Sequence[TextChange]) -> TextChange | None:
    """Return a change that makes a mistake of a kind, apart from the others, or None."""
    candidates = list(kind.plant(text, pick))
    pick.shuffle(candidates)
    free = [each for each in candidates if all(_are_apart(each, other) for other in others)]
    return next((each for each in free[:_MAX_TRIED] if _makes_mistake(text.text, kind, each)), None)


def _are_apart(a: TextChange, b: TextChange) -> bool:
    return (a.end + 1 < b.start or b.end + 1 < a.start) and not (a.declaration and b.declaration)


def _makes_mistake(program: str, kind: MistakeKind, change: TextChange) -> bool:
    """Return whether a change makes another scene, or none. What the checker says does not count.

    A part that was moved must be farther away than one that counts as repaired.
    """
    made = _applied(program, [(kind.name, change)])
    before, after = _outcome(made.sound, geometry=False), _outcome(made.text, geometry=False)
    if before.layout is None:
        return False
    return not _is_same(before.layout, after.layout, _MOVED if kind.evidence == "geometry" else _POSE)


def _applied(program: str, changes: Sequence[tuple[str, TextChange]]) -> Mutated:
    text = with_edits(program, (TextEdit(change.start, change.end, change.text) for _, change in changes))
    declarations = "".join(f"\n{change.declaration}\n" for _, change in changes if change.declaration)
    mistakes = tuple(
        PlantedMistake(kind, change.start, change.end, program[change.start : change.end], change.text)
        for kind, change in changes
    )
    return Mutated(text + declarations, mistakes, program + declarations)


# --- repair ----------------------------------------------------------------------------------------------------------


def check_documents(text: str) -> list[dict[str, Any]]:
    """Return what ``scenelang check --run --geometry --json`` prints about a program."""
    return [to_json(d) for d in capped(_asked().of(Source(_NAME, text)).diagnostics)]


@cache
def _asked() -> Examination:
    return Examination(_session(), run=True, geometry=True, complete=True)


def repaired_by_check(text: str, turns: int = 1) -> str:
    """Return a program after repairs by nothing but the fixes and names in the findings of ``check --json``.

    In each turn the first fix of every finding is applied, or its first name put in place of the text that it is about,
    from the errors on; edits that overlap an earlier one wait for the next turn. In a
    program with errors, what is unused stays.
    """
    for _ in range(turns):
        edits = _edits(text, check_documents(text))
        if not edits:
            break
        text = with_edits(text, edits)
    return text


_CONSEQUENCES = ("unused", "unreachable-word", "unreachable-code", "constant-condition")  # often of an error


def _edits(text: str, documents: Sequence[Mapping[str, Any]]) -> list[TextEdit]:
    source = Source(_NAME, text)
    has_errors = any(document["severity"] == "error" for document in documents)
    chosen: list[TextEdit] = []
    for document in sorted(documents, key=lambda document: document["severity"] != "error"):
        edits = _edits_of(source, document)
        waits = has_errors and document["name"] in _CONSEQUENCES
        if edits and not waits and not any(edit.overlaps(other) for edit in edits for other in chosen):
            chosen += edits
    return chosen


def _edits_of(source: Source, document: Mapping[str, Any]) -> list[TextEdit]:
    """Return the edits of the first fix, or of the first name that may have been meant."""
    for fix in document["fixes"]:
        places = [_range(source, edit["place"]) for edit in fix["edits"]]
        edits = [
            TextEdit(*place, e["text"]) for place, e in zip(places, fix["edits"], strict=True) if place is not None
        ]
        if len(edits) == len(places):
            return edits
    place = _range(source, document["place"])
    names = document["near"] or re.findall(r"did you mean `([^`]+)`", document["hint"] or "")
    if place is None or not names or "\n" in source.text[slice(*place)]:
        return []
    return [TextEdit(*place, names[0])]


def _range(source: Source, place: Mapping[str, Any] | None) -> tuple[int, int] | None:
    if place is None or place["file"] != source.name:
        return None
    start = source.line_start(place["line"]) + place["column"] - 1
    return start, source.line_start(place["end_line"]) + place["end_column"] - 1


def is_detected(made: Mutated, mistake: PlantedMistake) -> bool:
    """Return whether ``check --json`` warns of a mistake, alone in its program, or calls it an error."""
    edit = TextEdit(mistake.start, mistake.end, mistake.new)
    known = {document["message"] for document in check_documents(made.sound)}
    diagnostics = check_documents(with_edits(made.sound, [edit]))
    return any(d["severity"] in ("error", "warning") and d["message"] not in known for d in diagnostics)


# --- measuring -------------------------------------------------------------------------------------------------------


def is_repaired(made: Mutated, text: str) -> bool:
    """Return whether a text makes the scene of the sound program.

    Where a part was moved, it must make no finding that the sound program has not, with all parts near their places.
    """
    is_moved = any(KINDS[mistake.kind].evidence == "geometry" for mistake in made.mistakes)
    before, after = _outcome(made.sound, geometry=is_moved), _outcome(text, geometry=is_moved)
    if is_moved and sum(after.findings.values()) > sum(before.findings.values()):
        return False
    return _is_same(before.layout, after.layout, _MOVED if is_moved else _POSE)


def repaired_mistakes(made: Mutated, text: str) -> list[bool]:
    """Return which mistakes a text has no more.

    All, if it makes the sound program's scene; else those with which the sound program makes its scene when it is
    written as the text is around them.
    """
    if is_repaired(made, text):
        return [True] * len(made.mistakes)
    if len(made.mistakes) == 1:
        return [False]
    changes = _differences(made.sound, text)
    return [_is_repaired_alone(made, mistake, changes) for mistake in made.mistakes]


def _is_repaired_alone(made: Mutated, mistake: PlantedMistake, changes: Sequence[TextEdit]) -> bool:
    own = [each for each in changes if each.start <= mistake.end and mistake.start <= each.end]
    return not own or is_repaired(replace(made, mistakes=(mistake,)), with_edits(made.sound, own))


def _differences(a: str, b: str) -> list[TextEdit]:
    """Return the edits that make the tokens of the second text of those of the first."""
    tokens, others = _tokens(a), _tokens(b)
    matcher = SequenceMatcher(None, [t for _, _, t in tokens], [t for _, _, t in others], autojunk=False)
    edits = []
    for tag, first, last, low, high in matcher.get_opcodes():
        if tag != "equal":
            start = tokens[first][0] if first < len(tokens) else len(a)
            end = tokens[last - 1][1] if last > first else start
            new = b[others[low][0] : others[high - 1][1]] if high > low else ""
            edits.append(TextEdit(start, end, new if last > first else f" {new} "))
    return edits


def _tokens(text: str) -> list[tuple[int, int, str]]:
    tokens = lexemes(text, 0, len(text))
    return [(start, end, text[start:end]) for kind, start, end in tokens if kind not in ("space", "comment", "block")]


def measure(
    programs: Mapping[str, str], per_kind: int, seed: int, kinds: Sequence[str] | None = None
) -> MutationReport:
    """Plant mistakes in programs, repair them, and count.

    Parameters
    ----------
    programs
        Programs that make a scene, by name.
    per_kind
        How many programs get a mistake of each kind, with none, one or two others of the same half of the kinds.
    seed
        The same seed gives the same report.
    kinds
        The kinds to measure; by default all.
    """
    planted: Counter[str] = Counter()
    detected: Counter[str] = Counter()
    one: Counter[str] = Counter()
    every: Counter[str] = Counter()
    missed: list[tuple[str, str, str]] = []
    total = whole = 0
    for made in _plants(programs, per_kind, seed, kinds or tuple(KINDS)):
        first = repaired_by_check(made.text)
        fixed = repaired_mistakes(made, first)
        later = fixed if all(fixed) else repaired_mistakes(made, repaired_by_check(first, TURNS - 1))
        total, whole = total + 1, whole + all(fixed)
        for mistake, now, then in zip(made.mistakes, fixed, later, strict=True):
            planted[mistake.kind] += 1
            detected[mistake.kind] += is_detected(made, mistake)
            one[mistake.kind] += now
            every[mistake.kind] += now or then
            if not now:
                missed.append((mistake.kind, made.text, first))
    rows = tuple(
        MutationRow(
            kind.name,
            kind.family,
            kind.tuned,
            planted[kind.name],
            detected[kind.name],
            one[kind.name],
            every[kind.name],
        )
        for kind in KINDS.values()
        if planted[kind.name]
    )
    return MutationReport(rows, total, whole, tuple(missed))


def _plants(programs: Mapping[str, str], per_kind: int, seed: int, kinds: Sequence[str]) -> Iterator[Mutated]:
    """Yield programs with one to three mistakes: the first is of each kind in turn, the others of the same half."""
    for kind in kinds:
        pick = Random(f"{seed}:{kind}")
        half = [name for name in kinds if KINDS[name].tuned == KINDS[kind].tuned and name != kind]
        names, number = sorted(programs), 0
        for round_ in range(per_kind):
            for name in pick.sample(names, len(names)):
                count = 1 + number % MAX_MISTAKES
                others = pick.sample(half, min(len(half), 2 * count))
                made = mutated(programs[name], seed + round_, count, [kind, *others])
                if made is not None:
                    yield made
                    number += 1
                if number == per_kind:
                    break
            if number == per_kind:
                break
