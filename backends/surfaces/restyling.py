"""Scenes in another style, as transformations of the entity graph: in clay, as triangles, and mesh files by image."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache

import numpy as np

from scenelang.backends.surfaces.appearance import look_of
from scenelang.backends.surfaces.cuts import CutSurface, two_sided
from scenelang.backends.surfaces.solids import keeps_own_colors, own_mesh
from scenelang.backends.surfaces.stand_ins import drawn_scene
from scenelang.grammar.datum import dataclass, replace
from scenelang.grammar.diagnostics import Diagnostic
from scenelang.interpreter.scene.entity import Entity, Scene, descendants
from scenelang.interpreter.scene.exploding import with_frames
from scenelang.interpreter.scene.modelling.computing import leaf_mesh
from scenelang.interpreter.scene.modelling.solid import SolidShape
from scenelang.interpreter.scene.primitives.base import MATERIALS, WHITE
from scenelang.interpreter.scene.primitives.mesh import Mesh
from scenelang.interpreter.scene.primitives.mesh_file import MeshFile
from scenelang.interpreter.scene.primitives.textures import Texture
from scenelang.interpreter.values.values import IDENTITY, Embedding, Pair, Vector

Warn = Callable[[Diagnostic], None]

_CLAY = (0.58, 0.53, 0.48)  # linear sRGB
_WIREFRAME_SEGMENTS = 24  # sides of full circles of a wireframe: few enough to tell its lines apart


def in_clay(scene: Scene, limit: int, warn: Warn | None) -> Scene:
    """Return a scene whose surfaces are all matte, of one color, and opaque unless they are invisible.

    ``limit`` and ``warn`` are those of ``drawn_scene``.
    """

    def molded(entity: Entity) -> Entity:
        """Return a primitive in clay."""
        own, shape = entity.embedding, entity.shape
        look = {name: value for name, value in own.attributes.items() if name not in _LOOK}
        if own.attributes.get("opacity") == 0:
            look["opacity"] = 0.0
        embedding = Embedding(own.handle, own.text, {**look, "color": Vector(_CLAY)})
        shape = None if shape is None else replace(shape, color=_CLAY, image=None)
        return Entity(entity.word, embedding, entity.children, shape, entity.tainted, entity.call_sites)

    drawn = drawn_scene(scene, limit, warn)
    return with_frames(drawn, _with_primitives(drawn.frames, molded))


_LOOK = frozenset(attribute.name for attribute in MATERIALS)


def in_mean_colors(scene: Scene) -> Scene:
    """Return a scene whose shapes have the colors of their substances and the mean colors of their textures."""

    def plain(entity: Entity) -> Entity:
        """Return a primitive whose shape has one color; one without a substance or a texture as it is."""
        shape, attributes = entity.shape, entity.embedding.attributes
        if shape is None or all(attributes.get(name) is None for name in ("material", "texture")):
            return entity
        own, color = entity.embedding, look_of(entity).color
        embedding = Embedding(own.handle, own.text, {**attributes, "color": Vector(color)})
        return Entity(entity.word, embedding, (), replace(shape, color=color), entity.tainted, entity.call_sites)

    return with_frames(scene, _with_primitives(scene.frames, plain))


def in_triangles(scene: Scene, limit: int, warn: Warn | None) -> Scene:
    """Return a scene whose primitives are the triangles of their surfaces.

    ``limit`` and ``warn`` are those of ``drawn_scene``.
    """

    def faceted(entity: Entity) -> Entity:
        """Return a primitive as triangles; one without geometry as it is."""
        shape = entity.shape
        if shape is None or not shape.has_geometry:
            return entity
        mesh = shape.computed.mesh if isinstance(shape, SolidShape) else leaf_mesh(shape, _WIREFRAME_SEGMENTS)
        surface = CutSurface(surface=two_sided(shape, mesh), color=shape.color, image=shape.image)
        return Entity(entity.word, entity.embedding, (), surface, entity.tainted, entity.call_sites)

    drawn = drawn_scene(scene, limit, warn)
    return with_frames(drawn, _with_primitives(drawn.frames, faceted))


@dataclass(frozen=True, slots=True)
class FilePart(CutSurface):
    """The part of a mesh file that one image colors, or that has no image."""

    word = "mesh"
    doc = "a part of a mesh file"
    is_file = True

    texture: Texture | None = None

    @property
    def own_texture(self) -> Texture | None:
        return self.texture


def with_file_images(scene: Scene) -> Scene:
    """Return a scene whose mesh files with images are parts, each with one image as its texture.

    So they are drawn and written as every texture is. A file of one image stays one primitive; of several, it becomes
    an entity of its word with a primitive for each. Raises SceneError for files that cannot be read.
    """
    if not any(isinstance(entity.shape, MeshFile) for entity in descendants(*scene.frames)):
        return scene

    def parted(entity: Entity) -> Entity:
        """Return a mesh file as its parts; any other primitive as it is."""
        shape = entity.shape
        mesh = own_mesh(shape) if isinstance(shape, MeshFile) and shape.file is not None else None
        if mesh is None or not mesh.images or not keeps_own_colors(entity, mesh):
            return entity
        assert isinstance(shape, MeshFile)
        parts = _parts_of(mesh, str(shape.file), str(shape.root))
        if len(parts) == 1:
            return Entity(entity.word, entity.embedding, (), parts[0], entity.tainted, entity.call_sites)
        look = Embedding(attributes=entity.embedding.attributes)
        more = entity.tainted, entity.call_sites
        children = tuple(Pair(Entity(entity.word, look, (), part, *more), IDENTITY) for part in parts)
        return Entity(entity.word, entity.embedding, children, None, *more)

    return with_frames(scene, _with_primitives(scene.frames, parted))


@lru_cache(maxsize=32)
def _parts_of(mesh: Mesh, file: str, root: str) -> tuple[FilePart, ...]:
    """Return the parts of a mesh by their image and its factor; one part without images keeps its own colors."""
    assert mesh.image is not None, "a mesh with images has their numbers"
    assert mesh.tint is not None, "a mesh with images has their factors"
    keys = np.column_stack([mesh.image, np.where(mesh.image[:, None] >= 0, mesh.tint, 0.0)])
    rows, place = np.unique(keys, axis=0, return_inverse=True)
    parts = []
    for k, (number, *factor) in enumerate(rows.tolist()):
        chosen = place.reshape(-1) == k
        faces, uv = mesh.faces[chosen], None if mesh.uv is None else mesh.uv[chosen]
        if number < 0:
            colors = np.ones((len(faces), 3)) if mesh.colors is None else mesh.colors[chosen]
            red, green, blue = colors[0].tolist()
            is_even = bool((colors == colors[0]).all())  # a color of the material, which every reader of files knows
            part = Mesh(mesh.vertices, None, faces, None if is_even else colors)
            parts.append(FilePart(surface=part, color=(red, green, blue) if is_even else WHITE))
            continue
        texture = Texture(file, 1.0, colors=(tuple(factor),), projection="uv", source=(root, int(number)))
        parts.append(FilePart(surface=Mesh(mesh.vertices, None, faces, uv=uv), texture=texture))
    return tuple(parts)


def _with_primitives(frames: Sequence[Entity], changed: Callable[[Entity], Entity]) -> list[Entity]:
    """Return frames whose primitives are ``changed``; shared entities stay shared."""
    known: dict[int, Entity] = {}
    for entity in descendants(*frames):
        if entity.is_primitive:
            known[id(entity)] = changed(entity)
            continue
        children = tuple(Pair(known[id(part.car)], part.cdr) for part in entity.children)
        known[id(entity)] = Entity(entity.word, entity.embedding, children, None, entity.tainted, entity.call_sites)
    return [known[id(root)] for root in frames]
