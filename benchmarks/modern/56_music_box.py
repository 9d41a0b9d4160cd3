"""a music box cylinder with pins encoding 'Twinkle Twinkle Little Star' and a steel comb"""
from helper import *
import math
import re

TUNE = "C4 C4 G4 G4 A4 A4 G4:2 F4 F4 E4 E4 D4 D4 C4:2"
NOTES = {n: i for i, n in enumerate("C D E F G A B".split())}
PATTERN = re.compile(r"(?P<name>[A-G])(?P<octave>\d)(?::(?P<beats>\d+))?")


def parse(tune: str) -> list[tuple[int, float]]:
    """-> [(comb tooth, start beat)]"""
    beat, events = 0.0, []
    for token in tune.split():
        m = PATTERN.fullmatch(token)
        if not m:
            raise ValueError(f"bad note: {token}")
        tooth = NOTES[m['name']] + 7 * (int(m['octave']) - 4)
        events.append((tooth, beat))
        beat += float(m.group('beats') or 1)
    return events


EVENTS = parse(TUNE)
TOTAL = EVENTS[-1][1] + 2


@register()
def pin(tooth: int, beat: float, radius: float, pitch: float) -> Shape:
    a = 2 * math.pi * beat / TOTAL
    x = (tooth - 3) * pitch
    inner = (x, radius * math.cos(a), radius * math.sin(a))
    outer = (x, (radius + 0.12) * math.cos(a), (radius + 0.12) * math.sin(a))
    return primitive_call('cylinder', shape_kwargs={'radius': 0.025, 'p0': inner, 'p1': outer}, color=(0.8, 0.8, 0.82))


@register()
def drum(radius: float = 0.6, pitch: float = 0.25) -> Shape:
    half = 4.2 * pitch
    body = primitive_call('cylinder', shape_kwargs={'radius': radius, 'p0': (-half, 0, 0), 'p1': (half, 0, 0)}, color=(0.85, 0.68, 0.3))
    axle = primitive_call('cylinder', shape_kwargs={'radius': 0.06, 'p0': (-half - 0.3, 0, 0), 'p1': (half + 0.6, 0, 0)}, color=(0.5, 0.5, 0.52))
    pins = [library_call('pin', tooth=t, beat=b, radius=radius, pitch=pitch) for t, b in EVENTS]
    return concat_shapes(body, axle, *pins)


@register()
def comb(teeth: int = 7, pitch: float = 0.25, reach: float = 0.78) -> Shape:
    def tooth(i: int) -> Shape:
        length = 0.9 - 0.06 * i
        bar = primitive_call('cube', shape_kwargs={'scale': (pitch * 0.7, 0.04, length)}, color=(0.65, 0.67, 0.7))
        return transform_shape(bar, translation_matrix(((i - 3) * pitch, 0, reach + length / 2)))
    spine = transform_shape(primitive_call('cube', shape_kwargs={'scale': (teeth * pitch + 0.2, 0.12, 0.4)}, color=(0.55, 0.57, 0.6)), translation_matrix((0, 0, reach + 1.0)))
    return concat_shapes(loop(teeth, tooth), spine)


@register()
def crank(x: float = 1.6) -> Shape:
    arm = primitive_call('cylinder', shape_kwargs={'radius': 0.05, 'p0': (x, 0, 0), 'p1': (x, 0.6, 0)}, color=(0.5, 0.5, 0.52))
    knob = primitive_call('cylinder', shape_kwargs={'radius': 0.1, 'p0': (x, 0.6, 0), 'p1': (x + 0.35, 0.6, 0)}, color=(0.4, 0.2, 0.1))
    return concat_shapes(arm, knob)


@register()
def music_box() -> Shape:
    base = transform_shape(primitive_call('cube', shape_kwargs={'scale': (3.2, 0.2, 3.6)}, color=(0.4, 0.24, 0.14)), translation_matrix((0, -0.9, 0.5)))
    posts = [transform_shape(primitive_call('cube', shape_kwargs={'scale': (0.1, 0.9, 0.3)}, color=(0.6, 0.6, 0.62)), translation_matrix((s * 1.25, -0.4, 0))) for s in (-1, 1)]
    return concat_shapes(base, *posts, library_call('drum'), library_call('comb'), library_call('crank'))
