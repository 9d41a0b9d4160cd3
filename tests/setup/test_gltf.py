"""Cameras and lights of a program in glTF files: where they are, what they see, and their units."""

from __future__ import annotations

import json
import math
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import scenelang as sl

SCENE = """(bind "vase" (lambda () (call "cylinder" :radius .3)))
(bind "room" (lambda () (transform (call "vase") (translate [1 0 0]))))
(camera "main" :eye [3 2 5] :look-at "vase" :fov 40 :roll 20)
(camera "around" :azimuth 30)
(camera "plan" :eye (list [0 9 0] [0 5 0]) :look-at [0 0 0] :orthographic #t :lens 50)
(light "bulb" :position [0 2 0] :power 100 :color [2 1 0])
(light "cone" :position [0 3 0] :look-at "vase" :angle 60 :blend .5 :power 50)
(light "panel" :position [0 3 0] :size 2 :power 50)
(light "sun" :direction [1 -1 0] :strength 3)
(scene "room")
"""


def document(tmp_path: Path, text: str = SCENE) -> dict[str, Any]:
    target = tmp_path / "a.glb"
    sl.evaluate(text).export(target)
    data = target.read_bytes()
    (length,) = struct.unpack_from("<I", data, 12)
    found: dict[str, Any] = json.loads(data[20 : 20 + length])
    return found


def rotation(node: dict[str, Any]) -> np.ndarray:
    x, y, z, w = node["rotation"]
    assert math.hypot(x, y, z, w) == pytest.approx(1)
    return np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ])  # fmt: skip


def test_cameras_are_those_of_pictures(tmp_path: Path) -> None:
    found = document(tmp_path)
    nodes = {node["name"]: node for node in found["nodes"]}
    scene = sl.evaluate(SCENE)
    assert "around" not in nodes
    for name in ("main", "plan"):
        node, placed = nodes[name], scene.placed(name, size=(100, 100))
        turn = rotation(node)
        assert node["translation"] == pytest.approx(placed.eye)
        assert turn[:, 0] == pytest.approx(placed.right, abs=1e-6)
        assert turn[:, 1] == pytest.approx(placed.up, abs=1e-6)
        assert -turn[:, 2] == pytest.approx(placed.forward, abs=1e-6)
        camera = found["cameras"][node["camera"]]
        if name == "main":
            assert camera["perspective"]["yfov"] == pytest.approx(math.radians(40))
        else:
            assert camera["orthographic"]["ymag"] == pytest.approx(50 / placed.focal[1])


def test_lights_have_the_units_of_gltf(tmp_path: Path) -> None:
    found = document(tmp_path)
    nodes = {node["name"]: node for node in found["nodes"]}
    lights = found["extensions"]["KHR_lights_punctual"]["lights"]
    of = {
        name: lights[nodes[name]["extensions"]["KHR_lights_punctual"]["light"]]
        for name in ("bulb", "cone", "panel", "sun")
    }
    assert of["bulb"] == {
        "type": "point",
        "color": [1.0, 0.5, 0.0],
        "intensity": pytest.approx(200 / (4 * math.pi) * 683),
    }
    assert of["cone"]["intensity"] == pytest.approx(50 / (4 * math.pi) * 683)
    assert of["cone"]["spot"]["outerConeAngle"] == pytest.approx(math.radians(30))
    assert of["cone"]["spot"]["innerConeAngle"] == pytest.approx(math.radians(15))
    assert of["panel"]["intensity"] == pytest.approx(50 / math.pi * 683)
    assert of["sun"]["intensity"] == pytest.approx(3 * 683)
    assert -rotation(nodes["sun"])[:, 2] == pytest.approx([math.sqrt(0.5), -math.sqrt(0.5), 0])
    assert -rotation(nodes["cone"])[:, 2] == pytest.approx(np.array([1, -2.5, 0]) / math.hypot(1, 2.5))
    assert found["extensionsUsed"] == ["KHR_lights_punctual"]
    assert len(found["scenes"][0]["nodes"]) == 1 + 2 + 4


def test_a_scene_without_any_is_as_before(tmp_path: Path) -> None:
    found = document(tmp_path, '(bind "vase" (lambda () (call "cylinder")))')
    assert not {"cameras", "extensions", "extensionsUsed"} & set(found)
    assert found["scenes"] == [{"nodes": [0]}]
