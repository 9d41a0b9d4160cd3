"""Where control goes: what leaves a body or a loop early, and the places that it can leave."""

from __future__ import annotations

import ast
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from scenelang.interpreter.transpile.analysis.scopes import Function, Variable
from scenelang.interpreter.transpile.analysis.syntax import inner_blocks
from scenelang.interpreter.transpile.writing.blocks import Block, Collecting
from scenelang.interpreter.transpile.writing.code import (
    Code,
)

Finish = Callable[[Block], Code | None]


@dataclass(eq=False)
class Jump:
    """A place that `return`, `break` or `continue` may have to leave early; used when a plain branch cannot say it.
    ``value`` is what a turn of a collecting loop has collected by then."""

    name: str
    variable: Variable | None = None
    value: Callable[[], Code] | None = None

    def escape(self) -> Variable:
        if self.variable is None:
            self.variable = Variable(self.name, None, is_temporary=True)
        return self.variable


@dataclass(eq=False)
class Mode:
    """What a body is for. ``leaving``: the statement that ends it early in tail position (``return`` of a function,
    ``continue`` of a loop's body); ``finish`` gives the value when its end is reached."""

    leaving: type[ast.stmt] | None
    finish: Finish
    is_tail: bool = True
    collection: Collecting | None = None


@dataclass(eq=False)
class Place:
    """The function being written, and the loops around the statement."""

    function: Function
    returns: Jump = field(default_factory=lambda: Jump("return"))
    breaks: list[Jump] = field(default_factory=list)
    continues: list[Jump] = field(default_factory=list)
    yields: Variable | None = None


def leaves(statement: ast.stmt, kind: type[ast.stmt]) -> bool:
    """Whether ``statement`` holds a ``return``, ``continue`` or ``break`` that leaves what it stands in."""
    if isinstance(statement, kind):
        return True
    if isinstance(statement, (ast.For, ast.While)) and kind is not ast.Return:
        return any(leaves(s, kind) for s in statement.orelse)
    return any(leaves(s, kind) for block in inner_blocks(statement) for s in block)


def always_leaves(body: Sequence[ast.stmt], kind: type[ast.stmt]) -> bool:
    """Whether the end of ``body`` is never reached."""
    for statement in body:
        if isinstance(statement, (kind, ast.Raise)):
            return True
        if isinstance(statement, ast.If) and statement.orelse:
            if always_leaves(statement.body, kind) and always_leaves(statement.orelse, kind):
                return True
        if isinstance(statement, ast.Try) and not statement.finalbody:
            blocks = [[*statement.body, *statement.orelse], *(h.body for h in statement.handlers)]
            if all(always_leaves(block, kind) for block in blocks):
                return True
    return False


def is_skip(statement: ast.stmt) -> bool:
    """``if c: continue``."""
    is_guard = isinstance(statement, ast.If) and not statement.orelse and len(statement.body) == 1
    return isinstance(statement, ast.If) and is_guard and isinstance(statement.body[0], ast.Continue)


def breaks_out(body: Sequence[ast.stmt]) -> bool:
    return any(leaves(statement, ast.Break) for statement in body)


def only_loop(body: Sequence[ast.stmt], collecting: Collecting | None) -> ast.For | None:
    """The loop that is all of a loop's body."""
    if len(body) == 1 and isinstance(body[0], ast.For) and not body[0].orelse and not breaks_out(body[0].body):
        return body[0]
    return None


def has_inner_star(target: ast.expr) -> bool:
    """Whether a pattern has a star elsewhere than at its end."""
    if isinstance(target, (ast.Tuple, ast.List)):
        return any(isinstance(e, ast.Starred) for e in target.elts[:-1]) or any(has_inner_star(e) for e in target.elts)
    return False


def is_main_guard(node: ast.If) -> bool:
    """``if __name__ == "__main__":``."""
    return any(isinstance(n, ast.Name) and n.id == "__name__" for n in ast.walk(node.test))


def text_of(node: ast.stmt) -> str | None:
    if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str):
        return node.value.value
    return None


def without_docstring(body: Sequence[ast.stmt]) -> Sequence[ast.stmt]:
    return body[1:] if body and text_of(body[0]) is not None else body


def comment_lines(text: str) -> list[str]:
    """The lines of a docstring, without its indentation."""
    lines = [line.rstrip() for line in text.strip().splitlines()]
    indents = [len(line) - len(line.lstrip()) for line in lines[1:] if line.strip()]
    cut = min(indents, default=0)
    return [line if position == 0 else line[cut:] for position, line in enumerate(lines)]


def docstring_lines(function: Function) -> list[str]:
    """The docstring of a function as lines of comment."""
    body = function.body
    text = text_of(body[0]) if body else None
    return comment_lines(text) if text and text.strip() else []
