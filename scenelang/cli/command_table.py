"""The table of commands, and what ``scenelang --help`` prints; no module of a command is imported for it."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence
from functools import cache, partial
from importlib import import_module
from typing import Any, NamedTuple, TypeVar

# The messages of argparse are in English, as the others are: looking for translations loads `locale` for each command.
argparse._ = str  # type: ignore[attr-defined]

AnyParser = TypeVar("AnyParser", bound=argparse.ArgumentParser)


class CommandKind(NamedTuple):
    """Properties of commands: a leading FILE, the ``options`` that it shares ("common" with all that evaluate programs,
    "output" with all that print), and whether programs run, under hard limits."""

    takes_file: bool = False
    options: str = ""
    evaluates: bool = True


PROGRAM = CommandKind(True, "common")
EVALUATION = CommandKind(False, "common")
OUTPUT = CommandKind(False, "output")
TEXT = CommandKind(False, "output", False)  # does not evaluate programs
FILE = CommandKind(True)
STANDALONE = CommandKind()  # declares all of its arguments
SERVER = CommandKind(evaluates=False)


class CommandRow(NamedTuple):
    """A command, run by ``run_NAME`` of ``module``; ``add_NAME``, if defined, declares its arguments."""

    kind: CommandKind
    module: str
    help: str

    def part(self, name: str, prefix: str) -> Any:
        """Return a function of the command's module, or None if it is not defined."""
        return getattr(import_module(f"scenelang.cli.{self.module}"), f"{prefix}_{name}", None)


# In the order of the help listing and the reference.
GROUPS: dict[str, dict[str, CommandRow]] = {
    "Write programs": {
        "check": CommandRow(EVALUATION, "programs", "check programs for errors without running them"),
        "run": CommandRow(PROGRAM, "programs", "evaluate a program and summarize its scene"),
        "repl": CommandRow(EVALUATION, "programs", "start an interactive session (REPL)"),
        "fmt": CommandRow(TEXT, "programs", "format programs: line breaks and indentation"),
        "explain": CommandRow(TEXT, "programs", "explain an error or warning and how to fix it"),
        "diff": CommandRow(EVALUATION, "programs", "compare the geometry of two scenes"),
        "expand": CommandRow(PROGRAM, "programs", "print the program after macro expansion"),
        "transpile": CommandRow(STANDALONE, "programs", "convert Python written by a language model to a program"),
        "simplify": CommandRow(PROGRAM, "programs", "rewrite a program as a person would write it"),
        "import": CommandRow(OUTPUT, "programs", "convert OpenSCAD, Blender scripts, Minecraft builds"),
    },
    "Inspect scenes": {
        "render": CommandRow(PROGRAM, "pictures", "render an image or a video of the scene"),
        "sheet": CommandRow(EVALUATION, "pictures", "draw a contact sheet, or two scenes with what differs"),
        "view": CommandRow(EVALUATION, "pictures", "show programs in a browser with live reload"),
        "studio": CommandRow(EVALUATION, "pictures", "edit programs in a browser beside their live picture"),
        "labels": CommandRow(EVALUATION, "pictures", "render labeled images: segmentation, depth, boxes, motion"),
        "dataset": CommandRow(TEXT, "pictures", "make labeled datasets of any size from a spec of what varies"),
        "graph": CommandRow(PROGRAM, "pictures", "draw the dependency graph of words (paper, Figure 2)"),
        "tree": CommandRow(PROGRAM, "programs", "print the entity hierarchy"),
        "count": CommandRow(PROGRAM, "programs", "count the instances of every word"),
        "bounds": CommandRow(PROGRAM, "programs", "print the exact bounding box of the scene or of a word"),
        "measure": CommandRow(PROGRAM, "programs", "print volume, surface, center of mass and inertia"),
        "simulate": CommandRow(PROGRAM, "physics", "show how the scene moves under gravity, as a video or a 4D scene"),
        "settle": CommandRow(PROGRAM, "physics", "let the scene come to rest, and write it with the new poses"),
        "repair": CommandRow(PROGRAM, "physics", "edit the program to resolve findings and failed declarations"),
        "flatten": CommandRow(PROGRAM, "programs", "count the primitives; with --json list them with matrices"),
    },
    "Export": {
        "export": CommandRow(PROGRAM, "exports", "export the scene to another file format"),
        "backends": CommandRow(OUTPUT, "exports", "list the backends and their output formats"),
    },
    "Generate with language models": {
        "generate": CommandRow(STANDALONE, "models", "generate a scene from text and images with a language model"),
        "build": CommandRow(STANDALONE, "models", "build a scene step by step, with acceptance and a critic"),
        "edit": CommandRow(STANDALONE, "models", "edit a scene by an instruction with a language model"),
        "bench": CommandRow(TEXT, "bench", "measure a language model on tasks that are judged by geometry"),
        "runs": CommandRow(TEXT, "models", "list the runs of generate, build and edit, or the attempts of one"),
    },
    "Embeddings and neural models": {
        "embeddings": CommandRow(FILE, "neural", "list, change, encode and compare the embeddings of a scene"),
        "embed": CommandRow(PROGRAM, "embed_eval", "describe every primitive in words, for neural backends"),
        "imagine": CommandRow(PROGRAM, "neural", "generate an image of the scene with a text-to-image model"),
        "invert": CommandRow(PROGRAM, "neural", "learn embeddings of entities from a photo (textual inversion)"),
        "style": CommandRow(PROGRAM, "neural", "learn a style embedding from an image"),
        "distill": CommandRow(PROGRAM, "neural", "optimize 3D Gaussians with score distillation (SDS)"),
        "eval": CommandRow(EVALUATION, "embed_eval", "compute the paper's metrics, and run its user study"),
    },
    "Integrations and diagnostics": {
        "lsp": CommandRow(SERVER, "programs", "start the language server on standard input and output"),
        "mcp": CommandRow(SERVER, "programs", "start the MCP server on standard input and output"),
        "search": CommandRow(TEXT, "programs", "search the language and its examples by meaning"),
        "grammar": CommandRow(TEXT, "programs", "export the grammar of the language"),
        "completion": CommandRow(SERVER, "programs", "print a shell completion script"),
        "doctor": CommandRow(TEXT, "programs", "check the installation and report what is missing"),
    },
}
COMMANDS = {name: command for group in GROUPS.values() for name, command in group.items()}

# Commands of earlier versions, with the names of today (docs/decisions.md, "Names of the field").
RENAMED_COMMANDS = {"lift": "simplify", "maps": "labels"}


def top_parser(kind: type[AnyParser], version: type[argparse.Action]) -> AnyParser:
    """Create the parser of the options before a command; its help lists the commands."""
    parser = kind(
        prog="scenelang",
        usage="scenelang [-h] [--version] COMMAND ...",
        description="The Scene Language: scenes as programs, words and embeddings.",
        epilog=_listing(),
        formatter_class=formatter(argparse.RawDescriptionHelpFormatter),
    )
    parser.add_argument("--version", action=version, nargs=0, help="show the version and exit")
    return parser


def formatter(kind: type[argparse.HelpFormatter]) -> Any:
    """Return a class of help for ``argparse``, as wide as the terminal.

    The size is read once; argparse asks ``shutil`` for it with every argument, which loads libraries of compression.
    """
    return partial(kind, width=_columns() - 2)


@cache
def _columns() -> int:
    """Return the width of the terminal in characters, as ``shutil.get_terminal_size`` does."""
    stated = os.environ.get("COLUMNS", "")
    if stated.isdecimal() and int(stated) > 0:
        return int(stated)
    try:
        return os.get_terminal_size(1).columns or _DEFAULT_COLUMNS
    except OSError:
        return _DEFAULT_COLUMNS


_DEFAULT_COLUMNS = 80


def prints_help(words: Sequence[str]) -> bool:
    """Print the help of ``scenelang`` if nothing else is asked for; False where ``main`` must run.

    It runs before ``main`` is imported, which takes four times as long. An output that cannot be written is reported
    by ``main``, which prints the help again.
    """
    if list(words) not in ([], ["-h"], ["--help"]):
        return False
    try:
        sys.stdout.write(top_parser(argparse.ArgumentParser, argparse.Action).format_help())
        sys.stdout.flush()
    except OSError:
        return False
    return True


def _listing() -> str:
    """Return the help listing of all commands by group."""
    groups = [
        "\n".join([f"{title}:", *(f"  {name:<11} {command.help}" for name, command in group.items())])
        for title, group in GROUPS.items()
    ]
    return "\n\n".join([*groups, "See `scenelang COMMAND --help` for the options of a command."])
