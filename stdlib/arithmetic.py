"""Arithmetic on numbers, and item by item on arrays; comparisons of numbers."""

from __future__ import annotations

import operator
from collections.abc import Callable
from itertools import pairwise
from typing import Any

import numpy as np

from scenelang.grammar.diagnostics import LimitError, SceneError
from scenelang.interpreter.library import Registry
from scenelang.interpreter.runtime import Runtime
from scenelang.interpreter.show import show
from scenelang.interpreter.types import vector_of
from scenelang.interpreter.values import NIL, MutableList, Pair, Vector
from scenelang.stdlib.arraydata import (
    INT64,
    Numpy,
    common_shape,
    from_flat,
    from_numpy,
    is_array,
    largest,
    to_numpy,
)
from scenelang.stdlib.errors import wrong_type

registry = Registry("numbers")

# Python refuses to print integers of more than 4,300 digits and multiplies long ones slowly: integers stay below that.
MOST_DIGITS = 4_000
_MOST_BITS = int(MOST_DIGITS / 0.30103)
_LARGE = 1 << _MOST_BITS
_SHORT = 64  # up to so many items, plain Python beats numpy

Operation = Callable[[Any, Any], Any]


def too_large(bits: int) -> LimitError:
    """The error for an integer of ``bits``."""
    digits = f"about {bits * 30103 // 100_000 + 1:,}" if bits < INT64 else "far too many"
    return LimitError("size", f"an integer of {digits} digits is larger than the limit of {MOST_DIGITS:,}")


def bounded(number: Any) -> Any:
    """``number``, or an error when it is an integer of too many digits."""
    if type(number) is int and not -_LARGE < number < _LARGE:
        raise too_large(number.bit_length())
    return number


def operand_error(name: str, value: Any) -> SceneError:
    """``value`` is no number and no array."""
    hint = None
    if type(value) is Pair or value is NIL or type(value) is MutableList:
        hint = "lists have no arithmetic; an array has, item by item: `(vector ...)`"
        if name == "+":
            hint += "; `append` joins lists"
    elif type(value) is str and name == "+":
        hint = "`string-append` joins strings"
    return wrong_type(name, "numbers or arrays", value, hint)


def charge_digits(rt: Runtime, *numbers: Any) -> None:
    """Charge for work on long integers that grows faster than their length."""
    for number in numbers:
        if type(number) is int and not -INT64 < number < INT64:
            rt.charge(number.bit_length() >> 8)


def check_operand(name: str, value: Any) -> None:
    if type(value) is not int and type(value) is not float and not is_array(value):
        raise operand_error(name, value)


def elementwise(rt: Runtime, name: str, operation: Operation, a: Any, b: Any) -> Any:
    """``operation`` on two numbers or arrays, at least one of them an array."""
    check_operand(name, a)
    check_operand(name, b)
    if type(a) is Vector and len(a) <= _SHORT:
        if type(b) is Vector and len(b) == len(a):
            return _short_vector(name, [operation(x, y) for x, y in zip(a, b)])
        if type(b) is int or type(b) is float:
            return _short_vector(name, [operation(x, b) for x in a])
    elif type(b) is Vector and len(b) <= _SHORT and (type(a) is int or type(a) is float):
        return _short_vector(name, [operation(a, y) for y in b])
    return _broadcast(rt, name, operation, to_numpy(rt, a, name), to_numpy(rt, b, name))


def _short_vector(name: str, numbers: list[Any]) -> Vector:
    if numbers and type(numbers[0]) is int and (max(numbers) >= INT64 or min(numbers) < -INT64):
        raise _wrapped(name)
    return vector_of(numbers)


def itemwise(rt: Runtime, name: str, operation: Operation, a: Any, b: Any) -> Any:
    """``operation``, a plain Python function of two numbers, on all items of two numbers or arrays."""
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
    """``operation`` with numpy, whose integers must not wrap around."""
    common_shape(rt, name, a, b)
    if a.dtype.kind == b.dtype.kind == "i":
        _check_integers(name, a, b)
    if name in ("/", "//", "%") and not b.all():
        raise ZeroDivisionError
    with np.errstate(all="ignore"):
        return from_numpy(operation(a, b))


def _check_integers(name: str, a: Numpy, b: Numpy) -> None:
    bound = 0
    if name in ("+", "-"):
        bound = largest(a) + largest(b)
    elif name == "*":
        bound = largest(a) * largest(b)
    if bound >= INT64:
        raise _wrapped(name)


def _wrapped(name: str) -> SceneError:
    return SceneError("domain", f"`{name}` would make integers that are too large for an array")


def add(rt: Runtime, a: Any, b: Any) -> Any:
    """``a + b`` for numbers and arrays."""
    if type(a) in (int, float) and type(b) in (int, float):
        return bounded(a + b)
    return elementwise(rt, "+", operator.add, a, b)


def subtract(rt: Runtime, a: Any, b: Any) -> Any:
    if type(a) in (int, float) and type(b) in (int, float):
        return bounded(a - b)
    return elementwise(rt, "-", operator.sub, a, b)


def multiply(rt: Runtime, a: Any, b: Any) -> Any:
    if type(a) in (int, float) and type(b) in (int, float):
        if type(a) is int and type(b) is int and a.bit_length() + b.bit_length() > _MOST_BITS:
            raise too_large(a.bit_length() + b.bit_length())
        return a * b
    return elementwise(rt, "*", operator.mul, a, b)


def divide(rt: Runtime, a: Any, b: Any) -> Any:
    if type(a) in (int, float) and type(b) in (int, float):
        return a / b
    return elementwise(rt, "/", operator.truediv, a, b)


def floor_divide(rt: Runtime, a: Any, b: Any) -> Any:
    if type(a) in (int, float) and type(b) in (int, float):
        return a // b
    return elementwise(rt, "//", operator.floordiv, a, b)


def modulo(rt: Runtime, a: Any, b: Any) -> Any:
    if type(a) in (int, float) and type(b) in (int, float):
        return a % b
    return elementwise(rt, "%", operator.mod, a, b)


def power(rt: Runtime, a: Any, b: Any) -> Any:
    if type(a) in (int, float) and type(b) in (int, float):
        return _power(a, b)
    return itemwise(rt, "expt", _power, a, b)


def _power(a: Any, b: Any) -> Any:
    if type(a) is int and type(b) is int and b > 1 and (a > 1 or a < -1):
        bits = (a.bit_length() - 1) * b
        if bits > _MOST_BITS:
            raise too_large(bits)
    result = a**b
    if type(result) is complex:
        raise SceneError("domain", f"`expt` of {show(a, 30)} to the power {show(b, 30)} is no real number")
    return result


def _single(name: str, value: Any) -> Any:
    check_operand(name, value)
    return value


@registry.define(
    "+",
    "numbers::Any ...",
    "Number",
    "The sum of numbers; of arrays item by item. Without arguments 0.",
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
    "number::Any more::Any ...",
    "Number",
    "The first number less all others; of one number its negative. Item by item on arrays.",
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
    "numbers::Any ...",
    "Number",
    "The product of numbers; of arrays item by item (the matrix product is `@`). Without arguments 1.",
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
    "number::Any more::Any ...",
    "Number",
    "The first number divided by all others, as a Float; of one number its reciprocal. Item by item on arrays.",
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
    "number::Any divisor::Any more::Any ...",
    "Number",
    "Division rounded down; whole numbers give a whole number. Item by item on arrays.",
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
    "number::Any divisor::Any",
    "Number",
    "The remainder of `//`; it has the sign of the divisor. Item by item on arrays.",
    ("(% -1 12)", "11"),
    "mod",
)
def remainder_floor(rt: Runtime, number: Any, divisor: Any) -> Any:
    return modulo(rt, number, divisor)


@registry.define(
    "modulo",
    "number::Any divisor::Any",
    "Number",
    "The same as `%`: the remainder with the sign of the divisor.",
    ("(modulo -7 3)", "2"),
)
def modulo_scheme(rt: Runtime, number: Any, divisor: Any) -> Any:
    return modulo(rt, number, divisor)


@registry.define(
    "expt",
    "base::Any exponent::Any",
    "Number",
    "`base` to the power `exponent`. Whole numbers give an Integer unless the exponent is negative. Item by item on "
    "arrays.",
    ("(expt 2 10)", "1024"),
)
def expt(rt: Runtime, base: Any, exponent: Any) -> Any:
    return power(rt, base, exponent)


@registry.define(
    "square",
    "number::Any",
    "Number",
    "The number times itself. Item by item on arrays.",
    ("(square [1 2 3])", "[1 4 9]"),
)
def square(rt: Runtime, number: Any) -> Any:
    return multiply(rt, number, number)


# --- comparisons -----------------------------------------------------------------------------------------------


def _comparable(name: str, value: Any) -> None:
    if type(value) is int or type(value) is float:
        return
    hint = None
    if is_array(value) or type(value) is Pair:
        hint = "`equal?` compares whole values; numbers inside are compared with `map` or `every`"
    elif name == "=":
        hint = "`equal?` compares any values"
    elif type(value) is str:
        hint = f"strings are compared with `string{name}?`"
    raise wrong_type(name, "numbers", value, hint)


def _chain(name: str, holds: Callable[[Any, Any], bool], numbers: tuple[Any, ...]) -> bool:
    """Whether ``holds`` is true of all neighbours."""
    for number in numbers:
        _comparable(name, number)
    return all(holds(a, b) for a, b in pairwise(numbers))


@registry.define(
    "=",
    "number::Any more::Any ...",
    "Boolean",
    "True when all numbers are equal; 1 and 1.0 are.",
    ("(= 1 1.)", "#t"),
    "eq",
)
def equals(rt: Runtime, *numbers: Any) -> bool:
    return _chain("=", operator.eq, numbers)


@registry.define(
    "<",
    "number::Any more::Any ...",
    "Boolean",
    "True when every number is smaller than the next.",
    ("(< 1 2 3)", "#t"),
    "lt",
)
def less(rt: Runtime, *numbers: Any) -> bool:
    return _chain("<", operator.lt, numbers)


@registry.define(
    ">",
    "number::Any more::Any ...",
    "Boolean",
    "True when every number is greater than the next.",
    ("(> 3 2 2)", "#f"),
    "gt",
)
def greater(rt: Runtime, *numbers: Any) -> bool:
    return _chain(">", operator.gt, numbers)


@registry.define(
    "<=",
    "number::Any more::Any ...",
    "Boolean",
    "True when no number is greater than the next.",
    ("(<= 1 1 2)", "#t"),
    "le",
)
def at_most(rt: Runtime, *numbers: Any) -> bool:
    return _chain("<=", operator.le, numbers)


@registry.define(
    ">=",
    "number::Any more::Any ...",
    "Boolean",
    "True when no number is smaller than the next.",
    ("(>= 3 2 2)", "#t"),
    "ge",
)
def at_least(rt: Runtime, *numbers: Any) -> bool:
    return _chain(">=", operator.ge, numbers)
