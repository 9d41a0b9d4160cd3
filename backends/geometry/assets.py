"""Mesh files that programs place with the primitive "asset": found inside the project folder, and measured."""

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
from functools import lru_cache
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import numpy as np
import numpy.typing as npt

from scenelang.backends.base import need
from scenelang.backends.pictures.studio import from_srgb
from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.scene.primitives.asset import Asset, read_files_by
from scenelang.interpreter.scene.primitives.mesh import Mesh

# The greatest and least value of a linear form over the points of a mesh, which is how far it reaches in a direction.
#
# Points that are near one another stand in a block with a box of its own, so that only blocks that may hold the
# furthest
# point are opened. The answer is that of all points, to the last bit; it needs no convex hull, whose computation can
# fail
# or take long, and no more memory than the points.


FloatArray = npt.NDArray[np.float64]

_CELLS = 1023  # along each axis, by which points are sorted
_LEAST = 64  # points of a block


class PointSupport:
    """The reach of ``points`` (N, 3), at least one, which are copied."""

    __slots__ = ("_count", "_half", "_middle", "_points")

    def __init__(self, points: FloatArray) -> None:
        low, high = points.min(axis=0), points.max(axis=0)
        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
            cell = np.nan_to_num((points - low) / (high - low) * _CELLS, nan=0.0)
        ordered = points[np.argsort(_interleaved(np.clip(cell, 0, _CELLS).astype(np.int64)), kind="stable")]
        is_new = np.ones(len(ordered), np.bool_)
        is_new[1:] = (ordered[1:] != ordered[:-1]).any(axis=1)
        kept = ordered[is_new]
        self._count = len(kept)
        size = max(_LEAST, int(np.sqrt(self._count)))
        blocks = -(-self._count // size)
        padded = np.concatenate([kept, np.repeat(kept[-1:], blocks * size - self._count, axis=0)])
        self._points = np.ascontiguousarray(padded.reshape(blocks, size, 3).transpose(0, 2, 1))  # (B, 3, size)
        lows, highs = self._points.min(axis=2), self._points.max(axis=2)
        self._middle, self._half = 0.5 * lows + 0.5 * highs, 0.5 * highs - 0.5 * lows

    def __len__(self) -> int:
        return self._count

    def interval(self, a: float, b: float, c: float) -> tuple[float, float]:
        """The least and the greatest ``a x + b y + c z``."""
        with np.errstate(all="ignore"):  # numbers too large are told by what comes out
            return self._interval(np.array((a, b, c)))

    def _interval(self, direction: FloatArray) -> tuple[float, float]:
        reach = self._half @ np.abs(direction)
        middle = self._middle @ direction
        slack = 1e-14 * (np.abs(self._middle) @ np.abs(direction) + reach)  # what rounding may take off a bound
        return -self._greatest(-direction, reach + slack - middle), self._greatest(direction, reach + slack + middle)

    def _greatest(self, direction: FloatArray, bounds: FloatArray) -> float:
        """The greatest value, where ``bounds`` are those of each block."""
        best = self._most(int(np.argmax(bounds)), direction)
        others = np.flatnonzero(bounds > best)
        return max(best, self._most(others, direction)) if len(others) else best

    def _most(self, blocks: int | npt.NDArray[np.int64], direction: FloatArray) -> float:
        chosen = self._points[blocks]
        x, y, z = chosen[..., 0, :], chosen[..., 1, :], chosen[..., 2, :]
        return float((direction[0] * x + direction[1] * y + direction[2] * z).max())


def _interleaved(cells: npt.NDArray[np.int64]) -> npt.NDArray[np.int64]:
    """The bits of three numbers of ten bits each, (N, 3), in turn: Morton's order."""
    spread = cells.copy()
    for shift, mask in ((16, 0x30000FF), (8, 0x300F00F), (4, 0x30C30C3), (2, 0x9249249)):
        spread = (spread | (spread << shift)) & mask
    return np.asarray(spread[:, 0] | (spread[:, 1] << 1) | (spread[:, 2] << 2), np.int64)


def _uncharged(work: int) -> None:
    """Nothing is counted outside an evaluation."""


class AssetFiles:
    """Finds and measures the assets of a scene. ``folder`` is its file's own, ``project`` the one not to be left, by
    assets and by what they refer to."""

    def __init__(self, folder: Path, project: Path, allow_outside: bool) -> None:
        self._folder = folder
        self._project = project
        self._allow_outside = allow_outside

    def measure(self, file: str, charge: Callable[[int], None] = _uncharged) -> Asset:
        """What is known of the mesh file ``file``; raises SceneError when it cannot be read. ``charge`` counts the
        work, before it is done where that is known, and raises LimitError where it is too much."""
        try:
            target = (self._folder / file).resolve()
        except (OSError, ValueError, RuntimeError):
            raise SceneError("file", f"`{file[:80]}` is no path") from None
        is_inside = target.is_relative_to(self._project)
        if not self._allow_outside and not is_inside:
            hint = "assets must lie in the project folder; --allow-outside lifts this"
            raise SceneError("import-outside", f"`{file[:80]}` leads out of {self._project}", hint)
        if not target.is_file():
            raise SceneError("file", f"there is no asset {file[:200]}")
        state = target.stat()
        charge(_CHECKED + (state.st_size >> 5))
        asset = _measured(str(target), str(self._project if is_inside else target.parent), state.st_mtime_ns)
        charge(_CHECKED + (len(asset.support) >> 3))
        return asset


_CHECKED = 4096  # steps, after which a meter looks at the clock


@lru_cache(maxsize=64)
def _measured(path: str, root: str, version: int) -> Asset:
    """What is known of a mesh file; ``version`` tells its states apart."""

    mesh = load_asset(path, root)
    points = mesh.vertices[np.unique(mesh.faces)]
    x0, y0, z0 = points.min(axis=0).tolist()
    x1, y1, z1 = points.max(axis=0).tolist()
    return Asset(path, root, (x0, y0, z0, x1, y1, z1), PointSupport(points))


# What a mesh file refers to: other files, which must lie inside one folder, and pictures, which must not be too
# large.
#
# The library that reads meshes gets these files from here only, so that neither its version nor its own rules decide
# what is read.


LARGEST_FILE = 128_000_000  # bytes, of a mesh file and of all that it refers to
_LARGEST_VIEWS = 2 * LARGEST_FILE  # bytes of all views of a glTF file: they may overlap
MOST_PIXELS = 1 << 25  # of all pictures of a mesh file together: 8192 x 4096
_PICTURES = ("PNG", "JPEG", "WEBP", "BMP", "GIF", "TGA", "TIFF", "PPM")  # formats whose decoder runs no other program
_SCHEME = re.compile(r"[A-Za-z][A-Za-z0-9+.\-]*:")


class References:
    """Reads the files that the mesh file ``path`` refers to, all of which lie in ``root``. It has the methods of a
    resolver of trimesh, which drops some errors on the way; the first of them is kept in ``problem``."""

    def __init__(self, path: Path, root: Path, decoded: bool) -> None:
        self.file_name = path.name
        self.file_path = str(path)
        self.problem: SceneError | None = None
        self._folder = path.parent.resolve()
        self._root = root.resolve()
        self._decoded = decoded
        self._read: dict[str, bytes] = {}
        self._room = LARGEST_FILE
        self._pixels = MOST_PIXELS

    def get(self, name: str) -> bytes:
        """The bytes of the file called ``name``; raises SceneError, or OSError for a file that is not there."""
        if name not in self._read:
            try:
                self._read[name] = self._bytes(name)
            except SceneError as problem:
                self.problem = self.problem or problem
                raise
        return self._read[name]

    __getitem__ = get

    def namespaced(self, namespace: str) -> References:
        """This resolver itself: names are those that the file says."""
        return self

    def keys(self) -> list[str]:
        """The names that were read."""
        return list(self._read)

    def picture(self, data: bytes, what: str) -> None:
        """Count the pixels of a picture before anything decodes it; raises SceneError for too many, or for a format
        that is not read. What is no picture passes."""
        size = _size_of(data)
        if size is None:
            return
        self._pixels -= size[0] * size[1]
        if self._pixels < 0:
            message = (
                f"{what} of the asset {self.file_name} has {size[0]:,} x {size[1]:,} pixels; all pictures of an asset"
            )
            raise SceneError("file", f"{message} together may have {MOST_PIXELS:,}")

    def _bytes(self, name: str) -> bytes:
        target = self._target(name)
        if not target.is_file():  # never a device or a pipe, which may have no end
            raise SceneError("file", f"the asset {self.file_name} refers to `{name[:80]}`, and there is no such file")
        size = target.stat().st_size
        self._room -= size
        if self._room < 0:
            message = f"the files that the asset {self.file_name} refers to have more than the {LARGEST_FILE:,} bytes"
            raise SceneError("file", f"{message} that they may")
        with target.open("rb") as file:
            data = file.read(size)
        self.picture(data, f"`{name[:80]}`")
        return data

    def _target(self, name: str) -> Path:
        """The path that ``name`` leads to, links followed."""
        plain = unquote(name) if self._decoded else name
        shown = f"the asset {self.file_name} refers to `{name[:80]}`, which"
        if _SCHEME.match(plain) or "\\" in plain or "\0" in plain or Path(plain).is_absolute() or plain[:1] == "/":
            raise SceneError("import-outside", f"{shown} is no path relative to it", hint=_HINT)
        try:
            target = (self._folder / plain).resolve()
        except (OSError, ValueError, RuntimeError):
            raise SceneError("file", f"{shown} is no path") from None
        if not target.is_relative_to(self._root):
            raise SceneError("import-outside", f"{shown} leads out of {self._root}", hint=_HINT)
        return target


_HINT = "an asset's buffers, materials and pictures lie in the project folder, or in the asset itself"


def _size_of(data: bytes) -> tuple[int, int] | None:
    """Width and height of a picture, from its head; None for what is no picture. Raises SceneError for pictures that
    are not read."""
    image = need("PIL.Image", "pillow")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", image.DecompressionBombWarning)
        try:
            with image.open(io.BytesIO(data)) as opened:
                kind, (width, height) = opened.format, opened.size
        except image.DecompressionBombError:
            raise SceneError("file", f"a picture of an asset may have {MOST_PIXELS:,} pixels at most") from None
        except Exception:  # a reader of foreign files may raise anything
            return None
    if kind not in _PICTURES:
        raise SceneError("file", f"a picture of an asset is a {kind}; it may be one of {', '.join(_PICTURES)}")
    return width, height


# glTF files as they are before a library reads them: every index points at something, every range lies within its
# buffer, nodes form trees, and all of it stays within limits.


MOST_NODES = 20_000  # and placed primitives, and anything else that a list of the file holds
MOST_TRIANGLES = 2_000_000
_DEEPEST = 100  # nodes below one another
_MOST_VALUES = 2_000_000  # of its JSON
_MAGIC, _JSON, _BINARY = b"glTF", 0x4E4F534A, 0x004E4942

# Where indices stand, and the list that each is one of.
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
_COMPONENTS = {5120: 1, 5121: 1, 5122: 2, 5123: 2, 5125: 4, 5126: 4}
_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}


def checked_gltf(data: bytes, is_binary: bool, references: References) -> dict[str, Any]:
    """The document of a .glb or .gltf file. Raises SceneError for the first thing in it that is wrong."""
    text, binary = _chunks(data, references.file_name) if is_binary else (data, None)
    gltf = _Gltf(references, _document(text, references.file_name))
    gltf.check_lists()
    gltf.check_indices()
    gltf.check_trees()
    gltf.check_buffers(binary)
    gltf.check_triangles()
    return gltf.document


def _broken(name: str, what: str) -> SceneError:
    return SceneError("file", f"the asset {name} is broken: {what}")


def _chunks(data: bytes, name: str) -> tuple[bytes, bytes | None]:
    """The JSON and the binary chunk of a .glb file."""
    if len(data) < 20 or data[:4] != _MAGIC:
        raise _broken(name, "it does not begin as a .glb file does")
    found: dict[int, bytes] = {}
    at, end = 12, len(data)
    while at + 8 <= end:
        size, kind = struct.unpack_from("<II", data, at)
        if at + 8 + size > end:
            raise _broken(name, f"a chunk of {size:,} bytes begins at byte {at:,} of {end:,}")
        found.setdefault(kind, data[at + 8 : at + 8 + size])
        at += 8 + size
    if _JSON not in found:
        raise _broken(name, "it has no JSON chunk")
    return found[_JSON], found.get(_BINARY)


def _document(text: bytes, name: str) -> dict[str, Any]:
    if sum(text.count(mark) for mark in (b"{", b"[", b",")) > _MOST_VALUES:
        raise SceneError("file", f"the JSON of the asset {name} has more than the {_MOST_VALUES:,} values that it may")
    try:
        document = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise _broken(name, f"its JSON cannot be read: {str(error)[:80]}") from None
    if not isinstance(document, dict):
        raise _broken(name, "its JSON is no object")
    return document


class _Gltf:
    """One document while it is checked."""

    def __init__(self, references: References, document: dict[str, Any]) -> None:
        self.document = document
        self._references = references
        self._name = references.file_name

    def _wrong(self, what: str) -> SceneError:
        return _broken(self._name, what)

    def _all(self, name: str) -> Sequence[dict[str, Any]]:
        found: Sequence[dict[str, Any]] = self.document.get(name) or ()
        return found

    def check_lists(self) -> None:
        """Every list is one of objects, and not too long."""
        for name in _LISTS:
            items = self.document.get(name)
            if items is None:
                continue
            if not isinstance(items, list) or not all(isinstance(item, dict) for item in items):
                raise self._wrong(f"`{name}` is no list of objects")
            if len(items) > MOST_NODES:
                message = f"the asset {self._name} has {len(items):,} {name}, more than the {MOST_NODES:,} that it may"
                raise SceneError("file", message)

    def check_indices(self) -> None:
        """Every index is a whole number below the length of its list."""
        chosen = self.document.get("scene")
        if chosen is not None:
            self._check_index("scene", chosen, "scenes")
        for name, path, target in _INDICES[1:]:
            keys = path.split(".")
            for number, item in enumerate(self._all(name)):
                for place, value in self._values(item, keys, f"{name}[{number}]"):
                    self._check_index(place, value, target)

    def _values(self, item: Any, keys: Sequence[str], place: str) -> Iterator[tuple[str, Any]]:
        """What stands below ``item`` at ``keys``, of which ``*`` is every item or value, with its place."""
        if not keys:
            yield place, item
            return
        key, rest = keys[0], keys[1:]
        if key != "*":
            if not isinstance(item, dict):
                raise self._wrong(f"`{place}` is no object")
            if key in item:
                yield from self._values(item[key], rest, f"{place}.{key}")
            return
        if not isinstance(item, (list, dict)):
            raise self._wrong(f"`{place}` is no list")
        for inner, value in item.items() if isinstance(item, dict) else enumerate(item):
            yield from self._values(value, rest, f"{place}[{str(inner)[:40]}]")

    def _check_index(self, place: str, value: Any, target: str) -> None:
        count = len(self._all(target))
        if type(value) is not int or not 0 <= value < count:
            raise self._wrong(f"`{place}` is {str(value)[:20]}, and the file has {count:,} {target}")

    def check_trees(self) -> None:
        """A node is a child of one other at most, and of none below itself."""
        nodes = self._all("nodes")
        children = [list(node.get("children") or ()) for node in nodes]
        parents = Counter(child for each in children for child in each)
        double = next((node for node, count in parents.items() if count > 1), None)
        if double is not None:
            raise self._wrong(f"`nodes[{double}]` is a child of several nodes")
        level = [number for number in range(len(nodes)) if number not in parents]
        seen = depth = 0
        while level:
            seen, depth = seen + len(level), depth + 1
            level = [child for number in level for child in children[number]]
        if depth > _DEEPEST:
            raise SceneError(
                "file", f"the nodes of the asset {self._name} are nested deeper than the {_DEEPEST} they may"
            )
        if seen < len(nodes):
            raise self._wrong("its `nodes` are below one another in a circle")

    # --- bytes -------------------------------------------------------------------------------------------------------

    def check_buffers(self, binary: bytes | None) -> None:
        """Buffers, views, accessors and pictures lie within one another, and pictures are not too large."""
        buffers = [self._buffer(number, each, binary) for number, each in enumerate(self._all("buffers"))]
        views = [self._view(number, each, buffers) for number, each in enumerate(self._all("bufferViews"))]
        if sum(map(len, views)) > _LARGEST_VIEWS:
            raise SceneError("file", f"the views of the asset {self._name} overlap and are too large together")
        sizes = [self._accessor(number, each, views) for number, each in enumerate(self._all("accessors"))]
        if sum(sizes) > _LARGEST_VIEWS:
            raise SceneError("file", f"the accessors of the asset {self._name} are too large together")
        for number, image in enumerate(self._all("images")):
            where = f"images[{number}]"
            if "bufferView" in image:
                self._references.picture(bytes(views[image["bufferView"]]), where)
            elif "uri" in image:
                self._by_uri(image["uri"], where)

    def _size(self, item: dict[str, Any], key: str, place: str, default: int | None = None) -> int:
        value = item.get(key, default)
        if type(value) is not int or value < 0:
            raise self._wrong(f"`{place}.{key}` is {str(value)[:20]}, and no size")
        return value

    def _buffer(self, number: int, buffer: dict[str, Any], binary: bytes | None) -> memoryview:
        place = f"buffers[{number}]"
        length = self._size(buffer, "byteLength", place)
        data = self._by_uri(buffer["uri"], place) if "uri" in buffer else binary if number == 0 else None
        if data is None or len(data) < length:
            had = 0 if data is None else len(data)
            raise self._wrong(f"`{place}.byteLength` is {length:,}, and there are {had:,} bytes")
        return memoryview(data)

    def _by_uri(self, uri: Any, place: str) -> bytes:
        if not isinstance(uri, str):
            raise self._wrong(f"`{place}.uri` is no text")
        if uri[:5].lower() != "data:":
            return self._references.get(uri)
        head, comma, text = uri.partition(",")
        if not comma or not head.lower().endswith(";base64"):
            raise self._wrong(f"`{place}.uri` holds data that are not in base64")
        try:
            data = base64.b64decode(text)
        except (binascii.Error, ValueError):
            raise self._wrong(f"`{place}.uri` holds data that are no base64") from None
        self._references.picture(data, place)
        return data

    def _view(self, number: int, view: dict[str, Any], buffers: Sequence[memoryview]) -> memoryview:
        place = f"bufferViews[{number}]"
        if "buffer" not in view:
            raise self._wrong(f"`{place}` has no buffer")
        data = buffers[view["buffer"]]
        start, length = self._size(view, "byteOffset", place, 0), self._size(view, "byteLength", place)
        if start + length > len(data):
            raise self._wrong(f"`{place}` ends at byte {start + length:,} of a buffer of {len(data):,}")
        found: memoryview = data[start : start + length]
        return found

    def _accessor(self, number: int, accessor: dict[str, Any], views: Sequence[memoryview]) -> int:
        """Its size in bytes."""
        place = f"accessors[{number}]"
        component, kind = accessor.get("componentType"), accessor.get("type")
        if component not in _COMPONENTS or kind not in _WIDTHS:
            raise self._wrong(f"`{place}` has no type that there is")
        count, item = self._size(accessor, "count", place), _COMPONENTS[component] * _WIDTHS[kind]
        if "bufferView" in accessor:
            number_of_view = accessor["bufferView"]
            view = self._all("bufferViews")[number_of_view]
            step = self._size(view, "byteStride", f"bufferViews[{number_of_view}]", 0) or item
            end = self._size(accessor, "byteOffset", place, 0) + (count - 1) * step + item if count else 0
            if end > len(views[number_of_view]):
                held = len(views[number_of_view])
                raise self._wrong(f"`{place}` ends at byte {end:,} of a view of {held:,}")
        return count * item

    def check_triangles(self) -> None:
        """What the nodes place is not too much: meshes can stand in many places."""
        sizes = [self._placed(number, mesh) for number, mesh in enumerate(self._all("meshes"))]
        meshes = [node["mesh"] for node in self._all("nodes") if "mesh" in node]
        parts = sum(sizes[mesh][0] for mesh in meshes) + sum(count for count, _ in sizes)
        if parts > MOST_NODES:
            message = (
                f"the nodes of the asset {self._name} place {parts:,} parts, more than the {MOST_NODES:,} that they may"
            )
            raise SceneError("file", message)
        triangles = sum(sizes[mesh][1] for mesh in meshes)
        if triangles > MOST_TRIANGLES:
            message = f"the asset {self._name} has {triangles:,} triangles, more than the {MOST_TRIANGLES:,} it may"
            raise SceneError("file", message)

    def _placed(self, number: int, mesh: dict[str, Any]) -> tuple[int, int]:
        """The primitives of a mesh, and their triangles."""
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
            mode = primitive.get("mode", 4)
            triangles += count // 3 if mode == 4 else max(count - 2, 0) if mode in (5, 6) else 0
        return len(primitives), triangles


# Mesh files as triangles with colours, for the primitive "asset".


IntArray = npt.NDArray[np.int64]

ENDINGS = (".glb", ".gltf", ".obj", ".ply", ".stl", ".off")
_GLTF = (".glb", ".gltf")


def load_asset(file: str | Path, root: str | Path | None = None) -> Mesh:
    """The mesh of a file (glTF, OBJ, PLY, STL, OFF), of all its parts together, in the file's frame with +y up.

    The other files that it refers to lie in the folder ``root``, by default its own. Raises SceneError: "file" where it
    cannot be read, holds no mesh, or is too large, "import-outside" where it refers to what lies elsewhere.
    """
    path = Path(file)
    if path.suffix.lower() not in ENDINGS:
        raise SceneError("file", f"the asset {path.name} is no mesh file", hint=f"it can be one of {' '.join(ENDINGS)}")
    try:
        state = path.stat()
    except OSError as error:
        raise SceneError("file", f"the asset {path.name} cannot be read: {error.strerror or error}") from None
    if state.st_size > LARGEST_FILE:
        raise SceneError(
            "file", f"the asset {path.name} has {state.st_size:,} bytes, more than the {LARGEST_FILE:,} that it may"
        )
    return _loaded(str(path), str(root or path.resolve().parent), state.st_mtime_ns, state.st_size)


read_files_by(load_asset)


_QUIET = logging.NullHandler()


@lru_cache(maxsize=32)
def _loaded(path: str, root: str, changed: int, size: int) -> Mesh:
    """The mesh of a file in the state that ``changed`` and ``size`` tell apart from others."""
    ending, name = Path(path).suffix.lower(), Path(path).name
    references = References(Path(path), Path(root), decoded=ending in _GLTF)
    try:
        mesh = _mesh(Path(path), references)
    except SceneError:
        raise
    except Exception as error:  # a reader of foreign files may raise anything
        said = str(error).splitlines()[0][:120] if str(error) else type(error).__name__
        if isinstance(error, IndexError):
            said = f"it refers to something that is not there ({said})"
        problem = SceneError("file", f"the asset {name} cannot be read as a {ending} file: {said}")
        raise references.problem or problem from None
    if references.problem is not None:  # which the reader of meshes may have passed over
        raise references.problem
    return mesh


def _mesh(path: Path, references: References) -> Mesh:
    """The mesh of a file; raises SceneError, or anything else for files that cannot be read."""
    trimesh = need("trimesh", "trimesh")
    ending, name = path.suffix.lower(), path.name
    with path.open("rb") as file:
        data = file.read(LARGEST_FILE + 1)
    document = checked_gltf(data, ending == ".glb", references) if ending in _GLTF else None
    # It logs tracebacks of files that it reads in another way then, which Python prints where nobody takes them.
    logging.getLogger("trimesh").addHandler(_QUIET)
    with np.errstate(all="ignore"):
        scene = trimesh.load_scene(io.BytesIO(data), file_type=ending[1:], resolver=references, process=False)
    parts = [part for part in _parts(scene) if isinstance(part[0], trimesh.Trimesh) and len(part[0].faces)]
    if not parts:
        raise SceneError("file", f"the asset {name} holds no mesh")
    meshes = [mesh for mesh, _ in parts]
    count = sum(len(mesh.faces) for mesh in meshes)
    if count > MOST_TRIANGLES:
        raise SceneError("file", f"the asset {name} has {count:,} triangles, more than the {MOST_TRIANGLES:,} it may")
    for mesh in meshes:
        _check_faces(mesh, name)
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes[:-1])])
    vertices = np.concatenate([mesh.vertices @ pose[:3, :3].T + pose[:3, 3] for mesh, pose in parts])
    if not np.isfinite(vertices).all():
        raise SceneError("file", f"the asset {name} has vertices that are no numbers")
    faces = np.concatenate([np.asarray(m.faces, np.int64) + start for m, start in zip(meshes, starts, strict=True)])
    factors = None if document is None else _gltf_factors(document)
    pictures: dict[int, npt.NDArray[np.uint8]] = {}
    colors = [_colors(mesh, factors, pictures) for mesh in meshes]
    if all(color is None for color in colors):
        return Mesh(vertices, None, faces)
    filled = [np.ones((len(m.faces), 3)) if c is None else c for m, c in zip(meshes, colors, strict=True)]
    return Mesh(vertices, None, faces, np.concatenate(filled))


def _check_faces(mesh: Any, name: str) -> None:
    low, high, count = int(mesh.faces.min()), int(mesh.faces.max()), len(mesh.vertices)
    if low < 0 or high >= count:
        wrong = low if low < 0 else high
        raise SceneError("file", f"the asset {name} is broken: a face has vertex {wrong:,}, and there are {count:,}")


def _parts(scene: Any) -> Iterator[tuple[Any, FloatArray]]:
    """The geometries of a file where they stand: each with its pose (4, 4)."""
    for node in scene.graph.nodes_geometry:
        pose, name = scene.graph[node]
        yield scene.geometry[name], np.asarray(pose, np.float64)


def _gltf_factors(document: dict[str, Any]) -> dict[str, FloatArray]:
    """The base colours (3,), linear, of a glTF file's materials by name: trimesh rounds them to bytes, which shows in
    dark colours."""
    materials = document.get("materials") or ()
    given = [
        (m.get("name"), (m.get("pbrMetallicRoughness") or {}).get("baseColorFactor", [1.0] * 4)) for m in materials
    ]
    named = Counter(name for name, _ in given)
    return {name: np.array(factor[:3], np.float64) for name, factor in given if name and named[name] == 1}


def _colors(
    mesh: Any, factors: dict[str, FloatArray] | None, pictures: dict[int, npt.NDArray[np.uint8]]
) -> FloatArray | None:
    """The linear colours (F, 3) of a mesh's faces: of its vertices or faces, or of its material and texture.

    ``factors`` are the materials' colours of a glTF file, whose vertex colours are linear too; None for other files.
    ``pictures`` keeps the pixels of textures, by ``id``: many parts may share one.
    """
    visual = mesh.visual
    if visual.kind in ("vertex", "face"):
        if visual.kind == "vertex":
            encoded = np.asarray(visual.vertex_colors, np.float64)[:, :3][mesh.faces].mean(axis=1)
        else:
            encoded = np.asarray(visual.face_colors, np.float64)[:, :3]
        share = encoded / 255.0
        return np.asarray(share if factors is not None else from_srgb(share), np.float64)
    material = getattr(visual, "material", None)
    if material is None:
        return None
    factor, texture = _factor_and_texture(material)
    factor = (factors or {}).get(getattr(material, "name", None) or "", factor)
    uv = getattr(visual, "uv", None)
    if factor is None and texture is None:
        return None
    colors = np.tile(np.ones(3) if factor is None else factor, (len(mesh.faces), 1))
    if texture is not None and uv is not None and len(uv) == len(mesh.vertices):
        if id(texture) not in pictures:
            pictures[id(texture)] = np.asarray(texture.convert("RGB"))
        colors *= _sampled(pictures[id(texture)], np.asarray(uv, np.float64)[mesh.faces].mean(axis=1))
    return colors


def _factor_and_texture(material: Any) -> tuple[FloatArray | None, Any]:
    """The linear factor (3,) and the texture of a material of glTF's kind or of OBJ's."""
    if hasattr(material, "baseColorFactor"):
        factor = material.baseColorFactor
        share = None if factor is None else _unit(np.asarray(factor)[:3])
        return share, material.baseColorTexture
    diffuse, texture = getattr(material, "diffuse", None), getattr(material, "image", None)
    if diffuse is None or texture is not None:  # what comes with a texture is the reader's own default
        return None, texture
    return np.asarray(from_srgb(_unit(np.asarray(diffuse)[:3])), np.float64), None


def _unit(values: npt.NDArray[Any]) -> FloatArray:
    """Colours as shares: trimesh keeps some of them as bytes."""
    return values.astype(np.float64) / 255.0 if values.dtype.kind in "ui" else np.clip(values.astype(np.float64), 0, 1)


def _sampled(pixels: npt.NDArray[np.uint8], uv: FloatArray) -> FloatArray:
    """The linear colours (F, 3) of ``pixels`` (H, W, 3) at ``uv`` (F, 2), repeated beyond [0, 1]."""
    height, width = pixels.shape[:2]
    column = np.floor(np.mod(uv[:, 0], 1.0) * width).astype(np.int64) % width
    row = np.floor(np.mod(1.0 - uv[:, 1], 1.0) * height).astype(np.int64) % height
    return np.asarray(from_srgb(pixels[row, column].astype(np.float64) / 255.0), np.float64)
