"""The top-level forms of a file, each with all that was found in it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from scenelang.grammar.datum import Datum, ListDatum
from scenelang.grammar.diagnostics import Diagnostic
from scenelang.grammar.reader import read_pieces
from scenelang.grammar.source import Source, Span
from scenelang.interpreter.expand import Pending, Use
from scenelang.interpreter.ledger import Record
from scenelang.interpreter.params import Param

if TYPE_CHECKING:
    from scenelang.interpreter.files import SourceFile


@dataclass(frozen=True, slots=True, eq=False)
class Import:
    """A top-level ``import``: the file that it brings, in its place among the forms."""

    file: SourceFile


@dataclass(slots=True)
class Step:
    """One of the two steps of a form, scanning or expansion: what it looked up, what went wrong, what macros cost, and
    for editors what the identifiers mean."""

    record: Record
    problems: list[Diagnostic]
    expansions: int
    expanded: int
    uses: list[Use]


class TopForm:
    """A top-level form, or several that touch, with all that was found in it."""

    __slots__ = ("asts", "datums", "expansion", "imports", "params", "pending", "read", "records", "scan", "scene",
                 "words")  # fmt: skip

    def __init__(self, datums: Sequence[Datum], read: Sequence[Diagnostic] = ()) -> None:
        self.datums = tuple(datums)
        self.read = tuple(read)  # what the reader found wrong
        self.scan: Step | None = None
        self.expansion: Step | None = None
        self.forget()

    def forget(self) -> None:
        """Nothing has been scanned yet."""
        self.scan = self.expansion = None
        self.pending: list[Pending | Import] = []
        self.words: list[tuple[str, Span]] = []
        self.records: set[str] = set()
        self.params: list[Param] = []
        self.imports: list[SourceFile] = []
        self.scene: ListDatum | None = None
        self.asts: list[Any] = []  # core AST and Imports


def top_forms(source: Source) -> list[TopForm]:
    """The forms of a text, read at once."""
    result = read_pieces(source)
    return [TopForm((), result.diagnostics), *(TopForm((datum,)) for datum in result.forms)]
