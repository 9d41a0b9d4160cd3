from helper import *

"""
a village street of houses, barns and a church
"""


class Building:
    wall_color = (0.85, 0.8, 0.7)
    roof_color = (0.6, 0.25, 0.15)
    count = 0

    def __init__(self, width: float, depth: float, height: float):
        self.width, self.depth, self.height = width, depth, height
        Building.count += 1
        self.number = Building.count

    def walls(self) -> Shape:
        box = primitive_call('cube', color=self.wall_color, shape_kwargs={'scale': (self.width, self.height, self.depth)})
        return transform_shape(box, translation_matrix((0, self.height / 2, 0)))

    def roof(self) -> Shape:
        panels = []
        for sign in (-1, 1):
            panel = primitive_call('cube', color=self.roof_color, shape_kwargs={'scale': (self.width * 0.62, 0.1, self.depth * 1.1)})
            panel = transform_shape(panel, rotation_matrix(-sign * math.pi / 5, direction=(0, 0, 1), point=(0, 0, 0)))
            panels.append(transform_shape(panel, translation_matrix((sign * self.width / 4, self.height + self.width * 0.17, 0))))
        return concat_shapes(*panels)

    def extras(self) -> list:
        return []

    def build(self) -> Shape:
        return concat_shapes(self.walls(), self.roof(), *self.extras())


class Cottage(Building):
    def __init__(self, width: float = 2.0):
        super().__init__(width, 2.4, 1.3)

    def extras(self) -> list:
        smoke = loop(self.number % 3 + 1, lambda i: transform_shape(
            primitive_call('sphere', color=(0.8, 0.8, 0.8), shape_kwargs={'radius': 0.1 + 0.04 * i}), translation_matrix((0.5, 2.4 + 0.3 * i, 0))))
        return super().extras() + [smoke]


class Barn(Building):
    wall_color = (0.6, 0.15, 0.12)

    def extras(self) -> list:
        door = primitive_call('cube', color=(0.95, 0.95, 0.95), shape_kwargs={'scale': (0.9, 1.1, 0.05)})
        return [*super().extras(), transform_shape(door, translation_matrix((0, 0.55, self.depth / 2)))]


class Church(Cottage):
    roof_color = (0.3, 0.35, 0.4)

    def __init__(self):
        super().__init__(width=2.6)
        self.height *= 1.5

    def extras(self) -> list:
        steeple = primitive_call('cube', color=self.wall_color, shape_kwargs={'scale': (0.8, 4.5, 0.8)})
        cross = primitive_call('cylinder', color=(0.9, 0.8, 0.2), shape_kwargs={'radius': 0.04, 'p0': (0, 4.5, 1.4), 'p1': (0, 5.2, 1.4)})
        return super().extras() + [transform_shape(steeple, translation_matrix((0, 2.25, 1.4))), cross]


@register("village street")
def village() -> Shape:
    buildings: list[Building] = [Cottage(), Cottage(1.8), Barn(3, 3, 1.8), Church(), Cottage(2.2), Building(2, 2, 2)]
    shapes, x = [], 0.0
    for b in buildings:
        x += b.width / 2
        shapes.append(transform_shape(b.build(), translation_matrix((x, 0, 0))))
        x += b.width / 2 + 0.8
    churches = sum(isinstance(b, Church) for b in buildings)
    road = primitive_call('cube', color=(0.45, 0.42, 0.4), shape_kwargs={'scale': (x, 0.05, 1.5 * churches)})
    return concat_shapes(*shapes, transform_shape(road, translation_matrix((x / 2, 0, 3))))
