"""The backend of pictures by Gaussian splatting: the primitives' Gaussians in the light of draft pictures."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from scenelang.backends.base import Option, Progress, Work, need
from scenelang.backends.draft.draw import draw
from scenelang.backends.draft.light import Shadow
from scenelang.backends.labels import labelled
from scenelang.backends.picture import STILL_ENDINGS, Image, Painter, PictureBackend, PictureOptions, write_still
from scenelang.backends.shots import Shot
from scenelang.backends.solids import normalized, solids_of
from scenelang.backends.splats.gaussians import Splats
from scenelang.backends.splats.initial import LEAST, MOST, SceneSplats, gaussians_of
from scenelang.backends.splats.lighting import backdrop, lit, shadow_of
from scenelang.backends.splats.rasterise import rasterise
from scenelang.backends.splats.view import view_of
from scenelang.backends.stage import Stage, Staging
from scenelang.backends.studio import encode, film
from scenelang.backends.weights import INSTALL
from scenelang.interpreter.flatten import flatten_entity

GAUSSIANS = Option(
    "gaussians", "how many Gaussians the scene is made of, shared out by area", 100_000, least=LEAST, most=MOST
)
DISTILLED = Option("distilled", "the folder of a run of `distill`: draw what it learned, in its own light", "")


class SplatsPainter:
    """Draws shots as Gaussians; those of the last frame are kept, for a camera that moves."""

    def __init__(self, staging: Staging, options: PictureOptions) -> None:
        self._staging = staging
        self._labels = options.labels
        self._seed = options.seed
        self._total = SPLATS.setting(options, "gaussians")
        self._kept: tuple[int, SceneSplats] | None = None

    def paint(self, shot: Shot, progress: Progress | None = None) -> Image:
        report = progress or (lambda _: None)
        stage = self._stage(shot)
        made = self._made(shot.frame)
        report(0.3)
        shadow = shadow_of(stage)
        splats = _lit(stage, made, shadow)
        report(0.5)
        behind = backdrop(stage, shadow)
        drawn = rasterise(splats, view_of(stage.camera, splats.means), antialiased=True)
        hidden = drawn.alpha.numpy()[:, :, None]
        radiance = np.asarray(drawn.color.numpy() + (1.0 - hidden) * behind, np.float32)
        picture = encode(film(radiance, stage.studio.environment))
        if self._labels and stage.solids.semantic.any():
            picture = labelled(picture, stage.solids, draw(stage, shaded=False).ids)
        report(1.0)
        return Image(picture, radiance)

    def _stage(self, shot: Shot) -> Stage:
        """The stage with the frame's solids in the order of its primitives."""
        staging = self._staging
        solids = solids_of(flatten_entity(staging.roots[shot.frame]))
        own = normalized(solids, staging.center, staging.scale)
        return replace(staging.stage(shot), solids=own, fixed=0)

    def _made(self, frame: int) -> SceneSplats:
        if self._kept is None or self._kept[0] != frame:
            self._kept = frame, gaussians_of(self._staging.roots[frame], self._total, self._seed)
        return self._kept[1]


def _lit(stage: Stage, made: SceneSplats, shadow: list[Shadow]) -> Splats:
    """The Gaussians in the stage's frame with radiance for colours, in 32 bits; those whose primitive is not drawn are
    left out."""
    import torch

    number = np.full(made.count, -1, np.int64)
    number[stage.solids.instance[::-1]] = np.arange(len(stage.solids))[::-1]
    ids = number[made.instance]
    kept = np.flatnonzero(ids >= 0)
    matrix = stage.scale * torch.eye(3, dtype=torch.float64)
    splats = made.splats.take(torch.from_numpy(kept)).moved(matrix, torch.from_numpy(-stage.scale * stage.center))
    colors = lit(stage, shadow, splats.means.numpy(), made.normals[kept], splats.colors.numpy(), ids[kept])
    return Splats(
        splats.means.float(), splats.covariances.float(), splats.opacities.float(), torch.from_numpy(colors)
    )  # fmt: skip


def _painter(staging: Staging, options: PictureOptions, shots: int) -> Painter:
    need("torch", INSTALL)
    folder = SPLATS.setting(options, "distilled")
    if folder:
        from scenelang.backends.distillation.painter import DistilledPainter

        return DistilledPainter(staging, Path(folder))
    return SplatsPainter(staging, options)


SPLATS = PictureBackend(
    name="splats",
    doc="pictures by Gaussian splatting: primitives as 3D Gaussians on their surfaces",
    work=Work.PICTURE,
    endings=STILL_ENDINGS,
    run=write_still("splats"),
    options=(GAUSSIANS, DISTILLED),
    packages=("PIL", "torch"),
    install=INSTALL,
    painter=_painter,
)
