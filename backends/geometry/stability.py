"""Things that would fall over or pass through each other: rigid groups of solids, what they rest on, and their balance.

Solids are welded into rigid groups where people model one thing of several: where they overlap, touch at the side, or
belong to one thing. What is left are things that rest on each other. A group topples if its centre of mass is beside
the convex hull of the places where it rests.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from functools import cached_property, lru_cache
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from scenelang.backends.surfaces.convex import MAX_EXACT, Bodies, beyond_edge, clusters, hull_of, width_of
from scenelang.backends.surfaces.distance import IntArray
from scenelang.backends.surfaces.solids import FloatArray
from scenelang.grammar.datum import dataclass
from scenelang.interpreter.scene.entity import Entity
from scenelang.interpreter.scene.primitives import find
from scenelang.interpreter.scene.primitives.cube import BLOCK
from scenelang.interpreter.scene.primitives.forms import CanonicalForm, Ratios


def _words(text: str) -> frozenset[str]:
    return frozenset(text.split())


# Nouns of parts: what is named so belongs to the thing beside it.
PARTS = _words(
    """
    arm armrest back bracket backrest baluster balustrade bar base beam blade body border bottom branch brick bristle
    button cap ceiling center centre column core corner cover crown cushion dial disc disk door drawer ear edge
    end eye face fin finger foot footrest frame front gable grip hand handle handlebar handrail head headboard
    hinge hoof horn hub joint keel key knob layer leaf leg lid limb link lintel lip mast mattress middle mouth
    nacelle neck newel nose nozzle pane panel pedal peg petal pillar pin pipe plank plate pole post prop rail
    railing rim ring riser rod roof root rope rotor rung screen seat segment shade shaft sheet shell shoulder
    side skirt slab slat sleeve socket sole spike spine spoke spout square stalk stand stem step stick stopper
    strap stringer strip strut support surface switch tail tile tip tire tooth top torso trim trunk tube tyre
    wall wheel window wing wire
    """
)
# Nouns of what is made to float or to hang.
AIRBORNE = _words(
    """
    aeroplane airplane airship angel arrow asteroid atom balloon banner bat bee bird blimp blind bubble bulb butterfly
    chandelier cloud comet confetti curtain dragon dragonfly drone droplet dust eagle electron fairy feather fire
    firefly firework fish flake flame fly ghost glow gull halo hanging helicopter jet kite label lamp lantern
    letter light lightbulb logo meteor mist molecule moon mote nebula neutron orb orbit particle pendant petal plane
    planet proton rain raindrop ray rocket satellite seagull sign sky smoke snow snowflake spaceship spark
    sparkle sprite star steam sun text ufo wave
    """
)
# Nouns of what a person lifts from what it stands on.
_PORTABLE = _words(
    """
    apple backpack bag ball banana barrel basket beaker bell book bottle bowl box bread brush bucket burger cake
    camera can candle candlestick carafe cat chair chest clock coin computer crate cube cup dice die dish dog
    doll donut egg figurine flask fork fruit gift glass globe goblet guitar hammer hat helmet jar jug kettle
    keyboard knife lantern laptop lemon loaf magazine microwave monitor mouse mug notebook orange ornament pan
    parcel pawn peach pear pen pencil phone pitcher pizza plate pot potion present pumpkin radio robot sandwich
    saucer scroll shoe skull spoon statue statuette stool suitcase tablet tankard teacup teapot television tin
    toaster tool toy trophy tv urn vase watermelon
    """
)
# Nouns of what stands on a floor by nothing but its weight.
_FURNITURE = _words(
    """
    armchair bed bench bookcase bookshelf cabinet couch crib cupboard desk drawers dresser fridge nightstand oven piano
    refrigerator sideboard sofa stove table wardrobe workbench
    """
)
# Nouns of what is held by the ground that it stands in.
_ROOTED = _words(
    """
    cactus crane flagpole floodlight flower hydrant lamppost mast palm plant pole post ramp sapling sign
    signpost stair staircase step streetlamp streetlight tree
    """
)
# Nouns of what others are set into or hang from.
_HOLDERS = _words(
    """
    arm bar basket beam bin bowl box bracket branch bucket cable canopy ceiling chain cone container crane cup
    frame glass hanger holder hook jar line mug nail pan pillar pot quiver rail ring rod roof rope sack saucer
    shade stand string tray tree tub vase wire
    """
)
# Nouns of what gives way, flows or grows: to be inside it is no fault.
_SOFT = _words(
    """
    air beard blanket blossom bough boulder bubble bush canopy carpet cloth cloud cream crown curtain cushion
    dirt duvet flame flower foam fog foliage fur garland grass ground hair hay hedge hill island ivy jam lake
    land lava lawn leaf mattress meadow mist moss mountain mud ocean path pavement paving pebble petal pillow
    plant pond pool puddle puff quilt river road rock rug sand sauce scarf sea shrub sky smoke soil steam stream
    terrain towel tree tuft water wave weed wig wool
    """
)
# Nouns of buildings, which stand in one another.
_BUILDINGS = _words(
    """
    arch barn battlement bridge building buttress castle chapel chimney church city cottage drum dungeon gate
    gatehouse hall house hut keep parapet porch pyramid skyscraper temple terrace tower turret village
    """
)
# Nouns of what is fastened to a wall or a ceiling that it touches.
_MOUNTED = _words(
    """
    antenna banner bell board bookshelf bracket cabinet clock curtain dartboard ivy mirror monitor painting photo
    picture plaque poster projector rack radiator ring screen shelf shutter sink socket speaker switch tv vent
    """
)
# Nouns of parts of buildings, which are no parts of what stands beside them.
_STRUCTURE = _words(
    """
    board border ceiling column door fence floor frame panel pillar plate post railing roof shelf side slab
    square stair step tabletop tile top wall window
    """
)
_BROAD = 0.3  # of the scene's area: what is that broad and at its bottom is the ground
_TOP = 1e-3  # of the scene's height: how near to 0 the top of the ground is
_SUNK = 0.25  # of a thing's height: what is deeper in another thing is held by it
_WELD = 0.05  # of the smaller body's least side: things that are deeper in each other, aside, hold each other
_VERTICAL = 0.8  # of the normal of a contact between a thing and what it rests on
_MARGIN = 0.02  # of a group's breadth: how far its centre of mass may be beside its support
_ROOTED_MARGIN = 0.05  # the same on the ground
_ROOM = 0.1  # of a group's breadth: how far inside its support the centre of mass of what stands well is
_MAX_DEPTH = 0.25  # of the smaller extent: how deep equal things may be in each other
_MAX_SHARED = 0.12  # of the smaller thing's volume: how much of it may be inside another
_MAX_PART = 0.2  # of the smaller body's volume: how much of it may be inside a body of another thing
_CLOSE = 0.02  # of a body's longest side: what is that near to its lowest point is its foot
_NEARLY = 0.05  # of a group's breadth: a part that is this near to what another part rests on does not let it tip far
_MANY = 200  # bodies of a group that are compared so
_NARROW = 0.05  # of a body's breadth: a foot that is narrower is an edge
_SLIM = 4.0  # times as long as thick: pencils and flowers are set into things


class Fault(NamedTuple):
    """A body that would fall, or passes through another.

    Attributes
    ----------
    body, other
        The body, and the one that it rests on or passes through; None is the ground.
    amount
        How far its centre of mass is beside its support, or how deep it is in the other, in scene units; the breadth of
        what stands on an edge.
    move
        The translation that would fix it; None for what stands on an edge, and for what moving it does not help.
    shift
        How far the centre of mass must move over the support to be inside it, with room; None for what stands on an
        edge.
    """

    body: int
    other: int | None
    amount: float
    move: tuple[float, float, float] | None
    shift: tuple[float, float, float] | None = None


@dataclass(frozen=True, slots=True)
class ChainLink:
    """One instance on the way to a primitive: the number of the instance and its entity."""

    number: int
    entity: Entity


def noun_of(word: str) -> str:
    """Return the singular of the last noun of a word, such as "leg" for "front-legs"."""
    noun = word.lower().replace("_", "-").replace(" ", "-").rstrip("-0123456789").split("-")[-1]
    return noun[:-1] if noun.endswith("s") and not noun.endswith("ss") else noun


def is_airborne(words: Sequence[str]) -> bool:
    """Return whether any of the words names what is made to float or to hang."""
    return any(
        noun_of(part) in AIRBORNE for word in words for part in word.replace("_", "-").replace(" ", "-").split("-")
    )


def is_part_of_thing(entity: Entity) -> bool:
    """Return whether an entity is a part of the thing that contains it, by its word."""
    cls = find(entity.word)
    return (cls is not None and cls.is_solid) or noun_of(entity.word) in PARTS


def chains_of(root: Entity) -> list[tuple[ChainLink, ...]]:
    """Return for each primitive below ``root``, in depth-first order, the instances from the root to it."""
    found: list[tuple[ChainLink, ...]] = []
    number = 0
    stack: list[tuple[Entity, tuple[ChainLink, ...]]] = [(root, ())]
    while stack:
        entity, above = stack.pop()
        number += 1
        chain = (*above, ChainLink(number, entity))
        if entity.is_primitive:
            found.append(chain)
        stack.extend((part.car, chain) for part in reversed(entity.children))
    return found


def are_one_thing(a: Sequence[ChainLink], b: Sequence[ChainLink], arrangements: Collection[int] = ()) -> bool:
    """Return whether two primitives that touch belong to one thing.

    In what contains both, one of them is a part: a shape, or by its noun; but not of what a person would lift from it,
    such as a cup. In an arrangement, which contains a floor, the floor is a part, and only parts belong to each other.
    """
    level = 0
    while level + 1 < min(len(a), len(b)) and a[level + 1].number == b[level + 1].number:
        level += 1
    if level + 1 >= min(len(a), len(b)):
        return True
    links = a[level + 1], b[level + 1]
    if a[level].entity.word in (links[0].entity.word, links[1].entity.word):  # recursion
        return True
    parts = [is_part_of_thing(link.entity) or link.number in arrangements for link in links]
    if a[level].number in arrangements:
        floors = [link.number in arrangements or noun_of(link.entity.word) in _STRUCTURE for link in links]
        shapes = [_is_shape(link.entity) for link in links]
        return all(parts) or (any(parts) and not any(floors) and not any(shapes))
    for link, other in (links, links[::-1]):
        if is_portable(link.entity) and (_is_shape(other.entity) or noun_of(other.entity.word) in _STRUCTURE):
            return False
    return any(parts)


def is_mounted(words: Sequence[str]) -> bool:
    """Return whether any of the words names what hangs or flies, or the last one what is fastened to a wall."""
    named = [word for word in words if (cls := find(word)) is None or not cls.is_solid]
    return is_airborne(words) or _has_noun(named[-1:], _MOUNTED)


def is_rooted(words: Sequence[str]) -> bool:
    """Return whether any of the words names what is held by the ground that it stands in, such as a street lamp."""
    return _has_noun(words, _ROOTED) or _has_noun([_closed(word) for word in words], _ROOTED)


def _closed(word: str) -> str:
    """Return a word with its last two nouns as one: "street lamp" as "streetlamp"."""
    first, _, last = word.lower().replace("_", "-").replace(" ", "-").rpartition("-")
    return first.rpartition("-")[2] + last


def is_put_down(words: Sequence[str]) -> bool:
    """Return whether a word of a path names what a person puts on a floor, and none what may be set into it."""
    return _has_noun(words, _PORTABLE | _FURNITURE) and not may_be_set_in(words)


def may_be_set_in(words: Sequence[str]) -> bool:
    """Return whether any of the words names what may be set into the ground, or is a part of a building."""
    return _has_noun(words, _ROOTED | _SOFT | _STRUCTURE | _BUILDINGS | AIRBORNE)


def is_portable(entity: Entity) -> bool:
    """Return whether an entity is what a person lifts from what it stands on, by its noun."""
    return not _is_shape(entity) and noun_of(entity.word) in _PORTABLE


def _is_shape(entity: Entity) -> bool:
    cls = find(entity.word)
    return cls is not None and cls.is_solid


@dataclass(frozen=True, slots=True, eq=False)
class Contacts:
    """Touching pairs of bodies (M, 2): which are of two things, which of these rest on each other, and the depth (M,)
    and direction (M, 3) of each."""

    pairs: IntArray
    gaps: FloatArray
    apart: npt.NDArray[np.bool_]
    rests: npt.NDArray[np.bool_]
    depth: FloatArray
    along: FloatArray
    thing: IntArray  # (N,) of each body: the thing that it is part of
    group: IntArray  # (N,) of each body: the things that hold each other
    floor: npt.NDArray[np.bool_]  # (N,) whether a body is the ground
    loose: npt.NDArray[np.bool_]  # (N,) whether a body is a shape in an arrangement
    owner: IntArray  # (N,) of each body: the number of the instance that it is, or whose material it is


def contacts_of(bodies: Bodies, root: Entity) -> Contacts:
    """Return the contacts of the bodies of a frame, and the groups that they join.

    First the parts of each thing are joined, then the things that hold each other because one is set into the other.
    """
    every = chains_of(root)
    chains = [every[row] for row in bodies.row.tolist()]
    pairs, gaps, _ = bodies.contacts
    floor = _is_floor(bodies)
    arrangements = {link.number for i in np.flatnonzero(floor).tolist() for link in chains[i][:-1]}
    apart = np.array([not are_one_thing(chains[i], chains[j], arrangements) for i, j in pairs.tolist()], bool)
    depth, along = np.zeros(len(pairs)), np.zeros((len(pairs), 3))
    if apart.any():
        depth[apart], along[apart] = bodies.overlaps(pairs[apart])
    thing = clusters(len(bodies), pairs[~apart].tolist())
    low, high = boxes_of_things(bodies, thing)
    upright = np.abs(along[:, 1]) >= _VERTICAL
    shallow = np.minimum((high - low)[pairs[:, 0], 1], (high - low)[pairs[:, 1], 1]) * _SUNK
    on_floor = floor[pairs].any(axis=1)
    held_by_floor = on_floor & (depth > 4.0 * bodies.touch)
    for row in np.flatnonzero(held_by_floor & apart).tolist():
        upper = next((i for i in pairs[row].tolist() if not floor[i]), None)
        held_by_floor[row] = upper is None or not is_put_down(bodies.words(upper)[1:])
        if upper is not None:
            shallow[row] = _SUNK * (high - low)[upper, 1]
    rests = apart & upright & ~held_by_floor & (depth <= np.maximum(shallow, 4.0 * bodies.touch))
    thin = np.minimum(*(bodies.boxes[1] - bodies.boxes[0]).min(axis=1)[pairs.T]) if len(pairs) else np.zeros(0)
    held = apart & ~rests & (upright | (depth > np.maximum(_WELD * thin, bodies.touch)))
    group = clusters(len(bodies), pairs[~apart | held].tolist())
    owner = np.array([chain[-2 if len(chain) > 1 and _is_shape(chain[-1].entity) else -1].number for chain in chains])
    loose = np.array(
        [len(chain) > 1 and chain[-2].number in arrangements and _is_shape(chain[-1].entity) for chain in chains], bool
    )
    return Contacts(pairs, gaps, apart, rests, depth, along, thing, group, floor, loose, owner.astype(np.int64))


def boxes_of_things(bodies: Bodies, group: IntArray) -> tuple[FloatArray, FloatArray]:
    """Return for each body the box (N, 3) of all bodies of its group."""
    low, high = (each.copy() for each in bodies.boxes)
    np.minimum.at(low, group, bodies.boxes[0])
    np.maximum.at(high, group, bodies.boxes[1])
    return low[group], high[group]


def _is_floor(bodies: Bodies) -> npt.NDArray[np.bool_]:
    """Return which bodies (N,) are the ground: broad ones at the bottom of the scene or
    whose tops are at 0."""
    low, high = bodies.boxes
    if not len(low):
        return np.zeros(0, bool)
    wide = (high.max(axis=0) - low.min(axis=0))[[0, 2]].prod()
    tall = float(high[:, 1].max() - low[:, 1].min())
    found: npt.NDArray[np.bool_] = (high - low)[:, [0, 2]].prod(axis=1) >= _BROAD * wide
    at_zero = np.abs(high[:, 1]) <= _TOP * tall
    found &= at_zero | (low[:, 1] <= low[:, 1].min() + 0.1 * tall)
    return found


# --- balance ---------------------------------------------------------------------------------------------------------


class _Balance:
    """The groups of a frame, what each rests on, and their centres of mass."""

    def __init__(self, bodies: Bodies, contacts: Contacts, ground: float) -> None:
        self.bodies, self.contacts, self.ground = bodies, contacts, ground
        low, high = bodies.boxes
        names, self.group = np.unique(contacts.group, return_inverse=True)
        count = len(names)
        order = np.argsort(self.group, kind="stable")
        self.members = np.split(order, np.cumsum(np.bincount(self.group, minlength=count))[:-1])
        volume, center = bodies.masses
        self.mass = np.bincount(self.group, volume, count)
        moment = np.stack([np.bincount(self.group, volume * center[:, k], count) for k in range(3)], axis=1)
        self.center = moment / self.mass[:, None]
        self.low, self.high = np.full((count, 3), np.inf), np.full((count, 3), -np.inf)
        np.minimum.at(self.low, self.group, low)
        np.maximum.at(self.high, self.group, high)
        self.below: list[list[tuple[int, int, float]]] = [[] for _ in range(count)]  # bodies above and below, and gap
        self.above: list[list[tuple[int, int]]] = [[] for _ in range(count)]
        middle = low[:, 1] + high[:, 1]
        resting = contacts.pairs[contacts.rests]
        for (i, j), gap in zip(resting.tolist(), contacts.gaps[contacts.rests].tolist()):
            upper, lower = (i, j) if middle[i] >= middle[j] else (j, i)
            if self.group[upper] != self.group[lower]:
                self.below[self.group[upper]].append((upper, lower, gap))
                self.above[self.group[lower]].append((upper, lower))
        self.grounded = low[:, 1] <= ground + 2.0 * bodies.touch
        self.feet = np.bincount(self.group, self.grounded, count)

    def supports(self, group: int) -> FloatArray:
        """Return points (K, 3) whose convex hull supports a group."""
        points: list[FloatArray] = []
        for i in self.members[group].tolist() if self.feet[group] else ():
            if self.grounded[i]:
                points.append(_lowest(self.bodies, i))
        for upper, lower, gap in self.below[group]:
            points.append(self._contact(upper, lower, gap))
            points += self._nearly(group, lower)
        return np.concatenate(points) if points else np.zeros((0, 3))

    def standing_on(self, group: int) -> set[int]:
        """Return the bodies of a group on which it stands."""
        feet = {i for i in self.members[group].tolist() if self.grounded[i]} if self.feet[group] else set()
        return feet | {upper for upper, _, _ in self.below[group]}

    def _nearly(self, group: int, lower: int) -> Iterator[FloatArray]:
        """Yield points (4, 3) below bodies of a group that are as good as on what another of its bodies rests on."""
        low, high = self.bodies.boxes
        room = _NEARLY * float((self.high[group] - self.low[group])[[0, 2]].max())
        members = self.members[group]
        if len(members) == 1 or len(members) > _MANY:
            return
        for i in set(members.tolist()) - self.standing_on(group):
            gap = low[i, 1] - high[lower, 1]
            first, last = np.maximum(low[i], low[lower]), np.minimum(high[i], high[lower])
            if abs(gap) <= room and (first <= last)[[0, 2]].all():
                yield np.array([[x, low[i, 1], z] for x in (first[0], last[0]) for z in (first[2], last[2])])

    def _contact(self, upper: int, lower: int, gap: float) -> FloatArray:
        """Return points around where a body rests on another."""
        low, high = self.bodies.boxes
        if self.is_whole(upper, lower):
            return _lowest(self.bodies, upper)
        size = min(float((high[i] - low[i]).max()) for i in (upper, lower))
        near = min(self.bodies.touch, 0.5 * _CLOSE * size)
        inside = low[upper, 1] < high[lower, 1] - 2.0 * self.bodies.touch
        if self.bodies.hollow[lower] and inside:  # in a cup or a bowl, whose rim holds it
            return np.array(
                [
                    [x, low[upper, 1], z]
                    for x in (low[lower, 0], high[lower, 0])
                    for z in (low[lower, 2], high[lower, 2])
                ]
            )
        found = self.bodies.patch(upper, lower, gap + near)
        if len(found):
            # What dips into another rests on its lowest points, what is in a hollow on all of them.
            hollow = self.bodies.hollow[[upper, lower]].any()
            return found if hollow else found[found[:, 1] <= found[:, 1].min() + near]
        first, last = np.maximum(low[upper], low[lower]), np.minimum(high[upper], high[lower])
        return np.array([[x, first[1], z] for x in (first[0], last[0]) for z in (first[2], last[2])])

    @cached_property
    def level(self) -> npt.NDArray[np.bool_]:
        """Which bodies (N,) are blocks along the axes of the world."""
        matrices = np.abs(self.bodies.solids.matrices[:, :, :3])
        straight = (matrices > 1e-6 * matrices.max(axis=(1, 2), keepdims=True)).sum(axis=(1, 2)) == 3
        blocks = np.array([kind is BLOCK for kind in self.bodies.solids.kinds], bool)[self.bodies.solids.forms]
        return np.asarray(straight & blocks & self.bodies.exact, bool)

    def is_pavement(self, lower: int, group: int) -> bool:
        """Whether a body is a broad, flat shape on the ground, in which a street lamp is planted."""
        low, high = self.bodies.boxes
        size = high[lower] - low[lower]
        is_broad = 2.0 * size[1] < size[[0, 2]].min() and size[[0, 2]].max() > self.high[group, 1] - self.low[group, 1]
        is_low = low[lower, 1] <= self._floor_top + 2.0 * self.bodies.touch
        return bool(self.contacts.loose[lower] and is_broad and is_low)

    @cached_property
    def _floor_top(self) -> float:
        """Height of the highest floor."""
        return float(self.bodies.boxes[1][self.contacts.floor, 1].max(initial=self.ground))

    def is_whole(self, upper: int, lower: int) -> bool:
        """Whether all of a body is above a level block that it rests on."""
        low, high = self.bodies.boxes
        if not self.level[lower] or low[upper, 1] < high[lower, 1] - self.bodies.touch:
            return False
        return bool((low[upper] >= low[lower])[[0, 2]].all() and (high[upper] <= high[lower])[[0, 2]].all())

    def key(self, group: int) -> tuple[object, ...]:
        """Return what decides how a group is balanced: equal groups on equal supports have equal keys."""
        bodies, members = self.bodies, self.members[group]
        lowers = [(upper, lower, self.is_whole(upper, lower)) for upper, lower, _ in self.below[group]]
        rows = [*members.tolist(), *(lower for _, lower, whole in lowers if not whole)]
        places = bodies.solids.matrices[rows].copy()
        places[:, :, 3] -= places[0, :, 3]
        numbers = np.round(places / (0.2 * bodies.touch or 1.0)).astype(np.int64)
        return (
            numbers.tobytes(), bodies.entity[rows].tobytes(), self.grounded[members].tobytes(),
            tuple((int(np.searchsorted(members, upper)), whole) for upper, _, whole in lowers),
            self.contacts.floor[[lower for _, lower, _ in lowers]].tobytes() if lowers else b"",
        )  # fmt: skip

    def is_easy(self, group: int) -> bool:
        """Whether a group is one upright body whose whole base is carried."""
        if len(self.members[group]) > 1 or len({lower for _, lower, _ in self.below[group]}) > 1:
            return False
        body = int(self.members[group][0])
        matrix = self.bodies.solids.matrices[body, :, :3]
        if self.bodies.hollow[body] or np.count_nonzero(np.abs(matrix) > 1e-6 * np.abs(matrix).max()) > 3:
            return False
        return self.feet[group] > 0 and not self.below[group]

    @cached_property
    def neighbours(self) -> list[set[int]]:
        """For each group the others that it touches."""
        found: list[set[int]] = [set() for _ in self.members]
        for i, j in self.group[self.contacts.pairs].tolist():
            found[i].add(j)
            found[j].add(i)
        return found

    def is_everywhere(self, group: int) -> bool:
        """Whether a group rests with all of its feet on what it stands on, so that moving it changes nothing."""
        floor, level = self.contacts.floor, self.bodies.boxes
        return all(
            self.is_whole(upper, lower) or (floor[lower] and bool(
                ((level[0][upper] >= level[0][lower]) & (level[1][upper] <= level[1][lower]))[[0, 2]].all()
            ))
            for upper, lower, _ in self.below[group]
        )  # fmt: skip

    def is_supported(self, group: int, but: int) -> bool:
        """Whether a group stands on the ground, or touches what does, without the group ``but``."""
        seen, stack = {group, but}, [group]
        while stack:
            at = stack.pop()
            if self.feet[at]:
                return True
            fresh = self.neighbours[at] - seen
            seen |= fresh
            stack += fresh
        return False

    def with_own_load(self, group: int) -> FloatArray:
        """Return the centre of mass (3,) of a group and what rests on it and on nothing else, such as the upper books
        of a pile."""
        seen, stack = {group}, [group]
        while stack and len(seen) <= _MANY:
            for upper, _ in self.above[stack.pop()]:
                other = int(self.group[upper])
                below = {int(self.group[lower]) for _, lower, _ in self.below[other]}
                if other not in seen and not self.feet[other] and below <= seen:
                    seen.add(other)
                    stack.append(other)
        return self._center_of({group} if len(seen) > _MANY else seen)

    def _center_of(self, groups: Collection[int]) -> FloatArray:
        rows = sorted(groups)
        found: FloatArray = (self.center[rows] * self.mass[rows, None]).sum(axis=0) / self.mass[rows].sum()
        return found

    def with_load(self, group: int) -> FloatArray:
        """Return the centre of mass (3,) of a group and all that rests on it, alone or with others."""
        seen, stack = {group}, [group]
        while stack:
            for upper, _ in self.above[stack.pop()]:
                other = int(self.group[upper])
                if other not in seen:
                    seen.add(other)
                    stack.append(other)
        return self._center_of(seen)


def standing_of(
    bodies: Bodies, contacts: Contacts, body: int, ground: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the points (K, 3) that carry the group of a body, the sides of their hull and the plumb line from its
    centre of mass (M, 2, 3), and that centre (1, 3)."""
    balance = _Balance(bodies, contacts, ground)
    group = int(balance.group[body])
    points, center = balance.supports(group), balance.center[group]
    if not len(points):
        return points, np.zeros((0, 2, 3)), center[None]
    level = float(points[:, 1].max())
    corners = np.insert(hull_of(points[:, [0, 2]]), 1, level, axis=1)
    sides = np.stack([corners, np.roll(corners, -1, axis=0)], axis=1)
    plumb = np.array([[center, [center[0], level, center[2]]]])
    return corners, np.concatenate([sides, plumb]), center[None]


def loads_of(bodies: Bodies, contacts: Contacts, body: int, ground: float) -> tuple[IntArray, FloatArray, IntArray]:
    """Return the bodies of the group of a body, their shares of its mass, and those on which it stands."""
    balance = _Balance(bodies, contacts, ground)
    group = int(balance.group[body])
    members = balance.members[group]
    mass = bodies.masses[0][members]
    return members, mass / mass.sum(), np.array(sorted(balance.standing_on(group)), np.int64)


class _Verdict(NamedTuple):
    """How a group is balanced: how far its centre is beside its support, negative inside, the way to a place inside
    with room, and whether it is on an edge."""

    beside: float
    back: FloatArray
    edge: bool


def unstable(
    bodies: Bodies, contacts: Contacts, ground: float, margins: tuple[float, float] = (_MARGIN, _ROOTED_MARGIN)
) -> Iterator[Fault]:
    """Yield the rigid groups that rest on something, but beside their centre of mass or on an edge.

    ``margins`` are of a group's breadth: how far its centre may be beside its support, on other things and on the
    ground; negative ones ask for room.
    """
    balance = _Balance(bodies, contacts, ground)
    known: dict[tuple[object, ...], _Verdict] = {}
    for group in range(len(balance.members)):
        if not (balance.feet[group] or balance.below[group]) or balance.is_easy(group):
            continue
        key = balance.key(group)
        if key not in known:
            known[key] = _verdict(balance, group)
        found = known[key]
        breadth = float((balance.high[group] - balance.low[group])[[0, 2]].max())
        first = int(balance.members[group][0])
        under = [lower for _, lower, _ in balance.below[group]]
        rooted = all(contacts.floor[each] or balance.is_pavement(each, group) for each in under)
        room = margins[1 if rooted else 0] * breadth
        if room < 0.0:  # no foot is asked for more room than it has
            room = max(room, -0.25 * width_of(balance.supports(group)[:, [0, 2]]))
        if balance.above[group] and found.beside <= room:
            found = _with_load(balance, group, found)
        falls = found.beside > room
        if not (falls or found.edge) or (rooted and is_rooted(bodies.words(first)[1:])):
            continue
        lowest = int(balance.members[group][np.argmin(bodies.boxes[0][balance.members[group], 1])])
        below = under[0] if under and not balance.grounded[lowest] else None
        if falls and beyond_edge(balance.supports(group)[:, [0, 2]], balance.with_load(group)[[0, 2]])[0] > room:
            shift = float(found.back[0]), 0.0, float(found.back[1])
            yield Fault(lowest, below, found.beside, None if balance.is_everywhere(group) else shift, shift)
        elif found.edge:
            yield Fault(lowest, below, breadth, None)


def _verdict(balance: _Balance, group: int) -> _Verdict:
    points = balance.supports(group)
    middle = balance.center[group, [0, 2]]
    beside, nearest = beyond_edge(points[:, [0, 2]], middle)
    breadth = float((balance.high[group] - balance.low[group])[[0, 2]].max())
    edge = _is_on_edge(balance.bodies, balance.standing_on(group), points, breadth)
    inward = points[:, [0, 2]].mean(axis=0) - nearest
    room = _ROOM * breadth / max(float(np.linalg.norm(inward)), 1e-9 * breadth)
    if balance.is_everywhere(group):
        room = min(room, 0.5)  # its foot grows no broader
    return _Verdict(beside, nearest - middle + room * inward, edge)


def _with_load(balance: _Balance, group: int, alone: _Verdict) -> _Verdict:
    """Return the verdict about a group with what it carries alone, if that is worse."""
    middle = balance.with_own_load(group)[[0, 2]]
    beside, nearest = beyond_edge(balance.supports(group)[:, [0, 2]], middle)
    return _Verdict(beside, nearest - middle, alone.edge) if beside > alone.beside else alone


def _is_on_edge(bodies: Bodies, feet: Collection[int], points: FloatArray, breadth: float) -> bool:
    """Return whether a group stands on edges or corners of bodies that have flat sides."""
    return bool(feet) and width_of(points[:, [0, 2]]) < _NARROW * breadth and all(_is_edge(bodies, i) for i in feet)


def _is_edge(bodies: Bodies, i: int) -> bool:
    """Return whether the lowest points of a body are an edge or a corner."""
    if bodies.hollow[i] or not bodies.exact[i]:
        return False
    form, _ = bodies.solids.form(i)
    axis = bodies.solids.matrices[i, :, 1]
    if form.is_rounded or (form.is_curved and abs(axis[1]) < 0.05 * np.linalg.norm(axis)):
        return False  # it lies on its round side
    low, high = bodies.boxes
    return width_of(_lowest(bodies, i, near=1e-6)[:, [0, 2]]) <= 1e-5 * float((high[i] - low[i]).max())


@lru_cache(maxsize=64)
def _vertices(form: CanonicalForm, ratios: Ratios) -> FloatArray:
    """Return the vertices (K, 3) of a primitive in its own frame."""
    return np.asarray(form.mesh(32, ratios).vertices, np.float64)


def _lowest(bodies: Bodies, i: int, near: float = _CLOSE) -> FloatArray:
    """Return the vertices (K, 3) of a body near its lowest point, within ``near`` of its longest side."""
    low, high = bodies.boxes
    room = min(near * float((high[i] - low[i]).max()), 2.0 * bodies.touch)
    if bodies.hollow[i] and (surface := bodies.surface(i)) is not None:
        vertices = np.asarray(surface.to_mesh64().vert_properties[:, :3], np.float64)
    else:
        form, ratios = bodies.solids.form(i)
        matrix = bodies.solids.matrices[i]
        vertices = _vertices(form, ratios) @ matrix[:, :3].T + matrix[:, 3]
    found: FloatArray = vertices[vertices[:, 1] <= vertices[:, 1].min() + room]
    return found


def hanging(bodies: Bodies, contacts: Contacts, ground: float) -> Iterator[Fault]:
    """Yield things that hang below another by nothing but contact, where nothing is made to hang."""
    balance = _Balance(bodies, contacts, ground)
    touched = np.zeros(len(balance.members), bool)  # by others at the side, or set into them
    aside = contacts.apart & ~contacts.rests
    for each in contacts.pairs[aside].T:
        touched[balance.group[each]] = True
    for group, carried in enumerate(balance.above):
        if balance.below[group] or balance.feet[group] or touched[group] or not carried:
            continue
        upper, lower = carried[0]
        names = [bodies.words(upper)[1:], bodies.words(lower)[1:]]
        if (
            is_airborne(names[1])
            or is_soft(names[1])
            or _has_noun(names[0], _HOLDERS | _SOFT)
            or not balance.is_supported(balance.group[upper], group)
        ):
            continue
        height = float(balance.high[group, 1] - balance.low[group, 1])
        up = float(bodies.boxes[1][upper, 1] - balance.low[group, 1])
        yield Fault(lower, upper, height, (0.0, up, 0.0))


# --- things that pass through each other -----------------------------------------------------------------------------


def intersecting(bodies: Bodies, contacts: Contacts, ground: float) -> Iterator[Fault]:
    """Yield pairs of things that pass through each other, the deepest pair of bodies of each.

    Things may be set into each other: a tree into the ground, a candle into a cake, a column into the wall beside it.
    What is reported: equal things that overlap, a thing that comes out of the other side of another, and one that is in
    another for a large part.
    """
    if not len(contacts.pairs):
        return
    low, high = bodies.boxes
    pairs = contacts.pairs
    solid = bodies.opaque & (bodies.exact | bodies.hollow) & ~contacts.floor
    deep = contacts.depth > np.where(bodies.hollow[pairs].any(axis=1), bodies.touch, 4.0 * bodies.touch)
    deep &= contacts.apart & solid[pairs].all(axis=1)
    extent = np.minimum(*(high - low).min(axis=1)[pairs.T])
    rounded = bodies.solids.that_are("is_rounded")
    own = bodies.masses[0]
    volume = np.bincount(contacts.thing, own, len(bodies))
    worst: dict[tuple[int, int], Fault] = {}
    shared: dict[tuple[int, int], float] = {}
    reported: set[tuple[int, int]] = set()
    for row in np.flatnonzero(deep).tolist()[:MAX_EXACT]:
        i, j = pairs[row].tolist()
        cut = bodies.hollow[[i, j]].any() and (bodies.is_cut(i, j) or bodies.is_cut(j, i))
        if _gives_way(bodies, i, j, not cut) or _is_ornament(bodies, contacts, i, j) or _are_built(bodies, i, j):
            continue
        key = (int(contacts.thing[i]), int(contacts.thing[j]))
        move = contacts.along[row] * contacts.depth[row]
        found = Fault(j, i, float(contacts.depth[row]), (float(move[0]), float(move[1]), float(move[2])))
        if key not in worst or worst[key].amount < found.amount:
            worst[key] = found
        same = bodies.words(i) == bodies.words(j) and contacts.depth[row] > _MAX_DEPTH * extent[row]
        if not rounded[[i, j]].any() and (
            same or _pierces(low, high, i, j, bodies.touch, ground) or _pierces(low, high, j, i, bodies.touch, ground)
        ):
            reported.add(key)
        if cut:
            reported.add(key)
        if key not in reported and contacts.depth[row] > 0.1 * extent[row]:
            common = bodies.shared_volume(i, j)
            shared[key] = shared.get(key, 0.0) + common
            if contacts.depth[row] > _MAX_DEPTH * extent[row] and common > _MAX_PART * min(own[i], own[j]):
                reported.add(key)
    for key, found in worst.items():
        if key in reported or shared.get(key, 0.0) > _MAX_SHARED * min(volume[key[0]], volume[key[1]]):
            yield found


def _gives_way(bodies: Bodies, i: int, j: int, held: bool = True) -> bool:
    """Return whether two bodies may overlap by what they are: one is soft, or, if ``held``, a slim one is set into a
    holder."""
    names = [bodies.words(k)[1:] for k in (i, j)]
    if any(is_soft(words) for words in names):
        return True
    low, high = bodies.boxes
    for slim, holder in ((i, names[1]), (j, names[0])) if held else ():
        size = np.sort(high[slim] - low[slim])
        if size[2] > _SLIM * size[1] and _has_noun(holder, _HOLDERS):
            return True
    return False


def is_soft(words: Sequence[str]) -> bool:
    """Return whether what leads to a body says that it gives way, flows or grows."""
    return _has_noun(words[-2:], _SOFT)


def _has_noun(words: Sequence[str], nouns: frozenset[str]) -> bool:
    return any(noun_of(word) in nouns for word in words)


def _are_built(bodies: Bodies, i: int, j: int) -> bool:
    """Return whether two bodies are of buildings, such as a wall and a tower."""
    first, second = bodies.words(i), bodies.words(j)
    common = next((k for k, (a, b) in enumerate(zip(first, second)) if a != b), max(len(first) - 2, 1))
    return all(_has_noun(words[common:], _STRUCTURE | _BUILDINGS) for words in (first, second))


def _is_ornament(bodies: Bodies, contacts: Contacts, i: int, j: int) -> bool:
    """Return whether one of two bodies is a shape in an arrangement that is smaller than the other."""
    low, high = bodies.boxes
    size = np.linalg.norm(high - low, axis=1)
    return bool((contacts.loose[i] and size[i] < size[j]) or (contacts.loose[j] and size[j] < size[i]))


def _pierces(low: FloatArray, high: FloatArray, a: int, b: int, room: float, ground: float) -> bool:
    """Return whether body ``a`` reaches out of two opposite sides of body ``b``, within its other sides.

    What lies on the ground has no lower side.
    """
    for axis in range(3):
        if axis == 1 and low[b, 1] <= ground + room:
            continue
        others = [each for each in range(3) if each != axis]
        out = low[a, axis] < low[b, axis] - room and high[a, axis] > high[b, axis] + room
        within = ((low[a, others] >= low[b, others] - room) & (high[a, others] <= high[b, others] + room)).all()
        if out and within:
            return True
    return False
