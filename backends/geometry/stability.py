"""Things that would fall over or pass through each other: rigid groups of solids, what they rest on, and their balance.

Solids are welded into rigid groups where people model one thing of several: where they overlap, touch at the side, or
belong to one thing. What is left are things that rest on each other. A group topples if its centre of mass is beside
the convex hull of the places where it rests.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from scenelang.backends.geometry.convex import Bodies, beyond_edge, clusters
from scenelang.backends.geometry.distance import IntArray, depths
from scenelang.backends.geometry.solids import FloatArray
from scenelang.grammar.datum import dataclass
from scenelang.interpreter.scene.entity import Entity
from scenelang.interpreter.scene.primitives import find


def _words(text: str) -> frozenset[str]:
    return frozenset(text.split())


# Nouns of parts: what is named so belongs to the thing beside it.
PARTS = _words(
    """
    arm armrest back backrest bar base beam blade body border bottom branch brick bristle button cap ceiling center
    centre column core corner cover crown cushion dial disc disk door drawer ear edge end eye face fin finger foot
    footrest frame front grip hand handle head headboard hinge hoof horn hub joint keel key knob layer leaf leg lid
    limb link lintel lip mast mattress middle mouth neck nose nozzle pane panel pedal peg petal pillar pin pipe
    plank plate pole post prop rail railing rim ring riser rod roof root rope rung screen seat segment shade shaft
    sheet shell shoulder side skirt slat sleeve socket sole spike spine spoke spout stalk stand stem step stick
    stopper strap strip strut support surface switch tail tile tip tire tooth top torso trim trunk tube tyre wall
    wheel window wing wire
    """
)
# Nouns of what is made to float or to hang.
AIRBORNE = _words(
    """
    airplane airship angel arrow asteroid atom balloon banner bat bee bird blimp bubble bulb butterfly chandelier
    cloud comet confetti dragon dragonfly drone droplet dust eagle electron fairy feather fire firefly firework fish
    flake flame fly ghost glow halo hanging helicopter jet kite label lamp lantern letter light lightbulb logo
    meteor mist molecule moon mote nebula neutron orb particle pendant petal plane planet proton rain raindrop ray
    rocket satellite seagull sign sky smoke snow snowflake spaceship spark sparkle sprite star steam sun text ufo
    wave
    """
)
_BROAD = 0.3  # of the scene's area: what is that broad and at its bottom is the ground
_SUNK = 0.25  # of a thing's height: what is deeper in another thing is held by it
_VERTICAL = 0.8  # of the normal of a contact between a thing and what it rests on
_MARGIN = 0.02  # of a group's breadth: how far its centre of mass may be beside its support
_ROOTED_MARGIN = 0.15  # the same on the ground, where lamp posts and trees are held by what is not shown
_MAX_DEPTH = 0.25  # of the smaller extent: how deep equal things may be in each other


class Fault(NamedTuple):
    """A body that would fall, or passes through another.

    Attributes
    ----------
    body, other
        The body, and the one that it rests on or passes through; None is the ground.
    amount
        How far its centre of mass is beside its support, or how deep it is in the other, in scene units.
    move
        The translation that would fix it.
    """

    body: int
    other: int | None
    amount: float
    move: tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class _Link:
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


def _is_part(entity: Entity) -> bool:
    """Return whether an entity is a part of the thing that contains it, by its word."""
    cls = find(entity.word)
    return (cls is not None and cls.is_solid) or noun_of(entity.word) in PARTS


def chains_of(root: Entity) -> list[tuple[_Link, ...]]:
    """Return for each primitive below ``root``, in depth-first order, the instances from the root to it."""
    found: list[tuple[_Link, ...]] = []
    number = 0
    stack: list[tuple[Entity, tuple[_Link, ...]]] = [(root, ())]
    while stack:
        entity, above = stack.pop()
        number += 1
        chain = (*above, _Link(number, entity))
        if entity.is_primitive:
            found.append(chain)
        stack.extend((part.car, chain) for part in reversed(entity.children))
    return found


def _are_one_thing(a: Sequence[_Link], b: Sequence[_Link]) -> bool:
    """Return whether two primitives belong to one thing: in what contains both, one of them is a part."""
    level = 0
    while level + 1 < min(len(a), len(b)) and a[level + 1].number == b[level + 1].number:
        level += 1
    first, second = a[level + 1].entity, b[level + 1].entity
    return a[level].entity.word in (first.word, second.word) or _is_part(first) or _is_part(second)  # or recursion


@dataclass(frozen=True, slots=True, eq=False)
class Contacts:
    """Touching pairs of bodies (M, 2): which are of two things, which of these rest on each other, and the depth (M,)
    and direction (M, 3) of each."""

    pairs: IntArray
    apart: npt.NDArray[np.bool_]
    rests: npt.NDArray[np.bool_]
    depth: FloatArray
    along: FloatArray
    thing: IntArray  # (N,) of each body: the thing that it is part of
    group: IntArray  # (N,) of each body: the things that hold each other
    floor: npt.NDArray[np.bool_]  # (N,) whether a body is the ground


def contacts_of(bodies: Bodies, root: Entity) -> Contacts:
    """Return the contacts of the bodies of a frame, and the groups that they join.

    First the parts of each thing are joined, then the things that hold each other because one is set into the other.
    """
    every = chains_of(root)
    chains = [every[row] for row in bodies.row.tolist()]
    pairs = bodies.contacts[0]
    apart = np.array([not _are_one_thing(chains[i], chains[j]) for i, j in pairs.tolist()], bool)
    depth, along = np.zeros(len(pairs)), np.zeros((len(pairs), 3))
    if apart.any():
        depth[apart], along[apart] = depths(bodies.pairs(pairs[apart]))
    thing = clusters(len(bodies), pairs[~apart].tolist())
    low, high = _boxes_of(bodies, thing)
    floor = _is_floor(bodies)
    upright = np.abs(along[:, 1]) >= _VERTICAL
    shallow = np.minimum((high - low)[pairs[:, 0], 1], (high - low)[pairs[:, 1], 1]) * _SUNK
    on_floor = floor[pairs].any(axis=1)
    rests = apart & upright & (depth <= np.where(on_floor, 4.0 * bodies.touch, np.maximum(shallow, 4.0 * bodies.touch)))
    held = apart & upright & ~rests
    group = clusters(len(bodies), pairs[~apart | held].tolist())
    return Contacts(pairs, apart, rests, depth, along, thing, group, floor)


def _boxes_of(bodies: Bodies, group: IntArray) -> tuple[FloatArray, FloatArray]:
    """Return for each body the box (N, 3) of all bodies of its group."""
    low, high = (each.copy() for each in bodies.boxes)
    np.minimum.at(low, group, bodies.boxes[0])
    np.maximum.at(high, group, bodies.boxes[1])
    return low[group], high[group]


def _is_floor(bodies: Bodies) -> npt.NDArray[np.bool_]:
    """Return which bodies (N,) are the ground: broad ones at the bottom of the scene."""
    low, high = bodies.boxes
    if not len(low):
        return np.zeros(0, bool)
    wide = (high.max(axis=0) - low.min(axis=0))[[0, 2]].prod()
    tall = float(high[:, 1].max() - low[:, 1].min())
    found: npt.NDArray[np.bool_] = (high - low)[:, [0, 2]].prod(axis=1) >= _BROAD * wide
    found &= low[:, 1] <= low[:, 1].min() + 0.1 * tall
    return found


# --- balance ---------------------------------------------------------------------------------------------------------


def unstable(bodies: Bodies, contacts: Contacts, ground: float) -> Iterator[Fault]:
    """Yield the rigid groups that rest on something, but beside their centre of mass."""
    low, high = bodies.boxes
    mass, center = _masses(bodies)
    for group in np.unique(contacts.group).tolist():
        members = np.flatnonzero(contacts.group == group)
        resting = contacts.pairs[contacts.rests & (contacts.group[contacts.pairs] == group).any(axis=1)]
        points, under = _support(bodies, members, resting, ground)
        if not len(points) or len(under) == 0:
            continue
        total = mass[members].sum()
        middle = (center[members] * mass[members, None]).sum(axis=0) / total
        beside, nearest = beyond_edge(points, middle[[0, 2]])
        breadth = float((high[members].max(axis=0) - low[members].min(axis=0))[[0, 2]].max())
        rooted = all(each is None or contacts.floor[each] for each in under)
        if beside > max((_ROOTED_MARGIN if rooted else _MARGIN) * breadth, 2.0 * bodies.touch):
            back = nearest - middle[[0, 2]]
            lowest = int(members[np.argmin(low[members, 1])])
            yield Fault(lowest, under[0], beside, (float(back[0]), 0.0, float(back[1])))


def _masses(bodies: Bodies) -> tuple[FloatArray, FloatArray]:
    """Return the volumes (N,) of bodies and their centres of mass (N, 3)."""
    matrices = bodies.solids.matrices
    volume, center = np.zeros(len(bodies)), matrices[:, :, 3].copy()
    scale = np.abs(np.linalg.det(matrices[:, :, :3]))
    for form, ratios, rows in bodies.solids.members():
        volume[rows] = form.volume(ratios) * scale[rows]
        if form.name == "cone":  # a quarter of the way from its base to its apex
            center[rows] -= 0.5 * matrices[rows, :, 1]
    return np.maximum(volume, 1e-12 * scale.max(initial=1.0)), center


def _support(
    bodies: Bodies, members: IntArray, resting: IntArray, ground: float
) -> tuple[FloatArray, list[int | None]]:
    """Return points (K, 2), x and z, whose convex hull supports a group, and the bodies below it; None is the ground.

    No points mean that it rests on nothing.
    """
    points: list[FloatArray] = []
    under: list[int | None] = []
    own = set(members.tolist())
    low, high = bodies.boxes
    for i in members.tolist():
        if low[i, 1] <= ground + 2.0 * bodies.touch:
            points.append(_lowest(bodies, i)[:, [0, 2]])
            under.append(None)
    for i, j in resting.tolist():
        above, below = (i, j) if i in own else (j, i)
        if low[above, 1] + high[above, 1] < low[below, 1] + high[below, 1]:
            continue  # it carries the other
        foot, floor = _lowest(bodies, above), _lowest(bodies, below, -1.0)
        first = np.maximum(foot.min(axis=0), floor.min(axis=0))[[0, 2]]
        last = np.minimum(foot.max(axis=0), floor.max(axis=0))[[0, 2]]
        if (first > last + 2.0 * bodies.touch).any():
            first, last = np.maximum(low[above], low[below])[[0, 2]], np.minimum(high[above], high[below])[[0, 2]]
        points.append(np.array([[x, z] for x in (first[0], last[0]) for z in (first[1], last[1])]))
        under.append(below)
    return (np.concatenate(points) if points else np.zeros((0, 2))), under


def _lowest(bodies: Bodies, i: int, down: float = 1.0) -> FloatArray:
    """Return the vertices (K, 3) of a body near its lowest point, or with ``down`` -1 near its highest."""
    form, ratios = bodies.solids.form(i)
    matrix = bodies.solids.matrices[i]
    vertices = form.mesh(32, ratios).vertices @ matrix[:, :3].T + matrix[:, 3]
    height = vertices[:, 1] * down
    found: FloatArray = vertices[height <= height.min() + 2.0 * bodies.touch]
    return found


# --- things that pass through each other -----------------------------------------------------------------------------


def intersecting(bodies: Bodies, contacts: Contacts) -> Iterator[Fault]:
    """Yield pairs of things that pass through each other, the deepest pair of bodies of each.

    Things may be set into each other: a tree into the ground, a candle into a cake, a column into the wall beside it.
    What is reported: equal things that overlap, and a thing that comes out of the other side of another.
    """
    if not len(contacts.pairs):
        return
    low, high = bodies.boxes
    pairs = contacts.pairs
    clear = bodies.opaque & bodies.exact & ~bodies.solids.that_are("is_rounded") & ~contacts.floor
    deep = contacts.apart & (contacts.depth > 4.0 * bodies.touch) & clear[pairs].all(axis=1)
    extent = np.minimum(*(high - low).min(axis=1)[pairs.T])
    worst: dict[tuple[int, int], Fault] = {}
    for row in np.flatnonzero(deep).tolist():
        i, j = pairs[row].tolist()
        same = bodies.words(i) == bodies.words(j) and contacts.depth[row] > _MAX_DEPTH * extent[row]
        if not (same or _pierces(low, high, i, j, bodies.touch) or _pierces(low, high, j, i, bodies.touch)):
            continue
        key = (int(contacts.thing[i]), int(contacts.thing[j]))
        move = contacts.along[row] * contacts.depth[row]
        found = Fault(j, i, float(contacts.depth[row]), (float(move[0]), float(move[1]), float(move[2])))
        if key not in worst or worst[key].amount < found.amount:
            worst[key] = found
    yield from worst.values()


def _pierces(low: FloatArray, high: FloatArray, a: int, b: int, room: float) -> bool:
    """Return whether body ``a`` reaches out of two opposite sides of body ``b``, within its other sides."""
    for axis in range(3):
        others = [each for each in range(3) if each != axis]
        out = low[a, axis] < low[b, axis] - room and high[a, axis] > high[b, axis] + room
        within = ((low[a, others] >= low[b, others] - room) & (high[a, others] <= high[b, others] + room)).all()
        if out and within:
            return True
    return False
