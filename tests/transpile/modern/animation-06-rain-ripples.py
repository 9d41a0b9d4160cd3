import random
from dataclasses import dataclass
from helper import *

"""
raindrops on a pond with rings that spread
"""


@dataclass(slots=True)
class Ripple:
    x: float
    z: float
    born: int
    strength: float = 1.0

    def radius(self, frame: int) -> float:
        return 0.1 + 0.15 * (frame - self.born)

    def alive(self, frame: int) -> bool:
        return self.radius(frame) < 1.2 * self.strength


@register()
def ring(radius: float, fade: float) -> Shape:
    n = 10
    tint = (0.3 + 0.5 * fade, 0.5 + 0.4 * fade, 0.9)
    return loop(n, lambda i: primitive_call('cylinder', color=tint, shape_kwargs={
        'radius': 0.02,
        'p0': (radius * math.cos(2 * math.pi * i / n), 0.02, radius * math.sin(2 * math.pi * i / n)),
        'p1': (radius * math.cos(2 * math.pi * (i + 1) / n), 0.02, radius * math.sin(2 * math.pi * (i + 1) / n)),
    }))


@register()
def pond() -> Shape:
    water = primitive_call('cylinder', color=(0.15, 0.3, 0.45), shape_kwargs={'radius': 3.5, 'p0': (0, -0.2, 0), 'p1': (0, 0, 0)})
    stones = loop(12, lambda i: transform_shape(primitive_call('sphere', color=(0.5, 0.5, 0.48), shape_kwargs={'radius': 0.3 + 0.05 * (i % 3)}), translation_matrix((3.5 * math.cos(i * math.pi / 6), 0, 3.5 * math.sin(i * math.pi / 6)))))
    return concat_shapes(water, stones)


def drops(rng, chance: float):
    """Endless stream: a drop or None for each frame."""
    while True:
        yield (rng.uniform(-2.5, 2.5), rng.uniform(-2.5, 2.5)) if rng.random() < chance else None


@register_animation()
def rain_on_pond() -> Generator[Shape, None, None]:
    still = library_call('pond')
    ripples: list[Ripple] = []
    for frame, drop in zip(range(25), drops(random.Random(8), 0.4)):
        match drop:
            case (x, z):
                ripples.append(Ripple(x, z, frame, random.uniform(0.6, 1.2)))
            case None:
                pass
        ripples = [r for r in ripples if r.alive(frame)]
        rings = [transform_shape(library_call('ring', radius=r.radius(frame), fade=1 / (1 + frame - r.born)), translation_matrix((r.x, 0, r.z))) for r in ripples]
        falling = [primitive_call('cylinder', color=(0.7, 0.8, 0.9), shape_kwargs={'radius': 0.02, 'p0': (drop[0], 0.3, drop[1]), 'p1': (drop[0], 0.9, drop[1])})] if drop else []
        yield concat_shapes(still, *rings, *falling)
