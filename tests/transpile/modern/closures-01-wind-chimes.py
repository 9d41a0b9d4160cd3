from helper import *
import math

"""
wind chimes: closures with late binding, defaults and counters
"""


def make_counter(start: int = 0, step: int = 1):
    value = start - step

    def tick() -> int:
        nonlocal value
        value += step
        return value

    def reset() -> None:
        nonlocal value
        value = start - step

    return tick, reset


def tubes_late() -> list:
    # every function sees the last i
    return [lambda: 0.3 + 0.1 * i for i in range(6)]


def tubes_early() -> list:
    return [lambda i=i: 0.3 + 0.1 * i for i in range(6)]


def accumulator():
    history = []

    def add(x: float) -> float:
        history.append(x)
        return sum(history)

    add.history = history
    return add


@register()
def chime(lengths: list, color: tuple) -> Shape:
    ring = primitive_call('cylinder', color=(0.5, 0.35, 0.2), shape_kwargs={'radius': 0.8, 'p0': (0, 0, 0), 'p1': (0, 0.08, 0)})
    tick, reset = make_counter(step=60)
    tubes = []
    for length in lengths:
        a = math.radians(tick())
        x, z = 0.6 * math.cos(a), 0.6 * math.sin(a)
        tubes.append(primitive_call('cylinder', color=color, shape_kwargs={'radius': 0.05, 'p0': (x, -0.3, z), 'p1': (x, -0.3 - 2 * length, z)}))
    reset()
    assert tick() == 0
    return concat_shapes(ring, *tubes)


@register()
def porch() -> Shape:
    add = accumulator()
    builders = {
        'same': lambda: [f() for f in tubes_late()],
        'rising': lambda: [f() for f in tubes_early()],
        'sums': lambda: [add(0.1) for _ in range(5)],
    }
    offset = 0
    shapes = []

    def place(shape):
        nonlocal offset
        shapes.append(transform_shape(shape, translation_matrix((offset, 0, 0))))
        offset += 2.5

    for k, (name, build) in enumerate(builders.items()):
        place(library_call('chime', lengths=build(), color=(0.7, 0.7 - 0.1 * k, 0.5 + 0.1 * k)))
    if len(add.history) > 4:
        def hook(x):
            return primitive_call('cylinder', color=(0.2, 0.2, 0.2), shape_kwargs={'radius': 0.02, 'p0': (x, 0, 0), 'p1': (x, 1, 0)})
    else:
        def hook(x):
            return primitive_call('sphere')
    beam = transform_shape(primitive_call('cube', color=(0.6, 0.45, 0.3), shape_kwargs={'scale': (offset, 0.2, 0.3)}), translation_matrix((offset / 2 - 1.25, 1.1, 0)))
    return concat_shapes(beam, *shapes, *[hook(2.5 * k) for k in range(3)])
