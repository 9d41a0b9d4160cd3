"""
trees sorted into classes of height
"""
from helper import *
import bisect
import heapq
import textwrap

HEIGHTS = [3.2, 1.1, 4.8, 2.5, .7, 3.9, 2.2]
LIMITS = [1, 2, 3, 4]
TEXT = textwrap.dedent("""
    oak pine
    elm
""").strip()


@register()
def trees() -> Shape:
    heap = list(HEIGHTS)
    heapq.heapify(heap)
    shapes = []
    i = 0
    while heap:
        h = heapq.heappop(heap)
        kind = bisect.bisect_left(LIMITS, h)
        shapes.append(transform_shape(primitive_call('cube', color=(.1, .2 + .15 * kind, .1), shape_kwargs={'scale': (.5, h, .5)}), translation_matrix((i, h / 2, kind))))
        i += 1
    for k, h in enumerate(heapq.nlargest(2, HEIGHTS)):
        shapes.append(transform_shape(primitive_call('sphere', color=(1, 1, 0), shape_kwargs={'radius': .3}), translation_matrix((k, h + 1, 0))))
    for r, line in enumerate(textwrap.wrap(TEXT.replace('\n', ' '), 8)):
        shapes.append(transform_shape(primitive_call('cube', color=(1, 1, 1), shape_kwargs={'scale': (len(line) * .1, .1, .1)}), translation_matrix((0, -r * .2 - 1, 0))))
    return concat_shapes(*shapes)
