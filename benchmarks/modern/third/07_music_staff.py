"""
a sheet of music standing on a stand, notes parsed from text
"""
from helper import *
import re
from collections import Counter
from dataclasses import dataclass
from fractions import Fraction
from itertools import accumulate

TUNE = 'C4:1/4 D4:1/8 E4:1/8 F4:1/4 G4:1/2 | A4:1/8 G4:1/8 F4:1/8 E4:1/8 D4:1/4 C4:1/4'
NOTE = re.compile(r'(?P<name>[A-G])(?P<octave>\d):(?P<num>\d+)/(?P<den>\d+)')
STEPS = {name: i for i, name in enumerate('CDEFGAB')}


@dataclass(frozen=True)
class Note:
    name: str
    octave: int
    length: Fraction

    @property
    def line(self) -> int:
        return STEPS[self.name] + 7 * (self.octave - 4)

    @property
    def is_open(self) -> bool:
        return self.length >= Fraction(1, 2)

    @property
    def flags(self) -> int:
        return 1 if self.length <= Fraction(1, 8) else 0


def parse(text: str) -> list[Note]:
    notes = []
    for token in text.split():
        if m := NOTE.fullmatch(token):
            notes.append(Note(m['name'], int(m['octave']), Fraction(int(m['num']), int(m['den']))))
    return notes


NOTES = parse(TUNE)
STARTS = [0, *accumulate(n.length for n in NOTES)][:-1]
USED = Counter(n.name for n in NOTES)


@register()
def staff(length: float = 8.0, gap: float = 0.3) -> Shape:
    lines = [primitive_call('cylinder', color=(0.1, 0.1, 0.1), shape_kwargs={'radius': 0.015, 'p0': (0, (k + 1) * gap, 0), 'p1': (length, (k + 1) * gap, 0)}) for k in range(5)]
    return concat_shapes(*lines)


@register()
def note_head(is_open: bool = False, flags: int = 0, gap: float = 0.3) -> Shape:
    color = (0.9, 0.9, 0.88) if is_open else (0.05, 0.05, 0.05)
    head = primitive_call('sphere', color=color, shape_kwargs={'radius': gap * 0.5})
    stem = primitive_call('cylinder', color=(0.05, 0.05, 0.05), shape_kwargs={'radius': 0.02, 'p0': (gap * 0.45, 0, 0), 'p1': (gap * 0.45, gap * 3, 0)})
    flag = [primitive_call('cylinder', color=(0.05, 0.05, 0.05), shape_kwargs={'radius': 0.025, 'p0': (gap * 0.45, gap * (3 - 0.4 * k), 0), 'p1': (gap * 1.1, gap * (2.2 - 0.4 * k), 0)}) for k in range(flags)]
    return concat_shapes(head, stem, *flag)


@register()
def melody(gap: float = 0.3, stretch: float = 4.0) -> Shape:
    heads = []
    for note, start in zip(NOTES, STARTS):
        shape = library_call('note_head', is_open=note.is_open, flags=note.flags, gap=gap)
        heads.append(transform_shape(shape, translation_matrix((0.5 + float(start) * stretch, note.line * gap / 2, 0.05))))
    return concat_shapes(*heads)


@register()
def histogram(width: float = 0.25) -> Shape:
    bars = []
    for i, (name, n) in enumerate(USED.most_common()):
        bar = primitive_call('cube', color=(0.2 + 0.1 * STEPS[name], 0.4, 0.7), shape_kwargs={'scale': (width, n * 0.3, width)})
        bars.append(transform_shape(bar, translation_matrix((i * width * 1.5, n * 0.15, 1.5))))
    return concat_shapes(*bars)


@register()
def music_stand() -> Shape:
    total = float(sum(n.length for n in NOTES))
    length = 1.0 + total * 4.0
    page = transform_shape(primitive_call('cube', color=(0.97, 0.95, 0.9), shape_kwargs={'scale': (length, 3.0, 0.04)}), translation_matrix((length / 2, 0.9, -0.05)))
    post = primitive_call('cylinder', color=(0.2, 0.2, 0.2), shape_kwargs={'radius': 0.08, 'p0': (length / 2, -3, -0.1), 'p1': (length / 2, -0.6, -0.1)})
    return concat_shapes(page, post, library_call('staff', length=length), library_call('melody'), library_call('histogram'))
