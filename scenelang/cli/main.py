"""Command-line entry point: parses arguments, runs one command, and reports every failure as a diagnostic.

Exit codes: 0 success, 1 a wrong program or file, 2 wrong usage, 130 interrupted (Ctrl-C), 141 nothing reads the output
any more, 143 ended (SIGTERM).
"""

from __future__ import annotations

import argparse
import gc
import os
import sys
from collections.abc import Sequence

from scenelang.cli.command_table import COMMANDS as COMMANDS
from scenelang.cli.command_table import RENAMED_COMMANDS, CommandRow, formatter, top_parser
from scenelang.cli.options import ReportedError, add_common, add_file, add_output, report
from scenelang.cli.wrong_usage import Adviser, missing_command, whole_command
from scenelang.console.reports import Parser
from scenelang.grammar.diagnostics import (
    Diagnostic,
    SceneError,
    UsageError,
    missing_part,
    printable,
    render_text,
    suggest,
)
from scenelang.interpreter.values.limits import Limits
from scenelang.sandbox.environment import keep_named_variables
from scenelang.sandbox.supervision import (
    CLOSED,
    INTERRUPTED,
    alarmed,
    is_bounded,
    is_supported,
    supervise,
    was_interrupted,
)


def main(argv: Sequence[str] | None = None, supervised: bool = False) -> int:
    """Run one command and return its exit code.

    Parameters
    ----------
    argv
        Arguments without the program name (default: those of the process). On wrong usage argparse exits with 2.
    supervised
        Run commands that evaluate programs in a child process under hard limits. The child also returns from here.
    """
    try:
        return _main(sys.argv[1:] if argv is None else list(argv), supervised=supervised)
    except OSError as error:  # in the output of --help or --version
        return _report_output(error)
    except ModuleNotFoundError as error:  # the options of a command whose domain is missing
        return _report_missing(error)


def _collect_garbage() -> None:
    """Collect garbage from now on, but not what has been imported, which stays."""
    gc.freeze()
    gc.set_threshold(50_000, 20, 50)
    gc.enable()


def _main(words: list[str], *, supervised: bool) -> int:
    """Parse the arguments, and run the command in this process or in a supervised one."""
    if not words:
        build_parser("").print_help()
        sys.stdout.flush()
        return 0
    if words[0] in RENAMED_COMMANDS:
        print(f"scenelang: error: use `scenelang {RENAMED_COMMANDS[words[0]]}`", file=sys.stderr)
        return 2
    missing = missing_command(words)
    if missing is not None:
        print(f"scenelang: error: {missing}", file=sys.stderr)
        return 2
    if words[0] not in COMMANDS and not words[0].startswith("-"):
        near = whole_command(words) or suggest(words[0], COMMANDS) or "see `scenelang --help` for a list of commands"
        print(f"scenelang: error: unknown command `{printable(words[0])[:60]}`; {near}", file=sys.stderr)
        return 2
    arguments = build_parser(words[0], words).parse_args(words)
    _collect_garbage()
    if not (supervised and COMMANDS[arguments.command].kind.evaluates and is_supported()):
        return _run(arguments)
    stream = sys.stdout if arguments.command == "check" and arguments.json else None

    def tell(problem: Diagnostic) -> None:
        """Report why the process was ended."""
        report(arguments, [problem], stream)

    if _is_bounded(arguments):
        with alarmed(Limits().seconds, tell):
            return _run(arguments)
    return supervise(lambda: _run_confined(arguments), tell)


def _is_bounded(arguments: argparse.Namespace) -> bool:
    """Return whether a command only checks programs, which takes bounded time and memory without a monitor."""
    options = ("evaluate", "geometry", "physics", "define", "z", "max_seconds", "max_memory")
    is_plain = arguments.command == "check" and not any(getattr(arguments, name) for name in options)
    return is_plain and is_bounded(arguments.files)


def _run_confined(arguments: argparse.Namespace) -> int:
    """Run a command in its own process, without the keys in the environment unless it needs them after evaluation."""
    if COMMANDS[arguments.command].module not in ("models", "embed_eval", "neural", "bench"):
        keep_named_variables()
    return _run(arguments)


def _run(arguments: argparse.Namespace) -> int:
    """Run a command, and report every exception as a diagnostic; return the exit code."""
    try:
        code = _worked(arguments)
        sys.stdout.flush()
        return INTERRUPTED if code and getattr(arguments, "was_interrupted", False) else code
    except SceneError as error:
        if was_interrupted(error):
            return _report_interruption()
        report(arguments, [error.diagnostic])
        return 2 if isinstance(error, UsageError) else 1
    except BrokenPipeError as error:
        return _report_output(error)
    except KeyboardInterrupt:
        return _report_interruption()
    except RecursionError:
        report(arguments, [SceneError("nesting", "the program is nested too deeply for this command").diagnostic])
        return 1
    except OSError as error:
        return _report_output(error)
    except ModuleNotFoundError as error:
        return _report_missing(error)
    except Exception as error:
        return _report_interruption() if was_interrupted(error) else _report_fault(error)


def _worked(arguments: argparse.Namespace) -> int:
    """Run a command; errors that it has reported already give exit code 1."""
    try:
        code: int = COMMANDS[arguments.command].part(arguments.command, "run")(arguments)
        return code
    except ReportedError:
        return 1


def _report_interruption() -> int:
    """Report Ctrl-C, and return the exit code."""
    print("interrupted", file=sys.stderr)
    return INTERRUPTED


def _report_missing(error: ModuleNotFoundError) -> int:
    """Report a part of the package that this installation lacks, as one that was made smaller does."""
    part = missing_part(error)
    if part is None:
        return _report_fault(error)
    print(part, file=sys.stderr)
    return 1


def _report_fault(error: Exception) -> int:
    """Report an internal error, with a hint how to get the traceback."""
    if os.environ.get("SCENELANG_TRACEBACK"):
        raise error
    message = f"{type(error).__name__}: {error}"
    print(f"internal error: {message} (set SCENELANG_TRACEBACK=1 for a traceback; please report it)", file=sys.stderr)
    return 1


def _report_output(error: OSError) -> int:
    """Report an output that cannot be written, and return the exit code."""
    if error.filename is None:
        _silence_stdout()
    if isinstance(error, BrokenPipeError):  # what reads the output has read enough, as `head` does
        return CLOSED
    reason = error.strerror or str(error)
    message = f"{reason}: {error.filename}" if error.filename else f"cannot write to standard output: {reason}"
    print(render_text(SceneError("file", message).diagnostic), file=sys.stderr)
    return 1


def _silence_stdout() -> None:
    """Redirect stdout to /dev/null, so that flushing at exit does not fail again."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


class _Version(argparse.Action):
    """Print the version and exit; the metadata lookup is slow, so it runs only on request."""

    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> None:
        from importlib.metadata import version

        parser._print_message(f"scenelang {version('scenelang')}\n", sys.stdout)
        parser.exit()


def build_parser(only: str | None = None, words: Sequence[str] = ()) -> argparse.ArgumentParser:
    """Create the argument parser; with ``only``, it has that command alone, or no arguments of commands.

    ``words`` are the arguments that it will parse, for advice on wrong ones.
    """
    parser = top_parser(Parser, _Version)
    quiet = argparse.SUPPRESS
    subparsers = parser.add_subparsers(prog="scenelang", dest="command", required=True, metavar="COMMAND", help=quiet)
    help_formatter = formatter(argparse.HelpFormatter)
    for name in [only] if only in COMMANDS else COMMANDS:
        subparser = subparsers.add_parser(name, help=COMMANDS[name].help, formatter_class=help_formatter)
        if only in (None, name):
            _add_arguments(subparser, name, COMMANDS[name])
        if words:
            subparser.advise = Adviser(name, subparser, words, build_parser)
    return parser


def _add_arguments(parser: argparse.ArgumentParser, name: str, command: CommandRow) -> None:
    """Add the arguments of one command, and those of its kind."""
    if command.kind.takes_file:
        add_file(parser)
    add = command.part(name, "add")
    if add is not None:
        add(parser)
    if command.kind.options:
        {"common": add_common, "output": add_output}[command.kind.options](parser)
