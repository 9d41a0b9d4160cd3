"""The names of a file's top level, with a record of who looked them up: what an analysis of one form depends on."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from scenelang.grammar.datum import Symbol
from scenelang.interpreter.scope import Macro


@dataclass(slots=True)
class Record:
    """What a piece of work looked up, with what it found (None: nothing), and what it bound.

    ``macros``: every macro there was, where the work asked for all of them. ``open_ended``: it depends on more than can
    be listed, such as all names when a misspelling is looked for.
    """

    seen: dict[Symbol, Any] = field(default_factory=dict)
    bound: dict[Symbol, Any] = field(default_factory=dict)
    macros: tuple[Any, ...] | None = None
    open_ended: bool = False


class Ledger(dict[Symbol, Any]):
    """Bindings by symbol. ``record`` notes the work that is going on."""

    def __init__(self) -> None:
        super().__init__()
        self.record = Record()

    def begin(self) -> Record:
        """Start a new record and return it."""
        self.record = Record()
        return self.record

    def get(self, key: Symbol, default: Any = None) -> Any:
        found = super().get(key, default)
        record = self.record
        if key not in record.seen and key not in record.bound:
            record.seen[key] = found
        return found

    def __setitem__(self, key: Symbol, value: Any) -> None:
        self.record.bound[key] = value
        super().__setitem__(key, value)

    def items(self) -> Any:
        """Every binding; the running work depends on each macro among them."""
        self.record.macros = self._macros()
        return super().items()

    def _macros(self) -> tuple[Any, ...]:
        found = super().items()
        return tuple((symbol, binding) for symbol, binding in found if isinstance(binding, Macro))

    def agrees(self, record: Record) -> bool:
        """Whether work with this record would find the same again."""
        if record.open_ended or (record.macros is not None and record.macros != self._macros()):
            return False
        find = super().get
        return all(find(symbol) is found for symbol, found in record.seen.items())

    def replay(self, bound: Mapping[Symbol, Any]) -> None:
        """Bind what finished work had bound."""
        self.update(bound)
