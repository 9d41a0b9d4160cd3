"""Commands that export scenes: export, backends."""

from __future__ import annotations

import argparse
from contextlib import nullcontext
from pathlib import Path

from scenelang.backends import base
from scenelang.backends.files import output_path
from scenelang.cli.options import (
    add_backend_options,
    add_fields,
    backend_settings_of,
    bounded,
    check_folder,
    done,
    fields_of,
    naming_other_commands,
    print_result,
    progress,
    scene_of,
    session_limit,
    usage_errors,
)
from scenelang.cli.options import warnings as warnings_of
from scenelang.console.reports import table


def add_export(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``export``."""
    parser.add_argument("-o", "--output", metavar="OUT", help="output file (default: FILE.glb)")
    parser.add_argument(
        "--backend",
        "--to",
        metavar="NAME",
        help="export backend, such as `bpy` or `python` for .py (default: from the file extension)",
    )
    add_fields(parser, base.BackendOptions, ("frame",))
    add_backend_options(parser, base.Work.EXPORT)


def _wrote_glb(path: Path) -> bool:
    """Return whether a file of the default name is ours, and may be replaced."""
    from scenelang.backends.exports.gltf import wrote_glb

    return wrote_glb(path)


def run_export(arguments: argparse.Namespace) -> int:
    """Export a scene to the format of a backend."""
    limit, shown, warn = session_limit(arguments), progress(arguments, "exporting"), warnings_of(arguments)
    with naming_other_commands("export", arguments), usage_errors():
        output = output_path(arguments.file, arguments.output, ".glb", _wrote_glb)
        backend = base.find(arguments.backend) if arguments.backend else base.for_file(output, base.Work.EXPORT)
        options = fields_of(
            arguments,
            base.BackendOptions,
            limit=limit,
            progress=shown,
            settings=backend_settings_of(arguments),
            warn=warn,
        )
        base.check_settings(options, [backend])
    check_folder(output)
    scene = scene_of(arguments)
    solid = bool(options.settings.get("solid"))  # the union may take long, and is part of what the limits are for
    with bounded(arguments) if solid else nullcontext():
        written = backend.run(scene.graph, output, options) or [output]
    done(arguments, *written)
    return 0


def run_backends(arguments: argparse.Namespace) -> int:
    """List the backends."""
    backends = base.all_backends()
    rows = [("backend", "command", "writes", "installed", ""), *(backend.row for backend in backends)]
    options = [f"{b.name} --{option.name}: {option.doc}" for b in backends for option in b.options]
    text = "\n".join([table(rows, (False,) * 5), *(options if arguments.verbose else ())])
    return print_result(arguments, [backend.metadata() for backend in backends], text)
