"""What neural backends are told of each thing in a scene: a sentence of the paper's template (section 4).

A sentence says how the thing looks and how all look that it is a part of, so that one entry of Z re-styles the whole
entity whose handle it has; the root's entry is the style of the scene.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.neural.clip import Prompt, Slot, TextEncoder, Vectors, parse_prompt, slots, with_texts
from scenelang.backends.neural.describing import Member, describe_all, has_meaning, thing
from scenelang.backends.neural.wording import DEFAULT, HOLE, check_template, packed, plain_text, unpacked, with_article
from scenelang.grammar.diagnostics import LimitError, SceneError
from scenelang.grammar.settings import setting, whole
from scenelang.interpreter.scene.bounds import entity_box
from scenelang.interpreter.scene.entity import Entity, Scene, primitive_count
from scenelang.interpreter.scene.numbering import Ancestry, ancestry_of, frame_numbers, instance_handles
from scenelang.interpreter.scene.primitives import Box

# What neural backends are told of each primitive: its sentence, with learned vectors where Z has them (the paper,
# section 4: the template c and z = g_CLIP(c)).


@dataclass(frozen=True, slots=True)
class PromptCondition:
    """What is said of primitives of one look: ``prompt`` with slots for learned vectors only, ``plain`` the sentence
    for models that read plain text, and the ``handles`` of their embeddings."""

    word: str
    prompt: Prompt
    plain: str
    handles: tuple[str, ...]


def together(conditions: Iterable[PromptCondition]) -> tuple[PromptCondition, ...]:
    """Each sentence once, with the handles of all that it is said of."""
    found: dict[tuple[str, Prompt], tuple[str, dict[str, None]]] = {}
    for each in conditions:
        _, handles = found.setdefault((each.word, each.prompt), (each.plain, {}))
        handles.update(dict.fromkeys(each.handles))
    return tuple(
        PromptCondition(word, prompt, plain, tuple(handles)) for (word, prompt), (plain, handles) in found.items()
    )


def resolved(text: str, texts: Mapping[str, str], learned: frozenset[str]) -> Prompt:
    """A prompt in which only handles with vectors are left open, the others written out.

    Raises SceneError("value") for a handle that has neither.
    """
    prompt = with_texts(parse_prompt(text), lambda name: None if name in learned else texts.get(name))
    unknown = [name for name in slots(prompt) if name not in learned]
    if unknown:
        raise SceneError(
            "value",
            f"<{unknown[0]}> has neither vectors nor a text",
            hint=f"give it one: scenelang embeddings FILE set '<{unknown[0]}>' --text \"...\"",
        )
    return prompt


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

    def condition(self, instance: int, primitives: Sequence[int]) -> PromptCondition:
        """The sentence of ``instance``, which has the ``primitives`` below it."""
        above = list(instances_above(self._ancestry, instance))
        word, text = self._described(instance, above, primitives)
        said = list(dict.fromkeys([*self._own(instance, text), *self._around(above, text)]))
        sentence = with_article(self._template(instance, word).replace(HOLE, ", ".join(said)))
        prompt = resolved(sentence, {}, self._sayings.learned)
        plain = plain_text(word, ", ".join(part for part in said if not part.startswith("<")) or text)
        return PromptCondition(word, prompt, plain, (self._handles[instance],))

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


# The encoded conditions of a scene: one embedding in Z_CLIP for each sentence, and whose it is.


FloatArray = npt.NDArray[np.float32]
VERSION = 1
_BATCH = 32


@dataclass(frozen=True, slots=True)
class EncodingRow:
    """The sentence ``prompt`` of things called ``word``, and the handles of their embeddings."""

    word: str
    prompt: str
    handles: tuple[str, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Encodings:
    """``matrix`` (K, D) holds the embedding of each row, of length 1; ``model`` made them."""

    model: str
    rows: tuple[EncodingRow, ...]
    matrix: FloatArray

    def row_of(self, handle: str) -> int | None:
        """The row of a handle; None where there is none."""
        return next((i for i, row in enumerate(self.rows) if handle in row.handles), None)

    def nearest(self, wanted: FloatArray) -> list[tuple[int, float]]:
        """The rows with their cosines to ``wanted`` (D,), the most similar first."""
        cosines = self.matrix @ (wanted / max(float(np.linalg.norm(wanted)), 1e-12))
        return [(int(i), float(cosines[i])) for i in np.argsort(-cosines, kind="stable")]


def encoded(
    conditions: Sequence[PromptCondition], encoder: TextEncoder, vectors: Vectors, model: str, batch: int = _BATCH
) -> Encodings:
    """Every condition as g_CLIP encodes it; raises SceneError as ``TextEncoder.encode`` does."""
    parts = []
    for start in range(0, len(conditions), batch):
        prompts = [condition.prompt for condition in conditions[start : start + batch]]
        pooled = encoder.encode(prompts, vectors).pooled.detach().float().cpu().numpy()
        parts.append(pooled / np.maximum(np.linalg.norm(pooled, axis=1, keepdims=True), 1e-12))
    rows = tuple(EncodingRow(each.word, written(each.prompt), each.handles) for each in conditions)
    matrix = np.concatenate(parts) if parts else np.zeros((0, 0), np.float32)
    return Encodings(model, rows, matrix.astype(np.float32))


def written(prompt: Prompt) -> str:
    """A prompt as text, its slots as handles."""
    return "".join(f"<{piece.name}>" if isinstance(piece, Slot) else piece for piece in prompt)


def to_json(encodings: Encodings) -> dict[str, Any]:
    """All but the matrix, as JSON data."""
    rows = [{"word": row.word, "prompt": row.prompt, "handles": packed(row.handles)} for row in encodings.rows]
    return {"version": VERSION, "model": encodings.model, "rows": rows}


def from_json(data: Mapping[str, Any], matrix: FloatArray) -> Encodings:
    """The inverse of ``to_json``; raises ValueError, KeyError or TypeError for what is none."""
    if data["version"] != VERSION:
        raise ValueError(f"its encodings are of version {str(data['version'])[:20]}; this program knows {VERSION}")
    rows = tuple(EncodingRow(str(row["word"]), str(row["prompt"]), unpacked(row["handles"])) for row in data["rows"])
    if matrix.ndim != 2 or len(matrix) != len(rows):
        raise ValueError("its encodings have another number of rows than their matrix")
    return Encodings(str(data["model"]), rows, np.asarray(matrix, np.float32))


# Which entities of a scene neural backends take as one: primitives, or intermediate nodes as new leaves (the paper,
# appendix "SDS-Based Renderer").


IntArray = npt.NDArray[np.int64]

_PATH = re.compile(r"\d+(/\d+)*\Z")


@dataclass(frozen=True, slots=True)
class Granularity:
    """Which entities count as one.

    Parameters
    ----------
    depth : int, optional
        Those so many levels below the root; None: only primitives.
    named : tuple of str
        Others, each by a handle ``<z5>``, by the places of children from the root ``0/2``, or by a word.

    Examples
    --------
    >>> Granularity(named=("moai",))
    Granularity(depth=None, named=('moai',))
    """

    depth: int | None = setting(None, "take entities N below the root as one each", metavar="N", read=whole)
    named: tuple[str, ...] = setting(
        (),
        "take an entity as one: its handle '<z5>', its word, or the places of children from the root, 0/2; may be "
        "repeated",
        "--entity", metavar="NAME", repeated=True,
    )  # fmt: skip


def units_of(ancestry: Ancestry, handles: Sequence[str], granularity: Granularity) -> IntArray:
    """For every instance (M,) the one that it counts as: the highest around it that ``granularity`` takes as one, or
    itself. ``handles`` are those of all instances."""
    units = np.arange(len(ancestry)) if granularity.depth is None else ancestry.at_depth(granularity.depth)
    chosen = np.zeros(len(ancestry), bool)
    for name in granularity.named:
        chosen[_called(ancestry, handles, name)] = True
    if chosen.any():
        units = units.copy()
        for level in range(ancestry.max_depth + 1):  # from the root, so that what is highest counts
            rows = np.flatnonzero(ancestry.depth == level)
            above = np.where(ancestry.parent[rows] >= 0, ancestry.parent[rows], rows)
            inside = chosen[units[above]] & (above != rows)
            units[rows] = np.where(inside, units[above], np.where(chosen[rows], rows, units[rows]))
    return units


def check_named(frames: Sequence[tuple[Ancestry, Sequence[str]]], granularity: Granularity) -> None:
    """Raises SceneError("value") for a name that nothing has in any of the frames, each with all its handles."""
    for name in granularity.named:
        if not any(_called(ancestry, handles, name) for ancestry, handles in frames):
            hint = "a handle '<z5>', places of children from the root 0/2, or a word; `scenelang tree` shows them"
            raise SceneError("value", f"nothing in the scene is called `{name}`", hint=hint)


def _called(ancestry: Ancestry, handles: Sequence[str], name: str) -> list[int]:
    """The instances that a name of the user's means."""
    if _PATH.match(name):
        wanted = tuple(map(int, name.split("/")))
        level = np.flatnonzero(ancestry.depth == len(wanted)).tolist()
        return [i for i in level if ancestry.path(i) == wanted]
    if name.startswith("<") and name.endswith(">"):
        return [i for i, handle in enumerate(handles) if handle == name[1:-1]]
    of_word = np.array([entity.word == name for entity in ancestry.nodes], bool)
    found: list[int] = np.flatnonzero(of_word[ancestry.node]).tolist()
    return found


# The leaves of a scene for neural backends: primitives, or entities that are taken as one, with their sentences.


MOST = 100_000  # primitives of all frames: a sentence for each is more than any neural backend can hear


@dataclass(frozen=True, slots=True, eq=False)
class PromptLeaf:
    """An instance taken as a whole. ``path`` are the child positions from the root, ``name`` its words; ``box`` its
    exact box in its own frame, ``pose`` (3, 4) where that stands in the world."""

    entity: Entity
    handle: str
    path: tuple[int, ...]
    name: str
    condition: PromptCondition
    box: Box
    pose: npt.NDArray[np.float64]


def leaves_of(scene: Scene, granularity: Granularity, sayings: Sayings) -> list[list[PromptLeaf]]:
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


def _of_frame(
    ancestry: Ancestry, handles: Sequence[str], granularity: Granularity, sayings: Sayings
) -> Iterator[PromptLeaf]:
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
        yield PromptLeaf(entity, handles[instance], ancestry.path(instance), name, condition, box, pose)
