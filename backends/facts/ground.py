"""The ground of a frame, and the walls that close a scene off: what needs no support."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from scenelang.backends.facts.bodies import BodySet
from scenelang.backends.facts.contacts import Contacts, own_sides
from scenelang.backends.facts.tolerances import (
    GROUND_AREA,
    GROUND_BELOW,
    GROUND_FLATNESS,
    GROUND_MARGIN,
    PLANTED,
    TERRAIN_AREA,
    WALL_SPAN,
    WALL_THICKNESS,
)
from scenelang.backends.surfaces.convex import Bodies
from scenelang.backends.surfaces.distance import IntArray
from scenelang.backends.surfaces.solids import FloatArray

BoolArray = npt.NDArray[np.bool_]


LOWEST_POINT = "the lowest point"


@dataclass(frozen=True, slots=True, eq=False)
class Ground:
    """The ground: a plane, and the solids that are it.

    Attributes
    ----------
    height
        Height of the plane, in scene units.
    solids : (N,)
        Which solids are the ground.
    reason
        Why: "a broad body lies under the rest", "the scene reaches y = 0", or "the lowest point".
    """

    height: float
    solids: BoolArray
    reason: str


def ground_of(solids: Bodies, bodies: BodySet, child: IntArray) -> Ground:
    """Return the ground of a frame; ``child`` (N,) is the part of the root that each solid is in.

    An explicit one comes first: a broad, flat solid under the rest, or the tiles of one part of the root. Otherwise it
    is the plane y = 0 if a body stands there, else the plane through the lowest point.
    """
    low, high = solids.boxes
    none = np.zeros(len(solids), bool)
    if not len(solids):
        return Ground(0.0, none, "the scene reaches y = 0")
    broad = _broad_ground(low, high, child, solids.touch) & solids.opaque & (len(bodies) > 1)
    for i in np.flatnonzero(broad & solids.hollow).tolist():
        broad[i] = _is_terrain(solids, i)
    if broad.any():
        bottom, top = float(low[broad, 1].min()), float(high[broad, 1].max())
        at_zero = bottom - solids.touch <= 0.0 <= top + solids.touch
        return Ground(0.0 if at_zero else bottom, broad, "a broad body lies under the rest")
    held = bodies.floating
    bottoms = bodies.low[~held, 1] if (~held).any() else bodies.low[:, 1]
    below = bottoms < -solids.touch
    heights = (bodies.size[~held, 1] if (~held).any() else bodies.size[:, 1])[below]
    planted = len(heights) > 1 and bool((-bottoms[below] <= PLANTED * heights).all())  # posts, with nothing else below
    if (np.abs(bottoms) <= solids.touch).any() or planted:
        return Ground(0.0, none, "the scene reaches y = 0")
    return Ground(float(bottoms.min()), none, LOWEST_POINT)


def _is_terrain(solids: Bodies, i: int) -> bool:
    """Return whether a solid that is not convex covers the scene and has one surface above any place: no roof."""
    low, high = solids.boxes
    footprint = float(areas(low[i], high[i]))
    surface = solids.surface(i)
    if surface is None or footprint < TERRAIN_AREA * float(areas(low.min(axis=0), high.max(axis=0))):
        return False
    mesh = surface.to_mesh64()
    corners = np.asarray(mesh.vert_properties[:, :3])[np.asarray(mesh.tri_verts)][:, :, [0, 2]]
    sides = corners[:, 1:] - corners[:, :1]
    faces = (sides[:, 0, 1] * sides[:, 1, 0] - sides[:, 0, 0] * sides[:, 1, 1]) / 2.0  # areas seen from above
    return TERRAIN_AREA * footprint <= float(faces[faces > 0.0].sum()) <= footprint / TERRAIN_AREA


def areas(low: FloatArray, high: FloatArray) -> FloatArray:
    """Return the horizontal areas (...,) of boxes with corners (..., 3)."""
    return np.asarray(np.prod((high - low)[..., [0, 2]], axis=-1), np.float64)


def _broad_ground(low: FloatArray, high: FloatArray, group: IntArray, touch: float) -> BoolArray:
    """Return which solids (N,) are a broad, flat ground under the rest: one solid, or the tiles of a ``group``."""
    least, most = low.min(axis=0), high.max(axis=0)
    area, middle = float(areas(least, most)), (low + high)[:, 1] / 2.0
    is_ground = np.zeros(len(low), bool)
    candidates = [np.array([i]) for i in np.flatnonzero(_is_broad(low, high, area)).tolist()]
    for number in np.unique(group).tolist():
        tiles = np.flatnonzero(group == number)
        if len(tiles) > 1 and _is_broad(low[tiles].min(axis=0)[None], high[tiles].max(axis=0)[None], area)[0]:
            covered = float(areas(low, high)[tiles].sum())
            if covered >= GROUND_AREA * area:
                candidates.append(tiles)
    for rows in candidates:
        bottom, top = float(low[rows, 1].min()), float(high[rows, 1].max())
        rest = np.setdiff1d(np.arange(len(low)), rows)
        # Under the rest: at least half of it is above, and nearly none below, such as the legs of a table.
        own = float(areas(low[rows].min(axis=0), high[rows].max(axis=0)))
        is_terrain = len(rows) == 1 and own >= TERRAIN_AREA * area
        level = bottom if is_terrain else top  # what stands in a valley is below the hills
        above, below = np.count_nonzero(middle[rest] > level), np.count_nonzero(middle[rest] < bottom)
        if bottom > touch and (np.abs(low[rest, 1]) <= touch).any():
            continue  # the rest stands on y = 0, as the poles of a stall beside its counter
        broadest = float(areas(low, high)[rest].max(initial=0.0))
        if len(rest) and own > GROUND_MARGIN * broadest and 2 * above >= len(rest) and below <= GROUND_BELOW * len(low):
            is_ground[rows] = True
    if is_ground.any():
        lowest = float(high[is_ground, 1].min())
        is_ground &= low[:, 1] <= lowest + (high - low)[is_ground, 1].min()  # a floor and its carpet, no table top
    return is_ground


def _is_broad(low: FloatArray, high: FloatArray, area: float) -> BoolArray:
    """Return which boxes (K,) are flat, and cover much of an area."""
    size = high - low
    broad = size[:, 0] * size[:, 2] >= GROUND_AREA * area
    return np.asarray(broad & (size[:, 1] <= GROUND_FLATNESS * size[:, [0, 2]].min(axis=1)), bool)


def walls_of(solids: Bodies, contacts: Contacts) -> BoolArray:
    """Return which solids (N,) are standing panels that close the scene off, and the ceilings that lie on them."""
    low, high = solids.boxes
    if not len(solids):
        return np.zeros(0, bool)
    size, scene = high - low, high.max(axis=0) - low.min(axis=0)
    scene = np.maximum(scene, 1e-300)
    thin = size.min(axis=1) <= WALL_THICKNESS * np.sort(size, axis=1)[:, 1]
    own = own_sides(solids, np.arange(len(solids)))  # a slanted rod does not fill its box
    thin &= own[:, 1] >= (1.0 - WALL_THICKNESS) * np.sort(size, axis=1)[:, 1]
    axis = np.argmin(size, axis=1)
    spans = size / scene >= WALL_SPAN
    standing = thin & (axis != 1) & spans[:, 1] & spans[np.arange(len(size)), 2 - axis]
    lying = thin & (axis == 1) & spans[:, 0] & spans[:, 2]
    pairs = contacts.pairs
    on_wall = np.zeros(len(solids), bool)
    for first, second in ((0, 1), (1, 0)):
        rows = standing[pairs[:, first]] & (
            low[pairs[:, second], 1] >= low[pairs[:, first], 1] + size[pairs[:, first], 1] / 2
        )
        on_wall[pairs[rows, second]] = True
    return np.asarray(standing | (lying & on_wall), bool)
