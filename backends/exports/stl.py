"""Exports as binary STL: the triangles in the world with their normals; the format knows no colour and no name."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import numpy.typing as npt

from scenelang.backends.exports.export import Job, mesh_backend, placed
from scenelang.backends.exports.surfaces import ExportSurface
from scenelang.interpreter.scene.primitives.mesh import triangle_normals

_TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def write(job: Job, path: Path) -> None:
    """Write the first frame of the plan at ``path``. Raises SceneError and LimitError."""
    pieces = [_triangles(one.surface) for one in placed(job.plan, job.limit, ".stl")]
    with path.open("wb") as file:
        file.write(b"scenelang: y up".ljust(80, b" "))
        file.write(struct.pack("<I", sum(map(len, pieces))))
        file.writelines(rows.tobytes() for rows in pieces)


def _triangles(surface: ExportSurface) -> npt.NDArray[np.void]:
    rows = np.zeros(len(surface.faces), _TRIANGLE)
    corners = surface.vertices[surface.faces]
    rows["corners"], rows["normal"] = corners, triangle_normals(corners)
    return rows


STL = mesh_backend("stl", "STL: one mesh without colours, for 3D printing", (".stl",), write, attributes=())
