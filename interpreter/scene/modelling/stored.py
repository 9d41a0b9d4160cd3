"""Surfaces of solids, and their files in the user's cache folder: another run need not compute them again.

A file is named by the digest of its expression, its folder by Manifold's version and a hash of the code, on which the
surface also depends. A file that cannot be read counts as absent. Where the evaluation of a program may not use files,
nothing is read or written. Intermediate nodes are not stored, because Manifold's numbers of surfaces are valid within
one process only.
"""

from __future__ import annotations

import hashlib
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from scenelang.grammar.datum import dataclass
from scenelang.interpreter.loading import np, read_cached, write_cached
from scenelang.interpreter.scene.primitives.mesh import Mesh

if TYPE_CHECKING:
    import numpy.typing as npt

    FloatArray = npt.NDArray[np.float64]

_ARRAYS = {"vertices": np.float64, "normals": np.float64, "faces": np.int64, "colors": np.float64, "joints": np.int64}


@dataclass(frozen=True, slots=True, eq=False)
class ComputedSolid:
    """Surface of a solid.

    Attributes
    ----------
    mesh
        Closed mesh with normals, and with colors and words of its faces.
    hull : (K, 3)
        Vertices of the convex hull, which determine every bounding box.
    volume, area
        In cubed and squared scene units.
    seconds
        Duration of the computation; 0 if it was read from disk.
    """

    mesh: Mesh
    hull: FloatArray
    volume: float
    area: float
    seconds: float


def load(digest: str) -> ComputedSolid | None:
    """Return the stored surface of the expression with a digest, or None."""
    data = read_cached(_kind(), digest)
    if data is None:
        return None
    try:
        mesh, hull = _mesh(data), _array(data["hull"], np.float64)
        volume, area = _array(data["measures"][None], np.float64, 2)[0].tolist()
    except (KeyError, ValueError, TypeError, IndexError):
        return None
    return ComputedSolid(mesh, hull, volume, area, 0.0)


def save(digest: str, solid: ComputedSolid) -> None:
    """Store a surface in the user's cache under the digest of its expression, unless it is stored already."""
    mesh = solid.mesh
    data = {name: getattr(mesh, name) for name in _ARRAYS}
    data |= {"hull": solid.hull, "measures": np.array([solid.volume, solid.area])}
    data["words"] = np.array([word.encode("utf-8", "surrogatepass").hex() for word in mesh.part_words], np.str_)
    if mesh.part is not None:
        data["part"] = mesh.part
    write_cached(_kind(), digest, data)


def _mesh(data: dict[str, Any]) -> Mesh:
    """Return the mesh of stored arrays; raises ValueError if they do not fit together."""
    arrays = {name: _array(data[name], kind) for name, kind in _ARRAYS.items()}
    words = tuple(bytes.fromhex(text).decode("utf-8", "surrogatepass") for text in data["words"].tolist())
    faces, count = arrays["faces"], len(arrays["vertices"])
    part = data.get("part")
    fits = len(arrays["normals"]) == count and len(arrays["colors"]) == len(arrays["joints"]) == len(faces)
    if not fits or (len(faces) and not 0 <= faces.min() <= faces.max() < count):
        raise ValueError("arrays of different sizes")
    if part is not None and (part.shape != (len(faces),) or not 0 <= part.min() <= part.max() < len(words)):
        raise ValueError("parts without words")
    return Mesh(part=part, part_words=words, **arrays)


def _array(value: Any, kind: Any, columns: int = 3) -> Any:
    """Return an array of rows; raises ValueError for another type or shape."""
    if value.dtype != kind or value.ndim != 2 or value.shape[1] != columns:
        raise ValueError("not the array that was stored")
    return value


def _kind() -> str:
    """Return the folder of the files within the cache."""
    return f"solids/{_version()}"


@cache
def _version() -> str:
    """Return a hash of Manifold's version and of the code that turns expressions into surfaces."""
    from importlib.metadata import version

    total = hashlib.sha256(version("manifold3d").encode())
    folder = Path(__file__).parent
    for path in sorted([*folder.glob("*.py"), *(folder.parent / "primitives").glob("*.py")]):
        total.update(path.read_bytes())
    return total.hexdigest()[:16]
