"""Display of values in the REPL: at most a dozen lines, without control characters."""

from __future__ import annotations

import base64
import io
import shutil
import textwrap
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum
from itertools import islice
from pathlib import Path
from typing import Any

from scenelang.backends.base import require
from scenelang.grammar.diagnostics import CODES, Diagnostic, SceneError, capped, printable, render_text
from scenelang.interpreter.runtime.procedures import Closure, Condition
from scenelang.interpreter.runtime.show import show
from scenelang.interpreter.runtime.types import Builtin
from scenelang.interpreter.scene.entity import Entity, Frames, Scene
from scenelang.interpreter.values.values import (
    Array,
    Matrix,
    MutableArray,
    MutableList,
    Pair,
    Procedure,
    Set,
    Table,
    Vector,
)

# Inline images: the protocols of iTerm2, kitty and sixel.


_CHUNK = 4096
_SIXEL_COLORS = 128


class Protocol(Enum):
    ITERM = "iterm2"
    KITTY = "kitty"
    SIXEL = "sixel"


def protocol_of(environment: Mapping[str, str]) -> Protocol | None:
    """Detect the terminal's image protocol; ``SCENELANG_IMAGES`` overrides it (a name, or ``none``)."""
    override = environment.get("SCENELANG_IMAGES")
    if override is not None:
        return next((p for p in Protocol if p.value == override), None)
    if "TMUX" in environment or environment.get("TERM", "").startswith("screen"):
        return None  # multiplexers do not pass the sequences through
    program, term = environment.get("TERM_PROGRAM", ""), environment.get("TERM", "")
    if program in ("iTerm.app", "WezTerm", "vscode") or environment.get("LC_TERMINAL") == "iTerm2":
        return Protocol.ITERM
    if "KITTY_WINDOW_ID" in environment or term in ("xterm-kitty", "xterm-ghostty") or program == "ghostty":
        return Protocol.KITTY
    if term.startswith(("foot", "mlterm", "yaft")) or "sixel" in term:
        return Protocol.SIXEL
    return None


def inline(path: Path, protocol: Protocol, rows: int) -> str:
    """Return the escape sequence of an image file, ``rows`` text lines high. Raises SceneError without pillow."""
    image = require("PIL.Image", "pillow").open(path).convert("RGB")
    if protocol is Protocol.SIXEL:
        return _sixel(image, rows * 18)
    data = io.BytesIO()
    image.save(data, "PNG")
    encoded = base64.b64encode(data.getvalue()).decode("ascii")
    if protocol is Protocol.ITERM:
        size = f"size={len(data.getvalue())};height={rows};preserveAspectRatio=1"
        return f"\x1b]1337;File=inline=1;{size}:{encoded}\a"
    return _kitty(encoded, rows)


def _kitty(encoded: str, rows: int) -> str:
    pieces = [encoded[i : i + _CHUNK] for i in range(0, len(encoded), _CHUNK)]
    sequence = []
    for number, piece in enumerate(pieces):
        head = f"a=T,f=100,r={rows}," if number == 0 else ""
        sequence.append(f"\x1b_G{head}m={int(number < len(pieces) - 1)};{piece}\x1b\\")
    return "".join(sequence)


def _sixel(image: Any, height: int) -> str:
    """Encode an image as sixel: palette, bands of six rows, each color's row run-length encoded."""
    width = max(1, round(image.width * height / image.height))
    small = image.resize((width, height)).quantize(_SIXEL_COLORS)
    palette = small.getpalette()
    pixels = small.load()
    out = [f'\x1bPq"1;1;{width};{height}']
    for number in sorted({index for _, index in small.getcolors(_SIXEL_COLORS)}):
        red, green, blue = (round(100 * c / 255) for c in palette[3 * number : 3 * number + 3])
        out.append(f"#{number};2;{red};{green};{blue}")
    for top in range(0, height, 6):
        rows = range(top, min(top + 6, height))
        used = sorted({pixels[x, y] for y in rows for x in range(width)})
        for color in used:
            bits = [sum(1 << (y - top) for y in rows if pixels[x, y] == color) for x in range(width)]
            out.append(f"#{color}{_runs(bits)}$")
        out.append("-")
    return "".join(out) + "\x1b\\"


def _runs(bits: list[int]) -> str:
    out: list[str] = []
    start = 0
    for x in range(1, len(bits) + 1):
        if x == len(bits) or bits[x] != bits[start]:
            out.append(f"!{x - start}{chr(63 + bits[start])}")
            start = x
    return "".join(out)


# Trees of entities: breadth-first within a few lines; equal neighbors are counted together.


_MAX_EXAMINED = 20_000  # maximum number of parts to examine per entity
_MAX_FACTS = 60


@dataclass(slots=True)
class _Node:
    label: str
    parts: Sequence[Any]
    children: list[_Node] = field(default_factory=list)
    hidden: str = ""


def _first_of(frames: Sequence[Any]) -> str:
    """Return the line above the tree of the first frame."""
    return f"{len(frames):,} frames; the first:" if len(frames) != 1 else "one frame:"


def tree_lines(value: Entity | Scene | Frames, most: int) -> list[str]:
    """Return the tree of an entity, or of the first frame of a scene, in at most ``most`` lines."""
    if isinstance(value, Frames):
        return [_first_of(value.frames), *_drawn(_Node("parts", value.frames[0]), most - 1)]
    if isinstance(value, Scene):
        root = value.root
        if value.animated:
            return [_first_of(value.frames), *_drawn(_node(root, 1), most - 1)]
        return _drawn(_node(root, 1), most)
    return _drawn(_node(value, 1), most)


def parts_tree(value: Pair | MutableList, most: int) -> list[str]:
    """Return the tree of parts, a list of entities and pairs ``(Entity . Matrix)``; empty for other values."""
    items = list(islice(_items(value), _MAX_EXAMINED + 1))
    if type(value) is Pair and type(value.car) is Entity and type(value.cdr) is Matrix:
        items = [value]
    if not items or not all(_is_part(item) for item in items):
        return []
    count = f"{len(items):,}" if len(items) <= _MAX_EXAMINED else f"more than {_MAX_EXAMINED:,}"
    return _drawn(_Node(f"{count} part{'' if len(items) == 1 else 's'}", [_as_part(item) for item in items]), most)


def _items(value: Any) -> Iterator[Any]:
    if type(value) is MutableList:
        yield from value.items
        return
    while type(value) is Pair:
        yield value.car
        value = value.cdr


def _is_part(item: Any) -> bool:
    return type(item) is Entity or (type(item) is Pair and type(item.car) is Entity and type(item.cdr) is Matrix)


def _as_part(item: Any) -> Any:
    return item if type(item) is Pair else Pair(item, None)


def _node(entity: Entity, count: int) -> _Node:
    times = f"{count:,} x " if count > 1 else ""
    return _Node(f"{times}{entity.word}{_facts(entity) if count == 1 else ''}", entity.children)


def _facts(entity: Entity) -> str:
    """Return handle, text and attributes, shortened."""
    z = entity.embedding
    facts = [f"<{z.handle}>"] if z.handle else []
    facts += [f'"{z.text[:40]}"'] if z.text else []
    facts += [f":{name} {_brief(value)}" for name, value in islice(z.attributes.items(), 6)]
    text = " ".join(facts)
    return f"  {text[:_MAX_FACTS]}{'...' if len(text) > _MAX_FACTS else ''}" if text else ""


def _brief(value: Any) -> str:
    if type(value) is float:
        return f"{value:.4g}"
    if type(value) is Vector:
        return "[" + " ".join(f"{x:.4g}" for x in value[:4]) + ("..." if len(value) > 4 else "") + "]"
    return show(value, 40)


def _drawn(root: _Node, most: int) -> list[str]:
    """Expand the tree breadth-first while lines are left, then format it from the top."""
    left = most - 1
    waiting = deque([root])
    while waiting:
        node = waiting.popleft()
        groups = _groups(node.parts)
        if not groups:
            continue
        rest = len(node.parts) - min(len(node.parts), _MAX_EXAMINED)
        if left <= 0:
            node.label += f"  ... {_parts(len(node.parts))}"
            continue
        fits = len(groups) if len(groups) <= left and not rest else max(0, left - 1)
        node.children = [_node(entity, count) for entity, count in groups[:fits]]
        hidden = sum(count for _, count in groups[fits:]) + rest
        if hidden:
            node.hidden = f"... {hidden:,} more" if fits else f"... {_parts(hidden)}"
        left -= fits + (1 if hidden else 0)
        waiting.extend(node.children)
    return list(_rows(root, "", ""))


def _parts(count: int) -> str:
    return f"{count:,} part{'' if count == 1 else 's'}"


def _rows(root: _Node, prefix: str, inner: str) -> Iterator[str]:
    stack = [(root, prefix, inner)]
    while stack:
        node, prefix, inner = stack.pop()
        yield prefix + node.label
        below: list[_Node] = [*node.children, *([_Node(node.hidden, ())] if node.hidden else [])]
        for number, child in reversed(list(enumerate(below))):
            last = number == len(below) - 1
            stack.append((child, inner + ("└─ " if last else "├─ "), inner + ("   " if last else "│  ")))


def _groups(parts: Iterable[Any]) -> list[tuple[Entity, int]]:
    """Group adjacent parts with the same word and number of parts, with a count."""
    groups: list[tuple[Entity, int]] = []
    for part in islice(parts, _MAX_EXAMINED):
        entity = part.car
        if groups and groups[-1][0].word == entity.word and len(groups[-1][0].children) == len(entity.children):
            groups[-1] = (groups[-1][0], groups[-1][1] + 1)
        else:
            groups.append((entity, 1))
    return groups


MAX_LINES = 12
_MAX_ROWS, _MAX_COLUMNS = 10, 10
_COUNTED = 100_000  # maximum length of a chain of pairs to count


def displayed(value: Any, width: int = 80) -> str:
    """Format a value, in at most ``MAX_LINES`` lines of at most ``width`` columns; empty for none."""
    lines = [clean(line) for line in _lines(value, max(width, 20))]
    if len(lines) > MAX_LINES:
        lines = [*lines[: MAX_LINES - 1], f"... {len(lines) - MAX_LINES + 1:,} more lines"]
    return "\n".join(line if len(line) <= width else line[: width - 3] + "..." for line in lines)


def clean(text: str) -> str:
    """Remove characters that control the terminal from a line."""
    return printable(text).replace("\n", "\\xa;")


def _lines(value: Any, width: int) -> Sequence[str]:
    """Return the lines that show a value, depending on its type."""
    if value is None:
        return []
    kind = type(value)
    if kind is Entity or kind is Scene or kind is Frames:
        return tree_lines(value, MAX_LINES)
    if kind is Matrix:
        return aligned([value[0:4], value[4:8], value[8:12], (0.0, 0.0, 0.0, 1.0)])
    if kind is Array or kind is MutableArray:
        return _array_lines(value.data, width)
    if kind is Vector:
        return _row(value[: _most_items(width)], len(value), width)
    if kind is Table:
        return _table_lines(value, width)
    if kind is Condition:
        return error_lines(value.error)
    if isinstance(value, Procedure):
        return [signature_of(value)]
    if (kind is Pair or kind is MutableList) and (lines := parts_tree(value, MAX_LINES)):
        return lines
    return _text_lines(value, width)


def _text_lines(value: Any, width: int) -> Sequence[str]:
    """Format other values as text, truncated with their length."""
    limit = width * 4
    text = show(value, limit)
    if len(text) < limit:
        return _wrapped(text, width)
    return [*_wrapped(text, width), f"({_length(value)})"] if _length(value) else _wrapped(text, width)


def _length(value: Any) -> str:
    if type(value) is str:
        return f"{len(value):,} characters"
    if type(value) is MutableList:
        return f"{len(value.items):,} items"
    if type(value) is Set:
        return f"{len(value.entries):,} members"
    if type(value) is int:
        return f"{len(str(abs(value))):,} digits"
    count = 0
    while type(value) is Pair:
        value, count = value.cdr, count + 1
        if count >= _COUNTED * 100:
            return f"more than {count:,} items"
    return f"{count:,} items" if count else ""


def _wrapped(text: str, width: int) -> list[str]:
    return textwrap.wrap(clean(text), width, subsequent_indent=" ", drop_whitespace=True) or [""]


def _most_items(width: int) -> int:
    return width // 2


def _row(shown: Sequence[Any], count: int, width: int) -> Sequence[str]:
    """Format the first items of a vector of ``count`` items."""
    return _wrapped("[" + " ".join(map(_number, shown)) + _rest(count, width) + "]", width)


def _rest(count: int, width: int) -> str:
    return f" ... {count - _most_items(width):,} more" if count > _most_items(width) else ""


def _number(x: Any) -> str:
    if isinstance(x, (bool, int)) or not isinstance(x, float):
        return str(x)
    text = f"{x:.6g}"
    return text if any(c in text for c in ".en") else text + ".0"


def aligned(rows: Iterable[Sequence[Any]]) -> list[str]:
    """Format rows of numbers as columns, with four significant digits."""
    cells = [[_short(x) for x in row] for row in rows]
    widths = [max(map(len, column)) for column in zip(*cells)]
    lines = ["[" + " ".join(c.rjust(w) for c, w in zip(row, widths)) + "]" for row in cells]
    return [("[" if i == 0 else " ") + line + ("]" if i == len(lines) - 1 else "") for i, line in enumerate(lines)]


def _short(x: Any) -> str:
    number = float(x)
    if abs(number) < 1e-12:
        return "0"
    return f"{number:.4g}"


def _array_lines(data: Any, width: int) -> Sequence[str]:
    if data.ndim == 1:
        return _row(data[: _most_items(width)].tolist(), len(data), width)
    if data.ndim != 2 or not data.size:
        shape = " x ".join(map(str, data.shape))
        return [f"array of {shape}", *(_text_lines(data.tolist(), width) if data.size < 50 else ())]
    columns = min(data.shape[1], _MAX_COLUMNS)
    lines = aligned(data[:_MAX_ROWS, :columns].tolist())
    if data.shape[0] > _MAX_ROWS or data.shape[1] > columns:
        lines.append(f"... {data.shape[0]:,} x {data.shape[1]:,}")
    return lines


def _table_lines(table: Table, width: int) -> list[str]:
    entries = list(table.entries.values())
    if not entries:
        return ["(table)"]
    shown = [(show(key, 30), show(value, width)) for key, value in entries[: MAX_LINES - 2]]
    across = max(len(key) for key, _ in shown)
    lines = [f"table of {len(entries):,}:", *(f"  {key.ljust(across)}  {value}" for key, value in shown)]
    return [*lines, f"  ... {len(entries) - len(shown):,} more"] if len(entries) > len(shown) else lines


def signature_of(function: Procedure) -> str:
    """Return the call signature of a function."""
    if isinstance(function, Builtin):
        return f"function {function.usage}"
    if type(function) is Closure:
        usage = function.code.usage
        inner = usage[1:-1] if usage.startswith("(") and usage.endswith(")") else usage
        named = inner if inner.split(" ")[0] == function.code.name else f"{function.code.name} {inner}".rstrip()
        return f"function ({named})"
    return show(function)


def error_lines(error: SceneError) -> list[str]:
    """Format an error value: code, message, position."""
    lines = [f"error {CODES[error.name].code}: {error.message}"]
    if error.span is not None:
        line, column = error.span.source.position(error.span.start)
        lines.append(f"  at {error.span.source.name}:{line}:{column}")
    return lines


# Output of a REPL: a terminal, or two plain streams.


_MAX_LOG_LINES = 200
_MAX_SCREEN_ROWS = 60


@dataclass(frozen=True, slots=True)
class Screen:
    """Output of a REPL. ``write`` prints a text without its final newline, ``complain`` an error. ``images`` is the
    inline image protocol. ``ask`` asks a yes-or-no question; None without an interactive user."""

    write: Callable[[str], None]
    complain: Callable[[str], None]
    color: bool = False
    images: Protocol | None = None
    ask: Callable[[str], bool] | None = None
    quiet: bool = False

    @property
    def width(self) -> int:
        return shutil.get_terminal_size((100, 24)).columns

    @property
    def height(self) -> int:
        return shutil.get_terminal_size((100, 24)).lines

    def report(self, diagnostics: Iterable[Diagnostic]) -> None:
        """Print diagnostics; warnings unless quiet."""
        for diagnostic in capped([d for d in diagnostics if d.is_error or not self.quiet]):
            self.complain(render_text(diagnostic, self.color))

    def log(self, lines: Sequence[str]) -> None:
        """Print the output of a program, up to a maximum number of lines."""
        shown = [part for line in lines[:_MAX_LOG_LINES] for part in line.split("\n")][:_MAX_LOG_LINES]
        for line in shown:
            self.write(clean(line))
        left = sum(line.count("\n") + 1 for line in lines) - len(shown)
        if left:
            self.write(f"... {left:,} more lines")

    def prose(self, lines: Iterable[str], most: int = _MAX_SCREEN_ROWS) -> None:
        """Print lines of text, wrapped with a hanging indent."""
        wrapped: list[str] = []
        for line in lines:
            indent = " " * (len(line) - len(line.lstrip()) + (0 if line.startswith(" ") else 2))
            wrapped += textwrap.wrap(clean(line), self.width, subsequent_indent=indent, break_on_hyphens=False) or [""]
        self.rows(wrapped, most)

    def rows(self, lines: Iterable[str], most: int = _MAX_SCREEN_ROWS) -> None:
        """Print the output lines of a command, truncated to the width, up to a maximum number."""
        width = self.width
        for number, line in enumerate(lines):
            if number == most:
                self.write("...")
                return
            text = clean(line)
            self.write(text if len(text) <= width else text[: width - 3] + "...")
