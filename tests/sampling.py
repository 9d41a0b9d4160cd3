"""Parameters of tests of which a part runs every time, and the rest with the slow tests."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from typing import Any

import pytest


def one_in(number: int, values: Iterable[Any]) -> list[Any]:
    """Each ``number``-th value from the first on as usual, the others marked as slow."""
    return [value if not i % number else _slow(value) for i, value in enumerate(values)]


def only(kept: Collection[Any], values: Iterable[Any]) -> list[Any]:
    """The values that are in ``kept`` as usual, the others marked as slow."""
    return [value if value in kept else _slow(value) for value in values]


def _slow(value: Any) -> Any:
    """A parameter of a slow test; a tuple is several parameters, as for ``pytest.mark.parametrize``."""
    if hasattr(value, "marks"):
        return pytest.param(*value.values, marks=[*value.marks, pytest.mark.slow], id=value.id)
    return pytest.param(*(value if isinstance(value, tuple) else (value,)), marks=pytest.mark.slow)
