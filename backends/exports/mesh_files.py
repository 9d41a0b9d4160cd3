"""Export of triangle meshes: Wavefront OBJ with an .mtl file, PLY, and binary STL.

An OBJ file has one object for each leaf, named by the words from the root to it.

By convention colours in .mtl files are sRGB-encoded, so ``Kd`` is. A merged part, whose colours vary, has vertex
colours (``v x y z r g b``), which most programs support.
"""

from __future__ import annotations

import re
import struct
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.exports.export import SIDES, TOLERANCE, Job, PlacedMesh, mesh_backend, placed
from scenelang.backends.exports.plan import ExportSurface
from scenelang.backends.pictures.appearance import Look, to_srgb
from scenelang.interpreter.scene.primitives.mesh import triangle_normals

_MAX_SHININESS = 1000.0  # maximum of Ns, which is 0 for a rough surface


def _write_obj(job: Job, path: Path) -> None:
    """Write the first frame of the plan to ``path``, with a material file; raises SceneError and LimitError."""
    materials: dict[Look, str] = {}
    library = path.with_suffix(".mtl")
    with path.open("w", encoding="utf-8", newline="\n") as file:
        file.write(f"# scenelang: y up, colours are sRGB\nmtllib {library.name}\n")
        start, numbers = 1, dict[tuple[str, ...], int]()
        for one in placed(job, ".obj"):
            name = _object_name(one, numbers)
            material = materials.setdefault(one.look, f"material_{len(materials) + 1}")
            file.write(f"o {name}\ng {' '.join(map(_escaped, one.path))}\nusemtl {material}\n")
            file.writelines(_lines(one, start))
            start += len(one.surface.vertices)
    library.write_text("".join(_material(name, look) for look, name in materials.items()), encoding="ascii")


def _object_name(one: PlacedMesh, numbers: dict[tuple[str, ...], int]) -> str:
    """Return the words from the root to the leaf, with a number if the name is not unique."""
    number = numbers[one.path] = numbers.get(one.path, 0) + 1
    return "/".join(map(_escaped, one.path)) + (f".{number:03d}" if number > 1 else "")


def _escaped(word: str) -> str:
    """Return a word without the characters that are delimiters in the format."""
    return re.sub(r"[\s/#\\]+", "_", word.encode("utf-8", "replace").decode()) or "_"


def _lines(one: PlacedMesh, start: int) -> Iterator[str]:
    """Yield the vertices, normals and faces of one object; its vertices are numbered from ``start``."""
    surface = one.surface
    columns = surface.vertices
    if surface.colors is not None:
        columns = np.hstack([columns, to_srgb(np.clip(surface.colors, 0.0, 1.0))])
    form = "v" + " %.9g" * columns.shape[1] + "\n"
    yield (form * len(columns)) % tuple(columns.ravel().tolist())
    yield ("vn %.6g %.6g %.6g\n" * len(surface.normals)) % tuple((surface.normals + 0.0).ravel().tolist())
    corners = np.repeat(surface.faces.reshape(-1) + start, 2)
    yield ("f %d//%d %d//%d %d//%d\n" * len(surface.faces)) % tuple(corners.tolist())


def _material(name: str, look: Look) -> str:
    def spelled(linear: tuple[float, ...]) -> str:
        return " ".join(f"{x:.6f}" for x in to_srgb(np.clip(np.array(linear), 0.0, 1.0)).tolist())

    lines = [f"newmtl {name}", f"Kd {spelled(look.color)}", f"d {look.opacity:g}"]
    if not look.is_matte:
        lines += [f"Ns {_MAX_SHININESS * (1.0 - look.gloss) ** 2:g}", f"Pr {look.gloss:g}"]
    if look.metallic:
        lines.append(f"Pm {look.metallic:g}")
    if any(look.emission):
        lines.append(f"Ke {' '.join(f'{x:g}' for x in look.emission)}")
    if look.ior is not None:
        lines.append(f"Ni {look.ior:g}")
    return "\n".join(lines) + "\n\n"


OBJ = mesh_backend(
    "obj",
    "Wavefront OBJ with materials, one object for each primitive or part",
    (".obj",),
    _write_obj,
    options=(SIDES, TOLERANCE),
)


# Binary PLY: one mesh in world coordinates, with normals and the sRGB colour and opacity of every vertex.


_VERTEX = np.dtype([("position", "<f4", 3), ("normal", "<f4", 3), ("color", "u1", 4)])
_PROPERTIES = (
    *(("float", name) for name in ("x", "y", "z", "nx", "ny", "nz")),
    *(("uchar", name) for name in ("red", "green", "blue", "alpha")),
)
_FACE = np.dtype([("count", "u1"), ("corners", "<i4", 3)])


def _write_ply(job: Job, path: Path) -> None:
    """Write the first frame of the plan to ``path``; raises SceneError and LimitError."""
    vertices, faces, start = [], [], 0
    for one in placed(job, ".ply"):
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
    """Write a binary PLY file.

    Parameters
    ----------
    properties : sequence of (str, str)
        Types and names of the vertex properties.
    vertices : sequence of structured arrays
        Rows that are concatenated.
    faces : sequence of (F, 3) arrays, optional
        Indices into all vertices; None for a point cloud.
    """
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


PLY = mesh_backend(
    "ply", "PLY: one coloured mesh", (".ply",), _write_ply, options=(SIDES, TOLERANCE), attributes=("color", "opacity")
)


# Binary STL: the triangles in world coordinates with their normals; the format has no colours or names.


_TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def _write_stl(job: Job, path: Path) -> None:
    """Write the first frame of the plan to ``path``; raises SceneError and LimitError."""
    pieces = [_triangles(one.surface) for one in placed(job, ".stl")]
    with path.open("wb") as file:
        file.write(b"scenelang: y up".ljust(80, b" "))
        file.write(struct.pack("<I", sum(map(len, pieces))))
        file.writelines(rows.tobytes() for rows in pieces)


def _triangles(surface: ExportSurface) -> npt.NDArray[np.void]:
    rows = np.zeros(len(surface.faces), _TRIANGLE)
    corners = surface.vertices[surface.faces]
    rows["corners"], rows["normal"] = corners, triangle_normals(corners)
    return rows


STL = mesh_backend(
    "stl",
    "STL: one mesh without colours, for 3D printing",
    (".stl",),
    _write_stl,
    options=(SIDES, TOLERANCE),
    attributes=(),
)
