"""Volume, surface area, center of mass and inertia of a scene as one solid of uniform density.

Primitives that touch no other part have the volumes and surfaces of their closed forms; where parts meet, Manifold
joins them first, so that nothing counts twice.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from scenelang.grammar.datum import dataclass, replace
from scenelang.grammar.diagnostics import LimitError, SceneError
from scenelang.interpreter.loading import np
from scenelang.interpreter.scene.entity import Entity
from scenelang.interpreter.scene.modelling.computing import surface_of
from scenelang.interpreter.scene.modelling.operations import PRIMITIVE, Expression, Operand
from scenelang.interpreter.scene.modelling.solid import has_volume, operand_of
from scenelang.interpreter.scene.pose import compose
from scenelang.interpreter.scene.primitives.base import Primitive
from scenelang.interpreter.scene.primitives.mesh import areas_of, volume_of
from scenelang.interpreter.values.values import IDENTITY, Matrix

if TYPE_CHECKING:
    import numpy.typing as npt

    FloatArray = npt.NDArray[np.float64]

_MIN_VOLUME_SHARE = 1e-15  # of the cube of the largest side: a solid of less is flat, up to rounding
_MAX_COORDINATE = 1e50  # moments of inertia grow with its fifth power, and floats end at 1e308
_FAR_COORDINATE = 1e6  # from which on moments about the origin lose digits, so that they are taken about the solid
_MAX_OFFSET_SIZES = 1e10  # distance from the origin in sizes of the solid: of 16 digits, six are left for its shape
_MAX_AXIS_DIFFERENCE = 1e-9  # relative, of the scale factors of a pose that keeps shapes similar


@dataclass(frozen=True, slots=True, eq=False)
class Measures:
    """Measures of a solid in scene units, with density 1.

    Attributes
    ----------
    volume, area
        Enclosed volume, and area of the surface.
    centroid : (3,)
        Center of mass; the origin for an empty solid.
    inertia : (3, 3)
        Inertia tensor about the center of mass, along the axes of the scene.
    """

    volume: float
    area: float
    centroid: FloatArray
    inertia: FloatArray

    @property
    def moments(self) -> FloatArray:
        """Principal moments of inertia (3,), ascending."""
        return np.asarray(np.linalg.eigvalsh(self.inertia), np.float64)

    def data(self) -> dict[str, Any]:
        """Return the measures as JSON data."""
        return {
            "volume": self.volume, "area": self.area, "centroid": self.centroid.tolist(),
            "moments": self.moments.tolist(), "inertia": self.inertia.tolist(),
        }  # fmt: skip


def measures_of(root: Entity, word: str | None = None, limit: int = 100_000) -> Measures:
    """Return the measures of a frame, or of all entities of a word in it, as one solid in the world frame.

    Semantic primitives count as their boxes, flat ones not at all. Raises SceneError and LimitError as ``measured``
    does, and LimitError for more than ``limit`` primitives.
    """
    operands: list[Operand] = []
    stack: list[tuple[Entity, Matrix, bool]] = [(root, IDENTITY, word is None)]
    while stack:
        entity, pose, counts = stack.pop()
        counts = counts or entity.word == word
        if entity.is_primitive and counts:
            operands += operands_of(entity, pose)
        if len(operands) > limit:
            raise LimitError("primitives", f"more than {limit:,} primitives to measure", "measure a word of fewer")
        stack.extend((part.car, compose(pose, part.cdr), counts) for part in reversed(entity.children))
    return measured(operands)


def operands_of(entity: Entity, pose: Sequence[float]) -> list[Operand]:
    """Return a primitive under a pose as operands of ``measured``: none if it is flat, its box if it is semantic."""
    shape = entity.shape
    if shape is None or shape.is_flat or not shape.has_geometry or not has_volume(pose):
        return []
    if shape.is_semantic:
        return [Operand(Expression(PRIMITIVE, shape=shape), tuple(pose))]
    return [operand_of("measure", entity, pose, entity.word)]


def measured(operands: Sequence[Operand]) -> Measures:
    """Return the measures of the union of solids.

    Raises
    ------
    SceneError
        "solid" if one of them cannot be computed, "domain" if one is too large or too far away.
    LimitError
        "size" if there would be too many triangles.
    """
    parts = [_measured_group(group) for group in _groups(operands)] if operands else []
    volume = sum(part.volume for part in parts)
    if volume <= 0.0:
        return Measures(0.0, 0.0, np.zeros(3), np.zeros((3, 3)))
    centroid = sum((part.volume * part.centroid for part in parts), np.zeros(3)) / volume
    inertia = sum((part.inertia + _shifted(part.volume, part.centroid - centroid) for part in parts), np.zeros((3, 3)))
    return Measures(volume, sum(part.area for part in parts), centroid, inertia)


def _shifted(mass: float, offset: FloatArray) -> FloatArray:
    """Return the term of the parallel axis theorem for a mass whose center is at ``offset`` from the axes."""
    tensor: FloatArray = mass * (float(offset @ offset) * np.eye(3) - np.outer(offset, offset))
    return tensor


def _groups(operands: Sequence[Operand]) -> list[list[Operand]]:
    """Return the operands in groups whose bounding boxes are apart, by a sweep along x and union-find."""
    boxes = np.array([_box(operand) for operand in operands])
    parents = np.arange(len(operands))

    def root(i: int) -> int:
        """Return the representative of a group; paths are halved on the way."""
        while parents[i] != i:
            parents[i] = parents[parents[i]]
            i = int(parents[i])
        return i

    order = np.argsort(boxes[:, 0], kind="stable")
    active: list[int] = []
    for i in order.tolist():  # a sweep along x
        active = [j for j in active if boxes[j, 3] >= boxes[i, 0]]
        for j in active:
            if (boxes[j, 1:3] <= boxes[i, 4:6]).all() and (boxes[i, 1:3] <= boxes[j, 4:6]).all():
                parents[root(i)] = root(j)
        active.append(i)
    groups: dict[int, list[Operand]] = {}
    for i, operand in enumerate(operands):
        groups.setdefault(root(i), []).append(operand)
    return list(groups.values())


def _box(operand: Operand) -> tuple[float, ...]:
    """Return the bounding box of an operand, minima before maxima."""
    shape = operand.expression.shape
    if shape is not None:
        return shape.box_under(operand.pose)
    surface = surface_of(operand.expression)
    if surface is None:
        return (0.0,) * 6
    pose = np.array(operand.pose).reshape(3, 4)
    points = surface.hull @ pose[:, :3].T + pose[:, 3]
    return (*points.min(axis=0).tolist(), *points.max(axis=0).tolist())


def _measured_group(group: Sequence[Operand]) -> Measures:
    """Return the measures of operands that may meet; far from the origin, relative to the position of the first."""
    place = np.array(group[0].pose, np.float64)[3::4]
    if not _FAR_COORDINATE < float(np.abs(place).max()) < _MAX_COORDINATE:
        return _measured_near(group)
    near = _measured_near([replace(operand, pose=_shifted_pose(operand.pose, place)) for operand in group])
    return Measures(near.volume, near.area, near.centroid + place, near.inertia)


def _shifted_pose(pose: Sequence[float], place: FloatArray) -> tuple[float, ...]:
    """Return a pose relative to an origin at ``place``."""
    shifted = np.array(pose, np.float64)
    shifted[3::4] -= place
    return tuple(shifted.tolist())


def _measured_near(group: Sequence[Operand]) -> Measures:
    """Return the measures of the union of operands, about the origin of their poses."""
    whole = group[0].expression if len(group) == 1 else Expression("solid-union", operands=tuple(group))
    pose = np.array(group[0].pose if len(group) == 1 else np.eye(3, 4), np.float64).reshape(3, 4)
    surface = surface_of(whole)
    if surface is None:
        return Measures(0.0, 0.0, np.zeros(3), np.zeros((3, 3)))
    corners = surface.mesh.corners @ pose[:, :3].T + pose[:, 3]
    reach = float(np.abs(corners).max())
    if not reach < _MAX_COORDINATE:
        raise SceneError(
            "domain", f"only what is within {_MAX_COORDINATE:g} of the origin can be measured, got {reach:.3g}"
        )
    size = float(np.ptp(corners.reshape(-1, 3), axis=0).max())
    if reach > _MAX_OFFSET_SIZES * size:
        raise SceneError("domain", f"what is {size:.3g} large and {reach:.3g} away from its origin cannot be measured")
    if np.linalg.det(pose[:, :3]) < 0.0:
        corners = corners[:, ::-1]
    volume, area = volume_of(corners), float(areas_of(corners).sum())
    if volume <= _MIN_VOLUME_SHARE * size**3:  # flattened by its pose
        return Measures(0.0, area, corners.reshape(-1, 3).mean(axis=0), np.zeros((3, 3)))
    centroid, inertia = _moments(corners)
    shape = whole.shape if whole.operation == PRIMITIVE else None
    if shape is not None:
        exact, area = _exact(shape, pose, area)
        inertia, volume = inertia * (exact / volume), exact
    return Measures(volume, area, centroid, inertia)


def _exact(shape: Primitive, pose: FloatArray, area: float) -> tuple[float, float]:
    """Return volume and surface area of a primitive in closed form; ``area`` stays unless the pose is a similarity."""
    volume = shape.volume() * abs(float(np.linalg.det(pose[:, :3])))
    lengths = np.linalg.svd(pose[:, :3], compute_uv=False)
    if lengths[0] - lengths[2] <= _MAX_AXIS_DIFFERENCE * lengths[0]:
        return volume, shape.area() * float(lengths[0]) ** 2
    return volume, area


def _moments(corners: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the center of mass of a closed mesh with the ``corners`` (F, 3, 3), and its inertia tensor about it.

    Sums over the tetrahedra between the faces and a point (Tonon, "Explicit exact formulas for the 3-D tetrahedron
    inertia tensor in terms of its vertex coordinates", 2004).
    """
    start = corners[0, 0]
    a, b, c = (corners[:, k] - start for k in range(3))
    volumes = np.einsum("ni,ni->n", a, np.cross(b, c)) / 6.0
    total, sums = float(volumes.sum()), a + b + c
    center = np.einsum("n,ni->i", volumes, sums) / (4.0 * total)
    second = sum(np.einsum("n,ni,nj->ij", volumes, v, v) for v in (a, b, c, sums)) / 20.0
    second = second - total * np.outer(center, center)
    return start + center, np.asarray(np.trace(second) * np.eye(3) - second, np.float64)
