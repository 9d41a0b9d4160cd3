"""Computes solids with Manifold (Lalish, https://github.com/elalish/manifold): expressions become triangle meshes.

Every node is computed once and cached; surfaces that took long are stored on disk too. Manifold numbers the surfaces
that enter an operation and says for each triangle of a result where it comes from, which gives colors and words.

Normals are smooth within a surface. They are computed in ``primitives/mesh``, because Manifold's ``calculate_normals``
took 25 s for 2,916 joined primitives (350,000 triangles), where ours takes one.
"""

from __future__ import annotations

import math
import time
from collections import Counter, OrderedDict
from collections.abc import Callable, Mapping, Sequence
from threading import Lock
from typing import TYPE_CHECKING, Any, NamedTuple

from scenelang.grammar.datum import Span
from scenelang.grammar.diagnostics import LimitError, Note, SceneError
from scenelang.interpreter.loading import np
from scenelang.interpreter.scene.modelling import stored
from scenelang.interpreter.scene.modelling.contours import EVEN_ODD, NON_ZERO, apart, normalized, section_of, untouching
from scenelang.interpreter.scene.modelling.operations import PRIMITIVE, REPLACING, SEGMENTS, Expression, nodes_of
from scenelang.interpreter.scene.modelling.stored import ComputedSolid
from scenelang.interpreter.scene.modelling.sweeping import (
    FEWER_SLICES,
    check_corners,
    height_field,
    lofted,
    swept,
    twisted,
)
from scenelang.interpreter.scene.primitives.base import Point, Primitive, mesh_of
from scenelang.interpreter.scene.primitives.mesh import Mesh, posed, smoothed

if TYPE_CHECKING:
    import numpy.typing as npt
    from manifold3d import CrossSection, Manifold, Mesh64

    FloatArray = npt.NDArray[np.float64]
    IntArray = npt.NDArray[np.int64]

MAX_TRIANGLES = 2_000_000  # of a solid
# Of the operands of one operation, which may be many more than the result has. Each takes 5.5 microseconds and, of
# overlapping spheres, 200 bytes: the largest operation takes a minute and 2 GB.
MAX_OPERAND_TRIANGLES = 10_000_000
MAX_PAIRS = 200_000  # pairs of faces of a Minkowski sum, each of which takes about 60 microseconds
_MAX_JOINT_CONTOURS = 16  # of a profile that is extruded as a whole; more are split into parts that lie apart
_MAX_CONCAVITY = 1e-6  # share of the volume of its hull that a convex tool may lack, for rounding
_CACHED_TRIANGLES = 8_000_000  # of computed nodes, and again of surfaces
_MIN_STORED_SECONDS = 0.05  # of computation; reading a file takes a few milliseconds
_MIN_VOLUME_SHARE = 1e-12  # of the bounding box: a mesh with less volume is flat, up to rounding
_SHARP_DEGREES = 40.0  # angle between faces from which an edge is drawn sharp
_WELD_SHARE = 1e-9  # of the size of a mesh: vertices closer than that are one, split for its normals or by rounding


class FaceSource(NamedTuple):
    """Origin of faces: their color, and the word of the part that created them."""

    color: Point
    word: str


class _Node(NamedTuple):
    """Computed node: its manifold, and the sources of the surfaces in it by Manifold's number."""

    manifold: Manifold
    sources: Mapping[int, FaceSource]


class _TriangleCache:
    """Least-recently-used cache of computed values by digest, bounded by their total number of triangles."""

    def __init__(self, max_triangles: int) -> None:
        self._max_triangles, self._total = max_triangles, 0
        self._values: OrderedDict[str, tuple[Any, int]] = OrderedDict()
        self._lock = Lock()

    def get(self, key: str) -> Any:
        """Return the value of a digest, or None."""
        with self._lock:
            entry = self._values.get(key)
            if entry is None:
                return None
            self._values.move_to_end(key)
            return entry[0]

    def put(self, key: str, value: Any, size: int) -> None:
        """Add a value of ``size`` triangles, and evict others if there are too many; the newest one always stays."""
        with self._lock:
            if key in self._values:
                return
            self._values[key] = value, size
            self._total += size
            while self._total > self._max_triangles and len(self._values) > 1:
                _, (_, old) = self._values.popitem(last=False)
                self._total -= old


_manifolds, _surfaces = _TriangleCache(_CACHED_TRIANGLES), _TriangleCache(_CACHED_TRIANGLES)


Announce = Callable[[Span], None]  # called with the source location of the node that is computed next


def computed(expression: Expression, note: Announce | None = None) -> ComputedSolid:
    """Return the surface of an expression.

    Parameters
    ----------
    note
        Called with the location of each operation before it is computed.

    Raises
    ------
    SceneError
        "solid" if an operand is open, flat or otherwise not a solid, or if the result is empty: an image without it
        would be silently wrong. ``volume`` of an empty solid is 0, so that a program can ask first.
    LimitError
        "size" if there would be too many triangles.
    """
    surface = surface_of(expression, note)
    if surface is None:
        raise _nothing_left(expression)
    return surface


def _nothing_left(expression: Expression) -> SceneError:
    """Return the error for an empty solid, at the innermost operation whose result is empty."""
    node = expression
    while (inner := _empty_operand(node)) is not None:
        node = inner
    message = f"`{node.operation}` leaves nothing"
    if node.caller:
        side = "inside" if node.operation == "intersection" else "outside"
        message = f"`{node.caller}` leaves nothing {side} of its tool"
    notes: tuple[Note, ...] = ()
    if node is not expression and expression.site is not None and expression.operation != PRIMITIVE:
        notes = (Note(f"so `{expression.caller or expression.operation}` leaves nothing", expression.site),)
    hint = "where this may happen, test it: `(> (volume x) 0)`"
    return SceneError("solid", message, hint, node.site or expression.site, notes)


def _empty_operand(node: Expression) -> Expression | None:
    """Return the operand that makes the result of a node empty."""
    inner = [operand.expression for operand in node.operands]
    return next((operand for operand in inner[: _needed(node)] if manifold_of(operand).manifold.is_empty()), None)


def _needed(node: Expression) -> int:
    """Return the number of operands, from the first, that decide whether the result of a node is empty."""
    return 1 if node.operation not in (*_OF_ANY, *_OF_ALL) else len(node.operands)


def surface_of(expression: Expression, note: Announce | None = None) -> ComputedSolid | None:
    """Return the surface of an expression, from memory or disk if it is stored there, or None if the solid is empty.

    Raises SceneError and LimitError as ``computed`` does.
    """
    surface: ComputedSolid | None = _surfaces.get(expression.digest)
    if surface is None:
        surface = stored.load(expression.digest) or _computed(expression, note)
        if surface is not None:
            _surfaces.put(expression.digest, surface, len(surface.mesh.faces))
    return surface


def _computed(expression: Expression, note: Announce | None) -> ComputedSolid | None:
    """Compute the surface of an expression, and pass it to ``store``; None if the solid is empty.

    ``note`` is called with the location of each operation before it is computed.
    """
    started = time.perf_counter()
    node = manifold_of(expression, note)
    if node.manifold.is_empty():
        return None
    surface = _surface(node, time.perf_counter() - started)
    store(expression, surface)
    return surface


def store(expression: Expression, solid: ComputedSolid) -> None:
    """Store the surface of an expression on disk if computing it took long."""
    if solid.seconds > _MIN_STORED_SECONDS:
        stored.save(expression.digest, solid)


def manifold_of(expression: Expression, note: Announce | None = None) -> _Node:
    """Return the manifold of an expression, computing the nodes that are not cached, operands first.

    Results that no later node needs are dropped at once, because thousands of them would fill the memory.
    """
    local: dict[str, _Node] = {}
    nodes = list(nodes_of(expression))
    uses = Counter(operand.expression.digest for node in nodes for operand in node.operands)
    for node in nodes:
        result: _Node | None = _manifolds.get(node.digest)
        if result is None:
            operands = [local[operand.expression.digest] for operand in node.operands]
            if note is not None and node.site is not None:
                note(node.site)
            try:
                _check_operands(node, operands)
                result = _carried_out(node, operands)
                if result.manifold.num_tri() > MAX_TRIANGLES:
                    raise too_large(node.operation, result.manifold.num_tri())
            except SceneError as error:
                error.span = error.span or node.site
                raise
            triangles = result.manifold.num_tri()
            _manifolds.put(node.digest, result, triangles)
        local[node.digest] = result
        for operand in node.operands:
            uses[operand.expression.digest] -= 1
            if not uses[operand.expression.digest]:
                del local[operand.expression.digest]
    return local[expression.digest]


def _check_operands(node: Expression, operands: Sequence[_Node]) -> None:
    """Raise LimitError if the operands of an operation have too many triangles in all."""
    triangles = sum(operand.manifold.num_tri() for operand in operands)
    if triangles > MAX_OPERAND_TRIANGLES:
        raise too_many_operands(node.operation, triangles)


_FEWER_HINT = "use fewer :segments, or fewer operands"


def too_large(operation: str, triangles: int) -> LimitError:
    """Return the error for a solid of too many triangles."""
    message = f"`{operation}` makes a solid of {triangles:,} triangles, more than the limit of {MAX_TRIANGLES:,}"
    return LimitError("size", message, hint=_FEWER_HINT)


def too_many_operands(operation: str, triangles: int) -> LimitError:
    """Return the error for an operation that would take minutes."""
    message = (
        f"the operands of `{operation}` have {triangles:,} triangles in all, "
        f"more than the limit of {MAX_OPERAND_TRIANGLES:,}"
    )
    return LimitError("size", message, hint=_FEWER_HINT)


_OF_ANY = frozenset(("solid-union", "hull"))  # operations with an empty result if all operands are empty
_OF_ALL = frozenset(("intersection", "minkowski"))  # if one operand is empty; all other operations, if the first is
# Operations to which an operand may be given twice without a change.
_IDEMPOTENT = frozenset(("solid-union", "intersection", "hull"))


def _carried_out(node: Expression, operands: Sequence[_Node]) -> _Node:
    """Compute a node from its computed operands, with the sources of its surfaces."""
    import manifold3d

    pairs = list(zip(operands, node.operands, strict=True))
    if node.operation in _IDEMPOTENT:  # nested doublings would have 2^n surfaces without one more triangle
        distinct = {(o.expression.digest, o.pose, o.color): (computed_operand, o) for computed_operand, o in pairs}
        pairs = list(distinct.values())
    placed = [_placed(computed_operand, operand.pose, operand.color) for computed_operand, operand in pairs]
    if node.operation == PRIMITIVE:
        assert node.shape is not None
        manifold = manifold_of_mesh(leaf_mesh(node.shape, int(node.parameters.get("segments", SEGMENTS))), node.word)
    elif _is_nothing(node, placed):
        return _Node(manifold3d.Manifold(), {})
    else:
        manifold = _operated(node, [operand.manifold for operand in placed])
    check_status(manifold, node.operation)
    if not placed or node.operation in REPLACING:
        manifold = manifold.as_original()
        return _Node(manifold, {manifold.original_id(): FaceSource(node.color, node.word)})
    sources: dict[int, FaceSource] = {}
    for operand in placed:
        sources |= operand.sources
    if node.operation == "cut-plane":  # the face of the cut is new
        first = next(iter(placed[0].sources.values()))
        for number in manifold.to_mesh64().run_original_id:
            sources.setdefault(number, FaceSource(node.color, first.word))
    return _Node(manifold, sources)


def _is_nothing(node: Expression, placed: Sequence[_Node]) -> bool:
    """Return whether the result of a node is empty because operands are; Manifold is not asked then."""
    empty = [operand.manifold.is_empty() for operand in placed[: _needed(node)]]
    return bool(empty) and (all(empty) if node.operation in _OF_ANY else any(empty))


def _operated(node: Expression, operands: Sequence[Manifold]) -> Manifold:
    """Carry out an operation; its parameters may come from an untrusted file, so Python's errors are converted."""
    operation = OPERATIONS.get(node.operation)
    if operation is None:
        raise SceneError("solid", f"`{node.operation}` is no operation on solids")
    try:
        if node.operation in REPLACING:
            return _near_origin(node.operation, operation, node.parameters, operands)
        return operation(node.parameters, operands)
    except (KeyError, IndexError, TypeError, ValueError) as error:
        raise SceneError("solid", f"`{node.operation}` cannot be computed: {error}") from error


def _near_origin(name: str, operation: Operation, parameters: Parameters, operands: Sequence[Manifold]) -> Manifold:
    """Carry out an operation that makes new surfaces, with its operands at the origin, and move the result back.

    Hulls and sums compare points by distances of about 1e-12 of their coordinates, which far from the origin are as
    large as details of the solid. The position of a sum is the sum of those of its operands; the tools of the other
    operations are at the origin already.
    """
    if not operands or any(operand.is_empty() for operand in operands):
        return operation(parameters, operands)
    boxes = [np.array(operand.bounding_box()).reshape(2, 3) for operand in operands]
    if name == "hull":
        back = (np.min(boxes, axis=(0, 1)) + np.max(boxes, axis=(0, 1))) / 2.0
        middles = [back] * len(boxes)
    else:
        middles = [box.mean(axis=0) if name == "minkowski" or i == 0 else np.zeros(3) for i, box in enumerate(boxes)]
        back = np.sum(middles, axis=0)
    moved = [operand.translate((-middle).tolist()) for operand, middle in zip(operands, middles, strict=True)]
    return operation(parameters, moved).translate(back.tolist())


def _placed(node: _Node, pose: Sequence[float], color: Point | None) -> _Node:
    """Return a computed operand under its pose, with one color for all of its faces if ``color`` is given."""
    manifold, sources = node.manifold, node.sources
    if color is not None and any(source.color != color for source in sources.values()):
        sources, manifold = _recolored(manifold, sources, color)
    return _Node(manifold.transform(np.array(pose, np.float64).reshape(3, 4)), sources)


def _recolored(
    manifold: Manifold, sources: Mapping[int, FaceSource], color: Point
) -> tuple[dict[int, FaceSource], Manifold]:  # fmt: skip
    """Return a manifold whose surfaces have new numbers and another color.

    The old numbers stay those of the uncolored solid, which may be an operand as well.
    """
    import manifold3d

    mesh = manifold.to_mesh64()
    old = list(mesh.run_original_id)
    first = manifold3d.Manifold.reserve_ids(len(old))
    numbers = list(range(first, first + len(old)))
    renumbered = manifold3d.Mesh64(
        np.array(mesh.vert_properties), np.array(mesh.tri_verts), np.array(mesh.merge_from_vert, np.uint64),
        np.array(mesh.merge_to_vert, np.uint64), run_index=np.array(mesh.run_index, np.uint64),
        run_original_id=np.array(numbers, np.uint32),
    )  # fmt: skip
    return (
        {number: FaceSource(color, sources[before].word) for number, before in zip(numbers, old, strict=True)},
        manifold3d.Manifold(renumbered),
    )


# --- leaves ----------------------------------------------------------------------------------------------------------


def leaf_mesh(shape: Primitive, segments: int) -> Mesh:
    """Return the mesh of a primitive; full circles have ``segments`` sides."""
    placed = shape.placed()
    if placed is not None:
        return posed(placed.form.mesh(segments, placed.ratios), placed.matrix[None])
    return shape.triangulate(0.0) if shape.is_file else mesh_of(shape)


def manifold_of_mesh(mesh: Mesh, word: str) -> Manifold:
    """Return the manifold of a closed mesh whose vertices may be split; raises SceneError("solid") for others."""
    import manifold3d

    vertices, faces, _ = welded(mesh.vertices, mesh.faces)
    manifold = manifold3d.Manifold(manifold3d.Mesh64(vertices, faces.astype(np.uint64)))
    if manifold.status() != manifold3d.Error.NoError:
        raise SceneError("solid", f'"{word}" is no closed solid: {open_edges(vertices, faces)}', subject=mesh)
    extent = np.ptp(vertices, axis=0) if len(vertices) else np.zeros(3)
    if manifold.is_empty() or abs(manifold.volume()) <= _MIN_VOLUME_SHARE * float(extent.prod()):
        raise SceneError("solid", f'"{word}" has no volume', subject=mesh)
    if manifold.volume() < 0.0:  # its faces are turned inward
        outward = np.ascontiguousarray(faces[:, ::-1]).astype(np.uint64)
        manifold = manifold3d.Manifold(manifold3d.Mesh64(vertices, outward))
    return manifold


def welded(vertices: FloatArray, faces: IntArray) -> tuple[FloatArray, IntArray, IntArray]:
    """Join vertices that are at the same place up to rounding, and drop the faces that degenerate.

    Parameters
    ----------
    vertices : (V, 3)
    faces : (F, 3)

    Returns
    -------
    tuple
        Vertices, faces, and for each of these faces its index among the given ones.
    """
    size = float(np.ptp(vertices, axis=0).max(initial=0.0)) if len(vertices) else 0.0
    grid = np.rint((vertices - vertices.min(axis=0, initial=0.0)) / (max(size, 1e-300) * _WELD_SHARE))
    _, first, place = np.unique(grid, axis=0, return_index=True, return_inverse=True)
    joined = np.asarray(place.reshape(-1)[faces], np.int64)
    a, b, c = joined.T
    proper = np.flatnonzero((a != b) & (b != c) & (c != a))
    return vertices[first], joined[proper], proper


def open_edges(vertices: FloatArray, faces: IntArray) -> str:
    """Return why a mesh is not a closed solid, with the place of a wrong edge, for error messages."""
    if not len(faces):
        return "it has no faces"
    edges, key, _ = _directed_edges(faces)
    unique, counts = np.unique(key, return_counts=True)
    twice = edges[np.isin(key, unique[counts > 1])]
    if len(twice):
        return f"two faces use an edge in the same direction, at {_at(vertices, twice[0])}"
    alone = boundary_edges(faces)
    if len(alone):
        return f"{len(alone):,} edges belong to one face only, one at {_at(vertices, alone[0])}"
    return "its surface touches itself"


def boundary_edges(faces: IntArray) -> IntArray:
    """Return the edges (K, 2) at the boundary of a mesh: no other face uses them in the opposite direction."""
    edges, key, back = _directed_edges(faces)
    return edges[~np.isin(key, back)]


def _directed_edges(faces: IntArray) -> tuple[IntArray, IntArray, IntArray]:
    """Return the edges (K, 2) of faces, and a number for each edge and for its reverse."""
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    count = int(faces.max(initial=0)) + 1
    return edges, edges[:, 0] * count + edges[:, 1], edges[:, 1] * count + edges[:, 0]


def _at(vertices: FloatArray, edge: IntArray) -> str:
    """Return the middle of an edge as the program would write it."""
    x, y, z = vertices[edge].mean(axis=0).tolist()
    return f"[{x:.4g} {y:.4g} {z:.4g}]"


def check_status(manifold: Manifold, operation: str) -> None:
    """Raise SceneError("solid") if Manifold could not carry out an operation."""
    import manifold3d

    status = manifold.status()
    if status != manifold3d.Error.NoError:
        raise SceneError("solid", f"`{operation}` cannot be computed: {_REASONS.get(status.name, _OTHER_REASON)}")


# Descriptions of Manifold's status codes.
_REASONS = {
    "NonFiniteVertex": "coordinates are not finite, or too large",
    "NotManifold": "the surface is not closed",
    "InvalidConstruction": "its numbers make no solid, or nothing of its profile has an area",
    "ResultTooLarge": "it would have too many triangles",
}
_OTHER_REASON = "its operands make no solid"


# --- operations ------------------------------------------------------------------------------------------------------


Parameters = Mapping[str, Any]
Operation = Callable[[Parameters, Sequence["Manifold"]], "Manifold"]


def _boolean(name: str) -> Operation:
    """Return the boolean operation ``name``, a member of Manifold's ``OpType``: "Add", "Subtract" or "Intersect"."""

    def run(parameters: Parameters, operands: Sequence[Manifold]) -> Manifold:
        """Combine all operands at once."""
        import manifold3d

        kind = getattr(manifold3d.OpType, name)
        return operands[0] if len(operands) == 1 else manifold3d.Manifold.batch_boolean(list(operands), kind)

    return run


def _hull(parameters: Parameters, operands: Sequence[Manifold]) -> Manifold:
    import manifold3d

    return manifold3d.Manifold.batch_hull(list(operands))


def _minkowski(parameters: Parameters, operands: Sequence[Manifold]) -> Manifold:
    """Minkowski sum with a convex tool; sums with other tools are unions of such sums."""
    base, tool = operands
    if tool.volume() < (1.0 - _MAX_CONCAVITY) * tool.hull().volume():
        raise SceneError(
            "solid", "the tool of `minkowski` is not convex", "take its `hull`, or join sums of convex tools"
        )
    _check_pairs("minkowski", base, tool)
    return base.minkowski_sum(tool)


def _check_pairs(name: str, base: Manifold, tool: Manifold) -> None:
    """Raise LimitError if a Minkowski sum would take too long."""
    pairs = base.num_tri() * tool.num_tri()
    if pairs > MAX_PAIRS:
        message = f"`{name}` of {base.num_tri():,} and {tool.num_tri():,} triangles has {pairs:,} pairs of faces"
        raise LimitError("size", f"{message}, more than {MAX_PAIRS:,}", hint="use fewer :segments in both operands")


def _ball(parameters: Parameters, radius: float) -> Manifold:
    """Return a sphere of the operation's fineness, the tool of offsets."""
    import manifold3d

    return manifold3d.Manifold.sphere(radius, int(parameters["segments"]))


def _rounded(parameters: Parameters, operands: Sequence[Manifold]) -> Manifold:
    """Morphological opening (Serra, 1982): the union of all balls of a radius that fit inside the solid."""
    base, ball = operands[0], _ball(parameters, parameters["radius"])
    _check_pairs("rounded", base, ball)
    inner = base.minkowski_difference(ball)
    if inner.is_empty():
        raise SceneError("solid", f"`rounded` leaves nothing: no ball of radius {parameters['radius']:g} fits inside")
    return inner.minkowski_sum(ball)


def _shell(parameters: Parameters, operands: Sequence[Manifold]) -> Manifold:
    """The solid without its erosion by a ball: a wall of even thickness, inside the surface."""
    base, ball = operands[0], _ball(parameters, parameters["thickness"])
    _check_pairs("shell", base, ball)
    return base - base.minkowski_difference(ball)


def _offset(parameters: Parameters, operands: Sequence[Manifold]) -> Manifold:
    """Dilation by a ball, or erosion for a negative distance."""
    base, distance = operands[0], parameters["distance"]
    ball = _ball(parameters, abs(distance))
    _check_pairs("offset-solid", base, ball)
    return base.minkowski_sum(ball) if distance > 0.0 else base.minkowski_difference(ball)


def _cut(parameters: Parameters, operands: Sequence[Manifold]) -> Manifold:
    """The part in front of the plane ``normal . p = offset``; the normal need not be a unit vector."""
    normal = np.asarray(parameters["normal"], np.float64)
    length = float(np.linalg.norm(normal))
    return operands[0].trim_by_plane((normal / length).tolist(), float(parameters["offset"]) / length)


def _mesh(parameters: Parameters, operands: Sequence[Manifold]) -> Manifold:
    return manifold_of_mesh(Mesh(parameters["vertices"], None, parameters["faces"].astype(np.int64)), "mesh")


def _extrude(parameters: Parameters, operands: Sequence[Manifold]) -> Manifold:
    """Extrusion along z, straight by Manifold and twisted by ``sweeping.twisted``.

    Manifold's fixed diagonals give other volumes for left and right twists: they differ by 13 % for a square turned by
    90 degrees in eight layers.
    """
    height, twist = float(parameters["height"]), float(parameters["twist"])
    taper = tuple(float(factor) for factor in parameters["taper"])
    if twist:
        layers = int(parameters["slices"]) + 1
        filled = normalized(parameters["profile"], _fill_rule(parameters))
        check_corners("extrude", layers + 1, sum(map(len, filled)), FEWER_SLICES)
        parts = untouching(filled)
        surfaces = [twisted(part, height, math.radians(twist), parameters["taper"], layers) for part in parts]
        solid = _united([manifold_of_mesh(Mesh(vertices, None, faces), "extrude") for vertices, faces in surfaces])
    else:
        rule, slices = _fill_rule(parameters), int(parameters["slices"])
        solid = _straight(parameters["profile"], rule, height, slices, (taper[0], taper[1]))
    return solid.translate((0.0, 0.0, -height / 2.0)) if parameters["center"] else solid


def _fill_rule(parameters: Parameters) -> str:
    """Return the fill rule of a profile, which a file may have changed."""
    rule = parameters.get("fill", NON_ZERO)
    if rule not in (NON_ZERO, EVEN_ODD):
        raise SceneError("solid", f"a profile cannot be filled by the rule {str(rule)[:40]!r}")
    return str(rule)


def _straight(
    contours: Sequence[FloatArray], rule: str, height: float, slices: int, taper: tuple[float, float]
) -> Manifold:
    """Return an extrusion without a twist.

    Parts that lie apart are extruded separately, because Manifold's time is quadratic in the number of contours.
    """
    import manifold3d

    groups = apart(contours) if len(contours) > _MAX_JOINT_CONTOURS else [contours]
    parts = [section_of(group, rule).extrude(height, slices, 0.0, taper) for group in groups]
    if len(parts) == 1:
        return parts[0]
    meshes = [part.to_mesh64() for part in parts]
    vertices = [np.array(mesh.vert_properties[:, :3], np.float64) for mesh in meshes]
    starts = np.cumsum([0, *map(len, vertices[:-1])])
    faces = [np.array(mesh.tri_verts, np.uint64) + start for mesh, start in zip(meshes, starts.tolist(), strict=True)]
    return manifold3d.Manifold(manifold3d.Mesh64(np.concatenate(vertices), np.concatenate(faces)))


def _lathe(parameters: Parameters, operands: Sequence[Manifold]) -> Manifold:
    """Solid of revolution around the y axis."""
    section = section_of(parameters["profile"], _fill_rule(parameters))
    if not section.is_empty() and section.bounds()[2] <= 0.0:
        hint = "profiles turn around the y axis, where x is the distance from it"
        raise SceneError("solid", "the profile of `lathe` is on the left of the axis: no x is above 0", hint)
    sides, angle = int(parameters["segments"]), float(parameters["angle"])
    if sides < 3:  # Manifold would choose the number itself
        return _few_sided(section, sides, math.radians(angle))
    z_to_y = np.array([[1.0, 0, 0, 0], [0, 0, 1.0, 0], [0, -1.0, 0, 0]])  # Manifold revolves around z
    return section.revolve(sides, angle).transform(z_to_y)


def _few_sided(section: CrossSection, sides: int, angle: float) -> Manifold:
    """Return a part of a turn with one or two flat sides, as an extrusion that is bent around the axis."""
    import manifold3d

    low, high = section.bounds()[1::2]
    right = manifold3d.CrossSection.square((section.bounds()[2], high - low)).translate((0.0, low))
    mesh = (section ^ right).extrude(1.0, sides - 1).to_mesh64()
    x, y, share = np.array(mesh.vert_properties[:, :3], np.float64).T
    vertices = np.stack([x * np.cos(angle * share), y, -x * np.sin(angle * share)], axis=1)
    return manifold_of_mesh(Mesh(vertices, None, np.asarray(mesh.tri_verts, np.int64)), "lathe")


def _sweep(parameters: Parameters, operands: Sequence[Manifold]) -> Manifold:
    """Union of the surfaces and hulls of a sweep."""
    import manifold3d

    twist, rule = float(parameters["twist"]), _fill_rule(parameters)
    filled, pieces = normalized(parameters["profile"], rule), []
    check_corners("sweep", len(parameters["path"]), sum(map(len, filled)))
    for part in untouching(filled):
        sweep = swept(part, parameters["path"], twist, parameters["taper"])
        pieces += [manifold_of_mesh(Mesh(vertices, None, faces), "sweep") for vertices, faces in sweep.surfaces]
        pieces += [manifold3d.Manifold.hull_points(corners) for corners in sweep.hulls]
    return _united(pieces)


def _united(pieces: list[Manifold]) -> Manifold:
    """Return the boolean union of solids."""
    import manifold3d

    return pieces[0] if len(pieces) == 1 else manifold3d.Manifold.batch_boolean(pieces, manifold3d.OpType.Add)


def _loft(parameters: Parameters, operands: Sequence[Manifold]) -> Manifold:
    """Loft through profiles, whose contours come one after another with their numbers of points."""
    contours, counts = parameters["contours"], parameters["counts"].astype(np.int64)
    ends = np.cumsum(counts)
    profiles = [contours[end - count : end] for end, count in zip(ends, counts, strict=True)]
    vertices, faces = lofted(profiles, parameters["poses"])
    return manifold_of_mesh(Mesh(vertices, None, faces), "loft")


def _height_field(parameters: Parameters, operands: Sequence[Manifold]) -> Manifold:
    vertices, faces = height_field(parameters["heights"], parameters["size"], float(parameters["base"]))
    return manifold_of_mesh(Mesh(vertices, None, faces), "heightfield")


OPERATIONS: dict[str, Operation] = {
    "difference": _boolean("Subtract"),
    "intersection": _boolean("Intersect"),
    "solid-union": _boolean("Add"),
    "hull": _hull,
    "minkowski": _minkowski,
    "rounded": _rounded,
    "shell": _shell,
    "offset-solid": _offset,
    "cut-plane": _cut,
    "mesh": _mesh,
    "extrude": _extrude,
    "lathe": _lathe,
    "sweep": _sweep,
    "loft": _loft,
    "heightfield": _height_field,
}


# --- surfaces --------------------------------------------------------------------------------------------------------


def _surface(node: _Node, seconds: float) -> ComputedSolid:
    """Return the mesh of a computed node with its colors, words and normals.

    Vertices are split where normals differ; ``joints`` says which of them Manifold counts as one.
    """
    manifold = node.manifold
    hull = np.array(manifold.hull().to_mesh64().vert_properties[:, :3], np.float64)
    mesh = manifold.to_mesh64()
    run_sources = [node.sources[number] for number in mesh.run_original_id]
    sources = tuple(dict.fromkeys(run_sources))
    source = _face_sources(mesh, [sources.index(run_source) for run_source in run_sources])
    colors = np.array([origin.color for origin in sources], np.float64)[source]
    words = tuple(dict.fromkeys(origin.word for origin in sources))
    part = np.array([words.index(origin.word) for origin in sources], np.int64)[source] if len(words) > 1 else None
    vertices, joined = np.array(mesh.vert_properties[:, :3], np.float64), np.arange(len(mesh.vert_properties))
    joined[np.asarray(mesh.merge_from_vert, np.int64)] = np.asarray(mesh.merge_to_vert, np.int64)
    joints = joined[np.asarray(mesh.tri_verts, np.int64)]
    runs = _face_sources(mesh, range(len(mesh.run_original_id)))
    normals, faces, place = smoothed(vertices, joints, runs, _SHARP_DEGREES)
    surface = Mesh(vertices[place], normals, faces, colors, part, words, joints)
    return ComputedSolid(surface, hull, manifold.volume(), manifold.surface_area(), seconds)


def _face_sources(mesh: Mesh64, numbers: Sequence[int]) -> IntArray:
    """Return for each face (F,) the number that its run has in ``numbers``.

    A run is a range of faces of one source; ``run_index`` has the first corners of the runs, three for each face.
    """
    edges = np.asarray(mesh.run_index, np.int64) // 3
    return np.repeat(np.asarray(numbers, np.int64), np.diff(edges))
