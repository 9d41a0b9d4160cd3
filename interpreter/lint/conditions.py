"""Conditions that are always true or always false."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any

from scenelang.grammar import ast
from scenelang.grammar.diagnostics import Diagnostic, Edit, Fix
from scenelang.grammar.source import Span
from scenelang.interpreter.library import Builtin

_COMPARISONS = frozenset(("=", "<", ">", "<=", ">=", "eq?", "eqv?", "equal?"))


def constant_conditions(nodes: Iterable[Any]) -> Iterator[Diagnostic]:
    """Tests of ``if`` and its kin, and operands of ``and`` and ``or``, that the text alone decides."""
    for node in nodes:
        kind = type(node)
        if kind is ast.If and node.span.expansion is None:
            yield from _of_choice(node)
        elif kind is ast.And or kind is ast.Or:
            for item in node.items[:-1]:
                if item.span.expansion is None and _decided(item) is not None:
                    yield _warning(item, ())


def _of_choice(node: ast.If) -> Iterator[Diagnostic]:
    always = _decided(node.test)
    if always is None or node.test.span.expansion is not None or _is_default(node, always):
        return
    kept = node.then if always else node.otherwise
    text = node.span.text
    fixes: tuple[Fix, ...] = ()
    if text.startswith("(if ") and kept is not None and kept.span.expansion is None and _inside(kept.span, node.span):
        fixes = (Fix("Keep only the branch that runs", (Edit(node.span, kept.span.text),), safe=True),)
    yield _warning(node.test, fixes)


def _is_default(node: ast.If, always: bool) -> bool:
    """``(#t ...)`` as the last clause of ``cond``, which many write for ``else``."""
    return always and not node.span.text.startswith(("(if", "(when", "(unless"))


def _inside(inner: Span, outer: Span) -> bool:
    return inner.source is outer.source and outer.start < inner.start and inner.end < outer.end


def _decided(test: Any) -> bool | None:
    """The truth of a test that is always the same; None where it may vary."""
    kind = type(test)
    if kind is ast.Constant:
        return test.value is not False and test.value is not None
    if kind is ast.Lambda or (kind is ast.Reference and isinstance(test.target, Builtin)):
        return True
    if kind is ast.Application and type(test.function) is ast.Reference and isinstance(test.function.target, Builtin):
        if test.function.target.name in _COMPARISONS and len(test.arguments) == 2:
            return _compared(test.function.target.name, *test.arguments)
    return None


def _compared(name: str, left: Any, right: Any) -> bool | None:
    same = type(left) is type(right) is ast.Reference and left.target is right.target
    if same and not isinstance(left.target, Builtin):
        return name not in ("<", ">")
    values = [item.value for item in (left, right) if type(item) is ast.Constant]
    if len(values) == 2 and all(type(value) in (int, float) for value in values):
        a, b = values
        return bool({"<": a < b, ">": a > b, "<=": a <= b, ">=": a >= b}.get(name, a == b))
    return None


def _warning(test: Any, fixes: tuple[Fix, ...]) -> Diagnostic:
    always = "true" if _decided(test) else "false"
    message = f"this condition is always {always}"
    hint = None
    if type(test) is ast.Lambda or (type(test) is ast.Reference and isinstance(test.target, Builtin)):
        hint = "a function is true; call it: `(name argument ...)`"
    return Diagnostic("constant-condition", message, test.span, hint, fixes=fixes)
