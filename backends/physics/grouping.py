"""Rigid bodies of a frame for simulations: the bodies of its facts, with colliders, masses and attributes.

``backends/facts`` decides what one body is, what is fastened to what, what stands fast, and where the ground is, so
that simulations and checks agree. Here, fastened bodies become one, and so do bodies that overlap deeper than ``WELD``
of the smaller one's least side, unless one rests on the other: deeper overlaps would make them fly apart. Bodies whose
place may be meant (notes of the facts, words that fly) are held. A part of a body that is slightly in the ground is cut
off.

A weld hides an object that passes through another; `check --geometry` reports that (W611), because a simulation cannot
tell a candle in a cake from a chair in a wall.

The attributes ``:body``, ``:fixed``, ``:floating``, ``:mass``, ``:density`` and ``:friction`` override the grouping.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.facts.bodies import is_whole, physics_of
from scenelang.backends.facts.frame import FrameFacts
from scenelang.backends.facts.words import flies
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
from scenelang.backends.surfaces.convex import clusters
from scenelang.backends.surfaces.distance import neighbors
from scenelang.grammar.datum import Span
from scenelang.grammar.diagnostics import LimitError, Note, SceneError
from scenelang.interpreter.scene.entity import Entity, descendants
from scenelang.interpreter.scene.pose import compose
from scenelang.interpreter.values.values import IDENTITY, Matrix

IntArray = npt.NDArray[np.int64]

MAX_PARTS = 20_000  # primitives of a frame
MAX_COLLIDERS = 40_000  # of a frame
MAX_PAIRS = 400_000  # of colliders that are near each other
MAX_BODIES = 4_000  # of a frame
MAX_UNITED_PARTS = 400  # parts of a body that are united to be measured; in larger bodies overlaps count in each part
TOUCH = 2e-3  # of the smaller part's diagonal: parts with smaller gaps touch
# of a scene without a given unit, so that verdicts do not depend on its unit; exports use 1 m per unit, as USD does
DIAGONAL_M = 2.0
# of the smaller part's least side: shallower overlaps are modeling tolerances that the solver pushes out unnoticed;
# deeper ones would make the parts fly apart and are welded
WELD = 1e-2
LOOSE = 1e-3  # of the smaller part's least side: shallower overlaps are left to the solver
# of the upper object's height: how deep it may be set into its support without a weld, so that a present that sinks 2
# mm into a table can fall from it
SUNK = 0.25
# vertical component of the direction in which an overlap is undone, from which one part is above the other
UPRIGHT = 0.8
_DEFAULT_DENSITY = 1000.0  # kg/m³, that of water; of primitives without `:density`
_MAX_COORDINATE = 1e12  # larger coordinates lose the digits that a simulation needs


@dataclass(frozen=True, slots=True, eq=False)
class PlacedEntity:
    """Instance of an entity in the expanded frame.

    Attributes
    ----------
    entity, world
        The entity and its pose in the world.
    parent
        Number of the parent instance; -1 for the root.
    physics
        Its physics attributes, validated.
    """

    entity: Entity
    world: Matrix
    parent: int
    physics: dict[str, Any]


@dataclass(frozen=True, slots=True, eq=False)
class BodyPart:
    """Primitive that takes part in the simulation: the number of its node, and its colliders."""

    node: int
    colliders: tuple[Collider, ...]

    def box(self) -> tuple[FloatArray, FloatArray]:
        """Return the axis-aligned box in the world: low and high corner, (3,) each."""
        boxes = [collider.box() for collider in self.colliders]
        return np.min([low for low, _ in boxes], axis=0), np.max([high for _, high in boxes], axis=0)


@dataclass(frozen=True, slots=True, eq=False)
class RigidBody:
    """Rigid body, in the world of the scene: lengths in scene units, y up.

    Attributes
    ----------
    words
        Words from the root to the body's entity, or to the entity that contains its parts.
    node
        Number of that entity's node.
    parts
        Numbers of its parts.
    fixed
        Whether it cannot move.
    note
        Why its place may be meant though gravity moves it, as the facts of the frame say; empty if nothing says so.
    moments
        Mass in kg, center of mass in scene units, second moments in kg and squared scene units.
    low, high : (3,)
        Corners of its axis-aligned box.
    verdict
        How it cannot stay where it is, as the facts of the frame say: "tips", "slides", "falls" or "floating"; empty
        if it can, or its place may be meant.
    """

    words: tuple[str, ...]
    node: int
    parts: tuple[int, ...]
    fixed: bool
    moments: Moments
    low: FloatArray
    high: FloatArray
    note: str = ""
    verdict: str = ""

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
        Meters per scene unit.
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
        bodies_below: list[set[int]] = [set() for _ in self.nodes]
        for number, body in enumerate(self.bodies):
            for part in body.parts:
                bodies_below[self.parts[part].node].add(number)
        for node in range(len(self.nodes) - 1, 0, -1):
            bodies_below[self.nodes[node].parent] |= bodies_below[node]
        return tuple(map(frozenset, bodies_below))

    def place(self, body: RigidBody) -> Span | None:
        """Return the source location of a body: the call of its first primitive that has one."""
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
        Meters per scene unit; by default such that the diagonal of the scene is ``DIAGONAL_M`` meters.

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
    return _Grouping(FrameFacts(root), nodes, parts, unit).grouped()


def _refuse_blocks(root: Entity) -> None:
    """Raise SceneError for Minecraft blocks, which do not fall."""
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
        yield PlacedEntity(entity, world, parent, physics_of(entity))
        stack.extend((part.car, compose(world, part.cdr), number) for part in reversed(entity.children))
        number += 1


def _parts(nodes: Sequence[PlacedEntity]) -> Iterator[BodyPart]:
    """Yield the visible primitives with a volume; semantic primitives only within a declared body."""
    in_declared_body = [False] * len(nodes)  # of each node, by attributes at or above it
    for number, node in enumerate(nodes):
        in_declared_body[number] = is_whole(node.physics) or (node.parent >= 0 and in_declared_body[node.parent])
        shape = node.entity.shape
        if shape is None or not shape.has_geometry or (shape.is_semantic and not in_declared_body[number]):
            continue
        if (shape.is_solid and shape.is_flat) or look_of(node.entity).opacity == 0.0:
            continue
        world = np.array(node.world, np.float64).reshape(3, 4)
        if not np.abs(world).max() < _MAX_COORDINATE:
            raise SceneError("pose", f'"{node.entity.word}" is too large or too far away to be simulated')
        colliders = colliders_of(shape, world)
        if colliders:
            yield BodyPart(number, colliders)


# --- grouping ---------------------------------------------------------------------------------------------------------


class _Grouping:
    """Groups the parts of a frame into bodies."""

    def __init__(
        self, facts: FrameFacts, nodes: tuple[PlacedEntity, ...], parts: tuple[BodyPart, ...], unit: float | None
    ) -> None:
        """Index the nodes and parts, and measure the contacts between parts."""
        self.facts, self.nodes, self.parts = facts, nodes, parts
        self.body_of: list[int] = []  # number of each part's body in the facts; negative without one
        boxes = [part.box() for part in parts]
        self.low, self.high = np.array([low for low, _ in boxes]), np.array([high for _, high in boxes])
        if not (np.isfinite(self.low).all() and np.isfinite(self.high).all()):
            raise SceneError("pose", "pose overflow: coordinates exceed the float range")
        self.diagonal = np.linalg.norm(self.high - self.low, axis=1)
        size = float(np.linalg.norm(self.high.max(axis=0) - self.low.min(axis=0)))
        self.unit = DIAGONAL_M / size if unit is None else unit
        self.below: list[list[int]] = [[] for _ in nodes]  # numbers of the parts at or below each node
        for number, part in enumerate(parts):
            for at in self._upwards(part.node):
                self.below[at].append(number)
        self.deep: list[tuple[int, int]] = []  # pairs of parts that overlap by more than WELD, and by LOOSE to WELD
        self.shallow: list[tuple[int, int]] = []
        self._find_contacts()

    def _find_contacts(self) -> None:
        """Measure the gaps of nearby parts; raises LimitError for more than ``MAX_PAIRS``."""
        margin = TOUCH * float(self.diagonal.max())
        pairs, complete = neighbors(self.low, self.high, margin, MAX_PAIRS)
        if not complete:
            message = f"more than the limit of {MAX_PAIRS:,} pairs of nearby parts to simulate"
            raise LimitError("size", message, "simulate a part of the scene with `--root WORD`")
        least = np.minimum(*((self.high - self.low)[pairs[:, k]].min(axis=1) for k in (0, 1)))
        self.distances = Distances([part.colliders for part in self.parts])
        gaps = self.distances.gaps(pairs, margin)
        for (i, j), gap, side in zip(pairs.tolist(), gaps.tolist(), least.tolist()):
            if -gap > WELD * side:
                self.deep.append((i, j))
            elif -gap > LOOSE * side:
                self.shallow.append((i, j))

    def grouped(self) -> BodySet:
        """Return the bodies, in the order of their first parts."""
        groups = self._welded(self._objects())
        self._separate(groups)
        ground = self._ground(groups)
        if len(groups) > MAX_BODIES:
            raise LimitError("size", f"the scene has {len(groups):,} bodies, more than the limit of {MAX_BODIES:,}")
        self._level(groups, ground)
        bodies = tuple(self._body(group, ground) for group in groups)
        frictions = tuple(self._inherited(part, "friction") for part in range(len(self.parts)))
        return BodySet(self.nodes, self.parts, bodies, ground, self.unit, frictions)

    def _objects(self) -> list[list[int]]:
        """Return the parts of each object: a body of the facts, or several that are fastened to each other."""
        facts, groups = self.facts, dict[int, list[int]]()
        primitives = np.cumsum([node.entity.is_primitive for node in self.nodes]) - 1  # of each node's primitive
        solid_of = {int(row): solid for solid, row in enumerate(facts.solids.row.tolist())}
        for number, part in enumerate(self.parts):
            solid = solid_of.get(int(primitives[part.node]))
            body = -1 - number if solid is None else int(facts.bodies.body[solid])
            self.body_of.append(body)
            name = body if body < 0 or self._is_apart(number) else int(facts.fastened[body])
            groups.setdefault(name, []).append(number)
        return sorted(groups.values())

    def _welded(self, groups: Sequence[Sequence[int]]) -> list[list[int]]:
        """Return the groups, merging those with a weld between them."""
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
        """Return whether one of two parts stands on the other, set into it by at most ``room``.

        ``other_room`` is the limit if the second part is the upper one.
        """
        overlap = self.distances.overlap(i, j)
        if overlap is None or abs(overlap.along[1]) < UPRIGHT:
            return False
        return overlap.depth <= (other_room if overlap.along[1] > 0.0 else room)

    def _separate(self, groups: Sequence[Sequence[int]]) -> None:
        """Cut overlapping colliders of different bodies, so that no body starts inside another.

        Of two colliders, the one that loses less volume is cut, along the plane through which it leaves the other.
        Letting the solver push them out was tried: pushing out 2 mm within a time step throws a table over. MuJoCo 4.0
        ignores negative contact margins for pairs that meet in one point, and lifting objects would move whatever
        stands on them.
        """
        owner = {part: number for number, group in enumerate(groups) for part in group}
        held = [self._stands_fast(group) for group in groups]
        parts = list(self.parts)
        for i, j in [*self.shallow, *self.deep]:
            if owner[i] == owner[j] or (held[owner[i]] and held[owner[j]]):
                continue
            for overlap in self.distances.overlaps(i, j):
                least = min(float(np.ptp(parts[k].box(), axis=0).min()) for k in (i, j))
                apart = self._is_apart(i) or self._is_apart(j)
                if LOOSE * least < overlap.depth and not (apart and overlap.depth > WELD * least):
                    _cut(parts, i, j, overlap)
        self.parts = tuple(parts)

    def _level(self, groups: Sequence[Sequence[int]], ground: float) -> None:
        """Cut off the parts of bodies that are slightly below the ground, so that they stand on it."""
        parts, down = list(self.parts), np.array([0.0, -1.0, 0.0])
        for group in groups:
            if not self._is_sunk(group, ground) or self._stands_fast(group):
                continue
            for part in group:
                cut = [trimmed(c, down, -ground) if reach_of(c, down) > -ground else c for c in parts[part].colliders]
                parts[part] = replace(parts[part], colliders=tuple(c for c in cut if c is not None))
        self.parts = tuple(parts)

    def _is_sunk(self, group: Sequence[int], ground: float) -> bool:
        """Return whether a part of a body is below the ground."""
        return any(ground - self.low[p, 1] > WELD * (self.high[p] - self.low[p]).min() for p in group)

    def _stands_fast(self, group: Sequence[int]) -> bool:
        """Return whether the ground holds a body: it is planted there, or the facts hold it."""
        return any(self._is_held(self.body_of[part]) for part in group)

    def _is_held(self, body: int) -> bool:
        """Return whether a body of the facts stands fast, or is where it is on purpose."""
        facts = self.facts
        if body < 0:
            return False
        verdict = facts.verdicts[body]
        return bool(
            facts.fixed[body] or facts.bodies.floating[body] or body in facts.planted or verdict.note == "anchored"
            or (not verdict.holds and not facts.bodies.loose[body] and self._flies(body))
        )  # fmt: skip

    def _note(self, group: Sequence[int]) -> str:
        """Return the note of the facts on a body of this group, "immersed" or "narrow"; empty if nothing says so."""
        bodies = self._bodies_of(group)
        verdicts = [self.facts.verdicts[body] for body in bodies]
        note = next((verdict.note for verdict in verdicts if verdict.note), "")
        is_narrow = any(self.facts.narrow[body] and verdict.holds for body, verdict in zip(bodies, verdicts))
        if not note and self.facts.immersed[bodies].any():
            return "immersed"
        return note or ("narrow" if is_narrow else "")

    def _verdict(self, group: Sequence[int]) -> str:
        """Return the verdict of the facts on a body of this group that does not hold; empty if all hold."""
        verdicts = [self.facts.verdicts[body] for body in self._bodies_of(group)]
        return next((verdict.kind for verdict in verdicts if not verdict.holds and not verdict.note), "")

    def _bodies_of(self, group: Sequence[int]) -> list[int]:
        """Return the bodies of the facts of which parts are members, ascending."""
        return sorted({self.body_of[part] for part in group} - {-1})

    def _flies(self, body: int) -> bool:
        """Return whether a word of a body is that of something that flies."""
        return any(flies(word) for word in self.facts.words_of(body))

    def _is_apart(self, part: int) -> bool:
        """Return whether an attribute decides the body of a part, so that overlaps do not weld it."""
        return any(is_whole(self.nodes[at].physics) for at in self._upwards(self.parts[part].node))

    def _ground(self, groups: Sequence[Sequence[int]]) -> float:
        """Return the height of the ground plane: that of the facts, or the lowest point where a body is below it."""
        tops = [max(self.high[part, 1] for part in group) for group in groups]
        height = self.facts.ground.height
        below = bool(tops) and min(tops) <= height - TOUCH * float(self.diagonal.max())
        return float(self.low[:, 1].min()) if below else height

    def _body(self, group: Sequence[int], ground: float) -> RigidBody:
        """Return the body of a group of parts; raises SceneError if its volume cannot be computed."""
        node = self._common(group)
        low, high = self.low[list(group)].min(axis=0), self.high[list(group)].max(axis=0)
        fixed = self._stands_fast(group) or any(self._inherited(part, "fixed") for part in group)
        moments = self._moments(node, group)
        if not (np.isfinite(moments.mass) and moments.mass > 0.0):
            raise SceneError("solid", f'the volume of "{self.nodes[node].entity.word}" cannot be computed')
        return RigidBody(self._words(node), node, tuple(group), fixed, moments, low, high, self._note(group),
                         self._verdict(group))  # fmt: skip

    def _common(self, group: Sequence[int]) -> int:
        """Return the lowest node that contains a group; for welded objects, that of the largest part."""
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
        """Return the words from the root to a node."""
        return tuple(self.nodes[node].entity.word for node in self._upwards(at))[::-1]

    def _upwards(self, at: int) -> Iterator[int]:
        """Yield a node and its ancestors, up to the root."""
        while at >= 0:
            yield at
            at = self.nodes[at].parent

    # --- attributes ---

    def _inherited(self, part: int, name: str) -> Any:
        """Return a physics attribute of the innermost entity around a part that has it, None if none has it."""
        levels = (self.nodes[at].physics for at in self._upwards(self.parts[part].node))
        return next((physics[name] for physics in levels if name in physics), None)

    def _moments(self, at: int, group: Sequence[int]) -> Moments:
        """Return the moments of a body.

        A body of one density, without masses inside it, is measured as a union. Otherwise each part is measured and
        scaled to its density, and then to the masses that entities declare.
        """
        densities = [(self._inherited(part, "density") or _DEFAULT_DENSITY) * self.unit**3 for part in group]
        weights = self._weights(group)
        declared_masses = [mass for mass, members in weights if len(members) == len(group)]
        inner = [members for _, members in weights if len(members) < len(group)]
        if len(set(densities)) == 1 and not inner and len(group) <= MAX_UNITED_PARTS:
            united = self._united(at, group).times(densities[0])
            return united.times(declared_masses[-1] / united.mass) if declared_masses and united.mass > 0.0 else united
        parts = {part: self._of_part(part).times(density) for part, density in zip(group, densities)}
        for mass, members in weights:  # inner ones first, so that an outer mass is distributed last
            member_mass = sum(parts[part].mass for part in members)
            parts |= {part: parts[part].times(mass / member_mass) for part in members if member_mass > 0.0}
        return total([parts[part] for part in group])

    def _weights(self, group: Sequence[int]) -> list[tuple[float, list[int]]]:
        """Return the declared masses with their parts, for entities inside the group; inner entities first."""
        inside = set(group)
        nodes: dict[int, None] = {}
        for part in group:
            at = self.parts[part].node
            while at >= 0:
                if "mass" in self.nodes[at].physics and inside.issuperset(self.below[at]):
                    nodes[at] = None
                at = self.nodes[at].parent
        return [(self.nodes[at].physics["mass"], self.below[at]) for at in sorted(nodes, reverse=True)]

    def _of_part(self, part: int) -> Moments:
        """Return the moments of a part in the world, with density 1."""
        node = self.nodes[self.parts[part].node]
        return primitive_moments(node.entity).under(np.array(node.world).reshape(3, 4))

    def _united(self, at: int, group: Sequence[int]) -> Moments:
        """Return the moments of the union of a body's parts, with density 1."""
        if len(group) == 1:
            return self._of_part(group[0])
        node = self.nodes[at]
        if len(self.below[at]) == len(group) == _countable(node.entity):
            return _shared_moments(node.entity, self._known).under(np.array(node.world).reshape(3, 4))
        placed = [self.nodes[self.parts[part].node] for part in group]
        return united_moments([(instance.entity, instance.world) for instance in placed])

    @cached_property
    def _known(self) -> dict[int, Moments]:
        """Cache of the moments of entities by identity, for instances of one entity."""
        return {}


def _cut(parts: list[BodyPart], i: int, j: int, overlap: Overlap) -> None:
    """Cut one of two overlapping colliders of two parts, so that they touch; the one that loses less volume."""
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


def _countable(entity: Entity) -> int:
    """Return the number of primitives of an entity that ``measures_of`` measures."""
    count, stack = 0, [entity]
    while stack:
        current = stack.pop()
        shape = current.shape
        count += shape is not None and shape.has_geometry and not shape.is_flat
        stack.extend(part.car for part in current.children)
    return count


def _shared_moments(entity: Entity, known: dict[int, Moments]) -> Moments:
    """Return the moments of an entity in its own frame, computed once for all its instances."""
    if id(entity) not in known:
        known[id(entity)] = entity_moments(entity)
    return known[id(entity)]
