"""One finding about the installation."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum


class State(Enum):
    OK = "ok"
    NOTE = "note"  # neither good nor bad
    MISSING = "missing"  # comes with an extra, or is better to have
    BROKEN = "broken"  # promised without extras


@dataclass(frozen=True, slots=True)
class Check:
    """``topic`` groups the findings, ``remedy`` is what mends it: a command line, or empty."""

    topic: str
    name: str
    state: State
    detail: str
    remedy: str = ""
