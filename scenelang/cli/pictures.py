"""Commands that make files from scenes: render, export, backends."""

from __future__ import annotations

import argparse
import re
from pathlib import Path
from typing import Any

from scenelang.cli.options import add_common, add_file, add_output, usage_errors
from scenelang.cli.output import print_json, progress, table
from scenelang.cli.programs import evaluated, session_limit
from scenelang.grammar.diagnostics import SceneError


def _size(text: str) -> tuple[int, int]:
    match = re.fullmatch(r"(\d+)x(\d+)", text)
    if match is None or not (1 <= int(match[1]) <= 16384 and 1 <= int(match[2]) <= 16384):
        raise argparse.ArgumentTypeError(f"`{text}` is no size; write WIDTHxHEIGHT, such as 800x600")
    return int(match[1]), int(match[2])


def add_render(subparsers: Any) -> None:
    parser = subparsers.add_parser("render", help="draw a picture of the scene")
    add_file(parser)
    parser.add_argument("-o", "--output", metavar="OUT.png", required=True, help="the picture to write")
    parser.add_argument("--size", type=_size, default=(512, 512), metavar="WxH", help="pixels (default 512x512)")
    parser.add_argument(
        "--camera",
        metavar="KEY=VALUE,...",
        help="azimuth, elevation and fov in degrees, distance, target=x:y:z; what is left out frames the scene",
    )
    parser.add_argument("--quality", choices=("draft", "final"), default="draft", help="final is path traced")
    parser.add_argument("--frame", type=int, default=0, metavar="N", help="frame of a 4D scene (default 0)")
    parser.add_argument("--samples", type=int, metavar="N", help="samples per pixel of final quality")
    add_common(parser)
    parser.set_defaults(run=render)


def render(arguments: argparse.Namespace) -> int:
    from scenelang.backends.base import Work, for_file
    from scenelang.backends.camera import parse_camera

    output = Path(arguments.output)
    with usage_errors():  # before the work, so that typos are cheap
        camera = parse_camera(arguments.camera) if arguments.camera else None
        for_file(output, Work.PICTURE)
    _check_folder(output)
    result = evaluated(arguments)
    if result.scene is None:
        return 1
    from scenelang.backends.picture import PictureOptions, render, save_picture

    chosen: dict[str, Any] = {"camera": camera} if camera is not None else {}
    if arguments.samples is not None:
        chosen["samples"] = arguments.samples
    width, height = arguments.size
    options = PictureOptions(
        frame=arguments.frame,
        limit=session_limit(arguments),
        progress=progress(arguments, "rendering"),
        width=width,
        height=height,
        quality=arguments.quality,
        seed=arguments.seed,
        **chosen,
    )
    save_picture(render(result.scene, options), output)
    _done(arguments, output)
    return 0


def add_export(subparsers: Any) -> None:
    parser = subparsers.add_parser("export", help="write the scene as a file for other programs")
    add_file(parser)
    parser.add_argument("-o", "--output", metavar="OUT.glb", required=True, help="the file to write")
    parser.add_argument("--backend", metavar="NAME", help="the backend (default: by file ending)")
    parser.add_argument("--frame", type=int, default=0, metavar="N", help="frame of a 4D scene (default 0)")
    add_common(parser)
    parser.set_defaults(run=export)


def export(arguments: argparse.Namespace) -> int:
    from scenelang.backends import base

    output = Path(arguments.output)
    with usage_errors():
        backend = base.find(arguments.backend) if arguments.backend else base.for_file(output)
    _check_folder(output)
    result = evaluated(arguments)
    if result.scene is None:
        return 1
    options = base.Options(
        frame=arguments.frame, limit=session_limit(arguments), progress=progress(arguments, "exporting")
    )
    backend.run(result.scene, output, options)
    _done(arguments, output)
    return 0


def add_backends(subparsers: Any) -> None:
    parser = subparsers.add_parser("backends", help="list what scenes can be turned into")
    add_output(parser)
    parser.set_defaults(run=backends)


def backends(arguments: argparse.Namespace) -> int:
    from scenelang.backends import base

    found = base.every()
    if arguments.json:
        print_json(
            [{"name": b.name, "doc": b.doc, "endings": list(b.endings), "installed": b.is_installed} for b in found]
        )
        return 0
    rows = [
        (b.name, " ".join(b.endings), "yes" if b.is_installed else f"pip install {b.install}", b.doc) for b in found
    ]
    print(table([("backend", "writes", "installed", ""), *rows], (False, False, False, False)))
    return 0


def _check_folder(output: Path) -> None:
    if not output.parent.is_dir():
        raise SceneError("file", f"cannot write {output}: there is no folder {output.parent}")


def _done(arguments: argparse.Namespace, output: Path) -> None:
    if not arguments.quiet:
        print(f"wrote {output}")


COMMANDS = (add_render, add_export, add_backends)
