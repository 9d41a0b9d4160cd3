"""Compositing kernels compiled by numba, for one core: a loop over splats and the pixels of their boxes.

Only ``rasterise_numba`` imports this module.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt

from scenelang.backends.base import require
from scenelang.backends.neural.splats.gaussians import MAX_ALPHA, MIN_ALPHA, MIN_TRANSMITTANCE
from scenelang.backends.neural.weights import INSTALL

Floats = npt.NDArray[Any]  # float32 or float64, contiguous
Ints = npt.NDArray[np.int64]

Function = TypeVar("Function", bound=Callable[..., Any])

_MIN_EXPONENT = math.log(MIN_ALPHA) - 1e-3  # skips the exponential for alphas below MIN_ALPHA, with a rounding margin


def _jit(function: Function) -> Function:
    compiled: Function = require("numba", INSTALL).njit(cache=True, nogil=True)(function)
    return compiled


@_jit
def boxes(centers: Floats, radii: Floats, width: int, height: int) -> Ints:
    """Return the pixel bounds (M, 4) of splats: first column, end column (exclusive), first row, end row."""
    out = np.empty((len(centers), 4), np.int64)
    for g in range(len(centers)):
        out[g, 0] = min(max(math.floor(centers[g, 0] - radii[g, 0]), 0), width)
        out[g, 1] = min(max(math.ceil(centers[g, 0] + radii[g, 0]), 0), width)
        out[g, 2] = min(max(math.floor(centers[g, 1] - radii[g, 1]), 0), height)
        out[g, 3] = min(max(math.ceil(centers[g, 1] + radii[g, 1]), 0), height)
    return out


@_jit
def forward(
    centers: Floats,
    conics: Floats,
    opacities: Floats,
    features: Floats,
    box: Ints,
    image: Floats,
    transmittance: Floats,
) -> Ints:
    """Add the splats to ``image`` (H, W, C), and update ``transmittance`` (H, W), initially 1.

    Returns the index (H, W) of the splat at which each pixel was finished, M if it was not.
    """
    count, channels = features.shape
    finished_at = np.full(transmittance.shape, count, np.int64)
    for g in range(count):
        a, b, c = conics[g, 0], conics[g, 1], conics[g, 2]
        log_opacity = math.log(opacities[g])
        for row in range(box[g, 2], box[g, 3]):
            dy = row + 0.5 - centers[g, 1]
            for column in range(box[g, 0], box[g, 1]):
                dx = column + 0.5 - centers[g, 0]
                sigma = max(0.5 * (a * dx * dx + c * dy * dy) + b * dx * dy, 0.0)
                if log_opacity - sigma < _MIN_EXPONENT or finished_at[row, column] < count:
                    continue
                alpha = min(opacities[g] * math.exp(-sigma), MAX_ALPHA)
                if alpha < MIN_ALPHA:
                    continue
                before = transmittance[row, column]
                after = before * (1.0 - alpha)
                if after <= MIN_TRANSMITTANCE:
                    finished_at[row, column] = g
                    continue
                weight = alpha * before
                for i in range(channels):
                    image[row, column, i] += weight * features[g, i]
                transmittance[row, column] = after
    return finished_at


@_jit
def backward(
    centers: Floats,
    conics: Floats,
    opacities: Floats,
    features: Floats,
    box: Ints,
    transmittance: Floats,
    finished_at: Ints,
    grad_image: Floats,
    grad_alpha: Floats,
) -> tuple[Floats, Floats, Floats, Floats]:
    """Return the gradients by centers, conics, opacities and features.

    Splats are processed from far to near; dividing the final ``transmittance`` (H, W) by ``1 - alpha`` recovers
    the transmittance before each splat, so that it need not be stored (3D Gaussian Splatting, appendix C).
    """
    count, channels = features.shape
    grad_centers, grad_conics = np.zeros_like(centers), np.zeros_like(conics)
    grad_opacities, grad_features = np.zeros_like(opacities), np.zeros_like(features)
    transmittance = transmittance.astype(np.float64)
    behind = np.zeros(transmittance.shape, np.float64)
    for g in range(count - 1, -1, -1):
        a, b, c = conics[g, 0], conics[g, 1], conics[g, 2]
        log_opacity = math.log(opacities[g])
        grad_x, grad_y, grad_a, grad_b, grad_c, grad_opacity = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for row in range(box[g, 2], box[g, 3]):
            dy = row + 0.5 - centers[g, 1]
            for column in range(box[g, 0], box[g, 1]):
                dx = column + 0.5 - centers[g, 0]
                sigma = max(0.5 * (a * dx * dx + c * dy * dy) + b * dx * dy, 0.0)
                if log_opacity - sigma < _MIN_EXPONENT or g >= finished_at[row, column]:
                    continue
                raw = opacities[g] * math.exp(-sigma)
                alpha = min(raw, MAX_ALPHA)
                if alpha < MIN_ALPHA:
                    continue
                before = transmittance[row, column] / (1.0 - alpha)
                value, weight = grad_alpha[row, column], alpha * before
                for i in range(channels):
                    value += features[g, i] * grad_image[row, column, i]
                    grad_features[g, i] += weight * grad_image[row, column, i]
                grad_splat_alpha = before * value - behind[row, column] / (1.0 - alpha)
                transmittance[row, column] = before
                behind[row, column] += weight * value
                if raw >= MAX_ALPHA:
                    continue
                grad_sigma = -alpha * grad_splat_alpha
                grad_opacity -= grad_sigma / opacities[g]
                grad_x -= grad_sigma * (a * dx + b * dy)
                grad_y -= grad_sigma * (b * dx + c * dy)
                grad_a += grad_sigma * 0.5 * dx * dx
                grad_b += grad_sigma * dx * dy
                grad_c += grad_sigma * 0.5 * dy * dy
        grad_centers[g, 0], grad_centers[g, 1], grad_opacities[g] = grad_x, grad_y, grad_opacity
        grad_conics[g, 0], grad_conics[g, 1], grad_conics[g, 2] = grad_a, grad_b, grad_c
    return grad_centers, grad_conics, grad_opacities, grad_features
