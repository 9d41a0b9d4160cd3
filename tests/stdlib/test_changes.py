from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from scenelang.grammar.diagnostics import LimitError, SceneError
from scenelang.interpreter.runtime.runtime import Runtime
from scenelang.interpreter.values.values import IDENTITY, NIL, Keyword, MutableArray, Record, RecordType, Table, Vector

from .conftest import BUILTINS, Caller, function, new_runtime, python, scheme

CALL = Caller(new_runtime())
INDEX = st.integers(-6, 6)
STEP = st.one_of(
    st.tuples(st.just("push!"), INDEX),
    st.tuples(st.just("pop!")),
    st.tuples(st.just("pop!"), INDEX),
    st.tuples(st.just("insert!"), INDEX, INDEX),
    st.tuples(st.just("set-ref!"), INDEX, INDEX),
    st.tuples(st.just("remove!"), INDEX),
    st.tuples(st.just("remove-at!"), INDEX),
    st.tuples(st.just("reverse!")),
    st.tuples(st.just("sort!")),
)


def step(xs: list[int], name: str, *arguments: int) -> Any:
    """What Python does."""
    if name == "insert!" and not -len(xs) <= arguments[0] <= len(xs):
        raise IndexError
    if name == "set-ref!":
        xs[arguments[0]] = arguments[1]
    elif name == "remove-at!":
        del xs[arguments[0]]
    else:
        method = {"push!": "append"}.get(name, name[:-1])
        return getattr(xs, method)(*arguments)
    return None


@given(st.lists(INDEX, max_size=4), st.lists(STEP, max_size=12))
def test_mutable_lists_are_pythons(start: list[int], steps: list[Any]) -> None:
    model, xs = list(start), CALL("mutable", start)
    for name, *arguments in steps:
        try:
            wanted = step(model, name, *arguments)
        except (IndexError, ValueError):
            assert CALL.error(name, xs, *arguments).name in ("index", "value")
        else:
            assert CALL(name, xs, *arguments) == wanted
        assert python(xs) == model


def test_immutable_things_name_their_twins(call: Caller) -> None:
    assert "(mutable-list ...)" in call.refuses("immutable", "push!", [1], 2)
    assert "(mutable-list ...)" in call.refuses("immutable", "set-ref!", [1], 0, 2)
    assert "(mutable-array ...)" in call.refuses("immutable", "set-ref!", Vector((1, 2)), 0, 2)
    assert "(mutable-array ...)" in call.refuses("immutable", "sort!", Vector((1, 2)))
    assert "(mutable-array ...)" in call.refuses("immutable", "set-ref!", IDENTITY, 0, 0, 2)
    assert "characters" in call.refuses("immutable", "set-ref!", "abc", 0, "x")
    assert "set-point-...!" in call.refuses("type", "set-ref!", Record(RecordType("point", ("x",)), [1], 1), "x", 2)
    call.refuses("immutable", "update!", [1], 0, BUILTINS["-"])
    call.refuses("type", "push!", 5, 1)
    assert "push!" in call.refuses("type", "add!", call("mutable-list"), 1)
    assert "remove-key!" in call.refuses("type", "remove!", call("table"), 1)


def test_tables_in_embeddings_cannot_change(call: Caller) -> None:
    frozen = Table({"a": ("a", 1)}, -1)
    for name, *arguments in (("set-ref!", "a", 2), ("remove-key!", "a"), ("clear!",), ("pop!", "a")):
        call.refuses("immutable", name, frozen, *arguments)
    assert frozen.entries == {"a": ("a", 1)}
    copy = call("mutable", frozen)
    call("set-ref!", copy, "a", 2)
    assert call("ref", copy, "a") == 2


def test_setting_deeper(call: Caller) -> None:
    rows = call("mutable-list", call("mutable-list", 1, 2), call("table", "k", 0))
    call("set-ref!", rows, 0, 1, 9)
    call("set-ref!", rows, 1, "k", 5)
    assert call.show("ref", rows, 0) == "(mutable-list 1 9)"
    assert call("ref", rows, 1, "k") == 5
    call.refuses("arity", "set-ref!", rows, 0)


def test_setting_arrays(call: Caller) -> None:
    array = call("mutable-array", [[1, 2, 3], [4, 5, 6]])
    call("set-ref!", array, 0, 1, 20)
    call("set-ref!", array, Keyword("all"), 0, Vector((7, 8)))
    call("set-ref!", array, 1, [1, None], 0)
    call("set-ref!", array, -1, -1, 9.0)
    assert array.data.tolist() == [[7, 20, 3], [8, 0, 9]]
    assert "Integers" in call.refuses("type", "set-ref!", array, 0, 0, 1.5)
    call.refuses("index", "set-ref!", array, 2, 0, 1)
    call.refuses("index", "set-ref!", array, 0, 0, 0, 1)
    assert "does not match" in call.refuses("value", "set-ref!", array, Keyword("all"), 0, Vector((1, 2, 3)))
    call.refuses("type", "set-ref!", array, 0, "x")
    rows = call("mutable-list", array)
    call.refuses("value", "set-ref!", rows, 0, 0, 0, 1)


def test_what_was_read_from_a_mutable_array_stays(call: Caller) -> None:
    array = call("mutable-array", [[1, 2], [3, 4]])
    row, whole, turned = call("ref", array, 0), call("array", array), call("transpose", array)
    cut, doubled = call("slice", array, [0, 1]), call("reshape", array, [4, 1])
    before = [str(x) if type(x) is Vector else x.data.tolist() for x in (row, whole, turned, cut, doubled)]
    call("set-ref!", array, 0, 0, 99)
    assert [str(x) if type(x) is Vector else x.data.tolist() for x in (row, whole, turned, cut, doubled)] == before
    source = np.array([[1, 2], [3, 4]])
    given_array = call("mutable", call("array", [[1, 2], [3, 4]]))
    call("set-ref!", given_array, 0, 0, 5)
    assert source[0, 0] == 1


def test_reordering_arrays(call: Caller) -> None:
    array = call("mutable-array", [3, 1, 2])
    call("sort!", array)
    assert array.data.tolist() == [1, 2, 3]
    call("reverse!", array)
    assert array.data.tolist() == [3, 2, 1]
    rows = call("mutable-array", [[1, 2], [3, 4]])
    call("reverse!", rows)
    assert rows.data.tolist() == [[3, 4], [1, 2]]


def test_update(call: Caller) -> None:
    xs, t = call("mutable-list", 1, 2), call("table", "a", 1)
    call("update!", xs, -1, function(lambda x: x + 10))
    call("update!", t, "a", function(lambda x: x + 10))
    call("update!", t, "b", function(lambda x: x + 10), 0)
    call("update!", t, call("table", "c", 3))
    assert python(xs) == [1, 12]
    assert call.show("mutable", t) == '(table "a" 11 "b" 10 "c" 3)'
    call.refuses("key", "update!", t, "z", BUILTINS["-"])
    assert call("ref", call("table-merge", t), "a") == 11


KEYS = st.sampled_from([1, 1.0, "1", True, False, 0, None, "", 2.5, -0.0])


@given(st.lists(st.tuples(KEYS, st.integers(0, 9)), max_size=10))
def test_tables_are_dicts(pairs: list[tuple[Any, int]]) -> None:
    tagged: dict[Any, tuple[Any, int]] = {}
    for key, value in pairs:
        tag = (type(key) is bool, key)
        tagged[tag] = (tagged[tag][0] if tag in tagged else key, value)
    table = CALL("table", *(part for pair in pairs for part in pair))
    assert [str(key) for key in CALL.python("table-keys", table)] == [str(key) for key, _ in tagged.values()]
    assert CALL.python("table-values", table) == [value for _, value in tagged.values()]
    assert CALL("length", table) == len(tagged)
    assert [CALL("has-key?", table, key) for key, _ in pairs] == [True] * len(pairs)


def test_tables(call: Caller) -> None:
    t = call("table", "a", 1, scheme([1, 2]), 2)
    assert call("ref", t, [1.0, 2]) == 2
    assert call.show("table-items", t) == '(("a" 1) ((1 2) 2))'
    assert call.show("keywords", call("table", "num_steps", 3)) == "(:num_steps 3)"
    assert call("pop!", t, "a") == 1
    assert call("pop!", t, "a", None) is None
    call.refuses("key", "pop!", t, "a")
    call.refuses("key", "remove-key!", t, "a")
    call.refuses("arity", "table", "a")
    call.refuses("type", "keywords", call("table", 1, 2))
    assert call.show("list->table", [["a", 1], call("cons", "b", 2)]) == '(table "a" 1 "b" 2)'
    call.refuses("type", "list->table", [["a", 1, 2]])


SETS = st.lists(st.integers(0, 6), max_size=6)


@given(SETS, SETS, SETS)
def test_sets(a: list[int], b: list[int], c: list[int]) -> None:
    first, second = CALL("list->set", a), CALL("set", *b)
    assert CALL.python("->list", first) == list(dict.fromkeys(a))
    assert set(CALL.python("->list", CALL("set-union", first, second, c))) == {*a, *b, *c}
    assert set(CALL.python("->list", CALL("set-intersection", first, second, c))) == set(a) & set(b) & set(c)
    assert set(CALL.python("->list", CALL("set-difference", first, second, c))) == set(a) - set(b) - set(c)
    assert CALL("subset?", first, second) == (set(a) <= set(b))
    for x in c:
        CALL("add!", first, x)
    assert set(CALL.python("->list", first)) == {*a, *c}


def test_removing_from_a_set(call: Caller) -> None:
    s = call("set", 1, 2)
    call("remove!", s, 1.0)
    assert call.show("mutable", s) == "(set 2)"
    call.refuses("key", "remove!", s, 5)
    call("clear!", s)
    assert call("empty?", s) is True


@pytest.mark.parametrize("name", ["push!", "add!", "extend!", "set-ref!", "insert!"])
def test_growth_is_bounded(name: str) -> None:
    call = Caller(new_runtime(size=100))
    thing = {"add!": call("set"), "set-ref!": call("table")}.get(name, call("mutable-list", 1))

    def grow() -> None:
        for i in range(200):
            arguments = {"set-ref!": (i, i), "insert!": (0, i), "extend!": (thing,)}.get(name, (i,))
            call(name, thing, *arguments)

    with pytest.raises(LimitError):
        grow()


# --- what shared calls rely on ---------------------------------------------------------------------------------

WRITES: list[tuple[str, Any]] = [
    ("push!", (1,)), ("pop!", ()), ("insert!", (0, 1)), ("set-ref!", (0, 1)), ("remove!", (1,)), ("remove-at!", (0,)),
    ("extend!", (NIL,)), ("clear!", ()), ("sort!", ()), ("reverse!", ()), ("shuffle!", ()), ("py-shuffle!", ()),
    ("update!", (0, BUILTINS["-"])),
]  # fmt: skip


@pytest.mark.parametrize(("name", "arguments"), WRITES)
def test_changes_are_noted(rt: Runtime, name: str, arguments: Any) -> None:
    call = Caller(rt)
    xs = call("mutable-list", 1, 2)
    rt.serial = rt.clock = xs.birth + 5
    call(name, xs, *arguments)
    assert rt.oldest_write == xs.birth


READS: list[tuple[str, Any]] = [
    ("length", lambda xs: (xs,)), ("ref", lambda xs: (xs, 0)), ("first", lambda xs: (xs,)), ("car", lambda xs: (xs,)),
    ("cdr", lambda xs: (xs,)), ("null?", lambda xs: (xs,)), ("pair?", lambda xs: (xs,)), ("slice", lambda xs: (xs, 1)),
    ("append", lambda xs: (xs, xs)), ("map", lambda xs: (BUILTINS["-"], xs)), ("sum", lambda xs: (xs,)),
    ("contains?", lambda xs: (xs, 1)), ("equal?", lambda xs: (xs, xs)), ("cons", lambda xs: (1, xs)),
    ("apply", lambda xs: (BUILTINS["+"], xs)), ("array", lambda xs: (xs,)), ("sort", lambda xs: (xs,)),
    ("list-ref", lambda xs: (xs, 0)), ("max", lambda xs: (xs,)), ("mutable", lambda xs: (xs,)),
    ("list-tail", lambda xs: (xs, 1)), ("choice", lambda xs: (xs,)), ("zeros", lambda xs: (xs,)),
]  # fmt: skip


@pytest.mark.parametrize(("name", "arguments"), READS)
def test_reads_are_noted(rt: Runtime, name: str, arguments: Any) -> None:
    call = Caller(rt)
    xs = call("mutable-list", 1, 2)
    rt.serial = rt.clock = xs.birth + 5
    call(name, *arguments(xs))
    assert xs.observed
    assert rt.oldest_read == xs.birth


@pytest.mark.parametrize(
    "name", ["table-keys", "table-values", "table-items", "table-merge", "keywords", "length", "mutable"]
)
def test_reads_of_tables_are_noted(rt: Runtime, name: str) -> None:
    call = Caller(rt)
    t = call("table", "a", 1)
    rt.serial = rt.clock = t.birth + 5
    call(name, t)
    assert t.observed


@pytest.mark.parametrize(
    ("name", "arguments"),
    [
        ("ref", (0,)),
        ("array", ()),
        ("sum", ()),
        ("@", (1,)),
        ("slice", (0,)),
        ("matrix?", ()),
        ("norm", ()),
        ("x-of", ()),
    ],
)
def test_reads_of_arrays_are_noted(rt: Runtime, name: str, arguments: Any) -> None:
    call = Caller(rt)
    data = np.eye(4) if name == "matrix?" else np.ones(3)
    array = MutableArray(data, rt.clock)
    rt.serial = rt.clock = array.birth + 5
    call(name, array, *([Vector((1, 2, 3))] if name == "@" else arguments))
    assert array.observed


def test_errors_of_the_program_pass_through(call: Caller) -> None:
    def fail(x: Any) -> Any:
        raise SceneError("user", "stop")

    call.refuses("user", "map", function(fail), [1])
