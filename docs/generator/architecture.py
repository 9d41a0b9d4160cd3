"""The diagram of docs/architecture.md: which folder imports which, read from the code."""

from __future__ import annotations

import ast
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from html import escape
from pathlib import Path

ROOT = Path(__file__).parents[2]
ROOMS = ("scenelang", "backends", "stdlib", "interpreter", "grammar")  # downward, as imports point
_MARGIN, _BOX, _GAP, _ROW, _HEIGHT, _LABEL, _WIDTH = 14, 108, 16, 78, 40, 120, 1060

Graph = Mapping[str, frozenset[str]]


@dataclass(frozen=True, slots=True)
class Box:
    """A folder at a place of the picture."""

    name: str
    files: int
    x: float
    y: float


def folder_of(path: Path) -> str:
    """The folder that a file of the packages belongs to, at most two levels deep; files of a room itself are that
    room's."""
    parts = path.relative_to(ROOT).parts
    return "/".join(parts[:2]) if len(parts) > 2 else parts[0]


@cache
def folders() -> Graph:
    """For each folder those that it imports, at any place of its files."""
    found: dict[str, set[str]] = {}
    for room in ROOMS:
        for path in sorted((ROOT / room).rglob("*.py")):
            if path.name not in ("__init__.py", "__main__.py"):
                own = found.setdefault(folder_of(path), set())
                own |= set(_imported(path)) - {folder_of(path)}
    return {name: frozenset(others & found.keys()) for name, others in found.items()}


def _imported(path: Path) -> Iterator[str]:
    for node in _statements(ast.parse(path.read_text("utf-8"))):
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("scenelang"):
            for alias in node.names:
                target = _file(f"{node.module}.{alias.name}") or _file(node.module or "")
                if target is not None:
                    yield folder_of(target)


def _statements(node: ast.AST) -> Iterator[ast.stmt]:
    """The statements below a node; expressions, which are most of a tree, hold none."""
    for block in ("body", "orelse", "finalbody", "handlers", "cases"):
        for child in getattr(node, block, ()):
            if isinstance(child, ast.stmt):
                yield child
            yield from _statements(child)


@cache
def _file(module: str) -> Path | None:
    """The file of a module, None where that is a name in one."""
    parts = module.split(".")[1:]
    base = ROOT.joinpath(*parts) if parts and parts[0] in ROOMS else ROOT.joinpath("scenelang", *parts)
    return next((path for path in (base.with_suffix(".py"), base / "__init__.py") if path.is_file()), None)


def levels(graph: Graph) -> dict[str, int]:
    """How many imports lie below each folder inside its room; folders that import one another share a level."""
    below = {name: {other for other in others if _room(other) == _room(name)} for name, others in graph.items()}

    def reach(name: str, seen: frozenset[str] = frozenset()) -> frozenset[str]:
        for other in below[name] - seen:
            seen = reach(other, seen | {other})
        return seen

    reached = {name: reach(name) for name in graph}
    group = {name: frozenset(o for o in reached[name] if name in reached[o]) | {name} for name in graph}

    @cache
    def level(mates: frozenset[str]) -> int:
        further = {group[other] for name in mates for other in below[name] if other not in mates}
        return 1 + max(map(level, further), default=-1)

    return {name: level(group[name]) for name in graph}


def shown(graph: Graph) -> list[tuple[str, str]]:
    """The arrows: imports inside a room that do not follow from others."""
    graph = {name: frozenset(o for o in others if _room(o) == _room(name)) for name, others in graph.items()}
    reached = {name: _reach(graph, name) for name in graph}

    def follows(name: str, other: str) -> bool:
        between = graph[name] - {other}
        return any(other in reached[one] and name not in reached[one] and one not in reached[other] for one in between)

    return [(name, other) for name in sorted(graph) for other in sorted(graph[name]) if not follows(name, other)]


def _reach(graph: Graph, name: str) -> frozenset[str]:
    found, stack = set(), [name]
    while stack:
        for other in graph[stack.pop()] - found:
            found.add(other)
            stack.append(other)
    return frozenset(found)


def _room(name: str) -> str:
    return name.split("/")[0]


def boxes(graph: Graph) -> tuple[dict[str, Box], float]:
    """Where each folder stands, and the height of the picture."""
    depth = levels(graph)
    placed: dict[str, Box] = {}
    y = float(_MARGIN)
    for room in ROOMS:
        mine = [name for name in graph if _room(name) == room]
        for level in sorted({depth[name] for name in mine}, reverse=True):
            row = [name for name in mine if depth[name] == level]
            row.sort(key=lambda name: (_pull(name, graph, placed), name))
            start = _LABEL + (_WIDTH - _LABEL - _MARGIN - len(row) * _BOX - (len(row) - 1) * _GAP) / 2
            for number, name in enumerate(row):
                placed[name] = Box(name, _count(name), start + number * (_BOX + _GAP), y)
            y += _ROW
        y += _GAP
    return placed, y - _ROW + _HEIGHT + _MARGIN


def _pull(name: str, graph: Graph, placed: Mapping[str, Box]) -> float:
    """The mean place of those above that import the folder."""
    above = [placed[other].x for other in placed if name in graph[other]]
    return sum(above) / len(above) if above else 0.0


def _count(name: str) -> int:
    paths = (ROOT / name).rglob("*.py") if "/" in name else (ROOT / name).glob("*.py")
    return sum(path.name != "__init__.py" for path in paths)


def architecture_svg() -> str:
    """The diagram as SVG text; the same text for the same imports."""
    graph = folders()
    placed, height = boxes(graph)
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {_WIDTH} {height:g}" font-family="sans-serif" '
        f'font-size="12"><title>Which folder imports which</title>',
        '<defs><marker id="tip" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="6" markerHeight="6" orient="auto">'
        '<path d="M0 0L8 4L0 8z" fill="#7a869a"/></marker></defs>',
        f'<rect width="{_WIDTH}" height="{height:g}" fill="#ffffff"/>',
    ]
    lines += [_band(room, graph, placed) for room in ROOMS]
    lines += [_arrow(placed[a], placed[b], a in graph[b]) for a, b in shown(graph) if not (a in graph[b] and a > b)]
    lines += [_drawn(box) for box in placed.values()]
    return "\n".join([*lines, "</svg>"]) + "\n"


def _band(room: str, graph: Graph, placed: Mapping[str, Box]) -> str:
    rows = [box.y for box in placed.values() if _room(box.name) == room]
    top, bottom = min(rows) - _GAP / 2, max(rows) + _HEIGHT + 1.6 * _GAP
    middle = (top + bottom) / 2
    below = sorted(
        {_room(other) for name in graph if _room(name) == room for other in graph[name]} - {room}, key=ROOMS.index
    )
    told = f"imports {', '.join(below)}" if below else "imports none of these"
    return (
        f'<rect x="4" y="{top:g}" width="{_WIDTH - 8}" height="{bottom - top:g}" rx="6" fill="#eef2f7"/>'
        f'<text x="14" y="{middle:g}" font-weight="bold" fill="#3c4858">{room}/</text>'
        + "".join(
            f'<text x="14" y="{middle + 16 + 12 * n:g}" font-size="9" fill="#68768a">{part}</text>'
            for n, part in enumerate(_wrapped(told))
        )
    )


def _wrapped(text: str) -> list[str]:
    """The words of a text, two in a line."""
    words = text.split()
    return [" ".join(words[n : n + 2]) for n in range(0, len(words), 2)]


def _arrow(one: Box, other: Box, is_mutual: bool) -> str:
    x0, x1 = one.x + _BOX / 2, other.x + _BOX / 2
    if one.y == other.y:
        y, sag = one.y + _HEIGHT, 12 + abs(x1 - x0) / 25
        path = f"M{x0:g} {y:g}C{x0:g} {y + sag:g} {x1:g} {y + sag:g} {x1:g} {y:g}"
    else:
        y0, y1 = one.y + _HEIGHT, other.y
        path = f"M{x0:g} {y0:g}C{x0:g} {y0 + 30:g} {x1:g} {y1 - 30:g} {x1:g} {y1:g}"
    start = ' marker-start="url(#tip)"' if is_mutual else ""
    return f'<path d="{path}" fill="none" stroke="#7a869a" stroke-width="1"{start} marker-end="url(#tip)"/>'


def _drawn(box: Box) -> str:
    name = escape(box.name.split("/")[-1]) if "/" in box.name else "(its files)"
    files = f"{box.files} file{'s' if box.files != 1 else ''}"
    return (
        f'<rect x="{box.x:g}" y="{box.y:g}" width="{_BOX}" height="{_HEIGHT}" rx="5" fill="#ffffff" stroke="#3c4858"/>'
        f'<text x="{box.x + _BOX / 2:g}" y="{box.y + 17:g}" text-anchor="middle" fill="#1d2733">{name}</text>'
        f'<text x="{box.x + _BOX / 2:g}" y="{box.y + 32:g}" text-anchor="middle" font-size="10" fill="#68768a">'
        f"{files}</text>"
    )
