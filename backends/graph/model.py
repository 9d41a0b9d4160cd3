"""The computation graph of a scene: what calls what, how often, under which handles (paper, Figure 2).

Entities of one word whose parts are alike are one node, so that sixty-four squares of two colours are one, while each
level of a recursion is a node of its own.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from dataclasses import dataclass

from scenelang.interpreter.entity import Entity, Scene, descendants, instance_counts
from scenelang.interpreter.numbering import first_handles

MOST_NODES = 400
_MOST_HANDLES = 2


@dataclass(frozen=True, slots=True, eq=False)
class Node:
    """``sample`` is one of the entities that the node stands for, ``distinct`` how many there are, ``instances`` how
    often they stand in the scene; ``handles`` are those of the first of them."""

    word: str
    sample: Entity
    distinct: int
    instances: int
    handles: tuple[str, ...]

    @property
    def is_primitive(self) -> bool:
        return self.sample.is_primitive


@dataclass(frozen=True, slots=True)
class Edge:
    """One entity of node ``start`` has from ``least`` to ``most`` parts of node ``end``."""

    start: int
    end: int
    least: int
    most: int

    @property
    def label(self) -> str:
        """How often, where it is more than once."""
        if self.least != self.most:
            return f"×{self.least}–{self.most}"
        return f"×{self.most:,}" if self.most > 1 else ""


@dataclass(frozen=True, slots=True, eq=False)
class CallGraph:
    """Nodes with the root first, and edges between them in the order of the parts. ``hidden`` nodes lie below the depth
    that was asked for, or beyond ``MOST_NODES``."""

    nodes: tuple[Node, ...]
    edges: tuple[Edge, ...]
    hidden: int


def call_graph(scene: Scene, frame: int = 0, depth: int | None = None) -> CallGraph:
    """The computation graph of one frame, as far as ``depth`` levels below the root."""
    root = scene.frames[frame]
    order = list(descendants(root))
    kind = _kinds(order)
    instances = instance_counts(order)
    members: dict[int, list[Entity]] = defaultdict(list)
    for entity in order:
        members[kind[id(entity)]].append(entity)
    shown, hidden = _shown(kind[id(root)], members, kind, depth)
    number = {one: i for i, one in enumerate(shown)}
    handles = first_handles(scene, frame)
    nodes = [_node(members[one], instances, handles) for one in shown]
    edges = [edge for one in shown for edge in _edges(one, members[one], kind, number)]
    return CallGraph(tuple(nodes), tuple(edges), hidden)


def _kinds(order: list[Entity]) -> dict[int, int]:
    """A number for every entity by ``id``: equal where words and the kinds of the parts are equal."""
    numbers: dict[tuple[str, tuple[int, ...]], int] = {}
    kind: dict[int, int] = {}
    for entity in order:  # children first
        parts = tuple(sorted({kind[id(part.car)] for part in entity.children}))
        kind[id(entity)] = numbers.setdefault((entity.word, parts), len(numbers))
    return kind


def _shown(
    root: int, members: dict[int, list[Entity]], kind: dict[int, int], depth: int | None
) -> tuple[list[int], int]:
    """The kinds that are drawn, level by level from the root, and how many are not."""
    shown, level = [root], [root]
    while level and (depth is None or depth > 0) and len(shown) < MOST_NODES:
        parts = [kind[id(part.car)] for one in level for entity in members[one] for part in entity.children]
        level = [one for one in dict.fromkeys(parts) if one not in set(shown)][: MOST_NODES - len(shown)]
        shown += level
        depth = None if depth is None else depth - 1
    return shown, len(members) - len(shown)


def _node(entities: list[Entity], instances: dict[int, int], handles: dict[int, str]) -> Node:
    first = tuple(dict.fromkeys(handles[id(entity)] for entity in entities))
    shown = first[:_MOST_HANDLES] + (("…",) if len(first) > _MOST_HANDLES else ())
    total = sum(instances[id(entity)] for entity in entities)
    return Node(entities[0].word, entities[0], len(entities), total, shown)


def _edges(start: int, entities: list[Entity], kind: dict[int, int], number: dict[int, int]) -> list[Edge]:
    counts = [Counter(kind[id(part.car)] for part in entity.children) for entity in entities]
    ends = dict.fromkeys(end for count in counts for end in count if end in number)
    return [
        Edge(number[start], number[end], min(count[end] for count in counts), max(count[end] for count in counts))
        for end in ends
    ]
