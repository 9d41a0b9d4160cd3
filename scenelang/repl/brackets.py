"""The brackets of a text that is being typed: which are open at its end, which closing ones are wrong."""

from __future__ import annotations

from dataclasses import dataclass

_CLOSERS = {")": "(", "]": "["}


@dataclass(frozen=True, slots=True)
class Scan:
    """``openers`` are the offsets of the brackets that are open at the end, ``wrong`` those of closing brackets that
    close nothing or the wrong kind. ``string`` is where a string begins that is still open, ``is_comment`` whether the
    text ends inside a comment."""

    openers: tuple[int, ...]
    wrong: tuple[int, ...]
    string: int | None
    is_comment: bool


def scan(text: str) -> Scan:
    """Look through a text once."""
    openers: list[int] = []
    wrong: list[int] = []
    position, end = 0, len(text)
    string: int | None = None
    is_comment = False
    while position < end:
        c = text[position]
        if c == '"':
            after = _string_end(text, position)
            if after is None:
                string = position
                break
            position = after
            continue
        if c == ";":
            newline = text.find("\n", position)
            if newline < 0:
                is_comment = True
                break
            position = newline
        elif c == "#" and text[position : position + 2] == "#|":
            block = _block_end(text, position)
            if block is None:
                is_comment = True
                break
            position = block
            continue
        elif c in "([":
            openers.append(position)
        elif c in ")]":
            if openers and text[openers[-1]] == _CLOSERS[c]:
                openers.pop()
            else:
                wrong.append(position)
        position += 1
    return Scan(tuple(openers), tuple(wrong), string, is_comment)


def _string_end(text: str, start: int) -> int | None:
    position = start + 1
    while position < len(text):
        if text[position] == "\\":
            position += 1
        elif text[position] == '"':
            return position + 1
        position += 1
    return None


def _block_end(text: str, start: int) -> int | None:
    depth, position = 0, start
    while position < len(text):
        pair = text[position : position + 2]
        if pair == "#|":
            depth, position = depth + 1, position + 2
        elif pair == "|#":
            depth, position = depth - 1, position + 2
            if depth == 0:
                return position
        else:
            position += 1
    return None
