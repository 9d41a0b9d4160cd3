"""The commands of neural models, and the options that they share."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from scenelang.cli.options import UsageError, add_common, add_file, session_of, usage_errors, whole, z_path
from scenelang.cli.output import print_json, report_run, say

if TYPE_CHECKING:
    from scenelang.backends.language_models.catalogue import ImageContent
    from scenelang.backends.neural.inversion import InversionProgress, InversionSettings
    from scenelang.backends.neural.sentences import Granularity
    from scenelang.backends.neural.weights import Models
    from scenelang.embeddings import Embeddings
    from scenelang.interpreter.scene.entity import Scene as SceneGraph
    from scenelang.inversion import Inversion, InversionModels, InversionStart, RunFolder
    from scenelang.scene import Scene

_ENTITY_HELP = "a word, words down to it (tower/roof), places of children (0/2), or a handle"


# --- shared options --------------------------------------------------------------------------------------------------


def add_models(parser: argparse.ArgumentParser) -> None:
    """Where weights are, and what computes."""
    group = parser.add_argument_group("neural models")
    group.add_argument(
        "--models-dir", metavar="DIR", help="a folder that holds models, each in a folder of its own (SCENELANG_MODELS)"
    )
    group.add_argument("--offline", action="store_true", help="ask no hub for weights that are not on this machine")
    group.add_argument("--device", metavar="NAME", help="cpu, cuda, mps (default: the fastest there is)")


def models_of(arguments: argparse.Namespace) -> Models:
    from scenelang.backends.neural.weights import Models

    return Models(arguments.models_dir, arguments.offline, arguments.device)


def add_granularity(parser: Any) -> None:
    """Which entities are taken as one, and the sentence of each."""
    parser.add_argument("--depth", type=whole, metavar="N", help="take entities N below the root as one each")
    parser.add_argument(
        "--entity", action="append", default=[], metavar="NAME",
        help="take an entity as one: its handle '<z5>', its word, or the places of children from the root, 0/2; "
        "may be repeated",
    )  # fmt: skip
    parser.add_argument("--template", metavar="TEXT", help="the sentence, with {embedding}, {word} and {style}")


def granularity_of(arguments: argparse.Namespace) -> Granularity:
    from scenelang.backends.neural.sentences import Granularity

    return Granularity(arguments.depth, tuple(arguments.entity))


def z_of(arguments: argparse.Namespace) -> Embeddings:
    """The file of embeddings to write: the one named, else that beside the program, which may not be there yet."""
    from scenelang.embeddings import Embeddings
    from scenelang.zfile import beside

    return Embeddings(z_path(arguments) or (None if arguments.file == "-" else beside(arguments.file)))


def scene_from(arguments: argparse.Namespace, fresh: bool = False) -> Scene | None:
    """Evaluate the command's file and print what the run said; None for a wrong program. ``fresh``: the file of
    embeddings is only to be made."""
    from scenelang.scene import Scene

    known = argparse.Namespace(**{**vars(arguments), "z": None, "file": "-"}) if fresh else arguments
    session = session_of(known)
    result = session.evaluate(session.source(arguments.file))
    report_run(arguments, result)
    if result.scene is None:
        return None
    return Scene(result.scene, arguments.file, result.log, result.diagnostics, result.program, session.options)


@contextmanager
def interruptions() -> Iterator[Callable[[], bool]]:
    """Whether Ctrl-C was pressed: from the first time that this is asked on, the step that is being made ends first.
    Pressed again it interrupts at once."""
    import signal
    import threading

    if threading.current_thread() is not threading.main_thread():
        yield lambda: False
        return
    pressed = threading.Event()
    before = signal.getsignal(signal.SIGINT)

    def note(*_: object) -> None:
        if pressed.is_set():
            raise KeyboardInterrupt
        pressed.set()

    def stopped() -> bool:
        if signal.getsignal(signal.SIGINT) is not note:  # what comes before the first step needs no care
            signal.signal(signal.SIGINT, note)
        return pressed.is_set()

    try:
        yield stopped
    finally:
        signal.signal(signal.SIGINT, before)


def _check_finished(finished: bool, folder: Path) -> None:
    """Says that a run was stopped and is kept, and ends the command."""
    if not finished:
        print(f"{folder} is kept; `--resume` goes on", file=sys.stderr)
        raise KeyboardInterrupt


def _show_step(text: str, is_last: bool) -> None:
    """One line on a terminal, written over at the next step."""
    sys.stderr.write(f"\r{text}\033[K" + ("\n" if is_last else ""))
    sys.stderr.flush()


# --- invert, style ---------------------------------------------------------------------------------------------------


def add_invert(subparsers: Any) -> None:
    parser = subparsers.add_parser("invert", help="learn the embeddings of entities from a picture of them")
    add_file(parser)
    parser.add_argument("--from", dest="picture", metavar="PICTURE", required=True, help="what shows them")
    parser.add_argument(
        "--entity",
        action="append",
        default=[],
        metavar="WORD|'<z4>'",
        help=f"{_ENTITY_HELP}; may be repeated (default: all parts with names that can be seen in the picture)",
    )
    parser.add_argument("--no-segment", action="store_true", help="the whole picture is the entity")
    _add_inversion(parser)
    add_common(parser)
    parser.set_defaults(run=invert)


def add_style(subparsers: Any) -> None:
    parser = subparsers.add_parser("style", help="learn a style from a picture, for a scene or a part of it")
    add_file(parser)
    parser.add_argument("--from", dest="picture", metavar="PICTURE", required=True, help="what has the style")
    parser.add_argument("--entity", metavar="WORD|'<z4>'", help=f"{_ENTITY_HELP} (default: the whole scene)")
    _add_inversion(parser)
    add_common(parser)
    parser.set_defaults(run=style, no_segment=False)


def _add_inversion(parser: argparse.ArgumentParser) -> None:
    """The picture's part, the work, and the models."""
    part = parser.add_argument_group("what of the picture")
    part.add_argument("--text", metavar="TEXT", help="what to look for in the picture")
    part.add_argument("--mask", metavar="FILE", help="a picture of the same size, white where the thing is")
    work = parser.add_argument_group("the optimisation")
    work.add_argument("--class-word", metavar="TEXT", help="what the picture shows (default: the entity's word)")
    work.add_argument("--style-word", default="photo", metavar="TEXT", help="what the style starts from (photo)")
    work.add_argument("--steps", type=whole, default=100, metavar="N", help="of each run (100)")
    work.add_argument("--rate", type=float, default=1e-2, metavar="X", help="how far a step goes (0.01)")
    work.add_argument("--batch", type=whole, default=4, metavar="N", help="noisy copies of a picture in a step (4)")
    work.add_argument("-o", "--output", metavar="DIR", help="the folder of the run (default: beside the program)")
    work.add_argument("--resume", action="store_true", help="go on with the run in the folder")
    work.add_argument("--force", action="store_true", help="begin anew, and replace what would be lost")
    add_models(parser)
    parser.add_argument("--model", metavar="NAME", help="MVDream/MVDream, another diffusion model, or a folder")
    parser.add_argument("--detector", metavar="NAME", help="IDEA-Research/grounding-dino-base, or a folder")
    parser.add_argument("--segmenter", metavar="NAME", help="facebook/sam-vit-huge, or a folder")


def invert(arguments: argparse.Namespace) -> int:
    from scenelang.inversion import invert as invert_entities

    run = _run_of(arguments)
    with usage_errors():
        subject = _subject_of(arguments)
        subject.check_single(arguments.entity)
    z = z_of(arguments)
    scene = scene_from(arguments, fresh=not z.exists)
    if scene is None:
        return 1
    with interruptions() as stop:
        found = invert_entities(
            scene, arguments.picture, entities=arguments.entity, subject=subject, settings=_inversion_of(arguments),
            networks=_networks_of(arguments), run=run, embeddings=z, models=models_of(arguments),
            on_start=_missing_teller(arguments), on_step=_loss_teller(arguments), stop=stop,
        )  # fmt: skip
    _check_finished(found.finished, found.folder)
    _tell(arguments, found)
    return 0


def style(arguments: argparse.Namespace) -> int:
    from scenelang.inversion import learn_style

    run = _run_of(arguments)
    with usage_errors():
        subject = _subject_of(arguments)
    z = z_of(arguments)
    scene = scene_from(arguments, fresh=not z.exists)
    if scene is None:
        return 1
    with interruptions() as stop:
        found = learn_style(
            scene, arguments.picture, entity=arguments.entity, subject=subject, settings=_inversion_of(arguments),
            networks=_networks_of(arguments), run=run, embeddings=z, models=models_of(arguments),
            on_step=_loss_teller(arguments), stop=stop,
        )  # fmt: skip
    _check_finished(found.finished, found.folder)
    _tell(arguments, found)
    return 0


def invert_parts(
    arguments: argparse.Namespace, graph: SceneGraph, pictures: Sequence[ImageContent], program: Path
) -> None:
    """Learn the named parts of a scene from the pictures that it was made of, into Z beside ``program``.

    ``arguments`` hold the options of neural models. Raises SceneError; the program stays.
    """
    from io import BytesIO

    from scenelang.backends.neural.clip import open_picture
    from scenelang.backends.neural.inversion import InversionSettings
    from scenelang.inversion import RunFolder
    from scenelang.inversion import invert as invert_entities
    from scenelang.scene import Scene

    given = [open_picture(BytesIO(each.data)) for each in pictures]
    with interruptions() as stop:
        found = invert_entities(
            Scene(graph, str(program)), given, settings=InversionSettings(seed=arguments.seed),
            run=RunFolder(force=True), models=models_of(arguments), missing_ok=True,
            on_start=_missing_teller(arguments), on_step=_loss_teller(arguments), stop=stop,
        )  # fmt: skip
    _check_finished(found.finished, found.folder)
    if found.parts and not arguments.json:
        _tell(arguments, found)


def _run_of(arguments: argparse.Namespace) -> RunFolder:
    """Where the run is; raises UsageError for standard input without places."""
    from scenelang.inversion import RunFolder

    with usage_errors():
        run = RunFolder(arguments.output, arguments.resume, arguments.force)
    if arguments.file == "-" and (arguments.output is None or arguments.z is None):
        raise UsageError("value", "for a program from standard input say where the run and Z are: -o DIR --z FILE")
    return run


def _subject_of(arguments: argparse.Namespace) -> Any:
    from scenelang.inversion import PictureSubject

    return PictureSubject(
        arguments.text, arguments.mask, arguments.no_segment, arguments.class_word, arguments.style_word
    )


def _inversion_of(arguments: argparse.Namespace) -> InversionSettings:
    from scenelang.backends.neural.inversion import InversionSettings

    return InversionSettings(arguments.steps, arguments.rate, arguments.batch, arguments.seed)


def _networks_of(arguments: argparse.Namespace) -> InversionModels:
    from scenelang.inversion import InversionModels

    return InversionModels(arguments.model, arguments.detector, arguments.segmenter)


def _missing_teller(arguments: argparse.Namespace) -> Callable[[InversionStart], None]:
    """Says which parts of the scene no picture shows."""

    def tell(start: InversionStart) -> None:
        if start.missing and not arguments.quiet:
            named = ", ".join(f'"{text}"' for text in start.missing)
            print(f"not found in the picture, so left as they are: {named}", file=sys.stderr)

    return tell


def _loss_teller(arguments: argparse.Namespace) -> Callable[[InversionProgress], None] | None:
    """A line with the loss on a terminal."""
    if arguments.quiet or not sys.stderr.isatty():
        return None
    return lambda told: _show_step(f"step {told.done:,}/{told.steps:,}  loss {told.loss:.4g}", told.done >= told.steps)


def _tell(arguments: argparse.Namespace, found: Inversion) -> None:
    """Say what was stored, and how much better the sentences fit the pictures."""
    if arguments.json:
        print_json({
            "z": str(found.embeddings.path), "loss": {"before": found.before, "after": found.after},
            "style": list(found.styles),
            "parts": [{"text": part.text, "handles": list(part.handles)} for part in found.parts],
        })  # fmt: skip
    elif not arguments.quiet:
        learned = [name for part in found.parts for name in part.handles]
        shown = " ".join(f"<{handle}>" for handle in dict.fromkeys([*learned[:8], *found.styles[:8]]))
        say(f"wrote {found.embeddings.path}: {shown}; loss {found.before:.4g} -> {found.after:.4g}")
