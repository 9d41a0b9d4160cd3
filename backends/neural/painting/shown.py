"""Gaussians for the viewer: on the surfaces of a scene, or learned by a `distill` run."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

from scenelang.backends.base import require
from scenelang.backends.neural.splats.gaussians import Splats
from scenelang.backends.neural.weights import INSTALL
from scenelang.backends.surfaces.image_files import to_srgb
from scenelang.interpreter.scene.entity import Scene

_DEFAULT_SPLATS = 100_000  # target for a scene without learned Gaussians


def surface_splats(scene: Scene) -> list[Splats]:
    """Return Gaussians on the surfaces of every frame's primitives, with colors without lighting."""
    require("torch", INSTALL)
    from scenelang.backends.neural.splats.initial import gaussians_of

    frames = []
    for root in scene.frames:
        surface = gaussians_of(root, max(_DEFAULT_SPLATS // len(scene.frames), 1000))
        colors = surface.splats.colors + surface.emission
        srgb = colors.new_tensor(to_srgb(np.clip(colors.numpy(), 0.0, 1.0)))
        frames.append(Splats(surface.splats.means, surface.splats.covariances, surface.splats.opacities, srgb))
    return frames


def distilled_splats(folder: Path) -> Callable[[Scene], list[Splats]]:
    """Return the Gaussians learned by a `distill` run; raises SceneError("file") if the folder contains none."""
    require("torch", INSTALL)
    from scenelang.backends.neural.distillation.run import load_checkpoint

    run = load_checkpoint(folder)

    def splats_of(scene: Scene) -> list[Splats]:
        import torch

        with torch.no_grad():
            return [run.splats(frame) for frame in range(min(run.frames, len(scene.frames)))]

    return splats_of
