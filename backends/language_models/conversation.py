"""What is said to a language model and what it answers, whichever family it is of."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum
from typing import Any


@dataclass(frozen=True, slots=True)
class Text:
    """A piece of text. ``is_fixed``: what was said up to its end is the same in many requests, so services may keep
    it."""

    text: str
    is_fixed: bool = False


@dataclass(frozen=True, slots=True)
class Picture:
    """An encoded picture; ``media_type`` such as ``image/png``."""

    media_type: str
    data: bytes = field(repr=False)


@dataclass(frozen=True, slots=True)
class Blocks:
    """What a provider answered, in its own form, to be sent back to it as it came (a turn that was paused)."""

    blocks: tuple[Mapping[str, Any], ...]


Part = Text | Picture | Blocks


@dataclass(frozen=True, slots=True)
class Turn:
    """What one side said. ``role`` is "user" or "assistant"."""

    role: str
    parts: tuple[Part, ...]


def said(role: str, text: str) -> Turn:
    """A turn of text alone."""
    return Turn(role, (Text(text),))


@dataclass(frozen=True, slots=True)
class Request:
    """One question. ``system`` is said before all turns. ``thinking`` is how the model is to think, None to leave that
    to it, and ``effort`` how much it is to work: both as the model's row of the catalogue allows. ``grammar`` is a GBNF
    grammar that the answer must follow, for services that can."""

    model: str
    system: Text
    turns: tuple[Turn, ...]
    max_tokens: int
    thinking: str | None = None
    effort: str | None = None
    grammar: str | None = None


class Stop(Enum):
    """Why an answer ended. CUT: at ``max_tokens``. FULL: the model's context has no more room. PAUSED: to be sent back
    as it came, so that the model goes on. BROKEN: the connection ended first."""

    END = "end"
    CUT = "cut"
    FULL = "full"
    REFUSED = "refused"
    PAUSED = "paused"
    BROKEN = "broken"


@dataclass(frozen=True, slots=True)
class Usage:
    """Tokens: sent and read anew, sent and read from the service's cache, written to it, and answered."""

    sent: int = 0
    cache_read: int = 0
    cache_written: int = 0
    answered: int = 0

    def __add__(self, other: Usage) -> Usage:
        return Usage(
            self.sent + other.sent,
            self.cache_read + other.cache_read,
            self.cache_written + other.cache_written,
            self.answered + other.answered,
        )

    @property
    def prompt(self) -> int:
        """All that was sent."""
        return self.sent + self.cache_read + self.cache_written


@dataclass(frozen=True, slots=True)
class Reply:
    """An answer. ``note`` says more about why it ended, such as a refusal's explanation; ``blocks`` are the provider's
    own form of it where it was paused."""

    text: str
    stop: Stop
    usage: Usage
    model: str
    note: str = ""
    blocks: tuple[Mapping[str, Any], ...] = ()
