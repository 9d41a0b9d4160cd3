"""Translations that resolve a finding, tried on the facts: a move counts only if the moved scene is checked again."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

import numpy as np

from scenelang.backends.facts.contacts import vertices_of
from scenelang.backends.facts.frame import FrameFacts
from scenelang.backends.facts.tolerances import SUSPENSION_AREA, SUSPENSION_HEIGHT
from scenelang.backends.surfaces.convex import Bodies
from scenelang.backends.surfaces.distance import IntArray, distances
from scenelang.backends.surfaces.solids import FloatArray

Vector = tuple[float, float, float]

MAX_TRIED_SOLIDS = 2_000  # of a frame in which moves are tried: each is a check of the whole frame
_MAX_CANDIDATES = 6  # moves tried for one finding
_MAX_FIRST, _MAX_NEAR = 8, 24  # solids whose fall is computed, and solids below them
_FALL_STEPS = 16  # of a fall, each by the distance that remains
_LEVEL_TOUCHES = 4.0  # contact tolerances between the bottom of a body and a top at its height
_SET_IN = 0.1  # of a body's height, by which it is set into what it does not stand on
_CONTACT_GAP = 0.02  # of the contact tolerance: a fall that is this near has ended
# Weights of a move's length against that of a drop: objects are put down more often than hung on a wall, and more often
# that than from a ceiling. On the 14 floating faults of benchmarks/everyday, these choose the object's own place.
_SIDEWAYS_EFFORT, _UPWARD_EFFORT = 1.5, 3.0


def helpful_move(
    facts: FrameFacts, members: IntArray, helps: Callable[[FrameFacts], bool], first: tuple[Vector, ...],
    *, reach: float,
) -> Vector | None:  # fmt: skip
    """Return the shortest translation of bodies after which ``helps`` holds of the frame; None if none does.

    Parameters
    ----------
    members : (K,)
        Numbers of the bodies that move together.
    first
        Translations to try.
    reach
        Longest drop onto what is below, or way to what is beside, that is tried too; infinite for none.
    """
    if len(facts.solids) > MAX_TRIED_SOLIDS:
        return None
    rows = np.concatenate([facts.bodies.members[int(body)] for body in members])
    ways = contact_moves(facts, members) if math.isfinite(reach) else ()
    every: set[Vector] = {*first, *(move for move in ways if math.dist(move, (0.0, 0.0, 0.0)) <= reach)}
    upward = 1.0 if math.isfinite(reach) and _has_narrow_top(facts, rows) else _UPWARD_EFFORT
    candidates = sorted(every, key=lambda move: _effort(move, upward))
    for move in candidates[:_MAX_CANDIDATES]:
        if helps(facts.moved(rows, move)):
            return move
    return None


def ranked_moves(facts: FrameFacts, members: IntArray) -> list[tuple[float, Vector]]:
    """Return the ways of bodies to contacts, those of the least effort first, each with the weight of its length."""
    if len(facts.solids) > MAX_TRIED_SOLIDS:
        return []
    rows = np.concatenate([facts.bodies.members[int(body)] for body in members])
    upward = 1.0 if _has_narrow_top(facts, rows) else _UPWARD_EFFORT
    moves = dict.fromkeys(contact_moves(facts, members))
    efforts = sorted((_effort(move, upward), move) for move in moves)
    return [(effort / math.dist(move, (0.0, 0.0, 0.0)), move) for effort, move in efforts]


def _effort(move: Vector, upward: float) -> float:
    """Return the length of a translation, weighted by what is less likely than a drop."""
    return math.hypot(*move) * weight_of(move, upward)


def weight_of(move: Vector, upward: float = _UPWARD_EFFORT) -> float:
    """Return the weight of a translation's length."""
    return upward if move[1] > 0.0 else 1.0 if move[1] < 0.0 else _SIDEWAYS_EFFORT


def _has_narrow_top(facts: FrameFacts, rows: IntArray) -> bool:
    """Return whether what reaches the top tenth of solids is narrow: a cord of a lamp, the ropes of a swing."""
    low, high = (corner[rows] for corner in facts.solids.boxes)
    top, bottom = float(high[:, 1].max()), float(low[:, 1].min())
    width = (high.max(axis=0) - low.min(axis=0))[[0, 2]]
    level, area = top - SUSPENSION_HEIGHT * (top - bottom), 0.0
    for i in rows[high[:, 1] > level].tolist():
        points = vertices_of(facts.solids, i)  # the box of a shade is as broad as its rim
        upper = points[points[:, 1] >= min(level, float(points[:, 1].max()))]
        area += float(np.ptp(upper[:, [0, 2]], axis=0).prod())
    return area <= SUSPENSION_AREA * float(width.prod())


def contact_moves(facts: FrameFacts, members: IntArray) -> Iterator[Vector]:
    """Yield the translations by which bodies come to rest on what is below, and touch what is beside or above them."""
    solids, bodies = facts.solids, facts.bodies
    low, high = bodies.low[members].min(axis=0), bodies.high[members].max(axis=0)
    others = np.flatnonzero(~np.isin(bodies.body, members))
    under, over = (corners[others] for corners in solids.boxes)
    room = solids.touch
    drop = float(low[1]) - facts.ground.height
    if drop > room:
        yield (0.0, -drop, 0.0)
    for axis in (1, 0, 2):
        across = [k for k in range(3) if k != axis]
        beside = ((under < high) & (over > low))[:, across].all(axis=1)
        for sign, gap in ((-1.0, low[axis] - over[:, axis]), (1.0, under[:, axis] - high[axis])):
            reachable = np.sort(np.unique(gap[beside & (gap > room)]))
            for length in reachable[:2].tolist():
                vector = np.zeros(3)
                vector[axis] = sign * length
                yield (float(vector[0]), float(vector[1]), float(vector[2]))
    yield from _onto_tops(solids, others, low, high)
    drop = max(float(low[1]) - facts.ground.height, 0.0)
    for axis, sign, reach in ((1, -1.0, drop), *((axis, sign, math.inf) for axis in (0, 2) for sign in (-1.0, 1.0))):
        length = _way_until_contact(facts, members, (low, high), axis, sign)
        if room < length < reach:
            vector = np.zeros(3)
            vector[axis] = sign * length
            yield (float(vector[0]), float(vector[1]), float(vector[2]))
            if axis == 1:  # the head of a snowman lies in its body, since balls do not stand on each other
                yield (0.0, -length - _SET_IN * float(high[1] - low[1]), 0.0)


def _onto_tops(solids: Bodies, others: IntArray, low: FloatArray, high: FloatArray) -> Iterator[Vector]:
    """Yield the level ways onto what ends at the height of the bottom of bodies: a cup that missed its table."""
    under, over = (corners[others] for corners in solids.boxes)
    tops = np.flatnonzero(np.abs(over[:, 1] - low[1]) <= _LEVEL_TOUCHES * solids.touch)
    half, middle = (high - low) / 2.0, (high + low) / 2.0
    room = np.maximum((over - under)[tops] / 2.0 - half, 0.0)  # of a smaller top, its middle
    center = ((over + under) / 2.0)[tops]
    ways = np.clip(middle, center - room, center + room) - middle
    lengths = np.hypot(ways[:, 0], ways[:, 2])
    for k in np.argsort(lengths, kind="stable")[:2].tolist():
        if lengths[k] > solids.touch:
            yield (float(ways[k, 0]), 0.0, float(ways[k, 2]))


def _way_until_contact(
    facts: FrameFacts, members: IntArray, box: tuple[FloatArray, FloatArray], axis: int, sign: float
) -> float:
    """Return how far bodies can move along an axis until they meet another, 0 if they meet none.

    The boxes of round and tilted solids meet before they do (conservative advancement by their distances, each of which
    they can move at least; Mirtich, 1996).
    """
    solids, body, (low, high) = facts.solids, facts.bodies.body, box
    (under, over), own = solids.boxes, np.flatnonzero(np.isin(body, members))
    others = np.flatnonzero(~np.isin(body, members))
    across = [k for k in range(3) if k != axis]
    near = ((under[others] < high) & (over[others] > low))[:, across].all(axis=1)
    near &= under[others, axis] < high[axis] if sign < 0.0 else over[others, axis] > low[axis]
    ends = under[own, axis] if sign < 0.0 else -over[own, axis]
    gaps = low[axis] - over[others, axis] if sign < 0.0 else under[others, axis] - high[axis]
    nearest = others[near][np.argsort(gaps[near], kind="stable")[:_MAX_NEAR]]
    pairs = np.stack(np.meshgrid(own[np.argsort(ends)[:_MAX_FIRST]], nearest, indexing="ij"), -1).reshape(-1, 2)
    if not len(pairs):
        return 0.0
    limit = float(gaps[near].max()) + 2.0 * float((high - low)[axis])
    way = 0.0
    for _ in range(_FALL_STEPS):
        posed = solids.pairs(pairs)
        posed.a.matrices[:, axis, 3] += sign * way
        gap = float(distances(posed).min())
        way += gap
        if gap <= _CONTACT_GAP * solids.touch:
            return way
        if way > limit:
            break
    return 0.0
