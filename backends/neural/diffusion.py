"""A diffusion model with all that belongs to it."""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from scenelang.backends.base import need
from scenelang.backends.neural.clip import Prompt, PromptVocabulary, TextEncoder, Vectors, tokens_of
from scenelang.backends.neural.weights import INSTALL
from scenelang.backends.pictures.camera import Camera, FloatArray
from scenelang.grammar.diagnostics import SceneError

if TYPE_CHECKING:
    from torch import Tensor


# A GPU whose memory is full, told in one line.


@contextmanager
def memory_told() -> Iterator[None]:
    """Raises SceneError("unsupported") in place of torch's error where the block runs out of the GPU's memory."""
    torch = need("torch", INSTALL)
    try:
        yield
    except torch.OutOfMemoryError as error:
        hint = "smaller pictures or models, fewer Gaussians or steps at once, or --device cpu"
        raise SceneError("unsupported", "the memory of the GPU is full", hint=hint) from error


# What makes a UNet of diffusers one of several views: cameras as conditions, self-attention over all views (MVDream).
#
# The network is a ``UNet2DConditionModel(class_embed_type="projection", projection_class_embeddings_input_dim=16)``.


VIEWS = 4  # that MVDream was trained on

# Our world in MVDream's. Ours has +y up, and the front of a thing at +z (azimuth 0). MVDream's is Blender's, +z up,
# with the front at +x: its sampling script begins with the view of azimuth 90, where `get_camera` puts the eye at +x,
# and threestudio, which trains with its cameras, counts azimuths from +x with the front at 0. So +z becomes +x, +y
# becomes +z and, since the turn keeps handedness, +x becomes +y.
_WORLD = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])


# --- cameras ---------------------------------------------------------------------------------------------------------


def camera_row(world_to_camera: FloatArray) -> FloatArray:
    """The 16 numbers that MVDream knows a camera by, which looks at a thing around the origin.

    ``world_to_camera`` (4, 4) is rigid, its axes those of ``camera.Camera``. The numbers are the rows of the matrix
    from camera (x right, y up, z back) to Blender's world, the eye moved to distance 1.
    """
    turn = world_to_camera[:3, :3].T
    eye = -turn @ world_to_camera[:3, 3]
    pose = np.eye(4)
    pose[:3, :3] = _WORLD @ turn @ np.diag([1.0, -1.0, -1.0])
    pose[:3, 3] = _WORLD @ eye / max(float(np.linalg.norm(eye)), 1e-8)
    return pose.reshape(16)


def camera_rows(cameras: Sequence[Camera]) -> Tensor:
    """(V, 16) of cameras whose thing stands around the origin."""
    torch = need("torch", INSTALL)
    rows = np.stack([camera_row(camera.world_to_camera) for camera in cameras])
    return torch.from_numpy(rows).float()  # type: ignore[no-any-return]


# --- the network -----------------------------------------------------------------------------------------------------


def fold_views(network: Any) -> None:
    """Gives ``network``, a UNet or ControlNet with cameras for classes, what it needs to denoise views together.

    It then takes ``cross_attention_kwargs={"views": V}``: each run of V rows of a batch is one group. A row of zeros
    in ``class_labels`` stands for no camera, and adds nothing to the embedding of the step.
    """
    if any(isinstance(processor, FoldedAttention) for processor in network.attn_processors.values()):
        return
    network.set_attn_processor(FoldedAttention())
    network.class_embedding.register_forward_hook(_without_camera)


class FoldedAttention:
    """Attention of diffusers whose tokens look at those of all views of their group; words are looked at as usual."""

    def __init__(self) -> None:
        self._plain = need("diffusers.models.attention_processor", INSTALL).AttnProcessor2_0()

    def __call__(
        self,
        attn: Any,
        hidden_states: Tensor,
        encoder_hidden_states: Tensor | None = None,
        attention_mask: Tensor | None = None,
        temb: Tensor | None = None,
        views: int = 1,
    ) -> Tensor:
        """``hidden_states`` (B, L, C), B a multiple of ``views``; the same shape comes back."""
        if encoder_hidden_states is not None:
            found = self._plain(attn, hidden_states, encoder_hidden_states, attention_mask, temb)
            return found  # type: ignore[no-any-return]
        batch, length, width = hidden_states.shape
        together = hidden_states.reshape(batch // views, views * length, width)
        return self._plain(attn, together).reshape(batch, length, -1)  # type: ignore[no-any-return]


def _without_camera(module: Any, given: tuple[Tensor, ...], embedding: Tensor) -> Tensor:
    """Nothing for rows without a camera; a camera's own row is never zero, since it ends in 1."""
    return embedding * (given[0] != 0).any(-1, keepdim=True)


# From pictures to what a diffusion model denoises, and back.


class Pixels(Protocol):
    """Both ways are differentiable. Pictures (B, 3, H, W) are sRGB in [0, 1], H and W multiples of ``factor``;
    latents (B, C, H / factor, W / factor). What comes back of a picture keeps its type and device."""

    @property
    def factor(self) -> int:
        """Pixels of a picture for one of the latents, along a side."""

    def encode(self, pictures: Tensor) -> Tensor:
        """The latents of pictures."""

    def decode(self, latents: Tensor) -> Tensor:
        """The pictures of latents, not cut to [0, 1]."""


class Autoencoder:
    """Latents of an AutoencoderKL: the mean of what it takes a picture for, times its scaling factor."""

    def __init__(self, network: Any) -> None:
        self._network = network
        self._scale = float(network.config.scaling_factor)

    @property
    def factor(self) -> int:
        return 1 << (len(self._network.config.block_out_channels) - 1)

    def encode(self, pictures: Tensor) -> Tensor:
        found = self._network.encode((2.0 * pictures - 1.0).to(self._network.dtype)).latent_dist.mean
        return (found * self._scale).to(pictures.dtype)  # type: ignore[no-any-return]

    def decode(self, latents: Tensor) -> Tensor:
        found = self._network.decode((latents / self._scale).to(self._network.dtype)).sample
        return (found.to(latents.dtype) + 1.0) / 2.0  # type: ignore[no-any-return]


class Unshuffled:
    """Latents of models without an autoencoder: the pixels of squares of ``factor`` x ``factor`` as channels."""

    def __init__(self, factor: int) -> None:
        self._functional = need("torch.nn.functional", INSTALL)
        self._factor = factor

    @property
    def factor(self) -> int:
        return self._factor

    def encode(self, pictures: Tensor) -> Tensor:
        return self._functional.pixel_unshuffle(2.0 * pictures - 1.0, self._factor)  # type: ignore[no-any-return]

    def decode(self, latents: Tensor) -> Tensor:
        return (self._functional.pixel_shuffle(latents, self._factor) + 1.0) / 2.0  # type: ignore[no-any-return]


# Libraries of models that say on the terminal what we say in errors.


@contextmanager
def quiet_libraries(bars: bool) -> Iterator[None]:
    """diffusers and transformers report errors only in the block; ``bars``: they still show how far downloads are."""
    libraries = [need(f"{name}.utils.logging", INSTALL) for name in ("diffusers", "transformers")]
    levels = [library.get_verbosity() for library in libraries]
    shown = libraries[1].is_progress_bar_enabled()
    for library in libraries:
        library.set_verbosity_error()
    if not bars and shown:
        libraries[1].disable_progress_bar()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    finally:
        for library, level in zip(libraries, levels, strict=True):
            library.set_verbosity(level)
        if not bars and shown:
            libraries[1].enable_progress_bar()


# How much noise there is at each step, and what a network's output says of picture and noise.


PREDICTIONS = ("epsilon", "v_prediction", "sample")
_MOST_STEPS = 10_000


@dataclass(frozen=True, slots=True, eq=False)
class Schedule:
    """``alphas`` (T,) are the shares of the picture's variance that are left after each step, the cumulative products
    of DDPM; ``prediction``, one of PREDICTIONS, is what the network's output means: the noise, the velocity
    ``sqrt(a) noise - sqrt(1 - a) clean``, or the clean picture."""

    alphas: Tensor
    prediction: str = "epsilon"

    @property
    def steps(self) -> int:
        """T; steps count from 0, the least noise, to T - 1."""
        return len(self.alphas)

    def noised(self, clean: Tensor, noise: Tensor, steps: Tensor) -> Tensor:
        """``clean`` (B, ...) with ``noise`` of that shape as after ``steps`` (B,)."""
        signal, spread = self._shares(clean, steps)
        return signal * clean + spread * noise

    def target(self, clean: Tensor, noise: Tensor, steps: Tensor) -> Tensor:
        """What the network was trained to say of ``clean`` (B, ...) with ``noise`` as after ``steps`` (B,)."""
        if self.prediction == "epsilon":
            return noise
        if self.prediction == "sample":
            return clean
        signal, spread = self._shares(clean, steps)
        return signal * noise - spread * clean

    def noise_of(self, output: Tensor, noisy: Tensor, steps: Tensor) -> Tensor:
        """The noise that ``output`` (B, ...) of the network sees in ``noisy`` after ``steps`` (B,)."""
        if self.prediction == "epsilon":
            return output
        signal, spread = self._shares(noisy, steps)
        if self.prediction == "v_prediction":
            return signal * output + spread * noisy
        return (noisy - signal * output) / spread

    def clean_of(self, output: Tensor, noisy: Tensor, steps: Tensor) -> Tensor:
        """What ``output`` (B, ...) of the network takes for the picture in ``noisy`` after ``steps`` (B,).

        From predicted noise it is not finite at a step that leaves nothing of the picture.
        """
        if self.prediction == "sample":
            return output
        signal, spread = self._shares(noisy, steps)
        if self.prediction == "v_prediction":
            return signal * noisy - spread * output
        return (noisy - spread * output) / signal

    def _shares(self, like: Tensor, steps: Tensor) -> tuple[Tensor, Tensor]:
        alphas = self.alphas.to(like.device)[steps.to(like.device)]
        alphas = alphas.reshape(-1, *[1] * (like.ndim - 1))
        return alphas.sqrt().to(like.dtype), (1.0 - alphas).sqrt().to(like.dtype)


def schedule_of(config: Mapping[str, Any]) -> Schedule:
    """The schedule of a ``scheduler_config.json`` of diffusers, as its DDPMScheduler computes it.

    Raises SceneError("weights") for schedules that are not known here.
    """
    torch = need("torch", INSTALL)
    prediction = config.get("prediction_type", "epsilon")
    if prediction not in PREDICTIONS:
        raise SceneError("weights", f"a scheduler that predicts {prediction!r} is not known ({', '.join(PREDICTIONS)})")
    alphas = torch.cumprod(1.0 - _betas(torch, config), dim=0)
    if config.get("rescale_betas_zero_snr"):
        alphas = _to_nothing(alphas)
    if not bool(torch.isfinite(alphas).all() and (alphas >= 0.0).all() and (alphas <= 1.0).all()):
        raise SceneError("weights", "the scheduler's betas are not between 0 and 1")
    return Schedule(alphas, prediction)


def _betas(torch: Any, config: Mapping[str, Any]) -> Any:
    kind = config.get("beta_schedule", "linear")
    given = config.get("trained_betas")
    steps = len(given) if given is not None else config.get("num_train_timesteps", 1000)
    if type(steps) is not int or not 2 <= steps <= _MOST_STEPS:
        raise SceneError("weights", f"a scheduler has 2 to {_MOST_STEPS:,} steps, not {steps!r}")
    if given is not None:
        return torch.tensor(given, dtype=torch.float32)
    start, end = float(config.get("beta_start", 0.0001)), float(config.get("beta_end", 0.02))
    if not 0.0 < start < 1.0 or not 0.0 < end < 1.0:
        raise SceneError("weights", f"the scheduler's betas are not between 0 and 1: {start:g}, {end:g}")
    if kind == "linear":
        return torch.linspace(start, end, steps, dtype=torch.float32)
    if kind == "scaled_linear":
        return torch.linspace(start**0.5, end**0.5, steps, dtype=torch.float32) ** 2
    if kind == "squaredcos_cap_v2":
        left = [math.cos((i / steps + 0.008) / 1.008 * math.pi / 2.0) ** 2 for i in range(steps + 1)]
        return torch.tensor([min(1.0 - left[i + 1] / left[i], 0.999) for i in range(steps)], dtype=torch.float32)
    raise SceneError("weights", f"the beta schedule {kind!r} is not known (linear, scaled_linear, squaredcos_cap_v2)")


def _to_nothing(alphas: Any) -> Any:
    """Shifted and stretched so that the last step leaves nothing of the picture, and the first stays as it is."""
    roots = alphas.sqrt()
    first, last = roots[0].clone(), roots[-1].clone()
    return ((roots - last) * (first / (first - last))) ** 2


# Prompts as the states that a diffusion model listens to, with learned vectors in place of handles.


class Words(Protocol):
    """Gradients flow into the vectors and nowhere else."""

    @property
    def width(self) -> int:
        """Numbers of a token's vector, and of a state."""

    @property
    def context(self) -> int:
        """Tokens of a prompt, the two at its ends included."""

    def vectors_of(self, text: str) -> Tensor:
        """The vectors (K, width) of a text's own tokens: what a pseudo-word may start from."""

    def encode(self, prompts: Sequence[Prompt], vectors: Vectors | None = None) -> Tensor:
        """The states (B, context, width) of prompts with the vectors of their handles; raises SceneError("value") for
        a handle without any, or of vectors of another width."""


class ClipWords:
    """States of the layer before the last of an OpenCLIP text encoder, what MVDream and Stable Diffusion 2 hear."""

    def __init__(self, encoder: TextEncoder) -> None:
        self._encoder = encoder

    @property
    def width(self) -> int:
        return self._encoder.width

    @property
    def context(self) -> int:
        return self._encoder.context

    def vectors_of(self, text: str) -> Tensor:
        return self._encoder.vectors_of(text)  # type: ignore[no-any-return]

    def encode(self, prompts: Sequence[Prompt], vectors: Vectors | None = None) -> Tensor:
        return self._encoder.encode(prompts, vectors).earlier  # type: ignore[no-any-return]


@dataclass(frozen=True, slots=True, eq=False)
class PromptEmbeddings:
    """B prompts encoded: ``words`` (B, T, D) are what attention reads, ``pooled`` (B, D) the states at their ends."""

    words: Tensor
    pooled: Tensor


class TransformerWords:
    """States of the last layer of ``network``, a CLIPTextModel of transformers; ``tokenizer`` is its CLIPTokenizer."""

    def __init__(self, network: Any, tokenizer: Any) -> None:
        self._torch = need("torch", INSTALL)
        self.network = network
        self.tokenizer = tokenizer

    @property
    def width(self) -> int:
        return int(self.network.config.hidden_size)

    @property
    def context(self) -> int:
        return int(self.network.config.max_position_embeddings)

    def vectors_of(self, text: str) -> Tensor:
        table = self.network.get_input_embeddings()
        return table(self._torch.tensor(self._numbers(text), device=table.weight.device))  # type: ignore[no-any-return]

    def encode(self, prompts: Sequence[Prompt], vectors: Vectors | None = None) -> Tensor:
        return self.encoded(prompts, vectors).words

    def encoded(self, prompts: Sequence[Prompt], vectors: Vectors | None = None) -> PromptEmbeddings:
        """As ``encode``, with the states at the ends of the prompts."""
        tokenizer = self.tokenizer
        vocabulary = PromptVocabulary(
            self._numbers,
            tokenizer.bos_token_id,
            tokenizer.eos_token_id,
            tokenizer.pad_token_id,
            self.context,
            self.width,
        )
        table = self.network.get_input_embeddings()
        tokens = tokens_of(prompts, vectors or {}, vocabulary, table.weight.device)

        def spliced(module: Any, given: Any, own: Tensor) -> Any:
            return self._torch.where(tokens.mask[..., None], tokens.vectors.to(own.dtype), own)

        options = {}
        if getattr(self.network.config, "use_attention_mask", False):  # of some checkpoints of Stable Diffusion 2
            places = self._torch.arange(self.context, device=tokens.ids.device)
            options["attention_mask"] = (places <= tokens.ends[:, None]).long()
        hook = table.register_forward_hook(spliced)  # the network itself takes nothing but token numbers
        try:
            states = self.network(input_ids=tokens.ids, **options).last_hidden_state
        finally:
            hook.remove()
        return PromptEmbeddings(states, states[self._torch.arange(len(states), device=states.device), tokens.ends])

    def _numbers(self, text: str) -> list[int]:
        """No part of a text is a special token: Stable Diffusion 2 calls its padding "!"."""
        return list(self.tokenizer(text, add_special_tokens=False, split_special_tokens=True).input_ids)


@dataclass(frozen=True, slots=True, eq=False)
class Diffusion:
    """``network`` is a UNet2DConditionModel of diffusers, made ready for its views here; ``size`` the pixels of a
    picture's side that it was trained on, ``views`` how many pictures it denoises together, 1 where it knows no
    cameras; ``control`` a ControlNetModel that keeps pictures to a depth map."""

    name: str
    network: Any
    schedule: Schedule
    pixels: Pixels
    words: Words
    size: int
    views: int = 1
    control: Any = None

    def __post_init__(self) -> None:
        for network in (self.network, self.control):
            if self.views > 1 and network is not None and network.class_embedding is not None:
                fold_views(network)

    def predict(
        self, latents: Tensor, steps: Tensor, states: Tensor, cameras: Tensor | None = None, depth: Tensor | None = None
    ) -> Tensor:
        """The network's output (B, C, h, w) for noisy ``latents`` of that shape after ``steps`` (B,), told ``states``
        (B, T, D) of the prompts.

        ``cameras`` (B, 16), rows of ``multiview.camera_rows``: each run of ``views`` rows is denoised together, so B
        is a multiple of that. Without them every picture is denoised alone and without camera. ``depth`` (B, 3, H, W)
        in [0, 1] is the control's picture. The weights' type is used inside, that of ``latents`` comes back. Raises
        SceneError("value") for cameras or depth that this model cannot take.
        """
        if cameras is not None:
            self._check(cameras, len(latents))
        residuals = {} if depth is None else self._controlled(latents, steps, states, cameras, depth)
        kind = self.network.dtype
        output = self.network(
            latents.to(kind),
            steps,
            encoder_hidden_states=states.to(kind),
            **self._conditions(self.network, latents, cameras),
            **residuals,
            return_dict=False,
        )[0]
        return output.to(latents.dtype)  # type: ignore[no-any-return]

    def _controlled(
        self, latents: Tensor, steps: Tensor, states: Tensor, cameras: Tensor | None, depth: Tensor
    ) -> dict[str, Any]:
        """What the control adds to the network's own features."""
        if self.control is None:
            hint = "name a ControlNet for depth that belongs to it"
            raise SceneError(
                "value", f"the model `{self.name}` has no control, so it cannot keep to a depth", hint=hint
            )
        kind, own = self.control.dtype, self.network.dtype
        down, middle = self.control(
            latents.to(kind),
            steps,
            encoder_hidden_states=states.to(kind),
            controlnet_cond=depth.to(kind),
            **self._conditions(self.control, latents, cameras),
            return_dict=False,
        )
        return {
            "down_block_additional_residuals": [part.to(own) for part in down],
            "mid_block_additional_residual": middle.to(own),
        }

    def _conditions(self, network: Any, latents: Tensor, cameras: Tensor | None) -> dict[str, Any]:
        """Cameras and groups as ``network`` takes them."""
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
            raise SceneError("value", f"the model `{self.name}` denoises single pictures and knows no cameras")
        if cameras.shape != (count, 16) or count % self.views:
            shape = " x ".join(map(str, cameras.shape))
            message = f"{count} pictures with cameras of {shape} numbers; `{self.name}` wants groups of {self.views}"
            raise SceneError("value", f"{message}, and 16 numbers each")
