"""a fruit market stall with crates of apples, oranges, lemons, grapes and a striped awning"""
from helper import *
from collections import namedtuple
import math
import random

Fruit = namedtuple('Fruit', 'name radius color jitter', defaults=[0.05])
FRUITS = [
    Fruit('apple', 0.07, (0.8, 0.12, 0.12), 0.1),
    Fruit('orange', 0.075, (0.98, 0.55, 0.1)),
    Fruit('lemon', 0.055, (0.98, 0.9, 0.25)),
    Fruit('lime', 0.05, (0.4, 0.75, 0.2)),
    Fruit('plum', 0.05, (0.4, 0.12, 0.4), 0.08),
    Fruit('peach', 0.07, (0.98, 0.7, 0.5)),
]
PRICES = dict(zip((f.name for f in FRUITS), (2.4, 1.9, 2.1, 2.8, 3.2, 3.5)))


@register()
def crate(width: float = 0.8, depth: float = 0.55, height: float = 0.22, slats: int = 3) -> Shape:
    wood = (0.72, 0.55, 0.35)
    parts = [transform_shape(primitive_call('cube', shape_kwargs={'scale': (width, 0.02, depth)}, color=wood), translation_matrix((0, 0.01, 0)))]
    h = height / slats
    for k in range(slats):
        y = h * (k + 0.5)
        for s in (-1, 1):
            parts.append(transform_shape(primitive_call('cube', shape_kwargs={'scale': (width, h * 0.75, 0.02)}, color=wood), translation_matrix((0, y, s * depth / 2))))
            parts.append(transform_shape(primitive_call('cube', shape_kwargs={'scale': (0.02, h * 0.75, depth)}, color=wood), translation_matrix((s * width / 2, y, 0))))
    return concat_shapes(*parts)


@register()
def fruit_pile(kind: str = 'apple', width: float = 0.76, depth: float = 0.5, layers: int = 2) -> Shape:
    fruit = next(f for f in FRUITS if f.name == kind)
    rnd = random.Random(len(kind) * 31 + ord(kind[0]))
    d = fruit.radius * 2
    shapes = []
    for layer in range(layers):
        nx, nz = int(width / d) - layer, int(depth / d) - layer
        for ix in range(nx):
            for iz in range(nz):
                x, z = (ix - (nx - 1) / 2) * d, (iz - (nz - 1) / 2) * d
                shade = 1 + rnd.uniform(-fruit.jitter, fruit.jitter)
                ball = primitive_call('sphere', shape_kwargs={'radius': fruit.radius * rnd.uniform(0.92, 1.0)}, color=tuple(min(1, c * shade) for c in fruit.color))
                shapes.append(transform_shape(ball, translation_matrix((x, fruit.radius * (1 + 1.5 * layer), z))))
    return concat_shapes(*shapes)


@register()
def grapes(rows: int = 6, berry: float = 0.03, color: tuple = (0.35, 0.15, 0.45)) -> Shape:
    berries = []
    for row in range(rows):
        count = rows - row
        for k in range(count):
            a = 2 * math.pi * k / count + row * 0.5
            r = berry * 0.9 * (count - 1) / 2
            berries.append(transform_shape(primitive_call('sphere', shape_kwargs={'radius': berry}, color=color), translation_matrix((r * math.cos(a), -row * berry * 1.5, r * math.sin(a)))))
    stem = primitive_call('cylinder', shape_kwargs={'radius': 0.008, 'p0': (0, 0, 0), 'p1': (0.01, 0.12, 0)}, color=(0.4, 0.3, 0.15))
    return concat_shapes(stem, *berries)


@register()
def price_tag(price: float = 1.5, size: float = 0.16) -> Shape:
    """A small board with one bar for each full euro and a dot for each 20 cents."""
    euros, cents = divmod(round(price * 100), 100)
    board = primitive_call('cube', shape_kwargs={'scale': (size, size * 0.7, 0.01)}, color=(0.12, 0.2, 0.15))
    bars = [transform_shape(primitive_call('cube', shape_kwargs={'scale': (0.012, 0.06, 0.005)}, color=(1, 1, 1)), translation_matrix((-size * 0.4 + 0.025 * k, 0.01, 0.008))) for k in range(euros)]
    dots = [transform_shape(primitive_call('sphere', shape_kwargs={'radius': 0.006}, color=(1, 0.9, 0.4)), translation_matrix((0.005 + 0.018 * k, -0.02, 0.008))) for k in range(cents // 20)]
    return concat_shapes(board, *bars, *dots)


@register()
def awning(width: float = 3.2, depth: float = 1.6, stripes: int = 10, pitch: float = 20.0) -> Shape:
    w = width / stripes
    strips = []
    for i in range(stripes):
        color = (0.1, 0.5, 0.3) if i % 2 == 0 else (0.97, 0.95, 0.9)
        x = -width / 2 + w * (i + 0.5)
        strips.append(transform_shape(primitive_call('cube', shape_kwargs={'scale': (w, 0.03, depth)}, color=color), translation_matrix((x, 0, 0))))
        strips.append(primitive_call('cylinder', shape_kwargs={'radius': w / 2, 'p0': (x, -0.02, depth / 2 - 0.01), 'p1': (x, -0.02, depth / 2 + 0.02)}, color=color))
    return transform_shape(concat_shapes(*strips), rotation_matrix(math.radians(pitch), (1, 0, 0), (0, 0, 0)))


@register()
def stall(columns: int = 3, height: float = 0.7) -> Shape:
    shapes = []
    for i, fruit in enumerate(FRUITS):
        row, col = divmod(i, columns)
        filled = concat_shapes(library_call('crate'), transform_shape(library_call('fruit_pile', kind=fruit.name), translation_matrix((0, 0.06, 0))),
                               transform_shape(library_call('price_tag', price=PRICES[fruit.name]), translation_matrix((0, 0.3, 0.3))))
        filled = transform_shape(filled, rotation_matrix(0.25, (1, 0, 0), (0, 0, 0)))
        shapes.append(transform_shape(filled, translation_matrix(((col - (columns - 1) / 2) * 0.95, height + 0.3 * (1 - row), (row - 0.5) * 0.65))))
    table = transform_shape(primitive_call('cube', shape_kwargs={'scale': (3.0, 0.06, 1.4)}, color=(0.55, 0.4, 0.25)), translation_matrix((0, height - 0.1, 0)))
    posts = [primitive_call('cylinder', shape_kwargs={'radius': 0.04, 'p0': (sx * 1.5, 0, z), 'p1': (sx * 1.5, 2.3 - 0.3 * (z > 0), z)}, color=(0.4, 0.28, 0.18)) for sx in (-1, 1) for z in (-0.7, 0.7)]
    bunches = [transform_shape(library_call('grapes', rows=5 + i % 2, color=(0.35, 0.15, 0.45) if i % 2 else (0.6, 0.75, 0.3)), translation_matrix((-1.2 + 0.6 * i, 1.75, 0.55))) for i in range(5)]
    return concat_shapes(table, *posts, *shapes, *bunches, transform_shape(library_call('awning'), translation_matrix((0, 2.25, 0))))


@register()
def market_square() -> Shape:
    paving = loop(25, lambda i: transform_shape(primitive_call('cylinder', shape_kwargs={'radius': 0.42, 'p0': (0, -0.05, 0), 'p1': (0, 0, 0)}, color=(0.6, 0.58 - 0.02 * (i % 3), 0.54)), translation_matrix(((i % 5 - 2) * 0.85, 0, (i // 5 - 2) * 0.85))))
    return concat_shapes(paving, library_call('stall'))
