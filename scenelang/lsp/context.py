"""What stands around a cursor, by the text alone, so that broken text does no harm."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass

from scenelang.grammar.chunks import lexemes


@dataclass(frozen=True, slots=True)
class Around:
    """A list that is open at the cursor: its items before the cursor as texts, nested ones as ``(``."""

    start: int
    items: tuple[str, ...]
    square: bool = False

    @property
    def head(self) -> str:
        return self.items[0] if self.items else ""


@dataclass(frozen=True, slots=True)
class Context:
    """``lists``: the open lists, innermost last. ``token``: the atom or string being written, up to the cursor, which
    begins at ``start``; it is in none of the lists. ``kind``: atom, string, comment or gap."""

    lists: tuple[Around, ...]
    token: str
    start: int
    kind: str

    @property
    def inner(self) -> Around | None:
        return self.lists[-1] if self.lists else None

    @property
    def position(self) -> int:
        """Which item of the innermost list the cursor is at; 0 is the head."""
        return len(self.lists[-1].items) if self.lists else 0

    def word(self, list_: Around | None) -> str | None:
        """The word of a ``(call "word" ...)``."""
        if list_ is None or len(list_.items) < 2 or list_.head not in ("call", "primitive"):
            return None
        return unquoted(list_.items[1])


def context(text: str, cursor: int, start: int = 0) -> Context:
    """The context of a cursor; ``start`` is a place at top level before it."""
    open_lists: list[tuple[int, list[str], bool]] = []
    for kind, begin, end in lexemes(text, start, cursor):
        if end >= cursor and kind in ("atom", "string", "other", "comment", "block"):
            closed = kind in ("string", "block") and end == cursor
            if not closed:
                token = "comment" if kind in ("comment", "block") else "atom" if kind == "atom" else "string"
                return Context(_frozen(open_lists), text[begin:cursor], begin, token)
        if kind == "open":
            if open_lists:
                open_lists[-1][1].append("(")
            open_lists.append((begin, [], text[begin] == "["))
        elif kind == "close":
            if open_lists:
                open_lists.pop()
        elif kind in ("atom", "string") and open_lists:
            open_lists[-1][1].append(text[begin:end])
    return Context(_frozen(open_lists), "", cursor, "gap")


def _frozen(lists: Sequence[tuple[int, list[str], bool]]) -> tuple[Around, ...]:
    return tuple(Around(start, tuple(items), square) for start, items, square in lists)


def unquoted(text: str) -> str | None:
    """The value of a string's text; None for anything else."""
    if len(text) < 2 or not text.startswith('"') or not text.endswith('"'):
        return None
    try:
        value = json.loads(text)
    except ValueError:
        return text[1:-1]
    return value if isinstance(value, str) else None


def closed(text: str, start: int, cursor: int, token: str, name: str) -> str:
    """The text from ``start`` with ``name`` in place of the token before the cursor, and all that is open closed."""
    lists = context(text, cursor, start).lists
    closers = "".join("]" if each.square else ")" for each in reversed(lists))
    return f"{text[start : cursor - len(token)]}{name}{closers}"
