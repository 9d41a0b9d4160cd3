"""Kinds of the results of library functions.

What the registry says of a result is used where it is exact. Functions whose result depends on their arguments have a
rule here. A rule must contain every value that the function can return: a test compares them with evaluated programs.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from scenelang.interpreter.kinds.kinds import (
    ANY,
    ARRAYS,
    BOOLEAN,
    CONS,
    EMBEDDING,
    EMPTY,
    ENTITY,
    FLOAT,
    FRAMES,
    FUNCTION,
    HANDLES,
    INTEGER,
    LIST,
    MATRIX,
    MAYBE_LIST,
    MUTABLE_ARRAY,
    MUTABLE_LIST,
    NEVER,
    NONE,
    NUMBER,
    NUMERIC,
    PART,
    PARTS,
    SET,
    STREAM,
    STRING,
    SYMBOL,
    TABLE,
    VECTOR,
    Kind,
    item_of,
    join,
    join_all,
    list_of,
    list_with,
    union_of,
    vector_of,
)
from scenelang.interpreter.runtime.types import Builtin

# Functions that take an angle in radians, with the position of that argument.
ANGLES = {"rotate": 0, "sin": 0, "cos": 0, "tan": 0}

# Arguments that are points or directions: three numbers.
TRIPLES = {"translate": (0,), "rotate": (1, 2), "reflect": (0, 1), "scale": (0, 1)}

# What each procedure can change, and the values that nothing can change.
_LISTS = frozenset(("MutableList",))
_SEQUENCES = frozenset(("MutableList", "MutableArray"))
_COLLECTIONS = frozenset(("MutableList", "Table", "Set"))
MUTATED: dict[str, frozenset[str]] = {
    **dict.fromkeys(("push!", "insert!", "remove-at!", "splice!"), _LISTS),
    **dict.fromkeys(("sort!", "reverse!", "shuffle!", "py-shuffle!"), _SEQUENCES),
    "pop!": frozenset(("MutableList", "Table", "Set")), "clear!": _COLLECTIONS, "add!": frozenset(("Set",)),
    "extend!": _COLLECTIONS, "remove!": frozenset(("MutableList", "Set")), "remove-key!": frozenset(("Table",)),
    "set-ref!": frozenset(("MutableList", "MutableArray", "Table", "Record")),
    "update!": frozenset(("MutableList", "MutableArray", "Table", "Record", "Set")),
}  # fmt: skip
IMMUTABLE = frozenset(("List", "Vector", "Array", "Matrix", "String", "Pair", "Part"))

# What ``car`` and ``cdr`` take apart.
PAIRS = frozenset(("List", "Pair", "Part", "Entity", "Handles", "MutableList"))

_BY_TYPE: dict[str, Kind] = {
    "Boolean": BOOLEAN, "String": STRING, "Word": STRING, "Symbol": SYMBOL, "Entity": ENTITY, "Matrix": MATRIX,
    "Vector": VECTOR, "Embedding": EMBEDDING, "Table": TABLE, "Set": SET, "Stream": STREAM, "Frames": FRAMES,
    "MutableList": MUTABLE_LIST, "MutableArray": MUTABLE_ARRAY, "Pair": CONS, "List": LIST, "Array": NUMERIC,
    "Function": FUNCTION, "List[Tuple[Entity, Matrix]]": PARTS, "List[Embedding]": Kind("List", None, EMBEDDING),
}  # fmt: skip

Rule = Callable[[Sequence[Kind]], Kind]


def result_of(builtin: Builtin, arguments: Sequence[Kind], has_keywords: bool) -> Kind:
    """Return the kind of the result of a call. ``arguments`` are the kinds of the positional ones."""
    rule = _RULES.get(builtin.name)
    if rule is not None:
        return ANY if has_keywords and builtin.name not in _KEYWORDS_DO_NOT_MATTER else rule(arguments)
    return _BY_TYPE.get(builtin.result, ANY)


def _is_number(kind: Kind) -> bool:
    return kind.tag in ("Integer", "Float") or kind is NUMBER


def _is_vector(kind: Kind) -> bool:
    return kind.tag == "Vector"


def _arithmetic(arguments: Sequence[Kind]) -> Kind:
    """Numbers give a number; arrays of one shape, and numbers, an array of that shape."""
    if all(kind is INTEGER for kind in arguments):
        return INTEGER
    if all(map(_is_number, arguments)):
        return NUMBER
    if any(kind is ANY for kind in arguments):
        return ANY
    vectors = [kind for kind in arguments if not _is_number(kind)]
    if all(map(_is_vector, vectors)):
        lengths = {len(kind.items) if kind.items is not None else None for kind in vectors}
        length = lengths.pop() if len(lengths) == 1 else None
        return vector_of(length) if length is not None else VECTOR
    return NUMERIC


def _division(arguments: Sequence[Kind]) -> Kind:
    kind = _arithmetic(arguments)
    return NUMBER if kind is INTEGER else kind


def _elementwise(arguments: Sequence[Kind]) -> Kind:
    """A function of one number, applied to each item of an array."""
    kind = arguments[0] if arguments else ANY
    if _is_number(kind):
        return NUMBER
    return vector_of(len(kind.items)) if _is_vector(kind) and kind.items is not None else NUMERIC


def _rounding(arguments: Sequence[Kind]) -> Kind:
    kind = _elementwise(arguments)
    return NUMBER if kind is NUMBER else kind


def _listed(arguments: Sequence[Kind]) -> Kind:
    return list_of(arguments)


def _listed_then(arguments: Sequence[Kind]) -> Kind:
    tail = arguments[-1]
    if tail.tag == "MutableList":
        return list_with(ANY)
    if tail.tag != "List" or len(arguments) > 32:
        return ANY if tail is ANY else CONS if len(arguments) > 1 else tail
    if tail.items is not None:
        return list_of([*arguments[:-1], *tail.items])
    return list_with(join_all([*arguments[:-1], item_of(tail)]))


def _cons(arguments: Sequence[Kind]) -> Kind:
    first, rest = arguments
    if first is ENTITY and rest is MATRIX:
        return PART
    if rest.tag == "List":
        return list_of([first, *rest.items]) if rest.items is not None else list_with(join(first, item_of(rest)))
    return CONS


def _car(arguments: Sequence[Kind]) -> Kind:
    kind = arguments[0]
    if kind.tag == "List":
        return kind.items[0] if kind.items else item_of(kind) if kind.items is None else ANY
    return ENTITY if kind is PART else CONS if kind is ENTITY else ANY


def _cdr(arguments: Sequence[Kind]) -> Kind:
    kind = arguments[0]
    if kind.tag == "List":
        return list_of(kind.items[1:]) if kind.items else list_with(item_of(kind)) if kind.items is None else ANY
    return MATRIX if kind is PART else PARTS if kind is ENTITY else HANDLES if kind is HANDLES else ANY


def result_of_pair(letter: str, kind: Kind) -> Kind:
    """Return the kind of the first part (``a``) or the rest (``d``) of a pair."""
    return _car((kind,)) if letter == "a" else _cdr((kind,))


def _append(arguments: Sequence[Kind]) -> Kind:
    """Lists give a list, whose items are those of all."""
    if not arguments:
        return EMPTY
    if any(kind.tag != "List" for kind in arguments[:-1]):
        return ANY
    last = arguments[-1]
    if last.tag != "List":
        return ANY
    if all(kind.items is not None for kind in arguments):
        return list_of([item for kind in arguments for item in kind.items or ()])
    return list_with(join_all(map(item_of, arguments)))


def _iota(arguments: Sequence[Kind]) -> Kind:
    whole = all(kind is INTEGER for kind in arguments[1:])
    return Kind("List", None, INTEGER if whole else NUMBER)


def _integers(arguments: Sequence[Kind]) -> Kind:
    return Kind("List", None, INTEGER)


def _same_sequence(arguments: Sequence[Kind]) -> Kind:
    """A sequence with the same items in another order or number."""
    kind = arguments[0]
    if kind.tag == "List":
        return list_with(item_of(kind)) if kind.items != () else EMPTY
    return VECTOR if kind.tag == "Vector" else ANY


def _reversed(arguments: Sequence[Kind]) -> Kind:
    kind = arguments[0]
    if kind.tag in ("List", "Vector") and kind.items is not None:
        return Kind(kind.tag, tuple(reversed(kind.items)))
    return _same_sequence(arguments)


def _mapped(arguments: Sequence[Kind]) -> Kind:
    function = arguments[0]
    item = function.item if function.tag == "Function" and function.item is not None else ANY
    return Kind("List", None, item if item is not NEVER else ANY)


def _item(arguments: Sequence[Kind]) -> Kind:
    kind = arguments[0]
    if len(arguments) == 1 and kind.tag in ("List", "Vector", "String"):
        found = item_of(kind)
        return ANY if found is NEVER else found
    return ANY


def _ref(arguments: Sequence[Kind]) -> Kind:
    """An item of a list or vector; a default may be given for tables only."""
    if len(arguments) != 2:
        return ANY
    kind = arguments[0]
    if kind.tag == "List" and kind.items != ():
        return item_of(kind)
    return NUMBER if kind.tag == "Vector" else STRING if kind.tag == "String" else ANY


def _coordinate(arguments: Sequence[Kind]) -> Kind:
    return NUMBER if arguments[0].tag == "Vector" else ANY


def _vector(arguments: Sequence[Kind]) -> Kind:
    if any(kind is ANY or not _is_number(kind) for kind in arguments):
        return vector_of(len(arguments)) if len(arguments) > 1 else VECTOR
    return vector_of(len(arguments), all(kind is INTEGER for kind in arguments))


def _matrix_product(arguments: Sequence[Kind]) -> Kind:
    if all(kind is MATRIX for kind in arguments):
        return MATRIX
    if all(kind is MATRIX for kind in arguments[:-1]) and arguments[-1].tag == "Vector":
        items = arguments[-1].items
        return vector_of(3) if items is not None and len(items) == 3 else VECTOR
    return ANY


def _dot(arguments: Sequence[Kind]) -> Kind:
    return NUMBER if all(kind.tag == "Vector" for kind in arguments) else ANY


def _extremum(arguments: Sequence[Kind]) -> Kind:
    if len(arguments) > 1 and all(map(_is_number, arguments)):
        return INTEGER if all(kind is INTEGER for kind in arguments) else NUMBER
    return ANY


def _sum(arguments: Sequence[Kind]) -> Kind:
    kind = arguments[0]
    if kind.tag == "Vector" or (kind.tag == "List" and _is_number(item_of(kind))):
        return NUMBER
    return ANY


def _drawn(arguments: Sequence[Kind]) -> Kind:
    """A draw without ``:size`` is a number if its limits are."""
    return NUMBER if all(map(_is_number, arguments)) else ANY


def _zipped(arguments: Sequence[Kind]) -> Kind:
    items = [item_of(kind) if kind.tag in ("List", "Vector", "String") else ANY for kind in arguments]
    return Kind("List", None, list_of([ANY if item is NEVER else item for item in items]))


def _enumerated(arguments: Sequence[Kind]) -> Kind:
    kind = arguments[0]
    item = item_of(kind) if kind.tag in ("List", "Vector", "String") else ANY
    return Kind("List", None, list_of([INTEGER, ANY if item is NEVER else item]))


def _identity(arguments: Sequence[Kind]) -> Kind:
    return arguments[0] if arguments else ANY


def _constant(kind: Kind) -> Rule:
    return lambda arguments: kind


_MAYBE = {"Integer": union_of((INTEGER, BOOLEAN))}
_FUNCTIONS = (
    "sqrt", "exp", "log10", "log2", "sin", "cos", "tan", "asin", "acos", "sinh", "cosh", "tanh", "degrees", "radians",
    "inexact", "exact->inexact",
)  # fmt: skip

_RULES: dict[str, Rule] = {
    **dict.fromkeys(("+", "-", "*", "square", "abs", "%", "modulo", "//"), _arithmetic),
    **dict.fromkeys(("/", "expt"), _division),
    **dict.fromkeys(_FUNCTIONS, _elementwise),
    **dict.fromkeys(("floor", "ceiling", "truncate", "round", "exact", "sign"), _rounding),
    **dict.fromkeys(("log", "atan"), _drawn),
    **dict.fromkeys(("clamp", "quotient", "remainder"), _constant(NUMBER)),
    **dict.fromkeys(("hypot", "norm", "distance", "determinant"), _constant(NUMBER)),
    **dict.fromkeys(("x-of", "y-of", "z-of"), _coordinate),
    "normalize": lambda arguments: VECTOR if arguments[0].items is None else vector_of(len(arguments[0].items)),
    "vector-ref": _constant(NUMBER), "transpose": lambda arguments: ANY if arguments[0].tag != "Matrix" else ARRAYS,
    **dict.fromkeys(("bitwise-and", "bitwise-or", "bitwise-xor", "arithmetic-shift", "gcd", "lcm"), _constant(INTEGER)),
    **dict.fromkeys(("length", "string-length", "vector-length", "count", "ord"), _constant(INTEGER)),
    **dict.fromkeys(("compute-shape-min", "compute-shape-max", "compute-shape-center"), _constant(vector_of(3))),
    "compute-shape-sizes": _constant(vector_of(3)),
    **dict.fromkeys(("color", "rgb", "hsv"), _constant(vector_of(3))),
    "list->vector": _constant(ARRAYS), "embedding-text": _constant(ANY),
    "cross": _constant(VECTOR), "interp": _constant(ANY), "lerp": _division,
    "list": _listed, "values": _listed, "list*": _listed_then, "cons": _cons, "car": _car, "cdr": _cdr,
    "append": _append, "iota": _iota, "range": _integers, "reverse": _reversed, "list-copy": _same_sequence,
    "list-head": _same_sequence, "list-tail": _same_sequence, "take": _same_sequence, "drop": _same_sequence,
    "rest": _same_sequence, "sort": _same_sequence, "shuffle": _same_sequence, "py-shuffle": _same_sequence,
    "repeat": _same_sequence, "delete": _constant(LIST), "delete-duplicates": _constant(LIST),
    "map": _mapped, "append-map": _constant(LIST), "filter-map": _constant(LIST),
    "first": _item, "second": _item, "third": _item, "last": _item, "ref": _ref, "list-ref": _ref,
    "choice": _item, "py-choice": _item,
    "zip": _zipped, "enumerate": _enumerated, "vector": _vector, "array": _constant(ANY), "@": _matrix_product,
    "dot": _dot, "min": _extremum, "max": _extremum, "sum": _sum, "identity-pose": _constant(MATRIX),
    "inverse": lambda arguments: MATRIX if arguments[0] is MATRIX else ARRAYS,
    "random": _drawn, "uniform": _drawn, "normal": _drawn, "rand": _constant(ANY), "randn": _constant(ANY),
    "randint": lambda arguments: INTEGER, "py-random": _constant(FLOAT), "py-uniform": _constant(NUMBER),
    "py-gauss": _constant(NUMBER), "py-randint": _constant(INTEGER), "py-randrange": _constant(INTEGER),
    "error": _constant(NEVER), "raise": _constant(NEVER), "assertion-failed": _constant(NEVER),
    "print": _constant(NONE), "identity": _identity, "member": _constant(MAYBE_LIST), "memq": _constant(MAYBE_LIST),
    "memv": _constant(MAYBE_LIST), "floor/": _constant(LIST), "truncate/": _constant(LIST),
    "string->list": _constant(Kind("List", None, STRING)), "string-split": _constant(Kind("List", None, STRING)),
    "->list": _constant(LIST), "vector->list": _constant(LIST), "partition": _constant(LIST),
    "filter": _constant(LIST), "remove": _constant(LIST), "mutable-list": _constant(MUTABLE_LIST),
    "mutable-array": _constant(MUTABLE_ARRAY), "retrieve": _constant(FUNCTION),
    **dict.fromkeys(("push!", "clear!", "set-ref!", "add!", "set-seed!", "py-set-seed!", "void"), _constant(ANY)),
}  # fmt: skip

# Keyword arguments of these functions do not change the kind of the result.
_KEYWORDS_DO_NOT_MATTER = frozenset((
    "sort", "shuffle", "py-shuffle", "py-random", "py-uniform", "py-gauss", "py-randint", "py-randrange", "py-choice",
))  # fmt: skip


__all__ = ["ANGLES", "IMMUTABLE", "MUTATED", "PAIRS", "TRIPLES", "result_of", "result_of_pair"]
