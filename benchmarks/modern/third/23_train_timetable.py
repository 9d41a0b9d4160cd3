"""
a station with departure board, trains sorted by time
"""
from helper import *
from bisect import bisect_left, insort
from collections import OrderedDict, namedtuple
from dataclasses import dataclass, field
from enum import IntFlag
from operator import attrgetter, itemgetter

Departure = namedtuple('Departure', ['minute', 'train', 'platform'])


class Feature(IntFlag):
    NONE = 0
    DINING = 1
    SLEEPER = 2
    BIKE = 4


@dataclass
class Train:
    name: str
    cars: int
    features: Feature = Feature.NONE
    color: tuple[float, float, float] = (0.2, 0.3, 0.7)
    _log: list[str] = field(default_factory=list, repr=False)

    def couple(self, *, front: int = 0, back: int = 0) -> 'Train':
        self.cars += front + back
        self._log.append(f'{self.name:<8}|{self.cars:03d}')
        return self

    def __format__(self, spec: str) -> str:
        return f'{self.name}/{self.cars}' if spec == 'short' else self.name


TRAINS = OrderedDict((t.name, t) for t in (
    Train('express', 4, Feature.DINING | Feature.BIKE, (0.8, 0.15, 0.15)),
    Train('night', 5, Feature.SLEEPER | Feature.DINING, (0.15, 0.15, 0.4)),
    Train('local', 2, color=(0.3, 0.6, 0.3)),
))
TRAINS['local'].couple(back=1)
TRAINS.move_to_end('local', last=False)

BOARD: list[Departure] = []
for minute, name in [(605, 'night'), (420, 'local'), (452, 'express'), (480, 'local')]:
    insort(BOARD, Departure(minute, name, len(TRAINS[name]._log) + 1))
NEXT = bisect_left(BOARD, (450,))


@register()
def car(color: tuple = (0.2, 0.3, 0.7), length: float = 1.6, windows: int = 4) -> Shape:
    body = transform_shape(primitive_call('cube', color=color, shape_kwargs={'scale': (length * 0.95, 0.7, 0.7)}), translation_matrix((0, 0.55, 0)))
    panes = [transform_shape(primitive_call('cube', color=(0.8, 0.9, 1.0), shape_kwargs={'scale': (length * 0.12, 0.2, 0.72)}), translation_matrix(((k - (windows - 1) / 2) * length / (windows + 1), 0.7, 0))) for k in range(windows)]
    wheels = [transform_shape(primitive_call('cylinder', color=(0.1, 0.1, 0.1), shape_kwargs={'radius': 0.15, 'p0': (0, 0.15, -0.36), 'p1': (0, 0.15, 0.36)}), translation_matrix((x * length * 0.3, 0, 0))) for x in (-1, 1)]
    return concat_shapes(body, *panes, *wheels)


@register()
def train(name: str = 'local') -> Shape:
    t = TRAINS[name]
    cars = []
    for k in range(t.cars):
        is_dining = bool(t.features & Feature.DINING) and k == t.cars // 2
        cars.append(transform_shape(library_call('car', color=(0.9, 0.8, 0.5) if is_dining else t.color, windows=2 if Feature.SLEEPER in t.features else 4), translation_matrix((-1.7 * k, 0, 0))))
    return concat_shapes(*cars)


@register()
def departure_board(digits: int = 4) -> Shape:
    panel = primitive_call('cube', color=(0.05, 0.05, 0.08), shape_kwargs={'scale': (3, 2, 0.1)})
    marks = []
    for row, d in enumerate(BOARD):
        h, m = divmod(d.minute, 60)
        for column, ch in enumerate(f'{h:02d}{m:02d}'):
            tall = 0.05 + 0.03 * int(ch)
            marks.append(transform_shape(primitive_call('cube', color=(1, 0.8, 0.2) if row == NEXT else (0.7, 0.7, 0.7), shape_kwargs={'scale': (0.2, tall, 0.05)}), translation_matrix((-1.2 + 0.3 * column, 0.7 - 0.4 * row, 0.08))))
    return concat_shapes(panel, *marks)


@register()
def station_hall() -> Shape:
    ordered = sorted(TRAINS.values(), key=attrgetter('cars', 'name'))
    tracks = [transform_shape(library_call('train', name=t.name), translation_matrix((0, 0, 1.6 * i))) for i, t in enumerate(ordered)]
    rails = [primitive_call('cylinder', color=(0.5, 0.5, 0.5), shape_kwargs={'radius': 0.04, 'p0': (-9, 0, 1.6 * i + s * 0.3), 'p1': (2, 0, 1.6 * i + s * 0.3)}) for i in range(len(ordered)) for s in (-1, 1)]
    label = sum(len(f'{t:short}') for t in ordered)
    sign = transform_shape(primitive_call('cube', color=(0.1, 0.3, 0.7), shape_kwargs={'scale': (0.1 * label, 0.4, 0.1)}), translation_matrix((-3, 3.6, -1)))
    board = transform_shape(library_call('departure_board'), translation_matrix((-3, 2.2, -1)))
    last = max(BOARD, key=itemgetter(0))
    clock = transform_shape(primitive_call('cylinder', color=(1, 1, 1), shape_kwargs={'radius': 0.3 + last.minute / 6000, 'p0': (0, 0, -0.05), 'p1': (0, 0, 0.05)}), translation_matrix((0, 3, -1)))
    return concat_shapes(*rails, *tracks, board, sign, clock)
