"""A scene made ready for drawing: flattened, brought to unit size, with the camera placed and the ground laid."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from scenelang.backends.camera import Camera, View, checked, place
from scenelang.backends.solids import Solids, normalized, solids_of
from scenelang.backends.studio import Studio, studio_for
from scenelang.grammar.diagnostics import LimitError, SceneError
from scenelang.interpreter.bounds import entity_box
from scenelang.interpreter.entity import Scene, primitive_count
from scenelang.interpreter.flatten import flatten_entity

FloatArray = npt.NDArray[np.float64]

_BELOW = 1e-4  # the ground lies this far under the lowest point, so that flat floors hide it


@dataclass(frozen=True, slots=True, eq=False)
class Stage:
    """Everything a renderer needs, in the frame where the scene's box is centred and has the half diagonal 1.

    ``ground`` is the ground's height, None where the camera looks from below it and would see nothing else.
    ``center`` (3,) and ``scale`` give that frame: ``p_stage = scale (p_world - center)``.
    """

    solids: Solids
    view: View
    studio: Studio
    ground: float | None
    width: int
    height: int
    center: FloatArray
    scale: float


_FARTHEST = 1e152  # squares of coordinates beyond it are no numbers any more


def box_of(scene: Scene) -> tuple[FloatArray, FloatArray]:
    """The exact box of all frames, low and high (3,) each; raises SceneError("empty-scene") when there is none."""
    boxes = [box for root in scene.frames if (box := entity_box(root)) is not None]
    if not boxes:
        raise SceneError("empty-scene", f'the scene "{scene.word}" has no primitives, so there is nothing to draw')
    every = np.array(boxes)
    low, high = every[:, :3].min(axis=0), every[:, 3:].max(axis=0)
    with np.errstate(over="ignore"):
        sizes = high - low
    if not np.isfinite(sizes).all() or max(np.abs(low).max(), np.abs(high).max()) > _FARTHEST:
        raise SceneError("unsupported", "the scene is larger than any number can tell, so it cannot be drawn")
    return low, high


def stage_of(scene: Scene, camera: Camera, frame: int, width: int, height: int, limit: int) -> Stage:
    """Prepare frame number ``frame`` for a picture of ``width`` x ``height`` pixels.

    The camera, the ground and the unit size are those of all frames together, so that a film does not jump. Raises
    SceneError, and LimitError when the frame expands to more than ``limit`` primitives.
    """
    if not 0 <= frame < len(scene.frames):
        have = f"{len(scene.frames)} frames, 0 to {len(scene.frames) - 1}" if len(scene.frames) > 1 else "one frame, 0"
        raise SceneError("value", f"the scene has {have}; there is no frame {frame}")
    low, high = box_of(scene)
    root = scene.frames[frame]
    count = primitive_count(root)
    if count > limit:
        raise LimitError(
            "primitives",
            f"the scene expands to {count:,} primitives, more than the {limit:,} that one picture may have",
            hint="raise the limit, or draw a part of the scene",
        )
    half = 0.5 * float(np.linalg.norm(high - low))
    center, scale = (low + high) / 2.0, 1.0 / half if half > 1e-300 else 1.0
    view = place(checked(camera), low, high, width / height).moved(center, scale)
    solids = normalized(solids_of(flatten_entity(root)), center, scale)
    ground = (low[1] - center[1]) * scale - _BELOW
    visible = view.eye[1] > ground + 1e-3
    return Stage(solids, view, studio_for(view), ground if visible else None, width, height, center, scale)
