"""MVDream's original checkpoint: conversion to a UNet and autoencoder of diffusers and OpenCLIP's text encoder.

The checkpoint is one file with the key names of CompVis' latent diffusion code.
"""

from __future__ import annotations

import json
import pickle
import re
import warnings
import zipfile
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from scenelang.backends.base import require
from scenelang.backends.files import atomic_write_all
from scenelang.backends.neural.clip import build_text_tower, text_weights
from scenelang.backends.neural.weights import INSTALL
from scenelang.grammar.diagnostics import SceneError

# Reading weights, with strict checks of names and shapes.


_MAX_CONFIG_BYTES = 1_000_000


def load_weights(
    source: str, network: Any, tensors: Mapping[str, Any], source_names: Mapping[str, str] | None = None
) -> Any:
    """Load ``tensors`` into ``network``, which may be on the device "meta"; returns it frozen.

    ``source_names`` maps keys to their names in the file, for messages. Raises SceneError("weights") with the first key
    that is missing, unexpected, or has another shape.
    """
    names = source_names or {}
    expected = network.state_dict()
    for key, like in expected.items():
        if key not in tensors:
            raise weights_mismatch(source, f"missing key `{names.get(key, key)}`")
        if tensors[key].shape != like.shape:
            actual, shape = (" x ".join(map(str, each)) for each in (tensors[key].shape, like.shape))
            raise weights_mismatch(source, f"`{names.get(key, key)}` has the shape {actual}, expected {shape}")
    for key in tensors:
        if key not in expected:
            raise weights_mismatch(source, f"unexpected key `{key}`")
    network.load_state_dict(dict(tensors), assign=True)
    return network.eval().requires_grad_(False)


def weights_mismatch(source: str, reason: str) -> SceneError:
    """Return the error for a ``source`` that does not contain the weights of the expected model."""
    return SceneError("weights", f"{source} does not contain the weights of the expected model: {reason}")


def read_tensors(path: Path) -> dict[str, Any]:
    """Read the tensors of a ``.safetensors``, ``.pt`` or ``.ckpt`` file, by name.

    Of the last two formats, ``state_dict`` is read if it exists. No code in the file is executed, and torch
    memory-maps it if possible. Raises SceneError("weights") if the file contains anything but tensors.
    """
    torch = require("torch", INSTALL)
    try:
        if path.suffix.lower() == ".safetensors":
            return dict(require("safetensors.torch", INSTALL).load_file(path))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # concerns files that are rejected anyway
            loaded = torch.load(path, map_location="cpu", weights_only=True, mmap=zipfile.is_zipfile(path))
    except pickle.UnpicklingError:  # torch's message recommends weights_only=False, which executes code in the file
        raise weights_mismatch(path.name, "it is damaged or contains objects other than tensors") from None
    except Exception as error:  # the libraries' errors for damaged files have no common type
        raise weights_mismatch(path.name, " ".join(str(error).split())[:160] or type(error).__name__) from error
    tensors = loaded.get("state_dict", loaded) if isinstance(loaded, dict) else None
    if not isinstance(tensors, dict) or not all(
        isinstance(key, str) and isinstance(value, torch.Tensor) for key, value in tensors.items()
    ):
        raise weights_mismatch(path.name, "it is not a state dict: expected tensors by name")
    return tensors


def read_config(path: Path) -> dict[str, Any]:
    """Read a JSON object; raises SceneError("weights") for any other content."""
    try:
        if path.stat().st_size > _MAX_CONFIG_BYTES:
            raise weights_mismatch(str(path), f"expected a configuration of at most {_MAX_CONFIG_BYTES:,} bytes")
        data = json.loads(path.read_text("utf-8"))
    except (OSError, ValueError, RecursionError) as error:
        raise weights_mismatch(str(path), str(error)[:160]) from error
    if not isinstance(data, dict):
        raise weights_mismatch(str(path), "expected a JSON object")
    return data


# Key names of the original checkpoint. CompVis numbers the UNet's blocks consecutively, diffusers by level; the
# autoencoders' names differ in words. The mappings go from diffusers' names to the checkpoint's.


UNET, VAE, TEXT = "model.diffusion_model.", "first_stage_model.", "cond_stage_model.model."
NO_WEIGHTS = {  # buffers of the noise schedule in the checkpoint, and parts of CLIP that the text encoder does not use
    "betas", "alphas_cumprod", "alphas_cumprod_prev", "sqrt_alphas_cumprod", "sqrt_one_minus_alphas_cumprod",
    "log_one_minus_alphas_cumprod", "sqrt_recip_alphas_cumprod", "sqrt_recipm1_alphas_cumprod", "posterior_variance",
    "posterior_log_variance_clipped", "posterior_mean_coef1", "posterior_mean_coef2", f"{TEXT}logit_scale",
    f"{TEXT}attn_mask",
}  # fmt: skip

_ENDS = {
    "conv_in": "input_blocks.0.0",
    "conv_norm_out": "out.0",
    "conv_out": "out.2",
    "time_embedding.linear_1": "time_embed.0",
    "time_embedding.linear_2": "time_embed.2",
    "class_embedding.linear_1": "camera_embed.0",
    "class_embedding.linear_2": "camera_embed.2",
    "mid_block.resnets.0": "middle_block.0",
    "mid_block.attentions.0": "middle_block.1",
    "mid_block.resnets.1": "middle_block.2",
}
_RESNET = {
    "norm1": "in_layers.0",
    "conv1": "in_layers.2",
    "time_emb_proj": "emb_layers.1",
    "norm2": "out_layers.0",
    "conv2": "out_layers.3",
    "conv_shortcut": "skip_connection",
}
_LEVEL = re.compile(r"(down|up)_blocks\.(\d+)\.(resnets|attentions|downsamplers|upsamplers)\.(\d+)\.")
_VAE_WORDS = (
    (r"\.mid_block\.resnets\.0\.", ".mid.block_1."),
    (r"\.mid_block\.resnets\.1\.", ".mid.block_2."),
    (r"\.mid_block\.attentions\.0\.", ".mid.attn_1."),
    (r"\.down_blocks\.(\d+)\.resnets\.", r".down.\1.block."),
    (r"\.down_blocks\.(\d+)\.downsamplers\.0\.", r".down.\1.downsample."),
    (r"\.up\.(\d+)\.resnets\.", r".up.\1.block."),
    (r"\.up\.(\d+)\.upsamplers\.0\.", r".up.\1.upsample."),
    (r"\.group_norm\.", ".norm."),
    (r"\.to_(q|k|v)\.", r".\1."),
    (r"\.to_out\.0\.", ".proj_out."),
    (r"\.conv_shortcut\.", ".nin_shortcut."),
    (r"\.conv_norm_out\.", ".norm_out."),
)
_CONVOLUTIONS = re.compile(r"\.attn_1\.(q|k|v|proj_out)\.weight$")  # 1 x 1 convolutions there, linear in diffusers


def unet_names(keys: Iterable[str]) -> dict[str, str]:
    """Map all ``keys`` of a UNet of diffusers to the checkpoint's names."""
    known = list(keys)
    layers = len({key.split(".")[3] for key in known if key.startswith("down_blocks.0.resnets.")})
    attention_blocks = {key.split(".")[1] for key in known if re.match(r"up_blocks\.\d+\.attentions\.", key)}
    return {key: UNET + _unet_name(key, layers, attention_blocks) for key in known}


def _unet_name(key: str, layers: int, attention_blocks: set[str]) -> str:
    level = _LEVEL.match(key)
    if level is None:
        for name, original in _ENDS.items():
            if key.startswith(f"{name}."):
                rest = key.removeprefix(f"{name}.")
                return f"{original}.{_resnet_name(rest) if '.resnets.' in name else rest}"
        return key
    direction, block, kind, number = level[1], int(level[2]), level[3], int(level[4])
    rest = key[level.end() :]
    first = block * (layers + 1)
    if kind == "downsamplers":
        return f"input_blocks.{first + layers + 1}.0.op.{rest.removeprefix('conv.')}"
    if kind == "upsamplers":
        return f"output_blocks.{first + layers}.{2 if level[2] in attention_blocks else 1}.{rest}"
    row = f"input_blocks.{first + number + 1}" if direction == "down" else f"output_blocks.{first + number}"
    return f"{row}.0.{_resnet_name(rest)}" if kind == "resnets" else f"{row}.1.{rest}"


def _resnet_name(rest: str) -> str:
    """Return the checkpoint's name of a key relative to its residual block."""
    part, _, leaf = rest.partition(".")
    return f"{_RESNET.get(part, part)}.{leaf}"


def vae_names(keys: Iterable[str]) -> dict[str, str]:
    """Map all ``keys`` of an autoencoder of diffusers to the checkpoint's names."""
    known = list(keys)
    levels = len({key.split(".")[2] for key in known if key.startswith("decoder.up_blocks.")})
    return {key: VAE + _vae_name(key, levels) for key in known}


def _vae_name(key: str, levels: int) -> str:
    name = re.sub(r"\.up_blocks\.(\d+)\.", lambda match: f".up.{levels - 1 - int(match[1])}.", key)
    for pattern, original in _VAE_WORDS:
        name = re.sub(pattern, original, name)
    return name


def text_names(keys: Iterable[str]) -> dict[str, str]:
    """Map the ``keys`` of an OpenCLIP text encoder to the checkpoint's names."""
    return {key: TEXT + key for key in keys}


def from_checkpoint(tensors: Mapping[str, Any], prefix: str, names: Mapping[str, str]) -> dict[str, Any]:
    """Rename the checkpoint's tensors that begin with ``prefix`` by the inverse of ``names``; unknown keys remain."""
    keys = {original: key for key, original in names.items()}
    renamed = {}
    for key, tensor in tensors.items():
        if key.startswith(prefix) and key not in NO_WEIGHTS:
            is_convolution = _CONVOLUTIONS.search(key) and tensor.ndim == 4 and tensor.shape[2:] == (1, 1)
            renamed[keys.get(key, key)] = tensor[:, :, 0, 0] if is_convolution else tensor
    return renamed


def to_checkpoint(tensors: Mapping[str, Any], names: Mapping[str, str]) -> dict[str, Any]:
    """Rename tensors to the checkpoint's names: the inverse of ``from_checkpoint``."""
    renamed = {names[key]: tensor for key, tensor in tensors.items()}
    return {key: tensor[:, :, None, None] if _CONVOLUTIONS.search(key) else tensor for key, tensor in renamed.items()}


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
    """Configurations of the networks in a checkpoint; the defaults are those of ``sd-v2.1-base-4view.pt``.

    Attributes
    ----------
    unet, vae
        Arguments of UNet2DConditionModel and AutoencoderKL of diffusers.
    text
        ``model_cfg`` of OpenCLIP.
    scheduler
        Configuration of a scheduler of diffusers.
    """

    unet: Mapping[str, Any] = field(default_factory=_unet)
    vae: Mapping[str, Any] = field(default_factory=_vae)
    text: Mapping[str, Any] = field(default_factory=_text)
    scheduler: Mapping[str, Any] = field(default_factory=_scheduler)


ORIGINAL = Architecture()


@dataclass(frozen=True, slots=True, eq=False)
class Networks:
    """UNet2DConditionModel, AutoencoderKL, and the text encoder of an OpenCLIP model."""

    unet: Any
    vae: Any
    text: Any


def empty_networks(architecture: Architecture = ORIGINAL) -> Networks:
    """Build the networks on the device "meta": names and shapes without weights."""
    torch = require("torch", INSTALL)
    diffusers = require("diffusers", INSTALL)
    with torch.device("meta"):
        unet = diffusers.UNet2DConditionModel(**architecture.unet)
        vae = diffusers.AutoencoderKL(**architecture.vae)
    return Networks(unet, vae, build_text_tower(architecture.text))


def read_mvdream(path: Path, architecture: Architecture = ORIGINAL) -> Networks:
    """Load the networks of a checkpoint on the CPU; raises SceneError("weights") if it is not one of MVDream."""
    tensors = read_tensors(path)
    for key in tensors:
        if not key.startswith((UNET, VAE, TEXT)) and key not in NO_WEIGHTS:
            raise weights_mismatch(path.name, f"unexpected key `{key}`")
    empty = empty_networks(architecture)
    parts = ((empty.unet, UNET, unet_names), (empty.vae, VAE, vae_names), (empty.text, TEXT, text_names))
    networks = []
    for network, prefix, names_of in parts:
        names = names_of(network.state_dict())
        networks.append(load_weights(path.name, network, from_checkpoint(tensors, prefix, names), names))
    return Networks(*networks)


def mvdream_tensors(networks: Networks) -> dict[str, Any]:
    """Return the tensors of a checkpoint with these networks: the inverse of ``read_mvdream``."""
    unet, vae, text = networks.unet.state_dict(), networks.vae.state_dict(), text_weights(networks.text.state_dict())
    return {
        **to_checkpoint(unet, unet_names(unet)),
        **to_checkpoint(vae, vae_names(vae)),
        **to_checkpoint(text, text_names(text)),
    }


def convert_mvdream(path: Path, folder: Path, architecture: Architecture = ORIGINAL) -> None:
    """Convert the checkpoint ``path`` to a new ``folder`` for ``load_diffusion``, atomically.

    Raises SceneError: "weights" for any other file, "file" if the folder exists or cannot be written.
    """
    safetensors = require("safetensors.torch", INSTALL)
    networks = read_mvdream(path, architecture)
    with atomic_write_all(folder.parent) as made:
        target = made / folder.name
        networks.unet.save_pretrained(target / "unet")
        networks.vae.save_pretrained(target / "vae")
        (target / "text").mkdir()
        text = {key: tensor.contiguous() for key, tensor in text_weights(networks.text.state_dict()).items()}
        safetensors.save_file(text, target / "text" / "open_clip_model.safetensors")
        _write(target / "text" / "open_clip_config.json", {"model_cfg": dict(architecture.text)})
        (target / "scheduler").mkdir()
        _write(target / "scheduler" / "scheduler_config.json", dict(architecture.scheduler))


def _write(path: Path, data: Mapping[str, Any]) -> None:
    path.write_text(json.dumps(data, indent=2), "utf-8")
