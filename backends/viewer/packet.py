"""A scene as one compact packet of bytes for the page: the entity DAG, and what its primitives look like.

Layout: the four bytes ``SCNV``, the length of the header (32-bit, little-endian), the header (JSON, padded with spaces
to a multiple of eight), then the columns. A column is an array that the header names with its type, place and length.
The page gets the DAG, never its expansion: paths, handles and counts are worked out there. Instances are rows
(primitive, pose, path of words); a row that stands in several frames is sent once, and a frame is a list of numbers of
rows in depth-first order. Poses and geometry are in the stage's frame (see ``stage``): box centred, half diagonal 1.
"""

from __future__ import annotations

import json
import math
import struct
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.minecraft.cubes import as_cubes
from scenelang.backends.shots import box_of
from scenelang.backends.stage import unit_size
from scenelang.backends.studio import BRIGHTEST, ENVIRONMENTS, SHOULDER
from scenelang.backends.viewer.graph import graph_of
from scenelang.backends.viewer.instances import Instances, instances_of
from scenelang.backends.viewer.splats import SplatsOf, splat_columns
from scenelang.grammar.diagnostics import LimitError, SceneError
from scenelang.grammar.source import Span
from scenelang.interpreter.entity import Scene, primitive_count

FORMAT, VERSION = "scenelang-viewer", 1
MAGIC = b"SCNV"
LIMIT = 2_000_000
_ALIGNMENT = 8
_TYPES = {"float32": "f4", "int32": "i4", "uint32": "u4", "uint8": "u1"}


@dataclass(slots=True)
class _Columns:
    """Arrays on their way into a packet; ``directory`` says where each is."""

    chunks: list[bytes] = field(default_factory=list)
    directory: dict[str, list[Any]] = field(default_factory=dict)
    size: int = 0

    def add(self, name: str, array: npt.NDArray[Any]) -> None:
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
) -> bytes:
    """The packet of ``scene``; ``definitions`` says where words are bound, ``splats`` gives the Gaussians that are seen
    in place of the solids.

    A scene without geometry, or with more than ``limit`` primitives in all frames, gives a packet with the tree alone;
    its header's ``notice`` says why in one line. Raises SceneError("attribute") for a look that makes no sense.
    """
    columns = _Columns()
    total = sum(primitive_count(root) for root in scene.frames)
    scene, notice = _drawable(scene, total, limit)
    header = _facts(scene) | {"notice": notice, "primitives": total}
    graph = graph_of(scene, definitions or {})
    header |= graph.tables
    for name, array in graph.columns.items():
        columns.add(name, array)
    if notice is None:
        try:
            _add_instances(columns, header, _instances(scene, header, graph.number))
            if splats is not None:
                _add_splats(columns, scene, splats)
        except SceneError as error:
            if error.name not in ("empty-scene", "unsupported", "pose"):
                raise
            header["notice"] = _line(error)
    header["columns"] = columns.directory
    text = json.dumps(header, separators=(",", ":"), ensure_ascii=True).encode()
    text += b" " * (-(len(MAGIC) + 4 + len(text)) % _ALIGNMENT)
    return b"".join([MAGIC, struct.pack("<I", len(text)), text, *columns.chunks])


def _drawable(scene: Scene, total: int, limit: int) -> tuple[Scene, str | None]:
    """The scene with its blocks as cubes; or as it is and, in a line, why it cannot be drawn."""
    if total > limit:
        return scene, (
            f"The scene expands to {total:,} primitives, more than the {limit:,} that this page draws; "
            "its tree is complete."
        )
    try:
        return as_cubes(scene, limit), None
    except LimitError as error:
        return scene, _line(error)


def _line(error: SceneError) -> str:
    return error.message[:1].upper() + error.message[1:] + "."


def _facts(scene: Scene) -> dict[str, Any]:
    return {
        "format": FORMAT,
        "version": VERSION,
        "word": scene.word,
        "animated": scene.animated,
        "frames": len(scene.frames),
        "notice": None,
        "box": None,
        "geometries": [],
        "paths": [],
        "studio": studio_facts(),
    }


def studio_facts() -> dict[str, Any]:
    """The constants of ``studio``, which is their one home; angles in radians."""
    light = ENVIRONMENTS["studio"]
    return {
        "backdrop": list(light.backdrop),
        "ambient": list(light.ambient),
        "key": list(light.key),
        "keyRadius": math.radians(light.radius),
        "keyTurn": math.radians(light.turn),
        "keyHeight": math.radians(light.height),
        "brightest": BRIGHTEST,
        "shoulder": SHOULDER,
    }


def _instances(scene: Scene, header: dict[str, Any], node_of: dict[int, int]) -> Instances:
    (low, high), (center, scale) = box_of(scene), unit_size(scene)
    header["box"] = {"low": low.tolist(), "high": high.tolist(), "center": center.tolist(), "scale": scale}
    return instances_of(scene, center, scale, node_of)


def _add_splats(columns: _Columns, scene: Scene, splats: SplatsOf) -> None:
    found = splat_columns(splats(scene), len(scene.frames), *unit_size(scene))
    if "splatPlace" in found:
        for name, array in found.items():
            columns.add(name, array)


def _add_instances(columns: _Columns, header: dict[str, Any], instances: Instances) -> None:
    words = {word: i for i, word in enumerate(header["words"])}
    header["paths"] = [[words[word] for word in path] for path in instances.paths]
    for number, geometry in enumerate(instances.geometries):
        facts = {"colors": geometry.colors is not None, "closed": geometry.is_closed, "coarse": geometry.coarse}
        header["geometries"].append(facts)
        columns.add(f"geometry{number}Positions", geometry.positions)
        columns.add(f"geometry{number}Normals", geometry.normals)
        columns.add(f"geometry{number}Indices", geometry.indices)
        if geometry.colors is not None:
            columns.add(f"geometry{number}Colors", geometry.colors)
    for name, array in instances.columns.items():
        columns.add(name, array)
