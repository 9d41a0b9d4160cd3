"""Surfaces of swept profiles, of lofts and of height fields, as closed triangle meshes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import TYPE_CHECKING

from scenelang.grammar.datum import dataclass
from scenelang.grammar.diagnostics import LimitError, SceneError
from scenelang.interpreter.loading import np
from scenelang.interpreter.scene.modelling.contours import Contours, area_of
from scenelang.interpreter.scene.modelling.curves import PathFrames, frames_of, lengths_to, points_at, rolls
from scenelang.interpreter.scene.modelling.operations import SEGMENTS

if TYPE_CHECKING:
    import numpy.typing as npt

    FloatArray = npt.NDArray[np.float64]
    IntArray = npt.NDArray[np.int64]

    Surface = tuple[FloatArray, IntArray]  # vertices (V, 3) and faces (F, 3)

MAX_CORNERS = 1_000_000  # of a surface: it has about twice as many triangles
_MAX_STATIONS = 20_000  # points of a path, each of which is compared with the others
_MAX_FOLDED_CORNERS = 30_000  # of the convex pieces of a sweep that folds, whose union takes seconds
_MAX_MITER = 4.0  # width of a mitered joint as a multiple of that of the profile, as the default of SVG's miter limit
FEWER_SLICES = "use fewer :slices; :twist is in radians: `(deg 90)`"
_LAYERS = 8  # of a loft between two different profiles, whose ruled surface is curved
_MIN_GAP_SINE = 1e-6  # of the smallest turn between two pieces that leaves a gap
_FLAT_SHARE = 1e-6  # of a cubed diagonal: a quadrilateral of less volume is flat
_TIE_SHARE = 1e-9  # of the size: diagonals that differ by less are equally long


@dataclass(frozen=True, slots=True, eq=False)
class Swept:
    """A sweep: the solid is the union of the surfaces and of the convex hulls of points."""

    surfaces: tuple[Surface, ...]
    hulls: tuple[FloatArray, ...] = ()


# --- rings -----------------------------------------------------------------------------------------------------------


def check_corners(
    name: str, rings: int, corners: int, hint: str = "use fewer :segments in the path or in the profile"
) -> None:
    """Raise LimitError("size") if a surface would have more than ``MAX_CORNERS`` corners.

    Parameters
    ----------
    name
        Builtin that the message names.
    rings, corners
        Number of cross-sections, and of the corners of each.
    hint
        How to reduce them.
    """
    if rings * corners > MAX_CORNERS:
        message = f"`{name}` of {rings:,} cross-sections with {corners:,} points has more than {MAX_CORNERS:,} corners"
        raise LimitError("size", message, hint)


def _ring_faces(contours: Contours, rings: int, caps: tuple[IntArray, IntArray] | None) -> IntArray:
    """Return the faces between equal cross-sections, one after another; without ``caps``, of a closed chain."""
    corners = sum(map(len, contours))
    starts = np.cumsum([0, *map(len, contours)])
    # Vertices are numbered ring by ring. A side is two triangles between a corner, the following one, and both in the
    # next ring.
    corner = np.arange(corners)
    following = np.concatenate([np.roll(corner[a:b], -1) for a, b in pairwise(starts)])
    base = corners * np.arange(rings - 1 if caps else rings)[:, None]
    ahead = (base + corners) % (corners * rings)
    a, b, c, d = base + corner, base + following, ahead + following, ahead + corner
    sides = np.concatenate([np.stack([a, b, c], axis=-1), np.stack([a, c, d], axis=-1)]).reshape(-1, 3)
    if caps is None:
        return np.asarray(sides, np.int64)
    return np.concatenate([sides, caps[0][:, ::-1], caps[1] + corners * (rings - 1)])


def _caps(contours: Contours) -> IntArray:
    """Return the triangles of a profile, indices of its points."""
    import manifold3d

    return np.array(manifold3d.triangulate(list(contours)), np.int64).reshape(-1, 3)


# --- sweeps ----------------------------------------------------------------------------------------------------------


def swept(contours: Contours, path: FloatArray, twist: float, taper: FloatArray) -> Swept:
    """Sweep a profile along a path.

    Joints are mitered, so that the cross-section of every straight piece is the profile, and the volume is area times
    length. A path that comes so close to itself that the surface might cross itself is divided into runs that do not,
    and the solid is the union of the sweeps along them. Where it bends more tightly than the profile allows, mitered
    pieces would fold; there, a convex profile is swept as convex pieces with beveled joints, and any other one is an
    error, because the surface would cross itself.

    Parameters
    ----------
    contours
        Profile without overlaps; its x and y axes are those of the rotation-minimizing frames.
    path : (N, 3)
        Points; closed if the last is the first.
    twist
        Angle in radians by which the profile turns about the path, from start to end.
    taper : (2,)
        Scale factors of the profile at the end.

    Returns
    -------
    Swept
        Closed surfaces and points of convex hulls, whose union is the solid.

    Raises
    ------
    SceneError
        "solid" if the surface would fold, or if the profile has no inside.
    LimitError
        "size" for too many points.
    """
    if not contours:
        raise SceneError("solid", "`sweep` got a profile with nothing inside")
    frames, spin = _finely(frames_of(path), twist)
    stations = len(frames.points) - frames.closed
    if stations > _MAX_STATIONS:
        raise LimitError("size", f"`sweep` expects a path of at most {_MAX_STATIONS:,} points, got {stations:,}")
    check_corners("sweep", stations, sum(map(len, contours)))
    sections = _sections(np.concatenate(contours), frames, spin, taper)
    ends = _ends(frames, sections)
    if ends.folded.any():
        _check_folds(frames, contours, ends.folded)
    return Swept(tuple(_surfaces(frames, ends, contours)), tuple(_hulls(frames, sections, ends.folded)))


def _finely(frames: PathFrames, twist: float) -> tuple[PathFrames, FloatArray]:
    """Return frames with additional points where the profile turns about the path, and its angle (N,) at each point."""
    spin = twist + frames.roll
    share = np.diff(frames.along) / frames.along[-1]
    # Rounding errors must not round a whole number of steps up.
    counts = np.maximum(1, np.ceil(abs(spin) * share / (math.tau / SEGMENTS) - 1e-9)).astype(np.int64)
    if counts.max() > 1:
        steps = np.concatenate([np.arange(count) / count for count in counts])
        which = np.repeat(np.arange(len(counts)), counts)
        start, step = frames.points[:-1][which], np.diff(frames.points, axis=0)[which]
        frames = frames_of(np.concatenate([start + steps[:, None] * step, frames.points[-1:]]))
    return frames, np.asarray(spin * frames.along / frames.along[-1], np.float64)


def _sections(corners: FloatArray, frames: PathFrames, spin: FloatArray, taper: FloatArray) -> FloatArray:
    """Return the profile (N, K, 3) at each point of a path, in the axes of the frame."""
    share = (frames.along / frames.along[-1])[:, None, None]
    scaled = corners[None] * (1.0 + (taper - 1.0) * share)
    return np.asarray(np.pad(scaled, ((0, 0), (0, 0), (0, 1))) @ np.swapaxes(rolls(spin), 1, 2), np.float64)


def _around(frames: PathFrames) -> tuple[IntArray, IntArray]:
    """Return the segments before and after each station; ends of an open path have one."""
    count = len(frames.axes)
    if frames.closed:
        after = np.arange(count)
        return (after - 1) % count, after
    return np.maximum(np.arange(count + 1) - 1, 0), np.minimum(np.arange(count + 1), count - 1)


@dataclass(frozen=True, slots=True, eq=False)
class _Ends:
    """Cross-sections (N - 1, K, 3) at the start and the end of each segment, and which segments would fold."""

    start: FloatArray
    end: FloatArray
    folded: npt.NDArray[np.bool_]


def _ends(frames: PathFrames, sections: FloatArray) -> _Ends:
    """Return the cross-sections in the planes between segments; next to one that folds, they are across the segment.

    Cutting the neighbors of a segment that folds changes them, so that they may fold too: repeat until none is added.
    """
    before, after = _around(frames)
    rings, sharp = _mitered(frames, sections, before, after)
    count = len(frames.axes)
    low, high = rings[:count], np.roll(rings, -1, axis=0)[:count]
    folded = sharp[:count] | np.roll(sharp, -1)[:count]
    across_low, across_high = _across(frames, sections)
    while True:
        beside_low = (before[:count] != after[:count]) & folded[before[:count]]
        beside_high = np.roll(folded, -1) & (np.arange(count) < count - (not frames.closed))
        start = np.where(beside_low[:, None, None], across_low, low)
        end = np.where(beside_high[:, None, None], across_high, high)
        forwards = np.einsum("skx,sx->sk", end - start, frames.directions).min(axis=1)
        extended = folded | (forwards <= 1e-9 * np.diff(frames.along))
        if (extended == folded).all():
            return _Ends(start, end, folded)
        folded = extended


def _mitered(
    frames: PathFrames, sections: FloatArray, before: IntArray, after: IntArray
) -> tuple[FloatArray, npt.NDArray[np.bool_]]:  # fmt: skip
    """Return the cross-sections (S, K, 3) in the planes between segments, and which joints are too sharp for that."""
    directions, stations = frames.directions, len(after)
    normal = directions[before] + directions[after]
    sharp = np.linalg.norm(normal, axis=1) < 2.0 / _MAX_MITER
    normal = np.where(sharp[:, None], directions[after], normal)
    flat = sections[:stations] @ np.swapaxes(frames.axes[after], 1, 2)
    # Each corner slides along the segment after the joint to the plane that halves the angle.
    slide = np.einsum("skx,sx->sk", flat, normal) / np.sum(directions[after] * normal, axis=1)[:, None]
    rings = frames.points[:stations, None] + flat - slide[:, :, None] * directions[after][:, None]
    return np.asarray(rings, np.float64), sharp


def _across(frames: PathFrames, sections: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the cross-sections (N - 1, K, 3) across each segment at its start and at its end."""
    turned = np.swapaxes(frames.axes, 1, 2)
    return frames.points[:-1, None] + sections[:-1] @ turned, frames.points[1:, None] + sections[1:] @ turned


def _check_folds(frames: PathFrames, contours: Contours, folded: npt.NDArray[np.bool_]) -> None:
    """Raise an error unless the segments that fold can be made of convex pieces."""
    if len(contours) > 1 or not _is_convex(contours[0]):
        x, y, z = frames.points[int(np.argmax(folded))].tolist()
        message = f"`sweep` would fold at [{x:.4g} {y:.4g} {z:.4g}]: the path bends too tightly for the profile"
        raise SceneError("solid", message, "use a wider bend or a smaller profile; only convex profiles may fold")
    count = int(folded.sum())
    if 4 * count * len(contours[0]) > _MAX_FOLDED_CORNERS:
        message = f"`sweep` folds, as the path bends too tightly, and {count:,} pieces are too many to join"
        raise LimitError("size", message, hint="use a wider bend, or fewer :segments in the path and in the profile")


def _hulls(frames: PathFrames, sections: FloatArray, folded: npt.NDArray[np.bool_]) -> list[FloatArray]:
    """Return the corners of the convex pieces: one for each segment that folds, and one for each of its joints."""
    start, end = _across(frames, sections)
    pieces = [np.concatenate([start[number], end[number]]) for number in np.flatnonzero(folded).tolist()]
    for one, other in zip(*(segments.tolist() for segments in _around(frames)), strict=True):
        turn = np.cross(frames.directions[one], frames.directions[other])
        if one != other and (folded[one] or folded[other]) and float(np.linalg.norm(turn)) > _MIN_GAP_SINE:
            pieces.append(np.concatenate([end[one], start[other]]))
    return pieces


def _is_convex(contour: FloatArray) -> bool:
    """Return whether a counter-clockwise contour never turns right, up to rounding."""
    side = np.roll(contour, -1, axis=0) - contour
    ahead = np.roll(side, -1, axis=0)
    turn = side[:, 0] * ahead[:, 1] - side[:, 1] * ahead[:, 0]
    return bool((turn >= -1e-9 * np.abs(turn).max()).all())


def _surfaces(frames: PathFrames, ends: _Ends, contours: Contours) -> list[Surface]:
    """Return a surface for each of the ``_runs`` of a path, which do not overlap themselves."""
    reach = float(np.linalg.norm(ends.start - frames.points[:-1, None], axis=2).max())
    runs = _runs(frames, reach, ends.folded)
    if frames.closed and runs == [(0, len(frames.axes))]:
        return [(ends.start.reshape(-1, 3), _ring_faces(contours, len(ends.start), None))]
    caps, surfaces = _caps(contours), []
    for first, last in runs:
        rings = np.concatenate([ends.start[first:last], ends.end[last - 1 : last]])
        surfaces.append((rings.reshape(-1, 3), _ring_faces(contours, len(rings), (caps, caps))))
    return surfaces


def _runs(frames: PathFrames, reach: float, folded: npt.NDArray[np.bool_]) -> list[tuple[int, int]]:
    """Divide a path into ranges (first, end) of segments without folds, whose sweeps do not overlap themselves.

    Points within ``reach`` of two segments can only coincide if the segments are closer than twice the reach. Along a
    bend that does not fold, that takes half a turn, and so a length of more than pi times the reach; consecutive
    segments are never compared.
    """
    middle = (frames.points[:-1] + frames.points[1:]) / 2.0
    length = np.diff(frames.along)
    total, first = float(frames.along[-1]), 0
    runs: list[tuple[int, int]] = []
    for number in range(len(middle)):
        run = slice(first, number)
        both = length[run] + length[number]
        between = frames.along[number] - frames.along[first + 1 : number + 1]
        if frames.closed:
            between = np.minimum(between, total - between - both)
        distant = (between > 1e-9 * total) & (between + both > math.pi * reach)
        near = np.linalg.norm(middle[run] - middle[number], axis=1) < 2.0 * reach + both / 2.0
        if folded[number] or (near & distant).any():
            runs.append((first, number))
            first = number + 1 if folded[number] else number
    return [(start, end) for start, end in (*runs, (first, len(middle))) if start < end]


# --- twists ----------------------------------------------------------------------------------------------------------


def twisted(contours: Contours, height: float, twist: float, taper: FloatArray, layers: int) -> Surface:
    """Return the surface of a profile that is extruded along z, turned and scaled on the way.

    The sides between layers are split along their shorter diagonals: the solid is then the mirror image of that of the
    opposite twist, and its volume the closest to that of the smooth one. One fixed diagonal, as in Manifold, has other
    volumes for left and right turns, by 13 % for a square turned by 90 degrees in eight layers.

    Parameters
    ----------
    contours
        Profile without overlaps, at z = 0.
    height
        Height in scene units.
    twist
        Angle of the top in radians.
    taper : (2,)
        Scale factors of the top.
    layers
        Number of layers between bottom and top.

    Returns
    -------
    vertices, faces : (V, 3), (F, 3)
        Closed surface.

    Raises
    ------
    SceneError
        "solid" if the profile has no contours.
    """
    if not contours:
        raise SceneError("solid", "`extrude` got a profile with nothing inside")
    corners = np.concatenate(contours)
    vertices = _twisted_rings(corners, height, twist, taper, layers).reshape(-1, 3)
    is_rightward = twist < 0.0
    sides = _twisted_sides(
        vertices, contours, layers, _TIE_SHARE * float(np.abs(corners).max()), is_rightward=is_rightward
    )
    caps = _caps(contours)
    return vertices, np.concatenate([sides, caps[:, ::-1], caps + layers * len(corners)])


def _twisted_rings(corners: FloatArray, height: float, twist: float, taper: FloatArray, layers: int) -> FloatArray:
    """Return the corners (K, 2) of a profile at all levels of an extrusion, (layers + 1, K, 3)."""
    share = np.linspace(0.0, 1.0, layers + 1)  # of the height
    scaled = corners[None] * (1.0 + (taper - 1.0) * share[:, None, None])
    cosine, sine = np.cos(twist * share)[:, None], np.sin(twist * share)[:, None]
    x, y = scaled[:, :, 0], scaled[:, :, 1]
    z = np.broadcast_to(height * share[:, None], x.shape)
    return np.stack([cosine * x - sine * y, sine * x + cosine * y, z], axis=-1)


def _twisted_sides(
    vertices: FloatArray, contours: Contours, layers: int, tie: float, *, is_rightward: bool
) -> IntArray:
    """Return the triangles (F, 3) between the rings of ``_twisted_rings``, which ``vertices`` are in order.

    The quadrilateral between a corner, the next one of its contour, and both in the ring above is split along its
    shorter diagonal. If their lengths differ by less than ``tie``, the turn decides, so that mirror images have
    mirrored triangles.
    """
    starts = np.cumsum([0, *map(len, contours)])
    count = int(starts[-1])  # corners of a ring
    following = np.concatenate(
        [start + np.roll(np.arange(len(contour)), -1) for start, contour in zip(starts, contours, strict=False)]
    )
    ring = (np.arange(layers) * count)[:, None]  # first vertex of each ring
    low, low_next = ring + np.arange(count), ring + following
    high, high_next = low + count, low_next + count
    rising = np.linalg.norm(vertices[low] - vertices[high_next], axis=-1)
    falling = np.linalg.norm(vertices[low_next] - vertices[high], axis=-1)
    excess = rising - falling
    takes_rising = ((excess < -tie) | ((np.abs(excess) <= tie) & is_rightward))[..., None]
    lower_third = np.where(takes_rising, high_next[..., None], high[..., None])
    upper_first = np.where(takes_rising, low[..., None], low_next[..., None])
    lower = np.concatenate([low[..., None], low_next[..., None], lower_third], axis=-1)
    upper = np.concatenate([upper_first, high_next[..., None], high[..., None]], axis=-1)
    return np.concatenate([lower.reshape(-1, 3), upper.reshape(-1, 3)])


# --- lofts -----------------------------------------------------------------------------------------------------------


def lofted(profiles: Sequence[Contours], poses: FloatArray) -> Surface:
    """Return the surface through profiles with equal numbers of contours, under poses (P, 3, 4).

    Raises SceneError("solid") for contours that do not correspond.
    """
    _check_contours(profiles)
    matched = [_matched([profile[i] for profile in profiles]) for i in range(len(profiles[0]))]
    sections = np.concatenate(matched, axis=1)
    check_corners("loft", *sections.shape[:2])
    rings = _layered(sections @ np.swapaxes(poses[:, :, :2], 1, 2) + poses[:, None, :, 3])
    first, last = (tuple(rings[place] for rings in matched) for place in (0, -1))
    vertices = rings.reshape(-1, 3)
    faces = _ring_faces(first, len(rings), (_caps(first), _caps(last)))
    return vertices, _with_short_diagonals(vertices, faces, (len(rings) - 1) * rings.shape[1])


def _layered(rings: FloatArray) -> FloatArray:
    """Return rings (R, K, 3) with further rings inserted where the surface between two of them is curved.

    That is where a quadrilateral between two rings is not flat: two triangles would not follow its ruled surface.
    """
    # The corners of each quadrilateral in order: two of the lower ring, two of the upper one.
    a, d = rings[:-1], rings[1:]
    b, c = np.roll(a, -1, axis=1), np.roll(d, -1, axis=1)
    volume = np.abs(np.sum(np.cross(b - a, c - a) * (d - a), axis=2))  # six times that of the tetrahedron abcd
    size = np.maximum(np.linalg.norm(c - a, axis=2), np.linalg.norm(d - b, axis=2))  # longer diagonal
    is_flat = (volume <= _FLAT_SHARE * size**3).all(axis=1)
    layers = [_between(*pair, 1 if flat else _LAYERS) for pair, flat in zip(pairwise(rings), is_flat, strict=True)]
    layered = np.concatenate([*layers, rings[-1:]])
    check_corners("loft", *layered.shape[:2])
    return layered


def _between(low: FloatArray, high: FloatArray, count: int) -> FloatArray:
    """Return ``count`` rings at equal steps from ``low`` on, without ``high``."""
    share = (np.arange(count) / count)[:, None, None]
    return np.asarray(low * (1.0 - share) + high * share, np.float64)


def _with_short_diagonals(vertices: FloatArray, faces: IntArray, count: int) -> IntArray:
    """Return faces whose first ``count`` quadrilaterals, a b c and a c d, are divided by their shorter diagonals."""
    a, b, c = faces[:count].T
    d = faces[count : 2 * count, 2]
    lengths = (np.linalg.norm(vertices[p] - vertices[q], axis=1) for p, q in ((b, d), (a, c)))
    is_shorter = np.less(*lengths)[:, None]
    first_halves = np.where(is_shorter, np.stack([a, b, d], axis=-1), faces[:count])
    second_halves = np.where(is_shorter, np.stack([b, c, d], axis=-1), faces[count : 2 * count])
    return np.concatenate([first_halves, second_halves, faces[2 * count :]])


def _check_contours(profiles: Sequence[Contours]) -> None:
    """Raise SceneError("solid") unless the contours of all profiles correspond, in number and direction."""
    counts = list(map(len, profiles))
    if len(set(counts)) > 1:
        shown = ", ".join(map(str, counts[:8]))
        raise SceneError("solid", f"`loft` expects profiles with equal numbers of contours, got {shown}")
    for number, contours in enumerate(zip(*profiles, strict=True)):
        signs = {area_of(contour) > 0.0 for contour in contours}
        if len(signs) > 1:
            message = f"`loft` expects corresponding contours to turn the same way, but those at {number} do not"
            raise SceneError("solid", message, "outer contours are counter-clockwise, holes clockwise")
    if sum(area_of(contour) for contour in profiles[0]) <= 0.0:
        hint = "outer contours must be counter-clockwise: `polygon` turns them"
        raise SceneError("solid", "`loft` got a profile with nothing inside", hint)


def _matched(contours: Sequence[FloatArray]) -> FloatArray:
    """Return contours (P, K, 2) with equal numbers of points.

    Unless they have them already, each gets the points of all others, at the same shares of its length, so that no
    corner is lost. The first point of each is the one closest to the contour before (``_turned_to``).
    """
    if len({len(contour) for contour in contours}) == 1:
        return np.stack(contours)
    turned = [contours[0]]
    for contour in contours[1:]:
        turned.append(_turned_to(contour, turned[-1]))
    closed = [np.concatenate([contour, contour[:1]]) for contour in turned]
    # all shares of the length at which any contour has a corner
    shares = np.concatenate([lengths_to(contour)[:-1] / lengths_to(contour)[-1] for contour in closed])
    shares = np.unique(np.round(shares, 9))
    return np.stack([points_at(contour, shares) for contour in closed])


def _turned_to(contour: FloatArray, before: FloatArray) -> FloatArray:
    """Return a contour that starts at the corner from which it is closest to another one, both moved to their centers.

    The distance is the sum of squares at equal shares of the lengths, compared for every corner.
    """
    shares = np.arange(SEGMENTS) / SEGMENTS
    target = _centered(np.concatenate([before, before[:1]]), shares)
    ahead = lengths_to(np.concatenate([contour, contour[:1]]))
    closed = np.concatenate([contour, contour[:1]])
    costs = []
    for start in ahead[:-1] / ahead[-1]:
        costs.append(float(np.sum((_centered(closed, (shares + start) % 1.0) - target) ** 2)))
    return np.roll(contour, -int(np.argmin(costs)), axis=0)


def _centered(closed: FloatArray, shares: FloatArray) -> FloatArray:
    """Return points of a contour at shares of its length, relative to their mean."""
    points = points_at(closed, shares)
    return np.asarray(points - points.mean(axis=0), np.float64)


# --- height fields ---------------------------------------------------------------------------------------------------


def height_field(heights: FloatArray, size: FloatArray, base: float) -> Surface:
    """Return the surface of a block around the y axis whose top has the given heights.

    The bottom is a fan around its middle, which needs no grid of points.

    Parameters
    ----------
    heights : (Z, X)
        Heights, rows along z and columns along x.
    size : (2,)
        Extents along x and z.
    base
        Height of the bottom.
    """
    rows, columns = heights.shape
    along_x, along_z = (side * (np.arange(n) / (n - 1) - 0.5) for side, n in zip(size, (columns, rows), strict=True))
    z, x = np.meshgrid(along_z, along_x, indexing="ij")
    top = np.stack([x, heights, z], axis=-1).reshape(-1, 3)
    # Vertices: the grid of the top, then its rim at the height of the bottom, then the middle of the bottom.
    number = np.arange(rows * columns).reshape(rows, columns)
    a, b, c, d = number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]
    upper = np.concatenate([np.stack([a, b, c], axis=-1).reshape(-1, 3), np.stack([a, c, d], axis=-1).reshape(-1, 3)])
    rim = np.concatenate([number[:, 0], number[-1, 1:], number[-2::-1, -1], number[0, -2:0:-1]])
    below = top[rim] * [1.0, 0.0, 1.0] + [0.0, base, 0.0]
    vertices = np.concatenate([top, below, [[0.0, base, 0.0]]])
    low = len(top) + np.arange(len(rim))
    after, low_after = np.roll(rim, -1), np.roll(low, -1)
    center = np.full_like(low, len(vertices) - 1)
    walls = [np.stack(face, axis=-1) for face in ((rim, low, low_after), (rim, low_after, after))]
    bottom = np.stack([center, low_after, low], axis=-1)
    return vertices, np.concatenate([upper, *walls, bottom])
