"""Versions of one program while it is being edited: only what an edit may have changed is looked at again.

The main file is cut into its top-level pieces (``grammar.chunks``). A piece whose text stood in the last version keeps
its datums; its scan and expansion are kept while every name that they looked up means the same (``ledger``). So places
inside a piece are relative to it; ``Version.place`` gives those of the whole text. The result is what an analysis from
scratch gives.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

from scenelang.grammar.chunks import Chunk, split_again
from scenelang.grammar.diagnostics import Diagnostic, Note
from scenelang.grammar.reader import read
from scenelang.grammar.source import Expansion, Source, Span
from scenelang.interpreter.expand import RunMacro
from scenelang.interpreter.files import ProgramState, SourceFile
from scenelang.interpreter.lint.facts import FactBook
from scenelang.interpreter.prelude import Prelude
from scenelang.interpreter.program import Program, finish_program
from scenelang.interpreter.top_forms import TopForm


@dataclass(frozen=True, slots=True, eq=False)
class Piece:
    """A piece of the text and the form that it is; ``source`` holds only its text, with blanks for its column."""

    text: str
    source: Source
    form: TopForm


@dataclass(frozen=True, slots=True, eq=False)
class Version:
    """One version of the text, analysed. ``pieces`` come with where the text of their sources begins."""

    source: Source
    pieces: tuple[tuple[int, Piece], ...]
    program: Program
    file: SourceFile
    offsets: Mapping[int, int]

    def place(self, span: Span) -> Span:
        """A span in the whole text, or in another file as it was."""
        expansion = span.expansion
        if expansion is not None:
            definition = expansion.definition
            outer = Span(span.source, span.start, span.end, expansion.outer)
            moved = None if definition is None else self.place(definition)
            expansion = Expansion(expansion.macro, moved, self.place(outer).expansion)
        offset = self.offsets.get(id(span.source))
        if offset is None:
            return Span(span.source, span.start, span.end, expansion)
        return Span(self.source, span.start + offset, span.end + offset, expansion)

    def diagnostic(self, diagnostic: Diagnostic) -> Diagnostic:
        """A diagnostic with places in the whole text."""
        if diagnostic.span is None and not diagnostic.notes:
            return diagnostic
        notes = tuple(Note(note.message, note.span and self.place(note.span)) for note in diagnostic.notes)
        fixes = tuple(
            replace(fix, edits=tuple(replace(edit, span=self.place(edit.span)) for edit in fix.edits))
            for fix in diagnostic.fixes
        )
        return replace(diagnostic, span=diagnostic.span and self.place(diagnostic.span), notes=notes, fixes=fixes)


class Versions:
    """The versions of one main file, one after the other."""

    def __init__(self, prelude: Prelude) -> None:
        self._prelude = prelude
        self._text = ""
        self._chunks: tuple[Chunk, ...] = ()
        self._pieces: tuple[tuple[int, Piece], ...] = ()
        self._state: ProgramState | None = None
        self._file: SourceFile | None = None
        self._book = FactBook()

    def analyse(self, source: Source, load: Callable[[str, Source, Span], Source], run_macro: RunMacro) -> Version:
        """The next version. ``load`` and ``run_macro`` are those of ``load_program``."""
        kept = self._state.files if self._state is not None else {}
        state = ProgramState(self._prelude, load, {}, run_macro, kept=kept, book=self._book, keeps_uses=True)
        file = self._file
        if file is None or file.source.name != source.name:
            file = SourceFile(source, self._prelude.scope, state, is_main=True)
        file.source, file.state, file.expander.run_macro = source, state, run_macro
        self._chunks = chunks = split_again(source.text, self._text, self._chunks)
        self._text = source.text
        self._pieces = pieces = self._next_pieces(source, chunks)
        file.forms = [piece.form for _, piece in pieces]
        self._state, self._file = state, file
        offsets = {id(piece.source): start for start, piece in pieces}
        return Version(source, pieces, finish_program(file), file, offsets)

    def _next_pieces(self, source: Source, chunks: Sequence[Chunk]) -> tuple[tuple[int, Piece], ...]:
        """The pieces of a text; one whose text stood in the last version, at the same column, is taken from there."""
        known: defaultdict[str, list[Piece]] = defaultdict(list)
        for _, piece in reversed(self._pieces):
            known[piece.text].append(piece)
        found = []
        for chunk in chunks:
            text = " " * chunk.column + chunk.text
            found.append((chunk.start - chunk.column, known[text].pop() if known[text] else _piece(source.name, text)))
        return tuple(found)


def _piece(name: str, text: str) -> Piece:
    source = Source(name, text)
    result = read(source)
    return Piece(text, source, TopForm(result.forms, result.diagnostics))
