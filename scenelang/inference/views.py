"""Pictures of a scene for a model to look at: several views of one, one view of several."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from scenelang.backends.language_models.conversation import Picture as Encoded
from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.entity import Scene

if TYPE_CHECKING:
    from scenelang.backends.picture import Picture

_SIZE = 448
_STILL = (
    ("from the front", "azimuth=0,elevation=15"),
    ("from the front right", "azimuth=40,elevation=25"),
    ("from behind on the left", "azimuth=220,elevation=25"),
    ("from above", "top"),
)
_FILM_VIEW = "azimuth=30,elevation=20"
_MOMENTS = (0.0, 0.13, 0.41, 0.77)  # of a film; no fractions at which things that go round look as they began
_MARGIN = 8


def views(scene: Scene) -> list[tuple[str, Encoded]]:
    """Several pictures with their captions: of a still scene from around, of a film at several times. Empty for a
    scene that cannot be drawn."""
    shown: list[tuple[str, str, int | None]] = [(caption, view, None) for caption, view in _STILL]
    if scene.animated:
        count = len(scene.frames)
        chosen = sorted({int(moment * count) for moment in _MOMENTS})
        shown = [(f"frame {frame} of {count}", _FILM_VIEW, frame) for frame in chosen]
    try:
        return [(f"The scene, {caption}:", encoded(picture(scene, view, frame))) for caption, view, frame in shown]
    except SceneError:
        return []


def picture(scene: Scene, view: str, frame: int | None = None, size: int = _SIZE) -> Picture:
    """A draft of a scene, (size, size, 3). Raises SceneError for a scene that cannot be drawn."""
    from scenelang.backends.picture import PictureOptions, render
    from scenelang.backends.viewpoint import parse_viewpoint

    options = PictureOptions(width=size, height=size, camera=parse_viewpoint(view), frame=frame)
    return render(scene, options)


def best_view(scene: Scene) -> Picture:
    """One picture that shows most: of a film its middle."""
    return picture(scene, _STILL[1][1], len(scene.frames) // 2 if scene.animated else None)


def contact_sheet(scenes: Sequence[Scene]) -> Encoded:
    """One view of each scene in a grid, with its number from 1."""
    from PIL import Image as Pillow
    from PIL import ImageDraw, ImageFont

    columns = math.ceil(math.sqrt(len(scenes)))
    rows = math.ceil(len(scenes) / columns)
    step = _SIZE + _MARGIN
    sheet = Pillow.new("RGB", (columns * step + _MARGIN, rows * step + _MARGIN), "white")
    font = ImageFont.load_default(40)
    for number, scene in enumerate(scenes):
        corner = (_MARGIN + number % columns * step, _MARGIN + number // columns * step)
        sheet.paste(Pillow.fromarray(best_view(scene)), corner)
        draw = ImageDraw.Draw(sheet)
        place = (corner[0] + 10, corner[1] + 6)
        draw.text(place, str(number + 1), fill="black", font=font, stroke_width=4, stroke_fill="white")
    return encoded(np.asarray(sheet))


def encoded(picture: Picture) -> Encoded:
    """A picture as models take it."""
    from scenelang.backends.picture import png_of

    return Encoded("image/png", png_of(picture))
