"""Printing of values, without recursion and in time bounded by the requested length."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from itertools import chain
from typing import TYPE_CHECKING, Any

from scenelang.grammar.datum import atom_text, number_text, string_text
from scenelang.grammar.diagnostics import CODES, SceneError
from scenelang.interpreter.loading import np
from scenelang.interpreter.runtime.types import TypeReader, numbers_of, type_name
from scenelang.interpreter.scene import pose
from scenelang.interpreter.scene.entity import Entity, Frames
from scenelang.interpreter.values.values import (
    NIL,
    Array,
    Condition,
    Embedding,
    HandleList,
    Keyword,
    Matrix,
    Mutable,
    MutableArray,
    MutableList,
    Pair,
    Procedure,
    Record,
    RecordType,
    Set,
    Stream,
    Symbol,
    Table,
    Vector,
    make_list,
    table_key,
)

if TYPE_CHECKING:
    import numpy.typing as npt


MAX_LENGTH = 10_000  # characters of a printed value
Read = Callable[[Mutable], None]


def _unread(_: Mutable) -> None:
    """Ignore a read; for text that is not visible to the program."""


def display(value: Any, limit: int = MAX_LENGTH, read: Read = _unread) -> str:
    """Return ``value`` as text for ``print`` and ``format``: strings are neither quoted nor truncated.

    ``limit`` and ``read`` are those of ``show``.
    """
    return value if type(value) is str else show(value, limit, read)


def show(value: Any, limit: int = MAX_LENGTH, read: Read = _unread) -> str:
    """Return ``value`` as text for the REPL, truncated to about ``limit`` characters with ``...``.

    ``read`` is called for every mutable value whose contents are printed, because a program that receives the text has
    read them.
    """
    if type(value) in _PLAIN:
        text = atom_text(value)
        return text if len(text) <= limit else text[: max(0, limit - 3)] + "..."
    out: list[str] = []
    size = 0
    stack: list[Iterator[Any]] = [iter((value,))]  # pieces that are still to be printed, innermost last
    while stack:
        item = next(stack[-1], _END)
        if item is _END:
            stack.pop()
            continue
        text = item.text if type(item) is _Text else _piece(item, stack, limit - size, read)
        out.append(text)
        size += len(text)
        if size > limit:
            return "".join(out)[: max(0, limit - 3)] + "..."
    return "".join(out)


def described(value: Any, limit: int) -> str:
    """Return a value for error messages: its type with an article, and its text; vectors are rounded to six digits."""
    if value is None:
        return type_name(value)
    if type(value) is Vector:
        value = Vector([float(f"{number:.6g}") if type(number) is float else number for number in value])
    return f"{type_name(value)}: {show(value, limit)}"


_END = object()
_PLAIN = frozenset((int, float, bool, type(None)))


class _Text:
    """Literal output between items."""

    __slots__ = ("text",)

    def __init__(self, text: str) -> None:
        self.text = text


_CLOSE = _Text(")")
_BRACKET = _Text("]")
_SPACE = _Text(" ")
_DOT = _Text(" . ")


def _piece(item: Any, stack: list[Iterator[Any]], budget: int, read: Read) -> str:
    """Return the beginning of the text of ``item``, and push the rest on ``stack``.

    At most about ``budget`` characters of a string are processed.
    """
    if type(item) is Pair:
        stack.append(_list_pieces(item))
        return "("
    if item is NIL:
        return "()"
    if isinstance(item, Mutable):
        read(item)
    sequence = _sequence_parts(item)
    if sequence is not None:
        opening, members = sequence
        stack.append(_call_pieces(members, is_first=opening == "("))
        return opening
    if type(item) is Vector:
        stack.append(_row_pieces(item))
        return "["
    if type(item) is Array or type(item) is _Rows:
        return _array_piece(item.data, stack)
    if type(item) is MutableArray:
        stack.append(iter((_CLOSE,)))
        return "(mutable-array " + _array_piece(item.data, stack)
    return _leaf(item, budget)


def _list_pieces(pair: Pair) -> Iterator[Any]:
    """Iterate over the pieces of a list after its opening bracket."""
    yield pair.car
    rest = pair.cdr
    while type(rest) is Pair:
        yield _SPACE
        yield rest.car
        rest = rest.cdr
    if rest is not NIL:
        yield _DOT
        yield rest
    yield _CLOSE


def _call_pieces(members: Iterator[Any], *, is_first: bool) -> Iterator[Any]:
    """Iterate over the pieces of a call with the operands ``members``; if ``is_first``, no name precedes them."""
    for member in members:
        if not is_first:
            yield _SPACE
        is_first = False
        yield member
    yield _CLOSE


def _row_pieces(members: Iterator[Any] | Vector) -> Iterator[Any]:
    """Iterate over the pieces of an array row after its opening bracket."""
    between = False
    for member in members:
        if between:
            yield _SPACE
        between = True
        yield member
    yield _BRACKET


def _array_piece(data: Any, stack: list[Iterator[Any]]) -> str:
    """Return the beginning of the text of an array, and push its rows on ``stack``."""
    if data.ndim == 0:
        return number_text(data.item())
    stack.append(_row_pieces(_rows(data)))
    return "["


def _rows(data: Any) -> Iterator[Any]:
    """Iterate over the numbers or subarrays of an array."""
    for row in data:
        yield row.item() if data.ndim == 1 else _Rows(row)


class _Rows:
    """Subarray that is being printed."""

    __slots__ = ("data",)

    def __init__(self, data: Any) -> None:
        self.data = data


def _sequence_parts(item: Any) -> tuple[str, Iterator[Any]] | None:
    """Return how the text of a collection begins, and its members; None for other values."""
    kind = type(item)
    if kind is MutableList:
        return "(mutable-list", iter(item.items)
    if kind is Table:
        return "(table", chain.from_iterable(item.entries.values())
    if kind is Set:
        return "(set", iter(item.entries.values())
    if kind is Record:
        return f"({item.type.name[:MAX_LENGTH]}", iter(item.values)
    if kind is Embedding:
        return "(embedding", _embedding_parts(item)
    return None


def _embedding_parts(item: Embedding) -> Iterator[Any]:
    """Iterate over the handle, text and attributes of an embedding."""
    if item.handle is not None:
        yield _Text(f"<{item.handle[:MAX_LENGTH]}>")
    if item.text is not None:
        yield item.text
    for name, value in item.attributes.items():
        yield _Text(f":{name[:MAX_LENGTH]}")
        yield value


def _leaf(item: Any, budget: int) -> str:
    """Return the text of a value that is printed in one piece.

    Values that cannot be read back are in angle brackets, such as ``<procedure name>`` and ``<error code>``.
    """
    kind = type(item)
    if kind is str:
        return string_text(_cut(item, budget))
    if kind is Symbol or kind is Keyword:
        return atom_text(kind(_cut(item, budget)))
    if kind is Matrix:
        rows = [item[0:4], item[4:8], item[8:12], (0.0, 0.0, 0.0, 1.0)]
        return "[" + " ".join("[" + " ".join(map(number_text, row)) + "]" for row in rows) + "]"
    if kind is Entity:
        return f'<entity "{_cut(item.word, budget)}">'
    if kind is Frames:
        return f"<{len(item.frames)} frames>"
    if kind is HandleList:
        return f"(<z{item.start}> <z{item.start + 1}> ...)"
    if isinstance(item, Procedure):
        return f"<procedure {_cut(item.name, budget)}>"
    if kind is Condition:
        return f"<error {CODES[item.error.name].code}>"
    if kind is Stream:
        return f"<random stream {item.kind}>"
    if kind is RecordType:
        return f"<record type {_cut(item.name, budget)}>"
    return atom_text(item)


def _cut(text: str, budget: int) -> str:
    """Return ``text``, or a prefix long enough to be recognized as truncated."""
    return text if len(text) <= budget + 8 else text[: max(0, budget) + 8]


# Array values: literals, and conversion between the language's array types and numpy arrays.


def from_numpy(data: Any) -> Any:
    """Convert a numpy array to a number, a Vector, a Matrix (if it is a pose) or an Array."""
    data = np.asarray(data)
    if data.dtype.kind == "f":
        data = data.astype(np.float64, copy=False)
    elif data.dtype.kind in "biu":
        data = data.astype(np.int64, copy=False)
    if data.ndim == 0:
        return data.item()
    if data.ndim == 1:
        return Vector(data.tolist())
    if data.shape == (4, 4):
        matrix = pose.from_array(data)
        if matrix is not None:
            return matrix
    return Array(data.copy() if data.base is not None else data)


def numbers_to_numpy(numbers: Any) -> npt.NDArray[Any]:
    """Convert (nested) Python numbers to an array of int64 if all are integers that fit, else float64."""
    data = np.array(numbers)
    if data.dtype.kind in "iu" and data.dtype != np.uint64:
        return data.astype(np.int64, copy=False)
    if data.dtype == np.float64:
        return data
    try:
        return np.array(numbers, dtype=np.float64)
    except OverflowError:
        raise SceneError("domain", "integer too large for an array") from None


def array_literal(items: Sequence[Any], reader: TypeReader | None = None) -> Any:
    """Return the value of ``[item ...]``, whose items are numbers or arrays of the same shape.

    Raises ``SceneError`` for other items. ``reader`` tracks reads of mutable items; it is not required for a constant.
    """
    kinds = {type(item) for item in items}
    if kinds <= {float} or kinds == {int}:
        return Vector(items)
    for item in items:
        if type(item) not in (int, float) and not isinstance(
            item, (Vector, Matrix, Array, MutableArray, Pair, MutableList)
        ):
            message = f"expected a number in an array, got {described(item, 60)}"
            raise SceneError("type", message, hint="use `(list ...)` for a list of other values")
    try:
        if kinds == {int, float}:
            return Vector([float(item) for item in items])
        return from_numpy(numbers_to_numpy([_row(item, reader) for item in items]))
    except OverflowError:
        raise SceneError("domain", "integer too large for an array of floats") from None
    except ValueError:
        raise SceneError("value", "the rows of an array must have the same shape") from None


def _row(item: Any, reader: TypeReader | None) -> Any:
    """Return an item of an array literal as nested Python numbers."""
    if isinstance(item, (Array, MutableArray)):
        if reader is not None:
            reader.charge(item.data.size >> 5)
            if isinstance(item, MutableArray):
                reader.read(item)
        return item.data.tolist()
    if type(item) is Matrix:
        return pose.to_array(item).tolist()
    if type(item) in (int, float):
        return item
    numbers = numbers_of(item, reader)
    if numbers is None:
        raise SceneError("type", f"expected a row of numbers in an array, got {show(item, 60)}")
    return numbers


# Attributes as plain data for JSON and files: numbers, arrays, strings, booleans, lists and tables
# (docs/language.md, "Entities and embeddings").


MAX_DEPTH = 100  # levels of nested values: JSON parsers and ``value_of`` recurse
MAX_ITEMS = 1_000_000  # of an attribute


class NotPlain(Exception):
    """Raised for a value that cannot be serialized: it contains a function, entity or nan, or is nested too deeply."""


def plain_value(value: Any, tagged: bool = False) -> Any:
    """Convert ``value`` to JSON data. If ``tagged``, arrays, tables and embeddings are marked, to be read back."""
    return _plain(value, 0, [MAX_ITEMS], tagged=tagged)


def _plain(value: Any, depth: int, budget: list[int], *, tagged: bool) -> Any:
    """Convert a value at a nesting ``depth``; ``budget`` is the number of items that are left, for all levels."""
    kind = type(value)
    budget[0] -= 1
    if depth > MAX_DEPTH or budget[0] < 0:
        raise NotPlain
    if value is None or kind in (str, int, bool):
        return value
    if kind is float:
        if not math.isfinite(value):
            raise NotPlain
        return value
    if kind in (Symbol, Keyword):
        return str(value)
    array = _array(value)
    if array is not None:
        return {"array": array} if tagged else array

    def inner(item: Any) -> Any:
        """Convert a member of the value."""
        return _plain(item, depth + 1, budget, tagged=tagged)

    if kind is Pair or value is NIL or kind is MutableList:
        return [inner(item) for item in _items(value)]
    if kind is Table:
        if tagged:
            return {"table": [[inner(key), inner(item)] for key, item in value.entries.values()]}
        return {str(inner(key)): inner(item) for key, item in value.entries.values()}
    if kind is Embedding:
        attributes = {name: inner(item) for name, item in value.attributes.items()}
        if tagged:
            return {"embedding": [value.handle, value.text, attributes]}
        return {"handle": value.handle, "text": value.text, "attributes": attributes}
    raise NotPlain


def _array(value: Any) -> Any:
    """Return an array as nested lists, or None for other values."""
    if type(value) is Vector:
        return list(value)
    if type(value) is Matrix:
        return pose.to_array(value).tolist()
    if isinstance(value, (Array, MutableArray)):
        return value.data.tolist()
    return None


def _items(value: Any) -> list[Any]:
    """Return the items of a list; the tail of an improper one is its last item."""
    if type(value) is MutableList:
        return list(value.items)
    items = []
    while type(value) is Pair:
        items.append(value.car)
        value = value.cdr
    if value is not NIL:
        items.append(value)
    return items


def plain_attributes(entity: Entity) -> dict[str, Any]:
    """Return an entity's attributes as JSON data, without those that cannot be serialized."""
    plain: dict[str, Any] = {}
    for name, value in entity.embedding.attributes.items():
        try:
            plain[name] = plain_value(value)
        except NotPlain:
            continue
    return plain


def primitive_attributes(entity: Entity) -> dict[str, Any]:
    """Return a primitive's attributes as JSON data, including defaults, without those that cannot be serialized."""
    attributes = plain_attributes(entity)
    if entity.shape is None:
        return attributes
    # Values that the geometry normalizes (sizes, points, the color) replace those of the program, but not ``fill``.
    normalized = entity.shape.defining_attributes()
    as_given = {name: value for name, value in attributes.items() if name not in normalized or name == "fill"}
    return {**{name: value for name, value in normalized.items() if name not in as_given}, **as_given}


# Conversion of tagged plain data back to values: the inverse of ``plain_value(value, tagged=True)``.


def value_of(plain: Any, depth: int = 0) -> Any:
    """Convert tagged JSON data to a value of the language.

    Raises ValueError for data that is malformed or nested too deeply; ``depth`` is the nesting of ``plain`` itself.
    """
    if depth > MAX_DEPTH:
        raise ValueError("attribute nested too deeply")
    if isinstance(plain, list):
        return make_list([value_of(item, depth + 1) for item in plain])
    if not isinstance(plain, dict):
        return plain
    if "array" in plain:
        return _read_array(plain["array"])
    if "table" in plain:
        pairs = [(value_of(key, depth + 1), value_of(item, depth + 1)) for key, item in plain["table"]]
        return Table({table_key(key): (key, item) for key, item in pairs}, -1)
    if "embedding" in plain:
        handle, text, attributes = plain["embedding"]
        return Embedding(handle, text, {name: value_of(item, depth + 1) for name, item in attributes.items()})
    raise ValueError("malformed attribute")


def _read_array(data: Any) -> Any:
    """Return the array of nested lists of numbers."""
    if not isinstance(data, list):
        raise ValueError("expected a list of array items")
    if all(isinstance(x, (int, float)) for x in data):
        return array_literal(data)
    return from_numpy(np.array(data))
