"""Evaluation of declarations: spatial relations of objects in every frame; violations have amounts and moves.

The vocabulary is in ``interpreter.scene.declarations``; distances and contacts are computed by ``arrangement``.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence, Set
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import numpy as np

from scenelang.backends.geometry.arrangement import (
    SUNK,
    Arrangement,
    PlacedObject,
    Vector,
    paired,
    seen_share,
    share_of,
)
from scenelang.backends.geometry.lint import rounded
from scenelang.backends.geometry.measures import FREE_RADIUS, WalkingPlan, block_types, outlines, tilt, visible_share
from scenelang.backends.surfaces.convex import bodies_of
from scenelang.backends.surfaces.marks import Marks
from scenelang.backends.surfaces.solids import FloatArray
from scenelang.grammar.datum import Span
from scenelang.grammar.diagnostics import (
    Diagnostic,
    LimitError,
    Note,
    SceneError,
    is_one_letter_off,
    near_names,
    suggest,
)
from scenelang.interpreter.scene.bounds import entity_box
from scenelang.interpreter.scene.declarations import OVER_FRAMES, Declaration, basic_color
from scenelang.interpreter.scene.entity import Entity, Scene, descendants

_MAX_COMPARISONS = 200_000  # pairs of objects that are compared for the declarations of a scene
# Primitives of the frames that are kept while declarations are tested: the tables of one take some kilobytes.
_MAX_KEPT_PRIMITIVES = 10_000
_MAX_VIOLATIONS = 1_000  # of one scene that are reported
_FIRST_OBJECTS = 32  # nearest objects, which are sorted before all others: the rest is seldom needed
FACING_DEGREES = 30.0  # degrees by default between a front and the direction to the other object
_ANGLE_DEGREES = 1.0  # default tolerance in degrees
_LENGTH_TOLERANCE = 0.01  # default tolerance of a length, relative to it
_BLOCK_TOLERANCE = 0.01  # of positions of Minecraft blocks, whose edges are 1
_RADIUS_SHARE = 0.05  # default tolerance of a common radius, relative to it
_AROUND_SHARE, _AROUND_DEGREES = 0.1, 5.0  # default tolerance of an even angle: a share of it, at most so many degrees
_PATH_TOLERANCE = 0.03  # default tolerance of a path, relative to its extent, or to its radius
_MAX_RADIUS = 20.0  # of a circle, relative to the extent of the path: a larger one is a line
_LEAST_VISIBLE = 0.5  # default share of an object that must be seen
_IN_DEGREES = frozenset({"tilt", "turns"})  # relations whose amounts are angles
_OFF_AXIS_DEGREES = 5.0  # by which the axis of a turn may differ from the declared one
_POSITION_TOLERANCE = 0.01  # default tolerance of positions, relative to the extent of the objects
# refused for Minecraft blocks, which have boxes only; contacts of blocks are those of their boxes
_NOT_FOR_BLOCKS = frozenset(
    {"inside", "supported", "floating", "fastened", "has-color", "tilt", "outline", "visible-from", "reachable"}
)
# Relations of directions: the axis, the sign of its direction in which A is farther, and how messages say it.
SIDES = {
    "above": (1, 1.0, "above"), "below": (1, -1.0, "below"), "left-of": (0, -1.0, "to the left of"),
    "right-of": (0, 1.0, "to the right of"), "in-front-of": (2, 1.0, "in front of"), "behind": (2, -1.0, "behind"),
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class Violation:
    """Declaration that does not hold.

    Attributes
    ----------
    declaration, frame
        The declaration, and the frame in which it does not hold.
    message
        Reason in words.
    amount
        Distance from holding, 0 if it held: a length in scene units, an angle in degrees, or a number of objects.
    subject, other
        Words of the two objects, None without one.
    place, other_place
        Their source locations.
    move
        Translation of the subject that makes it hold, None if unknown.
    turn
        Rotation of the subject about the vertical axis in radians that makes it hold, None if unknown.
    rows, other_rows
        First and last primitive of the two objects in the flattened frame, None without one.
    """

    declaration: Declaration
    frame: int
    message: str
    amount: float
    subject: str | None = None
    other: str | None = None
    place: Span | None = None
    other_place: Span | None = None
    move: Vector | None = None
    turn: float | None = None
    rows: tuple[int, int] | None = None
    other_rows: tuple[int, int] | None = None


@dataclass(frozen=True, slots=True)
class _Failure:
    """Reason why a relation of some objects does not hold; fields as in ``Violation``."""

    message: str
    amount: float
    subject: PlacedObject | None = None
    other: PlacedObject | None = None
    move: Vector | None = None
    turn: float | None = None


@dataclass(slots=True)
class _Work:
    """Budget of comparisons, and the frames that were measured: relations over all frames read them again."""

    scene: Scene
    remaining: int = _MAX_COMPARISONS
    kept: dict[int, Arrangement] = field(default_factory=dict)
    kept_primitives: int = 0

    def arrangement(self, frame: int) -> Arrangement:
        """Return the arrangement of a frame, which is kept if there is room."""
        if frame in self.kept:
            return self.kept[frame]
        arrangement = Arrangement(self.scene, frame)
        self.kept_primitives += len(arrangement.bodies)
        if self.kept_primitives <= _MAX_KEPT_PRIMITIVES:
            self.kept[frame] = arrangement
        return arrangement

    def spend(self, count: int = 1) -> None:
        """Subtract comparisons; raises LimitError if none remain."""
        self.remaining -= count
        if self.remaining < 0:
            raise LimitError(
                "primitives",
                f"the declarations compare more than {_MAX_COMPARISONS:,} pairs of things",
                "state them inside of the entities that they are about, or check a part with `--root WORD`",
            )


@dataclass(frozen=True, slots=True, eq=False)
class _Context:
    """One frame, the instance that a declaration is about, and the declaration.

    ``first`` if one failure is enough.
    """

    arrangement: Arrangement
    within: int
    declaration: Declaration
    work: _Work
    first: bool = False

    def option(self, name: str, default: Any = None) -> Any:
        """Return an option of the declaration."""
        return self.declaration.options.get(name, default)

    def objects(self, name: str) -> list[PlacedObject]:
        """Return the objects with a name; raises SceneError for none, and for blocks that the relation refuses."""
        instances = self.arrangement.objects(name, self.within)
        if not instances:
            raise self.unknown(name)
        if self.declaration.relation in _NOT_FOR_BLOCKS and any(
            self.arrangement.has_blocks(placed) for placed in instances
        ):
            problem = f'`{self.declaration.relation}` has no meaning for "{name}", which is made of Minecraft blocks'
            raise SceneError("declaration-subject", problem, "state `count`, `size` or `above`, which use boxes")
        return instances

    def unknown(self, name: str) -> SceneError:
        """Return the error about a name without instances, with a hint."""
        ancestry, scene = self.arrangement.ancestry, self.arrangement.scene
        container = (ancestry.entity(self.within) if len(ancestry) else self.arrangement.root).word
        problem = f"no instance has the handle {name}" if name.startswith("<") else f'"{name}" does not occur'
        hint = self.arrangement.problem_of(name, self.within) or suggest(name, self.arrangement.words())
        if hint is None and self.within and self.arrangement.instances(name):
            outside = f'it occurs outside of "{container}"'
            hint = f"{outside}; state the declaration in an entity that contains it, or at top level"
        frame_text = f" (frame {self.arrangement.frame})" if scene.animated else ""
        return SceneError("declaration-subject", f'{problem} in "{container}"{frame_text}', hint)

    def is_misspelled(self, name: str, *, surely: bool) -> bool:
        """Return whether a word that does not occur is close to one that does.

        With ``surely``, it must be one letter off.
        """
        scene = self.arrangement.scene
        if scene.animated and any(entity.word == name for entity in descendants(*scene.frames)):
            return False
        near = near_names(name, self.arrangement.words())
        return any(is_one_letter_off(name, other) for other in near) if surely else bool(near)

    def touch(self, placed: PlacedObject) -> float:
        """Return the gap below which an object touches another, as declared or by default."""
        return float(self.option("within", self.arrangement.touch(placed)))


# --- checking --------------------------------------------------------------------------------------------------------


def violations(
    scene: Scene, extra: Sequence[Declaration] = (), only: Callable[[Declaration], bool] = lambda _: True
) -> list[Violation]:
    """Return the violations of a scene's declarations, and of ``extra`` ones about the whole scene.

    Each declaration that ``only`` accepts is tested in every frame, for every instance of the entity that declares it.

    Raises
    ------
    SceneError("declaration-subject")
        If a word does not occur, or a relation has no meaning for it.
    LimitError
        If too many pairs of objects are compared.
    """
    failed: list[Violation] = []
    for outcome in _tested(scene, extra, only):
        if isinstance(outcome, SceneError):
            raise outcome
        failed.append(outcome)
    return failed


def reasons(scene: Scene, declarations: Sequence[Declaration], *, is_lenient: bool = False) -> list[str | None]:
    """Return the first reason why each declaration about the whole scene fails, None if it holds.

    The program's own declarations are not tested. Declarations that cannot be tested, since a word does not occur,
    fail; if ``is_lenient``, they hold.
    """
    messages: dict[int, str] = {}
    asked = {id(declaration): number for number, declaration in enumerate(declarations)}
    spans = {id(declaration.span): number for number, declaration in enumerate(declarations)}
    for outcome in _tested(scene, declarations, lambda declaration: id(declaration) in asked, first=True):
        is_error = isinstance(outcome, SceneError)
        if is_error and is_lenient:
            continue
        number = spans[id(outcome.span)] if isinstance(outcome, SceneError) else asked[id(outcome.declaration)]
        messages.setdefault(number, outcome.message)
    return [messages.get(number) for number in range(len(declarations))]


def accepts(scene: Scene, declarations: Sequence[Declaration]) -> bool:
    """Return whether all declarations about the whole scene hold; those that are cheap to test are tested first."""
    ordered = sorted(declarations, key=lambda declaration: declaration.relation in _OF_CONTACT)
    asked = {id(declaration) for declaration in ordered}
    return next(_tested(scene, ordered, lambda each: id(each) in asked, first=True), None) is None


# Relations that compare surfaces, or need the ground, which follows from contacts.
_OF_CONTACT = frozenset({
    "clear-of", "distance", "elevation", "fastened", "floating", "inside", "on", "reachable", "supported", "touching",
    "visible-from",
})  # fmt: skip


def _tested(
    scene: Scene,
    extra: Sequence[Declaration] = (),
    only: Callable[[Declaration], bool] = lambda _: True,
    *,
    first: bool = False,
) -> Iterator[Violation | SceneError]:
    """Yield the violations of all declarations, and an error once for each that cannot be tested.

    With ``first``, only the first violation of each; it is not tested further.
    """
    declaring = {id(e) for e in descendants(*scene.frames) if e.declarations}
    about_scene = (*scene.declarations, *extra)
    if not declaring and not about_scene:
        return
    work, count = _Work(scene), 0
    finished: set[int] = set()
    once: dict[int, list[list[Violation]]] = {}  # violations in each frame of what must hold in one of them
    for number in range(len(scene.frames)):
        arrangement = work.arrangement(number)
        tested: dict[int, list[Violation]] = {}
        for within, declaration in _declared(arrangement, declaring, about_scene):
            if id(declaration) in finished or not only(declaration) or count >= _MAX_VIOLATIONS:
                continue
            if not _concerns(declaration, number, len(scene.frames)):
                continue
            context = _Context(arrangement, within, declaration, work, first)
            try:
                failures = _failures(context)
            except SceneError as error:
                error.span = error.span or declaration.span
                finished.add(id(declaration))
                yield error
                continue
            if declaration.options.get("sometime"):
                found = tested.setdefault(id(declaration), [])
                found += [_violation(context, number, failure) for failure in failures]
                continue
            if first and failures:
                finished.add(id(declaration))
                failures = failures[:1]
            count += len(failures)
            yield from (_violation(context, number, failure) for failure in failures)
        for key, failed in tested.items():
            once.setdefault(key, []).append(failed)
    for frames in once.values():
        if all(frames):
            yield from min(frames, key=lambda failed: sum(violation.amount for violation in failed))


def _concerns(declaration: Declaration, frame: int, count: int) -> bool:
    """Return whether a declaration is tested in a frame: those over all frames, and ``:first`` ones, in the first."""
    if declaration.relation in OVER_FRAMES or declaration.options.get("first"):
        return frame == 0
    return frame == count - 1 if declaration.options.get("last") else True


def _declared(
    arrangement: Arrangement, declaring: Set[int], about_scene: Sequence[Declaration]
) -> Iterator[tuple[int, Declaration]]:
    """Yield the declarations of a frame with their instances; equal ones of equal poses once."""
    for declaration in about_scene:
        yield 0, declaration
    yielded: set[tuple[Any, ...]] = set()
    for node, entity in enumerate(arrangement.ancestry.nodes):
        if id(entity) not in declaring:
            continue
        for instance in np.flatnonzero(arrangement.ancestry.node == node).tolist():
            pose = arrangement.ancestry.poses[instance]
            for declaration in entity.declarations:
                compared_pose = pose if declaration.relation == "supported" else pose[:, :3]
                key = (node, id(declaration), np.round(compared_pose, 9).tobytes())
                if key not in yielded:
                    yielded.add(key)
                    yield instance, declaration


def _failures(context: _Context) -> list[_Failure]:
    """Return the failures of a declaration in one frame, with `negated` taken into account."""
    declaration = context.declaration
    try:
        with np.errstate(all="ignore"):  # extents near the limits of floats overflow where they are multiplied
            failures = _RELATIONS[declaration.relation](context)
    except np.linalg.LinAlgError:
        raise SceneError("declaration-subject", "the scene is too large or too small to measure") from None
    if not declaration.options.get("negated"):
        return failures
    if failures:
        return []
    subject = context.arrangement.objects(declaration.things[0], context.within)
    return [_Failure("it holds, and should not", 1.0, subject[0] if subject else None)]


def _violation(context: _Context, frame: int, failure: _Failure) -> Violation:
    """Return a failure as a public violation, without references into the arrangement."""
    subject, other = failure.subject, failure.other
    return Violation(
        context.declaration,
        frame,
        failure.message,
        failure.amount,
        subject.entity.word if subject is not None else None,
        other.entity.word if other is not None else None,
        _place(subject),
        _place(other),
        failure.move,
        failure.turn,
        context.arrangement.rows(subject),
        context.arrangement.rows(other),
    )


def _place(placed: PlacedObject | None) -> Span | None:
    """Return the source location of an object: the call of its first primitive."""
    if placed is None:
        return None
    return next((span for entity in descendants(placed.entity) for span in entity.call_sites[:1]), None)


def check_declarations(scene: Scene, extra: Sequence[Declaration] = ()) -> list[Diagnostic]:
    """Return an error for each declaration that does not hold, about its worst violation."""
    groups: dict[tuple[Any, ...], list[Violation]] = {}
    errors: list[Diagnostic] = []
    distinct = {(str(declaration), declaration.options.get("message")): declaration for declaration in reversed(extra)}
    extra = list(distinct.values())[::-1]
    for outcome in _tested(scene, extra):
        if isinstance(outcome, SceneError):
            errors.append(outcome.diagnostic)
            continue
        span = outcome.declaration.span
        key = (str(outcome.declaration), None if span is None else (span.source.name, span.start))
        groups.setdefault(key, []).append(outcome)
    diagnostics = [*errors, *(_diagnostic(group, scene) for group in groups.values())]
    extra_spans = {id(declaration.span) for declaration in extra}
    own_messages = {d.message for d in diagnostics if id(d.span) not in extra_spans}
    # An extra declaration that the program states too is reported once.
    return [d for d in diagnostics if id(d.span) not in extra_spans or d.message not in own_messages]


def marked_violation(scene: Scene, extra: Sequence[Declaration]) -> tuple[Entity, Marks] | None:
    """Return the root of the frame in which the first declaration fails, and its marks; None if all hold.

    The marks show both objects, and the move that would fix it.
    """
    for outcome in _tested(scene, extra):
        if isinstance(outcome, Violation) and outcome.rows is not None:
            root = scene.frames[outcome.frame]
            subject_rows, other_rows = (
                frozenset(range(r[0], r[1] + 1)) if r else frozenset() for r in (outcome.rows, outcome.other_rows)
            )
            return root, Marks(
                subject_rows,
                other_rows,
                np.zeros((0, 3)),
                _move_lines(root, subject_rows, outcome.move),
                np.zeros((0, 3)),
            )
    return None


def _move_lines(root: Entity, rows: Set[int], move: Vector | None) -> FloatArray:
    """Return the line (1, 2, 3) along which the foot of an object moves; none if the move is unknown."""
    if move is None:
        return np.zeros((0, 2, 3))
    bodies = bodies_of(root)
    low, high = bodies.boxes
    is_subject = np.isin(bodies.row, list(rows))
    if not is_subject.any():
        return np.zeros((0, 2, 3))
    foot = (low[is_subject].min(axis=0) + high[is_subject].max(axis=0)) / 2.0
    foot[1] = low[is_subject, 1].min()
    return np.array([[foot, foot + np.array(move)]])


def _diagnostic(group: Sequence[Violation], scene: Scene) -> Diagnostic:
    """Return the error about the violations of one declaration, of which the worst of the first frame is described."""
    frames = sorted({violation.frame for violation in group})
    first = [violation for violation in group if violation.frame == frames[0]]
    worst = max(first, key=lambda violation: violation.amount)
    declaration = worst.declaration
    message = f"{declaration} does not hold: {worst.message}"
    if len(first) > 1:
        message += f" ({len(first)} times)"
    if scene.animated and declaration.options.get("sometime"):
        message += f" (nearest in frame {frames[0]})"
    elif scene.animated and declaration.relation not in OVER_FRAMES:
        message += f" (frame {frames[0]}" + (f" and {len(frames) - 1} more)" if len(frames) > 1 else ")")
    if declaration.options.get("message"):
        message = f"{declaration.options['message']}: {message}"
    notes = []
    if worst.place is not None:
        notes.append(Note(f'"{worst.subject}" is made here', worst.place))
    if worst.other_place is not None and worst.other_place != worst.place:
        notes.append(Note(f'"{worst.other}" is made here', worst.other_place))
    return Diagnostic("declaration", message, declaration.span, _hint(worst), tuple(notes))


def _hint(worst: Violation) -> str | None:
    """Return the translation that would fix a violation as a hint, None if it is unknown."""
    if worst.move is None or not any(abs(x) > 1e-9 for x in worst.move):
        return None
    return f'`(translate [{rounded(worst.move)}])` of "{worst.subject}" would fix it'


# --- relations of two objects ---------------------------------------------------------------------------------------


_Test = Callable[[_Context, PlacedObject, PlacedObject], "_Failure | None"]


def _pairwise(test: _Test, *, every_object: bool = False) -> Callable[[_Context], list[_Failure]]:
    """Return a relation that tests each subject against some object or, with ``every_object``, against all."""

    def relation(context: _Context) -> list[_Failure]:
        """Return the failing subjects; with `any`, the one nearest to holding if all fail."""
        declaration = context.declaration
        subjects, objects = (context.objects(name) for name in declaration.things[:2])
        # If the nearest object is at least the least distance away, all are.
        apart = every_object or (test is _distance and declaration.number is None and "max" not in declaration.options)
        universal = apart or bool(declaration.options.get("all"))
        boxes = _boxes(context, objects)
        of_surfaces = "axis" not in declaration.options  # centers may be near along an axis and far across it
        reach = float(declaration.options.get("min", 0.0)) if apart and of_surfaces else np.inf
        near = None
        are_solid = not any(context.arrangement.has_blocks(placed) for placed in (*subjects, *objects))
        if len(subjects) > 1 and are_solid and of_surfaces and (apart or test in _CONTACTS):
            reaches = [max(context.touch(a), reach) if apart else context.touch(a) for a in subjects]
            near = context.arrangement.prepare(subjects, objects, reaches, _MAX_COMPARISONS)
        if context.first and near is not None and not universal and declaration.options.get("any"):
            if any(
                _against(context, test, a, near[a.instance], universal=False) is None
                for a in subjects
                if a.instance in near
            ):
                return []
            subjects = subjects[:1]  # none holds; the first gives the reason
        failures = []
        for a in subjects:
            around = near.get(a.instance, []) if near is not None else []
            if around and not universal and _against(context, test, a, around, universal=False) is None:
                failure = None
            elif near is not None and apart:
                failure = _against(context, test, a, context.arrangement.nearest(a, around), universal=True)
            else:
                failure = _against(context, test, a, _nearest(context, a, objects, boxes, reach), universal=universal)
            if failure is None and declaration.options.get("any"):
                return []
            if failure is not None:
                failures.append(failure)
                if context.first and not declaration.options.get("any"):
                    break
        if failures and declaration.options.get("any"):
            return [min(failures, key=lambda failure: failure.amount)]
        return failures

    return relation


def _against(
    context: _Context, test: _Test, a: PlacedObject, objects: Iterable[PlacedObject], *, universal: bool
) -> _Failure | None:
    """Return why a subject fails: against the object nearest to holding or, with ``universal``, the worst of all."""
    worst: _Failure | None = None
    best: _Failure | None = None
    is_alone = True
    for b in objects:
        if b.instance == a.instance:
            continue
        is_alone = False
        context.work.spend()
        if best is not None and not universal and test in _NEARNESS and _gap(context.arrangement, a, b) >= best.amount:
            continue  # farther away than the best object is from holding
        failure = _tested_pair(context, test, a, b)
        if failure is None and not universal:
            return None
        if failure is not None:
            worst = failure if worst is None or failure.amount > worst.amount else worst
            best = failure if best is None or failure.amount < best.amount else best
    if is_alone and not universal:
        return _Failure(f'there is no other "{context.declaration.things[1]}"', 1.0, a)
    return worst if universal else best


def _tested_pair(context: _Context, test: _Test, a: PlacedObject, b: PlacedObject) -> _Failure | None:
    """Return why a relation of two objects does not hold; contacts of Minecraft blocks are those of their boxes."""
    of_blocks = _BLOCK_TESTS.get(test)
    if of_blocks is not None and (context.arrangement.has_blocks(a) or context.arrangement.has_blocks(b)):
        return of_blocks(context, a, b)
    return test(context, a, b)


def _block_pairs(context: _Context, a: PlacedObject, b: PlacedObject) -> tuple[FloatArray, FloatArray]:
    """Return the signed gaps along the axes (N, M, 3) of the boxes of two objects, and how far each of the first is
    above each of the second (N, M)."""
    (low, high, _), (under, over, _) = (_parts(context.arrangement, placed) for placed in (a, b))
    context.work.spend(len(low) * len(under) // 1000)
    gaps = np.maximum(low[:, None] - over[None], under[None] - high[:, None])
    return gaps, low[:, None, 1] - over[None, :, 1]


def _blocks_on(context: _Context, a: PlacedObject, b: PlacedObject) -> _Failure | None:
    """Return why no block of ``a`` is directly on one of ``b``."""
    gaps, above = _block_pairs(context, a, b)
    is_over = (gaps[..., [0, 2]] < -_BLOCK_TOLERANCE).all(axis=-1)
    distances = np.abs(above[is_over])
    if len(distances) and distances.min() <= _BLOCK_TOLERANCE:
        return None
    amount = float(distances.min()) if len(distances) else float(np.abs(gaps).min() + 1.0)
    return _Failure(f'no block of "{a.entity.word}" is on one of "{b.entity.word}"', amount, a, b)


def _blocks_apart(context: _Context, a: PlacedObject, b: PlacedObject) -> float:
    """Return the distance of the blocks of two objects, negative where some are in one place."""
    gaps, _ = _block_pairs(context, a, b)
    apart = np.linalg.norm(np.maximum(gaps, 0.0), axis=-1)
    deepest = gaps.max(axis=-1)
    return float(deepest.min()) if deepest.min() < -_BLOCK_TOLERANCE else float(apart.min())


def _blocks_touching(context: _Context, a: PlacedObject, b: PlacedObject) -> _Failure | None:
    """Return why the blocks of two objects do not touch."""
    apart = _blocks_apart(context, a, b)
    if abs(apart) <= _BLOCK_TOLERANCE:
        return None
    how = f"are {apart:.3g} apart" if apart > 0.0 else "are in one place"
    return _Failure(f"blocks of {_two_words(a, b)} {how}", abs(apart), a, b)


def _blocks_clear_of(context: _Context, a: PlacedObject, b: PlacedObject) -> _Failure | None:
    """Return why the blocks of two objects are in one place, or closer than `min`."""
    apart, least = _blocks_apart(context, a, b), float(context.option("min", 0.0))
    if apart >= least - _BLOCK_TOLERANCE:
        return None
    return _Failure(f"blocks of {_two_words(a, b)} are {apart:.3g} apart", least - apart, a, b)


def _blocks_distance(context: _Context, a: PlacedObject, b: PlacedObject) -> _Failure | None:
    """Return why the distance of the blocks of two objects is not as declared."""
    if context.option("axis") is not None:
        return _center_distance(context, a, b)
    apart = max(_blocks_apart(context, a, b), 0.0)
    off = _off(context, apart)
    return None if off == 0.0 else _Failure(f"{_two_words(a, b)} are {apart:.3g} apart", abs(off), a, b)


def _gap(arrangement: Arrangement, a: PlacedObject, b: PlacedObject) -> float:
    """Return the distance of the boxes of two objects, 0 if they touch."""
    (low, high), (under, over) = arrangement.box(a), arrangement.box(b)
    return float(np.linalg.norm(np.maximum(np.maximum(low - over, under - high), 0.0)))


def _boxes(context: _Context, objects: Sequence[PlacedObject]) -> tuple[FloatArray, FloatArray]:
    """Return the low and the high corners (N, 3) of the boxes of objects."""
    low, high = zip(*(context.arrangement.box(placed) for placed in objects))
    return np.array(low), np.array(high)


def _nearest(
    context: _Context,
    a: PlacedObject,
    objects: Sequence[PlacedObject],
    boxes: tuple[FloatArray, FloatArray],
    reach: float,
) -> Iterator[PlacedObject]:
    """Yield the objects whose boxes are within ``reach``, the nearest first.

    The nearest ``_FIRST_OBJECTS`` are selected in linear time before all are sorted.
    """
    low, high = context.arrangement.box(a)
    apart = np.maximum(np.maximum(boxes[0] - high, low - boxes[1]), 0.0)
    square = (apart * apart).sum(axis=1)
    first = np.zeros(0, np.int64)
    if len(square) > 2 * _FIRST_OBJECTS:  # usually one of the nearest decides
        first = np.flatnonzero(square <= np.partition(square, _FIRST_OBJECTS)[_FIRST_OBJECTS])
        first = first[np.argsort(square[first], kind="stable")]
        yield from (objects[i] for i in first[square[first] <= reach * reach * (1.0 + 1e-9)].tolist())
    order = np.argsort(square, kind="stable")[len(first) :]
    yield from (objects[i] for i in order[square[order] <= reach * reach * (1.0 + 1e-9)].tolist())


def _on(context: _Context, a: PlacedObject, b: PlacedObject) -> _Failure | None:
    """Return why ``a`` is not on ``b``: a gap, an overlap, or a contact that does not support it."""
    arrangement, reach = context.arrangement, context.touch(a)
    low, high = arrangement.box(a)
    if arrangement.contains(a, b):
        return _Failure(
            f'"{b.entity.word}" is a part of "{a.entity.word}"', max(float((high - low).max()), reach), a, b
        )
    separation = arrangement.separation(a, b)
    if separation is None:
        return _Failure(f'"{a.entity.word}" has no solid parts', 1.0, a, b)
    deepest = max(reach, SUNK * float(high[1] - low[1]))
    if -deepest <= separation.distance <= reach and arrangement.is_blocked(a, b, reach):
        return None
    move = _onto(arrangement, a, b)
    amount = float(np.linalg.norm(move)) if move is not None else abs(separation.distance)
    if separation.distance < -deepest:
        message = f"{_two_words(a, b)} overlap by {-separation.distance:.3g}"
    elif separation.distance > reach and move is not None and abs(move[0]) + abs(move[2]) < reach:
        message = f'"{a.entity.word}" floats {separation.distance:.3g} above "{b.entity.word}"'
        if move[1] > 0.0:
            message = f'"{a.entity.word}" is {separation.distance:.3g} below "{b.entity.word}"'
    elif separation.distance > reach:
        message = f'"{a.entity.word}" is {separation.distance:.3g} from "{b.entity.word}"'
    else:
        message = f'"{a.entity.word}" touches "{b.entity.word}", which does not carry it'
    return _Failure(message, max(amount, reach), a, b, move)


def _two_words(a: PlacedObject, b: PlacedObject) -> str:
    """Return the quoted words of two objects."""
    return f'"{a.entity.word}" and "{b.entity.word}"'


def _onto(arrangement: Arrangement, a: PlacedObject, b: PlacedObject) -> Vector | None:
    """Return the translation that puts ``a`` onto ``b``: sideways over it if necessary, then down to contact."""
    (low, high), (under, over) = arrangement.box(a), arrangement.box(b)
    center = (low + high) / 2.0
    sideways = np.clip(center, under, over) - center
    sideways[1] = 0.0
    if sideways.any():  # as much of the object as fits, not only its center
        half = (high - low) / 2.0
        inset = np.minimum(half, (over - under) / 2.0)
        sideways = np.clip(center, under + inset, over - inset) - center
        sideways[1] = 0.0
    up = float(over[1] - low[1])
    shifted = _dropped(arrangement, a, b, sideways, max(up, 0.0))
    if shifted is None:
        return None
    return float(sideways[0]), shifted, float(sideways[2])


def _dropped(
    arrangement: Arrangement, a: PlacedObject, b: PlacedObject, sideways: FloatArray, up: float
) -> float | None:
    """Return the height by which ``a``, moved sideways, comes to rest on ``b``."""
    tolerance = 1e-9 * arrangement.bodies.size
    fall = arrangement.fall(a, [b], up + tolerance, sideways)
    return None if fall is None else up + tolerance - fall


def _inside(context: _Context, a: PlacedObject, b: PlacedObject) -> _Failure | None:
    """Return why too little of the hull of ``a`` is inside that of ``b``, in space or seen along an axis."""
    arrangement, least, axis = context.arrangement, float(context.option("share", 1.0)), context.option("axis")
    inner, outer = arrangement.hull(a, b), arrangement.hull(b, a)
    (low, high), (under, over) = arrangement.box(a), arrangement.box(b)
    kept = [k for k in range(3) if axis is None or k != "xyz".index(axis)]
    share = share_of(inner, outer) if axis is None else seen_share(inner, outer, kept)
    if share is None:  # flat or empty: by boxes
        extent = np.maximum(high - low, 1e-12)
        shared = np.clip(np.minimum(high, over) - np.maximum(low, under), 0.0, None) / extent
        share = float(np.prod(shared[kept]))
    if share >= least - 1e-3:
        return None
    out = np.maximum(under - low, 0.0) - np.maximum(high - over, 0.0)
    out[[k for k in range(3) if k not in kept]] = 0.0
    fits = bool((high - low <= over - under)[kept].all())
    move = _vector(out) if fits and out.any() else None
    amount = max(float(np.linalg.norm(out)), (least - share) * float((high - low).max()), arrangement.touch(a))
    seen = f", seen along {axis}" if axis is not None else ""
    share = abs(round(share, 2))  # rounding may leave -0
    return _Failure(f'{share:.0%} of "{a.entity.word}" is inside "{b.entity.word}"{seen}', amount, a, b, move)


def _touching(context: _Context, a: PlacedObject, b: PlacedObject) -> _Failure | None:
    """Return why two objects do not touch: a gap or an overlap."""
    reach = context.touch(a)
    separation = context.arrangement.separation(a, b)
    if separation is None or abs(separation.distance) <= reach:
        return None
    move = _scaled(context.arrangement.away(separation), -separation.distance)
    if separation.distance > 0.0:
        return _Failure(f"{_two_words(a, b)} are {separation.distance:.3g} apart", separation.distance, a, b, move)
    return _Failure(f"{_two_words(a, b)} overlap by {-separation.distance:.3g}", -separation.distance, a, b, move)


def _clear_of(context: _Context, a: PlacedObject, b: PlacedObject) -> _Failure | None:
    """Return why two objects are closer than `min`, or overlap."""
    least = float(context.option("min", 0.0))
    if _gap(context.arrangement, a, b) >= max(least, 1e-12):
        return None
    separation = context.arrangement.separation(a, b)
    tolerance = context.arrangement.touch(a) if least == 0.0 else 1e-9 * context.arrangement.bodies.size
    if separation is None or separation.distance >= least - tolerance:
        return None
    lacking = least - separation.distance
    move = _apart(context.arrangement, a, b, least, _scaled(context.arrangement.away(separation), lacking))
    if separation.distance < 0.0:
        return _Failure(f"{_two_words(a, b)} overlap by {-separation.distance:.3g}", lacking, a, b, move)
    distance = separation.distance + 0.0  # -0 becomes 0
    return _Failure(f"{_two_words(a, b)} are only {distance:.3g} apart", lacking, a, b, move)


def _apart(arrangement: Arrangement, a: PlacedObject, b: PlacedObject, least: float, move: Vector) -> Vector:
    """Return ``move`` if it separates ``a`` from ``b`` by ``least``, else the shortest that separates their boxes."""
    tolerance = 1e-6 * arrangement.bodies.size
    separation = arrangement.separation(a, b, move)
    if separation is None or separation.distance >= least - tolerance:
        return move
    (low, high), (under, over) = arrangement.box(a), arrangement.box(b)
    lengths = np.concatenate([over - low + least, under - high - least])
    best = int(np.argmin(np.abs(lengths)))
    return _vector(np.eye(3)[best % 3] * lengths[best])


def _distance(context: _Context, a: PlacedObject, b: PlacedObject) -> _Failure | None:
    """Return why the distance of two objects is not as declared."""
    if context.option("axis") is not None:
        return _center_distance(context, a, b)
    distance = context.arrangement.gap(a, b)
    off = 0.0 if distance is None else _off(context, distance)
    if off == 0.0:
        return None
    separation = context.arrangement.separation(a, b)
    move = None if separation is None else _scaled(context.arrangement.away(separation), -off)
    return _Failure(f"{_two_words(a, b)} are {distance:.3g} apart", abs(off), a, b, move)


def _center_distance(context: _Context, a: PlacedObject, b: PlacedObject) -> _Failure | None:
    """Return why the distance of the centers of two objects, measured along axes, is not as declared."""
    along = str(context.option("axis"))
    apart = context.arrangement.center(a) - context.arrangement.center(b)
    apart[[k for k, axis in enumerate("xyz") if axis not in along]] = 0.0
    distance = float(np.linalg.norm(apart))
    off = _off(context, distance)
    if off == 0.0:
        return None
    move = _vector(-off / distance * apart) if distance > 0.0 else None
    message = f"the centers of {_two_words(a, b)} are {distance:.3g} apart along {along}"
    return _Failure(message, abs(off), a, b, move)


def _off(context: _Context, value: float) -> float:
    """Return how far a value is above (positive) or below the declared one; 0 if it holds."""
    expected = context.declaration.number
    if expected is not None:
        least = _ANGLE_DEGREES if context.declaration.relation in _IN_DEGREES else 0.0
        within = float(context.option("within", max(_LENGTH_TOLERANCE * expected, least)))
        return 0.0 if abs(value - expected) <= within + 1e-9 else value - expected
    tolerance = 1e-9 * max(1.0, context.arrangement.bodies.size)
    least, most = context.option("min"), context.option("max")
    if least is not None and value < least - tolerance:
        return float(value - least)
    if most is not None and value > most + tolerance:
        return float(value - most)
    return 0.0


def _angle(context: _Context, a: PlacedObject, b: PlacedObject) -> _Failure | None:
    """Return why the angle between the axes of two objects is not as declared."""
    axis = context.option("axis", "y")
    cosine = float(context.arrangement.axis(a, axis) @ context.arrangement.axis(b, axis))
    degrees = math.degrees(math.acos(min(1.0, max(-1.0, cosine))))
    expected = context.declaration.number or 0.0
    if abs(degrees - expected) <= float(context.option("within", _ANGLE_DEGREES)):
        return None
    message = f"the angle between the {axis} axes of {_two_words(a, b)} is {degrees:.3g} degrees"
    return _Failure(message, abs(degrees - expected), a, b)


def _facing(context: _Context, a: PlacedObject, b: PlacedObject) -> _Failure | None:
    """Return why ``a`` does not face ``b``: the direction of its z axis, seen from above."""
    arrangement = context.arrangement
    towards = arrangement.center(b) - arrangement.center(a)
    front, aim = arrangement.axis(a, "z")[[0, 2]], towards[[0, 2]]
    if float(np.linalg.norm(aim)) <= arrangement.touch(a):
        return None  # one is over the other
    if float(np.linalg.norm(front)) < 1e-6:
        return _Failure(f'"{a.entity.word}" faces up or down', 90.0, a, b)
    turn = math.atan2(front[1] * aim[0] - front[0] * aim[1], float(front @ aim))
    degrees = abs(math.degrees(turn))
    if degrees <= float(context.option("within", FACING_DEGREES)):
        return None
    message = f'"{a.entity.word}" faces {degrees:.3g} degrees away from "{b.entity.word}"'
    return _Failure(message, degrees, a, b, turn=turn)


def _direction(name: str) -> _Test:
    """Return the test of a relation such as "above": the center of ``a`` is beyond the box of ``b`` along an axis."""
    axis, sign, words = SIDES[name]

    def test(context: _Context, a: PlacedObject, b: PlacedObject) -> _Failure | None:
        """Return why ``a`` is not on the declared side of ``b``."""
        (low, high), (under, over) = context.arrangement.box(a), context.arrangement.box(b)
        center = float(low[axis] + high[axis]) / 2.0 * sign
        edge = float(over[axis]) if sign > 0.0 else -float(under[axis])
        near = float(low[axis]) if sign > 0.0 else -float(high[axis])
        middle = (low + high) / 2.0
        beside = [side for side in (0, 2) if not under[side] <= middle[side] <= over[side]] if axis == 1 else []
        if beside and ((low <= (under + over) / 2.0) & ((under + over) / 2.0 <= high))[[0, 2]].all():
            beside = []  # a table counts as below a cup near its edge
        lacking = edge - center
        if lacking < 0.0 and not beside:
            return None
        move = [0.0, 0.0, 0.0]
        if lacking >= 0.0:
            move[axis] = sign * (edge - near)
        for side in beside:
            move[side] = float(np.clip(middle[side], under[side], over[side]) - middle[side])
        message = f'"{a.entity.word}" is not {words} "{b.entity.word}"'
        return _Failure(message, max(float(np.linalg.norm(move)), context.arrangement.touch(a)), a, b, _vector(move))

    return test


def _between(context: _Context) -> list[_Failure]:
    """Return the subjects that are between no two of the objects."""
    arrangement = context.arrangement
    subjects, firsts, seconds = (context.objects(name) for name in context.declaration.things)
    centers = {end.instance: arrangement.center(end) for end in (*firsts, *seconds)}
    failures = []
    for a in subjects:
        pairs = [(b, c) for b in firsts for c in seconds if len({a.instance, b.instance, c.instance}) == 3]
        context.work.spend(len(pairs))
        ends = np.array([[centers[end.instance] for end in pair] for pair in pairs]).reshape(-1, 2, 3)
        away = _beside_segments(arrangement.box(a), ends[:, 0], ends[:, 1])
        if (away == 0.0).any():
            if context.option("any"):
                return []
            continue
        nearest = int(away.argmin()) if pairs else None
        amount, b = (1.0, None) if nearest is None else (float(away[nearest]), pairs[nearest][0])
        first, second = context.declaration.things[1:]
        failures.append(_Failure(f'"{a.entity.word}" is not between "{first}" and "{second}"', amount, a, b))
    return failures[:1] if context.option("any") else failures


def _beside_segments(box: tuple[FloatArray, FloatArray], starts: FloatArray, ends: FloatArray) -> FloatArray:
    """Return the horizontal distances (N,) of a box from the segments between points (N, 3).

    A distance is 0 if the segment passes through the box, seen from above.
    """
    low, high = box
    along = ends - starts
    first, last = np.zeros(len(along)), np.ones(len(along))
    for axis in (0, 2):
        level = np.abs(along[:, axis]) < 1e-12
        step = np.where(level, 1.0, along[:, axis])
        crossings = np.stack([low[axis] - starts[:, axis], high[axis] - starts[:, axis]]) / step
        is_beside = level & ~((low[axis] <= starts[:, axis]) & (starts[:, axis] <= high[axis]))
        first = np.where(is_beside, 2.0, np.where(level, first, np.maximum(first, crossings.min(axis=0))))
        last = np.where(level, last, np.minimum(last, crossings.max(axis=0)))
    center = (low + high) / 2.0
    lengths = np.maximum(np.einsum("ij,ij->i", along, along), 1e-300)
    shares = np.clip(np.einsum("ij,ij->i", center - starts, along) / lengths, 0.0, 1.0)
    gaps = np.linalg.norm((center - starts - shares[:, None] * along)[:, [0, 2]], axis=1)
    return np.where(first <= last, 0.0, np.maximum(gaps, 1e-9))


# --- relations of one object, or of all together --------------------------------------------------------------------


def _size(context: _Context) -> list[_Failure]:
    """Return the subjects whose extent along an axis is not as declared."""
    axis = context.option("axis")

    def extents() -> Iterator[float]:
        """Yield the extent of each subject, charging for it."""
        for a in context.objects(context.declaration.things[0]):
            context.work.spend()
            yield _extent(context.arrangement, a, axis)

    return _measured(context, extents(), f"measures {{:.3g}} along {' or '.join(axis)}")


def _extent(arrangement: Arrangement, placed: PlacedObject, axes: str) -> float:
    """Return the extent of an object along an axis of the scene, the largest one along several."""
    low, high = arrangement.box(placed)
    return max(float((high - low)["xyz".index(axis)]) for axis in axes)


def _measured(context: _Context, amounts: Iterable[float], message_format: str) -> list[_Failure]:
    """Return the subjects whose amounts are not as declared; ``message_format`` is a format of the message."""
    failures = []
    for a, amount in zip(context.objects(context.declaration.things[0]), amounts):
        off = _off(context, amount)
        if off == 0.0 and context.option("any"):
            return []
        if off != 0.0:
            failures.append(_Failure(f'"{a.entity.word}" {message_format.format(amount)}', abs(off), a))
    return failures[:1] if context.option("any") else failures


def _count(context: _Context) -> list[_Failure]:
    """Return the failure of the number of instances; raises SceneError for a word that is probably misspelled."""
    name = context.declaration.things[0]
    instances = context.arrangement.instances(name, context.within)
    count = len(instances)
    exact, least, most = context.declaration.number, context.option("min"), context.option("max")
    low = exact if exact is not None else (0.0 if least is None else least)
    high = exact if exact is not None else (math.inf if most is None else most)
    holds = low <= count <= high
    if count == 0 and context.is_misspelled(name, surely=holds):
        raise context.unknown(name)
    if holds:
        return []
    subject = context.arrangement.object_at(instances[0]) if instances else None
    message = f"there {'is' if count == 1 else 'are'} {count}"
    return [_Failure(message, max(low - count, count - high), subject)]


def _proportion(context: _Context, a: PlacedObject, b: PlacedObject) -> _Failure | None:
    """Return why the extent of ``a`` relative to that of ``b`` is not as declared."""
    axis = context.option("axis")
    first, second = (_extent(context.arrangement, placed, axis) for placed in (a, b))
    ratio = first / max(second, 1e-300)
    off = _off(context, ratio)
    if off == 0.0:
        return None
    message = f'"{a.entity.word}" measures {ratio:.3g} times "{b.entity.word}" along {" or ".join(axis)}'
    return _Failure(message, abs(off), a, b)


def _aspect(context: _Context) -> list[_Failure]:
    """Return the subjects whose extents along two axes are not in proportion."""
    axis, to = context.option("axis"), context.option("to")
    objects = context.objects(context.declaration.things[0])
    context.work.spend(len(objects))
    ratios = (_extent(context.arrangement, a, axis) / max(_extent(context.arrangement, a, to), 1e-300) for a in objects)
    return _measured(context, ratios, f"measures {{:.3g}} times as much along {axis} as along {to}")


def _elevation(context: _Context) -> list[_Failure]:
    """Return the subjects whose lowest points are not as high above the ground as declared."""
    arrangement = context.arrangement
    objects = context.objects(context.declaration.things[0])
    context.work.spend(len(objects))
    has_solids = len(arrangement.bodies) > 0
    ground = arrangement.ground if has_solids else 0.0
    heights = [float(arrangement.box(placed)[0][1]) - ground for placed in objects]
    reach = max(arrangement.touch(placed) for placed in objects) if has_solids else _BLOCK_TOLERANCE
    return _measured(context, (0.0 if abs(height) <= reach else height for height in heights), "is {:.3g} high")


def _common_center(context: _Context, name: str) -> FloatArray:
    """Return the mean (3,) of the centers of all objects of a name: of a ring without a center, the ring's."""
    return np.asarray(np.mean([context.arrangement.center(a) for a in context.objects(name)], axis=0), np.float64)


def _encircles(context: _Context) -> list[_Failure]:
    """Return the subjects that are not at the declared distance from an axis, or not at the distance of the others."""
    arrangement, (first, second) = context.arrangement, context.declaration.things
    objects, middle = context.objects(first), _common_center(context, second)
    context.work.spend(len(objects))
    kept = [k for k in range(3) if k != "xyz".index(context.option("axis", "y"))]
    radii = np.array([np.linalg.norm((arrangement.center(placed) - middle)[kept]) for placed in objects])
    if context.declaration.number is None and not {"min", "max"} & {*context.declaration.options}:
        usual = float(np.median(radii))
        within = float(context.option("within", _RADIUS_SHARE * usual))
        off = np.where(np.abs(radii - usual) <= within + 1e-9, 0.0, radii - usual)
        return [
            _Failure(f'"{a.entity.word}" is {radius:.3g} from the axis, others {usual:.3g}', abs(float(lacking)), a)
            for a, radius, lacking in zip(objects, radii.tolist(), off.tolist())
            if lacking != 0.0
        ]
    return _measured(context, radii.tolist(), "is {:.3g} from the axis")


def _rising(context: _Context) -> list[_Failure]:
    """Return the subjects that are not higher than the one before along a direction, or around an object."""
    objects, centers, _ = _centers(context)
    around, along = context.option("around"), str(context.option("along"))
    if around is not None:
        azimuths = _azimuths(context, objects)
        places, way = (azimuths - azimuths[int(np.argmin(centers[:, 1]))]) % 360.0, f'around "{around}"'
    else:
        places, way = centers[:, "xyz".index(along[-1])] * (-1.0 if along[0] == "-" else 1.0), f"along {along}"
    order = np.argsort(places, kind="stable").tolist()
    return [
        _Failure(f'"{objects[b].entity.word}" is not higher than the one before {way}',
                 float(centers[a, 1] - centers[b, 1]), objects[b], objects[a])
        for a, b in pairwise(order)
        if centers[b, 1] <= centers[a, 1] + context.arrangement.touch(objects[b])
    ]  # fmt: skip


def _tilt(context: _Context) -> list[_Failure]:
    """Return the subjects that are not tilted as declared."""
    objects = context.objects(context.declaration.things[0])
    context.work.spend(sum(placed.last - placed.first for placed in objects))
    angles = (tilt(context.arrangement, placed) for placed in objects)
    return _measured(context, angles, "is tilted by {:.3g} degrees")


def _outline(context: _Context) -> list[_Failure]:
    """Return the subjects whose outline along an axis is another one."""
    expected, axis = str(context.declaration.term), context.option("axis", "y")
    failures = []
    for placed in context.objects(context.declaration.things[0]):
        context.work.spend(placed.last - placed.first)
        if expected not in outlines(context.arrangement, placed, axis):
            failures.append(_Failure(f'"{placed.entity.word}" is not {expected}, seen along {axis}', 1.0, placed))
        elif context.option("any"):
            return []
    return failures[:1] if context.option("any") else failures


def _made_of(context: _Context) -> list[_Failure]:
    """Return the subjects most of whose blocks are of another type."""
    expected, failures = str(context.declaration.term), list[_Failure]()
    for placed in context.objects(context.declaration.things[0]):
        context.work.spend()
        volumes = block_types(placed.entity)
        total = sum(volumes.values())
        if total <= 0.0:
            raise SceneError("declaration-subject", f'"{placed.entity.word}" has no Minecraft blocks')
        named = sum(volume for name, volume in volumes.items() if f"_{expected}_" in f"_{name}_")
        if 2.0 * named <= total:
            most = max(volumes, key=lambda name: volumes[name])
            failures.append(_Failure(f'"{placed.entity.word}" is of {most}', 1.0 - named / total, placed))
        elif context.option("any"):
            return []
    return failures[:1] if context.option("any") else failures


def _visible_from(context: _Context, a: PlacedObject, b: PlacedObject) -> _Failure | None:
    """Return why too little of ``a`` is seen from ``b``."""
    context.work.spend(len(context.arrangement.bodies))
    least = float(context.option("share", _LEAST_VISIBLE))
    share = visible_share(context.arrangement, a, b)
    if share >= least:
        return None
    return _Failure(f'{share:.0%} of "{a.entity.word}" is seen from "{b.entity.word}"', least - share, a, b)


def _reachable(context: _Context) -> list[_Failure]:
    """Return the subjects that a person cannot walk to from an object, or with `all` from each."""
    context.work.spend(len(context.arrangement.bodies))
    subjects, starts = (context.objects(name) for name in context.declaration.things)
    if not len(context.arrangement.bodies):
        raise SceneError("declaration-subject", "nothing solid is in the scene, so that there is no way to test")
    floor = WalkingPlan(context.arrangement, float(context.option("within", FREE_RADIUS)))
    ways = [(b, floor.reached(floor.around(b))) for b in starts]
    failures = []
    for a in subjects:
        context.work.spend(len(starts))
        ends = floor.around(a)
        blocked = [b for b, way in ways if b.instance != a.instance and not (way & ends).any()]
        if not blocked or (len(blocked) < len(ways) and not context.option("all")):
            if context.option("any"):
                return []
            continue
        message = f'no free way on the ground leads from "{blocked[0].entity.word}" to "{a.entity.word}"'
        failures.append(_Failure(message, 1.0, a, blocked[0]))
    return failures[:1] if context.option("any") else failures


def _has_color(context: _Context) -> list[_Failure]:
    """Return the subjects more of whose surface has another color, measured by the boxes of their bodies."""
    bodies = context.arrangement.bodies
    low, high = bodies.boxes
    x, y, z = (high - low).T
    area = x * y + y * z + z * x
    failures = []
    for a in context.objects(context.declaration.things[0]):
        context.work.spend()
        shares: dict[str, float] = {}
        for body in range(a.first, a.last):
            name = basic_color(bodies.colors[body].tolist())
            shares[name] = shares.get(name, 0.0) + float(area[body])
        total = sum(shares.values())
        if total <= 0.0:
            raise SceneError("declaration-subject", f'"{a.entity.word}" has no surface that can be seen')
        share = shares.get(str(context.declaration.term), 0.0) / total
        most = max(shares, key=lambda name: shares[name])
        # Of several colors the most frequent: a red can with a white band and silver ends is half red by its boxes.
        is_most = share >= shares[most] / total
        if is_most and context.option("any"):
            return []
        if not is_most:
            failures.append(_Failure(f'"{a.entity.word}" is {most}', 1.0 - share, a))
    return failures[:1] if context.option("any") else failures


def _frames(context: _Context) -> Iterator[tuple[Arrangement, list[PlacedObject]]]:
    """Yield every frame with its subjects, which must be the same in number and order."""
    name = context.declaration.things[0]
    count = len(context.objects(name))
    for number in range(len(context.arrangement.scene.frames)):
        arrangement = context.work.arrangement(number)
        objects = arrangement.objects(name, context.within)
        context.work.spend(len(objects))
        if len(objects) != count:
            problem = f'there are {count} "{name}" in the first frame and {len(objects)} in frame {number}'
            raise SceneError(
                "declaration-subject", problem, f"state `{context.declaration.relation}` of things that stay"
            )
        yield arrangement, objects


def _moves(context: _Context) -> list[_Failure]:
    """Return the subjects whose center does not move as declared."""
    places = np.array(
        [[arrangement.center(a) for a in objects] for arrangement, objects in _frames(context)]
    )  # (F, N, 3)
    extent = np.ptp(places, axis=0)
    along = context.option("along")
    if along is not None and along[0] in "+-":
        way = (places[-1] - places[0])[:, "xyz".index(along[1])] * (1.0 if along[0] == "+" else -1.0)
        return _measured(context, way.tolist(), f"moves by {{:.3g}} in the direction {along}")
    amounts = np.linalg.norm(extent, axis=1) if along is None else extent[:, "xyz".index(along)]
    return _measured(context, amounts.tolist(), "moves by {:.3g}" + (f" along {along}" if along else ""))


def _turns(context: _Context) -> list[_Failure]:
    """Return the subjects that do not turn as declared."""
    frames = [[_linear(arrangement, a) for a in objects] for arrangement, objects in _frames(context)]
    axis = context.option("axis")
    if axis is not None:
        return _turns_about(context, list(zip(*frames)), axis)
    amounts = [max(_turn(first, later) for later in poses) for first, *poses in zip(frames[0], *frames)]
    return _measured(context, amounts, "turns by {:.3g} degrees")


def _turns_about(context: _Context, objects: Sequence[Sequence[FloatArray]], axis: str) -> list[_Failure]:
    """Return the subjects that do not turn about an axis of the scene as declared, or turn about another one.

    What does not turn about an axis, such as `(turns "rod" 0 :axis "y")`, may turn about another one.
    """
    direction = np.eye(3)["xyz".index(axis[-1])] * (-1.0 if axis[0] == "-" else 1.0)
    subjects = context.objects(context.declaration.things[0])
    amounts = []
    for placed, poses in zip(subjects, objects):
        steps = np.array([_rotation_vector(first, later) for first, later in pairwise(poses)]).reshape(-1, 3)
        along = steps @ direction
        beside = np.linalg.norm(steps - np.outer(along, direction), axis=1)
        allowed = math.tan(math.radians(_OFF_AXIS_DEGREES)) * np.abs(along).sum() + _ANGLE_DEGREES
        if context.declaration.number != 0.0 and beside.sum() > allowed:
            message = f'"{placed.entity.word}" turns about another axis than {axis[-1]}'
            return [_Failure(message, float(beside.sum()), placed)]
        swept = np.cumsum(along) if len(along) else np.zeros(1)
        amounts.append(float(swept[-1]) if axis[0] in "+-" else float(np.abs(swept).max()))
    return _measured(context, amounts, f"turns by {{:.3g}} degrees about {axis}")


def _rotation_vector(first: FloatArray, later: FloatArray) -> FloatArray:
    """Return the greatest turn (3,) in degrees, as axis times angle, between the bodies (N, 3, 3) of two frames."""
    if first.shape != later.shape or not len(first):
        return np.zeros(3)
    vectors = [_axis_times_angle(_rotation(b) @ _rotation(a).T) for a, b in zip(first, later)]
    return max(vectors, key=lambda vector: float(np.linalg.norm(vector)))


def _axis_times_angle(rotation: FloatArray) -> FloatArray:
    """Return the axis of a rotation (3, 3) times its angle in degrees, from 0 to 180."""
    angle = math.degrees(math.acos(min(1.0, max(-1.0, (float(np.trace(rotation)) - 1.0) / 2.0))))
    skew = np.array([rotation[2, 1] - rotation[1, 2], rotation[0, 2] - rotation[2, 0], rotation[1, 0] - rotation[0, 1]])
    if float(np.linalg.norm(skew)) > 1e-9:
        return np.asarray(angle * skew / np.linalg.norm(skew), np.float64)
    if angle < 90.0:
        return np.zeros(3)
    # Half a turn: R + I = 2 n n', whose longest column is along the axis.
    columns = rotation + np.eye(3)
    column = columns[:, int(np.argmax(np.diag(columns)))]
    return np.asarray(angle * column / np.linalg.norm(column), np.float64)


def _path(context: _Context) -> list[_Failure]:
    """Return the subjects whose centers do not move on a path of the declared shape."""
    shape, about = str(context.declaration.term), context.option("about")
    frames = [[arrangement.center(a) for a in objects] for arrangement, objects in _frames(context)]
    axis_center = None if about is None else _common_center(context, about)
    failures = []
    for placed, places in zip(context.objects(context.declaration.things[0]), np.array(frames).transpose(1, 0, 2)):
        off, tolerance = _off_path(places, shape, axis_center)
        if float(np.ptp(places, axis=0).max()) <= context.arrangement.touch(placed):
            failures.append(_Failure(f'"{placed.entity.word}" does not move', 1.0, placed))
        elif off <= float(context.option("within", tolerance)):
            if context.option("any"):
                return []
        else:
            written = f"a {shape}" + (f' around "{about}"' if about is not None else "")
            written = "a closed path" if shape == "closed" else written
            failures.append(_Failure(f'"{placed.entity.word}" is {off:.3g} beside {written}', off, placed))
    return failures[:1] if context.option("any") else failures


def _off_path(places: FloatArray, shape: str, axis_center: FloatArray | None) -> tuple[float, float]:
    """Return how far places (F, 3) are beside a path of a shape at most, and the default tolerance."""
    extent = float(np.linalg.norm(np.ptp(places, axis=0)))
    if shape == "closed":  # the last frame of a loop is often the one before the first
        steps = np.linalg.norm(np.diff(places, axis=0), axis=1)
        return float(np.linalg.norm(places[-1] - places[0])), float(1.5 * steps.max(initial=0.0))
    middle = places.mean(axis=0)
    away = places - middle
    axes = np.linalg.svd(away, full_matrices=False)[2]
    if shape == "line":
        direction = axes[0]
        beside = np.linalg.norm(away - np.outer(away @ direction, direction), axis=1)
        return float(beside.max()), _PATH_TOLERANCE * extent
    # A circle: least squares of x^2 + y^2 = 2 a x + 2 b y + c in the plane of the places (Kasa, 1976).
    flat = away @ axes[:2].T
    a, b, c = np.linalg.lstsq(np.c_[2.0 * flat, np.ones(len(flat))], (flat * flat).sum(axis=1), rcond=None)[0].tolist()
    radius = math.sqrt(max(c + a * a + b * b, 0.0))
    if radius > _MAX_RADIUS * extent:
        return extent, _PATH_TOLERANCE * extent
    center = middle + np.array([a, b]) @ axes[:2]
    normal = axes[2] if len(axes) > 2 else np.zeros(3)
    beside = np.hypot(np.linalg.norm(flat - [a, b], axis=1) - radius, away @ normal)
    off = float(beside.max())
    if axis_center is not None:
        apart = center - axis_center
        off = max(off, float(np.linalg.norm(apart - (apart @ normal) * normal)))
    return off, _PATH_TOLERANCE * max(radius, 1e-300)


def _linear(arrangement: Arrangement, a: PlacedObject) -> FloatArray:
    """Return the linear parts (N, 3, 3) of the poses of an object's bodies."""
    return np.asarray(arrangement.bodies.worlds[a.first : a.last, :, :3], np.float64)


def _turn(first: FloatArray, later: FloatArray) -> float:
    """Return the largest rotation in degrees between the same bodies of two frames; 0 if they differ in number."""
    if first.shape != later.shape or not len(first):
        return 0.0
    turned = [_rotation(b) @ _rotation(a).T for a, b in zip(first, later)]
    return max(math.degrees(math.acos(min(1.0, max(-1.0, (float(np.trace(r)) - 1.0) / 2.0)))) for r in turned)


def _rotation(linear: FloatArray) -> FloatArray:
    """Return the rotation nearest to a linear map, the orthogonal factor of its polar decomposition."""
    u, _, v = np.linalg.svd(linear)
    return np.asarray(u @ v, np.float64)


def _centers(context: _Context) -> tuple[list[PlacedObject], FloatArray, float]:
    """Return the subjects, their centers (N, 3), and the tolerance of positions."""
    objects = context.objects(context.declaration.things[0])
    context.work.spend(len(objects))
    centers = np.array([context.arrangement.center(placed) for placed in objects])
    sizes = [float(np.subtract(*context.arrangement.box(placed)[::-1]).max()) for placed in objects]
    spread = float(np.ptp(centers, axis=0).max()) if len(objects) > 1 else 0.0
    return (
        objects,
        centers,
        float(context.option("within", _POSITION_TOLERANCE * max(float(np.mean(sizes)), 0.1 * spread))),
    )


def _aligned(context: _Context) -> list[_Failure]:
    """Return the subjects that are not on a common line, or not on an axis or plane."""
    objects, centers, within = _centers(context)
    along = context.option("along")
    middle = np.median(centers, axis=0) if along is not None else centers.mean(axis=0)
    if along is not None:
        free = ["xyz".index(axis) for axis in along]
        away = centers - middle
        away[:, free] = 0.0
    else:
        direction = _principal(centers - middle)
        away = (centers - middle) - np.outer((centers - middle) @ direction, direction)
    beside = np.linalg.norm(away, axis=1)
    line = "a line" if along is None else (f"a line along {along}" if len(along) == 1 else f"an {along} plane")
    return [
        _Failure(f'"{objects[i].entity.word}" is {beside[i]:.3g} beside {line}', float(beside[i]), objects[i], None,
                 _vector(-away[i]))
        for i in np.flatnonzero(beside > within).tolist()
    ]  # fmt: skip


def _principal(points: FloatArray) -> FloatArray:
    """Return the direction (3,) of the largest spread of points."""
    if len(points) < 2 or not np.ptp(points, axis=0).any():
        return np.array([1.0, 0.0, 0.0])
    return np.asarray(np.linalg.svd(points, full_matrices=False)[2][0], np.float64)


def _evenly_spaced(context: _Context) -> list[_Failure]:
    """Return the subjects whose distance to the previous one differs from the median."""
    if context.option("around") is not None:
        return _evenly_around(context)
    objects, centers, within = _centers(context)
    if len(objects) < 3:
        return []
    along = context.option("along")
    direction = np.eye(3)["xyz".index(along[0])] if along else _principal(centers - centers.mean(axis=0))
    positions = centers @ direction
    order = np.argsort(positions, kind="stable")
    if along:  # an avenue has two trees at each position
        same = min(within, _POSITION_TOLERANCE * max(float(np.ptp(positions)), 1e-12))
        order = order[np.concatenate([[True], np.diff(positions[order]) > same])]
        if len(order) < 2:
            return [_Failure(f'all "{objects[0].entity.word}" are at one position along {along}', 1.0, objects[0])]
    gaps = np.diff(positions[order])
    usual = float(np.median(gaps))
    failures = []
    for k in np.flatnonzero(np.abs(gaps - usual) > within).tolist():
        placed = objects[int(order[k + 1])]
        message = f'the distance to the next "{placed.entity.word}" is {gaps[k]:.3g}, that of the others {usual:.3g}'
        failures.append(_Failure(message, abs(float(gaps[k]) - usual), placed, objects[int(order[k])],
                              _vector(direction * (usual - gaps[k]))))  # fmt: skip
    return failures


def _azimuths(context: _Context, objects: Sequence[PlacedObject]) -> FloatArray:
    """Return the angles (N,) in degrees at which objects are around the one of ``:around``, seen along an axis.

    Raises SceneError for one at its center, which has none.
    """
    arrangement, about = context.arrangement, context.option("around")
    middle = _common_center(context, about)
    kept = {"x": [1, 2], "y": [0, 2], "z": [0, 1]}[context.option("axis", "y")]
    away = np.array([arrangement.center(placed) - middle for placed in objects])[:, kept]
    for placed, length in zip(objects, np.linalg.norm(away, axis=1).tolist()):
        if length <= arrangement.touch(placed):
            raise SceneError("declaration-subject", f'"{placed.entity.word}" is at the center of "{about}"')
    across = -away[:, 1] if context.option("axis", "y") == "y" else away[:, 1]  # counterclockwise seen from above
    return np.asarray(np.degrees(np.arctan2(across, away[:, 0])) % 360.0, np.float64)


def _evenly_around(context: _Context) -> list[_Failure]:
    """Return the subjects whose angle to the one before, seen from the object that they are around, is not the mean."""
    objects = context.objects(context.declaration.things[0])
    context.work.spend(len(objects))
    if len(objects) < 2:
        return []
    azimuths = _azimuths(context, objects)
    order = np.argsort(azimuths, kind="stable")
    gaps = np.diff(azimuths[order], append=azimuths[order[0]] + 360.0)
    mean = 360.0 / len(objects)
    within = float(context.option("within", min(_AROUND_SHARE * mean, _AROUND_DEGREES)))
    return [
        _Failure(
            f'the angle to the next "{objects[int(order[k])].entity.word}" around "{context.option("around")}" is'
            f" {gaps[k]:.3g} degrees, where {mean:.3g} is even",
            abs(float(gaps[k]) - mean),
            objects[int(order[k])],
            objects[int(order[(k + 1) % len(order)])],
        )
        for k in np.flatnonzero(np.abs(gaps - mean) > within).tolist()
    ]


def _rows(context: _Context) -> list[_Failure]:
    """Return the failure of the number of positions along an axis, or of the number of objects at each."""
    objects, centers, within = _centers(context)
    along, each = str(context.option("along")), context.option("each")
    positions = centers[:, "xyz".index(along[-1])] * (-1.0 if along[0] == "-" else 1.0)
    order = np.argsort(positions, kind="stable")
    ends = np.flatnonzero(np.diff(positions[order]) > max(within, 1e-12)) + 1
    rows = np.split(order, ends)
    expected = int(context.declaration.number or 0)
    if len(rows) != expected:
        message = f'"{objects[0].entity.word}" has {len(rows)} positions along {along}'
        return [_Failure(message, abs(len(rows) - expected), objects[0])]
    counts = [len(row) if each is None else each for row in rows] if not isinstance(each, tuple) else list(each)
    if len(counts) != expected:
        raise SceneError("value", f"`:each` has {len(counts)} numbers for {expected} positions")
    return [
        _Failure(f'there are {len(row)} "{objects[row[0]].entity.word}" at {positions[row[0]]:.3g} along {along}',
                 abs(len(row) - count), objects[row[0]])
        for row, count in zip(rows, counts) if len(row) != count
    ]  # fmt: skip


def _order(context: _Context) -> list[_Failure]:
    """Return the first objects of each name that come before one of the name before it."""
    names = context.declaration.things
    groups = [context.objects(name) for name in names]
    context.work.spend(sum(len(group) for group in groups))
    if context.option("around") is not None:
        angles = [_azimuths(context, group) for group in groups]
        start = float(angles[0].min())
        places = [(angle - start) % 360.0 for angle in angles]
    else:
        axis = "xyz".index(context.option("along"))
        places = [np.array([context.arrangement.center(placed)[axis] for placed in group]) for group in groups]
    failures = []
    for number in range(1, len(groups)):
        last, first = int(np.argmax(places[number - 1])), int(np.argmin(places[number]))
        lacking = float(places[number - 1][last] - places[number][first])
        b, a = groups[number - 1][last], groups[number][first]
        if lacking >= -context.arrangement.touch(a):
            message = f'"{a.entity.word}" does not come after "{b.entity.word}"'
            failures.append(_Failure(message, max(lacking, context.arrangement.touch(a)), a, b))
    return failures


def _symmetric(context: _Context) -> list[_Failure]:
    """Test mirror symmetry of the boxes and words of all primitives."""
    objects, _, within = _centers(context)
    axis = "xyz".index(context.option("across", "x"))
    arrangement, about = context.arrangement, context.option("about")
    middle = (_common_center(context, about) if about is not None else _middle(arrangement, objects))[axis]
    parts = [_parts(arrangement, placed) for placed in objects]
    owner = np.repeat(np.arange(len(objects)), [len(part_words) for _, _, part_words in parts])
    context.work.spend(len(owner))
    low, high = (np.concatenate([part[k] for part in parts]) for k in (0, 1))
    center, size = (low + high) / 2.0, high - low
    words = np.unique([word for _, _, part_words in parts for word in part_words], return_inverse=True)[1]
    mirrored = center.copy()
    mirrored[:, axis] = 2.0 * middle - mirrored[:, axis]
    beside = np.zeros(len(owner))
    alone = np.setdiff1d(np.arange(len(owner)), paired(center, mirrored, size, words, within))
    context.work.spend(len(alone) * len(owner) // 1000)
    for k in alone.tolist():
        away = np.abs(np.hstack([center - mirrored[k], size - size[k]])).max(axis=1)
        beside[k] = np.where(words == words[k], away, np.inf).min()
    failures = []
    for number, placed in enumerate(objects):
        distances = beside[owner == number]
        if len(distances) and distances.max() > within:
            failures.append(_Failure(f'"{placed.entity.word}" has no mirror image', _finite(distances.max()), placed))
    return failures


def _parts(arrangement: Arrangement, placed: PlacedObject) -> tuple[FloatArray, FloatArray, list[str]]:
    """Return the boxes (N, 3), (N, 3) and the words of an object's primitives; blocks have boxes without bodies."""
    if placed.last > placed.first:
        (low, high), entity = arrangement.bodies.boxes, arrangement.bodies.entity[placed.first : placed.last]
        words = [arrangement.bodies.entities[e].word for e in entity.tolist()]
        return low[placed.first : placed.last], high[placed.first : placed.last], words
    first, last = arrangement.rows(placed) or (0, -1)
    instances = arrangement.ancestry.primitives[first : last + 1].tolist()
    # "delete-blocks" has a size and no geometry.
    leaves = [leaf for leaf in map(arrangement.object_at, instances) if entity_box(leaf.entity) is not None]
    lows, highs = (np.array([arrangement.box(leaf)[k] for leaf in leaves]).reshape(-1, 3) for k in (0, 1))
    return lows, highs, [leaf.entity.word for leaf in leaves]


def _finite(value: float) -> float:
    """Return a distance, 1 if it is infinite."""
    return float(value) if np.isfinite(value) else 1.0


def _middle(arrangement: Arrangement, objects: Sequence[PlacedObject]) -> FloatArray:
    """Return the center (3,) of the common box of objects."""
    lows, highs = zip(*(arrangement.box(placed) for placed in objects))
    return np.asarray((np.min(lows, axis=0) + np.max(highs, axis=0)) / 2.0, np.float64)


def _supported(context: _Context) -> list[_Failure]:
    """Return the subjects that no contacts connect to the ground, by the facts; balance is another check."""
    arrangement, failures = context.arrangement, list[_Failure]()
    facts = arrangement.facts
    for a in context.objects(context.declaration.things[0]):
        context.work.spend()
        bodies = np.unique(facts.bodies.body[a.first : a.last]).tolist()
        floating = [b for b in bodies if facts.verdicts[b].kind == "floating"]
        if not floating:
            if context.option("any"):
                return []
            continue
        failures.append(_unsupported(arrangement, a, floating[0]))
        if context.first and not context.option("any"):
            break
    return failures[:1] if context.option("any") else failures


def _floats(context: _Context) -> list[_Failure]:
    """Return the subjects that contacts connect to the ground, before any attribute counts."""
    facts = context.arrangement.facts
    grounded = facts.statics.grounded(np.zeros(len(facts.bodies), bool))
    failures = []
    for a in context.objects(context.declaration.things[0]):
        context.work.spend()
        if not grounded[facts.bodies.body[a.first : a.last]].any():
            if context.option("any"):
                return []
            continue
        failures.append(_Failure(f'"{a.entity.word}" touches what stands on the ground', 1.0, a))
    return failures[:1] if context.option("any") else failures


def _fastened(context: _Context, a: PlacedObject, b: PlacedObject) -> _Failure | None:
    """Return why an object is not fastened to another: no body of both is in one rigid group."""
    facts = context.arrangement.facts
    first, second = (set(facts.fastened[facts.bodies.body[x.first : x.last]].tolist()) for x in (a, b))
    if first & second:
        return None
    return _Failure(f"{_two_words(a, b)} are not fastened to each other", 1.0, a, b)


def _unsupported(arrangement: Arrangement, a: PlacedObject, body: int) -> _Failure:
    """Return the failure of an object with a floating body, with the fall that ends on something."""
    facts = arrangement.facts
    low, _ = arrangement.box(a)
    others = [
        arrangement.object_at(int(arrangement.ancestry.primitives[row]))
        for row in arrangement.bodies.row[facts.clusters[facts.bodies.body] != facts.clusters[body]].tolist()
    ]
    fall = arrangement.fall(a, others)
    down = float(low[1]) - arrangement.ground
    drop = down if fall is None else min(fall, down)
    message = f'"{a.entity.word}" floats {drop:.3g} above what is below it'
    return _Failure(message, max(drop, arrangement.touch(a)), a, None, (0.0, -drop, 0.0))


def _vector(values: Iterable[float]) -> Vector:
    """Return three numbers as a vector without negative zeros."""
    x, y, z = (float(value) + 0.0 for value in values)
    return x, y, z


def _scaled(direction: Sequence[float], length: float) -> Vector:
    """Return a direction times a length."""
    return _vector(length * x for x in direction)


_CONTACTS = (_on, _touching, _clear_of)  # relations of objects that are near each other
# Contacts of Minecraft blocks, which are boxes on a grid.
_BLOCK_TESTS: dict[_Test, _Test] = {
    _on: _blocks_on,
    _touching: _blocks_touching,
    _clear_of: _blocks_clear_of,
    _distance: _blocks_distance,
}
_NEARNESS = (_on, _touching)  # relations that fail by at least the distance of the boxes
_RELATIONS: dict[str, Callable[[_Context], list[_Failure]]] = {
    "on": _pairwise(_on),
    "inside": _pairwise(_inside),
    "touching": _pairwise(_touching),
    "clear-of": _pairwise(_clear_of, every_object=True),
    "distance": _pairwise(_distance),
    "angle": _pairwise(_angle),
    "facing": _pairwise(_facing),
    **{name: _pairwise(_direction(name)) for name in SIDES},
    "between": _between,
    "aligned": _aligned,
    "evenly-spaced": _evenly_spaced,
    "symmetric": _symmetric,
    "supported": _supported,
    "floating": _floats,
    "fastened": _pairwise(_fastened),
    "order": _order,
    "rows": _rows,
    "proportion": _pairwise(_proportion),
    "aspect": _aspect,
    "elevation": _elevation,
    "encircles": _encircles,
    "rising": _rising,
    "tilt": _tilt,
    "outline": _outline,
    "made-of": _made_of,
    "visible-from": _pairwise(_visible_from),
    "reachable": _reachable,
    "path": _path,
    "size": _size,
    "count": _count,
    "has-color": _has_color,
    "moves": _moves,
    "turns": _turns,
}
