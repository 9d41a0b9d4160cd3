"""Block states that depend on neighbors: arms of fences, panes and walls, corners of stairs, by the game's rules.

North is -z, east +x, south +z, west -x.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from scenelang.backends.minecraft.blocks import (
    AIR_STATE,
    SIDES,
    BlockKind,
    BlockState,
    BlockTable,
    Build,
    Cells,
    alias,
    load_table,
    nearest,
    renamed,
    unified,
)
from scenelang.backends.minecraft.voxels import NAMESPACE, Voxels, ignored, modern, namespaced
from scenelang.grammar.datum import Span
from scenelang.grammar.diagnostics import Diagnostic, suggest
from scenelang.interpreter.plugins import SERVICES

IntArray = npt.NDArray[np.int64]
BoolArray = npt.NDArray[np.bool_]

STEPS = {"north": (0, 0, -1), "east": (1, 0, 0), "south": (0, 0, 1), "west": (-1, 0, 0), "up": (0, 1, 0)}
CONNECTED = ("fence", "pane", "wall", "stairs")  # shapes whose states depend on neighbors
_CORNERS = ("straight", "outer_left", "outer_right", "inner_left", "inner_right")
_HEIGHTS = ("none", "low", "tall")
_BOOLEANS = ("false", "true")

# Full cubes to which nothing connects.
_UNCONNECTED = ("_leaves", "shulker_box", "pumpkin", "jack_o_lantern", "melon", "barrier")
# Blocks that raise the post of a wall below them.
_POSTS = (
    "torch", "_sign", "_banner", "pressure_plate", "cactus_flower", "tripwire", "lantern", "candle", "chain",
    "_head", "skull",
)  # fmt: skip

# for each property: indices into its possible values, and these values
Choices = Mapping[str, tuple[IntArray, tuple[str, ...]]]


@dataclass(frozen=True, slots=True, eq=False)
class Traits:
    """Properties of blocks used by the rules, one entry per palette index.

    ``facing`` is an index into SIDES or -1; ``top`` marks the upper half.
    """

    shape: npt.NDArray[np.str_]
    facing: IntArray
    top: BoolArray
    solid: BoolArray  # full faces on all sides
    roof: BoolArray  # underside covers the block below
    nether: BoolArray  # nether fences, to which wooden ones do not connect
    post: BoolArray

    @staticmethod
    def of(palette: Sequence[BlockState], kinds: Sequence[BlockKind]) -> Traits:
        """Return the traits of complete states."""
        rows = [dict(state.properties) for state in palette]
        shapes = [kind.shape for kind in kinds]
        double = np.array([row.get("type") == "double" for row in rows], np.bool_)
        solid = np.array([s == "cube" and not k.name.endswith(_UNCONNECTED) for s, k in zip(shapes, kinds)], np.bool_)
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
    """Selected cells of a grid, ``at`` (3, N), with access to their neighbors."""

    cells: Cells
    at: IntArray

    def beside(self, step: tuple[int, int, int]) -> IntArray:
        """Return the indices (N,) of the neighbors at offset ``step``; air outside the grid."""
        neighbors = self.at + np.array(step, np.int64)[:, None]
        inside = ((neighbors >= 0) & (neighbors < np.array(self.cells.shape, np.int64)[:, None])).all(axis=0)
        indices = np.zeros(self.at.shape[1], np.int64)
        x, y, z = neighbors[:, inside]
        indices[inside] = self.cells[x, y, z]
        return indices

    def where(self, mask: BoolArray) -> Surroundings:
        """Return the cells selected by the mask (N,)."""
        return Surroundings(self.cells, self.at[:, mask])


def connected(shape: str, around: Surroundings, traits: Traits) -> Choices:
    """Return the neighbor-dependent properties of the blocks ``around``, of one of the CONNECTED shapes."""
    return _RULES[shape](around, traits)


# --- arms ------------------------------------------------------------------------------------------------------------


def _carries(other: IntArray, side: int, traits: Traits) -> BoolArray:
    """Return whether the blocks ``other``, at ``side``, have a full face here: cubes, double slabs, backs of stairs."""
    back = (traits.shape[other] == "stairs") & (traits.facing[other] == (side + 2) % 4)
    is_full: BoolArray = traits.solid[other] | back
    return is_full


def _gate_across(other: IntArray, side: int, traits: Traits) -> BoolArray:
    """Return whether the blocks are gates whose ends point to this side.

    A gate opens perpendicular to its fence line.
    """
    across: BoolArray = (traits.shape[other] == "gate") & (traits.facing[other] % 2 != side % 2)
    return across


def _fences(around: Surroundings, traits: Traits) -> Choices:
    """Return the arms of fences: to fences of the same material, gates across, and full faces."""
    fence = around.beside((0, 0, 0))
    arms = {}
    for side, name in enumerate(SIDES):
        other = around.beside(STEPS[name])
        is_fence = (traits.shape[other] == "fence") & (traits.nether[other] == traits.nether[fence])
        arm = is_fence | _gate_across(other, side, traits) | _carries(other, side, traits)
        arms[name] = (arm.astype(np.int64), _BOOLEANS)
    return arms


def _panes(around: Surroundings, traits: Traits) -> Choices:
    """Return the arms of panes and bars: to panes, walls and full faces."""
    arms = {}
    for side, name in enumerate(SIDES):
        other = around.beside(STEPS[name])
        arm = np.isin(traits.shape[other], ("pane", "wall")) | _carries(other, side, traits)
        arms[name] = (arm.astype(np.int64), _BOOLEANS)
    return arms


def _wall_arms(around: Surroundings, traits: Traits) -> BoolArray:
    """Return the mask (4, N) of sides on which the walls have an arm."""
    arms = []
    for side, name in enumerate(SIDES):
        other = around.beside(STEPS[name])
        line = np.isin(traits.shape[other], ("pane", "wall")) | _gate_across(other, side, traits)
        arms.append(line | _carries(other, side, traits))
    return np.array(arms)


def _walls(around: Surroundings, traits: Traits) -> Choices:
    """Return the states of walls.

    Arms are tall below a roof or below the arm of another wall; a post is needed where the arms are not a straight
    line, and below some blocks. Walls are processed from the top down because a post also requires one below.
    """
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
    states: dict[str, tuple[IntArray, tuple[str, ...]]] = {
        name: (height[side], _HEIGHTS) for side, name in enumerate(SIDES)
    }
    states["up"] = (post.astype(np.int64), _BOOLEANS)
    return states


def _carry_posts(around: Surroundings, post: BoolArray, waits: BoolArray) -> None:
    """Set ``post`` of walls below walls with a post; ``waits`` marks walls that this decides."""
    x, y, z = around.at
    standing = np.zeros((around.cells.shape[0], around.cells.shape[2]), np.bool_)
    for level in np.unique(y)[::-1].tolist():
        rows = y == level
        undecided = rows & waits
        post[undecided] |= standing[x[undecided], z[undecided]]
        standing[x[rows], z[rows]] = post[rows]


# --- corners ---------------------------------------------------------------------------------------------------------


def _stairs(around: Surroundings, traits: Traits) -> Choices:
    """Return the corners of stairs.

    Stairs turn if the stairs in front or behind are perpendicular, unless the row of stairs continues on that side.
    """
    stairs = around.beside((0, 0, 0))
    facing = traits.facing[stairs]
    beside = np.array([around.beside(STEPS[name]) for name in SIDES])
    rows = np.arange(len(stairs))
    corner = np.zeros(len(stairs), np.int64)
    # An outer corner, in front, takes precedence over an inner one, behind.
    for direction, continues, kind in ((2, 0, 3), (0, 2, 1)):
        other = beside[(facing + direction) % 4, rows]
        other_facing = traits.facing[other]
        bends = _same_half(stairs, other, traits) & (other_facing % 2 != facing % 2)
        beyond = beside[(other_facing + continues) % 4, rows]
        straight = _same_half(stairs, beyond, traits) & (traits.facing[beyond] == facing)
        is_left = other_facing == (facing + 3) % 4
        corner = np.where(bends & ~straight, np.where(is_left, kind, kind + 1), corner)
    return {"shape": (corner, _CORNERS)}


def _same_half(stairs: IntArray, other: IntArray, traits: Traits) -> BoolArray:
    """Return whether the blocks ``other`` are stairs of the same half, top or bottom."""
    is_same: BoolArray = (traits.shape[other] == "stairs") & (traits.top[other] == traits.top[stairs])
    return is_same


_RULES: Mapping[str, Callable[[Surroundings, Traits], Choices]] = {
    "fence": _fences, "pane": _panes, "wall": _walls, "stairs": _stairs,
}  # fmt: skip


# Resolution of requested blocks to states of the game (the paper, appendix "Minecraft Renderer").


Similar = Callable[[str, Sequence[str]], str | None]  # returns the name closest in meaning to the first argument
_MISSPELLING_SIMILARITY = 0.95  # Jaro-Winkler similarity from which an unknown name is a misspelling, not another word
_MAX_NAME_LENGTH = 100  # characters of a name to compare, since hostile ones may be long


@dataclass(frozen=True, slots=True)
class Resolved:
    """Complete block state.

    ``given`` are the properties set by the program; the others are defaults.
    """

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
    """Return the complete state of a requested block.

    A block that the version lacks is silently replaced by its current name if it was renamed. Otherwise the nearest
    block is used, with a warning: an alias, a misspelling, the result of ``similar``, or the most similar name. A
    property is never an error: those of earlier versions are converted silently, as old names are, and unknown ones are
    dropped with a warning.

    Parameters
    ----------
    block_type : str
        Name of the block, with or without namespace.
    properties : Mapping[str, str], optional
        Properties given by the program.
    table : BlockTable, optional
        Blocks of the version; by default the current one.
    similar : Similar, optional
        Function that returns the name closest in meaning.
    span : Span, optional
        Source location for warnings.
    """
    table = table or load_table()
    name = namespaced(block_type)
    given = dict(properties or {})
    kind = table.blocks.get(name) or _renamed(name, table)
    if kind is not None:
        current = modern(name, kind, given, table)
        return _resolved(
            current.kind,
            current.given,
            *(_ignored_property(current.kind, *pair, span) for pair in current.dropped.items()),
        )
    kind = _nearest(name.partition(":")[2][:_MAX_NAME_LENGTH], table, similar)
    current = modern(name, kind, given, table)
    dropped = ", ".join(f"{key}={value}" for key, value in given.items() if key in current.dropped)
    dropped_text = f", without {dropped}" if dropped else ""
    unknown = f"Minecraft {table.version} has no block `{name[:_MAX_NAME_LENGTH]}`"
    message = f"{unknown}; using `{current.kind.name}` instead{dropped_text}"
    return _resolved(current.kind, current.given, Diagnostic("unknown-block", message, span))


def _resolved(kind: BlockKind, given: Mapping[str, str], *warnings: Diagnostic) -> Resolved:
    """Return a block's state with the given properties and defaults."""
    state = BlockState(kind.name, tuple(sorted({**kind.defaults, **given}.items())))
    return Resolved(state, frozenset(given), warnings)


def _renamed(name: str, table: BlockTable) -> BlockKind | None:
    """Return the block that replaced an older name, None if it was not renamed."""
    other = renamed(name.removeprefix(NAMESPACE), {known.removeprefix(NAMESPACE) for known in table.blocks})
    return None if other is None else table.blocks[NAMESPACE + other]


def _nearest(name: str, table: BlockTable, similar: Similar | None) -> BlockKind:
    """Return the replacement for an unknown block, never an operator-only one."""
    names = [kind.name.removeprefix(NAMESPACE) for kind in table.blocks.values() if not kind.is_for_operators]
    replacement = alias(name, names)
    if replacement is None:
        replacement, similarity = nearest(name, names)
        if similar is not None and similarity < _MISSPELLING_SIMILARITY:
            similar_name = similar(name.replace("_", " "), names)
            replacement = similar_name if similar_name in names else replacement
    return table.blocks[NAMESPACE + replacement]


def _ignored_property(kind: BlockKind, name: str, value: str, span: Span | None) -> Diagnostic:
    """Return the warning for an unknown property or value."""
    if name not in kind.values:
        have = f"expected {_listed(kind.values)}" if kind.values else "it has no properties"
        message = f"the block `{kind.name}` has no property `{name[:_MAX_NAME_LENGTH]}`, which is ignored; {have}"
        return Diagnostic("block-property", message, span, hint=suggest(name, kind.values))
    values = _listed(kind.values[name], "or")
    message = f"`{name}` of `{kind.name}` must be {values}; `{value[:_MAX_NAME_LENGTH]}` is ignored"
    return Diagnostic("block-property", message, span, hint=suggest(value, kind.values[name]))


def _listed(names: Sequence[str] | Mapping[str, object], last: str = "and") -> str:
    """Return quoted names as an English list."""
    shown = [f"`{name}`" for name in names]
    return f" {last} ".join(part for part in (", ".join(shown[:-1]), shown[-1]) if part)


# Resolution of whole builds to complete block states of the game.


_BATCH_CELLS = 1 << 22  # cells processed per batch


@dataclass(frozen=True, slots=True, eq=False)
class Settled:
    """A build of complete block states, with one warning for each block that was replaced or ignored."""

    build: Build
    warnings: tuple[Diagnostic, ...]


def nearest_by_meaning(name: str, candidates: Sequence[str]) -> str | None:
    """Return the candidate closest in meaning, None if CLIP, which measures it, is not installed.

    Only weights that are already on the machine are used: a misspelled block does not justify a download of 4 GB.
    """
    nearest_word = SERVICES.optional("nearest-word")
    candidate: str | None = None if nearest_word is None else nearest_word(name, candidates)
    return candidate


def settled(voxels: Voxels, table: BlockTable | None = None, similar: Similar | None = nearest_by_meaning) -> Settled:
    """Resolve ``voxels`` to complete states of the version of ``table``.

    Unknown blocks are replaced (see ``resolve``), neighbor-dependent properties are computed unless the program sets
    them, and the others get defaults.
    """
    table = table or load_table()
    requested = voxels.build
    resolved = [Resolved(AIR_STATE)] + [
        resolve(state.name, dict(state.properties), table, similar, place)
        for state, place in zip(requested.palette[1:], voxels.places[1:])
    ]
    warnings = {warning.message: warning for state in resolved for warning in state.warnings}
    build = unified(requested.origin, *_with_neighbors(requested.cells, resolved, table))
    ignored_words = ignored(voxels)
    more = (warning for warning in (ignored_words, voxels.off_cells) if warning is not None)
    return Settled(build, (*warnings.values(), *more))


def _with_neighbors(cells: Cells, resolved: Sequence[Resolved], table: BlockTable) -> tuple[Cells, list[BlockState]]:
    """Return the cells with neighbor-dependent states applied, and the states of their indices."""
    states = [one.state for one in resolved]
    kinds = [table.blocks[state.name] for state in states]
    traits = Traits.of(states, kinds)
    new_cells = cells
    for shape in CONNECTED:
        numbers = np.flatnonzero(traits.shape == shape)
        if not len(numbers):
            continue
        around = Surroundings(cells, _cells_with(cells, numbers, len(states)))
        current = around.beside((0, 0, 0))
        choices = connected(shape, around, traits)
        if new_cells is cells:
            new_cells = cells.copy()
        x, y, z = around.at
        new_cells[x, y, z] = _numbered(current, choices, resolved, states)
    return new_cells, states


def _cells_with(cells: Cells, numbers: IntArray, count: int) -> IntArray:
    """Return the cells (3, N) that contain one of ``numbers``."""
    is_selected = np.zeros(count, np.bool_)
    is_selected[numbers] = True
    slab = max(1, _BATCH_CELLS // max(1, cells[:1].size))
    parts = []
    for start in range(0, len(cells), slab):
        at = np.array(np.nonzero(is_selected[cells[start : start + slab]]), np.int64)
        at[0] += start
        parts.append(at)
    return np.concatenate(parts, axis=1)


def _numbered(current: IntArray, choices: Choices, resolved: Sequence[Resolved], states: list[BlockState]) -> IntArray:
    """Return the index of each cell's state after applying ``choices``; new states are appended to ``states``."""
    code = current.copy()
    for places, values in choices.values():
        code = code * len(values) + places
    _, first, inverse = np.unique(code, return_index=True, return_inverse=True)
    indices = []
    for row in first.tolist():
        before = resolved[int(current[row])]
        computed = {name: values[int(places[row])] for name, (places, values) in choices.items()}
        chosen = {name: value for name, value in computed.items() if name not in before.given}
        indices.append(len(states))
        states.append(BlockState(before.state.name, tuple(sorted({**dict(before.state.properties), **chosen}.items()))))
    return np.array(indices, np.int64)[inverse]
