"""Whether declarations hold: relations of things in every frame, as violations with amounts and moves.

The vocabulary is in ``interpreter.scene.declarations``; distances and contacts are computed by ``arrangement``.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence, Set
from dataclasses import dataclass
from typing import Any

import numpy as np

from scenelang.backends.geometry.arrangement import SUNK, Arrangement, Thing, Vector, paired, share_of
from scenelang.backends.geometry.lint import rounded
from scenelang.backends.surfaces.convex import bodies_of
from scenelang.backends.surfaces.distance import IntArray
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
from scenelang.interpreter.scene.declarations import OVER_FRAMES, Declaration, basic_color
from scenelang.interpreter.scene.entity import Entity, Scene, descendants

_MAX_TESTS = 200_000  # pairs of things that are compared for the declarations of a scene
_MAX_VIOLATIONS = 1_000
_FIRST = 32  # things that are compared before all are put in the order of their distance
_FACING = 30.0  # degrees
_ANGLE = 1.0  # degrees
_NUMBER = 0.01  # tolerance of a length, relative to it
_PLACE = 0.01  # tolerance of places, relative to the extent of the things
_NO_MEANING = frozenset({"on", "inside", "touching", "clear-of", "distance", "supported", "has-color"})  # for blocks
_SIDES = {
    "above": (1, 1.0, "above"), "below": (1, -1.0, "below"), "left-of": (0, -1.0, "to the left of"),
    "right-of": (0, 1.0, "to the right of"), "in-front-of": (2, 1.0, "in front of"), "behind": (2, -1.0, "behind"),
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class Violation:
    """A declaration that does not hold.

    Attributes
    ----------
    declaration, frame
        What is stated, and the frame in which it does not hold.
    message
        Why, in words.
    amount
        How far it is from holding: 0 would hold. A length in scene units, an angle in degrees, or a number of things.
    subject, other
        Words of the two things; None where there is none.
    place, other_place
        Where the program makes them.
    move
        Translation of the subject that makes it hold, None if it is not known.
    turn
        Angle in radians about the vertical axis that makes it hold if the subject is turned by it, None if unknown.
    rows, other_rows
        First and last primitive of the two things in the flattened frame; None where there is none.
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
    """Why a relation of some things does not hold."""

    message: str
    amount: float
    subject: Thing | None = None
    other: Thing | None = None
    move: Vector | None = None
    turn: float | None = None


@dataclass(slots=True)
class _Work:
    """Number of comparisons that remain."""

    left: int = _MAX_TESTS

    def spend(self, count: int = 1) -> None:
        self.left -= count
        if self.left < 0:
            raise LimitError(
                "primitives",
                f"the declarations compare more than {_MAX_TESTS:,} pairs of things",
                "state them inside of the entities that they are about, or check a part with `--root WORD`",
            )


@dataclass(frozen=True, slots=True, eq=False)
class _Context:
    """One frame, the instance that a declaration is about, and the declaration; ``first`` if one failure is enough."""

    here: Arrangement
    within: int
    stated: Declaration
    work: _Work
    first: bool = False

    def option(self, name: str, default: Any = None) -> Any:
        return self.stated.options.get(name, default)

    def things(self, name: str) -> list[Thing]:
        """Return the things with a name; raises SceneError if there are none."""
        found = self.here.things(name, self.within)
        if not found:
            raise self.unknown(name)
        if self.stated.relation in _NO_MEANING and any(self.here.has_blocks(thing) for thing in found):
            problem = f'`{self.stated.relation}` has no meaning for "{name}", which is made of Minecraft blocks'
            raise SceneError("declaration-subject", problem, "state `count`, `size` or `above`, which use boxes")
        return found

    def unknown(self, name: str) -> SceneError:
        ancestry, scene = self.here.ancestry, self.here.scene
        around = (ancestry.entity(self.within) if len(ancestry) else self.here.root).word
        what = f"no instance has the handle {name}" if name.startswith("<") else f'"{name}" does not occur'
        hint = self.here.problem_of(name, self.within) or suggest(name, self.here.words())
        if hint is None and self.within and self.here.instances(name):
            hint = (
                f'it occurs outside of "{around}"; state the declaration in an entity that contains it, or at top level'
            )
        where = f" (frame {self.here.frame})" if scene.animated else ""
        return SceneError("declaration-subject", f'{what} in "{around}"{where}', hint)

    def is_misspelled(self, name: str, surely: bool) -> bool:
        """Return whether a word that does not occur in the frame is like one that does, with ``surely`` but for one
        letter."""
        scene = self.here.scene
        if scene.animated and any(entity.word == name for entity in descendants(*scene.frames)):
            return False
        near = near_names(name, self.here.words())
        return any(is_one_letter_off(name, other) for other in near) if surely else bool(near)

    def touch(self, thing: Thing) -> float:
        return float(self.option("within", self.here.touch(thing)))


# --- checking --------------------------------------------------------------------------------------------------------


def violations(
    scene: Scene, extra: Sequence[Declaration] = (), only: Callable[[Declaration], bool] = lambda _: True
) -> list[Violation]:
    """Return the declarations of a scene that do not hold, and those of ``extra`` about the whole scene.

    Each that ``only`` accepts is tested in every frame, for every instance of the entity that states it.

    Raises
    ------
    SceneError("declaration-subject")
        If a word does not occur, or a relation has no meaning for it.
    LimitError
        If too many pairs of things are compared.
    """
    found: list[Violation] = []
    for each in _tested(scene, extra, only):
        if isinstance(each, SceneError):
            raise each
        found.append(each)
    return found


def reasons(scene: Scene, declarations: Sequence[Declaration]) -> list[str | None]:
    """Return for each declaration about the whole scene why it does not hold first, None if it holds.

    The program's own declarations are not tested. What cannot be tested does not hold.
    """
    found: dict[int, str] = {}
    asked = {id(each): number for number, each in enumerate(declarations)}
    spans = {id(each.span): number for number, each in enumerate(declarations)}
    for each in _tested(scene, declarations, lambda declaration: id(declaration) in asked, first=True):
        number = spans[id(each.span)] if isinstance(each, SceneError) else asked[id(each.declaration)]
        found.setdefault(number, each.message)
    return [found.get(number) for number in range(len(declarations))]


def _tested(
    scene: Scene,
    extra: Sequence[Declaration] = (),
    only: Callable[[Declaration], bool] = lambda _: True,
    first: bool = False,
) -> Iterator[Violation | SceneError]:
    """Yield the violations of all declarations, and an error once for each that cannot be tested.

    With ``first`` only the first violation of each, after which it is not tested further.
    """
    stating = {id(e) for e in descendants(*scene.frames) if e.declarations}
    about_scene = (*scene.declarations, *extra)
    if not stating and not about_scene:
        return
    work, count = _Work(), 0
    wrong: set[int] = set()
    for number in range(len(scene.frames)):
        here = Arrangement(scene, number)
        for within, declaration in _stated(here, stating, about_scene):
            if id(declaration) in wrong or not only(declaration) or count >= _MAX_VIOLATIONS:
                continue
            if number and declaration.relation in OVER_FRAMES:
                continue
            context = _Context(here, within, declaration, work, first)
            try:
                failures = _failures(context)
            except SceneError as error:
                error.span = error.span or declaration.span
                wrong.add(id(declaration))
                yield error
                continue
            if first and failures:
                wrong.add(id(declaration))
                failures = failures[:1]
            count += len(failures)
            yield from (_violation(context, number, failure) for failure in failures)


def _stated(
    here: Arrangement, stating: Set[int], about_scene: Sequence[Declaration]
) -> Iterator[tuple[int, Declaration]]:
    """Yield the declarations of a frame with the instances that they are about; equal ones in equal poses once."""
    for declaration in about_scene:
        yield 0, declaration
    seen: set[tuple[Any, ...]] = set()
    for node, entity in enumerate(here.ancestry.nodes):
        if id(entity) not in stating:
            continue
        for instance in np.flatnonzero(here.ancestry.node == node).tolist():
            pose = here.ancestry.poses[instance]
            for declaration in entity.declarations:
                place = pose if declaration.relation == "supported" else pose[:, :3]
                key = (node, id(declaration), np.round(place, 9).tobytes())
                if key not in seen:
                    seen.add(key)
                    yield instance, declaration


def _failures(context: _Context) -> list[_Failure]:
    stated = context.stated
    failures = _RELATIONS[stated.relation](context)
    if not stated.options.get("negated"):
        return failures
    if failures:
        return []
    subject = context.here.things(stated.things[0], context.within)
    return [_Failure("it holds, and should not", 1.0, subject[0] if subject else None)]


def _violation(context: _Context, frame: int, failure: _Failure) -> Violation:
    subject, other = failure.subject, failure.other
    return Violation(
        context.stated,
        frame,
        failure.message,
        failure.amount,
        subject.entity.word if subject is not None else None,
        other.entity.word if other is not None else None,
        _place(subject),
        _place(other),
        failure.move,
        failure.turn,
        context.here.rows(subject),
        context.here.rows(other),
    )


def _place(thing: Thing | None) -> Span | None:
    """Return where the program makes a thing: the call of its first primitive."""
    if thing is None:
        return None
    return next((span for entity in descendants(thing.entity) for span in entity.call_sites[:1]), None)


def check_declarations(scene: Scene, extra: Sequence[Declaration] = ()) -> list[Diagnostic]:
    """Return an error for each declaration that does not hold, about the worst case of each."""
    groups: dict[tuple[Any, ...], list[Violation]] = {}
    errors: list[Diagnostic] = []
    extra = list({(str(each), each.options.get("message")): each for each in reversed(extra)}.values())[::-1]
    for each in _tested(scene, extra):
        if isinstance(each, SceneError):
            errors.append(each.diagnostic)
            continue
        span = each.declaration.span
        key = (str(each.declaration), None if span is None else (span.source.name, span.start))
        groups.setdefault(key, []).append(each)
    found = [*errors, *(_diagnostic(group, scene) for group in groups.values())]
    asked = {id(each.span) for each in extra}
    stated = {d.message for d in found if id(d.span) not in asked}
    return [d for d in found if id(d.span) not in asked or d.message not in stated]  # what the program states too


def marked_violation(scene: Scene, extra: Sequence[Declaration]) -> tuple[Entity, Marks] | None:
    """Return the root of the frame in which the first declaration fails, with marks on both objects and on the move
    that would fix it; None if all hold."""
    for each in _tested(scene, extra):
        if isinstance(each, Violation) and each.rows is not None:
            root = scene.frames[each.frame]
            own, other = (frozenset(range(r[0], r[1] + 1)) if r else frozenset() for r in (each.rows, each.other_rows))
            return root, Marks(own, other, np.zeros((0, 3)), _move_lines(root, own, each.move), np.zeros((0, 3)))
    return None


def _move_lines(root: Entity, rows: Set[int], move: Vector | None) -> FloatArray:
    """Return the line (1, 2, 3) along which the foot of a thing moves, none if it is not known."""
    if move is None:
        return np.zeros((0, 2, 3))
    bodies = bodies_of(root)
    low, high = bodies.boxes
    own = np.isin(bodies.row, list(rows))
    if not own.any():
        return np.zeros((0, 2, 3))
    foot = (low[own].min(axis=0) + high[own].max(axis=0)) / 2.0
    foot[1] = low[own, 1].min()
    return np.array([[foot, foot + np.array(move)]])


def _diagnostic(group: Sequence[Violation], scene: Scene) -> Diagnostic:
    frames = sorted({each.frame for each in group})
    first = [each for each in group if each.frame == frames[0]]
    worst = max(first, key=lambda each: each.amount)
    stated = worst.declaration
    message = f"{stated} does not hold: {worst.message}"
    if len(first) > 1:
        message += f" ({len(first)} times)"
    if scene.animated and stated.relation not in OVER_FRAMES:
        message += f" (frame {frames[0]}" + (f" and {len(frames) - 1} more)" if len(frames) > 1 else ")")
    if stated.options.get("message"):
        message = f"{stated.options['message']}: {message}"
    notes = []
    if worst.place is not None:
        notes.append(Note(f'"{worst.subject}" is made here', worst.place))
    if worst.other_place is not None and worst.other_place != worst.place:
        notes.append(Note(f'"{worst.other}" is made here', worst.other_place))
    return Diagnostic("declaration", message, stated.span, _hint(worst), tuple(notes))


def _hint(worst: Violation) -> str | None:
    if worst.move is None or not any(abs(x) > 1e-9 for x in worst.move):
        return None
    return f'`(translate [{rounded(worst.move)}])` of "{worst.subject}" would fix it'


# --- relations of two things -----------------------------------------------------------------------------------------


_Test = Callable[[_Context, Thing, Thing], "_Failure | None"]


def _pairwise(test: _Test, every_object: bool = False) -> Callable[[_Context], list[_Failure]]:
    """Return a relation that tests each subject against some object, or against all with ``every_object``."""

    def relation(context: _Context) -> list[_Failure]:
        stated = context.stated
        subjects, objects = (context.things(name) for name in stated.things[:2])
        # No B is nearer than the least distance: then the nearest one is not.
        apart = every_object or (test is _distance and stated.number is None and "max" not in stated.options)
        universal = apart or bool(stated.options.get("all"))
        boxes = _boxes(context, objects)
        reach = float(stated.options.get("min", 0.0)) if apart else np.inf
        near = None
        if len(subjects) > 1 and (apart or test in _CONTACTS):
            reaches = [max(context.touch(a), reach) if apart else context.touch(a) for a in subjects]
            near = context.here.prepare(subjects, objects, reaches, _MAX_TESTS)
        if context.first and near is not None and not universal and stated.options.get("any"):
            if any(_against(context, test, a, near[a.instance], False) is None for a in subjects if a.instance in near):
                return []
            subjects = subjects[:1]  # none holds; the first tells why
        failures = []
        for a in subjects:
            around = near.get(a.instance, []) if near is not None else []
            if around and not universal and _against(context, test, a, around, False) is None:
                failure = None
            elif near is not None and apart:
                failure = _against(context, test, a, context.here.nearest(a, around), True)
            else:
                failure = _against(context, test, a, _nearest(context, a, objects, boxes, reach), universal)
            if failure is None and stated.options.get("any"):
                return []
            if failure is not None:
                failures.append(failure)
                if context.first and not stated.options.get("any"):
                    break
        if failures and stated.options.get("any"):
            return [min(failures, key=lambda each: each.amount)]
        return failures

    return relation


def _against(context: _Context, test: _Test, a: Thing, objects: Iterable[Thing], universal: bool) -> _Failure | None:
    """Return why a subject fails: against the nearest object, or with ``universal`` the worst of all."""
    worst: _Failure | None = None
    best: _Failure | None = None
    alone = True
    for b in objects:
        if b.instance == a.instance:
            continue
        alone = False
        context.work.spend()
        if best is not None and not universal and test in _NEARNESS and _gap(context.here, a, b) >= best.amount:
            continue  # further than the nearest is from holding
        failure = test(context, a, b)
        if failure is None and not universal:
            return None
        if failure is not None:
            worst = failure if worst is None or failure.amount > worst.amount else worst
            best = failure if best is None or failure.amount < best.amount else best
    if alone and not universal:
        return _Failure(f'there is no other "{context.stated.things[1]}"', 1.0, a)
    return worst if universal else best


def _gap(here: Arrangement, a: Thing, b: Thing) -> float:
    """Return the distance of the boxes of two things, 0 if these touch."""
    (low, high), (under, over) = here.box(a), here.box(b)
    return float(np.linalg.norm(np.maximum(np.maximum(low - over, under - high), 0.0)))


def _boxes(context: _Context, things: Sequence[Thing]) -> tuple[FloatArray, FloatArray]:
    """Return the low and the high corners (N, 3) of the boxes of things."""
    low, high = zip(*(context.here.box(thing) for thing in things))
    return np.array(low), np.array(high)


def _nearest(
    context: _Context, a: Thing, objects: Sequence[Thing], boxes: tuple[FloatArray, FloatArray], reach: float
) -> Iterator[Thing]:
    """Yield the objects whose boxes are within ``reach``, the nearest first."""
    low, high = context.here.box(a)
    apart = np.maximum(np.maximum(boxes[0] - high, low - boxes[1]), 0.0)
    square = (apart * apart).sum(axis=1)
    first = np.zeros(0, np.int64)
    if len(square) > 2 * _FIRST:  # all are seldom needed
        first = np.flatnonzero(square <= np.partition(square, _FIRST)[_FIRST])
        first = first[np.argsort(square[first], kind="stable")]
        yield from (objects[i] for i in first[square[first] <= reach * reach * (1.0 + 1e-9)].tolist())
    order = np.argsort(square, kind="stable")[len(first) :]
    yield from (objects[i] for i in order[square[order] <= reach * reach * (1.0 + 1e-9)].tolist())


def _on(context: _Context, a: Thing, b: Thing) -> _Failure | None:
    here, reach = context.here, context.touch(a)
    low, high = here.box(a)
    if here.contains(a, b):
        return _Failure(
            f'"{b.entity.word}" is a part of "{a.entity.word}"', max(float((high - low).max()), reach), a, b
        )
    found = here.separation(a, b)
    if found is None:
        return _Failure(f'"{a.entity.word}" has no solid parts', 1.0, a, b)
    deepest = max(reach, SUNK * float(high[1] - low[1]))
    if -deepest <= found.distance <= reach and here.is_blocked(a, b, reach):
        return None
    move = _onto(here, a, b)
    amount = float(np.linalg.norm(move)) if move is not None else abs(found.distance)
    if found.distance < -deepest:
        message = f"{_two_words(a, b)} overlap by {-found.distance:.3g}"
    elif found.distance > reach and move is not None and abs(move[0]) + abs(move[2]) < reach:
        message = f'"{a.entity.word}" floats {found.distance:.3g} above "{b.entity.word}"'
        if move[1] > 0.0:
            message = f'"{a.entity.word}" is {found.distance:.3g} below "{b.entity.word}"'
    elif found.distance > reach:
        message = f'"{a.entity.word}" is {found.distance:.3g} from "{b.entity.word}"'
    else:
        message = f'"{a.entity.word}" touches "{b.entity.word}", which does not carry it'
    return _Failure(message, max(amount, reach), a, b, move)


def _two_words(a: Thing, b: Thing) -> str:
    return f'"{a.entity.word}" and "{b.entity.word}"'


def _onto(here: Arrangement, a: Thing, b: Thing) -> Vector | None:
    """Return the translation that puts ``a`` onto ``b``: over it where it is not yet, then down until they meet."""
    (low, high), (under, over) = here.box(a), here.box(b)
    center = (low + high) / 2.0
    sideways = np.clip(center, under, over) - center
    sideways[1] = 0.0
    if sideways.any():  # not only its centre: as much of it as fits
        half = (high - low) / 2.0
        inset = np.minimum(half, (over - under) / 2.0)
        sideways = np.clip(center, under + inset, over - inset) - center
        sideways[1] = 0.0
    up = float(over[1] - low[1])
    shifted = _dropped(here, a, b, sideways, max(up, 0.0))
    if shifted is None:
        return None
    return float(sideways[0]), shifted, float(sideways[2])


def _dropped(here: Arrangement, a: Thing, b: Thing, sideways: FloatArray, up: float) -> float | None:
    """Return the height by which ``a``, moved sideways, comes to rest on ``b``."""
    room = 1e-9 * here.bodies.size
    fall = here.fall(a, [b], up + room, sideways)
    return None if fall is None else up + room - fall


def _inside(context: _Context, a: Thing, b: Thing) -> _Failure | None:
    here, least = context.here, float(context.option("share", 1.0))
    inner, outer = here.hull(a, b), here.hull(b, a)
    (low, high), (under, over) = here.box(a), here.box(b)
    share = share_of(inner, outer)
    if share is None:  # flat, or a hull of nothing: by boxes
        extent = np.maximum(high - low, 1e-12)
        share = float(np.prod(np.clip(np.minimum(high, over) - np.maximum(low, under), 0.0, None) / extent))
    if share >= least - 1e-3:
        return None
    out = np.maximum(under - low, 0.0) - np.maximum(high - over, 0.0)
    fits = bool((high - low <= over - under).all())
    move = _vector(out) if fits and out.any() else None
    amount = max(float(np.linalg.norm(out)), (least - share) * float((high - low).max()), here.touch(a))
    return _Failure(f'{share:.0%} of "{a.entity.word}" is inside "{b.entity.word}"', amount, a, b, move)


def _touching(context: _Context, a: Thing, b: Thing) -> _Failure | None:
    reach = context.touch(a)
    found = context.here.separation(a, b)
    if found is None or abs(found.distance) <= reach:
        return None
    move = _scaled(context.here.away(found), -found.distance)
    if found.distance > 0.0:
        return _Failure(f"{_two_words(a, b)} are {found.distance:.3g} apart", found.distance, a, b, move)
    return _Failure(f"{_two_words(a, b)} overlap by {-found.distance:.3g}", -found.distance, a, b, move)


def _clear_of(context: _Context, a: Thing, b: Thing) -> _Failure | None:
    least = float(context.option("min", 0.0))
    if _gap(context.here, a, b) >= max(least, 1e-12):
        return None
    found = context.here.separation(a, b)
    room = context.here.touch(a) if least == 0.0 else 1e-9 * context.here.bodies.size
    if found is None or found.distance >= least - room:
        return None
    lacking = least - found.distance
    move = _apart(context.here, a, b, least, _scaled(context.here.away(found), lacking))
    if found.distance < 0.0:
        return _Failure(f"{_two_words(a, b)} overlap by {-found.distance:.3g}", lacking, a, b, move)
    return _Failure(f"{_two_words(a, b)} are only {found.distance:.3g} apart", lacking, a, b, move)


def _apart(here: Arrangement, a: Thing, b: Thing, least: float, move: Vector) -> Vector:
    """Return ``move`` if it takes ``a`` so far from ``b``, otherwise the least move after which their boxes are."""
    room = 1e-6 * here.bodies.size
    found = here.separation(a, b, move)
    if found is None or found.distance >= least - room:
        return move
    (low, high), (under, over) = here.box(a), here.box(b)
    lengths = np.concatenate([over - low + least, under - high - least])
    best = int(np.argmin(np.abs(lengths)))
    return _vector(np.eye(3)[best % 3] * lengths[best])


def _distance(context: _Context, a: Thing, b: Thing) -> _Failure | None:
    found = context.here.separation(a, b)
    if found is None:
        return None
    distance = max(found.distance, 0.0) + 0.0
    off = _off(context, distance)
    if off == 0.0:
        return None
    return _Failure(
        f"{_two_words(a, b)} are {distance:.3g} apart", abs(off), a, b, _scaled(context.here.away(found), -off)
    )


def _off(context: _Context, value: float) -> float:
    """Return how far a value is above (positive) or below what the declaration states; 0 if it holds."""
    expected = context.stated.number
    if expected is not None:
        within = float(context.option("within", _NUMBER * expected))
        return 0.0 if abs(value - expected) <= within + 1e-9 else value - expected
    room = 1e-9 * max(1.0, context.here.bodies.size)
    least, most = context.option("min"), context.option("max")
    if least is not None and value < least - room:
        return float(value - least)
    if most is not None and value > most + room:
        return float(value - most)
    return 0.0


def _angle(context: _Context, a: Thing, b: Thing) -> _Failure | None:
    axis = context.option("axis", "y")
    cosine = float(context.here.axis(a, axis) @ context.here.axis(b, axis))
    degrees = math.degrees(math.acos(min(1.0, max(-1.0, cosine))))
    expected = context.stated.number or 0.0
    if abs(degrees - expected) <= float(context.option("within", _ANGLE)):
        return None
    message = f"the angle between the {axis} axes of {_two_words(a, b)} is {degrees:.3g} degrees"
    return _Failure(message, abs(degrees - expected), a, b)


def _facing(context: _Context, a: Thing, b: Thing) -> _Failure | None:
    here = context.here
    towards = here.center(b) - here.center(a)
    front, aim = here.axis(a, "z")[[0, 2]], towards[[0, 2]]
    if float(np.linalg.norm(aim)) <= here.touch(a):
        return None  # one is over the other
    if float(np.linalg.norm(front)) < 1e-6:
        return _Failure(f'"{a.entity.word}" faces up or down', 90.0, a, b)
    turn = math.atan2(front[1] * aim[0] - front[0] * aim[1], float(front @ aim))
    degrees = abs(math.degrees(turn))
    if degrees <= float(context.option("within", _FACING)):
        return None
    message = f'"{a.entity.word}" faces {degrees:.3g} degrees away from "{b.entity.word}"'
    return _Failure(message, degrees, a, b, turn=turn)


def _direction(name: str) -> _Test:
    axis, sign, words = _SIDES[name]

    def test(context: _Context, a: Thing, b: Thing) -> _Failure | None:
        (low, high), (under, over) = context.here.box(a), context.here.box(b)
        center = float(low[axis] + high[axis]) / 2.0 * sign
        edge = float(over[axis]) if sign > 0.0 else -float(under[axis])
        near = float(low[axis]) if sign > 0.0 else -float(high[axis])
        middle = (low + high) / 2.0
        beside = [side for side in (0, 2) if not under[side] <= middle[side] <= over[side]] if axis == 1 else []
        if beside and ((low <= (under + over) / 2.0) & ((under + over) / 2.0 <= high))[[0, 2]].all():
            beside = []  # a table is below the cup near its edge
        lacking = edge - center
        if lacking < 0.0 and not beside:
            return None
        move = [0.0, 0.0, 0.0]
        if lacking >= 0.0:
            move[axis] = sign * (edge - near)
        for side in beside:
            move[side] = float(np.clip(middle[side], under[side], over[side]) - middle[side])
        message = f'"{a.entity.word}" is not {words} "{b.entity.word}"'
        return _Failure(message, max(float(np.linalg.norm(move)), context.here.touch(a)), a, b, _vector(move))

    return test


def _between(context: _Context) -> list[_Failure]:
    here = context.here
    subjects, firsts, seconds = (context.things(name) for name in context.stated.things)
    failures = []
    for a in subjects:
        pairs = [(b, c) for b in firsts for c in seconds if len({a.instance, b.instance, c.instance}) == 3]
        context.work.spend(len(pairs))
        nearest = [(_beside_segment(here, a, here.center(b), here.center(c)), b) for b, c in pairs]
        if any(away == 0.0 for away, _ in nearest):
            if context.option("any"):
                return []
            continue
        away, b = min(nearest, key=lambda each: each[0], default=(1.0, None))
        first, second = context.stated.things[1:]
        failures.append(_Failure(f'"{a.entity.word}" is not between "{first}" and "{second}"', away, a, b))
    return failures[:1] if context.option("any") else failures


def _beside_segment(here: Arrangement, a: Thing, start: FloatArray, end: FloatArray) -> float:
    """Return how far the box of a thing is beside the line between two points; 0 if the line passes through it, or
    if it passes above or below and the thing is between them seen from above."""
    low, high = here.box(a)
    along = end - start
    first, last = 0.0, 1.0
    for axis in (0, 2):
        if abs(along[axis]) < 1e-12:
            if not low[axis] <= start[axis] <= high[axis]:
                first, last = 1.0, 0.0
            continue
        near, far = sorted(((low[axis] - start[axis]) / along[axis], (high[axis] - start[axis]) / along[axis]))
        first, last = max(first, near), min(last, far)
    if first <= last:
        return 0.0
    center = (low + high) / 2.0
    share = float(np.clip((center - start) @ along / max(float(along @ along), 1e-300), 0.0, 1.0))
    return max(float(np.linalg.norm((center - start - share * along)[[0, 2]])), 1e-9)


# --- relations of one thing, or of all together ----------------------------------------------------------------------


def _size(context: _Context) -> list[_Failure]:
    axis = context.option("axis")

    def extents() -> Iterator[float]:
        for a in context.things(context.stated.things[0]):
            context.work.spend()
            low, high = context.here.box(a)
            yield float((high - low)["xyz".index(axis)])

    return _measured(context, extents(), f"measures {{:.3g}} along {axis}")


def _measured(context: _Context, amounts: Iterable[float], what: str) -> list[_Failure]:
    """Return the subjects whose amounts, in their order, are not as stated."""
    failures = []
    for a, amount in zip(context.things(context.stated.things[0]), amounts):
        off = _off(context, amount)
        if off == 0.0 and context.option("any"):
            return []
        if off != 0.0:
            failures.append(_Failure(f'"{a.entity.word}" {what.format(amount)}', abs(off), a))
    return failures[:1] if context.option("any") else failures


def _count(context: _Context) -> list[_Failure]:
    name = context.stated.things[0]
    found = context.here.instances(name, context.within)
    count = len(found)
    exact, least, most = context.stated.number, context.option("min"), context.option("max")
    low = exact if exact is not None else (0.0 if least is None else least)
    high = exact if exact is not None else (math.inf if most is None else most)
    holds = low <= count <= high
    if count == 0 and context.is_misspelled(name, surely=holds):
        raise context.unknown(name)
    if holds:
        return []
    subject = context.here.thing(found[0]) if found else None
    message = f"there {'is' if count == 1 else 'are'} {count}"
    return [_Failure(message, max(low - count, count - high), subject)]


def _has_color(context: _Context) -> list[_Failure]:
    """Test which color most of the surface has, as the boxes of its bodies measure it."""
    bodies = context.here.bodies
    low, high = bodies.boxes
    x, y, z = (high - low).T
    area = x * y + y * z + z * x
    failures = []
    for a in context.things(context.stated.things[0]):
        context.work.spend()
        shares: dict[str, float] = {}
        for body in range(a.first, a.last):
            name = basic_color(bodies.colors[body].tolist())
            shares[name] = shares.get(name, 0.0) + float(area[body])
        whole = sum(shares.values())
        if whole <= 0.0:
            raise SceneError("declaration-subject", f'"{a.entity.word}" has no surface that can be seen')
        share = shares.get(str(context.stated.color), 0.0) / whole
        if share > 0.5 and context.option("any"):
            return []
        if share <= 0.5:
            most = max(shares, key=lambda name: shares[name])
            failures.append(_Failure(f'"{a.entity.word}" is {most}', 1.0 - share, a))
    return failures[:1] if context.option("any") else failures


def _frames(context: _Context) -> Iterator[tuple[Arrangement, list[Thing]]]:
    """Yield every frame with the subjects there, which are the same in number and order."""
    name = context.stated.things[0]
    count = len(context.things(name))
    for number in range(len(context.here.scene.frames)):
        here = Arrangement(context.here.scene, number) if number else context.here
        things = here.things(name, context.within)
        context.work.spend(len(things))
        if len(things) != count:
            problem = f'there are {count} "{name}" in the first frame and {len(things)} in frame {number}'
            raise SceneError("declaration-subject", problem, f"state `{context.stated.relation}` of things that stay")
        yield here, things


def _moves(context: _Context) -> list[_Failure]:
    places = np.array([[here.center(a) for a in things] for here, things in _frames(context)])  # (F, N, 3)
    extent = np.ptp(places, axis=0)
    along = context.option("along")
    amounts = np.linalg.norm(extent, axis=1) if along is None else extent[:, "xyz".index(along)]
    return _measured(context, amounts.tolist(), "moves by {:.3g}" + (f" along {along}" if along else ""))


def _turns(context: _Context) -> list[_Failure]:
    frames = [[_linear(here, a) for a in things] for here, things in _frames(context)]
    amounts = [max(_turn(first, later) for later in poses) for first, *poses in zip(frames[0], *frames)]
    return _measured(context, amounts, "turns by {:.3g} degrees")


def _linear(here: Arrangement, a: Thing) -> FloatArray:
    """Return the linear parts (N, 3, 3) of the poses of a thing's bodies."""
    return np.asarray(here.bodies.worlds[a.first : a.last, :, :3], np.float64)


def _turn(first: FloatArray, later: FloatArray) -> float:
    """Return the greatest angle in degrees between the same bodies of two frames; 0 if they are not the same."""
    if first.shape != later.shape or not len(first):
        return 0.0
    turned = [_rotation(b) @ _rotation(a).T for a, b in zip(first, later)]
    return max(math.degrees(math.acos(min(1.0, max(-1.0, (float(np.trace(r)) - 1.0) / 2.0)))) for r in turned)


def _rotation(linear: FloatArray) -> FloatArray:
    """Return the rotation that is nearest to a linear map (the orthogonal factor of its polar decomposition)."""
    u, _, v = np.linalg.svd(linear)
    return np.asarray(u @ v, np.float64)


def _centers(context: _Context) -> tuple[list[Thing], FloatArray, float]:
    """Return the subjects, their centres (N, 3), and the tolerance of places."""
    things = context.things(context.stated.things[0])
    context.work.spend(len(things))
    centers = np.array([context.here.center(thing) for thing in things])
    sizes = [float(np.subtract(*context.here.box(thing)[::-1]).max()) for thing in things]
    spread = float(np.ptp(centers, axis=0).max()) if len(things) > 1 else 0.0
    return things, centers, float(context.option("within", _PLACE * max(float(np.mean(sizes)), 0.1 * spread)))


def _aligned(context: _Context) -> list[_Failure]:
    things, centers, within = _centers(context)
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
        _Failure(f'"{things[i].entity.word}" is {beside[i]:.3g} beside {line}', float(beside[i]), things[i], None,
                 _vector(-away[i]))
        for i in np.flatnonzero(beside > within).tolist()
    ]  # fmt: skip


def _principal(points: FloatArray) -> FloatArray:
    """Return the direction (3,) in which points are spread most."""
    if len(points) < 2 or not np.ptp(points, axis=0).any():
        return np.array([1.0, 0.0, 0.0])
    return np.asarray(np.linalg.svd(points, full_matrices=False)[2][0], np.float64)


def _evenly_spaced(context: _Context) -> list[_Failure]:
    things, centers, within = _centers(context)
    if len(things) < 3:
        return []
    along = context.option("along")
    direction = np.eye(3)["xyz".index(along[0])] if along else _principal(centers - centers.mean(axis=0))
    place = centers @ direction
    order = np.argsort(place, kind="stable")
    gaps = np.diff(place[order])
    usual = float(np.median(gaps))
    found = []
    for k in np.flatnonzero(np.abs(gaps - usual) > within).tolist():
        thing = things[int(order[k + 1])]
        message = f'the distance to the next "{thing.entity.word}" is {gaps[k]:.3g}, that of the others {usual:.3g}'
        found.append(_Failure(message, abs(float(gaps[k]) - usual), thing, things[int(order[k])],
                              _vector(direction * (usual - gaps[k]))))  # fmt: skip
    return found


def _symmetric(context: _Context) -> list[_Failure]:
    """Test mirror symmetry of the boxes and words of all primitives."""
    things, _, within = _centers(context)
    axis = "xyz".index(context.option("across", "x"))
    here, about = context.here, context.option("about")
    middle = here.center(context.things(about)[0])[axis] if about is not None else _middle(here, things)[axis]
    parts = [_parts(here, thing) for thing in things]
    owner = np.repeat(np.arange(len(things)), [len(part_words) for _, _, part_words in parts])
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
    for number, thing in enumerate(things):
        own = beside[owner == number]
        if len(own) and own.max() > within:
            failures.append(_Failure(f'"{thing.entity.word}" has no mirror image', _finite(own.max()), thing))
    return failures


def _parts(here: Arrangement, thing: Thing) -> tuple[FloatArray, FloatArray, list[str]]:
    """Return the boxes (N, 3), (N, 3) and the words of the primitives of a thing; blocks have no bodies, but boxes."""
    if thing.last > thing.first:
        (low, high), entity = here.bodies.boxes, here.bodies.entity[thing.first : thing.last]
        words = [here.bodies.entities[e].word for e in entity.tolist()]
        return low[thing.first : thing.last], high[thing.first : thing.last], words
    first, last = here.rows(thing) or (0, -1)
    leaves = [here.thing(int(instance)) for instance in here.ancestry.primitives[first : last + 1]]
    lows, highs = (np.array([here.box(leaf)[k] for leaf in leaves]).reshape(-1, 3) for k in (0, 1))
    return lows, highs, [leaf.entity.word for leaf in leaves]


def _finite(value: float) -> float:
    return float(value) if np.isfinite(value) else 1.0


def _middle(here: Arrangement, things: Sequence[Thing]) -> FloatArray:
    lows, highs = zip(*(here.box(thing) for thing in things))
    return np.asarray((np.min(lows, axis=0) + np.max(highs, axis=0)) / 2.0, np.float64)


def _supported(context: _Context) -> list[_Failure]:
    here = context.here
    subjects = context.things(context.stated.things[0])
    reach = float(context.option("within", min(here.touch(a) for a in subjects)))
    group = here.groups(reach)
    low, _ = here.bodies.boxes
    standing = set(group[low[:, 1] <= here.ground + 2.0 * reach].tolist())
    failures = []
    for a in subjects:
        context.work.spend()
        own = set(group[a.first : a.last].tolist())
        if not own - standing or (own & standing):
            if context.option("any"):
                return []
            continue
        failures.append(_floating(here, a, group, own))
        if context.first and not context.option("any"):
            break
    return failures[:1] if context.option("any") else failures


def _floating(here: Arrangement, a: Thing, group: IntArray, own: set[int]) -> _Failure:
    """Return the failure of a thing that is not connected to the ground, with the fall that connects it."""
    low, _ = here.box(a)
    others = [here.thing(int(here.ancestry.primitives[row])) for row in _outside(here, group, own)]
    fall = here.fall(a, others)
    down = float(low[1]) - here.ground
    drop = down if fall is None else min(fall, down)
    message = f'"{a.entity.word}" floats {drop:.3g} above what is below it'
    return _Failure(message, max(drop, here.touch(a)), a, None, (0.0, -drop, 0.0))


def _outside(here: Arrangement, group: IntArray, own: set[int]) -> list[int]:
    """Return the primitives of the frame whose bodies are in none of the groups ``own``."""
    rows = np.flatnonzero(~np.isin(group, list(own)))
    return [int(row) for row in here.bodies.row[rows]]


def _vector(values: Iterable[float]) -> Vector:
    x, y, z = (float(value) + 0.0 for value in values)
    return x, y, z


def _scaled(direction: Sequence[float], length: float) -> Vector:
    return _vector(length * x for x in direction)


_CONTACTS = (_on, _touching, _clear_of)  # relations of things that are near
_NEARNESS = (_on, _touching)  # those that fail by at least the distance of the boxes
_RELATIONS: dict[str, Callable[[_Context], list[_Failure]]] = {
    "on": _pairwise(_on),
    "inside": _pairwise(_inside),
    "touching": _pairwise(_touching),
    "clear-of": _pairwise(_clear_of, every_object=True),
    "distance": _pairwise(_distance),
    "angle": _pairwise(_angle),
    "facing": _pairwise(_facing),
    **{name: _pairwise(_direction(name)) for name in _SIDES},
    "between": _between,
    "aligned": _aligned,
    "evenly-spaced": _evenly_spaced,
    "symmetric": _symmetric,
    "supported": _supported,
    "size": _size,
    "count": _count,
    "has-color": _has_color,
    "moves": _moves,
    "turns": _turns,
}
