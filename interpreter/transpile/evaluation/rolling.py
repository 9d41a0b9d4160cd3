"""Loops from lists of similar expressions: ``f(1, 2), f(1, 3), f(1, 4)`` becomes ``*[f(1, x) for x in (2, 3, 4)]``.

The expressions are generalised to their least general common form (anti-unification; Plotkin 1970); what differs
becomes the columns of a table.
"""

from __future__ import annotations

import ast
import copy
import itertools
from collections.abc import Iterable, Iterator, Sequence
from typing import Any

_FEWEST = 3  # expressions that become a loop


def rolled(nodes: Iterable[ast.expr]) -> list[ast.expr]:
    """Return expressions with loops in place of runs of similar ones."""
    found: list[ast.expr] = []
    run: list[ast.expr] = []
    shape = ""
    for node in nodes:
        own = _shape(node)
        if own != shape:
            found += _loop(run)
            run, shape = [], own
        run.append(node)
    return found + _loop(run)


def _shape(node: ast.expr) -> str:
    """Return the form of an expression without its numbers and texts."""
    if isinstance(node, ast.Starred):
        return f"*{id(node)}"  # a loop remains
    general = _General()
    return ast.dump(general.visit(copy.deepcopy(node)))


def _is_number(node: ast.AST) -> bool:
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
        node = node.operand
    return isinstance(node, ast.Constant) and type(node.value) in (int, float)


class _General(ast.NodeTransformer):
    def visit(self, node: ast.AST) -> ast.AST:
        if _is_number(node):
            return ast.Constant(0)
        return self.generic_visit(node)


def _loop(run: Sequence[ast.expr]) -> list[ast.expr]:
    if len(run) < _FEWEST or isinstance(run[0], ast.Starred):
        return list(run)
    rows = [_numbers(node) for node in run]
    columns = list(zip(*rows))
    taken = {n.id for n in ast.walk(run[0]) if isinstance(n, ast.Name)}
    free = (name for name in _names() if name not in taken)
    varying = [i for i, column in enumerate(columns) if len({ast.dump(each) for each in column}) > 1]
    groups: dict[str, str] = {}  # names by the values of a column
    names: dict[int, str] = {}
    kept: list[int] = []
    for i in varying:
        text = "".join(map(ast.dump, columns[i]))
        if text not in groups:
            groups[text] = next(free)
            kept.append(i)
        names[i] = groups[text]
    if not varying or len(kept) > 12:
        return list(run)
    template: Any = _Named(names).visit(copy.deepcopy(run[0]))
    table: list[ast.expr] = [
        columns[kept[0]][row] if len(kept) == 1 else ast.Tuple([columns[i][row] for i in kept], ast.Load())
        for row in range(len(run))
    ]
    targets: list[ast.expr] = [ast.Name(name, ast.Store()) for name in groups.values()]
    target = targets[0] if len(targets) == 1 else ast.Tuple(targets, ast.Store())
    loop = ast.comprehension(target, ast.List(table, ast.Load()), [], 0)
    return [ast.Starred(ast.ListComp(template, [loop]), ast.Load())]


def _names() -> Iterator[str]:
    for number in itertools.count():
        for letter in "xyzwuvabcdefghijklmnopqrst":
            yield f"{letter}{number or ''}_"


def _numbers(node: ast.AST) -> list[ast.expr]:
    """Return the numbers in an expression, in order."""
    if _is_number(node) and isinstance(node, ast.expr):
        return [node]
    return [each for child in ast.iter_child_nodes(node) for each in _numbers(child)]


class _Named(ast.NodeTransformer):
    """Replaces numbers, by their position, by names."""

    def __init__(self, names: dict[int, str]) -> None:
        self._names, self._count = names, 0

    def visit(self, node: ast.AST) -> ast.AST:
        if _is_number(node):
            name = self._names.get(self._count)
            self._count += 1
            return ast.Name(name, ast.Load()) if name is not None else node
        return self.generic_visit(node)
