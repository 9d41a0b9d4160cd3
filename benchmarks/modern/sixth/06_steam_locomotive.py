"""an old black steam locomotive with a coal tender on a railway track"""
from helper import *
import math

BLACK = (0.07, 0.07, 0.08)
RED = (0.7, 0.1, 0.08)
BRASS = (0.83, 0.63, 0.22)


def tube(p0, p1, radius, color=BLACK):
    return primitive_call('cylinder', shape_kwargs={'radius': radius, 'p0': p0, 'p1': p1}, color=color)


def block(size, center, color=BLACK):
    return transform_shape(primitive_call('cube', shape_kwargs={'scale': size}, color=color), translation_matrix(center))


@register("rails along x on wooden sleepers")
def track(length: float = 12.0, gauge: float = 1.4, spacing: float = 0.6) -> Shape:
    n = int(length / spacing)
    sleepers = loop(n, lambda i: block((0.22, 0.12, gauge * 1.7), (-length / 2 + (i + 0.5) * spacing, -0.06, 0), (0.33, 0.24, 0.17)))
    rails = [block((length, 0.12, 0.08), (0, 0.06, s * gauge / 2), (0.5, 0.5, 0.52)) for s in (-1, 1)]
    return concat_shapes(sleepers, *rails)


@register("a spoked wheel that stands on y = 0")
def spoked_wheel(radius: float = 0.6, spokes: int = 10) -> Shape:
    tire = tube((0, 0, -0.06), (0, 0, 0.06), radius, RED)
    face = tube((0, 0, -0.065), (0, 0, 0.065), radius * 0.85, BLACK)
    bars = loop(spokes, lambda i: transform_shape(
        tube((0, 0, 0.07), (radius * 0.85, 0, 0.07), 0.025, RED),
        rotation_matrix(2 * math.pi * i / spokes, (0, 0, 1), (0, 0, 0))))
    hub = tube((0, 0, -0.09), (0, 0, 0.1), 0.1, RED)
    return transform_shape(concat_shapes(tire, face, bars, hub), translation_matrix((0, radius, 0)))


@register("wheel sets on both rails, and the coupling rods")
def running_gear(drivers: int = 3, radius: float = 0.6, gauge: float = 1.4, pitch: float = 1.3) -> Shape:
    shapes = []
    for k in range(drivers):
        for s in (-1, 1):
            wheel = library_call('spoked_wheel', radius=radius)
            if s < 0:
                wheel = transform_shape(wheel, rotation_matrix(math.pi, (0, 1, 0), (0, 0, 0)))
            shapes.append(transform_shape(wheel, translation_matrix((k * pitch, 0, s * gauge / 2))))
        shapes.append(tube((k * pitch, radius, -gauge / 2), (k * pitch, radius, gauge / 2), 0.06))
    for s in (-1, 1):
        z = s * (gauge / 2 + 0.14)
        shapes.append(tube((0, radius - 0.2, z), ((drivers - 1) * pitch, radius - 0.2, z), 0.045, (0.7, 0.7, 0.72)))
    return concat_shapes(*shapes)


@register()
def boiler(length: float = 4.0, radius: float = 0.65, bands: int = 4) -> Shape:
    y = 1.75
    shell = tube((0, y, 0), (length, y, 0), radius)
    rings = [tube((x - 0.03, y, 0), (x + 0.03, y, 0), radius + 0.015, BRASS)
             for x in [length * (k + 0.5) / bands for k in range(bands)]]
    chimney = [tube((length - 0.5, y + radius - 0.1, 0), (length - 0.5, y + radius + 0.55, 0), 0.17),
               tube((length - 0.5, y + radius + 0.5, 0), (length - 0.5, y + radius + 0.65, 0), 0.25)]
    domes = [transform_shape(primitive_call('sphere', shape_kwargs={'radius': 0.28}, color=BRASS), translation_matrix((x, y + radius, 0)))
             for x in (1.0, 2.1)]
    lamp = transform_shape(primitive_call('sphere', shape_kwargs={'radius': 0.16}, color=(1, 0.95, 0.7)), translation_matrix((length + 0.08, y + 0.35, 0)))
    return concat_shapes(shell, *rings, *chimney, *domes, lamp)


@register()
def cab(width: float = 1.6) -> Shape:
    floor = block((1.4, 0.1, width), (0, 1.15, 0))
    roof = block((1.7, 0.08, width + 0.2), (0, 3.0, 0), RED)
    pillars = [block((0.1, 1.8, 0.1), (x, 2.1, s * width / 2.1)) for x in (-0.6, 0.6) for s in (-1, 1)]
    sides = [block((1.3, 0.8, 0.05), (0, 1.6, s * width / 2.1), RED) for s in (-1, 1)]
    return concat_shapes(floor, roof, *pillars, *sides)


@register()
def tender(length: float = 2.2) -> Shape:
    tank = block((length, 1.0, 1.5), (0, 1.4, 0))
    stripe = block((length * 0.9, 0.06, 1.52), (0, 1.6, 0), BRASS)
    coal = [transform_shape(primitive_call('sphere', shape_kwargs={'radius': 0.16 + 0.03 * ((i + j) % 2)}, color=(0.03, 0.03, 0.03)),
                            translation_matrix((-0.8 + 0.27 * i, 1.9 + 0.06 * ((i * j) % 3), -0.5 + 0.25 * j)))
            for i in range(7) for j in range(5)]
    wheels = transform_shape(library_call('running_gear', drivers=2, radius=0.42, pitch=1.1), translation_matrix((-0.55, 0, 0)))
    return concat_shapes(tank, stripe, *coal, wheels)


@register()
def steam_locomotive() -> Shape:
    engine = concat_shapes(
        transform_shape(library_call('running_gear'), translation_matrix((0.4, 0, 0))),
        library_call('boiler'),
        transform_shape(library_call('cab'), translation_matrix((-0.75, 0, 0))),
        block((5.4, 0.15, 1.3), (1.3, 1.0, 0), RED),
    )
    wagon = transform_shape(library_call('tender'), translation_matrix((-2.9, 0, 0)))
    train = transform_shape(concat_shapes(engine, wagon), translation_matrix((0, 0.12, 0)))
    return concat_shapes(library_call('track'), train)
