"""Cameras and lights of a program in glTF: nodes beside the scene's root, with ``KHR_lights_punctual``.

glTF has points, spots and directional lights, in candela and lux: watts are multiplied by 683 lm/W, as Blender's
exporter and importer do. A sphere becomes a point, a rectangle a spot of 90 degrees with its intensity along the axis.
Cameras with an ``:eye`` are written where they are in the first frame; those that are placed around the scene are left
to the reader, which frames scenes itself.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.surfaces.lights import Light, center_in, center_of, level_axes, lights_of
from scenelang.interpreter.scene.entity import Scene
from scenelang.interpreter.scene.setup import CAMERA, Declared, named

FloatArray = npt.NDArray[np.float64]
Node = dict[str, Any]

LIGHTS = "KHR_lights_punctual"
_LUMENS = 683.0  # of a watt
_NEAR_PLANE, _FAR_PLANE = (
    0.001,
    1000.0,
)  # clipping planes of an orthographic camera, relative to the distance that it looks
_FRAME_HEIGHT, _FOV = 24.0, 35.0  # mm of the frame that `:lens` is about, and degrees without either


def light_nodes(scene: Scene) -> list[tuple[Node, Node]]:
    """Return a node and a light for each light of a scene; raises SceneError for one that looks at nothing."""
    return [
        (_node(light.name or light.kind, light.position, light.direction), _punctual(light))
        for light in lights_of(scene)
    ]


def _punctual(light: Light) -> Node:
    """Return a light of ``KHR_lights_punctual``."""
    brightest = max(light.color) or 1.0
    watts = light.power * brightest
    color = [channel / brightest for channel in light.color]
    if light.kind == "sun":
        return {"type": "directional", "color": color, "intensity": watts * _LUMENS}
    cone: Node = {}
    steradians = 4.0 * math.pi
    if light.kind == "spot":
        outer = math.radians(light.angle / 2.0)
        cone = {"spot": {"innerConeAngle": outer * (1.0 - max(light.blend, 1e-3)), "outerConeAngle": outer}}
    elif light.kind == "area":
        cone, steradians = {"spot": {"innerConeAngle": 0.0, "outerConeAngle": math.pi / 2.0}}, math.pi
    kind = "spot" if cone else "point"
    return {"type": kind, "color": color, "intensity": watts / steradians * _LUMENS} | cone


def camera_nodes(scene: Scene) -> list[tuple[Node, Node]]:
    """Return a node and a camera for each camera of a scene that has an eye; raises SceneError for wrong words."""
    return [_camera(scene, item) for item in named(scene.setup, CAMERA) if "eye" in item.values]


def _camera(scene: Scene, item: Declared) -> tuple[Node, Node]:
    """Return the node and the camera of a declaration, as it is in the first frame."""
    eye, target = (_first(item, key) for key in ("eye", "look-at"))
    if isinstance(target, str):
        target = center_of(scene, target, item, 0)
    elif target is None:
        target = center_in(scene, None) or (0.0, 0.0, 0.0)
    forward = np.array(target) - np.array(eye)
    distance = float(np.linalg.norm(forward)) or 1.0
    lens = _first(item, "lens")
    fov = math.radians(_first(item, "fov") or _FOV) if lens is None else 2.0 * math.atan(_FRAME_HEIGHT / 2.0 / lens)
    node = _node(item.name or CAMERA, eye, forward / distance, math.radians(_first(item, "roll") or 0.0))
    if not item.values.get("orthographic"):
        return node, {"type": "perspective", "perspective": {"yfov": fov, "znear": _NEAR_PLANE * distance}}
    half = distance * math.tan(fov / 2.0)
    planes = {"znear": _NEAR_PLANE * distance, "zfar": _FAR_PLANE * distance}
    return node, {"type": "orthographic", "orthographic": {"xmag": half, "ymag": half} | planes}


def _first(item: Declared, key: str) -> Any:
    """Return a value of a camera in the first frame."""
    value = item.values.get(key)
    is_point = key in ("eye", "look-at") and isinstance(value, tuple) and isinstance(value[0], float)
    return value[0] if isinstance(value, tuple) and not is_point else value


def _node(name: str, position: Any, direction: Any, roll: float = 0.0) -> Node:
    """Return a node at a position with -z in a direction, turned clockwise about it by ``roll`` radians."""
    right, up, forward = level_axes(np.array(direction, np.float64))
    turned = math.cos(roll) * right - math.sin(roll) * up, math.cos(roll) * up + math.sin(roll) * right
    rotation = _quaternion(np.stack([turned[0], turned[1], -forward], axis=1))
    return {"name": name, "translation": [float(x) for x in position], "rotation": rotation}


def _quaternion(rotation: FloatArray) -> list[float]:
    """Return the unit quaternion (x, y, z, w) of a rotation (3, 3), from the eigenvector of Bar-Itzhack (2000)."""
    (a, b, c), (d, e, f), (g, h, i) = rotation
    symmetric = np.array([
        [a - e - i, b + d, c + g, h - f],
        [b + d, e - a - i, f + h, c - g],
        [c + g, f + h, i - a - e, d - b],
        [h - f, c - g, d - b, a + e + i],
    ])  # fmt: skip
    _, vectors = np.linalg.eigh(symmetric)
    x, y, z, w = vectors[:, -1].tolist()
    return [x, y, z, w]
