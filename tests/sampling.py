"""Parameters of tests of which a part runs every time, and the rest with the slow tests.

Long tests (``durations``) take turns by the day; ``SCENELANG_TEST_DAY=1`` runs those of another one, ``all`` all.
"""

from __future__ import annotations

import os
from collections import defaultdict
from collections.abc import Collection, Iterable
from datetime import date
from pathlib import Path
from typing import Any
from zlib import crc32

import pytest

DAYS = 5  # in which each case of a long test runs once
DAY = os.environ.get("SCENELANG_TEST_DAY") or str(date.today().toordinal() % DAYS)


def one_in(number: int, values: Iterable[Any]) -> list[Any]:
    """Each ``number``-th value from the first on as usual, the others marked as slow."""
    return [value if not i % number else _slow(value) for i, value in enumerate(values)]


def only(kept: Collection[Any], values: Iterable[Any]) -> list[Any]:
    """The values that are in ``kept`` as usual, the others marked as slow."""
    return [value if value in kept else _slow(value) for value in values]


def mark(items: Iterable[pytest.Item]) -> None:
    """Mark as slow all but one in ``n`` of the cases of each test that is marked ``sampled(n)``.

    Which ones stay depends on the names of the cases alone, not on how many there are.
    """
    groups: dict[str, list[pytest.Item]] = defaultdict(list)
    for item in items:
        if item.get_closest_marker("sampled") is not None:
            groups[item.nodeid.partition("[")[0]].append(item)
    for group in groups.values():
        marker = group[0].get_closest_marker("sampled")
        assert marker is not None
        kept = -(-len(group) // marker.args[0])
        for item in sorted(group, key=lambda each: crc32(each.nodeid.encode()))[kept:]:
            item.add_marker(pytest.mark.slow)


def take_turns(items: Iterable[pytest.Item]) -> None:
    """Mark as slow the cases of long tests that run on other days; which ones depends on their names alone."""
    long_tests = set((Path(__file__).parent / "long_tests.txt").read_text("utf-8").split())
    for item in items:
        if item.nodeid.partition("[")[0] in long_tests and DAY not in ("all", str(crc32(item.nodeid.encode()) % DAYS)):
            item.add_marker(pytest.mark.slow)


def _slow(value: Any) -> Any:
    """A parameter of a slow test; a tuple is several parameters, as for ``pytest.mark.parametrize``."""
    if hasattr(value, "marks"):
        return pytest.param(*value.values, marks=[*value.marks, pytest.mark.slow], id=value.id)
    return pytest.param(*(value if isinstance(value, tuple) else (value,)), marks=pytest.mark.slow)
