"""How the page first shows a scene: the camera that the program declares, and the tone behind the scene."""

from __future__ import annotations

import math
from typing import Any

from scenelang.backends.pictures.camera import Camera, Viewpoint
from scenelang.backends.pictures.declared import ProgramView, settled
from scenelang.backends.pictures.film import PictureOptions
from scenelang.backends.pictures.stage import staging_of, still, unit_size
from scenelang.backends.surfaces.appearance import Color
from scenelang.backends.surfaces.environments import ENVIRONMENTS
from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.scene.entity import Scene, primitive_count
from scenelang.interpreter.scene.setup import CAMERA, named

_SIZE = (640, 480)  # pixels of the image that the first camera frames
_MOST_TONED = 10_000  # primitives up to which the tone is chosen, which takes 60 ms, with these 200 ms


def camera_of(scene: Scene) -> dict[str, Any] | None:
    """Return the first camera of a program as data of the page; None without one that can be placed.

    Angles are in degrees; ``distance`` and ``target`` are in the frame of the stage. ``isFramed`` says that the page
    places the camera as near as its window allows.
    """
    if not named(scene.setup, CAMERA):
        return None
    try:
        view = ProgramView().of(scene)
        camera = still(scene, view, 0, *_SIZE).camera.rescaled(*unit_size(scene))
    except SceneError:  # its images say what is wrong with it
        return None
    is_framed = isinstance(view, Viewpoint) and view.distance is None and view.target is None and view.eye is None
    fov = view.fov if isinstance(view, Viewpoint) and view.lens is None else None
    return {**_angles(camera, fov), "isFramed": is_framed}


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
    return {
        "azimuth": math.degrees(math.atan2(-camera.right[2], camera.right[0])),
        "elevation": math.degrees(math.asin(min(1.0, max(-1.0, -float(camera.forward[1]))))),
        "fov": fov,
        "distance": distance,
        "target": (camera.eye + ahead * camera.forward).tolist(),
        "orthographic": camera.is_parallel,
    }


def backdrop_of(scene: Scene) -> Color:
    """Return the radiance behind a scene that drafts choose for the first image of the program.

    It is the studio's for a scene so large that the page would wait, and in the playground, which has no drafts.
    """
    environment = ENVIRONMENTS["studio"]
    usual = environment.backdrop or environment.ambient
    if primitive_count(scene.frames[0]) > _MOST_TONED:
        return usual
    try:
        from scenelang.backends.pictures.draft import toned
    except ImportError:
        return usual
    try:
        options = settled(scene, PictureOptions())
        staging = staging_of(scene, [0], _MOST_TONED, options.environment, options.ground, lighting=options.lighting)
        return toned(staging, still(scene, options.camera, 0, *_SIZE)).backdrop or usual
    except SceneError:  # its images say what is wrong with it
        return usual
