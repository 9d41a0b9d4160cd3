"""MIGC, multi-instance generation controller (Zhou et al. 2024): attention per instance, and a learned fusion.

For each instance, inside its box: the layer's attention to its prompt, and *enhancement attention* to two tokens, the
prompt's pooled state and the position of the box. *Layout attention* is self-attention among tokens that share a box.
The fusion weights background, instances and the result of layout attention by a softmax over SLOTS of them, computed by
convolutions and CBAM (Woo et al. 2018). The user provides the weights; key names, the order of a box's coordinates and
the boxes of layout attention are those of the published checkpoint.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from scenelang.backends.base import require
from scenelang.backends.neural.imagine.layout import (
    AttentionRegion,
    LayoutConditioning,
    attention_processors,
    feature_shape,
)
from scenelang.backends.neural.weights import INSTALL, ModelHub
from scenelang.grammar.diagnostics import SceneError

# MIGC's checkpoint: conversion of key names to diffusers' layers, and checks of shapes.


WEIGHTS = "limuloo/MIGC"
FILE = "MIGC_SD14.ckpt"
SLOTS = 30
_KEY = re.compile(r"(?:.*\.)?(input_blocks|middle_block|output_blocks)\.(\d+)\.(?:.*\.)?migc\.(.+)\Z")
_PREFIX = "model.diffusion_model"
_LAYER = "1.transformer_blocks.0.attn2.migc"
_LEVEL = re.compile(r"(down_blocks|up_blocks)\.(\d+)\.attentions\.(\d+)\.")


@dataclass(frozen=True, slots=True, eq=False)
class Migc:
    """Weights of MIGC: the tensors of each layer by name, by the name of diffusers' attention processor."""

    layers: Mapping[str, Mapping[str, Any]]

    @property
    def text_width(self) -> int:
        """Dimensions of the tokens of enhancement attention."""
        layer = next(iter(self.layers.values()))
        return int(layer["ea.to_k.weight"].shape[1])


def load_migc(name: str = WEIGHTS, hub: ModelHub | None = None) -> Migc:
    """Load MIGC's weights from a file, or from a local folder that contains MIGC_SD14.ckpt.

    Raises SceneError("weights") if they are unavailable or invalid.
    """
    path = Path(name).expanduser()
    location = path if path.is_file() else (hub or ModelHub()).find_folder(name)
    if location is None:
        hint = f"download {FILE} from github.com/{WEIGHTS} (not for commercial use), and specify it with --migc FILE"
        raise SceneError("weights", f"MIGC's weights `{name}` are not available locally", hint=hint)
    file = location if location.is_file() else location / FILE
    try:
        return from_checkpoint(_read(file))
    except SceneError:
        raise
    except Exception as error:  # torch's errors for files of other formats have no common type
        reason = " ".join(str(error).split())[:160] or type(error).__name__
        raise SceneError("weights", f"cannot load MIGC's weights from {file}: {reason}") from error


def from_checkpoint(tensors: Mapping[str, Any]) -> Migc:
    """Convert a checkpoint's tensors; raises SceneError("weights") for unexpected keys or shapes."""
    layers: dict[str, dict[str, Any]] = {}
    for key, tensor in tensors.items():
        processor, inner = processor_of(key)
        layers.setdefault(processor, {})[inner] = tensor
    if not layers:
        raise SceneError("weights", "the checkpoint contains no weights of MIGC")
    for processor, layer in layers.items():
        _check(processor, layer)
    return Migc(layers)


def to_checkpoint(migc: Migc) -> dict[str, Any]:
    """Return the tensors with the key names of MIGC's checkpoint: the inverse of ``from_checkpoint``."""
    return {
        f"{_PREFIX}.{original_block(processor)}.{_LAYER}.{inner}"
        if not processor.startswith("mid")
        else f"{_PREFIX}.middle_block.{_LAYER}.{inner}": tensor
        for processor, layer in migc.layers.items()
        for inner, tensor in layer.items()
    }


def processor_of(key: str) -> tuple[str, str]:
    """Convert a checkpoint's key to the name of diffusers' processor and the name within MIGC.

    Raises SceneError("weights") for an unexpected key.
    """
    match = _KEY.match(key)
    if match is None:
        raise SceneError("weights", f"unexpected key `{key[:120]}` in MIGC's checkpoint")
    # each level of Stable Diffusion 1 has two down blocks or three up blocks, numbered consecutively in the checkpoint
    block, number, inner = match[1], int(match[2]), match[3]
    if block == "middle_block":
        layer = "mid_block.attentions.0"
    elif block == "input_blocks":
        layer = f"down_blocks.{number // 3}.attentions.{number % 3 - 1}"
    else:
        layer = f"up_blocks.{number // 3}.attentions.{number % 3}"
    return f"{layer}.transformer_blocks.0.attn2.processor", inner


def original_block(processor: str) -> str:
    """Return the checkpoint's block for a processor of diffusers' down or up blocks; raises SceneError("weights")."""
    match = _LEVEL.match(processor)
    if match is None:
        raise SceneError("weights", f"`{processor[:120]}` is not a layer of MIGC")
    level, index = int(match[2]), int(match[3])
    return (
        f"input_blocks.{3 * level + index + 1}" if match[1] == "down_blocks" else f"output_blocks.{3 * level + index}"
    )


def expected_shapes(width: int, text: int) -> dict[str, tuple[int, ...]]:
    """Return the shape of every tensor of a layer with ``width`` channels, for text tokens of width ``text``."""
    shapes: dict[str, tuple[int, ...]] = {"norm.weight": (width,), "norm.bias": (width,)}
    for part, context in (("ea", text), ("la", width)):
        shapes |= {f"{part}.to_q.weight": (width, width), f"{part}.to_k.weight": (width, context)}
        shapes |= {f"{part}.to_v.weight": (width, context)} | _layer(f"{part}.to_out.0", width, width)
    shapes |= _layer("sac.conv1", width, width + 1, 1, 1) | _layer("sac.conv2", 1, width, 1, 1)
    for part, channels, hidden in (("sac.cbam1", width, width // 16), ("sac.cbam2", SLOTS, SLOTS)):
        shapes |= _layer(f"{part}.ChannelGate.mlp.1", hidden, channels)
        shapes |= _layer(f"{part}.ChannelGate.mlp.3", channels, hidden)
        shapes[f"{part}.SpatialGate.spatial.conv.weight"] = (1, 2, 7, 7)
    for layer, out_features, in_features in ((0, 512, 64), (2, 512, 512), (4, text, 512)):
        shapes |= _layer(f"pos_net.linears_position.{layer}", out_features, in_features)
    return shapes


def _layer(name: str, out: int, *rest: int) -> dict[str, tuple[int, ...]]:
    return {f"{name}.weight": (out, *rest), f"{name}.bias": (out,)}


def _check(processor: str, layer: Mapping[str, Any]) -> None:
    """Raise SceneError("weights") if tensors of a layer are missing, unexpected or have another shape."""
    if not {"norm.weight", "ea.to_k.weight"} <= layer.keys() or layer["ea.to_k.weight"].ndim != 2:
        raise SceneError("weights", f"MIGC's weights are incomplete: missing tensors of {processor}")
    expected = expected_shapes(len(layer["norm.weight"]), layer["ea.to_k.weight"].shape[1])
    shapes = {name: tuple(tensor.shape) for name, tensor in layer.items()}
    if shapes != expected:
        wrong = sorted(name for name in expected.keys() | shapes.keys() if expected.get(name) != shapes.get(name))
        message = f"unexpected shape of `{wrong[0]}` in MIGC's weights for {processor}"
        raise SceneError("weights", message)


def _read(file: Path) -> Mapping[str, Any]:
    if file.suffix == ".safetensors":
        tensors: Mapping[str, Any] = require("safetensors.torch", INSTALL).load_file(file)
        return tensors
    loaded = require("torch", INSTALL).load(file, map_location="cpu", weights_only=True)
    return loaded.get("state_dict", loaded) if isinstance(loaded, dict) else {}


# Conditioning of a UNet.


DEFAULT_MODEL = "CompVis/stable-diffusion-v1-4"  # the model for which the published weights were trained
MAX_INSTANCES = SLOTS - 2  # background and layout attention take two slots
ACTIVE_FRACTION = 0.5  # of the steps, from the first, with layout conditioning
_HEADS = 8
_FREQUENCIES, _TEMPERATURE = 8, 100.0  # of the Fourier embedding of boxes, as in GLIGEN


@dataclass(frozen=True, slots=True, eq=False)
class _BoxMasks:
    """Masks of N boxes at one resolution.

    Attributes
    ----------
    inside
        (N, HW, 1), coverage of each cell by each box.
    outside
        (HW, 1), coverage of each cell by the background.
    shape
        H, W.
    """

    inside: Any
    outside: Any
    shape: tuple[int, int]


class MigcConditioning:
    """MIGC conditioning of the layers of ``unet`` for which there are ``weights``.

    ``latent`` is the (height, width) of the latent of an image eight times as large. With ``guided``, the first row of
    a batch is unconditional. The order of instances in the fusion's slots is random, by ``seed``. Raises
    SceneError("weights") for weights of another model.
    """

    def __init__(
        self,
        unet: Any,
        weights: Migc,
        regions: Sequence[AttentionRegion],
        latent: tuple[int, int],
        guided: bool,
        seed: int,
    ) -> None:
        torch = require("torch", INSTALL)
        before = unet.attn_processors
        unexpected = [name for name in weights.layers if name not in before]
        if unexpected:
            raise SceneError("weights", f"MIGC's weights are for another model: this one has no layer {unexpected[0]}")
        width, expected = regions[0].pooled.shape[-1] if regions else weights.text_width, weights.text_width
        if width != expected:
            raise SceneError("weights", f"MIGC's weights expect text embeddings of width {expected}, got {width}")
        # all layers share one generator: each shuffles its slots differently, and the seed fixes every order
        generator = torch.Generator().manual_seed(seed)
        self._unet = unet
        self._layers = {
            name: MigcAttention(before[name], _like(layer, unet), regions[:MAX_INSTANCES], latent, guided, generator)
            for name, layer in weights.layers.items()
        }
        self._stack = ExitStack()

    def __enter__(self) -> LayoutConditioning:
        self._stack.enter_context(attention_processors(self._unet, self._layers))
        return self

    def __exit__(self, *_: object) -> None:
        self._stack.close()

    def step(self, number: int, steps: int) -> dict[str, Any] | None:
        for layer in self._layers.values():
            layer.active = number < round(ACTIVE_FRACTION * steps)
        return None


def _like(layer: Mapping[str, Any], unet: Any) -> dict[str, Any]:
    model = next(unet.parameters())
    return {key: value.to(model) for key, value in layer.items()}


class MigcAttention:
    """Attention processor of one layer.

    ``before`` is the processor that it wraps, ``weights`` are the tensors by their names within MIGC, ``generator``
    shuffles slots.
    """

    def __init__(
        self,
        before: Any,
        weights: Mapping[str, Any],
        regions: Sequence[AttentionRegion],
        latent: tuple[int, int],
        guided: bool,
        generator: Any,
    ) -> None:
        self.active = True
        self._before = before
        self._weights = weights
        self._regions = regions
        self._latent = latent
        self._guided = guided
        self._generator = generator

    def __call__(
        self,
        attn: Any,
        hidden_states: Any,
        encoder_hidden_states: Any = None,
        attention_mask: Any = None,
        temb: Any = None,
    ) -> Any:
        """Attend from image states (B, HW, C) to the prompt's (B, T, D), for a batch of one image.

        The conditional row is fused from the attention to the prompt and to each instance.
        """
        torch = require("torch", INSTALL)
        out = self._before(attn, hidden_states, encoder_hidden_states, attention_mask, temb)
        if not self.active or not self._regions:
            return out
        start = len(hidden_states) // 2 if self._guided else 0
        own = hidden_states[start:]
        states = torch.cat([region.hidden_states for region in self._regions]).to(own)
        per_instance = self._before(attn, own.expand(len(states), -1, -1), states, None, temb)
        masks = box_masks([region.box for region in self._regions], self._latent, own)
        fused = self._fuse(own, out[start:], per_instance, masks)
        return torch.cat([out[:start], fused])

    def _fuse(self, own: Any, whole: Any, per_instance: Any, masks: _BoxMasks) -> Any:
        """Fuse the attention to the whole prompt (1, HW, C) and to each instance (N, HW, C); returns (1, HW, C)."""
        torch = require("torch", INSTALL)
        weights = self._weights
        pooled = torch.stack([region.pooled for region in self._regions]).to(own)  # (N, 1, D)
        boxes = own.new_tensor([region.box for region in self._regions])
        tokens = torch.cat([pooled, box_tokens(weights, boxes)[:, None]], dim=1)
        normal = torch.nn.functional.layer_norm(own, own.shape[-1:], weights["norm.weight"], weights["norm.bias"])
        enhanced = attention(weights, "ea", normal.expand(len(pooled), -1, -1), tokens)
        instances = (per_instance + enhanced) * masks.inside
        layout = attention(weights, "la", own, own, shared_box_mask(masks))
        rows = torch.cat([whole * masks.outside, instances, layout])
        regions = torch.cat([masks.outside[None], masks.inside, torch.ones_like(masks.inside[:1])])
        return (rows * fusion_weights(weights, rows, regions, masks.shape, self._generator)).sum(0, keepdim=True)


# --- components ------------------------------------------------------------------------------------------------------


def box_masks(boxes: Sequence[Any], latent: tuple[int, int], own: Any) -> _BoxMasks:
    """Return the masks of boxes, in fractions of the image, for a layer with the states ``own`` (1, HW, C)."""
    torch = require("torch", INSTALL)
    height, width = latent[0] * 8, latent[1] * 8
    full = torch.zeros(len(boxes), height, width)
    for mask, (x0, y0, x1, y1) in zip(full, boxes, strict=True):
        mask[int(height * y0) : int(height * y1), int(width * x0) : int(width * x1)] = 1.0
    both = torch.cat([full, 1.0 - full.amax(0, keepdim=True)])[None].to(own)
    shape = feature_shape(own.shape[1], latent)
    for size in (latent, shape):  # in two steps, as in the training of the published weights
        both = torch.nn.functional.interpolate(both, size=size, mode="bilinear")
    rows = both[0].reshape(len(boxes) + 1, -1, 1)
    return _BoxMasks(rows[:-1], rows[-1], shape)


def box_tokens(weights: Mapping[str, Any], boxes: Any) -> Any:
    """Return the position tokens (N, D) of ``boxes`` (N, 4) x0, y0, x1, y1; the network expects x0, x1, y0, y1."""
    torch = require("torch", INSTALL)
    ordered = boxes[:, [0, 2, 1, 3]]
    waves = [_TEMPERATURE ** (i / _FREQUENCIES) * ordered for i in range(_FREQUENCIES)]
    state = torch.cat([part for wave in waves for part in (wave.sin(), wave.cos())], dim=1)
    for layer in (0, 2, 4):
        state = _linear(weights, f"pos_net.linears_position.{layer}", state)
        state = torch.nn.functional.silu(state) if layer < 4 else state
    return state


def attention(weights: Mapping[str, Any], part: str, queries: Any, context: Any, mask: Any = None) -> Any:
    """Multi-head attention from ``queries`` (B, Q, C) to ``context`` (B, K, D) with the weights of ``part``.

    The boolean ``mask`` (Q, K) selects the keys of each query; a query without any attends uniformly to all.
    """
    torch = require("torch", INSTALL)

    def heads(name: str, states: Any) -> Any:
        projected = states @ weights[f"{part}.{name}.weight"].T
        return projected.unflatten(-1, (_HEADS, -1)).transpose(1, 2)

    q, k, v = heads("to_q", queries), heads("to_k", context), heads("to_v", context)
    if mask is not None:
        empty = ~mask.any(dim=-1, keepdim=True)
        q, mask = q.masked_fill(empty, 0.0), mask | empty  # a softmax over no keys would be NaN
    attended = torch.nn.functional.scaled_dot_product_attention(q, k, v, attn_mask=mask)
    return _linear(weights, f"{part}.to_out.0", attended.transpose(1, 2).flatten(2))


def shared_box_mask(masks: _BoxMasks) -> Any:
    """Return the mask (HW, HW) of pairs of cells that share a box or the background."""
    torch = require("torch", INSTALL)
    groups = torch.cat([masks.inside, masks.outside[None]])[..., 0]  # (N, HW)
    return (groups.T @ groups) > 0.0


def fusion_weights(weights: Mapping[str, Any], rows: Any, masks: Any, shape: tuple[int, int], generator: Any) -> Any:
    """Return the fusion weights (N + 2, HW, 1) of ``rows`` (N + 2, HW, C): background, N instances, layout attention.

    ``masks`` (N + 2, HW, 1) are the regions of the rows.
    """
    torch = require("torch", INSTALL)
    empty = torch.zeros_like(rows[:1]), torch.zeros_like(masks[:1])
    inputs = torch.cat([torch.cat([rows, empty[0]]), torch.cat([masks, empty[1]])], dim=-1)
    state = inputs.unflatten(1, shape).permute(0, 3, 1, 2)  # (N + 3, C + 1, H, W)
    state = _cbam(weights, "sac.cbam1", _pointwise(weights, "sac.conv1", state))
    scores = _pointwise(weights, "sac.conv2", state)[:, 0]  # (N + 3, H, W)
    count = len(rows) - 2
    # unused slots get the score of the empty row; the order is random, since cbam2 depends on the slot
    order = torch.randperm(MAX_INSTANCES, generator=generator)
    slots = torch.cat([scores[1 : count + 1], scores[-1:].expand(MAX_INSTANCES - count, -1, -1)])
    filled = torch.cat([scores[:1], slots[order], scores[count + 1 : count + 2]])
    weighted = _cbam(weights, "sac.cbam2", filled[None])[0]
    restored = weighted[1:-1][torch.argsort(order)][:count]
    return torch.cat([weighted[:1], restored, weighted[-1:]]).flatten(1)[..., None].softmax(dim=0)


def _cbam(weights: Mapping[str, Any], part: str, state: Any) -> Any:
    """Convolutional block attention module: channel attention, then spatial attention, of ``state`` (B, C, H, W)."""
    torch = require("torch", INSTALL)

    def channel_scores(pooled: Any) -> Any:
        hidden = torch.relu(_linear(weights, f"{part}.ChannelGate.mlp.1", pooled))
        return _linear(weights, f"{part}.ChannelGate.mlp.3", hidden)

    channels = torch.sigmoid(channel_scores(state.mean(dim=(2, 3))) + channel_scores(state.amax(dim=(2, 3))))
    state = state * channels[:, :, None, None]
    kernel = weights[f"{part}.SpatialGate.spatial.conv.weight"]
    pooled = torch.stack([state.amax(dim=1), state.mean(dim=1)], dim=1)
    spatial = torch.nn.functional.conv2d(pooled, kernel, padding=kernel.shape[-1] // 2)
    return state * torch.sigmoid(spatial)


def _linear(weights: Mapping[str, Any], part: str, state: Any) -> Any:
    torch = require("torch", INSTALL)
    return torch.nn.functional.linear(state, weights[f"{part}.weight"], weights[f"{part}.bias"])


def _pointwise(weights: Mapping[str, Any], part: str, state: Any) -> Any:
    torch = require("torch", INSTALL)
    return torch.nn.functional.conv2d(state, weights[f"{part}.weight"], weights[f"{part}.bias"])
