"""Comparison of two flattened scenes as multisets of primitives, by world-space geometry.

Two primitives are equal if their word, color and material agree, and their position and second moments agree within a
tolerance relative to the size of the scene (so a cube rotated by 90 degrees about itself is the same cube). Minecraft
blocks are equal if position, size, type, fill and keywords agree. Second moments of a cube do not depend on its
orientation, so the fourth moments of its edge directions are compared as well; assets and words without a known
geometry are compared by their whole pose. The remaining primitives of both sides are then paired as recolored (same
geometry) or moved (same size and look), so that each change is reported once.

All steps are near-linear in the number of primitives: rows are paired by hashes of their features rounded to a grid, on
several shifted grids because equal features may lie on both sides of a cell boundary (locality-sensitive hashing);
neighbors are searched only for the rows that remain. SciPy's k-d tree would replace 40 of these lines, and ``diff``
would need a package of 40 MB that imports in 0.2 s.

The size of the scene is the extent of the positions, as in the corpus's ``compare.py``; if all primitives are at one
point, the extent of the largest one. ``compare.py`` compares second moments only, so for it all rotations of a cube are
equal.
"""

from __future__ import annotations

import json
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.runtime.show import primitive_attributes
from scenelang.interpreter.scene.flatten import FlatFrame
from scenelang.interpreter.scene.primitives import MATERIALS, Primitive, class_of, find
from scenelang.interpreter.scene.primitives.base import Symmetry

if TYPE_CHECKING:
    import numpy.typing as npt


Floats: TypeAlias = "npt.NDArray[np.float64]"
Ints: TypeAlias = "npt.NDArray[np.int64]"
Bools: TypeAlias = "npt.NDArray[np.bool_]"
Hashes: TypeAlias = "npt.NDArray[np.uint64]"
Point = tuple[float, float, float]

TOLERANCE = 1e-5  # of lengths, relative to the size of the scene
COLOR_TOLERANCE = 2e-3  # of linear sRGB components, half a step of 8 bits
_MIN_SCENE_SIZE = 1e-3  # scene units: a smaller scene is compared as if it had this size
# Tolerances of the other features in units of the tolerance of lengths. Second moments are squares of lengths of up to
# half the scene; the edge directions of small cubes vary more than their moments (see ``_Rule.holds``).
_MOMENT_FACTOR = 4.0
_ORIENTATION_FACTOR = 8.0
_STRETCH_FACTOR = 4.0
_SHIFTS = (0.317, 0.731, 0.113, 0.558)  # grid offsets; no round number lies on a cell boundary
_MAX_CANDIDATES = 64  # neighbors compared with one row
_CHUNK_ROWS = 50_000  # rows whose neighbors are searched together
_MAX_VISITED_ROWS = 2_000  # while augmenting the matching
_MAX_NUMBER = 1e100  # of attributes; moments are products of four of them
_MAX_DISTANCES = 4_000_000  # pairwise distances between moved primitives; beyond that, they are paired in order
_BLOCK = "block"
_NO_ORIENTATION = Symmetry()
_ONES: Point = (1.0, 1.0, 1.0)
_ORIGIN: Point = (0.0, 0.0, 0.0)
_ZERO = np.zeros(1, np.int64)


# --- features of primitives --------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class ComparedSolid:
    """The compared properties of a primitive, without its pose.

    Attributes
    ----------
    kind
        Word ("block" for all block words) and properties that no pose can change, such as the file of a mesh file.
    look
        Appearance of a block, which replaces its color; of other primitives the attributes of the material that differ
        from their defaults, such as ``:material "oak"``.
    size
        Size of a primitive without an axis.
    p0, p1, radius
        Endpoints and radius of a primitive with an axis, such as a cylinder.
    """

    word: str
    kind: str
    look: str
    color: Point
    size: Point = _ONES
    p0: Point = _ORIGIN
    p1: Point = _ORIGIN
    radius: float = 0.0
    is_computed: bool = False  # a computed solid, which equals those of its digest only

    @property
    def symmetry(self) -> Symmetry:
        """Which turns leave the primitive as it is, so that two poses that differ by one are equal."""
        if self.is_computed:
            return Symmetry(unknown=True)
        return _NO_ORIENTATION if self.is_block else class_of(self.word).symmetry

    @property
    def has_axis(self) -> bool:
        """Whether the primitive has endpoints, as a cylinder does."""
        return self.symmetry.axis

    @property
    def is_block(self) -> bool:
        """Whether the primitive is made of Minecraft blocks."""
        return self.word == _BLOCK


def solid_of(word: str, attributes: Mapping[str, Any], use_block_scale: bool = True) -> ComparedSolid:
    """Return the solid for a word and its attributes as plain data.

    Parameters
    ----------
    use_block_scale
        Whether a block's ``scale`` is part of its size; in golden files the matrix contains it.

    Raises
    ------
    ValueError
        If an attribute is malformed.
    """
    values = {name.lstrip(":").replace("-", "_"): value for name, value in attributes.items()}
    cls = find(word.replace("_", "-")) if "_" in word else None  # the paper's tool writes block words with underscores
    cls = cls if cls is not None and cls.is_block else class_of(word)
    if cls.is_block or word == _BLOCK:
        size = _size(values.get("scale")) if use_block_scale else _ONES
        return ComparedSolid(_BLOCK, _BLOCK, _block_look(values), _ORIGIN, size)
    color, look = _color(values.get("color")), _material(values)
    if isinstance(values.get("solid"), str):
        return ComparedSolid(word, f"{word} {values['solid']}", look, color, is_computed=True)
    numbers = {name: _checked(values[name]) for name in _geometry_of(cls) if values.get(name) is not None}
    detail, fixed_size = cls.comparison_key({**values, **numbers})
    kind = f"{word} {detail}" if detail else word
    if cls.symmetry.axis:
        p0, p1 = _point(values.get("p0", _ORIGIN)), _point(values.get("p1", (0.0, 1.0, 0.0)))
        radius = _number(values.get("radius", 1.0))
        return ComparedSolid(word, kind, look, color, p0=p0, p1=p1, radius=radius)
    size = _size(values.get("scale")) if fixed_size is None else fixed_size
    return ComparedSolid(word, kind, look, color, size)


def _material(values: Mapping[str, Any]) -> str:
    """Format the attributes of a material that differ from their defaults, such as ``:metallic 1 :roughness 0.2``."""
    given = ((attribute, values.get(attribute.name)) for attribute in MATERIALS)
    return " ".join(
        f":{attribute.name} {_written(value)}"
        for attribute, value in given
        if value is not None and value != attribute.default
    )


def _written(value: Any) -> str:
    """Format a value of plain data; numbers that differ by rounding are equal."""
    if isinstance(value, (list, tuple)):
        return f"[{' '.join(map(_written, value))}]"
    return f"{value + 0.0:.6g}" if type(value) in (int, float) else json.dumps(value, sort_keys=True)


def _geometry_of(cls: type[Primitive]) -> Iterator[str]:
    """Iterate over the attributes that the geometry of a primitive depends on, with underscores."""
    return (attribute.name.replace("-", "_") for attribute in cls.attributes if attribute.read is not None)


def _checked(value: Any) -> Any:
    """Validate a number or a list of three numbers."""
    return _point(value) if isinstance(value, (list, tuple)) else _number(value)


def _number(value: Any) -> float:
    """Validate a finite number."""
    if type(value) not in (int, float):
        raise ValueError("has an attribute that is not a number")
    try:
        number = float(value)
    except OverflowError:
        raise ValueError("has a number outside the supported range") from None
    if not abs(number) < _MAX_NUMBER:  # nan too
        raise ValueError("has a number outside the supported range")
    return number


def _point(value: Any) -> Point:
    """Validate a list of three numbers."""
    if not isinstance(value, (list, tuple)) or len(value) != 3:
        raise ValueError("has an attribute that is not a list of three numbers")
    x, y, z = map(_number, value)
    return (x, y, z)


def _size(value: Any) -> Point:
    """Return the three side lengths of a ``scale``, 1 by default."""
    if value is None:
        return _ONES
    return _point(value) if isinstance(value, (list, tuple)) else (_number(value),) * 3


def _color(value: Any) -> Point:
    """Return a color clamped to [0, 1], white by default."""
    if value is None or value == []:
        return _ONES
    if not isinstance(value, (list, tuple)):
        raise ValueError("has a color that is not a list of three numbers")
    r, g, b = (min(1.0, max(0.0, x)) for x in _point(value[:3]))
    return (r, g, b)


def _block_look(values: Mapping[str, Any]) -> str:
    """Format type, keywords and fill of a block, such as ``minecraft:oak_log[axis=y]``."""
    keywords = values.get("block_kwargs") or {}
    if isinstance(keywords, list):
        if not all(isinstance(pair, list) and len(pair) == 2 for pair in keywords):
            raise ValueError("has `block_kwargs` that are not name-value pairs")
        keywords = {_keyword_text(name): value for name, value in keywords}
    if not isinstance(keywords, dict):
        raise ValueError("has `block_kwargs` that are not name-value pairs")
    states = ",".join(f"{name}={_keyword_text(value)}" for name, value in sorted(keywords.items()))
    fill = "" if values.get("fill", True) else " hollow"
    return f"{values.get('block_type') or 'minecraft:air'}{f'[{states}]' if states else ''}{fill}"


def _keyword_text(value: Any) -> str:
    """Return a name or value of a block state as text."""
    return value if isinstance(value, str) else json.dumps(value)


@dataclass(frozen=True, slots=True, eq=False)
class ComparedFrame:
    """Primitives of one frame, N rows.

    Attributes
    ----------
    solids, index : (N,)
        Row ``i`` is ``solids[index[i]]``.
    matrices : (N, 3, 4)
        Upper three rows of the world matrices.
    paths, path_index : (N,)
        ``paths[path_index[i]]`` are the words from the root to the parent of row ``i``; empty if unknown.
    """

    solids: tuple[ComparedSolid, ...]
    index: Ints  # (N,)
    matrices: Floats  # (N, 3, 4)
    paths: tuple[tuple[str, ...], ...]
    path_index: Ints  # (N,)

    def __len__(self) -> int:
        return len(self.index)

    def solid(self, row: int) -> ComparedSolid:
        """Return the solid of a row."""
        return self.solids[int(self.index[row])]

    def labels(self, rows: Iterable[int]) -> list[str]:
        """Return readable labels of rows: ``tower/step[3]`` is the fourth primitive directly below ``tower/step``."""
        order = np.argsort(self.path_index, kind="stable")
        place = np.empty(len(self), np.int64)
        counts = np.bincount(self.path_index, minlength=len(self.paths))
        starts = np.cumsum(counts) - counts
        place[order] = np.arange(len(self)) - starts[self.path_index[order]]
        labels = []
        for row in rows:
            path = int(self.path_index[row])
            number = f"[{place[row]}]" if counts[path] > 1 or not self.paths[path] else ""
            labels.append("/".join(self.paths[path]) + number)
        return labels


def compared_frame(frame: FlatFrame) -> ComparedFrame:
    """Convert a flattened frame for comparison; raise ``SceneError("attribute")`` for malformed attributes."""
    try:
        solids = tuple(solid_of(entity.word, primitive_attributes(entity)) for entity in frame.primitives)
    except ValueError as error:
        raise SceneError("attribute", f"cannot compare the scene: a primitive {error}") from None
    index, path_index = frame.index.astype(np.int64), frame.path_index.astype(np.int64)
    return ComparedFrame(solids, index, frame.matrices, frame.paths, path_index)


@dataclass(frozen=True, slots=True, eq=False)
class _Features:
    """Feature vectors of the primitives of a frame, N rows. Lengths are in units of the size of the scene.

    Attributes
    ----------
    kind, look : (N,)
        Integers that identify kinds and looks, shared by both frames.
    lengths : (N, 6)
        Endpoints of a primitive with an axis; position and size of a block; else the position and zeros.
    moments : (N, 6)
        Second moments xx, yy, zz, xy, xz, yz.
    orientation : (N, 15)
        Orientation of primitives that the moments do not determine, scaled by ``extent``; else zeros.
    extent : (N,)
        Root sum of squares of the edge lengths.
    colors : (N, 3)
        Linear sRGB.
    location : (N, 3)
        Representative point: the midpoint of the axis, else the position.
    has_axis : (N,)
        Whether ``lengths`` holds the endpoints of an axis.
    """

    kind: Ints  # (N,)
    look: Ints  # (N,)
    lengths: Floats  # (N, 6)
    moments: Floats  # (N, 6)
    orientation: Floats  # (N, 15)
    extent: Floats  # (N,)
    colors: Floats  # (N, 3)
    location: Floats  # (N, 3)
    has_axis: Bools  # (N,)

    def __len__(self) -> int:
        return len(self.kind)

    def take(self, rows: Ints) -> _Features:
        """Return the features of some rows."""
        return _Features(
            self.kind[rows], self.look[rows], self.lengths[rows], self.moments[rows], self.orientation[rows],
            self.extent[rows], self.colors[rows], self.location[rows], self.has_axis[rows],
        )  # fmt: skip


def _features(frame: ComparedFrame, kinds: dict[str, int], looks: dict[str, int]) -> _Features:
    """Return the features of a frame in scene units, before normalization."""
    solids = frame.solids
    has_axis = np.array([solid.has_axis for solid in solids], np.bool_)[frame.index]
    is_block = np.array([solid.is_block for solid in solids], np.bool_)[frame.index]
    with np.errstate(all="ignore"):  # the caller reports overflow
        start, end = _endpoints(frame, has_axis, is_block)
        moments = _moments(frame, has_axis)
        orientation, extent = _orientations(frame)
        location = np.where(has_axis[:, None], (start + end) / 2, start)
    moments[is_block] = 0.0
    return _Features(
        _intern([solid.kind for solid in solids], kinds)[frame.index],
        _intern([solid.look for solid in solids], looks)[frame.index],
        np.hstack([start, end]),
        moments[:, (0, 1, 2, 0, 0, 1), (0, 1, 2, 1, 2, 2)],
        orientation,
        extent,
        _points(frame, [solid.color for solid in solids]),
        location,
        has_axis,
    )


def _intern(names: Sequence[str], numbers: dict[str, int]) -> Ints:
    """Map names to integers; new names are added to ``numbers``."""
    return np.array([numbers.setdefault(name, len(numbers)) for name in names], np.int64)


def _points(frame: ComparedFrame, points: Sequence[Point]) -> Floats:
    """Return for each of the N primitives the point (3,) of its solid; ``points`` has one for each solid."""
    of_rows: Floats = np.array(points, np.float64).reshape(-1, 3)[frame.index]
    return of_rows


def _endpoints(frame: ComparedFrame, has_axis: Bools, is_block: Bools) -> tuple[Floats, Floats]:
    """Return both points of ``_Features.lengths``, (N, 3) each."""
    linear, position = frame.matrices[:, :, :3], frame.matrices[:, :, 3]
    p0, p1 = (
        _points(frame, points)
        for points in ([solid.p0 for solid in frame.solids], [solid.p1 for solid in frame.solids])
    )
    size = np.einsum("nii->ni", linear) * _points(frame, [solid.size for solid in frame.solids])
    start = np.where(has_axis[:, None], np.einsum("nij,nj->ni", linear, p0) + position, position)
    end = np.where(has_axis[:, None], np.einsum("nij,nj->ni", linear, p1) + position, 0.0)
    return start, np.where(is_block[:, None], size, end)


def _moments(frame: ComparedFrame, has_axis: Bools) -> Floats:
    """Return second moments (N, 3, 3) up to a factor, of the cross-section of a primitive with an axis, else of all."""
    linear, solids = frame.matrices[:, :, :3], frame.solids
    axis = _points(frame, [solid.p1 for solid in solids]) - _points(frame, [solid.p0 for solid in solids])
    length = np.linalg.norm(axis, axis=1, keepdims=True)
    axis = axis / np.where(length > 0, length, 1.0)
    radius = np.array([solid.radius for solid in solids])[frame.index, None, None]
    across = (np.eye(3) - axis[:, :, None] * axis[:, None, :]) * radius**2
    stretched = np.eye(3) * (_points(frame, [solid.size for solid in solids]) ** 2)[:, :, None]
    moments: Floats = linear @ np.where(has_axis[:, None, None], across, stretched) @ linear.transpose(0, 2, 1)
    return moments


# Index tuples of the 15 independent components of a symmetric fourth-order tensor in three dimensions.
_TENSOR_INDICES = [(i, j, k, m) for i in range(3) for j in range(i, 3) for k in range(j, 3) for m in range(k, 3)]


def _orientations(frame: ComparedFrame) -> tuple[Floats, Floats]:
    """Return ``_Features.orientation``, (N, 15), and ``_Features.extent``, (N,).

    For cubes, the orientation is the fourth-moment tensor of the unit edge vectors, which is invariant under
    permutation and sign of the edges. For primitives without known symmetry, it is the edge vectors themselves. Both
    are multiplied by the extent.
    """
    size = _points(frame, [solid.size for solid in frame.solids])  # (N, 3), along the local axes
    edges = frame.matrices[:, :, :3] * size[:, None, :]  # (N, 3, 3); each column is an edge vector in world space
    length = np.sqrt((edges**2).sum(axis=(1, 2)))[:, None]
    unit = edges / np.where(length > 0, length, 1.0)[:, :, None]
    is_cube = np.array([solid.symmetry.edges for solid in frame.solids], np.bool_)[frame.index]
    is_asymmetric = np.array([solid.symmetry.unknown for solid in frame.solids], np.bool_)[frame.index]
    orientation = np.zeros((len(frame), len(_TENSOR_INDICES)))
    for column, (i, j, k, m) in enumerate(_TENSOR_INDICES):
        orientation[:, column] = (unit[:, i] * unit[:, j] * unit[:, k] * unit[:, m]).sum(axis=1) * is_cube
    orientation[is_asymmetric, :9] = unit[is_asymmetric].reshape(-1, 9)
    return orientation * length, length[:, 0]


def _scene_size(a: _Features, b: _Features) -> float:
    """Return the extent of the positions of all primitives, or of the largest one if all positions coincide."""
    points = np.vstack([a.lengths[:, :3], b.lengths[:, :3]])
    with np.errstate(all="ignore"):
        size = float(np.ptp(points, axis=0).max()) if len(points) else 0.0
    if size < _MIN_SCENE_SIZE:
        squares = np.vstack([a.moments[:, :3], b.moments[:, :3]])
        size = max(_MIN_SCENE_SIZE, float(np.sqrt(squares.max(initial=0.0))))
    return size


def _normalized(rows: _Features, size: float) -> _Features:
    """Divide all lengths by ``size``; raise ``SceneError("pose")`` on overflow."""
    with np.errstate(all="ignore"):
        lengths, location = rows.lengths / size, rows.location / size
        moments, orientation, extent = rows.moments / size / size, rows.orientation / size, rows.extent / size
    if not all(np.isfinite(numbers).all() for numbers in (lengths, moments, orientation)):
        raise SceneError("pose", "the coordinates of the scene are too large to compare")
    return _Features(rows.kind, rows.look, lengths, moments, orientation, extent, rows.colors, location, rows.has_axis)


# --- pairing -----------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class _Rule:
    """Rule for pairing rows: their geometry, and with ``colored`` also their appearance, agree within a tolerance."""

    tolerance: float
    colored: bool

    def holds(self, a: _Features, b: _Features) -> Bools:
        """Return whether each row of ``a`` agrees with the same row of ``b``, (N,)."""
        agree: Bools = a.kind == b.kind
        agree &= (np.abs(a.lengths - b.lengths) <= self.tolerance).all(axis=1)
        apart = np.abs(a.moments - b.moments).max(axis=1, initial=0.0)
        agree &= apart <= _MOMENT_FACTOR * self.tolerance
        # A small cube may be slightly stretched within the tolerance of its moments, which also rotates its edges.
        stretched = np.where(a.extent > 0, apart / np.where(a.extent > 0, a.extent, 1.0), 0.0)
        turned = np.abs(a.orientation - b.orientation).max(axis=1, initial=0.0)
        agree &= turned <= _ORIENTATION_FACTOR * self.tolerance + _STRETCH_FACTOR * stretched
        if self.colored:
            agree &= (a.look == b.look) & (np.abs(a.colors - b.colors) <= COLOR_TOLERANCE).all(axis=1)
        return agree

    def columns(self, rows: _Features) -> list[Floats]:
        """Return the compared features in units of their tolerances."""
        step = max(self.tolerance, 1e-12)  # not 0, for a division
        columns = [rows.kind[:, None].astype(np.float64), rows.lengths / step, rows.moments / (_MOMENT_FACTOR * step)]
        columns.append(rows.orientation / (_ORIENTATION_FACTOR * step))
        if self.colored:
            columns += [rows.look[:, None].astype(np.float64), rows.colors / COLOR_TOLERANCE]
        return columns


def _hash(columns: Sequence[Floats], shift: float = 0.0) -> Hashes:
    """Hash each row to the cell of a unit grid, offset by ``shift``. Cells may collide, so check the rows it pairs."""
    mixed = np.zeros(len(columns[0]), np.uint64)
    with np.errstate(over="ignore"):
        for block in columns:
            for column in (np.floor(block + shift) + 0.0).T:  # no -0.0
                mixed = _mix(mixed ^ np.ascontiguousarray(column).view(np.uint64))
    return mixed


def _mix(numbers: Hashes) -> Hashes:
    """Apply a bijective 64-bit finalizer (multiply and xorshift, after SplitMix64)."""
    numbers = numbers * np.uint64(0x9E3779B97F4A7C15)
    numbers ^= numbers >> np.uint64(29)
    numbers *= np.uint64(0xBF58476D1CE4E5B9)
    mixed: Hashes = numbers ^ (numbers >> np.uint64(32))
    return mixed


def _disambiguated(hashes: Hashes) -> Hashes:
    """Combine each hash with the number of earlier rows that have it, so that duplicates are paired one to one."""
    order = np.argsort(hashes, kind="stable")
    ordered = hashes[order]
    first = np.r_[True, ordered[1:] != ordered[:-1]] if len(ordered) else np.zeros(0, np.bool_)
    starts = np.flatnonzero(first)
    rank = np.empty(len(hashes), np.uint64)
    rank[order] = np.arange(len(hashes)) - np.repeat(starts, np.diff(np.r_[starts, len(hashes)]))
    with np.errstate(over="ignore"):
        return _mix(hashes + rank * np.uint64(0xD6E8FEB86659FD93))


class _Pairing:
    """One-to-one pairing of the rows of ``a`` and ``b``; -1 marks an unpaired row."""

    def __init__(self, a: _Features, b: _Features) -> None:
        self.a, self.b = a, b
        self.partner_of_a = np.full(len(a), -1, np.int64)
        self.partner_of_b = np.full(len(b), -1, np.int64)

    def unpaired(self) -> tuple[Ints, Ints]:
        """Return the unpaired rows of both sides, ascending."""
        return np.flatnonzero(self.partner_of_a < 0), np.flatnonzero(self.partner_of_b < 0)

    def join(self, rows_a: Ints, rows_b: Ints) -> None:
        """Pair rows of both sides."""
        self.partner_of_a[rows_a] = rows_b
        self.partner_of_b[rows_b] = rows_a

    def match(self, rule: _Rule) -> None:
        """Pair as many unpaired rows that satisfy the rule as possible."""
        self._by_index(rule)
        for shift in _SHIFTS:
            if not self._by_cell(rule, shift):
                return
        self._by_neighbors(rule)

    def _by_index(self, rule: _Rule) -> None:
        """Pair rows with the same index: two versions of a program mostly agree in order."""
        count = min(len(self.a), len(self.b))
        both = np.flatnonzero((self.partner_of_a[:count] < 0) & (self.partner_of_b[:count] < 0))
        agree = both[rule.holds(self.a.take(both), self.b.take(both))]
        self.join(agree, agree)

    def _by_cell(self, rule: _Rule, shift: float) -> bool:
        """Pair unpaired rows in the same grid cell; return whether unpaired rows remain on both sides."""
        rows_a, rows_b = self.unpaired()
        if not len(rows_a) or not len(rows_b):
            return False
        left, right = self.a.take(rows_a), self.b.take(rows_b)
        by_color_a, by_color_b = np.lexsort(left.colors.T), np.lexsort(right.colors.T)  # similar colors first
        hash_a = _disambiguated(_hash(rule.columns(left), shift)[by_color_a])
        hash_b = _disambiguated(_hash(rule.columns(right), shift)[by_color_b])
        _, i, j = np.intersect1d(hash_a, hash_b, return_indices=True)
        i, j = by_color_a[i], by_color_b[j]
        agree = rule.holds(left.take(i), right.take(j))
        self.join(rows_a[i[agree]], rows_b[j[agree]])
        return bool(agree.sum() < min(len(rows_a), len(rows_b)))

    def _by_neighbors(self, rule: _Rule) -> None:
        """Pair the remaining rows greedily by color distance, then augment the pairing to a maximum matching."""
        rows_a, rows_b = self.unpaired()
        near = _Neighbors(self.b.take(rows_b), rule)
        for start in range(0, len(rows_a), _CHUNK_ROWS):
            chunk = rows_a[start : start + _CHUNK_ROWS]
            i, j, distance = near.edges(self.a.take(chunk))
            for edge in np.argsort(distance, kind="stable").tolist():
                row, other = chunk[i[edge]], rows_b[j[edge]]
                if self.partner_of_a[row] < 0 and self.partner_of_b[other] < 0:
                    self.partner_of_a[row], self.partner_of_b[other] = other, row
        if rule.colored:
            self._augment(rule)

    def _augment(self, rule: _Rule) -> None:
        """Search augmenting paths from the unpaired rows of ``a``.

        Without one, a matching is maximum (Berge's theorem).
        """
        rows_a, rows_b = self.unpaired()
        if not len(rows_a) or not len(rows_b):
            return
        near = _Neighbors(self.b, rule)
        rows_with_neighbors, _, _ = near.edges(self.a.take(rows_a[:_CHUNK_ROWS]))
        searches = [_MAX_VISITED_ROWS]
        visited: set[int] = set()  # rows of b of failed searches, from which no unpaired row can be reached
        for row in rows_a[np.unique(rows_with_neighbors)].tolist():
            self._search(row, near, visited, searches)

    def _search(self, row: int, near: _Neighbors, visited: set[int], searches: list[int]) -> None:
        """Search an augmenting path from ``row`` in breadth-first order, and apply it.

        ``searches[0]`` is the remaining number of visited rows.
        """
        came_from: dict[int, int] = {}  # row of a from which each row of b was reached
        queue = deque([row])
        while queue and searches[0] > 0:
            searches[0] -= 1
            current = queue.popleft()
            _, neighbors, _ = near.edges(self.a.take(np.array([current], np.int64)))
            for other in neighbors.tolist():
                if other in visited or other in came_from:
                    continue
                came_from[other] = current
                if self.partner_of_b[other] < 0:
                    self._apply_path(row, other, came_from)
                    return
                queue.append(int(self.partner_of_b[other]))
        visited.update(came_from)

    def _apply_path(self, row: int, other: int, came_from: dict[int, int]) -> None:
        """Re-pair the rows along the path from ``row`` to ``other``."""
        while True:
            current = came_from[other]
            before = int(self.partner_of_a[current])
            self.partner_of_a[current], self.partner_of_b[other] = other, current
            if current == row:
                return
            other = before


class _Neighbors:
    """Spatial grid over the positions of rows, to find the rows that a rule pairs with given ones."""

    def __init__(self, rows: _Features, rule: _Rule) -> None:
        self._rows = rows
        self._rule = rule
        self._step = 2 * max(rule.tolerance, 1e-12)
        keys = self._keys(rows, np.zeros(3))[0]
        self._order = np.argsort(keys, kind="stable")
        self._sorted = keys[self._order]

    def _keys(self, rows: _Features, offset: Floats) -> tuple[Hashes, Floats]:
        """Return the hashes of the cells of rows, and the cells (N, 3), after a shift by ``offset`` cells."""
        cells = np.floor(rows.lengths[:, :3] / self._step + offset)
        return _hash([rows.kind[:, None].astype(np.float64), cells]), cells

    def edges(self, rows: _Features) -> tuple[Ints, Ints, Floats]:
        """Return the pairs (given row, found row) that satisfy the rule, and their color distances."""
        given_rows, found_rows = [np.zeros(0, np.int64)], [np.zeros(0, np.int64)]
        low = self._keys(rows, np.full(3, -0.5))[1]
        for corner in range(8):  # the cells that the tolerance box around a row touches
            sides = np.array([corner & 1, corner >> 1 & 1, corner >> 2], np.float64)
            keys, cells = self._keys(rows, sides - 0.5)
            touched = ((cells != low) | (sides == 0)).all(axis=1)
            first = np.searchsorted(self._sorted, keys, "left")
            count = np.minimum(np.searchsorted(self._sorted, keys, "right") - first, _MAX_CANDIDATES) * touched
            i = np.repeat(np.arange(len(rows)), count)
            within = np.arange(len(i)) - np.repeat(np.cumsum(count) - count, count)
            j = self._order[first[i] + within]
            agree = self._rule.holds(rows.take(i), self._rows.take(j))
            given_rows.append(i[agree])
            found_rows.append(j[agree])
        i, j = np.concatenate(given_rows), np.concatenate(found_rows)
        apart = np.abs(rows.colors[i] - self._rows.colors[j]).max(axis=1, initial=0.0)
        return i, j, apart + (rows.look[i] != self._rows.look[j])


# --- moved primitives --------------------------------------------------------------------------------------------


def _shape_columns(rows: _Features, tolerance: float) -> list[Floats]:
    """Return the features that are invariant under rigid motion, in units of their tolerances."""
    xx, yy, zz, xy, xz, yz = rows.moments.T
    matrices = np.stack([xx, xy, xz, xy, yy, yz, xz, yz, zz], axis=1).reshape(-1, 3, 3)
    principal = np.linalg.eigvalsh(matrices)  # the eigenvalues of the moments do not depend on the orientation
    step = max(tolerance, 1e-12)
    axis = np.linalg.norm(rows.lengths[:, 3:] - rows.lengths[:, :3], axis=1, keepdims=True)
    size = np.where(rows.has_axis[:, None], axis, rows.lengths[:, 3:])
    identity = np.stack([rows.kind, rows.look], axis=1).astype(np.float64)
    return [identity, rows.colors / COLOR_TOLERANCE, principal / (_MOMENT_FACTOR * step), size / step]


def _pair_moved(a: _Features, b: _Features, tolerance: float) -> tuple[Ints, Ints]:
    """Return the rows of both sides that are pairs of the same shape and appearance, nearest first.

    Rows are compared if their values lie in one cell of a grid. What the border of a cell separates is in one cell of
    a grid with another offset, so the rows that remain try those in turn.
    """
    pairs_a, pairs_b = [np.zeros(0, np.int64)], [np.zeros(0, np.int64)]
    left, right = np.arange(len(a)), np.arange(len(b))
    columns_a, columns_b = _shape_columns(a, tolerance), _shape_columns(b, tolerance)
    budget = _MAX_DISTANCES
    for shift in _SHIFTS:
        hash_a = _hash([block[left] for block in columns_a], shift)
        hash_b = _hash([block[right] for block in columns_b], shift)
        for group_a, group_b in _groups(hash_a, hash_b):
            rows_a, rows_b = left[group_a], right[group_b]
            distances = len(rows_a) * len(rows_b)
            if distances <= budget:
                budget -= distances
                i, j = _pair_nearest(a.location[rows_a], b.location[rows_b])
            else:
                i, j = _pair_in_order(a.location[rows_a], b.location[rows_b])
            pairs_a.append(rows_a[i])
            pairs_b.append(rows_b[j])
        left = np.setdiff1d(np.arange(len(a)), np.concatenate(pairs_a))
        right = np.setdiff1d(np.arange(len(b)), np.concatenate(pairs_b))
        if not len(left) or not len(right):
            break
    return np.concatenate(pairs_a), np.concatenate(pairs_b)


def _groups(hash_a: Hashes, hash_b: Hashes) -> Iterable[tuple[Ints, Ints]]:
    """Iterate over the rows of both sides for each hash that occurs in both."""
    order_a, order_b = np.argsort(hash_a, kind="stable"), np.argsort(hash_b, kind="stable")
    sorted_a, sorted_b = hash_a[order_a], hash_b[order_b]
    shared = np.intersect1d(hash_a, hash_b)
    ends = [np.searchsorted(x, shared, side) for x in (sorted_a, sorted_b) for side in ("left", "right")]
    for a0, a1, b0, b1 in zip(*(end.tolist() for end in ends)):
        yield order_a[a0:a1], order_b[b0:b1]


def _pair_nearest(a: Floats, b: Floats) -> tuple[Ints, Ints]:
    """Pair points greedily by increasing distance."""
    if len(a) == len(b) == 1:
        return _ZERO, _ZERO
    distance = np.abs(a[:, None, :] - b[None, :, :]).max(axis=2)  # the largest difference of a coordinate
    free_a, free_b = [True] * len(a), [True] * len(b)
    pairs: list[tuple[int, int]] = []
    for flat in np.argsort(distance, axis=None, kind="stable").tolist():
        i, j = divmod(flat, len(b))
        if free_a[i] and free_b[j]:
            free_a[i] = free_b[j] = False
            pairs.append((i, j))
            if len(pairs) == min(len(a), len(b)):
                break
    return np.array([i for i, _ in pairs], np.int64), np.array([j for _, j in pairs], np.int64)


def _pair_in_order(a: Floats, b: Floats) -> tuple[Ints, Ints]:
    """Pair points by their lexicographic order (x, y, z), which a common translation preserves."""
    count = min(len(a), len(b))
    return np.lexsort(a.T[::-1])[:count], np.lexsort(b.T[::-1])[:count]


# --- comparison --------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True, eq=False)
class FrameDifference:
    """Difference between two frames A and B, as row indices.

    Attributes
    ----------
    matched
        Number of equal primitives.
    moved, recolored : (n, 2)
        Pairs of rows of A and B.
    missing : (n,)
        Rows only in A.
    extra : (n,)
        Rows only in B.
    positions_a, positions_b : (N, 3)
        Location of each row, in scene units.
    """

    matched: int
    moved: Ints
    recolored: Ints
    missing: Ints
    extra: Ints
    positions_a: Floats
    positions_b: Floats

    @property
    def equal(self) -> bool:
        """Whether all primitives are equal."""
        return not (len(self.moved) or len(self.recolored) or len(self.missing) or len(self.extra))


def compare_frames(a: ComparedFrame, b: ComparedFrame, tolerance: float = TOLERANCE) -> FrameDifference:
    """Compare two frames.

    As many equal primitives as possible are paired first. Of the remaining ones, those of the same geometry count as
    recolored, then those of the same shape and color as moved.

    Parameters
    ----------
    a, b
        Frames to compare.
    tolerance
        Tolerance of lengths, relative to the extent of the positions of both frames.
    """
    kinds: dict[str, int] = {}
    looks: dict[str, int] = {}
    features_a, features_b = _features(a, kinds, looks), _features(b, kinds, looks)
    size = _scene_size(features_a, features_b)
    rows_a, rows_b = _normalized(features_a, size), _normalized(features_b, size)
    same = _Pairing(rows_a, rows_b)
    same.match(_Rule(tolerance, colored=True))
    free_a, free_b = same.unpaired()
    recolored = _pairs_among(
        free_a, free_b, lambda: _pair_recolored(rows_a.take(free_a), rows_b.take(free_b), tolerance)
    )
    free_a, free_b = np.setdiff1d(free_a, recolored[:, 0]), np.setdiff1d(free_b, recolored[:, 1])
    moved = _pairs_among(free_a, free_b, lambda: _pair_moved(rows_a.take(free_a), rows_b.take(free_b), tolerance))
    return FrameDifference(
        int((same.partner_of_a >= 0).sum()), moved, recolored,
        np.setdiff1d(free_a, moved[:, 0]), np.setdiff1d(free_b, moved[:, 1]),
        features_a.location, features_b.location,
    )  # fmt: skip


def _pair_recolored(a: _Features, b: _Features, tolerance: float) -> tuple[Ints, Ints]:
    """Pair rows of the same geometry, whatever their color."""
    pairing = _Pairing(a, b)
    pairing.match(_Rule(tolerance, colored=False))
    i = np.flatnonzero(pairing.partner_of_a >= 0)
    return i, pairing.partner_of_a[i]


def _pairs_among(rows_a: Ints, rows_b: Ints, pair: Callable[[], tuple[Ints, Ints]]) -> Ints:
    """Return the pairs that ``pair`` finds among the given rows, as rows of the frames (n, 2) in ascending order."""
    if not len(rows_a) or not len(rows_b):
        return np.zeros((0, 2), np.int64)
    i, j = pair()
    pairs = np.stack([rows_a[i], rows_b[j]], axis=1)
    ordered: Ints = pairs[np.argsort(pairs[:, 0], kind="stable")]
    return ordered
