"""a round library tower with a spiral staircase, curved bookshelves and a reading globe"""
from helper import *
from functools import lru_cache, reduce
from itertools import accumulate, chain, takewhile
from operator import matmul
import math
import random
import statistics

RNG = random.Random(1851)
LEATHER = [(0.45, 0.12, 0.1), (0.15, 0.3, 0.2), (0.15, 0.2, 0.4), (0.5, 0.35, 0.15), (0.3, 0.15, 0.3)]


def compose(*poses):
    return reduce(matmul, poses, identity_matrix())


def around_y(angle):
    return rotation_matrix(angle, (0, 1, 0), (0, 0, 0))


@lru_cache(maxsize=None)
def catmull_rom(p0, p1, p2, p3, n=6):
    """Points of one Catmull-Rom piece, without its end."""
    def component(a, b, c, d, t):
        return 0.5 * (2 * b + (c - a) * t + (2 * a - 5 * b + 4 * c - d) * t ** 2 + (3 * b - a - 3 * c + d) * t ** 3)
    return tuple(tuple(component(*axis, k / n) for axis in zip(p0, p1, p2, p3)) for k in range(n))


def smooth(points, n=6):
    padded = [points[0], *points, points[-1]]
    pieces = (catmull_rom(*padded[i:i + 4], n) for i in range(len(padded) - 3))
    return [*chain.from_iterable(pieces), points[-1]]


@register()
def step(inner: float = 0.2, outer: float = 1.3, rise: float = 0.2, sweep: float = 0.35) -> Shape:
    wedges = 4
    def wedge(i):
        r = inner + (outer - inner) * (i + 0.5) / wedges
        plank = primitive_call('cube', shape_kwargs={'scale': ((outer - inner) / wedges, 0.06, r * sweep * 1.15)}, color=(0.48, 0.32, 0.18))
        return transform_shape(plank, translation_matrix((r, 0, 0)))
    baluster = primitive_call('cylinder', shape_kwargs={'radius': 0.02, 'p0': (outer - 0.06, 0, 0), 'p1': (outer - 0.06, 0.9, 0)}, color=(0.12, 0.1, 0.1))
    return concat_shapes(loop(wedges, wedge), baluster)


@register()
def spiral(steps: int = 28, rise: float = 0.2, sweep: float = 0.35, outer: float = 1.3) -> Shape:
    treads = loop(steps, lambda i: transform_shape(library_call('step', outer=outer, sweep=sweep), compose(around_y(-i * sweep), translation_matrix((0, (i + 1) * rise, 0)))))
    rail_points = [((outer - 0.06) * math.cos(i * sweep), (i + 1) * rise + 0.9, (outer - 0.06) * math.sin(i * sweep)) for i in range(steps)]
    path = smooth(rail_points, n=3)
    rail = [primitive_call('cylinder', shape_kwargs={'radius': 0.035, 'p0': a, 'p1': b}, color=(0.4, 0.25, 0.13)) for a, b in zip(path, path[1:])]
    pole = primitive_call('cylinder', shape_kwargs={'radius': 0.12, 'p0': (0, 0, 0), 'p1': (0, steps * rise + 1.1, 0)}, color=(0.2, 0.15, 0.12))
    return concat_shapes(pole, treads, *rail)


def book_widths(limit: float):
    """Widths of books that fit a shelf of that length."""
    stream = iter(lambda: RNG.triangular(0.03, 0.09, 0.05), None)
    pairs = takewhile(lambda pair: pair[1] < limit, running(stream))
    return [width for width, _ in pairs]


def running(stream):
    total = 0.0
    for width in stream:
        total += width
        yield width, total


@register()
def bookcase(shelves: int = 5, width: float = 1.1, gap: float = 0.42) -> Shape:
    wood = (0.36, 0.22, 0.12)
    boards = loop(shelves + 1, lambda i: transform_shape(primitive_call('cube', shape_kwargs={'scale': (width, 0.04, 0.3)}, color=wood), translation_matrix((0, i * gap, 0))))
    sides = [transform_shape(primitive_call('cube', shape_kwargs={'scale': (0.05, shelves * gap + 0.04, 0.32)}, color=wood), translation_matrix((s * width / 2, shelves * gap / 2, 0))) for s in (-1, 1)]
    books = []
    for shelf in range(shelves):
        widths = book_widths(width - 0.12)
        offsets = [0.0, *accumulate(widths)]
        mean = statistics.fmean(widths)
        for k, (w, x) in enumerate(zip(widths, offsets)):
            h = gap * (0.62 + 0.25 * ((k * 37 + shelf * 11) % 10) / 10)
            color = LEATHER[(k + shelf) % len(LEATHER)]
            book = primitive_call('cube', shape_kwargs={'scale': (w * 0.93, h, 0.22 if w > mean else 0.18)}, color=color)
            books.append(transform_shape(book, translation_matrix((-width / 2 + 0.06 + x + w / 2, shelf * gap + 0.02 + h / 2, 0.02))))
    return concat_shapes(boards, *sides, *books)


@register()
def globe(radius: float = 0.35, meridians: int = 6) -> Shape:
    ocean = primitive_call('sphere', shape_kwargs={'radius': radius}, color=(0.3, 0.5, 0.65))
    def meridian(i):
        ring = [(radius * 1.02 * math.cos(t), radius * 1.02 * math.sin(t), 0) for t in (2 * math.pi * k / 24 for k in range(25))]
        arc = concat_shapes(*[primitive_call('cylinder', shape_kwargs={'radius': 0.006, 'p0': a, 'p1': b}, color=(0.85, 0.7, 0.35)) for a, b in zip(ring, ring[1:])])
        return transform_shape(arc, around_y(math.pi * i / meridians))
    ball = transform_shape(concat_shapes(ocean, loop(meridians, meridian)), rotation_matrix(math.radians(23.4), (0, 0, 1), (0, 0, 0)))
    stand = loop(3, lambda i: primitive_call('cylinder', shape_kwargs={'radius': 0.03, 'p0': (0, -radius, 0), 'p1': (0.35 * math.cos(2.1 * i), -radius - 0.6, 0.35 * math.sin(2.1 * i))}, color=(0.3, 0.18, 0.1)))
    return transform_shape(concat_shapes(ball, stand), translation_matrix((0, radius + 0.6, 0)))


@register()
def library_tower(cases: int = 9, radius: float = 3.2, floors: int = 2) -> Shape:
    floor = primitive_call('cylinder', shape_kwargs={'radius': radius + 0.4, 'p0': (0, -0.1, 0), 'p1': (0, 0, 0)}, color=(0.55, 0.38, 0.22))
    walls = []
    for level in range(floors):
        for i in range(cases):
            angle = 2 * math.pi * (i + 0.5 * level) / (cases + 2)
            shelf = library_call('bookcase', shelves=5 - level)
            walls.append(transform_shape(shelf, compose(translation_matrix((0, 2.6 * level, 0)), around_y(angle), translation_matrix((0, 0, -radius)))))
    reading = transform_shape(library_call('globe'), translation_matrix((1.9, 0, 1.4)))
    return concat_shapes(floor, library_call('spiral'), reading, *walls)
