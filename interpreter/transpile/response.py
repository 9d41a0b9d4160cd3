"""Where the program stands in a language model's response: prose, fenced code, prose."""

from __future__ import annotations

import ast
import re
import textwrap
import warnings
from dataclasses import dataclass
from typing import TypeAlias

_FENCE = re.compile(r"^[ \t]*+(?:```++|~~~++)[ \t]*+([\w+-]*+)[^\n`]*+$", re.M)
_PYTHON_FENCE = re.compile(r"^[ \t]*(?:```|~~~)[ \t]*(?:python3?|py)[ \t]*$", re.M | re.I)
_CLOSING = re.compile(r"^[ \t]*(?:```|~~~)", re.M)
_REGISTERS = re.compile(r"^[ \t]*@register", re.M)


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
    first block that registers something when that one does not; the whole text when nothing is fenced, or when the
    text is Python as it stands (its fences are then inside strings)."""
    blocks = _python_blocks(text) or _blocks(text)
    if not blocks or _is_python(text):
        return Response(0, len(text), "", "")
    chosen = next((block for block in blocks if _REGISTERS.search(text, block[1], block[2])), blocks[0])
    opening, start, end, closing = chosen
    before = _FENCE.sub("", _without_blocks(text, blocks, 0, opening))
    after = _FENCE.sub("", _without_blocks(text, blocks, closing, len(text)))
    return Response(start, end, before.strip(), after.strip(), len(blocks) - 1)


def _is_python(text: str) -> bool:
    """Whether a whole text parses as Python and is more than strings."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            tree = ast.parse(textwrap.dedent(text))
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return False
    return any(not isinstance(node, ast.Expr) or not isinstance(node.value, ast.Constant) for node in tree.body)


def code_of(text: str) -> str:
    """The code of a response by itself, with one newline at its end."""
    found = find_code(text)
    return text[found.start : found.end].strip() + "\n"


# A block: start of the opening fence, start and end of the code, end of the closing fence.
Block: TypeAlias = tuple[int, int, int, int]


def _python_blocks(text: str) -> list[Block]:
    """Blocks that say that they are Python, each up to the next fence of any kind."""
    found: list[Block] = []
    position = 0
    while opening := _PYTHON_FENCE.search(text, position):
        start = _next_line(text, opening)
        closing = _CLOSING.search(text, start)
        end = closing.start() if closing else len(text)
        line_end = text.find("\n", end) if closing else -1
        position = line_end if line_end >= 0 else len(text)
        found.append((opening.start(), start, end, position))
    return found


def _blocks(text: str) -> list[Block]:
    """All fenced blocks."""
    found: list[Block] = []
    opening: re.Match[str] | None = None
    for match in _FENCE.finditer(text):
        if opening is None:
            opening = match
        elif not match.group(1):
            found.append((opening.start(), _next_line(text, opening), match.start(), match.end()))
            opening = None
    if opening is not None:  # cut off before its end
        found.append((opening.start(), _next_line(text, opening), len(text), len(text)))
    return found


def _next_line(text: str, fence: re.Match[str]) -> int:
    return min(fence.end() + 1, len(text))


def _without_blocks(text: str, blocks: list[Block], start: int, end: int) -> str:
    pieces = []
    for opening, _, _, closing in blocks:
        if start <= opening and closing <= end:
            pieces.append(text[start:opening])
            start = closing
    pieces.append(text[start:end])
    return "\n".join(pieces)
