"""Mesh files as triangles with colours, for the primitive "asset"."""

from __future__ import annotations

import io
import logging
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.asset_gltf import MOST_TRIANGLES, checked_gltf
from scenelang.backends.asset_references import LARGEST_FILE, References
from scenelang.backends.base import need
from scenelang.backends.studio import from_srgb
from scenelang.grammar.diagnostics import SceneError

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]

ENDINGS = (".glb", ".gltf", ".obj", ".ply", ".stl", ".off")
_GLTF = (".glb", ".gltf")


@dataclass(frozen=True, slots=True, eq=False)
class AssetMesh:
    """``vertices`` (V, 3) in the asset's frame, +y up; ``faces`` (F, 3); ``face_colors`` (F, 3), linear sRGB, None
    where the file says nothing of colours."""

    vertices: FloatArray
    faces: IntArray
    face_colors: FloatArray | None

    @property
    def corners(self) -> FloatArray:
        """The triangles (F, 3, 3)."""
        return np.asarray(self.vertices[self.faces], np.float64)


def load_asset(file: str | Path, root: str | Path | None = None) -> AssetMesh:
    """The mesh of a file (glTF, OBJ, PLY, STL, OFF), of all its parts together.

    The other files that it refers to lie in the folder ``root``, by default its own. Raises SceneError: "file" where it
    cannot be read, holds no mesh, or is too large, "import-outside" where it refers to what lies elsewhere.
    """
    path = Path(file)
    if path.suffix.lower() not in ENDINGS:
        raise SceneError("file", f"the asset {path.name} is no mesh file", hint=f"it can be one of {' '.join(ENDINGS)}")
    try:
        state = path.stat()
    except OSError as error:
        raise SceneError("file", f"the asset {path.name} cannot be read: {error.strerror or error}") from None
    if state.st_size > LARGEST_FILE:
        raise SceneError(
            "file", f"the asset {path.name} has {state.st_size:,} bytes, more than the {LARGEST_FILE:,} that it may"
        )
    return _loaded(str(path), str(root or path.resolve().parent), state.st_mtime_ns, state.st_size)


_QUIET = logging.NullHandler()


@lru_cache(maxsize=32)
def _loaded(path: str, root: str, changed: int, size: int) -> AssetMesh:
    """The mesh of a file in the state that ``changed`` and ``size`` tell apart from others."""
    ending, name = Path(path).suffix.lower(), Path(path).name
    references = References(Path(path), Path(root), decoded=ending in _GLTF)
    try:
        mesh = _mesh(Path(path), references)
    except SceneError:
        raise
    except Exception as error:  # a reader of foreign files may raise anything
        said = str(error).splitlines()[0][:120] if str(error) else type(error).__name__
        if isinstance(error, IndexError):
            said = f"it refers to something that is not there ({said})"
        problem = SceneError("file", f"the asset {name} cannot be read as a {ending} file: {said}")
        raise references.problem or problem from None
    if references.problem is not None:  # which the reader of meshes may have passed over
        raise references.problem
    return mesh


def _mesh(path: Path, references: References) -> AssetMesh:
    """The mesh of a file; raises SceneError, or anything else for files that cannot be read."""
    trimesh = need("trimesh", "trimesh")
    ending, name = path.suffix.lower(), path.name
    with path.open("rb") as file:
        data = file.read(LARGEST_FILE + 1)
    document = checked_gltf(data, ending == ".glb", references) if ending in _GLTF else None
    # It logs tracebacks of files that it reads in another way then, which Python prints where nobody takes them.
    logging.getLogger("trimesh").addHandler(_QUIET)
    with np.errstate(all="ignore"):
        scene = trimesh.load_scene(io.BytesIO(data), file_type=ending[1:], resolver=references, process=False)
    parts = [part for part in _parts(scene) if isinstance(part[0], trimesh.Trimesh) and len(part[0].faces)]
    if not parts:
        raise SceneError("file", f"the asset {name} holds no mesh")
    meshes = [mesh for mesh, _ in parts]
    count = sum(len(mesh.faces) for mesh in meshes)
    if count > MOST_TRIANGLES:
        raise SceneError("file", f"the asset {name} has {count:,} triangles, more than the {MOST_TRIANGLES:,} it may")
    for mesh in meshes:
        _check_faces(mesh, name)
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes[:-1])])
    vertices = np.concatenate([mesh.vertices @ pose[:3, :3].T + pose[:3, 3] for mesh, pose in parts])
    if not np.isfinite(vertices).all():
        raise SceneError("file", f"the asset {name} has vertices that are no numbers")
    faces = np.concatenate([np.asarray(m.faces, np.int64) + start for m, start in zip(meshes, starts, strict=True)])
    factors = None if document is None else _gltf_factors(document)
    pictures: dict[int, npt.NDArray[np.uint8]] = {}
    colors = [_colors(mesh, factors, pictures) for mesh in meshes]
    if all(color is None for color in colors):
        return AssetMesh(vertices, faces, None)
    filled = [np.ones((len(m.faces), 3)) if c is None else c for m, c in zip(meshes, colors, strict=True)]
    return AssetMesh(vertices, faces, np.concatenate(filled))


def _check_faces(mesh: Any, name: str) -> None:
    low, high, count = int(mesh.faces.min()), int(mesh.faces.max()), len(mesh.vertices)
    if low < 0 or high >= count:
        wrong = low if low < 0 else high
        raise SceneError("file", f"the asset {name} is broken: a face has vertex {wrong:,}, and there are {count:,}")


def _parts(scene: Any) -> Iterator[tuple[Any, FloatArray]]:
    """The geometries of a file where they stand: each with its pose (4, 4)."""
    for node in scene.graph.nodes_geometry:
        pose, name = scene.graph[node]
        yield scene.geometry[name], np.asarray(pose, np.float64)


def _gltf_factors(document: dict[str, Any]) -> dict[str, FloatArray]:
    """The base colours (3,), linear, of a glTF file's materials by name: trimesh rounds them to bytes, which shows in
    dark colours."""
    materials = document.get("materials") or ()
    given = [
        (m.get("name"), (m.get("pbrMetallicRoughness") or {}).get("baseColorFactor", [1.0] * 4)) for m in materials
    ]
    named = Counter(name for name, _ in given)
    return {name: np.array(factor[:3], np.float64) for name, factor in given if name and named[name] == 1}


def _colors(
    mesh: Any, factors: dict[str, FloatArray] | None, pictures: dict[int, npt.NDArray[np.uint8]]
) -> FloatArray | None:
    """The linear colours (F, 3) of a mesh's faces: of its vertices or faces, or of its material and texture.

    ``factors`` are the materials' colours of a glTF file, whose vertex colours are linear too; None for other files.
    ``pictures`` keeps the pixels of textures, by ``id``: many parts may share one.
    """
    visual = mesh.visual
    if visual.kind in ("vertex", "face"):
        if visual.kind == "vertex":
            encoded = np.asarray(visual.vertex_colors, np.float64)[:, :3][mesh.faces].mean(axis=1)
        else:
            encoded = np.asarray(visual.face_colors, np.float64)[:, :3]
        share = encoded / 255.0
        return np.asarray(share if factors is not None else from_srgb(share), np.float64)
    material = getattr(visual, "material", None)
    if material is None:
        return None
    factor, texture = _factor_and_texture(material)
    factor = (factors or {}).get(getattr(material, "name", None) or "", factor)
    uv = getattr(visual, "uv", None)
    if factor is None and texture is None:
        return None
    colors = np.tile(np.ones(3) if factor is None else factor, (len(mesh.faces), 1))
    if texture is not None and uv is not None and len(uv) == len(mesh.vertices):
        if id(texture) not in pictures:
            pictures[id(texture)] = np.asarray(texture.convert("RGB"))
        colors *= _sampled(pictures[id(texture)], np.asarray(uv, np.float64)[mesh.faces].mean(axis=1))
    return colors


def _factor_and_texture(material: Any) -> tuple[FloatArray | None, Any]:
    """The linear factor (3,) and the texture of a material of glTF's kind or of OBJ's."""
    if hasattr(material, "baseColorFactor"):
        factor = material.baseColorFactor
        share = None if factor is None else _unit(np.asarray(factor)[:3])
        return share, material.baseColorTexture
    diffuse, texture = getattr(material, "diffuse", None), getattr(material, "image", None)
    if diffuse is None or texture is not None:  # what comes with a texture is the reader's own default
        return None, texture
    return np.asarray(from_srgb(_unit(np.asarray(diffuse)[:3])), np.float64), None


def _unit(values: npt.NDArray[Any]) -> FloatArray:
    """Colours as shares: trimesh keeps some of them as bytes."""
    return values.astype(np.float64) / 255.0 if values.dtype.kind in "ui" else np.clip(values.astype(np.float64), 0, 1)


def _sampled(pixels: npt.NDArray[np.uint8], uv: FloatArray) -> FloatArray:
    """The linear colours (F, 3) of ``pixels`` (H, W, 3) at ``uv`` (F, 2), repeated beyond [0, 1]."""
    height, width = pixels.shape[:2]
    column = np.floor(np.mod(uv[:, 0], 1.0) * width).astype(np.int64) % width
    row = np.floor(np.mod(1.0 - uv[:, 1], 1.0) * height).astype(np.int64) % height
    return np.asarray(from_srgb(pixels[row, column].astype(np.float64) / 255.0), np.float64)
