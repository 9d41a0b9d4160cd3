"""Many handles in little room: numbers that go on in a rhythm, as those of repeated things do, are one item."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from itertools import cycle, pairwise

MAX_HANDLES = 4_000_000
_NUMBERED = re.compile(r"z([1-9]\d{0,17})\Z")
_LONGEST = 48  # numbers in the longest rhythm
_FEWEST = 4  # handles that are worth an item of their own

Item = str | list[int]


def in_order(handles: Iterable[str]) -> tuple[str, ...]:
    """Handles with names of their own, sorted, then those that are numbers, ascending."""
    names, numbers = _parted(set(handles))
    return (*names, *(f"z{number}" for number in numbers))


def packed(handles: Sequence[str]) -> list[Item]:
    """Handles in order as JSON data: `"young"`, or `[first, count, step, step ...]`, the steps repeated."""
    names, numbers = _parted(handles)
    items: list[Item] = [*names]
    steps = [b - a for a, b in pairwise(numbers)]
    at = 0
    while at < len(numbers):
        period, count = _rhythm(steps, at)
        if count >= _FEWEST:
            items.append([numbers[at], count, *steps[at : at + period]])
            at += count
        else:
            items.append(f"z{numbers[at]}")
            at += 1
    return items


def unpacked(items: Iterable[object]) -> tuple[str, ...]:
    """The inverse of ``packed``; raises ValueError for what is none."""
    found: list[str] = []
    for item in items:
        if isinstance(item, str) and item:
            found.append(item)
        elif isinstance(item, list) and len(item) > 2 and all(type(n) is int and n > 0 for n in item):
            if len(found) + item[1] > MAX_HANDLES:
                raise ValueError("more handles than a scene has")
            found += _counted(item[0], item[1], item[2:])
        else:
            raise ValueError("a handle must be a string or a run of numbers")
    return tuple(found)


def _counted(first: int, count: int, steps: Sequence[int]) -> Iterator[str]:
    number = first
    for _, step in zip(range(count), cycle(steps)):
        yield f"z{number}"
        number += step


def _rhythm(steps: Sequence[int], at: int) -> tuple[int, int]:
    """The steps of the rhythm that goes on longest from place ``at``, and how many numbers it covers."""
    best = (1, 1)
    for period in range(1, _LONGEST + 1):
        end = at + period
        while end < len(steps) and steps[end] == steps[end - period]:
            end += 1
        covered = min(end, len(steps)) - at + 1
        if end - at >= 2 * period and covered > best[1]:
            best = (period, covered)
    return best


def _parted(handles: Iterable[str]) -> tuple[list[str], list[int]]:
    names: list[str] = []
    numbers: list[int] = []
    for handle in handles:
        match = _NUMBERED.match(handle)
        if match:
            numbers.append(int(match[1]))
        else:
            names.append(handle)
    return sorted(names), sorted(numbers)
