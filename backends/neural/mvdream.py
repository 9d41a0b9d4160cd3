"""MVDream's original checkpoint, one file, as UNet and autoencoder of diffusers and OpenCLIP's text encoder."""

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

from scenelang.backends.base import need
from scenelang.backends.files import written_together
from scenelang.backends.neural.clip import empty_tower, text_weights
from scenelang.backends.neural.weights import INSTALL
from scenelang.grammar.diagnostics import SceneError

# Tensors of a file put into a network, where they are those of that network.


_LARGEST_CONFIG = 1_000_000


def fitted(source: str, network: Any, tensors: Mapping[str, Any], called: Mapping[str, str] | None = None) -> Any:
    """``network``, which may be on torch's device "meta", with ``tensors`` for its weights.

    ``called`` are other names of the keys, for messages. Raises SceneError("weights") that names the first key which
    is missing, foreign, or has another shape.
    """
    names = called or {}
    wanted = network.state_dict()
    for key, like in wanted.items():
        if key not in tensors:
            raise other_model(source, f"`{names.get(key, key)}` is missing")
        if tensors[key].shape != like.shape:
            found, meant = (" x ".join(map(str, shape)) for shape in (tensors[key].shape, like.shape))
            raise other_model(source, f"`{names.get(key, key)}` has the shape {found}, not {meant}")
    for key in tensors:
        if key not in wanted:
            raise other_model(source, f"`{key}` does not belong there")
    network.load_state_dict(dict(tensors), assign=True)
    return network.eval().requires_grad_(False)


def other_model(source: str, why: str) -> SceneError:
    """The error for weights of another model than that which ``source`` should hold."""
    return SceneError("weights", f"{source} holds no weights of that model: {why}")


def read_tensors(path: Path) -> dict[str, Any]:
    """The tensors of a ``.safetensors``, ``.pt`` or ``.ckpt`` file, by name; those of the last two under
    ``state_dict`` where that is there. Nothing in the file is run, and torch maps it rather than reads it where it can.

    Raises SceneError("weights") for what holds anything else.
    """
    torch = need("torch", INSTALL)
    try:
        if path.suffix.lower() == ".safetensors":
            return dict(need("safetensors.torch", INSTALL).load_file(path))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # about files that are refused anyway
            held = torch.load(path, map_location="cpu", weights_only=True, mmap=zipfile.is_zipfile(path))
    except pickle.UnpicklingError:  # torch's own message advises to trust the file
        raise other_model(path.name, "it has more than tensors in it, or is broken") from None
    except Exception as error:  # what the libraries raise for broken files has no common type
        raise other_model(path.name, " ".join(str(error).split())[:160] or type(error).__name__) from error
    inner = held.get("state_dict", held) if isinstance(held, dict) else None
    if not isinstance(inner, dict) or not all(
        isinstance(key, str) and isinstance(value, torch.Tensor) for key, value in inner.items()
    ):
        raise other_model(path.name, "it is not a state dict: expected tensors by name")
    return inner


def read_config(path: Path) -> dict[str, Any]:
    """A JSON object of settings; raises SceneError("weights") for anything else."""
    try:
        if path.stat().st_size > _LARGEST_CONFIG:
            raise other_model(str(path), "it is too large for settings")
        data = json.loads(path.read_text("utf-8"))
    except (OSError, ValueError, RecursionError) as error:
        raise other_model(str(path), str(error)[:160]) from error
    if not isinstance(data, dict):
        raise other_model(str(path), "it is no JSON object")
    return data


# What the weights of MVDream's original checkpoint are called in diffusers and OpenCLIP.
#
# The names of the UNet count blocks in one row where diffusers counts by level; those of the autoencoder differ in
# words. Maps go from diffusers' names to the checkpoint's.


UNET, VAE, TEXT = "model.diffusion_model.", "first_stage_model.", "cond_stage_model.model."
NO_WEIGHTS = {  # tables of the noise schedule that the checkpoint keeps, and what the text encoder never uses
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
_CONVOLVED = re.compile(r"\.attn_1\.(q|k|v|proj_out)\.weight$")  # linear layers that the checkpoint has as convolutions


def unet_names(keys: Iterable[str]) -> dict[str, str]:
    """The checkpoint's names of a UNet's ``keys``, all that it has."""
    known = list(keys)
    layers = len({key.split(".")[3] for key in known if key.startswith("down_blocks.0.resnets.")})
    attentive = {key.split(".")[1] for key in known if re.match(r"up_blocks\.\d+\.attentions\.", key)}
    return {key: UNET + _unet_name(key, layers, attentive) for key in known}


def _unet_name(key: str, layers: int, attentive: set[str]) -> str:
    level = _LEVEL.match(key)
    if level is None:
        for ours, theirs in _ENDS.items():
            if key.startswith(f"{ours}."):
                rest = key.removeprefix(f"{ours}.")
                return f"{theirs}.{_inside(rest) if '.resnets.' in ours else rest}"
        return key
    way, block, kind, number = level[1], int(level[2]), level[3], int(level[4])
    rest = key[level.end() :]
    first = block * (layers + 1)
    if kind == "downsamplers":
        return f"input_blocks.{first + layers + 1}.0.op.{rest.removeprefix('conv.')}"
    if kind == "upsamplers":
        return f"output_blocks.{first + layers}.{2 if level[2] in attentive else 1}.{rest}"
    row = f"input_blocks.{first + number + 1}" if way == "down" else f"output_blocks.{first + number}"
    return f"{row}.0.{_inside(rest)}" if kind == "resnets" else f"{row}.1.{rest}"


def _inside(rest: str) -> str:
    """A name within a residual block."""
    part, _, leaf = rest.partition(".")
    return f"{_RESNET.get(part, part)}.{leaf}"


def vae_names(keys: Iterable[str]) -> dict[str, str]:
    """The checkpoint's names of an autoencoder's ``keys``, all that it has."""
    known = list(keys)
    levels = len({key.split(".")[2] for key in known if key.startswith("decoder.up_blocks.")})
    return {key: VAE + _vae_name(key, levels) for key in known}


def _vae_name(key: str, levels: int) -> str:
    name = re.sub(r"\.up_blocks\.(\d+)\.", lambda found: f".up.{levels - 1 - int(found[1])}.", key)
    for ours, theirs in _VAE_WORDS:
        name = re.sub(ours, theirs, name)
    return name


def text_names(keys: Iterable[str]) -> dict[str, str]:
    """The checkpoint's names of the ``keys`` of an OpenCLIP text encoder."""
    return {key: TEXT + key for key in keys}


def from_checkpoint(tensors: Mapping[str, Any], prefix: str, names: Mapping[str, str]) -> dict[str, Any]:
    """The checkpoint's tensors that begin with ``prefix``, by our names; those that have none keep their own."""
    ours = {theirs: key for key, theirs in names.items()}
    found = {}
    for key, tensor in tensors.items():
        if key.startswith(prefix) and key not in NO_WEIGHTS:
            flat = _CONVOLVED.search(key) and tensor.ndim == 4 and tensor.shape[2:] == (1, 1)
            found[ours.get(key, key)] = tensor[:, :, 0, 0] if flat else tensor
    return found


def to_checkpoint(tensors: Mapping[str, Any], names: Mapping[str, str]) -> dict[str, Any]:
    """Our tensors by the checkpoint's names: what ``from_checkpoint`` takes back."""
    found = {names[key]: tensor for key, tensor in tensors.items()}
    return {key: tensor[:, :, None, None] if _CONVOLVED.search(key) else tensor for key, tensor in found.items()}


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
