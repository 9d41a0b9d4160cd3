"""Layout conditioning of diffusers' UNets: the common interface, regional attention, and GLIGEN."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from typing import Any, Protocol

from scenelang.backends.base import require
from scenelang.backends.neural.imagine.layout import MAX_INSTANCES, Box
from scenelang.backends.neural.weights import INSTALL
from scenelang.grammar.diagnostics import SceneError


@dataclass(frozen=True, slots=True, eq=False)
class AttentionRegion:
    """Region of the image with its prompt.

    Attributes
    ----------
    box
        x0, y0, x1, y1 in fractions of the image size.
    hidden_states
        (1, T, D), of the prompt.
    pooled
        (1, D), of the prompt.
    """

    box: Box
    hidden_states: Any
    pooled: Any


class LayoutConditioning(Protocol):
    """Layout conditioning of one image: a context manager that modifies the UNet and restores it at the end."""

    def __enter__(self) -> LayoutConditioning: ...

    def __exit__(self, *_: object) -> None: ...

    def step(self, number: int, steps: int) -> dict[str, Any] | None:
        """Prepare step ``number`` of ``steps``, from 0; returns additional ``cross_attention_kwargs`` for the UNet."""


class NoConditioning:
    """No layout conditioning: leaves the UNet unchanged."""

    def __enter__(self) -> LayoutConditioning:
        return self

    def __exit__(self, *_: object) -> None:
        return None

    def step(self, number: int, steps: int) -> dict[str, Any] | None:
        return None


@contextmanager
def attention_processors(unet: Any, replaced: Mapping[str, Any]) -> Iterator[None]:
    """Replace attention processors of ``unet`` by name for the duration of the block."""
    before = dict(unet.attn_processors)
    unet.set_attn_processor({**before, **replaced})
    try:
        yield
    finally:
        unet.set_attn_processor(before)


def feature_shape(tokens: int, latent: tuple[int, int]) -> tuple[int, int]:
    """Return height and width of the UNet level with ``tokens`` image tokens, for a ``latent`` of (height, width).

    Each level halves both, rounded up. Raises ValueError if no level has that many tokens.
    """
    height, width = latent
    while height * width > tokens and height * width > 1:
        height, width = (height + 1) // 2, (width + 1) // 2
    if height * width != tokens:
        raise ValueError(f"no level of a {latent[0]} x {latent[1]} latent has {tokens} tokens")
    return height, width


def cells_in(box: Box, shape: tuple[int, int]) -> list[int]:
    """Return the row-major indices of the grid cells whose centres are in ``box``, or else of the nearest cell.

    ``shape`` is the height and width of the grid.
    """
    height, width = shape
    columns = _interval(box[0], box[2], width)
    rows = _interval(box[1], box[3], height)
    return [row * width + column for row in rows for column in columns]


def _interval(low: float, high: float, cells: int) -> Sequence[int]:
    found = [i for i in range(cells) if low <= (i + 0.5) / cells <= high]
    return found or [min(cells - 1, max(0, int(0.5 * (low + high) * cells)))]


# Regional attention: training-free layout conditioning, where the prompt of an instance affects only its box.
#
# The output of each cross-attention layer is ``(global + w sum m_i inst_i) / (1 + w sum m_i)``, where m_i is 1 inside
# the box of instance i and 0 elsewhere. With guidance, the unconditional half of the batch is unchanged.


DEFAULT_WEIGHT = 10.0


class Regional:
    """Regional attention in every cross-attention layer of ``unet``, for a ``latent`` of (height, width).

    With ``guided``, the first half of a batch is unconditional.
    """

    def __init__(
        self,
        unet: Any,
        regions: Sequence[AttentionRegion],
        latent: tuple[int, int],
        guided: bool,
        weight: float = DEFAULT_WEIGHT,
    ) -> None:
        self._unet = unet
        self._processors = {
            name: RegionalAttention(before, regions, latent, guided, weight)
            for name, before in unet.attn_processors.items()
            if ".attn2." in name
        }
        self._stack = ExitStack()

    def __enter__(self) -> LayoutConditioning:
        self._stack.enter_context(attention_processors(self._unet, self._processors))
        return self

    def __exit__(self, *_: object) -> None:
        self._stack.close()

    def step(self, number: int, steps: int) -> dict[str, Any] | None:
        return None


class RegionalAttention:
    """Attention processor of one layer; ``before`` is the processor that it wraps."""

    def __init__(
        self, before: Any, regions: Sequence[AttentionRegion], latent: tuple[int, int], guided: bool, weight: float
    ) -> None:
        self._before = before
        self._regions = regions
        self._latent = latent
        self._guided = guided
        self._weight = weight

    def __call__(
        self,
        attn: Any,
        hidden_states: Any,
        encoder_hidden_states: Any = None,
        attention_mask: Any = None,
        temb: Any = None,
    ) -> Any:
        """Attend from image states (B, HW, C) to the prompt's (B, T, D), blended with attention to the regions'."""
        torch = require("torch", INSTALL)
        out = self._before(attn, hidden_states, encoder_hidden_states, attention_mask, temb)
        start = len(hidden_states) // 2 if self._guided else 0
        own = hidden_states[start:]
        shape = feature_shape(own.shape[1], self._latent)
        total, weights = out[start:].clone(), torch.ones_like(out[0, :, :1])
        for region in self._regions:
            rows = torch.tensor(cells_in(region.box, shape), device=own.device)
            states = region.hidden_states.to(own).expand(len(own), -1, -1)
            total[:, rows] += self._weight * self._before(attn, own[:, rows], states, None, temb)
            weights[rows] += self._weight
        return torch.cat([out[:start], total / weights])


# GLIGEN (Li et al. 2023): gated self-attention over grounding tokens of boxes and prompts, with trained weights.


DEFAULT_MODEL = "masterful/gligen-1-4-generation-text-box"
SCHEDULED_SAMPLING_BETA = 0.3  # fraction of the steps, from the first, with grounding; diffusers' default


class Gligen:
    """GLIGEN conditioning of ``unet``. With ``guided``, the first half of a batch is unconditional and has no boxes.

    Raises SceneError("weights") for a model without gated attention.
    """

    def __init__(
        self, unet: Any, regions: Sequence[AttentionRegion], guided: bool, beta: float = SCHEDULED_SAMPLING_BETA
    ) -> None:
        if getattr(unet.config, "attention_type", "default") != "gated":
            hint = f"use --model {DEFAULT_MODEL}, or a folder with weights of GLIGEN for boxes and text"
            raise SceneError("weights", "the model has no gated attention layers of GLIGEN", hint=hint)
        self._unet = unet
        self._beta = beta
        self._tokens = {"gligen": grounding_tokens(unet, regions, guided)}

    def __enter__(self) -> LayoutConditioning:
        return self

    def __exit__(self, *_: object) -> None:
        enable_gates(self._unet, True)  # the default of diffusers

    def step(self, number: int, steps: int) -> dict[str, Any] | None:
        enable_gates(self._unet, number < int(self._beta * steps))
        return self._tokens


def grounding_tokens(unet: Any, regions: Sequence[AttentionRegion], guided: bool) -> dict[str, Any]:
    """Return the inputs of diffusers' position network.

    These are ``boxes`` (B, 30, 4), ``positive_embeddings`` (B, 30, D) and ``masks`` (B, 30), where B is 2 if ``guided``
    and 1 otherwise.
    """
    torch = require("torch", INSTALL)
    weight = next(unet.position_net.parameters())
    width = int(unet.position_net.positive_len)
    boxes, masks = weight.new_zeros(1, MAX_INSTANCES, 4), weight.new_zeros(1, MAX_INSTANCES)
    texts = weight.new_zeros(1, MAX_INSTANCES, width)
    for i, region in enumerate(regions[:MAX_INSTANCES]):
        if region.pooled.shape[-1] != width:
            message = f"GLIGEN expects text embeddings of width {width}, got {region.pooled.shape[-1]}"
            raise SceneError("weights", message)
        boxes[0, i] = weight.new_tensor(region.box)
        texts[0, i] = region.pooled[0].to(weight)
        masks[0, i] = 1.0
    if guided:
        boxes, texts, masks = torch.cat([boxes, boxes]), torch.cat([texts, texts]), torch.cat([masks * 0.0, masks])
    return {"boxes": boxes, "positive_embeddings": texts, "masks": masks}


def enable_gates(unet: Any, enabled: bool) -> None:
    """Enable or disable gated self-attention."""
    for module in unet.modules():
        if hasattr(module, "alpha_attn") and hasattr(module, "alpha_dense"):
            module.enabled = enabled
