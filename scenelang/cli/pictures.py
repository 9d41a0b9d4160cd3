"""Commands that make files from scenes: render, export, backends."""

from __future__ import annotations

import argparse
import re
from pathlib import Path
from typing import TYPE_CHECKING, Any

from scenelang.cli.options import add_common, add_file, add_output, usage_errors, whole
from scenelang.cli.output import print_json, progress, say, table, warnings
from scenelang.cli.programs import evaluated, session_limit
from scenelang.grammar.diagnostics import SceneError

if TYPE_CHECKING:
    from scenelang.backends.pictures.film import PictureBackend, PictureOptions
    from scenelang.interpreter.scene.entity import Scene

_SIZE = (512, 512)


def picture_size(text: str) -> tuple[int, int]:
    """``WIDTHxHEIGHT`` in pixels."""
    match = re.fullmatch(r"(\d+)x(\d+)", text)
    if match is None or not (1 <= int(match[1]) <= 16384 and 1 <= int(match[2]) <= 16384):
        raise argparse.ArgumentTypeError(f"`{text}` is no size; write WIDTHxHEIGHT, such as 800x600")
    return int(match[1]), int(match[2])


# --- render --------------------------------------------------------------------------------------------------------


def add_render(subparsers: Any) -> None:
    parser = subparsers.add_parser("render", help="draw a picture or a film of the scene")
    add_file(parser)
    parser.add_argument("-o", "--output", metavar="OUT", required=True, help=".png .jpg .webp .exr .gif .apng .mp4")
    parser.add_argument("--quality", choices=("draft", "final"), default="draft", help="final is path traced")
    parser.add_argument("--backend", metavar="NAME,...", help="backends that draw, side by side, instead of a quality")
    parser.add_argument("--frame", type=whole, metavar="N", help="a picture of this frame of a 4D scene, from 0")
    add_view(parser)
    parser.add_argument("--no-labels", action="store_true", help="no words on the boxes of semantic primitives")
    films = parser.add_argument_group("films")
    films.add_argument("--frames", type=whole, metavar="N", help="pictures of a film (default: the scene's, or 48)")
    films.add_argument("--fps", type=float, metavar="X", help="pictures per second (default 24)")
    films.add_argument("--orbit", type=float, metavar="DEGREES", help="how far the camera goes round the scene")
    add_picture_options_later(parser)
    add_common(parser)
    parser.set_defaults(run=render)


def add_view(parser: argparse.ArgumentParser, several: bool = False) -> None:
    """What tells where pictures are taken from, by one camera or ``several``, and in what light."""
    group = parser.add_argument_group("view")
    add_camera(group, "pixels (default 512x512)", several)
    names = "studio, overcast, sunny, sunset, night, flat"
    group.add_argument("--environment", default="studio", metavar="NAME", help=f"the light: {names}")
    group.add_argument("--ground", metavar="NAME", help="seamless, none, white, dark, meadow, earth, checker")


def add_camera(group: Any, size_help: str, several: bool = False) -> None:
    """How large pictures are, and where they are taken from: by one camera or ``several``."""
    group.add_argument("--size", type=picture_size, metavar="WxH", help=size_help)
    group.add_argument(
        "--camera",
        metavar="VIEW",
        action="append" if several else "store",
        help="turntable, top, isometric, follow; azimuth=40,elevation=20,distance=5,fov=35,target=0:1:0,aperture=.1,"
        "focus=4; or a camera's JSON file; what is left out frames the scene",
    )


def add_picture_options_later(parser: argparse.ArgumentParser) -> None:
    """The options of the backends that draw."""
    from scenelang.cli.backend_options import add_later

    def add(to: argparse.ArgumentParser) -> None:
        from scenelang.backends.base import Work
        from scenelang.cli.backend_options import add_backend_options

        add_backend_options(to, Work.PICTURE)

    add_later(parser, add)


def render(arguments: argparse.Namespace) -> int:
    from scenelang.backends.pictures.film import check, picture_backend

    output = Path(arguments.output)
    with usage_errors():  # before the work, so that typos are cheap
        chosen = arguments.backend.split(",") if arguments.backend else [arguments.quality]
        backends = [picture_backend(name.strip()) for name in chosen]
        options = picture_options(arguments)
        check(options, backends)
        _check_ending(output, arguments, len(backends))
    check_folder(output)
    result = evaluated(arguments)
    if result.scene is None:
        return 1
    _draw(result.scene, output, backends, options, arguments)
    done(arguments, output)
    return 0


def picture_options(arguments: argparse.Namespace) -> PictureOptions:
    """What the options of a command that draws ask for; raises SceneError."""
    from scenelang.backends.pictures.camera import Camera, Viewpoint, parse_viewpoint
    from scenelang.backends.pictures.film import PictureOptions
    from scenelang.cli.backend_options import settings_of

    camera = parse_viewpoint(arguments.camera) if arguments.camera else Viewpoint()
    own = (camera.width, camera.height) if isinstance(camera, Camera) else _SIZE
    width, height = arguments.size or own
    return PictureOptions(
        frame=arguments.frame,
        limit=session_limit(arguments),
        progress=progress(arguments, "rendering"),
        settings=settings_of(arguments),
        warn=warnings(arguments),
        width=width,
        height=height,
        camera=camera,
        environment=arguments.environment,
        ground=arguments.ground,
        seed=arguments.seed,
        labels=not getattr(arguments, "no_labels", False),
    )


def _wants_film(arguments: argparse.Namespace) -> bool:
    return any(value is not None for value in (arguments.frames, arguments.fps, arguments.orbit))


def _check_ending(output: Path, arguments: argparse.Namespace, backends: int) -> None:
    """Raises SceneError for a file that no picture or film can be written to."""
    from scenelang.backends.pictures.film import ENDINGS, FPS, STILL_ENDINGS, check_film, is_film

    ending = output.suffix.lower()
    known = sorted({*STILL_ENDINGS, *ENDINGS})
    if ending not in known:
        shown = f"`{ending}` files" if ending else "a file without an ending"
        raise SceneError("backend", f"no backend writes {shown}", hint=f"it can be one of {' '.join(known)}")
    if is_film(output, _wants_film(arguments)):
        if arguments.frame is not None:
            raise SceneError("value", "`--frame` asks for one picture, but a film is to be written")
        check_film(output, FPS if arguments.fps is None else arguments.fps)
    elif _wants_film(arguments):
        hint = f"write {' '.join(ENDINGS)}, or leave out --frames, --fps and --orbit"
        raise SceneError("value", f"`{output.name}` is one picture, but a film is asked for", hint=hint)
    elif ending == ".exr" and backends > 1:
        raise SceneError("value", "an .exr file holds what one backend draws")


def _draw(
    scene: Scene, output: Path, backends: list[PictureBackend], options: PictureOptions, arguments: argparse.Namespace
) -> None:
    from scenelang.backends.base import part_of
    from scenelang.backends.pictures.film import (
        FPS,
        is_film,
        painters,
        save_film,
        save_image,
        save_picture,
        side_by_side,
    )
    from scenelang.backends.pictures.stage import film, still

    wanted = _wants_film(arguments) or (scene.animated and arguments.frame is None and output.suffix.lower() == ".webp")
    if is_film(output, wanted):
        shots = film(scene, options.camera, options.width, options.height, arguments.frames, arguments.orbit)
        fps = FPS if arguments.fps is None else arguments.fps
        save_film(painters(scene, options, backends, shots), shots, output, fps, options.progress)
        return
    shot = still(scene, options.camera, options.frame, options.width, options.height)
    count = len(backends)
    images = [
        painter.paint(shot, part_of(options.progress, i / count, (i + 1) / count))
        for i, painter in enumerate(painters(scene, options, backends, [shot]))
    ]
    if count == 1:
        save_image(images[0], output)
    else:
        save_picture(side_by_side([image.picture for image in images]), output)


# --- export --------------------------------------------------------------------------------------------------------


def add_export(subparsers: Any) -> None:
    from scenelang.cli.backend_options import add_later

    parser = subparsers.add_parser("export", help="write the scene as a file for other programs")
    add_file(parser)
    parser.add_argument("-o", "--output", metavar="OUT", required=True, help="the file to write, such as OUT.glb")
    parser.add_argument("--backend", metavar="NAME", help="the backend (default: by file ending)")
    parser.add_argument("--frame", type=whole, metavar="N", help="only this frame of a 4D scene, from 0")
    add_later(parser, _add_export_options)
    add_common(parser)
    parser.set_defaults(run=export)


def _add_export_options(parser: argparse.ArgumentParser) -> None:
    from scenelang.backends.base import Work
    from scenelang.cli.backend_options import add_backend_options

    add_backend_options(parser, Work.EXPORT)


def export(arguments: argparse.Namespace) -> int:
    from scenelang.backends import base
    from scenelang.cli.backend_options import settings_of

    output = Path(arguments.output)
    with usage_errors():
        backend = base.find(arguments.backend) if arguments.backend else base.for_file(output, base.Work.EXPORT)
        options = base.BackendOptions(
            arguments.frame,
            session_limit(arguments),
            progress(arguments, "exporting"),
            settings_of(arguments),
            warnings(arguments),
        )
        base.check_settings(options, [backend])
    check_folder(output)
    result = evaluated(arguments)
    if result.scene is None:
        return 1
    written = backend.run(result.scene, output, options) or [output]
    done(arguments, *written)
    return 0


# --- backends ------------------------------------------------------------------------------------------------------


def add_backends(subparsers: Any) -> None:
    parser = subparsers.add_parser("backends", help="list what scenes can be turned into")
    add_output(parser)
    parser.set_defaults(run=backends)


def backends(arguments: argparse.Namespace) -> int:
    from scenelang.backends import base

    found = base.every()
    if arguments.json:
        print_json([_facts(backend) for backend in found])
        return 0
    rows = [
        (b.name, b.work.value, " ".join(b.endings), "yes" if b.is_installed else f"pip install {b.install}", b.doc)
        for b in found
    ]
    say(table([("backend", "command", "writes", "installed", ""), *rows], (False,) * 5))
    if arguments.verbose:
        for backend in found:
            for option in backend.options:
                say(f"{backend.name} --{option.name}: {option.doc}")
    return 0


def _facts(backend: Any) -> dict[str, Any]:
    """What `backends --json` says of a backend."""
    accepts = backend.accepts
    return {
        "name": backend.name,
        "doc": backend.doc,
        "command": backend.work.value,
        "endings": list(backend.endings),
        "installed": backend.is_installed,
        "install": backend.install,
        "accepts": {
            "words": list(accepts.primitives()),
            "any_word": accepts.any_word,
            "attributes": list(accepts.attributes),
            "animated": accepts.animated,
        },
        "options": [
            {"name": option.name, "doc": option.doc, "default": option.default, "choices": list(option.choices)}
            for option in backend.options
        ],
    }


def check_folder(output: Path) -> None:
    """Raises SceneError where ``output`` cannot be a file: before the work, so that typos are cheap."""
    if not output.parent.is_dir():
        raise SceneError("file", f"cannot write {output}: there is no folder {output.parent}")
    if output.is_dir():
        raise SceneError("file", f"cannot write {output}: it is a folder")


def done(arguments: argparse.Namespace, *written: Path) -> None:
    """Say what was written."""
    if not arguments.quiet:
        for output in written:
            say(f"wrote {output}")


COMMANDS = (add_render, add_export, add_backends)
