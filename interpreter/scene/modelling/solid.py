"""The primitive of computed solids, which ``difference``, ``extrude`` and the other procedures return."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from scenelang.grammar.datum import Span, dataclass
from scenelang.grammar.diagnostics import Note, SceneError
from scenelang.interpreter.scene.entity import Entity, descendants
from scenelang.interpreter.scene.modelling.operations import PRIMITIVE, SEGMENTS, Expression, Operand
from scenelang.interpreter.scene.primitives.base import Primitive, Symmetry, color_of
from scenelang.interpreter.values.values import IDENTITY

if TYPE_CHECKING:
    from scenelang.interpreter.scene.modelling.stored import ComputedSolid
    from scenelang.interpreter.scene.primitives.mesh import Mesh


@dataclass(frozen=True, slots=True, kw_only=True)
class SolidShape(Primitive):
    """Solid that is computed when its surface or size is needed; its faces have their own colors unless it has one."""

    word = "solid"
    doc = "a computed solid"
    is_solid = False  # its expression determines it, which is not an attribute: attributes stay plain data
    symmetry = Symmetry(unknown=True)

    expression: Expression = Expression("solid-union")

    @classmethod
    def of(cls, expression: Expression, attributes: Mapping[str, Any]) -> SolidShape:
        """Return the solid of an expression; raises SceneError("attribute") for invalid attributes."""
        checked = cls.from_attributes(expression.operation, attributes)  # raises for an invalid material
        color = attributes.get("color")
        shown = checked.color if color is None else color_of("solid", color)
        return cls(expression=expression, color=shown, image=checked.image)

    def defining_attributes(self) -> dict[str, Any]:
        return {"solid": self.expression.digest, "color": list(self.color)}

    def display_name(self, word: str) -> str | None:
        return None

    @property
    def computed(self) -> ComputedSolid:
        """Surface; computing it raises SceneError and LimitError."""
        from scenelang.interpreter.scene.modelling.computing import computed

        return computed(self.expression)

    @property
    def is_flat(self) -> bool:
        return False

    @property
    def cost(self) -> int:
        return 64

    def interval(self, a: float, b: float, c: float) -> tuple[float, float]:
        # exact, since the vertices of the hull determine every extreme
        hull = self.computed.hull
        along = hull[:, 0] * a + hull[:, 1] * b + hull[:, 2] * c
        return float(along.min()), float(along.max())

    def triangulate(self, tolerance: float) -> Mesh:
        """Return the surface, whatever the tolerance: the segments of its operands decide."""
        return self.computed.mesh

    def volume(self) -> float:
        return self.computed.volume

    def area(self) -> float:
        return self.computed.area


def compute_all(roots: Iterable[Entity], note: Callable[[Span], None] | None = None) -> None:
    """Compute the solids of frames now, so that errors and limits are met before a backend begins.

    Those that the evaluation has computed are stored on disk now, because it may not write files. ``note`` is called
    with the source location of each node before it is computed. Raises SceneError and LimitError as ``computed`` does.
    """
    for entity in descendants(*roots):
        if isinstance(entity.shape, SolidShape):
            from scenelang.interpreter.scene.modelling.computing import computed, store

            store(entity.shape.expression, computed(entity.shape.expression, note))


# --- entities as operands --------------------------------------------------------------------------------------------


def operand_of(name: str, entity: Entity, pose: Sequence[float], word: str, segments: int = SEGMENTS) -> Operand:
    """Return a primitive entity as an operand.

    Parameters
    ----------
    name
        Builtin that is named in errors.
    entity
        Primitive.
    pose : (12,)
        Pose of the operand, row by row.
    word
        Word of its faces in masks.
    segments
        Number of sides of its full circles.

    Raises
    ------
    SceneError
        "solid" for a primitive that is not a solid, with the place where it is created.
    """
    shape = entity.shape
    assert shape is not None
    if not has_volume(pose):
        raise _refusal(name, entity, "its pose makes it flat")
    if isinstance(shape, SolidShape):
        color = entity.embedding.attributes.get("color")
        return Operand(shape.expression, tuple(pose), None if color is None else shape.color)
    reason = _why_no_solid(shape)
    if reason is not None:
        hint = "give it a `bind` that makes solids, or leave it out" if shape.is_semantic else None
        raise _refusal(name, entity, f"it is {reason}", hint)
    parameters = {"segments": segments} if segments != SEGMENTS else {}
    site = entity.call_sites[0] if entity.call_sites else None
    return Operand(Expression(PRIMITIVE, parameters, (), shape, word, shape.color, site), tuple(pose))


def _refusal(name: str, entity: Entity, why: str, hint: str | None = None) -> SceneError:
    """Return the error for an entity that is not a solid; ``check --run --picture`` shows it."""
    notes = tuple(Note(f'"{entity.word}" is made here', span) for span in entity.call_sites[:1])
    return SceneError("solid", f'`{name}` cannot use "{entity.word}": {why}', hint, notes=notes, subject=entity)


_MIN_DETERMINANT = 1e-12  # relative to the lengths of the columns; below it, a pose flattens up to rounding


def has_volume(pose: Sequence[float]) -> bool:
    """Return whether a pose keeps three dimensions, up to rounding."""
    a, b, c, _, d, e, f, _, g, h, i, _ = pose
    sizes = [math.hypot(*column) for column in ((a, d, g), (b, e, h), (c, f, i))]
    determinant = a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)
    return abs(determinant) > _MIN_DETERMINANT * sizes[0] * sizes[1] * sizes[2]


def _why_no_solid(shape: Primitive) -> str | None:
    """Return why a primitive is not a solid, or None if it is one."""
    if shape.is_semantic:
        return "a semantic primitive, which has no shape before a model draws it"
    if shape.is_block:
        return "made of Minecraft blocks"
    if shape.is_flat or not shape.has_geometry:
        return "flat, so it has no volume"
    return None


def joined(root: Entity, segments_of: Callable[[Entity], int] = lambda _: SEGMENTS) -> Expression | None:
    """Return the union of all primitives below an entity as one solid, or None if it has none with a volume.

    Parts are joined level by level, so that shared ones are joined once. Semantic primitives count as their boxes.

    Parameters
    ----------
    root
        Entity whose primitives are joined.
    segments_of
        Number of sides of full circles, for a primitive entity.
    """
    order = list(descendants(root))
    solids: dict[int, Expression | None] = {}
    containers: dict[int, str] = {}  # word of the entity that contains a primitive
    for entity in reversed(order):  # parents first
        for part in entity.children:
            containers.setdefault(id(part.car), entity.word)
    for entity in order:
        if entity.is_primitive:
            word = containers.get(id(entity), entity.word)
            solids[id(entity)] = _joined_leaf(entity, word, segments_of(entity))
            continue
        operands = [(solids[id(part.car)], part.cdr) for part in entity.children]
        parts = tuple(Operand(solid, tuple(pose)) for solid, pose in operands if solid is not None)
        solids[id(entity)] = Expression("solid-union", operands=parts, word=entity.word) if parts else None
    return solids[id(root)]


def _joined_leaf(entity: Entity, word: str, segments: int) -> Expression | None:
    """Return the solid of a primitive entity, or None if it is flat."""
    shape = entity.shape
    if shape is None or shape.is_flat or not shape.has_geometry:
        return None
    if isinstance(shape, SolidShape):
        operand = operand_of("solid-union", entity, IDENTITY, word)
        return Expression("solid-union", operands=(operand,), word=word)
    return Expression(PRIMITIVE, {"segments": segments}, (), shape, word, shape.color)
