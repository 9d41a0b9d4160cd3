"""Programs: files, imports and top-level forms, expanded and parsed into one list of core AST in running order."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

from scenelang.grammar import ast
from scenelang.grammar.core import parse_core
from scenelang.grammar.datum import Atom, Datum, Keyword, ListDatum, Symbol
from scenelang.grammar.diagnostics import Diagnostic, SceneError, suggest
from scenelang.grammar.reader import read
from scenelang.grammar.source import Source, Span
from scenelang.interpreter.expand import Expander, Pending, core, is_identifier, syntax_error
from scenelang.interpreter.forms import FORMS
from scenelang.interpreter.library import Builtin, Library
from scenelang.interpreter.scope import (
    ConstantBinding,
    Macro,
    PaperForm,
    Scope,
    Special,
    Variable,
    base_name,
)

PAPER_FORMS = {"call": "CALL", "union": "UNION", "union-loop": "UNION_LOOP", "transform": "TRANSFORM"}
STD = "std/"
_DEFINED = re.compile(r"^\(define \(?([^\s()]+)", re.M)


@dataclass(frozen=True, slots=True, eq=False)
class Param:
    """A ``(param name default "doc" :min a :max b)`` of a program."""

    name: str
    default: str
    doc: str
    minimum: float | None
    maximum: float | None
    span: Span


@dataclass(frozen=True, slots=True, eq=False)
class Program:
    """A program ready to run. ``forms`` are the top-level forms of every file in running order.

    ``scene`` is the main file's ``(scene ...)``; ``words`` maps each word that the main file binds at top level to the
    place of its (last) binding; ``all_words`` does so for all files.
    """

    main: Source
    sources: tuple[Source, ...]
    forms: tuple[Any, ...]
    scene: ast.Call | None
    words: Mapping[str, Span]
    all_words: Mapping[str, Span]
    params: tuple[Param, ...]
    diagnostics: tuple[Diagnostic, ...]

    @property
    def ok(self) -> bool:
        return not any(d.is_error for d in self.diagnostics)


class Prelude:
    """The definitions that every program sees, from the library's modules, expanded once per process and only when a
    program uses a name that is neither a form nor a builtin."""

    def __init__(self, library: Library) -> None:
        self.library = library
        self.scope = Scope(None, self._lookup)
        self.definitions: dict[Variable, ast.Define] = {}
        self._exports: dict[str, Any] = {}
        self._pending = list(library.prelude)
        self._homes = {name: module for module in library.prelude for name in _DEFINED.findall(library.modules[module])}
        self._loading = False

    def _lookup(self, name: str) -> Any:
        if name in FORMS:
            return Special(name)
        if name.startswith(STD):
            name = name[len(STD) :]
        builtin = self.library.builtins.get(name)
        if builtin is not None:
            return builtin
        if name in self.library.constants:
            return ConstantBinding(self.library.constants[name])
        module = self._homes.get(name)
        while module in self._pending and not self._loading:
            self._load(self._pending.pop(0))
        return self._exports.get(name)

    def _load(self, module: str) -> None:
        self._loading = True
        source = Source(f"{STD}{module}", self.library.modules[module])
        unit = _File(source, self.scope, _no_macros, None)
        unit.scan()
        for form in unit.finish():
            assert isinstance(form, ast.Define)
            self.definitions[form.target] = form
        errors = [d for d in unit.expander.diagnostics if d.is_error]
        assert not errors, errors[0].message
        for symbol, binding in unit.scope.bindings.items():
            name = str(symbol)
            if name in PAPER_FORMS:
                binding = PaperForm(PAPER_FORMS[name], binding)
            self._exports[name] = binding
        self._loading = False

    def names(self) -> Iterator[str]:
        """Every name that programs see without defining it."""
        while self._pending and not self._loading:
            self._load(self._pending.pop(0))
        yield from self.library.builtins
        yield from self.library.constants
        yield from (name for name in self._exports if not name.startswith("%"))  # those are the library's own


@lru_cache(maxsize=4)
def prelude_of(library: Library) -> Prelude:
    return Prelude(library)


def _no_macros(procedure: list[Any], function: Datum, arguments: list[Any]) -> Any:
    raise SceneError("macro", "the prelude defines no procedural macros")


@dataclass(frozen=True, slots=True, eq=False)
class _Import:
    """A top-level ``import``: the file that it brings, in its place among the forms."""

    file: _File


@dataclass(slots=True, eq=False)
class _State:
    """What the files of one program share while they are loaded."""

    prelude: Prelude
    load: Callable[[str, Source, Span], Source]
    overrides: dict[str, Any]
    run_macro: Callable[[list[Any], Datum, list[Any]], Any]
    files: dict[str, _File] = field(default_factory=dict)
    loading: list[str] = field(default_factory=list)
    params: list[Param] = field(default_factory=list)
    used_overrides: set[str] = field(default_factory=set)


class _FileExpander(Expander):
    def __init__(self, file: _File, run_macro: Any) -> None:
        super().__init__(run_macro)
        self._file = file

    def known_names(self) -> Iterable[str]:
        state = self._file.state
        return state.prelude.names() if state is not None else ()

    def importable_from(self, name: str) -> str | None:
        state = self._file.state
        module = state.prelude.library.module_of(name.removeprefix(STD)) if state is not None else None
        return f"{STD}{module}" if module is not None else None

    def bound_words(self) -> Iterable[str]:
        state = self._file.state
        return [word for file in (self._file, *(state.files.values() if state else ())) for word in file.words]


class _File:
    """One file on its way: scanned for definitions first, then expanded form by form."""

    def __init__(
        self, source: Source, parent: Scope, run_macro: Any, state: _State | None, is_main: bool = False,
        datums: Sequence[Datum] | None = None,
    ) -> None:  # fmt: skip
        self.source = source
        self._datums = datums
        self.scope = Scope(parent)
        self.state = state
        self.is_main = is_main
        self.is_incomplete = False  # an import of it failed
        self.expander = _FileExpander(self, run_macro)
        self.pending: list[Pending | _Import] = []
        self.words: dict[str, Span] = {}
        self.imports: list[_File] = []
        self.scene: Any = None
        self.forms: list[Any] = []

    # --- scanning ----------------------------------------------------------------------------------------------

    def scan(self) -> None:
        """Read the file; find its definitions, macros and imports."""
        datums = self._datums
        if datums is None:
            result = read(self.source)
            self.expander.diagnostics.extend(result.diagnostics)
            datums = result.forms
        for datum in datums:
            self._guarded(lambda datum=datum: self._scan_form(datum))  # type: ignore[misc]

    def _guarded(self, action: Callable[[], Any]) -> Any:
        """Run a step; what goes wrong in it is noted, so that the other forms are still looked at."""
        try:
            return action()
        except SceneError as error:
            if error.name in ("file", "import-cycle", "import-outside"):
                self.is_incomplete = True
            if error.name == "unbound" and self.is_incomplete:
                return None  # the file that was not found may define it
            if error.name == "syntax" and isinstance(error.value, str):
                error.hint = error.hint or _usage_hint(error.value)
            self.expander.diagnostics.append(error.diagnostic)
            return None

    def _scan_form(self, datum: Datum) -> None:
        while isinstance(datum, ListDatum) and datum.items and datum.tail is None:
            binding = self.expander.binding_of(datum.items[0], self.scope)
            if isinstance(binding, Macro):
                datum = self.expander.expand_macro(binding, datum, self.scope)
                continue
            name = binding.name if isinstance(binding, Special) else None
            if name == "begin":
                for item in datum.items[1:]:
                    self._scan_form(item)
                return
            handler = {"import": self._scan_import, "scene": self._scan_scene, "param": self._scan_param}.get(
                name or ""
            )
            if handler is not None and self.state is not None:
                handler(datum)
                return
            if name == "bind":
                self._note_word(datum)
            break
        found: list[Pending] = []
        self.expander.scan(datum, self.scope, found)
        self.pending.extend(found)

    def _note_word(self, datum: ListDatum) -> None:
        word = datum.items[1] if len(datum.items) > 1 else None
        if isinstance(word, Atom) and type(word.value) is str:
            if word.value in self.words:
                message = f'"{word.value}" is bound twice in this file; the last binding wins'
                self.expander.diagnostics.append(Diagnostic("bound-twice", message, word.span))
            self.words[word.value] = word.span

    def _scan_import(self, datum: ListDatum) -> None:
        assert self.state is not None
        path = datum.items[1] if len(datum.items) > 1 else None
        if not isinstance(path, Atom) or type(path.value) is not str:
            raise syntax_error("import", "`import` needs the name of a file, a string", datum.span)
        prefix = self._import_prefix(datum)
        file = self._load(path.value, path.span)
        self.pending.append(_Import(file))
        self.imports.append(file)
        for symbol, binding in file.scope.bindings.items():
            name = Symbol(prefix + base_name(symbol))
            if isinstance(binding, Builtin) and symbol.startswith(STD):
                name = symbol  # the original of a builtin is always `std/name`
            if isinstance(binding, (Variable, Macro, Builtin)) and name not in self.scope.bindings:
                self.scope.bindings[name] = binding
        self.expander.record_names |= file.expander.record_names

    def _import_prefix(self, datum: ListDatum) -> str:
        if len(datum.items) == 2:
            return ""
        key = datum.items[2]
        if len(datum.items) == 4 and isinstance(key, Atom) and type(key.value) is Keyword and key.value == "prefix":
            if is_identifier(datum.items[3]):
                return base_name(datum.items[3].value)
        raise syntax_error("import", "`import` has no place for this", key.span)

    def _load(self, path: str, span: Span) -> _File:
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
            file = state.files[source.name] = _File(source, state.prelude.scope, state.run_macro, state)
            if path.startswith(STD):
                file.bring(state.prelude.library.imported.get(path[len(STD) :], {}))
            state.loading.append(source.name)
            file.scan()
            state.loading.pop()
        return state.files[source.name]

    def bring(self, builtins: Mapping[str, Builtin]) -> None:
        """Give the file builtins that programs have only by importing it."""
        for name, builtin in builtins.items():
            self.scope.bindings[Symbol(name)] = self.scope.bindings[Symbol(STD + name)] = builtin

    def _scan_scene(self, datum: ListDatum) -> None:
        if not self.is_main:
            return
        if len(datum.items) < 2:
            raise syntax_error("scene", "`scene` needs a word", datum.span)
        if self.scene is not None:
            raise SceneError("duplicate", "there are two `(scene ...)` forms", None, datum.span)
        self.scene = datum

    def _scan_param(self, datum: ListDatum) -> None:
        state = self.state
        assert state is not None
        if len(datum.items) < 3 or not is_identifier(datum.items[1]):
            raise syntax_error("param", "`param` needs a name and a value", datum.span)
        name = datum.items[1]
        spelled = base_name(name.value)
        param = _param(datum, spelled)
        state.params.append(param)
        target = self.expander.declare_target(name, self.scope, recursive=True, is_global=True)
        value = datum.items[2]
        if isinstance(value, Atom) and type(value.value) in (int, float):
            _override(param, value, value.span)  # the default must be in range too
        if spelled in state.overrides:
            state.used_overrides.add(spelled)
            value = _override(param, state.overrides[spelled], value.span)
        finish = lambda: core("DEFINE", [target, self.expander.expand(value, self.scope)], datum.span)
        self.pending.append(Pending(finish, True, datum))

    # --- expanding ---------------------------------------------------------------------------------------------

    def finish(self) -> list[Any]:
        """Expand and parse every form; the core AST in running order, imports in their places."""
        for item in self.pending:
            if isinstance(item, _Import):
                self.forms.append(item)
                continue
            for form in self._guarded(lambda item=item: parse_core([item.finish()])) or ():  # type: ignore[misc]
                self.forms.append(form)
        return self.forms

    def finish_scene(self) -> ast.Call | None:
        """The ``(scene word argument ...)`` of the main file as a call."""
        if self.scene is None:
            return None
        expand = lambda: parse_core(
            [core("CALL", [self.expander.expand(item, self.scope) for item in self.scene.items[1:]], self.scene.span)]
        )
        found = self._guarded(expand)
        return found[0] if found else None


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


def _param(datum: ListDatum, name: str) -> Param:
    rest = list(datum.items[3:])
    doc = ""
    if rest and isinstance(rest[0], Atom) and type(rest[0].value) is str:
        doc = rest.pop(0).value
    ends: dict[str, float] = {}
    while rest:
        key = rest.pop(0)
        known = isinstance(key, Atom) and type(key.value) is Keyword and str(key.value) in ("min", "max")
        if not known or not rest or not isinstance(rest[0], Atom) or type(rest[0].value) not in (int, float):
            raise syntax_error("param", "`param` has no place for this", key.span)
        ends[str(key.value)] = rest.pop(0).value
    default = " ".join(datum.items[2].span.text.split())
    return Param(name, default, doc, ends.get("min"), ends.get("max"), datum.span)


def _override(param: Param, value: Any, span: Span) -> Datum:
    """The datum that takes the place of a param's default."""
    datum: Datum = value
    number = datum.value if isinstance(datum, Atom) and type(datum.value) in (int, float) else None
    for bound, sign, word in ((param.minimum, 1, "least"), (param.maximum, -1, "most")):
        if number is None and bound is not None:
            raise SceneError("param", f"`{param.name}` must be a number, at {word} {bound}", None, param.span)
        if number is not None and bound is not None and sign * number < sign * bound:
            raise SceneError("param", f"`{param.name}` must be at {word} {bound}, got {number}", None, param.span)
    return datum


def load_program(
    main: Source,
    library: Library,
    load: Callable[[str, Source, Span], Source],
    run_macro: Callable[[list[Any], Datum, list[Any]], Any],
    overrides: Mapping[str, Any] | None = None,
    datums: Sequence[Datum] | None = None,
) -> Program:
    """Read, expand and parse ``main`` and all that it imports. Never raises for a mistake in a program.

    ``load(path, importing source, span)`` finds an imported file or raises SceneError; ``overrides`` maps names of
    params to datums; ``datums`` are the main file's forms when it is written in something else.
    """
    prelude = prelude_of(library)
    state = _State(prelude, load, dict(overrides or {}), run_macro)
    file = _File(main, prelude.scope, run_macro, state, True, datums)
    state.files[main.name] = file
    state.loading.append(main.name)
    file.scan()
    for each in list(state.files.values()):
        each.finish()
    scene = file.finish_scene()
    diagnostics = [d for each in _in_order(file) for d in each.expander.diagnostics]
    for name in state.overrides.keys() - state.used_overrides:
        hint = suggest(name, (p.name for p in state.params)) or _known_params(state.params)
        diagnostics.append(Diagnostic("param", f"the program has no `param` named `{name}`", None, hint))
    forms: list[Any] = []
    _collect(file, frozenset(), forms, set())
    all_words = {word: span for each in reversed(_in_order(file)) for word, span in each.words.items()}
    return Program(
        main, tuple(each.source for each in _in_order(file)), tuple(forms), scene, file.words, all_words,
        tuple(state.params), tuple(diagnostics),
    )  # fmt: skip


def _known_params(params: Sequence[Param]) -> str | None:
    return "it has " + ", ".join(f"`{p.name}`" for p in params) if params else None


def _in_order(file: _File) -> list[_File]:
    """The files of a program, each before those that it imports."""
    found: dict[int, _File] = {}
    stack = [file]
    while stack:
        each = stack.pop()
        if id(each) not in found:
            found[id(each)] = each
            stack.extend(reversed(each.imports))
    return list(found.values())


def _collect(file: _File, claimed: frozenset[str], forms: list[Any], done: set[int]) -> None:
    """Forms in running order. A word that an importing file binds belongs to it: the imported binding is left out."""
    if id(file) in done:
        return
    done.add(id(file))
    for form in file.forms:
        if isinstance(form, _Import):
            _collect(form.file, claimed | file.words.keys(), forms, done)
            continue
        if type(form) is ast.Bind and type(form.word) is ast.Constant:
            if form.word.value in claimed:
                continue
            form = ast.Bind(form.word, form.function, form.span, top_level=True)
        forms.append(form)
