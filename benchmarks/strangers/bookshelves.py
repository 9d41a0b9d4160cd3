# A library of shelves that are filled with books until there is no more room, with leaning books and gaps; 2026-11-29.
from __future__ import annotations

from math import floor
from random import Random

from things import AT_HOME, Pose, Thing, count, product, translate, turn_z

CLOTHS = [(0.5, 0.1, 0.1), (0.1, 0.3, 0.2), (0.1, 0.15, 0.4), (0.7, 0.6, 0.3)]


def book(width: float, height: float, color: tuple[float, float, float]) -> Thing:
    body = Thing("cube", scale=(width, height, 0.2), color=color)
    parts = [(body, translate(width / 2, height / 2, 0))]
    if width > 0.045:
        band = Thing("cube", scale=(width, 0.02, 0.21), color=(0.9, 0.8, 0.4))
        parts.append((band, translate(width / 2, 0.8 * height, 0)))
    return Thing("book", parts, width=width, height=height, color=color)


def row(length: float, source: Random) -> list[tuple[Thing, Pose]]:
    x = 0.02
    books: list[tuple[Thing, Pose]] = []
    while True:
        width, height = source.uniform(0.02, 0.06), source.uniform(0.18, 0.3)
        if x + width > length:
            return books
        if source.uniform(0, 1) < 0.05:
            x += 0.08
            continue
        lean = turn_z(-0.15) if source.uniform(0, 1) < 0.04 else AT_HOME
        paint = CLOTHS[floor(1000 * width) % 4]
        books.append((book(width, height, paint), product(translate(x, 0, 0), lean)))
        x += width + 0.002


def shelf(length: float, source: Random) -> Thing:
    board = Thing("cube", scale=(length, 0.02, 0.25), color=(0.4, 0.3, 0.2))
    parts = [(board, translate(length / 2, -0.01, 0)), *row(length, source)]
    return Thing("shelf", parts, length=length)


def case(shelves: int, source: Random) -> Thing:
    parts = [(shelf(1.6, source), translate(0, 0.35 * k, 0)) for k in range(shelves)]
    return Thing("case", parts)


def run(cases: int = 40, shelves: int = 8) -> int:
    source = Random(3)
    places = [translate(1.7 * (i % 10), 0, 1.5 * (i // 10)) for i in range(cases)]
    return count(Thing("library", [(case(shelves, source), place) for place in places]))
