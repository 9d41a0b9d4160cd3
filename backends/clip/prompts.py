"""Prompts with handles: text in which `<z2>` stands for learned vectors, or for a text of its own."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass

_HANDLE = re.compile(r"<([A-Za-z][A-Za-z0-9_-]*\*?)>")


@dataclass(frozen=True, slots=True)
class Slot:
    """The place of the handle ``name`` in a prompt."""

    name: str


Prompt = tuple[str | Slot, ...]  # no two texts beside each other, no empty ones


def parse_prompt(text: str) -> Prompt:
    """``a <z2> moai`` as its parts: ``("a ", Slot("z2"), " moai")``."""
    pieces: list[str | Slot] = []
    for number, piece in enumerate(_HANDLE.split(text)):
        if number % 2:
            pieces.append(Slot(piece))
        elif piece:
            pieces.append(piece)
    return tuple(pieces)


def with_texts(prompt: Prompt, text_of: Callable[[str], str | None]) -> Prompt:
    """The prompt with the slots that ``text_of`` has a text for written out."""
    pieces: list[str | Slot] = []
    for piece in prompt:
        text = text_of(piece.name) if isinstance(piece, Slot) else piece
        if text is None:
            pieces.append(piece)
        elif pieces and isinstance(pieces[-1], str):
            pieces[-1] += text
        elif text:
            pieces.append(text)
    return tuple(pieces)


def slots(prompt: Prompt) -> tuple[str, ...]:
    """The names of the handles in a prompt, each once, in order."""
    return tuple(dict.fromkeys(piece.name for piece in prompt if isinstance(piece, Slot)))
