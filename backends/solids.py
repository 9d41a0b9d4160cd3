"""Primitives as arrays: what a primitive entity means to the geometric backends (their ``g_reparam``).

Every primitive is one of a few canonical convex solids under an affine pose, so that nothing that draws them needs to
know of sizes, radii and axes. Canonical solids lie in the cube [-1, 1]^3: BALL x^2 + y^2 + z^2 <= 1; BLOCK the cube;
CYLINDER x^2 + z^2 <= 1; CONE x^2 + z^2 <= ((1 - y) / 2)^2 with its apex at y = 1; TRIANGLE with the corners
(-1, -1, 0), (1, -1, 0), (-1, 1, 0), for meshes.
"""

from __future__ import annotations

import colorsys
import hashlib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import IntEnum
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.studio import from_srgb
from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.entity import Entity
from scenelang.interpreter.flatten import FlatFrame
from scenelang.interpreter.shapes import Kind, Shape
from scenelang.interpreter.values import Array, MutableArray, MutableList, Pair, list_items

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]
Point = tuple[float, float, float]

_THINNEST = 2e-5  # half the thickness that flat things are given, where the scene's half diagonal is 1
_MOST_TRIANGLES = 2_000_000


class Form(IntEnum):
    """The canonical solids of the module's docstring."""

    BALL = 0
    BLOCK = 1
    CYLINDER = 2
    CONE = 3
    TRIANGLE = 4


@dataclass(frozen=True, slots=True, eq=False)
class Solids:
    """N posed solids in one frame of reference.

    ``matrices[i]`` takes the canonical solid ``forms[i]`` there. ``colors`` is reflectance, ``emission`` radiance, both
    linear sRGB; ``opacity`` in (0, 1]. ``words[word[i]]`` is the primitive's word, ``semantic[i]`` says that it is the
    stand-in for a semantic primitive. ``instance[i]`` is its number in the flattened frame.
    """

    forms: npt.NDArray[np.int8]  # (N,)
    matrices: FloatArray  # (N, 3, 4)
    colors: FloatArray  # (N, 3)
    emission: FloatArray  # (N, 3)
    opacity: FloatArray  # (N,)
    word: IntArray  # (N,)
    semantic: npt.NDArray[np.bool_]  # (N,)
    instance: IntArray  # (N,)
    words: tuple[str, ...]

    def __len__(self) -> int:
        return len(self.forms)

    def take(self, which: npt.NDArray[Any]) -> Solids:
        """The solids that the mask or the indices ``which`` select."""
        return Solids(
            self.forms[which],
            self.matrices[which],
            self.colors[which],
            self.emission[which],
            self.opacity[which],
            self.word[which],
            self.semantic[which],
            self.instance[which],
            self.words,
        )


@dataclass(frozen=True, slots=True)
class Look:
    """How a primitive's surface looks: reflectance and radiance in linear sRGB, opacity in [0, 1]."""

    color: Point
    emission: Point = (0.0, 0.0, 0.0)
    opacity: float = 1.0


def solids_of(frame: FlatFrame) -> Solids:
    """The solids that the primitives of ``frame`` are drawn as, in world coordinates; raises SceneError."""
    words = list(dict.fromkeys(entity.word for entity in frame.primitives))
    number = {word: i for i, word in enumerate(words)}
    looks = [look_of(entity) for entity in frame.primitives]
    meshes: dict[str, FloatArray | None] = {}
    pieces = [_pieces(entity, meshes) for entity in frame.primitives]
    parts = [_single(frame, pieces, looks, number, words)]
    for i, (_, local) in enumerate(pieces):
        if len(local) > 1 and looks[i].opacity > 0.0:
            parts.append(_many(frame, i, local, looks[i], number, words))
    return join(parts) if len(parts) > 1 else parts[0]


def join(parts: Sequence[Solids]) -> Solids:
    """The solids of all ``parts``, which share their words."""
    names = ("forms", "matrices", "colors", "emission", "opacity", "word", "semantic", "instance")
    columns: dict[str, Any] = {name: np.concatenate([getattr(part, name) for part in parts]) for name in names}
    return Solids(**columns, words=parts[0].words)


def _single(
    frame: FlatFrame,
    pieces: Sequence[tuple[Form, FloatArray]],
    looks: Sequence[Look],
    number: Mapping[str, int],
    words: Sequence[str],
) -> Solids:
    """The instances of all primitives that are one solid each."""
    count = len(pieces)
    single = np.array([len(local) == 1 for _, local in pieces], bool)
    local = np.zeros((count, 3, 4))
    for i, (_, poses) in enumerate(pieces):
        if single[i]:
            local[i] = poses[0]
    drawn = single & np.array([look.opacity > 0.0 for look in looks], bool)
    index = np.asarray(frame.index)
    instance = np.flatnonzero(drawn[index]) if count else np.zeros(0, np.int64)
    which = index[instance]
    semantic = np.array([_is_semantic(entity) for entity in frame.primitives], bool)
    return Solids(
        np.array([form for form, _ in pieces], np.int8)[which],
        composed(frame.matrices[instance], local[which]),
        np.array([look.color for look in looks]).reshape(count, 3)[which],
        np.array([look.emission for look in looks]).reshape(count, 3)[which],
        np.array([look.opacity for look in looks])[which],
        np.array([number[entity.word] for entity in frame.primitives], np.int64)[which],
        semantic[which],
        instance,
        tuple(words),
    )


def _many(
    frame: FlatFrame, primitive: int, local: FloatArray, look: Look, number: Mapping[str, int], words: Sequence[str]
) -> Solids:
    """The instances of one primitive that is many triangles."""
    instance = np.flatnonzero(np.asarray(frame.index) == primitive)
    if len(instance) * len(local) > _MOST_TRIANGLES:
        raise SceneError(
            "unsupported",
            f'the meshes of "{frame.primitives[primitive].word}" have {len(instance) * len(local):,} triangles in all, '
            f"more than the {_MOST_TRIANGLES:,} that a picture may have",
            hint="use a simpler mesh, or fewer of them",
        )
    matrices = np.asarray(frame.matrices[instance])
    total = len(instance) * len(local)
    world = composed(np.repeat(matrices, len(local), axis=0), np.tile(local, (len(instance), 1, 1)))
    return Solids(
        np.full(total, Form.TRIANGLE, np.int8),
        world,
        np.tile(np.array(look.color), (total, 1)),
        np.tile(np.array(look.emission), (total, 1)),
        np.full(total, look.opacity),
        np.full(total, number[frame.primitives[primitive].word], np.int64),
        np.zeros(total, bool),
        np.repeat(instance, len(local)),
        tuple(words),
    )


def composed(outer: npt.NDArray[np.float64], inner: npt.NDArray[np.float64]) -> FloatArray:
    """Row-wise ``outer @ inner`` of affine poses (N, 3, 4)."""
    out = np.empty(np.broadcast_shapes(outer.shape, inner.shape))
    with np.errstate(all="ignore"):
        np.matmul(outer[..., :3], inner, out=out)
        out[..., 3] += outer[..., 3]
    return out


# --- shapes and looks of primitives ----------------------------------------------------------------------------


def local_pose(shape: Shape) -> tuple[Form, FloatArray] | None:
    """The canonical solid that ``shape`` is and its pose (3, 4) in the primitive's frame; None when there is none
    (deleted blocks, a cylinder or cone without a length, an asset)."""
    if shape.kind in (Kind.CUBE, Kind.BOX):
        return Form.BLOCK, _stretch(np.array(shape.size) / 2.0, np.zeros(3))
    if shape.kind is Kind.CUBOID:
        return Form.BLOCK, _stretch(np.array(shape.size) / 2.0, np.array(shape.size) / 2.0)
    if shape.kind is Kind.SPHERE:
        return Form.BALL, _stretch(np.full(3, shape.radius), np.zeros(3))
    if shape.kind in (Kind.CYLINDER, Kind.CONE):
        form = Form.CYLINDER if shape.kind is Kind.CYLINDER else Form.CONE
        pose = _axis_pose(np.array(shape.p0), np.array(shape.p1), shape.radius)
        return None if pose is None else (form, pose)
    return None


def _stretch(half: FloatArray, center: FloatArray) -> FloatArray:
    return np.concatenate([np.diag(half), center[:, None]], axis=1)


def _axis_pose(p0: FloatArray, p1: FloatArray, radius: float) -> FloatArray | None:
    """The pose that takes the canonical axis, from y = -1 to y = 1, to p0 and p1; None where these are one point."""
    axis = p1 - p0
    largest = float(np.max(np.abs(axis)))
    if largest == 0.0:
        return None
    unit = axis / largest
    unit = unit / np.linalg.norm(unit)
    other = np.eye(3)[int(np.argmin(np.abs(unit)))]
    across = np.cross(unit, other)
    across /= np.linalg.norm(across)
    return np.stack([radius * across, axis / 2.0, radius * np.cross(across, unit), (p0 + p1) / 2.0], axis=1)


def _pieces(entity: Entity, meshes: dict[str, FloatArray | None]) -> tuple[Form, FloatArray]:
    """The form and the local poses (K, 3, 4) of a primitive; K = 0 where nothing is drawn."""
    shape = entity.shape
    nothing = Form.BLOCK, np.zeros((0, 3, 4))
    if shape is None:
        return nothing
    if shape.kind is not Kind.ASSET:
        found = local_pose(shape)
        return (found[0], found[1][None]) if found is not None else nothing
    triangles = _asset_triangles(shape.file, meshes)
    if triangles is not None:
        return Form.TRIANGLE, triangles
    x0, y0, z0, x1, y1, z1 = shape.box or (0.0, 0.0, 0.0, *shape.size)
    low, high = np.array([x0, y0, z0]), np.array([x1, y1, z1])
    return Form.BLOCK, _stretch((high - low) / 2.0, (high + low) / 2.0)[None]


def _asset_triangles(file: str | None, meshes: dict[str, FloatArray | None]) -> FloatArray | None:
    """The triangles of a mesh file as poses (K, 3, 4), K >= 2; None where it cannot be drawn, so that its box is."""
    if file is None:
        return None
    if file not in meshes:
        loaded = load_mesh(file)
        meshes[file] = None if loaded is None else triangle_poses(loaded[0][loaded[1]])
    found = meshes[file]
    return found if found is not None and len(found) > 1 else None


def load_mesh(file: str) -> tuple[FloatArray, IntArray] | None:
    """Vertices (V, 3) and triangles (F, 3) of a mesh file through trimesh; None where it is no readable mesh."""
    from scenelang.backends.base import need

    trimesh = need("trimesh", "trimesh")
    try:
        mesh = trimesh.load(file, force="mesh")
        vertices, faces = np.asarray(mesh.vertices, np.float64), np.asarray(mesh.faces, np.int64)
    except Exception:  # a reader of foreign files may raise anything
        return None
    if not len(faces) or not np.isfinite(vertices).all():
        return None
    return vertices, faces


def triangle_poses(corners: FloatArray) -> FloatArray:
    """Poses (K, 3, 4) of the canonical triangle for ``corners`` (F, 3, 3), without the triangles of no area."""
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    normal = np.cross(b - a, c - a)
    length = np.linalg.norm(normal, axis=1)
    edge = np.maximum(np.linalg.norm(b - a, axis=1), np.linalg.norm(c - a, axis=1))
    kept = length > 1e-12 * edge * edge
    thin = normal[kept] / length[kept, None] * (1e-3 * edge[kept, None])
    a, b, c = a[kept], b[kept], c[kept]
    return np.stack([(b - a) / 2.0, (c - a) / 2.0, thin, (b + c) / 2.0], axis=2)


def _is_semantic(entity: Entity) -> bool:
    return entity.shape is not None and entity.shape.kind is Kind.BOX


def look_of(entity: Entity) -> Look:
    """The look that a primitive's attributes ask for; raises SceneError("attribute") where they make none.

    Semantic primitives and blocks without ``:color`` have a stable tint of their word or block type.
    """
    attributes, shape = entity.embedding.attributes, entity.shape
    color = shape.color if shape is not None else (1.0, 1.0, 1.0)
    if attributes.get("color") is None and shape is not None:
        if shape.kind is Kind.BOX:
            color = tint(entity.word, 0.34, 0.93)
        elif shape.kind is Kind.CUBOID:
            color = tint(str(attributes.get("block-type", "")), 0.45, 0.80)
    opacity = _numbers_in(entity.word, "opacity", attributes.get("opacity"), (1,), (1.0,))[0]
    glow = _numbers_in(entity.word, "emission", attributes.get("emission"), (1, 3), (0.0, 0.0, 0.0))
    if len(glow) == 1:
        glow = tuple(glow[0] * channel for channel in color)
    red, green, blue = (max(0.0, channel) for channel in glow)
    return Look(color, (red, green, blue), min(1.0, max(0.0, opacity)))


def tint(text: str, saturation: float, value: float) -> Point:
    """A colour of ``text``'s own, the same on every machine: linear sRGB of the given HSV saturation and value."""
    hue = int.from_bytes(hashlib.blake2s(text.encode("utf-8", "surrogatepass"), digest_size=4).digest(), "big") / 2**32
    red, green, blue = from_srgb(np.array(colorsys.hsv_to_rgb(hue, saturation, value))).tolist()
    return (red, green, blue)


def _numbers_in(
    word: str, name: str, value: Any, lengths: Iterable[int], default: tuple[float, ...]
) -> tuple[float, ...]:
    """The attribute ``value`` as one of ``lengths`` many finite floats."""
    if value is None:
        return default
    numbers = _listed(value)
    try:
        floats = tuple(float(number) for number in numbers)
    except (TypeError, ValueError, OverflowError):
        floats = ()
    if len(floats) not in tuple(lengths) or not np.isfinite(floats).all() or any(isinstance(n, str) for n in numbers):
        wanted = " or ".join("a number" if length == 1 else f"{length} numbers" for length in lengths)
        raise SceneError("attribute", f'the attribute `:{name}` of "{word}" must be {wanted}')
    return floats


def _listed(value: Any) -> Sequence[Any]:
    if isinstance(value, tuple):
        return value
    if type(value) is Pair:
        return list_items(value)
    if isinstance(value, MutableList):
        return value.items
    if isinstance(value, (Array, MutableArray)):
        items: list[Any] = value.data.ravel().tolist()
        return items
    return (value,)


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
        doubtful = np.flatnonzero(sound & (_thickness(matrices) < 2.0 * _THINNEST))
    if len(doubtful):
        linear, alive = _thickened(matrices[doubtful, :, :3])
        matrices[doubtful, :, :3] = linear
        sound[doubtful] &= alive
    return replace(solids, matrices=matrices).take(sound) if not sound.all() else replace(solids, matrices=matrices)


def _thickness(matrices: FloatArray) -> FloatArray:
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
