# Ackermann's function (Ackermann 1928, in Robinson's form) and Hofstadter's female and male sequences; 2026-11-29.
from __future__ import annotations


def ackermann(m: int, n: int) -> int:
    if m == 0:
        return n + 1
    if n == 0:
        return ackermann(m - 1, 1)
    return ackermann(m - 1, ackermann(m, n - 1))


def female(n: int) -> int:
    return 1 if n == 0 else n - male(female(n - 1))


def male(n: int) -> int:
    return 0 if n == 0 else n - female(male(n - 1))


def run(size: int = 60, terms: int = 45) -> int:
    return ackermann(2, size) + sum(map(female, range(terms)))
