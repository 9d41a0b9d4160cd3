"""Initial Gaussians of primitives: flat ones that cover their surfaces, and some inside; lighting of Gaussians.

The Gaussians of a primitive entity are computed once, in its own frame, and transformed for each instance.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from scenelang.backends.neural.splats.gaussians import Gaussians, Splats, apply_pose, concatenate_splats
from scenelang.backends.pictures.draft_light import (
    GROUND,
    SKY,
    Reach,
    Shadow,
    Surface,
    albedo_of,
    ground_depths,
    key_reach,
    radiance_of,
    shadow_map,
)
from scenelang.backends.pictures.rays import camera_rays
from scenelang.backends.pictures.stage import Stage
from scenelang.backends.surfaces.appearance import Look, look_of
from scenelang.backends.surfaces.solids import keeps_own_colors, own_mesh
from scenelang.grammar.diagnostics import LimitError
from scenelang.interpreter.scene.entity import Entity, primitive_count
from scenelang.interpreter.scene.flatten import flatten_entity
from scenelang.interpreter.scene.primitives import Placed
from scenelang.interpreter.scene.primitives.forms import CanonicalForm
from scenelang.interpreter.scene.primitives.mesh import Mesh, cofactors_of, triangle_normals

if TYPE_CHECKING:
    from torch import Tensor


# Deterministic low-discrepancy samples on the surfaces of primitives.
#
# A surface consists of charts (``primitives.forms``), each an area-preserving map from the unit square. On each chart
# the points form a Fibonacci lattice, which has no visible rows and no clumps.


FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]
Float32Array = npt.NDArray[np.float32]

_GOLDEN = (math.sqrt(5.0) - 1.0) / 2.0
_PLASTIC = 1.324717957244746  # plastic ratio, the analogue of the golden ratio in 2D (the R2 sequence, Roberts 2018)


@dataclass(frozen=True, slots=True, eq=False)
class SurfaceSamples:
    """K points on a surface: ``points`` and unit ``normals`` (K, 3), and the ``area`` of the whole surface."""

    points: FloatArray
    normals: FloatArray
    area: float


def sample_solid(
    form: CanonicalForm, half: Sequence[float], count: int, seed: int = 0, ratios: tuple[float, ...] = ()
) -> SurfaceSamples:
    """Sample ``count`` points on the canonical ``form``, scaled by the three ``half`` sizes.

    Round forms require equal first and last sizes. ``seed`` shifts the lattice.
    """
    charts = [chart for chart in form.charts(half, ratios) if chart.area > 0.0]
    area = sum(chart.area for chart in charts)
    if not charts:
        return SurfaceSamples(np.zeros((0, 3)), np.zeros((0, 3)), 0.0)
    counts = _apportion([chart.area for chart in charts], count)
    # a different shift per chart, so that points on both sides of a flat form do not coincide
    samples = [
        chart.place(*_fibonacci_lattice(n, seed + i)) for i, (chart, n) in enumerate(zip(charts, counts, strict=True))
    ]
    return SurfaceSamples(np.concatenate([p for p, _ in samples]), np.concatenate([n for _, n in samples]), area)


def sample_triangles(corners: FloatArray, count: int, seed: int = 0) -> tuple[SurfaceSamples, IntArray]:
    """Sample ``count`` points on triangles (F, 3, 3); also returns the triangle (K,) of each point.

    The result is empty if the triangles have no area.
    """
    areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2.0
    cumulative = np.cumsum(areas)
    if not len(areas) or not 0.0 < cumulative[-1] < math.inf:
        return SurfaceSamples(np.zeros((0, 3)), np.zeros((0, 3)), 0.0), np.zeros(0, np.int64)
    i = np.arange(count)
    triangle = np.searchsorted(cumulative, (i + 0.5) / count * cumulative[-1], side="right").clip(max=len(areas) - 1)
    u, v = np.modf(i / _PLASTIC + seed * _GOLDEN)[0], np.modf(i / _PLASTIC**2 + seed * _GOLDEN)[0]
    outside = u + v > 1.0  # mirror the half of the unit square outside the triangle
    u, v = np.where(outside, 1.0 - u, u)[:, None], np.where(outside, 1.0 - v, v)[:, None]
    a, b, c = (corners[triangle, k] for k in range(3))
    points = a + u * (b - a) + v * (c - a)
    return SurfaceSamples(points, triangle_normals(corners)[triangle], float(cumulative[-1])), triangle


def _fibonacci_lattice(count: int, seed: int) -> tuple[FloatArray, FloatArray]:
    """Return the coordinates u, v of ``count`` points in the unit square."""
    i = np.arange(count)
    return (i + 0.5) / max(count, 1), np.modf(i * _GOLDEN + seed * math.sqrt(2.0))[0]


def _apportion(areas: Sequence[float], count: int) -> list[int]:
    """Divide ``count`` in proportion to ``areas``, by the largest remainder method."""
    exact = np.array(areas) / sum(areas) * count
    parts = np.floor(exact).astype(np.int64)
    parts[np.argsort(parts - exact, kind="stable")[: count - int(parts.sum())]] += 1
    return [int(part) for part in parts]


MAX_GAUSSIANS = 5_000_000  # of a scene
MIN_GAUSSIANS = 16  # of a primitive; fewer do not cover its surface
_INTERIOR_FRACTION = 0.1  # of the Gaussians, on copies of the surface scaled by these factors
_MIN_INTERIOR_SCALE, _MAX_INTERIOR_SCALE = 0.3, 0.8
_WIDTH, _THICKNESS = 0.6, 0.08  # standard deviations along and across the surface, in distances between neighbors
_OVERLAP = 2.0 * np.pi * _WIDTH**2  # mean number of Gaussians at each point: density times the integral of a Gaussian
_MAX_OPACITY = 0.98
_MIN_RELATIVE_SCALE = 1e-9  # of standard deviations, relative to the largest, since logarithms must be finite


@dataclass(frozen=True, slots=True, eq=False)
class Cover:
    """Gaussians of one primitive in its own frame, in float64, with unit ``normals`` (K, 3) and covered ``area``."""

    gaussians: Gaussians
    normals: FloatArray
    area: float


@dataclass(frozen=True, slots=True, eq=False)
class SceneSplats:
    """N Gaussians of a scene in world space, in float64.

    Attributes
    ----------
    splats
        Gaussians, with reflectance as colors.
    emission
        (N, 3), emitted radiance.
    normals
        (N, 3), unit vectors.
    instance
        (N,), index of the primitive in the flattened scene.
    count
        Number of primitives in the flattened scene.
    """

    splats: Splats
    emission: Tensor
    normals: FloatArray
    instance: IntArray
    count: int


def gaussians_of(root: Entity, total: int, seed: int = 0) -> SceneSplats:
    """Return about ``total`` Gaussians for the scene ``root``, distributed by area, at least 16 for each primitive.

    ``seed`` shifts their positions. Raises SceneError for invalid attributes and files; LimitError if the primitives
    require more than MAX_GAUSSIANS.
    """
    import torch

    count = primitive_count(root)
    if max(total, count * MIN_GAUSSIANS) > MAX_GAUSSIANS:
        required = (
            f"{total:,} Gaussians"
            if total > MAX_GAUSSIANS
            else f"{count:,} primitives with {MIN_GAUSSIANS} Gaussians each"
        )
        message = f"{required} exceed the limit of {MAX_GAUSSIANS:,} Gaussians"
        raise LimitError("primitives", message, hint="render a part of the scene")
    frame = flatten_entity(root)
    finite = np.flatnonzero(np.isfinite(frame.matrices).all(axis=(1, 2)))
    order = finite[np.argsort(frame.index[finite], kind="stable")]
    starts = np.searchsorted(frame.index[order], np.arange(len(frame.primitives) + 1))
    instances = [order[a:b] for a, b in pairwise(starts.tolist())]  # by primitive
    scales = [_area_scale(frame.matrices[indices]) for indices in instances]
    covers = [_cover_of_area(primitive, seed) for primitive in frame.primitives]
    areas = np.array([c.area * s if c is not None else 0.0 for c, s in zip(covers, scales)])
    total_area = float(areas @ [len(indices) for indices in instances])
    parts, emission, normals, instance = [], [], [], []
    for primitive, indices, area in zip(frame.primitives, instances, areas.tolist()):
        if not area or not len(indices):
            continue
        cover = cover_of(primitive, max(MIN_GAUSSIANS, round(total * area / total_area)), seed)
        if cover is None or not len(cover.gaussians):
            continue
        splats, world_normals = _apply_poses(cover, frame.matrices[indices])
        parts.append(splats)
        normals.append(world_normals)
        instance.append(np.repeat(indices, len(cover.gaussians)))
        emission.append(torch.tensor(look_of(primitive).emission, dtype=torch.float64).expand(len(splats), 3))
    if not parts:
        return _no_splats(count)
    return SceneSplats(
        concatenate_splats(parts), torch.cat(emission), np.concatenate(normals), np.concatenate(instance), count
    )


def cover_of(entity: Entity, count: int, seed: int = 0) -> Cover | None:
    """Return ``count`` Gaussians for one primitive, None if it is invisible; raises SceneError."""
    shape, look = entity.shape, look_of(entity)
    if shape is None or look.opacity == 0.0 or count < 1:
        return None
    placed = shape.placed()
    if placed is not None:
        return _solid_cover(placed, look, count, seed)
    mesh = own_mesh(shape)
    return None if mesh is None else _mesh_cover(entity, mesh, look, count, seed)


def _cover_of_area(entity: Entity, seed: int) -> Cover | None:
    """Return a cover of one Gaussian, for its area."""
    return cover_of(entity, 1, seed)


def _area_scale(matrices: FloatArray) -> float:
    """Return the mean factor by which poses (K, 3, 4) scale areas, exact for uniform scales."""
    return float(np.square(matrices[:, :, :3]).sum(axis=(1, 2)).mean() / 3.0) if len(matrices) else 0.0


def _apply_poses(cover: Cover, matrices: FloatArray) -> tuple[Splats, FloatArray]:
    """Apply each of the poses (K, 3, 4) to a cover; returns the concatenated splats and their normals."""
    import torch

    count, copies = len(cover.gaussians), len(matrices)
    poses = torch.from_numpy(np.repeat(matrices, count, axis=0))
    splats = apply_pose(cover.gaussians.take(torch.arange(count).repeat(copies)), poses[:, :, :3], poses[:, :, 3])
    linear = matrices[:, :, :3]
    # normals transform by the cofactor matrix, with the sign of the determinant removed for reflections
    cofactors = cofactors_of(linear)
    cofactors *= np.where(np.einsum("ni,ni->n", linear[:, :, 0], cofactors[:, :, 0]) < 0.0, -1.0, 1.0)[:, None, None]
    return splats, _unit(np.einsum("nij,kj->nki", cofactors, cover.normals).reshape(-1, 3))


def _unit(vectors: FloatArray) -> FloatArray:
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    up = np.broadcast_to([0.0, 1.0, 0.0], vectors.shape)
    return np.asarray(np.where(length > 0.0, vectors / np.where(length > 0.0, length, 1.0), up), np.float64)


# --- one primitive ---------------------------------------------------------------------------------------------


def _solid_cover(placed: Placed, look: Look, count: int, seed: int) -> Cover | None:
    """Return the Gaussians of a canonical form: flat ones on its surface, round ones inside."""
    pose = placed.matrix
    half = np.linalg.norm(pose[:, :3], axis=0)
    axes = np.where(half > 0.0, pose[:, :3] / np.where(half > 0.0, half, 1.0), np.eye(3))
    convex = placed.form.is_convex  # only then are scaled copies of the surface inside
    hides_interior = convex and half.min() > 0.0 and look.opacity == 1.0
    inside = int(count * _INTERIOR_FRACTION) if hides_interior else 0
    surface = sample_solid(placed.form, half.tolist(), count - inside, seed, placed.ratios)
    if not len(surface.points):
        return None
    interior = sample_solid(placed.form, half.tolist(), inside, seed + 1, placed.ratios)
    factors = np.linspace(_MIN_INTERIOR_SCALE, _MAX_INTERIOR_SCALE, inside)[:, None]
    points = np.concatenate([surface.points, factors * interior.points])
    normals = np.concatenate([surface.normals, interior.normals])
    spacing = np.sqrt(surface.area / max(len(surface.points), 1))
    flat = [_WIDTH * spacing, _WIDTH * spacing, _THICKNESS * spacing]
    round_ = [min(_WIDTH * spacing, 0.1 * float(half.min()))] * 3
    scales = np.concatenate([np.tile(flat, (len(surface.points), 1)), np.tile(round_, (inside, 1))])
    samples = SurfaceSamples(points @ axes.T + pose[:, 3], normals @ axes.T, surface.area)
    return _cover(samples, scales, np.tile(look.color, (count, 1)), look.opacity)


def _mesh_cover(entity: Entity, mesh: Mesh, look: Look, count: int, seed: int) -> Cover | None:
    """Return the Gaussians of a mesh, in its own colors unless the primitive has a ``:color``."""
    surface, triangle = sample_triangles(mesh.corners, count, seed)
    if not len(surface.points):
        return None
    own = mesh.colors if keeps_own_colors(entity, mesh) else None
    colors = own[triangle] if own is not None else np.tile(look.color, (count, 1))
    spacing = np.sqrt(surface.area / count)
    scales = np.tile([_WIDTH * spacing, _WIDTH * spacing, _THICKNESS * spacing], (count, 1))
    return _cover(surface, scales, colors, look.opacity)


def _cover(samples: SurfaceSamples, scales: FloatArray, colors: FloatArray, opacity: float) -> Cover:
    """Return Gaussians with standard deviations ``scales`` (K, 3), the last along the normal.

    Overlapping Gaussians together have the given ``opacity``.
    """
    import torch

    alpha = min(1.0 - (1.0 - opacity) ** (1.0 / _OVERLAP), _MAX_OPACITY)
    min_scale = _MIN_RELATIVE_SCALE * float(scales.max(initial=0.0)) or _MIN_RELATIVE_SCALE
    gaussians = Gaussians(
        torch.from_numpy(np.ascontiguousarray(samples.points)),
        torch.from_numpy(np.log(np.maximum(scales, min_scale))),
        torch.from_numpy(_quaternions_to(samples.normals)),
        torch.full((len(samples.points),), float(np.log(alpha / (1.0 - alpha))), dtype=torch.float64),
        torch.from_numpy(np.array(colors, np.float64)),
    )
    return Cover(gaussians, samples.normals, samples.area)


def _quaternions_to(normals: FloatArray) -> FloatArray:
    """Return the quaternions (K, 4) of the shortest rotations from z to unit ``normals`` (K, 3)."""
    x, y, z = normals.T
    quaternions = np.stack([1.0 + z, -y, x, np.zeros(len(normals))], axis=1)
    quaternions[z < -1.0 + 1e-9] = [0.0, 1.0, 0.0, 0.0]  # half a turn about any horizontal axis
    return np.asarray(quaternions / np.linalg.norm(quaternions, axis=1, keepdims=True), np.float64)


def _no_splats(count: int) -> SceneSplats:
    import torch

    empty = torch.zeros(0, 3, dtype=torch.float64)
    splats = Splats(empty, torch.zeros(0, 3, 3, dtype=torch.float64), empty[:, 0], empty)
    return SceneSplats(splats, empty, np.zeros((0, 3)), np.zeros(0, np.int64), count)


# Lighting of Gaussians as in draft pictures, and the background.


_SHADOW_PIXELS = 1024


_AMBIENT = 0.9  # unoccluded fraction of the ambient light at Gaussians; at the ground it is 1


_ROW = 1 << 12  # Gaussians per row of the sampling pattern for shadows


def shadow_of(stage: Stage) -> list[Shadow]:
    """Return the shadow map of the solids of ``stage``; empty in an unlit environment."""
    if stage.studio.environment.unlit:
        return []
    return [(shadow_map(stage.solids, stage.studio.key_direction, _SHADOW_PIXELS), 1.0)]


def shade(
    stage: Stage, shadow: list[Shadow], points: FloatArray, normals: FloatArray, colors: FloatArray, ids: IntArray
) -> Float32Array:
    """Return the radiance (N, 3) towards the eye of ``points`` with ``normals`` and reflectances ``colors`` (N, 3).

    ``ids`` (N,) are the solids of the stage to which the points belong.
    """
    camera = stage.camera
    view = np.broadcast_to(camera.forward, points.shape) if camera.is_parallel else points - camera.eye
    view = view / np.maximum(np.linalg.norm(view, axis=1, keepdims=True), 1e-300)
    backfacing = np.einsum("ni,ni->n", normals, view) > 0.0
    surface = Surface(ids, np.zeros(len(ids)), points, np.where(backfacing[:, None], -normals, normals), view)
    return radiance_of(stage, surface, colors.astype(np.float32), _reach(stage, surface, shadow, _ROW, _AMBIENT))


def backdrop(stage: Stage, shadow: list[Shadow]) -> Float32Array:
    """Return the radiance (H, W, 3) of ground and sky without the solids, but with their shadow."""
    origin, direction = camera_rays(stage.camera).each()
    count = len(origin)
    depth = np.full(count, np.inf) if stage.ground is None else ground_depths(stage.ground, origin, direction)
    ids = np.where(np.isfinite(depth), GROUND, SKY)
    points = origin + direction * np.where(np.isfinite(depth), depth, 0.0)[:, None]
    view = direction / np.linalg.norm(direction, axis=1, keepdims=True)
    surface = Surface(ids, depth, points, np.tile([0.0, 1.0, 0.0], (count, 1)), view)
    reach = _reach(stage, surface, shadow, stage.width, 1.0)
    return radiance_of(stage, surface, albedo_of(stage, surface), reach).reshape(stage.height, stage.width, 3)


def _reach(stage: Stage, surface: Surface, shadow: list[Shadow], width: int, ambient: float) -> Reach:
    row, column = np.divmod(np.arange(len(surface.ids)), width)
    key = key_reach(stage, surface, shadow, row, column)
    return Reach(key, np.full(len(key), ambient, np.float32))
