"""Pictures of what was distilled: the learned Gaussians over the ground and sky of every other picture."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from scenelang.backends.base import Progress
from scenelang.backends.distillation.keeping import Kept, kept_in
from scenelang.backends.picture import Image
from scenelang.backends.shots import Shot
from scenelang.backends.splats.gaussians import Splats
from scenelang.backends.splats.lighting import backdrop, shadow_of
from scenelang.backends.splats.rasterise import rasterise
from scenelang.backends.splats.view import view_of
from scenelang.backends.stage import Staging
from scenelang.backends.studio import encode, film, from_srgb
from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.entity import descendants


class DistilledPainter:
    """Draws shots of the run in a folder. Its colours are those of pictures, so that no light falls on them."""

    def __init__(self, staging: Staging, folder: Path) -> None:
        self._staging = staging
        self._kept: Kept = kept_in(folder)
        self._folder = folder
        words = {entity.word for entity in descendants(*staging.roots.values())}
        frames = [frame for frame in staging.roots if frame < self._kept.frames]
        players = [player for player in self._kept.players if any(player.shown[frame] for frame in frames)]
        strange = next((player.name for player in players if player.word not in words), None)
        if strange is not None:
            message = f"the run in {folder} was made of another scene: there is no `{strange}` in this one"
            raise SceneError("value", message)

    def paint(self, shot: Shot, progress: Progress | None = None) -> Image:
        import torch

        kept = self._kept
        if shot.frame >= kept.frames:
            raise SceneError("value", f"the run in {self._folder} has {kept.frames} frames, not {shot.frame + 1}")
        stage = self._staging.stage(shot)
        moved = stage.scale * torch.eye(3), torch.from_numpy(-stage.scale * stage.center).float()
        splats = kept.splats(shot.frame).moved(*moved) if self._is_shown(shot.frame) else _nothing()
        drawn = rasterise(splats, view_of(stage.camera, splats.means), antialiased=True)
        behind = (
            encode(film(np.asarray(backdrop(stage, shadow_of(stage)), np.float32), stage.studio.environment)) / 255.0
        )
        hidden = drawn.alpha.numpy()[:, :, None]
        picture = np.clip(drawn.color.numpy() + (1.0 - hidden) * behind, 0.0, 1.0)
        if progress is not None:
            progress(1.0)
        return Image(np.asarray(np.rint(255.0 * picture), np.uint8), np.asarray(from_srgb(picture), np.float32))

    def _is_shown(self, frame: int) -> bool:
        return any(player.shown[frame] for player in self._kept.players)


def _nothing() -> Splats:
    import torch

    return Splats(torch.zeros(0, 3), torch.zeros(0, 3, 3), torch.zeros(0), torch.zeros(0, 3))
