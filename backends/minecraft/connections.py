"""What blocks take from their neighbours: arms of fences, panes and walls, corners of stairs, as the game's rules say.

North is -z, east +x, south +z, west -x.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from scenelang.backends.minecraft.blocks import AIR_STATE, SIDES, BlockState, Build, Cells, unified
from scenelang.backends.minecraft.table import BlockKind, BlockTable, alias, load_table, nearest, renamed
from scenelang.backends.minecraft.voxels import NAMESPACE, Voxels, ignored, modern, namespaced
from scenelang.backends.neural.clip import by_meaning
from scenelang.grammar.datum import Span
from scenelang.grammar.diagnostics import Diagnostic, suggest

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


# From the block that a program asks for to a state that the game has (the paper, appendix "Minecraft Renderer").


Similar = Callable[[str, Sequence[str]], str | None]  # of the names, that which means most nearly the first text
_MISSPELT = 0.95  # so alike are a name and its misspelling
_LONGEST = 100  # letters of a name that are compared


@dataclass(frozen=True, slots=True)
class Resolved:
    """A state with all of its block's properties. ``given``: those that the program set; the others are defaults."""

    state: BlockState
    given: frozenset[str] = frozenset()
    warnings: tuple[Diagnostic, ...] = ()


def resolve(
    block_type: str,
    properties: Mapping[str, str] | None = None,
    table: BlockTable | None = None,
    similar: Similar | None = None,
    span: Span | None = None,
) -> Resolved:
    """The state of the block ``block_type``, with or without namespace, whose ``properties`` are as given.

    A block that the version does not have becomes, without a word, what the game calls it there; else the nearest one,
    with a warning that names both: an alias, a misspelling, what ``similar`` finds, or the most alike name.
    Properties of earlier versions become what they are today, without a word; what means nothing to the block is left
    out, with a warning. Warnings carry ``span``.
    """
    table = table or load_table()
    name = namespaced(block_type)
    given = dict(properties or {})
    kind = table.blocks.get(name) or _renamed(name, table)
    if kind is not None:
        found = modern(name, kind, given, table)
        return _filled(found.kind, found.given, *(_left_out(found.kind, *pair, span) for pair in found.dropped.items()))
    kind = _nearest(name.partition(":")[2][:_LONGEST], table, similar)
    found = modern(name, kind, given, table)
    dropped = ", ".join(f"{key}={value}" for key, value in given.items() if key in found.dropped)
    without = f", without {dropped}" if dropped else ""
    message = (
        f"Minecraft {table.version} has no block `{name[:_LONGEST]}`; `{found.kind.name}` is laid instead{without}"
    )
    return _filled(found.kind, found.given, Diagnostic("unknown-block", message, span))


def _filled(kind: BlockKind, given: Mapping[str, str], *warnings: Diagnostic) -> Resolved:
    state = BlockState(kind.name, tuple(sorted({**kind.defaults, **given}.items())))
    return Resolved(state, frozenset(given), warnings)


def _renamed(name: str, table: BlockTable) -> BlockKind | None:
    other = renamed(name.removeprefix(NAMESPACE), {known.removeprefix(NAMESPACE) for known in table.blocks})
    return None if other is None else table.blocks[NAMESPACE + other]


def _nearest(name: str, table: BlockTable, similar: Similar | None) -> BlockKind:
    """The block to lay in place of one that there is not: never one for operators."""
    names = [kind.name.removeprefix(NAMESPACE) for kind in table.blocks.values() if not kind.is_for_operators]
    found = alias(name, names)
    if found is None:
        found, likeness = nearest(name, names)
        if similar is not None and likeness < _MISSPELT:
            meant = similar(name.replace("_", " "), names)
            found = meant if meant in names else found
    return table.blocks[NAMESPACE + found]


def _left_out(kind: BlockKind, name: str, value: str, span: Span | None) -> Diagnostic:
    """The warning for a property that the block does not take."""
    if name not in kind.values:
        have = f"it has {_listed(kind.values)}" if kind.values else "it has none"
        message = f"the block `{kind.name}` has no property `{name[:_LONGEST]}`, which is left out; {have}"
        return Diagnostic("block-property", message, span, hint=suggest(name, kind.values))
    values = _listed(kind.values[name], "or")
    message = f"`{name}` of `{kind.name}` is {values}, not `{value[:_LONGEST]}`, which is left out"
    return Diagnostic("block-property", message, span, hint=suggest(value, kind.values[name]))


def _listed(names: Sequence[str] | Mapping[str, object], last: str = "and") -> str:
    shown = [f"`{name}`" for name in names]
    return f" {last} ".join(part for part in (", ".join(shown[:-1]), shown[-1]) if part)


# From what a program asks for to block states that the game has, each with all of its properties.


_SLAB = 1 << 22  # cells that are looked at together


@dataclass(frozen=True, slots=True, eq=False)
class Settled:
    """A build of whole block states; what was replaced on the way, one warning for each block, and what lays none."""

    build: Build
    warnings: tuple[Diagnostic, ...]


def settled(voxels: Voxels, table: BlockTable | None = None, similar: Similar | None = by_meaning) -> Settled:
    """``voxels`` with states that the version of ``table`` has: unknown blocks replaced (see ``knowledge``), arms and
    corners from the neighbours where the program does not set them, defaults for the rest."""
    table = table or load_table()
    asked = voxels.build
    found = [Resolved(AIR_STATE)] + [
        resolve(state.name, dict(state.properties), table, similar, place)
        for state, place in zip(asked.palette[1:], voxels.places[1:])
    ]
    warnings = {warning.message: warning for each in found for warning in each.warnings}
    build = unified(asked.origin, *_with_neighbours(asked.cells, found, table))
    left_out = ignored(voxels)
    more = (each for each in (left_out, voxels.off_cells) if each is not None)
    return Settled(build, (*warnings.values(), *more))


def _with_neighbours(cells: Cells, found: Sequence[Resolved], table: BlockTable) -> tuple[Cells, list[BlockState]]:
    """The cells, and the states that their numbers mean, where neighbours have had their say."""
    states = [each.state for each in found]
    kinds = [table.blocks[state.name] for state in states]
    traits = Traits.of(states, kinds)
    fresh = cells
    for shape in CONNECTED:
        numbers = np.flatnonzero(traits.shape == shape)
        if not len(numbers):
            continue
        around = Surroundings(cells, _standing(cells, numbers, len(states)))
        own = around.beside((0, 0, 0))
        choices = connected(shape, around, traits)
        if fresh is cells:
            fresh = cells.copy()
        x, y, z = around.at
        fresh[x, y, z] = _numbered(own, choices, found, states)
    return fresh, states


def _standing(cells: Cells, numbers: IntArray, count: int) -> IntArray:
    """The cells (3, N) in which one of ``numbers`` stands."""
    wanted = np.zeros(count, np.bool_)
    wanted[numbers] = True
    slab = max(1, _SLAB // max(1, cells[:1].size))
    parts = []
    for start in range(0, len(cells), slab):
        at = np.array(np.nonzero(wanted[cells[start : start + slab]]), np.int64)
        at[0] += start
        parts.append(at)
    return np.concatenate(parts, axis=1)


def _numbered(own: IntArray, choices: Choices, found: Sequence[Resolved], states: list[BlockState]) -> IntArray:
    """The number of each cell's state, given what its neighbours make of it; new states are added to ``states``."""
    code = own.copy()
    for places, values in choices.values():
        code = code * len(values) + places
    _, first, inverse = np.unique(code, return_index=True, return_inverse=True)
    fresh = []
    for row in first.tolist():
        before = found[int(own[row])]
        made = {name: values[int(places[row])] for name, (places, values) in choices.items()}
        chosen = {name: value for name, value in made.items() if name not in before.given}
        fresh.append(len(states))
        states.append(BlockState(before.state.name, tuple(sorted({**dict(before.state.properties), **chosen}.items()))))
    return np.array(fresh, np.int64)[inverse]
