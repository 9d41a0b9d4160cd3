"""Exports as Mitsuba 3 XML, with the meshes that it names in .ply files beside it, in world coordinates.

Camera, light, ground and materials are those of final pictures. Primitives are instances of exact unit shapes, which
is right under any pose; beyond ``--instance-limit`` repeated parts are instances of merged meshes. Mitsuba can place
no lamp as an instance, and nothing under a singular pose: these are meshes in the world, one for each material.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from scenelang.backends.appearance import Look, look_of
from scenelang.backends.base import need
from scenelang.backends.exports.export import INSTANCES, Job, mesh_backend, unsupported_frames
from scenelang.backends.exports.items import Item, Plan, cut_below, distinct
from scenelang.backends.exports.merging import WHITE, Patch, joined, merged, segments_for
from scenelang.backends.exports.ply import write_ply
from scenelang.backends.exports.surfaces import Surface, solid_of
from scenelang.backends.exports.world import leaves
from scenelang.backends.exports.xml_elements import elements
from scenelang.backends.meshes import unit_mesh
from scenelang.backends.mitsuba.materials import surface as bsdf_of
from scenelang.backends.mitsuba.shapes import CONE_SEGMENTS, dissolves, unit_parts
from scenelang.backends.solids import Form
from scenelang.backends.studio import BRIGHTEST
from scenelang.interpreter import pose
from scenelang.interpreter.values import Matrix

_VERTEX = np.dtype([("position", "<f4", 3), ("normal", "<f4", 3), ("color", "<f4", 3)])
_PROPERTIES = tuple(("float", name) for name in ("x", "y", "z", "nx", "ny", "nz", "r", "g", "b"))
_COLORS = {"type": "mesh_attribute", "name": "vertex_color"}


def write(job: Job, path: Path) -> None:
    """Write the first frame of the plan at ``path``. Raises SceneError and LimitError."""
    from scenelang.backends.exports.mitsuba_stage import stage_elements

    unsupported_frames(job.plan.roots, ".xml")
    need("mitsuba", "mitsuba")
    plan = cut_below(job.plan, job.instances)
    whole = [item.entity for item in distinct(*plan.roots) if item.merged]
    shapes = _Shapes(path, segments_for(whole, "the merged meshes"))
    with path.open("w", encoding="utf-8", newline="\n") as file:
        file.write('<?xml version="1.0" encoding="utf-8"?>\n<!-- scenelang: y up, linear sRGB -->\n')
        file.write('<scene version="3.0.0">\n')
        file.writelines(line + "\n" for line in stage_elements(plan))
        file.writelines(line + "\n" for line in shapes.lines(plan))
        file.write("</scene>\n")


@dataclass(slots=True)
class _Shapes:
    """Writes the shapes of a scene and their meshes; remembers the groups that instances refer to."""

    path: Path
    segments: int
    meshes: int = 0
    groups: dict[Hashable, str | None] = field(default_factory=dict)
    patches: dict[int, tuple[list[Patch], list[Patch]]] = field(default_factory=dict)
    loose: dict[Look, list[Surface]] = field(default_factory=dict)

    def lines(self, plan: Plan) -> Iterator[str]:
        """The elements of all leaves, in depth-first order; what cannot be an instance comes last."""
        for leaf in leaves(plan, 2**40):
            fresh: list[str] = []
            place = self._placed(leaf.item, leaf.pose, fresh)
            yield from fresh
            if place is not None:
                group, local = place
                matrix = np.vstack([np.array(local).reshape(3, 4), [0.0, 0.0, 0.0, 1.0]])
                yield from elements(None, {"type": "instance", "group": {"ref": group}, "to_world": matrix})
        for look, surfaces in self.loose.items():
            yield from elements(None, self._mesh(Patch(look, joined(surfaces))))

    def _placed(self, item: Item, place: Matrix, fresh: list[str]) -> tuple[str, Matrix] | None:
        """The group of a leaf and its pose; None where it is loose or nothing is seen. ``fresh`` gets a new group."""
        if item.merged:
            still, lamps = self._merged(item)
            if _is_flat(place):
                self._loosen([*still, *lamps], place)
                return None
            self._loosen(lamps, place)
            if id(item.entity) not in self.groups:
                self._add_group(id(item.entity), [self._mesh(patch) for patch in still], fresh)
            group = self.groups[id(item.entity)]
            return None if group is None else (group, place)
        look, solid = look_of(item.entity), solid_of(item.entity)
        if solid is None or look.opacity == 0.0:
            return None
        whole = pose.compose(place, solid.pose)
        if any(look.emission) or _is_flat(whole) or (solid.form == Form.BALL and _dissolves(whole)):
            surface = solid.surface()
            self._loosen([] if surface is None else [Patch(look, surface)], whole)
            return None
        key = (solid.key, look)
        if key not in self.groups:
            parts = self._own(item, look) if solid.form is None else self._unit(solid.form, look)
            self._add_group(key, parts, fresh)
        group = self.groups[key]
        return None if group is None else (group, whole)

    def _merged(self, item: Item) -> tuple[list[Patch], list[Patch]]:
        """The patches of a merged item: those that can be instances, and lamps."""
        if id(item.entity) not in self.patches:
            found = merged(item.entity, self.segments)
            dark = [patch for patch in found if not any(patch.look.emission)]
            self.patches[id(item.entity)] = dark, [patch for patch in found if any(patch.look.emission)]
        return self.patches[id(item.entity)]

    def _own(self, item: Item, look: Look) -> list[dict[str, Any]]:
        """The mesh of a primitive that is no canonical solid."""
        solid = solid_of(item.entity)
        surface = None if solid is None else solid.surface()
        return [] if surface is None else [self._mesh(Patch(look, surface))]

    def _loosen(self, patches: list[Patch], place: Matrix) -> None:
        """Add patches to the meshes that stand in the world."""
        for patch in patches:
            copy = patch.surface.under(np.array(place).reshape(1, 3, 4))
            colors = np.ones_like(copy.vertices) if copy.colors is None else copy.colors
            painted = replace(copy, colors=colors * np.array(patch.look.color))
            self.loose.setdefault(replace(patch.look, color=WHITE), []).append(painted)

    def _add_group(self, key: Hashable, parts: list[dict[str, Any]], fresh: list[str]) -> None:
        """A new group of shapes, whose element goes to ``fresh``; none where it would be empty."""
        name = f"group{len(self.groups) + 1}" if parts else None
        self.groups[key] = name
        if parts:
            shapes = {f"part{k}": part for k, part in enumerate(parts)}
            fresh += elements(None, {"type": "shapegroup", "id": name, **shapes})

    def _unit(self, form: Form, look: Look) -> list[dict[str, Any]]:
        """The canonical solid, exact but for cones."""
        parts = [part | {"bsdf": bsdf_of(look)} for part in unit_parts(form)]
        if parts:
            return parts
        mesh = unit_mesh(form, CONE_SEGMENTS)
        return [self._mesh(Patch(look, Surface(mesh.vertices, mesh.normals, mesh.faces)))]

    def _mesh(self, patch: Patch) -> dict[str, Any]:
        """A .ply file beside the scene, and the element that names it."""
        self.meshes += 1
        file = self.path.with_name(f"{self.path.stem}-mesh{self.meshes:03d}.ply")
        _write_ply(file, patch)
        painted = _painted(bsdf_of(replace(patch.look, color=WHITE)))
        shape: dict[str, Any] = {"type": "ply", "filename": file.name, "bsdf": painted}
        if any(patch.look.emission):
            shape["emitter"] = {"type": "area", "radiance": {"type": "rgb", "value": patch.look.emission}}
        return shape


def _write_ply(file: Path, patch: Patch) -> None:
    """A mesh whose vertices have the colours that reflect, linear."""
    surface = patch.surface
    colors = np.ones_like(surface.vertices) if surface.colors is None else surface.colors
    rows = np.empty(len(surface.vertices), _VERTEX)
    rows["position"], rows["normal"] = surface.vertices, surface.normals
    rows["color"] = colors * np.array(patch.look.color) * BRIGHTEST
    write_ply(file, _PROPERTIES, [rows], [surface.faces])


def _painted(bsdf: Mapping[str, Any]) -> dict[str, Any]:
    """A material whose colour is that of the mesh's vertices."""
    out: dict[str, Any] = {}
    for key, value in bsdf.items():
        if key in ("reflectance", "base_color"):
            out[key] = _COLORS
        else:
            out[key] = _painted(value) if isinstance(value, Mapping) and value.get("type") != "rgb" else value
    return out


def _is_flat(place: Matrix) -> bool:
    """True when the pose cannot be inverted in single precision."""
    linear = np.array(place).reshape(3, 4)[:, :3]
    largest = float(np.abs(linear).max())
    return largest == 0.0 or abs(float(np.linalg.det(linear / largest))) < 1e-9


def _dissolves(place: Matrix) -> bool:
    return bool(dissolves(np.array(place).reshape(1, 3, 4))[0])


MITSUBA_XML = mesh_backend(
    "mitsuba-xml",
    "Mitsuba 3 XML with meshes beside it: the scene of final pictures",
    (".xml",),
    write,
    options=(INSTANCES,),
    packages=("mitsuba",),
    install="mitsuba",
)
