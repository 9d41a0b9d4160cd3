"""The command transpile: a language model's Python as a program of the language."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

from scenelang.cli.options import UsageError, add_limits, add_output, limits_of
from scenelang.cli.output import report
from scenelang.session import Options, Session


def add_transpile(subparsers: Any) -> None:
    parser = subparsers.add_parser(
        "transpile",
        help="turn a language model's Python into a program",
        description="Turn the Python of a language model's response into a program. The Python is never run.",
    )
    parser.add_argument(
        "file", metavar="FILE", help="a response (.txt), a Python program (.py), `-` for standard input"
    )
    parser.add_argument("-o", "--output", metavar="OUT.scene", help="where to write it (default: standard output)")
    add_output(parser)
    add_limits(parser)
    parser.set_defaults(run=transpile)


def transpile(arguments: argparse.Namespace) -> int:
    if arguments.output is not None and Path(arguments.output).resolve() == Path(arguments.file).resolve():
        raise UsageError("file", "the output would replace the Python that it is made of")
    session = Session(Options(limits=limits_of(arguments)))
    translation = session.transpile(session.source(arguments.file))
    report(arguments, translation.diagnostics)
    if not translation.ok:
        return 1
    if arguments.output is None:
        sys.stdout.write(translation.text)
        return 0
    from scenelang.backends.files import written_whole

    with written_whole(arguments.output) as path:
        path.write_text(translation.text, encoding="utf-8")
    return 0


COMMANDS = (add_transpile,)
