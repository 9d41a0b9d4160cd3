"""The command completion: a script that lets a shell complete command lines."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Mapping, Sequence
from typing import Any

SHELLS = ("bash", "zsh", "fish")


def add_completion(subparsers: Any) -> None:
    parser = subparsers.add_parser(
        "completion",
        help="print a script that completes commands in a shell",
        description="Print a script that completes commands, options, choices, files and a program's words. For bash "
        'put `eval "$(scenelang completion bash)"` into ~/.bashrc, for zsh the same with zsh into ~/.zshrc behind '
        "`compinit`; for fish write it to ~/.config/fish/completions/scenelang.fish.",
    )
    parser.add_argument("shell", metavar="SHELL", choices=SHELLS, help="bash, zsh or fish")
    parser.set_defaults(evaluates=False, run=completion, json=False, quiet=False, no_color=False)


def completion(arguments: argparse.Namespace) -> int:
    sys.stdout.write(script(arguments.shell))
    return 0


def script(shell: str) -> str:
    """The script for one of ``SHELLS``."""
    from scenelang.cli.main import build_parser
    from scenelang.shell_completion import bash_script, commands_of, fish_script, zsh_script

    writers = {"bash": bash_script, "zsh": zsh_script, "fish": fish_script}
    return writers[shell](commands_of(build_parser(), _known_values()))


def _known_values() -> Mapping[str, Sequence[str]]:
    """Values of options that the parser takes as any text, by option: shells can help with them all the same."""
    from scenelang.backends import base
    from scenelang.backends.pictures.studio import ENVIRONMENTS, GROUNDS
    from scenelang.grammar.diagnostics import CODES

    return {
        "backend": [backend.name for backend in base.every()],
        "camera": ["turntable", "top", "isometric", "follow"],
        "environment": list(ENVIRONMENTS),
        "ground": list(GROUNDS),
        "codes": [text for name, entry in CODES.items() for text in (entry.code, name)],
    }


COMMANDS = (add_completion,)
