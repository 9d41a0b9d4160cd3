"""Solids as Mitsuba's shapes: exact unit shapes to be placed many times, and merged meshes whose faces carry colours.

Mitsuba's own cylinders have no caps, its spheres are none under uneven scales, and it has no cone; so units are closed
by disks and placed as instances, which is right under any invertible affine pose. Merged meshes load linearly.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.appearance import Look
from scenelang.backends.meshes import posed, unit_mesh
from scenelang.backends.mitsuba.materials import (
    FACE_COLOR,
    FACE_GLOSS,
    FACE_METAL,
    FACE_OPACITY,
    face_surface,
    is_glass,
    rgb,
    surface,
)
from scenelang.backends.solids import Form, Solids, thinness
from scenelang.backends.studio import BRIGHTEST

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]

SEGMENTS = (8, 12, 16, 24, 32, 48, 64, 96, 128, 192)
CONE_SEGMENTS = 256
_DEVIATION = 0.15  # pixels that a polygon may lie inside the circle that it stands for
_MOST_FACES = 24_000_000
_GLOW_STEPS = 16  # distinct strengths per channel that glowing colours are rounded to, per unit
_FLAT = (Form.BLOCK, Form.TRIANGLE)
_FLATTEST = 0.02  # least over greatest half axis of a ball that is drawn as Mitsuba's sphere


def unit_parts(form: Form) -> list[dict[str, Any]]:
    """The exact shapes of a canonical solid without their material, poses as (4, 4); none of a cone, which Mitsuba does
    not have: it is a mesh of ``CONE_SEGMENTS`` sides."""
    if form == Form.BALL:
        return [{"type": "sphere"}]
    if form == Form.BLOCK:
        return [{"type": "cube"}]
    if form == Form.CYLINDER:
        side = {"type": "cylinder", "p0": (0, -1, 0), "p1": (0, 1, 0), "radius": 1.0}
        return [side, *({"type": "disk", "to_world": _cap(y)} for y in (1.0, -1.0))]
    return []


def _cap(y: float) -> FloatArray:
    """The pose of the unit disk as the end of a cylinder, facing outward."""
    return np.array([[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, y, y], [0.0, -y, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]])


def unit_group(mi: Any, form: Form, look: Look) -> Any:
    """A shape group of the canonical solid, exact but for cones."""
    bsdf = mi.load_dict(surface(look))
    parts = {}
    for k, part in enumerate(unit_parts(form)):
        pose = {"to_world": mi.ScalarTransform4f(part["to_world"])} if "to_world" in part else {}
        parts[f"part{k}"] = part | pose | {"bsdf": bsdf}
    if not parts:
        mesh = unit_mesh(form, CONE_SEGMENTS)
        parts = {"mesh": _plain_mesh(mi, bsdf, mesh.vertices, mesh.normals, mesh.faces)}
    return mi.load_dict({"type": "shapegroup", **parts})


def _plain_mesh(mi: Any, bsdf: Any, vertices: FloatArray, normals: FloatArray | None, faces: IntArray) -> Any:
    props = mi.Properties()
    props["bsdf"] = bsdf
    props["face_normals"] = normals is None
    mesh = mi.Mesh("solids", len(vertices), len(faces), has_vertex_normals=normals is not None, props=props)
    _fill(mi, mesh, vertices, normals, faces)
    return mesh


def _fill(mi: Any, mesh: Any, vertices: FloatArray, normals: FloatArray | None, faces: IntArray) -> None:
    params = mi.traverse(mesh)
    params["vertex_positions"] = vertices.astype(np.float32).ravel()
    params["faces"] = faces.astype(np.uint32).ravel()
    if normals is not None:
        params["vertex_normals"] = normals.astype(np.float32).ravel()
    params.update()


# --- merged meshes ---------------------------------------------------------------------------------------------


def merged_meshes(mi: Any, solids: Solids, segments: IntArray) -> Iterator[Any]:
    """Few meshes of all ``solids``: by glow, since an emitter has one radiance, by kind of material, by whether faces
    are flat. ``segments`` (N,) are the sides of round solids."""
    flat = np.isin(solids.forms, _FLAT)
    glow = np.rint(solids.emission * _GLOW_STEPS) / _GLOW_STEPS
    matte, clear = solids.looks.matte[solids.look], solids.opacity < 1.0
    glass = np.array([is_glass(look) for look in solids.looks.rows], bool)[solids.look]
    own = np.where(glass, solids.look, -1)  # refracting materials cannot differ within a mesh
    keys = np.column_stack([glow, own, flat, matte, clear])
    kinds, kind = np.unique(keys, axis=0, return_inverse=True)
    for k, key in enumerate(kinds):
        rows = np.flatnonzero(kind.reshape(-1) == k)
        part = solids.take(rows)
        bsdf = surface(solids.looks.rows[int(key[3])]) if key[3] >= 0 else face_surface(bool(key[5]), bool(key[6]))
        yield _merged_mesh(mi, part, segments[rows], bool(key[4]), bsdf, key[:3])


def _merged_mesh(
    mi: Any, solids: Solids, segments: IntArray, is_flat: bool, bsdf: dict[str, Any], glow: FloatArray
) -> Any:
    vertices, normals, faces, owner = _merged(solids, segments)
    props = mi.Properties()
    props["bsdf"] = mi.load_dict(bsdf)
    props["face_normals"] = is_flat
    if glow.any():
        props["emitter"] = mi.load_dict({"type": "area", "radiance": rgb(glow)})
    mesh = mi.Mesh("solids", len(vertices), len(faces), has_vertex_normals=not is_flat, props=props)
    look = solids.look[owner]
    mesh.add_attribute(FACE_COLOR, 3, (solids.looks.color[look] * BRIGHTEST).astype(np.float32).ravel())
    for name, values in (
        (FACE_OPACITY, solids.looks.opacity),
        (FACE_GLOSS, np.maximum(solids.looks.gloss, 0.03)),
        (FACE_METAL, solids.looks.metallic),
    ):
        mesh.add_attribute(name, 1, values[look].astype(np.float32))
    _fill(mi, mesh, vertices, None if is_flat else normals, faces)
    return mesh


def segments_for(solids: Solids, pixels: FloatArray) -> IntArray:
    """Sides (N,) of round solids that are ``pixels`` (N,) large in the picture; fewer where the meshes would not fit
    the memory, 0 for flat ones."""
    wanted = math.pi * np.sqrt(pixels / (2.0 * _DEVIATION))
    choices = np.array(SEGMENTS)
    for coarser in range(len(choices)):
        sides = choices[np.clip(np.searchsorted(choices, wanted) - coarser, 0, len(choices) - 1)]
        faces = np.where(solids.forms == Form.BALL, sides * sides, 4 * sides)
        if faces.sum() <= _MOST_FACES:
            break
    return np.asarray(np.where(np.isin(solids.forms, _FLAT), 0, sides), np.int64)


def is_too_flat(solids: Solids) -> npt.NDArray[np.bool_]:
    """Which solids (N,) are balls that Mitsuba's sphere cannot be."""
    return np.asarray((solids.forms == Form.BALL) & dissolves(solids.matrices), bool)


def dissolves(matrices: FloatArray) -> npt.NDArray[np.bool_]:
    """Under which poses (N, 3, 4) Mitsuba's sphere, in single precision, is so flat that it dissolves."""
    return np.asarray(thinness(matrices) < _FLATTEST * sizes_of(matrices), bool)


def sizes_of(matrices: FloatArray) -> FloatArray:
    """The longest half axis (N,) of solids under ``matrices`` (N, 3, 4)."""
    return np.asarray(np.sqrt(np.einsum("nij,nij->nj", matrices[:, :, :3], matrices[:, :, :3])).max(axis=1), np.float64)


def _merged(solids: Solids, segments: IntArray) -> tuple[FloatArray, FloatArray, IntArray, IntArray]:
    """Vertices, normals, faces of all solids, and the number of the solid that each face belongs to."""
    parts: list[tuple[FloatArray, FloatArray, IntArray, IntArray]] = []
    start = 0
    for form in Form:
        for sides in np.unique(segments[solids.forms == form]):
            rows = np.flatnonzero((solids.forms == form) & (segments == sides))
            mesh = unit_mesh(form, max(3, int(sides)))
            vertices, normals, faces = posed(mesh, solids.matrices[rows])
            parts.append((vertices, normals, faces + start, np.repeat(rows, len(mesh.faces))))
            start += len(vertices)
    vertices, normals, faces, owner = (np.concatenate(column) for column in zip(*parts, strict=True))
    return vertices, normals, faces, owner
