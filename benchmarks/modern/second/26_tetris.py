"""
an arcade cabinet with a tetris game on its screen
"""
from helper import *
from dataclasses import dataclass
from enum import Enum
from random import Random
import numpy as np


PAINT = dict(I=(0.2, 0.85, 0.9), O=(0.95, 0.85, 0.2), T=(0.7, 0.3, 0.85), S=(0.3, 0.85, 0.35),
             Z=(0.9, 0.25, 0.25), J=(0.25, 0.4, 0.9), L=(0.95, 0.6, 0.2))


class Tetromino(Enum):
    I = ('####',)
    O = ('##', '##')
    T = ('###', '.#.')
    S = ('.##', '##.')
    Z = ('##.', '.##')
    J = ('#..', '###')
    L = ('..#', '###')

    def __init__(self, *rows: str):
        self.mask = np.array([[c == '#' for c in row] for row in rows])

    @property
    def color(self) -> tuple[float, float, float]:
        return PAINT[self.name]

    def rotations(self):
        seen = set()
        for k in range(4):
            m = np.rot90(self.mask, k)
            if (key := (m.shape, m.tobytes())) not in seen:
                yield seen.add(key) or m


@dataclass
class Well:
    rows: int = 18
    cols: int = 10

    def __post_init__(self):
        self.grid = np.zeros((self.rows, self.cols), dtype=int)

    def landing(self, m: np.ndarray, c: int) -> int | None:
        h, w = m.shape
        best = None
        for r in range(self.rows - h, -1, -1):
            if (self.grid[r:r + h, c:c + w].astype(bool) & m).any(): break
            best = r
        return best

    def score(self, m, r, c) -> tuple[float, ...]:
        trial = self.grid.astype(bool).copy()
        trial[r:r + m.shape[0], c:c + m.shape[1]] |= m
        tops = np.where(trial.any(axis=0), self.rows - np.argmax(trial[::-1], axis=0), 0)
        holes = int((tops - trial.sum(axis=0)).sum())
        return holes * 3 + r, float(np.abs(np.diff(tops)).sum())

    def drop(self, piece: Tetromino, tag: int):
        options = [(self.score(m, r, c), i, r, c, m)
                   for i, m in enumerate(piece.rotations())
                   for c in range(self.cols - m.shape[1] + 1)
                   if (r := self.landing(m, c)) is not None]
        if not options: raise StopIteration('game over')
        *_, r, c, m = min(options, key=lambda o: o[:2])
        self.grid[r:r + m.shape[0], c:c + m.shape[1]][m] = tag

    def clear(self) -> int:
        full = self.grid.all(axis=1)
        keep = self.grid[~full]
        self.grid = np.vstack([keep, np.zeros((full.sum(), self.cols), dtype=int)])
        return int(full.sum())


def play(pieces: int, seed: int) -> tuple[Well, int]:
    rng, well, lines, kinds = Random(seed), Well(), 0, list(Tetromino)
    for _ in range(pieces):
        piece = rng.choice(kinds)
        try:
            well.drop(piece, kinds.index(piece) + 1)
        except StopIteration:
            break
        lines += well.clear()
    return well, lines


@register()
def screen(pieces: int = 23, seed: int = 8, pixel: float = 0.12) -> Shape:
    well, lines = play(pieces, seed)
    kinds = [*Tetromino]
    out = [primitive_call('cube', {'scale': (well.cols * pixel, well.rows * pixel, 0.02)}, color=(0.03, 0.03, 0.06))]
    for r, c in zip(*np.nonzero(well.grid)):
        px = primitive_call('cube', {'scale': (pixel * 0.9, pixel * 0.9, 0.04)}, color=kinds[well.grid[r, c] - 1].color)
        out.append(transform_shape(px, translation_matrix(((c - well.cols / 2 + 0.5) * pixel, (r - well.rows / 2 + 0.5) * pixel, 0.02))))
    bars = loop(lines + 1, lambda i: transform_shape(primitive_call('cube', {'scale': (0.05, 0.1, 0.02)}, color=(0.3, 1, 0.4)), translation_matrix((0.72, -0.9 + i * 0.14, 0))))
    return concat_shapes(*out, bars)


@register()
def controls(buttons: int = 3) -> Shape:
    panel = primitive_call('cube', {'scale': (1.7, 0.08, 0.6)}, color=(0.15, 0.15, 0.18))
    stick = primitive_call('cylinder', {'radius': 0.03, 'p0': (-0.5, 0, 0), 'p1': (-0.45, 0.3, 0)}, color=(0.1, 0.1, 0.1))
    knob = transform_shape(primitive_call('sphere', {'radius': 0.08}, color=(0.9, 0.1, 0.1)), translation_matrix((-0.45, 0.32, 0)))
    keys = loop(buttons, lambda i: primitive_call('cylinder', {'radius': 0.07, 'p0': (0.1 + 0.2 * i, 0.03, 0), 'p1': (0.1 + 0.2 * i, 0.08, 0)}, color=(0.95, 0.8, 0.1)))
    return concat_shapes(panel, stick, knob, keys)


@register()
def arcade_cabinet() -> Shape:
    blue = (0.12, 0.2, 0.5)
    blocks = [((1.8, 1.8, 1.4), (0, 0.9, 0)), ((1.8, 2.6, 0.6), (0, 3.1, -0.4)), ((1.8, 0.5, 1.1), (0, 4.6, -0.15))]
    body = [transform_shape(primitive_call('cube', {'scale': s}, color=blue), translation_matrix(p)) for s, p in blocks]
    view = transform_shape(library_call('screen'), rotation_matrix(-0.12, (1, 0, 0), (0, 0, 0)))
    view = transform_shape(view, translation_matrix((0, 3.1, 0.1)))
    panel = transform_shape(library_call('controls'), translation_matrix((0, 1.86, 0.4)))
    sign = transform_shape(primitive_call('cube', {'scale': (1.6, 0.35, 0.05)}, color=(1, 0.9, 0.5)), translation_matrix((0, 4.6, 0.42)))
    return concat_shapes(*body, view, panel, sign)
