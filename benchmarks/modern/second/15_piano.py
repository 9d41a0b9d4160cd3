"""
a grand piano with its lid open and a bench
"""
from helper import *
import math
from dataclasses import dataclass, KW_ONLY
from enum import IntEnum
from itertools import compress, count, cycle, islice

BLACK_PATTERN = (0, 1, 0, 1, 0, 0, 1, 0, 1, 0, 1, 0)


class Note(IntEnum):
    C = 0; CS = 1; D = 2; DS = 3; E = 4; F = 5; FS = 6; G = 7; GS = 8; A = 9; AS = 10; B = 11

    @property
    def is_black(self) -> bool:
        return bool(BLACK_PATTERN[self])


@dataclass
class Key:
    note: Note
    index: int
    _: KW_ONLY
    white_before: int

    @property
    def x(self) -> float:
        return self.white_before * 0.1 - (0.0 if self.note.is_black else -0.05)


def keyboard_layout(n: int = 88, first: Note = Note.A) -> list[Key]:
    notes = islice(cycle(Note), first, first + n)
    keys, whites = [], 0
    for i, note in enumerate(notes):
        keys.append(Key(note, i, white_before=whites))
        whites += not note.is_black
    assert whites == 52, whites
    return keys


@register()
def piano_key(black: bool = False) -> Shape:
    if black:
        k = primitive_call('cube', {'scale': (0.055, 0.08, 0.4)}, color=(0.05, 0.05, 0.05))
        return transform_shape(k, translation_matrix((0, 0.06, -0.1)))
    return primitive_call('cube', {'scale': (0.094, 0.06, 0.6)}, color=(0.97, 0.96, 0.92))


@register()
def keyboard(n: int = 88) -> Shape:
    keys = [transform_shape(library_call('piano_key', black=k.note.is_black), translation_matrix((k.x, 0, 0))) for k in keyboard_layout(n)]
    joined = concat_shapes(*keys)
    cx, *_rest = compute_shape_center(joined)
    return transform_shape(joined, translation_matrix((-cx, 0, 0)))


def outline(t: float) -> float:
    """depth of the case for a position across, 0 is the bass side"""
    return 5.0 - 2.6 * (1 / (1 + math.exp(-10 * (t - 0.55))))


@register()
def case(width: float = 5.6, strips: int = 28, thickness: float = 0.5, color: tuple = (0.06, 0.06, 0.07)) -> Shape:
    w = width / strips

    def strip(i: int) -> Shape:
        depth = outline((i + 0.5) / strips)
        s = primitive_call('cube', {'scale': (w * 1.01, thickness, depth)}, color=color)
        return transform_shape(s, translation_matrix((-width / 2 + (i + 0.5) * w, 0, -depth / 2)))

    return loop(strips, strip)


@register()
def lid(width: float = 5.6, angle: float = 0.9) -> Shape:
    flat = library_call('case', width=width, thickness=0.06, color=(0.1, 0.1, 0.11))
    hinge = (-width / 2, 0, 0)
    return transform_shape(flat, rotation_matrix(angle, (0, 0, 1), hinge))


@register()
def leg(height: float = 1.6) -> Shape:
    parts = [('cylinder', {'radius': 0.12, 'p0': (0, 0.1, 0), 'p1': (0, height, 0)}), ('sphere', {'radius': 0.1})]
    return concat_shapes(*(primitive_call(kind, kw, color=c) for (kind, kw), c in zip(parts, [(0.06, 0.06, 0.07), (0.75, 0.6, 0.3)], strict=True)))


@register()
def bench(width: float = 1.8, height: float = 1.2) -> Shape:
    seat = transform_shape(primitive_call('cube', {'scale': (width, 0.2, 0.8)}, color=(0.3, 0.08, 0.08)), translation_matrix((0, height, 0)))
    ends = [(sx * width * 0.42, sz * 0.3) for sx in (-1, 1) for sz in (-1, 1)]
    legs = [primitive_call('cylinder', {'radius': 0.05, 'p0': (x, 0, z), 'p1': (x, height, z)}, color=(0.05, 0.05, 0.05)) for x, z in ends]
    return concat_shapes(seat, *legs)


@register()
def grand_piano() -> Shape:
    body = transform_shape(library_call('case'), translation_matrix((0, 1.85, 0)))
    cover = transform_shape(library_call('lid'), translation_matrix((0, 2.15, 0)))
    shelf = transform_shape(primitive_call('cube', {'scale': (5.6, 0.2, 0.8)}, color=(0.06, 0.06, 0.07)), translation_matrix((0, 1.72, 0.4)))
    keys = transform_shape(library_call('keyboard'), translation_matrix((0, 1.88, 0.35)))
    legs = [transform_shape(library_call('leg'), translation_matrix((x, 0, z))) for x, z in ((-2.5, 0.2), (2.5, 0.2), (-1.6, -4.3))]
    prop = primitive_call('cylinder', {'radius': 0.03, 'p0': (1.5, 2.1, -1.0), 'p1': (0.0, 2.1 + 2.8 * math.tan(0.9), -1.0)}, color=(0.75, 0.6, 0.3))
    pedals = loop(3, lambda i: transform_shape(primitive_call('cube', {'scale': (0.12, 0.05, 0.4)}, color=(0.8, 0.65, 0.3)),
                                               translation_matrix(((i - 1) * 0.3, 0.1, 0.2))))
    seat = transform_shape(library_call('bench'), translation_matrix((0, 0, 1.9)))
    return concat_shapes(body, cover, shelf, keys, *legs, prop, pedals, seat)
