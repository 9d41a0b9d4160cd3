"""Cameras: where a picture is taken from, and framing a scene so that all of it is in view.

World frame: right-handed, +x right, +y up, +z towards the viewer. At azimuth 0 the camera looks from +z towards -z; a
positive azimuth moves it towards +x, a positive elevation upwards. Angles are degrees, lengths the scene's units.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from scenelang.grammar.diagnostics import SceneError, suggest

FloatArray = npt.NDArray[np.float64]
Point = tuple[float, float, float]

MARGIN = 0.06  # of the half picture, on each side
_KEYS = ("azimuth", "elevation", "distance", "fov", "target")


@dataclass(frozen=True, slots=True)
class Camera:
    """A camera as the user asks for it. ``fov`` is the vertical field of view; ``distance`` is from the eye to
    ``target``; where either is None it is chosen so that the whole scene is in view."""

    azimuth: float = 30.0
    elevation: float = 25.0
    distance: float | None = None
    fov: float = 35.0
    target: Point | None = None


@dataclass(frozen=True, slots=True, eq=False)
class View:
    """A placed camera: ``eye`` and the orthonormal ``right``, ``up``, ``forward``, all (3,) in the world frame.

    ``tangent`` is tan(fov / 2), vertical; ``aspect`` is width / height.
    """

    eye: FloatArray
    right: FloatArray
    up: FloatArray
    forward: FloatArray
    tangent: float
    aspect: float

    @property
    def axes(self) -> FloatArray:
        """The rows right, up, forward: (3, 3), from world directions to the camera's."""
        return np.stack([self.right, self.up, self.forward])

    def project(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Points (N, 3) to picture coordinates (N, 2) in [-1, 1] where in view, +y up, and depths (N,) along forward.

        Points at or behind the eye have coordinates nan.
        """
        local = (points - self.eye) @ self.axes.T
        depth = local[:, 2]
        safe = np.where(depth > 0.0, depth, np.nan)
        flat = local[:, :2] / (safe[:, None] * np.array([self.tangent * self.aspect, self.tangent]))
        return flat, depth

    def moved(self, center: FloatArray, scale: float) -> View:
        """The same view of the world after ``p -> scale (p - center)``."""
        return replace(self, eye=(self.eye - center) * scale)


def place(camera: Camera, low: FloatArray, high: FloatArray, aspect: float) -> View:
    """Place ``camera`` before the box from ``low`` to ``high`` (3,), for pictures of width / height ``aspect``.

    Without a target the box is centred in the picture; without a distance the eye is as near as the eight corners of
    the box allow with a margin of 6 % of the half picture on every side.
    """
    right, up, forward = axes_of(camera.azimuth, camera.elevation)
    tangent = math.tan(math.radians(camera.fov) / 2.0)
    center = np.array(camera.target, np.float64) if camera.target is not None else (low + high) / 2.0
    corners = np.array(np.meshgrid(*zip(low, high, strict=True), indexing="ij")).reshape(3, 8).T
    x, y, z = ((corners - center) @ axis for axis in (right, up, forward))
    kx, ky = tangent * aspect * (1.0 - MARGIN), tangent * (1.0 - MARGIN)
    if camera.target is None:
        shift_x, near_x = _fit(x, z, kx)
        shift_y, near_y = _fit(y, z, ky)
        fitted = max(near_x, near_y)
        center = center + shift_x * right + shift_y * up
    else:
        fitted = max(float(np.max(np.abs(x) / kx - z)), float(np.max(np.abs(y) / ky - z)))
    extent = float(np.max(high - low))
    distance = camera.distance if camera.distance is not None else max(fitted, 1e-3 * extent) or 1.0
    return View(center - distance * forward, right, up, forward, tangent, aspect)


def axes_of(azimuth: float, elevation: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """The camera's right, up and forward, each (3,), for angles in degrees; well defined straight up and down too."""
    a, e = math.radians(azimuth), math.radians(elevation)
    right = np.array([math.cos(a), 0.0, -math.sin(a)])
    forward = -np.array([math.sin(a) * math.cos(e), math.sin(e), math.cos(a) * math.cos(e)])
    return right, np.cross(right, forward), forward


def _fit(x: FloatArray, z: FloatArray, k: float) -> tuple[float, float]:
    """The shift c and the least distance d with |x - c| <= k (z + d) for all corners."""
    a, b = float(np.max(x - k * z)), float(np.max(-x - k * z))
    return (a - b) / 2.0, (a + b) / (2.0 * k)


def parse_camera(text: str) -> Camera:
    """The camera that ``text`` describes: ``azimuth=40,elevation=20,distance=5,fov=35,target=0:1:0``, each optional.

    Raises SceneError("value") for anything else.
    """
    values: dict[str, float | Point] = {}
    for item in filter(None, (part.strip() for part in text.split(","))):
        key, equals, value = (piece.strip() for piece in item.partition("="))
        if key not in _KEYS or not equals:
            hint = suggest(key, _KEYS) or "write it like azimuth=40,elevation=20,distance=5,fov=35,target=0:1:0"
            raise SceneError("value", f"the camera does not understand `{item}`", hint=hint)
        if key in values:
            raise SceneError("value", f"the camera's `{key}` is given twice")
        numbers = [_number(key, piece) for piece in value.split(":")]
        if len(numbers) != (3 if key == "target" else 1):
            wanted = "three numbers like 0:1:0" if key == "target" else "one number"
            raise SceneError("value", f"the camera's `{key}` must be {wanted}, not `{value}`")
        values[key] = (numbers[0], numbers[1], numbers[2]) if key == "target" else numbers[0]
    return checked(Camera(**values))  # type: ignore[arg-type]


def checked(camera: Camera) -> Camera:
    """``camera`` itself when its numbers make sense; raises SceneError("value") otherwise."""
    plain = (camera.azimuth, camera.elevation, camera.fov, camera.distance or 0.0, *(camera.target or ()))
    if not all(map(math.isfinite, plain)):
        raise SceneError("value", "the camera's numbers must be finite")
    if not 1.0 <= camera.fov <= 150.0:
        raise SceneError("value", f"the camera's `fov` must be between 1 and 150 degrees, not {camera.fov:g}")
    if camera.distance is not None and camera.distance <= 0.0:
        raise SceneError("value", f"the camera's `distance` must be above 0, not {camera.distance:g}")
    return camera


def _number(key: str, text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise SceneError("value", f"the camera's `{key}` must be a number, not `{text}`") from None
