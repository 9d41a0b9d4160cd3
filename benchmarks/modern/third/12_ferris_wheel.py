"""
a ferris wheel with coloured gondolas and a ticket booth
"""
from helper import *
import math
from collections.abc import Iterable
from itertools import cycle, islice, chain
from functools import partial

PALETTE = [(0.9, 0.2, 0.2), (0.95, 0.7, 0.1), (0.2, 0.6, 0.9), (0.3, 0.75, 0.35)]


def polar(radius: float, angle: float, /, *, z: float = 0.0) -> tuple[float, float, float]:
    return (radius * math.cos(angle), radius * math.sin(angle), z)


def rod(a, b, radius=0.05, color=(0.7, 0.7, 0.75)):
    return primitive_call('cylinder', color=color, shape_kwargs={'radius': radius, 'p0': a, 'p1': b})


strut = partial(rod, radius=0.12, color=(0.4, 0.4, 0.45))


def compose(*functions):
    def run(shape):
        for f in functions:
            shape = f(shape)
        return shape
    return run


def moved(x=0.0, y=0.0, z=0.0):
    return lambda shape: transform_shape(shape, translation_matrix((x, y, z)))


def turned(angle, axis=(0, 0, 1)):
    return lambda shape: transform_shape(shape, rotation_matrix(angle, axis, (0, 0, 0)))


@register()
def gondola(color: tuple = (0.9, 0.2, 0.2), size: float = 0.5) -> Shape:
    cabin = primitive_call('cube', color=color, shape_kwargs={'scale': (size, size * 0.8, size)})
    roof = primitive_call('cylinder', color=(0.95, 0.95, 0.95), shape_kwargs={'radius': size * 0.7, 'p0': (0, size * 0.4, 0), 'p1': (0, size * 0.5, 0)})
    hook = rod((0, size * 0.5, 0), (0, size * 1.0, 0))
    return compose(moved(y=-size))(concat_shapes(cabin, roof, hook))


@register()
def wheel(spokes: int = 12, radius: float = 3.0, turn: float = 0.1) -> Shape:
    angles = [turn + k * math.tau / spokes for k in range(spokes)]
    parts: list[Shape] = []
    for z in (-0.35, 0.35):
        parts.extend(rod((0, 0, z), polar(radius, a, z=z)) for a in angles)
        parts.extend(rod(polar(radius, a, z=z), polar(radius, b, z=z)) for a, b in zip(angles, angles[1:] + angles[:1]))
    axles = [rod(polar(radius, a, z=-0.35), polar(radius, a, z=0.35)) for a in angles]
    colors = islice(cycle(PALETTE), spokes)
    cabins = [compose(moved(*polar(radius, a)))(library_call('gondola', color=c)) for a, c in zip(angles, colors)]
    return concat_shapes(*chain(parts, axles, cabins))


@register()
def support(height: float = 4.0, spread: float = 1.8) -> Shape:
    legs = [strut((s * spread, -height, z), (0, 0, z)) for s in (-1, 1) for z in (-0.6, 0.6)]
    hub = strut((0, 0, -0.7), (0, 0, 0.7), radius=0.25)
    return concat_shapes(*legs, hub)


@register()
def booth(stripes: int = 6) -> Shape:
    width = 1.2 / stripes
    awning = [compose(moved(x=(i + 0.5) * width - 0.6, y=1.4), turned(0.3, (1, 0, 0)))(
        primitive_call('cube', color=(0.9, 0.1, 0.1) if i % 2 else (1, 1, 1), shape_kwargs={'scale': (width, 0.05, 0.8)})) for i in range(stripes)]
    counter = moved(y=0.5)(primitive_call('cube', color=(0.6, 0.45, 0.3), shape_kwargs={'scale': (1.2, 1.0, 0.8)}))
    return concat_shapes(counter, *awning)


@register()
def fairground() -> Shape:
    ride = moved(y=4.0)(concat_shapes(library_call('support'), library_call('wheel', spokes=10)))
    ground = moved(y=-0.05)(primitive_call('cube', color=(0.5, 0.6, 0.4), shape_kwargs={'scale': (10, 0.1, 6)}))
    return concat_shapes(ground, ride, compose(turned(-0.4, (0, 1, 0)), moved(x=3.5, z=1.5))(library_call('booth')))
