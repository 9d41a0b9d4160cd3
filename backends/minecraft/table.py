"""The blocks of one version of the game, read from the table that ``extract`` wrote."""

from __future__ import annotations

import gzip
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib.resources import files

from scenelang.backends.minecraft.blocks import BlockState

# What only operators can place, or what is no block of its own: never laid in place of another block.
_FOR_OPERATORS = frozenset({
    "command_block", "repeating_command_block", "chain_command_block", "structure_block", "structure_void", "jigsaw",
    "barrier", "light", "test_block", "test_instance_block", "moving_piston", "piston_head", "end_portal",
    "nether_portal", "end_gateway", "spawner", "trial_spawner", "vault", "bubble_column", "fire", "soul_fire",
    "air", "cave_air", "void_air",
})  # fmt: skip


@dataclass(frozen=True, slots=True)
class BlockKind:
    """What is known of a block.

    ``shape``: air, cube (one whole cell), slab, stairs, pane, fence, gate, wall, door, trapdoor, fluid, plant (crossed
    planes), thin (nothing that stops a walker) or box. ``box``: what stops one, in sixteenths of the cell (min x, y, z,
    max x, y, z), of the default state; None where nothing does. ``color``: the average of its faces, sRGB from 0 to
    255, None where nothing is drawn; ``opacity`` from 0 to 1. ``light``: that it gives, from 0 to 15. ``transparent``:
    light goes through. ``values`` are the possible values of each property, ``defaults`` what it has otherwise.
    """

    name: str
    shape: str
    color: tuple[int, int, int] | None
    opacity: float
    light: int
    transparent: bool
    hardness: float
    box: tuple[int, int, int, int, int, int] | None
    values: Mapping[str, tuple[str, ...]]
    defaults: Mapping[str, str]

    @property
    def is_for_operators(self) -> bool:
        """True for commands, structures and the like, and for what the game alone places."""
        return self.name.removeprefix("minecraft:") in _FOR_OPERATORS

    def allows(self, state: BlockState) -> bool:
        """True where ``state`` has exactly this block's properties, each with a possible value."""
        given = dict(state.properties)
        return given.keys() == self.values.keys() and all(given[name] in self.values[name] for name in given)


@dataclass(frozen=True, slots=True)
class Table:
    """Every block of a version by its full name, ``minecraft:stone``; ``data_version`` is what files call it."""

    version: str
    data_version: int
    blocks: Mapping[str, BlockKind]


@cache
def load_table() -> Table:
    """The table that comes with the package."""
    packed = files("scenelang.backends.minecraft").joinpath("blocks.tsv.gz").read_bytes()
    head, *lines = gzip.decompress(packed).decode("ascii").splitlines()
    _, version, data_version = head.split("\t")
    kinds = [_kind(line.split("\t")) for line in lines]
    return Table(version, int(data_version), {kind.name: kind for kind in kinds})


def _kind(fields: list[str]) -> BlockKind:
    name, shape, color, opacity, light, transparent, hardness, box, properties = fields
    values: dict[str, tuple[str, ...]] = {}
    defaults: dict[str, str] = {}
    for pair in properties.split():
        key, listed = pair.split("=")
        values[key] = tuple(value.rstrip("*") for value in listed.split("|"))
        defaults[key] = next(value[:-1] for value in listed.split("|") if value.endswith("*"))
    sides = [int(n) for n in box.split(",")] if box else []
    return BlockKind(
        f"minecraft:{name}",
        shape,
        (int(color[:2], 16), int(color[2:4], 16), int(color[4:], 16)) if color else None,
        float(opacity),
        int(light),
        transparent == "1",
        float(hardness),
        (sides[0], sides[1], sides[2], sides[3], sides[4], sides[5]) if sides else None,
        values,
        defaults,
    )
