import re
from string import ascii_lowercase, digits
from helper import *

"""
a chess position after some moves in a simple notation
"""

FILES = ascii_lowercase[:8]
MOVES = "1. e2-e4 e7-e5 2. Ng1-f3 Nb8-c6 3. Bf1-b5 a7-a6 4. Bb5xc6 d7xc6 5. O-O"
PIECE_HEIGHT = dict(P=0.5, N=0.7, B=0.8, R=0.6, Q=1.0, K=1.1)
MOVE = re.compile(r"([NBRQK]?)([a-h])([1-8])([-x])([a-h])([1-8])")

def square(file: str, rank: str) -> tuple[int, int]:
    return FILES.index(file), digits.index(rank) - 1

def start_position() -> dict[tuple[int, int], str]:
    board = {}
    for i, piece in enumerate("RNBQKBNR"):
        board[i, 0], board[i, 1] = piece, "P"
        board[i, 7], board[i, 6] = piece.lower(), "p"
    return board

def play(board: dict, text: str) -> list[str]:
    captured = []
    for m in MOVE.finditer(text):
        _, f1, r1, how, f2, r2 = m.groups()
        target = square(f2, r2)
        if how == "x":
            captured.append(board[target])
        board[target] = board.pop(square(f1, r1))
    if re.search(r"\bO-O\b", text):
        board[6, 0], board[5, 0] = board.pop((4, 0)), board.pop((7, 0))
    return captured

@register()
def piece(letter: str) -> Shape:
    color = (0.92, 0.88, 0.78) if letter.isupper() else (0.2, 0.15, 0.12)
    h = PIECE_HEIGHT[letter.upper()]
    body = primitive_call('cylinder', color=color, shape_kwargs={'radius': 0.2, 'p0': (0, 0, 0), 'p1': (0, h * 0.7, 0)})
    if letter in "nN":
        head = primitive_call('cube', color=color, shape_kwargs={'scale': (0.2, 0.3, 0.4)})
    else:
        head = primitive_call('sphere', color=color, shape_kwargs={'radius': 0.18})
    return concat_shapes(body, transform_shape(head, translation_matrix((0, h * 0.8, 0))))

@register()
def chessboard() -> Shape:
    squares = [
        transform_shape(primitive_call('cube', color=(0.85, 0.7, 0.5) if (x + z) % 2 else (0.4, 0.25, 0.15), shape_kwargs={'scale': (1, 0.1, 1)}), translation_matrix((x, -0.05, z)))
        for x in range(8) for z in range(8)
    ]
    return concat_shapes(*squares)

@register()
def game() -> Shape:
    board = start_position()
    captured = play(board, MOVES)
    moves = len(re.findall(r"\d+\.", MOVES))
    shapes = [transform_shape(library_call('piece', letter=p), translation_matrix((x, 0, z))) for (x, z), p in sorted(board.items())]
    side = [transform_shape(library_call('piece', letter=p), translation_matrix((8.5, 0, k))) for k, p in enumerate(captured)]
    clock = primitive_call('cube', color=(0.5, 0.3, 0.2), shape_kwargs={'scale': (0.5, 0.2 * moves, 1)})
    return concat_shapes(library_call('chessboard'), *shapes, *side, transform_shape(clock, translation_matrix((9, 0.5, 4))))
