"""The viewer page, and the binary packet of a scene for it: the entity DAG and the appearance of its primitives.

Layout: the four bytes ``SCNV``, the length of the header (32-bit, little-endian), the header (JSON, padded with spaces
to a multiple of eight bytes), then the columns. A column is an array; the header lists its name, type, offset and
length. The page receives the DAG, never its expansion: it computes paths, handles and counts itself. Instances are rows
(primitive, pose, path of words); a row that occurs in several frames is sent once, and a frame is a list of row indices
in depth-first order. Poses and geometry are in the stage's frame (see ``stage``): box centered, half diagonal 1.
"""

from __future__ import annotations

import atexit
import base64
import gzip
import hashlib
import html
import json
import os
import secrets
import struct
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from scenelang.backends.files import check_folder, write_text
from scenelang.backends.pictures.stage import box_of, unit_size
from scenelang.backends.surfaces.appearance import GLASS, Color, Look, look_of
from scenelang.backends.surfaces.precision import own_offset
from scenelang.backends.surfaces.restyling import with_file_images
from scenelang.backends.surfaces.solids import composed, coordinates_of, is_semantic, keeps_own_colors, own_mesh
from scenelang.backends.surfaces.stand_ins import drawn_scene
from scenelang.backends.viewer.start import cameras_of, studio_of, tone_of
from scenelang.backends.viewer.texture_columns import texture_columns
from scenelang.grammar.datum import Span
from scenelang.grammar.diagnostics import LimitError, SceneError, UsageError
from scenelang.grammar.settings import typed
from scenelang.interpreter.inspection.numbering import number_scene
from scenelang.interpreter.loading import user_folder
from scenelang.interpreter.runtime.show import show
from scenelang.interpreter.runtime.types import STD
from scenelang.interpreter.scene.entity import Entity, Scene, descendants, primitive_count
from scenelang.interpreter.scene.flatten import FlatFrame, flatten
from scenelang.interpreter.scene.primitives import Primitive
from scenelang.interpreter.scene.primitives.forms import CanonicalForm
from scenelang.interpreter.scene.primitives.mesh import Mesh, triangle_normals
from scenelang.interpreter.values.values import Embedding

# The entity DAG as tables and columns: words, embeddings, source locations, edges. Its size grows with the number of
# distinct entities.


_MAX_VALUE_LENGTH = 200  # characters of an attribute that is shown
_MAX_LINE_LENGTH = 200  # characters of a source line that is shown


@dataclass(slots=True)
class _Table:
    """Table of distinct rows of plain data, identified by index."""

    rows: list[Any] = field(default_factory=list)
    numbers: dict[Any, int] = field(default_factory=dict)

    def number(self, key: Any, row: Any) -> int:
        """Return the index of the row with a key; ``row`` is the row or a function that returns it."""
        index = self.numbers.get(key)
        if index is None:
            index = self.numbers[key] = len(self.rows)
            self.rows.append(row() if callable(row) else row)
        return index


@dataclass(frozen=True, slots=True, eq=False)
class PacketGraph:
    """The entity DAG in packet form.

    ``tables`` are JSON data; ``number`` maps ``id(entity)`` to its node, children before parents. ``columns``, per
    node: ``nodeWord``; ``nodeEmbedding``, ``nodePlace`` and ``nodeDefinition`` (-1: none); ``nodePrimitive``;
    ``nodeStart`` (V + 1), so that the children of node n are ``nodeChild[nodeStart[n]:nodeStart[n + 1]]``.
    """

    tables: dict[str, Any]
    columns: dict[str, npt.NDArray[Any]]
    number: dict[int, int]


def graph_of(scene: Scene, definitions: Mapping[str, Span]) -> PacketGraph:
    """Return the distinct entities of all frames of ``scene``; ``definitions`` maps words to where they are bound."""
    nodes = list(descendants(*scene.frames))
    words, embeddings, places = _Table(), _Table(), _Table()
    number = {id(entity): i for i, entity in enumerate(nodes)}
    start = np.zeros(len(nodes) + 1, np.int32)
    np.cumsum([len(entity.children) for entity in nodes], out=start[1:])
    columns: dict[str, npt.NDArray[Any]] = {
        "nodeWord": _column(words.number(entity.word, entity.word) for entity in nodes),
        "nodeEmbedding": _column(_embedding(embeddings, entity.embedding) for entity in nodes),
        "nodePlace": _column(_places(places, entity.call_sites) for entity in nodes),
        "nodeDefinition": _column(_places(places, _definition(entity, definitions)) for entity in nodes),
        "nodeStart": start,
        "nodeChild": _column(number[id(part.car)] for entity in nodes for part in entity.children),
        "nodePrimitive": np.array([entity.is_primitive for entity in nodes], np.uint8),
    }
    tables = {
        "words": words.rows,
        "embeddings": embeddings.rows,
        "places": places.rows,
        "roots": [number[id(root)] for root in scene.frames],
        "taken": list(number_scene(scene).taken),
    }
    return PacketGraph(tables, columns, number)


def _column(numbers: Any) -> npt.NDArray[np.int32]:
    """Return integers as a column."""
    return np.fromiter(numbers, np.int32)


def _embedding(table: _Table, embedding: Embedding) -> int:
    """Return the index of an embedding's row, -1 for an empty one."""
    if embedding.handle is None and not embedding.text and not embedding.attributes:
        return -1
    return table.number(id(embedding), lambda: _embedding_row(embedding))


def _embedding_row(embedding: Embedding) -> dict[str, Any]:
    """Return the JSON data of an embedding."""
    attributes = [[name, show(value, _MAX_VALUE_LENGTH)] for name, value in embedding.attributes.items()]
    return {"handle": embedding.handle, "text": embedding.text, "attributes": attributes}


def _definition(entity: Entity, definitions: Mapping[str, Span]) -> tuple[Span, ...]:
    """Return where the word of a non-primitive entity is bound, if known."""
    span = None if entity.is_primitive else definitions.get(entity.word)
    return () if span is None else (span,)


def _places(table: _Table, spans: Sequence[Span]) -> int:
    """Return the index of a list of source locations, -1 if all are in the standard library."""
    program_spans = [span for span in spans if not span.source.name.startswith(STD)]
    if not program_spans:
        return -1
    key = tuple((id(span.source), span.start) for span in program_spans)
    return table.number(key, lambda: [_place_row(span) for span in program_spans])


def _place_row(span: Span) -> dict[str, Any]:
    """Return the JSON data of a source location, with the form; of a definition, whose place is its word, the line."""
    line, column = span.source.position(span.start)
    text = span.text.partition("\n")[0] if span.text.startswith("(") else span.source.line(line).strip()
    shown = text if len(text) <= _MAX_LINE_LENGTH else text[: _MAX_LINE_LENGTH - 3] + "..."
    return {"file": span.source.name, "line": line, "column": column, "text": shown}


# Instances for the page: geometries, one row per instance of a primitive, and the rows that each frame shows.


FloatArray = npt.NDArray[np.float64]
_FormKey = tuple[CanonicalForm, tuple[float, ...]]
_PLAIN, _OWN, _CHARTED = "plain", "colors of its own", "texture coordinates"  # of the mesh of a file
_MeshKey = tuple[Primitive, str]
IntArray = npt.NDArray[np.int64]

# Level of detail: round solids have two tessellations, of which the coarse one is used for small objects.
_FINE_SIDES, _COARSE_SIDES = 64, 8
_MAX_FINE_INSTANCES = 300  # instances up to which all are drawn with the fine version
MATTE = -1.0  # marks a surface without roughness
NO_FACETS = 1.0  # index of refraction of what reflects nothing below its coat


@dataclass(frozen=True, slots=True, eq=False)
class Geometry:
    """Mesh in its own frame.

    ``positions`` and ``normals`` (3 V), ``indices`` (3 F), and ``colors`` (3 V), linear sRGB, if the mesh has its own.
    ``chart`` (2 V) are the texture coordinates of a mesh file, for textures with the projection uv.
    ``is_closed`` marks a canonical solid, without holes. ``coarse`` is the index of the geometry that replaces it at a
    small size on the screen.
    """

    positions: npt.NDArray[np.float32]
    normals: npt.NDArray[np.float32]
    indices: npt.NDArray[np.uint32]
    colors: npt.NDArray[np.float32] | None = None
    chart: npt.NDArray[np.float32] | None = None
    is_closed: bool = True
    coarse: int | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Instances:
    """The instances of all frames, as ``columns`` by name.

    Per primitive entity: ``primitiveNode`` (its node in the DAG), ``primitiveGeometry`` (-1: not drawn),
    ``primitiveLook`` (12 floats: color, opacity, emission, ior, roughness, metallic, coat, sheen),
    ``primitiveSemantic``. Per row: ``rowPrimitive``, ``rowPath`` (into ``paths``), ``rowPose`` (12 floats, row-major).
    Per frame: rows ``frameRow[frameStart[f]:frameStart[f + 1]]`` in depth-first order. Textures, if there are any, are
    those of ``texture_columns``, with images of ``texture_side`` pixels.
    """

    geometries: tuple[Geometry, ...]
    paths: tuple[tuple[str, ...], ...]
    columns: dict[str, npt.NDArray[Any]]
    texture_side: int


@dataclass(frozen=True, slots=True, eq=False)
class _Rows:
    """The concatenated instances of all frames; ``start`` (F + 1) are the offsets of the frames."""

    primitives: list[Entity]
    primitive: IntArray
    paths: list[tuple[str, ...]]
    path: IntArray
    matrices: FloatArray
    start: IntArray


def instances_of(scene: Scene, center: FloatArray, scale: float, node_of: dict[int, int]) -> Instances:
    """Return the instances of every frame of ``scene`` after ``p -> scale (p - center)``.

    ``node_of`` maps ``id(entity)`` to its index in the DAG. Raises SceneError for invalid poses or attributes.
    """
    rows = _concatenate_frames(flatten(scene).frames)
    used = np.bincount(rows.primitive, minlength=len(rows.primitives))
    geometries, geometry_of, local = _geometries(rows.primitives, used)
    poses = composed(rows.matrices, local[rows.primitive])
    poses[:, :, 3] -= center
    poses *= scale
    flat = poses.reshape(-1, 12).astype(np.float32)
    distinct, row_of = _distinct_rows(flat, rows) if len(rows.start) > 2 else (slice(None), np.arange(len(flat)))
    looks = [look_of(entity) for entity in rows.primitives]
    side, textures = texture_columns(looks, local)
    columns: dict[str, npt.NDArray[Any]] = {
        "primitiveNode": np.array([node_of[id(entity)] for entity in rows.primitives], np.int32),
        "primitiveGeometry": geometry_of,
        "primitiveLook": _look_column(looks),
        "primitiveSemantic": np.array([is_semantic(entity) for entity in rows.primitives], np.uint8),
        "rowPrimitive": rows.primitive[distinct].astype(np.int32),
        "rowPath": rows.path[distinct].astype(np.int32),
        "rowPose": flat[distinct].reshape(-1),
        "frameStart": rows.start.astype(np.uint32),
        "frameRow": row_of.astype(np.uint32),
        **textures,
    }
    return Instances(tuple(geometries), tuple(rows.paths), columns, side)


def _concatenate_frames(frames: Sequence[FlatFrame]) -> _Rows:
    """Concatenate the instances of ``frames``, with common numbering of primitives and paths."""
    primitives: dict[int, int] = {}
    entities: list[Entity] = []
    paths: dict[tuple[str, ...], int] = {}
    primitive, path = [], []
    for frame in frames:
        for entity in frame.primitives:
            if id(entity) not in primitives:
                primitives[id(entity)] = len(entities)
                entities.append(entity)
        primitive_numbers = np.array([primitives[id(entity)] for entity in frame.primitives], np.int64)
        path_numbers = np.array([paths.setdefault(words, len(paths)) for words in frame.paths], np.int64)
        primitive.append(primitive_numbers[frame.index] if len(frame) else np.zeros(0, np.int64))
        path.append(path_numbers[frame.path_index] if len(frame) else np.zeros(0, np.int64))
    start = np.cumsum([0, *(len(frame) for frame in frames)])
    matrices = np.concatenate([frame.matrices for frame in frames])
    return _Rows(entities, np.concatenate(primitive), list(paths), np.concatenate(path), matrices, start)


def _distinct_rows(flat: npt.NDArray[np.float32], rows: _Rows) -> tuple[IntArray, IntArray]:
    """Return the first row of each set of equal rows, and for every instance the index of its distinct row."""
    keys = np.empty((len(flat), 14), np.uint32)
    keys[:, :12] = (flat + np.float32(0.0)).view(np.uint32)  # + 0.0 removes negative zeros
    keys[:, 12], keys[:, 13] = rows.primitive, rows.path
    odd = np.random.RandomState(0).randint(0, 1 << 62, 14).astype(np.uint64) * np.uint64(2) + np.uint64(1)
    hashed = (keys.astype(np.uint64) * odd).sum(axis=1, dtype=np.uint64)
    _, first, place = np.unique(hashed, return_index=True, return_inverse=True)
    if not (keys[first[place]] == keys).all():  # hash collision: compare the full rows
        _, first, place = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    return first.astype(np.int64), place.reshape(-1).astype(np.int64)


def _look_column(looks: Sequence[Look]) -> npt.NDArray[np.float32]:
    """Return the looks of primitives as a column; ``Instances`` documents the twelve floats."""
    table = np.zeros((len(looks), 12), np.float32)
    for row, look in zip(table, looks, strict=True):
        row[:3], row[3], row[4:7] = look.color, look.opacity, look.emission
        row[7] = NO_FACETS if look.is_diffuse else look.ior or GLASS
        row[8:] = MATTE if look.is_matte else look.gloss, look.metallic, look.coat, look.sheen
    return table.reshape(-1)


def _geometries(
    primitives: Sequence[Entity], used: IntArray
) -> tuple[list[Geometry], npt.NDArray[np.int32], FloatArray]:
    """Return the geometries, the index of each primitive's (-1: none) and its pose in the primitive's frame (P, 3,
    4)."""
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
            numbers[key] = _add(geometries, key, has_coarse=int(used.sum()) > _MAX_FINE_INSTANCES)
        geometry_of[i], local[i] = numbers[key], pose
    return geometries, geometry_of, local


def _add(geometries: list[Geometry], key: _FormKey | _MeshKey, *, has_coarse: bool) -> int:
    """Add the geometry of ``key``, preceded by its coarse version if there is one; return its index."""
    shape, detail = key
    if isinstance(shape, Primitive):
        mesh = own_mesh(shape)
        assert mesh is not None, "a mesh without faces has no key"
        offset = own_offset(mesh.vertices, mesh.faces)
        near = mesh if offset is None else replace(mesh, vertices=mesh.vertices - offset)
        geometries.append(_mesh_geometry(near, own_colors=detail is _OWN, has_chart=detail is _CHARTED))
        return len(geometries) - 1
    assert isinstance(detail, tuple)
    if shape.is_curved and has_coarse:
        geometries.append(_form_geometry(shape, detail, _COARSE_SIDES))
        geometries.append(replace(_form_geometry(shape, detail, _FINE_SIDES), coarse=len(geometries) - 1))
    else:
        geometries.append(_form_geometry(shape, detail, _FINE_SIDES))
    return len(geometries) - 1


def _geometry_key(entity: Entity) -> tuple[_FormKey | _MeshKey | None, FloatArray]:
    """Return the geometry key of a primitive and its pose (3, 4).

    The key is a canonical form or a mesh (with or without its own colors), None if the primitive is not drawn.
    """
    shape, identity = entity.shape, np.eye(4)[:3]
    if shape is None or not shape.has_geometry:
        return None, identity
    placed = shape.placed()
    if placed is not None:
        return (placed.form, placed.ratios), placed.matrix
    mesh = own_mesh(shape)
    if mesh is None:
        return None, identity
    offset = own_offset(mesh.vertices, mesh.faces)  # positions are float32
    pose = identity if offset is None else np.column_stack([np.eye(3), offset])
    texture = look_of(entity).texture
    if texture is not None and texture.projection == "uv":
        coordinates_of(entity, mesh)  # which says if it has none
        return (shape.key, _CHARTED), pose
    return (shape.key, _OWN if keeps_own_colors(entity, mesh) else _PLAIN), pose


def _form_geometry(form: CanonicalForm, ratios: tuple[float, ...], sides: int) -> Geometry:
    """Return the geometry of a canonical form."""
    return _smooth_geometry(form.mesh(sides, ratios))


def _smooth_geometry(mesh: Mesh) -> Geometry:
    """Return a mesh with smooth shading."""
    return Geometry(
        mesh.vertices.astype(np.float32).reshape(-1),
        mesh.shading.astype(np.float32).reshape(-1),
        mesh.faces.astype(np.uint32).reshape(-1),
    )


def _mesh_geometry(mesh: Mesh, *, own_colors: bool, has_chart: bool) -> Geometry:
    """Return a primitive's own mesh, flat-shaded if it has no normals; it may be open."""
    if mesh.normals is not None and not own_colors:
        return _smooth_geometry(mesh)
    corners, colors = mesh.corners, mesh.colors if own_colors else None
    return Geometry(
        corners.astype(np.float32).reshape(-1),
        np.repeat(triangle_normals(corners), 3, axis=0).astype(np.float32).reshape(-1),
        np.arange(3 * len(corners), dtype=np.uint32),
        None if colors is None else np.repeat(colors, 3, axis=0).astype(np.float32).reshape(-1),
        None if mesh.uv is None or not has_chart else mesh.uv.astype(np.float32).reshape(-1),
        is_closed=False,
    )


# Gaussian splats for the page, drawn instead of the solids.


class DrawnSplats(Protocol):
    """Gaussians of one frame as torch tensors: positions (N, 3), covariances (N, 3, 3), opacities (N,) and sRGB (N, 3).

    ``backends/neural/splats/gaussians.Splats`` is one; the viewer does not import torch.
    """

    @property
    def means(self) -> Any:
        """The positions (N, 3)."""
        ...

    @property
    def covariances(self) -> Any:
        """The covariances (N, 3, 3)."""
        ...

    @property
    def opacities(self) -> Any:
        """The opacities (N,)."""
        ...

    @property
    def colors(self) -> Any:
        """The sRGB colors (N, 3)."""
        ...

    def __len__(self) -> int: ...


SplatsOf = Callable[[Scene], Sequence[DrawnSplats]]  # Gaussians of every frame

MAX_SPLATS = 2_000_000  # in all frames: each takes four texels of 16 bytes on the GPU


def splat_columns(frames: Sequence[DrawnSplats], count: int, center: FloatArray, scale: float) -> dict[str, Any]:
    """Return the Gaussians of ``count`` frames after ``p -> scale (p - center)`` as columns.

    The columns are ``splatStart`` (F + 1), ``splatPlace`` (3 N), ``splatSpread`` (6 N: the upper triangle of the
    covariance, row by row), ``splatColor`` (4 N: sRGB and opacity). Frames beyond ``frames`` have none. Raises
    LimitError for more than MAX_SPLATS.
    """
    sizes = [len(splats) for splats in frames] + [0] * (count - len(frames))
    if sum(sizes) > MAX_SPLATS:
        message = f"the scene has {sum(sizes):,} Gaussians, more than the limit of {MAX_SPLATS:,} for this page"
        raise LimitError("primitives", message)
    rows = [_rows(splats, center, scale) for splats in frames]
    columns = {name: np.concatenate([row[name] for row in rows]) for name in rows[0]} if rows else {}
    return {"splatStart": np.concatenate([[0], np.cumsum(sizes)]).astype(np.uint32), **columns}


def _rows(splats: DrawnSplats, center: FloatArray, scale: float) -> dict[str, npt.NDArray[Any]]:
    """Return the Gaussians of one frame as columns, in the frame of the packet."""
    means, covariances, opacities, colors = (
        np.asarray(tensor.detach().cpu().double().numpy())
        for tensor in (splats.means, splats.covariances, splats.opacities, splats.colors)
    )
    upper = covariances[:, [0, 0, 0, 1, 1, 2], [0, 1, 2, 1, 2, 2]] * scale**2
    rgba = np.concatenate([colors, opacities[:, None]], axis=1)
    return {
        "splatPlace": (scale * (means - center)).astype(np.float32).ravel(),
        "splatSpread": upper.astype(np.float32).ravel(),
        "splatColor": np.rint(255.0 * np.clip(rgba, 0.0, 1.0)).astype(np.uint8).ravel(),
    }


FORMAT, VERSION = "scenelang-viewer", 1
MAGIC = b"SCNV"
LIMIT = 2_000_000  # primitives of a scene that is drawn
_ALIGNMENT = 8  # bytes, as typed arrays of the page need
_TYPES = {"float32": "f4", "int32": "i4", "uint32": "u4", "uint8": "u1"}


@dataclass(slots=True)
class _Columns:
    """Collects arrays for a packet; ``directory`` lists their types, offsets and lengths."""

    chunks: list[bytes] = field(default_factory=list)
    directory: dict[str, list[Any]] = field(default_factory=dict)
    size: int = 0

    def add(self, name: str, array: npt.NDArray[Any]) -> None:
        """Add an array as a column, little-endian and aligned."""
        data = np.ascontiguousarray(array).astype(array.dtype.newbyteorder("<"), copy=False).tobytes()
        self.directory[name] = [_TYPES[array.dtype.name], self.size, array.size]
        padded = data + bytes(-len(data) % _ALIGNMENT)
        self.chunks.append(padded)
        self.size += len(padded)


def packet_of(
    scene: Scene,
    limit: int = LIMIT,
    definitions: Mapping[str, Span] | None = None,
    splats: SplatsOf | None = None,
    tone: Callable[[Scene], Color] = tone_of,
) -> bytes:
    """Return the packet of ``scene``.

    A scene without geometry, or with more than ``limit`` primitives in all frames, yields a packet with only the tree;
    the header's ``notice`` is a one-line explanation. Raises SceneError("attribute") for invalid material attributes.

    Parameters
    ----------
    definitions : mapping, optional
        Where words are bound.
    splats : callable, optional
        Returns the Gaussians to draw instead of the solids.
    tone : callable, optional
        Returns the factor of the radiance behind the scene.
    """
    columns = _Columns()
    total = sum(primitive_count(root) for root in scene.frames)
    declared = scene
    scene, notice = _drawable(scene, total, limit)
    header = _header(scene) | {"notice": notice, "primitives": total}
    graph = graph_of(scene, definitions or {})
    header |= graph.tables
    for name, array in graph.columns.items():
        columns.add(name, array)
    if notice is None:
        try:
            _add_instances(columns, header, _instances(scene, header, graph.number))
            header["cameras"] = cameras_of(declared)
            header["studio"], panorama = studio_of(declared, tone(declared), unit_size(scene))
            if panorama is not None:
                columns.add("panorama", panorama.astype(np.float32).reshape(-1))
            if splats is not None:
                _add_splats(columns, scene, splats)
        except SceneError as error:
            if error.name not in ("empty-scene", "unsupported", "pose"):
                raise
            header["notice"] = _as_sentence(error)
    header["columns"] = columns.directory
    text = _json(header)
    text += b" " * (-(len(MAGIC) + 4 + len(text)) % _ALIGNMENT)
    return b"".join([MAGIC, struct.pack("<I", len(text)), text, *columns.chunks])


def _json(data: Any) -> bytes:
    """Return compact ASCII JSON."""
    return json.dumps(data, separators=(",", ":"), ensure_ascii=True).encode()


# Changes between packets: a page that has the last version of a scene receives only new parts.


CHANGES_MAGIC = b"SCNC"


def packet_changes(old: bytes, new: bytes) -> bytes:
    """Return the parts of the packet ``new`` that the packet ``old`` lacks, and the positions of the others in it.

    Layout: the four bytes ``SCNC``, the length of the header, the header, the new bytes. The header lists the parts of
    the packet in order: ``[start, length]`` of a part of the old packet, or ``[-1, length]`` of a new one. The common
    start and the common end of each column, and of each entry of the header, are parts of the old packet: that finds
    the one range that a usual edit changes in a few milliseconds. General differences (rsync, bsdiff) find more, and
    take longer than sending the bytes on one machine. ``viewer/src`` applies them.
    """
    old_sections = dict(_sections(old))
    parts: list[tuple[int, int]] = []
    new_bytes: list[bytes] = []
    for name, (start, end) in _sections(new):
        old_start, old_end = old_sections.get(name, (0, 0))
        before, after = _common_ends(old[old_start:old_end], new[start:end])
        middle = new[start + before : end - after]
        parts += [part for part in ((old_start, before), (-1, len(middle)), (old_end - after, after)) if part[1]]
        new_bytes.append(middle)
    text = _json(parts)
    return b"".join([CHANGES_MAGIC, struct.pack("<I", len(text)), text, *new_bytes])


def _sections(packet: bytes) -> Iterator[tuple[str, tuple[int, int]]]:
    """Iterate over the entries of the header and the columns of a packet, with their places, without gaps."""
    (length,) = struct.unpack_from("<I", packet, len(MAGIC))
    start, end = 0, len(MAGIC) + 4 + length
    header = json.loads(packet[len(MAGIC) + 4 : end])
    place = len(MAGIC) + 4
    for name, value in header.items():
        place += len(_json({name: value})) - 1  # with the brace or comma before it
        yield f"/{name}", (start, place)
        start = place
    yield "/", (start, end)
    starts = [end + offset for _, offset, _ in header["columns"].values()]
    yield from zip(header["columns"], zip(starts, [*starts[1:], len(packet)]))


def _common_ends(old: bytes, new: bytes) -> tuple[int, int]:
    """Return the lengths of the common start and of the common end, which do not overlap."""
    size = min(len(old), len(new))
    if old == new:
        return size, 0
    before = _first_difference(np.frombuffer(old, np.uint8, size), np.frombuffer(new, np.uint8, size))
    rest = size - before
    ends = (np.frombuffer(text, np.uint8)[len(text) - rest :][::-1] for text in (old, new))
    return before, _first_difference(*ends)


def _first_difference(a: npt.NDArray[np.uint8], b: npt.NDArray[np.uint8]) -> int:
    """Return the index of the first difference of arrays of one length, which is the length if there is none."""
    different = a != b
    return int(different.argmax()) if different.any() else len(a)


def _drawable(scene: Scene, total: int, limit: int) -> tuple[Scene, str | None]:
    """Return the scene with its blocks as cubes; or unchanged with a one-line reason why it cannot be drawn."""
    if total > limit:
        return scene, (
            f"The scene expands to {total:,} primitives, more than the limit of {limit:,} for this page; "
            "its tree is complete."
        )
    try:
        return with_file_images(drawn_scene(scene, limit)), None
    except LimitError as error:
        return scene, _as_sentence(error)


def _as_sentence(error: SceneError) -> str:
    """Return the message of an error as a sentence."""
    return error.message[:1].upper() + error.message[1:] + "."


def _header(scene: Scene) -> dict[str, Any]:
    """Return the header of a packet without geometry."""
    return {
        "format": FORMAT,
        "version": VERSION,
        "word": scene.word,
        "animated": scene.animated,
        "frames": len(scene.frames),
        "notice": None,
        "box": None,
        "cameras": [],
        "textureSide": 0,
        "geometries": [],
        "paths": [],
        "studio": studio_of(Scene(scene.word, scene.frames, scene.animated), (1.0, 1.0, 1.0), None)[0],
    }


def _instances(scene: Scene, header: dict[str, Any], node_of: dict[int, int]) -> Instances:
    """Return the instances of a scene at unit size; records its box in the header."""
    (low, high), (center, scale) = box_of(scene), unit_size(scene)
    header["box"] = {"low": low.tolist(), "high": high.tolist(), "center": center.tolist(), "scale": scale}
    return instances_of(scene, center, scale, node_of)


def _add_splats(columns: _Columns, scene: Scene, splats: SplatsOf) -> None:
    """Add the columns of Gaussians, unless there are none."""
    splat_arrays = splat_columns(splats(scene), len(scene.frames), *unit_size(scene))
    if "splatPlace" in splat_arrays:
        for name, array in splat_arrays.items():
            columns.add(name, array)


def _add_instances(columns: _Columns, header: dict[str, Any], instances: Instances) -> None:
    """Add the geometries and the columns of instances."""
    words = {word: i for i, word in enumerate(header["words"])}
    header["textureSide"] = instances.texture_side
    header["paths"] = [[words[word] for word in path] for path in instances.paths]
    for number, geometry in enumerate(instances.geometries):
        properties = {
            "colors": geometry.colors is not None, "chart": geometry.chart is not None, "closed": geometry.is_closed,
            "coarse": geometry.coarse,
        }  # fmt: skip
        header["geometries"].append(properties)
        columns.add(f"geometry{number}Positions", geometry.positions)
        columns.add(f"geometry{number}Normals", geometry.normals)
        columns.add(f"geometry{number}Indices", geometry.indices)
        if geometry.colors is not None:
            columns.add(f"geometry{number}Colors", geometry.colors)
        if geometry.chart is not None:
            columns.add(f"geometry{number}Chart", geometry.chart)
    for name, array in instances.columns.items():
        columns.add(name, array)


_SCRIPT = "text/javascript; charset=utf-8"
STATIC = {"viewer.js": _SCRIPT, "studio.js": _SCRIPT, "viewer.css": "text/css; charset=utf-8"}
_HEAD, _BODY = "<!--head-->", "<!--body-->"
_ICON = '<link rel="icon" href="data:,">'  # prevents browsers from requesting /favicon.ico


@dataclass(frozen=True, slots=True)
class SavedScene:
    """Scene to embed in a page, with the server's response ``state`` and its ``packet``, if any."""

    name: str
    state: Mapping[str, Any]
    packet: bytes | None


@cache
def static(name: str) -> bytes:
    """Return a built file; ``name`` is a key of ``STATIC`` or ``page.html``."""
    return files(__package__).joinpath("static", name).read_bytes()


def served_page(nonce: str | None = None) -> bytes:
    """Return the page for a server that also serves ``STATIC``: the studio's with the ``nonce`` of the editor's styles,
    else the viewer's."""
    mark = f'<meta name="style-nonce" content="{nonce}">' if nonce else ""
    head = f'{_ICON}{mark}<link rel="stylesheet" href="viewer.css">'
    script = "studio.js" if nonce else "viewer.js"
    return _template().replace(_HEAD, head).replace(_BODY, f'<script src="{script}"></script>').encode()


def frame_page() -> str:
    """Return the page of the notebook's widget, a frame that asks its parent; its policy forbids loading anything."""
    nonce = secrets.token_urlsafe(16)
    script = _embeddable(_text("studio.js"))
    policy = f"default-src 'none'; img-src data: blob:; script-src 'nonce-{nonce}'; style-src 'nonce-{nonce}'"
    head = f'<meta http-equiv="Content-Security-Policy" content="{policy}"><meta name="widget">'
    head += f'<meta name="style-nonce" content="{nonce}">'
    style = f'<style nonce="{nonce}">{_text("viewer.css")}</style>'
    body = f'<script nonce="{nonce}">{script}</script>'
    return _template().replace(_HEAD, head + style).replace(_BODY, body)


def self_contained_page(scenes: Sequence[SavedScene]) -> str:
    """Return an HTML page with the viewer and ``scenes`` embedded; its content security policy forbids loading
    anything."""
    return inline_page(_template(), _text("viewer.js"), _text("viewer.css"), "scenes", _scene_data(scenes))


def inline_page(template: str, script: str, style: str, name: str, data: Any) -> str:
    """Return ``template`` with a script, a style sheet, and ``data`` as JSON in the element ``name``.

    The content security policy allows only this script and style.
    """
    script = _embeddable(script)
    policy = f"default-src 'none'; img-src data:; script-src '{_digest(script)}'; style-src '{_digest(style)}'"
    head = f'<meta http-equiv="Content-Security-Policy" content="{html.escape(policy)}">{_ICON}<style>{style}</style>'
    body = f'<script type="application/json" id="{name}">{_json_text(data)}</script><script>{script}</script>'
    return template.replace(_HEAD, head).replace(_BODY, body)


def _embeddable(script: str) -> str:
    """Return a script without what would end its element."""
    return script.replace("</script", "<\\/script").replace("<!--", "<\\!--")


def page_path(text: str) -> str:
    """Validate a path for a page; raises UsageError for another extension, SceneError if the folder does not exist."""
    path = Path(text)
    if path.suffix.lower() not in (".html", ".htm"):
        raise UsageError("file", f"a page must be an .html file, not {path.name}")
    check_folder(path)
    return text


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class ViewerPage:
    """The interactive viewer as a self-contained HTML page; notebooks display it in an iframe."""

    html: str
    height: int

    @typed
    def save(self, path: str | Path) -> Path:
        """Write the page to a file. Returns the path."""
        write_text(path, self.html)
        return Path(path)

    def _repr_html_(self) -> str:
        """Return the page in an iframe, for notebooks."""
        return iframe(self.html, self.height)

    def __repr__(self) -> str:
        return f"<ViewerPage of {len(self.html):,} characters>"


def page_of(scene: Scene, limit: int, splats: SplatsOf | None = None) -> str:
    """Return the viewer with one scene as a self-contained HTML page; ``splats`` are drawn instead of the solids."""
    state: dict[str, Any] = {"name": scene.word, "version": 1, "ok": True, "picture": 1}
    state |= {"diagnostics": [], "params": []}
    return self_contained_page([SavedScene(scene.word, state, packet_of(scene, limit, splats=splats))])


def iframe(page: str, height: int) -> str:
    """Return an isolated iframe that shows ``page``; ``height`` in CSS pixels."""
    return (
        f'<iframe srcdoc="{html.escape(page)}" sandbox="allow-scripts" title="scene" '
        f'style="width:100%;height:{height}px;border:0"></iframe>'
    )


def _template() -> str:
    """Return the built page."""
    return _text("page.html")


def _text(name: str) -> str:
    """Return a built text file."""
    return static(name).decode()


def _digest(text: str) -> str:
    """Return the hash of a script or style for the content security policy."""
    return "sha256-" + base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()


def _json_text(data: Any) -> str:
    """Return ``data`` as JSON that is safe in a script element: every ``<`` is escaped."""
    return json.dumps(data).replace("<", "\\u003c")


def _scene_data(scenes: Sequence[SavedScene]) -> list[dict[str, Any]]:
    """Return the scenes as JSON data, their packets compressed."""
    return [
        {
            "name": scene.name,
            "state": dict(scene.state),
            "picture": None
            if scene.packet is None
            else base64.b64encode(gzip.compress(scene.packet, 6, mtime=0)).decode(),
        }
        for scene in scenes
    ]


def has_screen() -> bool:
    """Return whether a graphical browser can be opened."""
    if sys.platform in ("darwin", "win32"):
        return True
    return any(os.environ.get(name) for name in ("DISPLAY", "WAYLAND_DISPLAY", "BROWSER"))


def open_in_browser(address: str) -> bool:
    """Open a page in the browser if there is a display; return whether that was tried.

    Every user of the machine can read a browser's arguments, and an address of the viewer contains its token. Therefore
    a file that only its owner can read is opened, which redirects to the address.
    """
    page = _page_that_leads_to(address) if has_screen() else None
    if page is not None:
        import webbrowser

        webbrowser.open(page)
    return page is not None


def _page_that_leads_to(address: str) -> str | None:
    """Return the address of a private file that redirects to ``address``, which is deleted at the end of the process.

    None if the user's cache folder cannot be written. An address of a file is returned as it is.
    """
    if address.startswith("file:"):
        return address
    path = user_folder("CACHE") / f"view-{secrets.token_hex(8)}.html"
    escaped = html.escape(address)
    refresh = f'<meta http-equiv="refresh" content="0;url={escaped}">'
    text = f'<!doctype html><meta charset="utf-8">{refresh}<a href="{escaped}">scene</a>'
    try:
        path.parent.mkdir(0o700, parents=True, exist_ok=True)
        with open(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "w", encoding="utf-8") as file:
            file.write(text)
    except OSError:
        return None
    atexit.register(path.unlink, missing_ok=True)
    return path.as_uri()
