"""What is probably wrong with one frame: things twice in one place, things that hover, that are below the ground, that
are hidden inside others, and faces that fight for one plane.

Artists let solids overlap on purpose: a trunk goes into its crown, a leg into the board, a rock into the ground. So an
overlap alone is nothing; the rules below name what is nearly always a mistake.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from scenelang.backends.solidity.bodies import Bodies
from scenelang.backends.solidity.distance import depths
from scenelang.backends.solidity.faces import SharedFace, shared_face
from scenelang.backends.solidity.neighbours import IntArray
from scenelang.backends.solids import FloatArray, Form, inverses_of
from scenelang.interpreter.shapes import GEOMETRY

_SAME = 1e-6  # of the scene's size: poses nearer than that are one
_DEEP = 0.34  # of the smaller extent: siblings of one word that go deeper into one another are wrong
_SUNK = 0.4  # of its own height: what goes deeper into the ground was forgotten to be lifted
_SUNK_BALL = 0.75  # rocks and bushes lie half in the ground
_BROAD = 0.4  # of the scene's area: what is as broad as that is the ground
_HOVERING = 2.0  # of its own size: what hovers higher than that is meant to fly
_MOST_FLYING = 0.34  # of all clusters: when more of them fly, the scene is in the air
_JOINT = 0.8  # of the outer solid
_FIGHTING = 0.1  # of the smaller face
_OTHER_COLOR = 0.08  # linear: neighbouring stones of slightly different tints fight unseen


@dataclass(frozen=True, slots=True)
class Finding:
    """``kind``: twin, buried, deep, hovering, sunk or fighting. ``body`` is what it is about, ``other`` what it is near
    or in. ``amount`` is a length in the scene's units (an area for faces), ``move`` the vector that would mend it."""

    kind: str
    body: int
    other: int | None
    amount: float
    move: tuple[float, float, float] | None = None


def findings(bodies: Bodies) -> Iterator[Finding]:
    """Everything suspicious about a frame, kind by kind."""
    if not len(bodies):
        return
    pairs, _, _ = bodies.contacts
    twins = _twins(bodies, pairs)
    yield from twins
    same = {(f.body, f.other) for f in twins}
    rest = np.array([pair for pair in pairs.tolist() if (pair[1], pair[0]) not in same], np.int64).reshape(-1, 2)
    hidden = _buried(bodies, rest)
    yield from hidden
    inside = {f.body for f in hidden}
    yield from _deep_siblings(bodies, np.array([p for p in rest.tolist() if inside.isdisjoint(p)]).reshape(-1, 2))
    yield from _hovering(bodies, pairs)
    yield from _below_ground(bodies)
    yield from _fighting_faces(bodies, rest)


# --- overlaps --------------------------------------------------------------------------------------------------------


def _twins(bodies: Bodies, pairs: IntArray) -> list[Finding]:
    """Equal solids under equal poses, however they came to be: one of them is too many."""
    a, b = pairs[:, 0], pairs[:, 1]
    equal = bodies.forms[a] == bodies.forms[b]
    near = np.abs(bodies.matrices[a] - bodies.matrices[b]).max(axis=(1, 2)) <= _SAME * bodies.size
    return [Finding("twin", j, i, _extent(bodies, i)) for i, j in pairs[equal & near].tolist()]


def _extent(bodies: Bodies, i: int) -> float:
    low, high = bodies.boxes
    return float((high[i] - low[i]).min())


def _buried(bodies: Bodies, pairs: IntArray) -> list[Finding]:
    """Things of which every solid lies inside an opaque one, so that nobody ever sees them. One hidden solid among
    others, such as a ball in a joint, is craft."""
    low, high = bodies.boxes
    found: dict[int, Finding] = {}
    for first, second in ((0, 1), (1, 0)):
        inner, outer = pairs[:, first], pairs[:, second]
        room = 1e-4 * bodies.size
        boxed = ((low[inner] >= low[outer] - room) & (high[inner] <= high[outer] + room)).all(axis=1)
        for i, o in pairs[boxed & bodies.opaque[outer]][:, [first, second]].tolist():
            if i not in found and _lies_in(bodies, i, o):
                found[i] = Finding("buried", i, o, _extent(bodies, i))
    things = Counter(_thing(bodies, i) for i in range(len(bodies)))
    hidden = Counter(_thing(bodies, i) for i in found)
    return [
        f for i, f in found.items()
        if hidden[_thing(bodies, i)] == things[_thing(bodies, i)] or _is_deep_sibling(bodies, i, f.other)
    ]  # fmt: skip


def _is_deep_sibling(bodies: Bodies, i: int, other: int | None) -> bool:
    """Whether a solid stands deep inside another one of the same thing: more than a joint needs."""
    assert other is not None
    return bool(bodies.path[i] == bodies.path[other]) and _lies_in(bodies, i, other, _JOINT)


def _thing(bodies: Bodies, i: int) -> tuple[str, ...]:
    """What a body is a part of: the words to its parent, or to itself where its word says what it is."""
    words = bodies.words(i)
    return words[:-1] if words[-1] in GEOMETRY and len(words) > 1 else words


def _lies_in(bodies: Bodies, inner: int, outer: int, limit: float = 0.995) -> bool:
    """Whether a solid lies inside another that is scaled by ``limit`` about its centre."""
    points = (_hull(int(bodies.forms[inner])) @ bodies.matrices[inner, :, :3].T) + bodies.matrices[inner, :, 3]
    return _holds(bodies, outer, points, limit)


def _holds(bodies: Bodies, outer: int, points: FloatArray, limit: float = 1.0) -> bool:
    """Whether all points (K, 3) lie in a solid that is scaled by ``limit`` about its centre."""
    linear = inverses_of(bodies.matrices[outer : outer + 1, :, :3])[0]
    local = (points - bodies.matrices[outer, :, 3]) @ linear.T
    form = bodies.forms[outer]
    if form == Form.BLOCK:
        return bool((np.abs(local) <= limit).all())
    if form == Form.BALL:
        return bool((np.linalg.norm(local, axis=1) <= limit).all())
    across = np.hypot(local[:, 0], local[:, 2])
    edge = limit if form == Form.CYLINDER else limit * (1.0 - local[:, 1]) / 2.0
    return bool(((across <= edge) & (np.abs(local[:, 1]) <= limit)).all())


def _hull(form: int) -> FloatArray:
    """Points of a canonical solid's surface, close enough to tell what holds it."""
    turn = np.linspace(0.0, 2.0 * np.pi, 32, endpoint=False)
    ring = np.stack([np.cos(turn), np.zeros(32), np.sin(turn)], axis=1)
    if form == Form.BLOCK:
        return np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], np.float64)
    if form == Form.BALL:
        heights = np.linspace(-1.0, 1.0, 17)
        return np.concatenate([ring * np.sqrt(1.0 - y * y) + np.array([0.0, y, 0.0]) for y in heights])
    up = np.array([[0.0, 1.0, 0.0]])
    return np.concatenate([ring - up, up if form == Form.CONE else ring + up])


def _deep_siblings(bodies: Bodies, pairs: IntArray) -> Iterator[Finding]:
    """Things of one word, such as books in a row, that go deep into one another. Balls are leaves, clouds, bubbles."""
    chosen = [
        (i, j)
        for i, j in pairs.tolist()
        if bodies.entity[i] == bodies.entity[j] and bodies.paths[bodies.path[i]] == bodies.paths[bodies.path[j]]
        and _is_a_thing(bodies, i) and bodies.forms[i] != Form.BALL
    ]  # fmt: skip
    if not chosen:
        return
    numbers = np.array(chosen, np.int64)
    depth, along = depths(bodies.pairs(numbers))
    for (i, j), deep, way in zip(chosen, depth.tolist(), along):
        if deep > _DEEP * min(_extent(bodies, i), _extent(bodies, j)):
            move = tuple(float(x) for x in way * deep)
            yield Finding("deep", j, i, deep, (move[0], move[1], move[2]))


def _is_a_thing(bodies: Bodies, i: int) -> bool:
    """Whether a body stands for a thing of its own rather than for building material: a word without geometry, or the
    only solid of a word that the program binds."""
    words = bodies.words(i)
    return words[-1] not in GEOMETRY or (len(words) > 1 and words[-2] in bodies.plain)


# --- what hovers -----------------------------------------------------------------------------------------------------


def _hovering(bodies: Bodies, pairs: IntArray) -> Iterator[Finding]:
    """Clusters of touching solids that stand a little off the ground and off all else."""
    cluster = _clusters(len(bodies), pairs)
    low, _ = bodies.boxes
    stands_on_zero = bool((np.abs(low[:, 1]) <= 2.0 * bodies.touch).any())
    ground = 0.0 if stands_on_zero else float(low[:, 1].min())
    numbers, sizes = np.unique(cluster, return_counts=True)
    if len(numbers) < 2:
        return
    standing = {int(c) for c in cluster[low[:, 1] <= ground + 2.0 * bodies.touch]}
    standing.add(int(numbers[np.argmax(sizes)]))
    flying = [int(c) for c in numbers if int(c) not in standing]
    if len(flying) > max(1.0, _MOST_FLYING * len(numbers)):
        return
    for c in flying:
        members = np.flatnonzero(cluster == c)
        yield from _gap_of(bodies, members, np.flatnonzero(cluster != c), ground)


def _clusters(count: int, pairs: IntArray) -> IntArray:
    """A number for each body, equal for those that contact joins."""
    parent = list(range(count))

    def root(i: int) -> int:
        while parent[i] != i:
            parent[i] = parent[parent[i]]
            i = parent[i]
        return i

    for i, j in pairs.tolist():
        parent[root(i)] = root(j)
    return np.array([root(i) for i in range(count)], np.int64)


def _gap_of(bodies: Bodies, members: IntArray, others: IntArray, ground: float) -> Iterator[Finding]:
    """The finding about one cluster, if the gap around it is small."""
    low, high = bodies.boxes
    own_low, own_high = low[members].min(axis=0), high[members].max(axis=0)
    size = float((own_high - own_low).max())
    apart = np.maximum(np.maximum(low[others] - own_high, own_low - high[others]), 0.0)
    near = others[np.argsort(np.linalg.norm(apart, axis=1))[:24]]
    numbers = np.array([(i, j) for i in members[:64].tolist() for j in near.tolist()], np.int64)
    gaps = bodies.gaps(numbers)
    best = int(np.argmin(gaps))
    gap, height = float(gaps[best]), float(own_low[1] - ground)
    if min(gap, height) >= _HOVERING * size:
        return
    i, j = numbers[best].tolist()
    if height < gap:
        yield Finding("hovering", i, None, height, (0.0, -height, 0.0))
    else:
        _, along = depths(bodies.pairs(numbers[best : best + 1]))
        move = along[0] * -gap if np.isfinite(along).all() else along[0]
        yield Finding("hovering", i, j, gap, (-float(move[0]), -float(move[1]), -float(move[2])))


# --- the ground ------------------------------------------------------------------------------------------------------


def _below_ground(bodies: Bodies) -> Iterator[Finding]:
    """Where the scene stands on y = 0: what goes deep below it, and is neither the ground nor beside it."""
    low, high = bodies.boxes
    room = 2.0 * bodies.touch
    tall = np.maximum(high[:, 1] - low[:, 1], 1e-12)
    limit = np.where(bodies.forms == Form.BALL, _SUNK_BALL, _SUNK) * tall
    below = -low[:, 1] > np.maximum(limit, room)
    ground = _ground(bodies, below)
    sunk = np.flatnonzero(below & ~ground)
    if np.count_nonzero((np.abs(low[:, 1]) <= room) & ~ground) < max(len(sunk), 1):
        return  # the scene does not stand on y = 0
    for i in sunk.tolist():
        if not _is_beside(bodies, i, ground):
            dip = float(-low[i, 1])
            yield Finding("sunk", i, None, dip, (0.0, dip, 0.0))


def _ground(bodies: Bodies, below: npt.NDArray[np.bool_]) -> npt.NDArray[np.bool_]:
    """The broad bodies that reach below 0, and what is below with them and touches them, such as a board's squares."""
    low, high = bodies.boxes
    wide = high.max(axis=0) - low.min(axis=0)
    ground: npt.NDArray[np.bool_] = below & ((high - low)[:, 0] * (high - low)[:, 2] >= _BROAD * wide[0] * wide[2])
    pairs, _, _ = bodies.contacts
    under = below & (high[:, 1] <= 2.0 * bodies.touch)
    pairs = pairs[(under | ground)[pairs].all(axis=1)]
    while True:
        reached = ground.copy()
        reached[pairs[ground[pairs].any(axis=1)]] = True
        if (reached == ground).all():
            return ground
        ground = reached


def _is_beside(bodies: Bodies, i: int, ground: npt.NDArray[np.bool_]) -> bool:
    """Whether a body touches the ground at its side, as the rim of a board does."""
    pairs, _, _ = bodies.contacts
    mine = pairs[(pairs == i).any(axis=1)]
    mine = mine[ground[mine].any(axis=1)]
    if not len(mine):
        return False
    depth, along = depths(bodies.pairs(mine))
    return bool(((depth < 0.25 * _extent(bodies, i)) & (np.abs(along[:, 1]) < 0.5)).any())


# --- faces -----------------------------------------------------------------------------------------------------------


def _fighting_faces(bodies: Bodies, pairs: IntArray) -> Iterator[Finding]:
    """Faces of different colours that look the same way in one plane and overlap where they can be seen: no renderer
    can tell which one is in front."""
    colors = np.abs(bodies.colors[pairs[:, 0]] - bodies.colors[pairs[:, 1]]).max(axis=1)
    flat = (bodies.forms[pairs] != Form.BALL).all(axis=1)
    opaque = bodies.opaque[pairs].all(axis=1)
    for i, j in pairs[flat & opaque & (colors > _OTHER_COLOR)].tolist():
        shared = shared_face(bodies.forms, bodies.matrices, i, j, 1e-5 * bodies.size)
        if shared is None or shared.share < _FIGHTING:
            continue
        if not _is_covered(bodies, shared, i, j):
            yield Finding("fighting", j, i, shared.area)


def _is_covered(bodies: Bodies, shared: SharedFace, i: int, j: int) -> bool:
    """Whether a third solid hides the middle of a shared face."""
    low, high = bodies.boxes
    point = shared.center + shared.normal * (1e-4 * bodies.size)
    near = np.flatnonzero(((low <= point) & (high >= point)).all(axis=1))
    return any(k not in (i, j) and bodies.opaque[k] and _holds(bodies, k, point[None]) for k in near.tolist())
