"""Polygon meshes: Blender's primitives with its corners and faces, measures, and operations on whole meshes.

Corners are in the order of Blender, on which scripts rely that select them by number.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from scenelang.backends.blender.corner_orders import ico_order, sphere_tail
from scenelang.interpreter.transpile.evaluation import UnsupportedPython

FloatArray = npt.NDArray[np.float64]
Face = tuple[int, ...]
MAX_CORNERS = 400_000


@dataclass(frozen=True, slots=True, eq=False)
class Polygons:
    """Corners (V, 3) and faces, counter-clockwise from outside; ``materials`` are slots by face, None for all 0."""

    points: FloatArray
    faces: tuple[Face, ...]
    materials: tuple[int, ...] | None = None

    def __post_init__(self) -> None:
        if len(self.points) > MAX_CORNERS:
            raise UnsupportedPython(f"this mesh has more than {MAX_CORNERS:,} vertices")

    def moved(self, matrix: FloatArray) -> Polygons:
        """Return the mesh under a matrix (4, 4); a reflection turns the faces around."""
        points = self.points @ matrix[:3, :3].T + matrix[:3, 3]
        flipped = np.linalg.det(matrix[:3, :3]) < 0
        return Polygons(points, tuple(f[::-1] for f in self.faces) if flipped else self.faces, self.materials)

    def slots(self) -> tuple[int, ...]:
        """Return the material slot of every face."""
        return self.materials if self.materials is not None else (0,) * len(self.faces)

    def flipped(self) -> Polygons:
        """Return the mesh with all faces turned around."""
        return Polygons(self.points, tuple(face[::-1] for face in self.faces), self.materials)

    def triangles(self) -> npt.NDArray[np.int64]:
        """Return the faces as triangles (F, 3), fans of their first corners."""
        rows = [(face[0], face[i], face[i + 1]) for face in self.faces for i in range(1, len(face) - 1)]
        return np.array(rows, np.int64).reshape(-1, 3)

    def volume(self) -> float:
        """Return the signed volume."""
        a, b, c = np.moveaxis(self.points[self.triangles()], 1, 0)
        return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0)

    def face_normals(self) -> FloatArray:
        """Return the unit normals of the faces (Newell's method)."""
        normals = np.zeros((len(self.faces), 3))
        for number, face in enumerate(self.faces):
            corners = self.points[list(face)]
            normals[number] = np.cross(corners, np.roll(corners, -1, axis=0)).sum(axis=0)
        lengths = np.linalg.norm(normals, axis=1, keepdims=True)
        return normals / np.where(lengths == 0, 1.0, lengths)

    def point_normals(self) -> FloatArray:
        """Return the normals of the corners, faces weighted by their angles as in Blender."""
        normals = self.face_normals()
        at_points = np.zeros_like(self.points)
        for face, normal in zip(self.faces, normals, strict=True):
            corners = self.points[list(face)]
            back, ahead = np.roll(corners, 1, axis=0) - corners, np.roll(corners, -1, axis=0) - corners
            products = np.linalg.norm(back, axis=1) * np.linalg.norm(ahead, axis=1)
            cosines = np.einsum("ij,ij->i", back, ahead) / np.where(products == 0, 1.0, products)
            np.add.at(at_points, list(face), np.arccos(np.clip(cosines, -1, 1))[:, None] * normal)
        lengths = np.linalg.norm(at_points, axis=1, keepdims=True)
        return at_points / np.where(lengths == 0, 1.0, lengths)

    def edges(self) -> dict[tuple[int, int], list[int]]:
        """Return the faces at every edge, by its two corners in order."""
        faces: dict[tuple[int, int], list[int]] = defaultdict(list)
        for number, face in enumerate(self.faces):
            for a, b in zip(face, (*face[1:], face[0]), strict=True):
                faces[min(a, b), max(a, b)].append(number)
        return faces

    def is_closed(self) -> bool:
        """Return whether every edge joins two faces that go through it in opposite directions."""
        directed: dict[tuple[int, int], int] = defaultdict(int)
        for face in self.faces:
            for a, b in zip(face, (*face[1:], face[0]), strict=True):
                directed[a, b] += 1
        return bool(self.faces) and all(n == 1 and directed.get((b, a)) == 1 for (a, b), n in list(directed.items()))

    def without_inner_faces(self) -> Polygons:
        """Return the mesh without faces at all of whose edges there are three or more: an extrusion leaves them."""
        edges = self.edges()
        kept = [
            number
            for number, face in enumerate(self.faces)
            if any(len(edges[min(a, b), max(a, b)]) < 3 for a, b in zip(face, (*face[1:], face[0]), strict=True))
        ]
        return self if len(kept) == len(self.faces) or not kept else self.part(kept)

    def islands(self) -> list[Polygons]:
        """Return the connected parts that have faces, without loose corners."""
        parent = list(range(len(self.points)))

        def root(i: int) -> int:
            while parent[i] != i:
                parent[i] = parent[parent[i]]
                i = parent[i]
            return i

        for face in self.faces:
            for corner in face[1:]:
                parent[root(corner)] = root(face[0])
        groups: dict[int, list[int]] = defaultdict(list)
        for number, face in enumerate(self.faces):
            groups[root(face[0])].append(number)
        return [self.part(numbers) for numbers in groups.values()]

    def part(self, numbers: Sequence[int]) -> Polygons:
        """Return some of the faces, with their corners."""
        kept = sorted({corner for number in numbers for corner in self.faces[number]})
        place = {corner: i for i, corner in enumerate(kept)}
        faces = tuple(tuple(place[corner] for corner in self.faces[number]) for number in numbers)
        slots = self.slots()
        return Polygons(self.points[kept], faces, tuple(slots[number] for number in numbers))

    def welded(self, distance: float) -> Polygons:
        """Return the mesh with corners merged that are closer than a distance."""
        if not len(self.points):
            return self
        cell = max(distance, 1e-9)
        cells: dict[tuple[int, ...], list[int]] = defaultdict(list)
        place = np.arange(len(self.points))
        for i, point in enumerate(self.points):
            key = np.floor(point / cell).astype(int)
            near = (j for d in np.ndindex(3, 3, 3) for j in cells.get(tuple((key + d - 1).tolist()), ()))
            match = next((j for j in near if np.linalg.norm(self.points[j] - point) <= distance), None)
            if match is None:
                cells[tuple(key.tolist())].append(i)
            else:
                place[i] = match
        return self._relabeled(place.tolist())

    def _relabeled(self, place: Sequence[int]) -> Polygons:
        kept = sorted(set(place))
        number = {corner: i for i, corner in enumerate(kept)}
        faces: list[Face] = []
        slots: list[int] = []
        for face, slot in zip(self.faces, self.slots(), strict=True):
            corners = [number[place[corner]] for corner in face]
            corners = [c for i, c in enumerate(corners) if c != corners[i - 1]]
            if len(set(corners)) >= 3:
                faces.append(tuple(corners))
                slots.append(slot)
        return Polygons(self.points[kept], tuple(faces), tuple(slots))

    def oriented(self) -> Polygons:
        """Return the mesh with consistent faces, outwards where it is closed (`normals_make_consistent`)."""
        around = self.edges()
        faces = list(self.faces)
        seen: set[int] = set()
        groups: list[list[int]] = []
        for start in range(len(faces)):
            if start in seen:
                continue
            seen.add(start)
            group = [start]
            for number in group:
                for a, b in zip(faces[number], (*faces[number][1:], faces[number][0]), strict=True):
                    for other in around[min(a, b), max(a, b)]:
                        if other not in seen:
                            seen.add(other)
                            group.append(other)
                            if _goes(faces[other], a, b):
                                faces[other] = faces[other][::-1]
            groups.append(group)
        made = Polygons(self.points, tuple(faces), self.materials)
        for group in groups:
            part = made.part(group)
            center = part.points.mean(axis=0)
            if Polygons(part.points - center, part.faces).volume() < 0:
                for number in group:
                    faces[number] = faces[number][::-1]
        return Polygons(self.points, tuple(faces), self.materials)


def _goes(face: Face, a: int, b: int) -> bool:
    return any(pair == (a, b) for pair in zip(face, (*face[1:], face[0]), strict=True))


EMPTY = Polygons(np.zeros((0, 3)), ())


def combined(meshes: Iterable[Polygons]) -> Polygons:
    """Return meshes as one."""
    parts = list(meshes)
    if not parts:
        return EMPTY
    starts = np.cumsum([0, *(len(part.points) for part in parts)]).tolist()
    faces = [tuple(c + start for c in face) for part, start in zip(parts, starts) for face in part.faces]
    slots = tuple(slot for part in parts for slot in part.slots())
    return Polygons(np.concatenate([part.points for part in parts]), tuple(faces), slots)


# --- primitives of unit size -----------------------------------------------------------------------------------------


def _made(points: object, faces: Iterable[Iterable[int]]) -> Polygons:
    return Polygons(np.array(points, np.float64).reshape(-1, 3), tuple(tuple(face) for face in faces))


@lru_cache(maxsize=1)
def cube() -> Polygons:
    """Return a cube of side 1 around the origin."""
    points = [(x, y, z) for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)]
    return _made(points, [(0, 1, 3, 2), (2, 3, 7, 6), (6, 7, 5, 4), (4, 5, 1, 0), (2, 6, 4, 0), (7, 3, 1, 5)])


def grid(columns: int, rows: int) -> Polygons:
    """Return a square of side 1 in the plane of x and y, with faces in columns and rows."""
    xs, ys = np.linspace(-0.5, 0.5, columns + 1), np.linspace(-0.5, 0.5, rows + 1)
    wide = columns + 1
    faces = [
        (j * wide + i, j * wide + i + 1, (j + 1) * wide + i + 1, (j + 1) * wide + i)
        for j in range(rows)
        for i in range(columns)
    ]
    return _made([(x, y, 0.0) for y in ys for x in xs], faces)


def ring_points(count: int, radius: float, z: float) -> list[tuple[float, float, float]]:
    """Return corners around z, clockwise from +y, as cylinders have them."""
    angles = [2 * math.pi * i / count for i in range(count)]
    return [(radius * math.sin(a), radius * math.cos(a), z) for a in angles]


def cone(count: int, bottom: float, top: float, fill: str = "NGON") -> Polygons:
    """Return a frustum around z from -0.5 to 0.5; ``fill`` of the ends is NGON, TRIFAN or NOTHING."""
    if top == 0 or bottom == 0:
        return _pointed(count, bottom, top, fill)
    low, high = ring_points(count, bottom, -0.5), ring_points(count, top, 0.5)
    points = [point for pair in zip(low, high, strict=True) for point in pair]
    base = 0
    if fill == "TRIFAN":
        points, base = [(0.0, 0.0, -0.5), (0.0, 0.0, 0.5), *points], 2
    faces: list[Face] = []
    for i in range(count):
        a, b = base + 2 * i, base + 2 * ((i + 1) % count)
        if fill == "TRIFAN":
            faces += [(0, a, b), (1, b + 1, a + 1)]
        faces.append((a, a + 1, b + 1, b))
    if fill == "NGON":
        faces.append(tuple(2 * i + 1 for i in range(count))[::-1])
        faces.append(tuple(2 * i for i in range(count)))
    return _made(points, faces)


def _pointed(count: int, bottom: float, top: float, fill: str) -> Polygons:
    is_up = top == 0
    points = ring_points(count, bottom if is_up else top, -0.5 if is_up else 0.5)
    points.append((0.0, 0.0, 0.5 if is_up else -0.5))
    if fill == "TRIFAN":
        points.append((0.0, 0.0, -0.5 if is_up else 0.5))
    faces: list[Face] = []
    for i in range(count):
        j = (i + 1) % count
        faces.append((i, count, j) if is_up else (j, count, i))
        if fill == "TRIFAN":
            faces.append((count + 1, i, j) if is_up else (count + 1, j, i))
    if fill == "NGON":
        faces.append(tuple(range(count)) if is_up else tuple(range(count))[::-1])
    return _made(points, faces)


def circle(count: int, fill: str) -> Polygons:
    """Return a regular polygon of radius 1, counter-clockwise; without a fill it has no faces."""
    points = [(-math.sin(a), math.cos(a), 0.0) for a in (2 * math.pi * i / count for i in range(count))]
    if fill == "TRIFAN":
        return _made([(0.0, 0.0, 0.0), *points], [(0, i + 1, (i + 1) % count + 1) for i in range(count)])
    return _made(points, [tuple(range(count))] if fill == "NGON" else [])


def uv_sphere(segments: int, rings: int) -> Polygons:
    """Return a sphere of radius 1 of segments and rings.

    Blender spins a half circle, and merges the last one with the first: the corners of the first that are merged are
    the last of all. Which these are depends on rounding, and is measured (``corner_orders``).
    """
    tail = sphere_tail(segments, rings) or ()
    first = [(0, row) for row in range(rings + 1) if row not in tail]
    rows = [*first, *((column, row) for column in range(1, segments) for row in range(1, rings))]
    rows += [(0, row) for row in tail]
    place = {at: i for i, at in enumerate(rows)}
    points = []
    for column, row in rows:
        around, polar = 2 * math.pi * column / segments, math.pi * row / rings
        points.append((math.sin(polar) * math.sin(around), math.sin(polar) * math.cos(around), math.cos(polar)))
    at: Callable[[int, int], int] = lambda column, row: place[(column % segments if 0 < row < rings else 0), row]
    faces: list[Face] = []
    for i in range(segments):
        faces.append((at(0, 0), at(i + 1, 1), at(i, 1)))
        faces += [(at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)) for j in range(1, rings - 1)]
        faces.append((at(0, rings), at(i, rings - 1), at(i + 1, rings - 1)))
    return _made(points, faces)


_ICO = [
    (0, 1, 2), (1, 0, 5), (0, 2, 3), (0, 3, 4), (0, 4, 5), (1, 5, 10), (2, 1, 6), (3, 2, 7), (4, 3, 8), (5, 4, 9),
    (1, 10, 6), (2, 6, 7), (3, 7, 8), (4, 8, 9), (5, 9, 10), (6, 10, 11), (7, 6, 11), (8, 7, 11), (9, 8, 11),
    (10, 9, 11),
]  # fmt: skip


@lru_cache(maxsize=8)
def ico_sphere(subdivisions: int) -> Polygons:
    """Return a sphere of radius 1 of triangles: an icosahedron whose faces are divided evenly, then projected."""
    if subdivisions > 7:
        raise UnsupportedPython("this sphere has too many faces")
    a, z = 2 / math.sqrt(5), 1 / math.sqrt(5)
    low = [(a * math.cos(t), a * math.sin(t), -z) for t in (math.radians(-36 - 72 * i) for i in range(5))]
    high = [(a * math.cos(t), a * math.sin(t), z) for t in (math.radians(-72 * (i + 1)) for i in range(5))]
    corners = np.array([(0.0, 0.0, -1.0), *low, *high, (0.0, 0.0, 1.0)])
    count = 2 ** (subdivisions - 1)
    points, faces = _divided_icosahedron(corners, count)
    order = ico_order(subdivisions)
    if order is None:
        return _made(points, faces)
    place = np.argsort(order)
    return _made(points[list(order)], [[int(place[c]) for c in face] for face in faces])


def _divided_icosahedron(corners: FloatArray, count: int) -> tuple[FloatArray, list[Face]]:
    """Return the points (N, 3), on the unit sphere, and triangles of an icosahedron with ``count`` parts per edge."""
    points = list(corners)
    known: dict[tuple[tuple[int, int], ...], int] = {((i, count),): i for i in range(len(corners))}

    def point(*weights: tuple[int, int]) -> int:
        # corners of weight 0 are left out, so that both faces at an edge share its points
        key = tuple(sorted((corner, weight) for corner, weight in weights if weight))
        if key not in known:
            known[key] = len(points)
            inner = sum((corners[corner] * weight for corner, weight in key), np.zeros(3))
            points.append(inner / np.linalg.norm(inner))
        return known[key]

    faces: list[Face] = []
    for a, b, c in _ICO:
        rows = [[point((a, count - i - j), (b, i), (c, j)) for j in range(count + 1 - i)] for i in range(count + 1)]
        for i in range(count):
            for j in range(count - i):
                faces.append((rows[i][j], rows[i + 1][j], rows[i][j + 1]))
                if i + j < count - 1:
                    faces.append((rows[i + 1][j], rows[i + 1][j + 1], rows[i][j + 1]))
    return np.array(points), faces


def torus(major: float, minor: float, around: int, across: int) -> Polygons:
    """Return a torus around z."""
    points = []
    for i in range(around):
        a = 2 * math.pi * i / around
        for j in range(across):
            b = 2 * math.pi * j / across
            r = major + minor * math.cos(b)
            points.append((r * math.cos(a), r * math.sin(a), minor * math.sin(b)))
    at: Callable[[int, int], int] = lambda i, j: i % around * across + j % across
    faces = [(at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)) for i in range(around) for j in range(across)]
    return _made(points, faces)


# --- operations ------------------------------------------------------------------------------------------------------


def subdivided(mesh: Polygons, levels: int, *, on_limit: bool) -> Polygons:
    """Return the Catmull-Clark subdivision of a mesh, boundaries smoothed as Blender does by default.

    With ``on_limit`` the corners are on the limit surface, as those of the modifier are unless it says otherwise.
    """
    for _ in range(levels):
        mesh = _catmull_clark(mesh)
    return _on_limit(mesh) if on_limit and levels else mesh


def _on_limit(mesh: Polygons) -> Polygons:
    """Return a mesh of quads with its corners on the limit surface of its subdivision."""
    count = len(mesh.points)
    near, across = np.zeros((count, 3)), np.zeros((count, 3))
    valence, border, border_count = np.zeros(count), np.zeros((count, 3)), np.zeros(count)
    for (a, b), around in mesh.edges().items():
        for corner, other in ((a, b), (b, a)):
            near[corner] += mesh.points[other]
            valence[corner] += 1
            if len(around) != 2:
                border[corner] += mesh.points[other]
                border_count[corner] += 1
    faces = np.array(mesh.faces, np.int64).reshape(-1, 4)
    for i in range(4):
        np.add.at(across, faces[:, i], mesh.points[faces[:, (i + 2) % 4]])
    n = valence[:, None]
    points = (n * n * mesh.points + 4 * near + across) / np.where(n == 0, 1.0, n * (n + 5))
    edge = (4 * mesh.points + border) / 6
    points = np.where((border_count == 2)[:, None], edge, points)
    points = np.where(((border_count > 0) & (border_count != 2))[:, None], mesh.points, points)
    return Polygons(points, mesh.faces, mesh.materials)


def _catmull_clark(mesh: Polygons) -> Polygons:
    """Return a mesh after one step of Catmull-Clark subdivision (1978): one quad for each corner of a face."""
    points, faces = mesh.points, mesh.faces
    if 4 * sum(map(len, faces)) > MAX_CORNERS:
        raise UnsupportedPython("this subdivision has too many faces")
    edges = mesh.edges()
    number = {edge: i for i, edge in enumerate(edges)}
    centers = np.array([points[list(face)].mean(axis=0) for face in faces]).reshape(-1, 3)
    ends = np.array(list(edges), np.int64).reshape(-1, 2)
    middles = points[ends].mean(axis=1)
    # midpoints of boundary edges stay: the boundary becomes a cubic B-spline
    edge_points = middles.copy()
    is_inner = np.array([len(around) == 2 for around in edges.values()], bool)
    for i, around in enumerate(edges.values()):
        if len(around) == 2:
            edge_points[i] = (points[ends[i]].sum(axis=0) + centers[around].sum(axis=0)) / 4
    moved = _moved_corners(mesh, centers, ends, middles, is_inner)
    count = len(points)
    made: list[Face] = []
    slots: list[int] = []
    for j, face in enumerate(faces):
        for i, corner in enumerate(face):
            before, after = face[i - 1], face[(i + 1) % len(face)]
            left = count + number[min(before, corner), max(before, corner)]
            right = count + number[min(corner, after), max(corner, after)]
            made.append((corner, right, count + len(edges) + j, left))
            slots.append(mesh.slots()[j])
    return Polygons(np.concatenate([moved, edge_points, centers]), tuple(made), tuple(slots))


def _moved_corners(
    mesh: Polygons,
    centers: FloatArray,
    ends: npt.NDArray[np.int64],
    middles: FloatArray,
    is_inner: npt.NDArray[np.bool_],
) -> FloatArray:
    """Return the positions (N, 3) of the original corners after one step of Catmull-Clark subdivision."""
    count = len(mesh.points)
    face_sum, face_count = np.zeros((count, 3)), np.zeros(count)
    for center, face in zip(centers, mesh.faces, strict=True):
        face_sum[list(face)] += center
        face_count[list(face)] += 1
    edge_sum, edge_count = np.zeros((count, 3)), np.zeros(count)
    border_sum, border_count = np.zeros((count, 3)), np.zeros(count)
    for (a, b), middle, inner in zip(ends, middles, is_inner, strict=True):
        for corner in (a, b):
            edge_sum[corner] += middle
            edge_count[corner] += 1
            if not inner:
                border_sum[corner] += middle
                border_count[corner] += 1
    moved = mesh.points.copy()
    for i in range(count):
        if border_count[i]:
            # cubic B-spline along the boundary; a corner at which several boundaries meet stays
            if border_count[i] == 2 and face_count[i] > 0:
                moved[i] = (border_sum[i] + 2 * mesh.points[i]) / 4
        elif edge_count[i]:
            n = edge_count[i]
            moved[i] = (face_sum[i] / face_count[i] + 2 * edge_sum[i] / n + (n - 3) * mesh.points[i]) / n
    return moved


def split_faces(mesh: Polygons, cuts: int) -> Polygons:
    """Return a mesh of quads with every edge cut into ``cuts`` + 1 parts; other faces are kept as fans of quads."""
    if any(len(face) != 4 for face in mesh.faces):
        raise UnsupportedPython("only quads can be subdivided here")
    points: list[FloatArray] = list(mesh.points)
    along: dict[tuple[int, int], list[int]] = {}
    n = cuts + 1

    def between(a: int, b: int) -> list[int]:
        key = min(a, b), max(a, b)
        if key not in along:
            low, high = mesh.points[key[0]], mesh.points[key[1]]
            along[key] = list(range(len(points), len(points) + cuts))
            points.extend(low + (high - low) * (i + 1) / n for i in range(cuts))
        inner = along[key] if a < b else along[key][::-1]
        return [a, *inner, b]

    made: list[Face] = []
    slots: list[int] = []
    for face, slot in zip(mesh.faces, mesh.slots(), strict=True):
        a, b, c, d = face
        rows = [between(a, b)]
        left, right = between(a, d), between(b, c)
        for j in range(1, n):
            start, end = points[left[j]], points[right[j]]
            inner = list(range(len(points), len(points) + cuts))
            points.extend(start + (end - start) * (i + 1) / n for i in range(cuts))
            rows.append([left[j], *inner, right[j]])
        rows.append(between(d, c))
        for j in range(n):
            made += [(rows[j][i], rows[j][i + 1], rows[j + 1][i + 1], rows[j + 1][i]) for i in range(n)]
            slots += [slot] * n
    return Polygons(np.array(points), tuple(made), tuple(slots))


def solidified(mesh: Polygons, thickness: float, offset: float, *, has_rim: bool, is_even: bool) -> Polygons:
    """Return a surface with a thickness, as the modifier gives it."""
    normals = mesh.point_normals()
    if is_even:
        normals = _even_normals(mesh, normals)
    out = thickness * (offset + 1) / 2
    back = thickness * (offset - 1) / 2
    count = len(mesh.points)
    faces = list(mesh.faces) + [tuple(c + count for c in face[::-1]) for face in mesh.faces]
    slots = [*mesh.slots(), *mesh.slots()]
    points = np.concatenate([mesh.points + normals * out, mesh.points + normals * back])
    if has_rim:
        edges = mesh.edges()
        for face, slot in zip(mesh.faces, mesh.slots(), strict=True):
            for a, b in zip(face, (*face[1:], face[0]), strict=True):
                if len(edges[min(a, b), max(a, b)]) == 1:
                    faces.append((b, a, a + count, b + count))
                    slots.append(slot)
    made = Polygons(points, tuple(faces), tuple(slots))
    return made if thickness >= 0 else made.flipped()


def _even_normals(mesh: Polygons, normals: FloatArray) -> FloatArray:
    """Scale the normals of corners so that the faces are a thickness apart."""
    sums, counts = np.zeros(len(normals)), np.zeros(len(normals))
    for face, normal in zip(mesh.faces, mesh.face_normals(), strict=True):
        for corner in face:
            sums[corner] += float(normal @ normals[corner])
            counts[corner] += 1
    means = sums / np.where(counts == 0, 1, counts)
    return normals / np.where(means < 0.1, 1.0, means)[:, None]


def without_loose(mesh: Polygons) -> Polygons:
    """Return the mesh without corners that no face uses."""
    return mesh.part(range(len(mesh.faces)))


def bisected(mesh: Polygons, keep: Callable[[FloatArray], FloatArray]) -> Polygons:
    """Return the part of a mesh where a linear function of points is not negative."""
    values = keep(mesh.points)
    points = list(mesh.points)
    cut: dict[tuple[int, int], int] = {}
    faces: list[Face] = []
    slots: list[int] = []
    for face, slot in zip(mesh.faces, mesh.slots(), strict=True):
        made: list[int] = []
        for a, b in zip(face, (*face[1:], face[0]), strict=True):
            if values[a] >= -1e-9:
                made.append(a)
            if (values[a] > 1e-9 and values[b] < -1e-9) or (values[a] < -1e-9 and values[b] > 1e-9):
                key = min(a, b), max(a, b)
                if key not in cut:
                    share = values[key[0]] / (values[key[0]] - values[key[1]])
                    cut[key] = len(points)
                    points.append(mesh.points[key[0]] + share * (mesh.points[key[1]] - mesh.points[key[0]]))
                made.append(cut[key])
        if len(made) >= 3 and any(values[c] > 1e-9 for c in face):
            faces.append(tuple(made))
            slots.append(slot)
    return without_loose(Polygons(np.array(points).reshape(-1, 3), tuple(faces), tuple(slots)))
