"""Pictures of scenes: what the backends that draw have in common."""

from __future__ import annotations

import io
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Protocol

import numpy as np
import numpy.typing as npt

from scenelang.backends.base import Backend, Options, Progress, check_settings, find, need
from scenelang.backends.camera import LARGEST, Camera
from scenelang.backends.files import written_whole
from scenelang.backends.shots import Shot, still
from scenelang.backends.stage import Staging, staging_of
from scenelang.backends.studio import ENVIRONMENTS, GROUNDS
from scenelang.backends.viewpoint import Viewpoint
from scenelang.grammar.diagnostics import SceneError, suggest
from scenelang.interpreter.entity import Scene

Picture = npt.NDArray[np.uint8]

STILL_ENDINGS = (".png", ".jpg", ".jpeg", ".webp", ".exr")
QUALITIES = {"draft": "draft", "final": "mitsuba"}  # the backend that draws pictures of each quality
_MOST_PIXELS = 4096 * 4096


@dataclass(frozen=True, slots=True)
class PictureOptions(Options):
    """``width`` and ``height`` in pixels; ``camera`` is placed or to be placed; ``environment`` and ``ground`` (None:
    the environment's own) are names of ``studio``; the same ``seed`` gives the same picture; ``labels`` writes the
    words of semantic primitives on the picture."""

    width: int = 512
    height: int = 512
    camera: Viewpoint | Camera = field(default_factory=Viewpoint)
    environment: str = "studio"
    ground: str | None = None
    seed: int = 0
    labels: bool = True


@dataclass(frozen=True, slots=True, eq=False)
class Image:
    """A drawn shot: ``picture`` (H, W, 3) 8-bit sRGB with labels, ``radiance`` (H, W, 3) linear sRGB without."""

    picture: Picture
    radiance: npt.NDArray[np.float32]


class Painter(Protocol):
    """Draws shots of one staging; what they have in common is worked out once."""

    def paint(self, shot: Shot, progress: Progress | None = None) -> Image:
        """Draw one shot; ``progress`` is called with a fraction from 0 to 1. Raises SceneError."""


@dataclass(frozen=True, slots=True)
class PictureBackend(Backend):
    """A backend that draws pictures: ``painter(staging, options, shots)`` for a picture or a film of so many shots."""

    painter: Callable[[Staging, PictureOptions, int], Painter] | None = None


def picture_backend(name: str) -> PictureBackend:
    """The backend that is called ``name`` or draws pictures of that quality; raises SceneError("backend")."""
    backend = find(QUALITIES.get(name, name))
    if not isinstance(backend, PictureBackend) or backend.painter is None:
        raise SceneError("backend", f"the backend `{name}` draws no pictures", hint="`scenelang backends` lists them")
    return backend


def render(scene: Scene, options: PictureOptions | None = None, backend: str = "draft") -> Picture:
    """One frame of ``scene`` as a picture: (height, width, 3), 8-bit sRGB. ``backend`` is a name or a quality.

    Raises SceneError: "empty-scene" when nothing would be drawn, "backend" when a package is missing, "value" for
    sizes and cameras that make no sense, "attribute" for an attribute that fits no surface.
    """
    return draw(scene, options or PictureOptions(), picture_backend(backend)).picture


def draw(scene: Scene, options: PictureOptions, backend: PictureBackend) -> Image:
    """One frame of ``scene`` as an image, drawn by ``backend``; raises SceneError as ``render`` does."""
    check(options, [backend])
    shot = still(scene, options.camera, options.frame, options.width, options.height)
    (painter,) = painters(scene, options, [backend], [shot])
    return painter.paint(shot, options.progress)


def painters(
    scene: Scene, options: PictureOptions, backends: Sequence[PictureBackend], shots: Sequence[Shot]
) -> list[Painter]:
    """The painters of several backends for the same ``shots``; raises SceneError."""
    frames = [shot.frame for shot in shots]
    staging = staging_of(scene, frames, options.limit, options.environment, options.ground, options.warn)
    return [backend.painter(staging, options, len(shots)) for backend in backends if backend.painter is not None]


def check(options: PictureOptions, backends: Sequence[Backend]) -> None:
    """Raises SceneError("value") for options that make no sense, whatever the scene."""
    if not (1 <= options.width <= LARGEST and 1 <= options.height <= LARGEST):
        raise SceneError(
            "value", f"a picture is 1 to {LARGEST} pixels wide and high, not {options.width} x {options.height}"
        )
    if options.width * options.height > _MOST_PIXELS:
        raise SceneError("value", f"a picture may have {_MOST_PIXELS:,} pixels, not {options.width} x {options.height}")
    _check_name("environment", options.environment, tuple(ENVIRONMENTS))
    if options.ground is not None:
        _check_name("ground", options.ground, tuple(GROUNDS))
    check_settings(options, backends)


def _check_name(what: str, name: str, known: Sequence[str]) -> None:
    if name not in known:
        hint = suggest(name, known) or f"it can be one of {', '.join(known)}"
        raise SceneError("value", f"there is no {what} `{name}`", hint=hint)


def write_still(backend_name: str) -> Callable[[Scene, Path, Options], None]:
    """The operation R of a picture backend, for the registry: draws one picture and writes it."""

    def run(scene: Scene, path: Path, options: Options) -> None:
        if not isinstance(options, PictureOptions):
            options = PictureOptions(options.frame, options.limit, options.progress, options.settings, options.warn)
        save_image(draw(scene, options, picture_backend(backend_name)), path)

    return run


def save_image(image: Image, path: Path | str) -> None:
    """Write ``image`` by the ending of ``path``, whole or not at all: PNG, JPEG, WebP, or its radiance as EXR.

    Raises SceneError: "backend" for another ending, "file" when the file cannot be written.
    """
    target = Path(path)
    if target.suffix.lower() == ".exr":
        save_radiance(image.radiance, target)
    else:
        save_picture(image.picture, target)


def save_picture(picture: Picture, path: Path | str) -> None:
    """Write ``picture`` (H, W, 3) as PNG, JPEG or WebP by the ending of ``path``, whole or not at all.

    Raises SceneError: "backend" for another ending, "file" when the file cannot be written.
    """
    target = Path(path)
    endings = tuple(ending for ending in STILL_ENDINGS if ending != ".exr")
    if target.suffix.lower() not in endings:
        raise SceneError("backend", f"a picture cannot be written as `{target.name}`", hint=f"use {' '.join(endings)}")
    image = need("PIL.Image", "pillow").fromarray(picture)
    with written_whole(target) as temporary:
        image.save(temporary, quality=92)


def png_of(picture: Picture) -> bytes:
    """``picture`` (H, W, 3) as PNG; raises SceneError("backend") without pillow."""
    data = io.BytesIO()
    need("PIL.Image", "pillow").fromarray(picture).save(data, "PNG")
    return data.getvalue()


def save_radiance(radiance: npt.NDArray[np.float32], path: Path | str) -> None:
    """Write ``radiance`` (H, W, 3), linear sRGB, as OpenEXR, whole or not at all; raises SceneError."""
    from scenelang.backends.exr import write_exr

    write_exr({"": radiance}, Path(path))
