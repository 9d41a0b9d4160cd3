"""a street crossing with traffic lights, zebra stripes and two cars"""
from helper import *
import math
from enum import Enum


class Signal(Enum):
    RED = (0.9, 0.1, 0.1)
    AMBER = (0.95, 0.65, 0.1)
    GREEN = (0.1, 0.8, 0.25)


ASPHALT = (0.2, 0.2, 0.22)
PAINT = (0.95, 0.95, 0.95)


def slab(w, h, d, x=0.0, y=0.0, z=0.0, color=ASPHALT):
    """A box whose underside is at y."""
    return transform_shape(primitive_call('cube', shape_kwargs={'scale': (w, h, d)}, color=color),
                           translation_matrix((x, y + h / 2, z)))


@register("a traffic light that shows one signal")
def traffic_light(lit: int = 0, height: float = 2.6) -> Shape:
    pole = primitive_call('cylinder', shape_kwargs={'radius': 0.05, 'p0': (0, 0, 0), 'p1': (0, height, 0)}, color=(0.3, 0.3, 0.3))
    case = slab(0.26, 0.72, 0.2, 0, height, 0, (0.08, 0.08, 0.08))
    lamps = []
    for index, signal in enumerate(Signal):
        dim = 1.0 if index == lit else 0.25
        color = tuple(channel * dim for channel in signal.value)
        lamp = primitive_call('sphere', shape_kwargs={'radius': 0.085}, color=color)
        lamps.append(transform_shape(lamp, translation_matrix((0, height + 0.6 - 0.24 * index, 0.09))))
    return concat_shapes(pole, case, *lamps)


@register("white stripes across a road that runs along z")
def zebra(stripes: int = 6, width: float = 3.0) -> Shape:
    pitch = width / stripes
    return loop(stripes, lambda i: slab(pitch * 0.5, 0.01, 1.0, -width / 2 + pitch * (i + 0.5), 0.005, 0, PAINT))


@register("a small car that looks along +x")
def car(body: tuple[float, float, float] = (0.8, 0.15, 0.1)) -> Shape:
    chassis = slab(1.7, 0.35, 0.75, 0, 0.18, 0, body)
    cabin = slab(0.85, 0.32, 0.66, -0.1, 0.53, 0, (0.6, 0.75, 0.85))
    roof = slab(0.8, 0.04, 0.68, -0.1, 0.85, 0, body)
    wheels = [
        primitive_call('cylinder', shape_kwargs={'radius': 0.19, 'p0': (x, 0.19, z - 0.07), 'p1': (x, 0.19, z + 0.07)}, color=(0.05, 0.05, 0.05))
        for x in (-0.52, 0.52) for z in (-0.36, 0.36)
    ]
    lights = [transform_shape(primitive_call('sphere', shape_kwargs={'radius': 0.07}, color=(1, 1, 0.8)),
                              translation_matrix((0.85, 0.38, s * 0.25))) for s in (-1, 1)]
    return concat_shapes(chassis, cabin, roof, *wheels, *lights)


@register("the crossing: two roads, four corners")
def roads(width: float = 3.0, reach: float = 6.0) -> Shape:
    parts = [slab(2 * reach, 0.04, width, 0, -0.04), slab(width, 0.04, 2 * reach, 0, -0.039)]
    corner = reach - width / 2
    middle = width / 2 + corner / 2
    for sx in (-1, 1):
        for sz in (-1, 1):
            parts.append(slab(corner, 0.12, corner, sx * middle, -0.02, sz * middle, (0.6, 0.58, 0.55)))
    dashes = loop(5, lambda k: concat_shapes(
        slab(0.4, 0.01, 0.08, 3.0 + 0.6 * k, 0.005, 0, PAINT),
        slab(0.4, 0.01, 0.08, -3.0 - 0.6 * k, 0.005, 0, PAINT)))
    return concat_shapes(*parts, dashes)


@register()
def street_crossing() -> Shape:
    lights, stripes = [], []
    for k in range(4):
        turn = rotation_matrix(k * math.pi / 2, (0, 1, 0), (0, 0, 0))
        light = transform_shape(library_call('traffic_light', lit=0 if k % 2 else 2), translation_matrix((1.8, 0.1, 1.8)))
        lights.append(transform_shape(light, turn))
        stripes.append(transform_shape(transform_shape(library_call('zebra'), translation_matrix((0, 0, 2.2))), turn))
    waiting = transform_shape(library_call('car'), translation_matrix((-4.0, 0, 0.8)))
    driving = transform_shape(library_call('car', body=(0.15, 0.35, 0.7)), rotation_matrix(math.pi / 2, (0, 1, 0), (0, 0, 0)))
    driving = transform_shape(driving, translation_matrix((0.75, 0, 0.4)))
    return concat_shapes(library_call('roads'), *stripes, *lights, waiting, driving)
