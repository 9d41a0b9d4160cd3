"""Division of triangles whose texture coordinates are not linear between their corners.

Files, and renderers of meshes, interpolate coordinates between corners, which is exact for flat projections. Those
around an axis bend: on the side of a cube, bricks that go around it would be up to a brick away from where drafts have
them.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from scenelang.backends.surfaces.tiles import angles, coordinates
from scenelang.interpreter.scene.primitives.textures import Texture

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]

_BENT = 1.0 / 256.0  # of a period, two pixels of a pattern: deviation from which an edge is divided
# Edges of that share of the size of the surface stay, and divisions end, because at the axis coordinates always bend.
_SHORTEST, _MOST_LEVELS = 1.0 / 64.0, 8
_MOST_TRIANGLES = 1 << 16  # of one surface; a texture of tiny periods would divide it without end
_SHARES = (0.25, 0.5, 0.75)  # of an edge; in the middle of one through the axis there may be no deviation


def divided(texture: Texture, corners: FloatArray) -> FloatArray:
    """Return triangles divided at their edges until coordinates in a texture are nearly linear on each.

    Parameters
    ----------
    corners : (F, 3, K)
        Positions in the frame of the primitive, and values beside them, which are interpolated. Triangles that share an
        edge are divided at the same points, so that a closed surface stays closed.
    """
    if texture.projection not in ("cylindrical", "spherical"):
        return corners
    shortest = _SHORTEST * float(np.ptp(corners[:, :, :3], axis=(0, 1)).max(initial=0.0))
    for _ in range(_MOST_LEVELS):
        edges = _bent(texture, corners[:, :, :3], shortest)
        if not edges.any() or len(corners) + edges.sum() > _MOST_TRIANGLES:
            break
        corners = _split(corners, edges)
    return corners


def _bent(texture: Texture, corners: FloatArray, shortest: float) -> BoolArray:
    """Return which edges (F, 3), from each corner to the next, are long and have coordinates that are not linear."""
    normals = np.repeat(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), 3, axis=0)
    around = np.repeat(angles(corners.mean(axis=1)), 3)

    def at(points: FloatArray) -> FloatArray:
        """Return the coordinates (F, 3, 2) of a point on each edge."""
        return coordinates(texture, points.reshape(-1, 3), normals, around).reshape(-1, 3, 2)

    ends, following = at(corners), np.roll(corners, -1, axis=1)
    far = np.roll(ends, -1, axis=1)
    bent = np.zeros(corners.shape[:2], np.bool_)
    for share in _SHARES:
        between = at(corners + share * (following - corners))
        bent |= (np.abs(between - ends - share * (far - ends)) > _BENT).any(axis=2)
    bent &= np.linalg.norm(following - corners, axis=2) > shortest
    return _on_both_sides(corners, following, bent)


def _on_both_sides(corners: FloatArray, following: FloatArray, edges: BoolArray) -> BoolArray:
    """Return the edges (F, 3) and those of other triangles that are the same edge.

    They have the same middle, in the last bit too. Edges of other triangles that only have the same middle are divided
    without need, on both sides as well.
    """
    x, y, z = np.moveaxis(corners + following, 2, 0)
    _, edge = np.unique(x * math.pi + y * math.e + z * math.sqrt(2.0), return_inverse=True)
    chosen = np.bincount(edge.reshape(-1), edges.ravel()) > 0.0
    return np.asarray(chosen[edge].reshape(edges.shape))


# The triangles that one becomes, of its corners (0 to 2) and the middles of its edges (3 to 5), by how many of the
# edges are divided: the first, the first two, or all.
_TEMPLATES = {
    1: ((0, 3, 2), (3, 1, 2)),
    2: ((3, 1, 4), (0, 3, 4), (0, 4, 2)),
    3: ((0, 3, 5), (3, 1, 4), (5, 4, 2), (3, 4, 5)),
}


def _split(corners: FloatArray, edges: BoolArray) -> FloatArray:
    """Return triangles divided in the middle of some edges (F, 3)."""
    count = edges.sum(axis=1)
    pieces = [corners[count == 0]]
    for number, template in _TEMPLATES.items():
        rows = np.flatnonzero(count == number)
        # the divided edges come first: of two, the first is the one after the edge that is whole
        first = np.argmax(edges[rows], axis=1) if number == 1 else (np.argmin(edges[rows], axis=1) + 1) % 3
        order = (first[:, None] + np.arange(3)) % 3
        turned = np.take_along_axis(corners[rows], order[:, :, None], axis=1)
        middles = (turned + np.roll(turned, -1, axis=1)) / 2.0
        points = np.concatenate([turned, middles], axis=1)
        pieces.append(points[:, np.array(template)].reshape(-1, 3, corners.shape[2]))
    return np.concatenate(pieces)
