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
import re
from collections import Counter
from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from scenelang.grammar.datum import ArrayDatum, Atom, Datum, Keyword, ListDatum, Source, Span, Symbol, subdatums, walk
from scenelang.grammar.diagnostics import ABOUT_SCENES, Diagnostic, Edit, Fix, SceneError
from scenelang.grammar.reader import read
from scenelang.grammar.settings import typed
from scenelang.interpreter.scene.entity import primitive_count
from scenelang.interpreter.scene.flatten import flatten_entity
from scenelang.interpreter.values.values import IDENTITY
from scenelang.repairs.alternatives import loop_counts
from scenelang.repairs.rearranging import Aim, Rearranged, aims_of, is_deeper_motion, is_sound_motion, rows_of
from scenelang.repairs.trials import Trials, cheapest, edited

if TYPE_CHECKING:
    from scenelang.backends.base import Progress
    from scenelang.backends.geometry.arrangement import Vector
    from scenelang.backends.geometry.lint import CheckedFrame
    from scenelang.backends.surfaces.distance import IntArray
    from scenelang.backends.surfaces.solids import FloatArray
    from scenelang.interpreter.scene.declarations import Declaration
    from scenelang.interpreter.scene.entity import Entity, Scene
    from scenelang.session.session import Session

EFFORT = 30.0  # of a repair: about 30 s
MAX_EDITS = 20
_MAX_LITERALS = 400
_MAX_PARTS = 60
_MAX_TESTS = 16  # candidates that are tested for one finding
_STEP = 1e-4  # of a literal, to measure what it moves
_STILL = 1e-9  # of the scene's size: less is rounding
_OFF = 0.3  # of a motion: how far the motion of a candidate may be from it
_TIDY = 5e-3  # of the scene's size: what one more changed literal costs
_INSIDE = 1e-3  # of the scene's size: what a literal costs that does not place a bound word
_STRUCTURAL = 0.02  # of the scene's size: what a new form in the program costs
_CORRECTIONS = 4
_OVERLAPS = ("twin", "through", "deep", "buried", "fighting")
_ROUNDING = 1e-2  # of a motion, and
_EXACT = 2e-5  # of the scene's size: what rounding may cost
_ALMOST = 0.05  # of its least extent: what is that near to its equal is there twice
_MAX_LOWERED = 6  # versions without a pose of which the literals are tried
_MAX_COMPARED = 20_000  # primitives that are compared with those that are left
_FARTHEST = 4.0  # times what the resolved findings need: how far things may move
_NO_LITERALS = frozenset({"assert-that", "color", "import", "format", "embedding"})


@dataclass(frozen=True, slots=True, eq=False)
class Goal:
    """A finding or failed declaration to resolve.

    ``key`` is equal for equal findings of other versions. Each of the ``aims`` would do; ``turn`` is an angle about the
    vertical axis by which the first thing would face the other. ``rows`` are those of the things that it is about.
    """

    key: tuple[str, ...]
    message: str
    amount: float
    rows: IntArray
    aims: tuple[Aim, ...]
    turn: float | None = None
    declaration: Declaration | None = None

    @property
    def need(self) -> float:
        """How far something must move at least; 0 if unknown."""
        return min((float(np.linalg.norm(move)) for aim in self.aims for move in aim.moves), default=0.0)


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

    @typed
    def diff(self, name: str = "program.scene") -> str:
        """Return a unified diff; empty if nothing changed."""
        old, new = (_lines(text) for text in (self.original, self.text))
        lines = difflib.unified_diff(old, new, name, name)
        return "".join(line if line.endswith("\n") else f"{line}\n\\ No newline at end of file\n" for line in lines)

    def data(self) -> dict[str, Any]:
        """Return the repair as JSON data."""
        edits = [{"line": e.line, "old": e.old, "new": e.new, "resolves": e.resolves} for e in self.edits]
        return {"edits": edits, "before": list(self.before), "left": list(self.left), "displacement": self.displacement}


def _lines(text: str) -> list[str]:
    """Return the lines of a text with their ends; only line feeds end lines in a diff."""
    return re.findall(r"[^\n]*\n|[^\n]+", text)


def repaired(
    session: Session,
    source: Source,
    extra: Sequence[Declaration] = (),
    *,
    effort: float = EFFORT,
    geometry: bool = True,
    progress: Progress | None = None,
) -> Repair:
    """Repair a program.

    Parameters
    ----------
    extra
        Declarations about the scene, besides those of the program.
    effort
        Units of work (``Effort``) after which no further edit is searched.
    geometry
        Whether to resolve the findings of the geometry lint too.
    progress
        Called with a fraction from 0 to 1; an exception raised by it ends the search.

    Raises
    ------
    SceneError
        If the program is wrong, or a declaration cannot be tested.
    """
    search = _Search(session, source.name, tuple(extra), geometry, effort)
    start = search.version(source.text)
    if start is None:
        raise SceneError("value", "the program has no scene")
    now, edits = start, list[ProgramEdit]()
    hopeless: set[tuple[str, ...]] = set()
    while len(edits) < MAX_EDITS and search.trials.can_go_on:
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

    The first three are tried, with the work of about ten seconds. Nothing is tried for a program with other errors.
    """
    about = [d for d in found if d.name in ABOUT_SCENES]
    if not about or any(d.is_error and d.name not in ABOUT_SCENES for d in found):
        return list(found)
    search = _Search(session, source.name, tuple(extra), geometry, _FIX_EFFORT)
    try:
        start = search.version(source.text)
    except SceneError:
        start = None
    fixes: dict[int, Fix] = {}
    left: list[Goal] = [] if start is None else list(start.goals)
    for _ in range(_MAX_FIXED):
        goal = next((each for each in left if search.trials.can_go_on), None)
        if goal is None or start is None:
            break
        better = search.step(start, goal)
        left = [each for each in left if each.key != goal.key and (better is None or each.key in better.counts)]
        finding = next((d for d in about if id(d) not in fixes and _is_about(d, goal)), None)
        if better is not None and finding is not None:
            fixes[id(finding)] = _fix_of(source, better.text)
    return [replace(d, fixes=(fixes[id(d)],)) if id(d) in fixes else d for d in found]


_FIX_EFFORT = 10.0
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
    """Return a message for each kind of finding, about the worst one."""
    worst: dict[tuple[str, ...], Goal] = {}
    for goal in version.goals:
        if goal.key not in worst or worst[goal.key].amount < goal.amount:
            worst[goal.key] = goal
    counts = version.counts
    return tuple(
        dict.fromkeys(
            each.message + (f" ({counts[key]} times)" if counts[key] > 1 else "") for key, each in worst.items()
        )
    )


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
    find: Callable[[_Version], list[Goal]]
    edits: tuple[ProgramEdit, ...] = ()

    @cached_property
    def goals(self) -> list[Goal]:
        return self.find(self)

    @cached_property
    def frames(self) -> dict[int, CheckedFrame]:
        from scenelang.backends.geometry.lint import CheckedFrame

        return {number: CheckedFrame(self.scene.frames[number]) for number in self.spans}

    @cached_property
    def spans(self) -> dict[int, tuple[int, int]]:
        """For each frame of the layout the position of its first primitive, and how many it has."""
        offsets = _offsets(self.scene)
        return {number: (at, primitive_count(self.scene.frames[number])) for number, at in offsets.items()}

    @cached_property
    def things(self) -> Rearranged:
        return Rearranged.of([(self.frames[number], at, count) for number, (at, count) in self.spans.items()])

    @cached_property
    def counts(self) -> Counter[tuple[str, ...]]:
        return Counter(goal.key for goal in self.goals)

    def cost(self, motion: FloatArray, goal: Goal) -> float:
        """Return what a motion (N, 3) of all corners costs that is to resolve a goal, or all that are equal to it."""
        if goal.key not in self._rows:
            every = [goal, *self.goals]
            equal = [each.rows for each in every if each.key == goal.key]
            self._rows[goal.key] = np.concatenate(equal), np.concatenate([each.rows for each in every])
        return self.things.cost(motion, *self._rows[goal.key])

    @cached_property
    def _rows(self) -> dict[tuple[str, ...], tuple[IntArray, IntArray]]:
        return {}

    @cached_property
    def size(self) -> float:
        """Diagonal of the box of all corners, or 1."""
        spread = np.ptp(self.corners, axis=0) if len(self.corners) else np.zeros(3)
        return float(np.linalg.norm(spread)) or 1.0


@dataclass(frozen=True, slots=True, eq=False)
class _Literal:
    """A number in the text, the group of numbers that it is changed with (those of one vector), and whether it places a
    word that the program binds."""

    span: Span
    value: float
    group: int
    places: bool


@dataclass(frozen=True, slots=True, eq=False)
class _Candidate:
    """Edits of the text, what they are expected to cost, and the numbers of the literals that they change."""

    edits: tuple[Edit, ...]
    cost: float
    literals: tuple[int, ...] = ()
    is_pose: bool = False  # a pose is left out


class _Search:
    """Search for the edits of one program. ``geometry``: findings of the lint are goals too; ``extra``: declarations
    besides those of the program."""

    def __init__(
        self, session: Session, name: str, extra: tuple[Declaration, ...], geometry: bool, effort: float
    ) -> None:
        from scenelang.session.editing import Editing

        self.name, self.extra, self.geometry = name, extra, geometry
        self.trials = Trials(name, Editing(session).evaluate, effort)
        self._motions_of: dict[str, list[FloatArray | None]] = {}  # of the literals of the last version
        self._lowered_texts: set[str] = set()

    def corners(self, scene: Scene) -> FloatArray:
        corners = _layout(scene)
        self.trials.spend_boxes(len(corners) // 2)
        return corners

    def version(self, text: str, edits: tuple[ProgramEdit, ...] = ()) -> _Version | None:
        """Evaluate a version; None if it is wrong or has no geometry."""
        result = self.trials.evaluate(text)
        if result.scene is None:
            if not edits:
                result.require()
            return None
        try:
            return _Version(text, result.scene, self.corners(result.scene), self.goals, edits)
        except SceneError:
            if not edits:
                raise
            return None

    def layout(self, text: str) -> FloatArray | None:
        """Return the corners of a version, None if it is wrong or one of its solids cannot be computed."""
        scene = self.trials.evaluate(text).scene
        try:
            return None if scene is None else self.corners(scene)
        except SceneError:
            return None

    def goals(self, version: _Version) -> list[Goal]:
        """Return all findings of a version, failed declarations first."""
        from scenelang.backends.geometry.relations import violations

        scene, offsets = version.scene, _offsets(version.scene)
        self.trials.spend_examination(len(version.corners) // 2)
        found = []
        for violation in violations(scene, self.extra):
            if violation.frame not in offsets:
                continue
            at = offsets[violation.frame]
            rows, others = rows_of(_between(violation.rows), at), rows_of(_between(violation.other_rows), at)
            moves = () if violation.move is None else _alternatives(violation.move, violation.declaration.relation)
            key = ("declaration", str(violation.declaration), violation.subject or "", str(violation.rows))
            message = f"{violation.declaration} does not hold: {violation.message}"
            turn, declaration = violation.turn, violation.declaration
            aims = (Aim.between(rows, others, moves),) if moves else ()
            found.append(Goal(key, message, violation.amount, rows, aims, turn, declaration))
        found.sort(key=lambda goal: -goal.amount)
        return [*found, *(_lint_goals(version.frames, offsets) if self.geometry else ())]

    # --- one step ----------------------------------------------------------------------------------------------

    def step(self, now: _Version, goal: Goal) -> _Version | None:
        """Return a version in which a goal is resolved and nothing new is found; None if none is found."""
        tried: set[Hashable] = set()
        spare: list[_Version] = []  # without a new finding, but with an object deeper in another

        def sound(candidate: _Candidate) -> _Version | None:
            version = self._tested(now, goal, candidate)
            if version is None or _is_sound(now, version):
                return version
            spare.append(version)
            return None

        for candidates in (self._by_literals, self._by_count, self._by_amount_or_turn, self._by_form):
            better = self.trials.first(cheapest(candidates(now, goal), _key, tried, _MAX_TESTS), sound)
            if better is not None:
                return better
            if spare and goal.declaration is not None:
                break
        return spare[0] if spare else None

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
            if left is None:
                return None
            if not candidate.literals:
                return self._lowered(now, found, goal, left) if candidate.is_pose else None
            if left.amount > 0.7 * goal.amount:
                return None
            candidate = self._corrected(now, found, left, candidate)
        return None

    def _lowered(self, now: _Version, found: _Version, goal: Goal, left: Goal) -> _Version | None:
        """Return a version in which what a removed pose leaves of a goal is resolved by a literal."""
        if (
            _too_far(now, found, goal, left.need)
            or found.text in self._lowered_texts
            or len(self._lowered_texts) >= _MAX_LOWERED
        ):
            return None
        self._lowered_texts.add(found.text)
        for candidate in cheapest(self._by_literals(found, left), _key, set(), _MAX_TESTS):
            if not self.trials.can_go_on:
                return None
            further = self._applied(found, candidate)
            try:
                if further is not None and _is_better(now, further, goal, left.need):
                    return replace(further, edits=(*found.edits, *further.edits))
            except SceneError:
                return None
        return None

    def _corrected(self, now: _Version, found: _Version, left: Goal, candidate: _Candidate) -> _Candidate:
        """Return a candidate whose literals also resolve what it leaves of a goal."""
        literals, motions = literals_of(Source(self.name, found.text)), self._motions(now)
        every = [
            each for aim in left.aims for each in self._solved(found, left, aim, literals, motions, candidate.literals)
        ]
        if not every:
            return replace(candidate, literals=())
        best = min(every, key=lambda each: each.cost)
        return _Candidate(
            tuple(Edit(old.span, new.text) for old, new in zip(candidate.edits, best.edits)), best.cost, best.literals
        )

    def _applied(self, now: _Version, candidate: _Candidate) -> _Version | None:
        changes = [edit for edit in candidate.edits if not _is_same_number(edit.span.text, edit.text)]
        changes.sort(key=lambda edit: edit.span.start)
        edits = (ProgramEdit(e.span.source.position(e.span.start)[0], e.span.text, e.text, "") for e in changes)
        return self.version(edited(now.text, changes), tuple(edits))

    # --- literals ----------------------------------------------------------------------------------------------

    def _motions(self, now: _Version) -> list[FloatArray | None]:
        """Return how all corners move with each literal, (N, 3) per unit; None if it moves nothing, or makes another
        number of primitives."""
        if now.text not in self._motions_of:
            self._motions_of.clear()
            self._motions_of[now.text] = [self._motion(now, each) for each in literals_of(Source(self.name, now.text))]
        return self._motions_of[now.text]

    def _motion(self, now: _Version, literal: _Literal) -> FloatArray | None:
        if not self.trials.can_go_on:
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
        if not goal.aims:
            return
        literals, motions = literals_of(Source(self.name, now.text)), self._motions(now)
        groups: dict[int, list[int]] = {}
        for number, literal in enumerate(literals):
            if motions[number] is not None:
                groups.setdefault(literal.group, []).append(number)
        for numbers in groups.values():
            for chosen in [[number] for number in numbers] + ([numbers] if len(numbers) > 1 else []):
                for aim in goal.aims:
                    yield from self._solved(now, goal, aim, literals, motions, chosen)

    def _solved(
        self, now: _Version, goal: Goal, aim: Aim, literals: Sequence[_Literal], motions: Sequence[FloatArray | None],
        chosen: Sequence[int],
    ) -> Iterator[_Candidate]:  # fmt: skip
        """Yield the changes of the chosen literals that are nearest to the translations of an aim."""
        every = [motion for number in chosen if (motion := motions[number]) is not None]
        relative = np.stack([aim.of(motion) for motion in every], axis=1)
        if float(np.abs(relative).max()) < 1e-9:
            return
        for move in aim.moves:
            steps = np.linalg.lstsq(relative, np.array(move), rcond=1e-6)[0]
            length = float(np.linalg.norm(move))
            off = float(np.linalg.norm(relative @ steps - move))
            if off > _OFF * length or not np.isfinite(steps).all():
                continue
            whole = np.tensordot(steps, np.stack(every), 1)
            cost = now.cost(whole, goal) + off + _TIDY * now.size * len(chosen)
            cost += 0.0 if literals[chosen[0]].places else _INSIDE * now.size
            values = np.array([literals[n].value for n in chosen]) + steps
            for rank, places in enumerate(self._places(now, goal, relative, values, length)):
                edits = tuple(Edit(literals[n].span, _number(v, places)) for n, v in zip(chosen, values.tolist()))
                written = 1e-7 * now.size * sum(len(edit.text) for edit in edits)  # of equal ones, the simplest
                yield _Candidate(edits, cost + rank * 1e-9 * now.size + written, tuple(chosen))

    def _places(self, now: _Version, goal: Goal, relative: FloatArray, values: FloatArray, length: float) -> list[int]:
        """Return the least number of decimals that is exact enough for a motion, and the exact one; for declarations,
        which have tolerances, also a lower one."""
        digits = _digits(now.size)
        if goal.declaration is not None:
            return [digits - 2, digits, 9]
        for places in range(max(digits - 2, 0), 9):
            error = float(np.linalg.norm(relative @ (np.round(values, places) - values)))
            if error <= min(_ROUNDING * length, _EXACT * now.size):
                return [places, 9]
        return [9]

    def _by_amount_or_turn(self, now: _Version, goal: Goal) -> Iterator[_Candidate]:
        """Yield changes of one literal by which the amount of a failed declaration becomes 0, and turns of a part."""
        if goal.declaration is None or goal.aims:
            return
        if goal.turn is not None:
            yield from self._turned(now, goal)
        yield from self._roots(now, goal, literals_of(Source(self.name, now.text)))

    def _by_count(self, now: _Version, goal: Goal) -> Iterator[_Candidate]:
        """Yield changes of the numbers that say how often something is made, by which a declared count holds."""
        if goal.declaration is not None and goal.declaration.relation == "count":
            source = Source(self.name, now.text)
            counts = {atom.span.start for form in walk(*read(source).forms) for atom in loop_counts(form)}
            yield from self._roots(now, goal, [each for each in literals_of(source) if each.span.start in counts])

    def _roots(self, now: _Version, goal: Goal, literals: Sequence[_Literal]) -> Iterator[_Candidate]:
        for literal in literals:
            if not self.trials.can_go_on:
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
                candidate = _Candidate((Edit(literal.span, _number(value, _digits(now.size))),), 0.0)
                found = self._applied(now, candidate)
                moved = None if found is None else _displacement(now.corners, found.corners)
                changed = abs(value - literal.value)  # of numbers of things, the nearest is meant
                return _Candidate(candidate.edits, _TIDY * now.size * (1 + changed) if moved is None else moved)
            before = amount
        return None

    def _turned(self, now: _Version, goal: Goal) -> Iterator[_Candidate]:
        """Yield turns of angles, and of the operands of ``union`` that place something, about their own vertical
        axis."""
        for angle in angles_of(Source(self.name, now.text), zero=True):
            for turn in (goal.turn or 0.0, -(goal.turn or 0.0)):
                for places in (2, 4):
                    value = math.remainder(float(angle.value) + turn, math.tau)
                    yield _Candidate((Edit(angle.span, _number(value, places)),), _TIDY * now.size + 1e-9 * places)
        for group in unions_of(Source(self.name, now.text)):
            for part in group:
                if _head(part) != "transform" or len(part.items) != 3 or not self.trials.can_go_on:
                    continue
                moved = self._moved_by(now, part)
                if moved is None or not len(goal.rows):
                    continue
                own = moved[goal.rows].mean(axis=0)
                if not np.abs(own).max() > 1e-6:
                    continue
                call, pose = part.items[1].span.text, part.items[2].span.text
                turn = math.copysign(1.0, float(np.linalg.det(own))) * (goal.turn or 0.0)
                for places in (2, 4):
                    new = f"(transform {call} (@ {pose} (rotate {_number(turn, places)} [0 1 0])))"
                    yield _Candidate((Edit(part.span, new),), _STRUCTURAL * now.size)

    def _amount(self, now: _Version, goal: Goal, literal: _Literal, value: float) -> float | None:
        """Return how far the goal's declaration is from holding with another value of a literal; 0 if it holds."""
        text = _replaced(now.text, literal.span, _number(value, 12))
        found = self.trials.evaluate(text).scene
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
        if goal.key[0] != "twin":
            yield from self._unwrapped(now, goal)
        groups = unions_of(Source(self.name, now.text))
        parts = [part for group in groups for part in group][:_MAX_PARTS]
        if goal.key[0] in _OVERLAPS:
            doubles = [part for part in parts if self._is_double(now, part)]  # the last of equal ones is removed
            yield from (_Candidate((Edit(_removed(part.span), ""),), -1e-9 * k) for k, part in enumerate(doubles))
        if goal.key[0] == "twin":
            return
        for part in parts:
            moved = self._moved_by(now, part) if goal.aims and self.trials.can_go_on else None
            for aim in goal.aims if moved is not None else ():
                assert moved is not None
                yield from self._placed(now, goal, aim, part, moved)

    def _placed(self, now: _Version, goal: Goal, aim: Aim, part: Datum, moved: FloatArray) -> Iterator[_Candidate]:
        """Yield a part with a translation around it, by which an aim is reached."""
        relative = aim.of(moved)
        if not np.abs(relative).max() > 1e-6:
            return
        for move in aim.moves:
            offset = np.linalg.lstsq(relative, np.array(move), rcond=1e-6)[0]
            cost = now.cost(moved @ offset, goal) + _STRUCTURAL * now.size
            for places in self._places(now, goal, relative, offset, float(np.linalg.norm(move))):
                numbers = " ".join(_number(x, places) for x in offset)
                new = f"(transform {part.span.text} (translate [{numbers}]))"
                yield _Candidate((Edit(part.span, new),), cost + 1e-9 * places)

    def _unwrapped(self, now: _Version, goal: Goal) -> Iterator[_Candidate]:
        """Yield the program without one of the poses that turn, scale or move what the goal is about."""
        source = Source(self.name, now.text)
        edits = [Edit(form.span, form.items[1].span.text) for form in poses_of(source)]
        edits += [Edit(angle.span, "0") for angle in angles_of(source)]
        for edit in edits[: 2 * _MAX_PARTS]:
            if not self.trials.can_go_on:
                return
            found = self._applied(now, _Candidate((edit,), 0.0))
            if found is None or found.corners.shape != now.corners.shape:
                continue
            motion = found.corners - now.corners
            if np.abs(motion[goal.rows]).max() > _STILL * now.size:
                cost = now.cost(motion, goal)
                yield _Candidate((edit,), cost + _STRUCTURAL * now.size, is_pose=True)

    def _moved_by(self, now: _Version, part: Datum) -> FloatArray | None:
        """Return how all corners move with a translation of a part, (N, 3, 3) per unit; None if nothing moves."""
        whole = np.zeros((len(now.corners), 3, 3))
        step = _STEP * now.size
        for axis in range(3):
            offset = " ".join(_number(step if k == axis else 0.0, 12) for k in range(3))
            text = f"(transform {part.span.text} (translate [{offset}]))"
            corners = self.layout(_replaced(now.text, part.span, text))
            if corners is None or corners.shape != now.corners.shape:
                return None
            whole[:, :, axis] = (corners - now.corners) / step
            if axis == 0 and not np.abs(whole).max() > 1e-6:
                return None
        return whole

    def _is_double(self, now: _Version, part: Datum) -> bool:
        """Return whether all that a part makes is there, or almost there, without it too."""
        corners = self.layout(_replaced(now.text, part.span, ""))
        if corners is None or not 0 < len(corners) < len(now.corners):
            return False
        kept, every = (boxes.reshape(-1, 6) for boxes in (corners, now.corners))
        room = _ALMOST * now.things.least(now.corners)[::2] + 1e-6 * now.size
        return all(
            bool((np.abs(kept - box).max(axis=1) <= least).any())
            for box, least in zip(every[: _MAX_COMPARED], room[: _MAX_COMPARED].tolist())
        )  # fmt: skip


def _too_far(now: _Version, found: _Version, goal: Goal, further: float = 0.0) -> bool:
    """Return whether a version moves something much farther than the findings that it resolves need, and what came up
    on the way to it (``further``)."""
    if goal.declaration is not None or found.corners.shape != now.corners.shape:
        return False
    resolved, need = now.counts - found.counts, further
    for each in now.goals:
        if resolved[each.key] > 0 or each is goal:
            resolved[each.key] -= 1
            need += each.need
    motion = np.linalg.norm(found.corners - now.corners, axis=1)
    return need > 0.0 and float(motion.max()) > _FARTHEST * need


def _is_better(now: _Version, found: _Version, goal: Goal, further: float = 0.0) -> bool:
    """Return whether a version resolves one goal at least, and makes no finding that was not there; for a finding of
    the lint also, whether things move little for it, and rest where they rested."""
    fewer = now.counts - found.counts
    if fewer[goal.key] <= 0 or found.counts - now.counts or sum(found.counts.values()) >= sum(now.counts.values()):
        return False
    return goal.declaration is not None or (
        not _too_far(now, found, goal, further) and _holds(now, found, is_sound_motion)
    )


def _is_sound(now: _Version, found: _Version) -> bool:
    """Return whether things rest in a version where they rested, and are not deeper in others."""
    return _holds(now, found, is_sound_motion) and _holds(now, found, lambda *each: not is_deeper_motion(*each))


def _holds(now: _Version, found: _Version, test: Callable[[CheckedFrame, CheckedFrame, FloatArray], bool]) -> bool:
    """Return whether a test of a motion holds in all frames."""
    if found.corners.shape != now.corners.shape:
        return True
    motion = found.corners - now.corners
    return all(
        test(now.frames[number], found.frames[number], motion[2 * at : 2 * (at + count)])
        for number, (at, count) in now.spans.items()
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


# --- findings of the geometry lint -----------------------------------------------------------------------------------


def _lint_goals(frames: Mapping[int, CheckedFrame], offsets: Mapping[int, int]) -> list[Goal]:
    from scenelang.backends.geometry.lint import message_of
    from scenelang.backends.surfaces.convex import clusters

    found = []
    for number, at in offsets.items():
        frame = frames[number]
        bodies, thing = frame.bodies, frame.contacts.object_of
        cluster = clusters(len(bodies), bodies.contacts[0].tolist()) if frame.findings else thing
        for each in frame.findings:
            words = "/".join(frame.words(each)), "" if each.other is None else "/".join(bodies.words(each.other))
            if each.whole:
                words = words[0], ""
            message = message_of(frame, each)
            rows = rows_of(bodies.row[thing == thing[each.body]], at)
            aims = tuple(aims_of(frame, each, cluster, at))
            found.append(Goal((each.kind, *words), message, each.amount, rows, aims))
    return found


# --- text ------------------------------------------------------------------------------------------------------------


def literals_of(source: Source) -> list[_Literal]:
    """Return the numbers of a program that may place things, at most 400, each with those of the same vector."""
    found: list[_Literal] = []
    forms = read(source).forms
    bound = {_called(form) for form in forms if _head(form) == "bind"}
    stack: list[tuple[Datum, Datum | None, bool]] = [(form, None, False) for form in reversed(forms)]
    while stack and len(found) < _MAX_LITERALS:
        datum, parent, places = stack.pop()
        if isinstance(datum, Atom):
            if type(datum.value) in (int, float) and math.isfinite(datum.value):
                group = id(parent) if _is_vector(parent) else id(datum)
                found.append(_Literal(datum.span, datum.value, group, places))
            continue
        pose = None
        if isinstance(datum, ListDatum) and _head(datum) == "transform" and len(datum.items) == 3:
            called = datum.items[1]
            pose = datum.items[2] if _head(called) == "call" and _called(called) in bound else None
        stack.extend((child, datum, places or child is pose) for child in reversed(list(_placing(datum))))
    return found


def _called(form: Datum) -> str | None:
    """Return the word of a form such as ``(call "cup")`` or ``(bind "cup" ...)``."""
    second = form.items[1] if isinstance(form, ListDatum) and len(form.items) > 1 else None
    return second.value if isinstance(second, Atom) and type(second.value) is str else None


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


def imports_of(source: Source) -> list[ListDatum]:
    """Return the forms of a program that import files."""
    return [form for head, form in _forms(source) if head == "import"]


def angles_of(source: Source, zero: bool = False) -> list[Atom]:
    """Return the numbers that are angles of ``rotate``, those that are 0 only if ``zero``."""
    angles = [form.items[1] for head, form in _forms(source) if head == "rotate" and len(form.items) > 2]
    return [
        each
        for each in angles
        if isinstance(each, Atom) and type(each.value) in (int, float) and (zero or each.value != 0)
    ]


def _forms(source: Source) -> Iterator[tuple[str, ListDatum]]:
    """Yield the forms of a program that begin with a name, and these names."""
    for datum in walk(*read(source).forms):
        head = _head(datum)
        if head is not None and isinstance(datum, ListDatum):
            yield head, datum


def _key(candidate: _Candidate) -> Hashable:
    """Return what is equal for candidates that make the same text."""
    changes = (
        (edit.span.start, edit.text) for edit in candidate.edits if not _is_same_number(edit.span.text, edit.text)
    )
    return frozenset(changes)


def _replaced(text: str, span: Span, new: str) -> str:
    return text[: span.start] + new + text[span.end :]


def _removed(span: Span) -> Span:
    """Return the place of a form with the blanks before it, and the break before them if nothing else is in its
    line."""
    text, start = span.source.text, span.start
    while start > 0 and text[start - 1] in " \t":
        start -= 1
    alone = start > 0 and text[start - 1] == "\n" and text[span.end : span.end + 1] in ("", "\n")
    return Span(span.source, start - 1 if alone else start, span.end)


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
