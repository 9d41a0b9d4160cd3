import abc
from helper import *

"""
a small stage with percussion and wind instruments
"""

class Instrument(metaclass=abc.ABCMeta):
    registry: Dict[str, type] = {}

    def __init_subclass__(cls, **kwargs):
        super().__init_subclass__(**kwargs)
        Instrument.registry[cls.__name__.lower()] = cls

    @abc.abstractmethod
    def body(self) -> Shape:
        ...

    @classmethod
    def create(cls, name: str, *args) -> "Instrument":
        return cls.registry[name](*args)

class Xylophone(Instrument):
    def __init__(self, bars: int = 8):
        self.bars = bars

    def body(self) -> Shape:
        hues = [(1 - i / self.bars, 0.3, i / self.bars) for i in range(self.bars)]
        return loop(self.bars, lambda i: transform_shape(
            primitive_call('cube', color=hues[i], shape_kwargs={'scale': (0.15, 0.04, 1.2 - 0.09 * i)}),
            translation_matrix((0.2 * i, 1, 0))))

class Drum(Instrument):
    def __init__(self, radius: float = 0.5, depth: float = 0.4):
        self.radius = radius
        self.depth = depth

    def body(self) -> Shape:
        shell = primitive_call('cylinder', color=(0.7, 0.1, 0.1), shape_kwargs={'radius': self.radius, 'p0': (0, 0, 0), 'p1': (0, self.depth, 0)})
        skin = primitive_call('cylinder', color=(0.95, 0.93, 0.88), shape_kwargs={'radius': self.radius * 0.96, 'p0': (0, self.depth, 0), 'p1': (0, self.depth + 0.02, 0)})
        return concat_shapes(shell, skin)

class PanFlute(Instrument):
    def body(self) -> Shape:
        pipes = []
        length = 1.0
        for i in range(7):
            pipes.append(primitive_call('cylinder', color=(0.8, 0.7, 0.4), shape_kwargs={'radius': 0.06, 'p0': (0.13 * i, 1 - length, 0), 'p1': (0.13 * i, 1, 0)}))
            length *= 2 ** (-2 / 12)
        return concat_shapes(*pipes)

@register()
def instrument(name: str, args: tuple = ()) -> Shape:
    return Instrument.create(name, *args).body()

@register()
def stage() -> Shape:
    platform = transform_shape(primitive_call('cube', color=(0.35, 0.2, 0.12), shape_kwargs={'scale': (9, 0.3, 4)}), translation_matrix((2.5, -0.15, 0)))
    setlist = [('xylophone', ()), ('drum', (0.6, 0.5)), ('panflute', ()), ('drum', (0.35,)), ('xylophone', (5,))]
    shapes = [platform]
    for k, (name, args) in enumerate(setlist):
        shapes.append(transform_shape(library_call('instrument', name=name, args=args), translation_matrix((-1.2 + 1.9 * k, 0, 0.5 if k % 2 else -0.5))))
    # one spotlight for each known kind
    for k, name in enumerate(sorted(Instrument.registry)):
        light = primitive_call('sphere', color=(1, 1, 0.7), shape_kwargs={'radius': 0.05 * len(name) / 2})
        shapes.append(transform_shape(light, translation_matrix((2.5 * k, 4, 0))))
    return concat_shapes(*shapes)
