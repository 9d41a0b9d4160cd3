"""A scene made ready for drawing: flattened, brought to unit size, with the camera placed and the ground laid."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from scenelang.backends.camera import Camera
from scenelang.backends.minecraft.cubes import as_cubes
from scenelang.backends.shots import Shot, box_of
from scenelang.backends.solids import Solids, normalized, parted, solids_of
from scenelang.backends.studio import Studio, studio_for
from scenelang.grammar.diagnostics import Diagnostic, LimitError
from scenelang.interpreter.entity import Entity, Scene, primitive_count
from scenelang.interpreter.flatten import flatten_entity

FloatArray = npt.NDArray[np.float64]

BELOW = 1e-4  # the ground lies this far under the lowest point, so that flat floors hide it


@dataclass(frozen=True, slots=True, eq=False)
class Stage:
    """Everything a renderer needs, in the frame where the scene's box is centred and has the half diagonal 1.

    The first ``fixed`` solids are the same in all stages of one film. ``ground`` is the ground's height, None where
    there is none, or the camera looks from below it and would see nothing else. ``center`` (3,) and ``scale`` give that
    frame: ``p_stage = scale (p_world - center)``.
    """

    solids: Solids
    fixed: int
    camera: Camera
    studio: Studio
    ground: float | None
    center: FloatArray
    scale: float

    @property
    def width(self) -> int:
        return self.camera.width

    @property
    def height(self) -> int:
        return self.camera.height


@dataclass(frozen=True, slots=True, eq=False)
class Staging:
    """The frames of a scene that one picture or film shows, prepared for any camera.

    ``fixed`` are the solids that are equal in all of them, ``moving`` the others, and ``roots`` the entities, by frame
    number, blocks as cubes; ``asked`` are the entities as the program made them.
    """

    asked: dict[int, Entity]
    roots: dict[int, Entity]
    fixed: Solids | None
    moving: dict[int, Solids]
    lowest: float
    center: FloatArray
    scale: float
    environment: str
    ground: str | None

    def stage(self, shot: Shot) -> Stage:
        """The stage of one shot. Everything but the moving solids is the same in all shots of one camera."""
        camera = shot.camera.rescaled(self.center, self.scale)
        studio = studio_for(camera, self.environment, self.ground)
        solids = self.moving[shot.frame]
        if self.fixed is not None:
            solids = self.fixed.followed_by(solids)
        ground = (self.lowest - self.center[1]) * self.scale - BELOW
        lies = studio.ground is not None and camera.eye[1] > ground + 1e-3
        fixed = len(self.fixed) if self.fixed is not None else 0
        return Stage(solids, fixed, camera, studio, ground if lies else None, self.center, self.scale)


def staging_of(
    scene: Scene,
    frames: Sequence[int],
    limit: int,
    environment: str = "studio",
    ground: str | None = None,
    warn: Callable[[Diagnostic], None] | None = None,
) -> Staging:
    """Prepare the ``frames`` of ``scene``; ``warn`` is told what is not drawn as the program asks.

    The unit size and the ground are those of all frames of the scene together, so that a film does not jump. Raises
    SceneError, and LimitError when a frame expands to more than ``limit`` primitives.
    """
    low, _ = box_of(scene)
    center, scale = unit_size(scene)
    shown = list(dict.fromkeys(frames))
    asked = {frame: scene.frames[frame] for frame in shown}
    drawn = as_cubes(Scene(scene.word, list(asked.values()), scene.animated), limit, warn).frames
    solids = [_solids(root, limit, center, scale) for root in drawn]
    fixed, moving = parted(solids) if len(shown) > 1 else (None, solids)
    roots = dict(zip(shown, drawn, strict=True))
    moved = dict(zip(shown, moving, strict=True))
    return Staging(asked, roots, fixed, moved, float(low[1]), center, scale, environment, ground)


def unit_size(scene: Scene) -> tuple[FloatArray, float]:
    """The centre (3,) and the scale that bring the box of all frames to the half diagonal 1; raises SceneError."""
    low, high = box_of(scene)
    half = 0.5 * float(np.linalg.norm(high - low))
    return (low + high) / 2.0, 1.0 / half if half > 1e-300 else 1.0


def _solids(root: Entity, limit: int, center: FloatArray, scale: float) -> Solids:
    check_size(root, limit)
    return normalized(solids_of(flatten_entity(root)), center, scale)


def check_size(root: Entity, limit: int) -> None:
    """Raises LimitError where ``root`` expands to more than ``limit`` primitives."""
    count = primitive_count(root)
    if count > limit:
        raise LimitError(
            "primitives",
            f"the scene expands to {count:,} primitives, more than the {limit:,} that one picture may have",
            hint="raise the limit, or draw a part of the scene",
        )
