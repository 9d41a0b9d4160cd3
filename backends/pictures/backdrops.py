"""The tone of the backdrop: the one before which the outline of a scene is visible.

A backdrop as light as the objects before it hides their outline. So the tone is chosen by a small draft of what is
beside the outline, before each tone in turn: the first tone is taken whose lightness differs enough from that of the
objects, else the one that differs most. The light of the environment stays the same; a dark floor reflects less of it,
which is why each tone is tried.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
import numpy.typing as npt

from scenelang.backends.pictures.camera import Camera
from scenelang.backends.surfaces.appearance import Color
from scenelang.backends.surfaces.panoramas import LUMINANCE

FloatArray = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]

# Radiance of the tones in the order of preference: the light gray of a studio, a lighter one, slate, charcoal, gray,
# black. Other environments have the same shares of the radiance of their own backdrop.
TONES: tuple[Color, ...] = (
    (0.60, 0.61, 0.625), (0.93, 0.935, 0.945), (0.085, 0.088, 0.095), (0.030, 0.031, 0.034), (0.30, 0.31, 0.325),
    (0.006, 0.006, 0.007),
)  # fmt: skip
_MIN_MEDIAN_CONTRAST = (
    25.0  # median difference in L*: the eye sees 20 at a glance, and the small draft is off by up to 5
)
# Of the outline, 30 % may differ by less than 15: of an outline that is half clear and half not, as that of a board of
# light and dark squares, the median says little and is another one in final images.
_FAINT_SHARE, _MIN_FAINT_CONTRAST = 0.3, 15.0
_PROBE_SIDE = 480  # pixels of the longer side of the draft beside the outline; 240 pixels miss bright rims
_METER_SIDE = 240  # of the draft by which the exposure is chosen
_REACH = 2  # pixels from the outline at which lightness is compared
# The exposure by the scene gives its objects this luminance in the geometric mean: a little more than the 18 % of a
# gray card, because the tone curve keeps colors up to 70 %. It changes light by at most 2 ** 12.
_METERED, _MAX_STOPS = 0.25, 12.0
_BLACK = 1e-5  # luminance below which pixels do not count


def lightness(linear: npt.NDArray[np.floating]) -> FloatArray:
    """Return CIE L* (...) of linear sRGB (..., 3): 116 times the cube root of luminance minus 16, linear near black."""
    luminance = np.asarray(linear, np.float64) @ LUMINANCE
    return np.asarray(np.where(luminance > 0.008856, 116.0 * np.cbrt(luminance) - 16.0, 903.3 * luminance), np.float64)


def probing(camera: Camera) -> Camera:
    """Return the camera of the draft by which the tone is chosen."""
    return _at(camera, _PROBE_SIDE)


def metering(camera: Camera) -> Camera:
    """Return the camera of the draft by which the exposure is chosen."""
    return _at(camera, _METER_SIDE)


def _at(camera: Camera, side: int) -> Camera:
    """Return ``camera`` with ``side`` pixels along its longer side: one choice for all sizes of an image."""
    ratio = side / max(camera.width, camera.height)
    return camera.resized(max(1, round(camera.width * ratio)), max(1, round(camera.height * ratio)))


def backdrops(own: Sequence[float]) -> list[Color]:
    """Return the radiance of the tones for an environment with the backdrop ``own`` (3), which is the first of them."""
    shares = np.array(TONES) / np.array(TONES[0])
    return [(red, green, blue) for red, green, blue in (shares * np.array(own)).tolist()]


def clearest(sides: Iterable[tuple[FloatArray, FloatArray]]) -> int:
    """Return the number of the first backdrop before which the outline is visible, else of the clearest.

    ``sides`` are the lightness (N,) inside and outside of the outline before each backdrop; those after the chosen one
    are not asked for.
    """
    differences: list[float] = []
    for inside, outside in sides:
        steps = np.abs(inside - outside)
        faint, middle = np.quantile(steps, (_FAINT_SHARE, 0.5)).tolist()
        differences.append(middle)
        if middle >= _MIN_MEDIAN_CONTRAST and faint >= _MIN_FAINT_CONTRAST:
            return len(differences) - 1
    return int(np.argmax(differences))


def stops_for(radiance: npt.NDArray[np.floating], solid: Mask) -> float:
    """Return the stops by which an image must be brighter so that its objects are neither dark nor burnt out.

    ``radiance`` (H, W, 3) is that of the image without an exposure, ``solid`` (H, W) the pixels of objects.
    """
    luminance = (radiance[solid] if solid.any() else radiance.reshape(-1, 3)).astype(np.float64) @ LUMINANCE
    lit = luminance[luminance > _BLACK]
    if not len(lit):
        return 0.0
    return float(np.clip(np.log2(_METERED) - np.log2(lit).mean(), -_MAX_STOPS, _MAX_STOPS))


def beside(solid: Mask) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]:
    """Return the indices (N,) of pairs of pixels inside and outside of the outline of ``solid`` (H, W), along rows and
    columns."""
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


def lines_in(solid: Mask) -> Mask:
    """Return which pixels of ``solid`` (H, W) are of lines one pixel wide: nothing is on two opposite sides of them.

    >>> lines_in(np.array([[0, 0, 0], [1, 1, 1], [0, 0, 1]], bool)).tolist()[1]
    [True, True, False]
    """
    framed = np.pad(solid, 1, constant_values=True)  # beyond the image, objects go on
    across = framed[1:-1, :-2] | framed[1:-1, 2:]
    along = framed[:-2, 1:-1] | framed[2:, 1:-1]
    return np.asarray(solid & ~(across & along), bool)
