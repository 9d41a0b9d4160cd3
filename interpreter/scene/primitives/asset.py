"""The primitive "asset": a mesh file. Finding, checking and reading files is a backend's work, given to it here."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import PurePosixPath
from typing import TYPE_CHECKING, Any

from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.scene.primitives.base import Attribute, Box, Primitive, Support, Symmetry, color_of

if TYPE_CHECKING:
    from scenelang.interpreter.scene.primitives.mesh import Mesh

FILE = Attribute("file", "the mesh file: .glb .gltf .obj .ply .stl .off, inside the project's folder", "a string", accepts=("String",))

# Reads a mesh file: the path and the folder in which all that it refers to lies -> triangles; raises SceneError.
_loaders: list[Callable[[str, str | None], Mesh]] = []


def read_files_by(loader: Callable[[str, str | None], Mesh]) -> None:
    """Let ``loader(path, root)`` read the mesh files of assets."""
    _loaders[:] = [loader]


@dataclass(frozen=True, slots=True)
class Asset:
    """A mesh file: its resolved ``path``, the folder ``root`` in which all that it refers to must lie, and the ``box``
    and ``support`` of its vertices."""

    path: str
    root: str
    box: Box
    support: Support


@dataclass(frozen=True, slots=True)
class MeshFile(Primitive):
    """The mesh in ``file``, in its own colours where the program gives it none. ``asset`` is what is known of it."""

    word = "asset"
    doc = "a mesh file inside the project's folder"
    attributes = (FILE,)
    is_solid = False
    is_file = True
    meaning = "object"
    turn = Symmetry(whole=True)

    file: str | None = None
    asset: Asset | None = None

    @classmethod
    def made(cls, word: str, given: Mapping[str, Any], asset: Any = None) -> Primitive:
        color = given.get("color")
        if color is None:
            return cls(file=given.get("file"), asset=asset)
        return cls(file=given.get("file"), asset=asset, color=color_of(word, color))

    @classmethod
    def compared(cls, given: Mapping[str, Any]) -> tuple[str, tuple[float, float, float] | None]:
        return str(given.get("file")), None

    def defining(self) -> dict[str, Any]:
        return {"color": list(self.color)}

    def name_of(self, word: str) -> str | None:
        return (PurePosixPath(self.file).stem if self.file else None) or self.meaning

    @property
    def root(self) -> str | None:
        """The folder in which what the mesh file refers to lies."""
        return None if self.asset is None else self.asset.root

    @property
    def is_flat(self) -> bool:
        return False

    @property
    def cost(self) -> int:
        return 1 if self.asset is None else 16 + (len(self.asset.support) >> 4)

    def interval(self, a: float, b: float, c: float) -> tuple[float, float]:
        if self.asset is not None:
            return self.asset.support.interval(a, b, c)
        half = 0.5 * (abs(a) + abs(b) + abs(c))  # a file that nobody has measured: the unit box from the origin
        middle = 0.5 * (a + b + c)
        return middle - half, middle + half

    def triangulate(self, tolerance: float) -> Mesh:
        """The triangles of the file, whatever the tolerance; raises SceneError where it cannot be read."""
        from scenelang.interpreter.scene.primitives.mesh import empty

        if self.file is None:
            return empty()
        if not _loaders:
            raise SceneError("file", f"the asset {self.file} cannot be read here")
        return _loaders[0](self.file, self.root)
