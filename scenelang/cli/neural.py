"""The commands of neural models, and the options that they share."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from scenelang import inversion, neural
from scenelang.backends.neural.distillation.learning import DistillationSettings
from scenelang.backends.neural.distillation.sds import Guiding
from scenelang.backends.neural.inversion import InversionSettings
from scenelang.backends.neural.sentences import Granularity
from scenelang.backends.pictures.camera import parse_viewpoint
from scenelang.backends.pictures.film import FPS, check_film
from scenelang.cli.options import (
    UsageError,
    add_camera,
    add_common,
    add_fields,
    add_models,
    fields_of,
    given,
    models_of,
    reader,
    scene_of,
    session_limit,
    usage_errors,
    whole,
    z_path,
)
from scenelang.cli.output import check_folder, done, progress, tell, warnings
from scenelang.embeddings import (
    Embeddings,
    attribute_of,
    check_export,
    check_program,
    handle_name,
    rows_table,
    similar_table,
)
from scenelang.grammar.diagnostics import SceneError
from scenelang.grammar.settings import amount, settings_in
from scenelang.inversion import InversionModels, PictureSubject, RunFolder
from scenelang.neural import DistillationModels, ImagineSettings
from scenelang.reports import print_json, say
from scenelang.sandbox.supervision import interruptions
from scenelang.zfile import beside

if TYPE_CHECKING:
    from scenelang.backends.language_models.catalogue import ImageContent
    from scenelang.inversion import Inversion
    from scenelang.neural import Distillation
    from scenelang.scene import Scene


Learned = TypeVar("Learned", "Inversion", "Distillation")
_ENTITY_HELP = "a word, words down to it (tower/roof), places of children (0/2), or a handle"


# --- shared options --------------------------------------------------------------------------------------------------


def add_granularity(parser: Any) -> None:
    """Which entities are taken as one, and the sentence of each."""
    add_fields(parser, Granularity)
    parser.add_argument("--template", metavar="TEXT", help="the sentence, with {embedding}, {word} and {style}")


def granularity_of(arguments: argparse.Namespace) -> Granularity:
    return fields_of(arguments, Granularity)


def z_of(arguments: argparse.Namespace) -> Embeddings:
    """The file of embeddings to write: the one named, else that beside the program, which may not be there yet."""
    return Embeddings(z_path(arguments) or (None if arguments.file == "-" else beside(arguments.file)))


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
    parser.add_argument("-o", "--output", metavar="OUT", required=True, help=".png; .json for a layout")
    count = "so many pictures, OUT-1.png, OUT-2.png ..."
    parser.add_argument("--count", type=whole, default=1, metavar="N", help=count)
    parser.add_argument("--frame", type=whole, metavar="N", help="this frame of a 4D scene, from 0")
    add_camera(parser.add_argument_group("view"), "pixels (default: what the model was made for)")
    layout = parser.add_argument_group("layout")
    layout.add_argument("--layout-only", action="store_true", help="write the layout as .png or .json, use no model")
    add_granularity(layout)
    drawing = parser.add_argument_group("drawing")
    drawing.add_argument("--prompt", help="what it shows (default: as the file's first comment says, or the root)")
    add_fields(drawing, ImagineSettings, ("negative",))
    add_fields(drawing, ImagineSettings, [name for name in settings_in(ImagineSettings) if name != "negative"])
    add_models(parser)


def run_imagine(arguments: argparse.Namespace) -> int:
    output = Path(arguments.output)
    with usage_errors():
        neural.check_output(output, arguments.layout_only)
        neural.check_count(arguments.count)
        settings = fields_of(arguments, ImagineSettings)
        camera = parse_viewpoint(arguments.camera) if arguments.camera else None
        neural.check_size(camera, arguments.size)
    check_folder(output)
    scene = scene_of(arguments)
    asked = {
        "size": arguments.size, "frame": arguments.frame, "prompt": arguments.prompt, "template": arguments.template,
        "granularity": granularity_of(arguments), "embeddings": Embeddings(z_path(arguments)),
        "limit": session_limit(arguments), "warn": warnings(arguments),
    }  # fmt: skip
    if arguments.layout_only:
        layout = neural.imagine_layout(scene, camera, method=settings.method, **asked)
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
    parser.add_argument("--from", dest="picture", metavar="PICTURE", required=True, help="what shows them")
    entities = f"{_ENTITY_HELP}; may be repeated (default: all parts with names that can be seen in the picture)"
    parser.add_argument("--entity", action="append", default=[], metavar="WORD|'<z4>'", help=entities)
    add_fields(parser, PictureSubject, ("whole",))
    _add_inversion(parser)


def add_style(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--from", dest="picture", metavar="PICTURE", required=True, help="what has the style")
    parser.add_argument("--entity", metavar="WORD|'<z4>'", help=f"{_ENTITY_HELP} (default: the whole scene)")
    _add_inversion(parser)


def _add_inversion(parser: argparse.ArgumentParser) -> None:
    """The picture's part, the work, and the models."""
    part = parser.add_argument_group("what of the picture")
    add_fields(part, PictureSubject, ("text", "mask"))
    work = parser.add_argument_group("the optimisation")
    add_fields(work, PictureSubject, ("class_word", "style_word"))
    add_fields(work, InversionSettings)
    add_fields(work, RunFolder, ("folder", "resume", "force"))
    add_models(parser)
    add_fields(parser, InversionModels)


def run_invert(arguments: argparse.Namespace) -> int:
    return _inverted(arguments, partial(inversion.invert, entities=arguments.entity), arguments.entity)


def run_style(arguments: argparse.Namespace) -> int:
    return _inverted(arguments, partial(inversion.learn_style, entity=arguments.entity))


def _inverted(
    arguments: argparse.Namespace, learn: Callable[..., Inversion], entities: Sequence[str] | None = None
) -> int:
    """Learn from a picture; ``entities`` are those that the options about one entity may mean."""
    with usage_errors():
        run = fields_of(arguments, RunFolder)
        if arguments.file == "-" and (arguments.output is None or arguments.z is None):
            raise SceneError("value", "for a program from standard input say where the run and Z are: -o DIR --z FILE")
        subject = fields_of(arguments, PictureSubject)
        if entities is not None:
            subject.check_single(entities)
    z = z_of(arguments)
    scene = scene_of(arguments, fresh=not z.exists)
    settings = fields_of(arguments, InversionSettings, seed=arguments.seed)
    networks = fields_of(arguments, InversionModels)
    asked = {"subject": subject, "settings": settings, "networks": networks, "run": run, "embeddings": z}
    _tell(arguments, finished(arguments, partial(learn, scene, arguments.picture, **asked)))
    return 0


def invert_generated(
    arguments: argparse.Namespace, scene: Scene, pictures: Sequence[ImageContent], program: Path
) -> None:
    """Learn the named parts of a scene from the pictures that it was made of, into Z beside ``program``."""
    from io import BytesIO

    from scenelang.backends.neural.clip import open_picture

    shown = [open_picture(BytesIO(each.data)) for each in pictures]
    named = replace(scene, name=str(program))
    settings = InversionSettings(seed=arguments.seed)
    found = finished(
        arguments,
        partial(inversion.invert, named, shown, settings=settings, run=RunFolder(force=True), missing_ok=True),
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
    parser.add_argument("-o", "--output", metavar="DIR", required=True, help="the folder of the run")
    parser.add_argument("--prompt", metavar="TEXT", help="what the scene is (default: what the file's head says)")
    add_granularity(parser)
    work = parser.add_argument_group("the optimisation")
    add_fields(work, DistillationSettings, ("steps",))
    work.add_argument("--budget", type=reader(amount), metavar="MINUTES", help="end by then, the annealing with it")
    add_fields(work, DistillationSettings, ("most",))
    add_fields(work, Guiding)
    add_fields(work, RunFolder, ("start", "resume", "force"), force="begin anew where the folder holds a run")
    work.add_argument("--film", metavar="OUT", help="also write a film of what was learned: .mp4 .gif .webp .apng")
    add_models(parser)
    add_fields(parser, DistillationModels)


def run_distill(arguments: argparse.Namespace) -> int:
    with usage_errors():
        run = fields_of(arguments, RunFolder)
        asked = given(arguments, DistillationSettings) | given(arguments, Guiding)
        if "most" in asked:
            asked["gaussians"] = asked.pop("most")
        settings = DistillationSettings.of(seed=arguments.seed, **asked)
    if arguments.film is not None:  # before the work, so that typos are cheap
        check_film(Path(arguments.film), FPS)
        check_folder(Path(arguments.film))
    scene = scene_of(arguments)
    networks = fields_of(arguments, DistillationModels)
    budget = None if arguments.budget is None else 60.0 * arguments.budget
    found = finished(arguments, partial(
        neural.distill, scene, run, prompt=arguments.prompt, template=arguments.template,
        granularity=granularity_of(arguments), settings=settings, networks=networks, budget=budget,
        embeddings=Embeddings(z_path(arguments)),
    ))  # fmt: skip
    film = [] if arguments.film is None else [found.film(scene).save(arguments.film)]
    done(arguments, *found.files, *film)
    return 0


# The commands embeddings and embed: what Z says of a scene's embeddings, and what numbers say in words.


def add_embeddings(parser: argparse.ArgumentParser) -> None:
    actions = parser.add_subparsers(dest="action", required=True, metavar="ACTION")
    for name, (told, add, _) in _ACTIONS.items():
        action = actions.add_parser(name, help=told)
        add(action)
        add_common(action)


def run_embeddings(arguments: argparse.Namespace) -> int:
    run: Callable[[argparse.Namespace], int] = _ACTIONS[arguments.action][2]
    return run(arguments)


def _add_list(parser: argparse.ArgumentParser) -> None:
    """Nothing of its own."""


def _add_set(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("handle", metavar="'<z5>'", help="a handle as `tree` shows it")
    parser.add_argument("--text", help="the text of the embedding")
    named = "an attribute, such as color=[1,0,0]"
    parser.add_argument("--attribute", action="append", default=[], metavar="NAME=VALUE", help=named)
    parser.add_argument("--image", metavar="FILE", help="a picture, which gives the handle a vector (a pseudo-word)")
    parser.add_argument("--start", metavar="TEXT", help="the word that the picture's vector starts from (object)")
    parser.add_argument("--model", metavar="NAME", help="architecture/weights of OpenCLIP, or a folder, for --image")
    parser.add_argument("--clear", action="store_true", help="forget what Z says of the handle first")
    add_models(parser)


def _add_encode(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--model", metavar="NAME", help="architecture/weights of OpenCLIP, or a folder")
    add_granularity(parser)
    add_models(parser)


def _add_swap(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("handle", metavar="'<z2>'")
    parser.add_argument("other", metavar="'<z3>'")


def _add_similar(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("query", metavar="'<z2>'|TEXT|PICTURE")
    parser.add_argument("-n", "--number", type=whole, default=10, metavar="N", help="how many (default 10)")
    add_models(parser)


def _add_export(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("-o", "--output", metavar="OUT", required=True, help=".npz .safetensors .json")


def _list(arguments: argparse.Namespace) -> int:
    scene = scene_of(arguments)
    rows = Embeddings(z_path(arguments)).table(scene)
    return tell(arguments, [row.data() for row in rows], rows_table(rows))


def _set(arguments: argparse.Namespace) -> int:
    with usage_errors():
        name = handle_name(arguments.handle)
    if arguments.file != "-":
        check_program(arguments.file)
    z = z_of(arguments)
    path = z.place()
    if arguments.text is arguments.image is None and not arguments.attribute and not arguments.clear:
        raise UsageError("value", "nothing to set", "give --text, --attribute or --image")
    if arguments.start is not None and arguments.image is None:
        raise UsageError("value", "`--start` is the word that a picture's vector starts from: give one with --image")
    attributes = dict(map(_attribute, arguments.attribute))
    word = z.set(
        name, text=arguments.text, attributes=attributes, image=arguments.image, start=arguments.start,
        model=arguments.model, clear=arguments.clear, models=models_of(arguments),
    )  # fmt: skip
    if not arguments.quiet:
        told = f"; cosine {word.before:.3f} -> {word.cosine:.3f}" if word is not None else ""
        say(f"wrote {path}: <{name}>{told}")
    return 0


def _attribute(item: str) -> tuple[str, Any]:
    """The name and value of `NAME=VALUE`; raises UsageError."""
    key, sign, text = item.partition("=")
    if not sign or not key or not text.strip():
        raise UsageError("value", f"--attribute wants NAME=VALUE, got `{item}`")
    return key.lstrip(":").strip(), attribute_of(text)


def _swap(arguments: argparse.Namespace) -> int:
    with usage_errors():
        one, other = handle_name(arguments.handle), handle_name(arguments.other)
    z = Embeddings(z_path(arguments))
    z.swap(one, other)
    if not arguments.quiet:
        say(f"wrote {z.path}: <{one}> and <{other}> swapped; `encode` again if their sentences are needed")
    return 0


def _encode(arguments: argparse.Namespace) -> int:
    scene = scene_of(arguments)
    z = z_of(arguments)
    found = z.encode(
        scene, model=arguments.model, template=arguments.template, granularity=granularity_of(arguments),
        models=models_of(arguments),
    )  # fmt: skip
    if not arguments.quiet:
        count = sum(len(row.handles) for row in found.rows)
        say(f"wrote {z.path}: {len(found.rows):,} sentences of {count:,} embeddings, by {found.model}")
    return 0


def _similar(arguments: argparse.Namespace) -> int:
    found = Embeddings(z_path(arguments)).similar(arguments.query, arguments.number, models=models_of(arguments))
    return tell(arguments, [row.data() for row in found], similar_table(found))


def _export(arguments: argparse.Namespace) -> int:
    output = Path(arguments.output)
    with usage_errors():
        check_export(output)
    check_folder(output)
    done(arguments, Embeddings(z_path(arguments)).export(output))
    return 0


# The actions of ``embeddings``: help, what declares their arguments, and the work.
_ACTIONS: Mapping[str, tuple[str, Callable[[argparse.ArgumentParser], None], Callable[[argparse.Namespace], int]]] = {
    "list": ("every entity's handle, word, text and attributes", _add_list, _list),
    "set": ("give a handle a text, attributes or the vector of a picture", _add_set, _set),
    "encode": ("encode every primitive's sentence by OpenCLIP, and keep that in Z", _add_encode, _encode),
    "swap": ("exchange what Z says of two handles", _add_swap, _swap),
    "similar": ("what is most like a handle, a text or a picture", _add_similar, _similar),
    "export": ("write the vectors in Z for other programs", _add_export, _export),
}
