"""Export to OpenUSD: .usda text, .usdc and .usd binary, .usdz package.

Every distinct entity that occurs in several places is a prototype, referenced by instanceable prims at each place, also
inside other prototypes: the file grows with distinct entities, not with instances. Everything is below the default
prim, the root entity: its hierarchy, ``Prototypes`` and ``Shapes`` (classes, which are not rendered themselves) and
``Materials``. A primitive is an Xform with the entity's attributes above the mesh ``geometry``.
"""

from __future__ import annotations

import errno
import json
import re
import tempfile
from collections.abc import Hashable, Sequence
from contextlib import nullcontext
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.base import BackendOptions, Option, check_settings, require
from scenelang.backends.exports.export import (
    FPS,
    INSTANCING,
    SIDES,
    TOLERANCE,
    Fineness,
    Job,
    Moving,
    TextureFiles,
    facts_of,
    fineness,
    matched,
    merged_facts,
    merged_sides,
    mesh_backend,
    variants,
)
from scenelang.backends.exports.plan import (
    COAT_ROUGHNESS,
    SEGMENTS,
    ExportItem,
    ExportPlan,
    ExportSurface,
    Solid,
    as_material,
    distinct,
    merged,
    points_of,
    shared,
    solid_of,
    translation,
)
from scenelang.backends.surfaces.appearance import Look, look_of, material_name
from scenelang.backends.surfaces.precision import about, common_offset, size_of
from scenelang.backends.surfaces.trs import decompose, unsheared
from scenelang.grammar.diagnostics import LimitError, SceneError
from scenelang.interpreter.plugins import SERVICES
from scenelang.interpreter.scene.bounds import entity_box
from scenelang.interpreter.scene.entity import Scene
from scenelang.interpreter.scene.primitives.textures import Texture
from scenelang.interpreter.values.values import IDENTITY, Matrix

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]

# Prims of a USD layer through Sdf, which is twenty times faster than UsdGeom.


INSTALL = "'scenelang[usd]'"
SHAPES = "Shapes"  # parent prim of the canonical solids
COORDINATES = "primvars:st"  # of textures, as readers expect them
_UNIFORM = ("subdivisionScheme", "xformOpOrder", "axis")


def valid_name(word: str) -> str:
    """Return ``word`` as a valid prim name: ASCII letters, digits and underscores, not starting with a digit."""
    name = re.sub(r"[^A-Za-z0-9_]+", "_", word)[:80].strip("_") or "entity"
    return f"_{name}" if name[0].isdigit() else name


@dataclass(slots=True)
class PrimNames:
    """Generates distinct names for siblings."""

    taken: dict[str, int] = field(default_factory=dict)

    def fresh(self, word: str) -> str:
        """Return a name for ``word`` that no sibling has: ``name``, ``name_2``, ``name_3``, ..."""
        base = name = valid_name(word)
        number = self.taken.get(base, 0)
        while number and name in self.taken:
            number += 1
            name = f"{base}_{number}"
        self.taken[base] = max(number, 1)
        self.taken.setdefault(name, 1)
        return name


class Prims:
    """Creates prims in one layer.

    Poses are affine, 12 floats, for column vectors; USD's matrices are their transposes. ``shares``: the faces of
    meshes share points.
    """

    def __init__(self, layer: Any, shares: bool = False) -> None:
        """Import USD's modules; raises SceneError("backend") without usd-core."""
        self.shares = shares
        self.sdf, self.gf, self.vt = (require(f"pxr.{name}", INSTALL) for name in ("Sdf", "Gf", "Vt"))
        self.layer = layer
        self._solids: dict[Hashable, Any] = {}
        self._shape_names = PrimNames()

    def prim(self, parent: Any, name: str, kind: str, abstract: bool = False) -> Any:
        """Add a prim of the schema ``kind`` below ``parent``, a prim or the layer."""
        specifier = self.sdf.SpecifierClass if abstract else self.sdf.SpecifierDef
        return self.sdf.PrimSpec(parent, name, specifier, kind)

    def attribute(self, prim: Any, name: str, kind: str, value: Any = None, custom: bool = False) -> Any:
        """Add an attribute of the type ``kind``, a name in Sdf.ValueTypeNames."""
        sdf = self.sdf
        variability = sdf.VariabilityUniform if name in _UNIFORM or name.startswith("info:") else sdf.VariabilityVarying
        spec = sdf.AttributeSpec(prim, name, getattr(sdf.ValueTypeNames, kind), variability, custom)
        if value is not None:
            spec.default = value
        return spec

    def points(self, values: npt.NDArray[Any]) -> Any:
        """Convert rows of three numbers to USD's array type."""
        return self.vt.Vec3fArray.FromNumpy(np.ascontiguousarray(values, np.float32))

    def matrix(self, pose: Matrix) -> Any:
        """Convert a pose to USD's matrix type, for row vectors."""
        m = pose
        return self.gf.Matrix4d(m[0], m[4], m[8], 0, m[1], m[5], m[9], 0, m[2], m[6], m[10], 0, m[3], m[7], m[11], 1)

    # --- poses and visibility, static or animated ---

    def place(self, prim: Any, poses: Sequence[Matrix], has_order: bool = False) -> None:
        """Set the pose of a prim, or one per frame; with ``has_order``, its prototype has the ``xformOpOrder``."""
        moves = len(set(poses)) > 1
        if not moves and poses[0] == IDENTITY:
            return
        transform = self.attribute(prim, "xformOp:transform", "Matrix4d", None if moves else self.matrix(poses[0]))
        if not has_order:
            self.order(prim)
        if moves:
            last = len(poses) - 1
            for frame, pose in enumerate(poses):
                if frame in (0, last) or pose != poses[frame - 1] or pose != poses[frame + 1]:
                    self.layer.SetTimeSample(transform.path, frame, self.matrix(pose))

    def order(self, prim: Any) -> None:
        """Set the ``xformOpOrder`` of a prim, or of a prototype for its references."""
        self.attribute(prim, "xformOpOrder", "TokenArray", self.vt.TokenArray(["xformOp:transform"]))

    def show(self, prim: Any, shown: Sequence[bool]) -> None:
        """Hide the prim in the frames without it."""
        if all(shown):
            return
        visibility = self.attribute(prim, "visibility", "Token")
        for frame, is_shown in enumerate(shown):
            if frame == 0 or is_shown != shown[frame - 1]:
                self.layer.SetTimeSample(visibility.path, frame, "inherited" if is_shown else "invisible")

    # --- metadata ---

    def describe(self, prim: Any, item: ExportItem) -> None:
        """Add the custom attributes of an entity: its word, handle, and embedding as JSON text."""
        facts = merged_facts(item.entity) if item.merged else facts_of(item.entity)
        self.attribute(prim, "scenelang:word", "String", _text(facts["word"]), custom=True)
        if "handle" in facts:
            self.attribute(prim, "scenelang:handle", "String", _text(facts["handle"]), custom=True)
        embedding = {name: facts[name] for name in ("handle", "text", "attributes") if name in facts}
        if embedding:
            self.attribute(prim, "scenelang:embedding", "String", json.dumps(embedding), custom=True)
        if item.merged:
            self.attribute(prim, "scenelang:words", "String", json.dumps(facts["words"]), custom=True)

    def hint_extent(self, prim: Any, roots: Sequence[ExportItem]) -> None:
        """Set the bounding box of the whole scene, which can be read without loading anything below ``prim``."""
        boxes = [entity_box(root.entity) for root in roots]
        known = next((box for box in boxes if box is not None), None)
        if known is None:
            return
        extents = self.attribute(prim, "extentsHint", "Float3Array")
        values = [self.points(np.array(box or known).reshape(2, 3)) for box in boxes]
        extents.default = values[0]
        for frame, value in enumerate(values if len(set(boxes)) > 1 else ()):
            self.layer.SetTimeSample(extents.path, frame, value)

    def hint_instances(self, prim: Any, items: Sequence[ExportItem], poses: FloatArray) -> None:
        """Set the extent of a PointInstancer, whose instances are the items under the poses (K, 3, 4)."""
        boxes = {id(item): entity_box(item.entity) for item in items}
        known = np.array([boxes[id(item)] or (np.nan,) * 6 for item in items]).reshape(-1, 2, 3)
        middle, half = known.mean(axis=1), (known[:, 1] - known[:, 0]) / 2.0
        places = np.einsum("kij,kj->ki", poses[:, :, :3], middle) + poses[:, :, 3]
        reach = np.einsum("kij,kj->ki", np.abs(poses[:, :, :3]), half)
        if np.isfinite(known).any():
            ends = [np.nanmin(places - reach, axis=0), np.nanmax(places + reach, axis=0)]
            self.attribute(prim, "extent", "Float3Array", self.points(np.array(ends)))

    # --- geometry ---

    def shape(self, parent: Any, name: str, solid: Solid, look: Look, segments: int = SEGMENTS) -> Any:
        """Add a canonical form as a reference to a shared prim.

        The prim has a built-in USD schema if the form has one, such as Capsule, which is exact; else it is a mesh.
        There is one for each form, because Blender 5 binds materials to meshes only, and one for each place of a
        texture on it.
        """
        form = solid.form
        assert form is not None
        schema = None if look.texture is not None else form.usd(solid.ratios)
        key = solid.key_in(look.texture), segments if schema is None else None
        if key not in self._solids:
            root = self.layer.GetPrimAtPath(f"/{self.layer.defaultPrim}")
            holder = root.nameChildren.get(SHAPES) or self.prim(root, SHAPES, "", abstract=True)
            shape_prim = self.prim(holder, self._shape_names.fresh(form.name), "Mesh" if schema is None else schema[0])
            if schema is None:
                surface = solid.surface(segments, look.texture)
                assert surface is not None
                self._triangles(shape_prim, surface)
            else:
                for attribute, (kind, value) in schema[1].items():
                    self.attribute(shape_prim, attribute, kind, value)
                reach = np.abs(form.hull(solid.ratios)).max(axis=0)
                self.attribute(shape_prim, "extent", "Float3Array", self.points(np.stack([-reach, reach])))
            self._solids[key] = shape_prim.path
        prim = self.prim(parent, name, "Mesh" if schema is None else schema[0])
        prim.referenceList.prependedItems = [self.sdf.Reference("", self._solids[key])]
        self._paint(prim, np.array([look.color]), "constant", look)
        return prim

    def instancer(
        self, prim: Any, prototypes: Sequence[Any], index: IntArray, poses: FloatArray, ids: IntArray
    ) -> None:
        """Make ``prim`` a PointInstancer of the paths ``prototypes``.

        Instance ``i`` is ``prototypes[index[i]]`` under ``poses[i]`` (3, 4), which have no shear.
        """
        vt, decomposition = self.vt, decompose(poses)
        relation = self.sdf.RelationshipSpec(prim, "prototypes", custom=False)
        relation.targetPathList.explicitItems = list(prototypes)
        self.attribute(prim, "protoIndices", "IntArray", vt.IntArray.FromNumpy(index.astype(np.int32)))
        self.attribute(prim, "positions", "Point3fArray", self.points(decomposition.translation))
        self.attribute(prim, "ids", "Int64Array", vt.Int64Array.FromNumpy(ids.astype(np.int64)))
        if (decomposition.scale != 1.0).any():
            self.attribute(prim, "scales", "Float3Array", self.points(decomposition.scale))
        if (decomposition.rotation != (0.0, 0.0, 0.0, 1.0)).any():
            rotations = np.ascontiguousarray(decomposition.rotation, np.float32)
            half_rotations = rotations.astype(np.float16)  # for readers without orientationsf
            self.attribute(prim, "orientations", "QuathArray", vt.QuathArray.FromNumpy(half_rotations))
            self.attribute(prim, "orientationsf", "QuatfArray", vt.QuatfArray.FromNumpy(rotations))

    def mesh(self, parent: Any, name: str, surface: ExportSurface, look: Look) -> Any:
        """Add triangles with their normals and, if the surface has them, colors."""
        prim = self.prim(parent, name, "Mesh")
        if self.shares:
            return self._body(prim, surface, look)
        self._triangles(prim, surface)
        if surface.colors is None:
            self._paint(prim, np.array([look.color]), "constant", look)
        else:
            self._paint(prim, surface.colors, "vertex", look)
        return prim

    def _body(self, prim: Any, surface: ExportSurface, look: Look) -> Any:
        """Add triangles that share points, with normals of their corners and colors of their own."""
        body = shared(surface)
        corners = surface.normals[surface.faces[points_of(surface)[2]]].reshape(-1, 3)
        self._triangles(prim, replace(body, normals=corners), "faceVarying")
        face_colors = body.face_colors
        self._paint(
            prim,
            np.array([look.color]) if face_colors is None else face_colors,
            "constant" if face_colors is None else "uniform",
            look,
        )
        return prim

    def _triangles(self, prim: Any, surface: ExportSurface, interpolation: str = "vertex") -> None:
        """Set the mesh attributes of a surface."""
        counts = self.vt.IntArray(len(surface.faces), 3)
        indices = self.vt.IntArray.FromNumpy(np.ascontiguousarray(surface.faces.reshape(-1), np.int32))
        low, high = surface.vertices.min(axis=0), surface.vertices.max(axis=0)
        self.attribute(prim, "subdivisionScheme", "Token", "none")
        self.attribute(prim, "faceVertexCounts", "IntArray", counts)
        self.attribute(prim, "faceVertexIndices", "IntArray", indices)
        self.attribute(prim, "points", "Point3fArray", self.points(surface.vertices))
        normals = self.attribute(prim, "normals", "Normal3fArray", self.points(surface.normals))
        normals.SetInfo("interpolation", interpolation)
        self.attribute(prim, "extent", "Float3Array", self.points(np.stack([low, high])))
        self.attribute(prim, "doubleSided", "Bool", True)
        if surface.uv is not None:
            coordinates = self.vt.Vec2fArray.FromNumpy(np.ascontiguousarray(surface.uv, np.float32))
            self.attribute(prim, COORDINATES, "TexCoord2fArray", coordinates).SetInfo("interpolation", "vertex")

    def _paint(self, prim: Any, colors: npt.NDArray[np.float64], interpolation: str, look: Look) -> None:
        """Set the display color and opacity of a prim."""
        primvar = self.attribute(prim, "primvars:displayColor", "Color3fArray", self.points(colors))
        primvar.SetInfo("interpolation", interpolation)
        if look.opacity < 1.0:
            opacity = self.vt.FloatArray([look.opacity])
            self.attribute(prim, "primvars:displayOpacity", "FloatArray", opacity).SetInfo("interpolation", "constant")


def _text(text: str) -> str:
    """Return ``text`` with characters that UTF-8 cannot encode replaced, and without NUL."""
    return text.encode("utf-8", "replace").decode("utf-8").replace("\0", "")


# UsdPreviewSurface materials, one for each look. USD's colors are linear, like the language's.


@dataclass(slots=True)
class Materials:
    """Adds materials below ``scope``; ``painted`` ones take their color from the mesh's vertices.

    Those with a texture take it from an image, which ``images`` writes.
    """

    prims: Prims
    scope: Any
    images: TextureFiles
    names: PrimNames = field(default_factory=PrimNames)
    _made: dict[tuple[Look, bool], Any] = field(default_factory=dict)

    def bind(self, prim: Any, look: Look, painted: bool = False) -> None:
        """Bind the material of ``look`` to the geometry ``prim``."""
        look = as_material(look)
        key = (look, painted)
        if key not in self._made:
            self._made[key] = self._add(
                self.names.fresh(material_name(look).replace("#", "color_")), look, painted=painted
            )
        sdf = self.prims.sdf
        prim.SetInfo("apiSchemas", sdf.TokenListOp.Create(prependedItems=["MaterialBindingAPI"]))
        binding = sdf.RelationshipSpec(prim, "material:binding", custom=False, variability=sdf.VariabilityUniform)
        binding.targetPathList.explicitItems = [self._made[key]]

    def _add(self, name: str, look: Look, *, painted: bool) -> Any:
        """Add a material with a UsdPreviewSurface shader and return its path."""
        prims, gf = self.prims, self.prims.gf
        material = prims.prim(self.scope, name, "Material")
        surface = prims.prim(material, "surface", "Shader")
        prims.attribute(surface, "info:id", "Token", "UsdPreviewSurface")
        color = prims.attribute(surface, "inputs:diffuseColor", "Color3f", gf.Vec3f(*look.color))
        if look.texture is not None:
            color.connectionPathList.explicitItems = [self._image(material, look.texture, look)]
            if look.texture.bump:
                normal = prims.attribute(surface, "inputs:normal", "Normal3f", gf.Vec3f(0.0, 0.0, 1.0))
                normal.connectionPathList.explicitItems = [self._image(material, look.texture, look, is_relief=True)]
        elif painted:
            color.connectionPathList.explicitItems = [self._reader(material, "color", 3, "displayColor")]
        prims.attribute(surface, "inputs:roughness", "Float", look.gloss)
        prims.attribute(surface, "inputs:metallic", "Float", look.metallic)
        if look.opacity < 1.0:
            prims.attribute(surface, "inputs:opacity", "Float", look.opacity)
        if any(look.emission):
            prims.attribute(surface, "inputs:emissiveColor", "Color3f", gf.Vec3f(*look.emission))
        if look.ior is not None:
            prims.attribute(surface, "inputs:ior", "Float", look.ior)
        if look.coat > 0.0:
            prims.attribute(surface, "inputs:clearcoat", "Float", look.coat)
            prims.attribute(surface, "inputs:clearcoatRoughness", "Float", COAT_ROUGHNESS)
        prims.attribute(surface, "outputs:surface", "Token")
        output = prims.attribute(material, "outputs:surface", "Token")
        output.connectionPathList.explicitItems = [surface.path.AppendProperty("outputs:surface")]
        return material.path

    def _reader(self, material: Any, name: str, size: int, primvar: str) -> Any:
        """Return the output of a shader node that reads ``size`` numbers of the mesh at each point."""
        reader = self.prims.prim(material, name, "Shader")
        self.prims.attribute(reader, "info:id", "Token", f"UsdPrimvarReader_float{size}")
        self.prims.attribute(reader, "inputs:varname", "String", primvar)
        self.prims.attribute(reader, "outputs:result", f"Float{size}")
        return reader.path.AppendProperty("outputs:result")

    def _image(self, material: Any, texture: Texture, look: Look, *, is_relief: bool = False) -> Any:
        """Return the output of a shader node that reads the image of a texture, or the normals of its relief."""
        prims, names = self.prims, ("relief_coordinates", "relief") if is_relief else ("coordinates", "texture")
        coordinates = self._reader(material, names[0], 2, COORDINATES.removeprefix("primvars:"))
        image = prims.prim(material, names[1], "Shader")
        file = self.images.name_of(texture, is_relief)
        prims.attribute(image, "info:id", "Token", "UsdUVTexture")
        prims.attribute(image, "inputs:file", "Asset", prims.sdf.AssetPath(f"./{file}"))
        if is_relief:  # numbers from -1 to 1, not colors
            prims.attribute(image, "inputs:scale", "Float4", prims.gf.Vec4f(2.0, 2.0, 2.0, 1.0))
            prims.attribute(image, "inputs:bias", "Float4", prims.gf.Vec4f(-1.0, -1.0, -1.0, 0.0))
        else:
            prims.attribute(image, "inputs:fallback", "Float4", prims.gf.Vec4f(*look.color, 1.0))
        prims.attribute(image, "inputs:sourceColorSpace", "Token", "raw" if is_relief else "sRGB")
        for side in "ST":
            prims.attribute(image, f"inputs:wrap{side}", "Token", "clamp" if texture.side else "repeat")
        prims.attribute(image, "inputs:st", "Float2").connectionPathList.explicitItems = [coordinates]
        prims.attribute(image, "outputs:rgb", "Float3")
        return image.path.AppendProperty("outputs:rgb")


MAX_PRIMS = 1_000_000  # of a file
# copies in one place from which they are one PointInstancer by default. A prim for each copy can be selected, hidden
# and changed, which is worth more than size as long as programs stay fast: 100,000 cubes as prims take six times as
# long to write, twice the memory and three times the space.
INSTANCER_COPIES = 10_000
_MAX_LEVELS = 1_000  # levels: USD composes recursively


def write(job: Job, path: Path) -> None:
    """Write the plan to ``path``; raises SceneError("backend") without usd-core, LimitError for too many prims."""
    sdf = require("pxr.Sdf", INSTALL)
    layer = sdf.Layer.CreateAnonymous(".usda" if path.suffix.lower() == ".usda" else ".usdc")
    is_package = path.suffix.lower() == ".usdz"
    try:
        with tempfile.TemporaryDirectory() if is_package else nullcontext(path.parent) as folder:
            main = Path(folder) / (f"{path.stem}.usdc" if is_package else path.name)
            with sdf.ChangeBlock():
                _fill(layer, job, TextureFiles(main))
            job.progress(0.8)
            if not layer.Export(str(main)) or (is_package and not package(main, path)):
                raise _not_written(path)
    except require("pxr.Tf", INSTALL).ErrorException:  # which says neither why nor, as the file is temporary, which
        raise _not_written(path) from None


def _not_written(path: Path) -> OSError:
    """Return the error for a file that USD could not write."""
    return OSError(errno.EIO, "USD cannot write the file; the disk may be full", str(path))


def package(main: Path, path: Path) -> bool:
    """Write a .usdz file, an uncompressed archive of a USD file and its images; return whether that was possible."""
    utils, sdf = require("pxr.UsdUtils", INSTALL), require("pxr.Sdf", INSTALL)
    return bool(utils.CreateNewUsdzPackage(sdf.AssetPath(str(main)), str(path)))


def _fill(layer: Any, job: Job, images: TextureFiles) -> None:
    """Fill a layer with the scene: metadata, materials and the hierarchy."""
    plan = job.plan
    merged_entities = [item.entity for item in distinct(*plan.roots) if item.merged]
    prims = Prims(layer, job.solid)
    root = prims.prim(layer, PrimNames().fresh(plan.word), "Xform")
    root.SetInfo("kind", "component")
    root.SetInfo("apiSchemas", prims.sdf.TokenListOp.Create(prependedItems=["GeomModelAPI"]))
    layer.defaultPrim = root.name
    metadata: dict[str, Any] = {"upAxis": "Y", "metersPerUnit": 1.0, "timeCodesPerSecond": job.fps}
    if plan.animated:
        metadata |= {"framesPerSecond": job.fps, "startTimeCode": 0.0, "endTimeCode": float(len(plan.roots) - 1)}
    for name, value in metadata.items():
        layer.pseudoRoot.SetInfo(name, value)
    prims.hint_extent(root, plan.roots)
    materials = Materials(prims, prims.prim(root, "Materials", "Scope"), images)
    segments = merged_sides(job, merged_entities)
    least = INSTANCER_COPIES if job.instancing is None else job.instancing
    tree = _Tree(prims, materials, root, segments, fineness(job, plan.roots), least)
    tree.add_frames(matched(plan.roots)) if plan.animated else tree.add_root(plan)


@dataclass(slots=True)
class _Tree:
    """Adds the hierarchy below ``root``; ``repeated`` items become prototypes on first use.

    ``segments`` are the sides of full circles of merged meshes, ``fine`` those of an item. From ``least`` copies of an
    item in another one on, they are one PointInstancer; 0 for never.
    """

    prims: Prims
    materials: Materials
    root: Any
    segments: int
    fine: Fineness
    least: int = 0
    repeated: set[int] = field(default_factory=set)
    remaining: int = MAX_PRIMS
    _prototypes: Any = None
    _paths: dict[int, Any] = field(default_factory=dict)
    _names: dict[Any, PrimNames] = field(default_factory=dict)

    # --- static objects ---

    def add_root(self, plan: ExportPlan) -> None:
        """Add a static scene; the root prim is the root entity."""
        self._find_repeated(plan.roots)
        self._fill_prim(plan.roots[0], self.root)

    def _find_repeated(self, roots: Sequence[ExportItem]) -> None:
        """Record the items that occur in several places; duplicates in ``roots`` count."""
        visited: set[int] = set()
        for root in roots:
            self.repeated.add(id(root)) if id(root) in visited else visited.add(id(root))
        for item in distinct(*roots):
            for child, _ in item.parts:
                self.repeated.add(id(child)) if id(child) in visited else visited.add(id(child))

    def _fill_prim(self, item: ExportItem, prim: Any, level: int = 0) -> None:
        """Add the metadata, geometry and parts of ``item`` to ``prim``, and the prototypes they need."""
        waiting = [(item, prim, level)]
        while waiting:
            item, prim, level = waiting.pop()
            self._count_prim(level)
            self.prims.describe(prim, item)
            if item.is_leaf:
                self._geometry(item, prim)
            copied = self._instancer(item, prim, waiting)
            for position, (child, pose) in enumerate(item.parts):
                if position in copied:
                    continue
                child_prim = self._posed(prim, child, (pose,), has_order=id(child) in self.repeated)
                if id(child) in self.repeated:
                    self._refer_to(child_prim, child, waiting)
                else:
                    waiting.append((child, child_prim, level + 1))

    def _refer_to(self, prim: Any, item: ExportItem, waiting: list[tuple[ExportItem, Any, int]]) -> None:
        """Make a prim an instance of the prototype of a repeated item, which is filled later if it is new."""
        if id(item) not in self._paths:
            waiting.append((item, self._prototype(item), 1))
        self._refer(prim, item)

    def _instancer(self, item: ExportItem, prim: Any, waiting: list[tuple[ExportItem, Any, int]]) -> set[int]:
        """Add a PointInstancer for the frequent parts of an item; return their positions among the parts.

        Instances cannot be sheared, so sheared parts are not included. ``ids`` are the positions. Words and handles are
        in the attributes of the prototypes, because copies are instances only if they are the same entity.
        """
        rows: dict[int, list[int]] = {}
        for position, (child, _) in enumerate(item.parts if self.least else ()):
            rows.setdefault(id(child), []).append(position)
        frequent = [copies for copies in rows.values() if len(copies) >= self.least]
        if not frequent:
            return set()
        positions = np.array(sorted(position for copies in frequent for position in copies), np.int64)
        poses = np.array([item.parts[position][1] for position in positions.tolist()]).reshape(-1, 3, 4)
        plain = ~decompose(poses).shears
        positions, poses = positions[plain], poses[plain]
        numbers: dict[int, int] = {}
        children = [item.parts[position][0] for position in positions.tolist()]
        index = np.array([numbers.setdefault(id(child), len(numbers)) for child in children], np.int64)
        if not len(index):
            return set()
        instancer = self.prims.prim(prim, self._name(prim, "instances"), "PointInstancer")
        prototypes = []
        for child in {id(child): child for child in children}.values():
            prototypes.append(self.prims.prim(instancer, self._name(instancer, child.word), "Xform"))
            self._refer_to(prototypes[-1], child, waiting)
        offset = common_offset(poses[:, :, 3], size_of(child.entity for child in children))  # positions are float32
        if offset is not None:
            self.prims.place(instancer, (translation(offset),))
            poses = about(poses, offset)
        self.prims.instancer(instancer, [prototype.path for prototype in prototypes], index, poses, positions)
        self.prims.hint_instances(instancer, children, poses)
        return set(positions.tolist())

    def _count_prim(self, level: int) -> None:
        """Count a prim; raises LimitError for too many or too deeply nested ones."""
        self.remaining -= 1
        if self.remaining < 0 or level > _MAX_LEVELS:
            limit = (
                f"prims are nested deeper than the limit of {_MAX_LEVELS:,}"
                if level > _MAX_LEVELS
                else f"more than the limit of {MAX_PRIMS:,} prims"
            )
            raise LimitError(
                "primitives", f"the scene is too large for USD: {limit}", hint="merge parts with --depth N"
            )

    def _posed(self, parent: Any, item: ExportItem, poses: Sequence[Matrix], *, has_order: bool = False) -> Any:
        """Add a prim below ``parent`` with a pose, or one per frame; two nested ones for a pose with shear."""
        pair = unsheared(poses[0]) if len(set(poses)) == 1 else None
        if pair is not None:  # Blender's objects have no shear, but nested ones do
            parent = self.prims.prim(parent, self._name(parent, f"{item.word}_shear"), "Xform")
            self.prims.place(parent, pair[:1])
            poses = pair[1:]
        prim = self.prims.prim(parent, self._name(parent, item.word), "Xform")
        self.prims.place(prim, poses, has_order)
        return prim

    def _name(self, parent: Any, word: str) -> str:
        """Return a name for a child of ``parent`` that no sibling has."""
        if parent.path not in self._names:
            reserved = (
                {"Materials": 1, "Prototypes": 1, SHAPES: 1, "geometry": 1} if parent == self.root else {"geometry": 1}
            )
            self._names[parent.path] = PrimNames(reserved)
        return self._names[parent.path].fresh(word)

    def _prototype(self, item: ExportItem) -> Any:
        """Add the prim of a prototype."""
        if self._prototypes is None:
            self._prototypes = self.prims.prim(self.root, "Prototypes", "", abstract=True)
        prototype = self.prims.prim(self._prototypes, self._name(self._prototypes, item.word), "Xform")
        self.prims.attribute(prototype, "xformOp:transform", "Matrix4d", self.prims.matrix(IDENTITY))
        self.prims.order(prototype)
        self._paths[id(item)] = prototype.path
        return prototype

    def _refer(self, prim: Any, item: ExportItem) -> None:
        """Make a prim an instance of the prototype of an item."""
        reference = self.prims.sdf.Reference("", self._paths[id(item)])
        prim.referenceList.prependedItems = [reference]
        prim.instanceable = True

    def _geometry(self, item: ExportItem, prim: Any) -> None:
        """Add the shape or the meshes of a leaf."""
        if item.merged:
            for number, patch in enumerate(merged(item.entity, self.segments, self.fine.within(item)), start=1):
                name = "geometry" if number == 1 else f"geometry_{number}"
                mesh = self.prims.mesh(prim, name, patch.surface, patch.look)
                self.prims.place(mesh, (patch.pose,))
                self.materials.bind(mesh, patch.look, painted=True)
            return
        self._solid(item, prim, "geometry", None)

    def _solid(self, item: ExportItem, prim: Any, name: str, poses: Sequence[Matrix] | None) -> Any:
        """Add the geometry of a primitive with its solid's pose, or one per frame; return None if it is invisible."""
        solid = solid_of(item.entity)
        if solid is None:
            return None
        look = look_of(item.entity)
        if look.opacity == 0.0:
            return None
        if solid.form is not None:
            geometry = self.prims.shape(prim, name, solid, look, self.fine.of(item))
            self.materials.bind(geometry, look)
        else:
            surface = solid.surface(self.fine.of(item), look.texture)
            if surface is None:
                return None
            geometry = self.prims.mesh(prim, name, surface, look)
            self.materials.bind(geometry, look, painted=surface.colors is not None)
        self.prims.place(geometry, poses or (solid.pose,))
        return geometry

    # --- animated objects ---

    def add_frames(self, root: Moving) -> None:
        """Add the frames of a 4D scene; time code ``i`` is frame ``i``."""
        self._find_repeated(_fixed_items(root))
        waiting: list[tuple[Moving, Any, int]] = [(root, self.root, 0)]
        while waiting:
            moving, prim, level = waiting.pop()
            self._count_prim(level)
            if moving.fixed is not None:
                self._add_fixed(moving.fixed, prim, level)
                continue
            self.prims.describe(prim, moving.first)
            self._changing(moving, prim)
            for child in moving.children:
                child_prim = self._posed(prim, child.first, child.filled_poses())
                self.prims.show(child_prim, child.shown)
                waiting.append((child, child_prim, level + 1))

    def _add_fixed(self, item: ExportItem, prim: Any, level: int) -> None:
        """Add an item that never changes, whose prim may move."""
        if id(item) not in self.repeated:
            self._fill_prim(item, prim, level)
            return
        waiting: list[tuple[ExportItem, Any, int]] = []
        self._refer_to(prim, item, waiting)
        for waiting_item in waiting:
            self._fill_prim(*waiting_item)

    def _changing(self, moving: Moving, prim: Any) -> None:
        """Add the geometry of a leaf whose look or shape changes: one prim for each variant, visible in its frames."""
        for item, shown in variants(moving):
            name = self._name(prim, "geometry")
            if item.merged:
                holder = self.prims.prim(prim, name, "Xform")
                self._geometry(item, holder)
                self.prims.show(holder, _hidden_or_shown(shown, moving))
                continue
            geometry = self._solid(item, prim, name, _solid_poses(moving, item, shown))
            if geometry is not None:
                self.prims.show(geometry, _hidden_or_shown(shown, moving))


def _hidden_or_shown(shown: Sequence[bool], moving: Moving) -> tuple[bool, ...]:
    """Return ``shown``, but True in the frames in which the whole object is hidden anyway."""
    return tuple(is_shown or not is_there for is_shown, is_there in zip(shown, moving.shown, strict=True))


def _solid_poses(moving: Moving, item: ExportItem, shown: Sequence[bool]) -> tuple[Matrix, ...]:
    """Return the poses of a leaf's solid in every frame; frames without it repeat the previous pose."""
    solid = None if item.merged else solid_of(item.entity)
    current = IDENTITY if solid is None else solid.pose
    poses = []
    for other, is_shown in zip(moving.items, shown, strict=True):
        if is_shown and other is not None:
            solid = solid_of(other.entity)
            current = current if solid is None else solid.pose
        poses.append(current)
    return tuple(poses)


def _fixed_items(root: Moving) -> list[ExportItem]:
    """Return the items that never change, once for each occurrence."""
    fixed, waiting = [], [root]
    while waiting:
        moving = waiting.pop()
        if moving.fixed is not None:
            fixed.append(moving.fixed)
        waiting.extend(moving.children)
    return fixed


PLAIN_USD = mesh_backend(
    "usd",
    "OpenUSD with instanceable prototypes, materials, textures, words and 4D time samples",
    (".usd", ".usda", ".usdc", ".usdz"),
    write,
    animated=True,
    options=(INSTANCING, SIDES, TOLERANCE, FPS),
    packages=("pxr",),
    install=INSTALL,
    unit="meter",
)
PHYSICS = Option("physics", "add rigid bodies, colliders and masses (UsdPhysics) of one frame", False)


def _run(scene: Scene, path: Path, options: BackendOptions) -> Sequence[Path]:
    """Write a USD file, with rigid bodies for ``--physics``."""
    check_settings(options, [USD])
    settings = {name: value for name, value in options.settings.items() if name != PHYSICS.name}
    plain = replace(options, settings=settings)
    if not USD.setting(options, PHYSICS.name):
        return PLAIN_USD.run(scene, path, plain) or [path]
    if any(settings.get(name) for name in ("parts", "solid", "section")) or settings.get("depth") is not None:
        message = "`--physics` needs the parts as they are: leave out `--parts`, `--depth`, `--section` and `--solid`"
        raise SceneError("value", message)
    written: Sequence[Path] = SERVICES.find("usd-physics")(scene, path, plain)
    return written


USD = replace(PLAIN_USD, run=_run, options=(*PLAIN_USD.options, PHYSICS))
