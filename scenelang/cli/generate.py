"""The command generate: a scene from words and pictures, by a language model."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from scenelang.cli.invert import invert_parts
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
from scenelang.cli.neural_options import add_models
from scenelang.cli.options import UsageError
from scenelang.cli.output import print_json, progress
from scenelang.cli.pictures import check_folder

if TYPE_CHECKING:
    from scenelang.inference.brief import Task
    from scenelang.inference.conductor import Inference
    from scenelang.inference.records import Run
    from scenelang.interpreter.scene.entity import Scene

_PICTURE_SIZE = 768
_LONGEST_TASK = 100_000  # characters
_MOST_PICTURES = 20


def add_generate(subparsers: Any) -> None:
    parser = subparsers.add_parser(
        "generate",
        help="make a scene of words and pictures, by a language model",
        description="Ask a language model for a scene, check and evaluate its program, have mistakes mended, and "
        "write the program. What the model answers is never executed as Python.",
    )
    parser.add_argument(
        "task", metavar="TASK", nargs="?", help='what the scene shows, such as "a chessboard at game start"'
    )
    parser.add_argument(
        "-o", "--output", metavar="OUT.scene", help="where to write the program (default: standard output)"
    )
    add_kind(parser)
    parser.add_argument("--render", action="store_true", help="also draw it, beside the program")
    parser.add_argument(
        "--invert",
        action="store_true",
        help="also learn the embeddings of its parts from the pictures, into Z beside it",
    )
    add_model_options(parser)
    add_models(parser)
    parser.set_defaults(run=generate)


def add_kind(parser: argparse.ArgumentParser) -> None:
    """What sort of scene is asked for, and in what notation."""
    parser.add_argument(
        "--image",
        action="append",
        default=[],
        metavar="FILE",
        help="a picture to reconstruct; may be given several times",
    )
    kind = parser.add_mutually_exclusive_group()
    kind.add_argument("--animate", action="store_true", help="a scene that moves")
    kind.add_argument("--minecraft", action="store_true", help="a build of Minecraft's blocks")
    parser.add_argument("--dsl", action="store_true", help="ask for the language itself in place of Python")


def generate(arguments: argparse.Namespace) -> int:
    from scenelang.inference.conductor import Inference

    if arguments.output is not None:
        check_folder(Path(arguments.output))
        if Path(arguments.output).suffix != ".scene":
            raise UsageError("file", f"{arguments.output} is to hold a program of the language: name it .scene")
    if arguments.resume is None and arguments.invert:
        _check_inversion(arguments)
    if arguments.resume is not None:
        return _finish(arguments, *resumed(arguments, "generate"))
    inference = Inference(task_of(arguments), settings_from(arguments), evaluation_options(arguments))
    if arguments.render and arguments.output is None:
        raise UsageError("value", "--render draws beside the program: say where that is with -o")
    if arguments.dry_run:
        return show_dry_run(arguments, inference)
    output = str(Path(arguments.output).resolve()) if arguments.output else None
    facts = {"output": output, "render": arguments.render, "invert": arguments.invert}
    run = begun(arguments, inference, arguments.task or "reconstruction", **facts)
    return _finish(arguments, inference, run)


def _finish(arguments: argparse.Namespace, inference: Inference, run: Run) -> int:
    """Run to the end, write the program and draw it."""
    from scenelang.backends.files import written_whole

    with recorded(arguments, run):
        run, result = played(arguments, inference, run)
    facts = run.facts
    chosen = arguments.output or facts.get("output")
    output = Path(chosen) if chosen else None
    if arguments.json:
        print_json(result_data(run, result))
    report_result(arguments, run, result)
    if output is not None:
        with written_whole(output) as temporary:
            temporary.write_text(result.best.program, "utf-8")
        say_written(arguments, output)
    elif not arguments.json:
        sys.stdout.write(result.best.program)
    if output is not None and (arguments.render or facts.get("render")) and result.best.scene is not None:
        _draw(arguments, result.best.scene, output)
    if output is not None and (arguments.invert or facts.get("invert")) and result.best.scene is not None:
        invert_parts(arguments, result.best.scene, inference.task.pictures, output)
    return 0


def _check_inversion(arguments: argparse.Namespace) -> None:
    """Raises UsageError where there is nothing to learn from or no place for it, and SceneError without the packages:
    before the language model costs money."""
    from scenelang.backends.base import need
    from scenelang.backends.neural.weights import INSTALL

    if not arguments.image or arguments.output is None:
        raise UsageError("value", "--invert learns from a picture, beside the program: give --image and -o")
    for package in ("torch", "diffusers", "transformers"):
        need(package, INSTALL)


def _draw(arguments: argparse.Namespace, scene: Scene, output: Path) -> None:
    """A draft beside the program: a picture, of a film a GIF."""
    from scenelang.backends.pictures.camera import Viewpoint
    from scenelang.backends.pictures.film import (
        FPS,
        PictureOptions,
        painters,
        picture_backend,
        render,
        save_film,
        save_picture,
    )
    from scenelang.backends.pictures.stage import film

    options = PictureOptions(width=_PICTURE_SIZE, height=_PICTURE_SIZE, progress=progress(arguments, "rendering"))
    if scene.animated:
        path = output.with_suffix(".gif")
        shots = film(scene, Viewpoint(), _PICTURE_SIZE // 2, _PICTURE_SIZE // 2, None, None)
        save_film(painters(scene, options, [picture_backend("draft")], shots), shots, path, FPS, options.progress)
    else:
        path = output.with_suffix(".png")
        save_picture(render(scene, options), path)
    say_written(arguments, path)


def task_of(arguments: argparse.Namespace) -> Task:
    """The task that a command's options and text give. Raises UsageError, and SceneError for a bad picture."""
    from scenelang.inference.answers import read_picture
    from scenelang.inference.brief import Notation, Task, TaskKind

    text = (arguments.task or "").strip()
    if not text and not arguments.image:
        raise UsageError("value", "say what the scene shows, or give a picture with --image")
    if len(text) > _LONGEST_TASK or len(arguments.image) > _MOST_PICTURES:
        raise UsageError("value", f"a task has at most {_LONGEST_TASK:,} characters and {_MOST_PICTURES} pictures")
    ablation = ablation_of(arguments)
    if ablation.takes_program and arguments.dsl:
        raise UsageError("value", "--dsl asks for a program, which --ablate P takes away")
    kind = TaskKind.FILM if arguments.animate else TaskKind.BLOCKS if arguments.minecraft else TaskKind.STILL
    notation = Notation.LANGUAGE if arguments.dsl else Notation.PYTHON
    if ablation.takes_program:
        notation = Notation.LIST
    pictures = tuple(read_picture(path) for path in arguments.image)
    return Task(text, kind, notation, ablation, pictures, None, arguments.seed)


COMMANDS = (add_generate,)
