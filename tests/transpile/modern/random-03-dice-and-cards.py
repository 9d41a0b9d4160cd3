from __future__ import annotations
import random
from enum import Enum
from typing import NamedTuple
from helper import *

"""
a game table: thrown dice and a dealt deck
"""


class Suit(Enum):
    HEARTS = (0.8, 0.1, 0.1)
    SPADES = (0.1, 0.1, 0.12)
    CLUBS = (0.1, 0.4, 0.15)
    DIAMONDS = (0.9, 0.4, 0.1)


class Card(NamedTuple):
    rank: int
    suit: Suit


class Deck:
    def __init__(self, seed: int | None = None):
        self.rng = random.Random(seed) if seed is not None else random
        self.cards = [Card(rank, suit) for suit in Suit for rank in range(1, 10)]

    def shuffled(self) -> Deck:
        self.rng.shuffle(self.cards)
        return self

    def deal(self, hands: int, size: int) -> list[list[Card]]:
        dealt = [[] for _ in range(hands)]
        for i in range(hands * size):
            dealt[i % hands].append(self.cards.pop())
        return dealt


PIPS = {1: [(0, 0)], 2: [(-1, -1), (1, 1)], 3: [(-1, -1), (0, 0), (1, 1)], 4: [(-1, -1), (-1, 1), (1, -1), (1, 1)],
        5: [(-1, -1), (-1, 1), (1, -1), (1, 1), (0, 0)], 6: [(-1, y) for y in (-1, 0, 1)] + [(1, y) for y in (-1, 0, 1)]}


@register()
def die(value: int) -> Shape:
    cube = primitive_call('cube', color=(0.95, 0.95, 0.9), shape_kwargs={'scale': (0.5, 0.5, 0.5)})
    pips = [transform_shape(primitive_call('sphere', color=(0.1, 0.1, 0.1), shape_kwargs={'radius': 0.05}), translation_matrix((0.13 * x, 0.25, 0.13 * z))) for x, z in PIPS[value]]
    return concat_shapes(cube, *pips)


@register()
def card(rank: int, color: tuple) -> Shape:
    paper = primitive_call('cube', color=(0.98, 0.98, 0.96), shape_kwargs={'scale': (0.6, 0.02, 0.9)})
    symbols = loop(rank, lambda i: transform_shape(primitive_call('cube', color=color, shape_kwargs={'scale': (0.1, 0.02, 0.1)}), translation_matrix((0.18 * (i % 3 - 1), 0.015, 0.25 * (i // 3 - 1)))))
    return concat_shapes(paper, symbols)


@register()
def game_table() -> Shape:
    shapes = [transform_shape(primitive_call('cylinder', color=(0.1, 0.4, 0.2), shape_kwargs={'radius': 4, 'p0': (0, -0.3, 0), 'p1': (0, 0, 0)}), identity_matrix())]
    for k in range(5):
        value = random.randint(1, 6)
        spot = (random.gauss(0, 0.8), 0.25, random.gauss(0, 0.8))
        shapes.append(transform_shape(library_call('die', value=value), translation_matrix(spot) @ rotation_matrix(random.random() * math.pi, (0, 1, 0), (0, 0, 0))))
    for h, hand in enumerate(Deck(seed=3).shuffled().deal(2, 4) + Deck().shuffled().deal(1, 5)):
        hand.sort(key=lambda c: (c.suit.name, c.rank))
        for i, (rank, suit) in enumerate(hand):
            pose = rotation_matrix(h * 2 * math.pi / 3, (0, 1, 0), (0, 0, 0)) @ translation_matrix((0.5 * i - 0.8, 0.02 + 0.02 * i, 2.8))
            shapes.append(transform_shape(library_call('card', rank=rank, color=suit.value), pose))
    return concat_shapes(*shapes)
