"""The command imagine: pictures of a scene by a text-to-image model."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

from scenelang.cli.neural_options import add_models, device_of, shelf_of
from scenelang.cli.neural_scene import add_granularity, granularity_of, sayings_of, scene_prompt
from scenelang.cli.options import UsageError, add_common, add_file, usage_errors, whole
from scenelang.cli.output import progress, warnings
from scenelang.cli.pictures import add_camera, check_folder, done
from scenelang.cli.programs import evaluated_text, session_limit

if TYPE_CHECKING:
    from scenelang.backends.neural.imagine.sampling import Checkpoint, Order, Picture, Sketch
    from scenelang.backends.neural.sentences import PromptCondition
    from scenelang.interpreter.scene.entity import Scene

_SKETCH_SIZE = (512, 512)
_MOST_PICTURES = 1000


def add_imagine(subparsers: Any) -> None:
    parser = subparsers.add_parser("imagine", help="a picture of the scene by a text-to-image model")
    add_file(parser)
    parser.add_argument("-o", "--output", metavar="OUT", required=True, help=".png; .json for a layout")
    parser.add_argument(
        "--count", type=whole, default=1, metavar="N", help="so many pictures, OUT-1.png, OUT-2.png ..."
    )
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
    group.add_argument(
        "--method", choices=("regional", "gligen", "migc"), default="regional",
        help="how the layout is heeded: without training, by GLIGEN's weights, or by MIGC's",
    )  # fmt: skip
    group.add_argument("--strength", type=float, default=10.0, metavar="X", help="of regional attention (default 10)")
    group.add_argument("--model", metavar="NAME", help="a Stable Diffusion checkpoint of the hub, or a folder")
    group.add_argument("--migc", metavar="FILE", help="MIGC's weights")
    group.add_argument("--scheduler", choices=("own", "ddim"), default="own", help="the checkpoint's own, or DDIM")
    group.add_argument(
        "--control", nargs="?", const="", metavar="NAME", help="heed depth too, by a ControlNet of the hub, or a folder"
    )
    group.add_argument(
        "--control-scale", type=float, default=1.0, metavar="X", help="how much depth counts (default 1)"
    )


def imagine(arguments: argparse.Namespace) -> int:
    from scenelang.backends.base import frame_of

    output = Path(arguments.output)
    with usage_errors():
        _check(arguments, output)
    check_folder(output)
    result, text = evaluated_text(arguments)
    if result.scene is None:
        return 1
    if arguments.frame is not None:
        frame_of(result.scene, arguments.frame)
    if arguments.layout_only:
        _write_layout(arguments, result.scene, text, output)
        return 0
    _draw(arguments, result.scene, text, output)
    return 0


def _check(arguments: argparse.Namespace, output: Path) -> None:
    """Raises SceneError for what makes no sense, whatever the scene."""
    from scenelang.backends.neural.imagine.sampling import Sampling, check_sampling

    endings = (".png", ".json") if arguments.layout_only else (".png",)
    if output.suffix.lower() not in endings:
        hint = "a layout alone, --layout-only, can be .json too" if output.suffix.lower() == ".json" else None
        raise UsageError("backend", f"`{output.name}` is none of {' '.join(endings)}", hint)
    if not 1 <= arguments.count <= _MOST_PICTURES:
        raise UsageError("value", f"`--count` must be 1 to {_MOST_PICTURES:,}, not {arguments.count:,}")
    if not 0.0 <= arguments.strength <= 1e6:
        raise UsageError("value", f"`--strength` must be 0 to 1,000,000, not {arguments.strength:g}")
    check_sampling(Sampling(8, 8, arguments.steps, arguments.guidance, 0, arguments.control_scale), 1)


# --- layout ----------------------------------------------------------------------------------------------------------


def _sketch(arguments: argparse.Namespace, scene: Scene, size: tuple[int, int]) -> Sketch:
    from scenelang.backends.neural.imagine.sampling import most_for, sketch_of
    from scenelang.backends.pictures.camera import Camera, Viewpoint, parse_viewpoint
    from scenelang.backends.pictures.film import PictureOptions, check
    from scenelang.backends.pictures.stage import still

    with usage_errors():
        view = parse_viewpoint(arguments.camera) if arguments.camera else Viewpoint()
        own = (view.width, view.height) if isinstance(view, Camera) else size
        width, height = arguments.size or own
        check(PictureOptions(width=width, height=height), [])
    shot = still(scene, view, arguments.frame, width, height)
    most, limit = most_for(arguments.method), session_limit(arguments)
    return sketch_of(scene, shot, granularity_of(arguments), most, limit, warnings(arguments))


def _write_layout(arguments: argparse.Namespace, scene: Scene, text: str, output: Path) -> None:
    from scenelang.backends.files import write_json
    from scenelang.backends.neural.imagine.layout import layout_json, layout_picture
    from scenelang.backends.neural.sentences import written
    from scenelang.backends.pictures.film import save_picture

    sayings, _ = sayings_of(arguments)
    sketch = _sketch(arguments, scene, _SKETCH_SIZE)
    sentences = sketch.sentences(sayings)
    conditions = sketch.conditions(sentences)
    if output.suffix.lower() == ".json":
        prompt = written(sentences.of_scene(scene_prompt(arguments, text, scene)))
        write_json(output, layout_json(sketch.layout, conditions, sketch.truth, prompt))
    else:
        save_picture(layout_picture(sketch.layout, conditions), output)
    done(arguments, output)


# --- pictures --------------------------------------------------------------------------------------------------------


def _draw(arguments: argparse.Namespace, scene: Scene, text: str, output: Path) -> None:
    from dataclasses import replace

    from scenelang.backends.base import part_of
    from scenelang.backends.neural.imagine.sampling import Sampling, check_sampling
    from scenelang.backends.neural.imagine.sampling import imagine as one_picture

    checkpoint = _checkpoint(arguments)
    sketch = _sketch(arguments, scene, checkpoint.size)
    width, height = sketch.layout.width, sketch.layout.height
    sampling = Sampling(
        width, height, arguments.steps, arguments.guidance, arguments.seed % (1 << 32), arguments.control_scale
    )
    check_sampling(sampling, checkpoint.factor)
    order, told = _order(arguments, checkpoint, sketch, scene_prompt(arguments, text, scene))
    shown = progress(arguments, "imagining")
    count = arguments.count
    for number in range(count):
        path = output if count == 1 else output.with_name(f"{output.stem}-{number + 1}{output.suffix}")
        own = replace(sampling, seed=(sampling.seed + number) % (1 << 32))
        part = part_of(shown, number / count, (number + 1) / count)
        _save(one_picture(checkpoint, sketch, order, own, part), path, told | {"seed": own.seed})
        done(arguments, path)


def _checkpoint(arguments: argparse.Namespace) -> Checkpoint:
    from scenelang.backends.neural.imagine import migc, regional, sampling

    default = {"gligen": regional.MODEL, "migc": migc.MODEL}.get(arguments.method, sampling.MODEL)
    name = arguments.model or default
    return sampling.load_checkpoint(name, shelf_of(arguments), device_of(arguments), arguments.scheduler)


def _order(
    arguments: argparse.Namespace,
    checkpoint: Checkpoint,
    sketch: Sketch,
    asked: str,
) -> tuple[Order, dict[str, Any]]:
    """What is to be drawn, and what the pictures say of it."""
    from dataclasses import replace

    from scenelang.backends.neural.imagine.layout import layout_json
    from scenelang.backends.neural.imagine.migc import WEIGHTS, load_migc
    from scenelang.backends.neural.imagine.sampling import (
        CONTROL,
        Order,
        load_control,
        readable_vectors,
        warn_of_unread,
    )
    from scenelang.backends.neural.sentences import written

    sayings, vectors = sayings_of(arguments)
    read = readable_vectors(checkpoint, vectors)
    sentences = sketch.sentences(replace(sayings, learned=frozenset(read)))
    conditions: list[PromptCondition] = sketch.conditions(sentences)
    warn_of_unread(conditions, sketch.handles[0], vectors, read, warnings(arguments))
    prompt = sentences.of_scene(asked)
    shelf = shelf_of(arguments)
    migc = load_migc(arguments.migc or WEIGHTS, shelf) if arguments.method == "migc" else None
    control_name = CONTROL if arguments.control == "" else arguments.control
    control = load_control(control_name, shelf, str(checkpoint.device)) if control_name else None
    order = Order(prompt, arguments.negative, conditions, read, arguments.method, arguments.strength, migc, control)
    told = {
        "file": Path(arguments.file).name,
        "model": checkpoint.name,
        "method": arguments.method,
        "control": control_name,
        "steps": arguments.steps,
        "guidance": arguments.guidance,
        "negative": arguments.negative,
        "layout": layout_json(sketch.layout, conditions, sketch.truth, written(prompt)),
    }
    return order, told


def _save(picture: Picture, path: Path, told: dict[str, Any]) -> None:
    """A PNG that says how it was made, written whole or not at all."""
    from importlib.metadata import version

    from scenelang.backends.base import need
    from scenelang.backends.files import written_whole

    notes = need("PIL.PngImagePlugin", "pillow").PngInfo()
    notes.add_text("Software", f"scenelang {version('scenelang')}")
    notes.add_text("scenelang", json.dumps(told))  # JSON in ASCII, as a text chunk wants it
    image = need("PIL.Image", "pillow").fromarray(picture)
    with written_whole(path) as temporary:
        image.save(temporary, "PNG", pnginfo=notes)


COMMANDS = (add_imagine,)
