"""
dunes
"""
from helper import *
from perlin_noise import PerlinNoise

noise = PerlinNoise(octaves=4, seed=1)
N = 10


@register()
def dunes() -> Shape:
    heights = [[noise([i / N, j / N]) for j in range(N)] for i in range(N)]
    return concat_shapes(*[
        transform_shape(primitive_call('cube', color=(.9, .8, .5), shape_kwargs={'scale': (1, 1 + h, 1)}), translation_matrix((i, (1 + h) / 2, j)))
        for i, row in enumerate(heights) for j, h in enumerate(row)
    ])
