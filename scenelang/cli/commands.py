"""The table of commands, and what ``scenelang --help`` prints; no module of a command is imported for it."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from importlib import import_module
from typing import Any, NamedTuple, TypeVar

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
        "transpile": Command(STANDALONE, "programs", "convert Python written by a language model to a program"),
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
        "export": Command(PROGRAM, "exports", "export the scene to another file format"),
        "backends": Command(OUTPUT, "exports", "list the backends and their output formats"),
    },
    "Generate with language models": {
        "generate": Command(STANDALONE, "models", "generate a scene from text and images with a language model"),
        "edit": Command(STANDALONE, "models", "edit a scene by an instruction with a language model"),
        "bench": Command(TEXT, "bench", "measure a language model on tasks that are judged by geometry"),
        "runs": Command(TEXT, "models", "list the runs of generate and edit, or the attempts of one"),
    },
    "Embeddings and neural models": {
        "embeddings": Command(FILE, "neural", "list, change, encode and compare the embeddings of a scene"),
        "embed": Command(PROGRAM, "describing", "describe every primitive in words, for neural backends"),
        "imagine": Command(PROGRAM, "neural", "generate an image of the scene with a text-to-image model"),
        "invert": Command(PROGRAM, "neural", "learn embeddings of entities from a photo (textual inversion)"),
        "style": Command(PROGRAM, "neural", "learn a style embedding from an image"),
        "distill": Command(PROGRAM, "neural", "optimize 3D Gaussians with score distillation (SDS)"),
        "eval": Command(EVALUATION, "describing", "compute the paper's metrics, and run its user study"),
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


def top_parser(kind: type[AnyParser], version: type[argparse.Action]) -> AnyParser:
    """Create the parser of the options before a command; its help lists the commands."""
    parser = kind(
        prog="scenelang",
        usage="scenelang [-h] [--version] COMMAND ...",
        description="The Scene Language: scenes as programs, words and embeddings.",
        epilog=_listing(),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--version", action=version, nargs=0, help="show the version and exit")
    return parser


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
