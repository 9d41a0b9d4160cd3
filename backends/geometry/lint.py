"""Geometric checks of one frame: duplicated, floating, sunken or hidden things, and z-fighting faces.

Solids often overlap on purpose: a trunk goes into its crown, a leg into the board, a rock into the ground. An overlap
alone is therefore not reported; the rules below identify what is nearly always a mistake.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence, Set
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from scenelang.backends.geometry.convex import MAX_PAIRS, Bodies, bodies_of, clusters
from scenelang.backends.geometry.distance import IntArray, depths
from scenelang.backends.geometry.solids import FloatArray, PosedForms
from scenelang.backends.geometry.stability import contacts_of, intersecting, is_airborne, unstable
from scenelang.grammar.datum import Span
from scenelang.grammar.diagnostics import Diagnostic, Note
from scenelang.interpreter.scene.entity import Entity, Scene, primitive_count
from scenelang.interpreter.scene.primitives import find
from scenelang.interpreter.scene.primitives.mesh import cofactors_of, inverses_of

_SIDES = 32  # of a round solid, for containment tests of its vertices


# --- coplanar faces: the flat faces of posed solids, and the intersection of two of them ---


_DOWN = -0.99


_Face = tuple[FloatArray, FloatArray]


def faces_of(solids: PosedForms, i: int) -> Iterator[_Face]:
    """Yield outward unit normals (3,) and corners (K, 3) of a posed solid's flat faces."""
    matrix = solids.matrices[i]
    cofactors = cofactors_of(matrix[None, :, :3])[0]
    inside_out = np.sign(np.linalg.det(matrix[:, :3]))
    form, ratios = solids.form(i)
    for axis, side, corners in form.flat_faces(ratios):
        normal = cofactors[:, axis] * side * inside_out
        length = np.linalg.norm(normal)
        if length > 0.0:
            yield normal / length, corners @ matrix[:, :3].T + matrix[:, 3]


@dataclass(frozen=True, slots=True, eq=False)
class SharedFace:
    """Overlap of two coplanar faces that face the same way.

    ``area`` of the overlap, its ``share`` of the smaller face, its centre (3,) and the common unit normal (3,).
    """

    area: float
    share: float
    center: FloatArray
    normal: FloatArray


def shared_face(
    faces: Sequence[_Face], others: Sequence[_Face], tolerance: float, least_width: float
) -> SharedFace | None:
    """Return the largest overlap of coplanar ``faces`` and ``others``, in planes closer than ``tolerance``.

    Faces that look straight down and overlaps narrower than ``least_width`` are ignored, since they are rarely visible.
    """
    best: SharedFace | None = None
    for normal, corners in faces:
        if normal[1] < _DOWN:
            continue
        for other_normal, other in others:
            if normal @ other_normal < 1.0 - 1e-6 or abs((other[0] - corners[0]) @ normal) > tolerance:
                continue
            axes = _axes(normal)
            first, second = _counter_clockwise(corners @ axes), _counter_clockwise(other @ axes)
            piece = _clipped(first, second)
            area, smaller = _area(piece), min(_area(first), _area(second))
            if smaller > 0.0 and _width(piece) >= least_width and area > (best.area if best is not None else 0.0):
                center = axes @ piece.mean(axis=0) + normal * (corners[0] @ normal)
                best = SharedFace(area, area / smaller, center, normal)
    return best


def _axes(normal: FloatArray) -> FloatArray:
    """Return two unit vectors perpendicular to ``normal`` as columns (3, 2)."""
    least = np.eye(3)[np.argmin(np.abs(normal))]
    u = np.cross(normal, least)
    u /= np.linalg.norm(u)
    return np.stack([u, np.cross(normal, u)], axis=1)


def _signed(polygon: FloatArray) -> float:
    x, y = polygon[:, 0], polygon[:, 1]
    return float((x * np.roll(y, -1) - y * np.roll(x, -1)).sum() / 2.0) if len(polygon) > 2 else 0.0


def _area(polygon: FloatArray) -> float:
    return abs(_signed(polygon))


def _width(polygon: FloatArray) -> float:
    """Return the width of a rectangle of the polygon's area and perimeter, if it is narrow."""
    perimeter = np.linalg.norm(np.roll(polygon, -1, axis=0) - polygon, axis=1).sum() if len(polygon) else 0.0
    return 2.0 * _area(polygon) / float(perimeter) if perimeter > 0.0 else 0.0


def _counter_clockwise(polygon: FloatArray) -> FloatArray:
    return polygon if _signed(polygon) >= 0.0 else polygon[::-1]


def _clipped(subject: FloatArray, clip: FloatArray) -> FloatArray:
    """Return the part of a convex polygon inside another (Sutherland and Hodgman, 1974); both counter-clockwise."""
    for start, end in zip(clip, np.roll(clip, -1, axis=0)):
        edge = end - start
        side = edge[0] * (subject[:, 1] - start[1]) - edge[1] * (subject[:, 0] - start[0])
        inside_points: list[FloatArray] = []
        for k in range(len(subject)):
            here, there = side[k], side[(k + 1) % len(subject)]
            if here >= 0.0:
                inside_points.append(subject[k])
            if (here >= 0.0) != (there >= 0.0):
                inside_points.append(
                    subject[k] + (subject[(k + 1) % len(subject)] - subject[k]) * here / (here - there)
                )
        if not inside_points:
            return np.zeros((0, 2))
        subject = np.array(inside_points)
    return subject


_POSE_TOLERANCE = 1e-6  # pose tolerance relative to the scene's size
_MAX_OVERLAP = 0.34  # of the smaller extent: siblings with the same word that overlap more are reported
_SUNK = 0.4  # of its height: what is deeper in the ground was probably not raised by mistake
_SUNK_BALL = 0.75  # rocks and bushes are often half in the ground
_BROAD = 0.4  # of the scene's area: a body this broad is the ground
_HOVERING = 2.0  # of its size: what floats higher than that is meant to fly
_MAX_FLOATING = 0.34  # of all clusters: if more of them float, the scene is in the air
_JOINT = 0.8  # of the outer solid
_MIN_SHARED = 0.1  # of the smaller face
_MIN_COLOR_DIFFERENCE = 0.08  # linear: z-fighting of stones with slightly different tints is not visible


@dataclass(frozen=True, slots=True)
class Finding:
    """A suspicious configuration.

    ``kind`` is twin, buried, deep, through, hovering, sunk, unstable or fighting. ``body`` is its subject, ``other``
    the body it is near or in. ``amount`` is a length in scene units (an area for faces), ``move`` the translation that
    would fix it.
    """

    kind: str
    body: int
    other: int | None
    amount: float
    move: tuple[float, float, float] | None = None


def findings(bodies: Bodies, root: Entity) -> Iterator[Finding]:
    """Yield all findings about the frame with a root, kind by kind."""
    if not len(bodies):
        return
    pairs, _, _ = bodies.contacts
    twins = _twins(bodies, pairs)
    yield from twins
    same = {(f.body, f.other) for f in twins}
    rest = np.array([pair for pair in pairs.tolist() if (pair[1], pair[0]) not in same], np.int64).reshape(-1, 2)
    hidden = _buried(bodies, rest)
    yield from hidden
    inside = {f.body for f in hidden}
    siblings = list(_deep_siblings(bodies, np.array([p for p in rest.tolist() if inside.isdisjoint(p)]).reshape(-1, 2)))
    yield from siblings
    known = same | {(f.body, f.other) for f in siblings} | {(i, None) for i in inside}
    yield from _balance(bodies, root, known)
    yield from _hovering(bodies, pairs)
    yield from _below_ground(bodies)
    yield from _fighting_faces(bodies, rest)


# --- overlaps --------------------------------------------------------------------------------------------------------


def _twins(bodies: Bodies, pairs: IntArray) -> list[Finding]:
    """Return duplicates: equal solids under equal poses, however they were created."""
    a, b = pairs[:, 0], pairs[:, 1]
    first, second = bodies.solids.take(a), bodies.solids.take(b)
    equal = (first.forms == second.forms) & (
        np.abs(first.ratios - second.ratios).max(axis=1, initial=0.0) <= _POSE_TOLERANCE
    )
    near = np.abs(first.matrices - second.matrices).max(axis=(1, 2)) <= _POSE_TOLERANCE * bodies.size
    return [Finding("twin", j, i, _extent(bodies, i)) for i, j in pairs[equal & near].tolist()]


def _extent(bodies: Bodies, i: int) -> float:
    low, high = bodies.boxes
    return float((high[i] - low[i]).min())


def _buried(bodies: Bodies, pairs: IntArray) -> list[Finding]:
    """Return things all of whose solids are inside an opaque solid, and so never visible.

    A single hidden solid among others, such as a ball in a joint, is normal modelling practice.
    """
    low, high = bodies.boxes
    found: dict[int, Finding] = {}
    for first, second in ((0, 1), (1, 0)):
        inner, outer = pairs[:, first], pairs[:, second]
        room = 1e-4 * bodies.size
        boxed = ((low[inner] >= low[outer] - room) & (high[inner] <= high[outer] + room)).all(axis=1)
        for i, o in pairs[boxed & bodies.opaque[outer]][:, [first, second]].tolist():
            if i not in found and _is_inside(bodies, i, o):
                found[i] = Finding("buried", i, o, _extent(bodies, i))
    things = Counter(_thing(bodies, i) for i in range(len(bodies)))
    hidden = Counter(_thing(bodies, i) for i in found)
    return [
        f for i, f in found.items()
        if hidden[_thing(bodies, i)] == things[_thing(bodies, i)] or _is_deep_sibling(bodies, i, f.other)
    ]  # fmt: skip


def _is_deep_sibling(bodies: Bodies, i: int, other: int | None) -> bool:
    """Whether a solid is deeper inside another solid of the same thing than a joint requires."""
    assert other is not None
    return bool(bodies.path[i] == bodies.path[other]) and _is_inside(bodies, i, other, _JOINT)


def _thing(bodies: Bodies, i: int) -> tuple[str, ...]:
    """Return the words of the thing that contains a body: the path to its parent, or to itself if its word names a
    thing."""
    words = bodies.words(i)
    return words[:-1] if _is_material(words[-1]) and len(words) > 1 else words


def _is_material(word: str) -> bool:
    """Whether a primitive's word names only a shape, such as "cube"."""
    cls = find(word)
    return cls is not None and cls.is_solid


def _is_inside(bodies: Bodies, inner: int, outer: int, limit: float = 0.995) -> bool:
    """Whether a solid is inside another that is scaled by ``limit`` about its centre."""
    matrix = bodies.solids.matrices[inner]
    form, ratios = bodies.solids.form(inner)
    return _holds(bodies, outer, form.mesh(_SIDES, ratios).vertices @ matrix[:, :3].T + matrix[:, 3], limit)


def _holds(bodies: Bodies, outer: int, points: FloatArray, limit: float = 1.0) -> bool:
    """Whether all points (K, 3) are inside a solid that is scaled by ``limit`` about its centre."""
    matrix = bodies.solids.matrices[outer]
    local = (points - matrix[:, 3]) @ inverses_of(matrix[None, :, :3])[0].T / limit
    form, ratios = bodies.solids.form(outer)
    return bool(form.contains(local[:, 0], local[:, 1], local[:, 2], ratios).all())


def _deep_siblings(bodies: Bodies, pairs: IntArray) -> Iterator[Finding]:
    """Yield deep overlaps of things with the same word, such as books in a row.

    Round things are exempt: they are usually leaves, clouds, bubbles or limbs.
    """
    chosen = [
        (i, j)
        for i, j in pairs.tolist()
        if bodies.entity[i] == bodies.entity[j] and bodies.paths[bodies.path[i]] == bodies.paths[bodies.path[j]]
        and _is_a_thing(bodies, i) and not bodies.solids.form(i)[0].is_rounded
    ]  # fmt: skip
    if not chosen:
        return
    numbers = np.array(chosen, np.int64)
    depth, along = depths(bodies.pairs(numbers))
    for (i, j), deep, direction in zip(chosen, depth.tolist(), along):
        if deep > _MAX_OVERLAP * min(_extent(bodies, i), _extent(bodies, j)):
            move = tuple(float(x) for x in direction * deep)
            yield Finding("deep", j, i, deep, (move[0], move[1], move[2]))


def _is_a_thing(bodies: Bodies, i: int) -> bool:
    """Whether a body is a thing rather than building material: a word without geometry, or the only solid of a bound
    word."""
    words = bodies.words(i)
    return not _is_material(words[-1]) or (len(words) > 1 and words[-2] in bodies.plain)


def _balance(bodies: Bodies, root: Entity, known: Set[tuple[int, int | None]]) -> Iterator[Finding]:
    """Yield things that pass through each other or would fall over, unless their bodies are ``known`` for overlaps."""
    contacts = contacts_of(bodies, root)
    for fault in intersecting(bodies, contacts):
        body, other = fault.body, fault.other
        if known.isdisjoint({(body, other), (other, body), (body, None), (other, None)}):
            yield Finding("through", *fault)
    for fault in unstable(bodies, contacts, _ground_height(bodies)):
        yield Finding("unstable", *fault)


def _ground_height(bodies: Bodies) -> float:
    """Return the height that the scene stands on: 0 if something stands there, else that of its lowest point."""
    low, _ = bodies.boxes
    return 0.0 if bool((np.abs(low[:, 1]) <= 2.0 * bodies.touch).any()) else float(low[:, 1].min())


# --- floating --------------------------------------------------------------------------------------------------------


def _hovering(bodies: Bodies, pairs: IntArray) -> Iterator[Finding]:
    """Yield clusters of touching solids that are slightly above the ground and separate from everything else."""
    cluster = clusters(len(bodies), pairs.tolist())
    low, _ = bodies.boxes
    ground = _ground_height(bodies)
    numbers, sizes = np.unique(cluster, return_counts=True)
    if len(numbers) < 2:
        return
    standing = {int(c) for c in cluster[low[:, 1] <= ground + 2.0 * bodies.touch]}
    standing.add(int(numbers[np.argmax(sizes)]))
    words = {int(c): bodies.words(int(np.argmax(cluster == c))) for c in numbers}
    flying = [int(c) for c in numbers if int(c) not in standing and not is_airborne(words[int(c)])]
    kinds, floating = {words[c] for c in (*standing, *flying)}, {words[c] for c in flying}
    if len(floating) > max(1.0, _MAX_FLOATING * len(kinds)):
        return
    for c in flying:
        members = np.flatnonzero(cluster == c)
        yield from _gap_of(bodies, members, np.flatnonzero(cluster != c), ground)


def _gap_of(bodies: Bodies, members: IntArray, others: IntArray, ground: float) -> Iterator[Finding]:
    """Yield the finding about one cluster, if the gap around it is small."""
    low, high = bodies.boxes
    own_low, own_high = low[members].min(axis=0), high[members].max(axis=0)
    size = float((own_high - own_low).max())
    apart = np.maximum(np.maximum(low[others] - own_high, own_low - high[others]), 0.0)
    near = others[np.argsort(np.linalg.norm(apart, axis=1))[:24]]
    numbers = np.array([(i, j) for i in members[:64].tolist() for j in near.tolist()], np.int64)
    gaps = bodies.gaps(numbers)
    best = int(np.argmin(gaps))
    gap, height = float(gaps[best]), float(own_low[1] - ground)
    if min(gap, height) >= _HOVERING * size:
        return
    i, j = numbers[best].tolist()
    if height < gap:
        yield Finding("hovering", i, None, height, (0.0, -height, 0.0))
    else:
        _, along = depths(bodies.pairs(numbers[best : best + 1]))
        move = along[0] * -gap if np.isfinite(along).all() else along[0]
        yield Finding("hovering", i, j, gap, (-float(move[0]), -float(move[1]), -float(move[2])))


# --- the ground ------------------------------------------------------------------------------------------------------


def _below_ground(bodies: Bodies) -> Iterator[Finding]:
    """If the scene stands on y = 0, yield what is deep below it and is neither the ground nor beside the ground."""
    low, high = bodies.boxes
    room = 2.0 * bodies.touch
    tall = np.maximum(high[:, 1] - low[:, 1], 1e-12)
    limit = np.where(bodies.solids.that_are("is_rounded"), _SUNK_BALL, _SUNK) * tall
    below = -low[:, 1] > np.maximum(limit, room)
    ground = _ground(bodies, below)
    sunk = np.flatnonzero(below & ~ground)
    if np.count_nonzero((np.abs(low[:, 1]) <= room) & ~ground) < max(len(sunk), 1):
        return  # the scene does not stand on y = 0
    for i in sunk.tolist():
        if not _is_beside(bodies, i, ground):
            dip = float(-low[i, 1])
            yield Finding("sunk", i, None, dip, (0.0, dip, 0.0))


def _ground(bodies: Bodies, below: npt.NDArray[np.bool_]) -> npt.NDArray[np.bool_]:
    """Return the ground: broad bodies that reach below 0, and bodies below 0 connected to them, such as a board's
    squares."""
    low, high = bodies.boxes
    wide = high.max(axis=0) - low.min(axis=0)
    ground: npt.NDArray[np.bool_] = below & ((high - low)[:, 0] * (high - low)[:, 2] >= _BROAD * wide[0] * wide[2])
    pairs, _, _ = bodies.contacts
    under = below & (high[:, 1] <= 2.0 * bodies.touch)
    pairs = pairs[(under | ground)[pairs].all(axis=1)]
    while True:
        reached = ground.copy()
        reached[pairs[ground[pairs].any(axis=1)]] = True
        if (reached == ground).all():
            return ground
        ground = reached


def _is_beside(bodies: Bodies, i: int, ground: npt.NDArray[np.bool_]) -> bool:
    """Whether a body touches the side of the ground, as the rim of a board does."""
    pairs, _, _ = bodies.contacts
    mine = pairs[(pairs == i).any(axis=1)]
    mine = mine[ground[mine].any(axis=1)]
    if not len(mine):
        return False
    depth, along = depths(bodies.pairs(mine))
    return bool(((depth < 0.25 * _extent(bodies, i)) & (np.abs(along[:, 1]) < 0.5)).any())


# --- coplanar faces --------------------------------------------------------------------------------------------------


def _fighting_faces(bodies: Bodies, pairs: IntArray) -> Iterator[Finding]:
    """Yield visible overlaps of coplanar faces of different colours: which one is in front is undefined
    (z-fighting)."""
    colors = np.abs(bodies.colors[pairs[:, 0]] - bodies.colors[pairs[:, 1]]).max(axis=1)
    flat = (~bodies.solids.that_are("is_rounded"))[pairs].all(axis=1)
    opaque = bodies.opaque[pairs].all(axis=1)
    chosen = pairs[flat & opaque & (colors > _MIN_COLOR_DIFFERENCE)]
    faces = {i: list(faces_of(bodies.solids, i)) for i in np.unique(chosen).tolist()}
    for i, j in chosen.tolist():
        shared = shared_face(faces[i], faces[j], 1e-5 * bodies.size, bodies.touch)
        if shared is None or shared.share < _MIN_SHARED:
            continue
        if not _is_covered(bodies, shared, i, j):
            yield Finding("fighting", j, i, shared.area)


def _is_covered(bodies: Bodies, shared: SharedFace, i: int, j: int) -> bool:
    """Whether a third solid hides the centre of a shared face."""
    low, high = bodies.boxes
    point = shared.center + shared.normal * (1e-4 * bodies.size)
    near = np.flatnonzero(((low <= point) & (high >= point)).all(axis=1))
    return any(k not in (i, j) and bodies.opaque[k] and _holds(bodies, k, point[None]) for k in near.tolist())


# Diagnostics: findings of every frame as warnings at the calls that made the things (``check --geometry``).


MAX_PRIMITIVES = 20_000
_MAX_FRAMES = 6
_MAX_SHOWN = 20


@dataclass(frozen=True, slots=True)
class _Named:
    """A finding with the words of its subjects, by which equal findings are merged."""

    finding: Finding
    words: tuple[str, ...]
    other: tuple[str, ...]
    place: Span | None
    other_place: Span | None
    frame: int


def check_geometry(scene: Scene) -> list[Diagnostic]:
    """Return warnings about the geometry of a scene.

    For a film, a sample of its frames is checked and findings in most of them are reported.
    """
    count = len(scene.frames)
    frames = sorted(
        {round(i * (count - 1) / max(_MAX_FRAMES - 1, 1)) for i in range(_MAX_FRAMES)} if count > 1 else {0}
    )
    found: dict[tuple[str, tuple[str, ...], tuple[str, ...]], list[_Named]] = {}
    remarks: list[Diagnostic] = []
    for number in frames:
        root = scene.frames[number]
        total = primitive_count(root)
        if total > MAX_PRIMITIVES:
            remarks.append(
                _incomplete(f"{total:,} primitives, more than the limit of {MAX_PRIMITIVES:,}", number, count)
            )
            continue
        bodies = bodies_of(root)
        for finding in findings(bodies, root):
            named = _named(bodies, finding, number)
            found.setdefault((finding.kind, named.words, named.other), []).append(named)
        if len(bodies) and not bodies.contacts[2]:
            remarks.append(
                _incomplete(f"more than the limit of {MAX_PAIRS:,} pairs of nearby primitives", number, count)
            )
    lasting = [group for group in found.values() if 2 * len({each.frame for each in group}) > len(frames)]
    shown = [_diagnostic(group, scene.animated) for group in lasting[:_MAX_SHOWN]]
    if len(lasting) > _MAX_SHOWN:
        shown.append(Diagnostic("geometry-limit", f"{len(lasting) - _MAX_SHOWN} more findings are not shown"))
    return [*shown, *remarks[:1]]


def _incomplete(why: str, frame: int, count: int) -> Diagnostic:
    where = f"frame {frame}" if count > 1 else "the scene"
    return Diagnostic("geometry-limit", f"{where} was not checked completely: {why}")


def _named(bodies: Bodies, finding: Finding, frame: int) -> _Named:
    other = finding.other
    return _Named(
        finding,
        bodies.words(finding.body),
        bodies.words(other) if other is not None else (),
        _place(bodies, finding.body),
        _place(bodies, other) if other is not None else None,
        frame,
    )


def _place(bodies: Bodies, i: int) -> Span | None:
    places = bodies.entities[bodies.entity[i]].call_sites
    return places[0] if places else None


def _diagnostic(group: Iterable[_Named], animated: bool) -> Diagnostic:
    """Return one warning for equal findings, about the worst one."""
    every = list(group)
    named = max(every, key=lambda each: each.finding.amount)
    finding = named.finding
    frames = {each.frame for each in every}
    times = max(sum(1 for each in every if each.frame == frame) for frame in frames)
    name, describe = _MESSAGES[finding.kind]
    message = describe(named) + (f" ({times} times)" if times > 1 else "")
    if animated:
        message += f" (frame {min(frames)})"
    hint = None
    if finding.move is not None and any(abs(x) > 1e-9 for x in finding.move):
        hint = f"`(translate [{' '.join(f'{round(x, 6) + 0.0:.3g}' for x in finding.move)}])` would fix it"
    other = named.other_place
    notes = (Note("the other thing is created here", other),) if other is not None and other != named.place else ()
    return Diagnostic(name, message, named.place, hint, notes)


def _path(words: tuple[str, ...]) -> str:
    """Return the last words of a path, quoted; the rest is obvious from context."""
    return '"' + "/".join(words[-3:]) + '"'


def _twin(named: _Named) -> str:
    return f"{_path(named.words)} occurs twice in the same place"


def _buried_message(named: _Named) -> str:
    return f"{_path(named.words)} is hidden inside {_path(named.other)}"


def _deep(named: _Named) -> str:
    return f"{_path(named.words)} overlaps its neighbour of the same word by {named.finding.amount:.3g}"


def _through(named: _Named) -> str:
    return f"{_path(named.words)} passes through {_path(named.other)}, {named.finding.amount:.3g} deep"


def _unstable(named: _Named) -> str:
    where = f"where it rests on {_path(named.other)}" if named.other else "its foot"
    return f"{_path(named.words)} would fall: its centre of mass is {named.finding.amount:.3g} beside {where}"


def _hovering_message(named: _Named) -> str:
    amount = f"{named.finding.amount:.3g}"
    if not named.other:
        return f"{_path(named.words)} floats {amount} above the ground"
    return f"{_path(named.words)} floats {amount} from {_path(named.other)}"


def _sunk(named: _Named) -> str:
    return f"{_path(named.words)} extends {named.finding.amount:.3g} below the ground, y = 0"


def _fighting(named: _Named) -> str:
    return f"a face of {_path(named.words)} is coplanar with one of {_path(named.other)} in another colour (z-fighting)"


_MESSAGES: dict[str, tuple[str, Callable[[_Named], str]]] = {
    "twin": ("overlap", _twin),
    "buried": ("overlap", _buried_message),
    "deep": ("overlap", _deep),
    "through": ("overlap", _through),
    "hovering": ("floating", _hovering_message),
    "unstable": ("unstable", _unstable),
    "sunk": ("below-ground", _sunk),
    "fighting": ("coincident-faces", _fighting),
}
