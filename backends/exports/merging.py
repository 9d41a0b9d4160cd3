"""One mesh of everything below an entity: what ``--depth`` makes of parts, and ``--instance-limit`` of repetitions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from scenelang.backends.appearance import Look, look_of
from scenelang.backends.exports.surfaces import SEGMENTS, Surface, is_round, surface_of, vertex_count
from scenelang.grammar.diagnostics import LimitError
from scenelang.interpreter.entity import Entity, primitive_count
from scenelang.interpreter.flatten import FlatFrame, flatten_entity

MOST_VERTICES = 24_000_000
WHITE = (1.0, 1.0, 1.0)
_COARSER = (SEGMENTS, 48, 32, 24, 16, 12, 8)


@dataclass(frozen=True, slots=True, eq=False)
class Patch:
    """The triangles of one material: ``look`` with its colour white, since ``surface.colors`` (V, 3) has it."""

    look: Look
    surface: Surface


def merged(entity: Entity, segments: int = SEGMENTS) -> tuple[Patch, ...]:
    """All primitives below ``entity``, in its frame, one patch for each material but for the colour."""
    frame = flatten_entity(entity, whole_cells=False)
    found: dict[Look, list[Surface]] = {}
    for number, primitive in enumerate(frame.primitives):
        look = look_of(primitive)
        surface = None if look.opacity == 0.0 else surface_of(primitive, segments)
        if surface is None:
            continue
        copies = surface.under(np.asarray(frame.matrices[frame.index == number]))
        found.setdefault(replace(look, color=WHITE), []).append(_painted(copies, look))
    return tuple(Patch(look, joined(surfaces)) for look, surfaces in found.items())


def _painted(surface: Surface, look: Look) -> Surface:
    """The surface with the look's colour on every vertex."""
    own = np.ones((len(surface.vertices), 3)) if surface.colors is None else surface.colors
    return replace(surface, colors=own * np.array(look.color))


def joined(surfaces: Sequence[Surface]) -> Surface:
    """All surfaces, which have colours, as one."""
    if len(surfaces) == 1:
        return surfaces[0]
    starts = np.cumsum([0, *(len(surface.vertices) for surface in surfaces)])
    colors = [np.ones_like(s.vertices) if s.colors is None else s.colors for s in surfaces]
    return Surface(
        np.concatenate([surface.vertices for surface in surfaces]),
        np.concatenate([surface.normals for surface in surfaces]),
        np.concatenate([surface.faces + start for surface, start in zip(surfaces, starts, strict=False)]),
        np.concatenate(colors),
    )


def segments_for(entities: Sequence[Entity], what: str, hint: str | None = None) -> int:
    """How many sides round primitives may have so that the ``entities``, merged, fit; raises LimitError when none do.

    ``what`` names the file in the message, ``hint`` says what to do.
    """
    shapes = [(frame, np.bincount(frame.index)) for frame in _frames(entities, what, hint)]
    for segments in _COARSER:
        total = sum(
            int(count) * vertex_count(primitive, segments)
            for frame, counts in shapes
            for primitive, count in zip(frame.primitives, counts.tolist(), strict=True)
        )
        if total <= MOST_VERTICES:
            return segments
        if not any(p.shape is not None and is_round(p.shape) for frame, _ in shapes for p in frame.primitives):
            break
    raise LimitError(
        "primitives", f"{what} would have {total:,} vertices, more than the {MOST_VERTICES:,} that fit", hint=hint
    )


def _frames(entities: Sequence[Entity], what: str, hint: str | None) -> list[FlatFrame]:
    total = sum(primitive_count(entity) for entity in entities)
    if 3 * total > MOST_VERTICES:  # before anything is expanded
        raise LimitError("primitives", f"{what} would hold {total:,} primitives, more than fit", hint=hint)
    return [flatten_entity(entity, whole_cells=False) for entity in entities]
