"""The diagnostics that a builtin raises, read from its source, so that the reference lists no other."""

from __future__ import annotations

import ast
import inspect
import textwrap
from collections.abc import Callable, Iterable, Iterator
from functools import cache
from typing import Any

from scenelang.grammar.diagnostics import CODES

# Calls from the builtin to the function that raises. With 2, `ref` has `index` from the helper that words the message;
# with 3, errors of the evaluator appear that no call of the builtin causes.
_DEPTH = 2
# Errors of every call with wrong arguments; the pages say so once.
_OF_EVERY_CALL = frozenset({"type", "arity", "keyword"})
# The library, and the primitives, which read the settings of `texture`.
_PACKAGES = ("scenelang.stdlib", "scenelang.interpreter.scene.primitives")


def raised_by(function: Callable[..., Any]) -> tuple[str, ...]:
    """Return the names of the diagnostics that a builtin raises, besides those of wrong arguments, sorted by code."""
    names = set(_raised(function, _DEPTH)) - _OF_EVERY_CALL
    return tuple(sorted(names, key=lambda name: CODES[name].code))


@cache
def _raised(function: Callable[..., Any], depth: int) -> frozenset[str]:
    """Return the names in a function and in those that it calls, down to a depth."""
    names: set[str] = set()
    known = getattr(inspect.unwrap(function), "__globals__", {})
    statements = _statements(function)
    # A function that only calls another is no step: `profile-union` and `profile-difference` share the one that raises.
    depth += len(statements) == 1 and isinstance(getattr(statements[0], "value", None), ast.Call)
    for call in _calls(statements):
        called = call.func.id if isinstance(call.func, ast.Name) else ""
        if called == "SceneError" and call.args and isinstance(call.args[0], ast.Constant):
            names.add(str(call.args[0].value))
        helper = known.get(called)
        if depth and inspect.isfunction(helper) and helper.__module__.startswith(_PACKAGES):
            names |= _raised(helper, depth - 1)
    return frozenset(names & CODES.keys())


def _statements(function: Callable[..., Any]) -> list[ast.stmt]:
    """Return the body of a function without its docstring; nothing for one without source, such as a class."""
    try:
        tree = ast.parse(textwrap.dedent(inspect.getsource(inspect.unwrap(function))))
    except (OSError, TypeError, SyntaxError):
        return []
    body = tree.body[0].body if isinstance(tree.body[0], ast.FunctionDef) else tree.body
    return [each for each in body if not (isinstance(each, ast.Expr) and isinstance(each.value, ast.Constant))]


def _calls(statements: Iterable[ast.stmt]) -> Iterator[ast.Call]:
    """Yield all calls in statements."""
    yield from (node for each in statements for node in ast.walk(each) if isinstance(node, ast.Call))
