"""The commands, and the parser of their arguments."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from importlib import import_module
from typing import Any, NamedTuple

from scenelang.cli.options import add_common, add_file, add_output


class Kind(NamedTuple):
    """What commands of a kind share: a FILE before their own arguments, ``groups`` of options behind them, and whether
    they evaluate programs, which is done under hard limits."""

    takes_file: bool = False
    groups: Callable[[argparse.ArgumentParser], None] | None = None
    evaluates: bool = True


PROGRAM = Kind(True, add_common)
EVALUATION = Kind(False, add_common)
OUTPUT = Kind(False, add_output)
TEXT = Kind(False, add_output, False)  # reads and writes, and runs nothing
FILE = Kind(True)
OWN = Kind()  # declares all its arguments itself
SERVER = Kind(evaluates=False)


class Command(NamedTuple):
    """A command: ``run_NAME`` of ``module`` does the work, ``add_NAME`` declares its own arguments, where it has any;
    ``help`` is one line."""

    kind: Kind
    module: str
    help: str

    def part(self, name: str, prefix: str) -> Any:
        """A function of the command, None where there is none."""
        return getattr(import_module(f"scenelang.cli.{self.module}"), f"{prefix}_{name}", None)


# In the order in which help and the reference list them.
GROUPS: dict[str, dict[str, Command]] = {
    "Write programs": {
        "check": Command(EVALUATION, "programs", "find mistakes without running the program"),
        "run": Command(PROGRAM, "programs", "evaluate a program and say what the scene is"),
        "repl": Command(EVALUATION, "servers", "the language interactively"),
        "fmt": Command(TEXT, "programs", "format programs: line breaks and indentation"),
        "explain": Command(TEXT, "programs", "why an error or warning arises, and how to mend it"),
        "diff": Command(EVALUATION, "programs", "what differs between the geometry of two scenes"),
        "expand": Command(PROGRAM, "programs", "print the program after macro expansion"),
        "transpile": Command(OWN, "programs", "turn a language model's Python into a program"),
        "import": Command(OUTPUT, "programs", "make a program of a Minecraft build: .schem .litematic .nbt"),
    },
    "Look at scenes": {
        "render": Command(PROGRAM, "pictures", "draw a picture or a film of the scene"),
        "view": Command(EVALUATION, "pictures", "show programs in a browser, live"),
        "maps": Command(EVALUATION, "pictures", "write labelled pictures: words, depth, boxes, motion"),
        "graph": Command(PROGRAM, "pictures", "draw what is made of what, as the paper's Figure 2 does"),
        "tree": Command(PROGRAM, "programs", "print the entity hierarchy"),
        "count": Command(PROGRAM, "programs", "count the instances of every word"),
        "bounds": Command(PROGRAM, "programs", "the exact bounding box of the scene, or of a word's entities"),
        "flatten": Command(PROGRAM, "programs", "the primitives with their world matrices"),
    },
    "Make files for other programs": {
        "export": Command(PROGRAM, "pictures", "write the scene as a file for other programs"),
        "backends": Command(OUTPUT, "pictures", "list what scenes can be turned into"),
    },
    "Ask a language model": {
        "generate": Command(OWN, "models", "make a scene of words and pictures, by a language model"),
        "edit": Command(OWN, "models", "change a scene by an instruction, by a language model"),
        "runs": Command(TEXT, "models", "list the runs of generate and edit, or the attempts of one"),
    },
    "Embeddings and neural models": {
        "embeddings": Command(FILE, "neural", "the embeddings of a scene: list, change, encode, compare"),
        "embed": Command(PROGRAM, "models", "describe every primitive in words, for neural backends"),
        "imagine": Command(PROGRAM, "neural", "a picture of the scene by a text-to-image model"),
        "invert": Command(PROGRAM, "neural", "learn the embeddings of entities from a picture of them"),
        "style": Command(PROGRAM, "neural", "learn a style from a picture, for a scene or a part of it"),
        "distill": Command(PROGRAM, "neural", "learn how primitives look as Gaussians, from diffusion models"),
        "eval": Command(EVALUATION, "evaluation", "metrics of scenes in the paper's tables, and its user study"),
    },
    "Editors, agents, this machine": {
        "lsp": Command(SERVER, "servers", "serve an editor over standard input and output (docs/editors.md)"),
        "mcp": Command(SERVER, "servers", "serve an agent over standard input and output (docs/mcp.md)"),
        "grammar": Command(TEXT, "programs", "write the language's grammar for another program"),
        "completion": Command(SERVER, "servers", "print a script that completes commands in a shell"),
        "doctor": Command(TEXT, "programs", "what is installed, which backends work and what is missing"),
    },
}
COMMANDS = {name: command for group in GROUPS.values() for name, command in group.items()}


class _Version(argparse.Action):
    """Prints the version; looked up only when asked for, since that takes a while."""

    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> None:
        from importlib.metadata import version

        print(f"scenelang {version('scenelang')}")
        parser.exit()


def build_parser(only: str | None = None) -> argparse.ArgumentParser:
    """The parser of all commands; of those that are not ``only`` it knows no arguments, which saves their imports."""
    parser = argparse.ArgumentParser(
        prog="scenelang",
        usage="scenelang [-h] [--version] COMMAND ...",
        description="The Scene Language: scenes as programs, words and embeddings.",
        epilog=_listing(),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--version", action=_Version, nargs=0, help="show the version and exit")
    subparsers = parser.add_subparsers(dest="command", required=True, metavar="COMMAND", help=argparse.SUPPRESS)
    for name, command in COMMANDS.items():
        mine = subparsers.add_parser(name, help=command.help)
        if only is None or name == only:
            _add_arguments(mine, name, command)
    return parser


def _listing() -> str:
    """All commands with their lines, by group."""
    groups = [
        "\n".join([f"{title}:", *(f"  {name:<11} {command.help}" for name, command in group.items())])
        for title, group in GROUPS.items()
    ]
    return "\n\n".join([*groups, "`scenelang COMMAND --help` explains one of them."])


def _add_arguments(parser: argparse.ArgumentParser, name: str, command: Command) -> None:
    if command.kind.takes_file:
        add_file(parser)
    own = command.part(name, "add")
    if own is not None:
        own(parser)
    if command.kind.groups is not None:
        command.kind.groups(parser)
