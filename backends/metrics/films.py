"""Films of others as pictures: what another method made, to be measured as scenes are."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from scenelang.backends.base import need
from scenelang.backends.metrics.views import check_room
from scenelang.backends.picture import Picture
from scenelang.backends.shots import MOST_FRAMES
from scenelang.grammar.diagnostics import SceneError

ENDINGS = (".mp4", ".gif", ".webp", ".apng", ".png", ".jpg", ".jpeg")
_LARGEST = 64_000_000  # pixels of one picture


def read_film(path: Path | str) -> list[Picture]:
    """Every picture (H, W, 3) of a film or picture file, 8-bit sRGB.

    Raises SceneError: "file" where it is none that can be read, "unsupported" where it does not fit the memory,
    "backend" where a package is missing.
    """
    source = Path(path)
    if source.suffix.lower() not in ENDINGS:
        raise SceneError("file", f"{path} is no film: it can be one of {' '.join(ENDINGS)}")
    frames = _video(source) if source.suffix.lower() == ".mp4" else _animation(source)
    found: list[Picture] = []
    size = 0
    for picture in frames:
        size += picture.nbytes
        check_room(size)
        found.append(picture)
        if len(found) > MOST_FRAMES:
            raise SceneError("file", f"{path} has more than {MOST_FRAMES:,} frames")
    if not found:
        raise SceneError("file", f"{path} holds no pictures")
    return found


def _animation(path: Path) -> Iterator[Picture]:
    image = need("PIL.Image", "pillow")
    try:
        with image.open(path) as film:
            _check(path, film.width, film.height)
            for number in range(getattr(film, "n_frames", 1)):
                film.seek(number)
                yield np.asarray(film.convert("RGB"), np.uint8)
    except (OSError, ValueError, SyntaxError, image.DecompressionBombError) as error:
        raise _unread(path, error) from None


def _video(path: Path) -> Iterator[Picture]:
    av = need("av", "'scenelang[video]'")
    try:
        with av.open(str(path)) as container:
            for frame in container.decode(video=0):
                _check(path, frame.width, frame.height)
                picture: Any = frame.to_ndarray(format="rgb24")
                yield np.ascontiguousarray(picture)
    except (av.FFmpegError, OSError, ValueError, IndexError) as error:
        raise _unread(path, error) from None


def _check(path: Path, width: int, height: int) -> None:
    if width * height > _LARGEST:
        raise SceneError("file", f"{path} has more than {_LARGEST:,} pixels")


def _unread(path: Path, error: Exception) -> SceneError:
    return SceneError("file", f"{path} is no film that can be read: {str(error)[:120]}")
