"""the Towers of Hanoi, solved: one frame after each move of four discs"""
from helper import *
import colorsys
from copy import deepcopy
from typing import Iterator, NamedTuple


class Move(NamedTuple):
    disc: int
    source: str
    target: str

    def __str__(self) -> str:
        return f"{self.disc}: {self.source} -> {self.target}"


def solve(n: int, source: str = 'A', target: str = 'C', spare: str = 'B') -> Iterator[Move]:
    if n == 0:
        return
    yield from solve(n - 1, source, spare, target)
    yield Move(n, source, target)
    yield from solve(n - 1, spare, target, source)


class IllegalMove(Exception):
    pass


class Towers:
    def __init__(self, n: int):
        self.n = n
        self.pegs: dict[str, list[int]] = {'A': list(range(n, 0, -1)), 'B': [], 'C': []}

    def __call__(self, move: Move) -> 'Towers':
        after = deepcopy(self)
        disc = after.pegs[move.source].pop()
        if disc != move.disc or (after.pegs[move.target] and after.pegs[move.target][-1] < disc):
            raise IllegalMove(str(move))
        after.pegs[move.target].append(disc)
        return after

    def __iter__(self):
        for peg, discs in self.pegs.items():
            for level, disc in enumerate(discs):
                yield peg, level, disc

    @property
    def done(self) -> bool:
        return len(self.pegs['C']) == self.n


PEG_X = {peg: 2.4 * (k - 1) for k, peg in enumerate('ABC')}
THICKNESS = 0.25


@register("a flat disc whose color depends on its size")
def disc(size: int = 1, count: int = 4) -> Shape:
    color = colorsys.hsv_to_rgb((size - 1) / count, 0.7, 0.9)
    r = 0.35 + 0.18 * size
    plate = primitive_call('cylinder', shape_kwargs={'radius': r, 'p0': (0, 0, 0), 'p1': (0, THICKNESS * 0.95, 0)}, color=color)
    groove = primitive_call('cylinder', shape_kwargs={'radius': r * 1.01, 'p0': (0, 0.1, 0), 'p1': (0, 0.14, 0)}, color=tuple(c * 0.6 for c in color))
    return concat_shapes(plate, groove)


@register("the board with three pegs")
def stand(height: float = 1.6) -> Shape:
    wood = (0.55, 0.38, 0.22)
    board = transform_shape(primitive_call('cube', shape_kwargs={'scale': (7.6, 0.2, 2.6)}, color=wood), translation_matrix((0, -0.1, 0)))
    pegs = [primitive_call('cylinder', shape_kwargs={'radius': 0.1, 'p0': (x, 0, 0), 'p1': (x, height, 0)}, color=wood) for x in PEG_X.values()]
    tips = [transform_shape(primitive_call('sphere', shape_kwargs={'radius': 0.12}, color=(0.8, 0.7, 0.3)), translation_matrix((x, height, 0))) for x in PEG_X.values()]
    return concat_shapes(board, *pegs, *tips)


def draw(towers: Towers) -> Shape:
    discs = [
        transform_shape(library_call('disc', size=disc, count=towers.n), translation_matrix((PEG_X[peg], level * THICKNESS, 0)))
        for peg, level, disc in towers
    ]
    if towers.done:
        star = primitive_call('sphere', shape_kwargs={'radius': 0.25}, color=(1.0, 0.85, 0.1))
        discs.append(transform_shape(star, translation_matrix((PEG_X['C'], 2.1, 0))))
    return concat_shapes(library_call('stand'), *discs)


@register_animation()
def tower_of_hanoi(n: int = 4) -> list[Shape]:
    state = Towers(n)
    frames = [draw(state)]
    for move in solve(n):
        frames.append(draw(state := state(move)))
    return frames
