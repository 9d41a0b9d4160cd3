"""a children's room: bunk bed, desk, wardrobe, rug and toys"""
from helper import *
import math

COLORS = dict(
    wood=(0.82, 0.66, 0.45),
    blue=(0.3, 0.5, 0.8),
    pink=(0.92, 0.55, 0.65),
    white=(0.96, 0.96, 0.94),
    gray=(0.5, 0.5, 0.52),
    yellow=(0.97, 0.83, 0.3),
)


def box(w, h, d, color='wood'):
    """A box that stands on the origin."""
    cube = primitive_call('cube', shape_kwargs={'scale': (w, h, d)}, color=COLORS[color])
    return transform_shape(cube, translation_matrix((0, h / 2, 0)))


def move(shape, x=0, y=0, z=0):
    return transform_shape(shape, translation_matrix((x, y, z)))


@register("mattress, pillow and a blanket")
def bedding(length: float = 1.9, width: float = 0.9, blanket: str = 'blue') -> Shape:
    mattress = box(length, 0.15, width, 'white')
    pillow = move(box(0.35, 0.08, width * 0.7, 'white'), -length / 2 + 0.25, 0.15)
    cover = move(box(length * 0.65, 0.05, width * 1.02, blanket), length * 0.16, 0.13)
    return concat_shapes(mattress, pillow, cover)


@register("a ladder along +y")
def ladder(height: float = 1.7, rungs: int = 5, width: float = 0.4) -> Shape:
    rails = [move(box(0.04, height, 0.04), s * width / 2) for s in (-1, 1)]
    steps = loop(rungs, lambda i: move(box(width, 0.03, 0.05), 0, (i + 1) * height / (rungs + 1)))
    return concat_shapes(*rails, steps)


@register()
def bunk_bed(length: float = 2.0, width: float = 1.0, height: float = 1.8, levels: int = 2) -> Shape:
    posts = [move(box(0.07, height, 0.07), sx * length / 2, 0, sz * width / 2) for sx in (-1, 1) for sz in (-1, 1)]
    decks = []
    blankets = ['blue', 'pink', 'yellow']
    for level in range(levels):
        y = 0.3 + level * (height - 0.6) / max(levels - 1, 1)
        decks.append(move(box(length, 0.06, width), 0, y))
        decks.append(move(library_call('bedding', blanket=blankets[level % len(blankets)]), 0, y + 0.06))
        if level > 0:  # nobody shall fall out
            decks.append(move(box(length, 0.05, 0.03), 0, y + 0.35, width / 2))
            decks.append(move(box(length, 0.05, 0.03), 0, y + 0.35, -width / 2))
    steps = transform_shape(library_call('ladder', height=height * 0.85), rotation_matrix(-math.pi / 24, (1, 0, 0), (0, 0, 0)))
    return concat_shapes(*posts, *decks, move(steps, 0.6, 0, width / 2 + 0.22))


@register("a desk with drawers; `drawers` on the right side")
def desk(width: float = 1.2, drawers: int = 3) -> Shape:
    top = move(box(width, 0.04, 0.6), 0, 0.7)
    legs = [move(box(0.05, 0.7, 0.05), -width / 2 + 0.05, 0, s * 0.25) for s in (-1, 1)]
    chest = move(box(0.4, 0.68, 0.55), width / 2 - 0.22, 0.02)
    height = 0.68 / drawers
    fronts = [move(box(0.36, height * 0.85, 0.02, 'white'), width / 2 - 0.22, 0.02 + (k + 0.07) * height, 0.285) for k in range(drawers)]
    knobs = [move(primitive_call('sphere', shape_kwargs={'radius': 0.02}, color=COLORS['gray']), width / 2 - 0.22, 0.02 + (k + 0.5) * height, 0.31)
             for k in range(drawers)]
    lamp = concat_shapes(
        primitive_call('cylinder', shape_kwargs={'radius': 0.08, 'p0': (0, 0, 0), 'p1': (0, 0.02, 0)}, color=COLORS['gray']),
        primitive_call('cylinder', shape_kwargs={'radius': 0.012, 'p0': (0, 0, 0), 'p1': (0.1, 0.35, 0)}, color=COLORS['gray']),
        primitive_call('cylinder', shape_kwargs={'radius': 0.07, 'p0': (0.1, 0.35, 0), 'p1': (0.17, 0.28, 0)}, color=COLORS['yellow']))
    return concat_shapes(top, *legs, chest, *fronts, *knobs, move(lamp, -width / 2 + 0.2, 0.74, -0.15))


@register("a teddy bear that sits")
def teddy(size: float = 0.3) -> Shape:
    fur, face = (0.62, 0.42, 0.25), (0.85, 0.7, 0.5)
    lumps = [
        ((0, 0.5, 0), 0.5, fur), ((0, 1.25, 0), 0.38, fur), ((0, 1.17, 0.28), 0.17, face),
        ((-0.3, 1.58, 0), 0.14, fur), ((0.3, 1.58, 0), 0.14, fur),
        ((-0.52, 0.7, 0.2), 0.17, fur), ((0.52, 0.7, 0.2), 0.17, fur),
        ((-0.35, 0.15, 0.5), 0.2, fur), ((0.35, 0.15, 0.5), 0.2, fur),
        ((0, 1.22, 0.45), 0.05, (0, 0, 0)), ((-0.14, 1.35, 0.34), 0.045, (0, 0, 0)), ((0.14, 1.35, 0.34), 0.045, (0, 0, 0)),
    ]
    shapes = [move(primitive_call('sphere', shape_kwargs={'radius': r}, color=c), *p) for p, r, c in lumps]
    return transform_shape(concat_shapes(*shapes), scale_matrix(size, (0, 0, 0)))


@register("a round rug of rings in two colors")
def rug(rings: int = 5, radius: float = 0.9) -> Shape:
    return loop(rings, lambda i: primitive_call('cylinder', shape_kwargs={
        'radius': radius * (rings - i) / rings, 'p0': (0, 0, 0), 'p1': (0, 0.01 + 0.004 * i, 0),
    }, color=COLORS['blue'] if i % 2 == 0 else COLORS['white']))


@register()
def kids_bedroom(room: float = 4.2) -> Shape:
    floor = move(box(room, 0.1, room), 0, -0.1)
    walls = [move(box(room, 2.5, 0.08, 'white'), 0, 0, -room / 2), move(box(0.08, 2.5, room, 'yellow'), -room / 2)]
    wardrobe = concat_shapes(box(1.0, 2.0, 0.55), *[move(box(0.48, 1.9, 0.02, 'white'), s * 0.25, 0.05, 0.28) for s in (-1, 1)])
    return concat_shapes(
        floor, *walls,
        move(library_call('bunk_bed'), -0.9, 0, -1.5),
        move(library_call('desk'), 1.3, 0, -1.7),
        move(transform_shape(wardrobe, rotation_matrix(math.pi / 2, (0, 1, 0), (0, 0, 0))), -1.8, 0, 1.0),
        move(library_call('rug'), 0.4, 0, 0.6),
        move(library_call('teddy'), 0.5, 0.02, 0.5))
