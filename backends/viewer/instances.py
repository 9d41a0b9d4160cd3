"""Instances for the page: geometries, one row per primitive entity, and the rows that each frame shows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.appearance import GLASS, look_of
from scenelang.backends.assets import load_asset
from scenelang.backends.meshes import triangle_normals, unit_mesh
from scenelang.backends.solids import Form, composed, is_semantic, local_pose
from scenelang.interpreter.entity import Entity, Scene
from scenelang.interpreter.flatten import FlatFrame, flatten
from scenelang.interpreter.shapes import Kind

FloatArray = npt.NDArray[np.float64]
_File = tuple[str, str | None, bool]  # a mesh file, the folder of what it refers to, and whether in its own colours
IntArray = npt.NDArray[np.int64]

# Round solids come with two numbers of sides: what is small in the picture is drawn with the few.
_MANY_SIDES, _FEW_SIDES = 64, 8
_ALL_FINE = 300  # up to so many instances none needs to be coarse
MATTE = -1.0  # the roughness of a surface that asks for none


@dataclass(frozen=True, slots=True, eq=False)
class Geometry:
    """A mesh in its own frame: ``positions`` and ``normals`` (3 V), ``indices`` (3 F), and where it has colours of its
    own ``colors`` (3 V), linear sRGB. ``is_closed``: a canonical solid, without holes.
    ``coarse`` is the number of the geometry that stands for it where it is small."""

    positions: npt.NDArray[np.float32]
    normals: npt.NDArray[np.float32]
    indices: npt.NDArray[np.uint32]
    colors: npt.NDArray[np.float32] | None = None
    is_closed: bool = True
    coarse: int | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Instances:
    """``columns`` by name.

    Per primitive entity: ``primitiveNode`` (its node of the DAG), ``primitiveGeometry`` (-1: nothing is drawn),
    ``primitiveLook`` (12 floats: colour, opacity, emission, ior, roughness, metallic, is-semantic, 0). Per row:
    ``rowPrimitive``, ``rowPath`` (into ``paths``), ``rowPose`` (12 floats, row-major). Per frame: rows
    ``frameRow[frameStart[f]:frameStart[f + 1]]`` in depth-first order.
    """

    geometries: tuple[Geometry, ...]
    paths: tuple[tuple[str, ...], ...]
    columns: dict[str, npt.NDArray[Any]]


@dataclass(frozen=True, slots=True, eq=False)
class _Rows:
    """The instances of all frames, one after the other; ``start`` (F + 1) says where each frame begins."""

    primitives: list[Entity]
    primitive: IntArray
    paths: list[tuple[str, ...]]
    path: IntArray
    matrices: FloatArray
    start: IntArray


def instances_of(scene: Scene, center: FloatArray, scale: float, node_of: dict[int, int]) -> Instances:
    """The instances of every frame of ``scene`` under ``p -> scale (p - center)``.

    ``node_of`` maps ``id(entity)`` to its number in the DAG. Raises SceneError where a pose or a look makes no sense.
    """
    rows = _joined(flatten(scene).frames)
    used = np.bincount(rows.primitive, minlength=len(rows.primitives))
    geometries, geometry_of, local = _geometries(rows.primitives, used)
    poses = composed(rows.matrices, local[rows.primitive])
    poses[:, :, 3] -= center
    poses *= scale
    flat = poses.reshape(-1, 12).astype(np.float32)
    kept, row_of = _distinct_rows(flat, rows) if len(rows.start) > 2 else (slice(None), np.arange(len(flat)))
    columns: dict[str, npt.NDArray[Any]] = {
        "primitiveNode": np.array([node_of[id(entity)] for entity in rows.primitives], np.int32),
        "primitiveGeometry": geometry_of,
        "primitiveLook": _looks(rows.primitives),
        "rowPrimitive": rows.primitive[kept].astype(np.int32),
        "rowPath": rows.path[kept].astype(np.int32),
        "rowPose": flat[kept].reshape(-1),
        "frameStart": rows.start.astype(np.uint32),
        "frameRow": row_of.astype(np.uint32),
    }
    return Instances(tuple(geometries), tuple(rows.paths), columns)


def _joined(frames: Sequence[FlatFrame]) -> _Rows:
    """The instances of ``frames``; primitives and paths of several frames are numbered together."""
    primitives: dict[int, int] = {}
    entities: list[Entity] = []
    paths: dict[tuple[str, ...], int] = {}
    primitive, path = [], []
    for frame in frames:
        for entity in frame.primitives:
            if id(entity) not in primitives:
                primitives[id(entity)] = len(entities)
                entities.append(entity)
        here = np.array([primitives[id(entity)] for entity in frame.primitives], np.int64)
        there = np.array([paths.setdefault(words, len(paths)) for words in frame.paths], np.int64)
        primitive.append(here[frame.index] if len(frame) else np.zeros(0, np.int64))
        path.append(there[frame.path_index] if len(frame) else np.zeros(0, np.int64))
    start = np.cumsum([0, *(len(frame) for frame in frames)])
    matrices = np.concatenate([frame.matrices for frame in frames])
    return _Rows(entities, np.concatenate(primitive), list(paths), np.concatenate(path), matrices, start)


def _distinct_rows(flat: npt.NDArray[np.float32], rows: _Rows) -> tuple[IntArray, IntArray]:
    """The first of each set of equal rows, and for every instance the place of its row among these."""
    keys = np.empty((len(flat), 14), np.uint32)
    keys[:, :12] = (flat + np.float32(0.0)).view(np.uint32)  # no negative zeros
    keys[:, 12], keys[:, 13] = rows.primitive, rows.path
    odd = np.random.RandomState(0).randint(0, 1 << 62, 14).astype(np.uint64) * np.uint64(2) + np.uint64(1)
    hashed = (keys.astype(np.uint64) * odd).sum(axis=1, dtype=np.uint64)
    _, first, place = np.unique(hashed, return_index=True, return_inverse=True)
    if not (keys[first[place]] == keys).all():  # two rows with one hash: compare them whole
        _, first, place = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    return first.astype(np.int64), place.reshape(-1).astype(np.int64)


def _looks(primitives: Sequence[Entity]) -> npt.NDArray[np.float32]:
    table = np.zeros((len(primitives), 12), np.float32)
    for row, entity in zip(table, primitives, strict=True):
        look = look_of(entity)
        row[:3], row[3], row[4:7] = look.color, look.opacity, look.emission
        row[7], row[8], row[9] = look.ior or GLASS, MATTE if look.is_matte else look.gloss, look.metallic
        row[10] = is_semantic(entity)
    return table.reshape(-1)


def _geometries(
    primitives: Sequence[Entity], used: IntArray
) -> tuple[list[Geometry], npt.NDArray[np.int32], FloatArray]:
    """The geometries, the number of each primitive's (-1: none) and its pose in the primitive's frame (P, 3, 4)."""
    geometries: list[Geometry] = []
    numbers: dict[Any, int] = {}
    geometry_of = np.full(len(primitives), -1, np.int32)
    local = np.zeros((len(primitives), 3, 4))
    local[:, [0, 1, 2], [0, 1, 2]] = 1.0
    for i, entity in enumerate(primitives):
        key, pose = _geometry_key(entity)
        if key is None:
            continue
        if key not in numbers:
            numbers[key] = _add(geometries, key, int(used.sum()) > _ALL_FINE)
        geometry_of[i], local[i] = numbers[key], pose
    return geometries, geometry_of, local


def _add(geometries: list[Geometry], key: Form | _File, has_coarse: bool) -> int:
    """Add the geometry of ``key``, and before it its coarse one where that is another; its number."""
    if not isinstance(key, Form):
        geometries.append(_asset(*key))
    elif key == Form.BLOCK or not has_coarse:
        geometries.append(_unit(key, _MANY_SIDES))
    else:
        geometries.append(_unit(key, _FEW_SIDES))
        geometries.append(replace(_unit(key, _MANY_SIDES), coarse=len(geometries) - 1))
    return len(geometries) - 1


def _geometry_key(entity: Entity) -> tuple[Form | _File | None, FloatArray]:
    """What a primitive is drawn as, a canonical solid or a file's mesh (in its own colours or not), and its pose
    (3, 4); None: not at all."""
    shape, identity = entity.shape, np.eye(4)[:3]
    if shape is None or not shape.has_geometry:
        return None, identity
    if shape.kind is Kind.ASSET:
        has_color = entity.embedding.attributes.get("color") is not None
        return (shape.file, shape.root, not has_color) if shape.file is not None else None, identity
    found = local_pose(shape)
    return (None, identity) if found is None else found


def _unit(form: Form, sides: int) -> Geometry:
    mesh = unit_mesh(form, sides)
    return Geometry(
        mesh.vertices.astype(np.float32).reshape(-1),
        mesh.normals.astype(np.float32).reshape(-1),
        mesh.faces.astype(np.uint32).reshape(-1),
    )


def _asset(file: str, root: str | None, own_colors: bool) -> Geometry:
    """The mesh of a file, flat-shaded; raises SceneError("file") when it cannot be read."""
    mesh = load_asset(file, root)
    corners, colors = mesh.corners, mesh.face_colors if own_colors else None
    return Geometry(
        corners.astype(np.float32).reshape(-1),
        np.repeat(triangle_normals(corners), 3, axis=0).astype(np.float32).reshape(-1),
        np.arange(3 * len(corners), dtype=np.uint32),
        None if colors is None else np.repeat(colors, 3, axis=0).astype(np.float32).reshape(-1),
        is_closed=False,
    )
