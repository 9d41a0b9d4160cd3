"""Export to 3MF, the format of printers and slicers: named parts with colors, in real units.

Each part of the root is an object of its word, whose components are the meshes below it; equal meshes are stored once.
Textures are images of the package with coordinates for each triangle (Materials and Properties Extension 1.2); the
mean color, which readers without this extension show, is that of the mesh. 3MF is z up and has no mirrored transforms,
so mirrored meshes are stored themselves (3MF Core Specification 1.3).
"""

from __future__ import annotations

import html
import re
import zipfile
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt

from scenelang.backends.base import Option
from scenelang.backends.exports.export import (
    SIDES,
    TOLERANCE,
    UNITS,
    Job,
    Surfaces,
    WorldLeaf,
    mesh_backend,
)
from scenelang.backends.exports.plan import ExportSurface, points_of
from scenelang.backends.surfaces.appearance import Look
from scenelang.backends.surfaces.image_files import to_srgb
from scenelang.backends.surfaces.tiles import pictured, tile_of
from scenelang.interpreter.scene.primitives.textures import Texture

FloatArray = npt.NDArray[np.float64]

_TYPES = """<?xml version="1.0" encoding="UTF-8"?>
<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types">
<Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/>
<Default Extension="png" ContentType="image/png"/>
<Default Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/>
</Types>
"""
_RELATIONS = """<?xml version="1.0" encoding="UTF-8"?>
<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">
<Relationship Target="/3D/3dmodel.model" Id="rel0" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/>
</Relationships>
"""
_TEXTURE_FOLDER = "/3D/Textures"
_TEXTURE_RELATION = "http://schemas.microsoft.com/3dmanufacturing/2013/01/3dtexture"
_MATERIALS = "http://schemas.microsoft.com/3dmanufacturing/material/2015/02"
_NAMESPACE = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
_MATERIALS_ID = 1  # id of the table of colors
_TO_Z_UP = np.array([[1.0, 0, 0], [0, 0, -1.0], [0, 1.0, 0]])  # y up to z up
_MIRROR = np.array([-1.0, 1.0, 1.0])
_NO_CHARACTER = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
_MAX_NINE_DIGIT = 1e4  # larger numbers get more than nine digits, so that distant bodies keep at least four decimals
_TIME = (1980, 1, 1, 0, 0, 0)  # fixed, so that equal scenes give equal bytes


def _write_3mf(job: Job, path: Path) -> None:
    """Write the first frame of the plan to ``path``; raises SceneError and LimitError."""
    model = _Model(job)
    text = "".join(model.lines())
    files: dict[str, str | bytes] = {"[Content_Types].xml": _TYPES, "_rels/.rels": _RELATIONS}
    if model.images:
        files["3D/_rels/3dmodel.model.rels"] = _related(model.images)
    files["3D/3dmodel.model"] = text
    files |= {name.removeprefix("/"): image for name, image in model.images.items()}
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in files.items():
            archive.writestr(zipfile.ZipInfo(name, _TIME), data, zipfile.ZIP_DEFLATED)


def _related(images: Iterable[str]) -> str:
    """Return the relationships of the model to the images at paths of the package."""
    lines = [
        f'<Relationship Target="{name}" Id="image{number}" Type="{_TEXTURE_RELATION}"/>\n'
        for number, name in enumerate(images)
    ]
    head, rest = _RELATIONS.split("<Relationship ", 1)
    return head + "".join(lines) + rest.partition("/>\n")[2]


class _Model:
    """3MF model under construction: colors, textures, meshes, objects and build items.

    ``images`` are PNG files by their path in the package.
    """

    def __init__(self, job: Job) -> None:
        """Flatten the scene of a job."""
        self._job, self._surfaces = job, Surfaces(job, ".3mf", shares=job.solid, textured=not job.solid)
        self._leaves = list(zip(self._surfaces.leaves.each(), self._surfaces.sides().tolist(), strict=True))
        self._colors: dict[str, int] = {}
        self._meshes: dict[tuple[int, bool], int] = {}
        self._objects: list[str] = []
        self.images: dict[str, bytes] = {}
        self._textures: dict[Texture, int] = {}
        self._next = _MATERIALS_ID + 1

    def lines(self) -> Iterator[str]:
        """Yield the lines of the model document."""
        parts = self._parts()
        unit = self._job.unit
        yield f'<?xml version="1.0" encoding="UTF-8"?>\n<model unit="{unit}" xml:lang="en-US" xmlns="{_NAMESPACE}"'
        yield f' xmlns:m="{_MATERIALS}">\n' if self._textures else ">\n"
        yield '<metadata name="Application">scenelang</metadata>\n<resources>\n'
        yield f'<basematerials id="{_MATERIALS_ID}">\n'
        yield from (f'<base name="{color}" displaycolor="{color}"/>\n' for color in self._colors)
        yield "</basematerials>\n"
        yield from self._objects
        yield "</resources>\n<build>\n"
        yield from (f'<item objectid="{number}" transform="{_spelled(np.eye(3, 4))}"/>\n' for number in parts)
        yield "</build>\n</model>\n"

    def _parts(self) -> list[int]:
        """Add the objects, and return the numbers of those to build."""
        groups: dict[int, tuple[str, list[tuple[WorldLeaf, int]]]] = {}
        for leaf, sides in self._leaves:
            word = leaf.path[1] if len(leaf.path) > 1 else leaf.path[0]
            groups.setdefault(leaf.branch, (word, []))[1].append((leaf, sides))
        numbers = []
        for word, members in groups.values():
            components = [line for leaf, sides in members for line in self._components(leaf, sides)]
            if components:
                numbers.append(self._add(f"name={_quoted(word)}", f"<components>\n{''.join(components)}</components>"))
        return numbers

    def _components(self, leaf: WorldLeaf, sides: int) -> Iterator[str]:
        """Yield the components of a leaf, one for each of its meshes; mirrored meshes are stored mirrored."""
        pose = np.array(leaf.pose, np.float64).reshape(3, 4)
        pose = np.concatenate([_TO_Z_UP @ pose[:, :3], (_TO_Z_UP @ pose[:, 3])[:, None]], axis=1)
        mirrored = bool(np.linalg.det(pose[:, :3]) < 0.0)
        if mirrored:
            pose[:, :3] *= _MIRROR
        for patch in self._surfaces.patches(leaf.item, sides):
            key = id(patch), mirrored
            if key not in self._meshes:
                self._meshes[key] = self._mesh(leaf.item.word, patch.look, patch.surface, mirrored=mirrored)
            offset = np.array(patch.pose[3::4]) * (_MIRROR if mirrored else 1.0)
            place = np.column_stack([pose[:, :3], pose[:, 3] + pose[:, :3] @ offset])
            yield f'<component objectid="{self._meshes[key]}" transform="{_spelled(place)}"/>\n'

    def _mesh(self, word: str, look: Look, surface: ExportSurface, *, mirrored: bool) -> int:
        """Add a mesh and return its number; the most frequent color is that of the object."""
        vertices, faces, face_numbers = points_of(surface)
        colors = self._face_colors(look, surface, face_numbers)
        group, places = self._places(look, surface, face_numbers)
        if mirrored:
            vertices, faces, places = vertices * _MIRROR, faces[:, ::-1], places[:, ::-1]
        common = int(np.bincount(colors).argmax()) if len(colors) else 0
        points = ('<vertex x="%.9g" y="%.9g" z="%.9g"/>\n' * len(vertices)) % tuple((vertices + 0.0).ravel().tolist())
        lines = [f"<mesh>\n<vertices>\n{points}</vertices>\n<triangles>\n"]
        for (a, b, c), color, (p, q, r) in zip(faces.tolist(), colors.tolist(), places.tolist(), strict=True):
            color_fields = "" if color == common else f' pid="{_MATERIALS_ID}" p1="{color}"'
            if group:
                color_fields = f' pid="{group}" p1="{p}" p2="{q}" p3="{r}"'
            lines.append(f'<triangle v1="{a}" v2="{b}" v3="{c}"{color_fields}/>\n')
        lines.append("</triangles>\n</mesh>")
        return self._add(f'name={_quoted(word)} pid="{_MATERIALS_ID}" pindex="{common}"', "".join(lines))

    def _places(
        self, look: Look, surface: ExportSurface, face_numbers: npt.NDArray[np.int64]
    ) -> tuple[int, npt.NDArray[np.int64]]:
        """Add the texture coordinates of a surface; return the number of their group, and those of the corners (F, 3).

        The group is 0 for a surface without a texture.
        """
        if surface.uv is None or look.texture is None:
            return 0, np.zeros((len(face_numbers), 3), np.int64)
        image, corners = self._texture(look.texture), surface.uv[surface.faces[face_numbers]].reshape(-1, 2)
        distinct, inverse = np.unique(np.round(corners, 7) + 0.0, axis=0, return_inverse=True)
        lines = ('<m:tex2coord u="%.9g" v="%.9g"/>\n' * len(distinct)) % tuple(distinct.ravel().tolist())
        number, self._next = self._next, self._next + 1
        self._objects.append(f'<m:texture2dgroup id="{number}" texid="{image}">\n{lines}</m:texture2dgroup>\n')
        return number, inverse.reshape(-1, 3)

    def _texture(self, texture: Texture) -> int:
        """Return the number of the image of a texture, added on first use."""
        image = pictured(texture)
        if image not in self._textures:
            number, self._next = self._next, self._next + 1
            name = f"{_TEXTURE_FOLDER}/{number}.png"
            self.images[name], self._textures[image] = tile_of(image).png(), number
            style = "clamp" if texture.side else "wrap"
            self._objects.append(
                f'<m:texture2d id="{number}" path="{name}" contenttype="image/png" tilestyleu="{style}"'
                f' tilestylev="{style}"/>\n'
            )
        return self._textures[image]

    def _face_colors(
        self, look: Look, surface: ExportSurface, face_numbers: npt.NDArray[np.int64]
    ) -> npt.NDArray[np.int64]:
        """Return the number of the color of each face, whose original numbers are ``face_numbers``."""
        colors = surface.face_colors
        if colors is None and surface.colors is not None:
            colors = surface.colors[surface.faces[:, 0]]
        linear = np.array(look.color)[None] if colors is None else colors[face_numbers]
        srgb = np.rint(255.0 * to_srgb(np.clip(linear, 0.0, 1.0))).astype(np.int64)
        opacity = round(255 * look.opacity)
        distinct, inverse = np.unique(srgb, axis=0, return_inverse=True)
        numbers = [self._color((*row, opacity)) for row in distinct.tolist()]
        color_numbers = np.array(numbers, np.int64)[inverse.reshape(-1)]
        return np.broadcast_to(color_numbers, len(face_numbers)) if len(color_numbers) == 1 else color_numbers

    def _color(self, rgba: Sequence[int]) -> int:
        """Return the number of a color in the table, added on first use."""
        return self._colors.setdefault("#" + "".join(f"{value:02X}" for value in rgba), len(self._colors))

    def _add(self, attributes: str, content: str) -> int:
        """Add an object and return its number."""
        number, self._next = self._next, self._next + 1
        self._objects.append(f'<object id="{number}" type="model" {attributes}>\n{content}\n</object>\n')
        return number


def _quoted(word: str) -> str:
    """Return a word as an attribute of XML, without the characters that XML does not have."""
    text = html.escape(_NO_CHARACTER.sub("", word), quote=False).replace(
        '"', "&quot;"
    )  # some readers do not know numeric references
    return f'"{text}"'


def _spelled(pose: FloatArray) -> str:
    """Return a transform as 3MF writes it: twelve numbers of the matrix for row vectors."""
    return " ".join(
        f"{value + 0.0:.9g}" if abs(value) < _MAX_NINE_DIGIT else f"{value:.15g}" for value in pose.T.ravel().tolist()
    )


THREE_MF = mesh_backend(
    "3mf", "3MF for printers and slicers: named parts with colors", (".3mf",), _write_3mf,
    options=(SIDES, TOLERANCE, Option("unit", "what a scene unit is in print", "millimeter", tuple(UNITS))),
    attributes=("color", "opacity", "texture"),
)  # fmt: skip
