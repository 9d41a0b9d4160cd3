"""Arguments of a call of a known function by the names of its parameters, with the mistakes that a call can make."""

from __future__ import annotations

import ast
from typing import TYPE_CHECKING

from scenelang.grammar.diagnostics import suggest
from scenelang.interpreter.transpile.analysis.domain import T_INT

if TYPE_CHECKING:
    from scenelang.interpreter.transpile.writing.writer import Writer


def arguments_of(w: Writer, node: ast.Call, signature: str, name: str) -> dict[str, ast.expr]:
    """The arguments by parameter. ``signature`` names the parameters in order; ``?`` marks an optional one."""
    parameters = signature.split()
    names = [p.rstrip("?") for p in parameters]
    found: dict[str, ast.expr] = {}
    for position, argument in enumerate(expanded(w, node.args)):
        if isinstance(argument, ast.Starred):
            raise w.unsupported(f"a star in a call of `{name}`", argument)
        if position >= len(names):
            message = (
                f"`{name}` takes at most {len(names)} argument{'s' if len(names) != 1 else ''}, got {len(node.args)}"
            )
            raise w.error("python-call", message, node)
        found[names[position]] = argument
    for keyword in node.keywords:
        if keyword.arg is None:
            raise w.unsupported(f"`**` in a call of `{name}`", keyword)
        if keyword.arg not in names:
            raise w.error(
                "python-call", f"`{name}` has no parameter `{keyword.arg}`", keyword, suggest(keyword.arg, names)
            )
        if keyword.arg in found:
            raise w.error("python-call", f"`{name}` gets `{keyword.arg}` twice", keyword)
        found[keyword.arg] = keyword.value
    for parameter in parameters:
        if not parameter.endswith("?") and parameter not in found:
            raise w.error("python-call", f"the call of `{name}` lacks `{parameter}`", node)
    return found


def expanded(w: Writer, arguments: list[ast.expr]) -> list[ast.expr]:
    """Arguments with ``*xs`` written out where ``xs`` is a variable whose length is known."""
    found: list[ast.expr] = []
    for argument in arguments:
        length = w.known_length(argument.value) if isinstance(argument, ast.Starred) else None
        if length is None or not isinstance(argument, ast.Starred) or not w.is_simple(argument.value):
            found.append(argument)
            continue
        items = [site.items for site in w.type(argument.value).sites if site.items is not None]
        for position in range(length):
            item = ast.copy_location(ast.Subscript(argument.value, ast.Constant(position), ast.Load()), argument)
            ast.copy_location(item.slice, argument)
            for types in items:
                w.facts.types[item] = w.type(item) | types[position]
            w.facts.types[item.slice] = T_INT
            found.append(item)
    return found


def is_zero_vector(node: ast.expr | None) -> bool:
    """``(0, 0, 0)``, also in floats or as ``np.zeros(3)``, or nothing at all."""
    if node is None:
        return True
    if isinstance(node, (ast.Tuple, ast.List)):
        return len(node.elts) == 3 and all(_is_zero(e) for e in node.elts)
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and len(node.args) == 1:
        if node.func.attr == "zeros":
            return isinstance(node.args[0], ast.Constant) and node.args[0].value == 3
        if node.func.attr == "array":
            return is_zero_vector(node.args[0])
    return False


def _is_zero(node: ast.expr) -> bool:
    return isinstance(node, ast.Constant) and type(node.value) in (int, float) and node.value == 0


def is_ones(node: ast.expr) -> bool:
    """``(1, 1, 1)``."""
    return (
        isinstance(node, (ast.Tuple, ast.List))
        and len(node.elts) == 3
        and all(isinstance(e, ast.Constant) and type(e.value) in (int, float) and e.value == 1 for e in node.elts)
    )
