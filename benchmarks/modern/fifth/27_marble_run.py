"""a wooden marble run read from an ASCII plan, with marbles rolling through it"""
from helper import *
from dataclasses import dataclass
from enum import Enum
from typing import Iterator
import math

PLAN = r"""
S........
>>>v.....
...>>v...
.v<<<<...
.>>>>>>v.
...v<<<<.
...>>>>>G
"""


class Piece(str, Enum):
    START = 'S'
    RIGHT = '>'
    LEFT = '<'
    DROP = 'v'
    GOAL = 'G'
    EMPTY = '.'

    @property
    def step(self) -> tuple[int, int]:
        return {'S': (1, 0), '>': (0, 1), '<': (0, -1), 'v': (1, 0)}.get(self.value, (0, 0))


@dataclass(frozen=True)
class Cell:
    row: int
    col: int
    piece: Piece

    def center(self, size: float, rows: int) -> tuple[float, float, float]:
        return self.col * size, (rows - 1 - self.row) * size, 0.0


class Board:
    def __init__(self, plan: str):
        self.grid = [[Piece(ch) for ch in line] for line in plan.strip().splitlines()]

    def __getitem__(self, key: tuple[int, int]) -> Piece:
        r, c = key
        if not (0 <= r < self.rows and 0 <= c < self.cols):
            raise IndexError(f'{key} is outside')
        return self.grid[r][c]

    def __iter__(self) -> Iterator[Cell]:
        for r, line in enumerate(self.grid):
            for c, piece in enumerate(line):
                if piece is not Piece.EMPTY:
                    yield Cell(r, c, piece)

    @property
    def rows(self) -> int:
        return len(self.grid)

    @property
    def cols(self) -> int:
        return max(map(len, self.grid))

    def roll(self, limit: int = 100) -> list[Cell]:
        """The cells a marble visits from the start until the goal or the edge."""
        here = next(cell for cell in self if cell.piece is Piece.START)
        visited = [here]
        for _ in range(limit):
            dr, dc = here.piece.step
            if (dr, dc) == (0, 0):
                break
            try:
                here = Cell(here.row + dr, here.col + dc, self[here.row + dr, here.col + dc])
            except IndexError:
                break
            visited.append(here)
            if here.piece is Piece.EMPTY:
                break
        return visited


BOARD = Board(PLAN)
BEECH = (0.85, 0.68, 0.45)


def cube(scale, at, color=BEECH):
    return transform_shape(primitive_call('cube', shape_kwargs={'scale': scale}, color=color), translation_matrix(at))


@register()
def channel(slope: float = 0.12, size: float = 0.5, depth: float = 0.3) -> Shape:
    floor = cube((size * 1.02, 0.04, depth), (0, 0, 0))
    rims = [cube((size * 1.02, 0.1, 0.03), (0, 0.05, s * depth / 2), (0.7, 0.5, 0.3)) for s in (-1, 1)]
    return transform_shape(concat_shapes(floor, *rims), rotation_matrix(slope, (0, 0, 1), (0, 0, 0)))


@register()
def chute(size: float = 0.5, rings: int = 5) -> Shape:
    def ring(k):
        y = size * (0.5 - k / rings)
        return concat_shapes(*[primitive_call('cylinder', shape_kwargs={'radius': 0.015, 'p0': (0.14 * math.cos(a), y, 0.14 * math.sin(a)), 'p1': (0.14 * math.cos(a + 1.05), y, 0.14 * math.sin(a + 1.05))}, color=(0.8, 0.25, 0.2))
                               for a in (i * math.pi / 3 for i in range(6))])
    return loop(rings, ring)


@register()
def piece_shape(kind: str = '>', size: float = 0.5) -> Shape:
    match Piece(kind):
        case Piece.RIGHT:
            return library_call('channel', slope=-0.12, size=size)
        case Piece.LEFT:
            return library_call('channel', slope=0.12, size=size)
        case Piece.DROP:
            return library_call('chute', size=size)
        case Piece.START:
            funnel = loop(5, lambda i: primitive_call('cylinder', shape_kwargs={'radius': 0.14 + 0.03 * i, 'p0': (0, 0.08 * i, 0), 'p1': (0, 0.08 * (i + 1), 0)}, color=(0.2, 0.5, 0.8)))
            return funnel
        case Piece.GOAL:
            return concat_shapes(cube((size, 0.04, size), (0, -0.1, 0), (0.2, 0.6, 0.3)), *[cube((0.03, 0.2, size), (s * size / 2, 0, 0), (0.2, 0.6, 0.3)) for s in (-1, 1)], *[cube((size, 0.2, 0.03), (0, 0, s * size / 2), (0.2, 0.6, 0.3)) for s in (-1, 1)])
        case _:
            return concat_shapes()


@register()
def marbles(every: int = 3, radius: float = 0.09, size: float = 0.5) -> Shape:
    palette = [(0.9, 0.2, 0.3), (0.2, 0.6, 0.9), (0.95, 0.85, 0.2), (0.4, 0.8, 0.4), (0.7, 0.3, 0.8)]
    path = BOARD.roll()
    out = []
    for n, cell in enumerate(path[::every]):
        x, y, z = cell.center(size, BOARD.rows)
        marble = primitive_call('sphere', shape_kwargs={'radius': radius}, color=palette[n % len(palette)])
        out.append(transform_shape(marble, translation_matrix((x, y + radius + 0.03, z))))
    return concat_shapes(*out)


@register()
def marble_run(size: float = 0.5) -> Shape:
    pieces = [transform_shape(library_call('piece_shape', kind=cell.piece.value, size=size), translation_matrix(cell.center(size, BOARD.rows))) for cell in BOARD]
    w, h = BOARD.cols * size, BOARD.rows * size
    back = cube((w + 0.3, h + 0.3, 0.06), ((w - size) / 2, (h - size) / 2, -0.22), (0.95, 0.9, 0.8))
    pegs = [primitive_call('cylinder', shape_kwargs={'radius': 0.025, 'p0': (x, y, -0.2), 'p1': (x, y, -0.1)}, color=(0.6, 0.4, 0.2)) for x, y, _ in (c.center(size, BOARD.rows) for c in BOARD)]
    feet = [cube((0.12, 0.1, 1.0), (x, -size / 2 - 0.2, 0), (0.6, 0.42, 0.25)) for x in (0, w - size)]
    return concat_shapes(back, *pegs, *feet, *pieces, library_call('marbles'))
