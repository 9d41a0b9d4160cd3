"""Callouts and dimensions: text and lines beside the objects of an image, drawn with Pillow at a finer resolution."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from scenelang.backends.base import require
from scenelang.backends.pictures.camera import Camera
from scenelang.backends.pictures.painted import font_for
from scenelang.interpreter.scene.primitives.base import Box

FloatArray = npt.NDArray[np.float64]
Float32Array = npt.NDArray[np.float32]
Mask = npt.NDArray[np.bool_]
Pixel = tuple[float, float]
Rectangle = tuple[float, float, float, float]  # left, top, right, bottom, in pixels

_FONT_PIXELS = (11, 40)  # smallest and largest; a share of the shorter side of the image between them
_FONT_SHARE = 1.0 / 30.0
_LINE_SHARE = 0.09  # width of leader and dimension lines, of the font's size
_LEADING = 1.35  # distance of lines of text, in sizes of the font
_GAP = 0.8  # between text and objects, in sizes of the font
_FINE_PIXELS = 2_000_000  # up to which images are annotated at four times their resolution, instead of twice
_MAX_LETTERS = 32
_MAX_EROSIONS = 400  # of an object's pixels, to find a point well inside
_LEAST_SHOWN = 0.04  # length of a dimension that is drawn, of the shorter side of the image
_OUTSIDE = 1.2  # room outside of dimension lines for their texts, in sizes of the font
_OFFSET = 1.6  # of dimension lines from the box, in sizes of the font


@dataclass(frozen=True, slots=True)
class Callout:
    """A text, and the pixel of the object that it names."""

    text: str
    at: Pixel


@dataclass(frozen=True, slots=True)
class Dimension:
    """A length between two pixels; its line is ``away`` from them, in pixels."""

    text: str
    start: Pixel
    end: Pixel
    away: Pixel


@dataclass(frozen=True, slots=True)
class Overlay:
    """What is drawn: polylines, filled polygons, dots (x, y, radius) and texts at the middles of their boxes."""

    lines: list[tuple[Pixel, ...]] = field(default_factory=list)
    polygons: list[tuple[Pixel, ...]] = field(default_factory=list)
    dots: list[tuple[float, float, float]] = field(default_factory=list)
    texts: list[tuple[str, Pixel]] = field(default_factory=list)


@dataclass(frozen=True, slots=True)
class Notes:
    """Shares (H, W) of each pixel that ink covers, and that the paper around the ink covers."""

    ink: Float32Array
    paper: Float32Array


def font_size(width: int, height: int) -> int:
    """Return the size of annotations in pixels, for an image of ``width`` x ``height``."""
    return int(min(_FONT_PIXELS[1], max(_FONT_PIXELS[0], round(min(width, height) * _FONT_SHARE))))


def text_width(text: str, size: int) -> float:
    """Return the width of a text in pixels."""
    return float(font_for(text, size).getlength(text))


def column_width(texts: Sequence[str], size: int) -> float:
    """Return the width in pixels of a column of callouts with the gaps beside it."""
    return max((text_width(text, size) for text in texts), default=0.0) + 2.6 * _GAP * size


def shown_text(word: str) -> str:
    """Return a word on one line, without unprintable characters, shortened if it is long."""
    text = "".join(c if c.isprintable() else " " for c in word).strip()
    return text if len(text) <= _MAX_LETTERS else text[: _MAX_LETTERS - 1] + "…"


def rectangle_of(mask: Mask) -> Rectangle | None:
    """Return the rectangle around the pixels of a mask (H, W)."""
    if not mask.any():
        return None
    rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    return float(columns[0]), float(rows[0]), float(columns[-1] + 1), float(rows[-1] + 1)


def inner_point(mask: Mask) -> Pixel:
    """Return a pixel of a mask (H, W) that is well inside: what is left of it after as many erosions as possible."""
    rectangle = rectangle_of(mask)
    assert rectangle is not None
    left, top, right, bottom = (int(x) for x in rectangle)
    part = np.pad(mask[top:bottom, left:right], 1)
    for _ in range(_MAX_EROSIONS):
        smaller = part.copy()
        smaller[1:-1, 1:-1] &= part[:-2, 1:-1] & part[2:, 1:-1] & part[1:-1, :-2] & part[1:-1, 2:]
        if not smaller.any():
            break
        part = smaller
    rows, columns = np.nonzero(part)
    nearest = int(np.argmin((rows - rows.mean()) ** 2 + (columns - columns.mean()) ** 2))
    return float(columns[nearest] - 1 + left) + 0.5, float(rows[nearest] - 1 + top) + 0.5


# --- callouts --------------------------------------------------------------------------------------------------------


def place_callouts(callouts: Sequence[Callout], around: Rectangle, size: tuple[int, int], drawing: Overlay) -> None:
    """Add callouts to a drawing, in a column on each side of the rectangle ``around`` the objects.

    The columns are in the order of the objects' heights, so that leader lines seldom cross; those that do not fit,
    the last ones given, are left out. ``size`` is that of the image, width and height.
    """
    width, height = size
    font = font_size(width, height)
    line = _LEADING * font
    most = max(1, int((height - font) / line))
    middle = (around[0] + around[2]) / 2.0
    sides: tuple[list[Callout], list[Callout]] = ([], [])
    for callout in callouts[: 2 * most]:
        side = int(callout.at[0] > middle)
        sides[side if len(sides[side]) < most else 1 - side].append(callout)
    for is_right, side_callouts in enumerate(sides):
        side_callouts.sort(key=lambda one: one.at[1])
        heights = _spread([one.at[1] for one in side_callouts], line, font, height - font)
        for one, y in zip(side_callouts, heights, strict=True):
            half = text_width(one.text, font) / 2.0
            if is_right:
                x = min(around[2] + 1.5 * _GAP * font + half, width - 0.4 * font - half)
            else:
                x = max(around[0] - 1.5 * _GAP * font - half, 0.4 * font + half)
            edge = x + (-1 if is_right else 1) * (half + 0.35 * font)
            elbow = edge + (-1 if is_right else 1) * 0.6 * font
            drawing.texts.append((one.text, (x, y)))
            drawing.lines.append(((edge, y), (elbow, y), one.at))
            drawing.dots.append((*one.at, 0.16 * font))


def _spread(wanted: Sequence[float], line: float, low: float, high: float) -> list[float]:
    """Return heights near the ``wanted`` ones, which ascend, at least ``line`` apart and from ``low`` to ``high``."""
    heights: list[float] = []
    for y in wanted:
        heights.append(max(y, heights[-1] + line if heights else low))
    limit = high
    for k in reversed(range(len(heights))):
        heights[k] = min(heights[k], limit)
        limit = heights[k] - line
    return heights


# --- dimensions ------------------------------------------------------------------------------------------------------


def dimensions_of(box: Box, camera: Camera) -> list[Dimension]:
    """Return the width, height and depth of a box as the camera sees it, each along an edge of its outline.

    An edge of the outline has all corners of the box on one side. A length that is seen from its end is left out.
    """
    corners = np.array([[box[k + 3 * ((n >> k) & 1)] for k in range(3)] for n in range(8)])
    pixels, _ = camera.project(corners)
    if not np.isfinite(pixels).all():
        return []
    center = pixels.mean(axis=0)
    offset = _OFFSET * font_size(camera.width, camera.height)
    dimensions = []
    for axis in range(3):
        edges = [(n, n | 1 << axis) for n in range(8) if not n >> axis & 1]
        candidates = list(_outer(pixels, center, edges))
        if not candidates or box[axis + 3] <= box[axis]:
            continue
        # Widths and depths below the objects, heights on the left.
        sign = np.array([0.0, 1.0]) if axis != 1 else np.array([-1.0, 0.0])
        first, last, normal = max(candidates, key=lambda one: float((one[0] + one[1]) @ sign + 1e-3 * one[2] @ sign))
        if np.linalg.norm(last - first) < _LEAST_SHOWN * min(camera.width, camera.height):
            continue
        text = f"{box[axis + 3] - box[axis]:.4g}"
        away = normal * offset
        dimensions.append(Dimension(text, _pixel(first), _pixel(last), _pixel(away)))
    return dimensions


def _outer(
    pixels: FloatArray, center: FloatArray, edges: Sequence[tuple[int, int]]
) -> Iterator[tuple[FloatArray, FloatArray, FloatArray]]:
    """Yield the edges of the outline of projected corners (8, 2): both ends, and the normal away from the center."""
    for one, other in edges:
        along = pixels[other] - pixels[one]
        length = float(np.linalg.norm(along))
        if length < 1.0:
            continue
        normal = np.array([along[1], -along[0]]) / length
        if normal @ (pixels[one] - center) < 0.0:
            normal = -normal
        if ((pixels - pixels[one]) @ normal <= 0.5).all():
            yield pixels[one], pixels[other], normal


def _pixel(values: FloatArray) -> Pixel:
    """Return an array (2,) as a pixel."""
    return float(values[0]), float(values[1])


def place_dimensions(dimensions: Sequence[Dimension], size: tuple[int, int], drawing: Overlay) -> None:
    """Add dimension lines with arrows, extension lines and lengths to a drawing of an image of ``size``."""
    font = font_size(*size)
    for one in dimensions:
        away = np.array(one.away)
        start, end = np.array(one.start) + away, np.array(one.end) + away
        along = (end - start) / np.linalg.norm(end - start)
        across = np.array([-along[1], along[0]])
        reach = away / np.linalg.norm(away) * 0.35 * font
        for point in (one.start, one.end):
            drawing.lines.append((_pixel(np.array(point) + 0.2 * away), _pixel(np.array(point) + away + reach)))
        # The line is interrupted by its text if that leaves a part of it on both sides; else the text is outside.
        half = text_width(one.text, font) / 2.0
        room = abs(along[0]) * half + abs(along[1]) * 0.6 * font + 0.3 * font
        middle, length = (start + end) / 2.0, float(np.linalg.norm(end - start))
        if length > 2.0 * room + 2.4 * font:
            drawing.lines.append((_pixel(start), _pixel(middle - along * room)))
            drawing.lines.append((_pixel(middle + along * room), _pixel(end)))
            drawing.texts.append((one.text, _pixel(middle)))
        else:
            drawing.lines.append((_pixel(start), _pixel(end)))
            unit = away / np.linalg.norm(away)
            outside = abs(unit[0]) * half + abs(unit[1]) * 0.6 * font + 0.35 * font
            drawing.texts.append((one.text, _pixel(middle + unit * outside)))
        for tip, direction in ((start, along), (end, -along)):
            back = tip + direction * 0.7 * font
            drawing.polygons.append(
                (_pixel(tip), _pixel(back + across * 0.2 * font), _pixel(back - across * 0.2 * font))
            )


def extent_of(dimensions: Sequence[Dimension], around: Rectangle, size: tuple[int, int]) -> Rectangle:
    """Return the rectangle of objects together with their dimension lines, with room for the lengths."""
    font = font_size(*size)
    points = [np.array(point) + np.array(one.away) for one in dimensions for point in (one.start, one.end)]
    if not points:
        return around
    every = np.array(points)
    low, high = every.min(axis=0) - font, every.max(axis=0) + font
    return min(around[0], low[0]), min(around[1], low[1]), max(around[2], high[0]), max(around[3], high[1])


def room_for(dimensions: Sequence[Dimension], size: tuple[int, int]) -> float:
    """Return the factor by which objects must shrink, around the middle of the image, to leave room for dimensions."""
    font = font_size(*size)
    half = np.array(size) / 2.0
    share = 1.0
    for one in dimensions:
        beside = np.abs(np.array(one.away)) + _OUTSIDE * font
        for point in (one.start, one.end):
            reach = np.abs(np.array(point) - half)
            share = min(share, float(((half - beside) / np.maximum(reach, 1e-9)).min()))
    return share


# --- drawing ---------------------------------------------------------------------------------------------------------


def drawn(drawing: Overlay, width: int, height: int) -> Notes:
    """Return the coverage of a drawing on an image of ``width`` x ``height`` pixels, antialiased."""
    image, pen_of = require("PIL.Image", "pillow"), require("PIL.ImageDraw", "pillow").Draw
    fine = 4 if width * height <= _FINE_PIXELS else 2
    size = font_size(width, height)
    thick = max(1.0, _LINE_SHARE * size)
    layers = [image.new("L", (width * fine, height * fine), 0) for _ in range(2)]
    for layer, more in zip(layers, (0.0, max(1.5, 0.12 * size)), strict=True):
        pen = pen_of(layer)
        stroke = round(2.0 * more * fine)
        for line in drawing.lines:
            pen.line(_scaled(line, fine), 255, round(thick * fine) + stroke, joint="curve")
        for polygon in drawing.polygons:
            pen.polygon(_scaled(polygon, fine), 255, 255, stroke or 1)
        for x, y, radius in drawing.dots:
            r = (radius + more) * fine
            pen.ellipse((x * fine - r, y * fine - r, x * fine + r, y * fine + r), 255)
        for text, (x, y) in drawing.texts:
            font = font_for(text, size * fine)
            around = round(0.25 * size * fine)  # no line crosses a text
            if not more:
                pen.text((x * fine, y * fine), text, 0, font, "mm", stroke_width=around, stroke_fill=0)
            pen.text((x * fine, y * fine), text, 255, font, "mm", stroke_width=stroke // 2)
    ink, paper = (
        np.asarray(layer, np.float32).reshape(height, fine, width, fine).mean(axis=(1, 3)) for layer in layers
    )
    return Notes(ink / np.float32(255.0), paper / np.float32(255.0))


def _scaled(points: Sequence[Pixel], factor: int) -> list[Pixel]:
    """Return points at a finer resolution."""
    return [(x * factor, y * factor) for x, y in points]
