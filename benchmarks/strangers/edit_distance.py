# Levenshtein's distance (Wagner and Fischer 1974) and the longest common subsequence of two texts; 2026-11-29.
from __future__ import annotations


def text(n: int, step: int) -> str:
    return "".join(chr(ord("a") + step * i * i % 17) for i in range(n))


def distance(a: str, b: str) -> int:
    row = list(range(len(b) + 1))
    for i, c in enumerate(a):
        diagonal = i
        row[0] = i + 1
        for j, d in enumerate(b):
            above = row[j + 1]
            row[j + 1] = min(above + 1, row[j] + 1, diagonal + (c != d))
            diagonal = above
    return row[-1]


def common(a: str, b: str) -> int:
    rows = [[0] * (len(b) + 1) for _ in range(len(a) + 1)]
    for i in range(len(a)):
        for j in range(len(b)):
            rows[i + 1][j + 1] = 1 + rows[i][j] if a[i] == b[j] else max(rows[i][j + 1], rows[i + 1][j])
    return rows[-1][-1]


def run(size: int = 75) -> str:
    a, b = text(size, 3), text(size, 5)
    return f"{distance(a, b)} {common(a, b)}"
