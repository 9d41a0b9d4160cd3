"""What neural backends are told of each thing in a scene: a sentence of the paper's template (section 4).

A sentence says how the thing looks and how all look that it is a part of, so that one entry of Z re-styles the whole
entity whose handle it has; the root's entry is the style of the scene.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from scenelang.backends.clip.conditions import Condition, resolved
from scenelang.backends.clip.prompts import Prompt, parse_prompt, slots
from scenelang.backends.wording.describing import Member, describe_all
from scenelang.backends.wording.readable import has_meaning, thing
from scenelang.backends.wording.templates import DEFAULT, HOLE, plain_text, with_article
from scenelang.interpreter.ancestry import Ancestry
from scenelang.interpreter.entity import Entity

_MOST_TOLD = 3  # kinds of primitives that speak for an entity without a text


@dataclass(frozen=True, slots=True)
class Sayings:
    """What is known besides the program: ``learned`` handles have vectors, ``texts`` of handles come from Z and beat
    the program's; ``template`` is the sentence, ``templates`` those of single handles, in which only `{embedding}` is
    left open."""

    learned: frozenset[str] = frozenset()
    texts: Mapping[str, str] = field(default_factory=dict)
    template: str = DEFAULT
    templates: Mapping[str, str] = field(default_factory=dict)


class Sentences:
    """The sentences of one frame's things; ``handles`` are those of all instances of ``ancestry``."""

    def __init__(self, ancestry: Ancestry, handles: Sequence[str], sayings: Sayings) -> None:
        self._ancestry, self._handles, self._sayings = ancestry, handles, sayings
        self._style = f"<{handles[0]}>" if handles[0] in sayings.learned else self._root_text()
        self._known: dict[tuple[int, ...], tuple[str, str]] = {}

    def _root_text(self) -> str:
        root = self._ancestry.entity(0)
        own = (root.embedding.text or "").strip() or thing(root)
        return self._sayings.texts.get(self._handles[0], own)

    def condition(self, instance: int, primitives: Sequence[int]) -> Condition:
        """The sentence of ``instance``, which has the ``primitives`` below it."""
        above = list(instances_above(self._ancestry, instance))
        word, text = self._described(instance, above, primitives)
        said = list(dict.fromkeys([*self._own(instance, text), *self._around(above, text)]))
        sentence = with_article(self._template(instance, word).replace(HOLE, ", ".join(said)))
        prompt = resolved(sentence, {}, self._sayings.learned)
        plain = plain_text(word, ", ".join(part for part in said if not part.startswith("<")) or text)
        return Condition(word, prompt, plain, (self._handles[instance],))

    def _template(self, instance: int, word: str) -> str:
        own = self._sayings.templates.get(self._handles[instance])
        if own is not None:
            return own.replace(f"<{self._handles[0]}>", self._style)
        return self._sayings.template.replace("{style}", self._style).replace("{word}", word)

    def of_scene(self, text: str) -> Prompt:
        """A sentence of the user's, in which handles may stand; raises SceneError("value") for one that nothing has."""
        texts = dict(self._sayings.texts)
        for handle in slots(parse_prompt(text)):
            if handle not in texts and handle in self._handles:
                instance = self._handles.index(handle)
                below = primitives_below(self._ancestry, instance)
                texts[handle] = self._described(instance, list(instances_above(self._ancestry, instance)), below)[1]
        return resolved(text, {self._handles[0]: self._root_text(), **texts}, self._sayings.learned)

    def _own(self, instance: int, text: str) -> list[str]:
        handle = self._handles[instance]
        return [f"<{handle}>"] if handle in self._sayings.learned else [text]

    def _around(self, above: Sequence[int], text: str) -> Iterator[str]:
        """What is said of the things around, as far as it was not said yet."""
        for i in above:
            handle, around = self._handles[i], (self._ancestry.entity(i).embedding.text or "").strip()
            around = self._sayings.texts.get(handle, around)
            if handle in self._sayings.learned:
                yield f"<{handle}>"
            elif around and around.lower() not in text.lower():
                yield around

    def _described(self, instance: int, above: Sequence[int], primitives: Sequence[int]) -> tuple[str, str]:
        """What a thing is, and how it looks."""
        entity = self._ancestry.entity(instance)
        named = next((i for i in (instance, *above) if has_meaning(self._ancestry.entity(i).word)), instance)
        whole = self._ancestry.entity(named)
        text = self._sayings.texts.get(self._handles[instance])
        if text is not None:
            return thing(whole), text
        parts = {id(self._ancestry.entity(i)): self._ancestry.entity(i) for i in primitives}
        key = (id(entity), named, *parts)
        if key not in self._known:
            self._known[key] = thing(whole), _look_of(entity, whole, parts.values())
        return self._known[key]


def instances_above(ancestry: Ancestry, instance: int) -> Iterator[int]:
    """The instances around ``instance``, nearest first, the root left out."""
    parent = int(ancestry.parent[instance])
    while parent > 0:
        yield parent
        parent = int(ancestry.parent[parent])


def primitives_below(ancestry: Ancestry, instance: int) -> list[int]:
    """The primitives of an instance, itself where it is one."""
    level = ancestry.at_depth(int(ancestry.depth[instance]))
    return [i for i in ancestry.primitives.tolist() if level[i] == instance]


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
