"""a three-tier birthday cake with thirty candles, presents and balloons"""
from helper import *
import math
import random
from itertools import cycle

PASTEL = [(0.98, 0.75, 0.8), (0.75, 0.88, 0.98), (0.99, 0.93, 0.7), (0.8, 0.95, 0.8), (0.88, 0.8, 0.98)]


@register()
def candle(height: float = 0.22, color: tuple = (0.9, 0.3, 0.3), lit: bool = True) -> Shape:
    twist = 6
    parts = [primitive_call('cylinder', shape_kwargs={'radius': 0.02, 'p0': (0, height * k / twist, 0), 'p1': (0, height * (k + 1) / twist, 0)}, color=color if k % 2 == 0 else (1, 1, 1)) for k in range(twist)]
    parts.append(primitive_call('cylinder', shape_kwargs={'radius': 0.004, 'p0': (0, height, 0), 'p1': (0, height + 0.03, 0)}, color=(0.1, 0.1, 0.1)))
    if lit:
        flame = transform_shape(primitive_call('sphere', shape_kwargs={'radius': 0.018}, color=(1, 0.75, 0.2)), scale_matrix((1, 2, 1), (0, 0, 0)))
        parts.append(transform_shape(flame, translation_matrix((0, height + 0.055, 0))))
    return concat_shapes(*parts)


@register()
def tier(radius: float = 0.8, height: float = 0.35, icing: tuple = (0.98, 0.75, 0.8), pearls: int = 0) -> Shape:
    sponge = primitive_call('cylinder', shape_kwargs={'radius': radius, 'p0': (0, 0, 0), 'p1': (0, height, 0)}, color=icing)
    count = pearls or int(2 * math.pi * radius / 0.12)
    def pearl(i):
        a = 2 * math.pi * i / count
        ball = primitive_call('sphere', shape_kwargs={'radius': 0.05}, color=(1, 0.98, 0.95))
        return transform_shape(ball, translation_matrix((radius * math.cos(a), 0.04, radius * math.sin(a))))
    drips = []
    for i in range(count // 2):
        a = 4 * math.pi * i / count + 0.1
        length = height * (0.25 + 0.3 * abs(math.sin(i * 1.7)))
        x, z = radius * math.cos(a), radius * math.sin(a)
        drips.append(primitive_call('cylinder', shape_kwargs={'radius': 0.04, 'p0': (x, height, z), 'p1': (x, height - length, z)}, color=(0.45, 0.25, 0.15)))
        drips.append(transform_shape(primitive_call('sphere', shape_kwargs={'radius': 0.04}, color=(0.45, 0.25, 0.15)), translation_matrix((x, height - length, z))))
    return concat_shapes(sponge, loop(count, pearl), *drips)


@register()
def cake(tiers: int = 3, base_radius: float = 0.9, candles: int = 30) -> Shape:
    shapes, tops, y = [], [], 0.0
    colors = cycle(PASTEL)
    for k in range(tiers):
        r = base_radius * (1 - k / (tiers + 0.5))
        shapes.append(transform_shape(library_call('tier', radius=r, icing=next(colors)), translation_matrix((0, y, 0))))
        y += 0.35
        inner = base_radius * (1 - (k + 1) / (tiers + 0.5)) if k < tiers - 1 else 0
        tops.append((y, (r + inner) / 2 if inner else r * 0.6, 2 * math.pi * r))
    # share the candles out by circumference
    total = sum(t[2] for t in tops)
    shares = [int(candles * t[2] / total) for t in tops]
    shares[0] += candles - sum(shares)
    for (level, ring, _), n in zip(tops, shares):
        for i in range(n):
            a = 2 * math.pi * i / n
            c = library_call('candle', color=PASTEL[i % len(PASTEL)], lit=(i % 7 != 6))
            shapes.append(transform_shape(c, translation_matrix((ring * math.cos(a), level, ring * math.sin(a)))))
    return concat_shapes(*shapes)


@register()
def present(size: tuple = (0.6, 0.4, 0.6), paper: tuple = (0.3, 0.5, 0.8), ribbon: tuple = (0.95, 0.85, 0.3)) -> Shape:
    w, h, d = size
    box = transform_shape(primitive_call('cube', shape_kwargs={'scale': size}, color=paper), translation_matrix((0, h / 2, 0)))
    bands = [transform_shape(primitive_call('cube', shape_kwargs={'scale': s}, color=ribbon), translation_matrix((0, h / 2, 0)))
             for s in ((w * 1.01, h * 1.01, d * 0.15), (w * 0.15, h * 1.01, d * 1.01))]
    loops = []
    for side in (-1, 1):
        for k in range(8):
            a = 2 * math.pi * k / 8
            loops.append(transform_shape(primitive_call('sphere', shape_kwargs={'radius': 0.025}, color=ribbon), translation_matrix((side * (0.09 + 0.07 * math.cos(a)), h + 0.05 + 0.045 * math.sin(a), 0))))
    return concat_shapes(box, *bands, *loops)


@register()
def balloon(color: tuple = (0.9, 0.2, 0.3), string: float = 1.6, sway: float = 0.2) -> Shape:
    skin = transform_shape(primitive_call('sphere', shape_kwargs={'radius': 0.3}, color=color), scale_matrix((1, 1.2, 1), (0, 0, 0)))
    knot = primitive_call('cylinder', shape_kwargs={'radius': 0.03, 'p0': (0, -0.36, 0), 'p1': (0, -0.4, 0)}, color=color)
    n = 8
    pts = [(sway * math.sin(2.5 * k / n) * k / n, -0.4 - string * k / n, 0) for k in range(n + 1)]
    line = [primitive_call('cylinder', shape_kwargs={'radius': 0.006, 'p0': a, 'p1': b}, color=(0.9, 0.9, 0.9)) for a, b in zip(pts, pts[1:])]
    return concat_shapes(skin, knot, *line)


@register()
def party(guests_presents: int = 5, balloons: int = 6, seed: int = 30) -> Shape:
    rnd = random.Random(seed)
    table = primitive_call('cylinder', shape_kwargs={'radius': 1.8, 'p0': (0, -0.1, 0), 'p1': (0, 0, 0)}, color=(0.97, 0.97, 0.95))
    gifts = []
    for i in range(guests_presents):
        a = math.pi * (0.15 + 0.7 * i / max(1, guests_presents - 1))
        size = (rnd.uniform(0.3, 0.5), rnd.uniform(0.2, 0.4), rnd.uniform(0.3, 0.5))
        gift = library_call('present', size=size, paper=rnd.choice(PASTEL), ribbon=(0.85, 0.15, 0.3) if i % 2 else (0.95, 0.85, 0.3))
        gift = transform_shape(gift, rotation_matrix(rnd.uniform(-0.5, 0.5), (0, 1, 0), (0, 0, 0)))
        gifts.append(transform_shape(gift, translation_matrix((1.45 * math.cos(a), 0, 1.45 * math.sin(a)))))
    hues = [(0.9, 0.2, 0.3), (0.2, 0.5, 0.9), (0.95, 0.8, 0.2)]
    floating = [transform_shape(library_call('balloon', color=hues[i % 3], sway=rnd.uniform(-0.3, 0.3)), translation_matrix((-1.5 + 3 * i / (balloons - 1), 2 + 0.25 * (i % 3), -1.4))) for i in range(balloons)]
    return concat_shapes(table, library_call('cake'), *gifts, *floating)
