"""Compositing compiled by numba, for one core: splat after splat over the pixels of its box. Only ``rasterise_numba``
imports this file."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt

from scenelang.backends.base import require
from scenelang.backends.neural.splats.gaussians import LEAST_ALPHA, LEAST_LIGHT, MOST_ALPHA
from scenelang.backends.neural.weights import INSTALL

Floats = npt.NDArray[Any]  # float32 or float64, contiguous
Ints = npt.NDArray[np.int64]

Function = TypeVar("Function", bound=Callable[..., Any])

_DIMMEST = math.log(LEAST_ALPHA) - 1e-3  # exponents below it need not be worked out


def _compiled(function: Function) -> Function:
    made: Function = require("numba", INSTALL).njit(cache=True, nogil=True)(function)
    return made


@_compiled
def boxes(centers: Floats, radii: Floats, width: int, height: int) -> Ints:
    """The pixels (M, 4) that splats reach: first column, the one after the last, and the same of rows."""
    out = np.empty((len(centers), 4), np.int64)
    for g in range(len(centers)):
        out[g, 0] = min(max(math.floor(centers[g, 0] - radii[g, 0]), 0), width)
        out[g, 1] = min(max(math.ceil(centers[g, 0] + radii[g, 0]), 0), width)
        out[g, 2] = min(max(math.floor(centers[g, 1] - radii[g, 1]), 0), height)
        out[g, 3] = min(max(math.ceil(centers[g, 1] + radii[g, 1]), 0), height)
    return out


@_compiled
def forward(
    centers: Floats, conics: Floats, opacities: Floats, features: Floats, box: Ints, image: Floats, light: Floats
) -> Ints:
    """Adds to ``image`` (H, W, C) and lowers ``light`` (H, W), which is 1. Gives the number of the splat at which each
    pixel was done (H, W), M where it never was."""
    count, channels = features.shape
    done = np.full(light.shape, count, np.int64)
    for g in range(count):
        a, b, c = conics[g, 0], conics[g, 1], conics[g, 2]
        strength = math.log(opacities[g])
        for row in range(box[g, 2], box[g, 3]):
            dy = row + 0.5 - centers[g, 1]
            for column in range(box[g, 0], box[g, 1]):
                dx = column + 0.5 - centers[g, 0]
                sigma = max(0.5 * (a * dx * dx + c * dy * dy) + b * dx * dy, 0.0)
                if strength - sigma < _DIMMEST or done[row, column] < count:
                    continue
                alpha = min(opacities[g] * math.exp(-sigma), MOST_ALPHA)
                if alpha < LEAST_ALPHA:
                    continue
                before = light[row, column]
                after = before * (1.0 - alpha)
                if after <= LEAST_LIGHT:
                    done[row, column] = g
                    continue
                weight = alpha * before
                for i in range(channels):
                    image[row, column, i] += weight * features[g, i]
                light[row, column] = after
    return done


@_compiled
def backward(
    centers: Floats,
    conics: Floats,
    opacities: Floats,
    features: Floats,
    box: Ints,
    light: Floats,
    done: Ints,
    by_image: Floats,
    by_hidden: Floats,
) -> tuple[Floats, Floats, Floats, Floats]:
    """The derivatives by the first four, from the light (H, W) behind all splats and those by the picture: farthest
    splat first, taking each away from the light again."""
    count, channels = features.shape
    by_centers, by_conics = np.zeros_like(centers), np.zeros_like(conics)
    by_opacities, by_features = np.zeros_like(opacities), np.zeros_like(features)
    light = light.astype(np.float64)
    behind = np.zeros(light.shape, np.float64)
    for g in range(count - 1, -1, -1):
        a, b, c = conics[g, 0], conics[g, 1], conics[g, 2]
        strength = math.log(opacities[g])
        by_x, by_y, by_a, by_b, by_c, by_opacity = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for row in range(box[g, 2], box[g, 3]):
            dy = row + 0.5 - centers[g, 1]
            for column in range(box[g, 0], box[g, 1]):
                dx = column + 0.5 - centers[g, 0]
                sigma = max(0.5 * (a * dx * dx + c * dy * dy) + b * dx * dy, 0.0)
                if strength - sigma < _DIMMEST or g >= done[row, column]:
                    continue
                raw = opacities[g] * math.exp(-sigma)
                alpha = min(raw, MOST_ALPHA)
                if alpha < LEAST_ALPHA:
                    continue
                before = light[row, column] / (1.0 - alpha)
                worth, weight = by_hidden[row, column], alpha * before
                for i in range(channels):
                    worth += features[g, i] * by_image[row, column, i]
                    by_features[g, i] += weight * by_image[row, column, i]
                by_alpha = before * worth - behind[row, column] / (1.0 - alpha)
                light[row, column] = before
                behind[row, column] += weight * worth
                if raw >= MOST_ALPHA:
                    continue
                by_sigma = -alpha * by_alpha
                by_opacity -= by_sigma / opacities[g]
                by_x -= by_sigma * (a * dx + b * dy)
                by_y -= by_sigma * (b * dx + c * dy)
                by_a += by_sigma * 0.5 * dx * dx
                by_b += by_sigma * dx * dy
                by_c += by_sigma * 0.5 * dy * dy
        by_centers[g, 0], by_centers[g, 1], by_opacities[g] = by_x, by_y, by_opacity
        by_conics[g, 0], by_conics[g, 1], by_conics[g, 2] = by_a, by_b, by_c
    return by_centers, by_conics, by_opacities, by_features
