# Walks in the plane until they leave a disc, each with its own seed; 2026-11-29.
from __future__ import annotations

from random import Random


def walk(seed: int) -> int:
    source = Random(seed)
    x = y = 0.0
    n = 0
    while x * x + y * y <= 100:
        x += source.uniform(-1, 1)
        y += source.uniform(-1, 1)
        n += 1
    return n


def run(walks: int = 60) -> float:
    return sum(walk(seed) for seed in range(walks)) / walks
