"""The styles of the layout: how a list that does not fit a line is spread over several.

A style writes the parts of a page and returns True; False: it does not suit this list, and the next one is tried on a
fresh page.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import takewhile
from typing import TYPE_CHECKING, TypeAlias

from scenelang.grammar.datum import ArrayDatum, Atom
from scenelang.grammar.layout_rules import EVEN_HEADS, WEIGHTY, Kind, Shape, head_of, is_keyword
from scenelang.grammar.layout_units import Unit, fill, unit_width, units, write_unit, write_units

if TYPE_CHECKING:
    from scenelang.grammar.layout_page import Page

Style: TypeAlias = "Callable[[Page], bool]"

_ROW = 3  # compound items fill lines only where so many fit one
_SHORT = 26  # a quoted list up to this width counts as a short item


def styles_of(shape: Shape) -> Sequence[Style]:
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
    before_function = shape is not None and shape.kind is Kind.LAMBDA
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
    return shape is not None and shape.kind is Kind.LAMBDA and _aligned(page)


def _hugging(page: Page) -> bool:
    """``(f (g x`` with the operands of the only operand under each other."""
    shape = page.kind_shape(1) if len(page.parts) == 2 else None
    return shape is not None and shape.kind in (Kind.ORDINARY, Kind.ALIGNED) and _aligned(page)


# --- lines of an author --------------------------------------------------------------------------------------------


def _as_written(page: Page) -> bool:
    """The operands on the lines that their author gave them: under the first one, or indented by two where that is on
    a line of its own or there are keywords."""
    breaks = page.breaks
    if breaks is None or len(page.parts) < 2:
        return False
    if page.shape.kind is Kind.CALL:
        return _on_lines(page, breaks, True)
    below = breaks[1]
    if page.shape.kind is Kind.ALIGNED and (below or not any(breaks[2:])):
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
        fresh = breaks[unit.start] and not (unit.start == 1 and page.shape.kind is Kind.CALL)
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
    upright = shape is None or shape.kind in (Kind.CALL, Kind.TRANSFORM)
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
    constant = shape.kind in (Kind.ARRAY, Kind.DATA, Kind.QUOTE)
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
_STYLES: dict[Kind, tuple[Style, ...]] = {
    **dict.fromkeys((Kind.SPECIAL, Kind.IF, Kind.BODIED, Kind.DEFINE, Kind.LAMBDA, Kind.LET), _SPECIAL),
    **dict.fromkeys((Kind.FOR, Kind.DO, Kind.GUARD, Kind.BIND, Kind.CLAUSES), _SPECIAL),
    Kind.ORDINARY: (
        *(_function_first, _keyed_as_written, _ordinary),
        *(_as_written, _as_written_below, _hugging, last_resort),
    ),
    Kind.CALL: (_as_written, _call),
    Kind.TRANSFORM: (_transform, last_resort, _pose_below),
    Kind.ALIGNED: (_as_written, _filled_operands, _aligned, last_resort),
    Kind.TABLE: (_table,),
    Kind.QUOTE: (last_resort,),
    Kind.QUASIQUOTE: (last_resort,),
    **dict.fromkeys((Kind.ARRAY, Kind.DATA), (_data_as_written, _filled)),
    Kind.PARAMETERS: (_filled,),
    **dict.fromkeys((Kind.GROUP, Kind.BINDINGS), (_listed,)),
    Kind.BINDING: (_glued_binding, last_resort),
    Kind.CLAUSE: (_clause,),
    Kind.SIGNATURE: (_signature,),
}
