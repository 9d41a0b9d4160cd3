"""The shots of a picture or a film: which frame of the scene is seen by which camera."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from scenelang.backends.appearance import check_seen
from scenelang.backends.base import frame_of
from scenelang.backends.camera import Camera
from scenelang.backends.viewpoint import Viewpoint, checked, place
from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.bounds import entity_box
from scenelang.interpreter.entity import Scene

FloatArray = npt.NDArray[np.float64]

FILM_FRAMES = 48  # of a turntable that does not say how many it has
MOST_FRAMES = 10_000
_FARTHEST = 1e152  # squares of coordinates beyond it are no numbers any more
_ANGLES = 24  # places on a full circle from which a turntable must show the whole scene


@dataclass(frozen=True, slots=True)
class Shot:
    """Frame number ``frame`` of the scene, seen by ``camera``."""

    frame: int
    camera: Camera


def box_of(scene: Scene) -> tuple[FloatArray, FloatArray]:
    """The exact box of all frames, low and high (3,) each; raises SceneError("empty-scene") when there is none,
    or nothing of it can be seen."""
    boxes = [box for root in scene.frames if (box := entity_box(root)) is not None]
    if not boxes:
        raise SceneError("empty-scene", f'the scene "{scene.word}" has no primitives, so there is nothing to draw')
    every = np.array(boxes)
    low, high = every[:, :3].min(axis=0), every[:, 3:].max(axis=0)
    with np.errstate(over="ignore"):
        sizes = high - low
    if not np.isfinite(sizes).all() or max(np.abs(low).max(), np.abs(high).max()) > _FARTHEST:
        raise SceneError("unsupported", "the scene is larger than any number can tell, so it cannot be drawn")
    check_seen(scene)
    return low, high


def still(scene: Scene, view: Viewpoint | Camera, frame: int | None, width: int, height: int) -> Shot:
    """The shot of one picture; raises SceneError."""
    number = frame_of(scene, frame)
    return Shot(number, _camera(scene, view, number, width, height))


def film(
    scene: Scene, view: Viewpoint | Camera, width: int, height: int, frames: int | None, orbit: float | None
) -> list[Shot]:
    """The shots of a film of ``frames`` pictures: the frames of a 4D scene, evenly chosen where there are more or
    fewer of them (None: each once), while the camera goes ``orbit`` degrees round the scene (None: the viewpoint's
    own; once round a static scene, not at all round a 4D one). Raises SceneError."""
    count = frames if frames is not None else len(scene.frames) if scene.animated else FILM_FRAMES
    if not 1 <= count <= MOST_FRAMES:
        raise SceneError("value", f"a film has 1 to {MOST_FRAMES:,} frames, not {count}")
    own = view.orbit if isinstance(view, Viewpoint) else None
    angle = orbit if orbit is not None else own if own is not None else 0.0 if scene.animated else 360.0
    if not math.isfinite(angle):
        raise SceneError("value", "the camera's orbit must be a finite number of degrees")
    numbers = [i * len(scene.frames) // count for i in range(count)]
    if not angle:
        return [still(scene, view, number, width, height) for number in numbers]
    low, high = box_of(scene)
    start = _orbiting(view, low, high, angle, width, height)
    pivot = np.array(view.target) if isinstance(view, Viewpoint) and view.target is not None else (low + high) / 2.0
    return [Shot(number, turned(start, pivot, angle * i / count)) for i, number in enumerate(numbers)]


def _camera(scene: Scene, view: Viewpoint | Camera, frame: int, width: int, height: int) -> Camera:
    if isinstance(view, Camera):
        return view if (view.width, view.height) == (width, height) else view.resized(width, height)
    low, high = box_of(scene)
    view = checked(view)
    if view.follow and view.target is None:
        whole = place(view, low, high, width, height)
        box = entity_box(scene.frames[frame])
        middle = (np.array(box[:3]) + np.array(box[3:])) / 2.0 if box is not None else (low + high) / 2.0
        distance = float(np.dot((low + high) / 2.0 - whole.eye, whole.forward))
        view = replace(view, target=tuple(middle.tolist()), distance=view.distance or distance)
    return place(view, low, high, width, height)


def _orbiting(
    view: Viewpoint | Camera, low: FloatArray, high: FloatArray, angle: float, width: int, height: int
) -> Camera:
    """The first camera of an orbit, far enough to see the whole scene all the way round."""
    if isinstance(view, Camera):
        return view if (view.width, view.height) == (width, height) else view.resized(width, height)
    view = checked(view)
    center = view.target if view.target is not None else tuple(((low + high) / 2.0).tolist())
    if view.distance is not None:
        return place(replace(view, target=center), low, high, width, height)
    steps = max(1, math.ceil(abs(angle) / 360.0 * _ANGLES))
    around = [replace(view, target=center, azimuth=view.azimuth + angle * i / steps) for i in range(steps + 1)]
    cameras = [place(one, low, high, width, height) for one in around]
    if view.orthographic:
        widest = min(cameras, key=lambda camera: camera.focal[0])
        return replace(cameras[0], intrinsics=widest.intrinsics)
    middle = np.array(center)
    distance = max(float(np.linalg.norm(camera.eye - middle)) for camera in cameras)
    return place(replace(view, target=center, distance=distance), low, high, width, height)


def turned(camera: Camera, pivot: FloatArray, angle: float) -> Camera:
    """``camera`` after ``angle`` degrees round the vertical axis through ``pivot`` (3,), towards +x from +z."""
    a = math.radians(angle)
    turn = np.array([[math.cos(a), 0.0, math.sin(a)], [0.0, 1.0, 0.0], [-math.sin(a), 0.0, math.cos(a)]])
    pose = np.eye(4)
    pose[:3, :3] = camera.world_to_camera[:3, :3] @ turn.T
    pose[:3, 3] = -pose[:3, :3] @ (pivot + turn @ (camera.eye - pivot))
    return replace(camera, world_to_camera=pose)
