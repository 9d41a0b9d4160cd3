"""Tokens counted without a service: never fewer than there are."""

from __future__ import annotations

import math

from scenelang.backends.language_models.conversation import Blocks, Picture, Request, Text

_BYTES_PER_TOKEN = 2  # fewer than the tokens of prose and programs have
_TOKENS_OF_PICTURE = 6_000  # more than the largest picture that services take
_FRAME = 100  # what services add around a request


def tokens_at_most(text: str) -> int:
    """More tokens than a text has."""
    return math.ceil(len(text.encode()) / _BYTES_PER_TOKEN)


def upper_estimate(request: Request) -> int:
    """More tokens than a request has."""
    parts = [part for turn in request.turns for part in turn.parts]
    texts = [request.system.text, *(part.text for part in parts if isinstance(part, Text))]
    texts += [str(block) for part in parts if isinstance(part, Blocks) for block in part.blocks]
    pictures = sum(isinstance(part, Picture) for part in parts)
    return sum(map(tokens_at_most, texts)) + pictures * _TOKENS_OF_PICTURE + _FRAME
