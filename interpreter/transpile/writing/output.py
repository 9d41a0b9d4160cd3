"""Code -> datums with spans in the Python, and the text of the program with its comments."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence

from scenelang.grammar.datum import ArrayDatum, Atom, Datum, Keyword, ListDatum, Symbol
from scenelang.grammar.diagnostics import Diagnostic
from scenelang.grammar.formatter import settled
from scenelang.grammar.layout import layout
from scenelang.grammar.source import Span
from scenelang.grammar.trivia import Trivia, line_comment
from scenelang.interpreter.forms import INDENTS
from scenelang.interpreter.transpile.writing.code import ArgumentName, Brackets, Code, Form, Key, Literal, Name, Ref
from scenelang.interpreter.transpile.writing.naming import Namer
from scenelang.interpreter.transpile.writing.readback import misread


class Output:
    """Turns code into datums; remembers comments and spellings beside them."""

    def __init__(self, namer: Namer, outer: Span) -> None:
        self._namer = namer
        self._outer = outer
        self.trivia: dict[int, Trivia] = {}
        self.spelling: dict[int, str] = {}

    def datum(self, code: Code, outer: Span | None = None) -> Datum:
        """The datum of ``code``; what has no place of its own has that of what it stands in."""
        span = code.span or outer or self._outer
        datum = self._bare(code, span)
        if code.before or code.after or code.blank:
            after = line_comment(code.after) if code.after else None
            self.trivia[id(datum)] = Trivia(_comments(code.before), after, code.blank)
        return datum

    def _bare(self, code: Code, span: Span) -> Datum:
        if type(code) is Form:
            rest = self.datum(code.rest, span) if code.rest is not None else None
            return ListDatum(tuple([self.datum(item, span) for item in code.items]), rest, span)
        if type(code) is Brackets:
            return ArrayDatum(tuple([self.datum(item, span) for item in code.items]), span)
        if type(code) is Literal:
            atom = Atom(code.value, span)
            if code.text is not None:
                self.spelling[id(atom)] = code.text
            return atom
        if type(code) is Ref:
            text = code.variable.text
            return Atom(Keyword(text) if code.is_keyword else Symbol(text), span)
        if type(code) is Key:
            return Atom(Keyword(code.text), span)
        if type(code) is ArgumentName:
            return Atom(Keyword(self._namer.keyword(code.python)), span)
        assert type(code) is Name
        return Atom(Symbol(code.text), span)

    def text(
        self, forms: Sequence[Datum], header: Sequence[str], footer: Sequence[str | None] = ()
    ) -> str | Diagnostic:
        """The text of the program; ``header`` are the lines of the comment that opens it. A diagnostic where the text
        would not read as ``forms``."""
        trivia = dict(self.trivia)
        if forms and header:
            first = trivia.get(id(forms[0]), Trivia())
            before = (*_comments(header), None, *first.before)
            trivia[id(forms[0])] = Trivia(before, first.after, first.blank, first.end)
        text = layout(forms, indents=INDENTS, trivia=trivia, spelling=self.spelling, end=_comments(footer))
        problem = misread(forms, text, self._outer)
        if problem is not None:
            return problem
        final = settled(text, INDENTS)
        return final if final == text else misread(forms, final, self._outer) or final


def _comments(texts: Sequence[str | None]) -> tuple[str | None, ...]:
    """Lines of comments; None is an empty line."""
    return tuple(None if text is None else line_comment(text) for text in texts)


def prose(text: str) -> list[str]:
    """Prose wrapped to lines of a comment; an empty line stays one."""
    lines: list[str] = []
    for paragraph in text.strip().splitlines():
        lines += textwrap.wrap(paragraph, 86) or [""]
    return lines
