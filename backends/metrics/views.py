"""The pictures that metrics look at: a turn around the scene, or its frames by a camera that stands still."""

from __future__ import annotations

from collections.abc import Sequence

from scenelang.backends.base import Progress, part_of
from scenelang.backends.picture import Picture, PictureOptions, painters, picture_backend
from scenelang.backends.shots import Shot, film
from scenelang.backends.viewpoint import PRESETS, Viewpoint
from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.entity import Scene

CLIP_VIEWS, LPIPS_VIEWS = 120, 20  # as the paper's
AROUND = PRESETS["turntable"]
STEADY = Viewpoint(AROUND.azimuth, AROUND.elevation)
_MOST_BYTES = 4_000_000_000  # of all pictures of a scene in memory


def around(scene: Scene, count: int, width: int, height: int) -> list[Shot]:
    """``count`` shots from equal angles of a full circle, all as far away; a 4D scene goes on from one to the next, its
    frames evenly chosen. Raises SceneError."""
    return film(scene, AROUND, width, height, count, 360.0)


def steady(scene: Scene, width: int, height: int) -> list[Shot]:
    """Every frame of a scene once, from one place; raises SceneError."""
    return film(scene, STEADY, width, height, len(scene.frames), 0.0)


def drawn(
    scene: Scene, shots: Sequence[Shot], options: PictureOptions, backend: str, progress: Progress | None = None
) -> list[Picture]:
    """The pictures (H, W, 3) of ``shots``; raises SceneError where they cannot be drawn, or do not fit the memory."""
    check_room(sum(shot.camera.width * shot.camera.height * 3 for shot in shots))
    (painter,) = painters(scene, options, [picture_backend(backend)], shots)
    count = len(shots)
    return [painter.paint(shot, part_of(progress, i / count, (i + 1) / count)).picture for i, shot in enumerate(shots)]


def check_room(size: int) -> None:
    """Raises SceneError("unsupported") for pictures of ``size`` bytes where these are too many."""
    if size > _MOST_BYTES:
        raise SceneError("unsupported", "pictures of that size do not fit the memory", hint="choose a smaller --size")
