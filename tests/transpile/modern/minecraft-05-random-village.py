from __future__ import annotations
from abc import ABC, abstractmethod
import numpy as np
from helper import *

"""
a small Minecraft village with houses of different styles
"""


def cuboid(name, size, at=(0, 0, 0), fill=True, **state) -> Shape:
    block = primitive_call('set_cuboid', block_type='minecraft:' + name, block_kwargs=state, scale=size, fill=fill)
    return transform_shape(block, translation_matrix(at))


class House(ABC):
    wall = "oak_planks"

    def __init__(self, width: int, depth: int, height: int = 4):
        self.width, self.depth, self.height = int(width), int(depth), int(height)

    @abstractmethod
    def roof(self) -> list: ...

    def windows(self) -> list:
        count = int(np.random.randint(1, 3))
        xs = np.random.choice(np.arange(1, self.width - 1), size=count, replace=False)
        return [cuboid("glass", (1, 1, 1), (int(x), 2, 0)) for x in np.sort(xs)]

    def build(self) -> Shape:
        shell = cuboid(self.wall, (self.width, self.height, self.depth), fill=False)
        door = [cuboid("spruce_door", (1, 1, 1), (self.width // 2, y, self.depth - 1), half=half, facing="north") for y, half in ((0, "lower"), (1, "upper"))]
        return concat_shapes(shell, *self.windows(), *door, *self.roof())


class Flat(House):
    wall = "sandstone"

    def roof(self):
        return [cuboid("smooth_sandstone", (self.width, 1, self.depth), (0, self.height, 0))]


class Gabled(House):
    def roof(self):
        steps = (self.width + 1) // 2
        return [cuboid("spruce_planks", (self.width - 2 * i, 1, self.depth + 2), (i, self.height + i, -1)) for i in range(steps) if self.width - 2 * i > 0]


class Towered(Gabled):
    wall = "cobblestone"

    def roof(self):
        extra = int(np.random.poisson(2)) + 3
        return super().roof() + [cuboid("stone_bricks", (3, self.height + extra, 3), (self.width, 0, 0), fill=False), cuboid("blue_terracotta", (5, 1, 5), (self.width - 1, self.height + extra, -1))]


@register("house")
def house(kind: str, width: int, depth: int) -> Shape:
    cls = {c.__name__: c for c in (Flat, Gabled, Towered)}[kind]
    return cls(width, depth).build()


@register("lamp post")
def lamp_post() -> Shape:
    return concat_shapes(cuboid("oak_fence", (1, 3, 1)), cuboid("lantern", (1, 1, 1), (0, 3, 0), hanging="false"))


@register("village")
def village(n: int = 6) -> Shape:
    shapes = [cuboid("grass_block", (50, 1, 34), (-2, -1, -2)), cuboid("dirt_path", (46, 1, 3), (0, -1, 14))]
    kinds = np.random.choice(["Flat", "Gabled", "Towered"], n, p=[0.3, 0.4, 0.3])
    for i, kind in enumerate(kinds):
        width, depth = np.random.randint(5, 9, size=2)
        side, column = divmod(i, 3)
        shapes.append(transform_shape(library_call('house', kind=str(kind), width=width, depth=depth), translation_matrix((15 * column, 0, 20 * side))))
        shapes.append(transform_shape(library_call('lamp post'), translation_matrix((15 * column + 12, 0, 13))))
    return concat_shapes(*shapes)
