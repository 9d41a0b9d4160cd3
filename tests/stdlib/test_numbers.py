from __future__ import annotations

import math
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from scenelang.grammar.diagnostics import LimitError
from scenelang.interpreter.runtime.runtime import Runtime
from scenelang.interpreter.values.values import IDENTITY, Array, Matrix, MutableArray, Vector

from .conftest import Caller, new_runtime

SMALL = st.one_of(st.integers(-50, 50), st.floats(-50, 50, allow_nan=False))
CALL = Caller(new_runtime())


def same(a: Any, b: Any) -> bool:
    return type(a) is type(b) and (a == b or (a != a and b != b))


@given(SMALL, SMALL)
def test_arithmetic_is_pythons(a: Any, b: Any) -> None:
    assert same(CALL("+", a, b), a + b)
    assert same(CALL("-", a, b), a - b)
    assert same(CALL("*", a, b), a * b)
    if b:
        assert same(CALL("/", a, b), a / b)
        assert same(CALL("//", a, b), a // b)
        assert same(CALL("%", a, b), a % b)
        assert CALL.python("floor/", a, b) == list(divmod(a, b))


@given(st.integers(-1000, 1000), st.integers(-20, 20).filter(bool))
def test_quotient_and_remainder_truncate(a: int, b: int) -> None:
    assert CALL("quotient", a, b) == int(a / b)
    assert CALL("remainder", a, b) == math.fmod(a, b)
    assert CALL("+", CALL("*", b, CALL("quotient", a, b)), CALL("remainder", a, b)) == a


@given(st.floats(-1e6, 1e6), st.integers(-3, 6))
def test_rounding_is_pythons(x: float, digits: int) -> None:
    for name, function in (("round", round), ("floor", math.floor), ("ceiling", math.ceil), ("truncate", math.trunc)):
        assert same(CALL(name, x), function(x))
    assert same(CALL("round", x, digits), round(x, digits))


def test_any_number_of_arguments(call: Caller) -> None:
    assert call("+") == 0
    assert call("*") == 1
    assert call("+", 1, 2, 3.5) == 6.5
    assert call("-", 5) == -5
    assert call("/", 4) == 0.25
    assert call("-", 10, 1, 2) == 7
    assert call("//", 100, 7, 2) == 7


@pytest.mark.parametrize("name", ["/", "//", "%", "quotient", "remainder", "modulo"])
@pytest.mark.parametrize("zero", [0, 0.0])
def test_division_by_zero(call: Caller, name: str, zero: Any) -> None:
    call.refuses("zero-division", name, 1, zero)
    call.refuses("zero-division", name, 1.5, zero)


@pytest.mark.parametrize("name", ["/", "//", "%"])
def test_division_by_zero_in_arrays(call: Caller, name: str) -> None:
    call.refuses("zero-division", name, Vector((1, 2)), Vector((1, 0)))
    call.refuses("zero-division", name, Array(np.ones((2, 2))), 0)


def test_wrong_operands_say_what_to_do(call: Caller) -> None:
    assert "(vector ...)" in call.refuses("type", "+", [1, 2], 1)
    assert "append" in call.refuses("type", "+", [1, 2], [3])
    assert "(vector ...)" in call.refuses("type", "*", 2, [1])
    assert "string-append" in call.refuses("type", "+", "a", "b")
    call.refuses("type", "+", True, 1)
    call.refuses("type", "-", None)
    call.refuses("type", "+", "a")
    assert "equal?" in call.refuses("type", "=", "a", "a")
    assert "equal?" in call.refuses("type", "=", Vector((1,)), Vector((1,)))
    assert "string<?" in call.refuses("type", "<", "a", "b")


ARRAYS = st.sampled_from([
    Vector((1, -2, 3)),
    Vector((0.5, 2.0, -7.0)),
    Vector(tuple(range(1, 101))),
    Vector((4,)),
    IDENTITY,
    Array(np.arange(1, 7).reshape(2, 3)),
    Array(np.arange(1.0, 4.0).reshape(3, 1)),
])  # fmt: skip
OPERATIONS = {"+": np.add, "-": np.subtract, "*": np.multiply, "/": np.divide, "//": np.floor_divide, "%": np.mod}


def as_numpy(value: Any) -> Any:
    if type(value) is Vector:
        return np.array(value)
    if type(value) is Matrix:
        return np.array([*value, 0.0, 0.0, 0.0, 1.0]).reshape(4, 4)
    return value.data if isinstance(value, Array) else np.array(value)


@given(
    ARRAYS, st.one_of(ARRAYS, st.integers(-9, 9), st.floats(0.5, 4)), st.sampled_from(sorted(OPERATIONS)), st.booleans()
)
def test_arrays_are_numpys(a: Any, b: Any, name: str, swap: bool) -> None:
    left, right = (b, a) if swap else (a, b)
    x, y = as_numpy(left), as_numpy(right)
    try:
        np.broadcast_shapes(x.shape, y.shape)
    except ValueError:
        assert "cannot broadcast" in CALL.refuses("value", name, left, right)
        return
    if name in ("/", "//", "%") and not y.all():
        CALL.refuses("zero-division", name, left, right)
        return
    wanted = OPERATIONS[name](x, y)
    got = as_numpy(CALL(name, left, right))
    assert got.shape == wanted.shape
    assert got.dtype.kind == wanted.dtype.kind or wanted.shape == (4, 4)
    assert got.tolist() == wanted.tolist()


def test_poses_stay_poses_only_while_they_are(call: Caller) -> None:
    assert type(call("*", IDENTITY, 1)) is Matrix
    assert type(call("+", IDENTITY, IDENTITY)) is Array


def test_integers_in_arrays_never_wrap(call: Caller) -> None:
    big = 1 << 62
    for left in (Vector((big, 1)), Array(np.array([[big, 1]]))):
        assert "too large" in call.refuses("domain", "+", left, left)
        assert "too large" in call.refuses("domain", "*", left, left)
    assert call("+", Vector((big,)), Vector((-big,))) == (0,)


def test_integers_are_bounded(call: Caller) -> None:
    assert call("expt", 2, 100) == 2**100
    for name, a, b in (("expt", 10, 5000), ("expt", 10, 10**100), ("expt", -7, 10**9)):
        with pytest.raises(LimitError, match="digits"):
            call(name, a, b)
    big = call("expt", 10, 3900)
    with pytest.raises(LimitError):
        call("*", big, big)
    with pytest.raises(LimitError):
        doubled(call, big, 2000)
    with pytest.raises(LimitError):
        call("lcm", call("expt", 2, 9000), call("expt", 3, 5000))


def doubled(call: Caller, number: int, times: int) -> int:
    for _ in range(times):
        number = call("+", number, number)
    return number


def test_powers(call: Caller) -> None:
    assert call("expt", 2, -1) == 0.5
    assert call("expt", 0, 0) == 1
    assert call("expt", 4, 0.5) == 2.0
    assert call("expt", Vector((1, 2, 3)), 2) == (1, 4, 9)
    call.refuses("domain", "expt", -8, 1 / 3)
    call.refuses("domain", "expt", 10.0, 400)
    call.refuses("zero-division", "expt", 0, -1)


def test_domains(call: Caller) -> None:
    for name, value in (("sqrt", -1), ("log", 0), ("log", -2.0), ("acos", 2), ("asin", -1.5), ("sin", math.inf)):
        call.refuses("domain", name, value)
    call.refuses("domain", "sqrt", Vector((1, -1)))
    call.refuses("domain", "exp", 1000)
    call.refuses("domain", "floor", math.nan)
    call.refuses("domain", "round", math.inf)
    call.refuses("domain", "log", 2, -1)
    call.refuses("zero-division", "log", 2, 1)
    call.refuses("domain", "exact", 2.5)


def test_results_that_are_whole_are_integers(call: Caller) -> None:
    for name in ("floor", "ceiling", "truncate", "round", "exact"):
        assert type(call(name, 3.0)) is int
    assert call("round", Vector((0.5, 1.5, 2.5))) == (0, 2, 2)
    assert call("round", 123456, -2) == 123500
    assert call("round", 5, -(10**12)) == 0
    assert call("round", 5.5, 10**30) == 5.5


def test_angles(call: Caller) -> None:
    assert call("atan", 1, 1) == math.atan2(1, 1)
    assert call("atan", 1) == math.atan(1)
    assert call("atan", Vector((1.0, 0.0)), Vector((0.0, 1.0))) == (math.pi / 2, 0.0)
    assert call("deg", Vector((180, 90))) == (math.pi, math.pi / 2)
    assert call("hypot", 3, 4) == 5.0


@given(st.lists(st.integers(-3, 3), min_size=1, max_size=5))
def test_comparison_chains(numbers: list[int]) -> None:
    pairs = list(pairwise(numbers))
    assert CALL("=", *numbers) == all(a == b for a, b in pairs)
    assert CALL("<", *numbers) == all(a < b for a, b in pairs)
    assert CALL(">", *numbers) == all(a > b for a, b in pairs)
    assert CALL("<=", *numbers) == all(a <= b for a, b in pairs)
    assert CALL(">=", *numbers) == all(a >= b for a, b in pairs)


def test_number_predicates(call: Caller) -> None:
    assert call("integer?", 2.0) is True
    assert call("integer?", "2") is False
    assert call("number?", True) is False
    assert call("nan?", math.nan) is True
    assert call("even?", 4.0) is True
    call.refuses("type", "zero?", "0")
    call.refuses("type", "odd?", 1.5)


@given(st.one_of(st.integers(), st.floats(allow_nan=False, allow_infinity=False)))
def test_numbers_survive_their_text(number: Any) -> None:
    assert same(CALL("string->number", CALL("number->string", number)), number)


@given(st.integers(-(10**12), 10**12), st.integers(2, 36))
def test_radix(number: int, radix: int) -> None:
    text = CALL("number->string", number, radix)
    assert int(text, radix) == number
    assert CALL("string->number", text, radix) == number


@pytest.mark.parametrize(
    "text", ["", " 1", "1 ", "1_000", "0x10", "nan", "one", "1/2", "--1", "\N{ARABIC-INDIC DIGIT ONE}"]
)
def test_texts_that_are_no_numbers(call: Caller, text: str) -> None:
    assert call("string->number", text) is False


def test_lerp_and_clamp(call: Caller) -> None:
    assert call("lerp", 0, 10, 0.5) == 5.0
    assert call("lerp", Vector((0, 0)), Vector((2, 4)), 0.5) == (1.0, 2.0)
    assert call("clamp", -1, 0, 10) == 0


def test_mutable_arrays_count_as_read(rt: Runtime) -> None:
    array = MutableArray(np.array([1.0, 2.0]), rt.clock)
    rt.serial = rt.clock + 1
    assert Caller(rt)("*", array, 2) == (2.0, 4.0)
    assert array.observed


def test_a_smooth_step_between_opposite_ends_of_floats(call: Caller) -> None:
    assert [call("smoothstep", -1e308, 1e308, x) for x in (-1e308, 0.0, 1e308)] == [0.0, 0.5, 1.0]
