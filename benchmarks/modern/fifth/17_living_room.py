"""a cozy living room with a corner sofa, a TV, a rug, a bookcase and a cat"""
from helper import *
import math

WALL_H = 2.6


class Palette:
    FABRIC = (0.35, 0.45, 0.5)
    CUSHIONS = [(0.9, 0.6, 0.25), (0.85, 0.85, 0.8), (0.55, 0.25, 0.3)]
    OAK = (0.66, 0.5, 0.33)
    DARK = (0.1, 0.1, 0.11)


def cube(scale, pos=(0, 0, 0), color=(1, 1, 1), yaw=0.0):
    shape = primitive_call('cube', shape_kwargs={'scale': scale}, color=color)
    if yaw:
        shape = transform_shape(shape, rotation_matrix(yaw, (0, 1, 0), (0, 0, 0)))
    return transform_shape(shape, translation_matrix(pos))


def cyl(p0, p1, r, color):
    return primitive_call('cylinder', shape_kwargs={'radius': r, 'p0': p0, 'p1': p1}, color=color)


def sph(pos, r, color):
    return transform_shape(primitive_call('sphere', shape_kwargs={'radius': r}, color=color), translation_matrix(pos))


@register()
def sofa_unit(width: float = 0.8, arm: str = 'none', cushion: int = -1) -> Shape:
    fabric = Palette.FABRIC
    parts = [
        cube((width, 0.25, 0.9), (0, 0.25, 0), fabric),
        cube((width * 0.96, 0.15, 0.7), (0, 0.44, 0.08), tuple(c * 1.1 for c in fabric)),
        cube((width, 0.55, 0.2), (0, 0.6, -0.35), fabric),
    ]
    if arm in ('left', 'both'):
        parts.append(cube((0.18, 0.4, 0.9), (-width / 2 - 0.09, 0.42, 0), fabric))
    if arm in ('right', 'both'):
        parts.append(cube((0.18, 0.4, 0.9), (width / 2 + 0.09, 0.42, 0), fabric))
    if cushion >= 0:
        pillow = cube((0.4, 0.4, 0.12), color=Palette.CUSHIONS[cushion % 3])
        pillow = transform_shape(pillow, rotation_matrix(-0.35, (1, 0, 0), (0, 0, 0)) @ rotation_matrix(0.15 * cushion, (0, 0, 1), (0, 0, 0)))
        parts.append(transform_shape(pillow, translation_matrix((0, 0.7, -0.14))))
    for x in (-width / 2 + 0.06, width / 2 - 0.06):
        parts.append(cyl((x, 0, 0.35), (x, 0.14, 0.35), 0.03, Palette.OAK))
    return concat_shapes(*parts)


@register()
def corner_sofa(long_side: int = 3, short_side: int = 2, unit: float = 0.8) -> Shape:
    shapes = []
    for i in range(long_side):
        arm = 'right' if i == long_side - 1 else 'none'
        shapes.append(transform_shape(library_call('sofa_unit', width=unit, arm=arm, cushion=i if i % 2 == 0 else -1), translation_matrix((i * unit, 0, 0))))
    for k in range(1, short_side + 1):
        arm = 'left' if k == short_side else 'none'
        seat = transform_shape(library_call('sofa_unit', width=unit, arm=arm, cushion=k), rotation_matrix(math.pi / 2, (0, 1, 0), (0, 0, 0)))
        shapes.append(transform_shape(seat, translation_matrix((0, 0, k * unit))))
    return concat_shapes(*shapes)


@register()
def television(diagonal: float = 1.4, aspect: float = 16 / 9) -> Shape:
    h = diagonal / math.sqrt(1 + aspect ** 2)
    w = h * aspect
    screen = [cube((w, h, 0.04), (0, 0.75 + h / 2, 0), Palette.DARK)]
    # a landscape on the screen: sky, hills, sun
    screen.append(cube((w * 0.96, h * 0.55, 0.01), (0, 0.75 + h * 0.68, 0.022), (0.5, 0.75, 0.95)))
    screen.append(cube((w * 0.96, h * 0.38, 0.01), (0, 0.75 + h * 0.22, 0.022), (0.35, 0.6, 0.3)))
    screen.append(cyl((w * 0.25, 0.75 + h * 0.75, 0.02), (w * 0.25, 0.75 + h * 0.75, 0.03), h * 0.1, (1, 0.9, 0.4)))
    cabinet = [cube((w * 1.2, 0.45, 0.4), (0, 0.35, 0), Palette.OAK)]
    cabinet += [cube((w * 0.36, 0.35, 0.02), (x * w * 0.39, 0.35, 0.2), (0.93, 0.92, 0.9)) for x in (-1, 0, 1)]
    return concat_shapes(*screen, *cabinet)


@register()
def rug(width: float = 2.2, depth: float = 1.6, rings: int = 5) -> Shape:
    a, b = (0.7, 0.25, 0.2), (0.92, 0.86, 0.72)
    layers = [cube((width * (1 - k / rings), 0.012 + 0.004 * k, depth * (1 - k / rings)), (0, 0.006, 0), a if k % 2 == 0 else b) for k in range(rings)]
    fringe = loop(24, lambda i: cube((0.02, 0.008, 0.08), (-width / 2 + (i % 12 + 0.5) * width / 12, 0.004, (depth / 2 + 0.04) * (1 if i < 12 else -1)), b))
    return concat_shapes(*layers, fringe)


@register()
def cat(color: tuple = (0.85, 0.55, 0.25), curl: float = 4.5) -> Shape:
    body = transform_shape(sph((0, 0, 0), 0.16, color), translation_matrix((0, 0.1, 0)) @ scale_matrix((1.4, 0.75, 1), (0, 0, 0)))
    head = sph((0.2, 0.16, 0.06), 0.09, color)
    ears = [transform_shape(cube((0.05, 0.07, 0.02), color=color), translation_matrix((0.2 + s * 0.04, 0.25, 0.06)) @ rotation_matrix(s * 0.3, (0, 0, 1), (0, 0, 0))) for s in (-1, 1)]
    tail = [sph((-0.2 * math.cos(curl * t), 0.05, 0.05 + 0.22 * math.sin(curl * t) * (1 - 0.3 * t)), 0.035, color if k % 2 else (0.98, 0.9, 0.8)) for k, t in enumerate(j / 10 for j in range(10))]
    return concat_shapes(body, head, *ears, *tail)


@register()
def coffee_table(radius: float = 0.45) -> Shape:
    legs = loop(3, lambda i: cyl((radius * 0.9 * math.cos(2.094 * i), 0, radius * 0.9 * math.sin(2.094 * i)), (radius * 0.4 * math.cos(2.094 * i), 0.38, radius * 0.4 * math.sin(2.094 * i)), 0.02, Palette.DARK))
    books = [cube((0.25, 0.03, 0.18), (0.05, 0.425 + 0.03 * k, 0), Palette.CUSHIONS[k], yaw=0.2 * k) for k in range(3)]
    return concat_shapes(cyl((0, 0.38, 0), (0, 0.41, 0), radius, Palette.OAK), legs, *books)


@register()
def living_room(width: float = 5.0, depth: float = 4.2) -> Shape:
    floor = loop(10, lambda i: cube((width / 10 * 0.98, 0.06, depth), (-width / 2 + (i + 0.5) * width / 10, -0.03, 0), tuple(c * (0.95 + 0.05 * (i % 2)) for c in Palette.OAK)))
    walls = [cube((width, WALL_H, 0.1), (0, WALL_H / 2, -depth / 2), (0.93, 0.9, 0.85)), cube((0.1, WALL_H, depth), (-width / 2, WALL_H / 2, 0), (0.88, 0.9, 0.87))]
    tv = transform_shape(library_call('television'), translation_matrix((0.3, 0, 1.75)) @ rotation_matrix(math.pi, (0, 1, 0), (0, 0, 0)))
    sofa = transform_shape(library_call('corner_sofa'), translation_matrix((-1.7, 0, -1.4)))
    pet = transform_shape(library_call('cat'), translation_matrix((-0.9, 0.52, -1.25)))
    return concat_shapes(floor, *walls, tv, sofa, pet, transform_shape(library_call('rug'), translation_matrix((0.2, 0, 0.2))), transform_shape(library_call('coffee_table'), translation_matrix((0.2, 0, 0.1))))
