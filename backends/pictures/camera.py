"""Cameras: pinhole or parallel projection, placed in the world, with a JSON form.

World frame: right-handed, +x right, +y up, +z towards the viewer. Camera frame: +x right, +y down, +z forward, as in
OpenCV. A world point p has the camera coordinates ``q = R p + t`` and the image position ``K q / q_z`` (``K (q_x,
q_y, 1)`` for a parallel projection) in pixels from the top left corner; pixel centers are at half-integers.
"""

from __future__ import annotations

import json
import math
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from scenelang.backends.files import read_regular
from scenelang.grammar.diagnostics import SceneError, suggest

FloatArray = npt.NDArray[np.float64]
Projection = Literal["perspective", "orthographic"]

FORMAT, VERSION = "scenelang-camera", 1
AXES = "camera: x right, y down, z forward; world: x right, y up, z towards the viewer; pixel centres at halves"
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

MARGIN = 0.06  # on each side, relative to half the image


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


PRESETS = {
    "turntable": Viewpoint(30.0, 20.0, orbit=360.0),
    "top": Viewpoint(0.0, 90.0),
    "isometric": Viewpoint(45.0, math.degrees(math.atan(math.sqrt(0.5))), orthographic=True),
    "follow": Viewpoint(30.0, 20.0, follow=True),
}
_FLAGS = ("orthographic", "follow")
USAGE = f"{', '.join(PRESETS)}, azimuth=40,elevation=20,distance=5,fov=35,target=0:1:0, or the JSON file of a camera"


def place(viewpoint: Viewpoint, low: FloatArray, high: FloatArray, width: int, height: int) -> Camera:
    """Place a camera in front of a box.

    Without a target the box is centered in the image. Without a distance the eye is as near as the eight corners of the
    box allow, with a margin of 6 % of half the image on every side.

    Parameters
    ----------
    low, high : (3,)
        Corners of the box, in scene units.
    width, height
        Of the image, in pixels.
    """
    axes = axes_of(viewpoint.azimuth, viewpoint.elevation)
    right, up, forward = axes
    center = np.array(viewpoint.target, np.float64) if viewpoint.target is not None else (low + high) / 2.0
    corners = np.array(np.meshgrid(*zip(low, high, strict=True), indexing="ij")).reshape(3, 8).T
    x, y, z = ((corners - center) @ axis for axis in axes)
    extent = float(np.max(high - low))
    if viewpoint.orthographic:
        return _parallel(viewpoint, center, axes, (x, y, z), extent, (width, height))
    tangent = math.tan(math.radians(viewpoint.fov) / 2.0)
    kx, ky = tangent * width / height * (1.0 - MARGIN), tangent * (1.0 - MARGIN)
    if viewpoint.target is None:
        fitted = max(_nearest(x, z, kx), _nearest(y, z, ky))
    else:
        fitted = max(float(np.max(np.abs(x) / kx - z)), float(np.max(np.abs(y) / ky - z)))
    distance = viewpoint.distance if viewpoint.distance is not None else max(fitted, 1e-3 * extent) or 1.0
    if viewpoint.target is None:
        depth = z + max(distance, 0.05 * extent - float(z.min()), 1e-9)  # the requested eye may be inside the box
        center = center + _middle(x, depth) * right + _middle(y, depth) * up
    focal = height / (2.0 * tangent)
    return camera_at(center - distance * forward, axes, focal, width, height, **_lens(viewpoint, distance))


def _parallel(
    viewpoint: Viewpoint,
    center: FloatArray,
    axes: tuple[FloatArray, FloatArray, FloatArray],
    corners: tuple[FloatArray, FloatArray, FloatArray],
    extent: float,
    size: tuple[int, int],
) -> Camera:
    """Place a camera with parallel projection; ``distance`` determines the visible height via ``fov``.

    ``corners`` are the coordinates of the box's corners along the axes, relative to ``center``.
    """
    (x, y, z), (width, height) = corners, size
    if viewpoint.target is None:
        center = center + (x.max() + x.min()) / 2.0 * axes[0] + (y.max() + y.min()) / 2.0 * axes[1]
        half_x, half_y = (x.max() - x.min()) / 2.0, (y.max() - y.min()) / 2.0
    else:
        half_x, half_y = np.abs(x).max(), np.abs(y).max()
    wanted = max(half_y, half_x * height / width) / (1.0 - MARGIN)
    if viewpoint.distance is not None:
        wanted = viewpoint.distance * math.tan(math.radians(viewpoint.fov) / 2.0)
    away = (viewpoint.distance or 0.0) + 2.0 * extent + float(np.abs(z).max()) or 1.0
    focal = height / (2.0 * float(wanted)) if wanted > 0.0 else float(height)
    eye = center - away * axes[2]
    return camera_at(eye, axes, focal, width, height, projection="orthographic", **_lens(viewpoint, away))


def _lens(viewpoint: Viewpoint, distance: float) -> dict[str, float]:
    """Return aperture and focus distance of a camera at a distance from its target."""
    return {"aperture": viewpoint.aperture, "focus": viewpoint.focus if viewpoint.focus is not None else distance}


def axes_of(azimuth: float, elevation: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the right, up and forward vectors (3,) of a camera for angles in degrees, also at the poles."""
    a, e = math.radians(azimuth), math.radians(elevation)
    right = np.array([math.cos(a), 0.0, -math.sin(a)])
    forward = -np.array([math.sin(a) * math.cos(e), math.sin(e), math.cos(a) * math.cos(e)])
    return right, np.cross(right, forward), forward


def _nearest(x: FloatArray, z: FloatArray, k: float) -> float:
    """Return the smallest distance d such that some c satisfies |x - c| <= k (z + d) for all corners."""
    return float(np.max(x - k * z) + np.max(-x - k * z)) / (2.0 * k)


def _middle(x: FloatArray, depth: FloatArray) -> float:
    """Return the c that minimizes the maximum of |x - c| / depth: the projection extends equally far on both sides.

    The minimum is the largest of (x_i - x_j) / (depth_i + depth_j) over all pairs of corners.
    """
    sums = depth[:, None] + depth[None, :]
    ratios = (x[:, None] - x[None, :]) / sums
    i, j = np.unravel_index(int(np.argmax(ratios)), ratios.shape)
    return float(x[i] * depth[j] + x[j] * depth[i]) / float(sums[i, j])


# --- as text ---------------------------------------------------------------------------------------------------


def parse_viewpoint(text: str) -> Viewpoint | Camera:
    """Parse a viewpoint: a preset, ``azimuth=40,elevation=20,...``, both (``isometric,azimuth=10``), or a JSON file.

    Raises SceneError.
    """
    if text.strip().lower().endswith(".json"):
        return read_camera(Path(text.strip()))
    items = [part for part in (piece.strip() for piece in text.split(",")) if part]
    if len(items) > 1 and all(map(_is_number, items)):
        named = ",".join(f"{name}={value}" for name, value in zip(("azimuth", "elevation", "distance"), items))
        message = f"the numbers of the camera `{text[:60]}` need names"
        raise SceneError("value", message, hint=f"write `--camera {named}`; or {_PLACED}")
    if len(items) == 1 and items[0].lower() in _SIDES:
        azimuth, elevation = _SIDES[items[0].lower()]
        hint = f"from this side: `--camera azimuth={azimuth},elevation={elevation}`; presets: {', '.join(PRESETS)}"
        raise SceneError("value", f"the camera has no preset `{items[0]}`", hint=hint)
    start = PRESETS.get(items[0]) if items else None
    changes: dict[str, float | bool | Point] = {}
    for item in items[1:] if start is not None else items:
        key, value = _change(item)
        if key in changes:
            raise SceneError("value", f"the camera's `{key}` is given twice")
        changes[key] = value
    return checked(replace(start or Viewpoint(), **changes))  # type: ignore[arg-type]


# Names of views in other tools: azimuth and elevation.
_SIDES = {
    "front": (0, 0), "right": (90, 0), "back": (180, 0), "rear": (180, 0), "left": (-90, 0), "side": (90, 0),
    "bottom": (0, -90), "below": (0, -90), "above": (0, 90),
}  # fmt: skip
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
    if len(numbers) != (3 if key == "target" else 1):
        wanted = "three numbers like 0:1:0" if key == "target" else "one number"
        raise SceneError("value", f"the camera's `{key}` must be {wanted}, not `{value}`")
    return key, (numbers[0], numbers[1], numbers[2]) if key == "target" else numbers[0]


def checked(viewpoint: Viewpoint) -> Viewpoint:
    """Return ``viewpoint`` unchanged if its values are in range; raises SceneError("value") otherwise."""
    optional = (viewpoint.distance, viewpoint.orbit, viewpoint.focus, *(viewpoint.target or ()))
    plain = (viewpoint.azimuth, viewpoint.elevation, viewpoint.fov, viewpoint.aperture, *(x or 0.0 for x in optional))
    if not all(map(math.isfinite, plain)):
        raise SceneError("value", "the camera's numbers must be finite")
    if not 1.0 <= viewpoint.fov <= 150.0:
        raise SceneError("value", f"the camera's `fov` must be between 1 and 150 degrees, not {viewpoint.fov:g}")
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
