"""Values of the language other than Python's own numbers, strings, booleans and None (docs/language.md, "Data").

All values are immutable except those of the classes under "mutable values", whose instances have a birth stamp, so that
memoized calls remain sound (see ``runtime``).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from math import isfinite
from struct import Struct, pack
from typing import TYPE_CHECKING, Any, Protocol

from scenelang.grammar.datum import Keyword as Keyword
from scenelang.grammar.datum import Symbol as Symbol
from scenelang.grammar.datum import dataclass
from scenelang.grammar.diagnostics import LimitError

if TYPE_CHECKING:
    import numpy.typing as npt

    from scenelang.grammar.diagnostics import SceneError


class Nil:
    """The empty list."""

    __slots__ = ()

    def __repr__(self) -> str:
        return "NIL"


NIL = Nil()


class Pair:
    """Immutable pair. A list is ``NIL``, or a pair whose ``cdr`` is a list."""

    __slots__ = ("car", "cdr")

    def __init__(self, car: Any, cdr: Any) -> None:
        self.car = car
        self.cdr = cdr

    def __repr__(self) -> str:
        return "<pair>"


def make_list(items: Iterable[Any], tail: Any = NIL) -> Any:
    """Return a list of ``items`` that ends in ``tail``."""
    result = tail
    for item in reversed(items if isinstance(items, (list, tuple)) else list(items)):
        result = Pair(item, result)
    return result


def iterate_list(value: Any) -> Iterator[Any]:
    """Iterate over the items of a proper list (the tail of an improper list is ignored)."""
    while type(value) is Pair:
        yield value.car
        value = value.cdr


def list_items(value: Any) -> list[Any]:
    """Return the items of a proper list as a Python list."""
    items = []
    while type(value) is Pair:
        items.append(value.car)
        value = value.cdr
    return items


class Vector(tuple[Any, ...]):
    """One-dimensional array whose items are all ``int`` or all ``float``."""

    __slots__ = ()


class Matrix(tuple[float, ...]):
    """Pose as an affine 4x4 matrix: the 12 floats of the upper three rows, row-major; the last row is 0 0 0 1."""

    __slots__ = ()


IDENTITY = Matrix((1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0))


class Array:
    """Immutable array of two or more dimensions that is not a pose."""

    __slots__ = ("data",)

    def __init__(self, data: npt.NDArray[Any]) -> None:
        data.setflags(write=False)
        self.data = data


class Embedding:
    """Embedding, which distinguishes the instances of a class of entities (paper, eq. 1).

    It has an optional handle, text and attributes. ``handle`` is the name without angle brackets (``z1``), and
    ``attributes`` maps names without colon to values.
    """

    __slots__ = ("attributes", "handle", "key", "text")

    def __init__(
        self, handle: str | None = None, text: str | None = None, attributes: Mapping[str, Any] | None = None
    ) -> None:
        self.handle = handle
        self.text = text
        self.attributes: Mapping[str, Any] = attributes if attributes is not None else {}
        self.key: Any = None  # cached by ``embedding_key``

    def __repr__(self) -> str:
        return f"<embedding {self.handle or ''}>"


ANONYMOUS = Embedding()


class HandleList:
    """The root's gamma: the lazy infinite list ``<zk> <zk+1> ...`` (docs/language.md, "Numbers and the file Z")."""

    __slots__ = ("start",)

    def __init__(self, start: int) -> None:
        self.start = start


class Procedure:
    """Base class of callable values. ``name`` is used in diagnostics."""

    __slots__ = ()
    name: str


@dataclass(frozen=True, slots=True, eq=False)
class Condition:
    """Error as a value, which ``guard`` binds for errors that were not raised with a value."""

    error: SceneError


# --- mutable values --------------------------------------------------------------------------------------------


class Mutable:
    """Base class of mutable values.

    ``birth`` is the clock at its creation, by which it is ordered relative to calls; a negative birth marks a copy in
    an embedding, which cannot be modified. ``observed`` is set if a memoized call has read it.
    """

    __slots__ = ("birth", "observed")

    def __init__(self, birth: int) -> None:
        self.birth = birth
        self.observed = False


class MutableList(Mutable):
    """Growable list, as Python's."""

    __slots__ = ("items",)

    def __init__(self, items: list[Any], birth: int) -> None:
        super().__init__(birth)
        self.items = items


class MutableArray(Mutable):
    """Array whose items can be set."""

    __slots__ = ("data",)

    def __init__(self, data: npt.NDArray[Any], birth: int) -> None:
        super().__init__(birth)
        self.data = data


class Table(Mutable):
    """Insertion-ordered table. ``entries`` maps a canonical key to ``(key, value)``."""

    __slots__ = ("entries",)

    def __init__(self, entries: dict[Any, tuple[Any, Any]], birth: int) -> None:
        super().__init__(birth)
        self.entries = entries


class Set(Mutable):
    """Insertion-ordered set. ``entries`` maps a canonical key to the member."""

    __slots__ = ("entries",)

    def __init__(self, entries: dict[Any, Any], birth: int) -> None:
        super().__init__(birth)
        self.entries = entries


class RecordType:
    """Record type created by ``define-record``."""

    __slots__ = ("fields", "name")

    def __init__(self, name: str, fields: tuple[str, ...]) -> None:
        self.name = name
        self.fields = fields


class Record(Mutable):
    """Instance of a record type; ``values`` are in the order of its fields."""

    __slots__ = ("type", "values")

    def __init__(self, record_type: RecordType, values: list[Any], birth: int) -> None:
        super().__init__(birth)
        self.type = record_type
        self.values = values


class Stream(Mutable):
    """Random stream that a program has created, in addition to the two global ones.

    ``generator`` is numpy's ``RandomState`` or ``Generator``, or ``random.Random``; ``kind`` says which.
    """

    __slots__ = ("generator", "kind")

    def __init__(self, kind: str, generator: Any, birth: int) -> None:
        super().__init__(birth)
        self.kind = kind
        self.generator = generator


# Equality and canonical keys of values, without recursion, because data may be nested arbitrarily deeply.


_NUMBERS = (int, float)
_CHARGE_INTERVAL = 1024  # values between two charges
_PLAIN = frozenset((int, str, bool, type(None), Symbol))
_pack_three = Struct("3d").pack
_MAX_KEY_PARTS = 200_000  # a call with a larger argument is not memoized
_MIN_CHARGED_ITEMS = 32  # the call itself pays for shorter sequences


class KeyReader(Protocol):
    """Callbacks of equality tests, which track reads of mutable values and the amount of work."""

    def read(self, value: Mutable) -> None:
        """Record that a mutable value is read."""

    @property
    def charge(self) -> Callable[[int], None]:
        """Function that counts steps of work."""


_ATOMS = frozenset((str, int, Keyword, Symbol))


def is_short_atom(value: Any) -> bool:
    """Return whether a value equals another one of its type if Python says so, at no charge."""
    kind = type(value)
    return kind is int or (kind in _ATOMS and len(value) <= _CHARGE_INTERVAL)


def equal(reader: KeyReader, a: Any, b: Any, typed: bool = True) -> bool:
    """Return whether two values are structurally equal.

    Pairs of objects are compared only once, so the comparison of shared and circular data terminates.

    Parameters
    ----------
    reader
        Callbacks for reads of mutable values and for work.
    a, b
        Values of the language.
    typed
        Whether 1 and 1.0 differ, as for ``equal?``; otherwise numbers are compared by value, as for ``contains?``.
    """
    if type(a) is type(b) and is_short_atom(a):
        return bool(a == b)
    stack = [(a, b)]
    compared: set[tuple[int, int]] = set()
    while stack:
        a, b = stack.pop()
        if a is b:
            continue
        if isinstance(a, (Pair, Mutable)):
            if (id(a), id(b)) in compared:
                continue
            compared.add((id(a), id(b)))
            if len(compared) % _CHARGE_INTERVAL == 0:
                reader.charge(_CHARGE_INTERVAL)
        for side in (a, b):
            if isinstance(side, Mutable):
                reader.read(side)
        kind = type(a)
        if not typed and kind in _NUMBERS and type(b) in _NUMBERS:
            if a != b:
                return False
            continue
        if isinstance(a, (MutableList, Pair)) or a is NIL:
            left, right = _sequence_step(reader, a, b)
            if left is None or right is None:
                return False
            stack.extend(zip(left, right))
            continue
        if kind is not type(b) and not _both_arrays(a, b):
            return False
        if not _same_kind(reader, a, b, stack, typed=typed):
            return False
    return True


def _sequence_step(reader: KeyReader, a: Any, b: Any) -> tuple[list[Any] | None, list[Any] | None]:
    """Return the parts of two lists that remain to be compared, or None if they cannot be equal."""
    if type(a) is Pair and type(b) is Pair:
        return [a.car, a.cdr], [b.car, b.cdr]
    left, right = _list_or_none(reader, a), _list_or_none(reader, b)
    if left is None or right is None or len(left) != len(right):
        return None, None
    return left, right


def _list_or_none(reader: KeyReader, value: Any) -> list[Any] | None:
    """Return the items of a mutable or a proper list, or None for any other value."""
    if isinstance(value, MutableList):
        reader.charge(1 + (len(value.items) >> 8))
        return value.items
    items = []
    while type(value) is Pair:
        items.append(value.car)
        value = value.cdr
    reader.charge(1 + (len(items) >> 4))
    return items if value is NIL else None


def _both_arrays(a: Any, b: Any) -> bool:
    """Return whether both values are arrays, of whatever representation."""
    arrays = (Vector, Matrix, Array, MutableArray)
    return isinstance(a, arrays) and isinstance(b, arrays)


def _array_size(value: Any) -> int:
    """Return the number of stored items of an array."""
    return len(value) if isinstance(value, tuple) else value.data.size


def _array_items(value: Any) -> tuple[tuple[int, ...], list[Any]]:
    """Return the shape of an array and its items in row-major order; a pose counts as a 4x4 matrix."""
    if type(value) is Vector:
        return (len(value),), list(value)
    if type(value) is Matrix:
        return (4, 4), [*value, 0.0, 0.0, 0.0, 1.0]
    return value.data.shape, value.data.ravel().tolist()


def _same_kind(reader: KeyReader, a: Any, b: Any, stack: list[tuple[Any, Any]], *, typed: bool) -> bool:
    """Return whether two values of one kind are equal, apart from the pairs of parts that are pushed onto ``stack``.

    Parts that Python compares at once cost less than a step each: a step is charged for 1,024 characters, 32 numbers,
    or 8 entries.
    """
    kind = type(a)
    if kind in (int, float, bool):
        return bool(a == b)
    if kind is str or kind is Symbol or kind is Keyword:
        if len(a) > _CHARGE_INTERVAL:
            reader.charge(len(a) >> 10)
        return bool(a == b)
    if _both_arrays(a, b):
        reader.charge(1 + ((_array_size(a) + _array_size(b)) >> 5))
        (shape_a, items_a), (shape_b, items_b) = _array_items(a), _array_items(b)
        same_types = not typed or [type(x) for x in items_a] == [type(x) for x in items_b]
        return shape_a == shape_b and items_a == items_b and same_types
    if kind is Embedding:
        reader.charge(len(a.attributes) >> 3)
        if (a.handle, a.text, set(a.attributes)) != (b.handle, b.text, set(b.attributes)):
            return False
        stack.extend((a.attributes[name], b.attributes[name]) for name in a.attributes)
        return True
    if kind is Table:
        reader.charge(len(a.entries) >> 3)
        if a.entries.keys() != b.entries.keys():
            return False
        stack.extend((a.entries[key][1], b.entries[key][1]) for key in a.entries)
        return True
    if kind is Set:
        reader.charge(len(a.entries) >> 3)
        return bool(a.entries.keys() == b.entries.keys())
    if kind is Record:
        stack.extend(zip(a.values, b.values))
        return a.type is b.type
    return kind is HandleList and a.start == b.start


class _Opaque(Exception):
    """Raised if a value has no key."""


_SCALAR_TAGS: dict[type, str] = {str: "s", Symbol: "y", Keyword: "k", bool: "b", type(None): "n"}

# CPython hashes integers modulo 2^61 - 1 without a seed, so a program could construct colliding keys that make a table
# quadratic. Longer integers are therefore keyed by their digits: string hashes are randomized in every process.
_MIN_LONG = 1 << 60

Charge = Callable[[int], None]


def _uncharged(_: int) -> None:
    """Ignore a charge; for keys of values that are known to be small."""


def memo_key(value: Any, charge: Charge = _uncharged) -> Any:
    """Return a hashable key that is equal for indistinguishable values, or None if ``value`` is not immutable data.

    The key is flat, so that hashing does not recurse. Numbers are keyed by type: 1, 1.0, -0.0 and #t differ. ``charge``
    is called with the number of steps.
    """
    try:
        return _key(value, typed=True, charge=charge)
    except _Opaque:
        return None


def table_key(value: Any, charge: Charge = _uncharged) -> Any:
    """Return the canonical key of ``value`` in tables and sets.

    Numbers are keyed by value, lists by content, and other values by identity.
    """
    kind = type(value)
    if kind is str:
        return value
    if kind is int or kind is float:
        return value if -_MIN_LONG < value < _MIN_LONG else _long_key(value)
    if kind is Pair:
        short = _short_key(value)
        if short is not None:
            return short
    return _key(value, typed=False, charge=charge)


def _short_key(pair: Any) -> tuple[Any, ...] | None:
    """Return the key that ``_key`` returns for a list of a few numbers, such as a cell of a grid, else None."""
    out: list[Any] = []
    while type(pair) is Pair:
        item = pair.car
        if (type(item) is not int and type(item) is not float) or len(out) > _MAX_SHORT_KEY:
            return None
        out += ("(", item if -_MIN_LONG < item < _MIN_LONG else _long_key(item))
        pair = pair.cdr
    if pair is not NIL:
        return None
    out.append(")")
    return tuple(out)


_MAX_SHORT_KEY = 12  # parts of a key without a charge, which ``_key`` makes for 16


def _long_key(number: int | float) -> Any:
    """Return the key of a number with many digits; an integer and an equal float have the same key."""
    if type(number) is float and not isfinite(number):
        return number
    return ("i", hex(int(number)))


def _key(value: Any, *, typed: bool, charge: Charge) -> tuple[Any, ...]:
    """Return the flat key of a value: tags of types and brackets, lengths, and scalars, in depth-first order.

    The stack replaces recursion, and the charges are those of a loop in Python: one step for 16 parts.
    """
    out: list[Any] = []
    stack = [value]
    charged = 0  # parts that have been paid for
    while stack:
        item = stack.pop()
        kind = type(item)
        if len(out) - charged >= _CHARGE_INTERVAL:
            charge((len(out) - charged) >> 4)
            charged = len(out)
            if charged > _MAX_KEY_PARTS:
                if typed:
                    raise _Opaque
                raise LimitError("size", "key of a table or set is too large")
        if kind is float or kind is int:
            out.append(_number_key(item) if typed else table_key(item))
        elif kind in _SCALAR_TAGS:
            out += (_SCALAR_TAGS[kind], item)
        elif kind is Pair:
            out.append("(")
            stack += (item.cdr, item.car)
        elif item is NIL:
            out.append(")")
        elif kind is Vector or kind is Matrix:
            charge(len(item) >> 5)
            out += ("v" if kind is Vector else "m", len(item))
            out += map(_number_key if typed else table_key, item)
        elif kind is Array:
            charge(item.data.size >> 8)
            out += ("a", item.data.shape, item.data.dtype.str, item.data.tobytes())
        elif kind is Embedding:
            out += ("e", item.handle, item.text, len(item.attributes))
            for name, attribute in item.attributes.items():
                stack += (attribute, name)
            charge(len(item.attributes) >> 4)
        elif kind is HandleList:
            out += ("h", item.start)
        elif kind is Table and item.birth < 0:
            out += ("t", len(item.entries))
            for key, entry in item.entries.values():
                stack += (entry, key)
            charge(len(item.entries) >> 4)
        else:
            out += ("o", _opaque_key(item, typed=typed))
    charge((len(out) - charged) >> 4)
    return tuple(out)


def _number_key(item: Any) -> Any:
    """Return the key of a number by type and value; -0.0 and 0.0 are distinguishable and have two keys."""
    if type(item) is int:
        return item if -_MIN_LONG < item < _MIN_LONG else _long_key(item)
    return ("f", "-0") if item == 0.0 and str(item)[0] == "-" else ("f", item)


def _opaque_key(item: Any, *, typed: bool) -> Any:
    """Return the key of a value compared by identity; memo keys admit only untainted entities, which are immutable."""
    if not typed:
        return item
    if getattr(item, "tainted", True):
        raise _Opaque
    return item


def embedding_key(embedding: Embedding, charge: Charge = _uncharged) -> Any:
    """Return the cached ``memo_key`` of an embedding, or False if it has none."""
    key = embedding.key
    if key is None:
        key = _plain_key(embedding, charge)
        if key is None:
            key = memo_key(embedding, charge)
        key = embedding.key = False if key is None else key
    return key


def _plain_key(embedding: Embedding, charge: Charge) -> Any:
    """Return the key of an embedding with only numbers, strings and vectors as attributes (fast path), else None."""
    out: list[Any] = [embedding.handle, embedding.text]
    if len(embedding.attributes) > _MIN_CHARGED_ITEMS:
        charge(len(embedding.attributes) >> 4)
    for name, value in embedding.attributes.items():
        kind = type(value)
        if kind is Vector:
            if len(value) > _MIN_CHARGED_ITEMS:
                charge(len(value) >> 5)
            if value and type(value[0]) is float:  # bytes, to distinguish -0.0 from 0.0
                value = _pack_three(*value) if len(value) == 3 else pack(f"{len(value)}d", *value)
            elif value:
                value = tuple(map(_number_key, value))
        elif kind is float:
            value = value if value else repr(value)
        elif kind is int:
            value = _number_key(value)
        elif kind not in _PLAIN:
            return None
        out += (name, kind, value)
    return tuple(out)
