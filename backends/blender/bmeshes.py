"""`bmesh`: meshes that scripts edit corner by corner, and its operators that have a counterpart."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.blender import polygons
from scenelang.backends.blender.blend_model import Blend, MeshBlock, Object
from scenelang.backends.blender.pieces import MeshPiece, PieceForm, polygons_of
from scenelang.backends.blender.polygons import MAX_CORNERS, Polygons
from scenelang.backends.blender.vectors import VectorValue, matrix_of
from scenelang.interpreter.transpile.evaluation import UnsupportedPython, words
from scenelang.interpreter.transpile.evaluation.objects import MISSING, HostObject, Module, Native

FloatArray = npt.NDArray[np.float64]


class Corner(HostObject):
    """Vertex of a bmesh."""

    python_name = "BMVert"
    shown = frozenset(words("co index normal is_valid link_faces link_edges select select_set"))

    def __init__(self, mesh: EditMesh, point: Iterable[float]) -> None:
        self._mesh = mesh
        self.co = VectorValue(point)
        self.index = -1
        self.select = False
        self.is_valid = True

    def assign(self, name: str, value: Any) -> None:
        if name == "co":
            self.co.set(value)
        elif name in ("select", "index", "hide", "tag"):
            if name in ("select", "index"):
                setattr(self, name, value)
        elif name == "normal":
            pass
        else:
            super().assign(name, value)

    def select_set(self, state: bool) -> None:
        """Select it."""
        self.select = state

    @property
    def normal(self) -> VectorValue:
        """Return the normal."""
        mesh, place = self._mesh.polygons()
        return VectorValue(mesh.point_normals()[place[id(self)]])

    @property
    def link_faces(self) -> list[Side]:
        """Return the faces at it."""
        return [face for face in self._mesh.sides if any(corner is self for corner in face.verts)]

    @property
    def link_edges(self) -> list[Border]:
        """Return the edges at it."""
        return [edge for edge in self._mesh.borders() if any(corner is self for corner in edge.verts)]

    def __getitem__(self, layer: Any) -> Any:
        return 0.0

    def __setitem__(self, layer: Any, value: Any) -> None:
        """Layers mean nothing."""


class Side(HostObject):
    """Face of a bmesh."""

    python_name = "BMFace"
    shown = frozenset(
        words(
            "verts normal index material_index smooth is_valid select calc_center_median calc_area edges loops "
            "select_set normal_flip normal_update calc_center_bounds"
        )
    )

    def __init__(self, mesh: EditMesh, verts: Sequence[Corner], slot: int = 0, smooth: bool = False) -> None:
        self._mesh, self.verts = mesh, list(verts)
        self.material_index, self.smooth, self.index = slot, smooth, -1
        self.select, self.is_valid = False, True
        self.loops = ()
        # Normals are those of the last update, as in Blender: of a new face (0, 0, 0).
        self._normal = VectorValue()

    def assign(self, name: str, value: Any) -> None:
        if name in ("material_index", "smooth", "select", "index"):
            setattr(self, name, value)
        elif name not in ("hide", "tag"):
            super().assign(name, value)

    def select_set(self, state: bool) -> None:
        """Select it."""
        self.select = state

    def points(self) -> FloatArray:
        """Return the corners as an array."""
        return np.array([corner.co.values for corner in self.verts])

    @property
    def normal(self) -> VectorValue:
        """Return the normal of the last update."""
        return self._normal.copy()  # type: ignore[no-any-return]

    def normal_update(self) -> None:
        """Compute the normal."""
        self._normal = VectorValue(Polygons(self.points(), (tuple(range(len(self.verts))),)).face_normals()[0])

    def normal_forget(self) -> None:
        """Leave the normal to the next update."""
        self._normal = VectorValue()

    def normal_flip(self) -> None:
        """Turn it around."""
        self.verts.reverse()
        self._normal = -self._normal

    def calc_center_median(self) -> VectorValue:
        """Return the mean of the corners."""
        return VectorValue(self.points().mean(axis=0))

    def calc_center_bounds(self) -> VectorValue:
        """Return the middle of the box."""
        return VectorValue((self.points().min(axis=0) + self.points().max(axis=0)) / 2)

    def calc_area(self) -> float:
        """Return the area."""
        points = self.points()
        return float(np.linalg.norm(np.cross(points, np.roll(points, -1, axis=0)).sum(axis=0)) / 2)

    @property
    def edges(self) -> list[Border]:
        """Return the edges."""
        return [Border(self._mesh, pair) for pair in zip(self.verts, (*self.verts[1:], self.verts[0]), strict=True)]


class Border(HostObject):
    """Edge of a bmesh."""

    python_name = "BMEdge"
    shown = frozenset(
        words("verts calc_length is_boundary link_faces select index calc_face_angle other_vert select_set")
    )

    def __init__(self, mesh: EditMesh, verts: Iterable[Corner]) -> None:
        self._mesh, self.verts = mesh, tuple(verts)
        self.select, self.index = False, -1

    def assign(self, name: str, value: Any) -> None:
        """Marks of edges mean nothing."""

    def select_set(self, state: bool) -> None:
        """Select it."""

    def other_vert(self, vert: Any) -> Any:
        """Return the other end."""
        return self.verts[1] if self.verts[0] is vert else self.verts[0]

    @property
    def link_faces(self) -> list[Side]:
        """Return the faces at it."""
        return [f for f in self._mesh.sides if all(any(corner is v for corner in f.verts) for v in self.verts)]

    @property
    def is_boundary(self) -> bool:
        """Return whether it has one face."""
        return len(self.link_faces) == 1

    def calc_length(self) -> float:
        """Return the length."""
        return (self.verts[0].co - self.verts[1].co).length

    def calc_face_angle(self, fallback: Any = 0.0) -> Any:
        """Return the angle between the two faces."""
        faces = self.link_faces
        return faces[0].normal.angle(faces[1].normal) if len(faces) == 2 else fallback


class _Sequence(HostObject):
    """Corners, edges or faces of a bmesh."""

    python_name = "BMElemSeq"
    shown = frozenset(words("new remove ensure_lookup_table index_update layers active sort get"))

    def __init__(self, mesh: EditMesh, items: list[Any]) -> None:
        self.mesh, self._items = mesh, items
        self.active = None

    layers = property(lambda self: _Layers())

    def ensure_lookup_table(self) -> None:
        """Number the elements."""
        for i, item in enumerate(self._items):
            item.index = i

    index_update = ensure_lookup_table

    def sort(self, **_: Any) -> None:
        """Sort the elements."""
        raise UnsupportedPython("`sort` of a bmesh is not supported")

    def __iter__(self) -> Iterator[Any]:
        return iter(list(self._items))

    def __len__(self) -> int:
        return len(self._items)

    def __getitem__(self, index: Any) -> Any:
        self.ensure_lookup_table()
        return self._items[index]

    def __contains__(self, item: Any) -> bool:
        return any(each is item for each in self._items)


class _Layers(HostObject):
    """Layers of a bmesh, which mean nothing."""

    def read(self, name: str) -> Any:
        return Native(name, lambda *_: _Layers()) if name in ("new", "verify", "get") else _Layers()


class Corners(_Sequence):
    """Vertices of a bmesh."""

    def new(self, co: Any = (0.0, 0.0, 0.0), example: Any = None) -> Corner:
        """Add a vertex."""
        made = Corner(self.mesh, [*co])
        made.index = -1
        self.mesh.add_corner(made)
        return made

    def remove(self, corner: Corner) -> None:
        """Remove a vertex with its faces."""
        self.mesh.remove_corners([corner])


class Sides(_Sequence):
    """Faces of a bmesh."""

    def new(self, verts: Any, example: Any = None) -> Side:
        """Add a face."""
        corners = [*verts]
        if len(corners) < 3:
            raise ValueError("faces.new(...): sequence must have at least 3 vertices")
        if len(set(map(id, corners))) != len(corners):
            raise ValueError("faces.new(verts): found the same (BMVert) used multiple times")
        key = frozenset(map(id, corners))
        if key in self.mesh.face_keys():
            raise ValueError("faces.new(verts): face already exists")
        made = Side(self.mesh, corners)
        self.mesh.add_side(made)
        return made

    def get(self, verts: Any, fallback: Any = None) -> Any:
        """Return the face of some corners."""
        key = frozenset(map(id, verts))
        return next((f for f in self.mesh.sides if frozenset(map(id, f.verts)) == key), fallback)

    def remove(self, side: Side) -> None:
        """Remove a face."""
        self.mesh.remove_sides([side])


class Borders(_Sequence):
    """Edges of a bmesh."""

    def new(self, verts: Any, example: Any = None) -> Border:
        """Add an edge without a face, which a scene cannot show."""
        return Border(self.mesh, verts)

    def get(self, verts: Any, fallback: Any = None) -> Any:
        """Return the edge between two corners."""
        return Border(self.mesh, verts)


class EditMesh(HostObject):
    """Mesh of `bmesh.new()`."""

    python_name = "BMesh"
    shown = frozenset(
        words(
            "verts faces edges free clear from_mesh to_mesh normal_update calc_volume transform copy from_object "
            "select_flush select_mode is_valid loops select_flush_mode"
        )
    )
    is_valid, loops = True, ()

    def __init__(self, blend: Blend) -> None:
        self.blend = blend
        self.corners: list[Corner] = []
        self.sides: list[Side] = []
        self._keys: set[frozenset[int]] | None = set()
        self.pieces: list[MeshPiece] | None = []  # what it is made of, until a script edits it
        self._sources: list[MeshPiece] = []  # pieces whose corners it has
        self.select_mode: Any = {"VERT"}

    def assign(self, name: str, value: Any) -> None:
        if name != "select_mode":
            super().assign(name, value)

    verts = property(lambda self: Corners(self, self.corners))
    faces = property(lambda self: Sides(self, self.sides))
    edges = property(lambda self: Borders(self, self.borders()))

    def add_corner(self, corner: Corner) -> None:
        """Add a vertex."""
        if len(self.corners) >= MAX_CORNERS:
            raise UnsupportedPython("this mesh has too many vertices")
        self.pieces = None
        self.corners.append(corner)

    def add_side(self, side: Side) -> None:
        """Add a face."""
        self.pieces = None
        self.sides.append(side)
        if self._keys is not None:
            self._keys.add(frozenset(map(id, side.verts)))

    def face_keys(self) -> set[frozenset[int]]:
        """Return the sets of corners of the faces."""
        if self._keys is None:
            self._keys = {frozenset(map(id, side.verts)) for side in self.sides}
        return self._keys

    def forget_keys(self) -> None:
        """Forget which faces there are, because one has other corners."""
        self.pieces = self._keys = None

    def borders(self) -> list[Border]:
        """Return the edges."""
        edges: dict[frozenset[int], Border] = {}
        for side in self.sides:
            for pair in zip(side.verts, (*side.verts[1:], side.verts[0]), strict=True):
                edges.setdefault(frozenset(map(id, pair)), Border(self, pair))
        self.blend.tick(len(edges))
        return list(edges.values())

    def polygons(self) -> tuple[Polygons, dict[int, int]]:
        """Return the mesh, and the number of every corner."""
        place = {id(corner): i for i, corner in enumerate(self.corners)}
        points = np.array([corner.co.values for corner in self.corners]).reshape(-1, 3)
        faces = tuple(tuple(place[id(corner)] for corner in side.verts) for side in self.sides)
        self.blend.tick(len(points) + len(faces))
        return Polygons(points, faces, tuple(int(side.material_index) for side in self.sides)), place

    def replace(self, mesh: Polygons, smooth: bool = False) -> None:
        """Replace everything by polygons, keeping corners by their numbers."""
        self.pieces = None
        for i, point in enumerate(mesh.points[: len(self.corners)]):
            self.corners[i].co.set(point)
        self.corners[len(mesh.points) :] = []
        self.corners += [Corner(self, point.tolist()) for point in mesh.points[len(self.corners) :]]
        self.sides[:] = [
            Side(self, [self.corners[c] for c in face], slot, smooth)
            for face, slot in zip(mesh.faces, mesh.slots(), strict=True)
        ]
        self._keys = None

    def extend(self, mesh: Polygons, piece: MeshPiece | None, *, is_loaded: bool = False) -> list[Corner]:
        """Add polygons, which are a piece until they are edited; return the new corners."""
        if piece is not None:
            self._sources.append(piece)
        has_normals = piece is None or piece.form is None or piece.form.kind not in ("plane", "ico") or is_loaded
        kept = [*self.pieces, piece] if self.pieces is not None and piece is not None else None
        made = [Corner(self, point.tolist()) for point in mesh.points]
        self.corners += made
        self.sides += [
            Side(self, [made[c] for c in face], slot) for face, slot in zip(mesh.faces, mesh.slots(), strict=True)
        ]
        if has_normals:
            for side in self.sides[-len(mesh.faces) :] if mesh.faces else ():
                side.normal_update()
        self._keys = None
        self.blend.tick(len(mesh.points))
        self.pieces = kept
        return made

    def remove_corners(self, chosen: Sequence[Corner]) -> None:
        """Remove vertices with their faces."""
        self.pieces, self._keys = None, None
        gone = set(map(id, chosen))
        for corner in chosen:
            corner.is_valid = False
        self.corners[:] = [corner for corner in self.corners if id(corner) not in gone]
        self.sides[:] = [side for side in self.sides if not any(id(corner) in gone for corner in side.verts)]

    def remove_sides(self, chosen: Sequence[Side]) -> None:
        """Remove faces."""
        self.pieces, self._keys = None, None
        gone = set(map(id, chosen))
        self.sides[:] = [side for side in self.sides if id(side) not in gone]

    # --- methods of scripts

    def free(self) -> None:
        """Do nothing."""

    def select_flush(self, *_: Any) -> None:
        """Do nothing."""

    select_flush_mode = select_flush

    def normal_update(self) -> None:
        """Compute all normals."""
        for side in self.sides:
            side.normal_update()

    def clear(self) -> None:
        """Remove everything."""
        self.corners.clear()
        self.sides.clear()
        self.pieces, self._keys = [], set()

    def from_mesh(self, mesh: MeshBlock, **_: Any) -> None:
        """Add a mesh."""
        pieces = mesh.settled()
        for piece in pieces:
            first = len(self.sides)
            self.extend(piece.polygons(), piece, is_loaded=True)
            for side in self.sides[first:]:
                side.smooth = piece.is_smooth

    def from_object(self, obj: Object, depsgraph: Any = None, **_: Any) -> None:
        """Add the mesh of an object with its modifiers."""
        made = polygons_of(self.blend.evaluated(obj))
        self.extend(made, None)

    def to_mesh(self, mesh: MeshBlock) -> None:
        """Give a mesh this geometry."""
        made, _ = self.polygons()
        smooth = bool(self.sides) and all(side.smooth for side in self.sides)
        if self.pieces and np.allclose(polygons_of(self.pieces).points, made.points, atol=1e-9):
            mesh.become(polygons.EMPTY)
            from dataclasses import replace

            mesh.pieces = [replace(piece, is_smooth=smooth) for piece in self.pieces]
        else:
            self.blend.check_order(self._sources)
            mesh.become(made, smooth)

    def calc_volume(self, signed: bool = False) -> float:
        """Return the volume."""
        volume = self.polygons()[0].volume()
        return volume if signed else abs(volume)

    def transform(self, matrix: Any, **_: Any) -> None:
        """Move everything."""
        _moved(self.corners, matrix.to_4x4().numbers)

    def copy(self) -> EditMesh:
        """Return a copy."""
        made = EditMesh(self.blend)
        made.extend(self.polygons()[0], None)
        return made


def _moved(corners: Iterable[Corner], matrix: FloatArray) -> None:
    for corner in corners:
        corner.co.set(matrix[:3, :3] @ corner.co.array() + matrix[:3, 3])


class BmeshOperators:
    """`bmesh.ops`."""

    def __init__(self, blend: Blend) -> None:
        self.blend = blend

    def _created(self, bm: EditMesh, form: PieceForm, sizes: Sequence[float], matrix: Any) -> dict[str, Any]:
        linear = np.diag([*sizes, 1.0])
        piece = MeshPiece((matrix.to_4x4().numbers if matrix is not None else np.eye(4)) @ linear, form)
        return {"verts": bm.extend(piece.polygons(), piece)}

    def create_cube(self, bm: EditMesh, size: float = 1.0, matrix: Any = None, calc_uvs: bool = False) -> Any:
        """Add a cube."""
        return self._created(bm, PieceForm("cube"), [size] * 3, matrix)

    def create_grid(
        self, bm: EditMesh, x_segments: int = 1, y_segments: int = 1, size: float = 1.0, matrix: Any = None,
        calc_uvs: bool = False,
    ) -> Any:  # fmt: skip
        """Add a square of many faces, whose half side is ``size``."""
        return self._created(bm, PieceForm("plane", (max(1, x_segments), max(1, y_segments))), [2 * size] * 3, matrix)

    def create_uvsphere(
        self, bm: EditMesh, u_segments: int = 32, v_segments: int = 16, radius: float = 1.0, matrix: Any = None,
        calc_uvs: bool = False,
    ) -> Any:  # fmt: skip
        """Add a sphere."""
        return self._created(bm, PieceForm("sphere", (u_segments, v_segments)), [radius] * 3, matrix)

    def create_icosphere(
        self, bm: EditMesh, subdivisions: int = 2, radius: float = 1.0, matrix: Any = None, calc_uvs: bool = False
    ) -> Any:
        """Add a sphere of triangles."""
        return self._created(bm, PieceForm("ico", (subdivisions,)), [radius] * 3, matrix)

    def create_cone(
        self, bm: EditMesh, cap_ends: bool = False, cap_tris: bool = False, segments: int = 32, radius1: float = 1.0,
        radius2: float = 0.0, depth: float = 2.0, matrix: Any = None, calc_uvs: bool = False,
    ) -> Any:  # fmt: skip
        """Add a cone, a frustum or a cylinder."""
        largest = max(radius1, radius2) or 1.0
        fill = ("TRIFAN" if cap_tris else "NGON") if cap_ends else "NOTHING"
        form = PieceForm("cone", (segments,), (radius1 / largest, radius2 / largest), fill)
        return self._created(bm, form, [largest, largest, depth], matrix)

    def create_circle(
        self, bm: EditMesh, cap_ends: bool = False, cap_tris: bool = False, segments: int = 32, radius: float = 1.0,
        matrix: Any = None, calc_uvs: bool = False,
    ) -> Any:  # fmt: skip
        """Add a disk."""
        fill = ("TRIFAN" if cap_tris else "NGON") if cap_ends else "NOTHING"
        return self._created(bm, PieceForm("circle", (segments,), fill=fill), [radius] * 3, matrix)

    def translate(self, bm: EditMesh, vec: Any = (0, 0, 0), space: Any = None, verts: Any = (), **_: Any) -> None:
        """Move vertices."""
        for corner in verts:
            corner.co.set(corner.co.array() + np.array([*vec]))

    def scale(self, bm: EditMesh, vec: Any = (1, 1, 1), space: Any = None, verts: Any = (), **_: Any) -> None:
        """Scale vertices."""
        matrix = np.diag([*vec, 1.0])
        if space is not None:
            frame = space.to_4x4().numbers
            matrix = np.linalg.inv(frame) @ matrix @ frame
        _moved(verts, matrix)

    def rotate(
        self, bm: EditMesh, cent: Any = (0, 0, 0), matrix: Any = None, verts: Any = (), space: Any = None, **_: Any
    ) -> None:
        """Rotate vertices about a point."""
        turn, center = matrix_of(matrix)[:3, :3], np.array([*cent])
        for corner in verts:
            corner.co.set(turn @ (corner.co.array() - center) + center)

    def transform(self, bm: EditMesh, matrix: Any = None, space: Any = None, verts: Any = (), **_: Any) -> None:
        """Move vertices by a matrix."""
        _moved(verts, matrix.to_4x4().numbers)

    def extrude_face_region(self, bm: EditMesh, geom: Any = (), **_: Any) -> Any:
        """Extrude faces as one region; the old faces stay, turned around if no other faces are around the region."""
        chosen = [item for item in geom if isinstance(item, Side)]
        if not chosen:
            raise UnsupportedPython("only faces can be extruded here", "extrude faces, or add them with `faces.new`")
        _check_alive(bm, chosen)
        inside = set(map(id, chosen))
        around: dict[frozenset[int], list[Side]] = {}
        for side in bm.sides:
            for edge in _edges_of(side):
                around.setdefault(frozenset(map(id, edge)), []).append(side)
        place: dict[int, Corner] = {}
        for corner in (corner for side in chosen for corner in side.verts):
            if id(corner) not in place:
                place[id(corner)] = Corner(bm, corner.co.values)
                bm.add_corner(place[id(corner)])
        walls: list[Side] = []
        has_neighbors = False
        for side in chosen:
            for a, b in _edges_of(side):
                others = around[frozenset((id(a), id(b)))]
                has_neighbors |= any(id(other) not in inside for other in others)
                if sum(id(other) in inside for other in others) == 1:
                    walls.append(Side(bm, [a, b, place[id(b)], place[id(a)]], side.material_index, side.smooth))
        made = [Side(bm, [place[id(c)] for c in side.verts], side.material_index, side.smooth) for side in chosen]
        if not has_neighbors:
            for side in chosen:
                side.normal_flip()
        for side in chosen:
            side.normal_forget()
        for side in (*walls, *made):
            bm.add_side(side)
        return {"geom": [*place.values(), *made]}

    def extrude_discrete_faces(self, bm: EditMesh, faces: Any = (), **_: Any) -> Any:
        """Extrude faces one by one."""
        made = []
        for face in faces:
            made += [item for item in self.extrude_face_region(bm, [face])["geom"] if isinstance(item, Side)]
            bm.remove_sides([face])
        return {"faces": made}

    def inset_region(
        self, bm: EditMesh, faces: Any = (), thickness: float = 0.0, depth: float = 0.0, use_even_offset: bool = False,
        **named: Any,
    ) -> Any:  # fmt: skip
        """Inset one face; return the faces around it."""
        if len([*faces]) != 1 or named.get("use_outset") or named.get("use_relative_offset"):
            raise UnsupportedPython("`inset_region` of several faces is not supported", "use `inset_individual`")
        made = self.inset_individual(bm, faces, thickness, depth, use_even_offset)
        for side in (*faces, *made["faces"]):
            side.normal_forget()
        return made

    def inset_individual(
        self, bm: EditMesh, faces: Any = (), thickness: float = 0.0, depth: float = 0.0, use_even_offset: bool = False,
        **named: Any,
    ) -> Any:  # fmt: skip
        """Inset faces one by one, which stay the inner ones; return the faces around them."""
        made = []
        _check_alive(bm, faces)
        for face in faces:
            points, normal = face.points(), face.normal.array()
            inner = _inset(points, normal, thickness, is_even=use_even_offset) + normal * depth
            corners = [Corner(bm, point.tolist()) for point in inner]
            for corner in corners:
                bm.add_corner(corner)
            ring = list(face.verts)
            face.verts[:] = corners
            bm.forget_keys()
            for i in range(len(ring)):
                j = (i + 1) % len(ring)
                side = Side(bm, [ring[i], ring[j], corners[j], corners[i]], face.material_index, face.smooth)
                side.normal_update()
                bm.add_side(side)
                made.append(side)
        return {"faces": made}

    def remove_doubles(self, bm: EditMesh, verts: Any = (), dist: float = 0.0, **_: Any) -> None:
        """Merge vertices."""
        mesh, _place = bm.polygons()
        welded = mesh.welded(dist)
        if len(welded.points) < len(mesh.points):
            bm.replace(welded)

    def recalc_face_normals(self, bm: EditMesh, faces: Any = (), **_: Any) -> None:
        """Turn all faces outwards."""
        pieces = bm.pieces
        made = bm.polygons()[0].oriented()
        for side, face in zip(bm.sides, made.faces, strict=True):
            turned = [bm.corners[c] for c in face]
            if turned[0] is not side.verts[0] or turned[1] is not side.verts[1]:
                side.verts = turned
                side._normal = -side._normal
        bm.pieces = pieces if pieces and all(piece.form is not None for piece in pieces) else None

    def reverse_faces(self, bm: EditMesh, faces: Any = (), **_: Any) -> None:
        """Turn faces around."""
        bm.pieces = None
        for face in faces:
            face.normal_flip()

    def delete(self, bm: EditMesh, geom: Any = (), context: str = "VERTS") -> None:
        """Delete vertices or faces."""
        items = [*geom]
        _check_alive(bm, items)
        if context == "VERTS":
            bm.remove_corners([item for item in items if isinstance(item, Corner)])
        elif context in ("FACES_ONLY", "FACES", "FACES_KEEP_BOUNDARY"):
            bm.remove_sides([item for item in items if isinstance(item, Side)])
        else:
            raise UnsupportedPython(f"`bmesh.ops.delete` of {context} is not supported")

    def subdivide_edges(
        self, bm: EditMesh, edges: Any = (), cuts: int = 1, use_grid_fill: bool = False, **named: Any
    ) -> None:
        """Cut all faces of a mesh of quads."""
        if len([*edges]) != len(bm.borders()) or named.get("smooth") or named.get("fractal") or not use_grid_fill:
            raise UnsupportedPython(
                "only a `subdivide_edges` of all edges of quads, with `use_grid_fill`, is supported"
            )
        bm.replace(polygons.split_faces(bm.polygons()[0], cuts))

    def contextual_create(self, bm: EditMesh, geom: Any = (), **_: Any) -> Any:
        """Add a face of vertices in their order."""
        corners = [item for item in geom if isinstance(item, Corner)]
        made = Side(bm, corners)
        bm.add_side(made)
        return {"faces": [made]}

    def duplicate(self, bm: EditMesh, geom: Any = (), **_: Any) -> Any:
        """Duplicate faces."""
        sides = [item for item in geom if isinstance(item, Side)]
        place: dict[int, Corner] = {}
        for side in sides:
            for corner in side.verts:
                if id(corner) not in place:
                    place[id(corner)] = Corner(bm, corner.co.values)
                    bm.add_corner(place[id(corner)])
        made = [Side(bm, [place[id(c)] for c in side.verts], side.material_index) for side in sides]
        for side in made:
            bm.add_side(side)
        return {"geom": [*place.values(), *made]}

    def triangulate(self, bm: EditMesh, faces: Any = (), **_: Any) -> Any:
        """Keep the faces: their triangles have the same shape."""
        return {"faces": [*faces], "edges": []}


def _check_alive(bm: EditMesh, items: Any) -> None:
    """Raise ReferenceError for faces and corners that are no longer in a mesh."""
    alive = {*map(id, bm.sides), *map(id, bm.corners)}
    for item in items:
        if isinstance(item, (Corner, Side)) and id(item) not in alive:
            raise ReferenceError(f"BMesh data of type {item.python_name} has been removed")


def _edges_of(side: Side) -> list[tuple[Corner, Corner]]:
    return list(zip(side.verts, (*side.verts[1:], side.verts[0]), strict=True))


def _inset(points: FloatArray, normal: FloatArray, thickness: float, *, is_even: bool) -> FloatArray:
    """Return a polygon with its corners, or evenly its edges, moved inwards by a distance."""
    made = np.zeros_like(points)
    count = len(points)
    for i in range(count):
        back, ahead = points[i] - points[i - 1], points[(i + 1) % count] - points[i]
        a, b = (np.cross(normal, edge / np.linalg.norm(edge)) for edge in (back, ahead))
        inwards = (a + b) / (max(1 + float(a @ b), 1e-9) if is_even else max(float(np.linalg.norm(a + b)), 1e-9))
        made[i] = points[i] + inwards * thickness
    return made


class _Operators(HostObject):
    """`bmesh.ops`: operators by name."""

    python_name = "bmesh.ops"

    def __init__(self, blend: Blend) -> None:
        self._known = BmeshOperators(blend)

    def read(self, name: str) -> Any:
        if name.startswith("_"):
            return MISSING
        method = getattr(self._known, name, None)
        if method is not None:
            return Native(f"bmesh.ops.{name}", method)

        def refuse(*_: Any, **__: Any) -> Any:
            raise UnsupportedPython(f"`bmesh.ops.{name}` is not supported", "build the faces with `faces.new`")

        return Native(f"bmesh.ops.{name}", refuse)


def bmesh_module(blend: Blend) -> Module:
    """Return the module `bmesh`."""

    def from_edit_mesh(mesh: MeshBlock) -> EditMesh:
        made = EditMesh(blend)
        made.from_mesh(mesh)
        blend.edit = made, mesh
        return made

    def update_edit_mesh(mesh: MeshBlock, **_: Any) -> None:
        if blend.edit is not None and blend.edit[1] is mesh:
            blend.edit[0].to_mesh(mesh)

    types = {"BMVert": Corner, "BMFace": Side, "BMEdge": Border, "BMesh": EditMesh}
    names: dict[str, Any] = {
        "new": Native("bmesh.new", lambda use_operators=True: EditMesh(blend)),
        "from_edit_mesh": Native("bmesh.from_edit_mesh", from_edit_mesh),
        "update_edit_mesh": Native("bmesh.update_edit_mesh", update_edit_mesh),
        "ops": _Operators(blend),
        "types": Module(
            "bmesh.types", {name: Native(f"bmesh.types.{name}", kind, kind) for name, kind in types.items()}
        ),
    }
    return Module("bmesh", names)
