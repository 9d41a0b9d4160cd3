"""Sections: scenes cut open by planes, with the cut faces of solids filled, as a transformation of the entity graph.

The triangles of each primitive that a plane meets are clipped, and keep their colors and normals. The filling is what
the boolean engine of solids finds (``interpreter/scene/modelling``): the faces of the tool in a difference. Primitives
that are away from the planes stay the exact shapes that they are.
"""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.surfaces.appearance import look_of, tint
from scenelang.backends.surfaces.stand_ins import drawn_scene
from scenelang.grammar.datum import dataclass, field
from scenelang.grammar.diagnostics import Diagnostic, LimitError, SceneError
from scenelang.interpreter.scene.bounds import entity_box
from scenelang.interpreter.scene.entity import Entity, Scene
from scenelang.interpreter.scene.exploding import rebuilt, with_frames
from scenelang.interpreter.scene.modelling.computing import leaf_mesh, surface_of
from scenelang.interpreter.scene.modelling.operations import PRIMITIVE, Expression, Operand
from scenelang.interpreter.scene.modelling.solid import SolidShape, has_volume
from scenelang.interpreter.scene.pose import AXES, compose
from scenelang.interpreter.scene.primitives import items_of
from scenelang.interpreter.scene.primitives.base import Box, Point, Primitive
from scenelang.interpreter.scene.primitives.cube import Cube
from scenelang.interpreter.scene.primitives.mesh import Mesh
from scenelang.interpreter.values.values import IDENTITY, Embedding, Matrix, Pair, Vector

FloatArray = npt.NDArray[np.float64]
Corners = npt.NDArray[np.float64]  # (F, 3, 3) or (F, 3, 6): positions, perhaps with normals

PLANES = 3  # of one section
_CUT_SEGMENTS = 128  # sides of full circles of what is cut: within 3e-4 of the radius
_MOST_CUTS = 20_000  # primitives that the planes meet
# Nested solids are cut a little later the smaller they are, so that their faces show on those of what is around them:
# in shares of the diagonal of the scene, for a size e times smaller, and for the next one of the same size.
_LATER, _NEXT, _MOST_NEXT = 1e-4, 2e-6, 50
_MOST_SHIFT = 0.01  # of a solid's own size
_TOOL = "\0section"  # word of the faces of the tool, which no program can write
_SHADE, _SATURATION = 0.5, 1.3  # of the cut faces' color, relative to that of the surface


@dataclass(frozen=True, slots=True)
class CutPlane:
    """A plane across an axis of the world.

    Attributes
    ----------
    axis
        Index of the axis.
    position
        In scene units, or a share of the box of the scene if ``is_share``.
    keeps_far
        Whether the side of larger coordinates stays, instead of the other.
    """

    axis: int
    position: float
    is_share: bool = False
    keeps_far: bool = False


def planes_of(text: str) -> tuple[CutPlane, ...]:
    """Read the planes of a section, such as ``x=0.2``, ``-z=50%`` or ``x=50%,z=50%``.

    ``x=0.2`` removes what is beyond the plane, ``-x=0.2`` what is before it. Raises SceneError("value").

    Examples
    --------
    >>> planes_of("-y=25%")
    (CutPlane(axis=1, position=0.25, is_share=True, keeps_far=True),)
    """
    planes = []
    for piece in text.split(","):
        match = re.fullmatch(r"\s*(-?)([xyz])\s*=\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d{1,2})?)(%?)\s*", piece)
        if match is None:
            hint = "write `x=0.2` or `y=50%`; `--section=-x=0.2` keeps the other side, `x=50%,z=50%` removes a corner"
            raise SceneError("value", f"`{text[:60]}` is no section", hint)
        sign, axis, number, share = match.groups()
        planes.append(CutPlane(AXES.index(axis), float(number) / (100.0 if share else 1.0), bool(share), bool(sign)))
    if len({plane.axis for plane in planes}) < len(planes):
        raise SceneError("value", f"the section `{text[:60]}` has two planes across one axis", "give one per axis")
    return tuple(planes)


@dataclass(frozen=True, slots=True, kw_only=True)
class CutSurface(Primitive):
    """A part of the surface of a primitive, or the face of a cut through it."""

    word = "cut-surface"
    doc = "a part of a surface"
    is_solid = False
    is_remnant = True

    surface: Mesh = field(default_factory=lambda: Mesh(np.zeros((0, 3)), None, np.zeros((0, 3), np.int64)))

    def defining_attributes(self) -> dict[str, Any]:
        return {"surface": id(self.surface), "color": list(self.color)}

    def triangulate(self, tolerance: float) -> Mesh:
        """Return the surface, whatever the tolerance."""
        return self.surface


def cut(
    scene: Scene,
    planes: Sequence[CutPlane],
    limit: int = 2_000_000,
    warn: Callable[[Diagnostic], None] | None = None,
) -> Scene:
    """Return a scene without what is beyond all of the planes; the cut faces of closed objects are filled.

    One plane removes a half of the scene, two or three a corner. Open meshes and flat objects have no filling.

    Parameters
    ----------
    limit
        Maximum number of cubes that Minecraft blocks become.
    warn
        Receives warnings about these.

    Raises
    ------
    SceneError
        "empty-scene" if nothing is left, "value" for planes that ``planes_of`` would not return.
    LimitError
        "primitives" if the planes meet more than 20,000 primitives.

    Examples
    --------
    >>> import scenelang as sl
    >>> half = cut(sl.evaluate('(bind "it" (lambda () (call "cube")))').graph, planes_of("x=0.25"))
    >>> sl.Scene(half).bounds.tolist()
    [[-0.5, -0.5, -0.5], [0.25, 0.5, 0.5]]
    """
    scene = drawn_scene(scene, limit, warn)
    boxes = [box for root in scene.frames if (box := entity_box(root)) is not None]
    if not boxes or not planes:
        return scene
    whole = np.array(boxes)
    low, high = whole[:, :3].min(axis=0), whole[:, 3:].max(axis=0)
    knife = _Knife(low, high, planes)
    frames = [knife.cut_root(root) for root in scene.frames]
    if all(entity_box(root) is None for root in frames):
        raise SceneError(
            "empty-scene", "the section leaves nothing", "move the plane, or keep the other side: `--section=-x=...`"
        )
    return with_frames(scene, frames)


class _Knife:
    """Cuts the frames of one scene; equal instances of frames are cut once."""

    def __init__(self, low: FloatArray, high: FloatArray, planes: Sequence[CutPlane]) -> None:
        self._diagonal = float(np.linalg.norm(high - low)) or 1.0
        # The removed box, which reaches beyond the scene where no plane bounds it.
        self._low, self._high = low - self._diagonal, high + self._diagonal
        self._planes = planes
        for plane in planes:
            k = plane.axis
            at = low[k] + plane.position * (high[k] - low[k]) if plane.is_share else plane.position
            # A plane that misses the scene removes all or nothing; its box must not be turned inside out.
            at = min(max(at, self._low[k] + 1e-3 * self._diagonal), self._high[k] - 1e-3 * self._diagonal)
            (self._high if plane.keeps_far else self._low)[k] = at
        self._shifts: dict[tuple[int, Matrix], float] = {}
        self._known: dict[tuple[int, Matrix], tuple[Any, ...]] = {}
        self._keep: list[Entity] = []  # so that no id of a known entity is used again

    def cut_root(self, root: Entity) -> Entity:
        """Return a frame without what is removed."""
        met = list(self._met(root))
        if len(met) > _MOST_CUTS:
            message = f"the section meets {len(met):,} primitives, more than the limit of {_MOST_CUTS:,}"
            raise LimitError("primitives", message, hint="cut a part of the scene: `--part PATH`")
        sizes = [self._size(entity, pose) for entity, pose in met]
        largest, seen, shifts = max(sizes, default=1.0), Counter[float](), list[float]()
        for size in sizes:
            later = _LATER * math.log(largest / size) + _NEXT * min(seen[size], _MOST_NEXT)
            shifts.append(later * self._diagonal)
            seen[size] += 1
        # in a large scene the shift of a small solid could be larger than the solid
        shares = (_MOST_SHIFT * size / shift for size, shift in zip(sizes, shifts, strict=True) if shift)
        factor = min(1.0, min(shares, default=1.0))
        for (entity, pose), shift in zip(met, shifts, strict=True):
            self._shifts[id(entity), pose] = factor * shift
        parts = self._cut(root)
        if len(parts) == 1 and parts[0].cdr == IDENTITY:
            whole: Entity = parts[0].car
            return whole
        return Entity(root.word, root.embedding, parts, None, root.tainted)

    def _side(self, entity: Entity, pose: Matrix) -> str:
        """Return whether an entity under a pose is kept, removed or met by the planes."""
        box = entity_box(entity)
        if box is None:
            return "kept"
        low, high = _box_under(box, pose)
        if (high <= self._low).any() or (low >= self._high).any():
            return "kept"
        return "removed" if (low >= self._low).all() and (high <= self._high).all() else "met"

    def _met(self, root: Entity) -> Iterator[tuple[Entity, Matrix]]:
        """Yield the primitives that the planes meet, with their poses, at most a few more than may be cut."""
        stack, count = [(root, Matrix(IDENTITY))], 0
        while stack and count <= _MOST_CUTS:
            entity, pose = stack.pop()
            if self._side(entity, pose) != "met":
                continue
            if entity.is_primitive:
                count += 1
                yield entity, pose
            stack.extend((part.car, compose(pose, part.cdr)) for part in entity.children)

    def _size(self, entity: Entity, pose: Matrix) -> float:
        """Return the size in the world by which nested primitives are told apart."""
        box = entity_box(entity)
        low, high = _box_under(box, pose) if box is not None else (np.zeros(3), np.zeros(3))
        return max(float(f"{np.linalg.norm(high - low):.9g}"), 1e-9 * self._diagonal)

    def _cut(self, root: Entity) -> tuple[Any, ...]:
        """Return the parts that an entity in the world becomes: pairs of entity and pose, none if it is removed."""
        start = (root, Matrix(IDENTITY))
        stack = [start]
        while stack:  # instead of recursion, because graphs can be deeper than Python's stack
            entity, pose = stack[-1]
            key = (id(entity), pose)
            if key in self._known:
                stack.pop()
                continue
            side = self._side(entity, pose)
            if side != "met" or entity.is_primitive:
                whole = (Pair(entity, Matrix(IDENTITY)),)
                self._put(key, entity, whole if side == "kept" else self._opened(entity, pose) if side == "met" else ())
                continue
            below = [(part.car, compose(pose, part.cdr)) for part in entity.children]
            waiting = [state for state in below if (id(state[0]), state[1]) not in self._known]
            if waiting:
                stack.extend(waiting)
                continue
            parts = []
            for part, state in zip(entity.children, below, strict=True):
                parts += [Pair(one.car, part.cdr) for one in self._known[id(state[0]), state[1]]]
            self._put(key, entity, (Pair(rebuilt(entity, tuple(parts)), Matrix(IDENTITY)),) if parts else ())
        return self._known[id(root), start[1]]

    def _put(self, key: tuple[int, Matrix], entity: Entity, parts: tuple[Any, ...]) -> None:
        """Remember what an entity under a pose becomes."""
        self._keep.append(entity)
        self._known[key] = parts

    def _opened(self, entity: Entity, pose: Matrix) -> tuple[Any, ...]:
        """Return what is left of a primitive: its surface, and the face of the cut, each if there is one."""
        shape = entity.shape
        assert shape is not None
        shift = self._shifts[id(entity), pose]
        low, high = self._low + shift, self._high - shift
        parts = []
        rest = _clipped(_mesh(shape), pose, low, high)
        face = _filling(shape, pose, low, high) if has_volume(pose) else None
        if len(rest.faces):
            parts.append(_part(entity, shape, rest if face is not None else two_sided(shape, rest)))
        if face is not None:
            color = _face_color(_base_color(entity, shape))
            embedding = Embedding(None, None, {"color": Vector(color)})
            parts.append(Entity(entity.word, embedding, (), CutSurface(surface=face, color=color), entity.tainted))
        return tuple(Pair(part, Matrix(IDENTITY)) for part in parts)


def two_sided(shape: Primitive, mesh: Mesh) -> Mesh:
    """Return the mesh of a surface that may be open, as those of files: renderers draw the front of faces only."""
    if not shape.is_file:
        return mesh
    one = mesh.faceted()
    count = len(one.vertices)
    vertices, normals = np.concatenate([one.vertices] * 2), np.concatenate([one.shading, -one.shading])
    faces = np.concatenate([one.faces, one.faces[:, ::-1] + count])
    return Mesh(vertices, normals, faces, None if mesh.colors is None else np.concatenate([mesh.colors] * 2))


def _box_under(box: Box, pose: Sequence[float]) -> tuple[FloatArray, FloatArray]:
    """Return low and high (3,) of the box around a box under a pose."""
    matrix = np.array(pose).reshape(3, 4)
    center, half = (np.array(box[:3]) + box[3:]) / 2.0, (np.array(box[3:]) - box[:3]) / 2.0
    middle, reach = matrix[:, :3] @ center + matrix[:, 3], np.abs(matrix[:, :3]) @ half
    return middle - reach, middle + reach


def _mesh(shape: Primitive) -> Mesh:
    """Return the triangles of a primitive that is cut."""
    return shape.computed.mesh if isinstance(shape, SolidShape) else leaf_mesh(shape, _CUT_SEGMENTS)


def _base_color(entity: Entity, shape: Primitive) -> Point:
    """Return the color of a primitive; of one with a texture or several colors, their mean."""
    attributes = entity.embedding.attributes
    if attributes.get("texture") is not None:
        return look_of(entity).color
    if attributes.get("color") is None and attributes.get("material") is None:
        seed = shape.color_seed(entity.word, attributes)
        if seed is not None:
            return tint(*seed)
        colors = _mesh(shape).colors if isinstance(shape, SolidShape) or shape.is_file else None
        if colors is not None and len(colors):
            red, green, blue = np.asarray(colors, np.float64).mean(axis=0).tolist()
            return (red, green, blue)
    return shape.color


def _face_color(color: Point) -> Point:
    """Return the color of cut faces: darker and more saturated than that of the surface, linear sRGB."""
    mean = sum(color) / 3.0
    red, green, blue = (max(0.0, _SHADE * (mean + _SATURATION * (part - mean))) for part in color)
    return (red, green, blue)


def _part(entity: Entity, shape: Primitive, rest: Mesh) -> Entity:
    """Return a primitive with the part ``rest`` of its surface, and its own look; a texture has the size it had."""
    texture, embedding, color = look_of(entity).texture, entity.embedding, _base_color(entity, shape)
    if texture is not None:
        value = embedding.attributes["texture"]
        parts = (value,) if isinstance(value, str) else tuple(items_of(value) or ())
        scaled = {**embedding.attributes, "texture": (*parts, "scale", texture.scale)}
        embedding, color = Embedding(embedding.handle, embedding.text, scaled), shape.color
    surface = CutSurface(surface=rest, color=color, image=shape.image)
    return Entity(entity.word, embedding, (), surface, entity.tainted, entity.call_sites)


# --- clipping --------------------------------------------------------------------------------------------------------


def _clipped(mesh: Mesh, pose: Matrix, low: FloatArray, high: FloatArray) -> Mesh:
    """Return the part of a mesh, which has a pose, that is outside of the box from ``low`` to ``high`` in the world."""
    corners, matrix = mesh.corners, np.array(pose).reshape(3, 4)
    if mesh.normals is not None:
        corners = np.concatenate([corners, mesh.normals[mesh.faces]], axis=2)
    source = np.arange(len(corners))
    outside: list[tuple[Corners, npt.NDArray[np.int64]]] = []
    for axis in range(3):  # what is inside of all slabs so far is left for the next
        for sign, bound in ((1.0, low[axis]), (-1.0, high[axis])):
            distance = sign * (corners[:, :, :3] @ matrix[axis, :3] + matrix[axis, 3] - bound)
            outside.append(_beyond(corners, source, -distance, -distance >= 0.0))
            corners, source = _beyond(corners, source, distance, distance > 0.0)
    kept, origin = (np.concatenate(arrays) for arrays in zip(*outside, strict=True))
    normals = None
    if mesh.normals is not None:
        normals = kept[:, :, 3:].reshape(-1, 3)
        length = np.linalg.norm(normals, axis=1, keepdims=True)
        normals = normals / np.where(length > 0.0, length, 1.0)
    faces = np.arange(3 * len(kept)).reshape(-1, 3)
    colors = None if mesh.colors is None else mesh.colors[origin]
    part = None if mesh.part is None else mesh.part[origin]
    return Mesh(kept[:, :, :3].reshape(-1, 3), normals, faces, colors, part, mesh.part_words)


def _beyond(
    corners: Corners, source: npt.NDArray[np.int64], distance: FloatArray, above: npt.NDArray[np.bool_]
) -> tuple[Corners, npt.NDArray[np.int64]]:
    """Return the parts of triangles where ``distance`` (F, 3) at their corners is positive, with their sources (F,).

    ``above`` (F, 3) is where that is so, with or without the corners on the plane.

    Where one corner is beyond, a triangle is left; where two are, a quadrilateral, which is split in two
    (Sutherland and Hodgman, 1974).
    """
    count = above.sum(axis=1)
    pieces, origins = [corners[count == 3]], [source[count == 3]]
    for number in (1, 2):
        rows = np.flatnonzero(count == number)
        if not len(rows):
            continue
        # The corner that is alone on its side comes first; the order around the triangle stays.
        alone = np.argmax(above[rows] if number == 1 else ~above[rows], axis=1)
        order = (alone[:, None] + np.arange(3)) % 3
        triangle = np.take_along_axis(corners[rows], order[:, :, None], axis=1)
        at = np.take_along_axis(distance[rows], order, axis=1)
        first, second, third = triangle[:, 0], triangle[:, 1], triangle[:, 2]
        to_second = first + (second - first) * (at[:, 0] / (at[:, 0] - at[:, 1]))[:, None]
        to_third = first + (third - first) * (at[:, 0] / (at[:, 0] - at[:, 2]))[:, None]
        if number == 1:
            pieces.append(np.stack([first, to_second, to_third], axis=1))
            origins.append(source[rows])
        else:
            pieces += [np.stack([to_second, second, third], axis=1), np.stack([to_second, third, to_third], axis=1)]
            origins += [source[rows], source[rows]]
    return np.concatenate(pieces), np.concatenate(origins)


def _filling(shape: Primitive, pose: Matrix, low: FloatArray, high: FloatArray) -> Mesh | None:
    """Return the faces that a cut of a closed primitive leaves; None for open and flat ones, and without such faces."""
    if shape.is_flat or not shape.has_geometry:
        return None
    if isinstance(shape, SolidShape):
        solid = shape.expression
    else:
        solid = Expression(PRIMITIVE, {"segments": _CUT_SEGMENTS}, (), shape, "surface", shape.color)
    matrix = np.eye(4)
    matrix[:3] = np.array(pose).reshape(3, 4)
    box = np.eye(4)
    box[:3] = np.column_stack([np.diag(high - low), (low + high) / 2.0])
    local = np.linalg.solve(matrix, box)
    tool = Expression(PRIMITIVE, {}, (), Cube(), _TOOL)
    operands = (Operand(solid, tuple(IDENTITY)), Operand(tool, tuple(local[:3].reshape(-1).tolist())))
    try:
        surface = surface_of(Expression("difference", operands=operands, word="surface"))
    except SceneError:  # an open mesh, or one that crosses itself
        return None
    if surface is None or _TOOL not in surface.mesh.part_words:
        return None
    mesh = surface.mesh
    if mesh.part is None:
        return None
    faces = mesh.faces[mesh.part == mesh.part_words.index(_TOOL)]
    return Mesh(mesh.vertices, None, faces) if len(faces) else None
