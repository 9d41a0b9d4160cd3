"""a breakfast table with a stack of pancakes, a coffee mug and a vase of tulips"""
from helper import *
import math
import random

WOOD = (0.62, 0.42, 0.25)
CREAM = (0.97, 0.94, 0.86)


@register()
def pancake_stack(count: int = 5, radius: float = 0.3, thickness: float = 0.06, seed: int = 4) -> Shape:
    rnd = random.Random(seed)
    shapes = []
    y = 0.0
    for i in range(count):
        dx, dz = rnd.uniform(-0.03, 0.03), rnd.uniform(-0.03, 0.03)
        golden = 0.75 + rnd.random() * 0.1
        shapes.append(primitive_call('cylinder', shape_kwargs={'radius': radius, 'p0': (dx, y, dz), 'p1': (dx, y + thickness, dz)}, color=(golden, golden * 0.68, 0.3)))
        y += thickness
    # butter and syrup on top
    butter = primitive_call('cube', shape_kwargs={'scale': (0.12, 0.05, 0.12)}, color=(1.0, 0.93, 0.5))
    butter = transform_shape(butter, rotation_matrix(0.4, direction=(0, 1, 0), point=(0, 0, 0)))
    shapes.append(transform_shape(butter, translation_matrix((0, y + 0.025, 0))))
    for k in range(7):
        angle = rnd.uniform(0, 2 * math.pi)
        drip = rnd.uniform(0.05, y * 0.8)
        x, z = (radius + 0.01) * math.cos(angle), (radius + 0.01) * math.sin(angle)
        shapes.append(primitive_call('cylinder', shape_kwargs={'radius': 0.02, 'p0': (x, y, z), 'p1': (x, y - drip, z)}, color=(0.45, 0.2, 0.05)))
    return concat_shapes(*shapes)


@register()
def plate(radius: float = 0.42) -> Shape:
    return concat_shapes(
        primitive_call('cylinder', shape_kwargs={'radius': radius * 0.6, 'p0': (0, 0, 0), 'p1': (0, 0.02, 0)}, color=CREAM),
        primitive_call('cylinder', shape_kwargs={'radius': radius, 'p0': (0, 0.02, 0), 'p1': (0, 0.035, 0)}, color=CREAM),
    )


@register()
def mug(height: float = 0.24, radius: float = 0.1, color: tuple = (0.2, 0.45, 0.55), steam: bool = True) -> Shape:
    body = primitive_call('cylinder', shape_kwargs={'radius': radius, 'p0': (0, 0, 0), 'p1': (0, height, 0)}, color=color)
    coffee = primitive_call('cylinder', shape_kwargs={'radius': radius * 0.88, 'p0': (0, height, 0), 'p1': (0, height + 0.003, 0)}, color=(0.22, 0.12, 0.06))

    def handle_piece(i: int) -> Shape:
        a = -math.pi / 2 + math.pi * i / 8
        piece = primitive_call('sphere', shape_kwargs={'radius': 0.018}, color=color)
        return transform_shape(piece, translation_matrix((radius + 0.07 * math.cos(a), height / 2 + 0.08 * math.sin(a), 0)))

    out = concat_shapes(body, coffee, loop(9, handle_piece))
    if steam:
        wisps = loop(12, lambda i: transform_shape(
            primitive_call('sphere', shape_kwargs={'radius': 0.012 + 0.001 * i}, color=(0.93, 0.93, 0.95)),
            translation_matrix((0.03 * math.sin(i * 0.9), height + 0.04 + 0.03 * i, 0.02 * math.cos(i * 0.7)))))
        out = concat_shapes(out, wisps)
    return out


@register()
def tulip(height: float = 0.5, bend: float = 0.1, color: tuple = (0.9, 0.25, 0.35)) -> Shape:
    n = 8
    def point(t):
        return (bend * t * t, height * t, 0)
    stem = loop(n, lambda i: primitive_call('cylinder', shape_kwargs={'radius': 0.012, 'p0': point(i / n), 'p1': point((i + 1) / n)}, color=(0.25, 0.55, 0.22)))
    petal = transform_shape(primitive_call('sphere', shape_kwargs={'radius': 1}, color=color), scale_matrix((0.035, 0.07, 0.05), (0, 0, 0)))
    petals = loop(5, lambda i: transform_shape(transform_shape(petal, translation_matrix((0.03, 0.05, 0))),
                                               rotation_matrix(i * 2 * math.pi / 5, (0, 1, 0), (0, 0, 0))))
    return concat_shapes(stem, transform_shape(petals, translation_matrix(point(1.0))))


@register()
def vase_of_tulips(flowers: int = 6) -> Shape:
    profile = [(0.07, 0.0), (0.1, 0.06), (0.11, 0.12), (0.09, 0.18), (0.06, 0.24), (0.07, 0.28)]
    vase = [primitive_call('cylinder', shape_kwargs={'radius': (r0 + r1) / 2, 'p0': (0, y0, 0), 'p1': (0, y1, 0)}, color=(0.75, 0.85, 0.9))
            for (r0, y0), (r1, y1) in zip(profile[:-1], profile[1:])]
    palette = [(0.9, 0.25, 0.35), (0.98, 0.8, 0.2), (0.85, 0.45, 0.75)]
    bunch = []
    for i in range(flowers):
        t = library_call('tulip', height=0.42 + 0.04 * (i % 3), bend=0.08 + 0.02 * i, color=palette[i % len(palette)])
        t = transform_shape(t, rotation_matrix(2 * math.pi * i / flowers, (0, 1, 0), (0, 0, 0)))
        bunch.append(transform_shape(t, translation_matrix((0, 0.12, 0))))
    return concat_shapes(*vase, *bunch)


@register()
def table(size: float = 1.6, height: float = 0.75) -> Shape:
    planks = loop(8, lambda i: transform_shape(
        primitive_call('cube', shape_kwargs={'scale': (size / 8 * 0.97, 0.05, size)}, color=tuple(c * (0.92 + 0.02 * (i % 4)) for c in WOOD)),
        translation_matrix((-size / 2 + size / 16 + i * size / 8, height - 0.025, 0))))
    legs = [primitive_call('cylinder', shape_kwargs={'radius': 0.05, 'p0': (sx * size * 0.42, 0, sz * size * 0.42), 'p1': (sx * size * 0.42, height - 0.05, sz * size * 0.42)}, color=WOOD)
            for sx in (-1, 1) for sz in (-1, 1)]
    return concat_shapes(planks, *legs)


@register()
def breakfast() -> Shape:
    base = library_call('table')
    top = compute_shape_max(base)[1]
    pancakes = concat_shapes(library_call('plate'), transform_shape(library_call('pancake_stack'), translation_matrix((0, 0.035, 0))))
    items = {
        (-0.2, 0.25): pancakes,
        (0.45, 0.3): library_call('mug'),
        (0.25, -0.4): library_call('vase_of_tulips'),
    }
    placed = [transform_shape(item, translation_matrix((x, top, z))) for (x, z), item in items.items()]
    return concat_shapes(base, *placed)
