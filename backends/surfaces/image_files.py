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
LARGEST = 2048  # pixels per side of an image on a surface, which is reduced to it
IMAGE_FORMATS = ("PNG", "JPEG", "WEBP", "BMP", "GIF", "TGA", "TIFF", "PPM")  # whose decoders start no other program


def checked_image(path: Path, name: str) -> Any:
    """Return an image of Pillow; raises SceneError("file") if it is none, broken or too large."""
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
    try:
        image.load()
    except Exception:  # decoding an untrusted file may raise any exception
        raise SceneError("file", f"the image `{name[:80]}` is broken") from None
    return image


def linear_pixels(
    image: Any, behind: tuple[float, float, float] | None = None, most: int = LARGEST
) -> npt.NDArray[np.float32]:
    """Return the linear sRGB (H, W, 3) of an image of Pillow, reduced to at most ``most`` pixels on a side.

    Transparent pixels are mixed with the linear color ``behind``, in encoded values as browsers do; without one, alpha
    is ignored.
    """
    from PIL import Image

    image = image.copy()
    image.thumbnail((most, most))
    if image.mode.startswith("I"):  # 16 bits of gray, which Pillow would clip
        image = Image.fromarray((np.asarray(image, np.float64) / 257.0).clip(0.0, 255.0).astype(np.uint8))
    if behind is not None:
        rgba = image.convert("RGBA")
        back = Image.new("RGBA", rgba.size, (*encode(np.array(behind)).tolist(), 255))
        image = Image.alpha_composite(back, rgba)
    return from_srgb(np.asarray(image.convert("RGB"), np.float32) / np.float32(255.0)).astype(np.float32)


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
