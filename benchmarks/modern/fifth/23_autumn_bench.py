"""a park bench under an autumn maple with falling and drifting leaves"""
from helper import *
from collections.abc import Generator, Iterable
from contextlib import contextmanager
from enum import Enum, auto
import itertools as it
import math
import random


class LeafState(Enum):
    ATTACHED = auto()
    FALLING = auto()
    LANDED = auto()

    @property
    def palette(self) -> list[tuple[float, float, float]]:
        match self:
            case LeafState.ATTACHED:
                return [(0.85, 0.25, 0.1), (0.95, 0.5, 0.1), (0.9, 0.7, 0.15)]
            case LeafState.FALLING:
                return [(0.95, 0.55, 0.15), (0.98, 0.75, 0.2)]
            case LeafState.LANDED:
                return [(0.6, 0.35, 0.15), (0.7, 0.45, 0.15), (0.75, 0.3, 0.12)]


@contextmanager
def seeded(value: int):
    """A local random stream; the global state comes back afterwards."""
    state = random.getstate()
    random.seed(value)
    try:
        yield random
    finally:
        random.setstate(state)


def tumble(x: float, y: float, z: float, wind: float = 0.3) -> Generator[tuple[float, float, float, float], None, None]:
    """Endless path of a falling leaf: it sinks, rocks from side to side and turns."""
    for tick in it.count():
        yield x, y, z, tick * 0.55
        y -= 0.16
        x += wind * math.sin(tick * 0.7) + 0.04
        z += 0.5 * wind * math.cos(tick * 0.9)


def leaf(color, size: float = 0.09) -> Shape:
    lobes = (primitive_call('cube', shape_kwargs={'scale': (size, 0.008, size * 0.35)}, color=color) for _ in range(3))
    return concat_shapes(*(transform_shape(lobe, rotation_matrix(k * math.pi / 3, (0, 1, 0), (0, 0, 0))) for k, lobe in enumerate(lobes)))


def branch(start, direction, length: float, depth: int, tips: list) -> Iterable[Shape]:
    """Yields the wood of a recursive tree; the ends of twigs land in tips."""
    end = tuple(s + length * d for s, d in zip(start, direction))
    yield primitive_call('cylinder', shape_kwargs={'radius': 0.025 * 1.75 ** depth, 'p0': start, 'p1': end}, color=(0.32, 0.22, 0.16))
    if depth == 0:
        tips.append(end)
        return
    for k in range(3):
        azimuth = 2 * math.pi * k / 3 + random.uniform(-0.5, 0.5)
        spread = random.uniform(0.45, 0.8)
        new = (direction[0] + spread * math.cos(azimuth), direction[1] + 0.15, direction[2] + spread * math.sin(azimuth))
        norm = math.hypot(*new)
        yield from branch(end, tuple(c / norm for c in new), length * random.uniform(0.65, 0.8), depth - 1, tips)


@register()
def maple(height: float = 1.5, depth: int = 3, leaves_per_tip: int = 5, seed: int = 3) -> Shape:
    tips: list[tuple[float, float, float]] = []
    with seeded(seed) as rnd:
        wood = list(branch((0, 0, 0), (0, 1, 0), height, depth, tips))
        crown = []
        for tip, _ in it.product(tips, range(leaves_per_tip)):
            at = tuple(c + rnd.gauss(0, 0.2) for c in tip)
            crown.append(transform_shape(leaf(rnd.choice(LeafState.ATTACHED.palette), size=0.16), translation_matrix(at) @ rotation_matrix(rnd.uniform(0, 3), (1, 0.3, 0.5), (0, 0, 0))))
    return concat_shapes(*wood, *crown)


@register()
def falling_leaves(count: int = 25, frames: int = 26, seed: int = 8) -> Shape:
    shapes = []
    with seeded(seed) as rnd:
        for i in range(count):
            path = tumble(rnd.uniform(-1.5, 1.5), rnd.uniform(2.2, 4.0), rnd.uniform(-1.5, 1.5), wind=rnd.uniform(0.1, 0.4))
            x, y, z, spin = next(it.islice(path, rnd.randrange(frames), None))
            state = LeafState.LANDED if y <= 0.02 else LeafState.FALLING
            y = max(y, 0.02)
            tilt = 0.0 if state is LeafState.LANDED else spin
            shapes.append(transform_shape(leaf(rnd.choice(state.palette)), translation_matrix((x, y, z)) @ rotation_matrix(tilt, (0.6, 0.2, 1), (0, 0, 0))))
    return concat_shapes(*shapes)


@register()
def bench(length: float = 1.8, slats: int = 5, seat: float = 0.45) -> Shape:
    wood, iron = (0.5, 0.32, 0.18), (0.13, 0.14, 0.13)
    board = primitive_call('cube', shape_kwargs={'scale': (length, 0.04, 0.08)}, color=wood)
    bottom = loop(slats, lambda i: transform_shape(board, translation_matrix((0, seat, 0.1 * i))))
    back = loop(slats - 1, lambda i: transform_shape(board, translation_matrix((0, seat + 0.14 + 0.1 * i, -0.1 - 0.03 * i)) @ rotation_matrix(1.3, (1, 0, 0), (0, 0, 0))))
    sides = []
    for x in (-length * 0.42, length * 0.42):
        rails = [((x, 0, 0.4), (x, seat, 0.4)), ((x, 0, -0.05), (x, seat, 0)), ((x, seat, -0.06), (x, seat + 0.5, -0.24)), ((x, seat + 0.22, -0.1), (x, seat + 0.22, 0.4)), ((x, seat, 0.4), (x, seat + 0.22, 0.4))]
        sides += [primitive_call('cylinder', shape_kwargs={'radius': 0.025, 'p0': a, 'p1': b}, color=iron) for a, b in rails]
    return concat_shapes(bottom, back, *sides)


@register()
def park_scene() -> Shape:
    lawn = primitive_call('cylinder', shape_kwargs={'radius': 4.5, 'p0': (0, -0.15, 0), 'p1': (0, 0, 0)}, color=(0.45, 0.5, 0.22))
    return concat_shapes(lawn, transform_shape(library_call('maple'), translation_matrix((-0.6, 0, -1.2))), library_call('bench'), library_call('falling_leaves'))
