"""Single precision: meshes keep their shapes far from the origin, and a format that cannot hold them is reported.

A float32 is a number rounded by up to 2^-24 of its value. A body of volume V and surface A changes by at most
A * 2^-24 * reach if its coordinates reach that far, so V / A, its *stoutness*, decides how far away it may be.
Formats with nodes store meshes around their own centers (``own_offset``, ``chunks_of``); others use double precision
or more digits where needed; STL, which has neither, warns (``changed_bodies``).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from scenelang.interpreter.scene.bounds import entity_box
from scenelang.interpreter.scene.entity import Entity
from scenelang.interpreter.scene.primitives.mesh import areas_of, volume_of

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]
BoolArray = npt.NDArray[np.bool_]


class Rounding(NamedTuple):
    """Rounding of coordinates by a format: the largest relative error, and the function."""

    error: float
    of: Callable[[FloatArray], FloatArray]


def _as_single(values: FloatArray) -> FloatArray:
    """Round to single precision."""
    return values.astype(np.float32).astype(np.float64)


def _with_nine_digits(values: FloatArray) -> FloatArray:
    """Round to nine significant decimal digits."""
    digits = 8.0 - np.floor(np.log10(np.maximum(np.abs(values), 1e-290)))
    scale = 10.0 ** np.minimum(digits, 300.0)
    return np.asarray(np.rint(values * scale) / scale, np.float64)


SINGLE = Rounding(2.0**-24, _as_single)
NINE_DIGITS = Rounding(5e-9, _with_nine_digits)
MAX_CHANGE = 1e-3  # relative to a volume: larger changes are avoided, or reported
_NEAR_EXTENTS = 4.0  # distance from the origin that needs no offset, unless a mesh is thinner than 1 : 1,000
_REACH_MARGIN = 1 / 16  # of the reach of a mesh: its bodies may be thinner than the whole
_FAR_SIZES = 1e3  # distance from which float32 rounds by more than 6e-5 (2^-14) of the size, which is visible
_MIN_VOLUME = 1e-9  # relative to the cube of the largest side: smaller volumes are rounding of an open or flat mesh
_OPEN_STOUTNESS = 1e-4  # relative to the diagonal: stoutness of a mesh without volume, so that it keeps its shape too
_BATCH_POINTS = 1 << 18  # points whose volumes are compared at once


def stoutness_of(vertices: FloatArray, faces: IntArray) -> float:
    """Return the volume of a mesh divided by its surface area, a length; 0 if it encloses nothing."""
    if not len(faces):
        return 0.0
    corners = vertices[faces]
    volume, area = abs(volume_of(corners)), float(areas_of(corners).sum())
    return volume / area if volume > _MIN_VOLUME * float(np.ptp(vertices, axis=0).max()) ** 3 else 0.0


def reach_of(stoutness: FloatArray | float, error: float) -> FloatArray:
    """Return the largest coordinates at which bodies keep their volumes under a relative rounding ``error``."""
    return MAX_CHANGE / error * np.asarray(stoutness, np.float64)


def own_offset(vertices: FloatArray, faces: IntArray) -> FloatArray | None:
    """Return the center (3,) of a mesh that is too far from its origin for single precision, else None."""
    if not len(vertices):
        return None
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    far = float(max(np.abs(low).max(), np.abs(high).max()))
    if far <= _NEAR_EXTENTS * float((high - low).max()):
        return None
    stoutness = stoutness_of(vertices, faces) or _OPEN_STOUTNESS * float(np.linalg.norm(high - low))
    if far <= _REACH_MARGIN * reach_of(stoutness, SINGLE.error):
        return None
    return np.asarray((low + high) / 2.0, np.float64)


def common_offset(points: FloatArray, size: float) -> FloatArray | None:
    """Return the center (3,) of some points if float32 would shift objects at them visibly, else None.

    The points are the positions of copies, or of one object over time. Objects shift visibly if the points are much
    farther from the origin than from each other and than the objects' ``size``.
    """
    low, high = points.min(axis=0, initial=np.inf), points.max(axis=0, initial=-np.inf)
    far = float(np.abs(points).max(initial=0.0))
    is_far = far > _FAR_SIZES * max(size, float((high - low).max()))
    return np.asarray((low + high) / 2.0, np.float64) if is_far else None


def about(poses: FloatArray, offset: FloatArray) -> FloatArray:
    """Return poses (..., 3, 4) relative to an offset (3,) of their common frame."""
    return poses - offset[:, None] * (0.0, 0.0, 0.0, 1.0)


def size_of(entities: Iterable[Entity]) -> float:
    """Return the largest extent of the boxes of some entities."""
    boxes = [box for box in map(entity_box, entities) if box is not None]
    return max((max(box[3] - box[0], box[4] - box[1], box[5] - box[2]) for box in boxes), default=0.0)


@dataclass(frozen=True, slots=True, eq=False)
class Copies:
    """Copies of meshes: centers (N, 3) and radii (N,) of their bounding spheres, and their stoutness (N,).

    Stoutness is 0 for those that enclose nothing.
    """

    centers: FloatArray
    radii: FloatArray
    stoutness: FloatArray

    @staticmethod
    def of(vertices: FloatArray, faces: IntArray, matrices: FloatArray) -> Copies:
        """Return the copies of a mesh.

        Parameters
        ----------
        vertices, faces : (V, 3), (F, 3)
            The mesh.
        matrices : (N, 3, 4)
            Poses of the copies.
        """
        if not len(vertices):
            none = np.zeros(len(matrices))
            return Copies(np.zeros((len(matrices), 3)), none, none)
        low, high = vertices.min(axis=0), vertices.max(axis=0)
        linear = matrices[:, :, :3]
        squares, least = _growth_of(linear)
        centers = linear @ ((low + high) / 2.0) + matrices[:, :, 3]
        radii = np.sqrt(squares) * float(np.linalg.norm(high - low)) / 2.0
        return Copies(centers, radii, stoutness_of(vertices, faces) * least)

    @staticmethod
    def of_boxes(boxes: FloatArray, matrices: FloatArray) -> Copies:
        """Return boxes (N, 2, 3) under poses (N, 3, 4).

        V / A of a box is at least a sixth of its shortest side, which is exact for a cube.
        """
        linear = matrices[:, :, :3]
        squares, least = _growth_of(linear)
        centers = np.einsum("nij,nj->ni", linear, boxes.mean(axis=1)) + matrices[:, :, 3]
        sides = boxes[:, 1] - boxes[:, 0]
        radii = np.sqrt(squares) * np.linalg.norm(sides, axis=1) / 2.0
        return Copies(centers, radii, sides.min(axis=1) / 6.0 * least)

    def thick(self) -> Copies:
        """Return the copies where those that enclose nothing count as thin plates."""
        return Copies(
            self.centers, self.radii, np.where(self.stoutness > 0.0, self.stoutness, 2.0 * _OPEN_STOUTNESS * self.radii)
        )

    def grouped(self, group: IntArray) -> Copies:
        """Return one body for each group, ``group`` (N,) being numbers from 0, as stout as its thinnest member."""
        count = int(group.max(initial=-1)) + 1
        low, high, stoutness = np.full((count, 3), np.inf), np.full((count, 3), -np.inf), np.full(count, np.inf)
        np.minimum.at(low, group, self.centers - self.radii[:, None])
        np.maximum.at(high, group, self.centers + self.radii[:, None])
        np.minimum.at(stoutness, group, self.stoutness)
        return Copies((low + high) / 2.0, (high - low).max(axis=1) / 2.0, stoutness)

    @staticmethod
    def joined(parts: Sequence[Copies]) -> Copies:
        """Concatenate copies."""
        return Copies(
            np.concatenate([part.centers for part in parts]),
            np.concatenate([part.radii for part in parts]),
            np.concatenate([part.stoutness for part in parts]),
        )

    def fit(self, error: float, rows: IntArray | None = None, offset: FloatArray | None = None) -> BoolArray:
        """Return the mask of copies that keep their volumes when their coordinates are rounded.

        ``error`` is the relative rounding error, ``rows`` are the copies that are tested (by default all), and
        ``offset`` (3,) is the point to which the coordinates are relative.
        """
        chosen = slice(None) if rows is None else rows
        centers = self.centers[chosen] - (0.0 if offset is None else offset)
        far = np.abs(centers).max(axis=1, initial=0.0) + self.radii[chosen]
        stoutness = self.stoutness[chosen]
        return np.asarray((far <= reach_of(stoutness, error)) | (stoutness == 0.0), np.bool_)


def _growth_of(linear: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the squared Frobenius norms (N,) of linear maps (N, 3, 3), and lower bounds (N,) of their scales.

    The squares of the two largest singular values sum to at least twice their product, so the determinant divided by
    half the squared norm is at most the smallest one.
    """
    squares = np.einsum("nij,nij->n", linear, linear)
    return squares, np.abs(np.linalg.det(linear)) / np.maximum(squares / 2.0, 1e-300)


def chunks_of(copies: Copies) -> list[tuple[IntArray, FloatArray]]:
    """Return the copies in groups that single precision can hold, each with the offset (3,) to store it about.

    They are one group about the origin if that suffices. Otherwise groups are halved across their longest side.
    """
    copies = copies.thick()
    everything = np.arange(len(copies.centers))
    if copies.fit(SINGLE.error).all():
        return [(everything, np.zeros(3))]
    chunks, waiting = [], [everything]
    while waiting:
        rows = waiting.pop()
        low, high = copies.centers[rows].min(axis=0), copies.centers[rows].max(axis=0)
        offset = (low + high) / 2.0
        if len(rows) == 1 or copies.fit(SINGLE.error, rows, offset).all():
            chunks.append((rows, offset))
            continue
        order = np.argsort(copies.centers[rows, int(np.argmax(high - low))], kind="stable")
        half = len(rows) // 2
        waiting += [np.sort(rows[order[half:]]), np.sort(rows[order[:half]])]
    return chunks


@dataclass(frozen=True, slots=True, eq=False)
class ChangedBody:
    """A body whose volume a format changes.

    Attributes
    ----------
    sizes, center : (3,)
        Of its box in the world.
    change
        Relative change of its volume.
    corner
        Index of one of its points in the mesh.
    """

    sizes: FloatArray
    center: FloatArray
    change: float
    corner: int


def changed_bodies(points: FloatArray, faces: IntArray, poses: FloatArray, rounding: Rounding) -> Iterator[ChangedBody]:
    """Yield the bodies of copies of a mesh whose volumes change by more than ``MAX_CHANGE``.

    A body is a connected part of the mesh.

    Parameters
    ----------
    points, faces : (V, 3), (F, 3)
        The mesh.
    poses : (N, 3, 4)
        Poses of its copies in the world.
    """
    if not len(faces):
        return
    body = bodies_of(faces)
    faces = faces[np.argsort(body, kind="stable")]
    starts = np.flatnonzero(np.diff(np.sort(body), prepend=-1))
    corner = np.repeat(faces[starts, 0], np.diff(starts, append=len(faces)))
    size = max(1, _BATCH_POINTS // len(points))
    for first in range(0, len(poses), size):
        some = poses[first : first + size]
        world = np.einsum("nij,pj->npi", some[:, :, :3], points) + some[:, None, :, 3]
        near = world[:, corner]  # volumes are summed about a point of the body, so that they do not cancel
        exact, rounded = (_volumes(coordinates, near, faces, starts) for coordinates in (world, rounding.of(world)))
        for n, k in np.argwhere(np.abs(rounded - exact) > MAX_CHANGE * np.abs(exact)).tolist():
            corners = world[n, np.unique(faces[starts[k] : (*starts, len(faces))[k + 1]])]
            low, high = corners.min(axis=0), corners.max(axis=0)
            if abs(exact[n, k]) > _MIN_VOLUME * float((high - low).max()) ** 3:
                change = float(abs(rounded[n, k] - exact[n, k]) / abs(exact[n, k]))
                yield ChangedBody(high - low, (low + high) / 2.0, change, int(faces[starts[k], 0]))


def _volumes(world: FloatArray, near: FloatArray, faces: IntArray, starts: IntArray) -> FloatArray:
    """Return the volumes (N, B) enclosed by the faces from each of ``starts`` on.

    They are summed about points ``near`` the faces (N, F, 3).
    """
    a, b, c = (world[:, faces[:, k]] - near for k in range(3))
    parts = np.einsum("nfi,nfi->nf", a, np.cross(b, c)) / 6.0
    return np.asarray(np.add.reduceat(parts, starts, axis=1), np.float64)


def bodies_of(faces: IntArray) -> IntArray:
    """Return the body (F,) of each face: equal numbers for faces connected by shared points (label propagation)."""
    count = int(faces.max(initial=-1)) + 1
    label = np.arange(count)
    while True:
        least = label[faces].min(axis=1)
        before = label.copy()
        for corner in range(3):
            np.minimum.at(label, faces[:, corner], least)
        label = label[label]  # a step further along each chain
        if (label == before).all():
            return np.asarray(label[faces[:, 0]], np.int64)
