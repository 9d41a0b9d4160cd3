"""Command-line entry point: parses arguments, runs one command, and reports every failure as a diagnostic.

Exit codes: 0 success, 1 a wrong program or file, 2 wrong usage, 130 interrupted (Ctrl-C), 141 nothing reads the output
any more, 143 ended (SIGTERM).
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Callable, Sequence
from importlib import import_module
from typing import Any, NamedTuple

from scenelang.cli.options import ReportedError, add_common, add_file, add_output, report
from scenelang.console.reports import Parser
from scenelang.grammar.diagnostics import SceneError, UsageError, printable, render_text, suggest
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
        return _main(sys.argv[1:] if argv is None else list(argv), supervised)
    except OSError as error:  # in the output of --help or --version
        return _report_output(error)


def _main(words: list[str], supervised: bool) -> int:
    if not words:
        build_parser("").print_help()
        sys.stdout.flush()
        return 0
    if words[0] not in COMMANDS and not words[0].startswith("-"):
        near = suggest(words[0], COMMANDS) or "see `scenelang --help` for a list of commands"
        print(f"scenelang: error: unknown command `{printable(words[0])[:60]}`; {near}", file=sys.stderr)
        return 2
    arguments = build_parser(words[0] if words else "").parse_args(words)
    if not (supervised and COMMANDS[arguments.command].kind.evaluates and is_supported()):
        return _run(arguments)
    stream = sys.stdout if arguments.command == "check" and arguments.json else None
    tell = lambda problem: report(arguments, [problem], stream)
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
    if COMMANDS[arguments.command].module not in ("models", "neural", "bench"):
        keep_named_variables()
    return _run(arguments)


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
    except BrokenPipeError as error:
        return _report_output(error)
    except KeyboardInterrupt:
        return _report_interruption()
    except RecursionError:
        report(arguments, [SceneError("nesting", "the program is nested too deeply for this command").diagnostic])
        return 1
    except OSError as error:
        return _report_output(error)
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


# Table of commands, and the argument parser.


class CommandKind(NamedTuple):
    """Properties of commands: a leading FILE, ``groups`` of options, and whether programs run, under hard limits."""

    takes_file: bool = False
    groups: Callable[[argparse.ArgumentParser], None] | None = None
    evaluates: bool = True


PROGRAM = CommandKind(True, add_common)
EVALUATION = CommandKind(False, add_common)
OUTPUT = CommandKind(False, add_output)
TEXT = CommandKind(False, add_output, False)  # does not evaluate programs
FILE = CommandKind(True)
OWN = CommandKind()  # declares all of its arguments
SERVER = CommandKind(evaluates=False)


class Command(NamedTuple):
    """A command, run by ``run_NAME`` of ``module``; ``add_NAME``, if defined, declares its arguments."""

    kind: CommandKind
    module: str
    help: str

    def part(self, name: str, prefix: str) -> Any:
        """Return a function of the command's module, or None if it is not defined."""
        return getattr(import_module(f"scenelang.cli.{self.module}"), f"{prefix}_{name}", None)


# In the order of the help listing and the reference.
GROUPS: dict[str, dict[str, Command]] = {
    "Write programs": {
        "check": Command(EVALUATION, "programs", "check programs for errors without running them"),
        "run": Command(PROGRAM, "programs", "evaluate a program and summarize its scene"),
        "repl": Command(EVALUATION, "programs", "start an interactive session (REPL)"),
        "fmt": Command(TEXT, "programs", "format programs: line breaks and indentation"),
        "explain": Command(TEXT, "programs", "explain an error or warning and how to fix it"),
        "diff": Command(EVALUATION, "programs", "compare the geometry of two scenes"),
        "expand": Command(PROGRAM, "programs", "print the program after macro expansion"),
        "transpile": Command(OWN, "programs", "convert Python written by a language model to a program"),
        "lift": Command(PROGRAM, "programs", "rewrite a program as a person would write it"),
        "import": Command(OUTPUT, "programs", "convert OpenSCAD or a Minecraft build: .scad .schem .litematic .nbt"),
    },
    "Inspect scenes": {
        "render": Command(PROGRAM, "pictures", "render an image or a video of the scene"),
        "view": Command(EVALUATION, "pictures", "show programs in a browser with live reload"),
        "maps": Command(EVALUATION, "pictures", "render labeled images: segmentation, depth, boxes, motion"),
        "dataset": Command(TEXT, "pictures", "make labeled datasets of any size from a spec of what varies"),
        "graph": Command(PROGRAM, "pictures", "draw the dependency graph of words (paper, Figure 2)"),
        "tree": Command(PROGRAM, "programs", "print the entity hierarchy"),
        "count": Command(PROGRAM, "programs", "count the instances of every word"),
        "bounds": Command(PROGRAM, "programs", "print the exact bounding box of the scene or of a word"),
        "measure": Command(PROGRAM, "programs", "print volume, surface, centre of mass and inertia"),
        "simulate": Command(PROGRAM, "physics", "show how the scene moves under gravity, as a film or a 4D scene"),
        "settle": Command(PROGRAM, "physics", "let the scene come to rest, and write it with the new poses"),
        "repair": Command(PROGRAM, "physics", "edit the program so that findings and failed declarations are resolved"),
        "flatten": Command(PROGRAM, "programs", "list the primitives with their world matrices"),
    },
    "Export": {
        "export": Command(PROGRAM, "pictures", "export the scene to another file format"),
        "backends": Command(OUTPUT, "pictures", "list the backends and their output formats"),
    },
    "Generate with language models": {
        "generate": Command(OWN, "models", "generate a scene from text and images with a language model"),
        "edit": Command(OWN, "models", "edit a scene by an instruction with a language model"),
        "bench": Command(TEXT, "bench", "measure a language model on tasks that are judged by geometry"),
        "runs": Command(TEXT, "models", "list the runs of generate and edit, or the attempts of one"),
    },
    "Embeddings and neural models": {
        "embeddings": Command(FILE, "neural", "list, change, encode and compare the embeddings of a scene"),
        "embed": Command(PROGRAM, "models", "describe every primitive in words, for neural backends"),
        "imagine": Command(PROGRAM, "neural", "generate an image of the scene with a text-to-image model"),
        "invert": Command(PROGRAM, "neural", "learn embeddings of entities from a photo (textual inversion)"),
        "style": Command(PROGRAM, "neural", "learn a style embedding from an image"),
        "distill": Command(PROGRAM, "neural", "optimize 3D Gaussians with score distillation (SDS)"),
        "eval": Command(EVALUATION, "models", "compute the paper's metrics, and run its user study"),
    },
    "Integrations and diagnostics": {
        "lsp": Command(SERVER, "programs", "start the language server on standard input and output"),
        "mcp": Command(SERVER, "programs", "start the MCP server on standard input and output"),
        "search": Command(TEXT, "programs", "search the language and its examples by meaning"),
        "grammar": Command(TEXT, "programs", "export the grammar of the language"),
        "completion": Command(SERVER, "programs", "print a shell completion script"),
        "doctor": Command(TEXT, "programs", "check the installation and report what is missing"),
    },
}
COMMANDS = {name: command for group in GROUPS.values() for name, command in group.items()}


class _Version(argparse.Action):
    """Print the version and exit; the metadata lookup is slow, so it runs only on request."""

    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> None:
        from importlib.metadata import version

        parser._print_message(f"scenelang {version('scenelang')}\n", sys.stdout)
        parser.exit()


def build_parser(only: str | None = None) -> argparse.ArgumentParser:
    """Create the argument parser; with ``only``, it has that command alone, or no arguments of commands."""
    parser = Parser(
        prog="scenelang",
        usage="scenelang [-h] [--version] COMMAND ...",
        description="The Scene Language: scenes as programs, words and embeddings.",
        epilog=_listing(),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--version", action=_Version, nargs=0, help="show the version and exit")
    quiet = argparse.SUPPRESS
    subparsers = parser.add_subparsers(prog="scenelang", dest="command", required=True, metavar="COMMAND", help=quiet)
    for name in [only] if only in COMMANDS else COMMANDS:
        mine = subparsers.add_parser(name, help=COMMANDS[name].help)
        if only in (None, name):
            _add_arguments(mine, name, COMMANDS[name])
    return parser


def _listing() -> str:
    """Return the help listing of all commands by group."""
    groups = [
        "\n".join([f"{title}:", *(f"  {name:<11} {command.help}" for name, command in group.items())])
        for title, group in GROUPS.items()
    ]
    return "\n\n".join([*groups, "See `scenelang COMMAND --help` for the options of a command."])


def _add_arguments(parser: argparse.ArgumentParser, name: str, command: Command) -> None:
    if command.kind.takes_file:
        add_file(parser)
    own = command.part(name, "add")
    if own is not None:
        own(parser)
    if command.kind.groups is not None:
        command.kind.groups(parser)
