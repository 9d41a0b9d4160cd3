"""
an apartment block with balconies, shops on the ground floor and a roof with tanks
"""
from helper import *
import math
import random
from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from enum import Enum, auto


class Floor(Enum):
    SHOP = auto()
    FLAT = auto()
    ATTIC = auto()


@dataclass
class Style:
    wall: tuple[float, float, float] = (0.82, 0.74, 0.62)
    glass: tuple[float, float, float] = (0.45, 0.65, 0.8)
    trim: tuple[float, float, float] = (0.3, 0.28, 0.26)
    accents: list[tuple[float, float, float]] = field(default_factory=lambda: [(0.8, 0.2, 0.2), (0.2, 0.4, 0.7), (0.9, 0.7, 0.2)])


class Bay(ABC):
    def __init__(self, style: Style, width: float = 1.5, height: float = 1.2):
        self.style = style
        self.width = width
        self.height = height

    @abstractmethod
    def parts(self) -> list[Shape]:
        ...

    def build(self, x: float, y: float) -> Shape:
        return transform_shape(concat_shapes(*self.parts()), translation_matrix((x, y, 0)))


class WindowBay(Bay):
    def __init__(self, style: Style, shutters: bool = True, **kwargs):
        super().__init__(style, **kwargs)
        self.shutters = shutters

    def parts(self):
        pane = primitive_call('cube', color=self.style.glass, shape_kwargs={'scale': (self.width * 0.5, self.height * 0.6, 0.05)})
        result = [pane]
        if self.shutters:
            for side in (-1, 1):
                shutter = primitive_call('cube', color=self.style.trim, shape_kwargs={'scale': (self.width * 0.15, self.height * 0.62, 0.06)})
                result.append(transform_shape(shutter, translation_matrix((side * self.width * 0.34, 0, 0))))
        return result


class BalconyBay(WindowBay):
    def parts(self):
        base = super().parts()
        slab = transform_shape(
            primitive_call('cube', color=self.style.trim, shape_kwargs={'scale': (self.width * 0.9, 0.06, 0.5)}),
            translation_matrix((0, -self.height * 0.4, 0.25)))
        bars = [
            transform_shape(primitive_call('cube', color=self.style.trim, shape_kwargs={'scale': (0.03, 0.4, 0.03)}),
                            translation_matrix((self.width * (k / 8 - 0.4375), -self.height * 0.22, 0.48)))
            for k in range(8)
        ]
        return base + [slab, *bars]


class ShopBay(Bay):
    def __init__(self, style, accent, **kwargs):
        super().__init__(style, **kwargs)
        self.accent = accent

    def parts(self):
        window = primitive_call('cube', color=self.style.glass, shape_kwargs={'scale': (self.width * 0.85, self.height * 0.7, 0.04)})
        awning = transform_shape(
            transform_shape(primitive_call('cube', color=self.accent, shape_kwargs={'scale': (self.width * 0.9, 0.04, 0.5)}),
                            rotation_matrix(math.radians(20), (1, 0, 0), (0, 0, 0))),
            translation_matrix((0, self.height * 0.45, 0.2)))
        return [window, awning]


def floor_kind(level: int, total: int) -> Floor:
    match level:
        case 0:
            return Floor.SHOP
        case n if n == total - 1:
            return Floor.ATTIC
        case _:
            return Floor.FLAT


@register()
def water_tank(radius: float = 0.4) -> Shape:
    tank = primitive_call('cylinder', color=(0.45, 0.3, 0.2), shape_kwargs={'radius': radius, 'p0': (0, 0.3, 0), 'p1': (0, 1.1, 0)})
    legs = loop(4, lambda i: transform_shape(
        primitive_call('cube', color=(0.2, 0.2, 0.2), shape_kwargs={'scale': (0.06, 0.3, 0.06)}),
        translation_matrix((radius * 0.7 * math.cos(math.pi / 4 + i * math.pi / 2), 0.15, radius * 0.7 * math.sin(math.pi / 4 + i * math.pi / 2)))))
    return concat_shapes(tank, legs)


@register()
def facade(floors: int = 6, bays: int = 5) -> Shape:
    random.seed(12)
    style = Style()
    height = 1.2
    shapes = []
    for level in range(floors):
        kind = floor_kind(level, floors)
        for b in range(bays):
            x = (b - (bays - 1) / 2) * 1.5
            y = (level + 0.5) * height
            if kind is Floor.SHOP:
                bay = ShopBay(style, random.choice(style.accents))
            elif kind is Floor.FLAT and (b + level) % 2 == 0:
                bay = BalconyBay(style, shutters=False)
            else:
                bay = WindowBay(style, shutters=kind is Floor.FLAT)
            shapes.append(bay.build(x, y))
    wall = transform_shape(primitive_call('cube', color=style.wall, shape_kwargs={'scale': (bays * 1.5, floors * height, 3)}),
                           translation_matrix((0, floors * height / 2, -1.53)))
    return concat_shapes(wall, *shapes)


@register()
def apartment_block() -> Shape:
    front = library_call('facade', floors=6, bays=5)
    top = compute_shape_max(front)[1]
    tanks = [transform_shape(library_call('water_tank', radius=r), translation_matrix((x, top, -1.5))) for x, r in ((-2, 0.4), (1.5, 0.55))]
    return concat_shapes(front, *tanks)
