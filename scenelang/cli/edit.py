"""The command edit: a scene changed by an instruction, by a language model."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from scenelang.backends.files import read_regular, rewrite, written_whole
from scenelang.cli.model_options import ablation_of, add_model_options, evaluation_options, settings_from
from scenelang.cli.model_runs import (
    begun,
    played,
    recorded,
    report_result,
    result_data,
    resumed,
    say_written,
    show_dry_run,
)
from scenelang.cli.options import UsageError, whole
from scenelang.cli.output import print_json, report_run, say, use_color
from scenelang.cli.pictures import check_folder
from scenelang.grammar.diagnostics import SceneError, printable
from scenelang.session import Session

if TYPE_CHECKING:
    from scenelang.inference.conductor import Inference, Result, SceneEdit
    from scenelang.inference.records import Run
    from scenelang.interpreter.scene.entity import Scene

_COLORS = {"+": "32", "-": "31", "@": "36"}


def add_edit(subparsers: Any) -> None:
    parser = subparsers.add_parser(
        "edit",
        help="change a scene by an instruction, by a language model",
        description="Send a program and an instruction to a language model, check and evaluate what comes back, and "
        "show what the edit did: to the text, to the things of the scene, in pictures. Nothing is overwritten without "
        "--apply.",
    )
    parser.add_argument("file", metavar="FILE", nargs="?", help="the program: .scene, or a model's .txt or .py")
    parser.add_argument(
        "instruction", metavar="INSTRUCTION", nargs="?", help='such as "shrink the staircase radius by 80%%"'
    )
    parser.add_argument("-o", "--output", metavar="NEW", help="where to write the edited program")
    parser.add_argument("--apply", action="store_true", help="write it over FILE")
    parser.add_argument(
        "--picture", metavar="OUT.png", help="where to draw the scene before and after (default: in the run's folder)"
    )
    parser.add_argument(
        "--limit", type=whole, default=20, metavar="N", help="changes of the scene to print (default 20)"
    )
    add_model_options(parser)
    parser.set_defaults(run=edit)


def edit(arguments: argparse.Namespace) -> int:
    _check_outputs(arguments)
    if arguments.resume is not None:
        inference, run = resumed(arguments, "edit")
        return _finish(arguments, inference, run, Path(str(run.facts["file"])))
    if arguments.file is None or not (arguments.instruction or "").strip():
        raise UsageError("value", "say which program is to be edited, and how")
    path = Path(arguments.file)
    found = _inference(arguments, path)
    if found is None:
        return 1
    if arguments.dry_run:
        return show_dry_run(arguments, found)
    name = f"{path.stem} {arguments.instruction}"
    run = begun(arguments, found, name, file=str(path.resolve()), digest=_digest(path))
    return _finish(arguments, found, run, path)


def _check_outputs(arguments: argparse.Namespace) -> None:
    """Raises UsageError or SceneError for places that cannot be written: before the work, so that typos are cheap."""
    if arguments.apply and arguments.output:
        raise UsageError("value", "--apply writes over the file; leave -o out")
    if arguments.file == "-":
        raise UsageError("file", "edit wants a file: what it holds is compared with what comes back")
    for chosen in (arguments.output, arguments.picture):
        if chosen is not None:
            check_folder(Path(chosen))
    if arguments.picture is not None and Path(arguments.picture).suffix.lower() not in (".png", ".jpg", ".webp"):
        raise UsageError("backend", f"no picture can be written to `{arguments.picture}`", "it can be a .png")


def _inference(arguments: argparse.Namespace, path: Path) -> Inference | None:
    """The edit to ask for; None for a program that is wrong already, which is then said."""
    from dataclasses import replace

    from scenelang.inference.conductor import Inference, edit_task, imported_files

    options = replace(evaluation_options(arguments), project=path.resolve().parent)
    session = Session(options)
    source = session.source(str(path))
    result = session.evaluate(source)
    report_run(arguments, result)
    if result.scene is None:
        return None
    task = edit_task(source, result.scene, arguments.instruction.strip(), ablation_of(arguments), arguments.seed)
    options = replace(options, imports=imported_files(result.program))
    return Inference(task, settings_from(arguments), options, str(path))


def _finish(arguments: argparse.Namespace, inference: Inference, run: Run, path: Path) -> int:
    """Run to the end, show what the edit did, and write it where that is asked for."""
    from scenelang.inference.conductor import edit_of, scene_before, without_known, written_as

    with recorded(arguments, run):
        run, result = played(arguments, inference, run)
        before = scene_before(path, inference.task, inference.options)
        done_to = edit_of(path.name, inference.task, before, result.best, inference.options.limits.primitives)
    run.keep_text("edit.diff", done_to.text + "\n")
    picture = _draw(arguments, run, before, result)
    if arguments.json:
        data = result_data(run, result) | {"diff": done_to.text, "changes": done_to.changes.data()}
        print_json(data | {"picture": str(picture) if picture is not None else None})
    else:
        _show(arguments, done_to)
    report_result(arguments, run, without_known(result, before))
    if picture is not None:
        say_written(arguments, picture)
    target = path if arguments.apply else Path(arguments.output) if arguments.output else None
    if target is None:
        if not arguments.quiet and not arguments.json:
            print(f"nothing is overwritten; to take it: scenelang edit --resume {run.name} --apply", file=sys.stderr)
        return 0
    if arguments.apply:
        _check_unchanged(path, run)
    _write(target, written_as(target, inference.task, result.best))
    say_written(arguments, target)
    return 0


def _check_unchanged(path: Path, run: Run) -> None:
    """Raises SceneError for a file that somebody changed since its program was sent."""
    if _digest(path) != run.facts.get("digest"):
        raise SceneError("file", f"{path} has changed since its program was sent", "write the edit elsewhere with -o")


def _digest(path: Path) -> str:
    from hashlib import sha256

    return sha256(read_regular(path)).hexdigest()


def _write(target: Path, text: str) -> None:
    if target.exists():
        rewrite(target, text)
        return
    with written_whole(target) as temporary:
        temporary.write_text(text, "utf-8")


def _draw(arguments: argparse.Namespace, run: Run, before: Scene, result: Result) -> Path | None:
    """The picture of before and after; None where a scene cannot be drawn."""
    from scenelang.backends.pictures.film import save_picture
    from scenelang.inference.conductor import before_and_after

    path = Path(arguments.picture) if arguments.picture else run.path / "before-after.png"
    assert result.best.scene is not None
    try:
        save_picture(before_and_after(before, result.best.scene), path)
    except SceneError:
        return None
    return path


def _show(arguments: argparse.Namespace, done_to: SceneEdit) -> None:
    from scenelang.scene_changes import OF_AN_EDIT, change_lines

    colored = use_color(arguments, sys.stdout)
    for line in done_to.text.splitlines():
        color = _COLORS.get(line[:1])
        shown = printable(line)
        print(f"\033[{color}m{shown}\033[0m" if colored and color else shown)
    say("\n".join(change_lines(done_to.changes, arguments.limit, OF_AN_EDIT)))


COMMANDS = (add_edit,)
