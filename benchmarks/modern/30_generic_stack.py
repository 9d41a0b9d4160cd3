"""a balanced zen stone stack (cairn) next to raked sand circles"""
from typing import Generic, TypeVar
from helper import *
import math
import random

S = TypeVar('S')


class Stack(Generic[S]):
    def __init__(self) -> None:
        self._items: list[S] = []

    def push(self, item: S) -> 'Stack[S]':
        self._items.append(item)
        return self

    def __iter__(self):
        return iter(self._items)

    def __len__(self) -> int:
        return len(self._items)

    def __bool__(self) -> bool:
        return bool(self._items)


@register()
def stone(radius: float, squash: float = 0.45, shade: float = 0.5) -> Shape:
    """A flat stone: a stack of discs following an ellipse profile."""
    n = 7
    h = radius * squash
    color = (shade, shade * 0.98, shade * 0.95)
    def slab(i: int) -> Shape:
        t = (i + 0.5) / n * 2 - 1
        r = radius * math.sqrt(1 - t * t)
        return primitive_call('cylinder', shape_kwargs={'radius': r, 'p0': (0, -h + 2 * h * i / n, 0), 'p1': (0, -h + 2 * h * (i + 1) / n, 0)}, color=color)
    return loop(n, slab)


@register()
def cairn(count: int = 6, seed: int = 9) -> Shape:
    rng = random.Random(seed)
    stack: Stack[Shape] = Stack()
    y, r = 0.0, 0.8
    while len(stack) < count:
        s = library_call('stone', radius=r, shade=rng.uniform(0.35, 0.7))
        s = transform_shape(s, rotation_matrix(rng.gauss(0, 0.05), (0, 0, 1), (0, 0, 0)))
        half = compute_shape_sizes(s)[1] / 2
        stack.push(transform_shape(s, translation_matrix((rng.uniform(-1, 1) * r * 0.1, y + half, rng.uniform(-1, 1) * r * 0.1))))
        y += 2 * half
        r *= rng.uniform(0.72, 0.85)
    assert stack
    return concat_shapes(*stack)


@register()
def raked_ring(radius: float, n: int = 36) -> Shape:
    pts = [(radius * math.cos(2 * math.pi * i / n), 0.02, radius * math.sin(2 * math.pi * i / n)) for i in range(n)]
    return concat_shapes(*[primitive_call('cylinder', shape_kwargs={'radius': 0.03, 'p0': p, 'p1': q}, color=(0.8, 0.76, 0.66)) for p, q in zip(pts, pts[1:] + pts[:1])])


@register()
def zen_garden() -> Shape:
    sand = transform_shape(primitive_call('cube', shape_kwargs={'scale': (6, 0.1, 6)}, color=(0.87, 0.83, 0.73)), translation_matrix((0, -0.05, 0)))
    rings = [library_call('raked_ring', radius=1.2 + 0.3 * k) for k in range(5)]
    return concat_shapes(sand, library_call('cairn'), *rings)
