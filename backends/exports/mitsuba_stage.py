"""Camera, light and ground of final pictures, brought from the stage's unit frame to world coordinates."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.exports.items import Plan
from scenelang.backends.exports.xml_elements import elements
from scenelang.backends.mitsuba.scene import surroundings
from scenelang.backends.mitsuba.variants import use
from scenelang.backends.shots import box_of, still
from scenelang.backends.solids import solids_of
from scenelang.backends.stage import Stage
from scenelang.backends.studio import studio_for
from scenelang.backends.viewpoint import Viewpoint
from scenelang.interpreter.entity import Entity, Scene
from scenelang.interpreter.flatten import flatten_entity
from scenelang.interpreter.values import ANONYMOUS

FloatArray = npt.NDArray[np.float64]

_WIDTH, _HEIGHT = 800, 600
_BOUNCES = 8
_SAMPLES = 64
_BELOW = 1e-4  # the ground lies this far under the lowest point, where the half diagonal is 1


def stage_elements(plan: Plan) -> list[str]:
    """The lines of integrator, sensor, lights and ground for a plan of one frame."""
    scene = Scene(plan.word, [plan.roots[0].entity], False)
    mi = use("scalar", 0, False)
    low, high = box_of(scene)
    half = 0.5 * float(np.linalg.norm(high - low))
    center, scale = (low + high) / 2.0, 1.0 / half if half > 1e-300 else 1.0
    shot = still(scene, Viewpoint(), None, _WIDTH, _HEIGHT)
    camera = shot.camera.rescaled(center, scale)
    studio = studio_for(camera, "studio", None)
    ground = (float(low[1]) - float(center[1])) * scale - _BELOW if studio.ground is not None else None
    nothing = solids_of(flatten_entity(Entity(plan.word, ANONYMOUS, ())))
    stage = Stage(nothing, 0, camera, studio, ground, center, scale)
    outward = np.diag([1.0 / scale] * 3 + [1.0])
    outward[:3, 3] = center
    lines: list[str] = []
    for key, value in surroundings(mi, stage, _BOUNCES).items():
        if key != "type":
            lines += elements(None, _in_world(value, outward, scale))
    return lines


def _in_world(value: Mapping[str, Any], outward: FloatArray, scale: float) -> dict[str, Any]:
    """A plugin with its poses and distances in world units."""
    out: dict[str, Any] = {}
    is_camera = "film" in value
    for key, item in value.items():
        if key == "to_world":
            pose = outward @ np.array(item.matrix, np.float64).reshape(4, 4)
            if is_camera and value["type"] != "orthographic":
                pose[:3, :3] *= scale  # a camera may not be scaled
            out[key] = pose
        elif hasattr(item, "matrix"):
            out[key] = np.array(item.matrix, np.float64)
        elif key in ("near_clip", "far_clip", "aperture_radius", "focus_distance"):
            out[key] = item / scale
        elif key == "sampler":
            out[key] = dict(item) | {"sample_count": _SAMPLES}
        else:
            out[key] = item
    return out
