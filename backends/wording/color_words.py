"""From a colour to the word for it: the nearest of the named ones, as people see it.

Scenes hold linear light, and pictures show it encoded: the word is for what a person sees in them, so [.5 .5 .5] is a
light grey (docs/decisions.md). Distances are those of Oklab, in which equal steps look equally large.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from functools import cache
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.studio import from_srgb
from scenelang.backends.wording.color_names import color_names
from scenelang.stdlib.colors import named_colors

FloatArray = npt.NDArray[np.float64]

_CHUNK = 4096  # colours compared at once, so that memory stays small
# Oklab (Ottosson 2020): linear sRGB to the responses of the cones, their cube roots to lightness and two opponents.
_CONES = np.array([
    [0.4122214708, 0.5363325363, 0.0514459929],
    [0.2119034982, 0.6806995451, 0.1073969566],
    [0.0883024619, 0.2817188376, 0.6299787005],
])  # fmt: skip
_OPPONENTS = np.array([
    [0.2104542553, 0.7936177850, -0.0040720468],
    [1.9779984951, -2.4285922050, 0.4505937099],
    [0.0259040371, 0.7827717662, -0.8086757660],
])  # fmt: skip


def oklab(linear: npt.ArrayLike) -> FloatArray:
    """Linear sRGB (..., 3) as lightness and two opponent axes (..., 3)."""
    cones = np.asarray(linear, np.float64) @ _CONES.T
    return np.asarray(np.cbrt(cones) @ _OPPONENTS.T, np.float64)


@cache
def named_points() -> tuple[tuple[str, ...], FloatArray]:
    """K names and their points in Oklab (K, 3)."""
    rows = color_names()
    encoded = np.array([[int(digits[at : at + 2], 16) for at in (0, 2, 4)] for _, digits in rows]) / 255.0
    points = oklab(from_srgb(encoded))
    points.setflags(write=False)
    return tuple(name for name, _ in rows), points


def color_words(colors: Sequence[Any] | FloatArray) -> list[str]:
    """The words for N colours (N, 3), linear sRGB; what lies outside 0 to 1 is clipped."""
    names, points = named_points()
    seen = oklab(np.clip(np.asarray(colors, np.float64).reshape(-1, 3), 0.0, 1.0))
    found: list[str] = []
    for start in range(0, len(seen), _CHUNK):
        steps = seen[start : start + _CHUNK, None, :] - points
        found += [names[i] for i in np.einsum("nkc,nkc->nk", steps, steps).argmin(axis=1).tolist()]
    return found


def names_color(text: str) -> bool:
    """Whether a text says what colour something has: a name of the table or of CSS is in it."""
    return _anywhere().search(text.lower()) is not None


@cache
def _anywhere() -> re.Pattern[str]:
    names = {name for name, _ in color_names()} | set(named_colors()) | {"gray", "golden", "colourful", "colorful"}
    return re.compile(rf"\b(?:{'|'.join(map(re.escape, sorted(names, key=len, reverse=True)))})(?:d?ish)?\b")
