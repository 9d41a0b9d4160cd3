"""
a container ship loaded by a greedy stacking plan
"""
from helper import *
import heapq
import random
from collections import Counter, defaultdict
from dataclasses import dataclass, field
from enum import Enum, auto


class Cargo(Enum):
    DRY = auto()
    REEFER = auto()
    TANK = auto()


PAINT = {Cargo.DRY: (0.75, 0.25, 0.15), Cargo.REEFER: (0.9, 0.9, 0.92), Cargo.TANK: (0.3, 0.5, 0.3)}


@dataclass(order=True)
class Stack:
    weight: float
    index: int
    boxes: list['Container'] = field(default_factory=list, compare=False)


@dataclass(frozen=True)
class Container:
    kind: Cargo
    weight: float
    serial: int


def manifest(n: int, seed: int = 3) -> list[Container]:
    rng = random.Random(seed)
    kinds = list(Cargo)
    return [Container(rng.choice(kinds), round(rng.uniform(5, 25), 1), k) for k in range(n)]


def plan(boxes: list[Container], bays: int, limit: int = 5) -> list[Stack]:
    heap = [Stack(0.0, i) for i in range(bays)]
    full: list[Stack] = []
    heapq.heapify(heap)
    for box in sorted(boxes, key=lambda b: (-b.weight, b.serial)):
        stack = heapq.heappop(heap)
        stack.boxes.append(box)
        stack.weight += box.weight
        if len(stack.boxes) < limit:
            heapq.heappush(heap, stack)
        else:
            full.append(stack)
    return sorted([*heap, *full], key=lambda s: s.index)


LOADED = plan(manifest(36), bays=9)


@register()
def container(color: tuple = (0.75, 0.25, 0.15), length: float = 2.4, side: float = 0.9) -> Shape:
    shell = primitive_call('cube', color=color, shape_kwargs={'scale': (length, side, side)})
    ribs = [transform_shape(primitive_call('cube', color=tuple(c * 0.8 for c in color), shape_kwargs={'scale': (0.05, side, side * 1.02)}), translation_matrix((x * length / 6, 0, 0))) for x in range(-2, 3)]
    return concat_shapes(shell, *ribs)


@register()
def hull(length: float = 14.0, beam: float = 4.0, slices: int = 8) -> Shape:
    parts = []
    for i in range(slices):
        t = i / (slices - 1)
        width = beam * (1 - 0.7 * t ** 3)
        parts.append(transform_shape(primitive_call('cube', color=(0.12, 0.15, 0.3), shape_kwargs={'scale': (length / slices, 1.6, width)}), translation_matrix((length * (t - 0.5) * (slices - 1) / slices, -0.8, 0))))
    return concat_shapes(*parts)


@register()
def bridge(floors: int = 4) -> Shape:
    decks = [transform_shape(primitive_call('cube', color=(0.95, 0.95, 0.93), shape_kwargs={'scale': (1.6 - 0.2 * f, 0.7, 3.2 - 0.3 * f)}), translation_matrix((0, 0.35 + 0.7 * f, 0))) for f in range(floors)]
    funnel = primitive_call('cylinder', color=(0.8, 0.3, 0.1), shape_kwargs={'radius': 0.3, 'p0': (-1.2, 0, 0), 'p1': (-1.2, 0.7 * floors + 0.8, 0)})
    return concat_shapes(*decks, funnel)


@register()
def ship() -> Shape:
    load = []
    for stack in LOADED:
        column, row = divmod(stack.index, 3)
        for level, box in enumerate(stack.boxes):
            shape = library_call('container', color=PAINT[box.kind])
            load.append(transform_shape(shape, translation_matrix((-1.5 + 2.6 * column, 0.45 + 0.92 * level, (row - 1) * 1.0))))
    tally = Counter(b.kind for s in LOADED for b in s.boxes)
    by_weight = defaultdict(float)
    for s in LOADED:
        for b in s.boxes:
            by_weight[b.kind] += b.weight
    flags = [transform_shape(primitive_call('cube', color=PAINT[kind], shape_kwargs={'scale': (0.4, 0.1 * number, 0.05)}), translation_matrix((-6.5 + 0.5 * i, 4 + by_weight[kind] / 500, 0))) for i, (kind, number) in enumerate(sorted(tally.items(), key=lambda kv: kv[0].value))]
    house = transform_shape(library_call('bridge'), translation_matrix((-5, 0, 0)))
    return concat_shapes(library_call('hull'), house, *load, *flags)
