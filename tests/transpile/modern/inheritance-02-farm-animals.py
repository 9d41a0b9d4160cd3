import math
from helper import *

"""
farm animals built through mixins and a diamond of classes
"""


class Animal:
    color = (0.6, 0.5, 0.4)
    legs = 4

    def __init__(self, size=1.0, **traits):
        self.size = size
        self.traits = traits

    def parts(self):
        s = self.size
        yield transform_shape(transform_shape(primitive_call('sphere', color=self.color, shape_kwargs={'radius': s}), scale_matrix((1.4, .8, .8), (0, 0, 0))), translation_matrix((0, 1.2 * s, 0)))
        for i in range(self.legs):
            a = 2 * math.pi * (i + .5) / self.legs
            x, z = s * math.cos(a), .5 * s * math.sin(a)
            yield primitive_call('cylinder', color=self.color, shape_kwargs={'radius': .12 * s, 'p0': (x, 0, z), 'p1': (x, s, z)})


class Horned(Animal):
    horn_color = (.95, .92, .8)

    def parts(self):
        yield from super().parts()
        s = self.size
        for side in (-1, 1):
            yield primitive_call('cylinder', color=self.horn_color, shape_kwargs={'radius': .07 * s, 'p0': (1.5 * s, 2 * s, .2 * side * s), 'p1': (1.6 * s, 2.5 * s, .5 * side * s)})


class Tailed(Animal):
    def parts(self):
        yield from super().parts()
        length = self.traits.get('tail', .6) * self.size
        yield primitive_call('cylinder', color=self.color, shape_kwargs={'radius': .06, 'p0': (-1.3 * self.size, 1.3 * self.size, 0), 'p1': (-1.3 * self.size - length / 2, 1.3 * self.size - length, 0)})


class Cow(Horned, Tailed):
    color = (.9, .9, .88)

    def parts(self):
        yield from super().parts()
        head = primitive_call('sphere', color=(.2, .2, .2), shape_kwargs={'radius': .45 * self.size})
        yield transform_shape(head, translation_matrix((1.6 * self.size, 1.7 * self.size, 0)))


class Chicken(Tailed):
    color = (.95, .85, .6)
    legs = 2


print([c.__name__ for c in Cow.__mro__])


@register()
def animal(kind: str, size: float, tail: float = .6) -> Shape:
    cls = {'cow': Cow, 'chicken': Chicken, 'goat': Horned}[kind]
    return concat_shapes(*cls(size, tail=tail).parts())


@register()
def farmyard() -> Shape:
    herd = [('cow', 1.0, 1.1), ('cow', .7, .8), ('goat', .6, 0), ('chicken', .3, .5), ('chicken', .25, .9), ('chicken', .35, .2)]
    placed = [
        transform_shape(library_call('animal', kind=kind, size=size, tail=tail),
                        translation_matrix((4 * (i % 3), 0, 3 * (i // 3))) @ rotation_matrix(.5 * i, (0, 1, 0), (0, 0, 0)))
        for i, (kind, size, tail) in enumerate(herd)
    ]
    ground = transform_shape(primitive_call('cube', color=(.4, .6, .3), shape_kwargs={'scale': (14, .1, 9)}), translation_matrix((4, -.05, 1.5)))
    return concat_shapes(ground, *placed)
