"""Parts of a list that stay together on a line, and writing them: one per line, or as many as fit."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, TypeAlias

from scenelang.grammar.layout_rules import is_ellipsis, is_keyword

if TYPE_CHECKING:
    from scenelang.grammar.layout_page import Page

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
