"""Text-to-image generation guided by a scene, and distillation of its primitives to 3D Gaussians.

See docs/imagine.md and docs/distillation.md.

Textual inversion is in ``scenelang.learning.inversion``, prompts and learned embeddings in
``scenelang.learning.embeddings``.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.base import Progress, frame_of, require, sub_progress
from scenelang.backends.neural.weights import INSTALL, Models
from scenelang.backends.pictures.camera import Camera as PlacedCamera
from scenelang.backends.pictures.images import Film, Size, View, picture_options, video_of
from scenelang.grammar.datum import dataclass, field, replace
from scenelang.grammar.diagnostics import Diagnostic, SceneError
from scenelang.grammar.settings import setting, typed, whole, within
from scenelang.learning.embeddings import Embeddings, tensors_of
from scenelang.learning.inversion import RunFolder
from scenelang.session.loaded import LoadedScene

if TYPE_CHECKING:
    from scenelang.backends.neural.clip import Prompt
    from scenelang.backends.neural.diffusion import DiffusionModel
    from scenelang.backends.neural.distillation.run import DistillationProgress, SavedDistillation
    from scenelang.backends.neural.distillation.training import (
        DistillationSettings,
        DistillationTrainer,
        SceneGroups,
        Teachers,
    )
    from scenelang.backends.neural.imagine.sampling import Checkpoint, GenerationRequest, Sampling, ShotLayout
    from scenelang.backends.neural.prompts import Granularity, PromptBuilder, PromptCondition
    from scenelang.backends.pictures.stage import Shot

Pixels = npt.NDArray[np.uint8]
Warn = Callable[[Diagnostic], None]
METHODS = ("regional", "gligen", "migc")
SCHEDULERS = ("own", "ddim")
_LAYOUT_SIZE = (512, 512)  # width and height in pixels of a layout without a camera
_MAX_IMAGES = 1000  # of one call


# --- imagine: settings -----------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class ImagineSettings:
    """Settings of text-to-image generation.

    Parameters
    ----------
    steps : int
        Number of denoising steps.
    guidance : float
        Classifier-free guidance scale; 1 disables guidance.
    negative : str
        Negative prompt.
    method : str
        Layout conditioning: "regional" (regional attention, training-free), "gligen" or "migc" (trained weights).
    strength : float
        Strength of regional attention.
    model : str, optional
        Stable Diffusion checkpoint on the hub, or a folder; default: that of the method.
    migc : path, optional
        Weights of MIGC.
    scheduler : str
        "own" for the checkpoint's scheduler, or "ddim".
    control : str, optional
        Depth ControlNet on the hub, or a folder; "" selects the default one, None disables it.
    control_scale : float
        Conditioning scale of the ControlNet.

    Raises
    ------
    SceneError
        If a number is out of range or a name is unknown.

    Examples
    --------
    >>> ImagineSettings(steps=30, guidance=9.0).scheduler
    'own'
    """

    steps: int = setting(50, "number of denoising steps (default 50)", metavar="N", read=whole)
    guidance: float = setting(
        7.5, "classifier-free guidance scale (default 7.5)", metavar="X", read=within(0.0, 10_000.0)
    )
    negative: str = setting("", "negative prompt", metavar="TEXT")
    method: str = setting(
        "regional", "layout conditioning: training-free regional attention (default), GLIGEN or MIGC", choices=METHODS
    )
    strength: float = setting(
        10.0, "strength of regional attention (default 10)", metavar="X", read=within(0.0, 1000.0)
    )
    model: str | None = setting(None, "Stable Diffusion checkpoint on the hub, or a folder", metavar="NAME")
    migc: str | Path | None = setting(None, "weights file of MIGC", metavar="FILE")
    scheduler: str = setting("own", "scheduler: the checkpoint's own, or DDIM", choices=SCHEDULERS)
    control: str | None = setting(None, "depth ControlNet on the hub, or a folder", metavar="NAME", alone="")
    control_scale: float = setting(
        1.0, "conditioning scale of the ControlNet (default 1)", metavar="X", read=within(0.0, 100.0)
    )

    def __post_init__(self) -> None:
        """Raise SceneError for numbers out of range and unknown names."""
        from scenelang.backends.neural.imagine.sampling import check_sampling

        if not 0.0 <= self.strength <= 1e6:
            raise SceneError("value", f"expected `--strength` between 0 and 1,000,000, got {self.strength:g}")
        for option, name, known in (("method", self.method, METHODS), ("scheduler", self.scheduler, SCHEDULERS)):
            if name not in known:
                raise SceneError("value", f"unknown `--{option}` `{name}`; expected one of {', '.join(known)}")
        check_sampling(self.sampling((8, 8), 0), 1)

    def sampling(self, size: Size, seed: int) -> Sampling:
        """Return the sampling parameters of one image; ``size`` is (width, height)."""
        from scenelang.backends.neural.imagine.sampling import Sampling

        return Sampling(*size, self.steps, self.guidance, seed % (1 << 32), self.control_scale)


# --- imagine: results ------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class SceneLayout:
    """Layout that conditions a text-to-image model: boxes and prompts of the instances in an image.

    Attributes
    ----------
    size : (width, height)
        In pixels.
    """

    _shot_layout: ShotLayout
    _conditions: Sequence[PromptCondition]
    _prompts: PromptBuilder
    _prompt: str

    @property
    def size(self) -> Size:
        """Width and height in pixels."""
        return self._shot_layout.layout.width, self._shot_layout.layout.height

    @property
    def data(self) -> dict[str, Any]:
        """The prompt and all instances with box and prompt, as JSON data (docs/imagine.md)."""
        from scenelang.backends.neural.imagine.layout import layout_json
        from scenelang.backends.neural.prompts import prompt_text

        prompt = prompt_text(self._prompts.scene_prompt(self._prompt))
        return layout_json(self._shot_layout.layout, self._conditions, self._shot_layout.truth, prompt)

    @property
    def pixels(self) -> Pixels:
        """Visualization of the layout (H, W, 3), sRGB."""
        from scenelang.backends.neural.imagine.layout import layout_picture

        return layout_picture(self._shot_layout.layout, self._conditions)

    def save(self, path: str | Path) -> Path:
        """Write the visualization as .png, or the data as .json. Returns the path."""
        from scenelang.backends.files import write_json
        from scenelang.backends.pictures.film import save_picture

        target = Path(path)
        check_output(target, layout_only=True)
        if target.suffix.lower() == ".json":
            write_json(target, self.data)
        else:
            save_picture(self.pixels, target)
        return target

    def __repr__(self) -> str:
        return f"<SceneLayout {self.size[0]} x {self.size[1]}: {len(self._conditions):,} instances>"


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class ImaginedPicture:
    """An image generated by a text-to-image model.

    Attributes
    ----------
    pixels : (H, W, 3) uint8
        sRGB.
    seed : int
        Random seed of the image.
    notes : mapping
        Generation metadata: model, method, prompts, layout and settings, as JSON data.
    """

    pixels: Pixels
    seed: int
    notes: Mapping[str, Any] = field(repr=False)

    def save(self, path: str | Path) -> Path:
        """Write a .png with the generation metadata, atomically. Returns the path."""
        from importlib.metadata import version

        from scenelang.backends.files import atomic_write
        from scenelang.backends.pictures.film import SOFTWARE, png_text

        target = Path(path)
        check_output(target)
        # JSON in ASCII: a text chunk is Latin-1
        chunks = png_text({"Software": f"{SOFTWARE} {version('scenelang')}", "scenelang": json.dumps(self.notes)})
        image = require("PIL.Image", "pillow").fromarray(self.pixels)
        with atomic_write(target) as temporary:
            image.save(temporary, "PNG", pnginfo=chunks)
        return target

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> npt.NDArray[Any]:
        return np.asarray(self.pixels, dtype) if not copy else np.array(self.pixels, dtype)

    def _repr_png_(self) -> bytes:
        from scenelang.backends.pictures.film import png_of

        return png_of(self.pixels)

    def __repr__(self) -> str:
        return f"<ImaginedPicture {self.pixels.shape[1]} x {self.pixels.shape[0]}, seed {self.seed}>"


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class ImaginedPictures:
    """Images that are generated lazily, when iterated or saved, with consecutive seeds.

    Attributes
    ----------
    seeds : tuple of int
        Random seed of each image.
    notes : mapping
        Generation metadata shared by the images.
    """

    seeds: tuple[int, ...]
    notes: Mapping[str, Any]
    _checkpoint: Checkpoint
    _shot_layout: ShotLayout
    _request: GenerationRequest
    _sampling: Sampling
    _progress: Progress | None

    def __len__(self) -> int:
        return len(self.seeds)

    def __iter__(self) -> Iterator[ImaginedPicture]:
        from scenelang.backends.neural.imagine.sampling import imagine as generate

        for number, seed in enumerate(self.seeds):
            part = sub_progress(self._progress, number / len(self), (number + 1) / len(self))
            sampling = replace(self._sampling, seed=seed)
            pixels = generate(self._checkpoint, self._shot_layout, self._request, sampling, part)
            yield ImaginedPicture(pixels, seed, {**self.notes, "seed": seed})

    def paths(self, output: str | Path) -> list[Path]:
        """Return the output path of each image: ``output`` for one image, else OUT-1.png, OUT-2.png and so on."""
        path = Path(output)
        if len(self) == 1:
            return [path]
        return [path.with_name(f"{path.stem}-{number}{path.suffix}") for number in range(1, len(self) + 1)]

    def save(self, output: str | Path) -> list[Path]:
        """Generate and write all images, each as soon as it is finished. Returns their paths."""
        check_output(Path(output))
        return [picture.save(path) for picture, path in zip(self, self.paths(output), strict=True)]

    def __repr__(self) -> str:
        size = f"{self._sampling.width} x {self._sampling.height}"
        return f"<ImaginedPictures: {len(self):,} of {size} by {self._checkpoint.name}>"


# --- imagine ---------------------------------------------------------------------------------------------------------


@typed
def imagine(
    scene: LoadedScene,
    camera: View | None = None,
    *,
    size: Size | None = None,
    frame: int | None = None,
    seed: int = 0,
    count: int = 1,
    prompt: str | None = None,
    template: str | None = None,
    granularity: Granularity | None = None,
    settings: ImagineSettings | None = None,
    embeddings: Embeddings | str | Path | None = "auto",
    models: Models | None = None,
    limit: int = 2_000_000,
    progress: Progress | None = None,
    warn: Warn | None = None,
) -> ImaginedPictures:
    """Generate images of a scene with a text-to-image model conditioned on the scene's layout.

    Parameters
    ----------
    scene : LoadedScene
        Scene that provides the layout and the prompts of the instances.
    camera : Camera, optional
        Camera of the images; the default frames the whole scene.
    size : (width, height), optional
        Image size in pixels; default: that of a placed camera, else the model's native size.
    frame : int, optional
        Frame of a 4D scene, counted from 0.
    seed : int
        Random seed of the first image; further images use consecutive seeds.
    count : int
        Number of images, 1 to 1,000.
    prompt : str, optional
        Prompt of the whole image, which may contain handles; default: the program's first comment, else the root's
        word.
    template : str, optional
        Prompt template of an instance, with ``{embedding}``, ``{word}`` and ``{style}``.
    granularity : Granularity, optional
        Grouping of entities to instances; default: every primitive is an instance.
    settings : ImagineSettings, optional
        Model, steps, guidance and layout conditioning.
    embeddings : Embeddings or path, optional
        Texts and learned token embeddings; "auto": the file beside the program, None: disabled.
    models : Models, optional
        Location of the weights, and compute device.
    limit : int
        Maximum number of primitives to expand.
    progress : callable, optional
        Called with a fraction from 0 to 1; an exception raised by it cancels the generation.
    warn : callable, optional
        Called with a ``Diagnostic`` for instances and embeddings that cannot be used.

    Raises
    ------
    SceneError
        If weights are unavailable, an entity is not found, or an argument is invalid.

    Examples
    --------
    >>> imagine(scene, prompt="a beach at dusk", models=Models("weights")).save("beach.png")  # doctest: +SKIP
    [PosixPath('beach.png')]
    """
    from scenelang.backends.neural.imagine.sampling import check_sampling

    settings, models = settings or ImagineSettings(), models or Models()
    check_count(count)
    frame_of(scene.graph, frame)
    checkpoint = _checkpoint(settings, models)
    tell = warn or (lambda _: None)
    shot = _shot(scene, camera, size or _own_size(camera, checkpoint.size), frame)
    shot_layout = _shot_layout(scene, shot, granularity, settings.method, limit, tell)
    sampling = settings.sampling((shot_layout.layout.width, shot_layout.layout.height), seed)
    check_sampling(sampling, checkpoint.factor)
    z = Embeddings.of(scene, embeddings)
    prompts, conditions, vectors = _prompts(z, template, checkpoint, shot_layout, tell)
    resolved = prompts.scene_prompt(scene_prompt(scene, prompt))
    request = _request(checkpoint, settings, models, resolved, conditions, vectors)
    notes = _notes(scene, checkpoint, settings, shot_layout, request)
    seeds = tuple((sampling.seed + number) % (1 << 32) for number in range(count))
    return ImaginedPictures(seeds, notes, checkpoint, shot_layout, request, sampling, progress)


@typed
def imagine_layout(
    scene: LoadedScene,
    camera: View | None = None,
    *,
    size: Size | None = None,
    frame: int | None = None,
    prompt: str | None = None,
    template: str | None = None,
    granularity: Granularity | None = None,
    method: str = "regional",
    embeddings: Embeddings | str | Path | None = "auto",
    limit: int = 2_000_000,
    warn: Warn | None = None,
) -> SceneLayout:
    """Compute the layout that ``imagine`` would use, without a model. The arguments are those of ``imagine``.

    Examples
    --------
    >>> import scenelang as sl
    >>> scene = sl.evaluate('(bind "beach" (lambda () (union (call "moai" "weathered"))))')
    >>> imagine_layout(scene, size=(96, 64))
    <SceneLayout 96 x 64: 1 instances>
    """
    context, _ = Embeddings.of(scene, embeddings).prompt_context(template)
    image_size = size or _own_size(camera, _LAYOUT_SIZE)
    shot = _shot(scene, camera, image_size, frame)
    shot_layout = _shot_layout(scene, shot, granularity, method, limit, warn or (lambda _: None))
    prompts = shot_layout.prompts(context)
    return SceneLayout(shot_layout, shot_layout.conditions(prompts), prompts, scene_prompt(scene, prompt))


def scene_prompt(scene: LoadedScene, prompt: str | None = None) -> str:
    """Return the prompt of the whole scene: ``prompt``, else the program's first comment, else the root's word.

    A line `; task: ...` of the comment takes precedence; otherwise its first sentence is used, which usually describes
    the scene.
    """
    from scenelang.backends.neural.descriptions import noun_of
    from scenelang.reference.primer import stated_task

    if prompt is None and scene.program is not None:
        prompt = stated_task(scene.program.main.text)
    return prompt or noun_of(scene.root)


def check_count(count: int) -> None:
    """Check the number of images; raises SceneError("value") if it is out of range."""
    if not 1 <= count <= _MAX_IMAGES:
        raise SceneError("value", f"expected `--count` between 1 and {_MAX_IMAGES:,}, got {count:,}")


def check_output(output: Path, layout_only: bool = False) -> None:
    """Check the file extension of an output; raises SceneError("backend") if it is not supported."""
    endings = (".png", ".json") if layout_only else (".png",)
    if output.suffix.lower() not in endings:
        hint = "use --layout-only to write a layout as .json" if output.suffix.lower() == ".json" else None
        raise SceneError("backend", f"expected a file name ending in {' or '.join(endings)}, got `{output.name}`", hint)


def check_size(camera: View | None, size: Size | None) -> None:
    """Check the image size independently of the scene; raises SceneError("value") if it is too large."""
    from scenelang.backends.pictures.film import PictureOptions, check

    width, height = size or _own_size(camera, _LAYOUT_SIZE)
    check(PictureOptions(width=width, height=height), [])


def _own_size(camera: View | None, default: Size) -> Size:
    """Return the size of a placed camera, or the default."""
    return (camera.width, camera.height) if isinstance(camera, PlacedCamera) else default


def _shot(scene: LoadedScene, camera: View | None, size: Size, frame: int | None) -> Shot:
    """Return the camera and the frame of one image; raises SceneError for an invalid size."""
    from scenelang.backends.pictures.images import picture_options
    from scenelang.backends.pictures.stage import still

    check_size(camera, size)
    return still(scene.graph, picture_options(camera).camera, frame, *size)


def _shot_layout(
    scene: LoadedScene, shot: Shot, granularity: Granularity | None, method: str, limit: int, warn: Warn
) -> ShotLayout:
    """Return the layout of one image."""
    from scenelang.backends.neural.imagine.sampling import max_instances_of, shot_layout_of
    from scenelang.backends.neural.prompts import Granularity

    return shot_layout_of(scene.graph, shot, granularity or Granularity(), max_instances_of(method), limit, warn)


def _checkpoint(settings: ImagineSettings, models: Models) -> Checkpoint:
    """Load the checkpoint of the settings, by default that of the method."""
    from scenelang.backends.neural.imagine import layout, migc, sampling

    default = {"gligen": layout.DEFAULT_MODEL, "migc": migc.DEFAULT_MODEL}.get(settings.method, sampling.DEFAULT_MODEL)
    name = settings.model or default
    return sampling.load_checkpoint(name, models.hub(), models.resolve_device(), settings.scheduler)


def _prompts(
    z: Embeddings, template: str | None, checkpoint: Checkpoint, shot_layout: ShotLayout, warn: Warn
) -> tuple[PromptBuilder, list[PromptCondition], Mapping[str, Any]]:
    """Return the prompts, those of the instances, and the learned vectors that the checkpoint can use."""
    from scenelang.backends.neural.imagine.sampling import compatible_vectors, warn_incompatible_vectors

    context, vectors = z.prompt_context(template)
    compatible = compatible_vectors(checkpoint, vectors)
    prompts = shot_layout.prompts(replace(context, learned=frozenset(compatible)))
    conditions = shot_layout.conditions(prompts)
    warn_incompatible_vectors(conditions, shot_layout.handles[0], vectors, compatible, warn)
    return prompts, conditions, compatible


def _control_name(settings: ImagineSettings) -> str | None:
    """Return the ControlNet for depth, None for none; the option alone means the default."""
    from scenelang.backends.neural.imagine.sampling import DEFAULT_CONTROLNET

    return DEFAULT_CONTROLNET if settings.control == "" else settings.control


def _request(
    checkpoint: Checkpoint,
    settings: ImagineSettings,
    models: Models,
    prompt: Prompt,
    conditions: Sequence[PromptCondition],
    vectors: Mapping[str, Any],
) -> GenerationRequest:
    """Return the generation request, with the networks of its conditioning."""
    from scenelang.backends.neural.imagine.migc import WEIGHTS, load_migc
    from scenelang.backends.neural.imagine.sampling import GenerationRequest, load_control

    hub, control_name = models.hub(), _control_name(settings)
    migc = load_migc(str(settings.migc or WEIGHTS), hub) if settings.method == "migc" else None
    control = load_control(control_name, hub, str(checkpoint.device)) if control_name else None
    return GenerationRequest(
        prompt, settings.negative, conditions, vectors, settings.method, settings.strength, migc, control
    )


def _notes(
    scene: LoadedScene,
    checkpoint: Checkpoint,
    settings: ImagineSettings,
    shot_layout: ShotLayout,
    request: GenerationRequest,
) -> dict[str, Any]:
    """Return the metadata of images."""
    from scenelang.backends.neural.imagine.layout import layout_json
    from scenelang.backends.neural.prompts import prompt_text

    return {
        "file": Path(scene.name).name,
        "model": checkpoint.name,
        "method": settings.method,
        "control": _control_name(settings),
        "steps": settings.steps,
        "guidance": settings.guidance,
        "negative": settings.negative,
        "layout": layout_json(shot_layout.layout, request.conditions, shot_layout.truth, prompt_text(request.prompt)),
    }


# --- distill ---------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class DistillationModels:
    """Diffusion models that supervise the distillation.

    Parameters
    ----------
    model : str, optional
        Multi-view diffusion model, by name or as a folder; default ``MVDream/MVDream``.
    scene_model : str, optional
        Text-to-image model that supervises renderings of the whole scene.
    control : str, optional
        Depth ControlNet of the scene model.
    scene_term : bool
        Whether to supervise the whole scene as well. False: optimize each object separately with fixed poses.
    half : bool
        Load the models in half precision (default on a GPU).

    Examples
    --------
    >>> DistillationModels("my-model", scene_term=False).half
    False
    """

    model: str | None = setting(
        None, "multi-view diffusion model (default MVDream/MVDream), or a folder", metavar="NAME"
    )
    scene_model: str | None = setting(None, "text-to-image model for the whole scene", metavar="NAME")
    control: str | None = setting(None, "depth ControlNet of the scene model, or a folder", metavar="NAME")
    scene_term: bool = setting(True, "optimize each object separately, with fixed poses", "--no-scene-term")
    half: bool = setting(False, "half precision (default on a GPU)")


@dataclass(frozen=True, slots=True)
class DistillationStart:
    """Summary of a distillation run before it starts.

    ``things`` counts the objects in the scene, ``learned`` those to optimize, ``steps`` the remaining steps;
    ``prompts`` contains the prompt of each distinct object.
    """

    things: int
    learned: int
    steps: int
    folder: Path
    prompts: tuple[str, ...] = field(repr=False)

    def __str__(self) -> str:
        return f"{self.things:,} objects, {self.learned:,} to optimize, {self.steps:,} steps in {self.folder}"


@dataclass(frozen=True, slots=True, repr=False)
class Distillation:
    """Result of a distillation run.

    Attributes
    ----------
    folder : Path
        Run folder (docs/distillation.md); ``scene.render(quality="splats", settings={"distilled": str(folder)})``
        renders the result.
    start : DistillationStart
        Summary from the start of the run.
    files : tuple of Path
        Gaussians and poses; empty if the run is not ``finished``.
    finished : bool
        False if ``stop`` ended the run; resume it with ``RunFolder(folder, resume=True)``.
    """

    folder: Path
    start: DistillationStart
    files: tuple[Path, ...]
    finished: bool

    def film(self, scene: LoadedScene, size: Size = (256, 256)) -> Film:
        """Return a video of the result: a turntable of a static scene, or the frames of a 4D scene."""
        options = picture_options(size=size, settings={"distilled": str(self.folder)})
        return video_of(scene, options, "splats")

    def __repr__(self) -> str:
        state = "finished" if self.finished else "stopped"
        return f"<Distillation in {self.folder}: {self.start.things:,} objects, {state}>"


@typed
def distill(
    scene: LoadedScene,
    run: RunFolder,
    *,
    prompt: str | None = None,
    template: str | None = None,
    granularity: Granularity | None = None,
    settings: DistillationSettings | None = None,
    networks: DistillationModels | None = None,
    budget: float | None = None,
    embeddings: Embeddings | str | Path | None = "auto",
    models: Models | None = None,
    progress: Progress | None = None,
    on_start: Callable[[DistillationStart], None] | None = None,
    on_step: Callable[[DistillationProgress], None] | None = None,
    stop: Callable[[], bool] | None = None,
) -> Distillation:
    """Optimize the primitives of a scene as 3D Gaussians with score distillation from diffusion models.

    Parameters
    ----------
    scene : LoadedScene
        Scene to distill.
    run : RunFolder
        Run folder, and whether to resume an existing run.
    prompt, template, granularity, embeddings
        As in ``imagine``.
    settings : DistillationSettings, optional
        ``DistillationSettings.of(steps, gaussians, guidance, weighting, seed)``.
    networks : DistillationModels, optional
        Diffusion models.
    budget : float, optional
        Maximum duration of the optimization in seconds; the timestep annealing is fitted to it.
    models : Models, optional
        Location of the weights, and compute device.
    progress : callable, optional
        Called with a fraction from 0 to 1; an exception raised by it cancels the run.
    on_start, on_step : callable, optional
        Called with the summary before the first step, and with the losses after each step.
    stop : callable, optional
        Called before each step; if it returns True, the run is saved and ends, and can be resumed later.

    Raises
    ------
    SceneError
        If the folder contains a run that would be overwritten or one that cannot be resumed, weights are unavailable,
        nothing is left to optimize, or an argument is invalid.

    Examples
    --------
    >>> distill(scene, RunFolder("run"), models=Models("weights", device="cuda"))  # doctest: +SKIP
    <Distillation in run: 3 objects, finished>
    """
    from scenelang.backends.files import new_folder
    from scenelang.backends.neural.diffusion import translate_out_of_memory
    from scenelang.backends.neural.distillation.run import load_checkpoint, run_config, write_outcome
    from scenelang.backends.neural.distillation.run import run as run_steps
    from scenelang.backends.neural.distillation.training import DistillationSettings, group_leaves
    from scenelang.backends.neural.prompts import Granularity, leaves_of

    for package in ("torch", "diffusers", "open_clip"):
        require(package, INSTALL)
    context, vectors = Embeddings.of(scene, embeddings).prompt_context(template)
    scene_groups = group_leaves(leaves_of(scene.graph, granularity or Granularity(), context))
    settings, models = settings or DistillationSettings.of(), models or Models()
    folder = run.path(scene, ".distillation")
    before, device = _before(run, folder), models.resolve_device()
    resolved_prompt = scene_prompt(scene, prompt)
    with new_folder(folder), translate_out_of_memory():
        teachers = _teachers(networks or DistillationModels(), models, resolved_prompt, tensors_of(vectors, device))
        names = [teachers.multiview.name, *([teachers.scene.name] if teachers.scene is not None else [])]
        config = run_config(settings, names, resolved_prompt)
        trainer = _trainer(run, scene_groups, teachers, settings, device, before, config)
        start = _start(scene_groups, trainer, folder)
        if on_start is not None:
            on_start(start)
        finished = run_steps(
            trainer, folder, config, seconds=0.0 if before is None else before.seconds, budget=budget,
            on_step=_step_callback(progress, on_step), stop=stop or (lambda: False),
        )  # fmt: skip
    files = write_outcome(load_checkpoint(folder), scene_groups, folder) if finished else []
    return Distillation(folder, start, tuple(files), finished)


def _before(run: RunFolder, folder: Path) -> SavedDistillation | None:
    """Return the run to resume, or None; raises SceneError if it is missing, or would be overwritten."""
    from scenelang.backends.neural.distillation.run import CHECKPOINT, load_checkpoint

    if folder.exists() and not folder.is_dir():
        raise SceneError("file", f"`{folder}` cannot be a folder: it is a file")
    if run.resume:
        return load_checkpoint(folder)
    if (folder / CHECKPOINT).exists() and not run.force:
        hint = "use --resume to continue it, or --force to overwrite it"
        raise SceneError("file", f"{folder} already contains a run", hint=hint)
    return None


def _trainer(
    run: RunFolder,
    scene_groups: SceneGroups,
    teachers: Teachers,
    settings: DistillationSettings,
    device: str,
    before: SavedDistillation | None,
    config: Mapping[str, Any],
) -> DistillationTrainer:
    """Create the optimization, restored from the saved run ``before`` if given."""
    from scenelang.backends.neural.distillation.run import check_same
    from scenelang.backends.neural.distillation.training import DistillationTrainer

    if before is None:
        return DistillationTrainer(scene_groups, teachers, settings, device, _reused(run, scene_groups))
    check_same(before, scene_groups, config)
    trainer = DistillationTrainer(scene_groups, teachers, settings, device, before.frozen_states())
    trainer.restore(before.tensors)
    return trainer


def _reused(run: RunFolder, scene_groups: SceneGroups) -> dict[int, Any]:
    """Return the objects already optimized by an earlier run; raises SceneError if nothing is left to optimize."""
    if run.start is None:
        return {}
    from scenelang.backends.neural.distillation.run import load_checkpoint, unchanged_groups

    unchanged = unchanged_groups(load_checkpoint(Path(run.start)), scene_groups)
    if len(unchanged) == len(scene_groups.groups):
        raise SceneError("value", f"nothing to optimize: all objects are unchanged since {run.start}")
    return unchanged


def _teachers(networks: DistillationModels, models: Models, prompt: str, vectors: Mapping[str, Any]) -> Teachers:
    """Load the diffusion models that supervise a distillation."""
    from scenelang.backends.neural.diffusion_loading import load_multiview
    from scenelang.backends.neural.distillation.training import Teachers

    torch = require("torch", INSTALL)
    hub, device = models.hub(), models.resolve_device()
    dtype = torch.float16 if networks.half or device.startswith("cuda") else torch.float32
    named: dict[str, Any] = {} if networks.model is None else {"name": networks.model}
    multiview = load_multiview(hub=hub, device=device, dtype=dtype, **named)
    scene = _scene_model(networks, models, dtype) if networks.scene_term else None
    return Teachers(multiview, scene, vectors, (prompt,))


def _scene_model(networks: DistillationModels, models: Models, dtype: Any) -> DiffusionModel:
    """Load the depth-conditioned model of the whole scene."""
    from scenelang.backends.neural.diffusion_loading import load_depth

    named: dict[str, Any] = {} if networks.scene_model is None else {"name": networks.scene_model}
    hub, device = models.hub(), models.resolve_device()
    return load_depth(control=networks.control, hub=hub, device=device, dtype=dtype, **named)


def _start(scene_groups: SceneGroups, trainer: DistillationTrainer, folder: Path) -> DistillationStart:
    """Return the summary of a run before its first step."""
    remaining_steps = trainer.steps - trainer.step_number
    prompts = tuple(group.condition.plain for group in scene_groups.groups)
    return DistillationStart(len(scene_groups.instances), trainer.learned, remaining_steps, folder, prompts)


def _step_callback(
    progress: Progress | None, on_step: Callable[[DistillationProgress], None] | None
) -> Callable[[DistillationProgress], None]:
    """Combine both callbacks into one that is called after each step."""

    def report(state: DistillationProgress) -> None:
        if on_step is not None:
            on_step(state)
        if progress is not None:
            progress(state.share)

    return report
