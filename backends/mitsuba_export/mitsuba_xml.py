"""Export to Mitsuba 3 XML, with meshes in separate .ply files, in world coordinates.

Camera, lighting, ground and materials are those of final images. Primitives are instances of exact unit shapes, which
are correct under any pose; beyond ``--instance-limit`` repeated parts are instances of merged meshes. Mitsuba supports
no emitters and no singular poses in instances: these become meshes in world coordinates, one for each material.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any
from xml.sax.saxutils import quoteattr  # writes only  # nosec B406

import numpy as np
import numpy.typing as npt

from scenelang.backends.base import BackendOptions, require
from scenelang.backends.exports.export import INSTANCES, Job, leaves, mesh_backend, unsupported_frames
from scenelang.backends.exports.mesh_files import write_ply
from scenelang.backends.exports.plan import (
    WHITE,
    ExportItem,
    ExportPlan,
    ExportSurface,
    Patch,
    Solid,
    cut_below,
    deepened,
    distinct,
    joined,
    merged,
    segments_for,
    solid_of,
    unit_surface,
)
from scenelang.backends.pictures.draft import toned
from scenelang.backends.pictures.film import FINAL_EXTRA, PictureOptions
from scenelang.backends.pictures.mitsuba import MITSUBA, use
from scenelang.backends.pictures.mitsuba_materials import Lobe, bitmap_paint, relief
from scenelang.backends.pictures.mitsuba_materials import surface as bsdf_of
from scenelang.backends.pictures.mitsuba_scene import (
    UNIT_SEGMENTS,
    dissolves,
    is_instantiable,
    surroundings,
    unit_parts,
)
from scenelang.backends.pictures.stage import Staging, box_of, staging_of, still, unit_size
from scenelang.backends.pictures.surroundings import settled
from scenelang.backends.surfaces.appearance import Look, look_of
from scenelang.backends.surfaces.solids import solids_of
from scenelang.grammar.datum import dataclass, field, replace
from scenelang.grammar.diagnostics import printable
from scenelang.interpreter.scene import pose
from scenelang.interpreter.scene.entity import Entity, Scene, primitive_count
from scenelang.interpreter.scene.flatten import flatten_entity
from scenelang.interpreter.scene.primitives.forms import CanonicalForm
from scenelang.interpreter.values.values import ANONYMOUS, IDENTITY, Matrix

# Mitsuba's scene dictionaries as XML elements.


_TAGS = {
    "path": "integrator",
    "perspective": "sensor",
    "thinlens": "sensor",
    "orthographic": "sensor",
    "hdrfilm": "film",
    "multijitter": "sampler",
    "box": "rfilter",
    "constant": "emitter",
    "directional": "emitter",
    "point": "emitter",
    "spot": "emitter",
    "area": "emitter",
    "diffuse": "bsdf",
    "twosided": "bsdf",
    "principled": "bsdf",
    "roughplastic": "bsdf",
    "roughconductor": "bsdf",
    "roughdielectric": "bsdf",
    "blendbsdf": "bsdf",
    "envmap": "emitter",
    "srgb": "texture",
    "bitmap": "texture",
    "mask": "bsdf",
    "bumpmap": "bsdf",
    "mesh_attribute": "texture",
    "checkerboard": "texture",
}  # all others are shapes


def _quoted(text: str) -> str:
    """Quote an attribute value; XML cannot represent control characters, even escaped."""
    return quoteattr(printable(text))


def elements(name: str | None, value: Any, indent: str = "  ") -> list[str]:
    """Return the lines of the property ``name``.

    ``value`` is a plugin (a mapping with a "type"), a transform (a matrix) or a plain value. The key "id" of a plugin
    names it, and a value ``{"ref": id}`` refers to it.
    """
    named = "" if name is None else f" name={_quoted(name)}"
    if isinstance(value, Mapping):
        return _plugin(named, value, indent)
    if isinstance(value, np.ndarray):
        matrix = " ".join(f"{number:.17g}" for number in value.ravel().tolist())
        return [f'{indent}<transform{named}><matrix value="{matrix}"/></transform>']
    if isinstance(value, bool):
        return [f'{indent}<boolean{named} value="{str(value).lower()}"/>']
    if isinstance(value, int):
        return [f'{indent}<integer{named} value="{value}"/>']
    if isinstance(value, float):
        return [f'{indent}<float{named} value="{value:.9g}"/>']
    if isinstance(value, str):
        return [f"{indent}<string{named} value={_quoted(value)}/>"]
    return [f'{indent}<point{named} value="{_numbers(value)}"/>']


def _plugin(named: str, value: Mapping[str, Any], indent: str) -> list[str]:
    """Return the lines of a plugin, a reference or a color; ``named`` is its name attribute."""
    if "ref" in value:
        return [f"{indent}<ref id={_quoted(value['ref'])}/>"]
    if value["type"] == "rgb":
        return [f'{indent}<rgb{named} value="{_numbers(value["value"])}"/>']
    tag = _TAGS.get(value["type"], "shape")
    label = f" id={_quoted(value['id'])}" if "id" in value else named if tag == "texture" else ""
    lines = [f'{indent}<{tag} type="{value["type"]}"{label}>']
    for key, item in value.items():
        if key not in ("type", "id"):
            lines += elements(key, item, indent + "  ")
    return [*lines, f"{indent}</{tag}>"]


def _numbers(values: Sequence[float]) -> str:
    """Return numbers as an attribute value."""
    return " ".join(f"{float(number):.9g}" for number in values)


_PROPERTIES = ("x", "y", "z", "nx", "ny", "nz", "r", "g", "b")


def write(job: Job, path: Path) -> None:
    """Write the first frame of the plan to ``path``; raises SceneError and LimitError."""

    unsupported_frames(job.plan.roots, ".xml")
    require("mitsuba", FINAL_EXTRA)
    plan = cut_below(job.plan, job.instances)
    merged_entities = [item.entity for item in distinct(*plan.roots) if item.merged]
    shapes = _Shapes(path, segments_for(merged_entities, "the merged meshes"))
    with path.open("w", encoding="utf-8", newline="\n") as file:
        file.write('<?xml version="1.0" encoding="utf-8"?>\n<!-- scenelang: y up, linear sRGB -->\n')
        file.write('<scene version="3.0.0">\n')
        file.writelines(line + "\n" for line in stage_elements(plan, path))
        file.writelines(line + "\n" for line in shapes.lines(plan))
        file.write("</scene>\n")


@dataclass(slots=True)
class _Shapes:
    """Writes the shapes of a scene and their meshes; stores the groups that instances refer to."""

    path: Path
    segments: int
    meshes: int = 0
    images: dict[bytes, str] = field(default_factory=dict)
    groups: dict[Hashable, str | None] = field(default_factory=dict)
    patches: dict[int, tuple[list[Patch], list[Patch]]] = field(default_factory=dict)
    loose: dict[Look, list[ExportSurface]] = field(default_factory=dict)

    def lines(self, plan: ExportPlan) -> Iterator[str]:
        """Yield the elements of all leaves in depth-first order; those that cannot be instances come last."""
        for leaf in leaves(plan, 2**40):
            new_groups: list[str] = []
            instance = self._placed(leaf.item, leaf.pose, new_groups)
            yield from new_groups
            if instance is not None:
                group, local = instance
                matrix = np.vstack([np.array(local).reshape(3, 4), [0.0, 0.0, 0.0, 1.0]])
                yield from elements(None, {"type": "instance", "group": {"ref": group}, "to_world": matrix})
        for look, surfaces in self.loose.items():
            yield from elements(None, self._mesh(Patch(look, joined(surfaces))))

    def _placed(self, item: ExportItem, place: Matrix, new_groups: list[str]) -> tuple[str, Matrix] | None:
        """Return the group and pose of a leaf; None if it is invisible or not an instance.

        Appends the elements of new groups to ``new_groups``.
        """
        if item.merged:
            instanced, emitters = self._merged(item)
            self._add_loose([replace(patch, look=_deeper(patch.look, place)) for patch in emitters], place)
            if _is_flat(place):
                self._add_loose(instanced, place)
                return None
            if id(item.entity) not in self.groups:
                self._add_group(id(item.entity), [self._mesh(patch) for patch in instanced], new_groups)
            group = self.groups[id(item.entity)]
            return None if group is None else (group, place)
        look, solid = look_of(item.entity), solid_of(item.entity)
        if solid is None or look.opacity == 0.0:
            return None
        solid_pose = pose.compose(place, solid.pose)
        if (
            not is_instantiable(look)
            or _is_flat(solid_pose)
            or (solid.form is not None and _dissolves(solid.form, solid_pose))
        ):
            surface = _shown(solid, look)
            self._add_loose([] if surface is None else [Patch(_deeper(look, place), surface)], solid_pose)
            return None
        key = solid.key_with(look)
        if key not in self.groups:
            if solid.form is None or look.texture is not None:
                parts = self._own(solid, look)
            else:
                parts = self._unit(solid.form, solid.ratios, look)
            self._add_group(key, parts, new_groups)
        group = self.groups[key]
        return None if group is None else (group, solid_pose)

    def _merged(self, item: ExportItem) -> tuple[list[Patch], list[Patch]]:
        """Return the patches of a merged item: those that can be instances, and the others."""
        if id(item.entity) not in self.patches:
            patches = merged(item.entity, self.segments, by_depth=True)
            instanced = [patch for patch in patches if is_instantiable(patch.look)]
            self.patches[id(item.entity)] = instanced, [patch for patch in patches if not is_instantiable(patch.look)]
        return self.patches[id(item.entity)]

    def _own(self, solid: Solid, look: Look) -> list[dict[str, Any]]:
        """Return the mesh of a primitive that is not a canonical solid, or has a texture."""
        surface = _shown(solid, look)
        return [] if surface is None else [self._mesh(Patch(look, surface))]

    def _add_loose(self, patches: list[Patch], place: Matrix) -> None:
        """Add patches to the meshes in world coordinates."""
        for patch in patches:
            copy = patch.surface.under(np.array(pose.compose(place, patch.pose)).reshape(1, 3, 4))
            if patch.look.texture is not None:
                self.loose.setdefault(replace(patch.look, color=WHITE), []).append(copy)
                continue
            colors = np.ones_like(copy.vertices) if copy.colors is None else copy.colors
            painted = replace(copy, colors=colors * np.array(patch.look.color))
            self.loose.setdefault(replace(patch.look, color=WHITE), []).append(painted)

    def _add_group(self, key: Hashable, parts: list[dict[str, Any]], new_groups: list[str]) -> None:
        """Add a group of shapes unless it would be empty; appends its element to ``new_groups``."""
        name = f"group{len(self.groups) + 1}" if parts else None
        self.groups[key] = name
        if parts:
            shapes = {f"part{k}": part for k, part in enumerate(parts)}
            new_groups += elements(None, {"type": "shapegroup", "id": name, **shapes})

    def _unit(self, form: CanonicalForm, ratios: tuple[float, ...], look: Look) -> list[dict[str, Any]]:
        """Return the shapes of a canonical form, exact if Mitsuba has such shapes."""
        parts = [part | {"bsdf": bsdf_of(look)} for part in unit_parts(form, ratios, look)]
        return parts or [self._mesh(Patch(look, unit_surface(form, ratios, UNIT_SEGMENTS)))]

    def _mesh(self, patch: Patch) -> dict[str, Any]:
        """Write a .ply file next to the scene and return the shape that refers to it."""
        self.meshes += 1
        file = self.path.with_name(f"{self.path.stem}-mesh{self.meshes:03d}.ply")
        surface = patch.surface
        colors = np.ones_like(surface.vertices) if surface.colors is None else surface.colors
        lobes = [np.asarray(colors * np.array(patch.look.color), np.float64)]

        def paint(lobe: Lobe) -> dict[str, Any]:
            """Return the texture of a lobe, which becomes an attribute of the mesh's vertices."""
            values = lobe(lobes[0])
            if values is lobes[0]:
                return {"type": "mesh_attribute", "name": "vertex_color"}
            lobes.append(values)
            return {"type": "mesh_attribute", "name": f"vertex_lobe{len(lobes) - 1}_color"}

        texture, look = patch.look.texture, replace(patch.look, color=WHITE)
        if texture is None:
            painted = bsdf_of(look, paint)
        else:
            painted = bsdf_of(
                look, bitmap_paint(texture, self._image), bump=relief(texture, texture.depth, self._image)
            )
        _write_ply(file, surface, lobes)
        shape: dict[str, Any] = {"type": "ply", "filename": file.name, "bsdf": painted}
        if patch.pose != IDENTITY:
            shape["to_world"] = np.vstack([np.array(patch.pose).reshape(3, 4), [0.0, 0.0, 0.0, 1.0]])
        if any(patch.look.emission):
            shape["emitter"] = {"type": "area", "radiance": {"type": "rgb", "value": patch.look.emission}}
        return shape

    def _image(self, values: npt.NDArray[np.float32]) -> dict[str, Any]:
        """Return the file of an image (H, W, 3) beside the scene, written once."""
        key = values.tobytes()
        if key not in self.images:
            self.images[key] = f"{self.path.stem}-image{len(self.images) + 1:03d}.exr"
            require("mitsuba", FINAL_EXTRA).Bitmap(values).write(str(self.path.with_name(self.images[key])))
        return {"filename": self.images[key]}


def _deeper(look: Look, place: Matrix) -> Look:
    """Return a look whose relief has the depth that it has under the pose ``place``."""
    return next(deepened(look, np.array(place, np.float64).reshape(1, 3, 4)))[0]


def _shown(solid: Solid, look: Look) -> ExportSurface | None:
    """Return the surface of a primitive, with coordinates in the texture of its look."""
    surface = solid.surface()
    return surface if surface is None or look.texture is None else surface.textured(look.texture, solid.pose)


def _write_ply(file: Path, surface: ExportSurface, lobes: Sequence[npt.NDArray[np.float64]]) -> None:
    """Write a mesh with the linear colors of its vertices, and those (V, 3) of further lobes of its material."""
    columns = [surface.vertices, surface.normals, *lobes]
    names = [*_PROPERTIES, *(f"lobe{k}_{channel}" for k in range(1, len(lobes)) for channel in "rgb")]
    if surface.uv is not None:
        columns.append(surface.uv)
        names += ["u", "v"]
    rows = np.ascontiguousarray(np.concatenate(columns, axis=1), "<f4").view(np.dtype([("row", "<f4", len(names))]))
    write_ply(file, tuple(("float", name) for name in names), [rows.reshape(-1)], [surface.faces])


def _is_flat(place: Matrix) -> bool:
    """Return whether the pose is singular in single precision."""
    linear = np.array(place).reshape(3, 4)[:, :3]
    largest = float(np.abs(linear).max())
    return largest == 0.0 or abs(float(np.linalg.det(linear / largest))) < 1e-9


def _dissolves(form: CanonicalForm, place: Matrix) -> bool:
    """Return whether rays miss a form under a pose, because it is too thin for single precision."""
    return dissolves(form, np.array(place).reshape(3, 4))


MITSUBA_XML = mesh_backend(
    "mitsuba-xml",
    "Mitsuba 3 XML with separate mesh files: the scene of final pictures",
    (".xml",),
    write,
    options=(INSTANCES,),
    packages=("mitsuba",),
    install=FINAL_EXTRA,
)


# Camera, lighting and ground of final images, transformed from the stage's unit frame to world coordinates.


FloatArray = npt.NDArray[np.float64]

_WIDTH, _HEIGHT = 800, 600
_MAX_PROBED = 200_000  # primitives of a scene for which the tone of the backdrop is chosen, as in images


def stage_elements(plan: ExportPlan, path: Path) -> list[str]:
    """Return the lines of integrator, sensor, emitters and ground for a plan of one frame.

    Writes the image of the surroundings beside ``path``.
    """
    scene = Scene(plan.word, [plan.roots[0].entity], False, (), plan.setup)
    options = settled(scene, PictureOptions(width=_WIDTH, height=_HEIGHT, stated=()))
    mi = use("scalar", 0, False)
    center, scale = unit_size(scene)
    nothing = solids_of(flatten_entity(Entity(plan.word, ANONYMOUS, ())))
    roots, lowest = {0: scene.root}, float(box_of(scene)[0][1])
    shot = still(scene, options.camera, None, options.width, options.height)
    staging = Staging(roots, roots, None, {0: nothing}, lowest, center, scale, options.environment, options.ground,
                      options.lighting)  # fmt: skip
    if primitive_count(scene.root) <= _MAX_PROBED:
        drawn = staging_of(scene, [0], _MAX_PROBED, options.environment, options.ground, lighting=options.lighting)
        staging = replace(staging, backdrop=toned(drawn, shot).backdrop)
    stage = staging.stage(shot)
    outward = np.diag([1.0 / scale] * 3 + [1.0])
    outward[:3, 3] = center
    lines: list[str] = []
    for key, value in surroundings(mi, stage, MITSUBA.setting(BackendOptions(), "bounces")).items():
        if key == "around":
            file = path.with_name(f"{path.stem}-sky.exr")
            value["bitmap"].write(str(file))
            lines += elements(None, {"type": "envmap", "filename": file.name})
        elif key != "type":
            lines += elements(None, _in_world(value, outward, scale))
    return lines


def _in_world(value: Mapping[str, Any], outward: FloatArray, scale: float) -> dict[str, Any]:
    """Return a plugin with its poses and distances in world units."""
    out: dict[str, Any] = {}
    is_camera = "film" in value
    for key, item in value.items():
        if key == "to_world":
            pose = outward @ np.array(item.matrix, np.float64).reshape(4, 4)
            if is_camera and value["type"] != "orthographic":
                pose[:3, :3] *= scale  # a camera's pose must not contain scale
            if value["type"] in ("directional", "spot"):  # nor must that of a light without extent
                pose[:3, :3] = np.array(item.matrix, np.float64).reshape(4, 4)[:3, :3]
            out[key] = pose
        elif hasattr(item, "matrix"):
            out[key] = np.array(item.matrix, np.float64)
        elif key in ("near_clip", "far_clip", "aperture_radius", "focus_distance"):
            out[key] = item / scale
        elif key == "position":
            out[key] = (outward @ np.array([*item, 1.0]))[:3].tolist()
        elif key == "intensity":  # radiant intensity, whose light falls with the square of the distance
            out[key] = {**item, "value": [channel / scale**2 for channel in item["value"]]}
        elif key in ("cutoff_angle", "beam_width"):
            out[key] = float(item)
        elif key == "sampler":
            out[key] = dict(item) | {"sample_count": MITSUBA.setting(BackendOptions(), "samples")}
        else:
            out[key] = item
    return out
