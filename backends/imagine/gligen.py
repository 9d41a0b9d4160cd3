"""GLIGEN (Li et al. 2023): boxes and sentences as tokens that gated self-attention reads, by weights of the user's."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from scenelang.backends.base import need
from scenelang.backends.imagine.layout import MOST
from scenelang.backends.imagine.steering import Region, Steering
from scenelang.backends.weights import INSTALL
from scenelang.grammar.diagnostics import SceneError

MODEL = "masterful/gligen-1-4-generation-text-box"
SHARE = 0.3  # of the steps, from the first, in which the gates are open


class Gligen:
    """GLIGEN's gates in ``unet``; they are closed again at the end. ``guided``: the first half of a batch is
    unconditional, and reads no boxes.

    Raises SceneError("weights") for a model without gates.
    """

    def __init__(self, unet: Any, regions: Sequence[Region], guided: bool, share: float = SHARE) -> None:
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


def grounding_of(unet: Any, regions: Sequence[Region], guided: bool) -> dict[str, Any]:
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
