"""Table of commands, and the argument parser."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from importlib import import_module
from typing import Any, NamedTuple

from scenelang.cli.options import add_common, add_file, add_output
from scenelang.reports import Parser


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
        "repl": Command(EVALUATION, "servers", "start an interactive session (REPL)"),
        "fmt": Command(TEXT, "programs", "format programs: line breaks and indentation"),
        "explain": Command(TEXT, "programs", "explain an error or warning and how to fix it"),
        "diff": Command(EVALUATION, "programs", "compare the geometry of two scenes"),
        "expand": Command(PROGRAM, "programs", "print the program after macro expansion"),
        "transpile": Command(OWN, "programs", "convert Python written by a language model to a program"),
        "import": Command(OUTPUT, "programs", "convert a Minecraft build to a program: .schem .litematic .nbt"),
    },
    "Inspect scenes": {
        "render": Command(PROGRAM, "pictures", "render an image or a video of the scene"),
        "view": Command(EVALUATION, "pictures", "show programs in a browser with live reload"),
        "maps": Command(EVALUATION, "pictures", "render labeled images: segmentation, depth, boxes, motion"),
        "graph": Command(PROGRAM, "pictures", "draw the dependency graph of words (paper, Figure 2)"),
        "tree": Command(PROGRAM, "programs", "print the entity hierarchy"),
        "count": Command(PROGRAM, "programs", "count the instances of every word"),
        "bounds": Command(PROGRAM, "programs", "print the exact bounding box of the scene or of a word"),
        "flatten": Command(PROGRAM, "programs", "list the primitives with their world matrices"),
    },
    "Export": {
        "export": Command(PROGRAM, "pictures", "export the scene to another file format"),
        "backends": Command(OUTPUT, "pictures", "list the backends and their output formats"),
    },
    "Generate with language models": {
        "generate": Command(OWN, "models", "generate a scene from text and images with a language model"),
        "edit": Command(OWN, "models", "edit a scene by an instruction with a language model"),
        "runs": Command(TEXT, "models", "list the runs of generate and edit, or the attempts of one"),
    },
    "Embeddings and neural models": {
        "embeddings": Command(FILE, "neural", "list, change, encode and compare the embeddings of a scene"),
        "embed": Command(PROGRAM, "models", "describe every primitive in words, for neural backends"),
        "imagine": Command(PROGRAM, "neural", "generate an image of the scene with a text-to-image model"),
        "invert": Command(PROGRAM, "neural", "learn embeddings of entities from a photo (textual inversion)"),
        "style": Command(PROGRAM, "neural", "learn a style embedding from an image"),
        "distill": Command(PROGRAM, "neural", "optimize 3D Gaussians with score distillation (SDS)"),
        "eval": Command(EVALUATION, "evaluation", "compute the paper's metrics, and run its user study"),
    },
    "Integrations and diagnostics": {
        "lsp": Command(SERVER, "servers", "start the language server on standard input and output"),
        "mcp": Command(SERVER, "servers", "start the MCP server on standard input and output"),
        "grammar": Command(TEXT, "programs", "export the grammar of the language"),
        "completion": Command(SERVER, "servers", "print a shell completion script"),
        "doctor": Command(TEXT, "programs", "check the installation and report what is missing"),
    },
}
COMMANDS = {name: command for group in GROUPS.values() for name, command in group.items()}


class _Version(argparse.Action):
    """Print the version and exit; the metadata lookup is slow, so it runs only on request."""

    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> None:
        from importlib.metadata import version

        print(f"scenelang {version('scenelang')}")
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
