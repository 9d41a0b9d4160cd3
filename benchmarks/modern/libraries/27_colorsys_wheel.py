"""
a wheel of colours
"""
from helper import *
import colorsys
import math


@register()
def swatch(hue: float, lightness: float = .5) -> Shape:
    return primitive_call('sphere', color=colorsys.hls_to_rgb(hue, lightness, .9), shape_kwargs={'radius': .3})


@register()
def wheel(n: int = 12) -> Shape:
    shapes = []
    for ring in range(1, 4):
        for i in range(n):
            a = 2 * math.pi * i / n
            r, g, b = colorsys.hsv_to_rgb(i / n, ring / 3, 1)
            h, s, v = colorsys.rgb_to_hsv(r, g, b)
            shapes.append(transform_shape(library_call('swatch', hue=h, lightness=.3 + .15 * ring), translation_matrix((ring * math.cos(a), s * .2, ring * math.sin(a)))))
    return concat_shapes(*shapes)
