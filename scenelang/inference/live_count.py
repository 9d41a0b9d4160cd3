"""A line that tells, while answers arrive, how much there is of them; on a terminal only."""

from __future__ import annotations

import time
from collections.abc import Callable
from threading import Lock
from typing import TextIO

_BETWEEN = 0.1  # seconds between changes of the line
_LETTERS_PER_TOKEN = 3.5


class LiveCount:
    """Counts the tokens, estimated, and the lines of the answers that arrive side by side. Without ``stream`` it
    writes nothing."""

    def __init__(self, stream: TextIO | None) -> None:
        self._stream = stream
        self._lock = Lock()
        self._counts: dict[int, tuple[str, int, int]] = {}
        self._shown = 0.0
        self._width = 0

    def counting(self, sample: int, number: int, purpose: str) -> Callable[[str], None]:
        """Begin an answer; what it gives is told of every piece that arrives."""
        label = f"sample {sample} {purpose}" if sample else purpose
        letters, lines = 0, 0

        def count(text: str) -> None:
            nonlocal letters, lines
            letters, lines = letters + len(text), lines + text.count("\n")
            with self._lock:
                self._counts[sample] = (label, round(letters / _LETTERS_PER_TOKEN), lines)
                if time.monotonic() - self._shown >= _BETWEEN:
                    self._show(self._line())

        with self._lock:
            self._counts[sample] = (label, 0, 0)
            self._show(self._line())
        return count

    def waiting(self, count: int) -> None:
        """Say that a batch is under way."""
        with self._lock:
            self._show(f"waiting for a batch: {count} not done yet")

    def end(self) -> None:
        """Take the line away."""
        with self._lock:
            self._counts.clear()
            if self._width:
                self._show("")
                self._width = 0

    def _line(self) -> str:
        told = [
            f"{label}: ~{tokens:,} tokens, {lines:,} lines" if tokens else f"{label}: waiting for the service"
            for label, tokens, lines in self._counts.values()
        ]
        return "; ".join(told)

    def _show(self, line: str) -> None:
        if self._stream is None:
            return
        self._shown = time.monotonic()
        self._stream.write(f"\r{line.ljust(self._width)}" + ("\r" if not line else ""))
        self._stream.flush()
        self._width = len(line)
