"""The backend of draft pictures."""

from __future__ import annotations

from scenelang.backends.base import Accepts, Progress, Work
from scenelang.backends.draft.draw import Kept, draw
from scenelang.backends.labels import labelled
from scenelang.backends.picture import STILL_ENDINGS, Image, Painter, PictureBackend, PictureOptions, write_still
from scenelang.backends.shots import Shot
from scenelang.backends.stage import Staging
from scenelang.backends.studio import encode


class DraftPainter:
    """Draws shots by casting rays; what the fixed solids look like is kept from shot to shot."""

    def __init__(self, staging: Staging, options: PictureOptions) -> None:
        self._staging = staging
        self._labels = options.labels
        self._kept = Kept()

    def paint(self, shot: Shot, progress: Progress | None = None) -> Image:
        stage = self._staging.stage(shot)
        drawn = draw(stage, progress, kept=self._kept)
        picture = encode(drawn.linear)
        return Image(labelled(picture, stage.solids, drawn.ids) if self._labels else picture, drawn.radiance)


def _painter(staging: Staging, options: PictureOptions, shots: int) -> Painter:
    return DraftPainter(staging, options)


DRAFT = PictureBackend(
    name="draft",
    doc="quick pictures by an analytic ray caster, with soft shadows and ambient occlusion",
    work=Work.PICTURE,
    endings=STILL_ENDINGS,
    run=write_still("draft"),
    accepts=Accepts(),
    packages=("PIL",),
    install="pillow",
    painter=_painter,
)
