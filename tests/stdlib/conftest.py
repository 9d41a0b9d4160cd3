"""What the tests of the standard library share: a runtime, and calls of builtins by name with Python data."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.runtime.procedures import call_builtin
from scenelang.interpreter.runtime.runtime import Runtime
from scenelang.interpreter.runtime.show import show
from scenelang.interpreter.runtime.types import Builtin, Library
from scenelang.interpreter.values.limits import Limits
from scenelang.interpreter.values.values import NIL, MutableList, Pair, Vector, make_list
from scenelang.stdlib.library import IMPORTED, TOPICS, registry_of

ALL_TOPICS = tuple(map(registry_of, (*TOPICS, *IMPORTED.values())))
BUILTINS: dict[str, Builtin] = {name: entry for topic in ALL_TOPICS for name, entry in topic.entries.items()}
LIBRARY = Library(BUILTINS, {}, {}, (), {})


def new_runtime(**limits: Any) -> Runtime:
    return Runtime(LIBRARY, Limits(**{"seconds": 3600.0} | limits))  # shared by many tests, so that none times out


def scheme(value: Any) -> Any:
    """Python data as the language's: lists and tuples become lists."""
    if type(value) in (list, tuple):
        return make_list([scheme(item) for item in value])
    return value


def python(value: Any) -> Any:
    """The language's lists and vectors as Python lists."""
    if type(value) is Pair or value is NIL:
        out = []
        while type(value) is Pair:
            out.append(python(value.car))
            value = value.cdr
        assert value is NIL
        return out
    if type(value) is MutableList:
        return [python(item) for item in value.items]
    return list(value) if type(value) is Vector else value


class Caller:
    """Calls builtins on one runtime."""

    def __init__(self, runtime: Runtime) -> None:
        self.rt = runtime

    def __call__(self, name: str, *arguments: Any) -> Any:
        return call_builtin(self.rt, BUILTINS[name], [scheme(argument) for argument in arguments])

    def python(self, name: str, *arguments: Any) -> Any:
        return python(self(name, *arguments))

    def show(self, name: str, *arguments: Any) -> str:
        return show(self(name, *arguments))

    def error(self, name: str, *arguments: Any) -> SceneError:
        with pytest.raises(SceneError) as caught:
            self(name, *arguments)
        return caught.value

    def refuses(self, kind: str, name: str, *arguments: Any) -> str:
        """The message and hint of the error ``kind`` that the call raises."""
        error = self.error(name, *arguments)
        assert error.name == kind, error
        return f"{error.message} | {error.hint or ''}"


@pytest.fixture
def rt() -> Runtime:
    return new_runtime()


@pytest.fixture
def call(rt: Runtime) -> Caller:
    return Caller(rt)


def function(body: Callable[..., Any]) -> Builtin:
    """A procedure of the language from a Python function."""
    return Builtin("test", "arguments ...", "Any", lambda rt, *arguments: body(*arguments), "", None, "test")
