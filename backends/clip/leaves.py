"""The leaves of a scene for neural backends: primitives, or entities that are taken as one, with their sentences."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from scenelang.backends.clip.conditions import Condition
from scenelang.backends.clip.granularity import Granularity, check_named, units_of
from scenelang.backends.clip.sentences import Sayings, Sentences, instances_above
from scenelang.backends.wording.templates import check_template
from scenelang.grammar.diagnostics import LimitError, SceneError
from scenelang.interpreter.ancestry import Ancestry, ancestry_of
from scenelang.interpreter.bounds import entity_box
from scenelang.interpreter.entity import Entity, Scene, primitive_count
from scenelang.interpreter.numbering import frame_numbers, instance_handles
from scenelang.interpreter.shapes import Box

MOST = 100_000  # primitives of all frames: a sentence for each is more than any neural backend can hear


@dataclass(frozen=True, slots=True, eq=False)
class Leaf:
    """An instance taken as a whole. ``path`` are the child positions from the root, ``name`` its words; ``box`` its
    exact box in its own frame, ``pose`` (3, 4) where that stands in the world."""

    entity: Entity
    handle: str
    path: tuple[int, ...]
    name: str
    condition: Condition
    box: Box
    pose: npt.NDArray[np.float64]


def leaves_of(scene: Scene, granularity: Granularity, sayings: Sayings) -> list[list[Leaf]]:
    """The leaves of every frame, in the order of the program.

    Raises SceneError: "value" for a name that nothing in the scene has, "empty-scene", LimitError.
    """
    check_template(sayings.template)
    check_anything(scene)
    counts = list(map(primitive_count, scene.frames))
    if sum(counts) > MOST:
        raise LimitError("primitives", f"the scene has more than the {MOST:,} primitives that can be described")
    numbers = frame_numbers(scene) if len(scene.frames) > 1 else None
    ancestries = [ancestry_of(root) if count else None for root, count in zip(scene.frames, counts)]
    frames = [(each, instance_handles(scene, each, numbers)) for each in ancestries if each is not None]
    check_named(frames, granularity)
    leaves = iter([list(_of_frame(ancestry, handles, granularity, sayings)) for ancestry, handles in frames])
    found = [next(leaves) if count else [] for count in counts]
    if not any(found):
        raise _empty(scene)
    return found


def check_anything(scene: Scene) -> None:
    """Raises SceneError("empty-scene") for a scene without any primitive."""
    if not any(map(primitive_count, scene.frames)):
        raise _empty(scene)


def _empty(scene: Scene) -> SceneError:
    return SceneError("empty-scene", f'the scene "{scene.word}" has no primitives, so there is nothing to learn')


def _of_frame(ancestry: Ancestry, handles: Sequence[str], granularity: Granularity, sayings: Sayings) -> Iterator[Leaf]:
    units = units_of(ancestry, handles, granularity)
    sentences = Sentences(ancestry, handles, sayings)
    members: dict[int, list[int]] = {}
    for primitive in ancestry.primitives.tolist():
        members.setdefault(int(units[primitive]), []).append(primitive)
    for instance, primitives in members.items():
        entity, pose = ancestry.entity(instance), ancestry.poses[instance]
        box = entity_box(entity)
        if box is None or not np.isfinite(pose).all():
            continue
        above = reversed(list(instances_above(ancestry, instance)))
        name = "/".join([*(ancestry.entity(i).word for i in above), entity.word])
        condition = sentences.condition(instance, primitives)
        yield Leaf(entity, handles[instance], ancestry.path(instance), name, condition, box, pose)
