"""Computes solids with Manifold (Lalish, https://github.com/elalish/manifold): expressions become triangle meshes.

Every node is computed once and kept while there is room; surfaces that took long are stored on disk too. Manifold
numbers the surfaces that enter an operation and says for each triangle of a result where it comes from, which gives
colours and words. Normals are smooth within a surface.
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
MAX_PAIRS = 200_000  # of faces of a Minkowski sum, each of which takes some 60 microseconds
_MANY_CONTOURS = 16  # of a profile, from which it is taken apart
_CONVEX = 1e-6  # share of the hull that a convex tool may lack
_KEPT_TRIANGLES = 8_000_000  # of computed nodes
_WORTH_STORING = 0.05  # seconds; reading a file takes a few milliseconds
_LEAST_VOLUME = 1e-12  # of the bounding box: what has less is turned inside out, or flat
_SHARP = 40.0  # degrees between faces from which an edge is drawn sharp


class FaceSource(NamedTuple):
    """Where faces come from: their colour, and the word of the part that they were made as."""

    color: Point
    word: str


class _Made(NamedTuple):
    """A computed node: its manifold, and the sources of the surfaces in it by Manifold's number."""

    manifold: Manifold
    sources: Mapping[int, FaceSource]


class _Kept:
    """Computed values by digest; those used longest ago go first when there are too many triangles."""

    def __init__(self, most: int) -> None:
        self._most, self._total = most, 0
        self._values: OrderedDict[str, tuple[Any, int]] = OrderedDict()
        self._lock = Lock()

    def get(self, key: str) -> Any:
        with self._lock:
            found = self._values.get(key)
            if found is None:
                return None
            self._values.move_to_end(key)
            return found[0]

    def put(self, key: str, value: Any, size: int) -> None:
        with self._lock:
            if key in self._values:
                return
            self._values[key] = value, size
            self._total += size
            while self._total > self._most and len(self._values) > 1:
                _, (_, old) = self._values.popitem(last=False)
                self._total -= old


_manifolds, _surfaces = _Kept(_KEPT_TRIANGLES), _Kept(_KEPT_TRIANGLES)


Announce = Callable[[Span], None]  # told where the program makes what is computed next


def computed(expression: Expression, note: Announce | None = None) -> ComputedSolid:
    """Return the surface of an expression.

    Raises
    ------
    SceneError
        "solid" if an operand is open, flat or otherwise no solid.
    LimitError
        "size" if there would be too many triangles.
    """
    found = surface_of(expression, note)
    if found is None:
        raise _nothing_left(expression)
    return found


def _nothing_left(expression: Expression) -> SceneError:
    """Return the error for an expression without a surface, at the operation that leaves nothing of its operands."""
    node = expression
    while (inner := _empty_operand(node)) is not None:
        node = inner
    message = f"`{node.operation}` leaves nothing"
    if node.caller:
        message = (
            f"`{node.caller}` leaves nothing {'inside' if node.operation == 'intersection' else 'outside'} of its tool"
        )
    notes: tuple[Note, ...] = ()
    if node is not expression and expression.site is not None and expression.operation != PRIMITIVE:
        notes = (Note(f"so `{expression.caller or expression.operation}` leaves nothing", expression.site),)
    hint = "where this may happen, test it: `(> (volume x) 0)`"
    return SceneError("solid", message, hint, node.site or expression.site, notes)


def _empty_operand(node: Expression) -> Expression | None:
    """Return the operand that makes the result of a node empty."""
    inner = [operand.expression for operand in node.operands]
    return next((each for each in inner[: _needed(node)] if manifold_of(each).manifold.is_empty()), None)


def _needed(node: Expression) -> int:
    """Return how many of the first operands a node has nothing without, or without all of them."""
    return 1 if node.operation not in (*_OF_ANY, *_OF_ALL) else len(node.operands)


def surface_of(expression: Expression, note: Announce | None = None) -> ComputedSolid | None:
    """Return the surface of an expression, from memory or disk if it is there, or None if nothing is left of it.

    Raises SceneError and LimitError as ``computed`` does.
    """
    found: ComputedSolid | None = _surfaces.get(expression.digest)
    if found is None:
        found = stored.load(expression.digest) or _computed(expression, note)
        if found is not None:
            _surfaces.put(expression.digest, found, len(found.mesh.faces))
    return found


def _computed(expression: Expression, note: Announce | None) -> ComputedSolid | None:
    started = time.perf_counter()
    made = manifold_of(expression, note)
    if made.manifold.is_empty():
        return None
    found = _surface(made, time.perf_counter() - started)
    store(expression, found)
    return found


def store(expression: Expression, solid: ComputedSolid) -> None:
    """Store the surface of an expression on disk if computing it took long."""
    if solid.seconds > _WORTH_STORING:
        stored.save(expression.digest, solid)


def manifold_of(expression: Expression, note: Announce | None = None) -> _Made:
    """Return the manifold of an expression, computing the nodes that are not kept, operands first."""
    local: dict[str, _Made] = {}  # without those that no later node needs: thousands would fill the memory
    nodes = list(nodes_of(expression))
    uses = Counter(operand.expression.digest for node in nodes for operand in node.operands)
    for node in nodes:
        made: _Made | None = _manifolds.get(node.digest)
        if made is None:
            operands = [local[operand.expression.digest] for operand in node.operands]
            if note is not None and node.site is not None:
                note(node.site)
            try:
                _check_operands(node, operands)
                made = _made(node, operands)
                if made.manifold.num_tri() > MAX_TRIANGLES:
                    raise too_large(node.operation, made.manifold.num_tri())
            except SceneError as error:
                error.span = error.span or node.site
                raise
            triangles = made.manifold.num_tri()
            _manifolds.put(node.digest, made, triangles)
        local[node.digest] = made
        for operand in node.operands:
            uses[operand.expression.digest] -= 1
            if not uses[operand.expression.digest]:
                del local[operand.expression.digest]
    return local[expression.digest]


def _check_operands(node: Expression, operands: Sequence[_Made]) -> None:
    """Raise the errors that are known before the operation."""
    triangles = sum(made.manifold.num_tri() for made in operands)
    if triangles > MAX_OPERAND_TRIANGLES:
        raise too_many_operands(node.operation, triangles)


_FEWER = "use fewer :segments, or fewer operands"


def too_large(operation: str, triangles: int) -> LimitError:
    """Return the error for a solid of too many triangles."""
    message = f"`{operation}` makes a solid of {triangles:,} triangles, more than the limit of {MAX_TRIANGLES:,}"
    return LimitError("size", message, hint=_FEWER)


def too_many_operands(operation: str, triangles: int) -> LimitError:
    """Return the error for an operation that would take minutes."""
    message = (
        f"the operands of `{operation}` have {triangles:,} triangles in all, "
        f"more than the limit of {MAX_OPERAND_TRIANGLES:,}"
    )
    return LimitError("size", message, hint=_FEWER)


_OF_ANY = frozenset(("union-solid", "hull"))  # operations that are empty if all operands are
_OF_ALL = frozenset(("intersection", "minkowski"))  # if one of them is; others if the first is
# Operations to which an operand may be given twice without a change.
_IDEMPOTENT = frozenset(("union-solid", "intersection", "hull"))


def _made(node: Expression, operands: Sequence[_Made]) -> _Made:
    import manifold3d

    pairs = list(zip(operands, node.operands, strict=True))
    if node.operation in _IDEMPOTENT:  # nested doublings would have 2^n surfaces without one more triangle
        pairs = list({(each.expression.digest, each.pose, each.color): (made, each) for made, each in pairs}.values())
    placed = [_placed(made, operand.pose, operand.color) for made, operand in pairs]
    if node.operation == PRIMITIVE:
        assert node.shape is not None
        manifold = manifold_of_mesh(leaf_mesh(node.shape, int(node.parameters.get("segments", SEGMENTS))), node.word)
    elif _is_nothing(node, placed):
        return _Made(manifold3d.Manifold(), {})
    else:
        manifold = _operated(node, [made.manifold for made in placed])
    check_status(manifold, node.operation)
    if not placed or node.operation in REPLACING:
        manifold = manifold.as_original()
        return _Made(manifold, {manifold.original_id(): FaceSource(node.color, node.word)})
    sources: dict[int, FaceSource] = {}
    for made in placed:
        sources |= made.sources
    if node.operation == "cut-plane":  # the face of the cut is new
        first = next(iter(placed[0].sources.values()))
        for number in manifold.to_mesh64().run_original_id:
            sources.setdefault(number, FaceSource(node.color, first.word))
    return _Made(manifold, sources)


def _is_nothing(node: Expression, placed: Sequence[_Made]) -> bool:
    """Whether a node has nothing because operands are empty, of which Manifold would compute no numbers."""
    empty = [made.manifold.is_empty() for made in placed[: _needed(node)]]
    return bool(empty) and (all(empty) if node.operation in _OF_ANY else any(empty))


def _operated(node: Expression, operands: Sequence[Manifold]) -> Manifold:
    """Carry out an operation, whose parameters may come from a file that anyone wrote."""
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
    """Carry out an operation that makes new surfaces with its operands at the origin, and move the result back.

    Hulls and sums compare points by distances of about 1e-12 of their coordinates, which far away are those of parts. A
    sum is as far away as its operands together; of the other operations only the solid itself may be far.
    """
    if not operands or any(each.is_empty() for each in operands):
        return operation(parameters, operands)
    boxes = [np.array(each.bounding_box()).reshape(2, 3) for each in operands]
    if name == "hull":
        back = (np.min(boxes, axis=(0, 1)) + np.max(boxes, axis=(0, 1))) / 2.0
        middles = [back] * len(boxes)
    else:
        middles = [box.mean(axis=0) if name == "minkowski" or i == 0 else np.zeros(3) for i, box in enumerate(boxes)]
        back = np.sum(middles, axis=0)
    moved = [each.translate((-middle).tolist()) for each, middle in zip(operands, middles, strict=True)]
    return operation(parameters, moved).translate(back.tolist())


def _placed(made: _Made, pose: Sequence[float], color: Point | None) -> _Made:
    """Return a computed operand under its pose, with one colour for all of its faces if ``color`` is given."""
    manifold, sources = made.manifold, made.sources
    if color is not None and any(source.color != color for source in sources.values()):
        sources, manifold = _recolored(manifold, sources, color)
    return _Made(manifold.transform(np.array(pose, np.float64).reshape(3, 4)), sources)


def _recolored(
    manifold: Manifold, sources: Mapping[int, FaceSource], color: Point
) -> tuple[dict[int, FaceSource], Manifold]:  # fmt: skip
    """Give the surfaces of a manifold new numbers, because its own ones stand for other colours."""
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
    """Return the mesh of a primitive, with so many sides of full circles."""
    placed = shape.placed()
    if placed is not None:
        return posed(placed.form.mesh(segments, placed.ratios), placed.matrix[None])
    return shape.triangulate(0.0) if shape.is_file else mesh_of(shape)


def manifold_of_mesh(mesh: Mesh, word: str) -> Manifold:
    """Return the manifold of a closed mesh whose vertices may be split; raises SceneError("solid") for others."""
    import manifold3d

    vertices, faces, _ = welded(mesh.vertices, mesh.faces)
    made = manifold3d.Manifold(manifold3d.Mesh64(vertices, faces.astype(np.uint64)))
    if made.status() != manifold3d.Error.NoError:
        raise SceneError("solid", f'"{word}" is no closed solid: {open_edges(vertices, faces)}', subject=mesh)
    extent = np.ptp(vertices, axis=0) if len(vertices) else np.zeros(3)
    if made.is_empty() or abs(made.volume()) <= _LEAST_VOLUME * float(extent.prod()):
        raise SceneError("solid", f'"{word}" has no volume', subject=mesh)
    if made.volume() < 0.0:  # faces turned inwards
        made = manifold3d.Manifold(manifold3d.Mesh64(vertices, np.ascontiguousarray(faces[:, ::-1]).astype(np.uint64)))
    return made


def welded(vertices: FloatArray, faces: IntArray) -> tuple[FloatArray, IntArray, IntArray]:
    """Join vertices that are at the same place up to rounding, and drop the faces that vanish.

    Returns vertices, faces, and for each face the index that it had.
    """
    size = float(np.ptp(vertices, axis=0).max(initial=0.0)) if len(vertices) else 0.0
    grid = np.rint((vertices - vertices.min(axis=0, initial=0.0)) / (max(size, 1e-300) * 1e-9))
    _, first, place = np.unique(grid, axis=0, return_index=True, return_inverse=True)
    found = np.asarray(place.reshape(-1)[faces], np.int64)
    a, b, c = found.T
    kept = np.flatnonzero((a != b) & (b != c) & (c != a))
    return vertices[first], found[kept], kept


def open_edges(vertices: FloatArray, faces: IntArray) -> str:
    """Return what is wrong with a mesh that is no closed solid, with a place."""
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
    """Return the edges (K, 2) that only one face uses in their direction, and none in the other."""
    edges, key, back = _directed_edges(faces)
    return edges[~np.isin(key, back)]


def _directed_edges(faces: IntArray) -> tuple[IntArray, IntArray, IntArray]:
    """Return the edges (K, 2) of faces, and a number for each edge and for its reverse."""
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    count = int(faces.max(initial=0)) + 1
    return edges, edges[:, 0] * count + edges[:, 1], edges[:, 1] * count + edges[:, 0]


def _at(vertices: FloatArray, edge: IntArray) -> str:
    x, y, z = vertices[edge].mean(axis=0).tolist()
    return f"[{x:.4g} {y:.4g} {z:.4g}]"


def check_status(manifold: Manifold, operation: str) -> None:
    """Raise SceneError("solid") if Manifold could not carry out an operation."""
    import manifold3d

    status = manifold.status()
    if status != manifold3d.Error.NoError:
        raise SceneError("solid", f"`{operation}` cannot be computed: {_REASONS.get(status.name, _OTHER_REASON)}")


# What the words of Manifold mean.
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
    def run(parameters: Parameters, operands: Sequence[Manifold]) -> Manifold:
        import manifold3d

        kind = getattr(manifold3d.OpType, name)
        return operands[0] if len(operands) == 1 else manifold3d.Manifold.batch_boolean(list(operands), kind)

    return run


def _hull(parameters: Parameters, operands: Sequence[Manifold]) -> Manifold:
    import manifold3d

    return manifold3d.Manifold.batch_hull(list(operands))


def _minkowski(parameters: Parameters, operands: Sequence[Manifold]) -> Manifold:
    base, tool = operands
    if tool.volume() < (1.0 - _CONVEX) * tool.hull().volume():
        raise SceneError(
            "solid", "the tool of `minkowski` is not convex", "take its `hull`, or join sums of convex tools"
        )
    _check_pairs("minkowski", base, tool)
    return base.minkowski_sum(tool)


def _check_pairs(name: str, base: Manifold, tool: Manifold) -> None:
    pairs = base.num_tri() * tool.num_tri()
    if pairs > MAX_PAIRS:
        message = f"`{name}` of {base.num_tri():,} and {tool.num_tri():,} triangles has {pairs:,} pairs of faces"
        raise LimitError("size", f"{message}, more than {MAX_PAIRS:,}", hint="use fewer :segments in both operands")


def _ball(parameters: Parameters, radius: float) -> Manifold:
    import manifold3d

    return manifold3d.Manifold.sphere(radius, int(parameters["segments"]))


def _rounded(parameters: Parameters, operands: Sequence[Manifold]) -> Manifold:
    """Morphological opening: what a ball inside of the solid can reach."""
    base, ball = operands[0], _ball(parameters, parameters["radius"])
    _check_pairs("rounded", base, ball)
    inner = base.minkowski_difference(ball)
    if inner.is_empty():
        raise SceneError("solid", f"`rounded` leaves nothing: no ball of radius {parameters['radius']:g} fits inside")
    return inner.minkowski_sum(ball)


def _shell(parameters: Parameters, operands: Sequence[Manifold]) -> Manifold:
    base, ball = operands[0], _ball(parameters, parameters["thickness"])
    _check_pairs("shell", base, ball)
    return base - base.minkowski_difference(ball)


def _offset(parameters: Parameters, operands: Sequence[Manifold]) -> Manifold:
    base, distance = operands[0], parameters["distance"]
    ball = _ball(parameters, abs(distance))
    _check_pairs("offset-solid", base, ball)
    return base.minkowski_sum(ball) if distance > 0.0 else base.minkowski_difference(ball)


def _cut(parameters: Parameters, operands: Sequence[Manifold]) -> Manifold:
    normal = np.asarray(parameters["normal"], np.float64)
    length = float(np.linalg.norm(normal))
    return operands[0].trim_by_plane((normal / length).tolist(), float(parameters["offset"]) / length)


def _mesh(parameters: Parameters, operands: Sequence[Manifold]) -> Manifold:
    return manifold_of_mesh(Mesh(parameters["vertices"], None, parameters["faces"].astype(np.int64)), "mesh")


def _extrude(parameters: Parameters, operands: Sequence[Manifold]) -> Manifold:
    height, twist = float(parameters["height"]), float(parameters["twist"])
    taper = tuple(float(factor) for factor in parameters["taper"])
    if twist:
        layers = int(parameters["slices"]) + 1
        filled = normalized(parameters["profile"], _fill_rule(parameters))
        check_corners("extrude", layers + 1, sum(map(len, filled)), FEWER_SLICES)
        parts = untouching(filled)
        surfaces = [twisted(part, height, math.radians(twist), parameters["taper"], layers) for part in parts]
        made = _united([manifold_of_mesh(Mesh(vertices, None, faces), "extrude") for vertices, faces in surfaces])
    else:
        rule, slices = _fill_rule(parameters), int(parameters["slices"])
        made = _straight(parameters["profile"], rule, height, slices, (taper[0], taper[1]))
    return made.translate((0.0, 0.0, -height / 2.0)) if parameters["center"] else made


def _fill_rule(parameters: Parameters) -> str:
    rule = parameters.get("fill", NON_ZERO)
    if rule not in (NON_ZERO, EVEN_ODD):  # of a file
        raise SceneError("solid", f"a profile cannot be filled by the rule {str(rule)[:40]!r}")
    return str(rule)


def _straight(
    contours: Sequence[FloatArray], rule: str, height: float, slices: int, taper: tuple[float, float]
) -> Manifold:
    """Return an extrusion without a twist; parts that lie apart are made each by itself, as Manifold is quadratic."""
    import manifold3d

    groups = apart(contours) if len(contours) > _MANY_CONTOURS else [contours]
    made = [section_of(group, rule).extrude(height, slices, 0.0, taper) for group in groups]
    if len(made) == 1:
        return made[0]
    meshes = [each.to_mesh64() for each in made]
    vertices = [np.array(each.vert_properties[:, :3], np.float64) for each in meshes]
    starts = np.cumsum([0, *map(len, vertices[:-1])])
    faces = [np.array(each.tri_verts, np.uint64) + start for each, start in zip(meshes, starts.tolist(), strict=True)]
    return manifold3d.Manifold(manifold3d.Mesh64(np.concatenate(vertices), np.concatenate(faces)))


def _lathe(parameters: Parameters, operands: Sequence[Manifold]) -> Manifold:
    section = section_of(parameters["profile"], _fill_rule(parameters))
    if not section.is_empty() and section.bounds()[2] <= 0.0:
        hint = "profiles turn around the y axis, where x is the distance from it"
        raise SceneError("solid", "the profile of `lathe` is on the left of the axis: no x is above 0", hint)
    sides, angle = int(parameters["segments"]), float(parameters["angle"])
    if sides < 3:  # Manifold would choose the number itself
        return _few_sided(section, sides, math.radians(angle))
    made = section.revolve(sides, angle)
    turn = np.array([[1.0, 0, 0, 0], [0, 0, 1.0, 0], [0, -1.0, 0, 0]])  # Manifold revolves around z
    return made.transform(turn)


def _few_sided(section: CrossSection, sides: int, angle: float) -> Manifold:
    """Return the part of a turn that one or two flat sides make."""
    import manifold3d

    low, high = section.bounds()[1::2]
    right = manifold3d.CrossSection.square((section.bounds()[2], high - low)).translate((0.0, low))
    mesh = (section ^ right).extrude(1.0, sides - 1).to_mesh64()
    x, y, share = np.array(mesh.vert_properties[:, :3], np.float64).T
    vertices = np.stack([x * np.cos(angle * share), y, -x * np.sin(angle * share)], axis=1)
    return manifold_of_mesh(Mesh(vertices, None, np.asarray(mesh.tri_verts, np.int64)), "lathe")


def _sweep(parameters: Parameters, operands: Sequence[Manifold]) -> Manifold:
    import manifold3d

    twist, rule = float(parameters["twist"]), _fill_rule(parameters)
    filled, pieces = normalized(parameters["profile"], rule), []
    check_corners("sweep", len(parameters["path"]), sum(map(len, filled)))
    for part in untouching(filled):
        made = swept(part, parameters["path"], twist, parameters["taper"])
        pieces += [manifold_of_mesh(Mesh(vertices, None, faces), "sweep") for vertices, faces in made.surfaces]
        pieces += [manifold3d.Manifold.hull_points(corners) for corners in made.hulls]
    return _united(pieces)


def _united(pieces: list[Manifold]) -> Manifold:
    import manifold3d

    return pieces[0] if len(pieces) == 1 else manifold3d.Manifold.batch_boolean(pieces, manifold3d.OpType.Add)


def _loft(parameters: Parameters, operands: Sequence[Manifold]) -> Manifold:
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
    "union-solid": _boolean("Add"),
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


def _surface(made: _Made, seconds: float) -> ComputedSolid:
    manifold = made.manifold
    hull = np.array(manifold.hull().to_mesh64().vert_properties[:, :3], np.float64)
    mesh = manifold.to_mesh64()
    sources = tuple(dict.fromkeys(made.sources[number] for number in mesh.run_original_id))
    source = _face_sources(mesh, [sources.index(made.sources[number]) for number in mesh.run_original_id])
    colors = np.array([each.color for each in sources], np.float64)[source]
    words = tuple(dict.fromkeys(each.word for each in sources))
    part = np.array([words.index(each.word) for each in sources], np.int64)[source] if len(words) > 1 else None
    vertices, joined = np.array(mesh.vert_properties[:, :3], np.float64), np.arange(len(mesh.vert_properties))
    joined[np.asarray(mesh.merge_from_vert, np.int64)] = np.asarray(mesh.merge_to_vert, np.int64)
    joints = joined[np.asarray(mesh.tri_verts, np.int64)]
    runs = _face_sources(mesh, range(len(mesh.run_original_id)))
    normals, faces, place = smoothed(vertices, joints, runs, _SHARP)
    surface = Mesh(vertices[place], normals, faces, colors, part, words, joints)
    return ComputedSolid(surface, hull, manifold.volume(), manifold.surface_area(), seconds)


def _face_sources(mesh: Mesh64, numbers: Sequence[int]) -> IntArray:
    """Return the number (F,) of each face's run; runs are given by their first corners."""
    edges = np.asarray(mesh.run_index, np.int64) // 3
    return np.repeat(np.asarray(numbers, np.int64), np.diff(edges))
