"""Diffusion models: network, noise schedule, image codec and prompt encoder; multi-view attention of MVDream."""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from scenelang.backends.base import require
from scenelang.backends.neural.clip import Prompt, PromptVocabulary, TextEncoder, Vectors, tokenize_prompts
from scenelang.backends.neural.weights import INSTALL
from scenelang.backends.pictures.camera import Camera, FloatArray
from scenelang.grammar.diagnostics import SceneError

if TYPE_CHECKING:
    from torch import Tensor


# Errors of CUDA.


@contextmanager
def translate_out_of_memory() -> Iterator[None]:
    """Translate torch's out-of-memory error in the block to SceneError("unsupported")."""
    torch = require("torch", INSTALL)
    try:
        yield
    except torch.OutOfMemoryError as error:
        hint = "use smaller images or models, fewer Gaussians, a smaller batch, or --device cpu"
        raise SceneError("unsupported", "out of GPU memory", hint=hint) from error


# Multi-view UNets (Shi et al., "MVDream", 2023, section 3): camera conditioning, and self-attention across all views.
#
# The network is a ``UNet2DConditionModel(class_embed_type="projection", projection_class_embeddings_input_dim=16)``:
# the camera takes the place of the class embedding.


VIEWS = 4  # number of views that MVDream was trained on

# Rotation from this project's world frame to MVDream's. Here +y is up and an object's front faces +z (azimuth 0).
# MVDream uses Blender's frame, +z up, with the front at +x: its sampling script starts with the view of azimuth 90, for
# which `get_camera` places the eye at +x, and threestudio, which trains with its cameras, measures azimuths from +x
# with the front at 0. So +z maps to +x, +y to +z and, since rotations preserve handedness, +x to +y.
_WORLD = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])


# --- cameras ---------------------------------------------------------------------------------------------------------


def camera_row(world_to_camera: FloatArray) -> FloatArray:
    """Return MVDream's camera condition (16,) for a camera that looks at an object around the origin.

    ``world_to_camera`` (4, 4) is rigid, with the axes of ``camera.Camera``. The result is the flattened matrix from
    camera space (OpenGL: x right, y up, z backwards) to Blender's world, with the eye at distance 1.
    """
    rotation = world_to_camera[:3, :3].T
    eye = -rotation @ world_to_camera[:3, 3]
    pose = np.eye(4)
    pose[:3, :3] = _WORLD @ rotation @ np.diag([1.0, -1.0, -1.0])
    pose[:3, 3] = _WORLD @ eye / max(float(np.linalg.norm(eye)), 1e-8)
    return pose.reshape(16)


def camera_rows(cameras: Sequence[Camera]) -> Tensor:
    """Return MVDream's conditions (V, 16) for V cameras around the origin."""
    torch = require("torch", INSTALL)
    rows = np.stack([camera_row(camera.world_to_camera) for camera in cameras])
    return torch.from_numpy(rows).float()  # type: ignore[no-any-return]


# --- the network -----------------------------------------------------------------------------------------------------


def fold_views(network: Any) -> None:
    """Enable joint denoising of views in ``network``, a UNet or ControlNet with camera conditioning.

    The network then accepts ``cross_attention_kwargs={"views": V}``: each V consecutive rows of a batch form a group. A
    row of zeros in ``class_labels`` means no camera, and adds nothing to the timestep embedding.
    """
    if any(isinstance(processor, FoldedAttention) for processor in network.attn_processors.values()):
        return
    network.set_attn_processor(FoldedAttention())
    network.class_embedding.register_forward_hook(_without_camera)


class FoldedAttention:
    """Attention processor of diffusers: self-attention over the tokens of all views of a group, usual cross-attention.

    MVDream calls this 3D self-attention: the views are folded into the sequence dimension (section 3.1).
    """

    def __init__(self) -> None:
        self._plain = require("diffusers.models.attention_processor", INSTALL).AttnProcessor2_0()

    def __call__(
        self,
        attn: Any,
        hidden_states: Tensor,
        encoder_hidden_states: Tensor | None = None,
        attention_mask: Tensor | None = None,
        temb: Tensor | None = None,
        views: int = 1,
    ) -> Tensor:
        """Apply attention to ``hidden_states`` (B, L, C), where B is a multiple of ``views``; preserves the shape."""
        if encoder_hidden_states is not None:
            attended = self._plain(attn, hidden_states, encoder_hidden_states, attention_mask, temb)
            return attended  # type: ignore[no-any-return]
        batch, length, width = hidden_states.shape
        together = hidden_states.reshape(batch // views, views * length, width)
        return self._plain(attn, together).reshape(batch, length, -1)  # type: ignore[no-any-return]


def _without_camera(module: Any, given: tuple[Tensor, ...], embedding: Tensor) -> Tensor:
    """Zero the embedding of rows without a camera; a camera's row is never zero, since it ends in 1."""
    return embedding * (given[0] != 0).any(-1, keepdim=True)


# Image codecs.


class LatentCodec(Protocol):
    """Differentiable mapping between images and latents.

    Images (B, 3, H, W) are sRGB in [0, 1], with H and W multiples of ``factor``; latents are
    (B, C, H / factor, W / factor). The dtype and device of the input are preserved.
    """

    @property
    def factor(self) -> int:
        """Downsampling factor: pixels per latent along each side."""

    def encode(self, pictures: Tensor) -> Tensor:
        """Encode images to latents."""

    def decode(self, latents: Tensor) -> Tensor:
        """Decode latents to images, which are not clamped to [0, 1]."""


class Autoencoder:
    """Latents of an AutoencoderKL: the mean of the posterior, times the scaling factor."""

    def __init__(self, network: Any) -> None:
        self._network = network
        self._scale = float(network.config.scaling_factor)

    @property
    def factor(self) -> int:
        return 1 << (len(self._network.config.block_out_channels) - 1)

    def encode(self, pictures: Tensor) -> Tensor:
        mean = self._network.encode((2.0 * pictures - 1.0).to(self._network.dtype)).latent_dist.mean
        return (mean * self._scale).to(pictures.dtype)  # type: ignore[no-any-return]

    def decode(self, latents: Tensor) -> Tensor:
        sample = self._network.decode((latents / self._scale).to(self._network.dtype)).sample
        return (sample.to(latents.dtype) + 1.0) / 2.0  # type: ignore[no-any-return]


class PixelUnshuffle:
    """Latents of pixel-space models: space-to-depth, with blocks of ``factor`` x ``factor`` pixels as channels."""

    def __init__(self, factor: int) -> None:
        self._functional = require("torch.nn.functional", INSTALL)
        self._factor = factor

    @property
    def factor(self) -> int:
        return self._factor

    def encode(self, pictures: Tensor) -> Tensor:
        return self._functional.pixel_unshuffle(2.0 * pictures - 1.0, self._factor)  # type: ignore[no-any-return]

    def decode(self, latents: Tensor) -> Tensor:
        return (self._functional.pixel_shuffle(latents, self._factor) + 1.0) / 2.0  # type: ignore[no-any-return]


# Third-party logging.


@contextmanager
def silence_libraries(progress_bars: bool) -> Iterator[None]:
    """Limit the logging of diffusers and transformers to errors; ``progress_bars``: still show those of downloads."""
    libraries = [require(f"{name}.utils.logging", INSTALL) for name in ("diffusers", "transformers")]
    levels = [library.get_verbosity() for library in libraries]
    shown = libraries[1].is_progress_bar_enabled()
    for library in libraries:
        library.set_verbosity_error()
    if not progress_bars and shown:
        libraries[1].disable_progress_bar()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    finally:
        for library, level in zip(libraries, levels, strict=True):
            library.set_verbosity(level)
        if not progress_bars and shown:
            libraries[1].enable_progress_bar()


# Noise schedule (Ho et al., "Denoising Diffusion Probabilistic Models", 2020).


PREDICTION_TYPES = ("epsilon", "v_prediction", "sample")
_MAX_TIMESTEPS = 10_000


@dataclass(frozen=True, slots=True, eq=False)
class NoiseSchedule:
    """Noise schedule with T timesteps, from 0 (least noise) to T - 1.

    Attributes
    ----------
    alphas_cumprod
        (T,), cumulative products of ``1 - beta``: the fraction of the signal's variance left at each timestep.
    prediction_type
        Meaning of the network's output, one of PREDICTION_TYPES: the noise, the velocity
        ``sqrt(a) noise - sqrt(1 - a) original`` (Salimans and Ho 2022), or the original sample.
    """

    alphas_cumprod: Tensor
    prediction_type: str = "epsilon"

    @property
    def num_timesteps(self) -> int:
        """Number T of timesteps."""
        return len(self.alphas_cumprod)

    def add_noise(self, original: Tensor, noise: Tensor, timesteps: Tensor) -> Tensor:
        """Return ``original`` (B, ...) with ``noise`` of the same shape added for ``timesteps`` (B,)."""
        signal, sigma = self._scales(original, timesteps)
        return signal * original + sigma * noise

    def training_target(self, original: Tensor, noise: Tensor, timesteps: Tensor) -> Tensor:
        """Return the network's training target (B, ...) for ``original`` with ``noise`` at ``timesteps`` (B,)."""
        if self.prediction_type == "epsilon":
            return noise
        if self.prediction_type == "sample":
            return original
        signal, sigma = self._scales(original, timesteps)
        return signal * noise - sigma * original

    def predicted_noise(self, output: Tensor, noisy: Tensor, timesteps: Tensor) -> Tensor:
        """Convert the network's ``output`` (B, ...) for ``noisy`` at ``timesteps`` (B,) to noise."""
        if self.prediction_type == "epsilon":
            return output
        signal, sigma = self._scales(noisy, timesteps)
        if self.prediction_type == "v_prediction":
            return signal * output + sigma * noisy
        return (noisy - signal * output) / sigma

    def predicted_original(self, output: Tensor, noisy: Tensor, timesteps: Tensor) -> Tensor:
        """Convert the network's ``output`` (B, ...) for ``noisy`` at ``timesteps`` (B,) to the original sample.

        With the prediction type "epsilon" the result is not finite at a timestep without any signal (zero SNR).
        """
        if self.prediction_type == "sample":
            return output
        signal, sigma = self._scales(noisy, timesteps)
        if self.prediction_type == "v_prediction":
            return signal * noisy - sigma * output
        return (noisy - sigma * output) / signal

    def _scales(self, like: Tensor, timesteps: Tensor) -> tuple[Tensor, Tensor]:
        """Return the scales of signal and noise, broadcastable to ``like``."""
        alphas = self.alphas_cumprod.to(like.device)[timesteps.to(like.device)]
        alphas = alphas.reshape(-1, *[1] * (like.ndim - 1))
        return alphas.sqrt().to(like.dtype), (1.0 - alphas).sqrt().to(like.dtype)


def schedule_of(config: Mapping[str, Any]) -> NoiseSchedule:
    """Return the schedule of a ``scheduler_config.json`` of diffusers, computed as by its DDPMScheduler.

    Raises SceneError("weights") for unsupported configurations.
    """
    torch = require("torch", INSTALL)
    prediction = config.get("prediction_type", "epsilon")
    if prediction not in PREDICTION_TYPES:
        message = f"unsupported prediction type {prediction!r}; expected one of {', '.join(PREDICTION_TYPES)}"
        raise SceneError("weights", message)
    alphas = torch.cumprod(1.0 - _betas(torch, config), dim=0)
    if config.get("rescale_betas_zero_snr"):
        alphas = _rescale_to_zero_snr(alphas)
    if not bool(torch.isfinite(alphas).all() and (alphas >= 0.0).all() and (alphas <= 1.0).all()):
        raise SceneError("weights", "the scheduler's betas are not between 0 and 1")
    return NoiseSchedule(alphas, prediction)


def _betas(torch: Any, config: Mapping[str, Any]) -> Any:
    kind = config.get("beta_schedule", "linear")
    given = config.get("trained_betas")
    steps = len(given) if given is not None else config.get("num_train_timesteps", 1000)
    if type(steps) is not int or not 2 <= steps <= _MAX_TIMESTEPS:
        raise SceneError("weights", f"a scheduler must have 2 to {_MAX_TIMESTEPS:,} timesteps, not {steps!r}")
    if given is not None:
        return torch.tensor(given, dtype=torch.float32)
    start, end = float(config.get("beta_start", 0.0001)), float(config.get("beta_end", 0.02))
    if not 0.0 < start < 1.0 or not 0.0 < end < 1.0:
        raise SceneError("weights", f"the scheduler's betas are not between 0 and 1: {start:g}, {end:g}")
    if kind == "linear":
        return torch.linspace(start, end, steps, dtype=torch.float32)
    if kind == "scaled_linear":
        return torch.linspace(start**0.5, end**0.5, steps, dtype=torch.float32) ** 2
    if kind == "squaredcos_cap_v2":  # cosine schedule (Nichol and Dhariwal 2021, equation 17)
        bars = [math.cos((i / steps + 0.008) / 1.008 * math.pi / 2.0) ** 2 for i in range(steps + 1)]
        return torch.tensor([min(1.0 - bars[i + 1] / bars[i], 0.999) for i in range(steps)], dtype=torch.float32)
    known = "linear, scaled_linear, squaredcos_cap_v2"
    raise SceneError("weights", f"unsupported beta schedule {kind!r}; expected one of {known}")


def _rescale_to_zero_snr(alphas: Any) -> Any:
    """Rescale ``alphas_cumprod`` to zero signal at the last timestep, preserving the first (Lin et al., "Common
    Diffusion Noise Schedules and Sample Steps are Flawed", 2024, algorithm 1)."""
    roots = alphas.sqrt()
    first, last = roots[0].clone(), roots[-1].clone()
    return ((roots - last) * (first / (first - last))) ** 2


# Text conditioning: the encoder hidden states of prompts, with learned embeddings in place of handles.


class PromptEncoder(Protocol):
    """Text encoder of a diffusion model; gradients flow into the learned vectors only."""

    @property
    def width(self) -> int:
        """Dimensions of a token embedding and of a hidden state."""

    @property
    def context_length(self) -> int:
        """Number of tokens of a prompt, including the two special tokens."""

    def token_embeddings(self, text: str) -> Tensor:
        """Return the embeddings (K, width) of a text's tokens, from which a pseudo-word may be initialized."""

    def encode(self, prompts: Sequence[Prompt], vectors: Vectors | None = None) -> Tensor:
        """Return the hidden states (B, context_length, width) of prompts with the vectors of their handles.

        Raises SceneError("value") for a handle without vectors, or with vectors of another width.
        """


class ClipPromptEncoder:
    """Penultimate hidden states of an OpenCLIP text encoder, the conditioning of MVDream and Stable Diffusion 2."""

    def __init__(self, encoder: TextEncoder) -> None:
        self._encoder = encoder

    @property
    def width(self) -> int:
        return self._encoder.width

    @property
    def context_length(self) -> int:
        return self._encoder.context_length

    def token_embeddings(self, text: str) -> Tensor:
        return self._encoder.token_embeddings(text)  # type: ignore[no-any-return]

    def encode(self, prompts: Sequence[Prompt], vectors: Vectors | None = None) -> Tensor:
        return self._encoder.encode(prompts, vectors).penultimate  # type: ignore[no-any-return]


@dataclass(frozen=True, slots=True, eq=False)
class PromptEmbeddings:
    """Encodings of B prompts: ``hidden_states`` (B, T, D), and ``pooled`` (B, D), those at the end-of-text tokens."""

    hidden_states: Tensor
    pooled: Tensor


class TransformersPromptEncoder:
    """Last hidden states of ``network``, a CLIPTextModel of transformers, with its CLIPTokenizer."""

    def __init__(self, network: Any, tokenizer: Any) -> None:
        self._torch = require("torch", INSTALL)
        self.network = network
        self.tokenizer = tokenizer

    @property
    def width(self) -> int:
        return int(self.network.config.hidden_size)

    @property
    def context_length(self) -> int:
        return int(self.network.config.max_position_embeddings)

    def token_embeddings(self, text: str) -> Tensor:
        table = self.network.get_input_embeddings()
        return table(self._torch.tensor(self._tokenize(text), device=table.weight.device))  # type: ignore[no-any-return]

    def encode(self, prompts: Sequence[Prompt], vectors: Vectors | None = None) -> Tensor:
        return self.encode_with_pooled(prompts, vectors).hidden_states

    def encode_with_pooled(self, prompts: Sequence[Prompt], vectors: Vectors | None = None) -> PromptEmbeddings:
        """Encode prompts as ``encode`` does, and also return the pooled states."""
        tokenizer = self.tokenizer
        vocabulary = PromptVocabulary(
            self._tokenize,
            tokenizer.bos_token_id,
            tokenizer.eos_token_id,
            tokenizer.pad_token_id,
            self.context_length,
            self.width,
        )
        table = self.network.get_input_embeddings()
        tokens = tokenize_prompts(prompts, vectors or {}, vocabulary, table.weight.device)

        def replace_learned(module: Any, inputs: Any, embedded: Tensor) -> Any:
            return self._torch.where(tokens.mask[..., None], tokens.vectors.to(embedded.dtype), embedded)

        options = {}
        if getattr(self.network.config, "use_attention_mask", False):  # of some checkpoints of Stable Diffusion 2
            positions = self._torch.arange(self.context_length, device=tokens.ids.device)
            options["attention_mask"] = (positions <= tokens.eos_positions[:, None]).long()
        hook = table.register_forward_hook(replace_learned)  # CLIPTextModel has no argument for embeddings
        try:
            states = self.network(input_ids=tokens.ids, **options).last_hidden_state
        finally:
            hook.remove()
        rows = self._torch.arange(len(states), device=states.device)
        return PromptEmbeddings(states, states[rows, tokens.eos_positions])

    def _tokenize(self, text: str) -> list[int]:
        """Tokenize a text without special tokens.

        The padding token of Stable Diffusion 2 is "!", and diffusers would treat one in a prompt as padding. OpenCLIP,
        which trained the text encoder, does not.
        """
        return list(self.tokenizer(text, add_special_tokens=False, split_special_tokens=True).input_ids)


def depth_condition(depth: Tensor, covered: Tensor) -> Tensor:
    """Return the conditioning image (1, 3, H, W) of a depth ControlNet, in [0, 1].

    Depth ControlNets are trained on inverse depth, as estimated by MiDaS: the nearest pixel is 1 and the farthest .1,
    linearly in 1 / depth. What is not ``covered`` (H, W) is 0.
    """
    import torch

    inverse = torch.where(covered, 1.0 / depth.clamp_min(1e-6), 0.0)
    if bool(covered.any()):
        low, high = inverse[covered].min(), inverse[covered].max()
        share = (inverse - low) / (high - low) if bool(high > low) else torch.ones_like(inverse)
        inverse = torch.where(covered, 0.1 + 0.9 * share, 0.0)
    return inverse[None, None].expand(1, 3, -1, -1)


@dataclass(frozen=True, slots=True, eq=False)
class DiffusionModel:
    """Diffusion model with its components.

    Attributes
    ----------
    name
        Name or path from which it was loaded.
    network
        UNet2DConditionModel of diffusers.
    schedule
        Noise schedule.
    codec
        Mapping between images and latents.
    text_encoder
        Encoder of prompts.
    size
        Side of the training images, in pixels.
    views
        Number of images denoised jointly; 1 for a model without camera conditioning.
    control
        ControlNetModel for depth maps, or None.
    """

    name: str
    network: Any
    schedule: NoiseSchedule
    codec: LatentCodec
    text_encoder: PromptEncoder
    size: int
    views: int = 1
    control: Any = None

    def __post_init__(self) -> None:
        for network in (self.network, self.control):
            if self.views > 1 and network is not None and network.class_embedding is not None:
                fold_views(network)

    def predict(
        self,
        latents: Tensor,
        timesteps: Tensor,
        hidden_states: Tensor,
        cameras: Tensor | None = None,
        depth: Tensor | None = None,
    ) -> Tensor:
        """Return the network's output (B, C, h, w) for noisy latents.

        Parameters
        ----------
        latents : Tensor
            (B, C, h, w); the output has their dtype, the network computes in that of its weights.
        timesteps : Tensor
            (B,).
        hidden_states : Tensor
            (B, T, D), of the prompts.
        cameras : Tensor, optional
            (B, 16), from ``camera_rows``. Each ``views`` consecutive rows are denoised jointly, so B is a multiple of
            ``views``; by default every image is denoised independently and without camera.
        depth : Tensor, optional
            (B, 3, H, W) in [0, 1], conditioning image of the ControlNet.

        Raises
        ------
        SceneError
            "value" if the model does not support cameras or depth, or their shape is wrong.
        """
        if cameras is not None:
            self._check(cameras, len(latents))
        residuals = {} if depth is None else self._control_residuals(latents, timesteps, hidden_states, cameras, depth)
        dtype = self.network.dtype
        output = self.network(
            latents.to(dtype),
            timesteps,
            encoder_hidden_states=hidden_states.to(dtype),
            **self._camera_conditioning(self.network, latents, cameras),
            **residuals,
            return_dict=False,
        )[0]
        return output.to(latents.dtype)  # type: ignore[no-any-return]

    def _control_residuals(
        self, latents: Tensor, timesteps: Tensor, hidden_states: Tensor, cameras: Tensor | None, depth: Tensor
    ) -> dict[str, Any]:
        """Return the residuals that the ControlNet adds to the features of the UNet."""
        if self.control is None:
            message = f"the model `{self.name}` has no ControlNet, so it cannot be conditioned on depth"
            raise SceneError("value", message, hint="specify a depth ControlNet for this model")
        dtype, unet_dtype = self.control.dtype, self.network.dtype
        down, middle = self.control(
            latents.to(dtype),
            timesteps,
            encoder_hidden_states=hidden_states.to(dtype),
            controlnet_cond=depth.to(dtype),
            **self._camera_conditioning(self.control, latents, cameras),
            return_dict=False,
        )
        return {
            "down_block_additional_residuals": [part.to(unet_dtype) for part in down],
            "mid_block_additional_residual": middle.to(unet_dtype),
        }

    def _camera_conditioning(self, network: Any, latents: Tensor, cameras: Tensor | None) -> dict[str, Any]:
        """Return the keyword arguments of ``network`` for cameras and view groups."""
        if self.views == 1 or network.class_embedding is None:
            return {}
        rows = latents.new_zeros((len(latents), 16)) if cameras is None else cameras
        views = 1 if cameras is None else self.views
        return {
            "class_labels": rows.to(latents.device, network.dtype),
            "cross_attention_kwargs": {"views": views},
        }

    def _check(self, cameras: Tensor, count: int) -> None:
        if self.views == 1:
            raise SceneError("value", f"the model `{self.name}` denoises single images and has no camera conditioning")
        if cameras.shape != (count, 16) or count % self.views:
            shape = " x ".join(map(str, cameras.shape))
            message = f"`{self.name}` expects cameras of shape B x 16 with B a multiple of {self.views}"
            raise SceneError("value", f"{message}, got {shape} for {count} images")
