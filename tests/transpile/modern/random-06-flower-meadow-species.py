import random
from abc import ABC, abstractmethod
from helper import *

"""
a meadow where each species draws its own random numbers
"""

class Species(ABC):
    abundance = 1

    def __init__(self, rng):
        self.rng = rng

    @abstractmethod
    def bloom(self) -> Shape: ...

    def specimen(self) -> Shape:
        h = self.rng.uniform(0.3, 0.7)
        stem = primitive_call('cylinder', color=(0.25, 0.55, 0.2), shape_kwargs={'radius': 0.02, 'p0': (0, 0, 0), 'p1': (0, h, 0)})
        return concat_shapes(stem, transform_shape(self.bloom(), translation_matrix((0, h, 0))))

class Daisy(Species):
    abundance = 5

    def bloom(self):
        n = self.rng.randint(5, 8)
        petals = loop(n, lambda i: transform_shape(primitive_call('sphere', color=(1, 1, 1), shape_kwargs={'radius': 0.06}), translation_matrix((0.1 * math.cos(2 * math.pi * i / n), 0, 0.1 * math.sin(2 * math.pi * i / n)))))
        return concat_shapes(primitive_call('sphere', color=(1, 0.8, 0.1), shape_kwargs={'radius': 0.06}), petals)

class Poppy(Species):
    abundance = 3

    def bloom(self):
        red = (self.rng.uniform(0.7, 1.0), self.rng.triangular(0, 0.3), 0.1)
        return primitive_call('sphere', color=red, shape_kwargs={'radius': self.rng.uniform(0.08, 0.13)})

class Thistle(Species):
    def bloom(self):
        spikes = [[self.rng.gauss(0, 0.1) for _ in range(3)] for _ in range(6)]
        return concat_shapes(*[primitive_call('cylinder', color=(0.5, 0.2, 0.6), shape_kwargs={'radius': 0.015, 'p0': (0, 0, 0), 'p1': (x, abs(y) + 0.1, z)}) for x, y, z in spikes])

@register()
def patch(species: Species, size: float) -> Shape:
    turf = primitive_call('cube', color=(0.3, 0.5, 0.2), shape_kwargs={'scale': (size, 0.05, size)})
    plants = []
    for _ in range(species.abundance):
        x, z = (species.rng.uniform(-size / 2, size / 2) for _ in "xz")
        plants.append(transform_shape(species.specimen(), translation_matrix((x, 0, z))))
    return concat_shapes(turf, *plants)

@register()
def meadow() -> Shape:
    kinds = Species.__subclasses__()
    pool = [cls for cls in kinds for _ in range(cls.abundance)]
    random.shuffle(pool)
    shapes = []
    for i, cls in enumerate(pool):
        rng = random if i % 3 else random.Random(i)
        shapes.append(transform_shape(library_call('patch', species=cls(rng), size=1.0), translation_matrix((1.05 * (i % 3), 0, 1.05 * (i // 3)))))
    return concat_shapes(*shapes)
