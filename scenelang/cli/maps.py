"""The command maps: labelled pictures of one or several scenes."""

from __future__ import annotations

import argparse
import hashlib
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from scenelang.cli.options import add_common, session_of, usage_errors, whole
from scenelang.cli.output import progress, report_run
from scenelang.cli.pictures import add_picture_options_later, add_view, done, picture_options
from scenelang.grammar.diagnostics import SceneError

if TYPE_CHECKING:
    from scenelang.backends.labels.dataset import DatasetItem, MapOptions
    from scenelang.backends.pictures.camera import Camera, Viewpoint

_MOST_VIEWS = 10_000


def add_maps(subparsers: Any) -> None:
    parser = subparsers.add_parser("maps", help="write labelled pictures: words, depth, boxes, motion")
    parser.add_argument("files", metavar="FILE", nargs="+", help="programs, `-` for standard input")
    parser.add_argument("-o", "--output", metavar="DIR", required=True, help="the folder to write to")
    parser.add_argument("--quality", choices=("draft", "final"), default="draft", help="of the colour pictures")
    parser.add_argument("--frame", type=whole, metavar="N", help="only this frame of a 4D scene, from 0")
    parser.add_argument("--views", type=whole, metavar="N", help="so many random cameras, by the seed")
    parser.add_argument("--tracks", type=whole, default=64, metavar="N", help="tracked points of 4D scenes (64)")
    parser.add_argument(
        "--annotations", type=whole, default=20_000, metavar="N", help="instances of a picture in coco.json (20,000)"
    )
    add_view(parser, several=True)
    add_picture_options_later(parser)
    add_common(parser)
    parser.set_defaults(run=maps, file="-")


def maps(arguments: argparse.Namespace) -> int:
    from scenelang.backends.labels.dataset import MapOptions, write_coco
    from scenelang.backends.pictures.film import check, picture_backend

    with usage_errors():
        backend = picture_backend(arguments.quality)
        cameras, arguments.camera = arguments.camera or [""], None
        options = picture_options(arguments)
        check(options, [backend])
        views = _views(arguments, cameras)
        names = _names(arguments.files)
    settings = MapOptions(options, views, arguments.size is not None, arguments.tracks, arguments.annotations)
    folder = Path(arguments.output)
    _check(folder)
    items: list[DatasetItem] = []
    failed = False
    for path, name in zip(arguments.files, names, strict=True):
        arguments.file = path
        made = _one(arguments, name, folder, settings)
        items += made or []
        failed = failed or made is None
    if items:
        write_coco(folder, items)
        done(arguments, folder)
    return 1 if failed else 0


def _one(arguments: argparse.Namespace, name: str, folder: Path, options: MapOptions) -> list[DatasetItem] | None:
    """The maps of one program, None where it is wrong."""
    from dataclasses import replace

    from scenelang.backends.base import frame_of
    from scenelang.backends.labels.dataset import items_of, write_maps
    from scenelang.backends.pictures.film import picture_backend

    session = session_of(arguments)
    source = session.source(arguments.file)
    result = session.evaluate(source)
    report_run(arguments, result)
    if result.scene is None:
        return None
    texts = [source.text, *(s.text for s in result.program.sources)] if result.program is not None else [source.text]
    told = "\0".join([*texts, repr(arguments.define), str(arguments.root), str(arguments.seed), str(arguments.z)])
    options = replace(options, digest=hashlib.sha256(told.encode("utf-8", "surrogatepass")).hexdigest())
    if arguments.frame is not None:
        frame_of(result.scene, arguments.frame)
    alone = len(arguments.files) == 1
    items = items_of(folder, name, result.scene, len(options.views), alone, arguments.frame)

    def skipped(item: DatasetItem) -> None:
        if not arguments.quiet:
            print(f"{item.folder} is there already", file=sys.stderr)

    backend = picture_backend(arguments.quality)
    write_maps(result.scene, items, options, backend, progress(arguments, name), skipped)
    return items


def _views(arguments: argparse.Namespace, cameras: list[str]) -> tuple[Viewpoint | Camera, ...]:
    from scenelang.backends.labels.dataset import random_views
    from scenelang.backends.pictures.camera import Camera, parse_viewpoint

    given = [parse_viewpoint(text) for text in cameras]
    if arguments.views is None:
        return tuple(given)
    if not 1 <= arguments.views <= _MOST_VIEWS:
        raise SceneError("value", f"`--views` must be 1 to {_MOST_VIEWS:,}, not {arguments.views}")
    if len(given) > 1 or isinstance(given[0], Camera):
        raise SceneError("value", "`--views` draws cameras at random: name one viewpoint that they share, or none")
    return random_views(arguments.views, arguments.seed, given[0])


def _names(files: list[str]) -> list[str]:
    """A name for each file, all different."""
    names: list[str] = []
    for path in files:
        stem = Path(path).stem if path != "-" else "scene"
        name, number = stem, 2
        while name in names:
            name, number = f"{stem}-{number}", number + 1
        names.append(name)
    return names


def _check(folder: Path) -> None:
    """Raises SceneError where ``folder`` can never be one; it is made when there is something to write."""
    existing = next(path for path in (folder, *folder.absolute().parents) if path.exists())
    if not existing.is_dir():
        raise SceneError("file", f"cannot write to {folder}: {existing} is no folder")


COMMANDS = (add_maps,)
