"""What an export says of an entity besides its geometry: word, handle, text, attributes."""

from __future__ import annotations

import json
from typing import Any

from scenelang.interpreter.entity import Entity, count_words, primitive_count
from scenelang.interpreter.plain import plain_attributes

_LONGEST = 4_000  # characters of an attribute; what is longer is left out


def facts_of(entity: Entity) -> dict[str, Any]:
    """``word`` and, where given, ``handle`` (no brackets), ``text`` and the plain ``attributes``, as JSON data."""
    embedding = entity.embedding
    found: dict[str, Any] = {"word": entity.word}
    if embedding.handle is not None:
        found["handle"] = embedding.handle
    if embedding.text is not None:
        found["text"] = embedding.text
    if embedding.attributes:
        attributes = {name: value for name, value in plain_attributes(entity).items() if _is_short(value)}
        if attributes:
            found["attributes"] = attributes
    return found


def merged_facts(entity: Entity) -> dict[str, Any]:
    """``facts_of`` with ``words``, the instances of each word below the merged entity, and ``primitives``."""
    words = count_words(entity)
    words[entity.word] -= 1
    below = {word: count for word, count in words.items() if count}
    return facts_of(entity) | {"words": below, "primitives": primitive_count(entity)}


def _is_short(value: Any) -> bool:
    return len(json.dumps(value)) <= _LONGEST
