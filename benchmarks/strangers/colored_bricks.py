# A block of bricks in nested loops, each with the color of its place; 2026-11-29.
from __future__ import annotations

from things import Thing, count, translate


def run(side: int = 25) -> int:
    parts = []
    for x in range(side):
        for y in range(side):
            for z in range(side):
                if not (x % 2 and y % 2 and z % 2):
                    brick = Thing("cube", scale=(0.9, 0.4, 0.4), color=(x / side, y / side, z / side))
                    parts.append((brick, translate(x + (0.5 if y % 2 else 0), 0.5 * y, 0.5 * z)))
    return count(Thing("bricks", parts))
