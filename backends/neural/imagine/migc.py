"""MIGC (Zhou et al. 2024): a layer attends to each instance apart, and a learned fusion puts them together.

Per instance, in its box: the layer's own attention to its sentence, and *enhancement attention* to two tokens, the
sentence's pooled state and the box's position. *Layout attention* is self-attention in which places see only places of
a box they share. The fusion weighs the background, the instances and the layout attention's result by a softmax over
SLOTS of them, from convolutions and CBAM (Woo et al. 2018). Weights are the user's own; key names, the order of a
box's numbers and which boxes layout attention reads are those of the published checkpoint.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from scenelang.backends.base import need
from scenelang.backends.neural.imagine.regional import AttentionRegion, Steering, processors, shape_of
from scenelang.backends.neural.weights import INSTALL, Shelf
from scenelang.grammar.diagnostics import SceneError

# MIGC's checkpoint: its key names in terms of diffusers' layers, and the shapes that it must have.


WEIGHTS = "limuloo/MIGC"
FILE = "MIGC_SD14.ckpt"
SLOTS = 30
_KEY = re.compile(r"(?:.*\.)?(input_blocks|middle_block|output_blocks)\.(\d+)\.(?:.*\.)?migc\.(.+)\Z")
_START = "model.diffusion_model"
_WHERE = "1.transformer_blocks.0.attn2.migc"
_HOME = re.compile(r"(down_blocks|up_blocks)\.(\d+)\.attentions\.(\d+)\.")


@dataclass(frozen=True, slots=True, eq=False)
class Migc:
    """The tensors of each layer by their names within MIGC, by the name of diffusers' attention processor there."""

    layers: Mapping[str, Mapping[str, Any]]

    @property
    def text_width(self) -> int:
        """Numbers of a token that enhancement attention reads."""
        layer = next(iter(self.layers.values()))
        return int(layer["ea.to_k.weight"].shape[1])


def load_migc(name: str = WEIGHTS, shelf: Shelf | None = None) -> Migc:
    """MIGC's weights: a file, or a folder on the shelf that holds MIGC_SD14.ckpt.

    Raises SceneError("weights") where they are not to be had, or are no weights of MIGC.
    """
    path = Path(name).expanduser()
    place = path if path.is_file() else (shelf or Shelf()).place(name)
    if place is None:
        hint = f"fetch {FILE} from its makers (github.com/{WEIGHTS}, not for commercial use), and name it: --migc FILE"
        raise SceneError("weights", f"MIGC's weights `{name}` are not on this machine", hint=hint)
    file = place if place.is_file() else place / FILE
    try:
        return from_checkpoint(_read(file))
    except SceneError:
        raise
    except Exception as error:  # what torch raises for files that are no weights has no common type
        said = " ".join(str(error).split())[:160] or type(error).__name__
        raise SceneError("weights", f"{file} does not hold MIGC's weights: {said}") from error


def from_checkpoint(tensors: Mapping[str, Any]) -> Migc:
    """The layers of a checkpoint's tensors; raises SceneError("weights") for others."""
    layers: dict[str, dict[str, Any]] = {}
    for key, tensor in tensors.items():
        processor, inner = layer_of(key)
        layers.setdefault(processor, {})[inner] = tensor
    if not layers:
        raise SceneError("weights", "the checkpoint is empty: it holds no weights of MIGC")
    for processor, layer in layers.items():
        _check(processor, layer)
    return Migc(layers)


def to_checkpoint(migc: Migc) -> dict[str, Any]:
    """The tensors under the names that MIGC's checkpoint has for them."""
    return {
        f"{_START}.{original(processor)}.{_WHERE}.{inner}"
        if not processor.startswith("mid")
        else f"{_START}.middle_block.{_WHERE}.{inner}": tensor
        for processor, layer in migc.layers.items()
        for inner, tensor in layer.items()
    }


def layer_of(key: str) -> tuple[str, str]:
    """Diffusers' processor and the name within MIGC of a checkpoint's key; raises SceneError("weights")."""
    found = _KEY.match(key)
    if found is None:
        raise SceneError("weights", f"`{key[:120]}` is not a key of MIGC's checkpoint")
    block, number, inner = found[1], int(found[2]), found[3]
    if block == "middle_block":
        home = "mid_block.attentions.0"
    elif block == "input_blocks":
        home = f"down_blocks.{number // 3}.attentions.{number % 3 - 1}"
    else:
        home = f"up_blocks.{number // 3}.attentions.{number % 3}"
    return f"{home}.transformer_blocks.0.attn2.processor", inner


def original(processor: str) -> str:
    """The block of the original model that holds a layer of diffusers' down or up blocks; raises SceneError."""
    found = _HOME.match(processor)
    if found is None:
        raise SceneError("weights", f"`{processor[:120]}` is not a layer of MIGC")
    level, place = int(found[2]), int(found[3])
    return (
        f"input_blocks.{3 * level + place + 1}" if found[1] == "down_blocks" else f"output_blocks.{3 * level + place}"
    )


def shapes(width: int, text: int) -> dict[str, tuple[int, ...]]:
    """The shape of every tensor of a layer with ``width`` channels, for text tokens of ``text`` numbers."""
    found: dict[str, tuple[int, ...]] = {"norm.weight": (width,), "norm.bias": (width,)}
    for part, read in (("ea", text), ("la", width)):
        found |= {f"{part}.to_q.weight": (width, width), f"{part}.to_k.weight": (width, read)}
        found |= {f"{part}.to_v.weight": (width, read)} | _layer(f"{part}.to_out.0", width, width)
    found |= _layer("sac.conv1", width, width + 1, 1, 1) | _layer("sac.conv2", 1, width, 1, 1)
    for part, channels, hidden in (("sac.cbam1", width, width // 16), ("sac.cbam2", SLOTS, SLOTS)):
        found |= _layer(f"{part}.ChannelGate.mlp.1", hidden, channels)
        found |= _layer(f"{part}.ChannelGate.mlp.3", channels, hidden)
        found[f"{part}.SpatialGate.spatial.conv.weight"] = (1, 2, 7, 7)
    for layer, size, read in ((0, 512, 64), (2, 512, 512), (4, text, 512)):
        found |= _layer(f"pos_net.linears_position.{layer}", size, read)
    return found


def _layer(name: str, out: int, *rest: int) -> dict[str, tuple[int, ...]]:
    return {f"{name}.weight": (out, *rest), f"{name}.bias": (out,)}


def _check(processor: str, layer: Mapping[str, Any]) -> None:
    """Raises SceneError("weights") where a layer lacks a tensor, or has one of another shape or name."""
    if not {"norm.weight", "ea.to_k.weight"} <= layer.keys() or layer["ea.to_k.weight"].ndim != 2:
        raise SceneError("weights", f"MIGC's weights lack parts of {processor}")
    wanted = shapes(len(layer["norm.weight"]), layer["ea.to_k.weight"].shape[1])
    have = {name: tuple(tensor.shape) for name, tensor in layer.items()}
    if have != wanted:
        wrong = sorted(name for name in wanted.keys() | have.keys() if wanted.get(name) != have.get(name))
        raise SceneError("weights", f"MIGC's weights are not as expected in {processor}: {wrong[0]}")


def _read(file: Path) -> Mapping[str, Any]:
    if file.suffix == ".safetensors":
        found: Mapping[str, Any] = need("safetensors.torch", INSTALL).load_file(file)
        return found
    held = need("torch", INSTALL).load(file, map_location="cpu", weights_only=True)
    return held.get("state_dict", held) if isinstance(held, dict) else {}


MODEL = "CompVis/stable-diffusion-v1-4"  # what the published weights belong to
MOST = SLOTS - 2  # the background and the layout attention's result take two
SHARE = 0.5  # of the steps, from the first, in which layers heed the layout
_HEADS = 8
_FREQUENCIES, _TEMPERATURE = 8, 100.0


@dataclass(frozen=True, slots=True, eq=False)
class _Guides:
    """For N instances at one resolution: ``inside`` (N, HW, 1) how far each place lies in each box, ``outside`` (HW, 1)
    in none; ``shape`` is H, W."""

    inside: Any
    outside: Any
    shape: tuple[int, int]


class MigcSteering:
    """MIGC in the layers of ``unet`` that ``weights`` are for; the unet works on ``latent`` (height, width) of a
    picture eight times as large. ``guided``: the first row of a batch is unconditional. The fusion shuffles its
    slots, by ``seed``.

    Raises SceneError("weights") for weights of another model.
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
        torch = need("torch", INSTALL)
        before = unet.attn_processors
        strange = [name for name in weights.layers if name not in before]
        if strange:
            raise SceneError("weights", f"MIGC's weights are not for this model: it has no layer {strange[0]}")
        width, made_for = regions[0].pooled.shape[-1] if regions else weights.text_width, weights.text_width
        if width != made_for:
            raise SceneError("weights", f"MIGC's weights read text {made_for} wide, this model's is {width}")
        source = torch.Generator().manual_seed(seed)
        self._unet = unet
        self._layers = {
            name: MigcAttention(before[name], _like(layer, unet), regions[:MOST], latent, guided, source)
            for name, layer in weights.layers.items()
        }
        self._stack = ExitStack()

    def __enter__(self) -> Steering:
        self._stack.enter_context(processors(self._unet, self._layers))
        return self

    def __exit__(self, *_: object) -> None:
        self._stack.close()

    def step(self, number: int, steps: int) -> dict[str, Any] | None:
        for layer in self._layers.values():
            layer.active = number < round(SHARE * steps)
        return None


def _like(layer: Mapping[str, Any], unet: Any) -> dict[str, Any]:
    model = next(unet.parameters())
    return {key: value.to(model) for key, value in layer.items()}


class MigcAttention:
    """One layer's processor: ``before`` is the one that it stands in for, ``weights`` are tensors by their names
    within MIGC, ``source`` shuffles slots."""

    def __init__(
        self,
        before: Any,
        weights: Mapping[str, Any],
        regions: Sequence[AttentionRegion],
        latent: tuple[int, int],
        guided: bool,
        source: Any,
    ) -> None:
        self.active = True
        self._before = before
        self._weights = weights
        self._regions = regions
        self._latent = latent
        self._guided = guided
        self._source = source

    def __call__(
        self,
        attn: Any,
        hidden_states: Any,
        encoder_hidden_states: Any = None,
        attention_mask: Any = None,
        temb: Any = None,
    ) -> Any:
        """States (B, HW, C) after attention to words (B, T, D): of a batch of one picture, its conditional row is
        fused from the instances'."""
        torch = need("torch", INSTALL)
        out = self._before(attn, hidden_states, encoder_hidden_states, attention_mask, temb)
        if not self.active or not self._regions:
            return out
        start = len(hidden_states) // 2 if self._guided else 0
        own = hidden_states[start:]
        words = torch.cat([region.words for region in self._regions]).to(own)
        apart = self._before(attn, own.expand(len(words), -1, -1), words, None, temb)
        guides = guides_of([region.box for region in self._regions], self._latent, own)
        fused = self._fused(own, out[start:], apart, guides)
        return torch.cat([out[:start], fused])

    def _fused(self, own: Any, everywhere: Any, apart: Any, guides: _Guides) -> Any:
        """The states (1, HW, C) from those of the whole prompt (1, HW, C) and of each instance's (N, HW, C)."""
        torch = need("torch", INSTALL)
        weights = self._weights
        pooled = torch.stack([region.pooled for region in self._regions]).to(own)  # (N, 1, D)
        boxes = own.new_tensor([region.box for region in self._regions])
        tokens = torch.cat([pooled, box_tokens(weights, boxes)[:, None]], dim=1)
        normal = torch.nn.functional.layer_norm(own, own.shape[-1:], weights["norm.weight"], weights["norm.bias"])
        enhanced = attention(weights, "ea", normal.expand(len(pooled), -1, -1), tokens)
        instances = (apart + enhanced) * guides.inside
        layout = attention(weights, "la", own, own, visible(guides))
        rows = torch.cat([everywhere * guides.outside, instances, layout])
        masks = torch.cat([guides.outside[None], guides.inside, torch.ones_like(guides.inside[:1])])
        return (rows * shares(weights, rows, masks, guides.shape, self._source)).sum(0, keepdim=True)


# --- parts -----------------------------------------------------------------------------------------------------------


def guides_of(boxes: Sequence[Any], latent: tuple[int, int], own: Any) -> _Guides:
    """The guides of boxes (shares of the picture) for a layer with the states ``own`` (1, HW, C)."""
    torch = need("torch", INSTALL)
    height, width = latent[0] * 8, latent[1] * 8
    full = torch.zeros(len(boxes), height, width)
    for mask, (x0, y0, x1, y1) in zip(full, boxes, strict=True):
        mask[int(height * y0) : int(height * y1), int(width * x0) : int(width * x1)] = 1.0
    both = torch.cat([full, 1.0 - full.amax(0, keepdim=True)])[None].to(own)
    shape = shape_of(own.shape[1], latent)
    for size in (latent, shape):  # in two steps, as the published weights were made
        both = torch.nn.functional.interpolate(both, size=size, mode="bilinear")
    rows = both[0].reshape(len(boxes) + 1, -1, 1)
    return _Guides(rows[:-1], rows[-1], shape)


def box_tokens(weights: Mapping[str, Any], boxes: Any) -> Any:
    """The tokens (N, D) of the positions of ``boxes`` (N, 4) x0, y0, x1, y1, which are read as x0, x1, y0, y1."""
    torch = need("torch", INSTALL)
    ordered = boxes[:, [0, 2, 1, 3]]
    waves = [_TEMPERATURE ** (i / _FREQUENCIES) * ordered for i in range(_FREQUENCIES)]
    state = torch.cat([part for wave in waves for part in (wave.sin(), wave.cos())], dim=1)
    for layer in (0, 2, 4):
        state = _linear(weights, f"pos_net.linears_position.{layer}", state)
        state = torch.nn.functional.silu(state) if layer < 4 else state
    return state


def attention(weights: Mapping[str, Any], part: str, queries: Any, read: Any, visible: Any = None) -> Any:
    """Multi-head attention of ``queries`` (B, Q, C) to ``read`` (B, K, D) by the weights of ``part``; ``visible``
    (Q, K) says what sees what; what sees nothing gets the mean of all."""
    torch = need("torch", INSTALL)

    def heads(name: str, states: Any) -> Any:
        made = states @ weights[f"{part}.{name}.weight"].T
        return made.unflatten(-1, (_HEADS, -1)).transpose(1, 2)

    q, k, v = heads("to_q", queries), heads("to_k", read), heads("to_v", read)
    if visible is not None:
        blind = ~visible.any(dim=-1, keepdim=True)
        q, visible = q.masked_fill(blind, 0.0), visible | blind
    found = torch.nn.functional.scaled_dot_product_attention(q, k, v, attn_mask=visible)
    return _linear(weights, f"{part}.to_out.0", found.transpose(1, 2).flatten(2))


def visible(guides: _Guides) -> Any:
    """Which places (HW, HW) share a box, or the outside of all."""
    torch = need("torch", INSTALL)
    groups = torch.cat([guides.inside, guides.outside[None]])[..., 0]  # (N, HW)
    return (groups.T @ groups) > 0.0


def shares(weights: Mapping[str, Any], rows: Any, masks: Any, shape: tuple[int, int], source: Any) -> Any:
    """How much of each of ``rows`` (N + 2, HW, C) goes into the result (N + 2, HW, 1): the background's first, the
    layout's last. ``masks`` (N + 2, HW, 1) are what each is about."""
    torch = need("torch", INSTALL)
    empty = torch.zeros_like(rows[:1]), torch.zeros_like(masks[:1])
    read = torch.cat([torch.cat([rows, empty[0]]), torch.cat([masks, empty[1]])], dim=-1)
    state = read.unflatten(1, shape).permute(0, 3, 1, 2)  # (N + 3, C + 1, H, W)
    state = _cbam(weights, "sac.cbam1", _pointwise(weights, "sac.conv1", state))
    rated = _pointwise(weights, "sac.conv2", state)[:, 0]  # (N + 3, H, W)
    count = len(rows) - 2
    order = torch.randperm(MOST, generator=source)
    slots = torch.cat([rated[1 : count + 1], rated[-1:].expand(MOST - count, -1, -1)])
    filled = torch.cat([rated[:1], slots[order], rated[count + 1 : count + 2]])
    weighed = _cbam(weights, "sac.cbam2", filled[None])[0]
    back = weighed[1:-1][torch.argsort(order)][:count]
    return torch.cat([weighed[:1], back, weighed[-1:]]).flatten(1)[..., None].softmax(dim=0)


def _cbam(weights: Mapping[str, Any], part: str, state: Any) -> Any:
    """The convolutional block attention module: channels (B, C, H, W) weighed by means and maxima, then places."""
    torch = need("torch", INSTALL)

    def rated(pooled: Any) -> Any:
        hidden = torch.relu(_linear(weights, f"{part}.ChannelGate.mlp.1", pooled))
        return _linear(weights, f"{part}.ChannelGate.mlp.3", hidden)

    channels = torch.sigmoid(rated(state.mean(dim=(2, 3))) + rated(state.amax(dim=(2, 3))))
    state = state * channels[:, :, None, None]
    kernel = weights[f"{part}.SpatialGate.spatial.conv.weight"]
    places = torch.stack([state.amax(dim=1), state.mean(dim=1)], dim=1)
    spread = torch.nn.functional.conv2d(places, kernel, padding=kernel.shape[-1] // 2)
    return state * torch.sigmoid(spread)


def _linear(weights: Mapping[str, Any], part: str, state: Any) -> Any:
    torch = need("torch", INSTALL)
    return torch.nn.functional.linear(state, weights[f"{part}.weight"], weights[f"{part}.bias"])


def _pointwise(weights: Mapping[str, Any], part: str, state: Any) -> Any:
    torch = need("torch", INSTALL)
    return torch.nn.functional.conv2d(state, weights[f"{part}.weight"], weights[f"{part}.bias"])
