"""a chessboard with all pieces in the starting position"""
from __future__ import annotations

from dataclasses import dataclass
from enum import Enum, auto
from helper import *
import numpy as np


class Kind(Enum):
    PAWN = auto()
    ROOK = auto()
    KNIGHT = auto()
    BISHOP = auto()
    QUEEN = auto()
    KING = auto()

    @property
    def height(self) -> float:
        return {Kind.PAWN: 0.7, Kind.ROOK: 0.85, Kind.KNIGHT: 0.95,
                Kind.BISHOP: 1.1, Kind.QUEEN: 1.3, Kind.KING: 1.5}[self]


@dataclass(frozen=True)
class Palette:
    light: tuple[float, float, float]
    dark: tuple[float, float, float]

    def square(self, i: int, j: int) -> tuple[float, float, float]:
        return self.light if (i + j) % 2 else self.dark


BOARD = Palette(light=(0.93, 0.87, 0.73), dark=(0.42, 0.26, 0.15))
SIDES = Palette(light=(0.95, 0.93, 0.88), dark=(0.12, 0.11, 0.12))
BACK_ROW = [Kind.ROOK, Kind.KNIGHT, Kind.BISHOP, Kind.QUEEN,
            Kind.KING, Kind.BISHOP, Kind.KNIGHT, Kind.ROOK]


@register()
def square(i: int, j: int, size: float = 1.0) -> Shape:
    tile = primitive_call('cube', shape_kwargs={'scale': (size, 0.2, size)}, color=BOARD.square(i, j))
    return transform_shape(tile, translation_matrix(((i - 3.5) * size, -0.1, (j - 3.5) * size)))


@register()
def board(size: float = 1.0) -> Shape:
    tiles = loop(8, lambda i: loop(8, lambda j: library_call('square', i=i, j=j, size=size)))
    frame = primitive_call('cube', shape_kwargs={'scale': (8.8 * size, 0.15, 8.8 * size)}, color=(0.3, 0.18, 0.1))
    return concat_shapes(transform_shape(frame, translation_matrix((0, -0.2, 0))), tiles)


@register()
def piece(kind: Kind, white: bool) -> Shape:
    color = SIDES.light if white else SIDES.dark
    h = kind.height

    def disc(r, y0, y1):
        return primitive_call('cylinder', shape_kwargs={'radius': r, 'p0': (0, y0, 0), 'p1': (0, y1, 0)}, color=color)

    parts = [disc(0.34, 0, 0.1), disc(0.2, 0.1, h * 0.75)]
    match kind:
        case Kind.PAWN | Kind.BISHOP:
            head = primitive_call('sphere', shape_kwargs={'radius': 0.2}, color=color)
            parts.append(transform_shape(head, translation_matrix((0, h * 0.85, 0))))
        case Kind.ROOK:
            parts.append(disc(0.28, h * 0.75, h))
        case Kind.KNIGHT:
            nose = primitive_call('cube', shape_kwargs={'scale': (0.2, 0.25, 0.45)}, color=color)
            tilt = rotation_matrix(np.radians(25 if white else -25), (1, 0, 0), (0, 0, 0))
            parts.append(transform_shape(transform_shape(nose, tilt), translation_matrix((0, h * 0.85, 0))))
        case Kind.QUEEN:
            crown = primitive_call('sphere', shape_kwargs={'radius': 0.1}, color=color)
            parts += [transform_shape(crown, translation_matrix((0.2 * np.cos(a), h, 0.2 * np.sin(a))))
                      for a in np.linspace(0, 2 * np.pi, 6, endpoint=False)]
        case _:
            for s in ((0.08, 0.3, 0.08), (0.25, 0.08, 0.08)):
                bar = primitive_call('cube', shape_kwargs={'scale': s}, color=color)
                parts.append(transform_shape(bar, translation_matrix((0, h * 0.9, 0))))
    return concat_shapes(*parts)


@register()
def army(white: bool = True) -> Shape:
    z_back, z_front = (-3.5, -2.5) if white else (3.5, 2.5)
    shapes = []
    for x, kind in enumerate(BACK_ROW):
        shapes.append(transform_shape(library_call('piece', kind=kind, white=white), translation_matrix((x - 3.5, 0, z_back))))
        shapes.append(transform_shape(library_call('piece', kind=Kind.PAWN, white=white), translation_matrix((x - 3.5, 0, z_front))))
    return sum(shapes, [])


@register()
def chess_scene() -> Shape:
    return concat_shapes(library_call('board'), library_call('army', white=True), library_call('army', white=False))
