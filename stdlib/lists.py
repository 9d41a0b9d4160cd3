"""Builtins for pairs and lists: construction, access from the front, and association lists."""

from __future__ import annotations

from collections.abc import Callable
from itertools import product
from typing import TYPE_CHECKING, Any, TypeAlias

from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.runtime.types import Builtin, Registry
from scenelang.interpreter.scene.entity import Entity
from scenelang.interpreter.values.values import (
    NIL,
    Array,
    HandleList,
    Matrix,
    MutableArray,
    MutableList,
    Nil,
    Pair,
    Symbol,
    Vector,
    make_list,
)
from scenelang.stdlib.operands import (
    bad_index,
    blocks,
    empty_sequence,
    identical,
    improper,
    infinite_error,
    items,
    length,
    same_value,
    wrong_type,
)
from scenelang.stdlib.predicates import equal

if TYPE_CHECKING:
    from scenelang.interpreter.runtime.runtime import Runtime

registry = Registry("lists")


# --- pairs -----------------------------------------------------------------------------------------------------


def car_of(rt: Runtime, value: Any, name: str = "car") -> Any:
    """Return the first item of a pair, an Entity, the list of handles or a mutable list."""
    kind = type(value)
    if kind is Pair:
        return value.car
    if kind is Entity:
        return Pair(value.word, value.embedding)
    if kind is HandleList:
        return rt.handle(f"z{value.start}")
    if kind is MutableList:
        rt.read(value)
        if value.items:
            return value.items[0]
    raise _not_a_pair(name, value)


def cdr_of(rt: Runtime, value: Any, name: str = "cdr") -> Any:
    """Return the rest after the first item of a pair, an Entity, the list of handles or a mutable list.

    Raises SceneError, which names the builtin ``name``, for other values and for an empty list.
    """
    kind = type(value)
    if kind is Pair:
        return value.cdr
    if kind is Entity:
        rt.charge(len(value.children) >> 2)
        return make_list(value.children)
    if kind is HandleList:
        return HandleList(value.start + 1)
    if kind is MutableList:
        rt.read(value)
        if value.items:
            rt.charge(len(value.items) >> 2)
            return make_list(value.items[1:])
    raise _not_a_pair(name, value)


def _not_a_pair(name: str, value: Any) -> SceneError:
    """Return the error for a value without a first item."""
    if value is NIL or type(value) is MutableList:
        return empty_sequence(name, "list")
    return wrong_type(name, "a pair or a list", value)


@registry.define("cons", "first::Any rest::Any", "Pair",
                 "Return the pair of two values; if the second is a list, the longer list.",
                 ("(list (cons 1 2) (cons 1 '(2 3)))", "((1 . 2) (1 2 3))"), "cons")  # fmt: skip
def cons(rt: Runtime, first: Any, rest: Any) -> Any:
    if type(rest) is MutableList:
        return Pair(first, make_list(items(rt, rest)))
    return Pair(first, rest)


@registry.define("car", "pair::Any", "Any",
                 "Return the first part of a pair, or the first item of a list. Of an Entity: the pair (word . "
                 "embedding).",
                 ("(car '(1 2 3))", "1"), "car")  # fmt: skip
def car(rt: Runtime, pair: Any) -> Any:
    return car_of(rt, pair)


@registry.define("cdr", "pair::Any", "Any",
                 "Return the second part of a pair, or a list without its first item. Of an Entity: the list of its "
                 "(Entity . Matrix) pairs.",
                 ("(cdr '(1 2 3))", "(2 3)"), "cdr")  # fmt: skip
def cdr(rt: Runtime, pair: Any) -> Any:
    return cdr_of(rt, pair)


def _define_chain(letters: str) -> None:
    """Register ``cadr`` and related functions; ``letters`` are applied from right to left."""
    name = f"c{letters}r"
    steps = [car_of if letter == "a" else cdr_of for letter in reversed(letters)]
    written = "".join(f"(c{letter}r " for letter in letters) + "pair" + ")" * len(letters)
    sample, printed = _chain_example(letters)

    @registry.define(name, "pair::Any", "Any", f"The same as `{written}`.", (f"({name} '{sample})", printed))
    def entry(rt: Runtime, pair: Any) -> Any:
        """Apply the steps from right to left."""
        for step in steps:
            pair = step(rt, pair, name)
        return pair


def _chain_example(letters: str) -> tuple[str, str]:
    """Return a list in which the chain reaches the symbol ``x``, and the text of this symbol."""
    text = "x"
    for letter in letters:
        text = f"({text})" if letter == "a" else f"(_ . {text})"
    return text, "x"


for _count in (2, 3, 4):
    for _letters in product("ad", repeat=_count):
        _define_chain("".join(_letters))


# --- making lists ----------------------------------------------------------------------------------------------


@registry.define(
    "list", "items::Any ...", "List", "Return the list of the arguments.", ('(list 1 "a" \'())', '(1 "a" ())')
)
def list_(rt: Runtime, *members: Any) -> Any:
    return make_list(members)


@registry.define("values", "items::Any ...", "List", "The same as `list`: multiple results are a list.",
                 ("(let-values (((q r) (floor/ 7 2))) (values r q))", "(1 3)"))  # fmt: skip
def values(rt: Runtime, *members: Any) -> Any:
    return make_list(members)


@registry.define("list*", "item::Any more::Any ...", "Any",
                 "Return the last argument, a list, with the other arguments in front of it.",
                 ("(list* 1 2 '(3 4))", "(1 2 3 4)"))  # fmt: skip
def list_star(rt: Runtime, *members: Any) -> Any:
    tail = members[-1]
    if type(tail) is MutableList:
        tail = make_list(items(rt, tail))
    return make_list(members[:-1], tail)


@registry.define("make-list", "count::Integer [fill::Any]", "List",
                 "Return a list of `count` times `fill` (default: none).",
                 ("(make-list 3 0)", "(0 0 0)"))  # fmt: skip
def make_list_(rt: Runtime, count: int, fill: Any = None) -> Any:
    if count < 0:
        raise SceneError("value", f"`make-list` expects a count that is not negative, got {count}")
    rt.meter.check_size(count, "a list")
    return make_list([fill] * count)


@registry.define("iota", "count::Integer [start::Number] [step::Number]", "List",
                 "Return `count` numbers from `start` (default 0) in steps of `step` (default 1).",
                 ("(list (iota 3) (iota 3 10 .5))", "((0 1 2) (10 10.5 11.0))"))  # fmt: skip
def iota(rt: Runtime, count: int, start: Any = 0, step: Any = 1) -> Any:
    if count < 0:
        raise SceneError("value", f"`iota` expects a count that is not negative, got {count}")
    rt.meter.check_size(count, "a list")
    if type(start) is int and type(step) is int:
        return make_list(_progression(rt, count, start, step))
    rt.charge(count >> 4)
    return make_list([start if i == 0 else start + step * i for i in range(count)])


def _progression(rt: Runtime, count: int, start: int, step: int) -> list[int]:
    """Return ``count`` integers from ``start`` in steps of ``step``; charge the memory of long integers."""
    bits = max(start.bit_length(), (step * count).bit_length())
    if bits > 64:
        rt.meter.reserve(count * (bits >> 3))
    out: list[int] = []
    for block in blocks(rt, range(count)):
        rt.charge(len(block) * bits >> 12)
        out += [start + step * i for i in block]
    return out


@registry.define("range", "start::Integer [end::Integer] [step::Integer]", "List",
                 "Return the Integers from `start` up to but excluding `end`, in steps of `step`; `(range n)` starts "
                 "at 0. For fractions there are `arange` and `linspace`.",
                 ("(list (range 4) (range 2 5) (range 5 0 -2))", "((0 1 2 3) (2 3 4) (5 3 1))"))  # fmt: skip
def range_(rt: Runtime, start: int, end: int | None = None, step: int = 1) -> Any:
    if end is None:
        start, end = 0, start
    if step == 0:
        raise SceneError("value", "`range` expects a step that is not 0")
    count = max(0, -((start - end) // step))
    rt.meter.check_size(count, "a list")
    return make_list(_progression(rt, count, start, step))


@registry.define("append", "lists::Any ...", "List",
                 "Concatenate lists; arrays count as lists of their items. A last argument that is neither, or a pose, "
                 "becomes the tail of a dotted list.",
                 ("(append '(1 2) '(3) '())", "(1 2 3)"))  # fmt: skip
def append(rt: Runtime, *lists: Any) -> Any:
    if not lists:
        return NIL
    for xs in lists:
        if type(xs) is str:
            raise wrong_type("append", "lists", xs, "to concatenate strings, write `(string-append a b)`")
    total = 0
    result = lists[-1]
    if type(result) is Pair and type(result.cdr) is Matrix:
        raise improper("append", result.cdr)
    if type(result) is Pair:
        tail = result  # it is shared, not copied, and may be dotted
        while type(tail) is Pair:
            total, tail = total + 1, tail.cdr
        rt.charge(total >> 4)
    elif type(result) in (Array, MutableArray, MutableList, Nil, Vector):
        members = items(rt, result, "append")
        total, result = len(members), make_list(members)
    for xs in reversed(lists[:-1]):
        members = items(rt, xs, "append")
        total += len(members)
        rt.meter.check_size(total, "a list")
        result = make_list(members, result)
    return result


@registry.define("list-copy", "xs::List", "List", "Return a copy of a list, also of a mutable one.",
                 ("(list-copy '(1 2))", "(1 2)"))  # fmt: skip
def list_copy(rt: Runtime, xs: Any) -> Any:
    return make_list(items(rt, xs, "list-copy"))


# --- parts of lists --------------------------------------------------------------------------------------------


def drop_front(rt: Runtime, xs: Any, count: int, name: str) -> Any:
    """Return a list without its first ``count`` items; the result shares the rest.

    The root's infinite list of handles stays infinite. Raises SceneError, which names the builtin ``name``, if the list
    is shorter or ``count`` is negative.
    """
    if type(xs) is MutableList:
        xs = make_list(items(rt, xs, name))
    if type(xs) is HandleList:
        if count < 0:
            raise infinite_error(name)
        return HandleList(xs.start + count)
    if count < 0:
        raise bad_index(count, length(rt, xs, name), "list")
    rest = xs
    for _ in range(count):
        if type(rest) is not Pair:
            raise bad_index(count, length(rt, xs, name), "list")
        rest = rest.cdr
    rt.charge(count >> 4)
    return rest


def take_front(rt: Runtime, xs: Any, count: int, name: str) -> list[Any]:
    """Return the first ``count`` items of a list, or of the root's infinite list of handles.

    Raises SceneError if the list is shorter or ``count`` is negative; ``name`` is the builtin that errors name.
    """
    if type(xs) is MutableList:
        xs = make_list(items(rt, xs, name))
    if count < 0:
        raise bad_index(count, length(rt, xs, name), "list")
    if type(xs) is HandleList:
        rt.meter.check_size(count, "a list")
        rt.charge(count)
        return [rt.handle(f"z{k}") for k in range(xs.start, xs.start + count)]
    members: list[Any] = []
    rest = xs
    for _ in range(count):
        if type(rest) is not Pair:
            raise bad_index(count, length(rt, xs, name), "list")
        members.append(rest.car)
        rest = rest.cdr
    rt.charge(count >> 2)
    return members


@registry.define("list-head", "xs::List count::Integer", "List", "Return the first `count` items of a list.",
                 ("(list-head '(a b c) 2)", "(a b)"))  # fmt: skip
def list_head(rt: Runtime, xs: Any, count: int) -> Any:
    return make_list(take_front(rt, xs, count, "list-head"))


@registry.define("list-tail", "xs::List count::Integer", "List", "Return a list without its first `count` items.",
                 ("(list-tail '(a b c) 2)", "(c)"))  # fmt: skip
def list_tail(rt: Runtime, xs: Any, count: int) -> Any:
    return drop_front(rt, xs, count, "list-tail")


@registry.define("list-ref", "xs::List index::Integer", "Any",
                 "Return the item at an index, starting at 0. `ref` works on every sequence.",
                 ("(list-ref '(a b c) 1)", "b"))  # fmt: skip
def list_ref(rt: Runtime, xs: Any, index: int) -> Any:
    rest = drop_front(rt, xs, index, "list-ref")
    if type(rest) is HandleList:
        return car_of(rt, rest)
    if type(rest) is not Pair:
        raise bad_index(index, length(rt, xs, "list-ref"), "list")
    return rest.car


# --- search ----------------------------------------------------------------------------------------------------

Same: TypeAlias = "Callable[[Runtime, Any, Any], bool]"


def _equality(same: Any) -> Same:
    """Return equality by value, or by a function of the program."""
    if same is None:
        return same_value
    if type(same) is Builtin and same.function is equal:
        return _same_typed

    def by_function(rt: Runtime, a: Any, b: Any) -> bool:
        """Return the truth value of the program's function."""
        result = rt.call2(same, a, b)
        return result is not False and result is not None

    return by_function


def _same_typed(rt: Runtime, a: Any, b: Any) -> bool:
    """Return whether two values are ``equal?``, the equality of ``case``.

    R7RS specifies ``eqv?`` for ``case``, which would never match constants that are lists.
    """
    kind = type(a)
    if kind is int or kind is str or kind is Symbol:
        return type(b) is kind and bool(a == b)
    return bool(equal(rt, a, b))


def _same_identity(rt: Runtime, a: Any, b: Any) -> bool:
    """Return whether two values are ``eq?``."""
    return identical(a, b)


def _tail_from(rt: Runtime, x: Any, xs: Any, same: Same, name: str) -> Any:
    """Return the list from the first item that is the same as ``x``, or False."""
    if type(xs) is not Pair:
        xs = make_list(items(rt, xs, name))
    length(rt, xs, name)  # an improper list is an error even if an item matches
    while type(xs) is Pair:
        rt.charge(1)
        if same(rt, x, xs.car):
            return xs
        xs = xs.cdr
    return False


@registry.define("member", "x::Any xs::Sequence [same::Function]", "Any",
                 "Return the rest of a list from the first item equal to `x`, or #f. Numbers compare by value. "
                 "`contains?` returns a Boolean.",
                 ("(list (member 2 '(1 2 3)) (member 9 '(1 2 3)))", "((2 3) #f)"), "member")  # fmt: skip
def member(rt: Runtime, x: Any, xs: Any, same: Any = None) -> Any:
    return _tail_from(rt, x, xs, _equality(same), "member")


@registry.define("memq", "x::Any xs::List", "Any", "The same as `member`, but compares by `eq?`.",
                 ("(memq 'b '(a b c))", "(b c)"))  # fmt: skip
def memq(rt: Runtime, x: Any, xs: Any) -> Any:
    return _tail_from(rt, x, xs, _same_identity, "memq")


@registry.define("memv", "x::Any xs::List", "Any", "The same as `memq`.", ("(memv 2 '(1 2 3))", "(2 3)"))
def memv(rt: Runtime, x: Any, xs: Any) -> Any:
    return _tail_from(rt, x, xs, _same_identity, "memv")


def _entry_of(rt: Runtime, key: Any, entries: Any, same: Same, name: str) -> Any:
    """Return the first pair of an association list with a key, or False."""
    for entry in items(rt, entries, name):
        rt.charge(1)
        if type(entry) is not Pair and type(entry) is not MutableList:
            raise wrong_type(name, "a list of pairs", entry, 'write pairs as in `\'(("a" . 1) ("b" . 2))`')
        if same(rt, key, car_of(rt, entry, name)):
            return entry
    return False


@registry.define("assoc", "key::Any pairs::List [same::Function]", "Any",
                 "Return the first pair in a list of pairs whose first part equals `key`, or #f.",
                 ("(assoc \"b\" '((\"a\" 1) (\"b\" 2)))", '("b" 2)'))  # fmt: skip
def assoc(rt: Runtime, key: Any, pairs: Any, same: Any = None) -> Any:
    return _entry_of(rt, key, pairs, _equality(same), "assoc")


@registry.define("assq", "key::Any pairs::List", "Any", "The same as `assoc`, but compares by `eq?`.",
                 ("(assq 'b '((a . 1) (b . 2)))", "(b . 2)"))  # fmt: skip
def assq(rt: Runtime, key: Any, pairs: Any) -> Any:
    return _entry_of(rt, key, pairs, _same_identity, "assq")


@registry.define(
    "assv", "key::Any pairs::List", "Any", "The same as `assq`.", ("(assv 2 '((1 . a) (2 . b)))", "(2 . b)")
)
def assv(rt: Runtime, key: Any, pairs: Any) -> Any:
    return _entry_of(rt, key, pairs, _same_identity, "assv")
