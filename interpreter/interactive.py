"""A top level that goes on: forms are read, expanded and run one after another, and names may be defined anew.

A form either does all that it says or nothing: what a failing form has bound or changed is taken back. All global
variables count as assigned, so that a shared call that read one holds only until it changes. When a name comes to mean
something else than a variable's new value (a macro, a record, a name of the library), the functions whose expansion
looked it up are expanded and made anew.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from scenelang.grammar import ast
from scenelang.grammar.datum import Datum, ListDatum, Symbol
from scenelang.grammar.diagnostics import Diagnostic, SceneError
from scenelang.grammar.reader import read
from scenelang.grammar.source import Source, Span
from scenelang.interpreter.entity import Scene
from scenelang.interpreter.evaluate import Run
from scenelang.interpreter.expand import RunMacro
from scenelang.interpreter.files import ProgramState, SourceFile
from scenelang.interpreter.journal import JournaledRuntime
from scenelang.interpreter.latest import Latest
from scenelang.interpreter.ledger import Record
from scenelang.interpreter.library import Library
from scenelang.interpreter.lint.interactive import WHOLE_FILE, new_form_warnings
from scenelang.interpreter.marks import Mark, go_back, mark_of
from scenelang.interpreter.prelude import prelude_of
from scenelang.interpreter.program import Program, assembled, collect
from scenelang.interpreter.replacing import (
    computes,
    fresh,
    groups,
    makes_function,
    names_of,
    placed,
    source_of,
)
from scenelang.interpreter.scope import Variable, base_name
from scenelang.interpreter.top_forms import Import, TopForm, top_forms

_MOST_ROUNDS = 10


@dataclass(frozen=True, slots=True)
class Given:
    """What one form came to. ``value`` is None for a definition."""

    value: Any
    is_expression: bool


class TopLevel:
    """``load(path, importing source, span)`` finds an imported file; ``new_macros`` gives what runs macros' bodies in
    the next evaluation; ``overrides`` are the datums of params. ``forms`` are those that made what there is now, in
    order: definitions, and expressions that changed something or drew a random number."""

    def __init__(
        self,
        library: Library,
        runtime: JournaledRuntime,
        main: Source,
        load: Callable[[str, Source, Span], Source],
        new_macros: Callable[[], RunMacro],
        overrides: dict[str, Datum],
    ) -> None:
        self.rt = runtime
        self.run = Run(library, runtime)
        self.main = main
        self._new_macros = new_macros
        prelude = prelude_of(library)
        self.state = ProgramState(prelude, load, overrides, new_macros())
        self.file = SourceFile(main, prelude.scope, self.state, is_main=True)
        self.latest = Latest(self.run, self.file.scope)
        self.forms: list[TopForm] = []
        self._drew: set[int] = set()  # forms, by id, that drew random numbers and did nothing else that stays
        self._ran: set[int] = set()  # imported files, by id
        self._known: list[SourceFile] = []  # so that ids stay theirs

    # --- evaluating --------------------------------------------------------------------------------------------

    def evaluate(
        self, source: Source, give: Callable[[Given], None], warn: Callable[[Diagnostic], None], whole: bool = False
    ) -> None:
        """Evaluate the forms of a text; ``give`` gets each form's value as soon as it is there.

        ``whole``: the text is a file, all of whose definitions see one another. Raises SceneError for the first form
        that fails; those before it have been evaluated, and it has left nothing behind.
        """
        forms = top_forms(source)
        for diagnostic in forms[0].read:
            if diagnostic.is_error:
                raise error_of(diagnostic)
        given_forms = [form for form in forms if form.datums]
        self.file.source = source if whole else self.main  # where imports are looked for
        self.state.run_macro = self.file.expander.run_macro = self._new_macros()
        self.file.expander.searches = 0
        batches = [given_forms] if whole else list(groups(given_forms))
        for group in batches:
            if len(group) == 1 or whole or self._expands(group):
                self._evaluate_group(group, give, warn, whole)
            else:
                for form in group:
                    self._evaluate_group([fresh(form)], give, warn, whole)

    def _expands(self, group: Sequence[TopForm]) -> bool:
        """Whether forms can be taken in together; otherwise the first one at fault is to be found."""
        mark = self._mark()
        problems = self._take_in([fresh(form) for form in group])
        self._go_back(mark)
        return not any(d.is_error for d in problems)

    def _evaluate_group(
        self, group: Sequence[TopForm], give: Callable[[Given], None], warn: Callable[[Diagnostic], None], whole: bool
    ) -> None:
        before = self._mark()
        try:
            problems = self._take_in(group)
        except BaseException:  # such as a recursion too deep: nothing of it may stay
            self._go_back(before)
            raise
        errors = [d for d in problems if d.is_error]
        if errors:
            self._go_back(before)
            for diagnostic in errors[:-1]:
                warn(diagnostic)
            raise error_of(errors[-1])
        for diagnostic in self._warnings(group, problems, whole):
            warn(diagnostic)
        self._run_group(group, before, give)

    def _run_group(self, group: Sequence[TopForm], before: Mark, give: Callable[[Given], None]) -> None:
        for number, form in enumerate(group):
            self.rt.begin()
            ran = set(self._ran)
            try:
                given = self._run_form(form)
            except BaseException:
                self.rt.take_back()
                self._ran = ran
                self._keep_only(before, group[:number])
                raise
            self._accept(form, before)
            for each in given:
                give(each)

    def _run_form(self, form: TopForm) -> list[Given]:
        given = []
        for tree in form.asts:
            if isinstance(tree, Import):
                self._run_import(tree)
                continue
            is_definition = type(tree) in (ast.Define, ast.Bind)
            given.append(Given(self.run.run_form(tree), not is_definition))
        return given

    def _run_import(self, item: Import) -> None:
        """Run an imported file and its imports, if they are new or have changed."""
        forms: list[Any] = []
        claimed = frozenset(word for form in self.forms for word, _ in form.words)
        collect(item.file, claimed, forms, self._ran)
        for form in forms:
            self.run.run_form(form)

    def _take_in(self, group: Sequence[TopForm]) -> list[Diagnostic]:
        """Scan and expand forms; imported files are looked at again."""
        state, file = self.state, self.file
        state.kept = {**state.kept, **state.files}
        state.files = {file.source.name: file}
        state.loading = [file.source.name]
        file.scene = None
        file.is_incomplete = False
        scene = self._scene()
        file.take_in(group)
        state.loading = []
        file.scene = file.scene or scene
        found = [d for form in group for step in (form.scan, form.expansion) if step for d in step.problems]
        for each in state.files.values():
            if each is not file:
                each.finish()
                found += each.diagnostics()
        self._count_as_assigned(group)
        self._note_changed_files()
        found += [d for d in file.problems if d.name != "bound-twice"]
        return [d for d in found if not (file.is_incomplete and d.name == "unbound")]

    def _scene(self) -> ListDatum | None:
        return next((form.scene for form in reversed(self.forms) if form.scene is not None), None)

    def _count_as_assigned(self, group: Sequence[TopForm]) -> None:
        """Whatever is global may change here, by a later form."""
        tables = [form.scan.record.bound for form in group if form.scan is not None]
        for file in self.state.files.values():
            tables.append(dict(dict.items(file.names)))
        for table in tables:
            for binding in table.values():
                if isinstance(binding, Variable):
                    binding.assigned = True

    def _note_changed_files(self) -> None:
        """A file that imports one that has not run in this version must run again too."""
        self._known += [file for file in self.state.files.values() if file is not self.file]
        changed = True
        while changed:
            changed = False
            for file in self._known:
                if id(file) in self._ran and any(id(each) not in self._ran for each in file.imports):
                    self._ran.discard(id(file))
                    changed = True

    # --- what is kept ------------------------------------------------------------------------------------------

    def _accept(self, form: TopForm, before: Mark) -> None:
        """A form was evaluated: it replaces those that defined the same, and what depends on it is made anew."""
        defined = names_of(form)
        if not defined and not form.imports and not form.scene:
            if not self.rt.has_changed:
                return
            if not self.rt.has_written:
                self._drew.add(id(form))
        self.forms = placed(self.forms, form)
        file = self.file
        file.forms = self.forms
        file.words = {word: span for each in self.forms for word, span in each.words}
        file.imports = [each for old in self.forms for each in old.imports]
        self.state.params = [param for each in self.forms for param in each.params]
        if defined or form.imports:
            self.rt.forget_calls()
            self._make_anew(before)

    def _make_anew(self, before: Mark) -> None:
        """Expand and run again the functions that looked up a name which now means something else."""
        for _ in range(_MOST_ROUNDS):
            stale = [form for form in self.forms if self._is_stale(form)]
            for form in stale:
                self._remake(form)
            if not stale:
                return

    def _is_stale(self, form: TopForm) -> bool:
        find = dict.get
        records: list[Record] = [step.record for step in (form.scan, form.expansion) if step is not None]
        own = {symbol for record in records for symbol in record.bound}
        return not form.imports and any(
            find(self.file.names, symbol) is not found
            for record in records
            for symbol, found in record.seen.items()
            if symbol not in own
        )

    def _remake(self, form: TopForm) -> None:
        """A form that does not expand any more keeps what it made."""
        again = fresh(form)
        mark = self._mark()
        problems = self._take_in([again])
        if any(d.is_error for d in problems):
            self._go_back(mark)
            for step in (form.scan, form.expansion):
                if step is not None:
                    step.record.seen = {s: dict.get(self.file.names, s) for s in step.record.seen}
            return
        self.forms[self.forms.index(form)] = again
        for tree in again.asts:
            if not isinstance(tree, Import) and makes_function(tree) and self._is_latest(again):
                self.run.run_form(tree)

    def _is_latest(self, form: TopForm) -> bool:
        return all(self.definition_of(name) is form for name in names_of(form))

    def _mark(self) -> Mark:
        return mark_of(self.file, self._ran)

    def _go_back(self, mark: Mark) -> None:
        go_back(self.file, mark)
        self._ran = set(mark.ran)

    def _keep_only(self, before: Mark, done: Sequence[TopForm]) -> None:
        """Of a group whose rest failed, keep the names of the forms that are done."""
        ran = set(self._ran)
        words = dict(self.file.words)
        self._go_back(before)
        for form in done:
            if form.scan is not None:
                self.file.names.replay(form.scan.record.bound)
            self.file.expander.record_names |= form.records
        self._ran = ran
        if done:
            self.file.words = words
            self.state.params = [param for each in self.forms for param in each.params]

    def forget_versions(self, source: Source) -> None:
        """Forget what other versions of a file defined and the version ``source`` does not."""
        old = [form for form in self.forms if source_of(form).name == source.name and source_of(form) is not source]
        self.forms = self.file.forms = [form for form in self.forms if form not in old]
        kept = {name for form in self.forms for name in names_of(form)}
        for form in old:
            for symbol in list(form.scan.record.bound if form.scan is not None else ()):
                if base_name(symbol) not in kept:
                    dict.pop(self.file.names, symbol, None)
            for word, _ in form.words:
                if f'"{word}"' not in kept:
                    self.rt.words[word].function = None
        self.file.words = {word: span for form in self.forms for word, span in form.words}
        self.rt.forget_calls()

    # --- for whoever looks at it -------------------------------------------------------------------------------

    def lasting_forms(self) -> list[TopForm]:
        """``forms`` without those that only drew random numbers after which nothing was computed."""
        found: list[TopForm] = []
        matters = False
        for form in reversed(self.forms):
            if id(form) not in self._drew or matters:
                found.append(form)
                matters = matters or computes(form)
        return found[::-1]

    def program(self) -> Program:
        """All that makes what there is now, as a program."""
        file = self.file
        file.scene = self._scene()
        file.problems = []
        self.state.files = {each.source.name: each for each in [file, *file.imports]}
        return assembled(file, file.finish_scene())

    def run_root(self, program: Program, word: str, seed: int) -> Scene:
        """The scene of the root ``word``, as a run of the program makes it; the random streams go on afterwards."""
        streams = self.rt.streams.snapshot()
        self.rt.begin()
        try:
            return self.run.run_root(program, word, seed)
        except BaseException:
            self.rt.take_back()
            raise
        finally:
            self.rt.streams.restore(streams)

    def expansion(self, source: Source) -> list[Any]:
        """The core AST of the forms of a text, of which nothing stays. Raises SceneError."""
        result = read(source)
        for diagnostic in result.diagnostics:
            raise error_of(diagnostic)
        mark = self._mark()
        forms = [TopForm((datum,)) for datum in result.forms]
        try:
            for diagnostic in self._take_in(forms):
                if diagnostic.is_error:
                    raise error_of(diagnostic)
        finally:
            self._go_back(mark)
        return [tree for form in forms for tree in form.asts if not isinstance(tree, Import)]

    def names(self) -> Iterator[tuple[str, Any]]:
        """The names that the session defined or imported, with their bindings."""
        for symbol, binding in dict.items(self.file.names):
            yield base_name(symbol), binding

    def value_of(self, name: str) -> Any:
        """The value of a name that is bound to a variable; raises KeyError."""
        binding = dict.get(self.file.names, Symbol(name))
        if not isinstance(binding, Variable) or binding not in self.run.globals:
            raise KeyError(name)
        return self.run.globals[binding].value

    def definition_of(self, name: str) -> TopForm | None:
        """The form that defines a name or binds a word, in the session or in what it imports."""
        files = [file for file in self._known if id(file) in self._ran]
        for forms in (self.forms, *(file.forms for file in reversed(files))):
            for form in reversed(forms):
                if name in names_of(form):
                    return form
        return None

    def _warnings(self, group: Sequence[TopForm], problems: Sequence[Diagnostic], whole: bool) -> list[Diagnostic]:
        trees = tuple(tree for form in group for tree in form.asts if not isinstance(tree, Import))
        words = {**{word: span for form in self.forms for word, span in form.words}, **self.file.words}
        imported = {word: span for file in self.state.files.values() for word, span in file.words.items()}
        found = [*problems, *new_form_warnings(self.main, trees, words, {**imported, **words})]
        return [d for d in found if whole or d.name not in WHOLE_FILE]


def error_of(diagnostic: Diagnostic) -> SceneError:
    """A diagnostic as an error again."""
    return SceneError(
        diagnostic.name, diagnostic.message, diagnostic.hint, diagnostic.span, diagnostic.notes, list(diagnostic.chain),
        fixes=diagnostic.fixes,
    )  # fmt: skip
