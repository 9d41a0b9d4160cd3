"""The light, the ground and the film that draft and final pictures share, so that they agree.

A uniform surrounding radiance ``AMBIENT``, a soft key light, and a ground whose reflectance is such that, where nothing
shades it, it has exactly the radiance of the ``BACKDROP`` that the camera sees behind everything. So there is no
horizon and nothing to fade. Radiance is linear sRGB; a white surface facing the key light is just below white.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from scenelang.backends.camera import View

FloatArray = npt.NDArray[np.float64]
AnyFloats = npt.NDArray[np.floating]

BACKDROP = (0.60, 0.61, 0.625)
AMBIENT = (0.42, 0.43, 0.445)
KEY = (0.76, 0.73, 0.68)  # radiance of a white surface that faces the key light, from that light alone
KEY_RADIUS = math.radians(5.0)  # half the angle under which the key light is seen
BRIGHTEST = 0.92  # no surface reflects all light
GROUND_EDGE = 5e4  # how far the ground reaches, where the scene's half diagonal is 1
_KEY_TURN = math.radians(-72.0)  # the key light stands left of the camera ...
_KEY_HEIGHT = math.radians(50.0)  # ... and above
_SHOULDER = 0.7


@dataclass(frozen=True, slots=True, eq=False)
class Studio:
    """``key_direction`` (3,): unit, from the scene to the key light. ``ground`` (3,): the ground's reflectance."""

    key_direction: FloatArray
    ground: FloatArray


def studio_for(view: View) -> Studio:
    """The studio whose key light stands beside the camera of ``view``, above the scene."""
    turn = math.atan2(-view.right[2], view.right[0]) + _KEY_TURN
    flat = math.cos(_KEY_HEIGHT)
    direction = np.array([math.sin(turn) * flat, math.sin(_KEY_HEIGHT), math.cos(turn) * flat])
    return Studio(direction, np.array(BACKDROP) / (np.array(AMBIENT) + np.array(KEY) * direction[1]))


def tone(linear: AnyFloats) -> AnyFloats:
    """Linear radiance to [0, 1): the identity up to 0.7, then a soft shoulder instead of clipping."""
    room = 1.0 - _SHOULDER
    over = np.maximum(linear - _SHOULDER, 0.0)
    return np.where(linear <= _SHOULDER, np.maximum(linear, 0.0), 1.0 - room * np.exp(-over / room))


def encode(linear: AnyFloats) -> npt.NDArray[np.uint8]:
    """Linear sRGB in [0, 1] to 8-bit sRGB of the same shape."""
    return np.asarray(np.rint(to_srgb(linear) * 255.0), np.uint8)


def to_srgb(linear: AnyFloats) -> AnyFloats:
    """Linear sRGB to sRGB, both in [0, 1]."""
    x = np.clip(linear, 0.0, 1.0)
    return np.where(x <= 0.0031308, 12.92 * x, 1.055 * np.power(np.maximum(x, 0.0031308), 1.0 / 2.4) - 0.055)


def from_srgb(encoded: AnyFloats) -> AnyFloats:
    """sRGB to linear sRGB, both in [0, 1]."""
    x = np.clip(encoded, 0.0, 1.0)
    return np.where(x <= 0.04045, x / 12.92, ((x + 0.055) / 1.055) ** 2.4)
