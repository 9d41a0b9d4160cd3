"""The backends that write a scene's Gaussians as files of 3D Gaussian Splatting."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from scenelang.backends.base import Accepts, Backend, Options, Work, check_settings, frame_of, need
from scenelang.backends.minecraft.cubes import as_cubes
from scenelang.backends.shots import box_of
from scenelang.backends.splats.backend import GAUSSIANS
from scenelang.backends.splats.files import write_gaussians
from scenelang.backends.splats.gaussians import Splats, gaussians_from
from scenelang.backends.splats.initial import gaussians_of
from scenelang.backends.stage import check_size
from scenelang.backends.weights import INSTALL
from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.entity import Scene


def _export(backend: Backend, scene: Scene, path: Path, options: Options) -> Sequence[Path]:
    """Write the Gaussians of one frame: reflectance and what glows, without light and shadow."""
    check_settings(options, [backend])
    need("torch", INSTALL)
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
    def run(scene: Scene, path: Path, options: Options) -> Sequence[Path]:
        return _export(made, scene, Path(path), options)

    accepts = Accepts(attributes=("color", "opacity", "emission"))
    made = Backend(name, doc, Work.EXPORT, endings, run, (GAUSSIANS,), accepts, ("torch",), INSTALL)
    return made


SPLAT = _backend("splat", "Gaussians as .splat, 32 bytes each, for viewers in browsers", (".splat",))
SPLATS_PLY = _backend("splats-ply", "Gaussians as the .ply of 3D Gaussian Splatting", (".ply",))
