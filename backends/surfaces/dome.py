"""The dome: radiance around a scene by direction, which every quality draws and reflects.

A dome is an image in latitude and longitude, made from the gradient and the softboxes of an environment, from the sun's
position, or from a file. Directions are unit vectors in the dome's own frame, which ``Dome.turned`` turns about the
vertical axis. Row 0 of the image is the zenith; its middle column is +z, where longitude grows towards +x.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]
Floats = npt.NDArray[np.floating]
Color = tuple[float, float, float]

_HEIGHT = 128  # rows of the image of an environment: its softboxes have soft edges
_TABLE_HEIGHT = 24  # rows of blurred images, and of irradiance
_SOURCE_HEIGHT, _LIGHT_HEIGHT = 32, 16  # rows of the images from which blurred images and irradiance are computed
_CACHED_PANORAMAS = 8  # of which the images stay in memory
_BLURS = (0.25, 0.5, 0.75, 1.0)  # roughnesses of blurred images


def direction_at(azimuth: float, elevation: float) -> FloatArray:
    """Return the unit direction (3,) at an azimuth, from +z towards +x, and an elevation, both in radians."""
    flat = math.cos(elevation)
    return np.array([math.sin(azimuth) * flat, math.sin(elevation), math.cos(azimuth) * flat])


@dataclass(frozen=True, slots=True)
class Softbox:
    """A rectangular light far away.

    Attributes
    ----------
    azimuth, elevation
        Direction of its middle in degrees, from +z towards +x, and above the horizon.
    width, height
        Half its angles in degrees.
    radiance
        Linear sRGB, in units of the mean radiance of the sky.
    """

    azimuth: float
    elevation: float
    width: float
    height: float
    radiance: Color

    def seen(self, directions: Floats) -> Floats:
        """Return the radiance (N, 3) in ``directions`` (N, 3); the edges are soft."""
        a, e = math.radians(self.azimuth), math.radians(self.elevation)
        middle = direction_at(a, e)
        right = np.array([math.cos(a), 0.0, -math.sin(a)])
        ahead = directions @ middle
        away = np.maximum(ahead, 1e-6)
        x = np.abs(directions @ right) / away / math.tan(math.radians(self.width))
        y = np.abs(directions @ np.cross(middle, right)) / away / math.tan(math.radians(self.height))
        share = _step(1.0 - x) * _step(1.0 - y) * (ahead > 0.0)
        return np.asarray(share[:, None] * np.array(self.radiance), np.float64)


def _step(inside: Floats) -> Floats:
    """Return the share of a softbox's radiance, 0 to 1, by the smoothstep polynomial 3 t^2 - 2 t^3.

    ``inside`` is the distance to the edge in half widths, negative outside; the share rises over the first quarter.
    """
    t = np.clip(inside * 4.0, 0.0, 1.0)
    return np.asarray(t * t * (3.0 - 2.0 * t), np.float64)


@dataclass(frozen=True, slots=True)
class Sky:
    """A gradient from the zenith over the horizon to the nadir, with softboxes, in units of its mean radiance.

    In each color, the dome of a sky lights a surface that faces upwards as much as a uniform one of radiance 1 does.
    """

    zenith: Color = (1.0, 1.0, 1.0)
    horizon: Color = (1.0, 1.0, 1.0)
    nadir: Color = (1.0, 1.0, 1.0)
    softboxes: tuple[Softbox, ...] = ()


UNIFORM = Sky()


@dataclass(frozen=True, slots=True, eq=False)
class Panorama:
    """Image of a dome: linear sRGB radiance ``image`` (H, 2 H, 3)."""

    image: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Dome:
    """Radiance by direction: a panorama, turned by ``turn`` degrees about the vertical axis, from +z towards +x.

    ``strength`` is a factor of its radiance.
    """

    panorama: Panorama
    turn: float = 0.0
    strength: float = 1.0

    def radiance(self, directions: Floats, roughness: Floats | None = None) -> FloatArray:
        """Return the radiance (N, 3) in unit ``directions`` (N, 3).

        ``roughness`` (N,) blurs it as a rough surface does whose mirror direction this is.
        """
        across, down = self._places(directions)
        sharp = _sampled(self.panorama.image, across, down)
        if roughness is None:
            return sharp * self.strength
        level = np.clip(np.asarray(roughness) / _BLURS[0], 0.0, float(len(_BLURS)))
        below = np.minimum(level.astype(np.int64), len(_BLURS) - 1)
        share = (level - below)[:, None]
        images = [sharp, *(_sampled(image, across, down) for image in _blurred(self.panorama))]
        first, second = (_chosen(images, below + step) for step in (0, 1))
        return np.asarray((first + (second - first) * share) * self.strength, np.float64)

    def irradiance(self, normals: Floats, *, above: bool) -> npt.NDArray[np.float32]:
        """Return the irradiance (N, 3) on surfaces with ``normals`` (N, 3), divided by pi.

        ``above`` leaves out the light from below the horizon, which a ground hides.
        """
        image = _irradiance(self.panorama)[int(above)]
        across, down = self._places(normals)
        row = (down * (len(image) - 1) + 0.5).astype(np.int32)
        column = (across * len(image) * 2).astype(np.int32)
        return image.reshape(-1, 3).take(row * np.int32(2 * len(image)) + column, 0) * np.float32(self.strength)

    def _places(self, directions: Floats) -> tuple[Floats, Floats]:
        """Return the shares across and down the image (N,) at which directions (N, 3) lie."""
        angle = np.arctan2(directions[:, 0], directions[:, 2])
        down = np.arccos(np.clip(directions[:, 1], -1.0, 1.0)) * angle.dtype.type(1.0 / math.pi)
        across = angle * angle.dtype.type(0.5 / math.pi) + angle.dtype.type(1.5 - self.turn / 360.0 % 1.0)
        return across - np.floor(across), down


@lru_cache(maxsize=_CACHED_PANORAMAS)
def panorama_of(sky: Sky, ambient: Color) -> Panorama:
    """Return the image of a sky whose light on a horizontal surface is that of the uniform radiance ``ambient``."""
    directions = directions_of(_HEIGHT).reshape(-1, 3)
    height = directions[:, 1:2]
    upper = np.array(sky.horizon) + (np.array(sky.zenith) - np.array(sky.horizon)) * np.maximum(height, 0.0)
    lower = (np.array(sky.nadir) - np.array(sky.horizon)) * np.sqrt(np.maximum(-height, 0.0))
    radiance = upper + lower + sum((box.seen(directions) for box in sky.softboxes), np.zeros(3))
    weight = np.maximum(height, 0.0) * solid_angles(_HEIGHT).reshape(-1, 1)
    mean = (radiance * weight).sum(axis=0) / weight.sum()
    return Panorama((radiance / mean * np.array(ambient)).reshape(_HEIGHT, 2 * _HEIGHT, 3))


def directions_of(height: int) -> FloatArray:
    """Return the directions (H, 2 H, 3) of the pixels of a dome's image of ``height`` rows."""
    polar = (np.arange(height) + 0.5) / height * math.pi
    around = ((np.arange(2 * height) + 0.5) / (2 * height) - 0.5) * 2.0 * math.pi
    flat = np.sin(polar)[:, None]
    parts = (
        flat * np.sin(around),
        np.broadcast_to(np.cos(polar)[:, None], (height, 2 * height)),
        flat * np.cos(around),
    )
    return np.stack(parts, axis=2)


def solid_angles(height: int) -> FloatArray:
    """Return the solid angles (H, 2 H) of the pixels of a dome's image."""
    edges = np.cos(np.arange(height + 1) / height * math.pi)
    return np.repeat((edges[:-1] - edges[1:])[:, None], 2 * height, axis=1) * (math.pi / height)


def smaller(image: FloatArray, height: int) -> FloatArray:
    """Return a dome's image with ``height`` rows, by averaging over solid angles; as it is if it has no more."""
    rows = len(image)
    if rows <= height:
        return image
    weights = solid_angles(rows)[:, :, None]
    down, across = np.arange(rows) * height // rows, np.arange(2 * rows) * height // rows
    target = (down[:, None] * 2 * height + across).reshape(-1)
    total = np.stack(
        [np.bincount(target, (image * weights)[:, :, k].reshape(-1), 2 * height * height) for k in range(3)]
    )
    count = np.bincount(target, weights.reshape(-1), 2 * height * height)
    return np.asarray((total / count).T.reshape(height, 2 * height, 3), np.float64)


@lru_cache(maxsize=_CACHED_PANORAMAS)
def _irradiance(panorama: Panorama) -> tuple[npt.NDArray[np.float32], npt.NDArray[np.float32]]:
    """Return the irradiance by normal, divided by pi, of all of a dome and of its upper half, as images.

    They are so large that the nearest pixel is precise to a level of 255.
    """
    source = smaller(panorama.image, _LIGHT_HEIGHT)
    toward = directions_of(len(source)).reshape(-1, 3)
    light = source.reshape(-1, 3) * solid_angles(len(source)).reshape(-1, 1) / math.pi
    cosine = np.maximum(directions_of(_TABLE_HEIGHT).reshape(-1, 3) @ toward.T, 0.0)
    directions = directions_of(_HEIGHT).reshape(-1, 3)
    both = []
    for part in (light, light * (toward[:, 1:2] > 0.0)):
        coarse = Dome(Panorama((cosine @ part).reshape(_TABLE_HEIGHT, 2 * _TABLE_HEIGHT, 3)))
        both.append(coarse.radiance(directions).reshape(_HEIGHT, 2 * _HEIGHT, 3).astype(np.float32))
    return both[0], both[1]


@lru_cache(maxsize=_CACHED_PANORAMAS)
def _blurred(panorama: Panorama) -> tuple[FloatArray, ...]:
    """Return the images of a dome that surfaces of the roughnesses ``_BLURS`` reflect.

    The lobe is that of GGX facets for a viewer along the normal (Karis, 2013).
    """
    source = smaller(panorama.image, _SOURCE_HEIGHT)
    toward = directions_of(len(source)).reshape(-1, 3)
    cosine = directions_of(_TABLE_HEIGHT).reshape(-1, 3) @ toward.T
    half = np.sqrt(np.clip(0.5 + 0.5 * cosine, 0.0, 1.0))  # cosine between the normal and the facet that reflects
    images = []
    for roughness in _BLURS:
        alpha2 = roughness**4
        lobe = alpha2 / (half * half * (alpha2 - 1.0) + 1.0) ** 2 * np.maximum(cosine, 0.0)
        lobe *= solid_angles(len(source)).reshape(-1)
        images.append((lobe / lobe.sum(axis=1, keepdims=True)) @ source.reshape(-1, 3))
    return tuple(image.reshape(_TABLE_HEIGHT, 2 * _TABLE_HEIGHT, 3) for image in images)


def _chosen(images: Sequence[FloatArray], number: npt.NDArray[np.int64]) -> FloatArray:
    """Return for each row its value (N, 3) from the image ``number`` (N,) of several (N, 3)."""
    out = images[0].copy()
    for k in range(1, len(images)):
        rows = number == k
        out[rows] = images[k][rows]
    return out


def _sampled(image: FloatArray, across: Floats, down: Floats) -> FloatArray:
    """Return values (N, 3) of an image at shares of its width and height (N,), bilinear."""
    height, width = image.shape[:2]
    x, y = across * width - 0.5, np.clip(down * height - 0.5, 0.0, height - 1.0)
    left, top = np.floor(x).astype(np.int64), np.minimum(y.astype(np.int64), max(0, height - 2))
    fx, fy = (x - left)[:, None], (y - top)[:, None]
    below, flat = np.minimum(top + 1, height - 1), image.reshape(-1, 3)
    first, second = left % width, (left + 1) % width
    upper = flat[top * width + first] * (1.0 - fx) + flat[top * width + second] * fx
    lower = flat[below * width + first] * (1.0 - fx) + flat[below * width + second] * fx
    return np.asarray(upper + (lower - upper) * fy, np.float64)
