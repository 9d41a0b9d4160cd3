"""Prompts as the tokens that a text encoder reads, with learned vectors in the places of handles."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from scenelang.backends.base import need
from scenelang.backends.clip.prompts import Prompt, Slot
from scenelang.backends.weights import INSTALL
from scenelang.grammar.diagnostics import SceneError

Vectors = Mapping[str, Any]  # by handle: tensors (K, width) in the space of the tokens' own vectors, K words each


@dataclass(frozen=True, slots=True, eq=False)
class Tokens:
    """Prompts as token numbers ``ids`` (B, T), with ``vectors`` (B, T, width) in the places where ``mask`` (B, T);
    ``ends`` (B,) are the places of the end tokens."""

    ids: Any
    vectors: Any
    mask: Any
    ends: Any


@dataclass(frozen=True, slots=True, eq=False)
class Vocabulary:
    """How an encoder reads text: ``numbers`` gives the tokens of a text, ``start``, ``end`` and ``padding`` stand
    around them; ``context`` tokens in all, each a vector of ``width``."""

    numbers: Callable[[str], list[int]]
    start: int
    end: int
    padding: int
    context: int
    width: int


def tokens_of(prompts: Sequence[Prompt], vectors: Vectors, vocabulary: Vocabulary, device: Any) -> Tokens:
    """What an encoder reads of each prompt; longer ones are cut, as CLIP does.

    Raises SceneError("value") for a handle without vectors, or of vectors of another width.
    """
    torch = need("torch", INSTALL)
    context, width = vocabulary.context, vocabulary.width
    ids = torch.full((len(prompts), context), vocabulary.padding, dtype=torch.long, device=device)
    mask = torch.zeros((len(prompts), context), dtype=torch.bool, device=device)
    rows, ends = [], []
    for b, prompt in enumerate(prompts):
        pieces = [_piece(piece, vectors, vocabulary) for piece in prompt]
        numbers = [n for piece, _ in pieces for n in piece][: context - 2]
        learned = [vector for _, piece in pieces for vector in piece][: context - 2]
        line = [vocabulary.start, *numbers, vocabulary.end]
        ids[b, : len(line)] = torch.tensor(line, device=device)
        zero = torch.zeros(width, device=device)
        row = [zero, *(zero if vector is None else vector.to(device) for vector in learned)]
        for place, vector in enumerate(learned, start=1):
            mask[b, place] = vector is not None
        rows.append(torch.stack([*row, *[zero] * (context - len(row))]))
        ends.append(len(line) - 1)
    return Tokens(ids, torch.stack(rows), mask, torch.tensor(ends, device=device))


def _piece(piece: str | Slot, vectors: Vectors, vocabulary: Vocabulary) -> tuple[list[int], list[Any]]:
    """The token numbers of a piece, and the vector in place of each, None for a token's own."""
    if isinstance(piece, str):
        numbers = vocabulary.numbers(piece)
        return numbers, [None] * len(numbers)
    found = vectors.get(piece.name)
    if found is None:
        raise SceneError("value", f"nothing is known of <{piece.name}>: neither vectors nor a text")
    if found.ndim != 2 or found.shape[1] != vocabulary.width:
        shape = " x ".join(map(str, found.shape))
        message = f"the vectors of <{piece.name}> are {shape}; those of this model are {vocabulary.width} wide"
        raise SceneError("value", message, hint="they were learned for another model")
    return [0] * len(found), list(found)
