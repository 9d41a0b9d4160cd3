"""The backend of draft images: it draws the shots of a staging with ``draft``."""

from __future__ import annotations

from dataclasses import replace

from scenelang.backends.base import Accepts, Option, Progress, Work
from scenelang.backends.pictures.draft import DraftCache, adjusted, draw_lens
from scenelang.backends.pictures.film import (
    STILL_ENDINGS,
    Image,
    Painter,
    PictureBackend,
    PictureOptions,
    clear_image,
    labeled,
    labels_of,
    write_still,
)
from scenelang.backends.pictures.stage import Shot, Stage, Staging
from scenelang.backends.surfaces.image_files import encode


class DraftPainter:
    """Draws shots by casting rays; image and light of static solids are cached from shot to shot."""

    def __init__(self, staging: Staging, options: PictureOptions) -> None:
        self._staging = staging
        self._labels = options.labels
        self._background = options.background
        self._by_pixel = DRAFT.setting(options, "shading") == "pixel"
        self._cache = DraftCache()

    def paint(self, shot: Shot, progress: Progress | None = None) -> Image:
        """Draw one shot; see ``Painter``. The first one decides the backdrop and the exposure.

        Shots that show the same one after the other, as in a video with more images than the scene has frames, share
        their image.
        """
        self._staging = adjusted(self._staging, shot)
        stage = self._staging.stage(shot)
        shown = shot.frame, shot.camera.identity, stage.lights, stage.instant
        return self._cache.get("image", shown, lambda: self._draw(stage, progress))

    def _draw(self, stage: Stage, progress: Progress | None) -> Image:
        """Draw a stage."""
        if len(self._staging.moving) == 1:  # one frame, perhaps seen by several cameras
            stage = replace(stage, fixed=len(stage.solids))
        drawn = draw_lens(stage, progress, cache=self._cache, by_pixel=self._by_pixel)
        if stage.is_clear:
            labels = labels_of(stage.solids, drawn.ids) if self._labels else []
            return clear_image(drawn.linear, drawn.radiance, drawn.alpha + drawn.shadow, labels, self._background)
        picture = encode(drawn.linear)
        return Image(labeled(picture, stage.solids, drawn.ids) if self._labels else picture, drawn.radiance)


def _painter(staging: Staging, options: PictureOptions, shots: int) -> Painter:
    """Create the painter of a staging; see ``PictureBackend``."""
    return DraftPainter(staging, options)


DRAFT = PictureBackend(
    name="draft",
    doc="fast pictures by an analytic ray caster, with soft shadows and ambient occlusion",
    work=Work.PICTURE,
    endings=STILL_ENDINGS,
    run=write_still("draft"),
    options=(Option("shading", "shade the edges of shadows by sample, or by pixel", "sample", ("sample", "pixel")),),
    accepts=Accepts(),
    packages=("PIL",),
    install="pillow",
    painter=_painter,
    has_alpha=True,
)
