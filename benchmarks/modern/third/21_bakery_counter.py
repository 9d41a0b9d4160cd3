"""
a bakery counter whose stock is described with dictionaries and match
"""
from helper import *
import math
from dataclasses import dataclass, KW_ONLY
from typing import Any, Final, TypedDict, Literal, NotRequired


class Item(TypedDict):
    kind: Literal['loaf', 'croissant', 'cake', 'pie']
    count: int
    options: NotRequired[dict[str, Any]]


STOCK: Final[list[Item]] = [
    {'kind': 'loaf', 'count': 3},
    {'kind': 'croissant', 'count': 4, 'options': {'segments': 5}},
    {'kind': 'cake', 'count': 2, 'options': {'tiers': [0.5, 0.35, 0.2], 'color': (0.95, 0.75, 0.8)}},
    {'kind': 'pie', 'count': 3, 'options': {'slices': 8, 'missing': 2}},
    {'kind': 'cake', 'count': 1},
]


@dataclass
class Slot:
    x: float
    _: KW_ONLY
    tier: int = 0
    width: float = 0.9


def cube(size, at, color):
    return transform_shape(primitive_call('cube', color=color, shape_kwargs={'scale': size}), translation_matrix(at))


@register()
def loaf(length: float = 0.9) -> Shape:
    cuts = [cube((0.04, 0.05, 0.3), (x * length / 5, 0.34, 0), (0.95, 0.85, 0.6)) for x in (-1, 0, 1)]
    body = transform_shape(primitive_call('sphere', color=(0.7, 0.45, 0.2), shape_kwargs={'radius': 0.5}), scale_matrix((length, 0.6, 0.5), (0, 0, 0)))
    return concat_shapes(transform_shape(body, translation_matrix((0, 0.15, 0))), *cuts)


@register()
def croissant(segments: int = 5, radius: float = 0.3) -> Shape:
    parts = []
    for k in range(segments):
        a = math.pi * (k + 0.5) / segments
        fat = 0.08 + 0.08 * math.sin(a)
        parts.append(transform_shape(primitive_call('sphere', color=(0.85, 0.6, 0.3), shape_kwargs={'radius': fat}), translation_matrix((radius * math.cos(a), fat, radius * math.sin(a)))))
    return concat_shapes(*parts)


@register()
def cake(tiers: list = [0.4, 0.25], color: tuple = (0.9, 0.85, 0.75)) -> Shape:
    y, layers = 0.0, []
    for r in tiers:
        layers.append(primitive_call('cylinder', color=color, shape_kwargs={'radius': r, 'p0': (0, y, 0), 'p1': (0, y := y + 0.25, 0)}))
    cherry = transform_shape(primitive_call('sphere', color=(0.8, 0.05, 0.1), shape_kwargs={'radius': 0.07}), translation_matrix((0, y + 0.05, 0)))
    return concat_shapes(*layers, cherry)


@register()
def pie(slices: int = 8, missing: int = 0, radius: float = 0.4) -> Shape:
    wedges = [primitive_call('cylinder', color=(0.8, 0.55, 0.25), shape_kwargs={'radius': radius * 0.2, 'p0': (radius * 0.6 * math.cos(a), 0, radius * 0.6 * math.sin(a)), 'p1': (radius * 0.6 * math.cos(a), 0.15, radius * 0.6 * math.sin(a))})
              for a in (math.tau * k / slices for k in range(slices - missing))]
    return concat_shapes(*wedges)


def bake(item: Item) -> Shape:
    match item:
        case {'kind': 'cake', 'options': {'tiers': [first, *rest], 'color': color}}:
            return library_call('cake', tiers=[first, *rest], color=color)
        case {'kind': 'pie', 'options': {'slices': n, **others}}:
            return library_call('pie', slices=n, missing=others.get('missing', 0))
        case {'kind': str(kind), 'options': options}:
            return library_call(kind, **options)
        case {'kind': kind}:
            return library_call(kind)


@register()
def counter() -> Shape:
    parts, slot = [], Slot(-3.0)
    for n, item in enumerate(STOCK):
        for _ in range(item['count']):
            parts.append(transform_shape(bake(item), translation_matrix((slot.x, 1.0 + 0.8 * slot.tier, 0))))
            slot = Slot(slot.x + slot.width, tier=slot.tier)
            if slot.x > 3:
                slot = Slot(-3.0, tier=slot.tier + 1)
    shelves = [cube((7.5, 0.05, 1.0), (0.2, 0.97 + 0.8 * t, 0), (0.6, 0.6, 0.65)) for t in range(slot.tier + 1)]
    front = cube((7.5, 0.95, 1.0), (0.2, 0.47, 0), (0.45, 0.3, 0.2))
    return concat_shapes(front, *shelves, *parts)
