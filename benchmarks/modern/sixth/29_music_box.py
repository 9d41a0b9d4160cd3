"""a music box: the melody is a string of notes, and its pins sit on a brass cylinder"""
from helper import *
import math
import re
from collections import namedtuple, defaultdict
from contextlib import contextmanager
from fractions import Fraction

TUNE = "C4/4 D4/4 E4/4 C4/4 C4/4 D4/4 E4/4 C4/4 E4/4 F4/4 G4/2 E4/4 F4/4 G4/2 G4/8 A4/8 G4/8 F4/8 E4/4 C4/4"
Note = namedtuple('Note', 'pitch start length')
NOTE = re.compile(r"(?P<name>[A-G])(?P<sharp>#?)(?P<octave>\d)/(?P<part>\d+)")
SEMITONES = dict(zip('CDEFGAB', (0, 2, 4, 5, 7, 9, 11)))
BRASS, STEEL, WOOD = (0.83, 0.66, 0.28), (0.7, 0.72, 0.75), (0.42, 0.25, 0.13)


def parse(tune: str) -> list[Note]:
    notes, clock = [], Fraction(0)
    for m in NOTE.finditer(tune):
        pitch = 12 * int(m['octave']) + SEMITONES[m['name']] + len(m['sharp'])
        length = Fraction(1, int(m['part']))
        notes.append(Note(pitch, clock, length))
        clock += length
    return notes


NOTES = parse(TUNE)
TOTAL = sum((n.length for n in NOTES), Fraction(0))
SCALE = sorted({n.pitch for n in NOTES})
BY_PITCH = defaultdict(list)
for note in NOTES:
    BY_PITCH[note.pitch].append(note)


class Assembly:
    """Collects shapes; `at` moves what is added within its block."""

    def __init__(self):
        self.shapes: list[Shape] = []
        self.offset = (0.0, 0.0, 0.0)

    @contextmanager
    def at(self, x=0.0, y=0.0, z=0.0):
        old = self.offset
        self.offset = tuple(a + b for a, b in zip(old, (x, y, z)))
        try:
            yield self
        finally:
            self.offset = old

    def add(self, *shapes: Shape) -> 'Assembly':
        self.shapes.extend(transform_shape(s, translation_matrix(self.offset)) for s in shapes)
        return self

    def finish(self) -> Shape:
        return concat_shapes(*self.shapes)


def rod(a, b, r, color):
    return primitive_call('cylinder', shape_kwargs={'radius': r, 'p0': a, 'p1': b}, color=color)


@register("the drum along x, with a pin for each note")
def drum(radius: float = 0.5, lane: float = 0.18) -> Shape:
    width = lane * (len(SCALE) + 1)
    pins = []
    for track, pitch in enumerate(SCALE):
        x = (track + 1) * lane
        for note in BY_PITCH[pitch]:
            angle = 2 * math.pi * float(note.start / TOTAL) * 0.95
            y, z = math.cos(angle), math.sin(angle)
            pins.append(rod((x, radius * y, radius * z), (x, (radius + 0.08) * y, (radius + 0.08) * z), 0.02, STEEL))
    return concat_shapes(rod((0, 0, 0), (width, 0, 0), radius, BRASS), rod((-0.25, 0, 0), (width + 0.25, 0, 0), 0.06, STEEL), *pins)


@register("a steel comb: low notes have long teeth")
def comb(lane: float = 0.18) -> Shape:
    shapes = []
    for track, pitch in enumerate(SCALE):
        length = 0.9 - 0.06 * (pitch - SCALE[0])
        tooth = primitive_call('cube', shape_kwargs={'scale': (lane * 0.8, 0.03, length)}, color=STEEL)
        shapes.append(transform_shape(tooth, translation_matrix(((track + 1) * lane, 0, length / 2))))
    spine = primitive_call('cube', shape_kwargs={'scale': (lane * (len(SCALE) + 1), 0.12, 0.3)}, color=STEEL)
    shapes.append(transform_shape(spine, translation_matrix((lane * (len(SCALE) + 1) / 2, 0, 1.0))))
    return concat_shapes(*shapes)


@register()
def crank(reach: float = 0.45) -> Shape:
    return concat_shapes(rod((0, 0, 0), (0, reach, 0), 0.04, STEEL), rod((0, reach, 0), (0.3, reach, 0), 0.035, STEEL),
                         transform_shape(primitive_call('sphere', shape_kwargs={'radius': 0.1}, color=(0.15, 0.1, 0.1)), translation_matrix((0.36, reach, 0))))


@register()
def music_box(lane: float = 0.18) -> Shape:
    width = lane * (len(SCALE) + 1)
    work = Assembly()
    work.add(transform_shape(primitive_call('cube', shape_kwargs={'scale': (width + 0.8, 0.15, 2.6)}, color=WOOD), translation_matrix((width / 2, -0.8, 0.4))))
    for x in (-0.12, width + 0.12):
        with work.at(x, -0.36, 0):
            work.add(primitive_call('cube', shape_kwargs={'scale': (0.08, 0.8, 0.3)}, color=BRASS))
    work.add(library_call('drum', lane=lane))
    with work.at(z=0.6):
        work.add(library_call('comb', lane=lane))
        with work.at(y=-0.4):
            work.add(transform_shape(primitive_call('cube', shape_kwargs={'scale': (width, 0.7, 0.25)}, color=WOOD), translation_matrix((width / 2, 0, 1.0))))
    with work.at(x=width + 0.25):
        work.add(library_call('crank'))
    return work.finish()
