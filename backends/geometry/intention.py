"""What is physically fine but evidently unintended: the one of several siblings that breaks the rule of all others.

No noun decides: words only tell which instances are siblings. A rule must fit all siblings but one, and that one must
miss it by much; what varies at random, grows as a series, or breaks a rule twice is left alone. Places are compared in
the axes of the arrangement, along straight rows (along, beside, height) and along rings (arc, radius, height): in both,
the coordinates of equally spaced siblings are linear in the number of the place, also on stairs and spirals.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations, permutations, product

import numpy as np

from scenelang.backends.facts.frame import FrameFacts
from scenelang.backends.facts.tolerances import PARALLEL, Tolerance
from scenelang.backends.geometry.symmetry import Asymmetry, asymmetries, innermost, unit_columns
from scenelang.backends.surfaces.distance import IntArray
from scenelang.backends.surfaces.solids import FloatArray
from scenelang.interpreter.scene.bounds import entity_box
from scenelang.interpreter.scene.entity import Entity

Vector = tuple[float, float, float]

EXACT = Tolerance(0.01, "of the spacing or size", "places and sizes that a rule computes agree to rounding")
ASTRAY = Tolerance(0.15, "of the spacing or size", "less is a chair that somebody pulled back")
NEARBY = Tolerance(0.75, "of the spacing", "what is farther from its place is somewhere else on purpose")
TURNED = Tolerance(math.radians(10.0), "radians", "less is a chair that somebody pushed")
SAME_TURN = Tolerance(math.radians(1.0), "radians", "turns that a rule computes agree to rounding")
SAME_SLIP = Tolerance(0.005, "radians", "an angle of three digits, times 57.3")
VISIBLE = Tolerance(0.01, "of the object's size", "a turn that moves no outline by more is not seen")
FACING_SPAN = Tolerance(math.radians(60.0), "radians", "what stands on one side of another need not face it")
HINGED = Tolerance(0.35, "of the object's extent", "what turns about its edge is a door or a lid")
STRANGE_SIZE = Tolerance(4.0, "times the others' size", "young and old, small and large are within it")
SHIFTED_DIGIT = Tolerance(0.05, "of the factor", "a factor so close to 10, 100 or 57.3 is a slip")
HALF_SEEN = Tolerance(0.5, "of the siblings", "what is near so many of them is their background")
BESIDE_PARTNER = Tolerance(2.0, "sizes of the part", "a part that lies farther from its partner was put away")

CELL = Tolerance(0.4, "of the spacing", "what stands within it beside an empty place takes the place")
PLAY = Tolerance(0.15, "of the object's extent", "the room of a drawer in its case")
SAME_PLACE = Tolerance(0.05, "of the object's size", "places of parts that are closer are one")
PLUMB = Tolerance(0.98, "vertical component of an axis", "turns about it are turns on the ground")
LARGEST_STEP = Tolerance(0.3, "of the ring", "four places are a ring, and three a triangle")
SURE = Tolerance(0.9, "confidence", "the others leave one place, turn or size, and a slip explains the difference")
LIKELY = Tolerance(0.8, "confidence", "the others leave one place, turn or size")
DOUBTFUL = Tolerance(0.6, "confidence", "a quarter turn, the end of a row or a place at the edge may be meant: a note")

_MIN_SIBLINGS = 4
_MIN_EQUAL = 3  # siblings of which one is larger or smaller by a power of ten or 57.3
_FEW_OF_ONE_SHAPE = 8  # fewer siblings of which one differs in one extent: a digit has up to seven bars, of two shapes
_MAX_SIBLINGS = 1_000  # of a group that are examined
_MAX_GROUPS = 400  # of a frame that are examined
_MAX_PARTS = 20_000  # solids of a group that are compared
_MAX_COMPANIONS = 12  # groups of one home that are compared with each other
_MAX_SUSPECTS = 8  # of a row that are left out in turn
_MAX_SIDES = 200  # solids of an object whose outline is compared
_LIFTS = 2  # levels by which objects that are alone in their parents are looked at together
_DEGREES = 180.0 / math.pi
_TURN_RULES = ("face", "turn evenly", "are parallel", "alternate")  # the more telling ones first
_GRAVITY = ("angle", "loose part", "turn", "height", "spacing", "size", "count", "symmetry")
_MAX_SINGLES = 8  # objects of a home that its siblings may face
_SLIP = "; an angle in degrees was taken for radians, or the reverse"
_SLIPS = (10.0, 100.0, 1000.0, _DEGREES)


@dataclass(frozen=True, slots=True, eq=False)
class Intention:
    """One sibling that breaks the rule of all others.

    Attributes
    ----------
    kind
        "turn", "spacing", "height", "count", "size", "angle", "symmetry" or "loose part".
    instance
        Number of the outlier in the ancestry; of a gap, the sibling before it.
    evidence
        Rest of the message, after the path of the outlier.
    confidence
        From 0 to 1.
    rows
        Solids of the outlier.
    move
        Translation in the world that would put it right.
    turn
        Angle about y that would put it right, in radians.
    counterpart
        Solids of the one that it is compared with; none where all others are evidence.
    """

    kind: str
    instance: int
    evidence: str
    confidence: float
    rows: IntArray
    move: Vector | None = None
    turn: float | None = None
    counterpart: tuple[int, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class _Departure:
    """Sibling that is not at its place, or the sibling before an empty place.

    Attributes
    ----------
    member
        Index in the group.
    place : (3,)
        Where it should be, or the empty place, in the axes of the home.
    spacing
        Distance of neighboring places.
    length
        Distance from its place; 0 for an empty place.
    confidence
        From 0 to 1.
    rule
        What the others form.
    count
        How many others.
    is_slip
        Whether its angle on a ring is in degrees rather than radians, or the reverse.
    together
        How many depart with it: a whole line of a grid.
    """

    member: int
    place: FloatArray
    spacing: float
    length: float
    confidence: float
    rule: str
    count: int
    is_slip: bool = False
    together: int = 1


@dataclass(frozen=True, slots=True, eq=False)
class _OddTurn:
    """Sibling that is turned otherwise than a rule of the others says.

    Attributes
    ----------
    rule
        One of ``_TURN_RULES``.
    member
        Index in the group.
    expected : (3, 3)
        Directions of the axes that it should have.
    chart
        What the others face the center of, None for other rules.
    """

    rule: str
    member: int
    expected: FloatArray
    chart: _Chart | None


def intentions(facts: FrameFacts) -> list[Intention]:
    """Return what is evidently unintended in a frame, the surest first, at most one for each instance.

    Examples
    --------
    >>> [i.kind for i in intentions(FrameFacts(scene.frames[0]))]  # doctest: +SKIP
    ['turn']
    """
    if not len(facts.solids):
        return []
    frame = _Frame(facts)
    groups = _groups(frame)
    every = [intention for group in groups for intention in group.intentions()]
    every += _beside_companions(groups)
    every += [frame.asymmetric(part) for part in asymmetries(facts)]
    every.sort(key=lambda i: (-i.confidence, _GRAVITY.index(i.kind), i.instance))
    kept: list[Intention] = []
    for intention in every:
        if not any(_is_part(intention.rows, other.rows) or _is_part(other.rows, intention.rows) for other in kept):
            kept.append(intention)
    return kept


def _is_shape(entity: Entity) -> bool:
    """Return whether an entity is a primitive that is named after its shape or made by an operation."""
    return entity.shape is not None and not entity.shape.is_semantic


def _is_part(rows: IntArray, others: IntArray) -> bool:
    """Return whether consecutive solids are among others."""
    return bool(rows[0] >= others[0] and rows[-1] <= others[-1])


# --- siblings --------------------------------------------------------------------------------------------------------


class _Frame:
    """Instances of a frame with their solids, boxes and shapes."""

    def __init__(self, facts: FrameFacts) -> None:
        self.facts, self.ancestry = facts, facts.ancestry
        # The half-open range of the solids of every instance, which are in depth-first order.
        self.first, last = self.ancestry.ranges(self.ancestry.primitives[facts.solids.row])
        self.last = last + 1
        self.box_of_node: dict[int, tuple[FloatArray, FloatArray] | None] = {}
        self.parts: dict[int, IntArray] = {}
        self.singles: dict[int, list[int]] = {}

    def rows(self, instance: int) -> IntArray:
        """Return the solids of an instance."""
        return np.arange(self.first[instance], self.last[instance])

    def box(self, instance: int) -> tuple[FloatArray, FloatArray] | None:
        """Return the center and the extents of an instance in its own axes."""
        node = int(self.ancestry.node[instance])
        if node not in self.box_of_node:
            box = entity_box(self.ancestry.nodes[node])
            corners = None if box is None else np.array(box, np.float64).reshape(2, 3)
            self.box_of_node[node] = None if corners is None else (corners.mean(axis=0), corners[1] - corners[0])
        return self.box_of_node[node]

    def part_at(self, depth: int) -> IntArray:
        """Return the ancestor (N,) at a depth of each solid."""
        if depth not in self.parts:
            self.parts[depth] = self.ancestry.at_depth(depth)[self.ancestry.primitives[self.facts.solids.row]]
        return self.parts[depth]

    def center(self, instance: int) -> tuple[FloatArray, FloatArray]:
        """Return the center of the box of an instance in the world, and half its extents."""
        corners, rows = self.facts.solids.boxes, self.rows(instance)
        low, high = corners[0][rows].min(axis=0), corners[1][rows].max(axis=0)
        return (low + high) / 2.0, (high - low) / 2.0

    def asymmetric(self, part: Asymmetry) -> Intention:
        """Return the intention about a part that breaks the symmetry of its body."""
        instance = innermost(self.facts, self.first, self.last, part.rows)
        pair = tuple(part.counterpart.tolist())
        return Intention("symmetry", instance, part.evidence, DOUBTFUL, part.rows, part.move, counterpart=pair)

    def single_objects(self, home: int) -> list[int]:
        """Return the first objects of a home that are alone of their kind."""
        if home not in self.singles:
            children = np.flatnonzero((self.ancestry.parent == home) & (self.last > self.first))
            _, kind, count = np.unique(self.words[children], return_inverse=True, return_counts=True)
            self.singles[home] = children[count[kind.reshape(-1)] == 1][:_MAX_SINGLES].tolist()
        return self.singles[home]

    @cached_property
    def homes(self) -> IntArray:
        """The instance (M,) in which each one's siblings are looked for; of one without any, an ancestor."""
        ancestry, homes = self.ancestry, self.ancestry.parent.copy()
        named = ~np.array([_is_shape(entity) for entity in ancestry.nodes], bool)[ancestry.node]
        for _ in range(_LIFTS):
            _, key, count = np.unique(np.stack([homes, self.words]), axis=1, return_inverse=True, return_counts=True)
            alone = named & (count[key.reshape(-1)] == 1) & (homes > 0)
            homes[alone] = ancestry.parent[homes[alone]]
        return homes

    @cached_property
    def words(self) -> IntArray:
        """Number (M,) of the word of each instance; shapes are told apart by their sizes."""
        numbers: dict[object, int] = {}
        of_node = []
        for entity in self.ancestry.nodes:
            key: object = entity.word
            if _is_shape(entity):
                box = entity_box(entity)
                size = None if box is None else np.subtract(box[3:], box[:3]).tolist()
                key = entity.word, None if size is None else tuple(float(f"{length:.3g}") for length in size)
            of_node.append(numbers.setdefault(key, len(numbers)))
        return np.array(of_node, np.int64)[self.ancestry.node]


def _groups(frame: _Frame) -> list[_Group]:
    """Return the groups of visible siblings of one word; of homes that are one entity, those of the first."""
    visible = np.flatnonzero((frame.last > frame.first) & (frame.ancestry.parent >= 0))
    order = visible[np.lexsort((visible, frame.words[visible], frame.homes[visible]))]
    edges = np.flatnonzero(np.diff(frame.homes[order]) | np.diff(frame.words[order])) + 1
    groups: dict[tuple[int, int], _Group] = {}
    for members in np.split(order, edges):
        if not len(members):
            continue
        home = int(frame.homes[members[0]])
        key = (int(frame.ancestry.node[home]), int(frame.words[members[0]]))
        if home >= 0 and len(members) >= _MIN_EQUAL and key not in groups and len(groups) < _MAX_GROUPS:
            shown = [m for m in members[:_MAX_SIBLINGS].tolist() if frame.box(m) is not None]
            if len(shown) >= _MIN_EQUAL:
                groups[key] = _Group(frame, home, np.array(shown))
    return list(groups.values())


def _beside_companions(groups: Sequence[_Group]) -> Iterator[Intention]:
    """Yield the one of several siblings that is not where all others are beside theirs of another word.

    A lid on each box, a plate before each chair. Of the two that miss each other, that which misses others too is
    wrong, else the smaller one.
    """
    homes: dict[tuple[int, int], list[_Group]] = {}
    for group in groups:
        homes.setdefault((group.home, len(group)), []).append(group)
    for alike in homes.values():
        if not 2 <= len(alike) <= _MAX_COMPANIONS or len(alike[0]) > _MAX_SUSPECTS**2:
            continue
        missed = [(a, b, *miss) for a, b in combinations(alike, 2) if (miss := _missed_companion(a, b)) is not None]
        blame = Counter(int(g.members[k]) for a, b, i, j, _ in missed for g, k in ((a, i), (b, j)))
        for a, b, i, j, length in missed:
            (group, member), (other, _) = sorted(
                ((a, i), (b, j)), key=lambda side: (-blame[int(side[0].members[side[1]])], side[0].size)
            )
            rest = f'{len(a) - 1} of {len(a)} "{group.word}" are beside theirs alike'
            evidence = f'is {length:.3g} from its place beside "{other.word}": {rest}'
            yield group.intention("spacing", member, evidence, DOUBTFUL)
        for group, other in permutations(alike, 2):
            turned = _turned_from_companion(group, other)
            if turned is not None:
                rest = f'{len(group) - 1} of {len(group)} "{group.word}" are turned to theirs alike'
                evidence = f'is turned by {math.degrees(turned[1]):.3g} degrees beside "{other.word}": {rest}'
                yield group.intention("turn", turned[0], evidence, DOUBTFUL)


def _companions(first: _Group, second: _Group) -> tuple[IntArray, FloatArray, FloatArray] | None:
    """Return the nearest sibling (N,) of the second group for each of the first, if they are pairs.

    Further, the offsets (N, 3) to them in the world, and in the axes of the first.
    """
    places, others = (group.places @ group.axes.T + group.zero for group in (first, second))
    apart = np.linalg.norm(places[:, None] - others[None], axis=2)
    match = np.argmin(apart, axis=1)
    if len(np.unique(match)) < len(match) or (np.argmin(apart, axis=0)[match] != np.arange(len(match))).any():
        return None
    offsets = others[match] - places
    return match, offsets, np.einsum("nji,nj->ni", first.axes @ first.turns, offsets)


def _turned_from_companion(group: _Group, other: _Group) -> tuple[int, float] | None:
    """Return the one sibling that is turned otherwise to what is beside it than all others, and the angle.

    A chair with its back to its desk, which stands where it should.
    """
    pairs = _companions(group, other) if len(group) >= _MIN_SIBLINGS else None
    if pairs is None:
        return None
    _, offsets, local = pairs
    away = np.linalg.norm(local - np.median(local, axis=0), axis=1)
    odd = np.flatnonzero(away > EXACT * group.size)
    if len(odd) != 1 or away[odd[0]] < ASTRAY * group.size:
        return None
    if np.ptp(np.linalg.norm(offsets, axis=1)) > EXACT * group.size:  # it is elsewhere, too
        return None
    member = int(odd[0])
    missing = group.turns[(member + 1) % len(group)] @ group.turns[member].T
    angle = _angle(missing)
    return (member, angle) if angle >= TURNED and group._is_seen(member, missing) else None


def _missed_companion(first: _Group, second: _Group) -> tuple[int, int, float] | None:
    """Return the one pair of nearest siblings whose offset is not that of the other pairs, and the difference."""
    pairs = _companions(first, second)
    if pairs is None:
        return None
    match, offsets, local = pairs
    size = min(first.size, second.size)
    for vectors in (offsets, local):
        away = np.linalg.norm(vectors - np.median(vectors, axis=0), axis=1)
        odd = np.flatnonzero(away > EXACT * size)
        if len(odd) == 1 and ASTRAY * size <= away[odd[0]] <= NEARBY * min(first.spacing, second.spacing):
            return int(odd[0]), int(match[odd[0]]), float(away[odd[0]])
        if not len(odd):
            return None
    return None


def _nearest(points: FloatArray) -> tuple[IntArray, FloatArray]:
    """Return for each point the number of the nearest other one, and its distance."""
    distances = np.linalg.norm(points[:, None] - points[None], axis=2)
    np.fill_diagonal(distances, np.inf)
    return np.argmin(distances, axis=1), distances.min(axis=1)


def _common_direction(points: FloatArray, up: int) -> FloatArray:
    """Return the rotation about an axis to the direction of most nearest neighbors, modulo 90 degrees."""
    first, second = ((up + 1) % 3, (up + 2) % 3)
    offsets = points[_nearest(np.delete(points, up, axis=1))[0]] - points
    angles = np.arctan2(offsets[:, second], offsets[:, first]) % (math.pi / 2)
    quarter = np.abs(angles[:, None] - angles[None, :32])
    alike = (np.minimum(quarter, math.pi / 2 - quarter) < 1e-3).sum(axis=0)
    angle = float(angles[np.argmax(alike)])
    rotation = np.eye(3)
    if alike.max() >= HALF_SEEN * len(points) and min(angle, math.pi / 2 - angle) > 1e-3:
        cos, sin = math.cos(angle), math.sin(angle)
        rotation[[first, first, second, second], [first, second, first, second]] = cos, -sin, sin, cos
    return rotation


class _Group:
    """N siblings of one word in one home; coordinates are in the axes of the home.

    Attributes
    ----------
    places, origins : (N, 3)
        Centers of the siblings' own boxes, and the origins of their poses.
    turns : (N, 3, 3)
        Directions of their axes.
    sizes : (N, 3)
        Extents along their axes, in scene units.
    """

    def __init__(self, frame: _Frame, home: int, members: IntArray) -> None:
        self.frame, self.home, self.members = frame, home, members
        poses, pose = frame.ancestry.poses[members], frame.ancestry.poses[home]
        self.axes, self.zero = unit_columns(pose[:, :3]), pose[:, 3]
        boxes = [frame.box(int(m)) for m in members]
        centers, sizes = (np.array([box[i] for box in boxes if box is not None]) for i in range(2))
        self.sizes = sizes * np.linalg.norm(poses[:, :, :3], axis=1)
        world = np.einsum("nij,nj->ni", poses[:, :, :3], centers) + poses[:, :, 3]
        rotations = unit_columns(poses[:, :, :3])
        turned = self._turned_inside() if np.ptp(self.sizes, axis=0).max() > EXACT * self.sizes.max() else None
        if turned is not None:
            rotations, world, self.sizes = turned
        elif np.ptp(self.sizes, axis=0).max() > EXACT * self.sizes.max():  # those of various sizes stand at one level
            low = frame.facts.solids.boxes[0][:, 1]
            world[:, 1] = [low[frame.rows(int(m))].min() for m in members]
        self.up = int(np.argmax(np.abs(self.axes[1]))) if np.abs(self.axes[1]).max() > 0.999 else -1
        self.tilt = np.eye(3)  # of the axes in those of the home
        if self.up >= 0:
            self.tilt = _common_direction((world - self.zero) @ self.axes, self.up)
            self.axes = self.axes @ self.tilt
        self.turns = np.einsum("ji,njk->nik", self.axes, rotations)
        self.places = (world - self.zero) @ self.axes
        self.origins = (poses[:, :, 3] - self.zero) @ self.axes
        corners = frame.facts.solids.boxes
        self.heights = np.array([np.ptp([c[frame.rows(int(m)), 1] for c in corners]) for m in members])
        first = frame.ancestry.entity(int(members[0]))
        self.word, self.is_shape = first.word, _is_shape(first)
        self.size = float(np.median(np.linalg.norm(self.sizes, axis=1)))

    def __len__(self) -> int:
        return len(self.members)

    def _turned_inside(self) -> tuple[FloatArray, FloatArray, FloatArray] | None:
        """Return rotations (N, 3, 3), centers and sizes (N, 3) of siblings that are equal but for a pose within them.

        A function that turns its parts by a parameter has no pose of its own: those of its solids tell its turn.
        """
        frame = self.frame
        parts = frame.last[self.members] - frame.first[self.members]
        if len(np.unique(parts)) > 1 or parts.sum() > _MAX_PARTS:
            return None
        rows = frame.first[self.members][:, None] + np.arange(parts[0])
        matrices = frame.facts.solids.solids.matrices[rows]
        lengths = np.linalg.norm(matrices[:, :, :, :3], axis=2)
        if np.ptp(lengths, axis=0).max() > EXACT * lengths.max():
            return None
        largest = int(np.argmax(lengths[0].prod(axis=1)))
        sizes = np.broadcast_to(2.0 * lengths[0, largest], (len(self.members), 3))
        return unit_columns(matrices[:, largest, :, :3]), matrices[:, :, :, 3].mean(axis=1), np.asarray(sizes)

    @cached_property
    def spacing(self) -> float:
        """Usual distance to the nearest sibling."""
        return float(np.median(_nearest(self.places)[1]))

    def intentions(self) -> Iterator[Intention]:
        """Yield what is unintended among the siblings."""
        if self.spacing <= EXACT * self.size or self.spacing <= 0.0:
            return
        if len(self) < _MIN_SIBLINGS:
            yield from self._sized()
            return
        odd = self._odd_turns()
        turned = next((turn for turn in map(self._turn_of, odd) if turn is not None), None)
        if turned is not None:
            yield turned
        else:
            displaced = list(self._displaced({turn.member for turn in odd}))
            yield from displaced or self._mirrored()
            yield from self._loose()
        yield from self._sized()
        yield from self._built()

    def intention(
        self, kind: str, member: int, evidence: str, confidence: float, turn: float | None = None,
        place: FloatArray | None = None,
    ) -> Intention:  # fmt: skip
        """Return an intention about a sibling that belongs at ``place``."""
        instance = int(self.members[member])
        move: Vector | None = None
        if place is not None:
            x, y, z = (self.axes @ (place - self.places[member])).tolist()
            move = (x, y, z)
        return Intention(kind, instance, evidence, confidence, self.frame.rows(instance), move, turn)

    # --- places ------------------------------------------------------------------------------------------------------

    @cached_property
    def levels(self) -> IntArray:
        """Numbers (N, 3) of the distinct coordinates, ascending."""
        return np.stack([_levels(self.places[:, k], EXACT * self.spacing) for k in range(3)], axis=1)

    def _displaced(self, turned: set[int]) -> Iterator[Intention]:
        """Yield the one sibling that is not at its place in a row, ring or grid, or the one empty place.

        Those that only turned about a hinge are at their places.
        """
        departures = list(self._departures())
        moved = [d for d in departures if d.length > 0.0]
        chosen = moved or departures
        if len({d.member for d in chosen if d.confidence >= max(c.confidence for c in chosen)}) != 1:
            return
        best = max(chosen, key=lambda d: d.confidence)
        if best.length and best.member in turned and not best.is_slip:
            return
        if not best.length and self.is_shape:
            yield from self._stand_in(best)
        gap = float(np.linalg.norm(self.places - best.place, axis=1).min())
        if (best.together == 1 and not best.is_slip and self._is_taken(best)) or (
            self._is_drawn(best) if best.length else gap < NEARBY * best.spacing
        ):
            return
        count = best.count
        if not best.length:
            evidence = f'has an empty place beside it: {count} "{self.word}" stand in {best.rule} of {count + 1}'
            yield self.intention("count", best.member, evidence, best.confidence)
            return
        offset = self.axes @ (self.places[best.member] - best.place)
        is_height = abs(offset[1]) >= 0.9 * float(np.linalg.norm(offset))
        how = f"too {'high' if offset[1] > 0 else 'low'}" if is_height else "from its place"
        evidence = f'is {best.length:.3g} {how}: {count} of {count + best.together} "{self.word}" form {best.rule}'
        kind = "angle" if best.is_slip else "height" if is_height else "spacing"
        evidence += _SLIP if best.is_slip else ""
        yield self.intention(kind, best.member, evidence, best.confidence, place=best.place)

    def _stand_in(self, empty: _Departure) -> Iterator[Intention]:
        """Yield the shape of another size that stands in the one place that shapes of equal size leave empty."""
        frame, first = self.frame, self.frame.ancestry.entity(int(self.members[0]))
        near = (frame.ancestry.parent == self.home) & (frame.last - frame.first == 1)
        for instance in np.setdiff1d(np.flatnonzero(near), self.members)[:_MAX_SIBLINGS].tolist():
            box = frame.box(instance)
            if frame.ancestry.entity(instance).word != first.word or box is None:
                continue
            pose = frame.ancestry.poses[instance]
            center, sizes = pose[:, :3] @ box[0] + pose[:, 3], box[1] * np.linalg.norm(pose[:, :3], axis=0)
            offset = np.abs((center - self.zero) @ self.axes - empty.place)
            ratios = np.maximum(sizes, 1e-300) / np.maximum(self.sizes[0], 1e-300)
            other = np.abs(np.log(ratios)) > math.log1p(ASTRAY)
            # One extent differs, and so may the center along it: a picket that is longer stands on the same ground.
            if other.sum() == 1 and (offset > EXACT * self.spacing).sum() <= 1 and offset.max() < empty.spacing:
                ratio = float(ratios[other][0])
                how = f"{max(ratio, 1.0 / ratio):.3g} times as {'large' if ratio > 1.0 else 'small'}"
                evidence = f'is in one extent {how} as the others: {len(self)} "{self.word}" beside it are equal'
                yield Intention("size", instance, evidence, DOUBTFUL, frame.rows(instance))

    def _departures(self) -> Iterator[_Departure]:
        """Yield what departs from grids, rows and rings."""
        yield from self._from_grid()
        yield from self._from_lines()
        frames = [_straight(self.places), *_rings(self.places)]
        seen = np.zeros(len(self), bool)
        for chart in frames:
            whole = _departure(chart, np.arange(len(self)))
            if whole is not None:
                yield whole
            elif chart.fits(np.arange(len(self))):
                return
        if self.up >= 0 and len(self) > _MIN_SIBLINGS:
            yield from self._from_level()
        rows = [row for chart in [*_along_axes(self.places), *frames[1:]] for row in chart.rows(self.spacing)]
        for _, members in rows:
            seen[members] = True
        strays = np.flatnonzero(~seen)
        for chart, members in rows:
            departure = _departure(chart, members) if len(members) > _MIN_SIBLINGS else None
            if departure is not None:
                yield departure
            elif len(strays) == 1 and chart.fits(members):
                departure = _departure(chart, np.append(members, strays), int(strays[0]))
                if departure is not None and departure.confidence < LIKELY and len(members) + 1 < len(self):
                    continue
                if departure is not None:
                    yield departure

    def _from_level(self) -> Iterator[_Departure]:
        """Yield the one hanging sibling that is not at the level of all others."""
        levels = self.levels[:, self.up]
        odd = np.flatnonzero(levels != np.argmax(np.bincount(levels)))
        if len(odd) != 1:
            return
        place = self.places[odd[0]].copy()
        place[self.up] = np.median(self.places[:, self.up])
        length, size = abs(float(self.places[odd[0], self.up] - place[self.up])), float(self.heights[odd[0]])
        if ASTRAY * size <= length <= size and not self._stands(int(odd[0])):
            yield _Departure(int(odd[0]), place, self.spacing, length, DOUBTFUL, "a level", len(self) - 1)

    def _from_grid(self) -> Iterator[_Departure]:
        """Yield the one sibling beside a place of a grid in which all others are, or the one empty place."""
        rare = [np.bincount(self.levels[:, k])[self.levels[:, k]] == 1 for k in range(3)]
        suspects = np.flatnonzero(np.any([r for r in rare if not r.all()] or [np.zeros(len(self), bool)], axis=0))
        departures = []
        for suspect in suspects.tolist()[:_MAX_SUSPECTS]:
            others = np.delete(np.arange(len(self)), suspect)
            empty = self._empty_place(others)
            if empty is None:
                continue
            offset = np.abs(self.places[suspect] - empty[0])
            axis, length = int(np.argmax(offset)), float(np.linalg.norm(offset))
            sole = int((offset > EXACT * self.spacing).sum()) == 1
            along = self.places[others, axis]
            reach = min(_least_gap(along, EXACT * self.spacing), max(self.spacing, float(np.ptp(along))))
            reach = self.spacing if np.ptp(along) <= EXACT * self.spacing else reach
            if ASTRAY * reach <= length <= NEARBY * reach and (sole or len(others) >= 5):
                tidy = _is_even(along, EXACT * self.spacing) + (abs(along.min() + along.max()) < EXACT * reach)
                departure = _Departure(
                    suspect, empty[0], reach, length, SURE if sole else DOUBTFUL, "a grid", len(others)
                )
                departures.append((int(tidy), suspect, departure))
        if 1 <= len(departures) <= 2:  # of two that could be wrong, the other leaves places that are less even
            yield max(departures, key=lambda item: item[:2])[2]
        empty = self._empty_place(np.arange(len(self)))
        if empty is not None and empty[1] and len(self) > 6:
            member = int(np.argmin(np.linalg.norm(self.places - empty[0], axis=1)))
            yield _Departure(member, empty[0], self.spacing, 0.0, empty[1], "a grid", len(self))

    def _from_lines(self) -> Iterator[_Departure]:
        """Yield the one line of a full grid that is not midway between its neighbors, where all other lines are."""
        shape = self.levels.max(axis=0) + 1
        if (shape > 1).sum() < 2 or not len(self) == int(shape.prod()) == len(np.unique(self.levels, axis=0)):
            return
        for axis in np.flatnonzero(shape >= _MIN_SIBLINGS).tolist():
            lines = np.array([self.places[self.levels[:, axis] == level, axis].mean() for level in range(shape[axis])])
            strays = []
            for level in range(1, len(lines) - 1):
                middle = (lines[level - 1] + lines[level + 1]) / 2.0
                fit = np.insert(np.delete(lines, level), level, middle)
                if np.ptp(np.diff(fit)) <= EXACT * abs(fit[1] - fit[0]):
                    strays.append((level, middle, abs(float(fit[1] - fit[0]))))
            if len(strays) != 1:
                continue
            level, middle, step = strays[0]
            length = abs(float(lines[level] - middle))
            if ASTRAY * step <= length <= NEARBY * step:
                line = np.flatnonzero(self.levels[:, axis] == level)
                place = self.places[line[0]].copy()
                place[axis] = middle
                confidence = LIKELY if len(lines) > _MIN_SIBLINGS else DOUBTFUL
                rest = len(self) - len(line)
                yield _Departure(int(line[0]), place, step, length, confidence, "a grid", rest, together=len(line))

    def _empty_place(self, members: IntArray) -> tuple[FloatArray, float] | None:
        """Return the only place of a grid that siblings leave empty, and how surely it is meant to be filled."""
        levels = np.stack([np.unique(self.levels[members, k], return_inverse=True)[1] for k in range(3)], axis=1)
        shape = levels.max(axis=0) + 1
        cells = np.unique(levels @ np.array([shape[1] * shape[2], shape[2], 1]))
        if (shape > 1).sum() < 2 or len(cells) != len(members) or int(shape.prod()) != len(members) + 1:
            return None
        free = int(np.setdiff1d(np.arange(shape.prod()), cells)[0])
        cell = np.array(np.unravel_index(free, tuple(shape.tolist())))
        place = np.array([self.places[members[levels[:, k] == cell[k]][0], k] for k in range(3)])
        at_end = ((cell == 0) | (cell == shape - 1)) & (shape > 1)
        even = all(_is_even(self.places[members, k], EXACT * self.spacing) for k in range(3))
        inner = int((shape > 1).sum() - at_end.sum())
        is_middle = bool((2 * cell == shape - 1).all())  # of merlons around a roof: the rest is symmetric without it
        inner = 0 if is_middle else inner
        return place, (0.0 if not even or not inner else LIKELY if not at_end.any() else DOUBTFUL)

    def _is_taken(self, departure: _Departure) -> bool:
        """Return whether an object stands at an empty place that is not near the siblings' own places."""
        low, high = self.frame.facts.solids.boxes
        own = np.zeros(len(low), bool)
        spans = []
        for member in self.members.tolist():
            rows = self.frame.rows(member)
            own[rows] = True
            spans.append((low[rows].min(axis=0), high[rows].max(axis=0)))
        half = np.median([over - under for under, over in spans], axis=0) / 2.0
        reach = np.maximum(0.95 * half, np.array([CELL, 0.0, CELL]) * departure.spacing)
        places = self.places @ self.axes.T + self.zero
        place = departure.place @ self.axes.T + self.zero
        near = ~own & ((low < place + reach) & (high > place - reach)).all(axis=1)
        others = np.delete(places, departure.member, axis=0)[:32]
        shared = [((low[near] < at + reach) & (high[near] > at - reach)).all(axis=1) for at in others]
        return bool((np.mean(shared, axis=0) < HALF_SEEN).any()) if near.any() else False

    def _stands(self, member: int) -> bool:
        """Return whether a sibling rests on something."""
        facts, rows = self.frame.facts, self.frame.rows(int(self.members[member]))
        low, pairs = facts.solids.boxes[0][rows, 1].min(), facts.contacts.pairs
        inside = np.isin(pairs, rows)
        others = pairs[inside[:, ::-1] & (inside[:, :1] != inside[:, 1:])]
        tops = facts.solids.boxes[1][others, 1]
        return bool((tops <= low + 0.1 * self.heights[member]).any() or low <= facts.ground.height + facts.solids.touch)

    def _is_drawn(self, departure: _Departure) -> bool:
        """Return whether a sibling is drawn out of a case that holds it from two opposite sides, as a drawer."""
        low, high = self.frame.facts.solids.boxes
        rows = self.frame.rows(int(self.members[departure.member]))
        others = np.setdiff1d(np.arange(len(low)), rows)
        offset = np.abs(self.axes @ (departure.place - self.places[departure.member]))
        along = int(np.argmax(offset))
        under, over = low[rows].min(axis=0), high[rows].max(axis=0)
        size = over - under
        if along == 1 or offset[along] > size[along]:
            return False
        for axis in (k for k in range(3) if k != along):
            shared = (low[others] < over - 0.01 * size) & (high[others] > under + 0.01 * size)
            beside = np.delete(shared, axis, axis=1).all(axis=1)
            gaps = under[axis] - high[others, axis], low[others, axis] - over[axis]
            if all((beside & (np.abs(gap) <= PLAY * size[axis])).any() for gap in gaps):
                return True
        return False

    # --- turns -------------------------------------------------------------------------------------------------------

    def _odd_turns(self) -> list[_OddTurn]:
        """Return for each rule of turns that only one sibling breaks, which one it is and how it should be."""
        odd_turns = []
        for rule, backs, chart in self._turn_rules():
            odd, expected = _odd_turn(np.einsum("nij,njk->nik", backs, self.turns), alternate=rule == "alternate")
            if odd is None:
                return []
            if odd >= 0:
                odd_turns.append(_OddTurn(rule, odd, backs[odd].T @ expected, chart))
        return sorted(odd_turns, key=lambda turn: _TURN_RULES.index(turn.rule))

    def _turn_rules(self) -> Iterator[tuple[str, FloatArray, _Chart | None]]:
        """Yield rules of turns: rotations (N, 3, 3) after which all siblings are parallel; frequent rules first."""
        count = len(self)
        still = np.broadcast_to(np.eye(3), (count, 3, 3))
        yield "are parallel", still, None
        if count >= 6:
            yield "alternate", still, None
        for chart in [*_rings(self.places), *self._around_others()]:
            if chart.surrounds and chart.span >= FACING_SPAN:
                yield "face", chart.unturned(), chart
        steps = np.einsum("nij,nkj->nik", self.turns[1:], self.turns[:-1])
        for step in (steps[0], steps[-1], steps[count // 2 - 1]) if count >= 6 else ():
            if _angle(step) > TURNED:
                powers = [np.eye(3)]
                for _ in range(count - 1):
                    powers.append(step.T @ powers[-1])
                yield "turn evenly", np.stack(powers), None

    def _around_others(self) -> Iterator[_Chart]:
        """Yield charts around the centers of the single objects of the home, and around their four sides."""
        normal = [*(k for k in range(3) if k != self.up), self.up]
        for instance in self.frame.single_objects(self.home) if self.up >= 0 else ():
            middle, half_extents = self.frame.center(instance)
            center, half = (middle - self.zero) @ self.axes, half_extents @ np.abs(self.axes)
            word = f'"{self.frame.ancestry.entity(instance).word}"'
            yield replace(_polar(self.places, self.up, center[normal[:2]]), rule=word)
            offsets = (self.places - center)[:, normal[:2]]
            # Quarter turns to the side of the object that a sibling is at: a table is faced across its long sides.
            is_first = np.abs(offsets[:, 0]) - half[normal[0]] > np.abs(offsets[:, 1]) - half[normal[1]]
            angles = np.where(is_first, np.where(offsets[:, 0] > 0, 0.0, 2.0), np.where(offsets[:, 1] > 0, 1.0, 3.0))
            coordinates = np.stack([angles * math.pi / 2.0, np.ones(len(self)), self.places[:, self.up]], axis=1)
            yield _Chart(coordinates, np.eye(3)[normal], word, center[normal[:2]], 1.0)

    def _name_of(self, chart: _Chart) -> str:
        """Return what siblings do that are turned to the center of a chart."""
        assert chart.center is not None
        if chart.rule.startswith('"'):
            return f"face {chart.rule}"
        ground = self.frame.facts.ground.solids
        for instance in self.frame.single_objects(self.home):
            if ground[self.frame.rows(instance)].all():
                continue
            flat = np.delete((self.frame.center(instance)[0] - self.zero) @ self.axes, chart.normal)
            if np.linalg.norm(flat - chart.center) < 0.1 * chart.radius:
                return f'face "{self.frame.ancestry.entity(instance).word}"'
        return "face their center"

    def _turn_of(self, odd: _OddTurn) -> Intention | None:
        """Return an intention about a sibling that is turned; None if that may be meant, or is not seen."""
        member, actual, count = odd.member, self.turns[odd.member], len(self)
        missing = odd.expected @ actual.T
        angle, axis = _angle(missing), self.axes @ _axis(missing)
        if angle < TURNED or np.linalg.det(missing) < 0.0 or not self._is_seen(member, missing):
            return None
        is_slip, is_upright = _is_slip_of_angle(self.tilt @ odd.expected, self.tilt @ actual), abs(axis[1]) > PLUMB
        is_odd = self._is_hinged(member, missing) or not (is_upright or odd.chart) or self._leans(member, actual)
        if not is_slip and is_odd:
            return None
        if not odd.chart and not is_slip and not self._is_regular(member):
            return None
        confidence = SURE if is_slip or odd.rule in ("face", "turn evenly") else LIKELY
        quarters = 2.0 * angle / math.pi
        if odd.rule == "are parallel" and abs(quarters - round(quarters)) < SAME_TURN and not is_slip:
            confidence = DOUBTFUL
        if not is_slip and (count <= _MIN_SIBLINGS or self._is_moved(member)):
            confidence = DOUBTFUL  # three others are little evidence; or somebody pulled the chair back and turned it
        rule = self._name_of(odd.chart) if odd.chart else odd.rule
        evidence = f'is turned by {math.degrees(angle):.3g} degrees: {count - 1} of {count} "{self.word}" {rule}'
        if is_slip:
            evidence += _SLIP
        turn = angle * float(np.sign(axis[1])) if is_upright else None
        return self.intention("angle" if is_slip else "turn", member, evidence, confidence, turn=turn)

    def _is_moved(self, member: int) -> bool:
        """Return whether a sibling alone is out of all rows along an axis in which each other one shares its row."""
        counts = np.stack([np.bincount(self.levels[:, k])[self.levels[:, k]] for k in range(3)], axis=1)
        return bool(((counts[member] == 1) & ((counts == 1).sum(axis=0) == 1)).any())

    def _is_hinged(self, member: int, missing: FloatArray) -> bool:
        """Return whether a sibling was turned about its edge, as a door is."""
        axis = _axis(missing)
        offset = self.places[member] - self.origins[member]
        across = self.sizes[member][np.abs(self.turns[member].T @ axis) < 0.7]
        return bool(np.linalg.norm(offset - offset @ axis * axis) >= HINGED * across.max())

    def _leans(self, member: int, turn: FloatArray) -> bool:
        """Return whether a sibling is tilted and touches something else from the side: a book at its neighbor."""
        facts, rows = self.frame.facts, self.frame.rows(int(self.members[member]))
        up = np.abs((self.axes @ turn)[1])
        if up.max() > PARALLEL:
            return False
        bodies = np.unique(facts.bodies.body[rows]).tolist()
        return any(abs(float(link.normal[1])) < PLUMB for body in bodies for link in facts.statics.of_body[body])

    def _is_seen(self, member: int, missing: FloatArray) -> bool:
        """Return whether a sibling looks otherwise after a rotation about its center."""
        solids = self.frame.facts.solids.solids
        rows = self.frame.rows(int(self.members[member]))[:_MAX_SIDES]
        turn = self.axes @ missing @ self.axes.T
        center = self.places[member] @ self.axes.T + self.zero
        taken, size = solids.take(rows), float(self.sizes[member].max())

        def outline(direction: FloatArray) -> float:
            return float(((taken.support(np.tile(direction, (len(rows), 1))) - center) @ direction).max())

        directions = np.array([d for d in product((-1.0, -0.4, 0.0, 0.4, 1.0), repeat=3) if any(d)])
        directions /= np.linalg.norm(directions, axis=1, keepdims=True)
        return any(abs(outline(d) - outline(turn.T @ d)) > VISIBLE * size for d in directions)

    def _is_regular(self, member: int) -> bool:
        """Return whether a sibling stands in an equally spaced row of at least four, a ring, or a full grid."""
        for points in (self.places, self.origins):
            if np.ptp(points, axis=0).max() <= EXACT * self.spacing:
                continue
            rows = [row for chart in _along_axes(points) for row in chart.rows(self.spacing)]
            rows += [(chart, np.arange(len(self))) for chart in [_straight(points), *_rings(points)]]
            if any(len(row) >= _MIN_SIBLINGS and member in row and chart.fits(row) for chart, row in rows):
                return True
            shape = [len(np.unique(_levels(points[:, k], EXACT * self.spacing))) for k in range(3)]
            if math.prod(shape) == len(self) and min(sorted(shape)[1:]) >= 3:
                return True
        return False

    # --- sizes -------------------------------------------------------------------------------------------------------

    def _sized(self) -> Iterator[Intention]:
        """Yield the one sibling that has another size than all others, which are equal."""
        frame, count = self.frame, len(self)
        parts = frame.last[self.members] - frame.first[self.members]
        if self.is_shape or len(np.unique(parts)) > 1 or parts[0] > _MAX_SIDES:
            return
        rows = frame.first[self.members][:, None] + np.arange(parts[0])
        sides = np.linalg.norm(frame.facts.solids.solids.matrices[rows][:, :, :, :3], axis=2)
        lengths = np.concatenate([self.sizes, sides.reshape(count, -1)], axis=1)
        usual = np.median(lengths, axis=0)
        factors = np.maximum(lengths, 1e-300)[:, usual > 0] / usual[usual > 0]
        odd = np.flatnonzero((np.abs(factors - 1.0) > EXACT).any(axis=1))
        if len(odd) != 1:
            return
        member = int(odd[0])
        factor = float(factors[member, np.argmax(np.abs(np.log(factors[member])))])
        ratio = max(factor, 1.0 / factor)
        is_slip = any(abs(ratio / slip - 1.0) < SHIFTED_DIGIT for slip in _SLIPS)
        is_whole = float(np.ptp(np.log(factors[member]))) < EXACT
        if count < _MIN_SIBLINGS:
            if not (is_whole and any(abs(ratio / slip - 1.0) < EXACT for slip in _SLIPS)):
                return
            confidence = DOUBTFUL
        elif ratio >= STRANGE_SIZE and not is_whole and count < _FEW_OF_ONE_SHAPE:
            confidence = DOUBTFUL  # the bars of a digit are of two lengths
        elif ratio >= STRANGE_SIZE:
            confidence = SURE if is_slip else LIKELY
        elif ratio >= 1.0 + ASTRAY and self._is_regular(member):
            confidence = DOUBTFUL
        else:
            return
        how = f"{ratio:.3g} times as {'large' if factor > 1 else 'small'} as the others"
        evidence = f'is {"" if is_whole else "in one extent "}{how}: {count - 1} of {count} "{self.word}" are equal'
        yield self.intention("size", member, evidence, confidence)

    # --- parts -------------------------------------------------------------------------------------------------------

    def _built(self) -> Iterator[Intention]:
        """Yield the one sibling that has other parts than all others, or has one of them at another place."""
        frame, count = self.frame, len(self)
        parts = frame.last[self.members] - frame.first[self.members]
        if count < _MIN_SIBLINGS or self.is_shape or parts.max() > _MAX_SIDES or parts.sum() > _MAX_PARTS:
            return
        words = [tuple(self._part(int(m), int(row)) for row in frame.rows(int(m))) for m in self.members]
        usual, frequency = Counter(words).most_common(1)[0]
        if frequency == count:
            yield from self._misplaced_parts(int(parts[0]))
        elif frequency == count - 1:
            member = next(i for i, these in enumerate(words) if these != usual)
            differences = Counter(words[member])
            differences.subtract(Counter(usual))
            changed = [(word, number) for word, number in differences.items() if number]
            if len(changed) != 1 or abs(changed[0][1]) > HALF_SEEN * len(usual):
                return
            word = changed[0][0]
            own, others = Counter(words[member])[word], Counter(usual)[word]
            evidence = f'has {own or "no"} "{word}" where {count - 1} of {count} "{self.word}" have {others or "none"}'
            yield self.intention("count", member, evidence, DOUBTFUL)

    def _part(self, instance: int, row: int) -> str:
        """Return the words of a solid below a sibling."""
        words = self.frame.facts.solids.words(row)
        return "/".join(words[int(self.frame.ancestry.depth[instance]) + 1 :]) or words[-1]

    def _misplaced_parts(self, parts: int) -> Iterator[Intention]:
        """Yield the one sibling of which one part is elsewhere, in its own axes, than the same part of all others."""
        frame, count = self.frame, len(self)
        rows = frame.first[self.members][:, None] + np.arange(parts)
        poses = frame.ancestry.poses[self.members]
        inverses = np.linalg.pinv(poses[:, :, :3])
        matrices = frame.facts.solids.solids.matrices[rows]
        centers = np.einsum("nij,nkj->nki", inverses, matrices[:, :, :, 3] - poses[:, None, :, 3])
        sizes = np.linalg.norm(np.einsum("nij,nkjl->nkil", inverses, matrices[:, :, :, :3]), axis=(2, 3))
        offsets = np.linalg.norm(centers - np.median(centers, axis=0), axis=2) / np.maximum(sizes, 1e-300)
        odd = np.flatnonzero((offsets > EXACT).any(axis=1))
        if len(odd) != 1 or (np.abs(sizes[odd[0]] / np.median(sizes, axis=0) - 1.0) > EXACT).any():
            return
        member, away = int(odd[0]), np.flatnonzero(offsets[odd[0]] > EXACT)
        if len(away) > HALF_SEEN * parts or offsets[member, away].min() < ASTRAY:
            return
        part = int(away[0])
        length = float(offsets[member, part] * sizes[member, part])
        evidence = (
            f'has its "{self._part(int(self.members[member]), int(rows[member, part]))}" {length:.3g} from where '
            f'{count - 1} of {count} "{self.word}" have it'
        )
        yield self.intention("loose part", member, evidence, DOUBTFUL)

    # --- symmetry ----------------------------------------------------------------------------------------------------

    def _mirrored(self) -> Iterator[Intention]:
        """Yield the one sibling that is not quite where the mirror image of another would be."""
        count = len(self)
        for axis in (k for k in range(3) if k != self.up):
            other = [k for k in range(3) if k != axis]
            center = self._mirror_plane(axis)
            if center is None:
                continue
            images = self.places.copy()
            images[:, axis] = 2.0 * center - images[:, axis]
            gaps = np.abs(images[:, None] - self.places[None]).max(axis=2)
            alike = np.abs(self.sizes[:, None] - self.sizes[None]).max(axis=2) <= EXACT * self.size
            single = np.flatnonzero(~((gaps <= EXACT * self.spacing) & alike).any(axis=1))
            if len(single) != 2 or count < 6 or not alike[single[0], single[1]]:
                continue
            first, second = single.tolist()
            offset = images[first] - self.places[second]
            length = abs(float(offset[axis]))
            sides = (self.places[single, axis] - center).tolist()
            is_near = ASTRAY * self.spacing <= length <= NEARBY * self.spacing
            if np.abs(offset[other]).max() <= EXACT * self.spacing and is_near and sides[0] * sides[1] < 0.0:
                distances = np.abs(self.places[:, axis] - center)
                evens = [m for m in (second, first) if _is_even(np.delete(distances, m), EXACT * self.spacing)]
                member = evens[0] if evens else second
                place = images[first if member == second else second]
                evidence = f'is {length:.3g} off the mirror image of another: {count - 1} of {count} "{self.word}" fit'
                yield self.intention("symmetry", member, evidence, LIKELY, place=place)
                return

    def _mirror_plane(self, axis: int) -> float | None:
        """Return the coordinate of the plane in which all siblings but two have images."""
        count, unit = min(len(self), 64), EXACT * self.spacing
        keys = np.concatenate([np.delete(self.places, axis, axis=1), self.sizes], axis=1)[:count]
        same = np.abs(keys[:, None] - keys[None]).max(axis=2) <= unit
        same &= ~np.eye(count, dtype=bool)
        x = self.places[:count, axis]
        middles = np.round((x[:, None] + x[None])[same] / 2.0 / unit).astype(np.int64)
        planes, votes = np.unique(middles, return_counts=True)
        return float(planes[np.argmax(votes)] * unit) if votes.max(initial=0) >= max(count - 2, 4) else None

    # --- partners ----------------------------------------------------------------------------------------------------

    def _loose(self) -> Iterator[Intention]:
        """Yield the one sibling that does not touch a partner, where all others touch one in the same way."""
        for partners in self._partners():
            touched = {member: sorted(those) for member, those in partners.items() if those}
            if len(touched) != len(self) - 1:
                continue
            member = next(m for m in range(len(self)) if m not in touched)
            touches = Counter(partner for those in touched.values() for partner in those)
            alike = self._alike(next(iter(touches)))
            places = {p: (self.frame.center(p)[0] - self.zero) @ self.axes for p in alike}
            usual = max(touches.values())
            lacking = [partner for partner in places if touches[partner] < usual]
            if len(places) < 2 or len(lacking) != 1 or touches[lacking[0]] != usual - 1:
                continue
            offsets = np.array([self.places[m] - places[those[0]] for m, those in touched.items()])
            spread = np.ptp(np.abs(offsets), axis=0).max()
            if spread > EXACT * self.size + EXACT * float(np.abs(offsets).max()):
                continue
            signs = np.array(list(product((-1.0, 1.0), repeat=3)))
            places_left = places[lacking[0]] + signs * np.abs(offsets).mean(axis=0)
            taken = (
                np.linalg.norm(places_left[:, None] - self.places[None], axis=2).min(axis=1) <= SAME_PLACE * self.size
            )
            taken &= np.linalg.norm(places_left - self.places[member], axis=1) > SAME_PLACE * self.size
            length = np.where(taken, np.inf, np.linalg.norm(places_left - self.places[member], axis=1))
            best = int(np.argmin(length))
            is_near = EXACT * self.size < length[best] <= BESIDE_PARTNER * self.size
            if is_near and self._contacts_of(int(self.members[member])) <= self._contacts_of(lacking[0]):
                word = self.frame.ancestry.entity(lacking[0]).word
                evidence = (
                    f'is {length[best]:.3g} off its "{word}": {len(self) - 1} of {len(self)} "{self.word}" touch one'
                )
                yield self.intention("loose part", member, evidence, SURE, place=places_left[best])
                return

    def _contacts_of(self, instance: int) -> int:
        """Return the number of contacts with others; of two that lack each other, the one with fewer is wrong."""
        frame = self.frame
        pairs = frame.facts.contacts.pairs
        inside = (pairs >= frame.first[instance]) & (pairs < frame.last[instance])
        return int((inside[:, 0] != inside[:, 1]).sum())

    def _alike(self, partner: int) -> list[int]:
        """Return the siblings of an instance with its word."""
        frame = self.frame
        same = (frame.ancestry.parent == frame.ancestry.parent[partner]) & (frame.words == frame.words[partner])
        return [int(i) for i in np.flatnonzero(same & (frame.last > frame.first))[:_MAX_SIBLINGS]]

    def _partners(self) -> Iterable[dict[int, set[int]]]:
        """Return for each kind of other parts of the home which of them each sibling touches."""
        frame, count = self.frame, len(self.frame.facts.solids)
        depth = int(frame.ancestry.depth[self.home]) + 1
        owner, part = np.full(count, -1), frame.part_at(depth)
        for member, instance in enumerate(self.members.tolist()):
            owner[frame.first[instance] : frame.last[instance]] = member
        pairs = frame.facts.contacts.pairs
        pairs = np.concatenate([pairs, pairs[:, ::-1]])
        pairs = pairs[(owner[pairs[:, 0]] >= 0) & (owner[pairs[:, 1]] < 0)]
        kinds: dict[int, dict[int, set[int]]] = {}
        for member, other in zip(owner[pairs[:, 0]].tolist(), part[pairs[:, 1]].tolist()):
            if frame.ancestry.parent[other] == self.home:
                kinds.setdefault(int(frame.words[other]), {}).setdefault(member, set()).add(other)
        return kinds.values()


# --- rows and rings --------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True, eq=False)
class _Chart:
    """Coordinates of points in which equally spaced ones are linear.

    Attributes
    ----------
    coordinates : (N, 3)
        Along a row, beside it, and in height; around a ring, from its center, and in height.
    axes : (3, 3)
        Directions of the coordinates of a row; of a ring, the two of its plane and the normal.
    rule
        Its name.
    center, radius
        Of a ring; its length is 2 pi ``radius`` in these coordinates. ``radius`` is 0 for rows.
    """

    coordinates: FloatArray
    axes: FloatArray
    rule: str
    center: FloatArray | None = None
    radius: float = 0.0

    @property
    def normal(self) -> int:
        """Axis that a ring lies around."""
        return int(np.argmax(self.axes[2]))

    @property
    def period(self) -> float:
        """Length of the ring, 0 for rows."""
        return 2.0 * math.pi * self.radius

    @property
    def surrounds(self) -> bool:
        """Whether no point is at the center, where it would face nothing."""
        return float(self.coordinates[:, 1].min()) > 1e-6 * self.radius

    @property
    def span(self) -> float:
        """Largest angle between directions to points of a ring, in radians."""
        angles = self.coordinates[:64, 0] / self.radius
        return float(np.abs(np.angle(np.exp(1j * (angles[:, None] - angles[None])))).max())

    def point(self, coordinates: FloatArray) -> FloatArray:
        """Return the point (3,) with given coordinates."""
        if self.center is None:
            return np.asarray(coordinates @ self.axes, np.float64)
        angle = coordinates[0] / self.radius
        flat = self.center + coordinates[1] * np.array([math.cos(angle), math.sin(angle)])
        return np.asarray(np.array([*flat, coordinates[2]]) @ self.axes, np.float64)

    def unturned(self) -> FloatArray:
        """Return the rotations (N, 3, 3) that bring every point to the angle 0."""
        angles = self.coordinates[:, 0] / self.radius
        cos, sin = np.cos(angles), np.sin(angles)
        back = np.zeros((len(angles), 3, 3))
        back[:, 0, 0], back[:, 0, 1], back[:, 1, 0], back[:, 1, 1], back[:, 2, 2] = cos, sin, -sin, cos, 1.0
        return np.asarray(np.einsum("ji,njk,kl->nil", self.axes, back, self.axes), np.float64)

    def fits(self, members: IntArray) -> bool:
        """Return whether points are equally spaced, but for single empty places."""
        return _series(self.coordinates[members], self.period) is not None

    def rows(self, spacing: float) -> Iterator[tuple[_Chart, IntArray]]:
        """Yield the sets of at least three points that have two coordinates in common."""
        labels = np.stack([_levels(self.coordinates[:, k], EXACT * spacing) for k in (1, 2)], axis=1)
        _, row = np.unique(labels, axis=0, return_inverse=True)
        order = np.argsort(row.reshape(-1), kind="stable")
        for members in np.split(order, np.cumsum(np.bincount(row.reshape(-1)))[:-1]):
            if len(members) >= 3:
                yield self, members


def _along_axes(points: FloatArray) -> list[_Chart]:
    """Return the charts of rows along the three axes."""
    orders = [np.roll(np.arange(3), -k) for k in range(3)]
    return [_Chart(points[:, order], np.eye(3)[order], "a row") for order in orders]


def _straight(points: FloatArray) -> _Chart:
    """Return the chart of a row along the axis in which points spread most."""
    return _along_axes(points)[int(np.argmax(np.ptp(points, axis=0)))]


def _rings(points: FloatArray) -> list[_Chart]:
    """Return charts around the axes and centers that at least four points have about the same distance from."""
    charts = []
    for normal in range(3):
        flat = np.delete(points, normal, axis=1)
        count = len(flat)
        centers = [np.zeros(2), flat.mean(axis=0)]
        for start in range(3):  # what one point is not in all of, from five points on
            triple = flat[(start + np.array([0, count // 3, 2 * count // 3])) % count]
            center = _circumcenter(triple)
            if center is not None and not any(np.allclose(center, c) for c in centers):
                centers.append(center)
        for center in centers:
            distances = np.linalg.norm(flat - center, axis=1)
            usual = float(np.median(distances))
            same = np.abs(distances - usual) <= EXACT * usual
            if usual > 0.0 and same.sum() >= 4 and usual <= 2.0 * float(np.ptp(flat, axis=0).max()):
                charts.append(_polar(points, normal, center))
    return charts


def _polar(points: FloatArray, normal: int, center: FloatArray) -> _Chart:
    """Return the chart of a ring."""
    order = [*(k for k in range(3) if k != normal), normal]
    flat = points[:, order[:2]] - center
    distances = np.linalg.norm(flat, axis=1)
    radius = max(float(np.median(distances)), 1e-300)
    angles = np.arctan2(flat[:, 1], flat[:, 0])
    coordinates = np.stack([angles * radius, distances, points[:, normal]], axis=1)
    return _Chart(coordinates, np.eye(3)[order], "a ring", center, radius)


def _circumcenter(corners: FloatArray) -> FloatArray | None:
    """Return the center of the circle through three points of the plane, None if they are in line."""
    a, b = corners[1] - corners[0], corners[2] - corners[0]
    cross = 2.0 * float(a[0] * b[1] - a[1] * b[0])
    if abs(cross) <= 1e-6 * float(a @ a + b @ b):
        return None
    u, v = float(a @ a), float(b @ b)
    return np.asarray(corners[0] + np.array([b[1] * u - a[1] * v, a[0] * v - b[0] * u]) / cross, np.float64)


@dataclass(frozen=True, slots=True, eq=False)
class _Series:
    """Points at numbered places: coordinates are ``base + number * step``.

    Attributes
    ----------
    base, step : (3,)
        Coordinates of place 0, and from one to the next.
    last
        Largest number that is taken; those of the ``empty`` places are between, or complete a ring.
    is_closed
        Whether the places go around a ring.
    """

    base: FloatArray
    step: FloatArray
    last: int
    empty: tuple[int, ...]
    is_closed: bool


def _series(coordinates: FloatArray, period: float) -> _Series | None:
    """Return the equally spaced places of at least three points, None if they are not equally spaced."""
    order = np.argsort(coordinates[:, 0], kind="stable")
    values = coordinates[order]
    if period:
        gaps = np.diff(values[:, 0], append=values[0, 0] + period)
        start = int(np.argmax(gaps)) + 1
        values = np.concatenate([values[start:], values[:start] + np.array([period, 0.0, 0.0])])
    gaps = np.diff(values[:, 0])
    gap = float(np.sort(gaps)[(len(gaps) - 1) // 2])
    if len(values) < 3 or gap <= 0.0 or (period and gap > LARGEST_STEP * period):
        return None
    places = np.cumsum(np.round(gaps / gap))
    if not np.isfinite(places[-1]) or places[-1] > len(values) + 1:  # a gap that is nearly 0 has no multiples
        return None
    numbers = np.concatenate([[0], places]).astype(np.int64)
    if (np.diff(numbers) < 1).any():
        return None
    design = np.stack([np.ones(len(values)), numbers], axis=1)
    (base, step), *_ = np.linalg.lstsq(design, values, rcond=None)
    length = float(np.linalg.norm(step))
    if np.abs(values - design @ np.stack([base, step])).max() > EXACT * length:
        return None
    count = round(period / step[0])
    is_closed = bool(period) and abs(count * step[0] - period) <= 0.05 * step[0]
    last = int(numbers[-1])
    every = range(max(count, last + 1) if is_closed else last + 1)
    return _Series(base, step, last, tuple(sorted(set(every) - set(numbers.tolist()))), is_closed)


def _departure(chart: _Chart, members: IntArray, suspect: int | None = None) -> _Departure | None:
    """Return the one member that is not at its place in a row or ring of the others, or the only empty place.

    Parameters
    ----------
    suspect
        The only member that may be wrong, if it is known.
    """
    coordinates = chart.coordinates[members]
    series = _series(coordinates, chart.period)
    if series is not None:
        return _gap(chart, members, series)
    suspects = _suspects(coordinates) if suspect is None else np.flatnonzero(members == suspect)
    departures = []
    for number in suspects.tolist() if len(members) >= _MIN_SIBLINGS else ():
        others = _series(np.delete(coordinates, number, axis=0), chart.period)
        if others is not None:
            departure = _missed(chart, others, int(members[number]), len(members) - 1)
            if departure is not None:
                departures.append(departure)
    return max(departures, key=lambda d: (d.confidence, -d.length), default=None)


def _gap(chart: _Chart, members: IntArray, series: _Series) -> _Departure | None:
    """Return the only empty place of equally spaced points; a gap in the middle of an open row is meant."""
    if (
        len(series.empty) != 1
        or len(members) < (5 if chart.radius else 6)
        or (2 * series.empty[0] == series.last and not series.is_closed)
    ):
        return None
    at = chart.point(series.base + series.empty[0] * series.step)
    before = chart.point(series.base + (series.empty[0] - 1) * series.step)
    points = np.stack([chart.point(c) for c in chart.coordinates[members]])
    member = int(members[np.argmin(np.linalg.norm(points - before, axis=1))])
    confidence = LIKELY if len(members) >= 7 else DOUBTFUL
    return _Departure(member, at, float(np.linalg.norm(series.step)), 0.0, confidence, chart.rule, len(members))


def _missed(chart: _Chart, series: _Series, member: int, count: int) -> _Departure | None:
    """Return how far a member is from the only place of a series that is left for it; None if that says nothing."""
    if len(series.empty) > 1 or (series.is_closed and not series.empty) or count < 3:
        return None
    spacing = float(np.linalg.norm(series.step))
    numbers = series.empty or (-1, series.last + 1)
    offsets = chart.coordinates[member] - (series.base + np.array(numbers)[:, None] * series.step)
    if chart.radius:
        offsets[:, 0] -= chart.period * np.round(offsets[:, 0] / chart.period)
    best = int(np.argmin(np.linalg.norm(offsets, axis=1)))
    offset = offsets[best] if chart.radius else _axes_along(series.step) @ offsets[best]
    along, length = abs(float(offset[0])), float(np.linalg.norm(offset))
    sole = int((np.abs(offset) > EXACT * spacing).sum()) == 1
    place = series.base + numbers[best] * series.step
    is_slip = False
    if chart.radius and sole and member:  # angles are counted from the first sibling
        expected, actual = (at[0] - chart.coordinates[0, 0] for at in (place, chart.coordinates[member]))
        is_slip = _is_slip(expected / chart.radius, actual / chart.radius)
    on_ring = series.is_closed and sole and along > EXACT * spacing
    if length < ASTRAY * spacing or (length > NEARBY * spacing and not on_ring):
        return None
    is_beside = sole and along <= EXACT * spacing  # at its place along the row, but beside, above or below it
    if series.empty:
        confidence = (SURE if count >= 4 else LIKELY) if sole else DOUBTFUL
        enough = count >= (3 if is_beside and not chart.radius else 4) or is_slip
    else:
        confidence = LIKELY if along <= EXACT * spacing else DOUBTFUL
        enough = count >= ((4 if chart.radius else 3) if is_beside else 5)
    departure = _Departure(member, chart.point(place), spacing, length, confidence, chart.rule, count, is_slip)
    return departure if enough else None


def _axes_along(step: FloatArray) -> FloatArray:
    """Return axes (3, 3), one a row: along a step, and two across it, of which one is a coordinate axis if possible.

    The axes of a home may be turned to those of most of its siblings, so that a row lies slanted in them.
    """
    along = step / np.linalg.norm(step)
    across = np.eye(3)[int(np.argmin(np.abs(along)))]
    across = across - (across @ along) * along
    across /= np.linalg.norm(across)
    return np.stack([along, across, np.cross(along, across)])


def _suspects(coordinates: FloatArray) -> IntArray:
    """Return the points whose neighbors in order are least in line with them, and both ends."""
    order = np.argsort(coordinates[:, 0], kind="stable")
    if len(order) <= _MAX_SUSPECTS:
        return order
    bends = np.linalg.norm(np.diff(coordinates[order], n=2, axis=0), axis=1)
    most = 1 + np.argsort(-bends, kind="stable")[: _MAX_SUSPECTS - 2]
    return np.asarray(order[np.concatenate([most, [0, len(order) - 1]])], np.int64)


def _levels(values: FloatArray, tolerance: float) -> IntArray:
    """Return for each value the number of its cluster, ascending; clusters are apart by more than ``tolerance``."""
    order = np.argsort(values, kind="stable")
    numbers = np.zeros(len(values), np.int64)
    numbers[order[1:]] = np.cumsum(np.diff(values[order]) > tolerance)
    return numbers


def _least_gap(values: FloatArray, tolerance: float) -> float:
    """Return the least distance of distinct values, infinity if there is one only."""
    gaps = np.diff(np.sort(values))
    return float(gaps[gaps > tolerance].min(initial=math.inf))


def _is_even(values: FloatArray, tolerance: float) -> bool:
    """Return whether distinct values are equally spaced."""
    gaps = np.diff(np.sort(values))
    gaps = gaps[gaps > tolerance]
    return not len(gaps) or float(np.ptp(gaps)) <= tolerance


# --- turns -----------------------------------------------------------------------------------------------------------


def _angle(rotation: FloatArray) -> float:
    """Return the angle of a rotation."""
    return math.acos(max(-1.0, min(1.0, (float(np.trace(rotation)) - 1.0) / 2.0)))


def _axis(rotation: FloatArray) -> FloatArray:
    """Return the unit axis of a rotation, about which it turns counterclockwise."""
    axis = np.linalg.svd(rotation - np.eye(3))[2][-1]
    skew = rotation - rotation.T
    sense = float(axis @ np.array([skew[2, 1], skew[0, 2], skew[1, 0]]))
    return np.asarray(-axis if sense < 0.0 else axis, np.float64)


def _odd_turn(turns: FloatArray, *, alternate: bool) -> tuple[int | None, FloatArray]:
    """Return the only rotation unlike all others, and theirs; None if all are equal, -1 if several differ."""
    classes = np.arange(len(turns)) % 2 if alternate else np.zeros(len(turns), np.int64)
    odd, expected = list[tuple[int, FloatArray]](), turns[0]
    for number in np.unique(classes).tolist():
        members = np.flatnonzero(classes == number)
        best: list[int] | None = None
        for candidate in members[:2].tolist():
            cosines = np.einsum("nij,ij->n", turns[members], turns[candidate])
            unlike = members[cosines < 1.0 + 2.0 * math.cos(SAME_TURN)].tolist()
            if best is None or len(unlike) < len(best):
                best, expected = unlike, turns[candidate]
        odd += [(member, expected) for member in best or ()]
    if not odd:
        return None, expected
    return (odd[0][0], odd[0][1]) if len(odd) == 1 else (-1, expected)


def _is_slip_of_angle(expected: FloatArray, actual: FloatArray) -> bool:
    """Return whether a rotation is one by as many radians as another has degrees, or the reverse."""
    angle, axis = _angle(expected), _axis(expected)
    if angle < 1e-3 or np.linalg.norm(actual @ axis - axis) > 1e-6:
        return False
    turned = _angle(actual) * (1.0 if float(axis @ _axis(actual)) >= 0.0 else -1.0)
    return _is_slip(angle, turned)


def _is_slip(expected: float, actual: float) -> bool:
    """Return whether an angle has as many radians as another has degrees, or the reverse, by any number of turns."""
    wholes = [expected + 2.0 * math.pi * k for k in (-1, 0, 1)]
    slips = [whole * factor for whole in wholes if abs(whole) > 1e-3 for factor in (_DEGREES, 1.0 / _DEGREES)]
    return any(abs(math.remainder(slip - actual, 2.0 * math.pi)) < SAME_SLIP for slip in slips)
