"""What methods that make a model heed a layout have in common."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from typing import Any, Protocol

from scenelang.backends.base import need
from scenelang.backends.neural.imagine.layout import MOST, Box
from scenelang.backends.neural.weights import INSTALL
from scenelang.grammar.diagnostics import SceneError


@dataclass(frozen=True, slots=True, eq=False)
class AttentionRegion:
    """A ``box`` as shares of the picture x0, y0, x1, y1, and what belongs there: ``words`` (1, T, D) of its sentence,
    ``pooled`` (1, D)."""

    box: Box
    words: Any
    pooled: Any


class Steering(Protocol):
    """One method at work on one picture: its context manager changes the model and puts it back."""

    def __enter__(self) -> Steering: ...

    def __exit__(self, *_: object) -> None: ...

    def step(self, number: int, steps: int) -> dict[str, Any] | None:
        """Called before each of ``steps`` steps, from 0: what attention is to be given there besides the words."""


class Unsteered:
    """The model as it is."""

    def __enter__(self) -> Steering:
        return self

    def __exit__(self, *_: object) -> None:
        return None

    def step(self, number: int, steps: int) -> dict[str, Any] | None:
        return None


@contextmanager
def processors(unet: Any, chosen: Mapping[str, Any]) -> Iterator[None]:
    """Inside the block the attention layers named in ``chosen`` work by other processors."""
    before = dict(unet.attn_processors)
    unet.set_attn_processor({**before, **chosen})
    try:
        yield
    finally:
        unet.set_attn_processor(before)


def shape_of(places: int, latent: tuple[int, int]) -> tuple[int, int]:
    """Height and width of a layer whose sequence has ``places``, in a model that works on ``latent`` (height, width):
    each level halves both, rounded up."""
    height, width = latent
    while height * width > places and height * width > 1:
        height, width = (height + 1) // 2, (width + 1) // 2
    if height * width != places:
        raise ValueError(f"no level of a {latent[0]} x {latent[1]} latent has {places} places")
    return height, width


def inside(box: Box, shape: tuple[int, int]) -> list[int]:
    """The places, row by row, of the cells of a grid ``shape`` (height, width) whose centres lie in ``box``; the cell
    nearest to its middle where there is none."""
    height, width = shape
    columns = _between(box[0], box[2], width)
    rows = _between(box[1], box[3], height)
    return [row * width + column for row in rows for column in columns]


def _between(low: float, high: float, cells: int) -> Sequence[int]:
    found = [i for i in range(cells) if low <= (i + 0.5) / cells <= high]
    return found or [min(cells - 1, max(0, int(0.5 * (low + high) * cells)))]


# Regional attention: a layout heeded without training. What a sentence says of an instance reaches only its box.
#
# In each cross-attention layer, where m_i is 1 inside the box of instance i and 0 elsewhere:
# ``(global + w sum m_i inst_i) / (1 + w sum m_i)``. The unconditional half of a guided batch stays as it is.


WEIGHT = 10.0


class Regional:
    """Regional attention in every cross-attention layer of ``unet``, which works on ``latent`` (height, width);
    ``guided``: the first half of a batch is unconditional."""

    def __init__(
        self,
        unet: Any,
        regions: Sequence[AttentionRegion],
        latent: tuple[int, int],
        guided: bool,
        weight: float = WEIGHT,
    ) -> None:
        self._unet = unet
        self._chosen = {
            name: RegionalAttention(before, regions, latent, guided, weight)
            for name, before in unet.attn_processors.items()
            if ".attn2." in name
        }
        self._stack = ExitStack()

    def __enter__(self) -> Steering:
        self._stack.enter_context(processors(self._unet, self._chosen))
        return self

    def __exit__(self, *_: object) -> None:
        self._stack.close()

    def step(self, number: int, steps: int) -> dict[str, Any] | None:
        return None


class RegionalAttention:
    """One layer's processor: ``before`` is the one that it stands in for, and does the attending."""

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
        """States (B, HW, C) after attention to words (B, T, D), blended with what the instances' words give."""
        torch = need("torch", INSTALL)
        out = self._before(attn, hidden_states, encoder_hidden_states, attention_mask, temb)
        start = len(hidden_states) // 2 if self._guided else 0
        own = hidden_states[start:]
        shape = shape_of(own.shape[1], self._latent)
        total, weights = out[start:].clone(), torch.ones_like(out[0, :, :1])
        for region in self._regions:
            rows = torch.tensor(inside(region.box, shape), device=own.device)
            words = region.words.to(own).expand(len(own), -1, -1)
            total[:, rows] += self._weight * self._before(attn, own[:, rows], words, None, temb)
            weights[rows] += self._weight
        return torch.cat([out[:start], total / weights])


# GLIGEN (Li et al. 2023): boxes and sentences as tokens that gated self-attention reads, by weights of the user's.


MODEL = "masterful/gligen-1-4-generation-text-box"
SHARE = 0.3  # of the steps, from the first, in which the gates are open


class Gligen:
    """GLIGEN's gates in ``unet``; they are closed again at the end. ``guided``: the first half of a batch is
    unconditional, and reads no boxes.

    Raises SceneError("weights") for a model without gates.
    """

    def __init__(self, unet: Any, regions: Sequence[AttentionRegion], guided: bool, share: float = SHARE) -> None:
        if getattr(unet.config, "attention_type", "default") != "gated":
            hint = f"--model {MODEL}, or a folder with weights of GLIGEN for boxes and text"
            raise SceneError("weights", "the model has no gates of GLIGEN, so it takes no layout this way", hint=hint)
        self._unet = unet
        self._share = share
        self._tokens = {"gligen": grounding_of(unet, regions, guided)}

    def __enter__(self) -> Steering:
        return self

    def __exit__(self, *_: object) -> None:
        open_gates(self._unet, True)  # as diffusers makes them

    def step(self, number: int, steps: int) -> dict[str, Any] | None:
        open_gates(self._unet, number < int(self._share * steps))
        return self._tokens


def grounding_of(unet: Any, regions: Sequence[AttentionRegion], guided: bool) -> dict[str, Any]:
    """What diffusers' position network reads: ``boxes`` (B, 30, 4), ``positive_embeddings`` (B, 30, D) and ``masks``
    (B, 30), with B 2 where ``guided``, else 1."""
    torch = need("torch", INSTALL)
    weight = next(unet.position_net.parameters())
    width = int(unet.position_net.positive_len)
    boxes, masks = weight.new_zeros(1, MOST, 4), weight.new_zeros(1, MOST)
    texts = weight.new_zeros(1, MOST, width)
    for i, region in enumerate(regions[:MOST]):
        if region.pooled.shape[-1] != width:
            message = f"the text encoder's states are {region.pooled.shape[-1]} wide, GLIGEN's weights want {width}"
            raise SceneError("weights", message)
        boxes[0, i] = weight.new_tensor(region.box)
        texts[0, i] = region.pooled[0].to(weight)
        masks[0, i] = 1.0
    if guided:
        boxes, texts, masks = torch.cat([boxes, boxes]), torch.cat([texts, texts]), torch.cat([masks * 0.0, masks])
    return {"boxes": boxes, "positive_embeddings": texts, "masks": masks}


def open_gates(unet: Any, are_open: bool) -> None:
    """Whether gated self-attention does anything."""
    for module in unet.modules():
        if hasattr(module, "alpha_attn") and hasattr(module, "alpha_dense"):
            module.enabled = are_open
