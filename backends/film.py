"""Films: turntables of static scenes, the frames of 4D ones; GIF, animated PNG and WebP by Pillow, MP4 by PyAV."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction
from pathlib import Path

import numpy as np

from scenelang.backends.base import Progress, need, part_of
from scenelang.backends.files import written_whole
from scenelang.backends.picture import Painter, Picture
from scenelang.backends.shots import Shot
from scenelang.grammar.diagnostics import SceneError

ENDINGS = (".gif", ".mp4", ".apng", ".webp")
FPS = 24
HIGHEST_FPS = 240.0
_MOST_BYTES = 4_000_000_000  # of all pictures of one film in memory
_GIF_COLORS = 255


def is_film(path: Path | str, wanted: bool) -> bool:
    """Whether ``path`` is to be a film: by its ending; a WebP file or a PNG may be either and is what is ``wanted``."""
    ending = Path(path).suffix.lower()
    return ending in (".gif", ".mp4", ".apng") or (wanted and ending in (".webp", ".png"))


def save_film(
    painters: Sequence[Painter],
    shots: Sequence[Shot],
    path: Path | str,
    fps: float = FPS,
    progress: Progress | None = None,
) -> None:
    """Draw ``shots`` and write them as one film by the ending of ``path``, whole or not at all.

    Several painters draw side by side. Raises SceneError: "value" for a frame rate that is none, "backend" for another
    ending or a missing package, "unsupported" where the film would not fit the memory, "file" when the file cannot be
    written.
    """
    target = Path(path)
    check_film(target, fps)
    size = sum(shot.camera.width * shot.camera.height * 3 for shot in shots) * len(painters)
    if target.suffix.lower() != ".mp4" and size > _MOST_BYTES:
        raise SceneError(
            "unsupported", f"{len(shots)} pictures of that size do not fit one {target.suffix} file",
            hint="write an .mp4, fewer --frames, or a smaller --size",
        )  # fmt: skip
    pictures = _drawn(painters, shots, progress)
    with written_whole(target) as temporary:
        if target.suffix.lower() == ".mp4":
            _write_mp4(pictures, temporary, fps)
        else:
            _write_pillow(pictures, temporary, fps)
    if progress is not None:
        progress(1.0)


def check_film(path: Path, fps: float) -> None:
    """Raises SceneError for a frame rate or an ending that no film has, or when its package is missing."""
    if not 0.0 < fps <= HIGHEST_FPS:
        raise SceneError("value", f"a film has up to {HIGHEST_FPS:g} frames per second, not {fps:g}")
    ending = path.suffix.lower()
    if ending not in (*ENDINGS, ".png"):
        raise SceneError("backend", f"a film cannot be written as `{path.name}`", hint=f"use {' '.join(ENDINGS)}")
    if ending == ".mp4":
        need("av", "'scenelang[video]'")


def _drawn(painters: Sequence[Painter], shots: Sequence[Shot], progress: Progress | None) -> Iterator[Picture]:
    for i, shot in enumerate(shots):
        pictures = []
        for k, painter in enumerate(painters):
            step = 0.98 / (len(shots) * len(painters))
            start = step * (i * len(painters) + k)
            pictures.append(painter.paint(shot, part_of(progress, start, start + step)).picture)
        yield side_by_side(pictures)


def side_by_side(pictures: Sequence[Picture]) -> Picture:
    """Pictures (H, W, 3) of one height beside each other."""
    return np.ascontiguousarray(np.concatenate(list(pictures), axis=1))


def _write_pillow(pictures: Iterator[Picture], path: Path, fps: float) -> None:
    module = need("PIL.Image", "pillow")
    images = [module.fromarray(picture) for picture in pictures]
    ending = path.suffix.lower()
    if ending == ".gif":
        images = [image.quantize(_GIF_COLORS, module.Quantize.FASTOCTREE) for image in images]
    first, rest = images[0], images[1:]
    kind = {".gif": "GIF", ".webp": "WEBP"}.get(ending, "PNG")
    more = {"quality": 88, "method": 4} if kind == "WEBP" else {"optimize": False} if kind == "GIF" else {}
    first.save(
        path, kind, save_all=True, append_images=rest, duration=_durations(len(images), fps, kind), loop=0, **more
    )


def _durations(count: int, fps: float, kind: str) -> list[int]:
    """Milliseconds that each picture stands, so that they add up; GIF counts in hundredths of a second."""
    unit = 10 if kind == "GIF" else 1
    ends = [round(1000.0 * (i + 1) / fps / unit) * unit for i in range(count)]
    return [max(unit, end - start) for start, end in zip([0, *ends[:-1]], ends, strict=True)]


def _write_mp4(pictures: Iterator[Picture], path: Path, fps: float) -> None:
    """H.264 as most players know it: even sizes, 4:2:0."""
    av = need("av", "'scenelang[video]'")
    with av.open(str(path), "w", format="mp4", options={"movflags": "faststart"}) as container:
        stream = container.add_stream("libx264", rate=Fraction(fps).limit_denominator(1001))
        stream.pix_fmt, stream.options = "yuv420p", {"crf": "18"}
        for i, picture in enumerate(pictures):
            even = np.pad(picture, ((0, picture.shape[0] % 2), (0, picture.shape[1] % 2), (0, 0)), mode="edge")
            if i == 0:
                stream.height, stream.width = even.shape[:2]
            frame = av.VideoFrame.from_ndarray(np.ascontiguousarray(even), format="rgb24")
            for packet in stream.encode(frame):
                container.mux(packet)
        for packet in stream.encode():
            container.mux(packet)
