"""The command graph: the computation graph of a scene as a drawing."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from scenelang.cli.options import UsageError, add_common, add_file, whole
from scenelang.cli.pictures import check_folder, done
from scenelang.cli.programs import evaluated


def add_graph(subparsers: Any) -> None:
    parser = subparsers.add_parser("graph", help="draw what is made of what, as the paper's Figure 2 does")
    add_file(parser)
    parser.add_argument("-o", "--output", metavar="OUT.svg", required=True, help="the drawing to write")
    parser.add_argument("--depth", type=whole, metavar="N", help="levels below the root")
    parser.add_argument("--frame", type=whole, metavar="N", help="frame of a 4D scene (default 0)")
    parser.add_argument("--thumbnails", action="store_true", help="a small picture of every node")
    add_common(parser)
    parser.set_defaults(run=graph)


def graph(arguments: argparse.Namespace) -> int:
    output = Path(arguments.output)
    if output.suffix.lower() != ".svg":
        raise UsageError("backend", f"a graph cannot be written as `{output.name}`", "use .svg")
    check_folder(output)
    result = evaluated(arguments)
    if result.scene is None:
        return 1
    from scenelang.backends.pictures.call_graph import write_graph

    write_graph(result.scene, output, arguments.frame, arguments.depth, arguments.thumbnails)
    done(arguments, output)
    return 0


COMMANDS = (add_graph,)
