"""The wording of a scene: a text for every primitive's embedding, and the template that its condition is made of.

Primitives with the same words share a row, so a scene of many equal things has few of them.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import islice

import numpy as np
import numpy.typing as npt

from scenelang.backends.wording.describing import Describe, Description, Member, describe_all
from scenelang.backends.wording.handles import MAX_HANDLES, in_order
from scenelang.backends.wording.readable import has_meaning, thing
from scenelang.backends.wording.templates import DEFAULT, template_for
from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.ancestry import ancestry_of
from scenelang.interpreter.entity import Entity, Scene
from scenelang.interpreter.flatten import flatten
from scenelang.interpreter.numbering import number_scene, primitive_handles

LIMIT = 1_000_000  # primitives of all frames together, unless more are asked for


@dataclass(frozen=True, slots=True)
class Row:
    """``handles`` are the embeddings, in order, of primitives called ``word`` that look as ``text`` says; ``template``
    is their sentence, with `{embedding}` for each handle."""

    word: str
    text: str
    template: str
    handles: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Wording:
    """``style`` is the root's handle, ``style_text`` its text; a handle has one text in all rows."""

    style: str
    style_text: str
    rows: tuple[Row, ...]


def wording_of(scene: Scene, template: str = DEFAULT, describe: Describe | None = None, limit: int = LIMIT) -> Wording:
    """The wording of every primitive of every frame; of an embedding that several primitives share the first counts.

    Raises SceneError: LimitError beyond ``limit`` primitives, "empty-scene", "attribute".
    """
    handles = primitive_handles(scene, flatten(scene, min(limit, MAX_HANDLES)))
    frames = [_members(root) for root in scene.frames]
    described = iter(describe_all([member for members, _ in frames for member in members], describe))
    texts: dict[str, str] = {}
    found: list[tuple[str, str, str]] = []  # handle, word, text
    for (members, which), of_frame in zip(frames, handles):
        found += _of_frame(members, list(islice(described, len(members))), which, of_frame, texts)
    if not found:
        raise SceneError("empty-scene", f'the scene "{scene.word}" has no primitives, so there is nothing to describe')
    style = number_scene(scene).handle(scene.root, 0)
    style_text = texts.get(style) or (scene.root.embedding.text or "").strip() or thing(scene.root)
    return Wording(style, style_text, _rows((h, w, t, template_for(template, w, style)) for h, w, t in found))


def merged(old: Wording, new: Wording) -> tuple[Wording, int]:
    """``new`` with the texts and templates that ``old`` has for its handles, all of ``old`` kept; and how many handles
    of ``new`` were there before."""
    texts = {handle: row.text for row in old.rows for handle in row.handles}
    kept = {(handle, row.word) for row in old.rows for handle in row.handles}
    fresh = _each(new.rows)
    added = ((h, w, texts.get(h, t), template) for h, w, t, template in fresh if (h, w) not in kept)
    rows = _rows([*_each(old.rows), *added])
    known = len({handle for row in new.rows for handle in row.handles} & texts.keys())
    return replace(new if old.style != new.style else old, rows=rows), known


def _each(rows: Iterable[Row]) -> list[tuple[str, str, str, str]]:
    return [(handle, row.word, row.text, row.template) for row in rows for handle in row.handles]


def _rows(found: Iterable[tuple[str, str, str, str]]) -> tuple[Row, ...]:
    """Rows of (handle, word, text, template), those with equal words together."""
    groups: dict[tuple[str, str, str], set[str]] = {}
    for handle, *rest in found:
        word, text, template = rest
        groups.setdefault((word, text, template), set()).add(handle)
    return tuple(Row(*words, in_order(group)) for words, group in groups.items())


def _of_frame(
    members: Sequence[Member],
    described: Sequence[Description],
    which: npt.NDArray[np.int64],
    handles: Sequence[str],
    texts: dict[str, str],
) -> Iterable[tuple[str, str, str]]:
    """Handle, word and text of one frame's primitives that have geometry; ``texts`` grows by those of new handles."""
    for handle, i in zip(handles, which.tolist()):
        shape = members[i].primitive.shape
        if shape is not None and shape.has_geometry:
            yield handle, described[i].word, texts.setdefault(handle, described[i].text)


def _members(root: Entity) -> tuple[list[Member], npt.NDArray[np.int64]]:
    """The distinct pairs of a primitive and what it is called after; for each primitive (N,) the place of its pair."""
    ancestry = ancestry_of(root)
    meaning = np.array([has_meaning(entity.word) for entity in ancestry.nodes])
    above = np.where(meaning[ancestry.node] | (ancestry.parent < 0), np.arange(len(ancestry)), ancestry.parent)
    while not np.array_equal(higher := above[above], above):
        above = higher
    named = ancestry.node[above[ancestry.primitives]]
    own = ancestry.node[ancestry.primitives]
    named = np.where(meaning[named], named, own)  # with no meaning all the way up it is what it is made of
    pairs, which = np.unique(own * len(ancestry.nodes) + named, return_inverse=True)
    found = (divmod(pair, len(ancestry.nodes)) for pair in pairs.tolist())
    return [Member(ancestry.nodes[i], ancestry.nodes[j]) for i, j in found], which.reshape(-1)
