"""a game of Connect Four in which red has just won"""
from helper import *
import math
from enum import IntEnum


class Cell(IntEnum):
    EMPTY = 0
    RED = 1
    YELLOW = 2


COLORS = {Cell.RED: (0.85, 0.1, 0.12), Cell.YELLOW: (0.98, 0.82, 0.1)}
COLUMNS, ROWS = 7, 6
MOVES = [3, 3, 2, 4, 4, 2, 2, 5, 1, 3, 5, 5, 0, 5, 3, 4, 6, 2]
BLUE = (0.1, 0.25, 0.7)
PITCH = 0.5


class Board:
    def __init__(self, columns: int = COLUMNS, rows: int = ROWS):
        self.columns = columns
        self.rows = rows
        self.cells = [[Cell.EMPTY] * columns for _ in range(rows)]

    def drop(self, column: int, who: Cell) -> bool:
        for row in range(self.rows):
            if self.cells[row][column] == Cell.EMPTY:
                self.cells[row][column] = who
                return True
        return False

    def winning_line(self):
        """The cells of the first line of four, or an empty list."""
        for row in range(self.rows):
            for col in range(self.columns):
                who = self.cells[row][col]
                if who == Cell.EMPTY:
                    continue
                for dr, dc in ((0, 1), (1, 0), (1, 1), (1, -1)):
                    line = [(row + dr * k, col + dc * k) for k in range(4)]
                    if all(0 <= r < self.rows and 0 <= c < self.columns and self.cells[r][c] == who for r, c in line):
                        return line
        return []


def play(moves: list[int]) -> Board:
    board = Board()
    who = Cell.RED
    for column in moves:
        if board.drop(column, who):
            who = Cell.YELLOW if who == Cell.RED else Cell.RED
        if board.winning_line():
            break
    return board


@register("a round playing piece in the xy plane")
def disc(color: tuple[float, float, float] = (0.85, 0.1, 0.12), radius: float = 0.2) -> Shape:
    coin = primitive_call('cylinder', shape_kwargs={'radius': radius, 'p0': (0, 0, -0.05), 'p1': (0, 0, 0.05)}, color=color)
    shade = tuple(0.8 * c for c in color)
    rim = primitive_call('cylinder', shape_kwargs={'radius': radius * 0.7, 'p0': (0, 0, -0.055), 'p1': (0, 0, 0.055)}, color=shade)
    return concat_shapes(coin, rim)


@register("the blue grid, made of bars between the columns and rows")
def rack(columns: int = COLUMNS, rows: int = ROWS) -> Shape:
    width, height = columns * PITCH, rows * PITCH
    bars = []
    for c in range(columns + 1):
        bar = primitive_call('cube', shape_kwargs={'scale': (0.07, height, 0.16)}, color=BLUE)
        bars.append(transform_shape(bar, translation_matrix((c * PITCH - width / 2, height / 2, 0))))
    for r in range(rows + 1):
        bar = primitive_call('cube', shape_kwargs={'scale': (width, 0.07, 0.16)}, color=BLUE)
        bars.append(transform_shape(bar, translation_matrix((0, r * PITCH, 0))))
    feet = [transform_shape(primitive_call('cube', shape_kwargs={'scale': (0.14, 0.3, 1.1)}, color=BLUE),
                            translation_matrix((s * (width / 2 + 0.07), -0.1, 0))) for s in (-1, 1)]
    return concat_shapes(*bars, *feet)


def position(row: int, column: int):
    return ((column + 0.5 - COLUMNS / 2) * PITCH, (row + 0.5) * PITCH, 0)


@register("the pieces of the game; those of the winning line carry a white dot")
def pieces() -> Shape:
    board = play(MOVES)
    winners = board.winning_line()
    shapes = []
    for row, cells in enumerate(board.cells):
        for column, cell in enumerate(cells):
            if cell is Cell.EMPTY:
                continue
            shapes.append(transform_shape(library_call('disc', color=COLORS[cell]), translation_matrix(position(row, column))))
            if (row, column) in winners:
                dot = primitive_call('sphere', shape_kwargs={'radius': 0.07}, color=(1, 1, 1))
                shapes.append(transform_shape(dot, translation_matrix((*position(row, column)[:2], 0.06))))
    return concat_shapes(*shapes)


@register("the board on a table with spare pieces")
def connect_four(spare: int = 6) -> Shape:
    table = transform_shape(primitive_call('cube', shape_kwargs={'scale': (6, 0.1, 3)}, color=(0.6, 0.42, 0.26)), translation_matrix((0, -0.3, 0)))

    def lying(i: int) -> Shape:
        flat = transform_shape(library_call('disc', color=COLORS[Cell(1 + i % 2)]), rotation_matrix(math.pi / 2, (1, 0, 0), (0, 0, 0)))
        return transform_shape(flat, translation_matrix((2.4, -0.2 + 0.1 * (i // 2), -0.4 + 0.8 * (i % 2))))

    return concat_shapes(table, library_call('rack'), library_call('pieces'), loop(spare, lying))
