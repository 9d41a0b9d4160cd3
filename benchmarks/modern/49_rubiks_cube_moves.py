"""a scrambled Rubik's cube, mid-turn"""
from helper import *
import itertools
import math
import numpy as np

COLORS = {(1, 0, 0): (0.8, 0.1, 0.1), (-1, 0, 0): (1.0, 0.5, 0.0), (0, 1, 0): (1.0, 1.0, 1.0),
          (0, -1, 0): (1.0, 0.85, 0.0), (0, 0, 1): (0.0, 0.6, 0.25), (0, 0, -1): (0.0, 0.3, 0.7)}
MOVES = {'R': ((1, 0, 0), 1), 'L': ((-1, 0, 0), 1), 'U': ((0, 1, 0), 1), 'D': ((0, -1, 0), 1), 'F': ((0, 0, 1), 1), 'B': ((0, 0, -1), 1)}


def parse_moves(text: str):
    """'R U' F2' -> (axis, quarter turns)."""
    for token in text.split():
        face, suffix = token[0], token[1:]
        turns = {'': 1, "'": -1, '2': 2}[suffix]
        axis, sign = MOVES[face]
        yield np.array(axis), -turns * sign


class Cubie:
    def __init__(self, home: tuple[int, int, int]):
        self.home = np.array(home)
        self.pose = np.eye(4)

    @property
    def position(self) -> np.ndarray:
        return np.rint(self.pose[:3, :3] @ self.home).astype(int)

    def turn(self, axis: np.ndarray, angle: float) -> None:
        if self.position @ axis == 1:
            self.pose = rotation_matrix(angle, axis, (0, 0, 0)) @ self.pose

    def stickers(self):
        for normal, color in COLORS.items():
            if self.home @ np.array(normal) == 1:
                yield np.array(normal), color


class Rubik:
    def __init__(self):
        self.cubies = [Cubie(p) for p in itertools.product((-1, 0, 1), repeat=3) if any(p)]

    def apply(self, moves: str) -> 'Rubik':
        for axis, q in parse_moves(moves):
            for c in self.cubies:
                c.turn(axis, q * math.pi / 2)
        return self


@register()
def cubie(c: Cubie) -> Shape:
    block = primitive_call('cube', shape_kwargs={'scale': (0.96, 0.96, 0.96)}, color=(0.05, 0.05, 0.05))
    parts = [block]
    for n, color in c.stickers():
        size = np.where(n != 0, 0.04, 0.8)
        parts.append(transform_shape(primitive_call('cube', shape_kwargs={'scale': size.tolist()}, color=color), translation_matrix(n * 0.48)))
    return transform_shape(concat_shapes(*parts), c.pose @ translation_matrix(c.home.astype(float)))


@register()
def rubiks_cube(scramble: str = "R U' F2 L D B' R2 U", partial_turn: float = 28.0) -> Shape:
    cube = Rubik().apply(scramble)
    assert len({tuple(c.position) for c in cube.cubies}) == 26
    out = []
    for c in cube.cubies:
        s = library_call('cubie', c=c)
        if c.position[1] == 1:
            s = transform_shape(s, rotation_matrix(math.radians(partial_turn), (0, 1, 0), (0, 0, 0)))
        out.append(s)
    return concat_shapes(*out)
