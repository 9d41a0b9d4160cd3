"""The command line in processes of their own that start at once: copies of one that has loaded everything.

What start-up does, and signals, are tested with processes that start from nothing."""

from __future__ import annotations

import atexit
import subprocess
from functools import cache
from pathlib import Path

from hostile.measuring import GIVEN_UP, Nursery


@cache
def _nursery() -> Nursery:
    made = Nursery(Path(__file__).parent)
    atexit.register(made.close)
    return made


def command(
    *words: str, folder: Path | None = None, text: str = "", timeout: float = GIVEN_UP
) -> subprocess.CompletedProcess[str]:
    """``scenelang`` with ``words``, to its end."""
    return _nursery().run(words, folder or Path.cwd(), text, timeout)
