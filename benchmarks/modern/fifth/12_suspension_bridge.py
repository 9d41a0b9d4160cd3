"""a red suspension bridge over a strait with cars crossing at dusk"""
from helper import *
import numpy as np

ORANGE_RED = (0.78, 0.24, 0.16)
SPAN, SIDE, DECK_Y, TOWER_H, WIDTH = 16.0, 6.0, 2.0, 7.0, 1.6


def cable_y(x: float) -> float:
    """Parabola between the towers, straight lines outside."""
    half = SPAN / 2
    if abs(x) <= half:
        sag = TOWER_H - DECK_Y - 0.4
        return DECK_Y + 0.4 + sag * (x / half) ** 2
    return np.interp(abs(x), [half, half + SIDE], [TOWER_H, DECK_Y])


def strut(p0, p1, r, color=ORANGE_RED):
    return primitive_call('cylinder', shape_kwargs={'radius': r, 'p0': [float(v) for v in p0], 'p1': [float(v) for v in p1]}, color=color)


@register()
def tower(height: float = TOWER_H, crossbars: int = 4) -> Shape:
    parts = []
    for z in (-WIDTH / 2, WIDTH / 2):
        for k, (y0, y1) in enumerate(zip(np.linspace(-1, height, 5)[:-1], np.linspace(-1, height, 5)[1:])):
            w = 0.5 - 0.06 * k
            cube = primitive_call('cube', shape_kwargs={'scale': (w, y1 - y0, w * 0.8)}, color=ORANGE_RED)
            parts.append(transform_shape(cube, translation_matrix((0, (y0 + y1) / 2, z))))
    for y in np.linspace(DECK_Y - 0.3, height - 0.2, crossbars):
        bar = primitive_call('cube', shape_kwargs={'scale': (0.25, 0.25, WIDTH)}, color=ORANGE_RED)
        parts.append(transform_shape(bar, translation_matrix((0, y, 0))))
    pier = primitive_call('cube', shape_kwargs={'scale': (1.4, 1.2, WIDTH + 1.2)}, color=(0.55, 0.53, 0.5))
    lamp = transform_shape(primitive_call('sphere', shape_kwargs={'radius': 0.12}, color=(1, 0.3, 0.25)), translation_matrix((0, height + 0.1, 0)))
    return concat_shapes(*parts, transform_shape(pier, translation_matrix((0, -0.9, 0))), lamp)


@register()
def cables(hanger_step: float = 0.8) -> Shape:
    total = SPAN / 2 + SIDE
    xs = np.linspace(-total, total, 57)
    ys = np.array([cable_y(x) for x in xs])
    shapes = []
    for z in (-WIDTH / 2, WIDTH / 2):
        for x0, y0, x1, y1 in zip(xs[:-1], ys[:-1], xs[1:], ys[1:]):
            shapes.append(strut((x0, y0, z), (x1, y1, z), 0.06))
        for x in np.arange(-total + hanger_step, total, hanger_step):
            top = cable_y(x)
            if top - DECK_Y > 0.15:
                shapes.append(strut((x, DECK_Y, z), (x, top, z), 0.018))
    return concat_shapes(*shapes)


@register()
def deck(truss_step: float = 1.0) -> Shape:
    length = SPAN + 2 * SIDE
    road = transform_shape(primitive_call('cube', shape_kwargs={'scale': (length, 0.12, WIDTH)}, color=(0.2, 0.2, 0.22)), translation_matrix((0, DECK_Y, 0)))
    n = int(length / truss_step)
    def panel(i: int) -> Shape:
        x = -length / 2 + i * truss_step
        out = []
        for z in (-WIDTH / 2, WIDTH / 2):
            lo, hi = DECK_Y - 0.4, DECK_Y
            out.append(strut((x, lo if i % 2 else hi, z), (x + truss_step, hi if i % 2 else lo, z), 0.03))
            out.append(strut((x, lo, z), (x + truss_step, lo, z), 0.03))
        return concat_shapes(*out)
    dashes = loop(n // 2, lambda i: transform_shape(primitive_call('cube', shape_kwargs={'scale': (0.5, 0.01, 0.05)}, color=(0.95, 0.85, 0.4)), translation_matrix((-length / 2 + 2 * i * truss_step + 0.5, DECK_Y + 0.065, 0))))
    return concat_shapes(road, loop(n, panel), dashes)


@register()
def car(color=(0.2, 0.3, 0.7), truck: bool = False) -> Shape:
    length = 0.9 if truck else 0.55
    body = transform_shape(primitive_call('cube', shape_kwargs={'scale': (length, 0.14, 0.26)}, color=color), translation_matrix((0, 0.13, 0)))
    cabin = transform_shape(primitive_call('cube', shape_kwargs={'scale': (length * 0.55, 0.3 if truck else 0.13, 0.24)}, color=(0.85, 0.88, 0.9)), translation_matrix((-0.05, 0.25, 0)))
    wheels = [strut((sx * length * 0.3, 0.06, sz * 0.12), (sx * length * 0.3, 0.06, sz * 0.14), 0.06, (0.05, 0.05, 0.05)) for sx in (-1, 1) for sz in (-1, 1)]
    lights = [transform_shape(primitive_call('sphere', shape_kwargs={'radius': 0.03}, color=(1, 1, 0.75) if end > 0 else (1, 0.1, 0.1)), translation_matrix((end * length / 2, 0.14, sz * 0.09))) for end in (-1, 1) for sz in (-1, 1)]
    return concat_shapes(body, cabin, *wheels, *lights)


@register()
def traffic(cars: int = 9, seed: int = 8) -> Shape:
    rng = np.random.default_rng(seed)
    lanes = rng.integers(0, 2, size=cars)
    positions = np.sort(rng.uniform(-12, 12, size=cars))
    # keep a distance between neighbours
    gaps = np.maximum(np.diff(positions), 1.3)
    positions = np.concatenate(([positions[0]], positions[0] + np.cumsum(gaps)))
    colors = rng.random((cars, 3)) * 0.8 + 0.1
    shapes = []
    for x, lane, c, truck in zip(positions, lanes, colors, rng.random(cars) < 0.25):
        vehicle = library_call('car', color=tuple(c.tolist()), truck=bool(truck))
        if lane:
            vehicle = transform_shape(vehicle, rotation_matrix(np.pi, (0, 1, 0), (0, 0, 0)))
        shapes.append(transform_shape(vehicle, translation_matrix((x, DECK_Y + 0.06, -0.4 if lane else 0.4))))
    return concat_shapes(*shapes)


@register()
def strait() -> Shape:
    water = transform_shape(primitive_call('cube', shape_kwargs={'scale': (32, 0.4, 14)}, color=(0.15, 0.2, 0.38)), translation_matrix((0, -1.2, 0)))
    banks = [transform_shape(primitive_call('cube', shape_kwargs={'scale': (5, 3, 14)}, color=(0.3, 0.28, 0.24)), translation_matrix((s * 15.5, 0.2, 0))) for s in (-1, 1)]
    sun = transform_shape(primitive_call('sphere', shape_kwargs={'radius': 1.4}, color=(1.0, 0.55, 0.25)), translation_matrix((4, 1.2, -14)))
    towers = [transform_shape(library_call('tower'), translation_matrix((s * SPAN / 2, 0, 0))) for s in (-1, 1)]
    return concat_shapes(water, *banks, sun, *towers, library_call('cables'), library_call('deck'), library_call('traffic'))
