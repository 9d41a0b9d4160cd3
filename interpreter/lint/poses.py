"""Poses that are probably composed in the wrong order."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import pairwise
from typing import Any

from scenelang.grammar import ast
from scenelang.grammar.diagnostics import Diagnostic
from scenelang.grammar.source import Span
from scenelang.interpreter.analyse import walk
from scenelang.interpreter.library import Builtin
from scenelang.interpreter.scope import Variable


def turned_after_moved(nodes: Iterable[Any]) -> Iterator[Diagnostic]:
    """A thing that is moved and then turned by a fixed angle about the origin, so that it swings away from its place.

    An angle that varies places things round a circle, and a move along the axis commutes with the turn: both are fine.
    """
    for node in nodes:
        if type(node) is ast.Transform:
            factors = _factors(node)
            for turn, move in pairwise(factors):
                if turn.span.expansion is None and _is_fixed_turn(turn) and _leaves_axis(turn, move):
                    yield _warning(turn)


def _factors(node: ast.Transform) -> list[Any]:
    """The matrices on the way to the part, the last applied first."""
    found: list[Any] = []
    part: Any = node
    if type(node.part) is ast.Transform:
        part = node
        while type(part) is ast.Transform:
            found += _product(part.matrix)
            part = part.part
            if len(found) > 1:
                break
        return found[: len(_product(node.matrix)) + 1]
    return _product(node.matrix)


def _product(matrix: Any) -> list[Any]:
    if _head(matrix) == "@":
        return [factor for argument in matrix.arguments for factor in _product(argument)]
    return [matrix]


def _head(node: Any) -> str | None:
    if type(node) is ast.Application and type(node.function) is ast.Reference:
        target = node.function.target
        return target.name if isinstance(target, Builtin) else None
    return None


def _is_fixed_turn(node: Any) -> bool:
    if _head(node) != "rotate" or len(node.arguments) != 2:
        return False
    return not any(
        type(part) is ast.Reference and isinstance(part.target, Variable) and not part.target.is_global
        for part in walk(node.arguments[0])
    )


def _leaves_axis(turn: Any, move: Any) -> bool:
    """Whether ``move`` is a translation that surely does not go along the axis of ``turn``."""
    if _head(move) != "translate" or len(move.arguments) != 1:
        return False
    axis, offset = _numbers(turn.arguments[1]), _numbers(move.arguments[0])
    if axis is None or offset is None:
        return False
    return any(shift not in (0, None) and along == 0 for along, shift in zip(axis, offset))


def _numbers(node: Any) -> list[float | None] | None:
    """The items of an array literal, None for those that are worked out."""
    if type(node) is not ast.ArrayLiteral:
        return None
    return [item.value if type(item) is ast.Constant else None for item in node.items]


def _warning(turn: Any) -> Diagnostic:
    span: Span = turn.span
    message = "this turns what was moved before, about the origin: it swings away from its place"
    hint = "turn first, then move, or give `rotate` a point to turn about"
    return Diagnostic("turned-after-moved", message, span, hint)
