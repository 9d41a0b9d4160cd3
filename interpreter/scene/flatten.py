"""Flattening of the entity DAG to primitives with world matrices, vectorized by DAG level.

The pose of a primitive is the product of the matrices on the path from the root (paper, section 4). The order is
depth-first. Minecraft blocks start at whole cells: their positions are truncated toward zero, as in the paper's tool.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence, Set
from dataclasses import dataclass
from typing import TYPE_CHECKING

from scenelang.grammar.diagnostics import LimitError, SceneError
from scenelang.interpreter.loading import np
from scenelang.interpreter.scene.entity import Entity, Scene, descendants, primitive_count
from scenelang.interpreter.scene.pose import stacked
from scenelang.interpreter.values.values import IDENTITY

if TYPE_CHECKING:
    import numpy.typing as npt

    IntArray = npt.NDArray[np.int64]
    Poses = npt.NDArray[np.float64]  # (12, N): row-major affine poses, one a column


DEFAULT_LIMIT = 5_000_000  # primitives, as in ``Limits``
_CHUNK_POSES = 1 << 13  # poses multiplied at a time: 12 columns of doubles (786 kB) that stay in the L2 cache


@dataclass(frozen=True, slots=True, eq=False)
class FlatFrame:
    """Primitives of one frame, N instances in depth-first order.

    Attributes
    ----------
    primitives
        Distinct primitive entities (see ``.shape``, ``.embedding``, ``.word``).
    index : (N,)
        Instance ``i`` is ``primitives[index[i]]``.
    matrices : (N, 3, 4)
        Upper three rows of the world matrices.
    paths, path_index : (N,)
        ``paths[path_index[i]]`` are the words from the root to the parent of the primitive.
    ranks : (N,)
        Position of the instance among the entities without a handle in depth-first pre-order, counted from 1; 0 if its
        embedding has a handle.
    """

    primitives: tuple[Entity, ...]
    index: IntArray  # (N,)
    matrices: npt.NDArray[np.float64]  # (N, 3, 4)
    path_index: IntArray  # (N,)
    paths: tuple[tuple[str, ...], ...]
    ranks: IntArray  # (N,)

    def __len__(self) -> int:
        return len(self.index)

    def select(self, mask: npt.NDArray[np.bool_]) -> FlatFrame:
        """Return the frame restricted to the instances that ``mask`` (N,) selects."""
        used, index = _distinct(self.index[mask])
        primitives = tuple(self.primitives[i] for i in used)
        return FlatFrame(primitives, index, self.matrices[mask], self.path_index[mask], self.paths, self.ranks[mask])


@dataclass(frozen=True, slots=True, eq=False)
class FlatScene:
    """Flattened scene with one ``FlatFrame`` per frame; a static scene has one."""

    word: str
    frames: tuple[FlatFrame, ...]
    animated: bool


def flatten(scene: Scene, limit: int = DEFAULT_LIMIT) -> FlatScene:
    """Flatten every frame of a scene.

    Parameters
    ----------
    scene
        Result of a program.
    limit
        Maximum number of primitives of all frames together; it is counted on the DAG before anything is expanded.

    Raises
    ------
    LimitError
        "primitives" if the frames have more than ``limit`` primitives in total.
    SceneError
        "pose" if a world matrix overflows.
    """
    total = sum(primitive_count(root) for root in scene.frames)
    if total > limit:
        raise LimitError(
            "primitives",
            f"the scene expands to {total:,} primitives, more than the limit of {limit:,}",
            hint="raise the limit with `--max-primitives`, or use `count` or `bounds`, which do not expand the scene",
        )
    frames = tuple(flatten_entity(root) for root in scene.frames)
    if not all(np.isfinite(frame.matrices).all() for frame in frames):
        raise SceneError("pose", "pose overflow: coordinates exceed the float range")
    return FlatScene(scene.word, frames, scene.animated)


@dataclass(frozen=True, slots=True, eq=False)
class Graph:
    """The DAG as arrays, V nodes and E edges; the edges of node ``n`` are ``start[n]:start[n + 1]``."""

    nodes: list[Entity]
    start: IntArray  # (V + 1,)
    child: IntArray  # (E,)
    pose: Poses  # (12, E)
    leaves: IntArray  # (V,) number of primitives below each node
    unhandled: IntArray  # (V,) instances below and including each node whose embedding has no handle
    leaf_offset: IntArray  # (E,) number of leaves below the earlier siblings
    rank_offset: IntArray  # (E,) unhandled instances of the earlier siblings


def graph_of(root: Entity, opaque: Set[int]) -> Graph:
    """Convert the DAG below ``root`` to arrays; entities whose ``id`` is in ``opaque`` are leaves."""
    nodes = list(descendants(root))
    number = {id(entity): i for i, entity in enumerate(nodes)}
    start = np.zeros(len(nodes) + 1, np.int64)
    np.cumsum([len(entity.children) for entity in nodes], out=start[1:])
    parts = [part for entity in nodes for part in entity.children]
    child = np.fromiter((number[id(part.car)] for part in parts), np.int64, len(parts))
    pose = np.ascontiguousarray(stacked([part.cdr for part in parts]).T)
    # Nodes come children first, so one pass sums what is below each node and before each edge.
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
        leaves[i] = 1 if id(entity) in opaque else leaf_sum + entity.is_primitive
        unhandled[i] = rank_sum + (entity.embedding.handle is None)
    return Graph(
        nodes, start, child, pose, np.array(leaves, np.int64), np.array(unhandled, np.int64), leaf_offset, rank_offset
    )


def compose_many(parents: Poses, parent: IntArray, children: Poses, child: IntArray) -> Poses:
    """Multiply N pairs of poses.

    Parameters
    ----------
    parents, children : (12, P), (12, C)
        Poses, one in a column.
    parent, child : (N,)
        Columns to multiply.

    Returns
    -------
    array (12, N)
        The products ``parents[:, parent] @ children[:, child]``, computed in chunks that fit the cache; infinite where
        they overflow, which the caller reports.
    """
    out = np.empty((12, len(parent)))
    with np.errstate(over="ignore", invalid="ignore"):  # the caller reports overflow
        _compose_chunks(parents, parent, children, child, out)
    return out


def _compose_chunks(parents: Poses, parent: IntArray, children: Poses, child: IntArray, out: Poses) -> None:
    """Write the products into ``out``: the same twelve sums of products as in ``pose.compose``, each over a chunk."""
    for lo in range(0, len(parent), _CHUNK_POSES):
        p = parents.take(parent[lo : lo + _CHUNK_POSES], axis=1)
        c = children.take(child[lo : lo + _CHUNK_POSES], axis=1)
        o = out[:, lo : lo + _CHUNK_POSES]
        for row in range(0, 12, 4):
            for column in range(4):
                o[row + column] = p[row] * c[column] + p[row + 1] * c[column + 4] + p[row + 2] * c[column + 8]
            o[row + 3] += p[row + 3]


class Paths:
    """Paths of words, interned as integers so that a whole level is extended at once."""

    def __init__(self, nodes: Sequence[Entity]) -> None:
        """Number the words of the nodes of a graph; path 0 is the empty one."""
        words: dict[str, int] = {}
        self.word_of = np.array([words.setdefault(entity.word, len(words)) for entity in nodes], np.int64)
        self.words = list(words)
        self.parents: list[tuple[int, int]] = [(0, 0)]  # for each path: its prefix, its last word
        self._numbers: dict[tuple[int, int], int] = {}

    def extend(self, path: IntArray, node: IntArray) -> IntArray:
        """Return for each instance the path extended by its own word."""
        key = path * len(self.words) + self.word_of[node]
        unique, inverse = np.unique(key, return_inverse=True)
        numbers = [self._number(int(k) // len(self.words), int(k) % len(self.words)) for k in unique]
        return np.array(numbers, np.int64)[inverse]

    def _number(self, path: int, word: int) -> int:
        """Return the number of a path extended by a word; it is new if the pair is."""
        number = self._numbers.get((path, word))
        if number is None:
            number = self._numbers[path, word] = len(self.parents)
            self.parents.append((path, word))
        return number

    def words_along(self, path: int) -> tuple[str, ...]:
        """Return the words of a path."""
        words: list[str] = []
        while path:
            path, word = self.parents[path]
            words.append(self.words[word])
        return tuple(reversed(words))


@dataclass(frozen=True, slots=True, eq=False)
class Level:
    """Instances at one depth, N rows.

    Attributes
    ----------
    node : (N,)
        Node of the graph.
    pose : (12, N)
        World pose.
    offset : (N,)
        Index among the leaves in depth-first order.
    rank : (N,)
        Number of unhandled instances before it in pre-order.
    path : (N,)
        Path of words.
    parent : (N,)
        Row of the parent among the inner instances of the level above.
    position : (N,)
        Index among the children of the parent.
    """

    node: IntArray
    pose: Poses
    offset: IntArray
    rank: IntArray
    path: IntArray
    parent: IntArray
    position: IntArray

    def select(self, mask: npt.NDArray[np.bool_]) -> Level:
        """Return the instances that ``mask`` (N,) selects."""
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


def _children(graph: Graph, level: Level, paths: Paths, has_handle: npt.NDArray[np.bool_]) -> Level:
    """Return the level below: the children of all instances that have primitives below them."""
    path = paths.extend(level.path, level.node)
    rank = level.rank + ~has_handle[level.node]
    first = graph.start[level.node]
    fan = graph.start[level.node + 1] - first  # number of children
    parent = np.repeat(np.arange(len(level.node)), fan)
    # Edges of a parent are consecutive: the position among all children minus that of the first sibling, plus its edge.
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


MOST_PRIMITIVES = 10_000_000  # of an expanded frame: their arrays take about 3 GB


def levels(graph: Graph, is_leaf: npt.NDArray[np.bool_], paths: Paths) -> Iterator[tuple[Level, Level]]:
    """Yield the instances of a frame, one depth of the tree after another: pairs of its leaves and its inner instances.

    Parameters
    ----------
    graph
        Entities of the frame.
    is_leaf
        Mask of the entities that are not opened, such as primitives.
    paths
        Table in which the paths of the instances are numbered.

    Raises
    ------
    LimitError
        "primitives" for more than ``MOST_PRIMITIVES``, whatever limits the caller has.
    """
    count = int(graph.leaves[-1])
    if count > MOST_PRIMITIVES:
        message = f"the scene expands to {count:,} primitives, more than the limit of {MOST_PRIMITIVES:,}"
        raise LimitError("primitives", message, "use a part of the scene")
    has_handle = np.array([entity.embedding.handle is not None for entity in graph.nodes])
    zero = np.zeros(1, np.int64)
    identity = np.array(IDENTITY).reshape(12, 1)
    root = np.array([len(graph.nodes) - 1], np.int64)
    level = Level(root, identity, zero, zero, zero, zero, zero)
    while len(level.node):
        leaf = is_leaf[level.node]
        inner = level.select(~leaf & (graph.leaves[level.node] > 0))
        yield level.select(leaf), inner
        if not len(inner.node):
            return
        level = _children(graph, inner, paths, has_handle)


def flatten_entity(root: Entity, opaque: Set[int] = frozenset(), snap_blocks: bool = True) -> FlatFrame:
    """Flatten one entity under the identity pose. The caller has checked the number of primitives.

    Parameters
    ----------
    opaque
        Values of ``id`` of entities that are not expanded but listed among the primitives.
    snap_blocks
        Whether to move Minecraft blocks to whole cells; False for an entity that is only a part of a scene.
    """
    graph = graph_of(root, opaque)
    is_leaf = np.array([entity.is_primitive or id(entity) in opaque for entity in graph.nodes])
    paths = Paths(graph.nodes)
    leaves_by_level = [leaves for leaves, _ in levels(graph, is_leaf, paths) if len(leaves.node)]
    leaves = _in_order(leaves_by_level, int(graph.leaves[-1]))
    used, index = _distinct(leaves.node)
    used_paths, path_index = _distinct(leaves.path)
    matrices = leaves.pose.T.reshape(-1, 3, 4)
    has_handle = np.array([entity.embedding.handle is not None for entity in graph.nodes])
    is_block = np.array([graph.nodes[i].is_block for i in used])
    if snap_blocks and is_block.any():
        matrices = np.ascontiguousarray(matrices)
        rows = is_block[index]
        matrices[rows, :, 3] = np.trunc(matrices[rows, :, 3]) + 0.0  # + 0.0 turns -0.0 into 0.0
    return FlatFrame(
        tuple(graph.nodes[i] for i in used),
        index,
        matrices,
        path_index,
        tuple(paths.words_along(int(path)) for path in used_paths),
        np.where(has_handle[leaves.node], 0, leaves.rank + 1),
    )


def _distinct(numbers: IntArray) -> tuple[IntArray, IntArray]:
    """Return the distinct non-negative integers in ascending order, and for each item its index among them."""
    used = np.flatnonzero(np.bincount(numbers))
    place = np.zeros(int(used[-1]) + 1 if len(used) else 0, np.int64)
    place[used] = np.arange(len(used))
    return used, place[numbers]


def _in_order(leaves_by_level: list[Level], total: int) -> Level:
    """Merge the leaves of all levels into depth-first order; ``parent`` and ``position`` then have no meaning."""
    if len(leaves_by_level) == 1:  # a single level is already in order
        return leaves_by_level[0]
    columns = {name: np.zeros(total, np.int64) for name in ("node", "offset", "rank", "path", "parent", "position")}
    pose = np.zeros((12, total))
    for level in leaves_by_level:
        pose[:, level.offset] = level.pose
        for name, column in columns.items():
            column[level.offset] = getattr(level, name)
    return Level(pose=pose, **columns)
