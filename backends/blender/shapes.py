"""Pieces of meshes as expressions of the Scene Language, and the helpers that converted programs define for them."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from scenelang.backends.blender.modifiers import as_box
from scenelang.backends.blender.pieces import BooleanPiece, MeshPiece, PieceForm
from scenelang.backends.blender.polygons import Polygons, combined, ico_sphere, solidified
from scenelang.backends.blender.vectors import Quaternion, quaternion_of
from scenelang.interpreter.transpile.evaluation import UnsupportedPython

FloatArray = npt.NDArray[np.float64]

# Blender's z is up, and a scene's y: (x, y, z) becomes (x, z, -y).
UPRIGHT = np.array([[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, -1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]])
_LATHE_SEGMENTS = 128  # of bodies of revolution that stand for curved ones: their volume is within .05 %
_PLATE = 1e-4  # thickness of what is flat in Blender, of its largest extent

HELPERS = {
    "prism": """
(define (prism sides bottom top height . look)
  "A frustum of a regular polygon around y, with a corner towards -z, centered at the origin."
  (define (corner i radius y)
    (define angle (/ (* tau i) sides))
    [(* radius (sin angle)) y (* -1 radius (cos angle))])
  (define low (for/list ((i (iota sides))) (corner i bottom (/ height -2))))
  (define high (if (= top 0) (list [0 (/ height 2) 0]) (for/list ((i (iota sides))) (corner i top (/ height 2)))))
  (define walls
    (for/list ((i (iota sides)))
      (define next (% (+ i 1) sides))
      (if (= top 0) (list i sides next) (list i (+ sides i) (+ sides next) next))))
  (define lid (if (= top 0) '() (list (reverse (iota sides sides)))))
  (apply mesh (append low high) (append walls (list (iota sides)) lid) look))""",
    "beveled-box": """
(define (beveled-box sizes width segments . look)
  "A box with edges that are beveled by `segments` faces, or rounded by many."
  (define inner (- (/ (* sizes [1 1 1]) 2) width))
  (define angles (for/list ((i (iota (+ segments 1)))) (/ (* pi i) (* 2 segments))))
  (define levels
    (append (map (lambda (a) (list (* width (cos a)) (- (* -1 (y-of inner)) (* width (sin a))))) (reverse angles))
            (map (lambda (a) (list (* width (cos a)) (+ (y-of inner) (* width (sin a))))) angles)))
  (define (level radius y)
    (for*/list (((q (sx sz)) (enumerate '((1 -1) (-1 -1) (-1 1) (1 1)))) (a angles))
      (define turn (+ a (/ (* pi q) 2)))
      [(+ (* sx (x-of inner)) (* radius (cos turn))) y (- (* sz (z-of inner)) (* radius (sin turn)))]))
  (define wide (* 4 (+ segments 1)))
  (define points (for/append (((radius y) levels)) (level radius y)))
  (define walls
    (for*/list ((j (iota (- (length levels) 1))) (i (iota wide)))
      (define next (% (+ i 1) wide))
      (list (+ (* j wide) i) (+ (* j wide) next) (+ (* (+ j 1) wide) next) (+ (* (+ j 1) wide) i))))
  (define lids (list (reverse (iota wide)) (iota wide (* wide (- (length levels) 1)))))
  (apply mesh points (append walls lids) look))""",
}


def number(value: float) -> str:
    """Return a number as text, to six digits."""
    text = f"{value:.6g}" if abs(value) >= 1e-9 else "0"
    return "0" if text == "-0" else text


def vector(values: Iterable[float]) -> str:
    """Return an array as text."""
    return f"[{' '.join(number(float(value)) for value in values)}]"


def upright(matrix: FloatArray) -> FloatArray:
    """Return a matrix of Blender's axes as one of a scene's."""
    made: FloatArray = UPRIGHT @ matrix @ UPRIGHT.T
    return made


def angle_text(angle: float) -> str:
    """Return an angle as text: degrees where they are few digits."""
    degrees = math.degrees(angle)
    if abs(degrees - round(degrees, 2)) < 1e-5:
        return f"(deg {number(round(degrees, 2))})"
    return number(angle)


def rigid(matrix: FloatArray) -> tuple[FloatArray, FloatArray] | None:
    """Return a rigid motion and sizes whose product is a matrix, or None if it shears; reflections are in the sizes."""
    linear = matrix[:3, :3]
    sizes = np.linalg.norm(linear, axis=0)
    largest = float(sizes.max())
    if largest == 0:
        return None
    axes = linear / np.where(sizes > largest * 1e-12, sizes, 1.0)
    flat = np.flatnonzero(sizes <= largest * 1e-12)
    if len(flat) == 1:
        i = int(flat[0])
        axes[:, i] = np.cross(axes[:, (i + 1) % 3], axes[:, (i + 2) % 3])
    elif len(flat) > 1:
        return None
    if not np.allclose(axes.T @ axes, np.eye(3), atol=2e-5):
        return None
    if np.linalg.det(axes) < 0:
        sizes, axes = sizes * [1, 1, -1], axes * [1, 1, -1]
    made = np.eye(4)
    made[:3, :3], made[:3, 3] = axes, matrix[:3, 3]
    return made, sizes


def pose_parts(matrix: FloatArray) -> list[str]:
    """Return the factors of a pose of a scene as text; none for the identity."""
    parts: list[str] = []
    if np.abs(matrix[:3, 3]).max() > 1e-9:
        parts.append(f"(translate {vector(matrix[:3, 3])})")
    split = rigid(matrix)
    if split is None:
        rows = " ".join(vector(row) for row in matrix)
        return [f"(pose [{rows}])"]
    motion, sizes = split
    axis, angle = quaternion_of(motion[:3, :3]).to_axis_angle()
    if abs(angle) > 1e-7:
        direction = np.array(axis.values)
        direction[np.abs(direction) < 1e-7] = 0.0
        if direction.sum() < 0:
            direction, angle = -direction, -angle
        angle = math.remainder(angle, 2 * math.pi)
        parts.append(f"(rotate {angle_text(angle)} {vector(direction)})")
    if not np.allclose(sizes, 1.0, atol=1e-7):
        uniform = np.allclose(sizes, sizes[0], rtol=1e-7)
        parts.append(f"(scale {number(sizes[0]) if uniform else vector(sizes)})")
    return parts


def moved(text: str, matrix: FloatArray) -> str:
    """Return an expression under a pose of a scene."""
    parts = pose_parts(matrix)
    if not parts:
        return text
    return f"(transform {text} {parts[0] if len(parts) == 1 else '(@ ' + ' '.join(parts) + ')'})"


@dataclass
class ShapeWriter:
    """Writes pieces; ``used`` are the helpers that they need, ``constants`` the meshes that are defined once."""

    used: set[str] = field(default_factory=set)
    constants: dict[str, str] = field(default_factory=dict)
    notes: dict[str, None] = field(default_factory=dict)

    def piece(self, piece: MeshPiece, look: str) -> tuple[str, FloatArray]:
        """Return an expression and the pose (4, 4), of Blender's axes, that places it."""
        if piece.operation is not None:
            return self._operation(piece.operation, look), piece.matrix
        if piece.bevel is not None:
            return self._beveled(piece, look)
        if piece.form is not None:
            return self._form(piece.form, piece.matrix, look, is_smooth=piece.is_smooth)
        assert piece.mesh is not None, "a piece has a form or a mesh"
        return self._mesh(piece.mesh.moved(piece.matrix), look), np.eye(4)

    def _form(self, form: PieceForm, matrix: FloatArray, look: str, *, is_smooth: bool) -> tuple[str, FloatArray]:
        """Return the expression of a primitive form and the pose (4, 4) that places it; an open form becomes a mesh."""
        is_flat = form.kind in ("plane", "circle")
        if not is_flat and not form.is_closed:
            return self._mesh(form.polygons().moved(matrix), look), np.eye(4)
        if form.kind == "circle" and form.fill == "NOTHING":
            raise UnsupportedPython("edges without faces have no counterpart in a scene")
        split = rigid(matrix)
        if split is None:
            motion, sizes = matrix, np.ones(3)
        else:
            motion, sizes = split
        if form.kind == "cube":
            return _call("cube", look, scale=_sizes(np.abs(sizes))), motion
        if is_flat:
            return self._plate(form, motion, np.abs(sizes), look, is_smooth=is_smooth)
        is_even = bool(abs(abs(sizes[0]) - abs(sizes[1])) <= 1e-6 * np.abs(sizes).max())
        is_uniform = is_even and bool(abs(abs(sizes[0]) - abs(sizes[2])) <= 1e-6 * np.abs(sizes).max())
        is_round = form.is_round(is_smooth)
        if form.kind in ("sphere", "ico"):
            if is_round:
                radius = abs(float(sizes[0])) if is_uniform else 1.0
                if is_uniform and split is not None:
                    # a rotation does not change a sphere
                    return _call("sphere", look, radius=number(radius)), _translation(motion[:3, 3])
                return _call("sphere", look, radius="1"), motion @ np.diag([*np.abs(sizes), 1.0])
            return self._faceted(form, motion, sizes, look)
        if form.kind == "torus":
            return self._torus(
                form, motion, sizes, look, is_round=is_round and form.counts[1] >= 12, is_uniform=is_uniform
            )
        return self._cone(form, motion, sizes, look, is_round=is_round, is_even=is_even)

    def _plate(
        self, form: PieceForm, motion: FloatArray, sizes: FloatArray, look: str, *, is_smooth: bool
    ) -> tuple[str, FloatArray]:
        """Return a thin plate under a flat form."""
        extent = float(max(sizes[0], sizes[1])) * (2.0 if form.kind == "circle" else 1.0)
        thickness = _PLATE * extent
        self.notes["flat and open meshes become thin plates, because a scene has solids only"] = None
        lowered = motion @ _translation(np.array([0.0, 0.0, -thickness / 2]))
        plate = np.array([sizes[0], sizes[1], thickness])
        if form.kind == "plane":
            return _call("cube", look, scale=_sizes(plate)), lowered
        cone = PieceForm("cone", form.counts, (1.0, 1.0))
        is_even = bool(abs(sizes[0] - sizes[1]) <= 1e-6 * sizes.max())
        return self._cone(cone, lowered, plate, look, is_round=form.is_round(is_smooth), is_even=is_even)

    def _cone(
        self, form: PieceForm, motion: FloatArray, sizes: FloatArray, look: str, *, is_round: bool, is_even: bool
    ) -> tuple[str, FloatArray]:
        """Return the expression of a cone, frustum, cylinder or prism, and the pose (4, 4) that places it."""
        bottom, top = form.sizes
        # a reflection along the axis exchanges the ends
        if sizes[2] < 0:
            bottom, top = top, bottom
        radius, height = (abs(float(sizes[0])), abs(float(sizes[2]))) if is_even else (1.0, 1.0)
        placed = motion if is_even else motion @ np.diag([*np.abs(sizes), 1.0])
        half = number(height / 2)
        low, high = f"[0 -{half} 0]", f"[0 {half} 0]"
        if not is_round:
            # the helper `prism` can end in a point only at the top
            if bottom == 0:
                return self._mesh(form.polygons().moved(motion @ np.diag([*sizes, 1.0])), look), np.eye(4)
            self.used.add("prism")
            values = " ".join(map(number, (bottom * radius, top * radius, height)))
            return f"(prism {form.counts[0]} {values}{look})", placed
        if bottom == top:
            return _call("cylinder", look, radius=number(bottom * radius), p0=low, p1=high), placed
        if top == 0:
            return _call("cone", look, radius=number(bottom * radius), p0=low, p1=high), placed
        if bottom == 0:
            return _call("cone", look, radius=number(top * radius), p0=high, p1=low), placed
        profile = f"[[0 -{half}] [{number(bottom * radius)} -{half}] [{number(top * radius)} {half}] [0 {half}]]"
        return f"(lathe {profile} :segments {_LATHE_SEGMENTS}{look})", placed

    def _torus(
        self, form: PieceForm, motion: FloatArray, sizes: FloatArray, look: str, *, is_round: bool, is_uniform: bool
    ) -> tuple[str, FloatArray]:
        factor = abs(float(sizes[0])) if is_uniform else 1.0
        placed = motion if is_uniform else motion @ np.diag([*np.abs(sizes), 1.0])
        major, minor = (size * factor for size in form.sizes)
        if is_round and form.counts[1] >= 16:
            return _call("torus", look, radius=number(major), tube=number(minor)), placed
        around, across = form.counts
        angles = [2 * math.pi * j / across for j in range(across)]
        profile = " ".join(vector((major + minor * math.cos(a), minor * math.sin(a))) for a in angles)
        return f"(lathe [{profile}] :segments {around}{look})", placed

    def _faceted(self, form: PieceForm, motion: FloatArray, sizes: FloatArray, look: str) -> tuple[str, FloatArray]:
        """Return a sphere of few faces."""
        placed = motion @ np.diag([*sizes, 1.0])
        if form.kind == "ico":
            name = f"icosphere-{form.counts[0]}"
            mesh = ico_sphere(form.counts[0])
            self.constants[f"{name}-points"] = _points_text(mesh)
            self.constants[f"{name}-faces"] = f"'{_faces_text(mesh)}"
            return f"(mesh {name}-points {name}-faces{look})", placed
        segments, rings = form.counts
        angles = [math.pi * j / rings for j in range(rings + 1)]
        profile = " ".join(
            vector((max(0.0, math.sin(a)) if 0 < a < math.pi - 1e-9 else 0.0, -math.cos(a))) for a in angles
        )
        # The first corner of a lathe is at +x, Blender's at +y, which is -z here.
        turn = np.array(placed) @ Quaternion((0.0, 0.0, 1.0), math.pi / 2).to_matrix().to_4x4().numbers
        return f"(lathe [{profile}] :segments {segments}{look})", turn

    def _beveled(self, piece: MeshPiece, look: str) -> tuple[str, FloatArray]:
        assert piece.bevel is not None, "the caller has a bevel"
        width, segments = piece.bevel
        inner = piece.matrix @ np.diag([*(1 / np.array(piece.bevel_sizes)), 1.0])
        split = rigid(inner)
        sizes, placed = np.array(piece.bevel_sizes), inner
        if split is not None and np.allclose(np.abs(split[1]), abs(split[1][0]), rtol=1e-6):
            factor = abs(float(split[1][0]))
            sizes, width, placed = sizes * factor, width * factor, split[0]
        if abs(width * 2 - sizes.min()) < 1e-9:
            width *= 1 - 1e-6  # corners stay distinct
        self.used.add("beveled-box")
        return f"(beveled-box {_sizes(sizes)} {number(width)} {segments}{look})", placed

    def _operation(self, operation: BooleanPiece, look: str) -> str:
        name = {"DIFFERENCE": "difference", "UNION": "solid-union", "INTERSECT": "intersection"}.get(operation.kind)
        if name is None:
            raise UnsupportedPython(f"the boolean {operation.kind} is not supported")
        operands = [self.united(operation.base, ""), *(self.united(tool, "") for tool in operation.tools)]
        return f"({name} {' '.join(operands)} :segments {_LATHE_SEGMENTS}{look})"

    def united(self, pieces: Sequence[MeshPiece], look: str) -> str:
        """Return pieces as one expression in the object's frame."""
        texts = [moved(text, upright(matrix)) for text, matrix in (self.piece(piece, look) for piece in pieces)]
        return texts[0] if len(texts) == 1 else f"(union {' '.join(texts)})"

    # --- polygons

    def _mesh(self, mesh: Polygons, look: str) -> str:
        """Return the expression of a mesh: closed islands become solids or cavities, open ones thin plates."""
        islands = [_outer(island) for island in mesh.islands()]
        solids = [island for island in islands if island.is_closed()]
        sheets = [island for island in islands if not island.is_closed()]
        # a negative volume means that the faces point inwards: a cavity, or a mesh that is inside out
        outer = [s for s in solids if s.volume() >= 0]
        inner = [s for s in solids if s.volume() < 0]
        if not outer:
            outer, inner = [s.flipped() for s in inner], []
        texts = [self._solid(each, look) for each in outer if abs(each.volume()) > 0]
        if inner:
            holes = " ".join(self._solid(each.flipped(), "") for each in inner)
            base = texts[0] if len(texts) == 1 else f"(union {' '.join(texts)})"
            texts = [f"(difference {base} {holes}{look})"]
        if sheets:
            self.notes["flat and open meshes become thin plates, because a scene has solids only"] = None
            whole = combined(sheets)
            extent = float((whole.points.max(axis=0) - whole.points.min(axis=0)).max())
            for sheet in sheets:
                plate = solidified(sheet, _PLATE * extent, -1.0, has_rim=True, is_even=False)
                if not plate.is_closed():
                    raise UnsupportedPython("a mesh whose faces do not bound a body or a surface is not supported")
                texts.append(self._raw(plate, look))
        if not texts:
            raise UnsupportedPython("a mesh without volume is not supported")
        return texts[0] if len(texts) == 1 else f"(union {' '.join(texts)})"

    def _solid(self, mesh: Polygons, look: str) -> str:
        boxed = as_box(mesh)
        if boxed is not None:
            matrix, sizes = boxed
            return moved(_call("cube", look, scale=_sizes(sizes)), upright(matrix))
        return self._raw(mesh, look)

    def _raw(self, mesh: Polygons, look: str) -> str:
        made = mesh.moved(UPRIGHT)
        return f"(mesh {_points_text(made, is_blender=False)} '{_faces_text(made)}{look})"


def _outer(island: Polygons) -> Polygons:
    """Return an island without faces inside it, if it bounds a body then; its faces are turned consistently."""
    if island.is_closed():
        return island
    outer = island.without_inner_faces()
    if outer.is_closed():
        return outer
    turned = outer.oriented()
    return turned if turned.is_closed() else island


def _translation(offset: FloatArray) -> FloatArray:
    made = np.eye(4)
    made[:3, 3] = offset
    return made


def _sizes(sizes: FloatArray) -> str:
    """Return the sizes of a box along Blender's axes as those of a scene."""
    x, y, z = (float(size) for size in sizes)
    return number(x) if number(x) == number(y) == number(z) else vector((x, z, y))


def _call(word: str, look: str, **attributes: str) -> str:
    defaults = {"radius": "1", "scale": "1"}
    given = "".join(f" :{name} {text}" for name, text in attributes.items() if defaults.get(name) != text)
    return f'(call "{word}"{given}{look})'


def _points_text(mesh: Polygons, *, is_blender: bool = True) -> str:
    points = mesh.points @ UPRIGHT[:3, :3].T if is_blender else mesh.points
    return f"[{' '.join(vector(point) for point in points)}]"


def _faces_text(mesh: Polygons) -> str:
    faces: list[tuple[int, ...]] = []
    normals = mesh.face_normals()
    extent = float(np.ptp(mesh.points, axis=0).max()) if len(mesh.points) else 1.0
    for face, normal in zip(mesh.faces, normals, strict=True):
        corners = mesh.points[list(face)]
        depth = np.abs((corners - corners[0]) @ normal).max()
        if len(face) > 3 and depth > 1e-6 * extent:  # not flat: Blender's triangles
            faces += [(face[0], face[i], face[i + 1]) for i in range(1, len(face) - 1)]
        else:
            faces.append(face)
    return f"({' '.join('(' + ' '.join(map(str, face)) + ')' for face in faces)})"
