"""The entities of a scene with cubes in place of the primitives that laid blocks.

Every entity that has blocks below it stands where it stood, at whole cells, its own cubes beside its children; where
there are too many, what is below a level is drawn as parts of that level's entities. What looks the same is shared.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from scenelang.backends.minecraft.painting import BoolArray, FloatArray, IntArray
from scenelang.interpreter import pose
from scenelang.interpreter.ancestry import Ancestry, ancestry_of
from scenelang.interpreter.entity import Entity, descendants
from scenelang.interpreter.shapes import BLOCK_WORDS
from scenelang.interpreter.values import Matrix, Pair

MOST_PARTS = 20_000  # entities of a frame that keep cubes of their own

Corner = tuple[float, ...]


@dataclass(frozen=True, slots=True)
class Cube:
    """A box of the instance ``owner`` from ``low`` to ``high`` in the world, turned by ``turn`` degrees about the
    vertical line through its cell's centre. ``primitive`` is the unit cube that has its look."""

    owner: int
    primitive: Entity
    low: Corner
    high: Corner
    turn: float


@dataclass(frozen=True, slots=True, eq=False)
class Parts:
    """Every instance of a frame (see ``ancestry``), the depth of the deepest that keep their own cubes, and the
    instance ``owner`` that each primitive which lays blocks belongs to."""

    ancestry: Ancestry
    depth: int
    owner: IntArray
    has_blocks: BoolArray  # (M,) of the instances


def parts_of(root: Entity, is_block: BoolArray) -> Parts:
    """The parts of a frame; ``is_block`` (N,) says which of its primitives lay blocks. The root is no primitive."""
    ancestry = ancestry_of(root)
    below: set[int] = set()
    for entity in descendants(root):
        if entity.word in BLOCK_WORDS or any(id(part.car) in below for part in entity.children):
            below.add(id(entity))
    is_leaf = np.array([entity.is_primitive for entity in ancestry.nodes])[ancestry.node]
    has_blocks = np.array([id(entity) in below for entity in ancestry.nodes])[ancestry.node] & ~is_leaf
    at_or_above = np.cumsum(np.bincount(ancestry.depth[has_blocks], minlength=1))
    depth = max(0, int(np.searchsorted(at_or_above, MOST_PARTS, side="right")) - 1)
    parents = ancestry.parent[ancestry.primitives[is_block]]
    return Parts(ancestry, depth, ancestry.at_depth(depth)[parents], has_blocks)


def rebuilt(parts: Parts, cubes: Iterable[Cube]) -> Entity:
    """The root with ``cubes``, and everything that is no block where it was."""
    ancestry = parts.ancestry
    anchors = np.trunc(ancestry.poses[:, :, 3])
    inside: defaultdict[int, list[Pair]] = defaultdict(list)
    for cube in cubes:
        inside[cube.owner].append(Pair(cube.primitive, _pose(cube, anchors[cube.owner])))
    _keep_others(parts, anchors, inside)
    twins: dict[object, Entity] = {}
    for i in np.flatnonzero(parts.has_blocks & (ancestry.depth <= parts.depth))[::-1].tolist():
        children = tuple(inside.pop(i, ()))
        if not children and i:
            continue
        key = int(ancestry.node[i]), tuple((id(part.car), part.cdr) for part in children)
        if key not in twins:
            entity = ancestry.entity(i)
            twins[key] = Entity(entity.word, entity.embedding, children)
        if i == 0:
            return twins[key]
        above = int(ancestry.parent[i])
        inside[above].insert(0, Pair(twins[key], pose.translation(*(anchors[i] - anchors[above]).tolist())))
    raise AssertionError("the root has blocks below it")


def _keep_others(parts: Parts, anchors: FloatArray, inside: defaultdict[int, list[Pair]]) -> None:
    """Give the highest entities without blocks to those that they stand in."""
    ancestry = parts.ancestry
    beside = parts.has_blocks[ancestry.parent] & (ancestry.parent >= 0)
    blocks = np.array([entity.word in BLOCK_WORDS for entity in ancestry.nodes])[ancestry.node]
    others = np.flatnonzero(beside & ~parts.has_blocks & ~blocks)
    owners = ancestry.at_depth(parts.depth)[ancestry.parent[others]]
    for i, owner in zip(others.tolist(), owners.tolist()):
        moved = ancestry.poses[i].copy()
        moved[:, 3] -= anchors[owner]
        inside[owner].append(Pair(ancestry.entity(i), Matrix(moved.ravel().tolist())))


def _pose(cube: Cube, anchor: FloatArray) -> Matrix:
    """Where the unit cube stands in its owner."""
    low, high = np.array(cube.low) - anchor, np.array(cube.high) - anchor
    x, y, z = ((low + high) / 2.0).tolist()
    a, b, c = (high - low).tolist()
    placed = Matrix((a, 0.0, 0.0, x, 0.0, b, 0.0, y, 0.0, 0.0, c, z))
    if not cube.turn:
        return placed
    return pose.compose(pose.rotation(np.radians(cube.turn), (0.0, 1.0, 0.0), (np.floor(low) + 0.5).tolist()), placed)
