"""Primitives of one frame as bodies in world coordinates, and their contacts.

Bodies are compared as convex solids first (``distance``). If one of a pair is not convex, such as a mug, a ring or a
bowl, contacts and overlaps of the hulls are verified on the surfaces, by Manifold.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from scenelang.backends.surfaces.appearance import look_of
from scenelang.backends.surfaces.distance import IntArray, Pairs, boxes, depths, distances, neighbors
from scenelang.backends.surfaces.solids import FloatArray, PosedForms, composed, own_mesh, posed_forms
from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.scene.entity import Entity, descendants, primitive_count
from scenelang.interpreter.scene.flatten import flatten_entity
from scenelang.interpreter.scene.modelling.computing import manifold_of_mesh
from scenelang.interpreter.scene.primitives import Placed
from scenelang.interpreter.scene.primitives.cube import BLOCK, placed_block
from scenelang.interpreter.values.values import IDENTITY

if TYPE_CHECKING:
    from manifold3d import Manifold

MAX_PAIRS = 1_000_000  # neighboring pairs of a frame
MAX_EXACT = 3_000  # pairs of a frame that are compared by their surfaces; further ones by their hulls
MAX_TRIANGLES = 20_000  # of a surface that is compared; larger ones are compared by their hulls
# The contact tolerance is the smaller of two lengths. On a wide ground the diagonal is large and small objects would
# all touch, so it is also limited by the size of the bodies: the diagonal of the box that three quarters are below.
_TOUCH_OF_SCENE = 1e-3  # relative to the scene's diagonal
_TOUCH_OF_BODIES = 0.03  # relative to the diagonal of a large body
_LARGE_QUANTILE = 0.75
_BATCH_PAIRS = 20_000  # pairs compared at once, which bounds the memory
_SIDES = 64  # of the polygons that stand for round surfaces
_SUNK_SHARE = 0.3  # of what a body has below another's top, inside that one: it is sunk rather than beside it
_MIN_SHARED = 1e-6  # relative to the smaller volume: surfaces that share less only touch
_CROSSING_THICKNESS = 0.45  # of the thinner body: tight fits share thinner layers (up to .37), walls that cross .57
_CROSSING_SHARE = 0.04  # of the smaller body: naves run into their towers, and spoons into rims, by less (up to .034)
_MAX_CROSSING_TRIANGLES = 10_000  # of two surfaces whose way out is searched: each of some 40 trials is a boolean
_BISECTIONS = 3  # of the length of a translation that separates two surfaces
_MIN_DETERMINANT = 1e-30  # of a pose: smaller ones have no volume


@dataclass(frozen=True, eq=False)
class Bodies:
    """N bodies of one frame: its visible primitives, each as a convex solid.

    Attributes
    ----------
    solids
        Convex solids in the world; a mesh is represented by its bounding box.
    entities, entity
        Primitives, and the index (N,) of that of each body.
    paths, path
        Words from the root to parents of primitives, and the index (N,) of that of each body.
    opaque
        Whether a body (N,) hides what is behind it.
    glowing
        Whether it emits light.
    colors
        Linear sRGB (N, 3).
    plain
        Bound words whose entities each consist of one primitive.
    exact
        Whether the solid (N,) is the primitive itself, not its box or convex hull.
    row
        Position (N,) among all primitives of the frame, in depth-first order.
    worlds
        Poses (N, 3, 4) of the primitives in the world.
    """

    solids: PosedForms
    entities: tuple[Entity, ...]
    entity: IntArray
    paths: tuple[tuple[str, ...], ...]
    path: IntArray
    opaque: npt.NDArray[np.bool_]
    glowing: npt.NDArray[np.bool_]
    colors: FloatArray
    plain: frozenset[str]
    exact: npt.NDArray[np.bool_]
    row: IntArray
    worlds: FloatArray

    def __len__(self) -> int:
        return len(self.solids)

    @cached_property
    def boxes(self) -> tuple[FloatArray, FloatArray]:
        """Low and high corners (N, 3) of the world-space boxes."""
        return boxes(self.solids)

    @cached_property
    def size(self) -> float:
        """Diagonal of the frame's bounding box."""
        low, high = self.boxes
        return float(np.linalg.norm(high.max(axis=0) - low.min(axis=0))) if len(self) else 0.0

    @cached_property
    def touch(self) -> float:
        """Contact tolerance, in scene units."""
        low, high = self.boxes
        usual = float(np.quantile(np.linalg.norm(high - low, axis=1), _LARGE_QUANTILE)) if len(self) else 0.0
        return min(_TOUCH_OF_SCENE * self.size, _TOUCH_OF_BODIES * usual)

    def pairs(self, numbers: IntArray) -> Pairs:
        """Return the solids of pairs (M, 2) of indices."""
        a, b = numbers[:, 0], numbers[:, 1]
        return Pairs(self.solids.take(a), self.solids.take(b))

    def gaps(self, numbers: IntArray) -> FloatArray:
        """Return the distances of pairs (M, 2); 0 if they touch or overlap."""
        low, high = self.boxes
        a, b = numbers[:, 0], numbers[:, 1]
        gaps = np.linalg.norm(np.maximum(np.maximum(low[a] - high[b], low[b] - high[a]), 0.0), axis=1)
        others = np.flatnonzero(~self.aligned[numbers].all(axis=1))  # than boxes along the axes
        for start in range(0, len(others), _BATCH_PAIRS):
            rows = others[start : start + _BATCH_PAIRS]
            gaps[rows] = distances(self.pairs(numbers[rows]))
        return np.asarray(gaps, np.float64)

    @cached_property
    def aligned(self) -> npt.NDArray[np.bool_]:
        """Mask (N,) of bodies that are blocks along the axes of the world."""
        matrices = np.abs(self.solids.matrices[:, :, :3])
        straight = (matrices > 1e-9 * matrices.max(axis=(1, 2), keepdims=True)).sum(axis=(1, 2)) == 3
        blocks = np.array([kind is BLOCK for kind in self.solids.kinds], bool)[self.solids.forms]
        return np.asarray(straight & blocks & ~self.hollow, bool)

    def common_points(self, i: int, j: int, shift: FloatArray) -> FloatArray:
        """Return the corners (K, 3) of the intersection of two bodies, of which body ``j`` is moved by ``shift`` (3,).

        The result is empty if they do not meet, or if a surface is unknown.
        """
        a, b = self.surface(i), self.surface(j)
        if a is None or b is None:
            return np.zeros((0, 3))
        x, y, z = shift.tolist()
        both = a ^ b.translate((x, y, z))
        if both.is_empty():
            return np.zeros((0, 3))
        return np.asarray(both.to_mesh64().vert_properties[:, :3], np.float64)

    @cached_property
    def contacts(self) -> tuple[IntArray, FloatArray, bool]:
        """The touching pairs (M, 2), their distances, and whether all pairs were checked."""
        near, complete = neighbors(*self.boxes, self.touch, MAX_PAIRS)
        return *self.touching(near), complete

    def touching(self, near: IntArray) -> tuple[IntArray, FloatArray]:
        """Return the pairs (M, 2) among nearby ones (K, 2) that touch, and their distances."""
        gaps = self.gaps(near)
        close = gaps <= self.touch
        near, gaps = near[close], gaps[close]
        for row in self._doubtful(near):
            a, b = (self.surface(i) for i in near[row].tolist())
            if a is not None and b is not None:
                gaps[row] = a.min_gap(b, 2.0 * self.touch)
        close = gaps <= self.touch
        return near[close], gaps[close]

    def _doubtful(self, pairs: IntArray) -> Sequence[int]:
        """Return the rows of pairs (M, 2) with a body that is not convex: their hulls may touch where they do not."""
        hollow = self.hollow
        rows: list[int] = np.flatnonzero(hollow[pairs].any(axis=1)).tolist() if len(pairs) else []
        return rows[:MAX_EXACT]

    @cached_property
    def hollow(self) -> npt.NDArray[np.bool_]:
        """Which bodies (N,) are not convex; placeholders of words count as their boxes."""
        solid = [entity.shape is not None and not entity.shape.is_semantic for entity in self.entities]
        return np.asarray(~self.exact & np.array(solid, bool)[self.entity], bool)

    @cached_property
    def surfaces(self) -> dict[int, Manifold | None]:
        """Surfaces of the primitives in their own axes, by index of the entity."""
        return {}

    def surface(self, i: int) -> Manifold | None:
        """Return the surface of a body in the world, None if it is open or too large."""
        number = int(self.entity[i])
        if number not in self.surfaces:
            self.surfaces[number] = self._local_surface(i)
        local = self.surfaces[number]
        is_form = not self.hollow[i] or self._is_form(i)
        return None if local is None else local.transform((self.solids.matrices if is_form else self.worlds)[i])

    def _is_form(self, i: int) -> bool:
        """Return whether a body is a canonical form under a pose, rather than a mesh in the primitive's axes."""
        shape = self.entities[self.entity[i]].shape
        return shape is None or shape.placed() is not None

    def _local_surface(self, i: int) -> Manifold | None:
        """Return the surface of a primitive in its own axes; None if it is open or too large."""
        entity = self.entities[self.entity[i]]
        form, ratios = self.solids.form(i)
        try:
            mesh = form.mesh(_SIDES, ratios) if not self.hollow[i] or self._is_form(i) else own_mesh(entity.shape)
            return None if mesh is None or len(mesh.faces) > MAX_TRIANGLES else manifold_of_mesh(mesh, entity.word)
        except SceneError:
            return None

    def overlaps(self, pairs: IntArray) -> tuple[FloatArray, FloatArray]:
        """Return the penetration depths (M,) of touching pairs (M, 2), and the directions (M, 3) that separate them.

        The direction is that in which the second body of a pair leaves the first. A body that touches the inside of a
        hollow one, as a spoon does a mug, has depth 0 and rests on it: the direction is up.
        """
        batches = [pairs[i : i + _BATCH_PAIRS] for i in range(0, len(pairs), _BATCH_PAIRS)]
        results = [depths(self.pairs(batch), self.touch) for batch in batches]
        depth = np.concatenate([np.zeros(0), *(depth for depth, _ in results)])
        along = np.concatenate([np.zeros((0, 3)), *(along for _, along in results)])
        for row in self._doubtful(pairs):
            if depth[row] <= self.touch:
                continue
            first, second = pairs[row].tolist()
            shared = self._common(first, second)
            if shared is not None:
                depth[row], along[row] = self._depth(first, second, shared, (float(depth[row]), along[row]))
        return depth, along

    def _depth(
        self, first: int, second: int, shared: Manifold, hulls: tuple[float, FloatArray]
    ) -> tuple[float, FloatArray]:
        """Return the penetration depth and direction (3,) of two bodies, given what they and what their hulls share.

        It is the mean thickness of the overlap, since two gears share a thin layer at many teeth, whose box is large;
        where the bodies cross, such as the walls of two cups in each other, it is what separates them.
        """
        volume = float(shared.volume())
        box = np.array(shared.bounding_box()).reshape(2, 3)
        if volume <= 0.0:
            return 0.0, np.array([0.0, self._side(first, second, 1, np.zeros(3)), 0.0])
        sunk = self._sunk(first, second, volume)
        if sunk is not None:
            return sunk
        extents = np.maximum(box[1] - box[0], 0.0)
        axis = int(np.argmin(extents))
        thickness = volume / float(np.delete(extents, axis).prod())
        along = np.eye(3)[axis] * self._side(first, second, axis, box.mean(axis=0))
        if not self._cross(first, second, shared):
            return thickness, along
        return self._way_out(first, second, (thickness, along), hulls)

    def _cross(self, first: int, second: int, shared: Manifold) -> bool:
        """Return whether what two bodies share is about as thick as the thinner one, and more than a corner of it.

        Twice the volume by the surface is the thickness of a plate. The walls of two bowls in each other share their
        whole thickness; a pin that fits tightly into its hole shares a layer with it, and a gallery around a tower,
        which nothing separates by a short way, a ring.
        """
        if shared.genus() > 0:
            return False
        surfaces = [surface for surface in (self.surface(first), self.surface(second)) if surface is not None]
        volumes = [float(surface.volume()) for surface in surfaces]
        thickness = min(volume / float(surface.surface_area()) for surface, volume in zip(surfaces, volumes))
        is_thick = float(shared.volume()) >= _CROSSING_THICKNESS * thickness * float(shared.surface_area())
        is_large = float(shared.volume()) >= _CROSSING_SHARE * min(volumes)
        is_cheap = sum(surface.num_tri() for surface in surfaces) <= _MAX_CROSSING_TRIANGLES
        return is_thick and is_large and is_cheap and not self._fits(*surfaces)

    def _fits(self, first: Manifold, second: Manifold) -> bool:
        """Return whether two bodies share nothing if either is smaller by the contact tolerance on each side.

        A sleeve with a slit on a cup and a helmet on a head are tight fits, however far the way out of them is.
        """
        for body, other in ((first, second), (second, first)):
            box = np.array(body.bounding_box()).reshape(2, 3)
            middle, extents = box.mean(axis=0), np.maximum(box[1] - box[0], 1e-300)
            factors = np.maximum(1.0 - 2.0 * self.touch / extents, 0.0)
            if not (factors > 0.0).all():
                continue
            x, y, z = middle.tolist()
            smaller = body.translate((-x, -y, -z)).scale(tuple(factors.tolist())).translate((x, y, z))
            if _shared(smaller, other).is_empty():
                return True
        return False

    def _way_out(
        self, first: int, second: int, shortest: tuple[float, FloatArray], hulls: tuple[float, FloatArray]
    ) -> tuple[float, FloatArray]:
        """Return the length and direction (3,) of a short translation of the second of two bodies out of the first.

        Parameters
        ----------
        first, second
            Two bodies that overlap, at least one of them concave.
        shortest
            The least length that is returned, and the direction to try first.
        hulls
            Translation that separates their convex hulls, and so the bodies.

        Notes
        -----
        The axes of the world and the direction of the hulls are tried at lengths that double; then the length is
        bisected. The mean thickness alone says .1 for two cups whose walls cross 2 deep.
        """
        a, b = self.surface(first), self.surface(second)
        if a is None or b is None:
            return shortest

        def is_apart(length: float, way: FloatArray) -> bool:
            """Return whether a translation separates the bodies."""
            x, y, z = (length * way).tolist()
            return bool(_shared(a, b.translate((x, y, z))).is_empty())

        length, ways = max(shortest[0], self.touch), [shortest[1], *np.eye(3), *-np.eye(3), hulls[1]]
        while length < hulls[0]:
            way = next((way for way in ways if is_apart(length, way)), None)
            if way is not None:
                low = max(length / 2.0, shortest[0])
                for _ in range(_BISECTIONS):
                    middle = (low + length) / 2.0
                    low, length = (low, middle) if is_apart(middle, way) else (middle, length)
                return length, way
            length *= 2.0
        return hulls

    def _side(self, first: int, second: int, axis: int, shared: FloatArray) -> float:
        """Return the sign of the direction along an axis in which the second of two bodies leaves the first.

        The smaller one leaves to the side of what they share, whose middle is given, on which most of it is: that of
        the whole of the larger one says nothing of a ball in a valley.
        """
        (low, high), middles = self.boxes, self._middles
        smaller, sign = (
            (second, 1.0) if np.prod((high - low)[second]) <= np.prod((high - low)[first]) else (first, -1.0)
        )
        offset = float(middles[smaller, axis] - shared[axis])
        if abs(offset) <= self.touch:
            offset, sign = float(middles[second, axis] - middles[first, axis]), 1.0
        return sign if offset >= 0.0 else -sign

    def _sunk(self, first: int, second: int, shared: float) -> tuple[float, FloatArray] | None:
        """Return how deep the higher of two bodies is in the lower one, and the direction; None if it is not sunk.

        A jar in a board shares a thin ring with it, but must be lifted by the height of the ring. Of what is below
        the other's top, much is inside: a spoon that leans in a bowl, and crosses its rim, is not sunk.
        """
        (bottom, top), middle = (corner[:, 1] for corner in self.boxes), self._middles[:, 1]
        upper, lower = (first, second) if middle[first] > middle[second] else (second, first)
        surface = self.surface(upper)
        if surface is None or shared <= 0.0 or top[upper] <= top[lower] + self.touch:
            return None
        below = surface.trim_by_plane((0.0, -1.0, 0.0), -float(top[lower])).volume()
        if shared < _SUNK_SHARE * below:
            return None
        return float(top[lower] - bottom[upper]), np.array([0.0, 1.0 if upper == second else -1.0, 0.0])

    @cached_property
    def _middles(self) -> FloatArray:
        """Centers (N, 3) of the boxes."""
        low, high = self.boxes
        return (low + high) / 2.0

    def _common(self, i: int, j: int) -> Manifold | None:
        """Return what two bodies share, empty if they only touch; None if a surface is unknown."""
        a, b = self.surface(i), self.surface(j)
        if a is None or b is None:
            return None
        return _shared(a, b)

    @cached_property
    def masses(self) -> tuple[FloatArray, FloatArray]:
        """Volumes (N,) and centers of mass (N, 3)."""
        matrices = self.solids.matrices
        volume, center = np.zeros(len(self)), matrices[:, :, 3].copy()
        scale = np.abs(np.linalg.det(matrices[:, :, :3]))
        for form, ratios, rows in self.solids.members():
            volume[rows] = form.volume(ratios) * scale[rows]
            if form.name == "cone":  # a quarter of the height above the base; the form's origin is half-way up
                center[rows] -= 0.5 * matrices[rows, :, 1]
        for i in np.flatnonzero(self.hollow)[:MAX_EXACT].tolist():
            surface = None if self._is_form(i) else self.surface(i)
            if surface is not None:
                volume[i], center[i] = surface.volume(), _centroid(surface)
        return np.maximum(volume, 1e-12 * scale.max(initial=1.0)), center

    def words(self, i: int) -> tuple[str, ...]:
        """Return the words from the root to a body."""
        return (*self.paths[self.path[i]], self.entities[self.entity[i]].word)


def _shared(first: Manifold, second: Manifold) -> Manifold:
    """Return what two surfaces share, empty if they only touch."""
    both = first ^ second
    is_slight = float(both.volume()) <= _MIN_SHARED * min(float(first.volume()), float(second.volume()))
    return type(both)() if is_slight else both


def bodies_of(root: Entity) -> Bodies:
    """Return the visible primitives below ``root`` as bodies, without those of zero volume."""
    frame = flatten_entity(root)
    placed = [_placed(entity) for entity in frame.primitives]
    looks = [look_of(entity) for entity in frame.primitives]
    has_form = np.array([form is not None for form in placed], bool)
    visible = np.array([look.opacity > 0.0 for look in looks], bool)
    index = np.asarray(frame.index)
    chosen = np.flatnonzero((has_form & visible)[index]) if len(index) else np.zeros(0, np.int64)
    index = index[chosen]
    forms = posed_forms(placed).take(index)
    matrices = composed(np.asarray(frame.matrices)[chosen], forms.matrices)
    solid = np.abs(np.linalg.det(matrices[:, :, :3])) > _MIN_DETERMINANT if len(chosen) else np.zeros(0, bool)
    chosen, index = chosen[solid], index[solid]
    return Bodies(
        replace(forms, matrices=matrices).take(solid),
        frame.primitives,
        index,
        frame.paths,
        np.asarray(frame.path_index)[chosen],
        np.array([look.opacity >= 1.0 for look in looks], bool)[index],
        np.array([any(look.emission) for look in looks], bool)[index],
        np.array([look.color for look in looks], np.float64).reshape(-1, 3)[index],
        _plain_words(root),
        np.array([_is_exact(entity) for entity in frame.primitives], bool)[index],
        chosen,
        np.asarray(frame.matrices)[chosen],
    )


def _is_exact(entity: Entity) -> bool:
    """Return whether the body of a primitive is convex and the primitive itself."""
    placed = None if entity.shape is None or entity.shape.is_semantic else entity.shape.placed()
    return placed is not None and placed.form.is_convex


def _centroid(surface: Manifold) -> FloatArray:
    """Return the center of mass (3,) of the inside of a surface.

    It is the mean of the tetrahedra that its triangles span with the mean of its corners, weighted by signed volume.
    """
    mesh = surface.to_mesh64()
    corners = np.asarray(mesh.vert_properties[:, :3], np.float64)[np.asarray(mesh.tri_verts, np.int64)]
    middle = corners.reshape(-1, 3).mean(axis=0)
    corners = corners - middle
    volume = np.einsum("ni,ni->n", corners[:, 0], np.cross(corners[:, 1], corners[:, 2]))
    return np.asarray((corners.sum(axis=1) / 4.0 * volume[:, None]).sum(axis=0) / volume.sum() + middle, np.float64)


def _plain_words(root: Entity) -> frozenset[str]:
    """Return the bound words whose entities all consist of one primitive."""
    counts: dict[str, set[int]] = {}
    for entity in descendants(root):
        if not entity.is_primitive:
            counts.setdefault(entity.word, set()).add(primitive_count(entity))
    return frozenset(word for word, numbers in counts.items() if numbers == {1})


def _placed(entity: Entity) -> Placed | None:
    """Return the convex form that replaces a primitive, under its pose in the primitive's frame, or None.

    It is the canonical form if the primitive has one; otherwise, as for a mesh, its bounding box. None for primitives
    that are invisible or have no extent, and for blocks, which replace earlier ones at the same place and so cannot
    overlap.
    """
    shape = entity.shape
    if shape is None or not shape.has_geometry or shape.is_block:
        return None
    placed = shape.placed()
    if placed is not None or (shape.is_solid and shape.is_flat):
        return placed
    low, high = np.array(shape.box_under(IDENTITY)).reshape(2, 3)
    if not shape.is_file and not (high > low).any():  # a single point, without a surface
        return None
    x, y, z = (high - low).tolist()
    rows = np.array(placed_block((x, y, z)).rows).reshape(3, 4)
    rows[:, 3] = (low + high) / 2.0
    return placed_block((x, y, z))._replace(rows=tuple(rows.ravel().tolist()))


def clusters(count: int, pairs: Iterable[Sequence[int]]) -> IntArray:
    """Return the connected components of a graph, by union-find with path halving (Tarjan and van Leeuwen, 1984).

    Parameters
    ----------
    count
        Number of nodes.
    pairs
        Edges, as pairs of nodes.

    Returns
    -------
    labels : (count,)
        Equal for nodes of one component: the number of one of them.

    Examples
    --------
    >>> labels = clusters(4, [(0, 2), (2, 3)])
    >>> bool(labels[0] == labels[3]), bool(labels[0] == labels[1])
    (True, False)
    """
    parent = list(range(count))

    def root(i: int) -> int:
        """Return the representative of the component of a node."""
        while parent[i] != i:
            parent[i] = parent[parent[i]]
            i = parent[i]
        return i

    for i, j in pairs:
        parent[root(i)] = root(j)
    return np.array([root(i) for i in range(count)], np.int64)


# --- polygons of contact and support ----------------------------------------------------------------------------------


def plane_axes(normal: FloatArray) -> FloatArray:
    """Return two unit vectors perpendicular to ``normal`` as columns (3, 2)."""
    least = np.eye(3)[int(np.argmin(np.abs(normal)))]
    u = np.cross(normal, least)
    u /= np.linalg.norm(u)
    return np.stack([u, np.cross(normal, u)], axis=1)


def signed_area(polygon: FloatArray) -> float:
    """Return the signed area of a polygon (K, 2), positive if it is counter-clockwise (shoelace formula)."""
    if len(polygon) < 3:
        return 0.0
    x, y = (polygon - polygon[0]).T  # products of coordinates far from the origin would cancel
    return float((x * np.roll(y, -1) - y * np.roll(x, -1)).sum() / 2.0)


def beyond_edge(points: FloatArray, at: FloatArray) -> tuple[float, FloatArray]:
    """Return how far a point is outside a convex hull, and the nearest point of its edge.

    Parameters
    ----------
    points : (K, 2)
        Points whose convex hull is meant.
    at : (2,)
        The point; the distance is negative if it is inside.
    """
    return _beyond(hull_of(points), at)


def all_within(points: FloatArray, others: FloatArray, margin: float) -> bool:
    """Return whether all ``others`` (L, 2) are in the convex hull of points (K, 2), or at most ``margin`` outside."""
    corners = hull_of(points)
    if len(corners) > 2:
        edges, away = np.roll(corners, -1, axis=0) - corners, others[:, None] - corners
        outside = (edges[:, 0] * away[..., 1] - edges[:, 1] * away[..., 0] < 0.0).any(axis=1)
        others = others[outside]
    return all(_beyond(corners, other)[0] <= margin for other in others)


def _beyond(corners: FloatArray, at: FloatArray) -> tuple[float, FloatArray]:
    """Return ``beyond_edge`` for the corners of a convex hull."""
    edges, away = np.roll(corners, -1, axis=0) - corners, at - corners
    share = np.clip((edges * away).sum(axis=1) / np.maximum((edges**2).sum(axis=1), 1e-300), 0.0, 1.0)
    nearest = corners + share[:, None] * edges
    distance = np.linalg.norm(at - nearest, axis=1)
    best = int(np.argmin(distance))
    inside = len(corners) > 2 and bool((edges[:, 0] * away[:, 1] - edges[:, 1] * away[:, 0] >= 0.0).all())
    return float(-distance[best] if inside else distance[best]), nearest[best]


def width_of(points: FloatArray) -> float:
    """Return the smallest width of the convex hull of points (K, 2), over all directions."""
    corners = hull_of(points)
    if len(corners) < 3:
        return 0.0
    edges = np.roll(corners, -1, axis=0) - corners
    normals = np.stack([edges[:, 1], -edges[:, 0]], axis=1) / np.linalg.norm(edges, axis=1)[:, None]
    return float(np.ptp(normals @ corners.T, axis=1).min())


def hull_of(points: FloatArray) -> FloatArray:
    """Return the convex hull of points (K, 2), counter-clockwise (monotone chain, Andrew, 1979)."""
    order = sorted(set(map(tuple, points.tolist())))
    if len(order) < 3:
        return np.array(order)
    chains = []
    for run in (order, order[::-1]):
        chain: list[tuple[float, ...]] = []
        for p in run:
            while len(chain) > 1 and _turn(chain[-2], chain[-1], p) <= 0.0:
                chain.pop()
            chain.append(p)
        chains += chain[:-1]
    return np.array(chains)


def _turn(a: Sequence[float], b: Sequence[float], c: Sequence[float]) -> float:
    """Return twice the signed area of a triangle (2,): positive for a left turn."""
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
