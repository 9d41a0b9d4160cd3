"""The primitive "mesh": a mesh file. A backend locates, checks and reads the files."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from scenelang.grammar.datum import dataclass
from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.scene.primitives.base import (
    Attribute,
    Box,
    Primitive,
    Support,
    Symmetry,
    color_of,
    texture_of,
)

if TYPE_CHECKING:
    from pathlib import Path

    from scenelang.interpreter.scene.primitives.mesh import Mesh

FILE = Attribute(
    "file",
    "path of the mesh file (.glb .gltf .obj .ply .stl .off) inside the project folder",
    "a string",
    accepts=("String",),
    needed='"chair.glb"',
)


def is_hidden(target: Path, project: Path) -> bool:
    """Return whether a file in a project is hidden, or in a hidden folder, which may hold settings and keys."""
    return any(part.startswith(".") for part in target.relative_to(project).parts)


def located(file: str, noun: str, folder: Path, project: Path, allow_outside: bool) -> Path:
    """Return the path of a file that a scene names.

    Parameters
    ----------
    file
        Path as the program gives it, relative to ``folder``.
    noun
        Kind of file, for error messages: "mesh file", "font".
    folder
        Folder of the scene's file.
    project
        Folder that must contain the file, unless ``allow_outside``; the file must not be hidden in it.
    allow_outside
        Whether any file may be read.

    Raises
    ------
    SceneError
        "file" if it does not exist, "import-outside" if it may not be read.
    """
    try:
        target = (folder / file).resolve()
    except (OSError, ValueError, RuntimeError):
        raise SceneError("file", f"`{file[:80]}` is not a valid path") from None
    if not allow_outside and not target.is_relative_to(project):
        hint = f"move the {noun} into the project folder, or allow this with --allow-outside"
        raise SceneError("import-outside", f"`{file[:80]}` is outside {project}", hint)
    if not allow_outside and is_hidden(target, project):
        hint = f"give the {noun} another name, or allow this with --allow-outside"
        raise SceneError("import-outside", f"`{file[:80]}` is hidden", hint)
    if not target.is_file():
        raise SceneError("file", f"the {noun} {file[:200]} does not exist")
    return target


# Loader of mesh files, called with the path and the folder that must contain all referenced files; raises SceneError.
_loaders: list[Callable[[str, str | None], Mesh]] = []


def set_mesh_loader(loader: Callable[[str, str | None], Mesh]) -> None:
    """Register ``loader(path, root)``, which reads the mesh files of assets."""
    _loaders[:] = [loader]


@dataclass(frozen=True, slots=True)
class Asset:
    """Metadata of a mesh file.

    Attributes
    ----------
    path
        Resolved path.
    root
        Folder that must contain all referenced files.
    box, support
        Bounding box and support function of the vertices.
    """

    path: str
    root: str
    box: Box
    support: Support


@dataclass(frozen=True, slots=True)
class MeshFile(Primitive):
    """Mesh in ``file``, with its own colors if the program sets none. ``asset`` is the metadata of the file.

    A color of the program replaces those of the file, where each triangle has the color of its texture at its center.
    """

    word = "mesh"
    doc = "a mesh file inside the project folder"
    attributes = (FILE,)
    is_solid = False
    is_file = True
    common_name = "object"
    symmetry = Symmetry(unknown=True)

    file: str | None = None
    asset: Asset | None = None

    @classmethod
    def from_attributes(cls, word: str, attributes: Mapping[str, Any], asset: Any = None) -> Primitive:
        """Create the primitive; ``load_asset`` of the runtime has checked and resolved the file."""
        values = {"color": color_of(word, color)} if (color := attributes.get("color")) is not None else {}
        chosen = None if attributes.get("texture") is None else texture_of(word, "texture", attributes["texture"])
        image = chosen.name if chosen is not None and chosen.is_image else None
        return cls(file=attributes.get("file"), asset=asset, image=image, **values)

    @classmethod
    def comparison_key(cls, given: Mapping[str, Any]) -> tuple[str, tuple[float, float, float] | None]:
        return str(given.get("file")), None

    def defining_attributes(self) -> dict[str, Any]:
        return {"color": list(self.color)}

    def display_name(self, word: str) -> str | None:
        from pathlib import PurePosixPath

        return (PurePosixPath(self.file).stem if self.file else None) or self.common_name

    @property
    def root(self) -> str | None:
        """Folder that must contain the files that the mesh file refers to, such as textures.

        None for a mesh file without metadata (``asset``).
        """
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
        half = 0.5 * (abs(a) + abs(b) + abs(c))  # the unit box for a file that has not been measured
        middle = 0.5 * (a + b + c)
        return middle - half, middle + half

    def triangulate(self, tolerance: float) -> Mesh:
        """Return the triangles of the file, whatever the tolerance; raise SceneError if it cannot be read."""
        from scenelang.interpreter.scene.primitives.mesh import empty

        if self.file is None:
            return empty()
        if not _loaders:
            raise SceneError("file", f"cannot read the mesh file {self.file}: no mesh loader is registered")
        return _loaders[0](self.file, self.root)
