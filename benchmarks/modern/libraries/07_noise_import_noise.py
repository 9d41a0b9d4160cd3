"""
islands where noise is high
"""
from helper import *
import noise
import numpy as np


def generate(width: int, depth: int, scale: float = 7.0, octaves: int = 3, seed: int = 42):
    world = np.zeros((width, depth))
    for i in range(width):
        for j in range(depth):
            world[i][j] = noise.snoise2(i / scale, j / scale, octaves=octaves, persistence=.5, lacunarity=2.0, base=seed)
    return (world - world.min()) / (world.max() - world.min())


@register()
def islands() -> Shape:
    field = generate(10, 10)
    sea = transform_shape(primitive_call('cube', color=(.1, .3, .7), shape_kwargs={'scale': (10, .2, 10)}), translation_matrix((4.5, 0, 4.5)))
    shapes = [sea]
    for (i, j), v in np.ndenumerate(field):
        if v > .55:
            shapes.append(transform_shape(primitive_call('cube', color=(.2, .5 + .3 * v, .2), shape_kwargs={'scale': (1, v, 1)}), translation_matrix((i, v / 2, j))))
    return concat_shapes(*shapes)
