# Lists through composed functions: closures, curried operators, folds and a group-by; 2026-11-29.
from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import reduce
from itertools import count

Step = Callable[[int], int]


def compose(*functions: Step) -> Step:
    return lambda x: reduce(lambda value, f: f(value), functions, x)


def adding(n: int) -> Step:
    return lambda x: x + n


def times(n: int) -> Step:
    return lambda x: x * n


def modulo_of(n: int) -> Step:
    return lambda x: x % n


def group_by(key: Step, xs: Iterable[int]) -> dict[int, list[int]]:
    groups: dict[int, list[int]] = {}
    for x in xs:
        groups.setdefault(key(x), []).append(x)
    return groups


scramble = compose(times(17), adding(5), modulo_of(1009), adding(-200))


def run(size: int = 6000) -> int:
    numbers = count(1)
    values = [scramble(next(numbers)) for _ in range(size)]
    groups = group_by(lambda x: x % 7, (x for x in values if x % 3 != 0))
    small = [xs for xs in groups.values() if len(xs) < size / 11]
    spread = max(max(xs) - min(xs) for xs in groups.values())
    return 1000 * len(small) + spread + sum(len(set(xs[:-51:-1])) for xs in groups.values())
