import math
import random
from helper import *

"""
an asteroid belt around a gas giant
"""

rng = random.Random(2024)
PALETTE = [(0.5, 0.45, 0.4), (0.4, 0.38, 0.36), (0.6, 0.5, 0.4)]

def unit_vector() -> tuple:
    z = random.uniform(-1, 1)
    a = random.uniform(0, math.tau)
    s = math.sqrt(1 - z * z)
    return (s * math.cos(a), s * math.sin(a), z)

@register("a lumpy asteroid")
def asteroid(size: float, lumps: int) -> Shape:
    parts = [primitive_call('sphere', color=random.choice(PALETTE), shape_kwargs={'radius': size})]
    for _ in range(lumps):
        direction = unit_vector()
        r = size * random.betavariate(2, 3)
        lump = primitive_call('sphere', color=PALETTE[random.randrange(len(PALETTE))], shape_kwargs={'radius': r})
        parts.append(transform_shape(lump, translation_matrix([size * c for c in direction])))
    return concat_shapes(*parts)

@register("asteroid belt")
def belt(n: int = 40, inner: float = 4.0, outer: float = 6.0) -> Shape:
    shapes = []
    for i in range(n):
        r = inner + (outer - inner) * random.random() ** 0.5
        a = random.uniform(0, 2 * math.pi)
        y = random.normalvariate(0, 0.15)
        size = min(0.05 * random.expovariate(1.0) + 0.05, 0.25)
        rock = library_call('asteroid', size=size, lumps=random.randint(0, 3))
        shapes.append(transform_shape(rock, translation_matrix((r * math.cos(a), y, r * math.sin(a)))))
    return concat_shapes(*shapes)

@register("gas giant with belt")
def system() -> Shape:
    bands = []
    y = -1.5
    while y < 1.5:
        h = rng.uniform(0.2, 0.5)
        top = min(y + h, 1.5)
        middle = (y + top) / 2
        color = (0.7 + rng.uniform(-0.1, 0.2), 0.55 + rng.uniform(-0.1, 0.1), 0.4)
        bands.append(primitive_call('cylinder', color=color, shape_kwargs={'radius': math.sqrt(max(4 - middle ** 2, 0.01)), 'p0': (0, y, 0), 'p1': (0, top, 0)}))
        y = top
    moons = [transform_shape(primitive_call('sphere', color=(0.8, 0.8, 0.8), shape_kwargs={'radius': 0.2}), translation_matrix([3 * c for c in unit_vector()])) for _ in range(3)]
    state = random.getrandbits(3)
    probe = primitive_call('cube', color=(0.9, 0.9, 0.2), shape_kwargs={'scale': (0.2, 0.2, 0.2 + 0.1 * state)})
    return concat_shapes(*bands, *moons, library_call('belt'), transform_shape(probe, translation_matrix((0, 3, 0))))
