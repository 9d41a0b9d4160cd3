# The sieve of Eratosthenes with a mutable list, as a Python programmer writes it; 2026-11-29.
from __future__ import annotations

from itertools import pairwise


def primes_below(n: int) -> list[int]:
    prime = [True] * n
    prime[0] = prime[1] = False
    i = 2
    while i * i < n:
        if prime[i]:
            for j in range(i * i, n, i):
                prime[j] = False
        i += 1
    return [p for p in range(n) if prime[p]]


def twins(primes: list[int]) -> list[tuple[int, int]]:
    return [(p, q) for p, q in pairwise(primes) if q - p == 2]


def run(limit: int = 25000) -> int:
    return sum(p for p, _ in twins(primes_below(limit)))
