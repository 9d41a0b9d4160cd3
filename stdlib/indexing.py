"""Reading by index, key and slice."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import islice
from typing import Any

from scenelang.grammar.diagnostics import SceneError, suggest
from scenelang.interpreter.entity import Entity
from scenelang.interpreter.equality import table_key
from scenelang.interpreter.library import Registry
from scenelang.interpreter.runtime import Runtime
from scenelang.interpreter.show import show
from scenelang.interpreter.types import type_name
from scenelang.interpreter.values import (
    NIL,
    Array,
    Embedding,
    HandleList,
    Keyword,
    Matrix,
    MutableArray,
    MutableList,
    Pair,
    Record,
    Symbol,
    Table,
    Vector,
    list_items,
)
from scenelang.stdlib.arraydata import from_numpy, is_array, shape_of, to_numpy
from scenelang.stdlib.errors import bad_index, endless, kind_of, not_a_sequence
from scenelang.stdlib.items import items, rebuild
from scenelang.stdlib.lists import list_ref

registry = Registry("sequences")

Axis = int | slice

_MOST_KNOWN = 200  # keys among which a misspelt one is looked for


def whole(key: Any, name: str = "ref") -> int:
    """``key`` as an index."""
    if type(key) is int:
        return key
    if type(key) is float and key.is_integer():
        return int(key)
    raise SceneError("type", f"`{name}` wants an Integer for the index, got {type_name(key)}: {show(key, 40)}")


def check_index(index: int, length: int, sequence: Any) -> int:
    """``index``, counted from the front; refuses one that is outside."""
    if -length <= index < length:
        return index + length if index < 0 else index
    raise bad_index(index, length, kind_of(sequence))


# --- ref -------------------------------------------------------------------------------------------------------


def _name_of(key: Any, what: str) -> str:
    if type(key) in (Keyword, Symbol, str):
        return str(key)
    message = f"`ref` wants the name of {what}, such as `:size`, got {type_name(key)}: {show(key, 40)}"
    raise SceneError("type", message)


def missing_key(what: str, key: Any, keys: Iterable[Any]) -> SceneError:
    """The error for a key that a table, record or embedding does not hold."""
    known = list(islice(keys, _MOST_KNOWN))
    hint = None
    if isinstance(key, str):
        hint = suggest(str(key), [str(name) for name in known if isinstance(name, str)])
    if hint is None and 0 < len(known) <= 12:
        hint = "it has " + ", ".join(show(name, 30) for name in known)
    return SceneError("key", f"the {what} has no {show(key, 60)}", hint=hint)


def table_ref(rt: Runtime, table: Table, key: Any, default: tuple[Any, ...]) -> Any:
    """The value under ``key``, else the default if one is given."""
    rt.read(table)
    entry = table.entries.get(table_key(key, rt.charge))
    if entry is not None:
        return entry[1]
    if default:
        return default[0]
    raise missing_key("table", key, (name for name, _ in table.entries.values()))


def _attribute(embedding: Embedding, key: Any, default: tuple[Any, ...]) -> Any:
    name = _name_of(key, "an attribute")
    if name in embedding.attributes:
        return embedding.attributes[name]
    if default:
        return default[0]
    raise missing_key("embedding", Keyword(name), map(Keyword, embedding.attributes))


def field_index(record: Record, key: Any) -> int:
    """The position of a record's field."""
    name = _name_of(key, "a field")
    if name not in record.type.fields:
        raise missing_key(f"record {record.type.name}", Keyword(name), [Keyword(known) for known in record.type.fields])
    return record.type.fields.index(name)


def array_ref(rt: Runtime, array: Any, keys: tuple[Any, ...]) -> Any:
    """The item, or the part, of an array at one index per axis."""
    if type(array) is Vector and len(keys) == 1:
        return array[check_index(whole(keys[0]), len(array), array)]
    if type(array) is MutableArray:
        rt.read(array)
    data = array.data if type(array) in (Array, MutableArray) else to_numpy(rt, array)
    part = data[check_axes(data.shape, keys, "ref")]
    rt.charge(part.size >> 6)
    return from_numpy(part.copy() if type(array) is MutableArray else part)


def check_axes(shape: tuple[int, ...], keys: tuple[Any, ...], name: str) -> tuple[int, ...]:
    """Indices into an array of ``shape``, counted from the front."""
    if len(keys) > len(shape):
        raise SceneError("index", f"`{name}` got {len(keys)} indices for an array of {len(shape)} dimensions")
    out = []
    for axis, (key, side) in enumerate(zip(keys, shape)):
        index = whole(key, name)
        if not -side <= index < side:
            what = "array" if len(shape) > 1 else "vector"
            raise bad_index(index, side, f"{what} along axis {axis}" if axis else what)
        out.append(index % side)
    return tuple(out)


def _item(rt: Runtime, sequence: Any, key: Any) -> Any:
    kind = type(sequence)
    if kind is Pair or sequence is NIL:
        index = whole(key)
        if index >= 0:
            return list_ref(rt, sequence, index)
        members = items(rt, sequence, "ref")
        return members[check_index(index, len(members), sequence)]
    if kind is MutableList:
        rt.read(sequence)
        return sequence.items[check_index(whole(key), len(sequence.items), sequence)]
    if kind is str:
        return sequence[check_index(whole(key), len(sequence), sequence)]
    if kind is HandleList:
        if whole(key) < 0:
            raise endless("ref")
        return rt.handle(f"z{sequence.start + whole(key)}")
    if kind is Entity:
        hint = "its parts are `(cdr entity)`, an attribute is `(ref (entity-embedding entity) :name)`"
        raise SceneError("type", "`ref` wants a sequence, table, embedding or record, got an Entity", hint=hint)
    raise not_a_sequence("ref", sequence)


@registry.define(
    "ref",
    "thing::Any key::Any more::Any ...",
    "Any",
    "The item of a sequence at an index (negative ones count from the end), of a table under a key, an embedding's "
    "attribute or a record's field under its keyword. For tables and embeddings a third argument is the value when "
    "there is none; otherwise further indices go deeper: `(ref rows i j)`.",
    ('(list (ref \'(a b c) -1) (ref (table "x" 1) "y" 0) (ref [[1 2] [3 4]] 1 0))', "(c 0 3)"),
)
def ref(rt: Runtime, thing: Any, key: Any, *more: Any) -> Any:
    kind = type(thing)
    if is_array(thing):
        return array_ref(rt, thing, (key, *more))
    if kind is Table or kind is Embedding:
        if len(more) > 1:
            raise SceneError(
                "arity", f"`ref` of a table or an embedding wants at most 3 arguments, got {2 + len(more)}"
            )
        return table_ref(rt, thing, key, more) if kind is Table else _attribute(thing, key, more)
    if kind is Record:
        rt.read(thing)
        value = thing.values[field_index(thing, key)]
    else:
        value = _item(rt, thing, key)
    return ref(rt, value, *more) if more else value


@registry.define(
    "vector-ref",
    "vector::Array index::Integer",
    "Number",
    "The same as `ref`, for arrays.",
    ("(vector-ref [5 6] 1)", "6"),
)
def vector_ref(rt: Runtime, vector: Any, index: int) -> Any:
    return array_ref(rt, vector, (index,))


@registry.define(
    "string-ref",
    "text::String index::Integer",
    "String",
    "The character at an index, a String of length 1.",
    ('(string-ref "abc" 1)', '"b"'),
)
def string_ref(rt: Runtime, text: str, index: int) -> str:
    return text[check_index(index, len(text), text)]


# --- slice -----------------------------------------------------------------------------------------------------


def _bound(value: Any) -> int | None:
    return None if value is None else whole(value, "slice")


def slice_of(parts: tuple[Any, ...] | list[Any]) -> slice:
    """The Python slice for ``start end step``; none stands for what is left out."""
    start, end, step = (*map(_bound, parts), None, None, None)[:3]
    if step == 0:
        raise SceneError("value", "`slice` wants a step that is not 0")
    return slice(start, end, step)


def _is_range(value: Any) -> bool:
    return type(value) is Pair or value is NIL or (type(value) is Keyword and value == "all")


def axis_selection(shape: tuple[int, ...], keys: tuple[Any, ...], name: str) -> tuple[Axis, ...]:
    """What is selected of an array: per axis an index, ``:all``, or a list ``(start end step)``."""
    if len(keys) > len(shape):
        raise SceneError("index", f"`{name}` got {len(keys)} indices for an array of {len(shape)} dimensions")
    out: list[Axis] = []
    for axis, key in enumerate(keys):
        if type(key) is Keyword:
            if key != "all":
                raise SceneError("value", f"`{name}` wants an index, `:all` or a list of bounds, got :{key}")
            out.append(slice(None))
        elif type(key) is Pair or key is NIL:
            parts = list_items(key)
            if not 1 <= len(parts) <= 3:
                raise SceneError("value", f"`{name}` wants bounds such as '(0 2), got {show(key, 40)}")
            out.append(slice_of(parts))
        else:
            out.extend(check_axes(shape[axis : axis + 1], (key,), name))
    return tuple(out)


def _slice_array(rt: Runtime, array: Any, keys: tuple[Any, ...]) -> Any:
    if len(shape_of(array)) == 1 and not any(map(_is_range, keys)):
        if type(array) is Vector:
            part = array[slice_of(keys)]
            rt.charge(len(part) >> 6)
            return Vector(part)
        return from_numpy(to_numpy(rt, array)[slice_of(keys)])
    data = array.data if type(array) is Array else to_numpy(rt, array)
    selected = data[axis_selection(data.shape, keys, "slice")]
    rt.charge(selected.size >> 6)
    return from_numpy(selected)


@registry.define(
    "slice",
    "xs::Sequence start::Any more::Any ...",
    "Sequence",
    "`(slice xs start end step)`: the items from `start` up to `end`, as Python slices; none stands for a bound that "
    "is left out. Of an array with more dimensions: per axis an index, `:all` or a list '(start end).",
    (
        '(list (slice \'(a b c d) 1 -1) (slice "scene" none none -1) (slice [[1 2] [3 4]] :all 0))',
        '((b c) "enecs" [1 3])',
    ),
)
def slice_(rt: Runtime, xs: Any, start: Any, *more: Any) -> Any:
    if isinstance(xs, (Vector, Matrix, Array, MutableArray)):
        return _slice_array(rt, xs, (start, *more))
    if len(more) > 2:
        raise SceneError("arity", f"`slice` wants 2 to 4 arguments, got {2 + len(more)}")
    cut = slice_of((start, *more))
    if type(xs) is str:
        rt.charge(len(xs) >> 8)
        return xs[cut]
    return rebuild(rt, xs, items(rt, xs, "slice")[cut])


@registry.define(
    "substring",
    "text::String start::Integer [end::Integer]",
    "String",
    "The characters from `start` up to `end`, which must lie inside the text.",
    ('(substring "chair leg" 0 5)', '"chair"'),
)
def substring(rt: Runtime, text: str, start: int, end: int | None = None) -> str:
    last = len(text) if end is None else end
    for index in (start, last):
        if not 0 <= index <= len(text):
            raise bad_index(index, len(text), "string")
    if start > last:
        raise SceneError("index", f"`substring` wants a start that is not behind the end, got {start} and {last}")
    rt.charge((last - start) >> 8)
    return text[start:last]
