"""The command line: parses it, runs one command, turns every failure into one clear message.

Exit codes: 0 success, 1 a wrong program or file, 2 wrong usage, 130 interrupted.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence

from scenelang.cli.commands import COMMANDS, build_parser
from scenelang.cli.options import Told
from scenelang.cli.output import report
from scenelang.grammar.diagnostics import SceneError, UsageError, printable, suggest
from scenelang.sandbox.supervision import INTERRUPTED, is_supported, supervise


def main(argv: Sequence[str] | None = None, supervised: bool = False) -> int:
    """Run one command and return its exit code; argparse exits with 2 for wrong usage. ``supervised``: commands that
    evaluate programs do so in a child process under hard limits; the child returns from here as well."""
    words = sys.argv[1:] if argv is None else list(argv)
    if not words:
        build_parser("").print_help()
        return 0
    if words[0] not in COMMANDS and not words[0].startswith("-"):
        near = suggest(words[0], COMMANDS) or "`scenelang --help` lists all"
        print(f"scenelang: error: there is no command `{printable(words[0])[:60]}`; {near}", file=sys.stderr)
        return 2
    arguments = build_parser(words[0] if words else "").parse_args(words)
    if supervised and COMMANDS[arguments.command].kind.evaluates and is_supported():
        stream = sys.stdout if arguments.command == "check" and arguments.json else None
        return supervise(lambda: _run(arguments), lambda problem: report(arguments, [problem], stream))
    return _run(arguments)


def _run(arguments: argparse.Namespace) -> int:
    try:
        code = _worked(arguments)
        sys.stdout.flush()
        return INTERRUPTED if code and getattr(arguments, "was_interrupted", False) else code
    except SceneError as error:
        if _was_interrupted(error):
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
        return _report_interruption() if _was_interrupted(error) else _report_fault(error)


def _worked(arguments: argparse.Namespace) -> int:
    try:
        code: int = COMMANDS[arguments.command].part(arguments.command, "run")(arguments)
        return code
    except Told:
        return 1


def _report_interruption() -> int:
    print("interrupted", file=sys.stderr)
    return INTERRUPTED


def _was_interrupted(error: BaseException) -> bool:
    """Whether Ctrl-C is behind an error: native libraries turn it into errors of their own."""
    found: BaseException | None = error
    while found is not None:
        if isinstance(found, KeyboardInterrupt) or "KeyboardInterrupt" in str(found):
            return True
        found = found.__cause__ or found.__context__
    return False


def _report_fault(error: Exception) -> int:
    """A fault of ours, not of the program: one line, and where the whole story is to be had."""
    if os.environ.get("SCENELANG_TRACEBACK"):
        raise error
    said = f"{type(error).__name__}: {error}"
    print(f"internal error: {said} (SCENELANG_TRACEBACK=1 shows where; please report it)", file=sys.stderr)
    return 1


def _silence_stdout() -> None:
    """Whoever read our output is gone: what is still buffered goes nowhere instead of failing at exit."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
