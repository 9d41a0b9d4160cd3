"""UsdPhysics in the USD export, with ``--physics``: rigid bodies, colliders, masses, friction, gravity and the ground.

Every body is a prim below the root, whose pose is a translation to its center of mass. Its visible prims, instances
included, are its children, and so are its colliders, which are not drawn. The children of the root are the bodies
because rigid bodies must be above instance roots, and a welded body may have parts from several branches. Bodies that
cannot move are colliders only. Shapes that USD has are exact; ellipsoids and others are meshes with the convex hull as
their approximation, because physics allows no scale on spheres, cylinders and capsules.
"""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from scenelang.backends.base import BackendOptions, frame_of, require
from scenelang.backends.exports.usd import INSTALL, PLAIN_USD, package
from scenelang.backends.files import atomic_write_all
from scenelang.backends.physics.colliders import SEGMENTS, Collider, FloatArray
from scenelang.backends.physics.dynamics import FRICTION, GRAVITY, check_weight, quaternion
from scenelang.backends.physics.grouping import BodySet, RigidBody, bodies_of
from scenelang.interpreter.scene.entity import Entity, Scene
from scenelang.interpreter.scene.pose import translation
from scenelang.interpreter.scene.primitives.sphere import BALL
from scenelang.interpreter.values.values import ANONYMOUS, Matrix, Pair

_RESERVED = ("Materials", "Prototypes", "Shapes")


def regrouped(root: Entity, bodies: BodySet) -> Entity:
    """Return the frame with one child of the root for each body, at its center of mass.

    Entities that belong to no body come last. All parts are pairs ``(Entity . Matrix)``.
    """
    body_parts: list[list[Pair]] = [[] for _ in bodies.bodies]  # in the frame of the body's center of mass
    other_parts: list[Pair] = []
    is_assigned = [False] * len(bodies.nodes)  # whether a node is in a part, which includes all its descendants
    for number, (node, bodies_inside) in enumerate(zip(bodies.nodes, bodies.inside, strict=True)):
        is_assigned[number] = node.parent >= 0 and is_assigned[node.parent]
        # The root, and a node with several bodies, are divided: their children are assigned one by one.
        if is_assigned[number] or number == 0 or len(bodies_inside) > 1:
            continue
        is_assigned[number] = True
        if not bodies_inside:
            other_parts.append(Pair(node.entity, node.world))
        for body in bodies_inside:
            pose = _moved(node.world, (-bodies.bodies[body].moments.center).tolist())
            body_parts[body].append(Pair(node.entity, pose))
    body_pairs = [
        Pair(Entity(body.words[-1], ANONYMOUS, tuple(parts)), translation(*body.moments.center.tolist()))
        for body, parts in zip(bodies.bodies, body_parts, strict=True)
    ]
    return Entity(root.word, root.embedding, (*body_pairs, *other_parts), None, root.tainted)


def _moved(pose: Matrix, by: Sequence[float]) -> Matrix:
    """Return a pose translated by a world vector."""
    rows = list(pose)
    for axis in range(3):
        rows[4 * axis + 3] += by[axis]
    return Matrix(rows)


def write_with_physics(scene: Scene, path: Path, options: BackendOptions) -> list[Path]:
    """Write one frame with rigid bodies; ``exports/usd`` calls it for ``--physics``."""
    root = scene.frames[frame_of(scene, options.frame)]
    bodies = bodies_of(root, 1.0)
    for body in bodies.bodies:
        check_weight(bodies, body)
    still = Scene(scene.word, [regrouped(root, bodies)], False)
    with tempfile.TemporaryDirectory() as drafts, atomic_write_all(path.parent, path) as folder:
        draft = Path(drafts) / f"{path.stem}.usdc"
        PLAIN_USD.run(still, draft, replace(options, frame=None))
        usd = require("pxr.Usd", INSTALL)
        stage = usd.Stage.Open(str(draft))
        _Physics(stage, bodies).add()
        stage.GetRootLayer().Save()
        _save(stage, draft, folder / path.name)
    return [path]


def _save(stage: Any, draft: Path, target: Path) -> None:
    """Write a stage to a file, packed if it is a USDZ, and the images of its draft; raises OSError."""
    if target.suffix.lower() == ".usdz":
        done = package(draft, target)
    else:
        done = stage.GetRootLayer().Export(str(target))
        for image in draft.parent.glob("*.png"):
            shutil.copyfile(image, target.with_name(image.name))
    if not done:
        raise OSError(5, "USD cannot write the file", str(target))


class _Physics:
    """Adds the prims and the schemas of physics to a stage."""

    def __init__(self, stage: Any, bodies: BodySet) -> None:
        modules = (require(f"pxr.{name}", INSTALL) for name in ("Gf", "Sdf", "UsdGeom", "UsdPhysics", "UsdShade", "Vt"))
        self.gf, self.sdf, self.geom, self.physics, self.shade, self.vt = modules
        self.stage, self.bodies = stage, bodies
        self.root = stage.GetDefaultPrim()
        self._materials: dict[float, Any] = {}

    def add(self) -> None:
        """Add the bodies, the gravity and the ground."""
        prims = [prim for prim in self.root.GetAllChildren() if prim.GetName() not in _RESERVED]
        for body, prim in zip(self.bodies.bodies, prims):
            self._add_body(body, prim)
        path = self.root.GetPath()
        scene = self.physics.Scene.Define(self.stage, path.AppendChild(self._free("PhysicsScene")))
        scene.CreateGravityDirectionAttr(self.gf.Vec3f(0.0, -1.0, 0.0))
        scene.CreateGravityMagnitudeAttr(GRAVITY)
        ground = self.geom.Plane.Define(self.stage, path.AppendChild(self._free("PhysicsGround")))
        ground.CreateAxisAttr("Y")
        self.geom.Imageable(ground).CreatePurposeAttr("guide")
        self._place(ground, np.eye(3), np.array([0.0, self.bodies.ground, 0.0]))
        self._collide(ground.GetPrim(), None)

    def _free(self, name: str) -> str:
        """Return a name that no child of the root has."""
        number, free_name = 2, name
        while self.root.GetChild(free_name):
            free_name, number = f"{name}_{number}", number + 1
        return free_name

    def _add_body(self, body: RigidBody, prim: Any) -> None:
        """Apply mass and inertia to the prim of a movable body, and add the body's colliders."""
        if not body.fixed:
            self.physics.RigidBodyAPI.Apply(prim)
            moments, axes = np.linalg.eigh(body.moments.inertia)
            axes = axes if np.linalg.det(axes) > 0.0 else axes * np.array([1.0, 1.0, -1.0])
            w, x, y, z = quaternion(axes)
            mass = self.physics.MassAPI.Apply(prim)
            mass.CreateMassAttr(body.moments.mass)
            mass.CreateCenterOfMassAttr(self.gf.Vec3f(0.0, 0.0, 0.0))
            mass.CreateDiagonalInertiaAttr(self.gf.Vec3f(*moments.tolist()))
            mass.CreatePrincipalAxesAttr(self.gf.Quatf(w, x, y, z))
        holder = self.geom.Scope.Define(self.stage, prim.GetPath().AppendChild("physics_colliders"))
        self.geom.Imageable(holder).CreatePurposeAttr("guide")
        number = 0
        for part in body.parts:
            for shape in self.bodies.parts[part].colliders:
                number += 1
                path = holder.GetPath().AppendChild(f"collider_{number}")
                self._add_collider(path, shape, body.moments.center, self.bodies.frictions[part])

    def _add_collider(self, path: Any, shape: Collider, center: FloatArray, friction: float | None) -> None:
        """Add a collider at its pose from the body's center of mass."""
        size, linear = shape.size.tolist(), shape.rotation
        if shape.kind == "box":
            geometry = self.geom.Cube.Define(self.stage, path)
            geometry.CreateSizeAttr(2.0)
            linear = shape.rotation * shape.size
            half = (1.0, 1.0, 1.0)
        elif shape.kind == "sphere":
            geometry = self.geom.Sphere.Define(self.stage, path)
            geometry.CreateRadiusAttr(size[0])
            half = tuple(shape.half.tolist())
        elif shape.kind in ("cylinder", "capsule"):
            geometry = getattr(self.geom, shape.kind.capitalize()).Define(self.stage, path)
            geometry.CreateAxisAttr("Z")
            geometry.CreateRadiusAttr(size[0])
            geometry.CreateHeightAttr(2.0 * size[1])
            half = tuple(shape.half.tolist())
        else:
            self._add_mesh(path, shape, center, friction)
            return
        geometry.CreateExtentAttr([self.gf.Vec3f(*(-x for x in half)), self.gf.Vec3f(*half)])
        self._place(geometry, linear, shape.center - center)
        self._collide(geometry.GetPrim(), friction)

    def _add_mesh(self, path: Any, shape: Collider, center: FloatArray, friction: float | None) -> None:
        """Add a collider without an exact USD shape as a mesh, of which the physics uses the convex hull."""
        import manifold3d

        points = shape.vertices if shape.kind == "mesh" else BALL.mesh(2 * SEGMENTS, ()).vertices * shape.size
        hull = manifold3d.Manifold.hull_points(np.ascontiguousarray(points))
        if hull.is_empty():
            return
        mesh = hull.to_mesh64()
        corners = np.ascontiguousarray(np.asarray(mesh.vert_properties)[:, :3], np.float32)
        faces = np.ascontiguousarray(np.asarray(mesh.tri_verts), np.int32)
        geometry = self.geom.Mesh.Define(self.stage, path)
        geometry.CreatePointsAttr(self.vt.Vec3fArray.FromNumpy(corners))
        geometry.CreateFaceVertexIndicesAttr(self.vt.IntArray.FromNumpy(faces.reshape(-1)))
        geometry.CreateFaceVertexCountsAttr(self.vt.IntArray(len(faces), 3))
        geometry.CreateSubdivisionSchemeAttr("none")
        geometry.CreateExtentAttr(self.vt.Vec3fArray.FromNumpy(np.stack([corners.min(axis=0), corners.max(axis=0)])))
        self._place(geometry, shape.rotation, shape.center - center)
        self._collide(geometry.GetPrim(), friction)
        self.physics.MeshCollisionAPI.Apply(geometry.GetPrim()).CreateApproximationAttr("convexHull")

    def _place(self, prim: Any, linear: FloatArray, position: FloatArray) -> None:
        """Set the transform of a prim; USD multiplies row vectors."""
        rows = np.eye(4)
        rows[:3, :3], rows[3, :3] = linear.T, position
        self.geom.Xformable(prim).AddTransformOp().Set(self.gf.Matrix4d(*rows.ravel().tolist()))

    def _collide(self, prim: Any, friction: float | None) -> None:
        """Make a prim a collider with the material of its friction."""
        self.physics.CollisionAPI.Apply(prim)
        binding = self.shade.MaterialBindingAPI.Apply(prim)
        material = self._material(FRICTION if friction is None else friction)
        binding.Bind(material, self.shade.Tokens.weakerThanDescendants, "physics")

    def _material(self, friction: float) -> Any:
        """Return the material of a coefficient of friction, added on first use."""
        if friction not in self._materials:
            path = self.root.GetPath().AppendChild("Materials").AppendChild(f"friction_{len(self._materials) + 1}")
            shade_material = self.shade.Material.Define(self.stage, path)
            material = self.physics.MaterialAPI.Apply(shade_material.GetPrim())
            material.CreateStaticFrictionAttr(friction)
            material.CreateDynamicFrictionAttr(friction)
            material.CreateRestitutionAttr(0.0)
            self._materials[friction] = shade_material
        return self._materials[friction]
