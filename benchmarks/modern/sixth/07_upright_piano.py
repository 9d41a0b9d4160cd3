"""an upright piano with a bench, sheet music and 52 + 36 keys"""
from helper import *

WALNUT = (0.26, 0.14, 0.08)
IVORY = (0.97, 0.96, 0.9)
EBONY = (0.05, 0.05, 0.05)

# does a black key follow the white key C, D, E, F, G, A, B?
HAS_SHARP = {'C': True, 'D': True, 'E': False, 'F': True, 'G': True, 'A': True, 'B': False}
SCALE = 'ABCDEFG'  # a piano begins with A


def cuboid(w, h, d, x=0, y=0, z=0, color=WALNUT):
    shape = primitive_call('cube', shape_kwargs={'scale': (w, h, d)}, color=color)
    return transform_shape(shape, translation_matrix((x, y, z)))


@register("all keys; the front edge at z = 0, the lowest key begins at x = 0")
def keyboard(whites: int = 52, key_width: float = 0.0235) -> Shape:
    keys = []
    for i in range(whites):
        x = (i + 0.5) * key_width
        keys.append(cuboid(key_width * 0.93, 0.02, 0.15, x, 0.01, -0.075, IVORY))
        name = SCALE[i % 7]
        if HAS_SHARP[name] and i < whites - 1:
            keys.append(cuboid(key_width * 0.55, 0.014, 0.095, x + key_width / 2, 0.027, -0.1025, EBONY))
    return concat_shapes(*keys)


@register("a sheet of music with five-line staves and a few notes")
def sheet_music(staves: int = 4, melody: list[int] = [0, 2, 4, 5, 7, 4, 2, 0]) -> Shape:
    page = cuboid(0.22, 0.3, 0.002, color=(0.98, 0.98, 0.95))
    ink = (0.1, 0.1, 0.1)
    marks = []
    for s in range(staves):
        top = 0.12 - s * 0.07
        for line in range(5):
            marks.append(cuboid(0.19, 0.0008, 0.001, 0, top - line * 0.006, 0.0015, ink))
        for n, degree in enumerate(melody[s % 2:]):
            x = -0.085 + n * 0.024
            y = top - 0.024 + degree * 0.003
            marks.append(transform_shape(primitive_call('sphere', shape_kwargs={'radius': 0.004}, color=ink), translation_matrix((x, y, 0.002))))
            marks.append(cuboid(0.001, 0.018, 0.001, x + 0.0035, y + 0.009, 0.002, ink))
    return concat_shapes(page, *marks)


@register("the case without keys")
def piano_case(width: float = 1.5, height: float = 1.25) -> Shape:
    body = cuboid(width, height, 0.3, 0, height / 2, -0.25)
    lid = cuboid(width + 0.04, 0.03, 0.34, 0, height + 0.015, -0.25)
    bed = cuboid(width, 0.1, 0.32, 0, 0.65, 0.02)
    legs = [cuboid(0.08, 0.6, 0.08, s * (width / 2 - 0.06), 0.3, 0.12) for s in (-1, 1)]
    cheeks = [cuboid(0.1, 0.09, 0.25, s * (width / 2 - 0.05), 0.74, 0.04) for s in (-1, 1)]
    panel = cuboid(width * 0.8, 0.3, 0.01, 0, 1.0, -0.097, (0.33, 0.19, 0.11))
    pedals = loop(3, lambda i: cuboid(0.04, 0.015, 0.16, (i - 1) * 0.1, 0.05, -0.02, (0.85, 0.7, 0.3)))
    return concat_shapes(body, lid, bed, *legs, *cheeks, panel, pedals)


@register()
def bench(width: float = 0.75, height: float = 0.5, buttons: int = 4) -> Shape:
    seat = cuboid(width, 0.04, 0.34, 0, height - 0.06, 0)
    cushion = cuboid(width * 0.96, 0.06, 0.32, 0, height - 0.01, 0, (0.4, 0.06, 0.08))
    legs = [cuboid(0.05, height - 0.08, 0.05, sx * (width / 2 - 0.05), (height - 0.08) / 2, sz * 0.13)
            for sx in (-1, 1) for sz in (-1, 1)]
    tufts = [transform_shape(primitive_call('sphere', shape_kwargs={'radius': 0.012}, color=(0.25, 0.03, 0.05)),
                             translation_matrix((width * ((b + 0.5) / buttons - 0.5), height + 0.02, z)))
             for b in range(buttons) for z in (-0.08, 0.08)]
    return concat_shapes(seat, cushion, *legs, *tufts)


@register()
def upright_piano() -> Shape:
    whites, key_width = 52, 0.0235
    keys = library_call('keyboard', whites=whites, key_width=key_width)
    keys = transform_shape(keys, translation_matrix((-whites * key_width / 2, 0.7, 0.16)))
    music = transform_shape(library_call('sheet_music'), rotation_matrix(-0.25, (1, 0, 0), (0, 0, 0)))
    music = transform_shape(music, translation_matrix((0.0, 1.0, -0.05)))
    stool = transform_shape(library_call('bench'), translation_matrix((0, 0, 0.65)))
    floor = cuboid(2.4, 0.02, 2.0, 0, -0.01, 0.3, (0.6, 0.45, 0.3))
    return concat_shapes(floor, library_call('piano_case'), keys, music, stool)
