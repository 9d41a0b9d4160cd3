"""What an editor draws around the text: inlay hints, colour swatches with a picker, and folding ranges."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

from lsprotocol import types as lsp

from scenelang.grammar import ast
from scenelang.grammar.datum import Source, Span
from scenelang.grammar.diagnostics import SceneError
from scenelang.grammar.reader import lexemes
from scenelang.interpreter.compile.analyse import walk
from scenelang.interpreter.expand.scope import Variable
from scenelang.interpreter.kinds.kinds import ANY, Kind, describe
from scenelang.interpreter.runtime.types import Builtin
from scenelang.interpreter.runtime.values import Keyword
from scenelang.lsp.names import position, range_of
from scenelang.lsp.references import Document
from scenelang.stdlib.colors import color_of, encoded, linear

# Inlay hints: the parameters that literal arguments are for, and the kinds of definitions where they are requested.


def inlay_hints(document: Document, first: int, last: int, kinds: bool = False) -> list[lsp.InlayHint]:
    """Return the hints of the lines ``first`` to ``last``, counted from 0; with ``kinds``, those of definitions too."""
    names = document.names
    if names is None:
        return []
    version = names.version
    results = version.program.kinds.of(version.program)
    found = []
    for form, result in zip(version.program.forms, results):
        place = version.place(form.span)
        if place.source is not document.source or not _overlaps(place, first, last):
            continue
        for span, label in _hints(form, result.kinds, kinds):
            at = version.place(span)
            if first <= at.source.position(at.start)[0] - 1 <= last:
                found.append((at, label))
    return [_inlay(at, label) for at, label in sorted(found, key=lambda row: row[0].start)]


def _overlaps(span: Span, first: int, last: int) -> bool:
    return span.source.position(span.start)[0] - 1 <= last and span.source.position(span.end)[0] - 1 >= first


def _inlay(at: Span, label: str) -> lsp.InlayHint:
    if label.startswith(":"):
        return lsp.InlayHint(position(at.source, at.end), label, kind=lsp.InlayHintKind.Type, padding_right=True)
    return lsp.InlayHint(position(at.source, at.start), label, kind=lsp.InlayHintKind.Parameter, padding_right=True)


def _hints(form: Any, kinds: dict[Any, Kind], with_kinds: bool) -> Iterator[tuple[Span, str]]:
    for node in walk(form):
        if node.span.expansion is not None:
            continue
        if type(node) is ast.Application:
            yield from _parameter_hints(node, kinds)
        elif with_kinds and type(node) is ast.Define and isinstance(node.target, Variable):
            kind = kinds.get(node.value, ANY)
            span = node.target.span
            if span is not None and kind is not ANY and kind.tag != "Function":
                yield span, f": {describe(kind).partition(' ')[2] or describe(kind)}"


def _parameter_hints(node: ast.Application, kinds: dict[Any, Kind]) -> Iterator[tuple[Span, str]]:
    names = _positional_names(kinds.get(node.function, ANY).code)
    if len(names) < 2:
        return
    pending = iter(node.arguments)
    positional = []
    for argument in pending:
        if type(argument) is ast.Constant and type(argument.value) is Keyword:
            next(pending, None)
        else:
            positional.append(argument)
    for name, argument in zip(names, positional):
        if type(argument) in (ast.Constant, ast.ArrayLiteral) and argument.span.expansion is None:
            yield argument.span, f"{name}:"


def _positional_names(code: Any) -> list[str]:
    if isinstance(code, Builtin):
        return [parameter.name for parameter in (*code.signature.required, *code.signature.optional)]
    if isinstance(code, ast.Lambda):
        return [parameter.name for parameter in code.parameters if parameter.kind in ("required", "optional")]
    return []


# Colour swatches: `(color "name")`, `(rgb r g b)` and arrays of three literal numbers as the value of `:color`.

_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_COLORS = re.compile(
    rf"""\(color\s+"(?P<name>[^"\n]*)"\s*\)|\(rgb\s+(?P<rgb>{_NUMBER}(?:\s+{_NUMBER}){{2}})\s*\)"""
    rf"""|(?<=:color\s)\[\s*(?P<linear>{_NUMBER}(?:\s+{_NUMBER}){{2}})\s*\]"""
)


def colors(document: Document) -> list[lsp.ColorInformation]:
    """Return the literal colours of a document, as sRGB."""
    text = document.source.text
    found = []
    for match in _COLORS.finditer(text):
        try:
            red, green, blue = _components(match)
        except SceneError:
            continue
        span = Span(document.source, *match.span())
        found.append(lsp.ColorInformation(range_of(span), lsp.Color(red, green, blue, 1.0)))
    return found


def _components(match: re.Match[str]) -> tuple[float, float, float]:
    if match["name"] is not None:
        values = [encoded(value) for value in color_of(match["name"])]
    elif match["rgb"] is not None:
        values = [float(value) / 255 for value in match["rgb"].split()]
    else:
        values = [encoded(float(value)) for value in match["linear"].split()]
    red, green, blue = (min(1.0, max(0.0, value)) for value in values)
    return red, green, blue


def color_presentations(source: Source, color: lsp.Color, range_: lsp.Range) -> list[lsp.ColorPresentation]:
    """Return the ways to write a colour that was picked, the one that the text uses first."""
    components = (color.red, color.green, color.blue)
    digits = "".join(f"{round(value * 255):02x}" for value in components)
    array = "[" + " ".join(f"{linear(value):.4g}" for value in components) + "]"
    texts = [f'(color "#{digits}")', f"(rgb {' '.join(str(round(value * 255)) for value in components)})", array]
    line = source.line(range_.start.line + 1)[range_.start.character :]
    texts.sort(key=lambda text: not line.startswith(text[:4] if text[0] == "(" else "["))
    return [lsp.ColorPresentation(text, lsp.TextEdit(range_, text)) for text in texts]


# Folding: brackets and comments that take several lines.


def folding_ranges(document: Document) -> list[lsp.FoldingRange]:
    """Return the forms and the runs of comment lines that take several lines."""
    source = document.source
    found: list[lsp.FoldingRange] = []
    opened: list[int] = []
    comment: tuple[int, int] | None = None  # first and last line of a run of comment lines
    for kind, start, end in lexemes(source.text, 0, len(source.text)):
        line = source.position(start)[0] - 1
        if kind == "comment":
            comment = (comment[0] if comment is not None and line == comment[1] + 1 else line, line)
            continue
        if kind == "space":
            continue
        if comment is not None and comment[1] > comment[0]:
            found.append(lsp.FoldingRange(*comment, kind=lsp.FoldingRangeKind.Comment))
        comment = None
        if kind == "open":
            opened.append(line)
        elif kind == "close" and opened:
            first, last = opened.pop(), line
            if last > first and not any(each.start_line == first and each.end_line == last for each in found[-1:]):
                found.append(lsp.FoldingRange(first, last))
        elif kind in ("block", "string") and (last := source.position(end)[0] - 1) > line:
            kind_ = lsp.FoldingRangeKind.Comment if kind == "block" else None
            found.append(lsp.FoldingRange(line, last, kind=kind_))
    if comment is not None and comment[1] > comment[0]:
        found.append(lsp.FoldingRange(*comment, kind=lsp.FoldingRangeKind.Comment))
    return _outermost(found)


def _outermost(ranges: list[lsp.FoldingRange]) -> list[lsp.FoldingRange]:
    """Keep one range for each first line, the longest: an editor folds one there."""
    longest: dict[int, lsp.FoldingRange] = {}
    for each in ranges:
        known = longest.get(each.start_line)
        if known is None or known.end_line < each.end_line:
            longest[each.start_line] = each
    return [longest[line] for line in sorted(longest)]
