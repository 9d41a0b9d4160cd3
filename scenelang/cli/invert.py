"""The commands invert and style: embeddings learned from a picture."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from scenelang.cli.inversion_options import add_inversion, place_of, way_of
from scenelang.cli.neural_options import device_of, shelf_of
from scenelang.cli.options import UsageError, add_common, add_file, session_of
from scenelang.cli.output import print_json, report_run, say
from scenelang.grammar.diagnostics import SceneError

if TYPE_CHECKING:
    from scenelang.backends.language_models.catalogue import ImageContent
    from scenelang.backends.neural.inversion import InversionOutcome, InversionTarget
    from scenelang.cli.inversion_work import InversionInput, Part, TargetPlace, Way
    from scenelang.interpreter.scene.entity import Scene

_ENTITY_HELP = "a word, words down to it (tower/roof), places of children (0/2), or a handle"


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
    add_inversion(parser)
    add_common(parser)
    parser.set_defaults(run=invert)


def add_style(subparsers: Any) -> None:
    parser = subparsers.add_parser("style", help="learn a style from a picture, for a scene or a part of it")
    add_file(parser)
    parser.add_argument("--from", dest="picture", metavar="PICTURE", required=True, help="what has the style")
    parser.add_argument("--entity", metavar="WORD|'<z4>'", help=f"{_ENTITY_HELP} (default: the whole scene)")
    add_inversion(parser)
    add_common(parser)
    parser.set_defaults(run=style)


# --- invert ----------------------------------------------------------------------------------------------------------


def invert(arguments: argparse.Namespace) -> int:
    from scenelang.backends.neural.inversion import style_handle
    from scenelang.cli.inversion_work import learn

    place = place_of(arguments, ".inversion")
    _check_options(arguments)
    scene = _scene(arguments, place.z)
    if scene is None:
        return 1
    targets = _targets(scene, arguments.entity)
    way = way_of(arguments)
    parts = _parts(arguments, way, place, targets)
    outcome = learn(way, place, parts, [style_handle(scene)])
    _tell(arguments, place, parts, [style_handle(scene)], outcome)
    return 0


def _check_options(arguments: argparse.Namespace) -> None:
    """Raises UsageError where options do not belong together."""
    if arguments.no_segment and (arguments.text or arguments.mask):
        raise UsageError("value", "`--no-segment` takes the whole picture: leave out --text and --mask")
    if arguments.text and arguments.mask:
        raise UsageError("value", "`--mask` says where the thing is, so there is nothing to look for: leave out --text")
    single = next((name for name in ("text", "mask", "class_word", "no_segment") if getattr(arguments, name)), None)
    if single is not None and len(arguments.entity) != 1:
        option = single.replace("_", "-")
        raise UsageError("value", f"`--{option}` is about one entity: name it with --entity")


def _targets(scene: Scene, names: Sequence[str]) -> list[InversionTarget]:
    from scenelang.backends.neural.inversion import named_parts, targets_named

    if not names:
        return named_parts(scene)
    targets = targets_named(scene, names)
    if any(target.whole for target in targets):
        hint = "`scenelang style` learns one from a picture"
        raise SceneError("value", "the embedding of the root is the style of the scene", hint=hint)
    claimed = [handle for target in targets for handle in target.handles]
    if len(set(claimed)) != len(claimed):
        raise SceneError("value", "two of the entities have an embedding in common, which can be learned once")
    return targets


def _parts(
    arguments: argparse.Namespace, way: Way, place: TargetPlace, targets: Sequence[InversionTarget]
) -> list[Part]:
    """What the picture shows of the targets; raises SceneError where that is nothing, or not all that was named."""
    from scenelang.cli.inversion_work import before_of, found_parts, kept_parts, masked_part

    kept = before_of(place)
    if kept is not None:
        return kept_parts(place, kept, targets)
    given = _given(arguments.picture)
    if arguments.no_segment or arguments.mask:
        mask = Path(arguments.mask) if arguments.mask else None
        return [masked_part(targets[0], given, mask, way.settings.seed)]
    texts = [arguments.text or target.text for target in targets]
    parts = found_parts(way, targets, texts, [given])
    missing = [text for target, text in zip(targets, texts) if target not in [part.target for part in parts]]
    if missing and (arguments.entity or not parts):
        hint = "say otherwise what to look for with --text, or where it is with --mask"
        raise SceneError("value", f'nothing in {given.name} looks like "{missing[0]}"', hint=hint)
    say_missing(arguments, missing)
    return parts


def say_missing(arguments: argparse.Namespace, missing: Sequence[str]) -> None:
    """Says which parts of the scene no picture shows."""
    if missing and not arguments.quiet:
        named = ", ".join(f'"{text}"' for text in missing)
        print(f"not found in the picture, so left as they are: {named}", file=sys.stderr)


def _given(path: str) -> InversionInput:
    from scenelang.backends.neural.clip import open_picture
    from scenelang.cli.inversion_work import InversionInput

    return InversionInput(Path(path).name, open_picture(path))


def _scene(arguments: argparse.Namespace, z: Path) -> Scene | None:
    """The scene of the command's program, with the packages at hand that its embeddings need. A file ``z`` that is not
    there yet will be written."""
    from scenelang.backends.base import need
    from scenelang.backends.neural.sentences import check_anything
    from scenelang.backends.neural.weights import INSTALL

    known = arguments if z.exists() else argparse.Namespace(**{**vars(arguments), "z": None, "file": "-"})
    session = session_of(known)
    result = session.evaluate(session.source(arguments.file))
    report_run(arguments, result)
    scene = result.scene
    if scene is not None:
        check_anything(scene)
    for package in ("torch", "diffusers", "transformers") if scene is not None else ():
        need(package, INSTALL)
    return scene


def _tell(
    arguments: argparse.Namespace,
    place: TargetPlace,
    parts: Sequence[Part],
    styles: Sequence[str],
    outcome: InversionOutcome,
) -> None:
    """Say what was stored, and how much better the sentences fit the pictures."""
    if arguments.json:
        print_json({
            "z": str(place.z), "loss": {"before": outcome.before, "after": outcome.after}, "style": list(styles),
            "parts": [{"text": part.word, "handles": list(part.target.handles)} for part in parts],
        })  # fmt: skip
    elif not arguments.quiet:
        learned = [name for part in parts for name in part.target.handles]
        shown = " ".join(f"<{handle}>" for handle in dict.fromkeys([*learned[:8], *styles[:8]]))
        say(f"wrote {place.z}: {shown}; loss {outcome.before:.4g} -> {outcome.after:.4g}")


# --- style -----------------------------------------------------------------------------------------------------------


def style(arguments: argparse.Namespace) -> int:
    from scenelang.cli.inversion_work import before_of, check_replaced, found_parts, kept_parts, learn, masked_part

    place = place_of(arguments, ".style")
    if arguments.text and arguments.mask:
        raise UsageError("value", "`--mask` says where the thing is, so there is nothing to look for: leave out --text")
    scene = _scene(arguments, place.z)
    if scene is None:
        return 1
    target = _styled(scene, arguments.entity)
    check_replaced(place, target.handles)
    way, kept = way_of(arguments), before_of(place)
    if kept is not None:
        parts = kept_parts(place, kept, [target])
    elif arguments.text:
        parts = found_parts(way, [target], [arguments.text], [_given(arguments.picture)])
    else:
        mask = Path(arguments.mask) if arguments.mask else None
        parts = [masked_part(target, _given(arguments.picture), mask, way.settings.seed)]
    if not parts:
        raise SceneError("value", f'nothing in {Path(arguments.picture).name} looks like "{arguments.text}"')
    outcome = learn(way, place, parts, target.handles, style_only=True)
    _tell(arguments, place, [], target.handles, outcome)
    return 0


def _styled(scene: Scene, name: str | None) -> InversionTarget:
    """The entity that gets a style: the root, or what a name says."""
    from scenelang.backends.neural.describing import thing
    from scenelang.backends.neural.inversion import InversionTarget, style_handle, targets_named

    if name is None:
        return InversionTarget(thing(scene.root), (style_handle(scene),), True)
    return targets_named(scene, [name])[0]


# --- after generate --------------------------------------------------------------------------------------------------


def invert_parts(arguments: argparse.Namespace, scene: Scene, pictures: Sequence[ImageContent], program: Path) -> None:
    """Learn the named parts of a scene from the pictures that it was made of, into Z beside ``program``.

    ``arguments`` hold the options of neural models. Raises SceneError; the program stays.
    """
    from io import BytesIO

    from scenelang.backends.neural.clip import open_picture
    from scenelang.backends.neural.inversion import InversionSettings, named_parts, style_handle
    from scenelang.cli.inversion_work import InversionInput, TargetPlace, Way, found_parts, learn
    from scenelang.zfile import beside

    targets = named_parts(scene)
    given = [
        InversionInput(f"picture {n}", open_picture(BytesIO(each.data))) for n, each in enumerate(pictures, start=1)
    ]
    way = Way(shelf_of(arguments), device_of(arguments), InversionSettings(seed=arguments.seed), quiet=arguments.quiet)
    place = TargetPlace(program.with_suffix(".inversion"), beside(str(program)), force=True)
    parts = found_parts(way, targets, [target.text for target in targets], given)
    seen = [part.target for part in parts]
    say_missing(arguments, [target.text for target in targets if target not in seen])
    if parts:
        outcome = learn(way, place, parts, [style_handle(scene)])
        if not arguments.json:
            _tell(arguments, place, parts, [style_handle(scene)], outcome)


COMMANDS = (add_invert, add_style)
