"""Primitives as arrays: what a primitive entity means to the geometric backends (their ``g_reparam``).

Every primitive is one of a few canonical convex solids under an affine pose, so that nothing that draws them needs to
know of sizes, radii and axes. Canonical solids lie in the cube [-1, 1]^3: BALL x^2 + y^2 + z^2 <= 1; BLOCK the cube;
CYLINDER x^2 + z^2 <= 1; CONE x^2 + z^2 <= ((1 - y) / 2)^2 with its apex at y = 1; TRIANGLE with the corners
(-1, -1, 0), (1, -1, 0), (-1, 1, 0), for meshes.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import IntEnum
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.geometry.assets import MOST_TRIANGLES, load_asset
from scenelang.backends.pictures.appearance import Look, Looks, look_of, looks_of
from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.scene.entity import Entity
from scenelang.interpreter.scene.flatten import FlatFrame
from scenelang.interpreter.scene.shapes import PrimitiveKind, PrimitiveShape

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]
Point = tuple[float, float, float]
Rows = tuple[float, float, float, float, float, float, float, float, float, float, float, float]

_THINNEST = 2e-5  # half the thickness that flat things are given, where the scene's half diagonal is 1


class SolidForm(IntEnum):
    """The canonical solids of the module's docstring."""

    BALL = 0
    BLOCK = 1
    CYLINDER = 2
    CONE = 3
    TRIANGLE = 4


@dataclass(frozen=True, slots=True, eq=False)
class Solids:
    """N posed solids in one frame of reference.

    ``matrices[i]`` takes the canonical solid ``forms[i]`` there; it looks as row ``look[i]`` of ``looks`` says.
    ``words[word[i]]`` is the primitive's word, ``semantic[i]`` says that it is the stand-in for a semantic primitive.
    ``instance[i]`` is its number in the flattened frame.
    """

    forms: npt.NDArray[np.int8]  # (N,)
    matrices: FloatArray  # (N, 3, 4)
    look: IntArray  # (N,)
    word: IntArray  # (N,)
    semantic: npt.NDArray[np.bool_]  # (N,)
    instance: IntArray  # (N,)
    looks: Looks
    words: tuple[str, ...]

    def __len__(self) -> int:
        return len(self.forms)

    @property
    def colors(self) -> FloatArray:
        """Reflectance (N, 3), linear sRGB; ``emission`` (N, 3) is radiance, ``opacity`` (N,) lies in (0, 1]."""
        return np.asarray(self.looks.color[self.look], np.float64)

    @property
    def emission(self) -> FloatArray:
        return np.asarray(self.looks.emission[self.look], np.float64)

    @property
    def opacity(self) -> FloatArray:
        return np.asarray(self.looks.opacity[self.look], np.float64)

    def take(self, which: npt.NDArray[Any]) -> Solids:
        """The solids that the mask or the indices ``which`` select."""
        columns: dict[str, Any] = {name: getattr(self, name)[which] for name in _COLUMNS}
        return replace(self, **columns)

    def followed_by(self, other: Solids) -> Solids:
        """These solids, then those of ``other``, which has the same tables of looks and words."""
        columns: dict[str, Any] = {
            name: np.concatenate([getattr(self, name), getattr(other, name)]) for name in _COLUMNS
        }
        return replace(self, **columns)


_COLUMNS = ("forms", "matrices", "look", "word", "semantic", "instance")


@dataclass(frozen=True, slots=True)
class _Piece:
    """What a distinct primitive is drawn as: one solid."""

    form: SolidForm
    rows: Rows
    look: int


@dataclass(frozen=True, slots=True, eq=False)
class _Mesh:
    """What a distinct primitive is drawn as: K triangles with local poses (K, 3, 4) and looks (K,)."""

    local: FloatArray
    look: IntArray


class _LookTable:
    """Numbers for distinct looks."""

    def __init__(self) -> None:
        self._numbers: dict[Look, int] = {}

    def number(self, look: Look) -> int:
        return self._numbers.setdefault(look, len(self._numbers))

    def looks(self) -> Looks:
        return looks_of(self._numbers)


def solids_of(frame: FlatFrame) -> Solids:
    """The solids that the primitives of ``frame`` are drawn as, in world coordinates; raises SceneError."""
    table = _LookTable()
    words = tuple(dict.fromkeys(entity.word for entity in frame.primitives))
    number = {word: i for i, word in enumerate(words)}
    pieces = [_piece(entity, table) for entity in frame.primitives]
    word = np.array([number[entity.word] for entity in frame.primitives], np.int64)
    semantic = np.array([is_semantic(entity) for entity in frame.primitives], bool)
    columns = [_single(frame, pieces, word, semantic)]
    for i, piece in enumerate(pieces):
        if isinstance(piece, _Mesh):
            columns.append(_many(frame, i, piece, int(word[i])))
    joined: dict[str, Any] = {name: np.concatenate([part[name] for part in columns]) for name in _COLUMNS}
    return Solids(**joined, looks=table.looks(), words=words)


def _single(
    frame: FlatFrame, pieces: Sequence[_Piece | _Mesh | None], word: IntArray, semantic: npt.NDArray[np.bool_]
) -> dict[str, npt.NDArray[Any]]:
    """The columns of the instances of all primitives that are one solid each."""
    singles = [(i, piece) for i, piece in enumerate(pieces) if isinstance(piece, _Piece)]
    place = np.full(len(pieces), -1, np.int64)
    place[[i for i, _ in singles]] = np.arange(len(singles))
    index = np.asarray(frame.index)
    instance = np.flatnonzero(place[index] >= 0) if len(index) else np.zeros(0, np.int64)
    which = place[index[instance]]
    local = np.array([piece.rows for _, piece in singles], np.float64).reshape(-1, 3, 4)
    return {
        "forms": np.array([piece.form for _, piece in singles], np.int8)[which],
        "matrices": composed(frame.matrices[instance], local[which]),
        "look": np.array([piece.look for _, piece in singles], np.int64)[which],
        "word": word[index[instance]],
        "semantic": semantic[index[instance]],
        "instance": instance,
    }


def _many(frame: FlatFrame, primitive: int, mesh: _Mesh, word: int) -> dict[str, npt.NDArray[Any]]:
    """The columns of the instances of one primitive that is many triangles."""
    instance = np.flatnonzero(np.asarray(frame.index) == primitive)
    count, total = len(mesh.local), len(instance) * len(mesh.local)
    if total > MOST_TRIANGLES:
        raise SceneError(
            "unsupported",
            f'the meshes of "{frame.primitives[primitive].word}" have {total:,} triangles in all, '
            f"more than the {MOST_TRIANGLES:,} that a picture may have",
            hint="use a simpler mesh, or fewer of them",
        )
    matrices = np.asarray(frame.matrices[instance])
    return {
        "forms": np.full(total, SolidForm.TRIANGLE, np.int8),
        "matrices": composed(np.repeat(matrices, count, axis=0), np.tile(mesh.local, (len(instance), 1, 1))),
        "look": np.tile(mesh.look, len(instance)),
        "word": np.full(total, word, np.int64),
        "semantic": np.zeros(total, bool),
        "instance": np.repeat(instance, count),
    }


def composed(outer: npt.NDArray[np.float64], inner: npt.NDArray[np.float64]) -> FloatArray:
    """Row-wise ``outer @ inner`` of affine poses (N, 3, 4)."""
    out = np.empty(np.broadcast_shapes(outer.shape, inner.shape))
    with np.errstate(all="ignore"):
        np.matmul(outer[..., :3], inner, out=out)
        out[..., 3] += outer[..., 3]
    return out


# --- shapes and looks of primitives ----------------------------------------------------------------------------


def local_pose(shape: PrimitiveShape) -> tuple[SolidForm, FloatArray] | None:
    """The canonical solid that ``shape`` is and its pose (3, 4) in the primitive's frame; None when there is none
    (deleted blocks, a cylinder or cone without a length, an asset)."""
    found = _local_rows(shape)
    return None if found is None else (found[0], np.array(found[1], np.float64).reshape(3, 4))


def _local_rows(shape: PrimitiveShape) -> tuple[SolidForm, Rows] | None:
    """As ``local_pose``, the pose as twelve numbers: arrays would cost more than the arithmetic."""
    kind = shape.kind
    if kind in (PrimitiveKind.CUBE, PrimitiveKind.BOX, PrimitiveKind.CUBOID):
        x, y, z = (side / 2.0 for side in shape.size)
        cx, cy, cz = (x, y, z) if kind is PrimitiveKind.CUBOID else (0.0, 0.0, 0.0)
        return SolidForm.BLOCK, (x, 0.0, 0.0, cx, 0.0, y, 0.0, cy, 0.0, 0.0, z, cz)
    if kind is PrimitiveKind.SPHERE:
        r = shape.radius
        return SolidForm.BALL, (r, 0.0, 0.0, 0.0, 0.0, r, 0.0, 0.0, 0.0, 0.0, r, 0.0)
    if kind in (PrimitiveKind.CYLINDER, PrimitiveKind.CONE):
        pose = _axis_rows(shape.p0, shape.p1, shape.radius)
        return (
            None if pose is None else (SolidForm.CYLINDER if kind is PrimitiveKind.CYLINDER else SolidForm.CONE, pose)
        )
    return None


def _axis_rows(p0: Point, p1: Point, radius: float) -> Rows | None:
    """The pose that takes the canonical axis, from y = -1 to y = 1, to p0 and p1; None where these are one point."""
    (x0, y0, z0), (x1, y1, z1) = p0, p1
    u, v, w = x1 - x0, y1 - y0, z1 - z0
    largest = max(abs(u), abs(v), abs(w))
    if largest == 0.0:
        return None
    i, j, k = u / largest, v / largest, w / largest
    length = math.sqrt(i * i + j * j + k * k)
    i, j, k = i / length, j / length, k / length
    # across is the product of the axis with the coordinate axis that it is least along
    if abs(i) <= abs(j) and abs(i) <= abs(k):
        a, b, c = 0.0, k, -j
    elif abs(j) <= abs(k):
        a, b, c = -k, 0.0, i
    else:
        a, b, c = j, -i, 0.0
    size = radius / math.sqrt(a * a + b * b + c * c)
    a, b, c = a * size, b * size, c * size
    e, f, g = b * k - c * j, c * i - a * k, a * j - b * i
    return (
        a, u / 2.0, e, (x0 + x1) / 2.0,
        b, v / 2.0, f, (y0 + y1) / 2.0,
        c, w / 2.0, g, (z0 + z1) / 2.0,
    )  # fmt: skip


def _piece(entity: Entity, table: _LookTable) -> _Piece | _Mesh | None:
    """What a primitive is drawn as, None where nothing is to be seen; raises SceneError where its attributes or its
    file make no sense."""
    shape, look = entity.shape, look_of(entity)
    if shape is None or look.opacity == 0.0:
        return None
    if shape.kind is PrimitiveKind.ASSET:
        return _asset_mesh(entity, look, table) if shape.file is not None else None
    found = _local_rows(shape)
    return None if found is None else _Piece(found[0], found[1], table.number(look))


def _asset_mesh(entity: Entity, look: Look, table: _LookTable) -> _Mesh:
    """The triangles of a mesh file, in their own colours unless the primitive has a ``:color``."""
    assert entity.shape is not None
    assert entity.shape.file is not None
    mesh = load_asset(entity.shape.file, entity.shape.root)
    local, kept = triangle_poses(mesh.corners)
    if mesh.face_colors is None or entity.embedding.attributes.get("color") is not None:
        return _Mesh(local, np.full(len(local), table.number(look)))
    colors, inverse = np.unique(mesh.face_colors[kept], axis=0, return_inverse=True)
    numbers = [table.number(replace(look, color=tuple(color))) for color in colors.tolist()]
    return _Mesh(local, np.array(numbers, np.int64)[inverse.reshape(-1)])


def triangle_poses(corners: FloatArray) -> tuple[FloatArray, IntArray]:
    """Poses (K, 3, 4) of the canonical triangle for ``corners`` (F, 3, 3) without the triangles of no area, and the
    numbers (K,) of those kept."""
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    normal = np.cross(b - a, c - a)
    length = np.linalg.norm(normal, axis=1)
    edge = np.maximum(np.linalg.norm(b - a, axis=1), np.linalg.norm(c - a, axis=1))
    kept = np.flatnonzero(length > 1e-12 * edge * edge)
    thin = normal[kept] / length[kept, None] * (1e-3 * edge[kept, None])
    a, b, c = a[kept], b[kept], c[kept]
    return np.stack([(b - a) / 2.0, (c - a) / 2.0, thin, (b + c) / 2.0], axis=2), kept


def is_semantic(entity: Entity) -> bool:
    """Whether a primitive is the stand-in for a word without geometry."""
    return entity.shape is not None and entity.shape.kind is PrimitiveKind.BOX


# --- films -----------------------------------------------------------------------------------------------------


def parted(frames: Sequence[Solids]) -> tuple[Solids, list[Solids]]:
    """The solids that are equal in all ``frames``, and the others of each; all share their tables."""
    table = _LookTable()
    words = {word: i for i, word in enumerate(dict.fromkeys(word for solids in frames for word in solids.words))}
    numbers = [np.array([table.number(look) for look in solids.looks.rows], np.int64) for solids in frames]
    looks = table.looks()
    common = [
        replace(
            solids,
            look=number[solids.look],
            word=np.array([words[word] for word in solids.words], np.int64)[solids.word],
            looks=looks,
            words=tuple(words),
        )
        for solids, number in zip(frames, numbers, strict=True)
    ]
    keys = [_row_keys(solids) for solids in common]
    shared = keys[0]
    for other in keys[1:]:
        shared = np.intersect1d(shared, other)
    fixed = common[0].take(np.isin(keys[0], shared))
    return fixed, [solids.take(~np.isin(key, shared)) for solids, key in zip(common, keys, strict=True)]


def _row_keys(solids: Solids) -> npt.NDArray[Any]:
    """One value per solid (N,), equal exactly where solids are drawn alike."""
    columns = [solids.matrices.reshape(len(solids), 12) + 0.0]  # no negative zeros
    columns += [column.astype(np.float64)[:, None] for column in (solids.forms, solids.look, solids.word)]
    rows = np.ascontiguousarray(np.concatenate(columns, axis=1))
    return rows.view(np.dtype((np.void, rows.shape[1] * 8))).reshape(-1)


# --- normal form -----------------------------------------------------------------------------------------------


def normalized(solids: Solids, center: FloatArray, scale: float) -> Solids:
    """The solids after ``p -> scale (p - center)``, every pose made invertible.

    Flat things get a thickness far below a pixel; what has no extent in two directions, and what is not finite, is
    left out.
    """
    matrices = solids.matrices.copy()
    with np.errstate(all="ignore"):
        matrices[:, :, 3] -= center
        matrices *= scale
        sound = np.asarray(np.isfinite(matrices).all(axis=(1, 2)), bool)
        doubtful = np.flatnonzero(sound & (thinness(matrices) < 2.0 * _THINNEST))
    if len(doubtful):
        linear, alive = _thickened(matrices[doubtful, :, :3])
        matrices[doubtful, :, :3] = linear
        sound[doubtful] &= alive
    return replace(solids, matrices=matrices).take(sound) if not sound.all() else replace(solids, matrices=matrices)


def thinness(matrices: FloatArray) -> FloatArray:
    """A lower bound, at most sqrt(3) too low, for the least singular value of each linear part (N,); nan where 0."""
    cofactors = cofactors_of(matrices[:, :, :3])
    determinant = np.einsum("ni,ni->n", matrices[:, :, 0], cofactors[:, :, 0])
    norm = np.sqrt(np.einsum("nij,nij->n", cofactors, cofactors))
    return np.where(norm > 0.0, np.abs(determinant) / np.where(norm > 0.0, norm, 1.0), 0.0)


def cofactors_of(linear: FloatArray) -> FloatArray:
    """The cofactor matrices of (N, 3, 3): ``det(A) inv(A).T``, whose columns are cross products of A's columns."""
    a, b, c = linear[:, :, 0], linear[:, :, 1], linear[:, :, 2]
    return np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)], axis=2)


def inverses_of(linear: FloatArray) -> FloatArray:
    """The inverses of (N, 3, 3), which are invertible."""
    cofactors = cofactors_of(linear)
    determinant = np.einsum("ni,ni->n", linear[:, :, 0], cofactors[:, :, 0])
    inverses: FloatArray = np.swapaxes(cofactors, 1, 2) / determinant[:, None, None]
    return inverses


def _thickened(linear: FloatArray) -> tuple[FloatArray, npt.NDArray[np.bool_]]:
    """The matrices (K, 3, 3) with their least singular value raised, and which of them are more than a line."""
    u, s, vt = np.linalg.svd(linear)
    least = np.minimum(_THINNEST, 2e-3 * s[:, 0])
    alive = (s[:, 1] > 0.05 * least) & (s[:, 0] > 1e-12)
    s = np.maximum(s, least[:, None])
    return (u * s[:, None, :]) @ vt, alive


# Triangle meshes of the canonical solids (see ``solids``), with normals for smooth surfaces and closed caps.


@dataclass(frozen=True, slots=True, eq=False)
class UnitMesh:
    """``vertices`` and outward unit ``normals`` (V, 3); ``faces`` (F, 3), counter-clockwise from outside."""

    vertices: FloatArray
    normals: FloatArray
    faces: IntArray


def unit_mesh(form: SolidForm, segments: int = 48) -> UnitMesh:
    """The canonical solid as a closed mesh; round ones have ``segments`` >= 3 sides, vertices on the true surface."""
    if form == SolidForm.BALL:
        return _ball(segments)
    if form == SolidForm.BLOCK:
        return _block()
    if form == SolidForm.CYLINDER:
        return _joined(_side(segments, 1.0), _cap(segments, 1.0), _cap(segments, -1.0))
    if form == SolidForm.CONE:
        return _joined(_side(segments, 0.0), _cap(segments, -1.0))
    corners = np.array([[-1.0, -1, 0], [1, -1, 0], [-1, 1, 0]])
    return UnitMesh(corners, np.tile([0.0, 0.0, 1.0], (3, 1)), np.array([[0, 1, 2]]))


def _joined(*meshes: UnitMesh) -> UnitMesh:
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    return UnitMesh(
        np.concatenate([mesh.vertices for mesh in meshes]),
        np.concatenate([mesh.normals for mesh in meshes]),
        np.concatenate([mesh.faces + start for mesh, start in zip(meshes, starts, strict=False)]),
    )


def _circle(segments: int) -> tuple[FloatArray, FloatArray]:
    angle = np.arange(segments) * (2.0 * math.pi / segments)
    return np.cos(angle), np.sin(angle)


def _ball(segments: int) -> UnitMesh:
    """Rings of latitude with the poles on the y axis."""
    rings = max(2, (segments + 1) // 2)
    cosine, sine = _circle(segments)
    height = np.arange(1, rings) * (math.pi / rings)
    y, radius = np.cos(height), np.sin(height)
    body = np.stack(
        [radius[:, None] * sine, np.broadcast_to(y[:, None], (rings - 1, segments)), radius[:, None] * cosine], axis=2
    )
    vertices = np.concatenate([[[0.0, 1.0, 0.0]], body.reshape(-1, 3), [[0.0, -1.0, 0.0]]])
    here = np.arange(segments)
    after = (here + 1) % segments
    last = len(vertices) - 1
    faces = [np.stack([np.zeros_like(here), 1 + here, 1 + after], axis=1)]
    for ring in range(rings - 2):
        top, bottom = 1 + ring * segments, 1 + (ring + 1) * segments
        faces.append(np.stack([top + here, bottom + here, bottom + after], axis=1))
        faces.append(np.stack([top + here, bottom + after, top + after], axis=1))
    start = 1 + (rings - 2) * segments
    faces.append(np.stack([start + here, np.full_like(here, last), start + after], axis=1))
    return UnitMesh(vertices, vertices.copy(), np.concatenate(faces))


def _block() -> UnitMesh:
    """Six squares of two triangles, four vertices each."""
    meshes = []
    for axis in range(3):
        for sign in (-1.0, 1.0):
            u, v = np.eye(3)[(axis + 1) % 3], np.eye(3)[(axis + 2) % 3]
            normal = sign * np.eye(3)[axis]
            v = sign * v
            corners = np.stack([normal - u - v, normal + u - v, normal + u + v, normal - u + v])
            meshes.append(UnitMesh(corners, np.tile(normal, (4, 1)), np.array([[0, 1, 2], [0, 2, 3]])))
    return _joined(*meshes)


def _side(segments: int, top: float) -> UnitMesh:
    """The side from radius 1 at y = -1 to radius ``top`` at y = 1."""
    cosine, sine = _circle(segments)
    ones = np.ones(segments)
    slope = (1.0 - top) / 2.0
    normal = np.stack([sine, slope * ones, cosine], axis=1) / math.hypot(1.0, slope)
    low = np.stack([sine, -ones, cosine], axis=1)
    here = np.arange(segments)
    after = (here + 1) % segments
    if top > 0.0:
        high = np.stack([top * sine, ones, top * cosine], axis=1)
        faces = [
            np.stack([here, after, segments + after], axis=1),
            np.stack([here, segments + after, segments + here], axis=1),
        ]
        return UnitMesh(np.concatenate([low, high]), np.concatenate([normal, normal]), np.concatenate(faces))
    middle = normal + normal[after]  # the apex has one vertex, and one normal, per side
    middle /= np.linalg.norm(middle, axis=1, keepdims=True)
    apex = np.tile([0.0, 1.0, 0.0], (segments, 1))
    faces = [np.stack([here, after, segments + here], axis=1)]
    return UnitMesh(np.concatenate([low, apex]), np.concatenate([normal, middle]), np.concatenate(faces))


def _cap(segments: int, y: float) -> UnitMesh:
    cosine, sine = _circle(segments)
    rim = np.stack([sine, np.full(segments, y), cosine], axis=1)
    vertices = np.concatenate([rim, [[0.0, y, 0.0]]])
    here = np.arange(segments)
    after = (here + 1) % segments
    center = np.full(segments, segments)
    faces = np.stack([here, after, center] if y > 0 else [after, here, center], axis=1)
    return UnitMesh(vertices, np.tile([0.0, math.copysign(1.0, y), 0.0], (segments + 1, 1)), faces)


def posed(mesh: UnitMesh, matrices: FloatArray) -> tuple[FloatArray, FloatArray, IntArray]:
    """``mesh`` under each of the invertible poses (K, 3, 4), one after the other.

    Returns vertices (K V, 3), unit normals (K V, 3) and faces (K F, 3); a mirrored copy's faces are turned, so that
    they stay counter-clockwise from outside.
    """
    linear = matrices[:, :, :3]
    count, size = len(matrices), len(mesh.vertices)
    vertices = mesh.vertices @ np.swapaxes(linear, 1, 2) + matrices[:, None, :, 3]
    cofactors = cofactors_of(linear)
    mirrored = np.einsum("ni,ni->n", linear[:, :, 0], cofactors[:, :, 0]) < 0.0
    normals = mesh.normals @ np.swapaxes(cofactors, 1, 2)
    normals *= np.where(mirrored, -1.0, 1.0)[:, None, None]
    length = np.sqrt(np.einsum("nvi,nvi->nv", normals, normals))
    normals /= np.where(length > 0.0, length, 1.0)[:, :, None]
    faces = (
        np.where(mirrored[:, None, None], mesh.faces[:, ::-1], mesh.faces) + (np.arange(count) * size)[:, None, None]
    )
    return vertices.reshape(-1, 3), normals.reshape(-1, 3), faces.reshape(-1, 3)


def triangle_normals(corners: FloatArray) -> FloatArray:
    """The unit normals (F, 3) of triangles (F, 3, 3), counter-clockwise from outside; zero where there is no area."""
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    unit: FloatArray = normals / np.where(length > 0.0, length, 1.0)
    return unit
