"""A part of a picture cut out along its mask, as diffusion models were trained to see things: in the middle of a
square, on plain grey (the paper, appendix "Textual Inversion Optimization")."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt

from scenelang.backends.base import need
from scenelang.backends.clip.images import open_picture
from scenelang.backends.grounding.masks import Mask
from scenelang.grammar.diagnostics import SceneError

Bytes = npt.NDArray[np.uint8]
_THING = 128  # a mask file's brightness from which a pixel belongs to the thing


def read_mask(path: Path | str, width: int, height: int) -> Mask:
    """The mask (H, W) of a picture file, light where the thing is; raises SceneError("file" or "value")."""
    picture = open_picture(path)
    if picture.size != (width, height):
        message = f"{path} has {picture.width} x {picture.height} pixels; the picture that it masks {width} x {height}"
        raise SceneError("value", message)
    found: Mask = np.asarray(picture.convert("L")) >= _THING
    return found


def mask_box(mask: Mask) -> tuple[int, int, int, int]:
    """The smallest box around what ``mask`` (H, W) shows: the first column and row in it, the first ones after it.

    Raises SceneError("value") for a mask that shows nothing.
    """
    rows, columns = np.flatnonzero(mask.any(1)), np.flatnonzero(mask.any(0))
    if not len(rows):
        raise SceneError("value", "the mask shows nothing of the picture")
    return int(columns[0]), int(rows[0]), int(columns[-1]) + 1, int(rows[-1]) + 1


def random_grey(seed: int) -> int:
    """A background's brightness, any of 256."""
    return int(np.random.default_rng(seed % (1 << 63)).integers(256))


def cut_out(picture: Bytes, mask: Mask, grey: int) -> Bytes:
    """What ``mask`` (H, W) shows of ``picture`` (H, W, 3) in the middle of the smallest square (S, S, 3) that holds it,
    on ``grey``. Of an odd number of pixels around it the larger half is right and below.

    Raises SceneError("value") for a mask that shows nothing.
    """
    left, top, right, bottom = mask_box(mask)
    width, height = right - left, bottom - top
    side = max(width, height)
    x, y = (side - width) // 2, (side - height) // 2
    square: Bytes = np.full((side, side, 3), grey, np.uint8)
    inside = mask[top:bottom, left:right, None]
    square[y : y + height, x : x + width] = np.where(inside, picture[top:bottom, left:right], np.uint8(grey))
    return square


def resized(square: Bytes, size: int) -> Bytes:
    """The picture with ``size`` pixels along each side."""
    image = need("PIL.Image", "pillow")
    found: Bytes = np.asarray(image.fromarray(square).resize((size, size), image.Resampling.LANCZOS))
    return found
