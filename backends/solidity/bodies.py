"""The primitives of one frame as convex bodies in the world's frame, and which of them touch."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from scenelang.backends.appearance import look_of
from scenelang.backends.solidity.distance import Pairs, distances
from scenelang.backends.solidity.neighbours import IntArray, neighbours
from scenelang.backends.solidity.support import Forms, boxes
from scenelang.backends.solids import FloatArray, Form, composed, local_pose
from scenelang.interpreter.entity import Entity, descendants, primitive_count
from scenelang.interpreter.flatten import flatten_entity
from scenelang.interpreter.shapes import Kind

MOST_PAIRS = 300_000
_TOUCH = 1e-3  # of the scene's diagonal
_BATCH = 20_000


@dataclass(frozen=True, eq=False)
class Bodies:
    """N bodies. ``entity[i]`` is the number of body ``i``'s primitive in ``entities``, ``paths[path[i]]`` the words
    that lead to it. A mesh file is its box. ``opaque``: nothing behind is seen through it."""

    forms: Forms
    matrices: FloatArray  # (N, 3, 4)
    entities: tuple[Entity, ...]
    entity: IntArray
    paths: tuple[tuple[str, ...], ...]
    path: IntArray
    opaque: npt.NDArray[np.bool_]
    colors: FloatArray  # (N, 3) linear
    plain: frozenset[str]  # the bound words of which every entity is one solid

    def __len__(self) -> int:
        return len(self.forms)

    @cached_property
    def boxes(self) -> tuple[FloatArray, FloatArray]:
        return boxes(self.forms, self.matrices)

    @cached_property
    def size(self) -> float:
        """The diagonal of the frame's box."""
        low, high = self.boxes
        return float(np.linalg.norm(high.max(axis=0) - low.min(axis=0))) if len(self) else 0.0

    @property
    def touch(self) -> float:
        """Nearer than this is contact."""
        return _TOUCH * self.size

    def pairs(self, numbers: IntArray) -> Pairs:
        a, b = numbers[:, 0], numbers[:, 1]
        return Pairs(self.forms[a], self.matrices[a], self.forms[b], self.matrices[b])

    def gaps(self, numbers: IntArray) -> FloatArray:
        """The distances of pairs (M, 2)."""
        parts = [distances(self.pairs(numbers[i : i + _BATCH])) for i in range(0, len(numbers), _BATCH)]
        return np.concatenate(parts) if parts else np.zeros(0)

    @cached_property
    def contacts(self) -> tuple[IntArray, FloatArray, bool]:
        """The pairs (M, 2) that touch, their distances, and whether all pairs were looked at."""
        near, complete = neighbours(*self.boxes, self.touch, MOST_PAIRS)
        gaps = self.gaps(near)
        close = gaps <= self.touch
        return near[close], gaps[close], complete

    def words(self, i: int) -> tuple[str, ...]:
        """The words from the root to a body."""
        return (*self.paths[self.path[i]], self.entities[self.entity[i]].word)


def bodies_of(root: Entity) -> Bodies:
    """The visible primitives below ``root`` as bodies; those without extent are left out."""
    frame = flatten_entity(root)
    poses = [_pose(entity) for entity in frame.primitives]
    looks = [look_of(entity) for entity in frame.primitives]
    known = np.array([pose is not None for pose in poses], bool)
    seen = np.array([look.opacity > 0.0 for look in looks], bool)
    index = np.asarray(frame.index)
    chosen = np.flatnonzero((known & seen)[index]) if len(index) else np.zeros(0, np.int64)
    index = index[chosen]
    forms = np.array([pose[0] if pose is not None else Form.BLOCK for pose in poses], np.int8)
    local = np.array([pose[1] if pose is not None else np.zeros((3, 4)) for pose in poses]).reshape(-1, 3, 4)
    matrices = composed(np.asarray(frame.matrices)[chosen], local[index])
    solid = np.abs(np.linalg.det(matrices[:, :, :3])) > 1e-30 if len(chosen) else np.zeros(0, bool)
    chosen, index, matrices = chosen[solid], index[solid], matrices[solid]
    return Bodies(
        forms[index],
        matrices,
        frame.primitives,
        index,
        frame.paths,
        np.asarray(frame.path_index)[chosen],
        np.array([look.opacity >= 1.0 for look in looks], bool)[index],
        np.array([look.color for look in looks], np.float64).reshape(-1, 3)[index],
        _plain_words(root),
    )


def _plain_words(root: Entity) -> frozenset[str]:
    counts: dict[str, set[int]] = {}
    for entity in descendants(root):
        if not entity.is_primitive:
            counts.setdefault(entity.word, set()).add(primitive_count(entity))
    return frozenset(word for word, found in counts.items() if found == {1})


def _pose(entity: Entity) -> tuple[Form, FloatArray] | None:
    """The canonical solid that a primitive is, and its pose (3, 4)."""
    shape = entity.shape
    if shape is None or shape.kind in (Kind.VOID, Kind.CUBOID):
        return None  # blocks take the place of those before them
    if shape.kind is not Kind.ASSET:
        return local_pose(shape)
    if shape.asset is None:
        return None
    low, high = np.array(shape.asset.box[:3]), np.array(shape.asset.box[3:])
    return Form.BLOCK, np.concatenate([np.diag((high - low) / 2.0), ((low + high) / 2.0)[:, None]], axis=1)
