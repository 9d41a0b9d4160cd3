"""Commands that render and view scenes: render, labels, dataset, graph, view."""

from __future__ import annotations

import argparse
import copy
import socket
import sys
import tempfile
import threading
import zlib
from collections.abc import Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

from scenelang.backends import base
from scenelang.backends.files import output_path
from scenelang.backends.pictures import film
from scenelang.backends.pictures.camera import Camera, Viewpoint, parse_viewpoint
from scenelang.backends.pictures.declared import view_of
from scenelang.backends.pictures.figures import Figure
from scenelang.backends.pictures.surroundings import settled
from scenelang.cli.options import (
    UsageError,
    add_backend_options,
    add_camera,
    add_fields,
    backend_settings_of,
    check_folder,
    done,
    fields_of,
    given,
    naming_other_commands,
    opened,
    print_result,
    progress,
    reader,
    report,
    scene_of,
    session_limit,
    session_of,
    usage_errors,
    whole,
)
from scenelang.cli.options import warnings as warnings_of
from scenelang.console.reports import deliver
from scenelang.grammar.datum import replace
from scenelang.grammar.settings import part_of_one, port

if TYPE_CHECKING:
    from scenelang.backends.labels.dataset import DatasetItem, LabeledScene
    from scenelang.backends.pictures.sheets import SheetOptions
    from scenelang.backends.viewer.packet import SplatsOf
    from scenelang.interpreter.scene.entity import Scene
    from scenelang.session.loaded import LoadedScene
    from scenelang.session.session import Session
    from scenelang.viewer.workspace import Evaluate, OpenSession, Workspace

_SIZE = (512, 512)  # pixels


# --- options of pictures and backends --------------------------------------------------------------------------------


def _add_view(
    parser: argparse.ArgumentParser,
    *,
    several: bool = False,
    size: str = "pixels (default 512x512, or that of the program)",
) -> None:
    """Add the options for cameras (``several`` allows repeats), the ``size`` of images, and lighting."""
    group = parser.add_argument_group("view")
    add_camera(group, size, several)
    add_fields(group, film.PictureOptions, ("environment", "ground", "exposure", "tone"))


def _add_quality(parser: argparse.ArgumentParser, what: str) -> None:
    """Add the option for a quality preset."""
    summaries = "; ".join(f"{quality.name}: {quality.doc}" for quality in film.QUALITIES.all())
    what = f"{what} (default draft, or that of the program; {summaries})"
    parser.add_argument("--quality", choices=film.QUALITIES.names(), help=what)


def _picture_options(arguments: argparse.Namespace, camera: str | None) -> film.PictureOptions:
    """Return the rendering options of a command; raises SceneError for an invalid camera."""
    view = view_of(camera)
    size = arguments.size or ((view.width, view.height) if isinstance(view, Camera) else None)
    width, height = size or _SIZE
    stated = (*given(arguments, film.PictureOptions), *(("size",) if size else ()))
    return fields_of(
        arguments, film.PictureOptions, limit=session_limit(arguments), progress=progress(arguments, "rendering"),
        settings=backend_settings_of(arguments), warn=warnings_of(arguments), width=width, height=height, camera=view,
        seed=arguments.seed, stated=stated, figure=fields_of(arguments, Figure),
    )  # fmt: skip


def _backend_of(arguments: argparse.Namespace, scene: Scene, options: film.PictureOptions) -> film.PictureBackend:
    """Return the backend of the quality of a command, else of the program; raises SceneError if it lacks an option."""
    stated = None if arguments.quality else film.declared_backend(scene)
    backend = stated or film.picture_backend(arguments.quality or "draft")
    film.check(options, [backend])
    return backend


# --- render ----------------------------------------------------------------------------------------------------------


def add_render(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``render``."""
    output = ".png .jpg .webp .exr .gif .apng .mp4 (default: FILE.png; FILE.gif with --frames or --orbit)"
    parser.add_argument("-o", "--output", metavar="OUT", help=output)
    _add_quality(parser, "of the picture")
    parser.add_argument("--backend", metavar="NAME,...", help="render with these backends side by side")
    add_fields(parser, film.PictureOptions, ("frame",), frame="frame of a 4D scene to render, counted from 0")
    parser.add_argument("--part", metavar="PATH", help="render only these instances, such as `chair/leg[2]`")
    _add_view(parser)
    add_fields(parser, film.PictureOptions, ("background", "labels", "shutter"))
    add_fields(parser.add_argument_group("publication figures"), Figure)
    add_fields(parser.add_argument_group("video"), film.FilmOptions)
    add_backend_options(parser, base.Work.PICTURE)


def run_render(arguments: argparse.Namespace) -> int:
    """Render an image or a video."""
    with naming_other_commands("render", arguments), usage_errors():  # fail early, before the expensive work
        shots = fields_of(arguments, film.FilmOptions)
        output = output_path(
            arguments.file, arguments.output, ".gif" if shots.is_wanted else ".png", film.wrote_picture
        )
        names = arguments.backend.split(",") if arguments.backend else [arguments.quality or "draft"]
        backends = [film.picture_backend(name.strip()) for name in names]
        options = _picture_options(arguments, arguments.camera)
        film.check(options, backends)
        film.check_output(output, options.frame, shots, len(backends))
        film.check_alpha(options, output, film.is_film(output, shots.is_wanted))
    check_folder(output)
    scene = scene_of(arguments)
    scene = scene if arguments.part is None else scene.part(arguments.part)
    if arguments.part is not None and arguments.camera is None:  # a part fills the image, whatever the program's camera
        options = replace(options, camera=Viewpoint())
    if arguments.backend is None:
        backends = [_backend_of(arguments, scene.graph, options)]
    film.write_drawing(scene.graph, output, options, shots, backends)
    done(arguments, output)
    return 0


# --- sheet -----------------------------------------------------------------------------------------------------------


def add_sheet(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``sheet``."""
    from scenelang.backends.pictures.sheets import CELL, SheetOptions
    from scenelang.session.scene_changes import TOLERANCE

    parser.add_argument("files", metavar="FILE", nargs="+", help="program; several get a cell each")
    parser.add_argument("-o", "--output", metavar="OUT", required=True, help="image: .png .jpg .webp")
    add_fields(parser, SheetOptions)
    parser.add_argument("--compare", action="store_true", help="two programs side by side, with what differs in color")
    parser.add_argument(
        "--tolerance", type=reader(part_of_one), default=TOLERANCE, metavar="T",
        help="relative tolerance of `--compare`, as a fraction of the scene's size (default 1e-5)",
    )  # fmt: skip
    _add_quality(parser, "of the images")
    add_fields(parser, film.PictureOptions, ("frame",), frame="frame of 4D scenes to draw, counted from 0")
    _add_view(parser, size=f"pixels of a cell (default {CELL[0]}x{CELL[1]})")
    add_fields(parser, film.PictureOptions, ("background", "labels"))
    add_fields(parser.add_argument_group("publication figures"), Figure)
    add_backend_options(parser, base.Work.PICTURE)


def run_sheet(arguments: argparse.Namespace) -> int:
    """Draw a contact sheet, or a comparison of two programs."""
    from scenelang.backends.pictures import sheets

    arguments.size = arguments.size or (None if (arguments.camera or "").endswith(".json") else sheets.CELL)
    output = Path(arguments.output)
    with usage_errors():  # fail early, before the expensive work
        wanted = fields_of(arguments, sheets.SheetOptions)
        sheets.check_wanted(wanted, len(arguments.files), is_comparison=arguments.compare)
        film.check_still(output)
        backend = film.picture_backend(arguments.quality or "draft")
        options = _picture_options(arguments, arguments.camera)
        sheets.check_sheet(options, backend)
        if arguments.files.count("-") > 1:
            raise UsageError("file", "only one of the inputs can be standard input")
    check_folder(output)
    named = [(name, scene.graph) for name, scene in _sheet_scenes(arguments, wanted)]
    backend = _backend_of(arguments, named[0][1], options)
    options = settled(named[0][1], options)
    if arguments.compare:
        sheet: sheets.Sheet = sheets.compared(named, options, backend, arguments.tolerance)
    elif len(named) == 1 and wanted.vary is None and wanted.seeds is None:
        sheet = sheets.sheet_of(sheets.cells_of(named[0][1], wanted, options), options, backend, wanted.columns)
    else:
        cells = sheets.cells_of_scenes(named, options, to_scale=len(arguments.files) == 1)
        sheet = sheets.sheet_of(cells, options, backend, wanted.columns)
    sheet.save(output)
    done(arguments, output)
    return 0


def _sheet_scenes(arguments: argparse.Namespace, wanted: SheetOptions) -> Iterator[tuple[str, LoadedScene]]:
    """Yield the scenes of a sheet with their captions: of the files, of values of a param, or of seeds."""
    from scenelang.backends.pictures.sheets import values_in

    if wanted.vary is None and wanted.seeds is None:
        for path in arguments.files:
            arguments.file = path
            yield Path(path).stem, scene_of(arguments)
        return
    (arguments.file,), given_defines = arguments.files, list(arguments.define)
    if arguments.file == "-":
        raise UsageError("file", "a sheet evaluates the program several times and cannot read standard input")
    if wanted.vary is not None:
        name, values = values_in(wanted.vary)
        for value in values:
            arguments.define = [*given_defines, f"{name}={value}"]
            yield f"{name} = {value}", scene_of(arguments)
    for seed in range(wanted.seeds or 0):
        arguments.seed = seed
        yield f"seed {seed}", scene_of(arguments)


# --- labels ----------------------------------------------------------------------------------------------------------


def add_labels(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``labels``."""
    from scenelang.backends.labels.dataset import MapOptions

    parser.add_argument("files", metavar="FILE", nargs="+", help="programs, or `-` for standard input")
    parser.add_argument("-o", "--output", metavar="DIR", required=True, help="output folder")
    _add_quality(parser, "quality of the color images")
    add_fields(parser, base.BackendOptions, ("frame",))
    parser.add_argument("--views", type=whole, metavar="N", help="number of random cameras")
    add_fields(parser, MapOptions)
    _add_view(parser, several=True)
    add_backend_options(parser, base.Work.PICTURE)


def run_labels(arguments: argparse.Namespace) -> int:
    """Render labeled images of scenes; exit code 1 if a program has errors."""
    from scenelang.backends.labels.dataset import MapOptions, check_set_folder, write_set
    from scenelang.backends.pictures.viewpoints import views_of

    with usage_errors():
        options = _picture_options(arguments, None)
        film.check(options, [film.picture_backend(arguments.quality or "draft")])
        film.check_opaque(options)
        read = view_of if arguments.views is None else parse_viewpoint
        views = views_of([read(text) for text in arguments.camera or [""]], arguments.views, arguments.seed)
    settings = fields_of(arguments, MapOptions, pictures=options, views=views, resize=arguments.size is not None)
    folder = Path(arguments.output)
    check_set_folder(folder)
    failed: list[str] = []

    def skipped(item: DatasetItem) -> None:
        """Report a scene that is in the output folder already."""
        if not arguments.quiet:
            print(f"{item.folder} already exists; skipped", file=sys.stderr)

    items = write_set(
        _labeled(arguments, failed), folder, settings, lambda scene: _backend_of(arguments, scene, options),
        alone=len(arguments.files) == 1, frame=arguments.frame, progress=lambda name: progress(arguments, name),
        skipped=skipped,
    )  # fmt: skip
    if items:
        done(arguments, folder)
    return 1 if failed else 0


def _labeled(arguments: argparse.Namespace, failed: list[str]) -> Iterator[LabeledScene]:
    """Yield the scenes of the files in order; report those with errors and add them to ``failed``."""
    from scenelang.backends.labels.dataset import LabeledScene, names_of

    for path, name in zip(arguments.files, names_of(arguments.files), strict=True):
        arguments.file = path
        result, source, _ = opened(arguments)
        if result.scene is None:
            failed.append(path)
            continue
        texts = [source.text, *(s.text for s in result.program.sources)] if result.program else [source.text]
        ways = (repr(arguments.define), str(arguments.root), str(arguments.seed), str(arguments.z))
        yield LabeledScene(name, result.scene, (*texts, *ways))


# --- datasets --------------------------------------------------------------------------------------------------------


def add_dataset(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``dataset``."""
    from scenelang.datasets.running import DatasetSettings

    usage = "spec in TOML; or `status DIR`, `verify DIR`, `merge DIR...`, `sample SPEC KEY`"
    parser.add_argument("words", metavar="SPEC", nargs="+", help=usage)
    parser.add_argument("-o", "--output", metavar="OUT", help="folder, or an address such as s3://bucket/set")
    add_fields(parser, DatasetSettings)
    preview = "only show the first samples with their labels on a contact sheet (default: preview.png)"
    parser.add_argument("--preview", metavar="OUT.png", nargs="?", const="preview.png", help=preview)
    parser.add_argument("--shown", type=whole, default=12, metavar="N", help="samples of a preview (default 12)")


def run_dataset(arguments: argparse.Namespace) -> int:
    """Make, verify, merge or inspect a dataset."""
    from scenelang.datasets import running

    verb, *words = arguments.words if arguments.words[0] in _VERBS else ["make", *arguments.words]
    least, most, needs_output = _VERBS[verb]
    if arguments.preview and arguments.output:
        raise UsageError("value", "`--preview` writes a contact sheet only and cannot be combined with `-o`")
    if not least <= len(words) <= most or (needs_output and not (arguments.output or arguments.preview)):
        usage = {"make": "dataset SPEC", "merge": "dataset merge DIR...", "sample": "dataset sample SPEC KEY"}
        raise UsageError("value", f"expected `{usage.get(verb, f'dataset {verb} DIR')}{' -o OUT' * needs_output}`")
    if verb == "verify":
        problems = running.verify_dataset(words[0], progress(arguments, "verifying"))
        report(arguments, problems)
        return 1 if problems else print_result(arguments, [], f"{words[0]} is complete and sound")
    if verb == "sample":
        done(arguments, *running.write_sample(words[0], words[1], arguments.output, arguments.count))
        return 0
    if verb == "make" and arguments.preview:
        from scenelang.datasets.describing import preview_dataset

        sheet = preview_dataset(words[0], arguments.preview, arguments.shown)
        report(arguments, sheet.failures)
        return print_result(arguments, sheet.data(), sheet)
    if verb == "make":
        shown = None if progress(arguments, "") is None else running.progress_text(sys.stderr)
        settings = given(arguments, running.DatasetSettings)
        try:
            result = running.dataset(words[0], arguments.output, progress=shown, **settings)
        except KeyboardInterrupt:
            print("what is finished is kept; `--resume` goes on", file=sys.stderr)
            raise
    else:
        result = (
            running.merge_datasets(words, arguments.output) if verb == "merge" else running.dataset_status(words[0])
        )
    report(arguments, result.warnings)
    failed = result.has_nothing and verb == "make"
    if failed:
        print(result.failed[0]["text"], file=sys.stderr)
    return print_result(arguments, result.data(), result) or int(failed)


# Least and most words of each form of `dataset`, and whether it writes.
_VERBS = {"make": (1, 1, True), "status": (1, 1, False), "verify": (1, 1, False), "merge": (1, 10_000, True),
          "sample": (2, 2, True)}  # fmt: skip


# --- graph -----------------------------------------------------------------------------------------------------------


def add_graph(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``graph``."""
    parser.add_argument("-o", "--output", metavar="OUT.svg", required=True, help="output file")
    parser.add_argument("--depth", type=whole, metavar="N", help="maximum depth below the root")
    parser.add_argument("--frame", type=whole, metavar="N", help="frame of a 4D scene (default 0)")
    parser.add_argument("--thumbnails", action="store_true", help="render a thumbnail of every node")


def run_graph(arguments: argparse.Namespace) -> int:
    """Write the call graph of a scene as SVG."""
    from scenelang.backends.pictures.call_graph import write_graph

    output = Path(arguments.output)
    if output.suffix.lower() != ".svg":
        raise UsageError("backend", f"cannot write a graph to `{output.name}`", "use .svg")
    check_folder(output)
    scene = scene_of(arguments)
    write_graph(scene.graph, output, arguments.frame, arguments.depth, arguments.thumbnails)
    done(arguments, output)
    return 0


# --- view ------------------------------------------------------------------------------------------------------------


def add_view(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``view``."""
    parser.add_argument("files", metavar="FILE", nargs="+", help="programs; the view reloads when they change")
    parser.add_argument(
        "--html", metavar="OUT.html", help="write a self-contained HTML page instead of starting a server"
    )
    parser.add_argument("--minecraft", action="store_true", help="show a Minecraft build with the game's block models")
    parser.add_argument("--textures", metavar="PATH", help="resource pack or game file (default: the installed game)")
    parser.add_argument("--splats", action="store_true", help="show Gaussian splats instead of solids")
    parser.add_argument("--distilled", metavar="DIR", help="show the Gaussians of a `distill` run")
    parser.add_argument("--port", type=reader(port), default=0, metavar="N", help="port (default: any free port)")
    parser.add_argument("--no-browser", action="store_true", help="do not open a browser")


def run_view(arguments: argparse.Namespace) -> int:
    """Show programs in a browser, or write a page."""
    if "-" in arguments.files:
        raise UsageError("file", "`view` watches files and cannot read standard input")
    if arguments.textures is not None and not arguments.minecraft:
        raise UsageError("value", "`--textures` requires `--minecraft`")
    if arguments.distilled is not None and len(arguments.files) > 1:
        raise UsageError("value", "`--distilled` accepts only one program")
    if arguments.minecraft and (arguments.splats or arguments.distilled is not None):
        raise UsageError("value", "`--minecraft` cannot be combined with `--splats` or `--distilled`")
    if arguments.minecraft:
        return _view_build(arguments)
    from scenelang.sandbox.worker import Worker
    from scenelang.viewer.workspace import Workspace

    evaluate = _evaluator(arguments)
    for file in arguments.files:
        if not Path(file).exists():
            print(f"there is no file {file}; it is shown when it is there", file=sys.stderr)
    if arguments.html:
        return _save(arguments, Workspace(arguments.files, evaluate))
    return _serve(arguments, Workspace(arguments.files, Worker(evaluate, keeps=True).ask))


def add_studio(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``studio``."""
    parser.add_argument(
        "path", metavar="FILE|FOLDER", nargs="?", default=".",
        help="program to edit, made if it does not exist; or the folder of programs (default: the current one)",
    )  # fmt: skip
    parser.add_argument("--port", type=reader(port), default=0, metavar="N", help="port (default: the folder's own)")
    parser.add_argument("--no-browser", action="store_true", help="do not open a browser")


def run_studio(arguments: argparse.Namespace) -> int:
    """Edit programs in a browser until Ctrl-C."""
    from scenelang.sandbox.worker import Worker
    from scenelang.viewer.program_tools import TOOLS, SharedProgress, tools
    from scenelang.viewer.workspace import SUPERSEDED, Workspace, programs_of

    arguments.files, created = programs_of(Path(arguments.path))
    for path in created:
        done(arguments, path)
    progress = SharedProgress()
    use = tools(_session_opener(arguments), progress.write)
    worker, others = Worker(_evaluator(arguments), keeps=True), Worker(use)
    workers = {**dict.fromkeys(TOOLS, others), **{tool: Worker(use) for tool in SUPERSEDED}}
    workspace = Workspace(
        arguments.files, worker.ask, lambda tool, *rest: workers[tool].ask(tool, *rest),
        lambda what: workers.get(what, worker).interrupt(), progress.read,
    )  # fmt: skip
    if not arguments.port:
        arguments.port = _own_port(Path(arguments.files[0]).resolve().parent)
    return _serve(arguments, workspace, edits=True)


_FIRST_PORT, _PORTS = 47_000, 1_000  # of studios


def _own_port(folder: Path) -> int:
    """Return the port of a folder's studio, 0 (any) if it is taken.

    Browsers keep drafts by address, port included, so that the next start must have the same one.
    """
    number = _FIRST_PORT + zlib.crc32(str(folder).encode()) % _PORTS
    with socket.socket() as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind(("127.0.0.1", number))
        except OSError:
            return 0
    return number


def _evaluator(arguments: argparse.Namespace) -> Evaluate:
    """Return the function that evaluates the files of a view with the options of the command."""
    from scenelang.backends.viewer.packet import LIMIT
    from scenelang.viewer.workspace import evaluator

    arguments.file = arguments.files[0]
    session_of(arguments)  # report errors of the command line first
    limit = arguments.max_primitives
    return evaluator(_session_opener(arguments), LIMIT if limit is None else int(limit), _splats(arguments))


def _session_opener(arguments: argparse.Namespace) -> OpenSession:
    """Return the function that opens the session of a file with the options of the command."""

    def open_session(file: str, values: Mapping[str, str]) -> Session:
        """Create the session of a file, with values of the sliders for its params."""
        chosen = copy.copy(arguments)
        chosen.file = file
        chosen.define = [*arguments.define, *(f"{name}={text}" for name, text in values.items())]
        return session_of(chosen)

    return open_session


def _splats(arguments: argparse.Namespace) -> SplatsOf | None:
    """Return the Gaussians to show in place of solids, or None to show solids."""
    if arguments.command != "view" or (arguments.distilled is None and not arguments.splats):
        return None
    from scenelang.backends.neural.painting.shown import distilled_splats, surface_splats

    return surface_splats if arguments.distilled is None else distilled_splats(Path(arguments.distilled))


def _serve(arguments: argparse.Namespace, workspace: Workspace, *, edits: bool = False) -> int:
    """Serve until interrupted by Ctrl-C."""
    from scenelang.viewer.server import ViewServer

    with ViewServer(workspace, arguments.port, edits) as server:
        _open(arguments, server.address, "Press Ctrl-C to stop.")
        with suppress(KeyboardInterrupt):
            server.serve_forever(0.2)
    return 0


def _open(arguments: argparse.Namespace, address: str, note: str) -> None:
    """Print an address, and open it in a browser unless the user disabled that or there is no display."""
    from scenelang.backends.viewer.packet import open_in_browser

    print(address, flush=True)
    if not arguments.quiet:
        print(note, file=sys.stderr)
    if not arguments.no_browser:
        open_in_browser(address)


def _save(arguments: argparse.Namespace, workspace: Workspace) -> int:
    """Write the page with the scenes of all files; write nothing if one of them has errors."""
    from scenelang.backends.viewer.packet import page_path
    from scenelang.viewer.workspace import saved_page

    output = page_path(arguments.html)
    page = saved_page(workspace, lambda diagnostics: report(arguments, diagnostics))
    if page is None:
        return 1
    deliver(page, output)
    done(arguments, Path(output))
    return 0


def _view_build(arguments: argparse.Namespace) -> int:
    """Write the page of ``--html``, or show it in a browser until Ctrl-C; files are not watched."""
    from scenelang.backends.deepslate.backend import page_of_scene
    from scenelang.backends.viewer.packet import page_path

    if len(arguments.files) > 1:
        raise UsageError("file", "`view --minecraft` accepts only one program")
    output = page_path(arguments.html) if arguments.html else None
    (arguments.file,) = arguments.files
    scene = scene_of(arguments)
    page = page_of_scene(scene.graph, arguments.textures or "", session_limit(arguments))
    report(arguments, page.warnings)
    if output is not None:
        deliver(page.text, output)
        done(arguments, Path(output))
        return 0
    with tempfile.TemporaryDirectory(prefix="scenelang-page-") as folder:
        path = Path(folder) / "build.html"
        deliver(page.text, str(path))
        _open(arguments, path.as_uri(), "Press Ctrl-C to stop and to delete the page.")
        with suppress(KeyboardInterrupt):
            threading.Event().wait()
    return 0
