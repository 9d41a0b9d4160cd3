"""Everything of Mitsuba's scene but the shapes: camera, film, light and ground of a stage."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from scenelang.backends.camera import Camera
from scenelang.backends.mitsuba.materials import rgb
from scenelang.backends.stage import Stage
from scenelang.backends.studio import CHECKER, CHECKER_EDGE, GROUND_EDGE, Studio

_LAMP = 1e6  # the distance of the key light, so far that it lights all of the ground alike
_UNDER = 1e-4  # how far the plain ground lies under the checkerboard


def surroundings(mi: Any, stage: Stage, depth: int) -> dict[str, Any]:
    """The scene without its solids, in the form that Mitsuba loads."""
    environment = stage.studio.environment
    scene: dict[str, Any] = {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": depth},
        "sensor": sensor(mi, stage.camera),
        "around": {"type": "constant", "radiance": rgb(environment.ambient)},
    }
    if any(environment.key):
        scene["key"] = _key_light(mi, stage.studio)
    if stage.ground is not None and stage.studio.ground is not None:
        scene |= _ground(mi, stage.ground, stage.studio.ground)
    return scene


def sensor(mi: Any, camera: Camera) -> dict[str, Any]:
    """The camera, with a lens where it has an aperture."""
    matrix = np.eye(4)
    matrix[:3, 0], matrix[:3, 1], matrix[:3, 2], matrix[:3, 3] = -camera.right, camera.up, camera.forward, camera.eye
    (focal, _), (cx, cy) = camera.focal, camera.principal
    found: dict[str, Any] = {
        "type": "perspective",
        "near_clip": 1e-4,
        "far_clip": 1e5,
        "film": {
            "type": "hdrfilm",
            "width": camera.width,
            "height": camera.height,
            "pixel_format": "rgb",
            "component_format": "float32",
            "rfilter": {"type": "box"},  # the denoiser wants pixels whose noise is independent
        },
        "sampler": {"type": "multijitter"},
    }
    if camera.is_parallel:
        half = camera.width / (2.0 * focal)
        matrix[:3, 3] += (camera.width / 2.0 - cx) / focal * camera.right - (
            camera.height / 2.0 - cy
        ) / focal * camera.up
        to_world = mi.ScalarTransform4f(matrix).scale([half, half, 1.0])
        return found | {"type": "orthographic", "to_world": to_world}
    found |= {
        "to_world": mi.ScalarTransform4f(matrix),
        "fov": 2.0 * math.degrees(math.atan(camera.width / (2.0 * focal))),
        "fov_axis": "x",
        "principal_point_offset_x": cx / camera.width - 0.5,
        "principal_point_offset_y": cy / camera.height - 0.5,
    }
    if camera.aperture > 0.0:
        found |= {"type": "thinlens", "aperture_radius": camera.aperture, "focus_distance": camera.focus}
        del found["principal_point_offset_x"], found["principal_point_offset_y"]
    return found


def _key_light(mi: Any, studio: Studio) -> dict[str, Any]:
    """A round lamp so far away that its light is nearly parallel, seen under twice the environment's radius."""
    angle = math.radians(studio.environment.radius)
    # a white surface facing the lamp has the radiance KEY = irradiance / pi = radiance (radius / distance)^2
    radiance = np.array(studio.environment.key) / math.sin(angle) ** 2
    frame = mi.ScalarTransform4f().look_at(
        origin=[float(x) for x in studio.key_direction * _LAMP], target=[0.0, 0.0, 0.0], up=[0.0, 1.0, 0.0]
    )
    return {
        "type": "disk",
        "to_world": frame.scale(_LAMP * math.tan(angle)),
        "emitter": {"type": "area", "radiance": rgb(radiance)},
        "bsdf": {"type": "diffuse", "reflectance": rgb((0.0, 0.0, 0.0))},
    }


def _ground(mi: Any, height: float, colors: Any) -> dict[str, Any]:
    """A large disk, under a checkerboard where the ground has two colours."""
    is_plain = bool((colors[0] == colors[1]).all())

    def lying(at: float) -> Any:
        return mi.ScalarTransform4f().translate([0.0, at, 0.0]).rotate([1, 0, 0], -90.0)

    disk = lying(height if is_plain else height - _UNDER).scale(GROUND_EDGE)
    parts = {"ground": {"type": "disk", "to_world": disk, "bsdf": _diffuse(rgb(colors.mean(axis=0)))}}
    if not is_plain:
        periods = 2.0 * CHECKER_EDGE / (2.0 * CHECKER)
        texture = {
            "type": "checkerboard",
            "color0": rgb(colors[1]),
            "color1": rgb(colors[0]),
            "to_uv": mi.ScalarTransform3f().scale([periods, periods]),
        }
        square = lying(height).scale(CHECKER_EDGE)
        parts["squares"] = {"type": "rectangle", "to_world": square, "bsdf": _diffuse(texture)}
    return parts


def _diffuse(reflectance: dict[str, Any]) -> dict[str, Any]:
    return {"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": reflectance}}
