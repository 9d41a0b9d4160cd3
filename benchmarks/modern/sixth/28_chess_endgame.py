"""a chess board with an endgame position, given in Forsyth-Edwards notation"""
from helper import *
import re
from enum import Enum
from typing import Callable

FEN = "6k1/5ppp/4p3/2b5/8/1P2R3/P4PPP/6K1"


class Side(Enum):
    WHITE = (0.93, 0.89, 0.8)
    BLACK = (0.16, 0.12, 0.1)

    @classmethod
    def of(cls, letter: str) -> 'Side':
        return cls.WHITE if letter.isupper() else cls.BLACK


def parse_fen(placement: str) -> dict[str, tuple[str, Side]]:
    """Return squares such as 'e4' with the piece upon them."""
    if not re.fullmatch(r"([pnbrqkPNBRQK1-8]+/){7}[pnbrqkPNBRQK1-8]+", placement):
        raise ValueError(f"not a placement: {placement!r}")
    squares = {}
    for rank, row in zip(range(8, 0, -1), placement.split('/')):
        file = 0
        for token in re.findall(r"\d|[a-zA-Z]", row):
            if token.isdigit():
                file += int(token)
            else:
                squares[f"{'abcdefgh'[file]}{rank}"] = (token.lower(), Side.of(token))
                file += 1
    return squares


PIECES: dict[str, Callable[..., list[Shape]]] = {}


def piece(letter: str):
    """Register the drawer of a piece under its letter."""
    def keep(function):
        PIECES[letter] = function
        return function
    return keep


def ball(y, r, color):
    return transform_shape(primitive_call('sphere', shape_kwargs={'radius': r}, color=color), translation_matrix((0, y, 0)))


def turned(color, *profile: tuple[float, float]) -> list[Shape]:
    """Stack cylinders (radius, height)."""
    shapes, y = [], 0.0
    for radius, height in profile:
        shapes.append(primitive_call('cylinder', shape_kwargs={'radius': radius, 'p0': (0, y, 0), 'p1': (0, y + height, 0)}, color=color))
        y += height
    return shapes


@piece('p')
def _pawn(color):
    return [*turned(color, (0.28, 0.08), (0.2, 0.08), (0.12, 0.28), (0.18, 0.04)), ball(0.58, 0.15, color)]


@piece('r')
def _rook(color):
    crown = [transform_shape(primitive_call('cube', shape_kwargs={'scale': (0.1, 0.1, 0.1)}, color=color), translation_matrix((0.17 * x, 0.85, 0.17 * z)))
             for x in (-1, 1) for z in (-1, 1)]
    return turned(color, (0.32, 0.1), (0.24, 0.1), (0.19, 0.45), (0.26, 0.15)) + crown


@piece('b')
def _bishop(color):
    return [*turned(color, (0.31, 0.1), (0.22, 0.1), (0.13, 0.5), (0.2, 0.05)), ball(0.87, 0.17, color), ball(1.06, 0.06, color)]


@piece('k')
def _king(color):
    cross = [transform_shape(primitive_call('cube', shape_kwargs={'scale': s}, color=color), translation_matrix((0, y, 0)))
             for s, y in (((0.07, 0.3, 0.07), 1.35), ((0.22, 0.07, 0.07), 1.38))]
    return turned(color, (0.35, 0.12), (0.26, 0.1), (0.16, 0.7), (0.24, 0.08), (0.2, 0.2)) + cross


@register("a piece by its letter; unknown letters become a simple peg")
def chess_piece(letter: str = 'p', white: bool = True) -> Shape:
    color = (Side.WHITE if white else Side.BLACK).value
    match PIECES.get(letter):
        case None:
            return concat_shapes(*turned(color, (0.3, 0.1), (0.15, 0.9)))
        case drawer:
            return concat_shapes(*drawer(color))


@register("64 squares and a frame")
def board() -> Shape:
    def square(i: int) -> Shape:
        rank, file = i >> 3, i & 7
        color = (0.55, 0.35, 0.2) if (rank ^ file) & 1 == 0 else (0.9, 0.78, 0.6)
        return transform_shape(primitive_call('cube', shape_kwargs={'scale': (1, 0.2, 1)}, color=color), translation_matrix((file, -0.1, -rank)))
    frame = transform_shape(primitive_call('cube', shape_kwargs={'scale': (8.8, 0.18, 8.8)}, color=(0.3, 0.18, 0.1)), translation_matrix((3.5, -0.12, -3.5)))
    return concat_shapes(loop(64, square), frame)


@register()
def chess_endgame() -> Shape:
    placed = []
    for name, (letter, side) in sorted(parse_fen(FEN).items()):
        x, z = ord(name[0]) - ord('a'), 1 - int(name[1:])
        placed.append(transform_shape(library_call('chess_piece', letter=letter, white=side is Side.WHITE), translation_matrix((x, 0, z))))
    return concat_shapes(library_call('board'), *placed)
