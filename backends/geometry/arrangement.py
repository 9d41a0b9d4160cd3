"""Positions of the objects of one frame: instances by word or handle, exact distances, overlaps and free falls.

Convex primitives are compared by their support functions (GJK and separating directions, ``surfaces.distance``), all
others by Manifold on their surfaces, because MuJoCo, an extra, has no cones, shears or concave shapes. Semantic
primitives count as their boxes.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import numpy.typing as npt

from scenelang.backends.facts.frame import facts_of
from scenelang.backends.surfaces.convex import MAX_PAIRS, Bodies
from scenelang.backends.surfaces.distance import IntArray, Pairs, depths, distances, neighbors
from scenelang.backends.surfaces.solids import FloatArray, is_object
from scenelang.grammar.diagnostics import LimitError, SceneError
from scenelang.interpreter.inspection.instance_paths import Locator, is_handle, is_plain
from scenelang.interpreter.inspection.numbering import Ancestry, frame_numbers, some_handles
from scenelang.interpreter.scene.bounds import parts_box
from scenelang.interpreter.scene.entity import Entity, Scene, contains_blocks
from scenelang.interpreter.scene.modelling.computing import leaf_mesh, manifold_of_mesh
from scenelang.interpreter.scene.primitives.mesh import Mesh
from scenelang.interpreter.values.values import Matrix, Pair

if TYPE_CHECKING:
    from manifold3d import Manifold

_SEGMENTS = 64  # sides of a round form that is compared with a surface
_BATCH_PAIRS = 20_000  # pairs that are compared at a time, to bound the memory
_FIRST_PAIRS = 64  # pairs that are compared first, to discard those whose boxes are farther apart
_TOUCH_RATIO = 1e-3  # of the frame's diagonal: objects with a smaller gap touch
_TOUCH_OBJECT_RATIO = 0.02  # the same of the object's own extent, for small objects in large scenes
_GAP_ROUNDS = 4  # of looking for the vertex nearest to that of the other surface, which bounds their gap
_GAP_MARGIN = 1.001  # by which triangles are looked for farther than the bound of a gap, for the rounding of meshes
_BISECTIONS = 30  # of a bisection: 2^-30 of an interval is below the contact tolerance
_PROBE_RATIO = 0.02  # of an object's extent, by which it is moved into another to see whether that blocks it
# vertical component of the direction in which an object is supported: slopes of up to 53 degrees
_MIN_SUPPORT_NORMAL = 0.6
_FALL_SAMPLES = 17  # heights at which a fall is tested before it is bisected
SUNK = 0.05  # of its height: how deep an object may be in its support
_INSIDE_SHARE = 0.95  # of its volume in the hull of another object, from which it is inside
_MAX_RELATED_PAIRS = 20_000  # pairs of nearby objects whose relations are listed
# Of the smaller box: surfaces that touch share up to 1e-16 of it by rounding, and a glass on a table "overlapped" by
# its way out of the table.
_MIN_OVERLAP = 1e-12
_MIN_SWEPT_SHARE = 1e-4  # of the volume that an object sweeps: less is rounding

Vector = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class PlacedObject:
    """Instance in a frame: its number in the ancestry, and the half-open range of its bodies."""

    instance: int
    entity: Entity
    first: int
    last: int


_ObjectPair = tuple[PlacedObject, PlacedObject]


@dataclass(frozen=True, slots=True)
class Separation:
    """Separation of two objects.

    Attributes
    ----------
    distance
        Signed distance in scene units, negative where they overlap.
    bodies
        Numbers of the pair of bodies with that distance.
    away
        Direction in which the first object leaves the second, where they overlap.
    """

    distance: float
    bodies: tuple[int, int]
    away: Vector | None = None


class _Comparison(NamedTuple):
    """Comparison of two objects within reach: whether the second supports the first, and their separation."""

    blocked: bool
    separation: Separation | None


class Arrangement:
    """Objects of one frame of a scene, and their distances; results are cached by instance.

    Raises SceneError for meshes that cannot be read.
    """

    def __init__(self, scene: Scene, frame: int = 0) -> None:
        self.scene = scene
        self.frame = frame
        self.root = scene.frames[frame]
        self.facts = facts_of(self.root)
        self.ancestry: Ancestry = self.facts.ancestry
        self.bodies: Bodies = self.facts.solids
        self._surfaces: dict[int, Manifold] = {}
        self._meshes: dict[int, Mesh] = {}
        self._boxes: dict[int, tuple[FloatArray, FloatArray]] = {}
        self._within: dict[int, IntArray] = {}
        self._comparisons: dict[tuple[int, int, float], _Comparison] = {}
        self._separations: dict[tuple[int, int], Separation] = {}

    # --- instances ---------------------------------------------------------------------------------------------

    @cached_property
    def _ranges(self) -> tuple[IntArray, IntArray]:
        """First and last primitive (M,) of every instance."""
        return self.ancestry.ranges(self.ancestry.primitives)

    def object_at(self, instance: int) -> PlacedObject:
        """Return the object of an instance."""
        first, last = self._ranges
        start = int(np.searchsorted(self.bodies.row, first[instance]))
        end = int(np.searchsorted(self.bodies.row, last[instance], side="right"))
        return PlacedObject(instance, self.ancestry.entity(instance), start, end)

    def path(self, placed: PlacedObject) -> str:
        """Return the path that denotes only this object."""
        return self._locator.path(self.ancestry.path(placed.instance))

    def rows(self, placed: PlacedObject | None) -> tuple[int, int] | None:
        """Return the first and last primitive of an object in the flattened frame, None for None."""
        first, last = self._ranges
        return None if placed is None else (int(first[placed.instance]), int(last[placed.instance]))

    @cached_property
    def _rows_by_word(self) -> dict[str, IntArray]:
        """Instances of each word, ascending."""
        nodes_by_word: dict[str, list[int]] = {}
        for number, entity in enumerate(self.ancestry.nodes):
            nodes_by_word.setdefault(entity.word, []).append(number)
        order = np.argsort(self.ancestry.node, kind="stable")
        ends = np.searchsorted(self.ancestry.node[order], np.arange(len(self.ancestry.nodes) + 1))
        return {
            word: np.sort(np.concatenate([order[ends[n] : ends[n + 1]] for n in numbers]))
            for word, numbers in nodes_by_word.items()
        }

    def _rows_with_handle(self, handle: str, within: int) -> IntArray:
        """Return the instances below ``within`` that have a handle, given or automatic."""
        rows = np.flatnonzero(self._is_below(within))
        numbers = frame_numbers(self.scene) if len(self.scene.frames) > 1 else None
        named = some_handles(self.scene, self.ancestry, rows.tolist(), numbers)
        return np.array([row for row in rows.tolist() if named[row] == handle], np.int64)

    def _is_below(self, instance: int) -> npt.NDArray[np.bool_]:
        """Return which instances (M,) are ``instance`` or below it."""
        depth = int(self.ancestry.depth[instance])
        if depth not in self._within:
            self._within[depth] = self.ancestry.at_depth(depth)
        return np.asarray(self._within[depth] == instance, bool)

    def instances(self, name: str, within: int = 0) -> list[int]:
        """Return the instances at or below ``within`` with a word, a handle such as "<z3>", or a path."""
        if name.startswith("<") and is_handle(name):
            return [int(row) for row in self._rows_with_handle(name.strip("<>"), within)]
        if not is_plain(name):
            return self._rows_at(name, within)
        rows = self._rows_by_word.get(name, np.zeros(0, np.int64))
        return [int(row) for row in (rows if within == 0 else rows[self._is_below(within)[rows]])]

    def _rows_at(self, path: str, within: int) -> list[int]:
        """Return the instances with primitives that a path denotes below ``within``; none if the path is wrong."""
        if not len(self.ancestry):
            return []
        start = self._locator.at(self.ancestry.path(within))
        try:
            matches = self._locator.find(path, start)
        except LimitError:
            raise
        except SceneError:
            return []
        rows = (self._row(match.positions) for match in matches)
        return sorted(row for row in rows if row is not None)

    def problem_of(self, path: str, within: int) -> str | None:
        """Return why a path denotes no instance below ``within``; None for words and handles."""
        if is_plain(path) or is_handle(path) or not len(self.ancestry):
            return None
        try:
            self._locator.find(path, self._locator.at(self.ancestry.path(within)))
        except SceneError as error:
            return f"{error.message}: {error.hint}" if error.hint else error.message
        return None

    def contains(self, placed: PlacedObject, other: PlacedObject) -> bool:
        """Return whether ``other`` is a part of an object."""
        return placed.instance != other.instance and bool(self._is_below(placed.instance)[other.instance])

    def _row(self, positions: Sequence[int]) -> int | None:
        """Return the instance at a path of child positions, None if it has no primitives."""
        ancestry, row = self.ancestry, 0
        for position in positions:
            children = np.flatnonzero((ancestry.parent == row) & (ancestry.position == position))
            if not len(children):
                return None
            row = int(children[0])
        return row

    @cached_property
    def _locator(self) -> Locator:
        return Locator(self.scene, self.frame)

    def objects(self, name: str, within: int = 0) -> list[PlacedObject]:
        """Return the outermost instances with a word, handle or path that are ``within`` or below it."""
        rows = self.instances(name, within)
        known = set(rows)
        return [self.object_at(row) for row in rows if not self._has_above(row, known)]

    def _has_above(self, row: int, known: set[int]) -> bool:
        """Return whether an ancestor of an instance is among ``known``."""
        above = int(self.ancestry.parent[row])
        while above >= 0:
            if above in known:
                return True
            above = int(self.ancestry.parent[above])
        return False

    def words(self) -> list[str]:
        """Return the words of the frame, sorted."""
        return sorted(self._rows_by_word)

    def has_blocks(self, placed: PlacedObject) -> bool:
        """Return whether an object contains Minecraft blocks."""
        return contains_blocks(placed.entity, lambda _: None)

    # --- boxes and frames --------------------------------------------------------------------------------------

    def box(self, placed: PlacedObject) -> tuple[FloatArray, FloatArray]:
        """Return the exact bounding box in the scene's frame: low and high corner (3,); SceneError without geometry."""
        corners = self._boxes.get(placed.instance)
        if corners is None:
            pose = Matrix(self.ancestry.poses[placed.instance].ravel().tolist())
            box = parts_box((Pair(placed.entity, pose),))
            if box is None:  # blocks that are removed
                raise SceneError("declaration-subject", f'"{placed.entity.word}" has no geometry to measure')
            corners = self._boxes[placed.instance] = (np.array(box[:3]), np.array(box[3:]))
        return corners

    def center(self, placed: PlacedObject) -> FloatArray:
        """Return the center (3,) of the bounding box."""
        low, high = self.box(placed)
        return np.asarray((low + high) / 2.0, np.float64)

    def axis(self, placed: PlacedObject, axis: str) -> FloatArray:
        """Return the unit vector (3,) of an axis of the object's frame, in the scene's frame."""
        column = self.ancestry.poses[placed.instance][:, "xyz".index(axis)]
        return np.asarray(column / max(float(np.linalg.norm(column)), 1e-300), np.float64)

    def touch(self, placed: PlacedObject) -> float:
        """Return the gap below which an object touches another, in scene units."""
        low, high = self.box(placed)
        return max(
            min(_TOUCH_RATIO * self.bodies.size, _TOUCH_OBJECT_RATIO * float((high - low).max())),
            1e-9 * self.bodies.size,
        )

    @property
    def ground(self) -> float:
        """Height of the ground."""
        return self.facts.ground.height

    # --- pairs of bodies ---------------------------------------------------------------------------------------

    def _rows(self, placed: PlacedObject, other: PlacedObject) -> IntArray:
        """Return the bodies of an object without those of ``other``, which may be a part of it."""
        rows = np.arange(placed.first, placed.last)
        if placed.first <= other.first and other.last <= placed.last:
            rows = rows[(rows < other.first) | (rows >= other.last)]
        return rows

    def _pairs(self, a: PlacedObject, b: PlacedObject, reach: float, shift: FloatArray) -> IntArray:
        """Return the pairs (M, 2) of bodies of two objects whose boxes are within ``reach``."""
        first, second = self._rows(a, b), self._rows(b, a)
        low, high = self.bodies.boxes
        blocks = []
        step = max(1, _BATCH_PAIRS * 50 // max(1, len(second)))  # rows of the table of boxes, a million entries
        for start in range(0, len(first), step):
            rows = first[start : start + step]
            below, above = low[rows, None] + shift - high[None, second], low[None, second] - high[rows, None] - shift
            apart = np.maximum(below, above)
            hits = np.nonzero(np.linalg.norm(np.maximum(apart, 0.0), axis=2) <= reach)
            blocks.append(np.stack([rows[hits[0]], second[hits[1]]], axis=1))
        return np.concatenate(blocks) if blocks else np.zeros((0, 2), np.int64)

    @cached_property
    def _convex(self) -> npt.NDArray[np.bool_]:
        """Mask (N,) of bodies that are compared by their support functions."""
        exact = np.array([_is_convex(entity) for entity in self.bodies.entities], bool)
        return exact[self.bodies.entity] if len(self.bodies) else np.zeros(0, bool)

    def _both_convex(self, pairs: IntArray) -> npt.NDArray[np.bool_]:
        """Return for which pairs (M,) both bodies are convex."""
        return np.asarray(self._convex[pairs].all(axis=1), bool)

    def _posed(self, pairs: IntArray, shift: FloatArray) -> Pairs:
        """Return pairs for the distance functions, with the first bodies moved by ``shift``."""
        posed = self.bodies.pairs(pairs)
        matrices = posed.a.matrices.copy()
        matrices[:, :, 3] += shift
        return Pairs(replace(posed.a, matrices=matrices), posed.b)

    def _surface(self, body: int) -> Manifold:
        """Return the solid of a body in the scene's frame."""
        number = int(self.bodies.entity[body])
        if number not in self._surfaces:
            self._surfaces[number] = _surface_of(self._mesh(body))
        return self._surfaces[number].transform(self._pose(body))

    def _mesh(self, body: int) -> Mesh:
        """Return the surface of a body in the frame of its primitive."""
        number = int(self.bodies.entity[body])
        if number not in self._meshes:
            shape = self.bodies.entities[number].shape
            assert shape is not None
            self._meshes[number] = leaf_mesh(shape, _SEGMENTS)
        return self._meshes[number]

    def _vertices(self, body: int) -> FloatArray:
        """Return the vertices (K, 3) of the surface of a body in the scene's frame."""
        pose = self._pose(body)
        return np.asarray(self._mesh(body).vertices @ pose[:, :3].T + pose[:, 3], np.float64)

    def triangles(self, body: int) -> tuple[FloatArray, IntArray]:
        """Return the vertices (K, 3) of the surface of a body in the scene's frame, and its triangles (M, 3)."""
        return self._vertices(body), np.asarray(self._mesh(body).faces, np.int64)

    def _pose(self, body: int) -> FloatArray:
        """Return the pose (3, 4) of the primitive of a body in the scene's frame."""
        return np.asarray(self.ancestry.poses[self.ancestry.primitives[self.bodies.row[body]]], np.float64)

    def _gaps(self, pairs: IntArray, shift: FloatArray, reach: float) -> FloatArray:
        """Return the distances (M,) of pairs, 0 where they overlap; those above ``reach`` may be ``reach``."""
        gaps = np.zeros(len(pairs))
        convex = np.flatnonzero(self._both_convex(pairs))
        for start in range(0, len(convex), _BATCH_PAIRS):
            rows = convex[start : start + _BATCH_PAIRS]
            gaps[rows] = distances(self._posed(pairs[rows], shift))
        for row in np.flatnonzero(~self._both_convex(pairs)).tolist():
            gaps[row] = self._surface_gap(_two(pairs[row]), shift, reach)
        return gaps

    def _surface_gap(self, pair: tuple[int, int], shift: FloatArray, reach: float) -> float:
        """Return the distance of the surfaces of two bodies, the first moved; ``reach`` if it is larger.

        ``min_gap`` compares all triangles within its reach, 0.7 s for two tori, so a bound of the gap is the first one.
        """
        i, j = pair
        a, b = self._surface(i).translate(shift.tolist()), self._surface(j)
        bound = _vertex_distance(self._vertices(i) + shift, self._vertices(j))
        near = _GAP_MARGIN * bound + 1e-9 * self.bodies.size
        gap = float(a.min_gap(b, min(near, reach)))
        is_bounded = gap < near or near >= reach  # not where a file has vertices without triangles
        return gap if is_bounded else float(a.min_gap(b, reach))

    def _overlap(self, pair: IntArray, shift: FloatArray) -> float:
        """Return the common volume of a pair of bodies, 0 for the rounding errors of surfaces that only touch."""
        a, b = (self._surface(int(body)) for body in pair)
        low, high = (corners[pair] for corners in self.bodies.boxes)
        volume = float((a.translate(shift.tolist()) ^ b).volume())
        return volume if volume > _MIN_OVERLAP * float((high - low).prod(axis=1).min()) else 0.0

    def _depth(self, pair: IntArray, shift: FloatArray) -> tuple[float, FloatArray]:
        """Return the least translation along an axis that separates an overlapping pair: its length and direction (3,).

        The first body is moved.
        """
        low, high = self.bodies.boxes
        a, b = pair.tolist()
        best, direction = np.inf, np.array([0.0, 1.0, 0.0])
        if self._overlap(pair, shift) <= 0.0:
            return 0.0, direction
        for axis in range(3):
            for sign in (1.0, -1.0):
                along = np.zeros(3)
                along[axis] = sign
                out = high[b] - low[a] - shift if sign > 0.0 else high[a] + shift - low[b]
                length = self._least_shift(pair, shift, along, min(float(out[axis]), best))
                if length < best:
                    best, direction = length, along
        return best, direction

    def _least_shift(self, pair: IntArray, shift: FloatArray, along: FloatArray, most: float) -> float:
        """Return the least translation along a direction that separates a pair, by bisection.

        Infinite if ``most`` does not separate it.
        """
        if self._overlap(pair, shift + along * most) > 0.0:
            return np.inf
        low, high = 0.0, most
        for _ in range(_BISECTIONS // 2):
            middle = (low + high) / 2.0
            if self._overlap(pair, shift + along * middle) > 0.0:
                low = middle
            else:
                high = middle
        return float(high)

    # --- objects -----------------------------------------------------------------------------------------------

    def separation(
        self, a: PlacedObject, b: PlacedObject, shift: Sequence[float] = (0.0, 0.0, 0.0)
    ) -> Separation | None:
        """Return the separation of two objects, the first moved by ``shift``; None if one has no bodies."""
        moved = np.asarray(shift, np.float64)
        cached = self._separations.get((a.instance, b.instance))
        if cached is not None and not moved.any():
            return cached
        nearest = self._nearest(a, b, moved)
        if nearest is None:
            return None
        pairs, gaps = nearest
        best = int(np.argmin(gaps))
        if gaps[best] > 0.0:
            return Separation(float(gaps[best]), _two(pairs[best]))
        return self._deepest(pairs[gaps <= 0.0], moved)

    def gap(self, a: PlacedObject, b: PlacedObject) -> float | None:
        """Return the distance of two objects, 0 if they touch or overlap; None if one has no bodies.

        It needs no depth, which takes most of the time of ``separation``.
        """
        nearest = self._nearest(a, b, np.zeros(3))
        return None if nearest is None else float(nearest[1].min())

    def _nearest(self, a: PlacedObject, b: PlacedObject, moved: FloatArray) -> tuple[IntArray, FloatArray] | None:
        """Return pairs (N, 2) of bodies, among them all that are nearest to each other, and their gaps (N,)."""
        pairs = self._pairs(a, b, np.inf, moved)
        if not len(pairs):
            return None
        low, high = self.bodies.boxes
        first, second = pairs[:, 0], pairs[:, 1]
        axis_gaps = np.maximum(np.maximum(low[first] + moved - high[second], low[second] - high[first] - moved), 0.0)
        box_gaps = np.linalg.norm(axis_gaps, axis=1)
        order = np.argsort(box_gaps, kind="stable")
        pairs, box_gaps = pairs[order], box_gaps[order]
        reach = 2.0 * self.bodies.size
        gaps = self._gaps(pairs[:_FIRST_PAIRS], moved, reach)
        others = np.flatnonzero(box_gaps[_FIRST_PAIRS:] <= gaps.min()) + _FIRST_PAIRS
        gaps = np.concatenate([gaps, self._gaps(pairs[others], moved, reach)])
        return np.concatenate([pairs[:_FIRST_PAIRS], pairs[others]]), gaps

    def _deepest(self, pairs: IntArray, shift: FloatArray) -> Separation:
        """Return the separation of two objects by the deepest of their overlapping pairs."""
        convex = self._both_convex(pairs)
        pairs = np.concatenate([pairs[convex], pairs[~convex][:_FIRST_PAIRS]])
        depth, along = self._depths(pairs, np.broadcast_to(shift, (len(pairs), 3)))
        worst = int(np.argmax(depth))
        return Separation(-max(float(depth[worst]), 0.0), _two(pairs[worst]), _three(along[worst]))

    def away(self, separation: Separation) -> Vector:
        """Return the direction in which the first of two objects leaves the second."""
        if separation.away is not None:
            return separation.away
        pair, shift = np.array(separation.bodies), np.zeros(3)
        if self._both_convex(pair[None])[0]:
            return _three(-depths(self._posed(pair[None], shift))[1][0])
        low, high = self.bodies.boxes
        a, b = pair.tolist()
        apart = np.maximum(low[a] + shift - high[b], 0.0) - np.maximum(low[b] - high[a] - shift, 0.0)
        if not apart.any():
            apart = (low[a] + high[a] - low[b] - high[b]) / 2.0 + shift
        return _three(apart / max(float(np.linalg.norm(apart)), 1e-300))

    def is_blocked(self, a: PlacedObject, b: PlacedObject, reach: float) -> bool:
        """Return whether ``b`` is within ``reach`` of ``a`` and keeps it from moving down.

        That is so if ``a``, moved down to contact and slightly further, has to move up by as much again to be clear of
        ``b``. The test needs no contact points, and is the same for tables, bowls and hooks.
        """
        comparison = self._comparisons.get((a.instance, b.instance, reach))
        if comparison is None:
            comparison = self._compared([(a, b)], [reach])[0]
        return comparison.blocked

    def prepare(
        self, subjects: Sequence[PlacedObject], objects: Sequence[PlacedObject], reaches: Sequence[float], limit: int
    ) -> dict[int, list[PlacedObject]] | None:
        """Compare all subjects with the objects within their reach at once, for later questions about single pairs.

        Returns the objects near each subject, by instance; None if there are more than ``limit`` pairs.
        """
        low, high = (np.array(corners) for corners in zip(*(self.box(placed) for placed in (*subjects, *objects))))
        near, complete = neighbors(low, high, max(reaches, default=0.0), limit)
        if not complete:
            return None
        count = len(subjects)
        cross = near[(near[:, 0] < count) & (near[:, 1] >= count)]
        pairs = [(subjects[i], objects[j - count]) for i, j in cross.tolist()]
        pair_reaches = [reaches[i] for i in cross[:, 0].tolist()]
        self.compare(pairs, pair_reaches)
        nearby: dict[int, list[PlacedObject]] = {}
        for (a, b), reach in zip(pairs, pair_reaches):
            comparison = self._comparisons.get((a.instance, b.instance, reach))
            if comparison is not None and comparison.separation is not None:
                nearby.setdefault(a.instance, []).append(b)
        return nearby

    def nearest(self, a: PlacedObject, others: Sequence[PlacedObject]) -> list[PlacedObject]:
        """Return the nearest of ``others``, or the one that overlaps ``a`` most, in a list.

        Only objects that were compared with ``a`` count; without any, the list is empty.
        """
        distances = {
            b.instance: self._separations[a.instance, b.instance].distance for b in others if b.instance != a.instance
        }
        return (
            [min((b for b in others if b.instance in distances), key=lambda b: distances[b.instance])]
            if distances
            else []
        )

    def compare(self, object_pairs: Sequence[_ObjectPair], reaches: Sequence[float]) -> None:
        """Compare pairs of objects that are within reach of each other at once, and cache the results."""
        wanted = [
            (pair, reach)
            for pair, reach in zip(object_pairs, reaches)
            if pair[0].instance != pair[1].instance
            and (pair[0].instance, pair[1].instance, reach) not in self._comparisons
        ]
        pairs, pair_reaches = [pair for pair, _ in wanted], [reach for _, reach in wanted]
        for (a, b), reach, comparison in zip(pairs, pair_reaches, self._compared(pairs, pair_reaches) if pairs else ()):
            self._comparisons[a.instance, b.instance, reach] = comparison
            if comparison.separation is not None:
                self._separations[a.instance, b.instance] = comparison.separation

    def _compared(self, object_pairs: Sequence[_ObjectPair], reaches: Sequence[float]) -> list[_Comparison]:
        """Compare pairs of objects where they are within reach of each other."""
        no_shift = np.zeros(3)
        blocks = [self._pairs(a, b, reach, no_shift) for (a, b), reach in zip(object_pairs, reaches)]
        pairs = np.concatenate(blocks)
        owner = np.repeat(np.arange(len(object_pairs)), [len(block) for block in blocks])
        reach = np.asarray(reaches)[owner]
        gaps = self._gaps(pairs, no_shift, 2.0 * float(np.max(reaches)) + 1e-12)
        close = gaps <= reach
        pairs, owner, gaps = pairs[close], owner[close], gaps[close]
        down = np.outer(gaps + self._further(object_pairs, pairs, owner), [0.0, -1.0, 0.0])
        before, away = self._depths(pairs, np.zeros((len(pairs), 3)))
        blocked = self._are_blocked(pairs, down, before, object_pairs, owner)
        comparisons = [_Comparison(False, None)] * len(object_pairs)
        for number in np.unique(owner).tolist():
            rows = np.flatnonzero(owner == number)
            deep = rows[np.argmax(np.where(gaps[rows] > 0.0, -gaps[rows], np.maximum(before[rows], 0.0)))]
            distance = float(gaps[deep]) if gaps[deep] > 0.0 else -max(float(before[deep]), 0.0)
            direction = None if gaps[deep] > 0.0 else _three(away[deep])
            comparisons[number] = _Comparison(
                bool(blocked[rows].any()), Separation(distance, _two(pairs[deep]), direction)
            )
        return comparisons

    def _further(self, object_pairs: Sequence[_ObjectPair], pairs: IntArray, owner: IntArray) -> FloatArray:
        """Return the distances (M,) by which the first objects are moved down beyond contact."""
        extent = np.array([float(np.subtract(*self.box(a)[::-1]).max()) for a, _ in object_pairs])[owner]
        low, high = self.bodies.boxes
        thin = (high - low)[:, 1][pairs].min(axis=1) if len(pairs) else np.zeros(0)
        return np.minimum(_PROBE_RATIO * extent, 0.25 * thin)

    def _depths(self, pairs: IntArray, shift: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return depths (M,) of pairs and the directions (M, 3) in which the first ones would move away."""
        depth, along = np.zeros(len(pairs)), np.zeros((len(pairs), 3))
        convex = self._both_convex(pairs)
        for start in range(0, int(convex.sum()), _BATCH_PAIRS):
            rows = np.flatnonzero(convex)[start : start + _BATCH_PAIRS]
            depth[rows], away = depths(self._posed(pairs[rows], shift[rows]))
            along[rows] = -away
        for row in np.flatnonzero(~convex).tolist():
            depth[row], along[row] = self._depth(pairs[row], shift[row])
        return depth, along

    def _are_blocked(
        self, pairs: IntArray, down: FloatArray, before: FloatArray, object_pairs: Sequence[_ObjectPair],
        owner: IntArray,
    ) -> npt.NDArray[np.bool_]:  # fmt: skip
        """Return for which pairs (M,) moving the first body down takes as much to undo."""
        is_blocked = np.zeros(len(pairs), bool)
        convex = np.flatnonzero(self._both_convex(pairs))
        if len(convex):
            after, _ = self._depths(pairs[convex], down[convex])
            is_blocked[convex] = after - before[convex] >= -_MIN_SUPPORT_NORMAL * down[convex, 1]
        for row in np.setdiff1d(np.arange(len(pairs)), convex).tolist():
            low, high = self.box(object_pairs[int(owner[row])][0])
            spread = float((high - low)[[0, 2]].prod())
            gained = self._overlap(pairs[row], down[row]) - self._overlap(pairs[row], np.zeros(3))
            is_blocked[row] = gained > -_MIN_SWEPT_SHARE * spread * float(down[row, 1])
        return is_blocked

    def fall(
        self,
        a: PlacedObject,
        others: Sequence[PlacedObject],
        start: float = 0.0,
        sideways: FloatArray | Sequence[float] = (0.0, 0.0, 0.0),
    ) -> float | None:
        """Return the distance that ``a`` can move down until it meets one of ``others``; None if it meets none.

        ``a`` is first raised by ``start`` and moved ``sideways``.
        """
        low, high = self.bodies.boxes
        least_fall = np.inf
        moved = np.asarray(sideways, np.float64) + np.array([0.0, start, 0.0])
        heights = [float(high[other.first : other.last, 1].max(initial=-np.inf)) for other in others]
        for other in (others[number] for number in np.argsort(heights, kind="stable")[::-1]):  # the highest first
            pairs = self._rows_below(a, other, moved)
            clear = low[pairs[:, 0], 1] + moved[1] - high[pairs[:, 1], 1]
            for row in np.argsort(clear, kind="stable").tolist():
                if clear[row] >= least_fall:
                    break
                far = min(least_fall, float(high[pairs[row, 0], 1] + moved[1] - low[pairs[row, 1], 1]))
                least_fall = min(
                    least_fall, self._first_touch(pairs[row : row + 1], moved, max(float(clear[row]), 0.0), far)
                )
        return float(least_fall) if np.isfinite(least_fall) else None

    def _rows_below(self, a: PlacedObject, b: PlacedObject, moved: FloatArray) -> IntArray:
        """Return the pairs (M, 2) of bodies of two objects of which the second is below the first, moved."""
        low, high = self.bodies.boxes
        pairs = np.stack(np.meshgrid(self._rows(a, b), self._rows(b, a), indexing="ij"), axis=-1).reshape(-1, 2)
        first, second = pairs.T
        under = low[second, 1] < high[first, 1] + moved[1]
        for axis in (0, 2):
            under &= low[first, axis] + moved[axis] < high[second, axis]
            under &= high[first, axis] + moved[axis] > low[second, axis]
        return np.asarray(pairs[under], np.int64)

    def _first_touch(self, pair: IntArray, moved: FloatArray, near: float, far: float) -> float:
        """Return the least fall at which a pair of bodies meets, between two bounds; infinite if it does not."""

        convex = bool(self._both_convex(pair)[0])

        def meets(fall: float) -> bool:
            """Return whether the pair overlaps after a fall."""
            shift = moved - np.array([0.0, fall, 0.0])
            return bool(self._gaps(pair, shift, 0.0)[0] <= 0.0) if convex else self._overlap(pair[0], shift) > 0.0

        samples = np.linspace(near, far, _FALL_SAMPLES).tolist()
        touching = next((k for k, fall in enumerate(samples) if meets(fall)), None)
        if not touching:
            return np.inf if touching is None else near
        low, high = samples[touching - 1], samples[touching]
        for _ in range(_BISECTIONS):
            middle = (low + high) / 2.0
            low, high = (low, middle) if meets(middle) else (middle, high)
        return float(high)

    def hull(self, placed: PlacedObject, other: PlacedObject | None = None) -> Manifold:
        """Return the convex hull of an object, without the bodies of ``other``."""
        import manifold3d

        rows = self._rows(placed, other) if other is not None else np.arange(placed.first, placed.last)
        points = [self._vertices(int(row)) for row in rows]
        return manifold3d.Manifold.hull_points(np.concatenate(points)) if points else manifold3d.Manifold()


def _vertex_distance(first: FloatArray, second: FloatArray) -> float:
    """Return the distance of two near vertices of surfaces (K, 3) and (L, 3), an upper bound of their gap."""
    to, best = second.mean(axis=0), np.inf
    for _ in range(_GAP_ROUNDS):
        start = first[np.linalg.norm(first - to, axis=1).argmin()]
        lengths = np.linalg.norm(second - start, axis=1)
        to, length = second[lengths.argmin()], float(lengths.min())
        if length >= best:
            break
        best = length
    return best


def _is_convex(entity: Entity) -> bool:
    """Return whether a primitive is exactly a convex canonical form; semantic primitives are boxes."""
    placed = None if entity.shape is None else entity.shape.placed()
    return placed is not None and placed.form.is_convex


def _surface_of(mesh: Mesh) -> Manifold:
    """Return the solid that a surface encloses; of an open surface, its convex hull."""
    import manifold3d

    try:
        return manifold_of_mesh(mesh, "")
    except SceneError:
        return manifold3d.Manifold.hull_points(mesh.vertices)


def _two(pair: IntArray) -> tuple[int, int]:
    """Return a pair of bodies as integers."""
    return int(pair[0]), int(pair[1])


def _three(vector: FloatArray) -> Vector:
    """Return a vector (3,) as floats."""
    return float(vector[0]), float(vector[1]), float(vector[2])


def share_of(inner: Manifold, outer: Manifold) -> float | None:
    """Return the fraction of the volume of a solid that is inside another; None if either has no volume."""
    volume = inner.volume()
    if inner.is_empty() or outer.is_empty() or volume <= 0.0:
        return None
    return float((inner ^ outer).volume() / volume)


def seen_share(inner: Manifold, outer: Manifold, kept: Sequence[int]) -> float | None:
    """Return the fraction of the outline of a convex solid that is inside that of another, both projected.

    Parameters
    ----------
    inner, outer
        Convex solids.
    kept
        The two axes that the projection keeps.

    Returns
    -------
    float or None
        None if either outline has no area.
    """
    import manifold3d

    first, second = (
        manifold3d.CrossSection.hull_points(np.asarray(solid.to_mesh64().vert_properties[:, kept], np.float64))
        for solid in (inner, outer)
    )
    area = first.area()
    if area <= 0.0 or second.area() <= 0.0:
        return None
    return float((first ^ second).area() / area)


# --- all relations of a frame ----------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Related:
    """Relation that holds between two objects of a frame.

    Attributes
    ----------
    relation
        "on", "inside", "touching" or "overlapping".
    subject, other
        Numbers of the two instances in the ancestry of the frame.
    distance
        Signed distance in scene units, negative where they overlap.
    """

    relation: str
    subject: int
    other: int
    distance: float


def related(arrangement: Arrangement, rows: Sequence[int], limit: int = _MAX_RELATED_PAIRS) -> list[Related]:
    """Return the relations of objects that touch or overlap and have the same container.

    ``rows`` are the instances; the container of one is its nearest ancestor among them. Raises LimitError for more than
    ``limit`` pairs of nearby objects.
    """
    containers = _parents(arrangement, rows)
    objects = [arrangement.object_at(row) for row in rows]
    boxes = [arrangement.box(placed) for placed in objects]
    low, high = np.array([box[0] for box in boxes]).reshape(-1, 3), np.array([box[1] for box in boxes]).reshape(-1, 3)
    reach = max((arrangement.touch(placed) for placed in objects), default=0.0)
    pairs, complete = neighbors(low, high, reach, limit)
    if not complete:
        raise LimitError("primitives", f"more than {limit:,} pairs of things are near each other")
    relations: list[Related] = []
    siblings = [(objects[i], objects[j]) for i, j in pairs.tolist() if containers[i] == containers[j]]
    both = [*siblings, *((b, a) for a, b in siblings)]
    arrangement.compare(both, [min(arrangement.touch(a), arrangement.touch(b)) for a, b in both])
    for a, b in siblings:
        if a.last > a.first and b.last > b.first:
            relations += _relations_between(arrangement, a, b)
    return relations


def _parents(arrangement: Arrangement, rows: Sequence[int]) -> list[int]:
    """Return for each instance its nearest ancestor among ``rows``, -1 for none."""
    known = set(rows)
    parents = []
    for row in rows:
        above = int(arrangement.ancestry.parent[row])
        while above >= 0 and above not in known:
            above = int(arrangement.ancestry.parent[above])
        parents.append(above)
    return parents


def _relations_between(arrangement: Arrangement, a: PlacedObject, b: PlacedObject) -> Iterator[Related]:
    """Yield the relations of two objects: inside, on, or else overlapping or touching."""
    reach = min(arrangement.touch(a), arrangement.touch(b))
    separation = arrangement.separation(a, b)
    if separation is None or separation.distance > reach:
        return
    pair = (a.instance, b.instance)
    for inner, outer in ((a, b), (b, a)):
        (low, high), (under, over) = arrangement.box(inner), arrangement.box(outer)
        if bool((low >= under - reach).all() and (high <= over + reach).all()):
            share = share_of(arrangement.hull(inner), arrangement.hull(outer))
            if share is not None and share >= _INSIDE_SHARE:
                yield Related("inside", inner.instance, outer.instance, separation.distance)
    is_supported = False
    for upper, lower in ((a, b), (b, a)):
        (low, high), (under, _) = arrangement.box(upper), arrangement.box(lower)
        sunk = max(reach, SUNK * float(high[1] - low[1]))
        if -sunk <= separation.distance and low[1] > under[1] - reach and arrangement.is_blocked(upper, lower, reach):
            is_supported = True
            yield Related("on", upper.instance, lower.instance, separation.distance)
    if not is_supported:
        yield Related("overlapping" if separation.distance < -reach else "touching", *pair, separation.distance)


def paired(center: FloatArray, mirrored: FloatArray, size: FloatArray, words: IntArray, within: float) -> IntArray:
    """Return the boxes that have a mirror image among the others.

    ``center`` and ``mirrored`` (N, 3) are the centers of the boxes and of their mirror images, ``size`` (N, 3) and
    ``words`` (N,) must be equal; ``within`` is the tolerance in scene units.
    """
    count = len(center)
    places = np.concatenate([center, mirrored])
    near, _ = neighbors(places, places, within, MAX_PAIRS)
    first, second = near[(near[:, 0] < count) & (near[:, 1] >= count)].T
    second = second - count
    is_match = (words[first] == words[second]) & (np.abs(size[first] - size[second]).max(axis=1, initial=0.0) <= within)
    is_match &= np.abs(center[first] - mirrored[second]).max(axis=1, initial=0.0) <= within
    return np.unique(second[is_match])


@dataclass(frozen=True, slots=True)
class SceneRelation:
    """A relation that holds between two objects.

    Attributes
    ----------
    relation : str
        "on", "inside", "touching" or "overlapping".
    subject, other : str
        Handles of the two objects, such as "z3".
    subject_word, other_word : str
        Their words.
    distance : float
        Signed distance of their surfaces in scene units, negative where they overlap.
    """

    relation: str
    subject: str
    other: str
    subject_word: str
    other_word: str
    distance: float


def scene_relations(
    scene: Scene, words: Collection[str] | None = None, frame: int = 0, limit: int = _MAX_RELATED_PAIRS
) -> list[SceneRelation]:
    """Return the relations of objects that touch or overlap in a frame, as ``Scene.relations`` documents.

    ``words`` selects the objects; by default all words that the program binds and semantic primitives, without the
    root. ``limit`` is the maximum number of pairs of nearby objects; raises LimitError.
    """
    root = scene.frames[frame]
    arrangement = Arrangement(scene, scene.frames.index(root))
    ancestry = arrangement.ancestry
    is_chosen = [
        entity.word in words if words is not None else is_object(entity) and entity is not root
        for entity in ancestry.nodes
    ]
    rows = [row for row, node in enumerate(ancestry.node.tolist()) if is_chosen[node]]
    relations = related(arrangement, rows, limit)
    numbers = frame_numbers(scene) if len(scene.frames) > 1 else None
    related_rows = sorted({row for relation in relations for row in (relation.subject, relation.other)})
    handles = some_handles(scene, ancestry, related_rows, numbers)
    words_of = {row: ancestry.entity(row).word for row in handles}
    return [
        SceneRelation(
            relation.relation, handles[relation.subject], handles[relation.other],
            words_of[relation.subject], words_of[relation.other], relation.distance,
        )
        for relation in relations
    ]  # fmt: skip
