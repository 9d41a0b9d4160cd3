"""An independent reader of the glTF files that the tests write: world-space triangles at any moment."""

from __future__ import annotations

import json
import re
import struct
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import numpy as np

_TYPES = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}
_DTYPES = {5126: np.float32, 5125: np.uint32, 5123: np.uint16}


@dataclass(frozen=True)
class Seen:
    """A mesh in the world: the names of the nodes down to it, ``vertices`` (V, 3), ``faces`` (F, 3), linear
    ``colors`` (V, 3), the material and the extras of the entity's node."""

    path: tuple[str, ...]
    vertices: np.ndarray
    faces: np.ndarray
    colors: np.ndarray
    material: dict[str, Any]
    extras: dict[str, Any]


class Gltf:
    def __init__(self, path: Path) -> None:
        data = path.read_bytes()
        if path.suffix == ".glb":
            magic, version, total, length, kind = struct.unpack_from("<4sIIII", data)
            assert (magic, version, total, kind) == (b"glTF", 2, len(data), 0x4E4F534A)
            self.document = json.loads(data[20 : 20 + length])
            self.buffer = data[20 + length + 8 :]
        else:
            self.document = json.loads(data)
            self.buffer = b""
            if self.document.get("buffers"):
                self.buffer = (path.parent / unquote(self.document["buffers"][0]["uri"])).read_bytes()
        self.nodes = self.document["nodes"]

    def array(self, number: int) -> np.ndarray:
        accessor = self.document["accessors"][number]
        view = self.document["bufferViews"][accessor["bufferView"]]
        width, dtype = _TYPES[accessor["type"]], _DTYPES[accessor["componentType"]]
        flat = np.frombuffer(self.buffer, dtype, accessor["count"] * width, view["byteOffset"])
        values = flat.reshape(accessor["count"], width) if width > 1 else flat
        return values / 65535.0 if accessor.get("normalized") else values

    def fields(self, moment: float) -> list[dict[str, Any]]:
        """Translation, rotation and scale of every node at ``moment`` seconds."""
        found = [
            {k: np.array(node[k]) for k in ("translation", "rotation", "scale") if k in node} for node in self.nodes
        ]
        for animation in self.document.get("animations", ()):
            for channel in animation["channels"]:
                sampler = animation["samplers"][channel["sampler"]]
                times, values = self.array(sampler["input"]), self.array(sampler["output"]).astype(float)
                found[channel["target"]["node"]][channel["target"]["path"]] = _sampled(
                    times, values, moment, sampler["interpolation"]
                )
        return found

    def seen(self, moment: float = 0.0) -> list[Seen]:
        """Every mesh in depth-first order, but for those scaled to nothing by a node ``.../shown``."""
        return [
            one for mesh, world, names, extras in self.placed(moment) for one in self._mesh(mesh, world, names, extras)
        ]

    def placed(self, moment: float = 0.0) -> list[tuple[int, np.ndarray, tuple[str, ...], dict[str, Any]]]:
        """The number of every mesh that is seen, its world matrix, names down to it, its entity's extras."""
        fields = self.fields(moment)
        out = []
        stack: list[tuple[int, np.ndarray, tuple[str, ...], dict[str, Any]]] = [(0, np.eye(4), (), {})]
        while stack:
            number, above, names, extras = stack.pop()
            node = self.nodes[number]
            pose = _matrix(fields[number])
            if re.search(r"/shown(_\d+)?$", node["name"]):
                assert set(np.diag(pose)[:3]) in ({0.0}, {1.0})
                if pose[0, 0] == 0.0:
                    continue
            world = above @ pose
            extras = node.get("extras", extras)
            names = (*names, node.get("extras", node).get("word", node["name"]))
            if "mesh" in node:
                out += [(node["mesh"], world @ own, names, extras) for own in self._instances(node)]
            stack.extend((child, world, names, extras) for child in reversed(node.get("children", ())))
        return out

    def _instances(self, node: dict[str, Any]) -> list[np.ndarray]:
        """The poses in its own frame at which the mesh of a node is seen."""
        given = node.get("extensions", {}).get("EXT_mesh_gpu_instancing")
        if given is None:
            return [np.eye(4)]
        assert "EXT_mesh_gpu_instancing" in self.document["extensionsRequired"]
        columns = {name: self.array(number) for name, number in given["attributes"].items()}
        assert len({len(column) for column in columns.values()} | {node["extras"]["instances"]}) == 1
        names = [name for name in columns if not name.startswith("_")]
        return [
            _matrix({name.lower(): columns[name][row].astype(float) for name in names})
            for row in range(len(columns["TRANSLATION"]))
        ]

    def _mesh(self, number: int, world: np.ndarray, names: tuple[str, ...], extras: dict[str, Any]) -> list[Seen]:
        out = []
        for primitive in self.document["meshes"][number]["primitives"]:
            vertices = self.array(primitive["attributes"]["POSITION"]) @ world[:3, :3].T + world[:3, 3]
            material = self.document["materials"][primitive["material"]]
            colors = np.tile(material["pbrMetallicRoughness"]["baseColorFactor"][:3], (len(vertices), 1))
            if "COLOR_0" in primitive["attributes"]:
                colors = colors * self.array(primitive["attributes"]["COLOR_0"])[:, :3]
            faces = self.array(primitive["indices"]).reshape(-1, 3).astype(int)
            out.append(Seen(names, vertices, faces, colors, material, extras))
        return out


def _sampled(times: np.ndarray, values: np.ndarray, moment: float, how: str) -> np.ndarray:
    """The value of a track at ``moment``."""
    moment = np.float32(moment)
    after = int(np.searchsorted(times, moment))
    if after < len(times) and times[after] == moment:
        return values[after]
    if after == 0 or after == len(times):
        return values[min(after, len(times) - 1)]
    if how == "STEP":
        return values[after - 1]
    share = (moment - times[after - 1]) / (times[after] - times[after - 1])
    mixed = values[after - 1] * (1 - share) + values[after] * share
    return mixed / np.linalg.norm(mixed) if values.shape[1] == 4 else mixed


def _matrix(fields: dict[str, Any]) -> np.ndarray:
    x, y, z, w = fields.get("rotation", (0.0, 0.0, 0.0, 1.0))
    out = np.eye(4)
    out[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    out[:3, :3] *= fields.get("scale", np.ones(3))
    out[:3, 3] = fields.get("translation", np.zeros(3))
    return out
