"""Tests and divisions that have the same result in every turn of a loop, or for every value of their kind."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from scenelang.grammar import ast
from scenelang.interpreter.checker.common import MAX_SHOWN, number_of
from scenelang.interpreter.compile.analyze import called_builtin
from scenelang.interpreter.compile.kinds import Kind, describe, is_truthy
from scenelang.interpreter.expand.scope import Variable
from scenelang.interpreter.runtime.types import Builtin

if TYPE_CHECKING:
    from scenelang.interpreter.checker.infer import KindInference

_FALSE_ALONE = "only `#f` and `none` are false"
_SEQUENCES = ("List", "Vector", "String", "MutableList", "Table", "Set")
_MIRRORED = {"<": ">", ">": "<", "<=": ">=", ">=": "<=", "=": "="}


def check_test(inference: KindInference, test: Any, kind: Kind) -> None:
    """Warn about a test that is always true, because its value is no Boolean, or by the range of a loop's index."""
    if type(test) in (ast.Constant, ast.Lambda) or test.span.expansion is not None:
        return
    inner = test.items if type(test) is ast.And else test.arguments if called_builtin(test) == "not" else ()
    for part in inner:
        check_test(inference, part, inference.result.kinds.get(part, kind))
    if inner:
        return
    target = getattr(test, "target", None)
    if isinstance(target, Builtin):
        return
    always = _comparison(inference, test)
    if always is not None:
        message = f"this condition is {'true' if always else 'false'} in every turn of the loop"
        inference.warn("constant-condition", message, test.span, _range_of_index(inference, test))
        return
    tags = {option.tag for option in kind.options}
    is_number = bool(tags) and tags <= {"Integer", "Float"}
    is_read = type(test) is ast.Reference and is_number
    if (
        is_truthy(kind) is not True
        or not (type(test) is ast.Application or is_read)
        or not (is_number or len(tags) == 1)
    ):
        return
    text = test.span.text if len(test.span.text) <= MAX_SHOWN else "..."
    message = f"this condition is always true: `{text}` is {describe(kind)}, and {_FALSE_ALONE}"
    hint = None
    if is_number:
        message = f"this condition is always true: `{text}` is a number, and every number, also 0, is true"
        hint = f"compare it: `(> {text} 0)`"
    elif kind.tag in _SEQUENCES:
        hint = f"whether it has items is `(not (empty? {text}))`"
    inference.warn("constant-condition", message, test.span, hint)


def check_floor_division(inference: KindInference, node: Any) -> None:
    """Warn about ``(// i n)`` with an index that is always less than ``n``, which is 0 in every turn."""
    division = node.arguments[0] if called_builtin(node) in ("floor", "truncate") and node.arguments else node
    name = called_builtin(division)
    if name not in (("//", "quotient") if division is node else ("/",)) or len(division.arguments) != 2:
        return
    index, divisor = division.arguments
    if node.span.expansion is not None:
        return
    if _is_below(inference, index, divisor):
        message = f"`{node.span.text}` rounds down, and is 0 in every turn of the loop"
        hint = f"write `(/ {index.span.text} {divisor.span.text})`, which is not rounded"
        inference.warn("constant-condition", message, node.span, hint)


def end_of_index(inference: KindInference, node: Any) -> str | None:
    """Return the code of the number of turns of the loop whose index an expression is, None for other expressions."""
    bounds = _bounds(inference, node)
    return bounds[1].span.text if bounds is not None and bounds[0] == 0 else None


def _bounds(inference: KindInference, node: Any) -> tuple[float, Any] | None:
    """Return the first value of an index that counts up by 1, and the expression of its end; None for other nodes."""
    if type(node) is not ast.Reference or not isinstance(node.target, Variable):
        return None
    values = inference.loops.get(node.target)
    if values is None or inference.is_assigned(node.target):
        return None
    name = called_builtin(values)
    if name in ("iota", "range") and len(values.arguments) == 1:
        return 0, values.arguments[0]
    if name == "range" and len(values.arguments) == 2:
        start = number_of(values.arguments[0])
        return (start, values.arguments[1]) if start is not None else None
    return (0, values) if name is None else None


def _range_of_index(inference: KindInference, test: Any) -> str | None:
    """Return the values that the index in a comparison has, for a hint."""
    for part in test.arguments:
        bounds = _bounds(inference, part)
        if bounds is not None:
            return f"`{part.span.text}` counts from {bounds[0]:g}, and ends before `{bounds[1].span.text}`"
    return None


def _is_below(inference: KindInference, index: Any, end: Any) -> bool:
    """Return whether an index is never negative and always less than another expression.

    Numbers with a name are left out: a param varies, and a constant is often a choice that a person changes.
    """
    bounds = _bounds(inference, index)
    if bounds is None or bounds[0] < 0:
        return False
    known, limit = number_of(bounds[1]), number_of(end)
    if known is not None and limit is not None:
        return known <= limit
    same = type(bounds[1]) is type(end) is ast.Reference and bounds[1].target is end.target
    return same and not inference.is_assigned(end.target)


def _comparison(inference: KindInference, test: Any) -> bool | None:
    """Return the result of a comparison of an index with a number or with its end; None if it varies."""
    sign = called_builtin(test)
    if sign not in _MIRRORED or len(test.arguments) != 2:
        return None
    left, right = test.arguments
    for index, other, relation in ((left, right, sign), (right, left, _MIRRORED[sign])):
        bounds = _bounds(inference, index)
        if bounds is None:
            continue
        if _is_below(inference, index, other):
            return relation in ("<", "<=")
        value = number_of(other)
        if value is not None and value < bounds[0]:
            return relation in (">", ">=")
        if value is not None and value == bounds[0] and relation in ("<", ">="):
            return relation == ">="
    return None
