"""Text -> tokens with the comments among them: all that a text holds but white space."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from scenelang.grammar.reader import block_comments, terminals, without_comments

LINE_COMMENT = "LINE_COMMENT"
BLOCK_COMMENT = "BLOCK_COMMENT"


class Token(NamedTuple):
    """``kind``: a terminal of ``reader.lark``, or a kind of comment. ``text`` is ``source[start:end]``."""

    kind: str
    text: str
    start: int
    end: int


def tokens(text: str) -> Iterator[Token]:
    """The tokens and comments of a text that reads, in order."""
    places = block_comments(text)
    position, upcoming = 0, 0
    for match in terminals().finditer(without_comments(text, places)):
        start, end = match.span()
        kind = str(match.lastgroup)
        if kind.startswith("__"):
            if text[start] != ";":
                continue  # white space
            kind = LINE_COMMENT
        while upcoming < len(places) and places[upcoming][0] < start:
            if places[upcoming][0] >= position:
                yield _block(text, *places[upcoming])
            upcoming += 1
        yield Token(kind, text[start:end], start, end)
        position = end
    for place in places[upcoming:]:
        if place[0] >= position:
            yield _block(text, *place)


def _block(text: str, start: int, end: int) -> Token:
    return Token(BLOCK_COMMENT, text[start:end], start, end)


def essence(text: str) -> list[tuple[str, str]]:
    """What may never change when white space does: kinds and texts of tokens and comments, blanks at the end of a
    line's comment left aside."""
    return [(t.kind, t.text.rstrip() if t.kind == LINE_COMMENT else t.text) for t in tokens(text)]
