"""Incremental evaluation for the REPL and editors: forms are read, expanded and run one after another.

Names may be redefined. Each form is a transaction: if it fails, its bindings and side effects are rolled back, because
the first write to an older object saves a copy (``JournaledRuntime``). ``guard`` does not roll back, because programs
rely on their side effects. All global variables count as assigned, so that a shared call that reads one is valid only
until it changes. If a name gets another meaning than a new value of its variable (a macro, a record, a library name, an
import), the functions whose expansion looked it up are expanded and created again.
"""

from __future__ import annotations

from bisect import bisect_right
from collections import Counter, defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any

from scenelang.grammar import ast
from scenelang.grammar.datum import Atom, Datum, ListDatum, Source, Span, Symbol, comment_above
from scenelang.grammar.diagnostics import Diagnostic, SceneError, error_of, moved_diagnostic, moved_span
from scenelang.grammar.reader import Chunk, read, split_again
from scenelang.interpreter.checker.book import KindBook
from scenelang.interpreter.checker.lint import WHOLE_FILE, LintCache, new_form_warnings
from scenelang.interpreter.checker.program import (
    Import,
    LookupRecord,
    Prelude,
    Program,
    ProgramState,
    Snapshot,
    SourceFile,
    TopForm,
    assemble_program,
    collect,
    finish_program,
    prelude_of,
    roll_back,
    snapshot_of,
    top_forms,
)
from scenelang.interpreter.checker.rules import FactCache, bound_word
from scenelang.interpreter.compile.analyze import pattern_variables
from scenelang.interpreter.evaluation.evaluate import (
    ProgramRun,
    SessionCalls,
    SessionForm,
    is_plain,
    is_same,
    uses_later_definitions,
)
from scenelang.interpreter.expand.expand import RunMacro
from scenelang.interpreter.expand.scope import Scope, Variable, base_name
from scenelang.interpreter.runtime.procedures import UNDEFINED, Cell
from scenelang.interpreter.runtime.runtime import JournaledRuntime, raised_value
from scenelang.interpreter.runtime.types import Library
from scenelang.interpreter.scene.entity import Scene
from scenelang.interpreter.scene.setup import Setup
from scenelang.interpreter.values.values import Mutable

# --- incremental analysis of a program under edit: only the forms that an edit may affect are analyzed again ----------
#
# The main file is split into top-level pieces. A piece with unchanged text reuses its datums, and also its scan and
# expansion if every name they looked up still has the same meaning (``TrackedNames``). A top-level name keeps its
# variable across versions, so a change inside a function does not affect its callers. Spans inside a piece are relative
# to it; ``Version.place`` converts them to the whole text. The result equals a full analysis.


@dataclass(frozen=True, slots=True, eq=False)
class Piece:
    """Top-level piece of the text with its form.

    ``source`` contains only the text of the piece, indented by blanks to its column.
    """

    text: str
    source: Source
    form: TopForm


@dataclass(frozen=True, slots=True, eq=False)
class Version:
    """Analyzed version of the text of a file.

    Attributes
    ----------
    source
        The whole text.
    pieces
        Its top-level forms, each with the offset of its source in the whole text.
    program
        Program with its diagnostics.
    file
        File with its bindings.
    offsets
        The same offsets, by the id of a piece's source.
    is_moved
        Whether it has the pieces of the version before it, and so the same forms, at other places or none.
    """

    source: Source
    pieces: tuple[tuple[int, Piece], ...]
    program: Program
    file: SourceFile
    offsets: Mapping[int, int]
    is_moved: bool = False

    def place(self, span: Span) -> Span:
        """Convert a span of a piece to the whole text; spans of other files are unchanged."""
        return moved_span(span, self._move)

    def _move(self, span: Span) -> tuple[Source, int]:
        """Return the source and the offset to which a span moves."""
        offset = self.offsets.get(id(span.source))
        return (span.source, 0) if offset is None else (self.source, offset)

    def diagnostic(self, diagnostic: Diagnostic) -> Diagnostic:
        """Convert the spans of a diagnostic to the whole text."""
        return moved_diagnostic(diagnostic, self.place)


class Versions:
    """Incremental analyzer of the successive versions of one main file."""

    def __init__(self, prelude: Prelude) -> None:
        """Create an analyzer that has seen no version; programs use the definitions of ``prelude``."""
        self._prelude = prelude
        # The last version, from which the next one reuses what is equal:
        self._text = ""
        self._chunks: tuple[Chunk, ...] = ()
        self._pieces: tuple[tuple[int, Piece], ...] = ()
        self._program: Program | None = None
        self._state: ProgramState | None = None
        self._file: SourceFile | None = None
        self._fact_cache = FactCache()
        self._kinds = KindBook(prelude.definitions)  # inferred kinds of the forms
        self._overrides: Mapping[str, str] = {}  # texts of the values that replace defaults of params, by name

    def analyze(
        self,
        source: Source,
        load: Callable[[str, Source, Span], Source],
        run_macro: RunMacro,
        overrides: Mapping[str, Datum] | None = None,
    ) -> Version:
        """Analyze the next version of the file.

        Parameters
        ----------
        source
            Text of the version.
        load, run_macro, overrides
            As for ``load_program``.

        Returns
        -------
        Version
            Program with its diagnostics. Forms that have not changed are those of the previous version.
        """
        values = overrides or {}
        texts = {name: datum.span.text for name, datum in values.items()}
        has_same_values = texts == self._overrides
        if not has_same_values:
            self._pieces = tuple((start, piece) for start, piece in self._pieces if not piece.form.params)
        self._overrides = texts
        before, last = self._pieces, self._program
        self._program = None  # so that a version whose analysis fails is none that a later one can be equal to
        self._chunks = chunks = split_again(source.text, self._text, self._chunks)
        self._text = source.text
        self._pieces = pieces = self._next_pieces(source, chunks)
        offsets = {id(piece.source): start for start, piece in pieces}
        if has_same_values and last is not None and self._is_same(source, last, before):
            assert self._file is not None
            self._file.source = source
            self._program = replace(last, main=source, sources=(source,))
            return Version(source, pieces, self._program, self._file, offsets, is_moved=True)
        self._file = file = self._next_file(source, load, values, run_macro)
        file.forms = [piece.form for _, piece in pieces]
        self._program = finish_program(file)
        return Version(source, pieces, self._program, file, offsets)

    def _is_same(self, source: Source, program: Program, before: Sequence[tuple[int, Piece]]) -> bool:
        """Return whether the file has the pieces of its last version, and imports none, which may have changed.

        After an edit of a comment or of a blank line all forms are where they were, or moved. A finding about the file
        itself has a place in its text.
        """
        if program.main.name != source.name or len(program.sources) != 1:
            return False
        if len(before) != len(self._pieces) or any(
            old is not new or old.form.imports for (_, old), (_, new) in zip(before, self._pieces)
        ):
            return False
        return all(d.span is None or d.span.source is not program.main for d in program.diagnostics)

    def _next_file(
        self,
        source: Source,
        load: Callable[[str, Source, Span], Source],
        values: Mapping[str, Datum],
        run_macro: RunMacro,
    ) -> SourceFile:
        """Return the file for its next version, with the scans and expansions of the one before."""
        previous = self._state.files if self._state is not None else {}
        self._state = state = ProgramState(
            self._prelude,
            load,
            values,
            run_macro,
            previous_files=previous,
            fact_cache=self._fact_cache,
            kinds=self._kinds,
            records_uses=True,
        )
        file = self._file
        if file is None or file.source.name != source.name:
            return SourceFile(source, self._prelude.scope, state, is_main=True)
        file.source, file.state, file.expander.run_macro = source, state, run_macro
        return file

    def _next_pieces(self, source: Source, chunks: Sequence[Chunk]) -> tuple[tuple[int, Piece], ...]:
        """Return the pieces of a text, reusing those with the same text and column in the previous version."""
        known: defaultdict[str, list[Piece]] = defaultdict(list)
        for _, piece in reversed(self._pieces):
            known[piece.text].append(piece)
        pieces = []
        for chunk in chunks:
            text = " " * chunk.column + chunk.text
            piece = known[text].pop() if known[text] else _piece(source.name, text)
            pieces.append((chunk.start - chunk.column, piece))
        return tuple(pieces)


def _piece(name: str, text: str) -> Piece:
    """Read a new piece."""
    source = Source(name, text)
    result = read(source)
    return Piece(text, source, TopForm(result.forms, result.diagnostics))


# --- REPL history variables: the last values ``*1 *2 *3`` and the last error ``*e`` -----------------------------------


VALUES = ("*1", "*2", "*3")
ERROR = "*e"


class History:
    """REPL history variables, bound in ``scope``. All are initially none."""

    def __init__(self, run: ProgramRun, scope: Scope) -> None:
        self._rt = run.rt
        self._cells: dict[str, Cell] = {}
        self.variables: set[Variable] = set()
        for name in (*VALUES, ERROR):
            variable = Variable(name, None, is_global=True)
            self.variables.add(variable)
            variable.assigned = True  # a call that reads it may be shared only until it changes
            scope.bind(Symbol(name), variable)
            self._cells[name] = run.globals[variable] = Cell(None, 0)

    @property
    def value(self) -> Any:
        """The most recent value, ``*1``."""
        return self._cells[VALUES[0]].value

    def remember(self, value: Any) -> None:
        """Store a value in ``*1``, shifting the previous values to ``*2`` and ``*3``."""
        cells = [self._cells[name] for name in VALUES]
        for cell, new_value in zip(cells, [value, *(cell.value for cell in cells[:-1])]):
            self._assign(cell, new_value)

    def remember_error(self, error: SceneError) -> None:
        """Store an error in ``*e``."""
        self._assign(self._cells[ERROR], raised_value(error))

    def _assign(self, cell: Cell, value: Any) -> None:
        """Set a variable, and invalidate all calls if one has read it."""
        if cell.observed:  # a cached call has read it
            self._rt.invalidate_calls()
            cell.observed = False
        cell.value = value


# --- forms of a session: the names that each defines, the form that it replaces, and groups for evaluation ------------


_DEFINING = frozenset(
    ["define", "define-values", "define-record", "define-syntax", "define-macro", "bind", "import", "param", "scene"]
)  # forms that are mutually visible if they are entered together


def source_of(form: TopForm) -> Source:
    """Return the source of a form."""
    return form.datums[0].span.source


def names_of(form: TopForm) -> set[str]:
    """Return the names that a form defines and the words that it binds; words are in quotes."""
    bound = form.scan.record.bound if form.scan is not None and not form.imports else {}
    return {base_name(symbol) for symbol in bound} | {f'"{word}"' for word, _ in form.words}


def fresh(form: TopForm) -> TopForm:
    """Return a copy of a form without the results of its analysis."""
    return TopForm(form.datums, form.read)


def replaces(new: TopForm, old: TopForm, defined: set[str]) -> bool:
    """Return whether the form ``new`` redefines everything that ``old`` defined."""
    if new.scene is not None and old.scene is not None:
        return True
    if new.imports or old.imports:
        return bool(new.imports and old.imports) and _text(new) == _text(old)
    old_names = names_of(old)
    return bool(old_names) and old_names <= defined


def is_assignment(form: TopForm) -> bool:
    """Return whether a form is ``(define name value)``, which can be repeated as ``(set! name value)``."""
    datum = form.datums[0]
    return (
        len(form.datums) == 1
        and isinstance(datum, ListDatum)
        and len(datum.items) == 3
        and datum.items[0].span.text == "define"
        and isinstance(datum.items[1], Atom)
    )


def runs_code(form: TopForm) -> bool:
    """Return whether evaluating a form runs code, unlike definitions of functions, macros and records."""
    return not _begins_with(form, "define-record") and not all(makes_function(tree) for tree in _trees((form,)))


def _begins_with(form: TopForm, name: str) -> bool:
    """Return whether a form is a list whose first item is a name."""
    datum = form.datums[0]
    return isinstance(datum, ListDatum) and bool(datum.items) and datum.items[0].span.text == name


def _trees(forms: Sequence[TopForm]) -> tuple[Any, ...]:
    """Return the core forms of forms, without imports."""
    return tuple(tree for form in forms for tree in form.asts if not isinstance(tree, Import))


def _variables(form: TopForm) -> Iterator[Variable]:
    """Iterate over the variables that a form defines."""
    for tree in _trees((form,)):
        if type(tree) is ast.Define:
            yield from pattern_variables(tree.target)


class _StaleForms(Exception):
    """Raised when forms of a file must be evaluated again.

    A name that they use has another meaning now, or is defined twice.
    """

    def __init__(self, forms: Sequence[TopForm]) -> None:
        super().__init__()
        self.forms = forms


@dataclass(frozen=True, slots=True)
class _Move:
    """Move of a form of an earlier version of a file, from ``start`` to ``end``, to its position in the current one."""

    start: int
    end: int
    source: Source
    offset: int


def _text(form: TopForm) -> str:
    """Return the source text of a form."""
    return " ".join(datum.span.text for datum in form.datums)


def _collected(files: Sequence[SourceFile]) -> tuple[list[Any], set[int]]:
    """Return the core forms of files and of those that they import, and the identities of the files."""
    trees: list[Any] = []
    done: set[int] = set()
    for file in files:
        collect(file, frozenset(), trees, done)
    return trees, done


def makes_function(tree: Any) -> bool:
    """Return whether a core form defines a function or binds a word to one."""
    value = tree.value if type(tree) is ast.Define else tree.function if type(tree) is ast.Bind else None
    return type(value) is ast.Lambda


def groups(forms: Sequence[TopForm]) -> Iterator[list[TopForm]]:
    """Group adjacent definitions of different names; every other form is a group of its own."""
    group: list[TopForm] = []
    names: set[str] = set()
    for form in forms:
        name = _defined_name(form.datums[0])
        if name is None or name in names:
            if group:
                yield group
            group, names = [], set()
        if name is None:
            yield [form]
        else:
            group.append(form)
            names.add(name)
    if group:
        yield group


def _defined_name(datum: Datum) -> str | None:
    """Return the name that a form apparently defines, or None for an expression."""
    if not isinstance(datum, ListDatum) or len(datum.items) < 2:
        return None
    head, target = datum.items[0], datum.items[1]
    if not isinstance(head, Atom) or str(head.value) not in _DEFINING or not isinstance(head.value, Symbol):
        return None
    while isinstance(target, ListDatum) and target.items:
        target = target.items[0]
    return str(target.span.text)


def inserted(forms: Sequence[TopForm], form: TopForm) -> list[TopForm]:
    """Insert a new form into the forms of a session, so that running them in order reproduces its state.

    A function, macro, record or param takes the position of the form that it replaces. The definition of a value is
    appended; an old definition of it is preserved if code ran after it, which may have used the old value. Where code
    used an old function or param, the order reproduces the state except for the values that the code made.
    """
    defined = names_of(form)
    replaced = [i for i, old in enumerate(forms) if replaces(form, old, defined)]
    if is_assignment(form):
        others = [i for i, old in enumerate(forms) if i not in replaced and runs_code(old)]
        replaced = [i for i in replaced if not any(i < other for other in others)]
    remaining = [old for i, old in enumerate(forms) if i not in replaced]
    is_moved = runs_code(form) and not _begins_with(form, "param")  # a program defines a param once
    remaining.insert(replaced[0] if replaced and not is_moved else len(remaining), form)
    return remaining


_NONE: Mapping[str, TopForm] = MappingProxyType({})
_MAX_UPDATES = 10  # updates of dependents after a definition, since their new definitions may have dependents too


@dataclass(frozen=True, slots=True)
class FormResult:
    """Result of evaluating a form. ``value`` is None for a definition."""

    value: Any
    is_expression: bool


class TopLevel:
    """Session of a REPL, to which forms can be added.

    ``forms`` are the forms that reproduce the current state, in order: definitions, and expressions that had side
    effects or drew random numbers.

    Parameters
    ----------
    library
        Standard library.
    runtime
        Runtime with an undo log.
    main
        Source that imports are relative to.
    load
        Function ``load(path, importing source, span)`` that returns an imported file.
    new_macros
        Function that returns the evaluator of macro bodies for the next evaluation.
    overrides
        Datums that replace the defaults of params, by name.
    """

    def __init__(
        self,
        library: Library,
        runtime: JournaledRuntime,
        main: Source,
        load: Callable[[str, Source, Span], Source],
        new_macros: Callable[[], RunMacro],
        overrides: dict[str, Datum],
    ) -> None:
        """Start an empty session."""
        self.rt = runtime
        self.run = ProgramRun(library, runtime)
        self.main = main
        self._new_macros = new_macros
        prelude = prelude_of(library)
        self.state = ProgramState(prelude, load, overrides, new_macros())
        self.file = SourceFile(main, prelude.scope, self.state, is_main=True)
        self.history = History(self.run, self.file.scope)
        self.forms: list[TopForm] = []
        self._random_only: set[int] = set()  # ids of forms whose only lasting effect was a random draw
        self._ran: set[int] = set()  # ids of imported files that have been run
        self._imported_files: list[SourceFile] = []  # keeps the files alive, so that their ids are not reused
        self._moves: dict[int, list[_Move]] = {}  # of forms kept by ``reload``, by the id of their source
        self._calls = SessionCalls(self.run, self.history.variables)
        self.rt.place = self.place
        self._lint = LintCache()  # of the file that was loaded last

    # --- evaluating --------------------------------------------------------------------------------------------

    def evaluate(
        self,
        source: Source,
        on_result: Callable[[FormResult], None],
        warn: Callable[[Diagnostic], None],
        whole: bool = False,
        reused: Mapping[str, TopForm] = _NONE,
    ) -> None:
        """Evaluate the forms of a text.

        Parameters
        ----------
        source
            Text to evaluate.
        on_result
            Callback for the result of each form, called as soon as it is available.
        warn
            Callback for warnings.
        whole
            Whether the text is a complete file, whose definitions are all mutually visible.
        reused
            Forms of the previous version of the file that are not evaluated again, by their text.

        Raises
        ------
        SceneError
            For the first form that fails. Its effects are rolled back; those of the forms before it remain.
        """
        forms = top_forms(source)
        for diagnostic in forms[0].read:
            if diagnostic.is_error:
                raise error_of(diagnostic)
        parsed_forms = [form for form in forms if form.datums]
        self.file.source = source if whole else self.main  # imports are relative to it
        self.state.run_macro = self.file.expander.run_macro = self._new_macros()
        self.file.expander.searches = 0
        if whole:
            self._evaluate_group(*self._split_forms(parsed_forms, source, reused), on_result, warn)
            return
        for group in groups(parsed_forms):
            if len(group) == 1 or self._expands(group):
                self._evaluate_group(group, None, on_result, warn)
            else:
                for form in group:
                    self._evaluate_group([fresh(form)], None, on_result, warn)

    def reload(
        self, source: Source, on_result: Callable[[FormResult], None], warn: Callable[[Diagnostic], None]
    ) -> None:
        """Evaluate the next version of a file, except for unchanged definitions of functions and macros.

        The definitions of its previous version that it no longer contains are removed.

        Parameters
        ----------
        source, on_result, warn
            As for ``evaluate``.

        Raises
        ------
        SceneError
            For the first form that fails, as ``evaluate`` does.
        """
        self.rt.forget_output()
        reused = self._unchanged(source) if self._calls.is_tracked else {}
        if not self._calls.is_tracked:
            self._ran -= self._imported(source.name)
        while True:
            try:
                self.evaluate(source, on_result, warn, whole=True, reused=reused)
                break
            except _StaleForms as signal:
                reused = {text: form for text, form in reused.items() if form not in signal.forms}
        self._forget(self._replace_forms(source))

    def _unchanged(self, source: Source) -> Mapping[str, TopForm]:
        """Return the forms of the previous version of a file that the next version can reuse, by their text."""
        return {
            _text(form): form
            for form in self._latest_forms()
            if source_of(form).name == source.name and not (runs_code(form) or form.imports or form.scene)
        }

    def _imported(self, name: str) -> set[int]:
        """Return the identities of the files that a file imports, directly or through others."""
        imports = [file for form in self.forms if source_of(form).name == name for file in form.imports]
        return _collected(imports)[1]

    def _latest_forms(self) -> list[TopForm]:
        """Return the forms whose definitions are all in effect."""
        latest = {name: form for form in self.forms for name in names_of(form)}
        return [form for form in self.forms if all(latest[name] is form for name in names_of(form))]

    def _expands(self, group: Sequence[TopForm]) -> bool:
        """Return whether forms expand together without errors.

        Otherwise the caller expands them one by one to find the error.
        """
        snapshot = self._snapshot()
        problems = self._add_forms([fresh(form) for form in group])
        self._roll_back(snapshot)
        return not any(d.is_error for d in problems)

    def _evaluate_group(
        self,
        group: Sequence[TopForm],
        unchanged: Sequence[TopForm] | None,
        on_result: Callable[[FormResult], None],
        warn: Callable[[Diagnostic], None],
    ) -> None:
        """Evaluate forms that are mutually visible.

        For a whole file, ``unchanged`` are its other forms, which are not evaluated; for an input, it is None.
        """
        before = self._snapshot()
        try:
            if unchanged is not None:
                self._remove_names(group, unchanged)
            problems = self._add_forms(group)
        except BaseException:  # such as RecursionError: roll back completely
            self._roll_back(before)
            raise
        defined = {name for form in group for name in names_of(form)}
        stale = [form for form in unchanged or () if self._is_stale(form) or not names_of(form).isdisjoint(defined)]
        if unchanged and not stale and not any(d.is_error for d in problems):
            stale = list(unchanged) if self._uses_later_definitions(group, unchanged) else []
        if stale:
            self._roll_back(before)
            raise _StaleForms(stale)
        errors = [d for d in problems if d.is_error]
        if errors:
            self._roll_back(before)
            for diagnostic in errors[:-1]:
                warn(diagnostic)
            raise error_of(errors[-1])
        for diagnostic in self._warnings(group, problems, unchanged):
            warn(diagnostic)
        try:
            with self._undefined([*group, *self._late_imports(group)] if unchanged is not None else ()) as values:
                self._run_group(group, before, on_result, unchanged or (), values)
        finally:
            self._settle(())
        if unchanged is None and any(form.imports for form in group):
            self._forget((), has_imported=True)

    def _uses_later_definitions(self, group: Sequence[TopForm], unchanged: Sequence[TopForm]) -> bool:
        """Return whether code of a file uses a definition in an unchanged form below it."""
        trees = _trees(sorted((*group, *unchanged), key=self._start))
        return uses_later_definitions(list(map(self._calls.reach, trees)), set(map(id, _trees(unchanged))))

    def _late_imports(self, group: Sequence[TopForm]) -> list[TopForm]:
        """Return the forms of files that are imported below code, and mark these files to be run again."""
        code = next((number for number, form in enumerate(group) if runs_code(form) and not form.imports), len(group))
        _, late = _collected([file for form in group[code:] for file in form.imports])
        self._ran -= late
        return [form for file in self._imported_files if id(file) in late for form in file.forms]

    @contextmanager
    def _undefined(self, group: Sequence[TopForm]) -> Iterator[Mapping[Variable, Any]]:
        """Context in which names that forms are about to define have no values; yields their earlier values.

        No form above the definitions can then use values of an earlier version. Names that are still undefined at the
        end get their values back.
        """
        cells = {variable: self.run.globals.get(variable) for form in group for variable in _variables(form)}
        values = {variable: cell.value for variable, cell in cells.items() if cell is not None}
        words = [self.rt.words[word] for form in group for word, _ in form.words if word in self.rt.words]
        functions = [(cell, cell.function) for cell in words]
        try:
            for variable in values:
                self.run.globals[variable].value = UNDEFINED
            for cell in words:
                cell.function = None
            yield values
        finally:
            for variable, value in values.items():
                if self.run.globals[variable].value is UNDEFINED:
                    self.run.globals[variable].value = value
            for cell, function in functions:
                cell.function = function if cell.function is None else cell.function

    def _run_group(
        self,
        group: Sequence[TopForm],
        before: Snapshot,
        on_result: Callable[[FormResult], None],
        unchanged: Sequence[TopForm],
        old: Mapping[Variable, Any],
    ) -> None:
        """Evaluate forms that have been expanded; ``old`` are the values that their variables had before.

        A form that changes anything but its own definitions may affect ``unchanged`` forms below it, so these run too.
        """
        forms, is_tracked = list(group), self._calls.is_tracked
        for number, form in enumerate(forms):
            if runs_code(form):
                self._settle(forms[number:])
            epochs, values = self._calls.epochs, self._plain_values(form, old)
            self.rt.begin()
            ran = set(self._ran)
            try:
                results = self._run_form(form)
            except BaseException:
                self.rt.roll_back()
                self._ran = ran
                self._roll_back_rest(before, forms[:number])
                raise
            imported = [file for file in self._imported_files if id(file) in self._ran - ran]
            new = [form, *(file_form for file in imported for file_form in file.forms)]
            self._calls.is_tracked &= not self.rt.has_written_other(self._defined_cells(new))
            if names_of(form) or form.imports:
                self._note(new, epochs, values)
            self._accept(form)
            for result in results:
                on_result(result)
            if is_tracked and not self._calls.is_tracked:
                is_tracked = False
                start = self._start(form)
                below = [*forms[number + 1 :], *(other for other in unchanged if self._start(other) > start)]
                forms[number + 1 :] = sorted(below, key=self._start)

    def _start(self, form: TopForm) -> int:
        """Return the offset of a form in the current version of its file."""
        return self.place(form.datums[0].span).start

    def _settle(self, coming: Sequence[TopForm]) -> None:
        """Update the dependents of the definitions since the last settlement; ``coming`` forms are about to run."""
        if self._calls.is_settled:
            return
        updated = self._update_dependents()
        self._calls.note(_trees(updated), self._calls.epochs)
        self._calls.settle(list(self._session_forms(coming)))

    def _note(self, forms: Sequence[TopForm], epochs: tuple[int, int], values: Mapping[Variable, Any]) -> None:
        """Record that definitions ran; ``epochs`` and ``values`` are those before."""
        cells = self.run.globals
        if values and all(is_same(value, cells[variable].value) for variable, value in values.items()):
            self._calls.restore(values, epochs)
        else:
            self._calls.note(_trees(forms), epochs)

    def _defined_cells(self, forms: Sequence[TopForm]) -> list[Mutable]:
        """Return the cells of the variables and words that forms define."""
        cells = [self.run.globals.get(variable) for form in forms for variable in _variables(form)]
        words = [self.rt.words[word] for form in forms for word, _ in form.words if word in self.rt.words]
        return [cell for cell in cells if cell is not None] + words

    def _plain_values(self, form: TopForm, old: Mapping[Variable, Any]) -> Mapping[Variable, Any]:
        """Return the values before a definition of its variables, if all are data that can be compared."""
        if not runs_code(form):
            return {}
        values = {}
        for variable in _variables(form):
            cell = self.run.globals.get(variable)
            value = cell.value if cell is not None else UNDEFINED
            values[variable] = old.get(variable, UNDEFINED) if value is UNDEFINED else value
        return values if all(map(is_plain, values.values())) else {}

    def _session_forms(self, coming: Sequence[TopForm]) -> Iterator[SessionForm]:
        """Iterate over the forms in effect; ``coming`` forms are about to run and replace others."""
        names = {name for form in coming for name in names_of(form)}
        latest = set(map(id, self._latest_forms()))
        for form in self.forms:
            trees = _trees((form,))
            is_replaced = id(form) not in latest or (bool(names) and names_of(form) <= names)
            yield SessionForm(trees, id(form) in latest and all(map(makes_function, trees)), is_replaced)
        for file in self._imported_files:
            for tree in _trees(file.forms) if id(file) in self._ran else ():
                yield SessionForm((tree,), type(tree) is ast.Define and makes_function(tree))

    def _run_form(self, form: TopForm) -> list[FormResult]:
        """Run a form, and the files that it imports."""
        results = []
        for tree in form.asts:
            if isinstance(tree, Import):
                self._run_import(tree)
                continue
            is_definition = type(tree) in (ast.Define, ast.Bind)
            results.append(FormResult(self.run.run_form(tree), not is_definition))
        return results

    def _run_import(self, item: Import) -> None:
        """Run an imported file and its imports unless they have been run already."""
        forms: list[Any] = []
        claimed = frozenset(word for form in self.forms for word, _ in form.words)
        collect(item.file, claimed, forms, self._ran)
        for form in forms:
            self.run.run_form(form)

    def _add_forms(self, group: Sequence[TopForm]) -> list[Diagnostic]:
        """Scan and expand forms; imported files are checked for changes."""
        state, file = self.state, self.file
        state.previous_files = {**state.previous_files, **state.files}
        state.files = {file.source.name: file}
        state.loading = [file.source.name]
        file.scene = None
        file.is_incomplete = False
        scene = self._scene()
        file.add_forms(group)
        state.loading = []
        file.scene = file.scene or scene
        problems = [d for form in group for step in (form.scan, form.expansion) if step for d in step.problems]
        for other in state.files.values():
            if other is not file:
                other.finish()
                problems += other.diagnostics()
        self._count_as_assigned(group)
        self._mark_changed_files()
        problems += [d for d in file.problems if d.name != "bound-twice"]
        return [d for d in problems if not (file.is_incomplete and d.name == "unbound")]

    def _scene(self) -> ListDatum | None:
        """Return the ``(scene ...)`` form that was accepted last, which chooses the root; None if there is none."""
        return next((form.scene for form in reversed(self.forms) if form.scene is not None), None)

    def _count_as_assigned(self, group: Sequence[TopForm]) -> None:
        """Mark all global variables as assigned, because a later form may change them."""
        tables = [form.scan.record.bound for form in group if form.scan is not None]
        for file in self.state.files.values():
            tables.append(dict(dict.items(file.names)))
        for table in tables:
            for binding in table.values():
                if isinstance(binding, Variable):
                    binding.assigned = True

    def _mark_changed_files(self) -> None:
        """Mark files to be run again if they import a file whose current version has not been run."""
        self._imported_files += [file for file in self.state.files.values() if file is not self.file]
        changed = True
        while changed:
            changed = False
            for file in self._imported_files:
                if id(file) in self._ran and any(id(imported) not in self._ran for imported in file.imports):
                    self._ran.discard(id(file))
                    changed = True

    # --- session state -----------------------------------------------------------------------------------------

    def _accept(self, form: TopForm) -> None:
        """Add an evaluated form to the session; it replaces forms with the same definitions."""
        defined = names_of(form)
        if not defined and not form.imports and not form.scene:
            if not self.rt.has_changed:
                return
            if not self.rt.has_written and not self._setup_of(form):
                self._random_only.add(id(form))
        forms = inserted(self.forms, form)
        self.forms = self._without_replaced_setup(forms) if self.rt.setups else forms
        self._list_forms()

    def _setup_of(self, *forms: TopForm) -> Setup:
        """Return what forms declare of cameras, lights, ... and no later one of them replaces."""
        return self.rt.setup_of(_trees(forms))

    def _without_replaced_setup(self, forms: Sequence[TopForm]) -> list[TopForm]:
        """Return the forms without those that only declare cameras, lights, ... which later forms replace."""
        latest = set(map(id, self._setup_of(*forms)))
        return [
            form for form in forms
            if names_of(form) or not (stated := self._setup_of(form)) or any(id(item) in latest for item in stated)
        ]  # fmt: skip

    def _update_dependents(self) -> list[TopForm]:
        """Expand and run again the functions that looked up a name whose meaning has changed; return their forms."""
        updated: list[TopForm] = []
        for _ in range(_MAX_UPDATES):
            stale = [form for form in self.forms if self._is_stale(form)]
            if not stale:
                break
            updated += map(self._reevaluate, stale)
        return updated

    def _is_stale(self, form: TopForm) -> bool:
        """Return whether a name that the analysis of a form looked up has another meaning now."""
        find = dict.get
        records: list[LookupRecord] = [step.record for step in (form.scan, form.expansion) if step is not None]
        defined = {symbol for record in records for symbol in record.bound}
        return not form.imports and any(
            find(self.file.names, symbol) is not binding
            for record in records
            for symbol, binding in record.lookups.items()
            if symbol not in defined
        )

    def _reevaluate(self, form: TopForm) -> TopForm:
        """Expand and run a stale form again; if it no longer expands, its old definitions remain."""
        new_form = fresh(form)
        snapshot = self._snapshot()
        problems = self._add_forms([new_form])
        if any(d.is_error for d in problems):
            self._roll_back(snapshot)
            for step in (form.scan, form.expansion):
                if step is not None:
                    step.record.lookups = {s: dict.get(self.file.names, s) for s in step.record.lookups}
            return form
        self.forms[self.forms.index(form)] = new_form
        for tree in _trees((new_form,)):
            if makes_function(tree) and self._is_latest(new_form):
                self.run.run_form(tree)
        return new_form

    def _is_latest(self, form: TopForm) -> bool:
        """Return whether all definitions of a form are in effect."""
        return all(self.definition_of(name) is form for name in names_of(form))

    def _snapshot(self) -> Snapshot:
        """Return a snapshot of the session's names."""
        return snapshot_of(self.file, self._ran)

    def _roll_back(self, snapshot: Snapshot) -> None:
        """Restore the session's names."""
        roll_back(self.file, snapshot)
        self._ran = set(snapshot.ran)

    def _roll_back_rest(self, before: Snapshot, done: Sequence[TopForm]) -> None:
        """Roll back a group that failed partway, except for the names of its completed forms."""
        ran = set(self._ran)
        words = dict(self.file.words)
        self._roll_back(before)
        for form in done:
            if form.scan is not None:
                self.file.names.replay(form.scan.record.bound)
            self.file.expander.record_names |= form.records
        self._ran = ran
        if done:
            self.file.words = words
            self.state.params = [param for form in self.forms for param in form.params]

    # --- reloading ---------------------------------------------------------------------------------------------

    def _split_forms(
        self, forms: Sequence[TopForm], source: Source, reused: Mapping[str, TopForm]
    ) -> tuple[list[TopForm], list[TopForm]]:
        """Separate the forms of a file into those to evaluate and those of ``reused``, whose positions are updated.

        A form is evaluated if another one defines the same name, since the last definition of a name counts.
        """
        names = Counter(_defined_name(form.datums[0]) for form in forms if form.datums[0].span.text[1:6] != "scene")
        new, unchanged = [], []
        self._moves = {key: moves for key, moves in self._moves.items() if moves[0].source.name != source.name}
        for form in forms:
            name, old = _defined_name(form.datums[0]), reused.get(_text(form))
            if old is None or name is None or names[name] > 1:
                new.append(form)
                continue
            unchanged.append(old)
            span = old.datums[0].span
            move = _Move(span.start, span.end, source, form.datums[0].span.start - span.start)
            self._moves.setdefault(id(source_of(old)), []).append(move)
        for moves in self._moves.values():
            moves.sort(key=lambda move: move.start)
        return new, unchanged

    def _remove_names(self, group: Sequence[TopForm], unchanged: Sequence[TopForm]) -> None:
        """Remove the names that the last version of a file defined, unless its next version apparently does."""
        file_name, unchanged_ids = self.file.source.name, set(map(id, unchanged))
        remaining = {_defined_name(form.datums[0]) for form in group}
        remaining |= {name for form in unchanged for name in names_of(form)}
        for form in self.forms:
            if source_of(form).name == file_name and form.scan is not None and id(form) not in unchanged_ids:
                for symbol in form.scan.record.bound:
                    if base_name(symbol) not in remaining:
                        dict.pop(self.file.names, symbol, None)

    def place(self, span: Span) -> Span:
        """Convert a span in a form of an earlier version of a file to the version that was loaded last."""
        return moved_span(span, self._move)

    def place_error(self, error: SceneError) -> None:
        """Convert the spans of an error as ``place`` does."""
        moved = moved_diagnostic(error.diagnostic, self.place)
        error.span, error.notes, error.chain = moved.span, moved.notes, list(moved.chain)

    def comment_of(self, form: TopForm) -> list[str]:
        """Return the comment lines directly above a form."""
        span = self.place(form.datums[0].span)
        return comment_above(span.source, span.start)

    def _move(self, span: Span) -> tuple[Source, int]:
        """Return the source and the offset to which a span of an unchanged form moves."""
        moves = self._moves.get(id(span.source), [])
        index = bisect_right(moves, span.start, key=lambda move: move.start) - 1
        if index < 0 or span.end > moves[index].end:
            return span.source, 0
        return moves[index].source, moves[index].offset

    def _replace_forms(self, source: Source) -> list[TopForm]:
        """Sort the forms of a file by their order in its text; remove and return those of its earlier versions."""
        current: dict[int, TopForm] = {}  # by their offsets in the text
        old: list[TopForm] = []
        others: list[TopForm] = []
        position = 0  # number of the other forms that come before those of the file
        for form in self.forms:
            span = self.place(form.datums[0].span)
            if span.source.name != source.name:
                others.append(form)
            elif span.source is source:
                position = position if current else len(others)
                current[span.start] = form
            else:
                old.append(form)
        sorted_forms = [current[start] for start in sorted(current)]
        self.forms = [*others[:position], *sorted_forms, *others[position:]]
        self._list_forms()
        return old

    def _forget(self, old: Sequence[TopForm], *, has_imported: bool = False) -> None:
        """Remove the definitions and words of removed forms and imports, unless other forms define the same ones.

        If files were imported again (``has_imported``), their words are bound again, because another file may bind them
        now.
        """
        remaining = {name for form in self.forms for name in names_of(form)}
        for form in old:
            for symbol in list(form.scan.record.bound if form.scan is not None else ()):
                if base_name(symbol) not in remaining:
                    dict.pop(self.file.names, symbol, None)
        trees, current = _collected(self.file.imports)
        imported = {bound_word(tree): tree for tree in trees}
        earlier = {word for file in self._imported_files if id(file) not in current for word in file.words}
        old_words = {word for form in old for word, _ in form.words}
        unbound = old_words.union(*(file.words for file in self._imported_files)) - self.file.words.keys()
        for word in unbound & self.rt.words.keys():
            if word not in imported:
                self.rt.words[word].function = None
            elif word in old_words or (has_imported and word in earlier):
                self.run.run_form(imported[word])
        if any(form.imports or not names_of(form) <= remaining for form in old) or unbound - imported.keys():
            self.rt.invalidate_calls()

    def _list_forms(self) -> None:
        """Update the file's lists of words, imports and params from the forms of the session."""
        file = self.file
        file.forms = self.forms
        file.words = {word: span for form in self.forms for word, span in form.words}
        file.imports = [imported for form in self.forms for imported in form.imports]
        self.state.params = [param for form in self.forms for param in form.params]

    # --- queries -----------------------------------------------------------------------------------------------

    def persistent_forms(self) -> list[TopForm]:
        """Return ``forms`` without those that only drew random numbers that had no effect on later forms."""
        persistent: list[TopForm] = []
        is_followed_by_code = False
        for form in reversed(self.forms):
            if id(form) not in self._random_only or is_followed_by_code:
                persistent.append(form)
                is_followed_by_code = is_followed_by_code or runs_code(form)
        return persistent[::-1]

    def program(self) -> Program:
        """Return the session as a program."""
        file = self.file
        file.scene = self._scene()
        file.problems = []
        self.state.files = {part.source.name: part for part in [file, *file.imports]}
        return assemble_program(file, file.finish_scene())

    def run_root(self, program: Program, word: str, seed: int) -> Scene:
        """Evaluate the root ``word`` as a run of the program would; the random streams are restored afterwards."""
        streams = self.rt.streams.snapshot()
        self.rt.begin()
        try:
            return self.run.run_root(program, word, seed)
        except BaseException:
            self.rt.roll_back()
            raise
        finally:
            self._calls.is_tracked &= not self.rt.has_written
            self.rt.streams.restore(streams)

    def expansion(self, source: Source) -> list[Any]:
        """Return the core AST of the forms of a text without changing the session; raise ``SceneError`` on errors."""
        result = read(source)
        for diagnostic in result.diagnostics:
            raise error_of(diagnostic)
        snapshot = self._snapshot()
        forms = [TopForm((datum,)) for datum in result.forms]
        try:
            for diagnostic in self._add_forms(forms):
                if diagnostic.is_error:
                    raise error_of(diagnostic)
        finally:
            self._roll_back(snapshot)
        return list(_trees(forms))

    def names(self) -> Iterator[tuple[str, Any]]:
        """Iterate over the names defined or imported by the session, with their bindings."""
        for symbol, binding in dict.items(self.file.names):
            yield base_name(symbol), binding

    def value_of(self, name: str) -> Any:
        """Return the value of a variable; raise ``KeyError`` if the name is not bound to one."""
        binding = dict.get(self.file.names, Symbol(name))
        if not isinstance(binding, Variable) or binding not in self.run.globals:
            raise KeyError(name)
        return self.run.globals[binding].value

    def definition_of(self, name: str) -> TopForm | None:
        """Return the form that defines a name or binds a word, in the session or its imports, or None."""
        files = [file for file in self._imported_files if id(file) in self._ran]
        for forms in (self.forms, *(file.forms for file in reversed(files))):
            for form in reversed(forms):
                if name in names_of(form):
                    return form
        return None

    def _warnings(
        self, group: Sequence[TopForm], problems: Sequence[Diagnostic], unchanged: Sequence[TopForm] | None
    ) -> list[Diagnostic]:
        """Return the warnings about new forms; for a whole file, those about ``unchanged`` forms too."""
        forms = [*(unchanged or ()), *group]
        steps = [step for form in unchanged or () for step in (form.scan, form.expansion) if step is not None]
        problems = [*(problem for step in steps for problem in step.problems), *problems]
        trees, cache = _trees(forms), LintCache() if unchanged is None else self._lint
        words = {**{word: span for form in self.forms for word, span in form.words}, **self.file.words}
        imported = {word: span for file in self.state.files.values() for word, span in file.words.items()}
        warnings = [*problems, *new_form_warnings(self.main, trees, words, {**imported, **words}, cache)]
        return [d for d in warnings if unchanged is not None or d.name not in WHOLE_FILE]
