"""The dynamic operators do what CPython does, on random values; they come with an import only."""

from __future__ import annotations

import operator
import re
from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from searching import many
from support import failure, session, value

from scenelang.grammar.datum import Source
from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.runtime.procedures import call_builtin
from scenelang.interpreter.runtime.runtime import Runtime
from scenelang.interpreter.runtime.show import show
from scenelang.interpreter.values.values import NIL, MutableList, Pair, Set, Table, Vector, make_list
from scenelang.stdlib.library import build_library

from .conftest import BUILTINS, Caller, function, new_runtime

IMPORT = '(import "std/python.scene")\n'

# --- random values: Python's, and the same in the language -------------------------------------------------------------

numbers = st.one_of(
    st.booleans(), st.integers(-9, 9), st.integers(), st.floats(), st.sampled_from([0.0, 1.0, 2.0, -0.0])
)
texts = st.text("ab'\"\\ \nä", max_size=4)
scalars = st.one_of(numbers, texts, st.none())
flat_keys = st.one_of(st.booleans(), st.integers(-3, 3), st.sampled_from([0.0, 1.0, 2.5]), texts, st.none())
keys = st.one_of(flat_keys, st.tuples(st.integers(-3, 3), texts), st.tuples(st.integers(0, 2), st.integers(0, 2)))
values = st.recursive(
    st.one_of(scalars, st.sets(keys, max_size=3)),
    lambda inner: st.one_of(st.lists(inner, max_size=3), st.dictionaries(keys, inner, max_size=3)),
    max_leaves=8,
)
choices = st.randoms(use_true_random=False)


def scene(python: Any, choice: Any, rt: Runtime) -> Any:
    """A Python value in the language; a list becomes a list, a mutable list, or a vector where that can be."""
    make = lambda item: scene(item, choice, rt)
    if isinstance(python, (list, tuple)):
        members = [make(item) for item in python]
        if isinstance(python, list) and choice.random() < 0.4:
            return MutableList(members, 1)
        if (
            members
            and {type(m) for m in members} == {int}
            and abs(max(members, key=abs)) < 2**62
            and choice.random() < 0.3
        ):
            return Vector(members)
        return make_list(members)
    if isinstance(python, dict):
        return call_builtin(rt, BUILTINS["table"], [x for k, v in python.items() for x in (make(k), make(v))])
    if isinstance(python, set):
        return call_builtin(rt, BUILTINS["set"], [make(item) for item in python])
    return python


def plain(result: Any) -> Any:
    """A value of the language as Python data."""
    if type(result) is Pair or result is NIL:
        out = []
        while type(result) is Pair:
            out.append(plain(result.car))
            result = result.cdr
        return out
    if isinstance(result, (MutableList, Vector)):
        return [plain(item) for item in (result.items if type(result) is MutableList else result)]
    if type(result) is Table:
        return {frozen(plain(key)): plain(entry) for key, entry in result.entries.values()}
    if type(result) is Set:
        return {frozen(plain(member)) for member in result.entries.values()}
    return result


def frozen(python: Any) -> Any:
    """Lists as tuples, so that Python can look them up."""
    return tuple(frozen(item) for item in python) if isinstance(python, list) else python


def same(a: Any, b: Any) -> bool:
    """Equal with equal types and signs; sets in any order."""
    if isinstance(a, (list, tuple)):
        return type(a) is type(b) and len(a) == len(b) and all(map(same, a, b))
    if isinstance(a, dict):
        return isinstance(b, dict) and same(list(a), list(b)) and same(list(a.values()), list(b.values()))
    return a == b if isinstance(a, set) else repr(a) == repr(b)


def holds_container(python: Any, kinds: Any) -> bool:
    inner = python.values() if isinstance(python, dict) else python if isinstance(python, (list, tuple)) else ()
    return isinstance(python, kinds) or any(holds_container(item, kinds) for item in inner)


def agrees(name: str, python: Callable[..., Any], choice: Any, *arguments: Any) -> None:
    """The operator and Python give the same, or both an error."""
    rt = new_runtime()
    converted = [scene(argument, choice, rt) for argument in arguments]
    try:
        expected = python(*arguments)
    except (TypeError, ZeroDivisionError, OverflowError, ValueError):
        with pytest.raises(SceneError):
            call_builtin(rt, BUILTINS[name], converted)
        return
    got = plain(call_builtin(rt, BUILTINS[name], converted))
    assert same(got, expected), (name, arguments, [show(c) for c in converted], got, expected)


CASES = settings(max_examples=many(300), deadline=None)


@CASES
@given(values, choices)
def test_truth_is_pythons(x: Any, choice: Any) -> None:
    assume(not (isinstance(x, list) and len(x) == 1))  # an array of one is as true as its number
    agrees("py-truthy?", bool, choice, x)


@CASES
@given(values, st.data(), choices)
def test_equality_is_pythons(x: Any, data: Any, choice: Any) -> None:
    agrees("py-==", operator.eq, choice, x, data.draw(st.one_of(values, st.just(x))))


@CASES
@given(values, values, choices)
def test_equal_values_in_other_clothes(x: Any, y: Any, choice: Any) -> None:
    """What differs only in 1, 1.0 and #t, or in the kind of list, is equal."""
    agrees("py-==", operator.eq, choice, _reclothed(x), x)
    agrees("py-==", operator.eq, choice, [x, y], [_reclothed(x), y])


def _reclothed(x: Any) -> Any:
    if isinstance(x, list):
        return [_reclothed(item) for item in x]
    if isinstance(x, dict):
        return {_reclothed(key): _reclothed(entry) for key, entry in x.items()}
    if isinstance(x, bool):
        return int(x)
    if x in (0, 1) and isinstance(x, (int, float)):
        return bool(x)
    return float(x) if isinstance(x, int) and abs(x) < 2**50 else x


@CASES
@given(values, values, choices)
def test_order_is_pythons(x: Any, y: Any, choice: Any) -> None:
    agrees("py-<", operator.lt, choice, x, y)


@CASES
@given(st.lists(st.lists(st.one_of(numbers, texts), max_size=2), max_size=3), st.data(), choices)
def test_order_of_lists_is_pythons(x: Any, data: Any, choice: Any) -> None:
    y = [
        *x[: data.draw(st.integers(0, 3))],
        *data.draw(st.lists(st.lists(st.one_of(numbers, texts), max_size=2), max_size=2)),
    ]
    agrees("py-<", operator.lt, choice, x, y)
    agrees("py-<", operator.lt, choice, y, x)


class _Lists:
    """A choice that never makes vectors: beside an array, a list counts as one."""

    @staticmethod
    def random() -> float:
        return 0.35


@CASES
@given(values, values)
def test_sums_are_pythons(x: Any, y: Any) -> None:
    agrees("py-+", operator.add, _Lists, x, y)


@CASES
@given(st.one_of(values, st.integers(-3, 9)), st.one_of(values, st.integers(-3, 9)))
def test_products_are_pythons(x: Any, y: Any) -> None:
    counts = [n for n in (x, y) if isinstance(n, int)]
    assume(all(abs(n) < 1000 for n in counts) or all(isinstance(n, (int, float)) for n in (x, y)))
    agrees("py-*", operator.mul, _Lists, x, y)


@CASES
@given(numbers, numbers)
def test_remainders_are_pythons(x: Any, y: Any) -> None:
    agrees("py-%", operator.mod, _Lists, x, y)


@CASES
@given(values, st.one_of(st.lists(values, max_size=4), st.dictionaries(keys, numbers), st.sets(keys), texts), choices)
def test_membership_is_pythons(x: Any, xs: Any, choice: Any) -> None:
    if isinstance(xs, (dict, set)):
        assume(not holds_container(x, (dict, set)))
        assume(not (isinstance(x, list) and any(isinstance(item, list) for item in x)))
        x = frozen(x)  # an immutable list stands for a tuple; Python looks up no list
    agrees("py-in", lambda a, b: a in b, choice, x, xs)


@pytest.mark.parametrize("xs", [{(0, 0)}, {(0, 0): 1}, set()], ids=str)
def test_a_mutable_list_is_no_key(xs: Any) -> None:
    rt = new_runtime()
    collection = scene(xs, _Lists, rt)
    for key in (MutableList([0, 0], 1), make_list((1, MutableList([0], 1)))):
        with pytest.raises(SceneError, match="that Python can hash"):
            call_builtin(rt, BUILTINS["py-in"], [key, collection])
    assert call_builtin(rt, BUILTINS["py-in"], [make_list((False, False)), collection]) == bool(xs)


@CASES
@given(values)
def test_text_is_pythons(x: Any) -> None:
    rt = new_runtime()
    got = call_builtin(rt, BUILTINS["py-str"], [scene(x, _Lists, rt)])
    assert got == str(_listed(x))


def _listed(x: Any) -> Any:
    """Tuples print as lists: with brackets, also as keys."""
    if isinstance(x, (list, tuple)):
        return [_listed(item) for item in x]
    if isinstance(x, dict):
        return _Shown("{" + ", ".join(f"{_listed(k)!r}: {_listed(v)!r}" for k, v in x.items()) + "}")
    if isinstance(x, set):
        return _Shown("{" + ", ".join(repr(_listed(item)) for item in x) + "}" if x else "set()")
    return x


class _Shown(str):
    def __repr__(self) -> str:
        return str(self)


fields = st.sampled_from(
    [
        "%d",
        "%5d",
        "%-6.2f",
        "%+.3e",
        "%s",
        "%10s",
        "%r",
        "%x",
        "%c",
        "%%",
        "%05d",
        "%g",
        "%.*f",
        "%*d",
        "x",
        "%y",
        "%",
        "%.1s",
        "%i %s",
        "%a",
    ]
)


@CASES
@given(st.lists(fields, max_size=3).map("".join), st.lists(scalars, max_size=4))
def test_templates_are_pythons(template: str, items: list[Any]) -> None:
    assume(all(not isinstance(item, int) or abs(item) < 1000 for item in items))
    plain = template.replace("%%", "")
    counted = re.search(r"%[^a-zA-Z%*]*\*", plain)  # a field that takes its width from the list
    assume(plain.count("%") != 1 or len(items) == 1 or counted)  # else a list of another length is the value itself
    rt = new_runtime()
    try:
        expected = template % tuple(items)
    except (TypeError, ValueError, OverflowError):
        with pytest.raises(SceneError):
            call_builtin(rt, BUILTINS["py-%"], [template, make_list(items)])
        return
    assert call_builtin(rt, BUILTINS["py-%"], [template, make_list(items)]) == expected


# --- single cases ------------------------------------------------------------------------------------------------------


def test_templates(call: Caller) -> None:
    assert call("py-%", "%s", [1, "a"]) == "[1, 'a']"
    assert call("py-%", "%s", call("mutable-list", 1)) == "[1]"
    assert call("py-%", "%(name)s is %(age)03d", call("table", "name", "oak", "age", 7)) == "oak is 007"
    assert call("py-%", "%.2f", 1.5) == "1.50"
    assert call("py-%", "(%.1f, %.1f)", Vector((1.0, 2.0))) == "(1.0, 2.0)"
    assert call("py-%", "%.0f", 2.5) == "2"
    assert call("py-%", "50%%", []) == "50%"
    call.refuses("key", "py-%", "%(age)d", call("table", "name", 1))
    call.refuses("format", "py-%", "%(age)d", 1)
    call.refuses("format", "py-%", "%d", "x")
    call.refuses("format", "py-%", "no field", 1)
    for bomb in ("%999999999999d", "%.999999999f", "%9999999999999999999999s"):
        call.refuses("size", "py-%", bomb, 1)
    call.refuses("size", "py-%", "%*d", [10**18, 1])


def test_arrays(call: Caller) -> None:
    assert call.show("py-+", Vector((1, 2)), [3, 4]) == "[4 6]"
    assert call.show("py-+", [0.5, 0], Vector((1, 2))) == "[1.5 2.0]"
    assert call.show("py-*", Vector((1, 2)), True) == "[1 2]"
    assert call.show("py-%", Vector((5, 6)), 4) == "[1 2]"
    assert call("py-==", Vector((1, 2)), [1, 2.0]) is True
    assert call("py-==", call("eye", 4), call("identity-pose")) is True
    assert call("py-==", call("eye", 2), [[1, 0], [0, 1]]) is True
    assert call("py-<", Vector((1, 2)), [1, 3]) is True
    assert call("py-truthy?", Vector((0,))) is False
    assert call("py-truthy?", call("eye", 4)) is True
    assert call("py-truthy?", Vector(())) is False
    assert call("py-in", 1, call("eye", 3)) is True
    assert call("py-in", 5, call("eye", 3)) is False
    assert call("py-in", [1, 0], call("eye", 2)) is True
    assert call.show("py-iter", call("eye", 2)) == "([1.0 0.0] [0.0 1.0])"
    assert call("py-str", Vector((1.0, 2.5))) == "[1.  2.5]"
    call.refuses("value", "py-+", Vector((1, 2)), [1, 2, 3])
    call.refuses("type", "py-+", Vector((1, 2)), "ab")


def test_errors(call: Caller) -> None:
    assert "py-str" in call.refuses("type", "py-+", "a", 1)
    call.refuses("type", "py-+", [1], 1)
    call.refuses("type", "py-*", [1], 2.0)
    call.refuses("type", "py-*", "a", "b")
    call.refuses("type", "py-%", [1], 2)
    call.refuses("zero-division", "py-%", 5, False)
    call.refuses("type", "py-<", 1, "a")
    call.refuses("type", "py-<", None, None)
    call.refuses("type", "py-in", 1, 5)
    call.refuses("type", "py-in", 1, "1")
    call.refuses("type", "py-iter", 5)
    call.refuses("key", "py-ref", call("table", "a", 1), "b")
    call.refuses("index", "py-ref", [1, 2], 2)
    call.refuses("size", "py-*", "ab", 10**12)
    call.refuses("size", "py-*", [1, 2], 10**12)


def test_references(call: Caller) -> None:
    table = call("table", 1, "one", False, "no", [1, 2], "pair")
    assert call("py-ref", table, True) == "one"
    assert call("py-ref", table, 0.0) == "no"
    assert call("py-ref", table, Vector((1, 2))) == "pair"
    assert call("py-ref", [5, 6], False) == 5
    assert call("py-ref", "abc", -1) == "c"
    assert call("py-ref", [[1, 2], [3, 4]], True, 0) == 3
    assert call("py-ref", call("eye", 2), True, True) == 1.0


def test_choices_are_made_when_needed(call: Caller) -> None:
    made = []
    later = function(lambda: made.append(1) or "later")
    assert call("py-bool-or", 5, later) == 5
    assert call("py-bool-and", "", later) == ""
    assert made == []
    assert call("py-bool-or", [], later) == "later"
    assert call("py-bool-and", [0], later) == "later"
    assert made == [1, 1]


def test_parts() -> None:
    definitions = IMPORT + '(define c (call "cube")) (define m (transform c (translate [1 0 0])))'
    check = lambda expression: value(expression, definitions)
    assert check("(eq? (car (py-ref c 0)) c)") is True
    assert check("(eq? (py-ref m 0) m)") is True
    assert check("(length (py-+ c m))") == 2
    assert check("(length (py-+ (union c m) m))") == 3
    assert check("(length (py-* m 3))") == 3
    assert check("(length (py-iter m))") == 1
    assert check("(py-truthy? c)") is True
    assert check("(py-in m (union c m))") is True


@pytest.mark.slow
def test_deep_data_does_not_recurse(rt: Runtime) -> None:
    def deep() -> Any:
        nested: Any = 1
        for level in range(200_000):
            nested = MutableList([nested], 1) if level % 2 else Pair(nested, NIL)
        return nested

    call = Caller(rt)
    a, b = deep(), deep()
    assert call("py-==", a, b) is True
    assert call("py-<", a, b) is False
    assert call("py-in", a, [b]) is True
    assert len(call("py-str", a)) == 400_001
    assert call("py-truthy?", a) is True
    ring = MutableList([], 1)
    ring.items.append(ring)
    other = MutableList([], 1)
    other.items.append(other)
    assert call("py-str", ring) == "[[...]]"
    assert call("py-==", ring, other) is True
    assert Caller(new_runtime(steps=10_000)).error("py-<", ring, other).name == "steps"


@pytest.mark.slow
def test_work_is_charged() -> None:
    long = make_list([make_list([i]) for i in range(30_000)])
    for name, arguments in {
        "py-==": (long, make_list([make_list([i]) for i in range(30_000)])),
        "py-in": (make_list(["x"]), long),
        "py-str": (long,),
        "py-iter": (long,),
        "py-+": (long, long),
    }.items():
        assert Caller(new_runtime(steps=4_000)).error(name, *arguments).name == "steps", name
    shared: Any = NIL
    for _ in range(60):
        shared = Pair(shared, Pair(shared, NIL))
    assert Caller(new_runtime()).error("py-str", shared).name in ("size", "steps")


# --- the import --------------------------------------------------------------------------------------------------------


def test_names_come_with_the_import_only() -> None:
    name, message = failure('(bind "a" (lambda () (print (py-+ 1 2)) (call "cube")))')
    assert (name, message) == ("unbound", "`py-+` is not defined")
    checked = session().check(Source("<test>", "(print (std/py-+ 1 2))"))
    (problem,) = [d for d in checked.diagnostics if d.is_error]
    assert problem.hint == 'add `(import "std/python.scene")`'
    assert not set(build_library().builtins) & set(build_library().imported["python.scene"])


def test_import() -> None:
    assert value("(py-+ 1 #t)", IMPORT) == 2
    assert value("(map py-str '(1 #t))", IMPORT) is not None
    assert value("(p/py-+ 1 #t)", '(import "std/python.scene" :prefix p/)') == 2
    assert value("(py-+ 1 #t)", IMPORT + "(define (py-+ a b) 'mine)") == "mine"
    assert value("(std/py-+ 1 #t)", IMPORT + "(define (py-+ a b) 'mine)") == 2
    assert value("(py-+ 1 #t)", IMPORT + IMPORT) == 2
    macro = "(define-syntax add (syntax-rules () ((_ a b) (py-+ a b))))"
    assert value("(let ((py-+ 5)) (add 1 #t))", IMPORT + macro) == 2


def test_an_expansion_keeps_the_import(tmp_path: Any, capsys: pytest.CaptureFixture[str]) -> None:
    from scenelang.cli.main import main

    (tmp_path / "helper.scene").write_text(IMPORT + "(define (twice x) (py-* x 2))")
    program = tmp_path / "a.scene"
    program.write_text('(import "helper.scene")\n(bind "a" (lambda () (call "cube" :scale (twice 1.5))))')
    assert main(["expand", str(program)]) == 0
    text = capsys.readouterr().out
    assert text.startswith('(import "std/python.scene")\n')
    (tmp_path / "b.scene").write_text(text)
    assert main(["run", "-q", str(tmp_path / "b.scene")]) == 0
