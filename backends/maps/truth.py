"""What every pixel of a picture shows: primitive, instances up the hierarchy, depth, normal, albedo and place.

Rays go through pixel centres. What is see-through counts as seen; what is invisible (``:opacity 0``) does not. The
ground is no part of the scene.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from scenelang.backends.camera import Camera
from scenelang.backends.rays.cast import NEAR, camera_rays, caster_for, ids_of
from scenelang.backends.rays.intersect import first_hit
from scenelang.backends.shots import Shot
from scenelang.backends.solids import Form, Solids, inverses_of, normalized, solids_of
from scenelang.backends.stage import check_size
from scenelang.interpreter.ancestry import Ancestry, ancestry_of
from scenelang.interpreter.bounds import entity_box
from scenelang.interpreter.entity import Scene
from scenelang.interpreter.flatten import FlatFrame, flatten_entity

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]

NOTHING = -1


@dataclass(frozen=True, slots=True, eq=False)
class Truth:
    """What the pixels (H, W) of one shot show.

    ``instance`` is the number in ``ancestry`` of the primitive that is seen, NOTHING where none is; ``depth`` the
    distance along the axis of view in scene units, infinity where nothing is; ``normal`` the unit normal in the world,
    turned to the camera; ``albedo`` linear sRGB; ``position`` in the world. All (H, W) or (H, W, 3).

    ``solids`` are those of the frame, in the world's frame.
    """

    camera: Camera
    frame: FlatFrame
    ancestry: Ancestry
    solids: Solids
    instance: IntArray
    depth: FloatArray
    normal: FloatArray
    albedo: FloatArray
    position: FloatArray

    @property
    def seen(self) -> npt.NDArray[np.bool_]:
        """Whether anything is seen (H, W)."""
        return np.asarray(self.instance >= 0)

    def at_depth(self, depth: int) -> IntArray:
        """The instance (H, W) at ``depth`` of the hierarchy that each pixel's primitive is part of, or NOTHING."""
        up = self.ancestry.at_depth(depth)
        return np.where(self.seen, up[np.maximum(self.instance, 0)], NOTHING)


def truth_of(scene: Scene, shot: Shot, limit: int, center: FloatArray, scale: float) -> Truth:
    """The truth of one shot. ``center`` (3,) and ``scale`` bring the scene to unit size, for precise arithmetic.

    Raises SceneError, and LimitError when the frame expands to more than ``limit`` primitives.
    """
    root = scene.frames[shot.frame]
    check_size(root, limit)
    frame, ancestry = flatten_entity(root), ancestry_of(root)
    world = solids_of(frame)
    solids = normalized(world, center, scale)
    camera = shot.camera.rescaled(center, scale)
    rays = camera_rays(camera)
    caster = caster_for(solids, rays)
    ids = ids_of(caster.cast())
    row, column = np.divmod(np.arange(ids.size), camera.width)
    origin, direction = rays.at(column + 0.5, row + 0.5)
    hit = np.flatnonzero(ids.reshape(-1) >= 0)
    number = ids.reshape(-1)[hit]
    depth = np.full(ids.size, np.inf)
    depth[hit] = _exact_depths(solids, number, origin[hit], direction[hit])
    position, normal, albedo = (np.zeros((ids.size, 3)) for _ in range(3))
    position[hit] = origin[hit] + direction[hit] * depth[hit, None]
    normal[hit] = caster.surface(number, position[hit], direction[hit])
    albedo[hit] = solids.colors[number]
    instance = np.full(ids.size, NOTHING, np.int64)
    instance[hit] = ancestry.primitives[solids.instance[number]]
    position[hit] = position[hit] / scale + center
    shape = ids.shape
    return Truth(
        shot.camera,
        frame,
        ancestry,
        world,
        instance.reshape(shape),
        (depth / scale).reshape(shape),
        normal.reshape(*shape, 3),
        albedo.reshape(*shape, 3),
        position.reshape(*shape, 3),
    )


def _exact_depths(solids: Solids, number: IntArray, origin: FloatArray, direction: FloatArray) -> FloatArray:
    """The ray parameters (N,) at which rays hit the solids ``number`` (N,), in full precision."""
    used, place = np.unique(number, return_inverse=True)
    inverse = inverses_of(solids.matrices[used, :, :3])[place]
    local_origin = np.einsum("nij,nj->ni", inverse, origin - solids.matrices[number, :, 3])
    local_direction = np.einsum("nij,nj->ni", inverse, direction)
    out = np.zeros(len(number))
    forms = solids.forms[number]
    for form in Form:
        rows = np.flatnonzero(forms == form)
        if len(rows):
            o, d = local_origin[rows].T, local_direction[rows].T
            with np.errstate(all="ignore"):
                out[rows] = first_hit(int(form), (o[0], o[1], o[2]), (d[0], d[1], d[2]), NEAR)
    return out


# --- correspondence of repeated instances ----------------------------------------------------------------------


@dataclass(frozen=True, slots=True, eq=False)
class Correspondence:
    """``unit`` (H, W) is the repeated instance that each pixel shows, NOTHING elsewhere, ``place`` (H, W, 3) where in
    its own box, from 0 to 1 along its own axes. Pixels of instances of one word with equal places correspond."""

    unit: IntArray
    place: npt.NDArray[np.float32]


def correspondence_of(truth: Truth) -> Correspondence:
    """What corresponds between repeated instances: those, as high in the hierarchy as possible, whose word stands
    more than once below the root."""
    ancestry = truth.ancestry
    instances = np.bincount(ancestry.node[1:], minlength=len(ancestry.nodes))
    words: Counter[str] = Counter()
    for entity, count in zip(ancestry.nodes, instances.tolist(), strict=True):
        words[entity.word] += count
    repeated = np.array([words[entity.word] > 1 for entity in ancestry.nodes], bool)
    unit_of = np.full(len(ancestry), NOTHING, np.int64)
    for depth in range(1, ancestry.deepest + 1):
        rows = np.flatnonzero(ancestry.depth == depth)
        above = unit_of[ancestry.parent[rows]]
        own = np.where(repeated[ancestry.node[rows]], rows, NOTHING)
        unit_of[rows] = np.where(above >= 0, above, own)
    unit = np.where(truth.seen, unit_of[np.maximum(truth.instance, 0)], NOTHING)
    place = np.zeros((*unit.shape, 3), np.float32)
    at = np.flatnonzero(unit.reshape(-1) >= 0)
    numbers, inverse = np.unique(unit.reshape(-1)[at], return_inverse=True)
    low, high = boxes_of(ancestry, numbers)
    local = into_local(truth.position.reshape(-1, 3)[at], ancestry.poses[numbers], inverse)
    size = np.where(high > low, high - low, 1.0)
    place.reshape(-1, 3)[at] = np.clip((local - low[inverse]) / size[inverse], 0.0, 1.0)
    return Correspondence(unit, place)


def boxes_of(ancestry: Ancestry, instances: IntArray) -> tuple[FloatArray, FloatArray]:
    """The boxes, low and high (K, 3), of instances in their entities' own frames."""
    found = [entity_box(ancestry.entity(int(i))) or (0.0,) * 6 for i in instances]
    boxes = np.array(found, np.float64).reshape(-1, 6)
    return boxes[:, :3], boxes[:, 3:]


def into_local(points: FloatArray, poses: FloatArray, which: IntArray) -> FloatArray:
    """World ``points`` (N, 3) in the frames ``poses[which]`` (K, 3, 4); flat poses count as thick as need be."""
    inverse = np.linalg.pinv(poses[:, :, :3]) if len(poses) else np.zeros((0, 3, 3))
    return np.asarray(np.einsum("nij,nj->ni", inverse[which], points - poses[which, :, 3]), np.float64)
