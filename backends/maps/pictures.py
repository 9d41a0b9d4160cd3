"""Maps as pictures for people: colours for words, instances, depths and motions; boxes, tracks and legends drawn."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.appearance import tint
from scenelang.backends.base import need
from scenelang.backends.maps.motion import VISIBLE, Flow, Tracks
from scenelang.backends.studio import encode

Picture = npt.NDArray[np.uint8]
IntArray = npt.NDArray[np.int64]
FloatArray = npt.NDArray[np.float64]
DrawnBox = tuple[Sequence[float], str, tuple[int, int, int]]  # x0, y0, x1, y1 in pixels; a word; a colour

_BLACK = (0, 0, 0)
_LINE = 18  # pixels of a legend's row
_MOST_ROWS = 200
_MOST_BOXES = 400


def word_color(word: str) -> tuple[int, int, int]:
    """A bright colour of a word's own, the same on every machine."""
    level = hashlib.blake2s(word.encode("utf-8", "surrogatepass"), digest_size=2).digest()
    saturation, value = (0.40, 0.65, 0.90)[level[0] % 3], (0.60, 0.80, 1.0)[level[1] % 3]
    red, green, blue = encode(np.array(tint(word, saturation, value))).tolist()
    return (red, green, blue)


def instance_color(number: int) -> tuple[int, int, int]:
    """A colour of an instance's own: neighbours in number differ."""
    hue, value = (number * 0.618033988749895) % 1.0, 0.62 + 0.33 * ((number * 0.7548776662466927) % 1.0)
    angle = 2.0 * math.pi * hue
    channels = [0.5 + 0.5 * math.cos(angle - shift) for shift in (0.0, 2.0944, 4.1888)]
    red, green, blue = (round(255 * value * (0.25 + 0.75 * channel)) for channel in channels)
    return (red, green, blue)


def colored(numbers: IntArray, colors: Mapping[int, tuple[int, int, int]]) -> Picture:
    """Numbers (H, W) as a picture; black where they have no colour."""
    used, inverse = np.unique(numbers, return_inverse=True)
    table = np.array([colors.get(int(number), _BLACK) for number in used], np.uint8)
    return np.asarray(table[inverse.reshape(-1)].reshape(*numbers.shape, 3))


def depth_picture(depth: FloatArray) -> Picture:
    """Depths (H, W) as grey: the nearest is white, the farthest dark, nothing is black."""
    seen = np.isfinite(depth)
    grey = np.zeros(depth.shape)
    if seen.any():
        near, far = float(depth[seen].min()), float(depth[seen].max())
        grey[seen] = 1.0 - 0.85 * (depth[seen] - near) / max(far - near, 1e-12 * abs(far), 1e-300)
    return np.repeat(np.rint(255 * grey).astype(np.uint8)[:, :, None], 3, axis=2)


def normal_picture(normal: FloatArray, seen: npt.NDArray[np.bool_]) -> Picture:
    """World normals (H, W, 3) from [-1, 1] to [0, 255]; black where nothing is seen."""
    return np.where(seen[:, :, None], np.rint(127.5 * (normal + 1.0)), 0.0).astype(np.uint8)


def flow_picture(flow: Flow) -> Picture:
    """Motions as colours: the direction is the hue, the length the strength; black where something is not."""
    motion = np.nan_to_num(flow.motion.astype(np.float64))
    length = np.hypot(motion[:, :, 0], motion[:, :, 1])
    strength = np.sqrt(np.clip(length / max(float(length.max()), 1e-9), 0.0, 1.0))[:, :, None]
    angle = np.arctan2(motion[:, :, 1], motion[:, :, 0])[:, :, None]
    hue = 0.5 + 0.5 * np.cos(angle - np.array([0.0, 2.0944, 4.1888]))
    known = np.isfinite(flow.motion[:, :, :1])
    return np.where(known, np.rint(255 * (1.0 - strength * (1.0 - hue))), 0.0).astype(np.uint8)


def with_boxes(picture: Picture, boxes: Sequence[DrawnBox]) -> Picture:
    """A copy of ``picture`` with rectangles x0, y0, x1, y1, their words, in their colours."""
    image = need("PIL.Image", "pillow").fromarray(picture)
    pen = need("PIL.ImageDraw", "pillow").Draw(image)
    font = need("PIL.ImageFont", "pillow").load_default(11)
    for (x0, y0, x1, y1), word, color in boxes[:_MOST_BOXES]:
        pen.rectangle((x0, y0, max(x0, x1 - 1), max(y0, y1 - 1)), outline=color)
        if x1 - x0 > 24:
            pen.text((x0 + 2, y0 + 1), _plain(word)[:24], fill=color, font=font, stroke_width=1, stroke_fill=_BLACK)
    return np.asarray(image, np.uint8).copy()


def with_tracks(picture: Picture, tracks: Tracks, frame: int, trail: int = 12) -> Picture:
    """A copy of ``picture``, frame number ``frame`` of a film, with the ways that tracked points came."""
    image = need("PIL.Image", "pillow").fromarray(picture)
    pen = need("PIL.ImageDraw", "pillow").Draw(image)
    first = max(0, frame - trail)
    size = max(1.0, min(picture.shape[:2]) / 160.0)
    for point in range(tracks.pixels.shape[1]):
        color = instance_color(point + 1)
        way = [tuple(place) for place in tracks.pixels[first : frame + 1, point] if np.isfinite(place).all()]
        if len(way) > 1:
            pen.line(way, fill=color, width=max(1, round(size)))
        if way and tracks.state[frame, point] == VISIBLE:
            x, y = way[-1]
            pen.ellipse((x - size, y - size, x + size, y + size), fill=color, outline=_BLACK)
    return np.asarray(image, np.uint8).copy()


def legend_picture(rows: Sequence[tuple[str, tuple[int, int, int]]]) -> Picture:
    """A legend: a square of each colour beside its name."""
    module, draw = need("PIL.Image", "pillow"), need("PIL.ImageDraw", "pillow")
    font = need("PIL.ImageFont", "pillow").load_default(13)
    shown = list(rows[:_MOST_ROWS])
    if len(rows) > len(shown):
        shown.append((f"and {len(rows) - len(shown):,} more", (255, 255, 255)))
    names = [_plain(name)[:48] for name, _ in shown]
    widest = max((font.getlength(name) for name in names), default=0.0)
    image = module.new("RGB", (int(widest) + 36, _LINE * max(1, len(shown)) + 8), (255, 255, 255))
    pen: Any = draw.Draw(image)
    for i, (name, (_, color)) in enumerate(zip(names, shown, strict=True)):
        top = 4 + i * _LINE
        pen.rectangle((6, top + 2, 20, top + _LINE - 3), fill=color)
        pen.text((28, top), name, fill=(20, 20, 20), font=font)
    return np.asarray(image, np.uint8).copy()


def _plain(word: str) -> str:
    return "".join(c if c.isprintable() else " " for c in word)
