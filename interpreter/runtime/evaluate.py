"""Evaluation of a program: its top-level forms in order, then its root, which creates the scene."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from scenelang.grammar import ast
from scenelang.grammar.ast import parse_core
from scenelang.grammar.datum import Datum, Span
from scenelang.grammar.diagnostics import SceneError, suggest
from scenelang.interpreter.compile.compile import compile_forms
from scenelang.interpreter.expand.expand import RunMacro
from scenelang.interpreter.expand.scope import Variable
from scenelang.interpreter.program.program import Prelude, Program, prelude_of
from scenelang.interpreter.runtime.limits import Limits
from scenelang.interpreter.runtime.procedures import UNDEFINED, Cell, Closure, EscapeSignal
from scenelang.interpreter.runtime.runtime import Runtime, root_arguments
from scenelang.interpreter.runtime.types import Library, type_name
from scenelang.interpreter.runtime.values import NIL, Embedding, Matrix, MutableList, Pair, list_items, make_list
from scenelang.interpreter.scene.entity import Entity, Frames, Scene
from scenelang.interpreter.scene.parts import call_embeddings, parts_of, with_attributes


class Globals(dict[Variable, Cell]):
    """Cells of global variables. Prelude functions are compiled when first referenced."""

    def __init__(self, rt: Runtime, prelude: Prelude) -> None:
        super().__init__()
        self._rt = rt
        self._prelude = prelude

    def get(self, variable: Variable, default: Any = None) -> Any:
        cell = super().get(variable)
        if cell is None and variable in self._prelude.definitions:
            cell = self[variable] = Cell(UNDEFINED, 0)
            (run,) = compile_forms(self._rt, self, [self._prelude.definitions[variable]])
            run([])
        return cell


class ProgramRun:
    """Run of a program that evaluates one form at a time; the REPL continues it with further forms."""

    def __init__(self, library: Library, runtime: Runtime) -> None:
        self.rt = runtime
        self.globals = Globals(runtime, prelude_of(library))

    def run_form(self, form: Any) -> Any:
        """Run one top-level form; return the value of an expression, or None for a definition."""
        (node,) = compile_forms(self.rt, self.globals, [form])
        try:
            return node([])
        except SceneError as error:
            error.span = error.span or form.span
            raise
        except EscapeSignal as signal:
            name = signal.escape.name
            raise SceneError("escape", f"`{name}` was called outside its `let/ec`", None, form.span) from None

    def run_forms(self, program: Program) -> None:
        for form in program.forms:
            self.run_form(form)

    def run_root(self, program: Program, word: str, seed: int) -> Scene:
        """Seed the random streams, evaluate the root ``word`` and return its scene."""
        rt = self.rt
        rt.streams.seed(seed)
        span = program.all_words.get(word) or (program.scene.span if program.scene else None)
        with _located(word, program.scene.span if program.scene else span):
            z, gamma = self._root_call(program, word)
        cell = rt.words.get(word)
        if cell is None or cell.function is None:
            hint = suggest(word, rt.words) or 'bind it with `(bind "word" (lambda () ...))`'
            raise SceneError("root", f'the root "{word}" is not bound', hint, span)
        with _located(word, program.scene.span if program.scene else span):
            return self.evaluate_root(word, cell.function, z, gamma)

    def _root_call(self, program: Program, word: str) -> tuple[Embedding, Any]:
        """Return the root's embedding and gamma: the defaults, merged with the arguments of ``(scene ...)``."""
        z, gamma = root_arguments(self.rt)
        scene = program.scene
        if scene is None or not scene.arguments or type(scene.word) is not ast.Constant or scene.word.value != word:
            return z, gamma
        values = [self.run_form(argument) for argument in scene.arguments]
        given, rest, _ = call_embeddings(self.rt, word, values)
        joined = Embedding(given.handle or z.handle, given.text or z.text, z.attributes)
        joined = with_attributes(self.rt, joined, given.attributes)
        return joined, make_list(rest) if rest else gamma

    def evaluate_root(self, word: str, function: Any, z: Embedding, gamma: Any) -> Scene:
        """Call the root's function and return its scene, which is static or consists of frames."""
        rt = self.rt
        rt.clock += 1
        serial = rt.clock
        rt.save_streams(serial)
        try:
            value = rt.apply_entity_function(function, word, z, gamma)
            frames = _frames(rt, function, value, word)
        except SceneError as error:
            error.called(f'"{word}"', None)
            raise
        roots = [rt.make_entity(word, z, children) for children in frames]
        for root in roots:
            root.function, root.rest, root.serial = function, gamma, serial
        return Scene(word, roots, animated=_is_animated(function, value))


def _is_animated(function: Any, value: Any) -> bool:
    return type(value) is Frames or _is_frame_list(function, value)


def _is_frame_list(function: Any, value: Any) -> bool:
    """Return whether a value is a 4D scene in the paper's form: a root without parameters returns a list of frames."""
    if type(function) is not Closure or function.code.parameters:
        return False
    if type(value) is Entity or (type(value) is not Pair and not isinstance(value, MutableList)):
        return False
    members = value.items if isinstance(value, MutableList) else list_items(value)
    return bool(members) and all(_is_frame(member) for member in members) and _is_proper(value)


def _is_proper(value: Any) -> bool:
    if isinstance(value, MutableList):
        return True
    while type(value) is Pair:
        value = value.cdr
    return value is NIL


def _is_frame(member: Any) -> bool:
    if type(member) is Entity or member is NIL or isinstance(member, MutableList):
        return True
    return type(member) is Pair and not (type(member.car) is Entity and type(member.cdr) is Matrix)


def _frames(rt: Runtime, function: Any, value: Any, word: str) -> list[tuple[Any, ...]]:
    if type(value) is Frames:
        return list(value.frames)
    if _is_frame_list(function, value):
        members = value.items if isinstance(value, MutableList) else list_items(value)
        return [parts_of(rt, member, word) for member in members]
    try:
        return [parts_of(rt, value, word)]
    except SceneError as error:
        if error.name == "parts" and error.span is None:
            error.message = f'expected a scene as the value of the root "{word}", got {type_name(value)}'
            error.hint = "return an entity, parts such as those of `union`, or `(frames ...)`"
        raise


def macro_runner(library: Library, limits: Limits, started: Callable[[Runtime], None] | None = None) -> RunMacro:
    """Return a function that runs the bodies of ``define-macro`` at expansion time.

    Macros are compiled at their first use and share one meter. ``started`` is called with their runtime, so that it can
    be cancelled.
    """
    runs: list[ProgramRun] = []
    compiled: dict[int, tuple[Datum, Any]] = {}

    def run_macro(function: Datum, arguments: list[Any]) -> tuple[Any, bool]:
        if not runs:
            runs.append(ProgramRun(library, Runtime(library, limits)))
            if started is not None:
                started(runs[0].rt)
        run = runs[0]
        if id(function) not in compiled:
            (form,) = parse_core([function])
            compiled[id(function)] = function, run.run_form(form)
        run.rt.drew_random = False
        value = run.rt.apply(compiled[id(function)][1], arguments)
        return value, not run.rt.drew_random

    return run_macro


@contextmanager
def _located(word: str, span: Span | None) -> Iterator[None]:
    """Give errors about the call of the root, which no code makes, the place of ``scene`` or of the root's ``bind``."""
    try:
        yield
    except SceneError as error:
        if error.span is None and error.name in ("keyword", "embedding"):
            error.span = span
            error.hint = f'write `(scene "{word}" :name value)`, or give the parameter a default: `(:name value)`'
        raise
