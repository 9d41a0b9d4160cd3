"""Compositing in plain torch, on any device: a loop over tiles, vectorised over the pixels and splats of each.

The backward pass recomputes the intermediate values, so memory does not grow with the number of splats.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

from scenelang.backends.neural.splats.gaussians import MAX_ALPHA, MIN_ALPHA, MIN_TRANSMITTANCE
from scenelang.grammar.diagnostics import LimitError

if TYPE_CHECKING:
    from torch import Tensor

    from scenelang.backends.neural.splats.rasterise_numba import Ellipses


TILE_SIZE = 8  # pixels
_CHUNK = 1 << 12  # splats of a tile that are processed at once
_MAX_PAIRS = 50_000_000  # of tiles and splats
_MAX_EXPONENT = 30.0  # larger exponents would produce denormal numbers, which are slow


@dataclass(frozen=True, slots=True, eq=False)
class _Tile:
    """Tile of pixels ``rows`` x ``columns`` (slices) with centers ``y`` (Y,) and ``x`` (X,), and the indices of the
    ``splats`` that overlap it, sorted from near to far."""

    rows: slice
    columns: slice
    y: Tensor
    x: Tensor
    splats: Tensor


def forward(ellipses: Ellipses) -> tuple[Tensor, Tensor, tuple[Tensor, ...]]:
    """Return the features (H, W, C), alpha (H, W), and the tensors required by ``backward``."""
    like = ellipses.features
    image = like.new_zeros(ellipses.height, ellipses.width, like.shape[1])
    alpha = like.new_zeros(ellipses.height, ellipses.width)
    for tile in _tiles(ellipses):
        for indices, chunk in _chunks(ellipses, tile):
            image[tile.rows, tile.columns] += chunk.weights @ ellipses.features[indices]
            alpha[tile.rows, tile.columns] += chunk.weights.sum(-1)
    return image, alpha, (image, alpha)


def backward(
    ellipses: Ellipses, saved: tuple[Tensor, ...], grad_image: Tensor, grad_alpha: Tensor
) -> tuple[Tensor, Tensor, Tensor, Tensor]:
    """Return the gradients by centers, conics, opacities and features."""
    import torch

    centers, conics = torch.zeros_like(ellipses.centers), torch.zeros_like(ellipses.conics)
    opacities, features = torch.zeros_like(ellipses.opacities), torch.zeros_like(ellipses.features)
    # A splat's alpha also scales all contributions behind it. Their sum is the total of the pixel, saved by the forward
    # pass, less the contributions up to the splat.
    image, alpha = saved
    total = (image * grad_image).sum(-1) + alpha * grad_alpha
    for tile in _tiles(ellipses):
        pixels = (tile.rows, tile.columns)
        remaining, grad_pixels = total[pixels][:, :, None], grad_image[pixels]
        for indices, chunk in _chunks(ellipses, tile):
            grad_weights = grad_pixels @ ellipses.features[indices].T + grad_alpha[pixels][:, :, None]
            behind = remaining - (chunk.weights * grad_weights).cumsum(-1)
            grad_alphas = chunk.drawn * (chunk.transmittance * grad_weights - behind / (1.0 - chunk.alphas))
            remaining = behind[:, :, -1:]
            features[indices] += torch.einsum("yxk,yxc->kc", chunk.weights, grad_pixels)
            grad_sigma = grad_alphas * -chunk.alphas * (chunk.alphas < MAX_ALPHA)
            opacities[indices] -= grad_sigma.sum((0, 1)) / ellipses.opacities[indices]
            center, conic = _geometry_gradients(grad_sigma, chunk.dx, chunk.dy, ellipses.conics[indices])
            centers[indices] += center
            conics[indices] += conic
    return centers, conics, opacities, features


@dataclass(frozen=True, slots=True, eq=False)
class _Chunk:
    """K splats over a tile.

    Attributes
    ----------
    dx, dy
        (X, K) and (Y, K), offsets of the pixels from the splats' centers.
    alphas
        (Y, X, K), 0 below the minimum.
    transmittance
        (Y, X, K), before each splat.
    drawn
        (Y, X, K), whether the splat contributes to the pixel.
    weights
        (Y, X, K), alpha times transmittance of drawn splats.
    """

    dx: Tensor
    dy: Tensor
    alphas: Tensor
    transmittance: Tensor
    drawn: Tensor
    weights: Tensor


def _chunks(ellipses: Ellipses, tile: _Tile) -> Iterator[tuple[Tensor, _Chunk]]:
    """Iterate over the splats of a tile in chunks, from near to far, until all pixels are finished."""
    import torch

    transmittance = tile.x.new_ones(len(tile.y), len(tile.x), 1)
    for indices in torch.split(tile.splats, _CHUNK):
        chunk, transmittance = _chunk(ellipses, tile, indices, transmittance)
        yield indices, chunk
        if bool((transmittance <= MIN_TRANSMITTANCE).all()):
            return


def _chunk(ellipses: Ellipses, tile: _Tile, indices: Tensor, transmittance: Tensor) -> tuple[_Chunk, Tensor]:
    """Return the chunk of the splats ``indices``, and the transmittance (Y, X, 1) after it."""
    import torch

    (cx, cy), (a, b, c) = ellipses.centers[indices].unbind(-1), ellipses.conics[indices].unbind(-1)
    dx, dy = tile.x[:, None] - cx, tile.y[:, None] - cy
    sigma = torch.addcmul((0.5 * c * dy * dy)[:, None, :], (b * dx)[None], dy[:, None, :])
    sigma += (0.5 * a * dx * dx)[None]
    alphas = ellipses.opacities[indices] * sigma.clamp_(0.0, _MAX_EXPONENT).neg_().exp_()
    alphas = alphas.clamp_(max=MAX_ALPHA).mul_(alphas >= MIN_ALPHA)
    after = (1.0 - alphas).cumprod(-1).mul_(transmittance)
    before = torch.cat([transmittance, after[:, :, :-1]], -1)
    drawn = (after > MIN_TRANSMITTANCE) & (alphas > 0.0)
    return _Chunk(dx, dy, alphas, before, drawn, alphas * before * drawn), after[:, :, -1:]


def _geometry_gradients(grad_sigma: Tensor, dx: Tensor, dy: Tensor, conics: Tensor) -> tuple[Tensor, Tensor]:
    """Return the gradients by centers (K, 2) and conics (K, 3), for ``sigma = (a dx^2 + c dy^2) / 2 + b dx dy``."""
    import torch

    a, b, c = conics.unbind(-1)
    columns, rows = grad_sigma.sum(0), grad_sigma.sum(1)
    mixed = (torch.einsum("yxk,yk->xk", grad_sigma, dy) * dx).sum(0)
    x, y = (columns * dx).sum(0), (rows * dy).sum(0)
    center = -torch.stack([a * x + b * y, b * x + c * y], -1)
    squares = 0.5 * (columns * dx * dx).sum(0), 0.5 * (rows * dy * dy).sum(0)
    return center, torch.stack([squares[0], mixed, squares[1]], -1)


# --- assignment of splats to tiles -----------------------------------------------------------------------------


def _tiles(ellipses: Ellipses) -> Iterator[_Tile]:
    """Iterate over the tiles that overlap at least one splat."""
    import torch

    splats, counts, tiles_x = _sort_by_tile(ellipses)
    like = ellipses.centers
    for number, indices in enumerate(torch.split(splats, counts)):
        if not len(indices):
            continue
        top, left = number // tiles_x * TILE_SIZE, number % tiles_x * TILE_SIZE
        rows = slice(top, min(top + TILE_SIZE, ellipses.height))
        columns = slice(left, min(left + TILE_SIZE, ellipses.width))
        y, x = (torch.arange(s.start, s.stop, device=like.device).to(like.dtype) + 0.5 for s in (rows, columns))
        yield _Tile(rows, columns, y, x, indices)


def _sort_by_tile(ellipses: Ellipses) -> tuple[Tensor, list[int], int]:
    """Return the splats of all tiles, concatenated; the number of splats per tile; and the number of tiles in a row."""
    import torch

    tiles_x, tiles_y = -(-ellipses.width // TILE_SIZE), -(-ellipses.height // TILE_SIZE)
    low = ((ellipses.centers - ellipses.radii) / TILE_SIZE).floor().long()
    high = ((ellipses.centers + ellipses.radii) / TILE_SIZE).ceil().long()
    limit = torch.tensor([tiles_x, tiles_y], device=low.device)
    low, high = low.clamp_min(0).minimum(limit), high.clamp_min(0).minimum(limit)
    width, height = (high - low).unbind(-1)
    counts = width * height
    total = int(counts.sum())
    if total > _MAX_PAIRS:
        message = f"the Gaussians overlap {total:,} tiles in total, more than {_MAX_PAIRS:,}"
        hint = "use a smaller image or fewer Gaussians, or install numba, which has no such limit"
        raise LimitError("size", message, hint=hint)
    splats = torch.repeat_interleave(counts)
    within = torch.arange(total, device=low.device) - (counts.cumsum(0) - counts)[splats]
    tile = (low[splats, 1] + within // width[splats]) * tiles_x + low[splats, 0] + within % width[splats]
    order = tile.sort(stable=True).indices  # stable, so that the splats of a tile remain sorted by depth
    return splats[order], torch.bincount(tile, minlength=tiles_x * tiles_y).tolist(), tiles_x
