"""a curved line of falling dominoes caught halfway through the chain reaction"""
from helper import *
import heapq
import math
from dataclasses import dataclass, field


@dataclass
class Domino:
    x: float
    z: float
    heading: float
    fall: float = 0.0


@dataclass(order=True)
class Event:
    time: float
    index: int = field(compare=False)


def s_curve(n: int, spacing: float = 0.35):
    x = z = 0.0
    heading = 0.0
    for i in range(n):
        yield Domino(x, z, heading)
        heading += 0.12 * math.sin(i * 2 * math.pi / n)
        x += spacing * math.cos(heading)
        z += spacing * math.sin(heading)


def simulate(dominoes: list[Domino], now: float, delay: float = 0.06, duration: float = 0.25) -> None:
    queue = [Event(0.0, 0)]
    while queue:
        ev = heapq.heappop(queue)
        if ev.time > now:
            break
        progress = min((now - ev.time) / duration, 1.0)
        dominoes[ev.index].fall = math.radians(68) * progress ** 2
        if ev.index + 1 < len(dominoes):
            heapq.heappush(queue, Event(ev.time + delay, ev.index + 1))


@register()
def domino(pips: tuple = (3, 4), height: float = 0.6, fall: float = 0.0) -> Shape:
    body = primitive_call('cube', shape_kwargs={'scale': (0.08, height, 0.3)}, color=(0.93, 0.91, 0.85))
    line = primitive_call('cube', shape_kwargs={'scale': (0.085, 0.01, 0.26)}, color=(0.1, 0.1, 0.1))
    dots = []
    for half, count in zip((-1, 1), pips):
        for k in range(count):
            z = 0.08 * (k % 2 * 2 - 1) if count > 1 else 0.0
            y = half * height / 4 + 0.08 * (k // 2 - (count - 1) // 2 / 2)
            dots.append(transform_shape(primitive_call('sphere', shape_kwargs={'radius': 0.022}, color=(0.1, 0.1, 0.1)), translation_matrix((0.04, y, z))))
    upright = transform_shape(concat_shapes(body, line, *dots), translation_matrix((0, height / 2, 0)))
    return transform_shape(upright, rotation_matrix(-fall, (0, 0, 1), (0.04, 0, 0)))


@register()
def chain(n: int = 24, now: float = 0.9) -> Shape:
    line = list(s_curve(n))
    simulate(line, now)
    shapes = []
    for i, d in enumerate(line):
        s = library_call('domino', pips=(i % 7, (i * 3) % 7), fall=d.fall)
        s = transform_shape(s, rotation_matrix(-d.heading, (0, 1, 0), (0, 0, 0)))
        shapes.append(transform_shape(s, translation_matrix((d.x, 0, d.z))))
    return concat_shapes(*shapes)


@register()
def domino_run() -> Shape:
    c = library_call('chain')
    mid, size = compute_shape_center(c), compute_shape_sizes(c)
    table = primitive_call('cube', shape_kwargs={'scale': (size[0] + 1.5, 0.2, size[2] + 1.5)}, color=(0.4, 0.25, 0.15))
    return concat_shapes(c, transform_shape(table, translation_matrix((mid[0], -0.1, mid[2]))))
