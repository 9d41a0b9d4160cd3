"""Builds as coloured cubes, for renderers that know nothing of blocks.

What stands in the cells in the end is drawn, in the average colours of the blocks: equal neighbours merged, slabs,
stairs, fences and the like in their shapes, glass and water with their opacity. Each cell stays with the entity whose
primitives laid it, so that a scene has the same parts as before.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from scenelang.backends.appearance import Look, look_of
from scenelang.backends.minecraft.asked import asked_state, is_hollow, place_of
from scenelang.backends.minecraft.blocks import AIR, AIR_STATE, BlockState, Build, Cells
from scenelang.backends.minecraft.cube_tree import Cube, parts_of, rebuilt
from scenelang.backends.minecraft.merging import Cuboids, merged
from scenelang.backends.minecraft.models import Bar, model_of
from scenelang.backends.minecraft.painting import IntArray, Laid, paint
from scenelang.backends.minecraft.placing import cells_around, first_cells, whole_sizes
from scenelang.backends.minecraft.settle import settled
from scenelang.backends.minecraft.table import BlockKind, load_table
from scenelang.backends.minecraft.voxels import Voxels
from scenelang.backends.studio import from_srgb
from scenelang.grammar.diagnostics import Diagnostic, LimitError
from scenelang.grammar.source import Span
from scenelang.interpreter.entity import Entity, Scene, descendants, primitive_count
from scenelang.interpreter.flatten import flatten_entity
from scenelang.interpreter.shapes import BLOCK_WORDS, Kind, Shape
from scenelang.interpreter.values import ANONYMOUS, IDENTITY, Embedding, Pair, Vector

MOST_CELLS = 64_000_000
_SLAB = 1 << 22  # cells that are looked at together


@dataclass(frozen=True, slots=True)
class _Ink:
    """What a primitive lays: the block it asks for, and the look that the program gives it."""

    state: BlockState
    look: Look
    given: frozenset[str]


def as_cubes(scene: Scene, limit: int = 2_000_000, warn: Callable[[Diagnostic], None] | None = None) -> Scene:
    """``scene`` with its blocks as cubes, everything else as it is; itself where it has no blocks.

    ``warn`` is told which blocks were replaced by others. Raises SceneError: "blocks" for poses that blocks cannot
    have, "attribute" for blocks that are none, and LimitError for more than ``limit`` primitives
    or cubes, or too many cells.
    """
    if not any(entity.word in BLOCK_WORDS for entity in descendants(*scene.frames)):
        return scene
    told: dict[str, Diagnostic] = {}
    made: dict[int, Entity] = {}
    for root in scene.frames:
        if id(root) not in made:
            made[id(root)], warnings = _as_cubes(root, limit)
            told |= {warning.message: warning for warning in warnings}
    for warning in told.values():
        if warn is not None:
            warn(warning)
    return Scene(scene.word, [made[id(root)] for root in scene.frames], scene.animated)


def _as_cubes(root: Entity, limit: int) -> tuple[Entity, tuple[Diagnostic, ...]]:
    if root.is_primitive:
        root = Entity(root.word, ANONYMOUS, (Pair(root, IDENTITY),))
    _check(primitive_count(root), limit, "primitives")
    flat = flatten_entity(root, whole_cells=False)
    is_block = np.array([primitive.word in BLOCK_WORDS for primitive in flat.primitives])[flat.index]
    blocks, parts = flat.only(is_block), parts_of(root, is_block)
    inks = [_ink(primitive) for primitive in blocks.primitives]
    pairs, number = np.unique(parts.owner * len(inks) + blocks.index, return_inverse=True)
    owners, ink = pairs // len(inks), pairs % len(inks)
    is_air = np.array([each.state == AIR_STATE for each in inks], np.bool_)
    low, size = first_cells(blocks), whole_sizes(blocks)
    hollow = np.array([is_hollow(p) for p in blocks.primitives], np.bool_)
    laid_number = np.where(is_air[blocks.index], AIR, number.reshape(-1) + 1)
    laid = Laid(low, low + size, laid_number, hollow[blocks.index], np.full(len(low), -1, np.int64))
    origin, extent = cells_around(laid, MOST_CELLS)
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
    if count > limit:
        message = f"the build has {count:,} {what}, more than the {limit:,} that may be drawn at once"
        raise LimitError("primitives", message, hint="draw a part of it, or export it as a file of the game's")


def _ink(primitive: Entity) -> _Ink:
    given = {name for name, value in primitive.embedding.attributes.items() if value is not None}
    return _Ink(asked_state(primitive), look_of(primitive), frozenset(given))


# --- what stands in each cell ----------------------------------------------------------------------------------------


def _states(
    cells: Cells, inks: Sequence[_Ink], places: Sequence[Span | None]
) -> tuple[Cells, tuple[BlockState, ...], tuple[Diagnostic, ...]]:
    """The number of each cell's whole state, neighbours heard, in a palette; and what was replaced."""
    asked: dict[BlockState, int] = {AIR_STATE: AIR}
    first: list[Span | None] = [None]
    used = np.unique(cells)
    numbers = np.zeros(len(inks) + 1, np.uint32)
    for n in used[used != AIR].tolist():
        state = inks[n - 1].state
        if state not in asked:
            asked[state] = len(asked)
            first.append(places[n - 1])
        numbers[n] = asked[state]
    build = Build((0, 0, 0), numbers[cells], tuple(asked))
    found = settled(Voxels(build, tuple(first), ()))
    return found.build.cells, found.build.palette, found.warnings


def _combined(pairs: Cells, states: Cells) -> tuple[Cells, IntArray, IntArray]:
    """One number for what was laid and what it became: the cells, and both for every number (entry 0 is air)."""
    span = int(states.max(initial=0)) + 1
    slab = max(1, _SLAB // max(1, pairs[:1].size))
    starts = range(0, len(pairs), slab)
    codes = [pairs[s : s + slab].astype(np.int64) * span + states[s : s + slab] for s in starts]
    known = np.unique(np.concatenate([np.zeros(1, np.int64), *map(np.unique, codes)]))
    fresh = np.empty(pairs.shape, np.uint32)
    for start, code in zip(starts, codes):
        fresh[start : start + slab] = np.searchsorted(known, code)
    return fresh, known // span, known % span


# --- what is drawn ---------------------------------------------------------------------------------------------------


class _Looks:
    """Boxes and surfaces of what stands in the cells, each worked out once."""

    def __init__(self, inks: Sequence[_Ink], palette: Sequence[BlockState]) -> None:
        blocks = load_table().blocks
        self._inks, self._palette = inks, palette
        self._kinds = [blocks[state.name] for state in palette]
        self.model = cache(self._model)
        self.primitive = cache(self._primitive)

    def _model(self, state: int) -> tuple[Bar, ...]:
        return model_of(self._palette[state], self._kinds[state])

    def _primitive(self, ink: int, state: int, place: Span | None) -> Entity:
        kind = self._kinds[state]
        return _cube(kind.name.removeprefix("minecraft:"), _look(self._inks[ink], kind), place)


def _look(ink: _Ink, kind: BlockKind) -> Look:
    """The block's colour and opacity, where the program does not set its own."""
    look = ink.look
    red, green, blue = from_srgb(np.array(kind.color or (0, 0, 0)) / 255.0).tolist()
    color = look.color if "color" in ink.given else (red, green, blue)
    opacity = look.opacity if "opacity" in ink.given else kind.opacity
    return Look(color, look.emission, opacity, look.roughness, look.metallic, look.ior)


def _cube(word: str, look: Look, place: Span | None) -> Entity:
    """A unit cube of that look."""
    given = {"opacity": look.opacity, "roughness": look.roughness, "metallic": look.metallic, "ior": look.ior}
    attributes: dict[str, Any] = {n: v for n, v in given.items() if v is not None and (n, v) not in _PLAIN}
    if any(look.emission):
        attributes["emission"] = Vector(look.emission)
    embedding = Embedding(attributes={"color": Vector(look.color), **attributes})
    return Entity(word, embedding, (), Shape(Kind.CUBE, color=look.color), places=(place,) if place else ())


_PLAIN = (("opacity", 1.0), ("metallic", 0.0))


def _cubes(
    cuboids: Cuboids,
    origin: IntArray,
    owners: IntArray,
    inks: IntArray,
    states: IntArray,
    looks: _Looks,
    places: Sequence[Span | None],
) -> Iterator[Cube]:
    """Every box of every cuboid; ``owners``, ``inks`` and ``states`` are those of the numbers of the cells."""
    lows = (cuboids.low + origin).tolist()
    for low, size, number in zip(lows, cuboids.size.tolist(), cuboids.number.tolist()):
        ink, state = int(inks[number]), int(states[number])
        primitive = looks.primitive(ink, state, places[ink])
        for bar in looks.model(state):
            yield Cube(int(owners[number]), primitive, *_placed(bar, low, size), bar.turn)


def _placed(bar: Bar, low: list[int], size: list[int]) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """The corners of ``bar`` in a cuboid that begins at the cell ``low``; it goes from one end to the other."""
    return (
        tuple(a + b / 16.0 for a, b in zip(low, bar.low)),
        tuple(a + n - 1 + b / 16.0 for a, n, b in zip(low, size, bar.high)),
    )
