"""MVDream's multi-view UNet in plain torch, with the names of its own checkpoint: what diffusers' is compared with."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import torch
from torch import Tensor, nn


def _slots(**modules: nn.Module) -> nn.ModuleDict:
    """Modules whose names in a state dict are numbers: ``_2=conv`` is "2"."""
    return nn.ModuleDict({name[1:]: module for name, module in modules.items()})


class Residual(nn.Module):
    def __init__(self, before: int, after: int, embedding: int) -> None:
        super().__init__()
        self.in_layers = _slots(_0=nn.GroupNorm(32, before), _2=nn.Conv2d(before, after, 3, padding=1))
        self.emb_layers = _slots(_1=nn.Linear(embedding, after))
        self.out_layers = _slots(_0=nn.GroupNorm(32, after), _3=nn.Conv2d(after, after, 3, padding=1))
        self.skip_connection = nn.Identity() if before == after else nn.Conv2d(before, after, 1)

    def forward(self, x: Tensor, embedding: Tensor) -> Tensor:
        inner = self.in_layers["2"](nn.functional.silu(self.in_layers["0"](x)))
        inner = inner + self.emb_layers["1"](nn.functional.silu(embedding))[:, :, None, None]
        return self.skip_connection(x) + self.out_layers["3"](nn.functional.silu(self.out_layers["0"](inner)))


class Attention(nn.Module):
    def __init__(self, width: int, heads: int, context: int) -> None:
        super().__init__()
        self.heads = heads
        self.to_q = nn.Linear(width, width, bias=False)
        self.to_k = nn.Linear(context, width, bias=False)
        self.to_v = nn.Linear(context, width, bias=False)
        self.to_out = _slots(_0=nn.Linear(width, width))

    def forward(self, x: Tensor, context: Tensor) -> Tensor:
        """One head after the other, one row of the batch after the other."""
        rows = []
        for own, other in zip(x, context, strict=True):
            q, k, v = self.to_q(own), self.to_k(other), self.to_v(other)
            parts = zip(*(part.chunk(self.heads, dim=1) for part in (q, k, v)), strict=True)
            rows.append(torch.cat([torch.softmax(a @ b.T / math.sqrt(a.shape[1]), dim=1) @ c for a, b, c in parts], 1))
        return self.to_out["0"](torch.stack(rows))


class Gated(nn.Module):
    def __init__(self, width: int) -> None:
        super().__init__()
        self.proj = nn.Linear(width, 8 * width)

    def forward(self, x: Tensor) -> Tensor:
        value, gate = self.proj(x).chunk(2, dim=-1)
        return value * nn.functional.gelu(gate)


class Block(nn.Module):
    def __init__(self, width: int, heads: int, context: int) -> None:
        super().__init__()
        self.attn1 = Attention(width, heads, width)
        self.ff = nn.ModuleDict({"net": _slots(_0=Gated(width), _2=nn.Linear(4 * width, width))})
        self.attn2 = Attention(width, heads, context)
        self.norm1, self.norm2, self.norm3 = (nn.LayerNorm(width) for _ in range(3))

    def forward(self, x: Tensor, words: Tensor, views: int) -> Tensor:
        groups = torch.stack([torch.cat(list(group)) for group in x.split(views)])  # the tokens of all views in a row
        looked = self.norm1(groups)
        groups = groups + self.attn1(looked, looked)
        x = torch.cat([torch.stack(list(group.chunk(views))) for group in groups])
        x = x + self.attn2(self.norm2(x), words)
        inner = self.ff["net"]
        return x + inner["2"](inner["0"](self.norm3(x)))


class Transformer(nn.Module):
    def __init__(self, width: int, heads: int, context: int) -> None:
        super().__init__()
        self.norm = nn.GroupNorm(32, width, eps=1e-6)
        self.proj_in = nn.Linear(width, width)
        self.transformer_blocks = nn.ModuleList([Block(width, heads, context)])
        self.proj_out = nn.Linear(width, width)

    def forward(self, x: Tensor, words: Tensor, views: int) -> Tensor:
        tokens = self.proj_in(self.norm(x).flatten(2).mT)
        tokens = self.proj_out(self.transformer_blocks[0](tokens, words, views))
        return x + tokens.mT.reshape(x.shape)


class Down(nn.Module):
    def __init__(self, width: int) -> None:
        super().__init__()
        self.op = nn.Conv2d(width, width, 3, stride=2, padding=1)

    def forward(self, x: Tensor) -> Tensor:
        return self.op(x)


class Up(nn.Module):
    def __init__(self, width: int) -> None:
        super().__init__()
        self.conv = nn.Conv2d(width, width, 3, padding=1)

    def forward(self, x: Tensor) -> Tensor:
        return self.conv(x.repeat_interleave(2, dim=2).repeat_interleave(2, dim=3))


class OriginalUNet(nn.Module):
    """``widths`` of the levels, those that attend, heads at each; ``words`` wide states, cameras of 16 numbers."""

    def __init__(
        self, widths: Sequence[int], attentive: Sequence[bool], heads: Sequence[int], layers: int, words: int,
        channels: int = 4,
    ) -> None:  # fmt: skip
        super().__init__()
        first = widths[0]
        wide = 4 * first
        self.first = first
        self.time_embed = _slots(_0=nn.Linear(first, wide), _2=nn.Linear(wide, wide))
        self.camera_embed = _slots(_0=nn.Linear(16, wide), _2=nn.Linear(wide, wide))
        self.input_blocks = nn.ModuleList([nn.ModuleList([nn.Conv2d(channels, first, 3, padding=1)])])
        kept, width = [first], first
        for level, after in enumerate(widths):
            for _ in range(layers):
                self.input_blocks.append(self._row(width, after, wide, attentive[level], heads[level], words))
                width = after
                kept.append(width)
            if level + 1 < len(widths):
                self.input_blocks.append(nn.ModuleList([Down(width)]))
                kept.append(width)
        middle = [Residual(width, width, wide), Transformer(width, heads[-1], words), Residual(width, width, wide)]
        self.middle_block = nn.ModuleList(middle)
        self.output_blocks = nn.ModuleList()
        for level in reversed(range(len(widths))):
            for number in range(layers + 1):
                row = self._row(width + kept.pop(), widths[level], wide, attentive[level], heads[level], words)
                width = widths[level]
                if level and number == layers:
                    row.append(Up(width))
                self.output_blocks.append(row)
        self.out = _slots(_0=nn.GroupNorm(32, first), _2=nn.Conv2d(first, channels, 3, padding=1))

    @staticmethod
    def _row(before: int, after: int, wide: int, attends: bool, heads: int, words: int) -> nn.ModuleList:
        row: list[nn.Module] = [Residual(before, after, wide)]
        return nn.ModuleList([*row, Transformer(after, heads, words)] if attends else row)

    def forward(self, x: Tensor, steps: Tensor, words: Tensor, cameras: Tensor | None, views: int) -> Tensor:
        half = self.first // 2
        waves = steps[:, None] * torch.exp(torch.arange(half) * (-math.log(10000.0) / half))
        embedding = _two(self.time_embed, torch.cat([waves.cos(), waves.sin()], dim=1))
        if cameras is not None:
            embedding = embedding + _two(self.camera_embed, cameras)
        kept = []
        for row in self.input_blocks:
            x = _run(row, x, embedding, words, views)
            kept.append(x)
        x = _run(self.middle_block, x, embedding, words, views)
        for row in self.output_blocks:
            x = _run(row, torch.cat([x, kept.pop()], dim=1), embedding, words, views)
        return self.out["2"](nn.functional.silu(self.out["0"](x)))


def _two(layers: Any, x: Tensor) -> Tensor:
    return layers["2"](nn.functional.silu(layers["0"](x)))


def _run(row: Any, x: Tensor, embedding: Tensor, words: Tensor, views: int) -> Tensor:
    for layer in row:
        if isinstance(layer, Residual):
            x = layer(x, embedding)
        elif isinstance(layer, Transformer):
            x = layer(x, words, views)
        else:
            x = layer(x)
    return x
