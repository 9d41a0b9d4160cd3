"""What blocks take from their neighbours: arms of fences, panes and walls, corners of stairs, as the game's rules say.

North is -z, east +x, south +z, west -x.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from scenelang.backends.minecraft.blocks import SIDES, BlockState, Cells
from scenelang.backends.minecraft.table import BlockKind

IntArray = npt.NDArray[np.int64]
BoolArray = npt.NDArray[np.bool_]

STEPS = {"north": (0, 0, -1), "east": (1, 0, 0), "south": (0, 0, 1), "west": (-1, 0, 0), "up": (0, 1, 0)}
CONNECTED = ("fence", "pane", "wall", "stairs")  # the shapes whose states are worked out here
_CORNERS = ("straight", "outer_left", "outer_right", "inner_left", "inner_right")
_HEIGHTS = ("none", "low", "tall")
_BOOLEANS = ("false", "true")

# Whole cubes that nothing connects to.
_LONELY = ("_leaves", "shulker_box", "pumpkin", "jack_o_lantern", "melon", "barrier")
# What stands on a wall and raises its post.
_POSTS = (
    "torch", "_sign", "_banner", "pressure_plate", "cactus_flower", "tripwire", "lantern", "candle", "chain",
    "_head", "skull",
)  # fmt: skip

Choices = Mapping[str, tuple[IntArray, tuple[str, ...]]]  # of each property: the place of its value in the values


@dataclass(frozen=True, slots=True, eq=False)
class Traits:
    """What the rules ask about a block, one entry for each number of the palette. ``facing`` is a place in SIDES or
    -1; ``top`` is the upper half."""

    shape: npt.NDArray[np.str_]
    facing: IntArray
    top: BoolArray
    solid: BoolArray  # all of its sides carry others
    roof: BoolArray  # its underside covers what is below
    nether: BoolArray  # a fence that wooden ones do not connect to
    post: BoolArray

    @staticmethod
    def of(palette: Sequence[BlockState], kinds: Sequence[BlockKind]) -> Traits:
        """The traits of states with all of their properties."""
        rows = [dict(state.properties) for state in palette]
        shapes = [kind.shape for kind in kinds]
        double = np.array([row.get("type") == "double" for row in rows], np.bool_)
        solid = np.array([s == "cube" and not k.name.endswith(_LONELY) for s, k in zip(shapes, kinds)], np.bool_)
        top = np.array([row.get("half") == "top" or row.get("type") == "top" for row in rows], np.bool_)
        shape = np.array(shapes)
        cube = shape == "cube"
        under = ((shape == "slab") | (shape == "stairs")) & ~top
        return Traits(
            shape,
            np.array([SIDES.index(row["facing"]) if row.get("facing") in SIDES else -1 for row in rows], np.int64),
            top,
            solid | (double & (shape == "slab")),
            cube | double | under,
            np.array([kind.name == "minecraft:nether_brick_fence" for kind in kinds], np.bool_),
            np.array([kind.name.endswith(_POSTS) for kind in kinds], np.bool_),
        )


@dataclass(frozen=True, slots=True, eq=False)
class Surroundings:
    """Some cells of a grid ``at`` (3, N), and what stands beside them."""

    cells: Cells
    at: IntArray

    def beside(self, step: tuple[int, int, int]) -> IntArray:
        """The numbers (N,) of what stands one ``step`` on; air outside of the grid."""
        there = self.at + np.array(step, np.int64)[:, None]
        inside = ((there >= 0) & (there < np.array(self.cells.shape, np.int64)[:, None])).all(axis=0)
        found = np.zeros(self.at.shape[1], np.int64)
        x, y, z = there[:, inside]
        found[inside] = self.cells[x, y, z]
        return found

    def where(self, mask: BoolArray) -> Surroundings:
        """Those of the cells that the mask (N,) selects."""
        return Surroundings(self.cells, self.at[:, mask])


def connected(shape: str, around: Surroundings, traits: Traits) -> Choices:
    """What the neighbours make of all blocks of one of the CONNECTED shapes, whose cells ``around`` has."""
    return _RULES[shape](around, traits)


# --- arms ------------------------------------------------------------------------------------------------------------


def _carries(other: IntArray, side: int, traits: Traits) -> BoolArray:
    """Whether the blocks ``other``, which stand at ``side``, offer a whole face: cubes, double slabs, backs of
    stairs."""
    back = (traits.shape[other] == "stairs") & (traits.facing[other] == (side + 2) % 4)
    whole: BoolArray = traits.solid[other] | back
    return whole


def _gate_across(other: IntArray, side: int, traits: Traits) -> BoolArray:
    """Whether the blocks are gates that end at this side: one opens across the line of its fence."""
    across: BoolArray = (traits.shape[other] == "gate") & (traits.facing[other] % 2 != side % 2)
    return across


def _fences(around: Surroundings, traits: Traits) -> Choices:
    own = around.beside((0, 0, 0))
    found = {}
    for side, name in enumerate(SIDES):
        other = around.beside(STEPS[name])
        same = (traits.shape[other] == "fence") & (traits.nether[other] == traits.nether[own])
        arm = same | _gate_across(other, side, traits) | _carries(other, side, traits)
        found[name] = (arm.astype(np.int64), _BOOLEANS)
    return found


def _panes(around: Surroundings, traits: Traits) -> Choices:
    found = {}
    for side, name in enumerate(SIDES):
        other = around.beside(STEPS[name])
        arm = np.isin(traits.shape[other], ("pane", "wall")) | _carries(other, side, traits)
        found[name] = (arm.astype(np.int64), _BOOLEANS)
    return found


def _wall_arms(around: Surroundings, traits: Traits) -> BoolArray:
    """Which sides of the walls have an arm (4, N)."""
    arms = []
    for side, name in enumerate(SIDES):
        other = around.beside(STEPS[name])
        line = np.isin(traits.shape[other], ("pane", "wall")) | _gate_across(other, side, traits)
        arms.append(line | _carries(other, side, traits))
    return np.array(arms)


def _walls(around: Surroundings, traits: Traits) -> Choices:
    """Arms are tall under a roof or under the arm of another wall; a post stands where the arms make no line, and
    under whatever needs one. Posts are found from the top down, since one carries the other."""
    arms = _wall_arms(around, traits)
    above = around.beside(STEPS["up"])
    is_wall = traits.shape[above] == "wall"
    over = _wall_arms(Surroundings(around.cells, around.at + np.array(STEPS["up"], np.int64)[:, None]), traits)
    tall = arms & (traits.roof[above] | (is_wall & over))
    height = arms.astype(np.int64) + tall
    line = (arms[0] == arms[2]) & (arms[1] == arms[3]) & arms.any(axis=0)
    shut = (tall[0] & tall[2]) | (tall[1] & tall[3])
    carries = traits.post[above] | np.isin(traits.shape[above], ("fence", "pane", "gate")) | traits.roof[above]
    post = ~line | (~shut & carries)
    _carry_posts(around, post, is_wall & line)
    found: dict[str, tuple[IntArray, tuple[str, ...]]] = {
        name: (height[side], _HEIGHTS) for side, name in enumerate(SIDES)
    }
    found["up"] = (post.astype(np.int64), _BOOLEANS)
    return found


def _carry_posts(around: Surroundings, post: BoolArray, waits: BoolArray) -> None:
    """Set ``post`` where the wall above, of which ``waits`` says that it decides, has one."""
    x, y, z = around.at
    standing = np.zeros((around.cells.shape[0], around.cells.shape[2]), np.bool_)
    for level in np.unique(y)[::-1].tolist():
        rows = y == level
        here = rows & waits
        post[here] |= standing[x[here], z[here]]
        standing[x[rows], z[rows]] = post[rows]


# --- corners ---------------------------------------------------------------------------------------------------------


def _stairs(around: Surroundings, traits: Traits) -> Choices:
    """Where the stairs before or behind turn, a corner, unless the row of stairs goes on at that side."""
    own = around.beside((0, 0, 0))
    facing = traits.facing[own]
    beside = np.array([around.beside(STEPS[name]) for name in SIDES])
    rows = np.arange(len(own))
    corner = np.zeros(len(own), np.int64)
    for there, goes_on, kind in ((2, 0, 3), (0, 2, 1)):  # an outer corner, in front, wins over an inner one, behind
        other = beside[(facing + there) % 4, rows]
        turn = traits.facing[other]
        bends = _same_half(own, other, traits) & (turn % 2 != facing % 2)
        beyond = beside[(turn + goes_on) % 4, rows]
        straight = _same_half(own, beyond, traits) & (traits.facing[beyond] == facing)
        left = turn == (facing + 3) % 4
        corner = np.where(bends & ~straight, np.where(left, kind, kind + 1), corner)
    return {"shape": (corner, _CORNERS)}


def _same_half(own: IntArray, other: IntArray, traits: Traits) -> BoolArray:
    same: BoolArray = (traits.shape[other] == "stairs") & (traits.top[other] == traits.top[own])
    return same


_RULES: Mapping[str, Callable[[Surroundings, Traits], Choices]] = {
    "fence": _fences, "pane": _panes, "wall": _walls, "stairs": _stairs,
}  # fmt: skip
