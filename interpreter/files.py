"""One file of a program on its way: scanned for definitions first, then expanded form by form into core AST.

Each top-level form keeps what was found in it and what it looked up (``ledger``), so that a later version of the file
can use it again (``incremental``).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

from scenelang.grammar import ast
from scenelang.grammar.core import parse_core
from scenelang.grammar.datum import Atom, Datum, Keyword, ListDatum, Symbol
from scenelang.grammar.diagnostics import Diagnostic, SceneError, suggest
from scenelang.grammar.source import Source, Span
from scenelang.interpreter.expand import (
    MAX_EXPANDED,
    MAX_EXPANSIONS,
    Pending,
    RunMacro,
    Use,
    core,
    is_identifier,
    syntax_error,
)
from scenelang.interpreter.file_expander import FileExpander
from scenelang.interpreter.forms import FORMS
from scenelang.interpreter.ledger import Ledger
from scenelang.interpreter.library import STD, Builtin
from scenelang.interpreter.lint.facts import FactBook
from scenelang.interpreter.params import Param, checked_value, read_param
from scenelang.interpreter.scope import Macro, Scope, Special, Variable, base_name
from scenelang.interpreter.top_forms import Import, Step, TopForm, top_forms

if TYPE_CHECKING:
    from scenelang.interpreter.prelude import Prelude


@dataclass(slots=True, eq=False)
class ProgramState:
    """What the files of one program share while they are loaded. ``kept`` are files of an earlier version;
    ``keeps_uses``: editors want to know what every identifier means."""

    prelude: Prelude
    load: Callable[[str, Source, Span], Source]
    overrides: Mapping[str, Any]
    run_macro: RunMacro
    files: dict[str, SourceFile] = field(default_factory=dict)
    loading: list[str] = field(default_factory=list)
    params: list[Param] = field(default_factory=list)
    kept: Mapping[str, SourceFile] = field(default_factory=dict)
    book: FactBook = field(default_factory=FactBook)
    keeps_uses: bool = False


_MISSING = ("file", "import-cycle", "import-outside")
_UNREADABLE = ("unclosed", "extra-close", "nesting", "bad-dot", "syntax")


class SourceFile:
    """A file of a program. ``scan`` and ``finish`` may be repeated, with other ``forms`` for a new version of its
    text; without a ``state`` the file is one of the library's own."""

    def __init__(self, source: Source, parent: Scope, state: ProgramState | None = None, is_main: bool = False) -> None:
        self.source = source
        self.names = Ledger()
        self.scope = Scope(parent)
        self.scope.bindings = self.names
        self.state = state
        self.is_main = is_main
        self.expander = FileExpander(self, state.run_macro if state is not None else _no_macros)
        self.forms: list[TopForm] = []
        self.begin()

    def begin(self) -> None:
        """Forget what was found, but for the forms themselves and the identity of variables."""
        self.names.clear()
        self.expander.begin()
        self.problems: list[Diagnostic] = []  # those of the whole file
        self.words: dict[str, Span] = {}
        self.imports: list[SourceFile] = []
        self.brought: dict[Symbol, tuple[str, Any]] = {}  # names that an import gave: the file's name, the binding
        self.scene: ListDatum | None = None
        self.is_incomplete = False  # something that may define names could not be read
        if self.state is not None and self.source.name.startswith(STD):
            self._bring(self.state.prelude.library.imported.get(self.source.name[len(STD) :], {}))

    def _bring(self, builtins: Mapping[str, Builtin]) -> None:
        """Give the file builtins that programs have only by importing it."""
        for name, builtin in builtins.items():
            self.names[Symbol(name)] = self.names[Symbol(STD + name)] = builtin

    # --- scanning ----------------------------------------------------------------------------------------------

    def scan(self) -> None:
        """Find definitions, macros and imports; of a form whose last scan still holds that is taken over."""
        self.begin()
        for form in self.forms:
            self._scan_top(form)

    def take_in(self, forms: Sequence[TopForm]) -> None:
        """Scan and expand further forms, which may define names anew; the file's own ``forms`` stay as they are."""
        records = set(self.expander.record_names)
        self.expander.begin()
        self.expander.record_names |= records
        self.problems = []
        for form in forms:
            self._scan_top(form)
        for form in forms:
            form.expansion = self._step(lambda form=form: self._finish_form(form))  # type: ignore[misc]

    def _scan_top(self, form: TopForm) -> None:
        if self._holds(form.scan) and not form.imports:
            assert form.scan is not None
            self._take_over(form.scan)
        else:
            form.forget()
            form.scan = self._step(lambda: self._scan_all(form))
        self._take(form)

    def _take_over(self, step: Step) -> None:
        """Do what a finished step did to the file's names and to the account of macros."""
        self.names.replay(step.record.bound)
        self.expander.declared |= {b.name for b in step.record.bound.values() if isinstance(b, Variable)}
        self.expander.expansions += step.expansions
        self.expander.expanded += step.expanded

    def _scan_all(self, form: TopForm) -> None:
        self.expander.found_records = form.records
        for datum in form.datums:
            self._guarded(lambda datum=datum: self._scan_form(datum, form))  # type: ignore[misc]

    def _holds(self, step: Step | None) -> bool:
        """Whether a step's result can be used again."""
        if step is None or not self.names.agrees(step.record):
            return False
        expander = self.expander
        return (
            expander.expansions + step.expansions <= MAX_EXPANSIONS
            and expander.expanded + step.expanded <= MAX_EXPANDED
        )

    def _step(self, action: Callable[[], Any]) -> Step:
        """Do one step of a form and keep account of it."""
        expander = self.expander
        expansions, expanded = expander.expansions, expander.expanded
        record = self.names.begin()
        problems: list[Diagnostic] = []
        expander.diagnostics = problems
        uses: list[Use] = []
        expander.uses = uses if self.state is not None and self.state.keeps_uses else None
        action()
        return Step(record, problems, expander.expansions - expansions, expander.expanded - expanded, uses)

    def _take(self, form: TopForm) -> None:
        """Add to the file what a scanned form holds."""
        for word, span in form.words:
            if word in self.words:
                message = f'"{word}" is bound twice in this file; the last binding wins'
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
            self.problems.append(Diagnostic("duplicate", "there are two `(scene ...)` forms", form.scene.span))
        elif form.scene is not None:
            self.scene = form.scene

    def _guarded(self, action: Callable[[], Any]) -> Any:
        """Run a step; what goes wrong in it is noted, so that the other forms are still looked at."""
        try:
            return action()
        except SceneError as error:
            if error.name == "syntax" and isinstance(error.value, str):
                error.hint = error.hint or _usage_hint(error.value)
            self.expander.diagnostics.append(error.diagnostic)
            return None

    def _scan_form(self, datum: Datum, form: TopForm) -> None:
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
        found: list[Pending] = []
        self.expander.scan(datum, self.scope, found)
        form.pending.extend(found)

    def _scan_import(self, datum: ListDatum, form: TopForm) -> None:
        path = datum.items[1] if len(datum.items) > 1 else None
        if not isinstance(path, Atom) or type(path.value) is not str:
            raise syntax_error("import", "`import` needs the name of a file, a string", datum.span)
        prefix = _import_prefix(datum)
        file = self._load(path.value, path.span)
        form.pending.append(Import(file))
        form.imports.append(file)
        for symbol, binding in file.scope.bindings.items():
            name = Symbol(prefix + base_name(symbol))
            if isinstance(binding, Builtin) and symbol.startswith(STD):
                name = symbol  # the original of a builtin is always `std/name`
            if isinstance(binding, (Variable, Macro, Builtin)) and self._may_bring(name, file):
                self.scope.bindings[name] = binding
                self.brought[name] = (file.source.name, binding)
        form.records |= file.expander.record_names

    def _may_bring(self, name: Symbol, file: SourceFile) -> bool:
        """Whether an import may bind a name: nothing else does, or an earlier version of the same file did."""
        if name not in self.scope.bindings:
            return True
        origin, binding = self.brought.get(name, ("", None))
        return origin == file.source.name and dict.get(self.names, name) is binding

    def _load(self, path: str, span: Span) -> SourceFile:
        state = self.state
        assert state is not None
        if path.startswith(STD):
            text = state.prelude.library.modules.get(path[len(STD) :])
            if text is None:
                hint = suggest(path, (STD + name for name in state.prelude.library.modules))
                raise SceneError("file", f"the standard library has no `{path}`", hint, span)
            source = Source(path, text)
        else:
            source = state.load(path, self.source, span)
        if source.name in state.loading:
            circle = " -> ".join([*state.loading[state.loading.index(source.name) :], source.name])
            raise SceneError("import-cycle", f"these files import one another: {circle}", None, span)
        if source.name not in state.files:
            file = state.kept.get(source.name)
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
        if not self.is_main:
            return
        if len(datum.items) < 2:
            raise syntax_error("scene", "`scene` needs a word", datum.span)
        if form.scene is not None:
            raise SceneError("duplicate", "there are two `(scene ...)` forms", None, datum.span)
        form.scene = datum

    def _scan_param(self, datum: ListDatum, form: TopForm) -> None:
        state = self.state
        assert state is not None
        if len(datum.items) < 3 or not is_identifier(datum.items[1]):
            raise syntax_error("param", "`param` needs a name and a value", datum.span)
        name = datum.items[1]
        spelled = base_name(name.value)
        param = read_param(datum, spelled)
        form.params.append(param)
        target = self.expander.declare_target(name, self.scope, recursive=True, is_global=True)
        value = datum.items[2]
        if isinstance(value, Atom) and type(value.value) in (int, float):
            checked_value(param, value, value.span)  # the default must be in range too
        if spelled in state.overrides:
            value = checked_value(param, state.overrides[spelled], value.span)
        finish = lambda: core("DEFINE", [target, self.expander.expand(value, self.scope)], datum.span)
        form.pending.append(Pending(finish, True, datum))

    # --- expanding ---------------------------------------------------------------------------------------------

    def finish(self) -> None:
        """Expand and parse every form; one whose expansion still holds keeps it."""
        for form in self.forms:
            step = form.expansion
            if step is not None and self._holds(step):
                self._take_over(step)
                continue
            form.asts = []
            form.expansion = self._step(lambda form=form: self._finish_form(form))  # type: ignore[misc]

    def _finish_form(self, form: TopForm) -> None:
        for item in form.pending:
            if isinstance(item, Import):
                form.asts.append(item)
                continue
            for tree in self._guarded(lambda item=item: parse_core([item.finish()])) or ():  # type: ignore[misc]
                form.asts.append(replace(tree, top_level=True) if type(tree) is ast.Bind else tree)

    def finish_scene(self) -> ast.Call | None:
        """The ``(scene word argument ...)`` of the main file as a call."""
        scene = self.scene
        if scene is None:
            return None
        expand = lambda: parse_core(
            [core("CALL", [self.expander.expand(item, self.scope) for item in scene.items[1:]], scene.span)]
        )
        found: list[Any] = []
        step = self._step(lambda: found.extend(self._guarded(expand) or ()))
        self.problems += step.problems
        return found[0] if found else None

    # --- what was found ----------------------------------------------------------------------------------------

    def asts(self) -> Iterator[Any]:
        """The core AST of every form, and Imports, in order."""
        for form in self.forms:
            yield from form.asts

    def diagnostics(self) -> list[Diagnostic]:
        """What is wrong with the file. Where something is missing, names without definition say nothing."""
        found = list(self.problems)
        for form in self.forms:
            found += form.read
            for step in (form.scan, form.expansion):
                found += step.problems if step is not None else ()
        return [d for d in found if not (self.is_incomplete and d.name == "unbound")]


def _no_macros(function: Datum, arguments: list[Any]) -> tuple[Any, bool]:
    raise SceneError("macro", "the prelude defines no procedural macros")


def _usage_hint(name: str) -> str | None:
    if name in FORMS:
        return f"its shape is {FORMS[name].usage}"
    return _PAPER_USAGE.get(name)


_PAPER_USAGE = {
    "call": 'its shape is (call word embedding-or-attribute ...), such as (call "cube" :color [1 0 0])',
    "union": "its shape is (union part ...)",
    "union-loop": "its shape is (union-loop count function)",
    "transform": "its shape is (transform part matrix)",
}


def _import_prefix(datum: ListDatum) -> str:
    if len(datum.items) == 2:
        return ""
    key = datum.items[2]
    if len(datum.items) == 4 and isinstance(key, Atom) and isinstance(key.value, Keyword) and key.value == "prefix":
        if is_identifier(datum.items[3]):
            return base_name(datum.items[3].value)
    raise syntax_error("import", "`import` has no place for this", key.span)
