"""
a chess position read from FEN notation
"""
from helper import *
import math

FEN = 'r1bqkb1r/pppp1ppp/2n2n2/4p2Q/2B1P3/8/PPPP1PPP/RNB1K1NR w KQkq - 4 4'
HEIGHTS = dict(p=0.6, r=0.8, n=0.9, b=1.0, q=1.3, k=1.4)


class FenError(ValueError):
    """Raised when a rank does not have eight squares."""


def parse(fen: str) -> dict[tuple[int, int], str]:
    board: dict[tuple[int, int], str] = {}
    for rank, row in enumerate(fen.split()[0].split('/')):
        file = 0
        for ch in row:
            if ch.isdigit():
                file += int(ch)
            else:
                board[file, 7 - rank] = ch
                file += 1
        if file != 8:
            raise FenError(f'rank {8 - rank} has {file} squares')
    return board


def lathe(profile, color):
    return concat_shapes(*[
        primitive_call('cylinder', color=color, shape_kwargs={'radius': r, 'p0': (0, y0, 0), 'p1': (0, y1, 0)})
        for (y0, r), (y1, _) in zip(profile, profile[1:])
    ])


@register()
def piece(kind: str, white: bool) -> Shape:
    color = (0.92, 0.88, 0.78) if white else (0.15, 0.12, 0.1)
    h = HEIGHTS[kind]
    stem = lathe([(0, 0.35), (0.1, 0.28), (0.2, 0.16), (h * 0.75, 0.16), (h * 0.8, 0)], color)
    match kind:
        case 'p':
            head = [primitive_call('sphere', color=color, shape_kwargs={'radius': 0.2})]
        case 'r':
            head = [primitive_call('cylinder', color=color, shape_kwargs={'radius': 0.25, 'p0': (0, -0.1, 0), 'p1': (0, 0.15, 0)})]
        case 'n':
            head = [transform_shape(primitive_call('cube', color=color, shape_kwargs={'scale': (0.2, 0.4, 0.35)}), rotation_matrix(-0.4, (1, 0, 0), (0, 0, 0)))]
        case 'b':
            head = [primitive_call('sphere', color=color, shape_kwargs={'radius': 0.18}), transform_shape(primitive_call('sphere', color=color, shape_kwargs={'radius': 0.08}), translation_matrix((0, 0.2, 0)))]
        case 'q' | 'k':
            crown = [transform_shape(primitive_call('sphere', color=color, shape_kwargs={'radius': 0.06}), translation_matrix((0.18 * math.cos(a), 0.1, 0.18 * math.sin(a)))) for a in [i * math.tau / 6 for i in range(6)]]
            head = [primitive_call('sphere', color=color, shape_kwargs={'radius': 0.22}), *crown]
            if kind == 'k':
                head += [transform_shape(primitive_call('cube', color=color, shape_kwargs={'scale': s}), translation_matrix((0, 0.35, 0))) for s in ((0.06, 0.3, 0.06), (0.2, 0.06, 0.06))]
        case other:
            raise ValueError(other)
    return concat_shapes(stem, transform_shape(concat_shapes(*head), translation_matrix((0, h * 0.85, 0))))


@register()
def board() -> Shape:
    return concat_shapes(*[
        transform_shape(primitive_call('cube', color=(0.85, 0.75, 0.6) if (x + z) % 2 else (0.4, 0.25, 0.15), shape_kwargs={'scale': (1, 0.2, 1)}), translation_matrix((x, -0.1, z)))
        for x in range(8) for z in range(8)
    ])


@register()
def position() -> Shape:
    try:
        squares = parse(FEN)
    except FenError as error:
        print(f'cannot read the position: {error}')
        squares = {}
    men = [transform_shape(library_call('piece', kind=ch.lower(), white=ch.isupper()), translation_matrix((x, 0, z))) for (x, z), ch in squares.items()]
    return concat_shapes(library_call('board'), *men)
