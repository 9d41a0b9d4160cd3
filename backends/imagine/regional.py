"""Regional attention: a layout heeded without training. What a sentence says of an instance reaches only its box.

In each cross-attention layer, where m_i is 1 inside the box of instance i and 0 elsewhere:
``(global + w sum m_i inst_i) / (1 + w sum m_i)``. The unconditional half of a guided batch stays as it is.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import ExitStack
from typing import Any

from scenelang.backends.base import need
from scenelang.backends.imagine.steering import Region, Steering, inside, processors, shape_of
from scenelang.backends.weights import INSTALL

WEIGHT = 10.0


class Regional:
    """Regional attention in every cross-attention layer of ``unet``, which works on ``latent`` (height, width);
    ``guided``: the first half of a batch is unconditional."""

    def __init__(
        self, unet: Any, regions: Sequence[Region], latent: tuple[int, int], guided: bool, weight: float = WEIGHT
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
        self, before: Any, regions: Sequence[Region], latent: tuple[int, int], guided: bool, weight: float
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
