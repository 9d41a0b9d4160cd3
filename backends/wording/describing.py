"""One primitive's embedding as a text: from the table of colours, or from a describer such as a language model.

What the program says comes first. What has no words, in no attribute either, is "typical".
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from scenelang.backends.appearance import Look, look_of
from scenelang.backends.wording.color_words import color_words, names_color
from scenelang.backends.wording.phrases import numbers, proportions, seen_color, surface, written
from scenelang.backends.wording.readable import thing
from scenelang.interpreter.bounds import entity_box
from scenelang.interpreter.entity import Entity
from scenelang.interpreter.plain import plain_attributes
from scenelang.interpreter.shapes import Point

MAX_TEXT = 300  # characters of a text made here; a program's own text is kept whole
MAX_ANSWER = 120
MAX_QUESTIONS = 256
UNDESCRIBED = "typical"


@dataclass(frozen=True, slots=True)
class Question:
    """What a describer is asked: words for a thing ``word`` with ``attributes`` (plain data, as in JSON), whose colour
    the table calls ``color`` (None where it has none) and whose text, without an answer, is ``text``."""

    word: str
    attributes: Mapping[str, Any]
    color: str | None
    text: str


Describe = Callable[[Sequence[Question]], Sequence[str]]


@dataclass(frozen=True, slots=True)
class Member:
    """A primitive and the entity whose word it takes: itself, or the nearest one around it that says what it is."""

    primitive: Entity
    named: Entity


@dataclass(frozen=True, slots=True)
class Description:
    """``word`` is what the thing is, ``text`` how it looks."""

    word: str
    text: str


@dataclass(frozen=True, slots=True)
class _Facts:
    """What is known of a member: the program's own texts (of the primitive, and of what it is a part of), what the
    attributes say in writing, and how it looks."""

    texts: tuple[str, ...]
    written: tuple[str, ...]
    look: Look


def describe_all(members: Sequence[Member], describe: Describe | None = None) -> list[Description]:
    """A description of each member; ``describe`` is asked once for each that reads alike, about those without a text
    in the program. An answer that is no short line of text is not taken. Raises SceneError("attribute")."""
    facts = [_facts(member) for member in members]
    colors = _colors(members, facts)
    found = [Description(thing(m.named), _text(m, fact, color)) for m, fact, color in zip(members, facts, colors)]
    if describe is None:
        return found
    questions: dict[Description, Question] = {}
    for member, fact, description, color in zip(members, facts, found, colors):
        if not fact.texts and description not in questions and len(questions) < MAX_QUESTIONS:
            attributes = plain_attributes(member.primitive)
            questions[description] = Question(description.word, attributes, color, description.text)
    answers = describe(tuple(questions.values())) if questions else ()
    better = {asked: text for asked, answer in zip(questions, answers) if (text := _accepted(answer)) is not None}
    return [d if fact.texts else Description(d.word, better.get(d, d.text)) for d, fact in zip(found, facts)]


def _accepted(answer: object) -> str | None:
    text = answer.strip() if isinstance(answer, str) else ""
    return text if 0 < len(text) <= MAX_ANSWER and text.isprintable() else None


def _facts(member: Member) -> _Facts:
    entities = tuple(dict.fromkeys((member.primitive, member.named)))
    texts = (entity.embedding.text for entity in entities)
    given = dict.fromkeys(text.strip() for text in texts if text is not None and text.strip())
    says = (text for entity in entities for text in written(entity))
    return _Facts(tuple(given), tuple(says), look_of(member.primitive))


def _colors(members: Sequence[Member], facts: Sequence[_Facts]) -> list[str | None]:
    """The colour words; None where there is no colour, or the program's words leave no room for one."""
    shown = [_shown(member, fact) for member, fact in zip(members, facts)]
    words = iter(color_words([color for color in shown if color is not None]))
    return [None if color is None else next(words) for color in shown]


def _shown(member: Member, facts: _Facts) -> Point | None:
    seen = seen_color(member.primitive, facts.look)
    said = (*facts.texts, *facts.written)
    if seen is None or (said and (not seen[1] or any(map(names_color, said)))):
        return None
    return seen[0]


def _text(member: Member, facts: _Facts, color: str | None) -> str:
    shape = proportions(entity_box(member.named))
    parts = [
        *facts.written,
        *([color] if color else []),
        *surface(facts.look),
        *([shape] if shape else []),
        *numbers(member.primitive),
    ]
    return _joined(", ".join(facts.texts), parts) or UNDESCRIBED


def _joined(start: str, parts: Iterable[str]) -> str:
    """``start`` and what ``parts`` add to it, as far as there is room; nothing is said twice."""
    text = start
    for part in parts:
        longer = f"{text}, {part}" if text else part
        if not _says(text, part) and len(longer) <= MAX_TEXT:
            text = longer
    return text


def _says(text: str, part: str) -> bool:
    """Whether ``part`` stands in ``text`` as words of its own: "red" is not in "weathered"."""
    return re.search(rf"(?<!\w){re.escape(part.lower())}(?!\w)", text.lower()) is not None
