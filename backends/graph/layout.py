"""Where the nodes of a computation graph stand: in rows by their distance from the root, with few crossings."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

GAP_X, GAP_Y = 26.0, 64.0
_PASSAGE = 4.0  # the width of an edge among nodes
_SWEEPS = 12


@dataclass(frozen=True, slots=True)
class Place:
    """The middle of a node, and its size."""

    x: float
    y: float
    width: float
    height: float


@dataclass(frozen=True, slots=True)
class Layout:
    """``places`` of the nodes; ``ways`` of the edges, the places between nodes that each passes."""

    places: tuple[Place, ...]
    ways: tuple[tuple[Place, ...], ...]


def laid_out(sizes: Sequence[tuple[float, float]], edges: Sequence[tuple[int, int]]) -> Layout:
    """The layout of nodes of ``sizes`` (width, height), the first of which is the root of the acyclic ``edges``.

    An edge over several rows passes a narrow place of its own in each row between, so that it crosses no node.
    """
    row_of = _rows(len(sizes), edges)
    all_sizes, short, passed = list(sizes), [], []
    for start, end in edges:
        between = []
        for row in range(row_of[start] + 1, row_of[end]):
            between.append(len(all_sizes))
            all_sizes.append((_PASSAGE, 0.0))
            row_of.append(row)
        chain = [start, *between, end]
        short += list(pairwise(chain))
        passed.append(between)
    places = _placed(all_sizes, short, row_of)
    ways = tuple(tuple(places[node] for node in between) for between in passed)
    return Layout(tuple(places[: len(sizes)]), ways)


def _placed(
    sizes: Sequence[tuple[float, float]], edges: Sequence[tuple[int, int]], row_of: Sequence[int]
) -> list[Place]:
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
            rows[row] = _sorted_by_neighbours(rows[row], above if down else below, _positions(rows))
    x = _abscissae(rows, sizes, above, below)
    heights = [max(sizes[node][1] for node in row) for row in rows]
    tops = [sum(heights[:row]) + GAP_Y * row for row in range(len(rows))]
    return [
        Place(x[node], tops[row_of[node]] + heights[row_of[node]] / 2.0, *sizes[node]) for node in range(len(sizes))
    ]


def _rows(count: int, edges: Sequence[tuple[int, int]]) -> list[int]:
    """The longest way from the root to each node, so that all edges point down."""
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
    """How far along its row each node stands, from 0 to 1."""
    return {node: (i + 0.5) / len(row) for row in rows for i, node in enumerate(row)}


def _sorted_by_neighbours(
    row: Sequence[int], neighbours: Mapping[int, Sequence[int]], positions: Mapping[int, float]
) -> list[int]:
    def mean(node: int) -> float:
        known = [positions[other] for other in neighbours[node]]
        return sum(known) / len(known) if known else positions[node]

    return sorted(row, key=mean)


def _abscissae(
    rows: Sequence[Sequence[int]],
    sizes: Sequence[tuple[float, float]],
    above: Mapping[int, Sequence[int]],
    below: Mapping[int, Sequence[int]],
) -> dict[int, float]:
    """The middles of the nodes: near their neighbours' mean, in the order of their rows, without overlap."""
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
            wanted = [sum(x[o] for o in near[n]) / len(near[n]) if near[n] else x[n] for n in row]
            for node, at in zip(row, _apart(wanted, [sizes[node][0] for node in row]), strict=True):
                x[node] = at
    return x


def _apart(wanted: Sequence[float], widths: Sequence[float]) -> list[float]:
    """Places in order, as near to the ``wanted`` ones as not overlapping allows: those that push form blocks, each
    about its own mean."""
    blocks: list[list[float]] = []  # [sum of wanted starts, nodes, place of the first]
    offsets: list[float] = []
    at = 0.0
    for i, (place, width) in enumerate(zip(wanted, widths, strict=True)):
        at += 0.0 if i == 0 else (widths[i - 1] + width) / 2.0 + GAP_X
        offsets.append(at)
        blocks.append([place - at, 1.0])
        while len(blocks) > 1 and blocks[-2][0] / blocks[-2][1] > blocks[-1][0] / blocks[-1][1]:
            total, count = blocks.pop()
            blocks[-1][0] += total
            blocks[-1][1] += count
    starts = [total / count for total, count in blocks for _ in range(int(count))]
    return [start + offset for start, offset in zip(starts, offsets, strict=True)]
