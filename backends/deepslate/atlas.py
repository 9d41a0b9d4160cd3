"""The textures of a build as one picture."""

from __future__ import annotations

import io
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.base import need
from scenelang.backends.picture import png_of
from scenelang.grammar.diagnostics import LimitError, SceneError

Pixels = npt.NDArray[np.uint8]  # (H, W, 4)
Place = tuple[int, int, int, int]

_LARGEST_SIDE = 4096  # of one texture, animations included
_LARGEST_FRAME = 1024
_LARGEST_ATLAS = 8192
_CLEAR, _SOLID = 26, 230  # alpha between them is that of stained glass, not of an edge
_FEW = 0.03  # the share of such pixels that makes a texture translucent


@dataclass(frozen=True, slots=True, eq=False)
class Atlas:
    """``png`` is square, its side a power of two. ``places``: left, top, right, bottom of each texture, in pixels.
    ``translucent`` are the names of those that one sees through."""

    png: bytes
    side: int
    places: Mapping[str, Place]
    translucent: frozenset[str]


def texture_from(png: bytes, name: str) -> Pixels:
    """The first frame of a texture, RGBA; raises SceneError("file") for what is no picture, or a huge one."""
    image_type = need("PIL.Image", "pillow")
    try:
        with image_type.open(io.BytesIO(png), formats=["PNG"]) as picture:
            width, height = picture.size
            if max(width, height) > _LARGEST_SIDE or width > _LARGEST_FRAME:
                raise SceneError("file", f"the texture `{name}` has {width} x {height} pixels, too many")
            pixels = np.asarray(picture.convert("RGBA"), np.uint8)
    except SceneError:
        raise
    except Exception as error:  # pillow raises many kinds for damaged files
        raise SceneError("file", f"the texture `{name}` is no picture: {error}") from None
    is_film = height > width and height % width == 0 and not name.startswith("minecraft:entity/")
    return pixels[:width] if is_film or height > _LARGEST_FRAME else pixels


def atlas_of(textures: Mapping[str, Pixels]) -> Atlas:
    """All ``textures`` in one picture; raises LimitError where they are too many for one."""
    order = sorted(textures, key=lambda name: (-textures[name].shape[0], name))
    side = _power_of_two(int(np.sqrt(sum(t.shape[0] * t.shape[1] for t in textures.values()) + 1.0)))
    side = max([side, *(_power_of_two(max(t.shape[:2])) for t in textures.values())])
    places = _shelved(textures, order, side)
    while places is None:
        side *= 2
        places = _shelved(textures, order, side)
    if side > _LARGEST_ATLAS:
        raise LimitError("size", f"the build's textures need more than {_LARGEST_ATLAS} x {_LARGEST_ATLAS} pixels")
    sheet = np.zeros((side, side, 4), np.uint8)
    for name, (left, top, right, bottom) in places.items():
        sheet[top:bottom, left:right] = textures[name]
    return Atlas(png_of(sheet), side, places, frozenset(_translucent(textures.items())))


def _shelved(textures: Mapping[str, Pixels], order: Iterable[str], side: int) -> dict[str, Place] | None:
    """Places in rows from the top, the highest textures first; None where they do not fit."""
    places: dict[str, Place] = {}
    x = y = row = 0
    for name in order:
        height, width = textures[name].shape[:2]
        if x + width > side:
            x, y, row = 0, y + row, 0
        row = max(row, height)
        if y + height > side:
            return None
        places[name] = (x, y, x + width, y + height)
        x += width
    return places


def _translucent(textures: Iterable[tuple[str, Any]]) -> Iterable[str]:
    for name, pixels in textures:
        alpha = pixels[:, :, 3]
        if ((alpha > _CLEAR) & (alpha < _SOLID)).mean() > _FEW:
            yield name


def _power_of_two(least: int) -> int:
    return 1 << max(4, (least - 1).bit_length())
