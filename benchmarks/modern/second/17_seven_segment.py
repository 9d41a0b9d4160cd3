"""
a digital alarm clock on a nightstand showing 07:45
"""
from helper import *
import re
from enum import Flag, auto
from functools import cached_property, singledispatchmethod
from itertools import chain


class Seg(Flag):
    A = auto(); B = auto(); C = auto(); D = auto(); E = auto(); F = auto(); G = auto()


def S(text: str) -> Seg:
    out = Seg(0)
    for ch in text.upper():
        out |= Seg[ch]
    return out


DIGITS = [S(t) for t in 'abcdef bc abged abgcd fgbc afgcd afgecd abc abcdefg abcdfg'.split()]

PLACES = {  # centre and whether it lies flat
    Seg.A: ((0, 1.0), True), Seg.G: ((0, 0.0), True), Seg.D: ((0, -1.0), True),
    Seg.F: ((-0.5, 0.5), False), Seg.B: ((0.5, 0.5), False),
    Seg.E: ((-0.5, -0.5), False), Seg.C: ((0.5, -0.5), False),
}


class Display:
    """Lays out a text such as 07:45 as lit and unlit segments."""
    LIT = (1.0, 0.15, 0.1)
    DIM = (0.18, 0.03, 0.03)

    def __init__(self, text: str, height: float = 0.5):
        if not re.fullmatch(r'(?P<h>[01]\d|2[0-3]):(?P<m>[0-5]\d)', text):
            raise ValueError(f'not a time: {text!r}')
        self.text = text
        self.height = height

    @cached_property
    def advance(self) -> float:
        return self.height * 0.9

    def __len__(self) -> int:
        return len(self.text)

    def __iter__(self):
        x = -self.advance * (len(self) - 1) / 2
        for ch in self.text:
            yield x, (int(ch) if ch.isdigit() else ch)
            x += self.advance

    @singledispatchmethod
    def cell(self, what) -> Shape:
        raise TypeError(type(what).__name__)

    @cell.register
    def _(self, what: int) -> Shape:
        lit = DIGITS[what]
        return library_call('digit', mask=lit.value, scale=self.height / 2)

    @cell.register
    def _(self, what: str) -> Shape:
        dot = primitive_call('cube', {'scale': (0.07, 0.07, 0.03)}, color=self.LIT)
        return concat_shapes(*[transform_shape(dot, translation_matrix((0, y, 0))) for y in (-0.1, 0.1)])

    def render(self) -> Shape:
        return list(chain.from_iterable(transform_shape(self.cell(w), translation_matrix((x, 0, 0))) for x, w in self))


@register()
def digit(mask: int = 127, scale: float = 0.25) -> Shape:
    lit = Seg(mask)
    bars = []
    for seg, ((x, y), flat) in PLACES.items():
        dims = (scale * 0.8, scale * 0.18, 0.03) if flat else (scale * 0.18, scale * 0.8, 0.03)
        bar = primitive_call('cube', {'scale': dims}, color=Display.LIT if seg in lit else Display.DIM)
        bars.append(transform_shape(bar, translation_matrix((x * scale, y * scale, 0))))
    return concat_shapes(*bars)


@register()
def alarm_clock(time: str = '07:45', width: float = 2.6, height: float = 1.0) -> Shape:
    shell = primitive_call('cube', {'scale': (width, height, 0.8)}, color=(0.15, 0.15, 0.17))
    glass = transform_shape(primitive_call('cube', {'scale': (width * 0.93, height * 0.8, 0.02)}, color=(0.03, 0.0, 0.0)), translation_matrix((0, 0, 0.4)))
    readout = transform_shape(Display(time).render(), translation_matrix((0, 0, 0.43)))
    snooze = transform_shape(primitive_call('cube', {'scale': (0.9, 0.08, 0.3)}, color=(0.6, 0.6, 0.62)), translation_matrix((0, height / 2 + 0.03, 0)))
    return transform_shape(concat_shapes(shell, glass, readout, snooze), translation_matrix((0, height / 2, 0)))


@register()
def nightstand(width: float = 4.0, height: float = 3.0, drawers: int = 2) -> Shape:
    oak = (0.55, 0.38, 0.22)
    body = transform_shape(primitive_call('cube', {'scale': (width, height, 2.5)}, color=oak), translation_matrix((0, -height / 2, 0)))

    def drawer(i: int) -> Shape:
        front = primitive_call('cube', {'scale': (width * 0.9, height / drawers * 0.85, 0.1)}, color=(0.62, 0.45, 0.28))
        knob = transform_shape(primitive_call('sphere', {'radius': 0.12}, color=(0.8, 0.7, 0.4)), translation_matrix((0, 0, 0.15)))
        return transform_shape(concat_shapes(front, knob), translation_matrix((0, -height * (i + 0.5) / drawers, 1.28)))

    return concat_shapes(body, loop(drawers, drawer))


@register()
def bedside() -> Shape:
    lamp = concat_shapes(
        primitive_call('cylinder', {'radius': 0.3, 'p0': (0, 0, 0), 'p1': (0, 0.08, 0)}, color=(0.3, 0.3, 0.3)),
        primitive_call('cylinder', {'radius': 0.05, 'p0': (0, 0.08, 0), 'p1': (0, 1.4, 0)}, color=(0.7, 0.6, 0.4)),
        primitive_call('cylinder', {'radius': 0.55, 'p0': (0, 1.3, 0), 'p1': (0, 2.0, 0)}, color=(0.98, 0.93, 0.8)))
    return concat_shapes(library_call('nightstand'), library_call('alarm_clock', time='07:45'),
                         transform_shape(lamp, translation_matrix((1.5, 0, -0.7))))
