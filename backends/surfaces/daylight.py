"""Daylight: the sky and the sun of a clear day by the hour.

The sky is the analytic model of Preetham, Shirley and Smits (1999), whose luminance is that of Perez (1993); the sun is
dimmed and reddened by the air as in the same paper. The place is at 45 degrees north at an equinox: the sun rises at 6,
in the east (+x), is highest at 12, in the south (+z, behind a viewer), and sets at 18, in the west (-x).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from scenelang.backends.surfaces.dome import Panorama, direction_at, directions_of

FloatArray = npt.NDArray[np.float64]

SUNRISE, SUNSET = 6.0, 18.0
CLEAREST, HAZIEST = 2.0, 10.0  # turbidities for which the model holds
_LATITUDE = math.radians(45.0)
_SKY_ROWS = 128  # of the sky's image
_LOWEST = math.radians(1.5)  # of the sun: below, the model's zenith luminance is negative
# Coefficients by turbidity T, ``a T + b``: of luminance, and of the chromaticities x and y.
_PEREZ = np.array([
    [[0.1787, -1.4630], [-0.3554, 0.4275], [-0.0227, 5.3251], [0.1206, -2.5771], [-0.0670, 0.3703]],
    [[-0.0193, -0.2592], [-0.0665, 0.0008], [-0.0004, 0.2125], [-0.0641, -0.8989], [-0.0033, 0.0452]],
    [[-0.0167, -0.2608], [-0.0950, 0.0092], [-0.0079, 0.2102], [-0.0441, -1.6537], [-0.0109, 0.0529]],
])  # fmt: skip
# Chromaticities at the zenith: rows by T^2, T and 1, columns by the cube, square, first and zeroth power of the sun's
# angle from it.
_ZENITH_X = np.array([
    [0.00166, -0.00375, 0.00209, 0.0], [-0.02903, 0.06377, -0.03202, 0.00394], [0.11693, -0.21196, 0.06052, 0.25886],
])  # fmt: skip
_ZENITH_Y = np.array([
    [0.00275, -0.00610, 0.00317, 0.0], [-0.04214, 0.08970, -0.04153, 0.00516], [0.15346, -0.26756, 0.06670, 0.26688],
])  # fmt: skip
_TO_RGB = np.array([[3.2406, -1.5372, -0.4986], [-0.9689, 1.8758, 0.0415], [0.0557, -0.2040, 1.0570]])
_WAVELENGTHS = np.array([0.610, 0.550, 0.465])  # micrometers of red, green and blue
_SUN_LUX = 127.5  # kilolux of the sun above the air, on a surface that faces it


@dataclass(frozen=True, slots=True, eq=False)
class Daylight:
    """Sky and sun.

    Attributes
    ----------
    panorama
        Radiance of the sky in kcd/m^2.
    sun : (3,)
        Radiance of a white surface that faces the sun, from it alone, in the same unit.
    azimuth, elevation
        Of the sun in degrees.
    """

    panorama: Panorama
    sun: FloatArray
    azimuth: float
    elevation: float


def daylight(hour: float, haze: float) -> Daylight:
    """Return the light of a clear day.

    Parameters
    ----------
    hour
        Between ``SUNRISE`` and ``SUNSET``.
    haze
        Turbidity, from ``CLEAREST`` to ``HAZIEST``: 2 is very clear, 3 clear, 6 hazy.
    """
    turn = (hour - 12.0) / 12.0 * math.pi
    elevation = max(math.asin(math.cos(_LATITUDE) * math.cos(turn)), _LOWEST)
    azimuth = math.atan2(-math.sin(turn), math.sin(_LATITUDE) * math.cos(turn))
    sky = _sky(directions_of(_SKY_ROWS).reshape(-1, 3), direction_at(azimuth, elevation), haze).reshape(
        _SKY_ROWS, 2 * _SKY_ROWS, 3
    )
    return Daylight(Panorama(sky), _sun(elevation, haze), math.degrees(azimuth), math.degrees(elevation))


def _sky(directions: FloatArray, sun: FloatArray, haze: float) -> FloatArray:
    """Return the radiance (N, 3) of the sky; below the horizon it is half of that at the horizon."""
    angle = math.acos(float(sun[1]))
    powers = np.array([angle**3, angle**2, angle, 1.0])
    turbidity = np.array([haze * haze, haze, 1.0])
    chi = (4.0 / 9.0 - haze / 120.0) * (math.pi - 2.0 * angle)
    zenith = (
        (4.0453 * haze - 4.9710) * math.tan(chi) - 0.2155 * haze + 2.4192,
        float(turbidity @ _ZENITH_X @ powers),
        float(turbidity @ _ZENITH_Y @ powers),
    )
    height = np.maximum(np.abs(directions[:, 1]), 0.01)
    level = directions * [1.0, 0.0, 1.0] + np.stack([np.zeros(len(height)), height, np.zeros(len(height))], axis=1)
    level /= np.linalg.norm(level, axis=1, keepdims=True)
    between = np.arccos(np.clip(level @ sun, -1.0, 1.0))
    luminance, x, y = (
        at * _perez(coefficients @ [haze, 1.0], height, between) / _perez(coefficients @ [haze, 1.0], 1.0, angle)
        for at, coefficients in zip(zenith, _PEREZ, strict=True)
    )
    xyz = np.stack([x / y * luminance, luminance, (1.0 - x - y) / y * luminance], axis=1)
    radiance = np.maximum(xyz @ _TO_RGB.T, 0.0)
    return np.asarray(radiance * np.where(directions[:, 1:2] < 0.0, 0.5, 1.0), np.float64)


def _perez(c: FloatArray, height: FloatArray | float, between: FloatArray | float) -> FloatArray:
    """Return the luminance of the sky at the cosine ``height`` from the zenith, at an angle from the sun."""
    a, b, c_, d, e = c
    gradient = 1.0 + a * np.exp(b / height)
    return np.asarray(gradient * (1.0 + c_ * np.exp(d * np.asarray(between)) + e * np.cos(between) ** 2), np.float64)


def _sun(elevation: float, haze: float) -> FloatArray:
    """Return the radiance (3,) of a white surface that faces the sun: what the air lets pass."""
    degrees = 90.0 - math.degrees(elevation)
    mass = 1.0 / (math.sin(elevation) + 0.15 * max(93.885 - degrees, 0.1) ** -1.253)
    molecules = np.exp(-0.008735 * _WAVELENGTHS**-4.08 * mass)
    aerosols = np.exp(-(0.04608 * haze - 0.04586) * _WAVELENGTHS**-1.3 * mass)
    ozone = np.exp(-np.array([0.022, 0.032, 0.003]) * mass)
    return np.asarray(_SUN_LUX / math.pi * molecules * aerosols * ozone, np.float64)
