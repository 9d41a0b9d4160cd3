"""Shots and stages: the frames of an image or video with their cameras, prepared for rendering."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from scenelang.backends.base import frame_of
from scenelang.backends.pictures.camera import Camera, Viewpoint, checked, place
from scenelang.backends.pictures.declared import Lighting, ProgramCamera, View, resolved, share_of
from scenelang.backends.surfaces.appearance import Studio, check_seen, studio_for
from scenelang.backends.surfaces.lights import Light
from scenelang.backends.surfaces.solids import Solids, normalized, parted, solids_of
from scenelang.backends.surfaces.stand_ins import drawn_scene
from scenelang.grammar.diagnostics import Diagnostic, LimitError, SceneError
from scenelang.interpreter.scene.bounds import entity_box
from scenelang.interpreter.scene.entity import Entity, Scene, primitive_count
from scenelang.interpreter.scene.flatten import flatten_entity

FloatArray = npt.NDArray[np.float64]

FILM_FRAMES = 48  # of a turntable by default
MOST_FRAMES = 10_000  # of a video
_MAX_COORDINATE = 1e152  # coordinates beyond this overflow when squared
MOST_ORBIT = 360_000.0  # degrees, a thousand turns
_CHECKED_ANGLES = 24  # positions on a full circle from which a turntable must show the whole scene


@dataclass(frozen=True, slots=True)
class Shot:
    """Frame number ``frame`` of the scene, seen by ``camera``."""

    frame: int
    camera: Camera


def box_of(scene: Scene) -> tuple[FloatArray, FloatArray]:
    """Return the exact bounding box of all frames, low and high (3,) each.

    Raises SceneError("empty-scene") if the scene has no geometry or is invisible.
    """
    boxes = [box for root in scene.frames if (box := entity_box(root)) is not None]
    if not boxes:
        raise SceneError("empty-scene", f'the scene "{scene.word}" has no primitives, so there is nothing to draw')
    every = np.array(boxes)
    low, high = every[:, :3].min(axis=0), every[:, 3:].max(axis=0)
    with np.errstate(over="ignore"):
        sizes = high - low
    if not np.isfinite(sizes).all() or max(np.abs(low).max(), np.abs(high).max()) > _MAX_COORDINATE:
        raise SceneError("unsupported", "the scene cannot be drawn: its coordinates exceed the float range")
    check_seen(scene)
    return low, high


def still(scene: Scene, view: View, frame: int | None, width: int, height: int) -> Shot:
    """Return the shot of one picture; raises SceneError."""
    number = frame_of(scene, frame)
    return Shot(number, _camera(scene, resolved(scene, view), number, width, height))


def film(scene: Scene, view: View, width: int, height: int, frames: int | None, orbit: float | None) -> list[Shot]:
    """Return the shots of a film; raises SceneError.

    Parameters
    ----------
    frames : int, optional
        Number of pictures; the frames of a 4D scene are resampled evenly. By default each frame once.
    orbit : float, optional
        Degrees that the camera travels around the scene. By default the viewpoint's, else 360 for a static scene and 0
        for
        a 4D scene.
    """
    count = frames if frames is not None else len(scene.frames) if scene.animated else FILM_FRAMES
    if not 1 <= count <= MOST_FRAMES:
        hint = "leave out --frames for all frames of the scene" if frames is not None else "use --frames"
        raise SceneError("value", f"a film must have 1 to {MOST_FRAMES:,} frames (--frames), got {count}", hint)
    view = resolved(scene, view)
    orbit_of_view = None if isinstance(view, Camera) else view.orbit
    angle = orbit if orbit is not None else orbit_of_view
    if angle is None:
        is_moving = scene.animated or (isinstance(view, ProgramCamera) and view.varies)
        angle = 0.0 if is_moving else 360.0
    if not -MOST_ORBIT <= angle <= MOST_ORBIT:
        raise SceneError("value", f"the camera's orbit must be at most {MOST_ORBIT:,.0f} degrees, not {angle:,g}")
    numbers = [i * len(scene.frames) // count for i in range(count)]
    if not angle:
        last = max(1, count - 1)
        return [Shot(number, _camera(scene, view, number, width, height, i / last)) for i, number in enumerate(numbers)]
    low, high = box_of(scene)
    target = None if isinstance(view, Camera) else view.target if isinstance(view, Viewpoint) else view.target(scene)
    if isinstance(view, ProgramCamera):
        view = _camera(scene, view, numbers[0], width, height, 0.0)
    start = _orbit_start(view, low, high, angle, width, height)
    pivot = np.array(target) if target is not None else (low + high) / 2.0
    return [Shot(number, turned(start, pivot, angle * i / count)) for i, number in enumerate(numbers)]


def _camera(
    scene: Scene,
    view: Viewpoint | Camera | ProgramCamera,
    frame: int,
    width: int,
    height: int,
    share: float | None = None,
) -> Camera:
    """Return the camera of a frame: placed, or resized; one that follows aims at the center of the frame.

    ``share`` is how far the image is on the way from the first of a video to the last, by default that of the frame.
    """
    if isinstance(view, ProgramCamera):
        share = share_of(scene, frame) if share is None else share
        size = width, height
        return view.at(scene, frame, share, size, lambda viewpoint: _camera(scene, viewpoint, frame, *size))
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


def _orbit_start(
    view: Viewpoint | Camera, low: FloatArray, high: FloatArray, angle: float, width: int, height: int
) -> Camera:
    """Return the first camera of an orbit, far enough away to see the whole scene from every angle."""
    if isinstance(view, Camera):
        return view if (view.width, view.height) == (width, height) else view.resized(width, height)
    view = checked(view)
    center = view.target if view.target is not None else tuple(((low + high) / 2.0).tolist())
    if view.distance is not None:
        return place(replace(view, target=center), low, high, width, height)
    steps = max(1, math.ceil(abs(angle) / 360.0 * _CHECKED_ANGLES))
    around = [replace(view, target=center, azimuth=view.azimuth + angle * i / steps) for i in range(steps + 1)]
    cameras = [place(position, low, high, width, height) for position in around]
    if view.orthographic:
        widest = min(cameras, key=lambda camera: camera.focal[0])
        return replace(cameras[0], intrinsics=widest.intrinsics)
    middle = np.array(center)
    distance = max(float(np.linalg.norm(camera.eye - middle)) for camera in cameras)
    return place(replace(view, target=center, distance=distance), low, high, width, height)


def turned(camera: Camera, pivot: FloatArray, angle: float) -> Camera:
    """Rotate ``camera`` by ``angle`` degrees around the vertical axis through ``pivot`` (3,), from +z towards +x."""
    a = math.radians(angle)
    rotation = np.array([[math.cos(a), 0.0, math.sin(a)], [0.0, 1.0, 0.0], [-math.sin(a), 0.0, math.cos(a)]])
    pose = np.eye(4)
    pose[:3, :3] = camera.world_to_camera[:3, :3] @ rotation.T
    pose[:3, 3] = -pose[:3, :3] @ (pivot + rotation @ (camera.eye - pivot))
    return replace(camera, world_to_camera=pose)


# Stage: a scene prepared for rendering: flattened, scaled to unit size, with a placed camera and a ground.


BELOW = 1e-4  # distance of the ground below the lowest point, so that flat floors hide it


@dataclass(frozen=True, slots=True, eq=False)
class Stage:
    """Input of a renderer, in the frame where the scene's box is centered and has half diagonal 1.

    Attributes
    ----------
    solids
        The first ``fixed`` of them are the same in all stages of one video.
    ground
        Height of the ground; None without a ground, or if the camera is below it and would see nothing else.
    center : (3,)
        With ``scale``, defines the frame: ``p_stage = scale (p_world - center)``.
    lights
        Lights of the program, in that frame.
    """

    solids: Solids
    fixed: int
    camera: Camera
    studio: Studio
    ground: float | None
    center: FloatArray
    scale: float
    lights: tuple[Light, ...] = ()

    @property
    def width(self) -> int:
        """Width of the image in pixels."""
        return self.camera.width

    @property
    def height(self) -> int:
        """Height of the image in pixels."""
        return self.camera.height


@dataclass(frozen=True, slots=True, eq=False)
class Staging:
    """The frames of a scene that an image or video shows, prepared for any camera.

    Attributes
    ----------
    asked
        Entities by frame number.
    roots
        The same with blocks converted to cubes.
    fixed
        Solids that are equal in all frames; None for a single one.
    moving
        Other solids, by frame number.
    lowest
        Lowest height of the scene in the world.
    center, scale
        As of ``Stage``.
    environment, ground
        Names in ``ENVIRONMENTS`` and ``GROUNDS``.
    lighting
        What the program declares of its light, None if it declares nothing.
    """

    asked: dict[int, Entity]
    roots: dict[int, Entity]
    fixed: Solids | None
    moving: dict[int, Solids]
    lowest: float
    center: FloatArray
    scale: float
    environment: str
    ground: str | None
    lighting: Lighting | None = None

    def stage(self, shot: Shot) -> Stage:
        """Return the stage of one shot; all shots of one camera differ only in the moving solids."""
        camera = shot.camera.rescaled(self.center, self.scale)
        lighting = self.lighting or Lighting()
        studio = lighting.studio(studio_for(camera.right, self.environment, self.ground))
        lights = tuple(light.scaled(self.center, self.scale) for light in lighting.lights)
        solids = self.moving[shot.frame]
        if self.fixed is not None:
            solids = self.fixed.followed_by(solids)
        ground = (self.lowest - self.center[1]) * self.scale - BELOW
        shows_ground = studio.ground is not None and camera.eye[1] > ground + 1e-3
        fixed = len(self.fixed) if self.fixed is not None else 0
        return Stage(solids, fixed, camera, studio, ground if shows_ground else None, self.center, self.scale, lights)


def staging_of(
    scene: Scene,
    frames: Sequence[int],
    limit: int,
    environment: str = "studio",
    ground: str | None = None,
    warn: Callable[[Diagnostic], None] | None = None,
    lighting: Lighting | None = None,
) -> Staging:
    """Prepare frames of a scene for rendering.

    Unit size and ground height are computed from all frames of the scene, so that a video does not jump.

    Parameters
    ----------
    frames
        Frame numbers.
    limit
        Maximum number of primitives of a frame.
    environment, ground
        Names in ``ENVIRONMENTS`` and ``GROUNDS``.
    warn
        Receives diagnostics for content that cannot be drawn faithfully.
    lighting
        What the program declares of its light.

    Raises
    ------
    SceneError
        If the scene is empty or cannot be drawn.
    LimitError
        If a frame expands to more than ``limit`` primitives.
    """
    low, _ = box_of(scene)
    center, scale = unit_size(scene)
    shown = list(dict.fromkeys(frames))
    asked = {frame: scene.frames[frame] for frame in shown}
    drawn = drawn_scene(Scene(scene.word, list(asked.values()), scene.animated), limit, warn).frames
    solids = [_solids(root, limit, center, scale) for root in drawn]
    fixed, moving = parted(solids) if len(shown) > 1 else (None, solids)
    roots = dict(zip(shown, drawn, strict=True))
    moved = dict(zip(shown, moving, strict=True))
    return Staging(asked, roots, fixed, moved, float(low[1]), center, scale, environment, ground, lighting)


def unit_size(scene: Scene) -> tuple[FloatArray, float]:
    """Return the center (3,) and the scale that give the box of all frames half diagonal 1; raises SceneError."""
    low, high = box_of(scene)
    half = 0.5 * float(np.linalg.norm(high - low))
    return (low + high) / 2.0, 1.0 / half if half > 1e-300 else 1.0


def _solids(root: Entity, limit: int, center: FloatArray, scale: float) -> Solids:
    """Return the solids of a frame at unit size."""
    check_size(root, limit)
    return normalized(solids_of(flatten_entity(root)), center, scale)


def check_size(root: Entity, limit: int) -> None:
    """Raise LimitError if ``root`` expands to more than ``limit`` primitives."""
    count = primitive_count(root)
    if count > limit:
        raise LimitError(
            "primitives",
            f"the scene expands to {count:,} primitives, more than the limit of {limit:,} for one picture",
            hint="raise the limit, or draw a part of the scene",
        )
