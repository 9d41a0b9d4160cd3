"""Prims of a USD layer through Sdf, which is twenty times faster than UsdGeom: transforms, shapes, meshes."""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.appearance import Look
from scenelang.backends.base import need
from scenelang.backends.exports.facts import facts_of, merged_facts
from scenelang.backends.exports.items import Item
from scenelang.backends.exports.surfaces import Surface, unit_surface
from scenelang.backends.solids import Form
from scenelang.interpreter.bounds import entity_box
from scenelang.interpreter.values import IDENTITY, Matrix

INSTALL = "'scenelang[usd]'"
SHAPES = "Shapes"  # the prim below the root that holds the canonical solids
_UNIFORM = ("subdivisionScheme", "xformOpOrder")


def valid_name(word: str) -> str:
    """``word`` as a prim's name: ASCII letters, digits and underscores, no digit first."""
    name = re.sub(r"[^A-Za-z0-9_]+", "_", word)[:80].strip("_") or "entity"
    return f"_{name}" if name[0].isdigit() else name


@dataclass(slots=True)
class Names:
    """Names of siblings, each once."""

    taken: dict[str, int] = field(default_factory=dict)

    def fresh(self, word: str) -> str:
        """A name for ``word`` that no sibling has: ``name``, ``name_2``, ``name_3``, ..."""
        base = name = valid_name(word)
        number = self.taken.get(base, 0)
        while number and name in self.taken:
            number += 1
            name = f"{base}_{number}"
        self.taken[base] = max(number, 1)
        self.taken.setdefault(name, 1)
        return name


class Prims:
    """Makes prims in one layer. Poses are affine, 12 floats, column vectors; USD's are their transposes."""

    def __init__(self, layer: Any) -> None:
        self.sdf, self.gf, self.vt = (need(f"pxr.{name}", INSTALL) for name in ("Sdf", "Gf", "Vt"))
        self.layer = layer
        self._solids: dict[Form, Any] = {}

    def prim(self, parent: Any, name: str, kind: str, abstract: bool = False) -> Any:
        """A new prim of the schema ``kind`` below ``parent``, a prim or the layer."""
        specifier = self.sdf.SpecifierClass if abstract else self.sdf.SpecifierDef
        return self.sdf.PrimSpec(parent, name, specifier, kind)

    def attribute(self, prim: Any, name: str, kind: str, value: Any = None, custom: bool = False) -> Any:
        """A new attribute of the type ``kind``, as Sdf.ValueTypeNames spells it."""
        sdf = self.sdf
        how = sdf.VariabilityUniform if name in _UNIFORM or name.startswith("info:") else sdf.VariabilityVarying
        made = sdf.AttributeSpec(prim, name, getattr(sdf.ValueTypeNames, kind), how, custom)
        if value is not None:
            made.default = value
        return made

    def points(self, values: npt.NDArray[Any]) -> Any:
        """Rows of three numbers as USD keeps them."""
        return self.vt.Vec3fArray.FromNumpy(np.ascontiguousarray(values, np.float32))

    def matrix(self, pose: Matrix) -> Any:
        """The pose as USD writes it, for row vectors."""
        m = pose
        return self.gf.Matrix4d(m[0], m[4], m[8], 0, m[1], m[5], m[9], 0, m[2], m[6], m[10], 0, m[3], m[7], m[11], 1)

    # --- poses and visibility, still or over time ---

    def place(self, prim: Any, poses: Sequence[Matrix]) -> None:
        """The pose of a prim, one for each frame or one for all."""
        moves = len(set(poses)) > 1
        if not moves and poses[0] == IDENTITY:
            return
        made = self.attribute(prim, "xformOp:transform", "Matrix4d", None if moves else self.matrix(poses[0]))
        self.attribute(prim, "xformOpOrder", "TokenArray", self.vt.TokenArray(["xformOp:transform"]))
        if moves:
            last = len(poses) - 1
            for frame, pose in enumerate(poses):
                if frame in (0, last) or pose != poses[frame - 1] or pose != poses[frame + 1]:
                    self.layer.SetTimeSample(made.path, frame, self.matrix(pose))

    def show(self, prim: Any, shown: Sequence[bool]) -> None:
        """Hide the prim in the frames in which it is not there."""
        if all(shown):
            return
        made = self.attribute(prim, "visibility", "Token")
        for frame, seen in enumerate(shown):
            if frame == 0 or seen != shown[frame - 1]:
                self.layer.SetTimeSample(made.path, frame, "inherited" if seen else "invisible")

    # --- what an entity says ---

    def describe(self, prim: Any, item: Item) -> None:
        """The custom attributes of an entity: its word, handle and embedding, the latter as JSON text."""
        facts = merged_facts(item.entity) if item.merged else facts_of(item.entity)
        self.attribute(prim, "scenelang:word", "String", _text(facts["word"]), custom=True)
        if "handle" in facts:
            self.attribute(prim, "scenelang:handle", "String", _text(facts["handle"]), custom=True)
        embedding = {name: facts[name] for name in ("handle", "text", "attributes") if name in facts}
        if embedding:
            self.attribute(prim, "scenelang:embedding", "String", json.dumps(embedding), custom=True)
        if item.merged:
            self.attribute(prim, "scenelang:words", "String", json.dumps(facts["words"]), custom=True)

    def hint_extent(self, prim: Any, roots: Sequence[Item]) -> None:
        """The box of the whole scene, where it can be read without opening anything below ``prim``."""
        boxes = [entity_box(root.entity) for root in roots]
        known = next(box for box in boxes if box is not None)
        made = self.attribute(prim, "extentsHint", "Float3Array")
        values = [self.points(np.array(box or known).reshape(2, 3)) for box in boxes]
        made.default = values[0]
        for frame, value in enumerate(values if len(set(boxes)) > 1 else ()):
            self.layer.SetTimeSample(made.path, frame, value)

    # --- geometry ---

    def shape(self, parent: Any, name: str, form: Form, look: Look) -> Any:
        """A canonical solid: a reference to one mesh for all of its form. Blender gives materials to meshes only, not
        to USD's own cubes and spheres."""
        prim = self.prim(parent, name, "Mesh")
        prim.referenceList.prependedItems = [self.sdf.Reference("", self._solid(form))]
        self._paint(prim, np.array([look.color]), "constant", look)
        return prim

    def _solid(self, form: Form) -> Any:
        """The path of a canonical solid's mesh, which is added when it is first asked for."""
        if form not in self._solids:
            root = self.layer.GetPrimAtPath(f"/{self.layer.defaultPrim}")
            holder = root.nameChildren.get(SHAPES) or self.prim(root, SHAPES, "", abstract=True)
            mesh = self.prim(holder, form.name.lower(), "Mesh")
            self._triangles(mesh, unit_surface(form))
            self._solids[form] = mesh.path
        return self._solids[form]

    def mesh(self, parent: Any, name: str, surface: Surface, look: Look) -> Any:
        """Triangles with their normals and, where the surface has them, colours."""
        prim = self.prim(parent, name, "Mesh")
        self._triangles(prim, surface)
        if surface.colors is None:
            self._paint(prim, np.array([look.color]), "constant", look)
        else:
            self._paint(prim, surface.colors, "vertex", look)
        return prim

    def _triangles(self, prim: Any, surface: Surface) -> None:
        counts = self.vt.IntArray(len(surface.faces), 3)
        indices = self.vt.IntArray.FromNumpy(np.ascontiguousarray(surface.faces.reshape(-1), np.int32))
        low, high = surface.vertices.min(axis=0), surface.vertices.max(axis=0)
        self.attribute(prim, "subdivisionScheme", "Token", "none")
        self.attribute(prim, "faceVertexCounts", "IntArray", counts)
        self.attribute(prim, "faceVertexIndices", "IntArray", indices)
        self.attribute(prim, "points", "Point3fArray", self.points(surface.vertices))
        normals = self.attribute(prim, "normals", "Normal3fArray", self.points(surface.normals))
        normals.SetInfo("interpolation", "vertex")
        self.attribute(prim, "extent", "Float3Array", self.points(np.stack([low, high])))
        self.attribute(prim, "doubleSided", "Bool", True)

    def _paint(self, prim: Any, colors: npt.NDArray[np.float64], interpolation: str, look: Look) -> None:
        made = self.attribute(prim, "primvars:displayColor", "Color3fArray", self.points(colors))
        made.SetInfo("interpolation", interpolation)
        if look.opacity < 1.0:
            clear = self.vt.FloatArray([look.opacity])
            self.attribute(prim, "primvars:displayOpacity", "FloatArray", clear).SetInfo("interpolation", "constant")


def _text(text: str) -> str:
    """``text`` as UTF-8 can hold it."""
    return text.encode("utf-8", "replace").decode("utf-8").replace("\0", "")
