"""A tiny resource pack that the tests make, in all the shapes in which looks come, and scenes of a few blocks."""

from __future__ import annotations

import io
import json
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from scenelang.grammar.datum import Source
from scenelang.interpreter.scene.entity import Scene
from scenelang.session.session import Options, Session

FACES = ("down", "up", "north", "south", "west", "east")
DEFINITIONS: dict[str, Any] = {
    "stone": {"variants": {"": [{"model": "minecraft:block/stone"}, {"model": "block/stone", "y": 180}]}},
    "glass": {"variants": {"": {"model": "block/glass"}}},
    "oak_log": {
        "variants": {
            "axis=x": {"model": "block/oak_log", "x": 90, "y": 90},
            "axis=y": {"model": "block/oak_log"},
            "axis=z": {"model": "block/oak_log", "x": 90},
        }
    },
    "oak_fence": {
        "multipart": [
            {"apply": {"model": "block/fence_post"}},
            {"when": {"OR": [{"east": "true"}, {"west": "true"}]}, "apply": {"model": "block/stone", "y": 90}},
        ]
    },
}
MODELS: dict[str, Any] = {
    "cube": {
        "elements": [
            {
                "from": [0, 0, 0],
                "to": [16, 16, 16],
                "faces": {side: {"texture": "#all", "cullface": side} for side in FACES},
            }
        ]
    },
    "stone": {"parent": "block/cube", "textures": {"all": "block/stone"}},
    "glass": {"parent": "minecraft:block/cube", "textures": {"all": {"sprite": "block/glass"}}},
    "oak_log": {"parent": "block/cube", "textures": {"all": "#side", "side": "block/oak_log"}},
    "fence_post": {
        "textures": {"all": "block/stone"},
        "elements": [
            {"from": [6, 0, 6], "to": [10, 16, 10], "faces": {"up": {"texture": "#all", "uv": [6, 6, 10, 10]}}}
        ],
    },
}
COLORS = {"stone": (120, 120, 120, 255), "glass": (200, 220, 255, 80), "oak_log": (110, 80, 40, 255)}


def png(color: tuple[int, ...], width: int = 16, height: int = 16) -> bytes:
    from PIL import Image

    data = io.BytesIO()
    Image.new("RGBA", (width, height), color).save(data, "PNG")
    return data.getvalue()


def as_json(data: Any) -> bytes:
    return json.dumps(data).encode()


def pack_files() -> dict[str, bytes]:
    """The files of a resource pack."""
    base = "assets/minecraft"
    files = {f"{base}/blockstates/{name}.json": as_json(data) for name, data in DEFINITIONS.items()}
    files |= {f"{base}/models/block/{name}.json": as_json(data) for name, data in MODELS.items()}
    return files | {f"{base}/textures/block/{name}.png": png(color) for name, color in COLORS.items()}


def wet_files() -> dict[str, bytes]:
    """What a pack needs for water: textures in two sizes, white and seven tenths opaque."""
    texture, base = "assets/minecraft/textures/block", "assets/minecraft/blockstates"
    return {
        f"{texture}/water_still.png": png((255, 255, 255, 180), 16, 512),
        f"{texture}/water_flow.png": png((255, 255, 255, 180), 32, 1024),
        f"{base}/water.json": as_json({"variants": {"": {"model": "block/water"}}}),
    }


def write_files(folder: Path, files: Mapping[str, bytes]) -> Path:
    for name, data in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(data)
    return folder


def write_zip(path: Path, files: Mapping[str, bytes]) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in files.items():
            archive.writestr(name, data)
    return path


def write_npm(folder: Path, version: str = "1.21.4") -> Path:
    """The layout of `minecraft-assets`."""
    files = {"blocks_states.json": as_json(DEFINITIONS), "blocks_models.json": as_json(MODELS)}
    files |= {f"blocks/{name}.png": png(color) for name, color in COLORS.items()}
    write_files(folder / "minecraft-assets/data" / version, files)
    return folder


def scene_of(body: str) -> Scene:
    text = f"""(define (block name x y z sx sy sz)
      (transform (call "set-cuboid" :block-type name :scale (list sx sy sz)) (translate (list x y z))))
    (bind "build" (lambda () {body}))"""
    result = Session(Options()).evaluate(Source("<test>", text))
    assert result.scene is not None, [each.message for each in result.diagnostics]
    return result.scene
