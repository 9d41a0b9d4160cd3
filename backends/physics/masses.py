"""Mass, center of mass and second moments of bodies.

A body of one density is measured as the union of its parts, so that overlaps count once: single boxes, balls and
cylinders in closed form, others by Manifold (`interpreter.scene.modelling.measuring`). Where
densities or masses differ within a body, every part has its own, and overlaps count in each.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.scene.bounds import entity_box
from scenelang.interpreter.scene.entity import Entity
from scenelang.interpreter.scene.modelling.measuring import Measures, measured, measures_of, operands_of
from scenelang.interpreter.scene.modelling.operations import PRIMITIVE, Expression, Operand
from scenelang.interpreter.scene.pose import compose
from scenelang.interpreter.scene.primitives.base import Primitive
from scenelang.interpreter.scene.primitives.cube import BLOCK, Cube
from scenelang.interpreter.scene.primitives.cylinder import CYLINDER
from scenelang.interpreter.scene.primitives.sphere import BALL
from scenelang.interpreter.values.values import ANONYMOUS, IDENTITY, Matrix

FloatArray = npt.NDArray[np.float64]

# Means of x^2, y^2 and z^2 over the points of a form, about its center.
_MEANS = {BLOCK: (1 / 3, 1 / 3, 1 / 3), BALL: (1 / 5, 1 / 5, 1 / 5), CYLINDER: (1 / 4, 1 / 3, 1 / 4)}

# Of the largest second moment. MuJoCo writes six digits: after rounding by 5e-6 each, two moments of inertia must still
# sum to at least the third.
_MIN_SECOND_RATIO = 2e-5
_MIN_BOX_SHARE = 1e-3  # of the largest extent: the thickness of the box of a flat open mesh


@dataclass(frozen=True, slots=True, eq=False)
class Moments:
    """Mass properties in some frame.

    Attributes
    ----------
    mass
        Mass; a volume while the density is 1.
    center : (3,)
        Center of mass.
    second : (3, 3)
        Second moments about the center of mass, the integral of ``(x - center) (x - center)^T`` over the mass.
    """

    mass: float
    center: FloatArray
    second: FloatArray

    @property
    def inertia(self) -> FloatArray:
        """Inertia tensor (3, 3) about the center of mass."""
        return np.asarray(np.trace(self.second) * np.eye(3) - self.second, np.float64)

    def principal(self) -> tuple[FloatArray, FloatArray]:
        """Return the principal moments of inertia (3,) and their axes, the columns of a rotation (3, 3).

        Each is the sum of two second moments, so that none exceeds the sum of the others. The second moment across a
        thin plate is nearly zero and is raised to ``_MIN_SECOND_RATIO``, since readers test that inequality on rounded
        numbers.
        """
        second, axes = np.linalg.eigh(self.second)
        second = np.maximum(second, _MIN_SECOND_RATIO * max(float(second[2]), 0.0))
        if np.linalg.det(axes) < 0.0:
            axes[:, 0] *= -1.0
        return np.asarray(second.sum() - second, np.float64), np.asarray(axes, np.float64)

    def times(self, factor: float) -> Moments:
        """Return the moments for ``factor`` times the density."""
        return Moments(self.mass * factor, self.center, self.second * factor)

    def under(self, pose: FloatArray) -> Moments:
        """Return the moments of a volume under an affine pose (3, 4), which changes volumes by its determinant."""
        linear = pose[:, :3]
        growth = abs(float(np.linalg.det(linear)))
        return Moments(self.mass * growth, linear @ self.center + pose[:, 3], growth * linear @ self.second @ linear.T)


def total(parts: Sequence[Moments]) -> Moments:
    """Return the moments of parts together, by the parallel axis theorem; zeros if there is no mass."""
    mass = sum(part.mass for part in parts)
    if not mass > 0.0:
        return Moments(0.0, np.zeros(3), np.zeros((3, 3)))
    center = sum((part.mass * part.center for part in parts), np.zeros(3)) / mass
    second = sum(
        (part.second + part.mass * np.outer(part.center - center, part.center - center) for part in parts),
        np.zeros((3, 3)),
    )
    return Moments(mass, center, second)


def primitive_moments(entity: Entity) -> Moments:
    """Return the moments of a primitive in its own frame, with density 1; semantic primitives count as their boxes."""
    assert entity.shape is not None
    placed = entity.shape.placed()
    if placed is not None and placed.form in _MEANS:
        volume = placed.form.volume(placed.ratios)
        return Moments(volume, np.zeros(3), volume * np.diag(_MEANS[placed.form])).under(placed.matrix)
    return _measured_shape(entity.shape.key, entity.word)


@lru_cache(maxsize=4096)
def _measured_shape(shape: Primitive, word: str) -> Moments:
    """Return the moments of a primitive without a closed form, measured once for equal shapes."""
    return united_moments([(Entity(word, ANONYMOUS, (), shape), IDENTITY)])


def united_moments(parts: Sequence[tuple[Entity, Sequence[float]]]) -> Moments:
    """Return the moments of the union of posed primitives, with density 1; open meshes count as their boxes."""
    try:
        return _moments(measured([operand for entity, pose in parts for operand in operands_of(entity, pose)]))
    except SceneError as error:
        if error.name != "solid":
            raise
    return _moments(measured([operand for entity, pose in parts for operand in _closed_operands(entity, pose)]))


def _closed_operands(entity: Entity, pose: Sequence[float]) -> list[Operand]:
    """Return the operands of a posed primitive, its box if it is an open mesh."""
    operands = operands_of(entity, pose)
    if not operands:
        return operands  # flat: it has no mass
    try:
        measured(operands)
    except SceneError as error:
        box = entity_box(entity)
        if error.name != "solid" or box is None:
            raise
        low, high = np.array(box, np.float64).reshape(2, 3)
        size = np.maximum(high - low, _MIN_BOX_SHARE * float((high - low).max()))
        center = ((low + high) / 2.0).tolist()
        at = compose(tuple(pose), (1.0, 0.0, 0.0, center[0], 0.0, 1.0, 0.0, center[1], 0.0, 0.0, 1.0, center[2]))
        return [Operand(Expression(PRIMITIVE, shape=Cube(size=tuple(size.tolist()))), at)]
    return operands


def entity_moments(entity: Entity) -> Moments:
    """Return the moments of an entity's primitives as one solid in its own frame, with density 1."""
    try:
        return _moments(measures_of(entity))
    except SceneError as error:
        if error.name != "solid":
            raise
    return united_moments(list(_posed_primitives(entity)))


def _posed_primitives(root: Entity) -> Iterator[tuple[Entity, Matrix]]:
    """Yield the primitives of an entity with their poses in its frame; trees may be deeper than Python's stack."""
    stack: list[tuple[Entity, Matrix]] = [(root, IDENTITY)]
    while stack:
        entity, pose = stack.pop()
        if entity.is_primitive:
            yield entity, pose
        stack.extend((part.car, compose(pose, part.cdr)) for part in reversed(entity.children))


def _moments(measures: Measures) -> Moments:
    """Return measures as moments: the second moments are half the trace of the inertia minus the inertia."""
    second = np.trace(measures.inertia) / 2.0 * np.eye(3) - measures.inertia
    return Moments(measures.volume, measures.centroid, second)
