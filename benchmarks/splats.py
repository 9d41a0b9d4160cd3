"""Splats forward and backward, in torch and compiled, on one thread each."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import torch

from scenelang.backends.neural.splats import rasterise_numba, rasterise_torch
from scenelang.backends.neural.splats.gaussians import Gaussians, apply_pose, view_of
from scenelang.backends.neural.splats.rasterise import rasterise_by
from scenelang.backends.neural.splats.rasterise_numba import Engine
from scenelang.backends.pictures.camera import Viewpoint, place


def steps(count: int, size: int) -> dict[str, Callable[[], Any]]:
    """One step each: ``count`` posed Gaussians drawn in ``size`` x ``size`` pixels, and the derivatives of all."""
    torch.set_num_threads(1)
    chance = torch.Generator().manual_seed(0)
    gaussians = Gaussians(
        torch.rand(count, 3, generator=chance) * 2.0 - 1.0,
        torch.randn(count, 3, generator=chance) * 0.3 - 4.0,
        torch.randn(count, 4, generator=chance),
        torch.randn(count, generator=chance),
        torch.rand(count, 3, generator=chance),
    )
    columns = (gaussians.means, gaussians.log_scales, gaussians.quaternions, gaussians.opacity_logits, gaussians.colors)
    view = view_of(place(Viewpoint(), -np.ones(3), np.ones(3), size, size), gaussians.means)

    def step(engine: Engine) -> None:
        for column in columns:
            column.grad = None
            column.requires_grad_()
        drawn = rasterise_by(engine, apply_pose(gaussians, torch.eye(3), torch.zeros(3)), view)
        (drawn.color.square().sum() + drawn.alpha.sum() + drawn.depth.sum()).backward()

    return {"torch": lambda: step(rasterise_torch), "numba": lambda: step(rasterise_numba)}
