"""Mesh files for the primitive "mesh": path checks, validation, loading and measurement."""

from __future__ import annotations

import base64
import binascii
import io
import json
import logging
import re
import struct
import warnings
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import numpy as np
import numpy.typing as npt

from scenelang.backends.base import require
from scenelang.backends.surfaces.image_files import (
    IMAGE_FORMATS,
    MAX_PIXELS,
    checked_image,
    from_srgb,
    linear_pixels,
)
from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.scene.primitives import MESH_ENDINGS
from scenelang.interpreter.scene.primitives.mesh import Mesh
from scenelang.interpreter.scene.primitives.mesh_file import Asset, located, set_mesh_loader
from scenelang.interpreter.scene.setup import is_panorama

# Support function of a point set: the extremes of a linear form. Points are sorted along a Morton curve into blocks
# with bounding boxes, so that only blocks that may contain the extreme point are opened. The result equals that of all
# points to the last bit. It needs no convex hull, whose computation can fail or take long, and no more memory than the
# points.


FloatArray = npt.NDArray[np.float64]

_CELLS = 1023  # grid cells per axis for sorting points: 10 bits, three of which fit a Morton code of 30 bits
_MIN_BLOCK = 64  # points of a block; smaller ones cost more to choose than to search


class PointSupport:
    """Support function of at least one point (N, 3); the points are copied."""

    __slots__ = ("_count", "_half", "_middle", "_points")

    def __init__(self, points: FloatArray) -> None:
        """Sort the points along a Morton curve into blocks of about the square root of their number."""
        low, high = points.min(axis=0), points.max(axis=0)
        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
            cell = np.nan_to_num((points - low) / (high - low) * _CELLS, nan=0.0)
        ordered = points[np.argsort(_interleaved(np.clip(cell, 0, _CELLS).astype(np.int64)), kind="stable")]
        is_new = np.ones(len(ordered), np.bool_)
        is_new[1:] = (ordered[1:] != ordered[:-1]).any(axis=1)
        unique = ordered[is_new]
        self._count = len(unique)
        size = max(_MIN_BLOCK, int(np.sqrt(self._count)))
        blocks = -(-self._count // size)
        padded = np.concatenate([unique, np.repeat(unique[-1:], blocks * size - self._count, axis=0)])
        self._points = np.ascontiguousarray(padded.reshape(blocks, size, 3).transpose(0, 2, 1))  # (B, 3, size)
        lows, highs = self._points.min(axis=2), self._points.max(axis=2)
        self._middle, self._half = 0.5 * lows + 0.5 * highs, 0.5 * highs - 0.5 * lows

    def __len__(self) -> int:
        return self._count

    def interval(self, a: float, b: float, c: float) -> tuple[float, float]:
        """Return the minimum and maximum of ``a x + b y + c z``."""
        with np.errstate(all="ignore"):  # overflow shows in the result
            return self._interval(np.array((a, b, c)))

    def _interval(self, direction: FloatArray) -> tuple[float, float]:
        """Return the minimum and maximum along a direction (3,)."""
        reach = self._half @ np.abs(direction)
        middle = self._middle @ direction
        slack = 1e-14 * (np.abs(self._middle) @ np.abs(direction) + reach)  # bound of the rounding error
        return -self._maximum(-direction, reach + slack - middle), self._maximum(direction, reach + slack + middle)

    def _maximum(self, direction: FloatArray, bounds: FloatArray) -> float:
        """Return the maximum, where ``bounds`` are upper bounds for each block."""
        best = self._block_maximum(int(np.argmax(bounds)), direction)
        others = np.flatnonzero(bounds > best)
        return max(best, self._block_maximum(others, direction)) if len(others) else best

    def _block_maximum(self, blocks: int | npt.NDArray[np.int64], direction: FloatArray) -> float:
        """Return the maximum of some blocks along a direction (3,)."""
        chosen = self._points[blocks]
        x, y, z = chosen[..., 0, :], chosen[..., 1, :], chosen[..., 2, :]
        return float((direction[0] * x + direction[1] * y + direction[2] * z).max())


def _interleaved(cells: npt.NDArray[np.int64]) -> npt.NDArray[np.int64]:
    """Return the Morton codes of cells (N, 3): the interleaved bits of three 10-bit numbers."""
    spread = cells.copy()
    for shift, mask in ((16, 0x30000FF), (8, 0x300F00F), (4, 0x30C30C3), (2, 0x9249249)):
        spread = (spread | (spread << shift)) & mask
    return np.asarray(spread[:, 0] | (spread[:, 1] << 1) | (spread[:, 2] << 2), np.int64)


def _uncharged(work: int) -> None:
    """Default for ``charge``: outside an evaluation no work is metered."""


class AssetFiles:
    """Finds and measures the mesh files of a scene.

    ``folder`` is the directory of the scene's file. Assets and the files they refer to must be inside ``project``.
    """

    def __init__(self, folder: Path, project: Path, allow_outside: bool) -> None:
        self._folder = folder
        self._project = project
        self._allow_outside = allow_outside

    def measure(self, file: str, charge: Callable[[int], None] = _uncharged) -> Asset:
        """Return the mesh file of a mesh file; raises SceneError if it cannot be read.

        ``charge`` meters the work, if possible before it is done, and raises LimitError if it exceeds the budget.
        """
        target = located(file, "mesh file", self._folder, self._project, self._allow_outside)
        is_inside = target.is_relative_to(self._project)
        state = target.stat()
        charge(_CLOCK_STEPS + (state.st_size >> 5))
        asset = _measured(str(target), str(self._project if is_inside else target.parent), state.st_mtime_ns)
        charge(_CLOCK_STEPS + (len(asset.support) >> 3))
        return asset

    def image(self, file: str, charge: Callable[[int], None] = _uncharged) -> str:
        """Return the path of an image of a texture, or of a panorama; raises SceneError if it cannot be one.

        Only the header of a texture is read, by Pillow: its size must be within ``MAX_PIXELS``. A panorama is read
        when an image is drawn.
        """
        target = located(file, "image", self._folder, self._project, self._allow_outside)
        charge(_CLOCK_STEPS)
        if target.stat().st_size > MAX_FILE_BYTES:
            raise SceneError("file", f"the image `{file[:80]}` is larger than {MAX_FILE_BYTES:,} bytes")
        if not is_panorama(target.name):
            checked_image(target, file)
        return str(target)


_CLOCK_STEPS = 4096  # steps after which a meter checks the clock


@lru_cache(maxsize=64)
def _measured(path: str, root: str, version: int) -> Asset:
    """Load and measure a mesh file; ``version`` is part of the cache key."""

    mesh = load_asset(path, root)
    points = mesh.vertices[np.unique(mesh.faces)]
    x0, y0, z0 = points.min(axis=0).tolist()
    x1, y1, z1 = points.max(axis=0).tolist()
    return Asset(path, root, (x0, y0, z0, x1, y1, z1), PointSupport(points))


# Files that a mesh file refers to: they must be inside the project folder (``..`` inside it is allowed), and images
# must not be too large. The mesh library gets these files only from here, so that security does not depend on its
# version or its rules. A mesh file outside the project (``--allow-outside``) may refer to its own folder.


MAX_FILE_BYTES = 128_000_000  # bytes, of a mesh file and separately of all files that it refers to
_MAX_VIEW_BYTES = 2 * MAX_FILE_BYTES  # bytes of all buffer views of a glTF file, which may overlap
_SCHEME = re.compile(r"[A-Za-z][A-Za-z0-9+.\-]*:")


class References:
    """Resolver for the files that the mesh file ``path`` refers to, all of which must be in ``root``.

    Implements trimesh's resolver interface. trimesh swallows some errors; the first one is saved in ``problem``.
    """

    def __init__(self, path: Path, root: Path, decoded: bool) -> None:
        self.file_name = path.name
        self.file_path = str(path)
        self.problem: SceneError | None = None
        self._folder = path.parent.resolve()
        self._root = root.resolve()
        self._decoded = decoded
        self._read: dict[str, bytes] = {}
        self._room = MAX_FILE_BYTES
        self._pixels = MAX_PIXELS

    def get(self, name: str) -> bytes:
        """Return the contents of the file ``name``; raises SceneError, or OSError if it does not exist."""
        if name not in self._read:
            try:
                self._read[name] = self._bytes(name)
            except SceneError as problem:
                self.problem = self.problem or problem
                raise
        return self._read[name]

    __getitem__ = get

    def namespaced(self, namespace: str) -> References:
        """Return this resolver itself: names are used exactly as written in the file."""
        return self

    def keys(self) -> list[str]:
        """Return the names that were read."""
        return list(self._read)

    def picture(self, data: bytes, what: str) -> None:
        """Check an image before it is decoded; ignores data that is not an image.

        Raises SceneError for an unsupported format, or if the total number of pixels exceeds the limit.
        """
        size = _size_of(data)
        if size is None:
            return
        self._pixels -= size[0] * size[1]
        if self._pixels < 0:
            message = (
                f"{what} of the mesh file {self.file_name} has {size[0]:,} x {size[1]:,} pixels; all pictures of a file"
            )
            raise SceneError("file", f"{message} together may have at most {MAX_PIXELS:,}")

    def _bytes(self, name: str) -> bytes:
        """Read a file within the limits of path, size and pixels."""
        target = self._target(name)
        if not target.is_file():  # never read a device or a pipe, which may have no end
            raise SceneError("file", f"the mesh file {self.file_name} refers to `{name[:80]}`, which does not exist")
        size = target.stat().st_size
        self._room -= size
        if self._room < 0:
            message = f"the files that the mesh file {self.file_name} refers to exceed the total limit"
            raise SceneError("file", f"{message} of {MAX_FILE_BYTES:,} bytes")
        with target.open("rb") as file:
            data = file.read(size)
        self.picture(data, f"`{name[:80]}`")
        return data

    def _target(self, name: str) -> Path:
        """Return the path of ``name`` with symbolic links resolved."""
        plain = unquote(name) if self._decoded else name
        shown = f"the mesh file {self.file_name} refers to `{name[:80]}`, which"
        if _SCHEME.match(plain) or "\\" in plain or "\0" in plain or Path(plain).is_absolute() or plain[:1] == "/":
            raise SceneError("import-outside", f"{shown} is not a relative path", hint=_HINT)
        try:
            target = (self._folder / plain).resolve()
        except (OSError, ValueError, RuntimeError):
            raise SceneError("file", f"{shown} is not a valid path") from None
        if not target.is_relative_to(self._root):
            raise SceneError("import-outside", f"{shown} is outside {self._root}", hint=_HINT)
        return target


_HINT = "move the mesh file's buffers, materials and images into the project folder, or embed them in the mesh file"


def _size_of(data: bytes) -> tuple[int, int] | None:
    """Return width and height of an image from its header, None if it is not an image.

    Raises SceneError for unsupported formats.
    """
    image = require("PIL.Image", "pillow")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", image.DecompressionBombWarning)
        try:
            with image.open(io.BytesIO(data)) as opened:
                kind, (width, height) = opened.format, opened.size
        except image.DecompressionBombError:
            raise SceneError("file", f"an image of a mesh file may have at most {MAX_PIXELS:,} pixels") from None
        except Exception:  # decoding an untrusted file may raise any exception
            return None
    if kind not in IMAGE_FORMATS:
        expected = ", ".join(IMAGE_FORMATS)
        raise SceneError("file", f"unsupported image format {kind} in a mesh file; expected one of {expected}")
    return width, height


# Validation of glTF files before a library reads them: every index and byte range is in bounds, nodes form trees, and
# sizes stay within limits.


MAX_NODES = 20_000  # nodes, placed primitives, or items of any other list of the file
MAX_TRIANGLES = 2_000_000  # of the file
_MAX_DEPTH = 100  # maximum nesting of nodes
_MAX_VALUES = 2_000_000  # of its JSON
_MAGIC, _JSON, _BINARY = b"glTF", 0x4E4F534A, 0x004E4942

# Locations of indices, and the list that each refers to.
_INDICES = (
    ("scene", "nodes.*", "nodes"),
    ("scenes", "nodes.*", "nodes"),
    ("nodes", "children.*", "nodes"),
    ("nodes", "mesh", "meshes"),
    ("nodes", "skin", "skins"),
    ("nodes", "camera", "cameras"),
    ("meshes", "primitives.*.indices", "accessors"),
    ("meshes", "primitives.*.material", "materials"),
    ("meshes", "primitives.*.attributes.*", "accessors"),
    ("meshes", "primitives.*.targets.*.*", "accessors"),
    ("accessors", "bufferView", "bufferViews"),
    ("accessors", "sparse.indices.bufferView", "bufferViews"),
    ("accessors", "sparse.values.bufferView", "bufferViews"),
    ("bufferViews", "buffer", "buffers"),
    ("images", "bufferView", "bufferViews"),
    ("textures", "source", "images"),
    ("textures", "sampler", "samplers"),
    ("materials", "pbrMetallicRoughness.baseColorTexture.index", "textures"),
    ("materials", "pbrMetallicRoughness.metallicRoughnessTexture.index", "textures"),
    ("materials", "normalTexture.index", "textures"),
    ("materials", "occlusionTexture.index", "textures"),
    ("materials", "emissiveTexture.index", "textures"),
    ("skins", "inverseBindMatrices", "accessors"),
    ("skins", "skeleton", "nodes"),
    ("skins", "joints.*", "nodes"),
)
_LISTS = tuple(dict.fromkeys([*(name for name, _, _ in _INDICES[1:]), *(target for _, _, target in _INDICES)]))
# Values of the glTF 2.0 specification (3.6.2.2, 5.24.4): bytes of component types, components of types, and modes.
_COMPONENTS = {5120: 1, 5121: 1, 5122: 2, 5123: 2, 5125: 4, 5126: 4}
_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}
_TRIANGLES, _STRIPS_AND_FANS = 4, (5, 6)


def checked_gltf(data: bytes, is_binary: bool, references: References) -> dict[str, Any]:
    """Return the JSON document of a glTF file after validating it.

    Parameters
    ----------
    data
        Contents of the file.
    is_binary
        Whether it is a .glb file, not .gltf.
    references
        Resolver of the files that it refers to.

    Raises
    ------
    SceneError
        For the first error in it.
    """
    text, binary = _chunks(data, references.file_name) if is_binary else (data, None)
    gltf = _Gltf(references, _document(text, references.file_name))
    gltf.check_lists()
    gltf.check_indices()
    gltf.check_trees()
    gltf.check_buffers(binary)
    gltf.check_triangles()
    return gltf.document


def _broken(name: str, what: str) -> SceneError:
    """Return the error of an invalid file."""
    return SceneError("file", f"the mesh file {name} is invalid: {what}")


def _chunks(data: bytes, name: str) -> tuple[bytes, bytes | None]:
    """Return the JSON and the binary chunk of a .glb file."""
    if len(data) < 20 or data[:4] != _MAGIC:
        raise _broken(name, "missing .glb header")
    chunks: dict[int, bytes] = {}
    at, end = 12, len(data)
    while at + 8 <= end:
        size, kind = struct.unpack_from("<II", data, at)
        if at + 8 + size > end:
            raise _broken(name, f"a chunk of {size:,} bytes at byte {at:,} exceeds the file size of {end:,}")
        chunks.setdefault(kind, data[at + 8 : at + 8 + size])
        at += 8 + size
    if _JSON not in chunks:
        raise _broken(name, "missing JSON chunk")
    return chunks[_JSON], chunks.get(_BINARY)


def _document(text: bytes, name: str) -> dict[str, Any]:
    """Parse the JSON of a glTF file, after bounding the number of its values by its punctuation."""
    if sum(text.count(mark) for mark in (b"{", b"[", b",")) > _MAX_VALUES:
        raise SceneError("file", f"the JSON of the mesh file {name} has more than the limit of {_MAX_VALUES:,} values")
    try:
        document = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise _broken(name, f"invalid JSON: {str(error)[:80]}") from None
    if not isinstance(document, dict):
        raise _broken(name, "its JSON is not an object")
    return document


class _Gltf:
    """A glTF document under validation."""

    def __init__(self, references: References, document: dict[str, Any]) -> None:
        self.document = document
        self._references = references
        self._name = references.file_name

    def _wrong(self, what: str) -> SceneError:
        """Return the error of this file."""
        return _broken(self._name, what)

    def _all(self, name: str) -> Sequence[dict[str, Any]]:
        """Return a list of the document, empty if it is absent."""
        items: Sequence[dict[str, Any]] = self.document.get(name) or ()
        return items

    def check_lists(self) -> None:
        """Check that every list contains objects and is not too long."""
        for name in _LISTS:
            items = self.document.get(name)
            if items is None:
                continue
            if not isinstance(items, list) or not all(isinstance(item, dict) for item in items):
                raise self._wrong(f"`{name}` is not a list of objects")
            if len(items) > MAX_NODES:
                message = f"the mesh file {self._name} has {len(items):,} {name}, more than the limit of {MAX_NODES:,}"
                raise SceneError("file", message)

    def check_indices(self) -> None:
        """Check that every index is an integer below the length of its list."""
        chosen = self.document.get("scene")
        if chosen is not None:
            self._check_index("scene", chosen, "scenes")
        for name, path, target in _INDICES[1:]:
            keys = path.split(".")
            for number, item in enumerate(self._all(name)):
                for place, value in self._values(item, keys, f"{name}[{number}]"):
                    self._check_index(place, value, target)

    def _values(self, item: Any, keys: Sequence[str], place: str) -> Iterator[tuple[str, Any]]:
        """Yield the values below ``item`` at ``keys`` with their paths; ``*`` matches every item or value."""
        if not keys:
            yield place, item
            return
        key, rest = keys[0], keys[1:]
        if key != "*":
            if not isinstance(item, dict):
                raise self._wrong(f"`{place}` is not an object")
            if key in item:
                yield from self._values(item[key], rest, f"{place}.{key}")
            return
        if not isinstance(item, (list, dict)):
            raise self._wrong(f"`{place}` is not a list")
        for inner, value in item.items() if isinstance(item, dict) else enumerate(item):
            yield from self._values(value, rest, f"{place}[{str(inner)[:40]}]")

    def _check_index(self, place: str, value: Any, target: str) -> None:
        """Check that a value is an index of the list ``target``."""
        count = len(self._all(target))
        if type(value) is not int or not 0 <= value < count:
            raise self._wrong(f"index `{place}` is {str(value)[:20]}, but the file has {count:,} {target}")

    def check_trees(self) -> None:
        """Check that nodes form trees: at most one parent each, and no cycles."""
        nodes = self._all("nodes")
        children = [list(node.get("children") or ()) for node in nodes]
        parents = Counter(child for siblings in children for child in siblings)
        double = next((node for node, count in parents.items() if count > 1), None)
        if double is not None:
            raise self._wrong(f"`nodes[{double}]` has several parents")
        level = [number for number in range(len(nodes)) if number not in parents]
        reached = depth = 0
        while level:
            reached, depth = reached + len(level), depth + 1
            level = [child for number in level for child in children[number]]
        if depth > _MAX_DEPTH:
            raise SceneError(
                "file", f"the nodes of the mesh file {self._name} are nested deeper than the limit of {_MAX_DEPTH}"
            )
        if reached < len(nodes):
            raise self._wrong("its `nodes` contain a cycle")

    # --- bytes -------------------------------------------------------------------------------------------------------

    def check_buffers(self, binary: bytes | None) -> None:
        """Check that buffers, views, accessors and images are in bounds, and that images are not too large.

        Parameters
        ----------
        binary
            Binary chunk of a .glb file, which is its first buffer; None for a .gltf file.

        Raises
        ------
        SceneError
            "file" if the file is malformed or exceeds a limit.
        OSError
            If a file that it refers to does not exist.
        """
        buffers = [self._buffer(number, buffer, binary) for number, buffer in enumerate(self._all("buffers"))]
        views = [self._view(number, view, buffers) for number, view in enumerate(self._all("bufferViews"))]
        if sum(map(len, views)) > _MAX_VIEW_BYTES:
            raise SceneError(
                "file", f"the buffer views of the mesh file {self._name} overlap and exceed the size limit in total"
            )
        sizes = [self._accessor(number, accessor, views) for number, accessor in enumerate(self._all("accessors"))]
        if sum(sizes) > _MAX_VIEW_BYTES:
            raise SceneError("file", f"the accessors of the mesh file {self._name} exceed the size limit in total")
        for number, image in enumerate(self._all("images")):
            where = f"images[{number}]"
            if "bufferView" in image:
                self._references.picture(bytes(views[image["bufferView"]]), where)
            elif "uri" in image:
                self._by_uri(image["uri"], where)  # raises if it cannot be read or is too large

    def _size(self, item: dict[str, Any], key: str, place: str, default: int | None = None) -> int:
        """Return a nonnegative integer of an object of the file."""
        value = item.get(key, default)
        if type(value) is not int or value < 0:
            raise self._wrong(f"`{place}.{key}` is not a valid size: {str(value)[:20]}")
        return value

    def _buffer(self, number: int, buffer: dict[str, Any], binary: bytes | None) -> memoryview:
        """Return the data of a buffer: of its URI, or the binary chunk for the first one."""
        place = f"buffers[{number}]"
        length = self._size(buffer, "byteLength", place)
        data = self._by_uri(buffer["uri"], place) if "uri" in buffer else binary if number == 0 else None
        if data is None or len(data) < length:
            available = 0 if data is None else len(data)
            raise self._wrong(f"`{place}.byteLength` is {length:,}, but the buffer has {available:,} bytes")
        return memoryview(data)

    def _by_uri(self, uri: Any, place: str) -> bytes:
        """Return the data of a base64 data URI, or of a file."""
        if not isinstance(uri, str):
            raise self._wrong(f"`{place}.uri` is not a string")
        if uri[:5].lower() != "data:":
            return self._references.get(uri)
        head, comma, text = uri.partition(",")
        if not comma or not head.lower().endswith(";base64"):
            raise self._wrong(f"`{place}.uri` is a data URI without base64 encoding")
        try:
            data = base64.b64decode(text)
        except (binascii.Error, ValueError):
            raise self._wrong(f"`{place}.uri` contains invalid base64") from None
        self._references.picture(data, place)
        return data

    def _view(self, number: int, view: dict[str, Any], buffers: Sequence[memoryview]) -> memoryview:
        """Return the data of a buffer view."""
        place = f"bufferViews[{number}]"
        if "buffer" not in view:
            raise self._wrong(f"`{place}` has no buffer")
        data = buffers[view["buffer"]]
        start, length = self._size(view, "byteOffset", place, 0), self._size(view, "byteLength", place)
        if start + length > len(data):
            raise self._wrong(f"`{place}` ends at byte {start + length:,} of a buffer of {len(data):,}")
        part: memoryview = data[start : start + length]
        return part

    def _accessor(self, number: int, accessor: dict[str, Any], views: Sequence[memoryview]) -> int:
        """Validate an accessor and return its size in bytes."""
        place = f"accessors[{number}]"
        component, kind = accessor.get("componentType"), accessor.get("type")
        if component not in _COMPONENTS or kind not in _WIDTHS:
            raise self._wrong(f"`{place}` has an unknown type")
        count, item = self._size(accessor, "count", place), _COMPONENTS[component] * _WIDTHS[kind]
        if "bufferView" in accessor:
            number_of_view = accessor["bufferView"]
            view = self._all("bufferViews")[number_of_view]
            step = self._size(view, "byteStride", f"bufferViews[{number_of_view}]", 0) or item
            end = self._size(accessor, "byteOffset", place, 0) + (count - 1) * step + item if count else 0
            if end > len(views[number_of_view]):
                available = len(views[number_of_view])
                raise self._wrong(f"`{place}` ends at byte {end:,} of a view of {available:,}")
        return count * item

    def check_triangles(self) -> None:
        """Check the number of placed parts and triangles, since a mesh can be instantiated many times."""
        sizes = [self._placed(number, mesh) for number, mesh in enumerate(self._all("meshes"))]
        meshes = [node["mesh"] for node in self._all("nodes") if "mesh" in node]
        parts = sum(sizes[mesh][0] for mesh in meshes) + sum(count for count, _ in sizes)
        if parts > MAX_NODES:
            message = f"the nodes of the mesh file {self._name} place {parts:,} parts, more than {MAX_NODES:,}"
            raise SceneError("file", message)
        triangles = sum(sizes[mesh][1] for mesh in meshes)
        if triangles > MAX_TRIANGLES:
            message = f"the mesh file {self._name} has {triangles:,} triangles, more than {MAX_TRIANGLES:,}"
            raise SceneError("file", message)

    def _placed(self, number: int, mesh: dict[str, Any]) -> tuple[int, int]:
        """Return the numbers of primitives and triangles of a mesh."""
        primitives = mesh.get("primitives")
        if not isinstance(primitives, list):
            raise self._wrong(f"`meshes[{number}]` has no primitives")
        triangles = 0
        for place, primitive in enumerate(primitives):
            attributes = primitive.get("attributes") or {}
            which = primitive.get("indices", attributes.get("POSITION"))
            if which is None:
                raise self._wrong(f"`meshes[{number}].primitives[{place}]` has no positions")
            count = self._all("accessors")[which]["count"]
            mode = primitive.get("mode", _TRIANGLES)
            triangles += count // 3 if mode == _TRIANGLES else max(count - 2, 0) if mode in _STRIPS_AND_FANS else 0
        return len(primitives), triangles


# Mesh files as colored triangles, for the primitive "mesh".


IntArray = npt.NDArray[np.int64]

_GLTF = (".glb", ".gltf")


def load_asset(file: str | Path, root: str | Path | None = None) -> Mesh:
    """Load a mesh file (glTF, OBJ, PLY, STL, OFF), with all its parts merged, in the file's frame with +y up.

    Parameters
    ----------
    file : str or Path
    root : str or Path, optional
        Directory that must contain the other files it refers to; by default the file's own.

    Raises
    ------
    SceneError
        "file" if it cannot be read, contains no mesh, or is too large; "import-outside" if it refers to files outside
        ``root``.
    """
    path = Path(file)
    if path.suffix.lower() not in MESH_ENDINGS:
        raise SceneError(
            "file",
            f"the mesh file {path.name} is not a supported mesh file",
            hint=f"supported extensions: {' '.join(MESH_ENDINGS)}",
        )
    try:
        state = path.stat()
    except OSError as error:
        raise SceneError("file", f"cannot read the mesh file {path.name}: {error.strerror or error}") from None
    if state.st_size > MAX_FILE_BYTES:
        raise SceneError(
            "file", f"the mesh file {path.name} has {state.st_size:,} bytes, more than the limit of {MAX_FILE_BYTES:,}"
        )
    return _loaded(str(path), str(root or path.resolve().parent), state.st_mtime_ns, state.st_size)


set_mesh_loader(load_asset)


_NULL_HANDLER = logging.NullHandler()


@lru_cache(maxsize=32)
def _loaded(path: str, root: str, changed: int, size: int) -> Mesh:
    """Load a mesh file; ``changed`` and ``size`` are part of the cache key."""
    ending, name = Path(path).suffix.lower(), Path(path).name
    references = References(Path(path), Path(root), decoded=ending in _GLTF)
    try:
        mesh = _mesh(Path(path), references)
    except SceneError:
        raise
    except Exception as error:  # decoding an untrusted file may raise any exception
        message = str(error).splitlines()[0][:120] if str(error) else type(error).__name__
        if isinstance(error, IndexError):
            message = f"index out of range ({message})"
        problem = SceneError("file", f"cannot read the mesh file {name} as a {ending} file: {message}")
        raise references.problem or problem from None
    if references.problem is not None:  # trimesh may have swallowed it
        raise references.problem
    return mesh


def _mesh(path: Path, references: References) -> Mesh:
    """Load the mesh of a file; raises SceneError, or any other exception for a malformed file."""
    trimesh = require("trimesh", "'scenelang[meshes]'")
    ending, name = path.suffix.lower(), path.name
    with path.open("rb") as file:
        data = file.read(MAX_FILE_BYTES + 1)
    document = checked_gltf(data, ending == ".glb", references) if ending in _GLTF else None
    # trimesh logs tracebacks for files that it then reads in another way; Python prints unhandled log records.
    logging.getLogger("trimesh").addHandler(_NULL_HANDLER)
    with np.errstate(all="ignore"):
        scene = trimesh.load_scene(io.BytesIO(data), file_type=ending[1:], resolver=references, process=False)
    parts = [part for part in _parts(scene) if isinstance(part[0], trimesh.Trimesh) and len(part[0].faces)]
    if not parts:
        raise SceneError("file", f"the mesh file {name} contains no mesh")
    meshes = [mesh for mesh, _ in parts]
    count = sum(len(mesh.faces) for mesh in meshes)
    if count > MAX_TRIANGLES:
        raise SceneError("file", f"the mesh file {name} has {count:,} triangles, more than {MAX_TRIANGLES:,}")
    for mesh in meshes:
        _check_faces(mesh, name)
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes[:-1])])
    vertices = np.concatenate([mesh.vertices @ pose[:3, :3].T + pose[:3, 3] for mesh, pose in parts])
    if not np.isfinite(vertices).all():
        raise SceneError("file", f"the mesh file {name} has vertices with non-finite coordinates")
    faces = np.concatenate([np.asarray(m.faces, np.int64) + start for m, start in zip(meshes, starts, strict=True)])
    factors = None if document is None else _gltf_factors(document)
    images: dict[int, _Image] = {}
    paints = [_paint(mesh, factors, images) for mesh in meshes]
    uv = None
    if any(paint.uv is not None for paint in paints):
        uv = np.concatenate([np.full((len(p), 3, 2), np.nan) if p.uv is None else p.uv for p in paints])
    if all(paint.color is None for paint in paints):
        return Mesh(vertices, None, faces, uv=uv)
    colors = np.concatenate([np.ones((len(p), 3)) if p.color is None else p.color for p in paints])
    if not images:
        return Mesh(vertices, None, faces, colors, uv=uv)
    image = np.concatenate([np.full(len(paint), paint.image) for paint in paints])
    tint = np.concatenate([np.tile(paint.factor, (len(paint), 1)) for paint in paints])
    pixels = tuple(image.pixels for image in images.values())
    return Mesh(vertices, None, faces, colors, uv=uv, image=image, images=pixels, tint=tint)


@dataclass(frozen=True, slots=True, eq=False)
class _Image:
    """A color image of a file: its number, and its linear pixels (H, W, 3)."""

    number: int
    pixels: npt.NDArray[np.float32]


@dataclass(frozen=True, slots=True, eq=False)
class _Paint:
    """The colors of a part with ``count`` faces.

    Attributes
    ----------
    color : (F, 3) or None
        Linear sRGB of its faces; where it has an image, that at the middle of each face.
    uv : (F, 3, 2) or None
        Texture coordinates of the corners.
    image
        Number of its image, -1 without one.
    factor : (3,)
        What its image is multiplied by.
    """

    count: int
    color: FloatArray | None = None
    uv: FloatArray | None = None
    image: int = -1
    factor: FloatArray = field(default_factory=lambda: np.ones(3))

    def __len__(self) -> int:
        return self.count


def _check_faces(mesh: Any, name: str) -> None:
    """Check that all faces of a mesh refer to its vertices."""
    low, high, count = int(mesh.faces.min()), int(mesh.faces.max()), len(mesh.vertices)
    if low < 0 or high >= count:
        wrong = low if low < 0 else high
        raise SceneError("file", f"the mesh file {name} is invalid: a face refers to vertex {wrong:,} of {count:,}")


def _parts(scene: Any) -> Iterator[tuple[Any, FloatArray]]:
    """Yield the placed geometries of a file, each with its pose (4, 4)."""
    for node in scene.graph.nodes_geometry:
        pose, name = scene.graph[node]
        yield scene.geometry[name], np.asarray(pose, np.float64)


def _gltf_factors(document: dict[str, Any]) -> dict[str, FloatArray]:
    """Return the linear base colors (3,) of a glTF file's materials by name.

    trimesh rounds them to bytes, which is visible in dark colors.
    """
    materials = document.get("materials") or ()
    factors = [
        (m.get("name"), (m.get("pbrMetallicRoughness") or {}).get("baseColorFactor", [1.0] * 4)) for m in materials
    ]
    named = Counter(name for name, _ in factors)
    return {name: np.array(factor[:3], np.float64) for name, factor in factors if name and named[name] == 1}


def _paint(mesh: Any, factors: dict[str, FloatArray] | None, images: dict[int, _Image]) -> _Paint:
    """Return the colors of a part, from its vertices or faces, or from its material and the image of this.

    ``factors`` are the material colors of a glTF file, whose vertex colors are linear too; None for other files.
    ``images`` are those of the file by ``id``, since many parts may share one; new ones are added.
    """
    visual, count = mesh.visual, len(mesh.faces)
    if visual.kind in ("vertex", "face"):
        if visual.kind == "vertex":
            encoded = np.asarray(visual.vertex_colors, np.float64)[:, :3][mesh.faces].mean(axis=1)
        else:
            encoded = np.asarray(visual.face_colors, np.float64)[:, :3]
        share = encoded / 255.0
        return _Paint(count, np.asarray(share if factors is not None else from_srgb(share), np.float64))
    material = getattr(visual, "material", None)
    uv = _coordinates(visual, mesh)
    if material is None:
        return _Paint(count, None, uv)
    factor, texture = _factor_and_texture(material)
    factor = (factors or {}).get(getattr(material, "name", None) or "", factor)
    if factor is None and texture is None:
        return _Paint(count, None, uv)
    factor = np.ones(3) if factor is None else factor
    colors = np.tile(factor, (count, 1))
    if texture is None or uv is None:
        return _Paint(count, colors, uv)
    if id(texture) not in images:
        images[id(texture)] = _Image(len(images), linear_pixels(texture))
    image = images[id(texture)]
    return _Paint(count, colors * _sample(image.pixels, uv.mean(axis=1)), uv, image.number, factor)


def _coordinates(visual: Any, mesh: Any) -> FloatArray | None:
    """Return the texture coordinates (F, 3, 2) of a part, None if it has none or invalid ones."""
    uv = getattr(visual, "uv", None)
    if uv is None or len(uv) != len(mesh.vertices):
        return None
    corners = np.asarray(uv, np.float64)[:, :2][mesh.faces]
    return corners if np.isfinite(corners).all() and np.abs(corners).max(initial=0.0) < _MAX_COORDINATE else None


_MAX_COORDINATE = 1e6  # of textures: beyond, single precision leaves no digits within a period


def _factor_and_texture(material: Any) -> tuple[FloatArray | None, Any]:
    """Return the linear factor (3,) and the texture of a glTF or OBJ material."""
    if hasattr(material, "baseColorFactor"):
        factor = material.baseColorFactor
        share = None if factor is None else _unit(np.asarray(factor)[:3])
        return share, material.baseColorTexture
    diffuse, texture = getattr(material, "diffuse", None), getattr(material, "image", None)
    if diffuse is None or texture is not None:  # with a texture, it is trimesh's default color
        return None, texture
    return np.asarray(from_srgb(_unit(np.asarray(diffuse)[:3])), np.float64), None


def _unit(values: npt.NDArray[Any]) -> FloatArray:
    """Return colors in [0, 1]; trimesh stores some of them as bytes."""
    return values.astype(np.float64) / 255.0 if values.dtype.kind in "ui" else np.clip(values.astype(np.float64), 0, 1)


def _sample(pixels: npt.NDArray[np.float32], uv: FloatArray) -> FloatArray:
    """Sample linear ``pixels`` (H, W, 3) at ``uv`` (F, 2), repeated beyond [0, 1]."""
    height, width = pixels.shape[:2]
    column = np.floor(np.mod(uv[:, 0], 1.0) * width).astype(np.int64) % width
    row = np.floor(np.mod(1.0 - uv[:, 1], 1.0) * height).astype(np.int64) % height
    return np.asarray(pixels[row, column], np.float64)
