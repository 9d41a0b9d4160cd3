"""The commands of neural models, and the options that they share."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from scenelang.cli.options import (
    add_camera,
    add_common,
    add_file,
    amount,
    scene_of,
    session_limit,
    usage_errors,
    whole,
    z_path,
)
from scenelang.cli.output import check_folder, done, print_json, progress, say, warnings
from scenelang.grammar.diagnostics import SceneError

if TYPE_CHECKING:
    from scenelang.backends.language_models.catalogue import ImageContent
    from scenelang.backends.neural.sentences import Granularity
    from scenelang.backends.neural.weights import Models
    from scenelang.embeddings import Embeddings
    from scenelang.inversion import Inversion
    from scenelang.neural import Distillation
    from scenelang.scene import Scene

Learned = TypeVar("Learned", "Inversion", "Distillation")
_ENTITY_HELP = "a word, words down to it (tower/roof), places of children (0/2), or a handle"


# --- shared options --------------------------------------------------------------------------------------------------


def add_models(parser: argparse.ArgumentParser) -> None:
    """Where weights are, and what computes."""
    group = parser.add_argument_group("neural models")
    folder = "a folder that holds models, each in a folder of its own (SCENELANG_MODELS)"
    group.add_argument("--models-dir", metavar="DIR", help=folder)
    group.add_argument("--offline", action="store_true", help="ask no hub for weights that are not on this machine")
    group.add_argument("--device", metavar="NAME", help="cpu, cuda, mps (default: the fastest there is)")


def models_of(arguments: argparse.Namespace) -> Models:
    from scenelang.backends.neural.weights import Models

    return Models(arguments.models_dir, arguments.offline, arguments.device)


def add_granularity(parser: Any) -> None:
    """Which entities are taken as one, and the sentence of each."""
    parser.add_argument("--depth", type=whole, metavar="N", help="take entities N below the root as one each")
    entity = "take an entity as one: its handle '<z5>', its word, or the places of children from the root, 0/2; may be "
    parser.add_argument("--entity", action="append", default=[], metavar="NAME", help=f"{entity}repeated")
    parser.add_argument("--template", metavar="TEXT", help="the sentence, with {embedding}, {word} and {style}")


def granularity_of(arguments: argparse.Namespace) -> Granularity:
    from scenelang.backends.neural.sentences import Granularity

    return Granularity(arguments.depth, tuple(arguments.entity))


def z_of(arguments: argparse.Namespace) -> Embeddings:
    """The file of embeddings to write: the one named, else that beside the program, which may not be there yet."""
    from scenelang.embeddings import Embeddings
    from scenelang.zfile import beside

    return Embeddings(z_path(arguments) or (None if arguments.file == "-" else beside(arguments.file)))


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


def finished(arguments: argparse.Namespace, learn: Callable[..., Learned]) -> Learned:
    """What a run comes to that tells of its start and its steps; one that Ctrl-C ends is kept, and ends the command."""
    with interruptions() as stop:
        found = learn(
            models=models_of(arguments), on_start=_say_start(arguments), on_step=_say_step(arguments), stop=stop
        )
    if not found.finished:
        print(f"{found.folder} is kept; `--resume` goes on", file=sys.stderr)
        raise KeyboardInterrupt
    return found


def _say_start(arguments: argparse.Namespace) -> Callable[[Any], None] | None:
    """What tells what is about to be learned."""

    def tell(start: Any) -> None:
        sentences = getattr(start, "sentences", ())
        for line in (str(start), *(f"  {sentence}" for sentence in sentences if arguments.verbose)):
            print(line, end="\n" if line else "", file=sys.stderr)

    return None if arguments.quiet else tell


def _say_step(arguments: argparse.Namespace) -> Callable[[Any], None] | None:
    """What shows the losses on a terminal, in a line that the next step writes over."""

    def tell(told: Any) -> None:
        sys.stderr.write(f"\r{told}\033[K" + ("\n" if told.share >= 1.0 else ""))
        sys.stderr.flush()

    return None if arguments.quiet or not sys.stderr.isatty() else tell


# --- imagine ---------------------------------------------------------------------------------------------------------


def add_imagine(parser: argparse.ArgumentParser) -> None:
    add_file(parser)
    parser.add_argument("-o", "--output", metavar="OUT", required=True, help=".png; .json for a layout")
    count = "so many pictures, OUT-1.png, OUT-2.png ..."
    parser.add_argument("--count", type=whole, default=1, metavar="N", help=count)
    parser.add_argument("--frame", type=whole, metavar="N", help="this frame of a 4D scene, from 0")
    add_camera(parser.add_argument_group("view"), "pixels (default: what the model was made for)")
    layout = parser.add_argument_group("layout")
    layout.add_argument("--layout-only", action="store_true", help="write the layout as .png or .json, use no model")
    add_granularity(layout)
    _add_drawing(parser.add_argument_group("drawing"))
    add_models(parser)
    add_common(parser)
    parser.set_defaults(run=imagine)


def _add_drawing(group: Any) -> None:
    group.add_argument("--prompt", help="what it shows (default: as the file's first comment says, or the root)")
    group.add_argument("--negative", default="", metavar="TEXT", help="what it should not show")
    group.add_argument("--steps", type=whole, default=50, metavar="N", help="steps of denoising (default 50)")
    group.add_argument("--guidance", type=float, default=7.5, metavar="X", help="how much words count (default 7.5)")
    heeded = "how the layout is heeded: without training, by GLIGEN's weights, or by MIGC's"
    group.add_argument("--method", choices=("regional", "gligen", "migc"), default="regional", help=heeded)
    group.add_argument("--strength", type=float, default=10.0, metavar="X", help="of regional attention (default 10)")
    group.add_argument("--model", metavar="NAME", help="a Stable Diffusion checkpoint of the hub, or a folder")
    group.add_argument("--migc", metavar="FILE", help="MIGC's weights")
    group.add_argument("--scheduler", choices=("own", "ddim"), default="own", help="the checkpoint's own, or DDIM")
    depth = "heed depth too, by a ControlNet of the hub, or a folder"
    group.add_argument("--control", nargs="?", const="", metavar="NAME", help=depth)
    counts = "how much depth counts (default 1)"
    group.add_argument("--control-scale", type=float, default=1.0, metavar="X", help=counts)


def imagine(arguments: argparse.Namespace) -> int:
    from scenelang import neural
    from scenelang.backends.pictures.camera import parse_viewpoint
    from scenelang.embeddings import Embeddings

    output = Path(arguments.output)
    with usage_errors():
        neural.check_output(output, arguments.layout_only)
        neural.check_count(arguments.count)
        settings = neural.ImagineSettings(
            arguments.steps, arguments.guidance, arguments.negative, arguments.method, arguments.strength,
            arguments.model, arguments.migc, arguments.scheduler, arguments.control, arguments.control_scale,
        )  # fmt: skip
        camera = parse_viewpoint(arguments.camera) if arguments.camera else None
        neural.check_size(camera, arguments.size)
    check_folder(output)
    scene = scene_of(arguments)
    if scene is None:
        return 1
    asked = {
        "size": arguments.size, "frame": arguments.frame, "prompt": arguments.prompt, "template": arguments.template,
        "granularity": granularity_of(arguments), "embeddings": Embeddings(z_path(arguments)),
        "limit": session_limit(arguments), "warn": warnings(arguments),
    }  # fmt: skip
    if arguments.layout_only:
        layout = neural.imagine_layout(scene, camera, method=arguments.method, **asked)
        done(arguments, layout.save(output))
        return 0
    pictures = neural.imagine(
        scene, camera, seed=arguments.seed, count=arguments.count, settings=settings, models=models_of(arguments),
        progress=progress(arguments, "imagining"), **asked,
    )  # fmt: skip
    for picture, path in zip(pictures, pictures.paths(output)):
        done(arguments, picture.save(path))
    return 0


# --- invert, style ---------------------------------------------------------------------------------------------------


def add_invert(parser: argparse.ArgumentParser) -> None:
    add_file(parser)
    parser.add_argument("--from", dest="picture", metavar="PICTURE", required=True, help="what shows them")
    entities = f"{_ENTITY_HELP}; may be repeated (default: all parts with names that can be seen in the picture)"
    parser.add_argument("--entity", action="append", default=[], metavar="WORD|'<z4>'", help=entities)
    parser.add_argument("--no-segment", action="store_true", help="the whole picture is the entity")
    _add_inversion(parser)
    parser.set_defaults(run=invert)


def add_style(parser: argparse.ArgumentParser) -> None:
    add_file(parser)
    parser.add_argument("--from", dest="picture", metavar="PICTURE", required=True, help="what has the style")
    parser.add_argument("--entity", metavar="WORD|'<z4>'", help=f"{_ENTITY_HELP} (default: the whole scene)")
    _add_inversion(parser)
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
    add_common(parser)


def invert(arguments: argparse.Namespace) -> int:
    from scenelang.inversion import invert as learn

    return _inverted(arguments, partial(learn, entities=arguments.entity), arguments.entity)


def style(arguments: argparse.Namespace) -> int:
    from scenelang.inversion import learn_style

    return _inverted(arguments, partial(learn_style, entity=arguments.entity))


def _inverted(
    arguments: argparse.Namespace, learn: Callable[..., Inversion], entities: Sequence[str] | None = None
) -> int:
    """Learn from a picture; ``entities`` are those that the options about one entity may mean."""
    from scenelang.backends.neural.inversion import InversionSettings
    from scenelang.inversion import InversionModels, PictureSubject, RunFolder

    with usage_errors():
        run = RunFolder(arguments.output, arguments.resume, arguments.force)
        if arguments.file == "-" and (arguments.output is None or arguments.z is None):
            raise SceneError("value", "for a program from standard input say where the run and Z are: -o DIR --z FILE")
        subject = PictureSubject(
            arguments.text, arguments.mask, arguments.no_segment, arguments.class_word, arguments.style_word
        )
        if entities is not None:
            subject.check_single(entities)
    z = z_of(arguments)
    scene = scene_of(arguments, fresh=not z.exists)
    if scene is None:
        return 1
    settings = InversionSettings(arguments.steps, arguments.rate, arguments.batch, arguments.seed)
    networks = InversionModels(arguments.model, arguments.detector, arguments.segmenter)
    asked = {"subject": subject, "settings": settings, "networks": networks, "run": run, "embeddings": z}
    _tell(arguments, finished(arguments, partial(learn, scene, arguments.picture, **asked)))
    return 0


def invert_generated(
    arguments: argparse.Namespace, scene: Scene, pictures: Sequence[ImageContent], program: Path
) -> None:
    """Learn the named parts of a scene from the pictures that it was made of, into Z beside ``program``."""
    from io import BytesIO

    from scenelang.backends.neural.clip import open_picture
    from scenelang.backends.neural.inversion import InversionSettings
    from scenelang.inversion import RunFolder
    from scenelang.inversion import invert as learn

    given = [open_picture(BytesIO(each.data)) for each in pictures]
    named = replace(scene, name=str(program))
    settings = InversionSettings(seed=arguments.seed)
    found = finished(
        arguments, partial(learn, named, given, settings=settings, run=RunFolder(force=True), missing_ok=True)
    )
    if found.parts and not arguments.json:
        _tell(arguments, found)


def _tell(arguments: argparse.Namespace, found: Inversion) -> None:
    """Say what was stored, and how much better the sentences fit the pictures."""
    if arguments.json:
        print_json(found.data())
    elif not arguments.quiet:
        say(f"wrote {found.embeddings.path}: {found}")


# --- distill ---------------------------------------------------------------------------------------------------------


def add_distill(parser: argparse.ArgumentParser) -> None:
    add_file(parser)
    parser.add_argument("-o", "--output", metavar="DIR", required=True, help="the folder of the run")
    parser.add_argument("--prompt", metavar="TEXT", help="what the scene is (default: what the file's head says)")
    add_granularity(parser)
    _add_optimisation(parser.add_argument_group("the optimisation"))
    add_models(parser)
    parser.add_argument("--model", metavar="NAME", help="the multi-view model (MVDream/MVDream), or a folder")
    parser.add_argument("--scene-model", metavar="NAME", help="the model of single pictures for the whole scene")
    parser.add_argument("--control", metavar="NAME", help="its ControlNet for depth, or a folder")
    parser.add_argument("--no-scene-term", action="store_true", help="learn each thing for itself; poses stay")
    parser.add_argument("--half", action="store_true", help="models in half precision (the default on a GPU)")
    add_common(parser)
    parser.set_defaults(run=distill)


def _add_optimisation(group: Any) -> None:
    weightings = ("reconstruction", "sds", "uniform")
    group.add_argument("--steps", type=whole, default=2000, metavar="N", help="for each thing to learn (2000)")
    group.add_argument("--budget", type=amount, metavar="MINUTES", help="end by then, the annealing with it")
    group.add_argument("--gaussians", type=whole, default=20_000, metavar="N", help="of each thing at most (20,000)")
    group.add_argument("--guidance", type=float, default=50.0, metavar="X", help="what a sentence counts (50)")
    group.add_argument("--weighting", choices=weightings, default="reconstruction", help="of the steps of noise")
    group.add_argument("--start", metavar="DIR", help="take over the things of an earlier run that are the same")
    group.add_argument("--resume", action="store_true", help="go on with the run in the folder")
    group.add_argument("--force", action="store_true", help="begin anew where the folder holds a run")
    group.add_argument("--film", metavar="OUT", help="also write a film of what was learned: .mp4 .gif .webp .apng")


def distill(arguments: argparse.Namespace) -> int:
    from scenelang import neural
    from scenelang.backends.neural.distillation.learning import DistillationSettings
    from scenelang.backends.pictures.film import FPS, check_film
    from scenelang.embeddings import Embeddings
    from scenelang.inversion import RunFolder

    with usage_errors():
        run = RunFolder(arguments.output, arguments.resume, arguments.force, arguments.start)
        settings = DistillationSettings.of(
            arguments.steps, arguments.gaussians, arguments.guidance, arguments.weighting, arguments.seed
        )
    if arguments.film is not None:  # before the work, so that typos are cheap
        check_film(Path(arguments.film), FPS)
        check_folder(Path(arguments.film))
    scene = scene_of(arguments)
    if scene is None:
        return 1
    networks = neural.DistillationModels(
        arguments.model, arguments.scene_model, arguments.control, not arguments.no_scene_term, arguments.half
    )
    budget = None if arguments.budget is None else 60.0 * arguments.budget
    found = finished(arguments, partial(
        neural.distill, scene, run, prompt=arguments.prompt, template=arguments.template,
        granularity=granularity_of(arguments), settings=settings, networks=networks, budget=budget,
        embeddings=Embeddings(z_path(arguments)),
    ))  # fmt: skip
    film = [] if arguments.film is None else [found.film(scene).save(arguments.film)]
    done(arguments, *found.files, *film)
    return 0
