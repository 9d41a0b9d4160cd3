"""
seaweed that sways by noise
"""
from helper import *
from noise import pnoise1, pnoise3, snoise3


@register()
def seaweed(x0: float = 0.0, segments: int = 10) -> Shape:
    shapes = []
    y = 0.0
    for s in range(segments):
        dx = pnoise1(x0 + s * .23, octaves=2) * .8
        dz = pnoise3(x0, s * .31, 1.7) * .8
        radius = .1 + .05 * abs(snoise3(x0 * .5, s * .17, .4))
        shapes.append(transform_shape(primitive_call('sphere', color=(.1, .5, .3), shape_kwargs={'radius': radius}), translation_matrix((x0 + dx, y, dz))))
        y += .2
    return concat_shapes(*shapes)


@register()
def seabed() -> Shape:
    return concat_shapes(*[library_call('seaweed', x0=i * 1.1) for i in range(6)])
