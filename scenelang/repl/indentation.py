"""How far a new line of an unfinished form is indented: bodies by two, operands under one another."""

from __future__ import annotations

import re
from collections.abc import Mapping

from scenelang.repl.brackets import scan

_HEAD = re.compile(r"[^\s()\[\]\"';`,]+")
_BLANK = re.compile(r"[ \t]*")
_CLAUSES = ("cond", "case")  # whose operands are lists of a test and a body


def indentation(text: str, indents: Mapping[str, int | None]) -> int:
    """Columns for the line that follows ``text``. ``indents``: for each form how many operands stand on the head's line
    before its body, None where operands are aligned."""
    found = scan(text)
    if not found.openers or found.string is not None:
        return 0
    opener = found.openers[-1]
    column = opener - (text.rfind("\n", 0, opener) + 1)
    if text[opener] == "[":
        return column + 1
    head = _HEAD.match(text, opener + 1)
    if head is None:
        return column + 1
    name, after = head[0], text[head.end() :]
    around = _HEAD.match(text, found.openers[-2] + 1) if len(found.openers) > 1 else None
    if around is not None and around[0] in _CLAUSES:
        return column + 1
    if name == "let" and re.match(r"\s+[^\s()]", after):
        return _body(column, after, 2)  # a named let
    wanted = indents.get(name, 0 if name.startswith(("def", "with-")) else None)
    if wanted is not None:
        return _body(column, after, wanted)
    blank = _BLANK.match(text, head.end())
    start = blank.end() if blank is not None else head.end()
    if start >= len(text) or text[start] in "\n;":
        return column + (1 if name == "else" else 2)
    return column + start - opener


def _body(column: int, after: str, wanted: int) -> int:
    """A body by two; what belongs on the head's line but does not stand there by four."""
    return column + (2 if _operands(after) >= wanted else 4)


def _operands(text: str) -> int:
    """How many operands are complete in the text after a head."""
    count, position = 0, 0
    while True:
        while position < len(text) and text[position].isspace():
            position += 1
        if position >= len(text):
            return count
        start = position
        if text[position] in '(["':
            position = _datum_end(text, position)
        else:
            atom = re.compile(r"[^\s()\[\]\"]+").match(text, position)
            position = atom.end() if atom is not None else position + 1
        count += position > start


def _datum_end(text: str, start: int) -> int:
    """Where the list or string that begins at ``start`` ends, the end of the text when it is open."""
    if text[start] == '"':
        match = re.compile(r'"(?:[^"\\]|\\.)*"').match(text, start)
        return match.end() if match is not None else len(text)
    low, high = start + 1, len(text)
    for close in re.finditer(r"[)\]]", text[low:high]):
        end = low + close.end()
        found = scan(text[start:end])
        if not found.openers and found.string is None:
            return end
    return len(text)
