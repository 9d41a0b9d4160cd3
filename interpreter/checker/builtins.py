"""Builtins: the kinds of their results, and checks of the values of their arguments.

The type of a result in the registry is used where it is exact. Functions whose result depends on their arguments have a
rule here. A rule must cover every value that the function can return: ``tests/kinds`` compares rules with evaluated
programs. A finding requires certainty, so some rules of arithmetic share type sets (``Numeric``, ``ArrayLike``) and
shapes are compared only if both are known: a small table that is always right is worth more than a larger one.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Any

from scenelang.grammar import ast
from scenelang.grammar.diagnostics import Edit, Fix, SceneError
from scenelang.grammar.lazy_patterns import lazy_pattern
from scenelang.interpreter.checker import truths
from scenelang.interpreter.checker.common import (
    A_PART,
    MAX_SHOWN,
    accepts,
    advice_on_value,
    may_be_parts,
    number_of,
    plural,
    shown,
    swap_fix,
    triple_fix,
    wrap_fix,
)
from scenelang.interpreter.compile.analyze import called_builtin, walk
from scenelang.interpreter.compile.kinds import (
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
    describe,
    is_number,
    item_of,
    join,
    join_all,
    length_of,
    list_of,
    list_with,
    pair_of,
    union_of,
    vector_of,
)
from scenelang.interpreter.runtime.types import BASE_TYPES, Builtin, BuiltinParameter, Type, expected_name
from scenelang.interpreter.values.values import Vector

if TYPE_CHECKING:
    from scenelang.interpreter.checker.infer import KindInference

# Functions that take an angle in radians, with the position of that argument.
ANGLES = {"rotate": 0, "sin": 0, "cos": 0, "tan": 0}

# Attributes and options whose values are angles in radians.
ANGLE_KEYWORDS = frozenset(("angle", "rotate", "start", "sweep", "turn", "twist"))

# Arguments that are points or directions: three numbers.
TRIPLES = {"translate": (0,), "rotate": (1, 2), "reflect": (0, 1), "scale": (0, 1)}

# Types that each procedure can change, and types that none can.
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

# Types that ``car`` and ``cdr`` accept.
PAIRS = frozenset(("List", "Pair", "Part", "Entity", "Handles", "MutableList"))

_BY_TYPE: dict[str, Kind] = {
    "Boolean": BOOLEAN, "String": STRING, "Word": STRING, "Symbol": SYMBOL, "Entity": ENTITY, "Matrix": MATRIX,
    "Vector": VECTOR, "Embedding": EMBEDDING, "Table": TABLE, "Set": SET, "Stream": STREAM, "Frames": FRAMES,
    "MutableList": MUTABLE_LIST, "MutableArray": MUTABLE_ARRAY, "Pair": CONS, "List": LIST, "Array": NUMERIC,
    "Function": FUNCTION, "List[Tuple[Entity, Matrix]]": PARTS, "List[Embedding]": Kind("List", None, EMBEDDING),
}  # fmt: skip

_MAX_CONSED = 32  # arguments of ``list*`` that are looked at

Rule = Callable[[Sequence[Kind]], Kind]  # the kind of a result, from those of the positional arguments


def result_of(builtin: Builtin, arguments: Sequence[Kind], has_keywords: bool) -> Kind:
    """Return the kind of the result of a call. ``arguments`` are the kinds of the positional ones."""
    rule = _RULES.get(builtin.name)
    if rule is not None:
        return ANY if has_keywords and builtin.name not in _KEYWORDS_DO_NOT_MATTER else rule(arguments)
    return _BY_TYPE.get(builtin.result, ANY)


def _is_vector(kind: Kind) -> bool:
    """Return whether a value is certainly a Vector."""
    return kind.tag == "Vector"


def _arithmetic(arguments: Sequence[Kind]) -> Kind:
    """Numbers give a number; arrays of one shape, and numbers, an array of that shape."""
    if all(kind is INTEGER for kind in arguments):
        return INTEGER
    if all(map(is_number, arguments)):
        return NUMBER
    if any(kind is ANY for kind in arguments):
        return NUMERIC
    vectors = [kind for kind in arguments if not is_number(kind)]
    if all(map(_is_vector, vectors)):
        lengths = {len(kind.items) if kind.items is not None else None for kind in vectors}
        length = lengths.pop() if len(lengths) == 1 else None
        return vector_of(length) if length is not None else VECTOR
    return NUMERIC


def _division(arguments: Sequence[Kind]) -> Kind:
    """Like arithmetic, but Integers may give a Float."""
    kind = _arithmetic(arguments)
    return NUMBER if kind is INTEGER else kind


def _elementwise(arguments: Sequence[Kind]) -> Kind:
    """A function of one number, applied to each item of an array."""
    kind = arguments[0] if arguments else ANY
    if is_number(kind):
        return NUMBER
    return vector_of(len(kind.items)) if _is_vector(kind) and kind.items is not None else NUMERIC


def _rounding(arguments: Sequence[Kind]) -> Kind:
    """A rounding function, applied to a number or each item of an array."""
    kind = _elementwise(arguments)
    return NUMBER if kind is NUMBER else kind


def _listed(arguments: Sequence[Kind]) -> Kind:
    """A list of the arguments."""
    return list_of(arguments)


def _listed_then(arguments: Sequence[Kind]) -> Kind:
    """A list of the arguments whose last one is the rest of the list."""
    tail = arguments[-1]
    if tail.tag == "MutableList":
        return list_with(ANY)
    if tail.tag != "List" or len(arguments) > _MAX_CONSED:
        return ANY if tail is ANY else CONS if len(arguments) > 1 else tail
    if tail.items is not None:
        return list_of([*arguments[:-1], *tail.items])
    return list_with(join_all([*arguments[:-1], item_of(tail)]))


def _cons(arguments: Sequence[Kind]) -> Kind:
    """A posed entity, a pair, or a list with one item more."""
    first, rest = arguments
    if first is ENTITY and rest is MATRIX:
        return PART
    if not accepts("List", rest):
        return pair_of(first, rest)
    if rest.tag == "List":
        return list_of([first, *rest.items]) if rest.items is not None else list_with(join(first, item_of(rest)))
    return CONS


def _car(arguments: Sequence[Kind]) -> Kind:
    """The first item; an entity is a pair of word and embedding, and its parts."""
    kind = arguments[0]
    if kind.tag == "List":
        return kind.items[0] if kind.items else item_of(kind) if kind.items is None else ANY
    if kind.tag == "Pair" and kind.items is not None:
        return kind.items[0]
    return ENTITY if kind is PART else pair_of(STRING, EMBEDDING) if kind is ENTITY else ANY


def _cdr(arguments: Sequence[Kind]) -> Kind:
    """The rest of a list or pair."""
    kind = arguments[0]
    if kind.tag == "List":
        return list_of(kind.items[1:]) if kind.items else list_with(item_of(kind)) if kind.items is None else ANY
    if kind.tag == "Pair" and kind.items is not None:
        return kind.items[1]
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
    """A list of numbers; Integers if start and step are."""
    are_integers = all(kind is INTEGER for kind in arguments[1:])
    return Kind("List", None, INTEGER if are_integers else NUMBER)


def _integers(arguments: Sequence[Kind]) -> Kind:
    """A list of Integers."""
    return Kind("List", None, INTEGER)


def _same_sequence(arguments: Sequence[Kind]) -> Kind:
    """A sequence with the same items in another order or number."""
    kind = arguments[0]
    if kind.tag == "List":
        return list_with(item_of(kind)) if kind.items != () else EMPTY
    return VECTOR if kind.tag == "Vector" else ANY


def _reversed(arguments: Sequence[Kind]) -> Kind:
    """The items in reverse order."""
    kind = arguments[0]
    if kind.tag in ("List", "Vector") and kind.items is not None:
        return Kind(kind.tag, tuple(reversed(kind.items)))
    return _same_sequence(arguments)


def _mapped(arguments: Sequence[Kind]) -> Kind:
    """A list of the function's results, as long as a single sequence of known length."""
    function = arguments[0]
    item = function.item if function.tag == "Function" and function.item is not None else ANY
    if len(arguments) == 2 and arguments[1].tag in ("List", "Vector") and item is not NEVER:
        length = length_of(arguments[1])
        if length is not None:
            return list_of([item] * length)
    return Kind("List", None, item if item is not NEVER else ANY)


def _item(arguments: Sequence[Kind]) -> Kind:
    """Any item of a sequence."""
    kind = arguments[0]
    if len(arguments) == 1 and kind.tag in ("List", "Vector", "String"):
        item = item_of(kind)
        return ANY if item is NEVER else item
    return ANY


def _nth(index: int) -> Rule:
    """The item at a position of a list or vector."""

    def rule(arguments: Sequence[Kind]) -> Kind:
        items = arguments[0].items if arguments[0].tag in ("List", "Vector") else None
        return items[index] if items is not None and -len(items) <= index < len(items) else _item(arguments)

    return rule


def _ref(arguments: Sequence[Kind]) -> Kind:
    """An item of a list or vector; a default may be given for tables only."""
    if len(arguments) != 2:
        return ANY
    kind = arguments[0]
    if kind.tag == "List" and kind.items != ():
        return item_of(kind)
    return NUMBER if kind.tag == "Vector" else STRING if kind.tag == "String" else ANY


def _coordinate(arguments: Sequence[Kind]) -> Kind:
    """A component of a vector."""
    return NUMBER if arguments[0].tag == "Vector" else ANY


def _vector(arguments: Sequence[Kind]) -> Kind:
    """An array of the arguments."""
    if any(map(is_number, arguments)):  # the others are numbers too, or the call fails
        return vector_of(len(arguments), all(kind is INTEGER for kind in arguments))
    return ARRAYS


def _matrix_product(arguments: Sequence[Kind]) -> Kind:
    """A pose, or a vector that poses are applied to."""
    if all(kind is MATRIX for kind in arguments):
        return MATRIX
    if all(kind is MATRIX for kind in arguments[:-1]) and arguments[-1].tag == "Vector":
        items = arguments[-1].items
        return vector_of(3) if items is not None and len(items) == 3 else VECTOR
    return ANY


def _dot(arguments: Sequence[Kind]) -> Kind:
    """A number for two vectors."""
    return NUMBER if all(kind.tag == "Vector" for kind in arguments) else ANY


def _extremum(arguments: Sequence[Kind]) -> Kind:
    """One of several numbers."""
    if len(arguments) > 1 and all(map(is_number, arguments)):
        return INTEGER if all(kind is INTEGER for kind in arguments) else NUMBER
    return ANY


def _sum(arguments: Sequence[Kind]) -> Kind:
    """Return the kind of ``(sum items)``: a number if the items are known to be numbers, as in a vector."""
    kind = arguments[0]
    if kind.tag == "Vector" or (kind.tag == "List" and is_number(item_of(kind))):
        return NUMBER
    return ANY


def _drawn(arguments: Sequence[Kind]) -> Kind:
    """A draw without ``:size`` is a number if its limits are."""
    return NUMBER if all(map(is_number, arguments)) else ANY


def _zipped(arguments: Sequence[Kind]) -> Kind:
    """A list of lists with one item of each sequence."""
    items = [item_of(kind) if kind.tag in ("List", "Vector", "String") else ANY for kind in arguments]
    return Kind("List", None, list_of([ANY if item is NEVER else item for item in items]))


def _enumerated(arguments: Sequence[Kind]) -> Kind:
    """A list of lists of an index and an item."""
    kind = arguments[0]
    item = item_of(kind) if kind.tag in ("List", "Vector", "String") else ANY
    return Kind("List", None, list_of([INTEGER, ANY if item is NEVER else item]))


def _identity(arguments: Sequence[Kind]) -> Kind:
    """The first argument."""
    return arguments[0] if arguments else ANY


def _constant(kind: Kind) -> Rule:
    """Return a rule for functions whose results all have one kind."""
    return lambda arguments: kind


_MAYBE = {"Integer": union_of((INTEGER, BOOLEAN))}
_FUNCTIONS = (
    "sqrt", "exp", "log10", "log2", "sin", "cos", "tan", "asin", "acos", "sinh", "cosh", "tanh", "deg", "to-degrees",
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
    "vector-ref": _coordinate, "transpose": lambda arguments: ANY if arguments[0].tag != "Matrix" else ARRAYS,
    **dict.fromkeys(("bitwise-and", "bitwise-or", "bitwise-xor", "arithmetic-shift", "gcd", "lcm"), _constant(INTEGER)),
    **dict.fromkeys(("length", "string-length", "vector-length", "count", "ord"), _constant(INTEGER)),
    **dict.fromkeys(("compute-shape-min", "compute-shape-max", "compute-shape-center"), _constant(vector_of(3))),
    "compute-shape-sizes": _constant(vector_of(3)),
    **dict.fromkeys(("color", "rgb", "hsv"), _constant(vector_of(3))),
    "list->vector": _constant(ARRAYS), "embedding-text": _constant(ANY),
    "cross": lambda arguments: VECTOR if all(each.tag == VECTOR.tag for each in arguments) else ANY,
    "interp": _constant(ANY), "lerp": _division,
    "list": _listed, "values": _listed, "list*": _listed_then, "cons": _cons, "car": _car, "cdr": _cdr,
    "append": _append, "iota": _iota, "range": _integers, "reverse": _reversed, "list-copy": _same_sequence,
    "list-head": _same_sequence, "list-tail": _same_sequence, "take": _same_sequence, "drop": _same_sequence,
    "rest": _same_sequence, "sort": _same_sequence, "shuffle": _same_sequence, "py-shuffle": _same_sequence,
    "repeat": _same_sequence, "delete": _constant(LIST), "delete-duplicates": _constant(LIST),
    "map": _mapped, "append-map": _constant(LIST), "filter-map": _constant(LIST),
    "first": _nth(0), "second": _nth(1), "third": _nth(2), "last": _nth(-1), "ref": _ref, "list-ref": _ref,
    "choice": _item, "py-choice": _item,
    "zip": _zipped, "enumerate": _enumerated, "vector": _vector, "array": _constant(ANY), "@": _matrix_product,
    "dot": _dot, "min": _extremum, "max": _extremum, "sum": _sum, "identity-pose": _constant(MATRIX),
    "inverse": lambda arguments: MATRIX if arguments[0] is MATRIX else ARRAYS,
    "random": _drawn, "uniform": _drawn, "normal": _drawn, "rand": _constant(ANY), "randn": _constant(ANY),
    "randint": lambda arguments: INTEGER, "py-random": _constant(FLOAT), "py-uniform": _constant(NUMBER),
    "py-gauss": _constant(NUMBER), "py-randint": _constant(INTEGER), "py-randrange": _constant(INTEGER),
    "error": _constant(NEVER), "raise": _constant(NEVER), "assertion-failed": _constant(NEVER),
    **dict.fromkeys(("print", "for-each"), _constant(NONE)),
    "identity": _identity, "member": _constant(MAYBE_LIST), "memq": _constant(MAYBE_LIST),
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


# --- values of arguments ---------------------------------------------------------------------------------------------


TURN = 2 * math.pi  # radians


def check_values(
    inference: KindInference,
    node: ast.Application,
    builtin: Builtin,
    nodes: Sequence[Any],
    kinds: Sequence[Kind],
    keywords: Sequence[tuple[str, Any, Any]] = (),
) -> bool:
    """Check the arguments of a builtin whose values are known: divisors, indices, angles, and what its entry checks.

    Parameters
    ----------
    node
        The call.
    builtin
        The builtin that it calls.
    nodes, kinds
        Positional arguments, and their kinds.
    keywords
        Keyword arguments: names, and nodes of keywords and values.

    Returns
    -------
    bool
        False after a report, so that each call has one error.
    """
    name = builtin.name
    truths.check_floor_division(inference, node)
    divisors = nodes[1:] if len(nodes) > 1 else nodes if name == "/" else ()
    if name in _DIVISIONS and any(inference.number_of(divisor) == 0 for divisor in divisors):
        if not any(kind is ANY or kind.tag not in ("Integer", "Float") for kind in kinds[:1]):
            inference.report("zero-division", f"division by zero in `{name}`", node.span,
                             _zero_hint(inference, node, divisors), expected="another number",
                             found="0")  # fmt: skip
            return False
    elif name in _DIVISIONS:
        for divisor in divisors:
            inference.need(divisor, f"a divisor in `{name}`", (), "a number other than 0", "zero-division",
                           fails=lambda value: value == 0)  # fmt: skip
    index = _INDEXED.get(name)
    if index is not None and len(nodes) > index[1]:
        if not _check_index(inference, node, name, nodes[index[0]], kinds[index[0]], nodes[index[1]]):
            return False
    for position in TRIPLES.get(name, ()):
        if position < len(nodes) and not _check_triple(inference, node, builtin, position, nodes, kinds):
            return False
    is_nested = name in ("set-ref!", "update!") and len(nodes) > 3  # several indices, each into the item before
    if name in MUTATED and not is_nested and not _check_mutable(inference, node, name, nodes[0], kinds[0]):
        return False
    if _CXR.fullmatch(name) and not _check_cxr(inference, node, name, nodes[0], kinds[0]):
        return False
    if name in ("min", "max") and len(nodes) > 1 and not _check_extremes(inference, node, name, nodes, kinds):
        return False
    rejected = _REJECTED.get(name)
    if rejected is not None and not _check_rejected(inference, node, builtin, rejected, nodes, kinds):
        return False
    if name in _EVALUATED and not _check_domain(inference, node, builtin, nodes):
        return False
    further = _FURTHER.get(name)
    if further is not None and not further(inference, node, name, nodes, kinds):
        return False
    angle = ANGLES.get(name)
    if angle is not None and len(nodes) > angle:
        check_angle(inference, nodes[angle])
    # The value of a literal that the reader could not read is None.
    given = {key: value for key, _, value in keywords}
    if builtin.check is not None and all(
        type(literal) is ast.Constant and literal.value is not None for literal in (*nodes, *given.values())
    ):
        try:
            builtin.check(*(node.value for node in nodes), **{key: value.value for key, value in given.items()})
        except SceneError as error:
            inference.report(error.name, error.message, node.span, error.hint, fixes=_near_fixes(error, nodes),
                             expected=f"a valid argument of `{name}`", found=" ".join(n.span.text for n in nodes),
                             signature=builtin.usage, near=error.near)  # fmt: skip
            return False
    return True


_NO_SEQUENCE = frozenset(("Integer", "Float", "Entity", "Function", "Boolean", "None", "Keyword", "Symbol"))
_NO_ARRAY = frozenset(("Integer", "Float", "Entity", "String", "Function", "Boolean", "None", "Keyword", "Symbol"))
_NO_PARTS = frozenset(("Integer", "Float", "String", "Function", "Boolean", "None", "Matrix", "Vector", "Keyword"))
_SEQUENCE = "a list or another sequence"

# Arguments that may have several types: the position, the tags that always fail, and the expected value for messages.
_REJECTED: dict[str, tuple[int, frozenset[str], str]] = {
    **dict.fromkeys(("first", "second", "third", "fourth", "fifth", "rest", "take", "drop"), (0, _NO_SEQUENCE,
                                                                                              _SEQUENCE)),
    "ref": (0, _NO_SEQUENCE, "a list, array, table, record or embedding"),
    "choice": (0, _NO_SEQUENCE - {"Integer", "Float"}, "a sequence or a number"),
    **dict.fromkeys(("min", "max"), (0, _NO_SEQUENCE - {"Integer", "Float"}, "numbers or a sequence")),
    "scale": (0, _NO_ARRAY - {"Integer", "Float"} | {"Matrix"}, "one or three numbers"),
    **dict.fromkeys(("parts", "primitives"), (0, _NO_PARTS, "an Entity, a pair or a list of these")),
    "map-parts": (1, _NO_PARTS, "an Entity, a pair or a list of these"),
    "embedding": (0, _NO_PARTS - {"String", "Keyword"} | {"Entity"}, "a handle, a text or attributes"),
    "pose": (0, _NO_ARRAY | {"Vector"}, "a Matrix"),
    **dict.fromkeys(("inverse", "determinant"), (0, _NO_ARRAY | {"Vector"}, "a square matrix")),
    "@": (0, _NO_ARRAY, "arrays"),
    **dict.fromkeys(("sum", "product"), (0, frozenset(("String",)), "a sequence of numbers")),
}  # fmt: skip


def need_of_argument(
    inference: KindInference, builtin: Builtin, index: int, parameter: BuiltinParameter, argument: Any
) -> None:
    """Record the type that a builtin requires of an argument of unknown kind.

    Parameters
    ----------
    index, parameter
        Number of the argument among the positional ones, and the parameter that takes it.
    argument
        Expression that is passed.
    """
    type_: Type = parameter.type
    place = f"passed to `{builtin.name}`"
    if index in TRIPLES.get(builtin.name, ()) and builtin.name != "scale":
        type_ = BASE_TYPES["Point"]
    rejected = _REJECTED.get(builtin.name)
    if rejected is not None and (rejected[0] == index or builtin.name == "@"):
        inference.need(argument, place, (), rejected[2], rejects=rejected[1])
    else:
        inference.need(argument, place, (type_,), expected_name(type_.name))


def _check_rejected(
    inference: KindInference,
    node: Any,
    builtin: Builtin,
    rejected: tuple[int, frozenset[str], str],
    nodes: Sequence[Any],
    kinds: Sequence[Kind],
) -> bool:
    """Check an argument whose type the registry leaves open."""
    position, tags, expected = rejected
    name = builtin.name
    for index, (argument, kind) in enumerate(zip(nodes, kinds)):
        if index != position and not (name == "@" and index > position):
            continue
        if name == "@" and len(nodes) == 1:
            continue
        if kind is ANY or not {option.tag for option in kind.options} <= tags:
            continue
        hint, fixes = advice_on_value(argument, "Number")
        if name == "ref" and len(nodes) == 2 and accepts("Sequence", kinds[1]) and kinds[1] is not ANY:
            hint = f"the sequence comes first: `(ref {nodes[1].span.text} {argument.span.text})`"
            fixes = swap_fix(node, argument, nodes[1])[1] if accepts("Integer", kind) else ()
        elif name == "@" and index > 0:
            hint = "a pose is scaled by `(scale n)`"
        inference.report(
            "parts" if tags is _NO_PARTS else "type", f"`{name}` expects {expected}, got {shown(argument, kind)}",
            node.span, hint or builtin.call_hint, fixes=fixes, expected=expected,
            found=describe(kind), signature=builtin.usage,
        )  # fmt: skip
        return False
    return True


# Functions that are cheap and pure, and not defined for all arguments of their types: the check calls them.
_EVALUATED = frozenset(("sqrt", "log", "log2", "log10", "asin", "acos", "substring", "normalize", "cross"))


class _Uncharged:
    """Runtime for calls of builtins with literals, which does not count steps."""

    @staticmethod
    def charge(steps: int) -> None: ...


def _check_domain(inference: KindInference, node: Any, builtin: Builtin, nodes: Sequence[Any]) -> bool:
    """Call a builtin if all arguments are known, and report the error if it fails."""
    values: list[Any] = []
    for argument in nodes:
        is_text = type(argument) is ast.Constant and type(argument.value) is str
        value: Any = argument.value if is_text else inference.number_of(argument)
        if type(argument) is ast.ArrayLiteral:
            items = [inference.number_of(item) for item in argument.items]
            value = Vector([item for item in items if item is not None]) if None not in items else None
        if value is None:
            if len(nodes) == 1 and builtin.signature.required[0].type.name == "Numeric":
                inference.need(argument, f"passed to `{builtin.name}`", (), "in the domain of the function", "domain",
                               fails=lambda number: _failure(builtin, [number]) is not None)  # fmt: skip
            return True
        values.append(int(value) if type(value) is float and value.is_integer() else value)
    error = _failure(builtin, values)
    if error is None:
        return True
    inference.report(error.name, error.message, node.span, error.hint or builtin.call_hint,
                     signature=builtin.usage)  # fmt: skip
    return False


def _failure(builtin: Builtin, values: Sequence[Any]) -> SceneError | None:
    """Return the error of a call of a builtin, or None if it succeeds."""
    try:
        builtin.function(_Uncharged, *values)
    except SceneError as error:
        return error
    except (ArithmeticError, ValueError):
        pass
    return None


def _check_scale(inference: KindInference, node: Any, name: str, nodes: Sequence[Any], kinds: Sequence[Kind]) -> bool:
    """Warn about a scale of 0."""
    if inference.number_of(nodes[0]) == 0 and node.span.expansion is None:
        inference.warn("out-of-range", "a scale of 0 shrinks the part to a point", node.span,
                       expected="a factor other than 0", found="0")  # fmt: skip
    return True


def _check_range(inference: KindInference, node: Any, name: str, nodes: Sequence[Any], kinds: Sequence[Kind]) -> bool:
    """Warn about a range that is empty because its step leads away from its end."""
    start, end = map(number_of, nodes[:2]) if len(nodes) > 1 else (None, None)
    step = number_of(nodes[2]) if len(nodes) > 2 else 1
    if step == 0:
        inference.report("value", "`range` expects a step that is not 0", node.span, expected="a step other than 0",
                         found="0")  # fmt: skip
        return False
    if start is None or end is None or not step or (end - start) * step >= 0 or node.span.expansion is not None:
        return True
    first, last = nodes[0].span.text, nodes[1].span.text
    hint = f"count down with `(range {first} {last} -1)`" if step == 1 else "the step has the wrong sign"
    inference.warn("out-of-range", f"the range from {first} to {last} is empty", node.span, hint,
                   expected="an end in the direction of the step", found=node.span.text)  # fmt: skip
    return True


def _check_extremes(
    inference: KindInference, node: Any, name: str, nodes: Sequence[Any], kinds: Sequence[Kind]
) -> bool:
    """Check that several arguments of ``min`` or ``max`` are numbers or arrays; a single one may be any sequence."""
    for argument, kind in zip(nodes, kinds):
        if not accepts("Numeric", kind):
            hint = f"for strings and lists, use `{name}-of`" if kind.tag == "String" else None
            inference.report(
                "type", f"`{name}` expects numbers, got {shown(argument, kind)}", node.span, hint,
                expected="numbers or arrays", found=describe(kind),
            )  # fmt: skip
            return False
    return True


def _check_shapes(inference: KindInference, node: Any, name: str, nodes: Sequence[Any], kinds: Sequence[Kind]) -> bool:
    """Check that vectors that are combined item by item have one length; length 1 is broadcast, as in numpy."""
    known_lengths = (length_of(kind) for kind in kinds if kind.tag == "Vector")
    lengths = {length for length in known_lengths if length not in (None, 1)}
    if MATRIX in kinds and name in ("+", "-", "*", "/", "dot") and lengths and lengths != {4}:
        vector = f"a Vector of {next(iter(lengths))} numbers"
        hint = "poses are composed by `@`: `(@ (translate [x y z]) pose)`"
        inference.report("value", f"`{name}` cannot broadcast a matrix and {vector}", node.span, hint,
                         expected="arrays of one shape", found=vector)  # fmt: skip
        return False
    if len(lengths) > 1 and all(kind.tag in ("Vector", "Integer", "Float") for kind in kinds):
        shapes = " and ".join(f"({length_of(kind)})" for kind in kinds if kind.tag == "Vector")
        verb = "multiply" if name == "dot" else "broadcast"
        inference.report("value", f"`{name}` cannot {verb} arrays of the shapes {shapes}", node.span,
                         "the arrays need the same length", expected="arrays of one length", found=shapes)  # fmt: skip
        return False
    if name == "*" and sum(kind is MATRIX for kind in kinds) > 1:
        head = node.function.span
        fixes = (Fix("Write `@`", (Edit(head, "@"),), safe=True),) if head.expansion is None else ()
        inference.warn("elementwise-poses", "`*` multiplies two matrices item by item", node.span,
                       "`@` composes poses: the last applies first", fixes)  # fmt: skip
    return True


def _check_direction(inference: KindInference, vector: Any, message: str, hint: str) -> bool:
    """Check that a literal vector that gives a direction is not zero."""
    if type(vector) is not ast.ArrayLiteral or not vector.items or not all(map(_is_zero, vector.items)):
        return True
    inference.report("value", message, vector.span, hint, expected="a non-zero Vector", found=vector.span.text)
    return False


def _check_counted(inference: KindInference, node: Any, name: str, nodes: Sequence[Any], kinds: Sequence[Kind]) -> bool:
    """Check that a count is not negative."""
    count = inference.number_of(nodes[0])
    if count is None or count >= 0:
        return True
    inference.report("value", f"`{name}` expects a count that is not negative, got {count:g}", node.span,
                     expected="a count that is not negative", found=f"{count:g}")  # fmt: skip
    return False


def _check_drawn(inference: KindInference, node: Any, name: str, nodes: Sequence[Any], kinds: Sequence[Kind]) -> bool:
    """Check the limits of a random integer."""
    limits = [inference.number_of(limit) for limit in nodes]
    if None in limits:
        return True
    low, high = (0.0, limits[0]) if len(limits) == 1 else limits[:2]
    assert low is not None
    assert high is not None
    if low < high or (name == "py-randint" and low == high):
        return True
    message = f"`{name}` expects a range that is not empty, got {low:g} up to {high:g}"
    inference.report("value", message, node.span, expected="a lower limit below the upper one",
                     found=f"{low:g} and {high:g}")  # fmt: skip
    return False


def _check_nonempty(
    inference: KindInference, node: Any, name: str, nodes: Sequence[Any], kinds: Sequence[Kind]
) -> bool:
    """Check that a single sequence has an item."""
    if len(nodes) > 1 or kinds[0].items != () or kinds[0].tag not in ("List", "Vector"):
        return True
    inference.report("index", f"`{name}` expects a sequence with at least one item, got an empty one", node.span,
                     expected="at least one item", found="0 items")  # fmt: skip
    return False


def _check_sorted(inference: KindInference, node: Any, name: str, nodes: Sequence[Any], kinds: Sequence[Kind]) -> bool:
    """Check that the items of a list that is sorted without a key can be compared."""
    items = kinds[0].items or ()
    orders = {"number" if item.tag == "Float" or item is INTEGER else item.tag for item in items}
    if len(node.arguments) > 1 or len(orders) < 2 or not orders <= {"number", "String"}:
        return True
    inference.report("type", "cannot compare a number and a String", node.span,
                     "sort by a key: `:key (lambda (x) ...)`", expected="items of one kind",
                     found="numbers and Strings")  # fmt: skip
    return False


def _check_radians(inference: KindInference, node: Any, name: str, nodes: Sequence[Any], kinds: Sequence[Kind]) -> bool:
    """Check the angle and the axis of a rotation."""
    angle = nodes[0]
    if called_builtin(angle) == "to-degrees" and angle.function.span.expansion is None:
        fix = Fix("Write `deg`", (Edit(angle.function.span, "deg"),), safe=True)
        inference.warn("out-of-range", f"`to-degrees` gives degrees, but `{name}` takes radians", angle.span,
                       "degrees are converted by `deg`", (fix,), expected="an angle in radians",
                       found="degrees")  # fmt: skip
    if name != "rotate" or len(nodes) == 1:
        return True
    message = "`rotate`: the rotation axis must be a finite non-zero vector"
    return _check_direction(inference, nodes[1], message, "the axes are `[1 0 0]`, `[0 1 0]` and `[0 0 1]`")


def _check_normal(inference: KindInference, node: Any, name: str, nodes: Sequence[Any], kinds: Sequence[Kind]) -> bool:
    """Check that the normal of a reflection is not zero."""
    message = "`reflect`: the normal of a reflection must be a finite non-zero vector"
    return _check_direction(inference, nodes[-1], message, "the plane x = 0 has the normal `[1 0 0]`")


def _check_product(inference: KindInference, node: Any, name: str, nodes: Sequence[Any], kinds: Sequence[Kind]) -> bool:
    """Check the shapes of a matrix product: only the last factor may be a vector of three numbers."""
    for index, (left, right) in enumerate(pairwise(kinds)):
        length = length_of(left) if left.tag == "Vector" else None
        if length in (None, 4) or right is not MATRIX:
            continue
        hint = "a vector becomes a pose with `(translate [x y z])`" if length == 3 else None
        fixes = (wrap_fix(nodes[index], "translate"),) if hint and nodes[index].span.expansion is None else ()
        inference.report("value", f"`@` cannot multiply a Vector of {length} numbers by a matrix", nodes[index].span,
                         hint, fixes=fixes, expected="a Matrix", found=describe(left))  # fmt: skip
        return False
    return True


def _check_pairs(inference: KindInference, node: Any, name: str, nodes: Sequence[Any], kinds: Sequence[Kind]) -> bool:
    """Check that every key of ``(table key value ...)`` has a value."""
    if len(nodes) % 2 == 0 or len(nodes) < len(node.arguments):
        return True
    inference.report("arity", f"`table` expects a value after every key, got {plural(len(nodes), 'argument')}",
                     nodes[-1].span, f"the key {nodes[-1].span.text} has no value" if nodes[-1].span.expansion is None
                     else None, expected="an even number of arguments", found=str(len(nodes)))  # fmt: skip
    return False


def _check_frames(inference: KindInference, node: Any, name: str, nodes: Sequence[Any], kinds: Sequence[Kind]) -> bool:
    """Check the items of the list of ``frames``."""
    kind = kinds[-1]
    items = kind.items if kind.items is not None else (item_of(kind),)
    culprit = next((item for item in items if not may_be_parts(item)), None) if kind.tag == "List" else None
    if culprit is None:
        return True
    message = f"the items of `frames` must be entities or parts, got {describe(culprit)}"
    inference.report("parts", message, nodes[-1].span, always=kind.items is not None, expected=A_PART,
                     found=describe(culprit))  # fmt: skip
    return False


def _check_applied(inference: KindInference, node: Any, name: str, nodes: Sequence[Any], kinds: Sequence[Kind]) -> bool:
    """Check the last argument of ``apply``."""
    if accepts("Sequence", kinds[-1]):
        return True
    inference.report("type", f"`apply` expects a list, got {shown(nodes[-1], kinds[-1])}", node.span,
                     "put the arguments into a list: `(apply f (list a b))`", expected="a List",
                     found=describe(kinds[-1]))  # fmt: skip
    return False


_ORDINALS = {"first": 1, "second": 2, "third": 3, "fourth": 4, "fifth": 5, "last": 1}


def _check_ordinal(inference: KindInference, node: Any, name: str, nodes: Sequence[Any], kinds: Sequence[Kind]) -> bool:
    """Return whether a sequence may be long enough for ``first``, ``second`` and so on; report one that is too short.

    Only lists and vectors have a length that is known without running the program.
    """
    length = length_of(kinds[0]) if kinds[0].tag in ("List", "Vector") else None
    if length is None or length >= _ORDINALS[name]:
        return True
    expected = f"at least {plural(_ORDINALS[name], 'item')}"
    message = f"`{name}` expects {expected}, got {shown(nodes[0], kinds[0])}"
    inference.report("index", message, node.span, expected=expected, found=str(length))
    return False


def _check_rgb(inference: KindInference, node: Any, name: str, nodes: Sequence[Any], kinds: Sequence[Kind]) -> bool:
    """Warn about components of ``rgb`` from 0 to 1, which are expected from 0 to 255."""
    values = [number_of(argument) for argument in nodes]
    known = [value for value in values if value is not None]
    if len(known) == len(values) == 3 and 0 < max(known) <= 1 and min(known) >= 0 and node.span.expansion is None:
        written = f"[{' '.join(argument.span.text for argument in nodes)}]"
        inference.warn(
            "out-of-range", f"the components of `rgb` go from 0 to 255, got {written[1:-1]}", node.span,
            f"a color with components from 0 to 1 is written `{written}`",
            (Fix(f"Write `{written}`", (Edit(node.span, written),)),), expected="components from 0 to 255",
            found=written[1:-1],
        )  # fmt: skip
    return True


def _warn_of_hue(inference: KindInference, hue: Any) -> bool:
    """Warn about a hue that is the index of a loop, or a multiple of it, instead of a share of 1."""
    end = truths.end_of_index(inference, hue)
    step = 1 if end is not None else _step_of(inference, hue)
    if step is None or abs(step) < 1:
        return False
    numbers = "whole numbers" if end is not None else f"multiples of {step:g}"
    message = f"the hue of `hsv` goes from 0 to 1, got {numbers}; whole numbers are all red"
    written = f"(/ {hue.span.text} {end or 360})"
    hint = f"{'once around' if end else 'from degrees'}: `{written}`"
    fix = Fix(f"Write `{written}`", (Edit(hue.span, written),))
    inference.warn("out-of-range", message, hue.span, hint, (fix,), expected="0 to 1", found=hue.span.text)
    return True


def _check_hsv(inference: KindInference, node: Any, name: str, nodes: Sequence[Any], kinds: Sequence[Kind]) -> bool:
    """Warn about a component of ``hsv`` outside 0 to 1."""
    if node.span.expansion is None:
        if _warn_of_hue(inference, nodes[0]):
            return True
        for parameter, value in zip(("hue", "saturation", "value"), map(inference.number_of, nodes)):
            if value is not None and not 0 <= value <= 1:
                message = f"the {parameter} of `hsv` goes from 0 to 1, got {value:g}"
                hint = f"degrees are divided by 360: `(/ {nodes[0].span.text} 360)`" if parameter == "hue" else None
                inference.warn("out-of-range", message, node.span, hint, expected="0 to 1", found=f"{value:g}")
                break
    return True


# Checks of single functions, after those that ``check_values`` makes for all.
_FURTHER: dict[str, Callable[..., bool]] = {
    **dict.fromkeys(("+", "-", "*", "/", "dot", "distance"), _check_shapes),
    **dict.fromkeys(("rotate", "sin", "cos", "tan"), _check_radians), "iota": _check_counted, "choice": _check_nonempty,
    **dict.fromkeys(("randint", "py-randint", "py-randrange"), _check_drawn), "sort": _check_sorted,
    **dict.fromkeys(("min", "max"), _check_nonempty),
    "apply": _check_applied, "frames": _check_frames, **dict.fromkeys(_ORDINALS, _check_ordinal),
    "rgb": _check_rgb, "hsv": _check_hsv, "reflect": _check_normal, "@": _check_product, "table": _check_pairs,
    "scale": _check_scale, "range": _check_range,
}  # fmt: skip


def _zero_hint(inference: KindInference, node: Any, divisors: Sequence[Any]) -> str | None:
    """Return the hint for a division by an expression that is 0: why it is, and the division that avoids it."""
    divisor = next(each for each in divisors if inference.number_of(each) == 0)
    text, whole = divisor.span.text, node.span.text
    if type(divisor) is ast.Constant or node.span.expansion is not None or len(whole) > MAX_SHOWN:
        return "divide by another number" if type(divisor) is ast.Constant else None
    values = {part.span.text: inference.number_of(part) for part in walk(divisor) if type(part) is ast.Reference}
    known = [f"`{name}` is {value:g}" for name, value in values.items() if value is not None and name != text]
    because = f", because {' and '.join(known)}" if known else ""
    return f"`{text}` is 0{because}: treat that case apart, `(if (= {text} 0) 0 {whole})`"


def _check_triple(
    inference: KindInference, node: Any, builtin: Builtin, position: int, nodes: Sequence[Any], kinds: Sequence[Kind]
) -> bool:
    """Check that a point or direction has three numbers."""
    parameters = (*builtin.signature.required, *builtin.signature.optional)
    kind = kinds[position]
    if type(nodes[position]) is ast.ArrayLiteral:
        inference.need_numbers(nodes[position], f"a component of what is passed to `{builtin.name}`")
    length = length_of(kind) if kind.tag in ("Vector", "List") else None
    if length is None or length == 3:
        return True
    hint, fixes = triple_fix(nodes[position])
    inference.report(
        "value", f"`{builtin.name}` expects three numbers for `{parameters[position].name}`, got {length}",
        nodes[position].span if type(nodes[position]) is ast.ArrayLiteral else node.span,
        hint or builtin.call_hint, fixes=fixes, expected="a Vector of 3 numbers", found=describe(kind),
        signature=builtin.usage,
    )  # fmt: skip
    return False


def _check_mutable(inference: KindInference, node: Any, name: str, argument: Any, kind: Kind) -> bool:
    """Check that the argument that a procedure changes is mutable."""
    tags = {option.tag for option in kind.options}
    if kind is ANY or tags & MUTATED[name]:
        return True
    if tags <= IMMUTABLE:
        described = describe(kind)
        twin = "mutable-array" if tags <= {"Vector", "Array", "Matrix"} else "mutable-list"
        hint = f"create it with `({twin} ...)`, or copy it with `(mutable x)`"
        inference.report("immutable", f"`{name}` cannot change {described}", node.span, hint, expected=f"a {twin}",
                         found=described)  # fmt: skip
        return False
    expected = " or ".join(describe(Kind(tag)) for tag in sorted(MUTATED[name]))
    inference.report("type", f"`{name}` expects {expected}, got {shown(argument, kind)}", node.span, expected=expected,
                     found=describe(kind))  # fmt: skip
    return False


_CXR = lazy_pattern(r"c[ad]{1,4}r")


def _check_cxr(inference: KindInference, node: Any, name: str, argument: Any, kind: Kind) -> bool:
    """Check ``car``, ``cdr`` and their compositions, from the innermost operation on."""
    for letter in reversed(name[1:-1]):
        if kind is ANY or len(kind.options) > 1:
            return True
        if kind.tag not in PAIRS:
            inference.report(
                "type", f"`{name}` expects a pair or a list, got {shown(argument, kind)}", node.span,
                expected="a pair or a list", found=describe(kind),
            )  # fmt: skip
            return False
        if kind.items == ():
            list_kind = inference.result.kinds[argument]
            inference.report("index", f"`{name}` expects a longer list, got {shown(argument, list_kind)}", node.span,
                             expected="a longer list", found=f"{length_of(list_kind)} items")  # fmt: skip
            return False
        kind = result_of_pair(letter, kind)
    return True


def _is_zero(node: Any) -> bool:
    """Return whether an expression is a literal zero."""
    return number_of(node) == 0.0


def _near_fixes(error: SceneError, nodes: Sequence[Any]) -> tuple[Fix, ...]:
    """Return fixes that replace a misspelled string by the names that the error suggests."""
    if len(nodes) != 1 or nodes[0].span.expansion is not None:
        return ()
    is_safe = len(error.near) == 1
    return tuple(Fix(f'Change to "{near}"', (Edit(nodes[0].span, f'"{near}"'),), is_safe) for near in error.near)


_DIVISIONS = frozenset(("/", "//", "%", "modulo", "quotient", "remainder", "floor/", "truncate/"))
_INDEXED = {"ref": (0, 1), "list-ref": (0, 1), "vector-ref": (0, 1), "string-ref": (0, 1)}


def _check_index(inference: KindInference, node: Any, name: str, sequence: Any, kind: Kind, index: Any) -> bool:
    """Check an index into a sequence: its type, and its range if both length and index are known."""
    length = length_of(kind) if kind.tag in ("List", "Vector") else None
    if type(sequence) is ast.Constant and type(sequence.value) is str:
        length = len(sequence.value)
    value = inference.number_of(index)
    index_kind = inference.result.kinds[index]
    is_indexed = kind.tag in ("List", "Vector", "Matrix", "Array", "String")
    if is_indexed and index_kind.tag in ("String", "Keyword", "Symbol", "Function", "Boolean", "None", "Entity"):
        inference.report("type", f"`{name}` expects an Integer as the index, got {shown(index, index_kind)}", node.span,
                         "indices start at 0", expected="an Integer", found=describe(index_kind))  # fmt: skip
        return False
    if kind is EMBEDDING and index_kind is INTEGER:
        message = f"`ref` expects the name of an attribute, such as `:size`, got {shown(index, index_kind)}"
        inference.report("type", message, node.span, expected="a keyword", found="an Integer")
        return False
    if length is None or value is None or not value.is_integer():
        return True
    lowest = -length if name == "ref" else 0
    if not lowest <= value < length:
        collection = "string" if type(sequence) is ast.Constant and type(sequence.value) is str else kind.tag.lower()
        inference.report(
            "index", f"index {int(value)} is outside the {collection} of length {length}", node.span,
            f"indices start at 0, so the last one is {length - 1}" if length else None,
            expected=f"0 to {length - 1}" if length else "no index", found=str(int(value)),
        )  # fmt: skip
        return False
    return True


def _step_of(inference: KindInference, node: Any) -> float | None:
    """Return the number by which an index is multiplied: ``30`` of ``(* i 30)``."""
    if called_builtin(node) != "*" or len(node.arguments) != 2:
        return None
    for factor, index in (node.arguments, reversed(node.arguments)):
        if inference.result.kinds.get(index, ANY) is INTEGER and inference.number_of(index) is None:
            return inference.number_of(factor)
    return None


def check_angle(inference: KindInference, node: Any) -> None:
    """Warn about a constant angle of more than two turns, which is certainly meant in degrees."""
    value = inference.number_of(node)
    step = _step_of(inference, node) if value is None else None
    value = step if value is None else value
    if value is None:
        inference.need(node, "an angle", (), "an angle in radians", "out-of-range",
                       fails=lambda angle: abs(angle) > 2 * TURN)  # fmt: skip
    if value is None or abs(value) <= 2 * TURN or node.span.expansion is not None:
        return
    text = node.span.text
    subject = text if step is None else f"each step of `{text}`"
    inference.warn(
        "out-of-range", f"angles are in radians, and {subject} is {abs(value) / TURN:.0f} turns", node.span,
        f"convert degrees: `(deg {text})`", (Fix("Convert from degrees", (Edit(node.span, f"(deg {text})"),)),),
        expected="an angle in radians", found=text,
    )  # fmt: skip
