"""a glossy pipe following a 3D Hilbert curve, colored along a rainbow"""
from helper import *
import colorsys
import itertools
import numpy as np


def hilbert3(s, center, axes):
    """Classic recursive generator of the 3D Hilbert curve points."""
    x, y, z = axes
    if s == 0:
        yield np.array(center, dtype=float)
        return
    h = 2 ** (s - 1) / 2
    sub = [
        ((-1, -1, -1), (y, z, x)),
        ((-1, -1, 1), (z, x, y)),
        ((-1, 1, 1), (z, x, y)),
        ((-1, 1, -1), (-x, -y, z)),
        ((1, 1, -1), (-x, -y, z)),
        ((1, 1, 1), (-z, x, -y)),
        ((1, -1, 1), (-z, x, -y)),
        ((1, -1, -1), (y, -z, -x)),
    ]
    for signs, ax in sub:
        c = center + h * (signs[0] * x + signs[1] * y + signs[2] * z)
        yield from hilbert3(s - 1, c, ax)


@register()
def pipe_segment(p0, p1, radius: float = 0.15, t: float = 0.0) -> Shape:
    color = colorsys.hsv_to_rgb(t, 0.8, 0.95)
    tube = primitive_call('cylinder', shape_kwargs={'radius': radius, 'p0': tuple(p0), 'p1': tuple(p1)}, color=color)
    joint = transform_shape(primitive_call('sphere', shape_kwargs={'radius': radius}, color=color), translation_matrix(p1))
    return concat_shapes(tube, joint)


@register()
def hilbert_pipe(order: int = 3, radius: float = 0.15) -> Shape:
    pts = list(hilbert3(order, np.zeros(3), np.eye(3)))
    assert len(pts) == 8 ** order, f"expected {8 ** order} points, got {len(pts)}"
    n = len(pts) - 1
    segs = (library_call('pipe_segment', p0=a, p1=b, radius=radius, t=i / n)
            for i, (a, b) in enumerate(itertools.pairwise(pts)))
    return concat_shapes(*segs)


@register()
def display() -> Shape:
    pipe = library_call('hilbert_pipe', order=3)
    lo = compute_shape_min(pipe)
    base = primitive_call('cube', shape_kwargs={'scale': (9, 0.3, 9)}, color=(0.15, 0.15, 0.18))
    c = compute_shape_center(pipe)
    return concat_shapes(pipe, transform_shape(base, translation_matrix((c[0], lo[1] - 0.3, c[2]))))
