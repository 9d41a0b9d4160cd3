"""a five-story Japanese pagoda in a cherry blossom garden"""
from helper import *
import math
import random

FLOORS = 5


def stack_up(*shapes, gap=0.0):
    """Put shapes on top of each other in y."""
    y, out = 0.0, []
    for s in shapes:
        lo, hi = compute_shape_min(s), compute_shape_max(s)
        out.append(transform_shape(s, translation_matrix([0, y - lo[1], 0])))
        y += hi[1] - lo[1] + gap
    return sum(out, [])


@register()
def roof(width: float, layers: int = 5, color=(0.2, 0.25, 0.28)) -> Shape:
    slabs = [primitive_call('cube', shape_kwargs={'scale': (w := width * (1 - 0.12 * k), 0.08, w)}, color=color) for k in range(layers)]
    tips = []
    for sx, sz in ((1, 1), (1, -1), (-1, 1), (-1, -1)):
        a = (sx * width / 2, 0, sz * width / 2)
        b = (sx * width * 0.58, 0.25, sz * width * 0.58)
        tips.append(primitive_call('cylinder', shape_kwargs={'radius': 0.04, 'p0': a, 'p1': b}, color=(0.75, 0.6, 0.2)))
    return concat_shapes(stack_up(*slabs), *tips)


@register()
def story(width: float, height: float = 0.8) -> Shape:
    core = primitive_call('cube', shape_kwargs={'scale': (width * 0.85, height, width * 0.85)}, color=(0.95, 0.92, 0.85))
    n = 4
    cols = []
    for side in range(4):
        for i in range(n):
            x = -width * 0.45 + i * width * 0.9 / (n - 1)
            c = primitive_call('cylinder', shape_kwargs={'radius': 0.05, 'p0': (x, -height / 2, width * 0.45), 'p1': (x, height / 2, width * 0.45)}, color=(0.75, 0.15, 0.1))
            cols.append(transform_shape(c, rotation_matrix(side * math.pi / 2, (0, 1, 0), (0, 0, 0))))
    return concat_shapes(core, *cols)


@register()
def finial(rings: int = 7) -> Shape:
    pole = primitive_call('cylinder', shape_kwargs={'radius': 0.03, 'p0': (0, 0, 0), 'p1': (0, 1.4, 0)}, color=(0.8, 0.65, 0.2))
    return concat_shapes(pole, loop(rings, lambda i: primitive_call('cylinder', shape_kwargs={'radius': 0.15 - 0.01 * i, 'p0': (0, 0.3 + 0.13 * i, 0), 'p1': (0, 0.33 + 0.13 * i, 0)}, color=(0.8, 0.65, 0.2))))


@register()
def pagoda(floors: int = FLOORS, width: float = 3.0) -> Shape:
    levels = [primitive_call('cube', shape_kwargs={'scale': (width * 1.3, 0.4, width * 1.3)}, color=(0.6, 0.6, 0.58))]
    for k in range(floors):
        w = width * 0.87 ** k
        levels += [library_call('story', width=w), library_call('roof', width=w * 1.45)]
    return stack_up(*levels, library_call('finial'))


@register()
def cherry_tree(seed: int = 0) -> Shape:
    rng = random.Random(seed)
    trunk = primitive_call('cylinder', shape_kwargs={'radius': 0.12, 'p0': (0, 0, 0), 'p1': (rng.uniform(-.2, .2), 1.2, 0)}, color=(0.35, 0.22, 0.18))
    puffs = [transform_shape(primitive_call('sphere', shape_kwargs={'radius': rng.uniform(0.25, 0.45)}, color=(1.0, rng.uniform(0.65, 0.8), rng.uniform(0.75, 0.85))),
                             translation_matrix((rng.gauss(0, 0.4), 1.5 + rng.gauss(0, 0.2), rng.gauss(0, 0.4)))) for _ in range(9)]
    return concat_shapes(trunk, *puffs)


@register()
def pagoda_garden() -> Shape:
    ground = transform_shape(primitive_call('cylinder', shape_kwargs={'radius': 7, 'p0': (0, -0.2, 0), 'p1': (0, 0, 0)}, color=(0.5, 0.65, 0.35)), identity_matrix())
    trees = loop(7, lambda i: transform_shape(library_call('cherry_tree', seed=i), translation_matrix((5 * math.cos(i * 0.9), 0, 5 * math.sin(i * 0.9)))))
    return concat_shapes(ground, library_call('pagoda'), trees)
