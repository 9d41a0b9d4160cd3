"""Contraction of the short edges of closed surfaces, for formats in single precision.

Merging points by their places makes edges with four faces wherever a surface touches itself or a thin part collapses.
Here the neighbors across every edge are followed through the faces that vanish, and points are then numbered again, one
for each fan of neighboring faces: every edge keeps exactly two faces by index, as in the surface before.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from scenelang.backends.surfaces.convex import clusters

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]


def contracted(
    points: FloatArray, faces: IntArray, tags: IntArray, least: float
) -> tuple[FloatArray, IntArray, IntArray]:
    """Contract the short edges of a closed surface, and drop the faces that vanish.

    An edge is short if its length is below ``least``, or if its ends round to one point in single precision. Two faces
    that become each other's reverse vanish, too.

    Parameters
    ----------
    points, faces : (V, 3), (F, 3)
        A surface in which every edge has two faces by index.
    tags : (F,)
        Any number for each face, such as its material.
    least
        Length below which an edge is contracted, in the unit of the points.

    Returns
    -------
    points, faces, tags
        Of the surface that remains.
    """
    edges = np.stack([faces, np.roll(faces, -1, axis=1)], axis=2).reshape(-1, 2)
    start, end = points[edges[:, 0]], points[edges[:, 1]]
    is_short = np.linalg.norm(start - end, axis=1) < least
    is_short |= (start.astype(np.float32) == end.astype(np.float32)).all(axis=1)
    short = edges[is_short]
    if not len(short):
        return points, faces, tags
    ends, pairs = np.unique(short, return_inverse=True)
    place = np.arange(len(points))
    place[ends] = ends[clusters(len(ends), pairs.reshape(-1, 2).tolist())]
    merged = place[faces]
    partner = _partners(faces)
    remains = _drop_flat(merged, partner)
    _drop_reversed(merged, partner, remains)
    return _numbered(points, merged, partner, remains, tags)


# Half-edge 3 f + i leads from corner i of face f to the next corner; its partner leads back in the neighboring face.


def _next(half: IntArray) -> IntArray:
    """Return the half-edge of the same face that follows each half-edge."""
    return np.asarray(half - half % 3 + (half % 3 + 1) % 3, np.int64)


def _partners(faces: IntArray) -> IntArray:
    """Return the half-edge (3 F,) in the other direction for each half-edge, -1 if there is none."""
    count = int(faces.max(initial=0)) + 1
    start, end = faces.reshape(-1), np.roll(faces, -1, axis=1).reshape(-1)
    key, back = start * count + end, end * count + start
    order, reverse = np.argsort(key, kind="stable"), np.argsort(back, kind="stable")
    partner = np.full(len(key), -1, np.int64)
    if (key[order] == back[reverse]).all():
        partner[order] = reverse
    return partner


def _join(partner: IntArray, one: int, other: int) -> None:
    """Make two half-edges partners, if both exist."""
    if one >= 0 and other >= 0:
        partner[one], partner[other] = other, one


def _drop_flat(merged: IntArray, partner: IntArray) -> npt.NDArray[np.bool_]:
    """Drop the faces that a contracted edge makes flat, and make the neighbors across their other edges partners.

    Parameters
    ----------
    merged : (F, 3)
        Faces after the contraction.
    partner : (3 F,)
        Partner of half-edge ``3 * face + corner``, -1 if there is none; changed in place.

    Returns
    -------
    (F,)
        Mask of the faces that remain.
    """
    is_contracted = merged == np.roll(merged, -1, axis=1)  # (F, 3): whether the edge from each corner is
    remains: npt.NDArray[np.bool_] = ~is_contracted.any(axis=1)
    for face in np.flatnonzero(is_contracted.sum(axis=1) == 1).tolist():
        edge = int(np.argmax(is_contracted[face]))
        after, before = 3 * face + (edge + 1) % 3, 3 * face + (edge + 2) % 3  # the half-edges that now coincide
        _join(partner, int(partner[after]), int(partner[before]))
    return remains


def _drop_reversed(merged: IntArray, partner: IntArray, remains: npt.NDArray[np.bool_]) -> None:
    """Drop pairs of faces that are each other's reverse, and join their neighbors."""
    rows = np.flatnonzero(remains)
    ordered = np.sort(merged[rows], axis=1)
    _, group, sizes = np.unique(ordered, axis=0, return_inverse=True, return_counts=True)
    double = rows[sizes[group.reshape(-1)] > 1]
    waiting: dict[tuple[int, ...], list[int]] = {}
    for face in double.tolist():
        a, b, c = merged[face].tolist()
        turned = min((a, c, b), (c, b, a), (b, a, c))
        if others := waiting.get(turned):
            other = others.pop()
            remains[[face, other]] = False
            _join_around(merged, partner, face, other)
        else:
            waiting.setdefault(min((a, b, c), (b, c, a), (c, a, b)), []).append(face)


def _join_around(merged: IntArray, partner: IntArray, face: int, other: int) -> None:
    """Join the neighbors of two opposite faces across each of their edges."""
    starts = {start: 3 * other + corner for corner, start in enumerate(merged[other].tolist())}
    for corner in range(3):
        half = 3 * face + corner
        back = starts[int(merged[face, (corner + 1) % 3])]
        if partner[half] != back:
            _join(partner, int(partner[half]), int(partner[back]))


def _numbered(
    points: FloatArray, merged: IntArray, partner: IntArray, remains: npt.NDArray[np.bool_], tags: IntArray
) -> tuple[FloatArray, IntArray, IntArray]:
    """Return the faces that remain, with a point for each fan of neighboring faces (label propagation)."""
    corner = np.flatnonzero(np.repeat(remains, 3))
    corner = corner[partner[corner] >= 0]
    ahead, across = _next(corner), _next(partner[corner])
    label = np.arange(3 * len(merged))
    while True:
        before = label.copy()
        for one, other in ((corner, across), (ahead, partner[corner])):
            np.minimum.at(label, one, label[other])
            np.minimum.at(label, other, label[one])
        label = label[label]  # a step further along each chain
        if (label == before).all():
            break
    chosen = label.reshape(-1, 3)[remains]
    first, numbers = np.unique(chosen, return_inverse=True)
    return points[merged.reshape(-1)[first]], numbers.reshape(-1, 3), tags[remains]


def crowded_edges(points: FloatArray, faces: IntArray) -> int:
    """Return how many edges have more than two faces for readers that join points at one place in single precision."""
    places, place = np.unique(points.astype(np.float32) + np.float32(0.0), axis=0, return_inverse=True)
    if len(places) == len(points):
        return 0
    joined = place.reshape(-1)[faces]
    edges = np.sort(np.stack([joined, np.roll(joined, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
    keys = edges[:, 0] * len(places) + edges[:, 1]
    _, counts = np.unique(keys[edges[:, 0] != edges[:, 1]], return_counts=True)
    return int((counts > 2).sum())
