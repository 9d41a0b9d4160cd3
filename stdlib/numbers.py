"""Functions of numbers: rounding, division of integers, roots, logarithms, angles, predicates, text."""

from __future__ import annotations

import math
import operator
import re
from collections.abc import Callable
from functools import reduce
from typing import Any

from scenelang.grammar.diagnostics import SceneError
from scenelang.grammar.printer import number_text
from scenelang.interpreter.library import Registry
from scenelang.interpreter.runtime import Runtime
from scenelang.interpreter.show import show
from scenelang.interpreter.values import make_list
from scenelang.stdlib.arithmetic import (
    MOST_DIGITS,
    add,
    bounded,
    charge_digits,
    check_operand,
    itemwise,
    multiply,
    subtract,
)
from scenelang.stdlib.arraydata import flat_items, from_flat, shape_of
from scenelang.stdlib.errors import wrong_type

registry = Registry("numbers")

Unary = Callable[[Any], Any]


def domain_error(name: str, value: Any) -> SceneError:
    return SceneError("domain", f"`{name}` of {show(value, 40)} is not a number")


def unary(rt: Runtime, name: str, function: Unary, value: Any) -> Any:
    """``function`` of a number, or of each item of an array; ValueError is an error of the domain."""
    if type(value) is int or type(value) is float:
        try:
            return function(value)
        except ValueError:
            raise domain_error(name, value) from None
    check_operand(name, value)
    flat = flat_items(rt, value)
    out = []
    for index, item in enumerate(flat):
        if not index & 15:
            rt.charge(1)
        try:
            out.append(function(item))
        except ValueError:
            raise domain_error(name, item) from None
    return from_flat(out, shape_of(value))


def _define_unary(name: str, function: Unary, doc: str, example: tuple[str, str]) -> None:
    """Register a function of one number that also works item by item on arrays."""

    @registry.define(name, "x::Any", "Number", doc + " Item by item on arrays.", example)
    def entry(rt: Runtime, x: Any) -> Any:
        return unary(rt, name, function, x)


def _log10(x: float) -> float:
    return math.log10(x)


_define_unary("abs", abs, "The number without its sign.", ("(abs -2.5)", "2.5"))
_define_unary("floor", math.floor, "The largest Integer that is not above `x`.", ("(floor -2.5)", "-3"))
_define_unary("ceiling", math.ceil, "The smallest Integer that is not below `x`.", ("(ceiling 2.1)", "3"))
_define_unary("truncate", math.trunc, "The Integer towards zero: `x` without its fraction.", ("(truncate -2.7)", "-2"))
_define_unary("inexact", float, "The number as a Float.", ("(inexact 3)", "3.0"))
_define_unary("exact->inexact", float, "The same as `inexact`: the number as a Float.", ("(exact->inexact 3)", "3.0"))
_define_unary("sqrt", math.sqrt, "The square root, as a Float.", ("(sqrt 16)", "4.0"))
_define_unary("exp", math.exp, "The number e to the power `x`.", ("(exp 0)", "1.0"))
_define_unary("log10", _log10, "The logarithm to base 10.", ("(log10 1000)", "3.0"))
_define_unary("log2", math.log2, "The logarithm to base 2.", ("(log2 8)", "3.0"))
_define_unary("sin", math.sin, "The sine of an angle in radians.", ("(sin (/ pi 2))", "1.0"))
_define_unary("cos", math.cos, "The cosine of an angle in radians.", ("(cos 0)", "1.0"))
_define_unary("tan", math.tan, "The tangent of an angle in radians.", ("(tan 0)", "0.0"))
_define_unary(
    "asin", math.asin, "The angle in radians, -pi/2 to pi/2, whose sine is `x`.", ("(asin 1)", "1.5707963267948966")
)
_define_unary("acos", math.acos, "The angle in radians, 0 to pi, whose cosine is `x`.", ("(acos 1)", "0.0"))
_define_unary("sinh", math.sinh, "The hyperbolic sine.", ("(sinh 0)", "0.0"))
_define_unary("cosh", math.cosh, "The hyperbolic cosine.", ("(cosh 0)", "1.0"))
_define_unary("tanh", math.tanh, "The hyperbolic tangent.", ("(tanh 0)", "0.0"))
_define_unary("degrees", math.degrees, "An angle in radians as degrees.", ("(degrees pi)", "180.0"))
_define_unary("radians", math.radians, "An angle in degrees as radians.", ("(radians 180)", "3.141592653589793"))


def _sign(x: Any) -> Any:
    return (x > 0) - (x < 0)


_define_unary("sign", _sign, "-1, 0 or 1, as `x` is negative, zero or positive.", ("(sign -2.5)", "-1"))


@registry.define(
    "exact",
    "x::Any",
    "Integer",
    "A whole number as an Integer; any other number is an error, as there are no rationals. Item by item on arrays.",
    ("(exact 3.)", "3"),
)
def exact(rt: Runtime, x: Any) -> Any:
    def whole(number: Any) -> int:
        if number != math.floor(number):
            hint = "`round`, `floor`, `ceiling` and `truncate` give Integers"
            raise SceneError("domain", f"{show(number)} is not whole, so it is no Integer", hint=hint)
        return int(number)

    return unary(rt, "exact", whole, x)


@registry.define(
    "round",
    "x::Any [digits::Integer]",
    "Number",
    "The nearest Integer, halves to the even one. With `digits`, rounded to so many places after the point, as Python "
    "rounds. Item by item on arrays.",
    ("(list (round 2.5) (round 3.14159 2))", "(2 3.14)"),
)
def round_(rt: Runtime, x: Any, digits: int | None = None) -> Any:
    if digits is None:
        return unary(rt, "round", round, x)
    charge_digits(rt, x)
    return unary(rt, "round", lambda number: _rounded(number, min(digits, 400)), x)


def _rounded(number: Any, places: int) -> Any:
    """``round(number, places)``, where Python would compute a power of ten that is larger than any number."""
    if type(number) is int and -places > number.bit_length() // 3 + 2:
        return 0
    return round(number, max(places, -2 * MOST_DIGITS))


@registry.define(
    "log",
    "x::Any [base::Number]",
    "Number",
    "The natural logarithm, or the one to `base`. Item by item on arrays.",
    ("(log 8 2)", "3.0"),
)
def log(rt: Runtime, x: Any, base: Any = None) -> Any:
    if base is None:
        return unary(rt, "log", math.log, x)
    if base <= 0:
        raise domain_error("log", base)
    return unary(rt, "log", lambda number: math.log(number, base), x)


@registry.define(
    "atan",
    "y::Any [x::Any]",
    "Number",
    "The angle in radians whose tangent is `y`; with `x`, the angle of the point (x, y) from the x axis, -pi to pi.",
    ("(degrees (atan 1 -1))", "135.0"),
)
def atan(rt: Runtime, y: Any, x: Any = None) -> Any:
    if x is None:
        return unary(rt, "atan", math.atan, y)
    if type(y) in (int, float) and type(x) in (int, float):
        return math.atan2(y, x)
    return itemwise(rt, "atan", math.atan2, y, x)


@registry.define(
    "hypot",
    "numbers::Number ...",
    "Float",
    "The square root of the sum of the squares: the length of the vector with these coordinates.",
    ("(hypot 3 4)", "5.0"),
)
def hypot(rt: Runtime, *numbers: Any) -> float:
    return math.hypot(*numbers)


@registry.define(
    "clamp",
    "x::Number low::Number high::Number",
    "Number",
    "`x`, but not below `low` and not above `high`. For arrays there is `clip`.",
    ("(clamp 12 0 10)", "10"),
)
def clamp(rt: Runtime, x: Any, low: Any, high: Any) -> Any:
    return max(low, min(x, high))


@registry.define(
    "lerp",
    "a::Any b::Any t::Number",
    "Number",
    "What lies between `a` (at `t` = 0) and `b` (at `t` = 1); numbers or arrays.",
    ("(lerp [0 0 0] [2 4 8] .5)", "[1.0 2.0 4.0]"),
)
def lerp(rt: Runtime, a: Any, b: Any, t: Any) -> Any:
    return add(rt, a, multiply(rt, subtract(rt, b, a), t))


# --- integers --------------------------------------------------------------------------------------------------


def _quotient(a: Any, b: Any) -> Any:
    if type(a) is int and type(b) is int:
        result = abs(a) // abs(b)
        return result if (a < 0) == (b < 0) else -result
    return float(math.trunc(a / b))


def _remainder(a: Any, b: Any) -> Any:
    if type(a) is int and type(b) is int:
        return a - b * _quotient(a, b)
    if b == 0:
        raise ZeroDivisionError
    return math.fmod(a, b)


@registry.define(
    "quotient", "a::Number b::Number", "Number", "Division rounded towards zero.", ("(quotient -7 2)", "-3")
)
def quotient(rt: Runtime, a: Any, b: Any) -> Any:
    return unary(rt, "quotient", lambda number: _quotient(number, b), a)


@registry.define(
    "remainder",
    "a::Number b::Number",
    "Number",
    "The remainder of `quotient`; it has the sign of `a`.",
    ("(remainder -7 2)", "-1"),
)
def remainder(rt: Runtime, a: Any, b: Any) -> Any:
    return unary(rt, "remainder", lambda number: _remainder(number, b), a)


@registry.define(
    "floor/",
    "a::Number b::Number",
    "List",
    "The list of `(// a b)` and `(% a b)`.",
    ("(floor/ -7 2)", "(-4 1)"),
)
def floor_both(rt: Runtime, a: Any, b: Any) -> Any:
    return make_list(divmod(a, b))


@registry.define(
    "truncate/",
    "a::Number b::Number",
    "List",
    "The list of the quotient and the remainder.",
    ("(truncate/ -7 2)", "(-3 -1)"),
)
def truncate_both(rt: Runtime, a: Any, b: Any) -> Any:
    return make_list((quotient(rt, a, b), remainder(rt, a, b)))


@registry.define(
    "bitwise-and", "integers::Integer ...", "Integer", "The bits that all have.", ("(bitwise-and 12 10)", "8")
)
def bitwise_and(rt: Runtime, *integers: int) -> int:
    return reduce(operator.and_, integers, -1)


@registry.define(
    "bitwise-or", "integers::Integer ...", "Integer", "The bits that any has.", ("(bitwise-or 12 10)", "14")
)
def bitwise_or(rt: Runtime, *integers: int) -> int:
    return reduce(operator.or_, integers, 0)


@registry.define(
    "bitwise-xor", "integers::Integer ...", "Integer", "The bits that an odd number has.", ("(bitwise-xor 12 10)", "6")
)
def bitwise_xor(rt: Runtime, *integers: int) -> int:
    return reduce(operator.xor, integers, 0)


@registry.define(
    "arithmetic-shift",
    "n::Integer count::Integer",
    "Integer",
    "The bits moved `count` places to the left, or to the right where it is negative.",
    ("(list (arithmetic-shift 5 2) (arithmetic-shift 5 -1))", "(20 2)"),
)
def arithmetic_shift(rt: Runtime, n: int, count: int) -> Any:
    if count < 0:
        return n >> min(-count, 100_000)
    return bounded(n << min(count, 100_000))


@registry.define(
    "gcd", "integers::Integer ...", "Integer", "The greatest common divisor, never negative.", ("(gcd 12 18)", "6")
)
def gcd(rt: Runtime, *integers: int) -> int:
    charge_digits(rt, *integers)
    return math.gcd(*integers)


@registry.define(
    "lcm", "integers::Integer ...", "Integer", "The least common multiple, never negative.", ("(lcm 4 6)", "12")
)
def lcm(rt: Runtime, *integers: int) -> Any:
    result = 1
    for integer in integers:
        charge_digits(rt, result, integer)
        result = bounded(math.lcm(result, integer))
    return result


# --- predicates ------------------------------------------------------------------------------------------------


def _number(name: str, x: Any) -> Any:
    if type(x) is not int and type(x) is not float:
        raise wrong_type(name, "a number", x)
    return x


def _define_predicate(name: str, holds: Callable[[Any], bool], doc: str, example: tuple[str, str]) -> None:
    @registry.define(name, "x::Any", "Boolean", doc, example)
    def entry(rt: Runtime, x: Any) -> bool:
        return holds(_number(name, x))


_define_predicate("zero?", lambda x: x == 0, "True for 0 and 0.0.", ("(zero? 0.)", "#t"))
_define_predicate("positive?", lambda x: x > 0, "True for numbers above zero.", ("(positive? 0)", "#f"))
_define_predicate("negative?", lambda x: x < 0, "True for numbers below zero.", ("(negative? -1)", "#t"))
_define_predicate("nan?", lambda x: x != x, "True for `nan`, the result of a sum without sense.", ("(nan? nan)", "#t"))
_define_predicate(
    "finite?", math.isfinite, "True for all numbers but `inf`, `-inf` and `nan`.", ("(finite? inf)", "#f")
)
_define_predicate("infinite?", math.isinf, "True for `inf` and `-inf`.", ("(infinite? (- inf))", "#t"))


@registry.define("even?", "n::Integer", "Boolean", "True for a multiple of two.", ("(even? 4)", "#t"))
def is_even(rt: Runtime, n: int) -> bool:
    return n % 2 == 0


@registry.define(
    "odd?", "n::Integer", "Boolean", "True for an Integer that is no multiple of two.", ("(odd? -3)", "#t")
)
def is_odd(rt: Runtime, n: int) -> bool:
    return n % 2 == 1


# --- text ------------------------------------------------------------------------------------------------------

_SHORT = 32
_DIGITS = "0123456789abcdefghijklmnopqrstuvwxyz"
_DECIMAL = re.compile(r"[+-]?(\d+(\.\d*)?|\.\d+)([eE][+-]?\d+)?\Z", re.ASCII)


def _check_radix(name: str, radix: int) -> None:
    if not 2 <= radix <= 36:
        raise SceneError("value", f"`{name}` wants a radix from 2 to 36, got {show(radix, 20)}")


@registry.define(
    "number->string",
    "x::Number [radix::Integer]",
    "String",
    "The number as text, as it prints; an Integer in any `radix` from 2 to 36.",
    ("(list (number->string 1.5) (number->string 255 16))", '("1.5" "ff")'),
)
def number_to_string(rt: Runtime, x: Any, radix: int = 10) -> str:
    _check_radix("number->string", radix)
    charge_digits(rt, x)
    if radix == 10:
        return number_text(x)
    if type(x) is not int:
        raise SceneError("value", f"only an Integer has a text in radix {radix}, got {show(x, 30)}")
    return ("-" if x < 0 else "") + (_digits_of(abs(x), radix).lstrip("0") or "0")


def _digits_of(number: int, radix: int) -> str:
    """The digits of ``number``, with zeros in front of them. A long one is halved, so that no step is quadratic."""
    count = 1
    while radix**count <= number:
        count *= 2
    if count <= _SHORT:
        digits = []
        for _ in range(count):
            number, digit = divmod(number, radix)
            digits.append(_DIGITS[digit])
        return "".join(reversed(digits))
    high, low = divmod(number, radix ** (count // 2))
    return _digits_of(high, radix) + _digits_of(low, radix).rjust(count // 2, "0")


@registry.define(
    "string->number",
    "text::String [radix::Integer]",
    "Any",
    "The number that a text is, or #f when it is none.",
    ('(list (string->number "2.5") (string->number "ff" 16) (string->number "three"))', "(2.5 255 #f)"),
)
def string_to_number(rt: Runtime, text: str, radix: int = 10) -> Any:
    _check_radix("string->number", radix)
    if len(text) > MOST_DIGITS:
        return False
    rt.charge(len(text) >> 6)
    if radix != 10:
        valid = re.fullmatch(r"[+-]?[0-9a-z]+", text.lower())
        try:
            return int(text, radix) if valid else False
        except ValueError:
            return False
    if not _DECIMAL.match(text):
        return False
    try:
        return int(text)
    except ValueError:
        return float(text)
