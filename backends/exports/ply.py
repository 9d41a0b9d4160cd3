"""Exports as binary PLY: one mesh in the world, with normals and the colour and opacity of every vertex, sRGB."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from scenelang.backends.exports.export import Job, mesh_backend
from scenelang.backends.exports.world import placed

_VERTEX = np.dtype([("position", "<f4", 3), ("normal", "<f4", 3), ("color", "u1", 4)])
_FACE = np.dtype([("count", "u1"), ("corners", "<i4", 3)])
_HEADER = """ply
format binary_little_endian 1.0
comment scenelang: y up, colours are sRGB
element vertex {vertices}
property float x
property float y
property float z
property float nx
property float ny
property float nz
property uchar red
property uchar green
property uchar blue
property uchar alpha
element face {faces}
property list uchar int vertex_indices
end_header
"""


def write(job: Job, path: Path) -> None:
    """Write the first frame of the plan at ``path``. Raises SceneError and LimitError."""
    vertices, faces, start = [], [], 0
    for one in placed(job.plan, job.limit, ".ply"):
        rows = np.empty(len(one.surface.vertices), _VERTEX)
        rows["position"], rows["normal"], rows["color"] = one.surface.vertices, one.surface.normals, one.srgb()
        sides = np.empty(len(one.surface.faces), _FACE)
        sides["count"], sides["corners"] = 3, one.surface.faces + start
        vertices.append(rows)
        faces.append(sides)
        start += len(rows)
    with path.open("wb") as file:
        file.write(_HEADER.format(vertices=start, faces=sum(map(len, faces))).encode("ascii"))
        file.writelines(rows.tobytes() for rows in vertices)
        file.writelines(sides.tobytes() for sides in faces)


PLY = mesh_backend("ply", "PLY: one coloured mesh", (".ply",), write, attributes=("color", "opacity"))
