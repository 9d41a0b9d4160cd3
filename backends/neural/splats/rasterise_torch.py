"""Compositing in plain torch, on any device: tile after tile, in each all pixels and splats at once.

The backward pass works the values out again instead of keeping them: memory does not grow with what is drawn.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

from scenelang.backends.neural.splats.gaussians import LEAST_ALPHA, LEAST_LIGHT, MOST_ALPHA
from scenelang.grammar.diagnostics import LimitError

if TYPE_CHECKING:
    from torch import Tensor

    from scenelang.backends.neural.splats.rasterise_numba import Ellipses


SIDE = 8  # pixels
_AT_ONCE = 1 << 12  # splats of a tile
_MOST_PAIRS = 50_000_000
_FAINTEST = 30.0  # exponents beyond it make numbers so small that the processor is slow


@dataclass(frozen=True, slots=True, eq=False)
class _Tile:
    """The pixels ``rows`` x ``columns`` (slices), their centres ``y`` (Y,) and ``x`` (X,), and which splats reach them,
    nearest first."""

    rows: slice
    columns: slice
    y: Tensor
    x: Tensor
    splats: Tensor


def forward(picture: Ellipses) -> tuple[Tensor, Tensor, tuple[Tensor, ...]]:
    """The features (H, W, C), the share that is hidden (H, W), and what ``backward`` needs of it."""
    like = picture.features
    image = like.new_zeros(picture.height, picture.width, like.shape[1])
    hidden = like.new_zeros(picture.height, picture.width)
    for tile in _tiles(picture):
        for which, layer in _layers(picture, tile):
            image[tile.rows, tile.columns] += layer.weights @ picture.features[which]
            hidden[tile.rows, tile.columns] += layer.weights.sum(-1)
    return image, hidden, (image, hidden)


def backward(
    picture: Ellipses, kept: tuple[Tensor, ...], by_image: Tensor, by_hidden: Tensor
) -> tuple[Tensor, Tensor, Tensor, Tensor]:
    """The derivatives by centres, conics, opacities and features, from those by what ``forward`` gave."""
    import torch

    centers, conics = torch.zeros_like(picture.centers), torch.zeros_like(picture.conics)
    opacities, features = torch.zeros_like(picture.opacities), torch.zeros_like(picture.features)
    # what all splats together add to each pixel, weighed by how much the pixel matters
    image, hidden = kept
    whole = (image * by_image).sum(-1) + hidden * by_hidden
    for tile in _tiles(picture):
        at = (tile.rows, tile.columns)
        behind, pull = whole[at][:, :, None], by_image[at]
        for which, layer in _layers(picture, tile):
            worth = pull @ picture.features[which].T + by_hidden[at][:, :, None]
            ahead = behind - (layer.weights * worth).cumsum(-1)
            by_alpha = layer.drawn * (layer.light * worth - ahead / (1.0 - layer.alphas))
            behind = ahead[:, :, -1:]
            features[which] += torch.einsum("yxk,yxc->kc", layer.weights, pull)
            by_sigma = by_alpha * -layer.alphas * (layer.alphas < MOST_ALPHA)
            opacities[which] -= by_sigma.sum((0, 1)) / picture.opacities[which]
            center, conic = _geometry(by_sigma, layer.dx, layer.dy, picture.conics[which])
            centers[which] += center
            conics[which] += conic
    return centers, conics, opacities, features


@dataclass(frozen=True, slots=True, eq=False)
class _Layer:
    """K splats over a tile: ``dx`` (X, K) and ``dy`` (Y, K) from their centres; (Y, X, K): ``alphas``, 0 where they are
    too low; the ``light`` that reaches each; which are ``drawn``; the ``weights`` with which they are."""

    dx: Tensor
    dy: Tensor
    alphas: Tensor
    light: Tensor
    drawn: Tensor
    weights: Tensor


def _layers(picture: Ellipses, tile: _Tile) -> Iterator[tuple[Tensor, _Layer]]:
    """The splats of a tile, many at once, nearest first, until no pixel lets light through."""
    import torch

    light = tile.x.new_ones(len(tile.y), len(tile.x), 1)
    for which in torch.split(tile.splats, _AT_ONCE):
        layer, light = _layer(picture, tile, which, light)
        yield which, layer
        if bool((light <= LEAST_LIGHT).all()):
            return


def _layer(picture: Ellipses, tile: _Tile, which: Tensor, light: Tensor) -> tuple[_Layer, Tensor]:
    """The layer of the splats ``which``, and the light (Y, X, 1) behind it."""
    import torch

    (cx, cy), (a, b, c) = picture.centers[which].unbind(-1), picture.conics[which].unbind(-1)
    dx, dy = tile.x[:, None] - cx, tile.y[:, None] - cy
    sigma = torch.addcmul((0.5 * c * dy * dy)[:, None, :], (b * dx)[None], dy[:, None, :])
    sigma += (0.5 * a * dx * dx)[None]
    alphas = picture.opacities[which] * sigma.clamp_(0.0, _FAINTEST).neg_().exp_()
    alphas = alphas.clamp_(max=MOST_ALPHA).mul_(alphas >= LEAST_ALPHA)
    after = (1.0 - alphas).cumprod(-1).mul_(light)
    before = torch.cat([light, after[:, :, :-1]], -1)
    drawn = (after > LEAST_LIGHT) & (alphas > 0.0)
    return _Layer(dx, dy, alphas, before, drawn, alphas * before * drawn), after[:, :, -1:]


def _geometry(by_sigma: Tensor, dx: Tensor, dy: Tensor, conics: Tensor) -> tuple[Tensor, Tensor]:
    """The derivatives (K, 2) and (K, 3) by centres and conics, of ``sigma = (a dx^2 + c dy^2) / 2 + b dx dy``."""
    import torch

    a, b, c = conics.unbind(-1)
    columns, rows = by_sigma.sum(0), by_sigma.sum(1)
    crossed = (torch.einsum("yxk,yk->xk", by_sigma, dy) * dx).sum(0)
    x, y = (columns * dx).sum(0), (rows * dy).sum(0)
    center = -torch.stack([a * x + b * y, b * x + c * y], -1)
    squares = 0.5 * (columns * dx * dx).sum(0), 0.5 * (rows * dy * dy).sum(0)
    return center, torch.stack([squares[0], crossed, squares[1]], -1)


# --- which splats reach which tile -----------------------------------------------------------------------------


def _tiles(picture: Ellipses) -> Iterator[_Tile]:
    """The tiles that at least one splat reaches."""
    import torch

    splats, counts, across = _sorted(picture)
    like = picture.centers
    for number, which in enumerate(torch.split(splats, counts)):
        if not len(which):
            continue
        top, left = number // across * SIDE, number % across * SIDE
        rows, columns = slice(top, min(top + SIDE, picture.height)), slice(left, min(left + SIDE, picture.width))
        y, x = (torch.arange(s.start, s.stop, device=like.device).to(like.dtype) + 0.5 for s in (rows, columns))
        yield _Tile(rows, columns, y, x, which)


def _sorted(picture: Ellipses) -> tuple[Tensor, list[int], int]:
    """The splats of all tiles, one tile after the other, how many each has, and how many tiles stand in a row."""
    import torch

    across, down = -(-picture.width // SIDE), -(-picture.height // SIDE)
    low = ((picture.centers - picture.radii) / SIDE).floor().long()
    high = ((picture.centers + picture.radii) / SIDE).ceil().long()
    most = torch.tensor([across, down], device=low.device)
    low, high = low.clamp_min(0).minimum(most), high.clamp_min(0).minimum(most)
    wide, tall = (high - low).unbind(-1)
    counts = wide * tall
    total = int(counts.sum())
    if total > _MOST_PAIRS:
        message = f"the Gaussians cover {total:,} tiles in all, more than the {_MOST_PAIRS:,} that fit"
        raise LimitError("size", message, hint="draw a smaller picture, or fewer Gaussians; numba has no such limit")
    splats = torch.repeat_interleave(counts)
    within = torch.arange(total, device=low.device) - (counts.cumsum(0) - counts)[splats]
    tile = (low[splats, 1] + within // wide[splats]) * across + low[splats, 0] + within % wide[splats]
    order = tile.sort(stable=True).indices
    return splats[order], torch.bincount(tile, minlength=across * down).tolist(), across
