"""The 2D layout of a shot: where each primitive, or each entity taken as one, stands in the picture.

The boxes are those of ``backends/maps``: the exact rectangles of projections, here cut at the picture's edges.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.base import need
from scenelang.backends.labels.dataset import instance_color
from scenelang.backends.labels.ground_truth import Boxes, Truth, boxes_in
from scenelang.backends.neural.sentences import PromptCondition, Sentences, written

IntArray = npt.NDArray[np.int64]
FloatArray = npt.NDArray[np.float64]
Box = tuple[float, float, float, float]

MOST = 30  # instances that models with slots can be told of


@dataclass(frozen=True, slots=True)
class LayoutPlace:
    """Where an instance stands: its number ``instance`` in the ancestry, its ``box`` x0, y0, x1, y1 in pixels from the
    top left corner, the least ``depth`` at which it is seen in scene units, ``area`` in pixels that show it."""

    instance: int
    box: Box
    depth: float
    area: int


@dataclass(frozen=True, slots=True)
class PictureLayout:
    """The ``places`` of a picture of ``width`` x ``height`` pixels, the nearest first; ``left_out`` counts instances
    that are seen but smaller than these."""

    width: int
    height: int
    places: tuple[LayoutPlace, ...]
    left_out: int

    def fractions(self, place: LayoutPlace) -> Box:
        """The place's box as shares of the picture, 0 to 1."""
        x0, y0, x1, y1 = place.box
        return x0 / self.width, y0 / self.height, x1 / self.width, y1 / self.height


def layout_of(truth: Truth, units: IntArray, most: int = MOST) -> PictureLayout:
    """The layout of a shot: of all instances among ``units`` (M,), the unit of every instance, that are seen at all,
    the ``most`` with the largest boxes."""
    boxes = boxes_in(truth)
    used = np.unique(units[truth.ancestry.primitives])
    nearest = _nearest(truth, units)
    seen = used[np.isfinite(nearest[used])]
    cut = cut_boxes(boxes, truth.camera.width, truth.camera.height)
    sizes = (cut[seen, 2] - cut[seen, 0]) * (cut[seen, 3] - cut[seen, 1])
    largest = seen[np.argsort(-sizes, kind="stable")[:most]]
    ordered = largest[np.argsort(nearest[largest], kind="stable")]
    places = tuple(_place(int(i), cut[i], nearest[i], boxes.area[i]) for i in ordered)
    return PictureLayout(truth.camera.width, truth.camera.height, places, len(seen) - len(places))


def cut_boxes(boxes: Boxes, width: int, height: int) -> FloatArray:
    """The boxes (M, 4) of whole projections inside a picture; what is seen, where a part lies behind the camera."""
    edges = np.array([width, height, width, height], np.float64)
    return np.clip(np.where(np.isnan(boxes.full), boxes.visible, boxes.full), 0.0, edges)


def _place(instance: int, box: FloatArray, depth: float, area: int) -> LayoutPlace:
    x0, y0, x1, y1 = box.tolist()
    return LayoutPlace(instance, (x0, y0, x1, y1), float(depth), int(area))


def _nearest(truth: Truth, units: IntArray) -> FloatArray:
    """For every instance (M,) the least depth of the pixels of the unit that it is; infinity where there are none."""
    out = np.full(len(truth.ancestry), np.inf)
    np.minimum.at(out, units[truth.instance[truth.seen]], truth.depth[truth.seen])
    return out


# A layout for inspection: as a picture with coloured, labelled boxes, and as JSON.


Picture = npt.NDArray[np.uint8]

FORMAT, VERSION = "scenelang-layout", 1
_BACKGROUND = 24
_FILL = 0.35  # how much of a box's colour lies over what is behind it
_LABEL = 100  # characters
_LINE = 13  # pixels of a line of text


def layout_picture(layout: PictureLayout, conditions: Sequence[PromptCondition]) -> Picture:
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


def layout_json(
    layout: PictureLayout, conditions: Sequence[PromptCondition], truth: Truth, prompt: str
) -> dict[str, Any]:
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


# What the model is told of each place of a layout.


def conditions_in(layout: PictureLayout, truth: Truth, units: IntArray, sentences: Sentences) -> list[PromptCondition]:
    """The condition of every place; ``units`` (M,) are what each instance counts as. Raises SceneError("value")."""
    primitives = truth.ancestry.primitives
    of = units[primitives]
    return [
        sentences.condition(place.instance, primitives[np.flatnonzero(of == place.instance)].tolist())
        for place in layout.places
    ]


def handles_in(conditions: Sequence[PromptCondition]) -> set[str]:
    """The handles of what the conditions are said of."""
    return {handle for condition in conditions for handle in condition.handles}
