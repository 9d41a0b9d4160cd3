"""Errors of endless recursion: the call that repeats, how its arguments develop, and the test that they miss.

The calls are read from the local variables of Python's frames in the traceback of the stack overflow.
"""

from __future__ import annotations

import math
import re
from collections import Counter, deque
from collections.abc import Iterator, Sequence
from itertools import islice, pairwise
from types import TracebackType
from typing import Any

from scenelang.grammar.datum import Span
from scenelang.grammar.diagnostics import Diagnostic
from scenelang.grammar.reader import piece_at
from scenelang.interpreter.compile.generated import site_of
from scenelang.interpreter.runtime.procedures import Cell, Closure, ClosureCode
from scenelang.interpreter.runtime.show import show
from scenelang.interpreter.scene.primitives import is_word
from scenelang.interpreter.values.limits import Limits

_MAX_TRACEBACK_FRAMES = 400  # Python frames read after a stack overflow; a call of the language takes ten or fewer
_MAX_SHOWN_CALLS = 40  # innermost calls in the diagnostic of a stack overflow
_SHOWN_VALUES = 4  # of an argument, in the outermost calls
_MAX_VALUE = 20  # characters of an argument

Chain = list[tuple[str, Span | None]]


def depth_error(limits: Limits, error: RecursionError) -> Diagnostic:
    """Return the diagnostic of a stack overflow, at the call that repeats."""
    chain = _innermost_calls(error)
    counts = Counter(name for name, _ in chain)
    # Of functions that call each other, the stack may end in any: the same one is named every time.
    names = sorted((name for name in counts if counts[name] > 1), key=lambda name: (not name.startswith('"'), name))
    repeated = next((call for call in chain if names and call[0] == names[0]), None)
    if repeated is None:
        message = f"maximum call depth of {limits.depth:,} exceeded"
        span = chain[0][1] if chain else None
        hint = "check for infinite recursion, or raise the limit with --max-depth"
        return Diagnostic("depth", message, span, hint, (), tuple(chain[:_MAX_SHOWN_CALLS]))
    name, span = repeated
    message = f"{name} calls itself without end (stopped at the maximum call depth of {limits.depth:,})"
    hint = _advice(name, span, _developments(name, error))
    while chain and chain[0] != repeated:  # inside the last call
        chain.pop(0)
    return Diagnostic("depth", message, span, hint, (), tuple(chain[:_MAX_SHOWN_CALLS]))


def _innermost_calls(error: RecursionError) -> Chain:
    """Return the innermost calls, the last one first.

    ``call`` of the interpreter has the word, the closures and functions of the compiler (``compile/generate``) the
    function and the span.
    """
    chain: Chain = []
    running: str | None = None
    for entry in reversed(deque(_entries(error), maxlen=_MAX_TRACEBACK_FRAMES)):
        frame = entry.tb_frame
        names = frame.f_locals
        site = site_of(entry)
        if site is not None:
            names = {"function": site[0], "span": site[1]}
        function, word, span = names.get("function"), names.get("name"), names.get("span")
        if frame.f_code.co_name == "call" and isinstance(word, str):
            running = f'"{word}"'
        elif isinstance(function, Closure) and not function.code.name.startswith('"'):  # words are recorded by `call`
            running = f"`{function.code.name}`"
        if running is not None and isinstance(span, Span):
            chain.append((running, span))
            running = None
    return chain


def _entries(error: RecursionError) -> Iterator[TracebackType]:
    """Iterate over the entries of a traceback, the outermost first."""
    traceback = error.__traceback__
    while traceback is not None:
        yield traceback
        traceback = traceback.tb_next


def _developments(name: str, error: RecursionError) -> dict[str, list[Any]]:
    """Return the values of each parameter of a function in its outermost calls."""
    values: dict[str, list[Any]] = {}
    for code, frame in islice(_calls_of(name.strip("`"), error), _SHOWN_VALUES):
        for parameter in code.parameters:
            if parameter.slot is not None and parameter.slot < len(frame):
                value = frame[parameter.slot]
                values.setdefault(parameter.name, []).append(value.value if type(value) is Cell else value)
    return values


def _calls_of(name: str, error: RecursionError) -> Iterator[tuple[ClosureCode, list[Any]]]:
    """Iterate over the calls of a function, the outermost first: its code, and its variables."""
    seen: set[int] = set()
    for call in map(_frame_of, _entries(error)):
        if call is not None and call[0].name == name and id(call[1]) not in seen:
            seen.add(id(call[1]))
            yield call


def _frame_of(entry: TracebackType) -> tuple[ClosureCode, list[Any]] | None:
    """Return the code and the variables of a call of the language at an entry of a traceback."""
    names = entry.tb_frame.f_locals
    code, frame = names.get("code"), names.get("frame")
    return (code, frame) if isinstance(code, ClosureCode) and type(frame) is list else None


def _advice(name: str, span: Span | None, values: dict[str, list[Any]]) -> str:
    """Return the hint for a function that calls itself without end."""
    word = name.strip('"')
    if name.startswith('"') and is_word(word):
        return f"{name} is bound by the program, so it is no longer the primitive: give your word another name"
    changing = {key: series for key, series in values.items() if any(a != b for a, b in pairwise(series))}
    for key, series in changing.items():
        shown = ", ".join(_shown_value(value) for value in series)
        was = f"`{key}` is {shown}, ..."
        numbers = [value for value in series if type(value) in (int, float)]
        test = _missed_test(key, numbers, span) if len(numbers) == len(series) else None
        if test is not None:
            return f"{was} and never makes `{test[0]}` true: write `{test[1]}`"
        return f"{was}: test when to stop, as `(if {_stopping_test(key, numbers)} ... (union))`"
    if values:
        return "its arguments are the same in every call: change one, and test when to stop, `(if test value (...))`"
    return "it has no parameter that could end it: pass one that changes, and test when to stop"


def _shown_value(value: Any) -> str:
    """Return a value of a parameter, a number without the digits of rounding errors."""
    return f"{value:.4g}" if type(value) is float else show(value, _MAX_VALUE)


def _stopping_test(key: str, numbers: Sequence[float]) -> str:
    """Return a test that a number which falls or rises from call to call passes in its first calls."""
    if len(numbers) < 2 or numbers[0] == numbers[-1] or not all(map(math.isfinite, numbers)):
        return f"(> {key} ...)"
    if numbers[-1] > numbers[0]:
        return f"(< {key} {max(10, math.ceil(numbers[-1] * 2))})"
    is_counted = all(type(number) is int for number in numbers)
    return f"(> {key} {0 if is_counted or numbers[0] <= 0 else float(f'{numbers[0] / 10:.1g}'):g})"


def _missed_test(key: str, numbers: Sequence[float], span: Span | None) -> tuple[str, str] | None:
    """Return the test for one value that a rising or falling argument skips, and the test that it cannot skip."""
    if span is None or len(numbers) < 2:
        return None
    text = span.source.text
    before = text.rfind("\n(", 0, span.start) + 1
    form = text[slice(*piece_at(text, before))]
    for test, goal in _tests_of(key, form):
        is_falling = numbers[-1] < numbers[0]
        is_passed = numbers[-1] < goal if is_falling else numbers[-1] > goal
        if is_passed and goal not in numbers:
            return test, f"({'<=' if is_falling else '>='} {key} {goal:g})"
    return None


def _tests_of(key: str, form: str) -> Iterator[tuple[str, float]]:
    """Iterate over the tests of a form whether a variable is one number, with that number."""
    name = re.escape(key)
    for match in re.finditer(rf"\((?:=|eq\?|eqv\?|equal\?) {name} (-?[\d.]+)\)", form):
        yield match[0], float(match[1])
    for match in re.finditer(rf"\((?:=|eq\?|eqv\?|equal\?) (-?[\d.]+) {name}\)", form):
        yield match[0], float(match[1])
    for match in re.finditer(rf"\(zero\? {name}\)", form):
        yield match[0], 0.0
