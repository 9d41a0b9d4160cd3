"""Interactive commands and servers (repl, lsp, mcp), and completion, which prints a shell script."""

from __future__ import annotations

import argparse
import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from scenelang.backends.base import require
from scenelang.cli.options import UsageError, add_limits, limits_of, session_of, use_color

if TYPE_CHECKING:
    from scenelang.repl.loop import ModelRequest

SHELLS = ("bash", "zsh", "fish")


# --- repl ------------------------------------------------------------------------------------------------------------


def add_repl(parser: argparse.ArgumentParser) -> None:
    parser.description = (
        "Enter forms and print their values. `,help` lists the commands. Without a terminal, forms are read "
        "from standard input, values are written to standard output and diagnostics to standard error."
    )
    parser.add_argument("file", metavar="FILE", nargs="?", help="program to load at startup")
    parser.add_argument("--plain", action="store_true", help="disable terminal features (implied without a terminal)")
    parser.add_argument("--prompt", metavar="TEXT", help="prompt written before each line is read, in plain mode")
    parser.add_argument("--strict-errors", action="store_true", help="exit 1 if an input had errors, in plain mode")


def _model_request(command: str, line: str) -> ModelRequest:
    from scenelang.cli.models import model_request

    return model_request(command, line)


def run_repl(arguments: argparse.Namespace) -> int:
    from scenelang.repl.evaluation import ReplEvaluation

    file = arguments.file
    is_terminal = sys.stdin.isatty() and sys.stdout.isatty() and os.environ.get("TERM") != "dumb"
    is_plain = arguments.plain or arguments.json or not is_terminal
    arguments.file = file or "-"  # locates the embeddings file
    evaluation = ReplEvaluation(session_of(arguments), file)
    if not is_plain:
        from scenelang.repl.console import run

        run(evaluation, use_color(arguments, sys.stdout), arguments.quiet, _model_request)
        return 0
    from scenelang.repl.plain import standard

    prompt = arguments.prompt
    if prompt is None:
        prompt = "> " if sys.stdin.isatty() and not arguments.json else ""
    errors = standard(prompt, arguments.json, arguments.quiet, _model_request).run(evaluation)
    return 1 if errors and arguments.strict_errors else 0


# --- lsp, mcp --------------------------------------------------------------------------------------------------------


def add_lsp(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--stdio", action="store_true", help="use standard input and output (the only transport; for compatibility)"
    )


def run_lsp(arguments: argparse.Namespace) -> int:
    require("pygls", "'scenelang[lsp]'")
    from importlib.metadata import version

    from scenelang.lsp.server import serve

    serve(version("scenelang"))
    sys.stdout = open(os.devnull, "w")  # noqa: SIM115 - the server has closed the original stdout
    return 0


def add_mcp(parser: argparse.ArgumentParser) -> None:
    parser.description = (
        "Start a server of the Model Context Protocol: agents check, run, count, render and compare "
        "programs, passed as text or as files of the project folder. It writes no files."
    )
    parser.add_argument(
        "--project",
        metavar="DIR",
        default=".",
        help="project folder; no other files are read (default: the current folder)",
    )
    add_limits(parser)


def run_mcp(arguments: argparse.Namespace) -> int:
    folder = Path(arguments.project)
    if not folder.is_dir():
        raise UsageError("file", f"not a folder: {arguments.project}")
    require("mcp", "'scenelang[mcp]'")
    from importlib.metadata import version

    from scenelang.mcp.server import serve

    serve(folder.resolve(), limits_of(arguments), version("scenelang"))
    return 0


# --- completion ------------------------------------------------------------------------------------------------------


def add_completion(parser: argparse.ArgumentParser) -> None:
    parser.description = (
        "Print a completion script for commands, options, choices, files and a program's words. For bash "
        'add `eval "$(scenelang completion bash)"` to ~/.bashrc, for zsh the same with zsh to ~/.zshrc after '
        "`compinit`; for fish write it to ~/.config/fish/completions/scenelang.fish."
    )
    parser.add_argument("shell", metavar="SHELL", choices=SHELLS, help="shell: bash, zsh or fish")


def run_completion(arguments: argparse.Namespace) -> int:
    from argcomplete.shell_integration import shellcode

    code = shellcode(["scenelang", "scene"], shell=arguments.shell, complete_arguments=["-o", "nospace"])  # nosec B604
    sys.stdout.write(code)
    return 0
