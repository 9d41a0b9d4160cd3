"""a tall oak bookshelf full of colorful books, with a globe on top"""
from helper import *
import math

OAK = (0.55, 0.36, 0.18)
SPINES = [(0.65, 0.12, 0.12), (0.12, 0.3, 0.55), (0.15, 0.42, 0.22), (0.85, 0.7, 0.25), (0.35, 0.18, 0.4), (0.9, 0.88, 0.8)]


@register("a board with its center at the origin")
def board(width: float = 1.0, thickness: float = 0.03, depth: float = 0.3) -> Shape:
    return primitive_call('cube', shape_kwargs={'scale': (width, thickness, depth)}, color=OAK)


@register("one upright book standing on y = 0, its left side at x = 0")
def book(thickness: float = 0.04, height: float = 0.25, hue: int = 0) -> Shape:
    cover = primitive_call('cube', shape_kwargs={'scale': (thickness, height, 0.2)}, color=SPINES[hue % len(SPINES)])
    band = primitive_call('cube', shape_kwargs={'scale': (thickness * 1.02, 0.02, 0.202)}, color=(0.9, 0.8, 0.5))
    cover = transform_shape(cover, translation_matrix((thickness / 2, height / 2, 0)))
    band = transform_shape(band, translation_matrix((thickness / 2, height * 0.8, 0)))
    return concat_shapes(cover, band)


@register("a row of books that fills a shelf from left to right")
def book_row(length: float = 0.9, seed: int = 0) -> Shape:
    shapes = []
    x = 0.0
    k = seed
    while True:
        # a cheap deterministic variation instead of random numbers
        thickness = 0.025 + 0.01 * ((k * 7) % 4)
        height = 0.22 + 0.015 * ((k * 5) % 5)
        if x + thickness > length:
            break
        if (k * 3 + seed) % 11 == 4:
            x += 0.03  # a gap where a book was taken out
        else:
            shapes.append(transform_shape(library_call('book', thickness=thickness, height=height, hue=k),
                                          translation_matrix((x, 0, 0))))
            x += thickness + 0.002
        k += 1
    return concat_shapes(*shapes)


@register()
def bookcase(width: float = 1.0, height: float = 2.0, shelves: int = 5) -> Shape:
    gap = height / shelves
    sides = [
        transform_shape(
            primitive_call('cube', shape_kwargs={'scale': (0.04, height, 0.3)}, color=OAK),
            translation_matrix((side * width / 2, height / 2, 0)),
        )
        for side in (-1, 1)
    ]
    boards = loop(shelves + 1, lambda i: transform_shape(library_call('board', width=width), translation_matrix((0, i * gap, 0))))
    rows = loop(shelves, lambda i: transform_shape(
        library_call('book_row', length=width - 0.1, seed=i * 4 + 1),
        translation_matrix((-width / 2 + 0.05, i * gap + 0.015, 0.02))))
    back = transform_shape(primitive_call('cube', shape_kwargs={'scale': (width, height, 0.01)}, color=(0.45, 0.28, 0.13)),
                           translation_matrix((0, height / 2, -0.15)))
    return concat_shapes(*sides, boards, back, rows)


@register("a desk globe tilted by the angle of the earth")
def globe(radius: float = 0.14, tilt: float = 23.4) -> Shape:
    brass = (0.8, 0.6, 0.25)
    sea = primitive_call('sphere', shape_kwargs={'radius': radius}, color=(0.2, 0.45, 0.7))
    axis = primitive_call('cylinder', shape_kwargs={'radius': 0.006, 'p0': (0, -radius * 1.2, 0), 'p1': (0, radius * 1.2, 0)}, color=brass)
    ball = transform_shape(concat_shapes(sea, axis), rotation_matrix(math.radians(-tilt), (0, 0, 1), (0, 0, 0)))
    ball = transform_shape(ball, translation_matrix((0, radius * 1.2 + 0.08, 0)))
    foot = primitive_call('cylinder', shape_kwargs={'radius': 0.08, 'p0': (0, 0, 0), 'p1': (0, 0.02, 0)}, color=brass)
    stem = primitive_call('cylinder', shape_kwargs={'radius': 0.012, 'p0': (0, 0, 0), 'p1': (0, 0.1, 0)}, color=brass)
    return concat_shapes(ball, foot, stem)


@register("the whole corner")
def bookshelf_corner() -> Shape:
    floor = primitive_call('cube', shape_kwargs={'scale': (2.4, 0.02, 1.4)}, color=(0.7, 0.62, 0.5))
    floor = transform_shape(floor, translation_matrix((0, -0.03, 0.3)))
    return concat_shapes(
        floor,
        library_call('bookcase'),
        transform_shape(library_call('globe'), translation_matrix((0.2, 2.015, 0))),
    )
