"""Evaluations of a REPL: limits, Ctrl-C, diagnostics and what is remembered, around a top level that goes on."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

from scenelang.grammar.diagnostics import Diagnostic, SceneError
from scenelang.grammar.source import Source, Span
from scenelang.interpreter.entity import Entity, Frames, Scene
from scenelang.interpreter.interactive import Given
from scenelang.interpreter.limits import Limits
from scenelang.interpreter.lint.words import find_root
from scenelang.interpreter.parts import parts_of
from scenelang.interpreter.runtime import Runtime
from scenelang.repl.tracing import Tracer
from scenelang.sandbox.supervision import Ended, limited, link
from scenelang.session import EXPANSION_DEPTH, Session, run_with_room, settled

T = TypeVar("T")
_LONGEST_INPUT = 60


@dataclass(frozen=True, slots=True, eq=False)
class Outcome:
    """What an input came to. ``values`` are those of its expressions, in order; ``diagnostics`` end with the error
    that stopped it, if any. ``seconds``, ``steps`` and ``entities`` are what it took."""

    values: tuple[Any, ...] = ()
    diagnostics: tuple[Diagnostic, ...] = ()
    log: tuple[str, ...] = ()
    seconds: float = 0.0
    steps: int = 0
    entities: int = 0

    @property
    def ok(self) -> bool:
        return not any(d.is_error for d in self.diagnostics)


@dataclass(frozen=True, slots=True, eq=False)
class Subject:
    """A scene that a command is about. ``what`` it is, in words; None where the command named it."""

    scene: Scene
    what: str | None


def _brief(text: str) -> str:
    """An input on one line, cut."""
    line = " ".join(text.split())
    return line if len(line) <= _LONGEST_INPUT else line[: _LONGEST_INPUT - 3] + "..."


class Evaluation:
    """The state of one REPL: session, top level, the file it was opened with, the number of inputs so far."""

    def __init__(self, session: Session, file: str | None = None) -> None:
        self.session = session
        self.file = file
        self.seed = session.options.seed
        self.inputs = 0
        self.tracer = Tracer()
        self.replacements = 0  # processes that had to be ended
        self.loaded: str | None = None  # the last file that was loaded by command
        self._macros: Runtime | None = None
        self.reset()

    def reset(self) -> None:
        """Begin again with nothing defined."""
        main = Source(self.file or "<repl>", "")
        self.top = self.session.top_level(main, self._macros_started)
        self._recent: tuple[str, Any] | None = None  # the last input and its value, while nothing was defined since
        self.top.rt.streams.seed(self.seed)

    def _macros_started(self, runtime: Runtime) -> None:
        self._macros = runtime

    def set_seed(self, seed: int) -> None:
        """Start the random streams anew."""
        self.seed = seed % (1 << 32)
        self.top.rt.streams.seed(self.seed)
        self.top.rt.forget_calls()

    # --- evaluating --------------------------------------------------------------------------------------------

    def source(self, text: str) -> Source:
        """The next input as a source."""
        self.inputs += 1
        return Source(f"<repl {self.inputs}>", text)

    def evaluate(self, source: Source, whole: bool = False) -> Outcome:
        """Evaluate the forms of an input; never raises for a mistake in them."""

        def work(give: Callable[[Given], None], warn: Callable[[Diagnostic], None]) -> None:
            watched = link()
            if watched is not None:
                watched.note(Span(source, 0, len(source.text)))
            self.top.evaluate(source, give, warn, whole)

        return self._account(work, source, whole)

    def load(self, path: str) -> Outcome:
        """Evaluate a file as one input."""
        try:
            source = self.session.source(path)
        except SceneError as error:
            return Outcome(diagnostics=(error.diagnostic,))
        return self.evaluate(source, whole=True)

    def reload(self, path: str) -> Outcome:
        """Evaluate a file again; what its last version defined and this one does not is forgotten."""
        try:
            source = self.session.source(path)
        except SceneError as error:
            return Outcome(diagnostics=(error.diagnostic,))
        outcome = self.evaluate(source, whole=True)
        if outcome.ok:
            self.top.forget_versions(source)
        return outcome

    def _account(
        self,
        work: Callable[[Callable[[Given], None], Callable[[Diagnostic], None]], None],
        source: Source,
        whole: bool,
    ) -> Outcome:
        values: list[Any] = []
        found: list[Diagnostic] = []
        rt = self.top.rt

        def give(given: Given) -> None:
            if given.is_expression and given.value is not None:
                values.append(given.value)
                self.top.latest.remember(given.value)

        started = time.perf_counter()
        problem = self.attempt(lambda: work(give, found.append))
        if values or problem is None:
            self._recent = (_brief(source.text), values[-1]) if values and not whole else None
        seconds = time.perf_counter() - started
        found += rt.warnings.values()
        shown = list(settled(found, {d.span.source.name: d.span.source for d in found if d.span}.values()))
        if problem is not None:
            shown.append(problem)
        return Outcome(tuple(values), tuple(shown), tuple(rt.log), seconds, rt.meter.total, rt.entities)

    def attempt(self, action: Callable[[], Any]) -> Diagnostic | None:
        """Run an action as an evaluation of its own; what went wrong, if anything, becomes ``*e``."""
        try:
            self.run(action)
        except (SceneError, RecursionError, MemoryError) as error:
            problem = self.session.problem_of(error)
            assert problem is not None
            kept = error if isinstance(error, SceneError) else SceneError(problem.name, problem.message, problem.hint)
            self.top.latest.remember_error(kept)
            return problem
        return None

    def run(self, action: Callable[[], T]) -> T:
        """Run an action under limits that begin anew; Ctrl-C ends it. Raises what it raises, and Ended, with all as it
        was before, where a monitor had to end the process."""
        rt = self.top.rt
        rt.renew()
        self.tracer.attach(self.top)
        depth = max(EXPANSION_DEPTH, self.session.options.limits.depth)
        folders = self.session.folders(self.top.main)
        with self._restored(), limited(self.session.options.limits):
            return run_with_room(action, depth, self._cancel, folders)

    @contextmanager
    def _restored(self) -> Iterator[None]:
        """A copy of this process stands by: it goes on from here when this one has to be ended. Threads do not come
        along, so only the main thread can be copied."""
        watched = link()
        if watched is None or threading.current_thread() is not threading.main_thread():
            yield
            return
        checkpoint = watched.checkpoint()
        if checkpoint.problem is not None:
            self.replacements += 1
            raise Ended(checkpoint.problem)
        try:
            yield
        finally:
            checkpoint.drop()

    def _cancel(self) -> None:
        self.top.rt.meter.cancel()
        if self._macros is not None:
            self._macros.meter.cancel()

    # --- scenes ------------------------------------------------------------------------------------------------

    def subject_of(self, text: str) -> Subject:
        """The scene of a form; without one that of the value which the last input gave, or else of the root, as it is
        defined now. Raises SceneError."""
        if text.strip():
            return Subject(self._scene_of_form(text), None)
        if self._recent is not None:
            form, value = self._recent
            scene = self.as_scene(value)
            if scene is not None:
                return Subject(scene, f"`{form}`, the last value")
        try:
            scene = self.root()
        except SceneError as error:
            last = self.top.latest.value
            older = self.as_scene(last) if last is not None else None
            if error.name != "no-root" or older is None:
                raise
            return Subject(older, "`*1`, an earlier value")
        return Subject(scene, f'the root "{scene.word}"')

    def _scene_of_form(self, text: str) -> Scene:
        values: list[Any] = []
        source = self.source(text)
        self.run(lambda: self.top.evaluate(source, lambda given: values.append(given.value), lambda _: None))
        value = values[-1] if values else None
        scene = self.as_scene(value)
        if scene is None:
            raise SceneError("type", "this is no scene", "a scene is an entity, parts, or frames")
        return scene

    def as_scene(self, value: Any) -> Scene | None:
        """A value as a scene: an entity, parts, frames; None for anything else."""
        if isinstance(value, Scene):
            return value
        if type(value) is Entity:
            return Scene(value.word, [value], False)
        rt = self.top.rt
        try:
            if type(value) is Frames:
                roots = [rt.make_entity("value", rt.handle("z1"), parts) for parts in value.frames]
                return Scene("value", roots, True)
            parts = parts_of(rt, value, "value")
        except SceneError:
            return None
        return Scene("value", [rt.make_entity("value", rt.handle("z1"), parts)], False) if parts else None

    def root(self) -> Scene:
        """The scene of the root word, as `run` makes it. Raises SceneError when there is none."""
        session = self.session

        def work() -> Scene:
            program = self.top.program()
            word = session.options.root or find_root(program)[0]
            return self.top.run_root(program, word, self.seed)

        if session.options.z_entries:
            return self._root_with_entries()
        return self.run(work)

    def _root_with_entries(self) -> Scene:
        """Entries for automatic numbers need a second run, so the definitions run as a program of their own."""
        from scenelang.repl.saving import program_text

        result = self.session.evaluate(Source(self.top.main.name, program_text(self.top)))
        if result.scene is None:
            errors = [d for d in result.diagnostics if d.is_error]
            raise SceneError(errors[0].name, errors[0].message, errors[0].hint)
        return result.scene

    @property
    def limits(self) -> Limits:
        return self.session.options.limits

    @property
    def folder(self) -> Path:
        """The folder of the file that the REPL was opened with, else the working one."""
        return Path(self.file).parent if self.file else Path.cwd()
