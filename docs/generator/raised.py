"""The diagnostics that a builtin raises, read from its source, so that the reference lists no other."""

from __future__ import annotations

import ast
import inspect
import textwrap
from collections.abc import Callable, Iterator
from functools import cache
from typing import Any

from scenelang.grammar.diagnostics import CODES

# Calls from the builtin to the function that raises. With 2, `ref` has `index` from the helper that words the message;
# with 3, errors of the evaluator appear that no call of the builtin causes.
_DEPTH = 2
# Errors of every call with wrong arguments; the pages say so once.
_OF_EVERY_CALL = frozenset({"type", "arity", "keyword"})
_PACKAGE = "scenelang.stdlib"


def raised_by(function: Callable[..., Any]) -> tuple[str, ...]:
    """Return the names of the diagnostics that a builtin raises, besides those of wrong arguments, sorted by code."""
    names = set(_raised(function, _DEPTH)) - _OF_EVERY_CALL
    return tuple(sorted(names, key=lambda name: CODES[name].code))


@cache
def _raised(function: Callable[..., Any], depth: int) -> frozenset[str]:
    """Return the names in a function and in those of the library that it calls, down to a depth."""
    names: set[str] = set()
    known = getattr(inspect.unwrap(function), "__globals__", {})
    for call in _calls(function):
        called = call.func.id if isinstance(call.func, ast.Name) else ""
        if called == "SceneError" and call.args and isinstance(call.args[0], ast.Constant):
            names.add(str(call.args[0].value))
        helper = known.get(called)
        if depth and inspect.isfunction(helper) and helper.__module__.startswith(_PACKAGE):
            names |= _raised(helper, depth - 1)
    return frozenset(names & CODES.keys())


def _calls(function: Callable[..., Any]) -> Iterator[ast.Call]:
    """Yield the calls in the source of a function; none for one without source, such as a class."""
    try:
        source = textwrap.dedent(inspect.getsource(inspect.unwrap(function)))
        tree = ast.parse(source)
    except (OSError, TypeError, SyntaxError):
        return
    yield from (node for node in ast.walk(tree) if isinstance(node, ast.Call))
