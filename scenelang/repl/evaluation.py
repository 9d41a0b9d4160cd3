"""Evaluation of REPL inputs with limits, interruption, diagnostics and history, on an incremental top level."""

from __future__ import annotations

import re
import shutil
import tempfile
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from itertools import chain
from pathlib import Path
from typing import Any, TypeVar

from scenelang.grammar.datum import Source, Span, Symbol
from scenelang.grammar.diagnostics import Diagnostic, SceneError, moved_diagnostic
from scenelang.interpreter.checker.lint import find_root
from scenelang.interpreter.checker.program import TopForm
from scenelang.interpreter.compile.generated import forget
from scenelang.interpreter.evaluation.evaluate import ProgramRun, is_plain, is_same
from scenelang.interpreter.evaluation.interactive import FormResult, TopLevel, is_assignment, names_of
from scenelang.interpreter.expand.scope import Macro, base_name
from scenelang.interpreter.runtime.parts import parts_of
from scenelang.interpreter.runtime.procedures import TAIL, Closure, Frame
from scenelang.interpreter.runtime.runtime import Runtime
from scenelang.interpreter.runtime.show import show
from scenelang.interpreter.scene.entity import Entity, Frames, Scene
from scenelang.interpreter.values.limits import Limits
from scenelang.reference import primer
from scenelang.repl.display import displayed, signature_of
from scenelang.sandbox.supervision import Ended, limited, link
from scenelang.sandbox.worker import Worker
from scenelang.session.formatting import formatted
from scenelang.session.session import EXPANSION_DEPTH, Options, Session, run_with_room, settled
from scenelang.viewer import workspace
from scenelang.viewer.server import ViewServer

# Saving the definitions of a session as a program.


def program_text(top: TopLevel) -> str:
    """Return the current definitions with their comments as a formatted program; empty if there are none."""
    seen: set[str] = set()
    texts = []
    for form in top.persistent_forms():
        texts.append(_with_comment(top, form, seen))
        seen |= names_of(form)
    text = "\n\n".join(texts)
    return formatted(text + "\n") if text else ""


def checked_program(session: Session, top: TopLevel, name: str) -> str:
    """Return ``program_text`` after checking that it gives the values of the session.

    Raises SceneError if nothing is defined, or if a value was made with an older version of another definition.
    """
    text = program_text(top)
    if not text:
        raise SceneError("value", "nothing to save: no definitions")
    errors = [d for d in session.check(Source(name, text)).diagnostics if d.is_error]
    if errors:
        hint = "enter the interdependent definitions again, in order"
        raise SceneError(errors[0].name, f"the definitions do not load in this order: {errors[0].message}", hint)
    for variable, value in _values(session, Source(name, text)).items():
        try:
            old = top.value_of(variable)
        except KeyError:
            continue
        if is_plain(old) and is_plain(value) and not is_same(old, value):
            message = f"`{variable}` is {show(old, _MAX_WIDTH)} here, but {show(value, _MAX_WIDTH)} in a saved program"
            raise SceneError("value", message, f"what it was made with has changed since: define `{variable}` again")
    return text


def _values(session: Session, source: Source) -> dict[str, Any]:
    """Evaluate the definitions of a program and return the values of its variables."""
    program = session.check(source).program
    if program is None:
        return {}
    run = ProgramRun(session.library, session.runtime_of(source))
    with limited(session.options.limits):
        run_with_room(lambda: run.run_forms(program), session.options.limits.depth)
    cells = ((base_name(Symbol(variable.name)), cell.value) for variable, cell in run.globals.items())
    return {variable: value for variable, value in cells if value is not None}


def _with_comment(top: TopLevel, form: TopForm, seen: set[str]) -> str:
    """Return a form with its comment; a redefinition of a value becomes an assignment."""
    texts: Sequence[str] = [datum.span.text for datum in form.datums]
    if is_assignment(form) and names_of(form) <= seen:
        texts = [re.sub(r"define", "set!", texts[0], count=1)]
    return "\n".join([*top.comment_of(form), *texts])


# Tracing of calls to the log.


MAX_LINES = 200
_MAX_WIDTH = 60
_MAX_DEPTH = 20


class Tracer:
    """Traces calls of functions and words. ``names`` contains function names, and words in quotes; a traced function
    runs through a wrapper that prints its calls."""

    def __init__(self) -> None:
        self.names: set[str] = set()
        self._depth = 0
        self._lines = 0

    def attach(self, top: TopLevel) -> None:
        """Wrap the current function of every traced name, at the start of an evaluation."""
        self._depth = self._lines = 0
        for name in self.names:
            function = function_of(top, name)
            if function is not None and function.traced is None:
                function.traced = self._telling(top, name, function)
                function.code.exposure.is_exposed = True  # its value is printed
                function.arity = -1
                forget(top.rt, function)
                top.rt.invalidate_calls()

    def toggle(self, top: TopLevel, name: str) -> bool:
        """Toggle tracing of a name; returns whether it is traced now."""
        if name not in self.names:
            self.names.add(name)
            return True
        self.names.discard(name)
        function = function_of(top, name)
        if function is not None:
            function.traced = None
            function.arity = function.code.arity
        return False

    def _telling(self, top: TopLevel, name: str, function: Closure) -> Any:
        rt, code = top.rt, function.code

        def run(frame: Frame) -> Any:
            arguments = " ".join(show(frame[p.slot], _MAX_WIDTH) for p in code.parameters)
            indent = "  " * min(self._depth, _MAX_DEPTH)
            self._tell(top, f"{indent}({name}{' ' if arguments else ''}{arguments})")
            self._depth += 1
            try:
                value = code.body(frame)
                while value is TAIL:
                    rt.tick()
                    value = rt.next_body(rt.next_frame)
            finally:
                self._depth -= 1
            self._tell(top, f"{indent}=> {show(value, _MAX_WIDTH)}")
            return value

        return run

    def _tell(self, top: TopLevel, line: str) -> None:
        self._lines += 1
        if self._lines <= MAX_LINES:
            top.rt.print(line)
        elif self._lines == MAX_LINES + 1:
            top.rt.print(f"... more than {MAX_LINES} lines of trace")


def function_of(top: TopLevel, name: str) -> Closure | None:
    """Return the function currently bound to a name; a word is a name in quotes."""
    if name.startswith('"'):
        cell = top.rt.words.get(name[1:-1])
        value = cell.function if cell is not None else None
    else:
        try:
            value = top.value_of(name)
        except KeyError:
            return None
    return value if type(value) is Closure else None


T = TypeVar("T")
_MAX_INPUT_LENGTH = 60


_Work = Callable[[Callable[[FormResult], None], Callable[[Diagnostic], None]], None]


@dataclass(frozen=True, slots=True, eq=False)
class EvaluationOutcome:
    """Result of an input. ``values`` are the values of its expressions, in order; ``diagnostics`` ends with the error
    that stopped it, if any. ``seconds``, ``steps`` and ``entities`` are its cost."""

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
class ReplSubject:
    """Scene that a command operates on. ``what`` describes it; None if the command specified it."""

    scene: Scene
    what: str | None


def _brief(text: str) -> str:
    """Shorten an input to one line."""
    line = " ".join(text.split())
    return line if len(line) <= _MAX_INPUT_LENGTH else line[: _MAX_INPUT_LENGTH - 3] + "..."


# What people type to leave a REPL or to get help, and the command that does it here.
_COMMANDS = {
    **dict.fromkeys(("help", "?", "h"), "`,help` lists the commands, `,doc name` explains a name"),
    **dict.fromkeys(("quit", "exit", "bye", "q"), "`,quit` or Ctrl-D ends the session"),
    "clear": "Ctrl-L clears the screen", "history": "the last values are `*1`, `*2` and `*3`",
}  # fmt: skip


def _with_command(problem: Diagnostic) -> Diagnostic:
    """Replace the hint of an undefined name that is a command in other REPLs."""
    text = problem.span.text if problem.name == "unbound" and problem.span is not None else ""
    hint = _COMMANDS.get(text)
    return replace(problem, hint=hint, fixes=()) if hint is not None else problem


class ReplEvaluation:
    """State of a REPL: session, top level, initial file and number of inputs."""

    def __init__(self, session: Session, file: str | None = None) -> None:
        self.session = session
        self.file = file
        self.seed = session.options.seed
        self.inputs = 0
        self.tracer = Tracer()
        self.replacements = 0  # number of killed processes
        self.loaded: str | None = None  # last file loaded by a command
        self._macros: Runtime | None = None
        self.reset()

    def reset(self) -> None:
        """Remove all definitions."""
        main = Source(self.file or "<repl>", "")
        self.top = self.session.top_level(main, self._macros_started)
        self._recent: tuple[str, Any] | None = None  # last input and its value, until the next definition
        self.top.rt.streams.seed(self.seed)

    def _macros_started(self, runtime: Runtime) -> None:
        self._macros = runtime

    def set_seed(self, seed: int) -> None:
        """Seed the random streams."""
        self.seed = seed % (1 << 32)
        self.top.rt.streams.seed(self.seed)
        self.top.rt.invalidate_calls()

    # --- evaluating --------------------------------------------------------------------------------------------

    def source(self, text: str) -> Source:
        """Return the next input as a source."""
        self.inputs += 1
        return Source(f"<repl {self.inputs}>", text)

    def evaluate(self, source: Source, whole: bool = False) -> EvaluationOutcome:
        """Evaluate the forms of an input; errors are returned as diagnostics and never raised."""

        work: _Work = lambda give, warn: self.top.evaluate(source, give, warn, whole)
        return self._account(work, source, whole=whole)

    def load(self, path: str) -> EvaluationOutcome:
        """Evaluate a file as one input."""
        try:
            source = self.session.source(path)
        except SceneError as error:
            return EvaluationOutcome(diagnostics=(error.diagnostic,))
        return self.evaluate(source, whole=True)

    def reload(self, path: str) -> EvaluationOutcome:
        """Evaluate a file again, apart from unchanged functions, and remove definitions of its previous version that it
        no longer contains."""
        try:
            source = self.session.source(path)
        except SceneError as error:
            return EvaluationOutcome(diagnostics=(error.diagnostic,))
        work: _Work = lambda give, warn: self.top.reload(source, give, warn)
        return self._account(work, source, whole=True)

    def _account(self, work: _Work, source: Source, *, whole: bool) -> EvaluationOutcome:
        """Run an evaluation and return its outcome: values, diagnostics, log, time and counts."""
        values: list[Any] = []
        diagnostics: list[Diagnostic] = []
        rt = self.top.rt

        def give(given: FormResult) -> None:
            if given.is_expression and given.value is not None:
                values.append(given.value)
                self.top.history.remember(given.value)

        started = time.perf_counter()
        watched = link()
        if watched is not None:
            # the position that the monitor reports if it has to kill this process
            watched.note(Span(source, 0, len(source.text)))
        problem = self.attempt(lambda: work(give, diagnostics.append))
        if values or problem is None:
            self._recent = (_brief(source.text), values[-1]) if values and not whole else None
        seconds = time.perf_counter() - started
        diagnostics = [moved_diagnostic(each, self.top.place) for each in (*diagnostics, *rt.warnings.values())]
        if problem is not None:
            diagnostics.append(_with_command(problem))
        shown = settled(diagnostics, {d.span.source.name: d.span.source for d in diagnostics if d.span}.values())
        return EvaluationOutcome(tuple(values), shown, tuple(rt.log), seconds, rt.meter.total, rt.entities)

    def attempt(self, action: Callable[[], Any]) -> Diagnostic | None:
        """Run an action as a separate evaluation; an error is stored in ``*e`` and returned."""
        try:
            self.run(action)
        except (SceneError, RecursionError, MemoryError) as error:
            problem = self.session.problem_of(error)
            assert problem is not None
            scene_error = (
                error if isinstance(error, SceneError) else SceneError(problem.name, problem.message, problem.hint)
            )
            self.top.history.remember_error(scene_error)
            return problem
        return None

    def run(self, action: Callable[[], T]) -> T:
        """Run an action under fresh limits; Ctrl-C interrupts it. Re-raises its exceptions; raises Ended, with the
        previous state restored, if the monitor killed the process."""
        rt = self.top.rt
        rt.reset()
        self.tracer.attach(self.top)
        depth = max(EXPANSION_DEPTH, self.session.options.limits.depth)
        folders = self.session.folders(self.top.main)
        try:
            with self._restored(), limited(self.session.options.limits):
                return run_with_room(action, depth, self._cancel, folders)
        except SceneError as error:
            self.top.place_error(error)
            raise

    @contextmanager
    def _restored(self) -> Iterator[None]:
        """Fork a checkpoint of this process, which continues if this process is killed. Only the main thread can fork,
        since threads are not copied."""
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

    def subject_of(self, text: str) -> ReplSubject:
        """Return the scene of a form; without a form, that of the last input's value, else of the root. Raises
        SceneError."""
        if text.strip():
            return ReplSubject(self._scene_of_form(text), None)
        if self._recent is not None:
            form, value = self._recent
            scene = self.as_scene(value)
            if scene is not None:
                return ReplSubject(scene, f"`{form}`, the last value")
        try:
            scene = self.root()
        except SceneError as error:
            last = self.top.history.value
            older = self.as_scene(last) if last is not None else None
            if error.name != "no-root" or older is None:
                raise
            return ReplSubject(older, "`*1`, an earlier value")
        return ReplSubject(scene, f'the root "{scene.word}"')

    def _scene_of_form(self, text: str) -> Scene:
        values: list[Any] = []
        source = self.source(text)
        self.run(lambda: self.top.evaluate(source, lambda given: values.append(given.value), lambda _: None))
        value = values[-1] if values else None
        scene = self.as_scene(value)
        if scene is None:
            raise SceneError("type", "expected a scene", "a scene is an entity, a list of parts, or frames")
        return scene

    def as_scene(self, value: Any) -> Scene | None:
        """Convert a value to a scene (entity, parts or frames); returns None for other values."""
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
        """Evaluate the root word, as `run` does. Raises SceneError if there is no root."""
        session = self.session

        def work() -> Scene:
            program = self.top.program()
            word = session.options.root or find_root(program)[0]
            return self.top.run_root(program, word, self.seed)

        if session.options.z_entries:
            return self._root_with_entries()
        return self.run(work)

    def _root_with_entries(self) -> Scene:
        """Evaluate the definitions as a separate program, since embeddings of automatic handles require two runs."""

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
        """Folder of the initial file, else the working directory."""
        return Path(self.file).parent if self.file else Path.cwd()


class _OneAnswer(ReplEvaluation):
    """State of an evaluation in a process of its own, whose end costs nothing: there is no checkpoint of it."""

    @contextmanager
    def _restored(self) -> Iterator[None]:
        yield


def answer_in_program(session: Session, source: Source, text: str) -> tuple[list[str], list[str], Sequence[Diagnostic]]:
    """Evaluate an input after a program; return the texts of its values, its log, and the diagnostics.

    If the program itself has errors, these are returned.
    """
    evaluation = _OneAnswer(session, source.name)
    program = evaluation.evaluate(source, whole=True)
    if not program.ok:
        return [], [], program.diagnostics
    outcome = evaluation.evaluate(evaluation.source(text))
    return [displayed(value) for value in outcome.values], list(outcome.log), outcome.diagnostics


# Descriptions of names: definitions of the session, and names known to every program.


def description(top: TopLevel, name: str) -> list[str]:
    """Return the description of ``name`` as lines: a name or word (quoted or not) of the session, or any name known to
    ``scenelang.reference.primer``; empty if unknown."""
    return list(_own(top, name)) or primer.description(name)


def known_names(top: TopLevel) -> Iterator[str]:
    """Return all names that have a description."""
    return chain((name for name, _ in top.names()), primer.known_names())


def _own(top: TopLevel, name: str) -> Iterator[str]:
    """Yield signature and comment of a definition of the session."""
    for key in (name, f'"{name.strip(chr(34))}"'):
        form = top.definition_of(key)
        if form is None:
            continue
        function = function_of(top, key)
        yield _signature(top, key) if function is None else signature_of(function)
        for line in top.comment_of(form):
            yield f"  {line.lstrip('; ').rstrip()}"
        yield f"  defined in {form.datums[0].span.source.name}"
        return


def _signature(top: TopLevel, key: str) -> str:
    binding = dict(top.names()).get(key)
    if isinstance(binding, Macro):
        return f"macro {binding.usage or key}"
    try:
        value = top.value_of(key)
    except KeyError:
        return key
    return f"{key} = {displayed(value, 60).splitlines()[0] if value is not None else 'none'}"


# Live viewer of a REPL, updated after each input.


_NAME = "session.scene"


class _TextSession(Session):
    """Session that reads the REPL's text, and resolves imports relative to the REPL's initial file."""

    def __init__(self, options: Options, folder: Path) -> None:
        super().__init__(options)
        self._beside = folder

    def source(self, path: str) -> Source:
        return Source(str(self._beside / _NAME), super().source(path).text)


class LiveView:
    """Viewer served by a background thread. Raises SceneError if nothing is defined."""

    def __init__(self, evaluation: ReplEvaluation) -> None:
        self._evaluation = evaluation
        if not program_text(evaluation.top):
            raise SceneError("no-root", "nothing to view: no definitions")
        self._folder = Path(tempfile.mkdtemp(prefix="scenelang-"))
        self._text = ""
        self.update()
        self._worker = Worker(self._evaluate)
        ask = lambda file, values, _text: self._worker.ask(file, values, self._options())
        self._server = ViewServer(workspace.Workspace([str(self._folder / _NAME)], ask))
        threading.Thread(target=self._server.serve_forever, args=(0.2,), daemon=True).start()

    @property
    def address(self) -> str:
        return self._server.address

    def _options(self) -> Options:
        return replace(self._evaluation.session.options, seed=self._evaluation.seed)

    def _evaluate(self, file: str, values: Mapping[str, str], options: Options) -> workspace.WorkspaceEvaluation:
        """Evaluate in the worker's process, which has a copy of the session from when the viewer was opened."""

        def open_session(_: str, values: Mapping[str, str]) -> Session:
            chosen = replace(options, defines={**options.defines, **values})
            return _TextSession(chosen, self._evaluation.folder)

        return workspace.evaluator(open_session, options.limits.primitives)(file, values, None)

    def update(self) -> None:
        """Update the viewer to the current definitions."""
        text = program_text(self._evaluation.top)
        if text != self._text:
            self._text = text
            (self._folder / _NAME).write_text(text, "utf-8")

    def open_browser(self) -> None:
        """Open the page in a browser if a display is available."""
        from scenelang.backends.viewer.packet import open_in_browser

        open_in_browser(self.address)

    def again(self) -> LiveView:
        """Create a new viewer in place of one whose threads did not survive a fork."""
        self._server.socket.close()
        shutil.rmtree(self._folder, ignore_errors=True)
        return LiveView(self._evaluation)

    def close(self) -> None:
        """Stop the server and remove its files."""
        self._server.shutdown()
        self._server.server_close()
        self._worker.close()
        shutil.rmtree(self._folder, ignore_errors=True)
