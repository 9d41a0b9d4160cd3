"""Which entities of a scene neural backends take as a whole, and the sentence of each (the paper, section 4 and the
appendix "Primitive Reparameterization": intermediate nodes become leaves).

The sentence of a thing says how it looks and how all look that it is a part of, so that one entry of Z re-styles the
whole entity whose handle it has; the root's entry is the style of the scene.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from scenelang.backends.clip.conditions import Condition, resolved
from scenelang.backends.wording.describing import Member, describe_all
from scenelang.backends.wording.readable import has_meaning, thing
from scenelang.backends.wording.templates import DEFAULT, HOLE, check_template, plain_text, with_article
from scenelang.grammar.diagnostics import LimitError, SceneError
from scenelang.interpreter.ancestry import Ancestry, ancestry_of
from scenelang.interpreter.bounds import entity_box
from scenelang.interpreter.entity import Entity, Scene, descendants, primitive_count
from scenelang.interpreter.numbering import frame_numbers, instance_handles, number_scene
from scenelang.interpreter.shapes import Box

MOST = 100_000  # primitives of all frames: a sentence for each is more than any neural backend can hear
_MOST_TOLD = 3  # kinds of primitives that speak for an entity without a text


@dataclass(frozen=True, slots=True)
class Granularity:
    """What becomes one leaf besides primitives: every entity at ``depth`` (the root is 0), and those that ``entities``
    names by word or by handle, `<z4>`."""

    depth: int | None = None
    entities: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Sayings:
    """What is known besides the program: ``learned`` handles have vectors, ``texts`` of handles come from a wording,
    ``template`` is the sentence."""

    learned: frozenset[str] = frozenset()
    texts: Mapping[str, str] | None = None
    template: str = DEFAULT


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

    Raises SceneError: "value" for a word or handle that no frame has, "empty-scene", LimitError.
    """
    check_template(sayings.template)
    if sum(map(primitive_count, scene.frames)) > MOST:
        raise LimitError("primitives", f"the scene has more than the {MOST:,} primitives that can be described")
    _check_names(scene, granularity)
    numbers = frame_numbers(scene) if len(scene.frames) > 1 else None
    found = []
    for root in scene.frames:
        ancestry = ancestry_of(root)
        handles = instance_handles(scene, ancestry, numbers)
        found.append(list(_of_frame(ancestry, handles, granularity, sayings)))
    if not any(found):
        raise SceneError("empty-scene", f'the scene "{scene.word}" has no primitives, so there is nothing to learn')
    return found


def _check_names(scene: Scene, granularity: Granularity) -> None:
    if granularity.depth is not None and granularity.depth < 0:
        raise SceneError("value", "the depth of leaves is 0 for the whole scene, or more")
    words = {entity.word for entity in descendants(*scene.frames)}
    for name in granularity.entities:
        if not name.startswith("<") and name not in words:
            raise SceneError("value", f'no entity of the scene has the word "{name}"')


def _of_frame(ancestry: Ancestry, handles: Sequence[str], granularity: Granularity, sayings: Sayings) -> Iterator[Leaf]:
    chosen = _chosen(ancestry, handles, granularity)
    sentences = _Sentences(ancestry, handles, sayings)
    for instance, primitives in chosen.items():
        entity = ancestry.entity(instance)
        box = entity_box(entity)
        if box is None or not np.isfinite(ancestry.poses[instance]).all():
            continue
        above = list(_above(ancestry, instance))
        name = "/".join([*(ancestry.entity(i).word for i in reversed(above)), entity.word])
        condition = sentences.of(instance, above, primitives)
        yield Leaf(
            entity, handles[instance], ancestry.path(instance), name, condition, box, ancestry.poses[instance]
        )  # fmt: skip


def _chosen(ancestry: Ancestry, handles: Sequence[str], granularity: Granularity) -> dict[int, list[int]]:
    """The instances that are leaves, and the primitives below each."""
    words = {name for name in granularity.entities if not name.startswith("<")}
    named = {name[1:-1] for name in granularity.entities if name.startswith("<")}
    missing = named - set(handles)
    if missing:
        raise SceneError("value", f"no entity of the scene has the handle <{sorted(missing)[0]}>")
    at_depth = ancestry.at_depth(granularity.depth) if granularity.depth is not None else None
    found: dict[int, list[int]] = {}
    for primitive in ancestry.primitives.tolist():
        leaf = int(at_depth[primitive]) if at_depth is not None else primitive
        for i in (primitive, *_above(ancestry, primitive), 0):  # the outermost wins
            if ancestry.entity(i).word in words or handles[i] in named:
                leaf = i if ancestry.depth[i] <= ancestry.depth[leaf] else leaf
        found.setdefault(leaf, []).append(primitive)
    return found


def _above(ancestry: Ancestry, instance: int) -> Iterator[int]:
    """The instances around ``instance``, nearest first, the root left out."""
    parent = int(ancestry.parent[instance])
    while parent > 0:
        yield parent
        parent = int(ancestry.parent[parent])


class _Sentences:
    """The sentences of one frame's things."""

    def __init__(self, ancestry: Ancestry, handles: Sequence[str], sayings: Sayings) -> None:
        self._ancestry, self._handles, self._sayings = ancestry, handles, sayings
        root = ancestry.entity(0)
        own = (root.embedding.text or "").strip() or thing(root)
        self._style = f"<{handles[0]}>" if handles[0] in sayings.learned else (sayings.texts or {}).get(handles[0], own)
        self._known: dict[tuple[int, ...], tuple[str, str]] = {}

    def of(self, instance: int, above: Sequence[int], primitives: Sequence[int]) -> Condition:
        word, text = self._described(instance, above, primitives)
        said = list(dict.fromkeys([*self._own(instance, text), *self._around(above, text)]))
        template = self._sayings.template.replace("{style}", self._style).replace("{word}", word)
        sentence = with_article(template.replace(HOLE, ", ".join(said)))
        prompt = resolved(sentence, {}, self._sayings.learned)
        plain = plain_text(word, ", ".join(part for part in said if not part.startswith("<")) or text)
        return Condition(word, prompt, plain, (self._handles[instance],))

    def _own(self, instance: int, text: str) -> list[str]:
        handle = self._handles[instance]
        return [f"<{handle}>"] if handle in self._sayings.learned else [text]

    def _around(self, above: Sequence[int], text: str) -> Iterator[str]:
        """What is said of the things around, as far as it was not said yet."""
        for i in above:
            handle, around = self._handles[i], (self._ancestry.entity(i).embedding.text or "").strip()
            if handle in self._sayings.learned:
                yield f"<{handle}>"
            elif around and around.lower() not in text.lower():
                yield around

    def _described(self, instance: int, above: Sequence[int], primitives: Sequence[int]) -> tuple[str, str]:
        """What a leaf is, and how it looks."""
        entity = self._ancestry.entity(instance)
        named = next((i for i in (instance, *above) if has_meaning(self._ancestry.entity(i).word)), instance)
        whole = self._ancestry.entity(named)
        parts = {id(self._ancestry.entity(i)): self._ancestry.entity(i) for i in primitives}
        key = (id(entity), named, *parts)
        if key not in self._known:
            text = (self._sayings.texts or {}).get(self._handles[instance])
            self._known[key] = thing(whole), text or _look_of(entity, whole, parts.values())
        return self._known[key]


def _look_of(entity: Entity, named: Entity, primitives: Iterable[Entity]) -> str:
    """A primitive's description; of an entity its text, else what its primitives look like."""
    own = (entity.embedding.text or "").strip()
    if own and not entity.is_primitive:
        return own
    members = [Member(each, named if entity.is_primitive else each) for each in primitives]
    texts = [described.text for described in describe_all(members)]
    if not entity.is_primitive:  # the first thing said of each: its own words, or its colour
        texts = list(dict.fromkeys(text.partition(",")[0] for text in texts))
    return " and ".join(texts[:_MOST_TOLD])


def style_handle(scene: Scene) -> str:
    """The handle of the root, which is the style of the scene."""
    return number_scene(scene).handle(scene.root, 0)
