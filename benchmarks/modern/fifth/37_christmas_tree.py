"""a Christmas tree wrapped in a spiral of coloured lights, with ornaments, a star and a toy train around it"""
from helper import *
from enum import Flag, auto
from functools import partial, total_ordering
from itertools import accumulate, chain, cycle, repeat, starmap, zip_longest
import math
import random


class Validated:
    """A descriptor that keeps a number in a range."""

    def __init__(self, low: float, high: float):
        self.low, self.high = low, high

    def __set_name__(self, owner, name):
        self.slot = f'_{name}'

    def __get__(self, obj, owner=None):
        return self if obj is None else getattr(obj, self.slot)

    def __set__(self, obj, value):
        setattr(obj, self.slot, max(self.low, min(self.high, value)))


@total_ordering
class Ornament:
    size = Validated(0.03, 0.14)
    weight = Validated(0.0, 1.0)

    def __init__(self, size, weight, color, kind='ball'):
        self.size, self.weight, self.color, self.kind = size, weight, color, kind

    def __eq__(self, other):
        return isinstance(other, Ornament) and self.weight == other.weight

    def __lt__(self, other):
        return self.weight < other.weight

    def __repr__(self):
        return f'{self.kind}({self.size:.2f}, {self.weight:.2f})'


class Decor(Flag):
    LIGHTS = auto()
    BALLS = auto()
    STAR = auto()
    TINSEL = auto()
    ALL = LIGHTS | BALLS | STAR | TINSEL


BULBS = [(1.0, 0.2, 0.2), (0.2, 1.0, 0.35), (0.3, 0.5, 1.0), (1.0, 0.85, 0.2), (1.0, 0.4, 0.9)]
ball = lambda p, r, c: transform_shape(primitive_call('sphere', shape_kwargs={'radius': r}, color=c), translation_matrix(p))
wire = lambda a, b, r=0.01, c=(0.1, 0.3, 0.12): primitive_call('cylinder', shape_kwargs={'radius': r, 'p0': a, 'p1': b}, color=c)


def running_mean():
    """A coroutine: send numbers, get the mean so far."""
    total, n, mean = 0.0, 0, None
    while True:
        value = yield mean
        total, n = total + value, n + 1
        mean = total / n


def cone_spiral(height, radius, turns, n, base=0.5):
    """Points at about equal distances on a cone: the angle goes with the square root."""
    for k in range(n):
        t = math.sqrt((k + 0.5) / n)
        a = turns * 2 * math.pi * t
        yield radius * t * math.cos(a), base + height * (1 - t), radius * t * math.sin(a)


@register()
def foliage(height: float = 3.0, radius: float = 1.15, layers: int = 9, needles: int = 26) -> Shape:
    trunk = wire((0, 0, 0), (0, 0.6, 0), 0.14, (0.35, 0.24, 0.14))
    tones = cycle([(0.08, 0.35, 0.15), (0.1, 0.42, 0.18), (0.06, 0.3, 0.14)])
    drops = accumulate(repeat(height / layers, layers - 1), initial=0.5)
    out = [trunk]
    for k, (y, tone) in enumerate(zip(drops, tones)):
        r = radius * (1 - k / layers)
        spin = 0.37 * k
        out += starmap(partial(wire, c=tone), (((0, y + height / layers * 1.3, 0), (r * math.cos(a), y, r * math.sin(a)), 0.05) for a in (spin + 2 * math.pi * j / needles for j in range(needles))))
    return concat_shapes(*out)


@register()
def light_chain(bulbs: int = 90, turns: float = 7.0, height: float = 3.0, radius: float = 1.22) -> Shape:
    points = list(cone_spiral(height, radius, turns, bulbs))
    cables = (wire(a, b, 0.008) for a, b in zip(points, points[1:]))
    lamps = (ball(p, 0.035 if i % 4 else 0.05, c) for i, (p, c) in enumerate(zip(points, cycle(BULBS))))
    return concat_shapes(*chain(cables, lamps))


@register()
def ornaments(count: int = 24, height: float = 3.0, radius: float = 1.2, seed: int = 24) -> Shape:
    rnd = random.Random(seed)
    stock = [Ornament(rnd.uniform(0.02, 0.18), rnd.random(), rnd.choice([(0.8, 0.1, 0.15), (0.9, 0.75, 0.3), (0.85, 0.87, 0.9)]), rnd.choice(('ball', 'drop'))) for _ in range(count)]
    mean = running_mean()
    next(mean)
    out = []
    # light ornaments at the top, heavy ones at the bottom
    for o, (x, y, z) in zip(sorted(stock), cone_spiral(height, radius, 4.2, count)):
        average = mean.send(o.size)
        hang = y - o.size - 0.05
        out.append(wire((x, y, z), (x, hang, z), 0.004, (0.8, 0.8, 0.8)))
        body = ball((x, hang, z), o.size * 0.8, o.color)
        if o.kind == 'drop':
            body = concat_shapes(body, wire((x, hang, z), (x, hang - o.size * 1.8, z), o.size * 0.25, o.color))
        if o.size > average:
            body = concat_shapes(body, ball((x, hang + o.size * 0.8, z), o.size * 0.25, (0.9, 0.8, 0.4)))
        out.append(body)
    return concat_shapes(*out)


@register()
def star(points: int = 5, outer: float = 0.28, inner: float = 0.11) -> Shape:
    radii = chain.from_iterable(repeat((outer, inner), points))
    rim = [(r * math.sin(math.pi * k / points), r * math.cos(math.pi * k / points), 0.0) for k, r in enumerate(radii)]
    gold = (1.0, 0.85, 0.25)
    edges = [wire(a, b, 0.025, gold) for a, b in zip_longest(rim, rim[1:], fillvalue=rim[0])]
    spokes = [wire((0, 0, z), p, 0.02, gold) for p in rim[::2] for z in (-0.06, 0.06)]
    return concat_shapes(*edges, *spokes)


@register()
def toy_train(wagons: int = 4, track_radius: float = 1.6, spacing: float = 0.36) -> Shape:
    rails = loop(48, lambda i: concat_shapes(*[wire((r * math.cos(i * math.pi / 24), 0.02, r * math.sin(i * math.pi / 24)), (r * math.cos((i + 1) * math.pi / 24), 0.02, r * math.sin((i + 1) * math.pi / 24)), 0.012, (0.5, 0.5, 0.52)) for r in (track_radius - 0.06, track_radius + 0.06)]))
    cars = []
    for k in range(wagons + 1):
        body = primitive_call('cube', shape_kwargs={'scale': (0.26, 0.14, 0.14)}, color=(0.75, 0.1, 0.1) if k == 0 else BULBS[k % len(BULBS)])
        extra = [wire((0.07, 0.05, 0), (0.07, 0.17, 0), 0.03, (0.1, 0.1, 0.1)), ball((0.07, 0.25, 0), 0.05, (0.95, 0.95, 0.95))] if k == 0 else [ball((0.05 * (j - 1), 0.09, 0), 0.04, BULBS[(k + j) % 5]) for j in range(3)]
        wheels = [wire((x, -0.07, z - 0.01), (x, -0.07, z + 0.01), 0.045, (0.15, 0.15, 0.15)) for x in (-0.08, 0.08) for z in (-0.08, 0.08)]
        a = -k * spacing / track_radius
        cars.append(transform_shape(concat_shapes(body, *extra, *wheels), rotation_matrix(-a, (0, 1, 0), (0, 0, 0)) @ translation_matrix((track_radius, 0.14, 0)) @ rotation_matrix(-math.pi / 2, (0, 1, 0), (0, 0, 0))))
    return concat_shapes(rails, *cars)


@register()
def christmas(decor: int = Decor.ALL.value) -> Shape:
    wanted = Decor(decor)
    parts = [library_call('foliage'), library_call('toy_train')]
    if Decor.LIGHTS in wanted:
        parts.append(library_call('light_chain'))
    if wanted & Decor.BALLS:
        parts.append(library_call('ornaments'))
    if Decor.STAR in wanted:
        parts.append(transform_shape(library_call('star'), translation_matrix((0, 3.85, 0))))
    floor = primitive_call('cylinder', shape_kwargs={'radius': 2.2, 'p0': (0, -0.08, 0), 'p1': (0, 0, 0)}, color=(0.55, 0.12, 0.14))
    return concat_shapes(floor, *parts)
