"""Primitives of one frame as convex bodies in world coordinates, and their contacts."""

from __future__ import annotations

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
    return placed is not None and placed.form.name != "torus"


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


def clusters(count: int, pairs: IntArray) -> IntArray:
    """Return the connected component of each body under contact (union-find)."""
    parent = list(range(count))

    def root(i: int) -> int:
        while parent[i] != i:
            parent[i] = parent[parent[i]]
            i = parent[i]
        return i

    for i, j in pairs.tolist():
        parent[root(i)] = root(j)
    return np.array([root(i) for i in range(count)], np.int64)
