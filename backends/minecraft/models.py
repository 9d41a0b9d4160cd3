"""Block models as a few boxes: slabs, stairs, fences, doors and the like with the game's dimensions.

Boxes are in sixteenths of the cell: x east, y up, z south. Directional blocks are defined facing north and rotated.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from scenelang.backends.minecraft.blocks import (
    AIR,
    AIR_STATE,
    SIDES,
    BlockKind,
    BlockState,
    Build,
    Cells,
    Cuboids,
    load_table,
    merged,
)
from scenelang.backends.minecraft.connections import settled
from scenelang.backends.minecraft.voxels import (
    BoolArray,
    FloatArray,
    IntArray,
    Laid,
    Voxels,
    asked_state,
    cells_around,
    first_cells,
    is_hollow,
    paint,
    place_of,
    whole_sizes,
)
from scenelang.backends.surfaces.appearance import Look, look_of
from scenelang.backends.surfaces.image_files import from_srgb
from scenelang.grammar.datum import Span
from scenelang.grammar.diagnostics import Diagnostic, LimitError
from scenelang.interpreter.inspection.numbering import Ancestry, ancestry_of
from scenelang.interpreter.scene import pose
from scenelang.interpreter.scene.entity import Entity, Scene, descendants, primitive_count
from scenelang.interpreter.scene.flatten import flatten_entity
from scenelang.interpreter.scene.part_columns import distinct_entities
from scenelang.interpreter.scene.primitives.cube import Cube as CubeShape
from scenelang.interpreter.values.values import ANONYMOUS, IDENTITY, Embedding, Matrix, Pair, Vector

Point = tuple[float, float, float]
Properties = Mapping[str, str]


@dataclass(frozen=True, slots=True)
class Bar:
    """Box from ``low`` to ``high``, rotated by ``turn`` degrees around the vertical axis through the cell's center."""

    low: Point
    high: Point
    turn: float = 0.0

    def spans(self, axis: int) -> bool:
        """Return whether the box spans the whole cell along ``axis``."""
        return self.turn == 0.0 and self.low[axis] == 0.0 and self.high[axis] == 16.0


WHOLE = (Bar((0.0, 0.0, 0.0), (16.0, 16.0, 16.0)),)  # box of a full block


def model_of(state: BlockState, kind: BlockKind) -> tuple[Bar, ...]:
    """Return the boxes of a complete block state, empty if it is invisible."""
    if kind.color is None:
        return ()
    return _MODELS.get(kind.shape, _box)(kind, dict(state.properties))


def _bar(x0: float, y0: float, z0: float, x1: float, y1: float, z1: float) -> Bar:
    """Return an unrotated box."""
    return Bar((x0, y0, z0), (x1, y1, z1))


def _rotated(bar: Bar, quarters: int) -> Bar:
    """Rotate by quarter turns clockwise seen from above: north becomes east."""
    for _ in range(quarters % 4):
        (x0, y0, z0), (x1, y1, z1) = bar.low, bar.high
        bar = Bar((16.0 - z1, y0, x0), (16.0 - z0, y1, x1), bar.turn)
    return bar


def _facing(bars: tuple[Bar, ...], side: str) -> tuple[Bar, ...]:
    """Return boxes that face north rotated to another side."""
    return tuple(_rotated(bar, SIDES.index(side)) for bar in bars)


def _upside_down(bars: tuple[Bar, ...]) -> tuple[Bar, ...]:
    """Return boxes mirrored top to bottom."""
    return tuple(_bar(*_with_y(bar.low, 16.0 - bar.high[1]), *_with_y(bar.high, 16.0 - bar.low[1])) for bar in bars)


def _with_y(point: Point, y: float) -> Point:
    """Return a point at another height."""
    return point[0], y, point[2]


# --- shapes of the game ----------------------------------------------------------------------------------------------


def _cube(_: BlockKind, __: Properties) -> tuple[Bar, ...]:
    """Return a full block."""
    return WHOLE


def _slab(_: BlockKind, has: Properties) -> tuple[Bar, ...]:
    """Return a slab: a half or the whole cell."""
    low, high = {"bottom": (0, 8), "top": (8, 16), "double": (0, 16)}[has["type"]]
    return (_bar(0, low, 0, 16, high, 16),)


# The upper boxes of stairs that face north: they ascend to the north.
_STEPS = {
    "straight": (_bar(0, 8, 0, 16, 16, 8),),
    "outer_left": (_bar(0, 8, 0, 8, 16, 8),),
    "outer_right": (_bar(8, 8, 0, 16, 16, 8),),
    "inner_left": (_bar(0, 8, 0, 16, 16, 8), _bar(0, 8, 8, 8, 16, 16)),
    "inner_right": (_bar(0, 8, 0, 16, 16, 8), _bar(8, 8, 8, 16, 16, 16)),
}


def _stairs(_: BlockKind, has: Properties) -> tuple[Bar, ...]:
    """Return stairs: a bottom slab and steps by their corner."""
    bars = _facing((_bar(0, 0, 0, 16, 8, 16), *_STEPS[has["shape"]]), has["facing"])
    return _upside_down(bars) if has["half"] == "top" else bars


def _fence(_: BlockKind, has: Properties) -> tuple[Bar, ...]:
    """Return a fence: a post, and two rails to each connected side."""
    arms = (_bar(7, 6, 0, 9, 9, 6), _bar(7, 12, 0, 9, 15, 6))
    return (_bar(6, 0, 6, 10, 16, 10), *_arms(arms, [side for side in SIDES if has[side] == "true"]))


def _pane(_: BlockKind, has: Properties) -> tuple[Bar, ...]:
    """Return a pane: a thin post, and an arm to each connected side."""
    return (_bar(7, 0, 7, 9, 16, 9), *_arms((_bar(7, 0, 0, 9, 16, 7),), [s for s in SIDES if has[s] == "true"]))


def _wall(_: BlockKind, has: Properties) -> tuple[Bar, ...]:
    """Return a wall: a post unless it is straight, and low or tall arms."""
    post = (_bar(4, 0, 4, 12, 16, 12),) if has["up"] == "true" else (_bar(5, 0, 5, 11, 14, 11),)
    low = _arms((_bar(5, 0, 0, 11, 14, 8),), [side for side in SIDES if has[side] == "low"])
    return (*post, *low, *_arms((_bar(5, 0, 0, 11, 16, 8),), [side for side in SIDES if has[side] == "tall"]))


def _arms(north: tuple[Bar, ...], sides: list[str]) -> tuple[Bar, ...]:
    """Return boxes that face north, rotated to each of the sides."""
    return tuple(bar for side in sides for bar in _facing(north, side))


def _gate(_: BlockKind, has: Properties) -> tuple[Bar, ...]:
    """Return a fence gate: two posts and two wings."""
    posts = (_bar(0, 5, 7, 2, 16, 9), _bar(14, 5, 7, 16, 16, 9))
    if has["open"] == "true":
        wings = tuple(_bar(x, y, 1, x + 2, y + 3, 7) for x in (0, 14) for y in (6, 12))
    else:
        wings = tuple(_bar(2, y, 7, 14, y + 3, 9) for y in (6, 12))
    return _facing((*posts, *wings), has["facing"])


def _door(_: BlockKind, has: Properties) -> tuple[Bar, ...]:
    """Return a door: opposite to its facing if closed, at its hinge if open."""
    turn = 0 if has["open"] == "false" else 1 if has["hinge"] == "left" else 3
    return (_rotated(_bar(0, 0, 13, 16, 16, 16), SIDES.index(has["facing"]) + turn),)


def _trapdoor(_: BlockKind, has: Properties) -> tuple[Bar, ...]:
    """Return a trapdoor: upright if open, else at the top or bottom."""
    if has["open"] == "true":
        return _facing((_bar(0, 0, 13, 16, 16, 16),), has["facing"])
    return (_bar(0, 13, 0, 16, 16, 16) if has["half"] == "top" else _bar(0, 0, 0, 16, 3, 16),)


def _fluid(_: BlockKind, has: Properties) -> tuple[Bar, ...]:
    """Return a whole cell, or the height of a flowing fluid; the game draws sources below air 2/16 lower."""
    level = int(has.get("level", "0"))
    return (_bar(0, 0, 0, 16, round((8 - level) / 8 * 16), 16),) if 0 < level < 8 else WHOLE


def _plant(kind: BlockKind, has: Properties) -> tuple[Bar, ...]:
    """Return two thin sheets across the diagonals."""
    is_tall = kind.name.endswith(("sugar_cane", "_plant")) or has.get("half") == "lower"
    high = 16.0 if is_tall else 13.0
    sheet = (0.0, 0.0, 7.8), (16.0, high, 8.2)
    return Bar(*sheet, turn=45.0), Bar(*sheet, turn=-45.0)


# --- thin blocks, by name --------------------------------------------------------------------------------------------

_BOARD = _bar(0, 7, 7.4, 16, 16, 8.6)
_THIN: tuple[tuple[str, tuple[Bar, ...]], ...] = (
    ("wall_torch", (_bar(7, 3, 11, 9, 13, 14),)),
    ("torch", (_bar(7, 0, 7, 9, 10, 9),)),
    ("wall_hanging_sign", (_bar(1, 0, 7, 15, 10, 9), _bar(0, 14, 6, 16, 16, 10))),
    ("hanging_sign", (_bar(1, 0, 7, 15, 10, 9), _bar(2, 10, 7.6, 14, 16, 8.4))),
    ("wall_sign", (_bar(0, 4.5, 14, 16, 12.5, 16),)),
    ("_sign", (_BOARD, _bar(7.4, 0, 7.4, 8.6, 7, 8.6))),
    ("wall_banner", (_bar(1, 0, 14, 15, 14, 15),)),
    ("_banner", (_bar(1, 2, 7, 15, 16, 8), _bar(7.5, 0, 8, 8.5, 16, 9))),
    ("pressure_plate", (_bar(1, 0, 1, 15, 1, 15),)),
    ("lever", (_bar(5, 0, 4, 11, 3, 12), _bar(7, 1, 5, 9, 9, 7))),
    ("_button", (_bar(5, 0, 6, 11, 2, 10),)),
    ("tripwire_hook", (_bar(6, 1, 8, 10, 9, 16),)),
    ("fire", (Bar((0, 0, 7.8), (16, 14, 8.2), 45.0), Bar((0, 0, 7.8), (16, 14, 8.2), -45.0))),
    ("coral_wall_fan", (_bar(0, 4, 5, 16, 12, 16),)),
    ("powder_snow", WHOLE),
    ("end_portal", (_bar(0, 6, 0, 16, 12, 16),)),
    ("portal", (_bar(0, 0, 6, 16, 16, 10),)),
    ("end_gateway", WHOLE),
    ("dripleaf", (_bar(5, 0, 5, 11, 13, 11),)),
    ("_stem", (_bar(7, 0, 7, 9, 8, 9),)),
    ("seagrass", (Bar((0, 0, 7.8), (16, 12, 8.2), 45.0), Bar((0, 0, 7.8), (16, 12, 8.2), -45.0))),
    ("spore_blossom", (_bar(1, 13, 1, 15, 16, 15),)),
)
_FLAT = (_bar(0, 0, 0, 16, 1, 16),)  # rails, redstone, petals and the like
_SHEETS = ("up", "down", *SIDES)  # faces on which vines and lichens grow


def _thin(kind: BlockKind, has: Properties) -> tuple[Bar, ...]:
    """Return a block without collision by its name, attached and rotated by its properties."""
    if kind.name.endswith(("vine", "lichen", "resin_clump")):
        return tuple(_sheet(side) for side in _SHEETS if has.get(side) == "true") or (_sheet("down"),)
    bars = next((bars for name, bars in _THIN if name in kind.name), _FLAT)
    if "face" in has:
        bars = _fixed(bars, has["face"])
    if has.get("facing") in SIDES:
        return _facing(bars, has["facing"])
    if has.get("axis") == "z":
        return _facing(bars, "east")
    if "rotation" in has:  # sixteenths of a full turn, clockwise from south
        return tuple(Bar(bar.low, bar.high, -22.5 * int(has["rotation"])) for bar in bars)
    return bars


def _sheet(side: str) -> Bar:
    """Return a thin sheet on a face of the cell."""
    if side in ("up", "down"):
        return _bar(0, 15.5, 0, 16, 16, 16) if side == "up" else _bar(0, 0, 0, 16, 0.5, 16)
    return _rotated(_bar(0, 0, 0, 16, 16, 0.5), SIDES.index(side))


def _fixed(bars: tuple[Bar, ...], face: str) -> tuple[Bar, ...]:
    """Attach buttons and levers, defined on the floor, to a wall behind them or to the ceiling."""
    if face == "ceiling":
        return _upside_down(bars)
    if face == "wall":
        return tuple(
            _bar(bar.low[0], bar.low[2], 16 - bar.high[1], bar.high[0], bar.high[2], 16 - bar.low[1]) for bar in bars
        )
    return bars


# --- other blocks ----------------------------------------------------------------------------------------------------


def _box(kind: BlockKind, has: Properties) -> tuple[Bar, ...]:
    """Return the collision box of the default state, rotated to the block's direction."""
    if "layers" in has:
        return (_bar(0, 0, 0, 16, 2 * int(has["layers"]), 16),)
    x0, y0, z0, x1, y1, z1 = (min(16, max(0, side)) for side in kind.box or (0, 0, 0, 16, 2, 16))
    bar = _bar(x0, y0, z0, x1, y1, z1)
    along = {"north": "z", "south": "z", "east": "x", "west": "x"}.get(has.get("facing", ""), has.get("axis", "y"))
    upright = kind.defaults.get("axis") == "y" or kind.defaults.get("facing") in ("up", "down")
    if upright:
        return (_laid_down(bar, along),)
    if has.get("facing") in SIDES and kind.defaults["facing"] in SIDES:
        return (_rotated(bar, SIDES.index(has["facing"]) - SIDES.index(kind.defaults["facing"])),)
    return (bar,)


def _laid_down(bar: Bar, axis: str) -> Bar:
    """Rotate an upright box so that it is along x or z."""
    (x0, y0, z0), (x1, y1, z1) = bar.low, bar.high
    if axis == "x":
        return Bar((y0, x0, z0), (y1, x1, z1))
    return Bar((x0, z0, y0), (x1, z1, y1)) if axis == "z" else bar


_MODELS: Mapping[str, Callable[[BlockKind, Properties], tuple[Bar, ...]]] = {
    "cube": _cube, "slab": _slab, "stairs": _stairs, "fence": _fence, "pane": _pane, "wall": _wall, "gate": _gate,
    "door": _door, "trapdoor": _trapdoor, "fluid": _fluid, "plant": _plant, "thin": _thin, "box": _box,
}  # fmt: skip


# Entities with cubes instead of the primitives that place blocks. Equal neighbors are merged only within the entity
# whose primitives placed them, so that trees, maps, glTF hierarchies and the viewer's selection keep their parts. Every
# entity that contains blocks keeps its position, at whole cells, with its own cubes next to its children. Beyond
# ``MAX_PARTS`` entities, the entities of the deepest level that fits are used, and handles in maps refer to that tree.
# Identical subtrees are shared.


MAX_PARTS = 20_000  # entities of a frame with separate cubes

Corner = tuple[float, ...]


@dataclass(frozen=True, slots=True)
class ModelCube:
    """Box of the instance ``owner`` from ``low`` to ``high`` in the world.

    It is rotated by ``turn`` degrees around the vertical axis through its cell's center. ``primitive`` is a unit cube
    with its look.
    """

    owner: int
    primitive: Entity
    low: Corner
    high: Corner
    turn: float


@dataclass(frozen=True, slots=True, eq=False)
class CubeParts:
    """Assignment of blocks to instances of a frame (see ``ancestry``).

    ``depth`` is the deepest level whose instances have separate cubes, ``owner`` the instance that owns each primitive
    that places blocks.
    """

    ancestry: Ancestry
    depth: int
    owner: IntArray
    has_blocks: BoolArray  # (M,) of the instances


def parts_of(root: Entity, is_block: BoolArray) -> CubeParts:
    """Return the assignment of blocks to instances of a frame.

    ``is_block`` (N,) marks the primitives that place blocks. The root is not a primitive.
    """
    ancestry = ancestry_of(root)
    with_blocks: set[int] = set()
    for entity in descendants(root):
        if entity.is_block or any(id(child) in with_blocks for child in distinct_entities(entity.children)):
            with_blocks.add(id(entity))
    is_leaf = np.array([entity.is_primitive for entity in ancestry.nodes])[ancestry.node]
    has_blocks = np.array([id(entity) in with_blocks for entity in ancestry.nodes])[ancestry.node] & ~is_leaf
    instances_up_to = np.cumsum(np.bincount(ancestry.depth[has_blocks], minlength=1))
    depth = max(0, int(np.searchsorted(instances_up_to, MAX_PARTS, side="right")) - 1)
    parents = ancestry.parent[ancestry.primitives[is_block]]
    return CubeParts(ancestry, depth, ancestry.at_depth(depth)[parents], has_blocks)


def rebuilt(parts: CubeParts, cubes: Iterable[ModelCube]) -> Entity:
    """Return the root with ``cubes`` instead of the primitives that place blocks; all others are unchanged."""
    ancestry = parts.ancestry
    anchors = np.trunc(ancestry.poses[:, :, 3])
    inside: defaultdict[int, list[Pair]] = defaultdict(list)
    for cube in cubes:
        inside[cube.owner].append(Pair(cube.primitive, _pose(cube, anchors[cube.owner])))
    _keep_others(parts, anchors, inside)
    shared: dict[object, Entity] = {}
    for i in np.flatnonzero(parts.has_blocks & (ancestry.depth <= parts.depth))[::-1].tolist():
        children = tuple(inside.pop(i, ()))
        if not children and i:
            continue
        key = int(ancestry.node[i]), tuple((id(part.car), part.cdr) for part in children)
        if key not in shared:
            entity = ancestry.entity(i)
            shared[key] = Entity(entity.word, entity.embedding, children)
        if i == 0:
            return shared[key]
        parent = int(ancestry.parent[i])
        inside[parent].insert(0, Pair(shared[key], pose.translation(*(anchors[i] - anchors[parent]).tolist())))
    raise AssertionError("the root has blocks below it")


def _keep_others(parts: CubeParts, anchors: FloatArray, inside: defaultdict[int, list[Pair]]) -> None:
    """Add the topmost entities without blocks to the instances that contain them."""
    ancestry = parts.ancestry
    is_child = parts.has_blocks[ancestry.parent] & (ancestry.parent >= 0)
    is_block = np.array([entity.is_block for entity in ancestry.nodes])[ancestry.node]
    others = np.flatnonzero(is_child & ~parts.has_blocks & ~is_block)
    owners = ancestry.at_depth(parts.depth)[ancestry.parent[others]]
    for i, owner in zip(others.tolist(), owners.tolist()):
        local_pose = ancestry.poses[i].copy()
        local_pose[:, 3] -= anchors[owner]
        inside[owner].append(Pair(ancestry.entity(i), Matrix(local_pose.ravel().tolist())))


def _pose(cube: ModelCube, anchor: FloatArray) -> Matrix:
    """Return the pose of the unit cube in its owner."""
    low, high = np.array(cube.low) - anchor, np.array(cube.high) - anchor
    x, y, z = ((low + high) / 2.0).tolist()
    a, b, c = (high - low).tolist()
    placed = Matrix((a, 0.0, 0.0, x, 0.0, b, 0.0, y, 0.0, 0.0, c, z))
    if not cube.turn:
        return placed
    return pose.compose(pose.rotation(np.radians(cube.turn), (0.0, 1.0, 0.0), (np.floor(low) + 0.5).tolist()), placed)


# Builds as colored cubes, for renderers without support for blocks. The final contents of the cells are drawn in the
# average colors of the blocks: equal neighbors merged, slabs, stairs, fences and the like with their shapes, glass
# and water with their opacity. Each cell belongs to the entity whose primitives placed it, so that the scene's parts
# are preserved.


MAX_CELLS = 64_000_000  # of a build that is drawn
_BATCH_CELLS = 1 << 22  # cells processed per batch


@dataclass(frozen=True, slots=True)
class _Ink:
    """Block that a primitive requests, its look, and the attributes that the program sets itself."""

    state: BlockState
    look: Look
    overrides: frozenset[str]


def as_cubes(scene: Scene, limit: int, warn: Callable[[Diagnostic], None] | None) -> Scene:
    """Return ``scene`` with its blocks as cubes, as ``surfaces/stand_ins.drawn_scene`` describes."""
    warnings_by_message: dict[str, Diagnostic] = {}
    drawn_roots: dict[int, Entity] = {}
    for root in scene.frames:
        if id(root) not in drawn_roots:
            drawn_roots[id(root)], warnings = _as_cubes(root, limit)
            warnings_by_message |= {warning.message: warning for warning in warnings}
    for warning in warnings_by_message.values():
        if warn is not None:
            warn(warning)
    return scene.with_frames([drawn_roots[id(root)] for root in scene.frames])


def _as_cubes(root: Entity, limit: int) -> tuple[Entity, tuple[Diagnostic, ...]]:
    """Return a frame with its blocks as cubes, and the warnings about replaced blocks.

    Cells are painted with the number of a pair of instance and primitive, so that merged cuboids know both.
    """
    if root.is_primitive:
        root = Entity(root.word, ANONYMOUS, (Pair(root, IDENTITY),))
    _check(primitive_count(root), limit, "primitives")
    flat = flatten_entity(root, snap_blocks=False)
    is_block = np.array([primitive.is_block for primitive in flat.primitives])[flat.index]
    blocks, parts = flat.select(is_block), parts_of(root, is_block)
    inks = [_ink(primitive) for primitive in blocks.primitives]
    pairs, number = np.unique(parts.owner * len(inks) + blocks.index, return_inverse=True)
    owners, ink = pairs // len(inks), pairs % len(inks)
    is_air = np.array([placed.state == AIR_STATE for placed in inks], np.bool_)
    low, size = first_cells(blocks), whole_sizes(blocks)
    hollow = np.array([is_hollow(p) for p in blocks.primitives], np.bool_)
    laid_number = np.where(is_air[blocks.index], AIR, number.reshape(-1) + 1)
    laid = Laid(low, low + size, laid_number, hollow[blocks.index], np.full(len(low), -1, np.int64))
    origin, extent = cells_around(laid, MAX_CELLS)
    cells = np.zeros(extent, np.uint32)
    paint(cells, origin, laid, ())
    places = [place_of(primitive) for primitive in blocks.primitives]
    states, palette, warnings = _states(cells, [inks[i] for i in ink.tolist()], [places[i] for i in ink.tolist()])
    keys, pair, state = _combined(cells, states)
    looks = _Looks(inks, palette)
    kinds = [looks.model(n) for n in state.tolist()]
    along = np.array([[len(bars) == 1 and bars[0].spans(axis) for axis in range(3)] for bars in kinds], np.bool_)
    cuboids = merged(keys, along.reshape(-1, 3))
    _check(len(cuboids), limit, "cubes")
    cubes = _cubes(cuboids, origin, owners[pair - 1], ink[pair - 1], state, looks, places)
    return rebuilt(parts, cubes), warnings


def _check(count: int, limit: int, what: str) -> None:
    """Raise LimitError if a build has too many ``what``."""
    if count > limit:
        message = f"the build has {count:,} {what}, more than the limit of {limit:,}"
        raise LimitError("primitives", message, hint="draw a part of it, or export it to a Minecraft file")


def _ink(primitive: Entity) -> _Ink:
    """Return what a primitive places; raises SceneError for an invalid block."""
    overrides = {name for name, value in primitive.embedding.attributes.items() if value is not None}
    return _Ink(asked_state(primitive), look_of(primitive), frozenset(overrides))


# --- contents of the cells ------------------------------------------------------------------------------------------


def _states(
    cells: Cells, inks: Sequence[_Ink], places: Sequence[Span | None]
) -> tuple[Cells, tuple[BlockState, ...], tuple[Diagnostic, ...]]:
    """Return the palette index of each cell's complete state, the palette, and warnings about replacements.

    Properties that depend on neighbors are resolved.
    """
    requested: dict[BlockState, int] = {AIR_STATE: AIR}
    first: list[Span | None] = [None]
    used = np.unique(cells)
    numbers = np.zeros(len(inks) + 1, np.uint32)
    for n in used[used != AIR].tolist():
        state = inks[n - 1].state
        if state not in requested:
            requested[state] = len(requested)
            first.append(places[n - 1])
        numbers[n] = requested[state]
    build = Build((0, 0, 0), numbers[cells], tuple(requested))
    resolved = settled(Voxels(build, tuple(first), ()))
    return resolved.build.cells, resolved.build.palette, resolved.warnings


def _combined(pairs: Cells, states: Cells) -> tuple[Cells, IntArray, IntArray]:
    """Combine the ink and the state of each cell into one index; returns the indices, and both per index (0 is air)."""
    span = int(states.max(initial=0)) + 1
    batch = max(1, _BATCH_CELLS // max(1, pairs[:1].size))
    starts = range(0, len(pairs), batch)
    codes = [pairs[s : s + batch].astype(np.int64) * span + states[s : s + batch] for s in starts]
    distinct = np.unique(np.concatenate([np.zeros(1, np.int64), *map(np.unique, codes)]))
    indices = np.empty(pairs.shape, np.uint32)
    for start, code in zip(starts, codes):
        indices[start : start + batch] = np.searchsorted(distinct, code)
    return indices, distinct // span, distinct % span


# --- cubes -----------------------------------------------------------------------------------------------------------


class _Looks:
    """Cached boxes and materials of the contents of cells."""

    def __init__(self, inks: Sequence[_Ink], palette: Sequence[BlockState]) -> None:
        blocks = load_table().blocks
        self._inks, self._palette = inks, palette
        self._kinds = [blocks[state.name] for state in palette]
        self.model = cache(self._model)
        self.primitive = cache(self._primitive)

    def _model(self, state: int) -> tuple[Bar, ...]:
        """Return the boxes of a state."""
        return model_of(self._palette[state], self._kinds[state])

    def _primitive(self, ink: int, state: int, place: Span | None) -> Entity:
        """Return the unit cube of a state with the look of an ink."""
        kind = self._kinds[state]
        return _cube_of(kind.name.removeprefix("minecraft:"), _look(self._inks[ink], kind), place)


def _look(ink: _Ink, kind: BlockKind) -> Look:
    """Return the block's color and opacity, overridden by those that the program sets."""
    look = ink.look
    red, green, blue = from_srgb(np.array(kind.color or (0, 0, 0)) / 255.0).tolist()
    color = look.color if "color" in ink.overrides else (red, green, blue)
    opacity = look.opacity if "opacity" in ink.overrides else kind.opacity
    return Look(color, look.emission, opacity, look.roughness, look.metallic, look.ior)


def _cube_of(word: str, look: Look, place: Span | None) -> Entity:
    """Return a unit cube with the given look."""
    look_attributes = {"opacity": look.opacity, "roughness": look.roughness, "metallic": look.metallic, "ior": look.ior}
    attributes: dict[str, Any] = {
        name: value
        for name, value in look_attributes.items()
        if value is not None and (name, value) not in _DEFAULT_ATTRIBUTES
    }
    if any(look.emission):
        attributes["emission"] = Vector(look.emission)
    embedding = Embedding(attributes={"color": Vector(look.color), **attributes})
    return Entity(word, embedding, (), CubeShape(color=look.color), call_sites=(place,) if place else ())


_DEFAULT_ATTRIBUTES = (("opacity", 1.0), ("metallic", 0.0))  # attributes that are omitted because they are defaults


def _cubes(
    cuboids: Cuboids,
    origin: IntArray,
    owners: IntArray,
    inks: IntArray,
    states: IntArray,
    looks: _Looks,
    places: Sequence[Span | None],
) -> Iterator[ModelCube]:
    """Yield every box of every cuboid; ``owners``, ``inks`` and ``states`` are indexed by the cuboids' numbers."""
    lows = (cuboids.low + origin).tolist()
    for low, size, number in zip(lows, cuboids.size.tolist(), cuboids.number.tolist()):
        ink, state = int(inks[number]), int(states[number])
        primitive = looks.primitive(ink, state, places[ink])
        for bar in looks.model(state):
            yield ModelCube(int(owners[number]), primitive, *_placed(bar, low, size), bar.turn)


def _placed(bar: Bar, low: list[int], size: list[int]) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Return the corners of ``bar`` stretched over a cuboid of ``size`` that begins at the cell ``low``."""
    return (
        tuple(a + b / 16.0 for a, b in zip(low, bar.low)),
        tuple(a + n - 1 + b / 16.0 for a, n, b in zip(low, size, bar.high)),
    )
