"""What the identifiers and words of a version mean, and where else they stand."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any

from scenelang.grammar import ast
from scenelang.grammar.datum import Atom, Datum, Keyword, ListDatum, Symbol, walk
from scenelang.grammar.source import Span
from scenelang.interpreter.analyse import pattern_variables
from scenelang.interpreter.expand import Use
from scenelang.interpreter.incremental import Piece, Version
from scenelang.interpreter.library import STD
from scenelang.interpreter.scope import Macro, PaperForm, Variable
from scenelang.interpreter.top_forms import TopForm

_TAKES_WORD = frozenset(("call", "bind", "retrieve", "bound?", "scene", "primitive"))
_LIBRARY = Path(__file__).parents[2]


@dataclass(frozen=True, slots=True)
class Word:
    """A string that stands for a word; ``defines``: it is bound there. One in a list may be something else: it is
    ``sure`` where a form takes a word."""

    span: Span
    text: str
    defines: bool = False
    sure: bool = True


@dataclass(frozen=True, eq=False)
class Names:
    """The names of one version. Places are in the whole text, or in other files. ``known`` are definitions of an
    earlier version, for what does not read in this one."""

    version: Version
    known: Mapping[Any, Any] = field(default_factory=dict)

    def piece_at(self, offset: int) -> tuple[int, Piece] | None:
        """The piece that holds an offset, its end included, with where its source begins."""
        low, high = 0, len(self.version.pieces)
        while low < high:
            middle = (low + high) // 2
            start, piece = self.version.pieces[middle]
            if start + len(piece.text) < offset:
                low = middle + 1
            else:
                high = middle
        if low == len(self.version.pieces):
            return None
        start, piece = self.version.pieces[low]
        return (start, piece) if start <= offset else None

    def use_at(self, offset: int) -> Use | None:
        """The identifier at an offset, or just before it, with its place in the whole text."""
        found = self.piece_at(offset)
        if found is None:
            return None
        start, piece = found
        best: Use | None = None
        for use in uses_of(piece.form):
            if use.span.source is piece.source and use.span.start + start <= offset <= use.span.end + start:
                if (
                    best is None
                    or getattr(use.binding, "name", None) == piece.source.text[use.span.start : use.span.end]
                ):
                    best = use  # of the names that a record makes, the one that stands there
        return best and Use(self.version.place(best.span), best.binding, best.defines)

    def word_at(self, offset: int) -> Word | None:
        """The word of the program whose string stands at an offset."""
        found = self.piece_at(offset)
        if found is None:
            return None
        start, piece = found
        for word in words_of(piece.form.datums):
            if word.span.start + start <= offset <= word.span.end + start:
                if word.sure or word.text in self.version.program.all_words:
                    return replace(word, span=self.version.place(word.span))
        return None

    def attribute_at(self, offset: int) -> tuple[Span, str, str] | None:
        """The attribute of a call at an offset: where it stands, the word that is called, its name."""
        found = self.piece_at(offset)
        start, piece = found if found is not None else (0, None)
        for datum in walk(*piece.form.datums) if piece is not None else ():
            items = datum.items if isinstance(datum, ListDatum) else ()
            if len(items) < 3 or not isinstance(items[1], Atom) or type(items[1].value) is not str:
                continue
            if not isinstance(items[0], Atom) or items[0].value not in ("call", "primitive"):
                continue
            for item in items[2:]:
                if isinstance(item, Atom) and isinstance(item.value, Keyword):
                    if item.span.start + start <= offset <= item.span.end + start:
                        return self.version.place(item.span), items[1].value, str(item.value)
        return None

    def uses_of_binding(self, binding: Any) -> Iterator[Use]:
        """Every place of the text where a name means ``binding``, each once."""
        seen = set()
        for _, piece in self.version.pieces:
            for use in uses_of(piece.form):
                place = (id(use.span.source), use.span.start)
                if use.binding is binding and place not in seen and use.span.source is piece.source:
                    seen.add(place)
                    yield Use(self.version.place(use.span), binding, use.defines)

    def uses_of_word(self, text: str) -> Iterator[Word]:
        """Every place of the text that holds a word."""
        for _, piece in self.version.pieces:
            if f'"{text}"' in piece.text:
                for word in words_of(piece.form.datums):
                    if word.text == text:
                        yield replace(word, span=self.version.place(word.span))

    def bindings_named(self, name: str) -> list[Any]:
        """The bindings that were defined as ``name`` and stand in the text, with or without a prefix."""
        found = {}
        for _, piece in self.version.pieces:
            if name in piece.text:
                for use in uses_of(piece.form):
                    binding = use.binding.variable if isinstance(use.binding, PaperForm) else use.binding
                    if isinstance(binding, (Variable, Macro)) and binding.name == name:
                        found[id(use.binding)] = use.binding
        return list(found.values())

    @cached_property
    def made_by_records(self) -> set[str]:
        """The names of records and of the procedures that their definitions make."""
        forms = self.version.program.forms
        made = (form.target for form in forms if type(form) is ast.Define and isinstance(form.target, tuple))
        spans: dict[Any, set[str]] = {}
        for target in made:
            for variable in pattern_variables(target):
                spans.setdefault(variable.span, set()).add(variable.name)
        return {name for names in spans.values() if len(names) > 1 for name in names}

    @cached_property
    def definitions(self) -> dict[Any, Any]:
        """The value of each top-level name of every file, and the function of each word (as a string), as core AST."""
        found: dict[Any, Any] = dict(self.known)
        for form in self.version.program.forms:
            if type(form) is ast.Define and isinstance(form.target, Variable):
                found[form.target] = form
            elif type(form) is ast.Bind and type(form.word) is ast.Constant:
                found[form.word.value] = form
        return found

    def definition_of(self, binding: Any) -> Span | None:
        """Where a binding comes from; None for what has no source."""
        if isinstance(binding, PaperForm):
            binding = binding.variable
        span = binding.span if isinstance(binding, (Variable, Macro)) else None
        return self.version.place(span) if span is not None else None


def uses_of(form: TopForm) -> Iterator[Use]:
    """The identifiers of a form that stand in its text."""
    for step in (form.scan, form.expansion):
        if step is not None:
            yield from step.uses


def words_of(datums: tuple[Datum, ...]) -> Iterator[Word]:
    """Strings where a form takes a word, and those in lists, in the order of the text."""
    stack: list[tuple[Datum, bool]] = [(datum, False) for datum in reversed(datums)]
    while stack:
        datum, listed = stack.pop()
        if isinstance(datum, Atom):
            if listed and type(datum.value) is str:
                yield Word(datum.span, datum.value, sure=False)
            continue
        items = datum.items
        head = items[0].value if items and isinstance(items[0], Atom) else None
        name = str(head) if isinstance(head, Symbol) else ""
        if name in _TAKES_WORD and len(items) > 1 and isinstance(items[1], Atom) and type(items[1].value) is str:
            yield Word(items[1].span, items[1].value, name == "bind")
            items = items[2:]
        quoted = name == "quote" or (listed and name != "list")
        stack += [(item, quoted or (name == "list" and isinstance(item, Atom))) for item in reversed(items)]


def file_of(span: Span) -> Path:
    """The file that a span lies in; the library's own files too."""
    name = span.source.name
    return _LIBRARY / "stdlib" / name[len(STD) :] if name.startswith(STD) else Path(name).absolute()
