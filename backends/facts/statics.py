"""Statics of a frame: which bodies can stay where they are under gravity, as rigid bodies with friction.

A body is in balance if its center of mass and whatever it carries are above the hull of the contacts it rests on.
Where that decides nothing, such as for a ladder, an arch or a counterweight, the forces of all contacts of the
connected bodies are a linear program (Whiting, Ochsendorf and Durand, "Procedural modeling of structurally-sound
masonry buildings", 2009). Equilibrium is not stability: a center of mass must bear a shift, a round foot must raise it
when it rolls, and faces that clamp a body have no friction, since nothing presses them together.

Contacts only push, except those that ``fastened`` names; bodies that they join are one group.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from scenelang.backends.facts.bodies import BodySet
from scenelang.backends.facts.contacts import (
    Contacts,
    area_of,
    extreme_points,
    rectangles_of,
    region_of,
    rooms_of,
    vertices_of,
)
from scenelang.backends.facts.ground import Ground
from scenelang.backends.facts.linear import least_slack
from scenelang.backends.facts.tolerances import BALANCE, FRICTION, HEAVY_FOOT, NARROW, PARALLEL
from scenelang.backends.surfaces.convex import Bodies, all_within, beyond_edge, clusters, hull_of, plane_axes, width_of
from scenelang.backends.surfaces.distance import IntArray
from scenelang.backends.surfaces.solids import FloatArray, PosedForms

BoolArray = npt.NDArray[np.bool_]

PLANE = -1  # number of the ground plane where contacts name bodies
_MAX_GROUPS = 200  # of a linear program; of larger ones, each body is judged by the hull of its own contacts
_RAYS = 8  # of a friction cone; a pyramid of 8 rays holds up to 8 % less than the cone
_MAX_SLACK = 2e-3  # relative to weight, and to weight times size: HiGHS is exact to 1e-7, contact regions to 1e-3
_SETTLED_TILT = math.radians(10.0)  # within which a body on a round foot comes to rest without toppling
_TILT = math.radians(0.5)  # of a test of a round foot: large against rounding, small against a polygon of 64 sides
_MIN_RISE = -1e-9  # relative to a body's size: a ball neither rises nor falls when it rolls
_NARROW_REGION = 1e-2  # relative to a body's size: where a ball touches a plane, 1.3e-3 for a bowling ball
_NARROW = 1e-3  # relative to a body's size: a narrower foot is an edge or a point
_STEEP, _LEVEL = 0.95, 1e-3  # vertical components of normals: of a face that clamps, and of two that do not lift
_SIDEWAYS = 0.5  # vertical component of a normal: faces that are steeper than 60 degrees are walls
_ROUGH = 20.0  # coefficient of friction of a contact that does not slide
_SAME = 1e-6  # of a body's breadth: arrangements of contacts that differ by less are equal
_SLIVER = 4.0  # squared contact tolerances: a sideways region of this area is the edge of one below
_FLAT = 0.1  # thickness over breadth of a region that is a plane: that of a face is twice the contact tolerance


@dataclass(frozen=True, slots=True, eq=False)
class BodyContact:
    """Contact of two bodies.

    Attributes
    ----------
    body, other
        The body that the contact pushes along ``normal``, and the one that pushes; ``PLANE`` is the ground plane.
    row
        Row of the contact of their solids; -1 for the plane.
    points : (K, 3)
        Corners of the region.
    normal : (3,)
        Unit vector.
    depth
        Penetration depth, in scene units.
    """

    body: int
    other: int
    row: int
    points: FloatArray
    normal: FloatArray
    depth: float


@dataclass(frozen=True, slots=True, eq=False)
class Balance:
    """Verdict on a group of bodies.

    Attributes
    ----------
    kind
        "stands", "tips", "slides" or "falls".
    beyond
        Distance of the center of mass beyond the hull of its supports, in scene units; negative inside.
    shift : (2,)
        Horizontal translation of the center that brings it to the middle of the nearest side of its support.
    """

    kind: str
    beyond: float = 0.0
    shift: tuple[float, float] = (0.0, 0.0)


@dataclass(frozen=True, slots=True)
class Perturbation:
    """Change of a scene under which its forces must balance.

    Attributes
    ----------
    shift : (2,)
        Horizontal shift of all centers of mass, relative to the extents of their groups.
    grip
        Factor of all friction; infinite for contacts that do not slide.
    inset
        Share by which the region of every contact is smaller.
    """

    shift: tuple[float, float] = (0.0, 0.0)
    grip: float = 1.0
    inset: float = 0.0


STANDS = Balance("stands", -math.inf)
PIVOTS = Balance("stands", -0.0)  # about a point or an edge, and comes back: it hangs, or its foot is round


def members_of(group: IntArray) -> dict[int, IntArray]:
    """Return the rows of each number of an array (B,), ascending."""
    order = np.argsort(group, kind="stable")
    numbers, starts = np.unique(group[order], return_index=True)
    return dict(zip(numbers.tolist(), np.split(order, starts[1:])))


class Statics:
    """Contacts of the bodies of a frame, and the balance of groups of them."""

    def __init__(
        self, solids: Bodies, bodies: BodySet, contacts: Contacts, ground: Ground, fixed: BoolArray,
        before: tuple[Statics | None, BoolArray | None] = (None, None),
    ) -> None:  # fmt: skip
        """Measure the contacts; ``before`` are the statics before some solids moved, and which (N,) did."""
        self.solids, self.bodies, self.contacts, self.ground, self.fixed = solids, bodies, contacts, ground, fixed
        self._before, self._moved = before
        self._faces: dict[tuple[int, int], list[tuple[FloatArray, FloatArray]]] = {}  # normals and regions, by solids
        self._has_friction = not np.isnan(bodies.friction).all()
        self._hulls: dict[tuple[int, ...], tuple[Balance, bool]] = {}  # of groups, by their bodies
        self._stands: dict[tuple[int, bytes], tuple[Balance, bool]] = {}  # by supports, loads and size about the center
        self._solved: dict[object, list[Balance]] = {}  # of connected groups, by their solids
        self.links = [*self._between_bodies(), *self._with_plane()]
        self.of_body: list[list[BodyContact]] = [[] for _ in range(len(bodies))]
        for link in self.links:
            self.of_body[link.body].append(link)
            if link.other != PLANE:
                self.of_body[link.other].append(link)

    def _between_bodies(self) -> Iterator[BodyContact]:
        """Yield the contacts of different bodies of which one can move."""
        contacts, owner = self.contacts, self.bodies.body
        first, second = owner[contacts.pairs].T
        rows = np.flatnonzero((first != second) & ~(self.fixed[first] & self.fixed[second]))
        depths, normals = contacts.depths(rows)
        aligned = np.all(self.solids.aligned[contacts.pairs[rows]], axis=1)
        regions = iter(rectangles_of(self.solids, contacts.pairs[rows[aligned]], normals[aligned]))
        bodies, others = second[rows].tolist(), first[rows].tolist()
        for k, (row, depth, is_aligned) in enumerate(zip(rows.tolist(), depths.tolist(), aligned.tolist())):
            faces = [(normals[k], next(regions))] if is_aligned else self._faces_of(row, depth, normals[k])
            for normal, points in faces:
                yield BodyContact(bodies[k], others[k], row, points, normal, depth)

    def _faces_of(self, row: int, depth: float, along: FloatArray) -> list[tuple[FloatArray, FloatArray]]:
        """Return the normals and regions of a contact, from before if its solids did not move."""
        i, j = self.contacts.pairs[row].tolist()
        if self._before is not None and self._moved is not None and not self._moved[[i, j]].any():
            known = self._before._faces.get((i, j))
            if known is not None:
                return self._faces.setdefault((i, j), known)
        faces = []
        if self.solids.hollow[[i, j]].any() and depth <= self.contacts.room[row]:
            faces = self._in_hollow(row)
        faces = faces or [(along, region_of(self.solids, self.contacts, row))]
        self._faces[i, j] = faces
        return faces

    def _in_hollow(self, row: int) -> list[tuple[FloatArray, FloatArray]]:
        """Return the normals and regions of a contact with a concave solid or a mesh: where one meets the other.

        A pin in a hole touches it all around, a mug on a hook only from above. A flat region has the normal of its
        plane.
        """
        i, j = self.contacts.pairs[row].tolist()
        reach = float(self.contacts.gaps[row]) + 0.5 * float(self.contacts.room[row])
        faces = []
        for direction in _DIRECTIONS:
            points = self.solids.common_points(i, j, -reach * direction)  # the second is pushed into the first
            if len(points):
                normal = _plane_normal(points, direction)
                if abs(normal @ direction) < np.abs(normal).max() - _TIE:
                    continue  # a face is met along its dominant axis: pushed along another, its side is arbitrary
                if direction[1] != 0.0 or area_of(points, normal) > _SLIVER * reach**2:
                    faces.append((normal, extreme_points(points, normal)))
        return faces

    def _with_plane(self) -> Iterator[BodyContact]:
        """Yield the contacts of bodies with the plane of the ground."""
        low, high = self.solids.boxes
        height, up = self.ground.height, np.array([0.0, 1.0, 0.0])
        every = np.arange(len(self.solids))
        room = rooms_of(self.solids, np.stack([every, every], axis=1))
        # A marked parking spot or a mat, thinner than the contact tolerance, lies on the plane all the same.
        above = np.minimum(room, 0.5 * (high - low)[:, 1])
        near = (low[:, 1] <= height + room) & (high[:, 1] >= height + above) & ~self.fixed[self.bodies.body]
        middle = ((low + high) / 2.0)[:, [0, 2]]
        for k in np.flatnonzero(self.ground.solids).tolist():  # the plane is beside the solids that are the ground
            near &= ~((middle >= low[k, [0, 2]]) & (middle <= high[k, [0, 2]])).all(axis=1)
        for i in np.flatnonzero(near).tolist():
            body = int(self.bodies.body[i])
            depth = max(height - float(low[i, 1]), 0.0)
            yield BodyContact(body, PLANE, -1, self._foot(i, float(room[i])), up, depth if depth > room[i] else 0.0)

    def _foot(self, i: int, room: float) -> FloatArray:
        """Return the points (K, 3) of a solid at or below the ground plane."""
        if self.solids.aligned[i]:
            (x, _, z), (u, _, w) = (corner[i].tolist() for corner in self.solids.boxes)
            height = self.ground.height
            return np.array([[x, height, z], [u, height, z], [u, height, w], [x, height, w]])
        vertices = vertices_of(self.solids, i)
        limit = max(self.ground.height, float(vertices[:, 1].min())) + room
        foot: FloatArray = vertices[vertices[:, 1] <= limit].copy()
        foot[:, 1] = self.ground.height
        return foot

    @cached_property
    def clusters(self) -> IntArray:
        """Groups (B,) of bodies that contacts connect."""
        return clusters(len(self.bodies), [(link.body, link.other) for link in self.links if link.other != PLANE])

    # --- groups ------------------------------------------------------------------------------------------------------

    def grounded(self, anchored: BoolArray) -> BoolArray:
        """Return which bodies (B,) are connected by contacts to the ground or to an ``anchored`` body."""
        label = self.clusters
        standing = {int(label[link.body]) for link in self.links if link.other == PLANE}
        standing |= set(label[self.fixed | anchored].tolist())
        return np.array([int(number) in standing for number in label], bool)

    def balances(self, group: IntArray, judged: BoolArray, braced: BoolArray | None = None) -> dict[int, Balance]:
        """Return the balance of each group of bodies of which ``judged`` (B,) ones are members.

        Parameters
        ----------
        group : (B,)
            Equal for bodies that are fastened to each other.
        braced : (B,)
            Bodies that hold besides the fixed ones, none by default.
        """
        is_held = self.fixed | self.bodies.floating
        held = set(group[is_held if braced is None else is_held | braced].tolist())
        known: dict[int, Balance] = dict.fromkeys(held, STANDS)
        open_groups: set[int] = set()
        rows_of = members_of(group)
        for number in np.unique(group[judged]).tolist():
            if number in held:
                continue
            key = tuple(rows_of[number].tolist())
            if key not in self._hulls:
                self._hulls[key] = self._by_hull(group, rows_of[number])
            known[number], sure = self._hulls[key]
            if not sure:
                open_groups.add(number)
        for component in self._components(group, held, open_groups):
            if len(component) <= _MAX_GROUPS:
                known |= self._by_program(group, [rows_of[number] for number in component], component, known)
        return known

    def are_narrow(self, group: IntArray, balances: Mapping[int, Balance], doubtful: BoolArray) -> BoolArray:
        """Return which bodies (B,) bear no shift of 5 % of their breadth, nor 5 % less friction or smaller contacts.

        Bodies that touch each other and can move are narrow together: each may push the others. So are those that
        forces hold where the hold of one is ``doubtful`` (B,).
        """
        narrow, rows_of = np.zeros(len(self.bodies), bool), members_of(group)
        held = set(group[self.fixed | self.bodies.floating].tolist())
        by_forces = set[int]()
        for number, rows in rows_of.items():
            if number in held:
                continue
            breadth = float((self.bodies.high[rows].max(axis=0) - self.bodies.low[rows].min(axis=0))[[0, 2]].max())
            hull, is_sure = self._hulls.get(tuple(rows.tolist()), (STANDS, True))
            solids = np.concatenate([self.bodies.members[int(body)] for body in rows])
            may_roll = hull.beyond > -math.inf and self._has_narrow_foot(solids, breadth)  # a ball in its bowl
            narrow[rows] = may_roll or balances.get(number, STANDS).beyond > -NARROW * breadth
            if not is_sure and hull is not PIVOTS:
                by_forces.add(number)
        for component in self._components(group, held, by_forces):
            members = [rows_of[number] for number in component]
            every = np.concatenate(members)
            narrow[every] |= doubtful[every].any()
            pivots = np.array([balances.get(number) is PIVOTS for number in component], bool)
            for trial in [*_shifts_by(NARROW), Perturbation(grip=1.0 - NARROW), Perturbation(inset=float(NARROW))]:
                if narrow[every].all() or len(component) > _MAX_GROUPS:
                    break
                slack = self._slack(group, component, members, pivots, trial)
                narrow[every] |= slack is not None and slack.max() > _MAX_SLACK
        for component in self._components(group, held, set(group[narrow].tolist()) - held):
            narrow[np.concatenate([rows_of[number] for number in component])] = True
        return narrow

    def links_of(self, members: Iterable[int], group: IntArray) -> Iterator[tuple[BodyContact, FloatArray]]:
        """Yield the contacts of the members of a group with others, each with the normal towards the member."""
        for body in members:
            for link in self.of_body[body]:
                if link.body == body:
                    if link.other == PLANE or group[link.other] != group[body]:
                        yield link, link.normal
                elif group[link.body] != group[body]:
                    yield link, -link.normal

    def center_of(self, members: IntArray) -> FloatArray:
        """Return the center of mass (3,) of bodies."""
        if len(members) == 1:
            return np.asarray(self.bodies.center[members[0]], np.float64)
        mass = self.bodies.mass[members]
        return np.asarray((self.bodies.center[members] * mass[:, None]).sum(axis=0) / mass.sum(), np.float64)

    def stands_on_heavy_foot(self, members: IntArray, group: IntArray) -> bool:
        """Return whether a group that tips stands if the one solid that it stands on is heavier than the rest.

        Models are solid where lamps are hollow, so that the shade outweighs the foot.
        """
        rows = np.concatenate([self.bodies.members[int(body)] for body in members])
        feet = {
            self._solid_of(link, rows) for link, normal in self.links_of(members.tolist(), group) if normal[1] > 0.5
        }
        if len(feet) != 1 or len(rows) < 2:
            return False
        volume, middle = self.solids.masses
        weight = volume[rows] * np.where(rows == feet.pop(), float(HEAVY_FOOT), 1.0)
        center = (middle[rows] * weight[:, None]).sum(axis=0) / weight.sum()
        supports, _, _ = self.supports_of(members, group)
        return len(supports) > 0 and beyond_edge(supports[:, [0, 2]], center[[0, 2]])[0] < 0.0

    def settles(self, members: IntArray, group: IntArray) -> bool:
        """Return whether a group that tips comes to rest within a small angle: a pretzel that lies on two of its bends.

        The points that meet what carries it within that angle count as supports, where that is below them.
        """
        rows = np.concatenate([self.bodies.members[int(body)] for body in members])
        lifting = [pair for pair in self.links_of(members.tolist(), group) if pair[1][1] > _SIDEWAYS]
        if any(normal[1] < 1.0 - _LEVEL for _, normal in lifting):
            return False  # on a slope it rolls or slides on
        links = [link for link, _ in lifting]
        pairs = [self.contacts.pairs[link.row] for link in links if link.row >= 0]
        carriers = np.setdiff1d(np.array(pairs, np.int64).reshape(-1), rows).tolist()
        if not links or len(carriers) > 1 or (carriers and len(pairs) < len(links)):
            return False
        supports = np.concatenate([link.points for link in links])
        level, center, flat = float(supports[:, 1].max()), self.center_of(members), hull_of(supports[:, [0, 2]])
        points = np.concatenate([vertices_of(self.solids, int(i)) for i in rows])
        points = points[points[:, 1] - level <= math.tan(_SETTLED_TILT) * _distances(flat, points[:, [0, 2]])]
        if carriers:
            top = hull_of(vertices_of(self.solids, carriers[0])[:, [0, 2]])
            points = points[_are_within(top, points[:, [0, 2]])]
        every = hull_of(np.concatenate([supports, points])[:, [0, 2]])
        room = _NARROW * float(self.bodies.extent(members)[[0, 2]].max())  # what lies on its round side has no breadth
        return bool(beyond_edge(flat, center[[0, 2]])[0] > room >= beyond_edge(every, center[[0, 2]])[0])

    def _solid_of(self, link: BodyContact, rows: IntArray) -> int:
        """Return the solid of a contact that is among ``rows``; for the plane, the lowest of them."""
        if link.row < 0:
            return int(rows[np.argmin(self.solids.boxes[0][rows, 1])])
        return next(int(i) for i in self.contacts.pairs[link.row] if i in rows)

    def supports_of(self, members: IntArray, group: IntArray) -> tuple[FloatArray, FloatArray, bool]:
        """Return the points a group rests on (K, 3), those at which it carries others, and whether it is held aside."""
        supports, loads, aside = [np.zeros((0, 3))], [np.zeros((0, 3))], False
        for link, normal in self.links_of(members.tolist(), group):
            slope = 1.0 / math.hypot(1.0, self._friction(link))
            if normal[1] >= slope:
                supports.append(link.points)
            elif normal[1] <= -slope:
                loads.append(link.points)
            else:
                aside = True
        return np.concatenate(supports), np.concatenate(loads), aside

    def _friction(self, link: BodyContact) -> float:
        """Return the coefficient of friction of a contact: the larger given one, else the default."""
        if not self._has_friction:
            return float(FRICTION)
        given = self.bodies.friction[[link.body] if link.other == PLANE else [link.body, link.other]]
        return float(np.nanmax(given)) if not np.isnan(given).all() else float(FRICTION)

    def _by_hull(self, group: IntArray, members: IntArray) -> tuple[Balance, bool]:
        """Return the balance of a group by the hull of its supports, and whether that is sure."""
        supports, loads, aside = self.supports_of(members, group)
        low, high = self.bodies.low[members].min(axis=0), self.bodies.high[members].max(axis=0)
        breadth, center = float((high - low)[[0, 2]].max()), self.center_of(members)
        if not len(supports):
            return Balance("falls", math.inf), not aside
        if float(supports[:, 1].max()) > center[1] + BALANCE * float(high[1] - low[1]):
            return PIVOTS, True  # it hangs: a pendulum swings until its center is below
        # The bricks of a wall have a few arrangements of contacts: of 100,000, a hull takes most of the time.
        relative = np.round((np.concatenate([supports, loads, [center + high - low]]) - center) / (_SAME * breadth))
        key = len(supports), relative[:, [0, 2]].tobytes()
        if key in self._stands:
            return self._stands[key]
        flat = hull_of(supports[:, [0, 2]])
        beyond, nearest = beyond_edge(flat, center[[0, 2]])
        if beyond <= -BALANCE * breadth or (beyond < 0.0 and self._bears_shift(flat, center, high - low)):
            verdict = Balance("stands", beyond), all_within(flat, loads[:, [0, 2]], BALANCE * breadth)
            return self._stands.setdefault(key, verdict)
        if self._is_round(members, supports, center, max(breadth, float(high[1] - low[1]))):
            return PIVOTS, True
        inward = flat.mean(axis=0) - nearest
        shift = nearest - center[[0, 2]] + 0.1 * breadth * inward / max(float(np.linalg.norm(inward)), 1e-9 * breadth)
        shift = np.where(np.abs(shift) >= 0.1 * np.abs(shift).max(), shift, 0.0)  # regions are not quite symmetric
        return Balance("tips", beyond, (float(shift[0]), float(shift[1]))), not aside and not len(loads)

    @staticmethod
    def _bears_shift(flat: FloatArray, center: FloatArray, size: FloatArray) -> bool:
        """Return whether a center of mass stays above the hull of points (K, 2) when it is shifted along an axis."""
        shifts = np.array([trial.shift for trial in _shifts_by(BALANCE)]) * size[[0, 2]]
        return all(beyond_edge(flat, center[[0, 2]] + shift)[0] <= 0.0 for shift in shifts)

    def _is_round(self, members: IntArray, supports: FloatArray, center: FloatArray, size: float) -> bool:
        """Return whether a group stands on a round foot that raises its center of mass, or keeps it, when it rolls.

        Its own foot must be narrow, and below the center; the height of the center is then the support function.
        """
        if width_of(supports[:, [0, 2]]) > _NARROW_REGION * size:
            return False
        rows = np.concatenate([self.bodies.members[int(body)] for body in members])
        solids = self.solids.solids.take(rows)
        flat = supports[:, [0, 2]]
        apart = float(np.linalg.norm(flat - center[[0, 2]], axis=1).min())
        is_above = min(apart, beyond_edge(flat, center[[0, 2]])[0]) <= 2.0 * _NARROW * size
        upright = self._height(solids, center, 0.0, 0.0)
        # What is not right above its foot may still come to rest within a small angle, as a fish on its belly, and a
        # bowl of few faces.
        rises = [
            min(self._height(solids, center, azimuth, tilt) - upright for azimuth in np.arange(8) * (math.pi / 4.0))
            for tilt in ((_TILT, _SETTLED_TILT) if is_above else (_SETTLED_TILT,))
        ]
        return max(rises) >= _MIN_RISE * size and self._has_narrow_foot(rows, size)

    @staticmethod
    def _height(solids: PosedForms, center: FloatArray, azimuth: float, tilt: float) -> float:
        """Return the height of a center above a plane that supports solids, tilted by an angle towards an azimuth."""
        down = np.array([math.sin(tilt) * math.cos(azimuth), -math.cos(tilt), math.sin(tilt) * math.sin(azimuth)])
        points = solids.support(np.broadcast_to(down, (len(solids), 3)))
        return float((points @ down).max() - center @ down)

    def _has_narrow_foot(self, rows: IntArray, size: float) -> bool:
        """Return whether the lowest points of solids are an edge or a point."""
        low = self.solids.boxes[0][rows, 1]
        lowest = rows[low <= low.min() + _NARROW * 0.01 * size]
        points = np.concatenate([vertices_of(self.solids, int(i)) for i in lowest])
        foot = points[points[:, 1] <= points[:, 1].min() + 1e-6 * size]
        return width_of(foot[:, [0, 2]]) <= _NARROW * size

    # --- linear programs ---------------------------------------------------------------------------------------------

    def _components(self, group: IntArray, held: set[int], open_groups: set[int]) -> Iterator[list[int]]:
        """Yield the connected groups, through contacts of movable ones, that contain an open group."""
        if not open_groups:
            return
        near: dict[int, set[int]] = {}
        for link in self.links:
            if link.other == PLANE:
                continue
            a, b = int(group[link.body]), int(group[link.other])
            if a != b and a not in held and b not in held:
                near.setdefault(a, set()).add(b)
                near.setdefault(b, set()).add(a)
        done: set[int] = set()
        for start in sorted(open_groups):
            if start in done:
                continue
            component, stack = {start}, [start]
            while stack:
                fresh = near.get(stack.pop(), set()) - component
                component |= fresh
                stack += fresh
            done |= component
            yield sorted(component)

    def _by_program(
        self, group: IntArray, members: Sequence[IntArray], component: Sequence[int], known: dict[int, Balance]
    ) -> dict[int, Balance]:
        """Return the balances of connected groups by the forces of their contacts."""
        solids = tuple(
            tuple(np.concatenate([self.bodies.members[int(body)] for body in rows]).tolist()) for rows in members
        )
        touching = {link.row for rows in members for body in rows for link in self.of_body[int(body)]}
        pairs = frozenset(tuple(self.contacts.pairs[row].tolist()) if row >= 0 else () for row in touching)
        key = solids, pairs
        if key not in self._solved:
            before = None
            if self._before is not None and self._moved is not None:
                named = [i for rows in (*solids, *pairs) for i in rows]
                before = None if self._moved[named].any() else self._before._solved.get(key)
            self._solved[key] = before or self._solve(group, component, members, known)
        return dict(zip(component, self._solved[key]))

    def _solve(
        self, group: IntArray, component: Sequence[int], members: Sequence[IntArray], known: dict[int, Balance]
    ) -> list[Balance]:
        """Return the balances of connected groups, in their order."""
        pivots = np.array([known.get(number) is PIVOTS for number in component], bool)
        worst = np.zeros(len(component))
        for trial in (Perturbation(), *_shifts_by(BALANCE)):
            slack = self._slack(group, component, members, pivots, trial)
            if slack is None:
                return [known[number] for number in component]
            worst = np.maximum(worst, slack)
            if worst.max() > _MAX_SLACK:  # what falls without a shift falls with one
                break
        verdicts: dict[int, Balance] = {}
        for k, number in enumerate(component):
            if worst[k] <= _MAX_SLACK:
                verdicts[number] = PIVOTS if pivots[k] else STANDS
            else:
                before = known[number] if number in known else self._by_hull(group, members[k])[0]
                kind = "tips" if before.kind == "stands" else before.kind
                verdicts[number] = Balance(kind, before.beyond, before.shift)
        failing = {number for number, balance in verdicts.items() if balance.kind != "stands"}
        if failing:
            rough = self._slack(group, component, members, pivots, Perturbation(grip=math.inf))
            for k, number in enumerate(component):
                if number in failing and rough is not None and rough[k] <= _MAX_SLACK and worst[k] > 10.0 * _MAX_SLACK:
                    verdicts[number] = Balance("slides", verdicts[number].beyond, verdicts[number].shift)
        return [verdicts[number] for number in component]

    def _slack(
        self, group: IntArray, component: Sequence[int], members: Sequence[IntArray], pivots: BoolArray,
        trial: Perturbation,
    ) -> FloatArray | None:  # fmt: skip
        """Return the largest slack of each group, relative to its weight and size; None if it cannot be computed.

        ``pivots`` are groups whose moments balance themselves.
        """
        place = {number: k for k, number in enumerate(component)}
        weight = np.array([float(self.bodies.mass[rows].sum()) for rows in members])
        low = np.array([self.bodies.low[rows].min(axis=0) for rows in members])
        high = np.array([self.bodies.high[rows].max(axis=0) for rows in members])
        size, center = np.linalg.norm(high - low, axis=1), np.array([self.center_of(rows) for rows in members])
        unit = float(weight.max())
        entries: tuple[list[IntArray], list[IntArray], list[FloatArray]] = ([], [], [])
        columns = 0
        for link, friction in self._pushing(group, place, members, trial.grip):
            sides = [(place.get(int(group[body]), -1) if body != PLANE else -1) for body in (link.body, link.other)]
            cone = _cone(link.normal, friction)
            if min(sides) < 0 and abs(link.normal[1]) < _SIDEWAYS:
                # A fixed face does not pull down: that would wedge a box on a ledge between it and the wall beside it.
                sign = 1.0 if sides[0] >= 0 else -1.0
                cone[:, 1] = sign * np.maximum(sign * cone[:, 1], sign * link.normal[1])
            forces = np.repeat(cone, len(link.points), axis=0)
            middle = link.points.mean(axis=0)
            points = np.tile(middle + (1.0 - trial.inset) * (link.points - middle), (_RAYS, 1))
            for k, sign in zip(sides, (1.0, -1.0)):
                if k < 0:
                    continue
                moments = np.cross(points - center[k], forces) / size[k] * (not pivots[k])
                wrench = sign * np.concatenate([forces, moments], axis=1) * (unit / weight[k])
                entries[0].append(np.tile(np.arange(6 * k, 6 * k + 6), len(forces)))
                entries[1].append(np.repeat(np.arange(columns, columns + len(forces)), 6))
                entries[2].append(wrench.ravel())
            columns += len(forces)
        load = np.zeros((len(members), 6))
        load[:, 1] = 1.0
        arm = np.zeros((len(members), 3))
        arm[:, [0, 2]] = np.array(trial.shift) * (high - low)[:, [0, 2]]
        load[:, 3:] = np.cross(arm, [0.0, 1.0, 0.0]) / size[:, None] * ~pivots[:, None]
        if not columns:
            return np.ones(len(members))
        matrix = np.concatenate(entries[0]), np.concatenate(entries[1]), np.concatenate(entries[2])
        slack = least_slack(matrix, 6 * len(members), columns, load.ravel())
        return None if slack is None else np.asarray(np.abs(slack).reshape(-1, 6).max(axis=1), np.float64)

    def _pushing(
        self, group: IntArray, place: dict[int, int], members: Sequence[IntArray], grip: float
    ) -> Iterator[tuple[BodyContact, float]]:
        """Yield the contacts of the groups of a component, each once, with its coefficient of friction."""
        clamped = {id(link) for rows in members for link in self._clamping(rows, group)}
        seen: set[int] = set()
        for rows in members:
            for link, _ in self.links_of(rows.tolist(), group):
                if id(link) not in seen:
                    seen.add(id(link))
                    friction = _ROUGH if math.isinf(grip) else grip * self._friction(link)
                    yield link, 0.0 if id(link) in clamped else friction

    def _clamping(self, members: IntArray, group: IntArray) -> Iterator[BodyContact]:
        """Yield the contacts of a group with opposed parallel faces, sideways: nothing presses them together."""
        links = self.links_of(members.tolist(), group)
        sideways = [(link, normal) for link, normal in links if -_STEEP < normal[1] < _SIDEWAYS]
        normals = np.array([normal for _, normal in sideways]).reshape(-1, 3)
        flat = normals[:, [0, 2]] / np.maximum(np.linalg.norm(normals[:, [0, 2]], axis=1, keepdims=True), 1e-300)
        opposed = (flat @ flat.T < -PARALLEL) & (normals[:, None, 1] + normals[None, :, 1] <= _LEVEL)
        opposed = opposed.any(axis=1) if len(normals) else np.zeros(0, bool)
        for (link, _), is_clamp in zip(sideways, opposed.tolist(), strict=True):
            if is_clamp:
                yield link


_TIE = 1e-6  # of a unit normal: faces at 45 degrees are met along both axes
_DIRECTIONS = tuple(sign * axis for axis in np.eye(3)[[1, 0, 2]] for sign in (1.0, -1.0))


def _distances(hull: FloatArray, points: FloatArray) -> FloatArray:
    """Return the distances (K,) of points (K, 2) from the boundary of a polygon (N, 2), which may be one point."""
    sides = np.roll(hull, -1, axis=0) - hull
    offsets = points[:, None] - hull[None]
    along = (offsets * sides).sum(axis=2) / np.maximum((sides**2).sum(axis=1), 1e-300)
    gaps = offsets - np.clip(along, 0.0, 1.0)[..., None] * sides
    return np.asarray(np.linalg.norm(gaps, axis=2).min(axis=1), np.float64)


def _are_within(hull: FloatArray, points: FloatArray) -> BoolArray:
    """Return which points (K, 2) are in a convex polygon (N, 2), whichever way around its corners are."""
    sides = np.roll(hull, -1, axis=0) - hull
    offsets = points[:, None] - hull[None]
    turns = sides[:, 0] * offsets[..., 1] - sides[:, 1] * offsets[..., 0]
    return np.asarray((turns >= 0.0).all(axis=1) | (turns <= 0.0).all(axis=1), bool)


def _plane_normal(points: FloatArray, direction: FloatArray) -> FloatArray:
    """Return the normal of a flat set of points (K, 3), on the side of ``direction``; that itself if they are not."""
    _, extents, axes = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)
    if len(points) < 4 or extents[2] > _FLAT * extents[1]:
        return direction
    return np.asarray(axes[2] if axes[2] @ direction >= 0.0 else -axes[2], np.float64)


def _shifts_by(share: float) -> list[Perturbation]:
    """Return the four shifts of centers of mass by a share of the extents."""
    return [Perturbation((share * x, share * z)) for x, z in ((1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0))]


def _cone(normal: FloatArray, friction: float) -> FloatArray:
    """Return the rays (8, 3) of the friction cone of a contact."""
    angles = np.arange(_RAYS) * (2.0 * math.pi / _RAYS)
    circle = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    return np.asarray(normal + friction * (circle @ plane_axes(normal).T), np.float64)
