"""The one camera type: pinhole or parallel, placed in the world, with its JSON form.

World frame: right-handed, +x right, +y up, +z towards the viewer. Camera frame: +x right, +y down, +z forward, as in
OpenCV. A world point p has the camera coordinates ``q = R p + t`` and the picture position ``K q / q_z`` (``K (q_x,
q_y, 1)`` for a parallel projection) in pixels from the top left corner, so that pixel centres lie at halves.
"""

from __future__ import annotations

import json
import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from scenelang.backends.files import read_regular
from scenelang.grammar.diagnostics import SceneError

FloatArray = npt.NDArray[np.float64]
Projection = Literal["perspective", "orthographic"]

FORMAT, VERSION = "scenelang-camera", 1
AXES = "camera: x right, y down, z forward; world: x right, y up, z towards the viewer; pixel centres at halves"
LARGEST = 8192
_LARGEST_FILE = 100_000


@dataclass(frozen=True, slots=True, eq=False)
class Camera:
    """A placed camera for pictures of ``width`` x ``height`` pixels.

    ``intrinsics`` K (3, 3) has pixels for units: the focal lengths (pixels per scene unit for "orthographic") and the
    principal point. ``world_to_camera`` (4, 4) is rigid. ``aperture`` is the lens's radius and ``focus`` the distance
    of what is sharp, in scene units; an aperture of 0 is a pinhole.
    """

    width: int
    height: int
    intrinsics: FloatArray
    world_to_camera: FloatArray
    projection: Projection = "perspective"
    aperture: float = 0.0
    focus: float = 1.0

    @property
    def is_parallel(self) -> bool:
        return self.projection == "orthographic"

    @property
    def right(self) -> FloatArray:
        """(3,) in the world, as ``up`` and ``forward`` are."""
        return np.asarray(self.world_to_camera[0, :3], np.float64)

    @property
    def up(self) -> FloatArray:
        return -np.asarray(self.world_to_camera[1, :3], np.float64)

    @property
    def forward(self) -> FloatArray:
        return np.asarray(self.world_to_camera[2, :3], np.float64)

    @property
    def axes(self) -> FloatArray:
        """The rows right, up, forward (3, 3): from world directions to those of the picture, +y up."""
        return np.stack([self.right, self.up, self.forward])

    @property
    def eye(self) -> FloatArray:
        """The camera's place (3,) in the world."""
        return np.asarray(-self.world_to_camera[:3, :3].T @ self.world_to_camera[:3, 3], np.float64)

    @property
    def focal(self) -> tuple[float, float]:
        """Pixels per unit at depth 1 (at any depth for parallel projection), across and down."""
        return float(self.intrinsics[0, 0]), float(self.intrinsics[1, 1])

    @property
    def principal(self) -> tuple[float, float]:
        """Where the axis of view meets the picture, in pixels."""
        return float(self.intrinsics[0, 2]), float(self.intrinsics[1, 2])

    def project(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Points (N, 3) to pixels (N, 2) from the top left corner, and depths (N,) along the axis of view.

        Of points at or behind the eye of a perspective camera the pixels are nan.
        """
        local = points @ self.world_to_camera[:3, :3].T + self.world_to_camera[:3, 3]
        depth = local[:, 2]
        safe = np.ones_like(depth) if self.is_parallel else np.where(depth > 0.0, depth, np.nan)
        return local[:, :2] / safe[:, None] * np.array(self.focal) + np.array(self.principal), depth

    def rescaled(self, center: FloatArray, scale: float) -> Camera:
        """The same picture of the world after ``p -> scale (p - center)``."""
        pose = self.world_to_camera.copy()
        pose[:3, 3] = -pose[:3, :3] @ ((self.eye - center) * scale)
        intrinsics = self.intrinsics.copy()
        if self.is_parallel:
            intrinsics[[0, 1], [0, 1]] /= scale
        aperture, focus = self.aperture * scale, self.focus * scale
        return replace(self, world_to_camera=pose, intrinsics=intrinsics, aperture=aperture, focus=focus)

    def resized(self, width: int, height: int) -> Camera:
        """The same view in a picture of another size: as much of it as the height shows."""
        ratio = height / self.height
        intrinsics = self.intrinsics.copy()
        intrinsics[:2] *= ratio
        intrinsics[0, 2] += (width - self.width * ratio) / 2.0
        return replace(self, width=width, height=height, intrinsics=intrinsics)


def camera_at(
    eye: FloatArray, axes: tuple[FloatArray, FloatArray, FloatArray], focal: float, width: int, height: int, **more: Any
) -> Camera:
    """A camera at ``eye`` (3,) with the orthonormal right, up and forward ``axes``, ``focal`` pixels long, whose axis
    of view meets the middle of the picture."""
    right, up, forward = axes
    pose = np.eye(4)
    pose[:3, :3] = np.stack([right, -up, forward])
    pose[:3, 3] = -pose[:3, :3] @ eye
    intrinsics = np.array([[focal, 0.0, width / 2.0], [0.0, focal, height / 2.0], [0.0, 0.0, 1.0]])
    return Camera(width, height, intrinsics, pose, **more)


def camera_to_json(camera: Camera) -> dict[str, Any]:
    """The JSON form, which ``camera_from_json`` reads back."""
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
    """The camera of a JSON file; raises SceneError."""
    target = Path(path)
    try:
        if target.stat().st_size > _LARGEST_FILE:
            raise SceneError("file", f"`{target}` is too large for a camera")
        data = json.loads(read_regular(target))
    except OSError as error:
        raise SceneError("file", f"cannot read {target}: {error.strerror or error}") from error
    except (ValueError, RecursionError):
        raise SceneError("value", f"`{target}` holds no camera: it is no JSON") from None
    return camera_from_json(data)


def camera_from_json(data: Any) -> Camera:
    """The camera that ``camera_to_json`` wrote, or another program in that form; raises SceneError("value")."""
    if not isinstance(data, dict) or data.get("format", FORMAT) != FORMAT:
        raise SceneError("value", f'a camera in JSON is an object with "format": "{FORMAT}"')
    projection = data.get("projection", "perspective")
    if projection not in ("perspective", "orthographic"):
        raise SceneError("value", f"a camera's projection is perspective or orthographic, not {projection!r}")
    size = [data.get(name) for name in ("width", "height")]
    if not all(type(side) is int and 1 <= side <= LARGEST for side in size):
        raise SceneError("value", f"a camera's width and height are whole numbers from 1 to {LARGEST}")
    intrinsics, pose = _matrix(data, "K", 3), _matrix(data, "world_to_camera", 4)
    turn = pose[:3, :3]
    with np.errstate(all="ignore"):
        is_rigid = np.abs(turn @ turn.T - np.eye(3)).max() <= 1e-4
    if not is_rigid or np.linalg.det(turn) < 0 or (pose[3] != [0, 0, 0, 1]).any():
        raise SceneError("value", "a camera's world_to_camera must be rigid: a rotation and a translation")
    fx, fy = float(intrinsics[0, 0]), float(intrinsics[1, 1])
    if min(fx, fy) <= 0.0 or abs(fx - fy) > 1e-6 * fx or intrinsics[0, 1] or (intrinsics[2] != [0, 0, 1]).any():
        raise SceneError("value", "a camera's K must have square pixels: [[f, 0, cx], [0, f, cy], [0, 0, 1]]")
    aperture, focus = _length(data, "aperture", 0.0), _length(data, "focus", 1.0)
    return Camera(size[0], size[1], intrinsics, pose, projection, aperture, focus)  # type: ignore[arg-type]


def _matrix(data: dict[str, Any], name: str, size: int) -> FloatArray:
    try:
        matrix = np.array(data.get(name), np.float64)
    except (TypeError, ValueError):
        matrix = np.zeros(0)
    if matrix.shape != (size, size) or not np.isfinite(matrix).all():
        raise SceneError("value", f"a camera's {name} must be {size} x {size} finite numbers")
    return matrix


def _length(data: dict[str, Any], name: str, default: float) -> float:
    value = data.get(name, default)
    if type(value) not in (int, float) or not math.isfinite(value) or value < 0.0:
        raise SceneError("value", f"a camera's {name} must be a number, 0 or more")
    return float(value)
