"""Viewpoints: what the user asks of a camera, and placing the camera so that the scene is in view.

At azimuth 0 the camera looks from +z towards -z; a positive azimuth moves it towards +x, a positive elevation upwards.
Angles are degrees, lengths the scene's units.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields, replace
from pathlib import Path

import numpy as np

from scenelang.backends.camera import Camera, FloatArray, camera_at, read_camera
from scenelang.grammar.diagnostics import SceneError, suggest

Point = tuple[float, float, float]

MARGIN = 0.06  # of the half picture, on each side


@dataclass(frozen=True, slots=True)
class Viewpoint:
    """``fov`` is the vertical field of view; ``distance`` is from the eye to ``target``; where either is None it is
    chosen so that the whole scene is in view.

    ``orthographic`` projects in parallel. ``follow`` aims at each frame's own middle. ``orbit`` is how far a film goes
    round the scene (None: once round a static scene). ``aperture`` is the radius of the lens, 0 for a pinhole, and
    ``focus`` the distance of what is sharp (None: the target's).
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
    """Place a camera before the box from ``low`` to ``high`` (3,), for pictures of ``width`` x ``height`` pixels.

    Without a target the box is centred in the picture; without a distance the eye is as near as the eight corners of
    the box allow with a margin of 6 % of the half picture on every side.
    """
    axes = axes_of(viewpoint.azimuth, viewpoint.elevation)
    right, up, forward = axes
    center = np.array(viewpoint.target, np.float64) if viewpoint.target is not None else (low + high) / 2.0
    corners = np.array(np.meshgrid(*zip(low, high, strict=True), indexing="ij")).reshape(3, 8).T
    x, y, z = ((corners - center) @ axis for axis in axes)
    extent = float(np.max(high - low))
    if viewpoint.orthographic:
        return _parallel(viewpoint, center, axes, x, y, z, extent, (width, height))
    tangent = math.tan(math.radians(viewpoint.fov) / 2.0)
    kx, ky = tangent * width / height * (1.0 - MARGIN), tangent * (1.0 - MARGIN)
    if viewpoint.target is None:
        fitted = max(_nearest(x, z, kx), _nearest(y, z, ky))
    else:
        fitted = max(float(np.max(np.abs(x) / kx - z)), float(np.max(np.abs(y) / ky - z)))
    distance = viewpoint.distance if viewpoint.distance is not None else max(fitted, 1e-3 * extent) or 1.0
    if viewpoint.target is None:
        depth = z + max(distance, 0.05 * extent - float(z.min()), 1e-9)  # the eye may be asked for within the box
        center = center + _middle(x, depth) * right + _middle(y, depth) * up
    focal = height / (2.0 * tangent)
    return camera_at(center - distance * forward, axes, focal, width, height, **_lens(viewpoint, distance))


def _parallel(
    viewpoint: Viewpoint,
    center: FloatArray,
    axes: tuple[FloatArray, FloatArray, FloatArray],
    x: FloatArray,
    y: FloatArray,
    z: FloatArray,
    extent: float,
    size: tuple[int, int],
) -> Camera:
    """A camera of parallel projection: ``distance`` stands for the height of what is seen at ``fov``."""
    width, height = size
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
    return {"aperture": viewpoint.aperture, "focus": viewpoint.focus if viewpoint.focus is not None else distance}


def axes_of(azimuth: float, elevation: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """The camera's right, up and forward, each (3,), for angles in degrees; well defined straight up and down too."""
    a, e = math.radians(azimuth), math.radians(elevation)
    right = np.array([math.cos(a), 0.0, -math.sin(a)])
    forward = -np.array([math.sin(a) * math.cos(e), math.sin(e), math.cos(a) * math.cos(e)])
    return right, np.cross(right, forward), forward


def _nearest(x: FloatArray, z: FloatArray, k: float) -> float:
    """The least distance d for which some c has |x - c| <= k (z + d) for all corners."""
    return float(np.max(x - k * z) + np.max(-x - k * z)) / (2.0 * k)


def _middle(x: FloatArray, depth: FloatArray) -> float:
    """The c with the least greatest |x - c| / depth: the corners project as far to one side of it as to the other.
    That greatest ratio is the largest of (x_i - x_j) / (depth_i + depth_j) over all pairs of corners."""
    sums = depth[:, None] + depth[None, :]
    ratios = (x[:, None] - x[None, :]) / sums
    i, j = np.unravel_index(int(np.argmax(ratios)), ratios.shape)
    return float(x[i] * depth[j] + x[j] * depth[i]) / float(sums[i, j])


# --- as text ---------------------------------------------------------------------------------------------------


def parse_viewpoint(text: str) -> Viewpoint | Camera:
    """What ``text`` asks for: a preset, ``azimuth=40,elevation=20,...``, a preset with changes
    (``isometric,azimuth=10``), or the path of a camera's JSON file. Raises SceneError for anything else."""
    if text.strip().lower().endswith(".json"):
        return read_camera(Path(text.strip()))
    items = [part for part in (piece.strip() for piece in text.split(",")) if part]
    start = PRESETS.get(items[0]) if items else None
    changes: dict[str, float | bool | Point] = {}
    for item in items[1:] if start is not None else items:
        key, value = _change(item)
        if key in changes:
            raise SceneError("value", f"the camera's `{key}` is given twice")
        changes[key] = value
    return checked(replace(start or Viewpoint(), **changes))  # type: ignore[arg-type]


def _change(item: str) -> tuple[str, float | bool | Point]:
    """The field and value of ``key=value``, or of a flag by itself."""
    keys = tuple(field.name for field in fields(Viewpoint))
    key, equals, value = (piece.strip() for piece in item.partition("="))
    if key in _FLAGS and not equals:
        return key, True
    if key not in keys or key in _FLAGS or not equals:
        hint = suggest(key, (*keys, *PRESETS)) or f"it can be {USAGE}"
        raise SceneError("value", f"the camera does not understand `{item}`", hint=hint)
    numbers = [_number(key, piece) for piece in value.split(":")]
    if len(numbers) != (3 if key == "target" else 1):
        wanted = "three numbers like 0:1:0" if key == "target" else "one number"
        raise SceneError("value", f"the camera's `{key}` must be {wanted}, not `{value}`")
    return key, (numbers[0], numbers[1], numbers[2]) if key == "target" else numbers[0]


def checked(viewpoint: Viewpoint) -> Viewpoint:
    """``viewpoint`` itself when its numbers make sense; raises SceneError("value") otherwise."""
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
    try:
        return float(text)
    except ValueError:
        raise SceneError("value", f"the camera's `{key}` must be a number, not `{text}`") from None
