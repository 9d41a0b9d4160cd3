# The words of a made-up text, counted: the task of Bentley and Knuth's column (CACM 1986); 2026-11-29.
from __future__ import annotations

STEMS = ["oak", "ash", "elm", "lime", "fir", "yew", "box", "birch", "beech", "maple", "holly"]
ENDS = ["", "en", "wood", "leaf", "root", ",", ".", "!"]


def make_text(n: int) -> str:
    seed = 42
    out = []
    for _ in range(n):
        seed = (seed * 1103515245 + 12345) % 2147483648
        out.append(STEMS[seed // 65536 % len(STEMS)] + ENDS[seed // 1024 % len(ENDS)])
    return " ".join(out)


def word_counts(text: str) -> dict[str, int]:
    counts: dict[str, int] = {}
    for word in text.split():
        key = word.rstrip(",.!")
        counts[key] = counts.get(key, 0) + 1
    return counts


def run(words: int = 12000) -> str:
    rows = sorted(word_counts(make_text(words)).items(), key=lambda row: (-row[1], row[0]))
    return ";".join(f"{word}={count}" for word, count in rows)
