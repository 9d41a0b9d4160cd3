"""a snowman next to a decorated Christmas tree while it snows"""
from helper import *
import math
import random

random.seed(24)

SNOW = (0.96, 0.97, 1.0)
COAL = (0.05, 0.05, 0.06)
BAUBLES = [(0.85, 0.1, 0.15), (0.95, 0.75, 0.2), (0.2, 0.4, 0.85), (0.8, 0.8, 0.85)]


def sphere(r, color, at=(0, 0, 0)):
    return transform_shape(primitive_call('sphere', shape_kwargs={'radius': r}, color=color), translation_matrix(at))


def stick(p0, p1, r, color):
    return primitive_call('cylinder', shape_kwargs={'radius': r, 'p0': p0, 'p1': p1}, color=color)


@register("a top hat whose brim is at y = 0")
def top_hat(radius: float = 0.2, height: float = 0.3) -> Shape:
    brim = stick((0, 0, 0), (0, 0.03, 0), radius * 1.6, COAL)
    crown = stick((0, 0, 0), (0, height, 0), radius, COAL)
    ribbon = stick((0, 0.03, 0), (0, 0.09, 0), radius * 1.02, (0.7, 0.1, 0.15))
    return concat_shapes(brim, crown, ribbon)


@register("a scarf of small balls around the neck with a hanging end")
def scarf(radius: float = 0.26, beads: int = 20) -> Shape:
    stripes = lambda i: (0.8, 0.15, 0.2) if i % 2 else (0.95, 0.9, 0.8)
    around = loop(beads, lambda i: sphere(0.06, stripes(i), (
        radius * math.cos(math.tau * i / beads), 0, radius * math.sin(math.tau * i / beads))))
    end = loop(6, lambda i: sphere(0.055, stripes(i), (0.12, -0.05 - 0.07 * i, radius + 0.05)))
    return concat_shapes(around, end)


@register()
def snowman(sizes: tuple[float, float, float] = (0.6, 0.42, 0.3), buttons: int = 3) -> Shape:
    body, y, centers = [], 0.0, []
    for k, r in enumerate(sizes):
        y += r * (0.9 if k == 0 else 0.75)
        centers.append(y)
        body.append(sphere(r, SNOW, (0, y, 0)))
        y += r * 0.75
    head_y, head_r = centers[-1], sizes[-1]
    eyes = [sphere(0.035, COAL, (s * 0.1, head_y + 0.07, head_r * 0.92)) for s in (-1, 1)]
    smile = [sphere(0.02, COAL, (0.14 * math.sin(a), head_y - 0.02 - 0.1 * math.cos(a), head_r * 0.93))
             for a in (-0.9, -0.45, 0, 0.45, 0.9)]
    nose = [stick((0, head_y, head_r * 0.9 + 0.06 * i), (0, head_y, head_r * 0.9 + 0.06 * (i + 1)), 0.04 - 0.01 * i, (0.95, 0.5, 0.1)) for i in range(4)]
    chest = loop(buttons, lambda i: sphere(0.035, COAL, (0, centers[1] - 0.18 + 0.18 * i, sizes[1] * 0.96)))
    arms = []
    for s in (-1, 1):
        hand = (s * 0.95, centers[1] + 0.35, 0.1)
        arms.append(stick((s * 0.35, centers[1] + 0.05, 0), hand, 0.025, (0.35, 0.22, 0.12)))
        arms += [stick(hand, (s * 1.08, centers[1] + 0.4 + 0.08 * f, 0.1 + 0.08 * f), 0.012, (0.35, 0.22, 0.12)) for f in (-1, 0, 1)]
    hat = transform_shape(library_call('top_hat'), translation_matrix((0, head_y + head_r * 0.8, 0)))
    wrap = transform_shape(library_call('scarf'), translation_matrix((0, head_y - head_r * 0.85, 0)))
    return concat_shapes(*body, *eyes, *smile, *nose, chest, *arms, hat, wrap)


@register("layers of green discs with baubles at their edges, and a star")
def christmas_tree(layers: int = 5, height: float = 2.6) -> Shape:
    trunk = stick((0, 0, 0), (0, 0.4, 0), 0.12, (0.4, 0.26, 0.15))
    parts = [trunk]
    step = (height - 0.4) / layers
    for layer in range(layers):
        outer = 1.0 - layer * 0.8 / layers
        y = 0.4 + layer * step
        for k in range(4):  # a cone of four discs
            parts.append(stick((0, y + k * step / 4, 0), (0, y + (k + 1) * step / 4, 0), outer * (1 - k * 0.2), (0.08, 0.36 + 0.03 * k, 0.16)))
        count = 9 - layer
        parts.append(loop(count, lambda i: sphere(0.07, BAUBLES[(i + layer) % len(BAUBLES)], (
            outer * math.cos(math.tau * i / count + layer), y, outer * math.sin(math.tau * i / count + layer)))))
    star = loop(5, lambda i: transform_shape(
        stick((0, 0, 0), (0, 0.2, 0), 0.035, (1.0, 0.85, 0.2)), rotation_matrix(math.tau * i / 5, (0, 0, 1), (0, 0, 0))))
    parts.append(transform_shape(star, translation_matrix((0, height + 0.15, 0))))
    return concat_shapes(*parts)


@register("snowflakes in the air")
def snowfall(flakes: int = 60) -> Shape:
    return concat_shapes(*[
        sphere(random.uniform(0.015, 0.035), (1, 1, 1), (random.uniform(-2.5, 2.5), random.uniform(0.3, 3.5), random.uniform(-1.5, 1.5)))
        for _ in range(flakes)
    ])


@register()
def winter_scene() -> Shape:
    ground = stick((0, -0.2, 0), (0, 0, 0), 3.0, SNOW)
    man = transform_shape(library_call('snowman'), translation_matrix((-0.9, 0, 0.3)))
    tree = transform_shape(library_call('christmas_tree'), translation_matrix((1.1, 0, -0.3)))
    return concat_shapes(ground, man, tree, library_call('snowfall'))
