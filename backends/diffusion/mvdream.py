"""MVDream's original checkpoint, one file, as UNet and autoencoder of diffusers and OpenCLIP's text encoder."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from scenelang.backends.base import need
from scenelang.backends.clip.towers import empty_tower, text_weights
from scenelang.backends.diffusion.fitting import fitted, other_model, read_tensors
from scenelang.backends.diffusion.mvdream_keys import (
    NO_WEIGHTS,
    TEXT,
    UNET,
    VAE,
    from_checkpoint,
    text_names,
    to_checkpoint,
    unet_names,
    vae_names,
)
from scenelang.backends.files import written_together
from scenelang.backends.weights import INSTALL

REPOSITORY, FILE = "MVDream/MVDream", "sd-v2.1-base-4view.pt"


def _unet() -> dict[str, Any]:
    return {
        "sample_size": 32,
        "in_channels": 4,
        "out_channels": 4,
        "block_out_channels": (320, 640, 1280, 1280),
        "layers_per_block": 2,
        "attention_head_dim": (5, 10, 20, 20),
        "cross_attention_dim": 1024,
        "use_linear_projection": True,
        "class_embed_type": "projection",
        "projection_class_embeddings_input_dim": 16,
    }


def _vae() -> dict[str, Any]:
    return {
        "sample_size": 256,
        "in_channels": 3,
        "out_channels": 3,
        "latent_channels": 4,
        "block_out_channels": (128, 256, 512, 512),
        "layers_per_block": 2,
        "down_block_types": ("DownEncoderBlock2D",) * 4,
        "up_block_types": ("UpDecoderBlock2D",) * 4,
        "scaling_factor": 0.18215,
    }


def _text() -> dict[str, Any]:
    settings = {"context_length": 77, "vocab_size": 49408, "width": 1024, "heads": 16, "layers": 24}
    return {"embed_dim": 1024, "text_cfg": settings}


def _scheduler() -> dict[str, Any]:
    return {
        "_class_name": "DDPMScheduler",
        "num_train_timesteps": 1000,
        "beta_schedule": "scaled_linear",
        "beta_start": 0.00085,
        "beta_end": 0.012,
        "prediction_type": "epsilon",
        "clip_sample": False,
    }


@dataclass(frozen=True, slots=True)
class Architecture:
    """The settings of the networks in a checkpoint: those of diffusers' UNet2DConditionModel and AutoencoderKL, a
    ``model_cfg`` of OpenCLIP, and a scheduler's. By default those of ``sd-v2.1-base-4view.pt``."""

    unet: Mapping[str, Any] = field(default_factory=_unet)
    vae: Mapping[str, Any] = field(default_factory=_vae)
    text: Mapping[str, Any] = field(default_factory=_text)
    scheduler: Mapping[str, Any] = field(default_factory=_scheduler)


ORIGINAL = Architecture()


@dataclass(frozen=True, slots=True, eq=False)
class Networks:
    """A UNet2DConditionModel, an AutoencoderKL, and the text encoder of an OpenCLIP model."""

    unet: Any
    vae: Any
    text: Any


def empty_networks(architecture: Architecture = ORIGINAL) -> Networks:
    """The networks on torch's device "meta": names and shapes without weights."""
    torch = need("torch", INSTALL)
    diffusers = need("diffusers", INSTALL)
    with torch.device("meta"):
        unet = diffusers.UNet2DConditionModel(**architecture.unet)
        vae = diffusers.AutoencoderKL(**architecture.vae)
    return Networks(unet, vae, empty_tower(architecture.text))


def read_mvdream(path: Path, architecture: Architecture = ORIGINAL) -> Networks:
    """The networks of a checkpoint, on the CPU; raises SceneError("weights") where it is not one of these."""
    tensors = read_tensors(path)
    for key in tensors:
        if not key.startswith((UNET, VAE, TEXT)) and key not in NO_WEIGHTS:
            raise other_model(path.name, f"`{key}` does not belong there")
    empty = empty_networks(architecture)
    parts = ((empty.unet, UNET, unet_names), (empty.vae, VAE, vae_names), (empty.text, TEXT, text_names))
    found = []
    for network, prefix, naming in parts:
        names = naming(network.state_dict())
        found.append(fitted(path.name, network, from_checkpoint(tensors, prefix, names), names))
    return Networks(*found)


def mvdream_tensors(networks: Networks) -> dict[str, Any]:
    """The checkpoint of networks: what ``read_mvdream`` reads back."""
    unet, vae, text = networks.unet.state_dict(), networks.vae.state_dict(), text_weights(networks.text.state_dict())
    return {
        **to_checkpoint(unet, unet_names(unet)),
        **to_checkpoint(vae, vae_names(vae)),
        **to_checkpoint(text, text_names(text)),
    }


def convert_mvdream(path: Path, folder: Path, architecture: Architecture = ORIGINAL) -> None:
    """Write the checkpoint ``path`` as the new ``folder`` that ``loading.load_diffusion`` reads, whole or not at all.

    Raises SceneError: "weights" for another file, "file" where the folder cannot be written or is there already.
    """
    safetensors = need("safetensors.torch", INSTALL)
    networks = read_mvdream(path, architecture)
    with written_together(folder.parent) as made:
        place = made / folder.name
        networks.unet.save_pretrained(place / "unet")
        networks.vae.save_pretrained(place / "vae")
        (place / "text").mkdir()
        text = {key: tensor.contiguous() for key, tensor in text_weights(networks.text.state_dict()).items()}
        safetensors.save_file(text, place / "text" / "open_clip_model.safetensors")
        _write(place / "text" / "open_clip_config.json", {"model_cfg": dict(architecture.text)})
        (place / "scheduler").mkdir()
        _write(place / "scheduler" / "scheduler_config.json", dict(architecture.scheduler))


def _write(path: Path, data: Mapping[str, Any]) -> None:
    path.write_text(json.dumps(data, indent=2), "utf-8")
