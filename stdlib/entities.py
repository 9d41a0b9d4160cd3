"""Entities, embeddings and poses (paper, appendix A; docs/language.md, chapter "Entities and embeddings")."""

from __future__ import annotations

from collections.abc import Callable
from math import isfinite
from typing import TYPE_CHECKING, Any

from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.runtime import parts
from scenelang.interpreter.runtime.procedures import Closure, items_of
from scenelang.interpreter.runtime.show import described, show
from scenelang.interpreter.runtime.types import Mismatch, Registry, numbers_of, type_name, vector_of
from scenelang.interpreter.scene import pose
from scenelang.interpreter.scene.bounds import UNIT_BOX, parts_box
from scenelang.interpreter.scene.entity import Entity, Frames, contains_blocks
from scenelang.interpreter.values.values import NIL, Embedding, Keyword, Matrix, Pair, Procedure, Vector, make_list

if TYPE_CHECKING:
    from scenelang.interpreter.runtime.runtime import Runtime

# Poses: the matrices of the paper's table (docs/language.md, chapter "Geometry"): right-handed, +y up, in radians.


poses = Registry("poses")
_ORIGIN = (0.0, 0.0, 0.0)


def _point(name: str, role: str, value: Vector) -> Vector:
    """Return an argument that is a vector of three numbers; ``role`` names it in the error message."""
    if len(value) != 3:
        raise SceneError("value", f"`{name}` expects three numbers for {role}, got {len(value)}: {show(value, 60)}")
    return value


def _finite(name: str, make: Callable[..., Matrix], *arguments: Any) -> Matrix:
    """Return the pose that ``make`` computes; raise SceneError if it is impossible or not finite."""
    try:
        matrix = make(*arguments)
    except ValueError as error:
        if not any(isinstance(each, float) and not isfinite(each) for each in arguments):
            raise SceneError("value", f"`{name}`: {error}") from None
    else:
        if pose.is_finite(matrix):
            return matrix
    raise SceneError("pose", f"the matrix of `{name}` is not finite: an argument is nan, inf or too large")


@poses.define(
    "translate", "offset::Vector", "Matrix", "Return the pose that translates by `offset`, [x y z] in scene units.",
    ("(@ (translate [1 2 3]) [0 0 0])", "[1.0 2.0 3.0]"),
)  # fmt: skip
def translate(rt: Runtime, offset: Vector) -> Matrix:
    if len(offset) == 3:
        exact = pose.exact_translation(*offset)
        if exact is not None:
            return exact
    x, y, z = _point("translate", "`offset`", offset)
    return _finite("translate", pose.translation, x, y, z)


@poses.define(
    "rotate", "angle::Float axis::Vector [point::Vector]", "Matrix",
    "Return the right-handed rotation by `angle` radians about `axis` through `point` (by default the origin).",
    ("(round (@ (rotate (/ pi 2) [0 1 0]) [1 0 0]) 6)", "[0.0 0.0 -1.0]"),
)  # fmt: skip
def rotate(rt: Runtime, angle: Any, axis: Vector, point: Any = _ORIGIN) -> Matrix:
    _point("rotate", "`axis`", axis)
    if point is not _ORIGIN:
        _point("rotate", "`point`", point)
    return _finite("rotate", pose.rotation, angle, axis, point)


@poses.define(
    "scale", "factors [origin::Vector]", "Matrix",
    "Return the pose that scales about `origin` by one factor, or by three factors along x, y and z.",
    ("(@ (scale [2 1 1]) [1 1 1])", "[2.0 1.0 1.0]"),
)  # fmt: skip
def scale(rt: Runtime, factors: Any, origin: Any = _ORIGIN) -> Matrix:
    if origin is not _ORIGIN:
        _point("scale", "`origin`", origin)
    if type(factors) in (int, float):  # one factor for all axes
        if origin is _ORIGIN and -pose.EXACT < factors < pose.EXACT:
            factor = float(factors)
            return Matrix((factor, 0.0, 0.0, 0.0, 0.0, factor, 0.0, 0.0, 0.0, 0.0, factor, 0.0))
        return _finite("scale", pose.scaling, factors, factors, factors, origin)
    numbers = numbers_of(factors, rt)
    if numbers is None:
        message = f"`scale` expects one or three numbers, got {described(factors, 60)}"
        raise SceneError("type", message, "write `(scale factor)` or `(scale [x y z])`")
    try:
        x, y, z = _point("scale", "`factors`", vector_of(numbers))
    except Mismatch:
        raise SceneError("pose", "a factor of `scale` is too large") from None
    return _finite("scale", pose.scaling, x, y, z, origin)


@poses.define(
    "reflect", "first::Vector [normal::Vector]", "Matrix",
    "Return the reflection in the plane through a point with a normal, `(reflect point normal)`; `(reflect normal)` "
    "through the origin.",
    ("(@ (reflect [1 0 0]) [1 2 3])", "[-1.0 2.0 3.0]"),
)  # fmt: skip
def reflect(rt: Runtime, first: Vector, normal: Vector | None = None) -> Matrix:
    point: Any = first
    if normal is None:
        point, normal = _ORIGIN, first
    _point("reflect", "the normal", normal)
    if point is not _ORIGIN:
        _point("reflect", "the point", point)
    mirror = normal
    return _finite("reflect", pose.reflection, point, mirror)


@poses.define(
    "look-at", "eye::Vector target::Vector [up::Vector]", "Matrix",
    "Return the pose that moves the origin to `eye` and turns +z towards `target`, with +y as close as possible to "
    "`up`, by default [0 1 0]. Objects whose front is +z look at the target.",
    ("(@ (look-at [0 0 0] [5 0 0]) [0 1 2])", "[2.0 1.0 0.0]"),
)  # fmt: skip
def look_at(rt: Runtime, eye: Vector, target: Vector, up: Any = (0.0, 1.0, 0.0)) -> Matrix:
    for role, value in (("`eye`", eye), ("`target`", target), ("`up`", up)):
        _point("look-at", role, value)
    return _finite("look-at", pose.facing, eye, target, up)


@poses.define(
    "pose", "matrix", "Matrix", "Convert a finite 4x4 array, mutable array or nested list to a pose.",
    ("(pose [[1 0 0 5] [0 1 0 0] [0 0 1 0] [0 0 0 1]])",
     "[[1.0 0.0 0.0 5.0] [0.0 1.0 0.0 0.0] [0.0 0.0 1.0 0.0] [0.0 0.0 0.0 1.0]]"),
)  # fmt: skip
def to_pose(rt: Runtime, matrix: Any) -> Matrix:
    return parts.pose_from(rt, matrix)


registry = Registry("entities")
define = registry.define


@define(
    "retrieve",
    "word::Word",
    "Function",
    "Return the function bound to `word`, or `(lambda _ (list))` if it is unbound.",
)
def retrieve(rt: Runtime, word: str) -> Any:
    function = rt.word_cell(word).function
    if type(function) is Closure:
        function.code.exposure.is_exposed = True
    return function if function is not None else rt.library.builtins["no-entities"]


@define(
    "no-entities",
    "arguments ...",
    "List",
    "The entity function of an unbound word: return no sub-entities.",
    ("(no-entities 1)", "()"),
)
def no_entities(rt: Runtime, *arguments: Any) -> Any:
    return NIL


@define(
    "bound?",
    "word::Word",
    "Boolean",
    "Return whether an entity function is bound to `word`.",
    ('(bound? "unknown")', "#f"),
)
def is_bound(rt: Runtime, word: str) -> bool:
    return rt.word_cell(word).function is not None


@define(
    "call-embeddings",
    "word::Word arguments::List",
    "List[Embedding]",
    "Return the embeddings among the arguments of a `call`; `:name value` pairs are added to the first, a new one if "
    "none is given.",
    ('(call-embeddings "tree" (list :height 3))', "((embedding :height 3))"),
)
def call_embeddings(rt: Runtime, word: str, arguments: Any) -> Any:
    values = items_of(rt, arguments)
    rt.charge(len(values) >> 2)
    z, rest, written = parts.call_embeddings(rt, word, values)
    rt.check_written(word, written)
    return Pair(z, make_list(rest))


@define(
    "apply-entity-function",
    "function::Function z::Embedding rest::List",
    "Any",
    "Apply an entity function to its embedding and the list of its descendants' embeddings; shared like a `call`.",
    ("(apply-entity-function (lambda (z gamma) (length gamma)) <z1> (list <z2>))", "1"),
)
def apply_entity_function(rt: Runtime, function: Procedure, z: Embedding, rest: Any) -> Any:
    return rt.apply_memoized(function, z, rest)


@define(
    "make-entity",
    "word::Word embedding::Embedding parts::Parts",
    "Entity",
    "Return an entity with these parts as its children.",
)
def make_entity(rt: Runtime, word: str, embedding: Embedding, children: Any) -> Entity:
    return rt.make_entity(word, embedding, parts.parts_of(rt, children, word))


@define(
    "primitive",
    "word::Word arguments ...",
    "Entity",
    'Return a primitive even if `word` is bound, so that a program can bind its own "cube" and still use the built-in '
    "one.",
    ('(primitive "cube" :color [1 0 0])', '<entity "cube">'),
)
def primitive(rt: Runtime, word: str, *arguments: Any) -> Entity:
    z, _, _ = parts.call_embeddings(rt, word, list(arguments))
    return rt.primitive(word, z)


@define(
    "parts",
    "x",
    "List[Tuple[Entity, Matrix]]",
    "Return the flat list of the parts of an entity, a pair (entity . matrix), or a list of these nested to any depth.",
    ('(length (parts (list (call "cube") (list (call "cone")))))', "2"),
)
def parts_list(rt: Runtime, x: Any) -> Any:
    return make_list(parts.parts_of(rt, x))


@define(
    "primitives",
    "x",
    "List[Tuple[Entity, Matrix]]",
    "Return the primitives of an entity, pair or parts in depth-first order, each with its pose; `parts` descends one "
    "level only.",
    ('(length (primitives (union (call "cube") (call "cone"))))', "2"),
)
def primitive_list(rt: Runtime, x: Any) -> Any:
    return make_list(parts.primitives_of(rt, x))


@define(
    "map-parts",
    "function::Function x",
    "Any",
    "Return `(function x)` for a pair (entity . matrix); otherwise the list of the results of the function for each "
    "part.",
    ('(length (map-parts (lambda (p) p) (list (call "cube"))))', "1"),
)
def map_parts(rt: Runtime, function: Procedure, x: Any) -> Any:
    if type(x) is Pair and type(x.car) is Entity and type(x.cdr) is not Pair and x.cdr is not NIL:
        (part,) = parts.parts_of(rt, x)
        return rt.call1(function, part)
    return make_list([rt.call1(function, part) for part in parts.parts_of(rt, x)])


@define(
    "frames",
    "list::Sequence",
    "Frames",
    "Return a 4D scene whose frames are the items of the list, entities or parts. Allowed only as the value of the "
    "root.",
)
def frames(rt: Runtime, sequence: Any) -> Frames:
    members = items_of(rt, sequence)
    rt.charge(len(members) >> 2)
    if not members:
        raise SceneError("frames", "`frames` expects at least one frame, got an empty list")
    return Frames(tuple(parts.parts_of(rt, member, "frames") for member in members))


@define(
    "embedding",
    "parts ...",
    "Embedding",
    "Return an embedding made of a handle, a text and `:name value` attributes, each optional.",
    ('(embedding "ivory" :scale 2)', '(embedding "ivory" :scale 2)'),
)
def embedding(rt: Runtime, *arguments: Any) -> Embedding:
    handle: str | None = None
    text: str | None = None
    attributes: dict[str, Any] = {}
    pending = iter(arguments)
    for argument in pending:
        if type(argument) is Keyword:
            try:
                attributes[str(argument)] = next(pending)
            except StopIteration:
                raise SceneError("keyword", f"`:{argument}` has no value") from None
        elif type(argument) is str:
            text = argument
        elif type(argument) is Embedding:
            handle, text = argument.handle or handle, argument.text or text
            rt.charge((len(argument.attributes) + len(attributes)) >> 4)
            attributes = {**argument.attributes, **attributes}  # those written here override an embedding's
        else:
            hint = "write attributes as `(embedding :name value)`"
            message = f"`embedding` expects a handle, a text or attributes, got {type_name(argument)}"
            raise SceneError("type", message, hint)
    return parts.with_attributes(rt, Embedding(handle, text), attributes)


@define(
    "embedding-text", "z::Embedding", "Any", "Return the text of an embedding, or `none`.",
    ('(embedding-text (embedding "ivory"))', '"ivory"'),
)  # fmt: skip
def embedding_text(rt: Runtime, z: Embedding) -> Any:
    return z.text


@define(
    "embedding-handle", "z::Embedding", "Any", "Return the name of the handle of an embedding, or `none`.",
    ("(embedding-handle <z3>)", '"z3"'),
)  # fmt: skip
def embedding_handle(rt: Runtime, z: Embedding) -> Any:
    return z.handle


@define(
    "embedding-attributes", "z::Embedding", "Table", "Return the table of the attributes of an embedding, by name.",
    ("(embedding-attributes (embedding :scale 2))", '(table "scale" 2)'),
)  # fmt: skip
def embedding_attributes(rt: Runtime, z: Embedding) -> Any:
    return parts.attribute_table(rt, z.attributes)


@define(
    "entity-word", "entity::Entity", "Word", "Return the word of an entity.", ('(entity-word (call "cube"))', '"cube"')
)
def entity_word(rt: Runtime, entity: Entity) -> str:
    return entity.word


@define(
    "entity-embedding", "entity::Entity", "Embedding", "Return the embedding of an entity.",
    ('(entity-embedding (call "cube" :scale 2))', "(embedding :scale 2)"),
)  # fmt: skip
def entity_embedding(rt: Runtime, entity: Entity) -> Embedding:
    return entity.embedding


@define(
    "entity-children", "entity::Entity", "List[Tuple[Entity, Matrix]]", "Return the parts of an entity.",
    ('(entity-children (call "cube"))', "()"),
)  # fmt: skip
def entity_children(rt: Runtime, entity: Entity) -> Any:
    rt.charge(len(entity.children) >> 4)
    return make_list(entity.children)


@define(
    "primitive?", "x", "Boolean", "Return whether `x` is a primitive entity, one made without an entity function.",
    ('(primitive? (call "cube"))', "#t"),
)  # fmt: skip
def is_primitive(rt: Runtime, x: Any) -> bool:
    return type(x) is Entity and x.is_primitive


@define(
    "blocks?", "x::Parts", "Boolean",
    "Return whether the parts contain Minecraft blocks. Combinators place objects of blocks at whole cells.",
    ('(blocks? (call "set-cuboid" :block-type "stone"))', "#t"),
)  # fmt: skip
def has_blocks(rt: Runtime, x: Any) -> bool:
    members = parts.parts_of(rt, x)
    rt.charge(len(members))
    return any(contains_blocks(part.car, rt.charge) for part in members)


def box_of(rt: Runtime, x: Any) -> tuple[float, ...]:
    """Return the exact box of ``x`` for a measurement; the unit box, with a warning, if it has no geometry."""
    box = parts_box(parts.parts_of(rt, x), rt.charge)
    if box is None:
        rt.warn("empty-box", "the bounding box of nothing is [-.5, .5] on each axis")
        return UNIT_BOX
    return box


@define(
    "compute-shape-min", "x::Parts", "Vector",
    "Return the minimum corner of the bounding box of an entity or parts, [x y z] in scene units.",
    ('(compute-shape-min (call "cube" :scale [1 2 1]))', "[-0.5 -1.0 -0.5]"),
)  # fmt: skip
def shape_min(rt: Runtime, x: Any) -> Vector:
    return Vector(box_of(rt, x)[:3])


@define(
    "compute-shape-max", "x::Parts", "Vector",
    "Return the maximum corner of the bounding box of an entity or parts, [x y z] in scene units.",
    ('(compute-shape-max (call "cylinder"))', "[1.0 1.0 1.0]"),
)  # fmt: skip
def shape_max(rt: Runtime, x: Any) -> Vector:
    return Vector(box_of(rt, x)[3:])


@define(
    "compute-shape-center", "x::Parts", "Vector",
    "Return the center of the bounding box of an entity or parts, [x y z] in scene units.",
    ('(compute-shape-center (call "cylinder"))', "[0.0 0.5 0.0]"),
)  # fmt: skip
def shape_center(rt: Runtime, x: Any) -> Vector:
    box = box_of(rt, x)
    return Vector([(box[i] + box[i + 3]) / 2 for i in range(3)])


@define(
    "compute-shape-sizes", "x::Parts", "Vector",
    "Return the sizes of the bounding box of an entity or parts in x, y and z, in scene units.",
    ('(compute-shape-sizes (call "sphere"))', "[2.0 2.0 2.0]"),
)  # fmt: skip
def shape_sizes(rt: Runtime, x: Any) -> Vector:
    box = box_of(rt, x)
    return Vector([box[i + 3] - box[i] for i in range(3)])
