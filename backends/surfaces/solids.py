"""Posed primitives as arrays: the renderer parameters of geometric backends (their ``g_reparam``).

Every primitive is a canonical form under an affine pose, or the triangles of a mesh, so that renderers are independent
of sizes, radii and axes. The primitives define the forms (``interpreter.scene.primitives``).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.surfaces.appearance import Look, Looks, look_of, looks_of
from scenelang.backends.surfaces.assets import MAX_TRIANGLES
from scenelang.backends.surfaces.tiles import tile_of
from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.scene.entity import Entity
from scenelang.interpreter.scene.flatten import FlatFrame
from scenelang.interpreter.scene.primitives import Placed, standard_forms
from scenelang.interpreter.scene.primitives.base import Primitive, mesh_of
from scenelang.interpreter.scene.primitives.forms import FACE, SMOOTH_FACE, TRIANGLE, CanonicalForm, Ratios
from scenelang.interpreter.scene.primitives.mesh import Mesh, cofactors_of, inverses_of
from scenelang.interpreter.scene.primitives.mesh_file import MeshFile
from scenelang.interpreter.scene.primitives.textures import Texture

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]
Numbers = npt.NDArray[np.int16]

_NO_ROWS = (0.0,) * 12  # of the pose of a primitive without a form
_MAX_FLAT_SINE = 1e-3  # sine of the angle between a corner's normal and its face below which a triangle is flat
_HALF_THICKNESS = 2e-5  # of flat objects, in units of the scene's half diagonal: far below a pixel
# Relative to the longest edge of a triangle.
_MIN_AREA = 1e-12  # squared; smaller triangles are degenerate
_TRIANGLE_THICKNESS = 1e-3  # of the canonical triangle's pose, which must be invertible


@dataclass(frozen=True, slots=True, eq=False)
class PosedForms:
    """N canonical forms under poses in one frame of reference.

    Attributes
    ----------
    kinds
        Distinct forms.
    forms
        Index (N,) in ``kinds``.
    ratios
        Ratios (N, R) of each form, of which it uses the first ones.
    matrices
        Poses (N, 3, 4), which map the forms into the frame of reference.
    """

    kinds: tuple[CanonicalForm, ...]
    forms: Numbers  # (N,)
    ratios: FloatArray  # (N, most ratios of a kind)
    matrices: FloatArray  # (N, 3, 4)

    def __len__(self) -> int:
        return len(self.forms)

    def take(self, which: npt.NDArray[Any]) -> PosedForms:
        """Return the rows selected by the mask or indices ``which``."""
        return PosedForms(self.kinds, self.forms[which], self.ratios[which], self.matrices[which])

    def form(self, i: int) -> tuple[CanonicalForm, tuple[float, ...]]:
        """Return the form of row ``i`` and its ratios."""
        kind = self.kinds[int(self.forms[i])]
        return kind, tuple(self.ratios[i, : kind.ratios].tolist())

    def groups(self, which: npt.NDArray[np.bool_] | None = None) -> Iterator[tuple[CanonicalForm, IntArray]]:
        """Yield the forms that occur (within the mask ``which``), each with the indices of its rows."""
        forms = self.forms if which is None else self.forms[which]
        for number in np.unique(forms).tolist():
            same = self.forms == number
            yield self.kinds[number], np.flatnonzero(same if which is None else same & which)

    def ratios_of(self, form: CanonicalForm, rows: npt.NDArray[Any]) -> Ratios:
        """Return the ratios of ``rows``, all of one form, as arrays (K,)."""
        return tuple(self.ratios[rows, k] for k in range(form.ratios))

    def members(self) -> Iterator[tuple[CanonicalForm, tuple[float, ...], IntArray]]:
        """Yield the distinct pairs of form and ratios, each with the indices of its rows.

        Triangles of smooth surfaces, each of which has its own ratios, are left out.
        """
        for form, rows in self.groups():
            if form.shading_ratios:
                continue
            if not form.ratios:
                yield form, (), rows
                continue
            values, place = np.unique(self.ratios[rows, : form.ratios], axis=0, return_inverse=True)
            order = np.argsort(place.reshape(-1), kind="stable")
            ends = np.cumsum(np.bincount(place.reshape(-1)))
            for value, part in zip(values.tolist(), np.split(rows[order], ends[:-1]), strict=True):
                yield form, tuple(value), part

    def that_are(self, name: str) -> npt.NDArray[np.bool_]:
        """Return the mask (N,) of rows whose form's attribute ``name`` is true."""
        true = np.array([bool(getattr(kind, name)) for kind in self.kinds], bool)
        return np.asarray(true[self.forms], bool)

    def support(self, directions: FloatArray) -> FloatArray:
        """Return support points (N, 3) along ``directions`` (N, 3); those of the convex hull for non-convex forms."""
        local = np.einsum("nij,ni->nj", self.matrices[:, :, :3], directions)
        local_points = np.empty_like(local)
        for form, rows in self.groups():
            local_points[rows] = form.support(local[rows], self.ratios_of(form, rows))
        points: FloatArray = np.einsum("nij,nj->ni", self.matrices[:, :, :3], local_points) + self.matrices[:, :, 3]
        return points


@dataclass(frozen=True, slots=True, eq=False)
class Solids(PosedForms):
    """N posed solids in one frame of reference.

    Attributes
    ----------
    look, looks
        Index (N,) of the material, and the materials.
    word, words
        Index (N,) of the primitive's word, and the words.
    semantic
        Whether it (N,) is the placeholder of a semantic primitive.
    instance
        Index (N,) in the flattened frame.
    local
        Poses (N, 12) from the frames of the forms to those of the primitives, row by row, if a look has a texture; else
        (N, 0).
    part, part_words
        Index (N,) of the word of the operand that a face of a computed solid comes from, -1 for none, and these words.
    """

    look: IntArray  # (N,)
    word: IntArray  # (N,)
    semantic: npt.NDArray[np.bool_]  # (N,)
    instance: IntArray  # (N,)
    part: IntArray  # (N,)
    local: FloatArray  # (N, 12) or (N, 0)
    looks: Looks
    words: tuple[str, ...]
    part_words: tuple[str, ...]

    @property
    def colors(self) -> FloatArray:
        """Reflectance (N, 3), linear sRGB."""
        return np.asarray(self.looks.color[self.look], np.float64)

    @property
    def emission(self) -> FloatArray:
        """Emitted radiance (N, 3), linear sRGB."""
        return np.asarray(self.looks.emission[self.look], np.float64)

    @property
    def opacity(self) -> FloatArray:
        """Opacity (N,) in (0, 1]."""
        return np.asarray(self.looks.opacity[self.look], np.float64)

    def into_primitives(self, rows: IntArray) -> tuple[FloatArray, FloatArray]:
        """Return the maps, linear parts (K, 3, 3) and offsets (K, 3), from the frame of reference to the primitives'.

        Only for solids with a texture.
        """
        local, matrices = self.local[rows].reshape(-1, 3, 4), self.matrices[rows]
        with np.errstate(all="ignore"):
            linear = local[:, :, :3] @ inverses_of(matrices[:, :, :3])
        return linear, local[:, :, 3] - np.einsum("kij,kj->ki", linear, matrices[:, :, 3])

    def take(self, which: npt.NDArray[Any]) -> Solids:
        """Return the solids selected by the mask or indices ``which``."""
        columns: dict[str, Any] = {name: getattr(self, name)[which] for name in _COLUMNS}
        return replace(self, **columns)

    def followed_by(self, other: Solids) -> Solids:
        """Concatenate these solids with ``other``, which must have the same tables of kinds, looks and words."""
        columns: dict[str, Any] = {
            name: np.concatenate([getattr(self, name), getattr(other, name)]) for name in _COLUMNS
        }
        return replace(self, **columns)


# The fields of ``Solids`` with a row for each solid.
_COLUMNS = ("forms", "ratios", "matrices", "look", "word", "semantic", "instance", "part", "local")


@dataclass(frozen=True, slots=True)
class _Piece:
    """Drawable of a distinct primitive: one canonical form."""

    placed: Placed
    look: int


@dataclass(frozen=True, slots=True, eq=False)
class _Triangles:
    """Drawable of a distinct primitive: K triangles with local poses (K, 3, 4) and looks (K,).

    ``normals`` (K, 9) are those at the corners, in the dual of each triangle's frame, None for the meshes of files,
    which may be open. ``charts`` (K, 3, 4) map the triangles to where textures are: into the frame of the primitive, or
    to texture coordinates of the file.
    """

    local: FloatArray
    look: IntArray
    normals: FloatArray | None = None
    part: IntArray | None = None
    part_words: tuple[str, ...] = ()
    charts: FloatArray | None = None


class FormTable:
    """Assigns indices to distinct forms in order of insertion, after the standard forms."""

    def __init__(self, forms: Sequence[CanonicalForm] = ()) -> None:
        self._numbers = {form: i for i, form in enumerate(standard_forms())}
        for form in forms:
            self.number(form)

    def number(self, form: CanonicalForm) -> int:
        """Return the index of a form, which is added if it is new."""
        return self._numbers.setdefault(form, len(self._numbers))

    def kinds(self) -> tuple[CanonicalForm, ...]:
        """Return the forms in the order of their indices."""
        return tuple(self._numbers)


def posed_forms(placed: Sequence[Placed | None]) -> PosedForms:
    """Return primitives in their own frames as rows; the row of None is a placeholder."""
    table = FormTable()
    numbers = [0 if one is None else table.number(one.form) for one in placed]
    kinds = table.kinds()
    ratios = np.zeros((len(placed), max(kinds[number].ratios for number in numbers) if numbers else 0))
    for i, one in enumerate(placed):
        if one is not None and one.ratios:
            ratios[i, : len(one.ratios)] = one.ratios
    matrices = np.array([_NO_ROWS if one is None else one.rows for one in placed], np.float64).reshape(-1, 3, 4)
    return PosedForms(kinds, np.array(numbers, np.int16), ratios, matrices)


class _LookTable:
    """Assigns indices to distinct looks."""

    def __init__(self) -> None:
        self._numbers: dict[Look, int] = {}

    def number(self, look: Look) -> int:
        """Return the index of a look, which is added if it is new."""
        return self._numbers.setdefault(look, len(self._numbers))

    def looks(self) -> Looks:
        """Return the looks in the order of their indices."""
        return looks_of(self._numbers)


def solids_of(frame: FlatFrame) -> Solids:
    """Return the solids of the primitives of a frame, in world coordinates.

    Raises
    ------
    SceneError
        If a material attribute is invalid, a mesh file cannot be read, or there are too many triangles.
    """
    table = _LookTable()
    words = tuple(dict.fromkeys(entity.word for entity in frame.primitives))
    number = {word: i for i, word in enumerate(words)}
    pieces = [_piece(entity, table) for entity in frame.primitives]
    word = np.array([number[entity.word] for entity in frame.primitives], np.int64)
    semantic = np.array([is_semantic(entity) for entity in frame.primitives], bool)
    forms = posed_forms([piece.placed if isinstance(piece, _Piece) else None for piece in pieces])
    columns = [_form_columns(frame, pieces, forms, word, semantic)]
    if any(isinstance(piece, _Triangles) and piece.normals is not None for piece in pieces):
        forms = _with_faces(forms)
        columns[0]["ratios"] = _padded(columns[0]["ratios"], SMOOTH_FACE.ratios)
    parts: dict[str, int] = {}
    for i, piece in enumerate(pieces):
        if isinstance(piece, _Triangles):
            columns.append(_triangle_columns(frame, i, piece, int(word[i]), forms, parts))
    looks = table.looks()
    if not looks.textured.any():
        for part in columns:
            part["local"] = np.zeros((len(part["forms"]), 0))
    joined: dict[str, Any] = {name: np.concatenate([part[name] for part in columns]) for name in _COLUMNS}
    return Solids(kinds=forms.kinds, **joined, looks=looks, words=words, part_words=tuple(parts))


def _with_faces(forms: PosedForms) -> PosedForms:
    """Return the same rows with the forms of faces among the kinds, and room for their ratios."""
    kinds = tuple(dict.fromkeys((*forms.kinds, FACE, SMOOTH_FACE)))
    return replace(forms, kinds=kinds, ratios=_padded(forms.ratios, SMOOTH_FACE.ratios))


def _padded(ratios: FloatArray, count: int) -> FloatArray:
    """Return ratios padded with zeros to at least ``count`` columns."""
    return np.pad(ratios, ((0, 0), (0, max(0, count - ratios.shape[1]))))


def _form_columns(
    frame: FlatFrame,
    pieces: Sequence[_Piece | _Triangles | None],
    forms: PosedForms,
    word: IntArray,
    semantic: npt.NDArray[np.bool_],
) -> dict[str, npt.NDArray[Any]]:
    """Return the columns of all instances of single-form primitives; ``forms`` has a row for each primitive."""
    single = np.array([isinstance(piece, _Piece) for piece in pieces], bool)
    look = np.array([piece.look if isinstance(piece, _Piece) else -1 for piece in pieces], np.int64)
    index = np.asarray(frame.index)
    instance = np.flatnonzero(single[index]) if len(index) else np.zeros(0, np.int64)
    which = index[instance]
    return {
        "forms": forms.forms[which],
        "ratios": forms.ratios[which],
        "matrices": composed(frame.matrices[instance], forms.matrices[which]),
        "look": look[which],
        "word": word[which],
        "semantic": semantic[which],
        "instance": instance,
        "part": np.full(len(which), -1, np.int64),
        "local": forms.matrices[which].reshape(len(which), 12),
    }


def _triangle_columns(
    frame: FlatFrame, primitive: int, mesh: _Triangles, word: int, forms: PosedForms, parts: dict[str, int]
) -> dict[str, npt.NDArray[Any]]:
    """Return the columns of all instances of one primitive that consists of many triangles.

    ``parts`` are the numbers of words of parts, to which new ones are added.
    """
    instance = np.flatnonzero(np.asarray(frame.index) == primitive)
    count, total = len(mesh.local), len(instance) * len(mesh.local)
    if total > MAX_TRIANGLES:
        raise SceneError(
            "unsupported",
            f'the meshes of "{frame.primitives[primitive].word}" have {total:,} triangles in total, '
            f"more than the limit of {MAX_TRIANGLES:,} for a picture",
            hint="use a simpler mesh, or fewer copies of it",
        )
    matrices = np.asarray(frame.matrices[instance])
    kinds, ratios = _triangle_forms(mesh, forms)
    return {
        "forms": np.tile(kinds, len(instance)),
        "ratios": np.tile(ratios, (len(instance), 1)),
        "matrices": composed(np.repeat(matrices, count, axis=0), np.tile(mesh.local, (len(instance), 1, 1))),
        "look": np.tile(mesh.look, len(instance)),
        "word": np.full(total, word, np.int64),
        "semantic": np.zeros(total, bool),
        "instance": np.repeat(instance, count),
        "part": np.tile(_part_numbers(mesh, parts), len(instance)),
        "local": np.tile((mesh.local if mesh.charts is None else mesh.charts).reshape(count, 12), (len(instance), 1)),
    }


def _part_numbers(mesh: _Triangles, parts: dict[str, int]) -> IntArray:
    """Return the indices (K,) of the words of a mesh's parts in ``parts``, to which new words are added."""
    if mesh.part is None:
        return np.full(len(mesh.local), -1, np.int64)
    return np.array([parts.setdefault(word, len(parts)) for word in mesh.part_words], np.int64)[mesh.part]


def _triangle_forms(mesh: _Triangles, forms: PosedForms) -> tuple[Numbers, FloatArray]:
    """Return the forms (K,) and ratios (K, R) of triangles: faces with one normal at all corners are flat."""
    count = len(mesh.local)
    ratios = np.zeros((count, forms.ratios.shape[1]))
    if mesh.normals is None:
        return np.full(count, forms.kinds.index(TRIANGLE), np.int16), ratios
    tilt = np.abs(mesh.normals.reshape(-1, 3, 3)[:, :, :2]).max(axis=(1, 2))
    is_smooth = tilt > _MAX_FLAT_SINE * np.linalg.norm(mesh.local[:, :, :2], axis=1).max(axis=1)
    ratios[is_smooth, : SMOOTH_FACE.ratios] = mesh.normals[is_smooth]
    return np.where(is_smooth, forms.kinds.index(SMOOTH_FACE), forms.kinds.index(FACE)).astype(np.int16), ratios


def composed(outer: npt.NDArray[np.float64], inner: npt.NDArray[np.float64]) -> FloatArray:
    """Row-wise product ``outer @ inner`` of affine poses (N, 3, 4)."""
    out = np.empty(np.broadcast_shapes(outer.shape, inner.shape))
    with np.errstate(all="ignore"):
        np.matmul(outer[..., :3], inner, out=out)
        out[..., 3] += outer[..., 3]
    return out


# --- shapes and looks of primitives ----------------------------------------------------------------------------


def own_mesh(shape: Primitive) -> Mesh | None:
    """Return the triangles of a primitive that is not a canonical form, None if nothing is visible.

    Raises SceneError for unreadable files.
    """
    if not shape.has_geometry or shape.placed() is not None:
        return None
    mesh = shape.triangulate(0.0) if shape.is_file else mesh_of(shape)
    return mesh if len(mesh.faces) else None


def keeps_own_colors(entity: Entity, mesh: Mesh) -> bool:
    """Return whether a mesh shows its own colors; a color, a material or a texture of the primitive replaces them."""
    given = entity.embedding.attributes
    return mesh.colors is not None and all(given.get(name) is None for name in ("color", "material", "texture"))


def _piece(entity: Entity, table: _LookTable) -> _Piece | _Triangles | None:
    """Return the drawable of a primitive, None if it is invisible; raises SceneError for bad attributes or files."""
    shape, look = entity.shape, look_of(entity)
    if shape is None or look.opacity == 0.0:
        return None
    placed = shape.placed()
    if placed is not None:
        return _Piece(placed, table.number(look))
    mesh = own_mesh(shape)
    return None if mesh is None else _triangles(entity, mesh, look, table)


def _triangles(entity: Entity, mesh: Mesh, look: Look, table: _LookTable) -> _Triangles:
    """Return the triangles of a mesh, in its own colors unless the primitive has a ``:color``."""
    local, valid = triangle_poses(mesh.corners)
    has_normals = entity.shape is not None and not entity.shape.is_file  # those of files are not used
    normals = _corner_normals(mesh, local, valid) if has_normals else None
    part = None if mesh.part is None else mesh.part[valid]
    charts: FloatArray | None
    if mesh.colors is not None and keeps_own_colors(entity, mesh):
        numbers, charts = _own_looks(entity, mesh, look, table, valid, local)
    else:
        numbers = np.full(len(local), table.number(look))
        has_chart = look.texture is not None and look.texture.projection == "uv"
        charts = _charts(coordinates_of(entity, mesh)[valid], local) if has_chart else None
    return _Triangles(local, numbers, normals, part, mesh.part_words, charts)


def _own_looks(
    entity: Entity, mesh: Mesh, look: Look, table: _LookTable, valid: IntArray, local: FloatArray
) -> tuple[IntArray, FloatArray]:
    """Return the looks (K,) and charts (K, 3, 4) of the triangles ``valid`` in the colors and images of their mesh."""
    assert mesh.colors is not None
    colors, inverse = np.unique(mesh.colors[valid], axis=0, return_inverse=True)
    looks = [table.number(replace(look, color=tuple(color))) for color in colors.tolist()]
    by_color = np.array(looks, np.int64)[inverse.reshape(-1)]
    return _imaged(entity, mesh, look, table, by_color, valid, local) if mesh.images else (by_color, local)


def coordinates_of(entity: Entity, mesh: Mesh) -> FloatArray:
    """Return the texture coordinates (F, 3, 2) of a mesh file; raises SceneError if not all faces have some."""
    if mesh.uv is None or not np.isfinite(mesh.uv).all():
        message = f'the mesh file of "{entity.word}" has no texture coordinates'
        raise SceneError("attribute", message, "write `:projection` box, planar, cylindrical or spherical")
    return mesh.uv


def _charts(uv: FloatArray, local: FloatArray) -> FloatArray:
    """Return maps (K, 3, 4) from canonical triangles to texture coordinates (K, 3, 2), with 0 for the third.

    The thickness of the triangles ``local`` grows as their sides do, so that a volume tells how lengths grow.
    """
    a, b, c = uv[:, 0], uv[:, 1], uv[:, 2]
    charts = np.zeros((len(uv), 3, 4))
    charts[:, :2] = np.stack([(b - a) / 2.0, (c - a) / 2.0, np.zeros_like(a), (b + c) / 2.0], axis=2)
    area = np.abs(charts[:, 0, 0] * charts[:, 1, 1] - charts[:, 0, 1] * charts[:, 1, 0])
    own = np.linalg.norm(np.cross(local[:, :, 0], local[:, :, 1]), axis=1)
    charts[:, 2, 2] = np.sqrt(area / own) * np.linalg.norm(local[:, :, 2], axis=1)
    return charts


def _imaged(
    entity: Entity, mesh: Mesh, look: Look, table: _LookTable, numbers: IntArray, valid: IntArray, local: FloatArray
) -> tuple[IntArray, FloatArray]:
    """Return the looks (K,) and charts (K, 3, 4) of the triangles ``valid`` with the images of their file.

    ``numbers`` (K,) are the looks of faces without an image.
    """
    file, uv, image, tint = entity.shape, mesh.uv, mesh.image, mesh.tint
    if not isinstance(file, MeshFile) or file.file is None or uv is None or image is None or tint is None:
        return numbers, local
    numbers, charts, shown = numbers.copy(), local.copy(), image[valid]
    for number in np.unique(shown[shown >= 0]).tolist():
        rows = np.flatnonzero(shown == number)
        charts[rows] = _charts(uv[valid[rows]], local[rows])
        tints, which = np.unique(tint[valid[rows]], axis=0, return_inverse=True)
        looks = []
        for factor in tints.tolist():
            source = (str(file.root), number)
            texture = Texture(file.file, 1.0, colors=(tuple(factor),), projection="uv", source=source)
            looks.append(table.number(replace(look, color=tile_of(texture).mean, texture=texture)))
        numbers[rows] = np.array(looks, np.int64)[which.reshape(-1)]
    return numbers, charts


def _corner_normals(mesh: Mesh, local: FloatArray, valid: IntArray) -> FloatArray:
    """Return the normals (K, 9) at the corners of the triangles ``valid``, in the dual of their frames ``local``."""
    if mesh.normals is None:
        flat = np.zeros((len(valid), 9))
        flat[:, 2::3] = 1.0
        return flat
    corners = mesh.normals[mesh.faces[valid]]
    return np.asarray(np.einsum("kix,kci->kcx", local[:, :, :3], corners).reshape(-1, 9), np.float64)


def triangle_poses(corners: FloatArray) -> tuple[FloatArray, IntArray]:
    """Return poses of the canonical triangle for the triangles of a mesh.

    Parameters
    ----------
    corners : (F, 3, 3)
        Corners of the triangles.

    Returns
    -------
    poses : (K, 3, 4)
        Degenerate triangles have none.
    valid : (K,)
        Indices of the others.
    """
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    normal = np.cross(b - a, c - a)
    length = np.linalg.norm(normal, axis=1)
    edge = np.maximum(np.linalg.norm(b - a, axis=1), np.linalg.norm(c - a, axis=1))
    valid = np.flatnonzero(length > _MIN_AREA * edge * edge)
    thin = normal[valid] / length[valid, None] * (_TRIANGLE_THICKNESS * edge[valid, None])
    a, b, c = a[valid], b[valid], c[valid]
    return np.stack([(b - a) / 2.0, (c - a) / 2.0, thin, (b + c) / 2.0], axis=2), valid


def is_semantic(entity: Entity) -> bool:
    """Return whether an entity is a semantic primitive: the box that is drawn for a word that is never bound."""
    return entity.shape is not None and entity.shape.is_semantic


def is_object(entity: Entity) -> bool:
    """Return whether an entity is bound by the program or is a semantic primitive, rather than a plain primitive."""
    return not entity.is_primitive or is_semantic(entity)


# --- animations -------------------------------------------------------------------------------------------------


def parted(frames: Sequence[Solids]) -> tuple[Solids, list[Solids]]:
    """Split ``frames`` into the solids that are equal in all of them and the others of each; all share their tables."""
    table = _LookTable()
    words = {word: i for i, word in enumerate(dict.fromkeys(word for solids in frames for word in solids.words))}
    numbers = [np.array([table.number(look) for look in solids.looks.rows], np.int64) for solids in frames]
    looks = table.looks()
    forms = FormTable([form for solids in frames for form in solids.kinds])
    widest, mapped = (max(getattr(solids, name).shape[1] for solids in frames) for name in ("ratios", "local"))
    common = [
        replace(
            solids,
            kinds=forms.kinds(),
            forms=np.array([forms.number(form) for form in solids.kinds], np.int16)[solids.forms],
            ratios=np.pad(solids.ratios, ((0, 0), (0, widest - solids.ratios.shape[1]))),
            local=np.pad(solids.local, ((0, 0), (0, mapped - solids.local.shape[1]))),
            look=number[solids.look],
            word=np.array([words[word] for word in solids.words], np.int64)[solids.word],
            looks=looks,
            words=tuple(words),
        )
        for solids, number in zip(frames, numbers, strict=True)
    ]
    keys = [_row_keys(solids) for solids in common]
    shared = keys[0]
    for other in keys[1:]:
        shared = np.intersect1d(shared, other)
    fixed = common[0].take(np.isin(keys[0], shared))
    return fixed, [solids.take(~np.isin(key, shared)) for solids, key in zip(common, keys, strict=True)]


def _row_keys(solids: Solids) -> npt.NDArray[Any]:
    """Return one value per solid (N,); values are equal if and only if the solids are drawn identically."""
    columns = [solids.matrices.reshape(len(solids), 12) + 0.0]  # + 0.0 removes negative zeros
    columns += [column.astype(np.float64)[:, None] for column in (solids.forms, solids.look, solids.word)]
    columns.append(solids.ratios)
    rows = np.ascontiguousarray(np.concatenate(columns, axis=1))
    return rows.view(np.dtype((np.void, rows.shape[1] * 8))).reshape(-1)


# --- normalization ---------------------------------------------------------------------------------------------


def normalized(solids: Solids, center: FloatArray, scale: float) -> Solids:
    """Return the solids after ``p -> scale (p - center)``, with every pose made invertible.

    Flat solids get a thickness far below a pixel. Solids without extent in two directions, or with non-finite poses,
    are removed.
    """
    matrices = solids.matrices.copy()
    with np.errstate(all="ignore"):
        matrices[:, :, 3] -= center
        matrices *= scale
        is_valid = np.asarray(np.isfinite(matrices).all(axis=(1, 2)), bool)
        doubtful = np.flatnonzero(is_valid & (thinness(matrices) < 2.0 * _HALF_THICKNESS))
    if len(doubtful):
        linear, has_area = _thickened(matrices[doubtful, :, :3])
        matrices[doubtful, :, :3] = linear
        is_valid[doubtful] &= has_area
    moved = replace(solids, matrices=matrices)
    return moved if is_valid.all() else moved.take(is_valid)


def thinness(matrices: FloatArray) -> FloatArray:
    """Return lower bounds of the smallest singular values of the linear parts of poses.

    The smallest singular value is the determinant divided by the product of the other two, which is at most the
    Frobenius norm of the cofactors.

    Parameters
    ----------
    matrices : (N, 3, 4)
        Poses, or only their linear parts, (N, 3, 3).

    Returns
    -------
    (N,)
        Bounds that are too low by a factor of at most sqrt(3); 0 for a singular matrix.
    """
    cofactors = cofactors_of(matrices[:, :, :3])
    determinant = np.einsum("ni,ni->n", matrices[:, :, 0], cofactors[:, :, 0])
    norm = np.sqrt(np.einsum("nij,nij->n", cofactors, cofactors))
    return np.where(norm > 0.0, np.abs(determinant) / np.where(norm > 0.0, norm, 1.0), 0.0)


def _thickened(linear: FloatArray) -> tuple[FloatArray, npt.NDArray[np.bool_]]:
    """Raise the smallest singular values of matrices (K, 3, 3); also return which (K,) have rank 2 or more."""
    u, s, vt = np.linalg.svd(linear)
    least = np.minimum(_HALF_THICKNESS, 2e-3 * s[:, 0])
    has_area = (s[:, 1] > 0.05 * least) & (s[:, 0] > 1e-12)
    s = np.maximum(s, least[:, None])
    return (u * s[:, None, :]) @ vt, has_area
