"""f-strings, ``%`` and ``format`` -> ``(format "..." ...)``."""

from __future__ import annotations

import ast
import re
import string
from typing import TYPE_CHECKING

from scenelang.interpreter.transpile.analysis.domain import FLOAT, INT, STR
from scenelang.interpreter.transpile.writing.code import Code, Literal, form

if TYPE_CHECKING:
    from scenelang.interpreter.transpile.writing.expressions import ExpressionWriter

_PERCENT = re.compile(r"%(?:\((\w+)\))?([-+ #0]*)(\d+)?(?:\.(\d+))?([a-zA-Z%])")


def interpolated(w: ExpressionWriter, node: ast.JoinedStr) -> Code:
    """An f-string."""
    template = ""
    values: list[Code] = []
    for part in node.values:
        if isinstance(part, ast.Constant):
            template += _escaped(str(part.value))
        elif isinstance(part, ast.FormattedValue):
            spec = ""
            if part.format_spec is not None:
                if not isinstance(part.format_spec, ast.JoinedStr) or not all(
                    isinstance(p, ast.Constant) for p in part.format_spec.values
                ):
                    raise w.unsupported("a computed format", part)
                spec = "".join(str(p.value) for p in part.format_spec.values if isinstance(p, ast.Constant))
            is_quoted = part.conversion == ord("r") and w.type(part.value).only(STR)
            field = "{" + (f":{spec}" if spec else "") + "}"
            template += f"'{field}'" if is_quoted else field
            values.append(printable(w, part.value) if not spec else w.expr(part.value))
    return _format(template, values)


def _format(template: str, values: list[Code]) -> Code:
    if not values:
        return Literal(template.replace("{{", "{").replace("}}", "}"))
    return form("format", Literal(template), *values)


def _escaped(text: str) -> str:
    return text.replace("{", "{{").replace("}", "}}")


def printable(w: ExpressionWriter, node: ast.expr) -> Code:
    """A value to be put into a text as Python would write it."""
    found = w.type(node)
    if not found.kinds or found.only(INT | FLOAT | STR):
        return w.expr(node)
    return w.dynamic("py-str", w.expr(node))


def percent(w: ExpressionWriter, node: ast.BinOp) -> Code:
    """``"..." % values``."""
    if not isinstance(node.left, ast.Constant):
        return w.dynamic("py-%", w.expr(node.left), w.expr(node.right))
    values = list(node.right.elts) if isinstance(node.right, ast.Tuple) else [node.right]
    template, position = "", 0
    codes: list[Code] = []
    text = str(node.left.value)
    for match in _PERCENT.finditer(text):
        template += _escaped(text[position : match.start()])
        position = match.end()
        name, flags, width, precision, kind = match.groups()
        if kind == "%":
            template += "%"
            continue
        if name or kind not in "sdifgeExX" or len(codes) >= len(values):
            raise w.error("python-call", f"the format `{match.group()}` does not fit the values", node.left)
        value = values[len(codes)]
        template += "{" + _spec(flags, width, precision, kind) + "}"
        if kind in "di" and not w.type(value).only(INT):
            codes.append(form("truncate", w.expr(value)))
        else:
            codes.append(printable(w, value) if kind == "s" else w.expr(value))
    if len(codes) != len(values):
        raise w.error("python-call", f"{len(values)} values for {len(codes)} places of the format", node)
    return _format(template + _escaped(text[position:]), codes)


def _spec(flags: str, width: str | None, precision: str | None, kind: str) -> str:
    if kind == "s" and not width and not precision:
        return ""
    align = "<" if "-" in flags else ">" if kind == "s" and width else ""
    sign = "+" if "+" in flags else ""
    zero = "0" if "0" in flags and not align else ""
    kind = {"i": "d", "s": ""}.get(kind, kind)
    return f":{align}{sign}{zero}{width or ''}{'.' + precision if precision else ''}{kind}"


def format_method(w: ExpressionWriter, node: ast.Call, func: ast.Attribute) -> Code:
    """``"...".format(...)``: named fields become positions; fields reach no attributes or items."""
    named = {k.arg: position for position, k in enumerate(node.keywords, len(node.args)) if k.arg is not None}
    values = [*node.args, *(k.value for k in node.keywords)]
    if not isinstance(func.value, ast.Constant):
        return form("format", w.expr(func.value), *(w.expr(value) for value in values))
    template = ""
    try:
        fields = list(string.Formatter().parse(str(func.value.value)))
    except ValueError as problem:
        raise w.error("python-call", f"the format is malformed: {problem}", func.value) from None
    for literal, name, spec, conversion in fields:
        template += _escaped(literal)
        if name is None:
            continue
        if "." in name or "[" in name:
            raise w.error("python-forbidden", f"the field `{{{name}}}` reaches into its value", func.value)
        if conversion not in (None, "s"):
            raise w.unsupported(f"`!{conversion}` in a format", func.value)
        if name and not name.isdigit():
            if name not in named:
                raise w.error("python-call", f"the format has no value for `{name}`", func.value)
            name = str(named[name])
        template += "{" + name + (f":{spec}" if spec else "") + "}"
    return _format(template, [printable(w, value) for value in values])
