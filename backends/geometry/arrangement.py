"""Where the things of one frame are: instances by word or handle, exact distances, overlaps and free falls.

Convex primitives are compared by their support functions (``distance``), all others by their surfaces (Manifold).
Semantic primitives count as their boxes.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import numpy.typing as npt

from scenelang.backends.geometry.lint import ground_height
from scenelang.backends.surfaces.convex import MAX_PAIRS, Bodies, bodies_of, clusters
from scenelang.backends.surfaces.distance import IntArray, Pairs, depths, distances, neighbours
from scenelang.backends.surfaces.solids import FloatArray, is_object
from scenelang.grammar.diagnostics import LimitError, SceneError
from scenelang.interpreter.inspection.instance_paths import Locator, is_handle, is_plain
from scenelang.interpreter.inspection.numbering import Ancestry, ancestry_of, frame_numbers, some_handles
from scenelang.interpreter.scene.bounds import parts_box
from scenelang.interpreter.scene.entity import Entity, Scene, contains_blocks
from scenelang.interpreter.scene.modelling.computing import leaf_mesh, manifold_of_mesh
from scenelang.interpreter.scene.primitives.mesh import Mesh
from scenelang.interpreter.values.values import Matrix, Pair

if TYPE_CHECKING:
    from manifold3d import Manifold

_SEGMENTS = 64  # sides of a round form that is compared with a surface
_BATCH = 20_000  # pairs that are compared at a time
_NEAREST = 64  # pairs that are compared first, to leave out all that are farther apart
_TOUCH = 1e-3  # of the frame's diagonal: closer things touch
_TOUCH_OWN = 0.02  # the same of the thing's own extent
_HALVINGS = 30
_FURTHER = 0.02  # of a thing's extent
_UPRIGHT = 0.6  # vertical part of the direction in which something carries a thing: up to 53 degrees of slope
_TRIES = 17  # heights at which a fall is tested first
SUNK = 0.05  # of its height: how deep a thing may be in what it rests on
_ENCLOSED = 0.95  # of its volume, in the hull of what it is inside of
_MAX_RELATED = 20_000
_SLIVER = 1e-4  # of the volume that a thing sweeps: less is rounding

Vector = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Thing:
    """One instance in a frame: its number in the ancestry, and the half-open range of its bodies."""

    instance: int
    entity: Entity
    first: int
    last: int


@dataclass(frozen=True, slots=True)
class Separation:
    """How far two things are apart: the signed distance, negative where they overlap, the pair of bodies that decides,
    and, where they overlap, the direction in which the first one would move away."""

    distance: float
    bodies: tuple[int, int]
    away: Vector | None = None


class _Near(NamedTuple):
    """What two things within reach are to each other: whether the second carries the first, and their separation."""

    blocked: bool
    separation: Separation | None


class Arrangement:
    """Things of one frame of a scene.

    Raises SceneError for meshes that cannot be read.
    """

    def __init__(self, scene: Scene, frame: int = 0) -> None:
        self.scene = scene
        self.frame = frame
        self.root = scene.frames[frame]
        self.ancestry: Ancestry = ancestry_of(self.root)
        self.bodies: Bodies = bodies_of(self.root)
        self._surfaces: dict[int, Manifold] = {}
        self._meshes: dict[int, Mesh] = {}
        self._boxes: dict[int, tuple[FloatArray, FloatArray]] = {}
        self._within: dict[int, IntArray] = {}
        self._near: dict[tuple[int, int, float], _Near] = {}
        self._separations: dict[tuple[int, int], Separation] = {}

    # --- instances ---------------------------------------------------------------------------------------------

    @cached_property
    def _ranges(self) -> tuple[IntArray, IntArray]:
        """The first and last primitive (M,) of every instance."""
        ancestry = self.ancestry
        first, last = np.full(len(ancestry), np.iinfo(np.int64).max), np.full(len(ancestry), -1)
        rows = np.arange(len(ancestry.primitives))
        first[ancestry.primitives] = last[ancestry.primitives] = rows
        for depth in range(ancestry.max_depth, 0, -1):
            level = np.flatnonzero(ancestry.depth == depth)
            np.minimum.at(first, ancestry.parent[level], first[level])
            np.maximum.at(last, ancestry.parent[level], last[level])
        return first, last

    def thing(self, instance: int) -> Thing:
        first, last = self._ranges
        start = int(np.searchsorted(self.bodies.row, first[instance]))
        end = int(np.searchsorted(self.bodies.row, last[instance], side="right"))
        return Thing(instance, self.ancestry.entity(instance), start, end)

    def path(self, thing: Thing) -> str:
        """Return the path that means a thing only."""
        return self._locator.path(self.ancestry.path(thing.instance))

    def rows(self, thing: Thing | None) -> tuple[int, int] | None:
        """Return the first and last primitive of a thing in the flattened frame."""
        first, last = self._ranges
        return None if thing is None else (int(first[thing.instance]), int(last[thing.instance]))

    @cached_property
    def _rows_by_word(self) -> dict[str, IntArray]:
        found: dict[str, list[int]] = {}
        for number, entity in enumerate(self.ancestry.nodes):
            found.setdefault(entity.word, []).append(number)
        order = np.argsort(self.ancestry.node, kind="stable")
        ends = np.searchsorted(self.ancestry.node[order], np.arange(len(self.ancestry.nodes) + 1))
        return {
            word: np.sort(np.concatenate([order[ends[n] : ends[n + 1]] for n in numbers]))
            for word, numbers in found.items()
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
        """Return all instances with a word, a handle such as "<z3>", or a path, that are ``within`` or below it."""
        if name.startswith("<") and is_handle(name):
            return [int(row) for row in self._rows_with_handle(name.strip("<>"), within)]
        if not is_plain(name):
            return self._rows_at(name, within)
        rows = self._rows_by_word.get(name, np.zeros(0, np.int64))
        return [int(row) for row in (rows if within == 0 else rows[self._is_below(within)[rows]])]

    def _rows_at(self, path: str, within: int) -> list[int]:
        """Return the instances that a path means below ``within`` and that have primitives, none if it is wrong."""
        start = self._locator.at(self.ancestry.path(within))
        try:
            found = self._locator.find(path, start)
        except LimitError:
            raise
        except SceneError:
            return []
        return sorted(row for each in found if (row := self._row(each.positions)) is not None)

    def problem_of(self, path: str, within: int) -> str | None:
        """Return why a path means nothing below ``within``, None for what is no path."""
        if is_plain(path) or is_handle(path):
            return None
        try:
            self._locator.find(path, self._locator.at(self.ancestry.path(within)))
        except SceneError as error:
            return f"{error.message}: {error.hint}" if error.hint else error.message
        return None

    def contains(self, thing: Thing, other: Thing) -> bool:
        """Return whether ``other`` is a part of a thing."""
        return thing.instance != other.instance and bool(self._is_below(thing.instance)[other.instance])

    def _row(self, positions: Sequence[int]) -> int | None:
        ancestry, row = self.ancestry, 0
        for position in positions:
            found = np.flatnonzero((ancestry.parent == row) & (ancestry.position == position))
            if not len(found):
                return None
            row = int(found[0])
        return row

    @cached_property
    def _locator(self) -> Locator:
        return Locator(self.scene, self.frame)

    def things(self, name: str, within: int = 0) -> list[Thing]:
        """Return the outermost instances with a word, handle or path that are ``within`` or below it."""
        rows = self.instances(name, within)
        known = set(rows)
        return [self.thing(row) for row in rows if not self._has_above(row, known)]

    def _has_above(self, row: int, known: set[int]) -> bool:
        above = int(self.ancestry.parent[row])
        while above >= 0:
            if above in known:
                return True
            above = int(self.ancestry.parent[above])
        return False

    def words(self) -> list[str]:
        return sorted(self._rows_by_word)

    def has_blocks(self, thing: Thing) -> bool:
        return contains_blocks(thing.entity, lambda _: None)

    # --- boxes and frames --------------------------------------------------------------------------------------

    def box(self, thing: Thing) -> tuple[FloatArray, FloatArray]:
        """Return the exact bounding box in the scene's frame: low and high corner (3,)."""
        found = self._boxes.get(thing.instance)
        if found is None:
            pose = Matrix(self.ancestry.poses[thing.instance].ravel().tolist())
            box = parts_box((Pair(thing.entity, pose),))
            assert box is not None  # instances have primitives
            found = self._boxes[thing.instance] = (np.array(box[:3]), np.array(box[3:]))
        return found

    def center(self, thing: Thing) -> FloatArray:
        low, high = self.box(thing)
        return np.asarray((low + high) / 2.0, np.float64)

    def axis(self, thing: Thing, axis: str) -> FloatArray:
        """Return the unit vector (3,) of an axis of the thing's own frame, in the scene's."""
        column = self.ancestry.poses[thing.instance][:, "xyz".index(axis)]
        return np.asarray(column / max(float(np.linalg.norm(column)), 1e-300), np.float64)

    def touch(self, thing: Thing) -> float:
        """Return the length below which the thing touches another."""
        low, high = self.box(thing)
        return max(min(_TOUCH * self.bodies.size, _TOUCH_OWN * float((high - low).max())), 1e-9 * self.bodies.size)

    @cached_property
    def ground(self) -> float:
        """The height that the scene stands on: 0 if something stands there, else that of its lowest point."""
        return ground_height(self.bodies) if len(self.bodies) else 0.0

    # --- pairs of bodies ---------------------------------------------------------------------------------------

    def _rows(self, thing: Thing, other: Thing) -> IntArray:
        """Return the bodies of a thing without those of ``other``, which may be a part of it."""
        rows = np.arange(thing.first, thing.last)
        if thing.first <= other.first and other.last <= thing.last:
            rows = rows[(rows < other.first) | (rows >= other.last)]
        return rows

    def _pairs(self, a: Thing, b: Thing, reach: float, shift: FloatArray) -> IntArray:
        """Return the pairs (M, 2) of bodies of two things whose boxes are within ``reach``."""
        first, second = self._rows(a, b), self._rows(b, a)
        low, high = self.bodies.boxes
        found = []
        step = max(1, _BATCH * 50 // max(1, len(second)))
        for start in range(0, len(first), step):
            rows = first[start : start + step]
            below, above = low[rows, None] + shift - high[None, second], low[None, second] - high[rows, None] - shift
            apart = np.maximum(below, above)
            near = np.nonzero(np.linalg.norm(np.maximum(apart, 0.0), axis=2) <= reach)
            found.append(np.stack([rows[near[0]], second[near[1]]], axis=1))
        return np.concatenate(found) if found else np.zeros((0, 2), np.int64)

    @cached_property
    def _convex(self) -> npt.NDArray[np.bool_]:
        """Which bodies (N,) are compared by their support functions."""
        exact = np.array([_is_convex(entity) for entity in self.bodies.entities], bool)
        return exact[self.bodies.entity] if len(self.bodies) else np.zeros(0, bool)

    def _both_convex(self, pairs: IntArray) -> npt.NDArray[np.bool_]:
        return np.asarray(self._convex[pairs].all(axis=1), bool)

    def _posed(self, pairs: IntArray, shift: FloatArray) -> Pairs:
        found = self.bodies.pairs(pairs)
        matrices = found.a.matrices.copy()
        matrices[:, :, 3] += shift
        return Pairs(replace(found.a, matrices=matrices), found.b)

    def _surface(self, body: int) -> Manifold:
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

    def _pose(self, body: int) -> FloatArray:
        """Return the pose (3, 4) of the primitive of a body in the scene's frame."""
        return np.asarray(self.ancestry.poses[self.ancestry.primitives[self.bodies.row[body]]], np.float64)

    def _gaps(self, pairs: IntArray, shift: FloatArray, reach: float) -> FloatArray:
        """Return the distances (M,) of pairs, 0 where they overlap; those above ``reach`` may be ``reach``."""
        gaps = np.zeros(len(pairs))
        convex = np.flatnonzero(self._both_convex(pairs))
        for start in range(0, len(convex), _BATCH):
            rows = convex[start : start + _BATCH]
            gaps[rows] = distances(self._posed(pairs[rows], shift))
        for row in np.flatnonzero(~self._both_convex(pairs)).tolist():
            a, b = (self._surface(body) for body in pairs[row].tolist())
            gaps[row] = a.translate(shift.tolist()).min_gap(b, reach)
        return gaps

    def _overlap(self, pair: IntArray, shift: FloatArray) -> float:
        """Return the volume that a pair of bodies shares."""
        a, b = (self._surface(int(body)) for body in pair)
        return float((a.translate(shift.tolist()) ^ b).volume())

    def _depth(self, pair: IntArray, shift: FloatArray) -> tuple[float, FloatArray]:
        """Return the least translation along an axis of the first of an overlapping pair that separates it from the
        second: its length and its direction (3,)."""
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
                least = self._least_shift(pair, shift, along, min(float(out[axis]), best))
                if least < best:
                    best, direction = least, along
        return best, direction

    def _least_shift(self, pair: IntArray, shift: FloatArray, along: FloatArray, most: float) -> float:
        """Return the least translation along a direction that separates a pair, ``most`` if that is less."""
        if self._overlap(pair, shift + along * most) > 0.0:
            return np.inf
        low, high = 0.0, most
        for _ in range(_HALVINGS // 2):
            middle = (low + high) / 2.0
            if self._overlap(pair, shift + along * middle) > 0.0:
                low = middle
            else:
                high = middle
        return float(high)

    # --- things ------------------------------------------------------------------------------------------------

    def separation(self, a: Thing, b: Thing, shift: Sequence[float] = (0.0, 0.0, 0.0)) -> Separation | None:
        """Return how far two things are apart, the first moved by ``shift``; None if one has no bodies."""
        moved = np.asarray(shift, np.float64)
        known = self._separations.get((a.instance, b.instance))
        if known is not None and not moved.any():
            return known
        pairs = self._pairs(a, b, np.inf, moved)
        if not len(pairs):
            return None
        low, high = self.bodies.boxes
        first, second = pairs[:, 0], pairs[:, 1]
        apart = np.maximum(np.maximum(low[first] + moved - high[second], low[second] - high[first] - moved), 0.0)
        least = np.linalg.norm(apart, axis=1)
        order = np.argsort(least, kind="stable")
        pairs, least = pairs[order], least[order]
        reach = 2.0 * self.bodies.size
        gaps = self._gaps(pairs[:_NEAREST], moved, reach)
        rest = np.flatnonzero(least[_NEAREST:] <= gaps.min()) + _NEAREST
        gaps = np.concatenate([gaps, self._gaps(pairs[rest], moved, reach)])
        pairs = np.concatenate([pairs[:_NEAREST], pairs[rest]])
        best = int(np.argmin(gaps))
        if gaps[best] > 0.0:
            return Separation(float(gaps[best]), _two(pairs[best]))
        return self._deepest(pairs[gaps <= 0.0], moved)

    def _deepest(self, pairs: IntArray, shift: FloatArray) -> Separation:
        convex = self._both_convex(pairs)
        pairs = np.concatenate([pairs[convex], pairs[~convex][:_NEAREST]])
        depth, along = self._depths(pairs, np.broadcast_to(shift, (len(pairs), 3)))
        worst = int(np.argmax(depth))
        return Separation(-max(float(depth[worst]), 0.0), _two(pairs[worst]), _three(along[worst]))

    def away(self, found: Separation) -> Vector:
        """Return the direction in which the first of two things would move away from the second."""
        if found.away is not None:
            return found.away
        pair, shift = np.array(found.bodies), np.zeros(3)
        if self._both_convex(pair[None])[0]:
            return _three(-depths(self._posed(pair[None], shift))[1][0])
        low, high = self.bodies.boxes
        a, b = pair.tolist()
        apart = np.maximum(low[a] + shift - high[b], 0.0) - np.maximum(low[b] - high[a] - shift, 0.0)
        if not apart.any():
            apart = (low[a] + high[a] - low[b] - high[b]) / 2.0 + shift
        return _three(apart / max(float(np.linalg.norm(apart)), 1e-300))

    def is_blocked(self, a: Thing, b: Thing, reach: float) -> bool:
        """Return whether ``b`` is within ``reach`` of ``a`` and keeps it from moving down.

        It does where ``a``, moved down to it and a little further, has to move up by as much again to be clear of it.
        """
        known = self._near.get((a.instance, b.instance, reach))
        if known is None:
            known = self._compared([(a, b)], [reach])[0]
        return known.blocked

    def prepare(
        self, subjects: Sequence[Thing], objects: Sequence[Thing], reaches: Sequence[float], limit: int
    ) -> dict[int, list[Thing]] | None:
        """Compare all subjects with the objects within their reach at once, for later questions about single pairs.

        Returns the objects near each subject, by instance; None if there are more than ``limit`` pairs.
        """
        low, high = (np.array(each) for each in zip(*(self.box(thing) for thing in (*subjects, *objects))))
        near, complete = neighbours(low, high, max(reaches, default=0.0), limit)
        if not complete:
            return None
        count = len(subjects)
        cross = near[(near[:, 0] < count) & (near[:, 1] >= count)]
        pairs = [(subjects[i], objects[j - count]) for i, j in cross.tolist()]
        own = [reaches[i] for i in cross[:, 0].tolist()]
        self.compare(pairs, own)
        found: dict[int, list[Thing]] = {}
        for (a, b), reach in zip(pairs, own):
            known = self._near.get((a.instance, b.instance, reach))
            if known is not None and known.separation is not None:
                found.setdefault(a.instance, []).append(b)
        return found

    def nearest(self, a: Thing, others: Sequence[Thing]) -> list[Thing]:
        """Return the nearest of things that were compared with ``a``, or that overlaps it most; none of none."""
        known = {
            b.instance: self._separations[a.instance, b.instance].distance for b in others if b.instance != a.instance
        }
        return [min((b for b in others if b.instance in known), key=lambda b: known[b.instance])] if known else []

    def compare(self, things: Sequence[tuple[Thing, Thing]], reaches: Sequence[float]) -> None:
        """Compare pairs of things that are within reach of each other at once, for later questions about them."""
        wanted = [
            (pair, reach)
            for pair, reach in zip(things, reaches)
            if pair[0].instance != pair[1].instance and (pair[0].instance, pair[1].instance, reach) not in self._near
        ]
        pairs, own = [pair for pair, _ in wanted], [reach for _, reach in wanted]
        for (a, b), reach, found in zip(pairs, own, self._compared(pairs, own) if pairs else ()):
            self._near[a.instance, b.instance, reach] = found
            if found.separation is not None:
                self._separations[a.instance, b.instance] = found.separation

    def _compared(self, things: Sequence[tuple[Thing, Thing]], reaches: Sequence[float]) -> list[_Near]:
        """Compare pairs of things where they are within reach of each other."""
        still = np.zeros(3)
        blocks = [self._pairs(a, b, reach, still) for (a, b), reach in zip(things, reaches)]
        pairs = np.concatenate(blocks)
        owner = np.repeat(np.arange(len(things)), [len(block) for block in blocks])
        reach = np.asarray(reaches)[owner]
        gaps = self._gaps(pairs, still, 2.0 * float(np.max(reaches)) + 1e-12)
        close = gaps <= reach
        pairs, owner, gaps = pairs[close], owner[close], gaps[close]
        down = np.outer(gaps + self._further(things, pairs, owner), [0.0, -1.0, 0.0])
        before, away = self._depths(pairs, np.zeros((len(pairs), 3)))
        blocked = self._are_blocked(pairs, down, before, things, owner)
        found = [_Near(False, None)] * len(things)
        for number in np.unique(owner).tolist():
            rows = np.flatnonzero(owner == number)
            deep = rows[np.argmax(np.where(gaps[rows] > 0.0, -gaps[rows], np.maximum(before[rows], 0.0)))]
            distance = float(gaps[deep]) if gaps[deep] > 0.0 else -max(float(before[deep]), 0.0)
            towards = None if gaps[deep] > 0.0 else _three(away[deep])
            found[number] = _Near(bool(blocked[rows].any()), Separation(distance, _two(pairs[deep]), towards))
        return found

    def _further(self, things: Sequence[tuple[Thing, Thing]], pairs: IntArray, owner: IntArray) -> FloatArray:
        """Return how far beyond contact the first things are moved down, (M,)."""
        extent = np.array([float(np.subtract(*self.box(a)[::-1]).max()) for a, _ in things])[owner]
        low, high = self.bodies.boxes
        thin = (high - low)[:, 1][pairs].min(axis=1) if len(pairs) else np.zeros(0)
        return np.minimum(_FURTHER * extent, 0.25 * thin)

    def _depths(self, pairs: IntArray, shift: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return depths (M,) of pairs and the directions (M, 3) in which the first ones would move away."""
        depth, along = np.zeros(len(pairs)), np.zeros((len(pairs), 3))
        convex = self._both_convex(pairs)
        for start in range(0, int(convex.sum()), _BATCH):
            rows = np.flatnonzero(convex)[start : start + _BATCH]
            depth[rows], away = depths(self._posed(pairs[rows], shift[rows]))
            along[rows] = -away
        for row in np.flatnonzero(~convex).tolist():
            depth[row], along[row] = self._depth(pairs[row], shift[row])
        return depth, along

    def _are_blocked(
        self, pairs: IntArray, down: FloatArray, before: FloatArray, things: Sequence[tuple[Thing, Thing]],
        owner: IntArray,
    ) -> npt.NDArray[np.bool_]:  # fmt: skip
        """Return for which pairs (M,) moving the first down takes as much to undo."""
        found = np.zeros(len(pairs), bool)
        convex = np.flatnonzero(self._both_convex(pairs))
        if len(convex):
            after, _ = self._depths(pairs[convex], down[convex])
            found[convex] = after - before[convex] >= -_UPRIGHT * down[convex, 1]
        for row in np.setdiff1d(np.arange(len(pairs)), convex).tolist():
            low, high = self.box(things[int(owner[row])][0])
            spread = float((high - low)[[0, 2]].prod())
            gained = self._overlap(pairs[row], down[row]) - self._overlap(pairs[row], np.zeros(3))
            found[row] = gained > -_SLIVER * spread * float(down[row, 1])
        return found

    def fall(
        self,
        a: Thing,
        others: Sequence[Thing],
        start: float = 0.0,
        sideways: FloatArray | Sequence[float] = (0.0, 0.0, 0.0),
    ) -> float | None:
        """Return how far ``a``, raised by ``start`` and moved ``sideways``, can move down until it meets one of
        ``others``; None if it meets none."""
        low, high = self.bodies.boxes
        best = np.inf
        moved = np.asarray(sideways, np.float64) + np.array([0.0, start, 0.0])
        tops = [float(high[each.first : each.last, 1].max(initial=-np.inf)) for each in others]
        for other in (others[number] for number in np.argsort(tops, kind="stable")[::-1]):  # the nearest first
            pairs = self._rows_below(a, other, moved)
            clear = low[pairs[:, 0], 1] + moved[1] - high[pairs[:, 1], 1]
            for row in np.argsort(clear, kind="stable").tolist():
                if clear[row] >= best:
                    break
                far = min(best, float(high[pairs[row, 0], 1] + moved[1] - low[pairs[row, 1], 1]))
                best = min(best, self._first_touch(pairs[row : row + 1], moved, max(float(clear[row]), 0.0), far))
        return float(best) if np.isfinite(best) else None

    def _rows_below(self, a: Thing, b: Thing, moved: FloatArray) -> IntArray:
        """Return the pairs (M, 2) of bodies of two things of which the second is below the first, moved."""
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
            shift = moved - np.array([0.0, fall, 0.0])
            return bool(self._gaps(pair, shift, 0.0)[0] <= 0.0) if convex else self._overlap(pair[0], shift) > 0.0

        tries = np.linspace(near, far, _TRIES).tolist()
        touching = next((k for k, fall in enumerate(tries) if meets(fall)), None)
        if not touching:
            return np.inf if touching is None else near
        low, high = tries[touching - 1], tries[touching]
        for _ in range(_HALVINGS):
            middle = (low + high) / 2.0
            low, high = (low, middle) if meets(middle) else (middle, high)
        return float(high)

    def hull(self, thing: Thing, other: Thing | None = None) -> Manifold:
        """Return the convex hull of a thing, without the bodies of ``other``."""
        import manifold3d

        rows = self._rows(thing, other) if other is not None else np.arange(thing.first, thing.last)
        points = [self._vertices(int(row)) for row in rows]
        return manifold3d.Manifold.hull_points(np.concatenate(points)) if points else manifold3d.Manifold()

    def groups(self, reach: float) -> IntArray:
        """Return a number (N,) for each body that is equal for those connected by bodies within ``reach``."""
        near, complete = neighbours(*self.bodies.boxes, reach, MAX_PAIRS)
        if not complete:
            raise SceneError("primitives", f"`supported` compares at most {MAX_PAIRS:,} pairs of primitives")
        close = near[self._gaps(near, np.zeros(3), 2.0 * reach + 1e-12) <= reach] if len(near) else near
        return clusters(len(self.bodies), close.tolist())


def _is_convex(entity: Entity) -> bool:
    """Return whether a primitive is its canonical form, and that is convex; semantic primitives are boxes."""
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
    return int(pair[0]), int(pair[1])


def _three(vector: FloatArray) -> Vector:
    return float(vector[0]), float(vector[1]), float(vector[2])


def share_of(inner: Manifold, outer: Manifold) -> float | None:
    """Return the share of the volume of a solid that is inside another; None if either has none."""
    volume = inner.volume()
    if inner.is_empty() or outer.is_empty() or volume <= 0.0:
        return None
    return float((inner ^ outer).volume() / volume)


# --- all relations of a frame ----------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Related:
    """A relation that holds between two things of a frame.

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


def related(here: Arrangement, rows: Sequence[int], limit: int = _MAX_RELATED) -> list[Related]:
    """Return the relations of things that touch or overlap, among instances with the same nearest instance above them.

    Raises LimitError for more than ``limit`` pairs of nearby things.
    """
    above = _parents(here, rows)
    things = [here.thing(row) for row in rows]
    boxes = [here.box(thing) for thing in things]
    low, high = np.array([box[0] for box in boxes]).reshape(-1, 3), np.array([box[1] for box in boxes]).reshape(-1, 3)
    reach = max((here.touch(thing) for thing in things), default=0.0)
    pairs, complete = neighbours(low, high, reach, limit)
    if not complete:
        raise LimitError("primitives", f"more than {limit:,} pairs of things are near each other")
    found: list[Related] = []
    same = [(things[i], things[j]) for i, j in pairs.tolist() if above[i] == above[j]]
    both = [*same, *((b, a) for a, b in same)]
    here.compare(both, [min(here.touch(a), here.touch(b)) for a, b in both])
    for a, b in same:
        if a.last > a.first and b.last > b.first:
            found += _relations_between(here, a, b)
    return found


def _parents(here: Arrangement, rows: Sequence[int]) -> list[int]:
    """Return for each instance the nearest one above it that is among ``rows``, -1 for none."""
    known = set(rows)
    found = []
    for row in rows:
        above = int(here.ancestry.parent[row])
        while above >= 0 and above not in known:
            above = int(here.ancestry.parent[above])
        found.append(above)
    return found


def _relations_between(here: Arrangement, a: Thing, b: Thing) -> Iterator[Related]:
    reach = min(here.touch(a), here.touch(b))
    found = here.separation(a, b)
    if found is None or found.distance > reach:
        return
    pair = (a.instance, b.instance)
    for inner, outer in ((a, b), (b, a)):
        (low, high), (under, over) = here.box(inner), here.box(outer)
        if bool((low >= under - reach).all() and (high <= over + reach).all()):
            share = share_of(here.hull(inner), here.hull(outer))
            if share is not None and share >= _ENCLOSED:
                yield Related("inside", inner.instance, outer.instance, found.distance)
    carried = False
    for upper, lower in ((a, b), (b, a)):
        (low, high), (under, _) = here.box(upper), here.box(lower)
        sunk = max(reach, SUNK * float(high[1] - low[1]))
        if -sunk <= found.distance and low[1] > under[1] - reach and here.is_blocked(upper, lower, reach):
            carried = True
            yield Related("on", upper.instance, lower.instance, found.distance)
    if not carried:
        yield Related("overlapping" if found.distance < -reach else "touching", *pair, found.distance)


def paired(center: FloatArray, mirrored: FloatArray, size: FloatArray, words: IntArray, within: float) -> IntArray:
    """Return the boxes that have one of their word and size within a distance of their mirror image."""
    count = len(center)
    places = np.concatenate([center, mirrored])
    near, _ = neighbours(places, places, within, MAX_PAIRS)
    first, second = near[(near[:, 0] < count) & (near[:, 1] >= count)].T
    second = second - count
    same = (words[first] == words[second]) & (np.abs(size[first] - size[second]).max(axis=1, initial=0.0) <= within)
    same &= np.abs(center[first] - mirrored[second]).max(axis=1, initial=0.0) <= within
    return np.unique(second[same])


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
    scene: Scene, words: Collection[str] | None = None, frame: int = 0, limit: int = _MAX_RELATED
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
