from helper import *

"""
a balance scale with brass weights on both pans
"""

class Weight:
    _made = 0
    DENSITY = 8.5

    def __init__(self, grams: float):
        self.grams = grams
        Weight._made += 1

    @classmethod
    def from_ounces(cls, ounces):
        return cls(ounces * 28.35)

    @classmethod
    def set_of(cls, *grams):
        return [cls(g) for g in grams]

    @classmethod
    def made(cls):
        return cls._made

    @staticmethod
    def radius_for(grams, density=DENSITY):
        return (3 * grams / (4 * math.pi * density)) ** (1 / 3) / 10

    @property
    def radius(self):
        return self.radius_for(self.grams)

class LeadWeight(Weight):
    DENSITY = 11.3

    @property
    def radius(self):
        return self.radius_for(self.grams, self.DENSITY)

@register()
def pan(weights: list) -> Shape:
    plate = primitive_call('cylinder', color=(0.8, 0.65, 0.2), shape_kwargs={'radius': 0.8, 'p0': (0, -0.05, 0), 'p1': (0, 0, 0)})
    chains = loop(3, lambda i: primitive_call('cylinder', color=(0.5, 0.5, 0.5), shape_kwargs={
        'radius': 0.015, 'p0': (0.75 * math.cos(2.1 * i), 0, 0.75 * math.sin(2.1 * i)), 'p1': (0, 1.5, 0)}))
    balls = []
    for i, w in enumerate(weights):
        color = (0.3, 0.3, 0.35) if isinstance(w, LeadWeight) else (0.85, 0.7, 0.3)
        angle = i * 2 * math.pi / len(weights)
        balls.append(transform_shape(primitive_call('sphere', color=color, shape_kwargs={'radius': w.radius}),
                                     translation_matrix((0.45 * math.cos(angle), w.radius, 0.45 * math.sin(angle)))))
    return concat_shapes(plate, chains, *balls)

@register()
def balance() -> Shape:
    left = Weight.set_of(50, 20, 10, 5)
    right = [Weight.from_ounces(1), *LeadWeight.set_of(30, 40)]
    difference = sum(w.grams for w in left) - sum(w.grams for w in right)
    tilt = max(-0.3, min(0.3, difference / 100))
    beam = primitive_call('cube', color=(0.7, 0.55, 0.15), shape_kwargs={'scale': (4, 0.1, 0.15)})
    beam = transform_shape(beam, translation_matrix((0, 3, 0)) @ rotation_matrix(tilt, (0, 0, 1), (0, 0, 0)))
    post = primitive_call('cylinder', color=(0.4, 0.25, 0.1), shape_kwargs={'radius': 0.1, 'p0': (0, 0, 0), 'p1': (0, 3.2, 0)})
    feet = loop(Weight.made(), lambda i: transform_shape(primitive_call('cube', color=(0.3, 0.2, 0.1), shape_kwargs={'scale': (0.2, 0.1, 1)}), translation_matrix((0.22 * (i - 3), 0, 0))))
    shapes = [beam, post, feet]
    for side, weights in ((-1, left), (1, right)):
        y = 3 + side * 2 * math.sin(tilt) - 1.5
        shapes.append(transform_shape(library_call('pan', weights=weights), translation_matrix((side * 2 * math.cos(tilt), y, 0))))
    return concat_shapes(*shapes)
