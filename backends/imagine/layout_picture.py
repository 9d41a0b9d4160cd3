"""A layout for inspection: as a picture with coloured, labelled boxes, and as JSON."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.base import need
from scenelang.backends.clip.conditions import Condition
from scenelang.backends.clip.encodings import written
from scenelang.backends.imagine.layout import Layout
from scenelang.backends.maps.pictures import instance_color
from scenelang.backends.maps.truth import Truth

Picture = npt.NDArray[np.uint8]

FORMAT, VERSION = "scenelang-layout", 1
_BACKGROUND = 24
_FILL = 0.35  # how much of a box's colour lies over what is behind it
_LABEL = 100  # characters
_LINE = 13  # pixels of a line of text


def layout_picture(layout: Layout, conditions: Sequence[Condition]) -> Picture:
    """The boxes (H, W, 3), those behind first, each in a colour of its own with what it has room for of its text."""
    picture = np.full((layout.height, layout.width, 3), _BACKGROUND, np.uint8)
    rows = list(enumerate(zip(layout.places, conditions, strict=True)))
    for number, (place, _) in reversed(rows):
        x0, y0, x1, y1 = (round(edge) for edge in place.box)
        part = picture[y0:y1, x0:x1]
        part[:] = np.rint((1.0 - _FILL) * part + _FILL * np.array(instance_color(number)))
    image = need("PIL.Image", "pillow").fromarray(picture)
    pen = need("PIL.ImageDraw", "pillow").Draw(image)
    font = need("PIL.ImageFont", "pillow").load_default(11)
    for number, (place, condition) in reversed(rows):
        left, top, right, bottom = place.box
        color = instance_color(number)
        pen.rectangle((left, top, max(left, right - 1), max(top, bottom - 1)), outline=color)
        lines = _wrapped(
            f"{number + 1} {condition.plain}"[:_LABEL], right - left - 4, lambda t: pen.textlength(t, font)
        )
        shown = "\n".join(lines[: max(1, int((bottom - top) // _LINE))])
        light = tuple((255 + part) // 2 for part in color)
        pen.text((left + 2, top + 1), shown, fill=light, font=font, stroke_width=1, stroke_fill=(0, 0, 0), spacing=0)
    return np.asarray(image, np.uint8).copy()


def _wrapped(text: str, width: float, length: Callable[[str], float]) -> list[str]:
    """A text in lines that are at most ``width`` long, longer only where a word is."""
    lines: list[str] = []
    for word in "".join(c if c.isprintable() else " " for c in text).split():
        if lines and length(f"{lines[-1]} {word}") <= width:
            lines[-1] += f" {word}"
        else:
            lines.append(word)
    return lines


def layout_json(layout: Layout, conditions: Sequence[Condition], truth: Truth, prompt: str) -> dict[str, Any]:
    """The layout as JSON; boxes are x0, y0, x1, y1 as shares of the picture, the nearest instance first."""
    ancestry = truth.ancestry
    return {
        "format": FORMAT,
        "version": VERSION,
        "width": layout.width,
        "height": layout.height,
        "prompt": prompt,
        "left_out": layout.left_out,
        "instances": [
            {
                "path": list(ancestry.path(place.instance)),
                "handle": f"<{condition.handles[0]}>",
                "word": ancestry.entity(place.instance).word,
                "prompt": written(condition.prompt),
                "text": condition.plain,
                "box": list(layout.fractions(place)),
                "depth": place.depth,
                "area": place.area,
            }
            for place, condition in zip(layout.places, conditions, strict=True)
        ],
    }
