"""Exports of bodies: MJCF for MuJoCo, and URDF.

MJCF is the model that `check --physics` simulates. URDF has one root link, the world, to which every body is joined,
fixed ones by a fixed joint and others by a floating one; it has no capsules and ellipsoids, which become a cylinder
between two spheres, and meshes. Both have z up, meters, and the masses and inertias of the scene.
"""

from __future__ import annotations

import html
import math
import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any
from xml.sax.saxutils import quoteattr  # writes only  # nosec B406

import numpy as np

from scenelang.backends.base import Accepts, Backend, BackendOptions, Option, Work, check_settings, frame_of
from scenelang.backends.files import atomic_write_all, write_text
from scenelang.backends.physics.colliders import INSTALL, SEGMENTS, Collider, FloatArray
from scenelang.backends.physics.dynamics import (
    MIN_TENSOR,
    TO_MODEL,
    check_weight,
    color_of,
    compiled,
    model_of,
    names_of,
)
from scenelang.backends.physics.grouping import BodySet, RigidBody, bodies_of
from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.scene.entity import Scene
from scenelang.interpreter.scene.primitives.sphere import BALL

# larger numbers get 15 digits instead of 9, so that bodies far from the origin keep their positions
_MAX_NINE_DIGIT = 1e4
SCALE = Option("metres-per-unit", "metres per scene unit", 1.0, minimum=1e-9, maximum=1e9)


def _bodies(scene: Scene, options: BackendOptions, backend: Backend) -> BodySet:
    """Return the bodies of the frame that a backend exports, with its scale."""
    check_settings(options, [backend])
    root = scene.frames[frame_of(scene, options.frame)]
    return bodies_of(root, backend.setting(options, SCALE.name))


# --- MJCF -------------------------------------------------------------------------------------------------------------


def _write_mjcf(scene: Scene, path: Path, options: BackendOptions) -> None:
    """Write a MuJoCo model."""
    spec = model_of(_bodies(scene, options, MJCF))
    model, _ = compiled(spec)  # the compiler centers meshes, which changes their poses
    write_text(path, _exact(spec.to_xml(), model))


def _exact(text: str, model: Any) -> str:
    """Return a model's XML with the positions, masses and inertias of bodies in full.

    MuJoCo writes six digits, which move bodies far from the origin, and by which the inertia of a thin plate breaks the
    inequality that MuJoCo tests when it reads them.
    """

    def exact(match: re.Match[str]) -> str:
        """Return the tags of a body and its inertia with full numbers."""
        number = model.body(html.unescape(match["name"])).id
        inertial = {"mass": model.body_mass[number : number + 1], "diaginertia": model.body_inertia[number]}
        head = _with_numbers(match["head"], {"pos": model.body_pos[number]})
        return head + _with_numbers(match["inertial"], inertial)

    return _BODY.sub(exact, text)


# The tag of a body and that of its inertia, which MuJoCo writes next.
_BODY = re.compile(r'(?P<head><body name="(?P<name>[^"]*)"[^>]*>)(?P<inertial>\s*<inertial [^>]*>)')


def _with_numbers(tag: str, numbers: Mapping[str, FloatArray]) -> str:
    """Return a tag with the values of attributes replaced."""
    for name, values in numbers.items():
        shown = " ".join(repr(float(value)) for value in values)
        tag = re.sub(rf'(?<= ){name}="[^"]*"', f'{name}="{shown}"', tag)
    return tag


MJCF = Backend(
    "mjcf",
    "MuJoCo model (MJCF) of the rigid bodies, with exact shapes, masses and inertias",
    Work.EXPORT,
    (".mjcf", ".mjcf.xml"),
    _write_mjcf,
    (SCALE,),
    Accepts(attributes=("color", "opacity", "fixed", "body", "mass", "density", "friction")),
    ("mujoco",),
    INSTALL,
)


# --- URDF -------------------------------------------------------------------------------------------------------------


def _write_urdf(scene: Scene, path: Path, options: BackendOptions) -> list[Path]:
    """Write a URDF and the OBJ files of its meshes; returns the files."""
    bodies = _bodies(scene, options, URDF)
    for body in bodies.bodies:
        check_weight(bodies, body, MIN_TENSOR)
    meshes = _MeshFiles(path.stem)
    lines = [
        '<?xml version="1.0"?>', f"<robot name={quoteattr(_plain(scene.word))}>", '  <link name="world"/>',
        *(line for name, body in zip(names_of(bodies), bodies.bodies) for line in _link(bodies, body, name, meshes)),
        "</robot>", "",
    ]  # fmt: skip
    with atomic_write_all(path.parent, path) as folder:
        for name, text in meshes.files.items():
            (folder / name).write_text(text, "ascii", newline="\n")
        (folder / path.name).write_text("\n".join(lines), "utf-8", newline="\n")
    return [path, *(path.parent / name for name in meshes.files)]


def _plain(word: str) -> str:
    """Return a word without the characters that XML does not allow."""
    return "".join(c if c.isprintable() else " " for c in word.encode("utf-8", "replace").decode("utf-8"))


class _MeshFiles:
    """The OBJ files of a URDF, one for each distinct convex mesh."""

    def __init__(self, stem: str) -> None:
        self.stem = stem
        self.files: dict[str, str] = {}
        self._names: dict[str, str] = {}

    def name(self, points: FloatArray) -> str:
        """Return the file name of the convex hull of points, which is written on first use."""
        text = _obj_of(points)
        if text not in self._names:
            self._names[text] = f"{self.stem}-piece{len(self._names)}.obj"
            self.files[self._names[text]] = text
        return self._names[text]


def _obj_of(points: FloatArray) -> str:
    """Return the convex hull of points as an OBJ file; raises SceneError for points without a hull."""
    import manifold3d

    hull = manifold3d.Manifold.hull_points(np.ascontiguousarray(points))
    if hull.is_empty():
        raise SceneError("solid", "a piece of the scene is too thin for a mesh of URDF")
    mesh = hull.to_mesh64()
    lines = [f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in np.asarray(mesh.vert_properties)[:, :3].tolist()]
    lines += [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in np.asarray(mesh.tri_verts).tolist()]
    return "\n".join(lines) + "\n"


def _link(bodies: BodySet, body: RigidBody, name: str, meshes: _MeshFiles) -> Iterator[str]:
    """Yield the lines of a body's link, and of the joint that connects it to the world."""
    unit, moments = bodies.unit, body.moments
    principal, principal_axes = moments.principal()
    axes_in_model = TO_MODEL @ principal_axes
    inertia = axes_in_model @ np.diag(principal) @ axes_in_model.T * unit**2
    inertia[np.abs(inertia) < 1e-15 * np.abs(inertia).max()] = 0.0
    names = "xyz"
    index_pairs = [(i, j) for i in range(3) for j in range(i, 3)]
    tensor = " ".join(f'i{names[i]}{names[j]}="{inertia[i, j]:.17g}"' for i, j in index_pairs)
    yield f"  <link name={quoteattr(name)}>"
    yield f'    <inertial><origin xyz="0 0 0" rpy="0 0 0"/><mass value="{moments.mass:.9g}"/>'
    yield f"      <inertia {tensor}/></inertial>"
    for part in body.parts:
        color = " ".join(f"{x:g}" for x in color_of(bodies, part))
        material = f'<material name="rgba {color}"><color rgba="{color}"/></material>'
        for shape in bodies.parts[part].colliders:
            for geometry, origin in _geometries(shape, moments.center, unit, meshes):
                yield f"    <visual>{origin}<geometry>{geometry}</geometry>{material}</visual>"
                yield f"    <collision>{origin}<geometry>{geometry}</geometry></collision>"
    yield "  </link>"
    kind = "fixed" if body.fixed else "floating"
    joint = quoteattr(f"world-{name}")
    yield f'  <joint name={joint} type="{kind}"><parent link="world"/><child link={quoteattr(name)}/>'
    yield f"    {_origin(TO_MODEL @ moments.center * unit, np.eye(3))}</joint>"


def _geometries(shape: Collider, center: FloatArray, unit: float, meshes: _MeshFiles) -> Iterator[tuple[str, str]]:
    """Yield the geometries of a collider, each with its origin in a body with the center of mass ``center``."""
    place, rotation = TO_MODEL @ (shape.center - center) * unit, TO_MODEL @ shape.rotation
    size = shape.size * unit
    if shape.kind == "box":
        yield f'<box size="{_numbers(2.0 * size)}"/>', _origin(place, rotation)
    elif shape.kind == "sphere":
        yield f'<sphere radius="{size[0]:.9g}"/>', _origin(place, rotation)
    elif shape.kind in ("cylinder", "capsule"):
        yield f'<cylinder radius="{size[0]:.9g}" length="{2.0 * size[1]:.9g}"/>', _origin(place, rotation)
        for side in (-1.0, 1.0) if shape.kind == "capsule" else ():
            end = place + rotation[:, 2] * side * size[1]
            yield f'<sphere radius="{size[0]:.9g}"/>', _origin(end, rotation)
    else:
        points = shape.vertices * unit if shape.kind == "mesh" else BALL.mesh(2 * SEGMENTS, ()).vertices * size
        yield f'<mesh filename="{meshes.name(points)}"/>', _origin(place, rotation)


def _numbers(values: Sequence[float] | FloatArray) -> str:
    """Return numbers as URDF writes them, without negative zeros."""
    return " ".join(f"{float(x) if abs(x) > 1e-12 else 0.0:.{9 if abs(x) < _MAX_NINE_DIGIT else 15}g}" for x in values)


def _origin(place: FloatArray, rotation: FloatArray) -> str:
    """Return the `<origin>` tag of a pose in meters and radians."""
    return f'<origin xyz="{_numbers(place)}" rpy="{_numbers(roll_pitch_yaw(rotation))}"/>'


def roll_pitch_yaw(rotation: FloatArray) -> tuple[float, float, float]:
    """Return a rotation (3, 3) as angles about the fixed axes x, y and z in this order, as URDF has them."""
    level = math.hypot(rotation[0, 0], rotation[1, 0])
    pitch = math.atan2(-rotation[2, 0], level)
    if level < 1e-9:  # gimbal lock: yaw is 0 and roll takes the whole rotation
        return math.atan2(-rotation[1, 2], rotation[1, 1]), pitch, 0.0
    return math.atan2(rotation[2, 1], rotation[2, 2]), pitch, math.atan2(rotation[1, 0], rotation[0, 0])


URDF = Backend(
    "urdf",
    "URDF: a link for every rigid body, joined to the world, with meshes beside it",
    Work.EXPORT,
    (".urdf",),
    _write_urdf,
    (SCALE,),
    Accepts(attributes=("color", "opacity", "fixed", "body", "mass", "density")),
    ("mujoco",),
    INSTALL,
)
