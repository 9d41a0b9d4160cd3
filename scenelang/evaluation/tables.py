"""Records in the layout of the paper's tables, beside the paper's numbers, as text, Markdown, LaTeX or JSON data."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np

from scenelang.evaluation.running import DYNAMIC, GENERIC, NUMERIC, MetricRecord

# The paper's tables of results (CVPR 2025, tables 3 and 4, and the appendix on 4D): their columns and numbers.


EVERY = ""  # group of columns that average over all scenes


@dataclass(frozen=True, slots=True)
class PaperFigure:
    """A number of the paper, with its standard deviation across scenes if given."""

    value: float
    deviation: float | None = None


@dataclass(frozen=True, slots=True)
class Column:
    """A column: ``title`` below a group heading. It shows ``part`` of the metric's values, multiplied by ``scale``,
    with ``digits`` decimals and ``unit``; ``is_best_high`` selects the arrow."""

    title: str
    metric: str
    group: str = EVERY
    heading: str = ""
    part: str = "value"
    digits: int = 3
    scale: float = 1.0
    unit: str = ""
    is_best_high: bool | None = True
    has_deviation: bool = False

    @property
    def arrow(self) -> str:
        return "" if self.is_best_high is None else "↑" if self.is_best_high else "↓"


@dataclass(frozen=True, slots=True)
class PaperTable:
    """A table of the paper; ``rows`` contains the methods with a figure or None for each column."""

    name: str
    title: str
    columns: tuple[Column, ...]
    rows: tuple[tuple[str, tuple[PaperFigure | None, ...]], ...]


def _text_columns(group: str, heading: str) -> tuple[Column, ...]:
    alignment = Column("Alignment", "alignment", group, heading, digits=2, has_deviation=True)
    return alignment, Column("CLIP", "clip", group, heading, has_deviation=True)


_COUNT = Column("Count", "count", NUMERIC, "Numeric prompts", digits=2)
TEXT = PaperTable(
    "text",
    "Text-prompted 3D generation",
    (*_text_columns(NUMERIC, "Numeric prompts"), _COUNT, *_text_columns(GENERIC, "Generic prompts")),
    (
        ("GraphDreamer", (PaperFigure(3.56, 7.38), PaperFigure(0.297, 0.085), PaperFigure(0.11),
                          PaperFigure(15.75, 20.39), PaperFigure(0.230, 0.097))),
        ("MVDream", (PaperFigure(10.79, 12.83), PaperFigure(0.312, 0.046), PaperFigure(0.11), PaperFigure(35.13, 31.90),
                     PaperFigure(0.328, 0.031))),
        ("Ours", (PaperFigure(85.65, 13.71), PaperFigure(0.351, 0.051), PaperFigure(1.0),
                  PaperFigure(52.13, 26.83), PaperFigure(0.328, 0.030))),
    ),
)  # fmt: skip
MOVING = PaperTable(
    "4d",
    "Text-prompted 4D generation",
    (
        Column("CLIP", "clip", DYNAMIC),
        Column("Dynamic", "dynamic", DYNAMIC, digits=1, scale=100.0, unit="%"),
        Column("Pixels", "dynamic", DYNAMIC, part="pixels", digits=2),
        Column("VBench", "dynamic", DYNAMIC, part="is_dynamic", digits=2),
    ),
    (
        ("4D-fy", (PaperFigure(0.352), PaperFigure(0.2), None, None)),
        ("4D-fy (w/ prompt variant)", (PaperFigure(0.354), PaperFigure(0.6), None, None)),
        ("Ours", (PaperFigure(0.341), PaperFigure(5.9), None, None)),
    ),
)
IMAGE = PaperTable(
    "image",
    "Image-prompted generation",
    (Column("LPIPS", "lpips", is_best_high=False),),
    (("GraphDreamer", (PaperFigure(0.811),)), ("Ours", (PaperFigure(0.681),))),
)
TABLES = (TEXT, MOVING, IMAGE)


_NONE = "-"
_LATEX = {"\\": r"\textbackslash{}", "{": r"\{", "}": r"\}", "~": r"\textasciitilde{}", "^": r"\textasciicircum{}"}
_LATEX |= {mark: "\\" + mark for mark in "&%$#_"}


@dataclass(frozen=True, slots=True)
class TableCell:
    """A number as displayed, scaled, averaged over ``count`` scenes (0: from the paper), with the standard deviation
    across scenes."""

    value: float
    deviation: float | None
    count: int = 0


@dataclass(frozen=True, slots=True)
class TableRow:
    """A row of a method; ``is_paper`` marks numbers printed in the paper rather than measured here."""

    method: str
    is_paper: bool
    cells: tuple[TableCell | None, ...]

    @property
    def label(self) -> str:
        return f"{self.method} (paper)" if self.is_paper else self.method


@dataclass(frozen=True, slots=True)
class ResultTable:
    """One of the paper's tables, with our rows below the paper's."""

    paper: PaperTable
    rows: tuple[TableRow, ...]


def tables_of(records: Sequence[MetricRecord]) -> list[ResultTable]:
    """Return the tables for which there are records; methods in order of appearance."""
    methods = list(dict.fromkeys(record.method for record in records))
    tables = []
    for paper in TABLES:
        rows = [_measured(method, records, paper.columns) for method in methods]
        rows = [row for row in rows if any(row.cells)]
        if rows:
            printed = [TableRow(name, True, tuple(map(_printed, figures))) for name, figures in paper.rows]
            tables.append(ResultTable(paper, (*printed, *rows)))
    return tables


def _printed(figure: PaperFigure | None) -> TableCell | None:
    return None if figure is None else TableCell(figure.value, figure.deviation)


def _measured(method: str, records: Sequence[MetricRecord], columns: Sequence[Column]) -> TableRow:
    return TableRow(
        method, False, tuple(_cell([r for r in records if r.method == method], column) for column in columns)
    )


def _cell(records: Sequence[MetricRecord], column: Column) -> TableCell | None:
    """Return the mean over scenes, and their population standard deviation."""
    values = [
        column.scale * float(record.values[column.part])
        for record in records
        if record.metric == column.metric and column.group in (EVERY, record.group) and column.part in record.values
    ]
    if not values:
        return None
    deviation = float(np.std(values)) if column.has_deviation else None
    return TableCell(float(np.mean(values)), deviation, len(values))


# --- as texts --------------------------------------------------------------------------------------------------------


def as_text(table: ResultTable) -> str:
    """Format a table as aligned text columns."""
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
    """Return each heading once, at its leftmost column."""
    line, at = "", 0
    for i, width in enumerate(widths):
        if top[i] and (i == 0 or top[i] != top[i - 1]):
            line = f"{line:<{at}}{top[i]}"
        at += width + 2
    return line


def as_markdown(table: ResultTable) -> str:
    """Format a table as GitHub Markdown; headings are prefixed to the column names."""
    columns = table.paper.columns
    named = (f"{c.heading}: {c.title}" if c.heading else c.title for c in columns)
    names = ["Method", *(f"{name} {c.arrow}".rstrip() for name, c in zip(named, columns, strict=True))]
    rows = [[_marked(row.label), *_cells(row, columns, _plain)] for row in table.rows]
    ruler = ["---", *("---:" for _ in columns)]
    return "\n".join([f"**{table.paper.title}**", "", *(f"| {' | '.join(cells)} |" for cells in (names, ruler, *rows))])


def as_latex(table: ResultTable) -> str:
    """Format a table as a LaTeX `tabular` with booktabs, as in the paper."""
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
    """Return the row of headings with rules below them; none without headings."""
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


def _cells(row: TableRow, columns: Sequence[Column], write: Callable[[TableCell, Column], str]) -> list[str]:
    return [_NONE if cell is None else write(cell, column) for cell, column in zip(row.cells, columns, strict=True)]


def _plain(cell: TableCell, column: Column) -> str:
    deviation = "" if cell.deviation is None else f" ± {cell.deviation:.{column.digits}f}"
    return f"{cell.value:.{column.digits}f}{deviation}{column.unit}"


def _in_latex(cell: TableCell, column: Column) -> str:
    deviation = "" if cell.deviation is None else rf" \pm {cell.deviation:.{column.digits}f}"
    return f"${cell.value:.{column.digits}f}{deviation}{_escaped(column.unit)}$"


def _escaped(text: str) -> str:
    return "".join(_LATEX.get(mark, mark) for mark in text)


def _marked(text: str) -> str:
    """Escape Markdown."""
    return "".join(f"\\{mark}" if mark in "\\`*_{}[]<>#|~" else mark for mark in text)


def as_data(table: ResultTable) -> dict[str, Any]:
    """Return a table as JSON data."""
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


LAYOUTS: Mapping[str, Callable[[ResultTable], str]] = MappingProxyType({
    "text": as_text, "markdown": as_markdown, "latex": as_latex,
})  # fmt: skip
