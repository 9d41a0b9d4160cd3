"""Programs: the files that one holds, and their core AST in running order."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from scenelang.grammar import ast
from scenelang.grammar.datum import Datum
from scenelang.grammar.diagnostics import Diagnostic, suggest
from scenelang.grammar.source import Source, Span
from scenelang.interpreter.expand import RunMacro
from scenelang.interpreter.files import ProgramState, SourceFile
from scenelang.interpreter.library import Library
from scenelang.interpreter.lint.facts import FactBook, Facts
from scenelang.interpreter.params import Param
from scenelang.interpreter.prelude import prelude_of
from scenelang.interpreter.top_forms import Import, TopForm, top_forms


@dataclass(frozen=True, eq=False)
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
    book: FactBook

    @cached_property
    def facts(self) -> list[Facts]:
        """What lints know of each of ``forms``."""
        return self.book.of(self.forms)

    @property
    def ok(self) -> bool:
        return not any(d.is_error for d in self.diagnostics)


def load_program(
    main: Source,
    library: Library,
    load: Callable[[str, Source, Span], Source],
    run_macro: RunMacro,
    overrides: Mapping[str, Any] | None = None,
    datums: Sequence[Datum] | None = None,
) -> Program:
    """Read, expand and parse ``main`` and all that it imports. Never raises for a mistake in a program.

    ``load(path, importing source, span)`` finds an imported file or raises SceneError; ``overrides`` maps names of
    params to datums; ``datums`` are the main file's forms when it is written in something else.
    """
    state = ProgramState(prelude_of(library), load, dict(overrides or {}), run_macro)
    file = SourceFile(main, state.prelude.scope, state, is_main=True)
    file.forms = top_forms(main) if datums is None else [TopForm((datum,)) for datum in datums]
    return finish_program(file)


def finish_program(file: SourceFile) -> Program:
    """The program of a main file whose forms are known."""
    state = file.state
    assert state is not None
    state.files[file.source.name] = file
    state.loading.append(file.source.name)
    file.scan()
    state.loading.pop()
    for each in list(state.files.values()):
        each.finish()
    return assembled(file, file.finish_scene())


def assembled(file: SourceFile, scene: ast.Call | None) -> Program:
    """The program of a main file that is expanded, with all that it imports."""
    state = file.state
    assert state is not None
    files = _in_order(file)
    diagnostics = [d for each in files for d in each.diagnostics()]
    for name in state.overrides.keys() - {param.name for param in state.params}:
        hint = suggest(name, (p.name for p in state.params)) or _known_params(state.params)
        diagnostics.append(Diagnostic("param", f"the program has no `param` named `{name}`", None, hint))
    forms: list[Any] = []
    collect(file, frozenset(), forms, set())
    all_words = {word: span for each in reversed(files) for word, span in each.words.items()}
    return Program(
        file.source, tuple(each.source for each in files), tuple(forms), scene, dict(file.words), all_words,
        tuple(state.params), tuple(diagnostics), state.book,
    )  # fmt: skip


def _known_params(params: Sequence[Param]) -> str | None:
    return "it has " + ", ".join(f"`{p.name}`" for p in params) if params else None


def _in_order(file: SourceFile) -> list[SourceFile]:
    """The files of a program, each before those that it imports."""
    found: dict[int, SourceFile] = {}
    stack = [file]
    while stack:
        each = stack.pop()
        if id(each) not in found:
            found[id(each)] = each
            stack.extend(reversed(each.imports))
    return list(found.values())


def collect(file: SourceFile, claimed: frozenset[str], forms: list[Any], done: set[int]) -> None:
    """Forms in running order. A word that an importing file binds belongs to it: the imported binding is left out.
    ``done``: files, by id, that have run already."""
    if id(file) in done:
        return
    done.add(id(file))
    for form in file.asts():
        if isinstance(form, Import):
            collect(form.file, claimed | file.words.keys(), forms, done)
        elif type(form) is not ast.Bind or type(form.word) is not ast.Constant or form.word.value not in claimed:
            forms.append(form)
