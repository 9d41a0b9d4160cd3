"""The command diff: what differs between the geometry of two scenes."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from scenelang.cli.options import UsageError, add_common, limits_of, session_of, whole
from scenelang.cli.output import print_json, report_run, say
from scenelang.sandbox.supervision import limited
from scenelang.scene_changes import TOLERANCE, change_lines, changes_between, sheets_in, sheets_of

if TYPE_CHECKING:
    from scenelang.interpreter.scene.difference import Sheet


def tolerance(text: str) -> float:
    """A part of the scene's size, more than 0 and less than 1."""
    try:
        value = float(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"`{text}` is no number") from None
    if not 0 < value < 1:
        raise argparse.ArgumentTypeError(f"`{text}` is not between 0 and 1")
    return value


def add_diff(subparsers: Any) -> None:
    parser = subparsers.add_parser("diff", help="what differs between the geometry of two scenes")
    parser.add_argument("a", metavar="A", help="a program, or a flattened scene (.json)")
    parser.add_argument("b", metavar="B", help="a program, or a flattened scene (.json)")
    parser.add_argument(
        "--tolerance", type=tolerance, default=TOLERANCE, metavar="T",
        help="differences up to this part of the scene's size do not count (default 1e-5)",
    )  # fmt: skip
    parser.add_argument("--limit", type=whole, default=20, metavar="N", help="changes to print (default 20)")
    add_common(parser)
    parser.set_defaults(run=diff)


def diff(arguments: argparse.Namespace) -> int:
    if arguments.a == arguments.b == "-":
        raise UsageError("file", "only one of the two can be standard input")
    sides: list[Sequence[Sheet]] = []
    for path in (arguments.a, arguments.b):
        with limited(limits_of(arguments)):
            sheets = _sheets(arguments, path)
        if sheets is None:
            return 1
        sides.append(sheets)
    frames_a, frames_b = sides
    with limited(limits_of(arguments)):
        found = changes_between(frames_a, frames_b, arguments.tolerance)
    if arguments.json:
        print_json(found.data())
    else:
        say("\n".join(change_lines(found, arguments.limit)))
    return 0 if found.equal else 1


def _sheets(arguments: argparse.Namespace, path: str) -> Sequence[Sheet] | None:
    """The frames of a program or a JSON file; None when the program is wrong, which is then said."""
    limit = limits_of(arguments).primitives
    sheets = sheets_in(path, limit)
    if sheets is not None:
        return sheets
    arguments.file = path  # what the shared options look at: embeddings lie beside it
    session = session_of(arguments)
    result = session.evaluate(session.source(path))
    report_run(arguments, result)
    return sheets_of(result.scene, limit) if result.scene is not None else None


COMMANDS = (add_diff,)
