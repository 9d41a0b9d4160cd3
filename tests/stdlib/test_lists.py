from __future__ import annotations

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from scenelang.grammar.diagnostics import LimitError
from scenelang.interpreter.runtime.runtime import Runtime
from scenelang.interpreter.scene.entity import Entity
from scenelang.interpreter.values.values import (
    ANONYMOUS,
    IDENTITY,
    NIL,
    Embedding,
    HandleList,
    Pair,
    Record,
    RecordType,
    Symbol,
    Vector,
)
from scenelang.stdlib.operands import items

from .conftest import BUILTINS, Caller, function, new_runtime, python, scheme

CALL = Caller(new_runtime())
ITEMS = st.lists(st.integers(0, 9), max_size=8)
BOUND = st.one_of(st.none(), st.integers(-10, 10))


def test_pairs(call: Caller) -> None:
    assert call.show("cons", 1, 2) == "(1 . 2)"
    assert call.show("cons", 1, [2]) == "(1 2)"
    assert call("caddr", [1, 2, 3]) == 3
    assert call("cdar", Pair(Pair(1, 2), 3)) == 2
    assert "an empty one" in call.refuses("index", "car", NIL)
    call.refuses("type", "cdr", 5)
    call.refuses("index", "cadr", [1])


def test_entities_as_pairs(call: Caller) -> None:
    child = Entity("leg", ANONYMOUS, ())
    entity = Entity("chair", ANONYMOUS, (Pair(child, IDENTITY),))
    head = call("car", entity)
    assert (head.car, head.cdr) == ("chair", ANONYMOUS)
    assert call("caar", call("cdr", entity)) is child
    assert "(cdr entity)" in str(call.refuses("type", "ref", entity, 0))
    assert call("list?", entity) is False
    assert call("pair?", entity) is False
    with pytest.raises(Exception, match="expects a list or another sequence") as caught:
        items(call.rt, entity, "length")
    assert "(cdr entity)" in caught.value.hint


def test_handles_without_end(call: Caller) -> None:
    gamma = HandleList(2)
    assert call("car", gamma).handle == "z2"
    assert call("car", call("cdr", gamma)).handle == "z3"
    assert call("ref", gamma, 5).handle == "z7"
    assert call("list-ref", gamma, 5).handle == "z7"
    assert call("first", gamma).handle == "z2"
    assert call("second", gamma).handle == "z3"
    assert [z.handle for z in call.python("list-head", gamma, 3)] == ["z2", "z3", "z4"]
    assert [z.handle for z in call.python("take", gamma, 2)] == ["z2", "z3"]
    assert call("list-tail", gamma, 4).start == 6
    assert call("pair?", gamma) is True
    assert call("null?", gamma) is False
    for name in ("length", "reverse"):
        with pytest.raises(Exception, match="needs the whole list") as caught:
            BUILTINS[name].function(call.rt, gamma)
        assert caught.value.name == "endless"
    call.refuses("endless", "apply", BUILTINS["+"], gamma)
    call.refuses("endless", "append", gamma, [1])
    call.refuses("endless", "ref", gamma, -1)


def test_improper_lists(call: Caller) -> None:
    assert "proper list" in call.refuses("type", "length", Pair(1, 2))
    entity = Entity("leg", ANONYMOUS, ())
    assert "(union pair)" in call.refuses("type", "append", [1], Pair(entity, IDENTITY))


@given(ITEMS, ITEMS, ITEMS)
def test_append(a: list[int], b: list[int], c: list[int]) -> None:
    assert CALL.python("append", a, b, c) == a + b + c
    assert CALL.python("append", CALL("mutable-list", *a), Vector(b)) == a + b
    rows = [[each, 1] for each in b]
    assert CALL.python("length", CALL("append", a, CALL("array", rows or [[0, 0]]))) == len(a) + len(rows or [0])


def test_append_shares_its_last_list(call: Caller) -> None:
    tail = scheme([3, 4])
    assert call("append", [1, 2], tail).cdr.cdr is tail
    assert call("append") is NIL
    assert "string-append" in call.refuses("type", "append", "a", "b")


@given(st.integers(-20, 20), st.integers(-20, 20), st.integers(-5, 5).filter(bool))
def test_range(start: int, end: int, step: int) -> None:
    assert CALL.python("range", start, end, step) == list(range(start, end, step))
    assert CALL.python("range", end) == list(range(end))


def test_counting(call: Caller) -> None:
    assert call.python("iota", 4, 1) == [1, 2, 3, 4]
    assert call.python("iota", 3, 0, 0.5) == [0, 0.5, 1.0]
    assert call.python("range", 3.0) == [0, 1, 2]
    call.refuses("value", "range", 0, 5, 0)
    call.refuses("type", "range", 0.5)
    call.refuses("value", "iota", -1)
    for name, count in (("iota", 10**9), ("range", 10**9), ("make-list", 10**9)):
        with pytest.raises(LimitError):
            call(name, count)


@given(ITEMS, BOUND, BOUND, BOUND.filter(lambda step: step != 0))
def test_slices_are_pythons(xs: list[int], start: Any, end: Any, step: Any) -> None:
    wanted = xs[start:end:step]
    assert CALL.python("slice", xs, start, end, step) == wanted
    assert CALL.python("slice", CALL("mutable-list", *xs), start, end, step) == wanted
    assert CALL("slice", Vector(xs), start, end, step) == tuple(wanted)
    text = "".join(map(str, xs))
    assert CALL("slice", text, start, end, step) == text[start:end:step]


@given(ITEMS, st.integers(-10, 10))
def test_indices_are_pythons(xs: list[int], index: int) -> None:
    for sequence in (scheme(xs), CALL("mutable-list", *xs), Vector(xs), "".join(map(str, xs))):
        if -len(xs) <= index < len(xs):
            assert str(CALL("ref", sequence, index)) == str(xs[index])
        else:
            assert f"of length {len(xs)}" in CALL.refuses("index", "ref", sequence, index)


def test_far_indices_are_index_errors(call: Caller) -> None:
    for name in ("ref", "list-ref", "list-tail", "list-head", "take", "drop"):
        call.refuses("index", name, [1, 2], 10**18)
        call.refuses("index", name, [1, 2], -3)


def test_ref_of_other_things(call: Caller) -> None:
    assert call("ref", [[1, 2], [3, 4]], 1, 0) == 3
    assert call("ref", call("table", "a", 1), "a") == 1
    assert call("ref", call("table", "a", 1), "b", 7) == 7
    assert "did you mean `height`" in call.refuses("key", "ref", call("table", "height", 1), "heigth")
    z = Embedding(attributes={"scale": 2})
    assert call("ref", z, call("string->symbol", "scale")) == 2
    assert call("ref", z, "color", "red") == "red"
    call.refuses("key", "ref", z, "color")
    point = Record(RecordType("point", ("x", "y")), [1, 2], 1)
    assert call("ref", point, "y") == 2
    assert "its keys are :x, :y" in call.refuses("key", "ref", point, "depth")
    call.refuses("type", "ref", [1], "a")
    call.refuses("type", "ref", 5, 0)
    call.refuses("arity", "ref", call("table"), 1, 2, 3)


def test_ends(call: Caller) -> None:
    for xs in ([1, 2, 3], Vector((1, 2, 3))):
        assert [call(name, xs) for name in ("first", "second", "third", "last")] == [1, 2, 3, 3]
        assert call.python("rest", xs) == [2, 3]
    assert call("rest", "abc") == "bc"
    call.refuses("index", "first", NIL)
    call.refuses("index", "third", Vector((1, 2)))
    call.refuses("index", "last", "")


@given(st.lists(ITEMS, max_size=4), st.integers(0, 4))
def test_flatten_and_repeat(xss: list[list[int]], times: int) -> None:
    assert CALL.python("flatten", [xss, 7]) == [x for xs in xss for x in xs] + [7]
    assert CALL.python("repeat", xss, times) == xss * times


def test_flatten_keeps_pairs_and_ends(call: Caller) -> None:
    assert call.show("flatten", [Pair(1, 2), [3]]) == "((1 . 2) 3)"
    endless = call("mutable-list")
    call("push!", endless, endless)
    runtime = new_runtime(steps=10_000)
    with pytest.raises(LimitError):
        Caller(runtime)("flatten", endless)


@given(
    st.lists(st.sampled_from([0, 1, 1.0, 2.5, "a", True]), max_size=8),
    st.sampled_from([0, 1, 1.0, 2.5, "a", True, None]),
)
def test_search_by_value(xs: list[Any], x: Any) -> None:
    def equal(a: Any, b: Any) -> bool:
        return (type(a) is bool) == (type(b) is bool) and a == b

    places = [i for i, item in enumerate(xs) if equal(item, x)]
    assert CALL("contains?", xs, x) == bool(places)
    assert CALL("contains?", CALL("set", *xs), x) == bool(places)
    assert CALL("count", xs, x) == len(places)
    assert CALL("index-of", xs, x) == (places[0] if places else False)
    assert python(CALL("member", x, xs)) == (xs[places[0] :] if places else False)
    assert CALL.python("delete", xs, x) == [item for item in xs if not equal(item, x)]


def test_search_in_structures(call: Caller) -> None:
    assert call("contains?", [[1, 2], [3]], [1.0, 2]) is True
    assert call("contains?", call("set", scheme([1, 2])), [1.0, 2.0]) is True
    assert call("contains?", "chair leg", "r l") is True
    assert call("contains?", call("table", "a", 1), "a") is True
    assert call.show("assoc", "b", [["a", 1], ["b", 2]]) == '("b" 2)'
    assert call.show("assoc", 2.0, [Pair(1, "x"), Pair(2, "y")]) == '(2 . "y")'
    assert call("assoc", 3, [Pair(1, 2)]) is False
    assert call.show("assq", Symbol("b"), [Pair(Symbol("b"), 1)]) == "(b . 1)"
    assert call.python("delete-duplicates", [1, 1.0, "a", [1], [1.0], "a"]) == [1, "a", [1]]
    call.refuses("type", "assoc", 1, [1])


def test_higher_order(call: Caller) -> None:
    double = function(lambda x: 2 * x)
    assert call.python("map", double, [1, 2]) == [2, 4]
    assert call.python("map", double, Vector((1.5,))) == [3.0]
    assert call.python("map", BUILTINS["+"], [1, 2, 3], Vector((10, 20)), [100, 200, 300]) == [111, 222]
    assert call.python("filter", BUILTINS["odd?"], range_list(6)) == [1, 3, 5]
    assert call.python("partition", BUILTINS["odd?"], range_list(4)) == [[1, 3], [0, 2]]
    assert call("fold", BUILTINS["cons"], NIL, [1, 2]).car == 2
    assert call("fold-left", BUILTINS["-"], 10, [1, 2]) == 7
    assert call("fold-right", BUILTINS["-"], 10, [1, 2]) == 1 - (2 - 10)
    assert call("fold", BUILTINS["+"], 0, [1, 2], [10, 20]) == 33
    assert call("reduce", BUILTINS["-"], 0, [1, 2, 3, 4]) == 2
    assert call("reduce", BUILTINS["max"], [3, 9, 4]) == 9
    assert call("reduce", BUILTINS["max"], -1, NIL) == -1
    call.refuses("value", "reduce", BUILTINS["max"], NIL)
    assert call("any", BUILTINS["member"], [1, 9], [[3], [9, 8]]) is not False
    assert call("any", BUILTINS["odd?"], NIL) is False
    assert call("every", BUILTINS["odd?"], NIL) is True
    assert call("every", double, [1, 2]) == 4
    assert call("apply", BUILTINS["+"], 1, [2, 3]) == 6
    assert call.python("append-map", function(lambda x: scheme([x, x])), [1, 2]) == [1, 1, 2, 2]
    assert call("list-index", BUILTINS["even?"], [1, 3, 4]) == 2
    assert call("find", BUILTINS["even?"], [1, 3]) is False
    call.refuses("type", "map", 5, [1])
    call.refuses("type", "map", double, 5)


def range_list(n: int) -> Any:
    return scheme(list(range(n)))


def test_zero_and_empty_are_true(call: Caller) -> None:
    assert call.python("filter", function(lambda x: 0), [1, 2]) == [1, 2]
    assert call.python("filter", function(lambda x: None), [1, 2]) == []


@pytest.mark.parametrize("name", ["map", "for-each", "filter", "fold"])
def test_changing_a_table_while_going_through_it(call: Caller, name: str) -> None:
    table = call("table", "a", 1, "b", 2)
    change = function(lambda *_: call("set-ref!", table, "c", 3))
    arguments = (change, 0, table) if name == "fold" else (change, table)
    assert "while it was being iterated" in call.refuses("changed", name, *arguments)


def test_a_mutable_list_may_change_meanwhile(call: Caller) -> None:
    xs = call("mutable-list", 1, 2)
    call("for-each", function(lambda x: call("push!", xs, x)), xs)
    assert python(xs) == [1, 2, 1, 2]


KEYED = st.lists(st.tuples(st.integers(0, 3), st.integers(0, 99)), max_size=12)


@given(KEYED, st.booleans())
def test_sort_is_pythons(pairs: list[tuple[int, int]], reverse: bool) -> None:
    key, less = BUILTINS["first"], function(lambda a, b: a.car < b.car)
    wanted = [list(pair) for pair in sorted(pairs, key=lambda pair: pair[0], reverse=reverse)]
    option = (keyword("reverse"), reverse)
    assert CALL.python("sort", pairs, keyword("key"), key, *option) == wanted
    assert CALL.python("sort", pairs, less, *option) == wanted
    assert CALL.python("sort", pairs) == [list(pair) for pair in sorted(pairs)]
    copy = CALL("mutable", pairs)
    CALL("sort!", copy, keyword("key"), key, *option)
    assert python(copy) == wanted


def keyword(name: str) -> Any:
    from scenelang.interpreter.values.values import Keyword

    return Keyword(name)


def test_order(call: Caller) -> None:
    assert call("sort", Vector((3, 1.5, 2))) == (1.5, 2, 3)
    assert call.python("sort", "cab") == ["a", "b", "c"]
    assert call.python("sort", [["b", 1], ["a", 2], ["a", 1.5]]) == [["a", 1.5], ["a", 2], ["b", 1]]
    assert call("max-of", ["oak", "birch"], keyword("key"), BUILTINS["length"]) == "birch"
    assert call("min-of", [2, 1, 1.0]) == 1
    assert "a String" in call.refuses("type", "sort", [1, "a"])
    call.refuses("type", "sort", [None])
    call.refuses("index", "min-of", NIL)
    deep: Any = NIL
    for _ in range(10_000):
        deep = Pair(deep, NIL)
    call.refuses("value", "sort", [deep, deep])


def test_conversions(call: Caller) -> None:
    assert call.python("->list", "ab") == ["a", "b"]
    assert call.python("->list", call("table", "k", 1)) == ["k"]
    xs = scheme([1])
    assert call("->list", xs) is xs
    assert call.show("mutable", "ab") == '(mutable-list "a" "b")'
    assert call.show("mutable", Vector((1, 2))) == "(mutable-array [1 2])"
    table = call("table", 1, 2)
    assert call("mutable", table) is not table
    assert call.python("zip", [1, 2, 3], "ab") == [[1, "a"], [2, "b"]]
    assert call.python("enumerate", "ab", 1) == [[1, "a"], [2, "b"]]
    assert call("reverse", "abc") == "cba"
    assert call("reverse", Vector((1, 2))) == (2, 1)


def test_order_of_a_set_of_strings_is_a_warning(rt: Runtime) -> None:
    call = Caller(rt)
    numbers, texts = call("set", 2, 1), call("set", "b", "a")
    call("map", BUILTINS["list"], numbers)
    call("contains?", texts, "a")
    call("length", texts)
    assert not rt.warnings
    call("map", BUILTINS["list"], texts)
    assert [warning.name for warning in rt.warnings.values()] == ["set-order"]
