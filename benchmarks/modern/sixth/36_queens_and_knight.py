"""two chess puzzles on one table: eight queens, and the tour of a knight as a thread"""
from helper import *
from functools import cache
from typing import Iterator, Optional
import math

Square = tuple[int, int]


def queens(n: int, placed: tuple[int, ...] = ()) -> Iterator[tuple[int, ...]]:
    """Yield the rows of the queens, one for each column, by backtracking."""
    column = len(placed)
    if column == n:
        yield placed
        return
    for row in range(n):
        if all(row != r and abs(row - r) != column - c for c, r in enumerate(placed)):
            yield from queens(n, placed + (row,))


@cache
def jumps(square: Square, n: int) -> tuple[Square, ...]:
    x, z = square
    return tuple((x + a * s, z + b * t) for a, b in ((1, 2), (2, 1)) for s in (1, -1) for t in (1, -1)
                 if 0 <= x + a * s < n and 0 <= z + b * t < n)


def knights_tour(n: int, start: Square = (0, 0)) -> Optional[list[Square]]:
    """Warnsdorff's rule with backtracking: first the square with the fewest ways out."""
    path, visited = [start], {start}

    def free(square: Square) -> list[Square]:
        return [s for s in jumps(square, n) if s not in visited]

    def go() -> bool:
        if len(path) == n * n:
            return True
        for square in sorted(free(path[-1]), key=lambda s: (len(free(s)), s)):
            path.append(square)
            visited.add(square)
            if go():
                return True
            visited.discard(path.pop())
        return False

    return path if go() else None


@register("a board of n by n squares with its corner square at the origin")
def board(n: int = 8) -> Shape:
    def square(i: int) -> Shape:
        x, z = divmod(i, n)
        color = (0.92, 0.85, 0.7) if (x + z) % 2 else (0.4, 0.25, 0.17)
        return transform_shape(primitive_call('cube', shape_kwargs={'scale': (1, 0.15, 1)}, color=color), translation_matrix((x, -0.075, z)))
    return loop(n * n, square)


@register("a queen with a crown of small balls")
def queen(color: tuple[float, float, float] = (0.85, 0.7, 0.3), points: int = 7) -> Shape:
    body = [primitive_call('cylinder', shape_kwargs={'radius': r, 'p0': (0, y, 0), 'p1': (0, y + h, 0)}, color=color)
            for r, y, h in ((0.34, 0.0, 0.12), (0.25, 0.12, 0.12), (0.15, 0.24, 0.6), (0.24, 0.84, 0.15))]
    crown = loop(points, lambda i: transform_shape(
        primitive_call('sphere', shape_kwargs={'radius': 0.06}, color=color),
        translation_matrix((0.2 * math.cos(math.tau * i / points), 1.02, 0.2 * math.sin(math.tau * i / points)))))
    return concat_shapes(*body, crown)


@register("the solution with a given number")
def eight_queens(n: int = 8, number: int = 3) -> Shape:
    for k, rows in enumerate(queens(n)):
        if k == number:
            break
    pieces = [transform_shape(library_call('queen'), translation_matrix((x, 0, z))) for x, z in enumerate(rows)]
    return concat_shapes(library_call('board', n=n), *pieces)


@register("pegs on all squares and a thread from peg to peg; its color changes along the way")
def tour(n: int = 6) -> Shape:
    path = knights_tour(n) or [(0, 0)]
    shapes = [library_call('board', n=n)]
    last = len(path) - 1
    for k, (x, z) in enumerate(path):
        shapes.append(primitive_call('cylinder', shape_kwargs={'radius': 0.06, 'p0': (x, 0, z), 'p1': (x, 0.3, z)}, color=(0.7, 0.7, 0.7)))
        if k < last:
            x2, z2 = path[k + 1]
            shade = k / last
            shapes.append(primitive_call('cylinder', shape_kwargs={'radius': 0.04, 'p0': (x, 0.27, z), 'p1': (x2, 0.27, z2)}, color=(shade, 0.2, 1 - shade)))
    for (x, z), color in ((path[0], (0.1, 0.8, 0.2)), (path[-1], (0.9, 0.1, 0.1))):
        shapes.append(transform_shape(primitive_call('sphere', shape_kwargs={'radius': 0.17}, color=color), translation_matrix((x, 0.4, z))))
    return concat_shapes(*shapes)


@register()
def puzzle_table() -> Shape:
    top = transform_shape(primitive_call('cube', shape_kwargs={'scale': (17, 0.3, 10)}, color=(0.3, 0.35, 0.3)), translation_matrix((6.5, -0.3, 3.5)))
    legs = [primitive_call('cylinder', shape_kwargs={'radius': 0.35, 'p0': (x, -6, z), 'p1': (x, -0.3, z)}, color=(0.25, 0.2, 0.15)) for x in (-1, 14) for z in (-0.5, 7.5)]
    return concat_shapes(top, *legs, library_call('eight_queens'), transform_shape(library_call('tour'), translation_matrix((9, 0, 1))))
