"""Conway's game of life on a table: a glider, a blinker and a beacon, one frame for each generation"""
from helper import *
from collections import Counter
from itertools import product
from typing import Generator, Iterable

Cells = frozenset[tuple[int, int]]
SIZE = 14

PATTERNS = {
    'glider': """
        .#.
        ..#
        ###""",
    'blinker': "###",
    'beacon': """
        ##..
        ##..
        ..##
        ..##""",
}


def parse(text: str, dx: int = 0, dz: int = 0) -> set[tuple[int, int]]:
    rows = [line.strip() for line in text.strip().splitlines()]
    return {(x + dx, z + dz) for z, row in enumerate(rows) for x, mark in enumerate(row) if mark == '#'}


def neighbors(cell: tuple[int, int]) -> Iterable[tuple[int, int]]:
    x, z = cell
    return (((x + dx) % SIZE, (z + dz) % SIZE) for dx, dz in product((-1, 0, 1), repeat=2) if (dx, dz) != (0, 0))


def evolve(alive: Cells) -> Cells:
    counts = Counter(n for cell in alive for n in neighbors(cell))
    return frozenset(cell for cell, count in counts.items() if count == 3 or (count == 2 and cell in alive))


def history(alive: Cells) -> Generator[tuple[Cells, dict[tuple[int, int], int]], None, None]:
    """Yield the living cells with the age of each."""
    ages = dict.fromkeys(alive, 0)
    while True:
        yield alive, ages
        alive = evolve(alive)
        ages = {cell: ages.get(cell, -1) + 1 for cell in alive}


@register("a living cell; it is darker the older it is")
def cell(age: int = 0) -> Shape:
    fade = 0.8 ** age
    body = primitive_call('cube', shape_kwargs={'scale': (0.85, 0.4, 0.85)}, color=(0.1 + 0.5 * fade, 0.3 + 0.6 * fade, 0.25))
    if age == 0:
        return body
    knob = primitive_call('sphere', shape_kwargs={'radius': 0.15}, color=(0.9, 0.9, 0.3))
    return concat_shapes(body, transform_shape(knob, translation_matrix((0, 0.25, 0))))


@register("the table with grooves between the fields")
def table(size: int = SIZE) -> Shape:
    top = primitive_call('cube', shape_kwargs={'scale': (size + 0.6, 0.3, size + 0.6)}, color=(0.25, 0.2, 0.18))
    lines = []
    for k in range(size + 1):
        at = k - size / 2
        lines.append(transform_shape(primitive_call('cube', shape_kwargs={'scale': (0.05, 0.02, size)}, color=(0.5, 0.5, 0.5)), translation_matrix((at, 0.16, 0))))
        lines.append(transform_shape(primitive_call('cube', shape_kwargs={'scale': (size, 0.02, 0.05)}, color=(0.5, 0.5, 0.5)), translation_matrix((0, 0.16, at))))
    return concat_shapes(top, *lines)


def picture(ages: dict[tuple[int, int], int]) -> Shape:
    middle = (SIZE - 1) / 2
    pieces = [transform_shape(library_call('cell', age=ages[x, z]), translation_matrix((x - middle, 0.36, z - middle))) for x, z in sorted(ages)]
    return concat_shapes(library_call('table'), *pieces)


@register_animation("six generations")
def game_of_life(generations: int = 6) -> Generator[Shape, None, None]:
    start = parse(PATTERNS['glider'], 1, 1) | parse(PATTERNS['blinker'], 8, 3) | parse(PATTERNS['beacon'], 5, 8)
    for _, (alive, ages) in zip(range(generations), history(frozenset(start))):
        assert len(alive) == len(ages)
        yield picture(ages)
