"""What a run leaves besides its state: pictures while it goes on; Gaussians, poses and their paths at its end."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.distillation.cast import Cast
from scenelang.backends.distillation.keeping import Kept
from scenelang.backends.distillation.views import alone, pictured, ring
from scenelang.backends.files import write_json, written_whole
from scenelang.backends.picture import save_picture
from scenelang.backends.splats.files import write_gaussians
from scenelang.backends.splats.gaussians import Splats, gaussians_from
from scenelang.backends.studio import from_srgb

if TYPE_CHECKING:
    from scenelang.backends.distillation.learning import Learning
    from scenelang.backends.splats.gaussians import Gaussians

PREVIEW = "preview.png"
_SIZE, _VIEWS, _MOST = 160, 4, 8


def write_preview(learning: Learning, folder: Path) -> None:
    """The first figures from four sides each, below each other, as the models see them."""
    rows = [_strip(figure.theta.gaussians()) for figure in learning.figures[:_MOST]]
    with written_whole(folder / PREVIEW) as temporary:
        save_picture(np.concatenate(rows), temporary)


def _strip(gaussians: Gaussians) -> npt.NDArray[np.uint8]:
    import torch

    with torch.no_grad():
        splats = alone(gaussians)
        pictures = [pictured(splats, camera).cpu().numpy() for camera in ring(_VIEWS, _SIZE)]
    return np.asarray(np.rint(255.0 * np.clip(np.concatenate(pictures, 1), 0.0, 1.0)), np.uint8)


def write_outcome(kept: Kept, cast: Cast, folder: Path) -> list[Path]:
    """`scene.ply`, or one file for each frame of a 4D scene, and `poses.json`; returns what was written. Raises
    SceneError("file")."""
    import torch

    written = []
    for frame in range(kept.frames):
        if not any(player.shown[frame] for player in kept.players):
            continue
        path = folder / ("scene.ply" if kept.frames == 1 else f"scene-{frame:03d}.ply")
        with torch.no_grad():
            splats = kept.splats(frame)
            linear = torch.from_numpy(np.asarray(from_srgb(splats.colors.numpy()), np.float32))
            lit = Splats(splats.means, splats.covariances, splats.opacities, linear)
            write_gaussians(gaussians_from(lit), path)
        written.append(path)
    path = folder / "poses.json"
    write_json(path, poses_of(kept, cast))
    return [*written, path]


def poses_of(kept: Kept, cast: Cast) -> dict[str, Any]:
    """The learned poses as JSON data: for each actor its words, handle and figure, its matrix (3, 4) in every frame
    and the path of its middle, null where it is not shown; for each figure its sentence and the half sizes of its
    box."""
    actors = []
    for number, player in enumerate(kept.players):
        matrices = kept.matrices(number)
        path = [None if matrix is None else [row[3] for row in matrix] for matrix in matrices]
        actors.append(
            {
                "name": player.name,
                "handle": f"<{player.handle}>",
                "figure": player.figure,
                "poses": matrices,
                "path": path,
            }
        )
    figures = [
        {"sentence": figure.condition.plain, "key": key, "box": figure.box.tolist()}
        for figure, key in zip(cast.figures, kept.keys)
    ]
    return {"format": "scenelang-distillation", "version": 1, "figures": figures, "actors": actors}
