"""a solution of the eight queens puzzle on a board, with attack lines of one queen"""
from helper import *
from typing import Iterator

N = 8


def solve(n: int, placed: tuple[int, ...] = ()) -> Iterator[tuple[int, ...]]:
    row = len(placed)
    if row == n:
        yield placed
        return
    for col in range(n):
        if all(col != c and abs(col - c) != row - r for r, c in enumerate(placed)):
            yield from solve(n, placed + (col,))


SOLUTION = next(s for s in solve(N) if s[0] not in (0, N - 1))


def at(row: int, col: int, y: float = 0.0) -> tuple[float, float, float]:
    return (col - (N - 1) / 2, y, row - (N - 1) / 2)


@register()
def queen(color=(0.1, 0.1, 0.12)) -> Shape:
    profile = [(0.35, 0.1), (0.25, 0.1), (0.15, 0.5), (0.2, 0.08), (0.26, 0.12)]
    parts, y = [], 0.0
    for r, h in profile:
        parts.append(primitive_call('cylinder', shape_kwargs={'radius': r, 'p0': (0, y, 0), 'p1': (0, y + h, 0)}, color=color))
        y += h
    ball = transform_shape(primitive_call('sphere', shape_kwargs={'radius': 0.1}, color=(0.9, 0.75, 0.2)), translation_matrix((0, y + 0.05, 0)))
    return concat_shapes(*parts, ball)


@register()
def squares() -> Shape:
    attacked = {(r, c) for r in range(N) for c in range(N)
                if r == 0 or c == SOLUTION[0] or r == abs(c - SOLUTION[0])}

    def tile(k: int) -> Shape:
        r, c = divmod(k, N)
        base = 0.85 if (r + c) % 2 == 0 else 0.35
        color = (base, base * 0.6, base * 0.6) if (r, c) in attacked else (base, base * 0.93, base * 0.8)
        return transform_shape(primitive_call('cube', shape_kwargs={'scale': (1, 0.1, 1)}, color=color), translation_matrix(at(r, c, -0.05)))

    return loop(N * N, tile)


@register()
def eight_queens() -> Shape:
    queens = loop(N, lambda r: transform_shape(library_call('queen'), translation_matrix(at(r, SOLUTION[r]))))
    return concat_shapes(library_call('squares'), queens)
