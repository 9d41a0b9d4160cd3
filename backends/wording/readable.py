"""Words of programs, kinds of blocks and values of attributes as a person would write them."""

from __future__ import annotations

import re
from pathlib import PurePosixPath
from typing import Any

from scenelang.grammar.datum import Keyword, Symbol
from scenelang.interpreter.entity import Entity
from scenelang.interpreter.shapes import WORDS

MAX_PART = 80  # characters of one part of a text that comes from an attribute
_LARGEST = 1e15  # what is beyond is no number that a person would read

_NAMESPACED = re.compile(r"[a-z_]+:[a-z0-9_]+(\[.*)?\Z")

_MEANINGS = {"set-cuboid": "block", "asset": "object"}


def has_meaning(word: str) -> bool:
    """Whether a word says what a thing is: `"pawn"` does, `"cube"` only says what it is made of."""
    return word not in WORDS


def thing(entity: Entity) -> str:
    """What an entity is, in words: `"piece_body"` is a piece body, a mesh file with no other word has its own name."""
    if entity.word == "asset" and entity.shape is not None and entity.shape.file:
        return spaced(PurePosixPath(entity.shape.file).stem) or "object"
    return _MEANINGS.get(entity.word) or spaced(entity.word) or "thing"


def spaced(name: str) -> str:
    """A name with spaces for its marks, `"oak_planks"` as `"oak planks"`; may be empty."""
    return " ".join(re.sub(r"[^\w'’]|_", " ", name).split())[:MAX_PART].strip()


def block(kind: str) -> str:
    """What blocks are made of: `"minecraft:oak_planks"` is oak planks. States in brackets are left out."""
    return spaced(kind.partition("[")[0].rpartition(":")[2])


def said(value: Any) -> str | None:
    """A string or symbol as it is, on one line, a name such as `minecraft:stone` as blocks have it; None for any other
    value, and for one that says nothing: a single letter is an axis or a label."""
    if not isinstance(value, (str, Symbol, Keyword)):
        return None
    text = " ".join(str(value).split())
    text = block(text) if _NAMESPACED.match(text) else text[:MAX_PART].strip()
    return text if len(text) > 1 else None


def measured(name: str, value: Any) -> str | None:
    """A number under its name, `"window count 4"`; True is the name alone, None is no number that can be read."""
    if value is True:
        return spaced(name) or None
    if type(value) in (int, float) and abs(value) < _LARGEST:
        return f"{spaced(name)} {value:.4g}".strip()
    return None
