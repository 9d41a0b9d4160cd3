"""a farmyard with a stone well, chickens, hay bales and a red barn"""
from helper import *
import math
import random


def mat(*ms):
    """The product of matrices, first one outermost."""
    m = identity_matrix()
    for x in ms:
        m = m @ x
    return m


def turn(deg, axis=(0, 1, 0)):
    return rotation_matrix(math.radians(deg), axis, (0, 0, 0))


@register()
def well(radius: float = 0.7, courses: int = 4, stones: int = 12, roof: bool = True) -> Shape:
    out = []
    for c in range(courses):
        for s in range(stones):
            a = 2 * math.pi * (s + 0.5 * (c % 2)) / stones
            g = 0.5 + 0.07 * ((s * 7 + c * 3) % 4) / 3
            stone = primitive_call('cube', shape_kwargs={'scale': (0.22, 0.19, 2 * math.pi * radius / stones * 0.92)}, color=(g, g, g * 0.95))
            out.append(transform_shape(stone, mat(turn(-math.degrees(a)), translation_matrix((radius, 0.1 + 0.2 * c, 0)))))
    top = courses * 0.2
    out.append(primitive_call('cylinder', shape_kwargs={'radius': radius * 0.9, 'p0': (0, top * 0.5, 0), 'p1': (0, top * 0.55, 0)}, color=(0.15, 0.3, 0.45)))
    if roof:
        for s in (-1, 1):
            out.append(primitive_call('cylinder', shape_kwargs={'radius': 0.05, 'p0': (s * radius, top, 0), 'p1': (s * radius, top + 1.3, 0)}, color=(0.42, 0.3, 0.18)))
            board = primitive_call('cube', shape_kwargs={'scale': (radius * 2.8, 0.05, 0.9)}, color=(0.5, 0.2, 0.15))
            out.append(transform_shape(board, mat(translation_matrix((0, top + 1.4, s * 0.36)), turn(s * 38, (1, 0, 0)))))
        out.append(primitive_call('cylinder', shape_kwargs={'radius': 0.06, 'p0': (-radius, top + 0.8, 0), 'p1': (radius, top + 0.8, 0)}, color=(0.5, 0.36, 0.2)))
        out.append(primitive_call('cylinder', shape_kwargs={'radius': 0.01, 'p0': (0, top + 0.8, 0), 'p1': (0, top + 0.25, 0)}, color=(0.8, 0.75, 0.6)))
        out.append(primitive_call('cylinder', shape_kwargs={'radius': 0.12, 'p0': (0, top, 0), 'p1': (0, top + 0.25, 0)}, color=(0.55, 0.4, 0.22)))
    return concat_shapes(*out)


@register()
def chicken(color: tuple = (0.95, 0.93, 0.88), pecking: bool = False, scale: float = 1.0) -> Shape:
    body = transform_shape(primitive_call('sphere', shape_kwargs={'radius': 0.14}, color=color), scale_matrix((1.3, 1, 0.9), (0, 0, 0)))
    tail = transform_shape(primitive_call('cube', shape_kwargs={'scale': (0.05, 0.16, 0.1)}, color=tuple(c * 0.8 for c in color)), mat(translation_matrix((-0.18, 0.08, 0)), turn(30, (0, 0, 1))))
    head_parts = concat_shapes(
        transform_shape(primitive_call('sphere', shape_kwargs={'radius': 0.07}, color=color), translation_matrix((0.18, 0.16, 0))),
        transform_shape(primitive_call('cube', shape_kwargs={'scale': (0.06, 0.04, 0.02)}, color=(0.85, 0.1, 0.1)), translation_matrix((0.18, 0.24, 0))),
        primitive_call('cylinder', shape_kwargs={'radius': 0.015, 'p0': (0.24, 0.16, 0), 'p1': (0.29, 0.15, 0)}, color=(0.95, 0.65, 0.15)),
    )
    if pecking:
        head_parts = transform_shape(head_parts, rotation_matrix(math.radians(-85), (0, 0, 1), (0.08, 0, 0)))
    legs = [primitive_call('cylinder', shape_kwargs={'radius': 0.012, 'p0': (0.02, -0.12, z), 'p1': (0.02, -0.24, z)}, color=(0.9, 0.6, 0.15)) for z in (-0.05, 0.05)]
    bird = transform_shape(concat_shapes(body, tail, head_parts, *legs), translation_matrix((0, 0.24, 0)))
    return transform_shape(bird, scale_matrix(scale, (0, 0, 0)))


@register()
def hay_bale(length: float = 0.9, radius: float = 0.5) -> Shape:
    roll = primitive_call('cylinder', shape_kwargs={'radius': radius, 'p0': (-length / 2, radius, 0), 'p1': (length / 2, radius, 0)}, color=(0.85, 0.72, 0.35))
    rings = loop(4, lambda i: primitive_call('cylinder', shape_kwargs={'radius': radius * 1.01, 'p0': (-length / 2 + length * (i + 0.5) / 4, radius, 0), 'p1': (-length / 2 + length * (i + 0.6) / 4, radius, 0)}, color=(0.65, 0.52, 0.2)))
    return concat_shapes(roll, rings)


@register()
def barn(width: float = 4.0, depth: float = 5.0, wall: float = 2.4) -> Shape:
    red, white, grey = (0.62, 0.13, 0.11), (0.93, 0.92, 0.9), (0.35, 0.33, 0.33)
    parts = [transform_shape(primitive_call('cube', shape_kwargs={'scale': (width, wall, depth)}, color=red), translation_matrix((0, wall / 2, 0)))]
    # gambrel roof: steep below, flat above
    profile = [(width / 2 + 0.2, wall - 0.1), (width * 0.32, wall + 1.1), (0, wall + 1.7)]
    for (x0, y0), (x1, y1) in zip(profile, profile[1:]):
        for s in (-1, 1):
            panel = primitive_call('cube', shape_kwargs={'scale': (math.hypot(x1 - x0, y1 - y0) + 0.05, 0.08, depth + 0.4)}, color=grey)
            parts.append(transform_shape(panel, mat(translation_matrix((s * (x0 + x1) / 2, (y0 + y1) / 2, 0)), turn(s * math.degrees(math.atan2(y1 - y0, x1 - x0)), (0, 0, 1)))))
    for i in range(10):
        y = wall + 1.65 * (i + 0.5) / 10
        half = width / 2 - (y - wall) * 0.6 if y < wall + 1.1 else width * 0.32 * (wall + 1.7 - y) / 0.6
        for s in (-1, 1):
            parts.append(transform_shape(primitive_call('cube', shape_kwargs={'scale': (2 * max(half, 0.05), 0.17, 0.06)}, color=red), translation_matrix((0, y, s * depth / 2 - s * 0.03))))
    door_w, door_h = 1.6, 1.8
    parts.append(transform_shape(primitive_call('cube', shape_kwargs={'scale': (door_w, door_h, 0.05)}, color=tuple(0.8 * c for c in red)), translation_matrix((0, door_h / 2, depth / 2 + 0.02))))
    corners = [(-door_w / 2, 0), (door_w / 2, 0), (door_w / 2, door_h), (-door_w / 2, door_h)]
    trims = list(zip(corners, corners[1:] + corners[:1])) + [(corners[0], corners[2]), (corners[1], corners[3])]
    parts += [primitive_call('cylinder', shape_kwargs={'radius': 0.05, 'p0': (x0, y0, depth / 2 + 0.05), 'p1': (x1, y1, depth / 2 + 0.05)}, color=white) for (x0, y0), (x1, y1) in trims]
    return concat_shapes(*parts)


@register()
def farmyard(chickens: int = 7, seed: int = 30) -> Shape:
    rnd = random.Random(seed)
    breeds = [(0.95, 0.93, 0.88), (0.6, 0.35, 0.18), (0.15, 0.13, 0.13)]
    flock = []
    for i in range(chickens):
        bird = library_call('chicken', color=breeds[i % 3], pecking=rnd.random() < 0.4, scale=rnd.uniform(0.8, 1.1))
        flock.append(transform_shape(bird, mat(translation_matrix((rnd.uniform(-1, 3.5), 0, rnd.uniform(0.5, 3.5))), turn(rnd.uniform(0, 360)))))
    bales = [transform_shape(library_call('hay_bale'), mat(translation_matrix(p), turn(d))) for p, d in [((3.0, 0, -1.5), 0), ((3.0, 0, -2.6), 5), ((3.0, 0.87, -2.05), -3), ((1.4, 0, -3.0), 70)]]
    yard = transform_shape(primitive_call('cube', shape_kwargs={'scale': (11, 0.1, 10)}, color=(0.55, 0.5, 0.3)), translation_matrix((0, -0.05, -0.5)))
    return concat_shapes(yard, transform_shape(library_call('barn'), translation_matrix((-2.5, 0, -2.5))), transform_shape(library_call('well'), translation_matrix((1.2, 0, 0))), *bales, *flock)
