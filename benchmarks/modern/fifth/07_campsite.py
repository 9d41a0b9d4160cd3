"""a campsite in a pine forest with a tent, a campfire and log seats"""
from helper import *
import math
import random


@register()
def pine(height: float = 4.0, tiers: int = 5, shade: float = 0.0) -> Shape:
    trunk = primitive_call('cylinder', shape_kwargs={'radius': 0.05 * height, 'p0': (0, 0, 0), 'p1': (0, height * 0.3, 0)}, color=(0.38, 0.26, 0.16))
    layers = []
    slices = 4
    for t in range(tiers):
        bottom = height * (0.2 + 0.15 * t)
        wide = height * 0.26 * (1 - t / (tiers + 1))
        for s in range(slices):
            layers.append(primitive_call('cylinder', shape_kwargs={
                'radius': wide * (1 - s / slices), 'p0': (0, bottom + s * height * 0.05, 0), 'p1': (0, bottom + (s + 1) * height * 0.05, 0),
            }, color=(0.1 + shade, 0.32 + shade + 0.02 * t, 0.16 + shade)))
    return concat_shapes(trunk, *layers)


@register()
def tent(width: float = 2.0, length: float = 2.6, height: float = 1.4, fabric: tuple = (0.9, 0.5, 0.15)) -> Shape:
    slope = math.atan2(height, width / 2)
    side_len = math.hypot(height, width / 2)
    walls = []
    for s in (-1, 1):
        wall = primitive_call('cube', shape_kwargs={'scale': (side_len, 0.03, length)}, color=fabric)
        wall = transform_shape(wall, rotation_matrix(-s * slope, (0, 0, 1), (0, 0, 0)))
        walls.append(transform_shape(wall, translation_matrix((s * width / 4, height / 2, 0))))
    n = 10
    back = loop(n, lambda i: transform_shape(
        primitive_call('cube', shape_kwargs={'scale': (width * (1 - (i + 0.5) / n), height / n, 0.03)}, color=tuple(c * 0.85 for c in fabric)),
        translation_matrix((0, height * (i + 0.5) / n, -length / 2))))
    poles = [primitive_call('cylinder', shape_kwargs={'radius': 0.025, 'p0': (0, 0, z), 'p1': (0, height + 0.1, z)}, color=(0.6, 0.6, 0.62)) for z in (-length / 2, length / 2)]
    guy_lines = [primitive_call('cylinder', shape_kwargs={'radius': 0.008, 'p0': (0, height, sz * length / 2), 'p1': (sx * width * 0.7, 0, sz * (length / 2 + 0.5))}, color=(0.9, 0.9, 0.85))
                 for sx in (-1, 1) for sz in (-1, 1)]
    return concat_shapes(*walls, back, *poles, *guy_lines)


@register()
def campfire(stones: int = 10, logs: int = 5, flames: int = 9, seed: int = 5) -> Shape:
    rnd = random.Random(seed)

    def stone(i):
        a = 2 * math.pi * i / stones
        r = rnd.uniform(0.1, 0.15)
        g = rnd.uniform(0.35, 0.5)
        rock = primitive_call('sphere', shape_kwargs={'radius': r}, color=(g, g, g * 0.97))
        return transform_shape(rock, translation_matrix((0.55 * math.cos(a), r * 0.6, 0.55 * math.sin(a))))

    def log(i):
        a = 2 * math.pi * i / logs + 0.2
        return primitive_call('cylinder', shape_kwargs={'radius': 0.06, 'p0': (0.4 * math.cos(a), 0.05, 0.4 * math.sin(a)), 'p1': (-0.05 * math.cos(a), 0.45, -0.05 * math.sin(a))}, color=(0.3, 0.18, 0.1))

    def flame(i):
        t = i / (flames - 1)
        a = i * 2.4
        r = 0.16 * (1 - t) + 0.03
        tongue = primitive_call('sphere', shape_kwargs={'radius': r}, color=(1.0, 0.85 - 0.5 * t, 0.2 * (1 - t)))
        return transform_shape(transform_shape(tongue, scale_matrix((1, 1.7, 1), (0, 0, 0))), translation_matrix((0.12 * (1 - t) * math.cos(a), 0.2 + 0.7 * t, 0.12 * (1 - t) * math.sin(a))))

    return concat_shapes(loop(stones, stone), loop(logs, log), loop(flames, flame))


@register()
def log_seat(length: float = 1.3, radius: float = 0.2) -> Shape:
    bark = primitive_call('cylinder', shape_kwargs={'radius': radius, 'p0': (-length / 2, radius, 0), 'p1': (length / 2, radius, 0)}, color=(0.36, 0.24, 0.14))
    ends = [primitive_call('cylinder', shape_kwargs={'radius': radius * f, 'p0': (s * length / 2, radius, 0), 'p1': (s * (length / 2 + 0.005 / f), radius, 0)}, color=(0.8 - 0.15 * f, 0.62 - 0.1 * f, 0.4))
            for s in (-1, 1) for f in (0.9, 0.6, 0.3)]
    return concat_shapes(bark, *ends)


@register()
def forest(trees: int = 18, inner: float = 4.5, outer: float = 8.0, seed: int = 11) -> Shape:
    random.seed(seed)
    shapes, spots = [], []
    attempts = 0
    while len(spots) < trees and attempts < 400:
        attempts += 1
        a, r = random.uniform(0, 2 * math.pi), random.uniform(inner, outer)
        x, z = r * math.cos(a), r * math.sin(a)
        if any(math.dist((x, z), other) < 1.4 for other in spots):
            continue
        spots.append((x, z))
        tree = library_call('pine', height=random.uniform(3, 5.5), tiers=random.randint(4, 6), shade=random.uniform(0, 0.08))
        shapes.append(transform_shape(tree, translation_matrix((x, 0, z))))
    return concat_shapes(*shapes)


@register()
def campsite() -> Shape:
    ground = primitive_call('cylinder', shape_kwargs={'radius': 9, 'p0': (0, -0.2, 0), 'p1': (0, 0, 0)}, color=(0.36, 0.42, 0.24))
    seats = [transform_shape(library_call('log_seat', length=1.1 + 0.1 * i), rotation_matrix(a, (0, 1, 0), (0, 0, 0)) @ translation_matrix((0, 0, 1.3)))
             for i, a in enumerate((0.3, 1.9, 3.6))]
    shelter = transform_shape(library_call('tent'), translation_matrix((-2.2, 0, -1.8)) @ rotation_matrix(0.8, (0, 1, 0), (0, 0, 0)))
    return concat_shapes(ground, library_call('campfire'), shelter, library_call('forest'), *seats)
