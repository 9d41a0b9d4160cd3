"""Kinds of values: static knowledge about a value, such as "an Integer" or "a Vector of 3 numbers".

Kinds form a lattice, as in abstract interpretation (Cousot and Cousot, POPL 1977). ``ANY`` is the top: nothing is
known. ``NEVER`` is the bottom: there is no value, because the expression always raises or escapes. In between are kinds
with one tag, which is the type that the runtime reports, and unions of kinds with different tags. A kind
over-approximates: a value can only have a tag that its kind has.

The compiler infers kinds of variables to write arithmetic without type tests (``generated``); the checker infers those
of all expressions to report mistakes (``interpreter/checker/infer``).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import Any

from scenelang.interpreter.values.values import NIL, Array, Embedding, Keyword, Matrix, Pair, Symbol, Vector

MAX_ITEMS = 64  # items whose kinds are kept one by one; a longer sequence has a common kind of its items
_MAX_TAGS = 8  # kinds in a union; a larger union is ANY
_MAX_DEPTH = 6  # levels of nested items, so that the kinds of recursive data are finite; deeper items are ANY
MAX_LITERAL_BITS = 60  # of an Integer that generated code contains as a literal, and whose size is known as a bound


class Kind:
    """One kind, or a union of several. Kinds are immutable.

    Attributes
    ----------
    tag
        ``Any``, ``Never``, ``Union``, or the name of one type of value.
    items
        Kinds of the items of a list or array, one by one, if their number is known.
    item
        Common kind of the items; of a function, the kind of its result.
    code
        Of a function, its definition: an ``ast.Lambda``, a ``Builtin`` or a ``RecordCode``; of a record, its name.
    options
        Members of a union, with distinct tags; of any other kind, the kind itself.
    bits
        Of an Integer, an upper bound of the bits of its magnitude; 0 if none is known. Only the compiler sets it.
    """

    __slots__ = ("bits", "code", "item", "items", "options", "tag")

    def __init__(
        self,
        tag: str,
        items: tuple[Kind, ...] | None = None,
        item: Kind | None = None,
        code: Any = None,
        options: tuple[Kind, ...] = (),
        bits: int = 0,
    ) -> None:
        self.tag = tag
        self.items = items
        self.item = item
        self.code = code
        self.options = options or (self,)
        self.bits = bits

    def __eq__(self, other: object) -> bool:
        if self is other:
            return True
        if not isinstance(other, Kind) or self.tag != other.tag or self.code is not other.code:
            return False
        if self.bits != other.bits:
            return False
        if self.tag == "Union":
            return self.options == other.options
        return self.items == other.items and self.item == other.item

    def __hash__(self) -> int:
        return hash((self.tag, self.items and len(self.items)))

    def __repr__(self) -> str:
        return f"<Kind {describe(self)}>"


ANY = Kind("Any")
NEVER = Kind("Never")
INTEGER = Kind("Integer")
FLOAT = Kind("Float")
BOOLEAN = Kind("Boolean")
NONE = Kind("None")
STRING = Kind("String")
SYMBOL = Kind("Symbol")
KEYWORD = Kind("Keyword")
MATRIX = Kind("Matrix")
ENTITY = Kind("Entity")
EMBEDDING = Kind("Embedding")
PART = Kind("Part")
TABLE = Kind("Table")
SET = Kind("Set")
STREAM = Kind("Stream")
FRAMES = Kind("Frames")
ERROR = Kind("Error")
HANDLES = Kind("Handles")
FUNCTION = Kind("Function")
LIST = Kind("List")
EMPTY = Kind("List", ())
PAIR = Kind("Pair")
VECTOR = Kind("Vector")
ARRAY = Kind("Array")
MUTABLE_LIST = Kind("MutableList")
MUTABLE_ARRAY = Kind("MutableArray")
RECORD = Kind("Record")


def union_of(options: Iterable[Kind]) -> Kind:
    """Return the union of kinds with distinct tags, in the order of the tags."""
    members = sorted(options, key=lambda kind: kind.tag)
    if not members:
        return NEVER
    if len(members) == 1:
        return members[0]
    return ANY if len(members) > _MAX_TAGS else Kind("Union", options=tuple(members))


NUMBER = union_of((INTEGER, FLOAT))
ARRAYS = union_of((VECTOR, MATRIX, ARRAY, MUTABLE_ARRAY))
NUMERIC = union_of((*NUMBER.options, *ARRAYS.options))
MAYBE_LIST = union_of((LIST, BOOLEAN))
CONS = union_of((LIST, PAIR, PART))
PARTS = Kind("List", None, PART)
_NUMBER_TAGS = ("Integer", "Float")


def is_number(kind: Kind) -> bool:
    """Return whether a value is certainly a number."""
    return all(option.tag in _NUMBER_TAGS for option in kind.options)


def may_be(kind: Kind, tag: str) -> bool:
    """Return whether a value may have the type ``tag``."""
    return kind is ANY or any(option.tag == tag for option in kind.options)


def integer_of(bits: int) -> Kind:
    """Return the kind of an Integer whose magnitude has at most ``bits`` bits; 0 means that no bound is known."""
    return Kind("Integer", bits=bits) if bits else INTEGER


def without_bits(kind: Kind) -> Kind:
    """Return a kind without the bound of an Integer, for iterations to a fixpoint, where the bound would grow."""
    if kind.tag == "Integer":
        return INTEGER
    return union_of(map(without_bits, kind.options)) if kind.tag == "Union" else kind


def join(a: Kind, b: Kind) -> Kind:
    """Return the smallest kind that contains all values of the kinds ``a`` and ``b``."""
    if a is b or b is NEVER:
        return a
    if a is NEVER:
        return b
    if a is ANY or b is ANY:
        return ANY
    if a.tag == b.tag != "Union":
        return _merged(a, b)
    by_tag = {kind.tag: kind for kind in a.options}
    for kind in b.options:
        known = by_tag.get(kind.tag)
        by_tag[kind.tag] = kind if known is None else _merged(known, kind)
    return union_of(by_tag.values())


def join_all(kinds: Iterable[Kind]) -> Kind:
    """Return the smallest kind that contains all values of ``kinds``; NEVER if it is empty."""
    result = NEVER
    for kind in kinds:
        result = join(result, kind)
        if result is ANY:
            break
    return result


def _merged(a: Kind, b: Kind) -> Kind:
    """Join two kinds with the same tag."""
    if a is b or a == b:
        return a
    if a.tag == "Integer":
        return integer_of(max(a.bits, b.bits) if a.bits and b.bits else 0)
    items = None
    if a.items is not None and b.items is not None and len(a.items) == len(b.items):
        items = tuple(map(join, a.items, b.items))
    code = a.code if a.code is b.code else None
    if a.tag == "Function":
        known = a.item is not None and b.item is not None
        return Kind(a.tag, None, join(a.item, b.item) if known else None, code)  # type: ignore[arg-type]
    return Kind(a.tag, items, None if items is not None else join(item_of(a), item_of(b)), code)


def item_of(kind: Kind) -> Kind:
    """Return the common kind of the items of one kind of sequence; NEVER if it has none."""
    if kind.items is not None:
        return join_all(kind.items)
    return kind.item if kind.item is not None else _ITEMS.get(kind.tag, ANY)


_ITEMS = {"Vector": NUMBER, "String": STRING, "Matrix": VECTOR}


def list_of(items: Sequence[Kind]) -> Kind:
    """Return the kind of a list with these items."""
    if len(items) > MAX_ITEMS:
        return Kind("List", None, join_all(items))
    return _shallow(Kind("List", tuple(items)))


def list_with(item: Kind) -> Kind:
    """Return the kind of a list of unknown length; ``item`` is NEVER if it is empty."""
    return EMPTY if item is NEVER else _shallow(Kind("List", None, item))


def pair_of(first: Kind, rest: Kind) -> Kind:
    """Return the kind of a pair whose rest is not a list."""
    return _shallow(Kind("Pair", (first, rest)))


def _shallow(kind: Kind, depth: int = 0) -> Kind:
    """Replace items nested deeper than ``_MAX_DEPTH`` by ANY."""
    if (kind.items is None and kind.item is None) or kind.tag == "Function":
        return kind
    if depth == _MAX_DEPTH:
        return Kind(kind.tag)
    if kind.items is not None:
        items = tuple(_shallow(item, depth + 1) for item in kind.items)
        return kind if all(map(_is, items, kind.items)) else Kind(kind.tag, items, None, kind.code)
    item = _shallow(item_of(kind), depth + 1)
    return kind if item is kind.item else Kind(kind.tag, None, item, kind.code)


def _is(a: Any, b: Any) -> bool:
    return a is b


_CONSTANTS: dict[type, Kind] = {
    int: INTEGER, float: FLOAT, bool: BOOLEAN, str: STRING, type(None): NONE, Symbol: SYMBOL, Keyword: KEYWORD,
    Embedding: EMBEDDING, Matrix: MATRIX, Array: ARRAY,
}  # fmt: skip
_COMPOUND: dict[type, Kind] = {Vector: VECTOR, Pair: CONS, type(NIL): EMPTY}


def kind_of_value(value: Any, depth: int = 0) -> Kind:
    """Return the kind of a constant, such as a quoted list; ``depth`` is its level in nested items."""
    known = _CONSTANTS.get(type(value))
    if known is not None:
        return known
    if type(value) is Vector:
        return vector_of(len(value), all(type(item) is int for item in value))
    if value is NIL:
        return EMPTY
    if type(value) is Pair:
        if depth == _MAX_DEPTH:
            return LIST if _is_proper(value) else PAIR
        items: list[Kind] = []
        while type(value) is Pair and len(items) <= MAX_ITEMS:
            items.append(kind_of_value(value.car, depth + 1))
            value = value.cdr
        if type(value) is Pair:
            return Kind("List") if _is_proper(value) else PAIR
        return list_of(items) if value is NIL else PAIR
    return ANY


def _is_proper(value: Any) -> bool:
    """Return whether a chain of pairs ends in the empty list (a proper list of R7RS, section 6.4)."""
    while type(value) is Pair:
        value = value.cdr
    return value is NIL


def kind_of_operand(value: Any) -> Kind:
    """Return the kind of a constant for generated code: its tag, and the bits of a small Integer.

    Items are left out, because generated code has no use for them and quoted lists can be long.
    """
    if type(value) is int:
        bits = value.bit_length()
        return integer_of(max(1, bits) if bits <= MAX_LITERAL_BITS else 0)
    return ANY if value is None else _CONSTANTS.get(type(value)) or _COMPOUND.get(type(value), ANY)


def vector_of(length: int, integers: bool = False) -> Kind:
    """Return the kind of a Vector of ``length`` numbers."""
    if length > MAX_ITEMS:
        return VECTOR
    return Kind("Vector", (INTEGER if integers else NUMBER,) * length)


def length_of(kind: Kind) -> int | None:
    """Return the number of items of a list or vector, if it is known."""
    return len(kind.items) if kind.items is not None else None


def is_truthy(kind: Kind) -> bool | None:
    """Return the truth of a value in a test, or None if it may vary: only ``#f`` and ``none`` are false."""
    if kind is ANY or kind is NEVER:
        return None
    tags = {option.tag for option in kind.options}
    if tags == {"None"}:
        return False
    return None if tags & {"Boolean", "None"} else True


def without_falsy(kind: Kind) -> Kind:
    """Return the kind of a value that passed a test."""
    if kind is ANY:
        return ANY
    return union_of(option for option in kind.options if option.tag != "None")


# --- messages ---------------------------------------------------------------------------------------------------------

_NAMES = {
    "Integer": "an Integer", "Float": "a Float", "Boolean": "a Boolean", "None": "`none`", "String": "a String",
    "Symbol": "a symbol", "Keyword": "a keyword", "List": "a List", "Pair": "a pair", "Part": "a posed entity",
    "Vector": "a Vector", "Matrix": "a Matrix", "Array": "an Array", "MutableArray": "a mutable array",
    "MutableList": "a mutable list", "Table": "a table", "Set": "a set", "Stream": "a random stream",
    "Embedding": "an Embedding", "Entity": "an Entity", "Frames": "frames", "Error": "an error",
    "Handles": "the root's list of handles", "Function": "a Function", "Record": "a record", "Any": "any value",
    "Never": "no value",
}  # fmt: skip


def describe(kind: Kind) -> str:
    """Return a kind with its article: ``a Vector of 2 numbers``, ``an Integer or a String``."""
    return " or ".join(_described(kind))


def _described(kind: Kind) -> Iterator[str]:
    """Iterate over the alternatives of a kind; Integer and Float read as "a number", several arrays as "an array"."""
    tags = {option.tag for option in kind.options}
    grouped: set[str] = set()  # tags that one of these words covers
    if tags >= {"Integer", "Float"}:
        grouped |= {"Integer", "Float"}
        yield "a number"
    if tags >= {"Vector", "Array"}:
        grouped |= {"Vector", "Array", "Matrix", "MutableArray"}
        yield "an array"
    for option in kind.options:
        if option.tag in grouped:
            continue
        if option.tag == "Record" and option.code:
            yield f"a {option.code}"
        elif option.tag == "Vector" and option.items is not None:
            yield f"a Vector of {len(option.items)} number{'s' * (len(option.items) != 1)}"
        elif option.tag == "List" and option.items == ():
            yield "the empty list"
        elif option.tag == "List" and item_of(option) is PART:
            yield "a List of parts"
        else:
            yield _NAMES[option.tag]
