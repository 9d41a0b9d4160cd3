"""Primitives of one frame as convex bodies in world coordinates, and their contacts."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import numpy.typing as npt

from scenelang.backends.geometry.distance import IntArray, Pairs, boxes, distances, neighbours
from scenelang.backends.geometry.solids import FloatArray, PosedForms, composed, posed_forms
from scenelang.backends.pictures.appearance import look_of
from scenelang.interpreter.runtime.values import IDENTITY
from scenelang.interpreter.scene.entity import Entity, descendants, primitive_count
from scenelang.interpreter.scene.flatten import flatten_entity
from scenelang.interpreter.scene.primitives import Placed
from scenelang.interpreter.scene.primitives.cube import placed_block

MAX_PAIRS = 300_000
_TOUCH = 1e-3  # contact tolerance relative to the scene's diagonal
_BATCH = 20_000


@dataclass(frozen=True, eq=False)
class Bodies:
    """N bodies of one frame.

    ``entity[i]`` is the index in ``entities`` of the primitive of body ``i``, ``paths[path[i]]`` the words that lead to
    it. A mesh is represented by its bounding box. ``opaque`` bodies hide what is behind them.
    """

    solids: PosedForms
    entities: tuple[Entity, ...]
    entity: IntArray
    paths: tuple[tuple[str, ...], ...]
    path: IntArray
    opaque: npt.NDArray[np.bool_]
    colors: FloatArray  # (N, 3) linear
    plain: frozenset[str]  # the bound words whose entities each consist of one solid
    exact: npt.NDArray[np.bool_]  # (N,) whether a body is the solid itself, and not its box or its convex hull
    row: IntArray  # (N,) position among all primitives of the frame, in depth-first order

    def __len__(self) -> int:
        return len(self.solids)

    @cached_property
    def boxes(self) -> tuple[FloatArray, FloatArray]:
        return boxes(self.solids)

    @cached_property
    def size(self) -> float:
        """Diagonal of the frame's bounding box."""
        low, high = self.boxes
        return float(np.linalg.norm(high.max(axis=0) - low.min(axis=0))) if len(self) else 0.0

    @property
    def touch(self) -> float:
        """Contact tolerance, in scene units."""
        return _TOUCH * self.size

    def pairs(self, numbers: IntArray) -> Pairs:
        a, b = numbers[:, 0], numbers[:, 1]
        return Pairs(self.solids.take(a), self.solids.take(b))

    def gaps(self, numbers: IntArray) -> FloatArray:
        """Return the distances of pairs (M, 2)."""
        parts = [distances(self.pairs(numbers[i : i + _BATCH])) for i in range(0, len(numbers), _BATCH)]
        return np.concatenate(parts) if parts else np.zeros(0)

    @cached_property
    def contacts(self) -> tuple[IntArray, FloatArray, bool]:
        """The touching pairs (M, 2), their distances, and whether all pairs were checked."""
        near, complete = neighbours(*self.boxes, self.touch, MAX_PAIRS)
        gaps = self.gaps(near)
        close = gaps <= self.touch
        return near[close], gaps[close], complete

    def words(self, i: int) -> tuple[str, ...]:
        """Return the words from the root to a body."""
        return (*self.paths[self.path[i]], self.entities[self.entity[i]].word)


def bodies_of(root: Entity) -> Bodies:
    """Return the visible primitives below ``root`` as bodies, without those of zero volume."""
    frame = flatten_entity(root)
    placed = [_placed(entity) for entity in frame.primitives]
    looks = [look_of(entity) for entity in frame.primitives]
    known = np.array([one is not None for one in placed], bool)
    seen = np.array([look.opacity > 0.0 for look in looks], bool)
    index = np.asarray(frame.index)
    chosen = np.flatnonzero((known & seen)[index]) if len(index) else np.zeros(0, np.int64)
    index = index[chosen]
    forms = posed_forms(placed).take(index)
    matrices = composed(np.asarray(frame.matrices)[chosen], forms.matrices)
    solid = np.abs(np.linalg.det(matrices[:, :, :3])) > 1e-30 if len(chosen) else np.zeros(0, bool)
    chosen, index = chosen[solid], index[solid]
    return Bodies(
        replace(forms, matrices=matrices).take(solid),
        frame.primitives,
        index,
        frame.paths,
        np.asarray(frame.path_index)[chosen],
        np.array([look.opacity >= 1.0 for look in looks], bool)[index],
        np.array([look.color for look in looks], np.float64).reshape(-1, 3)[index],
        _plain_words(root),
        np.array([_is_exact(entity) for entity in frame.primitives], bool)[index],
        chosen,
    )


def _is_exact(entity: Entity) -> bool:
    """Whether the body of a primitive is convex and the primitive itself."""
    placed = None if entity.shape is None or entity.shape.is_semantic else entity.shape.placed()
    return placed is not None and placed.form.is_convex


def _plain_words(root: Entity) -> frozenset[str]:
    counts: dict[str, set[int]] = {}
    for entity in descendants(root):
        if not entity.is_primitive:
            counts.setdefault(entity.word, set()).add(primitive_count(entity))
    return frozenset(word for word, found in counts.items() if found == {1})


def _placed(entity: Entity) -> Placed | None:
    """Return the canonical form of a primitive in its frame, the bounding box for a mesh.

    None for blocks, which replace earlier ones at the same place and so cannot overlap, and for invisible primitives.
    """
    shape = entity.shape
    if shape is None or not shape.has_geometry or shape.is_block:
        return None
    placed = shape.placed()
    if placed is not None or (shape.is_solid and shape.is_flat):
        return placed
    low, high = np.array(shape.box_under(IDENTITY)).reshape(2, 3)
    if not shape.is_file and not (high > low).any():
        return None
    x, y, z = (high - low).tolist()
    rows = np.array(placed_block((x, y, z)).rows).reshape(3, 4)
    rows[:, 3] = (low + high) / 2.0
    return placed_block((x, y, z))._replace(rows=tuple(rows.ravel().tolist()))


def clusters(count: int, pairs: Iterable[Sequence[int]]) -> IntArray:
    """Return a number for each of ``count`` things that is equal for those that pairs of them connect (union-find)."""
    parent = list(range(count))

    def root(i: int) -> int:
        while parent[i] != i:
            parent[i] = parent[parent[i]]
            i = parent[i]
        return i

    for i, j in pairs:
        parent[root(i)] = root(j)
    return np.array([root(i) for i in range(count)], np.int64)


# --- polygons of support ---------------------------------------------------------------------------------------------


def beyond_edge(points: FloatArray, at: FloatArray) -> tuple[float, FloatArray]:
    """Return how far ``at`` (2,) is outside the convex hull of points (K, 2), negative inside, and the nearest point of
    its edge."""
    corners = _hull(points)
    edges, away = np.roll(corners, -1, axis=0) - corners, at - corners
    share = np.clip((edges * away).sum(axis=1) / np.maximum((edges**2).sum(axis=1), 1e-300), 0.0, 1.0)
    nearest = corners + share[:, None] * edges
    distance = np.linalg.norm(at - nearest, axis=1)
    best = int(np.argmin(distance))
    inside = len(corners) > 2 and bool((edges[:, 0] * away[:, 1] - edges[:, 1] * away[:, 0] >= 0.0).all())
    return float(-distance[best] if inside else distance[best]), nearest[best]


def _hull(points: FloatArray) -> FloatArray:
    """Return the convex hull of points (K, 2), counter-clockwise (monotone chain, Andrew, 1979)."""
    order = sorted(map(tuple, np.unique(points, axis=0).tolist()))
    if len(order) < 3:
        return np.array(order)
    chains = []
    for run in (order, order[::-1]):
        chain: list[tuple[float, ...]] = []
        for p in run:
            while len(chain) > 1 and _turn(chain[-2], chain[-1], p) <= 0.0:
                chain.pop()
            chain.append(p)
        chains += chain[:-1]
    return np.array(chains)


def _turn(a: Sequence[float], b: Sequence[float], c: Sequence[float]) -> float:
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
