"""Objects that would fall over or pass through each other: rigid groups of solids, their supports and their balance.

Solids form one object by words and nesting, because programs build an object from several parts: in the entity that
contains both, one is a shape ("cube"), has a noun of parts ("leg", "wheel") or has the word of its container. Only
different objects rest on each other, and only they can topple or pass through each other. Objects that are set into
each other are welded into a rigid group; a group topples if its center of mass is outside the convex hull of its
contacts.
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


# Nouns of parts, which belong to the object next to them.
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
# Nouns of objects that float, fly or hang.
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
# Nouns of objects that are lifted from their support.
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
# Nouns of objects that stand on a floor by their weight alone.
_FURNITURE = _words(
    """
    armchair bed bench bookcase bookshelf cabinet couch crib cupboard desk drawers dresser fridge nightstand oven piano
    refrigerator sideboard sofa stove table wardrobe workbench
    """
)
# Nouns of objects that are anchored in the ground.
_ROOTED = _words(
    """
    cactus crane flagpole floodlight flower hydrant lamppost mast palm plant pole post ramp sapling sign
    signpost stair staircase step streetlamp streetlight tree
    """
)
# Nouns of objects that others are set into or hang from.
_HOLDERS = _words(
    """
    arm bar basket beam bin bowl box bracket branch bucket cable canopy ceiling chain cone container crane cup
    frame glass hanger holder hook jar line mug nail pan pillar pot quiver rail ring rod roof rope sack saucer
    shade stand string tray tree tub vase wire
    """
)
# Nouns of objects that give way, flow or grow: an object may be inside them.
_SOFT = _words(
    """
    air beard blanket blossom bough boulder bubble bush canopy carpet cloth cloud cream crown curtain cushion
    dirt duvet flame flower foam fog foliage fur garland grass ground hair hay hedge hill island ivy jam lake
    land lava lawn leaf mattress meadow mist moss mountain mud ocean path pavement paving pebble petal pillow
    plant pond pool puddle puff quilt river road rock rug sand sauce scarf sea shrub sky smoke soil steam stream
    terrain towel tree tuft water wave weed wig wool
    """
)
# Nouns of buildings, which may be set into each other.
_BUILDINGS = _words(
    """
    arch barn battlement bridge building buttress castle chapel chimney church city cottage drum dungeon gate
    gatehouse hall house hut keep parapet porch pyramid skyscraper temple terrace tower turret village
    """
)
# Nouns of objects that are fastened to a wall or a ceiling that they touch.
_MOUNTED = _words(
    """
    antenna banner bell board bookshelf bracket cabinet clock curtain dartboard ivy mirror monitor painting photo
    picture plaque poster projector rack radiator ring screen shelf shutter sink socket speaker switch tv vent
    """
)
# Nouns of parts of buildings, which are not parts of the objects next to them.
_STRUCTURE = _words(
    """
    board border ceiling column door fence floor frame panel pillar plate post railing roof shelf side slab
    square stair step tabletop tile top wall window
    """
)
_FLOOR_AREA = 0.3  # of the scene's area: a body this broad, at the bottom of the scene, is the ground
_ZERO_TOLERANCE = 1e-3  # of the scene's height: tolerance for the top of the ground at y = 0
_MAX_REST_DEPTH = 0.25  # of an object's height: an object deeper in another does not rest on it but is held by it
_MIN_HOLD_DEPTH = 0.05  # of the smaller body's least side: objects that overlap more, sideways, hold each other
_MIN_REST_NORMAL = 0.8  # vertical component of a contact's normal, from which one object rests on the other
_BALANCE_MARGIN = 0.02  # of a group's breadth: tolerance of the center of mass beyond the support
_GROUND_BALANCE_MARGIN = 0.05  # the same on the ground: posts and trees are held by parts that are not modeled
_FIX_MARGIN = 0.1  # of a group's breadth: a fix moves the center of mass this far inside the support
_MAX_PENETRATION = 0.25  # of the smaller extent: equal objects that overlap more are reported
_MAX_SHARED_VOLUME = 0.12  # of the smaller object's volume: more of it inside another object is reported
_MAX_SHARED_BODY = 0.2  # of the smaller body's volume: more of it inside a body of another object is reported
_FOOT_HEIGHT = 0.02  # of a body's longest side: vertices this near to its lowest point are its foot
_NEAR_SUPPORT = 0.05  # of a group's breadth: a part this near above a support stops the group from tipping far
# bodies of a group whose near supports are tested, and groups of a pile: both grow quadratically
_MAX_GROUP_BODIES = 200
_EDGE_WIDTH = 0.05  # of a body's breadth: a narrower foot is an edge
_SLIM_RATIO = 4.0  # length over thickness of pencils and flowers, which are set into other objects


class Fault(NamedTuple):
    """Body that would fall, or that passes through another.

    Attributes
    ----------
    body, other
        The body, and the one that it rests on or passes through; None is the ground.
    amount
        Distance of its center of mass beyond its support, or penetration depth, in scene units; the breadth of an
        object that stands on an edge.
    move
        Translation that fixes it; None for objects on an edge, and if moving does not help.
    shift
        Translation of the center of mass alone that brings it over the support, with a margin; None for objects on an
        edge.
    """

    body: int
    other: int | None
    amount: float
    move: tuple[float, float, float] | None
    shift: tuple[float, float, float] | None = None


@dataclass(frozen=True, slots=True)
class ChainLink:
    """One instance on the path to a primitive: its number and its entity."""

    number: int
    entity: Entity


def noun_of(word: str) -> str:
    """Return the singular of the last noun of a word, such as "leg" for "front-legs"."""
    noun = word.lower().replace("_", "-").replace(" ", "-").rstrip("-0123456789").split("-")[-1]
    return noun[:-1] if noun.endswith("s") and not noun.endswith("ss") else noun


def is_airborne(words: Sequence[str]) -> bool:
    """Return whether any of the words names an object that floats, flies or hangs."""
    return any(
        noun_of(part) in AIRBORNE for word in words for part in word.replace("_", "-").replace(" ", "-").split("-")
    )


def is_part_of_object(entity: Entity) -> bool:
    """Return whether an entity is a part of the object that contains it, by its word."""
    cls = find(entity.word)
    return (cls is not None and cls.is_solid) or noun_of(entity.word) in PARTS


def chains_of(root: Entity) -> list[tuple[ChainLink, ...]]:
    """Return for each primitive below ``root``, in depth-first order, the instances from the root to it."""
    chains: list[tuple[ChainLink, ...]] = []
    number = 0
    stack: list[tuple[Entity, tuple[ChainLink, ...]]] = [(root, ())]
    while stack:
        entity, above = stack.pop()
        number += 1
        chain = (*above, ChainLink(number, entity))
        if entity.is_primitive:
            chains.append(chain)
        stack.extend((part.car, chain) for part in reversed(entity.children))
    return chains


def are_one_object(a: Sequence[ChainLink], b: Sequence[ChainLink], arrangements: Collection[int] = ()) -> bool:
    """Return whether two touching primitives belong to one object.

    In the entity that contains both, one of them is a part: a shape, or a noun of parts; but not a part of an object
    that is lifted from it, such as a cup. In ``arrangements``, which contain a floor, the floor is a part, and only
    parts belong together.
    """
    level = 0
    while level + 1 < min(len(a), len(b)) and a[level + 1].number == b[level + 1].number:
        level += 1
    if level + 1 >= min(len(a), len(b)):
        return True
    links = a[level + 1], b[level + 1]
    if a[level].entity.word in (links[0].entity.word, links[1].entity.word):  # recursion
        return True
    parts = [is_part_of_object(link.entity) or link.number in arrangements for link in links]
    if a[level].number in arrangements:
        floors = [link.number in arrangements or noun_of(link.entity.word) in _STRUCTURE for link in links]
        shapes = [_is_shape(link.entity) for link in links]
        return all(parts) or (any(parts) and not any(floors) and not any(shapes))
    for link, other in (links, links[::-1]):
        if is_portable(link.entity) and (_is_shape(other.entity) or noun_of(other.entity.word) in _STRUCTURE):
            return False
    return any(parts)


def is_mounted(words: Sequence[str]) -> bool:
    """Return whether any of the words names a hanging or flying object, or the last a wall-mounted one."""
    named = [word for word in words if (cls := find(word)) is None or not cls.is_solid]
    return is_airborne(words) or _has_noun(named[-1:], _MOUNTED)


def is_rooted(words: Sequence[str]) -> bool:
    """Return whether any of the words names an object that is anchored in the ground, such as a street lamp."""
    return _has_noun(words, _ROOTED) or _has_noun([_closed(word) for word in words], _ROOTED)


def _closed(word: str) -> str:
    """Return a word with its last two nouns as one: "street lamp" as "streetlamp"."""
    first, _, last = word.lower().replace("_", "-").replace(" ", "-").rpartition("-")
    return first.rpartition("-")[2] + last


def is_put_down(words: Sequence[str]) -> bool:
    """Return whether a path has a word for an object put on a floor, and none for one that may be set into it."""
    return _has_noun(words, _PORTABLE | _FURNITURE) and not may_be_set_in(words)


def may_be_set_in(words: Sequence[str]) -> bool:
    """Return whether any of the words names an object that may be set into the ground, or a part of a building."""
    return _has_noun(words, _ROOTED | _SOFT | _STRUCTURE | _BUILDINGS | AIRBORNE)


def is_portable(entity: Entity) -> bool:
    """Return whether an entity is an object that is lifted from its support, by its noun."""
    return not _is_shape(entity) and noun_of(entity.word) in _PORTABLE


def _is_shape(entity: Entity) -> bool:
    """Return whether an entity's word is that of a primitive shape."""
    cls = find(entity.word)
    return cls is not None and cls.is_solid


@dataclass(frozen=True, slots=True, eq=False)
class Contacts:
    """Contacts between the M touching pairs of N bodies, and the groups that they form.

    Attributes
    ----------
    pairs : (M, 2)
        Numbers of the two bodies.
    gaps : (M,)
        Distances in scene units.
    apart : (M,)
        Whether the bodies belong to two objects.
    rests : (M,)
        Whether one of the objects rests on the other.
    depth : (M,), along : (M, 3)
        Penetration depth, and the direction that separates the bodies; zeros within an object.
    object_of : (N,)
        Number of the object that each body is part of.
    group : (N,)
        Number of the rigid group of objects that hold each other.
    floor : (N,)
        Whether a body is the ground.
    loose : (N,)
        Whether a body is a shape in an arrangement.
    owner : (N,)
        Number of the instance that a body is, or whose material it is.
    """

    pairs: IntArray
    gaps: FloatArray
    apart: npt.NDArray[np.bool_]
    rests: npt.NDArray[np.bool_]
    depth: FloatArray
    along: FloatArray
    object_of: IntArray
    group: IntArray
    floor: npt.NDArray[np.bool_]
    loose: npt.NDArray[np.bool_]
    owner: IntArray


def contacts_of(bodies: Bodies, root: Entity) -> Contacts:
    """Return the contacts of the bodies of a frame, and the groups that they form.

    First the parts of each object are joined, then the objects of which one is set into the other.
    """
    all_chains = chains_of(root)
    chains = [all_chains[row] for row in bodies.row.tolist()]
    pairs, gaps, _ = bodies.contacts
    floor = _is_floor(bodies)
    arrangements = {link.number for i in np.flatnonzero(floor).tolist() for link in chains[i][:-1]}
    apart = np.array([not are_one_object(chains[i], chains[j], arrangements) for i, j in pairs.tolist()], bool)
    depth, along = np.zeros(len(pairs)), np.zeros((len(pairs), 3))
    if apart.any():
        depth[apart], along[apart] = bodies.overlaps(pairs[apart])
    object_of = clusters(len(bodies), pairs[~apart].tolist())
    low, high = boxes_of_groups(bodies, object_of)
    upright = np.abs(along[:, 1]) >= _MIN_REST_NORMAL
    shallow = np.minimum((high - low)[pairs[:, 0], 1], (high - low)[pairs[:, 1], 1]) * _MAX_REST_DEPTH
    on_floor = floor[pairs].any(axis=1)
    held_by_floor = on_floor & (depth > 4.0 * bodies.touch)
    for row in np.flatnonzero(held_by_floor & apart).tolist():
        upper = next((i for i in pairs[row].tolist() if not floor[i]), None)
        held_by_floor[row] = upper is None or not is_put_down(bodies.words(upper)[1:])
        if upper is not None:
            shallow[row] = _MAX_REST_DEPTH * (high - low)[upper, 1]
    rests = apart & upright & ~held_by_floor & (depth <= np.maximum(shallow, 4.0 * bodies.touch))
    least_side = np.minimum(*(bodies.boxes[1] - bodies.boxes[0]).min(axis=1)[pairs.T]) if len(pairs) else np.zeros(0)
    held = apart & ~rests & (upright | (depth > np.maximum(_MIN_HOLD_DEPTH * least_side, bodies.touch)))
    group = clusters(len(bodies), pairs[~apart | held].tolist())
    owner = np.array([chain[-2 if len(chain) > 1 and _is_shape(chain[-1].entity) else -1].number for chain in chains])
    loose = np.array(
        [len(chain) > 1 and chain[-2].number in arrangements and _is_shape(chain[-1].entity) for chain in chains], bool
    )
    return Contacts(pairs, gaps, apart, rests, depth, along, object_of, group, floor, loose, owner.astype(np.int64))


def boxes_of_groups(bodies: Bodies, group: IntArray) -> tuple[FloatArray, FloatArray]:
    """Return for each body the box of its group: low and high corners (N, 3)."""
    low, high = (corners.copy() for corners in bodies.boxes)
    np.minimum.at(low, group, bodies.boxes[0])
    np.maximum.at(high, group, bodies.boxes[1])
    return low[group], high[group]


def _is_floor(bodies: Bodies) -> npt.NDArray[np.bool_]:
    """Return which bodies (N,) are the ground: broad, and at the bottom of the scene or with their top at y = 0."""
    low, high = bodies.boxes
    if not len(low):
        return np.zeros(0, bool)
    wide = (high.max(axis=0) - low.min(axis=0))[[0, 2]].prod()
    tall = float(high[:, 1].max() - low[:, 1].min())
    is_floor: npt.NDArray[np.bool_] = (high - low)[:, [0, 2]].prod(axis=1) >= _FLOOR_AREA * wide
    at_zero = np.abs(high[:, 1]) <= _ZERO_TOLERANCE * tall
    is_floor &= at_zero | (low[:, 1] <= low[:, 1].min() + 0.1 * tall)
    return is_floor


# --- balance ---------------------------------------------------------------------------------------------------------


class _Balance:
    """Rigid groups of a frame, their supports and their centers of mass."""

    def __init__(self, bodies: Bodies, contacts: Contacts, ground: float) -> None:
        """Sum masses and centers by group, and collect the contacts at which a group rests on another."""
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
        """Return the points (K, 3) whose convex hull supports a group."""
        points: list[FloatArray] = []
        for i in self.members[group].tolist() if self.feet[group] else ():
            if self.grounded[i]:
                points.append(_lowest(self.bodies, i))
        for upper, lower, gap in self.below[group]:
            points.append(self._contact(upper, lower, gap))
            points += self._nearly(group, lower)
        return np.concatenate(points) if points else np.zeros((0, 3))

    def standing_on(self, group: int) -> set[int]:
        """Return the bodies of a group that are its feet."""
        feet = {i for i in self.members[group].tolist() if self.grounded[i]} if self.feet[group] else set()
        return feet | {upper for upper, _, _ in self.below[group]}

    def _nearly(self, group: int, lower: int) -> Iterator[FloatArray]:
        """Yield corners (4, 3) of bodies that are barely above or below a support of another body of their group."""
        low, high = self.bodies.boxes
        tolerance = _NEAR_SUPPORT * float((self.high[group] - self.low[group])[[0, 2]].max())
        members = self.members[group]
        if len(members) == 1 or len(members) > _MAX_GROUP_BODIES:
            return
        for i in set(members.tolist()) - self.standing_on(group):
            gap = low[i, 1] - high[lower, 1]
            first, last = np.maximum(low[i], low[lower]), np.minimum(high[i], high[lower])
            if abs(gap) <= tolerance and (first <= last)[[0, 2]].all():
                yield np.array([[x, low[i, 1], z] for x in (first[0], last[0]) for z in (first[2], last[2])])

    def _contact(self, upper: int, lower: int, gap: float) -> FloatArray:
        """Return points (K, 3) around the contact at which a body rests on another."""
        low, high = self.bodies.boxes
        if self.is_whole(upper, lower):
            return _lowest(self.bodies, upper)
        size = min(float((high[i] - low[i]).max()) for i in (upper, lower))
        room = min(self.bodies.touch, 0.5 * _FOOT_HEIGHT * size)
        inside = low[upper, 1] < high[lower, 1] - 2.0 * self.bodies.touch
        if self.bodies.hollow[lower] and inside:  # in a cup or a bowl, held by its rim
            return np.array(
                [
                    [x, low[upper, 1], z]
                    for x in (low[lower, 0], high[lower, 0])
                    for z in (low[lower, 2], high[lower, 2])
                ]
            )
        patch = self.bodies.patch(upper, lower, gap + room)
        if len(patch):
            # A body that dips into another rests on its lowest points, one in a hollow on all of them.
            hollow = self.bodies.hollow[[upper, lower]].any()
            return patch if hollow else patch[patch[:, 1] <= patch[:, 1].min() + room]
        first, last = np.maximum(low[upper], low[lower]), np.minimum(high[upper], high[lower])
        return np.array([[x, first[1], z] for x in (first[0], last[0]) for z in (first[2], last[2])])

    @cached_property
    def level(self) -> npt.NDArray[np.bool_]:
        """Mask (N,) of bodies that are blocks along the axes of the world."""
        matrices = np.abs(self.bodies.solids.matrices[:, :, :3])
        straight = (matrices > 1e-6 * matrices.max(axis=(1, 2), keepdims=True)).sum(axis=(1, 2)) == 3
        blocks = np.array([kind is BLOCK for kind in self.bodies.solids.kinds], bool)[self.bodies.solids.forms]
        return np.asarray(straight & blocks & self.bodies.exact, bool)

    def is_pavement(self, lower: int, group: int) -> bool:
        """Return whether a body is a broad, flat shape on the ground, in which a street lamp may be planted."""
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
        """Return whether all of a body is above a level block that it rests on."""
        low, high = self.bodies.boxes
        if not self.level[lower] or low[upper, 1] < high[lower, 1] - self.bodies.touch:
            return False
        return bool((low[upper] >= low[lower])[[0, 2]].all() and (high[upper] <= high[lower])[[0, 2]].all())

    def key(self, group: int) -> tuple[object, ...]:
        """Return a key of a group's balance: equal groups on equal supports have equal keys."""
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
        """Return whether a group is one upright body that stands on the ground with its whole base."""
        if len(self.members[group]) > 1 or len({lower for _, lower, _ in self.below[group]}) > 1:
            return False
        body = int(self.members[group][0])
        matrix = self.bodies.solids.matrices[body, :, :3]
        if self.bodies.hollow[body] or np.count_nonzero(np.abs(matrix) > 1e-6 * np.abs(matrix).max()) > 3:
            return False
        return self.feet[group] > 0 and not self.below[group]

    @cached_property
    def neighbours(self) -> list[set[int]]:
        """Touching groups of each group."""
        touching: list[set[int]] = [set() for _ in self.members]
        for i, j in self.group[self.contacts.pairs].tolist():
            touching[i].add(j)
            touching[j].add(i)
        return touching

    def is_everywhere(self, group: int) -> bool:
        """Return whether all feet of a group are fully supported, so that moving it changes nothing."""
        floor, level = self.contacts.floor, self.bodies.boxes
        return all(
            self.is_whole(upper, lower) or (floor[lower] and bool(
                ((level[0][upper] >= level[0][lower]) & (level[1][upper] <= level[1][lower]))[[0, 2]].all()
            ))
            for upper, lower, _ in self.below[group]
        )  # fmt: skip

    def is_supported(self, group: int, but: int) -> bool:
        """Return whether a group is connected to the ground without the group ``but``."""
        visited, stack = {group, but}, [group]
        while stack:
            current = stack.pop()
            if self.feet[current]:
                return True
            unvisited = self.neighbours[current] - visited
            visited |= unvisited
            stack += unvisited
        return False

    def with_own_load(self, group: int) -> FloatArray:
        """Return the center of mass (3,) of a group with its own load: objects that rest on nothing else.

        An example is the upper books of a pile.
        """
        loaded, stack = {group}, [group]
        while stack and len(loaded) <= _MAX_GROUP_BODIES:
            for upper, _ in self.above[stack.pop()]:
                other = int(self.group[upper])
                below = {int(self.group[lower]) for _, lower, _ in self.below[other]}
                if other not in loaded and not self.feet[other] and below <= loaded:
                    loaded.add(other)
                    stack.append(other)
        return self._center_of({group} if len(loaded) > _MAX_GROUP_BODIES else loaded)

    def _center_of(self, groups: Collection[int]) -> FloatArray:
        """Return the common center of mass (3,) of groups."""
        rows = sorted(groups)
        moment = (self.center[rows] * self.mass[rows, None]).sum(axis=0)
        return np.asarray(moment / self.mass[rows].sum(), np.float64)

    def with_load(self, group: int) -> FloatArray:
        """Return the center of mass (3,) of a group and all objects that rest on it, alone or with others."""
        loaded, stack = {group}, [group]
        while stack:
            for upper, _ in self.above[stack.pop()]:
                other = int(self.group[upper])
                if other not in loaded:
                    loaded.add(other)
                    stack.append(other)
        return self._center_of(loaded)


def standing_of(
    bodies: Bodies, contacts: Contacts, body: int, ground: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return marks on the balance of the group of a body.

    These are the corners (K, 3) of its support, the sides of the support and the plumb line from its center of mass (M,
    2, 3), and that center (1, 3).
    """
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
    """Return the bodies of the group of a body, their shares of its mass, and those that are its feet."""
    balance = _Balance(bodies, contacts, ground)
    group = int(balance.group[body])
    members = balance.members[group]
    mass = bodies.masses[0][members]
    return members, mass / mass.sum(), np.array(sorted(balance.standing_on(group)), np.int64)


class _Verdict(NamedTuple):
    """Balance of a group.

    Attributes
    ----------
    beside
        Distance of its center of mass beyond its support, negative inside.
    back : (2,)
        Horizontal translation that brings the center inside, with a margin.
    edge
        Whether it stands on an edge.
    """

    beside: float
    back: FloatArray
    edge: bool


def unstable(
    bodies: Bodies,
    contacts: Contacts,
    ground: float,
    margins: tuple[float, float] = (_BALANCE_MARGIN, _GROUND_BALANCE_MARGIN),
) -> Iterator[Fault]:
    """Yield the rigid groups that rest on a support, but not below their center of mass, or on an edge.

    ``margins`` are fractions of a group's breadth: tolerances of the center beyond the support, on other objects and on
    the ground; negative ones ask for a margin inside.
    """
    balance = _Balance(bodies, contacts, ground)
    known: dict[tuple[object, ...], _Verdict] = {}
    for group in range(len(balance.members)):
        if not (balance.feet[group] or balance.below[group]) or balance.is_easy(group):
            continue
        key = balance.key(group)
        if key not in known:
            known[key] = _verdict(balance, group)
        verdict = known[key]
        breadth = float((balance.high[group] - balance.low[group])[[0, 2]].max())
        first = int(balance.members[group][0])
        under = [lower for _, lower, _ in balance.below[group]]
        rooted = all(contacts.floor[lower] or balance.is_pavement(lower, group) for lower in under)
        margin = margins[1 if rooted else 0] * breadth
        if margin < 0.0:  # a foot has at most a quarter of its width as a margin
            margin = max(margin, -0.25 * width_of(balance.supports(group)[:, [0, 2]]))
        if balance.above[group] and verdict.beside <= margin:
            verdict = _with_load(balance, group, verdict)
        falls = verdict.beside > margin
        if not (falls or verdict.edge) or (rooted and is_rooted(bodies.words(first)[1:])):
            continue
        lowest = int(balance.members[group][np.argmin(bodies.boxes[0][balance.members[group], 1])])
        below = under[0] if under and not balance.grounded[lowest] else None
        if falls and beyond_edge(balance.supports(group)[:, [0, 2]], balance.with_load(group)[[0, 2]])[0] > margin:
            shift = float(verdict.back[0]), 0.0, float(verdict.back[1])
            yield Fault(lowest, below, verdict.beside, None if balance.is_everywhere(group) else shift, shift)
        elif verdict.edge:
            yield Fault(lowest, below, breadth, None)


def _verdict(balance: _Balance, group: int) -> _Verdict:
    """Return the balance of a group without its load."""
    points = balance.supports(group)
    middle = balance.center[group, [0, 2]]
    beside, nearest = beyond_edge(points[:, [0, 2]], middle)
    breadth = float((balance.high[group] - balance.low[group])[[0, 2]].max())
    edge = _is_on_edge(balance.bodies, balance.standing_on(group), points, breadth)
    inward = points[:, [0, 2]].mean(axis=0) - nearest
    margin = _FIX_MARGIN * breadth / max(float(np.linalg.norm(inward)), 1e-9 * breadth)
    if balance.is_everywhere(group):
        margin = min(margin, 0.5)  # moving does not broaden its foot
    return _Verdict(beside, nearest - middle + margin * inward, edge)


def _with_load(balance: _Balance, group: int, alone: _Verdict) -> _Verdict:
    """Return the balance of a group with its own load, if that is worse than ``alone``."""
    middle = balance.with_own_load(group)[[0, 2]]
    beside, nearest = beyond_edge(balance.supports(group)[:, [0, 2]], middle)
    return _Verdict(beside, nearest - middle, alone.edge) if beside > alone.beside else alone


def _is_on_edge(bodies: Bodies, feet: Collection[int], points: FloatArray, breadth: float) -> bool:
    """Return whether a group stands on edges or corners of bodies that have flat sides."""
    return bool(feet) and width_of(points[:, [0, 2]]) < _EDGE_WIDTH * breadth and all(_is_edge(bodies, i) for i in feet)


def _is_edge(bodies: Bodies, i: int) -> bool:
    """Return whether the lowest points of a body are an edge or a corner."""
    if bodies.hollow[i] or not bodies.exact[i]:
        return False
    form, _ = bodies.solids.form(i)
    axis = bodies.solids.matrices[i, :, 1]
    if form.is_rounded or (form.is_curved and abs(axis[1]) < 0.05 * np.linalg.norm(axis)):
        return False  # on its round side
    low, high = bodies.boxes
    return width_of(_lowest(bodies, i, near=1e-6)[:, [0, 2]]) <= 1e-5 * float((high[i] - low[i]).max())


@lru_cache(maxsize=64)
def _vertices(form: CanonicalForm, ratios: Ratios) -> FloatArray:
    """Return the vertices (K, 3) of a primitive in its own frame."""
    return np.asarray(form.mesh(32, ratios).vertices, np.float64)


def _lowest(bodies: Bodies, i: int, near: float = _FOOT_HEIGHT) -> FloatArray:
    """Return the vertices (K, 3) of a body near its lowest point, within ``near`` of its longest side."""
    low, high = bodies.boxes
    tolerance = min(near * float((high[i] - low[i]).max()), 2.0 * bodies.touch)
    if bodies.hollow[i] and (surface := bodies.surface(i)) is not None:
        vertices = np.asarray(surface.to_mesh64().vert_properties[:, :3], np.float64)
    else:
        form, ratios = bodies.solids.form(i)
        matrix = bodies.solids.matrices[i]
        vertices = _vertices(form, ratios) @ matrix[:, :3].T + matrix[:, 3]
    foot: FloatArray = vertices[vertices[:, 1] <= vertices[:, 1].min() + tolerance]
    return foot


def hanging(bodies: Bodies, contacts: Contacts, ground: float) -> Iterator[Fault]:
    """Yield objects that hang below another by contact alone, where nothing is made to hang."""
    balance = _Balance(bodies, contacts, ground)
    touched = np.zeros(len(balance.members), bool)  # at the side, or by penetration
    aside = contacts.apart & ~contacts.rests
    for bodies_aside in contacts.pairs[aside].T:
        touched[balance.group[bodies_aside]] = True
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


# --- objects that pass through each other ----------------------------------------------------------------------------


def intersecting(bodies: Bodies, contacts: Contacts, ground: float) -> Iterator[Fault]:
    """Yield pairs of objects that pass through each other, with their deepest pair of bodies.

    Objects may be set into each other: a tree into the ground, a candle into a cake, a column into the wall next to it.
    Reported are equal objects that overlap, an object that comes out of the other side of another, and one that is
    inside another for a large part.
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
    body_volume = bodies.masses[0]
    volume = np.bincount(contacts.object_of, body_volume, len(bodies))
    worst: dict[tuple[int, int], Fault] = {}
    shared: dict[tuple[int, int], float] = {}
    reported: set[tuple[int, int]] = set()
    for row in np.flatnonzero(deep).tolist()[:MAX_EXACT]:
        i, j = pairs[row].tolist()
        is_cut = bodies.hollow[[i, j]].any() and (bodies.is_cut(i, j) or bodies.is_cut(j, i))
        if (
            _gives_way(bodies, i, j, allows_holders=not is_cut)
            or _is_ornament(bodies, contacts, i, j)
            or _are_built(bodies, i, j)
        ):
            continue
        key = (int(contacts.object_of[i]), int(contacts.object_of[j]))
        move = contacts.along[row] * contacts.depth[row]
        fault = Fault(j, i, float(contacts.depth[row]), (float(move[0]), float(move[1]), float(move[2])))
        if key not in worst or worst[key].amount < fault.amount:
            worst[key] = fault
        is_peer = bodies.words(i) == bodies.words(j) and contacts.depth[row] > _MAX_PENETRATION * extent[row]
        if not rounded[[i, j]].any() and (
            is_peer
            or _pierces(low, high, i, j, bodies.touch, ground)
            or _pierces(low, high, j, i, bodies.touch, ground)
        ):
            reported.add(key)
        if is_cut:
            reported.add(key)
        if key not in reported and contacts.depth[row] > 0.1 * extent[row]:
            common = bodies.shared_volume(i, j)
            shared[key] = shared.get(key, 0.0) + common
            if contacts.depth[row] > _MAX_PENETRATION * extent[row] and common > _MAX_SHARED_BODY * min(
                body_volume[i], body_volume[j]
            ):
                reported.add(key)
    for key, fault in worst.items():
        if key in reported or shared.get(key, 0.0) > _MAX_SHARED_VOLUME * min(volume[key[0]], volume[key[1]]):
            yield fault


def _gives_way(bodies: Bodies, i: int, j: int, *, allows_holders: bool) -> bool:
    """Return whether two bodies may overlap by their words.

    One is soft or, if ``allows_holders``, a slim one is set into a holder.
    """
    names = [bodies.words(k)[1:] for k in (i, j)]
    if any(is_soft(words) for words in names):
        return True
    low, high = bodies.boxes
    for slim, holder in ((i, names[1]), (j, names[0])) if allows_holders else ():
        size = np.sort(high[slim] - low[slim])
        if size[2] > _SLIM_RATIO * size[1] and _has_noun(holder, _HOLDERS):
            return True
    return False


def is_soft(words: Sequence[str]) -> bool:
    """Return whether the last words of a path name an object that gives way, flows or grows."""
    return _has_noun(words[-2:], _SOFT)


def _has_noun(words: Sequence[str], nouns: frozenset[str]) -> bool:
    """Return whether any of the words has one of the nouns."""
    return any(noun_of(word) in nouns for word in words)


def _are_built(bodies: Bodies, i: int, j: int) -> bool:
    """Return whether two bodies belong to buildings, such as a wall and a tower."""
    first, second = bodies.words(i), bodies.words(j)
    common = next((k for k, (a, b) in enumerate(zip(first, second)) if a != b), max(len(first) - 2, 1))
    return all(_has_noun(words[common:], _STRUCTURE | _BUILDINGS) for words in (first, second))


def _is_ornament(bodies: Bodies, contacts: Contacts, i: int, j: int) -> bool:
    """Return whether one of two bodies is a shape in an arrangement and smaller than the other."""
    low, high = bodies.boxes
    size = np.linalg.norm(high - low, axis=1)
    return bool((contacts.loose[i] and size[i] < size[j]) or (contacts.loose[j] and size[j] < size[i]))


def _pierces(low: FloatArray, high: FloatArray, a: int, b: int, tolerance: float, ground: float) -> bool:
    """Return whether body ``a`` comes out of two opposite sides of body ``b``, within its other sides.

    A body on the ground has no lower side.
    """
    for axis in range(3):
        if axis == 1 and low[b, 1] <= ground + tolerance:
            continue
        across = [other for other in range(3) if other != axis]
        out = low[a, axis] < low[b, axis] - tolerance and high[a, axis] > high[b, axis] + tolerance
        within = (
            (low[a, across] >= low[b, across] - tolerance) & (high[a, across] <= high[b, across] + tolerance)
        ).all()
        if out and within:
            return True
    return False
