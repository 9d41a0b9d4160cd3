"""Cameras: pinhole or parallel projection, placed in the world, with a JSON form.

World frame: right-handed, +x right, +y up, +z towards the viewer. Camera frame: +x right, +y down, +z forward, as in
OpenCV. A world point p has the camera coordinates ``q = R p + t`` and the image position ``K q / q_z`` (``K (q_x,
q_y, 1)`` for a parallel projection) in pixels from the top left corner; pixel centers are at half-integers.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any, Literal, Protocol

import numpy as np
import numpy.typing as npt

from scenelang.backends.files import read_regular
from scenelang.grammar.diagnostics import SceneError, suggest

FloatArray = npt.NDArray[np.float64]
Projection = Literal["perspective", "orthographic"]

FORMAT, VERSION = "scenelang-camera", 1
AXES = "camera: x right, y down, z forward; world: x right, y up, z towards the viewer; pixel centers at halves"
LARGEST = 8192  # pixels of a side
_MAX_FILE_BYTES = 100_000


@dataclass(frozen=True, slots=True, eq=False)
class Camera:
    """A placed camera for images of ``width`` x ``height`` pixels.

    Attributes
    ----------
    intrinsics : (3, 3)
        K in pixels: the focal lengths (pixels per scene unit for "orthographic") and the principal point.
    world_to_camera : (4, 4)
        Rigid transform, in scene units.
    projection
        "perspective" or "orthographic".
    aperture
        Radius of the lens in scene units; 0 is a pinhole.
    focus
        Focus distance in scene units.
    """

    width: int
    height: int
    intrinsics: FloatArray
    world_to_camera: FloatArray
    projection: Projection = "perspective"
    aperture: float = 0.0
    focus: float = 1.0

    def __repr__(self) -> str:
        eye, forward = (" ".join(f"{x:.3g}" for x in v) for v in (self.eye, self.forward))
        return f"<PlacedCamera {self.width} x {self.height} at [{eye}], looking along [{forward}]>"

    @property
    def is_parallel(self) -> bool:
        """Whether the projection is parallel."""
        return self.projection == "orthographic"

    @property
    def right(self) -> FloatArray:
        """Unit vector (3,) to the right in the image, in the world."""
        return np.asarray(self.world_to_camera[0, :3], np.float64)

    @property
    def up(self) -> FloatArray:
        """Unit vector (3,) upwards in the image, in the world."""
        return -np.asarray(self.world_to_camera[1, :3], np.float64)

    @property
    def forward(self) -> FloatArray:
        """Unit vector (3,) of the view direction, in the world."""
        return np.asarray(self.world_to_camera[2, :3], np.float64)

    @property
    def axes(self) -> FloatArray:
        """Rotation (3, 3) from world directions to (right, up, forward); its rows are these axes."""
        return np.stack([self.right, self.up, self.forward])

    @property
    def eye(self) -> FloatArray:
        """Position (3,) of the camera in the world."""
        return np.asarray(-self.world_to_camera[:3, :3].T @ self.world_to_camera[:3, 3], np.float64)

    @property
    def focal(self) -> tuple[float, float]:
        """Focal lengths, horizontal and vertical: pixels per unit at depth 1 (at any depth for parallel projection)."""
        return float(self.intrinsics[0, 0]), float(self.intrinsics[1, 1])

    @property
    def principal(self) -> tuple[float, float]:
        """Principal point, in pixels."""
        return float(self.intrinsics[0, 2]), float(self.intrinsics[1, 2])

    def project(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Project points (N, 3) to pixels (N, 2) from the top left corner, and depths (N,) along the optical axis.

        The pixels of points at or behind the eye of a perspective camera are nan.
        """
        local = points @ self.world_to_camera[:3, :3].T + self.world_to_camera[:3, 3]
        depth = local[:, 2]
        safe = np.ones_like(depth) if self.is_parallel else np.where(depth > 0.0, depth, np.nan)
        return local[:, :2] / safe[:, None] * np.array(self.focal) + np.array(self.principal), depth

    def rescaled(self, center: FloatArray, scale: float) -> Camera:
        """Return the camera that sees the same image after the world is transformed by ``p -> scale (p - center)``."""
        pose = self.world_to_camera.copy()
        pose[:3, 3] = -pose[:3, :3] @ ((self.eye - center) * scale)
        intrinsics = self.intrinsics.copy()
        if self.is_parallel:
            intrinsics[[0, 1], [0, 1]] /= scale
        aperture, focus = self.aperture * scale, self.focus * scale
        return replace(self, world_to_camera=pose, intrinsics=intrinsics, aperture=aperture, focus=focus)

    def from_lens(self, right: float, up: float) -> Camera:
        """Return the pinhole at a point of the lens, in scene units from its middle, which sees the same in focus."""
        pose = self.world_to_camera.copy()
        pose[:3, 3] = -pose[:3, :3] @ (self.eye + right * self.right + up * self.up)
        intrinsics = self.intrinsics.copy()
        fx, fy = self.focal
        intrinsics[:2, 2] += [fx * right / self.focus, -fy * up / self.focus]
        return replace(self, world_to_camera=pose, intrinsics=intrinsics, aperture=0.0)

    @property
    def identity(self) -> Hashable:
        """A value that is equal for cameras that see the same."""
        return (
            self.world_to_camera.tobytes(), self.intrinsics.tobytes(), self.projection, self.width, self.height,
            self.aperture, self.focus,
        )  # fmt: skip

    def resized(self, width: int, height: int) -> Camera:
        """Return the same view at another picture size; the vertical field of view is preserved."""
        ratio = height / self.height
        intrinsics = self.intrinsics.copy()
        intrinsics[:2] *= ratio
        intrinsics[0, 2] += (width - self.width * ratio) / 2.0
        return replace(self, width=width, height=height, intrinsics=intrinsics)


def camera_at(
    eye: FloatArray, axes: tuple[FloatArray, FloatArray, FloatArray], focal: float, width: int, height: int, **more: Any
) -> Camera:
    """Return a camera at ``eye`` (3,) with orthonormal (right, up, forward) ``axes`` and a centered principal point.

    ``focal`` is the focal length in pixels; ``more`` is passed to ``Camera``.
    """
    right, up, forward = axes
    pose = np.eye(4)
    pose[:3, :3] = np.stack([right, -up, forward])
    pose[:3, 3] = -pose[:3, :3] @ eye
    intrinsics = np.array([[focal, 0.0, width / 2.0], [0.0, focal, height / 2.0], [0.0, 0.0, 1.0]])
    return Camera(width, height, intrinsics, pose, **more)


def camera_to_json(camera: Camera) -> dict[str, Any]:
    """Return the JSON form of a camera, the input of ``camera_from_json``."""
    return {
        "format": FORMAT,
        "version": VERSION,
        "width": camera.width,
        "height": camera.height,
        "projection": camera.projection,
        "K": camera.intrinsics.tolist(),
        "world_to_camera": camera.world_to_camera.tolist(),
        "axes": AXES,
        "aperture": camera.aperture,
        "focus": camera.focus,
    }


def read_camera(path: Path | str) -> Camera:
    """Read a camera from a JSON file; raises SceneError."""
    target = Path(path)
    try:
        if target.stat().st_size > _MAX_FILE_BYTES:
            raise SceneError("file", f"`{target}` is too large for a camera file")
        data = json.loads(read_regular(target))
    except OSError as error:
        raise SceneError("file", f"cannot read {target}: {error.strerror or error}") from error
    except (ValueError, RecursionError):
        raise SceneError("value", f"`{target}` is not a camera file: invalid JSON") from None
    return camera_from_json(data)


def camera_from_json(data: Any) -> Camera:
    """Return the camera described by JSON data in the form of ``camera_to_json``; raises SceneError("value")."""
    if not isinstance(data, dict) or data.get("format", FORMAT) != FORMAT:
        raise SceneError("value", f'a JSON camera must be an object with "format": "{FORMAT}"')
    projection = data.get("projection", "perspective")
    if projection not in ("perspective", "orthographic"):
        raise SceneError("value", f"a camera's projection must be perspective or orthographic, not {projection!r}")
    size = [data.get(name) for name in ("width", "height")]
    if not all(type(side) is int and 1 <= side <= LARGEST for side in size):
        raise SceneError("value", f"a camera's width and height must be integers from 1 to {LARGEST}")
    intrinsics, pose = _matrix(data, "K", 3), _matrix(data, "world_to_camera", 4)
    rotation = pose[:3, :3]
    with np.errstate(all="ignore"):
        is_rigid = np.abs(rotation @ rotation.T - np.eye(3)).max() <= 1e-4
    if not is_rigid or np.linalg.det(rotation) < 0 or (pose[3] != [0, 0, 0, 1]).any():
        raise SceneError("value", "a camera's world_to_camera must be rigid: a rotation and a translation")
    fx, fy = float(intrinsics[0, 0]), float(intrinsics[1, 1])
    if min(fx, fy) <= 0.0 or abs(fx - fy) > 1e-6 * fx or intrinsics[0, 1] or (intrinsics[2] != [0, 0, 1]).any():
        raise SceneError("value", "a camera's K must have square pixels: [[f, 0, cx], [0, f, cy], [0, 0, 1]]")
    aperture, focus = _length(data, "aperture", 0.0), _length(data, "focus", 1.0)
    return Camera(size[0], size[1], intrinsics, pose, projection, aperture, focus)  # type: ignore[arg-type]


def _matrix(data: dict[str, Any], name: str, size: int) -> FloatArray:
    """Return a square matrix of a JSON camera; raises SceneError."""
    try:
        matrix = np.array(data.get(name), np.float64)
    except (TypeError, ValueError):
        matrix = np.zeros(0)
    if matrix.shape != (size, size) or not np.isfinite(matrix).all():
        raise SceneError("value", f"a camera's {name} must be a {size} x {size} matrix of finite numbers")
    return matrix


def _length(data: dict[str, Any], name: str, default: float) -> float:
    """Return a nonnegative number of a JSON camera; raises SceneError."""
    value = data.get(name, default)
    if type(value) not in (int, float) or not math.isfinite(value) or value < 0.0:
        raise SceneError("value", f"a camera's {name} must be a number, 0 or more")
    return float(value)


# Viewpoints: a camera as the user describes it, and its placement such that the scene is in view. At azimuth 0 the
# camera looks from +z towards -z; a positive azimuth moves it towards +x, a positive elevation upwards. Angles are in
# degrees, lengths in scene units.


Point = tuple[float, float, float]

FILL = 0.91  # share of the image's limiting side that the objects take
MARGIN = 0.06  # around a box on each side, relative to half the image: its corners are seldom reached
_FILM_WIDTH = 36.0  # mm, of a full-frame camera
_PRECISION = 1e-9  # relative, of the centering
_MOST_STEPS = 60  # of the centering; about six are needed


@dataclass(frozen=True, slots=True)
class Viewpoint:
    """A camera as described by the user, before it is placed.

    Attributes
    ----------
    azimuth, elevation
        Direction from the target, in degrees.
    distance
        From the eye to the target, in scene units; None if the whole scene must be in view.
    fov
        Vertical field of view in degrees.
    target
        Point at the center of the image; None for the scene's.
    eye
        Position of the camera, instead of ``azimuth``, ``elevation`` and ``distance``; it looks at ``target``, by
        default the center of the scene's box.
    roll
        Turn of the camera around its view direction, clockwise, in degrees.
    lens
        Focal length in millimeters for an image 36 mm wide, instead of ``fov``.
    orthographic
        Use parallel projection.
    follow
        Aim at the center of each frame.
    orbit
        Angle in degrees that the camera of a video travels around the scene; None for one full turn around a static
        one.
    aperture
        Radius of the lens in scene units; 0 is a pinhole.
    focus
        Focus distance in scene units; None for the target's.
    """

    azimuth: float = 30.0
    elevation: float = 25.0
    distance: float | None = None
    fov: float = 35.0
    target: Point | None = None
    orthographic: bool = False
    follow: bool = False
    orbit: float | None = None
    aperture: float = 0.0
    focus: float | None = None
    eye: Point | None = None
    roll: float = 0.0
    lens: float | None = None


PRESETS = {
    "three-quarter": Viewpoint(),
    "hero": Viewpoint(35.0, 6.0, fov=20.0),
    "catalogue": Viewpoint(30.0, 16.0, fov=12.0),
    "isometric": Viewpoint(45.0, math.degrees(math.atan(math.sqrt(0.5))), orthographic=True),
    "plan": Viewpoint(0.0, 90.0, orthographic=True),
    "elevation": Viewpoint(0.0, 0.0, orthographic=True),
    "front": Viewpoint(0.0, 0.0),
    "right": Viewpoint(90.0, 0.0),
    "back": Viewpoint(180.0, 0.0),
    "left": Viewpoint(-90.0, 0.0),
    "top": Viewpoint(0.0, 90.0),
    "bottom": Viewpoint(0.0, -90.0),
    "turntable": Viewpoint(30.0, 20.0, orbit=360.0),
    "follow": Viewpoint(30.0, 20.0, follow=True),
}
_FLAGS = ("orthographic", "follow")
_POINTS = ("target", "eye")
_FARTHEST = 1e12  # of coordinates and distances: beyond, single precision has no places left for the image
_ANGLED = ("azimuth", "elevation", "distance")  # what an eye stands instead of
_SETTINGS = "azimuth=40,elevation=20,distance=5,fov=35,target=0:1:0, eye=1:2:3"
USAGE = f"{', '.join(PRESETS)}, {_SETTINGS}, or the JSON file of a camera"


class Extent(Protocol):
    """Points that a camera frames, by their support function."""

    def highest(self, direction: FloatArray) -> float:
        """Return the maximum of ``direction`` . p over all points p."""


@dataclass(frozen=True, slots=True, eq=False)
class BoxExtent:
    """Extent of the box from ``low`` to ``high`` (3,)."""

    low: FloatArray
    high: FloatArray

    def highest(self, direction: FloatArray) -> float:
        """Return the maximum of ``direction`` . p over the corners p."""
        return float(np.maximum(direction * self.low, direction * self.high).sum())


def place(viewpoint: Viewpoint, low: FloatArray, high: FloatArray, width: int, height: int) -> Camera:
    """Place a camera in front of a box, with a margin of 6 % of half the image on every side; see ``framed``.

    Parameters
    ----------
    low, high : (3,)
        Corners of the box, in scene units.
    width, height
        Of the image, in pixels.
    """
    return framed(viewpoint, BoxExtent(low, high), width, height, 1.0 - MARGIN)


def framed(viewpoint: Viewpoint, extent: Extent, width: int, height: int, fill: float = FILL) -> Camera:
    """Place a camera such that the silhouette of ``extent`` is in view.

    Without a target and a distance the bounding rectangle of the silhouette is centered in the image, and the eye is as
    near as the silhouette allows: the rectangle's limiting side is ``fill`` of the image's. With a target the eye is as
    near as the silhouette allows. With a distance the box of the extent is centered, so that cameras of equal distance
    and elevation, as those of a dataset's orbit, are on a circle.

    A point at (x, y, z) along the camera's axes, seen from the distance d, is at (x - c) / (z + d). All points are from
    -k to k for some c if d is at least the mean of the maxima of x / k - z and -x / k - z, which are supports.

    Parameters
    ----------
    width, height
        Of the image, in pixels.

    Raises
    ------
    SceneError
        "value" if the eye is at its target.
    """
    low, high = (np.array([sign * extent.highest(sign * axis) for axis in np.eye(3)]) for sign in (-1.0, 1.0))
    box_center = (low + high) / 2.0
    size = float(np.max(high - low))
    center = np.array(viewpoint.target, np.float64) if viewpoint.target is not None else box_center
    given, axes = viewpoint.distance, axes_of(viewpoint.azimuth, viewpoint.elevation)
    if viewpoint.eye is not None:
        axes, given = looking(np.array(viewpoint.eye, np.float64), center)
    axes = rolled(axes, viewpoint.roll)
    forward = axes[2]
    if given is not None:
        extent = BoxExtent(low, high)
    frame = _Frame(extent, center, axes, fill, is_centered=viewpoint.target is None and viewpoint.eye is None)
    tangent = math.tan(math.radians(viewpoint.fov) / 2.0)
    if viewpoint.lens is not None:
        tangent = _FILM_WIDTH / 2.0 / viewpoint.lens * height / width
    if viewpoint.orthographic:
        half = given * tangent if given is not None else frame.half_height(width / height)
        center = center + frame.shift(None)
        away = (given or 0.0) + 2.0 * size + max(abs(frame.reach(forward)), abs(frame.reach(-forward))) or 1.0
        focal = height / (2.0 * half) if half > 0.0 else float(height)
        return camera_at(
            center - away * forward, axes, focal, width, height, projection="orthographic", **_lens(viewpoint, away)
        )
    nearest = frame.reach(-forward)  # in front of the center
    distance = given
    if distance is None:
        fitted = frame.distance(tangent * width / height, tangent)
        distance = max(fitted, 1e-3 * size, nearest + 1e-5 * size) or 1.0
    center = center + frame.shift(max(distance, 0.05 * size + nearest, 1e-9))  # the given eye may be inside
    focal = height / (2.0 * tangent)
    return camera_at(center - distance * forward, axes, focal, width, height, **_lens(viewpoint, distance))


@dataclass(frozen=True, slots=True, eq=False)
class _Frame:
    """An extent as seen along ``axes`` (right, up, forward), with coordinates relative to ``center``."""

    extent: Extent
    center: FloatArray
    axes: tuple[FloatArray, FloatArray, FloatArray]
    fill: float
    is_centered: bool

    def reach(self, direction: FloatArray) -> float:
        """Return the maximum of ``direction`` . p, relative to the center."""
        return self.extent.highest(direction) - float(direction @ self.center)

    def distance(self, across: float, along: float) -> float:
        """Return the least distance for the tangents of half the horizontal and vertical field of view."""
        return max(self._nearest(axis, self.fill * k) for axis, k in zip(self.axes, (across, along)))

    def _nearest(self, axis: FloatArray, k: float) -> float:
        """Return the least distance from which the extent is within ``k`` along an axis."""
        reaches = [self.reach(sign / k * axis - self.axes[2]) for sign in (1.0, -1.0)]
        return sum(reaches) / 2.0 if self.is_centered else max(reaches)

    def half_height(self, aspect: float) -> float:
        """Return half the height that a parallel projection must show."""
        halves = []
        for axis in self.axes[:2]:
            reaches = self.reach(axis), self.reach(-axis)
            halves.append(sum(reaches) / 2.0 if self.is_centered else max(reaches))
        return max(halves[1], halves[0] / aspect) / self.fill

    def shift(self, distance: float | None) -> FloatArray:
        """Return the vector (3,) by which the camera must move to center the extent, zero if it is not to be centered.

        ``distance`` is that of the eye from the center; None for a parallel projection.
        """
        right, up, _ = self.axes
        if not self.is_centered:
            return np.zeros(3)
        return self._middle(right, distance) * right + self._middle(up, distance) * up

    def _middle(self, axis: FloatArray, distance: float | None) -> float:
        """Return the c for which (x - c) / (z + distance) reaches equally far on both sides, x being along ``axis``.

        It reaches as far as t on both if the maxima of x - t z and -x - t z add up to 2 t distance; their sum minus
        that is a convex and falling function of t, whose zero the Illinois variant of regula falsi finds.
        """
        forward = self.axes[2]

        def sides(t: float) -> tuple[float, float]:
            """Return the maxima on both sides for a slope ``t``."""
            return self.reach(axis - t * forward), self.reach(-axis - t * forward)

        flat = sides(0.0)
        if distance is None:
            return (flat[0] - flat[1]) / 2.0
        low, high = ((sum(flat) / 2.0 / (distance + sign * self.reach(sign * forward))) for sign in (1.0, -1.0))

        def excess(t: float) -> float:
            """Return how much both sides exceed ``t`` together."""
            return sum(sides(t)) - 2.0 * t * distance

        t = _zero(excess, low, high, sum(flat))
        above, below = sides(t)
        return (above - below) / 2.0


def _zero(function: Callable[[float], float], low: float, high: float, scale: float) -> float:
    """Return a zero of a falling function between ``low`` and ``high`` (Illinois method; Dowell and Jarratt, 1971).

    ``scale`` is the magnitude of the terms of the function, whose rounding errors limit the precision.
    """
    at_low, at_high = function(low), function(high)
    t, last = low if abs(at_low) <= abs(at_high) else high, 0.0
    for _ in range(_MOST_STEPS):
        if at_low <= 0.0 or at_high >= 0.0:
            break
        t = (low * at_high - high * at_low) / (at_high - at_low)
        value = function(t)
        if abs(value) <= _PRECISION * scale:
            break
        is_repeated, last = value * last > 0.0, value
        if value > 0.0:
            low, at_low = t, value
            at_high = at_high / 2.0 if is_repeated else at_high
        else:
            high, at_high = t, value
            at_low = at_low / 2.0 if is_repeated else at_low
    return t


def _lens(viewpoint: Viewpoint, distance: float) -> dict[str, float]:
    """Return aperture and focus distance of a camera at a distance from its target."""
    return {"aperture": viewpoint.aperture, "focus": viewpoint.focus if viewpoint.focus is not None else distance}


def looking(eye: FloatArray, target: FloatArray) -> tuple[tuple[FloatArray, FloatArray, FloatArray], float]:
    """Return the axes of a level camera at ``eye`` (3,) that looks at ``target`` (3,), and the distance between them.

    Raises SceneError("value") if they are the same point.
    """
    forward = target - eye
    distance = float(np.linalg.norm(forward))
    if distance <= 1e-12 * max(1.0, float(np.abs(eye).max())):
        raise SceneError("value", "the camera's `eye` is at the point that it looks at", hint="move `eye` or `target`")
    forward = forward / distance
    above = np.array([0.0, 1.0, 0.0]) if abs(forward[1]) < 1.0 - 1e-9 else np.array([0.0, 0.0, -1.0])
    right = np.cross(forward, above)
    right = right / np.linalg.norm(right)
    return (right, np.cross(right, forward), forward), distance


def rolled(axes: tuple[FloatArray, FloatArray, FloatArray], roll: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Turn a camera's axes clockwise around its view direction, by degrees."""
    if not roll:
        return axes
    right, up, forward = axes
    c, s = math.cos(math.radians(roll)), math.sin(math.radians(roll))
    return c * right - s * up, s * right + c * up, forward


def axes_of(azimuth: float, elevation: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the right, up and forward vectors (3,) of a camera for angles in degrees, also at the poles."""
    a, e = math.radians(azimuth), math.radians(elevation)
    right = np.array([math.cos(a), 0.0, -math.sin(a)])
    forward = -np.array([math.sin(a) * math.cos(e), math.sin(e), math.cos(a) * math.cos(e)])
    return right, np.cross(right, forward), forward


# --- as text ---------------------------------------------------------------------------------------------------


def parse_viewpoint(text: str) -> Viewpoint | Camera:
    """Parse a viewpoint: a preset, ``azimuth=40,elevation=20,...``, both (``isometric,azimuth=10``), or a JSON file.

    Raises SceneError.
    """
    if text.strip().lower().endswith(".json"):
        return read_camera(Path(text.strip()))
    items = _items(text)
    if len(items) > 1 and all(map(_is_number, items)):
        named = ",".join(f"{name}={value}" for name, value in zip(_ANGLED, items))
        message = f"the numbers of the camera `{text[:60]}` need names"
        raise SceneError("value", message, hint=f"write `--camera {named}`; or {_PLACED}")
    start = PRESETS.get(_SIDES.get(items[0].lower(), items[0].lower())) if items else None
    changes = _changes(items[1:] if start is not None else items)
    return checked(replace(start or Viewpoint(), **changes))  # type: ignore[arg-type]


def named_changes(text: str) -> tuple[str, Changes] | None:
    """Return the name and the changes of a text such as ``main,fov=35``, None if it does not begin with a name.

    Raises SceneError for changes that no camera has.
    """
    items = _items(text)
    if not items or "=" in items[0] or _is_number(items[0]) or text.strip().lower().endswith(".json"):
        return None
    return items[0], _changes(items[1:])


Changes = dict[str, float | bool | Point]  # of the fields of a viewpoint


def _changes(items: Sequence[str]) -> Changes:
    """Parse fields of a viewpoint; raises SceneError."""
    changes: Changes = {}
    for item in items:
        key, value = _change(item)
        if key in changes:
            raise SceneError("value", f"the camera's `{key}` is given twice")
        changes[key] = value
    for one, other in (*((("eye", key)) for key in _ANGLED), ("lens", "fov")):
        if one in changes and other in changes:
            raise SceneError("value", f"the camera's `{one}` and `{other}` exclude each other", hint=_EYE_HINT)
    return changes


def _items(text: str) -> list[str]:
    """Split the text of a viewpoint at commas, but not between the numbers of a point: ``eye=1,2,3`` is one item."""
    items: list[str] = []
    for piece in filter(None, map(str.strip, text.split(","))):
        if items and items[-1].partition("=")[0].strip() in _POINTS and _is_number(piece):
            items[-1] += f":{piece}"
        else:
            items.append(piece)
    return items


# Names of views in other tools.
_SIDES = {"rear": "back", "side": "right", "below": "bottom", "above": "top", "catalog": "catalogue"}
_EYE_HINT = "an eye stands for azimuth, elevation and distance: write `--camera eye=1:2:3,target=0:0:0`; lens for fov"
_PLACED = f"a preset ({', '.join(PRESETS)}), or the JSON file of a camera"


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _change(item: str) -> tuple[str, float | bool | Point]:
    """Parse ``key=value``, or a flag without a value, into a field of ``Viewpoint`` and its value."""
    keys = tuple(field.name for field in fields(Viewpoint))
    key, equals, value = (piece.strip() for piece in item.partition("="))
    if key in _FLAGS and not equals:
        return key, True
    if key not in keys or key in _FLAGS or not equals:
        hint = suggest(key, (*keys, *PRESETS)) or f"expected {USAGE}"
        raise SceneError("value", f"unknown camera setting `{item}`", hint=hint)
    numbers = [_number(key, piece) for piece in value.split(":")]
    if len(numbers) != (3 if key in _POINTS else 1):
        wanted = f"three numbers, as `{key}=1,2,3`" if key in _POINTS else f"one number, as `{key}=2`"
        raise SceneError("value", f"the camera's `{key}` must be {wanted}, not `{value.replace(':', ',')}`")
    return key, (numbers[0], numbers[1], numbers[2]) if key in _POINTS else numbers[0]


def checked(viewpoint: Viewpoint) -> Viewpoint:
    """Return ``viewpoint`` unchanged if its values are in range; raises SceneError("value") otherwise."""
    points = (*(viewpoint.target or ()), *(viewpoint.eye or ()))
    optional = (viewpoint.distance, viewpoint.orbit, viewpoint.focus, viewpoint.lens, *points)
    plain = (
        viewpoint.azimuth, viewpoint.elevation, viewpoint.fov, viewpoint.aperture, viewpoint.roll,
        *(x or 0.0 for x in optional),
    )  # fmt: skip
    if not all(map(math.isfinite, plain)):
        raise SceneError("value", "the camera's numbers must be finite")
    if max(map(abs, plain)) > _FARTHEST:
        raise SceneError("value", f"the camera's numbers must be at most {_FARTHEST:g}")
    if not 1.0 <= viewpoint.fov <= 150.0:
        raise SceneError("value", f"the camera's `fov` must be between 1 and 150 degrees, not {viewpoint.fov:g}")
    if viewpoint.lens is not None and not 1.0 <= viewpoint.lens <= 2000.0:
        raise SceneError("value", f"the camera's `lens` must be between 1 and 2,000 mm, not {viewpoint.lens:g}")
    default = Viewpoint()
    for name in _ANGLED if viewpoint.eye is not None else ():
        if getattr(viewpoint, name) != getattr(default, name):
            raise SceneError("value", f"the camera's `eye` and `{name}` exclude each other", hint=_EYE_HINT)
    if viewpoint.eye is not None and viewpoint.target is not None:
        looking(np.array(viewpoint.eye, np.float64), np.array(viewpoint.target, np.float64))
    for name in ("distance", "focus"):
        value = getattr(viewpoint, name)
        if value is not None and value <= 0.0:
            raise SceneError("value", f"the camera's `{name}` must be above 0, not {value:g}")
    if viewpoint.aperture < 0.0:
        raise SceneError("value", f"the camera's `aperture` must be 0 or more, not {viewpoint.aperture:g}")
    return viewpoint


def _number(key: str, text: str) -> float:
    """Parse a number of a viewpoint; raises SceneError."""
    try:
        return float(text)
    except ValueError:
        raise SceneError("value", f"the camera's `{key}` must be a number, not `{text}`") from None
