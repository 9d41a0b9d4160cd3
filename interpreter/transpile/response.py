"""Where the program stands in a language model's response: prose, fenced code, prose."""

from __future__ import annotations

import re
from dataclasses import dataclass

_FENCE = re.compile(r"^[ \t]*(?:```+|~~~+)[ \t]*([\w+-]*)[^\n`]*$", re.M)
_REGISTERS = re.compile(r"^[ \t]*@register", re.M)
_PYTHON = ("python", "py", "python3")


@dataclass(frozen=True, slots=True)
class Response:
    """``start`` and ``end`` delimit the code in the text; ``before`` and ``after`` are the prose around it;
    ``ignored`` counts the further blocks of code that were left out."""

    start: int
    end: int
    before: str
    after: str
    ignored: int = 0


def find_code(text: str) -> Response:
    """The code of a response: from the first line "```python" to the next "```", as the paper's own tool reads it; the
    first block that registers something when that one does not; the whole text when nothing is fenced."""
    blocks = _blocks(text)
    if not blocks:
        return Response(0, len(text), "", "")
    python = [block for block in blocks if block[0].lower() in _PYTHON] or blocks
    chosen = next((block for block in python if _REGISTERS.search(text, block[2], block[3])), python[0])
    _, opening, start, end, closing = chosen
    before = _FENCE.sub("", _without_blocks(text, blocks, 0, opening))
    after = _FENCE.sub("", _without_blocks(text, blocks, closing, len(text)))
    return Response(start, end, before.strip(), after.strip(), len(python) - 1)


def _blocks(text: str) -> list[tuple[str, int, int, int, int]]:
    """(language, start of the opening fence, start and end of the code, end of the closing fence) of every block."""
    found: list[tuple[str, int, int, int, int]] = []
    opening: re.Match[str] | None = None
    for match in _FENCE.finditer(text):
        if opening is None:
            opening = match
        elif not match.group(1):
            found.append((opening.group(1), opening.start(), _next_line(text, opening), match.start(), match.end()))
            opening = None
    if opening is not None:  # cut off before its end
        found.append((opening.group(1), opening.start(), _next_line(text, opening), len(text), len(text)))
    return found


def _next_line(text: str, fence: re.Match[str]) -> int:
    return min(fence.end() + 1, len(text))


def _without_blocks(text: str, blocks: list[tuple[str, int, int, int, int]], start: int, end: int) -> str:
    pieces = []
    for _, opening, _, _, closing in blocks:
        if start <= opening and closing <= end:
            pieces.append(text[start:opening])
            start = closing
    pieces.append(text[start:end])
    return "\n".join(pieces)
