"""a dining room with a table, six chairs and a pendant lamp"""
from helper import *
from abc import ABC, abstractmethod
from dataclasses import dataclass, field
import math


@dataclass(kw_only=True)
class Part(ABC):
    color: tuple[float, float, float] = (0.5, 0.35, 0.2)

    @abstractmethod
    def build(self) -> Shape: ...

    def box(self, size, at) -> Shape:
        return transform_shape(primitive_call('cube', shape_kwargs={'scale': size}, color=self.color), translation_matrix(at))

    def post(self, x, z, y0, y1, r) -> Shape:
        return primitive_call('cylinder', shape_kwargs={'radius': r, 'p0': (x, y0, z), 'p1': (x, y1, z)}, color=self.color)


@dataclass(kw_only=True)
class Legged(Part):
    width: float
    depth: float
    height: float
    leg_radius: float = 0.04
    inset: float = field(init=False)

    def __post_init__(self):
        self.inset = self.leg_radius * 1.5

    def legs(self) -> Shape:
        dx, dz = self.width / 2 - self.inset, self.depth / 2 - self.inset
        return concat_shapes(*(self.post(sx * dx, sz * dz, 0, self.height, self.leg_radius) for sx in (-1, 1) for sz in (-1, 1)))

    def build(self) -> Shape:
        return concat_shapes(self.legs(), self.box((self.width, 0.05, self.depth), (0, self.height, 0)))


@dataclass(kw_only=True)
class ChairPart(Legged):
    back_height: float = 0.5

    def build(self) -> Shape:
        seat = super().build()
        y = self.height + self.back_height / 2
        back = self.box((self.width, self.back_height, 0.05), (0, y, -self.depth / 2))
        return concat_shapes(seat, back)


@register()
def table(width: float = 2.4, depth: float = 1.1) -> Shape:
    return Legged(width=width, depth=depth, height=0.75, leg_radius=0.06).build()


@register()
def chair(facing: float = 0.0) -> Shape:
    return transform_shape(ChairPart(width=0.45, depth=0.45, height=0.45, color=(0.3, 0.2, 0.12)).build(),
                           rotation_matrix(facing, (0, 1, 0), (0, 0, 0)))


@register()
def pendant_lamp(drop: float = 1.0, ceiling: float = 2.6) -> Shape:
    y = ceiling - drop
    cord = primitive_call('cylinder', shape_kwargs={'radius': 0.01, 'p0': (0, y, 0), 'p1': (0, ceiling, 0)}, color=(0.05, 0.05, 0.05))
    shade = loop(8, lambda i: primitive_call('cylinder', shape_kwargs={'radius': 0.05 + 0.03 * i, 'p0': (0, y - 0.03 * i, 0), 'p1': (0, y - 0.03 * (i + 1), 0)}, color=(0.1, 0.1, 0.1)))
    bulb = transform_shape(primitive_call('sphere', shape_kwargs={'radius': 0.08}, color=(1, 0.95, 0.7)), translation_matrix((0, y - 0.26, 0)))
    return concat_shapes(cord, shade, bulb)


@register()
def dining_room() -> Shape:
    placements = [((x, 0, z), 0.0 if z < 0 else math.pi) for x in (-0.7, 0, 0.7) for z in (-0.75, 0.75)]
    chairs = [transform_shape(library_call('chair', facing=f), translation_matrix(p)) for p, f in placements]
    floor = transform_shape(primitive_call('cube', shape_kwargs={'scale': (5, 0.1, 4)}, color=(0.7, 0.6, 0.45)), translation_matrix((0, -0.05, 0)))
    return concat_shapes(floor, library_call('table'), library_call('pendant_lamp'), *chairs)
