"""Camera, light and ground of final pictures, brought from the stage's unit frame to world coordinates."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.base import Options
from scenelang.backends.exports.items import Plan
from scenelang.backends.exports.xml_elements import elements
from scenelang.backends.mitsuba.backend import MITSUBA
from scenelang.backends.mitsuba.scene import surroundings
from scenelang.backends.mitsuba.variants import use
from scenelang.backends.shots import box_of, still
from scenelang.backends.solids import solids_of
from scenelang.backends.stage import Staging, unit_size
from scenelang.backends.viewpoint import Viewpoint
from scenelang.interpreter.entity import Entity, Scene
from scenelang.interpreter.flatten import flatten_entity
from scenelang.interpreter.values import ANONYMOUS

FloatArray = npt.NDArray[np.float64]

_WIDTH, _HEIGHT = 800, 600


def stage_elements(plan: Plan) -> list[str]:
    """The lines of integrator, sensor, lights and ground for a plan of one frame."""
    scene = Scene(plan.word, [plan.roots[0].entity], False)
    mi = use("scalar", 0, False)
    center, scale = unit_size(scene)
    nothing = solids_of(flatten_entity(Entity(plan.word, ANONYMOUS, ())))
    roots, lowest = {0: scene.root}, float(box_of(scene)[0][1])
    staging = Staging(roots, roots, None, {0: nothing}, lowest, center, scale, "studio", None)
    stage = staging.stage(still(scene, Viewpoint(), None, _WIDTH, _HEIGHT))
    outward = np.diag([1.0 / scale] * 3 + [1.0])
    outward[:3, 3] = center
    lines: list[str] = []
    for key, value in surroundings(mi, stage, MITSUBA.setting(Options(), "bounces")).items():
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
            out[key] = dict(item) | {"sample_count": MITSUBA.setting(Options(), "samples")}
        else:
            out[key] = item
    return out
