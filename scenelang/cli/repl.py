"""The command `repl`: the language interactively, in a terminal or driven by another program."""

from __future__ import annotations

import argparse
import os
import sys
from typing import Any

from scenelang.cli.options import add_common, session_of
from scenelang.cli.output import use_color


def add_repl(subparsers: Any) -> None:
    parser = subparsers.add_parser(
        "repl",
        help="the language interactively",
        description="Type forms and see their values. `,help` lists the commands. Without a terminal forms are read "
        "from standard input, values go to standard output and diagnostics to standard error.",
    )
    parser.add_argument("file", metavar="FILE", nargs="?", help="a program to begin with")
    parser.add_argument("--plain", action="store_true", help="no terminal features; so too without a terminal")
    parser.add_argument("--prompt", metavar="TEXT", help="in plain mode, what is written before each line is read")
    parser.add_argument("--strict-errors", action="store_true", help="in plain mode, exit 1 when an input was wrong")
    add_common(parser)
    parser.set_defaults(run=repl)


def repl(arguments: argparse.Namespace) -> int:
    from scenelang.repl.evaluation import ReplEvaluation

    file = arguments.file
    is_terminal = sys.stdin.isatty() and sys.stdout.isatty() and os.environ.get("TERM") != "dumb"
    is_plain = arguments.plain or arguments.json or not is_terminal
    arguments.file = file or "-"  # where embeddings are looked for
    evaluation = ReplEvaluation(session_of(arguments), file)
    if not is_plain:
        from scenelang.repl.console import run

        run(evaluation, use_color(arguments, sys.stdout), arguments.quiet)
        return 0
    from scenelang.repl.plain import standard

    prompt = arguments.prompt
    if prompt is None:
        prompt = "> " if sys.stdin.isatty() and not arguments.json else ""
    errors = standard(prompt, arguments.json, arguments.quiet).run(evaluation)
    return 1 if errors and arguments.strict_errors else 0


COMMANDS = (add_repl,)
