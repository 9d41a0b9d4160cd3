"""a 3D bar chart of monthly rainfall with the mean and median marked"""
from helper import *
import statistics
from datetime import date

RAIN = """
Jan 78.2
Feb 61.0
Mar 55.4
Apr 49.9
May 58.1
Jun 44.3
Jul 30.8
Aug 35.5
Sep 62.7
Oct 90.1
Nov 101.6
Dec 95.0
"""


def read(text: str) -> dict[int, float]:
    out = {}
    for line in text.strip().splitlines():
        month, _, value = line.partition(' ')
        idx = next(m for m in range(1, 13) if date(2025, m, 1).strftime('%b') == month)
        out[idx] = float(value)
    return out


DATA = read(RAIN)
MEAN, MEDIAN, SPREAD = statistics.fmean(DATA.values()), statistics.median(DATA.values()), statistics.pstdev(DATA.values())
SCALE = 3.0 / max(DATA.values())


def zscore(v: float) -> float:
    return (v - MEAN) / SPREAD


@register()
def bar(month: int, mm: float, width: float = 0.6) -> Shape:
    z = max(-1.0, min(1.0, zscore(mm) / 2))
    color = (0.35 - 0.25 * z, 0.55 - 0.2 * z, 0.75 + 0.2 * z)
    h = mm * SCALE
    shape = primitive_call('cube', shape_kwargs={'scale': (width, h, width)}, color=color)
    return transform_shape(shape, translation_matrix((month - 6.5, h / 2, 0)))


@register()
def marker(level: float, color=(0.9, 0.2, 0.2)) -> Shape:
    y = level * SCALE
    return primitive_call('cylinder', shape_kwargs={'radius': 0.03, 'p0': (-6.5, y, 0.4), 'p1': (6.5, y, 0.4)}, color=color)


@register()
def axes() -> Shape:
    base = transform_shape(primitive_call('cube', shape_kwargs={'scale': (13, 0.08, 1.5)}, color=(0.9, 0.9, 0.9)), translation_matrix((0, -0.04, 0)))
    ticks = [primitive_call('cylinder', shape_kwargs={'radius': 0.015, 'p0': (-6.6, mm * SCALE, -0.5), 'p1': (-6.3, mm * SCALE, -0.5)}, color=(0.2, 0.2, 0.2))
             for mm in range(0, int(max(DATA.values())) + 1, 20)]
    pole = primitive_call('cylinder', shape_kwargs={'radius': 0.02, 'p0': (-6.5, 0, -0.5), 'p1': (-6.5, 3.3, -0.5)}, color=(0.2, 0.2, 0.2))
    return concat_shapes(base, pole, *ticks)


@register()
def rainfall_chart() -> Shape:
    bars = [library_call('bar', month=m, mm=v) for m, v in sorted(DATA.items(), key=lambda mv: -mv[1])]
    return concat_shapes(library_call('axes'), *bars, library_call('marker', level=MEAN), library_call('marker', level=MEDIAN, color=(0.2, 0.7, 0.3)))
