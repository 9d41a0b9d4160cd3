"""The command `view`: programs in a browser page, live, or as one file that works offline."""

from __future__ import annotations

import argparse
import copy
import os
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from scenelang.cli.options import UsageError, add_common, session_of
from scenelang.cli.output import report
from scenelang.cli.pictures import check_folder, done
from scenelang.session import Session

if TYPE_CHECKING:
    from scenelang.backends.viewer.packet import SplatsOf
    from scenelang.viewer.workspace import Evaluate, Workspace


def _port(text: str) -> int:
    if not text.isdecimal() or not 0 <= int(text) <= 65535:
        raise argparse.ArgumentTypeError(f"`{text}` is no port; it is a number from 0 to 65535")
    return int(text)


def add_view(subparsers: Any) -> None:
    parser = subparsers.add_parser("view", help="show programs in a browser, live")
    parser.add_argument("files", metavar="FILE", nargs="+", help="programs; their files are watched")
    parser.add_argument("--html", metavar="OUT.html", help="write one page that works offline, and serve nothing")
    parser.add_argument("--minecraft", action="store_true", help="the blocks of one program with the game's own looks")
    parser.add_argument("--textures", metavar="PATH", help="where these looks are (default: the installed game)")
    parser.add_argument("--splats", action="store_true", help="show Gaussians in place of solids")
    parser.add_argument("--distilled", metavar="DIR", help="show what a run of `distill` learned")
    parser.add_argument("--port", type=_port, default=0, metavar="N", help="the port (default: a free one)")
    parser.add_argument("--no-browser", action="store_true", help="only print the address")
    add_common(parser)
    parser.set_defaults(run=view)


def view(arguments: argparse.Namespace) -> int:
    if "-" in arguments.files:
        raise UsageError("file", "`view` watches files, so it cannot show standard input")
    if arguments.textures is not None and not arguments.minecraft:
        raise UsageError("value", "`--textures` goes with `--minecraft`")
    if arguments.distilled is not None and len(arguments.files) > 1:
        raise UsageError("value", "`--distilled` shows one program")
    if arguments.minecraft and (arguments.splats or arguments.distilled is not None):
        raise UsageError("value", "`--minecraft` shows blocks, `--splats` and `--distilled` Gaussians: choose one")
    if arguments.minecraft:
        from scenelang.cli.build_view import view_build

        return view_build(arguments)
    from scenelang.sandbox.worker import Worker
    from scenelang.viewer.workspace import Workspace

    evaluate = _evaluator(arguments)
    if arguments.html:
        return save(arguments, Workspace(arguments.files, evaluate))
    return serve(arguments, Workspace(arguments.files, Worker(evaluate).ask))


def _evaluator(arguments: argparse.Namespace) -> Evaluate:
    from scenelang.backends.viewer.packet import LIMIT
    from scenelang.viewer.workspace import evaluator

    def open_session(file: str, values: Mapping[str, str]) -> Session:
        chosen = copy.copy(arguments)
        chosen.file = file
        chosen.define = [*arguments.define, *(f"{name}={text}" for name, text in values.items())]
        return session_of(chosen)

    arguments.file = arguments.files[0]
    session_of(arguments)  # mistakes of the command line come first
    limit = arguments.max_primitives
    return evaluator(open_session, LIMIT if limit is None else int(limit), _splats(arguments))


def _splats(arguments: argparse.Namespace) -> SplatsOf | None:
    """The Gaussians that are shown in place of solids, None for solids."""
    if arguments.distilled is None and not arguments.splats:
        return None
    from scenelang.backends.viewer.packet import distilled_splats, own_splats

    return own_splats if arguments.distilled is None else distilled_splats(Path(arguments.distilled))


def serve(arguments: argparse.Namespace, workspace: Workspace) -> int:
    """Serve until Ctrl-C."""
    from scenelang.viewer.server import ViewServer

    with ViewServer(workspace, arguments.port) as server:
        print(server.address, flush=True)
        if not arguments.quiet:
            print("Ctrl-C ends it.", file=sys.stderr)
        open_page(arguments, server.address)
        try:
            server.serve_forever(0.2)
        except KeyboardInterrupt:
            pass
    return 0


def open_page(arguments: argparse.Namespace, address: str) -> None:
    """Open a browser where there is a screen and the user wants one."""
    if not arguments.no_browser and has_screen():
        import webbrowser

        webbrowser.open(address)


def has_screen() -> bool:
    """False where a browser would open in this terminal."""
    if sys.platform in ("darwin", "win32"):
        return True
    return any(os.environ.get(name) for name in ("DISPLAY", "WAYLAND_DISPLAY", "BROWSER"))


def page_file(arguments: argparse.Namespace) -> Path:
    """The file that `--html` names; raises UsageError for one that cannot be a page."""
    output = Path(arguments.html)
    if output.suffix.lower() not in (".html", ".htm"):
        raise UsageError("file", f"a page is an .html file, not {output.name}")
    check_folder(output)
    return output


def write_page(text: str, output: Path) -> None:
    from scenelang.backends.files import written_whole

    with written_whole(output) as temporary:
        temporary.write_text(text, encoding="utf-8")


def save(arguments: argparse.Namespace, workspace: Workspace) -> int:
    """Write the page with all files' scenes; nothing is written when one of them has a mistake."""
    from scenelang.backends.viewer.page import SavedScene, self_contained
    from scenelang.viewer.workspace import state_data

    output = page_file(arguments)
    scenes = []
    for number, name in enumerate(workspace.files):
        state = workspace.state(number)
        report(arguments, state.diagnostics)
        if state.packet is None or not state.ok:
            return 1
        scenes.append(SavedScene(name, state_data(name, state, is_live=False), state.packet))
    write_page(self_contained(scenes), output)
    done(arguments, output)
    return 0


COMMANDS = (add_view,)
