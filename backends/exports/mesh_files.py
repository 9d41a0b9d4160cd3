"""Export of triangle meshes: Wavefront OBJ with an .mtl file, PLY, and binary STL.

An OBJ file has one object for each leaf, named by the words from the root to it. It numbers positions, normals and
texture coordinates separately, which halves the files of boxes.

By convention colors in .mtl files are sRGB-encoded, so ``Kd`` is. A merged part, whose colors vary, has vertex
colors (``v x y z r g b``), which most programs support. Images of textures are files beside the .mtl file.
"""

from __future__ import annotations

import re
import struct
from collections import Counter
from collections.abc import Hashable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.exports.export import (
    SIDES,
    TOLERANCE,
    Job,
    LeafPiece,
    Surfaces,
    TextureFiles,
    WorldBlock,
    mesh_backend,
)
from scenelang.backends.exports.plan import WHITE, as_material
from scenelang.backends.surfaces.appearance import Look, material_name
from scenelang.backends.surfaces.contraction import contracted
from scenelang.backends.surfaces.image_files import to_srgb
from scenelang.backends.surfaces.precision import NINE_DIGITS, SINGLE, ChangedBody
from scenelang.grammar.diagnostics import Diagnostic
from scenelang.interpreter.scene.primitives.mesh import triangle_normals

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]

_CONTROLS = re.compile(r"[\x00-\x1f\x7f]")
# bytes of the lines of an object, of a point, of a normal and of texture coordinates in an OBJ file
_HEAD, _ROW, _NORMAL_ROW, _COORDINATE_ROW = 60, 34, 24, 20
_UNNAMED = re.compile(r"[^A-Za-z0-9_-]+")  # names in .mtl files end at white space, and # begins a comment
_MAX_SHININESS = 1000.0  # maximum of Ns, whose minimum 0 is a rough surface


def _write_obj(job: Job, path: Path) -> None:
    """Write the first frame of the plan to ``path``, with a material file; raises SceneError and LimitError."""
    surfaces = Surfaces(job, ".obj", shares=job.solid, textured=True)
    text = _ObjText(surfaces)
    surfaces.announce(text.estimated_size(), ".obj")
    # a name is any bytes, and a line of the file
    library = path.with_name(_CONTROLS.sub("_", path.stem) + ".mtl")
    with path.open("w", encoding="utf-8", errors="surrogateescape", newline="\n") as file:
        file.write(f"# scenelang: y up, colors are sRGB\nmtllib {library.name}\n")
        for block in surfaces.blocks():
            file.writelines(text.objects(block))
    images = TextureFiles(path)
    materials = [_material(name, look, images) for look, name in text.materials.items()]
    library.write_text("".join(materials), encoding="utf-8")


@dataclass(frozen=True, slots=True, eq=False)
class _Outline:
    """Surface as an OBJ object, with distinct positions, texture coordinates and normals.

    Attributes
    ----------
    points, normals
        Numbers of the vertices that they are taken from. A body has no normals, for which readers would split its
        points.
    uv : (T, 2), optional
        Coordinates in a texture.
    colors : (P, 3), optional
        Colors of the points.
    faces, mirrored
        Numbers at each corner of those of position, texture coordinates and normal that there are, in this order, from
        0, and those of the mirrored surface.
    form
        Text of the object, with formats for its numbers.
    """

    points: IntArray
    normals: IntArray | None
    uv: FloatArray | None
    colors: FloatArray | None
    faces: IntArray
    mirrored: IntArray
    form: str

    @property
    def kinds(self) -> list[int]:
        """What corners have a number of: 0 for positions, 1 for texture coordinates, 2 for normals."""
        return [0, *([] if self.uv is None else [1]), *([] if self.normals is None else [2])]


def _outline(piece: LeafPiece, number: str, *, is_body: bool) -> _Outline:
    """Return a piece as an object; ``number`` is the format of its positions."""
    surface, colors = piece.surface, piece.colors
    columns = surface.vertices
    if colors is not None:
        colors = to_srgb(np.clip(colors, 0.0, 1.0)).astype(np.float64)
        columns = np.hstack([columns, colors])
    if is_body:
        form = "s off\n" + _vertex_form(columns, number) * len(columns) + "f %d %d %d\n" * len(surface.faces)
        faces = surface.faces
        mirrored = faces[:, ::-1].reshape(-1)
        return _Outline(np.arange(len(columns)), None, None, colors, faces.reshape(-1), mirrored, form)
    if surface.joints is None or colors is not None:
        points, place = _firsts(columns)
        point = place[surface.faces]
    else:  # points where the solid only touches itself stay separate
        _, first, place = np.unique(surface.joints, return_index=True, return_inverse=True)
        points, point = surface.faces.ravel()[first], place.reshape(surface.faces.shape)
    normals, normal = _firsts(surface.normals)
    form, corner = _vertex_form(columns, number) * len(points), "%d//%d"
    numbers, uv = [point, normal[surface.faces]], None
    if surface.uv is not None:
        first, place = _firsts(surface.uv)
        uv, corner = surface.uv[first], "%d/%d/%d"
        form += "vt %.7g %.7g\n" * len(uv)
        numbers.insert(1, place[surface.faces])
    form += "vn %.6g %.6g %.6g\n" * len(normals) + f"f {corner} {corner} {corner}\n" * len(surface.faces)
    corners = np.stack(numbers, axis=2)
    point_colors = None if colors is None else colors[points]
    return _Outline(points, normals, uv, point_colors, corners.reshape(-1), corners[:, ::-1].reshape(-1), form)


def _vertex_form(columns: FloatArray, number: str) -> str:
    """Return the format of a line of a position, with a color if the columns have one."""
    colors: int = columns.shape[1] - 3
    return f"v {number} {number} {number}" + " %.9g" * colors + "\n"


def _firsts(rows: FloatArray) -> tuple[IntArray, IntArray]:
    """Return the first of each set of equal rows, in order, and for each row the number of its set."""
    _, first, place = np.unique(rows + 0.0, axis=0, return_index=True, return_inverse=True)
    order = np.argsort(first)
    number = np.empty(len(order), np.int64)
    number[order] = np.arange(len(order))
    return first[order], number[place.reshape(-1)]


class _ObjText:
    """Writes the objects of an OBJ file, which number positions, coordinates and normals through the file."""

    def __init__(self, surfaces: Surfaces) -> None:
        """Choose nine digits, or all if rounding to nine would change the volume of a body."""
        self.materials: dict[Look, str] = {}
        self.names: Counter[str] = Counter()
        self._surfaces, self._leaves, self._shares = surfaces, surfaces.leaves, surfaces.shares
        self._number = "%.9g" if surfaces.keeps_shapes(NINE_DIGITS) else "%.17g"
        self._outlines: dict[Hashable, _Outline] = {}
        self._names: dict[tuple[int, str], str] = {}
        self._numbers: dict[str, int] = {}
        self._next = np.array([1, 1, 1])

    def estimated_size(self) -> float:
        """Return the approximate size of the objects in bytes, within a fifth."""
        size = 0.0
        vertices, _ = self._surfaces.size()
        digits = len(str(max(vertices, 1)))
        for pieces, count in self._surfaces.kinds():
            for piece in pieces:
                outline = self._outline(piece)
                normals = 0 if outline.normals is None else len(outline.normals)
                coordinates = 0 if outline.uv is None else len(outline.uv)
                rows = _ROW * len(outline.points) + _NORMAL_ROW * normals + _COORDINATE_ROW * coordinates
                size += count * (_HEAD + rows + len(outline.faces) * (digits + 1))
        return size

    def objects(self, block: WorldBlock) -> Iterator[str]:
        """Yield the text of each object of a block."""
        starts, leaf, mirrored = block.first.tolist(), block.leaf.tolist(), block.mirrored.tolist()
        for number, piece in enumerate(block.pieces):
            outline = self._outline(piece)
            points = block.vertices[starts[number] + outline.points]
            if outline.colors is not None:
                points = np.hstack([points, outline.colors])
            normals = np.zeros((0, 3))
            if outline.normals is not None:
                normals = block.normals[starts[number] + outline.normals] + 0.0
            faces = outline.mirrored if mirrored[number] else outline.faces
            uv = np.zeros((0, 2)) if outline.uv is None else outline.uv
            corners = (faces.reshape(-1, len(outline.kinds)) + self._next[outline.kinds]).ravel()
            self._next = self._next + np.array([len(points), len(uv), len(normals)])
            numbers = tuple(number for rows in (points, uv, normals, corners) for number in rows.ravel().tolist())
            yield self._head(leaf[number], piece.look)
            yield outline.form % numbers

    def _outline(self, piece: LeafPiece) -> _Outline:
        """Return the outline of a piece, computed once for equal surfaces and colors."""
        key = id(piece.surface), None if piece.surface.colors is None else piece.look.color
        if key not in self._outlines:
            self._outlines[key] = _outline(piece, self._number, is_body=self._shares)
        return self._outlines[key]

    def _head(self, leaf: int, look: Look) -> str:
        """Return the lines that begin an object; its name has a number if it is not unique."""
        path = self._leaves.path(leaf)
        key = int(self._leaves.path_index[leaf]), path[-1]
        if key not in self._names:
            words = [_escaped(word) for word in path]
            self._names[key] = "/".join(words)
        name = self._names[key]
        number = self._numbers[name] = self._numbers.get(name, 0) + 1
        look = as_material(look)
        material = self.materials.get(look)
        if material is None:
            base = _UNNAMED.sub("_", material_name(look).replace("#", "color_"))
            same = self.names[base]
            self.names[base] += 1
            material = self.materials[look] = f"{base}.{same:03d}" if same else base
        counted = f".{number:03d}" if number > 1 else ""
        return f"o {name}{counted}\ng {name.replace('/', ' ')}\nusemtl {material}\n"


def _escaped(word: str) -> str:
    """Return a word without the characters that are delimiters in the format."""
    return re.sub(r"[\s/#\\]+", "_", word.encode("utf-8", "replace").decode()) or "_"


def _material(name: str, look: Look, images: TextureFiles) -> str:
    """Return the lines of a material; Pr, Pm, Ke and norm are MTL's PBR extension, in which ``map_Kd`` is times Kd."""

    def spelled(linear: tuple[float, ...]) -> str:
        """Return a linear color as three sRGB numbers."""
        return " ".join(f"{x:.6f}" for x in to_srgb(np.clip(np.array(linear), 0.0, 1.0)).tolist())

    color = look.color if look.texture is None else WHITE
    lines = [f"newmtl {name}", f"Kd {spelled(color)}", f"d {look.opacity:g}"]
    if look.texture is not None:
        clamp = "-clamp on " if look.texture.side else ""
        lines.append(f"map_Kd {clamp}{images.name_of(look.texture)}")
        if look.texture.bump:
            lines.append(f"norm {clamp}{images.name_of(look.texture, is_relief=True)}")
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


# Binary PLY: one mesh in world coordinates, with normals and the sRGB color and opacity of every vertex; a body has
# points without normals, and the colors of its faces.


_COMMENT = "scenelang: y up, colors are sRGB"
_NORMALS = tuple(("float", name) for name in ("nx", "ny", "nz"))
_COLORS = tuple(("uchar", name) for name in ("red", "green", "blue", "alpha"))
_FACE = np.dtype([("count", "u1"), ("corners", "<i4", 3)])
_PAINTED = np.dtype([*_FACE.descr, ("color", "u1", 4)])


def _write_ply(job: Job, path: Path) -> None:
    """Write the first frame of the plan to ``path``; raises SceneError and LimitError.

    Positions are doubles if float32 would change the volume of a body.
    """
    surfaces = Surfaces(job, ".ply", shares=job.solid)
    vertices_and_faces = surfaces.size()
    surfaces.announce(28.0 * vertices_and_faces[0] + 13.0 * vertices_and_faces[1], ".ply")
    kind, code = ("float", "<f4") if surfaces.keeps_shapes(SINGLE) else ("double", "<f8")
    positions = tuple((kind, name) for name in ("x", "y", "z"))
    if job.solid:
        blocks = list(surfaces.blocks())
        points = [block.vertices.astype(code).view([("position", code, 3)]) for block in blocks]
        face_rows, start = [], 0
        for block in blocks:
            face_rows.append(_painted_faces(block, start))
            start += len(block.vertices)
        write_ply(path, positions, points, face_rows, _COMMENT, face_properties=_COLORS)
        return
    row = np.dtype([("position", code, 3), ("normal", "<f4", 3), ("color", "u1", 4)])
    faces: list[npt.NDArray[Any]] = []

    def vertices() -> Iterator[npt.NDArray[Any]]:
        """Yield the vertices block by block, and collect the faces, which are only written after all vertices."""
        start = 0
        for block in surfaces.blocks():
            rows = np.empty(len(block.vertices), row)
            rows["position"], rows["normal"], rows["color"] = block.vertices, block.normals, block.srgb()
            faces.append(_ply_faces(block.faces() + start))
            start += len(rows)
            yield rows

    write_ply(path, (*positions, *_NORMALS, *_COLORS), vertices(), faces, _COMMENT, vertices_and_faces)


def write_ply(
    path: Path,
    properties: Sequence[tuple[str, str]],
    vertices: Iterable[npt.NDArray[Any]],
    faces: Iterable[npt.NDArray[Any]] | None,
    comment: str | None = None,
    size: tuple[int, int] | None = None,
    face_properties: Sequence[tuple[str, str]] = (),
) -> None:
    """Write a binary PLY file.

    Parameters
    ----------
    properties : sequence of (str, str)
        Types and names of the vertex properties.
    vertices : iterable of structured arrays
        Rows that are concatenated.
    faces : iterable of (F, 3) arrays, or of arrays of PLY's own rows, optional
        Indices into all vertices; None for a point cloud. They are read after all vertices.
    size : (int, int), optional
        The numbers of vertices and faces, needed unless both are sequences.
    face_properties : sequence of (str, str)
        Types and names of what faces have after their corners, in PLY's own rows.
    """
    if size is None:
        vertices, faces = list(vertices), None if faces is None else list(faces)
        size = sum(map(len, vertices)), sum(map(len, faces or ()))
    lines = ["ply", "format binary_little_endian 1.0", *([f"comment {comment}"] if comment else ())]
    lines += [f"element vertex {size[0]}", *(f"property {kind} {name}" for kind, name in properties)]
    if faces is not None:
        lines += [f"element face {size[1]}", "property list uchar int vertex_indices"]
        lines += [f"property {kind} {name}" for kind, name in face_properties]
    lines += ["end_header", ""]
    with path.open("wb") as file:
        file.write("\n".join(lines).encode("ascii"))
        file.writelines(rows.tobytes() for rows in vertices)
        file.writelines((f if f.dtype.names else _ply_faces(f)).tobytes() for f in faces or ())


def _ply_faces(corners: IntArray) -> npt.NDArray[Any]:
    """Return triangles as PLY's rows of faces."""
    rows = np.empty(len(corners), _FACE)
    rows["count"], rows["corners"] = 3, corners
    return rows


def _painted_faces(block: WorldBlock, start: int) -> npt.NDArray[Any]:
    """Return the faces of a block with their colors; ``start`` is its first vertex in the file."""
    corners = block.faces() + start
    rows = np.empty(len(corners), _PAINTED)
    rows["count"], rows["corners"], rows["color"] = 3, corners, block.face_srgb()
    return rows


PLY = mesh_backend(
    "ply", "PLY: one colored mesh", (".ply",), _write_ply, options=(SIDES, TOLERANCE), attributes=("color", "opacity")
)


# Binary STL: the triangles in world coordinates with their normals; the format has no colors or names.


_TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def _write_stl(job: Job, path: Path) -> None:
    """Write the first frame of the plan to ``path``; raises SceneError and LimitError."""
    surfaces = Surfaces(job, ".stl", shares=job.solid)
    count = surfaces.size()[1]
    surfaces.announce(50.0 * count, ".stl")
    for warning in _warnings(surfaces):
        job.warn(warning)
    pieces: Iterator[tuple[FloatArray, IntArray]] = ((block.vertices, block.faces()) for block in surfaces.blocks())
    if job.solid:
        welded = [_single(*piece) for piece in pieces]
        count, pieces = sum(len(faces) for _, faces in welded), iter(welded)
    with path.open("wb") as file:
        file.write(b"scenelang: y up".ljust(80, b" "))
        file.write(struct.pack("<I", count))
        file.writelines(_triangles(*piece).tobytes() for piece in pieces)


def _single(vertices: FloatArray, faces: IntArray) -> tuple[FloatArray, IntArray]:
    """Return a closed surface that stays closed after rounding to float32 and joining of equal points."""
    points, corners, _ = contracted(vertices, faces, np.arange(len(faces)), 0.0)
    return (points, corners) if len(corners) else (vertices, faces)


def _warnings(surfaces: Surfaces) -> Iterator[Diagnostic]:
    """Yield a warning for each word with bodies whose volumes change in single precision, about the worst."""
    worst: dict[str, tuple[ChangedBody, int]] = {}
    for word, body in surfaces.changed(SINGLE):
        other, count = worst.get(word, (body, 0))
        worst[word] = body if body.change > other.change else other, count + 1
    for word, (body, count) in worst.items():
        sizes, center = (" ".join(f"{x:.4g}" for x in numbers) for numbers in (body.sizes, body.center))
        more = f" (the worst of {count:,})" if count > 1 else ""
        share = f"{100.0 * body.change:.3g} %"
        message = f'STL changes the volume of "{word}" by {share}: it is [{sizes}] large at [{center}]'
        hint = "move the scene to the origin, or write .ply, .3mf or .glb, which keep it"
        yield Diagnostic("single-precision", message + more, None, hint)


def _triangles(vertices: FloatArray, faces: IntArray) -> npt.NDArray[np.void]:
    """Return triangles as STL's rows, with their normals."""
    rows = np.zeros(len(faces), _TRIANGLE)
    corners = vertices[faces]
    rows["corners"], rows["normal"] = corners, triangle_normals(corners)
    return rows


STL = mesh_backend(
    "stl",
    "STL: one mesh without colors, for 3D printing",
    (".stl",),
    _write_stl,
    options=(SIDES, TOLERANCE),
    attributes=(),
)
