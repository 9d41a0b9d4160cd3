"""Export as binary glTF 2.0: the hierarchy of entities as nodes, named by their words.

Every instance of an entity is a node; geometry is shared: one set of vertices per distinct shape, one mesh per distinct
shape and look. glTF poses are a translation, a rotation and a scale, so a pose A that shears is split into a parent
(t, U, S) and a child V' by the singular value decomposition A = U S V'. glTF is right-handed with +y up, as scenes are.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.appearance import Look, look_of
from scenelang.backends.assets import load_asset
from scenelang.backends.base import Backend, Options, Work, frame_of
from scenelang.backends.files import written_whole
from scenelang.backends.meshes import posed, unit_mesh
from scenelang.backends.solids import Form, local_pose
from scenelang.grammar.diagnostics import LimitError, SceneError
from scenelang.interpreter.bounds import entity_box
from scenelang.interpreter.entity import Entity, Scene, count_words
from scenelang.interpreter.shapes import Kind, Shape
from scenelang.interpreter.values import IDENTITY, Matrix

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]

MOST_NODES = 250_000
SEGMENTS = 64
_ARRAY_BUFFER, _ELEMENT_BUFFER = 34962, 34963
_FLOAT, _UINT = 5126, 5125
_SQUARE = 1e-6  # cosine between two axes of a pose below which it does not shear


def export(scene: Scene, path: Path | str, options: Options | None = None) -> None:
    """Write one frame of ``scene`` to ``path`` as GLB, whole or not at all.

    Raises SceneError: "empty-scene" when there is no geometry, "file" when the file cannot be written; LimitError when
    the scene expands to more than ``MOST_NODES`` instances of entities.
    """
    options = options or Options()
    root = scene.frames[frame_of(scene, options.frame)]
    if entity_box(root) is None:
        raise SceneError("empty-scene", f'the scene "{scene.word}" has no primitives, so there is nothing to export')
    instances = sum(count_words(root).values())
    if instances > MOST_NODES:
        raise LimitError(
            "primitives",
            f"the scene expands to {instances:,} entities, more than the {MOST_NODES:,} nodes that a GLB file may have",
            hint="export a part of the scene; pictures have no such limit",
        )
    document = _Document()
    _add_nodes(document, root)
    data = document.to_bytes(scene.word)
    if options.progress is not None:
        options.progress(0.9)
    with written_whole(path) as temporary:
        temporary.write_bytes(data)
    if options.progress is not None:
        options.progress(1.0)


@dataclass(slots=True)
class _Document:
    """The glTF file under construction, and what it already holds, so that it is shared."""

    nodes: list[dict[str, Any]] = field(default_factory=list)
    meshes: list[dict[str, Any]] = field(default_factory=list)
    materials: list[dict[str, Any]] = field(default_factory=list)
    accessors: list[dict[str, Any]] = field(default_factory=list)
    views: list[dict[str, Any]] = field(default_factory=list)
    chunks: list[bytes] = field(default_factory=list)
    size: int = 0
    geometry: dict[tuple[Any, ...], dict[str, Any] | None] = field(default_factory=dict)
    mesh_numbers: dict[tuple[Any, ...], int | None] = field(default_factory=dict)
    material_numbers: dict[Look, int] = field(default_factory=dict)

    def mesh_of(self, entity: Entity) -> int | None:
        """The number of the mesh that a primitive is, None where it has no surface."""
        shape = entity.shape
        if shape is None:
            return None
        look = look_of(entity)
        key = (_geometry_key(shape), look)
        if key not in self.mesh_numbers:
            self.mesh_numbers[key] = self._add_mesh(entity.word, shape, look)
        return self.mesh_numbers[key]

    def _add_mesh(self, word: str, shape: Shape, look: Look) -> int | None:
        key = _geometry_key(shape)
        if key not in self.geometry:
            self.geometry[key] = self._add_geometry(shape)
        geometry = self.geometry[key]
        if geometry is None or look.opacity == 0.0:
            return None
        if look not in self.material_numbers:
            self.material_numbers[look] = len(self.materials)
            self.materials.append(_material(look))
        self.meshes.append({"name": word, "primitives": [geometry | {"material": self.material_numbers[look]}]})
        return len(self.meshes) - 1

    def _add_geometry(self, shape: Shape) -> dict[str, Any] | None:
        made = _geometry(shape)
        if made is None:
            return None
        vertices, normals, faces = made
        attributes = {"POSITION": self._add_array(vertices.astype(np.float32), "VEC3", _ARRAY_BUFFER)}
        if normals is not None:
            attributes["NORMAL"] = self._add_array(normals.astype(np.float32), "VEC3", _ARRAY_BUFFER)
        return {
            "attributes": attributes,
            "indices": self._add_array(faces.astype(np.uint32).reshape(-1), "SCALAR", _ELEMENT_BUFFER),
        }

    def _add_array(self, array: npt.NDArray[Any], kind: str, target: int) -> int:
        data = array.tobytes()  # a multiple of four bytes
        self.views.append({"buffer": 0, "byteOffset": self.size, "byteLength": len(data), "target": target})
        accessor: dict[str, Any] = {
            "bufferView": len(self.views) - 1,
            "componentType": _FLOAT if array.dtype == np.float32 else _UINT,
            "count": len(array),
            "type": kind,
            "min": np.atleast_1d(array.min(axis=0)).tolist(),
            "max": np.atleast_1d(array.max(axis=0)).tolist(),
        }
        self.accessors.append(accessor)
        self.chunks.append(data)
        self.size += len(data)
        return len(self.accessors) - 1

    def to_bytes(self, name: str) -> bytes:
        """The file: a header, the JSON chunk and the binary chunk."""
        from importlib.metadata import PackageNotFoundError, version

        try:
            generator = f"scenelang {version('scenelang')}"
        except PackageNotFoundError:
            generator = "scenelang"
        document: dict[str, Any] = {
            "asset": {"version": "2.0", "generator": generator},
            "scene": 0,
            "scenes": [{"name": name, "nodes": [0]}],
            "nodes": self.nodes,
            "meshes": self.meshes,
            "materials": self.materials,
            "accessors": self.accessors,
            "bufferViews": self.views,
            "buffers": [{"byteLength": self.size}],
        }
        if any("extensions" in material for material in self.materials):
            document["extensionsUsed"] = ["KHR_materials_emissive_strength"]
        document = {key: value for key, value in document.items() if value != []}
        if not self.size:
            del document["buffers"]
        text = json.dumps(document, separators=(",", ":"), ensure_ascii=True).encode()
        text += b" " * (-len(text) % 4)
        binary = b"".join(self.chunks)
        parts = [struct.pack("<II", len(text), 0x4E4F534A), text]
        if binary:
            parts += [struct.pack("<II", len(binary), 0x004E4942), binary]
        total = 12 + sum(map(len, parts))
        return b"".join([struct.pack("<4sII", b"glTF", 2, total), *parts])


# --- nodes -----------------------------------------------------------------------------------------------------


def _add_nodes(document: _Document, root: Entity) -> None:
    """One node per instance below and including ``root``, without recursion."""
    poses: dict[Matrix, list[dict[str, Any]]] = {}
    waiting: list[tuple[Entity, Matrix, list[int] | None]] = [(root, IDENTITY, None)]
    while waiting:
        entity, pose, siblings = waiting.pop()
        if pose not in poses:
            poses[pose] = node_poses(pose)
        outer, *inner = poses[pose]
        node = {"name": entity.word, **outer, "extras": _extras(entity)}
        if siblings is not None:
            siblings.append(len(document.nodes))
        document.nodes.append(node)
        for more in inner:
            node["children"] = [len(document.nodes)]
            node = {"name": f"{entity.word}/shear", **more}
            document.nodes.append(node)
        mesh = document.mesh_of(entity)
        if mesh is not None:
            node["mesh"] = mesh
        if entity.children:
            children: list[int] = []
            node["children"] = children
            waiting.extend((part.car, part.cdr, children) for part in reversed(entity.children))


def _extras(entity: Entity) -> dict[str, Any]:
    embedding = entity.embedding
    given = {"word": entity.word, "handle": embedding.handle, "text": embedding.text}
    return {name: value for name, value in given.items() if value is not None}


def node_poses(pose: Sequence[float]) -> list[dict[str, Any]]:
    """One glTF node pose, or a parent's and a child's where the affine ``pose`` (12 floats) shears or flattens."""
    matrix = np.array(pose).reshape(3, 4)
    linear = matrix[:, :3]
    move: dict[str, Any] = {"translation": matrix[:, 3].tolist()} if matrix[:, 3].any() else {}
    size = np.linalg.norm(linear, axis=0)
    if (size > 0.0).all():
        turned = linear / size
        products = turned.T @ turned
        if max(abs(products[0, 1]), abs(products[0, 2]), abs(products[1, 2])) < _SQUARE:
            if np.linalg.det(turned) < 0.0:
                turned[:, 0], size[0] = -turned[:, 0], -size[0]
            return [move | _turn_and_scale(turned, size)]
    u, s, vt = np.linalg.svd(linear)
    sign = np.linalg.det(u) * np.linalg.det(vt)
    u, vt = u * np.sign(np.linalg.det(u)), vt * np.sign(np.linalg.det(vt))
    return [move | _turn_and_scale(u, s if sign > 0 else -s), _turn_and_scale(vt, np.ones(3))]


def _turn_and_scale(rotation: FloatArray, scale: FloatArray) -> dict[str, Any]:
    out: dict[str, Any] = {}
    if not np.array_equal(rotation, np.eye(3)):
        out["rotation"] = _quaternion(rotation)
    if not np.array_equal(scale, np.ones(3)):
        out["scale"] = scale.tolist()
    return out


def _quaternion(r: FloatArray) -> list[float]:
    """The unit quaternion (x, y, z, w) of a rotation matrix: the row of 4 q q' with the largest diagonal."""
    outer = np.array([
        [1 + r[0, 0] - r[1, 1] - r[2, 2], r[0, 1] + r[1, 0], r[0, 2] + r[2, 0], r[2, 1] - r[1, 2]],
        [r[0, 1] + r[1, 0], 1 - r[0, 0] + r[1, 1] - r[2, 2], r[1, 2] + r[2, 1], r[0, 2] - r[2, 0]],
        [r[0, 2] + r[2, 0], r[1, 2] + r[2, 1], 1 - r[0, 0] - r[1, 1] + r[2, 2], r[1, 0] - r[0, 1]],
        [r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1], 1 + r[0, 0] + r[1, 1] + r[2, 2]],
    ])  # fmt: skip
    q = outer[int(np.argmax(np.diag(outer)))]
    unit: list[float] = (q / np.linalg.norm(q)).tolist()
    return unit


# --- meshes ----------------------------------------------------------------------------------------------------


def _geometry_key(shape: Shape) -> tuple[Any, ...]:
    """What the vertices of ``shape`` depend on."""
    kind = Kind.CUBE if shape.kind is Kind.BOX else shape.kind
    return (kind, shape.size, shape.radius, shape.p0, shape.p1, shape.file, shape.box)


def _geometry(shape: Shape) -> tuple[FloatArray, FloatArray | None, IntArray] | None:
    """Vertices, normals and faces of ``shape`` in the primitive's own frame; None where it has no surface."""
    if shape.kind is Kind.ASSET:
        if shape.file is not None:
            mesh = load_asset(shape.file)
            return mesh.vertices, None, mesh.faces
        x0, y0, z0, x1, y1, z1 = shape.box or (0.0, 0.0, 0.0, *shape.size)
        middle = np.array([x0 + x1, y0 + y1, z0 + z1]) / 2.0
        half = np.array([x1 - x0, y1 - y0, z1 - z0]) / 2.0
        return _checked(Form.BLOCK, np.concatenate([np.diag(half), middle[:, None]], axis=1))
    found = local_pose(shape)
    return None if found is None else _checked(*found)


def _checked(form: Form, pose: FloatArray) -> tuple[FloatArray, FloatArray, IntArray]:
    vertices, normals, faces = posed(unit_mesh(form, SEGMENTS), pose[None])
    normals[~normals.any(axis=1)] = (0.0, 1.0, 0.0)  # faces without an area have no normal
    return vertices, normals, faces


def _material(look: Look) -> dict[str, Any]:
    material: dict[str, Any] = {
        "pbrMetallicRoughness": {
            "baseColorFactor": [*look.color, look.opacity],
            "metallicFactor": 0.0,
            "roughnessFactor": 0.8,
        },
        "doubleSided": True,
    }
    if look.opacity < 1.0:
        material["alphaMode"] = "BLEND"
    brightest = max(look.emission)
    if brightest > 0.0:
        strength = max(1.0, brightest)
        material["emissiveFactor"] = [channel / strength for channel in look.emission]
        if strength > 1.0:
            material["extensions"] = {"KHR_materials_emissive_strength": {"emissiveStrength": strength}}
    return material


def _run(scene: Scene, path: Path, options: Options) -> None:
    export(scene, path, options)


GLB = Backend(
    name="glb",
    doc="binary glTF 2.0 with the hierarchy of entities, for other 3D programs",
    work=Work.EXPORT,
    endings=(".glb",),
    run=_run,
)
