"""The tone of the backdrop: the one before which the outline of a scene is visible.

A backdrop as light as the objects before it hides their outline. So the tone is chosen by a small draft: the lightness
of the scene beside its outline is compared with that of each tone. The first tone that differs enough is taken, else
the one that differs most. Colors of the scene stay the same, as the light does.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from scenelang.backends.pictures.camera import Camera
from scenelang.backends.surfaces.appearance import Color
from scenelang.backends.surfaces.environments import tone

FloatArray = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]

# Radiance of the tones in the order of preference: the light gray of a studio, a lighter one, slate, charcoal, gray.
TONES: tuple[Color, ...] = (
    (0.60, 0.61, 0.625), (0.93, 0.935, 0.945), (0.085, 0.088, 0.095), (0.030, 0.031, 0.034), (0.30, 0.31, 0.325),
)  # fmt: skip
_ENOUGH = 25.0  # median difference in L*: the eye sees 20 at a glance
_SIDE = 240  # pixels of the longer side of the small draft
_REACH = 1  # pixels from the outline at which lightness is compared
# CIE L* of a radiance: 116 times its cube root minus 16, linear near black.
_LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


def lightness(linear: npt.NDArray[np.floating]) -> FloatArray:
    """Return CIE L* (...) of linear sRGB (..., 3)."""
    luminance = np.asarray(linear, np.float64) @ _LUMINANCE
    return np.asarray(np.where(luminance > 0.008856, 116.0 * np.cbrt(luminance) - 16.0, 903.3 * luminance), np.float64)


def small(camera: Camera) -> Camera:
    """Return the camera with which the small draft is drawn."""
    ratio = _SIDE / max(camera.width, camera.height)
    if ratio >= 1.0:
        return camera
    return camera.resized(max(1, round(camera.width * ratio)), max(1, round(camera.height * ratio)))


def tone_for(radiance: npt.NDArray[np.floating], solid: Mask, current: Color) -> Color:
    """Return the tone of the backdrop before which the outline of the objects is visible.

    Parameters
    ----------
    radiance : (H, W, 3)
        Of a draft before a backdrop of radiance ``current``.
    solid : (H, W)
        Pixels of objects.
    """
    inside, outside = _beside(solid)
    if not len(inside):
        return current
    flat = radiance.reshape(-1, 3)
    within = lightness(tone(flat[inside]))
    shadow = flat[outside] / np.array(current)  # what shadows leave of the light on the ground
    differences = [float(np.median(np.abs(within - lightness(tone(shadow * np.array(color)))))) for color in TONES]
    enough = [color for color, difference in zip(TONES, differences, strict=True) if difference >= _ENOUGH]
    return enough[0] if enough else TONES[int(np.argmax(differences))]


def _beside(solid: Mask) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]:
    """Return the indices (N,) of pairs of pixels on both sides of the outline, along rows and columns."""
    index = np.arange(solid.size).reshape(solid.shape)
    inside, outside = [], []
    for pixels, which in ((index, solid), (index.T, solid.T)):
        for order in (1, -1):
            row, other = which[:, ::order], pixels[:, ::order]
            width = row.shape[1] - 2 * _REACH
            runs: list[Mask] = [row[:, k : k + width] for k in range(2 * _REACH + 1)]
            edge = np.logical_and.reduce(runs[: _REACH + 1]) & ~np.logical_or.reduce(runs[_REACH + 1 :])
            inside.append(other[:, :width][edge])
            outside.append(other[:, 2 * _REACH :][edge])
    return np.concatenate(inside), np.concatenate(outside)
