"""Evaluation of a program: its top-level forms in order, then its root, which creates the scene."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from collections.abc import Set as AbstractSet
from contextlib import contextmanager
from typing import Any

from scenelang.grammar import ast
from scenelang.grammar.ast import parse_core
from scenelang.grammar.datum import Datum, Span, dataclass, replace
from scenelang.grammar.diagnostics import SceneError, suggest
from scenelang.interpreter.checker.program import Prelude, Program, prelude_of
from scenelang.interpreter.compile.analyze import pattern_variables, strings_in, walk
from scenelang.interpreter.compile.compile import compile_forms
from scenelang.interpreter.expand.expand import RunMacro
from scenelang.interpreter.expand.scope import Variable
from scenelang.interpreter.runtime.parts import call_embeddings, parts_of, with_attributes
from scenelang.interpreter.runtime.procedures import MAKE_RECORD, UNDEFINED, Cell, Closure, EscapeSignal
from scenelang.interpreter.runtime.runtime import NEVER, Runtime, root_arguments
from scenelang.interpreter.runtime.types import Builtin, Library, type_name
from scenelang.interpreter.scene.entity import Entity, Frames, Scene
from scenelang.interpreter.values.limits import Limits
from scenelang.interpreter.values.values import NIL, Embedding, Matrix, MutableList, Pair, Vector, list_items, make_list


class Globals(dict[Variable, Cell]):
    """Cells of global variables. Prelude functions are compiled when first referenced."""

    def __init__(self, rt: Runtime, prelude: Prelude) -> None:
        super().__init__()
        self._rt = rt
        self._prelude = prelude

    def get(self, variable: Variable, default: Any = None) -> Any:
        """Return the cell of a variable; a prelude function is compiled first, None for an unknown variable."""
        cell = super().get(variable)
        if cell is None and variable in self._prelude.definitions:
            cell = self[variable] = Cell(UNDEFINED, NEVER)  # the call that needs it must not count as a writer
            (run,) = compile_forms(self._rt, self, [self._prelude.definitions[variable]])
            run([])
            cell.birth = 0
        return cell


class ProgramRun:
    """Run of a program that evaluates one form at a time; the REPL continues it with further forms."""

    def __init__(self, library: Library, runtime: Runtime) -> None:
        self.rt = runtime
        self.globals = Globals(runtime, prelude_of(library))

    def run_form(self, form: Any) -> Any:
        """Run one top-level form; return the value of an expression, or None for a definition."""
        self.rt.begin_form(form)
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
        """Run all top-level forms of a program."""
        for form in program.forms:
            self.run_form(form)

    def run_root(self, program: Program, word: str, seed: int) -> Scene:
        """Seed the random streams, evaluate the root ``word`` and return its scene.

        The language defines that the streams are seeded just before the root is evaluated. Code at top level uses the
        streams as seeded at the start of the run.
        """
        rt = self.rt
        rt.streams.seed(seed)
        span = program.all_words.get(word) or (program.scene.span if program.scene else None)
        with _located(word, program.scene.span if program.scene else span):
            z, gamma = self._root_call(program, word)
        cell = rt.words.get(word)
        if cell is None or cell.function is None:
            bound = [f'"{each}"' for each in rt.words][:_MAX_LISTED]
            listed = f"the program binds {', '.join(bound)}" if bound else f'bind it: `(bind "{word}" (lambda () ...))`'
            hint = suggest(word, rt.words) or listed
            raise SceneError("root", f'the root "{word}" is not bound', hint, span)
        with _located(word, program.scene.span if program.scene else span):
            setup = rt.setup_of(program.own_forms)
            rt.form = None
            scene = self.evaluate_root(word, cell.function, z, gamma)
        return scene.with_setup(setup)

    def _root_call(self, program: Program, word: str) -> tuple[Embedding, Any]:
        """Return the root's embedding and gamma: the defaults, merged with the arguments of ``(scene ...)``."""
        z, gamma = root_arguments(self.rt)
        scene = program.scene
        if scene is None or not scene.arguments or type(scene.word) is not ast.Constant or scene.word.value != word:
            return z, gamma
        values = [self.run_form(argument) for argument in scene.arguments]
        arguments, rest, written = call_embeddings(self.rt, word, values)
        self.rt.check_written(word, written)
        merged = Embedding(arguments.handle or z.handle, arguments.text or z.text, z.attributes)
        merged = with_attributes(self.rt, merged, arguments.attributes)
        return merged, make_list(rest) if rest else gamma

    def evaluate_root(self, word: str, function: Any, z: Embedding, gamma: Any) -> Scene:
        """Call the root's function and return its scene, which is static or consists of frames.

        Parameters
        ----------
        word, function
            Root word, and the function that it is bound to.
        z
            Embedding of the root.
        gamma
            Infinite list of handles, or the positional arguments of ``(scene ...)``.
        """
        rt = self.rt
        rt.clock += 1
        serial = rt.clock
        rt.save_streams(serial)
        declarations = tuple(rt.declarations)  # those at top level
        try:
            value = rt.apply_entity_function(function, word, z, gamma)
            frames = _frames(rt, function, value, word)
        except SceneError as error:
            error.called(f'"{word}"', None)
            raise
        roots = [rt.make_entity(word, z, children) for children in frames]
        root_declarations = rt.declared_since(len(declarations))
        for root in roots:
            root.function, root.rest, root.serial, root.declarations = function, gamma, serial, root_declarations
        return Scene(word, roots, _is_animated(function, value), declarations)


def _is_animated(function: Any, value: Any) -> bool:
    """Return whether the value of the root is a 4D scene."""
    return type(value) is Frames or _is_frame_list(function, value)


def _is_frame_list(function: Any, value: Any) -> bool:
    """Return whether a value is a 4D scene in the paper's form: a root without parameters returns a list of frames."""
    if type(function) is not Closure or function.code.parameters:
        return False
    if type(value) is Entity or (type(value) is not Pair and not isinstance(value, MutableList)):
        return False
    if type(value) is Pair and not _is_frame(value.car):
        return False
    members = value.items if isinstance(value, MutableList) else list_items(value)
    return bool(members) and all(_is_frame(member) for member in members) and _is_proper(value)


def _is_proper(value: Any) -> bool:
    """Return whether a value is a list that does not end in a dotted pair."""
    if isinstance(value, MutableList):
        return True
    while type(value) is Pair:
        value = value.cdr
    return value is NIL


def _is_frame(member: Any) -> bool:
    """Return whether an item of the root's list may be a frame: an entity or a list, but not a posed entity."""
    if type(member) is Entity or member is NIL or isinstance(member, MutableList):
        return True
    return type(member) is Pair and not (type(member.car) is Entity and type(member.cdr) is Matrix)


def _frames(rt: Runtime, function: Any, value: Any, word: str) -> list[Sequence[Any]]:
    """Return the parts of each frame; a static scene has one."""
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
    """Locate errors without a place, as of limits, and of the root's call, at ``scene`` or at the root's ``bind``."""
    try:
        yield
    except SceneError as error:
        is_unplaced, error.span = error.span is None, error.span or span
        if is_unplaced and error.name in ("keyword", "embedding"):
            error.hint = f'write `(scene "{word}" :name value)`, or give the parameter a default: `(:name value)`'
        raise


# --- evaluation of a program under edit: only the forms that an edit affects are evaluated again ----------------------
#
# The runtime of one version continues with the next. A top-level form that only creates functions is skipped if neither
# it nor anything that it mentions, directly or through other forms, has changed; all other forms run again, in order.
# A memoized call stays valid while the function of its word is the same object, because everything that it may have
# read is then unchanged. This needs no record of reads at run time: recording the version of each definition that a
# call reads would be finer, but would cost time at each read, and forms are analyzed once.
#
# A version is run from scratch if this is not certain: if a word has two bindings or is bound by a function, if code at
# top level uses a later definition, or if a value differs although nothing that it was computed from has changed. The
# limits count only what is evaluated again.


@dataclass(frozen=True, slots=True, eq=False)
class FormReach:
    """Definitions of a top-level form, and the names and words that it can read.

    Attributes
    ----------
    form
        Form of the core AST.
    variables, words
        Global variables that it defines, and words that it binds.
    mentions, strings
        Global variables that it mentions, and strings, each of which may be the word of a call.
    is_open
        Whether it may look up a word that it does not mention.
    is_static
        Whether running it only creates functions.
    """

    form: Any
    variables: tuple[Variable, ...]
    words: tuple[str, ...]
    mentions: frozenset[Variable]
    strings: frozenset[str]
    is_open: bool
    is_static: bool


_MAX_LISTED = 5  # words in a hint
_LOOKUPS = frozenset(("call", "retrieve", "bound?", "apply-entity-function"))


def reach_of(form: Any, known: Mapping[int, FormReach]) -> FormReach:
    """Return what a top-level form defines and can read; results in ``known``, by the ids of forms, are reused."""
    reach = known.get(id(form))
    if reach is not None and reach.form is form and reach.is_static == _makes_functions(form, reach.variables):
        return reach
    mentions: set[Variable] = set()
    strings: set[str] = set()
    is_open = False
    for node in walk(form):
        kind = type(node)
        if kind is ast.Constant:
            strings.update(strings_in(node.value))
        elif kind is ast.Call or kind is ast.Bind:
            is_open = is_open or type(node.word) is not ast.Constant
        elif kind is ast.Reference or kind is ast.Assignment:
            target = node.target
            if isinstance(target, (Builtin, Variable)):
                is_open = is_open or target.name in _LOOKUPS  # also as a value
            if isinstance(target, Variable) and target.is_global:
                mentions.add(target)
    variables = tuple(pattern_variables(form.target)) if type(form) is ast.Define else ()
    words = (form.word.value,) if type(form) is ast.Bind and type(form.word) is ast.Constant else ()
    is_static = _makes_functions(form, variables)
    return FormReach(form, variables, words, frozenset(mentions), frozenset(strings), is_open, is_static)


def _makes_functions(form: Any, variables: tuple[Variable, ...]) -> bool:
    """Return whether running a form only creates functions; ``set!`` may replace those of an assigned variable."""
    if type(form) is ast.Bind:
        return type(form.word) is ast.Constant and type(form.function) is ast.Lambda
    if type(form) is not ast.Define or any(variable.assigned for variable in variables):
        return False
    value = form.value
    if type(value) is ast.Application and type(value.function) is ast.Reference:
        return value.function.target is MAKE_RECORD and all(
            type(argument) is ast.Constant for argument in value.arguments
        )
    return type(value) is ast.Lambda


class _Restart(Exception):
    """Raised when a version must be run from scratch."""


_MAX_KEPT = 1_000_000  # memoized calls of earlier versions; more are dropped by a run from scratch, for their memory


class IncrementalRun:
    """Run of the successive versions of one program, which share the calls that an edit does not affect.

    Parameters
    ----------
    library
        Standard library.
    new_runtime
        Function that returns a runtime for a run from scratch.
    """

    def __init__(self, library: Library, new_runtime: Callable[[], Runtime]) -> None:
        """Start without a version, so that the first one runs from scratch."""
        self._library = library
        self._new_runtime = new_runtime
        self._reaches: dict[int, FormReach] = {}
        self._run: ProgramRun | None = None  # None if the next version must be run from scratch
        self._assigned: dict[Variable, bool] = {}  # `Variable.assigned` in the last version
        self._functions: dict[str, Any] = {}  # of the words that are bound at top level
        self._bindings = 0  # epoch of words after the last version
        self._scene: Scene | None = None  # of the last version, if it depends on the functions alone
        self._root: tuple[str, Any] | None = None  # the root's word and function
        self._trace: Sequence[Any] = ()  # of the root's evaluation, which is replayed with its scene
        self.rt = new_runtime()
        self._place = self.rt.place
        self.evaluated = 0  # top-level forms that the last run evaluated
        self.reads_places = False  # whether a value of the program is a place in its text, which any edit may move
        self.most_steps: int | None = None  # of the next versions, if fewer than the runtime's limit

    def run(self, program: Program, word: str, seed: int, place: Callable[[Span], Span], spent: float = 0.0) -> Scene:
        """Run the next version of the program and return its scene.

        Parameters
        ----------
        program
            The version.
        word
            Word of the root.
        seed
            Seed of the random streams.
        place
            Converts a span of the program to the whole text.
        spent
            Seconds of the time limit that the check has used.

        Raises
        ------
        SceneError
            The same as in a run from scratch.
        """
        self._place = self.rt.place = lambda span: self._read_place(place, span)
        reaches = [reach_of(form, self._reaches) for form in program.forms]
        previous, self._reaches = self._reaches, {id(reach.form): reach for reach in reaches}
        run, self._run = self._run, None  # so that the next version starts from scratch if this one fails
        try:
            if run is None or self.rt.kept > _MAX_KEPT:
                raise _Restart
            return self._continue(run, program, reaches, previous, word, seed, spent)
        except _Restart:
            return self._from_scratch(program, reaches, word, seed, spent)

    def _read_place(self, place: Callable[[Span], Span], span: Span) -> Span:
        """Return the place of a span in the whole text, and note that the program has it as a value."""
        self.reads_places = True
        return place(span)

    def _from_scratch(
        self, program: Program, reaches: Sequence[FormReach], word: str, seed: int, spent: float
    ) -> Scene:
        """Run all forms and the root in a new runtime."""
        self.rt = self._new_runtime()
        self.rt.place = self._place
        self._restart(seed, spent)
        run = ProgramRun(self._library, self.rt)
        for form in program.forms:
            run.run_form(form)
        self.evaluated = len(reaches)
        return self._finish(run, program, reaches, word, seed, self.rt.binds)

    def _continue(
        self,
        run: ProgramRun,
        program: Program,
        reaches: Sequence[FormReach],
        previous: Mapping[int, FormReach],
        word: str,
        seed: int,
        spent: float,
    ) -> Scene:
        """Run the next version in the runtime of the last one.

        Raises ``_Restart`` if it is not certain that the result is that of a new run.
        """
        rt = self.rt
        changed = self._changed(run, reaches, previous)
        unchanged = {id(reach.form) for reach in reaches if reach.is_static} - changed
        if uses_later_definitions(reaches, unchanged):
            raise _Restart
        values = self._clean(run, reaches, unchanged, seed, spent)
        rt.keep_calls(self._functions, self._bindings)  # until the words of other forms are bound again
        before, binds = rt.clock, rt.binds
        for reach in reaches:
            if id(reach.form) not in unchanged:
                run.run_form(reach.form)
                if id(reach.form) not in changed and not all(
                    is_same(values[variable], run.globals[variable].value) for variable in reach.variables
                ):
                    raise _Restart
        self.evaluated = len(reaches) - len(unchanged)
        binds = rt.binds - binds
        if binds != sum(bool(reach.words) for reach in reaches if id(reach.form) not in unchanged):
            raise _Restart  # other code than a form at top level binds a word
        if rt.clock != before and any(reach.words and id(reach.form) in changed for reach in reaches):
            raise _Restart  # code at top level calls words between the bindings
        rt.keep_calls(_functions(rt, reaches), self._bindings)
        if self._scene is not None and self._root == (word, self._function(word)) and program.scene is None:
            self._keep(run, reaches)
            rt.replay(self._trace)
            return self._scene.with_setup(rt.setup_of(program.own_forms))
        unchanged_words = sum(bool(reach.words) for reach in reaches if id(reach.form) in unchanged)
        return self._finish(run, program, reaches, word, seed, binds + unchanged_words)

    def _changed(self, run: ProgramRun, reaches: Sequence[FormReach], previous: Mapping[int, FormReach]) -> set[int]:
        """Return the forms that are new, those whose values cannot be compared, and all that depend on these."""
        current = {id(reach.form) for reach in reaches}
        removed = [reach for key, reach in previous.items() if key not in current]
        words = {word for reach in removed for word in reach.words}
        variables = {variable for reach in removed for variable in reach.variables}
        forms: set[int] = set()
        for reach in reaches:
            is_new = id(reach.form) not in previous
            has_new_flags = any(self._assigned.get(v) != v.assigned for v in (*reach.variables, *reach.mentions))
            values = [run.globals[v].value for v in reach.variables if v in run.globals]
            is_volatile = not reach.is_static and bool(reach.words or not all(map(is_plain, values)))
            if is_new or has_new_flags or is_volatile:
                forms.add(id(reach.form))
                words.update(reach.words)
                variables.update(reach.variables)
        return with_dependents(reaches, forms, words, variables)

    def _clean(
        self, run: ProgramRun, reaches: Sequence[FormReach], unchanged: set[int], seed: int, spent: float
    ) -> dict[Variable, Any]:
        """Undo the effects of the last run except for unchanged functions; return the values of the other variables."""
        rt = self.rt
        self._restart(seed, spent)
        bound = {word for reach in reaches if id(reach.form) in unchanged for word in reach.words}
        for word in list(rt.words):
            if word not in bound:
                del rt.words[word]
        values = {}
        for reach in reaches:
            if id(reach.form) not in unchanged:
                for variable in reach.variables:
                    cell = run.globals.get(variable)
                    if cell is not None:
                        values[variable], cell.value = cell.value, UNDEFINED
        return values

    def _restart(self, seed: int, spent: float) -> None:
        """Prepare the runtime for the next version."""
        self.rt.restart(seed, spent)
        meter = self.rt.meter
        if self.most_steps is not None and self.most_steps < meter.limits.steps:
            meter.limits = replace(meter.limits, steps=self.most_steps)

    def _finish(
        self, run: ProgramRun, program: Program, reaches: Sequence[FormReach], word: str, seed: int, binds: int
    ) -> Scene:
        """Evaluate the root, and keep the state for the next version if only ``bind`` forms at top level bind words.

        ``binds`` is the number of times that the forms have bound words.
        """
        rt = self.rt
        output, bindings, before = rt.output, rt.bindings, rt.binds
        functions = _functions(rt, reaches)
        rt.drew_random, rt.oldest_read, rt.oldest_write = False, NEVER, NEVER
        scene = run.run_root(program, word, seed)
        is_pure = not rt.drew_random and rt.oldest_read == rt.oldest_write == NEVER and rt.output == output
        is_bound_once = len(functions) == sum(len(reach.words) for reach in reaches) == binds and rt.binds == before
        if is_bound_once and rt.bindings == bindings and functions == _functions(rt, reaches):
            self._scene = scene if is_pure and program.scene is None else None
            self._root, self._trace = (word, self._function(word)), rt.trace or []
            self._keep(run, reaches)
        return scene

    def _keep(self, run: ProgramRun, reaches: Sequence[FormReach]) -> None:
        """Keep the state of a run for the next version."""
        self._run = run
        self._functions, self._bindings = _functions(self.rt, reaches), self.rt.bindings
        self._assigned = {v: v.assigned for reach in reaches for v in (*reach.variables, *reach.mentions)}

    def _function(self, word: str) -> Any:
        """Return the function of a word, or None."""
        cell = self.rt.words.get(word)
        return cell.function if cell is not None else None


def _functions(rt: Runtime, reaches: Sequence[FormReach]) -> dict[str, Any]:
    """Return the functions of the words that are bound at top level."""
    words = [word for reach in reaches for word in reach.words]
    return {word: rt.words[word].function for word in words if word in rt.words}


def with_dependents(
    reaches: Sequence[FormReach], forms: set[int], words: set[str], variables: set[Variable]
) -> set[int]:
    """Return the ids ``forms``, and those of all forms that mention changed words or variables.

    A form that mentions them only through other forms is included.
    """
    readers: dict[Any, list[FormReach]] = {}
    for reach in reaches:
        for name in (*reach.mentions, *reach.strings, *reach.words):
            readers.setdefault(name, []).append(reach)
    open_forms = [reach for reach in reaches if reach.is_open]
    dependents, pending = set(forms), [*words, *variables]
    while pending:
        name = pending.pop()
        affected = [*readers.pop(name, ())]
        if type(name) is str:  # a word, which open forms may call without mentioning it
            affected += open_forms
            open_forms = []
        for reach in affected:
            if id(reach.form) not in dependents:
                dependents.add(id(reach.form))
                pending += (*reach.words, *reach.variables)
    return dependents


def uses_later_definitions(reaches: Sequence[FormReach], unchanged: set[int]) -> bool:
    """Return whether code at top level can call a function that is defined after it by an unchanged form.

    ``unchanged`` are the ids of these forms. In a run from scratch, the function would not exist yet. The search goes
    from definitions to their readers, from the last definition on, and visits each form once.
    """
    homes: dict[Any, int] = {}
    for index, reach in enumerate(reaches):
        homes.update(dict.fromkeys((*reach.variables, *reach.words), index))
    anything = len(reaches)  # index of an imaginary form that mentions every name, for open forms
    readers: list[list[int]] = [[] for _ in range(anything + 1)]
    for home in set(homes.values()):
        readers[home].append(anything)
    for index, reach in enumerate(reaches):
        names = (name for name in (*reach.mentions, *reach.strings) if name in homes)
        for home in [anything] if reach.is_open else {homes[name] for name in names}:
            readers[home].append(index)
    visited = [False] * (anything + 1)
    for last in range(anything - 1, -1, -1):
        if id(reaches[last].form) not in unchanged:
            continue
        stack = readers[last]
        while stack:
            index = stack.pop()
            if not visited[index]:
                visited[index] = True
                stack += readers[index]
                if index < last and not reaches[index].is_static:
                    return True
    return False


_MAX_COMPARED = 1_000  # items of a list that is compared with its value in the next version


def is_plain(value: Any) -> bool:
    """Return whether a value is immutable data that can be compared, and not a long list."""
    count = 0
    while type(value) is Pair:
        count += 1
        if count > _MAX_COMPARED or not is_plain(value.car):
            return False
        value = value.cdr
    return value is None or value is NIL or type(value) in (int, float, bool, str, Vector, Matrix)


def is_same(old: Any, new: Any) -> bool:
    """Return whether two plain values are indistinguishable to a program; 0.0 and -0.0 are not."""
    while type(old) is type(new) is Pair:
        if not is_same(old.car, new.car):
            return False
        old, new = old.cdr, new.cdr
    if type(old) is not type(new):
        return False
    return repr(old) == repr(new) if type(old) in (float, Vector, Matrix) else bool(old == new)


# --- calls of a REPL session: those that a definition does not affect are used again ---------------------------------


@dataclass(frozen=True, slots=True, eq=False)
class SessionForm:
    """Form of a session in effect.

    Attributes
    ----------
    trees
        Its core forms.
    is_static
        Whether running it again only creates its functions again.
    is_replaced
        Whether another form has replaced it or is about to; running it again would undo that.
    """

    trees: tuple[Any, ...]
    is_static: bool
    is_replaced: bool = False


class SessionCalls:
    """Memoized calls of a REPL session, whose functions are defined one after another.

    After a definition, the functions that mention its names, directly or through other forms, are created again, so
    that their calls are new ones; all other calls stay valid. All calls are invalidated if that is not certain: if a
    form has changed anything but its own definitions, or if a value may contain a function that should be created
    again.

    Parameters
    ----------
    run
        Run of the forms.
    volatile
        Variables that change without a definition.
    """

    def __init__(self, run: ProgramRun, volatile: AbstractSet[Variable]) -> None:
        self._run = run
        self._volatile = volatile
        self._reaches: dict[int, FormReach] = {}
        self._changed: list[Any] = []  # core forms that ran since the calls were settled
        self._before: tuple[int, int] | None = None  # the epochs before the first of them; None if settled
        self.is_tracked = True  # False after a form has changed anything but its own definitions

    @property
    def is_settled(self) -> bool:
        """Whether all calls are valid."""
        return self._before is None

    @property
    def epochs(self) -> tuple[int, int]:
        """The current epochs of words and of values."""
        return self._run.rt.bindings, self._run.rt.epoch

    def reach(self, tree: Any) -> FormReach:
        """Return the definitions of a core form, and the names and words that it can read."""
        return reach_of(tree, self._reaches)

    def note(self, trees: Sequence[Any], epochs: tuple[int, int]) -> None:
        """Record that the core forms of a definition ran, which began in these epochs."""
        self._changed += trees
        self._before = self._before or epochs

    def restore(self, variables: Iterable[Variable], epochs: tuple[int, int]) -> None:
        """Keep all calls after a definition that did not change the values of its variables."""
        self._run.rt.epoch = epochs[1]
        self._observe(variables)

    def settle(self, forms: Sequence[SessionForm]) -> None:
        """Keep the calls that the definitions since the last settlement do not affect.

        ``forms`` are all forms of the session.
        """
        rt, changed, before = self._run.rt, self._changed, self._before
        self._changed, self._before = [], None
        try:
            affected = self._affected(forms, changed) if self.is_tracked else None
            if affected is None or before is None:
                rt.invalidate_calls()
                return
            for tree in affected:
                self._run.run_form(tree)
        except BaseException:  # such as an interruption
            rt.invalidate_calls()
            raise
        rt.keep_calls(_functions(rt, list(self._reaches.values())), *before)
        for tree in (*changed, *affected):
            reach = self.reach(tree)
            self._observe(reach.variables)
            for word in reach.words:
                rt.word_cell(word)

    def _observe(self, variables: Iterable[Variable]) -> None:
        """Mark variables as read, because a call that is kept may have read them."""
        for cell in map(self._run.globals.get, variables):
            if cell is not None:
                cell.observed = True

    def _affected(self, forms: Sequence[SessionForm], changed: Sequence[Any]) -> list[Any] | None:
        """Return the core forms whose functions must be created again, or None if this is not certain."""
        self._reaches = {id(tree): reach_of(tree, self._reaches) for form in forms for tree in form.trees}
        new = list(map(self.reach, changed))
        ids = {id(tree) for tree in changed}
        words = {word for reach in new for word in reach.words}
        variables = {variable for reach in new for variable in reach.variables} | self._volatile
        dependents = with_dependents(list(self._reaches.values()), ids, words, variables)
        affected: list[Any] = []
        for form in forms:
            trees = [tree for tree in form.trees if id(tree) in dependents and id(tree) not in ids]
            if trees and not (form.is_static or form.is_replaced):
                return None
            affected += filter(self._is_defined, trees) if form.is_static else ()
        return affected

    def _is_defined(self, tree: Any) -> bool:
        """Return whether all definitions of a core form have values at present."""
        reach = self.reach(tree)
        cells = [self._run.globals.get(variable) for variable in reach.variables]
        words = [self._run.rt.words.get(word) for word in reach.words]
        is_bound = all(word is not None and word.function is not None for word in words)
        return is_bound and all(cell is not None and cell.value is not UNDEFINED for cell in cells)
