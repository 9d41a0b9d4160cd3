"""a green circuit board with chips, resistors and LEDs, its copper traces routed automatically"""
from helper import *
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from typing import Literal, Optional
import heapq
import math

COLS, ROWS, PITCH = 30, 20, 0.2
Point = tuple[int, int]

SCHEMATIC = '''
chip     U1  at 6,5    pins 8
chip     U2  at 18,9   pins 14
resistor R1  at 3,14   ohms 4700
resistor R2  at 14,2   ohms 220
resistor R3  at 25,4   ohms 1000000
led      D1  at 26,15  color red
cap      C1  at 10,14
net U1.0 U2.2
net U1.5 R1.0
net R1.1 C1.0
net C1.1 U2.8
net R2.0 U1.4
net R2.1 R3.0
net R3.1 D1.0
net U2.0 U1.7 D1.1
'''

BANDS = ['#000000', '#7b3f00', '#d00000', '#ff7f00', '#ffd800', '#00a000', '#0040d0', '#8000c0', '#808080', '#ffffff']


def rgb(code: str) -> tuple[float, float, float]:
    value = int(code.removeprefix('#'), 16)
    return (value >> 16) / 255, (value >> 8 & 0xFF) / 255, (value & 0xFF) / 255


@dataclass
class Component:
    kind: Literal['chip', 'resistor', 'led', 'cap']
    name: str
    at: Point
    options: dict[str, str] = field(default_factory=dict)

    def pins(self) -> list[Point]:
        x, y = self.at
        match self:
            case Component(kind='chip', options={'pins': n}):
                half = int(n) // 2
                return [(x + i, y) for i in range(half)] + [(x + half - 1 - i, y + 3) for i in range(half)]
            case Component(kind='resistor'):
                return [(x, y), (x + 3, y)]
            case _:
                return [(x, y), (x + 1, y)]

    def body(self) -> set[Point]:
        (x0, y0), (x1, y1) = (tuple(f(axis) for axis in zip(*self.pins())) for f in (min, max))
        return {(x, y) for x in range(x0, x1 + 1) for y in range(y0, y1 + 1)}


def parse(text: str) -> tuple[dict[str, Component], list[list[tuple[str, int]]]]:
    parts, nets = {}, []
    for line in filter(None, map(str.strip, text.splitlines())):
        match line.split():
            case ['net', *ends]:
                nets.append([(name, int(pin)) for name, pin in (e.split('.') for e in ends)])
            case [kind, name, 'at', xy, *rest]:
                x, y = (int(v) for v in xy.split(','))
                parts[name] = Component(kind, name, (x, y), dict(zip(rest[::2], rest[1::2])))
    return parts, nets


class Router:
    def __init__(self, blocked: Iterable[Point]):
        self.blocked = set(blocked)

    def neighbours(self, p: Point) -> Iterator[tuple[Point, float]]:
        for dx, dy in ((1, 0), (0, 1), (-1, 0), (0, -1), (1, 1), (-1, 1), (1, -1), (-1, -1)):
            q = p[0] + dx, p[1] + dy
            if 0 <= q[0] < COLS and 0 <= q[1] < ROWS:
                yield q, math.hypot(dx, dy)

    def route(self, sources: set[Point], goal: Point, net: int = 0) -> list[Point]:
        """A* from any of the sources to the goal."""
        best: dict[Point, float] = {s: 0.0 for s in sources}
        came: dict[Point, Optional[Point]] = {s: None for s in sources}
        heap = [(math.dist(s, goal), s) for s in sorted(sources)]
        heapq.heapify(heap)
        while heap:
            _, p = heapq.heappop(heap)
            if p == goal:
                path = [p]
                while (p := came[p]) is not None:
                    path.append(p)
                return path[::-1]
            for q, step in self.neighbours(p):
                if q in self.blocked and q != goal:
                    continue
                if (cost := best[p] + step) < best.get(q, math.inf) - 1e-12:
                    best[q], came[q] = cost, p
                    heapq.heappush(heap, (cost + math.dist(q, goal), q))
        raise LookupError(f'no way to {goal}', net)


PARTS, NETS = parse(SCHEMATIC)


def world(p: Point, y: float = 0.0) -> tuple[float, float, float]:
    return (p[0] - (COLS - 1) / 2) * PITCH, y, (p[1] - (ROWS - 1) / 2) * PITCH


def wire(a, b, r, color=(0.8, 0.8, 0.82)):
    return primitive_call('cylinder', shape_kwargs={'radius': r, 'p0': a, 'p1': b}, color=color)


@register()
def component(name: str = 'U1', lift: float = 0.12) -> Shape:
    c = PARTS[name]
    legs = [wire(world(p, -0.05), world(p, lift), 0.025) for p in c.pins()]
    center = tuple(sum(v) / len(c.pins()) for v in zip(*(world(p, lift) for p in c.pins())))
    x, y, z = center
    if c.kind == 'chip':
        w = len(c.pins()) / 2 * PITCH
        body = concat_shapes(transform_shape(primitive_call('cube', shape_kwargs={'scale': (w, 0.14, PITCH * 2.6)}, color=(0.1, 0.1, 0.11)), translation_matrix((x, y + 0.05, z))), wire((x - w / 2 + 0.08, y + 0.1, z + 0.12), (x - w / 2 + 0.08, y + 0.125, z + 0.12), 0.04, (0.5, 0.5, 0.5)))
    elif c.kind == 'resistor':
        ohms = c.options['ohms']
        digits = [int(ohms[0]), int(ohms[1]), len(ohms) - 2]
        stripes = [wire((x - 0.15 + 0.1 * i, y, z), (x - 0.11 + 0.1 * i, y, z), 0.085, rgb(BANDS[d])) for i, d in enumerate(digits)]
        body = concat_shapes(wire((x - 0.22, y, z), (x + 0.22, y, z), 0.075, (0.85, 0.75, 0.55)), wire((x - 0.3, y, z), (x + 0.3, y, z), 0.02), *stripes, wire((x + 0.18, y, z), (x + 0.2, y, z), 0.085, (0.85, 0.7, 0.3)))
    elif c.kind == 'led':
        glow = {'red': (1, 0.15, 0.1)}.get(c.options.get('color', ''), (1, 1, 1))
        body = concat_shapes(wire((x, y, z), (x, y + 0.18, z), 0.11, glow), transform_shape(primitive_call('sphere', shape_kwargs={'radius': 0.11}, color=glow), translation_matrix((x, y + 0.18, z))))
    else:
        body = concat_shapes(wire((x, y, z), (x, y + 0.4, z), 0.14, (0.1, 0.15, 0.4)), wire((x, y + 0.4, z), (x, y + 0.405, z), 0.12, (0.75, 0.75, 0.78)))
    return concat_shapes(*legs, body)


@register()
def traces(width: float = 0.035) -> Shape:
    pads = {p for c in PARTS.values() for p in c.pins()}
    router = Router(pads | set().union(*(c.body() for c in PARTS.values() if c.kind != 'chip')))
    out, failed = [], []
    for index, net in enumerate(NETS):
        first, *others = (PARTS[name].pins()[pin] for name, pin in net)
        tree = {first}
        for goal in others:
            try:
                path = router.route(tree, goal, index)
            except LookupError as error:
                failed.append(error.args[1])
                out.append(wire(world(first, 0.3), world(goal, 0.3), 0.015, (0.9, 0.2, 0.8)))  # a jumper cable
            else:
                tree |= {*path}
                out += [wire(world(a, 0.01), world(b, 0.01), width, (0.85, 0.55, 0.25)) for a, b in zip(path, path[1:])]
            finally:
                router.blocked |= tree
    beacons = [transform_shape(primitive_call('sphere', shape_kwargs={'radius': 0.06}, color=(1, 0, 1)), translation_matrix(world((n, 0), 0.1))) for n in failed]
    return concat_shapes(*out, *beacons)


@register()
def circuit_board(margin: float = 0.4) -> Shape:
    w, d = COLS * PITCH + margin, ROWS * PITCH + margin
    board = transform_shape(primitive_call('cube', shape_kwargs={'scale': (w, 0.06, d)}, color=(0.05, 0.35, 0.18)), translation_matrix((0, -0.03, 0)))
    holes = [wire((sx * (w / 2 - 0.2), -0.07, sz * (d / 2 - 0.2)), (sx * (w / 2 - 0.2), 0.01, sz * (d / 2 - 0.2)), 0.1, (0.85, 0.7, 0.35)) for sx in (-1, 1) for sz in (-1, 1)]
    rings = [wire(world(p, 0.0), world(p, 0.02), 0.06, (0.85, 0.7, 0.35)) for c in PARTS.values() for p in c.pins()]
    return concat_shapes(board, *holes, *rings, library_call('traces'), *[library_call('component', name=n) for n in PARTS])
