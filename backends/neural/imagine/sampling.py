"""Drawing one picture: a checkpoint denoises from noise, guided by words, a layout and a depth picture."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.base import Progress, need
from scenelang.backends.labels.dataset import depth_picture
from scenelang.backends.labels.ground_truth import Truth, truth_of
from scenelang.backends.minecraft.models import as_cubes
from scenelang.backends.neural.clip import Prompt
from scenelang.backends.neural.diffusion import TransformerWords, quiet_libraries
from scenelang.backends.neural.imagine.layout import MOST, PictureLayout, conditions_in, handles_in, layout_of
from scenelang.backends.neural.imagine.migc import MOST as MIGC_MOST
from scenelang.backends.neural.imagine.migc import Migc, MigcSteering
from scenelang.backends.neural.imagine.regional import WEIGHT, AttentionRegion, Gligen, Regional, Steering, Unsteered
from scenelang.backends.neural.sentences import (
    Granularity,
    IntArray,
    PromptCondition,
    Sayings,
    Sentences,
    check_named,
    units_of,
)
from scenelang.backends.neural.weights import INSTALL, Shelf
from scenelang.backends.neural.wording import check_template
from scenelang.backends.pictures.stage import Shot, unit_size
from scenelang.grammar.diagnostics import Diagnostic, SceneError
from scenelang.interpreter.scene.entity import Scene
from scenelang.interpreter.scene.numbering import frame_numbers, instance_handles

# Stable Diffusion checkpoints and ControlNets in the folder layout of diffusers, by name.


MODEL = "stabilityai/stable-diffusion-2-1"
CONTROL = "thibaud/controlnet-sd21-depth-diffusers"
SCHEDULERS = ("own", "ddim")
_MIRRORS = "its makers took it from the hub; name a mirror of it, or a folder that holds it: --model NAME"


@dataclass(frozen=True, slots=True, eq=False)
class Checkpoint:
    """A text-to-image model, ready to sample; weights are frozen."""

    name: str
    unet: Any
    vae: Any
    words: TransformerWords
    scheduler: Any

    @property
    def factor(self) -> int:
        """Pixels across one place of the latent."""
        return int(2 ** (len(self.vae.config.block_out_channels) - 1))

    @property
    def size(self) -> tuple[int, int]:
        """Width and height in pixels that the model was made for."""
        sample = self.unet.config.sample_size
        height, width = (sample, sample) if isinstance(sample, int) else sample
        return int(width) * self.factor, int(height) * self.factor

    @property
    def device(self) -> Any:
        return next(self.unet.parameters()).device


def load_checkpoint(
    name: str = MODEL, shelf: Shelf | None = None, device: str = "cpu", scheduler: str = "own"
) -> Checkpoint:
    """The checkpoint ``name`` on ``device``, in half precision on CUDA; ``scheduler`` is one of SCHEDULERS.

    Raises SceneError: "weights" where it is not to be had, "backend" without the packages.
    """
    diffusers = need("diffusers", INSTALL)
    make = partial(diffusers.StableDiffusionPipeline.from_pretrained, safety_checker=None, feature_extractor=None)
    try:
        made = _loaded(make, name, shelf)
    except SceneError as error:
        is_gone = error.name == "weights" and name == MODEL
        raise SceneError(error.name, error.message, _MIRRORS if is_gone else error.hint) from error
    own = made.scheduler
    chosen = diffusers.DDIMScheduler.from_config(own.config) if scheduler == "ddim" else own
    for part in (made.unet, made.vae, made.text_encoder):
        _ready(part, device)
    return Checkpoint(name, made.unet, made.vae, TransformerWords(made.text_encoder, made.tokenizer), chosen)


def load_control(name: str = CONTROL, shelf: Shelf | None = None, device: str = "cpu") -> Any:
    """The ControlNet ``name`` on ``device``; raises SceneError as ``load_checkpoint`` does."""
    diffusers = need("diffusers", INSTALL)
    return _ready(_loaded(diffusers.ControlNetModel.from_pretrained, name, shelf), device)


def check_control(control: Any, unet: Any) -> None:
    """Raises SceneError("weights") for a ControlNet that was made for another kind of model."""
    keys = ("cross_attention_dim", "block_out_channels", "in_channels")
    wrong = [key for key in keys if _plain(control.config[key]) != _plain(unet.config[key])]
    if wrong:
        said = f"{wrong[0]} is {control.config[wrong[0]]}, not {unet.config[wrong[0]]}"
        raise SceneError("weights", f"the ControlNet is not for this model: its {said}", hint="name another: --control")


def _plain(value: Any) -> Any:
    return list(value) if isinstance(value, (list, tuple)) else value


def _ready(network: Any, device: str) -> Any:
    """The network on ``device``, to be used only."""
    torch = need("torch", INSTALL)
    kind = torch.float16 if device.startswith("cuda") else torch.float32
    with quiet_libraries(bars=False):
        return network.to(device, kind).eval().requires_grad_(False)


def _loaded(make: Any, name: str, shelf: Shelf | None) -> Any:
    def local(folder: Path) -> Any:
        with quiet_libraries(bars=False):
            return make(str(folder), local_files_only=True)

    def hub(called: str, offline: bool) -> Any:
        with quiet_libraries(bars=not offline):
            return make(called, local_files_only=offline)

    return (shelf or Shelf()).load(name, local, hub)


Picture = npt.NDArray[np.uint8]
MOST_STEPS = 1000


@dataclass(frozen=True, slots=True)
class Sampling:
    """``width`` and ``height`` in pixels; so many ``steps``; ``guidance`` 1 is none; the same ``seed`` gives the same
    picture on the same machine; ``control`` is how much a ControlNet counts."""

    width: int
    height: int
    steps: int = 50
    guidance: float = 7.5
    seed: int = 0
    control: float = 1.0

    @property
    def guided(self) -> bool:
        return self.guidance > 1.0

    def latent(self, factor: int) -> tuple[int, int]:
        """Height and width of the latent whose places are ``factor`` pixels wide."""
        return self.height // factor, self.width // factor


@dataclass(frozen=True, slots=True, eq=False)
class Control:
    """A ControlNet and its ``picture`` (H, W, 3), 8-bit: for depth, the nearest is white."""

    network: Any
    picture: Picture


def check_sampling(sampling: Sampling, factor: int) -> None:
    """Raises SceneError("value") for numbers that make no picture."""
    if sampling.width % factor or sampling.height % factor:
        shown = f"{sampling.width} x {sampling.height}"
        raise SceneError("value", f"this model draws pictures in steps of {factor} pixels, so not {shown}")
    if not 1 <= sampling.steps <= MOST_STEPS:
        raise SceneError("value", f"`--steps` must be 1 to {MOST_STEPS:,}, not {sampling.steps:,}")
    for name, value, most in (("guidance", sampling.guidance, 100.0), ("control-scale", sampling.control, 10.0)):
        if not 0.0 <= value <= most:
            raise SceneError("value", f"`--{name}` must be 0 to {most:g}, not {value:g}")


def draw(
    checkpoint: Checkpoint,
    words: Any,
    sampling: Sampling,
    steering: Steering | None = None,
    control: Control | None = None,
    progress: Progress | None = None,
) -> Picture:
    """One picture (H, W, 3), 8-bit sRGB. ``words`` (B, T, D) are the prompt's, with the negative prompt's before them
    where the sampling is guided.

    Raises SceneError("value") for sizes and numbers that make no sense, "unsupported" where memory does not suffice or
    the model's numbers overflow.
    """
    torch = need("torch", INSTALL)
    check_sampling(sampling, checkpoint.factor)
    try:
        with torch.no_grad(), steering or Unsteered() as steered:
            latent = _denoised(checkpoint, words, sampling, steered, control, progress)
            decoded = checkpoint.vae.decode(latent / checkpoint.vae.config.scaling_factor).sample
    except torch.OutOfMemoryError as error:
        message = f"{checkpoint.device} has too little memory for a picture of {sampling.width} x {sampling.height}"
        raise SceneError("unsupported", message, hint="a smaller --size, or --device cpu") from error
    if not bool(torch.isfinite(decoded).all()):
        raise SceneError("unsupported", "numeric overflow in the model: no image was produced", hint="--device cpu")
    shares = (decoded[0].float().permute(1, 2, 0) / 2.0 + 0.5).clamp(0.0, 1.0).cpu().numpy()
    return np.asarray((shares * 255.0).round().astype(np.uint8))


def _denoised(
    checkpoint: Checkpoint,
    words: Any,
    sampling: Sampling,
    steering: Steering,
    control: Control | None,
    progress: Progress | None,
) -> Any:
    """The latent (1, C, h, w) after all steps."""
    torch = need("torch", INSTALL)
    unet, scheduler = checkpoint.unet, checkpoint.scheduler
    source = torch.Generator().manual_seed(sampling.seed)  # on the CPU: the same noise for every device
    scheduler.set_timesteps(sampling.steps, device=checkpoint.device)
    shape = (1, unet.config.in_channels, *sampling.latent(checkpoint.factor))
    latent = torch.randn(shape, generator=source, dtype=words.dtype).to(checkpoint.device) * scheduler.init_noise_sigma
    takes_source = "generator" in inspect.signature(scheduler.step).parameters
    more = {"generator": source} if takes_source else {}
    depth = _condition(control, checkpoint, words) if control is not None else None
    times = scheduler.timesteps
    for number, time in enumerate(times):
        given = steering.step(number, len(times))
        read = scheduler.scale_model_input(torch.cat([latent] * len(words)), time)
        residuals = _residuals(control, depth, read, time, words, sampling.control)
        noise = unet(read, time, encoder_hidden_states=words, cross_attention_kwargs=given, **residuals).sample
        if sampling.guided:
            without, with_words = noise.chunk(2)
            noise = without + sampling.guidance * (with_words - without)
        latent = scheduler.step(noise, time, latent, **more).prev_sample
        if progress is not None:
            progress((number + 1) / len(times))
    return latent


def _condition(control: Control, checkpoint: Checkpoint, words: Any) -> Any:
    """A ControlNet's picture as it reads it (1, 3, H, W), 0 to 1."""
    torch = need("torch", INSTALL)
    return torch.from_numpy(control.picture.copy()).permute(2, 0, 1)[None].to(checkpoint.device, words.dtype) / 255.0


def _residuals(control: Control | None, depth: Any, read: Any, time: Any, words: Any, scale: float) -> dict[str, Any]:
    """What a ControlNet adds to the model's levels."""
    if control is None:
        return {}
    shown = depth.expand(len(read), -1, -1, -1)
    down, middle = control.network(
        read, time, encoder_hidden_states=words, controlnet_cond=shown, conditioning_scale=scale, return_dict=False
    )
    return {"down_block_additional_residuals": down, "mid_block_additional_residual": middle}


# From a shot of a scene to pictures: its layout, what is said of each place, and a model that draws them.


METHODS = ("regional", "gligen", "migc")
Warn = Callable[[Diagnostic], None]
Vectors = Mapping[str, npt.NDArray[Any]]


@dataclass(frozen=True, slots=True, eq=False)
class Sketch:
    """A shot as a layout, before any model: ``handles`` are those of all instances of the truth, ``units`` (M,) what
    each counts as."""

    truth: Truth
    layout: PictureLayout
    handles: tuple[str, ...]
    units: IntArray

    def sentences(self, sayings: Sayings) -> Sentences:
        """What can be said of each thing; raises SceneError("value") for a template that means nothing."""
        check_template(sayings.template)
        return Sentences(self.truth.ancestry, self.handles, sayings)

    def conditions(self, sentences: Sentences) -> list[PromptCondition]:
        """What is said of each place."""
        return conditions_in(self.layout, self.truth, self.units, sentences)


def most_for(method: str) -> int:
    """How many instances a method can be told of."""
    return MIGC_MOST if method == "migc" else MOST


def sketch_of(scene: Scene, shot: Shot, granularity: Granularity, most: int, limit: int, warn: Warn) -> Sketch:
    """The layout of ``shot``, at most ``most`` instances. Warns of what is left out. Raises SceneError, and LimitError
    beyond ``limit`` primitives."""
    scene = as_cubes(scene, limit, warn)
    truth = truth_of(scene, shot, limit, *unit_size(scene))
    numbers = frame_numbers(scene) if len(scene.frames) > 1 else None
    handles = tuple(instance_handles(scene, truth.ancestry, numbers))
    check_named([(truth.ancestry, handles)], granularity)
    units = units_of(truth.ancestry, handles, granularity)
    layout = layout_of(truth, units, most)
    if layout.left_out:
        message = f"{layout.left_out:,} instances are left out: only the {len(layout.places)} largest are drawn"
        warn(Diagnostic("crowded-layout", message, hint="take whole entities as one: --depth N, --entity NAME"))
    return Sketch(truth, layout, handles, units)


def readable_vectors(checkpoint: Checkpoint, vectors: Vectors) -> dict[str, Any]:
    """The learned vectors of Z that the checkpoint's text encoder can read, as tensors."""
    torch = need("torch", INSTALL)
    width = checkpoint.words.width
    fitting = {handle: each for handle, each in vectors.items() if each.ndim == 2 and each.shape[1] == width}
    return {handle: torch.from_numpy(each).to(checkpoint.device) for handle, each in fitting.items()}


def warn_of_unread(
    conditions: Sequence[PromptCondition], style: str, vectors: Vectors, read: Vectors, warn: Warn
) -> None:
    """Tell which learned vectors were to be read, but fit another text encoder."""
    meant = {style, *handles_in(conditions)}
    unread = sorted(meant & (vectors.keys() - read.keys()))
    if unread:
        shown = ", ".join(f"<{handle}>" for handle in unread[:3]) + (", ..." if len(unread) > 3 else "")
        message = f"the vectors of {shown} are not of the width that this model reads, so texts take their place"
        warn(Diagnostic("unread-vectors", message, hint="vectors of OpenCLIP ViT-H fit Stable Diffusion 2"))


@dataclass(frozen=True, slots=True, eq=False)
class Order:
    """What is to be drawn: the scene's ``prompt``, the ``negative`` one, the ``conditions`` of the sketch's places,
    learned ``vectors`` by handle, and how: a ``method`` of METHODS, ``weight`` of regional attention, ``migc``'s
    weights, a ``control`` network for depth."""

    prompt: Prompt
    negative: str
    conditions: Sequence[PromptCondition]
    vectors: Mapping[str, Any]
    method: str = "regional"
    weight: float = WEIGHT
    migc: Migc | None = None
    control: Any = None


def imagine(
    checkpoint: Checkpoint, sketch: Sketch, order: Order, sampling: Sampling, progress: Progress | None = None
) -> Picture:
    """One picture (H, W, 3) of a sketch, 8-bit sRGB; raises SceneError."""
    torch = need("torch", INSTALL)
    with torch.no_grad():
        asked = [order.prompt, *(condition.prompt for condition in order.conditions)]
        encoded = checkpoint.words.encoded(asked, order.vectors)
        words = encoded.words[:1]
        if sampling.guided:
            negative = (order.negative,) if order.negative else ()
            words = torch.cat([checkpoint.words.encode([negative]), words])
    regions = [
        AttentionRegion(sketch.layout.fractions(place), encoded.words[i : i + 1], encoded.pooled[i : i + 1])
        for i, place in enumerate(sketch.layout.places, start=1)
    ]
    control = None
    if order.control is not None:
        check_control(order.control, checkpoint.unet)
        control = Control(order.control, depth_picture(sketch.truth.depth))
    steering = _steering(checkpoint, order, regions, sampling)
    return draw(checkpoint, words, sampling, steering, control, progress)


def _steering(checkpoint: Checkpoint, order: Order, regions: Sequence[AttentionRegion], sampling: Sampling) -> Steering:
    latent, guided = sampling.latent(checkpoint.factor), sampling.guided
    if order.method == "gligen":
        return Gligen(checkpoint.unet, regions, guided)
    if order.method == "migc" and order.migc is not None:
        return MigcSteering(checkpoint.unet, order.migc, regions, latent, guided, sampling.seed)
    return Regional(checkpoint.unet, regions, latent, guided, order.weight)
