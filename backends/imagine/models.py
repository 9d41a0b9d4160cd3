"""Stable Diffusion checkpoints and ControlNets in the folder layout of diffusers, by name."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from scenelang.backends.base import need
from scenelang.backends.diffusion.quiet import quiet_libraries
from scenelang.backends.diffusion.words import TransformerWords
from scenelang.backends.weights import INSTALL, Shelf
from scenelang.grammar.diagnostics import SceneError

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
