"""The command mcp: a server for agents that build scenes."""

from __future__ import annotations

import argparse
import os
from pathlib import Path
from typing import Any

from scenelang.backends.base import every, need
from scenelang.cli.options import UsageError, add_limits, limits_of


def add_mcp(subparsers: Any) -> None:
    parser = subparsers.add_parser(
        "mcp",
        help="serve an agent over standard input and output (docs/mcp.md)",
        description="A server of the Model Context Protocol: an agent checks, runs, counts, renders and compares "
        "programs, its own or files of the project folder. It writes no files.",
    )
    parser.add_argument(
        "--project", metavar="DIR", default=".", help="the only folder whose files are read (default: the current one)"
    )
    add_limits(parser)
    parser.set_defaults(evaluates=False, run=mcp)


def mcp(arguments: argparse.Namespace) -> int:
    folder = Path(arguments.project)
    if not folder.is_dir():
        raise UsageError("file", f"there is no folder {arguments.project}")
    need("mcp", "'scenelang[mcp]'")
    from importlib.metadata import version

    from scenelang.mcp.server import build_server, work
    from scenelang.mcp.tools import Project
    from scenelang.sandbox.worker import Worker

    root = folder.resolve()
    os.chdir(root)  # what programs import and what diagnostics name is relative to it
    _import_ahead()
    worker = Worker(work, (str(root),))
    build_server(Project(root, limits_of(arguments)), version("scenelang"), worker).run("stdio")
    return 0


def _import_ahead() -> None:
    """Modules and tables that every request needs are loaded once, before processes are forked for requests."""
    from scenelang.backends.pictures import film  # noqa: F401
    from scenelang.grammar import ast, reader
    from scenelang.stdlib.library import build_library

    reader.prepare()
    ast.prepare()
    build_library()
    every()


COMMANDS = (add_mcp,)
