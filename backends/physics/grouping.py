"""Which parts of a frame are rigid bodies: the things that a person would lift (docs/physics.md).

1. A child of the root is a thing, or several. Primitives that stand directly in the root are taken together while they
   touch.
2. An entity whose parts all touch is one body: a chair of legs, a seat and a back.
3. If at least half of its parts touch, it is a thing with strays, and each connected cluster is a body.
4. Otherwise it is an arrangement, such as "chess pieces", and what holds for the root holds for it.
5. Parts of different bodies that overlap deeper than ``WELD`` of the smaller one's least side are glued: their bodies
   are one, unless one thing is set into another from above. What is set into the ground by more than a tenth of its
   least extent stands fast; of what is less deep, the part in the ground is cut off.

The attributes ``:body``, ``:fixed``, ``:mass``, ``:density`` and ``:friction`` of entities override what is found.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.geometry.stability import (
    ChainLink,
    are_one_thing,
    is_airborne,
    is_mounted,
    is_part_of_thing,
    is_portable,
    is_put_down,
    is_rooted,
    may_be_set_in,
)
from scenelang.backends.physics.colliders import (
    Collider,
    FloatArray,
    colliders_of,
    reach_of,
    trimmed,
    volume_of_collider,
)
from scenelang.backends.physics.dynamics import Distances, Overlap
from scenelang.backends.physics.masses import Moments, entity_moments, primitive_moments, total, united_moments
from scenelang.backends.surfaces.appearance import look_of
from scenelang.backends.surfaces.convex import beyond_edge, clusters
from scenelang.backends.surfaces.distance import neighbours
from scenelang.grammar.datum import Span
from scenelang.grammar.diagnostics import LimitError, Note, SceneError
from scenelang.interpreter.scene.entity import Entity, descendants
from scenelang.interpreter.scene.pose import compose
from scenelang.interpreter.scene.primitives.base import PHYSICS
from scenelang.interpreter.values.values import IDENTITY, Matrix

IntArray = npt.NDArray[np.int64]

MAX_PARTS = 20_000  # primitives
MAX_COLLIDERS = 40_000
MAX_PAIRS = 400_000  # of colliders that are near each other
MAX_BODIES = 4_000
MAX_UNITED = 400  # parts of a body that are joined to be measured; in larger ones overlaps count in each part
TOUCH = 2e-3  # of the smaller part's diagonal: parts that are closer touch
DIAGONAL = 2.0  # metres: what a scene is taken to measure unless a unit is given
WELD = 1e-2  # of the smaller part's least side: parts that overlap deeper are one body, unless they are two things
LOOSE = 1e-3  # the same: a simulation need not know of less
ROOTED = 0.1  # of its least extent: what is deeper in the ground stands fast
SUNK = 0.25  # of the upper thing's height: as deep may it be set into what it stands on
UPRIGHT = 0.8  # of the direction in which one leaves the other
_LARGEST = 1e12  # coordinates beyond it lose the digits that a simulation needs
_READERS = {attribute.name: attribute for attribute in PHYSICS}


@dataclass(frozen=True, slots=True, eq=False)
class PlacedEntity:
    """An instance of an entity in the expanded frame.

    Attributes
    ----------
    entity, world
        The entity and its pose in the world.
    parent
        Number of the parent instance; -1 for the root.
    given
        The attributes of physics that it has, as they are read.
    """

    entity: Entity
    world: Matrix
    parent: int
    given: dict[str, Any]


@dataclass(frozen=True, slots=True, eq=False)
class BodyPart:
    """A primitive that takes part: the number of its node, and its colliders."""

    node: int
    colliders: tuple[Collider, ...]

    def box(self) -> tuple[FloatArray, FloatArray]:
        """Return the axis-aligned box in the world: low and high corner, (3,) each."""
        found = [collider.box() for collider in self.colliders]
        return np.min([low for low, _ in found], axis=0), np.max([high for _, high in found], axis=0)


@dataclass(frozen=True, slots=True, eq=False)
class RigidBody:
    """A rigid body, in the world of the scene: lengths in scene units, y up.

    Attributes
    ----------
    words
        The words from the root to the entity that it is, or to the one that contains its parts.
    node
        Number of that entity's node.
    parts
        Numbers of its parts.
    fixed
        Whether it cannot move.
    moments
        Mass in kg, centre of mass in scene units, second moments in kg and squared scene units.
    low, high : (3,)
        Corners of its axis-aligned box.
    """

    words: tuple[str, ...]
    node: int
    parts: tuple[int, ...]
    fixed: bool
    moments: Moments
    low: FloatArray
    high: FloatArray

    @property
    def name(self) -> str:
        """The last words of the path, as messages show them."""
        return "/".join(self.words[-2:])

    @property
    def size(self) -> float:
        """Longest side of the box, in scene units."""
        return float((self.high - self.low).max())


@dataclass(frozen=True, eq=False)
class BodySet:
    """The bodies of one frame.

    Attributes
    ----------
    nodes, parts, bodies
        The instances of entities in pre-order, the primitives that take part, and the bodies.
    ground
        Height of the ground plane.
    unit
        Metres per scene unit.
    frictions
        Coefficient of friction of each part, None where none is given.
    """

    nodes: tuple[PlacedEntity, ...]
    parts: tuple[BodyPart, ...]
    bodies: tuple[RigidBody, ...]
    ground: float
    unit: float
    frictions: tuple[float | None, ...]

    @cached_property
    def size(self) -> float:
        """Diagonal of the box of all bodies, in scene units."""
        low = np.min([body.low for body in self.bodies], axis=0)
        high = np.max([body.high for body in self.bodies], axis=0)
        return float(np.linalg.norm(high - low))

    @cached_property
    def inside(self) -> tuple[frozenset[int], ...]:
        """For each node the numbers of the bodies that have parts at or below it."""
        found: list[set[int]] = [set() for _ in self.nodes]
        for number, body in enumerate(self.bodies):
            for part in body.parts:
                found[self.parts[part].node].add(number)
        for node in range(len(self.nodes) - 1, 0, -1):
            found[self.nodes[node].parent] |= found[node]
        return tuple(map(frozenset, found))

    def place(self, body: RigidBody) -> Span | None:
        """Return where the program makes a body: the call of its first primitive that has a place."""
        for part in body.parts:
            places = self.nodes[self.parts[part].node].entity.call_sites
            if places:
                return places[0]
        return None


def bodies_of(root: Entity, unit: float | None = None) -> BodySet:
    """Return the bodies of a frame.

    Parameters
    ----------
    root
        Root of the frame.
    unit
        Metres per scene unit; by default such that the diagonal of the scene is ``DIAGONAL`` metres.

    Raises
    ------
    SceneError
        "value" for a unit out of range, "unsupported" for Minecraft blocks, "attribute" for physics attributes that
        cannot be read, "empty-scene" if nothing can be a body.
    LimitError
        "primitives" or "size" for more parts, colliders, contacts or bodies than the limits.
    """
    if unit is not None and not 1e-9 <= unit <= 1e9:
        raise SceneError("value", f"`metres_per_unit`: expected a number from 1e-9 to 1e9, got {unit!r}")
    _refuse_blocks(root)
    nodes = tuple(_expanded(root))
    parts = tuple(_parts(nodes))
    if not parts:
        message = f'"{root.word}" has nothing that can be a rigid body: things with a volume that can be seen'
        raise SceneError("empty-scene", message, "semantic primitives take part with `:body #t`")
    if sum(len(part.colliders) for part in parts) > MAX_COLLIDERS:
        raise LimitError("size", f"the scene has more than the limit of {MAX_COLLIDERS:,} convex pieces to simulate")
    return _Grouping(nodes, parts, unit).grouped()


def _refuse_blocks(root: Entity) -> None:
    block = next((entity for entity in descendants(root) if entity.is_block), None)
    if block is not None:
        notes = tuple(Note(f'"{block.word}" is made here', span) for span in block.call_sites[:1])
        message = "Minecraft blocks are no rigid bodies: they stay where they are put"
        raise SceneError("unsupported", message, "use primitives such as cubes", notes=notes)


def _expanded(root: Entity) -> Iterator[PlacedEntity]:
    """Yield the instances of a frame in pre-order; raises LimitError for more than ``MAX_PARTS`` primitives."""
    stack: list[tuple[Entity, Matrix, int]] = [(root, IDENTITY, -1)]
    number, primitives = 0, 0
    while stack:
        entity, world, parent = stack.pop()
        primitives += entity.is_primitive
        if primitives > MAX_PARTS or number > 10 * MAX_PARTS:
            raise LimitError(
                "primitives", f"more than the limit of {MAX_PARTS:,} primitives to simulate",
                hint="simulate a part of the scene with `--root WORD`",
            )  # fmt: skip
        yield PlacedEntity(entity, world, parent, _given(entity))
        stack.extend((part.car, compose(world, part.cdr), number) for part in reversed(entity.children))
        number += 1


def _given(entity: Entity) -> dict[str, Any]:
    """Return the attributes of physics of an entity; raises SceneError("attribute")."""
    attributes = entity.embedding.attributes
    found: dict[str, Any] = {}
    for name, attribute in _READERS.items():
        value = attributes.get(name)
        if value is None or attribute.read is None:
            continue
        try:
            found[name] = attribute.read(entity.word, name, value)
        except SceneError as error:
            if entity.call_sites and error.span is None:
                error.span = entity.call_sites[0]
            raise
    return found


def _parts(nodes: Sequence[PlacedEntity]) -> Iterator[BodyPart]:
    whole = [False] * len(nodes)  # whether an entity at or above the node is a body by its attributes
    for number, node in enumerate(nodes):
        whole[number] = _is_whole(node.given) or (node.parent >= 0 and whole[node.parent])
        shape = node.entity.shape
        if shape is None or not shape.has_geometry or (shape.is_semantic and not whole[number]):
            continue
        if (shape.is_solid and shape.is_flat) or look_of(node.entity).opacity == 0.0:
            continue
        world = np.array(node.world, np.float64).reshape(3, 4)
        if not np.abs(world).max() < _LARGEST:
            raise SceneError("pose", f'"{node.entity.word}" is too large or too far away to be simulated')
        found = colliders_of(shape, world)
        if found:
            yield BodyPart(number, found)


# --- grouping ---------------------------------------------------------------------------------------------------------


class _Grouping:
    """Groups the parts of a frame to bodies."""

    def __init__(self, nodes: tuple[PlacedEntity, ...], parts: tuple[BodyPart, ...], unit: float | None) -> None:
        self.nodes, self.parts = nodes, parts
        boxes = [part.box() for part in parts]
        self.low, self.high = np.array([low for low, _ in boxes]), np.array([high for _, high in boxes])
        if not (np.isfinite(self.low).all() and np.isfinite(self.high).all()):
            raise SceneError("pose", "pose overflow: coordinates exceed the float range")
        self.diagonal = np.linalg.norm(self.high - self.low, axis=1)
        size = float(np.linalg.norm(self.high.max(axis=0) - self.low.min(axis=0)))
        self.unit = DIAGONAL / size if unit is None else unit
        self.children: list[list[int]] = [[] for _ in nodes]
        for number, node in enumerate(nodes):
            if node.parent >= 0:
                self.children[node.parent].append(number)
        self.below: list[list[int]] = [[] for _ in nodes]  # numbers of the parts at or below each node
        for number, part in enumerate(parts):
            for at in self._upwards(part.node):
                self.below[at].append(number)
        self.touching: list[list[int]] = [[] for _ in parts]
        self.deep: list[tuple[int, int]] = []  # pairs of parts that overlap: too deep to be ignored, and less
        self.shallow: list[tuple[int, int]] = []
        self._find_contacts()

    def _find_contacts(self) -> None:
        margin = TOUCH * float(self.diagonal.max())
        pairs, complete = neighbours(self.low, self.high, margin, MAX_PAIRS)
        if not complete:
            message = f"more than the limit of {MAX_PAIRS:,} pairs of nearby parts to simulate"
            raise LimitError("size", message, "simulate a part of the scene with `--root WORD`")
        smaller = np.minimum(self.diagonal[pairs[:, 0]], self.diagonal[pairs[:, 1]])
        least = np.minimum(*((self.high - self.low)[pairs[:, k]].min(axis=1) for k in (0, 1)))
        self.distances = Distances([part.colliders for part in self.parts])
        gaps = self.distances.gaps(pairs, margin)
        for (i, j), gap, size, side in zip(pairs.tolist(), gaps.tolist(), smaller.tolist(), least.tolist()):
            if gap <= TOUCH * size:
                self.touching[i].append(j)
                self.touching[j].append(i)
            if -gap > WELD * side:
                self.deep.append((i, j))
            elif -gap > LOOSE * side:
                self.shallow.append((i, j))

    def grouped(self) -> BodySet:
        """Return the bodies, in the order of their first parts."""
        groups = self._welded(self._things())
        self._part(groups)
        ground = self._ground(groups)
        if len(groups) > MAX_BODIES:
            raise LimitError("size", f"the scene has {len(groups):,} bodies, more than the limit of {MAX_BODIES:,}")
        self._level(groups, ground)
        bodies = tuple(self._body(group, ground) for group in groups)
        frictions = tuple(self._inherited(part, "friction") for part in range(len(self.parts)))
        return BodySet(self.nodes, self.parts, bodies, ground, self.unit, frictions)

    def _things(self) -> list[list[int]]:
        """Return the parts of each thing, before welds."""
        found: list[list[int]] = []
        stack = [0]
        while stack:
            at = stack.pop()
            below = self.below[at]
            if not below:
                continue
            given = self.nodes[at].given
            if _is_whole(given) or "mass" in given or self.nodes[at].entity.is_primitive:
                found.append(below)
                continue
            separate = at == 0 or given.get("body") is False or self._has_bodies(at) or self._is_arrangement(at)
            clusters = [] if separate else self._clusters(below)
            if clusters and 2 * len(clusters[0]) >= len(below):
                found += clusters
                continue
            by_noun = at != 0 and given.get("body") is not False
            held = [child for child in self.children[at] if self._is_loose(child, by_noun)]
            found += self._clusters([part for child in held for part in self.below[child]])
            stack.extend(child for child in reversed(self.children[at]) if child not in held)
        return found

    def _is_arrangement(self, at: int) -> bool:
        """Whether something is in an entity that a person lifts from it, by its noun, such as a cup on a table."""
        children = [child for child in self.children[at] if self.below[child]]
        return len(children) > 1 and any(is_portable(self.nodes[child].entity) for child in children)

    def _has_bodies(self, at: int) -> bool:
        """Whether an attribute makes something below a node a body of its own."""
        for part in self.below[at]:
            node = self.parts[part].node
            while node != at:
                given = self.nodes[node].given
                if _is_whole(given) or given.get("body") is False:
                    return True
                node = self.nodes[node].parent
        return False

    def _is_loose(self, node: int, by_noun: bool) -> bool:
        """Whether a node is material of what contains it, a primitive of a shape's name, or a part by its noun."""
        entity, given = self.nodes[node].entity, self.nodes[node].given
        if _is_whole(given) or given.get("body") is False or "mass" in given:
            return False
        is_shape = entity.shape is not None and entity.shape.is_solid
        return is_shape or (by_noun and is_part_of_thing(entity))

    def _clusters(self, members: Sequence[int]) -> list[list[int]]:
        """Return the connected clusters of parts, the largest first."""
        inside, seen = set(members), set()
        found: list[list[int]] = []
        for start in members:
            if start in seen:
                continue
            seen.add(start)
            cluster, stack = [], [start]
            while stack:
                part = stack.pop()
                cluster.append(part)
                fresh = [other for other in self.touching[part] if other in inside and other not in seen]
                seen.update(fresh)
                stack += fresh
            found.append(sorted(cluster))
        return sorted(found, key=lambda cluster: (-len(cluster), cluster[0]))

    def _welded(self, groups: Sequence[Sequence[int]]) -> list[list[int]]:
        """Return the groups, of which those with a weld between them are one."""
        owner = {part: number for number, group in enumerate(groups) for part in group}
        heights = [float(np.ptp(np.stack([self.low[group, 1].min(), self.high[group, 1].max()]))) for group in groups]
        joined = [
            (owner[i], owner[j])
            for i, j in self.deep
            if owner[i] != owner[j]
            and not (self._is_apart(i) or self._is_apart(j))
            and not self._rests(i, j, SUNK * heights[owner[i]], SUNK * heights[owner[j]])
        ]
        merged: dict[int, list[int]] = {}
        for name, group in zip(clusters(len(groups), joined).tolist(), groups, strict=True):
            merged.setdefault(name, []).extend(group)
        return sorted((sorted(group) for group in merged.values()), key=lambda group: group[0])

    def _rests(self, i: int, j: int, room: float, other_room: float) -> bool:
        """Whether one of two parts stands on the other, although it is set into it by up to ``room``, or ``other_room``
        if it is the second: they are parts of two things, and one leaves the other upwards."""
        upper = next((p for p, q in ((i, j), (j, i)) if self._floors[q]), None)
        put_down = upper is not None and is_put_down(self._words(self.parts[upper].node)[1:])
        if not put_down and are_one_thing(self._chain(i), self._chain(j)):
            return False
        found = self.distances.overlap(i, j)
        if found is None or abs(found.along[1]) < UPRIGHT:
            return False
        return found.depth <= (other_room if found.along[1] > 0.0 else room)

    def _paved(self, height: float) -> npt.NDArray[np.bool_]:
        """Which parts (N,) are broad and flat shapes on a floor, in which something of a height may be planted."""
        extent = self.high - self.low
        top = float(self.high[self._floors, 1].max(initial=-np.inf))
        shapes = np.array([self._is_loose(part.node, False) for part in self.parts], bool)
        broad = (2.0 * extent[:, 1] < extent[:, [0, 2]].min(axis=1)) & (extent[:, [0, 2]].max(axis=1) > height)
        return np.asarray(shapes & broad & (self.low[:, 1] <= top + TOUCH * self.diagonal.max()), bool)

    @cached_property
    def _floors(self) -> npt.NDArray[np.bool_]:
        """Which parts (N,) are flat, broad and at the bottom of the scene or at 0."""
        extent, bottom, top = self.high - self.low, self.low[:, 1].min(), self.high[:, 1].max()
        at_zero = np.abs(self.high[:, 1]) <= 1e-3 * (top - bottom)
        low = (self.low[:, 1] <= bottom + 0.1 * (top - bottom)) | at_zero
        return np.asarray(self.broad & low & (2.0 * extent[:, 1] < extent[:, [0, 2]].min(axis=1)), bool)

    def _chain(self, part: int) -> list[ChainLink]:
        return [ChainLink(at, self.nodes[at].entity) for at in self._upwards(self.parts[part].node)][::-1]

    def _part(self, groups: Sequence[Sequence[int]]) -> None:
        """Cut off what parts of one body have in another, so that nothing starts inside something.

        Of two colliders that overlap, the one is cut that loses less, along the plane in which it leaves the other.
        """
        owner = {part: number for number, group in enumerate(groups) for part in group}
        parts = list(self.parts)
        for i, j in [*self.shallow, *self.deep]:
            if owner[i] == owner[j]:
                continue
            for each in self.distances.overlaps(i, j):
                least = min(float(np.ptp(parts[k].box(), axis=0).min()) for k in (i, j))
                apart = self._is_apart(i) or self._is_apart(j)
                if LOOSE * least < each.depth and not (apart and each.depth > WELD * least):
                    _cut(parts, i, j, each)
        self.parts = tuple(parts)

    def _level(self, groups: Sequence[Sequence[int]], ground: float) -> None:
        """Cut off what bodies have in the ground that are set into it only a little, so that they stand on it."""
        parts, down = list(self.parts), np.array([0.0, -1.0, 0.0])
        for group in groups:
            if not self._is_sunk(group, ground) or self._stands_fast(group, ground):
                continue
            for part in group:
                cut = [trimmed(c, down, -ground) if reach_of(c, down) > -ground else c for c in parts[part].colliders]
                parts[part] = replace(parts[part], colliders=tuple(c for c in cut if c is not None))
        self.parts = tuple(parts)

    def _is_sunk(self, group: Sequence[int], ground: float) -> bool:
        """Whether a part of a body is in the ground."""
        return any(ground - self.low[p, 1] > WELD * (self.high[p] - self.low[p]).min() for p in group)

    def _stands_fast(self, group: Sequence[int], ground: float) -> bool:
        """Whether a body in the ground is held by it: it is deep there for its least extent, or as broad as a floor."""
        rows = list(group)
        low, high = self.low[rows].min(axis=0), self.high[rows].max(axis=0)
        deep = ground - low[1] > ROOTED * (high - low).min() and not self._leans(group, ground)
        return bool(deep or (self.broad[rows] & (self.low[rows, 1] < ground)).any())

    def _leans(self, group: Sequence[int], ground: float) -> bool:
        """Whether a body is beside the parts that it has in the ground, which are not deep enough to hold it: a table
        that is tilted, with two of its legs in the ground."""
        rows = np.array(group)
        low, high = self.low[rows], self.high[rows]
        dips = low[:, 1] < ground
        depth, height = ground - low[:, 1].min(), high[:, 1].max() - low[:, 1].min()
        if depth > SUNK * height or may_be_set_in(self._words(self._common(group))[1:]):
            return False
        shapes = [shape for part in group for shape in self.parts[part].colliders]
        weights = np.array([volume_of_collider(shape) for shape in shapes])
        center = np.average([shape.center for shape in shapes], axis=0, weights=np.maximum(weights, 1e-300))
        feet = np.concatenate([np.stack([x, z], axis=1) for x in (low[dips][:, 0], high[dips][:, 0])
                               for z in (low[dips][:, 2], high[dips][:, 2])])  # fmt: skip
        return beyond_edge(feet, center[[0, 2]])[0] > 0.0

    def _is_apart(self, part: int) -> bool:
        """Whether an attribute says what body a part belongs to, so that overlaps do not."""
        return any(_is_whole(self.nodes[at].given) for at in self._upwards(self.parts[part].node))

    def _ground(self, groups: Sequence[Sequence[int]]) -> float:
        """Return the height of the ground: 0 if something stands there and nothing is below, else the lowest point."""
        boxes = [[part.box() for k in group if (part := self.parts[k]).colliders] for group in groups]
        bottoms = np.array([min(low[1] for low, _ in found) for found in boxes if found])
        tops = np.array([max(high[1] for _, high in found) for found in boxes if found])
        near = TOUCH * np.array([self.diagonal[list(group)].max() for group, found in zip(groups, boxes) if found])
        if (np.abs(bottoms) <= near).any() and not ((bottoms < -near) & (tops <= near)).any():
            return min(0.0, float(bottoms[np.abs(bottoms) <= near].min()))
        return float(bottoms.min())

    def _body(self, group: Sequence[int], ground: float) -> RigidBody:
        at = self._common(group)
        low, high = self.low[list(group)].min(axis=0), self.high[list(group)].max(axis=0)
        stands_fast = self._is_sunk(group, ground) and self._stands_fast(group, ground)
        fixed = stands_fast or any(self._inherited(part, "fixed") for part in group) or self._hangs(at, group, ground)
        moments = self._moments(at, group)
        if not (np.isfinite(moments.mass) and moments.mass > 0.0):
            raise SceneError("solid", f'the volume of "{self.nodes[at].entity.word}" cannot be computed')
        return RigidBody(self._words(at), at, tuple(group), fixed, moments, low, high)

    def _hangs(self, at: int, group: Sequence[int], ground: float) -> bool:
        """Whether a body is held by what its word says: it hangs, flies or is fastened to what it touches, and nothing
        is below it; or it is rooted in the ground. Attributes decide otherwise."""
        given, words = self.nodes[at].given, self._words(at)[1:]
        if "fixed" in given or "body" in given or not (is_mounted(words) or is_rooted(words)):
            return False
        rows = list(group)
        low, high = self.low[rows].min(axis=0), self.high[rows].max(axis=0)
        room = TOUCH * self.diagonal[rows].max()
        beside = (self.low <= high + room).all(axis=1) & (self.high >= low - room).all(axis=1)
        beside[rows] = False
        if is_rooted(words) and (
            low[1] <= ground + room or (beside & (self.broad | self._paved(float(high[1] - low[1])))).any()
        ):
            return True
        touched = {other for part in rows for other in self.touching[part]} - set(rows)
        below = [other for other in touched if self.high[other, 1] <= low[1] + max(room, SUNK * (high - low)[1])]
        if low[1] <= ground + room or below:
            return False
        return bool(touched) or is_airborne(words)

    @cached_property
    def broad(self) -> npt.NDArray[np.bool_]:
        """Which parts (N,) are as broad as a floor."""
        area = (self.high - self.low)[:, [0, 2]].prod(axis=1)
        whole = (self.high.max(axis=0) - self.low.min(axis=0))[[0, 2]].prod()
        return np.asarray(area >= 0.3 * whole, bool)

    def _common(self, group: Sequence[int]) -> int:
        """Return the lowest node that contains a group; of welded things the one with the largest part."""
        largest = max(group, key=lambda part: (self.diagonal[part], -part))
        at = self.parts[largest].node
        inside = set(group)
        while self.nodes[at].parent > 0 and inside.issuperset(self.below[self.nodes[at].parent]):
            at = self.nodes[at].parent
        while at > 0 and not inside.issubset(self.below[at]):
            if not self.nodes[at].entity.is_primitive:
                break
            at = self.nodes[at].parent
        return at

    def _words(self, at: int) -> tuple[str, ...]:
        return tuple(self.nodes[each].entity.word for each in self._upwards(at))[::-1]

    def _upwards(self, at: int) -> Iterator[int]:
        """Yield a node and those above it, up to the root."""
        while at >= 0:
            yield at
            at = self.nodes[at].parent

    # --- attributes ---

    def _inherited(self, part: int, name: str) -> Any:
        """Return an attribute of the innermost entity around a part that has it."""
        found = (self.nodes[at].given for at in self._upwards(self.parts[part].node))
        return next((given[name] for given in found if name in given), None)

    def _moments(self, at: int, group: Sequence[int]) -> Moments:
        """Return the moments of a body."""
        densities = [(self._inherited(part, "density") or 1000.0) * self.unit**3 for part in group]
        weights = self._weights(group)
        whole = [mass for mass, members in weights if len(members) == len(group)]
        inner = [each for each in weights if len(each[1]) < len(group)]
        if len(set(densities)) == 1 and not inner and len(group) <= MAX_UNITED:
            found = self._united(at, group).times(densities[0])
            return found.times(whole[-1] / found.mass) if whole and found.mass > 0.0 else found
        parts = {part: self._of_part(part).times(density) for part, density in zip(group, densities)}
        for mass, members in weights:  # inner ones first, so that an outer mass is distributed last
            own = sum(parts[part].mass for part in members)
            parts |= {part: parts[part].times(mass / own) for part in members if own > 0.0}
        return total([parts[part] for part in group])

    def _weights(self, group: Sequence[int]) -> list[tuple[float, list[int]]]:
        """Return the masses that entities give, with their parts in the group, inner ones first."""
        inside = set(group)
        nodes: dict[int, None] = {}
        for part in group:
            at = self.parts[part].node
            while at >= 0:
                if "mass" in self.nodes[at].given and inside.issuperset(self.below[at]):
                    nodes[at] = None
                at = self.nodes[at].parent
        return [(self.nodes[at].given["mass"], self.below[at]) for at in sorted(nodes, reverse=True)]

    def _of_part(self, part: int) -> Moments:
        node = self.nodes[self.parts[part].node]
        return primitive_moments(node.entity).under(np.array(node.world).reshape(3, 4))

    def _united(self, at: int, group: Sequence[int]) -> Moments:
        if len(group) == 1:
            return self._of_part(group[0])
        node = self.nodes[at]
        if len(self.below[at]) == len(group) == _countable(node.entity):
            return _shared_moments(node.entity, self._known).under(np.array(node.world).reshape(3, 4))
        placed = [self.nodes[self.parts[part].node] for part in group]
        return united_moments([(each.entity, each.world) for each in placed])

    @cached_property
    def _known(self) -> dict[int, Moments]:
        return {}


def _cut(parts: list[BodyPart], i: int, j: int, overlap: Overlap) -> None:
    """Cut one of two overlapping colliders of two parts, so that they touch."""
    first, second = parts[i].colliders[overlap.first], parts[j].colliders[overlap.second]
    cuts = [
        (i, overlap.first, first, trimmed(first, overlap.along, -reach_of(second, -overlap.along))),
        (j, overlap.second, second, trimmed(second, -overlap.along, -reach_of(first, overlap.along))),
    ]
    lost = [
        (volume_of_collider(old) - volume_of_collider(new), row)
        for row, (_, _, old, new) in enumerate(cuts)
        if new is not None
    ]
    if lost:
        part, number, _, new = cuts[min(lost)[1]]
        shapes = list(parts[part].colliders)
        assert new is not None
        shapes[number] = new
        parts[part] = replace(parts[part], colliders=tuple(shapes))


def _is_whole(given: dict[str, Any]) -> bool:
    """Whether attributes make an entity a body of its own."""
    return bool(given.get("fixed") or given.get("body"))


def _countable(entity: Entity) -> int:
    """Return how many primitives ``measures_of`` measures in an entity."""
    count, stack = 0, [entity]
    while stack:
        each = stack.pop()
        shape = each.shape
        count += shape is not None and shape.has_geometry and not shape.is_flat
        stack.extend(part.car for part in each.children)
    return count


def _shared_moments(entity: Entity, known: dict[int, Moments]) -> Moments:
    """Return the moments of an entity in its own frame, computed once for all its instances."""
    if id(entity) not in known:
        known[id(entity)] = entity_moments(entity)
    return known[id(entity)]
