"""a Japanese zen garden: raked sand, three rocks, a stone lantern and a small bamboo fence"""
from helper import *
import math
from typing import NamedTuple


class Rock(NamedTuple):
    x: float
    z: float
    size: float
    lobes: int = 3


ROCKS = [Rock(-1.2, 0.3, 0.45, 4), Rock(0.9, -0.6, 0.3), Rock(1.5, 0.9, 0.2, lobes=2)]
STONE = (0.42, 0.42, 0.44)
SAND = (0.88, 0.84, 0.74)


@register("a bed of sand in a wooden frame")
def sand_bed(width: float = 5.0, depth: float = 3.4) -> Shape:
    sand = primitive_call('cube', shape_kwargs={'scale': (width, 0.1, depth)}, color=SAND)
    wood = (0.36, 0.24, 0.15)
    rails = []
    for s in (-1, 1):
        rails.append(transform_shape(primitive_call('cube', shape_kwargs={'scale': (width + 0.2, 0.18, 0.1)}, color=wood),
                                     translation_matrix((0, 0.02, s * (depth / 2 + 0.05)))))
        rails.append(transform_shape(primitive_call('cube', shape_kwargs={'scale': (0.1, 0.18, depth)}, color=wood),
                                     translation_matrix((s * (width / 2 + 0.05), 0.02, 0))))
    return concat_shapes(sand, *rails)


@register("a ring of ripples, raked around a rock")
def ripple(radius: float = 0.6, pieces: int = 24) -> Shape:
    def arc(i: int) -> Shape:
        a0, a1 = (2 * math.pi * k / pieces for k in (i, i + 1))
        return primitive_call('cylinder', shape_kwargs={
            'radius': 0.015,
            'p0': (radius * math.cos(a0), 0.05, radius * math.sin(a0)),
            'p1': (radius * math.cos(a1), 0.05, radius * math.sin(a1)),
        }, color=(0.8, 0.75, 0.64))
    return loop(pieces, arc)


@register("straight furrows along x, interrupted where a rock has its rings")
def furrows(width: float = 5.0, depth: float = 3.4, count: int = 18) -> Shape:
    lines = []
    for k in range(count):
        z = -depth / 2 + (k + 0.5) * depth / count
        start = -width / 2 + 0.05
        # obstacles along this line, from left to right
        cuts = []
        for rock in sorted(ROCKS, key=lambda r: r.x):
            reach = rock.size + 0.35
            if abs(z - rock.z) < reach:
                half = math.sqrt(reach ** 2 - (z - rock.z) ** 2)
                cuts.append((rock.x - half, rock.x + half))
        for left, right in cuts + [(width / 2 - 0.05, None)]:
            if left > start:
                lines.append(primitive_call('cylinder', shape_kwargs={'radius': 0.012, 'p0': (start, 0.05, z), 'p1': (left, 0.05, z)},
                                            color=(0.82, 0.77, 0.66)))
            if right is not None:
                start = max(start, right)
    return concat_shapes(*lines)


@register()
def rock(size: float = 0.4, lobes: int = 3) -> Shape:
    body = primitive_call('sphere', shape_kwargs={'radius': size}, color=STONE)
    extra = loop(lobes, lambda i: transform_shape(
        primitive_call('sphere', shape_kwargs={'radius': size * (0.7 - 0.1 * i)}, color=(0.38, 0.4, 0.38)),
        translation_matrix((size * 0.6 * math.cos(2.4 * i), -0.05 * i, size * 0.6 * math.sin(2.4 * i)))))
    return concat_shapes(body, extra)


@register()
def stone_lantern(height: float = 1.0) -> Shape:
    # (radius, from, to) as fractions of the height
    profile = [(0.26, 0.0, 0.1), (0.1, 0.1, 0.5), (0.24, 0.5, 0.58), (0.34, 0.8, 0.88), (0.2, 0.88, 0.95)]
    rings = [primitive_call('cylinder', shape_kwargs={'radius': r * height, 'p0': (0, a * height, 0), 'p1': (0, b * height, 0)}, color=STONE)
             for r, a, b in profile]
    fire = transform_shape(primitive_call('cube', shape_kwargs={'scale': (0.28 * height, 0.22 * height, 0.28 * height)}, color=(1, 0.8, 0.4)),
                           translation_matrix((0, 0.69 * height, 0)))
    return concat_shapes(*rings, fire)


@register()
def bamboo_fence(length: float = 5.2, canes: int = 40) -> Shape:
    step = length / canes
    green = lambda i: (0.55 + 0.05 * (i % 3), 0.58, 0.25)
    upright = loop(canes, lambda i: primitive_call('cylinder', shape_kwargs={
        'radius': step * 0.42, 'p0': ((i + 0.5) * step - length / 2, 0, 0), 'p1': ((i + 0.5) * step - length / 2, 0.9 + 0.04 * (i % 2), 0)}, color=green(i)))
    ties = [primitive_call('cylinder', shape_kwargs={'radius': 0.04, 'p0': (-length / 2, y, 0.06), 'p1': (length / 2, y, 0.06)}, color=(0.4, 0.3, 0.15))
            for y in (0.25, 0.7)]
    return concat_shapes(upright, *ties)


@register()
def zen_garden() -> Shape:
    scene = [library_call('sand_bed'), library_call('furrows')]
    for r in ROCKS:
        place = translation_matrix((r.x, 0, r.z))
        rings = [library_call('ripple', radius=r.size + 0.1 + 0.1 * k) for k in range(3)]
        scene.append(transform_shape(concat_shapes(library_call('rock', size=r.size, lobes=r.lobes), *rings), place))
    scene.append(transform_shape(library_call('stone_lantern'), translation_matrix((2.1, 0.05, -1.2))))
    scene.append(transform_shape(library_call('bamboo_fence'), translation_matrix((0, -0.05, -1.9))))
    return concat_shapes(*scene)
