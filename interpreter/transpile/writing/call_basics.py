"""What the writers of library calls share."""

from __future__ import annotations

import ast
from collections.abc import Callable
from typing import TYPE_CHECKING, TypeAlias

from scenelang.interpreter.transpile.analysis.domain import (
    NUMBERS,
)
from scenelang.interpreter.transpile.writing.code import (
    Code,
    Key,
    form,
)
from scenelang.interpreter.transpile.writing.operators import numeric

if TYPE_CHECKING:
    from scenelang.interpreter.transpile.writing.expressions import ExpressionWriter


CallWriter: TypeAlias = "Callable[[ExpressionWriter, ast.Call], Code]"


def numeric_call(head: str) -> CallWriter:
    def write(w: ExpressionWriter, node: ast.Call) -> Code:
        only_positional(w, node)
        return form(head, *(numeric(w, argument) for argument in node.args))

    return write


def elementwise_call(head: str) -> CallWriter:
    def write(w: ExpressionWriter, node: ast.Call) -> Code:
        items = [w.array(a) if not w.type(a).only(NUMBERS) else numeric(w, a) for a in plain_arguments(w, node)]
        for keyword in node.keywords:
            if keyword.arg != "axis":
                raise w.unsupported(f"`{keyword.arg}` here", keyword)
            items += [Key("axis"), w.expr(keyword.value)]
        return form(head, *items)

    return write


def plain_arguments(w: ExpressionWriter, node: ast.Call) -> list[ast.expr]:
    for argument in node.args:
        if isinstance(argument, ast.Starred):
            raise w.unsupported("a star in this call", argument)
    return node.args


def only_positional(w: ExpressionWriter, node: ast.Call) -> None:
    plain_arguments(w, node)
    if node.keywords:
        raise w.error(
            "python-call", f"`{w.text.text(node.func)}` has no parameter `{node.keywords[0].arg}`", node.keywords[0]
        )


def keyword_of(node: ast.Call, name: str) -> ast.expr | None:
    return next((k.value for k in node.keywords if k.arg == name), None)


def is_comprehension(node: ast.expr) -> bool:
    return isinstance(node, (ast.GeneratorExp, ast.ListComp))
