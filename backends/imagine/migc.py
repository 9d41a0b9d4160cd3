"""MIGC (Zhou et al. 2024): a layer attends to each instance apart, and a learned fusion puts them together.

Per instance, in its box: the layer's own attention to its sentence, and *enhancement attention* to two tokens, the
sentence's pooled state and the box's position. *Layout attention* is self-attention in which places see only places of
a box they share. The fusion weighs the background, the instances and the layout attention's result by a softmax over
SLOTS of them, from convolutions and CBAM (Woo et al. 2018). Weights are the user's own; key names, the order of a
box's numbers and which boxes layout attention reads are those of the published checkpoint.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from typing import Any

from scenelang.backends.base import need
from scenelang.backends.imagine.migc_files import SLOTS, Migc
from scenelang.backends.imagine.steering import Region, Steering, processors, shape_of
from scenelang.backends.weights import INSTALL
from scenelang.grammar.diagnostics import SceneError

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
        self, unet: Any, weights: Migc, regions: Sequence[Region], latent: tuple[int, int], guided: bool, seed: int
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
        regions: Sequence[Region],
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
