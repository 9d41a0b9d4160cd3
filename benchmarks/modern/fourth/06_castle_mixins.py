"""
a castle whose towers are combined from mixin classes
"""
from helper import *
import math

STONE = (0.6, 0.6, 0.58)
ROOF = (0.55, 0.15, 0.12)
FLAG = (0.9, 0.8, 0.1)


def at(shape, x=0.0, y=0.0, z=0.0):
    return transform_shape(shape, translation_matrix((x, y, z)))


class Component:
    registry: dict[str, type] = {}

    def __init_subclass__(cls, /, tag: str | None = None, **kwargs):
        super().__init_subclass__(**kwargs)
        if tag:
            Component.registry[tag] = cls

    def __init__(self, height=3.0, radius=0.8):
        self.height = height
        self.radius = radius

    def shapes(self):
        return [primitive_call('cylinder', color=STONE, shape_kwargs={'radius': self.radius, 'p0': (0, 0, 0), 'p1': (0, self.height, 0)})]


class Battlements:
    merlons = 8

    def shapes(self):
        out = super().shapes()
        for k in range(self.merlons):
            a = 2 * math.pi * k / self.merlons
            merlon = primitive_call('cube', color=STONE, shape_kwargs={'scale': (0.25, 0.35, 0.25)})
            out.append(at(merlon, self.radius * math.cos(a), self.height + 0.17, self.radius * math.sin(a)))
        return out


class Roofed:
    def shapes(self):
        out = super().shapes()
        steps = 6
        for s in range(steps):
            r = self.radius * 1.15 * (1 - s / steps)
            out.append(primitive_call('cylinder', color=ROOF, shape_kwargs={'radius': r, 'p0': (0, self.height + s * 0.2, 0), 'p1': (0, self.height + (s + 1) * 0.2, 0)}))
        return out


class Flagged:
    def shapes(self):
        out = super().shapes()
        top = compute_shape_max(concat_shapes(*out))[1]
        out.append(primitive_call('cylinder', color=(0.2, 0.2, 0.2), shape_kwargs={'radius': 0.03, 'p0': (0, top, 0), 'p1': (0, top + 0.8, 0)}))
        out.append(at(primitive_call('cube', color=FLAG, shape_kwargs={'scale': (0.4, 0.25, 0.02)}), 0.2, top + 0.65))
        return out


class Keep(Flagged, Battlements, Component, tag='keep'):
    merlons = 12


class Spire(Flagged, Roofed, Component, tag='spire'):
    pass


class Watch(Battlements, Component, tag='watch'):
    pass


@register()
def tower(kind: str, height: float = 3.0, radius: float = 0.8) -> Shape:
    try:
        cls = Component.registry[kind]
    except KeyError:
        cls = Component
    return concat_shapes(*cls(height=height, radius=radius).shapes())


@register()
def castle() -> Shape:
    corners = [(-4, -4), (4, -4), (4, 4), (-4, 4)]
    kinds = ['spire', 'watch', 'spire', 'plain']
    towers = [at(library_call('tower', kind=k, height=3 + 0.3 * i), x, 0, z) for i, (k, (x, z)) in enumerate(zip(kinds, corners))]
    walls = []
    for (x0, z0), (x1, z1) in zip(corners, corners[1:] + corners[:1]):
        length = math.dist((x0, z0), (x1, z1))
        wall = primitive_call('cube', color=STONE, shape_kwargs={'scale': (length, 2, 0.5)})
        wall = transform_shape(wall, rotation_matrix(math.atan2(z0 - z1, x1 - x0), (0, 1, 0), (0, 0, 0)))
        walls.append(at(wall, (x0 + x1) / 2, 1, (z0 + z1) / 2))
    keep = library_call('tower', kind='keep', height=5.0, radius=1.4)
    return concat_shapes(*towers, *walls, keep)
