"""The backend of pictures by Gaussian splatting: the primitives' Gaussians in the light of draft pictures."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import numpy.typing as npt

from scenelang.backends.base import (
    Accepts,
    Backend,
    BackendOptions,
    Option,
    Progress,
    Work,
    check_settings,
    frame_of,
    require,
)
from scenelang.backends.geometry.solids import normalized, solids_of
from scenelang.backends.minecraft.models import as_cubes
from scenelang.backends.neural.splats.files import write_gaussians
from scenelang.backends.neural.splats.gaussians import Splats, gaussians_from, view_of
from scenelang.backends.neural.splats.initial import LEAST, MOST, SceneSplats, backdrop, gaussians_of, lit, shadow_of
from scenelang.backends.neural.splats.rasterise import rasterise
from scenelang.backends.neural.weights import INSTALL
from scenelang.backends.pictures.draft import draw
from scenelang.backends.pictures.draft_light import (
    Shadow,
)
from scenelang.backends.pictures.film import (
    STILL_ENDINGS,
    Image,
    Painter,
    PictureBackend,
    PictureOptions,
    labelled,
    write_still,
)
from scenelang.backends.pictures.stage import Shot, Stage, Staging, box_of, check_size
from scenelang.backends.pictures.studio import encode, tone_map
from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.scene.entity import Scene
from scenelang.interpreter.scene.flatten import flatten_entity

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]
Float32Array = npt.NDArray[np.float32]


GAUSSIANS = Option(
    "gaussians", "how many Gaussians the scene is made of, shared out by area", 100_000, minimum=LEAST, maximum=MOST
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
        picture = encode(tone_map(radiance, stage.studio.environment))
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
    require("torch", INSTALL)
    folder = SPLATS.setting(options, "distilled")
    if folder:
        from scenelang.backends.neural.distillation.run import DistilledPainter

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


# The backends that write a scene's Gaussians as files of 3D Gaussian Splatting.


def _export(backend: Backend, scene: Scene, path: Path, options: BackendOptions) -> Sequence[Path]:
    """Write the Gaussians of one frame: reflectance and what glows, without light and shadow."""
    check_settings(options, [backend])
    require("torch", INSTALL)
    if len(scene.frames) > 1 and options.frame is None:
        raise SceneError("unsupported", f"a {path.suffix} file holds one frame", hint="choose one with --frame N")
    box_of(scene)
    one = Scene(scene.word, [scene.frames[frame_of(scene, options.frame)]], False)
    check_size(one.root, options.limit)
    made = gaussians_of(as_cubes(one, options.limit, options.warn).root, backend.setting(options, "gaussians"))
    splats = made.splats
    colors = (splats.colors + made.emission).clamp(0.0, 1.0)
    write_gaussians(gaussians_from(Splats(splats.means, splats.covariances, splats.opacities, colors)), path)
    if options.progress is not None:
        options.progress(1.0)
    return [path]


def _backend(name: str, doc: str, endings: tuple[str, ...]) -> Backend:
    def run(scene: Scene, path: Path, options: BackendOptions) -> Sequence[Path]:
        return _export(made, scene, Path(path), options)

    accepts = Accepts(attributes=("color", "opacity", "emission"))
    made = Backend(name, doc, Work.EXPORT, endings, run, (GAUSSIANS,), accepts, ("torch",), INSTALL)
    return made


SPLAT = _backend("splat", "Gaussians as .splat, 32 bytes each, for viewers in browsers", (".splat",))
SPLATS_PLY = _backend("splats-ply", "Gaussians as the .ply of 3D Gaussian Splatting", (".ply",))
