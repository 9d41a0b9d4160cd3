"""The 2D layout of a shot: where each primitive, or each entity taken as one, stands in the picture.

The boxes are those of ``backends/maps``: the exact rectangles of projections, here cut at the picture's edges.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from scenelang.backends.maps.boxes import Boxes, boxes_in
from scenelang.backends.maps.truth import Truth
from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.ancestry import Ancestry

IntArray = npt.NDArray[np.int64]
FloatArray = npt.NDArray[np.float64]
Box = tuple[float, float, float, float]

MOST = 30  # instances that models with slots can be told of
_PATH = re.compile(r"\d+(/\d+)*\Z")


@dataclass(frozen=True, slots=True)
class Wholes:
    """Which entities count as one: those ``depth`` below the root (None: only primitives), and the ``named`` ones, each
    by a handle ``<z5>``, by the places of children from the root ``0/2``, or by a word."""

    depth: int | None = None
    named: tuple[str, ...] = ()


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


# --- what counts as one ----------------------------------------------------------------------------------------------


def units_of(ancestry: Ancestry, handles: Sequence[str], wholes: Wholes) -> IntArray:
    """For every instance (M,) the one that it counts as: the highest around it that ``wholes`` takes as one, or itself.

    ``handles`` are those of all instances. Raises SceneError("value") for a name that nothing has.
    """
    units = np.arange(len(ancestry)) if wholes.depth is None else ancestry.at_depth(wholes.depth)
    chosen = np.zeros(len(ancestry), bool)
    for name in wholes.named:
        called = _called(ancestry, handles, name)
        if not called:
            hint = "a handle '<z5>', places of children from the root 0/2, or a word; `scenelang tree` shows them"
            raise SceneError("value", f"nothing in the scene is called `{name}`", hint=hint)
        chosen[called] = True
    if chosen.any():
        units = units.copy()
        for level in range(ancestry.deepest + 1):  # from the root, so that what is highest counts
            rows = np.flatnonzero(ancestry.depth == level)
            above = np.where(ancestry.parent[rows] >= 0, ancestry.parent[rows], rows)
            inside = chosen[units[above]] & (above != rows)
            units[rows] = np.where(inside, units[above], np.where(chosen[rows], rows, units[rows]))
    return units


def _called(ancestry: Ancestry, handles: Sequence[str], name: str) -> list[int]:
    """The instances that a name of the user's means."""
    if _PATH.match(name):
        wanted = tuple(map(int, name.split("/")))
        level = np.flatnonzero(ancestry.depth == len(wanted)).tolist()
        return [i for i in level if ancestry.path(i) == wanted]
    if name.startswith("<") and name.endswith(">"):
        return [i for i, handle in enumerate(handles) if handle == name[1:-1]]
    of_word = np.array([entity.word == name for entity in ancestry.nodes], bool)
    found: list[int] = np.flatnonzero(of_word[ancestry.node]).tolist()
    return found
