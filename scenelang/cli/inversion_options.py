"""Options of the commands that learn pseudo-words from pictures."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from scenelang.cli.neural_options import add_models, device_of, shelf_of
from scenelang.cli.options import UsageError, whole, z_path

if TYPE_CHECKING:
    from scenelang.cli.inversion_work import TargetPlace, Way


def add_inversion(parser: argparse.ArgumentParser) -> None:
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
    add_grounding(parser)


def add_grounding(parser: argparse.ArgumentParser) -> None:
    """The networks that find things in pictures."""
    parser.add_argument("--detector", metavar="NAME", help="IDEA-Research/grounding-dino-base, or a folder")
    parser.add_argument("--segmenter", metavar="NAME", help="facebook/sam-vit-huge, or a folder")


def way_of(arguments: argparse.Namespace) -> Way:
    """How to learn, as the options say; raises SceneError for what makes no sense."""
    from scenelang.backends.neural.inversion import InversionSettings
    from scenelang.cli.inversion_work import Way

    for option, word in (("class-word", arguments.class_word), ("style-word", arguments.style_word)):
        if word is not None and not word.strip():
            raise UsageError("value", f"`--{option}` is a word to start from, not nothing")
    settings = InversionSettings(arguments.steps, arguments.rate, arguments.batch, arguments.seed)
    return Way(
        shelf_of(arguments), device_of(arguments), settings, arguments.model, arguments.detector, arguments.segmenter,
        arguments.class_word, arguments.style_word, arguments.quiet,
    )  # fmt: skip


def place_of(arguments: argparse.Namespace, ending: str) -> TargetPlace:
    """Where the run and Z are; raises UsageError for standard input without places."""
    from scenelang.cli.inversion_work import TargetPlace
    from scenelang.zfile import beside

    if arguments.resume and arguments.force:
        raise UsageError("value", "`--resume` goes on and `--force` begins anew: choose one")
    if arguments.file == "-" and (arguments.output is None or arguments.z is None):
        raise UsageError("value", "for a program from standard input say where the run and Z are: -o DIR --z FILE")
    folder = Path(arguments.output) if arguments.output else Path(arguments.file).with_suffix(ending)
    return TargetPlace(folder, z_path(arguments) or beside(arguments.file), arguments.resume, arguments.force)
