"""
a sokoban level solved a few moves, shown as a board
"""
from helper import *
from collections import deque
from dataclasses import dataclass
from typing import NamedTuple


class Pos(NamedTuple):
    row: int
    col: int

    def step(self, d: 'Pos') -> 'Pos':
        return Pos(self.row + d.row, self.col + d.col)


DIRECTIONS = {'u': Pos(-1, 0), 'd': Pos(1, 0), 'l': Pos(0, -1), 'r': Pos(0, 1)}
LEVEL = '''
#######
#.   .#
# $$  #
#  @  #
#######
'''.strip().splitlines()


@dataclass(frozen=True)
class State:
    player: Pos
    boxes: frozenset[Pos]


def load(rows):
    walls, goals, boxes, player = set(), set(), set(), None
    for r, row in enumerate(rows):
        for c, ch in enumerate(row):
            match ch:
                case '#':
                    walls.add(Pos(r, c))
                case '.':
                    goals.add(Pos(r, c))
                case '$':
                    boxes.add(Pos(r, c))
                case '@':
                    player = Pos(r, c)
    return frozenset(walls), frozenset(goals), State(player, frozenset(boxes))


def moves(state, walls):
    for name, d in DIRECTIONS.items():
        to = state.player.step(d)
        if to in walls:
            continue
        if to in state.boxes:
            beyond = to.step(d)
            if beyond in walls or beyond in state.boxes:
                continue
            yield name, State(to, (state.boxes - {to}) | {beyond})
        else:
            yield name, State(to, state.boxes)


def solve(walls, goals, start, limit=4000):
    queue, seen = deque([(start, '')]), {start}
    while queue and limit > 0:
        limit -= 1
        state, path = queue.popleft()
        if state.boxes == goals:
            return path, state
        for name, after in moves(state, walls):
            if after not in seen:
                seen.add(after)
                queue.append((after, path + name))
    return '', start


WALLS, GOALS, START = load(LEVEL)
PATH, END = solve(WALLS, GOALS, START)


@register()
def crate(size: float = 0.8, placed: bool = False) -> Shape:
    color = (0.9, 0.7, 0.2) if placed else (0.6, 0.4, 0.2)
    box = primitive_call('cube', color=color, shape_kwargs={'scale': size})
    slats = [transform_shape(primitive_call('cube', color=(0.4, 0.26, 0.12), shape_kwargs={'scale': (size * 1.03, size * 0.1, size * 1.03)}), translation_matrix((0, k * size * 0.3, 0))) for k in (-1, 0, 1)]
    return concat_shapes(box, *slats)


@register()
def board(cell: float = 1.0) -> Shape:
    parts = []
    for p in sorted(WALLS):
        parts.append(transform_shape(primitive_call('cube', color=(0.5, 0.5, 0.55), shape_kwargs={'scale': cell}), translation_matrix((p.col * cell, cell / 2, p.row * cell))))
    for p in sorted(GOALS):
        parts.append(primitive_call('cylinder', color=(0.8, 0.2, 0.3), shape_kwargs={'radius': 0.3 * cell, 'p0': (p.col * cell, 0, p.row * cell), 'p1': (p.col * cell, 0.05, p.row * cell)}))
    return concat_shapes(*parts)


@register()
def sokoban() -> Shape:
    crates = [transform_shape(library_call('crate', placed=p in GOALS), translation_matrix((p.col, 0.4, p.row))) for p in sorted(END.boxes)]
    ghosts = [transform_shape(primitive_call('sphere', color=(0.9, 0.9, 0.9), shape_kwargs={'radius': 0.1}), translation_matrix((p.col, 0.1, p.row))) for p in sorted(START.boxes)]
    steps, here = [], START.player
    for i, name in enumerate(PATH):
        here = here.step(DIRECTIONS[name])
        steps.append(transform_shape(primitive_call('sphere', color=(0.2, 0.4 + 0.5 * i / len(PATH), 0.9), shape_kwargs={'radius': 0.12}), translation_matrix((here.col, 0.15, here.row))))
    return concat_shapes(library_call('board'), *crates, *ghosts, *steps)
