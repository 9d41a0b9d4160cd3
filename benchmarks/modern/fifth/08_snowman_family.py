"""a family of snowmen in a snowy yard with a picket fence"""
from helper import *
import math
import random
from typing import NamedTuple


class Member(NamedTuple):
    name: str
    height: float
    x: float
    scarf: tuple[float, float, float]
    hat: str = 'top'


FAMILY = (
    Member('father', 2.4, -1.6, (0.75, 0.1, 0.15)),
    Member('mother', 2.1, 0.2, (0.2, 0.35, 0.75), hat='beanie'),
    Member('child', 1.3, 1.6, (0.2, 0.6, 0.3), hat='beanie'),
    Member('baby', 0.9, 2.6, (0.9, 0.7, 0.2), hat='none'),
)
SNOW = (0.96, 0.97, 1.0)
COAL = (0.08, 0.08, 0.09)


def sphere_at(radius, center, color):
    s = primitive_call('sphere', shape_kwargs={'radius': radius}, color=color)
    return transform_shape(s, translation_matrix(center))


@register()
def hat(kind: str = 'top', size: float = 0.3, color: tuple = (0.1, 0.1, 0.12)) -> Shape:
    if kind == 'top':
        brim = primitive_call('cylinder', shape_kwargs={'radius': size * 1.4, 'p0': (0, 0, 0), 'p1': (0, size * 0.12, 0)}, color=COAL)
        crown = primitive_call('cylinder', shape_kwargs={'radius': size * 0.85, 'p0': (0, 0, 0), 'p1': (0, size * 1.4, 0)}, color=COAL)
        band = primitive_call('cylinder', shape_kwargs={'radius': size * 0.88, 'p0': (0, size * 0.12, 0), 'p1': (0, size * 0.35, 0)}, color=color)
        return concat_shapes(brim, crown, band)
    if kind == 'beanie':
        cap = loop(5, lambda i: primitive_call('cylinder', shape_kwargs={
            'radius': size * math.cos(i * 0.28), 'p0': (0, size * math.sin(i * 0.28), 0), 'p1': (0, size * math.sin((i + 1) * 0.28), 0)}, color=color))
        return concat_shapes(cap, sphere_at(size * 0.25, (0, size * 1.1, 0), (1, 1, 1)))
    return []


@register()
def snowman(height: float = 2.0, scarf: tuple = (0.8, 0.1, 0.1), hat_kind: str = 'top', buttons: int = 3) -> Shape:
    # three balls whose radii are 3 : 2.2 : 1.5 and overlap a little
    unit = height / (2 * (3 + 2.2 + 1.5) * 0.9)
    radii = [3 * unit, 2.2 * unit, 1.5 * unit]
    centers, y = [], 0.0
    for r in radii:
        centers.append(y + r * 0.9)
        y += 2 * r * 0.9
    balls = [sphere_at(r, (0, c, 0), SNOW) for r, c in zip(radii, centers)]
    head_r, head_y = radii[2], centers[2]
    eyes = [sphere_at(head_r * 0.13, (s * head_r * 0.35, head_y + head_r * 0.25, head_r * 0.9), COAL) for s in (-1, 1)]
    mouth = [sphere_at(head_r * 0.08, (head_r * 0.45 * math.sin(a), head_y - head_r * 0.4 * math.cos(a) + 0.02, head_r * 0.88), COAL)
             for a in [(-2 + k) * 0.35 for k in range(5)]]
    nose = loop(5, lambda i: primitive_call('cylinder', shape_kwargs={
        'radius': head_r * 0.15 * (1 - i / 5), 'p0': (0, head_y, head_r * (0.9 + 0.15 * i)), 'p1': (0, head_y, head_r * (0.9 + 0.15 * (i + 1)))}, color=(0.95, 0.5, 0.1)))
    front = [sphere_at(radii[1] * 0.1, (0, centers[1] + radii[1] * 0.5 * (1 - i), radii[1] * math.cos(0.5 * (1 - i))), COAL) for i in range(buttons)]
    neck = primitive_call('cylinder', shape_kwargs={'radius': head_r * 0.85, 'p0': (0, head_y - head_r, 0), 'p1': (0, head_y - head_r * 0.65, 0)}, color=scarf)
    tail = transform_shape(primitive_call('cube', shape_kwargs={'scale': (head_r * 0.4, head_r * 1.3, 0.05)}, color=scarf), translation_matrix((head_r * 0.4, head_y - head_r * 1.4, radii[1] * 0.9)))
    arms = [primitive_call('cylinder', shape_kwargs={'radius': 0.02 * height, 'p0': (s * radii[1] * 0.8, centers[1], 0), 'p1': (s * radii[1] * 2.1, centers[1] + radii[1] * 0.7, 0.1)}, color=(0.35, 0.22, 0.12)) for s in (-1, 1)]
    top = transform_shape(library_call('hat', kind=hat_kind, size=head_r * 0.8, color=scarf), translation_matrix((0, head_y + head_r * 0.75, 0)))
    return concat_shapes(*balls, *eyes, *mouth, nose, *front, neck, tail, *arms, top)


@register()
def picket_fence(length: float = 8.0, spacing: float = 0.3, height: float = 0.8) -> Shape:
    count = int(length / spacing) + 1
    white = (0.9, 0.9, 0.88)
    def picket(i):
        x = -length / 2 + i * spacing
        board = transform_shape(primitive_call('cube', shape_kwargs={'scale': (0.14, height, 0.04)}, color=white), translation_matrix((x, height / 2, 0)))
        tip = primitive_call('cube', shape_kwargs={'scale': (0.1, 0.1, 0.04)}, color=white)
        tip = transform_shape(transform_shape(tip, rotation_matrix(math.pi / 4, (0, 0, 1), (0, 0, 0))), translation_matrix((x, height, 0)))
        snow_cap = sphere_at(0.05, (x, height + 0.07, 0), SNOW)
        return concat_shapes(board, tip, snow_cap)
    rails = [transform_shape(primitive_call('cube', shape_kwargs={'scale': (length, 0.08, 0.03)}, color=white), translation_matrix((0, height * f, -0.03))) for f in (0.3, 0.7)]
    return concat_shapes(loop(count, picket), *rails)


@register()
def snowfall(flakes: int = 90, width: float = 8.0, height: float = 4.5) -> Shape:
    def flake(_):
        p = (random.uniform(-width / 2, width / 2), random.uniform(0.2, height), random.uniform(-3, 3))
        return sphere_at(random.choice((0.02, 0.03, 0.04)), p, (1, 1, 1))
    return loop(flakes, flake)


@register()
def winter_yard() -> Shape:
    snowmen = [transform_shape(library_call('snowman', height=m.height, scarf=m.scarf, hat_kind=m.hat, buttons=max(2, int(m.height * 1.5))), translation_matrix((m.x, 0, 0.3 * i)))
               for i, m in enumerate(FAMILY)]
    ground = transform_shape(primitive_call('cube', shape_kwargs={'scale': (9, 0.2, 7)}, color=(0.9, 0.93, 0.98)), translation_matrix((0, -0.1, 0)))
    fence = transform_shape(library_call('picket_fence'), translation_matrix((0, 0, -1.8)))
    return concat_shapes(ground, fence, *snowmen, library_call('snowfall'))
