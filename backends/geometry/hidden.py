"""Solids that cannot be seen: duplicates in one place, and those inside an opaque solid."""

from __future__ import annotations

from collections import Counter

import numpy as np

from scenelang.backends.facts.bodies import is_shape
from scenelang.backends.facts.frame import FrameFacts
from scenelang.backends.surfaces.convex import Bodies
from scenelang.backends.surfaces.distance import IntArray
from scenelang.backends.surfaces.solids import FloatArray
from scenelang.interpreter.scene.primitives.mesh import inverses_of

_POSE_TOLERANCE = 1e-6  # of the scene's size: equal poses differ by rounding only
_DUPLICATE_OFFSET = 0.05  # of its least extent: a copy that is offset by less is a duplicate, not a neighbor
_JOINT_SCALE = 0.8  # scale of the outer solid: a part that fits into it is deeper than a joint needs
_MAX_OUTSIDE_SHARE = 1e-3  # of its volume: a solid with less outside another is inside it, up to tessellation
_ROUND_SIDES = 32  # of a round solid's mesh, for containment tests of its vertices


def duplicates(facts: FrameFacts) -> IntArray:
    """Return pairs (K, 2) of equal solids under equal poses, and of solids of one call with a slight offset."""
    solids, body, pairs = facts.solids, facts.bodies.body, facts.contacts.pairs
    a, b = pairs.T
    first, second = solids.solids.take(a), solids.solids.take(b)
    is_equal = (first.forms == second.forms) & (
        np.abs(first.ratios - second.ratios).max(axis=1, initial=0.0) <= _POSE_TOLERANCE
    )
    is_equal &= ~solids.hollow[pairs].any(axis=1) | (solids.entity[a] == solids.entity[b])
    apart = np.abs(first.matrices - second.matrices)
    is_same_pose = apart.max(axis=(1, 2), initial=0.0) <= _POSE_TOLERANCE * solids.size
    is_same_turn = apart[:, :, :3].max(axis=(1, 2), initial=0.0) <= _POSE_TOLERANCE * solids.size
    offset = np.linalg.norm(first.matrices[:, :, 3] - second.matrices[:, :, 3], axis=1)
    low, high = solids.boxes
    least_side = np.where(body[a] == body[b], (high - low)[a].min(axis=1), facts.bodies.size[body[a]].min(axis=1))
    is_offset_copy = (offset <= _DUPLICATE_OFFSET * least_side) & is_same_turn
    is_offset_copy &= (solids.entity[a] == solids.entity[b]) & (solids.path[a] == solids.path[b])
    return np.asarray(pairs[(is_equal & is_same_pose) | is_offset_copy], np.int64)


def hidden_solids(facts: FrameFacts, pairs: IntArray) -> dict[int, int]:
    """Return the solids of ``pairs`` (K, 2) that are inside an opaque one, each with that one.

    A single hidden solid among others of its entity, such as a ball in a joint, is normal modeling practice.
    """
    solids = facts.solids
    low, high = solids.boxes
    inside: dict[int, int] = {}
    for first, second in ((0, 1), (1, 0)):
        inner, outer = pairs[:, first], pairs[:, second]
        room = 1e-4 * solids.size
        boxed = ((low[inner] >= low[outer] - room) & (high[inner] <= high[outer] + room)).all(axis=1)
        for i, o in pairs[boxed & solids.opaque[outer]][:, [first, second]].tolist():
            if i not in inside and is_inside(solids, i, o):
                inside[i] = o
    owner = _owners(facts)
    parts, hidden = Counter(owner.tolist()), Counter(owner[list(inside)].tolist())
    return {
        i: o for i, o in inside.items()
        if hidden[owner[i]] == parts[owner[i]]
        or (solids.path[i] == solids.path[o] and is_inside(solids, i, o, _JOINT_SCALE))
    }  # fmt: skip


def _owners(facts: FrameFacts) -> IntArray:
    """Return the instance (N,) that each solid is; that of its parent for a shape without a word."""
    instance = facts.ancestry.primitives[facts.solids.row]
    shape = np.array([is_shape(entity) for entity in facts.ancestry.nodes], bool)[facts.ancestry.node[instance]]
    parent = facts.ancestry.parent[instance]
    return np.asarray(np.where(shape & (parent >= 0), parent, instance), np.int64)


def is_inside(bodies: Bodies, inner: int, outer: int, limit: float = 0.995) -> bool:
    """Return whether a solid is inside another that is scaled by ``limit`` about its center."""
    if bodies.hollow[outer]:
        surfaces = bodies.surface(inner), bodies.surface(outer)
        if surfaces[1] is None:
            return False  # an open basket hides nothing
        if surfaces[0] is not None and surfaces[1] is not None:
            return bool((surfaces[0] - surfaces[1]).volume() < _MAX_OUTSIDE_SHARE * surfaces[0].volume())
    matrix = bodies.solids.matrices[inner]
    form, ratios = bodies.solids.form(inner)
    return holds_points(bodies, outer, form.mesh(_ROUND_SIDES, ratios).vertices @ matrix[:, :3].T + matrix[:, 3], limit)


def holds_points(bodies: Bodies, outer: int, points: FloatArray, limit: float = 1.0) -> bool:
    """Return whether all points (K, 3) are inside a solid that is scaled by ``limit`` about its center."""
    matrix = bodies.solids.matrices[outer]
    local = (points - matrix[:, 3]) @ inverses_of(matrix[None, :, :3])[0].T / limit
    form, ratios = bodies.solids.form(outer)
    return bool(form.contains(local[:, 0], local[:, 1], local[:, 2], ratios).all())
