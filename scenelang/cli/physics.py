"""Commands for physical plausibility: simulate, settle, repair. `check --physics` is with the other checks."""

from __future__ import annotations

import argparse
import os
from pathlib import Path
from typing import Any

from scenelang.backends.files import output_path, rewrite, write_text
from scenelang.cli.options import (
    add_camera,
    add_physics,
    check_folder,
    compute_solids,
    done,
    limits_of,
    opened,
    print_result,
    progress,
    reader,
    report,
    scene_of,
    usage_errors,
)
from scenelang.console.reports import say, table
from scenelang.grammar.datum import Source, replace
from scenelang.grammar.diagnostics import Diagnostic, SceneError, UsageError
from scenelang.grammar.settings import amount, frame_rate
from scenelang.sandbox.supervision import limited
from scenelang.session.loaded import LoadedScene
from scenelang.session.session import Session

_GUARD_SECONDS_PER_EFFORT = 4.0  # CPU seconds; a unit takes about one, so that effort ends a repair, not time
_FILMS = (".mp4", ".gif", ".apng", ".webp")


def add_simulate(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``simulate``."""
    parser.add_argument(
        "-o", "--output", metavar="OUT", required=True, help="film (.mp4 .gif .apng .webp) or 4D scene (.json)"
    )
    add_physics(parser, "2")
    parser.add_argument(
        "--velocity", action="append", default=[], type=reader(velocity), metavar="WORD=X,Y,Z",
        help="initial velocity of the bodies of a word, in scene units per second; may be repeated",
    )  # fmt: skip
    parser.add_argument("--fps", type=reader(frame_rate), default=24.0, metavar="N", help="frames per second")
    add_camera(parser, "size of the video in pixels (default 512x512, or that of the program)")


def velocity(text: str) -> tuple[str, tuple[float, float, float]]:
    """Return the word and the three numbers of ``WORD=X,Y,Z``; raises ValueError."""
    from scenelang.backends.physics.settling import MAX_SPEED

    word, equals, numbers = text.rpartition("=")
    try:
        x, y, z = (float(part) for part in numbers.split(","))
    except ValueError:
        raise ValueError(f"expected WORD=X,Y,Z, got {text!r}") from None
    if not equals or not all(abs(speed) <= MAX_SPEED for speed in (x, y, z)):
        raise ValueError(f"expected WORD=X,Y,Z with numbers of at most {MAX_SPEED:g}, got {text!r}")
    return word, (x, y, z)


def run_simulate(arguments: argparse.Namespace) -> int:
    """Simulate a scene, and write a video or a 4D scene."""
    from scenelang.backends.physics.settling import simulated
    from scenelang.backends.physics.verdicts import diagnostics_of
    from scenelang.backends.pictures.declared import view_of
    from scenelang.backends.pictures.images import picture_options, video_of
    from scenelang.files.scene_json import write_scene

    output = Path(arguments.output)
    with usage_errors():
        if output.suffix.lower() not in (*_FILMS, ".json"):
            raise UsageError(
                "value", f"`simulate` writes {' '.join(_FILMS)} and .json, not `{output.suffix or output}`"
            )
        camera = view_of(arguments.camera) if arguments.camera else None
    check_folder(output)
    scene = scene_of(arguments)
    with limited(limits_of(arguments)):
        moved, physics_report = simulated(
            scene.graph, arguments.seconds or 2.0, arguments.fps, arguments.metres_per_unit,
            dict(arguments.velocity), progress(arguments, "simulating"),
        )  # fmt: skip
    if output.suffix.lower() == ".json":
        write_scene(moved, output)
    else:
        video = video_of(LoadedScene(moved), picture_options(camera, arguments.size))
        video.save(output, arguments.fps, progress(arguments, "rendering"))
    if not arguments.json:
        report(arguments, [d for d in diagnostics_of(physics_report) if d.name == "body-explodes"])
    if arguments.json:
        return print_result(arguments, physics_report.data() | {"written": os.fspath(output)}, "")
    done(arguments, output)
    return 0


def add_settle(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``settle``."""
    parser.description = "Let a scene come to rest, and write the program with changed poses, or the scene as JSON."
    output = (
        "program (.scene) or scene (.json) to write (default: FILE.settled.scene, or .json if literals cannot say it)"
    )
    parser.add_argument("-o", "--output", metavar="OUT", help=output)
    add_physics(parser, "5")


def _translated(session: Session, source: Source) -> Source:
    """Return the program that Python is translated to, which can be edited; raises UsageError if parts are missing."""
    translation = session.transpile(source)
    if not translation.ok:
        message = f"`settle` edits programs in the Scene Language, and `{source.name}` cannot be translated as a whole"
        raise UsageError("value", message, "write the scene instead: `-o OUT.json`")
    return Source(f"{source.name}.scene", translation.text)


def run_settle(arguments: argparse.Namespace) -> int:
    """Let a scene come to rest, and write the program or the scene."""
    from scenelang.backends.physics.settling import SETTLE_SECONDS, EditedProgram, edited_program, settled
    from scenelang.files.scene_json import holds_scene, write_scene
    from scenelang.session.session import is_python

    asked = Path(arguments.output) if arguments.output else None
    if asked is not None and asked.suffix.lower() not in (".scene", ".json"):
        raise UsageError("value", f"`settle` writes .scene and .json, not `{asked.suffix or asked}`")
    result, source, session = opened(arguments)
    if result.scene is None:
        return 1
    writes_scene = asked is not None and asked.suffix.lower() == ".json"
    if is_python(source) and not writes_scene:
        source = _translated(session, source)
    scene, scale = result.scene, arguments.metres_per_unit
    with limited(limits_of(arguments)):
        compute_solids(arguments, scene.frames)
        rest = settled(scene, arguments.seconds or SETTLE_SECONDS, scale, progress(arguments, "simulating"))
        edited = EditedProgram(source.text, ())
        if result.program is not None and not writes_scene:
            edited = edited_program(source, scene, scale, rest, lambda text: session.evaluate(text).scene)
    complete = len(edited.bodies) == len(rest.moved)
    is_program = asked.suffix.lower() == ".scene" if asked is not None else complete and result.program is not None
    ending = ".settled.scene" if is_program else ".settled.json"
    output = asked or output_path(arguments.file, None, ending, lambda path: not is_program and holds_scene(path))
    if asked is not None and is_program and not edited.bodies and rest.moved:
        message = "none of the poses that change is a literal of the program that makes nothing else"
        raise SceneError("unsupported", message, f"write the scene instead: `-o {output.with_suffix('.json')}`")
    if is_program:
        write_text(output, edited.text)
    else:
        write_scene(rest.scene, output)
    return _report_settled(arguments, rest, edited, output, is_program=is_program)


def _report_settled(arguments: argparse.Namespace, rest: Any, edited: Any, output: Path, *, is_program: bool) -> int:
    """Report what moved and what the program could not express; return the exit code."""
    bodies = [rest.report.bodies[number] for number in rest.moved]
    left = [n for n in rest.moved if is_program and n not in edited.bodies]
    facts = rest.report.data() | {"moved": list(rest.moved), "left": left, "written": os.fspath(output)}
    rows = [("/".join(b.words[-3:]), b.kind, f"{b.moved:.4g}", f"{b.tilt:.1f}", b.why) for b in bodies]
    heads = [("body", "verdict", "moved", "tilt", "why")] if rows else []
    text = table([*heads, *rows], (False, False, True, True, False)) if rows else "everything rests"
    code = print_result(arguments, facts, text)
    if left and not arguments.json:
        names = ", ".join(sorted({f'"{rest.report.bodies[n].words[-1]}"' for n in left}))
        message = f"the program keeps these poses, which are no literals of their own: {names}"
        report(arguments, [Diagnostic("body-moves", message, None, "write all poses with `-o OUT.json`")])
    if not arguments.json:
        done(arguments, output)
    return code


def add_repair(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``repair``."""
    parser.description = "Edit a program so that findings of `check --geometry` and failed declarations are resolved."
    parser.add_argument(
        "-o", "--output", metavar="OUT", help="program to write, which may be FILE (default: print a diff)"
    )
    parser.add_argument(
        "--that", metavar="DECLARATION", action="append", help="a declaration, or a file of them, besides the program's"
    )
    parser.add_argument("--only-declarations", action="store_true", help="leave findings of the geometry lint alone")
    parser.add_argument(
        "--effort",
        type=reader(amount),
        metavar="N",
        default=30.0,
        help="how much is searched, about a second each (default 30); the result does not depend on the machine",
    )


def run_repair(arguments: argparse.Namespace) -> int:
    """Repair a program, and print the diff or write it; exit code 1 if findings remain."""
    from scenelang.repairs.repairing import imports_of, repaired
    from scenelang.session.declarations import declarations_of

    result, source, session = opened(arguments)
    if result.scene is None:
        return 1
    if result.program is None or not source.name.endswith((".scene", "<stdin>")):
        raise UsageError("value", f"`repair` edits programs in the Scene Language, not `{source.name}`")
    output = Path(arguments.output) if arguments.output else None
    if output is not None:
        _check_program(output)
    stated = [declaration for text in arguments.that or () for declaration in declarations_of(session, text)]
    limits = limits_of(arguments)
    compute_solids(arguments, result.scene.frames)
    with limited(replace(limits, seconds=limits.seconds + _GUARD_SECONDS_PER_EFFORT * arguments.effort)):
        repair = repaired(
            session, source, stated, effort=arguments.effort, geometry=not arguments.only_declarations,
            progress=progress(arguments, "repairing"),
        )  # fmt: skip
    written = output is not None and (repair.changed or not _is_same_file(output, arguments.file))
    if output is not None and written:
        (rewrite if output.exists() else write_text)(output, repair.text)
    hint = "what imported files make is repaired in these files" if imports_of(source) else None
    left = [Diagnostic("declaration", f"not repaired: {message}", None, hint) for message in repair.left]
    if arguments.json:
        print_result(arguments, repair.data() | {"program": repair.text, "ok": not left}, "")
        return 1 if left else 0
    rows = [(f"line {edit.line}", edit.resolves) for edit in repair.edits]
    summary = table(rows, (False, False)) if rows else "nothing to repair" if not left else ""
    if repair.changed or summary:
        print(repair.diff(source.name) + summary)
    report(arguments, left)
    if repair.changed and not arguments.quiet:
        edits = "1 edit" if len(repair.edits) == 1 else f"{len(repair.edits)} edits"
        say(f"{edits}; things move by {repair.displacement:.3g} on average")
    if output is not None and written:
        done(arguments, output)
    return 1 if left else 0


def _is_same_file(output: Path, file: str) -> bool:
    """Return whether an output is the input."""
    return file != "-" and output.exists() and output.samefile(file)


def _check_program(output: Path) -> None:
    """Check that a program can be written; raises UsageError for other files, SceneError("file") for read-only ones."""
    if output.suffix.lower() != ".scene":
        raise UsageError("value", f"`repair` writes programs, whose names end in `.scene`, not `{output}`")
    check_folder(output)
    if output.exists() and not (os.access(output, os.W_OK) and output.stat().st_mode & 0o222):  # root may write all
        raise SceneError("file", f"cannot write `{output}`: the file is read-only")
