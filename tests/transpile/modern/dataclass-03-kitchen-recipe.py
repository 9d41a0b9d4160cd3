from __future__ import annotations
from dataclasses import dataclass, field, InitVar
from helper import *

"""
layer cakes on a counter, configured with nested dataclasses
"""

RGB = tuple[float, float, float]


@dataclass(kw_only=True)
class Layer:
    thickness: float
    color: RGB
    filling: RGB | None = None


@dataclass
class Cake:
    radius: float
    layers: list[Layer] = field(default_factory=list)
    candles: int = 0
    base_height: InitVar[float] = 0.1
    height: float = field(init=False)

    def __post_init__(self, base_height: float) -> None:
        self.height = base_height + sum(layer.thickness for layer in self.layers)
        self._base = base_height

    def add(self, **spec) -> Cake:
        layer = Layer(**spec)
        self.layers.append(layer)
        self.height += layer.thickness
        return self

    def __len__(self) -> int:
        return len(self.layers)


def drum(radius: float, bottom: float, top: float, color: RGB) -> Shape:
    return primitive_call('cylinder', color=color, shape_kwargs={'radius': radius, 'p0': (0, bottom, 0), 'p1': (0, top, 0)})


@register()
def candle() -> Shape:
    flame = transform_shape(primitive_call('sphere', color=(1, 0.7, 0.1), shape_kwargs={'radius': 0.05}), translation_matrix((0, 0.35, 0)))
    return concat_shapes(drum(0.03, 0, 0.3, (0.9, 0.9, 1)), flame)


@register()
def cake(spec: Cake) -> Shape:
    shapes = [drum(spec.radius * 1.2, 0, spec._base, (0.9, 0.9, 0.9))]
    y = spec._base
    for layer in spec.layers:
        top = y + layer.thickness
        shapes.append(drum(spec.radius, y, top, layer.color))
        if layer.filling is not None:
            shapes.append(drum(spec.radius * 1.02, top - 0.04, top, layer.filling))
        y = top
    for k in range(spec.candles):
        a = 2 * math.pi * k / spec.candles
        shapes.append(transform_shape(library_call('candle'), translation_matrix((0.7 * spec.radius * math.cos(a), spec.height, 0.7 * spec.radius * math.sin(a)))))
    return concat_shapes(*shapes)


@register()
def bakery_counter() -> Shape:
    cream, cocoa, berry = (0.98, 0.95, 0.85), (0.35, 0.2, 0.1), (0.8, 0.2, 0.4)
    cakes = [
        Cake(0.8).add(thickness=0.3, color=cocoa, filling=cream).add(thickness=0.3, color=cocoa),
        Cake(0.6, [Layer(thickness=0.5, color=cream)], candles=5, base_height=0.2),
        Cake(0.9, candles=3).add(color=berry, thickness=0.2).add(color=cream, thickness=0.25, filling=berry).add(color=berry, thickness=0.2),
    ]
    cakes.sort(key=len)
    x, shapes = 0.0, [transform_shape(primitive_call('cube', color=(0.6, 0.6, 0.62), shape_kwargs={'scale': (8, 0.2, 2.5)}), translation_matrix((2.5, -0.1, 0)))]
    for c in cakes:
        shapes.append(transform_shape(library_call('cake', spec=c), translation_matrix((x, 0, 0))))
        x += 2 * c.radius + 0.8
    return concat_shapes(*shapes)
