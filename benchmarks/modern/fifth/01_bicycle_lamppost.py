"""a red city bicycle parked next to an old street lamp"""
from helper import *
import math


def rod(p0, p1, radius, color):
    return primitive_call('cylinder', shape_kwargs={'radius': radius, 'p0': tuple(p0), 'p1': tuple(p1)}, color=color)


def ball(center, radius, color):
    return transform_shape(primitive_call('sphere', shape_kwargs={'radius': radius}, color=color), translation_matrix(center))


@register("a spoked bicycle wheel in the xy plane")
def wheel(radius: float = 0.34, spokes: int = 16, tire: float = 0.022) -> Shape:
    segments = 36
    rim_points = [(radius * math.cos(2 * math.pi * k / segments), radius * math.sin(2 * math.pi * k / segments), 0.0)
                  for k in range(segments + 1)]
    rim = [rod(a, b, tire, (0.07, 0.07, 0.08)) for a, b in zip(rim_points, rim_points[1:])]

    def spoke(i: int) -> Shape:
        angle = 2 * math.pi * i / spokes
        side = 0.03 if i % 2 == 0 else -0.03
        return rod((0, 0, side), (radius * math.cos(angle), radius * math.sin(angle), 0), 0.003, (0.8, 0.8, 0.82))

    hub = rod((0, 0, -0.05), (0, 0, 0.05), 0.025, (0.5, 0.5, 0.52))
    return concat_shapes(*rim, loop(spokes, spoke), hub)


@register()
def frame(paint: tuple[float, float, float] = (0.75, 0.08, 0.1), wheelbase: float = 1.05) -> Shape:
    joints = {
        'rear': (0.0, 0.0, 0.0),
        'bottom': (0.42, -0.05, 0.0),
        'seat': (0.27, 0.5, 0.0),
        'head': (wheelbase - 0.22, 0.52, 0.0),
        'front': (wheelbase, 0.0, 0.0),
    }
    tubes = [('rear', 'bottom'), ('rear', 'seat'), ('bottom', 'seat'), ('seat', 'head'), ('bottom', 'head'), ('head', 'front')]
    return concat_shapes(*[rod(joints[a], joints[b], 0.018, paint) for a, b in tubes])


@register()
def saddle(height: float = 0.14) -> Shape:
    post = rod((0, 0, 0), (0, height, 0), 0.014, (0.7, 0.7, 0.72))
    pad = transform_shape(primitive_call('cube', shape_kwargs={'scale': (0.26, 0.05, 0.14)}, color=(0.3, 0.17, 0.08)),
                          translation_matrix((0.02, height + 0.02, 0)))
    nose = ball((0.15, height + 0.02, 0), 0.035, (0.3, 0.17, 0.08))
    return concat_shapes(post, pad, nose)


@register()
def handlebar(width: float = 0.56, rise: float = 0.12) -> Shape:
    chrome, grip = (0.75, 0.75, 0.78), (0.1, 0.1, 0.1)
    parts = [rod((0, 0, 0), (0, rise, 0), 0.015, chrome), rod((0, rise, -width / 2), (0, rise, width / 2), 0.012, chrome)]
    for side in (-1, 1):
        parts.append(rod((0, rise, side * width / 2), (-0.14, rise, side * width / 2), 0.018, grip))
    parts.append(ball((0, rise + 0.03, 0.1), 0.025, (0.85, 0.7, 0.2)))
    return concat_shapes(*parts)


@register()
def bicycle(paint: tuple[float, float, float] = (0.75, 0.08, 0.1), lean_degrees: float = 8.0) -> Shape:
    wheelbase, radius = 1.05, 0.34
    rear = library_call('wheel', radius=radius)
    front = transform_shape(library_call('wheel', radius=radius, spokes=20), translation_matrix((wheelbase, 0, 0)))
    crank = concat_shapes(
        rod((0.42, -0.05, -0.06), (0.42, -0.05, 0.06), 0.02, (0.6, 0.6, 0.6)),
        rod((0.42, -0.05, 0.05), (0.42, -0.05, 0.06), 0.09, (0.4, 0.4, 0.42)),
    )
    body = concat_shapes(
        rear, front, crank,
        library_call('frame', paint=paint, wheelbase=wheelbase),
        transform_shape(library_call('saddle'), translation_matrix((0.27, 0.5, 0))),
        transform_shape(library_call('handlebar'), translation_matrix((wheelbase - 0.22, 0.52, 0))),
    )
    lifted = transform_shape(body, translation_matrix((0, radius, 0)))
    return transform_shape(lifted, rotation_matrix(math.radians(lean_degrees), (1, 0, 0), (0, 0, 0)))


@register()
def street_lamp(height: float = 3.2, lanterns: int = 2) -> Shape:
    iron = (0.12, 0.16, 0.14)
    pole = rod((0, 0, 0), (0, height, 0), 0.05, iron)
    base = loop(3, lambda i: rod((0, 0.12 * i, 0), (0, 0.12 * (i + 1), 0), 0.18 - 0.04 * i, iron))
    heads = []
    for i in range(lanterns):
        a = 2 * math.pi * i / lanterns
        x, z = 0.45 * math.cos(a), 0.45 * math.sin(a)
        heads.append(rod((0, height - 0.2, 0), (x, height, z), 0.025, iron))
        heads.append(ball((x, height + 0.12, z), 0.13, (1.0, 0.92, 0.65)))
        heads.append(rod((x, height + 0.24, z), (x, height + 0.28, z), 0.1, iron))
    return concat_shapes(pole, base, *heads)


@register()
def sidewalk(tiles_x: int = 7, tiles_z: int = 4, size: float = 0.5) -> Shape:
    def tile(i: int) -> Shape:
        row, col = divmod(i, tiles_x)
        shade = 0.55 + 0.06 * ((row + col) % 2)
        cube = primitive_call('cube', shape_kwargs={'scale': (size * 0.97, 0.06, size * 0.97)}, color=(shade, shade, shade * 0.97))
        return transform_shape(cube, translation_matrix(((col - (tiles_x - 1) / 2) * size, -0.03, (row - (tiles_z - 1) / 2) * size)))
    return loop(tiles_x * tiles_z, tile)


@register()
def street_corner() -> Shape:
    bike = transform_shape(library_call('bicycle', lean_degrees=-7.0), translation_matrix((-0.6, 0, 0.2)))
    lamp = transform_shape(library_call('street_lamp'), translation_matrix((0.3, 0, -0.25)))
    return concat_shapes(library_call('sidewalk'), bike, lamp)
