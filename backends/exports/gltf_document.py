"""A glTF 2.0 file under construction: arrays, meshes and materials, each once."""

from __future__ import annotations

import json
import struct
from collections.abc import Hashable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.exports.surfaces import SEGMENTS, ExportSurface, Solid, merged
from scenelang.backends.pictures.appearance import Look
from scenelang.interpreter.scene.entity import Entity

_ARRAY_BUFFER, _ELEMENT_BUFFER = 34962, 34963
_COMPONENTS = {"float32": 5126, "uint32": 5125, "uint16": 5123}
_LARGEST = 2**32 - 1


@dataclass(slots=True)
class GltfDocument:
    """The parts of the file, and what it already holds, so that it is shared."""

    segments: int = SEGMENTS
    nodes: list[dict[str, Any]] = field(default_factory=list)
    meshes: list[dict[str, Any]] = field(default_factory=list)
    materials: list[dict[str, Any]] = field(default_factory=list)
    accessors: list[dict[str, Any]] = field(default_factory=list)
    views: list[dict[str, Any]] = field(default_factory=list)
    animations: list[dict[str, Any]] = field(default_factory=list)
    chunks: list[bytes] = field(default_factory=list)
    size: int = 0
    _surfaces: dict[Hashable, dict[str, Any] | None] = field(default_factory=dict)
    _mesh_numbers: dict[Hashable, int | None] = field(default_factory=dict)
    _material_numbers: dict[Look, int] = field(default_factory=dict)

    # --- meshes ---

    def solid_mesh(self, word: str, solid: Solid, look: Look) -> int | None:
        """The number of the mesh that a primitive shares, None where nothing is seen of it."""
        key = (solid.key, look)
        if key not in self._mesh_numbers:
            self._mesh_numbers[key] = self._add_solid(word, solid, look)
        return self._mesh_numbers[key]

    def _add_solid(self, word: str, solid: Solid, look: Look) -> int | None:
        if look.opacity == 0.0:
            return None
        if solid.key not in self._surfaces:
            surface = solid.surface(SEGMENTS)
            self._surfaces[solid.key] = None if surface is None else self._add_surface(surface)
        geometry = self._surfaces[solid.key]
        if geometry is None:
            return None
        said = None if solid.form is None else solid.form.gltf(solid.ratios)
        return self._add_mesh(word, [geometry | {"material": self._material(look)}], said)

    def merged_mesh(self, entity: Entity) -> int | None:
        """The number of the one mesh of all that is below ``entity``, None where nothing is seen of it."""
        key = id(entity)
        if key not in self._mesh_numbers:
            patches = [
                self._add_surface(patch.surface) | {"material": self._material(patch.look)}
                for patch in merged(entity, self.segments)
            ]
            self._mesh_numbers[key] = self._add_mesh(entity.word, patches) if patches else None
        return self._mesh_numbers[key]

    def _add_mesh(self, name: str, primitives: list[dict[str, Any]], extras: dict[str, Any] | None = None) -> int:
        more = {} if extras is None else {"extras": extras}
        self.meshes.append({"name": name, "primitives": primitives} | more)
        return len(self.meshes) - 1

    def _add_surface(self, surface: ExportSurface) -> dict[str, Any]:
        attributes = {
            "POSITION": self.add_array(surface.vertices.astype(np.float32), "VEC3", _ARRAY_BUFFER),
            "NORMAL": self.add_array(surface.normals.astype(np.float32), "VEC3", _ARRAY_BUFFER),
        }
        if surface.colors is not None:
            shades = np.full((len(surface.colors), 4), 65535, np.uint16)  # linear; 8 bits would band in the dark
            shades[:, :3] = np.rint(np.clip(surface.colors, 0.0, 1.0) * 65535.0)
            attributes["COLOR_0"] = self.add_array(shades, "VEC4", _ARRAY_BUFFER, normalized=True)
        small = len(surface.vertices) < 65535
        indices = surface.faces.astype(np.uint16 if small else np.uint32).reshape(-1)
        return {"attributes": attributes, "indices": self.add_array(indices, "SCALAR", _ELEMENT_BUFFER)}

    # --- arrays ---

    def add_array(self, array: npt.NDArray[Any], kind: str, target: int | None = None, normalized: bool = False) -> int:
        """The number of a new accessor for ``array``, one element a row."""
        data = array.tobytes()
        data += b"\0" * (-len(data) % 4)
        view: dict[str, Any] = {"buffer": 0, "byteOffset": self.size, "byteLength": array.nbytes}
        accessor: dict[str, Any] = {
            "bufferView": len(self.views),
            "componentType": _COMPONENTS[array.dtype.name],
            "count": len(array),
            "type": kind,
            "min": np.atleast_1d(array.min(axis=0)).tolist(),
            "max": np.atleast_1d(array.max(axis=0)).tolist(),
        }
        if target is not None:
            view["target"] = target
        if normalized:
            accessor["normalized"] = True
        self.views.append(view)
        self.accessors.append(accessor)
        self.chunks.append(data)
        self.size += len(data)
        return len(self.accessors) - 1

    # --- materials ---

    def _material(self, look: Look) -> int:
        if look not in self._material_numbers:
            self._material_numbers[look] = len(self.materials)
            self.materials.append(material(look))
        return self._material_numbers[look]

    # --- the file ---

    def to_json(self, name: str, uri: str | None = None) -> bytes:
        """The JSON document; ``uri`` is where the binary buffer is, None for the chunk of the same file."""
        buffer: dict[str, Any] = {"byteLength": self.size} | ({"uri": uri} if uri is not None else {})
        used = {name for made in self.materials for name in made.get("extensions", ())}
        document: dict[str, Any] = {
            "asset": {"version": "2.0", "generator": _generator()},
            "scene": 0,
            "scenes": [{"name": name, "nodes": [0]}],
            "nodes": self.nodes,
            "meshes": self.meshes,
            "materials": self.materials,
            "animations": self.animations,
            "accessors": self.accessors,
            "bufferViews": self.views,
            "buffers": [buffer] if self.size else [],
            "extensionsUsed": sorted(used),
        }
        filled = {key: value for key, value in document.items() if value != []}
        return json.dumps(filled, separators=(",", ":"), ensure_ascii=True, allow_nan=False).encode()

    def to_glb(self, name: str) -> list[bytes]:
        """The pieces of a .glb file: a header, the JSON chunk and the binary chunk."""
        text = self.to_json(name)
        text += b" " * (-len(text) % 4)
        parts = [struct.pack("<II", len(text), 0x4E4F534A), text]
        if self.size:
            parts += [struct.pack("<II", self.size, 0x004E4942), *self.chunks]
        total = 12 + sum(map(len, parts))
        return [struct.pack("<4sII", b"glTF", 2, total), *parts]

    @property
    def is_too_large(self) -> bool:
        """True when the arrays alone are more than a .glb file can hold."""
        return self.size > _LARGEST


def material(look: Look) -> dict[str, Any]:
    """The glTF material of a look; its factors are linear, as colours are."""
    made: dict[str, Any] = {
        "pbrMetallicRoughness": {
            "baseColorFactor": [*look.color, look.opacity],
            "metallicFactor": look.metallic,
            "roughnessFactor": look.gloss,
        },
        "doubleSided": True,
    }
    if look.opacity < 1.0:
        made["alphaMode"] = "BLEND"
    extensions: dict[str, Any] = {}
    brightest = max(look.emission)
    if brightest > 0.0:
        strength = max(1.0, brightest)
        made["emissiveFactor"] = [channel / strength for channel in look.emission]
        if strength > 1.0:
            extensions["KHR_materials_emissive_strength"] = {"emissiveStrength": strength}
    if look.ior is not None:
        extensions["KHR_materials_ior"] = {"ior": look.ior}
    return made | ({"extensions": extensions} if extensions else {})


def _generator() -> str:
    from importlib.metadata import PackageNotFoundError, version

    try:
        return f"scenelang {version('scenelang')}"
    except PackageNotFoundError:
        return "scenelang"
