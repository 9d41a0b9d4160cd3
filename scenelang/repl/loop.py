"""One REPL apart from how lines come in: an input is evaluated or a command run, and what comes of it is shown."""

from __future__ import annotations

import threading
from pathlib import Path
from typing import TYPE_CHECKING

from scenelang.grammar.diagnostics import Diagnostic, LimitError, SceneError
from scenelang.repl.commands import find, is_command, split
from scenelang.repl.display import displayed
from scenelang.repl.evaluation import Evaluation, Outcome
from scenelang.repl.screen import Screen

if TYPE_CHECKING:
    from scenelang.repl.live_view import LiveView
    from scenelang.repl.watching import Watch


class Quit(Exception):
    """The user wants to leave."""


class Repl:
    """``feed`` takes one input after the other; ``lock`` is held while one is worked on, since a watched file is
    evaluated by a thread of its own."""

    def __init__(self, evaluation: Evaluation, screen: Screen) -> None:
        self.evaluation = evaluation
        self.screen = screen
        self.lock = threading.RLock()
        self.watch: Watch | None = None
        self.live_view: LiveView | None = None
        self.pictures: Path | None = None  # the folder for pictures that were given no name
        self.errors = 0

    def feed(self, text: str) -> Outcome:
        """Evaluate an input or run a command; never raises for a mistake in it. Raises Quit."""
        before = self.evaluation.replacements
        with self.lock:
            try:
                return self._fed(text)
            finally:
                if self.evaluation.replacements != before:
                    self._restart()

    def _fed(self, text: str) -> Outcome:
        if is_command(text):
            return self._command(text)
        outcome = self.evaluation.evaluate(self.evaluation.source(text))
        self.show(outcome)
        self.changed()
        return outcome

    def _restart(self) -> None:
        """This process has taken the place of another one, whose threads are gone: start them again."""
        if self.watch is not None:
            self.watch = self.watch.again()
        if self.live_view is not None:
            self.live_view = self.live_view.again()
            self.screen.write(f"the viewer is now at {self.live_view.address}")

    def open(self) -> bool:
        """Load the file that the REPL was opened with; whether that went well."""
        file = self.evaluation.file
        if file is None:
            return True
        with self.lock:
            outcome = self.evaluation.load(file)
            self.show(outcome)
            return outcome.ok

    def show(self, outcome: Outcome) -> None:
        """Show log, values and diagnostics of an evaluation."""
        self.screen.log(outcome.log)
        for value in outcome.values:
            text = displayed(value, self.screen.width)
            if text:
                self.screen.write(text)
        self.screen.report(outcome.diagnostics)
        self.errors += not outcome.ok

    def changed(self) -> None:
        """Something may be defined that was not: tell the viewer."""
        if self.live_view is not None:
            self.live_view.update()

    def close(self) -> None:
        """End what runs in the background."""
        if self.watch is not None:
            self.watch.stop()
        if self.live_view is not None:
            self.live_view.close()

    def _command(self, text: str) -> Outcome:
        name, rest = split(text)
        evaluation = self.evaluation
        try:
            find(name).run(self, rest)
        except (SceneError, RecursionError, MemoryError) as error:
            problem = evaluation.session.problem_of(error)
            assert problem is not None
            return self._failed(problem)
        except OSError as error:
            said = f"{error.strerror or error}: {error.filename or 'output'}"
            return self._failed(SceneError("file", said).diagnostic)
        except KeyboardInterrupt:
            return self._failed(LimitError("interrupted", f"`,{find(name).name}` was interrupted").diagnostic)
        return Outcome()

    def _failed(self, problem: Diagnostic) -> Outcome:
        """What a command comes to that could not do its work."""
        self.screen.report([problem])
        self.errors += 1
        return Outcome(diagnostics=(problem,))
