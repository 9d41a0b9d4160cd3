"""Wording of a scene: a text for every primitive's embedding, and the template of its prompt.

Primitives with the same word, text and template share a row, so a scene of many equal objects has few rows.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import cycle, islice, pairwise
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.neural.descriptions import Describe, Description, Member, describe_all, has_meaning, noun_of
from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.inspection.numbering import ancestry_of, number_scene, primitive_handles
from scenelang.interpreter.scene.entity import Entity, Scene
from scenelang.interpreter.scene.flatten import flatten

# Run-length encoding of handles: numbers whose differences repeat with a period, as those of repeated objects do, are
# stored as one item.


MAX_HANDLES = 4_000_000
_NUMBERED = re.compile(r"z([1-9]\d{0,17})\Z")
_MAX_PERIOD = 48
_MIN_RUN = 4  # shorter runs are stored as single handles

Item = str | list[int]


def sort_handles(handles: Iterable[str]) -> tuple[str, ...]:
    """Sort handles, without duplicates: names alphabetically, then numbered ones numerically."""
    names, numbers = _split_handles(set(handles))
    return (*names, *(f"z{number}" for number in numbers))


def pack_handles(handles: Sequence[str]) -> list[Item]:
    """Encode sorted handles as JSON data: `"young"`, or a run `[first, count, step, step ...]` with repeating steps."""
    names, numbers = _split_handles(handles)
    items: list[Item] = [*names]
    steps = [b - a for a, b in pairwise(numbers)]
    at = 0
    while at < len(numbers):
        period, count = _longest_run(steps, at)
        if count >= _MIN_RUN:
            items.append([numbers[at], count, *steps[at : at + period]])
            at += count
        else:
            items.append(f"z{numbers[at]}")
            at += 1
    return items


def unpack_handles(items: Iterable[object]) -> tuple[str, ...]:
    """Decode the result of ``pack_handles``; raises ValueError for invalid data."""
    handles: list[str] = []
    for item in items:
        if isinstance(item, str) and item:
            handles.append(item)
        elif isinstance(item, list) and len(item) > 2 and all(type(n) is int and n > 0 for n in item):
            if len(handles) + item[1] > MAX_HANDLES:
                raise ValueError(f"more than {MAX_HANDLES:,} handles")
            handles += _expand_run(item[0], item[1], item[2:])
        else:
            raise ValueError("a handle must be a string or a run of numbers")
    return tuple(handles)


def _expand_run(first: int, count: int, steps: Sequence[int]) -> Iterator[str]:
    number = first
    for _, step in zip(range(count), cycle(steps)):
        yield f"z{number}"
        number += step


def _longest_run(steps: Sequence[int], at: int) -> tuple[int, int]:
    """Return the period of the longest periodic run of steps from index ``at``, and how many numbers it covers."""
    best = (1, 1)
    for period in range(1, _MAX_PERIOD + 1):
        end = at + period
        while end < len(steps) and steps[end] == steps[end - period]:
            end += 1
        covered = min(end, len(steps)) - at + 1
        if end - at >= 2 * period and covered > best[1]:  # a period must occur at least twice
            best = (period, covered)
    return best


def _split_handles(handles: Iterable[str]) -> tuple[list[str], list[int]]:
    """Return the sorted names and the sorted numbers of handles."""
    names: list[str] = []
    numbers: list[int] = []
    for handle in handles:
        match = _NUMBERED.match(handle)
        if match:
            numbers.append(int(match[1]))
        else:
            names.append(handle)
    return sorted(names), sorted(numbers)


# Language templates: the prompt that describes one primitive to a neural backend (the paper, section 4).


DEFAULT_TEMPLATE = "a {embedding} {word}, in the style of {style}, 3D model"
PLACEHOLDER = "{embedding}"
MAX_TEMPLATE = 500  # characters
_PLACEHOLDERS = (PLACEHOLDER, "{word}", "{style}")
_BRACES = re.compile(r"\{[^{}]*\}|[{}]")
_MAX_ADJECTIVE_WORDS = 3  # longer parts of a text follow the noun
_CONSONANT_SOUNDS = ("uni", "use", "eu", "one")  # spelled with a vowel, pronounced with a consonant


def check_template(template: str) -> None:
    """Raise SceneError("value") for a template with several lines or unknown placeholders, or without {embedding}."""
    known = "the placeholders are {embedding}, {word} and {style}"
    for brace in _BRACES.findall(template):
        if brace not in _PLACEHOLDERS:
            raise SceneError("value", f"unknown placeholder `{brace}` in the template", known)
    if PLACEHOLDER not in template:
        raise SceneError("value", "the template must contain the placeholder {embedding}", known)
    if len(template) > MAX_TEMPLATE or not template.isprintable():
        raise SceneError("value", f"a template must be one line of at most {MAX_TEMPLATE} characters")


def fill_template(template: str, word: str, style: str) -> str:
    """Fill in the noun ``word`` and the root's handle ``style``; only the placeholder ``{embedding}`` remains."""
    return template.replace("{style}", f"<{style}>").replace("{word}", word)


def prompt_for(template: str, handle: str) -> str:
    """Return the prompt of the primitive with ``handle``: `a <z68> pawn, in the style of <z1>, 3D model`."""
    return template.replace(PLACEHOLDER, f"<{handle}>")


def plain_text(word: str, text: str) -> str:
    """Return a prompt without handles, for models that read plain text: `an ivory pawn, 3D model`.

    Long parts of the text, and numbers, follow the noun: `a tall door, height 3, 3D model`.
    """
    parts = [part for part in re.split(r"\s*[,;\n]\s*", text) if part]
    before = [part for part in parts if len(part.split()) <= _MAX_ADJECTIVE_WORDS and not re.search(r"\d", part)]
    after = [part for part in parts if part not in before]
    phrase = f"{', '.join(before)} {word}".strip()
    return ", ".join([fix_article(f"a {phrase}"), *after, "3D model"])


def fix_article(text: str) -> str:
    """Replace the article "a" at the beginning of a text by "an" before a vowel sound: `an ivory pawn`."""
    rest = text.removeprefix("a ")
    vowel = rest[:1].lower() in tuple("aeiou") and not rest.lower().startswith(_CONSONANT_SOUNDS)
    return f"an {rest}" if vowel and rest != text else text


DEFAULT_LIMIT = 1_000_000  # primitives of all frames together


@dataclass(frozen=True, slots=True)
class WordingRow:
    """Primitives with the noun ``word``, the appearance ``text`` and the prompt ``template``, which has the placeholder
    `{embedding}`; ``handles`` are those of their embeddings, sorted."""

    word: str
    text: str
    template: str
    handles: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Wording:
    """Texts of a scene: the root's handle ``style`` with its ``style_text``, and one text per handle in ``rows``."""

    style: str
    style_text: str
    rows: tuple[WordingRow, ...]


def wording_of(
    scene: Scene, template: str = DEFAULT_TEMPLATE, describe: Describe | None = None, limit: int = DEFAULT_LIMIT
) -> Wording:
    """Describe every primitive of every frame; an embedding shared by several primitives has the text of the first.

    Raises SceneError: "empty-scene", "attribute"; LimitError for more than ``limit`` primitives.
    """
    handles = primitive_handles(scene, flatten(scene, min(limit, MAX_HANDLES)))
    frames = [_members(root) for root in scene.frames]
    described = iter(describe_all([member for members, _ in frames for member in members], describe))
    texts: dict[str, str] = {}
    rows: list[tuple[str, str, str]] = []  # handle, word, text
    for (members, member_index), frame_handles in zip(frames, handles):
        rows += _frame_texts(members, list(islice(described, len(members))), member_index, frame_handles, texts)
    if not rows:
        raise SceneError("empty-scene", f'the scene "{scene.word}" has no primitives, so there is nothing to describe')
    style = number_scene(scene).handle(scene.root, 0)
    style_text = texts.get(style) or (scene.root.embedding.text or "").strip() or noun_of(scene.root)
    return Wording(style, style_text, _group_rows((h, w, t, fill_template(template, w, style)) for h, w, t in rows))


def merge(old: Wording, new: Wording) -> tuple[Wording, int]:
    """Add the handles of ``new`` to ``old``, without changing the texts and templates in ``old``.

    Returns the result, and how many handles of ``new`` were in ``old`` already.
    """
    texts = {handle: row.text for row in old.rows for handle in row.handles}
    existing = {(handle, row.word) for row in old.rows for handle in row.handles}
    entries = _entries(new.rows)
    added = ((h, w, texts.get(h, t), template) for h, w, t, template in entries if (h, w) not in existing)
    rows = _group_rows([*_entries(old.rows), *added])
    known = len({handle for row in new.rows for handle in row.handles} & texts.keys())
    return replace(new if old.style != new.style else old, rows=rows), known


def _entries(rows: Iterable[WordingRow]) -> list[tuple[str, str, str, str]]:
    """Return an entry (handle, word, text, template) for every handle."""
    return [(handle, row.word, row.text, row.template) for row in rows for handle in row.handles]


def _group_rows(entries: Iterable[tuple[str, str, str, str]]) -> tuple[WordingRow, ...]:
    """Group entries (handle, word, text, template) by word, text and template."""
    groups: dict[tuple[str, str, str], set[str]] = {}
    for handle, *rest in entries:
        word, text, template = rest
        groups.setdefault((word, text, template), set()).add(handle)
    return tuple(WordingRow(*words, sort_handles(group)) for words, group in groups.items())


def _frame_texts(
    members: Sequence[Member],
    described: Sequence[Description],
    member_index: npt.NDArray[np.int64],
    handles: Sequence[str],
    texts: dict[str, str],
) -> Iterable[tuple[str, str, str]]:
    """Yield handle, word and text of one frame's primitives with geometry; adds the texts of new handles to ``texts``.

    ``member_index`` maps each primitive to its member.
    """
    for handle, i in zip(handles, member_index.tolist()):
        shape = members[i].primitive.shape
        if shape is not None and shape.has_geometry:
            yield handle, described[i].word, texts.setdefault(handle, described[i].text)


def _members(root: Entity) -> tuple[list[Member], npt.NDArray[np.int64]]:
    """Return the distinct members of a frame, and the index (N,) of each primitive's member."""
    ancestry = ancestry_of(root)
    meaning = np.array([has_meaning(entity.word) for entity in ancestry.nodes])
    # pointer jumping: doubles the distance to the nearest meaningful ancestor in every pass
    target = np.where(meaning[ancestry.node] | (ancestry.parent < 0), np.arange(len(ancestry)), ancestry.parent)
    while not np.array_equal(farther := target[target], target):
        target = farther
    named = ancestry.node[target[ancestry.primitives]]
    own = ancestry.node[ancestry.primitives]
    named = np.where(meaning[named], named, own)  # without a meaningful ancestor, the primitive's own word
    pairs, which = np.unique(own * len(ancestry.nodes) + named, return_inverse=True)
    distinct = (divmod(pair, len(ancestry.nodes)) for pair in pairs.tolist())
    return [Member(ancestry.nodes[i], ancestry.nodes[j]) for i, j in distinct], which.reshape(-1)


# JSON form of a wording, in the header of the file Z (docs/embeddings.md documents it).


VERSION = 1


def to_json(wording: Wording) -> dict[str, Any]:
    """Return the wording as JSON data."""
    return {
        "version": VERSION,
        "style": {"handle": wording.style, "text": wording.style_text},
        "rows": [
            {"word": row.word, "text": row.text, "template": row.template, "handles": pack_handles(row.handles)}
            for row in wording.rows
        ],
    }


def from_json(data: Any) -> Wording:
    """Parse the result of ``to_json``; raises ValueError, KeyError, TypeError or AttributeError for invalid data."""
    if data["version"] != VERSION:
        raise ValueError(f"unsupported version {str(data['version'])[:20]} of the wording, expected {VERSION}")
    rows = tuple(
        WordingRow(_text(row["word"]), _text(row["text"]), _text(row["template"]), unpack_handles(row["handles"]))
        for row in data["rows"]
    )
    return Wording(_text(data["style"]["handle"]), _text(data["style"]["text"]), rows)


def _text(value: object) -> str:
    if not isinstance(value, str) or not value:
        raise ValueError("expected a non-empty text in the wording")
    return value
