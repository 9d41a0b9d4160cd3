import numpy as np
from helper import *

"""
a year of weather: reductions over axes become bars, rings and a table of dots
"""

MONTHS = np.arange(12)
CITIES = ["Oslo", "Rome", "Cairo"]


def temperatures() -> np.ndarray:
    """Shape (city, month, part of the day)."""
    base = np.array([5.0, 16.0, 22.0]).reshape(-1, 1, 1)
    swing = np.array([11, 9, 7])[:, None, None]
    season = -np.cos(2 * np.pi * (MONTHS - 0.5) / 12)[None, :, None]
    day = np.array([-3.0, 0.0, 4.0])[None, None, :]
    return base + swing * season + day


def color_of(t: float) -> tuple:
    knots = np.array([-10, 5, 15, 25, 35])
    r = np.interp(t, knots, [0.2, 0.3, 0.5, 0.95, 0.9])
    g = np.interp(t, knots, [0.3, 0.6, 0.8, 0.7, 0.1])
    b = np.interp(t, knots, [0.9, 0.9, 0.4, 0.2, 0.1])
    return float(r), float(g), float(b)


@register()
def year_ring(values: np.ndarray, radius: float) -> Shape:
    shapes = []
    for month, t in enumerate(values):
        a = 2 * np.pi * month / 12
        h = max(0.05, 0.1 + t / 25)
        bar = primitive_call('cube', color=color_of(t), shape_kwargs={'scale': (0.4, h, 0.4)})
        shapes.append(transform_shape(bar, translation_matrix((radius * np.cos(a), h / 2, radius * np.sin(a)))))
    return concat_shapes(*shapes)


@register()
def weather_globe() -> Shape:
    t = temperatures()
    mean = t.mean(axis=2)
    spread = t.max(axis=(1, 2)) - t.min(axis=(1, 2))
    centered = mean - mean.mean(axis=1, keepdims=True)
    warmest = mean.argmax(axis=1)
    cumulative = np.cumsum(centered, axis=1)
    shapes = [library_call('year_ring', values=row, radius=1.5 + i) for i, row in enumerate(mean)]
    for i, row in enumerate(cumulative):
        for j, value in enumerate(row[::2]):
            dot = primitive_call('sphere', color=(0.5, 0.5, 0.6), shape_kwargs={'radius': 0.05 + abs(value) / 400})
            shapes.append(transform_shape(dot, translation_matrix((0.5 * j - 1.2, 3 + 0.4 * i, 0))))
    for i, (s, w) in enumerate(zip(spread, warmest)):
        a = 2 * np.pi * w / 12
        shapes.append(primitive_call('cylinder', color=(0.9, 0.1, 0.2), shape_kwargs={'radius': 0.06, 'p0': (0, 0, 0), 'p1': ((1 + i) * np.cos(a), s / 10, (1 + i) * np.sin(a))}))
    freezing = (t < 0).any(axis=-1).sum(axis=-1)
    std = np.std(t, axis=(0, 1), ddof=1)
    med, q = np.median(t), np.percentile(t, [10, 90])
    for k, v in enumerate([*freezing, *std, med, *q, t.prod(axis=2).min() ** 2 / 1e4, (t > 20).all(axis=2).sum(), np.average(mean[0], weights=MONTHS + 1)]):
        size = 0.1 + abs(v) / 30
        shapes.append(transform_shape(primitive_call('cube', color=(0.6, 0.4, 0.2), shape_kwargs={'scale': (0.2, size, 0.2)}), translation_matrix((0.4 * k - 2, size / 2, 5))))
    return concat_shapes(*shapes)
