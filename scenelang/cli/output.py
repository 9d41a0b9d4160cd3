"""Output of commands: diagnostics as text or JSON, the program's log, progress on a terminal."""

from __future__ import annotations

import argparse
import json
import os
import sys
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any, TextIO

from scenelang.backends.files import check_folder as check_folder
from scenelang.grammar.diagnostics import Diagnostic, capped, printable, render_text, to_json
from scenelang.reports import print_json, progress_line, say

if TYPE_CHECKING:
    from scenelang.session import Evaluated


def use_color(arguments: argparse.Namespace, stream: TextIO) -> bool:
    return stream.isatty() and not getattr(arguments, "no_color", False) and "NO_COLOR" not in os.environ


def report(arguments: argparse.Namespace, diagnostics: Iterable[Diagnostic], stream: TextIO | None = None) -> None:
    """Print diagnostics: errors always, warnings unless quiet; as one JSON list with ``--json``."""
    quiet = getattr(arguments, "quiet", False)
    shown = capped([d for d in diagnostics if d.is_error or not quiet])
    if any(d.name == "interrupted" for d in shown):
        arguments.was_interrupted = True
    stream = stream or sys.stderr
    if getattr(arguments, "json", False):
        print(json.dumps([to_json(d) for d in shown]), file=stream)
        return
    for diagnostic in shown:
        print(render_text(diagnostic, use_color(arguments, stream)), file=stream)
    without_hint = sorted({diagnostic.code for diagnostic in shown if not diagnostic.hint})
    if without_hint and stream.isatty() and not quiet:  # only for interactive use
        print(f"  more: scenelang explain {' '.join(without_hint)}", file=stream)


def report_run(arguments: argparse.Namespace, result: Evaluated) -> None:
    """Print the log and the diagnostics of a run to standard error; standard output is for data."""
    if not arguments.quiet:
        for line in result.log:
            print(printable(line) if sys.stderr.isatty() else line, file=sys.stderr)
    if result.diagnostics:
        report(arguments, result.diagnostics)
    if arguments.verbose:
        print(f"{result.steps:,} steps", file=sys.stderr)


def print_result(arguments: argparse.Namespace, data: Any, text: object) -> int:
    """Print a command's result as JSON or text, and return exit code 0."""
    if arguments.json:
        print_json(data)
    else:
        say(str(text))
    return 0


def warnings(arguments: argparse.Namespace) -> Callable[[Diagnostic], None]:
    """Return a callback that reports warnings of backends, each message only once."""
    reported: set[str] = set()

    def warn(diagnostic: Diagnostic) -> None:
        if diagnostic.message not in reported:
            reported.add(diagnostic.message)
            report(arguments, [diagnostic])

    return warn


def progress(arguments: argparse.Namespace, label: str) -> Callable[[float], None] | None:
    """Return a callback for a progress line on standard error, or None without a terminal or when quiet."""
    if arguments.quiet or not sys.stderr.isatty():
        return None
    return progress_line(sys.stderr, label)


def done(arguments: argparse.Namespace, *written: Path) -> None:
    """Report the files that were written."""
    if not arguments.quiet:
        for output in written:
            say(f"wrote {output}")
