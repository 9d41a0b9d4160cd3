from helper import *

"""
sliding puzzle boards after several moves
"""

Board = List[List[int]]

def solved(n: int) -> Board:
    flat = [*range(1, n * n), 0]
    return [flat[i:i + n] for i in range(0, n * n, n)]

def find(board: Board, value: int) -> Tuple[int, int]:
    for r, row in enumerate(board):
        if value in row:
            return r, row.index(value)
    raise ValueError(value)

def shifted(board: Board, move: str) -> Board:
    new = [row[:] for row in board]
    r, c = find(new, 0)
    dr, dc = {"U": (-1, 0), "D": (1, 0), "L": (0, -1), "R": (0, 1)}[move]
    if 0 <= (r2 := r + dr) < len(new) and 0 <= (c2 := c + dc) < len(new):
        new[r][c], new[r2][c2] = new[r2][c2], new[r][c]
    return new

def rotate_row(board: Board, index: int, k: int) -> Board:
    row = board[index]
    return board[:index] + [row[-k:] + row[:-k]] + board[index + 1:]

def transpose(board: Board) -> Board:
    return [list(column) for column in zip(*board)]

@register()
def tile(value: int, n: int) -> Shape:
    shade = value / (n * n)
    plate = primitive_call('cube', color=(0.9 - 0.5 * shade, 0.6, 0.3 + 0.6 * shade), shape_kwargs={'scale': (0.9, 0.9, 0.2)})
    dots = loop(value % 5, lambda i: transform_shape(primitive_call('sphere', color=(0.1, 0.1, 0.1), shape_kwargs={'radius': 0.06}), translation_matrix((-0.3 + 0.15 * i, 0.2, 0.12))))
    return concat_shapes(plate, dots)

@register()
def board_shape(board: Board) -> Shape:
    n = len(board)
    frame = transform_shape(primitive_call('cube', color=(0.3, 0.2, 0.1), shape_kwargs={'scale': (n + 0.3, n + 0.3, 0.1)}), translation_matrix((0, 0, -0.15)))
    tiles = [
        transform_shape(library_call('tile', value=value, n=n), translation_matrix((c - (n - 1) / 2, (n - 1) / 2 - r, 0)))
        for r, row in enumerate(board) for c, value in enumerate(row) if value
    ]
    return concat_shapes(frame, *tiles)

@register()
def puzzle_wall() -> Shape:
    start = solved(3)
    boards = [start]
    for moves in ("UULL", "LURDDR", "LLUURRDD"):
        board = boards[-1]
        for move in moves:
            board = shifted(board, move)
        boards.append(board)
    boards += [rotate_row(solved(4), 1, 1), transpose(solved(4)), [row[::-1] for row in start[::-1]]]
    assert start == solved(3) and start is not boards[1]
    return loop(len(boards), lambda i: transform_shape(library_call('board_shape', board=boards[i]), translation_matrix((5 * (i % 4), -5 * (i // 4), 0))))
