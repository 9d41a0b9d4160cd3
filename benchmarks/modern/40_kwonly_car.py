"""a row of three cars: a sedan, a pickup truck and a bus"""
from helper import *
from types import SimpleNamespace
from typing import TypedDict
import math


class Spec(TypedDict, total=False):
    length: float
    width: float
    body_height: float
    cabin: tuple[float, float]
    cabin_height: float
    paint: tuple[float, float, float]
    axles: list[float]


MODELS: dict[str, Spec] = {
    'sedan': {'length': 4.2, 'cabin': (-0.25, 0.2), 'cabin_height': 0.6, 'paint': (0.75, 0.1, 0.12)},
    'pickup': {'length': 4.8, 'cabin': (0.0, 0.3), 'cabin_height': 0.75, 'paint': (0.15, 0.3, 0.55), 'body_height': 0.8},
    'bus': {'length': 8.0, 'cabin': (-0.48, 0.48), 'cabin_height': 1.5, 'paint': (0.95, 0.7, 0.1), 'body_height': 1.0, 'axles': [-0.3, -0.22, 0.32]},
}
DEFAULTS: Spec = {'width': 1.8, 'body_height': 0.6, 'axles': [-0.3, 0.3]}


@register()
def wheel(*, radius: float = 0.35, width: float = 0.25) -> Shape:
    tire = primitive_call('cylinder', shape_kwargs={'radius': radius, 'p0': (0, 0, -width / 2), 'p1': (0, 0, width / 2)}, color=(0.08, 0.08, 0.08))
    rim = primitive_call('cylinder', shape_kwargs={'radius': radius * 0.6, 'p0': (0, 0, -width / 2 - 0.01), 'p1': (0, 0, width / 2 + 0.01)}, color=(0.75, 0.75, 0.78))
    return concat_shapes(tire, rim)


@register()
def cabin(*, length: float, width: float, height: float, paint) -> Shape:
    glass = primitive_call('cube', shape_kwargs={'scale': (length, height, width * 0.92)}, color=(0.55, 0.7, 0.8))
    roof = primitive_call('cube', shape_kwargs={'scale': (length, 0.08, width * 0.94)}, color=paint)
    n = max(2, round(length / 1.0) + 1)
    pillars = loop(n, lambda i: transform_shape(primitive_call('cube', shape_kwargs={'scale': (0.08, height, width * 0.94)}, color=paint),
                                                translation_matrix((-length / 2 + length * i / (n - 1), 0, 0))))
    return concat_shapes(glass, transform_shape(roof, translation_matrix((0, height / 2, 0))), pillars)


def build(model: str = 'sedan', /, **overrides) -> Shape:
    s = SimpleNamespace(**(DEFAULTS | MODELS[model] | overrides))
    ride, r = 0.35, 0.35
    y = ride + s.body_height / 2
    shapes = [transform_shape(primitive_call('cube', shape_kwargs={'scale': (s.length, s.body_height, s.width)}, color=s.paint), translation_matrix((0, y, 0)))]
    x0, x1 = (f * s.length for f in s.cabin)
    cab = library_call('cabin', length=x1 - x0, width=s.width, height=s.cabin_height, paint=s.paint)
    shapes.append(transform_shape(cab, translation_matrix(((x0 + x1) / 2, ride + s.body_height + s.cabin_height / 2, 0))))
    for f in s.axles:
        for side in (-1, 1):
            shapes.append(transform_shape(library_call('wheel', radius=r), translation_matrix((f * s.length, r, side * s.width / 2))))
    for side in (-1, 1):
        lamp = primitive_call('sphere', shape_kwargs={'radius': 0.12}, color=(1, 1, 0.8))
        shapes.append(transform_shape(lamp, translation_matrix((s.length / 2, y, side * s.width * 0.35))))
    return concat_shapes(*shapes)


@register()
def parking_row(gap: float = 1.0) -> Shape:
    out, z = [], 0.0
    for name in MODELS:
        shape = build(name) if name != 'sedan' else library_call('sedan_on_lot')
        depth = compute_shape_sizes(shape)[2]
        out.append(transform_shape(shape, translation_matrix((0, 0, z + depth / 2))))
        z += depth + gap
    return concat_shapes(*out)


@register()
def sedan_on_lot() -> Shape:
    return build('sedan', paint=(0.1, 0.5, 0.3))


@register()
def car_park() -> Shape:
    row = library_call('parking_row')
    c, s = compute_shape_center(row), compute_shape_sizes(row)
    lot = primitive_call('cube', shape_kwargs={'scale': (s[0] + 2, 0.1, s[2] + 2)}, color=(0.3, 0.3, 0.32))
    return concat_shapes(row, transform_shape(lot, translation_matrix((c[0], -0.05, c[2]))))
