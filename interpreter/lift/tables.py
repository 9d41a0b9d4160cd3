"""Rules of lifting for data: similar parts become a loop over a table, and columns of tables become formulas.

A column of numbers that follows the index, and pairs of columns on a circle, are written as arithmetic, from which
``patterns`` finds rings: the inverse of unrolling a loop, as in Szalinski (see there).
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from scenelang.grammar.datum import Keyword, Span
from scenelang.interpreter.expand.forms import FORMS
from scenelang.interpreter.lift.patterns import accept, find_ring
from scenelang.interpreter.lift.simplify import gives_parts, is_part, shorten_number, vector_of
from scenelang.interpreter.lift.tree import (
    CodeTree,
    OpenProgram,
    Poly,
    array,
    atom,
    bound_names,
    code,
    copied,
    expression,
    form,
    listed,
    names,
    same,
    size,
    symbol,
)


def find(program: OpenProgram, top: CodeTree) -> bool:
    """Apply the rules of this file to a top-level form."""
    changed = False
    for node in reversed(list(code(top))):
        if node.head == "for/union":
            changed |= _formulas(program, node)
        elif node.head == "union":
            changed |= _table(node)
    return changed


# --- similar parts -------------------------------------------------------------------------------------------------

_MIN_ROWS = 3  # similar forms that become a loop over a table
_MAX_COLUMNS = 4  # of that table: variables of the loop
_GAIN = 0.75  # a table must be this much shorter than the parts


def _table(node: CodeTree) -> bool:
    """Write similar members of a union as a loop over a table of their differences."""
    assert node.items is not None
    members, position, changed = node.operands, 0, False
    kept: list[CodeTree] = []
    while position < len(members):
        run = _run(members, position)
        loop = _table_loop(members[position : position + run]) if run >= _MIN_ROWS else None
        if loop is not None:
            kept.append(loop)
            position += run
            changed = True
        else:
            kept.append(members[position])
            position += 1
    if changed:
        node.items[1:] = kept
        if len(kept) == 1 and gives_parts(kept[0]):
            node.become(kept[0])
    return changed


def _run(members: Sequence[CodeTree], start: int) -> int:
    """Return how many members from ``start`` on differ from it in constants only."""
    first = members[start]
    if not is_part(first) and first.items is None:
        return 1
    end = start + 1
    while end < len(members) and _is_similar(first, members[end]) and not members[end].trivia.blank:
        end += 1
    return end - start


def _is_similar(a: CodeTree, b: CodeTree) -> bool:
    if a.items is None or b.items is None:
        if a.items is not b.items:
            return False
        if _is_cell(a) and _is_cell(b):
            return (type(a.value) is str) is (type(b.value) is str)
        return type(a.value) is type(b.value) and a.value == b.value
    if a.is_array is not b.is_array or len(a.items) != len(b.items) or a.tail is not None or b.tail is not None:
        return False
    if a.head == "quote" or b.head == "quote":
        return same(a, b)
    return all(map(_is_similar, a.items, b.items))


def _is_cell(node: CodeTree) -> bool:
    """Return whether a node may differ between the rows of a table."""
    return node.is_number or (node.items is None and type(node.value) is str)


@dataclass(frozen=True, slots=True)
class _Column:
    """Cells of a table, as paths from each row's part."""

    path: tuple[int, ...]
    name: str
    cells: tuple[CodeTree, ...]


def _table_loop(rows: Sequence[CodeTree]) -> CodeTree | None:
    if any(not same(copied(row), copied(rows[0])) for row in rows[1:]):
        columns = list(_columns(rows, rows[0], ()))
    else:
        return None
    span = rows[0].span
    taken = {name for row in rows for name in names(row)} | FORMS.keys()
    columns = _named(columns, taken)
    if not columns or len(columns) > _MAX_COLUMNS:
        return None
    template = _replaced(rows[0], {column.path: column.name for column in columns})
    comments = [row.trivia for row in rows]
    if any(trivia.before or trivia.after for trivia in comments[1:]) and any(t.before for t in comments[1:]):
        return None
    loop = _product_loop(columns, template) or _row_loop(columns, template)
    notes = [trivia.after.lstrip("; ") for trivia in comments if trivia.after]
    if size(loop) > _GAIN * sum(map(size, rows)):
        return None
    if notes and len(notes) == len(rows) and len(set(notes)) > 1:
        return None  # each part has its own meaning
    loop.span = span
    loop.trivia = rows[0].trivia
    return loop


def _columns(rows: Sequence[CodeTree], first: CodeTree, path: tuple[int, ...], name: str = "") -> Iterator[_Column]:
    """Find what differs between rows. A vector of which several components differ is one column."""
    if first.items is None:
        if not all(same(row, first) for row in rows):
            yield _Column(path, name, tuple(rows))
        return
    if first.is_array and _is_vector(rows):
        different = [
            k
            for k in range(len(first.items))
            if not all(same(row.items[k], first.items[k]) for row in rows if row.items)
        ]
        if len(different) > 1 and all(row.is_array and all(map(_is_cell, row.items or ())) for row in rows):
            if not (len(different) == 2 and _is_product(rows, different)):
                yield _Column(path, name or "p", tuple(rows))
                return
    for position, item in enumerate(first.items):
        inner = [row.items[position] for row in rows if row.items is not None]
        before = first.items[position - 1].value if position else None
        own = str(before) if type(before) is Keyword else _place(first, position, name)
        yield from _columns(inner, item, (*path, position), own)


def _is_vector(rows: Sequence[CodeTree]) -> bool:
    return all(row.is_array and row.items is not None and len(row.items) in (2, 3) for row in rows)


def _is_product(rows: Sequence[CodeTree], columns: Sequence[int]) -> bool:
    cells = [tuple(row.items[k].value for k in columns) for row in rows if row.items]
    outer = list(dict.fromkeys(cell[0] for cell in cells))
    inner = list(dict.fromkeys(cell[1] for cell in cells))
    return len(outer) > 1 and len(inner) > 1 and cells == [(a, b) for a in outer for b in inner]


def _place(node: CodeTree, position: int, name: str) -> str:
    if node.is_array and len(node.items or ()) == 3:
        return "xyz"[position]
    if node.head == "call" and position == 1:
        return "word"
    if node.head == "rotate" and position == 1:
        return "angle"
    return name or "value"


def _named(columns: Sequence[_Column], taken: set[str] | frozenset[str]) -> list[_Column]:
    """Merge columns with equal cells, and give each a name of its own."""
    named: list[_Column] = []
    used = set(taken)
    for column in columns:
        twin = next((one for one in named if all(map(same, one.cells, column.cells))), None)
        if twin is not None:
            named.append(_Column(column.path, twin.name, column.cells))
            continue
        stem = text = column.name
        number = 2
        while text in used:
            text = f"{stem}-{number}"
            number += 1
        used.add(text)
        named.append(_Column(column.path, text, column.cells))
    return named


def _replaced(node: CodeTree, variables: dict[tuple[int, ...], str], path: tuple[int, ...] = ()) -> CodeTree:
    if path in variables:
        return symbol(variables[path], node.span)
    if node.items is None:
        return copied(node)
    new = CodeTree(
        [_replaced(item, variables, (*path, position)) for position, item in enumerate(node.items)], None, node.span
    )
    new.is_array = node.is_array
    return new


def _unique(columns: Sequence[_Column]) -> list[_Column]:
    return list({column.name: column for column in columns}.values())


def _product_loop(columns: Sequence[_Column], template: CodeTree) -> CodeTree | None:
    """Return nested loops if the rows are all pairs of two columns' values, in order."""
    distinct = _unique(columns)
    if len(distinct) != 2 or any(cell.items is not None for column in distinct for cell in column.cells):
        return None
    values = [[cell.value for cell in column.cells] for column in distinct]
    for outer, inner in ((0, 1), (1, 0)):
        first = list(dict.fromkeys(values[outer]))
        second = list(dict.fromkeys(values[inner]))
        pairs = list(zip(values[outer], values[inner]))
        if len(first) > 1 and len(second) > 1 and pairs == [(a, b) for a in first for b in second]:
            clauses = [_clause(distinct[outer], len(second)), _clause(distinct[inner], 1, len(second))]
            return form("for*/union", listed(clauses, template.span), template, span=template.span)
    return None


def _clause(column: _Column, step: int, count: int | None = None) -> CodeTree:
    span = column.cells[0].span
    cells = column.cells[::step][:count]
    return listed([symbol(column.name, span), _quoted([_datum(cell) for cell in cells])], span)


def _row_loop(columns: Sequence[_Column], template: CodeTree) -> CodeTree:
    distinct, span = _unique(columns), template.span
    if len(distinct) == 1:
        clause = _clause(distinct[0], 1)
    else:
        rows = [listed([_datum(column.cells[k]) for column in distinct], span) for k in range(len(distinct[0].cells))]
        variables = listed([symbol(column.name, span) for column in distinct], span)
        clause = listed([variables, _quoted(rows)], span)
    return form("for/union", listed([clause], span), template, span=span)


def _quoted(items: Sequence[CodeTree]) -> CodeTree:
    return form("quote", listed(items, items[0].span), span=items[0].span)


def _datum(cell: CodeTree) -> CodeTree:
    """Return a cell as quoted data: an array is a list there."""
    new = copied(cell)
    if new.is_array:
        new.is_array = False
    return new


# --- formulas for tables -------------------------------------------------------------------------------------------

_MIN_FITTED = 4  # rows that a formula is fitted to
_ROUNDING = 1e-11  # of the largest coordinate


@dataclass(frozen=True, slots=True)
class _Table:
    """Loop over the rows of a quoted table of numbers: the cells by variable."""

    columns: dict[str, list[CodeTree]]
    count: int
    body: CodeTree


def _table_of(node: CodeTree) -> _Table | None:
    """Return a loop over a quoted table of at least ``_MIN_FITTED`` rows, None for other forms."""
    operands = node.operands
    clauses = operands[0].items if operands else None
    if node.head != "for/union" or len(operands) != 2 or clauses is None or len(clauses) != 1:
        return None
    pattern, sequence = clauses[0].items if clauses[0].items and len(clauses[0].items) == 2 else (None, None)
    if pattern is None or sequence is None or sequence.head != "quote" or not sequence.operands:
        return None
    rows = sequence.operands[0].items or []
    names_ = [pattern] if pattern.items is None else pattern.items
    if len(rows) < _MIN_FITTED or pattern.tail is not None or any(one.name is None for one in names_):
        return None
    # a name that the body binds again does not mean the column there
    if len({one.name for one in names_}) != len(names_) or set(_bound_inside(operands[1])) & {
        one.name for one in names_
    }:
        return None
    if pattern.items is None:
        return _Table({str(pattern.name): rows}, len(rows), operands[1])
    if any(row.items is None or row.tail is not None or len(row.items) != len(names_) for row in rows):
        return None
    cells = [[row.items[k] for row in rows if row.items] for k in range(len(names_))]
    return _Table({str(one.name): column for one, column in zip(names_, cells)}, len(rows), operands[1])


def _bound_inside(node: CodeTree) -> Iterator[str]:
    for one in code(node):
        yield from bound_names(one)


def _formulas(program: OpenProgram, node: CodeTree) -> bool:
    """Write a loop over a table whose columns follow formulas as a loop over the index, or as a ring."""
    table = _table_of(node)
    if table is None or not {"+", "-", "*", "/", "pi", "tau", "sin", "cos"} <= program.known:
        return False
    index = next((name for name in ("i", "j", "k", "step") if name not in names(table.body)), None)
    if index is None:
        return False
    body = copied(table.body, comments=True)
    columns = dict(table.columns)
    _split_vectors(body, columns)
    formulas = _fitted(body, columns, index, table.count)
    span = node.span
    for name in _placed_names(table.body) & table.columns.keys() - formulas.keys():
        for cell in table.columns[name]:
            shorten_number(cell)
    if not formulas:
        return False
    rest = {name: cells for name, cells in columns.items() if name not in formulas}
    body = _with_values(body, formulas)
    counter = listed([symbol(index, span), atom(table.count, span)], span)
    clauses = [counter, *_remaining(rest, span)]
    new = form("for/union", listed(clauses, span), body, span=span)
    if (not rest and size(new) >= size(node)) or not rest:
        find_ring(program, new)
    return accept(node, new)


def _remaining(columns: dict[str, list[CodeTree]], span: Span) -> list[CodeTree]:
    if not columns:
        return []
    if len(columns) == 1:
        ((name, cells),) = columns.items()
        return [listed([symbol(name, span), _quoted([copied(cell) for cell in cells])], span)]
    rows = [listed([copied(cell) for cell in row], span) for row in zip(*columns.values())]
    pattern = listed([symbol(name, span) for name in columns], span)
    return [listed([pattern, _quoted(rows)], span)]


def _split_vectors(body: CodeTree, columns: dict[str, list[CodeTree]]) -> None:
    """Split a column of points that is only used as ``(translate p)`` into its coordinates."""
    for name, cells in list(columns.items()):
        if any(
            cell.items is None or len(cell.items) != 3 or not all(x.is_number for x in cell.items) for cell in cells
        ):
            continue
        uses = [one for one in code(body) if one.head == "translate" and len(one.operands) == 1]
        uses = [one for one in uses if one.operands[0].name == name]
        if len(uses) != 1 or names(body)[name] != 1:
            continue
        span = uses[0].span
        parts = [f"{name}-{axis}" for axis in "xyz"]
        assert uses[0].items is not None
        uses[0].items[1] = array([symbol(part, span) for part in parts], span)
        del columns[name]
        for k, part in enumerate(parts):
            columns[part] = [cell.items[k] for cell in cells if cell.items]


def _fitted(body: CodeTree, columns: dict[str, list[CodeTree]], index: str, count: int) -> dict[str, CodeTree]:
    """Return expressions of the index for the columns that have one."""
    formulas: dict[str, CodeTree] = {}
    numbers = {
        name: [cell.value for cell in cells]
        for name, cells in columns.items()
        if all(cell.is_number and math.isfinite(cell.value) for cell in cells)
    }
    placed = _placed_names(body)
    for name, values in numbers.items():
        formula = _line_through(values, index, body.span, is_rounded=name in placed)
        if formula is not None:
            formulas[name] = formula
    for one in code(body):
        vector = vector_of(one)
        pair = (vector[0].name, vector[2].name) if vector is not None else (None, None)
        are_free = pair[0] in numbers and pair[1] in numbers and not {*pair} & formulas.keys()
        if are_free and pair[0] != pair[1]:
            x, z = str(pair[0]), str(pair[1])
            if x in placed and z in placed:
                circle = _circle_through(numbers[x], numbers[z], index, count, body.span)
                formulas |= dict(zip((x, z), circle)) if circle is not None else {}
    return formulas


def _placed_names(body: CodeTree) -> set[str]:
    """Names that occur only in the vectors of translations, where values may differ by rounding."""
    inside: Counter[str] = Counter()
    for one in code(body):
        vector = vector_of(one)
        for coordinate in vector or ():
            if coordinate.name is not None:
                inside[coordinate.name] += 1
    total = names(body)
    return {name for name, times in inside.items() if total[name] == times}


def _line_through(values: Sequence[float], index: str, span: Span, *, is_rounded: bool) -> CodeTree | None:
    """Return ``start + step * index`` for numbers that it gives: exactly, or up to rounding."""
    count, start = len(values), values[0]
    step = (values[-1] - start) / (count - 1)
    if all(type(value) is int for value in values) and step == round(step):
        step = round(step)
    largest = max(map(abs, values)) or 1.0
    for results, node in _lines(start, step, symbol(index, span), count):
        apart = max(abs(result - value) for result, value in zip(results, values))
        exact = all(result == value and type(result) is type(value) for result, value in zip(results, values))
        if exact or (is_rounded and apart <= _ROUNDING * largest):
            return node
    return None


def _lines(start: float, step: float, i: CodeTree, count: int) -> Iterator[tuple[list[float], CodeTree]]:
    """Iterate over ways to compute ``start + step * i``, which round differently: the numbers and the expression."""
    span = i.span
    for first, slope in dict.fromkeys(((start, step), (_short(start), _short(step)))):
        begin = atom(float(first) if isinstance(slope, float) else first, span)
        if slope == 0:
            yield [begin.value] * count, begin
            continue
        amount = abs(slope)
        times = i if type(amount) is int and amount == 1 else form("*", atom(amount, span), i, span=span)
        ways: list[tuple[list[float], CodeTree]] = [([amount * k for k in range(count)], times)]
        parts = round(1 / amount)
        if type(slope) is float and parts > 1 and math.isclose(1 / amount, parts, rel_tol=1e-9):
            ways.insert(0, ([k / parts for k in range(count)], form("/", i, atom(parts, span), span=span)))
        for offsets, node in ways:
            sign = 1 if slope > 0 else -1
            if first == 0:
                yield [sign * x for x in offsets], node if slope > 0 else form("-", node, span=span)
            else:
                total = form("+" if slope > 0 else "-", begin, node, span=span)
                yield [begin.value + sign * x for x in offsets], total


def _short(value: float) -> float:
    """Return a number without the error of its last digits."""
    return value if type(value) is int else float(f"{value:.11g}")


def _circle_through(
    xs: Sequence[float], zs: Sequence[float], index: str, count: int, span: Span
) -> tuple[CodeTree, CodeTree] | None:
    """Return sine and cosine of an angle that is linear in the index, for points on a circle about the origin."""
    radius = math.hypot(xs[0], zs[0])
    angles = [math.atan2(x, z) for x, z in zip(xs, zs)]
    step = math.remainder(angles[1] - angles[0], math.tau)
    whole = math.tau / count
    step = math.copysign(whole, step) if math.isclose(abs(step), whole, rel_tol=1e-9) else step
    if radius == 0 or abs(step) < 1e-6:
        return None
    for k, (x, z) in enumerate(zip(xs, zs)):
        angle = angles[0] + step * k
        if math.hypot(radius * math.sin(angle) - x, radius * math.cos(angle) - z) > _ROUNDING * radius:
            return None
    pi = Poly.factor(symbol("pi", span))
    start = _turned_by(angles[0], pi)
    slope = pi * Poly.number(math.copysign(2 / count, step)) if abs(step) == whole else _turned_by(step, pi)
    angle_node = expression(start + slope * Poly.factor(symbol(index, span)), symbol(index, span))
    if angle_node is None:
        return None
    waves = [form(wave, copied(angle_node), span=span) for wave in ("sin", "cos")]
    x_form, z_form = (form("*", atom(_short(radius), span), wave, span=span) for wave in waves)
    return x_form, z_form


def _turned_by(angle: float, pi: Poly) -> Poly:
    """Return an angle as a fraction of pi, if it is one, or as a number."""
    part = angle / math.pi
    for under in (1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 12, 14, 15, 16, 18, 20, 24, 30, 32, 36, 60):
        if math.isclose(part * under, round(part * under), rel_tol=1e-10, abs_tol=1e-10):
            return pi * Poly.number(round(part * under) / under)
    return Poly.number(_short(angle))


def _with_values(node: CodeTree, values: dict[str, CodeTree]) -> CodeTree:
    """Return a tree in which variables are replaced by expressions."""
    if node.name in values:
        new = copied(values[str(node.name)])
        new.trivia = node.trivia
        return new
    if node.items is None or node.head == "quote":
        return node
    node.items[:] = [_with_values(item, values) for item in node.items]
    return node
