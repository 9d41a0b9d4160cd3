"""Scenes in another style, as transformations of the entity graph: in clay, and as triangles."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from scenelang.backends.surfaces.appearance import look_of
from scenelang.backends.surfaces.cuts import CutSurface, two_sided
from scenelang.backends.surfaces.stand_ins import drawn_scene
from scenelang.grammar.datum import replace
from scenelang.grammar.diagnostics import Diagnostic
from scenelang.interpreter.scene.entity import Entity, Scene, descendants
from scenelang.interpreter.scene.exploding import with_frames
from scenelang.interpreter.scene.modelling.computing import leaf_mesh
from scenelang.interpreter.scene.modelling.solid import SolidShape
from scenelang.interpreter.scene.primitives.base import MATERIALS
from scenelang.interpreter.values.values import Embedding, Pair, Vector

Warn = Callable[[Diagnostic], None]

_CLAY = (0.58, 0.53, 0.48)  # linear sRGB
_SEGMENTS = 24  # sides of full circles of a wireframe: few enough to tell its lines apart


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
        mesh = shape.computed.mesh if isinstance(shape, SolidShape) else leaf_mesh(shape, _SEGMENTS)
        surface = CutSurface(surface=two_sided(shape, mesh), color=shape.color, image=shape.image)
        return Entity(entity.word, entity.embedding, (), surface, entity.tainted, entity.call_sites)

    drawn = drawn_scene(scene, limit, warn)
    return with_frames(drawn, _with_primitives(drawn.frames, faceted))


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
