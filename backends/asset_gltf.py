"""glTF files as they are before a library reads them: every index points at something, every range lies within its
buffer, nodes form trees, and all of it stays within limits."""

from __future__ import annotations

import base64
import binascii
import json
import struct
from collections import Counter
from collections.abc import Iterator, Sequence
from typing import Any

from scenelang.backends.asset_references import LARGEST_FILE, References
from scenelang.grammar.diagnostics import SceneError

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
        if sum(map(len, views)) > 2 * LARGEST_FILE:
            raise SceneError("file", f"the views of the asset {self._name} overlap and are too large together")
        sizes = [self._accessor(number, each, views) for number, each in enumerate(self._all("accessors"))]
        if sum(sizes) > 2 * LARGEST_FILE:
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
