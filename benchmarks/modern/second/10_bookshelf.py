"""
a bookshelf filled with books of different sizes, with a few leaning
"""
from helper import *
import logging
import math
import random
import statistics
from dataclasses import dataclass, field, replace
from itertools import accumulate, takewhile

log = logging.getLogger(__name__)

PALETTE = [(0.55, 0.12, 0.12), (0.12, 0.25, 0.45), (0.15, 0.38, 0.22), (0.78, 0.66, 0.35), (0.3, 0.2, 0.35), (0.85, 0.83, 0.78)]


@dataclass(order=True)
class Book:
    height: float
    thickness: float = field(compare=False, default=0.1)
    depth: float = field(compare=False, default=0.6)
    color: tuple[float, float, float] = field(compare=False, default=(0.5, 0.5, 0.5))

    @staticmethod
    def random(rng: random.Random) -> 'Book':
        return Book(height=rng.triangular(0.6, 1.05, 0.85), thickness=rng.uniform(0.06, 0.2),
                    depth=rng.uniform(0.5, 0.65), color=rng.choice(PALETTE))


def endless_books(seed: int):
    rng = random.Random(seed)
    while True:
        yield Book.random(rng)


def fill(width: float, seed: int) -> list[Book]:
    """Takes books from the endless supply until the shelf is nearly full."""
    supply = endless_books(seed)
    used = 0.0
    row = []
    for b in supply:
        if used + b.thickness > width * 0.88:
            break
        used += b.thickness
        row.append(b)
    log.debug('%d books, mean height %.2f', len(row), statistics.mean(b.height for b in row))
    return row


@register()
def book(height: float = 0.9, thickness: float = 0.12, depth: float = 0.6, color: tuple = (0.6, 0.2, 0.2)) -> Shape:
    cover = primitive_call('cube', {'scale': (thickness, height, depth)}, color=color)
    pages = primitive_call('cube', {'scale': (thickness * 0.8, height * 0.96, depth * 0.98)}, color=(0.95, 0.93, 0.85))
    pages = transform_shape(pages, translation_matrix((0, 0, -depth * 0.03)))
    band = primitive_call('cube', {'scale': (thickness * 1.02, height * 0.04, depth * 1.005)}, color=(0.9, 0.8, 0.4))
    bands = [transform_shape(band, translation_matrix((0, s * height * 0.35, 0))) for s in (-1, 1)]
    return transform_shape(concat_shapes(cover, pages, *bands), translation_matrix((0, height / 2, 0)))


@register()
def shelf_row(width: float = 4.0, seed: int = 0, sort: bool = False) -> Shape:
    row = fill(width, seed)
    if sort:
        row.sort(reverse=True)
    starts = [0, *accumulate(b.thickness for b in row)]
    shapes = []
    for x0, b in zip(starts, row):
        s = library_call('book', height=b.height, thickness=b.thickness, depth=b.depth, color=b.color)
        shapes.append(transform_shape(s, translation_matrix((x0 + b.thickness / 2, 0, b.depth / 2))))
    # one leaning book rests on the last one
    last = row[-1]
    leaner = replace(last, height=last.height * 0.9, color=PALETTE[seed % len(PALETTE)])
    tilt = math.radians(12)
    lean = library_call('book', height=leaner.height, thickness=leaner.thickness, depth=leaner.depth, color=leaner.color)
    lean = transform_shape(lean, rotation_matrix(tilt, (0, 0, 1), (0, 0, 0)))
    dx = starts[-1] + leaner.thickness / 2 + leaner.height * math.sin(tilt)
    shapes.append(transform_shape(lean, translation_matrix((dx, 0, leaner.depth / 2))))
    return sum(shapes, [])


@register()
def bookcase(width: float = 4.0, pitch: float = 1.3, shelves: int = 4, depth: float = 0.75) -> Shape:
    wood = (0.42, 0.27, 0.16)
    total = pitch * shelves
    plank = primitive_call('cube', {'scale': (width + 0.2, 0.08, depth)}, color=wood)
    planks = loop(shelves + 1, lambda i: transform_shape(plank, translation_matrix((width / 2, i * pitch - 0.04, depth / 2))))
    sides = [transform_shape(primitive_call('cube', {'scale': (0.1, total + 0.1, depth)}, color=wood),
                             translation_matrix((x, total / 2, depth / 2))) for x in (-0.1, width + 0.1)]
    back = transform_shape(primitive_call('cube', {'scale': (width + 0.2, total, 0.04)}, color=(0.35, 0.22, 0.13)),
                           translation_matrix((width / 2, total / 2, 0)))
    return concat_shapes(planks, *sides, back)


@register()
def vase(height: float = 0.7) -> Shape:
    radii = [0.12 + 0.1 * math.sin(math.pi * t / 6) for t in range(7)]
    slices = takewhile(lambda p: p[0] < 7, enumerate(radii))
    h = height / 7
    return concat_shapes(*(primitive_call('cylinder', {'radius': r, 'p0': (0, i * h, 0), 'p1': (0, (i + 1) * h, 0)},
                                          color=(0.3, 0.5, 0.6)) for i, r in slices))


@register()
def library_shelf(shelves: int = 4) -> Shape:
    pitch, width = 1.3, 4.0
    case = library_call('bookcase', width=width, pitch=pitch, shelves=shelves)
    rows = [transform_shape(library_call('shelf_row', width=width, seed=s, sort=s % 2 == 0), translation_matrix((0, s * pitch, 0)))
            for s in range(shelves)]
    top = compute_shape_max(case)[1]
    pot = transform_shape(library_call('vase'), translation_matrix((width * 0.8, top, 0.4)))
    return concat_shapes(case, *rows, pot)
