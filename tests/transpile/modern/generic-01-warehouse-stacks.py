from __future__ import annotations
from typing import Generic, TypeVar, Callable, Iterable, TypeAlias
from dataclasses import dataclass
from helper import *

"""
a warehouse with pallets handled by generic stacks and queues
"""

T = TypeVar("T")
K = TypeVar("K", bound=str)
Color: TypeAlias = tuple[float, float, float]
Painter = Callable[[T], Shape]


class Stack(Generic[T]):
    def __init__(self, items: Iterable[T] = ()) -> None:
        self._items: list[T] = list(items)

    def push(self, item: T) -> None:
        self._items.append(item)

    def pop(self) -> T:
        return self._items.pop()

    def peek(self) -> T | None:
        return self._items[-1] if self._items else None

    def __len__(self) -> int:
        return len(self._items)

    def render(self, painter: Painter[T], pitch: float) -> Shape:
        return concat_shapes(*[transform_shape(painter(item), translation_matrix((0, pitch * i, 0))) for i, item in enumerate(self._items)])


@dataclass
class Pair(Generic[T, K]):
    value: T
    key: K


class Registry(dict[str, Stack[T]]):
    def __missing__(self, key: str) -> Stack[T]:
        self[key] = Stack()
        return self[key]


@register()
def pallet(color: Color = (0.7, 0.55, 0.35), load: float = 0.0) -> Shape:
    planks = loop(4, lambda i: transform_shape(primitive_call('cube', color=color, shape_kwargs={'scale': (0.2, 0.05, 1)}), translation_matrix((0.27 * (i - 1.5), 0.05, 0))))
    if load <= 0:
        return planks
    cargo = transform_shape(primitive_call('cube', color=(0.3, 0.5, 0.6), shape_kwargs={'scale': (0.9, load, 0.9)}), translation_matrix((0, 0.08 + load / 2, 0)))
    return concat_shapes(planks, cargo)


@register()
def warehouse() -> Shape:
    bays: Registry[Pair[float, str]] = Registry()
    arrivals = [("A", 0.4), ("B", 0.0), ("A", 0.3), ("C", 0.5), ("B", 0.2), ("A", 0.0), ("C", 0.5)]
    for key, load in arrivals:
        bays[key].push(Pair(load, key))
    moved = bays["A"].pop()
    bays["D"].push(moved)
    assert bays["A"].peek() is not None and Stack[int]().peek() is None
    painter: Painter[Pair] = lambda p: library_call('pallet', load=p.value, color=(0.7, 0.5 + 0.05 * (ord(p.key) - 65), 0.3))
    shapes = [transform_shape(bays[k].render(painter, 0.7), translation_matrix((1.5 * i, 0, 0))) for i, k in enumerate(sorted(bays))]
    rails = [primitive_call('cylinder', color=(0.9, 0.5, 0.1), shape_kwargs={'radius': 0.05, 'p0': (1.5 * i - 0.75, 0, -0.6), 'p1': (1.5 * i - 0.75, 0.8 * max(map(len, bays.values())), -0.6)}) for i in range(len(bays) + 1)]
    return concat_shapes(*shapes, *rails)
