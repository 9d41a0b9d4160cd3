import numpy as np
from helper import *

"""
a terraced hill with a pond in Minecraft, made from a numpy height map
"""

LAYERS = ((0, "minecraft:stone"), (3, "minecraft:dirt"), (5, "minecraft:grass_block"), (8, "minecraft:snow_block"))


def height_map(n: int) -> np.ndarray:
    z, x = np.mgrid[:n, :n] - (n - 1) / 2
    mound = 9 * np.exp(-(x ** 2 + z ** 2) / (n * 1.5))
    ripple = np.sin(x * 0.9) * np.cos(z * 0.7)
    return np.clip(np.rint(mound + ripple + 1), 1, 10).astype(int)


def surface(height: int) -> str:
    index = np.searchsorted([level for level, _ in LAYERS], height, side="right") - 1
    return LAYERS[index][1]


def cuboid(kind: str, scale, at=(0, 0, 0)) -> Shape:
    return transform_shape(primitive_call('set_cuboid', block_type=kind, block_kwargs={}, scale=tuple(int(s) for s in scale), fill=True), translation_matrix(at))


@register()
def terrain(n: int) -> Shape:
    heights = height_map(n)
    columns = []
    for (z, x), h in np.ndenumerate(heights):
        if h > 1:
            columns.append(cuboid("minecraft:stone", (1, h - 1, 1), (x, 0, z)))
        columns.append(cuboid(surface(int(h)), (1, 1, 1), (x, h - 1, z)))
    return concat_shapes(*columns)


@register()
def pond(radius: int) -> Shape:
    rows = []
    for dz in range(-radius, radius + 1):
        half = int(np.sqrt(radius ** 2 - dz ** 2))
        rows.append(cuboid("minecraft:water", (2 * half + 1, 1, 1), (-half, 0, dz)))
    return concat_shapes(*rows)


@register()
def hill(n: int = 12) -> Shape:
    heights = height_map(n)
    peak = tuple(int(v) for v in np.argwhere(heights == heights.max())[0])
    flag = [cuboid("minecraft:oak_fence", (1, 3, 1), (peak[1], heights[peak], peak[0])), cuboid("minecraft:red_wool", (2, 1, 1), (peak[1] + 1, heights[peak] + 2, peak[0]))]
    stairs = [cuboid("minecraft:stone_bricks", (1, 1, 2), (n + k, int(h), n // 2)) for k, h in enumerate(heights[n // 2, :-5:-1])]
    return concat_shapes(library_call('terrain', n=n), transform_shape(library_call('pond', radius=3), translation_matrix((-5, 0, 3))), *flag, *stairs)
