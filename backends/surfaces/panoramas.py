"""Panoramas from files: Radiance (.hdr) and OpenEXR (.exr) images in latitude and longitude, and the sun in them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from scenelang.backends.base import require
from scenelang.backends.files import read_regular
from scenelang.backends.surfaces.dome import Panorama, directions_of, smaller, solid_angles
from scenelang.backends.surfaces.image_files import MAX_PIXELS
from scenelang.grammar.diagnostics import SceneError

FloatArray = npt.NDArray[np.float64]

LUMINANCE = np.array([0.2126, 0.7152, 0.0722])  # of linear sRGB
_MAX_IMAGE_BYTES = 256_000_000  # of a file
_MAX_IMAGE_ROWS = 256  # to which images are reduced
# To which images are enlarged: light is added up at the middles of pixels, which must be near together for a sun to
# differ from what is around it, and for a surface to see what is above the horizon.
_MIN_IMAGE_ROWS = 32
_FINAL_EXTRA = "'scenelang[final]'"  # what installs Mitsuba, which reads OpenEXR
# A sun is the brightest spot, within a few degrees, if it gives so much of all light.
_SUN_SHARE, _SUN_DEGREES = 0.12, 6.0


@dataclass(frozen=True, slots=True, eq=False)
class Sun:
    """The sun of a panorama: the radiance ``light`` (3,) of a white surface that faces it, and its place in degrees."""

    light: FloatArray
    azimuth: float
    elevation: float
    radius: float


def panorama_from(path: str) -> Panorama:
    """Return the panorama of an image file, whose middle column is +z; raises SceneError("file")."""
    target = Path(path)
    try:
        if target.stat().st_size > _MAX_IMAGE_BYTES:
            raise SceneError("file", f"`{path}` is larger than {_MAX_IMAGE_BYTES:,} bytes")
        image = _exr(target) if target.suffix.lower() == ".exr" else radiance_image(read_regular(target))
    except OSError as error:
        raise SceneError("file", f"cannot read `{path}`: {error.strerror or error}") from None
    except (ValueError, RuntimeError, IndexError):
        raise SceneError("file", f"`{path}` is not an image that can be read") from None
    height, width = image.shape[:2]
    if width != 2 * height:
        hint = "an image of all directions is twice as wide as it is high"
        raise SceneError("file", f"`{path}` has {width} x {height} pixels and is not a panorama", hint)
    if not np.isfinite(image).all() or (image < 0.0).any():
        raise SceneError("file", f"`{path}` has pixels that are not light: infinite, negative or not numbers")
    if not image.any():
        raise SceneError("file", f"`{path}` is black: it lights nothing")
    # Images have -z, or another direction, in the middle; ours have +z there, and columns grow towards +x.
    return Panorama(smaller(_enlarged(image[:, ::-1]), _MAX_IMAGE_ROWS))


def _enlarged(image: FloatArray) -> FloatArray:
    """Return an image (H, W, 3) whose pixels are repeated if it has few of them."""
    times = -(-_MIN_IMAGE_ROWS // len(image))
    return image if times == 1 else image.repeat(times, 0).repeat(times, 1)


def _exr(path: Path) -> FloatArray:
    """Return the first three channels (H, W, 3) of an OpenEXR file."""
    mi = require("mitsuba", _FINAL_EXTRA)
    bitmap = mi.Bitmap(str(path))
    values = np.array(bitmap.convert(mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.Float32, False), np.float64)
    return values.reshape(values.shape[0], -1, 3)


def radiance_image(data: bytes) -> FloatArray:
    """Return the pixels (H, W, 3) of a Radiance file (.hdr), run-length encoded or not; raises ValueError."""
    head, _, rest = data.partition(b"\n\n")
    if not head.startswith((b"#?RADIANCE", b"#?RGBE")) or b"32-bit_rle_rgbe" not in head:
        raise ValueError("not a Radiance file")
    size, _, body = rest.partition(b"\n")
    words = size.split()
    if len(words) != 4 or words[0] != b"-Y" or words[2] != b"+X":
        raise ValueError("unknown orientation")
    height, width = int(words[1]), int(words[3])
    if not 0 < height * width <= MAX_PIXELS:
        raise ValueError("too large")
    rgbe = _scanlines(body, height, width)
    scale = np.ldexp(1.0, rgbe[:, :, 3].astype(np.int64) - 136) * (rgbe[:, :, 3] > 0)
    return np.asarray(rgbe[:, :, :3] * scale[:, :, None], np.float64)


def _scanlines(body: bytes, height: int, width: int) -> npt.NDArray[np.uint8]:
    """Return the bytes (H, W, 4) of the pixels of a Radiance file."""
    plain = len(body) >= 4 * height * width and body[:2] != b"\x02\x02"
    if plain:
        return np.frombuffer(body, np.uint8, 4 * height * width).reshape(height, width, 4)
    out = np.zeros((height, width, 4), np.uint8)
    at = 0
    for row in range(height):
        if body[at : at + 2] != b"\x02\x02" or body[at + 2] * 256 + body[at + 3] != width:
            raise ValueError("unknown encoding")
        at += 4
        for channel in range(4):
            at = _runs(body, at, out[row, :, channel])
    return out


def _runs(body: bytes, at: int, line: npt.NDArray[np.uint8]) -> int:
    """Decode the runs of one channel of a line from a place in the file; return the place after them."""
    column = 0
    while column < len(line):
        count = body[at]
        if count > 128:
            count -= 128
            line[column : column + count] = body[at + 1]
            at += 2
        else:
            if count == 0:
                raise ValueError("an empty run")
            line[column : column + count] = np.frombuffer(body, np.uint8, count, at + 1)
            at += 1 + count
        column += count
    return at


def without_sun(panorama: Panorama) -> tuple[Panorama, Sun | None]:
    """Return a panorama with its sun replaced by the sky around it, and the sun.

    A sun is a spot around the brightest pixel above the horizon that gives ``_SUN_SHARE`` of the light on a level
    surface. Without one the panorama is unchanged, and the sun None.
    """
    image = panorama.image
    toward, weight = directions_of(len(image)), solid_angles(len(image))
    light = image @ LUMINANCE
    brightest = np.unravel_index(int(np.argmax(light * (toward[:, :, 1] > 0.0))), light.shape)
    near = toward @ toward[brightest] > math.cos(math.radians(_SUN_DEGREES))
    ring = (toward @ toward[brightest] > math.cos(math.radians(2.0 * _SUN_DEGREES))) & ~near
    sky = np.median(image[ring], axis=0) if ring.any() else np.zeros(3)
    extra = np.maximum(image - sky, 0.0) * (near * weight)[:, :, None]
    received = light * weight * np.maximum(toward[:, :, 1], 0.0)
    share = float((extra @ LUMINANCE * np.maximum(toward[:, :, 1], 0.0)).sum()) / max(float(received.sum()), 1e-12)
    if share < _SUN_SHARE:
        return panorama, None
    power = extra @ LUMINANCE
    middle = (toward * power[:, :, None]).sum(axis=(0, 1))
    middle /= np.linalg.norm(middle)
    spread = np.degrees(np.arccos(np.clip(toward @ middle, -1.0, 1.0)))
    radius = math.sqrt(2.0) * float((spread**2 * power).sum() / power.sum()) ** 0.5
    rest = np.where(near[:, :, None], np.minimum(image, sky), image)
    azimuth, elevation = math.degrees(math.atan2(middle[0], middle[2])), math.degrees(math.asin(float(middle[1])))
    return Panorama(rest), Sun(extra.sum(axis=(0, 1)) / math.pi, azimuth, elevation, min(max(radius, 0.5), 10.0))
