"""Repair of programs without a language model: edits of literals that resolve findings and failed declarations.

The program is edited, not its scene: a literal moves everything that is made from it, so loops and symmetries remain.
For each finding, the motion of all primitives with each numeric literal is measured by finite differences. The literals
of a vector are solved for the motion that resolves the finding (least squares), and the candidates are tested, those
that move least first. If no literal helps, a part is moved with ``translate``, a pose is left out, or a duplicate is
removed.

The search follows "Procedural Scene Programs for Open-Universe Scene Generation: LLM-Free Error Correction via Program
Search" (arXiv 2510.16147), with derivatives in place of sampled proposals: one evaluation per literal measures what it
moves, so few candidates are tested. Declarations without a translation (``count``, ``size``) have no such derivative;
for them, secants on each literal find a root. The candidates are rated in ``rearranging``.
"""

from __future__ import annotations

import difflib
import math
import re
from collections import Counter
from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any

import numpy as np

from scenelang.backends.facts.tolerances import (
    AROUND,
    DEEPER,
    GLUED,
    LOOSE_SLIP,
    ORDER_SLIP,
    OTHER_SLIP,
    POINT_SLIP,
    SIBLING_SLIP,
    SIGN_SLIP,
    TURN_SLIP,
    ZERO_SLIP,
)
from scenelang.grammar.datum import ArrayDatum, Atom, Datum, Keyword, ListDatum, Source, Span, Symbol, subdatums, walk
from scenelang.grammar.diagnostics import ABOUT_SCENES, Diagnostic, Edit, Fix, SceneError
from scenelang.grammar.reader import read
from scenelang.grammar.settings import typed
from scenelang.interpreter.scene.entity import primitive_count
from scenelang.interpreter.scene.flatten import flatten_entity
from scenelang.interpreter.values.values import IDENTITY
from scenelang.repairs.alternatives import loop_counts
from scenelang.repairs.edit_trials import Trials, cheapest, edited, version_evaluator
from scenelang.repairs.rearranging import (
    Aim,
    ObjectCorners,
    aims_of,
    effort_of,
    is_deeper_motion,
    is_deforming_motion,
    is_sound_motion,
    rows_of,
)
from scenelang.repairs.slips import (
    attributes_left_out,
    changed_numbers,
    changed_orders,
    completed_grids,
    completed_lists,
    number_text,
    pattern_values,
    sibling_values,
)

if TYPE_CHECKING:
    from scenelang.backends.base import Progress
    from scenelang.backends.geometry.arrangement import Vector
    from scenelang.backends.geometry.lint import CheckedFrame, Finding
    from scenelang.backends.surfaces.distance import IntArray
    from scenelang.backends.surfaces.solids import FloatArray
    from scenelang.interpreter.scene.declarations import Declaration
    from scenelang.interpreter.scene.entity import Entity, Scene
    from scenelang.session.session import Session

# Budgets, in units of ``Trials`` (about a second each).
EFFORT = 30.0  # of a repair
_FIX_EFFORT = 10.0  # of the fixes that `check` offers
# Limits of the search. Each literal costs one evaluation per version, each part three.
MAX_EDITS = 20
_MAX_FIXED = 3  # findings that get a fix in `check`
_MAX_CHANGED_LITERALS = 400  # of a program, the first ones: 400 evaluations for the derivatives of a version
_MAX_CHANGED_PARTS = 60  # members of unions, the first ones: 180 evaluations for those of a version
_MAX_CANDIDATES_OF_FINDING = 16  # the cheapest ones, for one finding and kind of edit
_MAX_UNPOSED_VERSIONS = 6  # versions without a pose whose literals are tried
_MAX_COMPARED = 20_000  # primitives of a part that are compared with the remaining ones
_MAX_CORRECTIONS = 4  # of a motion that is not linear in the literals (Newton's method with the first derivatives)
_MAX_SECANT_STEPS = 4  # towards the value of a literal at which a declaration holds: two evaluations each
_MAX_TITLE_LENGTH = 40  # characters of an edit in the title of a fix
# Steps and tolerances of the derivatives, which are forward differences in double precision.
_LITERAL_STEP = 1e-4  # relative to a literal, or to the scene's size for a part
_SECANT_STEP = 1e-3  # relative to a literal
_MOTION_TOLERANCE = 1e-9  # relative to the scene's size: smaller motions are rounding
_MIN_DERIVATIVE = 1e-6  # scene units per unit of translation: smaller ones do not move a part
_NEGLIGIBLE = 1e-9  # derivatives of an aim and differences of amounts below this are rounding
_BOX_TOLERANCE = 1e-6  # relative to the scene's size: boxes closer than this are equal
_RCOND = 1e-6  # of least squares: directions that a vector does not move are left alone
_MAX_MISS = 0.3  # relative to a motion: a candidate that misses it by more is not tested
_MIN_PROGRESS = 0.7  # a correction must leave less than this part of the finding's amount
# Costs, in units of the scene's size, on top of how far objects move. They only order candidates that move about as
# much: fewer literals, then those that place a word that the program binds, then no new form.
_LITERAL_COST = 5e-3  # of each further literal
_INNER_LITERAL_COST = 1e-3  # of a literal that does not place a bound word
_FORM_COST = 0.02  # of a new form
_CHARACTER_COST = 1e-7  # of a written character: among equal edits, the simplest
_TIE_COST = 1e-9  # keeps the order of candidates that are equal otherwise
# Numbers are written with the fewest decimals whose error is below both of these.
_ROUNDING_OF_MOTION = 1e-2  # relative to the motion
_ROUNDING_OF_SCENE = 2e-5  # relative to the scene's size
_MAX_DECIMALS = 9
_EXACT_DECIMALS = 12  # of a literal that is changed by a step and never written to a file
# A part is a duplicate if its box differs from an equal one by less than 5 % of the shortest side of its object. The
# lint has the same threshold (``backends/geometry/lint``).
_DUPLICATE_DISTANCE = 0.05
# An edit may move objects up to four times as far as the findings that it resolves need. On planted faults, repairs
# move them by 1.16 times the planted displacement in the mean (docs/relations.md).
_MAX_EXCESS = 4.0
# Ends of the kinds of findings that any edit may add: faces in one plane, and a guess about symmetry, may be meant.
_ACCEPTED = ("coplanar note", "outlier note")
# Weights of the way of a slip by its kind. Where only a contact resolves a finding, a number that reaches one by chance
# is rare; where room does, many numbers make room.
_SLIPS_TO_CONTACTS = {
    "sibling": SIBLING_SLIP, "other": OTHER_SLIP, "sign": SIGN_SLIP, "turn": TURN_SLIP, "operation": TURN_SLIP,
    "zero": ZERO_SLIP, "point": POINT_SLIP, "order": ORDER_SLIP,
}  # fmt: skip
_SLIPS_TO_ROOM = {**_SLIPS_TO_CONTACTS, "sibling": SIGN_SLIP, "other": LOOSE_SLIP, "zero": LOOSE_SLIP}
_MAX_SLIPS_OF_KIND = 4  # that are tried for one finding
_USUAL_SHARE = 0.9  # of a program's numbers, which have at most the usual decimals: a number with more lost its point
_NEAREST_WAYS = 3  # to contacts, of which the longest tells how far an object may be from its place
_PATTERN_REACH = 4.0  # times as far as others may move: a number that completes a pattern
_ZERO_REACH = 2.0  # times as far as others may move: a coordinate of an object that belongs to an axis
_MIN_EXTENT_LEFT = 0.3  # of a primitive's longest extent: a cone that is to hang higher is not made flat
_MIN_VOLUME_LEFT = 0.2  # of a solid: a slab that tips is not made thin
_MAX_ROUNDING = 2.0  # times the change that a finding needs, by which a rounder number may exceed it
_EXACT_KINDS = ("floating", "sunk")  # findings whose resolution is a contact: there are no rounder numbers for it
_BALANCE_KINDS = ("tips", "slides", "falls")  # findings that more room resolves better
_OVERLAP_KINDS = ("twin", "deep", "hidden", "coplanar")  # findings that removing a duplicate may resolve
_NO_LITERALS = frozenset({"assert-that", "color", "import", "format", "embedding"})  # forms whose numbers place nothing
_NO_PLACEMENT = frozenset({"color", "opacity", "min", "max", "segments", "seed", "roughness", "metallic"})  # keywords


@dataclass(frozen=True, eq=False)
class Goal:
    """A finding or failed declaration to resolve.

    Attributes
    ----------
    key
        Identity across versions: kind, words and place; equal for findings of one kind about the same words.
    message
        Text of the finding.
    amount
        How far it is from holding; 0 if it holds. The unit is that of the check.
    rows
        Rows of the layout of the objects that it is about.
    find_aims
        Computes alternative motions, each of which resolves it; those of a finding are tried, which takes long.
    turn
        Angle in radians about the vertical axis by which the first object would face the second; None if it is not
        about orientation.
    declaration
        The failed declaration; None for a finding of the lint.
    """

    key: tuple[str, ...]
    message: str
    amount: float
    rows: IntArray
    find_aims: Callable[[], Iterable[Aim]] = tuple
    turn: float | None = None
    declaration: Declaration | None = None

    @property
    def is_note(self) -> bool:
        """Whether it is a finding that may be meant: no edit resolves it, and none may cause it."""
        return self.key[0].endswith(" note")

    @cached_property
    def aims(self) -> tuple[Aim, ...]:
        """Alternative motions, each of which resolves it."""
        return tuple(self.find_aims())

    @property
    def need(self) -> float:
        """Shortest translation that resolves it, in scene units; 0 if unknown.

        Where none was tried with success, the ways to contacts of the least effort tell how far it may be.
        """
        known = [math.hypot(*move) for aim in self.aims if not aim.efforts for move in aim.moves]
        ways = [math.hypot(*move) for aim in self.aims if aim.efforts for move in aim.moves[:_NEAREST_WAYS]]
        return min(known) if known else max(ways, default=0.0)


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
        The program after all edits; equal to the original if there were no findings or none could be repaired.
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
        """Whether the program was edited."""
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
        goal = next((goal for goal in now.goals if goal.key not in hopeless and not goal.is_note), None)
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
    session: Session, source: Source, diagnostics: Sequence[Diagnostic], extra: Sequence[Declaration] = (), *,
    geometry: bool = True,
) -> list[Diagnostic]:  # fmt: skip
    """Return diagnostics in which findings about the scene have fixes: the edit of the program that resolves each.

    The first three are tried, with a budget of about ten seconds. Nothing is tried for a program with other errors.
    """
    about = [d for d in diagnostics if d.name in ABOUT_SCENES]
    if not about or any(d.is_error and d.name not in ABOUT_SCENES for d in diagnostics):
        return list(diagnostics)
    search = _Search(session, source.name, tuple(extra), geometry, _FIX_EFFORT)
    try:
        start = search.version(source.text)
    except SceneError:
        start = None
    fixes: dict[int, Fix] = {}
    left: list[Goal] = [] if start is None else [goal for goal in start.goals if not goal.is_note]
    for _ in range(_MAX_FIXED):
        goal = left[0] if left and search.trials.can_go_on else None
        if goal is None or start is None:
            break
        better = search.step(start, goal)
        left = [rest for rest in left if rest.key != goal.key and (better is None or rest.key in better.counts)]
        finding = next((d for d in about if id(d) not in fixes and _is_about(d, goal)), None)
        if better is not None and finding is not None:
            fixes[id(finding)] = _fix_of(source, better.text)
    return [replace(d, fixes=(fixes[id(d)],)) if id(d) in fixes else d for d in diagnostics]


def _is_about(diagnostic: Diagnostic, goal: Goal) -> bool:
    """Return whether a diagnostic reports a goal: it names its declaration, or the last three of its words."""
    if goal.declaration is not None:
        return diagnostic.name == "declaration" and str(goal.declaration) in diagnostic.message
    _, subject, *_ = goal.key
    words = "/".join(subject.split("/")[-3:])
    return diagnostic.name != "declaration" and f'"{words}"' in diagnostic.message


def _fix_of(source: Source, text: str) -> Fix:
    """Return the fix that turns one text into another by its smallest edit."""
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
    title = f"Change to `{new}`" if len(new) <= _MAX_TITLE_LENGTH and new else "Change the program"
    return Fix(title, (Edit(Span(source, head, len(old) - tail), new),))


def _messages(version: _Version) -> tuple[str, ...]:
    """Return a message for each kind of finding, about the worst one."""
    worst: dict[tuple[str, ...], Goal] = {}
    for goal in version.goals:
        if goal.is_note:
            continue
        if goal.key not in worst or worst[goal.key].amount < goal.amount:
            worst[goal.key] = goal
    counts = version.counts
    messages = (goal.message + (f" ({counts[key]} times)" if counts[key] > 1 else "") for key, goal in worst.items())
    return tuple(dict.fromkeys(messages))


def _displacement(before: FloatArray, after: FloatArray) -> float | None:
    """Return the mean distance between corners of two layouts; None if the numbers of primitives differ."""
    if before.shape != after.shape:
        return None
    return float(np.linalg.norm(after - before, axis=1).mean()) if len(before) else 0.0


# --- versions of the program -----------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class _Version:
    """An evaluated version of the program.

    Attributes
    ----------
    corners
        Two corners (2N, 3) of the box of each primitive of the checked frames, in scene units.
    find
        Computes the goals.
    edits
        Edits that led to it.
    """

    text: str
    scene: Scene
    corners: FloatArray
    find: Callable[[_Version], list[Goal]]
    edits: tuple[ProgramEdit, ...] = ()

    @cached_property
    def goals(self) -> list[Goal]:
        """Findings and failed declarations."""
        return self.find(self)

    @cached_property
    def frames(self) -> dict[int, CheckedFrame]:
        """Geometry checks of the frames of the layout."""
        from scenelang.backends.geometry.lint import CheckedFrame

        return {number: CheckedFrame(self.scene.frames[number]) for number in self.spans}

    @cached_property
    def spans(self) -> dict[int, tuple[int, int]]:
        """Position of the first primitive, and number of primitives, of each frame of the layout."""
        offsets = _offsets(self.scene)
        return {number: (at, primitive_count(self.scene.frames[number])) for number, at in offsets.items()}

    @cached_property
    def objects(self) -> ObjectCorners:
        """Objects that the corners belong to."""
        return ObjectCorners.of([(self.frames[number], at, count) for number, (at, count) in self.spans.items()])

    @cached_property
    def counts(self) -> Counter[tuple[str, ...]]:
        """Number of goals of each key."""
        return Counter(goal.key for goal in self.goals)

    def cost(self, motion: FloatArray, goal: Goal) -> float:
        """Return the cost of a motion (N, 3) of all corners that is to resolve all goals of one key."""
        if goal.key not in self._rows:
            every = [goal, *self.goals]
            equal = [other.rows for other in every if other.key == goal.key]
            self._rows[goal.key] = np.concatenate(equal), np.concatenate([other.rows for other in every])
        return self.objects.cost(motion, *self._rows[goal.key])

    @cached_property
    def _rows(self) -> dict[tuple[str, ...], tuple[IntArray, IntArray]]:
        """Rows of the goals of each key, and of all goals; a search asks for them thousands of times."""
        return {}

    def rows_around(self, goal: Goal) -> IntArray:
        """Return the rows of the objects of a goal, and of those as near as its amount or a tenth of its size."""
        if not len(goal.rows):
            return goal.rows
        own = self.corners[goal.rows]
        low, high = own.min(axis=0), own.max(axis=0)
        room = max(goal.amount, AROUND * float(np.linalg.norm(high - low)))
        is_near = ((self.corners >= low - room) & (self.corners <= high + room)).all(axis=1)
        labels = self.objects.labels
        return np.flatnonzero(np.isin(labels, np.unique(np.concatenate([labels[is_near], labels[goal.rows]]))))

    @cached_property
    def size(self) -> float:
        """Diagonal of the box of all corners, in scene units; 1 for an empty scene, since it divides."""
        spread = np.ptp(self.corners, axis=0) if len(self.corners) else np.zeros(3)
        return float(np.linalg.norm(spread)) or 1.0


@dataclass(frozen=True, slots=True, eq=False)
class _Literal:
    """A number in the text.

    ``group`` is equal for the numbers of one vector, which are solved together. ``places`` says whether it places a
    word
    that the program binds.
    """

    span: Span
    value: float
    group: int
    places: bool


@dataclass(frozen=True, slots=True, eq=False)
class _Candidate:
    """Edits to try, their expected cost, and the indices of the literals that they change.

    ``is_pose`` marks those that leave out a pose. ``reach`` is a factor of the way that it may move objects: longer
    for a number that completes a pattern. ``slip`` is the kind of a slip of the author.
    """

    edits: tuple[Edit, ...]
    cost: float
    literals: tuple[int, ...] = ()
    is_pose: bool = False
    reach: float = 1.0
    slip: str = ""

    @property
    def accepted(self) -> tuple[str, ...]:
        """The ends of the kinds of findings that it may add: notes, if it completes a pattern."""
        return (" note",) if self.reach > 1.0 and not self.slip else _ACCEPTED

    def further(self, goal: Goal) -> float:
        """Return how much farther than a goal needs it may move objects, as a further need."""
        return (self.reach - 1.0) * (goal.need or goal.amount)


class _Search:
    """Search for the edits of one program.

    ``geometry`` adds the findings of the lint to the goals, ``extra`` declarations besides those of the program.
    """

    def __init__(
        self, session: Session, name: str, extra: tuple[Declaration, ...], geometry: bool, effort: float
    ) -> None:
        self.name, self.extra, self.geometry = name, extra, geometry
        self.trials = Trials(name, version_evaluator(session), effort)
        self._motions_of: dict[str, list[FloatArray | None]] = {}  # of the literals, for the last version only
        self._unposed_texts: set[str] = set()

    def corners(self, scene: Scene) -> FloatArray:
        """Return the corners of a scene, and charge for them."""
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
        """Return the goals of a version: failed declarations by decreasing amount, then findings of the lint."""
        from scenelang.backends.geometry.relations import violations

        scene, offsets = version.scene, _offsets(version.scene)
        self.trials.spend_examination(len(version.corners) // 2)
        failed = []
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
            failed.append(Goal(key, message, violation.amount, rows, partial(tuple, aims), turn, declaration))
        failed.sort(key=lambda goal: -goal.amount)
        return [*failed, *(_lint_goals(version.frames, offsets) if self.geometry else ())]

    # --- one step ----------------------------------------------------------------------------------------------

    def step(self, now: _Version, goal: Goal) -> _Version | None:
        """Return a version in which a goal is resolved without a new finding; None if none is found."""
        tried: set[Hashable] = set()
        spare: list[tuple[float, _Version]] = []  # versions that resolve the goal, but not well, with their costs

        def sound(candidate: _Candidate) -> _Version | None:
            """Return the version of a candidate if it is flawless; others that resolve the goal are spare.

            What a short way leaves deeper in another object, or held only if it is glued, is nearer to what was meant
            than a slip that moves it far.
            """
            version = self._tested(now, goal, candidate)
            if version is None:
                return None
            is_held = _stands(version, goal)
            if not is_held or not _is_sound(now, version):
                weight = math.inf if candidate.slip not in ("", "sibling") else DEEPER if is_held else GLUED
                spare.append((weight * candidate.cost, version))
                return None
            least = min((cost for cost, _ in spare), default=math.inf)
            if least < candidate.cost:
                return next(version for cost, version in spare if cost == least)
            return self._tidied(now, goal, candidate) or version

        ways = (
            self._by_pattern, self._by_completion, self._by_number, self._by_count, self._by_amount_or_turn,
            self._by_form,
        )  # fmt: skip
        for candidates in ways:
            most = _MAX_CANDIDATES_OF_FINDING + len(_SLIPS_TO_ROOM) * _MAX_SLIPS_OF_KIND
            better = self.trials.first(cheapest(candidates(now, goal), _key, tried, most), sound)
            if better is not None:
                return better
            if spare and goal.declaration is not None:
                break
        return min(spare, key=lambda each: each[0])[1] if spare else None

    def _tested(self, now: _Version, goal: Goal, candidate: _Candidate) -> _Version | None:
        """Return the version that a candidate makes if it is better.

        A motion that is not linear in the literals, such as that of an angle, is corrected by Newton's method.
        """
        for _ in range(_MAX_CORRECTIONS):
            version = self._applied(now, candidate)
            if version is not None and goal.declaration is None and not candidate.is_pose:
                if self._is_broken(now, version) or (goal.key[0] == "floating" and _is_apart(version, goal)):
                    return None  # known without the facts of the version, which take longest
            try:
                if version is None or _is_better(now, version, goal, candidate.further(goal), candidate.accepted):
                    return version
                left = next((other for other in version.goals if other.key == goal.key), None)
            except SceneError:
                return None
            if left is None:
                return None
            if not candidate.literals:
                return self._without_pose(now, version, goal, left) if candidate.is_pose else None
            if left.amount > _MIN_PROGRESS * goal.amount:
                return None
            candidate = self._corrected(now, version, left, candidate)
        return None

    def _without_pose(self, now: _Version, version: _Version, goal: Goal, left: Goal) -> _Version | None:
        """Resolve by a literal what the removal of a pose leaves of a goal.

        Without its turn, an object may float where the turned one touched the ground.
        """
        if (
            _too_far(now, version, goal, left.need)
            or version.text in self._unposed_texts
            or len(self._unposed_texts) >= _MAX_UNPOSED_VERSIONS
        ):
            return None
        self._unposed_texts.add(version.text)
        for candidate in cheapest(self._by_literals(version, left), _key, set(), _MAX_CANDIDATES_OF_FINDING):
            if not self.trials.can_go_on:
                return None
            further = self._applied(version, candidate)
            try:
                if further is not None and _is_better(now, further, goal, left.need):
                    return replace(further, edits=(*version.edits, *further.edits))
            except SceneError:
                return None
        return None

    def _corrected(self, now: _Version, version: _Version, left: Goal, candidate: _Candidate) -> _Candidate:
        """Return a candidate whose literals also resolve what it leaves of a goal."""
        literals, motions = literals_of(Source(self.name, version.text)), self._motions(now)
        solutions = [
            solution
            for aim in left.aims
            for solution in self._solved(version, left, aim, literals, motions, candidate.literals)
        ]
        if not solutions:
            return replace(candidate, literals=())
        best = min(solutions, key=lambda solution: solution.cost)
        # The spans are those of the original text, to which all edits of a candidate are applied.
        return _Candidate(
            tuple(Edit(old.span, new.text) for old, new in zip(candidate.edits, best.edits)), best.cost, best.literals
        )

    def _applied(self, now: _Version, candidate: _Candidate) -> _Version | None:
        """Return the version that a candidate makes, without edits that change nothing; None if it is wrong."""
        changes = [edit for edit in candidate.edits if not _is_same_number(edit.span.text, edit.text)]
        changes.sort(key=lambda edit: edit.span.start)
        edits = (ProgramEdit(e.span.source.position(e.span.start)[0], e.span.text, e.text, "") for e in changes)
        return self.version(edited(now.text, changes), tuple(edits))

    # --- patterns ----------------------------------------------------------------------------------------------

    def _by_pattern(self, now: _Version, goal: Goal) -> Iterator[_Candidate]:
        """Yield changes of the one number of a list without which it is even or symmetric: a slip of the author."""
        if goal.declaration is not None or goal.key[0] not in (*_EXACT_KINDS, *_BALANCE_KINDS, "deep"):
            return
        source = Source(self.name, now.text)
        values, around = pattern_values(source), now.rows_around(goal)
        for literal, motion in zip(literals_of(source), self._motions(now) if values else ()):
            value = values.get(literal.span.start)
            if motion is None or value is None or np.abs(motion[around]).max(initial=0.0) <= _MIN_DERIVATIVE:
                continue
            way = float(np.linalg.norm(motion, axis=1).max()) * abs(value - literal.value)
            if way <= _PATTERN_REACH * _MAX_EXCESS * (goal.need or goal.amount):
                edit = Edit(literal.span, number_text(value, _MAX_DECIMALS))
                cost = now.size * len(edit.text) + now.cost(motion * (value - literal.value), goal)  # simple ones first
                yield _Candidate((edit,), cost, reach=_PATTERN_REACH)

    def _tidied(self, now: _Version, goal: Goal, candidate: _Candidate) -> _Version | None:
        """Return a version with a simpler number than that of a candidate that resolves a finding, None if none does.

        What hung over an edge is placed well inside, and a coordinate that belongs to an axis of symmetry is 0.
        """
        if goal.declaration is not None or not candidate.literals:
            return None
        for simpler in self._simpler(now, goal, candidate):
            version = self._applied(now, simpler) if self.trials.can_go_on else None
            try:
                if version is None:
                    continue
                if _is_better(now, version, goal, simpler.further(goal), simpler.accepted):
                    return version
            except SceneError:
                continue
        return None

    def _simpler(self, now: _Version, goal: Goal, candidate: _Candidate) -> Iterator[_Candidate]:
        """Yield candidates with simpler numbers: zeros first, then numbers of fewer digits, farther than needed."""
        literals = literals_of(Source(self.name, now.text))
        chosen = [literals[number] for number in candidate.literals]
        is_exact = goal.key[0] in _EXACT_KINDS
        vector = [
            (literal, motion)
            for literal, motion in zip(literals, self._motions(now))
            if literal.group == chosen[0].group and motion is not None
        ]
        for literal, motion in vector if len(vector) > 1 else ():
            is_level = float(np.abs(motion[goal.rows, 1]).max()) <= _MIN_DERIVATIVE
            is_whole = literal.places  # else a part of an object, which is where it is by the object's symmetry
            if literal.value != 0.0 and (is_level and not is_whole if is_exact else is_whole):
                yield _Candidate((Edit(literal.span, "0"),), 0.0, reach=_ZERO_REACH if is_exact else 1.0)
        if goal.key[0] not in _BALANCE_KINDS or len(chosen) != 1:
            return
        literal, value = chosen[0], float(candidate.edits[0].text)
        places = len(literal.span.text.partition(".")[2])
        for step in (5.0 * 10.0**-places, 10.0**-places):
            outward = math.ceil if value > literal.value else math.floor
            rounder = outward(value / step) * step
            if rounder and abs(rounder - value) <= _MAX_ROUNDING * abs(value - literal.value):
                yield _Candidate((Edit(literal.span, number_text(rounder, _MAX_DECIMALS)),), 0.0)

    # --- slips -------------------------------------------------------------------------------------------------

    def _by_completion(self, now: _Version, goal: Goal) -> Iterator[_Candidate]:
        """Yield lists with what they lack, and calls without an attribute too much, for what has lost its balance."""
        if goal.key[0] not in _BALANCE_KINDS:
            return
        source = Source(self.name, now.text)
        changes = [*((edit,) for edit in attributes_left_out(source)), *completed_grids(source)]
        changes += [(edit,) for edit in completed_lists(source)]
        for rank, edits in enumerate(changes):
            yield _Candidate(tuple(edits), rank * _TIE_COST)

    def _by_number(self, now: _Version, goal: Goal) -> Iterator[_Candidate]:
        """Yield changes of literals that reach an aim of a goal, and those that a slip of the author suggests."""
        yield from cheapest(self._by_literals(now, goal), _key, set(), _MAX_CANDIDATES_OF_FINDING)
        slips = sorted(self._by_slip(now, goal), key=lambda candidate: candidate.cost)
        kinds = Counter[str]()
        for slip in slips:
            kinds[slip.slip] += 1
            if kinds[slip.slip] <= _MAX_SLIPS_OF_KIND:
                yield slip

    def _by_slip(self, now: _Version, goal: Goal) -> Iterator[_Candidate]:
        """Yield what siblings, signs, decimal points and orders suggest in place of what moves the objects of a goal.

        The cost is that of the motion, times how unlikely the slip is: for a finding that only a contact resolves, what
        reaches it exactly is hardly there by chance.
        """
        if goal.declaration is not None or goal.key[0] not in (*_EXACT_KINDS, *_BALANCE_KINDS, "deep"):
            return
        source = Source(self.name, now.text)
        rows, literals = now.rows_around(goal), literals_of(source)
        least = _MOTION_TOLERANCE * now.size
        starts = [
            literal.span.start
            for literal, motion in zip(literals, self._motions(now))
            if motion is not None and float(np.abs(motion[rows]).max(initial=0.0)) > _MIN_DERIVATIVE
        ]
        decimals = sorted(_decimals(literal.span.text) for literal in literals)
        usual = decimals[int(_USUAL_SHARE * (len(decimals) - 1))] if decimals else 0
        weights = _SLIPS_TO_CONTACTS if goal.key[0] in _EXACT_KINDS else _SLIPS_TO_ROOM
        for slip in dict.fromkeys((*sibling_values(source), *changed_numbers(source), *changed_orders(source))):
            span = slip.edit.span
            is_computed = slip.kind in ("turn", "operation")  # of names, of which no number tells what they move
            if not is_computed and not any(span.start <= start < span.end for start in starts):
                continue
            if slip.kind == "point" and _decimals(span.text) <= usual:
                continue
            corners = self.layout(_replaced(now.text, span, slip.edit.text)) if self.trials.can_go_on else None
            if corners is None or corners.shape != now.corners.shape:
                continue
            motion = corners - now.corners
            if np.abs(motion[rows]).max(initial=0.0) > least and not self._is_deforming(now, motion):
                if slip.kind in ("point", "order", "zero") and now.objects.is_deforming(motion, least):
                    continue  # what is too thin to stand is not meant to be ten times as thick
                move = motion[goal.rows].mean(axis=0)
                cost = weights[slip.kind] * effort_of(move) * now.cost(motion, goal) + _LITERAL_COST * now.size
                yield _Candidate((slip.edit,), cost, reach=_PATTERN_REACH, slip=slip.kind)

    def _is_broken(self, now: _Version, version: _Version) -> bool:
        """Return whether a shape is made flat, or an object that holds is torn apart."""
        if version.corners.shape != now.corners.shape:
            return False
        is_broken = _is_collapsed(now, version) or self._is_deforming(now, version.corners - now.corners)
        return is_broken or any(_is_thinned(now.frames[number], version.frames[number]) for number in now.spans)

    def _is_deforming(self, now: _Version, motion: FloatArray) -> bool:
        """Return whether a motion of all corners moves parts of a body that holds as it is apart."""
        return any(
            is_deforming_motion(now.frames[number], motion[2 * at : 2 * (at + count)])
            for number, (at, count) in now.spans.items()
        )

    # --- literals ----------------------------------------------------------------------------------------------

    def _motions(self, now: _Version) -> list[FloatArray | None]:
        """Return the derivative (N, 3) of all corners by each literal.

        It is None for a literal that moves nothing, or changes the number of primitives.
        """
        if now.text not in self._motions_of:
            self._motions_of.clear()
            literals = literals_of(Source(self.name, now.text))
            self._motions_of[now.text] = [self._motion(now, literal) for literal in literals]
        return self._motions_of[now.text]

    def _motion(self, now: _Version, literal: _Literal) -> FloatArray | None:
        """Return the derivative of all corners by a literal, by a forward difference."""
        if not self.trials.can_go_on:
            return None
        step = _LITERAL_STEP * max(1.0, abs(literal.value))
        text = _replaced(now.text, literal.span, number_text(literal.value + step, _EXACT_DECIMALS))
        corners = self.layout(text)
        if corners is None or corners.shape != now.corners.shape:
            return None
        motion: FloatArray = (corners - now.corners) / step
        return motion if np.abs(motion).max(initial=0.0) > _MOTION_TOLERANCE * now.size / step else None

    def _by_literals(self, now: _Version, goal: Goal) -> Iterator[_Candidate]:
        """Yield changes of single literals and of whole vectors that reach an aim of a goal."""
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
        """Yield the values of literals whose motion is nearest to the translations of an aim.

        Parameters
        ----------
        literals, motions
            All literals of the version, and their derivatives.
        chosen
            Indices of the literals that are solved for: one, or all of a vector.
        """
        derivatives = [motion for number in chosen if (motion := motions[number]) is not None]
        relative = np.stack([aim.of(motion) for motion in derivatives], axis=1)
        if float(np.abs(relative).max()) < _NEGLIGIBLE:
            return
        for move, effort in zip(aim.moves, aim.efforts or (1.0,) * len(aim.moves)):
            steps = np.linalg.lstsq(relative, np.array(move), rcond=_RCOND)[0]
            length = float(np.linalg.norm(move))
            miss = float(np.linalg.norm(relative @ steps - move))
            if miss > _MAX_MISS * length or not np.isfinite(steps).all():
                continue
            whole = np.tensordot(steps, np.stack(derivatives), 1)
            cost = effort * now.cost(whole, goal) + miss + _LITERAL_COST * now.size * len(chosen)
            cost += 0.0 if literals[chosen[0]].places else _INNER_LITERAL_COST * now.size
            values = np.array([literals[n].value for n in chosen]) + steps
            for rank, places in enumerate(self._places(now, goal, relative, values, length)):
                edits = tuple(Edit(literals[n].span, number_text(v, places)) for n, v in zip(chosen, values.tolist()))
                length_cost = _CHARACTER_COST * now.size * sum(len(edit.text) for edit in edits)
                yield _Candidate(edits, cost + rank * _TIE_COST * now.size + length_cost, tuple(chosen))

    def _places(self, now: _Version, goal: Goal, relative: FloatArray, values: FloatArray, length: float) -> list[int]:
        """Return the numbers of decimals to try, the least that is exact enough first.

        Declarations have tolerances, so fewer decimals are tried for them too.
        """
        digits = _digits(now.size)
        if goal.declaration is not None:
            return [digits - 2, digits, _MAX_DECIMALS]
        for places in range(max(digits - 2, 0), _MAX_DECIMALS):
            error = float(np.linalg.norm(relative @ (np.round(values, places) - values)))
            if error <= min(_ROUNDING_OF_MOTION * length, _ROUNDING_OF_SCENE * now.size):
                return [places, _MAX_DECIMALS]
        return [_MAX_DECIMALS]

    def _by_amount_or_turn(self, now: _Version, goal: Goal) -> Iterator[_Candidate]:
        """Yield changes of one literal by which a failed declaration holds, and turns of a part."""
        if goal.declaration is None or goal.aims:
            return
        if goal.turn is not None:
            yield from self._turned(now, goal)
        yield from self._roots(now, goal, literals_of(Source(self.name, now.text)))

    def _by_count(self, now: _Version, goal: Goal) -> Iterator[_Candidate]:
        """Yield changes of the numbers of repetitions by which a declared count holds."""
        if goal.declaration is not None and goal.declaration.relation == "count":
            source = Source(self.name, now.text)
            counts = {atom.span.start for form in walk(*read(source).forms) for atom in loop_counts(form)}
            yield from self._roots(now, goal, [number for number in literals_of(source) if number.span.start in counts])

    def _roots(self, now: _Version, goal: Goal, literals: Sequence[_Literal]) -> Iterator[_Candidate]:
        """Yield for each literal the value at which the goal's declaration holds, if there is one."""
        for literal in literals:
            if not self.trials.can_go_on:
                return
            root = self._root_of(now, goal, literal)
            if root is not None:
                yield root

    def _root_of(self, now: _Version, goal: Goal, literal: _Literal) -> _Candidate | None:
        """Find the value of a literal at which the goal's declaration holds, by the secant method.

        A count is changed by whole numbers. Its cost is how many it adds or removes, because the nearest count is
        meant.
        """
        whole = isinstance(literal.value, int) and abs(literal.value) < 1000
        step = 1.0 if whole and goal.key[1].startswith("(count") else _SECANT_STEP * max(1.0, abs(literal.value))
        value, before = float(literal.value), goal.amount
        for _ in range(_MAX_SECANT_STEPS):
            ahead = self._amount(now, goal, literal, value + step)
            if ahead is None or abs(ahead - before) < _NEGLIGIBLE:
                return None
            value -= before * step / (ahead - before)
            value = round(value) if step == 1.0 else value
            amount = self._amount(now, goal, literal, value)
            if amount is None:
                return None
            if amount == 0.0:
                candidate = _Candidate((Edit(literal.span, number_text(value, _digits(now.size))),), 0.0)
                version = self._applied(now, candidate)
                moved = None if version is None else _displacement(now.corners, version.corners)
                changed = abs(value - literal.value)
                return _Candidate(candidate.edits, _LITERAL_COST * now.size * (1 + changed) if moved is None else moved)
            before = amount
        return None

    def _turned(self, now: _Version, goal: Goal) -> Iterator[_Candidate]:
        """Yield turns about the vertical by the angle that a goal asks for.

        They change the angles of the program, then add a turn to the operands of ``union`` that have a pose.
        """
        for angle in angles_of(Source(self.name, now.text), zero=True):
            for turn in (goal.turn or 0.0, -(goal.turn or 0.0)):
                for places in (2, 4):
                    value = math.remainder(float(angle.value) + turn, math.tau)
                    cost = _LITERAL_COST * now.size + _TIE_COST * places
                    yield _Candidate((Edit(angle.span, number_text(value, places)),), cost)
        for group in unions_of(Source(self.name, now.text)):
            for part in group:
                if _head(part) != "transform" or len(part.items) != 3 or not self.trials.can_go_on:
                    continue
                moved = self._moved_by(now, part)
                if moved is None or not len(goal.rows):
                    continue
                frame = moved[goal.rows].mean(axis=0)
                if not np.abs(frame).max() > _MIN_DERIVATIVE:
                    continue
                call, pose = part.items[1].span.text, part.items[2].span.text
                # A mirrored part turns the other way.
                turn = math.copysign(1.0, float(np.linalg.det(frame))) * (goal.turn or 0.0)
                for places in (2, 4):
                    new = f"(transform {call} (@ {pose} (rotate {number_text(turn, places)} [0 1 0])))"
                    yield _Candidate((Edit(part.span, new),), _FORM_COST * now.size)

    def _amount(self, now: _Version, goal: Goal, literal: _Literal, value: float) -> float | None:
        """Return how far the goal's declaration is from holding with another value of a literal; 0 if it holds."""
        text = _replaced(now.text, literal.span, number_text(value, _EXACT_DECIMALS))
        scene = self.trials.evaluate(text).scene
        if scene is None:
            return None
        from scenelang.backends.geometry.relations import violations

        try:
            failures = violations(scene, self.extra, lambda declaration: str(declaration) == str(goal.declaration))
        except SceneError:
            return None
        return sum(violation.amount for violation in failures)

    # --- forms -------------------------------------------------------------------------------------------------

    def _by_form(self, now: _Version, goal: Goal) -> Iterator[_Candidate]:
        """Yield edits of the operands of ``union``: without a pose, without a duplicate, or moved."""
        if not len(goal.rows):
            return
        if goal.key[0] != "twin":
            yield from self._unwrapped(now, goal)
        groups = unions_of(Source(self.name, now.text))
        parts = [part for group in groups for part in group][:_MAX_CHANGED_PARTS]
        if goal.key[0] in _OVERLAP_KINDS:
            duplicates = [part for part in parts if self._is_duplicate(now, part)]
            yield from (
                _Candidate((Edit(_removed(part.span), ""),), -_TIE_COST * k)  # the last of several is removed
                for k, part in enumerate(duplicates)
            )
        if goal.key[0] == "twin":
            return
        known = any(not aim.efforts for aim in goal.aims)
        for part in parts:
            moved = self._moved_by(now, part) if known and self.trials.can_go_on else None
            for aim in goal.aims if moved is not None else ():
                assert moved is not None
                if not aim.efforts:
                    yield from self._placed(now, goal, aim, part, moved)

    def _placed(self, now: _Version, goal: Goal, aim: Aim, part: Datum, moved: FloatArray) -> Iterator[_Candidate]:
        """Yield a part inside a translation that reaches an aim."""
        relative = aim.of(moved)
        if not np.abs(relative).max() > _MIN_DERIVATIVE:
            return
        for move in aim.moves:
            offset = np.linalg.lstsq(relative, np.array(move), rcond=_RCOND)[0]
            cost = now.cost(moved @ offset, goal) + _FORM_COST * now.size
            for places in self._places(now, goal, relative, offset, float(np.linalg.norm(move))):
                numbers = " ".join(number_text(x, places) for x in offset)
                new = f"(transform {part.span.text} (translate [{numbers}]))"
                yield _Candidate((Edit(part.span, new),), cost + _TIE_COST * places)

    def _unwrapped(self, now: _Version, goal: Goal) -> Iterator[_Candidate]:
        """Yield the program without one of the poses, or turns, of the objects of the goal."""
        source = Source(self.name, now.text)
        edits = [Edit(form.span, form.items[1].span.text) for form in poses_of(source)]
        edits += [Edit(angle.span, "0") for angle in angles_of(source)]
        for edit in edits[: 2 * _MAX_CHANGED_PARTS]:
            if not self.trials.can_go_on:
                return
            version = self._applied(now, _Candidate((edit,), 0.0))
            if version is None or version.corners.shape != now.corners.shape:
                continue
            motion = version.corners - now.corners
            if np.abs(motion[goal.rows]).max() > _MOTION_TOLERANCE * now.size:
                cost = now.cost(motion, goal)
                yield _Candidate((edit,), cost + _FORM_COST * now.size, is_pose=True)

    def _moved_by(self, now: _Version, part: Datum) -> FloatArray | None:
        """Return the derivative (N, 3, 3) of all corners by a translation of a part; None if nothing moves."""
        whole = np.zeros((len(now.corners), 3, 3))
        step = _LITERAL_STEP * now.size
        for axis in range(3):
            offset = " ".join(number_text(step if k == axis else 0.0, _EXACT_DECIMALS) for k in range(3))
            text = f"(transform {part.span.text} (translate [{offset}]))"
            corners = self.layout(_replaced(now.text, part.span, text))
            if corners is None or corners.shape != now.corners.shape:
                return None
            whole[:, :, axis] = (corners - now.corners) / step
            if axis == 0 and not np.abs(whole).max() > _MIN_DERIVATIVE:
                return None
        return whole

    def _is_duplicate(self, now: _Version, part: Datum) -> bool:
        """Return whether every primitive of a part has an equal one, or almost, in the scene without the part."""
        corners = self.layout(_replaced(now.text, part.span, ""))
        if corners is None or not 0 < len(corners) < len(now.corners):
            return False
        remaining, every = (boxes.reshape(-1, 6) for boxes in (corners, now.corners))
        room = _DUPLICATE_DISTANCE * now.objects.least_extents(now.corners)[::2] + _BOX_TOLERANCE * now.size
        return all(
            bool((np.abs(remaining - box).max(axis=1) <= least).any())
            for box, least in zip(every[: _MAX_COMPARED], room[: _MAX_COMPARED].tolist())
        )  # fmt: skip


def _too_far(now: _Version, version: _Version, goal: Goal, further: float = 0.0) -> bool:
    """Return whether a version moves a corner much farther than the findings that it resolves need.

    ``further`` is the need of findings that arose on the way and are resolved again.
    """
    if goal.declaration is not None or version.corners.shape != now.corners.shape:
        return False
    resolved, need = now.counts - version.counts, further
    for other in now.goals:
        if resolved[other.key] > 0 or other is goal:
            resolved[other.key] -= 1
            need += max(other.need, other.amount) if other.key[0] in _BALANCE_KINDS else other.need or other.amount
    motion = np.linalg.norm(version.corners - now.corners, axis=1)
    return need > 0.0 and float(motion.max()) > _MAX_EXCESS * need


def _is_better(
    now: _Version, version: _Version, goal: Goal, further: float = 0.0, accepted: tuple[str, ...] = _ACCEPTED
) -> bool:
    """Return whether a version resolves at least one goal of the key of ``goal`` and adds no finding but ``accepted``.

    For a finding of the lint, objects must also move little and keep their support. A declaration is a wish of the
    author, so it is met whatever moves.
    """
    if _is_collapsed(now, version):
        return False
    fewer, new = now.counts - version.counts, version.counts - now.counts
    new = Counter({key: count for key, count in new.items() if not key[0].endswith(accepted)})
    if fewer[goal.key] <= 0 or new:
        return False
    return goal.declaration is not None or (
        not _too_far(now, version, goal, further) and _holds(now, version, is_sound_motion)
    )


def _is_collapsed(now: _Version, version: _Version) -> bool:
    """Return whether a primitive loses nearly all of an extent: a cone whose ends become one point."""
    if version.corners.shape != now.corners.shape:
        return False
    before, after = (np.abs(np.diff(v.corners.reshape(-1, 2, 3), axis=1)).max(axis=2) for v in (now, version))
    return bool((after < _MIN_EXTENT_LEFT * before).any())


def _is_thinned(before: CheckedFrame, after: CheckedFrame) -> bool:
    """Return whether a solid loses nearly all of its volume: slabs as thin as paper cannot tip."""
    old, new = before.solids.masses[0], after.solids.masses[0]
    return len(old) == len(new) and bool((new < _MIN_VOLUME_LEFT * old).any())


def _is_apart(version: _Version, goal: Goal) -> bool:
    """Return whether what floats is apart from the boxes of all others, and higher than the lowest of them."""
    rows = np.concatenate([goal.rows, *(aim.rows for aim in goal.aims)])
    for number, (at, _) in version.spans.items():
        solids = version.frames[number].solids
        low, high = solids.boxes
        own = np.isin(2 * (solids.row + at), rows)
        room = 2.0 * solids.touch
        near = np.ones((int(own.sum()), int((~own).sum())), bool)
        for axis in range(3):
            near &= low[own, axis][:, None] <= high[~own, axis] + room
            near &= high[own, axis][:, None] >= low[~own, axis] - room
        if near.any() or (own.any() and low[own, 1].min() <= low[:, 1].min() + room):
            return False
    return True


def _stands(version: _Version, goal: Goal) -> bool:
    """Return whether the object of a finding holds: a note about it may be one about others that it has joined."""
    for number, (at, count) in version.spans.items():
        frame = version.frames[number]
        own = np.isin(2 * (frame.solids.row + at), goal.rows)
        bodies = np.unique(frame.facts.bodies.body[own]) if count else ()
        if not all(frame.facts.verdicts[int(body)].holds for body in bodies):
            return False
    return True


def _is_sound(now: _Version, version: _Version) -> bool:
    """Return whether objects keep their support in a version, and penetrate each other no deeper."""
    return _holds(now, version, is_sound_motion) and _holds(now, version, lambda *motion: not is_deeper_motion(*motion))


def _holds(now: _Version, version: _Version, test: Callable[[CheckedFrame, CheckedFrame, FloatArray], bool]) -> bool:
    """Return whether a test of the motion between two versions holds in all frames."""
    if version.corners.shape != now.corners.shape:
        return True
    motion = version.corners - now.corners
    return all(
        test(now.frames[number], version.frames[number], motion[2 * at : 2 * (at + count)])
        for number, (at, count) in now.spans.items()
    )


# --- layouts ---------------------------------------------------------------------------------------------------------


def _alternatives(move: Vector, relation: str) -> tuple[Vector, ...]:
    """Return the translations that resolve a declaration.

    If it only concerns a distance, those along the ground and along one axis that gain the same distance are
    alternatives.
    """
    if relation not in ("distance", "clear-of", "touching"):
        return (move,)
    moves = [move]
    for axes in ((0, 2), (0,), (2,)):
        along = np.array([x if axis in axes else 0.0 for axis, x in enumerate(move)])
        square = float(along @ along)
        if square > 0.1 * sum(x * x for x in move):
            x, y, z = (along * float(np.dot(move, move)) / square).tolist()
            moves.append((x, y, z))
    return tuple(dict.fromkeys(moves))


def _sampled(scene: Scene) -> list[int]:
    """Return the numbers of the frames of the layout: those that the lint checks."""
    from scenelang.backends.geometry.lint import checked_frames

    return checked_frames(scene)


def _layout(scene: Scene) -> FloatArray:
    """Return the corners (2N, 3) of the boxes of all primitives in the sampled frames, frame after frame."""
    return np.concatenate([_corners_in(scene.frames[number]) for number in _sampled(scene)])


def _corners_in(root: Entity) -> FloatArray:
    """Return the corners (2N, 3) of the boxes of a frame: the images of the corners of each local box."""
    frame = flatten_entity(root)
    local = np.array([_corners(entity) for entity in frame.primitives]).reshape(-1, 2, 3)
    matrices = np.asarray(frame.matrices).reshape(-1, 3, 4)
    if not len(matrices):
        return np.zeros((0, 3))
    corners = np.einsum("nij,nkj->nki", matrices[:, :, :3], local[frame.index]) + matrices[:, None, :, 3]
    return np.asarray(corners.reshape(-1, 3), np.float64)


def _corners(entity: Entity) -> tuple[float, ...]:
    """Return the low and high corner of a primitive in its own axes."""
    assert entity.shape is not None
    return tuple(entity.shape.box_under(IDENTITY))


def _offsets(scene: Scene) -> dict[int, int]:
    """Return the position of the first primitive of each frame of the layout."""
    offsets, at = {}, 0
    for number in _sampled(scene):
        offsets[number] = at
        at += primitive_count(scene.frames[number])
    return offsets


def _between(rows: tuple[int, int] | None) -> IntArray | None:
    """Return the primitives from the first to the last, both included."""
    return None if rows is None else np.arange(rows[0], rows[1] + 1)


# --- findings of the geometry lint -----------------------------------------------------------------------------------


def _lint_goals(frames: Mapping[int, CheckedFrame], offsets: Mapping[int, int]) -> list[Goal]:
    """Return the findings of the lint in some frames as goals, in its order.

    Notes, and what does not hold in most frames of a film, are goals that no edit resolves: a ball that jumps floats.
    """
    from scenelang.backends.geometry.lint import message_of

    named = [
        (number, finding, (finding.kind, *_words_of(frames[number], finding)))
        for number in offsets
        for finding in frames[number].findings
    ]
    holds = Counter(key for _, key in {(number, key) for number, _, key in named})
    goals = []
    for number, finding, key in named:
        frame, at = frames[number], offsets[number]
        is_note = bool(finding.note) or 2 * holds[key] <= len(offsets)
        rows = rows_of(frame.solids.row[frame.subject(finding)], at)
        aims = tuple if is_note else partial(aims_of, frame, finding, at)
        named_key = (f"{key[0]} note" if is_note else key[0], *key[1:])
        goals.append(Goal(named_key, message_of(frame, finding), finding.amount, rows, aims))
    return goals


def _words_of(frame: CheckedFrame, finding: Finding) -> tuple[str, str]:
    """Return the words of the subject of a finding, and of the solid that it is in or near."""
    other = "" if finding.other is None or finding.whole else "/".join(frame.solids.words(finding.other))
    return "/".join(frame.words(finding)), other


# --- text ------------------------------------------------------------------------------------------------------------


def literals_of(source: Source) -> list[_Literal]:
    """Return the numbers of a program that may place objects, at most 400, those of one vector in one group."""
    literals: list[_Literal] = []
    forms = read(source).forms
    bound = {_called(form) for form in forms if _head(form) == "bind"}
    stack: list[tuple[Datum, Datum | None, bool]] = [(form, None, False) for form in reversed(forms)]
    while stack and len(literals) < _MAX_CHANGED_LITERALS:
        datum, parent, places = stack.pop()
        if isinstance(datum, Atom):
            if type(datum.value) in (int, float) and math.isfinite(datum.value):
                group = id(parent) if _is_vector(parent) else id(datum)
                literals.append(_Literal(datum.span, datum.value, group, places))
            continue
        pose = None
        if isinstance(datum, ListDatum) and _head(datum) == "transform" and len(datum.items) == 3:
            called = datum.items[1]
            pose = datum.items[2] if _head(called) == "call" and _called(called) in bound else None
        stack.extend((child, datum, places or child is pose) for child in reversed(list(_placing(datum))))
    return literals


def _called(form: Datum) -> str | None:
    """Return the word of a form such as ``(call "cup")`` or ``(bind "cup" ...)``."""
    second = form.items[1] if isinstance(form, ListDatum) and len(form.items) > 1 else None
    return second.value if isinstance(second, Atom) and type(second.value) is str else None


def _is_vector(datum: Datum | None) -> bool:
    """Return whether a form writes a vector or a list, whose numbers belong together."""
    return isinstance(datum, ArrayDatum) or (
        isinstance(datum, ListDatum) and _head(datum) in ("vector", "quote", "list")
    )


def _head(datum: Datum) -> str | None:
    """Return the symbol that a form begins with; None if it begins with none."""
    first = datum.items[0] if isinstance(datum, ListDatum) and datum.items else None
    return str(first.value) if isinstance(first, Atom) and isinstance(first.value, Symbol) else None


def _placing(datum: Datum) -> Iterator[Datum]:
    """Yield the parts of a form whose numbers may place objects: no colors, bounds of params or seeds."""
    head = _head(datum)
    if head in _NO_LITERALS:
        return
    skip = False
    for child in subdatums(datum):
        if skip:
            skip = False
            continue
        if isinstance(child, Atom) and isinstance(child.value, Keyword):
            skip = str(child.value) in _NO_PLACEMENT
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
    """Return the literal angles of ``rotate``; those that are 0 only if ``zero``."""
    angles = [form.items[1] for head, form in _forms(source) if head == "rotate" and len(form.items) > 2]
    numbers = [angle for angle in angles if isinstance(angle, Atom) and type(angle.value) in (int, float)]
    return [number for number in numbers if zero or number.value != 0]


def _forms(source: Source) -> Iterator[tuple[str, ListDatum]]:
    """Yield the forms of a program that begin with a symbol, each with that symbol."""
    for datum in walk(*read(source).forms):
        head = _head(datum)
        if head is not None and isinstance(datum, ListDatum):
            yield head, datum


def _key(candidate: _Candidate) -> Hashable:
    """Return the identity of a candidate: equal for those that make the same text."""
    changes = (
        (edit.span.start, edit.text) for edit in candidate.edits if not _is_same_number(edit.span.text, edit.text)
    )
    return frozenset(changes)


def _replaced(text: str, span: Span, new: str) -> str:
    """Return a text with a span replaced."""
    return text[: span.start] + new + text[span.end :]


def _removed(span: Span) -> Span:
    """Return the span of a form with the blanks before it, and with its line if nothing else is there."""
    text, start = span.source.text, span.start
    while start > 0 and text[start - 1] in " \t":
        start -= 1
    alone = start > 0 and text[start - 1] == "\n" and text[span.end : span.end + 1] in ("", "\n")
    return Span(span.source, start - 1 if alone else start, span.end)


def _digits(size: float) -> int:
    """Return the number of decimals that resolves a ten-thousandth of a size."""
    return max(2, math.ceil(4.0 - math.log10(max(size, 1e-12))))


def _decimals(text: str) -> int:
    """Return the number of decimals that a number is written with."""
    return len(text.partition(".")[2])


def _is_same_number(old: str, new: str) -> bool:
    """Return whether two texts are the same number."""
    try:
        return float(old) == float(new)
    except ValueError:
        return False
