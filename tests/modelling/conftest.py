"""What the tests of solid modelling share: values of expressions as numpy arrays, and the errors that they end in."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from support import value

from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.values.values import Array, list_items

FloatArray = npt.NDArray[np.float64]


def as_array(found: Any) -> FloatArray:
    return np.asarray(found.data if isinstance(found, Array) else found, np.float64)


@pytest.fixture
def array() -> Callable[[str], FloatArray]:
    """The value of an expression, an array."""
    return lambda expression: as_array(value(expression))


@pytest.fixture
def number() -> Callable[[str], float]:
    """The value of an expression, a number."""
    return lambda expression: float(value(expression))


@pytest.fixture
def contours() -> Callable[[str], list[FloatArray]]:
    """The value of an expression, a list of contours."""
    return lambda expression: [as_array(contour) for contour in list_items(value(expression))]


@pytest.fixture
def refuses() -> Callable[[str, str], str]:
    """The message of the error, of a given name, that an expression ends in."""

    def check(name: str, expression: str) -> str:
        with pytest.raises(SceneError) as caught:
            value(expression)
        assert caught.value.name == name, caught.value
        return f"{caught.value.message} | {caught.value.hint or ''}"

    return check
