"""What painters make of shots: images, with alpha where they have it, and the font of texts on them."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from scenelang.backends.base import Progress, require
from scenelang.backends.pictures.stage import Shot
from scenelang.grammar.datum import dataclass

Picture = npt.NDArray[np.uint8]


@dataclass(frozen=True, slots=True, eq=False)
class Image:
    """A drawn shot: ``picture`` (H, W, 3) 8-bit sRGB with labels, ``radiance`` (H, W, 3) linear sRGB without labels.

    ``alpha`` (H, W) is None if all pixels are opaque. The picture's colors are not multiplied by it, the radiance is.
    """

    picture: Picture
    radiance: npt.NDArray[np.float32]
    alpha: Picture | None = None

    @property
    def rgba(self) -> Picture:
        """The picture with alpha, (H, W, 4)."""
        alpha = np.full(self.picture.shape[:2], 255, np.uint8) if self.alpha is None else self.alpha
        return np.dstack([self.picture, alpha])


class Painter(Protocol):
    """Draws the shots of one staging; computations that the shots share are done once."""

    def paint(self, shot: Shot, progress: Progress | None = None) -> Image:
        """Draw one shot; ``progress`` is called with a fraction from 0 to 1. Raises SceneError."""


def flattened(rgba: Picture, background: Picture) -> Picture:
    """Return a picture with alpha (H, W, 4) over a flat background (3,), both 8-bit sRGB."""
    share = rgba[:, :, 3:].astype(np.float32) / np.float32(255.0)
    return np.asarray(np.rint(rgba[:, :, :3] * share + background * (1.0 - share)), np.uint8)


def font_for(text: str, size: int) -> Any:
    """Return Pillow's default font, or a system font with wider coverage for non-ASCII text, if available."""
    fonts = require("PIL.ImageFont", "pillow")
    if not text.isascii():
        for name in ("DejaVuSans.ttf", "NotoSans-Regular.ttf", "Arial Unicode.ttf", "arial.ttf"):
            try:
                return fonts.truetype(name, size)
            except OSError:
                continue
    return fonts.load_default(size)
