"""fractals on plinths: a Sierpinski pyramid, a Cantor set and a Koch snowflake"""
from helper import *
import math

GOLD = (0.9, 0.7, 0.25)
STONE = (0.75, 0.73, 0.7)


@register("a stepped pyramid with its base on y = 0")
def small_pyramid(size: float = 1.0, steps: int = 3) -> Shape:
    h = size * 0.7 / steps

    def step(i: int) -> Shape:
        w = size * (1 - i / steps)
        slab = primitive_call('cube', shape_kwargs={'scale': (w, h, w)}, color=(0.9 - 0.1 * i, 0.7 - 0.05 * i, 0.25 + 0.1 * i))
        return transform_shape(slab, translation_matrix((0, h * (i + 0.5), 0)))

    return loop(steps, step)


@register("five copies of half the size: four in the corners and one above")
def sierpinski(depth: int = 3, size: float = 2.0) -> Shape:
    if depth == 0:
        return library_call('small_pyramid', size=size)
    half = size / 2
    child = library_call('sierpinski', depth=depth - 1, size=half)
    offsets = [(sx * half / 2, 0.0, sz * half / 2) for sx in (-1, 1) for sz in (-1, 1)] + [(0.0, half * 0.7, 0.0)]
    return concat_shapes(*[transform_shape(child, translation_matrix(o)) for o in offsets])


@register("the Cantor set: each level below removes the middle third")
def cantor(depth: int = 4, length: float = 2.0, level: int = 0) -> Shape:
    t = level / 5
    bar = primitive_call('cube', shape_kwargs={'scale': (length, 0.1, 0.2)}, color=(0.2 + 0.6 * t, 0.3, 0.8 - 0.5 * t))
    bar = transform_shape(bar, translation_matrix((0, -0.18 * level, 0)))
    if depth == 0:
        return bar
    third = length / 3
    left = transform_shape(library_call('cantor', depth=depth - 1, length=third, level=level + 1), translation_matrix((-third, 0, 0)))
    right = transform_shape(library_call('cantor', depth=depth - 1, length=third, level=level + 1), translation_matrix((third, 0, 0)))
    return concat_shapes(bar, left, right)


def koch(a: tuple[float, float], b: tuple[float, float], depth: int) -> list[tuple[float, float]]:
    """The points of a Koch curve from a to b, without b."""
    if depth == 0:
        return [a]
    dx, dy = (b[0] - a[0]) / 3, (b[1] - a[1]) / 3
    p = (a[0] + dx, a[1] + dy)
    q = (a[0] + 2 * dx, a[1] + 2 * dy)
    c, s = math.cos(-math.pi / 3), math.sin(-math.pi / 3)
    peak = (p[0] + dx * c - dy * s, p[1] + dx * s + dy * c)
    points = []
    for start, end in [(a, p), (p, peak), (peak, q), (q, b)]:
        points += koch(start, end, depth - 1)
    return points


@register("a snowflake of rods in the xy plane")
def snowflake(depth: int = 3, radius: float = 0.9) -> Shape:
    corners = [(radius * math.cos(math.tau * k / 3 + math.pi / 2), radius * math.sin(math.tau * k / 3 + math.pi / 2)) for k in range(3)]
    outline = []
    for k in range(3):
        outline.extend(koch(corners[k], corners[(k + 1) % 3], depth))
    rods = []
    for i, (x, y) in enumerate(outline):
        x2, y2 = outline[(i + 1) % len(outline)]
        rods.append(primitive_call('cylinder', shape_kwargs={'radius': 0.02, 'p0': (x, y, 0), 'p1': (x2, y2, 0)}, color=(0.75, 0.9, 1.0)))
    return concat_shapes(*rods)


@register("a plinth with a moulding")
def plinth(width: float = 1.6, height: float = 0.8) -> Shape:
    tiers = [(1.15, 0.0, 0.1), (1.0, 0.1, 0.9), (1.1, 0.9, 1.0)]
    return concat_shapes(*[
        transform_shape(primitive_call('cube', shape_kwargs={'scale': (width * w, height * (b - a), width * w)}, color=STONE),
                        translation_matrix((0, height * (a + b) / 2, 0)))
        for w, a, b in tiers
    ])


@register()
def fractal_gallery(spacing: float = 3.0) -> Shape:
    exhibits = [
        (library_call('sierpinski'), 0.8),
        (library_call('cantor'), 2.0),
        (library_call('snowflake'), 2.0),
    ]
    shapes = []
    for k, (exhibit, y) in enumerate(exhibits):
        x = (k - 1) * spacing
        shapes.append(transform_shape(library_call('plinth', width=2.0), translation_matrix((x, 0, 0))))
        shapes.append(transform_shape(exhibit, translation_matrix((x, y, 0))))
    floor = transform_shape(primitive_call('cube', shape_kwargs={'scale': (10, 0.1, 4)}, color=(0.3, 0.22, 0.18)), translation_matrix((0, -0.05, 0)))
    return concat_shapes(floor, *shapes)
