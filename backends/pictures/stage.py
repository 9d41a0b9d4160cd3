"""Shots and stages: the frames of an image or video with their cameras, prepared for rendering."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from scenelang.backends.base import frame_of
from scenelang.backends.pictures.camera import BoxExtent, Camera, Extent, Viewpoint, checked, framed
from scenelang.backends.pictures.declared import Lighting, ProgramCamera, View, resolved, share_of
from scenelang.backends.surfaces.appearance import Color, check_seen, look_of
from scenelang.backends.surfaces.environments import Environment, Studio, studio_for
from scenelang.backends.surfaces.lights import Light
from scenelang.backends.surfaces.solids import Solids, normalized, parted, solids_of
from scenelang.backends.surfaces.stand_ins import drawn_scene
from scenelang.grammar.diagnostics import Diagnostic, LimitError, SceneError
from scenelang.interpreter.scene.bounds import entity_box
from scenelang.interpreter.scene.entity import Entity, Scene, primitive_count
from scenelang.interpreter.scene.flatten import flatten_entity
from scenelang.interpreter.scene.supports import Supports

FloatArray = npt.NDArray[np.float64]

FILM_FRAMES = 48  # of a turntable by default
MOST_FRAMES = 10_000  # of a video
_MAX_COORDINATE = 1e152  # coordinates beyond this overflow when squared
MOST_ORBIT = 360_000.0  # degrees, a thousand turns
# Grounds of images with alpha, with what lights the scene from below; "shadow" shows only the shadow on it.
CLEAR_GROUNDS = {"transparent": "none", "shadow": "seamless"}
_MOST_FRAMED = 1_000  # images of an orbit whose union is framed; of more, every second or so


@dataclass(frozen=True, slots=True)
class Shot:
    """Frame number ``frame`` of the scene, seen by ``camera``.

    Attributes
    ----------
    share
        How far the video is, from 0 to 1.
    instant
        Number of the instant, and of all instants of which an image is the mean: these share the points of a lens.
    """

    frame: int
    camera: Camera
    share: float = 0.0
    instant: tuple[int, int] = (0, 1)


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
    """Return the shot of one image, which frames that frame; raises SceneError."""
    return stills(scene, view, [frame_of(scene, frame)], width, height)[0]


def stills(
    scene: Scene,
    view: View,
    frames: Sequence[int],
    width: int,
    height: int,
    seen: Sequence[int] | None = None,
) -> list[Shot]:
    """Return the shots of frames by one camera, which frames all that is ``seen``; one that follows aims at each frame.

    ``seen`` are frames too, by default the same ones. Raises SceneError.
    """
    chosen = resolved(scene, view)
    if isinstance(chosen, ProgramCamera):
        shares = [share_of(scene, frame) for frame in frames]
        return _declared(scene, chosen, list(zip(frames, shares, strict=True)), (width, height), seen or frames)
    low, high = box_of(scene)
    if isinstance(chosen, Camera):
        return [Shot(frame, _resized(chosen, width, height), share_of(scene, frame)) for frame in frames]
    placed = checked(chosen)
    camera = framed(
        placed, _extent(scene, [(scene.frames[k], np.eye(3, 4)) for k in dict.fromkeys(seen or frames)]), width, height
    )
    if not placed.follow or placed.target is not None:
        return [Shot(frame, camera, share_of(scene, frame)) for frame in frames]
    distance = placed.distance or float(np.dot((low + high) / 2.0 - camera.eye, camera.forward))
    shots = []
    for frame in frames:
        box = entity_box(scene.frames[frame])
        middle = (np.array(box[:3]) + np.array(box[3:])) / 2.0 if box is not None else (low + high) / 2.0
        aimed = replace(placed, target=tuple(middle.tolist()), distance=None if placed.eye is not None else distance)
        shots.append(Shot(frame, framed(aimed, BoxExtent(low, high), width, height), share_of(scene, frame)))
    return shots


def _declared(
    scene: Scene,
    camera: ProgramCamera,
    shares: Sequence[tuple[int, float]],
    size: tuple[int, int],
    seen: Sequence[int],
) -> list[Shot]:
    """Return the shots of a camera of the program, for frames and how far each is on the way through the video."""

    def place(viewpoint: Viewpoint) -> Camera:
        """Place a viewpoint in front of all that is seen."""
        (shot,) = stills(scene, viewpoint, [seen[0]], *size, seen=seen)
        return shot.camera

    return [Shot(frame, camera.at(scene, frame, share, size, place), share) for frame, share in shares]


def _extent(scene: Scene, placed: Sequence[tuple[Entity, FloatArray]]) -> Extent:
    """Return what is seen of entities under their poses (3, 4), of Minecraft blocks their cells; if that is nothing, as
    in an empty frame, the box of the scene."""
    supports = Supports(placed, lambda primitive: look_of(primitive).opacity > 0.0)
    return supports if not supports.is_empty else BoxExtent(*box_of(scene))


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
    shares = [i / max(1, count - 1) for i in range(count)]
    if not angle:
        if isinstance(view, ProgramCamera):
            return _declared(scene, view, list(zip(numbers, shares, strict=True)), (width, height), numbers)
        shots = stills(scene, view, numbers, width, height)
        return [replace(shot, share=share) for shot, share in zip(shots, shares, strict=True)]
    low, high = box_of(scene)
    target = None if isinstance(view, Camera) else view.target if isinstance(view, Viewpoint) else view.target(scene)
    pivot = (low + high) / 2.0 if target is None else np.array(target, np.float64)
    angles = [angle * i / count for i in range(count)]
    if isinstance(view, ProgramCamera):
        (first,) = _declared(scene, view, [(numbers[0], 0.0)], (width, height), numbers)
        view = first.camera
    start = _orbit_start(scene, view, pivot, list(zip(numbers, angles)), (width, height))
    return [Shot(n, turned(start, pivot, a), share) for n, a, share in zip(numbers, angles, shares, strict=True)]


def _resized(camera: Camera, width: int, height: int) -> Camera:
    """Return the camera at the size of the image."""
    return camera if (camera.width, camera.height) == (width, height) else camera.resized(width, height)


def _orbit_start(
    scene: Scene,
    view: Viewpoint | Camera,
    pivot: FloatArray,
    seen: Sequence[tuple[int, float]],
    size: tuple[int, int],
) -> Camera:
    """Return the first camera of an orbit, which frames the union of all that its images show.

    A camera that turns around a scene sees what a camera at rest sees of the scene that turns the other way. ``seen``
    are the images: a frame and the angle of the camera, in degrees; ``size`` is theirs in pixels.
    """
    if isinstance(view, Camera):
        return _resized(view, *size)
    view = checked(view)
    if view.distance is not None and view.target is None:
        view = replace(view, target=tuple(pivot.tolist()))
    distinct = list({(id(scene.frames[n]), round(angle % 360.0, 6)): (n, angle) for n, angle in seen}.values())
    placed = []
    for number, angle in distinct[:: math.ceil(len(distinct) / _MOST_FRAMED)]:
        rotation = _around_vertical(-angle)
        placed.append((scene.frames[number], np.column_stack([rotation, pivot - rotation @ pivot])))
    return framed(view, _extent(scene, placed), *size)


def turned(camera: Camera, pivot: FloatArray, angle: float) -> Camera:
    """Rotate ``camera`` by ``angle`` degrees around the vertical axis through ``pivot`` (3,), from +z towards +x."""
    rotation = _around_vertical(angle)
    pose = np.eye(4)
    pose[:3, :3] = camera.world_to_camera[:3, :3] @ rotation.T
    pose[:3, 3] = -pose[:3, :3] @ (pivot + rotation @ (camera.eye - pivot))
    return replace(camera, world_to_camera=pose)


def _around_vertical(angle: float) -> FloatArray:
    """Return the rotation (3, 3) by degrees around the vertical axis, from +z towards +x."""
    a = math.radians(angle)
    return np.array([[math.cos(a), 0.0, math.sin(a)], [0.0, 1.0, 0.0], [-math.sin(a), 0.0, math.cos(a)]])


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
    is_clear
        Whether the image has alpha: neither ground nor backdrop, only the shadow on the ground.
    center : (3,)
        With ``scale``, defines the frame: ``p_stage = scale (p_world - center)``.
    lights
        Lights of the program, in that frame.
    instant
        As of ``Shot``.
    """

    solids: Solids
    fixed: int
    camera: Camera
    studio: Studio
    ground: float | None
    center: FloatArray
    scale: float
    is_clear: bool = False
    lights: tuple[Light, ...] = ()
    instant: tuple[int, int] = (0, 1)

    @property
    def fades(self) -> bool:
        """Whether the light on the ground falls off away from the scene."""
        return self.studio.fades and self.ground is not None and not self.is_clear

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
        Names in ``ENVIRONMENTS``, and in ``GROUNDS`` or ``CLEAR_GROUNDS``.
    lighting
        What the program declares of its light, None if it declares nothing.
    backdrop
        Radiance (3) behind the scene; None for that of the environment.
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
    backdrop: Color | None = None

    def stage(self, shot: Shot) -> Stage:
        """Return the stage of one shot; all shots of one camera differ only in the moving solids."""
        camera = shot.camera.rescaled(self.center, self.scale)
        is_clear = self.ground in CLEAR_GROUNDS
        studio = self.studio(camera)
        lighting = self.lighting or Lighting()
        lights = tuple(light.scaled(self.center, self.scale) for light in lighting.lights_at(shot.share))
        solids = self.moving[shot.frame]
        if self.fixed is not None:
            solids = self.fixed.followed_by(solids)
        ground = (self.lowest - self.center[1]) * self.scale - BELOW
        shows_ground = studio.ground is not None and camera.eye[1] > ground + 1e-3
        fixed = len(self.fixed) if self.fixed is not None else 0
        height = ground if shows_ground else None
        return Stage(solids, fixed, camera, studio, height, self.center, self.scale, is_clear, lights, shot.instant)

    def studio(self, camera: Camera) -> Studio:
        """Return the lighting of an image by ``camera``."""
        under = CLEAR_GROUNDS.get(self.ground or "", self.ground)
        return (self.lighting or Lighting()).studio(studio_for(camera.right, self.environment, under, self.backdrop))


def has_free_tone(environment: Environment, ground: str | None, lighting: Lighting | None) -> bool:
    """Return whether images of a scene choose the tone behind it: no ground, sky or light of the program sets it."""
    has_lights = lighting is not None and bool(lighting.lights)
    is_seamless = environment.ground == "seamless" and environment.backdrop is not None
    return ground is None and not has_lights and is_seamless


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
