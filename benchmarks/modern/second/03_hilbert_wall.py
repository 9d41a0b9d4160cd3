"""
a sculpture: a Hilbert curve made of copper pipe mounted on a dark wall
"""
from helper import *
import numpy as np
from itertools import pairwise
from typing import Iterator


def hilbert(order: int) -> Iterator[tuple[int, int]]:
    """Endlessly simple: turtle walk over the rewritten axiom."""
    rules = {'A': '-BF+AFA+FB-', 'B': '+AF-BFB-FA+'}

    def expand(sym: str, depth: int) -> Iterator[str]:
        if depth == 0 or sym not in rules:
            yield sym
            return
        for s in rules[sym]:
            yield from expand(s, depth - 1)

    x = y = 0
    dx, dy = 1, 0
    yield x, y
    for c in expand('A', order):
        match c:
            case 'F':
                x, y = x + dx, y + dy
                yield x, y
            case '+':
                dx, dy = -dy, dx
            case '-':
                dx, dy = dy, -dx
            case _:
                pass


def lerp_color(t: float, a=(0.72, 0.45, 0.2), b=(0.95, 0.75, 0.5)) -> tuple[float, ...]:
    return tuple((1 - t) * np.array(a) + t * np.array(b))


@register()
def elbow(radius: float = 0.1, color: tuple = (0.8, 0.5, 0.3)) -> Shape:
    return primitive_call('sphere', {'radius': radius}, color=color)


@register()
def hilbert_pipe(order: int = 3, cell: float = 0.5, radius: float = 0.08) -> Shape:
    pts = np.array(list(hilbert(order)), dtype=float)
    pts -= (pts.max(axis=0) + pts.min(axis=0)) / 2
    pts *= cell
    pts3 = np.column_stack([pts, np.zeros(len(pts))])
    n = len(pts3) - 1
    shapes: list[Shape] = []
    for i, (a, b) in enumerate(pairwise(pts3)):
        col = lerp_color(i / n)
        shapes += [
            primitive_call('cylinder', {'radius': radius, 'p0': a, 'p1': b}, color=col),
            transform_shape(library_call('elbow', radius=radius * 1.15, color=col), translation_matrix(a)),
        ]
    shapes.append(transform_shape(library_call('elbow', radius=radius * 2), translation_matrix(pts3[-1])))
    return concat_shapes(*shapes)


@register()
def backing_wall(width: float = 5.0, height: float = 5.0, thickness: float = 0.2) -> Shape:
    panel = primitive_call('cube', {'scale': (width, height, thickness)}, color=(0.12, 0.13, 0.16))
    corners = np.array([[sx, sy] for sx in (-1, 1) for sy in (-1, 1)]) * np.array([width, height]) * 0.46
    bolts = [
        transform_shape(
            primitive_call('cylinder', {'radius': 0.06, 'p0': (0, 0, 0), 'p1': (0, 0, 0.08)}, color=(0.7, 0.7, 0.7)),
            translation_matrix((*c, thickness / 2)))
        for c in corners
    ]
    return concat_shapes(panel, *bolts)


@register()
def wall_sculpture() -> Shape:
    pipe = library_call('hilbert_pipe', order=4, cell=0.28, radius=0.05)
    size = compute_shape_sizes(pipe)
    wall = library_call('backing_wall', width=float(size[0]) * 1.25, height=float(size[1]) * 1.25)
    pipe = transform_shape(pipe, translation_matrix((0, 0, 0.35)))
    plinth = primitive_call('cube', {'scale': (size[0] * 1.4, 0.3, 1.0)}, color=(0.3, 0.3, 0.32))
    plinth = transform_shape(plinth, translation_matrix((0, compute_shape_min(wall)[1] - 0.15, 0.2)))
    return concat_shapes(wall, pipe, plinth)
