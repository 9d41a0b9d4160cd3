"""Types of the results of library functions and methods: builtins, the helper API, math, numpy and random."""

from __future__ import annotations

import ast
from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import TypeAlias, TypeVar

from scenelang.interpreter.runtime.modelling_helpers import ASSERT_THAT, ModellingHelper, scene_helpers
from scenelang.interpreter.transpile.analysis.inference import (
    ANYTHING,
    ARRAY,
    BOOL,
    CHANGES,
    CONTAINERS,
    DICT,
    DRAWS,
    INT,
    LIST,
    NONE,
    NOTHING,
    NUMBERS,
    POSE,
    RECORD,
    SEQUENCES,
    SET,
    SHAPE,
    STREAM,
    T_BOOL,
    T_FLOAT,
    T_INT,
    T_NONE,
    T_NUMBER,
    T_POSE,
    T_SHAPE,
    T_STR,
    T_STREAM,
    TUPLE,
    AbstractType,
    InferenceState,
    join_all,
)

Result: TypeAlias = "Callable[[InferenceState, ast.AST, list[AbstractType], dict[str, AbstractType]], AbstractType]"
Method: TypeAlias = (
    "Callable[[InferenceState, ast.Call, AbstractType, list[AbstractType], dict[str, AbstractType]], AbstractType]"
)

T = TypeVar("T")

MUTATORS = frozenset({"random.shuffle", "numpy.random.shuffle", "heapq.heappush", "heapq.heappop"})


def uses_random_stream(path: str) -> bool:
    """Return whether calling the function at ``path`` uses or seeds a random stream."""
    if path in ("random.Random", "numpy.random.RandomState", "numpy.random.default_rng"):
        return False
    return path.startswith(("random.", "numpy.random."))


def _list_of(element: Callable[[InferenceState, list[AbstractType]], AbstractType]) -> Result:
    return lambda infer, node, args, named: infer.container(node, LIST, element(infer, args))


def _array(infer: InferenceState, node: ast.AST, element: AbstractType = T_FLOAT) -> AbstractType:
    return infer.container(node, ARRAY, element)


def _vector(
    infer: InferenceState, node: ast.AST, args: list[AbstractType], named: dict[str, AbstractType]
) -> AbstractType:
    return _array(infer, node)


def _elementwise(
    infer: InferenceState, node: ast.AST, args: list[AbstractType], named: dict[str, AbstractType]
) -> AbstractType:
    """Return the type of an elementwise function such as ``np.sin``: a number of a number, else an array."""
    joined = join_all(args)
    if joined.kinds & (ARRAY | LIST | TUPLE | POSE):
        element = join_all([infer.elements(a) for a in args if a.kinds & (ARRAY | LIST | TUPLE)])
        nested = element.kinds & (ARRAY | LIST | TUPLE)
        return _array(infer, node, infer.container(node, ARRAY, T_FLOAT, tag="row") if nested else T_FLOAT)
    return T_FLOAT


def _make_array(
    infer: InferenceState, node: ast.AST, args: list[AbstractType], named: dict[str, AbstractType]
) -> AbstractType:
    """Return the type of ``np.array(x)``, with as many dimensions as the nesting of ``x``."""
    if not args:
        return _array(infer, node)
    if args[0].only(NUMBERS):
        return args[0]
    element = infer.elements(args[0])
    if element.kinds & (LIST | TUPLE | ARRAY):
        inner = infer.elements(element)
        return infer.grow(infer.site(node, ARRAY), infer.container(node, ARRAY, inner or T_FLOAT, tag="row"))
    return _array(infer, node, element if element.kinds else T_FLOAT)


def _has_booleans(node: ast.AST) -> bool:
    """Return whether a call asks for an array of Booleans, which contains 1 and 0."""
    named = [each.value for each in node.keywords if each.arg == "dtype"] if isinstance(node, ast.Call) else []
    return any(ast.unparse(each) in ("bool", "np.bool_") for each in named)


def _shaped(
    infer: InferenceState, node: ast.AST, args: list[AbstractType], named: dict[str, AbstractType]
) -> AbstractType:
    """Return the type of an array with the shape that is passed as the first argument, as in ``np.zeros(shape)``."""
    shape = args[0] if args else named.get("shape", T_INT)
    is_matrix = bool(shape.kinds & (LIST | TUPLE)) and any(
        site.items is None or len(site.items) > 1 for site in infer.read_sites(shape)
    )
    if _has_booleans(node):
        row = infer.container(node, ARRAY, T_INT, T_BOOL, tag="row")
        return infer.container(node, ARRAY, row if is_matrix else T_INT, T_BOOL)
    if is_matrix:
        return infer.grow(infer.site(node, ARRAY), infer.container(node, ARRAY, T_FLOAT, tag="row"))
    return _array(infer, node)


def _random_result(number: AbstractType, position: int = 2) -> Result:
    """Return the transfer function of a random function.

    With a size, the argument at ``position``, it returns an array.
    """

    def result(
        infer: InferenceState, node: ast.AST, args: list[AbstractType], named: dict[str, AbstractType]
    ) -> AbstractType:
        size = args[position] if len(args) > position else named.get("size")
        if size is not None and not size.only(NONE):
            return _shaped(infer, node, [size], {})
        return number

    return result


def _random_by_dimensions(
    infer: InferenceState, node: ast.AST, args: list[AbstractType], named: dict[str, AbstractType]
) -> AbstractType:
    if len(args) > 1:
        return _array(infer, node, infer.container(node, ARRAY, T_FLOAT, tag="row"))
    return _array(infer, node) if args else T_FLOAT


def _random_by_size(
    infer: InferenceState, node: ast.AST, args: list[AbstractType], named: dict[str, AbstractType]
) -> AbstractType:
    size = args[0] if args else named.get("size")
    return _shaped(infer, node, [size], {}) if size is not None and not size.only(NONE) else T_FLOAT


def _np_choice(
    infer: InferenceState, node: ast.AST, args: list[AbstractType], named: dict[str, AbstractType]
) -> AbstractType:
    source = args[0] if args else NOTHING
    item = T_INT if source.only(INT) else infer.elements(source)
    if len(args) > 1 or "size" in named:
        return _array(infer, node, item) if item.only(NUMBERS) else infer.container(node, LIST, item)
    return item


def _item(
    infer: InferenceState, node: ast.AST, args: list[AbstractType], named: dict[str, AbstractType]
) -> AbstractType:
    return infer.elements(args[0]) if args else NOTHING


def _first(
    infer: InferenceState, node: ast.AST, args: list[AbstractType], named: dict[str, AbstractType]
) -> AbstractType:
    return args[0] if args else NOTHING


def _permutation(
    infer: InferenceState, node: ast.AST, args: list[AbstractType], named: dict[str, AbstractType]
) -> AbstractType:
    if args and args[0].only(INT):
        return _array(infer, node, T_INT)
    element = infer.elements(args[0]) if args else NOTHING
    return _array(infer, node, element) if element.only(NUMBERS) else infer.container(node, LIST, element)


def _library(
    infer: InferenceState, node: ast.AST, args: list[AbstractType], named: dict[str, AbstractType]
) -> AbstractType:
    return T_SHAPE


def _loop(
    infer: InferenceState, node: ast.AST, args: list[AbstractType], named: dict[str, AbstractType]
) -> AbstractType:
    functions = args[1] if len(args) > 1 else named.get("fn", named.get("func", NOTHING))
    infer.call(functions, node, [T_INT], {})
    return T_SHAPE


def _enumerate(
    infer: InferenceState, node: ast.AST, args: list[AbstractType], named: dict[str, AbstractType]
) -> AbstractType:
    pair = infer.tuple_of(node, [T_INT, infer.elements(args[0]) if args else NOTHING], tag="pair")
    return infer.container(node, LIST, pair)


def _zip(
    infer: InferenceState, node: ast.AST, args: list[AbstractType], named: dict[str, AbstractType]
) -> AbstractType:
    starred = isinstance(node, ast.Call) and any(isinstance(a, ast.Starred) for a in node.args)
    if starred:
        return infer.container(
            node, LIST, infer.container(node, TUPLE, join_all([infer.elements(a) for a in args]), tag="row")
        )
    row = infer.tuple_of(node, [infer.elements(a) for a in args], tag="row")
    return infer.container(node, LIST, row)


def _map(
    infer: InferenceState, node: ast.AST, args: list[AbstractType], named: dict[str, AbstractType]
) -> AbstractType:
    if not args:
        return NOTHING
    return infer.container(node, LIST, infer.call(args[0], node, [infer.elements(a) for a in args[1:]], {}))


def _filter(
    infer: InferenceState, node: ast.AST, args: list[AbstractType], named: dict[str, AbstractType]
) -> AbstractType:
    if len(args) < 2:
        return NOTHING
    element = infer.elements(args[1])
    infer.call(args[0], node, [element], {})
    return infer.container(node, LIST, element)


def _sorted(
    infer: InferenceState, node: ast.AST, args: list[AbstractType], named: dict[str, AbstractType]
) -> AbstractType:
    element = infer.elements(args[0]) if args else NOTHING
    if "key" in named:
        infer.call(named["key"], node, [element], {})
    return infer.container(node, LIST, element)


def _extreme(
    infer: InferenceState, node: ast.AST, args: list[AbstractType], named: dict[str, AbstractType]
) -> AbstractType:
    items = infer.elements(args[0]) if len(args) == 1 else join_all(args)
    if "key" in named:
        infer.call(named["key"], node, [items], {})
    return items | named.get("default", NOTHING)


def _sum(
    infer: InferenceState, node: ast.AST, args: list[AbstractType], named: dict[str, AbstractType]
) -> AbstractType:
    element = infer.elements(args[0]) if args else NOTHING
    start = args[1] if len(args) > 1 else named.get("start", T_INT)
    if element.kinds & SHAPE:
        return T_SHAPE
    if start.kinds & (LIST | TUPLE):
        return infer.container(node, start.kinds & (LIST | TUPLE), infer.elements(element) | infer.elements(start))
    if element.only(BOOL):
        return T_INT
    return element | start if element.only(NUMBERS) else element


def _np_sum(
    infer: InferenceState, node: ast.AST, args: list[AbstractType], named: dict[str, AbstractType]
) -> AbstractType:
    if "axis" in named or len(args) > 1:
        return _array(infer, node)
    return T_FLOAT


def _sequence(kind: int) -> Result:
    def result(
        infer: InferenceState, node: ast.AST, args: list[AbstractType], named: dict[str, AbstractType]
    ) -> AbstractType:
        if not args:
            return infer.container(node, kind, NOTHING)
        sites = infer.read_sites(args[0])
        known = len(sites) == 1 and sites[0].items is not None and not args[0].kinds & ~SEQUENCES
        if known and sites[0].items is not None and kind & SEQUENCES:
            return infer.tuple_of(node, sites[0].items, kind=kind)
        return infer.container(node, kind, infer.elements(args[0]))

    return result


def _dict(
    infer: InferenceState, node: ast.AST, args: list[AbstractType], named: dict[str, AbstractType]
) -> AbstractType:
    key, value = (T_STR, join_all(list(named.values()))) if named else (NOTHING, NOTHING)
    fields: dict[object, AbstractType] = {name: inferred for name, inferred in named.items()}  # noqa: C416 (the keys widen)
    other = NOTHING
    for argument in args:
        for site in infer.read_sites(argument):
            if site.kind == DICT:
                key, value, other = key | site.key, value | site.element, other | site.other
                for name, inferred in site.fields.items():
                    fields[name] = fields.get(name, NOTHING) | inferred
            else:
                key = key | infer.item_at(site.element, 0)
                other = other | infer.item_at(site.element, 1)
                value = value | other
    return infer.table(infer.site(node, DICT), key, value, fields, other)


def _divmod(
    infer: InferenceState, node: ast.AST, args: list[AbstractType], named: dict[str, AbstractType]
) -> AbstractType:
    number = T_INT if all(a.only(INT) for a in args) else T_NUMBER
    return infer.tuple_of(node, [number, number])


def _round(
    infer: InferenceState, node: ast.AST, args: list[AbstractType], named: dict[str, AbstractType]
) -> AbstractType:
    return T_FLOAT if len(args) > 1 else T_INT


def _absolute(
    infer: InferenceState, node: ast.AST, args: list[AbstractType], named: dict[str, AbstractType]
) -> AbstractType:
    if args and args[0].kinds & RECORD:
        return NOTHING  # until the method is called that gives it
    return args[0] if args and not args[0].only(BOOL) else T_INT


def _reduce(
    infer: InferenceState, node: ast.AST, args: list[AbstractType], named: dict[str, AbstractType]
) -> AbstractType:
    if len(args) < 2:
        return NOTHING
    start = args[2] if len(args) > 2 else infer.elements(args[1])
    once = start | infer.call(args[0], node, [start, infer.elements(args[1])], {})
    return once | infer.call(args[0], node, [once, infer.elements(args[1])], {})


def _product(
    infer: InferenceState, node: ast.AST, args: list[AbstractType], named: dict[str, AbstractType]
) -> AbstractType:
    if "repeat" in named:
        return infer.container(node, LIST, infer.container(node, TUPLE, infer.elements(args[0]), tag="row"))
    return infer.container(node, LIST, infer.tuple_of(node, [infer.elements(a) for a in args], tag="row"))


def _combinations(
    infer: InferenceState, node: ast.AST, args: list[AbstractType], named: dict[str, AbstractType]
) -> AbstractType:
    element = infer.elements(args[0]) if args else NOTHING
    return infer.container(node, LIST, infer.container(node, TUPLE, element, tag="row"))


def _chain(
    infer: InferenceState, node: ast.AST, args: list[AbstractType], named: dict[str, AbstractType]
) -> AbstractType:
    return infer.container(node, LIST, join_all([infer.elements(a) for a in args]))


def _colors(
    infer: InferenceState, node: ast.AST, args: list[AbstractType], named: dict[str, AbstractType]
) -> AbstractType:
    return infer.tuple_of(node, [T_FLOAT, T_FLOAT, T_FLOAT])


def _stack(
    infer: InferenceState, node: ast.AST, args: list[AbstractType], named: dict[str, AbstractType]
) -> AbstractType:
    element = infer.elements(args[0]) if args else NOTHING
    return infer.grow(infer.site(node, ARRAY), infer.container(node, ARRAY, infer.elements(element), tag="row"))


def _concatenated(
    infer: InferenceState, node: ast.AST, args: list[AbstractType], named: dict[str, AbstractType]
) -> AbstractType:
    """Return the type of concatenated arrays, which has the same number of dimensions."""
    items = infer.elements(infer.elements(args[0])) if args else NOTHING
    return _array(infer, node, AbstractType(ARRAY) if items.only(ARRAY | SEQUENCES) else T_FLOAT)


def _concatenated_shapes(
    infer: InferenceState, node: ast.AST, args: list[AbstractType], named: dict[str, AbstractType]
) -> AbstractType:
    return T_POSE if args and all(value.only(POSE) for value in args) else T_SHAPE


def _defaultdict(
    infer: InferenceState, node: ast.AST, args: list[AbstractType], named: dict[str, AbstractType]
) -> AbstractType:
    default = infer.call(args[0], node, [], {}) if args else NOTHING
    return infer.table(infer.site(node, DICT, "table"), NOTHING, default, {}, default)  # the default has one of its own


def _meshgrid(
    infer: InferenceState, node: ast.AST, args: list[AbstractType], named: dict[str, AbstractType]
) -> AbstractType:
    grid = infer.grow(infer.site(node, ARRAY, "grid"), infer.container(node, ARRAY, T_FLOAT, tag="row"))
    return infer.container(node, LIST, grid)


def _dataclass_field(
    infer: InferenceState, node: ast.AST, args: list[AbstractType], named: dict[str, AbstractType]
) -> AbstractType:
    default = infer.call(named["default_factory"], node, [], {}) if "default_factory" in named else NOTHING
    return default | named.get("default", NOTHING)


def _matrix(
    infer: InferenceState, node: ast.AST, args: list[AbstractType], named: dict[str, AbstractType]
) -> AbstractType:
    return infer.grow(infer.site(node, ARRAY), infer.container(node, ARRAY, T_FLOAT, tag="row"))


def _dot(
    infer: InferenceState, node: ast.AST, args: list[AbstractType], named: dict[str, AbstractType]
) -> AbstractType:
    if any(a.kinds & POSE for a in args) or any(infer.elements(a).kinds & (ARRAY | LIST | TUPLE) for a in args):
        return AbstractType(ARRAY) if not all(a.kinds & POSE for a in args) else T_POSE
    return T_FLOAT


def _cloned(
    infer: InferenceState, node: ast.AST, args: list[AbstractType], named: dict[str, AbstractType]
) -> AbstractType:
    return _clone(infer, node, args[0], "copy") if args else NOTHING


def _shallow(
    infer: InferenceState, node: ast.AST, args: list[AbstractType], named: dict[str, AbstractType]
) -> AbstractType:
    result = NOTHING
    for site in infer.read_sites(args[0]) if args else ():
        copy = infer.site(node, site.kind, str(site.kind))
        if site.kind == DICT:
            infer.table(copy, site.key, site.element, site.fields, site.other)
        result = result | infer.grow(copy, site.element, site.key)
    return result if result.kinds else (args[0] if args else NOTHING)


def _clone(infer: InferenceState, node: ast.AST, value: AbstractType, tag: str) -> AbstractType:
    """Return the type of a deep copy, which has its own containers down to a limited depth."""
    if len(tag) > 12:  # limits the depth of recursive containers
        return value
    result = AbstractType(value.kinds & ~(CONTAINERS | ARRAY)) if value.kinds & ~(CONTAINERS | ARRAY) else NOTHING
    for site in infer.read_sites(value):
        element = _clone(infer, node, site.element, tag + "+")
        result = result | infer.container(node, site.kind, element, site.key, f"{tag}{site.kind}")
    return result


def _pose(
    infer: InferenceState, node: ast.AST, args: list[AbstractType], named: dict[str, AbstractType]
) -> AbstractType:
    return infer.container(node, POSE, AbstractType(ARRAY))


def _moved_shape(
    infer: InferenceState, node: ast.AST, args: list[AbstractType], named: dict[str, AbstractType]
) -> AbstractType:
    """Return a shape; nothing for an array, with which the call fails: a method may try it last."""
    shape = args[0] if args else named.get("shape", T_SHAPE)
    return T_SHAPE if shape.kinds & ~(ARRAY | NUMBERS) else NOTHING  # so far


def _plain_range(
    infer: InferenceState, node: ast.AST, args: list[AbstractType], named: dict[str, AbstractType]
) -> AbstractType:
    return infer.container(node, LIST, T_INT)


def _arange(
    infer: InferenceState, node: ast.AST, args: list[AbstractType], named: dict[str, AbstractType]
) -> AbstractType:
    return _array(infer, node, T_INT if all(a.only(INT) for a in args) else T_FLOAT)


def _for_names(module: str, names: str, result: T) -> dict[str, T]:
    """Return the same entry for several names of a module; an empty module is for methods."""
    return {f"{module}.{name}" if module else name: result for name in names.split()}


def _declaring(
    infer: InferenceState, node: ast.AST, args: list[AbstractType], named: dict[str, AbstractType]
) -> AbstractType:
    """Return the type of ``assert_that``, which states something of the object that is being made."""
    infer.effect(node, CHANGES)
    return T_NONE


def _rows(infer: InferenceState, node: ast.AST, tag: str) -> AbstractType:
    """Return the type of an array of points."""
    return infer.container(node, ARRAY, infer.container(node, ARRAY, T_FLOAT, tag=f"{tag}row"), tag=tag)


def _modelled(helper: ModellingHelper) -> Result:
    """Return the type of what a function for solids, profiles or paths returns; functions that it takes get numbers."""

    def result(
        infer: InferenceState, node: ast.AST, args: list[AbstractType], named: dict[str, AbstractType]
    ) -> AbstractType:
        for value in (*args, *named.values()):
            for function in value.functions:
                infer.call(value, node, [T_FLOAT] * len(function.parameters), {})
        if helper.draws:
            infer.effect(node, DRAWS)
        return _BUILTIN_RESULTS[helper.result](infer, node)

    return result


# Types of the results of builtins by their names in the registry; contours are a list of arrays of points.
_BUILTIN_RESULTS: Mapping[str, Callable[[InferenceState, ast.AST], AbstractType]] = MappingProxyType({
    "Entity": lambda infer, node: T_SHAPE,
    "Float": lambda infer, node: T_FLOAT,
    "Vector": _array,
    "Array": lambda infer, node: _rows(infer, node, ""),
    "List": lambda infer, node: infer.container(node, LIST, _rows(infer, node, "contour")),
    "List[Entity]": lambda infer, node: infer.container(node, LIST, T_SHAPE),
    "List[Matrix]": lambda infer, node: infer.container(
        node, LIST, infer.container(node, POSE, AbstractType(ARRAY), tag="pose")
    ),
    "Matrix": lambda infer, node: infer.container(node, POSE, AbstractType(ARRAY)),
    "Any": lambda infer, node: ANYTHING,
})  # fmt: skip

RESULTS: dict[str, AbstractType | Result] = {
    **{name: _modelled(helper) for name, helper in scene_helpers().items()}, ASSERT_THAT: _declaring,
    # the helper API
    "primitive_call": T_SHAPE, "concat_shapes": _concatenated_shapes, "transform_shape": _moved_shape, "loop": _loop,
    "library_call": T_SHAPE, "translation_matrix": _pose, "rotation_matrix": _pose, "scale_matrix": _pose,
    "reflection_matrix": _pose, "identity_matrix": _pose, "compute_shape_center": _vector,
    "compute_shape_min": _vector, "compute_shape_max": _vector, "compute_shape_sizes": _vector,
    # builtins
    "len": T_INT, "int": T_INT, "float": T_FLOAT, "str": T_STR, "repr": T_STR, "bool": T_BOOL, "chr": T_STR,
    "ord": T_INT,
    "any": T_BOOL, "all": T_BOOL, "isinstance": T_BOOL, "callable": T_BOOL, "print": T_NONE, "format": T_STR,
    "hasattr": T_BOOL, "range": _plain_range, "enumerate": _enumerate, "zip": _zip, "map": _map, "filter": _filter,
    "sorted": _sorted, "reversed": _sorted, "min": _extreme, "max": _extreme, "sum": _sum, "abs": _absolute,
    "round": _round, "divmod": _divmod, "pow": T_NUMBER, "list": _sequence(LIST), "tuple": _sequence(TUPLE),
    "set": _sequence(SET), "frozenset": _sequence(SET), "dict": _dict, "iter": _sequence(LIST), "next": _item,
    "bin": T_STR, "hex": T_STR,
    # math
    **_for_names("math", (
        "sin cos tan asin acos atan atan2 sinh cosh tanh sqrt exp log log2 log10 pow hypot radians "
        "degrees fmod fabs dist copysign pi e tau inf nan fsum cbrt asinh acosh atanh expm1 log1p"
    ), T_FLOAT),
    **_for_names("math", "floor ceil trunc factorial comb perm gcd lcm isqrt", T_INT),
    "math.isclose": T_BOOL, "math.isnan": T_BOOL, "math.isinf": T_BOOL, "math.isfinite": T_BOOL, "math.prod": _sum,
    # numpy
    **_for_names("numpy", (
        "sin cos tan arcsin arccos arctan arctan2 sinh cosh tanh sqrt exp log log2 log10 radians degrees "
        "deg2rad rad2deg abs absolute fabs floor ceil round rint sign square power mod clip maximum "
        "minimum add subtract multiply divide hypot where interp negative float_power trunc around "
        "remainder fmod float64 float32"
    ), _elementwise),
    "numpy.pi": T_FLOAT, "numpy.e": T_FLOAT, "numpy.inf": T_FLOAT, "numpy.nan": T_FLOAT, "numpy.int32": T_INT,
    "numpy.int64": T_INT, "numpy.array": _make_array, "numpy.asarray": _make_array, "numpy.zeros": _shaped,
    "numpy.ones": _shaped, "numpy.full": _shaped, "numpy.empty": _shaped, "numpy.zeros_like": _elementwise,
    "numpy.ones_like": _elementwise, "numpy.copy": _make_array, "numpy.float_": T_FLOAT,
    "numpy.full_like": _elementwise, "numpy.linspace": _vector, "numpy.arange": _arange, "numpy.logspace": _vector,
    "numpy.geomspace": _vector, "numpy.eye": _matrix, "numpy.identity": _matrix, "numpy.dot": _dot,
    "numpy.cross": _elementwise,
    "numpy.matmul": _matrix, "numpy.outer": _matrix, "numpy.inner": T_FLOAT, "numpy.vdot": T_FLOAT,
    "numpy.linalg.norm": _np_sum, "numpy.linalg.inv": _first, "numpy.linalg.det": T_FLOAT,
    "numpy.linalg.solve": _vector,
    "numpy.stack": _stack, "numpy.vstack": _stack, "numpy.hstack": _concatenated, "numpy.column_stack": _stack,
    "numpy.concatenate": _concatenated, "numpy.append": _vector, "numpy.sum": _np_sum, "numpy.mean": _np_sum,
    "numpy.max": _np_sum, "numpy.min": _np_sum, "numpy.amax": _np_sum, "numpy.amin": _np_sum, "numpy.prod": _np_sum,
    "numpy.average": _np_sum, "numpy.median": _np_sum, "numpy.std": _np_sum, "numpy.cumsum": _vector,
    "numpy.argmin": T_INT, "numpy.argmax": T_INT, "numpy.argsort": _vector, "numpy.sort": _first, "numpy.flip": _first,
    "numpy.roll": _first, "numpy.tile": _vector, "numpy.repeat": _vector, "numpy.transpose": _first,
    "numpy.reshape": _first,
    "numpy.diff": _vector, "numpy.isclose": T_BOOL, "numpy.allclose": T_BOOL, "numpy.array_equal": T_BOOL,
    "numpy.any": T_BOOL, "numpy.all": T_BOOL, "numpy.meshgrid": _meshgrid, "numpy.deg2rad": _elementwise,
    "numpy.unique": _first, "numpy.squeeze": _first, "numpy.ravel": _vector, "numpy.bool_": T_BOOL,
    "numpy.diag": _matrix,
    # random
    **_for_names("numpy.random", "uniform normal beta gamma", _random_result(T_FLOAT)),
    "numpy.random.exponential": _random_result(T_FLOAT, 1), "numpy.random.standard_normal": _random_result(T_FLOAT, 0),
    "numpy.random.randint": _random_result(T_INT), "numpy.random.integers": _random_result(T_INT),
    "numpy.random.random": _random_by_size, "numpy.random.rand": _random_by_dimensions,
    "numpy.random.randn": _random_by_dimensions, "numpy.random.choice": _np_choice,
    "numpy.random.random_sample": _random_by_size, "numpy.random.shuffle": T_NONE,
    "numpy.random.permutation": _permutation,
    "numpy.random.seed": T_NONE, "numpy.random.get_state": T_STREAM, "numpy.random.set_state": T_NONE,
    "numpy.random.RandomState": T_STREAM, "numpy.random.default_rng": T_STREAM,
    "numpy.random.Generator": T_STREAM,
    "random.random": T_FLOAT, "random.uniform": T_FLOAT, "random.gauss": T_FLOAT, "random.normalvariate": T_FLOAT,
    "random.triangular": T_FLOAT, "random.betavariate": T_FLOAT, "random.expovariate": T_FLOAT,
    "random.randint": T_INT, "random.randrange": T_INT, "random.choice": _item, "random.seed": T_NONE,
    "random.shuffle": T_NONE,
    "random.choices": _list_of(lambda infer, args: infer.elements(args[0]) if args else NOTHING),
    "random.sample": _list_of(lambda infer, args: infer.elements(args[0]) if args else NOTHING),
    "random.Random": AbstractType(STREAM, frozenset(("random.Random",))), "random.getrandbits": T_INT,
    # other modules
    "functools.reduce": _reduce, "itertools.product": _product, "itertools.combinations": _combinations,
    "itertools.permutations": _combinations, "itertools.chain": _chain, "itertools.zip_longest": _zip,
    "itertools.chain.from_iterable": _list_of(
        lambda infer, args: infer.elements(infer.elements(args[0])) if args else NOTHING
    ),
    "itertools.cycle": _list_of(lambda infer, args: infer.elements(args[0]) if args else NOTHING),
    "itertools.repeat": _list_of(lambda infer, args: args[0] if args else NOTHING),
    "itertools.accumulate": _list_of(lambda infer, args: infer.elements(args[0]) if args else NOTHING),
    "itertools.islice": _list_of(lambda infer, args: infer.elements(args[0]) if args else NOTHING),
    "collections.defaultdict": _defaultdict, "collections.OrderedDict": _dict, "collections.deque": _sequence(LIST),
    "colorsys.hsv_to_rgb": _colors, "colorsys.hls_to_rgb": _colors, "colorsys.rgb_to_hsv": _colors,
    "dataclasses.field": _dataclass_field, "copy.copy": _shallow, "copy.deepcopy": _cloned, "operator.add": T_NUMBER,
    "operator.mul": T_NUMBER,
    "functools.partial": ANYTHING, "functools.lru_cache": ANYTHING,
}  # fmt: skip


# --- methods ---------------------------------------------------------------------------------------------------


def _appended(
    infer: InferenceState, node: ast.Call, owner: AbstractType, args: list[AbstractType], named: dict[str, AbstractType]
) -> AbstractType:
    infer.mutate(owner, args[-1] if args else NOTHING, node=node)
    return T_NONE


def _extended(
    infer: InferenceState, node: ast.Call, owner: AbstractType, args: list[AbstractType], named: dict[str, AbstractType]
) -> AbstractType:
    infer.mutate(owner, infer.elements(args[0]) if args else NOTHING, node=node)
    return T_NONE


def _changed(
    infer: InferenceState, node: ast.Call, owner: AbstractType, args: list[AbstractType], named: dict[str, AbstractType]
) -> AbstractType:
    if "key" in named:
        infer.call(named["key"], node, [infer.elements(owner)], {})
    infer.mutate(owner, node=node)
    return T_NONE


def _popped(
    infer: InferenceState, node: ast.Call, owner: AbstractType, args: list[AbstractType], named: dict[str, AbstractType]
) -> AbstractType:
    infer.mutate(owner, node=node)
    return _values(infer, owner) | (args[1] if len(args) > 1 else NOTHING)


def _values(infer: InferenceState, owner: AbstractType) -> AbstractType:
    return join_all([site.element for site in infer.read_sites(owner)]) | (
        ANYTHING if owner.kinds & ~0xFFFF else NOTHING
    )


def _get(
    infer: InferenceState, node: ast.Call, owner: AbstractType, args: list[AbstractType], named: dict[str, AbstractType]
) -> AbstractType:
    item = join_all([infer.field(site, node.args[0]) for site in infer.read_sites(owner)]) if node.args else NOTHING
    item = item | (ANYTHING if owner.kinds & ~0xFFFF else NOTHING)
    return item | (args[1] if len(args) > 1 else T_NONE)


def _setdefault(
    infer: InferenceState, node: ast.Call, owner: AbstractType, args: list[AbstractType], named: dict[str, AbstractType]
) -> AbstractType:
    default = args[1] if len(args) > 1 else T_NONE
    for site in owner.sites:
        infer.table(site, args[0] if args else NOTHING, default, {}, default)
    infer.mutate(owner, default, args[0] if args else NOTHING, node=node)
    return _values(infer, owner)


def _items(
    infer: InferenceState, node: ast.Call, owner: AbstractType, args: list[AbstractType], named: dict[str, AbstractType]
) -> AbstractType:
    sites = infer.read_sites(owner)
    pair = infer.tuple_of(node, [join_all([s.key for s in sites]), join_all([s.element for s in sites])], tag="pair")
    return infer.container(node, LIST, pair)


def _keys(
    infer: InferenceState, node: ast.Call, owner: AbstractType, args: list[AbstractType], named: dict[str, AbstractType]
) -> AbstractType:
    return infer.container(node, LIST, join_all([s.key for s in infer.read_sites(owner)]))


def _all_values(
    infer: InferenceState, node: ast.Call, owner: AbstractType, args: list[AbstractType], named: dict[str, AbstractType]
) -> AbstractType:
    return infer.container(node, LIST, _values(infer, owner))


def _update(
    infer: InferenceState, node: ast.Call, owner: AbstractType, args: list[AbstractType], named: dict[str, AbstractType]
) -> AbstractType:
    for target in owner.sites:
        for site in [s for a in args for s in infer.read_sites(a)]:
            infer.table(target, site.key, site.element, {}, site.element)
        infer.table(target, NOTHING, NOTHING, {name: inferred for name, inferred in named.items()}, NOTHING)  # noqa: C416
    for site in [s for a in args for s in infer.read_sites(a)]:
        infer.mutate(owner, site.element, site.key, node=node)
    infer.mutate(owner, join_all(list(named.values())), T_STR if named else NOTHING, node=node)
    return T_NONE


def _copied(
    infer: InferenceState, node: ast.Call, owner: AbstractType, args: list[AbstractType], named: dict[str, AbstractType]
) -> AbstractType:
    result = NOTHING
    for site in infer.read_sites(owner):
        copy = infer.site(node, site.kind, str(site.kind))
        if site.items is not None and copy.items is None and not copy.element.kinds:
            copy.items = [NOTHING] * len(site.items)
        if site.kind == DICT:
            infer.table(copy, site.key, site.element, site.fields, site.other)
        result = result | infer.grow(copy, site.element, site.key, site.items)
    return result | owner.without(0x0FFF if owner.sites else 0).bare()


def _set_method(
    infer: InferenceState, node: ast.Call, owner: AbstractType, args: list[AbstractType], named: dict[str, AbstractType]
) -> AbstractType:
    return infer.container(node, SET, infer.elements(owner) | join_all([infer.elements(a) for a in args]))


def _strings(
    infer: InferenceState, node: ast.Call, owner: AbstractType, args: list[AbstractType], named: dict[str, AbstractType]
) -> AbstractType:
    return infer.container(node, LIST, T_STR)


def _same_array(
    infer: InferenceState, node: ast.Call, owner: AbstractType, args: list[AbstractType], named: dict[str, AbstractType]
) -> AbstractType:
    return owner


def _reduced(
    infer: InferenceState, node: ast.Call, owner: AbstractType, args: list[AbstractType], named: dict[str, AbstractType]
) -> AbstractType:
    return _array(infer, node) if args or "axis" in named else T_FLOAT


def _to_list(
    infer: InferenceState, node: ast.Call, owner: AbstractType, args: list[AbstractType], named: dict[str, AbstractType]
) -> AbstractType:
    return infer.container(node, LIST, infer.elements(owner))


def _constant(result: AbstractType) -> Method:
    return lambda infer, node, owner, args, named: result


def _stream_method(name: str) -> Method:
    """Return the transfer function of a stream's method, which is that of the function in its module."""

    def result(
        infer: InferenceState,
        node: ast.Call,
        owner: AbstractType,
        args: list[AbstractType],
        named: dict[str, AbstractType],
    ) -> AbstractType:
        infer.effect(node, 1)
        entry = RESULTS.get(f"numpy.random.{name}") or RESULTS.get(f"random.{name}") or ANYTHING
        if name == "shuffle" and args:
            infer.mutate(args[0], node=node)
        return entry if isinstance(entry, AbstractType) else entry(infer, node, args, named)

    return result


_STREAM_METHODS = (
    "uniform", "random", "randint", "choice", "normal", "shuffle", "permutation", "rand", "randn", "integers",
    "gauss", "sample", "choices", "seed", "random_sample", "randrange", "standard_normal", "triangular",
)  # fmt: skip

METHODS: dict[str, Method] = {
    "append": _appended, "insert": _appended, "add": _appended, "appendleft": _appended, "extend": _extended,
    "remove": _changed, "discard": _changed, "clear": _changed, "sort": _changed, "reverse": _changed,
    "pop": _popped, "popleft": _popped, "popitem": _items, "get": _get, "setdefault": _setdefault, "items": _items,
    "keys": _keys, "values": _all_values, "update": _update, "copy": _copied, "index": _constant(T_INT),
    "count": _constant(T_INT), "union": _set_method, "intersection": _set_method, "difference": _set_method,
    "symmetric_difference": _set_method, "issubset": _constant(T_BOOL), "issuperset": _constant(T_BOOL),
    "isdisjoint": _constant(T_BOOL),
    **_for_names("", (
        "upper lower strip lstrip rstrip title capitalize replace join format zfill center ljust rjust "
        "swapcase removeprefix removesuffix"
    ), _constant(T_STR)),
    "split": _strings, "splitlines": _strings, "startswith": _constant(T_BOOL), "endswith": _constant(T_BOOL),
    "find": _constant(T_INT), "isdigit": _constant(T_BOOL), "isalpha": _constant(T_BOOL), "isupper": _constant(T_BOOL),
    "islower": _constant(T_BOOL), "isspace": _constant(T_BOOL), "rfind": _constant(T_INT),
    "sum": _reduced, "mean": _reduced, "max": _reduced, "min": _reduced, "prod": _reduced, "std": _reduced,
    "tolist": _to_list, "astype": _same_array, "flatten": _to_list, "ravel": _to_list, "reshape": _same_array,
    "transpose": _same_array, "dot": lambda infer, node, owner, args, named: _dot(infer, node, [owner, *args], named),
    "item": _constant(T_FLOAT), "round": _same_array, "clip": _same_array, "all": _constant(T_BOOL),
    "any": _constant(T_BOOL),
    "argmin": _constant(T_INT), "argmax": _constant(T_INT), "cumsum": _same_array,
    **{name: _stream_method(name) for name in _STREAM_METHODS},
}  # fmt: skip
