"""a hexagonal strategy board game with lakes, forests, fields, mountains and a few castles"""
from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, total_ordering
from string import ascii_uppercase
from typing import Iterator
import math

from helper import *


@total_ordering
@dataclass(frozen=True)
class Hex:
    """Axial coordinates."""
    q: int
    r: int

    def __add__(self, other: Hex) -> Hex:
        return Hex(self.q + other.q, self.r + other.r)

    def __mul__(self, k: int) -> Hex:
        return Hex(self.q * k, self.r * k)

    def __abs__(self) -> int:
        return (abs(self.q) + abs(self.r) + abs(self.q + self.r)) // 2

    def __lt__(self, other: Hex) -> bool:
        return (self.r, self.q) < (other.r, other.q)

    def center(self, size: float = 1.0) -> tuple[float, float]:
        return (size * math.sqrt(3) * (self.q + self.r / 2), size * 1.5 * self.r)


DIRECTIONS = tuple(Hex(*d) for d in ((1, 0), (0, 1), (-1, 1), (-1, 0), (0, -1), (1, -1)))


def ring(radius: int) -> Iterator[Hex]:
    if radius == 0:
        yield Hex(0, 0)
        return
    at = DIRECTIONS[4] * radius
    for direction in DIRECTIONS:
        for _ in range(radius):
            yield at
            at = at + direction


class GameMap:
    LAND = {'field': (0.85, 0.78, 0.35), 'forest': (0.2, 0.5, 0.22), 'mountain': (0.55, 0.52, 0.5), 'lake': (0.3, 0.55, 0.85)}

    def __init__(self, radius: int):
        self.radius = radius

    @cached_property
    def tiles(self) -> dict[Hex, str]:
        kinds = list(self.LAND)
        return {h: kinds[(h.q * 7 + h.r * 3 + h.q * h.r) % len(kinds)] for k in range(self.radius + 1) for h in ring(k)}

    def __getitem__(self, h: Hex) -> str:
        return self.tiles.get(h, 'sea')

    def __iter__(self) -> Iterator[Hex]:
        return iter(sorted(self.tiles))

    def borders_water(self, h: Hex) -> bool:
        return any(self[h + d] in ('lake', 'sea') for d in DIRECTIONS)


WORLD = GameMap(3)


@register("a hexagonal tile of three crossed boxes")
def tile(color: tuple[float, float, float] = (0.8, 0.8, 0.4), height: float = 0.2, size: float = 0.95) -> Shape:
    # three rectangles through the center together are a hexagon
    slab = primitive_call('cube', shape_kwargs={'scale': (size * math.sqrt(3), height, size)}, color=color)
    turned = loop(3, lambda i: transform_shape(slab, rotation_matrix(i * math.pi / 3, (0, 1, 0), (0, 0, 0))))
    return transform_shape(turned, translation_matrix((0, height / 2, 0)))


@register("what grows or stands on a tile")
def feature(kind: str = 'forest', size: float = 1.0) -> Shape:
    match kind:
        case 'forest':
            spots = [(-0.3, -0.2), (0.3, -0.1), (0.0, 0.35)]
            return concat_shapes(*[transform_shape(primitive_call('sphere', shape_kwargs={'radius': 0.22 * size}, color=(0.1, 0.4, 0.15)), translation_matrix((x, 0.2, z))) for x, z in spots])
        case 'mountain':
            return loop(4, lambda i: primitive_call('cylinder', shape_kwargs={'radius': (0.5 - 0.12 * i) * size, 'p0': (0, 0.2 * i, 0), 'p1': (0, 0.2 * (i + 1), 0)},
                                                    color=(0.95, 0.95, 0.97) if i == 3 else (0.5, 0.47, 0.45)))
        case 'field' | 'lake' as flat:
            color = (0.95, 0.88, 0.45) if flat == 'field' else (0.6, 0.8, 0.95)
            return loop(3, lambda i: transform_shape(primitive_call('cube', shape_kwargs={'scale': (0.9, 0.03, 0.1)}, color=color), translation_matrix((0, 0.01, (i - 1) * 0.3))))
        case other:
            raise ValueError(f"unknown land {other!r}")


@register()
def castle(owner: int = 0) -> Shape:
    color = [(0.85, 0.15, 0.15), (0.15, 0.25, 0.8), (0.9, 0.9, 0.9)][owner % 3]
    keep = transform_shape(primitive_call('cube', shape_kwargs={'scale': (0.5, 0.5, 0.5)}, color=color), translation_matrix((0, 0.25, 0)))
    towers = [primitive_call('cylinder', shape_kwargs={'radius': 0.12, 'p0': (x, 0, z), 'p1': (x, 0.7, z)}, color=color) for x in (-0.28, 0.28) for z in (-0.28, 0.28)]
    return concat_shapes(keep, *towers)


@register()
def hex_strategy_board() -> Shape:
    shapes = []
    ports = [h for h in WORLD if WORLD.borders_water(h) and WORLD[h] == 'field']
    names = dict(zip(ports, ascii_uppercase))
    for h in WORLD:
        x, z = h.center()
        kind = WORLD[h]
        height = 0.12 if kind == 'lake' else 0.2 + 0.05 * (3 - abs(h))
        piece = [library_call('tile', color=GameMap.LAND[kind], height=height), transform_shape(library_call('feature', kind=kind), translation_matrix((0, height, 0)))]
        if names.get(h, 'Z') < 'D':
            piece.append(transform_shape(library_call('castle', owner=ord(names[h]) - ord('A')), translation_matrix((0, height, 0))))
        shapes.append(transform_shape(concat_shapes(*piece), translation_matrix((x, 0, z))))
    sea = primitive_call('cylinder', shape_kwargs={'radius': 7.0, 'p0': (0, -0.2, 0), 'p1': (0, 0, 0)}, color=(0.15, 0.35, 0.6))
    return concat_shapes(sea, *shapes)
