"""Image files and their colors: the checks of files that programs name, and sRGB against linear light."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.base import require
from scenelang.grammar.diagnostics import SceneError

AnyFloats = npt.NDArray[np.floating]

MAX_PIXELS = 1 << 25  # of all images of a mesh file together, and of an image of a texture: 8192 x 4096
IMAGE_FORMATS = ("PNG", "JPEG", "WEBP", "BMP", "GIF", "TGA", "TIFF", "PPM")  # whose decoders start no other program


def checked_image(path: Path, name: str) -> Any:
    """Return an image of Pillow, not yet decoded; raises SceneError("file") if it is none or too large."""
    pillow = require("PIL.Image", "pillow")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            image = pillow.open(path, formats=IMAGE_FORMATS)
    except pillow.DecompressionBombError:
        raise SceneError("file", f"the image `{name[:80]}` has more than {MAX_PIXELS:,} pixels") from None
    except (OSError, ValueError, SyntaxError):
        raise SceneError("file", f"`{name[:80]}` is not an image that can be read") from None
    if image.width * image.height > MAX_PIXELS:
        raise SceneError("file", f"the image `{name[:80]}` has more than {MAX_PIXELS:,} pixels")
    return image


def encode(linear: AnyFloats) -> npt.NDArray[np.uint8]:
    """Convert linear sRGB in [0, 1] to 8-bit sRGB of the same shape."""
    return np.asarray(np.rint(to_srgb(linear) * 255.0), np.uint8)


def to_srgb(linear: AnyFloats) -> AnyFloats:
    """Convert linear sRGB to sRGB, both in [0, 1] (IEC 61966-2-1)."""
    x = np.clip(linear, 0.0, 1.0)
    return np.where(x <= 0.0031308, 12.92 * x, 1.055 * np.power(np.maximum(x, 0.0031308), 1.0 / 2.4) - 0.055)


def from_srgb(encoded: AnyFloats) -> AnyFloats:
    """Convert sRGB to linear sRGB, both in [0, 1] and of the same shape (IEC 61966-2-1)."""
    x = np.clip(encoded, 0.0, 1.0)
    return np.where(x <= 0.04045, x / 12.92, ((x + 0.055) / 1.055) ** 2.4)
