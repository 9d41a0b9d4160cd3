from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from scenelang.grammar.diagnostics import CODES, SceneError
from scenelang.interpreter.runtime.procedures import Condition
from scenelang.interpreter.runtime.runtime import Runtime
from scenelang.interpreter.scene.primitives.base import linear
from scenelang.interpreter.values.values import NIL, Embedding, HandleList, Keyword, MutableList, Pair, Symbol, Vector
from scenelang.stdlib import builtin_names
from scenelang.stdlib.colors import named_colors
from scenelang.stdlib.library import build_library, index_text
from scenelang.stdlib.numbers import CONSTANTS

from .conftest import ALL_TOPICS, BUILTINS, Caller

NAMES = """
+ - * / // % quotient remainder modulo floor/ expt abs min max sum product floor ceiling round truncate exact inexact
number->string string->number sqrt exp log sin cos tan asin acos atan sinh cosh tanh hypot deg to-degrees clamp lerp
gcd lcm even? odd? zero? positive? negative? integer? nan? length ref slice append reverse map filter for-each fold
reduce any every apply iota range zip enumerate list-ref list-tail list-head first second last take drop contains?
empty? index-of member assoc sort min-of max-of flatten list-index count delete-duplicates repeat make-list
string->list ->list mutable set-ref! push! pop! insert! remove! remove-at! extend! sort! reverse! shuffle! clear!
update! remove-key! add! table-keys table-values table-items table-merge keywords has-key? set-union set-intersection
set-difference subset? list->set array vector zeros ones full eye linspace arange dot cross norm normalize distance
transpose reshape stack-arrays concatenate mean argmin argmax cumsum interp where clip inverse determinant solve
identity-pose array-shape x-of y-of z-of @ random uniform randint choice normal shuffle permutation rand randn
py-random py-uniform py-randint py-choice py-choices py-sample py-shuffle py-gauss string-append string-join
string-split string-upcase string-downcase string-trim string-contains? string-prefix? string-suffix? string-index
string-replace string-pad ord chr format error-message error-code error-is? print boolean? integer? number? string?
symbol? list? pair? vector? array? matrix? table? set? procedure? entity? embedding? none? set-seed! py-set-seed!
random-stream default-rng py-random-stream mutable-list mutable-array table set = < > <= >= not eq? eqv? equal?
cons car cdr list error raise values null? color
""".split()  # noqa: SIM905


def test_all_that_the_design_lists_is_there() -> None:
    assert [name for name in NAMES if name not in BUILTINS] == []


def test_entries_are_complete() -> None:
    for topic in ALL_TOPICS:
        for name, entry in topic.entries.items():
            assert entry.doc.endswith("."), name
            assert entry.signature.text == entry.parameters
            assert entry.doc[0].isupper() or entry.doc[0] in "-`#", name


def test_the_index_has_every_name() -> None:
    """After a new builtin: ``make tables``."""
    assert Path(builtin_names.__file__).read_text("utf-8") == index_text()


def test_names_are_unique() -> None:
    assert sum(len(topic.entries) for topic in ALL_TOPICS) == len(BUILTINS)


def test_fast_paths_are_marked() -> None:
    marks = {entry.intrinsic: name for name, entry in BUILTINS.items() if entry.intrinsic}
    wanted = {
        "add": "+", "sub": "-", "mul": "*", "div": "/", "floordiv": "//", "mod": "%", "eq": "=", "lt": "<", "gt": ">",
        "le": "<=", "ge": ">=", "not": "not", "car": "car", "cdr": "cdr", "cons": "cons", "null?": "null?",
        "pair?": "pair?", "matmul": "@",
    }  # fmt: skip
    assert wanted.items() <= marks.items()


def test_build_library() -> None:
    library = build_library()
    assert library is build_library()
    assert library.builtins["+"] is BUILTINS["+"]
    assert library.constants["pi"] == CONSTANTS["pi"][0]
    assert library.constants.keys() == library.constant_docs.keys()
    assert "prelude.scene" in library.modules


def test_importing_is_light() -> None:
    heavy = ["numpy.random", "fractions", "decimal", "colorsys", "statistics"]
    code = f"import sys, scenelang.stdlib.library; print([m for m in {heavy} if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


# --- control ---------------------------------------------------------------------------------------------------


def test_errors_as_data(call: Caller) -> None:
    caught = Condition(call.error("ref", [1, 2], 5))
    assert call("error?", caught) is True
    assert call("error-message", caught) == "index 5 is outside the list of length 2"
    assert call("error-code", caught) == CODES["index"].code
    assert call("error-is?", caught, "index") is True
    assert call("error-is?", caught, "key") is False
    assert call("error-is?", 42, "user") is True
    assert call("error-message", 42) == "42"
    assert "did you mean" in call.refuses("value", "error-is?", caught, "indx")
    call.refuses("type", "error-code", 42)


def test_raising(call: Caller) -> None:
    assert call.error("error", "no leg:", 5, "x").message == 'no leg: 5 "x"'
    assert call.error("raise", 42).value == 42
    original = SceneError("key", "gone")
    assert call.error("raise", Condition(original)) is original


def test_print(rt: Runtime) -> None:
    assert Caller(rt)("print", "legs:", 4, scheme_list(1, "a")) is None
    assert rt.log == ['legs: 4 (1 "a")']


def scheme_list(*items: object) -> object:
    return Pair(items[0], Pair(items[1], NIL))


# --- tests of types --------------------------------------------------------------------------------------------

LIST, EMPTY = Pair(1, NIL), MutableList([], 1)
KINDS = {
    "boolean?": [True, False], "none?": [None], "number?": [1, 1.5], "integer?": [1], "string?": ["a"],
    "symbol?": [Symbol("a")], "keyword?": [Keyword("a")], "list?": [NIL, LIST, EMPTY],
    "pair?": [Pair(1, 2), LIST, HandleList(2)], "null?": [NIL, EMPTY], "vector?": [Vector((1,))],
    "procedure?": [BUILTINS["car"]], "embedding?": [Embedding()],
}  # fmt: skip


@pytest.mark.parametrize("name", sorted(KINDS))
def test_types(call: Caller, name: str) -> None:
    for kind, values in KINDS.items():
        for value in values:
            assert call(name, value) is any(value is member for member in KINDS[name]), (kind, value)


def test_equality(call: Caller) -> None:
    assert call("eq?", "ab", "".join(["a", "b"])) is True
    assert call("eq?", [1], [1]) is False
    assert call("eq?", 1, 1.0) is False
    assert call("eq?", True, 1) is False
    assert call("eq?", Symbol("a"), "a") is False
    assert call("equal?", [1, [2]], [1, [2]]) is True
    assert call("equal?", [1], [1.0]) is False
    assert call("equal?", [1], call("mutable-list", 1)) is True
    assert call("not", None) is True
    assert call("not", NIL) is False


# --- colors ---------------------------------------------------------------------------------------------------


def test_colors(call: Caller) -> None:
    assert call("color", "#C08040") == tuple(linear(x / 255) for x in (0xC0, 0x80, 0x40))
    assert call("color", "Light Blue") == call("color", "#add8e6")
    assert call("color", "#fff") == (1.0, 1.0, 1.0)
    assert abs(call("rgb", 188, 188, 188)[0] - 0.5) < 0.005
    assert call("hsv", 1 / 3, 1, 1)[1] == 1.0
    assert len(named_colors()) == 148
    assert 'did you mean "ivory"' in call.refuses("value", "color", "ivry")
    call.refuses("value", "color", "#12345")
    call.refuses("value", "color", "#ggg")
    call.refuses("value", "rgb", 256, 0, 0)
    call.refuses("type", "hsv", float("inf"), 1, 1)
