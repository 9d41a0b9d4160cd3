"""Small pictures of the documentation, by the draft renderer."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt
from PIL import Image

from scenelang import Options, Session, Source
from scenelang.backends.pictures.declared import view_of
from scenelang.backends.pictures.film import PictureOptions, render
from scenelang.grammar.diagnostics import render_text

_ROOT = Path(__file__).parents[2]  # mesh files of programs are relative to it
_OVERSAMPLING = 2
_COLORS = 128


def drawn(
    program: str, size: tuple[int, int], camera: str, frame: int | None = None, oversampling: int = _OVERSAMPLING
) -> Image.Image:
    """The picture of a program, ``size`` in pixels; raises ValueError for a program that is wrong."""
    result = Session(Options(project=_ROOT)).evaluate(Source("<documentation>", program))
    if result.scene is None or result.diagnostics:
        raise ValueError("\n".join(render_text(d) for d in result.diagnostics))
    width, height = (oversampling * side for side in size)
    options = PictureOptions(width=width, height=height, camera=view_of(camera), frame=frame)
    picture = Image.fromarray(render(result.scene, options))
    return picture.resize(size, Image.Resampling.LANCZOS)


def save(picture: Image.Image, path: Path) -> None:
    """Write a picture as a PNG of few bytes, unless the one that is there shows the same."""
    if path.exists() and difference(picture, path) < 1:
        return
    path.parent.mkdir(parents=True, exist_ok=True)
    small = picture.quantize(_COLORS, Image.Quantize.MEDIANCUT, dither=Image.Dither.FLOYDSTEINBERG)
    small.save(path, optimize=True)


def difference(picture: Image.Image, path: Path) -> float:
    """How far a picture is from a file's: the mean over blocks of 4 x 4 pixels, of 255; 255 for other sizes."""
    there = Image.open(path).convert("RGB")
    if there.size != picture.size:
        return 255.0
    return float(np.abs(_blocks(picture) - _blocks(there)).mean())


def _blocks(picture: Image.Image) -> npt.NDArray[np.float64]:
    width, height = (side // 4 for side in picture.size)
    values = np.asarray(picture.convert("RGB"), np.float64)[: 4 * height, : 4 * width]
    return values.reshape(height, 4, width, 4, 3).mean(axis=(1, 3))
