"""The command lsp: the language server for editors."""

from __future__ import annotations

import argparse
import os
import sys
from typing import Any

from scenelang.backends.base import need


def add_lsp(subparsers: Any) -> None:
    parser = subparsers.add_parser("lsp", help="serve an editor over standard input and output (docs/editors.md)")
    parser.add_argument("--stdio", action="store_true", help="what editors add; the only way there is")
    parser.set_defaults(evaluates=False, run=lsp)


def lsp(arguments: argparse.Namespace) -> int:
    need("pygls", "'scenelang[lsp]'")
    from importlib.metadata import version

    from scenelang.lsp.server import serve

    serve(version("scenelang"))
    sys.stdout = open(os.devnull, "w")  # noqa: SIM115 - the protocol's end has closed the real one
    return 0


COMMANDS = (add_lsp,)
