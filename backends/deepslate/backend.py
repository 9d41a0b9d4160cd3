"""The backend of pictures with the game's own looks."""

from __future__ import annotations

import io

import numpy as np

from scenelang.backends.base import Accepts, Option, Progress, Work, need
from scenelang.backends.camera import Camera, camera_to_json
from scenelang.backends.deepslate.browser import INSTALL, PACKAGES, Browser
from scenelang.backends.deepslate.builds import builds_of
from scenelang.backends.deepslate.looks import looks_of
from scenelang.backends.deepslate.page import Surroundings, page_of
from scenelang.backends.deepslate.places import layers_for
from scenelang.backends.picture import (
    STILL_ENDINGS,
    Image,
    Painter,
    Picture,
    PictureBackend,
    PictureOptions,
    write_still,
)
from scenelang.backends.shots import Shot
from scenelang.backends.stage import Staging
from scenelang.backends.studio import from_srgb, to_srgb
from scenelang.interpreter.shapes import BLOCK_WORDS

_FINEST = 3  # samples along each side of a pixel
_MOST_SAMPLES = 4096 * 4096


class BuildPainter:
    """Takes pictures of one page in one browser, which starts with the first of them."""

    def __init__(self, staging: Staging, options: PictureOptions) -> None:
        self._staging = staging
        layers = layers_for(DEEPSLATE.setting(options, "textures"))  # looked for first: a build may take long
        self._builds = builds_of(staging.asked, options.limit)
        self._looks = looks_of(self._builds.palette, layers)
        self._browser: Browser | None = None
        for warning in (*self._builds.warnings, *self._looks.warnings):
            if options.warn is not None:
                options.warn(warning)

    def paint(self, shot: Shot, progress: Progress | None = None) -> Image:
        if self._browser is None:
            self._browser = Browser(self._page(shot.camera))
        camera = shot.camera
        factor = next((n for n in range(_FINEST, 1, -1) if n * n * camera.width * camera.height <= _MOST_SAMPLES), 1)
        png = self._browser.shoot(shot.frame, camera_to_json(camera), factor)
        if progress is not None:
            progress(1.0)
        return _image(png, camera, factor)

    def _page(self, camera: Camera) -> str:
        stage = self._staging
        around = Surroundings(stage.center, stage.scale, stage.lowest, stage.environment, stage.ground)
        return page_of("build", self._builds, self._looks, around, camera)


def _image(png: bytes, camera: Camera, factor: int) -> Image:
    """The picture of ``factor`` x ``factor`` samples for each pixel, averaged as light."""
    with need("PIL.Image", "pillow").open(io.BytesIO(png)) as drawn:
        samples = np.asarray(drawn.convert("RGB"), np.uint8)
    light = from_srgb(np.arange(256) / 255.0).astype(np.float32)[samples]
    radiance = light.reshape(camera.height, factor, camera.width, factor, 3).mean(axis=(1, 3))
    picture: Picture = np.rint(255.0 * to_srgb(radiance)).astype(np.uint8)
    return Image(picture, radiance)


def _painter(staging: Staging, options: PictureOptions, shots: int) -> Painter:
    return BuildPainter(staging, options)


DEEPSLATE = PictureBackend(
    name="deepslate",
    doc="builds of Minecraft with the game's own looks, drawn in a browser",
    work=Work.PICTURE,
    endings=STILL_ENDINGS,
    run=write_still("deepslate"),
    options=(
        Option(
            "textures",
            "the game's jar, a resource pack or npm's minecraft-assets; else the installed game",
            "",
        ),
    ),
    accepts=Accepts(words=BLOCK_WORDS, any_word=False, attributes=()),
    packages=(*PACKAGES, "PIL"),
    install=INSTALL,
    painter=_painter,
)
