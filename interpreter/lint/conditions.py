"""Conditions that are always true or always false."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any

from scenelang.grammar import ast
from scenelang.grammar.datum import ListDatum
from scenelang.grammar.diagnostics import Diagnostic, Edit, Fix
from scenelang.grammar.reader import read
from scenelang.grammar.source import Source, Span
from scenelang.interpreter.library import Builtin
from scenelang.interpreter.lint.removal import is_inert, spaced, written_nodes

_BY_TYPE = frozenset(("eq?", "eqv?", "equal?"))
_COMPARISONS = frozenset(("=", "<", ">", "<=", ">=", "eq?", "eqv?", "equal?"))

_MOST_READ = 200_000  # letters of conditions of one form that are read again for a fix: they may be nested deeply


def constant_conditions(nodes: Iterable[Any], form: Any) -> Iterator[Diagnostic]:
    """Tests of ``if`` and its kin, and operands of ``and`` and ``or``, that the text alone decides."""
    written = {id(node) for node in written_nodes(form)}
    letters = _MOST_READ
    for node in nodes:
        kind = type(node)
        if kind is ast.If and node.span.expansion is None:
            letters -= node.span.end - node.span.start
            yield from _of_choice(node, id(node) in written, letters > 0)
        elif kind is ast.And or kind is ast.Or:
            for item in node.items[:-1]:
                if item.span.expansion is None and _decided(item) is not None:
                    yield _warning(item, ())


def _of_choice(node: ast.If, is_written: bool, is_read: bool) -> Iterator[Diagnostic]:
    always = _decided(node.test)
    if always is None or node.test.span.expansion is not None or _is_default(node, always):
        return
    kept = node.then if always else node.otherwise
    text = node.span.text if is_read else ""
    fixes: tuple[Fix, ...] = ()
    if text.startswith("(if ") and kept is not None and kept.span.expansion is None and _inside(kept.span, node.span):
        branch = _branch(text, 2 if always else 3)
        replacement = spaced(node.span, branch) if branch is not None else None
        if replacement is not None:
            safe = is_written and _cannot_fail(node.test)
            fixes = (Fix("Keep only the branch that runs", (Edit(node.span, replacement),), safe),)
    yield _warning(node.test, fixes)


def _branch(text: str, position: int) -> str | None:
    """The text of a branch of an ``if`` as it is written, with a prefix such as a quote."""
    forms = read(Source("<if>", text)).forms
    items = forms[0].items if forms and isinstance(forms[0], ListDatum) else ()
    return items[position].span.text if position < len(items) else None


def _cannot_fail(test: Any) -> bool:
    """Whether a test that is always the same cannot fail either, as a comparison of a variable with itself can."""
    if type(test) is ast.Application:
        return all(type(item) is ast.Constant for item in test.arguments)
    return is_inert(test)


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
    if name in _BY_TYPE and type(getattr(left, "value", None)) is not type(getattr(right, "value", None)):
        return None  # 1 and 1. are equal numbers of two types
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
