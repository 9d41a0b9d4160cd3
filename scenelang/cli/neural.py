"""Commands of neural models (imagine, invert, style, distill, embeddings), and their shared options."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from scenelang.backends.neural.distillation.terms import Guidance
from scenelang.backends.neural.distillation.training import DistillationSettings
from scenelang.backends.neural.inversion import InversionSettings
from scenelang.backends.neural.prompts import Granularity
from scenelang.backends.pictures.declared import view_of
from scenelang.backends.pictures.film import FPS, check_film
from scenelang.cli.options import (
    UsageError,
    add_camera,
    add_common,
    add_fields,
    add_models,
    check_folder,
    done,
    fields_of,
    given,
    models_of,
    print_result,
    progress,
    reader,
    report,
    scene_of,
    session_limit,
    usage_errors,
    warnings,
    whole,
    z_path,
)
from scenelang.console.reports import print_json, say
from scenelang.files import beside
from scenelang.grammar.diagnostics import Diagnostic, SceneError, suggest
from scenelang.grammar.settings import amount, settings_in
from scenelang.learning import inversion, neural
from scenelang.learning.embeddings import (
    Embeddings,
    attribute_of,
    check_export,
    check_program,
    handle_name,
    rows_table,
    similar_table,
)
from scenelang.learning.inversion import InversionModels, PictureSubject, RunFolder
from scenelang.learning.neural import DistillationModels, ImagineSettings
from scenelang.sandbox.supervision import interruptions

if TYPE_CHECKING:
    from scenelang.backends.language_models.catalogue import ImageContent
    from scenelang.learning.inversion import Inversion
    from scenelang.learning.neural import Distillation
    from scenelang.session.loaded import LoadedScene


Learned = TypeVar("Learned", "Inversion", "Distillation")
_ENTITY_HELP = "entity to learn: a word, a path of words (tower/roof) or of child indices (0/2), or a handle"


# --- shared options --------------------------------------------------------------------------------------------------


def add_granularity(parser: Any) -> None:
    """Add the options for grouping entities and for the prompt template."""
    add_fields(parser, Granularity)
    parser.add_argument("--template", metavar="TEXT", help="prompt template with {embedding}, {word} and {style}")


def granularity_of(arguments: argparse.Namespace) -> Granularity:
    """Return the options for grouping entities."""
    return fields_of(arguments, Granularity)


def z_of(arguments: argparse.Namespace) -> Embeddings:
    """Return the embeddings file to write: the given one, else the one beside the program, which may not exist yet."""
    return Embeddings(z_path(arguments) or (None if arguments.file == "-" else beside(arguments.file)))


def finished(arguments: argparse.Namespace, learn: Callable[..., Learned]) -> Learned:
    """Train with progress output; Ctrl-C saves the run and ends the command."""
    with interruptions() as stop:
        learned = learn(
            models=models_of(arguments), on_start=_say_start(arguments), on_step=_say_step(arguments), stop=stop
        )
    if not learned.finished:
        print(f"saved to {learned.folder}; continue with `--resume`", file=sys.stderr)
        raise KeyboardInterrupt
    return learned


def _say_start(arguments: argparse.Namespace) -> Callable[[Any], None] | None:
    """Return a callback that prints what will be trained, or None when quiet."""

    def show(start: Any) -> None:
        """Print what will be trained."""
        sentences = getattr(start, "sentences", ())
        for line in (str(start), *(f"  {sentence}" for sentence in sentences if arguments.verbose)):
            print(line, end="\n" if line else "", file=sys.stderr)

    return None if arguments.quiet else show


def _say_step(arguments: argparse.Namespace) -> Callable[[Any], None] | None:
    """Return a callback that updates the line of losses on a terminal, or None elsewhere."""

    def show(state: Any) -> None:
        """Replace the line by the state of a step."""
        sys.stderr.write(f"\r{state}\033[K" + ("\n" if state.share >= 1.0 else ""))
        sys.stderr.flush()

    return None if arguments.quiet or not sys.stderr.isatty() else show


# --- imagine ---------------------------------------------------------------------------------------------------------


def add_imagine(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``imagine``."""
    parser.add_argument(
        "-o", "--output", metavar="OUT", required=True, help="output image (.png), or layout (.png, .json)"
    )
    count = "number of images, written to OUT-1.png, OUT-2.png ..."
    parser.add_argument("--count", type=whole, default=1, metavar="N", help=count)
    parser.add_argument("--frame", type=whole, metavar="N", help="frame of a 4D scene, counted from 0")
    add_camera(parser.add_argument_group("view"), "image size in pixels (default: the model's native size)")
    layout = parser.add_argument_group("layout")
    layout.add_argument(
        "--layout-only", action="store_true", help="only write the layout as .png or .json, without using a model"
    )
    add_granularity(layout)
    drawing = parser.add_argument_group("generation")
    drawing.add_argument("--prompt", help="text prompt (default: the file's first comment, or the root word)")
    add_fields(drawing, ImagineSettings, ("negative",))
    add_fields(drawing, ImagineSettings, [name for name in settings_in(ImagineSettings) if name != "negative"])
    add_models(parser)


def run_imagine(arguments: argparse.Namespace) -> int:
    """Generate images of a scene by a diffusion model, or write the layout."""
    output = Path(arguments.output)
    with usage_errors():
        neural.check_output(output, arguments.layout_only)
        neural.check_count(arguments.count)
        settings = fields_of(arguments, ImagineSettings)
        camera = view_of(arguments.camera) if arguments.camera else None
        neural.check_size(camera, arguments.size)
    check_folder(output)
    scene = scene_of(arguments)
    kwargs = {
        "size": arguments.size, "frame": arguments.frame, "prompt": arguments.prompt, "template": arguments.template,
        "granularity": granularity_of(arguments), "embeddings": Embeddings(z_path(arguments)),
        "limit": session_limit(arguments), "warn": warnings(arguments),
    }  # fmt: skip
    if arguments.layout_only:
        layout = neural.imagine_layout(scene, camera, method=settings.method, **kwargs)
        done(arguments, layout.save(output))
        return 0
    pictures = neural.imagine(
        scene, camera, seed=arguments.seed, count=arguments.count, settings=settings, models=models_of(arguments),
        progress=progress(arguments, "imagining"), **kwargs,
    )  # fmt: skip
    for picture, path in zip(pictures, pictures.paths(output)):
        done(arguments, picture.save(path))
    return 0


# --- invert, style ---------------------------------------------------------------------------------------------------


def add_invert(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``invert``."""
    parser.add_argument("--from", dest="picture", metavar="PICTURE", required=True, help="input image of the entities")
    entities = f"{_ENTITY_HELP}; may be repeated (default: all named parts that are visible in the image)"
    parser.add_argument("--entity", action="append", default=[], metavar="WORD|'<z4>'", help=entities)
    add_fields(parser, PictureSubject, ("whole",))
    _add_inversion(parser)


def add_style(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``style``."""
    parser.add_argument("--from", dest="picture", metavar="PICTURE", required=True, help="input image with the style")
    parser.add_argument("--entity", metavar="WORD|'<z4>'", help=f"{_ENTITY_HELP} (default: the whole scene)")
    _add_inversion(parser)


def _add_inversion(parser: argparse.ArgumentParser) -> None:
    """Add the options for the image region, the optimization and the models."""
    part = parser.add_argument_group("image region")
    add_fields(part, PictureSubject, ("text", "mask"))
    work = parser.add_argument_group("optimization")
    add_fields(work, PictureSubject, ("class_word", "style_word"))
    add_fields(work, InversionSettings)
    add_fields(work, RunFolder, ("folder", "resume", "force"))
    add_models(parser)
    add_fields(parser, InversionModels)


def run_invert(arguments: argparse.Namespace) -> int:
    """Learn embeddings of entities from an image."""
    return _inverted(arguments, partial(inversion.invert, entities=arguments.entity), arguments.entity)


def run_style(arguments: argparse.Namespace) -> int:
    """Learn the style of an image."""
    return _inverted(arguments, partial(inversion.learn_style, entity=arguments.entity))


def _inverted(
    arguments: argparse.Namespace, learn: Callable[..., Inversion], entities: Sequence[str] | None = None
) -> int:
    """Learn from an image; ``entities`` are the entities that the single-entity options could apply to."""
    with usage_errors():
        run = fields_of(arguments, RunFolder)
        if arguments.file == "-" and (arguments.output is None or arguments.z is None):
            raise SceneError("value", "a program from standard input requires -o DIR and --z FILE")
        subject = fields_of(arguments, PictureSubject)
        if entities is not None:
            subject.check_single(entities)
    z = z_of(arguments)
    scene = scene_of(arguments, fresh=not z.exists)
    settings = fields_of(arguments, InversionSettings, seed=arguments.seed)
    networks = fields_of(arguments, InversionModels)
    kwargs = {"subject": subject, "settings": settings, "networks": networks, "run": run, "embeddings": z}
    _tell(arguments, finished(arguments, partial(learn, scene, arguments.picture, **kwargs)))
    return 0


def invert_generated(
    arguments: argparse.Namespace, scene: LoadedScene, pictures: Sequence[ImageContent], program: Path
) -> None:
    """Learn the named parts of a generated scene from its input images, into the embeddings file of ``program``."""
    from io import BytesIO

    from scenelang.backends.pictures.film import open_image

    shown = [open_image(BytesIO(picture.data)) for picture in pictures]
    named = replace(scene, name=str(program))
    settings = InversionSettings(seed=arguments.seed)
    inverted = finished(
        arguments,
        partial(inversion.invert, named, shown, settings=settings, run=RunFolder(force=True), missing_ok=True),
    )
    if inverted.parts and not arguments.json:
        _tell(arguments, inverted)


def _tell(arguments: argparse.Namespace, inverted: Inversion) -> None:
    """Report where the embeddings were stored, and how much better the prompts match the images."""
    if arguments.json:
        print_json(inverted.data())
    elif not arguments.quiet:
        say(f"wrote {inverted.embeddings.path}: {inverted}")


# --- distill ---------------------------------------------------------------------------------------------------------


def add_distill(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``distill``."""
    parser.add_argument("-o", "--output", metavar="DIR", required=True, help="run folder")
    parser.add_argument("--prompt", metavar="TEXT", help="text prompt (default: the comment at the head of the file)")
    add_granularity(parser)
    work = parser.add_argument_group("optimization")
    add_fields(work, DistillationSettings, ("steps",))
    work.add_argument(
        "--budget", type=reader(amount), metavar="MINUTES", help="time budget; the timestep annealing is fitted to it"
    )
    add_fields(work, DistillationSettings, ("max_gaussians",))
    add_fields(work, Guidance)
    add_fields(work, RunFolder, ("start", "resume", "force"), force="overwrite an existing run")
    work.add_argument("--film", metavar="OUT", help="also render the result to a video: .mp4 .gif .webp .apng")
    add_models(parser)
    add_fields(parser, DistillationModels)


def run_distill(arguments: argparse.Namespace) -> int:
    """Optimize Gaussians of a scene by score distillation."""
    with usage_errors():
        run = fields_of(arguments, RunFolder)
        kwargs = given(arguments, DistillationSettings) | given(arguments, Guidance)
        for name, argument in (("max_gaussians", "gaussians"), ("scale", "guidance")):
            if name in kwargs:
                kwargs[argument] = kwargs.pop(name)
        settings = DistillationSettings.of(seed=arguments.seed, **kwargs)
    if arguments.film is not None:  # fail early, before the expensive work
        check_film(Path(arguments.film), FPS)
        check_folder(Path(arguments.film))
    scene = scene_of(arguments)
    networks = fields_of(arguments, DistillationModels)
    budget = None if arguments.budget is None else 60.0 * arguments.budget
    distilled = finished(arguments, partial(
        neural.distill, scene, run, prompt=arguments.prompt, template=arguments.template,
        granularity=granularity_of(arguments), settings=settings, networks=networks, budget=budget,
        embeddings=Embeddings(z_path(arguments)),
    ))  # fmt: skip
    film = [] if arguments.film is None else [distilled.film(scene).save(arguments.film)]
    done(arguments, *distilled.files, *film)
    return 0


# --- embeddings ------------------------------------------------------------------------------------------------------


def add_embeddings(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``embeddings``."""
    actions = parser.add_subparsers(dest="action", required=True, metavar="ACTION")
    for name, (summary, add, _) in _ACTIONS.items():
        action = actions.add_parser(name, help=summary)
        add(action)
        add_common(action)


def run_embeddings(arguments: argparse.Namespace) -> int:
    """Run an action on the embeddings file."""
    run: Callable[[argparse.Namespace], int] = _ACTIONS[arguments.action][2]
    return run(arguments)


def _add_list(parser: argparse.ArgumentParser) -> None:
    """Add no arguments."""


def _add_set(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``embeddings set``."""
    parser.add_argument("handle", metavar="'<z5>'", help="handle, as printed by `tree`")
    parser.add_argument("--text", help="text of the embedding")
    named = "attribute value, such as color=[1,0,0]"
    parser.add_argument("--attribute", action="append", default=[], metavar="NAME=VALUE", help=named)
    parser.add_argument("--image", metavar="FILE", help="image from which to learn a token embedding (pseudo-word)")
    parser.add_argument("--start", metavar="TEXT", help="word that initializes the token embedding (default: object)")
    parser.add_argument("--model", metavar="NAME", help="OpenCLIP model for --image: architecture/weights, or a folder")
    parser.add_argument("--clear", action="store_true", help="first remove the handle's existing entry")
    add_models(parser)


def _add_encode(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``embeddings encode``."""
    parser.add_argument("--model", metavar="NAME", help="OpenCLIP model: architecture/weights, or a folder")
    add_granularity(parser)
    add_models(parser)


def _add_swap(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``embeddings swap``."""
    parser.add_argument("handle", metavar="'<z2>'")
    parser.add_argument("other", metavar="'<z3>'")


def _add_similar(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``embeddings similar``."""
    parser.add_argument("query", metavar="'<z2>'|TEXT|PICTURE")
    parser.add_argument("-n", "--number", type=whole, default=10, metavar="N", help="number of results (default 10)")
    add_models(parser)


def _add_export(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``embeddings export``."""
    parser.add_argument("-o", "--output", metavar="OUT", required=True, help="output file: .npz .safetensors .json")


def _list(arguments: argparse.Namespace) -> int:
    """Print handle, word, text and attributes of every entity."""
    scene = scene_of(arguments)
    rows = Embeddings(z_path(arguments)).table(scene)
    return print_result(arguments, [row.data() for row in rows], rows_table(rows))


def _set(arguments: argparse.Namespace) -> int:
    """Change the entry of a handle."""
    with usage_errors():
        name = handle_name(arguments.handle)
    if arguments.file != "-":
        check_program(arguments.file)
    z = z_of(arguments)
    path = z.place()
    if arguments.text is arguments.image is None and not arguments.attribute and not arguments.clear:
        raise UsageError("value", "nothing to set", "give --text, --attribute or --image")
    if arguments.start is not None and arguments.image is None:
        raise UsageError("value", "`--start` requires --image")
    attributes = dict(map(_attribute, arguments.attribute))
    _warn_of_handle(arguments, name)
    word = z.set(
        name, text=arguments.text, attributes=attributes, image=arguments.image, start=arguments.start,
        model=arguments.model, clear=arguments.clear, models=models_of(arguments),
    )  # fmt: skip
    if not arguments.quiet:
        change = f"; cosine {word.before:.3f} -> {word.cosine:.3f}" if word is not None else ""
        say(f"wrote {path}: <{name}>{change}")
    return 0


def _warn_of_handle(arguments: argparse.Namespace, name: str) -> None:
    """Warn of a handle that no entity of the program has, to which an entry would belong."""
    plain = argparse.Namespace(**{**vars(arguments), "z": None})  # the file of entries may not be there yet
    rows = Embeddings(None).table(scene_of(plain))
    if any(row.handle == name for row in rows):
        return
    same = next((row.handle for row in rows if row.word == name), None)
    hint = f'the entity "{name}" has <{same}>' if same else suggest(name, [row.handle for row in rows])
    message = f"no entity of the program has the handle <{name}>"
    report(arguments, [Diagnostic("unused-entry", message, None, hint or "`list` prints the handles")])


def _attribute(item: str) -> tuple[str, Any]:
    """Split `NAME=VALUE` into name and value; raises UsageError."""
    key, sign, text = item.partition("=")
    if not sign or not key or not text.strip():
        raise UsageError("value", f"expected NAME=VALUE for --attribute, got `{item}`")
    return key.lstrip(":").strip(), attribute_of(text)


def _swap(arguments: argparse.Namespace) -> int:
    """Swap the entries of two handles."""
    with usage_errors():
        one, other = handle_name(arguments.handle), handle_name(arguments.other)
    z = Embeddings(z_path(arguments))
    z.swap(one, other)
    if not arguments.quiet:
        say(f"wrote {z.path}: <{one}> and <{other}> swapped; run `encode` again to update their prompt embeddings")
    return 0


def _encode(arguments: argparse.Namespace) -> int:
    """Encode the prompts of a scene, and store the vectors."""
    scene = scene_of(arguments)
    z = z_of(arguments)
    encodings = z.encode(
        scene, model=arguments.model, template=arguments.template, granularity=granularity_of(arguments),
        models=models_of(arguments),
    )  # fmt: skip
    if not arguments.quiet:
        count = sum(len(row.handles) for row in encodings.rows)
        say(f"wrote {z.path}: {len(encodings.rows):,} prompts of {count:,} embeddings encoded with {encodings.model}")
    return 0


def _similar(arguments: argparse.Namespace) -> int:
    """Print the embeddings most similar to a query."""
    similar = Embeddings(z_path(arguments)).similar(arguments.query, arguments.number, models=models_of(arguments))
    return print_result(arguments, [row.data() for row in similar], similar_table(similar))


def _export(arguments: argparse.Namespace) -> int:
    """Write the vectors to a file of another format."""
    output = Path(arguments.output)
    with usage_errors():
        check_export(output)
    check_folder(output)
    done(arguments, Embeddings(z_path(arguments)).export(output))
    return 0


# The actions of ``embeddings``: help, function that adds the arguments, function that runs it.
_ACTIONS: Mapping[str, tuple[str, Callable[[argparse.ArgumentParser], None], Callable[[argparse.Namespace], int]]] = {
    "list": ("list every entity's handle, word, text and attributes", _add_list, _list),
    "set": ("set the text, attributes or token embedding of a handle", _add_set, _set),
    "encode": ("encode every primitive's prompt with OpenCLIP and store the vectors", _add_encode, _encode),
    "swap": ("swap the entries of two handles", _add_swap, _swap),
    "similar": ("find the embeddings most similar to a handle, a text or an image", _add_similar, _similar),
    "export": ("export the vectors to another file format", _add_export, _export),
}
