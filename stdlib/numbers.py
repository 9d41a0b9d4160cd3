"""Builtins for numbers: arithmetic, comparison, rounding, integer division, logarithms, angles, predicates and text."""

from __future__ import annotations

import math
import operator
import re
from collections.abc import Callable
from functools import reduce
from itertools import pairwise
from typing import TYPE_CHECKING, Any

from scenelang.grammar.datum import number_text
from scenelang.grammar.diagnostics import LimitError, SceneError
from scenelang.grammar.lazy_patterns import lazy_pattern
from scenelang.interpreter.loading import np
from scenelang.interpreter.runtime.show import show
from scenelang.interpreter.runtime.types import Registry, vector_of
from scenelang.interpreter.values.values import NIL, MutableList, Pair, Vector, make_list
from scenelang.stdlib.operands import (
    INT64,
    Numpy,
    common_shape,
    flat_items,
    from_flat,
    from_numpy,
    is_array,
    largest,
    shape_of,
    to_numpy,
    wrong_type,
)

if TYPE_CHECKING:
    from scenelang.interpreter.runtime.runtime import Runtime

registry = Registry("numbers")

# Python refuses to print integers of more than 4,300 digits (`sys.set_int_max_str_digits`), and its multiplication
# takes more than linear time, so larger integers are errors.
MAX_DIGITS = 4_000
_MAX_BITS = int(MAX_DIGITS / 0.30103)  # a bit is log10(2) digits
_BOUND = 1 << _MAX_BITS
_SHORT_ARRAY = 64  # items up to which plain Python is faster than numpy
_MAX_SHIFT = 100_000  # bits: more than any integer has, and a result of more would be refused anyway
_MAX_PLACES = 400  # decimal places: a float has no more

Operation = Callable[[Any, Any], Any]


def too_large(bits: int) -> LimitError:
    """Return the error for an integer of ``bits`` bits."""
    digits = f"about {bits * 30103 // 100_000 + 1:,}" if bits < INT64 else "far too many"
    return LimitError("size", f"an integer of {digits} digits is larger than the limit of {MAX_DIGITS:,}")


def bounded(number: Any) -> Any:
    """Return ``number``; an integer with too many digits is an error."""
    if type(number) is int and not -_BOUND < number < _BOUND:
        raise too_large(number.bit_length())
    return number


def operand_error(name: str, value: Any) -> SceneError:
    """Return the error for an operand that is neither a number nor an array."""
    hint = None
    if type(value) is Pair or value is NIL or type(value) is MutableList:
        hint = "to calculate elementwise, use an array: `(vector ...)`"
        if name == "+":
            hint += "; to concatenate lists, write `(append a b)`"
    elif type(value) is str and name == "+":
        hint = "to concatenate strings, write `(string-append a b)`"
    return wrong_type(name, "numbers or arrays", value, hint)


def charge_digits(rt: Runtime, *numbers: Any) -> None:
    """Charge for work on long integers that is more than linear in their length."""
    for number in numbers:
        if type(number) is int and not -INT64 < number < INT64:
            rt.charge(number.bit_length() >> 8)


def check_operand(name: str, value: Any) -> None:
    """Raise SceneError for a value that is neither a number nor an array."""
    if type(value) is not int and type(value) is not float and not is_array(value):
        raise operand_error(name, value)


def elementwise(rt: Runtime, name: str, operation: Operation, a: Any, b: Any) -> Any:
    """Apply an operation to two numbers or arrays, at least one of them an array, as numpy broadcasts them.

    Parameters
    ----------
    name
        Builtin that error messages name.
    operation
        Function of two numbers or numpy arrays.
    a, b
        Operands.

    Returns
    -------
    Vector or Array
        Array of the results.

    Raises
    ------
    SceneError
        If an operand is neither a number nor an array, or the shapes differ.
    """
    check_operand(name, a)
    check_operand(name, b)
    if type(a) is Vector and len(a) <= _SHORT_ARRAY:
        if type(b) is Vector and len(b) == len(a):
            return _short_vector(name, [operation(x, y) for x, y in zip(a, b)])
        if type(b) is int or type(b) is float:
            return _short_vector(name, [operation(x, b) for x in a])
    elif type(b) is Vector and len(b) <= _SHORT_ARRAY and (type(a) is int or type(a) is float):
        return _short_vector(name, [operation(a, y) for y in b])
    return _broadcast(rt, name, operation, to_numpy(rt, a, name), to_numpy(rt, b, name))


def _short_vector(name: str, numbers: list[Any]) -> Vector:
    """Return a vector of results, whose integers must fit 64 bits as in numpy."""
    if numbers and type(numbers[0]) is int and (max(numbers) >= INT64 or min(numbers) < -INT64):
        raise overflow_error(name)
    return vector_of(numbers)


def itemwise(rt: Runtime, name: str, operation: Operation, a: Any, b: Any) -> Any:
    """Apply ``operation``, a plain Python function of two numbers, to each pair of items of two numbers or arrays."""
    check_operand(name, a)
    check_operand(name, b)
    left, right = to_numpy(rt, a, name), to_numpy(rt, b, name)
    shape = common_shape(rt, name, left, right)
    pairs = zip(np.broadcast_to(left, shape).ravel().tolist(), np.broadcast_to(right, shape).ravel().tolist())
    out = []
    for index, (x, y) in enumerate(pairs):
        if not index & 15:
            rt.charge(1)
        number = operation(x, y)
        if type(number) is int and not -INT64 < number < INT64:
            rt.charge(number.bit_length() >> 9)
        out.append(number)
    return from_flat(out, shape)


def _broadcast(rt: Runtime, name: str, operation: Operation, a: Numpy, b: Numpy) -> Any:
    """Apply ``operation`` with numpy; an overflow of its integers is an error."""
    common_shape(rt, name, a, b)
    if a.dtype.kind == b.dtype.kind == "i":
        _check_integers(name, a, b)
    if name in ("/", "//", "%") and not b.all():
        raise ZeroDivisionError
    with np.errstate(all="ignore"):
        return from_numpy(operation(a, b))


def _check_integers(name: str, a: Numpy, b: Numpy) -> None:
    """Raise SceneError if integers of a result may exceed 64 bits, which numpy would not report."""
    bound = 0
    if name in ("+", "-"):
        bound = largest(a) + largest(b)
    elif name == "*":
        bound = largest(a) * largest(b)
    if bound >= INT64:
        raise overflow_error(name)


def overflow_error(name: str) -> SceneError:
    """Return the error for integers of an array that exceed 64 bits."""
    return SceneError("domain", f"the integers of the result of `{name}` are too large for an array")


def add(rt: Runtime, a: Any, b: Any) -> Any:
    """Return ``a + b`` for numbers and arrays."""
    if type(a) in (int, float) and type(b) in (int, float):
        return bounded(a + b)
    return elementwise(rt, "+", operator.add, a, b)


def subtract(rt: Runtime, a: Any, b: Any) -> Any:
    """Return ``a - b`` for numbers and arrays."""
    if type(a) in (int, float) and type(b) in (int, float):
        return bounded(a - b)
    return elementwise(rt, "-", operator.sub, a, b)


def multiply(rt: Runtime, a: Any, b: Any) -> Any:
    """Return ``a * b`` for numbers and arrays; the size of integers is checked before, because that takes long."""
    if type(a) in (int, float) and type(b) in (int, float):
        if type(a) is int and type(b) is int and a.bit_length() + b.bit_length() > _MAX_BITS:
            raise too_large(a.bit_length() + b.bit_length())
        return a * b
    return elementwise(rt, "*", operator.mul, a, b)


def divide(rt: Runtime, a: Any, b: Any) -> Any:
    """Return ``a / b`` for numbers and arrays."""
    if type(a) in (int, float) and type(b) in (int, float):
        return a / b
    return elementwise(rt, "/", operator.truediv, a, b)


def floor_divide(rt: Runtime, a: Any, b: Any) -> Any:
    """Return ``a // b`` for numbers and arrays."""
    if type(a) in (int, float) and type(b) in (int, float):
        return a // b
    return elementwise(rt, "//", operator.floordiv, a, b)


def modulo(rt: Runtime, a: Any, b: Any) -> Any:
    """Return ``a % b`` for numbers and arrays."""
    if type(a) in (int, float) and type(b) in (int, float):
        return a % b
    return elementwise(rt, "%", operator.mod, a, b)


def power(rt: Runtime, a: Any, b: Any) -> Any:
    """Return ``a ** b`` for numbers and arrays."""
    if type(a) in (int, float) and type(b) in (int, float):
        result = _power(a, b)
        charge_digits(rt, result)
        return result
    return itemwise(rt, "expt", _power, a, b)


def _power(a: Any, b: Any) -> Any:
    """Return a power of two numbers; one with too many digits, or a complex one, is an error."""
    if type(a) is int and type(b) is int and b > 1 and (a > 1 or a < -1):
        bits = (a.bit_length() - 1) * b
        if bits > _MAX_BITS:
            raise too_large(bits)
    result = a**b
    if type(result) is complex:
        raise SceneError("domain", f"{show(a, 30)} to the power {show(b, 30)} is not a real number")
    return result


def _single(name: str, value: Any) -> Any:
    """Return the first operand after checking it, since no operation does so for a single one."""
    check_operand(name, value)
    return value


@registry.define(
    "+",
    "numbers::Numeric ...",
    "Number",
    "Return the sum of numbers, elementwise for arrays; 0 without arguments.",
    ("(+ 1 2 .5)", "3.5"),
    "add",
)
def plus(rt: Runtime, *numbers: Any) -> Any:
    if not numbers:
        return 0
    total = _single("+", numbers[0])
    for number in numbers[1:]:
        total = add(rt, total, number)
    return total


@registry.define(
    "-",
    "number::Numeric more::Numeric ...",
    "Number",
    "Subtract all others from the first number; negate a single number. Elementwise on arrays.",
    ("(- [5 5] 2)", "[3 3]"),
    "sub",
)
def minus(rt: Runtime, number: Any, *more: Any) -> Any:
    if not more:
        return subtract(rt, 0, number) if is_array(number) else -_single("-", number)
    for other in more:
        number = subtract(rt, number, other)
    return number


@registry.define(
    "*",
    "numbers::Numeric ...",
    "Number",
    "Return the product of numbers, elementwise for arrays (the matrix product is `@`); 1 without arguments.",
    ("(* 2 [1 2 3])", "[2 4 6]"),
    "mul",
)
def times(rt: Runtime, *numbers: Any) -> Any:
    if not numbers:
        return 1
    result = _single("*", numbers[0])
    for number in numbers[1:]:
        result = multiply(rt, result, number)
    return result


@registry.define(
    "/",
    "number::Numeric more::Numeric ...",
    "Number",
    "Divide the first number by all others, as a Float; return the reciprocal of a single number. Elementwise on "
    "arrays.",
    ("(/ 7 2)", "3.5"),
    "div",
)
def over(rt: Runtime, number: Any, *more: Any) -> Any:
    if not more:
        return divide(rt, 1, number)
    for other in more:
        number = divide(rt, number, other)
    return number


@registry.define(
    "//",
    "number::Numeric divisor::Numeric more::Numeric ...",
    "Number",
    "Divide and round down (floor division); the quotient of Integers is an Integer. Elementwise on arrays.",
    ("(// -7 2)", "-4"),
    "floordiv",
)
def floor_over(rt: Runtime, number: Any, divisor: Any, *more: Any) -> Any:
    number = floor_divide(rt, number, divisor)
    for other in more:
        number = floor_divide(rt, number, other)
    return number


@registry.define(
    "%",
    "number::Numeric divisor::Numeric",
    "Number",
    "Return the remainder of `//`, with the sign of the divisor. Elementwise on arrays.",
    ("(% -1 12)", "11"),
    "mod",
)
def remainder_floor(rt: Runtime, number: Any, divisor: Any) -> Any:
    return modulo(rt, number, divisor)


@registry.define(
    "modulo",
    "number::Numeric divisor::Numeric",
    "Number",
    "The same as `%`: the remainder with the sign of the divisor.",
    ("(modulo -7 3)", "2"),
)
def modulo_scheme(rt: Runtime, number: Any, divisor: Any) -> Any:
    return modulo(rt, number, divisor)


@registry.define(
    "expt",
    "base::Numeric exponent::Numeric",
    "Number",
    "Return `base` to the power `exponent`: an Integer for Integers unless the exponent is negative. Elementwise on "
    "arrays.",
    ("(expt 2 10)", "1024"),
)
def expt(rt: Runtime, base: Any, exponent: Any) -> Any:
    return power(rt, base, exponent)


@registry.define(
    "square",
    "number::Numeric",
    "Number",
    "Return the number times itself. Elementwise on arrays.",
    ("(square [1 2 3])", "[1 4 9]"),
)
def square(rt: Runtime, number: Any) -> Any:
    return multiply(rt, number, number)


# --- comparisons -----------------------------------------------------------------------------------------------


def _comparable(name: str, value: Any) -> None:
    """Raise SceneError for a value that is not a number.

    Arrays are among these: their comparison would always be true in a condition.
    """
    if type(value) is int or type(value) is float:
        return
    hint = None
    if is_array(value) or type(value) is Pair:
        hint = "to compare whole values, use `equal?`; to compare their items, use `map` or `every`"
    elif name == "=":
        hint = "to compare values of any type, write `(equal? a b)`"
    elif type(value) is str:
        hint = f"to compare strings, write `(string{name}? a b)`"
    raise wrong_type(name, "numbers", value, hint)


def _chain(name: str, holds: Callable[[Any, Any], bool], numbers: tuple[Any, ...]) -> bool:
    """Return whether ``holds`` is true for all pairs of neighbors."""
    for number in numbers:
        _comparable(name, number)
    return all(holds(a, b) for a, b in pairwise(numbers))


@registry.define(
    "=",
    "number::Number more::Number ...",
    "Boolean",
    "Return whether all numbers are equal; 1 and 1.0 are.",
    ("(= 1 1.)", "#t"),
    "eq",
)
def equals(rt: Runtime, *numbers: Any) -> bool:
    return _chain("=", operator.eq, numbers)


@registry.define(
    "<",
    "number::Number more::Number ...",
    "Boolean",
    "Return whether every number is less than the next.",
    ("(< 1 2 3)", "#t"),
    "lt",
)
def less(rt: Runtime, *numbers: Any) -> bool:
    return _chain("<", operator.lt, numbers)


@registry.define(
    ">",
    "number::Number more::Number ...",
    "Boolean",
    "Return whether every number is greater than the next.",
    ("(> 3 2 2)", "#f"),
    "gt",
)
def greater(rt: Runtime, *numbers: Any) -> bool:
    return _chain(">", operator.gt, numbers)


@registry.define(
    "<=",
    "number::Number more::Number ...",
    "Boolean",
    "Return whether every number is less than or equal to the next.",
    ("(<= 1 1 2)", "#t"),
    "le",
)
def at_most(rt: Runtime, *numbers: Any) -> bool:
    return _chain("<=", operator.le, numbers)


@registry.define(
    ">=",
    "number::Number more::Number ...",
    "Boolean",
    "Return whether every number is greater than or equal to the next.",
    ("(>= 3 2 2)", "#t"),
    "ge",
)
def at_least(rt: Runtime, *numbers: Any) -> bool:
    return _chain(">=", operator.ge, numbers)


Unary = Callable[[Any], Any]


def domain_error(name: str, value: Any) -> SceneError:
    """Return the error for a number outside the domain of a function."""
    return SceneError("domain", f"`{name}` is not defined for {show(value, 40)}")


def unary(rt: Runtime, name: str, function: Unary, value: Any) -> Any:
    """Apply ``function`` to a number, or to each item of an array.

    ``name`` is the builtin that error messages name. A ValueError of the function becomes SceneError: its argument is
    outside its domain.
    """
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
    """Register a function of one number that also works elementwise on arrays."""

    @registry.define(name, "x::Numeric", "Number", doc + " Elementwise on arrays.", example)
    def entry(rt: Runtime, x: Any) -> Any:
        """Apply the function elementwise."""
        return unary(rt, name, function, x)


def _log10(x: float) -> float:
    return math.log10(x)


_define_unary("abs", abs, "Return the absolute value.", ("(abs -2.5)", "2.5"))
_define_unary("floor", math.floor, "Return the largest Integer not greater than `x`.", ("(floor -2.5)", "-3"))
_define_unary("ceiling", math.ceil, "Return the smallest Integer not less than `x`.", ("(ceiling 2.1)", "3"))
_define_unary("truncate", math.trunc, "Round towards zero to an Integer.", ("(truncate -2.7)", "-2"))
_define_unary("inexact", float, "Convert a number to a Float.", ("(inexact 3)", "3.0"))
_define_unary(
    "exact->inexact", float, "The same as `inexact`: convert a number to a Float.", ("(exact->inexact 3)", "3.0")
)
_define_unary("sqrt", math.sqrt, "Return the square root, as a Float.", ("(sqrt 16)", "4.0"))
_define_unary("exp", math.exp, "Return e to the power `x`.", ("(exp 0)", "1.0"))
_define_unary("log10", _log10, "Return the logarithm to base 10.", ("(log10 1000)", "3.0"))
_define_unary("log2", math.log2, "Return the logarithm to base 2.", ("(log2 8)", "3.0"))
_define_unary("sin", math.sin, "Return the sine of an angle in radians.", ("(sin (/ pi 2))", "1.0"))
_define_unary("cos", math.cos, "Return the cosine of an angle in radians.", ("(cos 0)", "1.0"))
_define_unary("tan", math.tan, "Return the tangent of an angle in radians.", ("(tan 0)", "0.0"))
_define_unary(
    "asin", math.asin, "Return the arc sine of `x` in radians, from -pi/2 to pi/2.", ("(asin 1)", "1.5707963267948966")
)
_define_unary("acos", math.acos, "Return the arc cosine of `x` in radians, from 0 to pi.", ("(acos 1)", "0.0"))
_define_unary("sinh", math.sinh, "Return the hyperbolic sine.", ("(sinh 0)", "0.0"))
_define_unary("cosh", math.cosh, "Return the hyperbolic cosine.", ("(cosh 0)", "1.0"))
_define_unary("tanh", math.tanh, "Return the hyperbolic tangent.", ("(tanh 0)", "0.0"))
_define_unary(
    "deg", math.radians, "Return an angle that is given in degrees, in radians.", ("(deg 180)", "3.141592653589793")
)
_define_unary(
    "to-degrees", math.degrees, "Return an angle that is given in radians, in degrees.", ("(to-degrees pi)", "180.0")
)


def _sign(x: Any) -> Any:
    """Return -1, 0 or 1; 0 for nan."""
    return (x > 0) - (x < 0)


_define_unary(
    "sign", _sign, "Return -1, 0 or 1 for a negative number, zero or a positive number.", ("(sign -2.5)", "-1")
)


@registry.define(
    "exact",
    "x::Numeric",
    "Integer",
    "Convert a whole number to an Integer; other numbers are an error, as there are no rationals. Elementwise on "
    "arrays.",
    ("(exact 3.)", "3"),
)
def exact(rt: Runtime, x: Any) -> Any:
    def to_integer(number: Any) -> int:
        """Return a whole number as an Integer."""
        if number != math.floor(number):
            hint = "to convert it, use `round`, `floor`, `ceiling` or `truncate`"
            raise SceneError("domain", f"`exact` expects a whole number, got {show(number)}", hint=hint)
        return int(number)

    return unary(rt, "exact", to_integer, x)


@registry.define(
    "round",
    "x::Numeric [digits::Integer]",
    "Number",
    "Round to the nearest Integer, halves to even; with `digits`, to that many decimal places, as Python does. "
    "Elementwise on arrays.",
    ("(list (round 2.5) (round 3.14159 2))", "(2 3.14)"),
)
def round_(rt: Runtime, x: Any, digits: int | None = None) -> Any:
    if digits is None:
        return unary(rt, "round", round, x)
    charge_digits(rt, x)
    return unary(rt, "round", lambda number: _rounded(number, min(digits, _MAX_PLACES)), x)


def _rounded(number: Any, places: int) -> Any:
    """Return ``round(number, places)``, with bounds on ``places`` so that Python computes no huge power of ten."""
    if type(number) is int and -places > number.bit_length() // 3 + 2:
        return 0
    return round(number, max(places, -2 * MAX_DIGITS))


@registry.define(
    "log",
    "x::Numeric [base::Number]",
    "Number",
    "Return the natural logarithm, or the logarithm to `base`. Elementwise on arrays.",
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
    "y::Numeric [x::Numeric]",
    "Number",
    "Return the arc tangent of `y` in radians; with `x`, the angle of the point (x, y) from the x axis, from -pi to "
    "pi.",
    ("(to-degrees (atan 1 -1))", "135.0"),
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
    "Return the square root of the sum of squares: the length of the vector with these coordinates.",
    ("(hypot 3 4)", "5.0"),
)
def hypot(rt: Runtime, *numbers: Any) -> float:
    return math.hypot(*numbers)


@registry.define(
    "clamp",
    "x::Number low::Number high::Number",
    "Number",
    "Limit `x` to the range from `low` to `high`. For arrays there is `clip`.",
    ("(clamp 12 0 10)", "10"),
)
def clamp(rt: Runtime, x: Any, low: Any, high: Any) -> Any:
    return max(low, min(x, high))


@registry.define(
    "lerp",
    "a::Numeric b::Numeric t::Number",
    "Any",
    "Interpolate linearly between `a` (at `t` = 0) and `b` (at `t` = 1, up to rounding), numbers or arrays.",
    ("(lerp [0 0 0] [2 4 8] .5)", "[1.0 2.0 4.0]"),
)
def lerp(rt: Runtime, a: Any, b: Any, t: Any) -> Any:
    # a + (b - a) t is not b at t = 1 for numbers of other sizes, and overflows for opposite ones
    return add(rt, multiply(rt, a, subtract(rt, 1, t)), multiply(rt, b, t))


@registry.define(
    "smoothstep",
    "a::Number b::Number x::Numeric",
    "Any",
    "Return 0 for `x` up to `a`, 1 from `b` on, and 3 t^2 - 2 t^3 between them, where t is the share of the way; "
    "`x` is a number or an array.",
    ("(smoothstep 0 10 [-5 5 20])", "[0.0 0.5 1.0]"),
)
def smoothstep(rt: Runtime, a: Any, b: Any, x: Any) -> Any:
    if a == b:
        raise SceneError("value", "`smoothstep` expects two different edges")
    with np.errstate(all="ignore"):
        scale = 1.0 if math.isfinite(b - a) else 0.5  # the difference of opposite ones may overflow
        share = scale * np.asarray(to_numpy(rt, x, "smoothstep"), np.float64) - scale * a
        t = np.clip(share / (scale * b - scale * a), 0.0, 1.0)
    rt.charge(t.size >> 6)
    return from_numpy(t * t * (3.0 - 2.0 * t))


# --- integers --------------------------------------------------------------------------------------------------


def _quotient(a: Any, b: Any) -> Any:
    """Divide and round toward zero; integers exactly, without a detour through floats."""
    if type(a) is int and type(b) is int:
        result = abs(a) // abs(b)
        return result if (a < 0) == (b < 0) else -result
    return float(math.trunc(a / b))


def _remainder(a: Any, b: Any) -> Any:
    """Return the remainder of ``_quotient``, with the sign of ``a``."""
    if type(a) is int and type(b) is int:
        return a - b * _quotient(a, b)
    if b == 0:
        raise ZeroDivisionError
    return math.fmod(a, b)


@registry.define(
    "quotient", "a::Number b::Number", "Number", "Divide and round towards zero.", ("(quotient -7 2)", "-3")
)
def quotient(rt: Runtime, a: Any, b: Any) -> Any:
    return unary(rt, "quotient", lambda number: _quotient(number, b), a)


@registry.define(
    "remainder",
    "a::Number b::Number",
    "Number",
    "Return the remainder of `quotient`, with the sign of `a`.",
    ("(remainder -7 2)", "-1"),
)
def remainder(rt: Runtime, a: Any, b: Any) -> Any:
    return unary(rt, "remainder", lambda number: _remainder(number, b), a)


@registry.define(
    "floor/",
    "a::Number b::Number",
    "List",
    "Return the list of `(// a b)` and `(% a b)`.",
    ("(floor/ -7 2)", "(-4 1)"),
)
def floor_both(rt: Runtime, a: Any, b: Any) -> Any:
    return make_list(divmod(a, b))


@registry.define(
    "truncate/",
    "a::Number b::Number",
    "List",
    "Return the list of the quotient and the remainder.",
    ("(truncate/ -7 2)", "(-3 -1)"),
)
def truncate_both(rt: Runtime, a: Any, b: Any) -> Any:
    return make_list((quotient(rt, a, b), remainder(rt, a, b)))


@registry.define(
    "exact-integer-sqrt",
    "n::Integer",
    "List",
    "Return the list of the largest integer whose square is at most `n`, and the difference to `n`.",
    ("(exact-integer-sqrt 17)", "(4 1)"),
)
def exact_integer_sqrt(rt: Runtime, n: int) -> Any:
    if n < 0:
        raise SceneError("value", f"`exact-integer-sqrt` expects an Integer that is not negative, got {show(n, 30)}")
    rt.charge(n.bit_length() >> 4)
    root = math.isqrt(n)
    return make_list((root, n - root * root))


@registry.define(
    "bitwise-and",
    "integers::Integer ...",
    "Integer",
    "Return the bits that are set in all integers.",
    ("(bitwise-and 12 10)", "8"),
)
def bitwise_and(rt: Runtime, *integers: int) -> int:
    return reduce(operator.and_, integers, -1)


@registry.define(
    "bitwise-or",
    "integers::Integer ...",
    "Integer",
    "Return the bits that are set in any of the integers.",
    ("(bitwise-or 12 10)", "14"),
)
def bitwise_or(rt: Runtime, *integers: int) -> int:
    return reduce(operator.or_, integers, 0)


@registry.define(
    "bitwise-xor",
    "integers::Integer ...",
    "Integer",
    "Return the bits that are set in an odd number of the integers.",
    ("(bitwise-xor 12 10)", "6"),
)
def bitwise_xor(rt: Runtime, *integers: int) -> int:
    return reduce(operator.xor, integers, 0)


@registry.define(
    "arithmetic-shift",
    "n::Integer count::Integer",
    "Integer",
    "Shift the bits left by `count` places, or right if `count` is negative.",
    ("(list (arithmetic-shift 5 2) (arithmetic-shift 5 -1))", "(20 2)"),
)
def arithmetic_shift(rt: Runtime, n: int, count: int) -> Any:
    if count < 0:
        return n >> min(-count, _MAX_SHIFT)
    return bounded(n << min(count, _MAX_SHIFT))


@registry.define(
    "gcd",
    "integers::Integer ...",
    "Integer",
    "Return the greatest common divisor, never negative.",
    ("(gcd 12 18)", "6"),
)
def gcd(rt: Runtime, *integers: int) -> int:
    charge_digits(rt, *integers)
    return math.gcd(*integers)


@registry.define(
    "lcm", "integers::Integer ...", "Integer", "Return the least common multiple, never negative.", ("(lcm 4 6)", "12")
)
def lcm(rt: Runtime, *integers: int) -> Any:
    result = 1
    for integer in integers:
        charge_digits(rt, result, integer)
        result = bounded(math.lcm(result, integer))
    return result


# --- predicates ------------------------------------------------------------------------------------------------


def _number(name: str, x: Any) -> Any:
    """Return a number; anything else is an error."""
    if type(x) is not int and type(x) is not float:
        raise wrong_type(name, "a number", x)
    return x


def _define_predicate(name: str, holds: Callable[[Any], bool], doc: str, example: tuple[str, str]) -> None:
    """Register a predicate of one number."""

    @registry.define(name, "x::Number", "Boolean", doc, example)
    def entry(rt: Runtime, x: Any) -> bool:
        return holds(_number(name, x))


_define_predicate("zero?", lambda x: x == 0, "Return whether a number is 0 or 0.0.", ("(zero? 0.)", "#t"))
_define_predicate(
    "positive?", lambda x: x > 0, "Return whether a number is greater than zero.", ("(positive? 0)", "#f")
)
_define_predicate("negative?", lambda x: x < 0, "Return whether a number is less than zero.", ("(negative? -1)", "#t"))
_define_predicate(
    "nan?",
    lambda x: x != x,
    "Return whether a number is `nan`, the result of an undefined operation.",
    ("(nan? nan)", "#t"),
)
_define_predicate(
    "finite?", math.isfinite, "Return whether a number is neither `inf`, `-inf` nor `nan`.", ("(finite? inf)", "#f")
)
_define_predicate("infinite?", math.isinf, "Return whether a number is `inf` or `-inf`.", ("(infinite? (- inf))", "#t"))


@registry.define(
    "even?", "n::Integer", "Boolean", "Return whether an Integer is a multiple of two.", ("(even? 4)", "#t")
)
def is_even(rt: Runtime, n: int) -> bool:
    return n % 2 == 0


@registry.define(
    "odd?", "n::Integer", "Boolean", "Return whether an Integer is not a multiple of two.", ("(odd? -3)", "#t")
)
def is_odd(rt: Runtime, n: int) -> bool:
    return n % 2 == 1


# --- text ------------------------------------------------------------------------------------------------------

_MAX_SIMPLE_DIGITS = 32  # that are divided off one by one
_DIGITS = "0123456789abcdefghijklmnopqrstuvwxyz"
_DECIMAL = lazy_pattern(r"[+-]?(\d+(\.\d*)?|\.\d+)([eE][+-]?\d+)?\Z", re.ASCII)


def _check_radix(name: str, radix: int) -> None:
    """Raise SceneError for a radix without enough digits and letters."""
    if not 2 <= radix <= 36:
        raise SceneError("value", f"`{name}` expects a radix from 2 to 36, got {show(radix, 20)}")


@registry.define(
    "number->string",
    "x::Number [radix::Integer]",
    "String",
    "Convert a number to text, as it prints; an Integer in any `radix` from 2 to 36.",
    ("(list (number->string 1.5) (number->string 255 16))", '("1.5" "ff")'),
)
def number_to_string(rt: Runtime, x: Any, radix: int = 10) -> str:
    if radix == 10 and (type(x) is float or -INT64 < x < INT64):
        return repr(x)
    _check_radix("number->string", radix)
    charge_digits(rt, x)
    if radix == 10:
        return number_text(x)
    if type(x) is not int:
        raise SceneError("value", f"`number->string` expects an Integer for radix {radix}, got {show(x, 30)}")
    rt.charge(x.bit_length() >> 5)
    return ("-" if x < 0 else "") + (_digits_of(abs(x), radix).lstrip("0") or "0")


def _digits_of(number: int, radix: int) -> str:
    """Return the digits of ``number`` with leading zeros.

    Divide and conquer: a long number is split in two halves, so that the divisions of all digits are not quadratic
    (Knuth, The Art of Computer Programming, volume 2, section 4.4).
    """
    count = 1
    while radix**count <= number:
        count *= 2
    if count <= _MAX_SIMPLE_DIGITS:
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
    "Parse a string as a number; return #f if it is not one.",
    ('(list (string->number "2.5") (string->number "ff" 16) (string->number "three"))', "(2.5 255 #f)"),
)
def string_to_number(rt: Runtime, text: str, radix: int = 10) -> Any:
    _check_radix("string->number", radix)
    if len(text) > MAX_DIGITS:
        return False
    rt.charge(len(text) >> 6)
    if radix != 10:
        valid = re.fullmatch(r"[+-]?[0-9a-z]+", text.lower())
        try:
            return int(text, radix) if valid else False
        except ValueError:
            return False
    if not _DECIMAL.match(text):  # Python's `float` also accepts "nan", underscores and other digits
        return False
    try:
        return int(text)
    except ValueError:
        return float(text)


# --- constants -------------------------------------------------------------------------------------------------

CONSTANTS: dict[str, tuple[float, str]] = {
    "pi": (math.pi, "Half the circumference of the unit circle; half a turn in radians."),
    "tau": (math.tau, "The circumference of the unit circle; a full turn in radians."),
    "e": (math.e, "The base of the natural logarithm."),
    "inf": (math.inf, "Infinity; poses, and the numbers that a primitive reads, must be finite."),
    "nan": (math.nan, "Not a number, such as `(- inf inf)`; it is not equal to any number, not even to itself."),
}
