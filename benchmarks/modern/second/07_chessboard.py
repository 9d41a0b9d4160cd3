"""
a chess board in the middle of a game
"""
from helper import *
from collections import Counter
from enum import StrEnum
from typing import Iterator, NamedTuple

POSITION = 'r1bqk2r/pppp1ppp/2n2n2/2b1p3/2B1P3/2N2N2/PPPP1PPP/R1BQ1RK1'


class Kind(StrEnum):
    PAWN = 'p'
    ROOK = 'r'
    KNIGHT = 'n'
    BISHOP = 'b'
    QUEEN = 'q'
    KING = 'k'


class Piece(NamedTuple):
    kind: Kind
    white: bool
    file: int
    rank: int


def parse_fen(placement: str) -> Iterator[Piece]:
    rows = placement.split('/')
    if len(rows) != 8:
        raise ValueError(f'expected 8 ranks, got {len(rows)}')
    for rank, row in zip(range(7, -1, -1), rows, strict=True):
        file = 0
        for ch in row:
            if ch.isdigit():
                file += int(ch)
                continue
            yield Piece(Kind(ch.lower()), ch.isupper(), file, rank)
            file += 1
        assert file == 8, f'rank {rank + 1} has {file} files'


def ivory(white: bool) -> tuple[float, float, float]:
    return (0.93, 0.89, 0.78) if white else (0.18, 0.12, 0.10)


@register()
def stem(height: float = 0.6, base: float = 0.32, color: tuple = (1, 1, 1)) -> Shape:
    rings = [(base, 0.0, 0.08), (base * 0.8, 0.08, 0.15), (base * 0.45, 0.15, height)]
    return concat_shapes(*(primitive_call('cylinder', {'radius': r, 'p0': (0, a, 0), 'p1': (0, b, 0)}, color=color)
                           for r, a, b in rings))


@register()
def chess_piece(kind: str = 'p', white: bool = True) -> Shape:
    c = ivory(white)
    up = lambda s, y, x=0.0: transform_shape(s, translation_matrix((x, y, 0)))
    match Kind(kind):
        case Kind.PAWN:
            return concat_shapes(library_call('stem', height=0.45, base=0.26, color=c),
                                 up(primitive_call('sphere', {'radius': 0.16}, color=c), 0.5))
        case Kind.ROOK:
            tower = primitive_call('cylinder', {'radius': 0.22, 'p0': (0, 0.55, 0), 'p1': (0, 0.75, 0)}, color=c)
            return concat_shapes(library_call('stem', color=c), tower)
        case Kind.KNIGHT:
            neck = transform_shape(primitive_call('cube', {'scale': (0.18, 0.45, 0.16)}, color=c),
                                   rotation_matrix(0.25, (0, 0, 1), (0, 0, 0)))
            snout = primitive_call('cube', {'scale': (0.34, 0.16, 0.14)}, color=c)
            horse = concat_shapes(library_call('stem', height=0.4, color=c), up(neck, 0.6), up(snout, 0.8, 0.08))
            return horse if white else transform_shape(horse, rotation_matrix(3.14159, (0, 1, 0), (0, 0, 0)))
        case Kind.BISHOP:
            return concat_shapes(library_call('stem', height=0.65, color=c),
                                 up(primitive_call('sphere', {'radius': 0.17}, color=c), 0.75),
                                 up(primitive_call('sphere', {'radius': 0.05}, color=c), 0.95))
        case Kind.QUEEN | Kind.KING as royal:
            body = library_call('stem', height=0.85, base=0.36, color=c)
            crown = primitive_call('cylinder', {'radius': 0.22, 'p0': (0, 0.85, 0), 'p1': (0, 1.0, 0)}, color=c)
            if royal is Kind.QUEEN:
                top = up(primitive_call('sphere', {'radius': 0.1}, color=c), 1.08)
            else:
                top = concat_shapes(up(primitive_call('cube', {'scale': (0.06, 0.26, 0.06)}, color=c), 1.13),
                                    up(primitive_call('cube', {'scale': (0.2, 0.06, 0.06)}, color=c), 1.16))
            return concat_shapes(body, crown, top)


@register()
def board(border: float = 0.4) -> Shape:
    frame = primitive_call('cube', {'scale': (8 + 2 * border, 0.3, 8 + 2 * border)}, color=(0.3, 0.18, 0.1))
    frame = transform_shape(frame, translation_matrix((3.5, -0.2, 3.5)))

    def square(i: int) -> Shape:
        f, r = divmod(i, 8)
        shade = (0.48, 0.3, 0.18) if (f + r) % 2 == 0 else (0.9, 0.82, 0.66)
        return transform_shape(primitive_call('cube', {'scale': (1, 0.1, 1)}, color=shade), translation_matrix((f, -0.05, r)))

    return concat_shapes(frame, loop(64, square))


@register()
def chess_game(fen: str = POSITION) -> Shape:
    pieces = list(parse_fen(fen))
    tally = Counter((p.white, p.kind) for p in pieces)
    assert tally[True, Kind.KING] == tally[False, Kind.KING] == 1
    men = [transform_shape(library_call('chess_piece', kind=str(p.kind), white=p.white), translation_matrix((p.file, 0, 7 - p.rank)))
           for p in pieces]
    captured = 32 - len(pieces)
    aside = loop(captured, lambda i: transform_shape(library_call('chess_piece', kind='p', white=i % 2 == 0),
                                                     translation_matrix((9, -0.35, i * 0.8))))
    return concat_shapes(library_call('board'), *men, aside)
