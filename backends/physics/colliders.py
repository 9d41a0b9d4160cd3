"""Convex colliders of posed primitives: exact shapes where simulators have them, otherwise convex meshes.

A ball under any affine pose is an ellipsoid, a box is a box unless it is sheared, a cylinder stays one while its
cross-section is round, a capsule under a similarity. Other convex shapes become the hull of their mesh. Non-convex
shapes are decomposed once in their own frame, since affine poses keep the pieces convex, and stored on disk. Source:
Wei, Liu, Ling and Su, "Approximate Convex Decomposition for 3D Meshes with Collision-Aware Concavity and Tree Search"
(CoACD), SIGGRAPH 2022.
"""

from __future__ import annotations

import hashlib
import subprocess
import sys
import tempfile
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path

import numpy as np
import numpy.typing as npt

from scenelang.backends.base import require
from scenelang.backends.surfaces.solids import own_mesh
from scenelang.grammar.diagnostics import LimitError, SceneError
from scenelang.interpreter.loading import read_cached, write_cached
from scenelang.interpreter.scene.modelling.computing import boundary_edges, welded
from scenelang.interpreter.scene.primitives import Placed
from scenelang.interpreter.scene.primitives.base import Primitive
from scenelang.interpreter.scene.primitives.capsule import CAPSULE
from scenelang.interpreter.scene.primitives.cube import BLOCK, placed_block
from scenelang.interpreter.scene.primitives.cylinder import CYLINDER
from scenelang.interpreter.scene.primitives.mesh import volume_of
from scenelang.interpreter.scene.primitives.sphere import BALL
from scenelang.interpreter.scene.primitives.torus import TORUS

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]

INSTALL = "'scenelang[physics]'"  # extra to install, as error messages show it
SEGMENTS = 24  # sides of the meshes of round shapes that simulators lack
MAX_PIECES = 64  # convex pieces of one non-convex primitive
MAX_DECOMPOSED_TRIANGLES = 200_000  # of one mesh to decompose
# Of CoACD for one mesh, which is halved geometrically instead after that: nesting dolls take 1 to 4 s of CPU each. The
# outer limit is of wall time, for a process that waits.
_COACD_CPU_S, _COACD_TIMEOUT_S = 15, 180.0
_MAX_SURFACE_TRIANGLES = 1_000  # of an open mesh, each of which is a thin piece; larger ones are their hull
_SURFACE_THICKNESS = 0.005  # of the largest extent: thinner pieces let fast bodies through
_COACD_THRESHOLD = 0.05  # CoACD's own default threshold, relative to a cube of side 2
# of the hull's volume: a tessellated convex shape loses some volume to rounding, not to concavity
_MAX_CONCAVE_SHARE = 2e-3  # of the hull's volume: a mesh that fills more of its hull counts as convex
_TORUS_WEDGES = 16  # convex pieces of a torus, one per 22.5 degrees
_MIN_THICKNESS_RATIO = 1e-6  # of the largest extent: flatter shapes have no volume that a simulator can use
_RELATIVE_TOLERANCE = 1e-6  # for equal lengths and right angles between axes

# From the frames of simulators, whose cylinders and capsules have their axis along z, to ours, where it is y.
_Z_TO_Y = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])


@dataclass(frozen=True, slots=True, eq=False)
class Collider:
    """A convex shape in the world of the scene.

    Attributes
    ----------
    kind
        "box", "sphere", "ellipsoid", "cylinder", "capsule" or "mesh".
    size : (3,)
        Half sizes in scene units: of a box and an ellipsoid; the radius of a sphere; radius and half the length along z
        of a cylinder, and of a capsule without its hemispheres; zeros for a mesh.
    rotation : (3, 3)
        Rotation from the frame of the shape to the world.
    center : (3,)
        Origin of the frame of the shape in the world.
    vertices : (K, 3)
        Corners of a mesh, whose convex hull is the shape, in the frame of the shape; empty for other kinds.
    """

    kind: str
    size: FloatArray
    rotation: FloatArray
    center: FloatArray
    vertices: FloatArray

    @property
    def corners(self) -> FloatArray:
        """Points (K, 3) in the world that bound the shape: those of a mesh, otherwise those of its box."""
        if self.kind == "mesh":
            points = self.vertices
        else:
            signs = np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])
            points = signs * self.half
        return np.asarray(points @ self.rotation.T + self.center, np.float64)

    @property
    def half(self) -> FloatArray:
        """Half sizes (3,) of the box around the shape in its own frame; not for meshes."""
        a, b = float(self.size[0]), float(self.size[1])
        boxes = {"sphere": (a, a, a), "cylinder": (a, a, b), "capsule": (a, a, a + b)}
        return np.array(boxes.get(self.kind, tuple(self.size)))

    def box(self) -> tuple[FloatArray, FloatArray]:
        """Return the exact axis-aligned box in the world: low and high corner, (3,) each."""
        if self.kind == "mesh":
            points = self.corners
            return points.min(axis=0), points.max(axis=0)
        rotation, size = self.rotation, self.size
        if self.kind == "box":
            reach = np.abs(rotation) @ size
        elif self.kind in ("sphere", "ellipsoid"):
            reach = np.linalg.norm(rotation * self.half, axis=1)
        else:
            along = np.abs(rotation[:, 2]) * size[1]
            across = size[0] * np.sqrt(np.maximum(0.0, 1.0 - rotation[:, 2] ** 2))
            reach = along + (size[0] if self.kind == "capsule" else across)
        return self.center - reach, self.center + reach


def colliders_of(shape: Primitive, world: FloatArray) -> tuple[Collider, ...]:
    """Return the colliders of a primitive under the world pose (3, 4); none for flat or invisible primitives.

    Raises SceneError for meshes that cannot be read or decomposed, LimitError for those with too many triangles.
    """
    if shape.is_semantic:
        return _of_box(shape, world)
    placed = shape.placed()
    if placed is not None:
        return _of_form(placed, world)
    return tuple(_mesh(piece, world) for piece in pieces_of(shape) if not _is_thin(piece @ world[:, :3].T))


def _of_box(shape: Primitive, world: FloatArray) -> tuple[Collider, ...]:
    """Return the box of a semantic primitive."""
    box = np.array(shape.box_under((1.0, 0, 0, 0, 0, 1.0, 0, 0, 0, 0, 1.0, 0))).reshape(2, 3)
    x, y, z = (box[1] - box[0]).tolist()
    if min(x, y, z) <= 0.0:
        return ()
    rows = np.array(placed_block((x, y, z)).rows).reshape(3, 4)
    rows[:, 3] = box.mean(axis=0)
    return _of_form(Placed(BLOCK, (), tuple(rows.ravel().tolist())), world)


def _of_form(placed: Placed, world: FloatArray) -> tuple[Collider, ...]:
    """Return the colliders of a posed canonical form: one exact shape, one hull, or the pieces of a concave form."""
    local = placed.matrix
    linear, center = world[:, :3] @ local[:, :3], world[:, :3] @ local[:, 3] + world[:, 3]
    lengths = np.linalg.svd(linear, compute_uv=False)
    if not np.isfinite(lengths).all() or lengths[2] <= _MIN_THICKNESS_RATIO * lengths[0] or lengths[0] == 0.0:
        return ()
    if not placed.form.is_convex:
        mesh = placed.form.mesh(_TORUS_WEDGES * 4, placed.ratios)
        pieces = _wedges(mesh.vertices) if placed.form is TORUS else _decomposed_mesh(mesh.vertices, mesh.faces)
        return tuple(_mesh(piece, np.column_stack([linear, center])) for piece in pieces)
    exact = _exact(placed, linear, center)
    if exact is not None:
        return (exact,)
    return (_mesh(placed.form.mesh(SEGMENTS, placed.ratios).vertices, np.column_stack([linear, center])),)


def _wedges(vertices: FloatArray) -> tuple[FloatArray, ...]:
    """Return the corners of each wedge of a ring about the y axis; adjacent wedges share the corners between them."""
    sector = np.arctan2(vertices[:, 2], vertices[:, 0]) * _TORUS_WEDGES / (2.0 * np.pi)
    middles = np.arange(_TORUS_WEDGES) + 0.5
    distance = np.abs((sector[:, None] - middles + _TORUS_WEDGES / 2.0) % _TORUS_WEDGES - _TORUS_WEDGES / 2.0)
    return tuple(vertices[is_inside] for is_inside in (distance <= 0.5 + 1e-6).T)


def _exact(placed: Placed, linear: FloatArray, center: FloatArray) -> Collider | None:
    """Return a form as a shape that simulators have, None if they lack it."""
    no_vertices = np.zeros((0, 3))
    if placed.form is BALL:
        axes, size, _ = np.linalg.svd(linear)
        if size[0] - size[2] <= _RELATIVE_TOLERANCE * size[0]:
            return Collider("sphere", np.array([size[0], 0.0, 0.0]), np.eye(3), center, no_vertices)
        return Collider("ellipsoid", size, _proper(axes), center, no_vertices)
    size = np.linalg.norm(linear, axis=0)
    axes = linear / size
    if np.abs(axes.T @ axes - np.eye(3)).max() > _RELATIVE_TOLERANCE:
        return None
    is_round = abs(size[0] - size[2]) <= _RELATIVE_TOLERANCE * size[0]
    rotation = _proper(axes) @ _Z_TO_Y
    if placed.form is BLOCK:  # rotated too, so that an upright box is upright in simulators
        return Collider("box", size[[0, 2, 1]], rotation, center, no_vertices)
    if placed.form is CYLINDER and is_round:
        return Collider("cylinder", np.array([size[0], size[1], 0.0]), rotation, center, no_vertices)
    if placed.form is CAPSULE and is_round and abs(size[0] - size[1]) <= _RELATIVE_TOLERANCE * size[0]:
        radius = float(placed.ratios[0]) * size[1]
        return Collider("capsule", np.array([radius, size[1] - radius, 0.0]), rotation, center, no_vertices)
    return None


def _proper(axes: FloatArray) -> FloatArray:
    """Return orthogonal axes as a rotation; the shapes here are symmetric, so that one axis may be reversed."""
    return axes if np.linalg.det(axes) > 0.0 else axes * np.array([1.0, 1.0, -1.0])


def _mesh(points: FloatArray, world: FloatArray) -> Collider:
    """Return a convex mesh under an affine pose: the rotation of its polar decomposition, and stretched corners.

    Objects that differ only by a rotation then share a mesh.
    """
    u, size, v = np.linalg.svd(world[:, :3])
    rotation = u @ v
    stretch = v.T @ np.diag(size) @ v
    if np.linalg.det(rotation) < 0.0:
        rotation, stretch = -rotation, -stretch
    return Collider("mesh", np.zeros(3), rotation, world[:, 3].copy(), points @ stretch)


def _is_thin(points: FloatArray) -> bool:
    """Return whether points are in a plane, a line or a point, within ``_MIN_THICKNESS_RATIO`` of their size."""
    if len(points) < 4 or not np.isfinite(points).all():
        return True
    spread = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    return bool(spread[2] <= _MIN_THICKNESS_RATIO * spread[0])


# --- parts of colliders -----------------------------------------------------------------------------------------------


def reach_of(shape: Collider, along: FloatArray) -> float:
    """Return the extent of a collider in a direction: the largest dot product of its points with it."""
    return float((_points(shape) @ along).max())


def trimmed(shape: Collider, along: FloatArray, level: float) -> Collider | None:
    """Return the part of a collider below a plane, None if nothing is left.

    Its points have a dot product with the unit vector ``along`` of at most ``level``.
    """
    import manifold3d

    normal, local_level = shape.rotation.T @ along, level - float(along @ shape.center)
    axis = int(np.argmax(np.abs(normal)))
    # A plane across an axis of a box or cylinder shortens it, which keeps the exact shape.
    if abs(normal[axis]) > 1.0 - 1e-3 * _RELATIVE_TOLERANCE and (
        shape.kind == "box" or (shape.kind == "cylinder" and axis == 2)
    ):
        size_index = 1 if shape.kind == "cylinder" else axis
        half = (shape.size[size_index] + local_level) / 2.0
        if half <= 0.0:
            return None
        size = shape.size.copy()
        size[size_index] = half
        return replace(shape, size=size, center=shape.center + along * (half - shape.size[size_index]))
    points = (_points(shape) - shape.center) @ shape.rotation
    solid = manifold3d.Manifold.hull_points(np.ascontiguousarray(points))
    solid = solid.trim_by_plane(tuple(-normal), -local_level)
    hull = _hull(np.asarray(solid.to_mesh64().vert_properties[:, :3], np.float64)) if not solid.is_empty() else None
    if hull is None or _is_thin(hull[0]):
        return None
    return Collider("mesh", np.zeros(3), shape.rotation, shape.center, hull[0])


def volume_of_collider(shape: Collider) -> float:
    """Return the volume of a collider; that of its mesh for round shapes other than cylinders."""
    if shape.kind == "box":
        return 8.0 * float(shape.size.prod())
    if shape.kind == "cylinder":
        return 2.0 * np.pi * float(shape.size[0] ** 2 * shape.size[1])
    hull = _hull(_points(shape))
    return 0.0 if hull is None else hull[1]


def _points(shape: Collider) -> FloatArray:
    """Return points (K, 3) in the world whose hull is the collider, or the mesh of a round one."""
    if shape.kind in ("box", "mesh"):
        return shape.corners
    a, b = float(shape.size[0]), float(shape.size[1])
    if shape.kind == "cylinder":
        points = CYLINDER.mesh(SEGMENTS, ()).vertices * [a, b, a] @ _Z_TO_Y
    elif shape.kind == "capsule":
        points = CAPSULE.mesh(SEGMENTS, (a / (a + b),)).vertices * (a + b) @ _Z_TO_Y
    else:
        points = BALL.mesh(SEGMENTS, ()).vertices * shape.half
    return np.asarray(points @ shape.rotation.T + shape.center, np.float64)


# --- pieces of shapes that are not convex -----------------------------------------------------------------------------


def pieces_of(shape: Primitive) -> tuple[FloatArray, ...]:
    """Return the corners of convex pieces, arrays (K, 3) in the frame of the primitive, of a mesh or a solid."""
    return _pieces_of(shape.key)


@lru_cache(maxsize=256)
def _pieces_of(shape: Primitive) -> tuple[FloatArray, ...]:
    """Return the convex pieces of a primitive, computed once for equal keys."""
    mesh = own_mesh(shape)
    return () if mesh is None else _decomposed_mesh(mesh.vertices, mesh.faces)


def _decomposed_mesh(vertices: FloatArray, faces: IntArray) -> tuple[FloatArray, ...]:
    """Return the convex pieces of a mesh: itself if it is convex. Raises LimitError for too many triangles."""
    vertices, faces, _ = welded(vertices, faces)
    if _is_thin(vertices):
        return ()
    if len(faces) > MAX_DECOMPOSED_TRIANGLES:
        limit = f"the limit of {MAX_DECOMPOSED_TRIANGLES:,} for a simulation"
        message = f"a mesh of {len(faces):,} triangles is more than {limit}"
        raise LimitError("size", message, "simplify the mesh, or use fewer segments")
    hull = _hull(vertices)
    if hull is None:
        return ()
    corners, volume = hull
    if abs(volume_of(vertices[faces])) >= (1.0 - _MAX_CONCAVE_SHARE) * volume:
        return (corners,)
    if len(boundary_edges(faces)):
        return _surface_pieces(vertices, faces) or (corners,)
    return _decomposed(vertices.tobytes(), faces.tobytes())


def _surface_pieces(vertices: FloatArray, faces: IntArray) -> tuple[FloatArray, ...]:
    """Return a thin prism (6, 3) for each triangle of an open mesh; none if there are too many.

    Triangles without an area, which collide with nothing, are left out.

    CoACD closes open meshes first, which took more than a minute for a basket of five faces.
    """
    if len(faces) > _MAX_SURFACE_TRIANGLES:
        return ()
    corners = vertices[faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(normals, axis=1)
    has_area = lengths > 0.0
    half_thickness = 0.5 * _SURFACE_THICKNESS * float(np.ptp(vertices, axis=0).max())
    offsets = (normals[has_area] / lengths[has_area, None] * half_thickness)[:, None]
    return tuple(np.concatenate([corners[has_area] - offsets, corners[has_area] + offsets], axis=1))


def _hull(vertices: FloatArray) -> tuple[FloatArray, float] | None:
    """Return the corners (K, 3) of the convex hull and its volume, None if it has none."""
    import manifold3d

    hull = manifold3d.Manifold.hull_points(np.ascontiguousarray(vertices, np.float64))
    if hull.is_empty() or hull.volume() <= 0.0:
        return None
    return np.asarray(hull.to_mesh64().vert_properties[:, :3], np.float64), float(hull.volume())


@lru_cache(maxsize=256)
def _decomposed(vertices: bytes, faces: bytes) -> tuple[FloatArray, ...]:
    """Return the convex pieces of a mesh by CoACD, from the disk cache if they are stored."""
    key = hashlib.sha256(vertices + faces + repr((_COACD_THRESHOLD, MAX_PIECES)).encode()).hexdigest()
    pieces = _loaded(key)
    if pieces is None:
        pieces = _coacd(np.frombuffer(vertices).reshape(-1, 3), np.frombuffer(faces, np.int64).reshape(-1, 3))
        write_cached("pieces", key, {f"piece{i}": piece for i, piece in enumerate(pieces)})
    return pieces


def _coacd(vertices: FloatArray, faces: IntArray) -> tuple[FloatArray, ...]:
    """Return the pieces (K, 3) of CoACD, or of ``_halved`` if it fails.

    It runs in its own process, because it aborts on some meshes.
    """
    require("coacd", INSTALL)
    # CoACD's thresholds assume a mesh that fits a cube of side 2.
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    middle, scale = (low + high) / 2.0, float((high - low).max()) / 2.0
    with tempfile.TemporaryDirectory() as folder:
        mesh_file, pieces_file = Path(folder) / "mesh.npz", Path(folder) / "pieces.npz"
        np.savez(mesh_file, vertices=(vertices - middle) / scale, faces=faces.astype(np.int32))
        script = _SCRIPT.format(
            mesh_file=str(mesh_file), pieces_file=str(pieces_file), concavity=_COACD_THRESHOLD, pieces=MAX_PIECES,
            seconds=_COACD_CPU_S,
        )  # fmt: skip
        run = [sys.executable, "-c", script]
        with suppress(subprocess.TimeoutExpired):
            subprocess.run(run, check=False, capture_output=True, timeout=_COACD_TIMEOUT_S)  # noqa: S603  # nosec B603
        if not pieces_file.is_file():
            return _halved(vertices, faces)
        with np.load(pieces_file) as arrays:
            pieces = [np.asarray(arrays[f"arr_{i}"], np.float64) for i in range(len(arrays.files))]
    hulls = [_hull(points) for points in pieces]
    return tuple(hull[0] * scale + middle for hull in hulls if hull is not None)


def _halved(vertices: FloatArray, faces: IntArray) -> tuple[FloatArray, ...]:
    """Return convex hulls of pieces of a mesh, by repeated halving.

    The piece whose hull is emptiest is cut across its longest side, until every piece nearly fills its hull or there
    are ``MAX_PIECES``.
    """
    import manifold3d

    mesh = manifold3d.Manifold(manifold3d.Mesh64(np.array(vertices), faces.astype(np.uint64)))
    pieces = mesh.decompose()
    while len(pieces) < MAX_PIECES:
        excess = [piece.hull().volume() - piece.volume() for piece in pieces]
        worst = int(np.argmax(excess)) if excess else 0
        if not excess or excess[worst] <= _COACD_THRESHOLD * mesh.volume() / MAX_PIECES:
            break
        box = np.array(pieces[worst].bounding_box()).reshape(2, 3)
        axis = int(np.argmax(box[1] - box[0]))
        halves = pieces.pop(worst).split_by_plane(np.eye(3)[axis], float(box[:, axis].mean()))
        pieces += [part for half in halves for part in half.decompose()]
    if not pieces:
        raise SceneError("solid", "a mesh cannot be split into convex pieces", "use fewer or more segments")
    hulls = [_hull(np.asarray(piece.to_mesh64().vert_properties[:, :3], np.float64)) for piece in pieces]
    return tuple(hull[0] for hull in hulls if hull is not None)


_SCRIPT = """
import coacd, numpy
try:
    import resource
    resource.setrlimit(resource.RLIMIT_CPU, ({seconds}, {seconds}))
except ImportError:
    pass  # Windows has no such limit
coacd.set_log_level("off")
with numpy.load({mesh_file!r}) as mesh:
    shape = coacd.Mesh(mesh["vertices"], mesh["faces"])
pieces = coacd.run_coacd(shape, threshold={concavity}, max_convex_hull={pieces}, max_ch_vertex=64, seed=0)
numpy.savez({pieces_file!r}, *[numpy.asarray(points) for points, _ in pieces])
"""


def _loaded(key: str) -> tuple[FloatArray, ...] | None:
    """Return stored pieces; None if they are missing or not plausible arrays of corners."""
    arrays = read_cached("pieces", key)
    if arrays is None:
        return None
    pieces = tuple(arrays.get(f"piece{i}", np.zeros(0)) for i in range(len(arrays)))
    has_shape = all(piece.dtype == np.float64 and piece.ndim == 2 and piece.shape[1] == 3 for piece in pieces)
    is_finite = all(np.isfinite(piece).all() and len(piece) >= 4 for piece in pieces)
    return pieces if has_shape and is_finite else None
