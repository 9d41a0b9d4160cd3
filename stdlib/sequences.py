"""Sequences of every kind: length, ends, order, search."""

from __future__ import annotations

from itertools import islice
from typing import Any

from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.equality import table_key
from scenelang.interpreter.library import Registry
from scenelang.interpreter.runtime import Runtime
from scenelang.interpreter.types import type_name
from scenelang.interpreter.values import (
    NIL,
    Array,
    HandleList,
    Matrix,
    Mutable,
    MutableArray,
    MutableList,
    Pair,
    Procedure,
    Set,
    Table,
    Vector,
    make_list,
)
from scenelang.stdlib.arraydata import ARRAYS, from_numpy, to_numpy
from scenelang.stdlib.errors import bad_index, empty_sequence, kind_of
from scenelang.stdlib.items import blocks, items, iterate, length, rebuild
from scenelang.stdlib.lists import car_of, cdr_of, drop_front, take_front
from scenelang.stdlib.predicates import same_value

registry = Registry("sequences")

_INT64 = 1 << 63


# --- length and ends -------------------------------------------------------------------------------------------


@registry.define("length", "xs::Sequence", "Integer",
                 "The number of items; of an array along its first axis, of a table its keys.",
                 ("(list (length '(a b)) (length \"abc\") (length [1 2 3 4]))", "(2 3 4)"))  # fmt: skip
def length_(rt: Runtime, xs: Any) -> int:
    return length(rt, xs)


@registry.define(
    "string-length", "text::String", "Integer", "The number of characters.", ('(string-length "abc")', "3")
)
def string_length(rt: Runtime, text: str) -> int:
    return len(text)


@registry.define("vector-length", "vector::Array", "Integer", "The number of items along the first axis.",
                 ("(vector-length [5 6])", "2"))  # fmt: skip
def vector_length(rt: Runtime, vector: Any) -> int:
    return length(rt, vector)


@registry.define("empty?", "xs::Sequence", "Boolean", "True for a sequence without items.",
                 ("(list (empty? '()) (empty? \"\") (empty? (set 1)))", "(#t #t #f)"))  # fmt: skip
def is_empty(rt: Runtime, xs: Any) -> bool:
    return type(xs) is not Pair and length(rt, xs, "empty?") == 0


def _nth(rt: Runtime, xs: Any, index: int, name: str) -> Any:
    if isinstance(xs, (Pair, HandleList)):
        for _ in range(index):
            xs = cdr_of(rt, xs, name)
        return car_of(rt, xs, name)
    members = items(rt, xs, name)
    if index >= len(members):
        raise bad_index(index, len(members), kind_of(xs))
    return members[index]


@registry.define("first", "xs::Any", "Any", "The first item of a sequence.", ("(first [5 6 7])", "5"))
def first(rt: Runtime, xs: Any) -> Any:
    return _nth(rt, xs, 0, "first")


@registry.define("second", "xs::Any", "Any", "The second item of a sequence.", ("(second '(a b c))", "b"))
def second(rt: Runtime, xs: Any) -> Any:
    return _nth(rt, xs, 1, "second")


@registry.define("third", "xs::Any", "Any", "The third item of a sequence.", ("(third [5 6 7])", "7"))
def third(rt: Runtime, xs: Any) -> Any:
    return _nth(rt, xs, 2, "third")


@registry.define("last", "xs::Sequence", "Any", "The last item of a sequence.", ("(last '(a b c))", "c"))
def last(rt: Runtime, xs: Any) -> Any:
    members = items(rt, xs, "last")
    if not members:
        raise empty_sequence("last")
    return members[-1]


@registry.define("rest", "xs::Any", "Sequence", "A sequence without its first item.", ("(rest '(a b c))", "(b c)"))
def rest(rt: Runtime, xs: Any) -> Any:
    if isinstance(xs, (Pair, HandleList)):
        return cdr_of(rt, xs, "rest")
    members = items(rt, xs, "rest")
    if not members:
        raise empty_sequence("rest")
    return rebuild(rt, xs, members[1:])


def _check_count(count: int, members: list[Any], xs: Any) -> None:
    if not 0 <= count <= len(members):
        raise bad_index(count, len(members), kind_of(xs))


@registry.define("take", "xs::Any count::Integer", "Sequence", "The first `count` items; there must be so many.",
                 ("(take '(a b c) 2)", "(a b)"))  # fmt: skip
def take(rt: Runtime, xs: Any, count: int) -> Any:
    if isinstance(xs, (Pair, HandleList)):
        return make_list(take_front(rt, xs, count, "take"))
    members = items(rt, xs, "take")
    _check_count(count, members, xs)
    return rebuild(rt, xs, members[:count])


@registry.define("drop", "xs::Any count::Integer", "Sequence", "All but the first `count` items.",
                 ("(drop [1 2 3] 1)", "[2 3]"))  # fmt: skip
def drop(rt: Runtime, xs: Any, count: int) -> Any:
    if isinstance(xs, (Pair, HandleList)):
        return drop_front(rt, xs, count, "drop")
    members = items(rt, xs, "drop")
    _check_count(count, members, xs)
    return rebuild(rt, xs, members[count:])


# --- order and shape -------------------------------------------------------------------------------------------


@registry.define("reverse", "xs::Sequence", "Sequence", "The items in reverse order; a string stays a string.",
                 ("(list (reverse '(1 2 3)) (reverse \"abc\"))", '((3 2 1) "cba")'))  # fmt: skip
def reverse(rt: Runtime, xs: Any) -> Any:
    return rebuild(rt, xs, items(rt, xs, "reverse")[::-1])


@registry.define("zip", "sequences::Sequence ...", "List",
                 "The list of the lists of all first items, all second items and so on, as far as the shortest goes.",
                 ("(zip '(a b c) [1 2])", "((a 1) (b 2))"))  # fmt: skip
def zip_(rt: Runtime, *sequences: Any) -> Any:
    columns = [items(rt, xs, "zip") for xs in sequences]
    rows = list(zip(*columns))
    return make_list([make_list(row) for block in blocks(rt, rows) for row in block])


@registry.define("enumerate", "xs::Sequence [start::Integer]", "List",
                 "The list of the lists (index item), counted from `start` (0).",
                 ("(enumerate '(a b))", "((0 a) (1 b))"))  # fmt: skip
def enumerate_(rt: Runtime, xs: Any, start: int = 0) -> Any:
    members = items(rt, xs, "enumerate")
    if not -_INT64 < start < _INT64:
        rt.meter.reserve(len(members) * start.bit_length() >> 3)
        rt.charge(len(members) * start.bit_length() >> 13)
    pairs = enumerate(members, start)
    return make_list([make_list(pair) for block in blocks(rt, members) for pair in islice(pairs, len(block))])


@registry.define("repeat", "xs::Sequence count::Integer", "Sequence",
                 "The items of a sequence `count` times in a row. `make-list` repeats one value.",
                 ("(list (repeat '(1 2) 2) (repeat \"ab\" 3))", '((1 2 1 2) "ababab")'))  # fmt: skip
def repeat(rt: Runtime, xs: Any, count: int) -> Any:
    count = max(0, count)
    what = "a string" if type(xs) is str else "a list"
    rt.meter.check_size(length(rt, xs, "repeat") * count, what)
    if type(xs) is str:
        return xs * count
    return rebuild(rt, xs, items(rt, xs, "repeat") * count)


@registry.define("flatten", "xs::Sequence", "Sequence",
                 "The items of a list and of all lists inside it, at any depth, in one list; of an array its numbers "
                 "in one vector.",
                 ("(list (flatten '(1 (2 (3)) ())) (flatten [[1 2] [3 4]]))", "((1 2 3) [1 2 3 4])"))  # fmt: skip
def flatten(rt: Runtime, xs: Any) -> Any:
    if isinstance(xs, ARRAYS):
        data = to_numpy(rt, xs)
        rt.charge(data.size >> 5)
        return from_numpy(data.ravel())
    out: list[Any] = []
    stack: list[Any] = items(rt, xs, "flatten")[::-1]
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
    count = 0
    while type(value) is Pair:
        value = value.cdr
        count += 1
    rt.charge(count >> 4)
    return value is NIL


# --- search ----------------------------------------------------------------------------------------------------


def contains(rt: Runtime, xs: Any, x: Any) -> bool:
    """Whether ``x`` is a member, a key, or a part of a string."""
    kind = type(xs)
    if kind is Set or kind is Table:
        rt.read(xs)
        return table_key(x, rt.charge) in xs.entries
    if kind is str:
        rt.charge(len(xs) >> 5)
        return type(x) is str and x in xs
    return position_of(rt, xs, x, "contains?") is not None


def position_of(rt: Runtime, xs: Any, x: Any, name: str) -> int | None:
    """The first index at which ``x`` stands in a sequence."""
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
                 "True when `x` is an item of a sequence, a key of a table, or a part of a string. Numbers compare by "
                 "value.",
                 ("(list (contains? '(1 2) 2.) (contains? \"chair leg\" \"leg\"))", "(#t #t)"))  # fmt: skip
def contains_(rt: Runtime, xs: Any, x: Any) -> bool:
    return contains(rt, xs, x)


@registry.define("index-of", "xs::Sequence x::Any", "Any", "The first index of an item equal to `x`, or #f.",
                 ("(list (index-of '(a b) 'b) (index-of [1 2] 5))", "(1 #f)"))  # fmt: skip
def index_of(rt: Runtime, xs: Any, x: Any) -> Any:
    index = position_of(rt, xs, x, "index-of")
    return False if index is None else index


@registry.define("count", "xs::Any x::Any", "Integer",
                 "How many items equal `x`. With a function first, `(count f xs)`: how many items it accepts.",
                 ("(list (count '(1 2 1) 1) (count odd? '(1 2 3)))", "(2 2)"))  # fmt: skip
def count(rt: Runtime, xs: Any, x: Any) -> int:
    total = 0
    if isinstance(xs, Procedure):
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
                 "The items without those that equal an earlier one; numbers compare by value.",
                 ("(delete-duplicates '(1 2 1. 3 2))", "(1 2 3)"))  # fmt: skip
def delete_duplicates(rt: Runtime, xs: Any) -> Any:
    seen: dict[Any, Any] = {}
    for item in items(rt, xs, "delete-duplicates"):
        rt.charge(1)
        seen.setdefault(table_key(item, rt.charge), item)
    return make_list(list(seen.values()))


@registry.define("delete", "xs::Sequence x::Any", "List", "The items that do not equal `x`; numbers compare by value.",
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
                 "The items of any sequence as a list: characters of a string, keys of a table, rows of an array.",
                 ("(->list [1 2])", "(1 2)"))  # fmt: skip
def to_list(rt: Runtime, xs: Any) -> Any:
    if type(xs) is Pair or xs is NIL:
        length(rt, xs, "->list")
        return xs
    return make_list(items(rt, xs, "->list"))


@registry.define("string->list", "text::String", "List", "The characters of a text, Strings of length 1.",
                 ('(string->list "abc")', '("a" "b" "c")'))  # fmt: skip
def string_to_list(rt: Runtime, text: str) -> Any:
    return make_list(items(rt, text))


@registry.define("vector->list", "vector::Array", "List", "The items of an array as a list.",
                 ("(vector->list [1 2])", "(1 2)"))  # fmt: skip
def vector_to_list(rt: Runtime, vector: Any) -> Any:
    return make_list(items(rt, vector))


@registry.define("mutable", "xs::Sequence", "Any",
                 "A new mutable twin with the same items: a mutable array for an array, a new table or set for a table "
                 "or set, else a mutable list.",
                 ("(let ((xs (mutable '(1 2)))) (push! xs 3) xs)", "(mutable-list 1 2 3)"))  # fmt: skip
def mutable(rt: Runtime, xs: Any) -> Any:
    if isinstance(xs, (Vector, Matrix, Array, MutableArray)):
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
                 "A list of the arguments that can grow and change, by `push! set-ref! remove!` and others.",
                 ("(mutable-list 1 2)", "(mutable-list 1 2)"))  # fmt: skip
def mutable_list(rt: Runtime, *members: Any) -> Any:
    return rt.mutable_list(list(members))


@registry.define("mutable-array", "data::Any", "MutableArray",
                 "An array that can change in place, by `set-ref!`, from an array or nested lists of numbers.",
                 ("(let ((a (mutable-array [1 2 3]))) (set-ref! a 0 9) a)", "(mutable-array [9 2 3])"))  # fmt: skip
def mutable_array(rt: Runtime, data: Any) -> Any:
    copy = to_numpy(rt, data, "mutable-array").copy()
    if copy.ndim == 0:
        raise SceneError("type", f"`mutable-array` wants an array or a list of numbers, got {type_name(data)}")
    return MutableArray(copy, rt.clock)
