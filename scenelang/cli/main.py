"""The entry point: parses the command line, runs one command, turns every failure into one clear message.

Exit codes: 0 success, 1 a wrong program or file, 2 wrong usage, 130 interrupted.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence

from scenelang.cli import (
    blocks,
    compare,
    completion,
    distill,
    doctor,
    edit,
    embed,
    embeddings,
    evaluate,
    explain,
    fmt,
    generate,
    grammar,
    graph,
    imagine,
    invert,
    lsp,
    maps,
    mcp,
    pictures,
    programs,
    repl,
    runs,
    transpile,
    view,
)
from scenelang.cli.options import UsageError
from scenelang.cli.output import report
from scenelang.grammar.diagnostics import SceneError
from scenelang.sandbox.supervision import INTERRUPTED, is_supported, supervise

# In the order in which help and the reference list their commands.
_MODULES = (
    programs,
    repl,
    explain,
    fmt,
    compare,
    transpile,
    generate,
    edit,
    runs,
    pictures,
    imagine,
    maps,
    blocks,
    graph,
    view,
    embeddings,
    embed,
    invert,
    distill,
    evaluate,
    grammar,
    lsp,
    mcp,
    doctor,
    completion,
)


class _Version(argparse.Action):
    """Prints the version; looked up only when asked for, since that takes a while."""

    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> None:
        from importlib.metadata import version

        print(f"scenelang {version('scenelang')}")
        parser.exit()


def build_parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="scenelang", description="The Scene Language: scenes as programs, words and embeddings."
    )
    parser.add_argument("--version", action=_Version, nargs=0, help="show the version and exit")
    subparsers = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    for module in _MODULES:
        for add in module.COMMANDS:
            add(subparsers)
    return parser


def main(argv: Sequence[str] | None = None, supervised: bool = False) -> int:
    """Run one command and return its exit code; argparse exits with 2 for wrong usage. ``supervised``: commands that
    evaluate programs do so in a child process under hard limits; the child returns from here as well."""
    arguments = build_parser().parse_args(argv)
    if supervised and getattr(arguments, "evaluates", True) and is_supported():
        stream = sys.stdout if arguments.command == "check" and arguments.json else None
        return supervise(lambda: _run(arguments), lambda problem: report(arguments, [problem], stream))
    return _run(arguments)


def _run(arguments: argparse.Namespace) -> int:
    try:
        code: int = arguments.run(arguments)
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
