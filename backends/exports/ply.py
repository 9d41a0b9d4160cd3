"""Exports as binary PLY: one mesh in the world, with normals and the colour and opacity of every vertex, sRGB."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.exports.export import Job, mesh_backend, placed

_VERTEX = np.dtype([("position", "<f4", 3), ("normal", "<f4", 3), ("color", "u1", 4)])
_PROPERTIES = (
    *(("float", name) for name in ("x", "y", "z", "nx", "ny", "nz")),
    *(("uchar", name) for name in ("red", "green", "blue", "alpha")),
)
_FACE = np.dtype([("count", "u1"), ("corners", "<i4", 3)])


def write(job: Job, path: Path) -> None:
    """Write the first frame of the plan at ``path``. Raises SceneError and LimitError."""
    vertices, faces, start = [], [], 0
    for one in placed(job.plan, job.limit, ".ply"):
        rows = np.empty(len(one.surface.vertices), _VERTEX)
        rows["position"], rows["normal"], rows["color"] = one.surface.vertices, one.surface.normals, one.srgb()
        vertices.append(rows)
        faces.append(one.surface.faces + start)
        start += len(rows)
    write_ply(path, _PROPERTIES, vertices, faces, "scenelang: y up, colours are sRGB")


def write_ply(
    path: Path,
    properties: Sequence[tuple[str, str]],
    vertices: Sequence[npt.NDArray[Any]],
    faces: Sequence[npt.NDArray[np.int64]] | None,
    comment: str | None = None,
) -> None:
    """Write a binary file: ``vertices`` are rows of structured arrays, whose numbers have the types and names of
    ``properties``; ``faces`` (F, 3) count them all. With None it holds points."""
    lines = ["ply", "format binary_little_endian 1.0", *([f"comment {comment}"] if comment else ())]
    lines += [f"element vertex {sum(map(len, vertices))}", *(f"property {kind} {name}" for kind, name in properties)]
    if faces is not None:
        lines += [f"element face {sum(map(len, faces))}", "property list uchar int vertex_indices"]
    lines += ["end_header", ""]
    with path.open("wb") as file:
        file.write("\n".join(lines).encode("ascii"))
        file.writelines(rows.tobytes() for rows in vertices)
        for corners in faces or ():
            sides = np.empty(len(corners), _FACE)
            sides["count"], sides["corners"] = 3, corners
            file.write(sides.tobytes())


PLY = mesh_backend("ply", "PLY: one coloured mesh", (".ply",), write, attributes=("color", "opacity"))
