"""a steam locomotive pulling three freight wagons"""
from helper import *
import logging
import math
from enum import Enum

log = logging.getLogger(__name__)


class Cargo(str, Enum):
    COAL = 'coal'
    LOGS = 'logs'
    BARRELS = 'barrels'


def cyl(p0, p1, r, color):
    return primitive_call('cylinder', shape_kwargs={'radius': r, 'p0': p0, 'p1': p1}, color=color)


def box(size, at, color):
    return transform_shape(primitive_call('cube', shape_kwargs={'scale': size}, color=color), translation_matrix(at))


@register()
def wheel(radius: float = 0.3, spokes: int = 6) -> Shape:
    tire = cyl((0, 0, -0.05), (0, 0, 0.05), radius, (0.12, 0.12, 0.12))
    spoke = lambda i: transform_shape(box((0.04, radius * 1.7, 0.12), (0, 0, 0), (0.7, 0.1, 0.1)), rotation_matrix(i * math.pi / spokes, (0, 0, 1), (0, 0, 0)))
    return concat_shapes(tire, loop(spokes, spoke))


@register()
def wheel_set(xs: tuple = (-0.6, 0.6), radius: float = 0.3, gauge: float = 0.8) -> Shape:
    return concat_shapes(*[
        transform_shape(library_call('wheel', radius=radius), translation_matrix((x, radius, s * gauge / 2)))
        for x in xs for s in (-1, 1)])


@register()
def locomotive() -> Shape:
    boiler = cyl((-0.4, 1.0, 0), (1.5, 1.0, 0), 0.4, (0.1, 0.25, 0.15))
    cab = box((0.9, 1.3, 0.95), (-0.9, 1.2, 0), (0.15, 0.3, 0.2))
    roof = box((1.1, 0.08, 1.1), (-0.9, 1.9, 0), (0.1, 0.1, 0.1))
    chimney = cyl((1.2, 1.3, 0), (1.2, 1.9, 0), 0.12, (0.1, 0.1, 0.1))
    dome = transform_shape(primitive_call('sphere', shape_kwargs={'radius': 0.2}, color=(0.8, 0.65, 0.2)), translation_matrix((0.4, 1.4, 0)))
    smoke = [transform_shape(primitive_call('sphere', shape_kwargs={'radius': 0.15 + 0.06 * i}, color=(0.85, 0.85, 0.85)), translation_matrix((1.2 - 0.3 * i, 2.1 + 0.2 * i, 0))) for i in range(4)]
    frame = box((3.0, 0.15, 0.7), (0, 0.55, 0), (0.2, 0.2, 0.2))
    return concat_shapes(boiler, cab, roof, chimney, dome, frame, library_call('wheel_set', xs=(-1.0, -0.2, 0.6, 1.2)), *smoke)


@register()
def wagon(cargo: str = 'coal') -> Shape:
    bed = box((2.2, 0.12, 0.9), (0, 0.6, 0), (0.4, 0.28, 0.18))
    load = []
    match Cargo(cargo):
        case Cargo.COAL:
            load.append(box((2.0, 0.5, 0.8), (0, 0.9, 0), (0.08, 0.08, 0.08)))
        case Cargo.LOGS:
            for level, count in enumerate((3, 2, 1)):
                for k in range(count):
                    z = (k - (count - 1) / 2) * 0.28
                    load.append(cyl((-1, 0.8 + 0.24 * level, z), (1, 0.8 + 0.24 * level, z), 0.13, (0.5, 0.33, 0.18)))
        case Cargo.BARRELS:
            load = [cyl((x, 0.66, 0), (x, 1.25, 0), 0.25, (0.55, 0.3, 0.12)) for x in (-0.75, 0, 0.75)]
    log.debug("wagon with %s: %d load shapes", cargo, len(load))
    return concat_shapes(bed, library_call('wheel_set', xs=(-0.7, 0.7), radius=0.25), *load)


@register()
def track(length: float = 14.0) -> Shape:
    rails = [box((length, 0.08, 0.06), (0, -0.04, z), (0.55, 0.55, 0.58)) for z in (-0.4, 0.4)]
    ties = loop(int(length / 0.5), lambda i: box((0.18, 0.08, 1.3), (-length / 2 + 0.25 + 0.5 * i, -0.12, 0), (0.35, 0.24, 0.15)))
    return concat_shapes(*rails, ties)


@register()
def train() -> Shape:
    logging.basicConfig(level=logging.WARNING)
    x = 4.5
    shapes = [transform_shape(library_call('locomotive'), translation_matrix((x, 0, 0)))]
    x -= 3.1
    for cargo in Cargo:
        shapes.append(transform_shape(library_call('wagon', cargo=cargo.value), translation_matrix((x, 0, 0))))
        shapes.append(box((0.4, 0.08, 0.1), (x + 1.3, 0.6, 0), (0.2, 0.2, 0.2)))
        x -= 2.6
    return concat_shapes(library_call('track'), *shapes)
