"""Rendering backend by Gaussian splatting, with the lighting of draft pictures, and export of Gaussians to files."""

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
from scenelang.backends.neural.splats.files import write_gaussians
from scenelang.backends.neural.splats.gaussians import Splats, gaussians_from, view_of
from scenelang.backends.neural.splats.initial import (
    MAX_GAUSSIANS,
    MIN_GAUSSIANS,
    SceneSplats,
    backdrop,
    gaussians_of,
    shade,
    shadow_of,
)
from scenelang.backends.neural.splats.rasterise import rasterise
from scenelang.backends.neural.weights import INSTALL
from scenelang.backends.pictures.draft import adjusted, draw
from scenelang.backends.pictures.draft_light import (
    Shadow,
)
from scenelang.backends.pictures.film import (
    STILL_ENDINGS,
    Image,
    Painter,
    PictureBackend,
    PictureOptions,
    labeled,
    write_still,
)
from scenelang.backends.pictures.stage import Shot, Stage, Staging, box_of, check_size
from scenelang.backends.surfaces.environments import tone_map
from scenelang.backends.surfaces.image_files import encode
from scenelang.backends.surfaces.solids import normalized, solids_of
from scenelang.backends.surfaces.stand_ins import drawn_scene
from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.scene.entity import Scene
from scenelang.interpreter.scene.flatten import flatten_entity

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]
Float32Array = npt.NDArray[np.float32]


GAUSSIANS = Option(
    "gaussians",
    "number of Gaussians of the scene, distributed by surface area",
    100_000,
    minimum=MIN_GAUSSIANS,
    maximum=MAX_GAUSSIANS,
)
DISTILLED = Option("distilled", "run folder of `distill`: render its result, which includes lighting", "")


class SplatsPainter:
    """Painter that renders shots as Gaussians; caches those of the last frame, for a moving camera."""

    def __init__(self, staging: Staging, options: PictureOptions) -> None:
        self._staging = staging
        self._labels = options.labels
        self._seed = options.seed
        self._total = SPLATS.setting(options, "gaussians")
        self._cache: tuple[int, SceneSplats] | None = None

    def paint(self, shot: Shot, progress: Progress | None = None) -> Image:
        report = progress or (lambda _: None)
        self._staging = adjusted(self._staging, shot)
        stage = self._stage(shot)
        scene_splats = self._scene_splats(shot.frame)
        report(0.3)
        shadow = shadow_of(stage)
        splats = _lit(stage, scene_splats, shadow)
        report(0.5)
        background = backdrop(stage, shadow)
        drawn = rasterise(splats, view_of(stage.camera, splats.means), antialiased=True)
        alpha = drawn.alpha.numpy()[:, :, None]
        radiance = np.asarray(drawn.color.numpy() + (1.0 - alpha) * background, np.float32)
        picture = encode(tone_map(radiance, stage.studio.environment))
        if self._labels and stage.solids.semantic.any():
            picture = labeled(picture, stage.solids, draw(stage, shaded=False).ids)
        report(1.0)
        return Image(picture, radiance)

    def _stage(self, shot: Shot) -> Stage:
        """Return the stage with the frame's solids in the order of its primitives."""
        staging = self._staging
        solids = solids_of(flatten_entity(staging.roots[shot.frame]))
        own = normalized(solids, staging.center, staging.scale)
        return replace(staging.stage(shot), solids=own, fixed=0)

    def _scene_splats(self, frame: int) -> SceneSplats:
        if self._cache is None or self._cache[0] != frame:
            self._cache = frame, gaussians_of(self._staging.roots[frame], self._total, self._seed)
        return self._cache[1]


def _lit(stage: Stage, scene_splats: SceneSplats, shadow: list[Shadow]) -> Splats:
    """Return the Gaussians of visible primitives in the stage's frame, with radiance as colors, in float32."""
    import torch

    # the first solid of each primitive, since a primitive may consist of several solids
    solid = np.full(scene_splats.count, -1, np.int64)
    solid[stage.solids.instance[::-1]] = np.arange(len(stage.solids))[::-1]
    ids = solid[scene_splats.instance]
    visible = np.flatnonzero(ids >= 0)
    matrix = stage.scale * torch.eye(3, dtype=torch.float64)
    translation = torch.from_numpy(-stage.scale * stage.center)
    splats = scene_splats.splats.take(torch.from_numpy(visible)).transformed(matrix, translation)
    normals = scene_splats.normals[visible]
    colors = shade(stage, shadow, splats.means.numpy(), normals, splats.colors.numpy(), ids[visible])
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
    doc="Gaussian splatting: primitives as 3D Gaussians on their surfaces",
    work=Work.PICTURE,
    endings=STILL_ENDINGS,
    run=write_still("splats"),
    options=(GAUSSIANS, DISTILLED),
    packages=("PIL", "torch"),
    install=INSTALL,
    painter=_painter,
)


# Backends that export a scene's Gaussians to files of 3D Gaussian Splatting.


def _export(backend: Backend, scene: Scene, path: Path, options: BackendOptions) -> Sequence[Path]:
    """Write the Gaussians of one frame, with reflectance and emission as colors, without lighting."""
    check_settings(options, [backend])
    require("torch", INSTALL)
    if len(scene.frames) > 1 and options.frame is None:
        message = f"a {path.suffix} file can only contain one frame"
        raise SceneError("unsupported", message, hint="select one with --frame N")
    box_of(scene)
    one = Scene(scene.word, [scene.frames[frame_of(scene, options.frame)]], False)
    check_size(one.root, options.limit)
    made = gaussians_of(drawn_scene(one, options.limit, options.warn).root, backend.setting(options, "gaussians"))
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
SPLATS_PLY = _backend("splats-ply", "Gaussians as .ply of 3D Gaussian Splatting", (".ply",))
