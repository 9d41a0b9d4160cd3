"""Ground truth per pixel: primitive, instances up the hierarchy, depth, normal, albedo and position.

Rays pass through pixel centers. Transparent surfaces count as visible; surfaces with ``:opacity 0`` do not. The ground
is not part of the scene.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from scenelang.backends.facts.frame import FrameFacts
from scenelang.backends.pictures.camera import Camera
from scenelang.backends.pictures.rays import NEAR, camera_rays, caster_for, ids_of
from scenelang.backends.pictures.stage import Shot, check_size
from scenelang.backends.surfaces.solids import Solids, normalized, solids_of
from scenelang.interpreter.inspection.numbering import Ancestry, ancestry_of
from scenelang.interpreter.scene.bounds import entity_box
from scenelang.interpreter.scene.entity import Scene
from scenelang.interpreter.scene.flatten import FlatFrame, flatten_entity
from scenelang.interpreter.scene.primitives.forms import CanonicalForm, Ratios, nearest_hit
from scenelang.interpreter.scene.primitives.mesh import inverses_of

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]

NOTHING = -1  # instance number of the background


@dataclass(frozen=True, slots=True, eq=False)
class Truth:
    """Ground truth of the pixels (H, W) of one shot.

    ``instance`` is the index in ``ancestry`` of the visible primitive, NOTHING on the background; ``depth`` the
    distance along the optical axis in scene units, infinity on the background; ``normal`` the unit normal in world
    coordinates, facing the camera; ``albedo`` linear sRGB; ``position`` in world coordinates. All (H, W) or (H, W, 3).
    ``solids.part_words[part]`` is the word of the operand of a computed solid that is seen, NOTHING for other pixels.

    ``solids`` are those of the frame, in world coordinates.
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
    part: IntArray

    @property
    def seen(self) -> npt.NDArray[np.bool_]:
        """Mask (H, W) of pixels that show the scene."""
        return np.asarray(self.instance >= 0)

    def at_depth(self, depth: int) -> IntArray:
        """Return the instance (H, W) at ``depth`` of the hierarchy that contains each pixel's primitive, or NOTHING."""
        return self.of_instances(self.ancestry.at_depth(depth))

    def of_instances(self, values: IntArray) -> IntArray:
        """Return the value (H, W) of each pixel's primitive, given those of the instances (M,), or NOTHING."""
        if not len(values):  # a frame without instances
            return np.full(self.instance.shape, NOTHING, np.int64)
        return np.where(self.seen, values[np.maximum(self.instance, 0)], NOTHING)


def truth_of(scene: Scene, shot: Shot, limit: int, center: FloatArray, scale: float) -> Truth:
    """Return the ground truth of one shot.

    ``center`` (3,) and ``scale`` bring the scene to unit size, for numerical precision. Raises SceneError, and
    LimitError if the frame expands to more than ``limit`` primitives.
    """
    return truth_in(expanded(scene, shot.frame, limit, center, scale), shot)


@dataclass(frozen=True, slots=True, eq=False)
class Expanded:
    """A frame as all cameras see it: flattened, with its instances, and its solids in the world and at unit size.

    ``center`` (3,) and ``scale`` bring it to unit size.
    """

    flat: FlatFrame
    ancestry: Ancestry
    world: Solids
    solids: Solids
    center: FloatArray
    scale: float


def expanded(scene: Scene, frame: int, limit: int, center: FloatArray, scale: float) -> Expanded:
    """Expand a frame; raises LimitError if it has more than ``limit`` primitives."""
    root = scene.frames[frame]
    check_size(root, limit)
    flat, ancestry = flatten_entity(root), ancestry_of(root)
    world = solids_of(flat)
    return Expanded(flat, ancestry, world, normalized(world, center, scale), center, scale)


def truth_in(frame: Expanded, shot: Shot) -> Truth:
    """Return the ground truth of one shot of an expanded frame."""
    solids, ancestry, center, scale = frame.solids, frame.ancestry, frame.center, frame.scale
    camera = shot.camera.rescaled(center, scale)
    rays = camera_rays(camera)
    caster = caster_for(solids, rays)
    ids = ids_of(caster.cast())
    hit = np.flatnonzero(ids.reshape(-1) >= 0)
    row, column = np.divmod(hit, camera.width)
    origin, direction = rays.at(column + 0.5, row + 0.5)
    number = ids.reshape(-1)[hit]
    depth = np.full(ids.size, np.inf)
    depth[hit] = _exact_depths(solids, number, origin, direction)
    position, normal, albedo = (np.zeros((ids.size, 3)) for _ in range(3))
    position[hit] = origin + direction * depth[hit, None]
    normal[hit] = caster.surface(number, position[hit], direction)
    albedo[hit] = solids.colors[number]
    instance = np.full(ids.size, NOTHING, np.int64)
    instance[hit] = ancestry.primitives[solids.instance[number]]
    part = np.full(ids.size, NOTHING, np.int64)
    part[hit] = solids.part[number]
    position[hit] = position[hit] / scale + center
    shape = ids.shape
    return Truth(
        shot.camera,
        frame.flat,
        ancestry,
        frame.world,
        instance.reshape(shape),
        (depth / scale).reshape(shape),
        normal.reshape(*shape, 3),
        albedo.reshape(*shape, 3),
        position.reshape(*shape, 3),
        part.reshape(shape),
    )


def _exact_depths(solids: Solids, number: IntArray, origin: FloatArray, direction: FloatArray) -> FloatArray:
    """Return the ray parameters (N,) of the hits on the solids ``number`` (N,), in double precision."""
    solid_numbers, slot = np.unique(number, return_inverse=True)
    inverse = inverses_of(solids.matrices[solid_numbers, :, :3])[slot]
    local_origin = np.einsum("nij,nj->ni", inverse, origin - solids.matrices[number, :, 3])
    local_direction = np.einsum("nij,nj->ni", inverse, direction)
    depths = np.zeros(len(number))
    hit = solids.take(number)
    for form, rows in hit.groups():
        start, d = local_origin[rows].T, local_direction[rows].T
        with np.errstate(all="ignore"):
            ratios = hit.ratios_of(form, rows)
            depths[rows] = nearest_hit(form, (start[0], start[1], start[2]), (d[0], d[1], d[2]), ratios, NEAR)
    return depths


# --- correspondence of repeated instances ----------------------------------------------------------------------


@dataclass(frozen=True, slots=True, eq=False)
class Correspondence:
    """Dense correspondence between repeated instances.

    ``unit`` (H, W) is the repeated instance at each pixel, NOTHING elsewhere; ``place`` (H, W, 3) the normalized
    position in the instance's box, from 0 to 1 along its axes. Pixels of instances of one word with equal places
    correspond.
    """

    unit: IntArray
    place: npt.NDArray[np.float32]


def correspondence_of(truth: Truth) -> Correspondence:
    """Return the correspondence between repeated instances.

    These are the topmost instances in the hierarchy, below the root, whose word occurs more than once. Instances of one
    word correspond at equal positions in their boxes, whatever their embeddings.
    """
    ancestry = truth.ancestry
    instances = np.bincount(ancestry.node[1:], minlength=len(ancestry.nodes))
    words: Counter[str] = Counter()
    for entity, count in zip(ancestry.nodes, instances.tolist(), strict=True):
        words[entity.word] += count
    repeated = np.array([words[entity.word] > 1 for entity in ancestry.nodes], bool)
    unit_of = np.full(len(ancestry), NOTHING, np.int64)
    for depth in range(1, ancestry.max_depth + 1):
        rows = np.flatnonzero(ancestry.depth == depth)
        above = unit_of[ancestry.parent[rows]]
        unit_at_depth = np.where(repeated[ancestry.node[rows]], rows, NOTHING)
        unit_of[rows] = np.where(above >= 0, above, unit_at_depth)
    unit = truth.of_instances(unit_of)
    place = np.zeros((*unit.shape, 3), np.float32)
    pixels = np.flatnonzero(unit.reshape(-1) >= 0)
    numbers, inverse = np.unique(unit.reshape(-1)[pixels], return_inverse=True)
    low, high = boxes_of(ancestry, numbers)
    local = into_local(truth.position.reshape(-1, 3)[pixels], ancestry.poses[numbers], inverse)
    size = np.where(high > low, high - low, 1.0)
    place.reshape(-1, 3)[pixels] = np.clip((local - low[inverse]) / size[inverse], 0.0, 1.0)
    return Correspondence(unit, place)


def boxes_of(ancestry: Ancestry, instances: IntArray) -> tuple[FloatArray, FloatArray]:
    """Return the boxes of instances in their entities' frames: low and high corners (K, 3)."""
    boxes_or_zero = [entity_box(ancestry.entity(int(i))) or (0.0,) * 6 for i in instances]
    boxes = np.array(boxes_or_zero, np.float64).reshape(-1, 6)
    return boxes[:, :3], boxes[:, 3:]


def bodies_of_instances(ancestry: Ancestry) -> IntArray:
    """Return the number of the body (M,) that each instance is, or is a part of; -1 for several bodies or none.

    Bodies are those of the checks and simulations: what a person would lift as one.
    """
    bodies = np.full(len(ancestry.node), NOTHING)
    if not len(ancestry):  # a frame without instances
        return bodies
    facts = FrameFacts(ancestry.entity(0), ancestry=ancestry)
    if len(facts.solids):
        body = facts.bodies.body
        first, last = ancestry.ranges(ancestry.primitives[facts.solids.row])
        changes = np.concatenate([[0], np.cumsum(np.diff(body) != 0)])
        filled = np.flatnonzero(last >= first)
        whole = filled[changes[last[filled]] == changes[first[filled]]]
        bodies[whole] = body[first[whole]]
    return bodies


def into_local(points: FloatArray, poses: FloatArray, which: IntArray) -> FloatArray:
    """Transform world ``points`` (N, 3) into the frames ``poses[which]`` (K, 3, 4), by pseudoinverse for flat poses."""
    inverse = np.linalg.pinv(poses[:, :, :3]) if len(poses) else np.zeros((0, 3, 3))
    return np.asarray(np.einsum("nij,nj->ni", inverse[which], points - poses[which, :, 3]), np.float64)


# Bounding boxes of instances: of the visible part and of the whole, in the image and in the world.


_MIN_DEPTH = 1e-9  # in scenes of unit size: points closer to the camera plane do not project
_MAX_DINKELBACH_STEPS = 40  # cap of Dinkelbach's iteration, which converges superlinearly in a few steps


@dataclass(frozen=True, slots=True, eq=False)
class Boxes:
    """Bounding boxes of all instances (M,), in pixels.

    ``visible`` (M, 4) is x0, y0, x1, y1 (ends excluded) of the visible part, ``area`` (M,) its number of pixels.
    ``full`` (M, 4) is the exact rectangle of the whole projection, which may extend beyond the image; nan if a part
    is behind the camera.
    """

    visible: IntArray
    area: IntArray
    full: FloatArray


def boxes_in(truth: Truth) -> Boxes:
    """Return the bounding boxes of every instance of a shot."""
    ancestry = truth.ancestry
    count = len(ancestry)
    rows, columns = np.nonzero(truth.seen)
    instance = truth.instance[rows, columns]
    visible = np.tile(np.array([truth.camera.width, truth.camera.height, 0, 0]), (count, 1))
    area = np.bincount(instance, minlength=count)
    for start, values in ((0, columns), (1, rows)):
        np.minimum.at(visible[:, start], instance, values)
        np.maximum.at(visible[:, start + 2], instance, values + 1)
    full = np.tile(np.array([np.inf, np.inf, -np.inf, -np.inf]), (count, 1))
    solids = truth.solids
    rectangles = rectangles_of(solids, truth.camera)
    number = ancestry.primitives[solids.instance]
    np.minimum.at(full, number, np.where([True, True, False, False], rectangles, np.inf))
    np.maximum.at(full, number, np.where([False, False, True, True], rectangles, -np.inf))
    _accumulate(ancestry, visible, area, full)
    full[~np.isfinite(full).all(axis=1)] = np.nan
    return Boxes(visible, area, full)


def _accumulate(ancestry: Ancestry, visible: IntArray, area: IntArray, full: FloatArray) -> None:
    """Accumulate the boxes and areas of instances into their parents, from the deepest level up."""
    for depth in range(ancestry.max_depth, 0, -1):
        rows = np.flatnonzero(ancestry.depth == depth)
        parent = ancestry.parent[rows]
        np.add.at(area, parent, area[rows])
        for boxes in (visible, full):
            np.minimum.at(boxes[:, :2], parent, boxes[rows, :2])
            np.maximum.at(boxes[:, 2:], parent, boxes[rows, 2:])


def rectangles_of(solids: Solids, camera: Camera) -> FloatArray:
    """Return the exact rectangles (N, 4) x0, y0, x1, y1 of the projections of solids, in pixels.

    nan if a solid is partly behind the camera. Ellipsoids and disks are computed from their dual quadrics, points
    directly, other forms from their support functions.
    """
    rotation, move = camera.world_to_camera[:3, :3], camera.world_to_camera[:3, 3]
    linear = rotation @ solids.matrices[:, :, :3]
    center = solids.matrices[:, :, 3] @ rotation.T + move
    out = np.full((len(solids), 4), np.nan)
    for form, rows in solids.groups():
        outline = form.outline()
        if outline is None:
            out[rows] = _of_reach(form, linear[rows], center[rows], solids.ratios_of(form, rows), camera)
        else:
            out[rows] = _of_outline(outline, linear[rows], center[rows], camera)
    return out


def _of_outline(outline: Sequence[FloatArray], linear: FloatArray, center: FloatArray, camera: Camera) -> FloatArray:
    """Return the rectangles of the union of posed points, disks and ellipsoids."""
    points = [piece[:, 0] for piece in outline if piece.shape[1] == 1]
    rectangles = []
    if points:
        rectangles.append(_of_points(np.einsum("nij,kj->nki", linear, np.array(points)) + center[:, None], camera))
    for piece in outline:
        if piece.shape[1] > 1:
            frames = linear @ piece
            frames[:, :, -1] += center
            rectangles.append(_of_quadrics(frames, camera))
    bounds = rectangles[0]
    for rectangle in rectangles[1:]:
        bounds = _union(bounds, rectangle)
    return bounds


def _of_reach(
    form: CanonicalForm, linear: FloatArray, center: FloatArray, ratios: Ratios, camera: Camera
) -> FloatArray:
    """Return the rectangles of a form given by its support function.

    The maximum of x / z over a body is the limit of the increasing ratios at the support points along (1, 0, -x / z).
    Source: Dinkelbach, "On nonlinear fractional programming", Management Science 13 (1967).
    """

    def farthest(direction: FloatArray) -> FloatArray:
        """Return the points (N, 3) of the bodies that are farthest along the directions (N, 3)."""
        local = np.einsum("nij,ni->nj", linear, direction)
        return np.asarray(np.einsum("nij,nj->ni", linear, form.support(local, ratios)) + center, np.float64)

    out = np.empty((len(linear), 4))
    for axis in range(2):
        for side, column in ((-1.0, axis), (1.0, axis + 2)):
            direction = np.zeros((len(linear), 3))
            direction[:, axis] = side
            edge = farthest(direction)[:, axis]
            if not camera.is_parallel:
                edge = center[:, axis] / np.maximum(center[:, 2], _MIN_DEPTH)
                for _ in range(_MAX_DINKELBACH_STEPS):
                    direction[:, 2] = -side * edge
                    point = farthest(direction)
                    before, edge = edge, point[:, axis] / np.maximum(point[:, 2], _MIN_DEPTH)
                    if (np.abs(edge - before) <= 1e-13 * (1.0 + np.abs(edge))).all():
                        break
            out[:, column] = edge * camera.focal[axis] + camera.principal[axis]
    if not camera.is_parallel:
        nearest = farthest(np.tile([0.0, 0.0, -1.0], (len(linear), 1)))[:, 2]
        out[nearest <= _MIN_DEPTH] = np.nan
    return out


def _union(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return the smallest rectangles (N, 4) around pairs of rectangles."""
    return np.concatenate([np.minimum(a[:, :2], b[:, :2]), np.maximum(a[:, 2:], b[:, 2:])], axis=1)


def _of_points(points: FloatArray, camera: Camera) -> FloatArray:
    """Return the rectangles of point sets (N, K, 3) in camera coordinates."""
    depth = points[:, :, 2]
    safe = np.ones_like(depth) if camera.is_parallel else np.where(depth > _MIN_DEPTH, depth, np.nan)
    flat = points[:, :, :2] / safe[:, :, None] * np.array(camera.focal) + np.array(camera.principal)
    return np.concatenate([flat.min(axis=1), flat.max(axis=1)], axis=1)


def _of_quadrics(frames: FloatArray, camera: Camera) -> FloatArray:
    """Return the rectangles of ellipsoids or ellipses; ``frames`` (N, 3, K) are K - 1 half axes and the center.

    Their dual quadric is ``F diag(1, .., 1, -1) F'``; a line l of the image is tangent to the projected conic C* if
    l' C* l = 0. Source: Hartley and Zisserman, *Multiple View Geometry*, section 8.3.
    """
    signs = np.ones(frames.shape[2])
    signs[-1] = -1.0
    projected = frames.copy()
    if camera.is_parallel:  # the third coordinate of an image point is 1 at any depth
        projected[:, 2], projected[:, 2, -1] = 0.0, 1.0
    dual = np.einsum("nik,k,njk->nij", projected, signs, projected)
    nearest = frames[:, 2, -1] - np.sqrt((frames[:, 2, :-1] ** 2).sum(axis=1))
    before = np.ones(len(frames), bool) if camera.is_parallel else nearest > _MIN_DEPTH
    out = np.full((len(frames), 4), np.nan)
    with np.errstate(all="ignore"):
        for axis in range(2):
            middle = dual[:, axis, 2]
            root = np.sqrt(np.maximum(middle**2 - dual[:, axis, axis] * dual[:, 2, 2], 0.0))
            ends = np.stack([(middle - root) / dual[:, 2, 2], (middle + root) / dual[:, 2, 2]])
            pixels = ends * camera.focal[axis] + camera.principal[axis]
            out[:, axis], out[:, axis + 2] = pixels.min(axis=0), pixels.max(axis=0)
    out[~before] = np.nan
    return out


# 4D: where the point seen by each pixel is in other frames, and the trajectories of tracked points. Entities of two
# frames correspond if they have the same path: the child positions from the root, and the words there, as in exported
# animations. A point moves with its entity: its position in the entity's frame is constant.


GONE, HIDDEN, VISIBLE = 0, 1, 2  # state of a point in another frame: does not exist, occluded or out of view, visible
# relative; a pixel's depth is that of its center, so points next to it differ by the surface's slope
_DEPTH_TOLERANCE = 2e-3


class PathNumbers:
    """Assigns numbers to paths of child positions and words, consistently across the frames of a video."""

    def __init__(self) -> None:
        self._numbers: dict[tuple[int, int, str], int] = {}

    def of(self, ancestry: Ancestry) -> IntArray:
        """Return the path number (M,) of every instance; the root's is 0."""
        out = np.zeros(len(ancestry), np.int64)
        for depth in range(1, ancestry.max_depth + 1):
            rows = np.flatnonzero(ancestry.depth == depth)
            above, position = out[ancestry.parent[rows]].tolist(), ancestry.position[rows].tolist()
            words = [ancestry.nodes[node].word for node in ancestry.node[rows].tolist()]
            table = self._numbers
            out[rows] = [table.setdefault(key, len(table) + 1) for key in zip(above, position, words, strict=True)]
        return out


@dataclass(frozen=True, slots=True, eq=False)
class Places:
    """Attachment of N points: path numbers (N,) and positions in the primitives' frames (N, 3)."""

    path: IntArray
    local: FloatArray


def places_of(truth: Truth, paths: IntArray, pixels: IntArray) -> Places:
    """Return the attachments of the points that the flat ``pixels`` (N,) show; no pixel may be background.

    ``paths`` are the path numbers of the instances.
    """
    instance = truth.instance.reshape(-1)[pixels]
    used, inverse = np.unique(instance, return_inverse=True)
    local = into_local(truth.position.reshape(-1, 3)[pixels], truth.ancestry.poses[used], inverse)
    return Places(paths[instance], local)


@dataclass(frozen=True, slots=True, eq=False)
class MotionMatch:
    """Positions of N points in a frame.

    ``pixels`` (N, 2) from the top left corner and ``world`` (N, 3) are nan for points that do not exist; ``state`` (N,)
    is GONE, HIDDEN or VISIBLE.
    """

    pixels: FloatArray
    world: FloatArray
    state: npt.NDArray[np.uint8]


def locate(places: Places, truth: Truth, paths: IntArray) -> MotionMatch:
    """Locate ``places`` in the frame of ``truth``, whose instances have the path numbers ``paths`` (M,)."""
    leaves = truth.ancestry.primitives
    order = np.argsort(paths[leaves], kind="stable")
    sorted_paths = paths[leaves][order]
    positions = np.searchsorted(sorted_paths, places.path)
    positions = np.minimum(positions, max(0, len(sorted_paths) - 1))
    exists = sorted_paths[positions] == places.path if len(sorted_paths) else np.zeros(len(places.path), bool)
    world = np.full((len(places.path), 3), np.nan)
    existing = np.flatnonzero(exists)
    poses = truth.ancestry.poses[leaves[order[positions[existing]]]]
    world[existing] = np.einsum("nij,nj->ni", poses[:, :, :3], places.local[existing]) + poses[:, :, 3]
    pixels, depth = truth.camera.project(np.nan_to_num(world))
    pixels[~exists] = np.nan
    state = np.where(exists, HIDDEN, GONE).astype(np.uint8)
    column, row = np.floor(np.nan_to_num(pixels, nan=-1.0)).astype(np.int64).T
    inside = exists & (column >= 0) & (row >= 0) & (column < truth.camera.width) & (row < truth.camera.height)
    inside &= depth > 0.0
    rows = np.flatnonzero(inside)
    # A pixel's depth is that of its center: on slopes, compare with the farthest of its neighbors.
    farthest = _farthest_around(truth.depth)[row[rows], column[rows]]
    state[rows[depth[rows] <= farthest * (1.0 + _DEPTH_TOLERANCE)]] = VISIBLE
    return MotionMatch(pixels, world, state)


def _farthest_around(depth: FloatArray) -> FloatArray:
    """Return the largest finite depth (H, W) among each pixel and its four neighbors."""
    finite = np.where(np.isfinite(depth), depth, -np.inf)
    padded = np.pad(finite, 1, constant_values=-np.inf)
    around = [padded[1:-1, 1:-1], padded[:-2, 1:-1], padded[2:, 1:-1], padded[1:-1, :-2], padded[1:-1, 2:]]
    return np.asarray(np.max(around, axis=0), np.float64)


@dataclass(frozen=True, slots=True, eq=False)
class Flow:
    """Dense motion (H, W) from a frame to the next.

    ``motion`` (H, W, 2) is in pixels, ``world`` (H, W, 3) in the world; nan for points that do not exist in the next
    frame. ``state`` (H, W) is GONE, HIDDEN or VISIBLE.
    """

    motion: npt.NDArray[np.float32]
    world: npt.NDArray[np.float32]
    state: npt.NDArray[np.uint8]


def flow_between(truth: Truth, following: Truth, paths: IntArray, following_paths: IntArray) -> Flow:
    """Return the dense motion from one frame to another; ``paths`` are the path numbers of their instances."""
    height, width = truth.instance.shape
    pixels = np.flatnonzero(truth.seen)
    match = locate(places_of(truth, paths, pixels), following, following_paths)
    row, column = np.divmod(pixels, width)
    motion, world = np.full((height * width, 2), np.nan, np.float32), np.full((height * width, 3), np.nan, np.float32)
    state = np.full(height * width, GONE, np.uint8)
    motion[pixels] = match.pixels - np.stack([column + 0.5, row + 0.5], axis=1)
    world[pixels] = match.world - truth.position.reshape(-1, 3)[pixels]
    state[pixels] = match.state
    return Flow(motion.reshape(height, width, 2), world.reshape(height, width, 3), state.reshape(height, width))


@dataclass(frozen=True, slots=True, eq=False)
class Tracks:
    """Trajectories of N points through F frames: ``pixels`` (F, N, 2), ``world`` (F, N, 3), ``state`` (F, N)."""

    pixels: FloatArray
    world: FloatArray
    state: npt.NDArray[np.uint8]


def sample_places(truth: Truth, paths: IntArray, count: int, seed: int) -> Places:
    """Sample ``count`` points visible in a frame uniformly, reproducibly for a given ``seed``."""
    pixels = np.flatnonzero(truth.seen)
    random = np.random.default_rng(seed)
    chosen = random.choice(pixels, size=min(count, len(pixels)), replace=False) if len(pixels) else pixels
    return places_of(truth, paths, np.sort(chosen))


def tracks_of(matches: Sequence[MotionMatch]) -> Tracks:
    """Return the trajectories of points located in successive frames."""
    return Tracks(
        np.stack([match.pixels for match in matches]),
        np.stack([match.world for match in matches]),
        np.stack([match.state for match in matches]),
    )
