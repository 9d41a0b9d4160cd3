"""Blocks for colours: the families of blocks that may stand for them, and the nearest of these."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from scenelang.backends.appearance import Looks
from scenelang.backends.minecraft.asked import namespaced
from scenelang.backends.minecraft.blocks import AIR_STATE, BlockState, Build
from scenelang.backends.minecraft.filling import Filled
from scenelang.backends.minecraft.painting import FloatArray, IntArray
from scenelang.backends.minecraft.palettes import trimmed, unified
from scenelang.backends.minecraft.table import BlockKind, Table, load_table
from scenelang.backends.studio import from_srgb
from scenelang.backends.wording.color_words import oklab
from scenelang.grammar.diagnostics import SceneError, suggest

FAMILIES = ("wool", "concrete", "terracotta", "glass", "planks", "logs", "bricks", "leaves", "powder", "glazed", "all")
USUAL = "wool,concrete,terracotta,glass"
_SEEN_THROUGH = 0.5  # opacity: what is below it becomes a block that light goes through
_FALLS = ("_powder", "sand", "gravel", "anvil", "dragon_egg")  # never laid unless asked for: they fall
_NOT_FOR_ALL = (
    "_ore",
    "infested_",
    "shulker_box",
    "_leaves",
    "spawner",
    "tnt",
    "ice",
    "_coral_block",
    "sculk",
    "_head",
)
_ENDINGS = {"logs": ("_log", "_stem"), "bricks": ("bricks", "_bricks"), "powder": ("_concrete_powder",),
            "glazed": ("_glazed_terracotta",), "glass": ("glass",)}  # fmt: skip


@dataclass(frozen=True, slots=True, eq=False)
class Palette:
    """Blocks with their colours: ``points`` (K, 3) in Oklab, ``opacity`` (K,)."""

    states: tuple[BlockState, ...]
    points: FloatArray
    opacity: FloatArray


def palette_of(text: str, table: Table | None = None) -> Palette:
    """The palette that ``text`` names: families and blocks, separated by commas, such as ``wool,oak_planks``.

    Raises SceneError("value") for a name that is neither.
    """
    table = table or load_table()
    names = [name.strip().lower() for name in text.split(",") if name.strip()]
    kinds = {kind.name: kind for name in names for kind in _kinds(name, table)}
    if not kinds:
        raise SceneError("value", "a palette needs a block", hint=f"it can be one of {', '.join(FAMILIES)}")
    chosen = list(kinds.values())
    colors = from_srgb(np.array([kind.color for kind in chosen], np.float64) / 255.0)
    states = tuple(BlockState(kind.name, tuple(sorted(_lasting(kind).items()))) for kind in chosen)
    return Palette(states, oklab(colors), np.array([kind.opacity for kind in chosen]))


def matched(looks: Looks, palette: Palette) -> IntArray:
    """The number in ``palette`` of the nearest block of every look (K,), among the blocks that hide what is behind or
    among the others, as the look does. Nearest in Oklab, where hue counts double and lightness, which light and shade
    change anyway, half: a bright red is a red block rather than an orange one."""
    wanted = oklab(np.clip(looks.color, 0.0, 1.0))
    clear = palette.opacity < 1.0
    found = np.zeros(len(wanted), np.int64)
    for i, (point, opacity) in enumerate(zip(wanted, looks.opacity.tolist())):
        group = clear == (opacity < _SEEN_THROUGH)
        candidates = np.flatnonzero(group) if group.any() else np.arange(len(clear))
        found[i] = candidates[int(np.argmin(_distances(palette.points[candidates], point)))]
    return found


def _distances(points: FloatArray, wanted: FloatArray) -> FloatArray:
    """How far ``points`` (K, 3) are from ``wanted`` (3,): squares of the differences of lightness, chroma and hue."""
    lightness = points[:, 0] - wanted[0]
    chroma = np.hypot(points[:, 1], points[:, 2]) - np.hypot(wanted[1], wanted[2])
    apart = ((points[:, 1:] - wanted[1:]) ** 2).sum(axis=1)
    hue = np.maximum(0.0, apart - chroma**2)
    away: FloatArray = 0.25 * lightness**2 + chroma**2 + 4.0 * hue
    return away


def in_blocks(filled: Filled, palette: Palette) -> Build:
    """The build that a filled grid is in the blocks of ``palette``."""
    number = np.concatenate([[0], matched(filled.looks, palette) + 1]).astype(np.uint32)
    return trimmed(unified(filled.origin, number[filled.cells], (AIR_STATE, *palette.states)))


def _kinds(name: str, table: Table) -> Sequence[BlockKind]:
    """The blocks of a family, or the block of that name."""
    cubes = [kind for kind in table.blocks.values() if _is_building_block(kind)]
    if name == "all":
        return [kind for kind in cubes if kind.opacity == 1.0 and not _has(kind, (*_FALLS, *_NOT_FOR_ALL))]
    exact = table.blocks.get(namespaced(name))
    if exact is not None and name not in FAMILIES:
        if not _is_building_block(exact):
            raise SceneError("value", f"`{name}` is no block that fills a cell with a colour")
        return [exact]
    endings = _ENDINGS.get(name, (f"_{name}", f":{name}"))
    found = [kind for kind in cubes if kind.name.endswith(endings)]
    if name == "terracotta":
        found = [kind for kind in found if "glazed" not in kind.name]
    if not found:
        known = [*FAMILIES, *(kind.name.removeprefix("minecraft:") for kind in cubes)]
        hint = suggest(name, known) or f"families are {', '.join(FAMILIES)}; or name blocks"
        raise SceneError("value", f"there is no block or family of blocks `{name}`", hint=hint)
    return found


def _is_building_block(kind: BlockKind) -> bool:
    return kind.shape == "cube" and kind.color is not None and not kind.is_for_operators and "infested" not in kind.name


def _has(kind: BlockKind, parts: tuple[str, ...]) -> bool:
    return any(part in kind.name for part in parts)


def _lasting(kind: BlockKind) -> dict[str, str]:
    """The block's default state; leaves that do not wither."""
    return {**kind.defaults, "persistent": "true"} if "persistent" in kind.defaults else dict(kind.defaults)
