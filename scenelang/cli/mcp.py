"""The command mcp: a server for agents that build scenes."""

from __future__ import annotations

import argparse
import os
from pathlib import Path
from typing import Any

from scenelang.backends.base import need
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
    parser.set_defaults(run=mcp)


def mcp(arguments: argparse.Namespace) -> int:
    folder = Path(arguments.project)
    if not folder.is_dir():
        raise UsageError("file", f"there is no folder {arguments.project}")
    need("mcp", "'scenelang[mcp]'")
    from importlib.metadata import version

    from scenelang.mcp.project import Project
    from scenelang.mcp.server import build_server

    root = folder.resolve()
    os.chdir(root)  # what programs import and what diagnostics name is relative to it
    build_server(Project(root, limits_of(arguments)), version("scenelang")).run("stdio")
    return 0


COMMANDS = (add_mcp,)
