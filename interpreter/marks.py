"""The names of a file at one moment, to go back to when what came after fails."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from scenelang.grammar.datum import ListDatum, Symbol
from scenelang.grammar.source import Span
from scenelang.interpreter.files import SourceFile
from scenelang.interpreter.params import Param


@dataclass(frozen=True, slots=True)
class Mark:
    """What a file knew: bindings, words, records, params, the files that it imports; ``ran`` are those that have run,
    by id."""

    names: dict[Symbol, Any]
    brought: dict[Symbol, tuple[str, Any]]
    words: dict[str, Span]
    records: frozenset[str]
    scene: ListDatum | None
    params: tuple[Param, ...]
    files: dict[str, SourceFile]
    ran: frozenset[int]


def mark_of(file: SourceFile, ran: Iterable[int]) -> Mark:
    """The mark of a main file as it is now."""
    state = file.state
    assert state is not None
    return Mark(
        dict(dict.items(file.names)), dict(file.brought), dict(file.words), frozenset(file.expander.record_names),
        file.scene, tuple(state.params), dict(state.files), frozenset(ran),
    )  # fmt: skip


def go_back(file: SourceFile, mark: Mark) -> None:
    """Make a main file know what it knew at the mark."""
    state = file.state
    assert state is not None
    file.names.clear()
    file.names.replay(mark.names)
    file.brought, file.words, file.scene = dict(mark.brought), dict(mark.words), mark.scene
    file.expander.record_names.clear()
    file.expander.record_names |= mark.records
    state.params, state.files, state.loading = list(mark.params), dict(mark.files), []
