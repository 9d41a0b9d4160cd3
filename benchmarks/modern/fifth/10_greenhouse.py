"""a glass greenhouse with shelves of potted plants and a watering can"""
from helper import *
import math
import random

FRAME = (0.92, 0.94, 0.92)
TERRACOTTA = (0.76, 0.4, 0.25)


def bar(a, b, r=0.03, color=FRAME):
    return primitive_call('cylinder', shape_kwargs=dict(radius=r, p0=a, p1=b), color=color)


def cuboid(sx, sy, sz, x=0.0, y=0.0, z=0.0, color=FRAME):
    return transform_shape(primitive_call('cube', shape_kwargs=dict(scale=(sx, sy, sz)), color=color), translation_matrix((x, y, z)))


@register()
def arch(width: float = 3.0, wall: float = 1.8, ridge: float = 2.8) -> Shape:
    outline = [(-width / 2, 0), (-width / 2, wall), (0, ridge), (width / 2, wall), (width / 2, 0)]
    return concat_shapes(*[bar((x0, y0, 0), (x1, y1, 0)) for (x0, y0), (x1, y1) in zip(outline, outline[1:])])


@register()
def frame(width: float = 3.0, length: float = 5.0, bays: int = 5, wall: float = 1.8, ridge: float = 2.8) -> Shape:
    one = library_call('arch', width=width, wall=wall, ridge=ridge)
    arches = loop(bays + 1, lambda i: transform_shape(one, translation_matrix((0, 0, -length / 2 + i * length / bays))))
    edges = [(-width / 2, 0.0), (-width / 2, wall), (0.0, ridge), (width / 2, wall), (width / 2, 0.0), (-width / 2, wall / 2), (width / 2, wall / 2)]
    beams = [bar((x, y, -length / 2), (x, y, length / 2)) for x, y in edges]
    glass = (0.75, 0.88, 0.9)
    panes = []
    run, rise = width / 2, ridge - wall
    for side in (-1, 1):
        pane = cuboid(math.hypot(run, rise), 0.01, length / bays - 0.1, color=glass)
        pane = transform_shape(pane, rotation_matrix(-side * math.atan2(rise, run), (0, 0, 1), (0, 0, 0)))
        for i in range(bays):
            if (i + (side > 0)) % 2 == 0:  # every other pane is open
                panes.append(transform_shape(pane, translation_matrix((side * run / 2, (wall + ridge) / 2, -length / 2 + (i + 0.5) * length / bays))))
    return concat_shapes(arches, *beams, *panes)


@register()
def pot(radius: float = 0.14, height: float = 0.22) -> Shape:
    steps = 4
    wall = loop(steps, lambda i: bar((0, height * i / steps, 0), (0, height * (i + 1) / steps, 0), radius * (0.7 + 0.3 * i / steps), TERRACOTTA))
    rim = bar((0, height * 0.85, 0), (0, height, 0), radius * 1.1, TERRACOTTA)
    soil = bar((0, height, 0), (0, height + 0.01, 0), radius * 0.95, (0.25, 0.17, 0.1))
    return concat_shapes(wall, rim, soil)


@register()
def fern(fronds: int = 9, length: float = 0.35, droop: float = 1.4) -> Shape:
    def frond(i):
        heading = 2 * math.pi * i / fronds
        pts = [(length * t * math.cos(heading), 0.3 * math.sin(droop * 1.6 * t), length * t * math.sin(heading)) for t in (0, 0.25, 0.5, 0.75, 1.0)]
        return concat_shapes(*[bar(a, b, 0.02 - 0.004 * k, (0.2, 0.45 + 0.05 * k, 0.2)) for k, (a, b) in enumerate(zip(pts, pts[1:]))])
    return loop(fronds, frond)


@register()
def cactus(height: float = 0.4, arms: int = 2) -> Shape:
    green = (0.25, 0.5, 0.3)
    parts = [bar((0, 0, 0), (0, height, 0), 0.07, green), transform_shape(primitive_call('sphere', shape_kwargs={'radius': 0.07}, color=green), translation_matrix((0, height, 0)))]
    for k in range(arms):
        s, y = (-1) ** k, height * (0.4 + 0.2 * k)
        parts += [bar((0, y, 0), (s * 0.14, y, 0), 0.04, green), bar((s * 0.14, y, 0), (s * 0.14, y + 0.15, 0), 0.04, green)]
    parts.append(transform_shape(primitive_call('sphere', shape_kwargs={'radius': 0.03}, color=(0.95, 0.4, 0.6)), translation_matrix((0, height + 0.08, 0))))
    return concat_shapes(*parts)


@register()
def tomato_plant(height: float = 0.6, fruits: int = 6, seed: int = 0) -> Shape:
    rnd = random.Random(seed)
    stake = bar((0, 0, 0), (0, height, 0), 0.012, (0.6, 0.5, 0.35))
    out = [stake]
    for k in range(fruits):
        y, a = height * (0.3 + 0.65 * k / fruits), k * 2.4
        x, z = 0.12 * math.cos(a), 0.12 * math.sin(a)
        out.append(bar((0, y, 0), (x, y + 0.03, z), 0.01, (0.3, 0.55, 0.25)))
        ripe = rnd.random()
        out.append(transform_shape(primitive_call('sphere', shape_kwargs={'radius': 0.04 + 0.015 * rnd.random()}, color=(0.4 + 0.5 * ripe, 0.6 - 0.45 * ripe, 0.15)), translation_matrix((x, y, z))))
    return concat_shapes(*out)


PLANTS = {'fern': lambda i: library_call('fern', fronds=7 + i % 4), 'cactus': lambda i: library_call('cactus', arms=i % 3), 'tomato': lambda i: library_call('tomato_plant', seed=i)}


@register()
def shelf(length: float = 4.2, tiers: int = 2, per_tier: int = 7, side: int = 1) -> Shape:
    out = []
    kinds = list(PLANTS)
    for t in range(tiers):
        y, x = 0.5 + 0.6 * t, side * 0.25 * t
        out.append(cuboid(0.4, 0.04, length, x, y, 0, (0.6, 0.46, 0.3)))
        for i in range(per_tier):
            z = -length / 2 + (i + 0.5) * length / per_tier
            potted = concat_shapes(library_call('pot'), transform_shape(PLANTS[kinds[(i + t) % len(kinds)]](i), translation_matrix((0, 0.22, 0))))
            out.append(transform_shape(potted, translation_matrix((x, y + 0.02, z))))
    out += [bar((0, 0, z), (0, 0.5 + 0.6 * (tiers - 1), z), 0.03, (0.5, 0.38, 0.25)) for z in (-length / 2, length / 2)]
    return concat_shapes(*out)


@register()
def watering_can(size: float = 0.3) -> Shape:
    metal = (0.35, 0.55, 0.6)
    body = bar((0, 0, 0), (0, size, 0), size * 0.5, metal)
    spout = bar((size * 0.4, size * 0.2, 0), (size * 1.3, size * 1.1, 0), size * 0.08, metal)
    rose = bar((size * 1.25, size * 1.05, 0), (size * 1.4, size * 1.2, 0), size * 0.18, metal)
    grip = loop(8, lambda i: bar((size * (-0.4 - 0.35 * math.sin(i * math.pi / 8)), size * (0.2 + 0.8 * i / 8), 0), (size * (-0.4 - 0.35 * math.sin((i + 1) * math.pi / 8)), size * (0.2 + 0.8 * (i + 1) / 8), 0), 0.02, metal))
    return concat_shapes(body, spout, rose, grip)


@register()
def greenhouse() -> Shape:
    floor = cuboid(3.2, 0.1, 5.2, 0, -0.05, 0, (0.6, 0.58, 0.53))
    left = transform_shape(library_call('shelf', side=-1), translation_matrix((-1.0, 0, 0)))
    right = transform_shape(library_call('shelf', side=1, per_tier=6), translation_matrix((1.0, 0, 0)))
    can = transform_shape(library_call('watering_can'), translation_matrix((0, 0, 1.5)))
    return concat_shapes(floor, library_call('frame'), left, right, can)
