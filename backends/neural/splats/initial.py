"""What primitives are as Gaussians before anything is learned: flat ones that cover their surfaces, some inside.

The Gaussians of a primitive entity are made once, in its own frame, and posed for each of its instances.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from scenelang.backends.geometry.solids import keeps_own_colors, own_mesh
from scenelang.backends.neural.splats.gaussians import Gaussians, Splats, joined, posed
from scenelang.backends.pictures.appearance import Look, look_of
from scenelang.backends.pictures.draft_light import (
    GROUND,
    SKY,
    Reach,
    Shadow,
    Surface,
    albedo_of,
    ground_depths,
    radiance_of,
    shadow_map,
)
from scenelang.backends.pictures.rays import camera_rays
from scenelang.backends.pictures.stage import Stage
from scenelang.backends.pictures.studio import BRIGHTEST
from scenelang.grammar.diagnostics import LimitError
from scenelang.interpreter.scene.entity import Entity, primitive_count
from scenelang.interpreter.scene.flatten import flatten_entity
from scenelang.interpreter.scene.primitives import Placed
from scenelang.interpreter.scene.primitives.forms import CanonicalForm
from scenelang.interpreter.scene.primitives.mesh import Mesh, cofactors_of, triangle_normals

if TYPE_CHECKING:
    from torch import Tensor


# Points that lie evenly on the surfaces of primitives: the same ones every time.
#
# A surface is made of charts (``primitives.forms``), each of which takes the unit square to a part of it without
# changing ratios of areas. On each the points are a Fibonacci lattice, so that they are neither random nor in rows.


FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]
Float32Array = npt.NDArray[np.float32]

_GOLDEN = (math.sqrt(5.0) - 1.0) / 2.0
_PLASTIC = 1.324717957244746  # its powers do in the plane what the golden ratio does on the line


@dataclass(frozen=True, slots=True, eq=False)
class SurfaceSamples:
    """K points on a surface: ``places`` and unit ``normals`` (K, 3); ``area`` is the whole surface's."""

    places: FloatArray
    normals: FloatArray
    area: float


def on_solid(
    form: CanonicalForm, half: Sequence[float], count: int, seed: int = 0, ratios: tuple[float, ...] = ()
) -> SurfaceSamples:
    """``count`` points on the canonical ``form``, stretched by the three ``half`` sizes; a round one must stay so, so
    that its first and last size are equal. ``seed`` shifts the lattice."""
    charts = [chart for chart in form.charts(half, ratios) if chart.area > 0.0]
    area = sum(chart.area for chart in charts)
    if not charts:
        return SurfaceSamples(np.zeros((0, 3)), np.zeros((0, 3)), 0.0)
    shares = _shared_out([chart.area for chart in charts], count)
    # each chart has its own shift, so that the two sides of something flat do not coincide
    found = [
        chart.place(*_lattice(share, seed + i)) for i, (chart, share) in enumerate(zip(charts, shares, strict=True))
    ]
    return SurfaceSamples(np.concatenate([p for p, _ in found]), np.concatenate([n for _, n in found]), area)


def on_triangles(corners: FloatArray, count: int, seed: int = 0) -> tuple[SurfaceSamples, IntArray]:
    """``count`` points on triangles (F, 3, 3), and on which each lies (K,); none where these have no area."""
    areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2.0
    reached = np.cumsum(areas)
    if not len(areas) or not 0.0 < reached[-1] < math.inf:
        return SurfaceSamples(np.zeros((0, 3)), np.zeros((0, 3)), 0.0), np.zeros(0, np.int64)
    i = np.arange(count)
    which = np.searchsorted(reached, (i + 0.5) / count * reached[-1], side="right").clip(max=len(areas) - 1)
    u, v = np.modf(i / _PLASTIC + seed * _GOLDEN)[0], np.modf(i / _PLASTIC**2 + seed * _GOLDEN)[0]
    over = u + v > 1.0
    u, v = np.where(over, 1.0 - u, u)[:, None], np.where(over, 1.0 - v, v)[:, None]
    a, b, c = (corners[which, k] for k in range(3))
    return SurfaceSamples(a + u * (b - a) + v * (c - a), triangle_normals(corners)[which], float(reached[-1])), which


def _lattice(count: int, seed: int) -> tuple[FloatArray, FloatArray]:
    i = np.arange(count)
    return (i + 0.5) / max(count, 1), np.modf(i * _GOLDEN + seed * math.sqrt(2.0))[0]


def _shared_out(areas: Sequence[float], count: int) -> list[int]:
    """``count`` in whole parts as the ``areas`` are, the largest rests rounded up."""
    exact = np.array(areas) / sum(areas) * count
    parts = np.floor(exact).astype(np.int64)
    parts[np.argsort(parts - exact, kind="stable")[: count - int(parts.sum())]] += 1
    return [int(part) for part in parts]


MOST = 5_000_000  # Gaussians of one scene
LEAST = 16  # of one primitive: fewer cover no surface
_INSIDE = 0.1  # the share that lies below the surface, shrunk towards the middle by up to...
_DEEPEST, _HIGHEST = 0.3, 0.8
_WIDTH, _THICKNESS = 0.6, 0.08  # standard deviations along and across the surface, in distances between neighbours
_LAYERS = 2.0 * np.pi * _WIDTH**2  # how many Gaussians lie over each point of a surface
_MOST_OPAQUE = 0.98
_THINNEST = 1e-9  # of the largest size: nothing has no extent at all


@dataclass(frozen=True, slots=True, eq=False)
class Cover:
    """The Gaussians of one primitive in its own frame, in 64 bits, and their unit ``normals`` (K, 3); ``area`` is what
    they cover."""

    gaussians: Gaussians
    normals: FloatArray
    area: float


@dataclass(frozen=True, slots=True, eq=False)
class SceneSplats:
    """N Gaussians of a scene, posed, in 64 bits. The colours of ``splats`` are reflectance, ``emission`` (N, 3) is
    radiance, ``normals`` (N, 3) have unit length. ``instance`` (N,): the primitive's number in the flattened scene,
    which has ``count`` of them."""

    splats: Splats
    emission: Tensor
    normals: FloatArray
    instance: IntArray
    count: int


def gaussians_of(root: Entity, total: int, seed: int = 0) -> SceneSplats:
    """About ``total`` Gaussians for the scene ``root``, shared out by area, at least LEAST for each primitive.

    Another ``seed`` places them otherwise. Raises SceneError for attributes and files that make no sense, and
    LimitError where the primitives need more than MOST.
    """
    import torch

    count = primitive_count(root)
    if max(total, count * LEAST) > MOST:
        wanted = f"{total:,} Gaussians" if total > MOST else f"{count:,} primitives with {LEAST} Gaussians each"
        raise LimitError("primitives", f"{wanted} are more than the {MOST:,} that fit", hint="draw a part of the scene")
    frame = flatten_entity(root)
    sound = np.flatnonzero(np.isfinite(frame.matrices).all(axis=(1, 2)))
    order = sound[np.argsort(frame.index[sound], kind="stable")]
    starts = np.searchsorted(frame.index[order], np.arange(len(frame.primitives) + 1))
    of = [order[a:b] for a, b in pairwise(starts.tolist())]
    sizes = [_size(frame.matrices[which]) for which in of]
    covers = [_cover_of_area(primitive, seed) for primitive in frame.primitives]
    weights = np.array([c.area * s if c is not None else 0.0 for c, s in zip(covers, sizes)])
    whole = float(weights @ [len(which) for which in of])
    parts, glow, normals, instance = [], [], [], []
    for primitive, which, weight in zip(frame.primitives, of, weights.tolist()):
        if not weight or not len(which):
            continue
        cover = cover_of(primitive, max(LEAST, round(total * weight / whole)), seed)
        if cover is None or not len(cover.gaussians):
            continue
        one, turned = _posed(cover, frame.matrices[which])
        parts.append(one)
        normals.append(turned)
        instance.append(np.repeat(which, len(cover.gaussians)))
        glow.append(torch.tensor(look_of(primitive).emission, dtype=torch.float64).expand(len(one), 3))
    if not parts:
        return _nothing(count)
    return SceneSplats(joined(parts), torch.cat(glow), np.concatenate(normals), np.concatenate(instance), count)


def cover_of(entity: Entity, count: int, seed: int = 0) -> Cover | None:
    """``count`` Gaussians for one primitive; None where there is nothing to see. Raises SceneError."""
    shape, look = entity.shape, look_of(entity)
    if shape is None or look.opacity == 0.0 or count < 1:
        return None
    placed = shape.placed()
    if placed is not None:
        return _solid_cover(placed, look, count, seed)
    mesh = own_mesh(shape)
    return None if mesh is None else _mesh_cover(entity, mesh, look, count, seed)


def _cover_of_area(entity: Entity, seed: int) -> Cover | None:
    """A cover of one Gaussian, for its area."""
    return cover_of(entity, 1, seed)


def _size(matrices: FloatArray) -> float:
    """By how much poses (K, 3, 4) make areas larger, about and on average."""
    return float(np.square(matrices[:, :, :3]).sum(axis=(1, 2)).mean() / 3.0) if len(matrices) else 0.0


def _posed(cover: Cover, matrices: FloatArray) -> tuple[Splats, FloatArray]:
    """The cover under each of the poses (K, 3, 4), one after the other, and the normals there."""
    import torch

    count, copies = len(cover.gaussians), len(matrices)
    each = torch.from_numpy(np.repeat(matrices, count, axis=0))
    splats = posed(cover.gaussians.take(torch.arange(count).repeat(copies)), each[:, :, :3], each[:, :, 3])
    linear = matrices[:, :, :3]
    cofactors = cofactors_of(linear)
    cofactors *= np.where(np.einsum("ni,ni->n", linear[:, :, 0], cofactors[:, :, 0]) < 0.0, -1.0, 1.0)[:, None, None]
    return splats, _unit(np.einsum("nij,kj->nki", cofactors, cover.normals).reshape(-1, 3))


def _unit(vectors: FloatArray) -> FloatArray:
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    up = np.broadcast_to([0.0, 1.0, 0.0], vectors.shape)
    return np.asarray(np.where(length > 0.0, vectors / np.where(length > 0.0, length, 1.0), up), np.float64)


# --- one primitive ---------------------------------------------------------------------------------------------


def _solid_cover(placed: Placed, look: Look, count: int, seed: int) -> Cover | None:
    """The Gaussians of a canonical form: flat ones on its surface, round ones inside."""
    pose = placed.matrix
    half = np.linalg.norm(pose[:, :3], axis=0)
    axes = np.where(half > 0.0, pose[:, :3] / np.where(half > 0.0, half, 1.0), np.eye(3))
    convex = placed.form.is_convex  # shrunk towards its middle, it stays inside
    hides = convex and half.min() > 0.0 and look.opacity == 1.0  # through the others one would see what is inside
    inside = int(count * _INSIDE) if hides else 0
    surface = on_solid(placed.form, half.tolist(), count - inside, seed, placed.ratios)
    if not len(surface.places):
        return None
    within = on_solid(placed.form, half.tolist(), inside, seed + 1, placed.ratios)
    depth = np.linspace(_DEEPEST, _HIGHEST, inside)[:, None]
    places = np.concatenate([surface.places, depth * within.places])
    normals = np.concatenate([surface.normals, within.normals])
    step = np.sqrt(surface.area / max(len(surface.places), 1))
    flat = [_WIDTH * step, _WIDTH * step, _THICKNESS * step]
    round_ = [min(_WIDTH * step, 0.1 * float(half.min()))] * 3
    scales = np.concatenate([np.tile(flat, (len(surface.places), 1)), np.tile(round_, (inside, 1))])
    turned = SurfaceSamples(places @ axes.T + pose[:, 3], normals @ axes.T, surface.area)
    return _cover(turned, scales, np.tile(look.color, (count, 1)), look.opacity)


def _mesh_cover(entity: Entity, mesh: Mesh, look: Look, count: int, seed: int) -> Cover | None:
    """The Gaussians of a mesh, in its own colours unless the primitive has a ``:color``."""
    surface, which = on_triangles(mesh.corners, count, seed)
    if not len(surface.places):
        return None
    own = mesh.colors if keeps_own_colors(entity, mesh) else None
    colors = own[which] if own is not None else np.tile(look.color, (count, 1))
    step = np.sqrt(surface.area / count)
    return _cover(surface, np.tile([_WIDTH * step, _WIDTH * step, _THICKNESS * step], (count, 1)), colors, look.opacity)


def _cover(at: SurfaceSamples, scales: FloatArray, colors: FloatArray, opacity: float) -> Cover:
    """Gaussians with standard deviations ``scales`` (K, 3), the last along the normal; what lies over a point of the
    surface has together the ``opacity``."""
    import torch

    each = min(1.0 - (1.0 - opacity) ** (1.0 / _LAYERS), _MOST_OPAQUE)
    least = _THINNEST * float(scales.max(initial=0.0)) or _THINNEST
    made = Gaussians(
        torch.from_numpy(np.ascontiguousarray(at.places)),
        torch.from_numpy(np.log(np.maximum(scales, least))),
        torch.from_numpy(_facing(at.normals)),
        torch.full((len(at.places),), float(np.log(each / (1.0 - each))), dtype=torch.float64),
        torch.from_numpy(np.array(colors, np.float64)),
    )
    return Cover(made, at.normals, at.area)


def _facing(normals: FloatArray) -> FloatArray:
    """Quaternions (K, 4) of the shortest turns that take z to unit ``normals`` (K, 3)."""
    x, y, z = normals.T
    turns = np.stack([1.0 + z, -y, x, np.zeros(len(normals))], axis=1)
    turns[z < -1.0 + 1e-9] = [0.0, 1.0, 0.0, 0.0]
    return np.asarray(turns / np.linalg.norm(turns, axis=1, keepdims=True), np.float64)


def _nothing(count: int) -> SceneSplats:
    import torch

    empty = torch.zeros(0, 3, dtype=torch.float64)
    splats = Splats(empty, torch.zeros(0, 3, 3, dtype=torch.float64), empty[:, 0], empty)
    return SceneSplats(splats, empty, np.zeros((0, 3)), np.zeros(0, np.int64), count)


# Light on the Gaussians of a scene, as draft pictures have it, and what lies behind them.


_SHADOW_PIXELS = 1024


_AROUND = 0.9  # the share of the surrounding light that reaches the Gaussians; all of it reaches the ground


_ROW = 1 << 12  # Gaussians in a row of the pattern by which shadows are sampled


def shadow_of(stage: Stage) -> list[Shadow]:
    """The shadow of the solids of ``stage``; none where there is no light."""
    if stage.studio.environment.unlit:
        return []
    return [(shadow_map(stage.solids, stage.studio.key_direction, _SHADOW_PIXELS), 1.0)]


def lit(
    stage: Stage, shadow: list[Shadow], points: FloatArray, normals: FloatArray, colors: FloatArray, ids: IntArray
) -> Float32Array:
    """The radiance (N, 3) towards the eye of ``points`` with ``normals`` and reflectances ``colors`` (N, 3), which
    belong to the solids ``ids`` (N,) of the stage."""
    camera = stage.camera
    view = np.broadcast_to(camera.forward, points.shape) if camera.is_parallel else points - camera.eye
    view = view / np.maximum(np.linalg.norm(view, axis=1, keepdims=True), 1e-300)
    away = np.einsum("ni,ni->n", normals, view) > 0.0
    seen = Surface(ids, np.zeros(len(ids)), points, np.where(away[:, None], -normals, normals), view)
    brightest = 1.0 if stage.studio.environment.unlit else BRIGHTEST
    return radiance_of(stage, seen, (colors * brightest).astype(np.float32), _reach(shadow, len(ids), _ROW, _AROUND))


def backdrop(stage: Stage, shadow: list[Shadow]) -> Float32Array:
    """The radiance (H, W, 3) of ground and sky without the solids, but with their shadow."""
    rays = camera_rays(stage.camera)
    count = stage.width * stage.height
    rows, columns = np.divmod(np.arange(count), stage.width)
    origin, direction = rays.at(columns + 0.5, rows + 0.5)
    depth = np.full(count, np.inf) if stage.ground is None else ground_depths(stage.ground, origin, direction)
    ids = np.where(np.isfinite(depth), GROUND, SKY)
    points = origin + direction * np.where(np.isfinite(depth), depth, 0.0)[:, None]
    view = direction / np.linalg.norm(direction, axis=1, keepdims=True)
    seen = Surface(ids, depth, points, np.tile([0.0, 1.0, 0.0], (count, 1)), view)
    reach = _reach(shadow, count, stage.width, 1.0)
    return radiance_of(stage, seen, albedo_of(stage, seen), reach).reshape(stage.height, stage.width, 3)


def _reach(shadow: list[Shadow], count: int, width: int, around: float) -> Reach:
    row, column = np.divmod(np.arange(count), width)
    return Reach(shadow, np.full(count, around, np.float32), row, column)
