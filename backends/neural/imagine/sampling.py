"""Sampling of images: a Stable Diffusion checkpoint conditioned on a prompt, a layout and a depth map."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.base import Progress, require
from scenelang.backends.labels.ground_truth import Truth, truth_of
from scenelang.backends.neural.clip import Prompt
from scenelang.backends.neural.diffusion import TransformersPromptEncoder, depth_condition, silence_libraries
from scenelang.backends.neural.imagine.layout import (
    DEFAULT_WEIGHT,
    MAX_INSTANCES,
    AttentionRegion,
    Gligen,
    LayoutConditioning,
    NoConditioning,
    PictureLayout,
    Regional,
    conditions_in,
    handles_in,
    layout_of,
)
from scenelang.backends.neural.imagine.migc import MAX_INSTANCES as MIGC_MAX_INSTANCES
from scenelang.backends.neural.imagine.migc import Migc, MigcConditioning
from scenelang.backends.neural.prompts import (
    Granularity,
    IntArray,
    PromptBuilder,
    PromptCondition,
    PromptContext,
    check_names,
    units_of,
)
from scenelang.backends.neural.weights import INSTALL, ModelHub
from scenelang.backends.neural.wording import check_template
from scenelang.backends.pictures.stage import Shot, unit_size
from scenelang.backends.surfaces.stand_ins import drawn_scene
from scenelang.grammar.diagnostics import Diagnostic, SceneError
from scenelang.interpreter.inspection.numbering import frame_numbers, instance_handles
from scenelang.interpreter.scene.entity import Scene

# Stable Diffusion checkpoints and ControlNets in the folder layout of diffusers, by name.


DEFAULT_MODEL = "stabilityai/stable-diffusion-2-1"
DEFAULT_CONTROLNET = "thibaud/controlnet-sd21-depth-diffusers"
SCHEDULERS = ("own", "ddim")
_MIRROR_HINT = "its authors removed it from the hub; specify a mirror or a local folder with --model NAME"


@dataclass(frozen=True, slots=True, eq=False)
class Checkpoint:
    """Text-to-image model with frozen weights."""

    name: str
    unet: Any
    vae: Any
    text_encoder: TransformersPromptEncoder
    scheduler: Any

    @property
    def factor(self) -> int:
        """Downsampling factor of the autoencoder: pixels per latent along each side."""
        return int(2 ** (len(self.vae.config.block_out_channels) - 1))

    @property
    def size(self) -> tuple[int, int]:
        """Native width and height of the model's images, in pixels."""
        sample = self.unet.config.sample_size
        height, width = (sample, sample) if isinstance(sample, int) else sample
        return int(width) * self.factor, int(height) * self.factor

    @property
    def device(self) -> Any:
        return next(self.unet.parameters()).device


def load_checkpoint(
    name: str = DEFAULT_MODEL, hub: ModelHub | None = None, device: str = "cpu", scheduler: str = "own"
) -> Checkpoint:
    """Load the checkpoint ``name`` to ``device``, in half precision on CUDA; ``scheduler`` is one of SCHEDULERS.

    Raises SceneError: "weights" if it is unavailable, "backend" without the packages.
    """
    diffusers = require("diffusers", INSTALL)
    make = partial(diffusers.StableDiffusionPipeline.from_pretrained, safety_checker=None, feature_extractor=None)
    try:
        pipeline = _load(make, name, hub)
    except SceneError as error:
        is_removed = error.name == "weights" and name == DEFAULT_MODEL
        raise SceneError(error.name, error.message, _MIRROR_HINT if is_removed else error.hint) from error
    own = pipeline.scheduler
    chosen = diffusers.DDIMScheduler.from_config(own.config) if scheduler == "ddim" else own
    for part in (pipeline.unet, pipeline.vae, pipeline.text_encoder):
        _freeze(part, device)
    encoder = TransformersPromptEncoder(pipeline.text_encoder, pipeline.tokenizer)
    return Checkpoint(name, pipeline.unet, pipeline.vae, encoder, chosen)


def load_control(name: str = DEFAULT_CONTROLNET, hub: ModelHub | None = None, device: str = "cpu") -> Any:
    """Load the ControlNet ``name`` to ``device``; raises the errors of ``load_checkpoint``."""
    diffusers = require("diffusers", INSTALL)
    return _freeze(_load(diffusers.ControlNetModel.from_pretrained, name, hub), device)


def check_control(control: Any, unet: Any) -> None:
    """Raise SceneError("weights") for a ControlNet of another base model."""
    keys = ("cross_attention_dim", "block_out_channels", "in_channels")
    wrong = [key for key in keys if _as_list(control.config[key]) != _as_list(unet.config[key])]
    if wrong:
        difference = f"{wrong[0]} is {control.config[wrong[0]]}, not {unet.config[wrong[0]]}"
        message = f"the ControlNet is for another model: its {difference}"
        raise SceneError("weights", message, hint="specify another one with --control")


def _as_list(value: Any) -> Any:
    return list(value) if isinstance(value, (list, tuple)) else value


def _freeze(network: Any, device: str) -> Any:
    """Move the network to ``device``, without gradients."""
    torch = require("torch", INSTALL)
    dtype = torch.float16 if device.startswith("cuda") else torch.float32
    with silence_libraries(progress_bars=False):
        return network.to(device, dtype).eval().requires_grad_(False)


def _load(from_pretrained: Any, name: str, hub: ModelHub | None) -> Any:
    def load_local(folder: Path) -> Any:
        with silence_libraries(progress_bars=False):
            return from_pretrained(str(folder), local_files_only=True)

    def load_remote(repository: str, offline: bool) -> Any:
        with silence_libraries(progress_bars=not offline):
            return from_pretrained(repository, local_files_only=offline)

    return (hub or ModelHub()).load(name, load_local, load_remote)


# Denoising.


Picture = npt.NDArray[np.uint8]
FloatArray = npt.NDArray[np.float64]
MAX_STEPS = 1000


@dataclass(frozen=True, slots=True)
class Sampling:
    """Sampling parameters of one image.

    Attributes
    ----------
    width, height
        In pixels.
    steps
        Number of denoising steps.
    guidance
        Classifier-free guidance scale; 1 disables guidance.
    seed
        Random seed; results are reproducible on the same machine.
    control
        Conditioning scale of the ControlNet.
    """

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
        """Return height and width of the latent with a downsampling factor of ``factor``."""
        return self.height // factor, self.width // factor


@dataclass(frozen=True, slots=True, eq=False)
class Control:
    """Depth ControlNet with the depth (H, W) along the viewing axis, infinity in the background."""

    network: Any
    depth: FloatArray


def check_sampling(sampling: Sampling, factor: int) -> None:
    """Raise SceneError("value") for parameters out of range; ``factor`` is that of the autoencoder."""
    if sampling.width % factor or sampling.height % factor:
        size = f"{sampling.width} x {sampling.height}"
        raise SceneError("value", f"width and height must be multiples of {factor} for this model, not {size}")
    if not 1 <= sampling.steps <= MAX_STEPS:
        raise SceneError("value", f"`--steps` must be 1 to {MAX_STEPS:,}, not {sampling.steps:,}")
    for name, value, maximum in (("guidance", sampling.guidance, 100.0), ("control-scale", sampling.control, 10.0)):
        if not 0.0 <= value <= maximum:
            raise SceneError("value", f"`--{name}` must be 0 to {maximum:g}, not {value:g}")


def generate_image(
    checkpoint: Checkpoint,
    hidden_states: Any,
    sampling: Sampling,
    conditioning: LayoutConditioning | None = None,
    control: Control | None = None,
    progress: Progress | None = None,
) -> Picture:
    """Generate one image (H, W, 3), 8-bit sRGB.

    Parameters
    ----------
    checkpoint : Checkpoint
        Model.
    hidden_states : Tensor
        (B, T, D), of the prompt; with guidance, preceded by those of the negative prompt.
    sampling : Sampling
        Size, steps, guidance and seed.
    conditioning : LayoutConditioning, optional
        Layout conditioning.
    control : Control, optional
        ControlNet.
    progress : callable, optional
        Called with a fraction from 0 to 1 after each step.

    Raises
    ------
    SceneError
        "value" for parameters out of range, "unsupported" if memory is insufficient or the result is not finite.
    """
    torch = require("torch", INSTALL)
    check_sampling(sampling, checkpoint.factor)
    try:
        with torch.no_grad(), conditioning or NoConditioning() as active:
            latent = _denoise(checkpoint, hidden_states, sampling, active, control, progress)
            decoded = checkpoint.vae.decode(latent / checkpoint.vae.config.scaling_factor).sample
    except torch.OutOfMemoryError as error:
        message = f"out of memory on {checkpoint.device} for an image of {sampling.width} x {sampling.height}"
        raise SceneError("unsupported", message, hint="use a smaller --size, or --device cpu") from error
    if not bool(torch.isfinite(decoded).all()):  # float16 overflows in some models
        message = "numeric overflow in the model: no image was produced"
        raise SceneError("unsupported", message, hint="use --device cpu, which computes in float32")
    levels = (decoded[0].float().permute(1, 2, 0) / 2.0 + 0.5).clamp(0.0, 1.0).cpu().numpy()
    return np.asarray((levels * 255.0).round().astype(np.uint8))


def _denoise(
    checkpoint: Checkpoint,
    hidden_states: Any,
    sampling: Sampling,
    conditioning: LayoutConditioning,
    control: Control | None,
    progress: Progress | None,
) -> Any:
    """Return the latent (1, C, h, w) after all denoising steps."""
    torch = require("torch", INSTALL)
    unet, scheduler = checkpoint.unet, checkpoint.scheduler
    generator = torch.Generator().manual_seed(sampling.seed)  # on the CPU: the same noise for every device
    scheduler.set_timesteps(sampling.steps, device=checkpoint.device)
    shape = (1, unet.config.in_channels, *sampling.latent(checkpoint.factor))
    noise = torch.randn(shape, generator=generator, dtype=hidden_states.dtype).to(checkpoint.device)
    latent = noise * scheduler.init_noise_sigma
    takes_generator = "generator" in inspect.signature(scheduler.step).parameters
    step_options = {"generator": generator} if takes_generator else {}
    depth = _control_image(control, checkpoint, hidden_states) if control is not None else None
    timesteps = scheduler.timesteps
    for number, timestep in enumerate(timesteps):
        attention_options = conditioning.step(number, len(timesteps))
        inputs = scheduler.scale_model_input(torch.cat([latent] * len(hidden_states)), timestep)
        residuals = _residuals(control, depth, inputs, timestep, hidden_states, sampling.control)
        output = unet(
            inputs,
            timestep,
            encoder_hidden_states=hidden_states,
            cross_attention_kwargs=attention_options,
            **residuals,
        ).sample
        if sampling.guided:  # classifier-free guidance (Ho and Salimans 2022)
            unconditional, conditional = output.chunk(2)
            output = unconditional + sampling.guidance * (conditional - unconditional)
        latent = scheduler.step(output, timestep, latent, **step_options).prev_sample
        if progress is not None:
            progress((number + 1) / len(timesteps))
    return latent


def _control_image(control: Control, checkpoint: Checkpoint, like: Any) -> Any:
    """Return the ControlNet's conditioning image (1, 3, H, W) in [0, 1], with the dtype of ``like``."""
    torch = require("torch", INSTALL)
    depth = torch.from_numpy(control.depth)
    return depth_condition(depth, torch.isfinite(depth)).to(checkpoint.device, like.dtype)


def _residuals(
    control: Control | None, depth: Any, inputs: Any, timestep: Any, hidden_states: Any, scale: float
) -> dict[str, Any]:
    """Return the residuals that the ControlNet adds to the UNet's features."""
    if control is None:
        return {}
    images = depth.expand(len(inputs), -1, -1, -1)
    down, middle = control.network(
        inputs,
        timestep,
        encoder_hidden_states=hidden_states,
        controlnet_cond=images,
        conditioning_scale=scale,
        return_dict=False,
    )
    return {"down_block_additional_residuals": down, "mid_block_additional_residual": middle}


# From a shot of a scene to images: layout, prompts of the instances, and generation.


METHODS = ("regional", "gligen", "migc")
Warn = Callable[[Diagnostic], None]
Vectors = Mapping[str, npt.NDArray[Any]]


@dataclass(frozen=True, slots=True, eq=False)
class ShotLayout:
    """Layout of a shot, independent of a model.

    Attributes
    ----------
    truth
        Ground-truth maps of the shot.
    layout
        Boxes of the instances.
    handles
        Handles of all instances of the scene.
    units
        (M,), unit of each instance of the scene.
    """

    truth: Truth
    layout: PictureLayout
    handles: tuple[str, ...]
    units: IntArray

    def prompts(self, context: PromptContext) -> PromptBuilder:
        """Return the prompt builder of the scene; raises SceneError("value") for an invalid template."""
        check_template(context.template)
        return PromptBuilder(self.truth.ancestry, self.handles, context)

    def conditions(self, prompts: PromptBuilder) -> list[PromptCondition]:
        """Return the prompt of each instance in the layout."""
        return conditions_in(self.layout, self.truth, self.units, prompts)


def max_instances_of(method: str) -> int:
    """Return the maximum number of instances that a method can condition on."""
    return MIGC_MAX_INSTANCES if method == "migc" else MAX_INSTANCES


def shot_layout_of(
    scene: Scene, shot: Shot, granularity: Granularity, max_instances: int, limit: int, warn: Warn
) -> ShotLayout:
    """Return the layout of ``shot`` with at most ``max_instances`` instances; warns if instances are omitted.

    Raises SceneError; LimitError for more than ``limit`` primitives.
    """
    scene = drawn_scene(scene, limit, warn)
    truth = truth_of(scene, shot, limit, *unit_size(scene))
    numbers = frame_numbers(scene) if len(scene.frames) > 1 else None
    handles = tuple(instance_handles(scene, truth.ancestry, numbers))
    check_names([(truth.ancestry, handles)], granularity)
    units = units_of(truth.ancestry, handles, granularity)
    layout = layout_of(truth, units, max_instances)
    if layout.left_out:
        message = f"{layout.left_out:,} instances are omitted: only the {len(layout.instances)} largest are used"
        warn(Diagnostic("crowded-layout", message, hint="treat entities as units with --depth N or --entity NAME"))
    return ShotLayout(truth, layout, handles, units)


def compatible_vectors(checkpoint: Checkpoint, vectors: Vectors) -> dict[str, Any]:
    """Return the learned vectors of Z with the width of the checkpoint's text encoder, as tensors."""
    torch = require("torch", INSTALL)
    width = checkpoint.text_encoder.width
    compatible = {handle: each for handle, each in vectors.items() if each.ndim == 2 and each.shape[1] == width}
    return {handle: torch.from_numpy(each).to(checkpoint.device) for handle, each in compatible.items()}


def warn_incompatible_vectors(
    conditions: Sequence[PromptCondition], style: str, vectors: Vectors, compatible: Vectors, warn: Warn
) -> None:
    """Warn about learned vectors in the prompts that are for another text encoder."""
    used = {style, *handles_in(conditions)}
    incompatible = sorted(used & (vectors.keys() - compatible.keys()))
    if incompatible:
        shown = ", ".join(f"<{handle}>" for handle in incompatible[:3]) + (", ..." if len(incompatible) > 3 else "")
        message = f"the learned vectors of {shown} are for another text encoder; their texts are used instead"
        warn(Diagnostic("unread-vectors", message, hint="vectors of OpenCLIP ViT-H fit Stable Diffusion 2"))


@dataclass(frozen=True, slots=True, eq=False)
class GenerationRequest:
    """Prompts and conditioning of an image.

    Attributes
    ----------
    prompt, negative
        Prompt of the whole image, and negative prompt.
    conditions
        Prompts of the layout's instances.
    vectors
        Learned vectors by handle.
    method
        Layout conditioning, one of METHODS.
    weight
        Strength of regional attention.
    migc
        Weights of MIGC.
    control
        ControlNet for depth.
    """

    prompt: Prompt
    negative: str
    conditions: Sequence[PromptCondition]
    vectors: Mapping[str, Any]
    method: str = "regional"
    weight: float = DEFAULT_WEIGHT
    migc: Migc | None = None
    control: Any = None


def imagine(
    checkpoint: Checkpoint,
    shot_layout: ShotLayout,
    request: GenerationRequest,
    sampling: Sampling,
    progress: Progress | None = None,
) -> Picture:
    """Generate one image (H, W, 3) for a layout, 8-bit sRGB; raises SceneError."""
    torch = require("torch", INSTALL)
    layout = shot_layout.layout
    with torch.no_grad():
        prompts = [request.prompt, *(condition.prompt for condition in request.conditions)]
        encoded = checkpoint.text_encoder.encode_with_pooled(prompts, request.vectors)
        hidden_states = encoded.hidden_states[:1]
        if sampling.guided:
            negative = (request.negative,) if request.negative else ()
            hidden_states = torch.cat([checkpoint.text_encoder.encode([negative]), hidden_states])
    regions = [
        AttentionRegion(layout.fractions(each), encoded.hidden_states[i : i + 1], encoded.pooled[i : i + 1])
        for i, each in enumerate(layout.instances, start=1)
    ]
    control = None
    if request.control is not None:
        check_control(request.control, checkpoint.unet)
        control = Control(request.control, shot_layout.truth.depth)
    conditioning = _conditioning(checkpoint, request, regions, sampling)
    return generate_image(checkpoint, hidden_states, sampling, conditioning, control, progress)


def _conditioning(
    checkpoint: Checkpoint, request: GenerationRequest, regions: Sequence[AttentionRegion], sampling: Sampling
) -> LayoutConditioning:
    latent, guided = sampling.latent(checkpoint.factor), sampling.guided
    if request.method == "gligen":
        return Gligen(checkpoint.unet, regions, guided)
    if request.method == "migc" and request.migc is not None:
        return MigcConditioning(checkpoint.unet, request.migc, regions, latent, guided, sampling.seed)
    return Regional(checkpoint.unet, regions, latent, guided, request.weight)
