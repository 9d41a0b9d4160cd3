"""Programs: the files of a program and their core AST in execution order."""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import cached_property, lru_cache
from itertools import accumulate
from typing import Any

from scenelang.grammar import ast
from scenelang.grammar.ast import FormError, parse_core
from scenelang.grammar.datum import Atom, Datum, Keyword, ListDatum, Source, Span, Symbol, dataclass, field, replace
from scenelang.grammar.diagnostics import Diagnostic, Note, SceneError, suggest
from scenelang.grammar.reader import read_part, read_pieces
from scenelang.interpreter.checker.book import KindBook
from scenelang.interpreter.checker.rules import FactCache, FormFacts
from scenelang.interpreter.expand.expand import (
    MAX_EXPANDED,
    MAX_EXPANSIONS,
    UNKNOWN,
    Expander,
    Pending,
    RunMacro,
    Use,
    core,
    is_identifier,
    syntax_error,
)
from scenelang.interpreter.expand.forms import FORMS, PAPER_FORMS
from scenelang.interpreter.expand.scope import ConstantBinding, Macro, PaperForm, Scope, Special, Variable, base_name
from scenelang.interpreter.runtime.types import STD, Builtin, Library

# --- expander of a file, with access to the program ------------------------------------------------------------------


_PLAIN_TYPES = frozenset(("Embedding", "List[Embedding]", "Integer", "Float", "Number", "Vector", "Matrix", "Entity"))


class FileExpander(Expander):
    """Expander of one file that suggests names of the whole program for misspelled ones."""

    def __init__(self, file: SourceFile, run_macro: RunMacro) -> None:
        super().__init__(run_macro)
        self._file = file
        self._globals: dict[str, Variable] = {}
        self.declared: set[str] = set()  # names declared in this version of the file

    def begin(self) -> None:
        """Reset the state for a new version of the file."""
        self.record_names.clear()
        self.expansions = self.expanded = 0
        self.declared.clear()

    def known_names(self) -> Iterable[str]:
        """Return the names of builtins, constants and the prelude, which a misspelled name is compared with."""
        state = self._file.state
        return state.prelude.names() if state is not None else ()

    def importable_from(self, name: str) -> str | None:
        """Return the library module that a name can be imported from, or None."""
        state = self._file.state
        module = state.prelude.library.module_of(name.removeprefix(STD)) if state is not None else None
        return f"{STD}{module}" if module is not None else None

    def bound_words(self) -> Iterable[str]:
        """Return the words that the files read so far bind."""
        state = self._file.state
        return [word for file in (self._file, *(state.files.values() if state else ())) for word in file.words]

    def unbound(self, atom: Atom, scope: Scope) -> SceneError:
        """Return the error for an undefined name; its form is analyzed again in the next version."""
        self._file.names.record.open_ended = True  # the suggestion depends on all names
        return super().unbound(atom, scope)

    def mark_random(self) -> None:
        """Record that a macro drew random numbers, so that its form is analyzed again in the next version."""
        self._file.names.record.open_ended = True

    def annotated_type(self, text: str, span: Span) -> Any:
        """Return the type of an annotation ``name::Type``."""
        if text not in _PLAIN_TYPES:
            self._file.names.record.open_ended = True  # the result depends on the program's records
        return super().annotated_type(text, span)

    def keep_global(self, variable: Variable) -> None:
        """Let the next definition of the variable's name define this variable."""
        self._globals[variable.name] = variable

    def global_variable(self, name: str, span: Span) -> Variable:
        """Return the variable of a global name, the same one as in the previous version of the file.

        A second definition of a name in the same file gets a separate variable.
        """
        known = None if name in self.declared else self._globals.get(name)
        variable = known or super().global_variable(name, span)
        if name not in self.declared:
            self._globals[name] = variable
        self.declared.add(name)
        variable.span = span
        return variable


# --- dependency tracking: top-level names with a record of lookups, on which the analysis of a form depends ----------


@dataclass(slots=True)
class LookupRecord:
    """Dependencies and results of the analysis of a form.

    Attributes
    ----------
    lookups
        Symbols looked up, with their bindings (None if unbound).
    bound
        Symbols bound, with their bindings.
    macros
        All macros in scope, if the analysis enumerated them.
    open_ended
        Whether the analysis depends on more than can be recorded, such as all names when searching for a suggestion.
    """

    lookups: dict[Symbol, Any] = field(default_factory=dict)
    bound: dict[Symbol, Any] = field(default_factory=dict)
    macros: tuple[Any, ...] | None = None
    open_ended: bool = False


class TrackedNames(dict[Symbol, Any]):
    """Bindings by symbol. ``record`` tracks the lookups and bindings of the current analysis."""

    def __init__(self) -> None:
        super().__init__()
        self.record = LookupRecord()

    def begin(self) -> LookupRecord:
        """Start a new record and return it."""
        self.record = LookupRecord()
        return self.record

    def get(self, key: Symbol, default: Any = None) -> Any:
        """Return a binding, and record the lookup."""
        binding = super().get(key, default)
        record = self.record
        if key not in record.lookups and key not in record.bound:
            record.lookups[key] = binding
        return binding

    def __setitem__(self, key: Symbol, value: Any) -> None:
        self.record.bound[key] = value
        super().__setitem__(key, value)

    def items(self) -> Any:
        """Return all bindings; the current analysis then depends on all macros among them."""
        self.record.macros = self._macros()
        return super().items()

    def _macros(self) -> tuple[Any, ...]:
        """Return all bindings of macros, without recording the lookup."""
        return tuple((symbol, binding) for symbol, binding in super().items() if isinstance(binding, Macro))

    def agrees(self, record: LookupRecord) -> bool:
        """Return whether all lookups of a record would still have the same results."""
        if record.open_ended or (record.macros is not None and record.macros != self._macros()):
            return False
        find = super().get
        return all(find(symbol) is binding for symbol, binding in record.lookups.items())

    def replay(self, bound: Mapping[Symbol, Any]) -> None:
        """Repeat the bindings of a completed analysis."""
        self.update(bound)


# --- params: constants of a program that the command line can override -----------------------------------------------


@dataclass(frozen=True, slots=True, eq=False)
class Param:
    """Declaration ``(param name default "doc" :min a :max b)``.

    Attributes
    ----------
    name, doc
        Name and description.
    default
        Source text of the default.
    minimum, maximum
        Range of a number, None where it is not limited.
    span
        Location of the declaration.
    """

    name: str
    default: str
    doc: str
    minimum: float | None
    maximum: float | None
    span: Span


def read_param(datum: ListDatum, name: str) -> Param:
    """Parse ``(param name value "doc" :min a :max b)``; raise ``SceneError`` if it is malformed."""
    rest = list(datum.items[3:])
    doc = ""
    if rest and isinstance(rest[0], Atom) and type(rest[0].value) is str:
        doc = rest.pop(0).value
    bounds: dict[str, float] = {}
    while rest:
        key = rest.pop(0)
        is_bound = isinstance(key, Atom) and isinstance(key.value, Keyword) and str(key.value) in ("min", "max")
        if not is_bound or not rest or not isinstance(rest[0], Atom) or type(rest[0].value) not in (int, float):
            raise syntax_error("param", "unexpected operand of `param`", key.span)
        bounds[str(key.value)] = rest.pop(0).value
    value = datum.items[2]
    default = " ".join(value.span.text.split())
    if bounds and isinstance(value, Atom) and type(value.value) is str:
        low = next(iter(bounds.values()))
        hint = f"the value comes before its description: `(param {name} {low:g} {default} ...)`"
        raise SceneError("param", f"the value of the param `{name}` is missing", hint, value.span)
    return Param(name, default, doc, bounds.get("min"), bounds.get("max"), datum.span)


def checked_value(param: Param, value: Any, span: Span) -> Datum:
    """Return ``value``, the datum of a param's default or of the option that overrides it, within its bounds."""
    datum: Datum = value
    number = datum.value if isinstance(datum, Atom) and type(datum.value) in (int, float) else None
    is_option = not _encloses(param.span, datum.span)
    needs_number = param.minimum is not None or param.maximum is not None
    low = -math.inf if param.minimum is None else param.minimum
    high = math.inf if param.maximum is None else param.maximum
    if (number is None and needs_number) or (number is not None and not low <= number <= high):
        message = f"`{param.name}` must be a number{_limits_of(param)}, got {datum.span.text}"
        if not is_option:
            bound = "min" if number is not None and number < low else "max"
            hint = None if number is None else f"the default is beyond `:{bound}`: change one of them"
            raise SceneError("param", message, hint, datum.span)
        hint = f"for example `--define {param.name}={param.default}`"
        note = Note("it is declared here", param.span)
        raise SceneError("param", f"--define {param.name}={datum.span.text}: {message}", hint, None, (note,))
    return datum


def _encloses(outer: Span, inner: Span) -> bool:
    """Return whether a span is inside another one."""
    return inner.source is outer.source and outer.start <= inner.start and inner.end <= outer.end


def _limits_of(param: Param) -> str:
    """Return the numbers that a param may be."""
    if param.minimum is not None and param.maximum is not None:
        return f" from {param.minimum} to {param.maximum}"
    return f" of at least {param.minimum}" if param.minimum is not None else f" of at most {param.maximum}"


# --- top-level forms with the results of their analysis --------------------------------------------------------------


@dataclass(frozen=True, slots=True, eq=False)
class Import:
    """Top-level ``import`` of a file, in its place among the forms."""

    file: SourceFile


@dataclass(slots=True)
class Step:
    """Result of one analysis step of a form, scanning or expansion.

    Attributes
    ----------
    record
        Names looked up and bound.
    problems
        Errors and warnings.
    expansions, expanded
        Number of macro expansions and of forms produced by macros.
    uses
        Meaning of each identifier, for editors.
    """

    record: LookupRecord
    problems: list[Diagnostic]
    expansions: int
    expanded: int
    uses: list[Use]


class TopForm:
    """Top-level form, or several adjacent ones, with the results of its analysis."""

    __slots__ = ("asts", "datums", "expansion", "imports", "params", "pending", "read", "records", "scan", "scene",
                 "words")  # fmt: skip

    def __init__(self, datums: Sequence[Datum], read: Sequence[Diagnostic] = ()) -> None:
        self.datums = tuple(datums)
        self.read = tuple(read)  # syntax errors found by the reader
        self.scan: Step | None = None
        self.expansion: Step | None = None
        self.forget()

    def forget(self) -> None:
        """Discard the results of the analysis."""
        self.scan = self.expansion = None
        self.pending: list[Pending | Import] = []
        self.words: list[tuple[str, Span]] = []
        self.records: set[str] = set()
        self.params: list[Param] = []
        self.imports: list[SourceFile] = []
        self.scene: ListDatum | None = None
        self.asts: list[Any] = []  # core AST nodes and Imports


def top_forms(source: Source) -> list[TopForm]:
    """Read a text into top-level forms; the first one carries the syntax errors."""
    result = read_pieces(source)
    return [TopForm((), result.diagnostics), *(TopForm((datum,)) for datum in result.forms)]


# --- files -----------------------------------------------------------------------------------------------------------
#
# A file of a program is first scanned for definitions, then expanded form by form into core AST.
#
# Each top-level form stores its results and the names it looked up (``TrackedNames``), so that a later version of the
# file can reuse them (``interactive``).


@dataclass(slots=True, eq=False)
class ProgramState:
    """State shared by the files of a program while they are loaded.

    Attributes
    ----------
    prelude
        Predefined names.
    load, overrides, run_macro
        As for ``load_program``.
    files
        Files read so far, by name.
    loading
        Names of the files whose imports are being read, outermost first: an import of one of them is a cycle.
    params
        Declarations read so far.
    previous_files
        Files of an earlier version that may be reused.
    fact_cache, kinds
        Results for the forms of an earlier version.
    records_uses
        Whether to record the meaning of every identifier, for editors.
    """

    prelude: Prelude
    load: Callable[[str, Source, Span], Source]
    overrides: Mapping[str, Any]
    run_macro: RunMacro
    files: dict[str, SourceFile] = field(default_factory=dict)
    loading: list[str] = field(default_factory=list)
    params: list[Param] = field(default_factory=list)
    previous_files: Mapping[str, SourceFile] = field(default_factory=dict)
    fact_cache: FactCache = field(default_factory=FactCache)
    kinds: KindBook | None = None
    records_uses: bool = False


_MAX_MALFORMED = 20  # malformed forms inside one top-level form that are reported; each is parsed again without them
_MISSING = ("file", "import-cycle", "import-outside")
_OF_FILES = (*_MISSING, "encoding")  # errors that a change of another file can remove
_UNREADABLE = ("unclosed", "extra-close", "nesting", "bad-dot", "syntax")


class _SpanSet:
    """Spans of one source, with a fast test whether one of them overlaps another span.

    The spans are sorted by their starts, with the largest end of all up to each, so that a test is a binary search.
    """

    def __init__(self) -> None:
        self._spans: list[tuple[int, int]] = []
        self._reach: list[int] = []  # the largest end of the spans up to each

    def add(self, span: Span) -> None:
        """Add a span."""
        self._spans.append((span.start, span.end))
        self._reach = []

    def overlaps(self, span: Span) -> bool:
        """Return whether a span of the set overlaps ``span``."""
        if not self._reach:
            self._spans.sort()
            self._reach = list(accumulate((end for _, end in self._spans), max))
        before = bisect_left(self._spans, (span.end, 0))
        return before > 0 and self._reach[before - 1] > span.start


class SourceFile:
    """Source file of a program.

    ``scan`` and ``finish`` may be repeated with other ``forms`` for a new version of the text. A file without a
    ``state`` belongs to the standard library.
    """

    def __init__(self, source: Source, parent: Scope, state: ProgramState | None = None, is_main: bool = False) -> None:
        self.source = source
        self.names = TrackedNames()
        self.scope = Scope(parent)
        self.scope.bindings = self.names
        self.state = state
        self.is_main = is_main
        self.expander = FileExpander(self, state.run_macro if state is not None else _no_macros)
        self.forms: list[TopForm] = []
        self.begin()

    def begin(self) -> None:
        """Discard all results except the forms themselves and the identity of variables."""
        self.names.clear()
        self.expander.begin()
        self.problems: list[Diagnostic] = []  # problems of the file as a whole
        self.words: dict[str, Span] = {}
        self.imports: list[SourceFile] = []
        self.imported_names: dict[Symbol, tuple[str, Any]] = {}  # imported names: the name of the file and the binding
        self.scene: ListDatum | None = None
        self.is_incomplete = False  # whether a syntax or import error may have hidden definitions
        if self.state is not None and self.source.name.startswith(STD):
            self._import_builtins(self.state.prelude.library.imported.get(self.source.name[len(STD) :], {}))

    def _import_builtins(self, builtins: Mapping[str, Builtin]) -> None:
        """Bind builtins that programs can use only by importing this file."""
        for name, builtin in builtins.items():
            self.names[Symbol(name)] = self.names[Symbol(STD + name)] = builtin

    # --- scanning ----------------------------------------------------------------------------------------------

    def scan(self) -> None:
        """Find definitions, macros and imports; reuse the previous scan of a form if it is still valid."""
        self.begin()
        for form in self.forms:
            self._scan_top(form)

    def add_forms(self, forms: Sequence[TopForm]) -> None:
        """Scan and expand additional forms, which may redefine names; ``forms`` is not changed."""
        records = set(self.expander.record_names)
        self.expander.begin()
        self.expander.record_names |= records
        self.problems = []
        for form in forms:
            self._scan_top(form)
        for form in forms:
            form.expansion = self._step(lambda form=form: self._finish_form(form))  # type: ignore[misc]

    def _scan_top(self, form: TopForm) -> None:
        """Scan a form, or repeat its previous scan if that is still valid and imports nothing."""
        if self._is_valid(form.scan) and not form.imports:
            assert form.scan is not None
            self._apply_step(form.scan)
        else:
            form.forget()
            form.scan = self._step(lambda: self._scan_all(form))
        self._add_results(form)

    def _apply_step(self, step: Step) -> None:
        """Repeat the effects of a completed step on the file's names and macro counters."""
        self.names.replay(step.record.bound)
        self.expander.declared |= {b.name for b in step.record.bound.values() if isinstance(b, Variable)}
        self.expander.expansions += step.expansions
        self.expander.expanded += step.expanded

    def _scan_all(self, form: TopForm) -> None:
        """Scan the datums of a form."""
        self.expander.found_records = form.records
        for datum in form.datums:
            self._try(lambda datum=datum: self._scan_form(datum, form))  # type: ignore[misc]

    def _is_valid(self, step: Step | None) -> bool:
        """Return whether the result of a step can be reused."""
        if step is None or not self.names.agrees(step.record) or any(d.name in _OF_FILES for d in step.problems):
            return False
        expander = self.expander
        return (
            expander.expansions + step.expansions <= MAX_EXPANSIONS
            and expander.expanded + step.expanded <= MAX_EXPANDED
        )

    def _step(self, action: Callable[[], Any]) -> Step:
        """Run one analysis step of a form and record its effects."""
        expander = self.expander
        expansions, expanded = expander.expansions, expander.expanded
        record = self.names.begin()
        problems: list[Diagnostic] = []
        expander.diagnostics = problems
        uses: list[Use] = []
        expander.uses = uses if self.state is not None and self.state.records_uses else None
        action()
        return Step(record, problems, expander.expansions - expansions, expander.expanded - expanded, uses)

    def _add_results(self, form: TopForm) -> None:
        """Add the results of a scanned form to the file."""
        for word, span in form.words:
            if word in self.words:
                message = f'"{word}" is bound twice in this file; the last binding is used'
                self.problems.append(Diagnostic("bound-twice", message, span))
            self.words[word] = span
        self.expander.record_names |= form.records
        self.imports += form.imports
        assert form.scan is not None
        if any(d.name in _MISSING for d in form.scan.problems) or any(d.name in _UNREADABLE for d in form.read):
            self.is_incomplete = True
        if self.state is not None:
            self.state.params += form.params
        if form.scene is not None and self.scene is not None:
            self.problems.append(Diagnostic("duplicate", "duplicate `(scene ...)` form", form.scene.span))
        elif form.scene is not None:
            self.scene = form.scene

    def _try(self, action: Callable[[], Any]) -> Any:
        """Run ``action``; record an error rather than raise it, so that the other forms are still analyzed."""
        try:
            return action()
        except SceneError as error:
            self._record(error)
            return None

    def _record(self, error: SceneError) -> None:
        """Record an error; one of the syntax of a form gets the form's usage as its hint."""
        if error.name == "syntax" and isinstance(error.value, str):
            is_second_pose = error.message == "unexpected operand of `transform`"
            error.hint = error.hint or (_ONE_POSE if is_second_pose else _usage_hint(error.value))
        self.expander.diagnostics.append(error.diagnostic)

    def _scan_form(self, datum: Datum, form: TopForm) -> None:
        """Scan a datum for definitions, imports, params and words; macros are expanded, and ``begin`` is spliced."""
        while isinstance(datum, ListDatum) and datum.items and datum.tail is None:
            binding = self.expander.binding_of(datum.items[0], self.scope)
            if isinstance(binding, Macro):
                datum = self.expander.expand_macro(binding, datum, self.scope)
                continue
            name = binding.name if isinstance(binding, Special) else None
            if name == "begin":
                for item in datum.items[1:]:
                    self._scan_form(item, form)
                return
            handler = {"import": self._scan_import, "scene": self._scan_scene, "param": self._scan_param}.get(
                name or ""
            )
            if handler is not None and self.state is not None:
                handler(datum, form)
                return
            if name == "bind":
                word = datum.items[1] if len(datum.items) > 1 else None
                if isinstance(word, Atom) and type(word.value) is str:
                    form.words.append((word.value, word.span))
            break
        pending: list[Pending] = []
        self.expander.scan(datum, self.scope, pending)
        form.pending.extend(pending)

    def _scan_import(self, datum: ListDatum, form: TopForm) -> None:
        """Scan an ``import``, which binds the names of the imported file unless they are bound already."""
        path = datum.items[1] if len(datum.items) > 1 else None
        if not isinstance(path, Atom) or type(path.value) is not str:
            name = path.span.text if isinstance(path, Atom) else "file.scene"
            hint = f'write `(import "{name}")`'
            raise syntax_error("import", "`import` expects a file name as a string", datum.span, hint)
        prefix = _import_prefix(datum)
        file = self._load(path.value, path.span)
        form.pending.append(Import(file))
        form.imports.append(file)
        for symbol, binding in file.scope.bindings.items():
            name = Symbol(prefix + base_name(symbol))
            if isinstance(binding, Builtin) and symbol.startswith(STD):
                name = symbol  # a builtin's qualified name `std/name` is never prefixed
            if isinstance(binding, (Variable, Macro, Builtin)) and self._may_import(name, file):
                self.scope.bindings[name] = binding
                self.imported_names[name] = (file.source.name, binding)
        form.records |= file.expander.record_names

    def _may_import(self, name: Symbol, file: SourceFile) -> bool:
        """Return whether an import may bind a name: it is unbound, or bound by an earlier version of the same file."""
        if name not in self.scope.bindings:
            return True
        origin, binding = self.imported_names.get(name, ("", None))
        return origin == file.source.name and dict.get(self.names, name) is binding

    def _load(self, path: str, span: Span) -> SourceFile:
        """Return an imported file after scanning it.

        A file of the previous version is reused if its text is the same.
        """
        state = self.state
        assert state is not None
        if path.startswith(STD):
            text = state.prelude.library.modules.get(path[len(STD) :])
            if text is None:
                modules = state.prelude.library.modules
                stem = path.rpartition("/")[2].removesuffix(".scene")
                homes = (name for name, text in modules.items() if f'(bind "{stem}"' in text)
                hint = next((f'"{stem}" is in `{STD}{name}`' for name in homes), None)
                hint = hint or suggest(path, (STD + name for name in modules))
                raise SceneError("file", f"no module `{path}` in the standard library", hint, span)
            source = Source(path, text)
        else:
            source = state.load(path, self.source, span)
        if source.name in state.loading:
            cycle = " -> ".join([*state.loading[state.loading.index(source.name) :], source.name])
            raise SceneError("import-cycle", f"import cycle: {cycle}", None, span)
        if source.name not in state.files:
            file = state.previous_files.get(source.name)
            if file is None or file.source.text != source.text:
                file = SourceFile(source, state.prelude.scope, state)
                file.forms = top_forms(source)
            file.state = state
            state.files[source.name] = file
            state.loading.append(source.name)
            file.scan()
            state.loading.pop()
        return state.files[source.name]

    def _scan_scene(self, datum: ListDatum, form: TopForm) -> None:
        """Scan ``(scene word argument ...)``, which counts in the main file only."""
        if not self.is_main:
            return
        if len(datum.items) < 2:
            raise syntax_error("scene", "`scene` expects a word", datum.span)
        if form.scene is not None:
            raise SceneError("duplicate", "duplicate `(scene ...)` form", None, datum.span)
        form.scene = datum

    def _scan_param(self, datum: ListDatum, form: TopForm) -> None:
        """Scan a ``param``, whose default may be overridden."""
        state = self.state
        assert state is not None
        if len(datum.items) < 3 or not is_identifier(datum.items[1]):
            raise syntax_error("param", "`param` expects a name and a value", datum.span)
        name = datum.items[1]
        spelled = base_name(name.value)
        param = read_param(datum, spelled)
        form.params.append(param)
        target = self.expander.declare_target(name, self.scope, recursive=True, is_global=True)
        value = datum.items[2]
        if isinstance(value, Atom) and type(value.value) in (int, float):
            checked_value(param, value, value.span)  # the default must be within the bounds too
        if spelled in state.overrides:
            value = checked_value(param, state.overrides[spelled], value.span)

        def finish() -> Datum:
            return core("DEFINE", [target, self.expander.expand(value, self.scope)], datum.span)

        form.pending.append(Pending(finish, True, datum))

    # --- expanding ---------------------------------------------------------------------------------------------

    def finish(self) -> None:
        """Expand and parse every form; reuse expansions that are still valid."""
        for form in self.forms:
            step = form.expansion
            if step is not None and self._is_valid(step):
                self._apply_step(step)
                continue
            form.asts = []
            form.expansion = self._step(lambda form=form: self._finish_form(form))  # type: ignore[misc]

    def _finish_form(self, form: TopForm) -> None:
        """Expand and parse the pending parts of a form."""
        for item in form.pending:
            if isinstance(item, Import):
                form.asts.append(item)
                continue
            for tree in self._try(lambda item=item: self._parse(item.finish())) or ():  # type: ignore[misc]
                form.asts.append(replace(tree, top_level=True) if type(tree) is ast.Bind else tree)

    def _parse(self, datum: Datum) -> tuple[Any, ...]:
        """Parse an expanded form. A malformed form inside is recorded, and a placeholder takes its place."""
        for _ in range(_MAX_MALFORMED):
            try:
                return parse_core([datum])
            except FormError as error:
                if error.form is None or error.form is datum:
                    raise
                self._record(error)
                datum = _without(datum, error.form)
        return ()

    def finish_scene(self) -> ast.Call | None:
        """Return the ``(scene word argument ...)`` of the main file as a call."""
        scene = self.scene
        if scene is None:
            return None

        def expand() -> tuple[Any, ...]:
            operands = [self.expander.expand(item, self.scope) for item in scene.items[1:]]
            return parse_core([core("CALL", operands, scene.span)])

        trees: list[Any] = []
        step = self._step(lambda: trees.extend(self._try(expand) or ()))
        self.problems += step.problems
        return trees[0] if trees else None

    # --- results -----------------------------------------------------------------------------------------------

    def asts(self) -> Iterator[Any]:
        """Iterate over the core AST of all forms, including Imports, in order."""
        for form in self.forms:
            yield from form.asts

    def broken(self) -> Iterator[Any]:
        """Iterate over the core AST of the forms that have errors."""
        unread = {id(d.span.source): _SpanSet() for form in self.forms for d in form.read if d.is_error and d.span}
        for span in (d.span for form in self.forms for d in form.read if d.is_error):
            if span is not None:
                unread[id(span.source)].add(span)
        for form in self.forms:
            steps = (step for step in (form.scan, form.expansion) if step is not None)
            spans = (datum.span for datum in form.datums if id(datum.span.source) in unread)
            is_unread = any(unread[id(span.source)].overlaps(span) for span in spans)
            if is_unread or any(d.is_error for step in steps for d in step.problems):
                yield from form.asts

    def diagnostics(self) -> list[Diagnostic]:
        """Return the problems of the file.

        Unbound names are omitted if some definitions could not be read, because they would be consequential errors.
        """
        problems = list(self.problems)
        for form in self.forms:
            problems += form.read
            for step in (form.scan, form.expansion):
                problems += step.problems if step is not None else ()
        return [d for d in problems if not (self.is_incomplete and d.name == "unbound")]


def _without(datum: Datum, form: Datum) -> Datum:
    """Return a datum with a placeholder in place of one of the forms inside it."""
    if datum is form:
        return Atom(UNKNOWN, form.span)
    if isinstance(datum, Atom):
        return datum
    return replace(datum, items=tuple(_without(item, form) for item in datum.items))


def _no_macros(function: Datum, arguments: list[Any]) -> tuple[Any, bool]:
    """``RunMacro`` of library files, which cannot define procedural macros."""
    raise SceneError("macro", "the prelude cannot use procedural macros")


def _usage_hint(name: str) -> str | None:
    """Return the usage of a form as a hint, or None."""
    if name in FORMS:
        return f"usage: {FORMS[name].usage}"
    return _PAPER_USAGE.get(name)


_ONE_POSE = "`transform` takes one pose: `@` combines several, of which the last applies first, `(@ second first)`"
_PAPER_USAGE = {
    "call": 'usage: (call word embedding-or-attribute ...), such as (call "cube" :color [1 0 0])',
    "union": "usage: (union part ...)",
    "union-loop": "usage: (union-loop count function)",
    "transform": "usage: (transform part matrix); (@ pose ...) combines poses, the last applies first",
}


def _import_prefix(datum: ListDatum) -> str:
    """Return the prefix of ``(import "file" :prefix name)``, empty without one."""
    if len(datum.items) == 2:
        return ""
    key = datum.items[2]
    if len(datum.items) == 4 and isinstance(key, Atom) and isinstance(key.value, Keyword) and key.value == "prefix":
        if is_identifier(datum.items[3]):
            return base_name(datum.items[3].value)
    raise syntax_error("import", "unexpected operand of `import`", key.span)


# --- snapshots of a file's names, for a rollback after a form that fails ---------------------------------------------


@dataclass(frozen=True, slots=True)
class Snapshot:
    """Snapshot of a main file: its bindings, words, records, params and imports.

    ``ran`` are the ids of the files that have been run.
    """

    names: dict[Symbol, Any]
    imported_names: dict[Symbol, tuple[str, Any]]
    words: dict[str, Span]
    records: frozenset[str]
    scene: ListDatum | None
    params: tuple[Param, ...]
    files: dict[str, SourceFile]
    ran: frozenset[int]


def snapshot_of(file: SourceFile, ran: Iterable[int]) -> Snapshot:
    """Take a snapshot of a main file."""
    state = file.state
    assert state is not None
    return Snapshot(
        dict(dict.items(file.names)), dict(file.imported_names), dict(file.words),
        frozenset(file.expander.record_names), file.scene, tuple(state.params), dict(state.files), frozenset(ran),
    )  # fmt: skip


def roll_back(file: SourceFile, snapshot: Snapshot) -> None:
    """Roll a main file back to a snapshot."""
    state = file.state
    assert state is not None
    file.names.clear()
    file.names.replay(snapshot.names)
    file.imported_names, file.words, file.scene = dict(snapshot.imported_names), dict(snapshot.words), snapshot.scene
    file.expander.record_names.clear()
    file.expander.record_names |= snapshot.records
    state.params, state.files, state.loading = list(snapshot.params), dict(snapshot.files), []


# --- predefined names: forms, builtins, constants, and library modules written in the language -----------------------


class Prelude:
    """Predefined names of every program.

    A definition of the library modules written in the language is read and expanded when a program first needs its
    body: as a value, or to check the arguments of a call. Reading all of them took a seventh of ``check``.
    """

    def __init__(self, library: Library) -> None:
        self.library = library
        self.scope = Scope(None, self._lookup)
        self.definitions = PreludeDefinitions(self.scope)
        self._exports: dict[str, Any] = {}

    def _lookup(self, name: str) -> Any:
        """Return the binding of a predefined name, or None."""
        if name in FORMS:
            return Special(name)
        if name.startswith(STD):
            name = name[len(STD) :]
        builtin = self.library.builtins.get(name)
        if builtin is not None:
            return builtin
        if name in self.library.constants:
            return ConstantBinding(self.library.constants[name])
        place = self.library.prelude_names.get(name)
        if place is not None and name not in self._exports:
            variable = self.definitions.declare(name, place)
            is_paper_form = name in PAPER_FORMS
            self._exports[name] = PaperForm(PAPER_FORMS[name], variable) if is_paper_form else variable
        return self._exports.get(name)

    def names(self) -> Iterator[str]:
        """Iterate over all predefined names."""
        yield from self.library.builtins
        yield from self.library.constants
        # Names that start with `%` are private to the library.
        yield from (name for name in self.library.prelude_names if not name.startswith("%"))


class PreludeDefinitions(Mapping[Variable, ast.Define]):
    """Core forms of the definitions that programs have referred to; each is expanded when it is first asked for."""

    def __init__(self, scope: Scope) -> None:
        """Create the mapping; ``scope`` resolves the names in the definitions."""
        self._scope = scope
        self._places: dict[Variable, Span] = {}
        self._expanded: dict[Variable, ast.Define] = {}

    def declare(self, name: str, place: Span) -> Variable:
        """Return the variable of a definition, whose text is at ``place``."""
        start = place.source.text.index(name, place.start + len("(define "))
        variable = Variable(name, Span(place.source, start, start + len(name)), is_global=True, recursive=True)
        self._places[variable] = place
        return variable

    def __getitem__(self, variable: Variable) -> ast.Define:
        if variable not in self._expanded:
            self._expanded[variable] = self._expand(variable, self._places[variable])
        return self._expanded[variable]

    def __iter__(self) -> Iterator[Variable]:
        return iter(self._places)

    def __len__(self) -> int:
        return len(self._places)

    def _expand(self, variable: Variable, place: Span) -> ast.Define:
        """Read and expand one definition, as a file of its own whose spans are those of the whole module."""
        unit = SourceFile(place.source, self._scope)
        unit.expander.keep_global(variable)
        result = read_part(place)
        unit.forms = [TopForm((datum,), result.diagnostics) for datum in result.forms]
        unit.scan()
        unit.finish()
        errors = [d for d in unit.diagnostics() if d.is_error]
        assert not errors, errors[0].message
        (form,) = unit.asts()
        assert isinstance(form, ast.Define)
        assert form.target is variable
        return form


@lru_cache(maxsize=4)
def prelude_of(library: Library) -> Prelude:
    """Return the prelude of a library: the definitions in the language that every program can use.

    It is the same object for the same library, so that its files are expanded once per process.
    """
    return Prelude(library)


@dataclass(frozen=True, eq=False)
class Program:
    """Expanded program, ready to run.

    Attributes
    ----------
    main, sources
        Main file, and all files.
    forms
        Top-level forms of all files in execution order.
    scene
        The ``(scene ...)`` of the main file as a call, if any.
    words, all_words
        Location of the last binding of each word bound at top level, in the main file and in all files.
    params
        Declared params.
    diagnostics
        Errors and warnings.
    fact_cache
        Cached facts for lints.
    kinds
        Cached kinds of the forms' expressions.
    broken
        Ids of the forms with errors, in which placeholders replace code that could not be expanded.
    """

    main: Source
    sources: tuple[Source, ...]
    forms: tuple[Any, ...]
    scene: ast.Call | None
    words: Mapping[str, Span]
    all_words: Mapping[str, Span]
    params: tuple[Param, ...]
    diagnostics: tuple[Diagnostic, ...]
    fact_cache: FactCache
    kinds: KindBook
    broken: frozenset[int] = frozenset()

    @cached_property
    def facts(self) -> list[FormFacts]:
        """Facts about each of ``forms``, for lints."""
        return self.fact_cache.of(self.forms)

    @property
    def own_forms(self) -> Iterator[Any]:
        """The forms of the main file: what imported files declare of cameras and lights is theirs alone."""
        imported = {source.name for source in self.sources} - {self.main.name}
        return (form for form in self.forms if form.span.source.name not in imported)

    @property
    def ok(self) -> bool:
        """Whether the program has no errors."""
        return not any(d.is_error for d in self.diagnostics)


def load_program(
    main: Source,
    library: Library,
    load: Callable[[str, Source, Span], Source],
    run_macro: RunMacro,
    overrides: Mapping[str, Any] | None = None,
    datums: Sequence[Datum] | None = None,
) -> Program:
    """Read, expand and parse ``main`` and all files it imports.

    Errors of the program are not raised, but returned as diagnostics.

    Parameters
    ----------
    main
        Source of the main file.
    library
        Standard library.
    load
        Function ``load(path, importing source, span)`` that returns an imported file or raises ``SceneError``.
    run_macro
        Function that evaluates the body of a procedural macro.
    overrides
        Datums that replace the defaults of params, by name.
    datums
        Forms of the main file, if it is not written in the language itself.
    """
    state = ProgramState(prelude_of(library), load, dict(overrides or {}), run_macro)
    file = SourceFile(main, state.prelude.scope, state, is_main=True)
    file.forms = top_forms(main) if datums is None else [TopForm((datum,)) for datum in datums]
    return finish_program(file)


def finish_program(file: SourceFile) -> Program:
    """Scan and expand a main file whose forms have been read, and all its imports."""
    state = file.state
    assert state is not None
    state.files[file.source.name] = file
    state.loading.append(file.source.name)
    file.scan()
    state.loading.pop()
    for source_file in list(state.files.values()):
        source_file.finish()
    return assemble_program(file, file.finish_scene())


def assemble_program(file: SourceFile, scene: ast.Call | None) -> Program:
    """Assemble the program of an expanded main file and its imports."""
    state = file.state
    assert state is not None
    files = _import_order(file)
    diagnostics = [d for part in files for d in part.diagnostics()]
    for name in state.overrides.keys() - {param.name for param in state.params}:
        hint = suggest(name, (p.name for p in state.params)) or _known_params(state.params)
        diagnostics.append(Diagnostic("param", f"unknown param `{name}`", None, hint))
    forms: list[Any] = []
    collect(file, frozenset(), forms, set())
    all_words = {word: span for part in reversed(files) for word, span in part.words.items()}
    return Program(
        file.source, tuple(part.source for part in files), tuple(forms), scene, dict(file.words), all_words,
        tuple(state.params), tuple(diagnostics), state.fact_cache, state.kinds or KindBook(state.prelude.definitions),
        frozenset(id(tree) for part in files for tree in part.broken()),
    )  # fmt: skip


def _known_params(params: Sequence[Param]) -> str | None:
    """Return the hint that lists all params, or None if there are none."""
    return "available params: " + ", ".join(f"`{p.name}`" for p in params) if params else None


def _import_order(file: SourceFile) -> list[SourceFile]:
    """Return the files of a program, each before the files it imports."""
    files: dict[int, SourceFile] = {}
    stack = [file]
    while stack:
        current = stack.pop()
        if id(current) not in files:
            files[id(current)] = current
            stack.extend(reversed(current.imports))
    return list(files.values())


def collect(file: SourceFile, claimed: frozenset[str], forms: list[Any], done: set[int]) -> None:
    """Append the forms of a file and its imports to ``forms`` in execution order.

    Bindings of words that an importing file binds itself (``claimed``) are omitted. ``done`` are the ids of the files
    that were collected already.
    """
    if id(file) in done:
        return
    done.add(id(file))
    for form in file.asts():
        if isinstance(form, Import):
            collect(form.file, claimed | file.words.keys(), forms, done)
        elif type(form) is not ast.Bind or type(form.word) is not ast.Constant or form.word.value not in claimed:
            forms.append(form)
