"""a Tetris board in the middle of a game, with a ghost piece and the next pieces beside it"""
from helper import *
from dataclasses import dataclass, field, replace
from typing import Iterable
import numpy as np
import random

TETROMINOES: dict[str, tuple[list[str], tuple[float, float, float]]] = {
    'I': (['####'], (0.2, 0.8, 0.9)),
    'O': (['##', '##'], (0.95, 0.85, 0.2)),
    'T': (['###', '.#.'], (0.65, 0.25, 0.8)),
    'S': (['.##', '##.'], (0.3, 0.8, 0.3)),
    'Z': (['##.', '.##'], (0.9, 0.25, 0.25)),
    'J': (['#..', '###'], (0.2, 0.35, 0.85)),
    'L': (['..#', '###'], (0.95, 0.55, 0.15)),
}
NAMES = list(TETROMINOES)


@dataclass(frozen=True)
class Piece:
    name: str
    x: int = 3
    y: int = 0
    turns: int = 0

    @property
    def mask(self) -> np.ndarray:
        rows, _ = TETROMINOES[self.name]
        return np.rot90(np.array([[ch == '#' for ch in row] for row in rows]), self.turns)

    @property
    def cells(self) -> Iterable[tuple[int, int]]:
        for r, c in np.argwhere(self.mask):
            yield self.y + int(r), self.x + int(c)

    def moved(self, dx: int = 0, dy: int = 0) -> 'Piece':
        return replace(self, x=self.x + dx, y=self.y + dy)


@dataclass
class Game:
    rows: int = 18
    cols: int = 10
    seed: int = 1984
    cleared: int = 0
    board: np.ndarray = field(init=False)

    def __post_init__(self):
        self.board = np.full((self.rows, self.cols), -1, dtype=int)
        self._rng = random.Random(self.seed)
        self._bag: list[str] = []

    def draw(self) -> str:
        if not self._bag:
            self._bag = self._rng.sample(NAMES, k=len(NAMES))
        return self._bag.pop()

    def fits(self, piece: Piece) -> bool:
        return all(0 <= c < self.cols and r < self.rows and (r < 0 or self.board[r, c] < 0) for r, c in piece.cells)

    def dropped(self, piece: Piece) -> Piece:
        while self.fits(lower := piece.moved(dy=1)):
            piece = lower
        return piece

    def badness(self, piece: Piece) -> tuple[float, int]:
        """Holes below count most, then height."""
        trial = self.board.copy()
        for r, c in piece.cells:
            trial[r, c] = 0
        filled = trial >= 0
        holes = int((np.maximum.accumulate(filled, axis=0) & ~filled).sum())
        heights = np.where(filled.any(axis=0), self.rows - filled.argmax(axis=0), 0)
        return holes * 4 + float(heights.max()) + float(np.abs(np.diff(heights)).sum()) * 0.6, piece.x

    def best(self, name: str) -> Piece | None:
        options = (self.dropped(p) for turns in range(4) for x in range(-1, self.cols) if self.fits(p := Piece(name, x, 0, turns)))
        return min(options, key=self.badness, default=None)

    def lock(self, piece: Piece) -> None:
        for r, c in piece.cells:
            self.board[r, c] = NAMES.index(piece.name)
        full = (self.board >= 0).all(axis=1)
        if (n := np.count_nonzero(full)):
            self.board = np.vstack([np.full((n, self.cols), -1), self.board[~full]])
            self.cleared += int(n)

    def play(self, moves: int) -> 'Game':
        for _ in range(moves):
            if (piece := self.best(self.draw())) is None:
                break
            self.lock(piece)
        return self


@register()
def mino(kind: str = 'I', size: float = 0.3, ghost: bool = False) -> Shape:
    _, color = TETROMINOES[kind]
    if ghost:
        edge = size * 0.46
        corners = [(-edge, -edge), (edge, -edge), (edge, edge), (-edge, edge)]
        return concat_shapes(*[primitive_call('cylinder', shape_kwargs={'radius': size * 0.04, 'p0': (*a, 0), 'p1': (*b, 0)}, color=color) for a, b in zip(corners, corners[1:] + corners[:1])])
    block = primitive_call('cube', shape_kwargs={'scale': (size * 0.96,) * 3}, color=color)
    shine = transform_shape(primitive_call('cube', shape_kwargs={'scale': (size * 0.6, size * 0.6, size * 0.05)}, color=tuple(min(1, c + 0.2) for c in color)), translation_matrix((0, 0, size / 2)))
    return concat_shapes(block, shine)


@register()
def well(moves: int = 34, size: float = 0.3) -> Shape:
    game = Game().play(moves)
    out = []
    for (r, c), k in np.ndenumerate(game.board):
        if k >= 0:
            out.append(transform_shape(library_call('mino', kind=NAMES[k], size=size), translation_matrix((c * size, (game.rows - 1 - r) * size, 0))))
    current = Piece(game.draw(), x=4, y=0, turns=1)
    for piece, ghost in ((game.dropped(current), True), (current, False)):
        for r, c in piece.cells:
            out.append(transform_shape(library_call('mino', kind=piece.name, size=size, ghost=ghost), translation_matrix((c * size, (game.rows - 1 - r) * size, 0))))
    w, h = game.cols * size, game.rows * size
    frame = [((w + 0.2, 0.1, size), (w / 2 - size / 2, -size / 2 - 0.05, 0))] + [((0.1, h, size), (x, h / 2 - size / 2, 0)) for x in (-size / 2 - 0.05, w - size / 2 + 0.05)]
    walls = [transform_shape(primitive_call('cube', shape_kwargs={'scale': s}, color=(0.3, 0.32, 0.36)), translation_matrix(p)) for s, p in frame]
    score = loop(game.cleared, lambda i: transform_shape(primitive_call('sphere', shape_kwargs={'radius': 0.08}, color=(1, 0.85, 0.2)), translation_matrix((w + 0.6 + 0.25 * (i % 4), 0.2 + 0.25 * (i // 4), 0))))
    return concat_shapes(*walls, *out, score)


@register()
def next_queue(count: int = 3, size: float = 0.22, seed: int = 7) -> Shape:
    names = random.Random(seed).choices(NAMES, weights=range(1, 8), k=count)
    rows = []
    for slot, name in enumerate(names):
        cells = Piece(name, x=0, y=slot * 4).cells
        rows += [transform_shape(library_call('mino', kind=name, size=size), translation_matrix((c * size, -r * size, 0))) for r, c in cells]
    return concat_shapes(*rows)


@register()
def arcade() -> Shape:
    queue = transform_shape(library_call('next_queue'), translation_matrix((3.6, 4.6, 0)))
    back = transform_shape(primitive_call('cube', shape_kwargs={'scale': (5.6, 6.2, 0.1)}, color=(0.08, 0.08, 0.12)), translation_matrix((2.0, 2.5, -0.3)))
    return concat_shapes(back, library_call('well'), queue)
