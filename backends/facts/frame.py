"""The facts of one frame: bodies, ground, contacts, what is fastened, and a verdict on every body.

Every check, declaration, filter, simulation and repair reads these; none decides anew what an object is, where the
ground is, or what stands.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from scenelang.backends.facts.bodies import BodySet, grouped, is_shape
from scenelang.backends.facts.contacts import Contacts, are_slim, area_of, axes_of, own_sides
from scenelang.backends.facts.ground import LOWEST_POINT, Ground, areas, ground_of, walls_of
from scenelang.backends.facts.statics import PLANE, STANDS, Balance, BodyContact, Statics, members_of
from scenelang.backends.facts.tolerances import (
    BRACKET_SPAN,
    BURIED,
    CAGE_DROP,
    CAGE_OVERLAP,
    CAGE_SIDES,
    CONTACT_ERROR,
    COURSE,
    GLUED_AREA,
    HIGH,
    HINGE_SPAN,
    JOINT,
    LINE,
    MAIN_CLUSTER,
    MOUNT_AREA,
    MOUNT_DEPTH,
    NEARLY,
    SET_IN,
    SLIM,
    SMALL_BASE,
    SNOW_COUNT,
    SNOW_SIZE,
    SUSPENSION_AREA,
    SUSPENSION_HEIGHT,
    UPRIGHT,
)
from scenelang.backends.surfaces.convex import Bodies, bodies_of, clusters
from scenelang.backends.surfaces.distance import IntArray
from scenelang.backends.surfaces.solids import FloatArray
from scenelang.interpreter.inspection.numbering import Ancestry, ancestry_of
from scenelang.interpreter.scene.entity import Entity, primitive_count

BoolArray = npt.NDArray[np.bool_]

_MAX_NAMED_SOLIDS = 200  # of a body whose lowest instance is looked up
_HOLDS = ("overlap", "joined", "glued")  # notes on bodies that stand if a doubtful hold is one
_ROUNDS = 6  # of fastening: each fastens what the one before left in the air; chains of holds are rarely longer


@dataclass(frozen=True, slots=True)
class Verdict:
    """What gravity does to a body.

    Attributes
    ----------
    kind
        "fixed", "supported", "floating" (no contacts lead to the ground), "tips", "slides" or "falls".
    note
        Why it may be meant nevertheless; empty if nothing says so.
    balance
        Balance of the bodies that it is fastened to, itself included.
    """

    kind: str
    note: str = ""
    balance: Balance = STANDS

    @property
    def holds(self) -> bool:
        """Whether the body stays where it is."""
        return self.kind in ("fixed", "supported")


class _Held(NamedTuple):
    """What holds without support from below.

    Attributes
    ----------
    group : (B,)
        Equal for bodies that are fastened to each other.
    balances
        Balance of each group.
    notes
        For bodies whose hold is doubtful: why.
    planted
        Bodies that the ground plane holds.
    """

    group: IntArray
    balances: dict[int, Balance]
    notes: dict[int, str]
    planted: frozenset[int]


class FrameFacts:
    """Facts of a frame, computed when they are asked for.

    Parameters
    ----------
    root
        Root of the frame.

    Raises
    ------
    SceneError
        For physics attributes or meshes that cannot be read.

    Examples
    --------
    >>> facts = FrameFacts(scene.frames[0])  # doctest: +SKIP
    >>> [verdict.kind for verdict in facts.verdicts]  # doctest: +SKIP
    ['supported', 'floating']
    """

    def __init__(self, root: Entity, solids: Bodies | None = None, ancestry: Ancestry | None = None) -> None:
        self.root = root
        self.solids = bodies_of(root) if solids is None else solids
        self.ancestry = ancestry_of(root) if ancestry is None else ancestry
        self._before: FrameFacts | None = None
        self._moved: BoolArray | None = None

    def moved(self, rows: IntArray, move: tuple[float, float, float]) -> FrameFacts:
        """Return the facts of the frame with some solids (K,) translated; what did not move is not computed again."""
        matrices, worlds = self.solids.solids.matrices.copy(), self.solids.worlds.copy()
        matrices[rows, :, 3] += move
        worlds[rows, :, 3] += move
        solids = replace(self.solids, solids=replace(self.solids.solids, matrices=matrices), worlds=worlds)
        solids.surfaces.update(self.solids.surfaces)
        is_moved = np.isin(np.arange(len(solids)), rows)
        leaves = self.ancestry.primitives[self.solids.row]
        (_, moved), (_, still) = self.ancestry.ranges(leaves[is_moved]), self.ancestry.ranges(leaves[~is_moved])
        poses = self.ancestry.poses.copy()
        poses[(moved >= 0) & (still < 0), :, 3] += move
        facts = FrameFacts(self.root, solids, replace(self.ancestry, poses=poses))
        facts._before, facts._moved = self, is_moved
        return facts

    @cached_property
    def contacts(self) -> Contacts:
        """The contacts of all solids."""
        return Contacts(self.solids, None if self._before is None else self._before.contacts, self._moved)

    @cached_property
    def bodies(self) -> BodySet:
        """The bodies."""
        return grouped(self.solids, self.ancestry, self.contacts)

    @cached_property
    def ground(self) -> Ground:
        """The ground."""
        child = self.ancestry.at_depth(1)[self.ancestry.primitives[self.solids.row]]
        return ground_of(self.solids, self.bodies, child)

    @cached_property
    def fixed(self) -> BoolArray:
        """Bodies (B,) that need no support: by attribute, the ground, and walls that close the scene off."""
        held = self.ground.solids | walls_of(self.solids, self.contacts) | self.inlays
        if len(self.bodies) > 1:  # a lone panel is no wall
            held = held & ~self.bodies.loose[self.bodies.body]
            return np.asarray(self.bodies.fixed | (np.bincount(self.bodies.body, held, len(self.bodies)) > 0), bool)
        return self.bodies.fixed

    @cached_property
    def inlays(self) -> BoolArray:
        """Solids (N,) that end at the ground plane from below, within their height, such as paving and foundations."""
        low, high = self.solids.boxes
        depth = self.ground.height - high[:, 1]
        deep = low[:, 1] < self.ground.height - self.solids.touch
        return np.asarray(deep & (depth >= -self.solids.touch) & (depth <= (high - low)[:, 1]), bool)

    @cached_property
    def statics(self) -> Statics:
        """The contacts of bodies and their balance."""
        before = None if self._before is None else self._before.statics
        return Statics(self.solids, self.bodies, self.contacts, self.ground, self.fixed, (before, self._moved))

    @cached_property
    def grounded(self) -> BoolArray:
        """Bodies (B,) that contacts connect to the ground, to a body that attributes hold, or to a row that holds."""
        grounded = self.statics.grounded(self.bodies.floating)
        rows = self._in_rows(~grounded)  # what lies on the middle planks of a sledge
        return self.statics.grounded(self.bodies.floating | rows) if rows.any() else grounded

    def _in_rows(self, failing: BoolArray) -> BoolArray:
        """Return which failing bodies (B,) are beside or above an equal one that holds: slats, tiles, courses."""
        in_row = np.zeros(len(self.bodies), bool)
        alike: dict[object, list[int]] = {}
        for body in range(len(self.bodies)) if failing.any() else ():
            alike.setdefault((int(self.bodies.joined[body]), self._likeness(body)), []).append(body)
        for row in alike.values():
            stack = [body for body in row if not failing[body]]
            waiting = [body for body in row if failing[body]]
            while stack and waiting:
                current = stack.pop()
                near = [body for body in waiting if self._is_beside(body, current)]
                in_row[near] = True
                waiting = [body for body in waiting if body not in near]
                stack += near
        return in_row

    def _is_beside(self, body: int, other: int) -> bool:
        """Return whether two equal bodies are beside or above each other with a joint between them."""
        bodies = self.bodies
        gap = np.maximum(bodies.low[body] - bodies.high[other], bodies.low[other] - bodies.high[body])
        level = abs(float(bodies.low[body, 1] - bodies.low[other, 1])) <= self.solids.touch
        joint = np.array([JOINT, 0.0 if level else COURSE, JOINT]) * bodies.size[body]
        return bool((level or gap[1] > self.solids.touch) and (np.maximum(gap, 0.0) <= joint).all())

    @cached_property
    def _held(self) -> _Held:
        """Bodies that are fastened to each other, because they would not stay otherwise."""
        count, pairs, planted = len(self.bodies), list[tuple[int, int]](), set[int]()
        notes: dict[int, str] = {}
        group = np.arange(count)
        balances = self.statics.balances(group, self.grounded)
        unbalanced = np.array([balances.get(body, STANDS).kind != "stands" for body in range(count)], bool)
        braced = self._in_rows(unbalanced & self.grounded)
        if braced.any():
            balances = self.statics.balances(group, self.grounded, braced)
        # What is glued may need its planted posts, and may carry what is mounted on it.
        for holds in (self._joints, self._mounts, self._glued, self._joints, self._mounts):
            for _ in range(_ROUNDS):
                failing = {number for number, balance in balances.items() if balance.kind != "stands"}
                fresh: list[tuple[int, int]] = []
                rows_of = members_of(group)
                for number in sorted(failing):
                    members = rows_of[number]
                    for link, note in holds(members, group):
                        other = link.other if link.body in members else link.body
                        if holds != self._joints and other != PLANE and int(group[other]) in failing:
                            continue  # it falls itself
                        fresh.append((link.body, link.other))
                        if note:
                            notes |= dict.fromkeys(members.tolist(), note)
                if not fresh:
                    break
                pairs += fresh
                group = clusters(count, [pair for pair in pairs if pair[1] != PLANE])
                planted |= {body for body, other in fresh if other == PLANE}
                balances = self.statics.balances(group, self.grounded, braced)
                balances |= {int(group[body]): STANDS for body in planted}
        return _Held(group, balances, notes, frozenset(planted))

    @property
    def planted(self) -> frozenset[int]:
        """Bodies that are set deep into the ground plane, which holds them."""
        return self._held.planted

    @property
    def fastened(self) -> IntArray:
        """Groups (B,) of bodies that are fastened to each other: embedded, mounted, suspended or joined."""
        return self._held.group

    # --- what holds without support from below -----------------------------------------------------------------------

    def _joints(self, members: IntArray, group: IntArray) -> Iterator[tuple[BodyContact, str]]:
        """Yield the overlaps that hold a group: it is set in, or set into what it holds on to."""
        if self.bodies.loose[members].any():
            return
        for link, normal in self.statics.links_of(members.tolist(), group):
            inner = link.body if link.body in members else link.other
            if link.row < 0:
                if link.depth >= SET_IN * self.bodies.size[inner, 1] and self._has_slim_foot(inner):
                    yield link, ""
                continue
            if link.depth <= self.contacts.room[link.row]:
                continue
            if abs(normal[1]) >= UPRIGHT and not self._is_set_in(link, inner):
                continue  # a seam under what stands on something
            yield link, "" if self.is_enclosed(link.row, link.normal) or self.is_threaded(link.row) else "overlap"

    def is_threaded(self, row: int) -> bool:
        """Return whether one solid of a contact is a rod or a line: what hangs on it, or is threaded by it, holds."""
        return bool(are_slim(self.solids, self.contacts.pairs[row]).any())

    def _is_set_in(self, link: BodyContact, inner: int) -> bool:
        """Return whether a body is set into what is below or above it: deep, or a rod in a hole, or a ball on a rod."""
        pair = self.contacts.pairs[link.row]
        if self.ground.solids[pair].any() and self._has_slim_foot(inner):
            return bool(link.depth >= SET_IN * self.bodies.size[inner, 1])
        if self.is_threaded(link.row) and link.depth >= BURIED * float(own_sides(self.solids, pair).min()):
            return True
        rounded = self.solids.solids.that_are("is_rounded")[pair].any()
        deep = link.depth >= SET_IN * self.bodies.size[inner].max()
        return bool((rounded and deep) or link.depth >= BURIED * self.bodies.size[inner, 1])

    def _has_slim_foot(self, body: int) -> bool:
        """Return whether a body enters the ground by one slim foot, or a round one."""
        rows = self.bodies.members[body]
        low, high = self.solids.boxes
        below = rows[low[rows, 1] < self.ground.height]
        if not len(below):
            return False
        foot = float((high[below].max(axis=0) - low[below].min(axis=0))[[0, 2]].max())
        height = float(self.bodies.size[body, 1])
        return bool(self.solids.solids.that_are("is_rounded")[below].all()) or height >= SLIM * foot

    def is_enclosed(self, row: int, normal: FloatArray) -> bool:
        """Return whether one solid of a contact lies within the other, seen along a normal."""
        low, high = self.solids.boxes
        across = [k for k in range(3) if k != int(np.argmax(np.abs(normal)))]
        i, j = self.contacts.pairs[row].tolist()
        room = float(self.contacts.room[row])
        return any(
            bool(((low[a] >= low[b] - room) & (high[a] <= high[b] + room))[across].all()) for a, b in ((i, j), (j, i))
        )

    def _mounts(self, members: IntArray, group: IntArray) -> Iterator[tuple[BodyContact, str]]:
        """Yield the contacts by which a group is hung on a face with its back, or suspended by a point of its top."""
        low, high = self.bodies.low[members].min(axis=0), self.bodies.high[members].max(axis=0)
        size = np.maximum(high - low, 1e-300)
        for link, normal in self.statics.links_of(members.tolist(), group):
            if link.row < 0:
                continue
            body, other = (link.body, link.other) if link.body in members else (link.other, link.body)
            if self.bodies.loose[body]:
                continue
            axis = int(np.argmax(np.abs(normal)))
            is_flat = size[axis] <= MOUNT_DEPTH * float(np.delete(size, axis).max())
            back = area_of(link.points, normal)
            if normal[1] < -0.5 and not self.fixed[other]:
                is_flat = False  # only a ceiling holds what is below it by its back
            is_slim = size[1] >= SLIM * float(size[[0, 2]].min())  # a rope is held by its whole section
            sides = self.bodies.size[body]
            is_line = sides[1] >= LINE * float(sides[[0, 2]].max())
            is_point = is_slim or back <= SUSPENSION_AREA * float(size[[0, 2]].prod())
            if (is_flat and normal[1] < 0.5 and back >= MOUNT_AREA * self._side_of(link, members, axis)) or (
                float(link.points[:, 1].max()) >= high[1] - SUSPENSION_HEIGHT * size[1]
                and (is_line or (is_point and normal[1] < -0.5))
            ):
                yield link, ""

    def _side_of(self, link: BodyContact, members: IntArray, axis: int) -> float:
        """Return the area of the side of the touching solid of a group, seen along an axis."""
        first = int(self.contacts.pairs[link.row, 0])
        return self._sides_of(link, axis)[0 if self.bodies.body[first] in members else 1]

    def _sides_of(self, link: BodyContact, axis: int) -> list[float]:
        """Return the areas of the sides of both touching solids, seen along an axis."""
        low, high = self.solids.boxes
        return [float(np.delete((high - low)[i], axis).prod()) for i in self.contacts.pairs[link.row].tolist()]

    def _glued(self, members: IntArray, group: IntArray) -> Iterator[tuple[BodyContact, str]]:
        """Yield the contacts of a group that could be glue or hinges, and its joints in the other reading of bodies."""
        if self.bodies.loose[members].any():
            return
        sideways: list[BodyContact] = []
        for link, normal in self.statics.links_of(members.tolist(), group):
            if link.row < 0:
                continue
            body, other = (link.body, link.other) if link.body in members else (link.other, link.body)
            if self.bodies.joined[body] == self.bodies.joined[other]:
                yield link, "joined"
            elif normal[1] < UPRIGHT and (normal[1] > -0.5 or self.fixed[other]):
                sideways.append(link)
                side = min(self._sides_of(link, int(np.argmax(np.abs(normal)))))
                if area_of(link.points, normal) >= GLUED_AREA * side:
                    yield link, "glued"
        if sideways:
            span = np.ptp(np.concatenate([link.points for link in sideways]), axis=0)
            extent = self.bodies.extent(members)
            across = [k for k in (0, 2) if k != int(np.argmax(np.abs(sideways[0].normal)))]
            is_hung = not any(self._stands_on(link, members) for body in members for link in self.statics.of_body[body])
            is_broad = is_hung and bool((span[across] >= BRACKET_SPAN * extent[across]).any())
            if is_broad or span[1] >= HINGE_SPAN * extent[1]:
                yield sideways[0], "glued"

    def words_of(self, body: int) -> tuple[str, ...]:
        """Return the words from the root's child to a body: to the lowest instance with a word that contains it."""
        ancestry, instance = self.ancestry, self._named_instance(body)
        words = []
        while ancestry.parent[instance] >= 0:
            words.append(ancestry.entity(instance).word)
            instance = int(ancestry.parent[instance])
        return tuple(reversed(words))

    def _named_instance(self, body: int) -> int:
        """Return the lowest instance with a word that contains the solids of a body."""
        rows = self.ancestry.primitives[self.solids.row[self.bodies.members[body]]]
        whole = int(self.bodies.instance[body])
        if len(rows) > _MAX_NAMED_SOLIDS:
            return whole
        chains = [self.ancestry.path_of_instances(int(row)) for row in rows]
        shared = [steps[0] for steps in zip(*chains) if len(set(steps)) == 1]
        named = [step for step in shared if not is_shape(self.ancestry.entity(step))]
        return named[-1] if len(named) > 1 else whole

    # --- verdicts ----------------------------------------------------------------------------------------------------

    @cached_property
    def verdicts(self) -> list[Verdict]:
        """One verdict for each body."""
        plain = [self._verdict(body) for body in range(len(self.bodies))]
        rows = self._in_rows(np.array([not verdict.holds and verdict.note not in _HOLDS for verdict in plain], bool))
        return [Verdict("supported") if rows[body] else verdict for body, verdict in enumerate(plain)]

    def _verdict(self, body: int) -> Verdict:
        """Return the verdict on a body, as if it were in no row of equals."""
        group, balances, notes, _ = self._held
        if self.fixed[body] or self.bodies.floating[body]:
            return Verdict("fixed")
        if not self.grounded[body]:
            return Verdict("floating", self._why_floating.get(body, ""))
        balance, note = balances.get(int(group[body]), STANDS), notes.get(body, "")
        if balance.kind != "stands":
            members = np.flatnonzero(group == group[body])
            why = self._why_falling(members)
            is_near = balance.kind == "tips" and self._is_on_its_edge(members, balance)
            return Verdict(balance.kind, why or ("on its edge" if is_near else ""), balance)
        # It stands only if the doubtful hold is one.
        return Verdict("falls", note) if note else Verdict("supported", "", balance)

    def _is_on_its_edge(self, members: IntArray, balance: Balance) -> bool:
        """Return whether a group with flat feet tips by so little that it may be rounding; what is round would roll."""
        rows = {link.row for body in members for link in self.statics.of_body[int(body)] if link.row >= 0}
        touching = self.contacts.pairs[sorted(rows)]
        own = touching[np.isin(self.bodies.body[touching], members)]
        form = self.solids.solids
        rolls = form.that_are("is_rounded")[own] | (form.that_are("is_curved")[own] & self._lies(own))
        return not rolls.any() and 0.0 < balance.beyond <= NEARLY * float(self.bodies.extent(members)[[0, 2]].max())

    def _lies(self, rows: IntArray) -> BoolArray:
        """Return whether the axes (K,) of round solids are level, so that they may roll."""
        return np.asarray(np.abs(axes_of(self.solids, rows)[:, 1]) < 1.0 - UPRIGHT, bool)

    @cached_property
    def narrow(self) -> BoolArray:
        """Bodies (B,) that hold with little balance: a simulation, whose contacts give way, may move them."""
        group, balances, notes, _ = self._held
        doubtful = np.isin(np.arange(len(self.bodies)), [body for body, note in notes.items() if note])
        return self.statics.are_narrow(group, balances, doubtful)

    @cached_property
    def immersed(self) -> BoolArray:
        """Bodies (B,) that overlap one that light passes: boats and fish in water, which carries them."""
        opaque, pairs = self.solids.opaque, self.contacts.pairs
        rows = np.flatnonzero(opaque[pairs[:, 0]] != opaque[pairs[:, 1]])
        depths, _ = self.contacts.depths(rows)
        deep = pairs[rows[depths > CONTACT_ERROR * self.contacts.room[rows]]]
        immersed = np.zeros(len(self.bodies), bool)
        immersed[self.bodies.body[np.where(opaque[deep[:, 0]], deep[:, 0], deep[:, 1])]] = True
        return immersed

    @cached_property
    def is_adrift(self) -> bool:
        """Whether most of the scene is one object around the origin without a base, as an aircraft in flight."""
        low, high = self.solids.boxes
        _, counts = np.unique(self.clusters[self.bodies.body], return_counts=True)
        if self.ground.reason != LOWEST_POINT or counts.max() <= MAIN_CLUSTER * len(low):
            return False
        lowest = low[:, 1] <= low[:, 1].min() + self.solids.touch
        base, area = float(areas(low, high)[lowest].sum()), float(areas(low.min(axis=0), high.max(axis=0)))
        straddles = bool(low[:, 1].min() < -self.solids.touch and high[:, 1].max() > self.solids.touch)
        return straddles and base < SMALL_BASE * area

    def _why_falling(self, members: IntArray) -> str:
        """Return why bodies without balance may be meant; empty if nothing says so."""
        if self.is_adrift:
            return "around the origin"
        low, high = self.bodies.low[members].min(axis=0), self.bodies.high[members].max(axis=0)
        if self._is_caged(members, low, high):
            return "in a case"
        whole = np.flatnonzero(np.isin(self.bodies.joined, self.bodies.joined[members]) & self.grounded)
        if len(whole) > len(members) and len(np.unique(self.bodies.joined[members])) == 1:
            group = np.where(np.isin(np.arange(len(self.bodies)), whole), int(whole[0]), self._held.group)
            balances = self.statics.balances(group, np.isin(np.arange(len(self.bodies)), whole))
            if balances.get(int(whole[0]), STANDS).kind == "stands":
                return "joined"
        if self._is_anchored(members):
            return "anchored"
        if self.statics.settles(members, self._held.group):
            return "it settles"
        if len(members) > 1:  # only within one body is the foot a part that may be heavier
            return ""
        return "heavy foot" if self.statics.stands_on_heavy_foot(members, self._held.group) else ""

    def _is_anchored(self, members: IntArray) -> bool:
        """Return whether a group stands by upright posts that are narrow for its height: a flag, a sign, a street lamp.

        A broad foot that lies on the ground is not set into it.
        """
        low, high = self.solids.boxes
        rows = np.concatenate([self.bodies.members[int(body)] for body in members])
        feet = rows[low[rows, 1] <= low[rows, 1].min() + self.solids.touch]
        links = [link for body in members for link in self.statics.of_body[int(body)]]
        if not any(self._stands_on(link, members) for link in links):
            return False
        axes = self.solids.solids.matrices[feet, :, 1]
        upright = bool((np.abs(axes[:, 1]) >= 0.999 * np.linalg.norm(axes, axis=1)).all())
        height, sides = float(high[rows, 1].max() - low[rows, 1].min()), (high - low)[feet]
        are_posts = bool((sides[:, 1] >= sides[:, [0, 2]].max(axis=1)).all())
        breadth = float((high[feet].max(axis=0) - low[feet].min(axis=0))[[0, 2]].max())
        return upright and are_posts and height >= SLIM * breadth

    @staticmethod
    def _stands_on(link: BodyContact, members: IntArray) -> bool:
        """Return whether a contact carries a group from below, from the ground or another body."""
        other, normal = (link.other, link.normal) if link.body in members else (link.body, -link.normal)
        return bool(normal[1] > 0.5 and (other == PLANE or other not in members))

    @property
    def clusters(self) -> IntArray:
        """Groups (B,) of bodies that contacts connect."""
        return self.statics.clusters

    @cached_property
    def _why_floating(self) -> dict[int, str]:
        """For bodies without support that may be meant: why."""
        bodies, loose = self.bodies, np.flatnonzero(~self.grounded & ~self.fixed)
        reasons: dict[int, str] = {}
        top = float(bodies.high[self.grounded, 1].max()) if self.grounded.any() else -np.inf
        keys = {body: self._likeness(body) for body in loose.tolist()}
        counts = Counter(keys.values())
        for number in np.unique(self.clusters[loose]).tolist():
            members = np.flatnonzero(self.clusters == number)
            low, high = bodies.low[members].min(axis=0), bodies.high[members].max(axis=0)
            height, size = float(high[1] - low[1]), float(np.linalg.norm(high - low))
            first = int(members[0])
            if len(members) == 1 and counts[keys[first]] >= SNOW_COUNT and size <= SNOW_SIZE * self.solids.size:
                reason = "one of many"
            elif low[1] > top + max(height, HIGH * (top - self.ground.height)):
                reason = "above everything that stands"
            elif self._is_caged(members, low, high):
                reason = "in a case"
            else:
                continue
            reasons |= dict.fromkeys(members.tolist(), reason)
        flying = {keys[body] for body, reason in reasons.items() if reason == "above everything that stands"}
        return reasons | {body: "as its equals" for body, key in keys.items() if body not in reasons and key in flying}

    def _likeness(self, body: int) -> tuple[object, ...]:
        """Return a key that equal bodies share: their primitives and sizes."""
        rows = self.bodies.members[body]
        size = np.round(self.bodies.size[body] / max(self.solids.touch, 1e-300))
        return tuple(self.solids.solids.forms[rows].tolist()), tuple(np.sort(size).tolist())

    def _is_caged(self, members: IntArray, low: FloatArray, high: FloatArray) -> bool:
        """Return whether bodies are enclosed on three sides, and would drop by little."""
        others = np.setdiff1d(np.arange(len(self.solids)), np.concatenate([self.bodies.members[m] for m in members]))
        (under, over), reach = self.solids.boxes, CAGE_DROP * (high - low)
        sides, size = 0, np.maximum(high - low, 1e-300)
        shared = (np.minimum(over[others], high) - np.maximum(under[others], low)) / size
        for axis in range(3):
            beside = (np.delete(shared, axis, axis=1) >= CAGE_OVERLAP).all(axis=1)
            for gap in (low[axis] - over[others, axis], under[others, axis] - high[axis]):
                sides += bool((beside & (gap >= -self.solids.touch) & (gap <= reach[axis])).any())
        below = ((under[others] < high) & (over[others] > low))[:, [0, 2]].all(axis=1)
        drop = low[1] - over[others][below & (over[others, 1] <= low[1] + self.solids.touch), 1]
        return sides >= CAGE_SIDES and bool((drop <= reach[1]).any())


# Frames whose facts are kept: as many as the lint checks of a video, without those whose tables take many megabytes.
_KEPT_FRAMES = 12
_MAX_KEPT_PRIMITIVES = 2_000


def facts_of(root: Entity) -> FrameFacts:
    """Return the facts of a frame; those of the last small frames are kept, since several checks read them in turn."""
    return _kept_facts(root) if primitive_count(root) <= _MAX_KEPT_PRIMITIVES else FrameFacts(root)


@lru_cache(maxsize=_KEPT_FRAMES)
def _kept_facts(root: Entity) -> FrameFacts:
    return FrameFacts(root)
