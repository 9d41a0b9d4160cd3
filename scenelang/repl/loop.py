"""Main loop of a REPL, independent of the front end: evaluates inputs, runs commands, and shows the results."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Protocol, TextIO

from scenelang.grammar.diagnostics import Diagnostic, LimitError, SceneError, suggest
from scenelang.repl.display import Screen, displayed
from scenelang.repl.evaluation import EvaluationOutcome, ReplEvaluation

if TYPE_CHECKING:
    from scenelang.inference.brief import Ablation, Task
    from scenelang.inference.records import InferenceSettings
    from scenelang.repl.evaluation import LiveView


class Quit(Exception):
    """Raised by ``,quit``."""


@dataclass(frozen=True, slots=True)
class Command:
    """A command, entered as a line that begins with a comma, such as ``,doc grid``.

    ``operand`` is the kind of its operand, for help and completion: "", FORM, NAME, WORD, TEXT, FILE, N."""

    name: str
    usage: str
    doc: str
    run: Callable[[Repl, str], None]
    operand: str = ""


class Background(Protocol):
    """A background thread of a REPL, such as a watched file."""

    path: str

    def again(self) -> Background:
        """Return a replacement for a thread that did not survive a fork."""
        ...

    def stop(self) -> None:
        """Stop the thread."""
        ...


@dataclass(frozen=True, slots=True)
class ModelRequest:
    """Request of ,generate or ,edit to a language model; ``task`` is that of ,generate."""

    text: str
    settings: InferenceSettings
    task: Task | None = None
    ablation: Ablation | None = None
    seed: int = 0
    runs: str | None = None
    live: TextIO | None = None


RequestReader = Callable[[str, str], ModelRequest]


def plain_request(command: str, line: str) -> ModelRequest:
    """Create a request without options, whose text is the line."""
    from scenelang.inference.brief import Ablation
    from scenelang.inference.generation import task_of
    from scenelang.inference.records import InferenceSettings

    task = task_of(line) if command == "generate" and line else None
    return ModelRequest(line, InferenceSettings(), task, Ablation.NONE)


class Repl:
    """State and dispatch of a REPL. ``request`` parses the operand of ,generate and ,edit.

    ``feed`` processes an input, and ``work`` what a background thread has ``ask``-ed for, one after the other under
    ``lock``. After ``ask``, ``wake`` makes the thread that reads inputs call ``work``: only the main thread can fork a
    checkpoint. Without a front end that can do so, the background thread does the work itself.
    """

    def __init__(
        self,
        evaluation: ReplEvaluation,
        screen: Screen,
        commands: Sequence[Command] = (),
        request: RequestReader = plain_request,
    ) -> None:
        self.request = request
        self.evaluation = evaluation
        self.screen = screen
        self.commands = commands
        self.lock = threading.RLock()
        self.watch: Background | None = None
        self.live_view: LiveView | None = None
        self.pictures: Path | None = None  # folder of images without a given file name
        self.errors = 0
        self.wake: Callable[[], None] = self.work
        self._asked: deque[Callable[[], None]] = deque()
        self._shown: EvaluationOutcome | None = None  # by the command that runs

    def feed(self, text: str) -> EvaluationOutcome:
        """Evaluate an input or run a command; errors are reported and never raised. Raises Quit."""
        with self._alone():
            return self._fed(text)

    @property
    def is_asked(self) -> bool:
        """Return whether there is something for ``work`` to do."""
        return bool(self._asked)

    def ask(self, action: Callable[[], None]) -> None:
        """Have an action done by the thread that reads inputs, once if it is asked for again before that."""
        if action not in self._asked:
            self._asked.append(action)
        self.wake()

    def work(self) -> None:
        """Do what background threads have asked for."""
        with self._alone():
            while self._asked:
                self._asked.popleft()()

    @contextmanager
    def _alone(self) -> Iterator[None]:
        """Hold the lock; restart the background threads if this process has replaced a killed one."""
        before = self.evaluation.replacements
        with self.lock:
            try:
                yield
            finally:
                if self.evaluation.replacements != before:
                    self._restart()

    def _fed(self, text: str) -> EvaluationOutcome:
        if is_command(text):
            return self._command(text)
        outcome = self.evaluation.evaluate(self.evaluation.source(text))
        self.show(outcome)
        self.changed()
        return outcome

    def _restart(self) -> None:
        """Restart background threads after this process has replaced a killed one."""
        if self.watch is not None:
            self.watch = self.watch.again()
        if self.live_view is not None:
            self.live_view = self.live_view.again()
            self.screen.write(f"the viewer is now at {self.live_view.address}")

    def open(self) -> bool:
        """Load the initial file; returns whether it succeeded."""
        file = self.evaluation.file
        if file is None:
            return True
        with self.lock:
            outcome = self.evaluation.load(file)
            self.show(outcome)
            return outcome.ok

    def show(self, outcome: EvaluationOutcome) -> None:
        """Print log, values and diagnostics of an evaluation."""
        self.screen.log(outcome.log)
        for value in outcome.values:
            text = displayed(value, self.screen.width)
            if text:
                self.screen.write(text)
        self.screen.report(outcome.diagnostics)
        self.errors += not outcome.ok
        self._shown = outcome

    def changed(self) -> None:
        """Update the viewer after definitions may have changed."""
        if self.live_view is not None:
            self.live_view.update()

    def close(self) -> None:
        """Stop background threads."""
        if self.watch is not None:
            self.watch.stop()
        if self.live_view is not None:
            self.live_view.close()

    def _command(self, text: str) -> EvaluationOutcome:
        """Run a command; an error is reported and returned as a failed outcome."""
        name, rest = split(text)
        evaluation = self.evaluation
        try:
            command = find(self.commands, name)
        except SceneError as error:
            return self._failed(error.diagnostic)
        # commands that evaluate set it in `show`
        self._shown = None
        try:
            command.run(self, rest)
        except (SceneError, RecursionError, MemoryError) as error:
            problem = evaluation.session.problem_of(error)
            assert problem is not None
            return self._failed(problem)
        except OSError as error:
            message = f"{error.strerror or error}: {error.filename or 'output'}"
            return self._failed(SceneError("file", message).diagnostic)
        except KeyboardInterrupt:
            return self._failed(LimitError("interrupted", f"`,{command.name}` was interrupted").diagnostic)
        return self._shown or EvaluationOutcome()

    def _failed(self, problem: Diagnostic) -> EvaluationOutcome:
        """Report a failed command and return its outcome."""
        self.screen.report([problem])
        self.errors += 1
        return EvaluationOutcome(diagnostics=(problem,))


def is_command(text: str) -> bool:
    """Return whether an input is a command; a comma is not otherwise valid at the top level."""
    stripped = text.lstrip()
    return stripped.startswith(",") and (stripped[1:2].isalpha() or not stripped[1:].strip())


def find(known: Sequence[Command], name: str) -> Command:
    """Find a command by name or unambiguous prefix. Raises SceneError with a suggestion."""
    exact = [command for command in known if command.name == name]
    matches = exact or [command for command in known if name and command.name.startswith(name)]
    if len(matches) == 1:
        return matches[0]
    if matches:
        listed = ", ".join(f",{command.name}" for command in matches)
        raise SceneError("value", f"ambiguous command `,{name[:40]}`: {listed}")
    near = suggest(name, [command.name for command in known])
    hint = near.replace("`", "`,", 1) if near else "see `,help` for a list of commands"
    raise SceneError("value", f"unknown command `,{name[:40]}`", hint)


def split(text: str) -> tuple[str, str]:
    """Split a command line into name and operand."""
    name, _, rest = text.strip()[1:].partition(" ")
    name = name.strip()
    return (name[:-1], f"! {rest.strip()}") if name.endswith("!") else (name, rest.strip())
