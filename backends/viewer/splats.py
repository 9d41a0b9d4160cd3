"""Gaussians for the page: what is seen in place of the solids."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.base import need
from scenelang.backends.studio import to_srgb
from scenelang.backends.weights import INSTALL
from scenelang.grammar.diagnostics import LimitError
from scenelang.interpreter.entity import Scene

if TYPE_CHECKING:
    from scenelang.backends.splats.gaussians import Splats

FloatArray = npt.NDArray[np.float64]
SplatsOf = Callable[[Scene], "list[Splats]"]  # of every frame, colours sRGB

MOST = 2_000_000  # of all frames: 4 texels of 16 bytes each
_TOTAL = 100_000  # of a scene whose Gaussians are its own


def own_splats(scene: Scene) -> list[Splats]:
    """The Gaussians on the surfaces of every frame's primitives, in the colours that they have without light."""
    need("torch", INSTALL)
    from scenelang.backends.splats.gaussians import Splats
    from scenelang.backends.splats.initial import gaussians_of

    found = []
    for root in scene.frames:
        made = gaussians_of(root, max(_TOTAL // len(scene.frames), 1000))
        colors = made.splats.colors + made.emission
        srgb = colors.new_tensor(to_srgb(np.clip(colors.numpy(), 0.0, 1.0)))
        found.append(Splats(made.splats.means, made.splats.covariances, made.splats.opacities, srgb))
    return found


def distilled_splats(folder: Path) -> SplatsOf:
    """Those that a run of `distill` has learned; raises SceneError("file") where there is none."""
    need("torch", INSTALL)
    from scenelang.backends.distillation.keeping import kept_in

    kept = kept_in(folder)

    def of(scene: Scene) -> list[Splats]:
        import torch

        with torch.no_grad():
            return [kept.splats(frame) for frame in range(min(kept.frames, len(scene.frames)))]

    return of


def splat_columns(frames: Sequence[Splats], count: int, center: FloatArray, scale: float) -> dict[str, Any]:
    """The Gaussians of ``count`` frames under ``p -> scale (p - center)`` as columns, none in frames that have no
    ``frames``: ``splatStart`` (F + 1), ``splatPlace`` (3 N), ``splatSpread`` (6 N: the upper right of the covariance,
    row by row), ``splatColor`` (4 N: sRGB and opacity).

    Raises LimitError for more than MOST.
    """
    sizes = [len(each) for each in frames] + [0] * (count - len(frames))
    if sum(sizes) > MOST:
        raise LimitError("primitives", f"the scene has {sum(sizes):,} Gaussians, more than the {MOST:,} of this page")
    rows = [_rows(each, center, scale) for each in frames]
    columns = {name: np.concatenate([row[name] for row in rows]) for name in rows[0]} if rows else {}
    return {"splatStart": np.concatenate([[0], np.cumsum(sizes)]).astype(np.uint32), **columns}


def _rows(splats: Splats, center: FloatArray, scale: float) -> dict[str, npt.NDArray[Any]]:
    means, covariances, opacities, colors = (
        np.asarray(each.detach().cpu().double().numpy())
        for each in (splats.means, splats.covariances, splats.opacities, splats.colors)
    )
    upper = covariances[:, [0, 0, 0, 1, 1, 2], [0, 1, 2, 1, 2, 2]] * scale**2
    paint = np.concatenate([colors, opacities[:, None]], axis=1)
    return {
        "splatPlace": (scale * (means - center)).astype(np.float32).ravel(),
        "splatSpread": upper.astype(np.float32).ravel(),
        "splatColor": np.rint(255.0 * np.clip(paint, 0.0, 1.0)).astype(np.uint8).ravel(),
    }
