"""Type predicates and equality."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from scenelang.interpreter.runtime.types import Registry
from scenelang.interpreter.scene import pose
from scenelang.interpreter.scene.entity import Entity
from scenelang.interpreter.values import values
from scenelang.interpreter.values.values import (
    NIL,
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
    Stream,
    Symbol,
    Table,
    Vector,
)
from scenelang.stdlib.operands import identical, is_array, record_read

if TYPE_CHECKING:
    from scenelang.interpreter.runtime.runtime import Runtime

registry = Registry("predicates")


def _define_test(
    name: str, holds: Callable[[Any], bool], doc: str, example: tuple[str, str], intrinsic: str | None = None
) -> None:
    """Register a predicate of one value."""

    @registry.define(name, "value::Any", "Boolean", doc, example, intrinsic)
    def entry(rt: Runtime, value: Any) -> bool:
        return holds(value)


def _is_whole(value: Any) -> bool:
    """Return whether a value is an Integer, or a Float without a fraction."""
    return type(value) is int or (type(value) is float and value.is_integer())


_define_test(
    "not", lambda v: v is False or v is None, "Return whether a value is #f or none.", ("(not 0)", "#f"), "not"
)
_define_test("boolean?", lambda v: type(v) is bool, "Return whether a value is #t or #f.", ("(boolean? #f)", "#t"))
_define_test("none?", lambda v: v is None, "Return whether a value is none.", ("(none? '())", "#f"))
_define_test(
    "number?",
    lambda v: type(v) in (int, float),
    "Return whether a value is an Integer or a Float.",
    ("(number? 1.5)", "#t"),
)
_define_test("integer?", _is_whole, "Return whether a value is an Integer or a whole Float.", ("(integer? 2.)", "#t"))
_define_test(
    "exact?",
    lambda v: type(v) is int,
    "Return whether a value is an Integer: true for 2, false for 2.0.",
    ("(exact? 2.)", "#f"),
)
_define_test(
    "inexact?", lambda v: type(v) is float, "Return whether a value is a Float, such as 2.0.", ("(inexact? 2.)", "#t")
)
_define_test("string?", lambda v: type(v) is str, "Return whether a value is a String.", ('(string? "a")', "#t"))
_define_test("symbol?", lambda v: type(v) is Symbol, "Return whether a value is a symbol.", ("(symbol? 'a)", "#t"))
_define_test(
    "keyword?", lambda v: type(v) is Keyword, "Return whether a value is a keyword.", ("(keyword? :size)", "#t")
)
_define_test(
    "table?", lambda v: type(v) is Table, "Return whether a value is a table.", ('(table? (table "a" 1))', "#t")
)
_define_test("set?", lambda v: type(v) is Set, "Return whether a value is a set.", ("(set? (set 1 2))", "#t"))
_define_test(
    "record?", lambda v: type(v) is Record, "Return whether a value is a record of any type.", ("(record? 1)", "#f")
)
_define_test(
    "procedure?",
    lambda v: isinstance(v, Procedure),
    "Return whether a value can be called.",
    ("(procedure? car)", "#t"),
)
_define_test(
    "entity?", lambda v: type(v) is Entity, "Return whether a value is an Entity.", ('(entity? (call "cube"))', "#t")
)
_define_test(
    "embedding?",
    lambda v: type(v) is Embedding,
    "Return whether a value is an Embedding.",
    ('(embedding? (embedding "ivory"))', "#t"),
)
_define_test(
    "stream?",
    lambda v: type(v) is Stream,
    "Return whether a value is a random stream.",
    ("(stream? (random-stream 1))", "#t"),
)
_define_test(
    "mutable?",
    lambda v: isinstance(v, Mutable) and v.birth >= 0,
    "Return whether a value can be modified: mutable lists and arrays, tables, sets, records and streams.",
    ("(mutable? (mutable-list 1 2))", "#t"),
)
_define_test(
    "array?",
    is_array,
    "Return whether a value is an array, of any number of dimensions.",
    ("(array? [[1 2] [3 4]])", "#t"),
)
_define_test(
    "vector?",
    lambda v: type(v) is Vector or (type(v) is MutableArray and v.data.ndim == 1),
    "Return whether a value is a one-dimensional array.",
    ("(vector? [1 2 3])", "#t"),
)


@registry.define(
    "matrix?",
    "value::Any",
    "Boolean",
    "Return whether a value is a pose: a 4x4 array whose last row is 0 0 0 1.",
    ("(list (matrix? (eye 4)) (matrix? (eye 3)))", "(#t #f)"),
)
def is_matrix(rt: Runtime, value: Any) -> bool:
    if type(value) is MutableArray and value.data.shape == (4, 4):
        rt.read(value)
        return pose.from_array(value.data) is not None
    return type(value) is Matrix


@registry.define(
    "pair?",
    "value::Any",
    "Boolean",
    "Return whether a value is a pair, as every list is that is not empty.",
    ("(list (pair? '(1)) (pair? '()))", "(#t #f)"),
    "pair?",
)
def is_pair(rt: Runtime, value: Any) -> bool:
    if type(value) is MutableList:
        rt.read(value)
        return bool(value.items)
    return type(value) is Pair or type(value) is HandleList


@registry.define(
    "null?", "value::Any", "Boolean", "Return whether a value is the empty list.", ("(null? (list))", "#t"), "null?"
)
def is_null(rt: Runtime, value: Any) -> bool:
    if type(value) is MutableList:
        rt.read(value)
        return not value.items
    return value is NIL


@registry.define(
    "list?",
    "value::Any",
    "Boolean",
    "Return whether a value is a list: pairs that end in the empty list, or a mutable list.",
    ("(list (list? '(1 2)) (list? (cons 1 2)))", "(#t #f)"),
)
def is_list(rt: Runtime, value: Any) -> bool:
    count = 0
    while type(value) is Pair:
        count += 1
        value = value.cdr
    rt.charge(count >> 3)
    return value is NIL or type(value) is MutableList


# --- equality --------------------------------------------------------------------------------------------------


@registry.define(
    "eq?",
    "a::Any b::Any",
    "Boolean",
    "Return whether both are the same object; numbers and strings are compared by value, and 1 and 1.0 differ.",
    ("(list (eq? 1 1) (eq? 1 1.) (eq? '() '()))", "(#t #f #t)"),
)
def eq(rt: Runtime, a: Any, b: Any) -> bool:
    return identical(a, b)


@registry.define(
    "boolean=?",
    "a::Boolean b::Boolean more::Boolean ...",
    "Boolean",
    "Return whether all are #t, or all are #f.",
    ("(boolean=? #t #t)", "#t"),
)
def boolean_equal(rt: Runtime, *values: bool) -> bool:
    rt.charge(len(values) >> 8)
    return all(value is values[0] for value in values)


@registry.define("eqv?", "a::Any b::Any", "Boolean", "The same as `eq?`.", ('(eqv? "a" "a")', "#t"))
def eqv(rt: Runtime, a: Any, b: Any) -> bool:
    return identical(a, b)


@registry.define(
    "equal?",
    "a::Any b::Any more::Any ...",
    "Boolean",
    "Return whether all have the same structure, content and types: 1 and 1.0 differ. `=` compares numbers by value.",
    ("(list (equal? '(1 (2)) '(1 (2))) (equal? 1 1.))", "(#t #f)"),
    intrinsic="equal?",
)
def equal(rt: Runtime, a: Any, b: Any, *more: Any) -> bool:
    record_read(rt, a, b, *more)
    return all(values.equal(rt, a, other) for other in (b, *more))
