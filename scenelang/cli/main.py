"""The command line: parses it, runs one command, turns every failure into one clear message.

Exit codes: 0 success, 1 a wrong program or file, 2 wrong usage, 130 interrupted.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence
from importlib import import_module
from typing import NamedTuple

from scenelang.cli.output import report
from scenelang.grammar.diagnostics import SceneError, UsageError
from scenelang.sandbox.supervision import INTERRUPTED, is_supported, supervise


class Command(NamedTuple):
    """A command: ``add_NAME`` of ``module`` declares its arguments, ``help`` is one line."""

    module: str
    help: str


# In the order in which help and the reference list them.
COMMANDS = {
    "check": Command("programs", "find mistakes without running the program"),
    "run": Command("programs", "evaluate a program and say what the scene is"),
    "tree": Command("programs", "print the entity hierarchy"),
    "flatten": Command("programs", "the primitives with their world matrices"),
    "count": Command("programs", "count the instances of every word"),
    "bounds": Command("programs", "the exact bounding box of the scene, or of a word's entities"),
    "expand": Command("programs", "print the program after macro expansion"),
    "repl": Command("servers", "the language interactively"),
    "explain": Command("programs", "why an error or warning arises, and how to mend it"),
    "fmt": Command("programs", "format programs: line breaks and indentation"),
    "diff": Command("programs", "what differs between the geometry of two scenes"),
    "transpile": Command("programs", "turn a language model's Python into a program"),
    "generate": Command("models", "make a scene of words and pictures, by a language model"),
    "edit": Command("models", "change a scene by an instruction, by a language model"),
    "runs": Command("models", "list the runs of generate and edit, or the attempts of one"),
    "render": Command("pictures", "draw a picture or a film of the scene"),
    "export": Command("pictures", "write the scene as a file for other programs"),
    "backends": Command("pictures", "list what scenes can be turned into"),
    "imagine": Command("neural", "a picture of the scene by a text-to-image model"),
    "maps": Command("pictures", "write labelled pictures: words, depth, boxes, motion"),
    "import": Command("programs", "make a program of a Minecraft build: .schem .litematic .nbt"),
    "graph": Command("pictures", "draw what is made of what, as the paper's Figure 2 does"),
    "view": Command("pictures", "show programs in a browser, live"),
    "embeddings": Command("embeddings", "the embeddings of a scene: list, change, encode, compare"),
    "embed": Command("embeddings", "describe every primitive in words, for neural backends"),
    "invert": Command("neural", "learn the embeddings of entities from a picture of them"),
    "style": Command("neural", "learn a style from a picture, for a scene or a part of it"),
    "distill": Command("neural", "learn how primitives look as Gaussians, from diffusion models"),
    "eval": Command("evaluation", "metrics of scenes in the paper's tables, and its user study"),
    "grammar": Command("programs", "write the language's grammar for another program"),
    "lsp": Command("servers", "serve an editor over standard input and output (docs/editors.md)"),
    "mcp": Command("servers", "serve an agent over standard input and output (docs/mcp.md)"),
    "doctor": Command("programs", "what is installed, which backends work and what is missing"),
    "completion": Command("servers", "print a script that completes commands in a shell"),
}


class _Version(argparse.Action):
    """Prints the version; looked up only when asked for, since that takes a while."""

    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> None:
        from importlib.metadata import version

        print(f"scenelang {version('scenelang')}")
        parser.exit()


def build_parser(only: str | None = None) -> argparse.ArgumentParser:
    """The parser of all commands; of those that are not ``only`` it knows no arguments, which saves their imports."""
    parser = argparse.ArgumentParser(
        prog="scenelang", description="The Scene Language: scenes as programs, words and embeddings."
    )
    parser.add_argument("--version", action=_Version, nargs=0, help="show the version and exit")
    subparsers = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    for name, command in COMMANDS.items():
        mine = subparsers.add_parser(name, help=command.help)
        if only is None or name == only:
            getattr(import_module(f"scenelang.cli.{command.module}"), f"add_{name}")(mine)
    return parser


def main(argv: Sequence[str] | None = None, supervised: bool = False) -> int:
    """Run one command and return its exit code; argparse exits with 2 for wrong usage. ``supervised``: commands that
    evaluate programs do so in a child process under hard limits; the child returns from here as well."""
    words = sys.argv[1:] if argv is None else list(argv)
    arguments = build_parser(words[0] if words else "").parse_args(words)
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
