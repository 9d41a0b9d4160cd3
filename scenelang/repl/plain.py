"""REPL without a terminal: reads forms from a stream, and writes values and diagnostics to streams, or all as JSON."""

from __future__ import annotations

import json
import re
import signal
import sys
import threading
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TextIO

from scenelang.grammar.datum import Source
from scenelang.grammar.diagnostics import capped, to_json
from scenelang.grammar.reader import Completeness, read
from scenelang.interpreter.runtime.types import type_name
from scenelang.repl.commands import commands
from scenelang.repl.display import Screen, displayed
from scenelang.repl.evaluation import EvaluationOutcome, ReplEvaluation
from scenelang.repl.loop import Quit, Repl, RequestReader, is_command, plain_request

_SMALL = 2_000  # characters; longer inputs are parsed only when brackets balance, and again after growing
_GROWTH = 1.1


@dataclass(frozen=True, slots=True)
class Plain:
    """Plain REPL. ``prompt`` is written before each line is read; ``as_json`` writes one object per form or command."""

    source: TextIO
    out: TextIO
    errors: TextIO
    prompt: str = ""
    as_json: bool = False
    quiet: bool = False
    request: RequestReader = plain_request

    def run(self, evaluation: ReplEvaluation) -> int:
        """Process inputs until the stream ends; returns the number of failed inputs."""
        output: list[str] = []
        if self.as_json:
            screen = Screen(output.append, lambda text: None, quiet=self.quiet)
        else:
            screen = Screen(lambda text: _say(self.out, text), lambda text: _say(self.errors, text), quiet=self.quiet)
        repl = Repl(evaluation, screen, commands(), self.request)
        waiting = _Waiting(repl)
        try:
            if evaluation.file is not None:
                self._answer(repl, evaluation.load(evaluation.file), output)
            for text in self._inputs(waiting):
                for part in _parts(text) if self.as_json else [text]:
                    self._feed(repl, part, output)
        except Quit:
            pass
        finally:
            repl.close()
        return repl.errors

    def _feed(self, repl: Repl, text: str, output: list[str]) -> None:
        if not self.as_json or is_command(text):
            outcome = repl.feed(text)
            if self.as_json:
                self._object(outcome, output)
            return
        evaluation = repl.evaluation
        with repl.lock:
            self._answer(repl, evaluation.evaluate(evaluation.source(text)), output)
            repl.changed()

    def _answer(self, repl: Repl, outcome: EvaluationOutcome, output: list[str]) -> None:
        if not self.as_json:
            repl.show(outcome)
            return
        repl.errors += not outcome.ok
        self._object(outcome, output)

    def _object(self, outcome: EvaluationOutcome, output: list[str]) -> None:
        value = outcome.values[-1] if outcome.values else None
        shown = capped([d for d in outcome.diagnostics if d.is_error or not self.quiet])
        data = {
            "ok": outcome.ok,
            "value": displayed(value, 100) if outcome.values else None,
            "type": type_name(value) if outcome.values else None,
            "diagnostics": [to_json(d) for d in shown],
            "log": list(outcome.log),
            "output": "\n".join(output),
            "seconds": round(outcome.seconds, 6),
            "steps": outcome.steps,
        }
        output.clear()
        _say(self.out, json.dumps(data))

    # --- reading -----------------------------------------------------------------------------------------------

    def _inputs(self, waiting: _Waiting) -> Iterator[str]:
        """Yield commands and texts whose forms are complete or malformed; at the end of the stream, the rest."""
        text, nesting, tried = "", _Nesting(), 0
        while True:
            if self.prompt:
                self.out.write(self.prompt)
                self.out.flush()
            with waiting:
                line = self.source.readline()
            if not line:
                break
            if not text and (is_command(line) or not line.strip()):
                if line.strip():
                    yield line.strip()
                continue
            text += line
            nesting.feed(line)
            if len(text) > _SMALL and (nesting.is_open or len(text) < _GROWTH * tried):
                continue
            if read(Source("<repl>", text)).completeness is not Completeness.INCOMPLETE:
                yield text.rstrip("\n")
                text, nesting, tried = "", _Nesting(), 0
            else:
                tried = len(text)
        if text.strip():
            yield text


class _Waiting:
    """Context in which a line is awaited, and in which the main thread does what other threads ask for.

    A signal interrupts the main thread, which continues to wait after its handler (PEP 475).
    """

    def __init__(self, repl: Repl) -> None:
        self._repl = repl
        self._is_waiting = False
        main = threading.main_thread()
        if threading.current_thread() is main and hasattr(signal, "pthread_kill"):
            signal.signal(signal.SIGUSR1, lambda number, frame: self._work())
            repl.wake = lambda: signal.pthread_kill(threading.main_thread().ident or 0, signal.SIGUSR1)

    def __enter__(self) -> None:
        self._is_waiting = True
        self._work()

    def __exit__(self, *failure: object) -> None:
        self._is_waiting = False

    def _work(self) -> None:
        while self._is_waiting and self._repl.is_asked:
            self._is_waiting = False  # not during the work
            self._repl.work()
            self._is_waiting = True


_STRING = re.compile(r'\\.|"', re.S)
_COMMENT = re.compile(r"#\||\|#")
_CODE = re.compile(r'#;|;[^\n]*|#\||["()\[\]]')


class _Nesting:
    """Incremental scanner for unclosed strings, comments and brackets; each line is scanned once."""

    def __init__(self) -> None:
        self._depth = 0
        self._comments = 0
        self._is_text = False

    @property
    def is_open(self) -> bool:
        return self._is_text or self._comments > 0 or self._depth > 0

    def feed(self, line: str) -> None:
        position = 0
        while (match := self._pattern().search(line, position)) is not None:
            position = match.end()
            self._note(match[0])

    def _pattern(self) -> re.Pattern[str]:
        return _STRING if self._is_text else _COMMENT if self._comments else _CODE

    def _note(self, mark: str) -> None:
        if mark == '"':
            self._is_text = not self._is_text
        elif mark in ("#|", "|#"):
            self._comments += 1 if mark == "#|" else -1
        elif mark in ("(", "["):
            self._depth += 1
        elif mark in (")", "]"):
            self._depth -= 1


def _parts(text: str) -> list[str]:
    """Yield the forms of an input one by one, or the whole input if it cannot be parsed."""
    forms = [] if is_command(text) else read(Source("<repl>", text)).forms
    return [form.span.text for form in forms] or [text]


def _say(stream: TextIO, text: str) -> None:
    stream.write(text + "\n")
    stream.flush()


def standard(prompt: str, as_json: bool, quiet: bool, request: RequestReader = plain_request) -> Plain:
    """Create a plain REPL on the process's standard streams; invalid UTF-8 becomes replacement characters."""
    for stream in (sys.stdin, sys.stdout, sys.stderr):
        reconfigure = getattr(stream, "reconfigure", None)
        if reconfigure is not None:
            reconfigure(encoding="utf-8", errors="replace")
    return Plain(sys.stdin, sys.stdout, sys.stderr, prompt, as_json, quiet, request)
