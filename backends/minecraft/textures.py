"""The average colour of a block's faces, from the game's models and textures; only ``extract`` uses it."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from scenelang.backends.minecraft.state_models import variants

# What the game tints grey textures with, in a temperate plain (sRGB).
_GRASS, _LEAVES, _WATER = (0x91, 0xBD, 0x59), (0x77, 0xAB, 0x2F), (0x3F, 0x76, 0xE4)
_TINTS = {
    "birch_leaves": (0x80, 0xA7, 0x55), "spruce_leaves": (0x61, 0x99, 0x61), "lily_pad": (0x20, 0x80, 0x30),
    "redstone_wire": (0x4B, 0x00, 0x00), "water": _WATER, "bubble_column": _WATER, "water_cauldron": _WATER,
    "vine": _LEAVES, "attached_melon_stem": (0xE0, 0xC7, 0x1C), "attached_pumpkin_stem": (0xE0, 0xC7, 0x1C),
}  # fmt: skip
_ITS_WOOL = ("_bed", "_wall_banner", "_banner")  # drawn by the game itself: their models hold no faces
# Earth with something on it, of which one sees the top.
_COVERED = ("grass_block", "mycelium", "podzol", "dirt_path", "farmland", "crimson_nylium", "warped_nylium")
_DRAWN = {"water": "water_still", "bubble_column": "water_still", "lava": "lava_still"}


class Textures:
    """Models and textures of one version in the folder of `minecraft-assets`."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._models = json.loads((folder / "blocks_models.json").read_text("utf-8"))
        self._states = json.loads((folder / "blocks_states.json").read_text("utf-8"))

    def look(self, name: str, properties: Mapping[str, str]) -> tuple[str, float]:
        """The average colour as six hexadecimal digits, empty where nothing is drawn, and the mean alpha of what is
        translucent, else 1."""
        for ending in _ITS_WOOL:
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
        """True where every model is two crossed planes, or a field's crop."""
        models = list(self._chosen(name, {}, every=True))
        parents = [parent for model in models for parent in self._line(model)]
        return any(parent.endswith(("cross", "crop", "tinted_cross", "stem_fruit")) for parent in parents)

    def _faces(self, name: str, properties: Mapping[str, str]) -> Iterator[tuple[str, bool]]:
        """The texture of every face, and whether it is tinted; the particles' texture where there are no faces."""
        if name in _DRAWN:
            yield _DRAWN[name], name != "lava"
            return
        particles: list[str] = []
        found = False
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
                        found = True
                        yield file, "tintindex" in face
            file = _file("#particle", textures)
            if file is not None:
                particles.append(file)
        if not found:
            yield from ((file, False) for file in particles[:1])

    def _chosen(self, name: str, properties: Mapping[str, str], every: bool = False) -> Iterator[str]:
        """The models of a state; of all states where ``every``."""
        for variant in variants(self._states.get(name, {}), properties, every):
            yield _plain(variant["model"])

    def _line(self, model: str) -> Iterator[str]:
        """A model and its ancestors."""
        while model in self._models:
            yield model
            model = _plain(self._models[model].get("parent", ""))

    def _pixels(self, file: str) -> Any:
        """The pixels (N, 4) from 0 to 1; None where there is no such picture."""
        from PIL import Image

        path = self._folder / "blocks" / f"{file}.png"
        if not path.exists():
            return None
        with Image.open(path) as picture:
            return np.asarray(picture.convert("RGBA"), np.float64).reshape(-1, 4) / 255.0


def _plain(path: str) -> str:
    return path.removeprefix("minecraft:").removeprefix("block/")


def _file(texture: str, textures: Mapping[str, Any]) -> str | None:
    for _ in range(10):
        if not texture.startswith("#") and texture not in textures:
            return _plain(texture)
        given = textures.get(texture.removeprefix("#"))  # one model leaves the mark out
        if given is None:
            return None
        texture = given["sprite"] if isinstance(given, dict) else given
    return None


def _tint(name: str) -> tuple[int, int, int]:
    if name in _TINTS:
        return _TINTS[name]
    return _LEAVES if name.endswith("_leaves") else _GRASS


def _linear(color: Any) -> Any:
    return np.where(color <= 0.04045, color / 12.92, ((color + 0.055) / 1.055) ** 2.4)


def _encoded(color: Any) -> Any:
    return np.where(color <= 0.0031308, 12.92 * color, 1.055 * color ** (1 / 2.4) - 0.055)
