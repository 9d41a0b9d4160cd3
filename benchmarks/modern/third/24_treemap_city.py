"""
a city whose blocks are a squarified treemap of a folder tree
"""
from __future__ import annotations
from helper import *
import json
import random
from dataclasses import dataclass, field
from functools import cached_property
from typing import Iterator

DATA = '''
{"name": "root", "children": [
  {"name": "src", "children": [{"name": "core.py", "size": 40}, {"name": "cli.py", "size": 18}, {"name": "ui", "children": [{"name": "a.js", "size": 25}, {"name": "b.js", "size": 12}]}]},
  {"name": "docs", "children": [{"name": "guide.md", "size": 22}, {"name": "api.md", "size": 9}]},
  {"name": "README", "size": 6}
]}
'''


@dataclass
class Rect:
    x: float
    y: float
    w: float
    h: float

    def split(self, shares: list[float]) -> Iterator[Rect]:
        total, offset = sum(shares), 0.0
        for s in shares:
            f = s / total
            if self.w >= self.h:
                yield Rect(self.x + offset * self.w, self.y, self.w * f, self.h)
            else:
                yield Rect(self.x, self.y + offset * self.h, self.w, self.h * f)
            offset += f

    def shrink(self, by: float) -> Rect:
        return Rect(self.x + by, self.y + by, max(self.w - 2 * by, 0.05), max(self.h - 2 * by, 0.05))

    @property
    def center(self) -> tuple[float, float]:
        return self.x + self.w / 2, self.y + self.h / 2


@dataclass
class Node:
    name: str
    own: int = 0
    children: list[Node] = field(default_factory=list)

    @classmethod
    def parse(cls, raw: dict) -> Node:
        return cls(raw['name'], raw.get('size', 0), [cls.parse(c) for c in raw.get('children', [])])

    @cached_property
    def size(self) -> int:
        return self.own + sum(c.size for c in self.children)

    def walk(self, rect: Rect, depth: int = 0) -> Iterator[tuple[Node, Rect, int]]:
        yield self, rect, depth
        ordered = sorted(self.children, key=lambda c: c.size, reverse=True)
        for child, part in zip(ordered, rect.shrink(0.1).split([c.size for c in ordered])):
            yield from child.walk(part, depth + 1)


ROOT = Node.parse(json.loads(DATA))


@register()
def building(width: float = 1.0, depth: float = 1.0, height: float = 2.0, tint: float = 0.5) -> Shape:
    tower = transform_shape(primitive_call('cube', color=(0.4 + 0.4 * tint, 0.5, 0.9 - 0.4 * tint), shape_kwargs={'scale': (width, height, depth)}), translation_matrix((0, height / 2, 0)))
    floors = max(1, int(height / 0.5))
    bands = [transform_shape(primitive_call('cube', color=(0.95, 0.95, 0.7), shape_kwargs={'scale': (width * 1.01, 0.06, depth * 1.01)}), translation_matrix((0, (k + 0.5) * height / floors, 0))) for k in range(floors)]
    return concat_shapes(tower, *bands)


@register()
def plinth(width: float = 4.0, depth: float = 4.0, level: int = 0) -> Shape:
    grey = 0.3 + 0.15 * level
    return transform_shape(primitive_call('cube', color=(grey, grey, grey), shape_kwargs={'scale': (width, 0.1, depth)}), translation_matrix((0, 0.05, 0)))


@register()
def treemap_city(side: float = 10.0) -> Shape:
    parts = []
    for node, rect, depth in ROOT.walk(Rect(-side / 2, -side / 2, side, side)):
        x, z = rect.center
        if node.children:
            shape = library_call('plinth', width=rect.w, depth=rect.h, level=depth)
        else:
            inner = rect.shrink(0.15)
            shape = library_call('building', width=inner.w, depth=inner.h, height=0.5 + node.size / 10, tint=min(1.0, len(node.name) / 10))
        parts.append(transform_shape(shape, translation_matrix((x, 0.1 * depth, z))))
    return concat_shapes(*parts)
