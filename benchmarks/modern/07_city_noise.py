"""a dense city block skyline with building heights from value noise"""
from helper import *
from functools import lru_cache
import math
import numpy as np


@lru_cache(maxsize=None)
def lattice(ix: int, iz: int, seed: int = 3) -> float:
    h = (ix * 374761393 + iz * 668265263 + seed * 2147483647) & 0xFFFFFFFF
    h = ((h ^ (h >> 13)) * 1274126177) & 0xFFFFFFFF
    return ((h ^ (h >> 16)) & 0xFFFF) / 0xFFFF


def smoothstep(t: float) -> float:
    return t * t * (3 - 2 * t)


def value_noise(x: float, z: float) -> float:
    ix, iz = math.floor(x), math.floor(z)
    fx, fz = smoothstep(x - ix), smoothstep(z - iz)
    a, b = lattice(ix, iz), lattice(ix + 1, iz)
    c, d = lattice(ix, iz + 1), lattice(ix + 1, iz + 1)
    return (a * (1 - fx) + b * fx) * (1 - fz) + (c * (1 - fx) + d * fx) * fz


def fbm(x: float, z: float, octaves: int = 3) -> float:
    return sum(value_noise(x * 2 ** o, z * 2 ** o) / 2 ** (o + 1) for o in range(octaves))


@register()
def windows(width: float, height: float, depth: float) -> Shape:
    rows = max(1, int(height / 0.5))
    strips = []
    for r in range(rows):
        y = -height / 2 + (r + 0.5) * height / rows
        strip = primitive_call('cube', shape_kwargs={'scale': (width * 1.02, 0.12, depth * 1.02)}, color=(0.95, 0.9, 0.55))
        strips.append(transform_shape(strip, translation_matrix((0, y, 0))))
    return concat_shapes(*strips)


@register()
def building(width: float = 0.7, height: float = 2.0, depth: float = 0.7, tint: float = 0.5) -> Shape:
    gray = 0.25 + 0.4 * tint
    body = primitive_call('cube', shape_kwargs={'scale': (width, height, depth)}, color=(gray, gray, min(1.0, gray * 1.15)))
    shape = concat_shapes(body, library_call('windows', width=width, height=height, depth=depth))
    if height > 3.5:
        spire = primitive_call('cylinder', shape_kwargs={'radius': 0.04, 'p0': (0, height / 2, 0), 'p1': (0, height / 2 + 1, 0)}, color=(0.8, 0.2, 0.2))
        shape = concat_shapes(shape, spire)
    return transform_shape(shape, translation_matrix((0, height / 2, 0)))


@register()
def city(n: int = 9, spacing: float = 1.0) -> Shape:
    center = (n - 1) / 2
    blocks = []
    for i, j in np.ndindex(n, n):
        if i % 4 == 3 or j % 4 == 3:
            continue  # streets
        falloff = math.exp(-((i - center) ** 2 + (j - center) ** 2) / (n * 1.5))
        h = 0.6 + 5.5 * fbm(i * 0.37, j * 0.37) * (0.3 + falloff)
        b = library_call('building', height=h, tint=lattice(i, j, 99))
        blocks.append(transform_shape(b, translation_matrix(((i - center) * spacing, 0, (j - center) * spacing))))
    return concat_shapes(*blocks)


@register()
def skyline() -> Shape:
    asphalt = primitive_call('cube', shape_kwargs={'scale': (10, 0.1, 10)}, color=(0.18, 0.18, 0.2))
    return concat_shapes(transform_shape(asphalt, translation_matrix((0, -0.05, 0))), library_call('city'))
