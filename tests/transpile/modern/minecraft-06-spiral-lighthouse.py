from contextlib import contextmanager
from itertools import cycle
import math
from helper import *

"""
a Minecraft lighthouse with a spiral stair inside
"""

class World:
    """Collects blocks relative to a moving cursor."""

    def __init__(self):
        self.blocks = []
        self.cursor = (0, 0, 0)

    @contextmanager
    def at(self, dx=0, dy=0, dz=0):
        before = self.cursor
        self.cursor = tuple(a + b for a, b in zip(before, (dx, dy, dz)))
        try:
            yield self
        finally:
            self.cursor = before

    def put(self, name, size=(1, 1, 1), *, hollow=False, **state):
        block = primitive_call('set_cuboid', block_type=name if ':' in name else f'minecraft:{name}', block_kwargs=state, scale=size, fill=not hollow)
        self.blocks.append(transform_shape(block, translation_matrix(self.cursor)))
        return self

    def clear(self, size):
        self.blocks.append(transform_shape(primitive_call('delete_blocks', scale=size), translation_matrix(self.cursor)))
        return self

    def __iadd__(self, shape):
        self.blocks.append(transform_shape(shape, translation_matrix(self.cursor)))
        return self

def disc(radius):
    """Rows (x, z, length) of a filled circle."""
    for z in range(-radius, radius + 1):
        half = math.floor(math.sqrt((radius + 0.3) ** 2 - z * z))
        yield -half, z, 2 * half + 1

@register("ring layer")
def layer(radius: int, material: str) -> Shape:
    w = World()
    for x, z, n in disc(radius):
        with w.at(x, 0, z):
            w.put(material, (n, 1, 1))
    for x, z, n in disc(radius - 1):
        with w.at(x, 0, z):
            w.clear((n, 1, 1))
    return concat_shapes(*w.blocks)

@register("lighthouse")
def lighthouse(height: int = 12) -> Shape:
    w = World()
    with w.at(-8, -1, -8):
        w.put("sand", (17, 1, 17))
    bands = cycle(["red_concrete"] * 3 + ["white_concrete"] * 3)
    facings = cycle("north east south west".split())
    for y, material in zip(range(height), bands):
        radius = 4 if y < 6 else 3
        with w.at(dy=y):
            w += library_call('layer', radius=radius, material=material)
            a = y * math.pi / 4
            with w.at(round(2 * math.cos(a)), 0, round(2 * math.sin(a))):
                w.put("stone_brick_stairs", facing=next(facings), half="bottom")
    with w.at(0, height, 0):
        for x, z, n in disc(4):
            with w.at(x, 0, z):
                w.put("smooth_stone", (n, 1, 1))
        with w.at(-1, 1, -1):
            w.put("glass", (3, 3, 3), hollow=True)
            with w.at(1, 1, 1):
                w.put("sea_lantern")
            with w.at(0, 3, 0):
                w.put("dark_oak_slab", (3, 1, 3), type="bottom")
    with w.at(4, 0, 0):
        w.clear((1, 2, 1))
    return concat_shapes(*w.blocks)
