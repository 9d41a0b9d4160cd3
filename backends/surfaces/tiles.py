"""Textures as images of one period, and the coordinates at which surfaces show them.

A pattern is drawn once as an image that repeats without seams; every backend shows this image, so that a texture is the
same in drafts, final images, the viewer and files. Texture coordinates are those of glTF turned upside down: u to the
right and v upwards, one unit a period, row 0 of the image at v = 1.
"""

from __future__ import annotations

import io
import math
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from types import MappingProxyType

import numpy as np
import numpy.typing as npt

from scenelang.backends.base import require
from scenelang.backends.surfaces.image_files import checked_image, encode, linear_pixels
from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.scene.primitives.textures import PATTERNS, SIDES, Color, Texture

FloatArray = npt.NDArray[np.float64]
Float32Array = npt.NDArray[np.float32]
IntArray = npt.NDArray[np.int64]

# Pixels per side of a pattern's image; fewer in a browser, where arrays are plain Python.
_SIZE = 128 if sys.platform == "emscripten" else 512
_JOINT = 0.055  # width of mortar and joints, relative to `:scale`
_CACHED_IMAGES = 16  # of textures, that stay in memory
_MARGIN = 0.125  # of the surface's color on each side of a decal, as shares of its image with them
_TURNED_AWAY = 0.05  # cosine between a normal and the side of a decal up to which a surface does not show it
_ON_AXIS = 1e-6  # share of the largest distance from the axis within which a point has no angle of its own


@dataclass(frozen=True, slots=True, eq=False)
class Tile:
    """One period of a texture.

    Attributes
    ----------
    levels
        Linear sRGB images (H, W, 3), each half as large as the one before, down to one pixel.
    size
        Width and height of the period in units of ``Texture.scale``.
    repeats
        Whether the image repeats; that of a decal has a margin of the surface's color, which continues beyond.
    """

    levels: tuple[Float32Array, ...]
    size: tuple[float, float]
    repeats: bool = True

    @property
    def image(self) -> Float32Array:
        """The image at full resolution."""
        return self.levels[0]

    @property
    def mean(self) -> Color:
        """Mean color; of a decal that of the surface, most of which does not show it."""
        shown = self.levels[-1] if self.repeats else self.image[:1, :1]
        red, green, blue = shown.reshape(-1, 3).mean(axis=0).tolist()
        return (red, green, blue)

    def png(self) -> bytes:
        """Return the image at full resolution as a PNG file."""
        return _png(encode(self.image))

    def at(self, uv: FloatArray, footprint: FloatArray) -> Float32Array:
        """Return the colors (N, 3) at coordinates ``uv`` (N, 2), averaged over squares of side ``footprint`` (N,).

        Both are in periods. Between the two nearest levels and their four nearest pixels the colors are interpolated.
        """
        height, width = self.image.shape[:2]
        if not self.repeats:
            uv = np.clip(uv, 0.5 / max(height, width), 1.0 - 0.5 / max(height, width))
        pixels = np.maximum(footprint * math.sqrt(width * height), 1.0)
        level = np.clip(np.log2(pixels), 0.0, len(self.levels) - 1.0)
        below = np.minimum(level.astype(np.int64), max(0, len(self.levels) - 2))
        out = np.empty((len(uv), 3), np.float32)
        for number in np.unique(below).tolist():
            rows = np.flatnonzero(below == number)
            share = (level[rows] - number).astype(np.float32)[:, None]
            fine = _bilinear(self.levels[number], uv[rows])
            coarse = _bilinear(self.levels[min(number + 1, len(self.levels) - 1)], uv[rows])
            out[rows] = fine + (coarse - fine) * share
        return out


def _png(pixels: npt.NDArray[np.uint8]) -> bytes:
    """Return an image (H, W, 3) as a PNG file."""
    data = io.BytesIO()
    require("PIL.Image", "pillow").fromarray(pixels).save(data, "PNG")
    return data.getvalue()


def _bilinear(image: Float32Array, uv: FloatArray) -> Float32Array:
    """Return the colors (N, 3) of a repeating image at ``uv`` (N, 2)."""
    height, width = image.shape[:2]
    x, y = (uv[:, 0] % 1.0) * width - 0.5, (1.0 - uv[:, 1] % 1.0) * height - 0.5
    left, top = np.floor(x).astype(np.int64), np.floor(y).astype(np.int64)
    fx, fy = (x - left).astype(np.float32)[:, None], (y - top).astype(np.float32)[:, None]
    flat = image.reshape(-1, 3)
    first, second, upper, lower = left % width, (left + 1) % width, top % height * width, (top + 1) % height * width
    one = flat[upper + first] * (1 - fx) + flat[upper + second] * fx
    other = flat[lower + first] * (1 - fx) + flat[lower + second] * fx
    return np.asarray(one + (other - one) * fy, np.float32)


def tile_of(texture: Texture) -> Tile:
    """Return one period of a texture whose colors are given; raises SceneError("file") for an image that is lost."""
    return _tile(pictured(texture))


def pictured(texture: Texture) -> Texture:
    """Return a texture without what does not change its image: textures of one image are equal."""
    side = next(iter(SIDES)) if texture.side else ""
    return replace(texture, scale=None, turn=0.0, projection="box", side=side, at=(0.0, 0.0), bump=0.0)


def relief_of(texture: Texture) -> Tile:
    """Return the heights of a texture's relief, the same in all channels: 1 where its first color is, or white in an
    image, and 0 for the second, or black.

    Its edges are bevels: steps would be thinner than pixels, and none would show them.
    """
    return _relief(replace(pictured(texture), colors=((1.0, 1.0, 1.0),) if texture.is_image else _HEIGHTS))


@lru_cache(maxsize=_CACHED_IMAGES)
def _relief(texture: Texture) -> Tile:
    """Return the relief of a texture that is ``pictured`` in black and white."""
    tile = _tile(texture)
    heights = tile.image.mean(axis=2)
    reach = max(1, round(_BEVEL * max(heights.shape)))
    for axis in (0, 0, 1, 1):  # two boxes of one width are a slope
        heights = sum(np.roll(heights, shift, axis) for shift in range(-reach, reach + 1)) / (2 * reach + 1)
    return replace(tile, levels=_levels(np.repeat(heights[:, :, None], 3, axis=2)))


def normals_png(texture: Texture) -> bytes:
    """Return the normals of a relief as a PNG file: x along u, y along v and z outwards, from -1 to 1 as 0 to 255.

    Slopes are lengths divided by lengths, so that the file serves every size of the surface.
    """
    tile = relief_of(texture)
    heights, (width, height) = tile.image[:, :, 0], tile.size
    across = (np.roll(heights, -1, 1) - np.roll(heights, 1, 1)) * (heights.shape[1] / (2.0 * width))
    upwards = (np.roll(heights, 1, 0) - np.roll(heights, -1, 0)) * (heights.shape[0] / (2.0 * height))
    normals = np.dstack([-texture.bump * across, -texture.bump * upwards, np.ones_like(heights)])
    normals /= np.linalg.norm(normals, axis=2)[:, :, None]
    return _png(np.rint((0.5 + 0.5 * normals) * 255.0).astype(np.uint8))


_HEIGHTS: tuple[Color, ...] = ((1.0, 1.0, 1.0), (0.0, 0.0, 0.0))
_BEVEL = 1.0 / 256.0  # half the width of the boxes that blur the heights, as a share of the image's longer side


@lru_cache(maxsize=_CACHED_IMAGES)
def _tile(texture: Texture) -> Tile:
    """Return the period of a texture that is ``pictured``."""
    if texture.side:
        return _decal(texture)
    if texture.is_image:
        image = _image_of(texture)
        if texture.colors:
            image = image * np.array(texture.colors[0], np.float32)
        return Tile(_levels(image), (1.0, len(image) / image.shape[1]))
    draw, size = _PATTERNS[texture.name]
    colors = np.array(texture.colors or PATTERNS[texture.name].colors, np.float32)
    centers = (np.arange(_SIZE) + 0.5) / _SIZE
    u, v = np.meshgrid(centers, centers)
    return Tile(_levels(draw(texture, u, 1.0 - v, colors)), size)


def _decal(texture: Texture) -> Tile:
    """Return an image or a text within a margin of the surface's color, which is the first of its colors."""
    around = texture.colors[0] if texture.colors else (1.0, 1.0, 1.0)
    if texture.is_image:
        image = _image_of(texture, around)
    else:
        image = _tile(replace(texture, side="")).image
    height, width = image.shape[:2]
    margin = max(1, math.ceil(max(height, width) * _MARGIN / (1.0 - 2.0 * _MARGIN)))
    framed = np.empty((height + 2 * margin, width + 2 * margin, 3), np.float32)
    framed[:] = around
    framed[margin:-margin, margin:-margin] = image
    return Tile(_levels(framed), (framed.shape[1] / width, framed.shape[0] / width), repeats=False)


def _image_of(texture: Texture, behind: Color = (1.0, 1.0, 1.0)) -> Float32Array:
    """Return the linear sRGB (H, W, 3) of a texture's image; transparent pixels have the color ``behind``."""
    if texture.source is not None:
        from scenelang.backends.surfaces.assets import load_asset

        folder, number = texture.source
        return load_asset(texture.name, folder).images[number]
    return linear_pixels(checked_image(Path(texture.name), texture.name), behind)  # says if Pillow is missing


def _levels(image: npt.NDArray[np.floating]) -> tuple[Float32Array, ...]:
    """Return an image and its reductions by halves."""
    levels = [np.asarray(image, np.float32)]
    while max(levels[-1].shape[:2]) > 1:
        last = levels[-1]
        rows, columns = (max(1, side // 2) for side in last.shape[:2])
        down = [np.arange(count) * side // count for side, count in zip(last.shape, (rows, columns), strict=False)]
        counts = [np.diff(np.append(starts, side)) for starts, side in zip(down, last.shape, strict=False)]
        summed = np.add.reduceat(np.add.reduceat(last, down[0], 0), down[1], 1)
        levels.append((summed / (counts[0][:, None, None] * counts[1][None, :, None])).astype(np.float32))
    return tuple(levels)


# --- patterns: images (H, W, 3) of one period, u and v (H, W) from 0 to 1 ------------------------------------------

Draw = Callable[[Texture, FloatArray, FloatArray, Float32Array], FloatArray]


def _mixed(colors: Float32Array, share: FloatArray) -> FloatArray:
    """Return the mixture (H, W, 3) of two colors by the ``share`` (H, W) of the second."""
    return np.asarray(colors[0] + (colors[1] - colors[0]) * share[:, :, None], np.float64)


def _checker(texture: Texture, u: FloatArray, v: FloatArray, colors: Float32Array) -> FloatArray:
    return _mixed(colors, ((u < 0.5) != (v < 0.5)).astype(float))


def _stripes(texture: Texture, u: FloatArray, v: FloatArray, colors: Float32Array) -> FloatArray:
    return _mixed(colors, (v >= 0.5).astype(float))


def _joints(x: FloatArray, width: float) -> FloatArray:
    """Return 1 within ``width`` of the whole numbers of ``x``, 0 elsewhere, with soft edges."""
    away = np.abs(x - np.round(x))
    return np.clip((0.5 * width - away) / (0.15 * width) + 0.5, 0.0, 1.0)


def _tones(column: FloatArray, row: FloatArray, strength: float) -> FloatArray:
    """Return factors around 1 (H, W) that are constant in a cell of integer ``column`` and ``row`` and vary by cell."""
    mixed = np.sin(column * 127.1 + row * 311.7 + 3.1) * 43758.5453
    return np.asarray(1.0 + strength * (2.0 * (mixed - np.floor(mixed)) - 1.0), np.float64)


def _brick(texture: Texture, u: FloatArray, v: FloatArray, colors: Float32Array) -> FloatArray:
    """Eight courses of four bricks, each course shifted by half a brick."""
    course = np.floor(v * 8.0)
    along = u * 4.0 + 0.5 * (course % 2.0)
    mortar = np.maximum(_joints(along, _JOINT), _joints(v * 8.0, 3.0 * _JOINT))
    grain = 1.0 + 0.10 * (_clouds(u, v, 64, 3) - 0.5)
    base = colors[0] * (_tones(np.floor(along) % 4.0, course, 0.22) * grain)[:, :, None]
    return np.asarray(base + (colors[1] - base) * mortar[:, :, None], np.float64)


def _tiles(texture: Texture, u: FloatArray, v: FloatArray, colors: Float32Array) -> FloatArray:
    joint = np.maximum(_joints(u * 4.0, _JOINT), _joints(v * 4.0, _JOINT))
    base = colors[0] * _tones(np.floor(u * 4.0), np.floor(v * 4.0), 0.05)[:, :, None]
    return np.asarray(base + (colors[1] - base) * joint[:, :, None], np.float64)


def _planks(texture: Texture, u: FloatArray, v: FloatArray, colors: Float32Array) -> FloatArray:
    """Four boards, each shifted along and of its own tone, with grain."""
    board = np.floor(v * 4.0)
    along = u * 2.0 + board * 0.37 + 0.2 * (board % 2.0)
    joint = np.maximum(_joints(v * 4.0, 0.5 * _JOINT), _joints(along, 0.1 * _JOINT))
    grain = 1.0 + 0.5 * (_clouds(u, v, 4, 4, stretch=16) - 0.5)
    base = colors[0] * (_tones(np.floor(along) % 2.0, board, 0.18) * grain)[:, :, None]
    return np.asarray(base + (colors[1] - base) * joint[:, :, None], np.float64)


def _wood(texture: Texture, u: FloatArray, v: FloatArray, colors: Float32Array) -> FloatArray:
    bend = _clouds(u, v, 2, 2, stretch=2)
    rings = 0.5 + 0.5 * np.sin(2.0 * math.pi * (v * 6.0 + 2.2 * bend))
    fibers = _clouds(u, v, 4, 4, stretch=32)
    return _mixed(colors, np.clip(0.55 * rings**2 + 0.7 * (fibers - 0.35), 0.0, 1.0))


def _marble(texture: Texture, u: FloatArray, v: FloatArray, colors: Float32Array) -> FloatArray:
    bend = _clouds(u, v, 3, 6)
    veins = np.abs(np.sin(math.pi * (2.0 * (u + v) + 3.0 * bend)))
    return _mixed(colors, np.clip((1.0 - veins) ** 5 * 0.9 + 0.25 * (_clouds(v, u, 4, 4) - 0.4), 0.0, 1.0))


def _noise(texture: Texture, u: FloatArray, v: FloatArray, colors: Float32Array) -> FloatArray:
    return _mixed(colors, np.clip(1.6 * _clouds(u, v, 4, 5) - 0.3, 0.0, 1.0))


def _dots(texture: Texture, u: FloatArray, v: FloatArray, colors: Float32Array) -> FloatArray:
    away = np.hypot(u - 0.5, v - 0.5)
    return _mixed(colors, np.clip((0.28 - away) * _SIZE + 0.5, 0.0, 1.0))


def _gradient(texture: Texture, u: FloatArray, v: FloatArray, colors: Float32Array) -> FloatArray:
    return _mixed(colors, 1.0 - np.abs(2.0 * v - 1.0))


def _text(texture: Texture, u: FloatArray, v: FloatArray, colors: Float32Array) -> FloatArray:
    """Return the colors (H, W, 3) of a tile with the text in its middle, as large as fits."""
    require("PIL.Image", "pillow")
    from PIL import Image, ImageDraw, ImageFont

    from scenelang.interpreter.scene.modelling.outlines import BUNDLED

    page = Image.new("L", (_SIZE, _SIZE), 0)
    pen = ImageDraw.Draw(page)

    def font(size: float) -> ImageFont.FreeTypeFont:
        """Return DejaVu Sans, which solids of text have, too."""
        return ImageFont.truetype(BUNDLED, size)

    # U+FFFF is not a character, so its glyph is that of all missing ones
    missing = bytes(font(40.0).getmask("\uffff"))
    lost = [letter for letter in texture.text if not letter.isspace() and bytes(font(40.0).getmask(letter)) == missing]
    if lost:
        hint = 'a solid of text takes a font of the project: `(text ... :font "FILE.ttf")`'
        raise SceneError("value", f"the font of textures has no letter `{lost[0]}`", hint)
    box = pen.multiline_textbbox((0, 0), texture.text, font=font(100.0), align="center")
    size = 100.0 * 0.86 * _SIZE / max(box[2] - box[0], box[3] - box[1], 1)
    middle = (_SIZE / 2, _SIZE / 2)
    pen.multiline_text(middle, texture.text, fill=255, font=font(max(4.0, size)), anchor="mm", align="center")
    return _mixed(colors, np.asarray(page, np.float64) / 255.0)


def _clouds(u: FloatArray, v: FloatArray, cells: int, octaves: int, stretch: int = 1) -> FloatArray:
    """Return periodic fractal noise (H, W) in [0, 1]: smoothly interpolated values on lattices, the first of ``cells``.

    ``stretch`` is how many times more cells there are along v.
    """
    total, weight, share = np.zeros_like(u), 0.0, 1.0
    random = np.random.RandomState(cells * 1009 + stretch)
    for octave in range(octaves):
        columns, rows = cells << octave, (cells * stretch) << octave
        if max(columns, rows) > _SIZE // 2:
            break
        lattice = random.random_sample((rows, columns))
        x, y = u * columns, v * rows
        left, top = np.floor(x).astype(np.int64), np.floor(y).astype(np.int64)
        fx, fy = x - left, y - top
        fx, fy = fx * fx * (3.0 - 2.0 * fx), fy * fy * (3.0 - 2.0 * fy)
        first, second, upper, lower = left % columns, (left + 1) % columns, top % rows, (top + 1) % rows
        one = lattice[upper, first] * (1.0 - fx) + lattice[upper, second] * fx
        other = lattice[lower, first] * (1.0 - fx) + lattice[lower, second] * fx
        total += share * (one + (other - one) * fy)
        weight, share = weight + share, share * 0.5
    return np.asarray(total / max(weight, 1.0), np.float64)


# The functions that draw one period, and its size in units of `:scale`.
_PATTERNS: Mapping[str, tuple[Draw, tuple[float, float]]] = MappingProxyType({
    "checker": (_checker, (2.0, 2.0)),
    "stripes": (_stripes, (2.0, 2.0)),
    "brick": (_brick, (4.0, 8.0 / 3.0)),
    "tiles": (_tiles, (4.0, 4.0)),
    "planks": (_planks, (16.0, 4.0)),
    "wood": (_wood, (1.0, 1.0)),
    "marble": (_marble, (2.0, 2.0)),
    "noise": (_noise, (4.0, 4.0)),
    "dots": (_dots, (1.0, 1.0)),
    "gradient": (_gradient, (1.0, 1.0)),
    "text": (_text, (1.0, 1.0)),
})  # fmt: skip


# --- coordinates --------------------------------------------------------------------------------------------------


def coordinates(
    texture: Texture, points: FloatArray, normals: FloatArray, around: FloatArray | None = None
) -> FloatArray:
    """Return the texture coordinates (N, 2) of points of a surface, in periods.

    Parameters
    ----------
    points, normals : (N, 3)
        In the frame of the primitive; for the projection "uv" the coordinates of a mesh file, with any third.
    around : (N,), optional
        Angles near which those of cylindrical and spherical projections are, so that the corners of a triangle are on
        one side of the seam.
    """
    x, y, z = points.T
    if texture.side:
        flat = _upright(points, *SIDES[texture.side]) - np.array(texture.at)
    elif texture.projection == "uv":
        flat = points[:, :2]
    elif texture.projection == "box":
        flat = _box(points, normals)
    elif texture.projection == "planar":
        flat = np.stack([x, y], axis=1)
    else:
        angle, radius = angles(points), np.hypot(x, z)
        if around is not None:
            angle = angle + 2.0 * math.pi * np.round((around - angle) / (2.0 * math.pi))
            angle = np.where(radius > _ON_AXIS * radius.max(initial=0.0), angle, around)
        if texture.projection == "cylindrical":
            flat = np.stack([angle * around_of(texture), y], axis=1)
        else:
            flat = np.stack([angle * around_of(texture), np.arctan2(y, radius) * around_of(texture)], axis=1)
    turn = math.radians(texture.turn)
    cosine, sine = math.cos(turn), math.sin(turn)
    turned = flat @ np.array([[cosine, -sine], [sine, cosine]])
    periods = np.asarray(turned / np.array(period_of(texture)) + middle_of(texture), np.float64)
    if texture.side:
        axis, is_positive = SIDES[texture.side]
        facing = (normals[:, axis] if is_positive else -normals[:, axis]) / np.linalg.norm(normals, axis=1).clip(1e-300)
        periods[facing <= _TURNED_AWAY] = 0.0  # a corner of the margin
    return periods


def period_of(texture: Texture) -> tuple[float, float]:
    """Return the width and the height of the period, in units of the primitive's frame or of a file's coordinates."""
    scale, (width, height) = texture.scale or 1.0, tile_of(texture).size
    if texture.projection == "uv" and texture.is_image:
        return scale, scale  # an image fills the unit square
    return width * scale, height * scale


def middle_of(texture: Texture) -> float:
    """Return both coordinates of the primitive's origin: images and texts are centered on it."""
    return 0.5 if (texture.is_image or texture.name == "text") and texture.projection != "uv" else 0.0


def around_of(texture: Texture) -> float:
    """Return the length of a radian around an axis: a turn has a whole number of periods, so that there is no seam."""
    period, _ = period_of(texture)
    return period * max(1.0, round(2.0 * math.pi / (2.0 * period))) / (2.0 * math.pi)


def angles(points: FloatArray) -> FloatArray:
    """Return the angles (N,) of points (N, 3) around the y axis, 0 at +z and growing towards +x."""
    return np.asarray(np.arctan2(points[:, 0], points[:, 2]), np.float64)


def _box(points: FloatArray, normals: FloatArray) -> FloatArray:
    """Return coordinates (N, 2) on the side that each point faces, upright on the four vertical ones."""
    axis = np.argmax(np.abs(normals), axis=1)
    return _upright(points, axis, np.take_along_axis(normals, axis[:, None], 1)[:, 0] >= 0.0)


def _upright(points: FloatArray, axis: IntArray | int, is_positive: npt.NDArray[np.bool_] | bool) -> FloatArray:
    """Return coordinates (N, 2) on the side that faces an end of an axis, upright on the four vertical ones."""
    x, y, z = points.T
    sign = np.where(is_positive, 1.0, -1.0)
    across = np.choose(axis, [-z * sign, x, x * sign])
    upward = np.choose(axis, [y, -z * sign, y])
    return np.stack([across, upward], axis=1)


def corner_coordinates(texture: Texture, corners: FloatArray) -> FloatArray:
    """Return the texture coordinates (F, 3, 2) at the corners (F, 3, 3) of triangles, in their primitive's frame."""
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    around = np.repeat(angles(corners.mean(axis=1)), 3)
    flat = coordinates(texture, corners.reshape(-1, 3), np.repeat(normals, 3, axis=0), around)
    return flat.reshape(-1, 3, 2)
