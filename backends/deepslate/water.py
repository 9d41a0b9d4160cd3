"""Which blocks hold water: water itself, and what stands in it."""

from __future__ import annotations

from scenelang.backends.minecraft.blocks import BlockState

WATER_TEXTURES = ("minecraft:block/water_still", "minecraft:block/water_flow")
_WATER = frozenset({"minecraft:water", "minecraft:bubble_column"})
_PLANTS = frozenset({"minecraft:kelp", "minecraft:kelp_plant", "minecraft:seagrass", "minecraft:tall_seagrass"})


def is_water(state: BlockState) -> bool:
    """True for a cell of nothing but water."""
    return state.name in _WATER


def is_wet(state: BlockState) -> bool:
    """True for a block with water around it, such as a waterlogged fence."""
    return state.name in _PLANTS or ("waterlogged", "true") in state.properties
