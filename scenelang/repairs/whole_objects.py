"""Edits of whole objects, of all primitives below an instance: other colors, and poses about a point of their box.

An object that has its colors from several literals is recolored where they stand, or, if other objects have them too,
by a function that makes it anew in another color, which is added to the program.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from scenelang.backends.surfaces.solids import FloatArray
from scenelang.grammar.datum import Atom, Datum, Keyword, ListDatum, Source, Span, Symbol, subdatums, walk
from scenelang.grammar.diagnostics import Edit, SceneError
from scenelang.grammar.reader import read
from scenelang.interpreter.runtime.show import primitive_attributes
from scenelang.interpreter.scene.bounds import entity_box
from scenelang.interpreter.scene.entity import Entity
from scenelang.interpreter.scene.modelling.operations import Expression
from scenelang.interpreter.values.values import Embedding, Matrix, Pair
from scenelang.repairs.program_forms import forms_of, head_of
from scenelang.stdlib.colors import named_colors

if TYPE_CHECKING:
    from scenelang.session.session import Session

_TOLERANCE = 1e-9  # of numbers of a pose that are taken as equal
_HELPER = """(define ({name} part color)
  (if (entity? part)
    (if (primitive? part)
      (primitive (entity-word part) (entity-embedding part) :color color)
      (make-entity (entity-word part) (entity-embedding part) ({name} (entity-children part) color)))
    (map-parts (lambda (p) (cons ({name} (car p) color) (cdr p))) part)))
"""
_AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}


@dataclass(frozen=True, slots=True)
class Recoloring:
    """Edits that recolor an object, the one to show first."""

    edits: tuple[Edit, ...]


# --- poses -----------------------------------------------------------------------------------------------------------


def box_pivots(entity: Entity, pose: Matrix) -> tuple[FloatArray, FloatArray]:
    """Return the middle of the underside, and the center, of the box of an instance under its pose.

    Raises SceneError if it has no geometry.
    """
    box = entity_box(Entity("", Embedding(None, None, {}), (Pair(entity, pose),)))
    if box is None:
        raise SceneError("empty-scene", f"`{entity.word}` has no geometry")
    low, high = np.array(box[:3], np.float64), np.array(box[3:], np.float64)
    middle = (low + high) / 2.0
    return np.array([middle[0], low[1], middle[2]]), middle


def motion_about(
    pose: FloatArray, pivot: FloatArray, scale: Sequence[float] | None, rotate: tuple[str, float] | None
) -> FloatArray:
    """Return a scaling or rotation of the scene about a point, as a motion (4, 4) in the axes of an instance.

    Raises SceneError if the pose of the instance is flat, so that it has no axes of its own.
    """
    if abs(np.linalg.det(pose[:3, :3])) < 1e-12:
        raise SceneError("pose", "the pose of the instance is flat, so that it cannot be scaled or rotated")
    linear = np.diag(np.array(scale, np.float64)) if scale is not None else _rotation(*(rotate or ("y", 0.0)))
    motion = np.eye(4)
    motion[:3, :3], motion[:3, 3] = linear, pivot - linear @ pivot
    return np.asarray(np.linalg.inv(pose) @ motion @ pose, np.float64)


def _rotation(axis: str, degrees: float) -> FloatArray:
    """Return a right-handed rotation (3, 3) about an axis of the scene."""
    x, y, z = _AXES[axis]
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    angle = np.radians(degrees)
    return np.asarray(np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross, np.float64)


def pose_form(motion: FloatArray, scale: Sequence[float] | None, rotate: tuple[str, float] | None) -> str:
    """Return the form of a motion (4, 4): `scale` or `rotate` where these can say it, otherwise the matrix."""
    linear, offset = motion[:3, :3], motion[:3, 3]
    # a point that stays where it is
    point = np.asarray(np.linalg.lstsq(np.eye(3) - linear, offset, rcond=1e-9)[0], np.float64)
    if np.abs(linear @ point + offset - point).max() > _TOLERANCE * max(1.0, np.abs(offset).max()):
        return _matrix(motion)
    place = f" {_vector(point)}" if np.abs(point).max() > _TOLERANCE else ""
    factors = np.diag(linear)
    if scale is not None and np.abs(linear - np.diag(factors)).max() <= _TOLERANCE:
        is_uniform = np.ptp(factors) <= _TOLERANCE
        return f"(scale {_number(factors[0]) if is_uniform else _vector(factors)}{place})"
    is_rigid = np.abs(linear @ linear.T - np.eye(3)).max() <= _TOLERANCE and np.linalg.det(linear) > 0
    if rotate is not None and is_rigid:
        axis = np.array([linear[2, 1] - linear[1, 2], linear[0, 2] - linear[2, 0], linear[1, 0] - linear[0, 1]])
        length = float(np.linalg.norm(axis))
        if length > 1e-6:  # else it is a half turn, whose axis this does not say
            angle = np.degrees(np.arctan2(length, np.trace(linear) - 1.0))
            return f"(rotate (deg {_number(angle)}) {_vector(np.asarray(axis / length, np.float64))}{place})"
    return _matrix(motion)


def _matrix(motion: FloatArray) -> str:
    """Write a motion (4, 4) as a pose."""
    return f"(pose [{' '.join(_vector(row) for row in motion)}])"


def _vector(values: Sequence[float] | FloatArray) -> str:
    """Write numbers as a vector."""
    return "[" + " ".join(map(_number, values)) + "]"


def _number(value: float) -> str:
    """Write a number with ten decimals."""
    return f"{round(float(value), 10) + 0.0:.14g}"


# --- colors ----------------------------------------------------------------------------------------------------------


def color_of_text(session: Session, value: str) -> tuple[float, ...]:
    """Return the color that a form such as `(color "ivory")` gives a primitive; raises SceneError if it gives none."""
    source = Source("<color>", f'(bind "cube" (lambda () (primitive "cube" :color {value})))')
    (part,) = session.evaluate(source).require().root.children
    attributes = primitive_attributes(part.car)
    return tuple(np.array(attributes["color"], np.float64).ravel().tolist())


def colorless(expression: Expression) -> Expression:
    """Return a solid with all its faces white, so that solids of equal form have equal digests."""
    operands = tuple(replace(each, expression=colorless(each.expression), color=None) for each in expression.operands)
    return replace(expression, operands=operands, color=(1.0, 1.0, 1.0))


def color_literals(source: Source, spans: Sequence[Span], value: str) -> Iterator[Recoloring]:
    """Yield the edits of single colors in some spans: `(color "red")`, vectors, and texts that name a color."""
    name = re.fullmatch(r'\(color ("[^"]*")\)', value.strip())
    tried = list[Span]()
    for span in spans:
        for datum in walk(*read(source).forms):
            if not _is_within(datum.span, [span]) or _is_within(datum.span, tried):
                continue
            if head_of(datum) == "color" or _is_color_vector(datum):
                yield Recoloring((Edit(datum.span, value),))
            elif name is not None and _is_color_name(datum):
                yield Recoloring((Edit(datum.span, name[1]),))
            else:
                continue
            tried.append(datum.span)


def _is_within(span: Span, others: Sequence[Span]) -> bool:
    """Return whether a span is in one of some others."""
    return any(other.start <= span.start and span.end <= other.end for other in others)


def _is_color_name(datum: Datum) -> bool:
    """Return whether a datum is a text that names a color."""
    if not isinstance(datum, Atom) or type(datum.value) is not str:
        return False
    return re.fullmatch("#[0-9a-fA-F]{3,8}", datum.value) is not None or datum.value in named_colors()


def _is_color_vector(datum: Datum) -> bool:
    """Return whether a datum is a literal vector of three numbers from 0 to 1."""
    numbers = [item.value for item in subdatums(datum) if isinstance(item, Atom) and type(item.value) in (int, float)]
    is_vector = datum.span.text.startswith("[") and len(list(subdatums(datum))) == len(numbers) == 3
    return is_vector and all(0 <= number <= 1 for number in numbers)


def literal_recoloring(source: Source, word: str, value: str) -> Recoloring | None:
    """Return the edits that give a color to all that the functions of a word, and those that they call, make."""
    bound = {str(name.value) for name in _bound_words(source)}
    reached, pending, edits = {word}, [word], dict[int, Edit]()
    while pending:
        for body in forms_of(source, pending.pop())[1]:
            for call in _color_edits(body, value, bound, edits):
                if call not in reached:
                    reached.add(call)
                    pending.append(call)
    return Recoloring(tuple(edits.values())) if edits else None


def _bound_words(source: Source) -> Iterator[Atom]:
    """Yield the words that a program binds."""
    for form in read(source).forms:
        if isinstance(form, ListDatum) and head_of(form) == "bind" and len(form.items) > 1:
            name = form.items[1]
            if isinstance(name, Atom):
                yield name


def _color_edits(body: Datum, value: str, bound: set[str], edits: dict[int, Edit]) -> Iterator[str]:
    """Add edits of all colors in a body, by offset, and yield the bound words that it calls."""
    stack: list[Datum] = [body]
    while stack:
        datum = stack.pop()
        if not isinstance(datum, ListDatum):
            continue
        old = _color_value(datum)
        called = _called_word(datum)
        if old is not None:
            edits[old.span.start] = Edit(old.span, value)
        elif called is not None and called not in bound:
            end = datum.span.end - 1
            edits[end] = Edit(Span(datum.span.source, end, end), f" :color {value}")
        if called in bound:
            yield str(called)
        if old is None:  # the color of a form is that of all that it is made of
            stack += subdatums(datum)


def _color_value(form: ListDatum) -> Datum | None:
    """Return the value of the attribute `:color` of a form, None without one."""
    items: list[Datum] = list(form.items)
    for key, value in pairwise(items):
        if isinstance(key, Atom) and isinstance(key.value, Keyword) and key.value == "color":
            return value
    return None


def _called_word(form: ListDatum) -> str | None:
    """Return the literal word that a form calls, None if it calls none."""
    if head_of(form) != "call" or len(form.items) < 2:
        return None
    name = form.items[1]
    return str(name.value) if isinstance(name, Atom) and type(name.value) is str else None


def wrapped_recolorings(source: Source, forms: Sequence[ListDatum], value: str) -> Iterator[Recoloring]:
    """Yield for each form the edits that make its value anew in another color."""
    name, added = recoloring_function(source)
    for form in forms:
        yield Recoloring((Edit(form.span, f"({name} {form.span.text} {value})"), *added))


def helper_function(source: Source, base: str, template: str) -> tuple[str, tuple[Edit, ...]]:
    """Return the name of a function of a template, and the edit that adds it unless the program has it.

    The template has ``{name}`` where the function is named; the name is ``base``, with a number if it is taken.
    """
    used = _symbols(source)
    names = (base, *(f"{base}-{number}" for number in range(2, len(used) + 3)))
    for name in names:
        text = template.format(name=name)
        if text in source.text:
            return name, ()
        if name not in used:
            forms = read(source).forms
            at = next((form.span.start for form in forms if head_of(form) != "import"), len(source.text))
            return name, (Edit(Span(source, at, at), f"{text}\n"),)
    raise AssertionError("more names than symbols are tried")


def recoloring_function(source: Source) -> tuple[str, tuple[Edit, ...]]:
    """Return the name of the function that recolors, and the edit that adds it unless the program has it."""
    return helper_function(source, "recolored", _HELPER)


def _symbols(source: Source) -> set[str]:
    """Return all symbols of a program."""
    symbols: set[str] = set()
    stack: list[Datum] = list(read(source).forms)
    while stack:
        datum = stack.pop()
        if isinstance(datum, Atom) and isinstance(datum.value, Symbol):
            symbols.add(str(datum.value))
        stack.extend(subdatums(datum))
    return symbols
