"""Geometric checks of one frame: duplicated, floating, sunken or hidden things, and z-fighting faces.

Solids often overlap on purpose: a trunk goes into its crown, a leg into the board, a rock into the ground. An overlap
alone is therefore not reported; the rules below identify what is nearly always a mistake.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import numpy.typing as npt

from scenelang.backends.geometry.stability import (
    Contacts,
    boxes_of_things,
    contacts_of,
    hanging,
    intersecting,
    is_airborne,
    is_mounted,
    is_put_down,
    is_soft,
    may_be_set_in,
    standing_of,
    unstable,
)
from scenelang.backends.surfaces.convex import MAX_PAIRS, Bodies, bodies_of, clusters
from scenelang.backends.surfaces.distance import IntArray, depths, distances
from scenelang.backends.surfaces.marks import Marks
from scenelang.backends.surfaces.solids import FloatArray, PosedForms
from scenelang.grammar.datum import Span
from scenelang.grammar.diagnostics import Diagnostic, Note
from scenelang.interpreter.scene.entity import Entity, Scene, primitive_count
from scenelang.interpreter.scene.primitives import find
from scenelang.interpreter.scene.primitives.mesh import cofactors_of, inverses_of

_SIDES = 32  # of a round solid, for containment tests of its vertices


# --- coplanar faces: the flat faces of posed solids, and the intersection of two of them ---


_DOWN = -0.99


_Face = tuple[FloatArray, FloatArray]


def faces_of(solids: PosedForms, i: int) -> Iterator[_Face]:
    """Yield outward unit normals (3,) and corners (K, 3) of a posed solid's flat faces."""
    matrix = solids.matrices[i]
    cofactors = cofactors_of(matrix[None, :, :3])[0]
    inside_out = np.sign(np.linalg.det(matrix[:, :3]))
    form, ratios = solids.form(i)
    for axis, side, corners in form.flat_faces(ratios):
        normal = cofactors[:, axis] * side * inside_out
        length = np.linalg.norm(normal)
        if length > 0.0:
            yield normal / length, corners @ matrix[:, :3].T + matrix[:, 3]


@dataclass(frozen=True, slots=True, eq=False)
class SharedFace:
    """Overlap of two coplanar faces that face the same way.

    ``area`` of the overlap, its ``share`` of the smaller face, its centre (3,) and the common unit normal (3,).
    """

    area: float
    share: float
    center: FloatArray
    normal: FloatArray


def shared_face(
    faces: Sequence[_Face], others: Sequence[_Face], tolerance: float, least_width: float
) -> SharedFace | None:
    """Return the largest overlap of coplanar ``faces`` and ``others``, in planes closer than ``tolerance``.

    Faces that look straight down and overlaps narrower than ``least_width`` are ignored, since they are rarely visible.
    """
    best: SharedFace | None = None
    for normal, corners in faces:
        if normal[1] < _DOWN:
            continue
        for other_normal, other in others:
            if normal @ other_normal < 1.0 - 1e-6 or abs((other[0] - corners[0]) @ normal) > tolerance:
                continue
            axes = _axes(normal)
            first, second = _counter_clockwise(corners @ axes), _counter_clockwise(other @ axes)
            piece = _clipped(first, second)
            area, smaller = _area(piece), min(_area(first), _area(second))
            if smaller > 0.0 and _width(piece) >= least_width and area > (best.area if best is not None else 0.0):
                center = axes @ piece.mean(axis=0) + normal * (corners[0] @ normal)
                best = SharedFace(area, area / smaller, center, normal)
    return best


def _axes(normal: FloatArray) -> FloatArray:
    """Return two unit vectors perpendicular to ``normal`` as columns (3, 2)."""
    least = np.eye(3)[np.argmin(np.abs(normal))]
    u = np.cross(normal, least)
    u /= np.linalg.norm(u)
    return np.stack([u, np.cross(normal, u)], axis=1)


def _signed(polygon: FloatArray) -> float:
    if not len(polygon):
        return 0.0
    x, y = (polygon - polygon[0]).T  # products of coordinates far from the origin would cancel
    return float((x * np.roll(y, -1) - y * np.roll(x, -1)).sum() / 2.0) if len(polygon) > 2 else 0.0


def _area(polygon: FloatArray) -> float:
    return abs(_signed(polygon))


def _width(polygon: FloatArray) -> float:
    """Return the width of a rectangle of the polygon's area and perimeter, if it is narrow."""
    perimeter = np.linalg.norm(np.roll(polygon, -1, axis=0) - polygon, axis=1).sum() if len(polygon) else 0.0
    return 2.0 * _area(polygon) / float(perimeter) if perimeter > 0.0 else 0.0


def _counter_clockwise(polygon: FloatArray) -> FloatArray:
    return polygon if _signed(polygon) >= 0.0 else polygon[::-1]


def _clipped(subject: FloatArray, clip: FloatArray) -> FloatArray:
    """Return the part of a convex polygon inside another (Sutherland and Hodgman, 1974); both counter-clockwise."""
    for start, end in zip(clip, np.roll(clip, -1, axis=0)):
        edge = end - start
        side = edge[0] * (subject[:, 1] - start[1]) - edge[1] * (subject[:, 0] - start[0])
        inside_points: list[FloatArray] = []
        for k in range(len(subject)):
            here, there = side[k], side[(k + 1) % len(subject)]
            if here >= 0.0:
                inside_points.append(subject[k])
            if (here >= 0.0) != (there >= 0.0):
                inside_points.append(
                    subject[k] + (subject[(k + 1) % len(subject)] - subject[k]) * here / (here - there)
                )
        if not inside_points:
            return np.zeros((0, 2))
        subject = np.array(inside_points)
    return subject


_POSE_TOLERANCE = 1e-6  # pose tolerance relative to the scene's size
_ALMOST = 0.05  # of its least extent: what is moved less against its equal was made twice by mistake
_MAX_OVERLAP = 0.34  # of the smaller extent: siblings with the same word that overlap more are reported
_SUNK = 0.4  # of its height: what is deeper in the ground was probably not raised by mistake
_SUNK_FURNITURE = 0.05  # the same of what a person puts on a floor, by its noun
_SUNK_PEER = 0.02  # the same of a thing whose equals stand on the ground
_SUNK_BALL = 0.75  # rocks, bushes and boats are often half in what carries them
_INLAY = 0.05  # of its breadth: what is flatter is laid into the floor
_BROAD = 0.4  # of the scene's area: a body this broad is the ground
_HOVERING = 2.0  # of its size: what floats higher than that is meant to fly
_FALL = 4.0  # times the nearest gap: what is that near below a thing is what it is to stand on
_PAIRED = 16  # bodies of a cluster, and pairs, whose fall is computed
_APPROACHES = 16
_MET = 0.02  # contact tolerances: gaps that count as none
_MANY = 6  # equal things that float
_JOINT_GAP = 0.05  # of their size: gaps of many equal things, such as tiles, that are meant
_MAX_FLOATING = 0.34  # of all clusters: if more of them float, the scene is in the air
_JOINT = 0.8  # of the outer solid
_OUTSIDE = 1e-3  # of its volume: what has less outside another solid is inside it
_MIN_SHARED = 0.1  # of the smaller face
_MIN_COLOR_DIFFERENCE = 0.08  # linear: z-fighting of stones with slightly different tints is not visible


@dataclass(frozen=True, slots=True)
class Finding:
    """A suspicious configuration.

    ``kind`` is twin, buried, deep, through, unstable, tipping (on an edge), hanging, hovering, sunk or fighting,
    ``body`` its subject, ``other`` the body it is near or in. ``amount`` is a length in scene units, an area for faces,
    ``move`` the translation that would fix it, ``shift`` that of its centre of mass alone, over its foot. ``whole`` if
    a twin is all of a thing.
    """

    kind: str
    body: int
    other: int | None
    amount: float
    move: tuple[float, float, float] | None = None
    shift: tuple[float, float, float] | None = None
    whole: bool = False


_OVERLAPS = ("twin", "buried", "deep", "through")


class CheckedFrame:
    """A frame: its bodies, their contacts, and the findings about them, the gravest first.

    One thing that is in the wrong place has one finding.
    """

    def __init__(self, root: Entity, bodies: Bodies | None = None) -> None:
        self.bodies = bodies_of(root) if bodies is None else bodies
        self.contacts = contacts_of(self.bodies, root)

    @cached_property
    def findings(self) -> list[Finding]:
        return self._ranked(list(_findings(self.bodies, self.contacts))) if len(self.bodies) else []

    def words(self, finding: Finding) -> tuple[str, ...]:
        """Return the words from the root to the subject of a finding, for a twin to the thing that is there twice."""
        bodies = self.bodies
        words = bodies.words(finding.body)
        if finding.whole:
            words = words[:-1]
            for i in np.flatnonzero(self.contacts.thing == self.contacts.thing[finding.body]).tolist():
                words = words[: next((k for k, (a, b) in enumerate(zip(words, bodies.words(i))) if a != b), None)]
        return words

    def concerned(self, finding: Finding) -> IntArray:
        """Return the bodies of the things that a finding is about."""
        named = [finding.body] if finding.other is None else [finding.body, finding.other]
        same = np.isin(self.contacts.thing, self.contacts.thing[named]) | np.isin(
            self.contacts.owner, self.contacts.owner[named]
        )
        return np.flatnonzero(same)

    def marks(self, finding: Finding) -> Marks:
        """Return what a picture of a finding shows: both things, where they touch, and what would carry them."""
        bodies, contacts = self.bodies, self.contacts
        own = np.flatnonzero(contacts.thing == contacts.thing[finding.body])
        other = np.zeros(0, np.int64)
        if finding.other is not None:
            other = np.setdiff1d(np.flatnonzero(contacts.thing == contacts.thing[finding.other]), own)
        points, lines, centers = np.zeros((0, 3)), np.zeros((0, 2, 3)), np.zeros((0, 3))
        low, high = bodies.boxes
        foot = (low[own].min(axis=0) + high[own].max(axis=0)) / 2.0
        foot[1] = low[own, 1].min()
        if finding.kind in ("unstable", "tipping"):
            points, lines, centers = standing_of(bodies, contacts, finding.body, ground_height(bodies))
        elif finding.kind in ("deep", "through") and finding.other is not None:
            points = bodies.patch(finding.body, finding.other, 0.0)
        elif finding.kind == "hanging" and finding.other is not None:
            points = bodies.patch(finding.other, finding.body, bodies.touch)
        elif finding.move is not None:
            lines = np.array([[foot, foot + finding.move]])
        return Marks(frozenset(bodies.row[own].tolist()), frozenset(bodies.row[other].tolist()), points, lines, centers)

    def _ranked(self, found: list[Finding]) -> list[Finding]:
        """Return one finding for each thing: of those about overlaps, for the thing that is in most of them."""
        thing = self.contacts.thing
        often = self._often(found)
        twins = Counter(
            (int(thing[f.body]), int(thing[f.other])) for f in found if f.kind == "twin" and f.other is not None
        )
        parts = Counter(thing.tolist())
        told: dict[tuple[str, int], Finding] = {}
        moved: set[int] = set()
        for finding in found:
            finding = self._turned(finding, often)
            subject = int(thing[finding.body])
            if finding.kind == "fighting":
                told.setdefault(("fighting", finding.body), finding)
                continue
            other = None if finding.other is None else int(thing[finding.other])
            if finding.kind not in _OVERLAPS and subject in moved:
                continue
            if finding.kind in ("deep", "through") and other in moved and ("deep", other) in told:
                continue
            key = "deep" if finding.kind in ("deep", "through") else finding.kind
            if key == "deep" and any((kind, subject) in told for kind in ("twin", "buried")):
                continue
            if key == "twin" and other is not None and other != subject and twins[subject, other] == parts[subject]:
                told.setdefault((key, parts.total() + subject), replace(finding, whole=parts[subject] > 1))
            elif key == "twin" or key == "buried":
                told.setdefault((key, finding.body), finding)
            elif (key, subject) not in told or told[key, subject].amount < finding.amount:
                told[key, subject] = finding
            moved.add(subject)
        return list(told.values())

    def _often(self, found: Iterable[Finding]) -> Counter[int]:
        """Return in how many overlaps each thing is that it could leave by one translation; else it is in none of its
        own making, such as a sofa with a chair in each side."""
        thing = self.contacts.thing
        moves: dict[int, list[FloatArray]] = {}
        for f in found:
            if f.kind in ("deep", "through") and f.other is not None and f.move is not None:
                moves.setdefault(int(thing[f.body]), []).append(np.array(f.move))
                moves.setdefault(int(thing[f.other]), []).append(-np.array(f.move))
        return Counter({
            number: len(every) if all(a @ b >= 0.0 for a in every for b in every) else 0
            for number, every in moves.items()
        })  # fmt: skip

    def _turned(self, finding: Finding, often: Mapping[int, int]) -> Finding:
        """Return a finding about an overlap with the thing first that is in more of them, or is the smaller."""
        if finding.kind not in ("deep", "through") or finding.other is None or finding.move is None:
            return finding
        thing = self.contacts.thing
        first, second = (often[int(thing[i])] for i in (finding.body, finding.other))
        sizes = [self._size(i) for i in (finding.body, finding.other)]
        if (first, -sizes[0]) >= (second, -sizes[1]):
            return finding
        x, y, z = finding.move
        return replace(finding, body=finding.other, other=finding.body, move=(-x, -y, -z))

    def _size(self, i: int) -> float:
        low, high = self.bodies.boxes
        rows = self.contacts.thing == self.contacts.thing[i]
        return float(np.linalg.norm(high[rows].max(axis=0) - low[rows].min(axis=0)))


def findings(bodies: Bodies, root: Entity) -> list[Finding]:
    """Return the findings about the frame with a root, the gravest first."""
    return CheckedFrame(root, bodies).findings


def _findings(bodies: Bodies, contacts: Contacts) -> Iterator[Finding]:
    """Yield all findings about a frame, kind by kind."""
    pairs = contacts.pairs
    twins = _twins(bodies, contacts, pairs)
    yield from twins
    same = {(f.body, f.other) for f in twins}
    rest = np.array([pair for pair in pairs.tolist() if (pair[1], pair[0]) not in same], np.int64).reshape(-1, 2)
    hidden = _buried(bodies, contacts, rest)
    yield from hidden
    inside = {f.body for f in hidden}
    siblings = list(_deep_siblings(bodies, np.array([p for p in rest.tolist() if inside.isdisjoint(p)]).reshape(-1, 2)))
    yield from siblings
    known = same | {(f.body, f.other) for f in siblings} | {(i, None) for i in inside}
    ground = ground_height(bodies)
    for fault in intersecting(bodies, contacts, ground):
        body, other = fault.body, fault.other
        if known.isdisjoint({(body, other), (other, body), (body, None), (other, None)}):
            yield Finding("through", *fault)
    sunk = list(_below_ground(bodies, contacts))
    yield from (finding for finding, deep in sunk if deep)
    for fault in unstable(bodies, contacts, ground):
        yield Finding("unstable" if fault.shift is not None else "tipping", *fault)
    for fault in hanging(bodies, contacts, ground):
        yield Finding("hanging", *fault)
    yield from (finding for finding, deep in sunk if not deep)  # what is tilted is told so
    yield from _hovering(bodies, pairs)
    yield from _fighting_faces(bodies, rest)


# --- overlaps --------------------------------------------------------------------------------------------------------


def _twins(bodies: Bodies, contacts: Contacts, pairs: IntArray) -> list[Finding]:
    """Return duplicates: equal solids under equal poses, however they were created, and solids of one call that are
    moved a little against each other."""
    a, b = pairs[:, 0], pairs[:, 1]
    first, second = bodies.solids.take(a), bodies.solids.take(b)
    equal = (first.forms == second.forms) & (
        np.abs(first.ratios - second.ratios).max(axis=1, initial=0.0) <= _POSE_TOLERANCE
    )
    equal &= ~bodies.hollow[pairs].any(axis=1) | (bodies.entity[a] == bodies.entity[b])
    near = np.abs(first.matrices - second.matrices).max(axis=(1, 2)) <= _POSE_TOLERANCE * bodies.size
    turned = np.abs(first.matrices - second.matrices)[:, :, :3].max(axis=(1, 2), initial=0.0)
    apart = np.linalg.norm(first.matrices[:, :, 3] - second.matrices[:, :, 3], axis=1)
    low, high = bodies.boxes
    whole = boxes_of_things(bodies, contacts.thing)
    own, of_things = (high - low)[a].min(axis=1), (whole[1] - whole[0])[a].min(axis=1)
    least = np.where(contacts.thing[a] == contacts.thing[b], own, of_things)
    almost = (apart <= _ALMOST * least) & (turned <= _POSE_TOLERANCE * bodies.size)
    almost &= (bodies.entity[a] == bodies.entity[b]) & (bodies.path[a] == bodies.path[b])
    return [Finding("twin", j, i, _extent(bodies, i)) for i, j in pairs[(equal & near) | almost].tolist()]


def _extent(bodies: Bodies, i: int) -> float:
    low, high = bodies.boxes
    return float((high[i] - low[i]).min())


def _buried(bodies: Bodies, contacts: Contacts, pairs: IntArray) -> list[Finding]:
    """Return things all of whose solids are inside an opaque solid, and so never visible.

    A single hidden solid among others, such as a ball in a joint, is normal modelling practice.
    """
    low, high = bodies.boxes
    found: dict[int, Finding] = {}
    for first, second in ((0, 1), (1, 0)):
        inner, outer = pairs[:, first], pairs[:, second]
        room = 1e-4 * bodies.size
        boxed = ((low[inner] >= low[outer] - room) & (high[inner] <= high[outer] + room)).all(axis=1)
        for i, o in pairs[boxed & bodies.opaque[outer]][:, [first, second]].tolist():
            if i not in found and _is_inside(bodies, i, o):
                found[i] = Finding("buried", i, o, _extent(bodies, i))
    owner = contacts.owner
    parts = Counter(owner.tolist())
    hidden = Counter(owner[list(found)].tolist())
    return [
        f for i, f in found.items()
        if hidden[owner[i]] == parts[owner[i]] or _is_deep_sibling(bodies, i, f.other)
    ]  # fmt: skip


def _is_deep_sibling(bodies: Bodies, i: int, other: int | None) -> bool:
    """Whether a solid is deeper inside another solid of the same thing than a joint requires."""
    assert other is not None
    return bool(bodies.path[i] == bodies.path[other]) and _is_inside(bodies, i, other, _JOINT)


def _is_material(word: str) -> bool:
    """Whether a primitive's word names only a shape, such as "cube"."""
    cls = find(word)
    return cls is not None and cls.is_solid


def _is_inside(bodies: Bodies, inner: int, outer: int, limit: float = 0.995) -> bool:
    """Whether a solid is inside another that is scaled by ``limit`` about its centre."""
    if bodies.hollow[outer]:
        surfaces = bodies.surface(inner), bodies.surface(outer)
        if surfaces[0] is not None and surfaces[1] is not None:
            return bool((surfaces[0] - surfaces[1]).volume() < _OUTSIDE * surfaces[0].volume())
    matrix = bodies.solids.matrices[inner]
    form, ratios = bodies.solids.form(inner)
    return _holds(bodies, outer, form.mesh(_SIDES, ratios).vertices @ matrix[:, :3].T + matrix[:, 3], limit)


def _holds(bodies: Bodies, outer: int, points: FloatArray, limit: float = 1.0) -> bool:
    """Whether all points (K, 3) are inside a solid that is scaled by ``limit`` about its centre."""
    matrix = bodies.solids.matrices[outer]
    local = (points - matrix[:, 3]) @ inverses_of(matrix[None, :, :3])[0].T / limit
    form, ratios = bodies.solids.form(outer)
    return bool(form.contains(local[:, 0], local[:, 1], local[:, 2], ratios).all())


def _deep_siblings(bodies: Bodies, pairs: IntArray) -> Iterator[Finding]:
    """Yield deep overlaps of things with the same word, such as books in a row.

    Round things are exempt: they are usually leaves, clouds, bubbles or limbs.
    """
    chosen = [
        (i, j)
        for i, j in pairs.tolist()
        if bodies.entity[i] == bodies.entity[j] and bodies.paths[bodies.path[i]] == bodies.paths[bodies.path[j]]
        and _is_a_thing(bodies, i) and not bodies.solids.form(i)[0].is_rounded
    ]  # fmt: skip
    if not chosen:
        return
    numbers = np.array(chosen, np.int64)
    depth, along = depths(bodies.pairs(numbers))
    for (i, j), deep, direction in zip(chosen, depth.tolist(), along):
        if deep > _MAX_OVERLAP * min(_extent(bodies, i), _extent(bodies, j)):
            move = tuple(float(x) for x in direction * deep)
            yield Finding("deep", j, i, deep, (move[0], move[1], move[2]))


def _is_a_thing(bodies: Bodies, i: int) -> bool:
    """Whether a body is a thing rather than building material: a word without geometry, or the only solid of a bound
    word."""
    words = bodies.words(i)
    return not _is_material(words[-1]) or (len(words) > 1 and words[-2] in bodies.plain)


def ground_height(bodies: Bodies) -> float:
    """Return the height that the scene stands on: 0 if something stands there, else that of its lowest point."""
    low, _ = bodies.boxes
    return 0.0 if bool((np.abs(low[:, 1]) <= 2.0 * bodies.touch).any()) else float(low[:, 1].min())


# --- floating --------------------------------------------------------------------------------------------------------


def _hovering(bodies: Bodies, pairs: IntArray) -> Iterator[Finding]:
    """Yield clusters of touching solids that are slightly above the ground and separate from everything else."""
    cluster = clusters(len(bodies), pairs.tolist())
    low, _ = bodies.boxes
    ground = ground_height(bodies)
    numbers, sizes = np.unique(cluster, return_counts=True)
    if len(numbers) < 2:
        return
    standing = {int(c) for c in cluster[low[:, 1] <= ground + 2.0 * bodies.touch]}
    if np.count_nonzero(sizes == sizes.max()) == 1:
        standing.add(int(numbers[np.argmax(sizes)]))
    firsts = np.unique(cluster, return_index=True)[1]
    words = {int(c): bodies.words(int(i)) for c, i in zip(numbers, firsts, strict=True)}
    flying = [int(c) for c in numbers if int(c) not in standing and not is_airborne(words[int(c)][1:])]
    kinds, floating = {words[c] for c in (*standing, *flying)}, {words[c] for c in flying}
    if len(floating) > max(1.0, _MAX_FLOATING * len(kinds)):
        return
    often = Counter(words[c] for c in flying)
    for c in flying:
        members = np.flatnonzero(cluster == c)
        for finding in _gap_of(bodies, members, np.flatnonzero(cluster != c), ground):
            size = float((bodies.boxes[1][members].max(axis=0) - bodies.boxes[0][members].min(axis=0)).max())
            if often[words[c]] < _MANY or finding.other is None or finding.amount > _JOINT_GAP * size:
                yield finding


def _gap_of(bodies: Bodies, members: IntArray, others: IntArray, ground: float) -> Iterator[Finding]:
    """Yield the finding about one cluster, if the gap around it is small."""
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
    most = max(min(_FALL * gap, _HOVERING * size), gap)
    drop, upper, lower = (np.inf, i, j) if height < gap else _drop_of(bodies, members, others, most)
    if height < gap or height <= drop < np.inf:
        yield Finding("hovering", i, None, height, (0.0, -height, 0.0))
    elif drop < np.inf and not is_mounted(bodies.words(i)[1:]):
        yield Finding("hovering", upper, lower, drop, (0.0, -drop, 0.0))
    else:
        _, along = depths(bodies.pairs(numbers[best : best + 1]))
        move = along[0] * -gap if np.isfinite(along).all() else along[0]
        yield Finding("hovering", i, j, gap, (-float(move[0]), -float(move[1]), -float(move[2])))


def _drop_of(bodies: Bodies, members: IntArray, others: IntArray, most: float) -> tuple[float, int, int]:
    """Return how far a cluster can fall until one of its bodies meets another body, and these two; infinity if there is
    none within ``most``.

    Each pair approaches by its distance, which is never more than what is left to fall.
    """
    low, high = bodies.boxes
    room = bodies.touch
    lowest = members[np.argsort(low[members, 1], kind="stable")][:_PAIRED]
    above, below = np.repeat(lowest, len(others)), np.tile(others, len(lowest))
    near = ((low[above] <= high[below]) & (high[above] >= low[below]))[:, [0, 2]].all(axis=1)
    fall = low[above, 1] - high[below, 1]
    near &= (low[above, 1] >= low[below, 1]) & (fall <= most)
    order = np.flatnonzero(near)[np.argsort(fall[near], kind="stable")][:_PAIRED]
    if not len(order):
        return np.inf, 0, 0
    pairs = bodies.pairs(np.stack([above[order], below[order]], axis=1))
    dropped, rows = np.maximum(fall[order], 0.0), np.arange(len(order))
    best, which = np.inf, 0
    for _ in range(_APPROACHES):
        near_pairs = pairs.take(rows)
        near_pairs.a.matrices[:, 1, 3] -= dropped[rows]
        gaps = distances(near_pairs)
        met = rows[gaps <= _MET * room]
        if len(met) and dropped[met].min() < best:
            which = int(met[np.argmin(dropped[met])])
            best = float(dropped[which])
        dropped[rows] += gaps
        rows = rows[(gaps > _MET * room) & (dropped[rows] <= min(most, best))]
        if not len(rows):
            break
    return best, int(above[order[which]]), int(below[order[which]])


# --- the ground ------------------------------------------------------------------------------------------------------


def _below_ground(bodies: Bodies, contacts: Contacts) -> Iterator[tuple[Finding, bool]]:
    """Yield things that are in the floor that they stand on, or below y = 0 if the scene stands there, and whether
    they are deep in it."""
    low, high = bodies.boxes
    room = 2.0 * bodies.touch
    names, thing = np.unique(contacts.thing, return_inverse=True)
    bottom, top = np.full(len(names), np.inf), np.full(len(names), -np.inf)
    np.minimum.at(bottom, thing, low[:, 1])
    np.maximum.at(top, thing, high[:, 1])
    hard = np.ones(len(names), bool)
    hard[thing[~bodies.solids.that_are("is_rounded")]] = False  # True: all its bodies are round
    limit = np.where(hard, _SUNK_BALL, _SUNK) * np.maximum(top - bottom, 1e-12)
    lowest = np.lexsort((low[:, 1], thing))[np.searchsorted(np.sort(thing), np.arange(len(names)))]
    below = -low[:, 1] > room
    ground = _ground(bodies, contacts, below)
    own = np.where(bodies.solids.that_are("is_rounded"), _SUNK_BALL, _SUNK) * (high[:, 1] - low[:, 1])
    legs = thing[(-low[:, 1] > np.maximum(own, room)) & (low[:, 1] <= bottom[thing] + room)]
    least = np.minimum(limit, _least_dips(bodies, lowest, bottom, top))
    sunk = (-bottom > np.maximum(least, room)) | np.isin(np.arange(len(names)), legs)
    sunk &= ~np.isin(np.arange(len(names)), thing[ground])
    standing = int(np.count_nonzero((np.abs(bottom) <= room) & ~np.isin(np.arange(len(names)), thing[ground])))
    dips: dict[int, tuple[float, int | None]] = {}
    if standing >= max(int(np.count_nonzero(sunk)), 1):
        dips |= {int(t): (-float(bottom[t]), None) for t in np.flatnonzero(sunk)}
    inside = _in_floors(bodies, contacts, thing, bottom, limit, least)
    dips |= inside
    for t, (dip, floor) in dips.items():
        body = int(lowest[t])
        if t in inside or not _is_beside(bodies, body, ground):
            yield Finding("sunk", body, floor, dip, (0.0, dip, 0.0)), dip > limit[t] or t in legs


def _least_dips(bodies: Bodies, lowest: IntArray, bottom: FloatArray, top: FloatArray) -> FloatArray:
    """Return for each thing, given by its lowest body, how deep in the ground it is a mistake even if it is not deep;
    infinite if only its depth tells.

    So is what a person puts on a floor, and a thing most of whose equals have one level above its own.
    """
    height, found = top - bottom, np.full(len(lowest), np.inf)
    round_ones = bodies.solids.that_are("is_rounded")
    equals: dict[tuple[str, ...], list[int]] = {}
    for t, body in enumerate(lowest.tolist()):
        words = bodies.words(body)
        if len(words) > 2 and not round_ones[body] and not may_be_set_in(words[1:]):
            equals.setdefault(words, []).append(t)
            if is_put_down(words[1:]):
                found[t] = _SUNK_FURNITURE * height[t]
    room = 2.0 * bodies.touch
    for members in equals.values():
        level = float(np.quantile(bottom[members], 0.5, method="higher"))
        at_level = [t for t in members if abs(bottom[t] - level) <= room]
        under = [t for t in members if bottom[t] < level - room]
        if len(members) > 1 and len(at_level) >= len(under):
            found[under] = np.minimum(found[under], _SUNK_PEER * height[under])
    return found


def _in_floors(
    bodies: Bodies, contacts: Contacts, thing: IntArray, bottom: FloatArray, limit: FloatArray, least: FloatArray
) -> dict[int, tuple[float, int | None]]:
    """Return for each thing that is deep in a floor how deep it is, and the floor."""
    found: dict[int, tuple[float, int | None]] = {}
    low, high = bodies.boxes
    flat = contacts.floor & (2.0 * (high - low)[:, 1] < (high - low)[:, [0, 2]].min(axis=1)) & bodies.opaque
    flat &= ~bodies.solids.that_are("is_rounded")  # the top of a hill is not where its side is
    touching = contacts.pairs[contacts.apart & flat[contacts.pairs].any(axis=1)]
    body_of = np.where(flat[touching[:, 1]], touching[:, 0], touching[:, 1])
    floor_of = touching.sum(axis=1) - body_of
    deep = high[floor_of, 1] - bottom[thing[body_of]] > np.maximum(least[thing[body_of]], 2.0 * bodies.touch)
    for body, floor in zip(body_of[deep].tolist(), floor_of[deep].tolist()):
        t, height = int(thing[body]), float(high[floor, 1])
        dip, room = height - float(bottom[t]), float(least[t])
        if is_soft(bodies.words(floor)):
            room = float(limit[t]) * _SUNK_BALL / _SUNK
        flat_thing = float(limit[t]) < _INLAY * float((high - low)[body, [0, 2]].max())
        if contacts.floor[body] or thing[floor] == t or bodies.hollow[floor] or flat_thing:
            continue
        if dip > max(room, 2.0 * bodies.touch) and dip > found.get(t, (0.0, None))[0]:
            found[t] = dip, (None if abs(height) <= bodies.touch else floor)
    return found


def _ground(bodies: Bodies, contacts: Contacts, below: npt.NDArray[np.bool_]) -> npt.NDArray[np.bool_]:
    """Return the ground: broad bodies that reach below 0, and bodies below 0 connected to them, such as a board's
    squares."""
    low, high = bodies.boxes
    room = 2.0 * bodies.touch
    wide = high.max(axis=0) - low.min(axis=0)
    deep = -low[:, 1] > np.maximum(_SUNK * (high[:, 1] - low[:, 1]), room)
    ground: npt.NDArray[np.bool_] = deep & ((high - low)[:, 0] * (high - low)[:, 2] >= _BROAD * wide[0] * wide[2])
    pairs, depth = contacts.pairs, contacts.depth
    under = below & (high[:, 1] <= room)
    level = high[:, 1] >= -room
    joined = (under | ground)[pairs].all(axis=1) & (level[pairs].all(axis=1) | (depth <= 2.0 * room))
    pairs = pairs[joined]
    while True:
        reached = ground.copy()
        reached[pairs[ground[pairs].any(axis=1)]] = True
        if (reached == ground).all():
            return ground
        ground = reached


def _is_beside(bodies: Bodies, i: int, ground: npt.NDArray[np.bool_]) -> bool:
    """Whether a body touches the side of the ground, as the rim of a board does."""
    pairs, _, _ = bodies.contacts
    mine = pairs[(pairs == i).any(axis=1)]
    mine = mine[ground[mine].any(axis=1)]
    if not len(mine):
        return False
    depth, along = depths(bodies.pairs(mine))
    return bool(((depth < 0.25 * _extent(bodies, i)) & (np.abs(along[:, 1]) < 0.5)).any())


# --- coplanar faces --------------------------------------------------------------------------------------------------


def _fighting_faces(bodies: Bodies, pairs: IntArray) -> Iterator[Finding]:
    """Yield visible overlaps of coplanar faces of different colours: which one is in front is undefined
    (z-fighting)."""
    colors = np.abs(bodies.colors[pairs[:, 0]] - bodies.colors[pairs[:, 1]]).max(axis=1)
    flat = (bodies.exact & ~bodies.solids.that_are("is_rounded"))[pairs].all(axis=1)
    opaque = bodies.opaque[pairs].all(axis=1)
    chosen = pairs[flat & opaque & (colors > _MIN_COLOR_DIFFERENCE)]
    faces = {i: list(faces_of(bodies.solids, i)) for i in np.unique(chosen).tolist()}
    for i, j in chosen.tolist():
        shared = shared_face(faces[i], faces[j], 1e-5 * bodies.size, bodies.touch)
        if shared is None or shared.share < _MIN_SHARED:
            continue
        if not _is_covered(bodies, shared, i, j):
            yield Finding("fighting", j, i, shared.area, _out_of(bodies, shared.normal, i, j))


def _out_of(bodies: Bodies, normal: FloatArray, i: int, j: int) -> tuple[float, float, float] | None:
    """Return a translation of a body ``j`` by which the thinner of two bodies stands out of the other along a normal;
    None if they are equally thick, and so coplanar on both sides."""
    thick = [float(np.abs(normal) @ (bodies.boxes[1] - bodies.boxes[0])[k]) for k in (i, j)]
    if abs(thick[0] - thick[1]) <= 1e-5 * bodies.size:
        return None
    move = normal * min(2.0 * bodies.touch, 0.5 * min(thick)) * (1.0 if thick[1] < thick[0] else -1.0)
    return float(move[0]), float(move[1]), float(move[2])


def _is_covered(bodies: Bodies, shared: SharedFace, i: int, j: int) -> bool:
    """Whether a third solid hides the centre of a shared face."""
    low, high = bodies.boxes
    point = shared.center + shared.normal * (1e-4 * bodies.size)
    near = np.flatnonzero(((low <= point) & (high >= point)).all(axis=1))
    return any(k not in (i, j) and bodies.opaque[k] and _holds(bodies, k, point[None]) for k in near.tolist())


# Diagnostics: findings of every frame as warnings at the calls that made the things (``check --geometry``).


MAX_PRIMITIVES = 100_000
_LEAST_FRAMES = 6  # of a film that are checked, however large they are
_MAX_FRAME_PRIMITIVES = 100_000  # of all frames that are checked
_MAX_SHOWN = 20


@dataclass(frozen=True, slots=True)
class _Named:
    """A finding with the words of its subjects, by which equal findings are merged."""

    finding: Finding
    words: tuple[str, ...]
    other: tuple[str, ...]
    place: Span | None
    other_place: Span | None
    frame: int


def marked_finding(scene: Scene) -> tuple[Entity, Marks] | None:
    """Return the root of the first frame with a finding, and the marks of its gravest one; None if there is none."""
    for root in scene.frames:
        if primitive_count(root) <= MAX_PRIMITIVES and (checked := CheckedFrame(root)).findings:
            return root, checked.marks(checked.findings[0])
    return None


def check_geometry(scene: Scene) -> list[Diagnostic]:
    """Return warnings about the geometry of a scene.

    All frames of a film are checked, of a large one a sample; findings in most of them are reported.
    """
    count = len(scene.frames)
    frames = checked_frames(scene)
    found: dict[tuple[str, tuple[str, ...], tuple[str, ...]], list[_Named]] = {}
    remarks: list[Diagnostic] = []
    for number in frames:
        root = scene.frames[number]
        total = primitive_count(root)
        if total > MAX_PRIMITIVES:
            remarks.append(
                _incomplete(f"{total:,} primitives, more than the limit of {MAX_PRIMITIVES:,}", number, count)
            )
            continue
        checked = CheckedFrame(root)
        bodies = checked.bodies
        for finding in checked.findings:
            named = _named(checked, finding, number)
            found.setdefault((finding.kind, named.words, named.other), []).append(named)
        if len(bodies) and not bodies.contacts[2]:
            remarks.append(
                _incomplete(f"more than the limit of {MAX_PAIRS:,} pairs of nearby primitives", number, count)
            )
    lasting = [group for group in found.values() if 2 * len({each.frame for each in group}) > len(frames)]
    shown = [_diagnostic(group, scene.animated) for group in lasting[:_MAX_SHOWN]]
    if len(lasting) > _MAX_SHOWN:
        shown.append(Diagnostic("geometry-limit", f"{len(lasting) - _MAX_SHOWN} more findings are not shown"))
    return [*shown, *remarks[:1]]


def checked_frames(scene: Scene) -> list[int]:
    """Return the numbers of the frames to check, evenly over a film that is too large for all."""
    count = len(scene.frames)
    affordable = _MAX_FRAME_PRIMITIVES // max(primitive_count(scene.root), 1)
    chosen = min(count, max(_LEAST_FRAMES, affordable))
    return sorted({round(i * (count - 1) / max(chosen - 1, 1)) for i in range(chosen)})


def _incomplete(why: str, frame: int, count: int) -> Diagnostic:
    where = f"frame {frame}" if count > 1 else "the scene"
    return Diagnostic("geometry-limit", f"{where} was not checked completely: {why}")


def _named(checked: CheckedFrame, finding: Finding, frame: int) -> _Named:
    bodies, other = checked.bodies, finding.other
    return _Named(
        finding,
        checked.words(finding),
        bodies.words(other) if other is not None else (),
        _place(bodies, finding.body),
        _place(bodies, other) if other is not None else None,
        frame,
    )


def _place(bodies: Bodies, i: int) -> Span | None:
    places = bodies.entities[bodies.entity[i]].call_sites
    return places[0] if places else None


def message_of(checked: CheckedFrame, finding: Finding) -> str:
    """Return the message of a warning about a finding."""
    return _MESSAGES[finding.kind][1](_named(checked, finding, 0))


def _diagnostic(group: Iterable[_Named], animated: bool) -> Diagnostic:
    """Return one warning for equal findings, about the worst one."""
    every = list(group)
    named = max(every, key=lambda each: each.finding.amount)
    finding = named.finding
    frames = {each.frame for each in every}
    times = max(sum(1 for each in every if each.frame == frame) for frame in frames)
    name, describe = _MESSAGES[finding.kind]
    message = describe(named) + (f" ({times} times)" if times > 1 else "")
    if animated:
        message += f" (frame {min(frames)})"
    hint = None
    if finding.move is not None and any(abs(x) > 1e-9 for x in finding.move):
        hint = f"`(translate [{rounded(finding.move, 3)}])` would fix it"
    elif finding.shift is not None:
        hint = f"move the heavy parts by `[{rounded(finding.shift, 3)}]` over the foot, or make the foot broader"
    other = named.other_place
    notes = (Note("the other thing is created here", other),) if other is not None and other != named.place else ()
    return Diagnostic(name, message, named.place, hint, notes)


def rounded(move: Sequence[float], digits: int = 4) -> str:
    """Return the components of a translation as they are written; those that are nothing beside the others are 0."""
    least = 1e-4 * max(abs(x) for x in move)
    return " ".join(f"{x if abs(x) > least else 0.0:.{digits}g}" for x in move)


def _path(words: tuple[str, ...]) -> str:
    """Return the last words of a path, quoted; the rest is obvious from context."""
    return '"' + "/".join(words[-3:]) + '"'


def _twin(named: _Named) -> str:
    return f"{_path(named.words)} occurs twice in the same place"


def _buried_message(named: _Named) -> str:
    return f"{_path(named.words)} is hidden inside {_path(named.other)}"


def _deep(named: _Named) -> str:
    return f"{_path(named.words)} overlaps its neighbour of the same word by {named.finding.amount:.3g}"


def _through(named: _Named) -> str:
    return f"{_path(named.words)} passes through {_path(named.other)}, {named.finding.amount:.3g} deep"


def _unstable(named: _Named) -> str:
    where = f"where it rests on {_path(named.other)}" if named.other else "its foot"
    return f"{_path(named.words)} would fall: its centre of mass is {named.finding.amount:.3g} beside {where}"


def _tipping(named: _Named) -> str:
    on = f" on {_path(named.other)}" if named.other else ""
    return f"{_path(named.words)} would fall: it stands on an edge{on}"


def _hanging(named: _Named) -> str:
    return f"{_path(named.words)} would fall: it hangs below {_path(named.other)}, which does not hold it"


def _hovering_message(named: _Named) -> str:
    amount = f"{named.finding.amount:.3g}"
    if not named.other:
        return f"{_path(named.words)} floats {amount} above the ground"
    return f"{_path(named.words)} floats {amount} from {_path(named.other)}"


def _sunk(named: _Named) -> str:
    ground = f"the top of {_path(named.other)}" if named.other else "the ground, y = 0"
    return f"{_path(named.words)} extends {named.finding.amount:.3g} below {ground}"


def _fighting(named: _Named) -> str:
    return f"a face of {_path(named.words)} is coplanar with one of {_path(named.other)} in another colour (z-fighting)"


_MESSAGES: dict[str, tuple[str, Callable[[_Named], str]]] = {
    "twin": ("overlap", _twin),
    "buried": ("overlap", _buried_message),
    "deep": ("overlap", _deep),
    "through": ("overlap", _through),
    "hovering": ("floating", _hovering_message),
    "unstable": ("unstable", _unstable),
    "tipping": ("unstable", _tipping),
    "hanging": ("unstable", _hanging),
    "sunk": ("below-ground", _sunk),
    "fighting": ("coincident-faces", _fighting),
}
