# An elementary cellular automaton on a ring of cells, rule 30 (Wolfram 1983); 2026-11-29.
from __future__ import annotations

Rule = dict[tuple[int, int, int], int]


def rule_of(number: int) -> Rule:
    return {(a, b, c): number >> (4 * a + 2 * b + c) & 1 for a in (0, 1) for b in (0, 1) for c in (0, 1)}


def step(row: list[int], rule: Rule) -> list[int]:
    n = len(row)
    return [rule[row[i - 1], row[i], row[(i + 1) % n]] for i in range(n)]


def run(cells: int = 101, generations: int = 90) -> int:
    rule = rule_of(30)
    row = [int(i == cells // 2) for i in range(cells)]
    total = 0
    for _ in range(generations):
        total += sum(row)
        row = step(row, rule)
    return total
