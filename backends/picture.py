"""Pictures of scenes, in draft and final quality: the operation R of the two picture backends."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Literal

import numpy as np
import numpy.typing as npt

from scenelang.backends.base import Backend, Options, Work, need
from scenelang.backends.camera import Camera
from scenelang.backends.files import written_whole
from scenelang.backends.stage import Stage, stage_of
from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.entity import Scene

Picture = npt.NDArray[np.uint8]
Quality = Literal["draft", "final"]

ENDINGS = (".png", ".jpg", ".jpeg", ".webp")
LARGEST = 8192
_MOST_PIXELS = 4096 * 4096


@dataclass(frozen=True, slots=True)
class PictureOptions(Options):
    """``width`` and ``height`` in pixels; ``samples`` per pixel and ``seed`` matter to final pictures only (the same
    seed gives the same picture); ``labels`` writes the words of semantic primitives on the picture."""

    width: int = 512
    height: int = 512
    camera: Camera = field(default_factory=Camera)
    quality: Quality = "final"
    samples: int = 64
    seed: int = 0
    labels: bool = True


def render(scene: Scene, options: PictureOptions | None = None) -> Picture:
    """One frame of ``scene`` as a picture: (height, width, 3), 8-bit sRGB.

    Raises SceneError: "empty-scene" when nothing would be drawn, "backend" when a package is missing, "value" for
    sizes and cameras that make no sense, "attribute" for an opacity or emission that is none.
    """
    options = options or PictureOptions()
    _check(options)
    stage = stage_of(scene, options.camera, options.frame, options.width, options.height, options.limit)
    return _draft(stage, options) if options.quality == "draft" else _final(stage, options)


def _check(options: PictureOptions) -> None:
    if options.quality not in ("draft", "final"):
        raise SceneError("value", f"the quality of a picture is `draft` or `final`, not `{options.quality}`")
    if not (1 <= options.width <= LARGEST and 1 <= options.height <= LARGEST):
        raise SceneError(
            "value", f"a picture is 1 to {LARGEST} pixels wide and high, not {options.width} x {options.height}"
        )
    if options.width * options.height > _MOST_PIXELS:
        raise SceneError("value", f"a picture may have {_MOST_PIXELS:,} pixels, not {options.width} x {options.height}")
    if not 1 <= options.samples <= 65536:
        raise SceneError("value", f"a final picture takes 1 to 65536 samples per pixel, not {options.samples}")


def _draft(stage: Stage, options: PictureOptions) -> Picture:
    from scenelang.backends import draft
    from scenelang.backends.labels import labels_of, write_labels
    from scenelang.backends.studio import encode

    drawn = draft.draw(stage, options.progress)
    picture = encode(drawn.linear)
    return write_labels(picture, labels_of(stage.solids, drawn.ids)) if options.labels else picture


def _final(stage: Stage, options: PictureOptions) -> Picture:
    from scenelang.backends import draft, mitsuba
    from scenelang.backends.labels import labels_of, write_labels
    from scenelang.backends.studio import encode

    guide = draft.draw(stage, _part(options.progress, 0.0, 0.1), shaded=False)
    linear = mitsuba.draw(stage, guide, options.samples, options.seed, _part(options.progress, 0.1, 1.0))
    picture = encode(linear)
    return write_labels(picture, labels_of(stage.solids, guide.ids)) if options.labels else picture


def _part(progress: Callable[[float], None] | None, start: float, end: float) -> Callable[[float], None] | None:
    """``progress`` for a part of the work that takes it from ``start`` to ``end``."""
    if progress is None:
        return None
    return lambda share: progress(start + (end - start) * share)


def save_picture(picture: Picture, path: Path | str) -> None:
    """Write ``picture`` (H, W, 3) as PNG, JPEG or WebP by the ending of ``path``, whole or not at all.

    Raises SceneError: "backend" for another ending, "file" when the file cannot be written.
    """
    target = Path(path)
    if target.suffix.lower() not in ENDINGS:
        raise SceneError("backend", f"a picture cannot be written as `{target.name}`", hint=f"use {' '.join(ENDINGS)}")
    image = need("PIL.Image", "pillow").fromarray(picture)
    with written_whole(target) as temporary:
        image.save(temporary, quality=92)


def _write(quality: Quality) -> Callable[[Scene, Path, Options], None]:
    def run(scene: Scene, path: Path, options: Options) -> None:
        names = [known.name for known in fields(PictureOptions) if hasattr(options, known.name)]
        given = {name: getattr(options, name) for name in names}
        given["quality"] = quality
        save_picture(render(scene, PictureOptions(**given)), path)

    return run


DRAFT = Backend(
    name="draft",
    doc="quick pictures by an analytic ray caster, with soft shadows",
    work=Work.PICTURE,
    endings=ENDINGS,
    run=_write("draft"),
    packages=("PIL",),
    install="pillow",
)
FINAL = Backend(
    name="mitsuba",
    doc="path-traced pictures by Mitsuba 3, denoised",
    work=Work.PICTURE,
    endings=ENDINGS,
    run=_write("final"),
    packages=("mitsuba", "PIL"),
    install="mitsuba mitsuba-oidn pillow",
)
