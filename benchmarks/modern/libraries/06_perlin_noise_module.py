"""
a terrain of perlin noise
"""
from helper import *
from noise import pnoise2

SIZE = 12
SCALE = 5.0


def height_at(x, z):
    return pnoise2(x / SCALE, z / SCALE, octaves=4, persistence=0.5, lacunarity=2.0, repeatx=1024, repeaty=1024, base=3)


@register()
def column(x: float, z: float, h: float) -> Shape:
    color = (.2, .6, .2) if h > .3 else (.7, .65, .4)
    return transform_shape(primitive_call('cube', color=color, shape_kwargs={'scale': (1, h, 1)}), translation_matrix((x, h / 2, z)))


@register()
def terrain() -> Shape:
    return concat_shapes(*[library_call('column', x=x, z=z, h=1 + 2 * height_at(x, z)) for x in range(SIZE) for z in range(SIZE)])
