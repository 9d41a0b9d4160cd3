"""Flattening of the entity DAG to primitives with world matrices, vectorized by DAG level.

The pose of a primitive is the product of the matrices on the path from the root (paper, section 4). The order is
depth-first. Minecraft blocks start at whole cells: their positions are truncated toward zero, as in the paper's tool.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence, Set
from dataclasses import dataclass, fields, replace
from typing import TYPE_CHECKING, Any

from scenelang.grammar.diagnostics import LimitError, SceneError
from scenelang.interpreter.loading import np
from scenelang.interpreter.scene.entity import Entity, Scene, descendants, primitive_count
from scenelang.interpreter.scene.part_columns import PartColumns
from scenelang.interpreter.scene.pose import stacked
from scenelang.interpreter.values.values import IDENTITY

if TYPE_CHECKING:
    import numpy.typing as npt

    IntArray = npt.NDArray[np.int64]
    Numbers = npt.NDArray[np.int32]
    Poses = npt.NDArray[np.float64]  # (12, N): row-major affine poses, one a column


DEFAULT_LIMIT = 5_000_000  # primitives, as in ``Limits``
# Instances made at a time: their poses, 12 columns of doubles (393 kB), stay in the L2 cache. A pose then takes 75 ns
# to multiply and to put into its place; in pieces of 8,192 it takes 90 ns, of 1,024 130 ns.
_PIECE = 1 << 12


@dataclass(frozen=True, slots=True, eq=False)
class FlatFrame:
    """Primitives of one frame, N instances in depth-first order.

    Attributes
    ----------
    primitives
        Distinct primitive entities (see ``.shape``, ``.embedding``, ``.word``).
    index : (N,) int32
        Instance ``i`` is ``primitives[index[i]]``.
    matrices : (N, 3, 4) or (N, 4, 4)
        Upper three rows of the world matrices, or whole matrices if they were asked for.
    paths, path_index : (N,) int32
        ``paths[path_index[i]]`` are the words from the root to the parent of the primitive.
    ranks : (N,)
        Position of the instance among the entities without a handle in depth-first pre-order, counted from 1; 0 if its
        embedding has a handle.
    """

    primitives: tuple[Entity, ...]
    index: Numbers  # (N,)
    matrices: npt.NDArray[np.float64]  # (N, 3, 4) or (N, 4, 4)
    path_index: Numbers  # (N,)
    paths: tuple[tuple[str, ...], ...]
    ranks: IntArray  # (N,)

    def __len__(self) -> int:
        return len(self.index)

    def select(self, mask: npt.NDArray[np.bool_]) -> FlatFrame:
        """Return the frame restricted to the instances that ``mask`` (N,) selects."""
        used, index = _distinct(self.index[mask], len(self.primitives))
        primitives = tuple(self.primitives[i] for i in used)
        return FlatFrame(primitives, index, self.matrices[mask], self.path_index[mask], self.paths, self.ranks[mask])


@dataclass(frozen=True, slots=True, eq=False)
class FlatScene:
    """Flattened scene with one ``FlatFrame`` per frame; a static scene has one."""

    word: str
    frames: tuple[FlatFrame, ...]
    animated: bool


def flatten(scene: Scene, limit: int = DEFAULT_LIMIT, whole: bool = False) -> FlatScene:
    """Flatten every frame of a scene.

    Parameters
    ----------
    scene
        Result of a program.
    limit
        Maximum number of primitives of all frames together; it is counted on the DAG before anything is expanded.
    whole
        Whether to return whole matrices, (N, 4, 4), each contiguous.

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
    frames = tuple(flatten_entity(root, whole=whole) for root in scene.frames)
    if not all(_is_finite(frame.matrices) for frame in frames):
        raise SceneError("pose", "pose overflow: coordinates exceed the float range")
    return FlatScene(scene.word, frames, scene.animated)


def _is_finite(matrices: npt.NDArray[np.float64]) -> bool:
    """Return whether all entries are finite; a finite sum says so without an array of answers."""
    with np.errstate(over="ignore", invalid="ignore"):
        return bool(np.isfinite(matrices.sum()) or np.isfinite(matrices).all())


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
    number = {entity: i for i, entity in enumerate(nodes)}
    start = np.zeros(len(nodes) + 1, np.int64)
    np.cumsum([len(entity.children) for entity in nodes], out=start[1:])
    child = np.empty(start[-1], np.int64)
    pose = np.empty((12, len(child)))
    # Nodes come children first, so one pass sums what is below each node.
    leaves: list[int] = []
    unhandled: list[int] = []
    for entity, low in zip(nodes, start.tolist()):
        below = _numbers_below(entity, number)
        child[low : low + len(below)] = below
        is_opaque = id(entity) in opaque
        leaves.append(1 if is_opaque else _total(leaves, below) + entity.is_primitive)
        unhandled.append(_total(unhandled, below) + (entity.embedding.handle is None))
    _write_poses(nodes, pose)
    leaf_counts, unhandled_counts = np.array(leaves, np.int64), np.array(unhandled, np.int64)
    return Graph(
        nodes, start, child, pose, leaf_counts, unhandled_counts,
        _before(leaf_counts[child], start), _before(unhandled_counts[child], start),
    )  # fmt: skip


def _numbers_below(entity: Entity, number: Mapping[Entity, int]) -> Sequence[int] | IntArray:
    """Return the number of the entity of each part."""
    parts = entity.children
    if type(parts) is PartColumns:
        return np.array([number[child] for child in parts.entities], np.int64)[np.frombuffer(parts.numbers, np.uint32)]
    return [number[part.car] for part in parts]


def _total(counts: Sequence[int], below: Sequence[int] | IntArray) -> int:
    """Return the sum of the counts of the nodes with these numbers, which may each occur several times."""
    if isinstance(below, np.ndarray):
        times = np.bincount(below)
        return sum(int(times[node]) * counts[node] for node in np.flatnonzero(times).tolist())
    return sum(map(counts.__getitem__, below))


def _write_poses(nodes: Sequence[Entity], out: Poses) -> None:
    """Write the pose of each edge, the parts of the nodes in order, into a column of ``out`` (12, E)."""
    waiting: list[Any] = []
    edge = 0

    def write(poses: npt.NDArray[np.float64]) -> int:
        """Write N poses (N, 12), a piece at a time, and return the next edge."""
        for low in range(0, len(poses), _PIECE):
            piece = poses[low : low + _PIECE]
            out[:, edge + low : edge + low + len(piece)] = piece.T
        return edge + len(poses)

    for entity in nodes:
        parts = entity.children
        if type(parts) is PartColumns:
            edge = write(stacked(waiting))
            waiting.clear()
            edge = write(np.frombuffer(parts.poses).reshape(-1, 12))
            continue
        waiting += [part.cdr for part in parts]
        if len(waiting) >= _PIECE:
            edge = write(stacked(waiting))
            waiting.clear()
    write(stacked(waiting))


def _before(counts: IntArray, start: IntArray) -> IntArray:
    """Return for each edge (E,) the sum of ``counts`` (E,) of the earlier edges of its node."""
    before = np.cumsum(counts) - counts
    first = start[:-1][start[:-1] < start[1:]]
    return before - np.repeat(before[first], np.diff(start)[start[:-1] < start[1:]])


class _Products:
    """Products of poses, a piece at a time, in memory that each piece uses again.

    New memory costs a page fault for each 4 kB, which took 1 s of the 3 s of 3.2 million cubes.
    """

    def __init__(self) -> None:
        self._rows = np.empty((4, 12 * _PIECE))

    def _array(self, number: int, rows: int, count: int) -> Poses:
        """Return one of the four arrays, contiguous, with as many rows and columns."""
        return self._rows[number, : rows * count].reshape(rows, count)

    def of(self, parents: Poses, parent: IntArray, children: Poses, child: IntArray, kept: bool) -> Poses:
        """Multiply N pairs of poses.

        Parameters
        ----------
        parents, children : (12, P), (12, C)
            Poses, one in a column.
        parent, child : (N,)
            Columns to multiply.
        kept
            Whether the result outlives the next call; else there are ``_PIECE`` pairs at most.

        Returns
        -------
        array (12, N)
            The products ``parents[:, parent] @ children[:, child]``; infinite where they overflow, which the caller
            reports.
        """
        count = len(parent)
        out = np.empty((12, count)) if kept else self._array(0, 12, count)
        with np.errstate(over="ignore", invalid="ignore"):  # the caller reports overflow
            for low in range(0, count, _PIECE):
                piece = slice(low, min(low + _PIECE, count))
                p, c = self._array(1, 12, piece.stop - low), self._array(2, 12, piece.stop - low)
                np.take(parents, parent[piece], axis=1, out=p, mode="clip")  # other modes take a copy of ``out``
                np.take(children, child[piece], axis=1, out=c, mode="clip")
                _compose(p, c, out[:, piece], self._array(3, 4, piece.stop - low))
        return out


def _compose(p: Poses, c: Poses, out: Poses, term: npt.NDArray[np.float64]) -> None:
    """Write N products into ``out``: the same twelve sums of products as in ``pose.compose``, a row of four at a time.

    ``term`` (4, N) is written over.
    """
    for row in range(0, 12, 4):
        total = out[row : row + 4]
        np.multiply(p[row], c[0:4], out=total)
        for column in (1, 2):
            np.multiply(p[row + column], c[4 * column : 4 * column + 4], out=term)
            total += term
        total[3] += p[row + 3]


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


def _children(
    graph: Graph, level: Level, paths: Paths, has_handle: npt.NDArray[np.bool_], products: _Products, *, in_pieces: bool
) -> Iterator[Level]:
    """Yield the level below, the children of all instances that have primitives below them, whole or in pieces.

    The poses of a piece are overwritten by those of the next.
    """
    path = paths.extend(level.path, level.node)
    rank = level.rank + ~has_handle[level.node]
    first = graph.start[level.node]
    fan = graph.start[level.node + 1] - first  # number of children
    end = np.cumsum(fan)
    shift = first - (end - fan)  # the edges of a parent are consecutive, and so are its children: edge minus child
    total = int(end[-1])
    size = _PIECE if in_pieces else total
    for low in range(0, total, size):
        high = min(low + size, total)
        parents = np.arange(np.searchsorted(end, low, "right"), np.searchsorted(end, high - 1, "right") + 1)
        parent = np.repeat(parents, np.minimum(end[parents], high) - np.maximum(end[parents] - fan[parents], low))
        edge = np.arange(low, high) + shift[parent]
        keep = graph.leaves[graph.child[edge]] > 0
        if not keep.all():
            parent, edge = parent[keep], edge[keep]
        yield Level(
            graph.child[edge],
            products.of(level.pose, parent, graph.pose, edge, kept=not in_pieces),
            level.offset[parent] + graph.leaf_offset[edge],
            rank[parent] + graph.rank_offset[edge],
            path[parent],
            parent,
            edge - first[parent],
        )


MOST_PRIMITIVES = 10_000_000  # of an expanded frame: the arrays of ``Primitives`` take 1.7 GB


def levels(
    graph: Graph, is_leaf: npt.NDArray[np.bool_], paths: Paths, in_pieces: bool = False
) -> Iterator[tuple[Level, Level]]:
    """Yield the instances of a frame, one depth of the tree after another: pairs of its leaves and its inner instances.

    Parameters
    ----------
    graph
        Entities of the frame.
    is_leaf
        Mask of the entities that are not opened, such as primitives.
    paths
        Table in which the paths of the instances are numbered.
    in_pieces
        Whether a depth comes in several pairs: as soon as ``_PIECE`` inner instances wait, those below them come, so
        that no level is ever whole in memory. The leaves of a pair are overwritten by the next pair, and ``parent`` has
        no meaning.

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
    products = _Products()
    waiting: dict[int, list[Level]] = {}  # inner instances by depth
    opened: list[tuple[int, Iterator[Level]]] = [(0, iter((Level(root, identity, zero, zero, zero, zero, zero),)))]
    while opened or waiting:
        depth = min(waiting, default=0)
        # Fewer than a piece wait until nothing is open, and then are the last of their depth: else a long chain would
        # be followed down once for each piece of the level that it starts from.
        if opened:
            depth, pieces = opened[-1]
            level = next(pieces, None)
            if level is None:
                opened.pop()
                continue
            leaf = is_leaf[level.node]
            inner = level.select(~leaf & (graph.leaves[level.node] > 0))
            yield level.select(leaf), inner
            if not len(inner.node):
                continue
            waiting.setdefault(depth, []).append(replace(inner, pose=inner.pose.copy()) if in_pieces else inner)
            if not in_pieces or sum(len(piece.node) for piece in waiting[depth]) < _PIECE:
                continue
        above = _joined(waiting.pop(depth))
        opened.append((depth + 1, _children(graph, above, paths, has_handle, products, in_pieces=in_pieces)))


def _joined(pieces: Sequence[Level]) -> Level:
    """Return consecutive pieces of a level as one."""
    if len(pieces) == 1:
        return pieces[0]
    columns = {
        column.name: np.concatenate([getattr(piece, column.name) for piece in pieces], axis=-1)
        for column in fields(Level)
    }
    return Level(**columns)


def flatten_entity(
    root: Entity, opaque: Set[int] = frozenset(), snap_blocks: bool = True, whole: bool = False
) -> FlatFrame:
    """Flatten one entity under the identity pose. The caller has checked the number of primitives.

    Parameters
    ----------
    opaque
        Values of ``id`` of entities that are not expanded but listed among the primitives.
    snap_blocks
        Whether to move Minecraft blocks to whole cells; False for an entity that is only a part of a scene.
    whole
        Whether to return whole matrices, (N, 4, 4), each contiguous; else (N, 3, 4), each entry of all in a row.
    """
    graph = graph_of(root, opaque)
    is_leaf = np.array([entity.is_primitive or id(entity) in opaque for entity in graph.nodes])
    paths = Paths(graph.nodes)
    leaves = _Leaves(int(graph.leaves[-1]), whole)
    for piece, _ in levels(graph, is_leaf, paths, in_pieces=True):
        leaves.put(piece)
    has_handle = np.array([entity.embedding.handle is not None for entity in graph.nodes])
    np.putmask(leaves.rank, has_handle[leaves.node], 0)
    used, index = _distinct(leaves.node, len(graph.nodes))
    used_paths, path_index = _distinct(leaves.path, len(paths.parents))
    matrices = leaves.matrices
    is_block = np.array([graph.nodes[i].is_block for i in used])
    if snap_blocks and is_block.any():
        matrices = np.ascontiguousarray(matrices)
        rows = is_block[index]
        matrices[rows, :3, 3] = np.trunc(matrices[rows, :3, 3]) + 0.0  # + 0.0 turns -0.0 into 0.0
    return FlatFrame(
        tuple(graph.nodes[i] for i in used),
        index,
        matrices,
        path_index,
        tuple(paths.words_along(int(path)) for path in used_paths),
        leaves.rank,
    )


class _Leaves:
    """Columns of a frame's leaves in depth-first order, which ``put`` fills with pieces of levels."""

    def __init__(self, count: int, whole: bool) -> None:
        """Reserve the columns; a page of memory is taken when it is written first."""
        self.node, self.path = np.empty(count, np.int32), np.empty(count, np.int32)
        self.rank = np.empty(count, np.int64)  # counts entities without primitives too, which no limit bounds
        # Twelve columns in a row each are fastest to write; a column of a whole matrix is one in sixteen.
        self._pose = np.empty((count, 16)).T if whole else np.empty((12, count))
        self.matrices = self._pose.T.reshape(-1, 4 if whole else 3, 4)

    def put(self, level: Level) -> None:
        """Write the leaves of a level to their places."""
        if not len(level.node):
            return
        first, last = int(level.offset[0]), int(level.offset[-1])  # ascending
        at = slice(first, last + 1) if last - first + 1 == len(level.node) else level.offset
        self.node[at], self.path[at], self.rank[at] = level.node, level.path, level.rank + 1
        self._pose[:12, at] = level.pose
        if len(self._pose) > 12:
            self._pose[12:, at] = np.array(_LAST_ROW)


_LAST_ROW = [[0.0], [0.0], [0.0], [1.0]]  # of every matrix, as a column


def _distinct(numbers: IntArray | Numbers, count: int) -> tuple[IntArray, Numbers]:
    """Return the distinct integers of 0 to ``count - 1`` in ascending order, and for each item its index among them."""
    present = np.zeros(count, bool)
    present[numbers] = True
    place = np.cumsum(present, dtype=np.int32) - 1
    return np.flatnonzero(present), place[numbers]
