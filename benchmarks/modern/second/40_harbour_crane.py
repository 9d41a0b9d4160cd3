"""
a container port: stacks of containers sorted by destination and a gantry crane lifting one
"""
from helper import *
import logging
import math
from collections import deque, OrderedDict
from dataclasses import dataclass, field
from functools import partialmethod
from random import Random

logging.basicConfig(level=logging.WARNING)
logger = logging.getLogger('port')

PORTS = OrderedDict(OSL=(0.75, 0.2, 0.18), SIN=(0.15, 0.4, 0.7), LAX=(0.9, 0.65, 0.15), RTM=(0.2, 0.55, 0.35))
SIZE = (2.4, 1.0, 1.0)


class YardFull(Exception):
    def __init__(self, code: str, limit: int):
        super().__init__(f'no room for {code}: every stack holds {limit}')


@dataclass(slots=True)
class Container:
    code: str
    number: int

    @property
    def color(self):
        base = PORTS[self.code]
        return tuple(min(1.0, c + 0.06 * (self.number % 3 - 1)) for c in base)

    def __str__(self):
        return f'{self.code}{self.number:04d}'


@dataclass
class Yard:
    lanes: int = 4
    limit: int = 4
    stacks: dict[tuple[str, int], deque[Container]] = field(default_factory=dict)

    def put(self, c: Container, *, lanes: range | None = None) -> None:
        for lane in lanes or range(self.lanes):
            stack = self.stacks.setdefault((c.code, lane), deque(maxlen=self.limit))
            if len(stack) < self.limit:
                stack.append(c)
                return
        raise YardFull(str(c), self.limit)

    put_front = partialmethod(put, lanes=range(2))

    def lift(self) -> tuple[Container, tuple[str, int]]:
        key = max(self.stacks, key=lambda k: (len(self.stacks[k]), k))
        return self.stacks[key].pop(), key


def load(n: int, seed: int) -> tuple[Yard, list[Container]]:
    rng, yard, left = Random(seed), Yard(), []
    codes = rng.choices(list(PORTS), weights=[5, 3, 2, 4], k=n)
    for i, code in enumerate(codes):
        box = Container(code, rng.randrange(10_000))
        try:
            (yard.put_front if i % 2 else yard.put)(box)
        except YardFull as full:
            logger.info('%s', full)
            left.append(box)
    return yard, left


@register()
def container(color: tuple = (0.75, 0.2, 0.18), ribs: int = 7) -> Shape:
    l, h, w = SIZE
    box = primitive_call('cube', {'scale': SIZE}, color=color)
    dark = tuple(0.8 * c for c in color)
    rib = primitive_call('cube', {'scale': (0.08, h * 0.9, w * 1.03)}, color=dark)
    return concat_shapes(box, loop(ribs, lambda i: transform_shape(rib, translation_matrix((l * ((i + 0.5) / ribs - 0.5), 0, 0)))))


@register()
def gantry(span: float = 6.0, height: float = 6.5, trolley: float = 0.0, drop: float = 2.0) -> Shape:
    yellow, steel = (0.95, 0.75, 0.1), (0.3, 0.3, 0.33)
    bar = lambda a, b, r=0.12, c=yellow: primitive_call('cylinder', {'radius': r, 'p0': a, 'p1': b}, color=c)
    legs = [bar((x, 0, z), (x * 0.8, height, z)) for x in (-1.2, 1.2) for z in (-span / 2, span / 2)]
    girders = [bar((x, height, -span / 2 - 1), (x, height, span / 2 + 2), 0.15) for x in (-0.6, 0.6)]
    cab = transform_shape(primitive_call('cube', {'scale': (1.4, 0.5, 0.8)}, color=steel), translation_matrix((0, height + 0.1, trolley)))
    ropes = [bar((x, height, trolley), (x * 1.6, height - drop, trolley), 0.02, steel) for x in (-0.6, 0.6)]
    spreader = transform_shape(primitive_call('cube', {'scale': (2.4, 0.1, 0.9)}, color=yellow), translation_matrix((0, height - drop, trolley)))
    return concat_shapes(*legs, *girders, cab, *ropes, spreader)


@register()
def container_port(boxes: int = 40, seed: int = 17) -> Shape:
    yard, left = load(boxes, seed)
    hanging, (code, lane) = yard.lift()
    column = {c: i * (SIZE[0] + 0.4) for i, c in enumerate(PORTS)}
    shapes = [transform_shape(library_call('container', color=c.color), translation_matrix((column[port], SIZE[1] * (k + 0.5), ln * 1.2)))
              for (port, ln), stack in sorted(yard.stacks.items()) for k, c in enumerate(stack)]
    drop, height = 1.0, 6.5
    crane = library_call('gantry', trolley=lane * 1.2 - 1.8, drop=drop, height=height)
    crane += transform_shape(library_call('container', color=hanging.color), translation_matrix((0, height - drop - 0.55, lane * 1.2 - 1.8)))
    shapes.append(transform_shape(crane, translation_matrix((column[code], 0, 1.8))))
    queue = [transform_shape(library_call('container', color=c.color), translation_matrix((i * 2.8, 0.5, 7.0))) for i, c in enumerate(left)]
    quay = transform_shape(primitive_call('cube', {'scale': (16, 0.3, 12)}, color=(0.55, 0.56, 0.57)), translation_matrix((4.2, -0.15, 2.5)))
    return concat_shapes(quay, *shapes, *queue)
