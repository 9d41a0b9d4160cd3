"""Convex colliders of posed primitives: exact shapes where simulators have them, otherwise convex meshes.

A ball under any affine pose is an ellipsoid, a box is a box unless it is sheared, a cylinder stays one while its
cross-section is round, a capsule under a similarity. What else is convex becomes the hull of its mesh; what is not
convex is decomposed once in its own frame by CoACD (Wei, Liu, Ling and Su, 2022) and stored on disk: affine poses keep
pieces convex.
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
from scenelang.interpreter.scene.modelling.computing import welded
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

INSTALL = "'scenelang[physics]'"
SEGMENTS = 24  # sides of the meshes of round shapes that simulators do not have
MAX_PIECES = 64  # of one non-convex primitive
MAX_DECOMPOSED = 200_000  # triangles of a mesh that is decomposed
_TIMEOUT = 180.0  # seconds of CoACD for one mesh, which is halved if that is not enough
_CONCAVITY = 0.05  # of CoACD, relative to the size: its own default
_CONVEX = 2e-3  # of the hull's volume: a mesh that lacks less counts as convex
_WEDGES = 16  # of a torus
_THIN = 1e-6  # of the largest extent: thinner things are flat
_SAME = 1e-6  # relative tolerance of equal lengths and right angles of axes

# From the frames of simulators, whose cylinders and capsules lie along z, to ours, where they lie along y.
_ALONG_Y = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])


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
    """Return the colliders of a primitive under the world pose (3, 4); none for what is flat or invisible.

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
    local = placed.matrix
    linear, center = world[:, :3] @ local[:, :3], world[:, :3] @ local[:, 3] + world[:, 3]
    lengths = np.linalg.svd(linear, compute_uv=False)
    if not np.isfinite(lengths).all() or lengths[2] <= _THIN * lengths[0] or lengths[0] == 0.0:
        return ()
    if not placed.form.is_convex:
        mesh = placed.form.mesh(_WEDGES * 4, placed.ratios)
        pieces = _wedges(mesh.vertices) if placed.form is TORUS else _decomposed_mesh(mesh.vertices, mesh.faces)
        return tuple(_mesh(piece, np.column_stack([linear, center])) for piece in pieces)
    exact = _exact(placed, linear, center)
    if exact is not None:
        return (exact,)
    return (_mesh(placed.form.mesh(SEGMENTS, placed.ratios).vertices, np.column_stack([linear, center])),)


def _wedges(vertices: FloatArray) -> tuple[FloatArray, ...]:
    """Return the corners of a ring about the y axis in wedges, which share those on the planes between them."""
    turn = np.arctan2(vertices[:, 2], vertices[:, 0]) * _WEDGES / (2.0 * np.pi)
    middles = np.arange(_WEDGES) + 0.5
    away = np.abs((turn[:, None] - middles + _WEDGES / 2.0) % _WEDGES - _WEDGES / 2.0)
    return tuple(vertices[near] for near in (away <= 0.5 + 1e-6).T)


def _exact(placed: Placed, linear: FloatArray, center: FloatArray) -> Collider | None:
    """Return a form as a shape that simulators have, None if they do not have it."""
    none = np.zeros((0, 3))
    if placed.form is BALL:
        axes, size, _ = np.linalg.svd(linear)
        if size[0] - size[2] <= _SAME * size[0]:
            return Collider("sphere", np.array([size[0], 0.0, 0.0]), np.eye(3), center, none)
        return Collider("ellipsoid", size, _proper(axes), center, none)
    size = np.linalg.norm(linear, axis=0)
    axes = linear / size
    if np.abs(axes.T @ axes - np.eye(3)).max() > _SAME:
        return None
    is_round = abs(size[0] - size[2]) <= _SAME * size[0]
    turned = _proper(axes) @ _ALONG_Y
    if placed.form is BLOCK:  # turned too: an upright box is upright in simulators
        return Collider("box", size[[0, 2, 1]], turned, center, none)
    if placed.form is CYLINDER and is_round:
        return Collider("cylinder", np.array([size[0], size[1], 0.0]), turned, center, none)
    if placed.form is CAPSULE and is_round and abs(size[0] - size[1]) <= _SAME * size[0]:
        radius = float(placed.ratios[0]) * size[1]
        return Collider("capsule", np.array([radius, size[1] - radius, 0.0]), turned, center, none)
    return None


def _proper(axes: FloatArray) -> FloatArray:
    """Return orthogonal axes as a rotation; the shapes here are symmetric, so that one axis may be reversed."""
    return axes if np.linalg.det(axes) > 0.0 else axes * np.array([1.0, 1.0, -1.0])


def _mesh(points: FloatArray, world: FloatArray) -> Collider:
    """Return a convex mesh under an affine pose: the rotation of its polar decomposition, and stretched corners, so
    that equal things in several directions share a mesh."""
    u, size, v = np.linalg.svd(world[:, :3])
    rotation = u @ v
    stretch = v.T @ np.diag(size) @ v
    if np.linalg.det(rotation) < 0.0:
        rotation, stretch = -rotation, -stretch
    return Collider("mesh", np.zeros(3), rotation, world[:, 3].copy(), points @ stretch)


def _is_thin(points: FloatArray) -> bool:
    """Whether points lie in a plane, a line or a point, within ``_THIN`` of their size."""
    if len(points) < 4 or not np.isfinite(points).all():
        return True
    spread = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    return bool(spread[2] <= _THIN * spread[0])


# --- parts of colliders -----------------------------------------------------------------------------------------------


def reach_of(shape: Collider, along: FloatArray) -> float:
    """Return how far a collider reaches in a direction: the greatest product of its points with it."""
    return float((_points(shape) @ along).max())


def trimmed(shape: Collider, along: FloatArray, level: float) -> Collider | None:
    """Return the part of a collider whose points have a product with the unit vector ``along`` of at most ``level``;
    None if nothing is left."""
    import manifold3d

    own, level_there = shape.rotation.T @ along, level - float(along @ shape.center)
    axis = int(np.argmax(np.abs(own)))
    if abs(own[axis]) > 1.0 - 1e-3 * _SAME and (shape.kind == "box" or (shape.kind == "cylinder" and axis == 2)):
        where = 1 if shape.kind == "cylinder" else axis
        half = (shape.size[where] + level_there) / 2.0
        if half <= 0.0:
            return None
        size = shape.size.copy()
        size[where] = half
        return replace(shape, size=size, center=shape.center + along * (half - shape.size[where]))
    points = (_points(shape) - shape.center) @ shape.rotation
    solid = manifold3d.Manifold.hull_points(np.ascontiguousarray(points))
    solid = solid.trim_by_plane(tuple(-own), -level_there)
    hull = _hull(np.asarray(solid.to_mesh64().vert_properties[:, :3], np.float64)) if not solid.is_empty() else None
    if hull is None or _is_thin(hull[0]):
        return None
    return Collider("mesh", np.zeros(3), shape.rotation, shape.center, hull[0])


def volume_of_collider(shape: Collider) -> float:
    """Return the volume of a collider; of a round one that of its mesh."""
    if shape.kind == "box":
        return 8.0 * float(shape.size.prod())
    if shape.kind == "cylinder":
        return 2.0 * np.pi * float(shape.size[0] ** 2 * shape.size[1])
    hull = _hull(_points(shape))
    return 0.0 if hull is None else hull[1]


def _points(shape: Collider) -> FloatArray:
    """Return points (K, 3) in the world whose hull is a collider, or for a round one its mesh."""
    if shape.kind in ("box", "mesh"):
        return shape.corners
    a, b = float(shape.size[0]), float(shape.size[1])
    if shape.kind == "cylinder":
        points = CYLINDER.mesh(SEGMENTS, ()).vertices * [a, b, a] @ _ALONG_Y
    elif shape.kind == "capsule":
        points = CAPSULE.mesh(SEGMENTS, (a / (a + b),)).vertices * (a + b) @ _ALONG_Y
    else:
        points = BALL.mesh(SEGMENTS, ()).vertices * shape.half
    return np.asarray(points @ shape.rotation.T + shape.center, np.float64)


# --- pieces of shapes that are not convex -----------------------------------------------------------------------------


def pieces_of(shape: Primitive) -> tuple[FloatArray, ...]:
    """Return the corners of convex pieces, arrays (K, 3) in the frame of the primitive, of a mesh or a solid."""
    return _pieces_of(shape.key)


@lru_cache(maxsize=256)
def _pieces_of(shape: Primitive) -> tuple[FloatArray, ...]:
    mesh = own_mesh(shape)
    return () if mesh is None else _decomposed_mesh(mesh.vertices, mesh.faces)


def _decomposed_mesh(vertices: FloatArray, faces: IntArray) -> tuple[FloatArray, ...]:
    vertices, faces, _ = welded(vertices, faces)
    if _is_thin(vertices):
        return ()
    if len(faces) > MAX_DECOMPOSED:
        message = f"a mesh of {len(faces):,} triangles is more than the limit of {MAX_DECOMPOSED:,} for a simulation"
        raise LimitError("size", message, "simplify the mesh, or use fewer segments")
    hull = _hull(vertices)
    if hull is None:
        return ()
    corners, volume = hull
    if abs(volume_of(vertices[faces])) >= (1.0 - _CONVEX) * volume:
        return (corners,)
    return _decomposed(vertices.tobytes(), faces.tobytes())


def _hull(vertices: FloatArray) -> tuple[FloatArray, float] | None:
    """Return the corners (K, 3) of the convex hull and its volume, None if it has none."""
    import manifold3d

    hull = manifold3d.Manifold.hull_points(np.ascontiguousarray(vertices, np.float64))
    if hull.is_empty() or hull.volume() <= 0.0:
        return None
    return np.asarray(hull.to_mesh64().vert_properties[:, :3], np.float64), float(hull.volume())


@lru_cache(maxsize=256)
def _decomposed(vertices: bytes, faces: bytes) -> tuple[FloatArray, ...]:
    """Return the convex pieces of a mesh by CoACD, from the disk if they are there."""
    key = hashlib.sha256(vertices + faces + repr((_CONCAVITY, MAX_PIECES)).encode()).hexdigest()
    found = _loaded(key)
    if found is None:
        found = _coacd(np.frombuffer(vertices).reshape(-1, 3), np.frombuffer(faces, np.int64).reshape(-1, 3))
        write_cached("pieces", key, {f"piece{i}": piece for i, piece in enumerate(found)})
    return found


def _coacd(vertices: FloatArray, faces: IntArray) -> tuple[FloatArray, ...]:
    """Return the pieces (K, 3) of CoACD, which runs in a process of its own: some meshes make it abort."""
    require("coacd", INSTALL)
    # Sizes are those of a cube of side 2, for which the thresholds of CoACD are made.
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    middle, scale = (low + high) / 2.0, float((high - low).max()) / 2.0
    with tempfile.TemporaryDirectory() as folder:
        given, made = Path(folder) / "mesh.npz", Path(folder) / "pieces.npz"
        np.savez(given, vertices=(vertices - middle) / scale, faces=faces.astype(np.int32))
        script = _SCRIPT.format(given=str(given), made=str(made), concavity=_CONCAVITY, pieces=MAX_PIECES)
        run = [sys.executable, "-c", script]
        with suppress(subprocess.TimeoutExpired):
            subprocess.run(run, check=False, capture_output=True, timeout=_TIMEOUT)  # noqa: S603  # nosec B603
        if not made.is_file():
            return _halved(vertices, faces)
        with np.load(made) as arrays:
            pieces = [np.asarray(arrays[f"arr_{i}"], np.float64) for i in range(len(arrays.files))]
    hulls = [_hull(points) for points in pieces]
    return tuple(hull[0] * scale + middle for hull in hulls if hull is not None)


def _halved(vertices: FloatArray, faces: IntArray) -> tuple[FloatArray, ...]:
    """Return the hulls of the pieces of a mesh that is halved across its longest side, those with the emptiest hulls
    first, until each nearly fills its hull or there are ``MAX_PIECES``."""
    import manifold3d

    mesh = manifold3d.Manifold(manifold3d.Mesh64(np.array(vertices), faces.astype(np.uint64)))
    pieces = mesh.decompose()
    while len(pieces) < MAX_PIECES:
        empty = [piece.hull().volume() - piece.volume() for piece in pieces]
        worst = int(np.argmax(empty)) if empty else 0
        if not empty or empty[worst] <= _CONCAVITY * mesh.volume() / MAX_PIECES:
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
coacd.set_log_level("off")
with numpy.load({given!r}) as mesh:
    shape = coacd.Mesh(mesh["vertices"], mesh["faces"])
pieces = coacd.run_coacd(shape, threshold={concavity}, max_convex_hull={pieces}, max_ch_vertex=64, seed=0)
numpy.savez({made!r}, *[numpy.asarray(points) for points, _ in pieces])
"""


def _loaded(key: str) -> tuple[FloatArray, ...] | None:
    arrays = read_cached("pieces", key)
    if arrays is None:
        return None
    found = tuple(arrays.get(f"piece{i}", np.zeros(0)) for i in range(len(arrays)))
    sound = all(each.dtype == np.float64 and each.ndim == 2 and each.shape[1] == 3 for each in found)
    return found if sound and all(np.isfinite(each).all() and len(each) >= 4 for each in found) else None
