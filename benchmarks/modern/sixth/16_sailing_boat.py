"""a wooden sailing boat on gentle waves"""
from helper import *
import math

HULL_COLORS = {'planks': (0.55, 0.3, 0.15), 'stripe': (0.95, 0.93, 0.88), 'keel': (0.15, 0.25, 0.45)}


def rod(a, b, radius, color):
    return primitive_call('cylinder', shape_kwargs={'radius': radius, 'p0': a, 'p1': b}, color=color)


def beam_at(t: float, beam: float) -> float:
    """Half width of the hull at t from 0 (stern) to 1 (bow)."""
    return beam * (0.65 + 1.4 * t - 2.05 * t * t) if t < 1 else 0.0


def hull_point(t, level, side, length, beam, depth):
    width = beam_at(t, beam) * (0.35 + 0.65 * level)
    return ((t - 0.5) * length, -depth * (1 - level) * (1 - 0.6 * t * t), side * width)


@register("the hull: planks as chains of rods from stern to bow")
def hull(length: float = 4.0, beam: float = 0.9, depth: float = 0.6, planks: int = 6, stations: int = 12) -> Shape:
    shapes = []
    for side in (-1, 1):
        for p in range(planks):
            level = p / (planks - 1)
            name = 'stripe' if p == planks - 1 else 'keel' if p == 0 else 'planks'
            points = [hull_point(s / stations, level, side, length, beam, depth) for s in range(stations + 1)]
            shapes.extend(rod(a, b, 0.08, HULL_COLORS[name]) for a, b in zip(points, points[1:]))
    # the transom closes the stern
    for p in range(planks):
        level = p / (planks - 1)
        left, right = (hull_point(0, level, s, length, beam, depth) for s in (-1, 1))
        shapes.append(rod(left, right, 0.08, HULL_COLORS['planks']))
    return concat_shapes(*shapes)


@register("thwarts to sit on")
def seats(count: int = 3, length: float = 4.0, beam: float = 0.9) -> Shape:
    def seat(i: int) -> Shape:
        t = 0.2 + 0.22 * i
        plank = primitive_call('cube', shape_kwargs={'scale': (0.3, 0.05, 2 * beam_at(t, beam) * 0.85)}, color=(0.75, 0.55, 0.3))
        return transform_shape(plank, translation_matrix(((t - 0.5) * length, -0.15, 0)))
    return loop(count, seat)


@register("a triangular sail in the xy plane, of horizontal strips")
def sail(foot: float = 1.7, height: float = 3.0, strips: int = 15, color: tuple[float, float, float] = (0.96, 0.94, 0.88)) -> Shape:
    shapes = []
    for i in range(strips):
        t = (i + 0.5) / strips
        width = foot * (1 - t)
        belly = 0.25 * math.sin(math.pi * t) ** 0.8
        strip = primitive_call('cube', shape_kwargs={'scale': (width, height / strips, 0.02)}, color=color if i % 5 else (0.8, 0.2, 0.2))
        shapes.append(transform_shape(strip, translation_matrix((-width / 2, t * height, belly))))
    return concat_shapes(*shapes)


@register("mast, boom, gaff lines and both sails")
def rig(mast: float = 3.8) -> Shape:
    spruce = (0.8, 0.62, 0.35)
    parts = [
        rod((0.4, -0.4, 0), (0.4, mast, 0), 0.05, spruce),
        rod((0.4, 0.5, 0), (-1.5, 0.5, 0.1), 0.035, spruce),
        rod((0.4, mast, 0), (2.0, 0.05, 0), 0.012, (0.2, 0.2, 0.2)),
        rod((0.4, mast, 0), (-1.95, 0.0, 0), 0.012, (0.2, 0.2, 0.2)),
        *[rod((0.4, mast * 0.9, 0), (0.2, 0, s * 0.85), 0.012, (0.2, 0.2, 0.2)) for s in (-1, 1)],
    ]
    main_sail = transform_shape(library_call('sail'), translation_matrix((0.35, 0.55, 0)))
    jib = transform_shape(library_call('sail', foot=1.2, height=2.6, strips=13), rotation_matrix(math.pi, (0, 1, 0), (0, 0, 0)))
    jib = transform_shape(jib, translation_matrix((0.5, 0.4, 0)))
    pennant = transform_shape(primitive_call('cube', shape_kwargs={'scale': (0.4, 0.12, 0.01)}, color=(0.1, 0.4, 0.7)), translation_matrix((0.2, mast - 0.05, 0)))
    return concat_shapes(*parts, main_sail, jib, pennant)


@register("the sea as a grid of blue columns")
def sea(cells: int = 16, size: float = 0.6) -> Shape:
    tiles = []
    for i in range(cells):
        for j in range(cells):
            x, z = (i - (cells - 1) / 2) * size, (j - (cells - 1) / 2) * size
            wave = 0.1 * math.sin(1.3 * x + 0.4 * z) + 0.06 * math.cos(1.9 * z)
            foam = wave > 0.12
            color = (0.75, 0.88, 0.95) if foam else (0.1, 0.35 + 0.8 * wave, 0.6)
            cube = primitive_call('cube', shape_kwargs={'scale': (size, 0.5, size)}, color=color)
            tiles.append(transform_shape(cube, translation_matrix((x, wave - 0.65, z))))
    return concat_shapes(*tiles)


@register()
def sailing_boat(heel: float = 9.0) -> Shape:
    boat = concat_shapes(library_call('hull'), library_call('seats'), library_call('rig'))
    boat = transform_shape(boat, rotation_matrix(math.radians(heel), (1, 0, 0), (0, 0, 0)))
    return concat_shapes(library_call('sea'), boat)
