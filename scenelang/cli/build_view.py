"""`view --minecraft`: one program's blocks with the game's own looks, as a page that needs no server."""

from __future__ import annotations

import argparse
import sys
import tempfile
import threading
from pathlib import Path

from scenelang.cli.options import UsageError
from scenelang.cli.output import report
from scenelang.cli.pictures import done
from scenelang.cli.programs import evaluated, session_limit
from scenelang.cli.view import open_page, page_file, write_page


def view_build(arguments: argparse.Namespace) -> int:
    """Write the page of ``--html``, or show one in a browser until Ctrl-C; the files are not watched."""
    if len(arguments.files) > 1:
        raise UsageError("file", "`view --minecraft` shows one program")
    output = page_file(arguments) if arguments.html else None
    (arguments.file,) = arguments.files
    result = evaluated(arguments)
    if result.scene is None:
        return 1
    from scenelang.backends.deepslate.backend import page_of_scene

    page = page_of_scene(result.scene, arguments.textures or "", session_limit(arguments))
    report(arguments, page.warnings)
    if output is None:
        _show(arguments, page.text)
    else:
        write_page(page.text, output)
        done(arguments, output)
    return 0


def _show(arguments: argparse.Namespace, text: str) -> None:
    """Show the page from a file of its own, which goes with Ctrl-C."""
    with tempfile.TemporaryDirectory(prefix="scenelang-page-") as folder:
        page = Path(folder) / "build.html"
        write_page(text, page)
        print(page.as_uri(), flush=True)
        if not arguments.quiet:
            print("Ctrl-C ends it and removes the page.", file=sys.stderr)
        open_page(arguments, page.as_uri())
        try:
            threading.Event().wait()
        except KeyboardInterrupt:
            pass
