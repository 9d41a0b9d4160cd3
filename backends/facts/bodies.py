"""Grouping of the solids of a frame into bodies: what a person would lift as one. No noun decides.

1. Attributes come first: ``:fixed``, ``:floating``, ``:mass`` and ``:body #t`` make an entity one body, ``:body #f``
   makes its children bodies of their own.
2. The root is an arrangement: each child is a body, or several.
3. An entity whose solids touch is one body; if at least half of them form one cluster, each cluster is a body. If less
   do, the entity is an arrangement, such as "chess pieces", and treated like the root.
4. A part that has a word, only rests from above, can be lifted by its height, carries nothing, and is not what joins
   the rest, is a body of its own: a cup on its table. In both readings, if it only touches its own kind: a book in a
   pile.

Where a reading is in doubt (4, and shapes that stand directly in an arrangement and touch), ``joined`` tells what
would be one body in the other reading; what is wrong in one of them only is a note.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.facts.contacts import Contacts
from scenelang.backends.facts.tolerances import MAIN_CLUSTER, SHALLOW, UPRIGHT
from scenelang.backends.surfaces.convex import Bodies, clusters
from scenelang.backends.surfaces.distance import IntArray
from scenelang.backends.surfaces.solids import FloatArray
from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.inspection.numbering import Ancestry
from scenelang.interpreter.scene.entity import Entity
from scenelang.interpreter.scene.primitives import PHYSICS

BoolArray = npt.NDArray[np.bool_]

# Parts of one body that may be lifted are looked for in bodies of at most so many solids: the search is quadratic.
_MAX_SEARCHED_SOLIDS = 1_500
_READERS = {attribute.name: attribute for attribute in PHYSICS}


@dataclass(frozen=True, eq=False)
class BodySet:
    """The bodies of one frame.

    Attributes
    ----------
    members
        Numbers of the solids of each of the B bodies, ascending.
    body : (N,)
        Number of the body of each solid.
    instance : (B,)
        Number of the instance in the ancestry that a body is, or that contains its solids.
    joined : (B,)
        Equal for bodies that are one in the other reading.
    low, high : (B, 3)
        Corners of their boxes, in scene units.
    mass : (B,), center : (B, 3)
        Masses in density times cubed scene units, and centers of mass.
    fixed, floating : (B,)
        Whether attributes hold a body where it is, or let it stay without support.
    loose : (B,)
        Whether ``:fixed #f`` says that nothing but contacts from below holds a body.
    friction : (B,)
        Coefficient of friction; NaN where none is given.
    """

    members: tuple[IntArray, ...]
    body: IntArray
    instance: IntArray
    joined: IntArray
    low: FloatArray
    high: FloatArray
    mass: FloatArray
    center: FloatArray
    fixed: BoolArray
    floating: BoolArray
    loose: BoolArray
    friction: FloatArray

    def __len__(self) -> int:
        return len(self.members)

    @cached_property
    def size(self) -> FloatArray:
        """Extents (B, 3) of their boxes."""
        return self.high - self.low

    def extent(self, members: IntArray) -> FloatArray:
        """Return the extents (3,) of the box around several bodies."""
        return np.asarray(self.high[members].max(axis=0) - self.low[members].min(axis=0), np.float64)


def physics_of(entity: Entity) -> dict[str, Any]:
    """Return the validated physics attributes of an entity; raises SceneError("attribute")."""
    attributes = entity.embedding.attributes
    physics: dict[str, Any] = {}
    for name, attribute in _READERS.items():
        value = attributes.get(name)
        if value is None or attribute.read is None:
            continue
        try:
            physics[name] = attribute.read(entity.word, name, value)
        except SceneError as error:
            if entity.call_sites and error.span is None:
                error.span = entity.call_sites[0]
            raise
    return physics


def is_whole(physics: dict[str, Any]) -> bool:
    """Return whether attributes declare an entity to be one body."""
    return bool(physics.get("fixed") or physics.get("floating") or physics.get("body"))


def is_shape(entity: Entity) -> bool:
    """Return whether an entity is a primitive named after its shape, such as "cube", or a computed solid."""
    shape = entity.shape
    return shape is not None and (shape.is_solid or not (shape.is_semantic or shape.is_file or shape.is_block))


def grouped(solids: Bodies, ancestry: Ancestry, contacts: Contacts) -> BodySet:
    """Return the bodies of a frame; raises SceneError("attribute") for physics attributes that cannot be read."""
    return _Grouping(solids, ancestry, contacts).bodies()


class _Grouping:
    """Groups the solids of a frame, from the root down."""

    def __init__(self, solids: Bodies, ancestry: Ancestry, contacts: Contacts) -> None:
        self.solids, self.ancestry, self.contacts = solids, ancestry, contacts
        self.physics = [physics_of(entity) for entity in ancestry.nodes]
        order = np.lexsort((ancestry.position, ancestry.parent))
        self.children_of = np.split(order, np.searchsorted(ancestry.parent[order], np.arange(len(ancestry) + 1)))[1:]
        # The half-open range of the solids of every instance, which are numbered in depth-first order.
        self.first, last = ancestry.ranges(ancestry.primitives[solids.row])
        self.last = last + 1
        self.pairs = contacts.pairs

    def attributes(self, instance: int) -> dict[str, Any]:
        """Return the physics attributes of an instance."""
        return self.physics[int(self.ancestry.node[instance])]

    @cached_property
    def _has_separate(self) -> BoolArray:
        """Mask (M,) of instances with an entity below them that attributes make a body of its own."""
        ancestry = self.ancestry
        declared = np.array([is_whole(p) or p.get("body") is False for p in self.physics], bool)[ancestry.node]
        below = np.zeros(len(ancestry), bool)
        for depth in range(ancestry.max_depth, 0, -1):
            level = np.flatnonzero((ancestry.depth == depth) & (declared | below))
            below[ancestry.parent[level]] = True
        return below

    def bodies(self) -> BodySet:
        """Return the bodies in the order of their first solids."""
        parts: list[tuple[int, IntArray, int]] = []  # instance, solids, number of the group in the other reading
        whole: dict[tuple[int, bool], int] = {}  # instances are one body in the other reading
        for instance, members, pieces in self._groups():
            for at, piece in pieces or [(instance, members)]:
                is_piled = at != instance and self._is_piled(at, piece)
                key = (at, True) if is_piled else (instance, False)
                parts.append((at, piece, whole.setdefault(key, len(whole))))
        parts.sort(key=lambda part: int(part[1][0]))
        return self._measured(parts)

    def _groups(self) -> Iterator[tuple[int, IntArray, list[tuple[int, IntArray]]]]:
        """Yield an instance, the solids of a body of it, and the bodies that they are in the other reading."""
        stack = [0] if len(self.first) else []
        while stack:
            at = stack.pop()
            first, last = int(self.first[at]), int(self.last[at])
            if last <= first or last < 0:
                continue
            members, physics = np.arange(first, last), self.attributes(at)
            if is_whole(physics) or "mass" in physics or self.ancestry.entity(at).is_primitive:
                yield at, members, []
                continue
            if at != 0 and physics.get("body") is not False and not self._has_separate[at]:
                parts = self._connected(members)
                if len(parts[0]) >= MAIN_CLUSTER * len(members):
                    for part in parts:
                        yield at, part, self._lifted(at, part)
                    continue
            children = [int(child) for child in self.children_of[at]]
            shapes = [child for child in children if self._is_loose(child)]
            loose = [int(self.first[child]) for child in shapes if self.last[child] > self.first[child]]
            for part in self._connected(np.array(loose, np.int64)) if loose else ():
                owner = self.ancestry.primitives[self.solids.row[part]]
                yield at, part, list(zip(owner.tolist(), part[:, None])) if len(part) > 1 else []
            taken = set(shapes)
            stack.extend(child for child in reversed(children) if child not in taken)

    def _is_loose(self, instance: int) -> bool:
        """Return whether an instance is a shape without a word, and no attribute makes it a body."""
        physics = self.attributes(instance)
        return is_shape(self.ancestry.entity(instance)) and not is_whole(physics) and physics.get("body") is not False

    def _connected(self, members: IntArray) -> list[IntArray]:
        """Return the clusters of touching solids among ascending ``members``, the largest first."""
        if len(members) == 1:
            return [members]
        pairs = self._within(members)
        labels = clusters(len(members), np.searchsorted(members, pairs).tolist())
        order = np.argsort(labels, kind="stable")
        starts = np.flatnonzero(np.diff(labels[order], prepend=-1))
        parts = [np.sort(part) for part in np.split(members[order], starts[1:])]
        return sorted(parts, key=lambda part: (-len(part), int(part[0])))

    def _within(self, members: IntArray) -> IntArray:
        """Return the touching pairs (K, 2) of which both solids are among ascending ``members``."""
        start, end = np.searchsorted(self.pairs[:, 0], [members[0], members[-1] + 1])
        pairs = self.pairs[start:end]
        if len(members) == members[-1] - members[0] + 1:
            return np.asarray(pairs[pairs[:, 1] <= members[-1]], np.int64)
        return np.asarray(pairs[np.isin(pairs, members).all(axis=1)], np.int64)

    # --- parts that can be lifted ------------------------------------------------------------------------------------

    def _lifted(self, at: int, members: IntArray) -> list[tuple[int, IntArray]]:
        """Return the parts with a word that can be lifted from a body, and the rest; none if nothing can be lifted."""
        if len(members) < 2 or len(members) > _MAX_SEARCHED_SOLIDS:
            return []
        candidates = list(self._named_parts(at, members))
        rest, pieces = members, []
        changed = True
        while changed:
            changed = False
            for instance, part in candidates:
                if len(part) < len(rest) and np.isin(part, rest).all() and self._can_be_lifted(part, rest):
                    pieces += self._lifted(instance, part) or [(instance, part)]
                    rest = np.setdiff1d(rest, part)
                    changed = True
        return [(at, rest), *pieces] if pieces else []

    def _named_parts(self, at: int, members: IntArray) -> Iterator[tuple[int, IntArray]]:
        """Yield the instances with a word below ``at`` whose solids are all among ``members``, outer ones first."""
        stack = [int(child) for child in self.children_of[at]]
        while stack:
            instance = stack.pop()
            part = np.arange(self.first[instance], self.last[instance])
            if not len(part):
                continue
            entity = self.ancestry.entity(instance)
            if not is_shape(entity) and np.isin(part, members).all() and len(self._connected(part)) == 1:
                yield instance, part
            if not entity.is_primitive:
                stack.extend(int(child) for child in self.children_of[instance])

    def _can_be_lifted(self, part: IntArray, rest: IntArray) -> bool:
        """Return whether a part only rests from above, carries nothing, is free above, and joins nothing."""
        others = np.setdiff1d(rest, part)
        rows = self._rows_between(part, others)
        if not len(rows):
            return False
        contacts, (low, high) = self.contacts, self.solids.boxes
        is_first = np.isin(contacts.pairs[rows, 0], part)
        depth, along = contacts.depths(rows)
        up = np.where(is_first, -along[:, 1], along[:, 1])
        height = float(high[part, 1].max() - low[part, 1].min())
        if (up < UPRIGHT).any() or (depth > np.maximum(SHALLOW * height, contacts.room[rows])).any():
            return False
        return self._is_free_above(part, others, height) and len(self._connected(others)) == 1

    def _is_piled(self, instance: int, part: IntArray) -> bool:
        """Return whether a part only touches siblings of its own word: a book in a pile is no part of it."""
        ancestry, word = self.ancestry, self.ancestry.entity(instance).word
        if is_shape(ancestry.entity(instance)):
            return False
        inside = np.isin(self.pairs, part)
        others = self.pairs[inside[:, ::-1] & ~inside]
        siblings = ancestry.at_depth(int(ancestry.depth[instance]))[ancestry.primitives[self.solids.row[others]]]
        return len(others) > 0 and all(
            at >= 0 and ancestry.parent[at] == ancestry.parent[instance] and ancestry.entity(at).word == word
            for at in np.unique(siblings).tolist()
        )

    def _rows_between(self, part: IntArray, others: IntArray) -> IntArray:
        """Return the rows of the contacts between two sets of solids."""
        mark = np.zeros(len(self.solids), np.int8)
        mark[part], mark[others] = 1, 2
        return np.flatnonzero(mark[self.pairs].sum(axis=1) == 3)

    def _is_free_above(self, part: IntArray, others: IntArray, height: float) -> bool:
        """Return whether no other solid is above the solids of a part, up to its height."""
        low, high = self.solids.boxes
        room = self.solids.touch
        for i in part.tolist():
            beside = ((low[others] < high[i] - room) & (high[others] > low[i] + room))[:, [0, 2]].all(axis=1)
            above = (high[others, 1] > high[i, 1] + room) & (low[others, 1] < high[i, 1] + height)
            if (beside & above).any():
                return False
        return True

    # --- measures ----------------------------------------------------------------------------------------------------

    def _measured(self, parts: Sequence[tuple[int, IntArray, int]]) -> BodySet:
        """Return the bodies of parts with their boxes, masses and attributes."""
        count, total = len(parts), len(self.solids)
        body = np.zeros(total, np.int64)
        for number, (_, members, _) in enumerate(parts):
            body[members] = number
        low, high = np.full((count, 3), np.inf), np.full((count, 3), -np.inf)
        np.minimum.at(low, body, self.solids.boxes[0])
        np.maximum.at(high, body, self.solids.boxes[1])
        volume, center = self.solids.masses
        weight = volume * self._inherited("density", 1000.0)
        mass = np.asarray(np.bincount(body, weight, count), np.float64)
        middle: FloatArray = np.stack([np.bincount(body, weight * center[:, k], count) for k in range(3)], axis=1)
        fixed, floating = (self._inherited(name, np.nan) for name in ("fixed", "floating"))
        friction = self._inherited("friction", np.nan)
        firsts = np.array([members[0] for _, members, _ in parts], np.int64)
        return BodySet(
            tuple(members for _, members, _ in parts), body,
            np.array([instance for instance, _, _ in parts], np.int64),
            np.array([group for _, _, group in parts], np.int64), low, high, mass,
            np.asarray(middle / mass[:, None], np.float64),
            np.bincount(body, fixed == 1.0, count) > 0, np.bincount(body, floating == 1.0, count) > 0,
            np.bincount(body, fixed == 0.0, count) > 0, friction[firsts],
        )  # fmt: skip

    def _inherited(self, name: str, default: float) -> FloatArray:
        """Return a physics attribute (N,) of the innermost entity around each solid that has it."""
        ancestry = self.ancestry
        given = np.array([float(p[name]) if name in p else np.nan for p in self.physics], np.float64)[ancestry.node]
        if np.isnan(given).all():
            return np.full(len(self.solids), default)
        for depth in range(1, ancestry.max_depth + 1):
            level = np.flatnonzero((ancestry.depth == depth) & np.isnan(given))
            given[level] = given[ancestry.parent[level]]
        values = given[ancestry.primitives[self.solids.row]]
        return np.where(np.isnan(values), default, values)
