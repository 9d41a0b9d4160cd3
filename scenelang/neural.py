"""Pictures of a scene by text-to-image models, and its things learned as Gaussians (docs/imagine.md, distillation.md).

Inversion of pictures is in ``scenelang.inversion``, the texts and vectors that models are told in
``scenelang.embeddings``.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.base import Progress, frame_of, need, part_of
from scenelang.backends.neural.weights import INSTALL, Models
from scenelang.backends.pictures.camera import Camera as PlacedCamera
from scenelang.backends.pictures.camera import Viewpoint
from scenelang.embeddings import Embeddings, tensors_of
from scenelang.grammar.diagnostics import Diagnostic, SceneError
from scenelang.grammar.settings import setting, whole
from scenelang.inversion import RunFolder
from scenelang.scene import Film, Scene, Size, View

if TYPE_CHECKING:
    from scenelang.backends.neural.diffusion import Diffusion
    from scenelang.backends.neural.distillation.learning import Cast, DistillationSettings, Learning, Teachers
    from scenelang.backends.neural.distillation.run import DistillationProgress, SavedDistillation
    from scenelang.backends.neural.imagine.sampling import Checkpoint, Order, Sampling, Sketch
    from scenelang.backends.neural.sentences import Granularity, PromptCondition, Sentences

Pixels = npt.NDArray[np.uint8]
Warn = Callable[[Diagnostic], None]
METHODS = ("regional", "gligen", "migc")
SCHEDULERS = ("own", "ddim")
_LAYOUT_SIZE = (512, 512)
_MAX_IMAGES = 1000


# --- imagine: what may be asked for ----------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class ImagineSettings:
    """How a text-to-image model draws a scene.

    Parameters
    ----------
    steps : int
        Steps of denoising.
    guidance : float
        The guidance scale; 1 is none.
    negative : str
        What the picture should not show.
    method : str
        How the layout is heeded: "regional" (without training), "gligen" or "migc" (by their weights).
    strength : float
        Of regional attention.
    model : str, optional
        A Stable Diffusion checkpoint of the hub, or a folder; default: that of the method.
    migc : path, optional
        MIGC's weights.
    scheduler : str
        "own", the checkpoint's, or "ddim".
    control : str, optional
        A ControlNet for depth, of the hub or a folder; "" is the default one, None none.
    control_scale : float
        How much depth counts.

    Raises
    ------
    SceneError
        A number out of its range, or a name that there is none of.

    Examples
    --------
    >>> ImagineSettings(steps=30, guidance=9.0).scheduler
    'own'
    """

    steps: int = setting(50, "steps of denoising (default 50)", metavar="N", read=whole)
    guidance: float = setting(7.5, "how much words count (default 7.5)", metavar="X", read=float)
    negative: str = setting("", "what it should not show", metavar="TEXT")
    method: str = setting(
        "regional", "how the layout is heeded: without training, by GLIGEN's weights, or by MIGC's", choices=METHODS
    )
    strength: float = setting(10.0, "of regional attention (default 10)", metavar="X", read=float)
    model: str | None = setting(None, "a Stable Diffusion checkpoint of the hub, or a folder", metavar="NAME")
    migc: str | Path | None = setting(None, "MIGC's weights", metavar="FILE")
    scheduler: str = setting("own", "the checkpoint's own, or DDIM", choices=SCHEDULERS)
    control: str | None = setting(
        None, "heed depth too, by a ControlNet of the hub, or a folder", metavar="NAME", alone=""
    )
    control_scale: float = setting(1.0, "how much depth counts (default 1)", metavar="X", read=float)

    def __post_init__(self) -> None:
        from scenelang.backends.neural.imagine.sampling import check_sampling

        if not 0.0 <= self.strength <= 1e6:
            raise SceneError("value", f"`--strength` must be 0 to 1,000,000, not {self.strength:g}")
        for option, name, known in (("method", self.method, METHODS), ("scheduler", self.scheduler, SCHEDULERS)):
            if name not in known:
                raise SceneError("value", f"`--{option}` is one of {', '.join(known)}, not `{name}`")
        check_sampling(self.sampling((8, 8), 0), 1)

    def sampling(self, size: Size, seed: int) -> Sampling:
        """One picture of ``size``, width and height."""
        from scenelang.backends.neural.imagine.sampling import Sampling

        return Sampling(*size, self.steps, self.guidance, seed % (1 << 32), self.control_scale)


# --- imagine: what comes of it ---------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class SceneLayout:
    """What a text-to-image model is told stands where.

    Attributes
    ----------
    size : (width, height)
        In pixels.
    """

    _sketch: Sketch
    _conditions: Sequence[PromptCondition]
    _sentences: Sentences
    _prompt: str

    @property
    def size(self) -> Size:
        return self._sketch.layout.width, self._sketch.layout.height

    @property
    def data(self) -> dict[str, Any]:
        """The prompt and every instance with its box and sentence, as JSON data (docs/imagine.md)."""
        from scenelang.backends.neural.imagine.layout import layout_json
        from scenelang.backends.neural.sentences import written

        prompt = written(self._sentences.of_scene(self._prompt))
        return layout_json(self._sketch.layout, self._conditions, self._sketch.truth, prompt)

    @property
    def pixels(self) -> Pixels:
        """The layout as a picture (H, W, 3), sRGB."""
        from scenelang.backends.neural.imagine.layout import layout_picture

        return layout_picture(self._sketch.layout, self._conditions)

    def save(self, path: str | Path) -> Path:
        """Write the picture as .png, or the data as .json. Returns its path."""
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
    """A picture by a text-to-image model.

    Attributes
    ----------
    pixels : (H, W, 3) uint8
        sRGB.
    seed : int
        What it was drawn with.
    notes : mapping
        How it was made: model, method, prompts, layout and settings, as JSON data.
    """

    pixels: Pixels
    seed: int
    notes: Mapping[str, Any] = field(repr=False)

    def save(self, path: str | Path) -> Path:
        """Write a .png that says how it was made; the file is whole or not there. Returns its path."""
        from importlib.metadata import version

        from scenelang.backends.files import written_whole

        target = Path(path)
        check_output(target)
        chunks = need("PIL.PngImagePlugin", "pillow").PngInfo()
        chunks.add_text("Software", f"scenelang {version('scenelang')}")
        chunks.add_text("scenelang", json.dumps(self.notes))  # JSON in ASCII, as a text chunk wants it
        image = need("PIL.Image", "pillow").fromarray(self.pixels)
        with written_whole(target) as temporary:
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
    """Pictures that are drawn when they are iterated or saved, by seeds that follow one another.

    Attributes
    ----------
    seeds : tuple of int
        One for each picture.
    notes : mapping
        What the pictures say of how they were made.
    """

    seeds: tuple[int, ...]
    notes: Mapping[str, Any]
    _checkpoint: Checkpoint
    _sketch: Sketch
    _order: Order
    _sampling: Sampling
    _progress: Progress | None

    def __len__(self) -> int:
        return len(self.seeds)

    def __iter__(self) -> Iterator[ImaginedPicture]:
        from scenelang.backends.neural.imagine.sampling import imagine as drawn

        for number, seed in enumerate(self.seeds):
            part = part_of(self._progress, number / len(self), (number + 1) / len(self))
            sampling = replace(self._sampling, seed=seed)
            pixels = drawn(self._checkpoint, self._sketch, self._order, sampling, part)
            yield ImaginedPicture(pixels, seed, {**self.notes, "seed": seed})

    def paths(self, output: str | Path) -> list[Path]:
        """Where the pictures go: ``output``, or of several OUT-1.png, OUT-2.png and so on."""
        path = Path(output)
        if len(self) == 1:
            return [path]
        return [path.with_name(f"{path.stem}-{number}{path.suffix}") for number in range(1, len(self) + 1)]

    def save(self, output: str | Path) -> list[Path]:
        """Draw and write all pictures, each when it is done. Returns their paths."""
        check_output(Path(output))
        return [picture.save(path) for picture, path in zip(self, self.paths(output), strict=True)]

    def __repr__(self) -> str:
        size = f"{self._sampling.width} x {self._sampling.height}"
        return f"<ImaginedPictures: {len(self):,} of {size} by {self._checkpoint.name}>"


# --- imagine ---------------------------------------------------------------------------------------------------------


def imagine(
    scene: Scene,
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
    """Pictures of a scene by a text-to-image model that heeds its layout.

    Parameters
    ----------
    scene : Scene
        What stands where, and what each thing is.
    camera : Camera, optional
        Where the pictures are taken from; the default frames the whole scene.
    size : (width, height), optional
        Pixels; default: that of a placed camera, else what the model was made for.
    frame : int, optional
        Frame of a 4D scene, from 0.
    seed : int
        Of the first picture; the others have those that follow. The same seed gives the same picture.
    count : int
        How many pictures, 1 to 1,000.
    prompt : str, optional
        What the pictures show, in which handles may stand; default: what the program's first comment says, else the
        root's word.
    template : str, optional
        The sentence about a thing, with ``{embedding}``, ``{word}`` and ``{style}``.
    granularity : Granularity, optional
        Which entities count as one; default every primitive.
    settings : ImagineSettings, optional
        The model, its steps and guidance, and how the layout is heeded.
    embeddings : Embeddings or path, optional
        Texts and learned vectors; "auto": the file beside the program, None: none.
    models : Models, optional
        Where weights are, and what computes.
    limit : int
        Most primitives that are expanded.
    progress : callable, optional
        Called with a fraction from 0 to 1. An exception that it raises cancels the work.
    warn : callable, optional
        Told what is left out or not understood.

    Raises
    ------
    SceneError
        Weights are not to be had, nothing in the scene is called so, or an argument makes no sense.

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
    sketch = _sketch(
        scene, camera, size or _own_size(camera, checkpoint.size), frame, granularity, settings.method, limit, tell
    )
    sampling = settings.sampling((sketch.layout.width, sketch.layout.height), seed)
    check_sampling(sampling, checkpoint.factor)
    z = Embeddings.of(scene, embeddings)
    order, notes = _order(scene, z, template, scene_prompt(scene, prompt), checkpoint, sketch, settings, models, tell)
    seeds = tuple((sampling.seed + number) % (1 << 32) for number in range(count))
    return ImaginedPictures(seeds, notes, checkpoint, sketch, order, sampling, progress)


def imagine_layout(
    scene: Scene,
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
    """What ``imagine`` would tell a model stands where; needs no model. The arguments are those of ``imagine``.

    Examples
    --------
    >>> import scenelang as sl
    >>> scene = sl.evaluate('(bind "beach" (lambda () (union (call "moai" "weathered"))))')
    >>> imagine_layout(scene, size=(96, 64))
    <SceneLayout 96 x 64: 1 instances>
    """
    sayings, _ = Embeddings.of(scene, embeddings).sayings(template)
    own = size or _own_size(camera, _LAYOUT_SIZE)
    sketch = _sketch(scene, camera, own, frame, granularity, method, limit, warn or (lambda _: None))
    sentences = sketch.sentences(sayings)
    return SceneLayout(sketch, sketch.conditions(sentences), sentences, scene_prompt(scene, prompt))


def scene_prompt(scene: Scene, prompt: str | None = None) -> str:
    """What the whole scene is: ``prompt``, else what the head of its program says, else the root's word."""
    from scenelang.backends.neural.describing import thing
    from scenelang.primer import stated_task

    if prompt is None and scene.program is not None:
        prompt = stated_task(scene.program.main.text)
    return prompt or thing(scene.root)


def check_count(count: int) -> None:
    """Raises SceneError("value") for a number of pictures that is none."""
    if not 1 <= count <= _MAX_IMAGES:
        raise SceneError("value", f"`--count` must be 1 to {_MAX_IMAGES:,}, not {count:,}")


def check_output(output: Path, layout_only: bool = False) -> None:
    """Raises SceneError("backend") for a file that a picture, or a layout alone, cannot be written to."""
    endings = (".png", ".json") if layout_only else (".png",)
    if output.suffix.lower() not in endings:
        hint = "a layout alone, --layout-only, can be .json too" if output.suffix.lower() == ".json" else None
        raise SceneError("backend", f"`{output.name}` is none of {' '.join(endings)}", hint)


def check_size(camera: View | None, size: Size | None) -> None:
    """Raises SceneError("value") for pictures that are too large, whatever the scene."""
    from scenelang.backends.pictures.film import PictureOptions, check

    width, height = size or _own_size(camera, _LAYOUT_SIZE)
    check(PictureOptions(width=width, height=height), [])


def _own_size(camera: View | None, default: Size) -> Size:
    return (camera.width, camera.height) if isinstance(camera, PlacedCamera) else default


def _sketch(
    scene: Scene,
    camera: View | None,
    size: Size,
    frame: int | None,
    granularity: Granularity | None,
    method: str,
    limit: int,
    warn: Warn,
) -> Sketch:
    from scenelang.backends.neural.imagine.sampling import most_for, sketch_of
    from scenelang.backends.neural.sentences import Granularity
    from scenelang.backends.pictures.stage import still

    check_size(camera, size)
    shot = still(scene.graph, camera or Viewpoint(), frame, *size)
    return sketch_of(scene.graph, shot, granularity or Granularity(), most_for(method), limit, warn)


def _checkpoint(settings: ImagineSettings, models: Models) -> Checkpoint:
    from scenelang.backends.neural.imagine import migc, regional, sampling

    default = {"gligen": regional.MODEL, "migc": migc.MODEL}.get(settings.method, sampling.MODEL)
    name = settings.model or default
    return sampling.load_checkpoint(name, models.shelf(), models.computes_on(), settings.scheduler)


def _order(
    scene: Scene,
    z: Embeddings,
    template: str | None,
    prompt: str,
    checkpoint: Checkpoint,
    sketch: Sketch,
    settings: ImagineSettings,
    models: Models,
    warn: Warn,
) -> tuple[Order, dict[str, Any]]:
    """What is to be drawn, and what the pictures say of it."""
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

    sayings, vectors = z.sayings(template)
    read = readable_vectors(checkpoint, vectors)
    sentences = sketch.sentences(replace(sayings, learned=frozenset(read)))
    conditions = sketch.conditions(sentences)
    warn_of_unread(conditions, sketch.handles[0], vectors, read, warn)
    asked = sentences.of_scene(prompt)
    shelf = models.shelf()
    migc = load_migc(str(settings.migc or WEIGHTS), shelf) if settings.method == "migc" else None
    control_name = CONTROL if settings.control == "" else settings.control
    control = load_control(control_name, shelf, str(checkpoint.device)) if control_name else None
    order = Order(asked, settings.negative, conditions, read, settings.method, settings.strength, migc, control)
    notes = {
        "file": Path(scene.name).name,
        "model": checkpoint.name,
        "method": settings.method,
        "control": control_name,
        "steps": settings.steps,
        "guidance": settings.guidance,
        "negative": settings.negative,
        "layout": layout_json(sketch.layout, conditions, sketch.truth, written(asked)),
    }
    return order, notes


# --- distill ---------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class DistillationModels:
    """The diffusion models that judge.

    Parameters
    ----------
    model : str, optional
        The multi-view model, by name or as a folder; default ``MVDream/MVDream``.
    scene_model : str, optional
        The model of single pictures for the whole scene.
    control : str, optional
        Its ControlNet for depth.
    scene_term : bool
        False: learn each thing for itself; poses stay as they are.
    half : bool
        Half precision, which is the default on a GPU.

    Examples
    --------
    >>> DistillationModels("my-model", scene_term=False).half
    False
    """

    model: str | None = setting(None, "the multi-view model (MVDream/MVDream), or a folder", metavar="NAME")
    scene_model: str | None = setting(None, "the model of single pictures for the whole scene", metavar="NAME")
    control: str | None = setting(None, "its ControlNet for depth, or a folder", metavar="NAME")
    scene_term: bool = setting(True, "learn each thing for itself; poses stay", "--no-scene-term")
    half: bool = setting(False, "models in half precision (the default on a GPU)")


@dataclass(frozen=True, slots=True)
class DistillationStart:
    """What a run in ``folder`` is about to do: ``things`` in the scene, ``learned`` of them, ``steps`` that are left,
    and the sentence of each different thing."""

    things: int
    learned: int
    steps: int
    folder: Path
    sentences: tuple[str, ...] = field(repr=False)

    def __str__(self) -> str:
        return f"{self.things:,} things, {self.learned:,} to learn, {self.steps:,} steps in {self.folder}"


@dataclass(frozen=True, slots=True, repr=False)
class Distillation:
    """A run that learned how things look.

    Attributes
    ----------
    folder : Path
        The run (docs/distillation.md); ``scene.render(quality="splats", settings={"distilled": str(folder)})`` draws
        what was learned.
    start : DistillationStart
        What was to be done.
    files : tuple of Path
        Gaussians and poses; none where the run is not ``finished``.
    finished : bool
        False where ``stop`` ended it; ``RunFolder(folder, resume=True)`` goes on.
    """

    folder: Path
    start: DistillationStart
    files: tuple[Path, ...]
    finished: bool

    def film(self, scene: Scene, size: Size = (256, 256)) -> Film:
        """A turn around what was learned of a static scene, or the frames of a 4D one; ``save`` draws it."""
        return scene.film(size=size, quality="splats", settings={"distilled": str(self.folder)})

    def __repr__(self) -> str:
        state = "finished" if self.finished else "stopped"
        return f"<Distillation in {self.folder}: {self.start.things:,} things, {state}>"


def distill(
    scene: Scene,
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
    """Learn how the primitives of a scene look as 3D Gaussians, from diffusion models.

    Parameters
    ----------
    scene : Scene
        What is to be learned.
    run : RunFolder
        Where the run is kept, and whether it goes on with one that is there.
    prompt, template, granularity, embeddings
        As in ``imagine``.
    settings : DistillationSettings, optional
        ``DistillationSettings.of(steps, gaussians, guidance, weighting, seed)``.
    networks : DistillationModels, optional
        Names of the diffusion models.
    budget : float, optional
        Seconds of optimisation at most; the annealing follows the time.
    models : Models, optional
        Where weights are, and what computes.
    progress : callable, optional
        Called with a fraction from 0 to 1. An exception that it raises cancels the work.
    on_start, on_step : callable, optional
        Told what is about to be done, and after each step its losses.
    stop : callable, optional
        Asked before each step; where it says True the run ends, with everything saved, so that it can go on.

    Raises
    ------
    SceneError
        The folder holds a run that would be lost or none that can go on, weights are not to be had, nothing is left to
        learn, or an argument makes no sense.

    Examples
    --------
    >>> distill(scene, RunFolder("run"), models=Models("weights", device="cuda"))  # doctest: +SKIP
    <Distillation in run: 3 things, finished>
    """
    from scenelang.backends.files import made_folder
    from scenelang.backends.neural.diffusion import memory_told
    from scenelang.backends.neural.distillation.learning import DistillationSettings, cast_of
    from scenelang.backends.neural.distillation.run import asked_of, kept_in, write_outcome
    from scenelang.backends.neural.distillation.run import run as run_steps
    from scenelang.backends.neural.sentences import Granularity, leaves_of

    for package in ("torch", "diffusers", "open_clip"):
        need(package, INSTALL)
    sayings, vectors = Embeddings.of(scene, embeddings).sayings(template)
    cast = cast_of(leaves_of(scene.graph, granularity or Granularity(), sayings))
    settings, models = settings or DistillationSettings.of(), models or Models()
    folder = run.path(scene, ".distillation")
    before, device = _before(run, folder), models.computes_on()
    asked_prompt = scene_prompt(scene, prompt)
    with memory_told():
        teachers = _teachers(networks or DistillationModels(), models, asked_prompt, tensors_of(vectors, device))
        names = [teachers.figures.name, *([teachers.scene.name] if teachers.scene is not None else [])]
        asked = asked_of(settings, names, asked_prompt)
        learning = _learning(run, cast, teachers, settings, device, before, asked)
        made_folder(folder)
        start = _start(cast, learning, folder)
        if on_start is not None:
            on_start(start)
        finished = run_steps(
            learning, folder, asked, seconds=0.0 if before is None else before.seconds, budget=budget,
            tell=_step_callback(progress, on_step), stopped=stop or (lambda: False),
        )  # fmt: skip
    files = write_outcome(kept_in(folder), cast, folder) if finished else []
    return Distillation(folder, start, tuple(files), finished)


def _before(run: RunFolder, folder: Path) -> SavedDistillation | None:
    """The run that is to go on; raises SceneError where there is none, or one that would be lost."""
    from scenelang.backends.neural.distillation.run import STATE, kept_in

    if folder.exists() and not folder.is_dir():
        raise SceneError("file", f"`{folder}` cannot be a folder: it is a file")
    if run.resume:
        return kept_in(folder)
    if (folder / STATE).exists() and not run.force:
        hint = "--resume goes on with it, --force begins anew"
        raise SceneError("file", f"{folder} holds a run already", hint=hint)
    return None


def _learning(
    run: RunFolder,
    cast: Cast,
    teachers: Teachers,
    settings: DistillationSettings,
    device: str,
    before: SavedDistillation | None,
    asked: Mapping[str, Any],
) -> Learning:
    """The optimisation at its beginning, or where ``before`` was left."""
    from scenelang.backends.neural.distillation.learning import Learning
    from scenelang.backends.neural.distillation.run import check_same

    if before is None:
        return Learning(cast, teachers, settings, device, _taken_over(run, cast))
    check_same(before, cast, asked)
    learning = Learning(cast, teachers, settings, device, before.frozen_states())
    learning.restore(before.tensors)
    return learning


def _taken_over(run: RunFolder, cast: Cast) -> dict[int, Any]:
    """The figures that an earlier run has learned; raises SceneError where that leaves nothing to do."""
    if run.start is None:
        return {}
    from scenelang.backends.neural.distillation.run import kept_in, same_figures

    found = same_figures(kept_in(Path(run.start)), cast)
    if len(found) == len(cast.figures):
        raise SceneError("value", f"everything in the scene is as in {run.start}, so there is nothing to learn")
    return found


def _teachers(networks: DistillationModels, models: Models, prompt: str, vectors: Mapping[str, Any]) -> Teachers:
    from scenelang.backends.neural.diffusion_loading import load_multiview
    from scenelang.backends.neural.distillation.learning import Teachers

    torch = need("torch", INSTALL)
    shelf, device = models.shelf(), models.computes_on()
    dtype = torch.float16 if networks.half or device.startswith("cuda") else torch.float32
    named: dict[str, Any] = {} if networks.model is None else {"name": networks.model}
    figures = load_multiview(shelf=shelf, device=device, dtype=dtype, **named)
    scene = _scene_model(networks, models, dtype) if networks.scene_term else None
    return Teachers(figures, scene, vectors, (prompt,))


def _scene_model(networks: DistillationModels, models: Models, dtype: Any) -> Diffusion:
    from scenelang.backends.neural.diffusion_loading import load_depth

    named: dict[str, Any] = {} if networks.scene_model is None else {"name": networks.scene_model}
    shelf, device = models.shelf(), models.computes_on()
    return load_depth(control=networks.control, shelf=shelf, device=device, dtype=dtype, **named)


def _start(cast: Cast, learning: Learning, folder: Path) -> DistillationStart:
    left = learning.steps - learning.step_number
    sentences = tuple(figure.condition.plain for figure in cast.figures)
    return DistillationStart(len(cast.actors), learning.learned, left, folder, sentences)


def _step_callback(
    progress: Progress | None, on_step: Callable[[DistillationProgress], None] | None
) -> Callable[[DistillationProgress], None]:
    """What is told of each step, one callback for both."""

    def report(state: DistillationProgress) -> None:
        if on_step is not None:
            on_step(state)
        if progress is not None:
            progress(state.share)

    return report
