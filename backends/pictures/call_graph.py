"""Computation graph of a scene as SVG: which entity calls which, how often, under which handles (paper, Figure 2).

Entities with the same word and the same kinds of parts share a node, so that sixty-four squares of two colors are one
node, while each level of a recursion has a separate node.
"""

from __future__ import annotations

import base64
import io
from collections import Counter, defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html import escape
from itertools import pairwise
from pathlib import Path

from scenelang.backends.base import frame_of, require
from scenelang.backends.files import write_text
from scenelang.backends.pictures.film import PictureOptions, render
from scenelang.backends.surfaces.appearance import word_color
from scenelang.grammar.diagnostics import SceneError, printable
from scenelang.interpreter.inspection.numbering import first_handles
from scenelang.interpreter.scene.bounds import entity_box
from scenelang.interpreter.scene.entity import Entity, Scene, descendants, instance_counts

MAX_NODES = 400  # that are drawn
_MAX_HANDLES = 2  # that are named in a node


@dataclass(frozen=True, slots=True, eq=False)
class Node:
    """A node of the graph: a class of equivalent entities.

    ``sample`` is one of the entities, ``distinct`` their number, ``instances`` the number of their instances in the
    scene; ``handles`` are those of their first instances.
    """

    word: str
    sample: Entity
    distinct: int
    instances: int
    handles: tuple[str, ...]

    @property
    def is_primitive(self) -> bool:
        """Whether its entities are primitives."""
        return self.sample.is_primitive


@dataclass(frozen=True, slots=True)
class Edge:
    """Every entity of node ``start`` has between ``least`` and ``most`` parts of node ``end``."""

    start: int
    end: int
    least: int
    most: int

    @property
    def label(self) -> str:
        """Multiplicity of the edge, empty for one."""
        if self.least != self.most:
            return f"×{self.least}–{self.most}"
        return f"×{self.most:,}" if self.most > 1 else ""


@dataclass(frozen=True, slots=True, eq=False)
class CallGraph:
    """The nodes, root first, and the edges in the order of the parts.

    ``hidden`` is the number of nodes omitted because they are below the requested depth or exceed ``MAX_NODES``.
    """

    nodes: tuple[Node, ...]
    edges: tuple[Edge, ...]
    hidden: int


def call_graph(scene: Scene, frame: int = 0, depth: int | None = None) -> CallGraph:
    """Return the computation graph of one frame, down to ``depth`` levels below the root (None: all)."""
    root = scene.frames[frame]
    order = list(descendants(root))
    kind = _kinds(order)
    instances = instance_counts(order)
    members: dict[int, list[Entity]] = defaultdict(list)
    for entity in order:
        members[kind[id(entity)]].append(entity)
    shown, hidden = _shown(kind[id(root)], members, kind, depth)
    number = {kind_number: i for i, kind_number in enumerate(shown)}
    handles = first_handles(scene, frame)
    nodes = [_node(members[one], instances, handles) for one in shown]
    edges = [edge for one in shown for edge in _edges(one, members[one], kind, number)]
    return CallGraph(tuple(nodes), tuple(edges), hidden)


def _kinds(order: list[Entity]) -> dict[int, int]:
    """Return the kind of every entity by ``id``; entities with equal words and equal kinds of parts have equal
    kinds."""
    numbers: dict[tuple[str, tuple[int, ...]], int] = {}
    kind: dict[int, int] = {}
    for entity in order:  # children first
        parts = tuple(sorted({kind[id(part.car)] for part in entity.children}))
        kind[id(entity)] = numbers.setdefault((entity.word, parts), len(numbers))
    return kind


def _shown(
    root: int, members: dict[int, list[Entity]], kind: dict[int, int], depth: int | None
) -> tuple[list[int], int]:
    """Return the kinds to draw, breadth first from the root, and the number of omitted kinds."""
    shown, level = [root], [root]
    while level and (depth is None or depth > 0) and len(shown) < MAX_NODES:
        parts = [kind[id(part.car)] for one in level for entity in members[one] for part in entity.children]
        level = [one for one in dict.fromkeys(parts) if one not in set(shown)][: MAX_NODES - len(shown)]
        shown += level
        depth = None if depth is None else depth - 1
    return shown, len(members) - len(shown)


def _node(entities: list[Entity], instances: dict[int, int], handles: dict[int, str]) -> Node:
    """Return the node of equivalent entities."""
    first = tuple(dict.fromkeys(handles[id(entity)] for entity in entities))
    shown = first[:_MAX_HANDLES] + (("…",) if len(first) > _MAX_HANDLES else ())
    total = sum(instances[id(entity)] for entity in entities)
    return Node(entities[0].word, entities[0], len(entities), total, shown)


def _edges(start: int, entities: list[Entity], kind: dict[int, int], number: dict[int, int]) -> list[Edge]:
    """Return the edges from a kind of entities to the kinds of their parts that are drawn."""
    counts = [Counter(kind[id(part.car)] for part in entity.children) for entity in entities]
    ends = dict.fromkeys(end for count in counts for end in count if end in number)
    return [
        Edge(number[start], number[end], min(count[end] for count in counts), max(count[end] for count in counts))
        for end in ends
    ]


# Layered graph layout (Sugiyama et al., 1981): rows by distance from the root, ordered to reduce crossings.


GAP_X, GAP_Y = 26.0, 64.0  # between nodes and rows, in SVG units
_PASSAGE_WIDTH = 4.0  # reserved for an edge that passes between nodes
_SWEEPS = 12  # down and up, alternately


@dataclass(frozen=True, slots=True)
class NodePosition:
    """Center and size of a node."""

    x: float
    y: float
    width: float
    height: float


@dataclass(frozen=True, slots=True)
class GraphLayout:
    """Positions of the nodes (``places``) and, for each edge, its waypoints between other nodes (``ways``)."""

    places: tuple[NodePosition, ...]
    ways: tuple[tuple[NodePosition, ...], ...]


def laid_out(sizes: Sequence[tuple[float, float]], edges: Sequence[tuple[int, int]]) -> GraphLayout:
    """Lay out nodes of ``sizes`` (width, height); the first is the root of the acyclic graph ``edges``.

    An edge that spans several rows gets a narrow dummy node in each row between, so that it crosses no node.
    """
    row_of = _rows(len(sizes), edges)
    all_sizes, short, passed = list(sizes), [], []
    for start, end in edges:
        between = []
        for row in range(row_of[start] + 1, row_of[end]):
            between.append(len(all_sizes))
            all_sizes.append((_PASSAGE_WIDTH, 0.0))
            row_of.append(row)
        chain = [start, *between, end]
        short += list(pairwise(chain))
        passed.append(between)
    places = _placed(all_sizes, short, row_of)
    ways = tuple(tuple(places[node] for node in between) for between in passed)
    return GraphLayout(tuple(places[: len(sizes)]), ways)


def _placed(
    sizes: Sequence[tuple[float, float]], edges: Sequence[tuple[int, int]], row_of: Sequence[int]
) -> list[NodePosition]:
    """Return the positions of nodes, given their rows.

    Each row is sorted by the mean position of its neighbors in the row before, down and up alternately (the barycenter
    heuristic).
    """
    rows: list[list[int]] = [[] for _ in range(max(row_of) + 1)]
    for node, row in enumerate(row_of):
        rows[row].append(node)
    above: dict[int, list[int]] = {node: [] for node in range(len(sizes))}
    below: dict[int, list[int]] = {node: [] for node in range(len(sizes))}
    for start, end in edges:
        above[end].append(start)
        below[start].append(end)
    for sweep in range(_SWEEPS):
        down = sweep % 2 == 0
        for row in range(len(rows)) if down else range(len(rows) - 1, -1, -1):
            rows[row] = _sorted_by_neighbors(rows[row], above if down else below, _positions(rows))
    x = _abscissae(rows, sizes, above, below)
    heights = [max(sizes[node][1] for node in row) for row in rows]
    tops = [sum(heights[:row]) + GAP_Y * row for row in range(len(rows))]
    return [
        NodePosition(x[node], tops[row_of[node]] + heights[row_of[node]] / 2.0, *sizes[node])
        for node in range(len(sizes))
    ]


def _rows(count: int, edges: Sequence[tuple[int, int]]) -> list[int]:
    """Return the row of each node: the length of the longest path from the root, so that all edges point down."""
    row = [0] * count
    waiting = [0] * count
    below: list[list[int]] = [[] for _ in range(count)]
    for start, end in edges:
        below[start].append(end)
        waiting[end] += 1
    ready = [node for node in range(count) if not waiting[node]]
    while ready:
        node = ready.pop()
        for end in below[node]:
            row[end] = max(row[end], row[node] + 1)
            waiting[end] -= 1
            if not waiting[end]:
                ready.append(end)
    return row


def _positions(rows: Sequence[Sequence[int]]) -> dict[int, float]:
    """Return the relative position of each node in its row, from 0 to 1."""
    return {node: (i + 0.5) / len(row) for row in rows for i, node in enumerate(row)}


def _sorted_by_neighbors(
    row: Sequence[int], neighbors: Mapping[int, Sequence[int]], positions: Mapping[int, float]
) -> list[int]:
    """Sort the nodes of a row by the mean positions of their neighbors."""

    def mean(node: int) -> float:
        """Return the mean position of the neighbors of a node, its own if it has none."""
        known = [positions[other] for other in neighbors[node]]
        return sum(known) / len(known) if known else positions[node]

    return sorted(row, key=mean)


def _abscissae(
    rows: Sequence[Sequence[int]],
    sizes: Sequence[tuple[float, float]],
    above: Mapping[int, Sequence[int]],
    below: Mapping[int, Sequence[int]],
) -> dict[int, float]:
    """Return the x coordinates of the nodes: near the mean of their neighbors, in row order, without overlap."""
    x: dict[int, float] = {}
    for row in rows:
        at = 0.0
        for node in row:
            x[node] = at + sizes[node][0] / 2.0
            at += sizes[node][0] + GAP_X
        for node in row:
            x[node] -= (at - GAP_X) / 2.0
    for sweep in range(_SWEEPS):
        for row in rows if sweep % 2 == 0 else rows[::-1]:
            near = above if sweep % 2 == 0 else below
            targets = [sum(x[o] for o in near[n]) / len(near[n]) if near[n] else x[n] for n in row]
            for node, at in zip(row, _apart(targets, [sizes[node][0] for node in row]), strict=True):
                x[node] = at
    return x


def _apart(targets: Sequence[float], widths: Sequence[float]) -> list[float]:
    """Return non-overlapping positions in order that minimize the squared distance to ``targets``.

    Pool adjacent violators: overlapping nodes are merged into blocks, each centered on its mean.
    """
    blocks: list[list[float]] = []  # [sum of target starts, number of nodes]
    offsets: list[float] = []
    at = 0.0
    for i, (place, width) in enumerate(zip(targets, widths, strict=True)):
        at += 0.0 if i == 0 else (widths[i - 1] + width) / 2.0 + GAP_X
        offsets.append(at)
        blocks.append([place - at, 1.0])
        while len(blocks) > 1 and blocks[-2][0] / blocks[-2][1] > blocks[-1][0] / blocks[-1][1]:
            total, count = blocks.pop()
            blocks[-1][0] += total
            blocks[-1][1] += count
    starts = [total / count for total, count in blocks for _ in range(int(count))]
    return [start + offset for start, offset in zip(starts, offsets, strict=True)]


# SVG output: words in boxes, handles below them, arrows with counts.


_FONT_SIZE = 14.0  # in SVG units, as all sizes here
_SMALL_FONT_SIZE = 11.0
_THUMBNAIL_SIZE = 72
_MARGIN = 18.0
_MAX_LABEL_LENGTH = 36  # characters
_LABEL_POSITIONS = (0.42, 0.58, 0.74)  # along arrows, in turn, so that labels of neighboring arrows do not overlap
_FAMILY = "ui-sans-serif, system-ui, 'Segoe UI', 'DejaVu Sans', sans-serif"
_LETTER_WIDTH = 0.6  # relative to the font size


def write_graph(
    scene: Scene, path: Path | str, frame: int | None = None, depth: int | None = None, thumbnails: bool = False
) -> None:
    """Write the computation graph of one frame to an SVG file, atomically; raises SceneError.

    With ``thumbnails``, each node shows a draft picture.
    """
    graph = call_graph(scene, frame_of(scene, frame), depth)
    pictures = [_thumbnail(node) if thumbnails else None for node in graph.nodes]
    text = drawing(graph, pictures)
    write_text(path, text)


def drawing(graph: CallGraph, pictures: Sequence[str | None]) -> str:
    """Return the SVG text; ``pictures`` are the nodes' PNG files in base64, or None."""
    sizes = [_size(node, picture) for node, picture in zip(graph.nodes, pictures, strict=True)]
    layout = laid_out(sizes, [(edge.start, edge.end) for edge in graph.edges])
    places = layout.places
    left = min(place.x - place.width / 2.0 for place in places) - _MARGIN
    right = max(place.x + place.width / 2.0 for place in places) + _MARGIN
    bottom = max(place.y + place.height / 2.0 for place in places) + _MARGIN + (24.0 if graph.hidden else 0.0)
    box = f"{left:.1f} {-_MARGIN:.1f} {right - left:.1f} {bottom + _MARGIN:.1f}"
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="{box}" width="{right - left:.0f}" '
        f'height="{bottom + _MARGIN:.0f}" font-family="{_FAMILY}">',
        f"<title>{escape(printable(graph.nodes[0].word))}</title>",
        '<defs><marker id="arrow" viewBox="0 0 8 8" refX="7.5" refY="4" markerWidth="7" markerHeight="7" '
        'orient="auto-start-reverse"><path d="M0 0.6 L8 4 L0 7.4 z" fill="#6b7280"/></marker></defs>',
        f'<rect x="{left:.1f}" y="{-_MARGIN:.1f}" width="100%" height="100%" fill="#ffffff"/>',
    ]
    lines += [
        _arrow(places[edge.start], places[edge.end], way, edge.label, number)
        for number, (edge, way) in enumerate(zip(graph.edges, layout.ways, strict=True))
    ]
    for node, place, picture in zip(graph.nodes, places, pictures, strict=True):
        lines += _box(node, place, picture)
    if graph.hidden:
        note = f"{graph.hidden} more not shown"
        lines.append(_text(left + _MARGIN, bottom - 8.0, note, _SMALL_FONT_SIZE, "#6b7280", "start"))
    return "\n".join([*lines, "</svg>", ""])


def _size(node: Node, picture: str | None) -> tuple[float, float]:
    """Return width and height of a node's box."""
    letters = max(len(_label(node.word)) * _FONT_SIZE, len(_handles(node)) * _SMALL_FONT_SIZE) * _LETTER_WIDTH
    height = 34.0 + (15.0 if node.handles else 0.0) + (_THUMBNAIL_SIZE + 4.0 if picture else 0.0)
    return max(letters + 26.0, 58.0, _THUMBNAIL_SIZE + 16.0 if picture else 0.0), height


def _label(word: str) -> str:
    """Return a word as printable text of limited length."""
    plain = "".join(c if c.isprintable() else " " for c in word)
    return plain if len(plain) <= _MAX_LABEL_LENGTH else plain[: _MAX_LABEL_LENGTH - 1] + "…"


def _handles(node: Node) -> str:
    """Return the text of a node's handles."""
    return " ".join(handle if handle == "…" else f"<{handle}>" for handle in node.handles)


def _box(node: Node, place: NodePosition, picture: str | None) -> list[str]:
    """Return the SVG elements of a node: box, thumbnail, word and handles."""
    x, y = place.x - place.width / 2.0, place.y - place.height / 2.0
    red, green, blue = word_color(node.word)
    fill = "#f8fafc" if node.is_primitive else f"rgba({red},{green},{blue},0.22)"
    radius = 4.0 if node.is_primitive else 10.0
    tooltip = f"{node.word}: {node.instances:,} instances, {node.distinct:,} distinct"
    lines = [
        "<g>",
        f"<title>{escape(printable(tooltip))}</title>",
        f'<rect x="{x:.1f}" y="{y:.1f}" width="{place.width:.1f}" height="{place.height:.1f}" rx="{radius}" '
        f'fill="#ffffff"/>',
        f'<rect x="{x:.1f}" y="{y:.1f}" width="{place.width:.1f}" height="{place.height:.1f}" rx="{radius}" '
        f'fill="{fill}" stroke="rgb({red},{green},{blue})" stroke-width="1.5"/>',
    ]
    at = y + 22.0
    if picture:
        lines.append(
            f'<image x="{place.x - _THUMBNAIL_SIZE / 2:.1f}" y="{y + 6:.1f}" '
            f'width="{_THUMBNAIL_SIZE}" height="{_THUMBNAIL_SIZE}" '
            f'href="data:image/png;base64,{picture}"/>'
        )
        at += _THUMBNAIL_SIZE + 2.0
    lines.append(_text(place.x, at, _label(node.word), _FONT_SIZE, "#111827", "middle"))
    if node.handles:
        lines.append(_text(place.x, at + 16.0, _handles(node), _SMALL_FONT_SIZE, "#6b7280", "middle"))
    return [*lines, "</g>"]


def _arrow(start: NodePosition, end: NodePosition, way: Sequence[NodePosition], label: str, number: int) -> str:
    """Draw a curve from the bottom of one box to the top of another, vertical at the waypoints ``way``.

    The label is on the last segment, at a height that varies with ``number`` so that neighboring labels do not
    overlap.
    """
    points = [(start.x, start.y + start.height / 2.0), *((p.x, p.y) for p in way), (end.x, end.y - end.height / 2.0)]
    path = f"M{points[0][0]:.1f} {points[0][1]:.1f}"
    for (x0, y0), (x1, y1) in pairwise(points):
        bend = (y1 - y0) / 2.0
        path += f" C{x0:.1f} {y0 + bend:.1f} {x1:.1f} {y1 - bend:.1f} {x1:.1f} {y1:.1f}"
    line = f'<path d="{path}" fill="none" stroke="#9ca3af" stroke-width="1.3" marker-end="url(#arrow)"/>'
    if not label:
        return line
    (x0, y0), (x1, y1) = points[-2:]
    t = _LABEL_POSITIONS[number % len(_LABEL_POSITIONS)]
    share = 3.0 * t * t - 2.0 * t**3
    x, y = x0 + (x1 - x0) * share, y0 + (y1 - y0) * (1.5 * t * (1.0 - t) + t**3)
    shown = _text(x, y + 4.0, label, _SMALL_FONT_SIZE, "#374151", "middle")
    return line + shown.replace("<text ", '<text stroke="#fff" stroke-width="4" paint-order="stroke" ', 1)


def _text(x: float, y: float, text: str, size: float, color: str, anchor: str) -> str:
    """Return an SVG text element."""
    shown = escape(printable(text))
    return f'<text x="{x:.1f}" y="{y:.1f}" font-size="{size:g}" fill="{color}" text-anchor="{anchor}">{shown}</text>'


def _thumbnail(node: Node) -> str | None:
    """Return a small draft picture of a node's entity as base64 PNG, or None if nothing of the entity is visible."""
    if entity_box(node.sample) is None:
        return None
    side = 2 * _THUMBNAIL_SIZE
    try:
        picture = render(Scene(node.word, [node.sample], False), PictureOptions(width=side, height=side, labels=False))
    except SceneError as error:
        if error.name != "empty-scene":  # all of it is transparent
            raise
        return None
    out = io.BytesIO()
    require("PIL.Image", "pillow").fromarray(picture).quantize(128).save(out, "PNG", optimize=True)
    return base64.b64encode(out.getvalue()).decode("ascii")
