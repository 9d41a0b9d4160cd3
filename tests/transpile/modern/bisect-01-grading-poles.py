from bisect import bisect, bisect_left, bisect_right, insort
from statistics import mean, median, mode, pstdev, stdev, quantiles, multimode
from helper import *

"""
a climbing competition: scores as poles, graded by breakpoints
"""

BREAKPOINTS = [40, 55, 70, 85]
GRADES = "EDCBA"
MEDAL = {"A": (0.95, 0.8, 0.2), "B": (0.75, 0.75, 0.8), "C": (0.7, 0.45, 0.2), "D": (0.4, 0.5, 0.6), "E": (0.3, 0.3, 0.3)}
SCORES = [62, 91, 38, 70, 85, 55, 77, 62, 49, 99, 62, 12]


def grade(score: int) -> str:
    return GRADES[bisect(BREAKPOINTS, score)]


def ranked(scores: list[int]) -> list[int]:
    result: list[int] = []
    for s in scores:
        insort(result, s)
    return result


@register()
def pole(score: int) -> Shape:
    h = score / 25
    g = grade(score)
    mast = primitive_call('cylinder', color=MEDAL[g], shape_kwargs={'radius': 0.12, 'p0': (0, 0, 0), 'p1': (0, h, 0)})
    top = transform_shape(primitive_call('sphere', color=MEDAL[g], shape_kwargs={'radius': 0.18 if g in "AB" else 0.14}), translation_matrix((0, h, 0)))
    return concat_shapes(mast, top)


@register()
def level_line(value: float, width: float, color: tuple = (1, 1, 1)) -> Shape:
    return transform_shape(primitive_call('cube', color=color, shape_kwargs={'scale': (width, 0.03, 0.03)}), translation_matrix((width / 2 - 0.5, value / 25, -0.3)))


@register()
def competition() -> Shape:
    scores = ranked(SCORES)
    n = len(scores)
    shapes = [transform_shape(library_call('pole', score=s), translation_matrix((0.6 * i, 0, 0))) for i, s in enumerate(scores)]
    width = 0.6 * n + 0.4
    for value, color in ((mean(scores), (1, 0, 0)), (median(scores), (0, 1, 0)), (mode(scores), (0, 0, 1)), (pstdev(scores), (1, 1, 0)), (stdev(scores), (0, 1, 1))):
        shapes.append(library_call('level_line', value=value, width=width, color=color))
    shapes += [library_call('level_line', value=q, width=width) for q in quantiles(scores, n=4)]
    low, high = bisect_left(scores, 62), bisect_right(scores, 62)
    bracket = primitive_call('cube', color=(0.2, 0.8, 0.5), shape_kwargs={'scale': (0.6 * (high - low), 0.1, 0.5)})
    shapes.append(transform_shape(bracket, translation_matrix((0.3 * (low + high - 1), 0.05, 0.5))))
    ties = len(multimode("aabbc"))
    shapes.append(transform_shape(primitive_call('cube', color=(0.5, 0.4, 0.3), shape_kwargs={'scale': (width, 0.1, ties)}), translation_matrix((width / 2 - 0.5, -0.05, 0))))
    return concat_shapes(*shapes)
