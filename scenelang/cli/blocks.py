"""The command import: files of Minecraft builds as programs."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from scenelang.cli.options import UsageError, add_output
from scenelang.cli.output import report
from scenelang.cli.pictures import check_folder, done
from scenelang.grammar.diagnostics import Diagnostic, SceneError

if TYPE_CHECKING:
    from scenelang.backends.minecraft.blocks import Build
    from scenelang.backends.minecraft.build_files import Lost


def add_import(subparsers: Any) -> None:
    parser = subparsers.add_parser("import", help="make a program of a Minecraft build: .schem .litematic .nbt")
    parser.add_argument("file", metavar="FILE", help="the build: .schem, .litematic or .nbt")
    parser.add_argument("-o", "--output", metavar="OUT.scene", help="the program to write (default: standard output)")
    add_output(parser)
    parser.set_defaults(run=import_build)


def import_build(arguments: argparse.Namespace) -> int:
    output = Path(arguments.output) if arguments.output else None
    if output is not None:
        if output.suffix != ".scene":
            raise UsageError("backend", f"a program cannot be written as `{output.name}`", "use .scene")
        check_folder(output)
    from scenelang.backends.files import written_whole
    from scenelang.backends.minecraft.export import program_text, read

    file = Path(arguments.file)
    loaded = read(file)
    if not loaded.build.cells.any():
        raise SceneError("empty-scene", f"`{file}` holds no blocks")
    text = program_text(loaded.build, file.stem)
    if output is None:
        sys.stdout.write(text)
    else:
        with written_whole(output) as temporary:
            temporary.write_text(text, "utf-8")
        done(arguments, output)
    warnings = [_lost(loaded.lost, file), _forgotten(loaded.build, file)]
    report(arguments, [warning for warning in warnings if warning is not None])
    return 0


def _lost(lost: Lost, file: Path) -> Diagnostic | None:
    """The warning that says what of a file the program does not have."""
    parts = [
        f"what {lost.block_entities:,} {_plural('block', lost.block_entities)} held, such as items or text"
        if lost.block_entities
        else "",
        f"{lost.entities:,} {'entity' if lost.entities == 1 else 'entities'}, such as animals or item frames"
        if lost.entities
        else "",
    ]
    said = " and ".join(part for part in parts if part)
    return Diagnostic("lost-contents", f"`{file}` loses {said}") if said else None


def _forgotten(build: Build, file: Path) -> Diagnostic | None:
    """The warning that names the blocks whose states this version does not have."""
    from scenelang.backends.minecraft.export import forgotten
    from scenelang.backends.minecraft.table import load_table

    found = forgotten(build)
    if not found:
        return None
    shown = ", ".join(f"`{state}`" for state in found[:8]) + (", .." if len(found) > 8 else "")
    return Diagnostic(
        "lost-contents", f"`{file}` holds states that Minecraft {load_table().version} does not have: {shown}"
    )


def _plural(word: str, count: int) -> str:
    return word if count == 1 else f"{word}s"


COMMANDS = (add_import,)
