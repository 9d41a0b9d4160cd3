"""a castle that a child built of wooden toy blocks"""
from helper import *
import math

RAINBOW = [(0.85, 0.2, 0.2), (0.95, 0.6, 0.15), (0.95, 0.85, 0.2), (0.3, 0.65, 0.3), (0.2, 0.45, 0.8), (0.55, 0.3, 0.65)]
UNIT = 0.4


def paint(i: int) -> tuple[float, float, float]:
    return RAINBOW[i % len(RAINBOW)]


@register("one cubic block; its underside at y = 0")
def block(color: tuple[float, float, float] = (0.8, 0.6, 0.4), w: float = 1, h: float = 1, d: float = 1) -> Shape:
    cube = primitive_call('cube', shape_kwargs={'scale': (w * UNIT * 0.98, h * UNIT * 0.98, d * UNIT * 0.98)}, color=color)
    return transform_shape(cube, translation_matrix((0, h * UNIT / 2, 0)))


@register("a stack of blocks, a bit crooked, with a pointed roof")
def tower(height: int = 5, twist: float = 6.0, offset: int = 0) -> Shape:
    shapes = []
    for level in range(height):
        piece = library_call('block', color=paint(level + offset), w=1.2, d=1.2)
        piece = transform_shape(piece, rotation_matrix(math.radians(twist) * (-1) ** level, (0, 1, 0), (0, 0, 0)))
        shapes.append(transform_shape(piece, translation_matrix((0, level * UNIT, 0))))
    # the roof is made of discs that become smaller
    discs = 6
    for k in range(discs):
        r = UNIT * 0.75 * (1 - k / discs)
        y = height * UNIT + k * UNIT / discs
        shapes.append(primitive_call('cylinder', shape_kwargs={'radius': r, 'p0': (0, y, 0), 'p1': (0, y + UNIT / discs, 0)}, color=paint(offset)))
    tip = primitive_call('sphere', shape_kwargs={'radius': 0.06}, color=(0.95, 0.95, 0.3))
    shapes.append(transform_shape(tip, translation_matrix((0, (height + 1) * UNIT + 0.04, 0))))
    return concat_shapes(*shapes)


@register("a wall along x of staggered bricks and battlements on top")
def wall(length: int = 6, courses: int = 2) -> Shape:
    bricks = []
    for course in range(courses):
        shift = 0.5 if course % 2 else 0.0
        count = length // 2 if not shift else length // 2 - 1
        for k in range(count):
            x = (-length / 2 + 1 + 2 * k + 2 * shift) * UNIT
            bricks.append(transform_shape(library_call('block', color=paint(course + 2 * k), w=2), translation_matrix((x, course * UNIT, 0))))
        if shift:  # half bricks close the ends
            for end in (-1, 1):
                x = end * (length / 2 - 0.5) * UNIT
                bricks.append(transform_shape(library_call('block', color=paint(course)), translation_matrix((x, course * UNIT, 0))))
    merlons = [
        transform_shape(library_call('block', color=paint(4), w=0.6, h=0.5, d=0.8), translation_matrix(((k + 0.5 - length / 2) * UNIT, courses * UNIT, 0)))
        for k in range(length) if k % 2 == 0
    ]
    return concat_shapes(*bricks, *merlons)


@register("two pillars, an arch of wedges, and a beam")
def gate(span: float = 1.2) -> Shape:
    pillars = [primitive_call('cylinder', shape_kwargs={'radius': 0.16, 'p0': (s * span / 2, 0, 0), 'p1': (s * span / 2, 0.8, 0)}, color=(0.85, 0.7, 0.5))
               for s in (-1, 1)]
    wedges = 7

    def wedge(i: int) -> Shape:
        a = math.pi * (i + 0.5) / wedges
        piece = primitive_call('cube', shape_kwargs={'scale': (0.2, 0.26, 0.36)}, color=paint(i))
        piece = transform_shape(piece, rotation_matrix(a, (0, 0, 1), (0, 0, 0)))
        return transform_shape(piece, translation_matrix((span / 2 * math.cos(a), 0.8 + span / 2 * math.sin(a), 0)))

    return concat_shapes(*pillars, loop(wedges, wedge))


@register("a banner on a stick")
def flag(color: tuple[float, float, float] = (0.9, 0.1, 0.3)) -> Shape:
    stick = primitive_call('cylinder', shape_kwargs={'radius': 0.02, 'p0': (0, 0, 0), 'p1': (0, 0.7, 0)}, color=(0.7, 0.5, 0.3))
    cloth = [transform_shape(primitive_call('cube', shape_kwargs={'scale': (0.1, 0.22, 0.015)}, color=color),
                             translation_matrix((0.06 + 0.1 * k, 0.56, 0.03 * math.sin(k * 1.2)))) for k in range(4)]
    return concat_shapes(stick, *cloth)


@register()
def toy_block_castle(side: float = 3.0) -> Shape:
    half = side / 2
    corners = [(sx * half, sz * half) for sx in (-1, 1) for sz in (-1, 1)]
    towers = [transform_shape(library_call('tower', height=4 + i % 2, offset=i), translation_matrix((x, 0, z))) for i, (x, z) in enumerate(corners)]
    back = transform_shape(library_call('wall', length=6), translation_matrix((0, 0, -half)))
    sides = []
    for s in (-1, 1):
        w = transform_shape(library_call('wall', length=6, courses=2 + (s > 0)), rotation_matrix(math.pi / 2, (0, 1, 0), (0, 0, 0)))
        sides.append(transform_shape(w, translation_matrix((s * half, 0, 0))))
    entry = transform_shape(library_call('gate'), translation_matrix((0, 0, half)))
    banner = transform_shape(library_call('flag'), translation_matrix((0, 2 * UNIT, -half)))
    rug = transform_shape(primitive_call('cube', shape_kwargs={'scale': (5, 0.04, 5)}, color=(0.75, 0.8, 0.85)), translation_matrix((0, -0.02, 0)))
    return concat_shapes(rug, *towers, back, *sides, entry, banner)
