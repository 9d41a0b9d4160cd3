"""a 3D bar chart of monthly rainfall in three cities"""
from helper import *

DATA = {
    'Bergen': [190, 152, 170, 114, 106, 132, 148, 190, 283, 271, 259, 235],
    'Lisbon': [99, 80, 62, 78, 47, 16, 5, 6, 33, 101, 128, 127],
    'Nairobi': [58, 50, 92, 242, 189, 39, 18, 24, 29, 61, 150, 108],
}
PALETTE = {'Bergen': (0.2, 0.4, 0.75), 'Lisbon': (0.9, 0.55, 0.2), 'Nairobi': (0.3, 0.65, 0.35)}
MONTHS = 12
STEP = 0.5
MM = 1 / 100  # scene units for each millimeter


def lerp(a, b, t):
    return tuple(x + (y - x) * t for x, y in zip(a, b))


def post(size, base, color):
    """A box on the point `base`."""
    x, y, z = base
    return transform_shape(primitive_call('cube', shape_kwargs={'scale': size}, color=color), translation_matrix((x, y + size[1] / 2, z)))


@register("one bar, lighter if it is low")
def bar(value: float = 100, color: tuple[float, float, float] = (0.2, 0.4, 0.75), width: float = 0.36) -> Shape:
    height = max(value * MM, 0.01)
    shade = lerp((1, 1, 1), color, min(1.0, 0.4 + value / 300))
    return post((width, height, width), (0, 0, 0), shade)


@register("the bars of a city along x; its wettest month has a ball on top")
def series(city: str = 'Bergen') -> Shape:
    values = DATA[city]
    wettest = values.index(max(values))
    shapes = [
        transform_shape(library_call('bar', value=v, color=PALETTE[city]), translation_matrix((m * STEP, 0, 0)))
        for m, v in enumerate(values)
    ]
    marker = primitive_call('sphere', shape_kwargs={'radius': 0.12}, color=(0.9, 0.1, 0.15))
    shapes.append(transform_shape(marker, translation_matrix((wettest * STEP, max(values) * MM + 0.15, 0))))
    return concat_shapes(*shapes)


@register("a polyline of the mean of all cities behind the bars")
def mean_line(z: float = -1.0) -> Shape:
    means = [sum(month) / len(DATA) for month in zip(*DATA.values())]
    points = [(m * STEP, v * MM, z) for m, v in enumerate(means)]
    segments = [
        primitive_call('cylinder', shape_kwargs={'radius': 0.03, 'p0': p, 'p1': q}, color=(0.15, 0.15, 0.15))
        for p, q in zip(points[:-1], points[1:])
    ]
    knots = [transform_shape(primitive_call('sphere', shape_kwargs={'radius': 0.06}, color=(0.15, 0.15, 0.15)), translation_matrix(p)) for p in points]
    return concat_shapes(*segments, *knots)


@register("floor, back wall and a line for each 50 mm")
def axes(top: int = 300, every: int = 50) -> Shape:
    width = MONTHS * STEP + 0.4
    depth = len(DATA) * STEP + 1.2
    center_x = (MONTHS - 1) * STEP / 2
    floor = post((width, 0.04, depth), (center_x, -0.04, 0.0), (0.92, 0.92, 0.92))
    wall = post((width, top * MM, 0.03), (center_x, 0, -depth / 2), (0.97, 0.97, 0.97))
    lines = [
        post((width, 0.012, 0.02), (center_x, mm * MM, -depth / 2 + 0.02), (0.6, 0.6, 0.65) if mm % 100 else (0.3, 0.3, 0.35))
        for mm in range(0, top + 1, every)
    ]
    ticks = [post((0.02, 0.02, 0.12), (m * STEP, 0, depth / 2 - 0.06), (0.3, 0.3, 0.3)) for m in range(MONTHS)]
    return concat_shapes(floor, wall, *lines, *ticks)


@register("a cube for each city, sorted by the total of the year")
def legend() -> Shape:
    ranking = sorted(DATA, key=lambda city: sum(DATA[city]), reverse=True)
    parts = []
    for rank, city in enumerate(ranking):
        total = sum(DATA[city])
        y = 2.4 - 0.4 * rank
        parts.append(post((0.2, 0.2, 0.2), (0, y, 0), PALETTE[city]))
        parts.append(primitive_call('cylinder', shape_kwargs={'radius': 0.05, 'p0': (0.2, y + 0.1, 0), 'p1': (0.2 + total / 2000, y + 0.1, 0)}, color=PALETTE[city]))
    return concat_shapes(*parts)


@register()
def rainfall_chart() -> Shape:
    rows = []
    for k, city in enumerate(sorted(DATA)):
        rows.append(transform_shape(library_call('series', city=city), translation_matrix((0, 0, (k - 1) * STEP))))
    key = transform_shape(library_call('legend'), translation_matrix((MONTHS * STEP + 0.3, 0, -0.8)))
    return concat_shapes(library_call('axes'), *rows, library_call('mean_line'), key)
