"""What the weights of MVDream's original checkpoint are called in diffusers and OpenCLIP.

The names of the UNet count blocks in one row where diffusers counts by level; those of the autoencoder differ in words.
Maps go from diffusers' names to the checkpoint's.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from typing import Any

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
