"""Flattening: from the entity DAG to primitives with world matrices, vectorised by level of the DAG.

The pose of a primitive is the product of the matrices from the root (paper, section 4). Order is depth first. Blocks
begin at whole cells: the positions of Minecraft's primitives are truncated toward zero, as the paper's tool does.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence, Set
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from scenelang.grammar.diagnostics import LimitError, SceneError
from scenelang.interpreter.runtime.values import IDENTITY
from scenelang.interpreter.scene.entity import Entity, Scene, descendants, primitive_count

if TYPE_CHECKING:
    import numpy.typing as npt

    IntArray = npt.NDArray[np.int64]
    Poses = npt.NDArray[np.float64]  # (12, N): row-major affine poses, one a column


DEFAULT_LIMIT = 5_000_000
_CHUNK = 1 << 13


@dataclass(frozen=True, slots=True, eq=False)
class FlatFrame:
    """One frame's primitives.

    ``primitives`` are the distinct primitive entities (use ``.shape``, ``.embedding``, ``.word``); instance ``i`` is
    ``primitives[index[i]]`` under ``matrices[i]``, the upper three rows of its world matrix. ``paths[path_index[i]]``
    are the words from the root down to the primitive's parent. ``ranks[i]`` is the instance's place among the
    entities without a handle in depth-first pre-order, from 1 (0 where its embedding has a handle).
    """

    primitives: tuple[Entity, ...]
    index: IntArray  # (N,)
    matrices: npt.NDArray[np.float64]  # (N, 3, 4)
    path_index: IntArray  # (N,)
    paths: tuple[tuple[str, ...], ...]
    ranks: IntArray  # (N,)

    def __len__(self) -> int:
        return len(self.index)

    def only(self, which: npt.NDArray[np.bool_]) -> FlatFrame:
        """The frame with the instances that the mask ``which`` (N,) selects."""
        used, index = _distinct(self.index[which])
        primitives = tuple(self.primitives[i] for i in used)
        return FlatFrame(primitives, index, self.matrices[which], self.path_index[which], self.paths, self.ranks[which])


@dataclass(frozen=True, slots=True, eq=False)
class FlatScene:
    """The flattened scene: one ``FlatFrame`` per frame (a static scene has one)."""

    word: str
    frames: tuple[FlatFrame, ...]
    animated: bool


def flatten(scene: Scene, limit: int = DEFAULT_LIMIT) -> FlatScene:
    """Flatten every frame; raises LimitError when the scene has more than ``limit`` primitives in all."""
    total = sum(primitive_count(root) for root in scene.frames)
    if total > limit:
        raise LimitError(
            "primitives",
            f"the scene expands to {total:,} primitives, more than the limit of {limit:,}",
            hint="raise it with --max-primitives, or look at fewer: `count` and `bounds` never expand",
        )
    frames = tuple(flatten_entity(root) for root in scene.frames)
    if not all(np.isfinite(frame.matrices).all() for frame in frames):
        raise SceneError("pose", "pose overflow: coordinates exceed the float range")
    return FlatScene(scene.word, frames, scene.animated)


@dataclass(frozen=True, slots=True, eq=False)
class Graph:
    """The DAG as arrays: the edges of node ``n`` are ``start[n]:start[n + 1]``."""

    nodes: list[Entity]
    start: IntArray  # (V + 1,)
    child: IntArray  # (E,)
    pose: Poses  # (12, E)
    leaves: IntArray  # (V,) primitives below each node
    unhandled: IntArray  # (V,) instances below and including each node whose embedding has no handle
    leaf_offset: IntArray  # (E,) leaves of the earlier siblings
    rank_offset: IntArray  # (E,) unhandled instances of the earlier siblings


def graph_of(root: Entity, cut: Set[int]) -> Graph:
    nodes = list(descendants(root))
    number = {id(entity): i for i, entity in enumerate(nodes)}
    start = np.zeros(len(nodes) + 1, np.int64)
    np.cumsum([len(entity.children) for entity in nodes], out=start[1:])
    parts = [part for entity in nodes for part in entity.children]
    child = np.fromiter((number[id(part.car)] for part in parts), np.int64, len(parts))
    pose = np.ascontiguousarray(np.array([part.cdr for part in parts], np.float64).reshape(len(parts), 12).T)
    leaves = [0] * len(nodes)
    unhandled = [0] * len(nodes)
    leaf_offset = np.zeros(len(parts), np.int64)
    rank_offset = np.zeros(len(parts), np.int64)
    edge = 0
    for i, entity in enumerate(nodes):
        leaf_sum = rank_sum = 0
        for part in entity.children:
            j = number[id(part.car)]
            leaf_offset[edge], rank_offset[edge] = leaf_sum, rank_sum
            leaf_sum += leaves[j]
            rank_sum += unhandled[j]
            edge += 1
        leaves[i] = 1 if id(entity) in cut else leaf_sum + entity.is_primitive
        unhandled[i] = rank_sum + (entity.embedding.handle is None)
    return Graph(
        nodes, start, child, pose, np.array(leaves, np.int64), np.array(unhandled, np.int64), leaf_offset, rank_offset
    )


def compose_many(parents: Poses, parent: IntArray, children: Poses, child: IntArray) -> Poses:
    """``parents[:, parent] @ children[:, child]`` column by column, (12, N); in chunks that stay in the cache."""
    out = np.empty((12, len(parent)))
    with np.errstate(over="ignore", invalid="ignore"):  # the caller tells what became infinite
        _compose_chunks(parents, parent, children, child, out)
    return out


def _compose_chunks(parents: Poses, parent: IntArray, children: Poses, child: IntArray, out: Poses) -> None:
    for lo in range(0, len(parent), _CHUNK):
        p = parents.take(parent[lo : lo + _CHUNK], axis=1)
        c = children.take(child[lo : lo + _CHUNK], axis=1)
        o = out[:, lo : lo + _CHUNK]
        for row in range(0, 12, 4):
            for column in range(4):
                o[row + column] = p[row] * c[column] + p[row + 1] * c[column + 4] + p[row + 2] * c[column + 8]
            o[row + 3] += p[row + 3]


class Paths:
    """Paths of words as numbers, so that a level is extended at once."""

    def __init__(self, nodes: Sequence[Entity]) -> None:
        words: dict[str, int] = {}
        self.word_of = np.array([words.setdefault(entity.word, len(words)) for entity in nodes], np.int64)
        self.words = list(words)
        self.parents: list[tuple[int, int]] = [(0, 0)]  # of each path: the path without its last word, that word
        self._numbers: dict[tuple[int, int], int] = {}

    def extend(self, path: IntArray, node: IntArray) -> IntArray:
        """For each instance, the number of its path plus its own word."""
        key = path * len(self.words) + self.word_of[node]
        unique, inverse = np.unique(key, return_inverse=True)
        numbers = [self._number(int(k) // len(self.words), int(k) % len(self.words)) for k in unique]
        return np.array(numbers, np.int64)[inverse]

    def _number(self, path: int, word: int) -> int:
        found = self._numbers.get((path, word))
        if found is None:
            found = self._numbers[path, word] = len(self.parents)
            self.parents.append((path, word))
        return found

    def spelled(self, path: int) -> tuple[str, ...]:
        """The words of a path."""
        found: list[str] = []
        while path:
            path, word = self.parents[path]
            found.append(self.words[word])
        return tuple(reversed(found))


@dataclass(frozen=True, slots=True, eq=False)
class Level:
    """Instances at one depth: node, pose, place among the leaves, unhandled instances before, path of words, the
    parent's row among the opened instances of the level above and the place among its children."""

    node: IntArray
    pose: Poses
    offset: IntArray
    rank: IntArray
    path: IntArray
    parent: IntArray
    position: IntArray

    def only(self, mask: npt.NDArray[np.bool_]) -> Level:
        if mask.all():
            return self
        return Level(
            self.node[mask],
            self.pose[:, mask],
            self.offset[mask],
            self.rank[mask],
            self.path[mask],
            self.parent[mask],
            self.position[mask],
        )


def _below(graph: Graph, level: Level, paths: Paths, has_handle: npt.NDArray[np.bool_]) -> Level:
    """The children of a level's instances, as far as primitives are below them."""
    path = paths.extend(level.path, level.node)
    rank = level.rank + ~has_handle[level.node]
    first = graph.start[level.node]
    fan = graph.start[level.node + 1] - first
    parent = np.repeat(np.arange(len(level.node)), fan)
    edge = np.arange(len(parent)) - np.repeat(np.cumsum(fan) - fan - first, fan)
    keep = graph.leaves[graph.child[edge]] > 0
    if not keep.all():
        parent, edge = parent[keep], edge[keep]
    return Level(
        graph.child[edge],
        compose_many(level.pose, parent, graph.pose, edge),
        level.offset[parent] + graph.leaf_offset[edge],
        rank[parent] + graph.rank_offset[edge],
        path[parent],
        parent,
        edge - first[parent],
    )


def levels(graph: Graph, is_leaf: npt.NDArray[np.bool_], paths: Paths) -> Iterator[tuple[Level, Level]]:
    """The leaves and the opened instances at each depth, from the root down."""
    has_handle = np.array([entity.embedding.handle is not None for entity in graph.nodes])
    zero = np.zeros(1, np.int64)
    identity = np.array(IDENTITY).reshape(12, 1)
    root = np.array([len(graph.nodes) - 1], np.int64)
    level = Level(root, identity, zero, zero, zero, zero, zero)
    while len(level.node):
        leaf = is_leaf[level.node]
        inner = level.only(~leaf & (graph.leaves[level.node] > 0))
        yield level.only(leaf), inner
        if not len(inner.node):
            return
        level = _below(graph, inner, paths, has_handle)


def flatten_entity(root: Entity, cut: Set[int] = frozenset(), whole_cells: bool = True) -> FlatFrame:
    """Flatten one entity; its own pose is the identity. The caller has checked the number of primitives.

    Entities whose ``id`` is in ``cut`` are not opened: they stand among the primitives. ``whole_cells=False`` leaves
    blocks where their poses put them, for an entity that is only a part of a scene.
    """
    graph = graph_of(root, cut)
    is_leaf = np.array([entity.is_primitive or id(entity) in cut for entity in graph.nodes])
    paths = Paths(graph.nodes)
    found = [leaves for leaves, _ in levels(graph, is_leaf, paths) if len(leaves.node)]
    leaves = _in_order(found, int(graph.leaves[-1]))
    used, index = _distinct(leaves.node)
    used_paths, path_index = _distinct(leaves.path)
    matrices = leaves.pose.T.reshape(-1, 3, 4)
    has_handle = np.array([entity.embedding.handle is not None for entity in graph.nodes])
    is_block = np.array([graph.nodes[i].is_block for i in used])
    if whole_cells and is_block.any():
        matrices = np.ascontiguousarray(matrices)
        rows = is_block[index]
        matrices[rows, :, 3] = np.trunc(matrices[rows, :, 3]) + 0.0  # no negative zeros
    return FlatFrame(
        tuple(graph.nodes[i] for i in used),
        index,
        matrices,
        path_index,
        tuple(paths.spelled(int(path)) for path in used_paths),
        np.where(has_handle[leaves.node], 0, leaves.rank + 1),
    )


def _distinct(numbers: IntArray) -> tuple[IntArray, IntArray]:
    """The distinct small numbers, ascending, and for each item its place among them."""
    used = np.flatnonzero(np.bincount(numbers))
    place = np.zeros(int(used[-1]) + 1 if len(used) else 0, np.int64)
    place[used] = np.arange(len(used))
    return used, place[numbers]


def _in_order(found: list[Level], total: int) -> Level:
    """The leaves of all levels, depth first; of parents and positions only one level of leaves has sensible ones."""
    if len(found) == 1:  # one level of leaves is in order already
        return found[0]
    columns = {name: np.zeros(total, np.int64) for name in ("node", "offset", "rank", "path", "parent", "position")}
    pose = np.zeros((12, total))
    for level in found:
        pose[:, level.offset] = level.pose
        for name, column in columns.items():
            column[level.offset] = getattr(level, name)
    return Level(pose=pose, **columns)
