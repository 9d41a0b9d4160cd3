"""Prompts of a scene's entities for neural backends, by the paper's language template (section 4).

A prompt describes the appearance of the entity and of all its ancestors, so that one entry of Z restyles the whole
entity with that handle; the root's entry is the style of the scene.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.neural.clip import Prompt, Slot, TextEncoder, Vectors, parse_prompt, slots, substitute_texts
from scenelang.backends.neural.descriptions import Member, describe_all, has_meaning, noun_of
from scenelang.backends.neural.wording import (
    DEFAULT_TEMPLATE,
    PLACEHOLDER,
    check_template,
    fix_article,
    pack_handles,
    plain_text,
    unpack_handles,
)
from scenelang.grammar.datum import dataclass, field
from scenelang.grammar.diagnostics import LimitError, SceneError
from scenelang.grammar.settings import setting, whole
from scenelang.interpreter.inspection.numbering import Ancestry, ancestry_of, frame_numbers, instance_handles
from scenelang.interpreter.scene.bounds import entity_box
from scenelang.interpreter.scene.entity import Entity, Scene, primitive_count
from scenelang.interpreter.scene.primitives import Box

# Prompts of entities, with learned vectors where Z has them (the paper, section 4: template c, embedding z =
# g_CLIP(c)).


@dataclass(frozen=True, slots=True)
class PromptCondition:
    """Prompt of entities with the same appearance.

    Attributes
    ----------
    word
        Noun of the entities.
    prompt
        Prompt with slots for learned vectors only.
    plain
        Prompt without handles, for models that read plain text.
    handles
        Handles of the entities' embeddings.
    """

    word: str
    prompt: Prompt
    plain: str
    handles: tuple[str, ...]


def merge_conditions(conditions: Iterable[PromptCondition]) -> tuple[PromptCondition, ...]:
    """Merge conditions with equal prompts; the result has the handles of all of them."""
    merged: dict[tuple[str, Prompt], tuple[str, dict[str, None]]] = {}
    for each in conditions:
        _, handles = merged.setdefault((each.word, each.prompt), (each.plain, {}))
        handles.update(dict.fromkeys(each.handles))
    return tuple(
        PromptCondition(word, prompt, plain, tuple(handles)) for (word, prompt), (plain, handles) in merged.items()
    )


def resolve_prompt(text: str, texts: Mapping[str, str], learned: frozenset[str]) -> Prompt:
    """Parse a prompt and replace its handles by their ``texts``, except ``learned`` ones, which remain as slots.

    Raises SceneError("value") for a handle with neither vectors nor a text.
    """
    prompt = substitute_texts(parse_prompt(text), lambda name: None if name in learned else texts.get(name))
    unknown = [name for name in slots(prompt) if name not in learned]
    if unknown:
        raise SceneError(
            "value",
            f"<{unknown[0]}> has neither vectors nor a text",
            hint=f"give it one: scenelang embeddings FILE set '<{unknown[0]}>' --text \"...\"",
        )
    return prompt


_MAX_APPEARANCES = 3  # of the primitives of an entity without a text; longer prompts would exceed CLIP's context


@dataclass(frozen=True, slots=True)
class PromptContext:
    """Template and embeddings from which prompts are built, in addition to the program.

    Attributes
    ----------
    learned
        Handles with learned vectors.
    texts
        Texts by handle from Z, which override the program's.
    template
        Template of all prompts.
    templates
        Templates of single handles, with ``{embedding}`` as the only placeholder.
    """

    learned: frozenset[str] = frozenset()
    texts: Mapping[str, str] = field(default_factory=dict)
    template: str = DEFAULT_TEMPLATE
    templates: Mapping[str, str] = field(default_factory=dict)


class PromptBuilder:
    """Builder of the prompts of one frame's entities; ``handles`` are those of all instances of ``ancestry``."""

    def __init__(self, ancestry: Ancestry, handles: Sequence[str], context: PromptContext) -> None:
        self._ancestry, self._handles, self._context = ancestry, handles, context
        self._style = f"<{handles[0]}>" if handles[0] in context.learned else self._root_text()
        self._cache: dict[tuple[int, ...], tuple[str, str]] = {}

    def _root_text(self) -> str:
        root = self._ancestry.entity(0)
        own = (root.embedding.text or "").strip() or noun_of(root)
        return self._context.texts.get(self._handles[0], own)

    def condition(self, instance: int, primitives: Sequence[int]) -> PromptCondition:
        """Return the prompt of ``instance``, whose descendant primitives are ``primitives``."""
        ancestors = list(ancestors_of(self._ancestry, instance))
        word, text = self._noun_and_text(instance, ancestors, primitives)
        parts = list(dict.fromkeys([*self._own_part(instance, text), *self._ancestor_parts(ancestors, text)]))
        filled = fix_article(self._template(instance, word).replace(PLACEHOLDER, ", ".join(parts)))
        prompt = resolve_prompt(filled, {}, self._context.learned)
        plain = plain_text(word, ", ".join(part for part in parts if not part.startswith("<")) or text)
        return PromptCondition(word, prompt, plain, (self._handles[instance],))

    def _template(self, instance: int, word: str) -> str:
        own = self._context.templates.get(self._handles[instance])
        if own is not None:
            return own.replace(f"<{self._handles[0]}>", self._style)
        return self._context.template.replace("{style}", self._style).replace("{word}", word)

    def scene_prompt(self, text: str) -> Prompt:
        """Resolve a user's prompt, which may contain handles; raises SceneError("value") for an unknown handle."""
        texts = dict(self._context.texts)
        for handle in slots(parse_prompt(text)):
            if handle not in texts and handle in self._handles:
                instance = self._handles.index(handle)
                primitives = descendant_primitives(self._ancestry, instance)
                ancestors = list(ancestors_of(self._ancestry, instance))
                texts[handle] = self._noun_and_text(instance, ancestors, primitives)[1]
        return resolve_prompt(text, {self._handles[0]: self._root_text(), **texts}, self._context.learned)

    def _own_part(self, instance: int, text: str) -> list[str]:
        handle = self._handles[instance]
        return [f"<{handle}>"] if handle in self._context.learned else [text]

    def _ancestor_parts(self, ancestors: Sequence[int], text: str) -> Iterator[str]:
        """Yield the handles or texts of the ancestors, except texts already contained in ``text``."""
        for i in ancestors:
            handle, own = self._handles[i], (self._ancestry.entity(i).embedding.text or "").strip()
            own = self._context.texts.get(handle, own)
            if handle in self._context.learned:
                yield f"<{handle}>"
            elif own and own.lower() not in text.lower():
                yield own

    def _noun_and_text(self, instance: int, ancestors: Sequence[int], primitives: Sequence[int]) -> tuple[str, str]:
        """Return the noun of an instance and the description of its appearance."""
        entity = self._ancestry.entity(instance)
        named = next((i for i in (instance, *ancestors) if has_meaning(self._ancestry.entity(i).word)), instance)
        whole = self._ancestry.entity(named)
        text = self._context.texts.get(self._handles[instance])
        if text is not None:
            return noun_of(whole), text
        parts = {id(self._ancestry.entity(i)): self._ancestry.entity(i) for i in primitives}
        key = (id(entity), named, *parts)
        if key not in self._cache:
            self._cache[key] = noun_of(whole), _appearance_of(entity, whole, parts.values())
        return self._cache[key]


def ancestors_of(ancestry: Ancestry, instance: int) -> Iterator[int]:
    """Iterate over the ancestors of ``instance``, nearest first, without the root."""
    parent = int(ancestry.parent[instance])
    while parent > 0:
        yield parent
        parent = int(ancestry.parent[parent])


def descendant_primitives(ancestry: Ancestry, instance: int) -> list[int]:
    """Return the primitives of an instance, which may be a primitive itself."""
    level = ancestry.at_depth(int(ancestry.depth[instance]))
    return [i for i in ancestry.primitives.tolist() if level[i] == instance]


def _appearance_of(entity: Entity, named: Entity, primitives: Iterable[Entity]) -> str:
    """Describe the appearance of an entity: its text, else that of its primitives."""
    own = (entity.embedding.text or "").strip()
    if own and not entity.is_primitive:
        return own
    members = [Member(each, named if entity.is_primitive else each) for each in primitives]
    texts = [described.text for described in describe_all(members)]
    if not entity.is_primitive:  # only the first part of each: the primitive's text, or its color
        texts = list(dict.fromkeys(text.partition(",")[0] for text in texts))
    return " and ".join(texts[:_MAX_APPEARANCES])


# Encoded conditions of a scene: one embedding in Z_CLIP per prompt, with the handles of its entities.


FloatArray = npt.NDArray[np.float32]
VERSION = 1
_BATCH = 32


@dataclass(frozen=True, slots=True)
class EncodingRow:
    """The ``prompt`` of entities with the noun ``word``, and the ``handles`` of their embeddings."""

    word: str
    prompt: str
    handles: tuple[str, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Encodings:
    """Embeddings of a scene's prompts: unit vectors ``matrix`` (K, D), one per row, computed by ``model``."""

    model: str
    rows: tuple[EncodingRow, ...]
    matrix: FloatArray

    def row_of(self, handle: str) -> int | None:
        """Return the index of the row with ``handle``, or None."""
        return next((i for i, row in enumerate(self.rows) if handle in row.handles), None)

    def nearest(self, query: FloatArray) -> list[tuple[int, float]]:
        """Return all rows with their cosine similarity to ``query`` (D,), most similar first."""
        cosines = self.matrix @ (query / max(float(np.linalg.norm(query)), 1e-12))
        return [(int(i), float(cosines[i])) for i in np.argsort(-cosines, kind="stable")]


def encode_conditions(
    conditions: Sequence[PromptCondition], encoder: TextEncoder, vectors: Vectors, model: str, batch: int = _BATCH
) -> Encodings:
    """Encode every condition with g_CLIP; raises the errors of ``TextEncoder.encode``."""
    parts = []
    for start in range(0, len(conditions), batch):
        prompts = [condition.prompt for condition in conditions[start : start + batch]]
        pooled = encoder.encode(prompts, vectors).pooled.detach().float().cpu().numpy()
        parts.append(pooled / np.maximum(np.linalg.norm(pooled, axis=1, keepdims=True), 1e-12))
    rows = tuple(EncodingRow(each.word, prompt_text(each.prompt), each.handles) for each in conditions)
    matrix = np.concatenate(parts) if parts else np.zeros((0, 0), np.float32)
    return Encodings(model, rows, matrix.astype(np.float32))


def prompt_text(prompt: Prompt) -> str:
    """Format a prompt as text, with handles for its slots."""
    return "".join(f"<{piece.name}>" if isinstance(piece, Slot) else piece for piece in prompt)


def to_json(encodings: Encodings) -> dict[str, Any]:
    """Return everything except the matrix as JSON data."""
    rows = [{"word": row.word, "prompt": row.prompt, "handles": pack_handles(row.handles)} for row in encodings.rows]
    return {"version": VERSION, "model": encodings.model, "rows": rows}


def from_json(data: Mapping[str, Any], matrix: FloatArray) -> Encodings:
    """Parse the result of ``to_json``; raises ValueError, KeyError or TypeError for invalid data."""
    if data["version"] != VERSION:
        raise ValueError(f"unsupported version {str(data['version'])[:20]} of the encodings, expected {VERSION}")
    rows = tuple(
        EncodingRow(str(row["word"]), str(row["prompt"]), unpack_handles(row["handles"])) for row in data["rows"]
    )
    if matrix.ndim != 2 or len(matrix) != len(rows):
        raise ValueError("the number of encodings differs from the number of rows of their matrix")
    return Encodings(str(data["model"]), rows, np.asarray(matrix, np.float32))


# Grouping of a scene for neural backends: primitives, or intermediate nodes as new leaves (the paper, appendix
# "SDS-Based Renderer").


IntArray = npt.NDArray[np.int64]

_PATH = re.compile(r"\d+(/\d+)*\Z")


@dataclass(frozen=True, slots=True)
class Granularity:
    """Entities to treat as a unit instead of as separate primitives.

    Parameters
    ----------
    depth : int, optional
        Treat every entity at this depth below the root as a unit; None: every primitive.
    named : tuple of str
        Further units, each as a handle ``<z5>``, a path of child indices from the root ``0/2``, or a word.

    Examples
    --------
    >>> Granularity(named=("moai",))
    Granularity(depth=None, named=('moai',))
    """

    depth: int | None = setting(None, "treat each entity N levels below the root as a unit", metavar="N", read=whole)
    named: tuple[str, ...] = setting(
        (),
        "treat an entity as a unit: a handle '<z5>', a word, or a path of child indices from the root, 0/2; may be "
        "repeated",
        "--entity", metavar="NAME", repeated=True,
    )  # fmt: skip


def units_of(ancestry: Ancestry, handles: Sequence[str], granularity: Granularity) -> IntArray:
    """Return the unit of every instance (M,): its highest ancestor that ``granularity`` treats as a unit, else itself.

    ``handles`` are those of all instances.
    """
    units = np.arange(len(ancestry)) if granularity.depth is None else ancestry.at_depth(granularity.depth)
    chosen = np.zeros(len(ancestry), bool)
    for name in granularity.named:
        chosen[_instances_named(ancestry, handles, name)] = True
    if chosen.any():
        units = units.copy()
        for level in range(ancestry.max_depth + 1):  # from the root down, so that the highest unit wins
            rows = np.flatnonzero(ancestry.depth == level)
            parents = np.where(ancestry.parent[rows] >= 0, ancestry.parent[rows], rows)
            inside = chosen[units[parents]] & (parents != rows)
            units[rows] = np.where(inside, units[parents], np.where(chosen[rows], rows, units[rows]))
    return units


def check_names(frames: Sequence[tuple[Ancestry, Sequence[str]]], granularity: Granularity) -> None:
    """Raise SceneError("value") for a name without an instance in any of the frames, each with all its handles."""
    for name in granularity.named:
        if not any(_instances_named(ancestry, handles, name) for ancestry, handles in frames):
            hint = "use a handle '<z5>', a path of child indices 0/2, or a word; `scenelang tree` shows them"
            raise SceneError("value", f"the scene has no entity `{name}`", hint=hint)


def _instances_named(ancestry: Ancestry, handles: Sequence[str], name: str) -> list[int]:
    """Return the instances with a handle, path or word given by the user."""
    if _PATH.match(name):
        path = tuple(map(int, name.split("/")))
        level = np.flatnonzero(ancestry.depth == len(path)).tolist()
        return [i for i in level if ancestry.path(i) == path]
    if name.startswith("<") and name.endswith(">"):
        return [i for i, handle in enumerate(handles) if handle == name[1:-1]]
    of_word = np.array([entity.word == name for entity in ancestry.nodes], bool)
    instances: list[int] = np.flatnonzero(of_word[ancestry.node]).tolist()
    return instances


# Leaves of a scene for neural backends: primitives, or entities treated as a unit, with their prompts.


MAX_PRIMITIVES = 100_000  # of all frames; no neural backend can process more prompts


@dataclass(frozen=True, slots=True, eq=False)
class PromptLeaf:
    """Instance of a unit.

    Attributes
    ----------
    entity, handle
        Entity and handle of the instance.
    path
        Child indices from the root.
    name
        Words from the root, joined by slashes.
    condition
        Prompt.
    box
        Exact bounding box in the entity's frame.
    pose
        (3, 4), from the entity's frame to the world.
    """

    entity: Entity
    handle: str
    path: tuple[int, ...]
    name: str
    condition: PromptCondition
    box: Box
    pose: npt.NDArray[np.float64]


def leaves_of(scene: Scene, granularity: Granularity, context: PromptContext) -> list[list[PromptLeaf]]:
    """Return the leaves of every frame, in the order of the program.

    Raises SceneError: "value" for a name without an entity, "empty-scene"; LimitError for too many primitives.
    """
    check_template(context.template)
    check_not_empty(scene)
    counts = list(map(primitive_count, scene.frames))
    if sum(counts) > MAX_PRIMITIVES:
        raise LimitError("primitives", f"the scene has more than {MAX_PRIMITIVES:,} primitives")
    numbers = frame_numbers(scene) if len(scene.frames) > 1 else None
    ancestries = [ancestry_of(root) if count else None for root, count in zip(scene.frames, counts)]
    frames = [(each, instance_handles(scene, each, numbers)) for each in ancestries if each is not None]
    check_names(frames, granularity)
    leaves = iter([list(_frame_leaves(ancestry, handles, granularity, context)) for ancestry, handles in frames])
    by_frame = [next(leaves) if count else [] for count in counts]
    if not any(by_frame):
        raise _empty(scene)
    return by_frame


def check_not_empty(scene: Scene) -> None:
    """Raise SceneError("empty-scene") for a scene without primitives."""
    if not any(map(primitive_count, scene.frames)):
        raise _empty(scene)


def _empty(scene: Scene) -> SceneError:
    return SceneError("empty-scene", f'the scene "{scene.word}" has no primitives, so there is nothing to learn')


def _frame_leaves(
    ancestry: Ancestry, handles: Sequence[str], granularity: Granularity, context: PromptContext
) -> Iterator[PromptLeaf]:
    units = units_of(ancestry, handles, granularity)
    prompts = PromptBuilder(ancestry, handles, context)
    members: dict[int, list[int]] = {}
    for primitive in ancestry.primitives.tolist():
        members.setdefault(int(units[primitive]), []).append(primitive)
    for instance, primitives in members.items():
        entity, pose = ancestry.entity(instance), ancestry.poses[instance]
        box = entity_box(entity)
        if box is None or not np.isfinite(pose).all():
            continue
        ancestors = reversed(list(ancestors_of(ancestry, instance)))
        name = "/".join([*(ancestry.entity(i).word for i in ancestors), entity.word])
        condition = prompts.condition(instance, primitives)
        yield PromptLeaf(entity, handles[instance], ancestry.path(instance), name, condition, box, pose)
