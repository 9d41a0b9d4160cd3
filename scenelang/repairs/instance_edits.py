"""Edits of a program at an instance of its scene, such as ``chair/leg[2]``, proven by evaluation.

A form that could make the instance is changed and the program is evaluated: the edit is accepted only if the chosen
instances change as asked and every other primitive of every frame stays the same. Which form makes an instance cannot
be read off the text, since loops, macros and helpers make several; ``settle`` proves its edits in the same way. Moves
change a literal pose first, then the numbers behind it (``placing_numbers``). Where a form makes others, too, the
instance becomes an exception (``single_instances``), or, in a shared edit, the others change with it.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import islice, pairwise
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np

from scenelang.backends.surfaces.solids import FloatArray
from scenelang.grammar.datum import Atom, Keyword, ListDatum, Source, Span, walk
from scenelang.grammar.diagnostics import Edit, SceneError
from scenelang.grammar.reader import read
from scenelang.interpreter.inspection.instance_paths import Located, Locator, escaped, outermost, primitive_ranges
from scenelang.interpreter.runtime.show import primitive_attributes
from scenelang.interpreter.scene.entity import Entity, Scene
from scenelang.interpreter.scene.flatten import FlatFrame, flatten
from scenelang.interpreter.scene.modelling.operations import Expression
from scenelang.interpreter.scene.primitives import is_word
from scenelang.interpreter.values.values import IDENTITY
from scenelang.repairs import edit_trials as trials
from scenelang.repairs.edit_trials import Trials
from scenelang.repairs.form_candidates import FormCandidate, shifted, space_before, vector_text, with_attribute
from scenelang.repairs.placing_numbers import Shift, angle_edits, number_edits, placing_numbers, spans_behind
from scenelang.repairs.program_forms import binds, forms_of, head_of, uses_around
from scenelang.repairs.single_instances import PartChange, exceptions
from scenelang.repairs.whole_objects import (
    Recoloring,
    box_pivots,
    color_literals,
    color_of_text,
    colorless,
    literal_recoloring,
    motion_about,
    pose_form,
    recoloring_function,
    wrapped_recolorings,
)

if TYPE_CHECKING:
    from scenelang.session.session import Session

_FORM_EFFORT = 20.0  # budget of the trials of changed forms, in units of ``Trials``: about 20 s
_NUMBER_EFFORT = 5.0  # the same for the numbers that place an instance
_NAMED_COLOR = re.compile(r"[a-zA-Z][a-zA-Z ]*|#[0-9a-fA-F]{3,8}")  # what `color` takes, which people write bare
_MAX_FORM_TRIALS = 120  # evaluations of changed forms for one edit
_MAX_MATCHED_PRIMITIVES = 200_000  # of a scene, which are matched with those before an edit
_POSE_TOLERANCE = 1e-9  # relative to the scene's size: primitives closer than this have not moved
# The same for the asked motion. It is written with 9 decimals and passes through the poses around the form.
_ASKED_MOTION_TOLERANCE = 1e-7
_LINEAR_PRECISION = 1e-3  # of sizes and turns, which a precision in large units would spoil
_MAX_COLORS = 8  # that are tried alone, those near the forms of the instances first
_DECIMALS = 9  # of numbers that are written
_MAX_SHOWN_LENGTH = 60  # characters of a form in a message


@dataclass(frozen=True, slots=True)
class InstanceEdit:
    """An edit of the instances of a path; exactly one field besides ``path``, ``precision`` and ``shared`` is set.

    Attributes
    ----------
    path
        Path as in ``Scene.instances``, such as ``chair/leg[2]``.
    move
        Translation in the axes and units of the scene.
    attribute
        Name of an attribute without its colon, and the text of its value.
    form
        Text of a form that replaces the one that makes the instance.
    remove
        Whether to remove the instance.
    recolor
        Text of a color that all primitives below the instances get, which names nothing of the program.
    scale
        Factors along the axes of the scene, about the middle of the underside of the first instance's box; about its
        center where numbers that give its size do so. Others are scaled alike in their own axes.
    rotate
        Axis of the scene, "x", "y" or "z", and an angle in degrees, about the center of the first instance's box.
        Others are rotated alike in their own axes.
    duplicate
        Translation, in the axes and units of the scene, of a copy that is added after each instance.
    word
        Word that is called in place of the instance's.
    rename
        New name of the instance's word, everywhere in the program.
    precision
        How far the instances may be from what the edit asks for, in the units of the scene: new numbers are written
        with as few decimals as keep to it. With 0 they have nine.
    shared
        Whether the edit is one that others share: a moved instance takes those with it that the same numbers or forms
        place; other edits change all instances that the same form makes.

    Examples
    --------
    >>> InstanceEdit("chair/leg[2]", move=(0.1, 0.0, 0.0)).path
    'chair/leg[2]'
    """

    path: str
    move: tuple[float, float, float] | None = None
    attribute: tuple[str, str] | None = None
    form: str | None = None
    remove: bool = False
    recolor: str | None = None
    scale: tuple[float, float, float] | None = None
    rotate: tuple[str, float] | None = None
    duplicate: tuple[float, float, float] | None = None
    word: str | None = None
    rename: str | None = None
    precision: float = 0.0
    shared: bool = False

    def __post_init__(self) -> None:
        if self.recolor is not None and _NAMED_COLOR.fullmatch(self.recolor.strip()):
            object.__setattr__(self, "recolor", f'(color "{self.recolor.strip()}")')
        given = (
            self.move, self.attribute, self.form, self.remove or None, self.recolor, self.scale, self.rotate,
            self.duplicate, self.word, self.rename,
        )  # fmt: skip
        if sum(each is not None for each in given) != 1:
            message = (
                "expected one of `move`, an attribute, a form that replaces it, `remove`, `recolor`, `scale`, "
                "`rotate`, `duplicate`, `word`, `rename`"
            )
            raise SceneError("value", message)
        for name in (self.word, self.rename):
            if name is not None and not _is_word(name):
                raise SceneError("value", "expected a word: text without quotes, backslashes and line ends")
        texts = (("value", self.attribute[1] if self.attribute else None), ("form", self.form), ("color", self.recolor))
        for field, text in texts:
            if text is not None and not _is_one_form(text):
                raise SceneError("value", f'the {field} must be one form, such as `[1 0 0]` or `(call "cube")`')
        if self.attribute is not None and not _is_keyword(self.attribute[0]):
            raise SceneError("value", f"`{self.attribute[0][:40]}` is no name of an attribute")
        for field, offset in (("move", self.move), ("duplicate", self.duplicate)):
            if offset is not None and not (len(offset) == 3 and np.isfinite(offset).all()):
                raise SceneError("value", f"`{field}`: expected three finite numbers")
        if self.scale is not None and not (np.isfinite(self.scale).all() and (np.abs(self.scale) > 1e-9).all()):
            raise SceneError("value", "`scale`: expected three finite numbers other than 0")
        if type(self.precision) not in (int, float) or not 0 <= self.precision < np.inf:
            raise SceneError("value", "`precision`: expected a finite number that is not negative")
        if self.rotate is not None and not (self.rotate[0] in ("x", "y", "z") and np.isfinite(self.rotate[1])):
            raise SceneError("value", "`rotate`: expected the axis x, y or z, and a finite number of degrees")

    @property
    def offset(self) -> tuple[float, float, float] | None:
        """Translation of the instances, or of their copies; None for other edits."""
        return self.move if self.move is not None else self.duplicate

    @property
    def keeps_primitives(self) -> bool:
        """Whether the instances have as many primitives after it as before."""
        return any(each is not None for each in (self.move, self.recolor, self.scale, self.rotate))


def _is_one_form(text: str) -> bool:
    """Return whether a text is one form without errors."""
    parsed = read(Source("<form>", text))
    return len(parsed.forms) == 1 and not any(diagnostic.is_error for diagnostic in parsed.diagnostics)


def _is_word(text: Any) -> bool:
    """Return whether a text is a word that can be written between quotes as it is."""
    return isinstance(text, str) and bool(text.strip()) and text.isprintable() and not set(text) & set('"\\')


def _is_keyword(name: str) -> bool:
    """Return whether a name can be the name of an attribute."""
    forms = read(Source("<name>", f":{name}")).forms
    return len(forms) == 1 and isinstance(forms[0], Atom) and forms[0].value == Keyword(name) and name.isprintable()


@dataclass(frozen=True, slots=True)
class EditedText:
    """A program after an edit: its text, the line of the form, the form before and after, and the instances changed.

    ``others`` is the number of other primitives that a shared edit changes.
    """

    text: str
    line: int
    old: str
    new: str
    instances: int
    others: int = 0


def edited(session: Session, source: Source, edit: InstanceEdit) -> EditedText:
    """Edit a program so that only the instances of a path change.

    Raises
    ------
    SceneError
        If the program is wrong, there is no such instance, or no form makes only these instances; the hint then names
        the form that affects the fewest others.
    """
    search = _Search(session, source, edit)
    result = search.trials.first(search.candidates(), search.result)
    if result is None:
        raise search.refusal()
    return result


def edited_by_data(session: Session, source: Source, change: Mapping[str, Any]) -> EditedText:
    """Edit a program by the fields of an ``InstanceEdit`` as JSON data, such as ``{"path": "leg", "move": [0, 1, 0]}``.

    Raises SceneError as ``edited`` does, and for data of another form.
    """
    values: dict[str, Any] = {
        name: tuple(value) if isinstance(value, list) else value for name, value in change.items()
    }
    try:
        edit = InstanceEdit(**values)
    except TypeError:
        raise SceneError("value", "an edit needs a path and one change, such as `move` with three numbers") from None
    return edited(session, source, edit)


class _Search:
    """Search for the form to edit, with what a refusal reports if there is none."""

    def __init__(self, session: Session, source: Source, edit: InstanceEdit) -> None:
        self.session, self.source, self.edit = session, source, edit
        evaluate = trials.version_evaluator(session)
        self.trials = Trials(source.name, evaluate, _FORM_EFFORT, _MAX_FORM_TRIALS)
        self._number_trials = Trials(source.name, evaluate, _NUMBER_EFFORT)
        self.before = _Layout(evaluate(source).require(), edit)
        if edit.recolor is not None:
            self.before.color = color_of_text(session, edit.recolor)
        self._shifts = dict[str, Shift | None]()  # by the texts that were tried
        self._moved: FloatArray | None = None  # motion of the instances by the last candidate, if it moved only them
        self._nearest: tuple[int, FormCandidate] | None = None  # fewest others that a form changes, and the form
        self._problem: str | None = None  # why the form that makes only the instances does not fit
        self._failure: str | None = None  # first error of an edited program
        self._others = 0  # other primitives that the last candidate changes

    def candidates(self) -> Iterator[FormCandidate]:
        """Yield the edits to try: at the forms and numbers that make the instances, then exceptions for them."""
        source, edit, layout = self.source, self.edit, self.before
        calls, bodies = forms_of(source, layout.word)
        # the calls of an imported word's part are in another file
        around = calls or [chain for word in layout.words_above for chain in forms_of(source, word)[0]]
        if edit.move is not None and not layout.is_root:
            yield from _shifted(calls, layout.local(edit.move))
            numbers = placing_numbers(source, self._spans(around))
            yield from number_edits(source, numbers, edit.move, self._shift, shared=edit.shared)
            computed = [*calls, bodies] if edit.shared else calls
            yield from _shifted(computed, layout.local(edit.move), computes=True)
        if edit.shared and edit.move is not None:
            yield from _own_moves(source, layout, edit.move)
            return
        if not edit.shared and not layout.is_root:
            yield from self._literals(around)
        yield from _candidates(source, edit, layout)
        for change in _part_changes(source, edit, layout):
            yield from exceptions(source, layout.located, change, lambda text: self.trials.evaluate(text).scene)

    def _literals(self, around: Sequence[Sequence[ListDatum]]) -> Iterator[FormCandidate]:
        """Yield edits of the literals that give the instances their size, their turn or their color."""
        source, edit, layout = self.source, self.edit, self.before
        if edit.recolor is not None:
            colors = color_literals(source, self._spans(around), edit.recolor)
            yield from map(_of_recoloring, islice(colors, _MAX_COLORS))
        elif layout.motion is not None:
            numbers = placing_numbers(source, self._spans(around))
            if edit.rotate is not None:
                yield from angle_edits(source, numbers, edit.rotate[1], self._shift)
            for change in layout.changes():
                yield from number_edits(source, numbers, change, self._shift, shared=False)

    def _spans(self, around: Sequence[Sequence[ListDatum]]) -> list[Span]:
        """Return where the literals behind the instances may be: first in the uses of macros that made them."""
        located = [each for instances in self.before.located for each in instances]
        sites = [site for each in located for site in each.entity.call_sites if site.source.name == self.source.name]
        return [*sites, *spans_behind(self.source, around)]

    def _shift(self, text: str) -> Shift | None:
        """Return how a text moves or changes the instances while there is budget for numbers; None if it does not."""
        if text not in self._shifts:
            scene = self._number_trials.evaluate(text).scene if self._number_trials.can_go_on else None
            self._shifts[text] = None if scene is None else self.before.shift(scene)
        return self._shifts[text]

    def result(self, candidate: FormCandidate) -> EditedText | None:
        """Return the program after a candidate that does what the edit asks and nothing else; else None.

        If a translation moves only the instances, but in other axes than those of the scene, it is corrected once.
        """
        if self._succeeds(candidate):
            return self._text_of(self._shortened(candidate))
        if self._moved is None:
            return None
        measured = self._measured(candidate)
        self._moved = None
        return self._text_of(self._shortened(measured)) if measured is not None and self._succeeds(measured) else None

    def _shortened(self, candidate: FormCandidate) -> FormCandidate:
        """Return a candidate that succeeds with its new numbers as short as the precision of the edit allows."""
        if not self.edit.precision:
            return candidate
        for decimals in range(1, _DECIMALS):
            shorter = candidate.rounded(decimals)
            if shorter == candidate:
                break
            if self._succeeds(shorter, self.edit.precision):
                return shorter
        self._succeeds(candidate)  # which counts what it changes
        return candidate

    def _succeeds(self, candidate: FormCandidate, precision: float = 0.0) -> bool:
        """Return whether a candidate does what the edit asks, up to a precision; record why if not."""
        self._others = 0
        result = self.trials.evaluate(trials.edited(self.source.text, candidate.edits))
        if result.scene is None:
            problem = next((d.message for d in result.diagnostics if d.is_error), None)
            if candidate.is_direct and self._failure is None:
                self._failure = problem
            return False
        outcome = self.before.outcome(result.scene, precision)
        is_free = self.edit.shared and self.edit.move is not None
        if outcome is None or (outcome.others and not is_free):
            if outcome is not None and (self._nearest is None or outcome.others < self._nearest[0]):
                self._nearest = outcome.others, candidate
            return False
        self._others = outcome.others if is_free else self.before.added
        if is_free and outcome.is_done and not outcome.others:
            self._problem = "nothing else shares the numbers and forms that place it"
            return False
        if not outcome.is_done and self.edit.offset is not None:
            self._moved = outcome.motion
            self._problem = "its instances, or the forms around them, are turned differently; move one of them"
        elif not outcome.is_done and candidate.is_direct:
            self._problem = "nothing that is seen depends on it; edit a part of it"
        return outcome.is_done

    def _text_of(self, candidate: FormCandidate) -> EditedText:
        """Return the program after a candidate."""
        line = self.source.position(candidate.span.start)[0]
        text = trials.edited(self.source.text, candidate.edits)
        return EditedText(text, line, candidate.span.text, candidate.new, self.before.count, self._others)

    def _measured(self, candidate: FormCandidate) -> FormCandidate | None:
        """Return a candidate whose translation is solved from the motions by one along each axis.

        A form inside turned or scaled ones moves its instances in other directions than it is moved itself.
        """
        columns = list[FloatArray]()
        for axis in range(3):
            self._moved = None
            self._succeeds(candidate.translated(np.eye(3)[axis]))
            if self._moved is None:
                return None
            columns.append(self._moved)
        offset = np.linalg.lstsq(np.stack(columns, axis=1), np.array(self.edit.offset), rcond=1e-9)[0]
        return candidate.translated(offset, in_place=True)

    def refusal(self) -> SceneError:
        """Return the error that says why no form can be edited."""
        path = self.edit.path
        if self._problem is not None:
            return SceneError("value", f"`{path}` cannot be edited so: {self._problem}")
        message = f"no form of the program makes only `{path}`"
        if self._nearest is None and self._failure is not None:
            return SceneError("value", f"`{path}` cannot be edited so: {self._failure}")
        if self._nearest is None:
            return SceneError("value", message, "edit the text of the program instead")
        others, candidate = self._nearest
        line = self.source.position(candidate.span.start)[0]
        shown = " ".join(candidate.span.text.split())
        shown = shown if len(shown) <= _MAX_SHOWN_LENGTH else shown[: _MAX_SHOWN_LENGTH - 3] + "..."
        also = f"{others:,} other primitive{'s' * (others != 1)}"
        hint = f"line {line}: `{shown}` also makes {also}; name all that it makes, or write the parts apart"
        return SceneError("value", message, hint)


# --- comparison of scenes --------------------------------------------------------------------------------------------


class _Layout:
    """The primitives of the frames of a scene, and which of them belong to the chosen instances."""

    color: tuple[float, ...] | None = None  # that an edit asks for

    def __init__(self, scene: Scene, edit: InstanceEdit) -> None:
        """Select the instances of a path in every frame; a path must select some in one of them."""
        self.edit, path = edit, edit.path
        self.frames = self._frames_of(scene)
        self.ranges: list[list[tuple[int, int]]] = []
        self.located: list[list[Located]] = []  # instances in each frame
        self.added = 0  # primitives of instances that the path does not select, but the form of the chosen ones makes
        self.poses: list[list[FloatArray]] = []  # of the instances, (4, 4) each
        # (4, 4) in the axes of an instance: what the edit asks for, and what numbers may do instead
        self.motion: FloatArray | None = None
        self._motions: list[FloatArray] = []
        self.word, self.count = path, 0
        self._parent: FloatArray = np.eye(3)  # axes of the parent of the first instance
        problem: SceneError | None = None
        for number, root in enumerate(scene.frames):
            try:
                locator = Locator(scene, number)
                instances = list(outermost(locator.find(path)))
                if edit.shared and edit.move is None:
                    instances, added = _with_alike(locator, instances)
                    self.added += added
            except SceneError as error:
                problem = problem or error
                self.ranges.append([])
                self.located.append([])
                self.poses.append([])
                continue
            self.ranges.append(primitive_ranges(root, instances))
            self.located.append(instances)
            self.poses.append([_square(instance.pose) for instance in instances])
            if not self.count:
                self._choose(locator, instances)
        if not self.count:
            raise problem or SceneError("value", f"no part `{path}`")
        if edit.shared and edit.move is None and not self.added:
            raise SceneError("value", f"the form that makes `{path}` makes nothing else")
        if edit.rename is not None:
            self.frames = [rows.renamed(self.word, edit.rename) for rows in self.frames]

    def _choose(self, locator: Locator, instances: Sequence[Located]) -> None:
        """Record word, number and parent axes of the instances of the first frame that has them."""
        self.count, self.word = len(instances), instances[0].entity.word
        self.is_root, self.is_primitive = not instances[0].positions, instances[0].entity.is_primitive
        ways = [instances[0].positions[:depth] for depth in range(len(instances[0].positions))]
        self.words_above = [locator.at(way).entity.word for way in reversed(ways)]
        above = locator.at(instances[0].positions[:-1]).pose if instances[0].positions else IDENTITY
        self._parent = np.array(above, np.float64).reshape(3, 4)[:, :3]
        if self.edit.scale is not None or self.edit.rotate is not None:
            base, middle = box_pivots(instances[0].entity, instances[0].pose)
            pivots = (base, middle) if self.edit.scale is not None else (middle,)
            pose = _square(instances[0].pose)
            self._motions = [motion_about(pose, pivot, self.edit.scale, self.edit.rotate) for pivot in pivots]
            self.motion = self._motions[0]

    def _frames_of(self, scene: Scene) -> list[_Rows]:
        """Return the primitives of the frames; those of edits that scale or rotate are without their sizes."""
        is_sized = self.edit.scale is None and self.edit.rotate is None
        return [_Rows(frame, is_sized=is_sized) for frame in flatten(scene, _MAX_MATCHED_PRIMITIVES).frames]

    def changes(self) -> Iterator[FloatArray]:
        """Yield the changes (K,) of the poses of the instances that the edit could ask for, as ``Shift`` has them."""
        for number in range(len(self._motions)):
            parts = list[FloatArray]()
            for rows, ranges, motions in zip(self.frames, self.ranges, self._in_scene(), strict=True):
                if ranges:
                    expected = _expected(rows, ranges, motions[number])
                    parts.append((expected - rows.poses[_rows_in(ranges)]).ravel())
            yield np.concatenate(parts)

    def _in_scene(self) -> Iterator[list[list[FloatArray]]]:
        """Yield the motions of each frame, as motions (4, 4) of each instance in the axes of the scene."""
        for poses in self.poses:
            yield [[pose @ motion @ np.linalg.pinv(pose) for pose in poses] for motion in self._motions]

    def local(self, move: Sequence[float]) -> FloatArray:
        """Return a translation in the scene's axes in those of the first instance's parent."""
        return np.asarray(np.linalg.lstsq(self._parent, np.array(move), rcond=None)[0], np.float64)

    def outcome(self, scene: Scene, precision: float) -> _Outcome | None:
        """Return what a program with an edit changes, of which what it asks for up to a precision.

        None if its primitives cannot be matched with those before.
        """
        try:
            frames = self._frames_of(scene)
        except SceneError:
            return None
        if len(frames) != len(self.frames):
            return None
        others, done, motion = 0, True, None
        edit = replace(self.edit, precision=precision)
        for old, new, ranges, motions in zip(self.frames, frames, self.ranges, self._in_scene(), strict=True):
            change = _changed(old, new, ranges, _Wanted(edit, motions, self.color))
            if change is None:
                return None
            others, motion = others + change.others, motion if motion is not None else change.motion
            done = done and change.is_done
        return _Outcome(others, done, motion)

    def shift(self, scene: Scene) -> Shift | None:
        """Return how far a program with an edit moves the instances; None if it does anything else to them."""
        try:
            frames = self._frames_of(scene)
        except SceneError:
            return None
        if len(frames) != len(self.frames):
            return None
        motion: FloatArray | None = None
        changes = list[FloatArray]()
        others: list[Any] = []
        for old, new, ranges in zip(self.frames, frames, self.ranges, strict=True):
            if len(old.keys) != len(new.keys):
                return None
            inside = np.zeros(len(old.keys), bool)
            for first, last in ranges:
                inside[first:last] = True
            others.append(~old.same(~inside, new, ~inside))
            if not ranges:
                continue
            if self.motion is not None:
                if (old.keys[inside] != new.keys[inside]).any():
                    return None
                changes.append((new.poses[inside] - old.poses[inside]).ravel())
                continue
            outcome = _moved_rows(old, new, inside, inside, self.edit)
            if outcome is None or outcome.motion is None:
                return None
            if motion is not None and np.abs(motion - outcome.motion).max() > _ASKED_MOTION_TOLERANCE * old.size:
                return None
            motion = outcome.motion
        if changes:
            motion = np.concatenate(changes)
        return None if motion is None else Shift(motion, np.concatenate(others))


def _with_alike(locator: Locator, instances: Sequence[Located]) -> tuple[list[Located], int]:
    """Return instances with all others that the same calls make, and the number of primitives of the others."""
    sites = {(site.start, site.end) for each in instances for site in each.entity.call_sites}
    chosen, entities = {each.positions for each in instances}, {id(each.entity) for each in instances}
    alike = [
        each
        for each in outermost(locator.find(escaped(instances[0].entity.word)))
        if id(each.entity) in entities or any((site.start, site.end) in sites for site in each.entity.call_sites)
    ]
    ranges = primitive_ranges(locator.root, [each for each in alike if each.positions not in chosen])
    return alike, sum(last - first for first, last in ranges)


def _square(pose: Sequence[float]) -> FloatArray:
    """Return a pose as a matrix (4, 4)."""
    return np.vstack([np.array(pose, np.float64).reshape(3, 4), [0.0, 0.0, 0.0, 1.0]])


@dataclass(frozen=True, slots=True, eq=False)
class _Wanted:
    """What an edit asks for in a frame: one of some motions (4, 4) of each instance in the scene, or a color."""

    edit: InstanceEdit
    motions: Sequence[Sequence[FloatArray]] = ()
    color: tuple[float, ...] | None = None


@dataclass(frozen=True, slots=True, eq=False)
class _Outcome:
    """Number of other primitives that change, whether the chosen ones do as asked, and their common motion, if any."""

    others: int
    is_done: bool
    motion: FloatArray | None = None


class _Rows:
    """Primitives of a frame: poses (N, 3, 4), and a hash (N,) of everything else that is drawn or counted."""

    def __init__(
        self, frame: FlatFrame, names: Mapping[str, str] = MappingProxyType({}), *, is_sized: bool = True
    ) -> None:
        """Read a frame, with the words ``names`` in place of its own.

        Unless ``is_sized``, the poses are those of canonical forms, so that sizes are in them.
        """
        self.poses = np.asarray(frame.matrices, np.float64).reshape(-1, 3, 4)
        keys = [(names.get(entity.word, entity.word), _key(entity)) for entity in frame.primitives]
        if not is_sized:
            forms = [_placed(entity) for entity in frame.primitives]
            keys = [key if form is None else (key[0], form[0]) for key, form in zip(keys, forms, strict=True)]
            own = [np.eye(4) if form is None else form[1] for form in forms]
            self.poses = self.poses @ np.stack(own)[frame.index] if own else self.poses
        paths = [hash(tuple(names.get(word, word) for word in path)) for path in frame.paths]
        self.keys = np.array(
            [hash((keys[i], paths[p])) for i, p in zip(frame.index.tolist(), frame.path_index.tolist())], np.int64
        )
        self.size = float(np.abs(self.poses[:, :, 3]).max(initial=1.0))
        self._frame = frame

    def renamed(self, old: str, new: str) -> _Rows:
        """Return the rows with another word in place of one."""
        return _Rows(self._frame, {old: new})

    def colors(self, rows: Any) -> list[tuple[float, ...] | None]:
        """Return the colors of some rows, None where one has no single color."""
        known = [_color(entity) for entity in self._frame.primitives]
        return [known[k] for k in self._frame.index[rows].tolist()]

    def colorless(self, rows: Any) -> list[tuple[str, Any]]:
        """Return the identities of some rows apart from their poses and colors."""
        keys = [entity.word + _key(entity, without="color") for entity in self._frame.primitives]
        index, paths = self._frame.index[rows].tolist(), self._frame.path_index[rows].tolist()
        return [(keys[i], self._frame.paths[p]) for i, p in zip(index, paths)]

    def same(self, rows: Any, other: _Rows, others: Any) -> Any:
        """Return which rows (K,) are equal to those of another frame."""
        distance = np.abs(self.poses[rows] - other.poses[others]).max(axis=(1, 2), initial=0.0)
        return (distance <= _POSE_TOLERANCE * self.size) & (self.keys[rows] == other.keys[others])


def _color(entity: Entity) -> tuple[float, ...] | None:
    """Return the color of a primitive, None if it has several."""
    color = primitive_attributes(entity).get("color")
    try:
        return tuple(np.array(color["array"] if isinstance(color, dict) else color, np.float64).ravel().tolist())
    except (TypeError, ValueError, KeyError):
        return None


def _key(entity: Entity, without: str = "") -> str:
    """Return the identity of a primitive apart from its word and pose: handle, text, attributes and box."""
    shape = entity.shape
    box = () if shape is None or not shape.has_geometry else tuple(round(x, 9) for x in shape.box_under(IDENTITY))
    embedding = entity.embedding
    known = primitive_attributes(entity)
    if without == "color" and isinstance(expression := getattr(shape, "expression", None), Expression):
        known = {**known, "solid": colorless(expression).digest}
    attributes = sorted((name, value) for name, value in known.items() if name != without)
    return repr((embedding.handle, embedding.text, attributes, box))


def _placed(entity: Entity) -> tuple[str, FloatArray] | None:
    """Return the identity of a primitive apart from its word, pose and size, and the pose (4, 4) of its canonical form.

    None if it has no canonical form.
    """
    placed = None if entity.shape is None else entity.shape.placed()
    if entity.shape is None or placed is None:
        return None
    sizes = entity.shape.defining_attributes().keys() - {"color"}
    attributes = sorted((name, value) for name, value in primitive_attributes(entity).items() if name not in sizes)
    ratios = tuple(round(ratio, 9) for ratio in placed.ratios)
    embedding = entity.embedding
    key = repr((embedding.handle, embedding.text, attributes, type(placed.form).__name__, ratios))
    return key, _square(placed.rows)


def _changed(old: _Rows, new: _Rows, ranges: Sequence[tuple[int, int]], wanted: _Wanted) -> _Outcome | None:
    """Return what changes in a frame; None if its primitives cannot be matched."""
    edit = wanted.edit
    chosen = sum(last - first for first, last in ranges)
    left = len(new.keys) - (len(old.keys) - chosen)
    if not ranges:
        return _Outcome(int((~old.same(slice(None), new, slice(None))).sum()), True) if left == 0 else None
    if edit.rename is not None:
        if left != chosen:
            return None
        others = int((~old.same(slice(None), new, slice(None))).sum())
        return _Outcome(others, not others)
    if edit.duplicate is not None:
        return _duplicated(old, new, ranges, edit)
    lengths = _lengths(ranges, left)
    if lengths is None or (edit.keeps_primitives and left != chosen) or (edit.remove and left):
        missing = len(old.keys) - len(new.keys) - chosen
        return _Outcome(missing, False) if missing > 0 else None
    outside_old, outside_new, inside_new = _matched(len(old.keys), ranges, lengths)
    others = int((~old.same(outside_old, new, outside_new)).sum())
    inside_old = _rows_in(ranges)
    if left != chosen or (others and edit.move is None):
        return _Outcome(others, not others)
    if wanted.motions:
        done = [_is_transformed(old, new, ranges, inside_new, motions, edit) for motions in wanted.motions]
        return _Outcome(0, any(done))
    if wanted.color is not None:
        return _Outcome(0, _is_recolored(old, new, inside_old, inside_new, wanted.color))
    if edit.move is None:
        return _Outcome(0, not bool(old.same(inside_old, new, inside_new).all()))
    moved = _moved_rows(old, new, inside_old, inside_new, edit)
    return replace(moved or _Outcome(0, False), others=others) if others else moved


def _duplicated(old: _Rows, new: _Rows, ranges: Sequence[tuple[int, int]], edit: InstanceEdit) -> _Outcome | None:
    """Return whether each instance is followed by its copy, moved as asked, and nothing else has changed."""
    added = len(new.keys) - len(old.keys)
    missing = sum(last - first for first, last in ranges)
    if added != missing:
        return _Outcome(added - missing, False) if added > missing else None
    lengths = [2 * (last - first) for first, last in ranges]
    outside_old, outside_new, inside_new = _matched(len(old.keys), ranges, lengths)
    others = int((~old.same(outside_old, new, outside_new)).sum())
    if others:
        return _Outcome(others, False)
    each = [np.arange(first, last) for first, last in ranges]
    before = np.concatenate([np.tile(rows, 2) for rows in each])
    is_copy = np.concatenate([np.repeat([False, True], len(rows)) for rows in each])
    first, copies = inside_new[~is_copy], inside_new[is_copy]
    if not bool(old.same(before[~is_copy], new, first).all()):
        return _Outcome(0, False)
    return _moved_rows(old, new, before[is_copy], copies, edit)


def _expected(rows: _Rows, ranges: Sequence[tuple[int, int]], motions: Sequence[FloatArray]) -> FloatArray:
    """Return the poses of the primitives of each instance under the instance's motion."""
    each = np.concatenate([np.repeat(m[None], last - first, axis=0) for m, (first, last) in zip(motions, ranges)])
    expected = each[:, :3, :3] @ rows.poses[_rows_in(ranges)]
    expected[:, :, 3] += each[:, :3, 3]
    return np.asarray(expected, np.float64)


def _is_transformed(
    old: _Rows,
    new: _Rows,
    ranges: Sequence[tuple[int, int]],
    after: Any,
    motions: Sequence[FloatArray],
    edit: InstanceEdit,
) -> bool:
    """Return whether the primitives of each instance are those before under the instance's motion."""
    tolerance = _ASKED_MOTION_TOLERANCE * max(old.size, new.size)
    distance = np.abs(_expected(old, ranges, motions) - new.poses[after])
    linear = min(edit.precision / max(old.size, 1e-300), _LINEAR_PRECISION)  # at the rim it is a length again
    is_close = distance[:, :, :3].max(initial=0.0) <= max(tolerance, linear)
    is_there = distance[:, :, 3].max(initial=0.0) <= max(tolerance, edit.precision)
    return bool(is_close and is_there and (old.keys[_rows_in(ranges)] == new.keys[after]).all())


def _is_recolored(old: _Rows, new: _Rows, before: Any, after: Any, color: Sequence[float]) -> bool:
    """Return whether rows ``after`` are rows ``before`` where they were, all with the color."""
    is_still = np.abs(new.poses[after] - old.poses[before]).max(initial=0.0) <= _POSE_TOLERANCE * old.size
    if not is_still or old.colorless(before) != new.colorless(after):
        return False
    return all(each is not None and each == tuple(color) for each in new.colors(after))


def _moved_rows(old: _Rows, new: _Rows, before: Any, after: Any, edit: InstanceEdit) -> _Outcome | None:
    """Return whether rows ``after`` are rows ``before`` moved as asked, and their motion if it is the same for all."""
    if not bool((old.keys[before] == new.keys[after]).all()):
        return None
    change = new.poses[after] - old.poses[before]
    tolerance = _ASKED_MOTION_TOLERANCE * old.size
    motion = change[0, :, 3]
    if np.abs(change[:, :, :3]).max(initial=0.0) > tolerance or np.abs(change[:, :, 3] - motion).max() > tolerance:
        return _Outcome(0, False)
    distance = np.abs(motion - np.array(edit.offset)).max()
    return _Outcome(0, bool(distance <= max(tolerance, edit.precision)), motion)


def _lengths(ranges: Sequence[tuple[int, int]], left: int) -> list[int] | None:
    """Return the number of primitives that each chosen instance has after an edit; None if it is unknown.

    ``left`` is their sum. If it differs from before, the instances of one form have equal shares of it.
    """
    old = [last - first for first, last in ranges]
    if left == sum(old):
        return old
    return [left // len(old)] * len(old) if left >= 0 and left % len(old) == 0 else None


def _rows_in(ranges: Sequence[tuple[int, int]]) -> Any:
    """Return the rows of some ranges."""
    return np.concatenate([np.arange(first, last) for first, last in ranges])


def _matched(count: int, ranges: Sequence[tuple[int, int]], lengths: Sequence[int]) -> tuple[Any, Any, Any]:
    """Return the other rows before and after an edit, and the rows of the chosen instances after it."""
    outside_old, outside_new, inside = [], [], []
    at, shift = 0, 0
    for (first, last), length in zip(ranges, lengths, strict=True):
        outside_old.append(np.arange(at, first))
        outside_new.append(np.arange(at, first) + shift)
        inside.append(np.arange(first, first + length) + shift)
        at, shift = last, shift + length - (last - first)
    outside_old.append(np.arange(at, count))
    outside_new.append(np.arange(at, count) + shift)
    return np.concatenate(outside_old), np.concatenate(outside_new), np.concatenate(inside)


# --- candidates ------------------------------------------------------------------------------------------------------


def _candidates(source: Source, edit: InstanceEdit, layout: _Layout) -> Iterator[FormCandidate]:
    """Yield candidate edits: calls of the word, then their enclosing forms, then the definition of the word."""
    calls, bodies = forms_of(source, layout.word)
    if edit.recolor is not None or layout.motion is not None:
        yield from _whole_object_candidates(source, edit, layout, calls, bodies)
        return
    if edit.rename is not None:
        yield from _renamings(source, layout.word, edit.rename)
        return
    if edit.duplicate is not None:
        for chain in calls if not layout.is_root else []:
            yield from _copies(chain, layout.local(edit.duplicate))
        return
    tried: set[tuple[int, int, str]] = set()
    for chain in calls if not layout.is_root else []:
        for form, new, is_direct in _of_chain(edit, chain, layout):
            key = form.span.start, form.span.end, new
            if key not in tried:
                tried.add(key)
                yield FormCandidate(form.span, new, is_direct)
    for body in bodies:
        if edit.form is not None or (edit.attribute is None and not edit.remove):
            yield from (FormCandidate(body.span, new, False) for new in _changes(edit, body, layout, is_call=True))


def _whole_object_candidates(
    source: Source,
    edit: InstanceEdit,
    layout: _Layout,
    calls: Sequence[Sequence[ListDatum]],
    bodies: Sequence[ListDatum],
) -> Iterator[FormCandidate]:
    """Yield candidate edits of whole objects: at a call, which is one object, then in the definition of their word."""
    direct = [chain[0] for chain in calls if not layout.is_root]
    if layout.motion is not None:
        pose = pose_form(layout.motion, layout.edit.scale, layout.edit.rotate)
        yield from (
            FormCandidate(form.span, f"(transform {form.span.text} {pose})", False) for form in [*direct, *bodies]
        )
        return
    for value in dict.fromkeys((edit.recolor or "", "[" + " ".join(f"{x:.12g}" for x in layout.color or ()) + "]")):
        yield from (FormCandidate(form.span, with_attribute(form, "color", value), False) for form in direct)
        changed = [
            literal_recoloring(source, layout.word, value),
            *wrapped_recolorings(source, [*direct, *bodies], value),
        ]
        yield from (_of_recoloring(each) for each in changed if each is not None)


def _of_recoloring(change: Recoloring) -> FormCandidate:
    """Return a recoloring as a candidate."""
    first, *others = change.edits
    return FormCandidate(first.span, first.text, False, tuple(others))


def _of_chain(edit: InstanceEdit, chain: Sequence[ListDatum], layout: _Layout) -> Iterator[tuple[ListDatum, str, bool]]:
    """Yield candidate edits of a call and its enclosing forms: removals of the outermost first."""
    ordered = list(enumerate(chain))
    for depth, form in reversed(ordered) if edit.remove else ordered:
        yield from ((form, new, depth == 0) for new in _changes(edit, form, layout, is_call=depth == 0))


def _changes(edit: InstanceEdit, form: ListDatum, layout: _Layout, *, is_call: bool) -> Iterator[str]:
    """Yield replacements of a form by which the edit could be done."""
    text = form.span.text
    if edit.move is not None:
        yield f"(transform {text} (translate {vector_text(layout.local(edit.move))}))"
    elif edit.attribute is not None and head_of(form) == "call":
        yield with_attribute(form, *edit.attribute)
    elif edit.form is not None and is_call:
        yield edit.form
    elif edit.word is not None and is_call:
        yield from _with_word(form, layout.word, edit.word)
    elif edit.remove:
        yield from ("", "(union)")


def _shifted(
    calls: Sequence[Sequence[ListDatum]], offset: FloatArray, *, computes: bool = False
) -> Iterator[FormCandidate]:
    """Yield calls, and the forms around them, with an offset added to their translations, as ``shifted`` does."""
    for chain in calls:
        for form in chain:
            yield from (FormCandidate(form.span, new, False) for new in shifted(form, offset, computes=computes))


def _own_moves(source: Source, layout: _Layout, move: Sequence[float]) -> Iterator[FormCandidate]:
    """Yield translations of the forms that make instances, without those around them: calls, then functions."""
    calls, bodies = forms_of(source, layout.word)
    uses = [use for chain in calls for use in uses_around(source, chain[0].span)]
    vector = vector_text(layout.local(move))
    for form in [*(chain[0] for chain in calls if not layout.is_root), *bodies, *uses]:
        yield FormCandidate(form.span, f"(transform {form.span.text} (translate {vector}))", False)


def _part_changes(source: Source, edit: InstanceEdit, layout: _Layout) -> Iterator[PartChange]:
    """Yield the changes of one object that do what an edit asks, for exceptions."""
    if edit.shared or edit.rename is not None:
        return
    if edit.offset is not None:
        is_copy = edit.duplicate is not None
        yield PartChange(layout.local(edit.offset), is_copy, True, lambda form: "", "")
    elif edit.remove:
        yield PartChange(None, False, True, lambda form: "(union)", "(union)")
    elif layout.motion is not None:
        pose = pose_form(layout.motion, edit.scale, edit.rotate)
        part = f"(transform (transform (car part) {pose}) (cdr part))"
        yield PartChange(None, False, False, lambda form: f"(transform {form.span.text} {pose})", part)
    elif edit.recolor is not None:
        if layout.is_primitive:
            yield _attribute_change(layout, "color", edit.recolor)
        name, added = recoloring_function(source)
        value = edit.recolor
        part = f"({name} part {value})"
        yield PartChange(None, False, False, lambda form: f"({name} {form.span.text} {value})", part, added)
    elif edit.attribute is not None:
        yield _attribute_change(layout, *edit.attribute)
    elif edit.form is not None:
        new = edit.form
        yield PartChange(None, False, False, lambda form: new, f"(transform {new} (cdr part))")
    elif edit.word is not None:
        word = edit.word
        part = f'(transform (call "{word}") (cdr part))'
        yield PartChange(None, False, False, lambda form: next(_with_word(form, layout.word, word), ""), part)


def _attribute_change(layout: _Layout, name: str, value: str) -> PartChange:
    """Return the change of an attribute of one object."""
    entity = "(primitive (entity-word (car part)) (entity-embedding (car part))"
    part = f"(transform {entity} :{name} {value}) (cdr part))" if layout.is_primitive else ""
    heads = ("call", layout.word)

    def of_form(form: ListDatum) -> str:
        """Return the form with the attribute."""
        return with_attribute(form, name, value) if head_of(form) in heads else ""

    return PartChange(None, False, False, of_form, part)


def _with_word(form: ListDatum, old: str, new: str) -> Iterator[str]:
    """Yield a call of another word, if the form is a call that names its word."""
    if head_of(form) != "call" or len(form.items) < 2:
        return
    name = form.items[1]
    if isinstance(name, Atom) and name.value == old:
        text, start = form.span.text, form.span.start
        yield f'{text[: name.span.start - start]}"{new}"{text[name.span.end - start :]}'


def _renamings(source: Source, old: str, new: str) -> Iterator[FormCandidate]:
    """Yield the edits that rename a word that the program binds: at all places that write it, or at its calls only.

    Raises SceneError for a word that the program does not bind, and for one that it has already.
    """
    named = [datum for form in read(source).forms for datum in walk(form) if isinstance(datum, Atom)]
    words = [datum for datum in named if type(datum.value) is str]
    heads = [
        form.items[1].span.start
        for top in read(source).forms
        for form in walk(top)
        if isinstance(form, ListDatum) and head_of(form) in ("bind", "call") and len(form.items) > 1
    ]
    if not any(binds(form, old) for form in read(source).forms if isinstance(form, ListDatum)):
        raise SceneError("value", f'"{old}" is not bound in this program', "replace the word of one object instead")
    if new == old or is_word(new) or any(word.value == new for word in words):
        raise SceneError("value", f'there is a word "{new}" already', "choose another name")
    every = [word.span for word in words if word.value == old]
    called = [span for span in every if span.start in heads]
    for first, *others in (every, called):
        yield FormCandidate(first, f'"{new}"', False, tuple(Edit(span, f'"{new}"') for span in others))


def _copies(chain: Sequence[ListDatum], offset: FloatArray) -> Iterator[FormCandidate]:
    """Yield candidate edits that add a copy of what a call makes: beside it in a union, else in a union of both."""
    beside = [form for form, around in pairwise(chain) if head_of(around) == "union"]
    for form in beside:
        space = space_before(form.span)
        for copy in shifted(form, offset):
            yield FormCandidate(form.span, f"{form.span.text}{space}{copy}", False)
        around = (f"{form.span.text}{space}(transform {form.span.text} (translate ", "))")
        yield FormCandidate(form.span, f"{around[0]}{vector_text(offset)}{around[1]}", False, around=around)
    for form in chain:
        around = (f"(union {form.span.text} (transform {form.span.text} (translate ", ")))")
        yield FormCandidate(form.span, f"{around[0]}{vector_text(offset)}{around[1]}", False, around=around)
