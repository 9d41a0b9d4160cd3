"""
a 3d bar chart of monthly rainfall in three cities, with a trend line
"""
from helper import *
import statistics
import string
from collections import defaultdict
from itertools import pairwise

DATA = """
# city     J   F   M   A   M   J   J   A   S   O   N   D
Lisbon    99  87  71  68  54  16   4   6  30 100 127 126
Bergen   250 200 190 130 110 130 150 190 270 260 260 280
Nairobi   60  50  90 200 160  35  18  24  28  55 150 100
"""

COLORS = [(0.25, 0.55, 0.85), (0.35, 0.75, 0.45), (0.95, 0.6, 0.2)]


def parse(text: str) -> dict[str, list[int]]:
    table: dict[str, list[int]] = {}
    for line in map(str.strip, text.splitlines()):
        if not line or line.startswith('#'):
            continue
        city, *values = line.split()
        table[city] = [int(v) for v in values]
        assert len(table[city]) == 12, f'{city}: {len(values)} months'
    return table


def running_mean(values: list[int], k: int = 3) -> list[float]:
    n = len(values)
    return [statistics.fmean(values[(i + d) % n] for d in range(-(k // 2), k // 2 + 1)) for i in range(n)]


@register()
def bar(height: float = 1.0, width: float = 0.4, color: tuple = (0.3, 0.5, 0.8), highlight: bool = False) -> Shape:
    height = max(height, 0.02)
    b = transform_shape(primitive_call('cube', {'scale': (width, height, width)}, color=color), translation_matrix((0, height / 2, 0)))
    if highlight:
        dot = primitive_call('sphere', {'radius': width * 0.3}, color=(0.95, 0.15, 0.2))
        b += transform_shape(dot, translation_matrix((0, height + width * 0.4, 0)))
    return b


@register()
def series(city: str = 'Bergen', scale: float = 0.01, color: tuple = (0.3, 0.5, 0.8)) -> Shape:
    values = parse(DATA)[city]
    peak, low = max(values), min(values)
    bars = loop(len(values), lambda i: transform_shape(
        library_call('bar', height=values[i] * scale, color=color, highlight=values[i] == peak),
        translation_matrix((i * 0.5, 0, 0))))
    mean = running_mean(values)
    pts = [(i * 0.5, m * scale, 0.26) for i, m in enumerate(mean)]
    line = [primitive_call('cylinder', {'radius': 0.03, 'p0': a, 'p1': b}, color=(0.1, 0.1, 0.1)) for a, b in pairwise(pts)]
    return concat_shapes(bars, *line)


@register()
def grid(width: float = 6.0, height: float = 3.0, depth: float = 3.0, every: float = 0.5) -> Shape:
    n = round(height / every)
    lines = loop(n + 1, lambda i: primitive_call('cylinder', {'radius': 0.01, 'p0': (-0.4, i * every, -0.5), 'p1': (width, i * every, -0.5)}, color=(0.6, 0.6, 0.6)))
    axes = [primitive_call('cylinder', {'radius': 0.03, 'p0': (-0.4, 0, -0.5), 'p1': end}, color=(0.2, 0.2, 0.2))
            for end in ((width, 0, -0.5), (-0.4, height, -0.5), (-0.4, 0, depth))]
    return concat_shapes(lines, *axes)


@register()
def rainfall_chart(scale: float = 0.01) -> Shape:
    table = parse(DATA)
    wettest = defaultdict(list)
    for city, values in table.items():
        month = max(range(12), key=values.__getitem__)
        wettest[month].append(city)
    ordered = sorted(table, key=lambda c: statistics.median(table[c]))
    rows = [transform_shape(library_call('series', city=c, scale=scale, color=COLORS[k % 3]), translation_matrix((0, 0, (len(ordered) - 1 - k) * 0.9)))
            for k, c in enumerate(ordered)]
    marks = [transform_shape(primitive_call('cube', {'scale': (0.3, 0.05, 0.1 * len(string.capwords(' '.join(cs)).split()))}, color=(0.9, 0.2, 0.2)),
                             translation_matrix((m * 0.5, 0.0, 2.5))) for m, cs in sorted(wettest.items())]
    floor = transform_shape(primitive_call('cube', {'scale': (6.8, 0.1, 3.8)}, color=(0.93, 0.93, 0.95)), translation_matrix((2.75, -0.06, 1.0)))
    return concat_shapes(floor, library_call('grid'), *rows, *marks)
