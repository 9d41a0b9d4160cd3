"""a giraffe family under an acacia tree"""
from helper import *
import math
import numpy as np

HIDE = (0.87, 0.68, 0.35)
PATCH = (0.5, 0.28, 0.12)
HOOF = (0.2, 0.14, 0.1)


def limb(a, b, r, color=HIDE):
    return primitive_call('cylinder', shape_kwargs={'radius': float(r), 'p0': tuple(a), 'p1': tuple(b)}, color=color)


def ball(c, r, color=HIDE):
    return transform_shape(primitive_call('sphere', shape_kwargs={'radius': float(r)}, color=color), translation_matrix(tuple(c)))


@register("a neck from the shoulder to the head as a chain of spheres")
def neck(length: float = 1.8, beads: int = 12, lean: float = 20.0) -> Shape:
    direction = np.array([math.sin(math.radians(lean)), math.cos(math.radians(lean)), 0.0])
    shapes = []
    for t in np.linspace(0, 1, beads):
        center = direction * length * t
        shapes.append(ball(center, 0.22 - 0.1 * t))
        if t > 0.1:
            side = np.array([0.0, 0.0, 0.15 - 0.07 * t])
            shapes.append(ball(center + side, 0.09 - 0.03 * t, PATCH))
            shapes.append(ball(center - side, 0.09 - 0.03 * t, PATCH))
    # a mane behind the neck
    back = np.array([-direction[1], direction[0], 0.0])
    for t in np.arange(0.15, 1.0, 0.1):
        shapes.append(ball(direction * length * t + back * (0.2 - 0.1 * t), 0.05, (0.45, 0.25, 0.1)))
    return concat_shapes(*shapes)


@register("a head that looks along +x")
def head() -> Shape:
    skull = ball((0, 0, 0), 0.16)
    muzzle = [ball((0.1 + 0.07 * i, -0.03 - 0.035 * i, 0), 0.13 - 0.015 * i) for i in range(4)]
    eyes = [ball((0.08, 0.06, s * 0.13), 0.03, (0.05, 0.03, 0.02)) for s in (-1, 1)]
    ears = [limb((-0.05, 0.08, s * 0.1), (-0.12, 0.14, s * 0.28), 0.04) for s in (-1, 1)]
    horns = []
    for s in (-1, 1):
        horns += [limb((-0.02, 0.1, s * 0.06), (-0.05, 0.3, s * 0.08), 0.025), ball((-0.05, 0.31, s * 0.08), 0.04, HOOF)]
    return concat_shapes(skull, *muzzle, *eyes, *ears, *horns)


@register()
def leg(length: float = 1.6, swing: float = 0.0) -> Shape:
    knee = (length * 0.5 * math.sin(math.radians(swing)), -length * 0.5 * math.cos(math.radians(swing)), 0)
    foot = (knee[0], -length, 0)
    return concat_shapes(limb((0, 0, 0), knee, 0.11), ball(knee, 0.11), limb(knee, foot, 0.075),
                         limb(foot, (foot[0], foot[1] - 0.08, 0), 0.09, HOOF))


@register()
def giraffe(lean: float = 20.0, stride: float = 10.0) -> Shape:
    height = 1.68
    body = [ball((x, height + 0.25 + 0.12 * x, 0), 0.42 - 0.05 * abs(x)) for x in np.linspace(-0.6, 0.6, 7)]
    spots = [
        ball((x + 0.08 * (row % 2), height + 0.15 + 0.17 * row + 0.12 * x, s * 0.36), 0.1, PATCH)
        for x in np.linspace(-0.55, 0.45, 5) for row in range(3) for s in (-1, 1)
    ]
    swings = {(1, 1): stride, (1, -1): -stride, (-1, 1): -stride, (-1, -1): stride}
    legs = [transform_shape(library_call('leg', swing=a), translation_matrix((0.55 * fx, height, 0.2 * fz))) for (fx, fz), a in swings.items()]
    tail = [limb((-0.9, height + 0.3, 0), (-1.1, height - 0.4, 0), 0.03), ball((-1.11, height - 0.48, 0), 0.08, HOOF)]
    shoulder = np.array([0.62, height + 0.45, 0.0])
    tip = shoulder + 1.8 * np.array([math.sin(math.radians(lean)), math.cos(math.radians(lean)), 0.0])
    return concat_shapes(
        *body, *spots, *legs, *tail,
        transform_shape(library_call('neck', lean=lean), translation_matrix(tuple(shoulder))),
        transform_shape(library_call('head'), translation_matrix(tuple(tip + np.array([0.05, 0.1, 0.0])))))


@register("a tree with a flat crown")
def acacia(height: float = 4.0, branches: int = 7) -> Shape:
    fork = np.array([0.15, height * 0.55, 0.0])
    parts = [limb((0, 0, 0), fork, 0.18, (0.42, 0.3, 0.2))]
    for k in range(branches):
        a = 2 * np.pi * k / branches
        end = np.array([1.4 * np.cos(a), height + 0.1 * (k % 2), 1.4 * np.sin(a)])
        parts.append(limb(fork, end, 0.07, (0.42, 0.3, 0.2)))
        parts.append(limb(end - np.array([0, 0.05, 0]), end + np.array([0, 0.18, 0]), 0.85, (0.35, 0.45, 0.15)))
    return concat_shapes(*parts)


@register()
def giraffe_savanna() -> Shape:
    ground = limb((0, -0.1, 0), (0, 0, 0), 5.0, (0.78, 0.66, 0.38))
    mother = library_call('giraffe')
    calf = transform_shape(library_call('giraffe', lean=35.0, stride=18.0), scale_matrix(0.5, (0, 0, 0)))
    calf = transform_shape(calf, translation_matrix((-0.8, 0, 1.6)))
    grass = loop(30, lambda i: limb((4 * math.cos(i * 2.4) * (0.4 + i / 50), 0, 4 * math.sin(i * 2.4) * (0.4 + i / 50)),
                                    (4 * math.cos(i * 2.4) * (0.4 + i / 50) + 0.06, 0.35, 4 * math.sin(i * 2.4) * (0.4 + i / 50)), 0.03, (0.6, 0.6, 0.25)))
    return concat_shapes(ground, mother, calf, transform_shape(library_call('acacia'), translation_matrix((2.4, 0, -1.2))), grass)
