"""Surfaces of solids, and their files in the user's cache folder: another run need not compute them again.

A file is named by the digest of its expression; its folder by what else decides the surface: Manifold's version and the
code that computes. Whatever cannot be read is computed. Where the evaluation of a program may not use files, nothing
is read or written.
"""

from __future__ import annotations

import hashlib
import os
import tempfile
import zipfile
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from scenelang.grammar.datum import dataclass
from scenelang.interpreter.loading import np, user_folder
from scenelang.interpreter.scene.primitives.mesh import Mesh

if TYPE_CHECKING:
    import numpy.typing as npt

    FloatArray = npt.NDArray[np.float64]

MAX_STORED_BYTES = 512 << 20  # of all files; those used longest ago are deleted first
_MAX_FILE_BYTES = 256 << 20
_ARRAYS = {"vertices": np.float64, "normals": np.float64, "faces": np.int64, "colors": np.float64, "joints": np.int64}


@dataclass(frozen=True, slots=True, eq=False)
class ComputedSolid:
    """Surface of a solid.

    Attributes
    ----------
    mesh
        Closed mesh with normals, colours of its faces, and the words that they were made as.
    hull : (K, 3)
        Vertices of the convex hull, which determine every bounding box.
    volume, area
        In scene units.
    seconds
        What computing it took; 0 if it was read from disk.
    """

    mesh: Mesh
    hull: FloatArray
    volume: float
    area: float
    seconds: float


def load(digest: str) -> ComputedSolid | None:
    """Return the stored surface of the expression with a digest, or None."""
    try:
        path = _path(digest)
        if path.stat().st_size > _MAX_FILE_BYTES:
            return None
        with np.load(path, allow_pickle=False) as file:
            data = {name: file[name] for name in file.files}
        mesh, hull = _mesh(data), _array(data["hull"], np.float64)
        volume, area = _array(data["measures"][None], np.float64, 2)[0].tolist()
    except (OSError, RuntimeError, KeyError, ValueError, TypeError, IndexError, EOFError, zipfile.BadZipFile):
        return None
    with suppress(OSError):
        os.utime(path)
    return ComputedSolid(mesh, hull, volume, area, 0.0)


def save(digest: str, solid: ComputedSolid) -> None:
    """Store a surface unless it is. A folder that cannot be written, and a full disk, are no errors."""
    mesh, temporary = solid.mesh, None
    data = {name: getattr(mesh, name) for name in _ARRAYS}
    data |= {"hull": solid.hull, "measures": np.array([solid.volume, solid.area])}
    data["words"] = np.array([word.encode("utf-8", "surrogatepass").hex() for word in mesh.part_words], np.str_)
    if mesh.part is not None:
        data["part"] = mesh.part
    with suppress(OSError, RuntimeError):
        path = _path(digest)
        if path.exists():
            return
        path.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.NamedTemporaryFile(dir=path.parent, suffix=".new", delete=False) as file:
            temporary = file.name
            np.savez(file, **data)
        os.replace(temporary, path)
        temporary = None
        _prune(path.parent.parent)
    if temporary is not None:
        with suppress(OSError):
            os.unlink(temporary)


def _mesh(data: dict[str, Any]) -> Mesh:
    """Return the mesh of stored arrays; raises ValueError if they do not fit together."""
    arrays = {name: _array(data[name], kind) for name, kind in _ARRAYS.items()}
    words = tuple(bytes.fromhex(text).decode("utf-8", "surrogatepass") for text in data["words"].tolist())
    faces, count = arrays["faces"], len(arrays["vertices"])
    part = data.get("part")
    same = len(arrays["normals"]) == count and len(arrays["colors"]) == len(arrays["joints"]) == len(faces)
    if not same or (len(faces) and not 0 <= faces.min() <= faces.max() < count):
        raise ValueError("arrays of different sizes")
    if part is not None and (part.shape != (len(faces),) or not 0 <= part.min() <= part.max() < len(words)):
        raise ValueError("parts without words")
    return Mesh(part=part, part_words=words, **arrays)


def _array(value: Any, kind: Any, columns: int = 3) -> Any:
    if value.dtype != kind or value.ndim != 2 or value.shape[1] != columns:
        raise ValueError("not the array that was stored")
    return value


def _path(digest: str) -> Path:
    return user_folder("CACHE") / "solids" / _version() / f"{digest}.npz"


@cache
def _version() -> str:
    """Return a hash of Manifold's version and of the code that turns expressions into surfaces."""
    from importlib.metadata import version

    total = hashlib.sha256(version("manifold3d").encode())
    here = Path(__file__).parent
    for path in sorted([*here.glob("*.py"), *(here.parent / "primitives").glob("*.py")]):
        total.update(path.read_bytes())
    return total.hexdigest()[:16]


def _prune(folder: Path) -> None:
    """Delete the files used longest ago while there are too many bytes."""
    files = sorted(((path.stat(), path) for path in folder.glob("*/*")), key=lambda each: each[0].st_mtime)
    total = sum(stat.st_size for stat, _ in files)
    for stat, path in files:
        if total <= MAX_STORED_BYTES:
            return
        path.unlink(missing_ok=True)
        total -= stat.st_size
