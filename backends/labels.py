"""The words of semantic primitives, written on a picture where their boxes can be seen (Pillow)."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.base import need
from scenelang.backends.solids import Solids

Picture = npt.NDArray[np.uint8]
Rectangle = tuple[float, float, float, float]

_MOST = 40
_MOST_PER_WORD = 6
_LONGEST = 32
_LEAST_SHARE = 1.5e-4  # of the picture's pixels that a box must show to be labelled
_INK = (28, 30, 36)
_PAPER = (255, 255, 255)
_SHIFTS = (0.0, -1.0, 1.0, -2.0, 2.0)  # lines that a word's first label may move to find room


@dataclass(frozen=True, slots=True)
class Label:
    """``text`` centred at pixel (``x``, ``y``); ``first`` when no larger box has the same word."""

    text: str
    x: float
    y: float
    first: bool


def labelled(picture: Picture, solids: Solids, ids: npt.NDArray[np.int64]) -> Picture:
    """``picture`` (H, W, 3), whose pixels see the solids ``ids`` (H, W), with the words of semantic primitives."""
    return write_labels(picture, labels_of(solids, ids))


def labels_of(solids: Solids, ids: npt.NDArray[np.int64]) -> list[Label]:
    """What to write on a picture whose pixels (H, W) see the solids ``ids``: the largest seen boxes first.

    A label stands at the middle of what is seen of its box, so nothing nearer hides it.
    """
    rows, columns = np.nonzero(ids >= 0)
    seen = ids[rows, columns]
    semantic = solids.semantic[seen]
    rows, columns, seen = rows[semantic], columns[semantic], seen[semantic]
    if not len(seen):
        return []
    numbers, inverse = np.unique(seen, return_inverse=True)
    area = np.bincount(inverse)
    x, y = np.bincount(inverse, columns + 0.5) / area, np.bincount(inverse, rows + 0.5) / area
    labels: list[Label] = []
    used: Counter[str] = Counter()
    for k in np.argsort(-area, kind="stable"):
        word = solids.words[int(solids.word[numbers[k]])]
        if area[k] < max(4.0, _LEAST_SHARE * ids.size) or used[word] >= _MOST_PER_WORD:
            continue
        labels.append(Label(_shortened(word), float(x[k]), float(y[k]), used[word] == 0))
        used[word] += 1
    labels.sort(key=lambda label: not label.first)
    return labels


def write_labels(picture: Picture, labels: list[Label]) -> Picture:
    """A copy of ``picture`` (H, W, 3) with ``labels`` written on it; those that would overlap others are left out."""
    if not labels:
        return picture
    image_module, draw_module = need("PIL.Image", "pillow"), need("PIL.ImageDraw", "pillow")
    image = image_module.fromarray(picture)
    pen = draw_module.Draw(image)
    height, width = picture.shape[:2]
    size = int(min(32, max(10, round(min(height, width) / 30))))
    stroke = max(1, round(size / 9))
    taken: list[Rectangle] = []
    for label in labels:
        font = _font(label.text, size)
        for x, y in _places(label, size * 1.25):
            box: Rectangle = pen.textbbox((x, y), label.text, font=font, anchor="mm", stroke_width=stroke)
            x, y = x + _inward(box[0], box[2], width), y + _inward(box[1], box[3], height)
            box = pen.textbbox((x, y), label.text, font=font, anchor="mm", stroke_width=stroke)
            if not any(_overlap(box, other) for other in taken):
                pen.text((x, y), label.text, font=font, anchor="mm", fill=_INK, stroke_width=stroke, stroke_fill=_PAPER)
                taken.append(box)
                break
        if len(taken) >= _MOST:
            break
    return np.asarray(image, np.uint8).copy()


def _places(label: Label, line: float) -> Iterator[tuple[float, float]]:
    for shift in _SHIFTS if label.first else (0.0,):
        yield label.x, label.y + shift * line


def _inward(low: float, high: float, size: int) -> float:
    """How far to move the span from ``low`` to ``high`` so that it lies in a picture of ``size``, if it fits."""
    return max(0.0, 2.0 - low) if low < 2.0 else min(0.0, size - 2.0 - high)


def _overlap(a: Rectangle, b: Rectangle) -> bool:
    return a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]


def _shortened(word: str) -> str:
    """The word on one line, without what cannot be printed."""
    text = "".join(c if c.isprintable() else " " for c in word).strip()
    return text if len(text) <= _LONGEST else text[: _LONGEST - 1] + "…"


def _font(text: str, size: int) -> Any:
    """Pillow's own font, or a wider system font where the text goes beyond Latin letters and one is found."""
    fonts = need("PIL.ImageFont", "pillow")
    if not text.isascii():
        for name in ("DejaVuSans.ttf", "NotoSans-Regular.ttf", "Arial Unicode.ttf", "arial.ttf"):
            try:
                return fonts.truetype(name, size)
            except OSError:
                continue
    return fonts.load_default(size)
