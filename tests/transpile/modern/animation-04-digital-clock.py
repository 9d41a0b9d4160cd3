from enum import Flag
from functools import cache
from helper import *

"""
a seven segment clock that counts down to launch
"""


class Seg(Flag):
    A = 1
    B = 2
    C = 4
    D = 8
    E = 16
    F = 32
    G = 64


DIGITS = [
    Seg.A | Seg.B | Seg.C | Seg.D | Seg.E | Seg.F,
    Seg.B | Seg.C,
    Seg.A | Seg.B | Seg.G | Seg.E | Seg.D,
    Seg.A | Seg.B | Seg.G | Seg.C | Seg.D,
    Seg.F | Seg.G | Seg.B | Seg.C,
    Seg.A | Seg.F | Seg.G | Seg.C | Seg.D,
    ~Seg.B,
    Seg.A | Seg.B | Seg.C,
    Seg(127),
    Seg(127) ^ Seg.E,
]
LAYOUT = {Seg.A: (0, 2, 1), Seg.G: (0, 1, 1), Seg.D: (0, 0, 1), Seg.F: (-0.5, 1.5, 0), Seg.B: (0.5, 1.5, 0), Seg.E: (-0.5, 0.5, 0), Seg.C: (0.5, 0.5, 0)}


@cache
def segment(flat: int, lit: bool):
    color = (1.0, 0.15, 0.1) if lit else (0.15, 0.05, 0.05)
    return primitive_call('cube', color=color, shape_kwargs={'scale': (0.8, 0.15, 0.1) if flat else (0.15, 0.8, 0.1)})


@register()
def digit(n: int) -> Shape:
    mask = DIGITS[n]
    return concat_shapes(*[transform_shape(segment(flat, seg in mask), translation_matrix((x, y, 0))) for seg, (x, y, flat) in LAYOUT.items()])


@register()
def display(seconds: int, blink: bool) -> Shape:
    text = f"{seconds // 60:02d}{seconds % 60:02d}"
    digits = [transform_shape(library_call('digit', n=int(ch)), translation_matrix((1.5 * i + (0.5 if i > 1 else 0), 0, 0))) for i, ch in enumerate(text)]
    dots = loop(2, lambda i: transform_shape(primitive_call('sphere', color=(1, 0.2, 0.1) if blink else (0.1, 0, 0), shape_kwargs={'radius': 0.1}), translation_matrix((2.5, 0.6 + 0.8 * i, 0))))
    return concat_shapes(*digits, dots)


@register_animation()
def countdown():
    start, frame = 65, 0
    while (left := start - frame) >= 55:
        yield library_call('display', seconds=left, blink=not frame % 2)
        frame += 1
    for left in (3, 2, 1, 0):
        yield library_call('display', seconds=left, blink=left == 0)
