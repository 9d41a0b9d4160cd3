"""A text cut into its top-level pieces, so that one can be read again without the others.

Whether a text reads is the reader's business; this scanner only matches brackets. Where they do not match, a piece ends
where the next one seems to begin: at an opening bracket in the first column.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

_TOKEN = re.compile(
    r"""(?P<space>\s+)|(?P<comment>;[^\n]*)|(?P<block>\#\|)|(?P<hide>\#;)|(?P<string>"(?:[^"\\]|\\.)*")"""
    r"""|(?P<open>[(\[])|(?P<close>[)\]])|(?P<prefix>'|`|,@|,)|(?P<atom>[^\s()\[\]";'`,]+)|(?P<other>.)""",
    re.S,
)
_EDGE = re.compile(r"#\||\|#")
_FIRST_COLUMN = re.compile(r"^[(\[]", re.M)


@dataclass(frozen=True)
class Chunk:
    """``text`` stands at ``start`` of the whole text, ``column`` characters (from 0) into its line; ``matched``: its
    brackets, strings and comments are closed."""

    start: int
    text: str
    column: int = 0
    matched: bool = True

    @property
    def end(self) -> int:
        return self.start + len(self.text)


@dataclass(frozen=True, eq=False)
class _Scan:
    text: str

    @cached_property
    def resumptions(self) -> list[int]:
        """Where text seems to begin anew."""
        return [match.start() for match in _FIRST_COLUMN.finditer(self.text)]

    def next_resumption(self, after: int) -> int:
        return next((start for start in self.resumptions if start > after), len(self.text))


def split(text: str) -> tuple[Chunk, ...]:
    """The pieces of ``text`` in order: usually one form each. What lies between them is blanks and comments."""
    return tuple(_pieces(_Scan(text)))


def _pieces(scan: _Scan) -> Iterator[Chunk]:
    position = 0
    held: list[Chunk] = []  # a piece of the first column and the indented ones after it
    while (found := _next_piece(scan, position)) is not None:
        chunk, position = found
        if scan.text[chunk.start] in ")]" and held:  # one of these ended too early, perhaps
            held = [Chunk(held[0].start, scan.text[held[0].start : position], held[0].column, matched=False)]
        elif chunk.column == 0:
            yield from held
            held = [chunk]
        else:
            held.append(chunk)
    yield from held


def _next_piece(scan: _Scan, position: int) -> tuple[Chunk, int] | None:
    """The first piece from ``position`` on, and where the search for the next one begins."""
    text = scan.text
    begin = _skip_blank(text, position)
    if begin is None:
        return None
    closed = _piece_end(text, begin)
    end = scan.next_resumption(begin) if closed is None else closed.end
    matched = closed is not None and closed.matched
    return Chunk(begin, text[begin:end].rstrip(), begin - _line_start(text, begin), matched), end


def _line_start(text: str, position: int) -> int:
    return text.rfind("\n", 0, position) + 1


# --- a text after an edit --------------------------------------------------------------------------------------------


def split_again(text: str, before: str, chunks: Sequence[Chunk]) -> tuple[Chunk, ...]:
    """What ``split(text)`` gives; ``chunks`` are the pieces of the text ``before``, of which those around the edit are
    used again."""
    if not all(chunk.matched for chunk in chunks):
        return split(text)
    head = _common_start(text, before)
    kept = [chunk for chunk in chunks if chunk.end < head]
    tail = _common_start(text[head:][::-1], before[head:][::-1])
    shift = len(text) - len(before)
    after = {chunk.start + shift: i for i, chunk in enumerate(chunks) if chunk.start > len(before) - tail}
    scan, position, found = _Scan(text), kept[-1].end if kept else 0, list(kept)
    while (piece := _next_piece(scan, position)) is not None:
        chunk, position = piece
        if not chunk.matched or text[chunk.start] in ")]":
            return split(text)
        if chunk.start in after:
            rest = chunks[after[chunk.start] :]
            return (*found, *(_shifted(each, shift, text) for each in rest))
        found.append(chunk)
    return tuple(found)


def _shifted(chunk: Chunk, shift: int, text: str) -> Chunk:
    start = chunk.start + shift
    column = start - _line_start(text, start) if chunk.column else 0
    return Chunk(start, chunk.text, column)


def _common_start(a: str, b: str) -> int:
    """How many characters two texts begin with alike."""
    low, high = 0, min(len(a), len(b))
    while low < high:
        middle = (low + high + 1) // 2
        if a[low:middle] == b[low:middle]:
            low = middle
        else:
            high = middle - 1
    return low


def _skip_blank(text: str, position: int) -> int | None:
    """Where the next piece begins; None at the end."""
    while (match := _TOKEN.match(text, position)) is not None:
        if match.lastgroup not in ("space", "comment"):
            if match.lastgroup != "block":
                return position
            end = _block_end(text, position)
            if end is None:
                return position
            position = end
        else:
            position = match.end()
    return None


def _block_end(text: str, start: int) -> int | None:
    depth, search = 1, start + 2
    while (edge := _EDGE.search(text, search)) is not None:
        search = edge.end()
        depth += 1 if edge[0] == "#|" else -1
        if depth == 0:
            return search
    return None


_OPENER = {")": "(", "]": "["}


class _End(NamedTuple):
    end: int
    matched: bool


def _piece_end(text: str, position: int) -> _End | None:
    """Where the piece that begins at ``position`` ends; None when it is never closed. Pieces that touch are one."""
    open_brackets: list[str] = []
    wanted = False  # a prefix still wants its datum
    while (match := _TOKEN.match(text, position)) is not None:
        kind, start = match.lastgroup, position
        position = match.end()
        if kind == "open":
            open_brackets.append(match[0])
            wanted = False
        elif kind == "close":
            if not open_brackets:
                return _End(position, False)
            if open_brackets.pop() != _OPENER[match[0]]:
                return None
            wanted = False
        elif kind == "prefix" or kind == "hide":
            wanted = True
        elif kind == "block":
            end = _block_end(text, start)
            if end is None:
                return None
            position = end
        elif kind == "other":
            return None  # a string that is never closed
        elif kind in ("atom", "string"):
            wanted = False
        if not open_brackets and not wanted and (kind in ("space", "comment") or _is_gap(text, position)):
            return _End(position, True)
    return None if open_brackets or wanted else _End(position, True)


def _is_gap(text: str, position: int) -> bool:
    """Whether what follows cannot join: white space, a comment, most brackets, the end."""
    return position >= len(text) or text[position] in " \t\r\n\f\v;()]"


def lexemes(text: str, start: int, end: int) -> Iterator[tuple[str, int, int]]:
    """The tokens between two offsets, however broken the text: kind (space, comment, block, hide, string, open, close,
    prefix, atom, other), start and end."""
    position = start
    while position < end and (match := _TOKEN.match(text, position)) is not None:
        kind = str(match.lastgroup)
        position = match.end()
        if kind == "block":
            position = _block_end(text, match.start()) or len(text)
        elif kind == "other" and match[0] == '"':
            position = len(text)  # a string that is never closed
        yield kind, match.start(), position


def piece_at(text: str, position: int) -> tuple[int, int]:
    """Where the first piece after ``position`` begins and ends, inside a form too; empty when none follows."""
    begin = _skip_blank(text, position)
    if begin is None:
        return len(text), len(text)
    closed = _piece_end(text, begin)
    return begin, len(text) if closed is None else closed.end
