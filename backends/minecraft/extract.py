"""Writes the table of blocks from npm's `minecraft-data` and `minecraft-assets` (`make blocks`): FOLDER VERSION OUT.

Run by hand when a new version of the game is wanted; never by the package. ``FOLDER`` holds ``node_modules``. One line
for each block, in tabs: name, shape, average colour (sRGB), opacity, light, transparent, hardness, box in sixteenths,
properties with all their values, the default one marked by a star.
"""

from __future__ import annotations

import gzip
import json
import sys
from pathlib import Path
from typing import Any

from scenelang.backends.minecraft.textures import Textures

Row = dict[str, Any]


def main(folder: Path, version: str, out: Path) -> None:
    """Write the table of ``version`` to ``out``, compressed, the same bytes for the same data."""
    data = folder / "node_modules/minecraft-data/minecraft-data/data/pc"
    assets = folder / "node_modules/minecraft-assets/minecraft-assets/data" / version
    blocks = _json(data / version / "blocks.json")
    collisions = _json(data / version / "blockCollisionShapes.json")
    textures = Textures(assets)
    lines = [f"minecraft\t{version}\t{_data_version(data, version)}"]
    lines += ["\t".join(_fields(block, collisions, textures)) for block in blocks]
    out.write_bytes(gzip.compress(("\n".join(lines) + "\n").encode("ascii"), 9, mtime=0))
    print(f"{out}: {len(blocks)} blocks, {out.stat().st_size:,} bytes")


def _json(path: Path) -> Any:
    return json.loads(path.read_text("utf-8"))


def _data_version(data: Path, version: str) -> int:
    rows = _json(data / "common/protocolVersions.json")
    return int(next(row["dataVersion"] for row in rows if row["minecraftVersion"] == version))


def _fields(block: Row, collisions: Row, textures: Textures) -> list[str]:
    name = block["name"]
    boxes = _boxes(name, block, collisions)
    values = {state["name"]: state.get("values", ["true", "false"]) for state in block["states"]}
    defaults = _defaults(block, values)
    shape = _shape(name, values, boxes, textures)
    ripe = {"age": values["age"][-1]} if shape == "plant" and "age" in values else {}
    color, opacity = textures.look(name, defaults | ripe)
    return [
        name,
        shape,
        color,
        f"{opacity if shape in ('cube', 'pane', 'fluid') else 1.0:.2g}",
        str(block["emitLight"]),
        "1" if block["transparent"] else "0",
        f"{block['hardness']:g}",
        ",".join(f"{round(16 * n)}" for n in _around(boxes[block["defaultState"] - block["minStateId"]])),
        " ".join(
            f"{key}=" + "|".join(f"{value}*" if value == defaults[key] else value for value in values[key])
            for key in sorted(values)
        ),
    ]


def _boxes(name: str, block: Row, collisions: Row) -> list[list[list[float]]]:
    """The boxes that one bumps into, for each state."""
    found = collisions["blocks"][name]
    count = block["maxStateId"] - block["minStateId"] + 1
    numbers = [found] * count if isinstance(found, int) else found
    return [collisions["shapes"][str(number)] for number in numbers]


def _around(boxes: list[list[float]]) -> list[float]:
    """The box around boxes (min x, y, z, max x, y, z); empty for none."""
    if not boxes:
        return []
    return [(min if i < 3 else max)(box[i] for box in boxes) for i in range(6)]


def _defaults(block: Row, values: dict[str, list[str]]) -> dict[str, str]:
    """The default value of each property: states are numbered with the last property fastest."""
    number = block["defaultState"] - block["minStateId"]
    found: dict[str, str] = {}
    for name in reversed(values):
        number, place = divmod(number, len(values[name]))
        found[name] = values[name][place]
    return found


_BY_PROPERTIES = (  # the first whose properties a block has; what a property is called alone does not tell a fence
    ({"type", "waterlogged"}, "slab"),
    ({"facing", "half", "shape"}, "stairs"),
    ({"hinge"}, "door"),
    ({"in_wall"}, "gate"),
    ({"facing", "half", "open"}, "trapdoor"),
)
_BY_ENDING = (("_fence", "fence"), ("_wall", "wall"), ("_pane", "pane"), ("_bars", "pane"), ("air", "air"))


def _shape(name: str, values: dict[str, list[str]], boxes: list[list[list[float]]], textures: Textures) -> str:
    for wanted, shape in _BY_PROPERTIES:
        if wanted <= set(values) and (shape != "slab" or "double" in values["type"]):
            return shape
    for ending, shape in _BY_ENDING:
        if name.endswith(ending) and (shape == "air" or {"north", "east"} <= set(values)):
            return shape
    if name in ("water", "lava", "bubble_column"):
        return "fluid"
    if all(found == [[0, 0, 0, 1, 1, 1]] for found in boxes):
        return "cube"
    if textures.is_cross(name):
        return "plant"
    return "box" if any(boxes) else "thin"


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2], Path(sys.argv[3]))
