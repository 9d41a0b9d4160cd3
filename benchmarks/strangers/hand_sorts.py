# Merge sort on lists (Scheme's way) and Shell's sort in place (Shell 1959), of the same numbers; 2026-11-29.
from __future__ import annotations


def numbers(n: int) -> list[int]:
    x = 12345
    out = []
    for _ in range(n):
        out.append(x)
        x = (x * 69069 + 1) % 65536
    return out[::-1]


def merge(a: list[int], b: list[int]) -> list[int]:
    i = j = 0
    out = []
    while i < len(a) and j < len(b):
        if a[i] <= b[j]:
            out.append(a[i])
            i += 1
        else:
            out.append(b[j])
            j += 1
    return out + a[i:] + b[j:]


def merge_sort(xs: list[int]) -> list[int]:
    half = len(xs) // 2
    return xs if len(xs) < 2 else merge(merge_sort(xs[:half]), merge_sort(xs[half:]))


def shell_sort(xs: list[int]) -> None:
    for gap in (701, 301, 132, 57, 23, 10, 4, 1):
        for i in range(gap, len(xs)):
            x = xs[i]
            j = i
            while j >= gap and xs[j - gap] > x:
                xs[j] = xs[j - gap]
                j -= gap
            xs[j] = x


def run(size: int = 1500) -> int:
    merged = merge_sort(numbers(size))
    shelled = numbers(size)
    shell_sort(shelled)
    return sum((i * a + b) % 997 for i, (a, b) in enumerate(zip(merged, shelled)))
