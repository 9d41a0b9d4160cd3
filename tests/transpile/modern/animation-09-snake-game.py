from __future__ import annotations
import random
from collections import deque
from typing import NamedTuple
from helper import *

"""
the game of snake, played by a simple strategy
"""


class Pos(NamedTuple):
    x: int
    y: int

    def __add__(self, other):
        return Pos(self.x + other[0], self.y + other[1])

    def to(self, other: Pos) -> int:
        return abs(self.x - other.x) + abs(self.y - other.y)


class GameOver(Exception):
    def __init__(self, length: int):
        self.length = length


class Game:
    SIZE = 8
    MOVES = ((1, 0), (0, 1), (-1, 0), (0, -1))

    def __init__(self):
        self.body = deque([Pos(3, 3), Pos(2, 3), Pos(1, 3)])
        self.food = self.place()

    def place(self) -> Pos:
        free = [Pos(x, y) for x in range(self.SIZE) for y in range(self.SIZE) if Pos(x, y) not in self.body]
        return random.choice(free)

    def safe(self, p: Pos) -> bool:
        return 0 <= p.x < self.SIZE and 0 <= p.y < self.SIZE and p not in list(self.body)[:-1]

    def step(self) -> bool:
        head = self.body[0]
        options = [head + m for m in self.MOVES if self.safe(head + m)]
        if not options:
            raise GameOver(len(self.body))
        target = min(options, key=lambda p: (p.to(self.food), p))
        self.body.appendleft(target)
        if ate := target == self.food:
            self.food = self.place()
        else:
            self.body.pop()
        return ate


@register()
def board() -> Shape:
    n = Game.SIZE
    ground = transform_shape(primitive_call('cube', color=(0.15, 0.2, 0.15), shape_kwargs={'scale': (n, 0.1, n)}), translation_matrix(((n - 1) / 2, -0.05, (n - 1) / 2)))
    walls = [transform_shape(primitive_call('cube', color=(0.4, 0.4, 0.4), shape_kwargs={'scale': (n, 0.4, 0.2)}), translation_matrix(((n - 1) / 2, 0.2, z))) for z in (-0.6, n - 0.4)]
    return concat_shapes(ground, *walls)


@register()
def snake(body: list, flash: bool) -> Shape:
    shapes = []
    for i, (x, y) in enumerate(body):
        shade = 1 - 0.6 * i / len(body)
        color = (1, 1, 0.3) if flash and i == 0 else (0.1, shade, 0.2)
        shapes.append(transform_shape(primitive_call('cube', color=color, shape_kwargs={'scale': (0.9, 0.6, 0.9)}), translation_matrix((x, 0.3, y))))
    return concat_shapes(*shapes)


@register_animation()
def snake_game():
    game, floor = Game(), library_call('board')
    try:
        for _ in range(40):
            ate = game.step()
            apple = transform_shape(primitive_call('sphere', color=(0.9, 0.1, 0.1), shape_kwargs={'radius': 0.35}), translation_matrix((game.food.x, 0.35, game.food.y)))
            yield concat_shapes(floor, library_call('snake', body=[*game.body], flash=ate), apple)
    except GameOver as over:
        yield concat_shapes(floor, *[primitive_call('cube', color=(0.9, 0, 0), shape_kwargs={'scale': 0.2 * k}) for k in range(1, over.length)])
