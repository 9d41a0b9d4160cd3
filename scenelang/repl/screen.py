"""Where a REPL writes: a terminal, or two plain streams."""

from __future__ import annotations

import shutil
import textwrap
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

from scenelang.grammar.diagnostics import Diagnostic, capped, render_text
from scenelang.repl.display import clean
from scenelang.repl.images import Protocol

_MOST_LOG_LINES = 200
_MOST_ROWS = 60


@dataclass(frozen=True, slots=True)
class Screen:
    """``write`` gets text without a newline at its end, ``complain`` what is wrong. ``images``: how pictures can be
    shown. ``ask`` puts a question that is answered with yes or no; None where nobody can be asked."""

    write: Callable[[str], None]
    complain: Callable[[str], None]
    color: bool = False
    images: Protocol | None = None
    ask: Callable[[str], bool] | None = None
    quiet: bool = False

    @property
    def width(self) -> int:
        return shutil.get_terminal_size((100, 24)).columns

    @property
    def height(self) -> int:
        return shutil.get_terminal_size((100, 24)).lines

    def report(self, diagnostics: Iterable[Diagnostic]) -> None:
        """Show diagnostics; warnings unless quiet."""
        for diagnostic in capped([d for d in diagnostics if d.is_error or not self.quiet]):
            self.complain(render_text(diagnostic, self.color))

    def log(self, lines: Sequence[str]) -> None:
        """Show what a program printed, within bounds."""
        shown = [part for line in lines[:_MOST_LOG_LINES] for part in line.split("\n")][:_MOST_LOG_LINES]
        for line in shown:
            self.write(clean(line))
        left = sum(line.count("\n") + 1 for line in lines) - len(shown)
        if left:
            self.write(f"... {left:,} more lines")

    def prose(self, lines: Iterable[str], most: int = _MOST_ROWS) -> None:
        """Show lines of text, long ones wrapped; what continues a line stands under its beginning."""
        wrapped: list[str] = []
        for line in lines:
            indent = " " * (len(line) - len(line.lstrip()) + (0 if line.startswith(" ") else 2))
            wrapped += textwrap.wrap(clean(line), self.width, subsequent_indent=indent, break_on_hyphens=False) or [""]
        self.rows(wrapped, most)

    def rows(self, lines: Iterable[str], most: int = _MOST_ROWS) -> None:
        """Show the lines that a command gives, cut to the width, at most so many."""
        width = self.width
        for number, line in enumerate(lines):
            if number == most:
                self.write("...")
                return
            text = clean(line)
            self.write(text if len(text) <= width else text[: width - 3] + "...")
