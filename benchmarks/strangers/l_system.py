# A plant of Prusinkiewicz and Lindenmayer (1990, figure 1.24 d), rewritten and followed by a turtle; 2026-11-29.
from __future__ import annotations

from math import cos, pi, radians, sin

RULES = {"X": "F[+X]F[-X]+X", "F": "FF"}


def plant(n: int) -> str:
    return "X" if n == 0 else "".join(RULES.get(c, c) for c in plant(n - 1))


def follow(text: str) -> float:
    kept = []
    x = y = highest = 0.0
    angle = pi / 2
    for c in text:
        if c == "F":
            x += cos(angle)
            y += sin(angle)
            highest = max(highest, y)
        elif c == "+":
            angle += radians(20)
        elif c == "-":
            angle -= radians(20)
        elif c == "[":
            kept.append((x, y, angle))
        elif c == "]":
            x, y, angle = kept.pop()
    return highest + x


def run(generations: int = 6) -> float:
    return round(follow(plant(generations)), 6)
