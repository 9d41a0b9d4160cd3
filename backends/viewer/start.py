"""How the page first shows a scene: the cameras and the light that the program declares, and the tone behind it."""

from __future__ import annotations

import math
from dataclasses import asdict
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.pictures.camera import BoxExtent, Camera, Viewpoint, framed
from scenelang.backends.pictures.declared import Lighting, ProgramCamera, share_of
from scenelang.backends.pictures.film import PictureOptions
from scenelang.backends.pictures.stage import box_of, has_free_tone, staging_of, still, unit_size
from scenelang.backends.pictures.surroundings import settled
from scenelang.backends.surfaces import microfacets
from scenelang.backends.surfaces.appearance import Color
from scenelang.backends.surfaces.dome import Panorama, smaller
from scenelang.backends.surfaces.environments import (
    CHECKER,
    FADE_FROM,
    FADE_TO,
    FADED,
    SHOULDER,
    environment_of,
    studio_for,
)
from scenelang.backends.surfaces.lights import Light, level_axes
from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.scene.entity import Scene, primitive_count
from scenelang.interpreter.scene.setup import CAMERA, Declared, named

FloatArray = npt.NDArray[np.float64]

_SIZE = (640, 480)  # pixels of the image that the first camera frames
_MOST_TONED = 10_000  # primitives up to which the tone is chosen, which takes 60 ms, with these 200 ms
_MOST_CAMERAS = 24  # that the page lists
_MOST_POSES = 48  # of a camera over the frames, evenly spaced: 1 ms each
_PANORAMA_ROWS = 64  # 98 KB: skies are smooth
_UNUSED = Panorama(np.zeros((1, 2, 3)))  # the page makes the dome of a gradient itself
_CLIPPED = 1.0 - 1e-6  # shoulder of the tone curve that clips


# --- cameras


def cameras_of(scene: Scene) -> list[dict[str, Any]]:
    """Return the cameras of a program that can be placed, as data of the page, the first one first.

    Each has a ``name``, and ``poses``: one, or several that are evenly spread over the frames. Angles are in degrees;
    ``distance`` and ``target`` are in the frame of the stage. ``isFramed`` says that the page places the camera as near
    as its window allows.
    """
    found = []
    for item in named(scene.setup, CAMERA)[:_MOST_CAMERAS]:
        try:
            poses = _poses(scene, item)
        except SceneError:  # its images say what is wrong with it
            continue
        found.append({"name": item.name, "isFramed": _is_framed(item), "poses": poses})
    return found


def _poses(scene: Scene, item: Declared) -> list[dict[str, Any]]:
    """Return a camera at evenly spaced frames, once if it rests; raises SceneError."""
    camera = ProgramCamera(item)
    view = camera.viewpoint(scene)
    is_still = len(scene.frames) == 1 or view is not None or not (camera.varies or _follows(item))
    count = 1 if is_still else min(len(scene.frames), _MOST_POSES)
    frames = [round(k * (len(scene.frames) - 1) / max(1, count - 1)) for k in range(count)]
    fov = view.fov if view is not None and view.lens is None else None
    size, box = unit_size(scene), BoxExtent(*box_of(scene))

    def placed(frame: int) -> Camera:
        """Return the camera of a frame; one that the page frames is placed before the box, which takes no time."""
        if _is_framed(item):
            return camera.at(scene, frame, share_of(scene, frame), _SIZE, lambda view: framed(view, box, *_SIZE))
        return still(scene, view or camera, frame, *_SIZE).camera

    return [_angles(placed(frame).rescaled(*size), fov) for frame in frames]


def _is_framed(item: Declared) -> bool:
    """Return whether a camera is as near as the window allows."""
    return not {"eye", "distance", "look-at"} & set(item.values)


def _follows(item: Declared) -> bool:
    """Return whether a camera looks at what words name, which may move."""
    return isinstance(item.values.get("look-at"), str)


def _angles(camera: Camera, fov: float | None) -> dict[str, Any]:
    """Return a camera as angles, a target and the distance to it; ``fov`` is its field of view, if known."""
    half = camera.height / (2.0 * camera.focal[1])  # at distance 1, or everywhere
    if camera.is_parallel:
        fov = Viewpoint().fov if fov is None else fov
        distance = half / math.tan(math.radians(fov) / 2.0)
    else:
        fov = math.degrees(2.0 * math.atan(half))
        distance = max(float(-camera.eye @ camera.forward), 0.1)  # to what is nearest to the center of the scene
    ahead = distance if not camera.is_parallel else float(-camera.eye @ camera.forward)
    x, y, z = camera.forward.tolist()
    is_steep = math.hypot(x, z) < 1e-6  # its roll is part of its azimuth
    azimuth = math.atan2(-camera.right[2], camera.right[0]) if is_steep else math.atan2(-x, -z)
    level = np.array([math.cos(azimuth), 0.0, -math.sin(azimuth)])
    return {
        "azimuth": math.degrees(azimuth),
        "elevation": math.degrees(math.asin(min(1.0, max(-1.0, -y)))),
        "roll": math.degrees(math.atan2(float(camera.up @ level), float(camera.right @ level))),
        "fov": fov,
        "distance": distance,
        "target": (camera.eye + ahead * camera.forward).tolist(),
        "orthographic": camera.is_parallel,
    }


# --- light


def studio_of(
    scene: Scene, tone: Color, size: tuple[FloatArray, float] | None
) -> tuple[dict[str, Any], FloatArray | None]:
    """Return the light of a scene's images as data of the page, and the panorama (H, 2 H, 3) around it, if it has one.

    Angles are in radians, from +z towards +x, for a camera at azimuth 0: what is not ``isFixed`` turns with the camera.

    Parameters
    ----------
    tone
        Factor of the radiance behind the scene, where images choose it.
    size
        Center and scale of the stage; None for a scene without geometry, which has no lights.
    """
    try:
        options = settled(scene, PictureOptions())
        environment = environment_of(options.environment)
    except SceneError:  # its images say what is wrong with it
        options = PictureOptions()
        environment = environment_of(options.environment)
    lighting = options.lighting or Lighting()
    behind = environment.backdrop
    if behind is not None and has_free_tone(environment, options.ground, lighting):
        behind = (behind[0] * tone[0], behind[1] * tone[1], behind[2] * tone[2])
    view = np.array([1.0, 0.0, 0.0])
    studio = lighting.studio(studio_for(view, options.environment, options.ground, behind, _UNUSED))
    light, panorama = studio.environment, None
    if light.panorama is not None:
        panorama = smaller(light.panorama.image, _PANORAMA_ROWS) * studio.dome.strength
    x, y, z = studio.key_direction.tolist()
    far = FADED if studio.fades else 1.0
    return {
        "environment": options.environment,
        "backdrop": None if light.backdrop is None else [far * channel for channel in light.backdrop],
        "fade": [FADE_FROM, FADE_TO, far],
        "ambient": list(light.ambient),
        "key": list(light.key),
        "keyRadius": math.radians(light.radius),
        "keyTurn": math.atan2(x, z),
        "keyHeight": math.asin(y),
        "domeTurn": math.radians(studio.dome.turn),
        "isFixed": light.is_fixed or lighting.turn is not None,
        "isUnlit": light.unlit,
        "sky": asdict(light.sky),
        "ground": None if studio.ground is None else studio.ground.tolist(),
        "checker": CHECKER,
        "exposure": light.gain,
        "albedo": list(microfacets.ALBEDO),
        "grazing": list(microfacets.GRAZING),
        "shoulder": _CLIPPED if light.curve == "clip" else SHOULDER,
        "lights": [] if size is None or light.unlit else [_lamp(lamp.scaled(*size)) for lamp in lighting.lights],
    }, panorama


def _lamp(light: Light) -> dict[str, Any]:
    """Return a light in the frame of the stage as data of the page; ``radius`` of a sun and angles are in radians."""
    axes = level_axes(np.array(light.direction))
    return {
        "kind": light.kind,
        "position": list(light.position),
        "axes": [axis.tolist() for axis in axes],
        "flux": light.flux.tolist(),
        "radius": math.radians(light.radius) if light.kind == "sun" else light.radius,
        "angle": math.radians(light.angle),
        "blend": light.blend,
        "size": list(light.size),
    }


def tone_of(scene: Scene) -> Color:
    """Return the factor of the radiance behind a scene that drafts choose for the first image of the program.

    It is 1 for a scene so large that the page would wait, and in the playground, which has no drafts.
    """
    usual = (1.0, 1.0, 1.0)
    if primitive_count(scene.frames[0]) > _MOST_TONED:
        return usual
    try:
        from scenelang.backends.pictures.draft import toned
    except ImportError:
        return usual
    try:
        options = settled(scene, PictureOptions())
        environment = environment_of(options.environment)
        if not has_free_tone(environment, options.ground, options.lighting) or environment.backdrop is None:
            return usual
        staging = staging_of(scene, [0], _MOST_TONED, options.environment, options.ground, lighting=options.lighting)
        chosen = toned(staging, still(scene, options.camera, 0, *_SIZE)).backdrop
    except SceneError:  # its images say what is wrong with it
        return usual
    if chosen is None:
        return usual
    red, green, blue = (new / max(old, 1e-9) for new, old in zip(chosen, environment.backdrop, strict=True))
    return red, green, blue
