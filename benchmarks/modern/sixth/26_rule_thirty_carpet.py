"""a woven wall carpet with the pattern of a one-dimensional cellular automaton (rule 30 and rule 90)"""
from helper import *
from enum import Flag, auto
from itertools import islice
from typing import Iterator

WIDTH = 31


class Edge(Flag):
    NONE = 0
    LEFT = auto()
    RIGHT = auto()
    BOTH = LEFT | RIGHT


def generations(rule: int, width: int = WIDTH) -> Iterator[int]:
    """Each row is an integer with a bit for each cell."""
    mask = (1 << width) - 1
    row = 1 << (width // 2)
    while True:
        yield row
        left = ((row << 1) | (row >> (width - 1))) & mask
        right = (row >> 1) | ((row & 1) << (width - 1))
        following = 0
        for cell in range(width):
            neighborhood = ((left >> cell) & 1) | (((row >> cell) & 1) << 1) | (((right >> cell) & 1) << 2)
            following |= ((rule >> neighborhood) & 1) << cell
        row = following


def runs(row: int, width: int = WIDTH) -> list[tuple[int, int]]:
    """Return (start, length) of each block of set bits, so that a thread is one box."""
    found = []
    text = f"{row:0{width}b}"
    start = None
    for i, bit in enumerate(text + '0'):
        if bit == '1' and start is None:
            start = i
        elif bit == '0' and start is not None:
            found.append((start, i - start))
            start = None
    return found


@register("a thread of some knots along x")
def thread(length: int = 1, color: tuple[float, float, float] = (0.7, 0.15, 0.2), knot: float = 0.1) -> Shape:
    body = primitive_call('cube', shape_kwargs={'scale': (length * knot, knot * 0.9, 0.05)}, color=color)
    return transform_shape(body, translation_matrix((length * knot / 2, 0, 0)))


@register("the pattern of a rule, from the top downward")
def weave(rule: int = 30, rows: int = 24, color: tuple[float, float, float] = (0.7, 0.15, 0.2), knot: float = 0.1) -> Shape:
    shapes = []
    for r, row in enumerate(islice(generations(rule), rows)):
        for start, length in runs(row):
            x = (start - WIDTH / 2) * knot
            shapes.append(transform_shape(library_call('thread', length=length, color=color, knot=knot), translation_matrix((x, -r * knot, 0))))
    return concat_shapes(*shapes)


@register("a fringe of thin strings; longer where the last row has a set bit")
def fringe(rule: int = 30, rows: int = 24, knot: float = 0.1) -> Shape:
    last = next(islice(generations(rule), rows - 1, rows))

    def string(i: int) -> Shape:
        length = 0.35 if last >> i & 1 else 0.2
        x = (i + 0.5 - WIDTH / 2) * knot
        return primitive_call('cylinder', shape_kwargs={'radius': 0.015, 'p0': (x, 0, 0), 'p1': (x, -length, 0)}, color=(0.9, 0.85, 0.7))

    return loop(WIDTH, string)


@register("cloth, pattern, fringe and a rod to hang it up")
def carpet(rule: int = 30, rows: int = 24, dye: tuple[float, float, float] = (0.7, 0.15, 0.2), edges: int = Edge.BOTH.value) -> Shape:
    knot = 0.1
    width, height = WIDTH * knot, rows * knot
    cloth = transform_shape(primitive_call('cube', shape_kwargs={'scale': (width + 0.1, height, 0.03)}, color=(0.93, 0.88, 0.76)),
                            translation_matrix((0, -height / 2 + knot / 2, -0.02)))
    wanted = Edge(edges)
    borders = []
    for edge, side in ((Edge.LEFT, -1), (Edge.RIGHT, 1)):
        if edge in wanted:
            border = primitive_call('cube', shape_kwargs={'scale': (0.08, height, 0.06)}, color=dye)
            borders.append(transform_shape(border, translation_matrix((side * (width / 2 + 0.08), -height / 2 + knot / 2, 0))))
    rod = primitive_call('cylinder', shape_kwargs={'radius': 0.05, 'p0': (-width / 2 - 0.3, 0.1, 0), 'p1': (width / 2 + 0.3, 0.1, 0)}, color=(0.4, 0.25, 0.12))
    ends = transform_shape(library_call('fringe', rule=rule, rows=rows), translation_matrix((0, -height + knot / 2, 0)))
    return concat_shapes(cloth, library_call('weave', rule=rule, rows=rows, color=dye), *borders, rod, ends)


@register()
def two_carpets() -> Shape:
    wall = transform_shape(primitive_call('cube', shape_kwargs={'scale': (8.4, 4, 0.1)}, color=(0.85, 0.86, 0.84)), translation_matrix((0, -1.2, -0.15)))
    left = transform_shape(library_call('carpet', rule=30), translation_matrix((-2.0, 0, 0)))
    right = transform_shape(library_call('carpet', rule=90, dye=(0.15, 0.3, 0.55), edges=Edge.RIGHT.value), translation_matrix((2.0, 0, 0)))
    return concat_shapes(wall, left, right)
