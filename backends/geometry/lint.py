"""Geometric checks of one frame: what floats, is sunk, would fall, overlaps, is hidden or there twice, or z-fights.

All rules read the facts of the frame (``backends/facts``); the constants are in its table. Findings that may be meant
are notes: words and doubtful readings only soften a finding. Minecraft blocks, which replace earlier ones, are skipped.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from scenelang.backends.facts.bodies import is_shape
from scenelang.backends.facts.contacts import are_slim, axes_of
from scenelang.backends.facts.frame import FrameFacts, Verdict, facts_of
from scenelang.backends.facts.statics import PLANE
from scenelang.backends.facts.tolerances import (
    BURIED,
    CONTACT_ERROR,
    COPLANAR_AREA,
    DETOUR,
    EDGE_AREA,
    PARALLEL,
    PLANTED,
    SEAM,
    SHALLOW,
    SLIM,
    SOFT,
    SUNK_BASE,
    TOUCH_OF_SOLIDS,
    UPRIGHT,
)
from scenelang.backends.facts.words import flies, is_soft
from scenelang.backends.geometry.coplanar import coplanar_pairs, faces_of
from scenelang.backends.geometry.hidden import duplicates, hidden_solids
from scenelang.backends.geometry.intention import intentions
from scenelang.backends.geometry.trials import helpful_move
from scenelang.backends.surfaces.convex import MAX_PAIRS, Bodies, hull_of
from scenelang.backends.surfaces.distance import IntArray, distances
from scenelang.backends.surfaces.marks import Marks
from scenelang.backends.surfaces.solids import FloatArray
from scenelang.grammar.datum import Span
from scenelang.grammar.diagnostics import Diagnostic, Note
from scenelang.interpreter.scene.entity import Entity, Scene, primitive_count

Vector = tuple[float, float, float]

MAX_PRIMITIVES = 100_000  # of a frame that is checked
_MIN_CHECKED_FRAMES = 6  # of a video that are checked, however large they are
_MAX_CHECKED_FRAMES = 12  # of a video: a finding counts if it holds in most, and a frame takes up to a second
_MAX_TOTAL_PRIMITIVES = 100_000  # of all checked frames together
_MAX_DIAGNOSTICS = 20  # findings of a report; further ones are counted
_MIN_EQUALS = 3  # siblings that tell what is meant; two may share a slip
_SURE = 0.8  # confidence from which an outlier is a warning
_MAX_NEAREST = 16  # solids, nearest by their boxes, of which the nearest is chosen by exact distances
_MAX_MARKED = 50  # objects of a finding that are marked
_MAX_MOVES = 4  # findings of a scene for which moves are tried, the gravest


@dataclass(frozen=True, slots=True)
class Finding:
    """Suspicious configuration.

    Attributes
    ----------
    kind
        "twin", "hidden", "deep", "sunk", "floating", "tips", "slides", "falls", "outlier" or "coplanar".
    body, other
        Solids: one of its subject, and one that the subject is near or in.
    amount
        Length in scene units; for coplanar faces an area.
    move
        Translation that would fix it, not yet tried.
    shift
        Translation of the subject's center of mass alone that would balance it.
    note
        Why it may be meant; empty for a warning.
    whole
        Whether a duplicate is a whole object.
    evidence
        What tells an outlier among its siblings; empty for other kinds.
    instance
        The outlier, which may be a part of its body; None for other kinds.
    """

    kind: str
    body: int
    other: int | None
    amount: float
    move: Vector | None = None
    shift: Vector | None = None
    note: str = ""
    whole: bool = False
    evidence: str = ""
    instance: int | None = None


_KINDS = ("twin", "hidden", "deep", "sunk", "tips", "slides", "falls", "floating", "outlier", "coplanar")


def _gravity(finding: Finding) -> tuple[bool, int, float]:
    """Return a key that sorts findings, the gravest first: warnings before notes, by kind and amount."""
    return bool(finding.note), _KINDS.index(finding.kind), -finding.amount


class CheckedFrame:
    """Frame with its facts and one finding for each misplaced object, the gravest first."""

    def __init__(self, root: Entity, facts: FrameFacts | None = None) -> None:
        self.facts = facts_of(root) if facts is None else facts

    @property
    def solids(self) -> Bodies:
        """The solids of the frame."""
        return self.facts.solids

    @cached_property
    def findings(self) -> list[Finding]:
        """Findings about the frame: warnings before notes, the gravest first."""
        if not len(self.solids):
            return []
        every = [self._softened(finding) for finding in self._every()]
        ranked: dict[tuple[object, ...], Finding] = {}
        for finding in sorted(every, key=_gravity):
            # The mirror image of what is sunk is not out of place itself.
            other = finding.other if finding.kind == "outlier" else None
            if other is None or ("place", int(self.facts.bodies.body[other])) not in ranked:
                ranked.setdefault(self._key(finding), finding)
        return list(ranked.values())

    def _key(self, finding: Finding) -> tuple[object, ...]:
        """Return a key by which a body has one finding about its place, and one about its size or turn."""
        body = int(self.facts.bodies.body[finding.body])
        if finding.kind == "outlier" and finding.move is None:
            return finding.kind, body
        if finding.kind in ("coplanar", "hidden"):
            return finding.kind, finding.body
        return "place", body

    def _every(self) -> Iterator[Finding]:
        """Yield all findings."""
        twins = self._duplicates()
        yield from twins
        known = {frozenset((f.body, f.other)) for f in twins if f.other is not None}
        pairs = self.facts.contacts.pairs
        fresh = np.array([pair for pair in pairs.tolist() if frozenset(pair) not in known], np.int64).reshape(-1, 2)
        hidden = hidden_solids(self.facts, fresh)
        for inner, outer in hidden.items():
            yield Finding("hidden", inner, outer, self._least_side(inner))
        twin_bodies = {frozenset(self.facts.bodies.body[list(pair)].tolist()) for pair in known}
        yield from self._overlaps(hidden, twin_bodies)
        yield from self._unsupported()
        yield from self._outliers()
        side = np.sort(self.solids.boxes[1].max(axis=0) - self.solids.boxes[0].min(axis=0))
        for i, j, area, move in coplanar_pairs(self.solids, fresh):
            small = area < COPLANAR_AREA * float(side[1] * side[2])
            note = "small" if small else "an edge" if self._is_edge(i, area) or self._is_edge(j, area) else ""
            yield Finding("coplanar", j, i, area, move, note=note)

    def _outliers(self) -> Iterator[Finding]:
        """Yield the objects that differ from their siblings."""
        for outlier in intentions(self.facts):
            note = "" if outlier.confidence >= _SURE else "a guess"
            first, other = int(outlier.rows[0]), next(iter(outlier.counterpart), None)
            yield Finding(
                "outlier", first, other, 0.0, outlier.move, note=note, evidence=outlier.evidence,
                instance=outlier.instance,
            )  # fmt: skip

    def _is_edge(self, i: int, area: float) -> bool:
        """Return whether an area is small for the largest side of a solid's box: the edge of a board, not its face."""
        low, high = self.solids.boxes
        sides = np.sort((high - low)[i])
        return bool(area <= EDGE_AREA * sides[1] * sides[2])

    def _least_side(self, i: int) -> float:
        """Return the shortest side of a solid's box."""
        low, high = self.solids.boxes
        return float((high[i] - low[i]).min())

    # --- overlaps ----------------------------------------------------------------------------------------------------

    def _duplicates(self) -> list[Finding]:
        """Return duplicates: one for each body all of whose solids have an equal, else one for each solid."""
        pairs, body = duplicates(self.facts), self.facts.bodies.body
        copies = Counter(map(tuple, body[pairs].tolist()))
        copies_of: dict[object, Finding] = {}
        for i, j in pairs.tolist():
            first, second = int(body[i]), int(body[j])
            whole = first != second and copies[first, second] == len(self.facts.bodies.members[second])
            key = ("body", second) if whole else ("solid", j)
            note = "part of one body" if first == second else ""
            copies_of.setdefault(key, Finding("twin", j, i, self._least_side(i), note=note, whole=whole))
        return list(copies_of.values())

    def _overlaps(self, hidden: dict[int, int], twins: set[frozenset[int]]) -> Iterator[Finding]:
        """Yield bodies that are sunk into what they stand on, and pairs of bodies that are in each other."""
        facts, deepest = self.facts, dict[tuple[int, int], Finding]()
        group = facts.fastened
        for link in facts.statics.links:
            pair = frozenset((link.body, link.other))
            if link.depth <= 0.0 or pair in twins:
                continue
            if link.other == PLANE:
                finding = self._sunk(link.body, None, link.depth, None)
            else:
                i, j = facts.contacts.pairs[link.row].tolist()
                if {i, j} & hidden.keys() or not self._shows(i, j) or self._are_one(link.body, link.other):
                    continue
                finding = self._overlap(link.row, joined=bool(group[link.body] == group[link.other]))
            if finding is None:
                continue
            if finding.kind == "deep" and pair in self._bearings:
                finding = replace(finding, note=finding.note or "a rod")
            other = -1 if finding.other is None else int(facts.bodies.body[finding.other])
            key = (int(facts.bodies.body[finding.body]), other)
            if key not in deepest or _gravity(finding) < _gravity(deepest[key]):
                deepest[key] = finding
        yield from self._as_their_equals(list(deepest.values()))

    def _as_their_equals(self, findings: Sequence[Finding]) -> Iterator[Finding]:
        """Yield findings, as notes where all equals of a body are as deep in others: a slip moves one of them."""
        body = self.facts.bodies.body
        deep: dict[int, list[Finding]] = {}
        for finding in findings:
            if finding.kind == "deep" and finding.other is not None:
                deep.setdefault(int(self._entity[body[finding.body]]), []).append(finding)
        for finding in findings:
            alike = deep.get(int(self._entity[body[finding.body]]), []) if finding.kind == "deep" else []
            amounts = [other.amount for other in alike]
            bodies = {int(body[other.body]) for other in alike}
            if len(bodies) >= _MIN_EQUALS and len(bodies) == len(self._equals(int(body[finding.body]))):
                if max(amounts) - min(amounts) <= 2.0 * self.solids.touch:
                    finding = replace(finding, note=finding.note or "as its equals")
            yield finding

    @cached_property
    def _entity(self) -> IntArray:
        """Return the number (B,) of the entity of each body: that of equal ones is equal."""
        return np.asarray(self.facts.ancestry.node[self.facts.bodies.instance], np.int64)

    @cached_property
    def _bearings(self) -> set[frozenset[int]]:
        """Return the pairs of bodies with round parts on one axis: an axle crosses the spokes of its wheel too."""
        facts, pairs = self.facts, self.facts.contacts.pairs
        round_ones = self.solids.solids.that_are("is_curved")
        rows = [k.row for k in facts.statics.links if k.row >= 0 and k.depth > 0.0 and round_ones[pairs[k.row]].all()]
        return {frozenset(facts.bodies.body[pairs[row]].tolist()) for row in rows if self._are_coaxial(*pairs[row])}

    def _are_coaxial(self, i: int, j: int) -> bool:
        """Return whether the axes of two round solids lie on one line."""
        first, second = axes_of(self.solids, np.array([i, j]))
        low, high = self.solids.boxes
        offset = (low + high)[j] / 2.0 - (low + high)[i] / 2.0
        apart = float(np.linalg.norm(offset - (offset @ first) * first))
        return abs(float(first @ second)) >= PARALLEL and apart <= self.solids.touch

    def _are_one(self, body: int, other: int) -> bool:
        """Return whether two bodies are one in the other reading, or parts of one that attributes hold in the air."""
        bodies, parent = self.facts.bodies, self.facts.ancestry.parent
        if bodies.joined[body] == bodies.joined[other]:
            return True
        return bool(
            bodies.floating[[body, other]].all() and parent[bodies.instance[body]] == parent[bodies.instance[other]]
        )

    def _shows(self, i: int, j: int) -> bool:
        """Return whether an overlap of two solids can be judged: both are opaque or solid, and their shapes known."""
        solids = self.solids
        known = solids.exact[[i, j]] | solids.hollow[[i, j]]
        return bool(known.all())

    def _overlap(self, row: int, *, joined: bool) -> Finding | None:
        """Return the finding about two overlapping solids of two bodies, None if they may overlap so."""
        facts, contacts = self.facts, self.facts.contacts
        i, j = contacts.pairs[row].tolist()
        depth, along = contacts.depth(row), contacts.along(row)
        if depth <= CONTACT_ERROR * contacts.room[row]:
            return None
        low, high = self.solids.boxes
        upper, lower = self._upper(i, j)
        bodies = facts.bodies.body[[upper, lower]].tolist()
        on_ground = bool(facts.ground.solids[lower])
        # The shortest way out of the ground is sideways for a post that is deeper in it than thick.
        is_planted = on_ground and self._is_level(lower, 1.0)
        if (abs(along[1]) >= UPRIGHT or is_planted) and not facts.fixed[bodies[0]]:
            beside = float(high[lower, 1] - facts.bodies.low[bodies[0], 1]) > 2.0 * depth  # of two chairs in each other
            if on_ground or not (joined or facts.ground.solids[upper] or beside):
                level = self._is_level(lower, 1.0) and (self._is_level(upper, -1.0) or self._is_round(upper))
                if on_ground or (level and not self._is_narrower(lower, upper)):
                    return self._sunk(bodies[0], lower, depth, upper)
                return None
        if joined or self.facts.ground.solids[[i, j]].any():
            return None
        thin = min(float(np.abs(along) @ (high - low)[k]) for k in (i, j))
        if depth <= SHALLOW * thin:
            return None
        subject, other = self._smaller(i, j)
        sign = 1.0 if subject == j else -1.0
        x, y, z = (sign * depth * along).tolist()
        media = ~self.solids.opaque[[i, j]] & ~self.solids.hollow[[i, j]]  # water and air, but no glass vessel
        note = "in something that light passes" if media.any() else ""
        if self.facts.is_adrift:
            note = note or "around the origin"
        if self.solids.glowing[[i, j]].all():
            note = note or "both glow"
        least = float(np.linalg.norm((high - low)[[i, j]], axis=1).min())
        if self._is_round(i) and self._is_round(j) and depth <= SOFT * least:
            note = note or "both are round"
        if facts.is_threaded(row) and (
            facts.is_enclosed(row, along) or self._is_round(i) or self._is_round(j)  # a float on its line
        ):
            note = note or "a rod"
        if self._is_pinned(row, along) or self._ends_in(i, j) or self._ends_in(j, i):
            note = note or "a rod"
        sits = abs(along[1]) >= UPRIGHT and low[upper, 1] > (low + high)[lower, 1] / 2.0
        if sits and self._is_round(lower) and depth <= BURIED * facts.bodies.size[bodies[0], 1]:
            note = note or "it is round"  # a hat on a head
        if self._is_seam(i, j, depth, along):
            note = note or "a seam"
        return Finding("deep", subject, other, depth, (x, y, z), note=note)

    def _is_pinned(self, row: int, along: FloatArray) -> bool:
        """Return whether a round solid is set into a face along its own axis, as a pin, a knob or a lamp is."""
        pair = self.facts.contacts.pairs[row]
        is_along = np.abs(axes_of(self.solids, pair) @ along) >= PARALLEL
        round_ones = self.solids.solids.that_are("is_curved")[pair] & is_along
        return abs(float(along[1])) < UPRIGHT and bool(round_ones.any()) and self.facts.is_enclosed(row, along)

    def _ends_in(self, i: int, j: int) -> bool:
        """Return whether a round rod ends within a round solid, as a strut does at its hub."""
        if not self.solids.solids.that_are("is_curved")[[i, j]].all() or not are_slim(self.solids, np.array([i]))[0]:
            return False
        low, high = self.solids.boxes
        axis = axes_of(self.solids, np.array([i]))[0]
        lengths = np.linalg.norm(self.solids.solids.matrices[i][:, :3], axis=0)
        reach, radius = axis * float(lengths.max()), float(lengths.min())
        ends = np.stack([(low + high)[i] / 2.0 + reach, (low + high)[i] / 2.0 - reach])
        return bool(((ends >= low[j] - radius) & (ends <= high[j] + radius)).all(axis=1).any())

    def _is_seam(self, i: int, j: int, depth: float, along: FloatArray) -> bool:
        """Return whether a shape without a word, or a building, runs a little into what it is built with."""
        bodies, facts = self.facts.bodies, self.facts
        pair = bodies.body[[i, j]].tolist()
        slight = [depth <= SEAM * float(np.abs(along) @ bodies.size[k]) + self.solids.touch for k in pair]
        if all(facts.words_of(k) and not is_shape(facts.ancestry.entity(int(bodies.instance[k]))) for k in pair):
            is_joint = facts.words_of(pair[0]) != facts.words_of(pair[1]) and abs(float(along[1])) < UPRIGHT
            return is_joint and all(slight) and all(self._is_on_ground(k) for k in pair)
        return any(slight)

    def _is_on_ground(self, body: int) -> bool:
        """Return whether a body touches the ground: buildings are joined to each other, pots are not."""
        ground, pairs = self.facts.ground.solids, self.facts.contacts.pairs
        links = self.facts.statics.of_body[body]
        return any(link.other == PLANE or (link.row >= 0 and ground[pairs[link.row]].any()) for link in links)

    def _upper(self, i: int, j: int) -> tuple[int, int]:
        """Return two solids, that of the upper body first; the ground is below everything."""
        on_ground = self.facts.ground.solids[[i, j]]
        heights = self.facts.bodies.center[self.facts.bodies.body[[i, j]], 1]
        return (j, i) if (bool(on_ground[0]), heights[1]) > (bool(on_ground[1]), heights[0]) else (i, j)

    def _smaller(self, i: int, j: int) -> tuple[int, int]:
        """Return two solids, that of the smaller or movable body first."""
        first, second = self.facts.bodies.body[[i, j]].tolist()
        size = np.linalg.norm(self.facts.bodies.size, axis=1)
        swapped = (bool(self.facts.fixed[first]), size[first]) > (bool(self.facts.fixed[second]), size[second])
        return (j, i) if swapped else (i, j)

    def _is_round(self, i: int) -> bool:
        """Return whether a solid has no flat face."""
        return bool(self.solids.solids.form(i)[0].is_rounded)

    def _is_narrower(self, i: int, j: int) -> bool:
        """Return whether a solid is narrower than another in both horizontal directions, as a pole in a ball is."""
        size = (self.solids.boxes[1] - self.solids.boxes[0])[[i, j]][:, [0, 2]]
        return bool((size[0] < size[1]).all())

    def _is_level(self, i: int, side: float) -> bool:
        """Return whether a solid has a level face on its upper (1) or lower (-1) side."""
        return any(side * float(normal[1]) > 0.99 for normal, _ in faces_of(self.solids.solids, i))

    def _has_base(self, i: int) -> bool:
        """Return whether a solid has a flat face that looks down, level or not: a ball and a lying log have none."""
        return any(float(normal[1]) < -0.1 for normal, _ in faces_of(self.solids.solids, i))

    def _sunk(self, body: int, lower: int | None, depth: float, upper: int | None) -> Finding | None:
        """Return the finding about a body that is in the ground or in what it stands on, None if it is not deep."""
        bodies, (low, high) = self.facts.bodies, self.solids.boxes
        if lower is None:
            depth = self.facts.ground.height - float(bodies.low[body, 1])
        else:  # the shortest way out may be down, through a thin top
            depth = max(depth, min(float(high[lower, 1] - bodies.low[body, 1]), float(bodies.size[body, 1])))
        height = float(bodies.size[body, 1])
        room = min(self.solids.touch, TOUCH_OF_SOLIDS * float(np.linalg.norm(bodies.size[body])))
        if depth <= max(SUNK_BASE * height, CONTACT_ERROR * room) or (
            lower is None and (self._is_beside_ground(body) or self._is_in_pit(body))
        ):
            return None
        on_ground = lower is None or bool(self.facts.ground.solids[lower])
        if on_ground and bodies.floating[body]:
            return None  # a boat in its harbour
        rows = bodies.members[body]
        level = self.facts.ground.height if lower is None else float(high[lower, 1])
        below = rows[low[rows, 1] < level - self.solids.touch]
        foot = float((high[below].max(axis=0) - low[below].min(axis=0))[[0, 2]].max()) if len(below) else 0.0
        note = ""
        if not on_ground and not self.solids.opaque[[lower, rows[0]]].all():
            note = "in something that light passes"
        elif on_ground and not any(self._has_base(int(k)) for k in rows):
            note = "it is round"
        elif self._is_alone(body):
            pass
        elif foot * SLIM <= height or (
            (lower is None or self._is_floor(lower, body)) and self._is_planted(body, below, level)
        ):
            note = "its foot is slim"
        elif on_ground and depth <= BURIED * height and self._is_level_with_equals(body):
            note = "as its equals"
        elif lower is None and self._hangs(body):
            note = "it hangs"
        subject = int(upper if upper is not None else rows[np.argmin(low[rows, 1])])
        return Finding("sunk", subject, lower, depth, (0.0, depth, 0.0), note=note)

    def _is_floor(self, lower: int, body: int) -> bool:
        """Return whether a solid is broader than a body in both horizontal directions."""
        low, high = self.solids.boxes
        return bool(((high - low)[lower] > self.facts.bodies.size[body])[[0, 2]].all())

    def _is_in_pit(self, body: int) -> bool:
        """Return whether a body below the ground plane lies on another one that is lower: a duck in a lock."""
        bodies = self.facts.bodies
        others = [link.other if link.body == body else link.body for link in self.facts.statics.of_body[body]]
        return any(
            other != PLANE and bodies.low[other, 1] < bodies.low[body, 1] - self.solids.touch for other in others
        )

    def _is_beside_ground(self, body: int) -> bool:
        """Return whether a body stands beside the ground and no deeper, as a platform at a track."""
        bodies, ground, room = self.facts.bodies, self.facts.ground.solids, self.solids.touch
        if not ground.any():
            return False
        low, high = self.solids.boxes[0][ground], self.solids.boxes[1][ground]
        over = ((bodies.low[body] < high - room) & (bodies.high[body] > low + room))[:, [0, 2]].all(axis=1)
        return not over.any() and bool(bodies.low[body, 1] >= low[:, 1].min() - room)

    def _is_planted(self, body: int, below: IntArray, level: float) -> bool:
        """Return whether all that a body has in the ground are slim legs, by a part of their length, as its equals."""
        facts, (low, high) = self.facts, self.solids.boxes
        if not len(below) or not are_slim(self.solids, below).all():
            return False
        if SLIM * float(facts.bodies.size[body, [0, 2]].min()) <= facts.bodies.size[body, 1]:
            return True  # a fence or a sign would not stand otherwise
        if (level - low[below, 1] > PLANTED * (high - low)[below, 1]).any():
            return False
        return len(self._equals(body)) == 1 or self._is_level_with_equals(body)

    def _equals(self, body: int) -> IntArray:
        """Return the bodies that are instances of the entity of a body, itself included."""
        return np.flatnonzero(self._entity == self._entity[body])

    def _is_level_with_equals(self, body: int) -> bool:
        """Return whether a body has equals, and all begin at its height: a slip moves one of them."""
        low, equals = self.facts.bodies.low[:, 1], self._equals(body)
        return len(equals) > 1 and bool((np.abs(low[equals] - low[body]) <= 2.0 * self.solids.touch).all())

    def _is_alone(self, body: int) -> bool:
        """Return whether a body is lower than its equals, at least three, which all begin at one height."""
        low = self.facts.bodies.low[:, 1]
        others = np.setdiff1d(self._equals(body), [body])
        return (
            len(others) >= _MIN_EQUALS
            and bool(np.ptp(low[others]) <= 2.0 * self.solids.touch)
            and bool(low[body] < low[others].min() - PLANTED * self.facts.bodies.size[body, 1])
        )

    def _hangs(self, body: int) -> bool:
        """Return whether a contact pushes a body up above its center of mass."""
        return any(
            link.other != PLANE
            and (link.normal[1] if link.body == body else -link.normal[1]) > 0.5
            and link.points[:, 1].min() > self.facts.bodies.center[body, 1]
            for link in self.facts.statics.of_body[body]
        )

    # --- support -----------------------------------------------------------------------------------------------------

    def _unsupported(self) -> Iterator[Finding]:
        """Yield one finding for each cluster that floats, and each group of bodies that would fall."""
        facts, seen = self.facts, set[object]()
        for body, verdict in enumerate(facts.verdicts):
            if verdict.holds:
                continue
            if verdict.kind == "floating":
                key: object = ("cluster", int(facts.clusters[body]))
            elif verdict.note in ("joined", "glued"):
                key = (verdict.note, int(facts.bodies.joined[body]))
            else:
                key = ("group", int(facts.fastened[body]))
            if key not in seen:
                seen.add(key)
                yield self._floating(body, verdict) if verdict.kind == "floating" else self._falling(body, verdict)

    def _floating(self, body: int, verdict: Verdict) -> Finding:
        """Return the finding about a cluster of bodies without support, about its largest one."""
        facts = self.facts
        members = np.flatnonzero(facts.clusters == facts.clusters[body])
        largest = int(members[np.argmax(np.linalg.norm(facts.bodies.size[members], axis=1))])
        rows = facts.bodies.members[largest]
        low, high = self.solids.boxes
        lowest = float(facts.bodies.low[members, 1].min())
        below_plane = facts.ground.height - float(facts.bodies.high[members, 1].max())
        others = np.flatnonzero(~np.isin(facts.bodies.body, members))
        in_pit = bool((low[others, 1] < lowest - self.solids.touch).any())
        if below_plane > 0.0 and not facts.ground.solids.any() and not in_pit:
            depth = facts.ground.height - lowest
            return Finding("sunk", int(rows[0]), None, depth, (0.0, depth, 0.0), note=verdict.note)
        least, most = facts.bodies.low[members].min(axis=0), facts.bodies.high[members].max(axis=0)
        below = others[((low[others] < most) & (high[others] > least))[:, [0, 2]].all(axis=1)]
        below = below[high[below, 1] <= lowest + self.solids.touch]
        drop, support = lowest - facts.ground.height, None
        if len(below):
            highest = int(below[np.argmax(high[below, 1])])
            if lowest - float(high[highest, 1]) <= drop:
                drop, support = lowest - float(high[highest, 1]), highest
        if len(others):
            gap, nearest = self._nearest(rows, others, least, most)
            # Beside or below what it should touch, or much nearer to it: a knob at its door; or nearer to another part
            # of its object, as a cart to the wheels beside its axles.
            paths = [set(self._path_of(k)) for k in (largest, int(facts.bodies.body[nearest]))]
            nearer = gap < drop - self.solids.touch and bool(paths[0] & paths[1])
            if drop <= self.solids.touch or DETOUR * gap < drop or nearer:
                drop, support = gap, nearest
        return Finding("floating", int(rows[np.argmin(low[rows, 1])]), support, drop, note=verdict.note)

    def _nearest(self, rows: IntArray, others: IntArray, least: FloatArray, most: FloatArray) -> tuple[float, int]:
        """Return the least distance of solids, whose box is given, from others, and the other one."""
        low, high = self.solids.boxes
        apart = np.maximum(np.maximum(low[others] - most, least - high[others]), 0.0)
        near = np.argsort(np.linalg.norm(apart, axis=1))[:_MAX_NEAREST]
        pairs = np.stack(np.meshgrid(rows, others[near], indexing="ij"), -1).reshape(-1, 2)
        gaps = distances(self.solids.pairs(pairs))
        return float(gaps.min()), int(pairs[np.argmin(gaps), 1])

    def _falling(self, body: int, verdict: Verdict) -> Finding:
        """Return the finding about a group of bodies that gravity would move, about the body itself."""
        facts = self.facts
        rows = facts.bodies.members[body]
        support = next((link.other if link.body == body else link.body for link in facts.statics.of_body[body]), PLANE)
        other = None if support == PLANE else int(facts.bodies.members[support][-1])
        contact = next((link for link in facts.statics.of_body[body] if link.row >= 0), None)
        if contact is not None:
            other = next(k for k in facts.contacts.pairs[contact.row].tolist() if facts.bodies.body[k] != body)
        x, z = verdict.balance.shift
        shift = (x, 0.0, z) if verdict.kind == "tips" and np.isfinite([x, z]).all() and (x or z) else None
        beyond = verdict.balance.beyond if np.isfinite(verdict.balance.beyond) else 0.0
        lowest = int(rows[np.argmin(self.solids.boxes[0][rows, 1])])
        return Finding(verdict.kind, lowest, other, max(beyond, 0.0), shift, shift, verdict.note)

    def _softened(self, finding: Finding) -> Finding:
        """Return a finding as a note where its words say that it may be meant."""
        if finding.note or finding.kind in ("twin", "hidden", "coplanar"):
            return finding
        words = self.solids.words(finding.body)[1:]
        # The propeller of an airplane does not fly where the rest of it stands.
        if finding.kind in ("floating", "tips", "falls", "slides"):
            body = int(self.facts.bodies.body[finding.body])
            members = np.flatnonzero(self.facts.fastened == self.facts.fastened[body])
            paths = {step for member in members for step in self._path_of(int(member))} - self._standing_instances
            named = [self.facts.ancestry.entity(step).word for step in paths]
            if any(flies(word) for word in (self.solids.words(finding.body)[-1], *named)):
                return replace(finding, note="by its word")
        elif any(
            is_soft(word) for word in (*words, *(() if finding.other is None else self.solids.words(finding.other)[1:]))
        ):
            return replace(finding, note="by its word")
        return finding

    def _path_of(self, body: int) -> tuple[int, ...]:
        """Return the instances around the first solid of a body, without the root."""
        ancestry, facts = self.facts.ancestry, self.facts
        leaf = int(ancestry.primitives[self.solids.row[facts.bodies.members[body][0]]])
        return ancestry.path_of_instances(leaf)[1:]

    @cached_property
    def _standing_instances(self) -> set[int]:
        """Return the instances of which a part stands."""
        standing = (body for body, verdict in enumerate(self.facts.verdicts) if verdict.holds)
        return {step for body in standing for step in self._path_of(body)}

    # --- what a report shows -----------------------------------------------------------------------------------------

    def words(self, finding: Finding) -> tuple[str, ...]:
        """Return the words from the root to the subject of a finding: the object, or the solid of a part of one."""
        body = int(self.facts.bodies.body[finding.body])
        if finding.kind in ("hidden", "coplanar") or (finding.kind == "twin" and not finding.whole):
            return self.solids.words(finding.body)
        own = self.facts.words_of(body)
        if finding.instance is not None:
            own = max(own, self._named_path(finding.instance), key=len)
        root = self.facts.root.word
        return (root, *own) if own else self.solids.words(finding.body)

    def _named_path(self, instance: int) -> tuple[str, ...]:
        """Return the words from the root's child to the innermost instance around one that has a word of its own."""
        path = [self.facts.ancestry.entity(step) for step in self.facts.ancestry.path_of_instances(instance)[1:]]
        while path and is_shape(path[-1]):
            path.pop()
        return tuple(entity.word for entity in path)

    def concerned(self, finding: Finding) -> IntArray:
        """Return the solids of the objects that a finding is about."""
        body = self.facts.bodies.body
        named = [finding.body] if finding.other is None else [finding.body, finding.other]
        return np.flatnonzero(np.isin(body, body[named]))

    def subject(self, finding: Finding) -> IntArray:
        """Return the solids of the object that a finding is about."""
        body = self.facts.bodies.body
        return np.flatnonzero(body == body[finding.body])

    def members(self, finding: Finding) -> IntArray:
        """Return the bodies that move together when a finding is fixed: its cluster or its fastened group."""
        body = int(self.facts.bodies.body[finding.body])
        label = self.facts.clusters if finding.kind == "floating" else self.facts.fastened
        return np.flatnonzero((label == label[body]) & ~self.facts.fixed)

    def tried_move(self, finding: Finding) -> Vector | None:
        """Return a translation of the subject that was tried and fixes a finding without another one; else None."""
        members = self.members(finding)
        if finding.kind in ("twin", "hidden", "coplanar", "outlier") or not len(members):
            return None
        before, identity = self._identities(), self._identity(finding)
        # One of several loaves that all float is out of their row until the others follow.
        words = self.words(finding)
        is_one_of_many = sum(f.kind == finding.kind and self.words(f) == words for f in self.findings) > 1

        def helps(facts: FrameFacts) -> bool:
            """Return whether the finding is gone, and none is new."""
            if identity[0] == "falls" and not facts.verdicts[int(facts.bodies.body[finding.body])].holds:
                return False  # on another that floats, it would be a part of that one's finding
            after = CheckedFrame(facts.root, facts)._identities()
            # a ball that may fly above all else, and no longer does when this one is put down, floats as before
            added = Counter((kind, body) for kind, _, body in (after - before).elements())
            known = Counter((kind, body) for kind, noted, body in (before - after).elements() if noted)
            new = [kind for kind, _ in added - known if kind != "outlier" or not is_one_of_many]
            return after[identity] < before[identity] and not new

        first = () if finding.move is None else (finding.move,)
        reach = DETOUR * finding.amount if finding.kind in ("floating", "tips") else math.inf
        return helpful_move(self.facts, members, helps, first, reach=reach)

    def _identities(self) -> Counter[tuple[object, ...]]:
        """Return the number of findings of each identity, without guesses."""
        return Counter(self._identity(f) for f in self.findings if f.kind != "outlier" or not f.note)

    def _identity(self, finding: Finding) -> tuple[object, ...]:
        """Return the kind of a finding and the body that it is about, which a move does not change."""
        kind = "falls" if finding.kind in ("tips", "slides", "floating") else finding.kind
        return kind, bool(finding.note), int(self.facts.bodies.instance[self.facts.bodies.body[finding.body]])

    def marks(self, finding: Finding) -> Marks:
        """Return the marks of an image of a finding: both objects, their contact and the missing support."""
        facts, solids = self.facts, self.solids
        body = facts.bodies.body
        subject = np.flatnonzero(body == body[finding.body])
        other = np.zeros(0, np.int64)
        if finding.other is not None:
            other = np.setdiff1d(np.flatnonzero(body == body[finding.other]), subject)
        points, lines, centers = np.zeros((0, 3)), np.zeros((0, 2, 3)), np.zeros((0, 3))
        if finding.kind in ("tips", "slides", "falls"):
            points, lines, centers = self._standing(int(body[finding.body]))
        elif finding.kind == "deep" and finding.other is not None:
            points = solids.common_points(finding.body, finding.other, np.zeros(3))
        elif finding.kind in ("floating", "sunk"):
            low, high = solids.boxes
            foot = (low[subject].min(axis=0) + high[subject].max(axis=0)) / 2.0
            foot[1] = low[subject, 1].min()
            up = finding.amount if finding.kind == "sunk" else -finding.amount
            lines = np.array([[foot, foot + np.array([0.0, up, 0.0])]])
        return Marks(
            frozenset(solids.row[subject].tolist()), frozenset(solids.row[other].tolist()), points, lines, centers
        )

    def _standing(self, body: int) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return the corners of the support of a body's group, its sides and plumb line, and its center of mass."""
        facts = self.facts
        members = np.flatnonzero(facts.fastened == facts.fastened[body])
        points, _, _ = facts.statics.supports_of(members, facts.fastened)
        center = facts.statics.center_of(members)
        if not len(points):
            return points, np.zeros((0, 2, 3)), center[None]
        level = float(points[:, 1].max())
        corners = np.insert(hull_of(points[:, [0, 2]]), 1, level, axis=1)
        sides = np.stack([corners, np.roll(corners, -1, axis=0)], axis=1)
        plumb = np.array([[center, [center[0], level, center[2]]]])
        return corners, np.concatenate([sides, plumb]), center[None]


# --- diagnostics: findings of every frame at the calls that created the objects (``check --geometry``) ----------------


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


def quoted_path(finding: Diagnostic) -> str:
    """Return the path of the object that the message of a finding names first; "" for one that names none.

    >>> quoted_path(Diagnostic("floating", '"room/cup" floats: it is 0.2 from "room/table"'))
    'room/cup'
    """
    return finding.message.partition('"')[2].partition('"')[0]


def check_geometry(scene: Scene) -> list[Diagnostic]:
    """Return warnings and notes about the geometry of a scene.

    All frames of a 4D scene are checked, of a large one a sample; findings in most of them are reported.
    """
    groups, remarks = _groups(scene)
    shown = [_diagnostic(group, animated=scene.animated) for group in groups[:_MAX_DIAGNOSTICS]]
    if len(groups) > _MAX_DIAGNOSTICS:
        shown.append(Diagnostic("geometry-limit", f"{len(groups) - _MAX_DIAGNOSTICS} more findings are not shown"))
    return [*shown, *remarks[:1]]


@dataclass(frozen=True, slots=True, eq=False)
class FindingMarks:
    """Where a finding of ``check_geometry`` is: the name and message of its diagnostic, a frame, and marks there."""

    name: str
    message: str
    frame: int
    marks: tuple[Marks, ...]


def marks_of_findings(scene: Scene) -> list[FindingMarks]:
    """Return where the findings of ``check_geometry`` are, each in the first frame that has it."""
    marked: list[FindingMarks] = []
    frames: dict[int, CheckedFrame] = {}
    for group in _groups(scene, tries=False)[0][:_MAX_DIAGNOSTICS]:
        diagnostic = _diagnostic(group, animated=scene.animated)
        frame = min(named.frame for named in group)
        checked = frames.setdefault(frame, CheckedFrame(scene.frames[frame]))  # its facts are computed once
        here = [named.finding for named in group if named.frame == frame]
        marks = tuple(checked.marks(finding) for finding in here[:_MAX_MARKED])
        marked.append(FindingMarks(diagnostic.name, diagnostic.message, frame, marks))
    return marked


def _groups(scene: Scene, *, tries: bool = True) -> tuple[list[list[_Named]], list[Diagnostic]]:
    """Return the equal findings that hold in most frames, in groups, and remarks about what was not checked.

    Without ``tries``, no moves that would fix findings are tried.
    """
    count = len(scene.frames)
    frames = checked_frames(scene)
    groups: dict[tuple[object, ...], list[_Named]] = {}
    remarks: list[Diagnostic] = []
    tried = 0
    for number in frames:
        root = scene.frames[number]
        total = primitive_count(root)
        if total > MAX_PRIMITIVES:
            remarks.append(
                _incomplete(f"{total:,} primitives, more than the limit of {MAX_PRIMITIVES:,}", number, count)
            )
            continue
        checked = CheckedFrame(root)
        for finding in checked.findings:
            named = _named(checked, finding, number)
            key = (finding.kind, bool(finding.note), named.words, named.other)
            if tries and key not in groups and not finding.note and tried < _MAX_MOVES:
                tried += 1
                named = replace(named, finding=replace(finding, move=checked.tried_move(finding)))
            else:
                named = replace(named, finding=replace(finding, move=None))
            groups.setdefault(key, []).append(named)
        if len(checked.solids) and not checked.facts.contacts.complete:
            remarks.append(
                _incomplete(f"more than the limit of {MAX_PAIRS:,} pairs of nearby primitives", number, count)
            )
    return [group for group in groups.values() if 2 * len({named.frame for named in group}) > len(frames)], remarks


def checked_frames(scene: Scene) -> list[int]:
    """Return the numbers of the frames to check, spaced evenly in a 4D scene that is too large for all."""
    count = len(scene.frames)
    affordable = _MAX_TOTAL_PRIMITIVES // max(primitive_count(scene.root), 1)
    chosen = min(count, max(_MIN_CHECKED_FRAMES, min(affordable, _MAX_CHECKED_FRAMES)))
    return sorted({round(i * (count - 1) / max(chosen - 1, 1)) for i in range(chosen)})


def _incomplete(why: str, frame: int, count: int) -> Diagnostic:
    """Return the warning that a frame was not checked completely."""
    where = f"frame {frame}" if count > 1 else "the scene"
    return Diagnostic("geometry-limit", f"{where} was not checked completely: {why}")


def _named(checked: CheckedFrame, finding: Finding, frame: int) -> _Named:
    """Return a finding with the words and source locations of its subjects."""
    other = finding.other
    other_words: tuple[str, ...] = ()
    if other is not None:
        other_words = checked.words(Finding(finding.kind, other, None, 0.0))
    return _Named(
        finding, checked.words(finding), other_words, _place(checked.solids, finding.body),
        _place(checked.solids, other) if other is not None else None, frame,
    )  # fmt: skip


def _place(solids: Bodies, i: int) -> Span | None:
    """Return the source location of a solid's first call, None if it is unknown."""
    places = solids.entities[solids.entity[i]].call_sites
    return places[0] if places else None


def message_of(checked: CheckedFrame, finding: Finding) -> str:
    """Return the message of a diagnostic about a finding."""
    return _MESSAGES[finding.kind][1](_named(checked, finding, 0))


def _diagnostic(group: Iterable[_Named], *, animated: bool) -> Diagnostic:
    """Return one diagnostic for equal findings, about the gravest one."""
    findings = list(group)
    named = max(findings, key=lambda named: named.finding.amount)
    frames = {named.frame for named in findings}
    times = max(Counter(named.frame for named in findings).values())
    name, describe = _MESSAGES[named.finding.kind]
    message = describe(named)
    if named.finding.note:
        name, message = f"{name}-note", f"{message}; {_NOTES[named.finding.note]}"
    message += f" ({times} times)" if times > 1 else ""
    if animated:
        message += f" (frame {min(frames)})"
    move = next((n.finding.move for n in findings if n.finding.move is not None), None)
    hint = None
    if move is not None and not named.finding.note:
        hint = _move_hint(move, [each for each in findings if each.frame == named.frame])
    elif named.finding.shift is not None and not named.finding.note:
        hint = f"move its center of mass by `[{rounded(named.finding.shift, 3)}]` over its support, or broaden that"
    other = named.other_place
    notes = (Note("the other object is created here", other),) if other is not None and other != named.place else ()
    return Diagnostic(name, message, named.place, hint, notes)


def _move_hint(move: Sequence[float], equals: Sequence[_Named]) -> str:
    """Return the hint at a move that was tried for one of equal findings.

    Another one is helped by it as well only if it floats or sinks by as much; sideways, each may face elsewhere.
    """
    text = rounded(move, 3)
    if len(equals) == 1:
        return f"`(translate [{text}])` would fix it"
    is_upright = rounded([move[0], 0.0, move[2]], 3) == rounded([0.0, 0.0, 0.0], 3)
    if is_upright and len({f"{each.finding.amount:.3g}" for each in equals}) == 1:
        return f"`(translate [{text}])` of each would fix it"
    return f"`(translate [{text}])` would fix one of them; the others need moves of their own"


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


def _hidden(named: _Named) -> str:
    """Return the message about a hidden solid."""
    return f"{_path(named.words)} is hidden inside {_path(named.other)}"


def _deep(named: _Named) -> str:
    """Return the message about objects that are in each other."""
    other = "its neighbor of the same word" if named.words == named.other else _path(named.other)
    return f"{_path(named.words)} is {named.finding.amount:.3g} deep in {other}"


def _falling(what: str) -> Callable[[_Named], str]:
    """Return the function that writes the message about an object without balance."""

    def message(named: _Named) -> str:
        """Return the message."""
        on = f" on {_path(named.other)}" if named.other else " on the ground"
        beside = f": its center of mass is {named.finding.amount:.3g} beyond its support"
        return f"{_path(named.words)} {what}{on}{beside if named.finding.amount > 0.0 else ''}"

    return message


def _unheld(named: _Named) -> str:
    """Return the message about an object with contacts of which none carries it."""
    touched = f"; it touches {_path(named.other)}" if named.other else ""
    return f"{_path(named.words)} would fall: nothing carries it{touched}"


def _floating(named: _Named) -> str:
    """Return the message about a floating object."""
    above = _path(named.other) if named.other else "the ground"
    return (
        f"{_path(named.words)} floats: it touches nothing that stands, and is {named.finding.amount:.3g} from {above}"
    )


def _sunk(named: _Named) -> str:
    """Return the message about a sunken object."""
    ground = _path(named.other) if named.other else "the ground"
    return f"{_path(named.words)} is sunk {named.finding.amount:.3g} into {ground}"


def _outlier(named: _Named) -> str:
    """Return the message about an object that differs from its siblings."""
    return f"{_path(named.words)} {named.finding.evidence}"


def _coplanar(named: _Named) -> str:
    """Return the message about z-fighting faces."""
    return f"a face of {_path(named.words)} is coplanar with one of {_path(named.other)} in another color (z-fighting)"


_MESSAGES: dict[str, tuple[str, Callable[[_Named], str]]] = {
    "twin": ("overlap", _twin),
    "hidden": ("overlap", _hidden),
    "deep": ("overlap", _deep),
    "sunk": ("below-ground", _sunk),
    "floating": ("floating", _floating),
    "tips": ("unstable", _falling("would tip over")),
    "slides": ("unstable", _falling("would slide")),
    "falls": ("unstable", _unheld),
    "outlier": ("outlier", _outlier),
    "coplanar": ("coincident-faces", _coplanar),
}
_NOTES = {
    "as its equals": "its equals are as well",
    "one of many": "it is one of many small ones, which may fly",
    "above everything that stands": "it is above everything that stands, and may fly",
    "in a case": "it is enclosed, and may only have clearance",
    "overlap": "it is held if what it overlaps is joined to it",
    "joined": "it is held if the shapes that touch are one object",
    "glued": "it is held if it is fastened to what it touches",
    "anchored": "it stands if it is anchored in the ground",
    "on its edge": "that little is rounding, or glue",
    "heavy foot": "it stands if its foot is much heavier than the rest",
    "it is round": "it has no flat base, and may be half buried",
    "part of one body": "it is inside one object, where it only costs",
    "small": "the faces are small",
    "it hangs": "something else carries it",
    "its foot is slim": "its foot is slim, and may be planted",
    "an edge": "it is an edge of a part, flush with the next one",
    "it settles": "it comes to rest within 10 degrees",
    "both are round": "both are round, and may be soft",
    "around the origin": "the object is built around the origin, so nothing says what joins its parts",
    "both glow": "they may be flames or light",
    "in something that light passes": "it may be in water or air",
    "a rod": "it may be a rod in its bearing",
    "a seam": "it may be built into it",
    "a guess": "it may be meant",
    "by its word": "its word says that it may be meant",
}
