"""Builtins for sequences of every type: length, access, order, search, conversion, slices and sorting."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import islice
from typing import TYPE_CHECKING, Any

from scenelang.grammar.diagnostics import SceneError, suggest
from scenelang.interpreter.runtime.show import described, show
from scenelang.interpreter.runtime.types import Registry, type_name
from scenelang.interpreter.scene.entity import Entity
from scenelang.interpreter.values.values import (
    NIL,
    Array,
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
    Set,
    Symbol,
    Table,
    Vector,
    list_items,
    make_list,
    table_key,
)
from scenelang.stdlib.lists import car_of, cdr_of, drop_front, list_ref, take_front
from scenelang.stdlib.operands import (
    ARRAYS,
    bad_index,
    blocks,
    empty_sequence,
    from_numpy,
    infinite_error,
    is_array,
    is_true,
    items,
    iterate,
    kind_of,
    length,
    not_a_sequence,
    rebuild,
    same_value,
    shape_of,
    to_numpy,
)

if TYPE_CHECKING:
    from scenelang.interpreter.runtime.runtime import Runtime

registry = Registry("sequences")

_INT64 = 1 << 63  # longer integers are charged for their memory


# --- length and ends -------------------------------------------------------------------------------------------


@registry.define("length", "xs::Sequence", "Integer",
                 "Return the number of items; of an array along its first axis, of a table the number of keys.",
                 ("(list (length '(a b)) (length \"abc\") (length [1 2 3 4]))", "(2 3 4)"))  # fmt: skip
def length_(rt: Runtime, xs: Any) -> int:
    return length(rt, xs)


@registry.define(
    "string-length", "text::String", "Integer", "Return the number of characters.", ('(string-length "abc")', "3")
)
def string_length(rt: Runtime, text: str) -> int:
    return len(text)


@registry.define("vector-length", "vector::Array", "Integer", "Return the number of items along the first axis.",
                 ("(vector-length [5 6])", "2"))  # fmt: skip
def vector_length(rt: Runtime, vector: Any) -> int:
    return length(rt, vector)


@registry.define("empty?", "xs::Sequence", "Boolean", "Return whether a sequence has no items.",
                 ("(list (empty? '()) (empty? \"\") (empty? (set 1)))", "(#t #t #f)"))  # fmt: skip
def is_empty(rt: Runtime, xs: Any) -> bool:
    return type(xs) is not Pair and length(rt, xs, "empty?") == 0


def _nth(rt: Runtime, xs: Any, index: int, name: str) -> Any:
    """Return the item at a small index of any sequence."""
    if isinstance(xs, (Pair, HandleList)):
        for _ in range(index):
            xs = cdr_of(rt, xs, name)
        return car_of(rt, xs, name)
    members = items(rt, xs, name)
    if index >= len(members):
        raise bad_index(index, len(members), kind_of(xs))
    return members[index]


@registry.define("first", "xs::Any", "Any", "Return the first item of a sequence.", ("(first [5 6 7])", "5"))
def first(rt: Runtime, xs: Any) -> Any:
    return _nth(rt, xs, 0, "first")


@registry.define("second", "xs::Any", "Any", "Return the second item of a sequence.", ("(second '(a b c))", "b"))
def second(rt: Runtime, xs: Any) -> Any:
    return _nth(rt, xs, 1, "second")


@registry.define("third", "xs::Any", "Any", "Return the third item of a sequence.", ("(third [5 6 7])", "7"))
def third(rt: Runtime, xs: Any) -> Any:
    return _nth(rt, xs, 2, "third")


@registry.define("last", "xs::Sequence", "Any", "Return the last item of a sequence.", ("(last '(a b c))", "c"))
def last(rt: Runtime, xs: Any) -> Any:
    members = items(rt, xs, "last")
    if not members:
        raise empty_sequence("last")
    return members[-1]


@registry.define(
    "rest", "xs::Any", "Sequence", "Return a sequence without its first item.", ("(rest '(a b c))", "(b c)")
)
def rest(rt: Runtime, xs: Any) -> Any:
    if isinstance(xs, (Pair, HandleList)):
        return cdr_of(rt, xs, "rest")
    members = items(rt, xs, "rest")
    if not members:
        raise empty_sequence("rest")
    return rebuild(rt, xs, members[1:])


def _check_count(count: int, members: list[Any], xs: Any) -> None:
    """Raise SceneError if a sequence has fewer than ``count`` items."""
    if not 0 <= count <= len(members):
        raise bad_index(count, len(members), kind_of(xs))


@registry.define("take", "xs::Any count::Integer", "Sequence", "Return the first `count` items; fewer are an error.",
                 ("(take '(a b c) 2)", "(a b)"))  # fmt: skip
def take(rt: Runtime, xs: Any, count: int) -> Any:
    if isinstance(xs, (Pair, HandleList)):
        return make_list(take_front(rt, xs, count, "take"))
    members = items(rt, xs, "take")
    _check_count(count, members, xs)
    return rebuild(rt, xs, members[:count])


@registry.define("drop", "xs::Any count::Integer", "Sequence", "Return all but the first `count` items.",
                 ("(drop [1 2 3] 1)", "[2 3]"))  # fmt: skip
def drop(rt: Runtime, xs: Any, count: int) -> Any:
    if isinstance(xs, (Pair, HandleList)):
        return drop_front(rt, xs, count, "drop")
    members = items(rt, xs, "drop")
    _check_count(count, members, xs)
    return rebuild(rt, xs, members[count:])


# --- order and shape -------------------------------------------------------------------------------------------


@registry.define("reverse", "xs::Sequence", "Sequence", "Return the items in reverse order; a string stays a string.",
                 ("(list (reverse '(1 2 3)) (reverse \"abc\"))", '((3 2 1) "cba")'))  # fmt: skip
def reverse(rt: Runtime, xs: Any) -> Any:
    return rebuild(rt, xs, items(rt, xs, "reverse")[::-1])


@registry.define("zip", "sequences::Sequence ...", "List",
                 "Return the list of lists with the i-th item of each sequence, up to the length of the shortest.",
                 ("(zip '(a b c) [1 2])", "((a 1) (b 2))"))  # fmt: skip
def zip_(rt: Runtime, *sequences: Any) -> Any:
    columns = [items(rt, xs, "zip") for xs in sequences]
    rows = list(zip(*columns))
    return make_list([make_list(row) for block in blocks(rt, rows) for row in block])


@registry.define("enumerate", "xs::Sequence [start::Integer]", "List",
                 "Return the list of lists (index item), counted from `start` (default 0).",
                 ("(enumerate '(a b))", "((0 a) (1 b))"))  # fmt: skip
def enumerate_(rt: Runtime, xs: Any, start: int = 0) -> Any:
    members = items(rt, xs, "enumerate")
    if not -_INT64 < start < _INT64:
        rt.meter.reserve(len(members) * start.bit_length() >> 3)
        rt.charge(len(members) * start.bit_length() >> 13)
    pairs = enumerate(members, start)
    return make_list([make_list(pair) for block in blocks(rt, members) for pair in islice(pairs, len(block))])


@registry.define("repeat", "xs::Sequence count::Integer", "Sequence",
                 "Return the items of a sequence `count` times in a row. `make-list` repeats one value.",
                 ("(list (repeat '(1 2) 2) (repeat \"ab\" 3))", '((1 2 1 2) "ababab")'))  # fmt: skip
def repeat(rt: Runtime, xs: Any, count: int) -> Any:
    count = max(0, count)
    kind = "a string" if type(xs) is str else "a list"
    rt.meter.check_size(length(rt, xs, "repeat") * count, kind)
    if type(xs) is str:
        return xs * count
    return rebuild(rt, xs, items(rt, xs, "repeat") * count)


@registry.define("flatten", "xs::Sequence", "Sequence",
                 "Return the items of a list and of all lists nested in it as one list; for an array, all its numbers "
                 "as one vector.",
                 ("(list (flatten '(1 (2 (3)) ())) (flatten [[1 2] [3 4]]))", "((1 2 3) [1 2 3 4])"))  # fmt: skip
def flatten(rt: Runtime, xs: Any) -> Any:
    if isinstance(xs, ARRAYS):
        data = to_numpy(rt, xs)
        rt.charge(data.size >> 5)
        return from_numpy(data.ravel())
    out: list[Any] = []
    stack: list[Any] = items(rt, xs, "flatten")[::-1]  # iterative, because lists may be nested to any depth
    while stack:
        item = stack.pop()
        rt.charge(1)
        if item is NIL:
            continue
        if type(item) is MutableList or (type(item) is Pair and _is_proper(rt, item)):
            stack.extend(reversed(items(rt, item, "flatten")))
        else:
            out.append(item)
            rt.meter.check_growth(len(out), "a list")
    return make_list(out)


def _is_proper(rt: Runtime, value: Any) -> bool:
    """Return whether a chain of pairs ends in the empty list."""
    count = 0
    while type(value) is Pair:
        value = value.cdr
        count += 1
    rt.charge(count >> 4)
    return value is NIL


# --- search ----------------------------------------------------------------------------------------------------


def contains(rt: Runtime, xs: Any, x: Any) -> bool:
    """Return whether ``x`` is a member, a key, or a part of a string."""
    kind = type(xs)
    if kind is Set or kind is Table:
        rt.read(xs)
        return table_key(x, rt.charge) in xs.entries
    if kind is str:
        rt.charge(len(xs) >> 5)
        return type(x) is str and x in xs
    return position_of(rt, xs, x, "contains?") is not None


def position_of(rt: Runtime, xs: Any, x: Any, name: str) -> int | None:
    """Return the first index of ``x`` in a sequence, or None; ``name`` is the builtin that errors name."""
    if type(xs) is str:
        rt.charge(len(xs) >> 5)
        position = xs.find(x) if type(x) is str else -1
        return None if position < 0 else position
    members = items(rt, xs, name, ordered=False)
    rt.charge(len(members) >> 2)
    if type(x) is str:
        return next((index for index, item in enumerate(members) if type(item) is str and item == x), None)
    if type(x) is int or type(x) is float:
        return next((index for index, item in enumerate(members) if type(item) in (int, float) and item == x), None)
    return next((index for index, item in enumerate(members) if same_value(rt, item, x)), None)


@registry.define("contains?", "xs::Sequence x::Any", "Boolean",
                 "Return whether `x` is an item of a sequence, a key of a table or a part of a string. Numbers "
                 "compare by value.",
                 ("(list (contains? '(1 2) 2.) (contains? \"chair leg\" \"leg\"))", "(#t #t)"))  # fmt: skip
def contains_(rt: Runtime, xs: Any, x: Any) -> bool:
    return contains(rt, xs, x)


@registry.define("index-of", "xs::Sequence x::Any", "Any", "Return the index of the first item equal to `x`, or #f.",
                 ("(list (index-of '(a b) 'b) (index-of [1 2] 5))", "(1 #f)"))  # fmt: skip
def index_of(rt: Runtime, xs: Any, x: Any) -> Any:
    index = position_of(rt, xs, x, "index-of")
    return False if index is None else index


@registry.define("count", "xs::Any x::Any", "Integer",
                 "Return the number of items equal to `x`; `(count f xs)` returns the number of items for which `f` "
                 "is true.",
                 ("(list (count '(1 2 1) 1) (count odd? '(1 2 3)))", "(2 2)"))  # fmt: skip
def count(rt: Runtime, xs: Any, x: Any) -> int:
    total = 0
    if isinstance(xs, Procedure):  # `(count f xs)`
        for item in iterate(rt, x, "count"):
            result = rt.call1(xs, item)
            total += result is not False and result is not None
        return total
    if type(xs) is str:
        rt.charge(len(xs) >> 5)
        return xs.count(x) if type(x) is str and x else 0
    for item in items(rt, xs, "count", ordered=False):
        rt.charge(1)
        total += same_value(rt, item, x)
    return total


@registry.define("delete-duplicates", "xs::Sequence", "List",
                 "Return the items without those equal to an earlier one; numbers compare by value.",
                 ("(delete-duplicates '(1 2 1. 3 2))", "(1 2 3)"))  # fmt: skip
def delete_duplicates(rt: Runtime, xs: Any) -> Any:
    distinct: dict[Any, Any] = {}
    for item in items(rt, xs, "delete-duplicates"):
        rt.charge(1)
        distinct.setdefault(table_key(item, rt.charge), item)
    return make_list(list(distinct.values()))


@registry.define("delete", "xs::Sequence x::Any", "List",
                 "Return the items that are not equal to `x`; numbers compare by value.",
                 ("(delete '(1 2 1) 1)", "(2)"))  # fmt: skip
def delete(rt: Runtime, xs: Any, x: Any) -> Any:
    out = []
    for item in items(rt, xs, "delete"):
        rt.charge(1)
        if not same_value(rt, item, x):
            out.append(item)
    return make_list(out)


# --- conversions -----------------------------------------------------------------------------------------------


@registry.define("->list", "xs::Sequence", "List",
                 "Convert any sequence to a list: characters of a string, keys of a table, rows of an array.",
                 ("(->list [1 2])", "(1 2)"))  # fmt: skip
def to_list(rt: Runtime, xs: Any) -> Any:
    if type(xs) is Pair or xs is NIL:
        length(rt, xs, "->list")
        return xs
    return make_list(items(rt, xs, "->list"))


@registry.define("string->list", "text::String", "List", "Return the characters of a text, as Strings of length 1.",
                 ('(string->list "abc")', '("a" "b" "c")'))  # fmt: skip
def string_to_list(rt: Runtime, text: str) -> Any:
    return make_list(items(rt, text))


@registry.define("vector->list", "vector::Array", "List", "Return the items of an array as a list.",
                 ("(vector->list [1 2])", "(1 2)"))  # fmt: skip
def vector_to_list(rt: Runtime, vector: Any) -> Any:
    return make_list(items(rt, vector))


@registry.define("mutable", "xs::Sequence", "Any",
                 "Return a mutable copy: a mutable array of an array, a new table or set of a table or set, otherwise "
                 "a mutable list.",
                 ("(let ((xs (mutable '(1 2)))) (push! xs 3) xs)", "(mutable-list 1 2 3)"))  # fmt: skip
def mutable(rt: Runtime, xs: Any) -> Any:
    if isinstance(xs, (Vector, Matrix, Array, MutableArray)):  # an array stays an array, so that arithmetic works on it
        return MutableArray(to_numpy(rt, xs).copy(), rt.clock)
    if isinstance(xs, Mutable):
        rt.read(xs)
    if type(xs) is Table or type(xs) is Set:
        rt.charge(len(xs.entries) >> 4)
    if type(xs) is Table:
        return rt.table_of(dict(xs.entries))
    if type(xs) is Set:
        return rt.set_of(dict(xs.entries))
    return rt.mutable_list(items(rt, xs, "mutable"))


@registry.define("mutable-list", "items::Any ...", "MutableList",
                 "Return a mutable list of the arguments; `push!`, `set-ref!`, `remove!` and others modify it.",
                 ("(mutable-list 1 2)", "(mutable-list 1 2)"))  # fmt: skip
def mutable_list(rt: Runtime, *members: Any) -> Any:
    return rt.mutable_list(list(members))


@registry.define("mutable-array", "data::ArrayLike", "MutableArray",
                 "Return a mutable array of an array or nested lists of numbers; `set-ref!` modifies it.",
                 ("(let ((a (mutable-array [1 2 3]))) (set-ref! a 0 9) a)", "(mutable-array [9 2 3])"))  # fmt: skip
def mutable_array(rt: Runtime, data: Any) -> Any:
    copy = to_numpy(rt, data, "mutable-array").copy()
    if copy.ndim == 0:
        raise SceneError("type", f"`mutable-array` expects an array or a list of numbers, got {type_name(data)}")
    return MutableArray(copy, rt.clock)


# --- access by index and key -----------------------------------------------------------------------------------

Axis = int | slice

_MAX_SUGGESTED = 200  # keys that are searched for a misspelt one


def to_index(key: Any, name: str = "ref") -> int:
    """Return ``key`` as an index; it must be a whole number."""
    if type(key) is int:
        return key
    if type(key) is float and key.is_integer():
        return int(key)
    raise SceneError("type", f"`{name}` expects an Integer as the index, got {described(key, 40)}")


def check_index(index: int, length: int, sequence: Any) -> int:
    """Return ``index`` counted from the start; one outside the sequence is an error."""
    if -length <= index < length:
        return index + length if index < 0 else index
    raise bad_index(index, length, kind_of(sequence))


# --- ref -------------------------------------------------------------------------------------------------------


def _name_of(key: Any, kind: str) -> str:
    if type(key) in (Keyword, Symbol, str):
        return str(key)
    message = f"`ref` expects the name of {kind}, such as `:size`, got {described(key, 40)}"
    raise SceneError("type", message)


def missing_key(owner: str, key: Any, keys: Iterable[Any]) -> SceneError:
    """Return the error for a key that a table, record or embedding does not have.

    ``owner`` is its type, for the message; the hint has a similar one of its ``keys``.
    """
    known = list(islice(keys, _MAX_SUGGESTED))
    hint = None
    if isinstance(key, str):
        hint = suggest(str(key), [str(name) for name in known if isinstance(name, str)])
    if hint is None and 0 < len(known) <= 12:
        hint = "its keys are " + ", ".join(show(name, 30) for name in known)
    return SceneError("key", f"the {owner} does not contain {show(key, 60)}", hint=hint)


def table_ref(rt: Runtime, table: Table, key: Any, default: tuple[Any, ...]) -> Any:
    """Return the value of ``key``, or the default if one is given."""
    rt.read(table)
    entry = table.entries.get(table_key(key, rt.charge))
    if entry is not None:
        return entry[1]
    if default:
        return default[0]
    raise missing_key("table", key, (name for name, _ in table.entries.values()))


def _attribute(embedding: Embedding, key: Any, default: tuple[Any, ...]) -> Any:
    """Return an attribute of an embedding, or the default if there is one."""
    name = _name_of(key, "an attribute")
    if name in embedding.attributes:
        return embedding.attributes[name]
    if default:
        return default[0]
    raise missing_key("embedding", Keyword(name), map(Keyword, embedding.attributes))


def field_index(record: Record, key: Any) -> int:
    """Return the position of a record's field."""
    name = _name_of(key, "a field")
    if name not in record.type.fields:
        raise missing_key(f"record {record.type.name}", Keyword(name), [Keyword(field) for field in record.type.fields])
    return record.type.fields.index(name)


def array_ref(rt: Runtime, array: Any, keys: tuple[Any, ...]) -> Any:
    """Return the item or the subarray of an array at one index per axis."""
    if type(array) is Vector and len(keys) == 1:
        return array[check_index(to_index(keys[0]), len(array), array)]
    if type(array) is MutableArray:
        rt.read(array)
    data = array.data if type(array) in (Array, MutableArray) else to_numpy(rt, array)
    part = data[check_axes(data.shape, keys, "ref")]
    rt.charge(part.size >> 6)
    return from_numpy(part.copy() if type(array) is MutableArray else part)


def check_axes(shape: tuple[int, ...], keys: tuple[Any, ...], name: str) -> tuple[int, ...]:
    """Return the indices into an array of ``shape``, counted from the start."""
    if len(keys) > len(shape):
        message = f"too many indices for `{name}`: the array is {len(shape)}-dimensional, got {len(keys)}"
        raise SceneError("index", message)
    out = []
    for axis, (key, side) in enumerate(zip(keys, shape)):
        index = to_index(key, name)
        if not -side <= index < side:
            kind = "array" if len(shape) > 1 else "vector"
            raise bad_index(index, side, f"{kind} along axis {axis}" if axis else kind)
        out.append(index % side)
    return tuple(out)


def _item(rt: Runtime, sequence: Any, key: Any) -> Any:
    """Return the item of a list, string or the list of handles at an index."""
    kind = type(sequence)
    if kind is Pair or sequence is NIL:
        index = to_index(key)
        if index >= 0:
            return list_ref(rt, sequence, index)
        members = items(rt, sequence, "ref")
        return members[check_index(index, len(members), sequence)]
    if kind is MutableList:
        rt.read(sequence)
        return sequence.items[check_index(to_index(key), len(sequence.items), sequence)]
    if kind is str:
        return sequence[check_index(to_index(key), len(sequence), sequence)]
    if kind is HandleList:
        if to_index(key) < 0:
            raise infinite_error("ref")
        return rt.handle(f"z{sequence.start + to_index(key)}")
    if kind is Entity:
        hint = "for its parts, write `(cdr entity)`; for an attribute, `(ref (entity-embedding entity) :name)`"
        raise SceneError("type", "`ref` expects a sequence, table, embedding or record, got an Entity", hint=hint)
    raise not_a_sequence("ref", sequence)


@registry.define(
    "ref",
    "collection::Any key::Any more::Any ...",
    "Any",
    "Return the item of a sequence at an index (a negative one counts from the end), the value of a table for a key, "
    "or an attribute of an embedding or a field of a record for its keyword. For tables and embeddings a third "
    "argument is the default for a missing key; otherwise further indices select in the item: `(ref rows i j)`.",
    ('(list (ref \'(a b c) -1) (ref (table "x" 1) "y" 0) (ref [[1 2] [3 4]] 1 0))', "(c 0 3)"),
    intrinsic="ref",
)
def ref(rt: Runtime, collection: Any, key: Any, *more: Any) -> Any:
    kind = type(collection)
    if is_array(collection):
        return array_ref(rt, collection, (key, *more))
    if kind is Table or kind is Embedding:  # the third argument is a default, not a further index
        if len(more) > 1:
            message = f"`ref` of a table or an embedding expects at most 3 arguments, got {2 + len(more)}"
            raise SceneError("arity", message)
        return table_ref(rt, collection, key, more) if kind is Table else _attribute(collection, key, more)
    if kind is Record:
        rt.read(collection)
        value = collection.values[field_index(collection, key)]
    else:
        value = _item(rt, collection, key)
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
    "Return the character at an index, a String of length 1.",
    ('(string-ref "abc" 1)', '"b"'),
)
def string_ref(rt: Runtime, text: str, index: int) -> str:
    return text[check_index(index, len(text), text)]


# --- slice -----------------------------------------------------------------------------------------------------


def _bound(value: Any) -> int | None:
    """Return a bound of a slice; none omits it."""
    return None if value is None else to_index(value, "slice")


def slice_of(parts: tuple[Any, ...] | list[Any]) -> slice:
    """Return the Python slice for ``start end step``; none omits a bound."""
    start, end, step = (*map(_bound, parts), None, None, None)[:3]
    if step == 0:
        raise SceneError("value", "`slice` expects a step that is not 0")
    return slice(start, end, step)


def _is_range(value: Any) -> bool:
    """Return whether a key selects several items along an axis: a list of bounds, or ``:all``."""
    return type(value) is Pair or value is NIL or (type(value) is Keyword and value == "all")


def axis_selection(shape: tuple[int, ...], keys: tuple[Any, ...], name: str) -> tuple[Axis, ...]:
    """Return the numpy index of a selection from an array of ``shape``.

    Parameters
    ----------
    keys
        For each axis an index, ``:all``, or a list ``(start end step)``.
    name
        Builtin that error messages name.

    Raises
    ------
    SceneError
        If a key is malformed or outside its axis.
    """
    if len(keys) > len(shape):
        message = f"too many indices for `{name}`: the array is {len(shape)}-dimensional, got {len(keys)}"
        raise SceneError("index", message)
    out: list[Axis] = []
    for axis, key in enumerate(keys):
        if type(key) is Keyword:
            if key != "all":
                raise SceneError("value", f"`{name}` expects an index, `:all` or a list of bounds, got :{key}")
            out.append(slice(None))
        elif type(key) is Pair or key is NIL:
            parts = list_items(key)
            if not 1 <= len(parts) <= 3:
                raise SceneError("value", f"`{name}` expects bounds such as '(0 2), got {show(key, 40)}")
            out.append(slice_of(parts))
        else:
            out.extend(check_axes(shape[axis : axis + 1], (key,), name))
    return tuple(out)


def _slice_array(rt: Runtime, array: Any, keys: tuple[Any, ...]) -> Any:
    """Return a slice of an array: bounds of a vector, or a selection for each axis."""
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
    "`(slice xs start end step)`: return the items from `start` up to but excluding `end`, as Python slices; none "
    "omits a bound. For an array with more dimensions: an index, `:all` or a list '(start end) for each axis.",
    (
        '(list (slice \'(a b c d) 1 -1) (slice "scene" none none -1) (slice [[1 2] [3 4]] :all 0))',
        '((b c) "enecs" [1 3])',
    ),
)
def slice_(rt: Runtime, xs: Any, start: Any, *more: Any) -> Any:
    if isinstance(xs, (Vector, Matrix, Array, MutableArray)):
        return _slice_array(rt, xs, (start, *more))
    if len(more) > 2:
        raise SceneError("arity", f"`slice` expects 2 to 4 arguments, got {2 + len(more)}")
    bounds = slice_of((start, *more))
    if type(xs) is str:
        rt.charge(len(xs) >> 8)
        return xs[bounds]
    return rebuild(rt, xs, items(rt, xs, "slice")[bounds])


@registry.define(
    "substring",
    "text::String start::Integer [end::Integer]",
    "String",
    "Return the characters from `start` up to but excluding `end`; both must be within the text.",
    ('(substring "chair leg" 0 5)', '"chair"'),
)
def substring(rt: Runtime, text: str, start: int, end: int | None = None) -> str:
    last = len(text) if end is None else end
    for index in (start, last):
        if not 0 <= index <= len(text):
            raise bad_index(index, len(text), "string")
    if start > last:
        raise SceneError("index", f"`substring` expects a start up to the end, got {start} and {last}")
    rt.charge((last - start) >> 8)
    return text[start:last]


# --- order -----------------------------------------------------------------------------------------------------

_MAX_DEPTH = 30  # of nested lists that are compared
_BLOCK_ITEMS = 1 << 16  # that are sorted between two checks of the limits


def sort_key(rt: Runtime, value: Any, depth: int = 0) -> Any:
    """Return Python data that have the order of ``value`` in the language.

    ``depth`` is the nesting of the value itself, which is limited because the function is recursive.
    """
    kind = type(value)
    if kind is int or kind is float or kind is str or kind is bool:
        return value
    if kind is Pair or value is NIL or kind is MutableList or kind is Vector:
        if depth == _MAX_DEPTH:
            raise SceneError("value", f"lists nested deeper than {_MAX_DEPTH} levels cannot be compared")
        rt.charge(1)
        return [sort_key(rt, item, depth + 1) for item in items(rt, value, "sort")]
    if depth:
        return value  # not comparable, but an earlier item may determine the order
    message = f"expected numbers, strings or lists of these to compare, got {described(value, 60)}"
    raise SceneError("type", message, hint="to compare other values, add `:key` or a function such as `<`")


def keys_of(rt: Runtime, members: list[Any], key: Any) -> list[Any]:
    """Return the sort keys of the items."""
    if key is None:
        return [sort_key(rt, item) for item in members]
    return [sort_key(rt, rt.call1(key, item)) for item in members]


def no_order(members: list[Any]) -> SceneError:
    """Return the error for items that cannot be compared."""
    kinds = list(dict.fromkeys(type_name(item) for item in members))
    mixed = " and ".join(kinds[:2]) if len(kinds) > 1 else "items of different types"
    return SceneError(
        "type", f"cannot compare {mixed}", hint="add `:key` with a function that returns comparable values"
    )


def sorted_items(rt: Runtime, members: list[Any], less: Any, key: Any, reverse: bool) -> list[Any]:
    """Return ``members`` in ascending order; the sort is stable, also in reverse.

    Parameters
    ----------
    less
        Function of the program that replaces ``<``, or None.
    key
        Function of the program that returns the value to compare by, or None for the item itself.
    reverse
        Whether the order is descending.

    Raises
    ------
    SceneError
        If items cannot be compared.
    """
    if less is not None:
        keyed = [(member, member if key is None else rt.call1(key, member)) for member in members]
        if reverse:
            keyed.reverse()
        ordered = [member for member, _ in _merge_sort(rt, keyed, less)]
        return ordered[::-1] if reverse else ordered
    keys = keys_of(rt, members, key)
    try:
        order = _order(rt, keys, reverse=reverse)
    except TypeError:
        raise no_order(members) from None
    return [members[index] for index in order]


def _order(rt: Runtime, keys: list[Any], *, reverse: bool) -> list[int]:
    """Return the indices of ``keys`` in order.

    Sorted blocks are merged in pairs, each in linear time by Python's Timsort, so that the limits are checked between.
    """
    order = list(range(len(keys)))
    width = _BLOCK_ITEMS
    while True:
        for start in range(0, len(order), width):
            rt.charge(min(width, len(order) - start) >> 3)
            order[start : start + width] = sorted(order[start : start + width], key=keys.__getitem__, reverse=reverse)
        if width >= len(order):
            return order
        width *= 2


def _merge_sort(rt: Runtime, pairs: list[Any], less: Any) -> list[Any]:
    """Sort stably by a bottom-up merge sort.

    ``less`` is a function of the program, which may raise or escape, so Python's own sort must not call it.
    """
    width = 1
    while width < len(pairs):
        merged: list[Any] = []
        for start in range(0, len(pairs), 2 * width):
            left, right = pairs[start : start + width], pairs[start + width : start + 2 * width]
            merged += _merge(rt, left, right, less)
        pairs = merged
        width *= 2
    return pairs


def _merge(rt: Runtime, left: list[Any], right: list[Any], less: Any) -> list[Any]:
    """Merge two sorted lists; of equal items, those of ``left`` come first."""
    out = []
    i = j = 0
    while i < len(left) and j < len(right):
        if is_true(rt.call2(less, right[j][1], left[i][1])):
            out.append(right[j])
            j += 1
        else:
            out.append(left[i])
            i += 1
    return out + left[i:] + right[j:]


def rebuild_template(value: Any) -> Any:
    """Return a value of the type that the sorted or shuffled items of ``value`` have, as ``original`` of ``rebuild``.

    It is ``value`` itself for a one-dimensional array, and the empty list for all other sequences.
    """
    if type(value) is Vector or (type(value) is MutableArray and value.data.ndim == 1):
        return value
    return NIL


@registry.define(
    "sort",
    "xs::Sequence [less::Function] [:key::Function] [:reverse::Boolean]",
    "Sequence",
    "Return the items in ascending order: numbers, strings, or lists compared item by item; the sort is stable. "
    "`:key` is the function to compare by, `:reverse #t` sorts in descending order, `less` replaces `<`.",
    ("(list (sort '(3 1 2)) (sort '((a 2) (b 1)) :key second) (sort '(1 2 3) >))", "((1 2 3) ((b 1) (a 2)) (3 2 1))"),
)
def sort(rt: Runtime, xs: Any, less: Any = None, *, key: Any = None, reverse: bool = False) -> Any:
    ordered = sorted_items(rt, list(iterate(rt, xs, "sort")), less, key, reverse)
    return rebuild(rt, rebuild_template(xs), ordered)


def _extreme(rt: Runtime, name: str, xs: Any, key: Any, *, largest: bool) -> Any:
    """Return the first item with the smallest or largest key."""
    members = list(iterate(rt, xs, name))
    if not members:
        raise empty_sequence(name)
    keys = keys_of(rt, members, key)
    best = 0
    try:
        for index in range(1, len(keys)):
            if not index & 63:
                rt.charge(4)
            if keys[index] > keys[best] if largest else keys[index] < keys[best]:
                best = index
    except TypeError:
        raise no_order(members) from None
    return members[best]


@registry.define(
    "min-of",
    "xs::Sequence [:key::Function]",
    "Any",
    "Return the smallest item, in natural order or by `:key`; of equal ones the first.",
    ("(min-of '((a 3) (b 1)) :key second)", "(b 1)"),
)
def min_of(rt: Runtime, xs: Any, *, key: Any = None) -> Any:
    return _extreme(rt, "min-of", xs, key, largest=False)


@registry.define(
    "max-of",
    "xs::Sequence [:key::Function]",
    "Any",
    "Return the largest item, in natural order or by `:key`; of equal ones the first.",
    ('(max-of \'("oak" "birch" "ash") :key length)', '"birch"'),
)
def max_of(rt: Runtime, xs: Any, *, key: Any = None) -> Any:
    return _extreme(rt, "max-of", xs, key, largest=True)
