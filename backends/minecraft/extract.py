"""Generate the tables of Minecraft blocks from npm's `minecraft-data` and `minecraft-assets`: FOLDER VERSION TARGET.

Run manually for a new version of the game; never imported by the package. The game's textures are not in the
repository; average colors, shapes and states are facts about blocks and are. ``FOLDER`` contains ``node_modules``. The
table has one line per block, tab-separated: name, shape, average color (sRGB), opacity, light, transparent, hardness,
box in sixteenths, properties with all their values, defaults marked by a star.
"""

from __future__ import annotations

import gzip
import json
import re
import sys
from collections.abc import Iterator, Mapping
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from scenelang.backends.minecraft.blocks import RENAMES, variants

# The average color of a block's faces, from the game's models and textures.


# Tints of gray textures, in a temperate plains biome (sRGB).
_GRASS, _LEAVES, _WATER = (0x91, 0xBD, 0x59), (0x77, 0xAB, 0x2F), (0x3F, 0x76, 0xE4)
_TINTS = {
    "birch_leaves": (0x80, 0xA7, 0x55), "spruce_leaves": (0x61, 0x99, 0x61), "lily_pad": (0x20, 0x80, 0x30),
    "redstone_wire": (0x4B, 0x00, 0x00), "water": _WATER, "bubble_column": _WATER, "water_cauldron": _WATER,
    "vine": _LEAVES, "attached_melon_stem": (0xE0, 0xC7, 0x1C), "attached_pumpkin_stem": (0xE0, 0xC7, 0x1C),
}  # fmt: skip
_WOOL_ENDINGS = ("_bed", "_wall_banner", "_banner")  # rendered by code in the game: their models have no faces
# Earth with a cover: the top face is representative, because it is visible in a meadow. Crops have the ripe plant's
# color.
_COVERED = ("grass_block", "mycelium", "podzol", "dirt_path", "farmland", "crimson_nylium", "warped_nylium")
_FLUID_TEXTURES = {"water": "water_still", "bubble_column": "water_still", "lava": "lava_still"}


class Textures:
    """Models and textures of one version in the folder of `minecraft-assets`."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._models = json.loads((folder / "blocks_models.json").read_text("utf-8"))
        self._states = json.loads((folder / "blocks_states.json").read_text("utf-8"))

    def look(self, name: str, properties: Mapping[str, str]) -> tuple[str, float]:
        """Return the average color as hexadecimal digits, and the opacity.

        The color is empty for invisible blocks; the opacity is the mean alpha of translucent blocks, else 1.
        """
        for ending in _WOOL_ENDINGS:
            wool = name.removesuffix(ending) + "_wool"
            if name.endswith(ending) and wool in self._states:
                return self.look(wool, {})
        total, weight, alphas = np.zeros(3), 0.0, []
        for file, tinted in self._faces(name, properties):
            pixels = self._pixels(file)
            if pixels is None:
                continue
            alpha = pixels[:, 3]
            color = _linear(pixels[:, :3]) * (_linear(np.array(_tint(name)) / 255.0) if tinted else 1.0)
            total += (color * alpha[:, None]).sum(axis=0) / len(alpha)
            weight += alpha.mean()
            is_clear = ((alpha > 0.02) & (alpha < 0.98)).mean() > 0.2 or "glass" in name
            alphas.append(float(alpha.mean()) if is_clear else 1.0)
        if not weight:
            return "", 1.0
        color = np.rint(255.0 * _encoded(total / weight)).astype(int)
        return "".join(f"{n:02x}" for n in color), float(np.mean(alphas))

    def is_cross(self, name: str) -> bool:
        """Return whether every model consists of two crossed planes or is a crop."""
        models = list(self._chosen(name, {}, every=True))
        parents = [parent for model in models for parent in self._line(model)]
        return any(parent.endswith(("cross", "crop", "tinted_cross", "stem_fruit")) for parent in parents)

    def _faces(self, name: str, properties: Mapping[str, str]) -> Iterator[tuple[str, bool]]:
        """Yield the texture of every face and whether it is tinted; the particle texture if there are no faces."""
        if name in _FLUID_TEXTURES:
            yield _FLUID_TEXTURES[name], name != "lava"
            return
        particles: list[str] = []
        has_faces = False
        for model in self._chosen(name, properties):
            textures: dict[str, Any] = {}
            elements: list[Any] = []
            for parent in reversed(list(self._line(model))):
                textures.update(self._models[parent].get("textures", {}))
                elements = self._models[parent].get("elements", elements)
            for element in elements:
                for side, face in element["faces"].items():
                    if name in _COVERED and side != "up":
                        continue
                    file = _file(face["texture"], textures)
                    if file is not None:
                        has_faces = True
                        yield file, "tintindex" in face
            file = _file("#particle", textures)
            if file is not None:
                particles.append(file)
        if not has_faces:
            yield from ((file, False) for file in particles[:1])

    def _chosen(self, name: str, properties: Mapping[str, str], *, every: bool = False) -> Iterator[str]:
        """Yield the models of a state; of all states with ``every``."""
        for variant in variants(self._states.get(name, {}), properties, every):
            yield _plain(variant["model"])

    def _line(self, model: str) -> Iterator[str]:
        """Yield a model and its ancestors."""
        while model in self._models:
            yield model
            model = _plain(self._models[model].get("parent", ""))

    def _pixels(self, file: str) -> Any:
        """Return the pixels (N, 4) from 0 to 1, None if the texture does not exist."""
        from PIL import Image

        path = self._folder / "blocks" / f"{file}.png"
        if not path.exists():
            return None
        with Image.open(path) as image:
            return np.asarray(image.convert("RGBA"), np.float64).reshape(-1, 4) / 255.0


def _plain(path: str) -> str:
    """Return a model's path without its prefixes."""
    return path.removeprefix("minecraft:").removeprefix("block/")


def _file(texture: str, textures: Mapping[str, Any]) -> str | None:
    """Return the texture that a reference resolves to, None if it is missing or cyclic."""
    for _ in range(10):
        if not texture.startswith("#") and texture not in textures:
            return _plain(texture)
        reference = textures.get(texture.removeprefix("#"))  # one model omits the `#`
        if reference is None:
            return None
        texture = reference["sprite"] if isinstance(reference, dict) else reference
    return None


def _tint(name: str) -> tuple[int, int, int]:
    """Return the tint of a block's gray textures."""
    if name in _TINTS:
        return _TINTS[name]
    return _LEAVES if name.endswith("_leaves") else _GRASS


def _linear(color: Any) -> Any:
    """Return sRGB values as linear ones."""
    return np.where(color <= 0.04045, color / 12.92, ((color + 0.055) / 1.055) ** 2.4)


def _encoded(color: Any) -> Any:
    """Return linear values as sRGB ones."""
    return np.where(color <= 0.0031308, 12.92 * color, 1.055 * color ** (1 / 2.4) - 0.055)


Row = dict[str, Any]


def write_table(folder: Path, version: str, out: Path) -> None:
    """Write the compressed table of ``version`` to ``out``, reproducibly."""
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
    """Return the content of a JSON file."""
    return json.loads(path.read_text("utf-8"))


def _data_version(data: Path, version: str) -> int:
    """Return the number of a release in files."""
    rows = _json(data / "common/protocolVersions.json")
    return int(next(row["dataVersion"] for row in rows if row["minecraftVersion"] == version))


def _fields(block: Row, collisions: Row, textures: Textures) -> list[str]:
    """Return the fields of a block's line, which ``blocks._kind`` reads."""
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
    """Return the collision boxes of each state."""
    shape_numbers = collisions["blocks"][name]
    count = block["maxStateId"] - block["minStateId"] + 1
    numbers = [shape_numbers] * count if isinstance(shape_numbers, int) else shape_numbers
    return [collisions["shapes"][str(number)] for number in numbers]


def _around(boxes: list[list[float]]) -> list[float]:
    """Return the bounding box of boxes (min x, y, z, max x, y, z); empty for none."""
    if not boxes:
        return []
    return [(min if i < 3 else max)(box[i] for box in boxes) for i in range(6)]


def _defaults(block: Row, values: dict[str, list[str]]) -> dict[str, str]:
    """Return the default value of each property; states are numbered with the last property fastest."""
    number = block["defaultState"] - block["minStateId"]
    defaults: dict[str, str] = {}
    for name in reversed(values):
        number, place = divmod(number, len(values[name]))
        defaults[name] = values[name][place]
    return defaults


_BY_PROPERTIES = (  # the first match decides; names alone do not identify a fence
    ({"type", "waterlogged"}, "slab"),
    ({"facing", "half", "shape"}, "stairs"),
    ({"hinge"}, "door"),
    ({"in_wall"}, "gate"),
    ({"facing", "half", "open"}, "trapdoor"),
)
_BY_ENDING = (("_fence", "fence"), ("_wall", "wall"), ("_pane", "pane"), ("_bars", "pane"), ("air", "air"))


def _shape(name: str, values: dict[str, list[str]], boxes: list[list[list[float]]], textures: Textures) -> str:
    """Return the shape of a block: by its properties, its name, or its collision boxes."""
    for required, shape in _BY_PROPERTIES:
        if required <= set(values) and (shape != "slab" or "double" in values["type"]):
            return shape
    for ending, shape in _BY_ENDING:
        if name.endswith(ending) and (shape == "air" or {"north", "east"} <= set(values)):
            return shape
    if name in ("water", "lava", "bubble_column"):
        return "fluid"
    if all(state_boxes == [[0, 0, 0, 1, 1, 1]] for state_boxes in boxes):
        return "cube"
    if textures.is_cross(name):
        return "plant"
    return "box" if any(boxes) else "thin"


# History: one line for each block that has changed. Its name, then tab-separated eras: the first release, and the
# properties with their values, a dash if the block did not exist.


FIRST = "1.13"  # the release that introduced the current block names and properties


def write_history(folder: Path, version: str, out: Path) -> None:
    """Write the compressed eras of all blocks of ``version`` to ``out``, reproducibly."""
    data = folder / "node_modules/minecraft-data/minecraft-data/data"
    releases = _releases(data, version)
    known = {release: _blocks(data / path) for release, path in releases.items()}
    lines = [line for name in known[version] if (line := _line(name, known))]
    out.write_bytes(gzip.compress(("\n".join(lines) + "\n").encode("ascii"), 9, mtime=0))
    print(f"{out}: {len(lines)} blocks, {out.stat().st_size:,} bytes")


def _releases(data: Path, version: str) -> dict[str, str]:
    """Return the data folder of each release from FIRST to ``version``, oldest first."""
    paths = json.loads((data / "dataPaths.json").read_text("utf-8"))["pc"]
    rows = json.loads((data / "pc/common/protocolVersions.json").read_text("utf-8"))
    order = [row["minecraftVersion"] for row in rows]  # newest first
    chosen = order[order.index(version) : order.index(FIRST) + 1]
    released = [v for v in reversed(chosen) if re.fullmatch(r"[\d.]+", v) and "blocks" in paths.get(v, {})]
    return {v: paths[v]["blocks"] for v in released}


def _blocks(folder: Path) -> dict[str, str]:
    """Return the properties of every block, as ``name=value|value name=...``."""
    blocks: list[dict[str, Any]] = json.loads((folder / "blocks.json").read_text("utf-8"))
    return {block["name"]: _properties(block["states"]) for block in blocks}


def _properties(states: list[dict[str, Any]]) -> str:
    """Return the properties of a block's states as text."""
    values = {state["name"]: state.get("values") or _implied_values(state) for state in states}
    return " ".join(f"{name}={'|'.join(map(str, values[name]))}" for name in sorted(values))


def _implied_values(state: dict[str, Any]) -> list[str]:
    """Return the values that the data omits: integers or booleans."""
    return [str(n) for n in range(state["num_values"])] if state["type"] == "int" else ["true", "false"]


def _line(name: str, known: dict[str, dict[str, str]]) -> str:
    """Return the eras of a block; empty if there is only one."""
    former = [old for old, new in RENAMES if new == name]
    eras: list[tuple[str, str]] = []
    for release, blocks in known.items():
        current = next((alias for alias in (name, *former) if alias in blocks), None)
        eras.append((release, blocks[current] if current is not None else "-"))
    changes = [eras[0], *(b for a, b in pairwise(eras) if a[1] != b[1])]
    return "\t".join([name, *(f"{release} {era}".rstrip() for release, era in changes)]) if len(changes) > 1 else ""


if __name__ == "__main__":
    downloads, version, target = Path(sys.argv[1]), sys.argv[2], Path(sys.argv[3])
    write_table(downloads, version, target / "blocks.tsv.gz")
    write_history(downloads, version, target / "history.tsv.gz")
