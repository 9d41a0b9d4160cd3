"""Layout styles: how a list that does not fit on one line is spread over several.

A style writes the parts of a list onto a page and returns True. If it returns False, it does not suit this list, and
the next style is tried on a fresh page.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from enum import Enum, auto
from itertools import takewhile
from typing import TYPE_CHECKING, NamedTuple, TypeAlias

from scenelang.grammar.datum import ArrayDatum, Atom, Datum, Keyword, ListDatum, Symbol

if TYPE_CHECKING:
    from scenelang.grammar.layout import Page


# Layout rules by head: which operands are on the line of the head, which parts are bodies, bindings, clauses or data,
# and which forms always take several lines.


class Role(Enum):
    """Syntactic role of a datum in the enclosing form."""

    TOP = auto()
    BODY = auto()  # a form of a body
    CODE = auto()
    FUNCTION = auto()  # the function bound by `bind`
    DATA = auto()
    BINDINGS = auto()
    BINDING = auto()
    CLAUSE = auto()
    PARAMETERS = auto()
    SIGNATURE = auto()


class HeadKind(Enum):
    """Layout category of a datum that does not fit on one line."""

    ORDINARY = auto()
    SPECIAL = auto()  # some operands on the head's line, the others indented by two
    IF = auto()
    BODIED = auto()  # SPECIAL; the other operands are a body
    DEFINE = auto()
    LAMBDA = auto()
    LET = auto()
    FOR = auto()
    DO = auto()
    GUARD = auto()
    BIND = auto()
    CLAUSES = auto()  # SPECIAL; the other operands are clauses
    CALL = auto()  # keyword pairs fill the lines
    TRANSFORM = auto()
    ALIGNED = auto()  # operands aligned under the first operand
    TABLE = auto()
    QUOTE = auto()
    QUASIQUOTE = auto()
    GROUP = auto()  # a list in code whose head is not a symbol
    ARRAY = auto()
    DATA = auto()
    BINDINGS = auto()
    BINDING = auto()
    CLAUSE = auto()
    PARAMETERS = auto()
    SIGNATURE = auto()


class HeadShape(NamedTuple):
    """Layout category of a datum, and the number ``inline_count`` of operands on the line of the head."""

    kind: HeadKind
    inline_count: int = 0


WITH_BODY = frozenset(
    (HeadKind.BODIED, HeadKind.DEFINE, HeadKind.LAMBDA, HeadKind.LET, HeadKind.FOR, HeadKind.DO, HeadKind.GUARD)
)
# a value of these kinds does not share a line with other keyword pairs
WEIGHTY = WITH_BODY | {HeadKind.CALL, HeadKind.TRANSFORM, HeadKind.CLAUSES}
# for these kinds, the style with the fewest lines is used rather than the first one that fits
SHORTEST = frozenset((HeadKind.TRANSFORM,))
# heads with equivalent operands: either all or none of them are on the line of the head
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
    *("sin", "cos", "tan", "asin", "acos", "atan", "deg", "to-degrees", "floor", "ceiling", "round"),
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
_COMBINATORS = {"ring": 2, "grid": 1, "mirror": 1, "align": 2, "on-top-of": 2, "attach": 2, "scatter": 2, "jitter": 1}
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
    """Return the shape of every head that is not laid out as an ordinary function call."""
    shapes = {}
    for name, indent in indents.items():
        kind = HeadKind.FOR if name.startswith(("for/", "for*")) or name == "for" else HeadKind.SPECIAL
        kind = HeadKind.ALIGNED if indent is None else _WHERE_INDENTED.get(name, kind)
        shapes[name] = HeadShape(kind, indent or 0)
    for name, kind in _ALWAYS.items():
        shapes[name] = HeadShape(kind, 1)
    for name, count in _COMBINATORS.items():
        shapes[name] = HeadShape(HeadKind.CALL, count)
    return shapes


def head_of(datum: Datum) -> str | None:
    """Return the symbol at the head of a list, or None."""
    if isinstance(datum, ListDatum) and datum.items:
        head = datum.items[0]
        if isinstance(head, Atom) and type(head.value) is Symbol:
            return head.value
    return None


def is_keyword(datum: Datum) -> bool:
    """Return whether ``datum`` is a keyword such as ``:scale``."""
    return isinstance(datum, Atom) and type(datum.value) is Keyword


def is_ellipsis(datum: Datum) -> bool:
    """Return whether ``datum`` is the ellipsis `...` of a macro's pattern or template."""
    return isinstance(datum, Atom) and type(datum.value) is Symbol and datum.value == "..."


def shape_of(datum: ListDatum | ArrayDatum, role: Role, shapes: Mapping[str, HeadShape]) -> HeadShape:
    """Return the shape of a compound datum in its role."""
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
    """Return the role of every part of a datum in its layout, including its tail.

    Parameters
    ----------
    datum
        List or array.
    shape
        Layout of lists with its head.
    parts
        Items of the datum, and its tail.
    """
    kind, inline_count = shape
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
        roles[1 + inline_count :] = [Role.BODY] * (count - 1 - inline_count)
    elif kind is HeadKind.CLAUSES:
        roles[1 + inline_count :] = [Role.CLAUSE] * (count - 1 - inline_count)
    _set_head_roles(kind, inline_count, parts, roles)
    return roles


def _set_head_roles(kind: HeadKind, inline_count: int, parts: Sequence[Datum], roles: list[Role]) -> None:
    """Set the roles of the operands on the line of the head."""
    if len(parts) < 2:
        return
    if kind is HeadKind.LAMBDA:
        roles[1] = Role.PARAMETERS
    elif kind is HeadKind.DEFINE and isinstance(parts[1], ListDatum):
        roles[1] = Role.SIGNATURE
    elif kind is HeadKind.LET:
        roles[min(inline_count, len(parts) - 1)] = Role.BINDINGS
    elif kind is HeadKind.FOR:
        inline_count = min(inline_count, len(parts) - 1)
        roles[1 : 1 + inline_count] = [Role.BINDINGS] * inline_count
    elif kind is HeadKind.DO:
        roles[1:3] = [Role.BINDINGS, Role.CLAUSE][: len(parts) - 1]
    elif kind is HeadKind.GUARD:
        roles[1] = Role.CLAUSE
    elif kind is HeadKind.BIND:
        roles[-1] = Role.FUNCTION


def takes_lines(datum: ListDatum | ArrayDatum, shape: HeadShape, role: Role) -> bool:
    """Return whether ``datum`` always takes several lines, even if it fits on one.

    This applies to top-level functions, Scheme's loops, and bodies and clauses of several forms.
    """
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
        if kind is HeadKind.DO or (kind is HeadKind.LET and shape.inline_count == 2):
            return True
        return count > 2 + shape.inline_count
    if kind is HeadKind.CLAUSES:
        return count > 2 + shape.inline_count
    if kind is HeadKind.CLAUSE:
        return count > 2 and not (isinstance(items[1], Atom) and items[1].value == "=>")
    if kind is HeadKind.IF and (role is Role.BODY or role is Role.TOP):
        return len(items) == 4 and isinstance(items[2], ListDatum) and isinstance(items[3], ListDatum)
    return False


def parts_of(datum: ListDatum | ArrayDatum) -> Sequence[Datum]:
    """Return the items of a datum, followed by its tail if it has one."""
    if isinstance(datum, ListDatum) and datum.tail is not None:
        return (*datum.items, datum.tail)
    return datum.items


# --- line breaks of an author ----------------------------------------------------------------------------------------

_PASSING = frozenset(("set!", "define-values"))  # a value that fits on the line of the head stays there
_BY_HEAD_LINE = WITH_BODY | {HeadKind.BIND, HeadKind.CLAUSES, HeadKind.IF, HeadKind.SPECIAL}


def stays_broken(
    datum: ListDatum | ArrayDatum, shape: HeadShape, parts: Sequence[Datum], breaks: Sequence[bool]
) -> bool:
    """Return whether the author's line breaks are preserved although the datum fits on one line.

    This applies to a body that starts on a new line, a function as the last operand, members of a union, a pose below
    its shape, and bindings below each other. ``breaks`` states which parts start a line.
    """
    kind, inline_count = shape
    if kind in _BY_HEAD_LINE:
        if kind is HeadKind.DEFINE and len(parts) > 1 and isinstance(parts[1], Atom):
            return False
        return any(breaks[1 + inline_count : 2 + inline_count]) and head_of(datum) not in _PASSING
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
    """Return whether the author put every row of tabular data, or every keyword pair of a call, on a separate line.

    Parameters
    ----------
    datum
        List or array.
    shape
        Layout of lists with its head.
    parts
        Items of the datum.
    breaks
        Whether the author broke the line before each part.
    """
    if shape.kind is HeadKind.DATA or shape.kind is HeadKind.ARRAY:
        return len(parts) > 1 and all(breaks[1:]) and not any(isinstance(part, Atom) for part in parts)
    if shape.kind is HeadKind.CALL or shape.kind is HeadKind.ORDINARY:
        keys = [place for place, part in enumerate(parts) if place and is_keyword(part)]
        return len(keys) > 1 and all(breaks[place] for place in keys)
    return False


# Units, the parts of a list that stay together on a line, are written one per line or filled up to the width.


Unit: TypeAlias = range  # positions of parts that stay together: a keyword and its value, or one part


def units(page: Page, first: int) -> list[Unit]:
    """Group the parts from ``first`` on: a keyword with its value, `...` with the part it repeats.

    In a call, the value may be a keyword too, as in ``(align a b :x :min)``; elsewhere keywords in a row are data.
    """
    parts, grouped, position = page.parts, [], first
    is_call = page.shape.kind in (HeadKind.CALL, HeadKind.ORDINARY)
    while position < len(parts):
        stop = position + 1
        if is_keyword(parts[position]) and stop < len(parts) and (is_call or not is_keyword(parts[stop])):
            stop += 1
        while stop < len(parts) and is_ellipsis(parts[stop]):
            stop += 1
        grouped.append(range(position, stop))
        position = stop
    return grouped


def write_units(page: Page, group: Sequence[Unit], indent: int) -> None:
    """Write one unit per line."""
    for unit in group:
        write_unit(page, unit, indent, fresh=True)


def write_unit(page: Page, unit: Unit, indent: int, *, fresh: bool) -> None:
    """Write the parts of a unit, on a new line if ``fresh``; a break inside it is indented further."""
    page.item(unit.start, indent, fresh=fresh)
    for position in unit[1:]:
        page.item(position, indent + 2)


def unit_width(page: Page, unit: Unit) -> int | None:
    """Return the width of a unit on one line, or None if it takes several."""
    width = len(unit) - 1
    for position in unit:
        flat = page.flat_width(position)
        if flat is None:
            return None
        width += flat
    return width


def fill(page: Page, group: Sequence[Unit], indent: int, most: int = 0) -> None:
    """Write as many units per line as fit.

    Parameters
    ----------
    page
        Page to write on.
    group
        Units to write. One that takes several lines does not share them with others.
    indent
        Column of the lines after the first.
    most
        Maximum number of units on a line; 0 for no maximum.
    """
    alone = False  # whether the previous unit takes several lines
    for count, unit in enumerate(group):
        width = unit_width(page, unit)
        fresh = alone or width is None or page.column + 1 + width > page.width
        fresh = fresh or (most > 0 and count % most == 0)
        if unit.start == 0 or (page.column == indent and not alone):
            fresh = False
        write_unit(page, unit, indent, fresh=fresh)
        alone = width is None or indent + width > page.width


Style: TypeAlias = "Callable[[Page], bool]"

_MIN_FILLED_ITEMS = 3  # compound items that must fit on a line for filling; fewer are rows, which read better apart
_MAX_SHORT_WIDTH = 26  # columns of a quoted list or array that counts as short: three fit on a line


def styles_of(shape: HeadShape) -> Sequence[Style]:
    """Return the styles of a shape, best first; the last one accepts any list."""
    return _STYLES[shape.kind]


def last_resort(page: Page) -> bool:
    """Write ``(f`` and every operand on a separate line, indented by two."""
    if page.parts:
        page.item(0, page.start + 1)
    write_units(page, units(page, 1), page.start + 2)
    return True


# --- heads with operands on their line ---------------------------------------------------------------------------


def _special(page: Page) -> bool:
    """Write ``(head operand`` and the other operands indented by two.

    Operands of the head's line that are too long for it are aligned under the first.
    """
    return _with_inline(page, page.shape.inline_count)


def _with_inline(page: Page, inline_count: int) -> bool:
    """Write the head with ``inline_count`` operands on its line, and the others indented by two."""
    inline_count = min(inline_count, len(page.parts) - 1)
    page.item(0, page.start + 1)
    under = page.column + 1
    for position in range(1, 1 + inline_count):
        page.item(position, under, fresh=position > 1 and not page.fits(position, page.column + 1))
    write_units(page, units(page, 1 + inline_count), page.start + 2)
    return True


def _keyed_as_written(page: Page) -> bool:
    """Write a call with keyword arguments with the author's line breaks."""
    return _has_keywords(page) and _as_written(page)


def _has_keywords(page: Page) -> bool:
    """Return whether a call has keyword arguments."""
    return any(is_keyword(part) for part in page.parts[1:])


def _ordinary(page: Page) -> bool:
    """Write a call with the operands below each other, or with leading short ones on the line of the head."""
    count = len(page.parts)
    if _has_keywords(page):
        return _pairs(page, 0)
    if count > 2 and head_of(page.datum) not in EVEN_HEADS and _leads(page):
        return _with_inline(page, count - 2)
    if not all(isinstance(part, Atom) for part in page.parts):
        return False
    has_lines = any(page.holds_lines(position) for position in range(count))
    return _aligned(page) if has_lines else _pairs(page, 0)


def _leads(page: Page) -> bool:
    """Return whether all operands but the last go on the line of the head: atoms, or short ones before a lambda."""
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
    """Write ``(map (lambda (x)`` with the other operands aligned under the function."""
    shape = page.kind_shape(1) if len(page.parts) > 2 else None
    return shape is not None and shape.kind is HeadKind.LAMBDA and _aligned(page)


def _hugging(page: Page) -> bool:
    """Write ``(f (g x`` with the operands of the only operand below each other."""
    shape = page.kind_shape(1) if len(page.parts) == 2 else None
    return shape is not None and shape.kind in (HeadKind.ORDINARY, HeadKind.ALIGNED) and _aligned(page)


# --- lines of an author --------------------------------------------------------------------------------------------


def _as_written(page: Page) -> bool:
    """Write the operands with the author's line breaks.

    They are aligned under the first operand, or indented by two if it is on a separate line or there are keywords.
    """
    breaks = page.breaks
    if breaks is None or len(page.parts) < 2:
        return False
    if page.shape.kind is HeadKind.CALL:
        return _on_lines(page, breaks, is_shallow=True)
    below = breaks[1]
    if page.shape.kind is HeadKind.ALIGNED and (below or not any(breaks[2:])):
        return False
    if head_of(page.datum) in EVEN_HEADS and not below:
        return False
    begins = page.start + 2 + (page.flat_width(0) or 0)  # column of the first operand on the line of the head
    keyed = page.fits(1, begins) and any(is_keyword(part) for part in page.parts)
    return _on_lines(page, breaks, is_shallow=below or keyed)


def _as_written_below(page: Page) -> bool:
    """Like ``_as_written``, with the lines after the first indented by two."""
    breaks = page.breaks
    if breaks is None or len(page.parts) < 3 or head_of(page.datum) in EVEN_HEADS:
        return False
    return _on_lines(page, breaks, is_shallow=True)


def _on_lines(page: Page, breaks: Sequence[bool], *, is_shallow: bool) -> bool:
    """Write the operands with the given line breaks, indented by two if shallow, else under the first operand."""
    page.item(0, page.start + 1)
    indent = page.start + 2 if is_shallow else page.column + 1
    filled = False  # whether the previous unit took several lines
    for unit in units(page, 1):
        fresh = breaks[unit.start] and not (unit.start == 1 and page.shape.kind is HeadKind.CALL)
        width = unit_width(page, unit)
        if fresh and width is not None and page.start + 2 + width <= page.width < indent + width:
            return False  # it fits on a line, but not at this indentation
        if unit.start > 1 and width is not None and page.column + 1 + width > page.width:
            fresh = True
        write_unit(page, unit, indent, fresh=fresh or filled)
        filled = width is None
    return True


def _data_as_written(page: Page) -> bool:
    """Write data with the author's line breaks."""
    breaks = page.breaks
    if breaks is None or not any(breaks[1:]) or page.has_rows or _is_matrix(page):
        return False
    for position in range(len(page.parts)):
        page.item(position, page.start + 1, fresh=position > 0 and breaks[position])
    return True


# --- keyword pairs -----------------------------------------------------------------------------------------------


def _call(page: Page) -> bool:
    """Write ``(call "word" :key value`` with as many pairs per line as fit."""
    return _pairs(page, 1)


def _pairs(page: Page, inline_count: int) -> bool:
    """Write the first operands and as many pairs per line as fit, or one pair per line if a value is weighty."""
    indent = page.start + 2
    page.item(0, page.start + 1)
    inline_count = min(inline_count, len(page.parts) - 1)
    for position in range(1, 1 + inline_count):
        page.item(position, indent)
    group = units(page, 1 + inline_count)
    if page.has_rows or any(_is_weighty(page, unit, indent) for unit in group):
        atoms = []
        if inline_count:
            atoms = list(takewhile(lambda unit: len(unit) == 1 and isinstance(page.parts[unit.start], Atom), group))
        fill(page, atoms, indent)
        write_units(page, group[len(atoms) :], indent)
    else:
        leading = list(takewhile(lambda unit: not is_keyword(page.parts[unit.start]), group))
        fill(page, leading, indent)
        keyed = _with_series(page, group[len(leading) :], indent)
        if leading and keyed and page.broken:
            write_unit(page, keyed.pop(0), indent, fresh=True)
        fill(page, keyed, indent)
    return True


def _is_weighty(page: Page, unit: Unit, indent: int) -> bool:
    """Return whether a unit needs a separate line: it takes several lines, or its value is a shape or has a body."""
    width = unit_width(page, unit)
    shape = page.kind_shape(unit[-1])
    return width is None or indent + width > page.width or (shape is not None and shape.kind in WEIGHTY)


def _with_series(page: Page, pairs: Sequence[Unit], indent: int) -> list[Unit]:
    """Join pairs with numbered keywords, such as ``:p0`` and ``:p1``, if they fit on one line."""
    joined: list[Unit] = []
    for unit in pairs:
        if joined and _continues(page, joined[-1], unit):
            both = range(joined[-1].start, unit.stop)
            width = unit_width(page, both)
            if width is not None and indent + width <= page.width:
                joined[-1] = both
                continue
        joined.append(unit)
    return joined


def _continues(page: Page, unit: Unit, following: Unit) -> bool:
    """Return whether two keywords differ in a final digit only."""
    names = [page.parts[place.start] for place in (unit, following)]
    if not all(isinstance(name, Atom) and is_keyword(name) for name in names):
        return False
    first, second = (str(name.value) for name in names if isinstance(name, Atom))
    return first[:-1] == second[:-1] and first[-1:].isdigit() and second[-1:].isdigit()


# --- aligned operands --------------------------------------------------------------------------------------------


def _transform(page: Page) -> bool:
    """Write the shape on the line of the head and its pose below it."""
    if len(page.parts) != 3:
        return False
    shape = page.kind_shape(1)
    upright = shape is None or shape.kind in (HeadKind.CALL, HeadKind.TRANSFORM)
    if not upright and not page.fits(1, page.column + len("transform ")):
        return False
    return _aligned(page)


def _pose_below(page: Page) -> bool:
    """Write ``(transform name`` and below it a pose that is too long to be aligned under the name."""
    return len(page.parts) == 3 and isinstance(page.parts[1], Atom) and _with_inline(page, 1)


def _aligned(page: Page) -> bool:
    """Align operands under the first operand; adjacent atoms share a line."""
    if len(page.parts) < 2:
        return False
    page.item(0, page.start + 1)
    indent = page.column + 1
    was_atom = False
    for unit in units(page, 1):
        is_atom = all(isinstance(page.parts[position], Atom) for position in unit)
        width = unit_width(page, unit)
        shares = is_atom and was_atom and width is not None and page.column + 1 + width <= page.width
        write_unit(page, unit, indent, fresh=unit.start > 1 and not shares)
        was_atom = is_atom
    return True


def _filled_operands(page: Page) -> bool:
    """Fill lines with the constants after a head such as ``list``, aligned under the first one."""
    if len(page.parts) < 4 or not all(_is_short(page, position) for position in range(1, len(page.parts))):
        return False
    page.item(0, page.start + 1)
    indent = page.column + 1
    page.item(1, indent)
    fill(page, units(page, 2), indent)
    return True


def _is_short(page: Page, position: int) -> bool:
    """Return whether a part is an atom or a short constant, several of which share a line."""
    part = page.parts[position]
    shape = page.kind_shape(position)
    if isinstance(part, Atom) or shape is None:
        return True
    width = page.flat_width(position)
    constant = shape.kind in (HeadKind.ARRAY, HeadKind.DATA, HeadKind.QUOTE)
    return constant and width is not None and width <= _MAX_SHORT_WIDTH


def _table(page: Page) -> bool:
    """Write one key with its value per line."""
    page.item(0, page.start + 1)
    indent = page.start + 2
    for position in range(1, len(page.parts)):
        page.item(position, indent if position % 2 else indent + 2, fresh=position % 2 == 1)
    return True


# --- parts of forms, data ----------------------------------------------------------------------------------------


def _filled(page: Page) -> bool:
    """Fill lines with the items, aligned after the bracket; wide compound items are written one per line."""
    indent = page.start + 1
    items = [range(position, position + 1) for position in range(len(page.parts))]
    if page.has_rows or _is_matrix(page) or _are_rows(page, indent):
        for unit in items:
            write_unit(page, unit, indent, fresh=unit.start > 0)
    else:
        fill(page, items, indent, _even_count(page, indent))
    return True


def _even_count(page: Page, indent: int) -> int:
    """Return how many compound items per line give even lines without adding lines, or 0 for no limit."""
    widths = [page.flat_width(position) for position in range(len(page.parts))]
    flat_widths = [width for width in widths if width is not None]
    if not flat_widths or len(flat_widths) < len(widths) or any(isinstance(part, Atom) for part in page.parts):
        return 0
    lines, column = 1, indent
    for width in flat_widths:
        if column > indent and column + width > page.width:
            lines, column = lines + 1, indent
        column += width + 1
    most = -(-len(flat_widths) // lines)
    longest = max(sum(flat_widths[start : start + most]) for start in range(0, len(flat_widths), most))
    return most if indent + longest + most - 1 <= page.width else 0


def _is_matrix(page: Page) -> bool:
    """Return whether the datum is an array of arrays, whose items are rows."""
    return isinstance(page.datum, ArrayDatum) and all(isinstance(part, ArrayDatum) for part in page.parts)


def _are_rows(page: Page, indent: int) -> bool:
    """Return whether the items of a list of lists are wide enough to be written one per line."""
    total = 0
    for position, part in enumerate(page.parts):
        width = page.flat_width(position)
        if isinstance(part, Atom):
            return False
        if width is None:
            return True
        total += width + 1
    return indent + _MIN_FILLED_ITEMS * total / max(len(page.parts), 1) > page.width + 1


def _signature(page: Page) -> bool:
    """Write a function's name and fill lines with its parameters, aligned under the first one."""
    if not page.parts:
        return True
    page.item(0, page.start + 1)
    fill(page, [range(position, position + 1) for position in range(1, len(page.parts))], page.column + 1)
    return True


def _listed(page: Page) -> bool:
    """Write every item on a separate line, aligned after the bracket."""
    for unit in units(page, 0):
        write_unit(page, unit, page.start + 1, fresh=unit.start > 0)
    return True


def _glued_binding(page: Page) -> bool:
    """Write ``(name value`` with the lines of the value below each other."""
    if not page.parts:
        return True
    page.item(0, page.start + 1)
    under = page.column + 1
    for position in range(1, len(page.parts)):
        page.item(position, under, fresh=position > 1)
    return True


def _clause(page: Page) -> bool:
    """Write ``(test`` with the body below the test; ``=>`` stays with its function."""
    arrow = False
    for position, part in enumerate(page.parts):
        page.item(position, page.start + 1, fresh=position > 0 and not arrow)
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
