"""Plan of an export: the entity DAG, with some entities marked to be merged into one mesh, and triangle surfaces.

An ``ExportItem`` is a distinct entity in one role. ``--depth N`` marks the entities at level N (the root is level 0),
so that each becomes one part; ``--instance-limit`` marks repeated small subtrees, so that a strict tree of nodes stays
small (``cut_below``). Items are shared like entities.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping, Sequence, Set
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from scenelang.backends.base import frame_of
from scenelang.backends.surfaces.appearance import Look, check_seen, look_of
from scenelang.backends.surfaces.contraction import contracted, crowded_edges
from scenelang.backends.surfaces.precision import Copies, about, chunks_of, own_offset
from scenelang.backends.surfaces.solids import coordinates_of, keeps_own_colors, own_mesh
from scenelang.backends.surfaces.stand_ins import drawn_scene
from scenelang.backends.surfaces.tiles import coordinates, corner_coordinates, pictured
from scenelang.backends.surfaces.unwrapping import divided
from scenelang.grammar.diagnostics import Diagnostic, LimitError, SceneError
from scenelang.interpreter.scene.bounds import entity_box
from scenelang.interpreter.scene.entity import Entity, Scene, descendants, instance_counts, primitive_count
from scenelang.interpreter.scene.flatten import flatten_entity
from scenelang.interpreter.scene.modelling.computing import welded
from scenelang.interpreter.scene.part_columns import distinct_entities
from scenelang.interpreter.scene.primitives import Primitive
from scenelang.interpreter.scene.primitives.forms import CanonicalForm
from scenelang.interpreter.scene.primitives.mesh import Mesh, posed_points
from scenelang.interpreter.scene.primitives.textures import Texture
from scenelang.interpreter.scene.setup import Setup
from scenelang.interpreter.values.values import IDENTITY, Matrix

MAX_NODES = 1_000_000  # of a strict tree
_MAX_COORDINATE = 1e30  # below the maximum of single precision, with a margin for products


@dataclass(frozen=True, slots=True, eq=False)
class ExportItem:
    """Entity to export; ``parts`` are pairs of item and pose. ``merged``: the whole subtree becomes one mesh."""

    entity: Entity
    parts: tuple[tuple[ExportItem, Matrix], ...] = ()
    merged: bool = False

    @property
    def word(self) -> str:
        """Word of the entity."""
        return self.entity.word

    @property
    def is_leaf(self) -> bool:
        """Whether the item is a single mesh."""
        return self.merged or self.entity.is_primitive


@dataclass(frozen=True, slots=True, eq=False)
class ExportPlan:
    """The items of every exported frame; ``animated`` if they are the frames of a 4D scene.

    ``setup`` is what the program declares of cameras and lights.
    """

    word: str
    roots: tuple[ExportItem, ...]
    animated: bool
    setup: Setup = ()


def planned(
    scene: Scene,
    frame: int | None = None,
    depth: int | None = None,
    limit: int = 2_000_000,
    warn: Callable[[Diagnostic], None] | None = None,
) -> ExportPlan:
    """Return the export plan of ``scene`` with blocks converted to cubes.

    Parameters
    ----------
    frame : int, optional
        Zero-based; by default all frames.
    depth : int, optional
        Level at which entities are merged; by default none.
    limit, warn
        As for ``drawn_scene``.

    Raises
    ------
    SceneError
        "value" if the frame does not exist, "empty-scene" if nothing has geometry, "pose" if coordinates are too large.
    """
    scene = drawn_scene(chosen(scene, frame), limit, warn)
    heights = _heights(scene.frames)
    cut = {id(root): math.inf if depth is None else depth for root in scene.frames}
    items = _Items(heights)
    roots = tuple(items.of(root, cut[id(root)]) for root in scene.frames)
    return ExportPlan(scene.word, roots, len(roots) > 1, scene.setup)


def chosen(scene: Scene, frame: int | None) -> Scene:
    """Return ``scene``, or its single frame ``frame``, if it can be exported; raises SceneError as ``planned`` does."""
    roots = scene.frames if frame is None else (scene.frames[frame_of(scene, frame)],)
    boxes = [box for box in map(entity_box, roots) if box is not None]
    if not boxes:
        raise SceneError("empty-scene", f'the scene "{scene.word}" has no primitives, so there is nothing to export')
    if not all(abs(number) < _MAX_COORDINATE for box in boxes for number in box):
        raise SceneError("pose", "pose overflow: coordinates exceed the range of single precision")
    check_seen(scene)
    return scene.with_frames(roots, scene.animated and frame is None)


class _Items:
    """Creates items, one for each distinct entity and number of remaining levels above the cut."""

    def __init__(self, heights: Mapping[int, int]) -> None:
        self._heights = heights
        self._made: dict[tuple[int, float], ExportItem] = {}

    def of(self, root: Entity, levels: float) -> ExportItem:
        """Return the item of ``root`` with its descendants ``levels`` below it merged; no recursion."""
        stack = [(root, levels)]
        while stack:
            entity, left = stack[-1]
            key = self._key(entity, left)
            if key in self._made:
                stack.pop()
                continue
            waiting = [] if left <= 0 else self._missing(entity, left - 1)
            if waiting:
                stack.extend(waiting)
                continue
            stack.pop()
            self._made[key] = self._item(entity, left)
        return self._made[self._key(root, levels)]

    def _key(self, entity: Entity, levels: float) -> tuple[int, float]:
        """Return the cache key of an entity; levels beyond its height do not matter."""
        return id(entity), (levels if levels < self._heights[id(entity)] else math.inf)

    def _missing(self, entity: Entity, levels: float) -> list[tuple[Entity, float]]:
        """Return the children of an entity that have no item yet."""
        return [
            (child, levels)
            for child in distinct_entities(entity.children)
            if self._key(child, levels) not in self._made
        ]

    def _item(self, entity: Entity, levels: float) -> ExportItem:
        """Return the item of an entity whose children have items."""
        if levels <= 0 and entity.children:
            return ExportItem(entity, merged=True)
        distinct_children = distinct_entities(entity.children)
        child_items = {id(child): self._made[self._key(child, levels - 1)] for child in distinct_children}
        return ExportItem(entity, tuple([(child_items[id(part.car)], part.cdr) for part in entity.children]))


def _heights(roots: Iterable[Entity]) -> dict[int, int]:
    """Return the number of levels below each distinct entity, 0 for a leaf."""
    heights: dict[int, int] = {}
    for entity in descendants(*roots):
        heights[id(entity)] = 1 + max((heights[id(child)] for child in distinct_entities(entity.children)), default=-1)
    return heights


# --- items as a DAG --------------------------------------------------------------------------------------------


def distinct(*roots: ExportItem) -> Iterator[ExportItem]:
    """Yield every distinct item below and including ``roots``, children before parents."""
    visited: set[int] = set()
    for root in roots:
        stack = [(root, iter(root.parts))] if id(root) not in visited else []
        visited.add(id(root))
        while stack:
            item, parts = stack[-1]
            for child, _ in parts:
                if id(child) not in visited:
                    visited.add(id(child))
                    stack.append((child, iter(child.parts)))
                    break
            else:
                stack.pop()
                yield item


def sizes(roots: Sequence[ExportItem]) -> dict[int, int]:
    """Return the number of instances below and including each distinct item."""
    counts: dict[int, int] = {}
    for item in distinct(*roots):
        counts[id(item)] = 1 + sum([counts[id(child)] for child, _ in item.parts])
    return counts


def cut_below(plan: ExportPlan, limit: int) -> ExportPlan:
    """Merge the smallest repeated subtrees of ``plan`` so that every frame has at most ``limit`` nodes.

    All subtrees of at most T instances that occur in several places are merged, with the smallest sufficient power of
    two T, so that merged parts are small and the hierarchy above them is preserved. Subtrees that occur once are not
    merged, which would make the file larger. Raises LimitError if more than ``MAX_NODES`` remain.
    """
    counts = sizes(plan.roots)
    most = max(counts[id(root)] for root in plan.roots)
    if most <= limit:
        return plan
    repeated = {key for key in _repeated(plan.roots) if counts[key] > 1}  # a single node cannot become fewer
    threshold = 2
    nodes = most
    while repeated and (nodes := _nodes(plan.roots, counts, repeated, threshold)) > limit and threshold < most:
        threshold *= 2
    if nodes > max(limit, MAX_NODES):
        raise LimitError(
            "primitives",
            f"the scene needs {nodes:,} nodes, more than the limit of {MAX_NODES:,} for a file",
            hint="merge parts with --depth N, or write .usd",
        )
    return _merged_below(plan, counts, repeated, threshold) if repeated else plan


def _repeated(roots: Sequence[ExportItem]) -> set[int]:
    """Return the ids of the items that occur in several places of one frame."""
    repeated: set[int] = set()
    for root in {id(root): root for root in roots}.values():
        order = list(distinct(root))
        places = dict.fromkeys((id(item) for item in order), 0)
        places[id(root)] = 1
        for item in reversed(order):
            for child, _ in item.parts:
                places[id(child)] += places[id(item)]
        repeated.update(key for key, count in places.items() if count > 1)
    return repeated


def _nodes(roots: Sequence[ExportItem], counts: Mapping[int, int], repeated: Set[int], threshold: int) -> int:
    """Return the number of nodes of the largest frame if repeated subtrees of at most ``threshold`` instances are
    merged."""
    nodes: dict[int, int] = {}
    for item in distinct(*roots):
        is_one = counts[id(item)] <= threshold and id(item) in repeated
        nodes[id(item)] = 1 if is_one else 1 + sum(nodes[id(child)] for child, _ in item.parts)
    return max(nodes[id(root)] for root in roots)


def _merged_below(plan: ExportPlan, counts: Mapping[int, int], repeated: Set[int], threshold: int) -> ExportPlan:
    """Return the plan with repeated subtrees of at most ``threshold`` instances merged."""
    new_items: dict[int, ExportItem] = {}
    for item in distinct(*plan.roots):
        if item.is_leaf or not item.parts:
            new_items[id(item)] = item
        elif counts[id(item)] <= threshold and id(item) in repeated:
            new_items[id(item)] = ExportItem(item.entity, merged=True)
        else:
            new_items[id(item)] = ExportItem(
                item.entity, tuple((new_items[id(child)], pose) for child, pose in item.parts)
            )
    return ExportPlan(plan.word, tuple(new_items[id(root)] for root in plan.roots), plan.animated, plan.setup)


# --- surfaces ---------------------------------------------------------------------------------------------------------


FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]

SEGMENTS = 64  # sides of a full circle by default
# of the largest coordinate about a body's own center: some steps of single precision (2^-23 = 1.2e-7)
_MIN_EDGE_RATIO = 5e-7


@dataclass(frozen=True, slots=True, eq=False)
class ExportSurface:
    """Triangle mesh with normals.

    Attributes
    ----------
    vertices, normals : (V, 3)
        Points and unit normals.
    faces : (F, 3)
        Vertex numbers, counter-clockwise seen from outside.
    colors : (V, 3), optional
        Linear sRGB, which multiply the look's color.
    joints : (F, 3), optional
        Points of the closed surface at each corner; None if equal positions are equal points.
    face_colors : (F, 3), optional
        Colors of the faces of a surface whose faces share points (``shared``), whose ``colors`` are means.
    uv : (V, 2), optional
        Coordinates in a texture, in periods: u to the right, v upwards.
    chart : (V, 2), optional
        Texture coordinates of a mesh file.
    """

    vertices: FloatArray
    normals: FloatArray
    faces: IntArray
    colors: FloatArray | None = None
    joints: IntArray | None = None
    face_colors: FloatArray | None = None
    uv: FloatArray | None = None
    chart: FloatArray | None = None

    def under(self, matrices: FloatArray) -> ExportSurface:
        """Return copies of the surface under the poses (K, 3, 4), concatenated."""
        vertices, normals, mirrored = self.copies(matrices)
        faces = np.where(mirrored[:, None, None], self.faces[:, ::-1], self.faces)
        faces = faces + (np.arange(len(matrices)) * len(self.vertices))[:, None, None]
        colors, uv = (
            None if values is None else np.tile(values, (len(matrices), 1)) for values in (self.colors, self.uv)
        )
        return ExportSurface(vertices.reshape(-1, 3), normals.reshape(-1, 3), faces.reshape(-1, 3), colors, uv=uv)

    def textured(self, texture: Texture, place: Matrix) -> ExportSurface:
        """Return the surface with coordinates in a texture; ``place`` brings it into the frame of its primitive.

        Every face has its own corners, because faces with one vertex may have different coordinates there. Faces are
        divided where coordinates are not linear between their corners.
        """
        if texture.projection == "uv":
            return self._by_own_coordinates(texture)
        pose = np.array(place, np.float64).reshape(3, 4)
        rows = [self.vertices @ pose[:, :3].T + pose[:, 3], self.vertices, self.normals]
        corners = divided(texture, np.concatenate(rows, axis=1)[self.faces])
        uv = corner_coordinates(texture, corners[:, :, :3]).reshape(-1, 2)
        flat = corners.reshape(-1, 9)
        joints = self.joints if len(corners) == len(self.faces) else None
        faces = np.arange(len(flat)).reshape(-1, 3)
        return ExportSurface(flat[:, 3:6], _unit_normals(flat[:, 6:]), faces, joints=joints, uv=uv)

    def _by_own_coordinates(self, texture: Texture) -> ExportSurface:
        """Return the surface with the texture coordinates of its file."""
        assert self.chart is not None, "solid_of refuses mesh files without coordinates"
        points = np.concatenate([self.chart, np.zeros((len(self.chart), 1))], axis=1)
        return replace(self, uv=coordinates(texture, points, points), colors=None)

    def moved(self, offset: FloatArray) -> ExportSurface:
        """Return the surface translated by an offset (3,)."""
        return replace(self, vertices=self.vertices + offset)

    def copies(self, matrices: FloatArray) -> tuple[FloatArray, FloatArray, npt.NDArray[np.bool_]]:
        """Return vertices and unit normals (K, V, 3) under the poses (K, 3, 4), and which poses mirror (K,)."""
        vertices, normals, mirrored = posed_points(self.vertices, self.normals, matrices)
        doubtful = np.abs(np.einsum("kvi,kvi->kv", normals, normals) - 1.0) > 1e-9
        doubtful |= ~np.isfinite(normals).all(axis=2)
        if doubtful.any():
            normals[doubtful] = _unit_normals(normals[doubtful])
        return vertices, normals, mirrored


def points_of(surface: ExportSurface) -> tuple[FloatArray, IntArray, IntArray]:
    """Return the points of a surface, the faces between them, and the original number of each face.

    Points of a computed solid at one place stay separate where the solid only touches itself.
    """
    if surface.joints is None:
        return welded(surface.vertices, surface.faces)
    _, first, place = np.unique(surface.joints, return_index=True, return_inverse=True)
    faces = place.reshape(surface.faces.shape)
    return surface.vertices[surface.faces.ravel()[first]], faces, np.arange(len(faces))


def _closed(surface: ExportSurface) -> tuple[FloatArray, IntArray, IntArray]:
    """Return points, faces and original face numbers of a surface that is closed by its point numbers alone."""
    points, faces, face_numbers = points_of(surface)
    return contracted(points, faces, face_numbers, _MIN_EDGE_RATIO * float(np.abs(points).max(initial=0.0)))


def crowded_edges_of(surface: ExportSurface) -> int:
    """Return the number of edges of a body with more than two faces for readers that join equal points."""
    return crowded_edges(*_closed(surface)[:2])


def shared(surface: ExportSurface) -> ExportSurface:
    """Return the surface with one vertex for each point, so that it is closed by its numbers alone.

    Points that single precision cannot tell apart about the origin of the surface are merged, so that it stays closed
    for readers that weld equal positions (``contracted``). The normal and the color of a point are means over the faces
    around it, weighted by the angles of their corners (Thürmer and Wüthrich, "Computing vertex normals from polygonal
    facets", 1998).
    """
    points, faces, face_numbers = _closed(surface)
    corners = points[faces]
    ahead, back = np.roll(corners, -1, axis=1) - corners, np.roll(corners, 1, axis=1) - corners
    turn = np.cross(ahead, back)
    angles = np.arctan2(np.linalg.norm(turn, axis=2), np.einsum("fci,fci->fc", ahead, back))[:, :, None]

    def around(values: FloatArray) -> FloatArray:
        """Return the weighted sum (V, 3) of values at corners, which are (F, 1, 3)."""
        weighted = (values * angles).reshape(-1, 3)
        sums = [np.bincount(faces.ravel(), weighted[:, axis], len(points)) for axis in range(3)]
        return np.stack(sums, axis=1).astype(np.float64)  # `bincount` of nothing gives integers

    normals = _unit_normals(around(_unit_normals(turn[:, 0])[:, None]))
    if surface.colors is None:
        return ExportSurface(points, normals, faces, None, faces)
    painted = surface.colors[surface.faces[face_numbers, 0]]
    weights = around(np.ones((len(faces), 1, 3)))
    sums = around(painted[:, None])
    colors = np.divide(sums, weights, out=np.ones_like(sums), where=weights > 0.0)
    return ExportSurface(points, normals, faces, colors, faces, painted)


def surface_of(entity: Entity, segments: int = SEGMENTS) -> ExportSurface | None:
    """Return the triangles of a primitive, None if it is invisible (removed blocks, a cylinder of zero length).

    Round primitives have ``segments`` sides and vertices on the exact surface. A mesh file's own colors are used
    unless the primitive has a ``:color``. Raises SceneError for unreadable files.
    """
    solid = solid_of(entity)
    return None if solid is None else solid.own_surface(segments)


def vertex_count(entity: Entity, segments: int) -> int:
    """Return the approximate number of vertices of ``surface_of``."""
    shape = entity.shape
    placed = None if shape is None else shape.placed()
    if placed is not None:
        return placed.form.vertex_count(segments, placed.ratios)
    mesh = None if shape is None else own_mesh(shape)
    return 0 if mesh is None else 3 * len(mesh.faces)


def is_round(shape: Primitive) -> bool:
    """Return whether the shape's surface depends on the number of sides."""
    placed = shape.placed()
    return placed is not None and placed.form.is_curved


def _of_mesh(mesh: Mesh, *, own_colors: bool) -> ExportSurface:
    """Return the surface of a mesh; if it has colors or no normals, its triangles share no vertices."""
    if mesh.normals is not None and not own_colors:
        return ExportSurface(mesh.vertices, _unit_normals(mesh.normals), mesh.faces, joints=mesh.joints)
    corners = mesh.corners
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    flat = np.repeat(_unit_normals(normals), 3, axis=0)
    shading = flat if mesh.normals is None else _unit_normals(mesh.normals[mesh.faces].reshape(-1, 3))
    colors = None if mesh.colors is None or not own_colors else np.repeat(mesh.colors, 3, axis=0)
    faces = np.arange(3 * len(corners)).reshape(-1, 3)
    chart = None if mesh.uv is None else mesh.uv.reshape(-1, 2)
    return ExportSurface(corners.reshape(-1, 3), shading, faces, colors, mesh.joints, chart=chart)


def _unit_normals(normals: FloatArray) -> FloatArray:
    """Normalize ``normals``; degenerate ones point up."""
    largest = np.abs(normals).max(axis=1, keepdims=True, initial=0.0)
    sound = np.isfinite(largest[:, 0]) & (largest[:, 0] > 0.0)
    out = np.where(sound[:, None], normals / np.where(sound[:, None], largest, 1.0), (0.0, 1.0, 0.0))
    unit: FloatArray = out / np.linalg.norm(out, axis=1, keepdims=True)
    return unit


COAT_ROUGHNESS = 0.05  # of varnish, as final images have it

# --- shared meshes -----------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Solid:
    """A primitive as a shared mesh and the pose (12 floats) that places it in the primitive's frame.

    ``form`` is the canonical form with the ``ratios``, whose surface is ``unit_surface``. It is None if ``shape`` has
    its own surface: a mesh, or a flat primitive, whose normals cannot be derived from a form's. A mesh that is too far
    from its origin for single precision is stored about its center, to which ``pose`` brings it. ``own_colors``: use
    those of the mesh.
    """

    form: CanonicalForm | None
    ratios: tuple[float, ...]
    shape: Primitive
    pose: Matrix
    own_colors: bool = False

    @property
    def key(self) -> Hashable:
        """Cache key of the shared mesh."""
        return (self.form, self.ratios) if self.form is not None else (self.shape.key, self.own_colors)

    def key_in(self, texture: Texture | None) -> Hashable:
        """Return the cache key of the shared mesh with coordinates in a texture, which depend on the pose."""
        return self.key if texture is None else (self.key, texture, self.pose)

    def key_with(self, look: Look) -> Hashable:
        """Return the cache key of the shared mesh with a look."""
        return self.key_in(look.texture), look

    def surface(self, segments: int = SEGMENTS, texture: Texture | None = None) -> ExportSurface | None:
        """Return the triangles of the shared mesh, without the pose; with coordinates in a texture if one is given."""
        if self.form is not None:
            surface: ExportSurface | None = unit_surface(self.form, self.ratios, segments)
        else:
            surface = self.own_surface(segments)
            if surface is not None and self.pose is not IDENTITY:
                surface = surface.moved(-np.array(self.pose[3::4]))
        return surface if surface is None or texture is None else surface.textured(texture, self.pose)

    def own_surface(self, segments: int = SEGMENTS) -> ExportSurface | None:
        """Return the triangles in the primitive's frame; None if there are none, as of an empty solid."""
        placed = self.shape.placed()
        if placed is not None:
            return unit_surface(placed.form, placed.ratios, segments).under(placed.matrix[None])
        mesh = own_mesh(self.shape)
        return _of_mesh(mesh, own_colors=self.own_colors) if mesh is not None and len(mesh.faces) else None


def as_material(look: Look) -> Look:
    """Return a look without where its texture is, which meshes have as coordinates: equal ones are one material.

    The depth of a relief belongs to the material.
    """
    texture = look.texture
    if texture is None:
        return look
    plain = pictured(texture)
    return replace(look, texture=replace(plain, bump=texture.bump, scale=texture.scale) if texture.bump else plain)


def solid_of(entity: Entity) -> Solid | None:
    """Return the solid of a primitive, None if it is invisible.

    Raises SceneError for a mesh file without the texture coordinates that the primitive's texture needs.
    """
    shape = entity.shape
    if shape is None:
        return None
    placed = shape.placed()
    if placed is None:
        mesh = own_mesh(shape)
        if mesh is None:
            return None
        texture = look_of(entity).texture
        if texture is not None and texture.projection == "uv":
            coordinates_of(entity, mesh)  # which says if it has none
        offset = own_offset(mesh.vertices, mesh.faces)
        return Solid(None, (), shape, translation(offset), keeps_own_colors(entity, mesh))
    if not np.linalg.det(placed.matrix[:, :3]):
        return Solid(None, (), shape, IDENTITY)
    return Solid(placed.form, placed.ratios, shape, Matrix(placed.rows))


def translation(offset: FloatArray | None) -> Matrix:
    """Return the pose that translates by an offset (3,), the identity without one."""
    if offset is None:
        return IDENTITY
    x, y, z = offset.tolist()
    return Matrix((1.0, 0.0, 0.0, x, 0.0, 1.0, 0.0, y, 0.0, 0.0, 1.0, z))


def unit_surface(form: CanonicalForm, ratios: tuple[float, ...], segments: int = SEGMENTS) -> ExportSurface:
    """Return the triangles of the canonical form."""
    mesh = form.mesh(segments, ratios)
    return ExportSurface(mesh.vertices, mesh.shading, mesh.faces)


# Merged meshes of everything below an entity, for ``--depth`` and ``--instance-limit``.


MAX_VERTICES = 24_000_000  # of a file
WHITE = (1.0, 1.0, 1.0)  # color of a look whose surface has vertex colors
# sides of full circles that are tried, in this order, until the file fits
_SIDE_CHOICES = (SEGMENTS, 48, 32, 24, 16, 12, 8)


@dataclass(frozen=True, slots=True, eq=False)
class Patch:
    """The triangles of one material; the look's color is white if ``surface.colors`` (V, 3) contains it.

    ``pose`` translates the surface to its place, if it is too far from the origin for single precision.
    """

    look: Look
    surface: ExportSurface
    pose: Matrix = IDENTITY


def merged(
    entity: Entity, segments: int = SEGMENTS, tolerance: float | None = None, by_depth: bool = False
) -> tuple[Patch, ...]:
    """Return all primitives below ``entity``, in its frame, as patches, one per material, ignoring color.

    Where single precision cannot hold all copies of a material in one frame, they are several patches with poses. With
    a ``tolerance`` of the entity's frame, every copy has the sides that it needs; raises LimitError if they are too
    many. ``by_depth`` gives the reliefs of textures the depth that they have in that frame.
    """
    frame = flatten_entity(entity, snap_blocks=False)
    copies: dict[Look, list[tuple[Look, ExportSurface, FloatArray]]] = {}
    remaining = MAX_VERTICES
    for number, primitive in enumerate(frame.primitives):
        look = look_of(primitive)
        if look.opacity == 0.0:
            continue
        matrices = np.asarray(frame.matrices[frame.index == number])
        sides = np.full(len(matrices), segments)
        if tolerance is not None:
            sides = sides_within(primitive, matrices, tolerance)
        for count in np.unique(sides).tolist():
            surface = surface_of(primitive, count)
            if surface is None:
                continue
            if look.texture is not None:
                surface = surface.textured(look.texture, IDENTITY)
            copies_of_count = matrices[sides == count]
            remaining -= len(copies_of_count) * len(surface.vertices)
            if remaining < 0:
                raise too_fine(entity.word)
            groups = deepened(look, copies_of_count) if by_depth else ((look, copies_of_count),)
            for shown, chosen in groups:
                shared_look = as_material(shown) if shown.texture is not None else replace(shown, color=WHITE)
                copies.setdefault(shared_look, []).append((shown, surface, chosen))
    return tuple(patch for look, parts in copies.items() for patch in _patches(look, parts))


def deepened(look: Look, matrices: FloatArray) -> Iterator[tuple[Look, FloatArray]]:
    """Yield poses (K, 3, 4) with equal growth of lengths, each with the look whose relief is as deep as under them."""
    if look.texture is None or not look.texture.bump:
        yield look, matrices
        return
    growth = np.abs(np.linalg.det(matrices[:, :, :3])) ** (1.0 / 3.0)
    rounded = np.array([float(f"{value:.3g}") for value in growth.tolist()])
    for value in np.unique(rounded).tolist():
        yield replace(look, texture=replace(look.texture, bump=look.texture.bump * value)), matrices[rounded == value]


def _patches(shared_look: Look, parts: Sequence[tuple[Look, ExportSurface, FloatArray]]) -> Iterator[Patch]:
    """Yield copies of surfaces under poses (K, 3, 4) as joined patches, in groups that single precision can hold."""
    every = Copies.joined([Copies.of(surface.vertices, surface.faces, matrices) for _, surface, matrices in parts])
    ends = np.cumsum([len(matrices) for _, _, matrices in parts])
    for rows, offset in chunks_of(every):
        surfaces = []
        for (look, surface, matrices), end in zip(parts, ends.tolist(), strict=True):
            chosen = matrices[rows[(rows >= end - len(matrices)) & (rows < end)] - (end - len(matrices))]
            if len(chosen):
                surfaces.append(_painted(surface.under(about(chosen, offset)), look))
        yield Patch(shared_look, joined(surfaces), translation(offset) if offset.any() else IDENTITY)


def sides_within(entity: Entity, worlds: FloatArray, tolerance: float) -> IntArray:
    """Return the sides of full circles of a primitive for which its mesh is within ``tolerance`` under each of the
    poses (K, 3, 4)."""
    placed = None if entity.shape is None else entity.shape.placed()
    if placed is None:
        return np.full(len(worlds), SEGMENTS)
    radii = np.linalg.norm(worlds[:, :, :3] @ placed.matrix[:, :3], 2, axis=(1, 2))
    distinct_radii, place = np.unique(radii, return_inverse=True)
    sides = [placed.form.segments_within(tolerance, radius) for radius in distinct_radii.tolist()]
    return np.array(sides, np.int64)[place]


def too_fine(word: str) -> LimitError:
    """Return the error for a tolerance that needs too many vertices."""
    message = f'"{word}" would have more than the limit of {MAX_VERTICES:,} vertices'
    return LimitError("size", message, hint="give a larger --tolerance, or --segments")


def _painted(surface: ExportSurface, look: Look) -> ExportSurface:
    """Return the surface with the look's color on every vertex, unless a texture has it."""
    if look.texture is not None:
        return surface
    surface_colors = np.ones((len(surface.vertices), 3)) if surface.colors is None else surface.colors
    return replace(surface, colors=surface_colors * np.array(look.color))


def joined(surfaces: Sequence[ExportSurface]) -> ExportSurface:
    """Concatenate surfaces, all of which have colors or all of which have coordinates in one texture."""
    uv = [surface.uv for surface in surfaces if surface.uv is not None]
    if len(surfaces) == 1:
        return surfaces[0]
    starts = np.cumsum([0, *(len(surface.vertices) for surface in surfaces)])
    colors = [np.ones_like(s.vertices) if s.colors is None else s.colors for s in surfaces]
    return ExportSurface(
        np.concatenate([surface.vertices for surface in surfaces]),
        np.concatenate([surface.normals for surface in surfaces]),
        np.concatenate([surface.faces + start for surface, start in zip(surfaces, starts, strict=False)]),
        None if uv else np.concatenate(colors),
        uv=np.concatenate(uv) if uv else None,
    )


def segments_for(
    entities: Sequence[Entity], what: str, hint: str | None = None, counts: Sequence[int] | None = None
) -> int:
    """Return the largest number of sides of round primitives for which the merged ``entities`` fit a file.

    ``what`` names the file in the message, ``hint`` is the hint of the error. Entity ``i`` occurs ``counts[i]`` times,
    by default once. Raises LimitError.
    """
    shapes = _primitives_in(entities, [1] * len(entities) if counts is None else counts, what, hint)
    for segments in _SIDE_CHOICES:
        total = sum(count * vertex_count(primitive, segments) for primitive, count in shapes)
        if total <= MAX_VERTICES:
            return segments
        if not any(p.shape is not None and is_round(p.shape) for p, _ in shapes):
            break
    raise LimitError(
        "primitives", f"{what} would have {total:,} vertices, more than the limit of {MAX_VERTICES:,}", hint=hint
    )


def _primitives_in(
    entities: Sequence[Entity], counts: Sequence[int], what: str, hint: str | None
) -> list[tuple[Entity, int]]:
    """Return the primitives below the entities with the numbers of their instances."""
    total = sum(count * primitive_count(entity) for entity, count in zip(entities, counts, strict=True))
    if 3 * total > MAX_VERTICES:  # check before anything is expanded
        raise LimitError("primitives", f"{what} would have {total:,} primitives, more than the limit", hint=hint)
    primitives: list[tuple[Entity, int]] = []
    for entity, times in zip(entities, counts, strict=True):
        order = list(descendants(entity))
        instances = instance_counts(order)
        primitives.extend((one, times * instances[id(one)]) for one in order if one.is_primitive)
    return primitives
