"""a football stadium with tiered stands, floodlights, goals and two teams in formation"""
from helper import *
from itertools import chain, count, product, starmap, takewhile
from typing import Iterable
import math

FORMATIONS = {'home': '4-3-3', 'away': '4-4-2'}
KIT = {'home': (0.85, 0.1, 0.1), 'away': (0.1, 0.2, 0.7)}
L, W = 20.0, 13.0
WHITE = (1.0, 1.0, 1.0)


def block(sx, sy, sz, x=0.0, y=0.0, z=0.0, color=WHITE) -> Shape:
    return transform_shape(primitive_call('cube', shape_kwargs={'scale': (sx, sy, sz)}, color=color), translation_matrix((x, y, z)))


def flat(shapes: Iterable[Shape]) -> Shape:
    return list(chain.from_iterable(shapes))


def positions(formation: str):
    """Yield (x, z) on the left half; goalkeeper first."""
    lines = [1, *map(int, formation.split('-'))]
    for depth, n in enumerate(lines):
        x = -L / 2 + 0.8 + depth * (L / 2 - 1.5) / len(lines)
        for k in range(n):
            yield x, (k - (n - 1) / 2) * W * 0.8 / max(n, 2)


@register()
def player(color=(0.85, 0.1, 0.1), skin=(0.85, 0.65, 0.5)) -> Shape:
    torso = primitive_call('cylinder', shape_kwargs={'radius': 0.13, 'p0': (0, 0.35, 0), 'p1': (0, 0.75, 0)}, color=color)
    legs = [primitive_call('cylinder', shape_kwargs={'radius': 0.05, 'p0': (0, 0, z), 'p1': (0, 0.38, z)}, color=WHITE) for z in (-0.07, 0.07)]
    head = transform_shape(primitive_call('sphere', shape_kwargs={'radius': 0.11}, color=skin), translation_matrix((0, 0.87, 0)))
    return flat([torso, head, *legs])


@register()
def team(side: str = 'home') -> Shape:
    mirror = 1 if side == 'home' else -1
    spots = list(positions(FORMATIONS[side]))
    assert len(spots) == 11, f"{side}: {len(spots)} players"
    return flat(transform_shape(library_call('player', color=KIT[side]), translation_matrix((mirror * x, 0, mirror * z))) for x, z in spots)


@register()
def pitch(stripes: int = 10) -> Shape:
    grass = starmap(lambda i, g: block(L / stripes, 0.1, W, x=-L / 2 + (i + 0.5) * L / stripes, y=-0.05, color=(0.2, g, 0.2)),
                    ((i, 0.55 if i % 2 else 0.62) for i in range(stripes)))
    lines = [block(0.08, 0.02, W), *(block(L, 0.02, 0.08, z=s * W / 2) for s in (-1, 1)), *(block(0.08, 0.02, W, x=s * L / 2) for s in (-1, 1))]
    n = 32
    circle = loop(n, lambda i: transform_shape(block(0.08, 0.02, 0.4, x=1.8), rotation_matrix(i * math.tau / n, (0, 1, 0), (0, 0, 0))))
    return flat([*grass, *lines, circle])


@register()
def goal(sign: int = 1, width: float = 2.2, height: float = 1.0) -> Shape:
    x = sign * L / 2
    bar = lambda a, b: primitive_call('cylinder', shape_kwargs={'radius': 0.05, 'p0': a, 'p1': b}, color=WHITE)
    return flat([bar((x, 0, -width / 2), (x, height, -width / 2)), bar((x, 0, width / 2), (x, height, width / 2)), bar((x, height, -width / 2), (x, height, width / 2))])


@register()
def stands(rise: float = 0.45, run: float = 0.7, max_height: float = 3.0) -> Shape:
    heights = takewhile(lambda h: h <= max_height, count(rise, rise))
    tiers = []
    for k, h in enumerate(heights):
        d = 1.5 + k * run
        color = (0.5 + 0.04 * (k % 3), 0.5, 0.55)
        for s in (-1, 1):
            tiers.append(block(L + 2 * d, h, run, y=h / 2, z=s * (W / 2 + d), color=color))
            tiers.append(block(run, h, W + 2 * d, x=s * (L / 2 + d), y=h / 2, color=color))
    return flat(tiers)


@register()
def floodlight(height: float = 7.0) -> Shape:
    mast = primitive_call('cylinder', shape_kwargs={'radius': 0.12, 'p0': (0, 0, 0), 'p1': (0, height, 0)}, color=(0.6, 0.6, 0.62))
    lamps = [block(0.3, 0.3, 0.15, x=0.4 * i, y=height + 0.4 * j, color=(1, 1, 0.85)) for i, j in product((-1, 0, 1), (0, 1))]
    return flat([mast, *lamps])


@register()
def stadium() -> Shape:
    lights = [transform_shape(library_call('floodlight'), translation_matrix((sx * (L / 2 + 6), 0, sz * (W / 2 + 6)))) for sx, sz in product((-1, 1), repeat=2)]
    ball = transform_shape(primitive_call('sphere', shape_kwargs={'radius': 0.1}, color=WHITE), translation_matrix((0, 0.1, 0)))
    goals = [library_call('goal', sign=s) for s in (-1, 1)]
    return concat_shapes(library_call('pitch'), library_call('stands'), *goals, *map(lambda s: library_call('team', side=s), FORMATIONS), ball, *lights)
