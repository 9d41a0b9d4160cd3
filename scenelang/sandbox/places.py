"""Which place of a program a thread is evaluating, read off its Python frames."""

from __future__ import annotations

import sys
import threading
from types import FrameType
from typing import get_args

from scenelang.grammar import ast
from scenelang.grammar.datum import ArrayDatum, Atom, ListDatum
from scenelang.grammar.source import Source, Span
from scenelang.interpreter.library import STD
from scenelang.interpreter.procedures import Closure
from scenelang.sandbox.status import Chain, Status

_PLACED = (ListDatum, ArrayDatum, Atom, *get_args(ast.Expr), ast.Define)
_MOST_FRAMES = 300
_FIRST_GLANCE = 0.02  # seconds
_GLANCE = 0.05


def running(thread: int) -> Chain:
    """The running calls of a thread that evaluates, innermost first, as in a diagnostic's chain; the first place has no
    name."""
    frame = sys._current_frames().get(thread)
    found: list[tuple[str, Span | None]] = []
    text: Source | None = None
    frames = 0
    while frame is not None and frames < _MOST_FRAMES:
        place = _place(frame)
        if frame.f_code.co_name == "evaluate_root":
            found.append((f'"{frame.f_locals.get("word")}"', None))
        elif place is not None:
            if not found:
                found.append(("", place))
            name = _called(frame)
            if name is not None:
                found.append((name, place))
        elif text is None:
            source = frame.f_locals.get("source")
            text = source if isinstance(source, Source) and not source.name.startswith(STD) else None
        frame, frames = frame.f_back, frames + 1
    if not found and text is not None:  # it is read or checked as a whole
        return (("", Span(text, 0, 0)),)
    return tuple(found)


def _place(frame: FrameType) -> Span | None:
    """The place in a program that a frame of the evaluator works at."""
    names = frame.f_locals
    span = names["use"].span if frame.f_code.co_name == "transform" and "use" in names else names.get("span")
    if not isinstance(span, Span):
        known = ("form",) if frame.f_code.co_name == "run_form" else ("datum", "node")
        span = next((names[name].span for name in known if isinstance(names.get(name), _PLACED)), None)
    if not isinstance(span, Span) or not isinstance(span.source, Source) or span.source.name.startswith(STD):
        return None
    return span


def _called(frame: FrameType) -> str | None:
    """The word or function that a frame is calling."""
    names = frame.f_locals
    function, word = names.get("function"), names.get("name")
    if frame.f_code.co_name == "call" and isinstance(word, str):
        return f'"{word}"'
    if frame.f_code.co_name == "transform" and isinstance(word, str):  # a macro; the place is that of its use
        return f"`{word}`"
    if isinstance(function, Closure) and not function.code.name.startswith('"'):
        return f"`{function.code.name}`"
    return None


class Sampler:
    """A thread that notes every few hundredths of a second where another one is. A builtin that holds the interpreter's
    lock keeps it from looking; what it saw last is then where that builtin was called."""

    def __init__(self, status: Status, thread: int) -> None:
        self._status = status
        self._thread = thread
        self._ended = threading.Event()
        threading.Thread(target=self._look, daemon=True).start()

    def stop(self) -> None:
        self._ended.set()

    def _look(self) -> None:
        pause = _FIRST_GLANCE
        while not self._ended.wait(pause):
            try:
                chain = running(self._thread)
            except RuntimeError:  # the frames changed while they were read
                continue
            if chain and not self._ended.is_set():
                self._status.put_place(chain)
            pause = _GLANCE
