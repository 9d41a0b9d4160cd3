"""Records as the paper's tables, its own figures beside them: as text, Markdown, LaTeX or JSON data."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from scenelang.evaluation.paper_tables import EVERY, TABLES, Column, Figure, PaperTable
from scenelang.evaluation.results import Record

_NONE = "-"
_LATEX = {"\\": r"\textbackslash{}", "{": r"\{", "}": r"\}", "~": r"\textasciitilde{}", "^": r"\textasciicircum{}"}
_LATEX |= {mark: "\\" + mark for mark in "&%$#_"}


@dataclass(frozen=True, slots=True)
class Cell:
    """A number as the column shows it, scaled, over ``count`` scenes (0: the paper's); the deviation is that across
    scenes."""

    value: float
    deviation: float | None
    count: int = 0


@dataclass(frozen=True, slots=True)
class Row:
    """A method; ``is_paper`` says that the paper printed these numbers and nothing here measured them."""

    method: str
    is_paper: bool
    cells: tuple[Cell | None, ...]

    @property
    def label(self) -> str:
        return f"{self.method} (paper)" if self.is_paper else self.method


@dataclass(frozen=True, slots=True)
class Table:
    """One of the paper's tables, with rows of ours below its own."""

    paper: PaperTable
    rows: tuple[Row, ...]


def tables_of(records: Sequence[Record]) -> list[Table]:
    """The tables that the records have something for; methods in the order in which they come."""
    methods = list(dict.fromkeys(record.method for record in records))
    found = []
    for paper in TABLES:
        rows = [_measured(method, records, paper.columns) for method in methods]
        rows = [row for row in rows if any(row.cells)]
        if rows:
            printed = [Row(name, True, tuple(map(_printed, figures))) for name, figures in paper.rows]
            found.append(Table(paper, (*printed, *rows)))
    return found


def _printed(figure: Figure | None) -> Cell | None:
    return None if figure is None else Cell(figure.value, figure.deviation)


def _measured(method: str, records: Sequence[Record], columns: Sequence[Column]) -> Row:
    return Row(method, False, tuple(_cell([r for r in records if r.method == method], column) for column in columns))


def _cell(records: Sequence[Record], column: Column) -> Cell | None:
    """The mean over scenes, and their standard deviation (of these scenes, not of all there might be)."""
    values = [
        column.scale * float(record.values[column.part])
        for record in records
        if record.metric == column.metric and column.group in (EVERY, record.group) and column.part in record.values
    ]
    if not values:
        return None
    deviation = float(np.std(values)) if column.has_deviation else None
    return Cell(float(np.mean(values)), deviation, len(values))


# --- as texts --------------------------------------------------------------------------------------------------------


def as_text(table: Table) -> str:
    """Aligned columns under their headings."""
    columns = table.paper.columns
    top = ["", *(column.heading for column in columns)]
    names = ["Method", *(f"{column.title} {column.arrow}".rstrip() for column in columns)]
    body = [[row.label, *_cells(row, columns, _plain)] for row in table.rows]
    widths = [max(len(row[i]) for row in (names, *body)) for i in range(len(names))]
    lines = [table.paper.title, ""]
    if any(top):
        lines.append(_headings(top, widths))
    rule = "  ".join("-" * width for width in widths)
    lines += [_line(names, widths), rule]
    ours = sum(row.is_paper for row in table.rows)
    lines += [_line(row, widths) for row in body[:ours]] + [rule] + [_line(row, widths) for row in body[ours:]]
    return "\n".join(lines)


def _line(cells: Sequence[str], widths: Sequence[int]) -> str:
    first, *rest = (f"{cell:<{width}}" if i == 0 else f"{cell:>{width}}" for i, (cell, width) in
                    enumerate(zip(cells, widths, strict=True)))  # fmt: skip
    return "  ".join((first, *rest)).rstrip()


def _headings(top: Sequence[str], widths: Sequence[int]) -> str:
    """Each heading once, at the left of its columns."""
    line, at = "", 0
    for i, width in enumerate(widths):
        if top[i] and (i == 0 or top[i] != top[i - 1]):
            line = f"{line:<{at}}{top[i]}"
        at += width + 2
    return line


def as_markdown(table: Table) -> str:
    """A table of GitHub's Markdown; headings stand before the names of columns."""
    columns = table.paper.columns
    named = (f"{c.heading}: {c.title}" if c.heading else c.title for c in columns)
    names = ["Method", *(f"{name} {c.arrow}".rstrip() for name, c in zip(named, columns, strict=True))]
    rows = [[_marked(row.label), *_cells(row, columns, _plain)] for row in table.rows]
    ruler = ["---", *("---:" for _ in columns)]
    return "\n".join([f"**{table.paper.title}**", "", *(f"| {' | '.join(cells)} |" for cells in (names, ruler, *rows))])


def as_latex(table: Table) -> str:
    """A `tabular` for booktabs, laid out as the paper's."""
    columns = table.paper.columns
    begin = rf"\begin{{tabular}}{{l{'c' * len(columns)}}}"
    lines = [f"% {table.paper.title}", begin, r"\toprule", *_latex_top(columns)]
    names = (f"{c.title}{_LATEX_ARROWS[c.arrow]}" for c in columns)
    lines += [" & ".join(("Methods", *names)) + r" \\", r"\midrule"]
    before = True
    for row in table.rows:
        if before and not row.is_paper:
            lines.append(r"\midrule")
        before = row.is_paper
        lines.append(" & ".join((_escaped(row.label), *_cells(row, columns, _in_latex))) + r" \\")
    return "\n".join([*lines, r"\bottomrule", r"\end{tabular}"])


_LATEX_ARROWS = {"": "", "↑": r" ($\uparrow$)", "↓": r" ($\downarrow$)"}


def _latex_top(columns: Sequence[Column]) -> list[str]:
    """The row of headings with lines below them; none where there are no headings."""
    spans: list[tuple[str, int]] = []
    for column in columns:
        if spans and spans[-1][0] == column.heading:
            spans[-1] = (column.heading, spans[-1][1] + 1)
        else:
            spans.append((column.heading, 1))
    if not any(heading for heading, _ in spans):
        return []
    cells, rules, at = [], [], 2
    for heading, width in spans:
        cells.append(rf"\multicolumn{{{width}}}{{c}}{{{_escaped(heading)}}}")
        rules.append(rf"\cmidrule(lr){{{at}-{at + width - 1}}}")
        at += width
    return [" & ".join(("", *cells)) + r" \\", " ".join(rules)]


def _cells(row: Row, columns: Sequence[Column], write: Callable[[Cell, Column], str]) -> list[str]:
    return [_NONE if cell is None else write(cell, column) for cell, column in zip(row.cells, columns, strict=True)]


def _plain(cell: Cell, column: Column) -> str:
    deviation = "" if cell.deviation is None else f" ± {cell.deviation:.{column.digits}f}"
    return f"{cell.value:.{column.digits}f}{deviation}{column.unit}"


def _in_latex(cell: Cell, column: Column) -> str:
    deviation = "" if cell.deviation is None else rf" \pm {cell.deviation:.{column.digits}f}"
    return f"${cell.value:.{column.digits}f}{deviation}{_escaped(column.unit)}$"


def _escaped(text: str) -> str:
    return "".join(_LATEX.get(mark, mark) for mark in text)


def _marked(text: str) -> str:
    """A text that Markdown takes for nothing else."""
    return "".join(f"\\{mark}" if mark in "\\`*_{}[]<>#|~" else mark for mark in text)


def as_data(table: Table) -> dict[str, Any]:
    """A table as JSON data."""
    columns = table.paper.columns
    rows = [
        {
            "method": row.method,
            "paper": row.is_paper,
            "cells": [
                None if cell is None else {"value": cell.value, "deviation": cell.deviation, "scenes": cell.count}
                for cell in row.cells
            ],
        }
        for row in table.rows
    ]
    names = [{"heading": c.heading, "title": c.title, "metric": c.metric, "unit": c.unit} for c in columns]
    return {"name": table.paper.name, "title": table.paper.title, "columns": names, "rows": rows}
