"""a bowling alley: one lane after the first throw of the last frame and a scoreboard of a whole game"""
from helper import *
from dataclasses import dataclass
from itertools import accumulate, count, zip_longest
from operator import itemgetter
import math
import string

GAME = 'X 7/ 9- X -8 8/ -6 X X X81'  # ten frames

SEGMENTS = dict(zip(string.digits, ('abcdef', 'bc', 'abdeg', 'abcdg', 'bcfg', 'acdfg', 'acdefg', 'abc', 'abcdefg', 'abcdfg')))
SEGMENT_BOX = {'a': (0, 2, 1), 'b': (0.5, 1.5, 0), 'c': (0.5, 0.5, 0), 'd': (0, 0, 1), 'e': (-0.5, 0.5, 0), 'f': (-0.5, 1.5, 0), 'g': (0, 1, 1)}


def rolls_of(game: str) -> list[int]:
    """Pins of every roll; `X` strike, `/` spare, `-` none."""
    rolls: list[int] = []
    for symbol in game.replace(' ', ''):
        match symbol:
            case 'X':
                rolls.append(10)
            case '/':
                rolls.append(10 - rolls[-1])
            case '-':
                rolls.append(0)
            case d if d.isdigit():
                rolls.append(int(d))
            case bad:
                raise ValueError(f'{bad!r} is no roll')
    return rolls


def frame_scores(rolls: list[int]) -> list[int]:
    def frames(i: int, frame: int):
        if frame == 10:
            return
        match rolls[i:i + 3]:
            case [10, *bonus]:
                yield 10 + sum(bonus)
                yield from frames(i + 1, frame + 1)
            case [a, b, *bonus] if a + b == 10:
                yield 10 + sum(bonus)
                yield from frames(i + 2, frame + 1)
            case [a, b, *_]:
                yield a + b
                yield from frames(i + 2, frame + 1)
    return [*frames(0, 0)]


@dataclass
class Ball:
    x: float
    z: float
    vx: float
    vz: float
    radius: float = 0.108

    def advance(self, dt: float, hook: float) -> None:
        self.vx += hook * dt
        self.x += self.vx * dt
        self.z += self.vz * dt


PINS = [((i - row / 2) * 0.305, -row * 0.264) for row in range(4) for i in range(row + 1)]


def throw(start: float = 0.35, aim: float = -0.05, hook: float = -0.03) -> tuple[set[int], list[tuple[float, float]]]:
    """Rolls until behind the pins; a pin falls when the ball or a falling pin comes near."""
    ball, fallen, path = Ball(start, 6.0, aim, -3.5), set(), []
    for tick in count():
        ball.advance(0.02, hook)
        if tick % 6 == 0:
            path.append((ball.x, ball.z))
        for k, (px, pz) in enumerate(PINS):
            if k not in fallen and math.hypot(ball.x - px, ball.z - pz) < ball.radius + 0.075:
                queue = [(k, px - ball.x)]
                while queue:
                    j, push = queue.pop()
                    if j in fallen:
                        continue
                    fallen.add(j)
                    for m, (qx, qz) in enumerate(PINS):
                        behind = qz < PINS[j][1] - 0.1 and math.dist((qx, qz), PINS[j]) < 0.35
                        if behind and (qx - PINS[j][0]) * push > 0:
                            queue.append((m, push))
        if ball.z < -1.2:
            return fallen, path


@register()
def pin(height: float = 0.38, lying: float = 0.0, heading: float = 0.0) -> Shape:
    profile = [(0.0, 0.028), (0.15, 0.055), (0.3, 0.06), (0.5, 0.045), (0.7, 0.025), (0.82, 0.03), (0.95, 0.03), (1.0, 0.015)]
    slices = [primitive_call('cylinder', shape_kwargs={'radius': (r0 + r1) / 2, 'p0': (0, t0 * height, 0), 'p1': (0, t1 * height, 0)}, color=(0.85, 0.1, 0.12) if 0.6 < (t0 + t1) / 2 < 0.8 else (0.98, 0.98, 0.96))
              for (t0, r0), (t1, r1) in zip(profile, profile[1:])]
    shape = transform_shape(concat_shapes(*slices), rotation_matrix(lying, (0, 0, 1), (0, 0, 0)))
    return transform_shape(shape, rotation_matrix(heading, (0, 1, 0), (0, 0, 0)))


@register()
def pin_deck(start: float = 0.35, hook: float = -0.03) -> Shape:
    fallen, path = throw(start=start, hook=hook)
    shapes = []
    for k, (x, z) in enumerate(PINS):
        down = k in fallen
        p = library_call('pin', lying=math.pi / 2 if down else 0.0, heading=k * 0.8 if down else 0.0)
        shapes.append(transform_shape(p, translation_matrix((x, 0.06 if down else 0.0, z))))
    trail = [transform_shape(primitive_call('sphere', shape_kwargs={'radius': 0.108 if i == len(path) - 1 else 0.02}, color=(0.1, 0.2, 0.6)), translation_matrix((x, 0.108, z))) for i, (x, z) in enumerate(path)]
    return concat_shapes(*shapes, *trail)


@register()
def number(value: int = 0, size: float = 0.08, color: tuple = (1.0, 0.6, 0.1)) -> Shape:
    """Seven-segment digits, left aligned."""
    out = []
    for place, digit in enumerate(str(value)):
        for x, y, flat in itemgetter(*SEGMENTS[digit])(SEGMENT_BOX):
            scale = (size * 0.9, size * 0.15, 0.02) if flat else (size * 0.15, size * 0.9, 0.02)
            out.append(transform_shape(primitive_call('cube', shape_kwargs={'scale': scale}, color=color), translation_matrix((size * (x + 1.6 * place), size * y, 0))))
    return concat_shapes(*out)


@register()
def scoreboard(game: str = GAME) -> Shape:
    rolls = rolls_of(game)
    totals = list(accumulate(frame_scores(rolls)))
    board = [transform_shape(primitive_call('cube', shape_kwargs={'scale': (5.4, 0.8, 0.06)}, color=(0.05, 0.06, 0.1)), translation_matrix((0, 0.1, -0.05)))]
    for i, (total, roll) in enumerate(zip_longest(totals, rolls[:10], fillvalue=0)):
        x = -2.55 + 0.53 * i
        board.append(transform_shape(library_call('number', value=total), translation_matrix((x, -0.1, 0))))
        board.append(transform_shape(library_call('number', value=roll, size=0.05, color=(0.4, 0.9, 1.0)), translation_matrix((x, 0.25, 0))))
    return concat_shapes(*board)


@register()
def bowling_alley(lane_length: float = 7.5) -> Shape:
    boards = loop(13, lambda i: transform_shape(primitive_call('cube', shape_kwargs={'scale': (0.082, 0.05, lane_length)}, color=(0.8 - 0.04 * (i % 3), 0.6, 0.36)), translation_matrix((-0.5 + 0.083 * i, -0.025, lane_length / 2 - 1.2))))
    arrows = [transform_shape(primitive_call('cube', shape_kwargs={'scale': (0.04, 0.01, 0.15)}, color=(0.5, 0.15, 0.1)), translation_matrix((0.15 * k, 0.005, 3.6 - 0.2 * (3 - abs(k))))) for k in range(-3, 4)]
    gutters = [primitive_call('cylinder', shape_kwargs={'radius': 0.1, 'p0': (s * 0.66, -0.08, -1.2), 'p1': (s * 0.66, -0.08, lane_length - 1.2)}, color=(0.3, 0.3, 0.33)) for s in (-1, 1)]
    score = transform_shape(library_call('scoreboard'), translation_matrix((0, 1.7, -1.3)))
    return concat_shapes(boards, *arrows, *gutters, library_call('pin_deck'), score)
