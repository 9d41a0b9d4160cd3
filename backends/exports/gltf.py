"""Export to glTF 2.0: .glb as a single file, .gltf with its buffer in a .bin file."""

from __future__ import annotations

import json
import struct
from collections.abc import Hashable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from urllib.parse import quote

import numpy as np
import numpy.typing as npt

from scenelang.backends.exports.export import (
    FPS,
    INSTANCES,
    Job,
    Moving,
    facts_of,
    matched,
    merged_facts,
    mesh_backend,
    variants,
)
from scenelang.backends.exports.plan import (
    SEGMENTS,
    ExportItem,
    ExportPlan,
    ExportSurface,
    Solid,
    cut_below,
    distinct,
    merged,
    segments_for,
    solid_of,
)
from scenelang.backends.exports.trs import Decomposition, decompose, decompose_track
from scenelang.backends.pictures.appearance import Look, look_of
from scenelang.grammar.diagnostics import LimitError
from scenelang.interpreter.runtime.values import IDENTITY, Matrix
from scenelang.interpreter.scene import pose
from scenelang.interpreter.scene.entity import Entity

# A glTF 2.0 document under construction; arrays, meshes and materials are deduplicated.


_ARRAY_BUFFER, _ELEMENT_BUFFER = 34962, 34963
_COMPONENTS = {"float32": 5126, "uint32": 5125, "uint16": 5123}
_MAX_SIZE = 2**32 - 1


@dataclass(slots=True)
class GltfDocument:
    """The elements of the file, with the tables that deduplicate them."""

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
        """Return the index of a primitive's shared mesh, None if it is invisible."""
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
        extras = None if solid.form is None else solid.form.gltf(solid.ratios)
        return self._add_mesh(word, [geometry | {"material": self._material(look)}], extras)

    def merged_mesh(self, entity: Entity) -> int | None:
        """Return the index of the merged mesh of everything below ``entity``, None if it is invisible."""
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
            # linear; 8 bits would cause banding in dark colours
            shades = np.full((len(surface.colors), 4), 65535, np.uint16)
            shades[:, :3] = np.rint(np.clip(surface.colors, 0.0, 1.0) * 65535.0)
            attributes["COLOR_0"] = self.add_array(shades, "VEC4", _ARRAY_BUFFER, normalized=True)
        small = len(surface.vertices) < 65535
        indices = surface.faces.astype(np.uint16 if small else np.uint32).reshape(-1)
        return {"attributes": attributes, "indices": self.add_array(indices, "SCALAR", _ELEMENT_BUFFER)}

    # --- arrays ---

    def add_array(self, array: npt.NDArray[Any], kind: str, target: int | None = None, normalized: bool = False) -> int:
        """Add an accessor for ``array``, one element per row, and return its index."""
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
        """Return the JSON document; ``uri`` locates the binary buffer, None for the chunk of the same file."""
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
        """Return the pieces of a .glb file: header, JSON chunk and binary chunk."""
        text = self.to_json(name)
        text += b" " * (-len(text) % 4)
        parts = [struct.pack("<II", len(text), 0x4E4F534A), text]
        if self.size:
            parts += [struct.pack("<II", self.size, 0x004E4942), *self.chunks]
        total = 12 + sum(map(len, parts))
        return [struct.pack("<4sII", b"glTF", 2, total), *parts]

    @property
    def is_too_large(self) -> bool:
        """Whether the arrays alone exceed the size of a .glb file."""
        return self.size > _MAX_SIZE


def material(look: Look) -> dict[str, Any]:
    """Return the glTF material of a look; its factors are linear, like colours."""
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
    from importlib.metadata import PackageNotFoundError, version

    try:
        return f"scenelang {version('scenelang')}"
    except PackageNotFoundError:
        return "scenelang"


# glTF animation: one sampler and channel for each property that changes between frames.


FloatArray = npt.NDArray[np.float64]

_SAME = 2e-7  # relative precision of float32


@dataclass(slots=True)
class AnimationTracks:
    """Animation of a document; frame ``i`` is at ``i / fps`` seconds."""

    document: GltfDocument
    fps: float
    samplers: list[dict[str, Any]] = field(default_factory=list)
    channels: list[dict[str, Any]] = field(default_factory=list)
    _times: dict[tuple[int, ...], int] = field(default_factory=dict)

    def add(self, node: int, path: str, values: FloatArray, jumps: bool = False) -> None:
        """Animate ``path`` of a node with ``values`` (F, K), interpolated linearly or, with ``jumps``, stepwise.

        Constant properties get no track. Of a run of equal values only the ends are stored, or the first if stepwise.
        """
        if (np.abs(values - values[0]) <= _SAME * np.abs(values[0]).max()).all():
            return
        same = (values[1:] == values[:-1]).all(axis=1)
        before = np.concatenate([[False], same])
        after = np.concatenate([same, [False]])
        keep = ~before if jumps else ~(before & after)
        keep[-1] = True  # all tracks have the same duration
        frames = np.flatnonzero(keep)
        output = self.document.add_array(
            np.ascontiguousarray(values[frames], np.float32), "VEC4" if path == "rotation" else "VEC3"
        )
        self.samplers.append(
            {"input": self._input(frames), "output": output, "interpolation": "STEP" if jumps else "LINEAR"}
        )
        self.channels.append({"sampler": len(self.samplers) - 1, "target": {"node": node, "path": path}})

    def _input(self, frames: npt.NDArray[np.int64]) -> int:
        key = tuple(frames.tolist())
        if key not in self._times:
            self._times[key] = self.document.add_array((frames / self.fps).astype(np.float32), "SCALAR")
        return self._times[key]

    def finish(self, name: str) -> None:
        """Add the animation to the document unless it is empty."""
        if self.channels:
            self.document.animations.append({"name": name, "samplers": self.samplers, "channels": self.channels})


# The hierarchy of a scene as glTF nodes, named by words, and its frames as an animation. Every instance of an entity is
# a node whose ``extras`` contain its metadata. A primitive's node places its canonical solid (a unit cube, ball,
# cylinder or cone, shared by all with the same look), so its pose is the product of the entity's and the solid's.
# Additional child nodes: ``word/shear`` for a pose with shear, ``word/shown`` with scale 0 or 1 for an object that is
# not in all frames, and ``word/1``, ``word/2``, ... for the looks of a primitive whose look changes.


Node = dict[str, Any]


def node_fields(decomposition: Decomposition, index: int) -> list[dict[str, Any]]:
    """Return the fields of one glTF node, or of a parent and its child, for pose ``index``; identities are omitted."""
    fields = {
        "translation": decomposition.translation,
        "rotation": decomposition.rotation,
        "scale": decomposition.scale,
    }
    neutral = {"translation": [0.0, 0.0, 0.0], "rotation": [0.0, 0.0, 0.0, 1.0], "scale": [1.0, 1.0, 1.0]}
    listed = {name: values[index].tolist() for name, values in fields.items()}
    outer = {name: value for name, value in listed.items() if value != neutral[name]}
    return [outer, {"rotation": decomposition.inner[index].tolist()}] if decomposition.shears[index] else [outer]


@dataclass(slots=True)
class Nodes:
    """Adds nodes to ``document``, with caches for poses, primitives and extras."""

    document: GltfDocument
    _poses: dict[Matrix, list[Node]] = field(default_factory=dict)
    _solids: dict[int, Solid | None] = field(default_factory=dict)
    _extras: dict[int, Node] = field(default_factory=dict)

    # --- static objects ---

    def prepare(self, items: Iterable[ExportItem]) -> None:
        """Decompose all poses below ``items`` at once, which is much faster than one by one."""
        found = {self.placed(child, place) for item in distinct(*items) for child, place in item.parts}
        fresh = [place for place in found if place not in self._poses]
        for start in range(0, len(fresh), 1 << 16):
            block = fresh[start : start + (1 << 16)]
            decomposition = decompose(np.array(block).reshape(-1, 3, 4))
            for index, place in enumerate(block):
                self._poses[place] = node_fields(decomposition, index)

    def add_still(self, root: ExportItem, place: Matrix, siblings: list[int] | None) -> None:
        """Add a node for each instance below and including ``root``, without recursion."""
        waiting: list[tuple[ExportItem, Matrix, list[int] | None]] = [(root, place, siblings)]
        while waiting:
            item, local, siblings = waiting.pop()
            node = self._add_posed(item.word, self._fields(self.placed(item, local)), self.extras(item), siblings)
            self._fill(node, item)
            if item.parts:
                children: list[int] = []
                node["children"] = children
                waiting.extend((child, pose_, children) for child, pose_ in reversed(item.parts))

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
        if siblings is not None:
            siblings.append(len(self.document.nodes))
        self.document.nodes.append(node)
        return len(self.document.nodes) - 1

    def _add_inner(self, name: str, fields: Node, outer: Node) -> Node:
        node = {"name": name, **fields}
        outer["children"] = [self._append(node, None)]
        return node

    def _fill(self, node: Node, item: ExportItem) -> None:
        """Set the mesh of the node to that of its item, if any."""
        mesh = self.mesh(item)
        if mesh is not None:
            node["mesh"] = mesh

    def mesh(self, item: ExportItem) -> int | None:
        """Return the index of the item's mesh."""
        if item.merged:
            return self.document.merged_mesh(item.entity)
        solid = self.solid(item)
        return None if solid is None else self.document.solid_mesh(item.word, solid, look_of(item.entity))

    # --- animated objects ---

    def add_moving(self, root: Moving, tracks: AnimationTracks) -> None:
        """Add a node for each path over all frames, with tracks for what changes."""
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
        kinds = variants(moving)
        one = len(kinds) == 1 and not moving.children
        places = list(moving.filled_poses())
        if one:
            items = _filled(moving.items)
            places = [self.placed(item, place) for item, place in zip(items, places, strict=True)]
        node = self._add_track(moving.word, places, moving.shown, self.extras(moving.first), siblings, tracks)
        if one:
            self._fill(node, kinds[0][0])
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
            mine = [other if seen else None for other, seen in zip(moving.items, shown, strict=True)]
            places = [self.placed(other, IDENTITY) for other in _filled(mine)]
            node = self._add_track(f"{moving.word}/{number}", places, shown, None, children, tracks)
            self._fill(node, item)

    def _add_track(
        self,
        name: str,
        places: Sequence[Matrix],
        shown: tuple[bool, ...],
        extras: Node | None,
        siblings: list[int] | None,
        tracks: AnimationTracks,
    ) -> Node:
        """Add a node with one pose per frame, visible in the frames ``shown``; return the innermost, which gets the
        content."""
        still = len(set(places)) == 1
        decomposition = None if still else decompose_track(np.array(places).reshape(-1, 3, 4))
        fields = self._fields(places[0]) if decomposition is None else node_fields(decomposition, 0)
        number = len(self.document.nodes)
        node = self._add_posed(name, fields, extras, siblings)
        if decomposition is not None:
            tracks.add(number, "translation", decomposition.translation)
            tracks.add(number, "rotation", decomposition.rotation)
            tracks.add(number, "scale", decomposition.scale)
            if decomposition.shears[0]:
                tracks.add(number + 1, "rotation", decomposition.inner)
        if not all(shown):
            first = {} if shown[0] else {"scale": [0.0, 0.0, 0.0]}
            node = self._add_inner(f"{name}/shown", first, node)
            tracks.add(len(self.document.nodes) - 1, "scale", np.repeat(np.array(shown, float)[:, None], 3, 1), True)
        return node


def _filled(items: Sequence[ExportItem | None]) -> list[ExportItem]:
    """Return an item for every frame; frames without one repeat the previous item."""
    found = next(item for item in items if item is not None)
    filled = []
    for item in items:
        found = item if item is not None else found
        filled.append(found)
    return filled


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
        path.write_bytes(document.to_json(job.plan.word, quote(buffer.name)))
        return
    with path.open("wb") as file:
        file.writelines(document.to_glb(job.plan.word))


def document_of(job: Job) -> GltfDocument:
    """Return the glTF document of a plan; raises LimitError if it would be too large."""
    plan = cut_below(job.plan, job.instances)
    whole = [item.entity for item in distinct(*plan.roots) if item.merged]
    document = GltfDocument(segments_for(whole, "the merged meshes", _HINT))
    nodes = Nodes(document)
    if plan.animated:
        _add_frames(nodes, plan, job.fps)
    else:
        nodes.prepare(plan.roots)
        nodes.add_still(plan.roots[0], IDENTITY, None)
    if document.is_too_large:
        raise LimitError("size", "the meshes exceed the 4 GB limit of a glTF file", hint=_HINT)
    return document


def _add_frames(nodes: Nodes, plan: ExportPlan, fps: float) -> None:
    root = matched(plan.roots)
    nodes.prepare(list(_fixed_items(root)))
    tracks = AnimationTracks(nodes.document, fps)
    nodes.add_moving(root, tracks)
    tracks.finish(plan.word)


def _fixed_items(root: Moving) -> Iterator[ExportItem]:
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
    options=(INSTANCES, FPS),
)
