"""
a neon sign reading OPEN 24H on a brick wall
"""
from helper import *
import random
from collections.abc import Mapping
from itertools import chain, pairwise
from typing import Literal

Color = tuple[float, float, float]
Stroke = list[tuple[float, float]]


class Alphabet(Mapping[str, list[Stroke]]):
    """Strokes written as strings of grid letters: rows a-e from the top, columns 0-2."""
    SOURCE = {
        'O': 'a0 a2 e2 e0 a0',
        'P': 'e0 a0 a2 c2 c0',
        'E': 'a2 a0 e0 e2|c0 c1',
        'N': 'e0 a0 e2 a2',
        '2': 'a0 a2 c2 c0 e0 e2',
        '4': 'a0 c0 c2|a2 e2',
        'H': 'a0 e0|c0 c2|a2 e2',
        ' ': '',
    }

    def __getitem__(self, ch: str) -> list[Stroke]:
        text = self.SOURCE[ch]
        return [[self._point(tok) for tok in part.split()] for part in text.split('|') if part]

    def __iter__(self):
        return iter(self.SOURCE)

    def __len__(self) -> int:
        return len(self.SOURCE)

    @staticmethod
    def _point(tok: str) -> tuple[float, float]:
        row, col = tok
        return int(col) / 2, (ord('e') - ord(row)) / 4


LETTERS = Alphabet()


@register()
def tube(points: list, radius: float = 0.03, color: tuple = (1.0, 0.3, 0.5)) -> Shape:
    pieces = (primitive_call('cylinder', {'radius': radius, 'p0': (*a, 0), 'p1': (*b, 0)}, color=color) for a, b in pairwise(points))
    elbows = (transform_shape(primitive_call('sphere', {'radius': radius}, color=color), translation_matrix((*p, 0))) for p in points)
    return [*chain.from_iterable(pieces), *chain.from_iterable(elbows)]


@register()
def neon_text(text: str = 'OPEN', height: float = 1.0, aspect: float = 0.6, color: tuple = (1.0, 0.3, 0.5)) -> Shape:
    width = height * aspect
    pitch = width * 1.4
    shapes: Shape = []
    for i, ch in enumerate(text):
        if (strokes := LETTERS.get(ch)) is None:
            raise KeyError(f'{ch!r} is not among {"".join(LETTERS)}')
        for stroke in strokes:
            pts = [(i * pitch + x * width, y * height) for x, y in stroke]
            shapes += library_call('tube', points=pts, radius=height * 0.035, color=color)
    cx = compute_shape_center(shapes)[0]
    return transform_shape(shapes, translation_matrix((-cx, 0, 0)))


@register()
def brick_wall(width: float = 5.0, height: float = 3.6, brick: tuple[float, float] = (0.5, 0.22), bond: Literal['running', 'stack'] = 'running', seed: int = 0) -> Shape:
    rng = random.Random(seed)
    bw, bh = brick
    rows = round(height / bh)
    bricks = []
    for r in range(rows):
        shift = bw / 2 if bond == 'running' and r % 2 else 0
        x = -width / 2 - shift
        while x < width / 2:
            tone = rng.gauss(0.0, 0.03)
            c = tuple(min(1, max(0, v + tone)) for v in (0.5, 0.22, 0.17))
            b = primitive_call('cube', {'scale': (bw * 0.95, bh * 0.9, 0.2)}, color=c)
            bricks.append(transform_shape(b, translation_matrix((x + bw / 2, (r + 0.5) * bh, 0))))
            x += bw
    mortar = transform_shape(primitive_call('cube', {'scale': (width + bw, height, 0.15)}, color=(0.6, 0.58, 0.55)), translation_matrix((0, height / 2, 0)))
    return concat_shapes(mortar, *bricks)


@register()
def border(width: float = 3.4, height: float = 2.4, color: tuple = (0.3, 0.8, 1.0)) -> Shape:
    x, y = width / 2, height / 2
    corners = [(-x, -y), (x, -y), (x, y), (-x, y)]
    return library_call('tube', points=corners + corners[:1], radius=0.04, color=color)


@register()
def neon_sign() -> Shape:
    lines: dict[str, Color] = {'OPEN': (1.0, 0.3, 0.5), '24H': (1.0, 0.85, 0.3)}
    words = [transform_shape(library_call('neon_text', text=t, height=0.8, color=c), translation_matrix((0, 1.9 - 1.05 * i, 0.25)))
             for i, (t, c) in enumerate(lines.items())]
    frame = transform_shape(library_call('border'), translation_matrix((0, 1.75, 0.2)))
    return concat_shapes(library_call('brick_wall'), frame, *words)
