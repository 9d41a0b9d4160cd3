"""The styles of the layout: how a list that does not fit a line is spread over several.

A style writes the parts of a page and returns True; False: it does not suit this list, and the next one is tried on a
fresh page.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from enum import Enum, auto
from itertools import takewhile
from typing import TYPE_CHECKING, NamedTuple, TypeAlias

from scenelang.grammar.datum import ArrayDatum, Atom, Datum, Keyword, ListDatum, Symbol

if TYPE_CHECKING:
    from scenelang.grammar.layout import Page


# What the layout of programs knows of heads: which operands stand on the head's line, which parts are bodies,
# bindings, clauses or data, and which forms always take several lines.


class Role(Enum):
    """What a datum is for the form around it."""

    TOP = auto()
    BODY = auto()  # a form of a body
    CODE = auto()
    FUNCTION = auto()  # the function that `bind` binds
    DATA = auto()
    BINDINGS = auto()
    BINDING = auto()
    CLAUSE = auto()
    PARAMETERS = auto()
    SIGNATURE = auto()


class HeadKind(Enum):
    """How a datum is laid out where it does not fit one line."""

    ORDINARY = auto()
    SPECIAL = auto()  # some operands on the head's line, the others indented by two
    IF = auto()
    BODIED = auto()  # SPECIAL, the others being a body
    DEFINE = auto()
    LAMBDA = auto()
    LET = auto()
    FOR = auto()
    DO = auto()
    GUARD = auto()
    BIND = auto()
    CLAUSES = auto()  # SPECIAL, the others being clauses
    CALL = auto()  # keyword pairs fill the lines
    TRANSFORM = auto()
    ALIGNED = auto()  # operands under the first operand
    TABLE = auto()
    QUOTE = auto()
    QUASIQUOTE = auto()
    GROUP = auto()  # a list in code whose head is no symbol
    ARRAY = auto()
    DATA = auto()
    BINDINGS = auto()
    BINDING = auto()
    CLAUSE = auto()
    PARAMETERS = auto()
    SIGNATURE = auto()


class HeadShape(NamedTuple):
    """How to lay a datum out; ``kept``: operands on the head's line."""

    kind: HeadKind
    kept: int = 0


WITH_BODY = frozenset(
    (HeadKind.BODIED, HeadKind.DEFINE, HeadKind.LAMBDA, HeadKind.LET, HeadKind.FOR, HeadKind.DO, HeadKind.GUARD)
)
# a value of these kinds is too much to share a line with other keyword pairs
WEIGHTY = WITH_BODY | {HeadKind.CALL, HeadKind.TRANSFORM, HeadKind.CLAUSES}
# of the styles of these kinds the one with the fewest lines is taken, not the first one that fits
SHORTEST = frozenset((HeadKind.TRANSFORM,))
# heads whose operands are equals: none of them stays behind on the head's line
EVEN_HEADS = frozenset(("union", "append", "union*", "frames"))

_BY_ROLE = {
    Role.DATA: HeadShape(HeadKind.DATA),
    Role.BINDINGS: HeadShape(HeadKind.BINDINGS),
    Role.BINDING: HeadShape(HeadKind.BINDING),
    Role.CLAUSE: HeadShape(HeadKind.CLAUSE),
    Role.PARAMETERS: HeadShape(HeadKind.PARAMETERS),
    Role.SIGNATURE: HeadShape(HeadKind.SIGNATURE),
}
_ORDINARY, _GROUP, _ARRAY, _DATA = (
    HeadShape(HeadKind.ORDINARY),
    HeadShape(HeadKind.GROUP),
    HeadShape(HeadKind.ARRAY),
    HeadShape(HeadKind.DATA),
)

_ALIGNED_HEADS = (
    *("+", "-", "*", "/", "//", "%", "**", "expt", "abs", "min", "max", "sqrt", "square", "hypot", "exp", "log"),
    *("sin", "cos", "tan", "asin", "acos", "atan", "radians", "degrees", "floor", "ceiling", "round"),
    *("=", "!=", "<", ">", "<=", ">=", "and", "or", "not", "list", "cons", "set", "ref", "@"),
)
_ALWAYS = {
    **dict.fromkeys(_ALIGNED_HEADS, HeadKind.ALIGNED),
    **dict.fromkeys(("call", "primitive", "scene", "param", "define-record"), HeadKind.CALL),
    **dict.fromkeys(("unquote", "unquote-splicing"), HeadKind.ORDINARY),
    "transform": HeadKind.TRANSFORM,
    "table": HeadKind.TABLE,
    "quote": HeadKind.QUOTE,
    "quasiquote": HeadKind.QUASIQUOTE,
}
_WHERE_INDENTED = {
    "if": HeadKind.IF,
    "lambda": HeadKind.LAMBDA,
    "define": HeadKind.DEFINE,
    "define-macro": HeadKind.DEFINE,
    "do": HeadKind.DO,
    "guard": HeadKind.GUARD,
    "bind": HeadKind.BIND,
    **dict.fromkeys(("let", "let*", "letrec", "letrec*", "let-values", "let*-values"), HeadKind.LET),
    **dict.fromkeys(("let-syntax", "letrec-syntax"), HeadKind.LET),
    **dict.fromkeys(("begin", "begin0", "when", "unless", "while", "let/ec"), HeadKind.BODIED),
    **dict.fromkeys(("cond", "case", "syntax-rules"), HeadKind.CLAUSES),
}


def shapes_by_head(indents: Mapping[str, int | None]) -> dict[str, HeadShape]:
    """The shape of every head that is more than an ordinary function."""
    shapes = {}
    for name, indent in indents.items():
        kind = HeadKind.FOR if name.startswith(("for/", "for*")) or name == "for" else HeadKind.SPECIAL
        kind = HeadKind.ALIGNED if indent is None else _WHERE_INDENTED.get(name, kind)
        shapes[name] = HeadShape(kind, indent or 0)
    for name, kind in _ALWAYS.items():
        shapes[name] = HeadShape(kind, 1)
    return shapes


def head_of(datum: Datum) -> str | None:
    """The symbol that a list begins with."""
    if isinstance(datum, ListDatum) and datum.items:
        head = datum.items[0]
        if isinstance(head, Atom) and type(head.value) is Symbol:
            return head.value
    return None


def is_keyword(datum: Datum) -> bool:
    return isinstance(datum, Atom) and type(datum.value) is Keyword


def is_ellipsis(datum: Datum) -> bool:
    """Whether ``datum`` is the `...` of a macro's pattern or template."""
    return isinstance(datum, Atom) and type(datum.value) is Symbol and datum.value == "..."


def shape_of(datum: ListDatum | ArrayDatum, role: Role, shapes: Mapping[str, HeadShape]) -> HeadShape:
    """The shape of a compound datum in its role."""
    if isinstance(datum, ArrayDatum):
        return _DATA if role is Role.DATA else _ARRAY
    fixed = _BY_ROLE.get(role)
    if fixed is not None:
        return fixed
    head = head_of(datum)
    if head is None:
        return _GROUP
    shape = shapes.get(head, _ORDINARY)
    if shape.kind is HeadKind.LET and len(datum.items) > 2 and isinstance(datum.items[1], Atom):
        return HeadShape(HeadKind.LET, 2)  # a named `let`
    return shape


def roles_of_parts(datum: ListDatum | ArrayDatum, shape: HeadShape, parts: Sequence[Datum]) -> list[Role]:
    """The role of every part of ``datum``, its tail included."""
    kind, kept = shape
    count = len(parts)
    if kind is HeadKind.DATA:
        unquoting = head_of(datum) in ("unquote", "unquote-splicing") and count == 2
        return [Role.CODE if unquoting else Role.DATA] * count
    if kind is HeadKind.BINDINGS or kind is HeadKind.PARAMETERS or kind is HeadKind.SIGNATURE:
        tested = kind is HeadKind.BINDINGS  # `:when test` among the clauses of a loop
        return [
            Role.CODE if tested and place and is_keyword(parts[place - 1]) else Role.BINDING for place in range(count)
        ]
    if kind is HeadKind.BINDING:
        return [Role.DATA] + [Role.CODE] * (count - 1)
    if kind is HeadKind.CLAUSE:
        return [Role.CODE] + [Role.BODY] * (count - 1)
    if kind is HeadKind.QUOTE:
        return [Role.DATA] * count
    if kind is HeadKind.QUASIQUOTE:  # a template of code, or of data
        return [Role.DATA if head_of(part) is None else Role.CODE for part in parts]
    roles = [Role.CODE] * count
    if kind in WITH_BODY:
        roles[1 + kept :] = [Role.BODY] * (count - 1 - kept)
    elif kind is HeadKind.CLAUSES:
        roles[1 + kept :] = [Role.CLAUSE] * (count - 1 - kept)
    _set_head_roles(kind, kept, parts, roles)
    return roles


def _set_head_roles(kind: HeadKind, kept: int, parts: Sequence[Datum], roles: list[Role]) -> None:
    """The roles of the operands that stand on the head's line."""
    if len(parts) < 2:
        return
    if kind is HeadKind.LAMBDA:
        roles[1] = Role.PARAMETERS
    elif kind is HeadKind.DEFINE and isinstance(parts[1], ListDatum):
        roles[1] = Role.SIGNATURE
    elif kind is HeadKind.LET:
        roles[min(kept, len(parts) - 1)] = Role.BINDINGS
    elif kind is HeadKind.FOR:
        kept = min(kept, len(parts) - 1)
        roles[1 : 1 + kept] = [Role.BINDINGS] * kept
    elif kind is HeadKind.DO:
        roles[1:3] = [Role.BINDINGS, Role.CLAUSE][: len(parts) - 1]
    elif kind is HeadKind.GUARD:
        roles[1] = Role.CLAUSE
    elif kind is HeadKind.BIND:
        roles[-1] = Role.FUNCTION


def takes_lines(datum: ListDatum | ArrayDatum, shape: HeadShape, role: Role) -> bool:
    """Whether ``datum`` takes several lines even where one would do: functions of a file, Scheme's loops, bodies and
    clauses of several forms."""
    kind = shape.kind
    items = datum.items
    count = sum(not is_ellipsis(item) for item in items)
    if kind in WITH_BODY:
        if role is Role.FUNCTION:
            return True
        if kind is HeadKind.DEFINE:
            if len(items) < 3 or not isinstance(items[1], ListDatum):
                return False
            if role is Role.TOP:
                return True
        if kind is HeadKind.DO or (kind is HeadKind.LET and shape.kept == 2):
            return True
        return count > 2 + shape.kept
    if kind is HeadKind.CLAUSES:
        return count > 2 + shape.kept
    if kind is HeadKind.CLAUSE:
        return count > 2 and not (isinstance(items[1], Atom) and items[1].value == "=>")
    if kind is HeadKind.IF and (role is Role.BODY or role is Role.TOP):
        return len(items) == 4 and isinstance(items[2], ListDatum) and isinstance(items[3], ListDatum)
    return False


def parts_of(datum: ListDatum | ArrayDatum) -> Sequence[Datum]:
    """The items of a datum, and its tail."""
    if isinstance(datum, ListDatum) and datum.tail is not None:
        return (*datum.items, datum.tail)
    return datum.items


# --- line breaks of an author ----------------------------------------------------------------------------------------

_PASSING = frozenset(("set!", "define-values"))  # a value that fits on the head's line stands there
_BY_HEAD_LINE = WITH_BODY | {HeadKind.BIND, HeadKind.CLAUSES, HeadKind.IF, HeadKind.SPECIAL}


def stays_broken(
    datum: ListDatum | ArrayDatum, shape: HeadShape, parts: Sequence[Datum], breaks: Sequence[bool]
) -> bool:
    """Whether line breaks that an author made are kept although one line has room: a body that begins on a line of its
    own, a function as the last operand, members of a union, a pose under its shape, bindings under each other.
    ``breaks`` tells which parts begin a line."""
    kind, kept = shape
    if kind in _BY_HEAD_LINE:
        if kind is HeadKind.DEFINE and len(parts) > 1 and isinstance(parts[1], Atom):
            return False
        return any(breaks[1 + kept : 2 + kept]) and head_of(datum) not in _PASSING
    if kind is HeadKind.CLAUSE:
        return any(breaks[1:2]) and not (isinstance(parts[1], Atom) and parts[1].value == "=>")
    if kind is HeadKind.ORDINARY and len(parts) > 2 and head_of(parts[-1]) == "lambda" and breaks[-1]:
        return True
    if kind is HeadKind.BINDINGS or kind is HeadKind.TRANSFORM or head_of(datum) in EVEN_HEADS:
        return any(breaks[1:])
    if kind is HeadKind.ALIGNED:
        compound = not any(isinstance(part, Atom) for part in parts[1:])
        return compound and len(parts) > 2 and all(breaks[2:])
    return kind is HeadKind.TABLE and any(breaks[1:2])


def has_rows(datum: ListDatum | ArrayDatum, shape: HeadShape, parts: Sequence[Datum], breaks: Sequence[bool]) -> bool:
    """Whether the author gave every row of a table of data, or every keyword pair of a call, a line of its own."""
    if shape.kind is HeadKind.DATA or shape.kind is HeadKind.ARRAY:
        return len(parts) > 1 and all(breaks[1:]) and not any(isinstance(part, Atom) for part in parts)
    if shape.kind is HeadKind.CALL or shape.kind is HeadKind.ORDINARY:
        keys = [place for place, part in enumerate(parts) if place and is_keyword(part)]
        return len(keys) > 1 and all(breaks[place] for place in keys)
    return False


# Parts of a list that stay together on a line, and writing them: one per line, or as many as fit.


Unit: TypeAlias = range  # positions of parts that stay together: a keyword and its value, or one part


def units(page: Page, first: int) -> list[Unit]:
    """The parts from ``first`` on; a keyword stays with the value after it, `...` with what it repeats."""
    parts, found, position = page.parts, [], first
    while position < len(parts):
        stop = position + 1
        if is_keyword(parts[position]) and stop < len(parts) and not is_keyword(parts[stop]):
            stop += 1
        while stop < len(parts) and is_ellipsis(parts[stop]):
            stop += 1
        found.append(range(position, stop))
        position = stop
    return found


def write_units(page: Page, found: Sequence[Unit], indent: int) -> None:
    """One unit per line."""
    for unit in found:
        write_unit(page, unit, indent, True)


def write_unit(page: Page, unit: Unit, indent: int, fresh: bool) -> None:
    page.item(unit.start, indent, fresh)
    for position in unit[1:]:
        page.item(position, indent + 2)


def unit_width(page: Page, unit: Unit) -> int | None:
    """The width of a unit on one line; None where it takes several."""
    width = len(unit) - 1
    for position in unit:
        flat = page.flat_width(position)
        if flat is None:
            return None
        width += flat
    return width


def fill(page: Page, found: Sequence[Unit], indent: int, most: int = 0) -> None:
    """As many units per line as fit, and no more than ``most`` if that is given; one that takes several lines has
    them for itself."""
    alone = False
    for count, unit in enumerate(found):
        width = unit_width(page, unit)
        fresh = alone or width is None or page.column + 1 + width > page.width
        fresh = fresh or (most > 0 and count % most == 0)
        if unit.start == 0 or (page.column == indent and not alone):
            fresh = False
        write_unit(page, unit, indent, fresh)
        alone = width is None or indent + width > page.width


Style: TypeAlias = "Callable[[Page], bool]"

_ROW = 3  # compound items fill lines only where so many fit one
_SHORT = 26  # a quoted list up to this width counts as a short item


def styles_of(shape: HeadShape) -> Sequence[Style]:
    """The styles for a shape, best first; the last one takes any list."""
    return _STYLES[shape.kind]


def last_resort(page: Page) -> bool:
    """``(f`` and every operand on a line of its own, indented by two."""
    if page.parts:
        page.item(0, page.start + 1)
    write_units(page, units(page, 1), page.start + 2)
    return True


# --- heads with operands on their line ---------------------------------------------------------------------------


def _special(page: Page) -> bool:
    """``(head operand`` and the others indented by two; kept operands too long for the line stand under the first."""
    return _with_kept(page, page.shape.kept)


def _with_kept(page: Page, kept: int) -> bool:
    kept = min(kept, len(page.parts) - 1)
    page.item(0, page.start + 1)
    under = page.column + 1
    for position in range(1, 1 + kept):
        page.item(position, under, position > 1 and not page.fits(position, page.column + 1))
    write_units(page, units(page, 1 + kept), page.start + 2)
    return True


def _keyed_as_written(page: Page) -> bool:
    """An application with keywords, on the lines that its author gave it."""
    return _has_keywords(page) and _as_written(page)


def _has_keywords(page: Page) -> bool:
    return any(is_keyword(part) for part in page.parts[1:])


def _ordinary(page: Page) -> bool:
    """An application: the operands under each other, or leading small ones on the head's line."""
    count = len(page.parts)
    if _has_keywords(page):
        return _pairs(page, 0)
    if count > 2 and head_of(page.datum) not in EVEN_HEADS and _leads(page):
        return _with_kept(page, count - 2)
    if not all(isinstance(part, Atom) for part in page.parts):
        return False
    has_lines = any(page.holds_lines(position) for position in range(count))
    return _aligned(page) if has_lines else _pairs(page, 0)


def _leads(page: Page) -> bool:
    """Whether all operands but the last stand on the head's line: atoms, or anything short before a function."""
    *leading, last = range(1, len(page.parts))
    if isinstance(page.parts[last], Atom):
        return False
    shape = page.kind_shape(last)
    before_function = shape is not None and shape.kind is HeadKind.LAMBDA
    column = page.column + (page.flat_width(0) or 0)
    for position in leading:
        width = page.flat_width(position)
        if width is None or not (before_function or isinstance(page.parts[position], Atom)):
            return False
        column += 1 + width
    return column <= page.width


def _function_first(page: Page) -> bool:
    """``(map (lambda (x)`` with the other operands under the function."""
    shape = page.kind_shape(1) if len(page.parts) > 2 else None
    return shape is not None and shape.kind is HeadKind.LAMBDA and _aligned(page)


def _hugging(page: Page) -> bool:
    """``(f (g x`` with the operands of the only operand under each other."""
    shape = page.kind_shape(1) if len(page.parts) == 2 else None
    return shape is not None and shape.kind in (HeadKind.ORDINARY, HeadKind.ALIGNED) and _aligned(page)


# --- lines of an author --------------------------------------------------------------------------------------------


def _as_written(page: Page) -> bool:
    """The operands on the lines that their author gave them: under the first one, or indented by two where that is on
    a line of its own or there are keywords."""
    breaks = page.breaks
    if breaks is None or len(page.parts) < 2:
        return False
    if page.shape.kind is HeadKind.CALL:
        return _on_lines(page, breaks, True)
    below = breaks[1]
    if page.shape.kind is HeadKind.ALIGNED and (below or not any(breaks[2:])):
        return False
    if head_of(page.datum) in EVEN_HEADS and not below:
        return False
    begins = page.start + 2 + (page.flat_width(0) or 0)
    keyed = page.fits(1, begins) and any(is_keyword(part) for part in page.parts)
    return _on_lines(page, breaks, below or keyed)


def _as_written_below(page: Page) -> bool:
    """As ``_as_written``, the lines after the first indented by two."""
    breaks = page.breaks
    if breaks is None or len(page.parts) < 3 or head_of(page.datum) in EVEN_HEADS:
        return False
    return _on_lines(page, breaks, True)


def _on_lines(page: Page, breaks: Sequence[bool], shallow: bool) -> bool:
    page.item(0, page.start + 1)
    indent = page.start + 2 if shallow else page.column + 1
    filled = False  # whether the unit before took several lines
    for unit in units(page, 1):
        fresh = breaks[unit.start] and not (unit.start == 1 and page.shape.kind is HeadKind.CALL)
        width = unit_width(page, unit)
        if fresh and width is not None and page.start + 2 + width <= page.width < indent + width:
            return False  # it has room on a line, but not there
        if unit.start > 1 and width is not None and page.column + 1 + width > page.width:
            fresh = True
        write_unit(page, unit, indent, fresh or filled)
        filled = width is None
    return True


def _data_as_written(page: Page) -> bool:
    """Data on the lines that their author gave them."""
    breaks = page.breaks
    if breaks is None or not any(breaks[1:]) or page.has_rows or _is_matrix(page):
        return False
    for position in range(len(page.parts)):
        page.item(position, page.start + 1, position > 0 and breaks[position])
    return True


# --- keyword pairs -----------------------------------------------------------------------------------------------


def _call(page: Page) -> bool:
    """``(call "word" :key value`` with as many pairs per line as fit."""
    return _pairs(page, 1)


def _pairs(page: Page, kept: int) -> bool:
    """The first operands and as many pairs per line as fit, or a line for each pair when a value is weighty."""
    indent = page.start + 2
    page.item(0, page.start + 1)
    kept = min(kept, len(page.parts) - 1)
    for position in range(1, 1 + kept):
        page.item(position, indent)
    found = units(page, 1 + kept)
    if page.has_rows or any(_is_weighty(page, unit, indent) for unit in found):
        atoms = list(takewhile(lambda unit: len(unit) == 1 and isinstance(page.parts[unit.start], Atom), found))
        if not kept:
            atoms = []
        fill(page, atoms, indent)
        write_units(page, found[len(atoms) :], indent)
    else:
        leading = list(takewhile(lambda unit: not is_keyword(page.parts[unit.start]), found))
        fill(page, leading, indent)
        keyed = _with_series(page, found[len(leading) :], indent)
        if leading and keyed and page.broken:
            write_unit(page, keyed.pop(0), indent, True)
        fill(page, keyed, indent)
    return True


def _is_weighty(page: Page, unit: Unit, indent: int) -> bool:
    """Whether a unit wants a line for itself: several lines, or a value that is a shape or has a body."""
    width = unit_width(page, unit)
    shape = page.kind_shape(unit[-1])
    return width is None or indent + width > page.width or (shape is not None and shape.kind in WEIGHTY)


def _with_series(page: Page, found: Sequence[Unit], indent: int) -> list[Unit]:
    """Pairs with numbered keywords, such as ``:p0`` and ``:p1``, are joined where they fit one line."""
    joined: list[Unit] = []
    for unit in found:
        if joined and _continues(page, joined[-1], unit):
            both = range(joined[-1].start, unit.stop)
            width = unit_width(page, both)
            if width is not None and indent + width <= page.width:
                joined[-1] = both
                continue
        joined.append(unit)
    return joined


def _continues(page: Page, unit: Unit, following: Unit) -> bool:
    names = [page.parts[place.start] for place in (unit, following)]
    if not all(isinstance(name, Atom) and is_keyword(name) for name in names):
        return False
    first, second = (str(name.value) for name in names if isinstance(name, Atom))
    return first[:-1] == second[:-1] and first[-1:].isdigit() and second[-1:].isdigit()


# --- aligned operands --------------------------------------------------------------------------------------------


def _transform(page: Page) -> bool:
    """The shape on the head's line and its pose under it."""
    if len(page.parts) != 3:
        return False
    shape = page.kind_shape(1)
    upright = shape is None or shape.kind in (HeadKind.CALL, HeadKind.TRANSFORM)
    if not upright and not page.fits(1, page.column + len("transform ")):
        return False
    return _aligned(page)


def _pose_below(page: Page) -> bool:
    """``(transform name`` and a pose too long to stand under the name."""
    return len(page.parts) == 3 and isinstance(page.parts[1], Atom) and _with_kept(page, 1)


def _aligned(page: Page) -> bool:
    """Operands under the first operand; neighbouring atoms share a line."""
    if len(page.parts) < 2:
        return False
    page.item(0, page.start + 1)
    indent = page.column + 1
    was_atom = False
    for unit in units(page, 1):
        is_atom = all(isinstance(page.parts[position], Atom) for position in unit)
        width = unit_width(page, unit)
        shares = is_atom and was_atom and width is not None and page.column + 1 + width <= page.width
        write_unit(page, unit, indent, unit.start > 1 and not shares)
        was_atom = is_atom
    return True


def _filled_operands(page: Page) -> bool:
    """Constants after a head such as ``list``, filling the lines under the first of them."""
    if len(page.parts) < 4 or not all(_is_short(page, position) for position in range(1, len(page.parts))):
        return False
    page.item(0, page.start + 1)
    indent = page.column + 1
    page.item(1, indent)
    fill(page, units(page, 2), indent)
    return True


def _is_short(page: Page, position: int) -> bool:
    part = page.parts[position]
    shape = page.kind_shape(position)
    if isinstance(part, Atom) or shape is None:
        return True
    width = page.flat_width(position)
    constant = shape.kind in (HeadKind.ARRAY, HeadKind.DATA, HeadKind.QUOTE)
    return constant and width is not None and width <= _SHORT


def _table(page: Page) -> bool:
    """One key with its value per line."""
    page.item(0, page.start + 1)
    indent = page.start + 2
    for position in range(1, len(page.parts)):
        page.item(position, indent if position % 2 else indent + 2, fresh=position % 2 == 1)
    return True


# --- parts of forms, data ----------------------------------------------------------------------------------------


def _filled(page: Page) -> bool:
    """Items from the bracket on, filling the lines; wide compound items one per line."""
    indent = page.start + 1
    found = [range(position, position + 1) for position in range(len(page.parts))]
    if page.has_rows or _is_matrix(page) or _are_rows(page, indent):
        for unit in found:
            write_unit(page, unit, indent, unit.start > 0)
    else:
        fill(page, found, indent, _even_count(page, indent))
    return True


def _even_count(page: Page, indent: int) -> int:
    """How many compound items to put on a line so that the lines are even and no more than needed; 0: any number."""
    widths = [page.flat_width(position) for position in range(len(page.parts))]
    known = [width for width in widths if width is not None]
    if not known or len(known) < len(widths) or any(isinstance(part, Atom) for part in page.parts):
        return 0
    lines, column = 1, indent
    for width in known:
        if column > indent and column + width > page.width:
            lines, column = lines + 1, indent
        column += width + 1
    most = -(-len(known) // lines)
    longest = max(sum(known[start : start + most]) for start in range(0, len(known), most))
    return most if indent + longest + most - 1 <= page.width else 0


def _is_matrix(page: Page) -> bool:
    """Whether the items are arrays of an array: rows."""
    return isinstance(page.datum, ArrayDatum) and all(isinstance(part, ArrayDatum) for part in page.parts)


def _are_rows(page: Page, indent: int) -> bool:
    """Whether the items of a list of lists are so wide that each one has a line."""
    total = 0
    for position, part in enumerate(page.parts):
        width = page.flat_width(position)
        if isinstance(part, Atom):
            return False
        if width is None:
            return True
        total += width + 1
    return indent + _ROW * total / max(len(page.parts), 1) > page.width + 1


def _signature(page: Page) -> bool:
    """A function's name, its parameters filling the lines under the first one."""
    if not page.parts:
        return True
    page.item(0, page.start + 1)
    fill(page, [range(position, position + 1) for position in range(1, len(page.parts))], page.column + 1)
    return True


def _listed(page: Page) -> bool:
    """Every item on a line of its own, from the bracket on."""
    for unit in units(page, 0):
        write_unit(page, unit, page.start + 1, unit.start > 0)
    return True


def _glued_binding(page: Page) -> bool:
    """``(name value``, the value's lines under each other."""
    if not page.parts:
        return True
    page.item(0, page.start + 1)
    under = page.column + 1
    for position in range(1, len(page.parts)):
        page.item(position, under, position > 1)
    return True


def _clause(page: Page) -> bool:
    """``(test`` and the body under the test; ``=>`` stays with its function."""
    arrow = False
    for position, part in enumerate(page.parts):
        page.item(position, page.start + 1, position > 0 and not arrow)
        arrow = isinstance(part, Atom) and part.value == "=>"
    return True


_SPECIAL: tuple[Style, ...] = (_special,)
_STYLES: dict[HeadKind, tuple[Style, ...]] = {
    **dict.fromkeys(
        (HeadKind.SPECIAL, HeadKind.IF, HeadKind.BODIED, HeadKind.DEFINE, HeadKind.LAMBDA, HeadKind.LET), _SPECIAL
    ),
    **dict.fromkeys((HeadKind.FOR, HeadKind.DO, HeadKind.GUARD, HeadKind.BIND, HeadKind.CLAUSES), _SPECIAL),
    HeadKind.ORDINARY: (
        *(_function_first, _keyed_as_written, _ordinary),
        *(_as_written, _as_written_below, _hugging, last_resort),
    ),
    HeadKind.CALL: (_as_written, _call),
    HeadKind.TRANSFORM: (_transform, last_resort, _pose_below),
    HeadKind.ALIGNED: (_as_written, _filled_operands, _aligned, last_resort),
    HeadKind.TABLE: (_table,),
    HeadKind.QUOTE: (last_resort,),
    HeadKind.QUASIQUOTE: (last_resort,),
    **dict.fromkeys((HeadKind.ARRAY, HeadKind.DATA), (_data_as_written, _filled)),
    HeadKind.PARAMETERS: (_filled,),
    **dict.fromkeys((HeadKind.GROUP, HeadKind.BINDINGS), (_listed,)),
    HeadKind.BINDING: (_glued_binding, last_resort),
    HeadKind.CLAUSE: (_clause,),
    HeadKind.SIGNATURE: (_signature,),
}
