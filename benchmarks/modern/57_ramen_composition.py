"""a bowl of ramen with noodles, egg halves, narutomaki and chopsticks"""
from helper import *
import math
import random
from operator import itemgetter


def ring_points(n, radius, y, phase=0.0):
    return [(radius * math.cos(phase + k * math.tau / n), y, radius * math.sin(phase + k * math.tau / n)) for k in range(n)]


@register()
def bowl(radius: float = 1.5, depth: float = 0.9, wall: int = 40) -> Shape:
    foot = primitive_call('cylinder', shape_kwargs={'radius': radius * 0.45, 'p0': (0, -0.12, 0), 'p1': (0, 0, 0)}, color=(0.15, 0.1, 0.1))
    layers = []
    steps = 8
    for s in range(steps):
        t = (s + 0.5) / steps
        r = radius * math.sqrt(1 - (1 - t) ** 2)
        for x, y, z in ring_points(wall, r, depth * t):
            layers.append(transform_shape(primitive_call('sphere', shape_kwargs={'radius': 0.12}, color=(0.75, 0.12, 0.1) if s == steps - 1 else (0.92, 0.9, 0.85)), translation_matrix((x, y, z))))
    return concat_shapes(foot, *layers)


@register()
def broth(radius: float = 1.35, y: float = 0.6) -> Shape:
    return primitive_call('cylinder', shape_kwargs={'radius': radius, 'p0': (0, 0.1, 0), 'p1': (0, y, 0)}, color=(0.72, 0.48, 0.22))


@register()
def noodle(seed: int, segments: int = 14, y: float = 0.6) -> Shape:
    rng = random.Random(seed)
    heading = rng.uniform(0, math.tau)
    x, z = rng.uniform(-0.5, 0.5), rng.uniform(-0.5, 0.5)
    bend = rng.choice([-1, 1]) * rng.uniform(0.3, 0.5)
    pts = []
    while len(pts) < segments:
        pts.append((x, y + 0.04 * math.sin(len(pts) + seed), z))
        heading += bend + rng.gauss(0, 0.1)
        x, z = x + 0.14 * math.cos(heading), z + 0.14 * math.sin(heading)
        if math.hypot(x, z) > 1.1:
            heading = math.atan2(-z, -x)
    return concat_shapes(*(primitive_call('cylinder', shape_kwargs={'radius': 0.04, 'p0': p, 'p1': q}, color=(0.96, 0.86, 0.55)) for p, q in zip(pts, pts[1:])))


@register()
def egg_half(size: float = 0.3) -> Shape:
    discs = [(r, y) for r, y in ((0.6, -0.5), (0.85, -0.25), (1.0, 0.0))]
    white = [primitive_call('cylinder', shape_kwargs={'radius': size * r, 'p0': (0, size * y, 0), 'p1': (0, size * (y + 0.25), 0)}, color=(0.97, 0.95, 0.9)) for r, y in sorted(discs, key=itemgetter(1))]
    yolk = primitive_call('cylinder', shape_kwargs={'radius': size * 0.55, 'p0': (0, size * 0.25, 0), 'p1': (0, size * 0.3, 0)}, color=(0.98, 0.65, 0.1))
    return concat_shapes(*white, yolk)


@register()
def narutomaki(radius: float = 0.25, turns: float = 2.0) -> Shape:
    cake = primitive_call('cylinder', shape_kwargs={'radius': radius, 'p0': (0, 0, 0), 'p1': (0, 0.08, 0)}, color=(0.98, 0.97, 0.96))
    n = 20
    spiral = [(radius * 0.8 * k / n * math.cos(turns * math.tau * k / n), 0.085, radius * 0.8 * k / n * math.sin(turns * math.tau * k / n)) for k in range(n)]
    return concat_shapes(cake, *[primitive_call('cylinder', shape_kwargs={'radius': 0.015, 'p0': a, 'p1': b}, color=(0.95, 0.4, 0.55)) for a, b in zip(spiral, spiral[1:])])


@register()
def ramen() -> Shape:
    toppings = [('egg_half', {}, (-0.6, 0.7, 0.3)), ('egg_half', {'size': 0.28}, (-0.3, 0.7, 0.75)), ('narutomaki', {}, (0.5, 0.68, 0.5)), ('narutomaki', {'turns': 2.5}, (0.75, 0.68, 0.0))]
    placed = [transform_shape(library_call(name, **kw), translation_matrix(at)) for name, kw, at in toppings]
    nori = transform_shape(primitive_call('cube', shape_kwargs={'scale': (0.6, 0.7, 0.03)}, color=(0.05, 0.15, 0.08)), translation_matrix((0.1, 0.95, -0.9)))
    sticks = [primitive_call('cylinder', shape_kwargs={'radius': 0.035, 'p0': (-1.6, 1.05, z), 'p1': (1.9, 1.05, z - 0.1)}, color=(0.55, 0.3, 0.15)) for z in (-0.2, -0.35)]
    noodles = loop(18, lambda i: library_call('noodle', seed=i))
    return concat_shapes(library_call('bowl'), library_call('broth'), noodles, *placed, nori, *sticks)
