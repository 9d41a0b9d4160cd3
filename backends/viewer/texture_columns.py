"""Textures for the page: each distinct image once, and for each primitive where its surface shows it.

The page evaluates ``surfaces/tiles.coordinates`` at each pixel, in the frame of the primitive.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.surfaces.appearance import Look
from scenelang.backends.surfaces.image_files import encode
from scenelang.backends.surfaces.tiles import Tile, around_of, middle_of, period_of, pictured, relief_of, tile_of
from scenelang.interpreter.scene.primitives.textures import PROJECTIONS, SIDES, Texture

FloatArray = npt.NDArray[np.float64]

FLOATS = 24  # of a primitive: six texels
_LARGEST = 512  # pixels per side
_MOST = 256  # images, as many as every WebGL 2 holds in one array
_MOST_PIXELS = 16 * _LARGEST**2  # of all images


def texture_columns(looks: Sequence[Look], local: FloatArray) -> tuple[int, dict[str, npt.NDArray[Any]]]:
    """Return the side of the images in pixels and the columns of textures; nothing for looks without textures.

    ``textureImages`` holds 8-bit sRGB squares, row 0 at v = 1. ``primitiveTexture`` has 24 floats for each primitive:
    the number of the image (-1: none) and of the projection in ``PROJECTIONS``, or after these of the side of a decal
    in ``SIDES``, width and height of the period; cosine and sine of the turn, the coordinates of the primitive's
    center, the length of a radian; the pose (3, 4) from the frame of the geometry to that of the primitive, row by row;
    the number of the image of the relief (-1: none) and its depth, and the displacement of a decal. Images beyond
    ``_MOST`` are left out: what has them shows its mean color, without a relief.

    Parameters
    ----------
    local : (P, 3, 4)
        Poses of the geometries in the frames of their primitives.
    """
    textures = [look.texture for look in looks]
    if not any(textures):
        return 0, {}
    numbers: dict[tuple[Texture, bool], int] = {}
    table = np.zeros((len(looks), FLOATS), np.float32)
    table[:, 0] = table[:, 20] = -1.0

    def image(texture: Texture, is_relief: bool) -> int:
        """Return the number of an image, or -1 if there are too many."""
        number = numbers.setdefault((pictured(texture), is_relief), len(numbers))
        return number if number < _MOST else -1

    for row, texture, pose in zip(table, textures, local, strict=True):
        if texture is None:
            continue
        turn, (width, height) = math.radians(texture.turn), period_of(texture)
        row[:4] = image(texture, False), _projection(texture), width, height
        row[4:8] = math.cos(turn), math.sin(turn), middle_of(texture), around_of(texture)
        row[8:20] = pose.reshape(12)
        row[20:] = image(texture, True) if texture.bump else -1, texture.depth, *texture.at
    tiles = [relief_of(texture) if is_relief else tile_of(texture) for texture, is_relief in list(numbers)[:_MOST]]
    side = _side(tiles)
    images = np.concatenate([_square(tile, side).reshape(-1) for tile in tiles])
    return side, {"textureImages": images, "primitiveTexture": table.reshape(-1)}


def _projection(texture: Texture) -> int:
    """Return the number of a texture's projection, or of the side that has it."""
    if texture.side:
        return len(PROJECTIONS) + list(SIDES).index(texture.side)
    return list(PROJECTIONS).index(texture.projection)


def _side(tiles: Sequence[Tile]) -> int:
    """Return the side of all images: that of the largest, but less if there are many."""
    side: int = min(_LARGEST, max(max(tile.image.shape[:2]) for tile in tiles))
    while side > 1 and side * side * len(tiles) > _MOST_PIXELS:
        side //= 2
    return side


def _square(tile: Tile, side: int) -> npt.NDArray[np.uint8]:
    """Return one period as a square image (S, S, 3), sampled as drafts do."""
    if tile.image.shape[:2] == (side, side):
        return encode(tile.image)
    row, column = np.divmod(np.arange(side * side), side)
    uv = np.stack([(column + 0.5) / side, 1.0 - (row + 0.5) / side], axis=1)
    return encode(tile.at(uv, np.full(len(uv), 1.0 / side)))
