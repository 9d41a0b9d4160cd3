"""Export to a Blender script: words are the names of objects, and equal entities share one mesh.

The script needs Blender 4 or newer and nothing else. Its objects are in the scene's axes, below one that turns y up to
z up. A pose that shears is a parent inverse, because objects have location, rotation and scale only.
"""

from __future__ import annotations

import keyword
import re
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt

from scenelang.backends.base import Accepts, Backend, BackendOptions, Option, Work, check_settings, frame_of
from scenelang.backends.files import write_text
from scenelang.backends.surfaces.appearance import Look, check_seen, look_of
from scenelang.backends.surfaces.solids import own_mesh
from scenelang.grammar.diagnostics import LimitError, SceneError
from scenelang.interpreter.scene.entity import Entity, Scene, descendants
from scenelang.interpreter.scene.primitives import Primitive
from scenelang.interpreter.values.values import Matrix

FloatArray = npt.NDArray[np.float64]
_MAX_NUMBERS = 6_000_000  # of a script

_HEAD = '''"""{title}, written by `scenelang export`."""

import math

import bmesh
import bpy
from mathutils import Matrix

SEGMENTS = {segments}  # sides of round objects


def material(name, color, roughness=None, metallic=0.0, emission=None, opacity=1.0, ior=None):
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    made.diffuse_color = (*color, opacity)
    inputs = made.node_tree.nodes["Principled BSDF"].inputs
    inputs["Base Color"].default_value = (*color, 1.0)
    inputs["Roughness"].default_value = 1.0 if roughness is None else roughness
    inputs["Metallic"].default_value = metallic
    if ior is not None:
        inputs["IOR"].default_value = ior
        inputs["Transmission Weight"].default_value = 1.0 - opacity
    else:
        inputs["Alpha"].default_value = opacity
    if emission is not None:
        inputs["Emission Color"].default_value = (*emission, 1.0)
        inputs["Emission Strength"].default_value = 1.0
    return made


def finished(bm, name, look, smooth=True):
    mesh = bpy.data.meshes.new(name)
    bm.to_mesh(mesh)
    bm.free()
    if smooth:
        mesh.shade_smooth()
    mesh.materials.append(look)
    return mesh


def box(name, look, sizes):
    bm = bmesh.new()
    bmesh.ops.create_cube(bm, size=1.0, matrix=Matrix.Diagonal((*sizes, 1.0)))
    return finished(bm, name, look, smooth=False)


def ball(name, look, radius):
    bm = bmesh.new()
    bmesh.ops.create_uvsphere(bm, u_segments=SEGMENTS, v_segments=SEGMENTS // 2, radius=radius)
    return finished(bm, name, look)


def cone(name, look, radius, top, height, pose):
    bm = bmesh.new()
    bmesh.ops.create_cone(
        bm, cap_ends=True, segments=SEGMENTS, radius1=radius, radius2=top, depth=height, matrix=Matrix(pose)
    )
    return finished(bm, name, look)


def torus(name, look, radius, tube):
    count, turn = SEGMENTS // 2, 2 * math.pi
    points = [
        ((radius + tube * math.cos(b)) * math.cos(a), tube * math.sin(b), (radius + tube * math.cos(b)) * math.sin(a))
        for a in (turn * i / SEGMENTS for i in range(SEGMENTS))
        for b in (turn * j / count for j in range(count))
    ]
    at = lambda i, j: i % SEGMENTS * count + j % count
    faces = [(at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)) for i in range(SEGMENTS) for j in range(count)]
    mesh = solid(name, look, points, faces)
    mesh.shade_smooth()
    return mesh


def solid(name, look, points, faces):
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(points, [], faces)
    mesh.materials.append(look)
    return mesh


def place(name, data, parent, pose, shears=False):
    made = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(made)
    made.parent = parent
    if shears:
        made.matrix_parent_inverse = Matrix(pose)
    else:
        made.matrix_basis = Matrix(pose)
    return made


for old in list(bpy.data.objects):
    bpy.data.objects.remove(old)
'''


def _write(scene: Scene, path: Path, options: BackendOptions) -> None:
    check_settings(options, [BPY])
    check_seen(scene)
    root = scene.frames[frame_of(scene, options.frame)]
    write_text(path, _Script(BPY.setting(options, "segments")).text(root))


class _Script:
    """Writes the script of a scene."""

    def __init__(self, segments: int) -> None:
        self._segments = segments
        self._names: set[str] = {"SEGMENTS", *re.findall(r"^def (\w+)", _HEAD, re.M), "bpy", "bmesh", "math", "old"}
        self._materials: dict[Look, str] = {}
        self._meshes: dict[tuple[object, str], str] = {}
        self._functions: dict[int, str] = {}
        self._count = 0

    def text(self, root: Entity) -> str:
        """Return the script."""
        materials: list[str] = []
        meshes: list[str] = []
        functions: list[str] = []
        for entity in descendants(root):
            if not entity.is_primitive:
                functions.append(self._function(entity, materials, meshes))
        if root.is_primitive:
            functions.append(self._function(Entity(root.word, root.embedding, ()), materials, meshes))
        top = 'up = place("scene", None, None, Matrix.Rotation(math.pi / 2, 4, "X"))'
        call = f"{self._functions[id(root)]}(up, Matrix.Identity(4))"
        head = _HEAD.replace("{title}", root.word.replace("\\", "").replace('"', "'")).replace(
            "{segments}", str(self._segments)
        )
        parts = [head, "\n".join(materials), "\n".join(meshes), *functions, f"{top}\n{call}"]
        return "\n\n".join(part for part in parts if part) + "\n"

    def _function(self, entity: Entity, materials: list[str], meshes: list[str]) -> str:
        """Return the function that places an entity; one with a single primitive is one object."""
        name = self._functions[id(entity)] = self._free(entity.word)
        parts = [(pair.car, np.array(_rows(pair.cdr))) for pair in entity.children]
        parts = [(part, pose) for part, pose in parts if not part.is_primitive or self._is_visible(part)]
        lines = [f"def {name}(parent, pose, shears=False):"]
        single = parts[0] if len(parts) == 1 and parts[0][0].is_primitive else None
        if single is not None and np.allclose(single[1], np.eye(4)):
            mesh = self._mesh(single[0], entity.word, materials, meshes)
            return "\n".join([*lines, f"    place({_text(entity.word)}, {mesh}, parent, pose, shears)"])
        lines.append(f"    own = place({_text(entity.word)}, None, parent, pose, shears)")
        for part, pose in parts:
            matrix = f"{_matrix_text(pose)}{', True' if _shears(pose) else ''}"
            if part.is_primitive:
                mesh = self._mesh(part, part.word, materials, meshes)
                lines.append(f"    place({_text(part.word)}, {mesh}, own, {matrix})")
            else:
                lines.append(f"    {self._functions[id(part)]}(own, {matrix})")
        return "\n".join(lines)

    def _is_visible(self, entity: Entity) -> bool:
        return entity.shape is not None and entity.shape.has_geometry and look_of(entity).opacity > 0.0

    def _mesh(self, entity: Entity, name: str, materials: list[str], meshes: list[str]) -> str:
        """Return the variable of the mesh of a primitive, which equal primitives share."""
        shape = entity.shape
        if shape is None or not self._is_visible(entity):
            return "None"
        look = look_of(entity)
        key = (shape.key, look), ""
        if key not in self._meshes:
            variable = self._meshes[key] = self._free(f"{name} mesh")
            meshes.append(f"{variable} = {self._mesh_text(entity, shape, name, self._look(look, name, materials))}")
        return self._meshes[key]

    def _look(self, look: Look, name: str, materials: list[str]) -> str:
        if look not in self._materials:
            variable = self._materials[look] = self._free(f"{name} look")
            values = [_text(name), _tuple(look.color)]
            if look.roughness is not None or look.metallic or look.ior is not None:
                values.append(f"roughness={look.gloss:.9g}")
            values += [f"metallic={look.metallic:.9g}"] if look.metallic else []
            values += [f"emission={_tuple(look.emission)}"] if any(look.emission) else []
            values += [f"opacity={look.opacity:.9g}"] if look.opacity < 1 else []
            values += [f"ior={look.ior:.9g}"] if look.ior is not None else []
            materials.append(f"{variable} = material({', '.join(values)})")
        return self._materials[look]

    def _mesh_text(self, entity: Entity, shape: Primitive, name: str, look: str) -> str:
        given = f"{_text(name)}, {look}"
        word = type(shape).__name__
        if word in ("Cube", "Semantic"):
            return f"box({given}, {_tuple(shape.size)})"  # type: ignore[attr-defined]
        if word == "Sphere":
            return f"ball({given}, {shape.radius:.9g})"  # type: ignore[attr-defined]
        if word in ("Cylinder", "Cone"):
            p0, p1 = (np.array(point, np.float64) for point in (shape.p0, shape.p1))  # type: ignore[attr-defined]
            radius: float = shape.radius  # type: ignore[attr-defined]
            height = float(np.linalg.norm(p1 - p0))
            if height > 0:
                top = radius if word == "Cylinder" else 0.0
                return f"cone({given}, {radius:.9g}, {top:.9g}, {height:.9g}, {_rows_text(_along(p0, p1))})"
        if word == "Torus":
            return f"torus({given}, {shape.radius:.9g}, {shape.tube:.9g})"  # type: ignore[attr-defined]
        points, faces = self._triangles(shape)
        self._count += points.size + 3 * len(faces)
        if self._count > _MAX_NUMBERS:
            hint = "give a smaller --segments, or export to .glb, which Blender imports"
            raise LimitError("size", f'"{entity.word}" has too many vertices for a script', hint=hint)
        rows = ", ".join(_tuple(point) for point in points)
        return f"solid({given}, [{rows}], [{', '.join(_numbers(face) for face in faces)}])"

    def _triangles(self, shape: Primitive) -> tuple[FloatArray, Sequence[Sequence[int]]]:
        """Return the surface of a primitive as triangles, whose corners are shared."""
        placed = shape.placed()
        if placed is not None:
            mesh = placed.form.mesh(self._segments, placed.ratios)
            points = mesh.vertices @ placed.matrix[:, :3].T + placed.matrix[:, 3]
            flips = np.linalg.det(placed.matrix[:, :3]) < 0
        else:
            own = own_mesh(shape)
            if own is None:
                raise SceneError("unsupported", f"`{shape.word}` has no surface that a script can contain")
            mesh, points, flips = own, own.vertices, False
        distinct, place = np.unique(np.round(points, 9), axis=0, return_inverse=True)
        faces = place.reshape(-1)[mesh.faces]
        faces = faces[(faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 2] != faces[:, 0])]
        return distinct, (faces[:, ::-1] if flips else faces).tolist()

    def _free(self, name: str) -> str:
        stem = re.sub(r"\W+", "_", name.lower(), flags=re.ASCII).strip("_") or "part"
        stem = f"_{stem}" if stem[0].isdigit() or keyword.iskeyword(stem) else stem
        unique = next(n for n in (stem, *(f"{stem}_{i}" for i in range(2, 1_000_000))) if n not in self._names)
        self._names.add(unique)
        return unique


def _rows(pose: Matrix) -> FloatArray:
    made = np.eye(4)
    made[:3] = np.array(list(pose), np.float64)[:12].reshape(3, 4)
    return made


def _along(p0: FloatArray, p1: FloatArray) -> FloatArray:
    """Return the pose that turns z to the axis of a cylinder, about its middle."""
    axis = (p1 - p0) / np.linalg.norm(p1 - p0)
    helper = np.array([1.0, 0.0, 0.0]) if abs(axis[0]) < 0.9 else np.array([0.0, 1.0, 0.0])
    across = np.cross(axis, helper)
    across /= np.linalg.norm(across)
    made = np.eye(4)
    made[:3, 0], made[:3, 1], made[:3, 2] = across, np.cross(axis, across), axis
    made[:3, 3] = (p0 + p1) / 2
    return made


def _shears(pose: FloatArray) -> bool:
    products = pose[:3, :3].T @ pose[:3, :3]
    return bool(np.abs(products - np.diag(np.diag(products))).max() > 1e-9 * max(1e-30, float(np.abs(products).max())))


def _number(value: float) -> str:
    text = f"{float(value):.9g}"
    return "0" if text == "-0" or abs(float(value)) < 1e-15 else text


def _tuple(values: Iterable[float]) -> str:
    return f"({', '.join(_number(value) for value in values)})"


def _numbers(values: Iterable[int]) -> str:
    return f"({', '.join(map(str, values))})"


def _rows_text(pose: FloatArray) -> str:
    return f"({', '.join(_tuple(row) for row in pose)})"


def _matrix_text(pose: FloatArray) -> str:
    if np.allclose(pose[:3, :3], np.eye(3)):
        return f"Matrix.Translation({_tuple(pose[:3, 3])})"
    return _rows_text(pose)


def _text(word: str) -> str:
    return '"' + word.replace("\\", "\\\\").replace('"', '\\"').replace("\n", " ") + '"'


BPY = Backend(
    "bpy",
    "a script that builds the scene in Blender, with words as names and shared meshes",
    Work.EXPORT,
    (".py",),
    _write,
    (Option("segments", "sides of round objects", 64, minimum=8, maximum=1024),),
    Accepts(animated=False),
)
