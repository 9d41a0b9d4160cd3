"""Console output: tables, colors, JSON and progress, with control characters removed."""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any, NoReturn, TextIO

from scenelang.backends.files import write_text
from scenelang.grammar.diagnostics import Diagnostic, folded, printable, render_text, to_json

_PROGRESS_DELAY = 1.0  # seconds; shorter work shows no progress
_BAR_WIDTH = 30  # characters
_COLORS = {"+": "32", "-": "31", "@": "36"}


def table(rows: Sequence[Sequence[str]], right: Sequence[bool]) -> str:
    """Format rows as aligned columns, right-aligned where ``right`` is True; each cell is one line."""
    rows = [[printable(cell).replace("\n", "\\n") for cell in row] for row in rows]
    widths = [max((len(row[i]) for row in rows), default=0) for i in range(len(right))]
    lines = []
    for row in rows:
        cells = [c.rjust(w) if r else c.ljust(w) for c, w, r in zip(row, widths, right)]
        lines.append("  ".join(cells).rstrip())
    return "\n".join(lines)


def colored(text: str, color: str | None) -> str:
    """Wrap a text in an ANSI color, given by its number, or return it unchanged."""
    return f"\x1b[{color}m{text}\x1b[0m" if color else text


def painted(difference: Iterable[str], color: bool) -> Iterator[str]:
    """Yield the lines of a unified diff with line ends, colored if ``color`` is True."""
    for line in difference:
        yield colored(line, _COLORS.get(line[:1]) if color else None) + "\n"


def progress_line(stream: TextIO, label: str) -> Callable[[float], None]:
    """Return a callback that draws a progress bar for a fraction of work.

    Parameters
    ----------
    stream
        Terminal to draw on.
    label
        Text before the bar.

    Returns
    -------
    callable
        To be called with the share of the work that is done, from 0 to 1. It draws nothing in the first second, so that
        short work shows no bar; 1 ends the line.
    """
    started = time.monotonic()

    def show(fraction: float) -> None:
        """Draw the progress bar at ``fraction``, clamped to 0 and 1, unless the work began less than a second ago."""
        elapsed = time.monotonic() - started
        if elapsed < _PROGRESS_DELAY:
            return
        filled = round(_BAR_WIDTH * min(1.0, max(0.0, fraction)))
        bar = "#" * filled + "-" * (_BAR_WIDTH - filled)
        end = "\n" if fraction >= 1.0 else ""
        stream.write(f"\r{label} [{bar}] {100 * fraction:3.0f}% {elapsed:5.1f}s{end}")
        stream.flush()

    return show


def say(text: str, end: str = "\n", flush: bool = False) -> None:
    """Print text that may originate from a program, with control characters removed."""
    print(printable(text), end=end, flush=flush)


def print_json(data: Any) -> None:
    """Print one JSON document to standard output, written incrementally."""
    import json

    for piece in json.JSONEncoder().iterencode(data):
        sys.stdout.write(piece)
    sys.stdout.write("\n")


def deliver(text: str, output: str | None) -> None:
    """Write a text to the file ``output`` atomically, or to standard output if it is None."""
    if output is None:
        sys.stdout.write(text)
    else:
        write_text(output, text)


def print_diagnostics(
    diagnostics: Sequence[Diagnostic], stream: TextIO, as_json: bool, color: bool, explains: bool
) -> None:
    """Print diagnostics.

    Parameters
    ----------
    diagnostics
        Diagnostics in the order in which they are printed.
    stream
        Where they are printed.
    as_json
        Whether to print them as one JSON list, instead of text.
    color
        Whether the text is colored.
    explains
        Whether to add the command that explains those without a hint.
    """
    if as_json:
        import json

        print(json.dumps([to_json(d) for d in diagnostics]), file=stream)
        return
    diagnostics = folded(diagnostics)
    for diagnostic in diagnostics:
        print(render_text(diagnostic, color), file=stream)
    without_hint = sorted({diagnostic.code for diagnostic in diagnostics if not diagnostic.hint})
    if without_hint and explains:
        print(f"  more: scenelang explain {' '.join(without_hint)}", file=stream)


def once(report: Callable[[Diagnostic], None]) -> Callable[[Diagnostic], None]:
    """Return a callback that reports diagnostics, each message only once."""
    reported: set[str] = set()

    def warn(diagnostic: Diagnostic) -> None:
        """Report a diagnostic whose message is new."""
        if diagnostic.message not in reported:
            reported.add(diagnostic.message)
            report(diagnostic)

    return warn


# Options that say what to draw or measure: a second one is an error, since both would be expected. Others are
# settings, whose last value counts, so that an alias or a script can have its own.
_ONCE = frozenset(("camera", "frame", "word", "part"))


class _Store(argparse.Action):
    """Action of an option with one value."""

    def __call__(self, parser: Any, namespace: Any, values: Any, option_string: str | None = None) -> None:
        given: set[str] = namespace.__dict__.setdefault(_GIVEN, set())
        is_second = option_string is not None and self.dest in given and self.dest in _ONCE
        if is_second and getattr(namespace, self.dest) != values:
            raise argparse.ArgumentError(self, "it is given twice")
        given.add(self.dest)
        setattr(namespace, self.dest, values)


_GIVEN = "_given"  # attribute of a namespace while arguments are parsed


class Parser(argparse.ArgumentParser):
    """Argument parser whose errors are one line, with what was probably meant.

    ``advise`` returns the line about arguments that the parser does not know, or about a name that is missing.
    """

    def __init__(self, *args: Any, **options: Any) -> None:
        super().__init__(*args, **options)
        self.advise: Callable[[Sequence[str], str], str | None] | None = None
        for name in (None, "store"):
            self.register("action", name, _Store)

    def _print_message(self, message: str, file: Any = None) -> None:
        """Print a message, and raise OSError where it cannot be written, which argparse would ignore."""
        if message:
            stream = file or sys.stderr
            stream.write(message)
            stream.flush()

    def error(self, message: str) -> NoReturn:
        """Exit with a message and the way to the usage."""
        if self.advise is not None:
            message = self.advise((), message) or message
        self.exit(2, f"{self.prog}: error: {message}\nusage: see `{self.prog} --help`\n")

    def parse_args(self, args: Any = None, namespace: Any = None) -> Any:
        """Parse all arguments; unknown ones are an error with the nearest option."""
        arguments, unknown = self.parse_known_args(args, namespace)
        arguments.__dict__.pop(_GIVEN, None)
        if unknown:
            self._parser_of(arguments)._report_unknown(unknown)
        return arguments

    def _parser_of(self, arguments: Any) -> Parser:
        """Return the parser of the command that ``arguments`` name, else this one."""
        commands = next((action for action in self._actions if isinstance(action, argparse._SubParsersAction)), None)
        return self if commands is None else commands.choices[getattr(arguments, commands.dest)]

    def _report_unknown(self, arguments: Sequence[str]) -> NoReturn:
        """Exit with what was probably meant by arguments that the parser does not know."""
        message = f"unrecognized arguments: {' '.join(arguments)}"
        self.error((self.advise(arguments, message) if self.advise is not None else None) or message)
