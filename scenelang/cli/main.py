"""Command-line entry point: parses arguments, runs one command, and reports every failure as a diagnostic.

Exit codes: 0 success, 1 a wrong program or file, 2 wrong usage, 130 interrupted.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence

from scenelang.cli.commands import COMMANDS, build_parser
from scenelang.cli.options import ReportedError, report
from scenelang.grammar.diagnostics import SceneError, UsageError, printable, suggest
from scenelang.sandbox.supervision import INTERRUPTED, is_bounded, is_supported, supervise, was_interrupted


def main(argv: Sequence[str] | None = None, supervised: bool = False) -> int:
    """Run one command and return its exit code.

    Parameters
    ----------
    argv
        Arguments without the program name (default: those of the process). On wrong usage argparse exits with 2.
    supervised
        Run commands that evaluate programs in a child process under hard limits. The child also returns from here.
    """
    words = sys.argv[1:] if argv is None else list(argv)
    if not words:
        build_parser("").print_help()
        return 0
    if words[0] not in COMMANDS and not words[0].startswith("-"):
        near = suggest(words[0], COMMANDS) or "see `scenelang --help` for a list of commands"
        print(f"scenelang: error: unknown command `{printable(words[0])[:60]}`; {near}", file=sys.stderr)
        return 2
    arguments = build_parser(words[0] if words else "").parse_args(words)
    evaluates = COMMANDS[arguments.command].kind.evaluates and not _is_bounded(arguments)
    if supervised and evaluates and is_supported():
        stream = sys.stdout if arguments.command == "check" and arguments.json else None
        return supervise(lambda: _run(arguments), lambda problem: report(arguments, [problem], stream))
    return _run(arguments)


def _is_bounded(arguments: argparse.Namespace) -> bool:
    """Return whether a command only checks programs, which takes bounded time and memory without a monitor."""
    options = ("evaluate", "geometry", "define", "z", "max_seconds", "max_memory")
    is_plain = arguments.command == "check" and not any(getattr(arguments, name) for name in options)
    return is_plain and is_bounded(arguments.files)


def _run(arguments: argparse.Namespace) -> int:
    try:
        code = _worked(arguments)
        sys.stdout.flush()
        return INTERRUPTED if code and getattr(arguments, "was_interrupted", False) else code
    except SceneError as error:
        if was_interrupted(error):
            return _report_interruption()
        report(arguments, [error.diagnostic])
        return 2 if isinstance(error, UsageError) else 1
    except BrokenPipeError:
        _silence_stdout()
        return 1
    except KeyboardInterrupt:
        return _report_interruption()
    except RecursionError:
        report(arguments, [SceneError("nesting", "the program is nested too deeply for this command").diagnostic])
        return 1
    except OSError as error:
        report(arguments, [SceneError("file", f"{error.strerror or error}: {error.filename or 'output'}").diagnostic])
        return 1
    except Exception as error:
        return _report_interruption() if was_interrupted(error) else _report_fault(error)


def _worked(arguments: argparse.Namespace) -> int:
    try:
        code: int = COMMANDS[arguments.command].part(arguments.command, "run")(arguments)
        return code
    except ReportedError:
        return 1


def _report_interruption() -> int:
    print("interrupted", file=sys.stderr)
    return INTERRUPTED


def _report_fault(error: Exception) -> int:
    """Report an internal error, with a hint how to get the traceback."""
    if os.environ.get("SCENELANG_TRACEBACK"):
        raise error
    message = f"{type(error).__name__}: {error}"
    print(f"internal error: {message} (set SCENELANG_TRACEBACK=1 for a traceback; please report it)", file=sys.stderr)
    return 1


def _silence_stdout() -> None:
    """Redirect stdout to /dev/null after a broken pipe, so that flushing at exit does not fail."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
