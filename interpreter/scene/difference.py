"""What differs between two flattened scenes: primitives compared as sets with multiplicity, by world-space geometry.

Two primitives are the same when they have one word, colour, and position and second moments within a tolerance that is
relative to the scene's size (so a cube turned by 90 degrees about itself is the same cube); blocks of Minecraft when
position, size, type, fill and keywords agree. Since second moments do not see how a cube is turned by 45 degrees, cubes
are told apart by fourth moments too; assets and words of unknown looks by their whole pose. What is left of both sides
is then paired as recoloured (same geometry) or moved (same size and colour), so that a change is told as one thing.

Everything is near-linear in the number of primitives: rows are paired by hashes of their numbers rounded to a grid, on
several grids since equal numbers may lie on both sides of a line; only what the grids leave is searched for neighbours.
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
from scenelang.interpreter.scene.primitives import Primitive, class_of, find
from scenelang.interpreter.scene.primitives.base import Symmetry

if TYPE_CHECKING:
    import numpy.typing as npt


Floats: TypeAlias = "npt.NDArray[np.float64]"
Ints: TypeAlias = "npt.NDArray[np.int64]"
Bools: TypeAlias = "npt.NDArray[np.bool_]"
Hashes: TypeAlias = "npt.NDArray[np.uint64]"
Point = tuple[float, float, float]

TOLERANCE = 1e-5
COLOR_TOLERANCE = 2e-3
_SMALLEST_SIZE = 1e-3
_MOMENTS = 4.0  # second moments are squares of lengths up to half the scene: their tolerance in units of the lengths'
_TURNS = 8.0
_STRETCH = 4.0
_SHIFTS = (0.317, 0.731, 0.113, 0.558)  # of the grids; no round number lies on their lines
_MOST_CANDIDATES = 64  # neighbours of one row that are looked at
_CHUNK = 50_000  # rows whose neighbours are looked at together
_MOST_SEARCHES = 2_000  # rows looked at while better pairings are sought
_MOST_DISTANCES = 4_000_000  # pairs of moved primitives whose distances are compared; beyond, they pair in order
_BLOCK = "block"
_STILL = Symmetry()
_WHITE: Point = (1.0, 1.0, 1.0)
_ORIGIN: Point = (0.0, 0.0, 0.0)
_FIRST = np.zeros(1, np.int64)


# --- primitives as numbers ---------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class ComparedSolid:
    """A primitive before its pose, as far as it is compared. ``kind`` is its word ("block" for all block words), with
    what no pose makes equal, such as the file of an asset; ``look`` is what a block has in place of a colour, "" for
    anything else. ``p0``, ``p1`` and ``radius`` belong to what has two ends, as cylinders, ``size`` to all others."""

    word: str
    kind: str
    look: str
    color: Point
    size: Point = _WHITE
    p0: Point = _ORIGIN
    p1: Point = _ORIGIN
    radius: float = 0.0

    @property
    def turn(self) -> Symmetry:
        """How it is told how one is turned."""
        return _STILL if self.is_block else class_of(self.word).turn

    @property
    def is_round(self) -> bool:
        return self.turn.ends

    @property
    def is_block(self) -> bool:
        return self.word == _BLOCK


def solid_of(word: str, attributes: Mapping[str, Any], scaled_blocks: bool = True) -> ComparedSolid:
    """The solid that a word and its attributes (plain data) are. ``scaled_blocks``: a block's ``scale`` counts; golden
    files have it in the matrix. Raises ValueError for attributes that are none."""
    given = {name.lstrip(":").replace("-", "_"): value for name, value in attributes.items()}
    cls = find(word.replace("_", "-")) if "_" in word else None  # the paper's tool spells blocks so
    cls = cls if cls is not None and cls.is_block else class_of(word)
    if cls.is_block or word == _BLOCK:
        size = _size(given.get("scale")) if scaled_blocks else _WHITE
        return ComparedSolid(_BLOCK, _BLOCK, _block_look(given), _ORIGIN, size)
    color = _color(given.get("color"))
    numbers = {name: _checked(given[name]) for name in _geometry_of(cls) if given.get(name) is not None}
    detail, own_size = cls.compared({**given, **numbers})
    kind = f"{word} {detail}" if detail else word
    if cls.turn.ends:
        p0, p1 = _point(given.get("p0", _ORIGIN)), _point(given.get("p1", (0.0, 1.0, 0.0)))
        radius = _number(given.get("radius", 1.0))
        return ComparedSolid(word, kind, "", color, p0=p0, p1=p1, radius=radius)
    size = _size(given.get("scale")) if own_size is None else own_size
    return ComparedSolid(word, kind, "", color, size)


def _geometry_of(cls: type[Primitive]) -> Iterator[str]:
    """The attributes that a primitive's geometry reads, as they are spelled here."""
    return (attribute.name.replace("-", "_") for attribute in cls.attributes if attribute.read is not None)


def _checked(value: Any) -> Any:
    """A number, or a list of three as a point, as it is."""
    return _point(value) if isinstance(value, (list, tuple)) else _number(value)


def _number(value: Any) -> float:
    if type(value) not in (int, float):
        raise ValueError("wants a number")
    try:
        number = float(value)
    except OverflowError:
        raise ValueError("wants a number of usual size") from None
    if not abs(number) < 1e100:  # nan too
        raise ValueError("wants a number of usual size")
    return number


def _point(value: Any) -> Point:
    if not isinstance(value, (list, tuple)) or len(value) != 3:
        raise ValueError("wants three numbers")
    x, y, z = map(_number, value)
    return (x, y, z)


def _size(value: Any) -> Point:
    if value is None:
        return _WHITE
    return _point(value) if isinstance(value, (list, tuple)) else (_number(value),) * 3


def _color(value: Any) -> Point:
    if value is None or value == []:
        return _WHITE
    if not isinstance(value, (list, tuple)):
        raise ValueError("wants a colour of three numbers")
    r, g, b = (min(1.0, max(0.0, x)) for x in _point(value[:3]))
    return (r, g, b)


def _block_look(given: Mapping[str, Any]) -> str:
    """Type, keywords and fill of a block as text, such as ``minecraft:oak_log[axis=y]``."""
    keywords = given.get("block_kwargs") or {}
    if isinstance(keywords, list):
        if not all(isinstance(pair, list) and len(pair) == 2 for pair in keywords):
            raise ValueError("wants block_kwargs by name")
        keywords = {_keyword_text(name): value for name, value in keywords}
    if not isinstance(keywords, dict):
        raise ValueError("wants block_kwargs by name")
    shown = ",".join(f"{name}={_keyword_text(value)}" for name, value in sorted(keywords.items()))
    fill = "" if given.get("fill", True) else " hollow"
    return f"{given.get('block_type') or 'minecraft:air'}{f'[{shown}]' if shown else ''}{fill}"


def _keyword_text(value: Any) -> str:
    return value if isinstance(value, str) else json.dumps(value)


@dataclass(frozen=True, slots=True, eq=False)
class Sheet:
    """One frame's primitives: row ``i`` is ``solids[index[i]]`` under ``matrices[i]``, the upper three rows of its
    world matrix; ``paths[path_index[i]]`` are the words from the root to its parent, empty where they are not known."""

    solids: tuple[ComparedSolid, ...]
    index: Ints  # (N,)
    matrices: Floats  # (N, 3, 4)
    paths: tuple[tuple[str, ...], ...]
    path_index: Ints  # (N,)

    def __len__(self) -> int:
        return len(self.index)

    def solid(self, row: int) -> ComparedSolid:
        return self.solids[int(self.index[row])]

    def labels(self, rows: Iterable[int]) -> list[str]:
        """How people find rows: ``tower/step[3]`` is the fourth primitive that stands directly in ``tower/step``."""
        order = np.argsort(self.path_index, kind="stable")
        place = np.empty(len(self), np.int64)
        counts = np.bincount(self.path_index, minlength=len(self.paths))
        starts = np.cumsum(counts) - counts
        place[order] = np.arange(len(self)) - starts[self.path_index[order]]
        found = []
        for row in rows:
            path = int(self.path_index[row])
            number = f"[{place[row]}]" if counts[path] > 1 or not self.paths[path] else ""
            found.append("/".join(self.paths[path]) + number)
        return found


def sheet_of(frame: FlatFrame) -> Sheet:
    """A flattened frame, to compare."""
    try:
        solids = tuple(solid_of(entity.word, primitive_attributes(entity)) for entity in frame.primitives)
    except ValueError as error:
        raise SceneError("attribute", f"a primitive of the scene cannot be compared: it {error}") from None
    return Sheet(solids, frame.index, frame.matrices, frame.paths, frame.path_index)


@dataclass(frozen=True, slots=True, eq=False)
class _Rows:
    """A sheet's primitives as numbers in units of the scene's size. ``kind`` and ``look`` are numbers common to both
    sheets. ``lengths``: the ends of cylinders and cones, position and size of blocks, else position and zeros.
    ``moments``: xx, yy, zz, xy, xz, yz. ``turns`` tells how a thing of equal moments is turned, in lengths, zeros where
    the moments tell all; ``extent`` is the common length of its edges. ``place`` is where a person would say that the
    primitive is."""

    kind: Ints  # (N,)
    look: Ints  # (N,)
    lengths: Floats  # (N, 6)
    moments: Floats  # (N, 6)
    turns: Floats  # (N, 15)
    extent: Floats  # (N,)
    colors: Floats  # (N, 3)
    place: Floats  # (N, 3)
    is_round: Bools  # (N,)

    def __len__(self) -> int:
        return len(self.kind)

    def take(self, rows: Ints) -> _Rows:
        return _Rows(
            self.kind[rows], self.look[rows], self.lengths[rows], self.moments[rows], self.turns[rows],
            self.extent[rows], self.colors[rows], self.place[rows], self.is_round[rows],
        )  # fmt: skip


def _world(sheet: Sheet, kinds: dict[str, int], looks: dict[str, int]) -> _Rows:
    """The rows of a sheet in the scene's own units."""
    solids = sheet.solids
    is_round = np.array([s.is_round for s in solids], np.bool_)[sheet.index]
    is_block = np.array([s.is_block for s in solids], np.bool_)[sheet.index]
    with np.errstate(all="ignore"):  # the caller tells what became infinite
        start, end = _ends(sheet, is_round, is_block)
        moments = _moments(sheet, is_round)
        turns, extent = _turns(sheet)
        place = np.where(is_round[:, None], (start + end) / 2, start)
    moments[is_block] = 0.0
    return _Rows(
        _numbers([s.kind for s in solids], kinds)[sheet.index],
        _numbers([s.look for s in solids], looks)[sheet.index],
        np.hstack([start, end]),
        moments[:, (0, 1, 2, 0, 0, 1), (0, 1, 2, 1, 2, 2)],
        turns,
        extent,
        _points(sheet, [s.color for s in solids]),
        place,
        is_round,
    )


def _numbers(names: Sequence[str], known: dict[str, int]) -> Ints:
    """A number for each name; ``known`` grows."""
    return np.array([known.setdefault(name, len(known)) for name in names], np.int64)


def _points(sheet: Sheet, points: Sequence[Point]) -> Floats:
    """A point of each row's solid, (N, 3)."""
    of_rows: Floats = np.array(points, np.float64).reshape(-1, 3)[sheet.index]
    return of_rows


def _ends(sheet: Sheet, is_round: Bools, is_block: Bools) -> tuple[Floats, Floats]:
    """The two points that ``_Rows.lengths`` holds, (N, 3) each."""
    linear, position = sheet.matrices[:, :, :3], sheet.matrices[:, :, 3]
    p0, p1 = (_points(sheet, points) for points in ([s.p0 for s in sheet.solids], [s.p1 for s in sheet.solids]))
    size = np.einsum("nii->ni", linear) * _points(sheet, [s.size for s in sheet.solids])
    start = np.where(is_round[:, None], np.einsum("nij,nj->ni", linear, p0) + position, position)
    end = np.where(is_round[:, None], np.einsum("nij,nj->ni", linear, p1) + position, 0.0)
    return start, np.where(is_block[:, None], size, end)


def _moments(sheet: Sheet, is_round: Bools) -> Floats:
    """Second moments up to a factor, (N, 3, 3): of the cross-section of cylinders and cones, else of the whole."""
    linear, solids = sheet.matrices[:, :, :3], sheet.solids
    axis = _points(sheet, [s.p1 for s in solids]) - _points(sheet, [s.p0 for s in solids])
    length = np.linalg.norm(axis, axis=1, keepdims=True)
    axis = axis / np.where(length > 0, length, 1.0)
    radius = np.array([s.radius for s in solids])[sheet.index, None, None]
    across = (np.eye(3) - axis[:, :, None] * axis[:, None, :]) * radius**2
    stretched = np.eye(3) * (_points(sheet, [s.size for s in solids]) ** 2)[:, :, None]
    found: Floats = linear @ np.where(is_round[:, None, None], across, stretched) @ linear.transpose(0, 2, 1)
    return found


_QUARTICS = [(i, j, k, m) for i in range(3) for j in range(i, 3) for k in range(j, 3) for m in range(k, 3)]


def _turns(sheet: Sheet) -> tuple[Floats, Floats]:
    """``_Rows.turns``, (N, 15), and ``extent``, (N,): of cubes the fourth moments of the directions of their edges,
    which no order or sign of the edges changes, of words of unknown looks the directions; both times the extent."""
    edges = sheet.matrices[:, :, :3] * _points(sheet, [s.size for s in sheet.solids])[:, None, :]
    length = np.sqrt((edges**2).sum(axis=(1, 2)))[:, None]
    unit = edges / np.where(length > 0, length, 1.0)[:, :, None]
    is_cube = np.array([s.turn.edges for s in sheet.solids], np.bool_)[sheet.index]
    is_whole = np.array([s.turn.whole for s in sheet.solids], np.bool_)[sheet.index]
    found = np.zeros((len(sheet), len(_QUARTICS)))
    for column, (i, j, k, m) in enumerate(_QUARTICS):
        found[:, column] = (unit[:, i] * unit[:, j] * unit[:, k] * unit[:, m]).sum(axis=1) * is_cube
    found[is_whole, :9] = unit[is_whole].reshape(-1, 9)
    return found * length, length[:, 0]


def _scene_size(a: _Rows, b: _Rows) -> float:
    """The extent of the primitives' positions; where they stand in one point, the extent of the largest."""
    points = np.vstack([a.lengths[:, :3], b.lengths[:, :3]])
    with np.errstate(all="ignore"):
        size = float(np.ptp(points, axis=0).max()) if len(points) else 0.0
    if size < _SMALLEST_SIZE:
        own = np.vstack([a.moments[:, :3], b.moments[:, :3]])
        size = max(_SMALLEST_SIZE, float(np.sqrt(own.max(initial=0.0))))
    return size


def _in_units(rows: _Rows, size: float) -> _Rows:
    with np.errstate(all="ignore"):
        lengths, place = rows.lengths / size, rows.place / size
        moments, turns, extent = rows.moments / size / size, rows.turns / size, rows.extent / size
    if not all(np.isfinite(numbers).all() for numbers in (lengths, moments, turns)):
        raise SceneError("pose", "the scene has poses with numbers too large to compare")
    return _Rows(rows.kind, rows.look, lengths, moments, turns, extent, rows.colors, place, rows.is_round)


# --- pairing -----------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class _Rule:
    """When two rows belong together: their geometry, and with ``colored`` their looks, agree within a tolerance."""

    tolerance: float
    colored: bool

    def holds(self, a: _Rows, b: _Rows) -> Bools:
        """Row by row, (N,)."""
        fits: Bools = a.kind == b.kind
        fits &= (np.abs(a.lengths - b.lengths) <= self.tolerance).all(axis=1)
        apart = np.abs(a.moments - b.moments).max(axis=1, initial=0.0)
        fits &= apart <= _MOMENTS * self.tolerance
        # a small thing may be stretched a little within the tolerance of its moments: its edges then turn with it
        stretched = np.where(a.extent > 0, apart / np.where(a.extent > 0, a.extent, 1.0), 0.0)
        fits &= np.abs(a.turns - b.turns).max(axis=1, initial=0.0) <= _TURNS * self.tolerance + _STRETCH * stretched
        if self.colored:
            fits &= (a.look == b.look) & (np.abs(a.colors - b.colors) <= COLOR_TOLERANCE).all(axis=1)
        return fits

    def columns(self, rows: _Rows) -> list[Floats]:
        """The numbers that agree, in units of their tolerances."""
        step = max(self.tolerance, 1e-12)
        found = [rows.kind[:, None].astype(np.float64), rows.lengths / step, rows.moments / (_MOMENTS * step)]
        found.append(rows.turns / (_TURNS * step))
        if self.colored:
            found += [rows.look[:, None].astype(np.float64), rows.colors / COLOR_TOLERANCE]
        return found


def _hash(columns: Sequence[Floats], shift: float = 0.0) -> Hashes:
    """One number per row for its cell on a grid of unit steps. Unequal cells may share one: check what it pairs."""
    mixed = np.zeros(len(columns[0]), np.uint64)
    with np.errstate(over="ignore"):
        for block in columns:
            for column in (np.floor(block + shift) + 0.0).T:  # no -0.0
                mixed = _mix(mixed ^ np.ascontiguousarray(column).view(np.uint64))
    return mixed


def _mix(numbers: Hashes) -> Hashes:
    numbers = numbers * np.uint64(0x9E3779B97F4A7C15)
    numbers ^= numbers >> np.uint64(29)
    numbers *= np.uint64(0xBF58476D1CE4E5B9)
    mixed: Hashes = numbers ^ (numbers >> np.uint64(32))
    return mixed


def _numbered(hashes: Hashes) -> Hashes:
    """Hashes that also tell the first row with a hash from the second, and so on."""
    order = np.argsort(hashes, kind="stable")
    ordered = hashes[order]
    first = np.r_[True, ordered[1:] != ordered[:-1]] if len(ordered) else np.zeros(0, np.bool_)
    starts = np.flatnonzero(first)
    rank = np.empty(len(hashes), np.uint64)
    rank[order] = np.arange(len(hashes)) - np.repeat(starts, np.diff(np.r_[starts, len(hashes)]))
    with np.errstate(over="ignore"):
        return _mix(hashes + rank * np.uint64(0xD6E8FEB86659FD93))


class _Pairing:
    """Which row of ``b`` each row of ``a`` is paired with; -1 for none. Rows are paired once."""

    def __init__(self, a: _Rows, b: _Rows) -> None:
        self.a, self.b = a, b
        self.of_a = np.full(len(a), -1, np.int64)
        self.of_b = np.full(len(b), -1, np.int64)

    def free(self) -> tuple[Ints, Ints]:
        return np.flatnonzero(self.of_a < 0), np.flatnonzero(self.of_b < 0)

    def join(self, rows_a: Ints, rows_b: Ints) -> None:
        self.of_a[rows_a] = rows_b
        self.of_b[rows_b] = rows_a

    def match(self, rule: _Rule) -> None:
        """Pair free rows for which the rule holds, as many as can be."""
        self._in_place(rule)
        for shift in _SHIFTS:
            if not self._by_cell(rule, shift):
                return
        self._by_neighbours(rule)

    def _in_place(self, rule: _Rule) -> None:
        """Rows at the same position in both: two versions of a program mostly agree in their order."""
        count = min(len(self.a), len(self.b))
        both = np.flatnonzero((self.of_a[:count] < 0) & (self.of_b[:count] < 0))
        fits = both[rule.holds(self.a.take(both), self.b.take(both))]
        self.join(fits, fits)

    def _by_cell(self, rule: _Rule, shift: float) -> bool:
        """Pair the free rows that lie in one cell of a grid; whether free rows are left on both sides."""
        rows_a, rows_b = self.free()
        if not len(rows_a) or not len(rows_b):
            return False
        left, right = self.a.take(rows_a), self.b.take(rows_b)
        by_color_a, by_color_b = np.lexsort(left.colors.T), np.lexsort(right.colors.T)  # like colours first
        hash_a = _numbered(_hash(rule.columns(left), shift)[by_color_a])
        hash_b = _numbered(_hash(rule.columns(right), shift)[by_color_b])
        _, i, j = np.intersect1d(hash_a, hash_b, return_indices=True)
        i, j = by_color_a[i], by_color_b[j]
        fits = rule.holds(left.take(i), right.take(j))
        self.join(rows_a[i[fits]], rows_b[j[fits]])
        return bool(fits.sum() < min(len(rows_a), len(rows_b)))

    def _by_neighbours(self, rule: _Rule) -> None:
        """Pair what the grids left: nearest in colour first, then by changing earlier pairs (a maximum matching)."""
        rows_a, rows_b = self.free()
        near = _Neighbours(self.b.take(rows_b), rule)
        for start in range(0, len(rows_a), _CHUNK):
            chunk = rows_a[start : start + _CHUNK]
            i, j, distance = near.edges(self.a.take(chunk))
            for edge in np.argsort(distance, kind="stable").tolist():
                row, other = chunk[i[edge]], rows_b[j[edge]]
                if self.of_a[row] < 0 and self.of_b[other] < 0:
                    self.of_a[row], self.of_b[other] = other, row
        if rule.colored:
            self._improve(rule)

    def _improve(self, rule: _Rule) -> None:
        """Alternating paths from free rows of ``a`` over paired ones to free rows of ``b``."""
        rows_a, rows_b = self.free()
        if not len(rows_a) or not len(rows_b):
            return
        near = _Neighbours(self.b, rule)
        lonely, _, _ = near.edges(self.a.take(rows_a[:_CHUNK]))
        searches = [_MOST_SEARCHES]
        visited: set[int] = set()  # rows of b from which no free row is reached, once a search has failed
        for row in rows_a[np.unique(lonely)].tolist():
            self._search(row, near, visited, searches)

    def _search(self, row: int, near: _Neighbours, visited: set[int], searches: list[int]) -> None:
        came_from: dict[int, int] = {}
        waiting = deque([row])
        while waiting and searches[0] > 0:
            searches[0] -= 1
            current = waiting.popleft()
            _, neighbours, _ = near.edges(self.a.take(np.array([current], np.int64)))
            for other in neighbours.tolist():
                if other in visited or other in came_from:
                    continue
                came_from[other] = current
                if self.of_b[other] < 0:
                    self._flip(row, other, came_from)
                    return
                waiting.append(int(self.of_b[other]))
        visited.update(came_from)

    def _flip(self, row: int, other: int, came_from: dict[int, int]) -> None:
        while True:
            current = came_from[other]
            before = int(self.of_a[current])
            self.of_a[current], self.of_b[other] = other, current
            if current == row:
                return
            other = before


class _Neighbours:
    """Finds the rows that a rule pairs with given ones, by a grid over their positions."""

    def __init__(self, rows: _Rows, rule: _Rule) -> None:
        self._rows = rows
        self._rule = rule
        self._step = 2 * max(rule.tolerance, 1e-12)
        keys = self._keys(rows, np.zeros(3))[0]
        self._order = np.argsort(keys, kind="stable")
        self._sorted = keys[self._order]

    def _keys(self, rows: _Rows, offset: Floats) -> tuple[Hashes, Floats]:
        cells = np.floor(rows.lengths[:, :3] / self._step + offset)
        return _hash([rows.kind[:, None].astype(np.float64), cells]), cells

    def edges(self, rows: _Rows) -> tuple[Ints, Ints, Floats]:
        """Pairs (given row, found row) for which the rule holds, and how far their colours are apart."""
        found_i, found_j = [np.zeros(0, np.int64)], [np.zeros(0, np.int64)]
        low = self._keys(rows, np.full(3, -0.5))[1]
        for corner in range(8):  # the cells that the box of the tolerance around a row touches
            sides = np.array([corner & 1, corner >> 1 & 1, corner >> 2], np.float64)
            keys, cells = self._keys(rows, sides - 0.5)
            touched = ((cells != low) | (sides == 0)).all(axis=1)
            first = np.searchsorted(self._sorted, keys, "left")
            count = np.minimum(np.searchsorted(self._sorted, keys, "right") - first, _MOST_CANDIDATES) * touched
            i = np.repeat(np.arange(len(rows)), count)
            within = np.arange(len(i)) - np.repeat(np.cumsum(count) - count, count)
            j = self._order[first[i] + within]
            fits = self._rule.holds(rows.take(i), self._rows.take(j))
            found_i.append(i[fits])
            found_j.append(j[fits])
        i, j = np.concatenate(found_i), np.concatenate(found_j)
        apart = np.abs(rows.colors[i] - self._rows.colors[j]).max(axis=1, initial=0.0)
        return i, j, apart + (rows.look[i] != self._rows.look[j])


# --- what moved --------------------------------------------------------------------------------------------------


def _shape_columns(rows: _Rows, tolerance: float) -> list[Floats]:
    """What stays the same when a primitive is moved and turned, in units of the tolerances."""
    xx, yy, zz, xy, xz, yz = rows.moments.T
    matrices = np.stack([xx, xy, xz, xy, yy, yz, xz, yz, zz], axis=1).reshape(-1, 3, 3)
    own = np.linalg.eigvalsh(matrices)
    step = max(tolerance, 1e-12)
    axis = np.linalg.norm(rows.lengths[:, 3:] - rows.lengths[:, :3], axis=1, keepdims=True)
    size = np.where(rows.is_round[:, None], axis, rows.lengths[:, 3:])
    identity = np.stack([rows.kind, rows.look], axis=1).astype(np.float64)
    return [identity, rows.colors / COLOR_TOLERANCE, own / (_MOMENTS * step), size / step]


def _moved(a: _Rows, b: _Rows, tolerance: float) -> tuple[Ints, Ints]:
    """Pairs of rows of the same shape and look, nearest first."""
    pairs_a, pairs_b = [np.zeros(0, np.int64)], [np.zeros(0, np.int64)]
    left, right = np.arange(len(a)), np.arange(len(b))
    columns_a, columns_b = _shape_columns(a, tolerance), _shape_columns(b, tolerance)
    room = _MOST_DISTANCES
    for shift in _SHIFTS:
        hash_a = _hash([block[left] for block in columns_a], shift)
        hash_b = _hash([block[right] for block in columns_b], shift)
        for group_a, group_b in _groups(hash_a, hash_b):
            rows_a, rows_b = left[group_a], right[group_b]
            small = len(rows_a) * len(rows_b) <= room
            room -= len(rows_a) * len(rows_b) if small else 0
            i, j = (_nearest if small else _in_order)(a.place[rows_a], b.place[rows_b])
            pairs_a.append(rows_a[i])
            pairs_b.append(rows_b[j])
        left = np.setdiff1d(np.arange(len(a)), np.concatenate(pairs_a))
        right = np.setdiff1d(np.arange(len(b)), np.concatenate(pairs_b))
        if not len(left) or not len(right):
            break
    return np.concatenate(pairs_a), np.concatenate(pairs_b)


def _groups(hash_a: Hashes, hash_b: Hashes) -> Iterable[tuple[Ints, Ints]]:
    """The rows of both sides under each hash that both have."""
    order_a, order_b = np.argsort(hash_a, kind="stable"), np.argsort(hash_b, kind="stable")
    sorted_a, sorted_b = hash_a[order_a], hash_b[order_b]
    shared = np.intersect1d(hash_a, hash_b)
    ends = [np.searchsorted(x, shared, side) for x in (sorted_a, sorted_b) for side in ("left", "right")]
    for a0, a1, b0, b1 in zip(*(end.tolist() for end in ends)):
        yield order_a[a0:a1], order_b[b0:b1]


def _nearest(a: Floats, b: Floats) -> tuple[Ints, Ints]:
    """Pairs of points, the nearest two first, each point once."""
    if len(a) == len(b) == 1:
        return _FIRST, _FIRST
    distance = np.abs(a[:, None, :] - b[None, :, :]).max(axis=2)
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


def _in_order(a: Floats, b: Floats) -> tuple[Ints, Ints]:
    """Pairs of points by their order along x, then y, then z: what a common shift keeps."""
    count = min(len(a), len(b))
    return np.lexsort(a.T[::-1])[:count], np.lexsort(b.T[::-1])[:count]


# --- the whole ---------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True, eq=False)
class FrameDifference:
    """What differs in one frame: rows of the two sheets, paired for ``moved`` and ``recolored``, (n, 2); single for
    ``missing`` (only in the first) and ``extra`` (only in the second), (n,)."""

    matched: int
    moved: Ints
    recolored: Ints
    missing: Ints
    extra: Ints
    places_a: Floats  # (N, 3) where each row is, in the scene's units
    places_b: Floats

    @property
    def equal(self) -> bool:
        return not (len(self.moved) or len(self.recolored) or len(self.missing) or len(self.extra))


def compare_frames(a: Sheet, b: Sheet, tolerance: float = TOLERANCE) -> FrameDifference:
    """Compare two frames. ``tolerance`` is in units of the extent of both frames' positions."""
    kinds: dict[str, int] = {}
    looks: dict[str, int] = {}
    world_a, world_b = _world(a, kinds, looks), _world(b, kinds, looks)
    size = _scene_size(world_a, world_b)
    rows_a, rows_b = _in_units(world_a, size), _in_units(world_b, size)
    same = _Pairing(rows_a, rows_b)
    same.match(_Rule(tolerance, colored=True))
    free_a, free_b = same.free()
    recolored = _pairs_among(free_a, free_b, lambda: _recolored(rows_a.take(free_a), rows_b.take(free_b), tolerance))
    free_a, free_b = np.setdiff1d(free_a, recolored[:, 0]), np.setdiff1d(free_b, recolored[:, 1])
    moved = _pairs_among(free_a, free_b, lambda: _moved(rows_a.take(free_a), rows_b.take(free_b), tolerance))
    return FrameDifference(
        int((same.of_a >= 0).sum()), moved, recolored,
        np.setdiff1d(free_a, moved[:, 0]), np.setdiff1d(free_b, moved[:, 1]),
        world_a.place, world_b.place,
    )  # fmt: skip


def _recolored(a: _Rows, b: _Rows, tolerance: float) -> tuple[Ints, Ints]:
    pairing = _Pairing(a, b)
    pairing.match(_Rule(tolerance, colored=False))
    i = np.flatnonzero(pairing.of_a >= 0)
    return i, pairing.of_a[i]


def _pairs_among(rows_a: Ints, rows_b: Ints, find: Callable[[], tuple[Ints, Ints]]) -> Ints:
    """Pairs that ``find`` makes of some rows, as rows of the whole, (n, 2), in order."""
    if not len(rows_a) or not len(rows_b):
        return np.zeros((0, 2), np.int64)
    i, j = find()
    pairs = np.stack([rows_a[i], rows_b[j]], axis=1)
    ordered: Ints = pairs[np.argsort(pairs[:, 0], kind="stable")]
    return ordered
