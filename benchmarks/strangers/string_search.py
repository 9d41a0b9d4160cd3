# Occurrences of a pattern by comparing characters, and by the table of Knuth, Morris and Pratt (1977); 2026-11-29.
from __future__ import annotations


def fibonacci_word(n: int) -> str:
    a, b = "b", "a"
    while len(b) < n:
        a, b = b, b + a
    return b[:n]


def plain_count(text: str, pattern: str) -> int:
    m = len(pattern)

    def here(i: int) -> bool:
        return all(text[i + k] == pattern[k] for k in range(m))

    return sum(here(i) for i in range(len(text) - m + 1))


def failure_table(pattern: str) -> list[int]:
    out = [0]
    k = 0
    for c in pattern[1:]:
        while k > 0 and c != pattern[k]:
            k = out[k - 1]
        if c == pattern[k]:
            k += 1
        out.append(k)
    return out


def quick_count(text: str, pattern: str) -> int:
    borders = failure_table(pattern)
    k = total = 0
    for c in text:
        while k > 0 and c != pattern[k]:
            k = borders[k - 1]
        if c == pattern[k]:
            k += 1
        if k == len(pattern):
            total += 1
            k = borders[k - 1]
    return total


def run(size: int = 6000) -> str:
    text, pattern = fibonacci_word(size), fibonacci_word(13)
    return f"{plain_count(text, pattern)}/{quick_count(text, pattern)}"
