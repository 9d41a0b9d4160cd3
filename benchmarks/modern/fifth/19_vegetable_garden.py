"""a vegetable garden with rows of carrots, cabbages and pumpkins, guarded by a scarecrow"""
from helper import *
import math
import random
from functools import partial

SOIL = (0.33, 0.22, 0.14)
GREEN = (0.3, 0.6, 0.22)

sphere = partial(primitive_call, 'sphere')
cylinder = partial(primitive_call, 'cylinder')
cube = partial(primitive_call, 'cube')


def at(shape, x=0.0, y=0.0, z=0.0):
    return transform_shape(shape, translation_matrix((x, y, z)))


@register()
def carrot(size: float = 0.12, leaves: int = 6) -> Shape:
    top = at(sphere(shape_kwargs={'radius': size * 0.35}, color=(0.95, 0.5, 0.1)), y=size * 0.05)
    fronds = loop(leaves, lambda i: cylinder(shape_kwargs={
        'radius': 0.008, 'p0': (0, size * 0.2, 0),
        'p1': (size * math.cos(i * 2 * math.pi / leaves), size * 2.2, size * math.sin(i * 2 * math.pi / leaves))}, color=GREEN))
    return concat_shapes(top, fronds)


@register()
def cabbage(size: float = 0.22, leaves: int = 8) -> Shape:
    heart = at(sphere(shape_kwargs={'radius': size * 0.7}, color=(0.7, 0.85, 0.5)), y=size * 0.6)
    leaf = transform_shape(sphere(shape_kwargs={'radius': 1}, color=(0.45, 0.7, 0.35)), scale_matrix((size * 0.5, size * 0.5, size * 0.1), (0, 0, 0)))
    leaf = at(transform_shape(leaf, rotation_matrix(0.5, (1, 0, 0), (0, 0, 0))), 0, size * 0.45, size * 0.7)
    return concat_shapes(heart, loop(leaves, lambda i: transform_shape(leaf, rotation_matrix(2 * math.pi * i / leaves, (0, 1, 0), (0, 0, 0)))))


@register()
def pumpkin(size: float = 0.3, ribs: int = 9, ripe: float = 1.0) -> Shape:
    color = (0.55 + 0.4 * ripe, 0.55 - 0.08 * ripe, 0.15)
    rib = transform_shape(sphere(shape_kwargs={'radius': 1}, color=color), scale_matrix((size * 0.45, size * 0.75, size * 0.35), (0, 0, 0)))
    body = loop(ribs, lambda i: transform_shape(at(rib, size * 0.5, size * 0.7, 0), rotation_matrix(2 * math.pi * i / ribs, (0, 1, 0), (0, 0, 0))))
    stem = cylinder(shape_kwargs={'radius': size * 0.1, 'p0': (0, size * 1.3, 0), 'p1': (size * 0.15, size * 1.7, 0)}, color=(0.4, 0.45, 0.2))
    return concat_shapes(body, stem)


@register()
def vegetable_row(kind: str = 'carrot', count: int = 10, spacing: float = 0.4, seed: int = 0) -> Shape:
    rnd = random.Random(seed)
    ridge = at(transform_shape(cylinder(shape_kwargs={'radius': 0.2, 'p0': (-spacing * count / 2, 0, 0), 'p1': (spacing * count / 2, 0, 0)}, color=SOIL), scale_matrix((1, 0.5, 1), (0, 0, 0))))
    plants = []
    for i in range(count):
        if rnd.random() < 0.08:
            continue  # something ate this one
        if kind == 'carrot':
            plant = library_call('carrot', size=rnd.uniform(0.1, 0.15), leaves=rnd.randint(5, 8))
        elif kind == 'cabbage':
            plant = library_call('cabbage', size=rnd.uniform(0.17, 0.23))
        else:
            plant = library_call('pumpkin', size=rnd.uniform(0.18, 0.3), ripe=rnd.random())
        plant = transform_shape(plant, rotation_matrix(rnd.uniform(0, math.tau), (0, 1, 0), (0, 0, 0)))
        plants.append(at(plant, (i - (count - 1) / 2) * spacing, 0.08, 0))
    return concat_shapes(ridge, *plants)


@register()
def scarecrow(height: float = 1.8, shirt: tuple = (0.65, 0.2, 0.15), patches: int = 3) -> Shape:
    wood, straw = (0.45, 0.32, 0.18), (0.9, 0.78, 0.4)
    pole = cylinder(shape_kwargs={'radius': 0.05, 'p0': (0, 0, 0), 'p1': (0, height, 0)}, color=wood)
    arms = cylinder(shape_kwargs={'radius': 0.04, 'p0': (-0.75, height * 0.75, 0), 'p1': (0.75, height * 0.75, 0)}, color=wood)
    torso = at(cube(shape_kwargs={'scale': (0.5, 0.65, 0.25)}, color=shirt), 0, height * 0.62, 0)
    sleeves = [at(cube(shape_kwargs={'scale': (0.4, 0.2, 0.2)}, color=shirt), s * 0.42, height * 0.75, 0) for s in (-1, 1)]
    patch_shapes = [at(cube(shape_kwargs={'scale': (0.12, 0.12, 0.01)}, color=((0.2, 0.4, 0.6), (0.9, 0.8, 0.3), (0.3, 0.55, 0.3))[k % 3]), -0.14 + 0.14 * k, height * (0.5 + 0.09 * k), 0.13) for k in range(patches)]
    hands = [cylinder(shape_kwargs={'radius': 0.012, 'p0': (s * 0.62, height * 0.75, 0), 'p1': (s * 0.85, height * 0.75 + 0.05 * (f - 2), 0.04 * (f % 2))}, color=straw) for s in (-1, 1) for f in range(5)]
    head = at(sphere(shape_kwargs={'radius': 0.19}, color=(0.88, 0.75, 0.55)), y=height + 0.05)
    face = [at(sphere(shape_kwargs={'radius': 0.025}, color=(0.1, 0.1, 0.1)), dx, height + dy, 0.18) for dx, dy in ((-0.07, 0.1), (0.07, 0.1), (-0.05, -0.02), (0, -0.04), (0.05, -0.02))]
    hat = concat_shapes(cylinder(shape_kwargs={'radius': 0.34, 'p0': (0, height + 0.18, 0), 'p1': (0, height + 0.21, 0)}, color=straw),
                        loop(4, lambda i: cylinder(shape_kwargs={'radius': 0.18 * (1 - i / 5), 'p0': (0, height + 0.2 + 0.08 * i, 0), 'p1': (0, height + 0.28 + 0.08 * i, 0)}, color=straw)))
    return concat_shapes(pole, arms, torso, *sleeves, *patch_shapes, *hands, head, *face, hat)


@register()
def crow(wing: float = 0.5) -> Shape:
    black = (0.08, 0.08, 0.1)
    body = transform_shape(sphere(shape_kwargs={'radius': 0.1}, color=black), scale_matrix((1.8, 1, 1), (0, 0, 0)))
    wings = [transform_shape(at(cube(shape_kwargs={'scale': (0.16, 0.02, 0.35)}, color=black), 0, 0.03, s * 0.2), rotation_matrix(-s * wing, (1, 0, 0), (0, 0, 0))) for s in (-1, 1)]
    beak = cylinder(shape_kwargs={'radius': 0.02, 'p0': (0.17, 0.02, 0), 'p1': (0.28, 0, 0)}, color=(0.9, 0.7, 0.2))
    return concat_shapes(body, *wings, beak)


@register()
def garden(rows: int = 6, row_gap: float = 0.7) -> Shape:
    kinds = ['carrot', 'cabbage', 'pumpkin']
    beds = [at(library_call('vegetable_row', kind=kinds[i % 3], count=8 if kinds[i % 3] == 'pumpkin' else 11, spacing=0.6 if kinds[i % 3] == 'pumpkin' else 0.42, seed=i), 0, 0, (i - (rows - 1) / 2) * row_gap) for i in range(rows)]
    plot = at(cube(shape_kwargs={'scale': (6, 0.1, rows * row_gap + 1)}, color=(0.42, 0.3, 0.18)), y=-0.05)
    birds = loop(4, lambda i: at(transform_shape(library_call('crow', wing=0.3 + 0.2 * i), rotation_matrix(i * 1.3, (0, 1, 0), (0, 0, 0))), -2 + 1.3 * i, 2.2 + 0.3 * (i % 2), -1 + 0.5 * i))
    return concat_shapes(plot, *beds, at(library_call('scarecrow'), 0.2, 0, -0.35), birds)
