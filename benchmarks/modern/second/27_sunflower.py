"""
a sunflower in a terracotta pot, with seeds in Vogel's spiral and a bee
"""
from helper import *
import math
from itertools import count, islice
from typing import NamedTuple

GOLDEN_ANGLE = math.pi * (3 - 5 ** 0.5)


class Polar(NamedTuple):
    r: float
    theta: float

    @property
    def xy(self) -> tuple[float, float]:
        return self.r * math.cos(self.theta), self.r * math.sin(self.theta)


def vogel(c: float = 0.06):
    """the seeds of the head, without end"""
    yield from (Polar(c * math.sqrt(n), n * GOLDEN_ANGLE) for n in count())


def mix(a, b, t):
    return tuple(p * (1 - t) + q * t for p, q in zip(a, b))


@register()
def seed_disc(n: int = 160, c: float = 0.06) -> Shape:
    rmax = c * math.sqrt(n)

    def seed(p: Polar) -> Shape:
        t = p.r / rmax
        bump = 0.12 * (1 - t * t)
        s = primitive_call('sphere', {'radius': c * (0.55 + 0.25 * t)}, color=mix((0.35, 0.3, 0.1), (0.3, 0.16, 0.06), t))
        x, y = p.xy
        return transform_shape(s, translation_matrix((x, y, bump)))

    disc = primitive_call('cylinder', {'radius': rmax, 'p0': (0, 0, -0.08), 'p1': (0, 0, 0)}, color=(0.28, 0.18, 0.08))
    return concat_shapes(disc, *map(seed, islice(vogel(c), n)))


@register()
def petal(length: float = 0.6, width: float = 0.2, segments: int = 4, color: tuple = (0.98, 0.78, 0.1)) -> Shape:
    out, x, bend = [], 0.0, 0.0
    step = length / segments
    for i in range(segments):
        w = width * math.sin(math.pi * (i + 0.8) / (segments + 0.6))
        bend += 0.06
        piece = primitive_call('cube', {'scale': (step * 1.1, w, 0.02)}, color=mix(color, (0.95, 0.55, 0.05), 1 - i / segments))
        piece = transform_shape(piece, rotation_matrix(-bend, (0, 1, 0), (0, 0, 0)))
        out.append(transform_shape(piece, translation_matrix((x + step / 2, 0, bend * 0.4))))
        x += step
    return concat_shapes(*out)


@register()
def flower_head(petals: int = 21, rows: int = 2) -> Shape:
    disc = library_call('seed_disc')
    radius = compute_shape_sizes(disc)[0] / 2 - 0.08
    ring = []
    for row in range(rows):
        for k in range(petals):
            a = 2 * math.pi * (k + row / rows) / petals
            p = transform_shape(library_call('petal', length=0.65 - 0.1 * row), translation_matrix((radius, 0, -0.05 * row)))
            ring.append(transform_shape(p, rotation_matrix(a, (0, 0, 1), (0, 0, 0))))
    return concat_shapes(disc, *ring)


@register()
def leaf(length: float = 0.9) -> Shape:
    blades = [(t / 6, 0.35 * math.sin(math.pi * (t + 0.5) / 6.5)) for t in range(6)]
    return concat_shapes(*(transform_shape(primitive_call('cube', {'scale': (length / 6, 0.03, max(w, 0.04))}, color=(0.2, 0.5, 0.15)),
                                           translation_matrix((t * length, 0.1 * math.sin(math.pi * t), 0))) for t, w in blades))


@register()
def stalk(height: float = 3.0, n: int = 10, lean: float = 0.25) -> Shape:
    pts = [(lean * (i / n) ** 2, height * i / n, 0) for i in range(n + 1)]
    stem = [primitive_call('cylinder', {'radius': 0.07, 'p0': p, 'p1': q}, color=(0.3, 0.55, 0.2)) for p, q in zip(pts, pts[1:])]
    for j, k in enumerate(range(3, n - 1, 2)):
        l = transform_shape(library_call('leaf'), rotation_matrix(0.5, (0, 0, 1), (0, 0, 0)))
        l = transform_shape(l, rotation_matrix(j * GOLDEN_ANGLE, (0, 1, 0), (0, 0, 0)))
        stem.append(transform_shape(l, translation_matrix(pts[k])))
    return concat_shapes(*stem)


@register()
def bee() -> Shape:
    stripes = [primitive_call('cylinder', {'radius': 0.07, 'p0': (i * 0.05, 0, 0), 'p1': ((i + 1) * 0.05, 0, 0)},
                              color=((0.95, 0.8, 0.1), (0.1, 0.1, 0.1))[i % 2]) for i in range(4)]
    head = transform_shape(primitive_call('sphere', {'radius': 0.06}, color=(0.1, 0.1, 0.1)), translation_matrix((0.24, 0, 0)))
    wings = [transform_shape(primitive_call('cube', {'scale': (0.1, 0.01, 0.16)}, color=(0.85, 0.92, 0.98)), translation_matrix((0.1, 0.08, s * 0.1))) for s in (-1, 1)]
    return concat_shapes(*stripes, head, *wings)


@register()
def potted_sunflower() -> Shape:
    pot = loop(6, lambda i: primitive_call('cylinder', {'radius': 0.5 + 0.05 * i, 'p0': (0, -1 + i / 6, 0), 'p1': (0, -1 + (i + 1) / 6, 0)}, color=(0.75, 0.38, 0.22)))
    soil = primitive_call('cylinder', {'radius': 0.7, 'p0': (0, -0.05, 0), 'p1': (0, 0.02, 0)}, color=(0.2, 0.13, 0.08))
    head = transform_shape(library_call('flower_head'), rotation_matrix(-0.25, (1, 0, 0), (0, 0, 0)))
    head = transform_shape(head, translation_matrix((0.25, 3.1, 0.12)))
    visitor = transform_shape(library_call('bee'), translation_matrix((0.3, 3.4, 0.7)))
    return concat_shapes(pot, soil, library_call('stalk'), head, visitor)
