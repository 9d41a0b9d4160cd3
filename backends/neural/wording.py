"""The wording of a scene: a text for every primitive's embedding, and the template that its condition is made of.

Primitives with the same words share a row, so a scene of many equal things has few of them.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import cycle, islice, pairwise
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.neural.describing import Describe, Description, Member, describe_all, has_meaning, thing
from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.scene.entity import Entity, Scene
from scenelang.interpreter.scene.flatten import flatten
from scenelang.interpreter.scene.numbering import ancestry_of, number_scene, primitive_handles

# Many handles in little room: numbers that go on in a rhythm, as those of repeated things do, are one item.


MAX_HANDLES = 4_000_000
_NUMBERED = re.compile(r"z([1-9]\d{0,17})\Z")
_LONGEST = 48  # numbers in the longest rhythm
_FEWEST = 4  # handles that are worth an item of their own

Item = str | list[int]


def in_order(handles: Iterable[str]) -> tuple[str, ...]:
    """Handles with names of their own, sorted, then those that are numbers, ascending."""
    names, numbers = _parted(set(handles))
    return (*names, *(f"z{number}" for number in numbers))


def packed(handles: Sequence[str]) -> list[Item]:
    """Handles in order as JSON data: `"young"`, or `[first, count, step, step ...]`, the steps repeated."""
    names, numbers = _parted(handles)
    items: list[Item] = [*names]
    steps = [b - a for a, b in pairwise(numbers)]
    at = 0
    while at < len(numbers):
        period, count = _rhythm(steps, at)
        if count >= _FEWEST:
            items.append([numbers[at], count, *steps[at : at + period]])
            at += count
        else:
            items.append(f"z{numbers[at]}")
            at += 1
    return items


def unpacked(items: Iterable[object]) -> tuple[str, ...]:
    """The inverse of ``packed``; raises ValueError for what is none."""
    found: list[str] = []
    for item in items:
        if isinstance(item, str) and item:
            found.append(item)
        elif isinstance(item, list) and len(item) > 2 and all(type(n) is int and n > 0 for n in item):
            if len(found) + item[1] > MAX_HANDLES:
                raise ValueError("more handles than a scene has")
            found += _counted(item[0], item[1], item[2:])
        else:
            raise ValueError("a handle must be a string or a run of numbers")
    return tuple(found)


def _counted(first: int, count: int, steps: Sequence[int]) -> Iterator[str]:
    number = first
    for _, step in zip(range(count), cycle(steps)):
        yield f"z{number}"
        number += step


def _rhythm(steps: Sequence[int], at: int) -> tuple[int, int]:
    """The steps of the rhythm that goes on longest from place ``at``, and how many numbers it covers."""
    best = (1, 1)
    for period in range(1, _LONGEST + 1):
        end = at + period
        while end < len(steps) and steps[end] == steps[end - period]:
            end += 1
        covered = min(end, len(steps)) - at + 1
        if end - at >= 2 * period and covered > best[1]:
            best = (period, covered)
    return best


def _parted(handles: Iterable[str]) -> tuple[list[str], list[int]]:
    names: list[str] = []
    numbers: list[int] = []
    for handle in handles:
        match = _NUMBERED.match(handle)
        if match:
            numbers.append(int(match[1]))
        else:
            names.append(handle)
    return sorted(names), sorted(numbers)


# Language templates: the sentence that describes one primitive to a neural backend (paper, section 4).


DEFAULT = "a {embedding} {word}, in the style of {style}, 3D model"
HOLE = "{embedding}"
MAX_TEMPLATE = 500  # characters
_HOLES = (HOLE, "{word}", "{style}")
_LONE = re.compile(r"\{[^{}]*\}|[{}]")
_ADJECTIVE = 3  # words of the longest part of a text that stands before the thing
_CONSONANT = ("uni", "use", "eu", "one")  # written with a vowel, spoken with a consonant


def check_template(template: str) -> None:
    """Raises SceneError("value") for a template that is no line of text, or whose braces mean nothing."""
    known = "a template knows {embedding}, {word} and {style}"
    for brace in _LONE.findall(template):
        if brace not in _HOLES:
            raise SceneError("value", f"`{brace}` is not a placeholder of a template", known)
    if HOLE not in template:
        raise SceneError("value", "a template without {embedding} says nothing of how a thing looks", known)
    if len(template) > MAX_TEMPLATE or not template.isprintable():
        raise SceneError("value", f"a template is one line of at most {MAX_TEMPLATE} characters")


def template_for(template: str, word: str, style: str) -> str:
    """The template of things called ``word`` under the root's handle ``style``; only ``{embedding}`` is left open."""
    return template.replace("{style}", f"<{style}>").replace("{word}", word)


def filled(template: str, handle: str) -> str:
    """The sentence for the primitive with ``handle``: `a <z68> pawn, in the style of <z1>, 3D model`."""
    return template.replace(HOLE, f"<{handle}>")


def plain_text(word: str, text: str) -> str:
    """The sentence without handles, for models that read plain text: `an ivory pawn, 3D model`. Longer parts of the
    text, and numbers, follow the thing: `a tall door, height 3, 3D model`."""
    parts = [part for part in re.split(r"\s*[,;\n]\s*", text) if part]
    before = [part for part in parts if len(part.split()) <= _ADJECTIVE and not re.search(r"\d", part)]
    after = [part for part in parts if part not in before]
    phrase = f"{', '.join(before)} {word}".strip()
    return ", ".join([with_article(f"a {phrase}"), *after, "3D model"])


def with_article(sentence: str) -> str:
    """A sentence that begins with "a" with "an" where that is how it is spoken: `an ivory pawn`."""
    rest = sentence.removeprefix("a ")
    vowel = rest[:1].lower() in tuple("aeiou") and not rest.lower().startswith(_CONSONANT)
    return f"an {rest}" if vowel and rest != sentence else sentence


LIMIT = 1_000_000  # primitives of all frames together, unless more are asked for


@dataclass(frozen=True, slots=True)
class WordingRow:
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
    rows: tuple[WordingRow, ...]


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


def _each(rows: Iterable[WordingRow]) -> list[tuple[str, str, str, str]]:
    return [(handle, row.word, row.text, row.template) for row in rows for handle in row.handles]


def _rows(found: Iterable[tuple[str, str, str, str]]) -> tuple[WordingRow, ...]:
    """Rows of (handle, word, text, template), those with equal words together."""
    groups: dict[tuple[str, str, str], set[str]] = {}
    for handle, *rest in found:
        word, text, template = rest
        groups.setdefault((word, text, template), set()).add(handle)
    return tuple(WordingRow(*words, in_order(group)) for words, group in groups.items())


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


# A wording as JSON data and back, for the header of the file Z (docs/embeddings.md shows the form).


VERSION = 1


def to_json(wording: Wording) -> dict[str, Any]:
    """The wording as JSON data."""
    return {
        "version": VERSION,
        "style": {"handle": wording.style, "text": wording.style_text},
        "rows": [
            {"word": row.word, "text": row.text, "template": row.template, "handles": packed(row.handles)}
            for row in wording.rows
        ],
    }


def from_json(data: Any) -> Wording:
    """The inverse of ``to_json``; raises ValueError, KeyError, TypeError or AttributeError for what is none."""
    if data["version"] != VERSION:
        raise ValueError(f"its wording is of version {str(data['version'])[:20]}; this program knows {VERSION}")
    rows = tuple(
        WordingRow(_text(row["word"]), _text(row["text"]), _text(row["template"]), unpacked(row["handles"]))
        for row in data["rows"]
    )
    return Wording(_text(data["style"]["handle"]), _text(data["style"]["text"]), rows)


def _text(value: object) -> str:
    if not isinstance(value, str) or not value:
        raise ValueError("a wording is made of texts")
    return value
