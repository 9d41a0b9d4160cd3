"""
a clock tower showing ten past ten, with roman numerals
"""
from helper import *
from datetime import datetime, timedelta
from fractions import Fraction
import math

STONE = (0.72, 0.66, 0.56)
DARK = (0.12, 0.12, 0.14)


def roman(n: int) -> str:
    out = ''
    for value, digit in ((10, 'X'), (9, 'IX'), (5, 'V'), (4, 'IV'), (1, 'I')):
        q, n = divmod(n, value)
        out += digit * q
    return out


def hand_fractions(t: datetime) -> tuple[Fraction, Fraction]:
    midnight = t.replace(hour=0, minute=0, second=0, microsecond=0)
    minutes = Fraction(int((t - midnight) / timedelta(minutes=1)))
    return (minutes / 720) % 1, (minutes / 60) % 1


def around_face(frac: Fraction | float, r: float) -> tuple[float, float, float]:
    a = math.tau * float(frac)
    return r * math.sin(a), r * math.cos(a), 0.0


STROKES = {
    'I': [((0, -1), (0, 1))],
    'V': [((-0.5, 1), (0, -1)), ((0.5, 1), (0, -1))],
    'X': [((-0.5, 1), (0.5, -1)), ((0.5, 1), (-0.5, -1))],
}


@register()
def glyph(char: str = 'X', size: float = 0.06, color: tuple = DARK) -> Shape:
    bars = []
    for (ax, ay), (bx, by) in STROKES[char]:
        bars.append(primitive_call('cylinder', {'radius': size * 0.2, 'p0': (ax * size, ay * size, 0), 'p1': (bx * size, by * size, 0)}, color=color))
    return concat_shapes(*bars)


@register()
def numeral(n: int = 12, size: float = 0.06) -> Shape:
    word = roman(n)
    pitch = size * 1.1
    x0 = -pitch * (len(word) - 1) / 2
    return concat_shapes(*[
        transform_shape(library_call('glyph', char=c, size=size), translation_matrix((x0 + i * pitch, 0, 0)))
        for i, c in enumerate(word)
    ])


@register()
def hand(length: float = 0.5, frac: float = 0.0, thickness: float = 0.03) -> Shape:
    bar = primitive_call('cube', {'scale': (thickness, length, thickness)}, color=DARK)
    bar = transform_shape(bar, translation_matrix((0, length / 2 - 0.06, 0)))
    return transform_shape(bar, rotation_matrix(-math.tau * frac, (0, 0, 1), (0, 0, 0)))


@register()
def clock_face(radius: float = 0.75, hour: int = 10, minute: int = 10) -> Shape:
    t = datetime(2025, 1, 1, hour, minute)
    h, m = hand_fractions(t)
    assert 0 <= h < 1 and 0 <= m < 1
    dial = primitive_call('cylinder', {'radius': radius, 'p0': (0, 0, -0.04), 'p1': (0, 0, 0)}, color=(0.96, 0.94, 0.86))
    rim = primitive_call('cylinder', {'radius': radius * 1.08, 'p0': (0, 0, -0.06), 'p1': (0, 0, -0.02)}, color=(0.75, 0.6, 0.25))
    numbers = [transform_shape(library_call('numeral', n=k), translation_matrix(around_face(Fraction(k, 12), radius * 0.8)))
               for k in range(1, 13)]
    hands = [transform_shape(library_call('hand', length=radius * f, frac=float(q)), translation_matrix((0, 0, dz)))
             for f, q, dz in ((0.55, h, 0.04), (0.8, m, 0.08))]
    boss = primitive_call('sphere', {'radius': 0.05}, color=(0.75, 0.6, 0.25))
    return concat_shapes(rim, dial, *numbers, *hands, boss)


@register()
def spire(width: float = 2.0, height: float = 1.8, n: int = 12) -> Shape:
    def course(i: int) -> Shape:
        f = 1 - Fraction(i, n)
        w = float(f) * width
        block = primitive_call('cube', {'scale': (w, height / n, w)}, color=(0.25, 0.36, 0.38))
        return transform_shape(block, translation_matrix((0, (i + 0.5) * height / n, 0)))
    return loop(n, course)


@register()
def clock_tower(height: float = 6.0, width: float = 2.0) -> Shape:
    shaft = transform_shape(primitive_call('cube', {'scale': (width, height, width)}, color=STONE), translation_matrix((0, height / 2, 0)))
    cornices = [transform_shape(primitive_call('cube', {'scale': (width + 0.2, 0.15, width + 0.2)}, color=(0.62, 0.56, 0.46)),
                                translation_matrix((0, y, 0))) for y in (0.1, height * 0.66, height)]
    face = transform_shape(library_call('clock_face'), translation_matrix((0, height * 0.83, width / 2 + 0.07)))
    faces = loop(4, lambda i: transform_shape(face, rotation_matrix(i * math.pi / 2, (0, 1, 0), (0, 0, 0))))
    top = transform_shape(library_call('spire', width=width), translation_matrix((0, height, 0)))
    return concat_shapes(shaft, *cornices, faces, top)
