"""Geometric checks of one frame: duplicate, floating, sunken or hidden objects, and z-fighting faces.

Solids often overlap on purpose: a trunk goes into its crown, a leg into the board, a rock into the ground. An overlap
alone is therefore not reported; the rules below identify configurations that are nearly always mistakes. Measured: 0.4
findings per scene of the corpus and the examples, at most four in one. Shapes are exact; only mesh files are
represented by their boxes, and Minecraft blocks, which replace earlier ones, are skipped.
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
    boxes_of_groups,
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

_ROUND_SIDES = 32  # of a round solid's mesh, for containment tests of its vertices


# --- coplanar faces: the flat faces of posed solids, and the intersection of two of them ---


_DOWNWARD_NORMAL = -0.99  # vertical component of the normal of faces that look down and are rarely visible


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

    Attributes
    ----------
    area
        Area of the overlap, in squared scene units.
    share
        Its fraction of the smaller face.
    center, normal : (3,)
        Its center, and the common unit normal.
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
        if normal[1] < _DOWNWARD_NORMAL:
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
    """Return the signed area of a polygon (K, 2), positive if it is counter-clockwise (shoelace formula)."""
    if not len(polygon):
        return 0.0
    x, y = (polygon - polygon[0]).T  # products of coordinates far from the origin would cancel
    return float((x * np.roll(y, -1) - y * np.roll(x, -1)).sum() / 2.0) if len(polygon) > 2 else 0.0


def _area(polygon: FloatArray) -> float:
    """Return the area of a polygon (K, 2)."""
    return abs(_signed(polygon))


def _width(polygon: FloatArray) -> float:
    """Return the width of a rectangle of the polygon's area and perimeter, if it is narrow."""
    perimeter = np.linalg.norm(np.roll(polygon, -1, axis=0) - polygon, axis=1).sum() if len(polygon) else 0.0
    return 2.0 * _area(polygon) / float(perimeter) if perimeter > 0.0 else 0.0


def _counter_clockwise(polygon: FloatArray) -> FloatArray:
    """Return a polygon (K, 2) in counter-clockwise order."""
    return polygon if _signed(polygon) >= 0.0 else polygon[::-1]


def _clipped(subject: FloatArray, clip: FloatArray) -> FloatArray:
    """Return the part of a convex polygon inside another; both counter-clockwise.

    Source: Sutherland and Hodgman, "Reentrant polygon clipping", CACM 17 (1974).
    """
    for start, end in zip(clip, np.roll(clip, -1, axis=0)):
        edge = end - start
        side = edge[0] * (subject[:, 1] - start[1]) - edge[1] * (subject[:, 0] - start[0])
        inside_points: list[FloatArray] = []
        for k in range(len(subject)):
            distance, next_distance = side[k], side[(k + 1) % len(subject)]
            if distance >= 0.0:
                inside_points.append(subject[k])
            if (distance >= 0.0) != (next_distance >= 0.0):
                inside_points.append(
                    subject[k] + (subject[(k + 1) % len(subject)] - subject[k]) * distance / (distance - next_distance)
                )
        if not inside_points:
            return np.zeros((0, 2))
        subject = np.array(inside_points)
    return subject


_POSE_TOLERANCE = 1e-6  # of the scene's size: equal poses differ by rounding only
_DUPLICATE_OFFSET = 0.05  # of its least extent: a copy that is offset by less is a duplicate, not a neighbor
_MAX_SIBLING_OVERLAP = 0.34  # of the smaller extent: siblings of one word that overlap more are reported
_MAX_SUNK = 0.4  # of its height: an object that is deeper in the ground was probably never raised by half its height
_MAX_SUNK_FURNITURE = 0.05  # the same for objects that are put on a floor, by their noun
_MAX_SUNK_PEER = 0.02  # the same for an object whose equals stand on the ground
_MAX_SUNK_BALL = 0.75  # the same for round bodies: rocks, bushes and boats are often half in the ground
_INLAY_HEIGHT = 0.05  # of its breadth: a flatter object is an inlay of the floor
_GROUND_AREA = 0.4  # of the scene's area: a body this broad is the ground
_MAX_HOVER_HEIGHT = 2.0  # of its size: an object that floats higher is meant to fly
_MAX_FALL_GAPS = 4.0  # times the nearest gap: a body within this distance below an object is its intended support
_MAX_NEAR_BODIES, _MAX_CLUSTER_BODIES = 24, 64  # bodies around and of a cluster whose gaps are measured
_MAX_FALL_PAIRS = 16  # lowest bodies of a cluster, and pairs of these with bodies below, whose fall is computed
_MAX_FALL_STEPS = 16  # steps of a fall, each by the distance that remains
_CONTACT_GAP = 0.02  # of the contact tolerance: smaller gaps count as none
_MIN_TILES = 6  # equal floating objects from which small gaps are meant, as of tiles
_MAX_TILE_GAP = 0.05  # of their size: gaps up to this between many equal objects are joints
_MAX_FLOATING_SHARE = 0.34  # of the kinds of clusters: if more of them float, the whole scene is in the air
_JOINT_SCALE = 0.8  # scale of the outer solid: a part that fits into it is deeper than a joint needs
_MAX_OUTSIDE_SHARE = 1e-3  # of its volume: a solid with less outside another is inside it, up to tessellation
_MIN_FACE_SHARE = 0.1  # of the smaller face: less flickers too little to be seen
_MIN_COLOR_DIFFERENCE = 0.08  # of linear channels: z-fighting of stones with slightly different tints is not visible


@dataclass(frozen=True, slots=True)
class Finding:
    """Suspicious configuration.

    Attributes
    ----------
    kind
        "twin", "buried", "deep", "through", "unstable", "tipping" (on an edge), "hanging", "hovering", "sunk" or
        "fighting".
    body, other
        Its subject, and the body that the subject is near or in.
    amount
        Length in scene units, for faces an area.
    move, shift
        Translation that fixes it, and that of the subject's center of mass alone.
    whole
        Whether a twin is a whole object.
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
    """Frame with its bodies, their contacts and one finding per misplaced object, the gravest first."""

    def __init__(self, root: Entity, bodies: Bodies | None = None) -> None:
        self.bodies = bodies_of(root) if bodies is None else bodies
        self.contacts = contacts_of(self.bodies, root)

    @cached_property
    def findings(self) -> list[Finding]:
        """Findings about the frame, the gravest first."""
        return self._ranked(list(_findings(self.bodies, self.contacts))) if len(self.bodies) else []

    def words(self, finding: Finding) -> tuple[str, ...]:
        """Return the words from the root to the subject of a finding; for a twin, to the duplicated object."""
        bodies = self.bodies
        words = bodies.words(finding.body)
        if finding.whole:
            words = words[:-1]
            for i in np.flatnonzero(self.contacts.object_of == self.contacts.object_of[finding.body]).tolist():
                words = words[: next((k for k, (a, b) in enumerate(zip(words, bodies.words(i))) if a != b), None)]
        return words

    def concerned(self, finding: Finding) -> IntArray:
        """Return the bodies of the objects that a finding is about."""
        named = [finding.body] if finding.other is None else [finding.body, finding.other]
        is_concerned = np.isin(self.contacts.object_of, self.contacts.object_of[named]) | np.isin(
            self.contacts.owner, self.contacts.owner[named]
        )
        return np.flatnonzero(is_concerned)

    def marks(self, finding: Finding) -> Marks:
        """Return the marks of an image of a finding: both objects, their contact and the missing support."""
        bodies, contacts = self.bodies, self.contacts
        subject = np.flatnonzero(contacts.object_of == contacts.object_of[finding.body])
        other = np.zeros(0, np.int64)
        if finding.other is not None:
            other = np.setdiff1d(np.flatnonzero(contacts.object_of == contacts.object_of[finding.other]), subject)
        points, lines, centers = np.zeros((0, 3)), np.zeros((0, 2, 3)), np.zeros((0, 3))
        low, high = bodies.boxes
        foot = (low[subject].min(axis=0) + high[subject].max(axis=0)) / 2.0
        foot[1] = low[subject, 1].min()
        if finding.kind in ("unstable", "tipping"):
            points, lines, centers = standing_of(bodies, contacts, finding.body, ground_height(bodies))
        elif finding.kind in ("deep", "through") and finding.other is not None:
            points = bodies.patch(finding.body, finding.other, 0.0)
        elif finding.kind == "hanging" and finding.other is not None:
            points = bodies.patch(finding.other, finding.body, bodies.touch)
        elif finding.move is not None:
            lines = np.array([[foot, foot + finding.move]])
        return Marks(
            frozenset(bodies.row[subject].tolist()), frozenset(bodies.row[other].tolist()), points, lines, centers
        )

    def _ranked(self, findings: list[Finding]) -> list[Finding]:
        """Return one finding for each object; of overlaps, for the object that is in most of them.

        A later finding about an object that an earlier one moves is omitted, since fixing the first may fix it too.
        """
        object_of = self.contacts.object_of
        overlap_counts = self._overlap_counts(findings)
        twins = Counter(
            (int(object_of[f.body]), int(object_of[f.other]))
            for f in findings
            if f.kind == "twin" and f.other is not None
        )
        parts = Counter(object_of.tolist())
        ranked: dict[tuple[str, int], Finding] = {}
        moved: set[int] = set()
        for finding in findings:
            finding = self._turned(finding, overlap_counts)
            subject = int(object_of[finding.body])
            if finding.kind == "fighting":
                ranked.setdefault(("fighting", finding.body), finding)
                continue
            other = None if finding.other is None else int(object_of[finding.other])
            if finding.kind not in _OVERLAPS and subject in moved:
                continue
            if finding.kind in ("deep", "through") and other in moved and ("deep", other) in ranked:
                continue
            key = "deep" if finding.kind in ("deep", "through") else finding.kind
            if key == "deep" and any((kind, subject) in ranked for kind in ("twin", "buried")):
                continue
            if key == "twin" and other is not None and other != subject and twins[subject, other] == parts[subject]:
                ranked.setdefault((key, parts.total() + subject), replace(finding, whole=parts[subject] > 1))
            elif key == "twin" or key == "buried":
                ranked.setdefault((key, finding.body), finding)
            elif (key, subject) not in ranked or ranked[key, subject].amount < finding.amount:
                ranked[key, subject] = finding
            moved.add(subject)
        return list(ranked.values())

    def _overlap_counts(self, findings: Iterable[Finding]) -> Counter[int]:
        """Return for each object the number of overlaps that one translation of it could resolve.

        It is 0 if the translations contradict each other: a sofa with a chair in each side is not the cause.
        """
        object_of = self.contacts.object_of
        moves: dict[int, list[FloatArray]] = {}
        for f in findings:
            if f.kind in ("deep", "through") and f.other is not None and f.move is not None:
                moves.setdefault(int(object_of[f.body]), []).append(np.array(f.move))
                moves.setdefault(int(object_of[f.other]), []).append(-np.array(f.move))
        return Counter({
            number: len(object_moves) if all(a @ b >= 0.0 for a in object_moves for b in object_moves) else 0
            for number, object_moves in moves.items()
        })  # fmt: skip

    def _turned(self, finding: Finding, overlap_counts: Mapping[int, int]) -> Finding:
        """Return a finding about an overlap with the object in more overlaps, or the smaller one, as subject."""
        if finding.kind not in ("deep", "through") or finding.other is None or finding.move is None:
            return finding
        object_of = self.contacts.object_of
        first, second = (overlap_counts[int(object_of[i])] for i in (finding.body, finding.other))
        sizes = [self._size(i) for i in (finding.body, finding.other)]
        if (first, -sizes[0]) >= (second, -sizes[1]):
            return finding
        x, y, z = finding.move
        return replace(finding, body=finding.other, other=finding.body, move=(-x, -y, -z))

    def _size(self, i: int) -> float:
        """Return the diagonal of the object of a body."""
        low, high = self.bodies.boxes
        rows = self.contacts.object_of == self.contacts.object_of[i]
        return float(np.linalg.norm(high[rows].max(axis=0) - low[rows].min(axis=0)))


def findings(bodies: Bodies, root: Entity) -> list[Finding]:
    """Return the findings about the frame with a root, the gravest first."""
    return CheckedFrame(root, bodies).findings


def _findings(bodies: Bodies, contacts: Contacts) -> Iterator[Finding]:
    """Yield all findings about a frame, kind by kind."""
    pairs = contacts.pairs
    twins = _twins(bodies, contacts, pairs)
    yield from twins
    twin_pairs = {(f.body, f.other) for f in twins}
    other_pairs = np.array([pair for pair in pairs.tolist() if (pair[1], pair[0]) not in twin_pairs], np.int64).reshape(
        -1, 2
    )
    hidden = _buried(bodies, contacts, other_pairs)
    yield from hidden
    hidden_bodies = {f.body for f in hidden}
    siblings = list(
        _deep_siblings(
            bodies, np.array([p for p in other_pairs.tolist() if hidden_bodies.isdisjoint(p)]).reshape(-1, 2)
        )
    )
    yield from siblings
    known_pairs = twin_pairs | {(f.body, f.other) for f in siblings} | {(i, None) for i in hidden_bodies}
    ground = ground_height(bodies)
    for fault in intersecting(bodies, contacts, ground):
        body, other = fault.body, fault.other
        if known_pairs.isdisjoint({(body, other), (other, body), (body, None), (other, None)}):
            yield Finding("through", *fault)
    sunk = list(_below_ground(bodies, contacts))
    yield from (finding for finding, deep in sunk if deep)
    for fault in unstable(bodies, contacts, ground):
        yield Finding("unstable" if fault.shift is not None else "tipping", *fault)
    for fault in hanging(bodies, contacts, ground):
        yield Finding("hanging", *fault)
    yield from (finding for finding, deep in sunk if not deep)  # a tilted object is reported as unstable instead
    yield from _hovering(bodies, pairs)
    yield from _fighting_faces(bodies, other_pairs)


# --- overlaps --------------------------------------------------------------------------------------------------------


def _twins(bodies: Bodies, contacts: Contacts, pairs: IntArray) -> list[Finding]:
    """Return duplicates: equal solids under equal poses, and solids of one call with a slight offset.

    Equal solids count however they were created.
    """
    a, b = pairs[:, 0], pairs[:, 1]
    first, second = bodies.solids.take(a), bodies.solids.take(b)
    is_equal = (first.forms == second.forms) & (
        np.abs(first.ratios - second.ratios).max(axis=1, initial=0.0) <= _POSE_TOLERANCE
    )
    is_equal &= ~bodies.hollow[pairs].any(axis=1) | (bodies.entity[a] == bodies.entity[b])
    is_same_pose = np.abs(first.matrices - second.matrices).max(axis=(1, 2)) <= _POSE_TOLERANCE * bodies.size
    turn = np.abs(first.matrices - second.matrices)[:, :, :3].max(axis=(1, 2), initial=0.0)
    offset = np.linalg.norm(first.matrices[:, :, 3] - second.matrices[:, :, 3], axis=1)
    low, high = bodies.boxes
    object_boxes = boxes_of_groups(bodies, contacts.object_of)
    body_side, object_side = (high - low)[a].min(axis=1), (object_boxes[1] - object_boxes[0])[a].min(axis=1)
    least_side = np.where(contacts.object_of[a] == contacts.object_of[b], body_side, object_side)
    is_offset_copy = (offset <= _DUPLICATE_OFFSET * least_side) & (turn <= _POSE_TOLERANCE * bodies.size)
    is_offset_copy &= (bodies.entity[a] == bodies.entity[b]) & (bodies.path[a] == bodies.path[b])
    return [
        Finding("twin", j, i, _extent(bodies, i)) for i, j in pairs[(is_equal & is_same_pose) | is_offset_copy].tolist()
    ]


def _extent(bodies: Bodies, i: int) -> float:
    """Return the least side of a body's box."""
    low, high = bodies.boxes
    return float((high[i] - low[i]).min())


def _buried(bodies: Bodies, contacts: Contacts, pairs: IntArray) -> list[Finding]:
    """Return objects whose solids are all inside an opaque solid, and so never visible.

    A single hidden solid among others, such as a ball in a joint, is normal modeling practice.
    """
    low, high = bodies.boxes
    buried: dict[int, Finding] = {}
    for first, second in ((0, 1), (1, 0)):
        inner, outer = pairs[:, first], pairs[:, second]
        tolerance = 1e-4 * bodies.size
        boxed = ((low[inner] >= low[outer] - tolerance) & (high[inner] <= high[outer] + tolerance)).all(axis=1)
        for i, o in pairs[boxed & bodies.opaque[outer]][:, [first, second]].tolist():
            if i not in buried and _is_inside(bodies, i, o):
                buried[i] = Finding("buried", i, o, _extent(bodies, i))
    owner = contacts.owner
    parts = Counter(owner.tolist())
    hidden = Counter(owner[list(buried)].tolist())
    return [
        f for i, f in buried.items()
        if hidden[owner[i]] == parts[owner[i]] or _is_deep_sibling(bodies, i, f.other)
    ]  # fmt: skip


def _is_deep_sibling(bodies: Bodies, i: int, other: int | None) -> bool:
    """Return whether a solid is deeper inside another solid of its object than a joint requires."""
    assert other is not None
    return bool(bodies.path[i] == bodies.path[other]) and _is_inside(bodies, i, other, _JOINT_SCALE)


def _is_material(word: str) -> bool:
    """Return whether a primitive's word names only a shape, such as "cube"."""
    cls = find(word)
    return cls is not None and cls.is_solid


def _is_inside(bodies: Bodies, inner: int, outer: int, limit: float = 0.995) -> bool:
    """Return whether a solid is inside another that is scaled by ``limit`` about its center."""
    if bodies.hollow[outer]:
        surfaces = bodies.surface(inner), bodies.surface(outer)
        if surfaces[0] is not None and surfaces[1] is not None:
            return bool((surfaces[0] - surfaces[1]).volume() < _MAX_OUTSIDE_SHARE * surfaces[0].volume())
    matrix = bodies.solids.matrices[inner]
    form, ratios = bodies.solids.form(inner)
    return _holds(bodies, outer, form.mesh(_ROUND_SIDES, ratios).vertices @ matrix[:, :3].T + matrix[:, 3], limit)


def _holds(bodies: Bodies, outer: int, points: FloatArray, limit: float = 1.0) -> bool:
    """Return whether all points (K, 3) are inside a solid that is scaled by ``limit`` about its center."""
    matrix = bodies.solids.matrices[outer]
    local = (points - matrix[:, 3]) @ inverses_of(matrix[None, :, :3])[0].T / limit
    form, ratios = bodies.solids.form(outer)
    return bool(form.contains(local[:, 0], local[:, 1], local[:, 2], ratios).all())


def _deep_siblings(bodies: Bodies, pairs: IntArray) -> Iterator[Finding]:
    """Yield deep overlaps of objects with the same word, such as books in a row.

    Round objects are exempt: they are usually leaves, clouds, bubbles or limbs.
    """
    chosen = [
        (i, j)
        for i, j in pairs.tolist()
        if bodies.entity[i] == bodies.entity[j] and bodies.paths[bodies.path[i]] == bodies.paths[bodies.path[j]]
        and _is_an_object(bodies, i) and not bodies.solids.form(i)[0].is_rounded
    ]  # fmt: skip
    if not chosen:
        return
    numbers = np.array(chosen, np.int64)
    depth, along = depths(bodies.pairs(numbers))
    for (i, j), deep, direction in zip(chosen, depth.tolist(), along):
        if deep > _MAX_SIBLING_OVERLAP * min(_extent(bodies, i), _extent(bodies, j)):
            move = tuple(float(x) for x in direction * deep)
            yield Finding("deep", j, i, deep, (move[0], move[1], move[2]))


def _is_an_object(bodies: Bodies, i: int) -> bool:
    """Return whether a body is an object rather than building material.

    Its word is not a shape's, or it is the only solid of a bound word.
    """
    words = bodies.words(i)
    return not _is_material(words[-1]) or (len(words) > 1 and words[-2] in bodies.plain)


def ground_height(bodies: Bodies) -> float:
    """Return the height of the ground: 0 if a body stands there, else the lowest point of the scene."""
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
    standing = {int(number) for number in cluster[low[:, 1] <= ground + 2.0 * bodies.touch]}
    if np.count_nonzero(sizes == sizes.max()) == 1:
        standing.add(int(numbers[np.argmax(sizes)]))
    firsts = np.unique(cluster, return_index=True)[1]
    words = {int(number): bodies.words(int(i)) for number, i in zip(numbers, firsts, strict=True)}
    flying = [
        int(number) for number in numbers if int(number) not in standing and not is_airborne(words[int(number)][1:])
    ]
    kinds, floating = {words[number] for number in (*standing, *flying)}, {words[number] for number in flying}
    if len(floating) > max(1.0, _MAX_FLOATING_SHARE * len(kinds)):
        return
    word_counts = Counter(words[number] for number in flying)
    for number in flying:
        members = np.flatnonzero(cluster == number)
        for finding in _gap_of(bodies, members, np.flatnonzero(cluster != number), ground):
            size = float((bodies.boxes[1][members].max(axis=0) - bodies.boxes[0][members].min(axis=0)).max())
            is_tile = word_counts[words[number]] >= _MIN_TILES and finding.other is not None
            if not is_tile or finding.amount > _MAX_TILE_GAP * size:
                yield finding


def _gap_of(bodies: Bodies, members: IntArray, others: IntArray, ground: float) -> Iterator[Finding]:
    """Yield the finding about one floating cluster, if the gap around it is small."""
    low, high = bodies.boxes
    cluster_low, cluster_high = low[members].min(axis=0), high[members].max(axis=0)
    size = float((cluster_high - cluster_low).max())
    apart = np.maximum(np.maximum(low[others] - cluster_high, cluster_low - high[others]), 0.0)
    near = others[np.argsort(np.linalg.norm(apart, axis=1))[:_MAX_NEAR_BODIES]]
    numbers = np.array([(i, j) for i in members[:_MAX_CLUSTER_BODIES].tolist() for j in near.tolist()], np.int64)
    gaps = bodies.gaps(numbers)
    best = int(np.argmin(gaps))
    gap, height = float(gaps[best]), float(cluster_low[1] - ground)
    if min(gap, height) >= _MAX_HOVER_HEIGHT * size:
        return
    i, j = numbers[best].tolist()
    max_drop = max(min(_MAX_FALL_GAPS * gap, _MAX_HOVER_HEIGHT * size), gap)
    drop, upper, lower = (np.inf, i, j) if height < gap else _drop_of(bodies, members, others, max_drop)
    if height < gap or height <= drop < np.inf:
        yield Finding("hovering", i, None, height, (0.0, -height, 0.0))
    elif drop < np.inf and not is_mounted(bodies.words(i)[1:]):
        yield Finding("hovering", upper, lower, drop, (0.0, -drop, 0.0))
    else:
        _, along = depths(bodies.pairs(numbers[best : best + 1]))
        move = along[0] * -gap if np.isfinite(along).all() else along[0]
        yield Finding("hovering", i, j, gap, (-float(move[0]), -float(move[1]), -float(move[2])))


def _drop_of(bodies: Bodies, members: IntArray, others: IntArray, most: float) -> tuple[float, int, int]:
    """Return the fall of a cluster until a body of it meets another body, and these two; infinity if none is near.

    Only bodies within ``most`` below count. Each pair approaches by its distance, which is at most the remaining fall
    (conservative advancement; Mirtich, 1996).
    """
    low, high = bodies.boxes
    tolerance = bodies.touch
    lowest = members[np.argsort(low[members, 1], kind="stable")][:_MAX_FALL_PAIRS]
    above, below = np.repeat(lowest, len(others)), np.tile(others, len(lowest))
    near = ((low[above] <= high[below]) & (high[above] >= low[below]))[:, [0, 2]].all(axis=1)
    fall = low[above, 1] - high[below, 1]
    near &= (low[above, 1] >= low[below, 1]) & (fall <= most)
    order = np.flatnonzero(near)[np.argsort(fall[near], kind="stable")][:_MAX_FALL_PAIRS]
    if not len(order):
        return np.inf, 0, 0
    pairs = bodies.pairs(np.stack([above[order], below[order]], axis=1))
    dropped, rows = np.maximum(fall[order], 0.0), np.arange(len(order))
    best, which = np.inf, 0
    for _ in range(_MAX_FALL_STEPS):
        near_pairs = pairs.take(rows)
        near_pairs.a.matrices[:, 1, 3] -= dropped[rows]
        gaps = distances(near_pairs)
        met = rows[gaps <= _CONTACT_GAP * tolerance]
        if len(met) and dropped[met].min() < best:
            which = int(met[np.argmin(dropped[met])])
            best = float(dropped[which])
        dropped[rows] += gaps
        rows = rows[(gaps > _CONTACT_GAP * tolerance) & (dropped[rows] <= min(most, best))]
        if not len(rows):
            break
    return best, int(above[order[which]]), int(below[order[which]])


# --- the ground ------------------------------------------------------------------------------------------------------


def _below_ground(bodies: Bodies, contacts: Contacts) -> Iterator[tuple[Finding, bool]]:
    """Yield objects that are sunk into their floor or below y = 0, and whether they are deep in it.

    Objects below y = 0 count only if the scene stands there.
    """
    low, high = bodies.boxes
    tolerance = 2.0 * bodies.touch
    names, object_of = np.unique(contacts.object_of, return_inverse=True)
    bottom, top = np.full(len(names), np.inf), np.full(len(names), -np.inf)
    np.minimum.at(bottom, object_of, low[:, 1])
    np.maximum.at(top, object_of, high[:, 1])
    hard = np.ones(len(names), bool)
    hard[object_of[~bodies.solids.that_are("is_rounded")]] = False  # True: all its bodies are round
    limit = np.where(hard, _MAX_SUNK_BALL, _MAX_SUNK) * np.maximum(top - bottom, 1e-12)
    lowest = np.lexsort((low[:, 1], object_of))[np.searchsorted(np.sort(object_of), np.arange(len(names)))]
    below = -low[:, 1] > tolerance
    ground = _ground(bodies, contacts, below)
    own = np.where(bodies.solids.that_are("is_rounded"), _MAX_SUNK_BALL, _MAX_SUNK) * (high[:, 1] - low[:, 1])
    legs = object_of[(-low[:, 1] > np.maximum(own, tolerance)) & (low[:, 1] <= bottom[object_of] + tolerance)]
    least = np.minimum(limit, _least_dips(bodies, lowest, bottom, top))
    sunk = (-bottom > np.maximum(least, tolerance)) | np.isin(np.arange(len(names)), legs)
    sunk &= ~np.isin(np.arange(len(names)), object_of[ground])
    standing = int(np.count_nonzero((np.abs(bottom) <= tolerance) & ~np.isin(np.arange(len(names)), object_of[ground])))
    dips: dict[int, tuple[float, int | None]] = {}
    if standing >= max(int(np.count_nonzero(sunk)), 1):
        dips |= {int(t): (-float(bottom[t]), None) for t in np.flatnonzero(sunk)}
    inside = _in_floors(bodies, contacts, object_of, bottom, limit, least)
    dips |= inside
    for t, (dip, floor) in dips.items():
        body = int(lowest[t])
        if t in inside or not _is_beside(bodies, body, ground):
            yield Finding("sunk", body, floor, dip, (0.0, dip, 0.0)), dip > limit[t] or t in legs


def _least_dips(bodies: Bodies, lowest: IntArray, bottom: FloatArray, top: FloatArray) -> FloatArray:
    """Return for each object, given by its lowest body, the depth in the ground from which it is a mistake.

    It is finite for objects that are put on a floor, and for objects most of whose equals are on one level above their
    own; for all others, only a large depth is a mistake.
    """
    height, least_dips = top - bottom, np.full(len(lowest), np.inf)
    round_ones = bodies.solids.that_are("is_rounded")
    equals: dict[tuple[str, ...], list[int]] = {}
    for number, body in enumerate(lowest.tolist()):
        words = bodies.words(body)
        if len(words) > 2 and not round_ones[body] and not may_be_set_in(words[1:]):
            equals.setdefault(words, []).append(number)
            if is_put_down(words[1:]):
                least_dips[number] = _MAX_SUNK_FURNITURE * height[number]
    tolerance = 2.0 * bodies.touch
    for members in equals.values():
        level = float(np.quantile(bottom[members], 0.5, method="higher"))
        at_level = [number for number in members if abs(bottom[number] - level) <= tolerance]
        under = [number for number in members if bottom[number] < level - tolerance]
        if len(members) > 1 and len(at_level) >= len(under):
            least_dips[under] = np.minimum(least_dips[under], _MAX_SUNK_PEER * height[under])
    return least_dips


def _in_floors(
    bodies: Bodies, contacts: Contacts, object_of: IntArray, bottom: FloatArray, limit: FloatArray, least: FloatArray
) -> dict[int, tuple[float, int | None]]:
    """Return for each object that is deep in a floor its depth, and the floor."""
    dips: dict[int, tuple[float, int | None]] = {}
    low, high = bodies.boxes
    flat = contacts.floor & (2.0 * (high - low)[:, 1] < (high - low)[:, [0, 2]].min(axis=1)) & bodies.opaque
    flat &= ~bodies.solids.that_are("is_rounded")  # the side of a hill is below its top
    touching = contacts.pairs[contacts.apart & flat[contacts.pairs].any(axis=1)]
    body_of = np.where(flat[touching[:, 1]], touching[:, 0], touching[:, 1])
    floor_of = touching.sum(axis=1) - body_of
    deep = high[floor_of, 1] - bottom[object_of[body_of]] > np.maximum(least[object_of[body_of]], 2.0 * bodies.touch)
    for body, floor in zip(body_of[deep].tolist(), floor_of[deep].tolist()):
        number, height = int(object_of[body]), float(high[floor, 1])
        dip, tolerance = height - float(bottom[number]), float(least[number])
        if is_soft(bodies.words(floor)):
            tolerance = float(limit[number]) * _MAX_SUNK_BALL / _MAX_SUNK
        is_flat = float(limit[number]) < _INLAY_HEIGHT * float((high - low)[body, [0, 2]].max())
        if contacts.floor[body] or object_of[floor] == number or bodies.hollow[floor] or is_flat:
            continue
        if dip > max(tolerance, 2.0 * bodies.touch) and dip > dips.get(number, (0.0, None))[0]:
            dips[number] = dip, (None if abs(height) <= bodies.touch else floor)
    return dips


def _ground(bodies: Bodies, contacts: Contacts, below: npt.NDArray[np.bool_]) -> npt.NDArray[np.bool_]:
    """Return which bodies (N,) are the ground.

    They are broad bodies that reach below 0, and bodies below 0 connected to them, such as a board's squares.
    """
    low, high = bodies.boxes
    tolerance = 2.0 * bodies.touch
    extent = high.max(axis=0) - low.min(axis=0)
    deep = -low[:, 1] > np.maximum(_MAX_SUNK * (high[:, 1] - low[:, 1]), tolerance)
    is_broad = (high - low)[:, 0] * (high - low)[:, 2] >= _GROUND_AREA * extent[0] * extent[2]
    ground: npt.NDArray[np.bool_] = deep & is_broad
    pairs, depth = contacts.pairs, contacts.depth
    under = below & (high[:, 1] <= tolerance)
    level = high[:, 1] >= -tolerance
    is_joined = (under | ground)[pairs].all(axis=1) & (level[pairs].all(axis=1) | (depth <= 2.0 * tolerance))
    pairs = pairs[is_joined]
    while True:
        reached = ground.copy()
        reached[pairs[ground[pairs].any(axis=1)]] = True
        if (reached == ground).all():
            return ground
        ground = reached


def _is_beside(bodies: Bodies, i: int, ground: npt.NDArray[np.bool_]) -> bool:
    """Return whether a body touches the side of the ground, as the rim of a board does."""
    pairs, _, _ = bodies.contacts
    contact_pairs = pairs[(pairs == i).any(axis=1)]
    contact_pairs = contact_pairs[ground[contact_pairs].any(axis=1)]
    if not len(contact_pairs):
        return False
    depth, along = depths(bodies.pairs(contact_pairs))
    return bool(((depth < 0.25 * _extent(bodies, i)) & (np.abs(along[:, 1]) < 0.5)).any())


# --- coplanar faces --------------------------------------------------------------------------------------------------


def _fighting_faces(bodies: Bodies, pairs: IntArray) -> Iterator[Finding]:
    """Yield visible overlaps of coplanar faces of different colors, which z-fight."""
    colors = np.abs(bodies.colors[pairs[:, 0]] - bodies.colors[pairs[:, 1]]).max(axis=1)
    flat = (bodies.exact & ~bodies.solids.that_are("is_rounded"))[pairs].all(axis=1)
    opaque = bodies.opaque[pairs].all(axis=1)
    chosen = pairs[flat & opaque & (colors > _MIN_COLOR_DIFFERENCE)]
    faces = {i: list(faces_of(bodies.solids, i)) for i in np.unique(chosen).tolist()}
    for i, j in chosen.tolist():
        shared = shared_face(faces[i], faces[j], 1e-5 * bodies.size, bodies.touch)
        if shared is None or shared.share < _MIN_FACE_SHARE:
            continue
        if not _is_covered(bodies, shared, i, j):
            yield Finding("fighting", j, i, shared.area, _out_of(bodies, shared.normal, i, j))


def _out_of(bodies: Bodies, normal: FloatArray, i: int, j: int) -> tuple[float, float, float] | None:
    """Return a translation of a body ``j`` after which the thinner of two bodies protrudes along a normal.

    None if they are equally thick, and so coplanar on both sides.
    """
    thick = [float(np.abs(normal) @ (bodies.boxes[1] - bodies.boxes[0])[k]) for k in (i, j)]
    if abs(thick[0] - thick[1]) <= 1e-5 * bodies.size:
        return None
    move = normal * min(2.0 * bodies.touch, 0.5 * min(thick)) * (1.0 if thick[1] < thick[0] else -1.0)
    return float(move[0]), float(move[1]), float(move[2])


def _is_covered(bodies: Bodies, shared: SharedFace, i: int, j: int) -> bool:
    """Return whether a third solid hides the center of a shared face."""
    low, high = bodies.boxes
    point = shared.center + shared.normal * (1e-4 * bodies.size)
    near = np.flatnonzero(((low <= point) & (high >= point)).all(axis=1))
    return any(k not in (i, j) and bodies.opaque[k] and _holds(bodies, k, point[None]) for k in near.tolist())


# Diagnostics: findings of every frame as warnings at the calls that created the objects (``check --geometry``).


MAX_PRIMITIVES = 100_000  # of a frame that is checked
_MIN_CHECKED_FRAMES = 6  # of a video that are checked, however large they are
_MAX_TOTAL_PRIMITIVES = 100_000  # of all checked frames together
_MAX_DIAGNOSTICS = 20  # findings of a report; further ones are counted


@dataclass(frozen=True, slots=True)
class _Named:
    """Finding with the words of its subjects, by which equal findings are merged."""

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

    All frames of a 4D scene are checked, of a large one a sample; findings in most of them are reported.
    """
    count = len(scene.frames)
    frames = checked_frames(scene)
    groups: dict[tuple[str, tuple[str, ...], tuple[str, ...]], list[_Named]] = {}
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
            groups.setdefault((finding.kind, named.words, named.other), []).append(named)
        if len(bodies) and not bodies.contacts[2]:
            remarks.append(
                _incomplete(f"more than the limit of {MAX_PAIRS:,} pairs of nearby primitives", number, count)
            )
    persistent = [group for group in groups.values() if 2 * len({named.frame for named in group}) > len(frames)]
    shown = [_diagnostic(group, animated=scene.animated) for group in persistent[:_MAX_DIAGNOSTICS]]
    if len(persistent) > _MAX_DIAGNOSTICS:
        shown.append(Diagnostic("geometry-limit", f"{len(persistent) - _MAX_DIAGNOSTICS} more findings are not shown"))
    return [*shown, *remarks[:1]]


def checked_frames(scene: Scene) -> list[int]:
    """Return the numbers of the frames to check, spaced evenly in a 4D scene that is too large for all."""
    count = len(scene.frames)
    affordable = _MAX_TOTAL_PRIMITIVES // max(primitive_count(scene.root), 1)
    chosen = min(count, max(_MIN_CHECKED_FRAMES, affordable))
    return sorted({round(i * (count - 1) / max(chosen - 1, 1)) for i in range(chosen)})


def _incomplete(why: str, frame: int, count: int) -> Diagnostic:
    """Return the warning that a frame was not checked completely."""
    where = f"frame {frame}" if count > 1 else "the scene"
    return Diagnostic("geometry-limit", f"{where} was not checked completely: {why}")


def _named(checked: CheckedFrame, finding: Finding, frame: int) -> _Named:
    """Return a finding with the words and source locations of its subjects."""
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
    """Return the source location of a body's first call, None if it is unknown."""
    places = bodies.entities[bodies.entity[i]].call_sites
    return places[0] if places else None


def message_of(checked: CheckedFrame, finding: Finding) -> str:
    """Return the message of a warning about a finding."""
    return _MESSAGES[finding.kind][1](_named(checked, finding, 0))


def _diagnostic(group: Iterable[_Named], *, animated: bool) -> Diagnostic:
    """Return one warning for equal findings, about the gravest one."""
    findings = list(group)
    named = max(findings, key=lambda named: named.finding.amount)
    finding = named.finding
    frames = {named.frame for named in findings}
    times = max(Counter(named.frame for named in findings).values())
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
    """Return the components of a translation as text; components below 1e-4 of the largest are 0."""
    least = 1e-4 * max(abs(x) for x in move)
    return " ".join(f"{x if abs(x) > least else 0.0:.{digits}g}" for x in move)


def _path(words: tuple[str, ...]) -> str:
    """Return the last words of a path, quoted; the rest is obvious from context."""
    return '"' + "/".join(words[-3:]) + '"'


def _twin(named: _Named) -> str:
    """Return the message about a duplicate."""
    return f"{_path(named.words)} occurs twice in the same place"


def _buried_message(named: _Named) -> str:
    """Return the message about a hidden object."""
    return f"{_path(named.words)} is hidden inside {_path(named.other)}"


def _deep(named: _Named) -> str:
    """Return the message about a deep overlap of siblings."""
    return f"{_path(named.words)} overlaps its neighbour of the same word by {named.finding.amount:.3g}"


def _through(named: _Named) -> str:
    """Return the message about objects that pass through each other."""
    return f"{_path(named.words)} passes through {_path(named.other)}, {named.finding.amount:.3g} deep"


def _unstable(named: _Named) -> str:
    """Return the message about an unbalanced object."""
    where = f"where it rests on {_path(named.other)}" if named.other else "its foot"
    return f"{_path(named.words)} would fall: its centre of mass is {named.finding.amount:.3g} beside {where}"


def _tipping(named: _Named) -> str:
    """Return the message about an object on an edge."""
    on = f" on {_path(named.other)}" if named.other else ""
    return f"{_path(named.words)} would fall: it stands on an edge{on}"


def _hanging(named: _Named) -> str:
    """Return the message about a hanging object."""
    return f"{_path(named.words)} would fall: it hangs below {_path(named.other)}, which does not hold it"


def _hovering_message(named: _Named) -> str:
    """Return the message about a floating object."""
    amount = f"{named.finding.amount:.3g}"
    if not named.other:
        return f"{_path(named.words)} floats {amount} above the ground"
    return f"{_path(named.words)} floats {amount} from {_path(named.other)}"


def _sunk(named: _Named) -> str:
    """Return the message about a sunken object."""
    ground = f"the top of {_path(named.other)}" if named.other else "the ground, y = 0"
    return f"{_path(named.words)} extends {named.finding.amount:.3g} below {ground}"


def _fighting(named: _Named) -> str:
    """Return the message about z-fighting faces."""
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
