"""Every instance of every entity of a scene, numbered, and the way from each primitive up to the root."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from scenelang.interpreter.entity import Entity
from scenelang.interpreter.flatten import Graph, Level, Paths, graph_of, levels

if TYPE_CHECKING:
    import numpy.typing as npt

    IntArray = npt.NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False)
class Ancestry:
    """The M instances that are primitives or have primitives below them, level by level from the root, number 0.

    ``nodes[node[i]]`` is the entity of instance i, ``parent[i]`` its parent (-1 for the root), ``position[i]`` its
    place among the parent's children, ``depth[i]`` how far it is from the root, ``poses[i]`` (3, 4) where it stands in
    the world. ``primitives[k]`` (N,) is the instance that the k-th primitive of the flattened frame is.
    """

    nodes: tuple[Entity, ...]
    node: IntArray  # (M,)
    parent: IntArray  # (M,)
    position: IntArray  # (M,)
    depth: IntArray  # (M,)
    poses: npt.NDArray[np.float64]  # (M, 3, 4)
    primitives: IntArray  # (N,)

    def __len__(self) -> int:
        return len(self.node)

    @property
    def deepest(self) -> int:
        return int(self.depth.max())

    def entity(self, instance: int) -> Entity:
        return self.nodes[int(self.node[instance])]

    def at_depth(self, depth: int) -> IntArray:
        """For every instance (M,) its ancestor at ``depth``; itself where it stands higher than that."""
        found = np.arange(len(self))
        while True:
            deeper = np.flatnonzero(self.depth[found] > depth)
            if not len(deeper):
                return found
            found[deeper] = self.parent[found[deeper]]

    def path(self, instance: int) -> tuple[int, ...]:
        """The child positions from the root to an instance."""
        found: list[int] = []
        while self.parent[instance] >= 0:
            found.append(int(self.position[instance]))
            instance = int(self.parent[instance])
        return tuple(reversed(found))


def ancestry_of(root: Entity) -> Ancestry:
    """Number every instance below and including ``root``. The caller has checked the number of primitives."""
    graph = graph_of(root, frozenset())
    is_leaf = np.array([entity.is_primitive for entity in graph.nodes])
    found = list(levels(graph, is_leaf, Paths(graph.nodes)))
    return _joined(graph, found)


def _joined(graph: Graph, found: list[tuple[Level, Level]]) -> Ancestry:
    """The levels one after the other, at each depth the opened instances before the leaves."""
    node, parent, position, depth, poses = [], [], [], [], []
    primitives = np.zeros(int(graph.leaves[-1]), np.int64)
    above, start = 0, 0  # where the opened instances of the level above begin, and this level
    for number, (leaves, inner) in enumerate(found):
        primitives[leaves.offset] = start + len(inner.node) + np.arange(len(leaves.node))
        for part in (inner, leaves):
            node.append(part.node)
            parent.append(part.parent + above if number else np.full(len(part.node), -1, np.int64))
            position.append(part.position)
            depth.append(np.full(len(part.node), number, np.int64))
            poses.append(part.pose.T.reshape(-1, 3, 4))
        above, start = start, start + len(inner.node) + len(leaves.node)
    return Ancestry(
        tuple(graph.nodes),
        np.concatenate(node),
        np.concatenate(parent),
        np.concatenate(position),
        np.concatenate(depth),
        np.concatenate(poses),
        primitives,
    )
