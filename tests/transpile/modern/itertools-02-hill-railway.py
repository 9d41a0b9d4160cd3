from itertools import accumulate, pairwise, groupby, zip_longest
import operator
from helper import *

"""
a mountain railway along an elevation profile
"""

STEPS = [0.0, 0.3, 0.5, 0.5, 0.2, -0.1, -0.4, -0.4, 0.1, 0.6, 0.6, -0.3, -0.8, 0.0, 0.0]


def kind(slope: float) -> str:
    if slope > 0.05:
        return "up"
    return "down" if slope < -0.05 else "flat"


RAIL = {"up": (0.8, 0.3, 0.2), "down": (0.2, 0.4, 0.8), "flat": (0.4, 0.4, 0.4)}


@register()
def segment(a: tuple, b: tuple, color: tuple) -> Shape:
    rails = [primitive_call('cylinder', color=color, shape_kwargs={'radius': 0.04, 'p0': (*a, z), 'p1': (*b, z)}) for z in (-0.2, 0.2)]
    middle = [(p + q) / 2 for p, q in zip(a, b)]
    sleeper = transform_shape(primitive_call('cube', color=(0.35, 0.22, 0.12), shape_kwargs={'scale': (0.15, 0.06, 0.7)}), translation_matrix((*middle, 0)))
    return concat_shapes(*rails, sleeper)


@register()
def station(size: int) -> Shape:
    return concat_shapes(
        transform_shape(primitive_call('cube', color=(0.8, 0.7, 0.5), shape_kwargs={'scale': (0.3 * size, 0.6, 0.5)}), translation_matrix((0, 0.3, 0))),
        transform_shape(primitive_call('cube', color=(0.5, 0.2, 0.1), shape_kwargs={'scale': (0.35 * size, 0.1, 0.7)}), translation_matrix((0, 0.65, 0))))


@register()
def railway() -> Shape:
    heights = list(accumulate(STEPS))
    points = [(0.8 * i, h) for i, h in enumerate(heights)]
    shapes = [library_call('segment', a=p, b=q, color=RAIL[kind(q[1] - p[1])]) for p, q in pairwise(points)]
    # one station in the middle of each run of equal slope
    index = 0
    for name, run in groupby(STEPS, key=kind):
        run = list(run)
        middle = index + len(run) // 2
        x, y = points[middle]
        z = 1.0 if name == "flat" else -1.0
        shapes.append(transform_shape(library_call('station', size=len(run)), translation_matrix((x, y, z))))
        index += len(run)
    peaks = accumulate(heights, max)
    doubled = accumulate([1, 2, 3, 4], operator.mul, initial=0.1)
    for i, (peak, extra) in enumerate(zip_longest(peaks, doubled, fillvalue=0.5)):
        pole = primitive_call('cylinder', color=(0.5, 0.5, 0.5), shape_kwargs={'radius': 0.03, 'p0': (0.8 * i, -1, 0), 'p1': (0.8 * i, heights[i] - 0.05, 0)})
        marker = transform_shape(primitive_call('sphere', color=(0.9, 0.8, 0.3), shape_kwargs={'radius': 0.05 + 0.05 * min(extra, 2)}), translation_matrix((0.8 * i, peak + 1, 0)))
        shapes += [pole, marker]
    return concat_shapes(*shapes)
