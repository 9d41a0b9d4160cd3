"""2D layout of a shot: the bounding box of each primitive, or of each entity treated as a unit, in the image.

The boxes are those of ``backends/labels``: exact bounds of projections, here clipped to the image.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.base import require
from scenelang.backends.labels.dataset import instance_color
from scenelang.backends.labels.ground_truth import Boxes, Truth, boxes_in
from scenelang.backends.neural.prompts import PromptBuilder, PromptCondition, prompt_text

IntArray = npt.NDArray[np.int64]
FloatArray = npt.NDArray[np.float64]
Box = tuple[float, float, float, float]

MAX_INSTANCES = 30  # GLIGEN's number of grounding tokens


@dataclass(frozen=True, slots=True)
class LayoutInstance:
    """Instance in an image.

    Attributes
    ----------
    instance
        Index in the ancestry.
    box
        x0, y0, x1, y1 in pixels from the top left corner.
    depth
        Minimum depth of its visible pixels, in scene units.
    area
        Number of its visible pixels.
    """

    instance: int
    box: Box
    depth: float
    area: int


@dataclass(frozen=True, slots=True)
class PictureLayout:
    """Layout of an image of ``width`` x ``height`` pixels.

    ``instances`` are ordered from near to far; ``left_out`` is the number of smaller visible instances without a box.
    """

    width: int
    height: int
    instances: tuple[LayoutInstance, ...]
    left_out: int

    def fractions(self, instance: LayoutInstance) -> Box:
        """Return the instance's box in fractions of the image size, 0 to 1."""
        x0, y0, x1, y1 = instance.box
        return x0 / self.width, y0 / self.height, x1 / self.width, y1 / self.height


def layout_of(truth: Truth, units: IntArray, max_instances: int = MAX_INSTANCES) -> PictureLayout:
    """Return the layout of a shot: the ``max_instances`` visible units with the largest boxes.

    ``units`` (M,) is the unit of every instance.
    """
    boxes = boxes_in(truth)
    used = np.unique(units[truth.ancestry.primitives])
    depths = _min_depths(truth, units)
    visible = used[np.isfinite(depths[used])]
    clipped = clip_boxes(boxes, truth.camera.width, truth.camera.height)
    sizes = (clipped[visible, 2] - clipped[visible, 0]) * (clipped[visible, 3] - clipped[visible, 1])
    largest = visible[np.argsort(-sizes, kind="stable")[:max_instances]]
    ordered = largest[np.argsort(depths[largest], kind="stable")]
    instances = tuple(_instance(int(i), clipped[i], depths[i], boxes.area[i]) for i in ordered)
    return PictureLayout(truth.camera.width, truth.camera.height, instances, len(visible) - len(instances))


def clip_boxes(boxes: Boxes, width: int, height: int) -> FloatArray:
    """Clip the boxes (M, 4) to the image: those of full projections, or the visible ones behind the camera plane."""
    edges = np.array([width, height, width, height], np.float64)
    return np.clip(np.where(np.isnan(boxes.full), boxes.visible, boxes.full), 0.0, edges)


def _instance(instance: int, box: FloatArray, depth: float, area: int) -> LayoutInstance:
    x0, y0, x1, y1 = box.tolist()
    return LayoutInstance(instance, (x0, y0, x1, y1), float(depth), int(area))


def _min_depths(truth: Truth, units: IntArray) -> FloatArray:
    """Return the minimum depth (M,) of the visible pixels of every unit; infinity without pixels."""
    out = np.full(len(truth.ancestry), np.inf)
    np.minimum.at(out, units[truth.instance[truth.seen]], truth.depth[truth.seen])
    return out


# Visualization of layouts: an image with coloured, labelled boxes, and JSON.


Picture = npt.NDArray[np.uint8]

FORMAT, VERSION = "scenelang-layout", 1
_BACKGROUND = 24
_FILL_OPACITY = 0.35
_MAX_LABEL = 100  # characters
_LINE_HEIGHT = 13  # pixels


def layout_picture(layout: PictureLayout, conditions: Sequence[PromptCondition]) -> Picture:
    """Draw the boxes (H, W, 3) from far to near, each in its own colour with as much of its prompt as fits."""
    picture = np.full((layout.height, layout.width, 3), _BACKGROUND, np.uint8)
    rows = list(enumerate(zip(layout.instances, conditions, strict=True)))
    for number, (instance, _) in reversed(rows):
        x0, y0, x1, y1 = (round(edge) for edge in instance.box)
        part = picture[y0:y1, x0:x1]
        part[:] = np.rint((1.0 - _FILL_OPACITY) * part + _FILL_OPACITY * np.array(instance_color(number)))
    image = require("PIL.Image", "pillow").fromarray(picture)
    pen = require("PIL.ImageDraw", "pillow").Draw(image)
    font = require("PIL.ImageFont", "pillow").load_default(11)
    for number, (instance, condition) in reversed(rows):
        left, top, right, bottom = instance.box
        color = instance_color(number)
        pen.rectangle((left, top, max(left, right - 1), max(top, bottom - 1)), outline=color)
        lines = _wrap_text(
            f"{number + 1} {condition.plain}"[:_MAX_LABEL], right - left - 4, lambda t: pen.textlength(t, font)
        )
        shown = "\n".join(lines[: max(1, int((bottom - top) // _LINE_HEIGHT))])
        light = tuple((255 + part) // 2 for part in color)
        pen.text((left + 2, top + 1), shown, fill=light, font=font, stroke_width=1, stroke_fill=(0, 0, 0), spacing=0)
    return np.asarray(image, np.uint8).copy()


def _wrap_text(text: str, width: float, length: Callable[[str], float]) -> list[str]:
    """Break a text into lines of at most ``width``; a single longer word is not broken."""
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
    """Return the layout as JSON data; boxes are x0, y0, x1, y1 in fractions of the image, nearest instance first."""
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
                "path": list(ancestry.path(each.instance)),
                "handle": f"<{condition.handles[0]}>",
                "word": ancestry.entity(each.instance).word,
                "prompt": prompt_text(condition.prompt),
                "text": condition.plain,
                "box": list(layout.fractions(each)),
                "depth": each.depth,
                "area": each.area,
            }
            for each, condition in zip(layout.instances, conditions, strict=True)
        ],
    }


# Prompts of the instances.


def conditions_in(
    layout: PictureLayout, truth: Truth, units: IntArray, prompts: PromptBuilder
) -> list[PromptCondition]:
    """Return the prompt of every instance of the layout; ``units`` (M,) is the unit of every instance of the scene.

    Raises SceneError("value").
    """
    primitives = truth.ancestry.primitives
    primitive_units = units[primitives]
    return [
        prompts.condition(each.instance, primitives[np.flatnonzero(primitive_units == each.instance)].tolist())
        for each in layout.instances
    ]


def handles_in(conditions: Sequence[PromptCondition]) -> set[str]:
    """Return all handles of the conditions."""
    return {handle for condition in conditions for handle in condition.handles}
