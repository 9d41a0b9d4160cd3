"""Repair of programs without a language model: edits of literals that resolve findings and failed declarations.

A program is changed, not its scene: a literal moves everything that is made from it, so loops and symmetries are kept.
For each finding, the motion of all primitives with each numeric literal is measured by finite differences; the literals
of a vector are solved for the motion that resolves the finding (least squares), and the candidates are tested in the
order of how little they move. What no literal can do is done by placing a part with ``translate``, by leaving out a
pose, or by removing a part that is there twice. The search follows "Procedural Scene Programs for Open-Universe Scene
Generation: LLM-Free Error Correction via Program Search" (arXiv 2510.16147), with derivatives in place of sampled
proposals.
"""

from __future__ import annotations

import difflib
import math
import time
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from scenelang.grammar.datum import ArrayDatum, Atom, Datum, Keyword, ListDatum, Source, Span, Symbol, subdatums, walk
from scenelang.grammar.diagnostics import ABOUT_SCENES, Diagnostic, Edit, Fix, SceneError
from scenelang.grammar.reader import read
from scenelang.interpreter.runtime.values import IDENTITY
from scenelang.interpreter.scene.entity import primitive_count
from scenelang.interpreter.scene.flatten import flatten_entity

if TYPE_CHECKING:
    from scenelang.backends.base import Progress
    from scenelang.backends.geometry.arrangement import Vector
    from scenelang.backends.geometry.distance import IntArray
    from scenelang.backends.geometry.lint import CheckedFrame, Finding
    from scenelang.backends.geometry.solids import FloatArray
    from scenelang.editing import Editing
    from scenelang.interpreter.scene.declarations import Declaration
    from scenelang.interpreter.scene.entity import Entity, Scene
    from scenelang.session import Evaluated, Session

SECONDS = 30.0
MAX_EDITS = 20
_MAX_LITERALS = 400
_MAX_PARTS = 60
_MAX_TESTS = 10  # candidates that are tested for one finding
_STEP = 1e-4  # of a literal, to measure what it moves
_STILL = 1e-9  # of the scene's size: less is rounding
_OFF = 0.3  # of a motion: how far the motion of a candidate may be from it
_TIDY = 5e-3  # of the scene's size: what one more changed literal costs
_STRUCTURAL = 0.02  # of the scene's size: what a new form in the program costs
_CORRECTIONS = 4
_OVERLAPS = ("twin", "through", "deep", "buried", "fighting")
_NO_LITERALS = frozenset({"assert-that", "color", "import", "format", "embedding"})


@dataclass(frozen=True, slots=True, eq=False)
class Goal:
    """A finding or failed declaration to resolve.

    ``key`` is equal for equal findings of other versions. ``rows`` and ``others`` are the primitives of the two things
    in the layout; ``moves`` are translations of the first thing, each of which would do, ``turn`` an angle about the
    vertical axis. ``body`` is the part of the first thing that the finding is about, None for all of it.
    """

    key: tuple[str, ...]
    message: str
    amount: float
    rows: IntArray
    others: IntArray
    moves: tuple[Vector, ...]
    turn: float | None = None
    declaration: Declaration | None = None
    body: IntArray | None = None

    @property
    def subjects(self) -> tuple[Goal, ...]:
        """The goal for all of its thing, and for the part that it is about."""
        return (self,) if self.body is None else (self, replace(self, rows=self.body, body=None))


@dataclass(frozen=True, slots=True)
class ProgramEdit:
    """One change of the program: the line, the text before and after, and the finding that it resolves."""

    line: int
    old: str
    new: str
    resolves: str


@dataclass(frozen=True, slots=True, eq=False)
class Repair:
    """A repaired program.

    Attributes
    ----------
    text
        The program after all edits; unchanged if nothing was found, or nothing could be repaired.
    edits
        The changes, in order.
    before, left
        Messages of the findings before, and of those that remain.
    displacement
        Mean distance by which the primitives moved, in scene units; 0 if their number changed.
    """

    original: str
    text: str
    edits: tuple[ProgramEdit, ...]
    before: tuple[str, ...]
    left: tuple[str, ...]
    displacement: float

    @property
    def changed(self) -> bool:
        return self.text != self.original

    def diff(self, name: str = "program.scene") -> str:
        """Return a unified diff; empty if nothing changed."""
        old, new = (text.splitlines(keepends=True) for text in (self.original, self.text))
        return "".join(difflib.unified_diff(old, new, name, name))

    def data(self) -> dict[str, Any]:
        """Return the repair as JSON data."""
        edits = [{"line": e.line, "old": e.old, "new": e.new, "resolves": e.resolves} for e in self.edits]
        return {"edits": edits, "before": list(self.before), "left": list(self.left), "displacement": self.displacement}


def repaired(
    session: Session,
    source: Source,
    extra: Sequence[Declaration] = (),
    *,
    seconds: float = SECONDS,
    geometry: bool = True,
    progress: Progress | None = None,
) -> Repair:
    """Repair a program.

    Parameters
    ----------
    extra
        Declarations about the scene, besides those of the program.
    seconds
        Time after which no further edit is searched.
    geometry
        Whether to resolve the findings of the geometry lint too.
    progress
        Called with a fraction from 0 to 1; an exception raised by it ends the search.

    Raises
    ------
    SceneError
        If the program is wrong, or a declaration cannot be tested.
    """
    search = _Search(session, source.name, tuple(extra), geometry, time.monotonic() + seconds)
    start = search.version(source.text)
    if start is None:
        raise SceneError("value", "the program has no scene")
    now, edits = start, list[ProgramEdit]()
    hopeless: set[tuple[str, ...]] = set()
    while len(edits) < MAX_EDITS and search.has_time():
        goal = next((goal for goal in now.goals if goal.key not in hopeless), None)
        if goal is None:
            break
        if progress is not None:
            progress(1.0 - len(now.goals) / max(len(start.goals), 1))
        better = search.step(now, goal)
        if better is None:
            hopeless.add(goal.key)
        else:
            now = better
            edits += [replace(edit, resolves=goal.message) for edit in better.edits]
    moved = _displacement(start.corners, now.corners)
    return Repair(
        source.text, now.text, tuple(edits), _messages(start), _messages(now), 0.0 if moved is None else moved
    )


def with_repairs(
    session: Session, source: Source, found: Sequence[Diagnostic], extra: Sequence[Declaration] = (), *,
    geometry: bool = True,
) -> list[Diagnostic]:  # fmt: skip
    """Return findings about a scene with fixes: the edit of the program by which each would be gone.

    The first three are tried, with at most 300 evaluations, in ten seconds. Nothing is tried for a program with other
    errors.
    """
    about = [d for d in found if d.name in ABOUT_SCENES]
    if not about or any(d.is_error and d.name not in ABOUT_SCENES for d in found):
        return list(found)
    search = _Search(session, source.name, tuple(extra), geometry, time.monotonic() + _FIX_SECONDS)
    search.evaluations = _FIX_EVALUATIONS
    try:
        start = search.version(source.text)
    except SceneError:
        start = None
    fixes: dict[int, Fix] = {}
    left: list[Goal] = [] if start is None else list(start.goals)
    for _ in range(_MAX_FIXED):
        goal = next((each for each in left if search.has_time()), None)
        if goal is None or start is None:
            break
        better = search.step(start, goal)
        left = [each for each in left if each.key != goal.key and (better is None or each.key in better.counts)]
        finding = next((d for d in about if id(d) not in fixes and _is_about(d, goal)), None)
        if better is not None and finding is not None:
            fixes[id(finding)] = _fix_of(source, better.text)
    return [replace(d, fixes=(fixes[id(d)],)) if id(d) in fixes else d for d in found]


_FIX_SECONDS = 10.0
_FIX_EVALUATIONS = 300  # so that a machine's speed decides nothing
_MAX_FIXED = 3


def _is_about(diagnostic: Diagnostic, goal: Goal) -> bool:
    """Return whether a diagnostic reports a goal: of its declaration, or of its words."""
    if goal.declaration is not None:
        return diagnostic.name == "declaration" and str(goal.declaration) in diagnostic.message
    _, subject, *_ = goal.key
    words = "/".join(subject.split("/")[-3:])
    return diagnostic.name != "declaration" and f'"{words}"' in diagnostic.message


def _fix_of(source: Source, text: str) -> Fix:
    """Return the fix that makes one text of another, by the smallest edit."""
    old = source.text
    head = next((i for i, (a, b) in enumerate(zip(old, text)) if a != b), min(len(old), len(text)))
    tail = 0
    while tail < min(len(old), len(text)) - head and old[len(old) - 1 - tail] == text[len(text) - 1 - tail]:
        tail += 1
    for datum in walk(*read(source).forms):  # a number is replaced as a whole
        if isinstance(datum, Atom) and datum.span.start < head < datum.span.end:
            head = datum.span.start
        if isinstance(datum, Atom) and datum.span.start < len(old) - tail < datum.span.end:
            tail = len(old) - datum.span.end
    new = text[head : len(text) - tail]
    title = f"Change to `{new}`" if len(new) <= _MAX_TITLE and new else "Change the program"
    return Fix(title, (Edit(Span(source, head, len(old) - tail), new),))


_MAX_TITLE = 40


def _messages(version: _Version) -> tuple[str, ...]:
    return tuple(dict.fromkeys(goal.message for goal in version.goals))


def _displacement(before: FloatArray, after: FloatArray) -> float | None:
    """Return the mean distance of two layouts, None if they have different numbers of primitives."""
    if before.shape != after.shape:
        return None
    return float(np.linalg.norm(after - before, axis=1).mean()) if len(before) else 0.0


# --- versions of the program -----------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class _Version:
    """A version of the program: its scene, two corners (2N, 3) of the box of each primitive, and the edits that led to
    it."""

    text: str
    scene: Scene
    corners: FloatArray
    find: Callable[[Scene], list[Goal]]
    edits: tuple[ProgramEdit, ...] = ()

    @cached_property
    def goals(self) -> list[Goal]:
        return self.find(self.scene)

    @cached_property
    def counts(self) -> Counter[tuple[str, ...]]:
        return Counter(goal.key for goal in self.goals)

    @cached_property
    def size(self) -> float:
        """Diagonal of the box of all corners, or 1."""
        spread = np.ptp(self.corners, axis=0) if len(self.corners) else np.zeros(3)
        return float(np.linalg.norm(spread)) or 1.0


@dataclass(frozen=True, slots=True, eq=False)
class _Literal:
    """A number in the text, and the group of numbers that it is changed with: those of one vector."""

    span: Span
    value: float
    group: int


@dataclass(frozen=True, slots=True, eq=False)
class _Candidate:
    """Changed pieces of the text, what they are expected to cost, and the numbers of the literals that they change."""

    changes: tuple[tuple[Span, str], ...]
    cost: float
    literals: tuple[int, ...] = ()


@dataclass(eq=False)
class _Search:
    session: Session
    name: str
    extra: tuple[Declaration, ...]
    geometry: bool
    deadline: float
    motions: dict[str, list[FloatArray | None]] = field(default_factory=dict)
    evaluations: float = math.inf  # that are left

    @cached_property
    def editing(self) -> Editing:
        """Evaluates versions, of each only what differs from the one before."""
        from scenelang.editing import Editing

        return Editing(self.session)

    def has_time(self) -> bool:
        return self.evaluations > 0 and time.monotonic() < self.deadline

    def evaluated(self, text: str) -> Evaluated:
        self.evaluations -= 1
        return self.editing.evaluate(Source(self.name, text))

    def version(self, text: str, edits: tuple[ProgramEdit, ...] = ()) -> _Version | None:
        """Evaluate a version; None if it is wrong or has no geometry."""
        result = self.evaluated(text)
        if result.scene is None:
            if not edits:
                result.require()
            return None
        try:
            return _Version(text, result.scene, _layout(result.scene), self.goals, edits)
        except SceneError:
            if not edits:
                raise
            return None

    def layout(self, text: str) -> FloatArray | None:
        """Return the corners of a version, None if it is wrong or one of its solids cannot be computed."""
        scene = self.evaluated(text).scene
        try:
            return None if scene is None else _layout(scene)
        except SceneError:
            return None

    def goals(self, scene: Scene) -> list[Goal]:
        """Return all findings of a version, failed declarations first."""
        from scenelang.backends.geometry.relations import violations

        offsets = _offsets(scene)
        found = []
        for violation in violations(scene, self.extra):
            if violation.frame not in offsets:
                continue
            at = offsets[violation.frame]
            rows, others = _rows(_between(violation.rows), at), _rows(_between(violation.other_rows), at)
            moves = () if violation.move is None else _alternatives(violation.move, violation.declaration.relation)
            key = ("declaration", str(violation.declaration), violation.subject or "", str(violation.rows))
            message = f"{violation.declaration} does not hold: {violation.message}"
            turn, declaration = violation.turn, violation.declaration
            found.append(Goal(key, message, violation.amount, rows, others, moves, turn, declaration))
        found.sort(key=lambda goal: -goal.amount)
        return [*found, *(_lint_goals(scene, offsets) if self.geometry else ())]

    # --- one step ----------------------------------------------------------------------------------------------

    def step(self, now: _Version, goal: Goal) -> _Version | None:
        """Return a version in which a goal is resolved and nothing new is found; None if none is found."""
        for candidates in (self._by_literals, self._by_amount_or_turn, self._by_form):
            ordered = sorted(candidates(now, goal), key=lambda each: each.cost)
            for candidate in ordered[:_MAX_TESTS]:
                if not self.has_time():
                    return None
                found = self._tested(now, goal, candidate)
                if found is not None:
                    return found
        return None

    def _tested(self, now: _Version, goal: Goal, candidate: _Candidate) -> _Version | None:
        """Return the version that a candidate makes if it is better; it is corrected where the motion is not linear."""
        for _ in range(_CORRECTIONS):
            found = self._applied(now, candidate)
            try:
                if found is None or _is_better(now, found, goal):
                    return found
                left = next((each for each in found.goals if each.key == goal.key), None)
            except SceneError:
                return None
            if left is None or not candidate.literals or left.amount > 0.7 * goal.amount:
                return None
            candidate = self._corrected(now, found, left, candidate)
        return None

    def _corrected(self, now: _Version, found: _Version, left: Goal, candidate: _Candidate) -> _Candidate:
        """Return a candidate whose literals also resolve what it leaves of a goal."""
        literals, motions = literals_of(Source(self.name, found.text)), self._motions(now)
        every = [
            c for move in left.moves for c in self._solved(found, left, literals, motions, candidate.literals, move)
        ]
        if not every:
            return replace(candidate, literals=())
        best = min(every, key=lambda each: each.cost)
        return _Candidate(
            tuple((span, new) for (span, _), (_, new) in zip(candidate.changes, best.changes)), best.cost, best.literals
        )

    def _applied(self, now: _Version, candidate: _Candidate) -> _Version | None:
        text, edits = now.text, []
        for span, new in sorted(candidate.changes, key=lambda change: -change[0].start):
            if _is_same_number(span.text, new):
                continue
            line, _ = span.source.position(span.start)
            edits.append(ProgramEdit(line, span.text, new, ""))
            text = _replaced(text, span, new)
        return self.version(text, tuple(reversed(edits)))

    # --- literals ----------------------------------------------------------------------------------------------

    def _motions(self, now: _Version) -> list[FloatArray | None]:
        """Return how all corners move with each literal, (N, 3) per unit; None if it moves nothing, or makes another
        number of primitives."""
        if now.text not in self.motions:
            self.motions.clear()
            self.motions[now.text] = [self._motion(now, each) for each in literals_of(Source(self.name, now.text))]
        return self.motions[now.text]

    def _motion(self, now: _Version, literal: _Literal) -> FloatArray | None:
        if not self.has_time():
            return None
        step = _STEP * max(1.0, abs(literal.value))
        text = _replaced(now.text, literal.span, _number(literal.value + step, 12))
        corners = self.layout(text)
        if corners is None or corners.shape != now.corners.shape:
            return None
        motion: FloatArray = (corners - now.corners) / step
        return motion if np.abs(motion).max(initial=0.0) > _STILL * now.size / step else None

    def _by_literals(self, now: _Version, goal: Goal) -> Iterator[_Candidate]:
        """Yield changes of the literals of one vector that move the two things of a goal to or from each other."""
        if not goal.moves or not len(goal.rows):
            return
        literals, motions = literals_of(Source(self.name, now.text)), self._motions(now)
        groups: dict[int, list[int]] = {}
        for number, literal in enumerate(literals):
            if motions[number] is not None:
                groups.setdefault(literal.group, []).append(number)
        for numbers in groups.values():
            for chosen in [[number] for number in numbers] + ([numbers] if len(numbers) > 1 else []):
                for subject in goal.subjects:
                    for move in goal.moves:
                        yield from self._solved(now, subject, literals, motions, chosen, move)

    def _solved(
        self, now: _Version, goal: Goal, literals: Sequence[_Literal], motions: Sequence[FloatArray | None],
        chosen: Sequence[int], move: Vector,
    ) -> Iterator[_Candidate]:  # fmt: skip
        """Yield the change of the chosen literals that is nearest to a translation of the goal's thing."""
        every = [motion for number in chosen if (motion := motions[number]) is not None]
        own = np.stack([_mean(motion, goal.rows) for motion in every], axis=1)
        relative = own - np.stack([_mean(motion, goal.others) for motion in every], axis=1)
        if float(np.abs(relative).max()) < 1e-9:
            return
        steps = np.linalg.lstsq(relative, np.array(move), rcond=1e-6)[0]
        length = float(np.linalg.norm(move))
        off = float(np.linalg.norm(relative @ steps - move))
        if off > _OFF * length or not np.isfinite(steps).all():
            return
        whole = np.tensordot(steps, np.stack(every), 1)
        cost = _cost(whole, goal) + off + _TIDY * now.size * len(chosen)
        digits = _digits(now.size)
        for places, extra in ((digits - 2, 0.0), (digits, 1e-9 * now.size), (9, 2e-9 * now.size)):
            values = [literals[n].value + step for n, step in zip(chosen, steps.tolist())]
            changes = tuple((literals[n].span, _number(v, places)) for n, v in zip(chosen, values))
            written = 1e-7 * now.size * sum(len(new) for _, new in changes)  # of equal ones, the simplest
            yield _Candidate(changes, cost + extra + written, tuple(chosen))

    def _by_amount_or_turn(self, now: _Version, goal: Goal) -> Iterator[_Candidate]:
        """Yield changes of one literal by which the amount of a failed declaration becomes 0, and turns of a part."""
        if goal.declaration is None or goal.moves:
            return
        if goal.turn is not None:
            yield from self._turned(now, goal)
        for literal in literals_of(Source(self.name, now.text)):
            if not self.has_time():
                return
            found = self._root_of(now, goal, literal)
            if found is not None:
                yield found

    def _root_of(self, now: _Version, goal: Goal, literal: _Literal) -> _Candidate | None:
        whole = isinstance(literal.value, int) and abs(literal.value) < 1000
        step = 1.0 if whole and goal.key[1].startswith("(count") else 1e-3 * max(1.0, abs(literal.value))
        value, before = float(literal.value), goal.amount
        for _ in range(4):
            there = self._amount(now, goal, literal, value + step)
            if there is None or abs(there - before) < 1e-9:
                return None
            value -= before * step / (there - before)
            value = round(value) if step == 1.0 else value
            amount = self._amount(now, goal, literal, value)
            if amount is None:
                return None
            if amount == 0.0:
                candidate = _Candidate(((literal.span, _number(value, _digits(now.size))),), 0.0)
                found = self._applied(now, candidate)
                moved = None if found is None else _displacement(now.corners, found.corners)
                changed = abs(value - literal.value)  # of numbers of things, the nearest is meant
                return _Candidate(candidate.changes, _TIDY * now.size * (1 + changed) if moved is None else moved)
            before = amount
        return None

    def _turned(self, now: _Version, goal: Goal) -> Iterator[_Candidate]:
        """Yield turns of the operands of ``union`` that place something, about their own vertical axis."""
        for group in unions_of(Source(self.name, now.text)):
            for part in group:
                if _head(part) != "transform" or len(part.items) != 3 or not self.has_time():
                    continue
                moved = self._moved_by(now, goal, part)
                if moved is None:
                    continue
                call, pose = part.items[1].span.text, part.items[2].span.text
                turn = goal.turn if np.linalg.det(moved[0]) > 0.0 else -(goal.turn or 0.0)
                for places in (2, 4):
                    new = f"(transform {call} (@ {pose} (rotate {_number(turn or 0.0, places)} [0 1 0])))"
                    yield _Candidate(((part.span, new),), _STRUCTURAL * now.size)

    def _amount(self, now: _Version, goal: Goal, literal: _Literal, value: float) -> float | None:
        """Return how far the goal's declaration is from holding with another value of a literal; 0 if it holds."""
        text = _replaced(now.text, literal.span, _number(value, 12))
        found = self.editing.evaluate(Source(self.name, text)).scene
        if found is None:
            return None
        from scenelang.backends.geometry.relations import violations

        try:
            every = violations(found, self.extra, lambda declaration: str(declaration) == str(goal.declaration))
        except SceneError:
            return None
        return sum(violation.amount for violation in every)

    # --- forms -------------------------------------------------------------------------------------------------

    def _by_form(self, now: _Version, goal: Goal) -> Iterator[_Candidate]:
        """Yield new placements of the operands of ``union``: moved, without a pose, or removed."""
        if not len(goal.rows):
            return
        yield from self._unwrapped(now, goal)
        groups = unions_of(Source(self.name, now.text))
        parts = [part for group in groups for part in group][:_MAX_PARTS]
        if goal.key[0] in _OVERLAPS:
            yield from (_Candidate(((part.span, ""),), 0.0) for part in parts if self._is_double(now, part))
        if goal.key[0] == "twin":
            return
        for part in parts:
            moved = self._moved_by(now, goal, part) if self.has_time() else None
            for move in goal.moves if moved is not None else ():
                assert moved is not None
                offset = np.linalg.lstsq(moved[0], np.array(move), rcond=1e-6)[0]
                cost = _cost(moved[1] @ offset, goal) + _STRUCTURAL * now.size
                for places in (_digits(now.size) - 2, _digits(now.size)):
                    numbers = " ".join(_number(x, places) for x in offset)
                    new = f"(transform {part.span.text} (translate [{numbers}]))"
                    yield _Candidate(((part.span, new),), cost + 1e-9 * places)

    def _unwrapped(self, now: _Version, goal: Goal) -> Iterator[_Candidate]:
        """Yield the program without one of the poses that turn, scale or move what the goal is about."""
        source = Source(self.name, now.text)
        changes = [(form.span, form.items[1].span.text) for form in poses_of(source)]
        changes += [(angle.span, "0") for angle in angles_of(source)]
        for change in changes[: 2 * _MAX_PARTS]:
            if not self.has_time():
                return
            found = self._applied(now, _Candidate((change,), 0.0))
            if found is None or found.corners.shape != now.corners.shape:
                continue
            motion = found.corners - now.corners
            if np.abs(motion[goal.rows]).max() > _STILL * now.size:
                yield _Candidate((change,), float(np.linalg.norm(motion, axis=1).mean()) + _STRUCTURAL * now.size)

    def _moved_by(self, now: _Version, goal: Goal, part: Datum) -> tuple[FloatArray, FloatArray] | None:
        """Return how the goal's thing (3, 3) and all corners (N, 3, 3) move with a translation of a part, per unit.

        None if the thing does not move.
        """
        found, whole = np.zeros((3, 3)), np.zeros((len(now.corners), 3, 3))
        step = _STEP * now.size
        for axis in range(3):
            offset = " ".join(_number(step if k == axis else 0.0, 12) for k in range(3))
            text = f"(transform {part.span.text} (translate [{offset}]))"
            corners = self.layout(_replaced(now.text, part.span, text))
            if corners is None or corners.shape != now.corners.shape:
                return None
            motion = (corners - now.corners) / step
            found[:, axis] = _mean(motion, goal.rows) - _mean(motion, goal.others)
            whole[:, :, axis] = motion
            if axis == 0 and not np.abs(motion).max() > 1e-6:
                return None
        return (found, whole) if np.abs(found).max() > 1e-6 else None

    def _is_double(self, now: _Version, part: Datum) -> bool:
        """Return whether all that a part makes is there without it too."""
        corners = self.layout(_replaced(now.text, part.span, ""))
        if corners is None:
            return False
        kept, every = _places(corners, now.size), _places(now.corners, now.size)
        return len(kept) > 0 and kept == every and len(corners) < len(now.corners)


def _cost(motion: FloatArray, goal: Goal) -> float:
    """Return what a motion (N, 3) of all corners costs: its mean length, twice for what is in no finding, and how much
    it bends the thing."""
    rows = goal.rows
    bent = float(np.linalg.norm(motion[rows] - motion[rows].mean(axis=0), axis=1).max())
    moved = np.linalg.norm(motion, axis=1)
    return float(2.0 * moved.sum() - moved[rows].sum()) / len(moved) + bent


def _is_better(now: _Version, found: _Version, goal: Goal) -> bool:
    """Return whether a version resolves one goal at least, and makes no finding that was not there."""
    fewer = now.counts - found.counts
    return (
        fewer[goal.key] > 0 and not found.counts - now.counts and sum(found.counts.values()) < sum(now.counts.values())
    )


# --- layouts ---------------------------------------------------------------------------------------------------------


def _alternatives(move: Vector, relation: str) -> tuple[Vector, ...]:
    """Return a translation and, for what only keeps a distance, those along the ground and one axis that do as much."""
    if relation not in ("distance", "clear-of", "touching"):
        return (move,)
    found = [move]
    for axes in ((0, 2), (0,), (2,)):
        along = np.array([x if axis in axes else 0.0 for axis, x in enumerate(move)])
        square = float(along @ along)
        if square > 0.1 * sum(x * x for x in move):
            x, y, z = (along * float(np.dot(move, move)) / square).tolist()
            found.append((x, y, z))
    return tuple(dict.fromkeys(found))


def _sampled(scene: Scene) -> list[int]:
    from scenelang.backends.geometry.lint import checked_frames

    return checked_frames(scene)


def _layout(scene: Scene) -> FloatArray:
    """Return two corners (2N, 3) of the boxes of the primitives of some frames, one frame after the other."""
    return np.concatenate([_corners_in(scene.frames[number]) for number in _sampled(scene)])


def _corners_in(root: Entity) -> FloatArray:
    frame = flatten_entity(root)
    local = np.array([_corners(entity) for entity in frame.primitives]).reshape(-1, 2, 3)
    matrices = np.asarray(frame.matrices).reshape(-1, 3, 4)
    if not len(matrices):
        return np.zeros((0, 3))
    found = np.einsum("nij,nkj->nki", matrices[:, :, :3], local[frame.index]) + matrices[:, None, :, 3]
    return np.asarray(found.reshape(-1, 3), np.float64)


def _corners(entity: Entity) -> tuple[float, ...]:
    assert entity.shape is not None
    return tuple(entity.shape.box_under(IDENTITY))


def _offsets(scene: Scene) -> dict[int, int]:
    """Return for each frame of the layout the position of its first primitive."""
    found, at = {}, 0
    for number in _sampled(scene):
        found[number] = at
        at += primitive_count(scene.frames[number])
    return found


def _between(rows: tuple[int, int] | None) -> IntArray | None:
    return None if rows is None else np.arange(rows[0], rows[1] + 1)


def _rows(primitives: IntArray | None, at: int) -> IntArray:
    """Return the rows of the layout for primitives of a frame that begins at ``at``."""
    if primitives is None:
        return np.zeros(0, np.int64)
    return np.stack([2 * (primitives + at), 2 * (primitives + at) + 1], axis=1).reshape(-1)


def _mean(motion: FloatArray, rows: IntArray) -> FloatArray:
    return np.asarray(motion[rows].mean(axis=0), np.float64) if len(rows) else np.zeros(3)


def _places(corners: FloatArray, size: float) -> set[tuple[float, ...]]:
    return set(map(tuple, np.round(corners / (1e-6 * size)).tolist()))


# --- findings of the geometry lint -----------------------------------------------------------------------------------


def _lint_goals(scene: Scene, offsets: dict[int, int]) -> list[Goal]:
    from scenelang.backends.geometry.convex import clusters
    from scenelang.backends.geometry.lint import CheckedFrame

    found = []
    for number, at in offsets.items():
        frame = CheckedFrame(scene.frames[number])
        bodies, thing = frame.bodies, frame.contacts.thing
        cluster = clusters(len(bodies), bodies.contacts[0].tolist()) if frame.findings else thing
        for each in frame.findings:
            rows = bodies.row[thing == thing[each.body]]
            others = None if each.other is None else bodies.row[thing == thing[each.other]]
            words = "/".join(bodies.words(each.body)), "" if each.other is None else "/".join(bodies.words(each.other))
            message = f'{each.kind} "{words[0]}"' + (f' and "{words[1]}"' if words[1] else "")
            moves = (*_moves(bodies, each), *_falls(frame, cluster, each))
            body = _rows(bodies.row[[each.body]], at)
            goal = Goal((each.kind, *words), message, each.amount, _rows(rows, at), _rows(others, at), moves, body=body)
            found.append(goal)
    return found


def _falls(frame: CheckedFrame, cluster: IntArray, finding: Finding) -> Iterator[Vector]:
    """Yield how far the things that touch the subject of a finding can fall: to the ground, and to what is below."""
    from scenelang.backends.geometry.lint import ground_height

    if finding.kind not in ("hovering", "hanging", "unstable", "tipping"):
        return
    bodies = frame.bodies
    low, high = bodies.boxes
    own = cluster == cluster[finding.body]
    foot, least, most = float(low[own, 1].min()), low[own].min(axis=0), high[own].max(axis=0)
    below = ~own & (high[:, 1] <= foot + bodies.touch)
    for axis in (0, 2):
        below &= (low[:, axis] < most[axis]) & (high[:, axis] > least[axis])
    heights = {ground_height(bodies), *([float(high[below, 1].max())] if below.any() else [])}
    yield from ((0.0, height - foot, 0.0) for height in sorted(heights, reverse=True) if foot - height > bodies.touch)


def _moves(bodies: Any, finding: Finding) -> tuple[Vector, ...]:
    """Return the translations that would resolve a finding: its own, or those that separate the two boxes."""
    if finding.move is not None:
        return (finding.move,)
    if finding.other is None or finding.kind == "twin":
        return ()
    low, high = bodies.boxes
    i, j = finding.body, finding.other
    moves = []
    for axis in range(3):
        for length in (high[j, axis] - low[i, axis], low[j, axis] - high[i, axis]):
            if finding.kind == "fighting":
                length = math.copysign(4.0 * bodies.touch, length)
            moves.append(tuple(float(length) if k == axis else 0.0 for k in range(3)))
    return tuple(sorted(moves, key=lambda move: sum(map(abs, move))))  # type: ignore[arg-type]


# --- text ------------------------------------------------------------------------------------------------------------


def literals_of(source: Source) -> list[_Literal]:
    """Return the numbers of a program that may place things, at most 400, each with those of the same vector."""
    found: list[_Literal] = []
    stack: list[tuple[Datum, Datum | None]] = [(form, None) for form in reversed(read(source).forms)]
    while stack and len(found) < _MAX_LITERALS:
        datum, parent = stack.pop()
        if isinstance(datum, Atom):
            if type(datum.value) in (int, float) and math.isfinite(datum.value):
                found.append(_Literal(datum.span, datum.value, id(parent) if _is_vector(parent) else id(datum)))
            continue
        stack.extend((child, datum) for child in reversed(list(_placing(datum))))
    return found


def _is_vector(datum: Datum | None) -> bool:
    return isinstance(datum, ArrayDatum) or (
        isinstance(datum, ListDatum) and _head(datum) in ("vector", "quote", "list")
    )


def _head(datum: Datum) -> str | None:
    first = datum.items[0] if isinstance(datum, ListDatum) and datum.items else None
    return str(first.value) if isinstance(first, Atom) and isinstance(first.value, Symbol) else None


def _placing(datum: Datum) -> Iterator[Datum]:
    """Yield the parts of a form that may place things: not colours, bounds of params and seeds."""
    head = _head(datum)
    if head in _NO_LITERALS:
        return
    skip = False
    for child in subdatums(datum):
        if skip:
            skip = False
            continue
        if isinstance(child, Atom) and isinstance(child.value, Keyword):
            skip = str(child.value) in ("color", "opacity", "min", "max", "segments", "seed", "roughness", "metallic")
        yield child


def unions_of(source: Source) -> list[list[ListDatum]]:
    """Return the operands of each ``union`` of a program that are forms, and the bodies of loops that make parts."""
    first = {"union": 1, "for/union": 2, "for*/union": 2}
    return [
        [item for item in form.items[first[head] :] if isinstance(item, ListDatum)]
        for head, form in _forms(source)
        if head in first
    ]


def poses_of(source: Source) -> list[ListDatum]:
    """Return the forms ``(transform part (rotate ...))``, and those with ``scale``, ``translate`` or ``@``."""
    heads = ("rotate", "scale", "translate", "@")
    return [
        form
        for head, form in _forms(source)
        if head == "transform" and len(form.items) == 3 and _head(form.items[2]) in heads
    ]


def angles_of(source: Source) -> list[Atom]:
    """Return the numbers that are angles of ``rotate`` and not 0."""
    angles = [form.items[1] for head, form in _forms(source) if head == "rotate" and len(form.items) > 2]
    return [each for each in angles if isinstance(each, Atom) and type(each.value) in (int, float) and each.value != 0]


def _forms(source: Source) -> Iterator[tuple[str, ListDatum]]:
    """Yield the forms of a program that begin with a name, and these names."""
    for datum in walk(*read(source).forms):
        head = _head(datum)
        if head is not None and isinstance(datum, ListDatum):
            yield head, datum


def _replaced(text: str, span: Span, new: str) -> str:
    return text[: span.start] + new + text[span.end :]


def _digits(size: float) -> int:
    """Return the number of decimals that shows a ten-thousandth of a size."""
    return max(2, math.ceil(4.0 - math.log10(max(size, 1e-12))))


def _is_same_number(old: str, new: str) -> bool:
    try:
        return float(old) == float(new)
    except ValueError:
        return False


def _number(value: float, places: int) -> str:
    text = f"{round(value, places) + 0.0:.12g}"
    if "e" in text:
        return text
    return (
        text.replace("-0.", "-.", 1) if text.startswith("-0.") else text.removeprefix("0") if text[:2] == "0." else text
    )
