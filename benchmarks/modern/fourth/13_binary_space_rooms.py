"""
a dungeon divided by binary space partitioning
"""
from __future__ import annotations
from helper import *
from dataclasses import dataclass, field
import random


@dataclass
class Rect:
    x: int
    y: int
    w: int
    h: int

    @property
    def center(self) -> tuple[float, float]:
        return self.x + self.w / 2, self.y + self.h / 2

    def inset(self, k: int) -> Rect:
        return Rect(self.x + k, self.y + k, self.w - 2 * k, self.h - 2 * k)


@dataclass
class Node:
    area: Rect
    children: list[Node] = field(default_factory=list)
    room: Rect | None = None

    def split(self, rng: random.Random, minimum: int = 6) -> None:
        horizontal = self.area.h > self.area.w if self.area.h != self.area.w else rng.random() < 0.5
        size = self.area.h if horizontal else self.area.w
        if size < 2 * minimum:
            self.room = self.area.inset(1)
            return
        cut = rng.randint(minimum, size - minimum)
        a = self.area
        if horizontal:
            parts = Rect(a.x, a.y, a.w, cut), Rect(a.x, a.y + cut, a.w, a.h - cut)
        else:
            parts = Rect(a.x, a.y, cut, a.h), Rect(a.x + cut, a.y, a.w - cut, a.h)
        for part in parts:
            child = Node(part)
            child.split(rng, minimum)
            self.children.append(child)

    def leaves(self):
        if self.room is not None:
            yield self
        for child in self.children:
            yield from child.leaves()

    def corridors(self):
        if len(self.children) == 2:
            yield self.children[0].area.center, self.children[1].area.center
            for child in self.children:
                yield from child.corridors()


@register()
def floor_tile(w: float, d: float, color=(0.5, 0.45, 0.4)) -> Shape:
    return primitive_call('cube', color=color, shape_kwargs={'scale': (w, 0.1, d)})


@register()
def room(w: int, d: int, height: float = 1.5) -> Shape:
    floor = library_call('floor_tile', w=w, d=d)
    walls = []
    for sx, sz in ((1, 0), (-1, 0), (0, 1), (0, -1)):
        size = (0.2, height, d) if sx else (w, height, 0.2)
        walls.append(transform_shape(primitive_call('cube', color=(0.35, 0.35, 0.38), shape_kwargs={'scale': size}), translation_matrix((sx * w / 2, height / 2, sz * d / 2))))
    return concat_shapes(floor, *walls)


@register()
def dungeon(width: int = 30, depth: int = 24, seed: int = 9) -> Shape:
    root = Node(Rect(0, 0, width, depth))
    root.split(random.Random(seed))
    shapes = []
    for leaf in root.leaves():
        cx, cy = leaf.room.center
        shapes.append(transform_shape(library_call('room', w=leaf.room.w, d=leaf.room.h), translation_matrix((cx, 0, cy))))
    for (x0, y0), (x1, y1) in root.corridors():
        w, d = abs(x1 - x0) or 1, abs(y1 - y0) or 1
        shapes.append(transform_shape(library_call('floor_tile', w=w, d=d, color=(0.6, 0.5, 0.3)), translation_matrix(((x0 + x1) / 2, -0.1, (y0 + y1) / 2))))
    return concat_shapes(*shapes)
