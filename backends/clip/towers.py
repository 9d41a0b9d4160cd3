"""The text encoder of an OpenCLIP model alone, without that of pictures, which is as large again."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from scenelang.backends.base import need
from scenelang.backends.clip.models import ClipModel, ClipName
from scenelang.backends.weights import INSTALL
from scenelang.grammar.diagnostics import SceneError

_SETTINGS = {"context_length", "vocab_size", "width", "heads", "layers", "mlp_ratio"}


def empty_tower(config: Mapping[str, Any]) -> Any:
    """The text encoder of a ``model_cfg`` of OpenCLIP on torch's device "meta": shapes without weights.

    Raises SceneError("weights") where it is more than a plain transformer.
    """
    torch = need("torch", INSTALL)
    transformer = need("open_clip.transformer", INSTALL)
    settings = config.get("text_cfg")
    if not isinstance(settings, dict) or not isinstance(config.get("embed_dim"), int):
        raise SceneError("weights", "the settings of the text encoder are not OpenCLIP's")
    foreign = sorted(set(settings) - _SETTINGS)
    if foreign:
        raise SceneError("weights", f"a text encoder with `{foreign[0]}` cannot be used by a diffusion model here")
    activation = transformer.QuickGELU if config.get("quick_gelu") else torch.nn.GELU
    with torch.device("meta"):
        tower = transformer.TextTransformer(**settings, output_dim=config["embed_dim"], act_layer=activation)
    tower.attn_mask = tower.build_causal_mask()  # no weight, so no file brings it
    return tower


def text_weights(tensors: Mapping[str, Any]) -> dict[str, Any]:
    """Those of an OpenCLIP model's ``tensors`` that are its text encoder's, named as there."""
    own = {key.removeprefix("text."): tensor for key, tensor in tensors.items() if not key.startswith("visual.")}
    return {key: tensor for key, tensor in own.items() if key not in ("logit_scale", "logit_bias", "attn_mask")}


def tower_model(name: str, tower: Any) -> ClipModel:
    """The text encoder with OpenCLIP's tokenizer, which encodes no pictures."""
    open_clip = need("open_clip", INSTALL)
    return ClipModel(ClipName(name), tower, open_clip.SimpleTokenizer(context_length=tower.context_length), None)
