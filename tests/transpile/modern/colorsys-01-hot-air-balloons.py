import colorsys
import math
from helper import *

"""
a festival of hot air balloons in the colors of the rainbow
"""


def hsv(h: float, s: float = 0.8, v: float = 0.95) -> tuple[float, float, float]:
    return colorsys.hsv_to_rgb(h % 1.0, s, v)


def darker(color, amount: float = 0.3):
    h, l, s = colorsys.rgb_to_hls(*color)
    return colorsys.hls_to_rgb(h, l * (1 - amount), s)


def complement(color):
    h, s, v = colorsys.rgb_to_hsv(*color)
    return hsv(h + 0.5, s, v)


@register()
def balloon(hue: float, gores: int = 8) -> Shape:
    base = hsv(hue)
    stripes = []
    for i in range(gores):
        a = 2 * math.pi * i / gores
        color = base if i % 2 == 0 else darker(base)
        gore = transform_shape(primitive_call('sphere', color=color, shape_kwargs={'radius': 0.5}), translation_matrix((0.35, 0, 0)) @ scale_matrix((1, 1.5, 0.9), (0, 0, 0)))
        stripes.append(transform_shape(gore, rotation_matrix(a, direction=(0, 1, 0), point=(0, 0, 0))))
    basket = transform_shape(primitive_call('cube', color=(0.55, 0.4, 0.2), shape_kwargs={'scale': (0.35, 0.25, 0.35)}), translation_matrix((0, -1.5, 0)))
    ropes = [primitive_call('cylinder', color=complement(base), shape_kwargs={'radius': 0.01, 'p0': (0.15 * sx, -1.4, 0.15 * sz), 'p1': (0.4 * sx, -0.5, 0.4 * sz)}) for sx in (-1, 1) for sz in (-1, 1)]
    return concat_shapes(*stripes, basket, *ropes)


@register()
def festival(n: int = 9) -> Shape:
    golden = (math.sqrt(5) - 1) / 2
    shapes = []
    for i in range(n):
        hue = (i * golden) % 1
        x, z = 2.2 * (i % 3), 2.2 * (i // 3)
        y = 2 + 1.5 * math.sin(2.4 * i)
        size = 0.7 + 0.3 * colorsys.rgb_to_yiq(*hsv(hue))[0]
        pose = translation_matrix((x, y, z)) @ scale_matrix(size, origin=(0, 0, 0))
        shapes.append(transform_shape(library_call('balloon', hue=hue, gores=6 + i % 3), pose))
    field = primitive_call('cube', color=hsv(0.3, 0.6, 0.5), shape_kwargs={'scale': (9, 0.1, 9)})
    return concat_shapes(*shapes, transform_shape(field, translation_matrix((2.2, -1, 2.2))))
