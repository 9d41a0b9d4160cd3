"""The data of the language that Python does not already have (docs/language.md, "Values").

Numbers, strings, booleans and ``none`` are Python's own. Everything here is immutable except the classes under
"mutable twins", whose instances carry a birth stamp so that memoised calls stay sound (see ``runtime``).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from math import isfinite
from struct import Struct, pack
from typing import TYPE_CHECKING, Any, Protocol

from scenelang.grammar.datum import Keyword as Keyword
from scenelang.grammar.datum import Symbol as Symbol
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
    """An immutable pair. A list is ``NIL`` or a pair whose ``cdr`` is a list."""

    __slots__ = ("car", "cdr")

    def __init__(self, car: Any, cdr: Any) -> None:
        self.car = car
        self.cdr = cdr

    def __repr__(self) -> str:
        return "<pair>"


def make_list(items: Iterable[Any], tail: Any = NIL) -> Any:
    """The list of ``items``, ending in ``tail``."""
    result = tail
    for item in reversed(items if isinstance(items, (list, tuple)) else list(items)):
        result = Pair(item, result)
    return result


def iterate_list(value: Any) -> Iterator[Any]:
    """The items of a proper list (the tail of an improper one is ignored)."""
    while type(value) is Pair:
        yield value.car
        value = value.cdr


def list_items(value: Any) -> list[Any]:
    """The items of a proper list as a Python list."""
    items = []
    while type(value) is Pair:
        items.append(value.car)
        value = value.cdr
    return items


class Vector(tuple[Any, ...]):
    """A one-dimensional array: all items are ``int`` or all are ``float``."""

    __slots__ = ()


class Matrix(tuple[float, ...]):
    """An affine pose: the upper three rows of a 4x4 matrix, row-major, 12 floats; the last row is 0 0 0 1."""

    __slots__ = ()


IDENTITY = Matrix((1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0))


class Array:
    """An immutable array of two or more dimensions that is no pose."""

    __slots__ = ("data",)

    def __init__(self, data: npt.NDArray[Any]) -> None:
        data.setflags(write=False)
        self.data = data


class Embedding:
    """What tells one instance of a class from another: handle, text and attributes, each optional (paper, eq. 1).

    ``handle`` is the name between the angle brackets (``z1``), ``attributes`` maps names (no colon) to values.
    """

    __slots__ = ("attributes", "handle", "key", "text")

    def __init__(
        self, handle: str | None = None, text: str | None = None, attributes: Mapping[str, Any] | None = None
    ) -> None:
        self.handle = handle
        self.text = text
        self.attributes: Mapping[str, Any] = attributes if attributes is not None else {}
        self.key: Any = None  # cached by ``equality.embedding_key``

    def __repr__(self) -> str:
        return f"<embedding {self.handle or ''}>"


ANONYMOUS = Embedding()


class HandleList:
    """The root's gamma: the lazy, endless list ``<zk> <zk+1> ...`` (language.md, section 4)."""

    __slots__ = ("start",)

    def __init__(self, start: int) -> None:
        self.start = start


class Procedure:
    """Anything that can be applied. ``name`` is what diagnostics call it."""

    __slots__ = ()
    name: str


@dataclass(frozen=True, slots=True, eq=False)
class Condition:
    """What ``guard`` binds for an error that is not a raised value: the error, as data."""

    error: SceneError


# --- mutable twins ---------------------------------------------------------------------------------------------


class Mutable:
    """Something that can change: ``birth`` orders it against running calls, ``observed`` says a stored call read it.

    A negative birth marks a copy that belongs to an embedding and can no longer be changed.
    """

    __slots__ = ("birth", "observed")

    def __init__(self, birth: int) -> None:
        self.birth = birth
        self.observed = False


class MutableList(Mutable):
    __slots__ = ("items",)

    def __init__(self, items: list[Any], birth: int) -> None:
        super().__init__(birth)
        self.items = items


class MutableArray(Mutable):
    __slots__ = ("data",)

    def __init__(self, data: npt.NDArray[Any], birth: int) -> None:
        super().__init__(birth)
        self.data = data


class Table(Mutable):
    """Insertion-ordered; ``entries`` maps a canonical key to ``(key, value)``."""

    __slots__ = ("entries",)

    def __init__(self, entries: dict[Any, tuple[Any, Any]], birth: int) -> None:
        super().__init__(birth)
        self.entries = entries


class Set(Mutable):
    """Insertion-ordered; ``entries`` maps a canonical key to the member."""

    __slots__ = ("entries",)

    def __init__(self, entries: dict[Any, Any], birth: int) -> None:
        super().__init__(birth)
        self.entries = entries


class RecordType:
    """The type that ``define-record`` makes."""

    __slots__ = ("fields", "name")

    def __init__(self, name: str, fields: tuple[str, ...]) -> None:
        self.name = name
        self.fields = fields


class Record(Mutable):
    __slots__ = ("type", "values")

    def __init__(self, record_type: RecordType, values: list[Any], birth: int) -> None:
        super().__init__(birth)
        self.type = record_type
        self.values = values


class Stream(Mutable):
    """A random stream of one's own; ``generator`` is numpy's ``RandomState``/``Generator`` or ``random.Random``."""

    __slots__ = ("generator", "kind")

    def __init__(self, kind: str, generator: Any, birth: int) -> None:
        super().__init__(birth)
        self.kind = kind
        self.generator = generator


# Equality and canonical keys of values, without recursion: data may be nested as deep as memory allows.


_NUMBERS = (int, float)
_CHARGE = 1024
_PLAIN = frozenset((int, str, bool, type(None), Symbol))
_pack_three = Struct("3d").pack
_LONGEST_KEY = 200_000
_FEW = 32  # items that are not charged


class KeyReader(Protocol):
    """What equality tells of its work: the mutable things that it reads, and how much it does."""

    def read(self, thing: Mutable) -> None: ...

    @property
    def charge(self) -> Callable[[int], None]: ...


def equal(reader: KeyReader, a: Any, b: Any, typed: bool = True) -> bool:
    """Structural equality. ``typed``: 1 and 1.0 differ (``equal?``); else numbers compare by value (``contains?``).

    Pairs that were compared before are not compared again, so shared and circular data end.
    """
    stack = [(a, b)]
    seen: set[tuple[int, int]] = set()
    while stack:
        a, b = stack.pop()
        if a is b:
            continue
        if isinstance(a, (Pair, Mutable)):
            if (id(a), id(b)) in seen:
                continue
            seen.add((id(a), id(b)))
            if len(seen) % _CHARGE == 0:
                reader.charge(_CHARGE)
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
        if not _same_kind(reader, a, b, stack, typed):
            return False
    return True


def _sequence_step(reader: KeyReader, a: Any, b: Any) -> tuple[list[Any] | None, list[Any] | None]:
    """What is left to compare of two lists; None when they cannot be equal."""
    if type(a) is Pair and type(b) is Pair:
        return [a.car, a.cdr], [b.car, b.cdr]
    left, right = _list_or_none(reader, a), _list_or_none(reader, b)
    if left is None or right is None or len(left) != len(right):
        return None, None
    return left, right


def _list_or_none(reader: KeyReader, value: Any) -> list[Any] | None:
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
    arrays = (Vector, Matrix, Array, MutableArray)
    return isinstance(a, arrays) and isinstance(b, arrays)


def _array_size(value: Any) -> int:
    return len(value) if isinstance(value, tuple) else value.data.size


def _array_items(value: Any) -> tuple[tuple[int, ...], list[Any]]:
    if type(value) is Vector:
        return (len(value),), list(value)
    if type(value) is Matrix:
        return (4, 4), [*value, 0.0, 0.0, 0.0, 1.0]
    return value.data.shape, value.data.ravel().tolist()


def _same_kind(reader: KeyReader, a: Any, b: Any, stack: list[tuple[Any, Any]], typed: bool) -> bool:
    kind = type(a)
    if kind in (int, float, bool):
        return bool(a == b)
    if kind is str or kind is Symbol or kind is Keyword:
        if len(a) > _CHARGE:
            reader.charge(len(a) >> 10)
        return bool(a == b)
    if _both_arrays(a, b):
        reader.charge(1 + ((_array_size(a) + _array_size(b)) >> 5))
        (shape_a, items_a), (shape_b, items_b) = _array_items(a), _array_items(b)
        same_types = not typed or [type(x) for x in items_a] == [type(x) for x in items_b]
        return shape_a == shape_b and items_a == items_b and same_types
    if kind is Embedding or kind is Table or kind is Set:
        reader.charge(len(a.attributes if kind is Embedding else a.entries) >> 3)
    if kind is Embedding:
        if (a.handle, a.text, set(a.attributes)) != (b.handle, b.text, set(b.attributes)):
            return False
        stack.extend((a.attributes[name], b.attributes[name]) for name in a.attributes)
        return True
    if kind is Table:
        if a.entries.keys() != b.entries.keys():
            return False
        stack.extend((a.entries[key][1], b.entries[key][1]) for key in a.entries)
        return True
    if kind is Set:
        return bool(a.entries.keys() == b.entries.keys())
    if kind is Record:
        stack.extend(zip(a.values, b.values))
        return a.type is b.type
    return kind is HandleList and a.start == b.start


class _Opaque(Exception):
    """The value has no key."""


_SCALAR_TAGS: dict[type, str] = {str: "s", Symbol: "y", Keyword: "k", bool: "b", type(None): "n"}

# CPython gives integers that differ by a multiple of 2^61 - 1 one hash, so that a table of such is searched one by one.
# Where integers are that long, their digits are the key, for the hash of a text is another in every process.
_LONG = 1 << 60

Charge = Callable[[int], None]


def _uncharged(_: int) -> None:
    """For keys of what is known to be small."""


def memo_key(value: Any, charge: Charge = _uncharged) -> Any:
    """A hashable key, equal for values that no program can tell apart; None when ``value`` is not immutable data.

    Flat, so that hashing never recurses. Numbers are keyed by type: 1, 1.0, -0.0 and #t differ.
    """
    try:
        return _key(value, typed=True, charge=charge)
    except _Opaque:
        return None


def table_key(value: Any, charge: Charge = _uncharged) -> Any:
    """The canonical key under which tables and sets keep ``value``: numbers by value, lists by content, others by
    identity."""
    kind = type(value)
    if kind is str:
        return value
    if kind is int or kind is float:
        return value if -_LONG < value < _LONG else _long_key(value)
    return _key(value, typed=False, charge=charge)


def _long_key(number: int | float) -> Any:
    """The key of a number of many digits; an integer and an equal float have one key."""
    if type(number) is float and not isfinite(number):
        return number
    return ("i", hex(int(number)))


def _key(value: Any, typed: bool, charge: Charge) -> tuple[Any, ...]:
    out: list[Any] = []
    stack = [value]
    charged = 0
    while stack:
        item = stack.pop()
        kind = type(item)
        if len(out) - charged >= _CHARGE:
            charge((len(out) - charged) >> 4)
            charged = len(out)
            if charged > _LONGEST_KEY:
                if typed:
                    raise _Opaque
                raise LimitError("size", "a key of a table or set is too large")
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
            out += ("o", _opaque_key(item, typed))
    charge((len(out) - charged) >> 4)
    return tuple(out)


def _number_key(item: Any) -> Any:
    if type(item) is int:
        return item if -_LONG < item < _LONG else _long_key(item)
    return ("f", "-0") if item == 0.0 and str(item)[0] == "-" else ("f", item)


def _opaque_key(item: Any, typed: bool) -> Any:
    """Entities are immutable and compare by identity; tables and sets keep anything else by identity too."""
    if not typed:
        return item
    if getattr(item, "tainted", True):
        raise _Opaque
    return item


def embedding_key(embedding: Embedding, charge: Charge = _uncharged) -> Any:
    """``memo_key`` of an embedding, cached; False when it has none."""
    key = embedding.key
    if key is None:
        key = _plain_key(embedding, charge)
        if key is None:
            key = memo_key(embedding, charge)
        key = embedding.key = False if key is None else key
    return key


def _plain_key(embedding: Embedding, charge: Charge) -> Any:
    """The key of an embedding whose attributes are numbers, strings and vectors, as nearly all are; else None."""
    out: list[Any] = [embedding.handle, embedding.text]
    if len(embedding.attributes) > _FEW:
        charge(len(embedding.attributes) >> 4)
    for name, value in embedding.attributes.items():
        kind = type(value)
        if kind is Vector:
            if len(value) > _FEW:
                charge(len(value) >> 5)
            if value and type(value[0]) is float:  # bytes, since -0.0 is no 0.0
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
