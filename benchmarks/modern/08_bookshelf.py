"""a wooden bookshelf filled with colorful books"""
from helper import *
from dataclasses import dataclass
from itertools import accumulate, takewhile
import random


@dataclass
class BookSpec:
    thickness: float
    height: float
    depth: float
    color: tuple[float, float, float]
    lean: float = 0.0

    def __post_init__(self):
        assert self.thickness > 0, "books need pages"
        self.color = tuple(round(min(max(c, 0.0), 1.0), 3) for c in self.color)


def endless_books(rng: random.Random):
    while True:
        base = rng.choice([(0.7, 0.15, 0.12), (0.1, 0.3, 0.6), (0.15, 0.45, 0.25), (0.85, 0.7, 0.3), (0.3, 0.2, 0.4)])
        jitter = rng.gauss(0, 0.06)
        yield BookSpec(rng.uniform(0.04, 0.1), rng.uniform(0.35, 0.52), rng.uniform(0.28, 0.36), tuple(c + jitter for c in base))


@register()
def book(spec: BookSpec) -> Shape:
    cover = primitive_call('cube', shape_kwargs={'scale': (spec.thickness, spec.height, spec.depth)}, color=spec.color)
    pages = primitive_call('cube', shape_kwargs={'scale': (spec.thickness * 0.8, spec.height * 0.96, spec.depth)}, color=(0.95, 0.93, 0.85))
    pages = transform_shape(pages, translation_matrix((0, 0.01, -0.01)))
    return transform_shape(concat_shapes(cover, pages), translation_matrix((0, spec.height / 2, 0)))


@register()
def row_of_books(width: float, seed: int) -> Shape:
    rng = random.Random(seed)
    shapes, x = [], 0.02
    for spec in endless_books(rng):
        if (right := x + spec.thickness) > width * rng.uniform(0.85, 1.0):
            break
        shapes.append(transform_shape(library_call('book', spec=spec), translation_matrix((x + spec.thickness / 2, 0, 0))))
        x = right + 0.004
    return concat_shapes(*shapes)


@register()
def case(width: float = 1.8, height: float = 2.6, depth: float = 0.4, shelves: int = 4, *, board: float = 0.05) -> Shape:
    wood = (0.45, 0.29, 0.16)
    side = primitive_call('cube', shape_kwargs={'scale': (board, height, depth)}, color=wood)
    plank = primitive_call('cube', shape_kwargs={'scale': (width, board, depth)}, color=wood)
    back = primitive_call('cube', shape_kwargs={'scale': (width, height, board / 2)}, color=tuple(0.8 * c for c in wood))
    sides = [transform_shape(side, translation_matrix((s * (width + board) / 2, height / 2, 0))) for s in (-1, 1)]
    planks = loop(shelves + 1, lambda i: transform_shape(plank, translation_matrix((0, i * (height - board) / shelves + board / 2, 0))))
    return concat_shapes(*sides, planks, transform_shape(back, translation_matrix((0, height / 2, -depth / 2))))


@register()
def bookshelf(shelves: int = 4) -> Shape:
    W, H = 1.8, 2.6
    frame = library_call('case', width=W, height=H, shelves=shelves)
    step = (H - 0.05) / shelves
    rows = loop(shelves, lambda i: transform_shape(
        library_call('row_of_books', width=W, seed=100 + i), translation_matrix((-W / 2, i * step + 0.05, 0))))
    return concat_shapes(frame, rows)
