"""Calls of chosen words and functions, written into the log as they happen."""

from __future__ import annotations

from typing import Any

from scenelang.interpreter.interactive import TopLevel
from scenelang.interpreter.procedures import TAIL, Closure, Frame
from scenelang.interpreter.show import show

MOST_LINES = 200
_WIDEST = 60
_DEEPEST = 20


class Tracer:
    """``names``: functions by name, words in quotes. A traced function runs through a body that tells of it."""

    def __init__(self) -> None:
        self.names: set[str] = set()
        self._depth = 0
        self._lines = 0

    def attach(self, top: TopLevel) -> None:
        """Have every traced name's present function tell of its calls, in the evaluation that begins."""
        self._depth = self._lines = 0
        for name in self.names:
            function = function_of(top, name)
            if function is not None and function.body is function.code.body:
                function.body = self._telling(top, name, function)
                top.rt.forget_calls()

    def toggle(self, top: TopLevel, name: str) -> bool:
        """Trace a name, or trace it no more; whether it is traced now."""
        if name not in self.names:
            self.names.add(name)
            return True
        self.names.discard(name)
        function = function_of(top, name)
        if function is not None:
            function.body = function.code.body
        return False

    def _telling(self, top: TopLevel, name: str, function: Closure) -> Any:
        rt, code = top.rt, function.code
        body = code.body

        def run(frame: Frame) -> Any:
            arguments = " ".join(show(frame[p.slot], _WIDEST) for p in code.parameters)
            indent = "  " * min(self._depth, _DEEPEST)
            self._tell(top, f"{indent}({name}{' ' if arguments else ''}{arguments})")
            self._depth += 1
            try:
                value = body(frame)
                while value is TAIL:
                    rt.tick()
                    value = rt.next_body(rt.next_frame)
            finally:
                self._depth -= 1
            self._tell(top, f"{indent}=> {show(value, _WIDEST)}")
            return value

        return run

    def _tell(self, top: TopLevel, line: str) -> None:
        self._lines += 1
        if self._lines <= MOST_LINES:
            top.rt.print(line)
        elif self._lines == MOST_LINES + 1:
            top.rt.print(f"... more than {MOST_LINES} lines of trace")


def function_of(top: TopLevel, name: str) -> Closure | None:
    """The function that a name is bound to now; a word is a name in quotes."""
    if name.startswith('"'):
        cell = top.rt.words.get(name[1:-1])
        value = cell.function if cell is not None else None
    else:
        try:
            value = top.value_of(name)
        except KeyError:
            return None
    return value if type(value) is Closure else None
