"""The tone curve AgX (T. Sobotka), in the version of E. Zhou that Blender has, which is a table of three dimensions.

The table is made here, by the published steps: what is outside of a gamut is brought into it at its luminance ("guard
rail"), an inset moves the primaries together, a sigmoid bends the logarithm of each channel, the hue is mixed from
those before and after it, and an outset moves the primaries apart again.

The image formation alone is not enough: of saturated colors, whose channels end at 0, Blender shows what lies between
two nodes of the table, up to 23 of 255 levels away. With the same nodes and the same interpolation, of 20,000 random
colors from 2^-6 to 2^6 half differ by less than .01 levels from Blender 5.0.1, 99 % by less than 3, and all by 6; of
grays all by .02.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]

# Chromaticities of primaries, and of the white point D65.
_WHITE = (0.3127, 0.3290)
_SRGB = ((0.64, 0.33), (0.30, 0.60), (0.15, 0.06))
_REC2020 = ((0.708, 0.292), (0.170, 0.797), (0.131, 0.046))
_E_GAMUT = ((0.8, 0.3177), (0.18, 0.9), (0.065, -0.0805))  # of FilmLight, whose logarithm the table expects
# Of the primaries of Rec.2020: attenuations of .4, .22 and .13, turns of 3, -1 and -2 degrees; and those of the outset.
_INSET = np.array([
    [0.856627153315983, 0.0951212405381588, 0.0482516061458583],
    [0.137318972929847, 0.761241990602591, 0.101439036467562],
    [0.11189821299995, 0.0767994186031903, 0.811302368396859],
])  # fmt: skip
_OUTSET = np.array([
    [1.1271005818144368, -0.11060664309660323, -0.016493938717834573],
    [-0.1413297634984383, 1.157823702216272, -0.016493938717834257],
    [-0.14132976349843826, -0.11060664309660294, 1.2519364065950405],
])  # fmt: skip

_NODES = 57  # of the table along each axis
_LOG_RANGE = -12.47393, 12.5260688117  # base-2 logarithms of the first and last node
_GRAY = 0.18  # middle gray, which the sigmoid keeps
_STOPS = -10.0, 6.5  # from middle gray, that the sigmoid spans
_SLOPE, _POWER = 2.4, 1.5  # of the sigmoid at middle gray, and of its toe and shoulder
_GAMMA = 2.4  # of the encoding that the table has
_HUE_KEPT = 0.6  # of the hue before the sigmoid; the rest is that of its channels
_CHUNK = 200_000  # colors mapped at once, which bounds the memory


def agx(linear: npt.NDArray[np.floating]) -> FloatArray:
    """Map linear sRGB radiance (..., 3) to linear sRGB in [0, 1] as Blender's view transform AgX does.

    Examples
    --------
    >>> agx(np.array([0.18, 0.18, 0.18])).round(3)
    array([0.18, 0.18, 0.18])
    """
    colors = np.asarray(linear, np.float64).reshape(-1, 3)
    unknown = np.asarray(np.isnan(colors).any(axis=1), bool)
    if unknown.any():
        colors = np.where(unknown[:, None], 0.0, colors)
    shown = [_between_nodes(colors[i : i + _CHUNK]) for i in range(0, len(colors), _CHUNK)]
    result = np.concatenate([np.zeros((0, 3)), *shown])
    result[unknown] = np.nan
    return result.reshape(np.shape(linear))


def _between_nodes(colors: FloatArray) -> FloatArray:
    """Return linear colors (N, 3) in [0, 1] by tetrahedral interpolation of the table.

    Each color is a sum of four nodes of its cell, along a path on which its largest share steps first.
    """
    first, last = _LOG_RANGE
    logs = np.log2(np.maximum(colors @ _conversion(_SRGB, _E_GAMUT).T, 2.0**first))
    place = np.clip((logs - first) / (last - first), 0.0, 1.0) * (_NODES - 1)
    cell = np.minimum(place.astype(np.int64), _NODES - 2)
    share = place - cell
    axes = np.argsort(-share, axis=1)
    weights = np.diff(np.take_along_axis(share, axes, axis=1), axis=1, prepend=1.0, append=0.0)
    strides = np.array([_NODES * _NODES, _NODES, 1])
    corners = np.concatenate([np.zeros((len(colors), 1), np.int64), strides[axes]], axis=1).cumsum(axis=1)
    nodes = _table()[(cell @ strides)[:, None] + corners]
    return np.asarray(np.einsum("nk,nkc->nc", -weights, nodes) ** _GAMMA, np.float64)


@lru_cache(maxsize=1)
def _table() -> FloatArray:
    """Return the encoded colors (N, 3) at the nodes of the table, the last axis fastest."""
    steps = np.exp2(np.linspace(*_LOG_RANGE, _NODES))
    nodes = np.stack(np.meshgrid(steps, steps, steps, indexing="ij"), axis=-1).reshape(-1, 3)
    colors = _into_gamut(nodes @ _conversion(_E_GAMUT, _REC2020).T, _luminance(_REC2020)) @ _INSET.T
    formed = _sigmoid(colors) ** _GAMMA
    formed = _with_hue(formed, _hue(colors)) @ (_conversion(_REC2020, _SRGB) @ _OUTSET).T
    table = np.clip(_into_gamut(formed, _luminance(_SRGB)), 0.0, 1.0) ** (1.0 / _GAMMA)
    table.flags.writeable = False  # it is shared by all images
    return np.asarray(table, np.float64)


def _sigmoid(colors: FloatArray) -> FloatArray:
    """Return encoded channels (N, 3) in [0, 1]: a line through middle gray that bends towards 0 and 1."""
    low, high = _STOPS
    pivot, gray = -low / (high - low), _GRAY ** (1.0 / _GAMMA)
    x = np.clip((np.log2(np.maximum(colors, 1e-12) / _GRAY) - low) / (high - low), 0.0, 1.0)
    shoulder, toe = _bend(1.0 - pivot, 1.0 - gray), _bend(pivot, gray)
    over, under = _SLOPE * np.maximum(x - pivot, 0.0) / shoulder, _SLOPE * np.maximum(pivot - x, 0.0) / toe
    rise = shoulder * over * (1.0 + over**_POWER) ** (-1.0 / _POWER)
    fall = toe * under * (1.0 + under**_POWER) ** (-1.0 / _POWER)
    return np.asarray(np.clip(gray + rise - fall, 0.0, 1.0), np.float64)


def _bend(run: float, rise: float) -> float:
    """Return the scale at which a hyperbola of the slope at the origin passes through a point."""
    slope: float = ((_SLOPE * run / rise) ** _POWER - 1.0) ** (1.0 / _POWER)
    return _SLOPE * run / slope


def _into_gamut(colors: FloatArray, luminance: FloatArray) -> FloatArray:
    """Return colors (N, 3) without negative channels, of at most the luminance that they had.

    Luminances are those of the color and of what its opponent lacks, since the luminance of a color with negative
    channels alone is no measure of its brightness.
    """
    raised = colors + np.maximum(-colors.min(axis=1, keepdims=True), 0.0)
    before, after = (_brightness(each, luminance) for each in (colors, raised))
    ratio = np.where(after > before, before / np.maximum(after, 1e-12), 1.0)
    return np.asarray(np.maximum(raised * ratio[:, None], 0.0), np.float64)


def _brightness(colors: FloatArray, luminance: FloatArray) -> FloatArray:
    """Return the luminances (N,) of colors, compensated by those of their opponents."""
    opponent = colors.max(axis=1, keepdims=True) - colors
    return np.asarray(colors @ luminance + opponent.max(axis=1) - opponent @ luminance, np.float64)


def _hue(colors: FloatArray) -> FloatArray:
    """Return the hues (N,) of colors, from 0 to 1."""
    red, green, blue = colors.T
    most, least = colors.max(axis=1), colors.min(axis=1)
    spread = np.where(most > least, most - least, 1.0)
    later = np.where(most == green, (blue - red) / spread + 2.0, (red - green) / spread + 4.0)
    sector = np.where(most == red, (green - blue) / spread, later)
    return np.asarray(sector / 6.0 % 1.0, np.float64)


def _with_hue(colors: FloatArray, hue: FloatArray) -> FloatArray:
    """Return colors (N, 3) of the same value and saturation, turned most of the way to other hues."""
    own = _hue(colors)
    turned = own + _HUE_KEPT * ((hue - own + 0.5) % 1.0 - 0.5)
    most, least = colors.max(axis=1), colors.min(axis=1)
    sector = (np.array([5.0, 3.0, 1.0]) + 6.0 * turned[:, None]) % 6.0
    wave = np.clip(np.minimum(sector, 4.0 - sector), 0.0, 1.0)
    return np.asarray(most[:, None] - (most - least)[:, None] * wave, np.float64)


Primaries = tuple[tuple[float, float], ...]


def _to_xyz(primaries: Primaries) -> FloatArray:
    """Return the matrix (3, 3) from linear colors of some primaries to CIE XYZ, white at Y = 1."""
    columns = np.array([(x / y, 1.0, (1.0 - x - y) / y) for x, y in (*primaries, _WHITE)]).T
    return np.asarray(columns[:, :3] * np.linalg.solve(columns[:, :3], columns[:, 3]), np.float64)


def _conversion(source: Primaries, target: Primaries) -> FloatArray:
    """Return the matrix (3, 3) that converts linear colors between primaries."""
    return np.asarray(np.linalg.solve(_to_xyz(target), _to_xyz(source)), np.float64)


def _luminance(primaries: Primaries) -> FloatArray:
    """Return the luminances (3,) of primaries."""
    return np.asarray(_to_xyz(primaries)[1], np.float64)
