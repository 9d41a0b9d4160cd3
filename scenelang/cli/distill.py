"""The command distill: the Gaussians of every primitive learned from diffusion models."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from scenelang.cli.neural_options import add_models, device_of, shelf_of
from scenelang.cli.neural_scene import add_granularity, folder_of, granularity_of, sayings_of, scene_prompt, tensors_of
from scenelang.cli.options import UsageError, add_common, add_file, amount, whole
from scenelang.cli.pictures import check_folder, done
from scenelang.cli.programs import evaluated_text
from scenelang.grammar.diagnostics import SceneError

if TYPE_CHECKING:
    from scenelang.backends.neural.diffusion import Diffusion
    from scenelang.backends.neural.distillation.checkpoint import SavedDistillation
    from scenelang.backends.neural.distillation.learning import Cast, DistillationSettings, Learning, Teachers
    from scenelang.backends.neural.distillation.run import DistillationProgress
    from scenelang.interpreter.scene.entity import Scene

_MOST_GUIDANCE = 1e4
WEIGHTINGS = ("reconstruction", "sds", "uniform")


def add_distill(subparsers: Any) -> None:
    parser = subparsers.add_parser("distill", help="learn how primitives look as Gaussians, from diffusion models")
    add_file(parser)
    parser.add_argument("-o", "--output", metavar="DIR", required=True, help="the folder of the run")
    parser.add_argument("--prompt", metavar="TEXT", help="what the scene is (default: what the file's head says)")
    add_granularity(parser)
    _add_work(parser)
    _add_models(parser)
    add_common(parser)
    parser.set_defaults(run=distill)


def _add_work(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("the optimisation")
    group.add_argument("--steps", type=whole, default=2000, metavar="N", help="for each thing to learn (2000)")
    group.add_argument("--budget", type=amount, metavar="MINUTES", help="end by then, the annealing with it")
    group.add_argument("--gaussians", type=whole, default=20_000, metavar="N", help="of each thing at most (20,000)")
    group.add_argument("--guidance", type=float, default=50.0, metavar="X", help="what a sentence counts (50)")
    group.add_argument("--weighting", choices=WEIGHTINGS, default="reconstruction", help="of the steps of noise")
    group.add_argument("--start", metavar="DIR", help="take over the things of an earlier run that are the same")
    group.add_argument("--resume", action="store_true", help="go on with the run in the folder")
    group.add_argument("--force", action="store_true", help="begin anew where the folder holds a run")
    group.add_argument("--film", metavar="OUT", help="also write a film of what was learned: .mp4 .gif .webp .apng")


def _add_models(parser: argparse.ArgumentParser) -> None:
    add_models(parser)
    parser.add_argument("--model", metavar="NAME", help="the multi-view model (MVDream/MVDream), or a folder")
    parser.add_argument("--scene-model", metavar="NAME", help="the model of single pictures for the whole scene")
    parser.add_argument("--control", metavar="NAME", help="its ControlNet for depth, or a folder")
    parser.add_argument("--no-scene-term", action="store_true", help="learn each thing for itself; poses stay")
    parser.add_argument("--half", action="store_true", help="models in half precision (the default on a GPU)")


def distill(arguments: argparse.Namespace) -> int:
    from scenelang.backends.base import need
    from scenelang.backends.neural.weights import INSTALL

    if arguments.resume and arguments.force:
        raise UsageError("value", "`--resume` goes on and `--force` begins anew: choose one")
    if arguments.resume and arguments.start is not None:
        raise UsageError("value", "`--start` begins a run, and `--resume` knows what it took over: choose one")
    if not 0.0 <= arguments.guidance <= _MOST_GUIDANCE:
        raise UsageError("value", f"`--guidance` must be 0 to {_MOST_GUIDANCE:,.0f}, not {arguments.guidance:g}")
    if arguments.film is not None:
        from scenelang.backends.pictures.film import FPS, check_film

        check_film(Path(arguments.film), FPS)
        check_folder(Path(arguments.film))
    result, text = evaluated_text(arguments)
    if result.scene is None:
        return 1
    for package in ("torch", "diffusers", "open_clip"):
        need(package, INSTALL)
    return _learn(arguments, text, result.scene)


def _learn(arguments: argparse.Namespace, text: str, scene: Scene) -> int:
    from scenelang.backends.neural.diffusion import memory_told
    from scenelang.backends.neural.distillation.checkpoint import asked_of, check_same
    from scenelang.backends.neural.distillation.learning import Learning, cast_of
    from scenelang.backends.neural.distillation.run import run
    from scenelang.backends.neural.sentences import leaves_of
    from scenelang.cli.interruptions import interruptions

    sayings, vectors = sayings_of(arguments)
    cast = cast_of(leaves_of(scene, granularity_of(arguments), sayings))
    settings = _settings(arguments)
    folder = Path(arguments.output)
    if folder.exists() and not folder.is_dir():
        raise SceneError("file", f"`{folder}` cannot be a folder: it is a file")
    before = _before(arguments, folder)
    prompt = scene_prompt(arguments, text, scene)
    device = device_of(arguments)
    with memory_told():
        teachers = _teachers(arguments, prompt, tensors_of(vectors, device), device)
        names = [teachers.figures.name, *([teachers.scene.name] if teachers.scene is not None else [])]
        asked = asked_of(settings, names, prompt)
        if before is not None:
            check_same(before, cast, asked)
        frozen = _taken_over(arguments, cast) if before is None else before.frozen_states()
        learning = Learning(cast, teachers, settings, device, frozen)
        if before is not None:
            learning.restore(before.tensors)
        folder_of(arguments.output)
        _say(arguments, cast, learning)
        with interruptions() as stopped:
            used = before.seconds if before is not None else 0.0
            budget = None if arguments.budget is None else 60.0 * arguments.budget
            finished = run(
                learning, folder, asked, seconds=used, budget=budget, tell=_teller(arguments), stopped=stopped
            )
    if not finished:
        print(f"{folder} is kept; `--resume` goes on", file=sys.stderr)
        raise KeyboardInterrupt
    return _finish(arguments, scene, cast, folder)


def _settings(arguments: argparse.Namespace) -> DistillationSettings:
    from scenelang.backends.neural.distillation.learning import DistillationSettings

    if arguments.steps < 1 or arguments.gaussians < 16:
        raise UsageError("value", "there is at least 1 step, and 16 Gaussians")
    plain = DistillationSettings()
    first = min(plain.first, arguments.gaussians)
    guiding = replace(plain.guiding, guidance=arguments.guidance, weighting=arguments.weighting)
    scene_guiding = replace(plain.scene_guiding, guidance=arguments.guidance)
    seed = arguments.seed or 0
    return replace(
        plain, seed=seed, steps=arguments.steps, first=first, most=arguments.gaussians,
        every=max(1, min(plain.every, arguments.steps // 5)), guiding=guiding, scene_guiding=scene_guiding,
    )  # fmt: skip


def _before(arguments: argparse.Namespace, folder: Path) -> SavedDistillation | None:
    """The run that is to go on; raises SceneError where there is none, or one that would be lost."""
    from scenelang.backends.neural.distillation.checkpoint import STATE, kept_in

    if arguments.resume:
        return kept_in(folder)
    if (folder / STATE).exists() and not arguments.force:
        hint = "--resume goes on with it, --force begins anew"
        raise SceneError("file", f"{folder} holds a run already", hint=hint)
    return None


def _taken_over(arguments: argparse.Namespace, cast: Cast) -> dict[int, Any]:
    """The figures that an earlier run has learned; raises SceneError where that leaves nothing to do."""
    if arguments.start is None:
        return {}
    from scenelang.backends.neural.distillation.checkpoint import kept_in, same_figures

    found = same_figures(kept_in(Path(arguments.start)), cast)
    if len(found) == len(cast.figures):
        raise SceneError("value", f"everything in the scene is as in {arguments.start}, so there is nothing to learn")
    return found


def _teachers(arguments: argparse.Namespace, prompt: str, vectors: dict[str, Any], device: str) -> Teachers:
    from scenelang.backends.base import need
    from scenelang.backends.neural.diffusion_loading import load_multiview
    from scenelang.backends.neural.distillation.learning import Teachers
    from scenelang.backends.neural.weights import INSTALL

    torch = need("torch", INSTALL)
    dtype = torch.float16 if arguments.half or device.startswith("cuda") else torch.float32
    named = {} if arguments.model is None else {"name": arguments.model}
    figures = load_multiview(shelf=shelf_of(arguments), device=device, dtype=dtype, **named)
    scene = None if arguments.no_scene_term else _scene_model(arguments, device, dtype)
    return Teachers(figures, scene, vectors, (prompt,))


def _scene_model(arguments: argparse.Namespace, device: str, dtype: Any) -> Diffusion:
    from scenelang.backends.neural.diffusion_loading import load_depth

    named = {} if arguments.scene_model is None else {"name": arguments.scene_model}
    return load_depth(control=arguments.control, shelf=shelf_of(arguments), device=device, dtype=dtype, **named)


def _say(arguments: argparse.Namespace, cast: Cast, learning: Learning) -> None:
    if arguments.quiet:
        return
    left = learning.steps - learning.step_number
    print(
        f"{len(cast.actors):,} things, {learning.learned:,} to learn, {left:,} steps in {arguments.output}",
        file=sys.stderr,
    )
    for figure in cast.figures if arguments.verbose else ():
        print(f"  {figure.condition.plain}", file=sys.stderr)


def _teller(arguments: argparse.Namespace) -> Callable[[DistillationProgress], None]:
    """A line with the losses on a terminal."""
    if arguments.quiet or not sys.stderr.isatty():
        return lambda _: None

    def tell(told: DistillationProgress) -> None:
        losses = told.losses
        parts = f"figure {losses.figure:.4g}  scene {losses.scene:.4g}  layout {losses.layout:.3g}"
        sys.stderr.write(f"\r{100 * told.share:3.0f}%  step {told.done:,}/{told.steps:,}  {parts}\033[K")
        if told.share >= 1.0:
            sys.stderr.write("\n")
        sys.stderr.flush()

    return tell


def _finish(arguments: argparse.Namespace, scene: Scene, cast: Cast, folder: Path) -> int:
    """Write what the run is for."""
    from scenelang.backends.neural.distillation.checkpoint import kept_in
    from scenelang.backends.neural.distillation.run import write_outcome

    written = write_outcome(kept_in(folder), cast, folder)
    if arguments.film is not None:
        _write_film(scene, folder, Path(arguments.film))
        written.append(Path(arguments.film))
    done(arguments, *written)
    return 0


def _write_film(scene: Scene, run: Path, path: Path) -> None:
    """A turn around a static scene, or the frames of a 4D one."""
    from scenelang.backends.pictures.film import PictureOptions, painters, picture_backend, save_film
    from scenelang.backends.pictures.stage import film

    options = PictureOptions(width=256, height=256, settings={"distilled": str(run)})
    shots = film(scene, options.camera, options.width, options.height, None, None)
    save_film(painters(scene, options, [picture_backend("splats")], shots), shots, path)


COMMANDS = (add_distill,)
