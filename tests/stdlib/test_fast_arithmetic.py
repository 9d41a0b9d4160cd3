"""The fast paths of sums, differences and products, against the builtins themselves."""

from __future__ import annotations

import math
from random import Random
from typing import Any

import pytest
from support import session

from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.compile import intrinsics
from scenelang.interpreter.runtime.procedures import call_builtin
from scenelang.interpreter.runtime.runtime import Runtime
from scenelang.interpreter.values.values import Vector

INTEGERS = (0, 1, -1, 7, 2**31, 2**52 + 1, 2**62, 2**63 - 1, -(2**63))
FLOATS = (0.0, -0.0, 1.5, -2.25, 5e-324, 1e308, -1e308, math.inf, math.nan)
OTHERS = (2**70, -(2**1100), True, "a", None)
RUNTIME = Runtime(session().library)


def operand(pick: Random) -> Any:
    """A number, a vector of mostly three Integers or Floats, or something else."""
    if pick.random() < 0.4:
        return pick.choice((*INTEGERS, *FLOATS, *OTHERS))
    numbers = pick.choice((INTEGERS, FLOATS))
    return Vector([pick.choice(numbers) for _ in range(pick.choice((1, 2, 3, 3, 3, 3, 4)))])


def outcome(function: Any, x: Any, y: Any) -> Any:
    try:
        result = function(x, y)
    except SceneError as error:
        return error.name, error.message
    return [type(each) for each in (result, *(result if isinstance(result, tuple) else ()))], repr(result)


@pytest.mark.parametrize(("name", "sign"), [("add", "+"), ("sub", "-"), ("mul", "*")])
def test_results_and_errors_are_those_of_the_builtin(name: str, sign: str) -> None:
    builtin = RUNTIME.library.builtins[sign]

    def slow(x: Any, y: Any) -> Any:
        return call_builtin(RUNTIME, builtin, [x, y])

    fast, pick = intrinsics.ARITHMETIC[name](slow), Random(7)
    for _ in range(3_000):
        x, y = operand(pick), operand(pick)
        assert outcome(fast, x, y) == outcome(slow, x, y), (x, y)
