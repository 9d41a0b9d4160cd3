"""Exports as Wavefront OBJ with an .mtl beside it: one object for each leaf, named by the words down to it.

Colours in .mtl files are sRGB-encoded by convention, so ``Kd`` is. A merged part, whose colours differ, has them on its
vertices (``v x y z r g b``), as most programs read them.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from scenelang.backends.exports.export import Job, PlacedMesh, mesh_backend, placed
from scenelang.backends.pictures.appearance import Look
from scenelang.backends.pictures.studio import to_srgb

_SHINE = 1000.0  # of Ns, which is 0 where a surface is rough


def write(job: Job, path: Path) -> None:
    """Write the first frame of the plan at ``path``, its materials beside it. Raises SceneError and LimitError."""
    materials: dict[Look, str] = {}
    library = path.with_suffix(".mtl")
    with path.open("w", encoding="utf-8", newline="\n") as file:
        file.write(f"# scenelang: y up, colours are sRGB\nmtllib {library.name}\n")
        start, numbers = 1, dict[tuple[str, ...], int]()
        for one in placed(job.plan, job.limit, ".obj"):
            name = _object_name(one, numbers)
            material = materials.setdefault(one.look, f"material_{len(materials) + 1}")
            file.write(f"o {name}\ng {' '.join(map(_spelled, one.path))}\nusemtl {material}\n")
            file.writelines(_lines(one, start))
            start += len(one.surface.vertices)
    library.write_text("".join(_material(name, look) for look, name in materials.items()), encoding="ascii")


def _object_name(one: PlacedMesh, numbers: dict[tuple[str, ...], int]) -> str:
    """The words down to the leaf, and a number that tells it from others with the same words."""
    number = numbers[one.path] = numbers.get(one.path, 0) + 1
    return "/".join(map(_spelled, one.path)) + (f".{number:03d}" if number > 1 else "")


def _spelled(word: str) -> str:
    """A word without what ends a name in the format."""
    return re.sub(r"[\s/#\\]+", "_", word.encode("utf-8", "replace").decode()) or "_"


def _lines(one: PlacedMesh, start: int) -> Iterator[str]:
    """The vertices, normals and faces of one object, whose vertices are numbered from ``start``."""
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
        lines += [f"Ns {_SHINE * (1.0 - look.gloss) ** 2:g}", f"Pr {look.gloss:g}"]
    if look.metallic:
        lines.append(f"Pm {look.metallic:g}")
    if any(look.emission):
        lines.append(f"Ke {' '.join(f'{x:g}' for x in look.emission)}")
    if look.ior is not None:
        lines.append(f"Ni {look.ior:g}")
    return "\n".join(lines) + "\n\n"


OBJ = mesh_backend("obj", "Wavefront OBJ with materials, one object for each primitive or part", (".obj",), write)
