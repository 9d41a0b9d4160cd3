"""Export to glTF 2.0: .glb as a single file, .gltf with its buffer in a .bin file."""

from __future__ import annotations

import json
import re
import struct
from collections import Counter
from collections.abc import Callable, Hashable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from urllib.parse import quote

import numpy as np
import numpy.typing as npt

from scenelang.backends.base import Option, require
from scenelang.backends.exports.export import (
    FPS,
    INSTANCES,
    INSTANCING,
    SIDES,
    TOLERANCE,
    Job,
    Moving,
    facts_of,
    fineness,
    leaf_counts,
    matched,
    merged_facts,
    merged_sides,
    mesh_backend,
    variants,
)
from scenelang.backends.exports.gltf_setup import LIGHTS, camera_nodes, light_nodes
from scenelang.backends.exports.plan import (
    COAT_ROUGHNESS,
    SEGMENTS,
    ExportItem,
    ExportPlan,
    ExportSurface,
    Solid,
    as_material,
    cut_below,
    distinct,
    merged,
    shared,
    solid_of,
)
from scenelang.backends.surfaces.appearance import Look, look_of, material_name
from scenelang.backends.surfaces.precision import about, common_offset, size_of
from scenelang.backends.surfaces.solids import composed
from scenelang.backends.surfaces.tiles import normals_png, pictured, tile_of
from scenelang.backends.surfaces.trs import Decomposition, decompose, decompose_track
from scenelang.grammar.diagnostics import LimitError
from scenelang.interpreter.scene import pose
from scenelang.interpreter.scene.entity import Entity, Scene
from scenelang.interpreter.scene.primitives.textures import Texture
from scenelang.interpreter.values.values import IDENTITY, Matrix

# A glTF 2.0 document under construction; arrays, meshes and materials are deduplicated.


_ARRAY_BUFFER, _ELEMENT_BUFFER = 34962, 34963
_COMPONENTS = {"float32": 5126, "uint32": 5125, "uint16": 5123}
_MAX_GLB_BYTES = 2**32 - 1  # bytes of a GLB file, whose lengths are 32-bit integers


PlacedMesh = tuple[Matrix, int]  # the pose of a mesh in its node, the identity unless it is far away, and its index


@dataclass(slots=True)
class GltfDocument:
    """The elements of the file, with the tables that deduplicate them."""

    segments: int = SEGMENTS  # of merged meshes
    shares: bool = False  # whether the faces of primitives share points; then they are flat, without normals
    compresses: bool = False  # whether meshes are compressed by Draco
    required: set[str] = field(default_factory=set)
    nodes: list[dict[str, Any]] = field(default_factory=list)
    meshes: list[dict[str, Any]] = field(default_factory=list)
    materials: list[dict[str, Any]] = field(default_factory=list)
    accessors: list[dict[str, Any]] = field(default_factory=list)
    views: list[dict[str, Any]] = field(default_factory=list)
    animations: list[dict[str, Any]] = field(default_factory=list)
    cameras: list[dict[str, Any]] = field(default_factory=list)
    lights: list[dict[str, Any]] = field(default_factory=list)
    beside: list[int] = field(default_factory=list)  # nodes of cameras and lights, beside the scene's root
    chunks: list[bytes] = field(default_factory=list)
    size: int = 0
    _surfaces: dict[Hashable, dict[str, Any] | None] = field(default_factory=dict)
    _mesh_numbers: dict[Hashable, int | None] = field(default_factory=dict)
    _merged: dict[tuple[int, float | None], list[PlacedMesh]] = field(default_factory=dict)
    images: list[dict[str, Any]] = field(default_factory=list)
    textures: list[dict[str, Any]] = field(default_factory=list)
    _material_numbers: dict[Look, int] = field(default_factory=dict)
    _material_names: Counter[str] = field(default_factory=Counter)
    _texture_numbers: dict[tuple[Texture, bool], int] = field(default_factory=dict)

    # --- meshes ---

    def solid_mesh(self, word: str, solid: Solid, look: Look, segments: int = SEGMENTS) -> int | None:
        """Return the index of a primitive's shared mesh, None if it is invisible."""
        key = (solid.key_with(look), segments)
        if key not in self._mesh_numbers:
            self._mesh_numbers[key] = self._add_solid(word, solid, look, segments)
        return self._mesh_numbers[key]

    def _add_solid(self, word: str, solid: Solid, look: Look, segments: int) -> int | None:
        """Add the shared mesh of a primitive with its look; return its index, None if it is invisible."""
        if look.opacity == 0.0:
            return None
        key = solid.key_in(look.texture), segments
        if key not in self._surfaces:
            surface = solid.surface(segments, look.texture)
            if surface is not None and self.shares:
                surface = shared(surface)
            self._surfaces[key] = self._add_surface(surface) if surface is not None and len(surface.faces) else None
        geometry = self._surfaces[key]
        if geometry is None:
            return None
        extras = None if solid.form is None else solid.form.gltf(solid.ratios)
        return self._add_mesh(word, [geometry | {"material": self._material(look)}], extras)

    def merged_meshes(self, entity: Entity, tolerance: float | None = None) -> list[PlacedMesh]:
        """Return the merged meshes of all primitives below ``entity``; none if it is invisible.

        They are one mesh about the entity's origin, or several about offsets if single precision cannot hold all in
        one.
        """
        key = id(entity), tolerance
        if key not in self._merged:
            groups: dict[Matrix, list[dict[str, Any]]] = {}
            for patch in merged(entity, self.segments, tolerance):
                primitive = self._add_surface(patch.surface) | {"material": self._material(patch.look)}
                groups.setdefault(patch.pose, []).append(primitive)
            self._merged[key] = [(place, self._add_mesh(entity.word, group)) for place, group in groups.items()]
        return self._merged[key]

    def _add_mesh(self, name: str, primitives: list[dict[str, Any]], extras: dict[str, Any] | None = None) -> int:
        """Add a mesh and return its index."""
        more = {} if extras is None else {"extras": extras}
        self.meshes.append({"name": name, "primitives": primitives} | more)
        return len(self.meshes) - 1

    def _add_surface(self, surface: ExportSurface) -> dict[str, Any]:
        """Add the arrays of a surface and return the fields of its glTF primitive."""
        columns: dict[str, npt.NDArray[Any]] = {"POSITION": surface.vertices.astype(np.float32)}
        if not self.shares:
            columns["NORMAL"] = surface.normals.astype(np.float32)
        if surface.colors is not None:
            # linear; 8 bits would cause banding in dark colors
            shades = np.full((len(surface.colors), 4), 65535, np.uint16)
            shades[:, :3] = np.rint(np.clip(surface.colors, 0.0, 1.0) * 65535.0)
            columns["COLOR_0"] = shades
        if surface.uv is not None:
            downward = surface.uv * [1.0, -1.0] + [0.0, 1.0]  # v grows downwards in glTF
            columns["TEXCOORD_0"] = downward.astype(np.float32)
        small = len(surface.vertices) < 65535
        indices = surface.faces.astype(np.uint16 if small else np.uint32).reshape(-1)
        if self.compresses and _has_area(columns["POSITION"], indices):
            return self._compressed(columns, indices)
        attributes = {
            name: self.add_array(column, f"VEC{column.shape[1]}", _ARRAY_BUFFER, name == "COLOR_0")
            for name, column in columns.items()
        }
        return {"attributes": attributes, "indices": self.add_array(indices, "SCALAR", _ELEMENT_BUFFER)}

    def _compressed(self, columns: dict[str, npt.NDArray[Any]], indices: npt.NDArray[Any]) -> dict[str, Any]:
        """Add the columns of a surface as one Draco mesh and return the fields of its glTF primitive.

        Draco may join and sort vertices, so accessors describe what it decodes to.
        """
        data, read, faces = compressed(columns, indices.reshape(-1, 3))
        extension = {"bufferView": self._add_view(data, {}), "attributes": {name: read[name][0] for name in read}}
        self.required.add(DRACO)
        accessors = {
            name: self._add_accessor(column, f"VEC{column.shape[1]}", normalized=name == "COLOR_0")
            for name, (_, column) in read.items()
        }
        numbers = self._add_accessor(faces.reshape(-1).astype(indices.dtype), "SCALAR")
        return {"attributes": accessors, "indices": numbers, "extensions": {DRACO: extension}}

    # --- arrays ---

    def add_array(self, array: npt.NDArray[Any], kind: str, target: int | None = None, normalized: bool = False) -> int:
        """Add an accessor for ``array``, one element per row, and return its index."""
        number = self._add_accessor(array, kind, normalized=normalized)
        view = self._add_view(array.tobytes(), {} if target is None else {"target": target})
        self.accessors[number] = {"bufferView": view} | self.accessors[number]
        return number

    def _add_accessor(self, array: npt.NDArray[Any], kind: str, *, normalized: bool = False) -> int:
        """Add an accessor that describes ``array`` and has no data yet, and return its index."""
        accessor: dict[str, Any] = {
            "componentType": _COMPONENTS[array.dtype.name],
            "count": len(array),
            "type": kind,
            "min": np.atleast_1d(array.min(axis=0)).tolist(),
            "max": np.atleast_1d(array.max(axis=0)).tolist(),
        }
        self.accessors.append(accessor | ({"normalized": True} if normalized else {}))
        return len(self.accessors) - 1

    def _add_view(self, data: bytes, fields: dict[str, int]) -> int:
        """Add bytes to the buffer, with the fields of their view, and return its index."""
        self.views.append({"buffer": 0, "byteOffset": self.size, "byteLength": len(data)} | fields)
        padded = data + b"\0" * (-len(data) % 4)
        self.chunks.append(padded)
        self.size += len(padded)
        return len(self.views) - 1

    # --- materials ---

    def _material(self, look: Look) -> int:
        """Return the index of the material of a look, added on first use."""
        look = as_material(look)
        if look not in self._material_numbers:
            self._material_numbers[look] = len(self.materials)
            fields = material(look)
            if look.texture is not None:
                fields["pbrMetallicRoughness"]["baseColorTexture"] = {"index": self._texture(look.texture)}
                if look.texture.bump:
                    fields["normalTexture"] = {"index": self._texture(look.texture, is_relief=True)}
            same = self._material_names[fields["name"]]
            self._material_names[fields["name"]] += 1
            if same:
                fields["name"] += f".{same:03d}"  # as Blender numbers equal names
            self.materials.append(fields)
        return self._material_numbers[look]

    def _texture(self, texture: Texture, *, is_relief: bool = False) -> int:
        """Return the index of a texture, or of the normals of its relief, whose image is added on first use.

        It repeats by default.
        """
        key = texture if is_relief else pictured(texture), is_relief
        if key not in self._texture_numbers:
            view = self._add_view(normals_png(texture) if is_relief else tile_of(texture).png(), {})
            name = f"{Path(texture.name).stem}{' relief' if is_relief else ''}"
            self.images.append({"name": name, "mimeType": "image/png", "bufferView": view})
            self.textures.append({"source": len(self.images) - 1, **({"sampler": 0} if texture.side else {})})
            self._texture_numbers[key] = len(self.images) - 1
        return self._texture_numbers[key]

    # --- cameras and lights ---

    def add_setup(self, scene: Scene) -> None:
        """Add the cameras and lights that a program declares, as nodes beside the scene's root; raises SceneError."""
        for node, camera in camera_nodes(scene):
            self.beside.append(len(self.nodes))
            self.nodes.append(node | {"camera": len(self.cameras)})
            self.cameras.append(camera)
        for node, light in light_nodes(scene):
            self.beside.append(len(self.nodes))
            self.nodes.append(node | {"extensions": {LIGHTS: {"light": len(self.lights)}}})
            self.lights.append(light)

    # --- names ---

    def name_uniquely(self) -> None:
        """Give every node and every mesh a unique name for three.js; the first of each keeps its word.

        three.js (GLTFLoader, PropertyBinding.sanitizeNodeName) finds animated nodes by names without the characters
        `[].:/`, in which white space is `_`, and numbers equal ones by `_1`, `_2`, ...; it names nodes first, then the
        parts of meshes. So that none of its numbered names is the name of a node, meshes of several parts are named
        after a word with which no node's name begins.
        """
        node_names = {read_name(node["name"]) for node in self.nodes}
        names = _UniqueNames(node_names)
        for node in self.nodes:
            node["name"] = names.fresh(node["name"])
        parts = {name.rpartition("_")[0] for name in names.taken if name.rpartition("_")[2].isdigit()}
        mesh_names = _UniqueNames({read_name(mesh["name"]) for mesh in self.meshes})
        for mesh in self.meshes:
            name = mesh_names.fresh(mesh["name"])
            while len(mesh["primitives"]) > 1 and read_name(name) in parts:
                name = mesh_names.fresh(f"{name} mesh")
            mesh["name"] = name

    # --- the file ---

    def to_json(self, uri: str | None = None) -> bytes:
        """Return the JSON document; ``uri`` locates the binary buffer, None for the chunk of the same file."""
        buffer: dict[str, Any] = {"byteLength": self.size} | ({"uri": uri} if uri is not None else {})
        used = {name for entry in self.materials for name in entry.get("extensions", ())}
        document: dict[str, Any] = {
            "asset": {"version": "2.0", "generator": _generator()},
            "scene": 0,
            "scenes": [{"nodes": [0, *self.beside]}],  # without a name: three.js would number a node of the same one
            "nodes": self.nodes,
            "meshes": self.meshes,
            "materials": self.materials,
            "textures": self.textures,
            "samplers": [_ONCE] if any("sampler" in texture for texture in self.textures) else [],
            "images": self.images,
            "animations": self.animations,
            "cameras": self.cameras,
            "accessors": self.accessors,
            "bufferViews": self.views,
            "buffers": [buffer] if self.size else [],
            "extensionsUsed": sorted(used | self.required | ({LIGHTS} if self.lights else set())),
            "extensionsRequired": sorted(self.required),
            "extensions": {LIGHTS: {"lights": self.lights}} if self.lights else [],
        }
        filled = {key: value for key, value in document.items() if value != []}
        return json.dumps(filled, separators=(",", ":"), ensure_ascii=True, allow_nan=False).encode()

    def to_glb(self) -> list[bytes]:
        """Return the pieces of a .glb file: header, JSON chunk and binary chunk."""
        text = self.to_json()
        text += b" " * (-len(text) % 4)
        parts = [struct.pack("<II", len(text), 0x4E4F534A), text]
        if self.size:
            parts += [struct.pack("<II", self.size, 0x004E4942), *self.chunks]
        total = 12 + sum(map(len, parts))
        return [struct.pack("<4sII", b"glTF", 2, total), *parts]

    @property
    def is_too_large(self) -> bool:
        """Whether the arrays alone exceed the size of a .glb file."""
        return self.size > _MAX_GLB_BYTES


_ONCE = {"wrapS": 33071, "wrapT": 33071}  # sampler of decals: the margin goes on
DRACO = "KHR_draco_mesh_compression"
# Bits of positions and texture coordinates, of the largest extent of a mesh: 16 are .0015 % of it. A ball of 64 sides
# takes a seventh of its space.
_BITS, _NORMAL_BITS, _LEVEL = 16, 10, 7
_KINDS = {
    0: "POSITION",
    1: "NORMAL",
    3: "TEXCOORD_0",
    4: "COLOR_0",
}  # by Draco's types of attributes; 4 is a generic one


def _has_area(points: npt.NDArray[Any], indices: npt.NDArray[Any]) -> bool:
    """Return whether a triangle has an area; Draco refuses a mesh of others, such as that of a flat cube."""
    corners = points[indices.reshape(-1, 3)]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return bool(normals.any())


def compressed(
    columns: dict[str, npt.NDArray[Any]], faces: npt.NDArray[Any]
) -> tuple[bytes, dict[str, tuple[int, npt.NDArray[Any]]], npt.NDArray[Any]]:
    """Return a mesh as Draco writes it, and what it decodes to: by name the id and the column, and the faces."""
    draco = require("DracoPy", "'scenelang[draco]'")
    others = {name: columns[key].astype(np.float64) for name, key in _DOUBLES.items() if key in columns}
    data = draco.encode(
        columns["POSITION"],
        faces.astype(np.uint32),
        quantization_bits=_BITS,
        compression_level=_LEVEL,
        tex_coord_quantization_bits=_BITS,
        normal_quantization_bits=_NORMAL_BITS,
        generic_attributes={7: columns["COLOR_0"]} if "COLOR_0" in columns else None,
        **others,
    )
    mesh = draco.decode(data)
    read = {_KINDS[one["attribute_type"]]: (one["unique_id"], one["data"]) for one in mesh.attributes}
    return data, {name: (key, rows.astype(columns[name].dtype)) for name, (key, rows) in read.items()}, mesh.faces


_DOUBLES = {"normals": "NORMAL", "tex_coord": "TEXCOORD_0"}  # by the arguments of DracoPy


def read_name(name: str) -> str:
    """Return a name as three.js has it."""
    return _UNREAD.sub("", _SPACES.sub("_", name))


# White space of JavaScript, which differs from Python's.
_SPACES = re.compile("[\t-\r \xa0\u1680\u2000-\u200a\u2028\u2029\u202f\u205f\u3000\ufeff]")
# Names that three.js's table of names, an object of JavaScript, has from the start.
_MEMBERS = frozenset(
    """
    constructor hasOwnProperty isPrototypeOf propertyIsEnumerable toLocaleString toString valueOf
    __proto__ __defineGetter__ __defineSetter__ __lookupGetter__ __lookupSetter__
    """.split()  # noqa: SIM905
)
_UNREAD = re.compile(r"[\[\].:/]")


class _UniqueNames:
    """Numbers equal names: the first keeps its word, the others get numbers that form no other given name."""

    def __init__(self, reserved: set[str]) -> None:
        self.taken = set(_MEMBERS)
        self._reserved = reserved
        self._numbers: dict[str, int] = {}

    def fresh(self, name: str) -> str:
        """Return a name that no other has."""
        key = read_name(name)
        if key not in self.taken:
            self.taken.add(key)
            return name
        number = self._numbers.get(key, 1) + 1
        while f"{key}_{number}" in self.taken or f"{key}_{number}" in self._reserved:
            number += 1
        self._numbers[key] = number
        self.taken.add(f"{key}_{number}")
        return f"{name}_{number}"


def material(look: Look) -> dict[str, Any]:
    """Return the glTF material of a look; its factors are linear, like colors."""
    is_refractive = look.ior is not None and look.opacity < 1.0
    color = (1.0, 1.0, 1.0) if look.texture is not None else look.color
    fields: dict[str, Any] = {
        "name": material_name(look),
        "pbrMetallicRoughness": {
            "baseColorFactor": [*color, 1.0 if is_refractive else look.opacity],
            "metallicFactor": look.metallic,
            "roughnessFactor": look.gloss,
        },
        "doubleSided": True,
    }
    if look.opacity < 1.0 and not is_refractive:
        fields["alphaMode"] = "BLEND"
    extensions = _extensions(look)
    brightest = max(look.emission)
    if brightest > 0.0:
        strength = max(1.0, brightest)
        fields["emissiveFactor"] = [channel / strength for channel in look.emission]
        if strength > 1.0:
            extensions["KHR_materials_emissive_strength"] = {"emissiveStrength": strength}
    return fields | ({"extensions": extensions} if extensions else {})


_SHEEN_ROUGHNESS = 0.5
_THICKNESS = 1.0  # of refracting volumes, in the frames of meshes: half the size of unit solids


def _extensions(look: Look) -> dict[str, Any]:
    """Return the extensions of a material, except that of bright emission."""
    extensions: dict[str, Any] = {}
    if look.ior is not None:
        extensions["KHR_materials_ior"] = {"ior": look.ior}
        if look.opacity < 1.0:
            extensions["KHR_materials_transmission"] = {"transmissionFactor": 1.0 - look.opacity}
            extensions["KHR_materials_volume"] = {"thicknessFactor": _THICKNESS}
    if look.coat > 0.0:
        extensions["KHR_materials_clearcoat"] = {
            "clearcoatFactor": look.coat, "clearcoatRoughnessFactor": COAT_ROUGHNESS
        }  # fmt: skip
    if look.sheen > 0.0:
        extensions["KHR_materials_sheen"] = {
            "sheenColorFactor": [look.sheen] * 3, "sheenRoughnessFactor": _SHEEN_ROUGHNESS
        }  # fmt: skip
    return extensions


def wrote_glb(path: Path) -> bool:
    """Return whether ``path`` is a GLB file that scenelang wrote, by the ``generator`` of its asset."""
    try:
        with path.open("rb") as file:
            magic, _, _, length, kind = struct.unpack("<4sIIII", file.read(20))
            head = file.read(min(length, 1 << 26)) if (magic, kind) == (b"glTF", 0x4E4F534A) else b"{}"
        generator = json.loads(head)["asset"]["generator"]
    except (OSError, ValueError, KeyError, TypeError, struct.error):
        return False
    return isinstance(generator, str) and generator.startswith("scenelang")


def _generator() -> str:
    """Return the `generator` of files, with the version if scenelang is installed."""
    from importlib.metadata import PackageNotFoundError, version

    try:
        return f"scenelang {version('scenelang')}"
    except PackageNotFoundError:
        return "scenelang"


# glTF animation: one sampler and channel for each property that changes between frames.


FloatArray = npt.NDArray[np.float64]

_FLOAT32_PRECISION = 2e-7  # relative precision of float32, within which values of a track are equal
# frames in which a pose becomes its mirror image, because no rotation and scale interpolate between them
_FLIP_FRAMES = 0.01


@dataclass(slots=True)
class AnimationTracks:
    """Animation of a document; frame ``i`` is at ``i / fps`` seconds."""

    document: GltfDocument
    fps: float
    samplers: list[dict[str, Any]] = field(default_factory=list)
    channels: list[dict[str, Any]] = field(default_factory=list)
    _times: dict[tuple[float, ...], int] = field(default_factory=dict)

    def add(self, node: int, path: str, values: FloatArray, jumps: bool = False, flips: Sequence[int] = ()) -> None:
        """Animate ``path`` of a node with ``values`` (F, K), interpolated linearly or, with ``jumps``, stepwise.

        Constant properties get no track. Of a run of equal values only the ends are stored, or the first if stepwise.
        Before each of the frames ``flips`` the values stay, and change within a hundredth of a frame.
        """
        if (np.abs(values - values[0]) <= _FLOAT32_PRECISION * np.abs(values[0]).max()).all():
            return
        same = (values[1:] == values[:-1]).all(axis=1)
        before = np.concatenate([[False], same])
        after = np.concatenate([same, [False]])
        keep = ~before if jumps else ~(before & after)
        keep[-1] = True  # all tracks have the same duration
        keep[[frame - 1 for frame in flips]] = keep[list(flips)] = True
        frames = np.flatnonzero(keep)
        rows = np.sort(np.concatenate([frames, [frame - 1 for frame in flips]])).astype(np.int64)
        times = np.sort(np.concatenate([frames, [frame - _FLIP_FRAMES for frame in flips]]))
        output = self.document.add_array(
            np.ascontiguousarray(values[rows], np.float32), "VEC4" if path == "rotation" else "VEC3"
        )
        self.samplers.append(
            {"input": self._input(times), "output": output, "interpolation": "STEP" if jumps else "LINEAR"}
        )
        self.channels.append({"sampler": len(self.samplers) - 1, "target": {"node": node, "path": path}})

    def _input(self, times: FloatArray) -> int:
        """Return the accessor of the times of keys, shared by equal tracks."""
        key = tuple(times.tolist())
        if key not in self._times:
            self._times[key] = self.document.add_array((times / self.fps).astype(np.float32), "SCALAR")
        return self._times[key]

    def finish(self, name: str) -> None:
        """Add the animation to the document unless it is empty."""
        if self.channels:
            self.document.animations.append({"name": name, "samplers": self.samplers, "channels": self.channels})


# glTF has no primitives of its own (its extension is a draft), so that all are meshes, and `extras` names the form of
# newer ones. The hierarchy of a scene as glTF nodes, named by words, and its frames as an animation. Every instance of
# an entity is a node whose ``extras`` contain its metadata. A primitive's node places its canonical solid (a unit cube,
# ball, cylinder or cone, shared by all with the same look), so its pose is the product of the entity's and the solid's.
# Additional child nodes: ``word/shear`` for a pose with shear, ``word/shown`` with scale 0 or 1 for an object that is
# not in all frames, and ``word/1``, ``word/2``, ... for the looks of a primitive whose look changes.


Node = dict[str, Any]


def node_fields(decomposition: Decomposition, index: int) -> list[Node]:
    """Return the fields of one glTF node, or of a parent and its child, for pose ``index``; identities are omitted."""
    row = slice(index, index + 1)
    d = decomposition
    return all_fields(Decomposition(d.translation[row], d.rotation[row], d.scale[row], d.inner[row], d.shears[row]))[0]


def all_fields(decomposition: Decomposition) -> list[list[Node]]:
    """Return the node fields of every pose, as ``node_fields`` does for one."""
    fields: list[list[Node]] = [[{}] for _ in range(len(decomposition.translation))]
    for name, neutral in _NEUTRAL.items():
        values = getattr(decomposition, name)
        rows = np.flatnonzero((values != neutral).any(axis=1))
        for row, value in zip(rows.tolist(), values[rows].tolist(), strict=True):
            fields[row][0][name] = value
    for row in np.flatnonzero(decomposition.shears).tolist():
        fields[row].append({"rotation": decomposition.inner[row].tolist()})
    return fields


_NEUTRAL = {"translation": (0.0, 0.0, 0.0), "rotation": (0.0, 0.0, 0.0, 1.0), "scale": (1.0, 1.0, 1.0)}
INSTANCED = "EXT_mesh_gpu_instancing"
_BATCH_POSES = 1 << 16  # poses decomposed at a time


@dataclass(slots=True)
class Nodes:
    """Adds nodes to ``document``, with caches for poses, primitives and the shared content of nodes of an item.

    ``sides`` returns the sides of full circles of an item, ``within`` the tolerance in its frame. From ``least`` copies
    of an item in another one on, they are instances of one node for each mesh (``EXT_mesh_gpu_instancing``); 0 for
    never. The extension repeats one node's mesh and not its children, so copies are grouped by mesh below the copied
    entity: the hierarchy of words remains, once for all copies. It must be in ``extensionsRequired``, and readers
    without it refuse the file, hence only on request.
    """

    document: GltfDocument
    sides: Callable[[ExportItem], int] = field(default=lambda _: SEGMENTS)
    within: Callable[[ExportItem], float | None] = field(default=lambda _: None)
    least: int = 0
    _poses: dict[Matrix, list[Node]] = field(default_factory=dict)
    _parts: dict[int, list[list[Node]]] = field(default_factory=dict)
    _solids: dict[int, Solid | None] = field(default_factory=dict)
    _extras: dict[int, Node] = field(default_factory=dict)
    _meshes: dict[int, list[PlacedMesh]] = field(default_factory=dict)

    # --- static objects ---

    def prepare(self, items: Iterable[ExportItem]) -> None:
        """Decompose all poses below ``items`` at once, which is much faster than one by one."""
        order = [item for item in distinct(*items) if item.parts and id(item) not in self._parts]
        children = [child for item in order for child, _ in item.parts]
        poses = pose.stacked([place for item in order for _, place in item.parts]).reshape(-1, 3, 4)
        fields: list[list[Node]] = []
        for start in range(0, len(children), _BATCH_POSES):
            rows = slice(start, start + _BATCH_POSES)
            fields += all_fields(decompose(self._all_placed(children[rows], poses[rows])))
        start = 0
        for item in order:
            self._parts[id(item)] = fields[start : start + len(item.parts)]
            start += len(item.parts)

    def _all_placed(self, items: Sequence[ExportItem], poses: FloatArray) -> FloatArray:
        """Return the poses of the items' nodes under the poses (K, 3, 4), as ``placed`` does for one."""
        numbers: dict[int, int] = {}
        index = [numbers.setdefault(id(item), len(numbers)) for item in items]
        item_poses = np.array([self.placed(item, IDENTITY) for item in {id(item): item for item in items}.values()])
        return composed(poses, item_poses.reshape(-1, 3, 4)[index])

    def add_still(self, root: ExportItem, place: Matrix, siblings: list[int] | None) -> None:
        """Add a node for each instance below and including ``root``, without recursion."""
        waiting = [(root, self._fields(self.placed(root, place)), siblings)]
        while waiting:
            item, fields, siblings = waiting.pop()
            node = self._add_posed(item.word, fields, self.extras(item), siblings)
            self._give_meshes(node, item)
            if not item.parts:
                continue
            children: list[int] = []
            node["children"] = children
            copied = self._copied(item)
            for child, poses in copied.values():
                self._add_copies(child, np.array(poses).reshape(-1, 3, 4), children)
            rows = zip(reversed(item.parts), reversed(self._parts[id(item)]), strict=True)
            waiting.extend((child, below, children) for (child, _), below in rows if id(child) not in copied)

    def _copied(self, item: ExportItem) -> dict[int, tuple[ExportItem, list[Matrix]]]:
        """Return the parts of an item that are instanced, with their poses."""
        if not self.least or len(item.parts) < self.least:
            return {}
        copies: dict[int, tuple[ExportItem, list[Matrix]]] = {}
        for child, place in item.parts:
            copies.setdefault(id(child), (child, []))[1].append(place)
        return {key: value for key, value in copies.items() if len(value[1]) >= self.least}

    def _add_copies(self, root: ExportItem, places: FloatArray, siblings: list[int]) -> None:
        """Add a node for each item below and including ``root`` that stands for all its instances.

        Instance ``k`` of a part is in copy ``k // n`` of ``root`` if a copy has n of it.
        """
        waiting = [(root, places, siblings)]
        while waiting:
            item, poses, siblings = waiting.pop()
            if item.is_leaf:
                self._add_instances(item, poses, siblings)
                continue
            children: list[int] = []
            node: Node = {"name": item.word, "extras": self.extras(item) | {"instances": len(poses)}}
            self._append(node, siblings)
            copies_by_child: dict[int, tuple[ExportItem, list[Matrix]]] = {}
            for child, place in item.parts:
                copies_by_child.setdefault(id(child), (child, []))[1].append(place)
            for child, child_poses in reversed(list(copies_by_child.values())):
                inner = np.array(child_poses).reshape(-1, 3, 4)
                product_ = composed(np.repeat(poses, len(inner), axis=0), np.tile(inner, (len(poses), 1, 1)))
                waiting.append((child, product_, children))
            if copies_by_child:
                node["children"] = children

    def _add_instances(self, item: ExportItem, poses: FloatArray, siblings: list[int]) -> None:
        """Add one node for all instances of a leaf, and ordinary nodes for those that are mirrored or sheared."""
        places = self._all_placed([item] * len(poses), poses)
        offset = common_offset(places[:, :, 3], size_of([item.entity]))  # translations of instances are float32
        near = places if offset is None else about(places, offset)
        decomposition = decompose(near)
        plain = ~decomposition.shears & (decomposition.scale > 0.0).all(axis=1)
        rows = np.flatnonzero(plain)
        if len(rows):
            node: Node = {"name": item.word, "extras": self.extras(item) | {"instances": len(rows)}}
            if offset is not None:
                node["translation"] = offset.tolist()
            self._append(node, siblings)
            meshes = self.meshes_of(item)
            for number, (inner, mesh) in enumerate(meshes, start=1):
                mesh_decomposition = (
                    decomposition if inner is IDENTITY else decompose(composed(near, np.array(inner).reshape(1, 3, 4)))
                )
                holder = node if len(meshes) == 1 else self._add_part(f"{item.word}/{number}", {}, node)
                self.document.required.add(INSTANCED)
                holder |= {
                    "mesh": mesh,
                    "extensions": {INSTANCED: {"attributes": self._instances(mesh_decomposition, rows)}},
                }
        for row in np.flatnonzero(~plain).tolist():
            fields = node_fields(decompose(places[row : row + 1]), 0)
            self._give_meshes(self._add_posed(item.word, fields, self.extras(item), siblings), item)

    def _instances(self, decomposition: Decomposition, rows: npt.NDArray[np.int64]) -> dict[str, int]:
        """Add the attributes of instances; ``_INSTANCE`` counts them as the scene does, ordinary nodes included."""
        add = self.document.add_array
        attributes = {"TRANSLATION": add(decomposition.translation[rows].astype(np.float32), "VEC3")}
        for name, kind in (("rotation", "VEC4"), ("scale", "VEC3")):
            values = getattr(decomposition, name)[rows]
            if (values != _NEUTRAL[name]).any():
                attributes[name.upper()] = add(values.astype(np.float32), kind)
        return attributes | {"_INSTANCE": add(rows.astype(np.uint32), "SCALAR")}

    def placed(self, item: ExportItem, local: Matrix) -> Matrix:
        """Return the pose of the item's node, including that of a primitive's solid."""
        solid = self.solid(item)
        return local if solid is None or solid.pose is IDENTITY else pose.compose(local, solid.pose)

    def solid(self, item: ExportItem) -> Solid | None:
        """Return the solid of a primitive, None for other items."""
        key = id(item.entity)
        if key not in self._solids:
            self._solids[key] = None if item.merged else solid_of(item.entity)
        return self._solids[key]

    def extras(self, item: ExportItem) -> Node:
        """Return the metadata of the node's entity."""
        if id(item) not in self._extras:
            self._extras[id(item)] = merged_facts(item.entity) if item.merged else facts_of(item.entity)
        return self._extras[id(item)]

    def _fields(self, place: Matrix) -> list[Node]:
        """Return the node fields of a pose, decomposed once."""
        if place not in self._poses:
            self._poses[place] = node_fields(decompose(np.array(place).reshape(1, 3, 4)), 0)
        return self._poses[place]

    def _add_posed(self, word: str, fields: Sequence[Node], extras: Node | None, siblings: list[int] | None) -> Node:
        """Add a node, and a child if the pose has shear; return the innermost, which gets the content."""
        outer, *inner = fields
        node = {"name": word, **outer} | ({"extras": extras} if extras else {})
        self._append(node, siblings)
        for more in inner:
            node = self._add_inner(f"{word}/shear", more, node)
        return node

    def _append(self, node: Node, siblings: list[int] | None) -> int:
        """Add a node below its siblings' parent and return its index."""
        if siblings is not None:
            siblings.append(len(self.document.nodes))
        self.document.nodes.append(node)
        return len(self.document.nodes) - 1

    def _add_inner(self, name: str, fields: Node, outer: Node) -> Node:
        """Add a node as the only child of another."""
        node = {"name": name, **fields}
        outer["children"] = [self._append(node, None)]
        return node

    def _add_part(self, name: str, fields: Node, node: Node) -> Node:
        """Add a child to a node."""
        part: Node = {"name": name, **fields}
        self._append(part, node.setdefault("children", []))
        return part

    def _give_meshes(self, node: Node, item: ExportItem) -> None:
        """Give a node the mesh of the item; nothing if that is invisible, and a child for each of several meshes."""
        meshes = self.meshes_of(item)
        if len(meshes) == 1 and meshes[0][0] is IDENTITY:
            node["mesh"] = meshes[0][1]
            return
        for number, (place, mesh) in enumerate(meshes, start=1):
            self._add_part(f"{item.word}/{number}", {"translation": list(place[3::4])}, node)["mesh"] = mesh

    def meshes_of(self, item: ExportItem) -> list[PlacedMesh]:
        """Return the meshes of the item."""
        if id(item) not in self._meshes:
            self._meshes[id(item)] = self._make_meshes(item)
        return self._meshes[id(item)]

    def _make_meshes(self, item: ExportItem) -> list[PlacedMesh]:
        """Add the meshes of an item."""
        if item.merged:
            return self.document.merged_meshes(item.entity, self.within(item))
        solid = self.solid(item)
        if solid is None:
            return []
        mesh = self.document.solid_mesh(item.word, solid, look_of(item.entity), self.sides(item))
        return [] if mesh is None else [(IDENTITY, mesh)]

    # --- animated objects ---

    def add_moving(self, root: Moving, tracks: AnimationTracks) -> None:
        """Add a node for each path over all frames, with tracks for the properties that change."""
        waiting: list[tuple[Moving, list[int] | None]] = [(root, None)]
        while waiting:
            moving, siblings = waiting.pop()
            if moving.fixed is not None and moving.is_still:
                self.add_still(moving.fixed, moving.poses[0] or IDENTITY, siblings)
                continue
            children: list[int] = []
            self._add_changing(moving, siblings, tracks, children)
            if moving.fixed is not None:
                for child, place in moving.fixed.parts:
                    self.add_still(child, place, children)
            waiting.extend((child, children) for child in reversed(moving.children))

    def _add_changing(
        self, moving: Moving, siblings: list[int] | None, tracks: AnimationTracks, children: list[int]
    ) -> None:
        """Add the node of an object that changes between frames, with its tracks and meshes."""
        kinds = variants(moving)
        has_one_mesh = len(kinds) == 1 and not moving.children
        places = list(moving.filled_poses())
        if has_one_mesh:
            items = _filled(moving.items)
            places = [self.placed(item, place) for item, place in zip(items, places, strict=True)]
        size = size_of([moving.first.entity])
        node = self._add_track(moving.word, places, moving.shown, self.extras(moving.first), siblings, tracks, size)
        if has_one_mesh:
            self._give_meshes(node, kinds[0][0])
        elif kinds:
            self._add_variants(moving, kinds, children, tracks)
        if children or moving.children or (moving.fixed is not None and moving.fixed.parts):
            node["children"] = children

    def _add_variants(
        self,
        moving: Moving,
        kinds: Sequence[tuple[ExportItem, tuple[bool, ...]]],
        children: list[int],
        tracks: AnimationTracks,
    ) -> None:
        """Add a child node for each mesh of the object over time, visible only in its frames."""
        for number, (item, shown) in enumerate(kinds, start=1):
            variant_items = [other if is_shown else None for other, is_shown in zip(moving.items, shown, strict=True)]
            places = [self.placed(other, IDENTITY) for other in _filled(variant_items)]
            name, size = f"{moving.word}/{number}", size_of([item.entity])
            node = self._add_track(name, places, shown, None, children, tracks, size)
            self._give_meshes(node, item)

    def _add_track(
        self,
        name: str,
        places: Sequence[Matrix],
        shown: tuple[bool, ...],
        extras: Node | None,
        siblings: list[int] | None,
        tracks: AnimationTracks,
        size: float,
    ) -> Node:
        """Add a node with one pose per frame, visible in the frames ``shown``.

        Returns the innermost of its nodes, which gets the content.
        """
        is_still = len(set(places)) == 1
        poses = np.array(places).reshape(-1, 3, 4)
        offset = None if is_still else common_offset(poses[:, :, 3], size)  # tracks are float32
        if offset is not None:
            self._add_posed(name, [{"translation": offset.tolist()}], extras, siblings)
            name, extras, siblings = f"{name}/motion", None, self.document.nodes[-1].setdefault("children", [])
            poses = about(poses, offset)
        decomposition = None if is_still else decompose_track(poses)
        fields = self._fields(places[0]) if decomposition is None else node_fields(decomposition, 0)
        number = len(self.document.nodes)
        node = self._add_posed(name, fields, extras, siblings)
        if decomposition is not None:
            handedness = np.sign(decomposition.scale).prod(axis=1)
            flips = (np.flatnonzero(handedness[1:] * handedness[:-1] < 0.0) + 1).tolist()
            tracks.add(number, "translation", decomposition.translation, flips=flips)
            tracks.add(number, "rotation", decomposition.rotation, flips=flips)
            tracks.add(number, "scale", decomposition.scale, flips=flips)
            if decomposition.shears[0]:
                tracks.add(number + 1, "rotation", decomposition.inner, flips=flips)
        if not all(shown):
            first = {} if shown[0] else {"scale": [0.0, 0.0, 0.0]}
            node = self._add_inner(f"{name}/shown", first, node)
            tracks.add(len(self.document.nodes) - 1, "scale", np.repeat(np.array(shown, float)[:, None], 3, 1), True)
        return node


def _filled(items: Sequence[ExportItem | None]) -> list[ExportItem]:
    """Return an item for every frame; frames without one repeat the previous item."""
    current = next(item for item in items if item is not None)
    filled = []
    for item in items:
        current = item if item is not None else current
        filled.append(current)
    return filled


COMPRESSED = Option(
    "draco", "compress meshes (KHR_draco_mesh_compression): readers must know it, and positions have 16 bits", False
)
_HINT = "raise --instance-limit, or export a part of the scene"


def write(job: Job, path: Path) -> None:
    """Write a .glb file, or a .gltf file and its .bin file; raises SceneError and LimitError."""
    document = document_of(job)
    job.progress(0.9)
    if path.suffix.lower() == ".gltf":
        buffer = path.with_suffix(".bin")
        if document.size:
            with buffer.open("wb") as file:
                file.writelines(document.chunks)
        path.write_bytes(document.to_json(quote(buffer.name)))
        return
    with path.open("wb") as file:
        file.writelines(document.to_glb())


def document_of(job: Job) -> GltfDocument:
    """Return the glTF document of a plan; raises LimitError if it would be too large."""
    plan = _within_limits(job)
    merged_entities = [item.entity for item in distinct(*plan.roots) if item.merged]
    document = GltfDocument(merged_sides(job, merged_entities, _HINT), job.solid, job.draco)
    fine = fineness(job, plan.roots)
    nodes = Nodes(document, fine.of, fine.within, job.instancing or 0)
    if plan.animated:
        _add_frames(nodes, plan, job.fps)
    else:
        nodes.prepare(plan.roots)
        nodes.add_still(plan.roots[0], IDENTITY, None)
    roots = [root.entity for root in job.plan.roots]
    document.add_setup(Scene(plan.word, roots, plan.animated, (), plan.setup))
    document.name_uniquely()
    if document.is_too_large:
        raise LimitError("size", "the meshes exceed the 4 GB limit of a glTF file", hint=_HINT)
    return document


def _within_limits(job: Job) -> ExportPlan:
    """Return the plan with repeated parts merged as far as the limit of nodes requires; instances need none."""
    if not job.instancing:
        return cut_below(job.plan, job.instances)
    most = max(leaf_counts(root)[id(root)] for root in job.plan.roots)
    if most > job.limit:
        message = f"the scene expands to {most:,} instances, more than the limit of {job.limit:,}"
        raise LimitError("primitives", message, hint="raise it with --max-primitives, or omit --instancing")
    return job.plan


def _add_frames(nodes: Nodes, plan: ExportPlan, fps: float) -> None:
    """Add the frames of a 4D scene as one animated hierarchy."""
    root = matched(plan.roots)
    nodes.prepare(list(_fixed_items(root)))
    tracks = AnimationTracks(nodes.document, fps)
    nodes.add_moving(root, tracks)
    tracks.finish(plan.word)


def _fixed_items(root: Moving) -> Iterator[ExportItem]:
    """Yield the items that never change."""
    waiting = [root]
    while waiting:
        moving = waiting.pop()
        if moving.fixed is not None:
            yield moving.fixed
        waiting.extend(moving.children)


GLTF = mesh_backend(
    "gltf",
    "glTF 2.0 with the entity hierarchy and 4D animation",
    (".glb", ".gltf"),
    write,
    animated=True,
    options=(INSTANCES, INSTANCING, COMPRESSED, SIDES, TOLERANCE, FPS),
    unit="meter",
)
