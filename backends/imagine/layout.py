"""The 2D layout of a shot: where each primitive, or each entity taken as one, stands in the picture.

The boxes are those of ``backends/maps``: the exact rectangles of projections, here cut at the picture's edges.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from scenelang.backends.maps.boxes import Boxes, boxes_in
from scenelang.backends.maps.truth import Truth

IntArray = npt.NDArray[np.int64]
FloatArray = npt.NDArray[np.float64]
Box = tuple[float, float, float, float]

MOST = 30  # instances that models with slots can be told of


@dataclass(frozen=True, slots=True)
class Place:
    """Where an instance stands: its number ``instance`` in the ancestry, its ``box`` x0, y0, x1, y1 in pixels from the
    top left corner, the least ``depth`` at which it is seen in scene units, ``area`` in pixels that show it."""

    instance: int
    box: Box
    depth: float
    area: int


@dataclass(frozen=True, slots=True)
class Layout:
    """The ``places`` of a picture of ``width`` x ``height`` pixels, the nearest first; ``left_out`` counts instances
    that are seen but smaller than these."""

    width: int
    height: int
    places: tuple[Place, ...]
    left_out: int

    def fractions(self, place: Place) -> Box:
        """The place's box as shares of the picture, 0 to 1."""
        x0, y0, x1, y1 = place.box
        return x0 / self.width, y0 / self.height, x1 / self.width, y1 / self.height


def layout_of(truth: Truth, units: IntArray, most: int = MOST) -> Layout:
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
    return Layout(truth.camera.width, truth.camera.height, places, len(seen) - len(places))


def cut_boxes(boxes: Boxes, width: int, height: int) -> FloatArray:
    """The boxes (M, 4) of whole projections inside a picture; what is seen, where a part lies behind the camera."""
    edges = np.array([width, height, width, height], np.float64)
    return np.clip(np.where(np.isnan(boxes.full), boxes.visible, boxes.full), 0.0, edges)


def _place(instance: int, box: FloatArray, depth: float, area: int) -> Place:
    x0, y0, x1, y1 = box.tolist()
    return Place(instance, (x0, y0, x1, y1), float(depth), int(area))


def _nearest(truth: Truth, units: IntArray) -> FloatArray:
    """For every instance (M,) the least depth of the pixels of the unit that it is; infinity where there are none."""
    out = np.full(len(truth.ancestry), np.inf)
    np.minimum.at(out, units[truth.instance[truth.seen]], truth.depth[truth.seen])
    return out
