"""
a house of cards four storeys high
"""
from helper import *
import math
from dataclasses import dataclass
from enum import Enum
from itertools import product
import random


class Suit(Enum):
    SPADES = ('♠', False)
    HEARTS = ('♥', True)
    DIAMONDS = ('♦', True)
    CLUBS = ('♣', False)

    def __init__(self, sign: str, red: bool):
        self.sign = sign
        self.red = red

    @property
    def ink(self):
        return (0.8, 0.1, 0.12) if self.red else (0.08, 0.08, 0.1)


@dataclass(frozen=True)
class Card:
    rank: int
    suit: Suit

    def __str__(self) -> str:
        name = {1: 'A', 11: 'J', 12: 'Q', 13: 'K'}.get(self.rank, str(self.rank))
        return name + self.suit.sign


class Deck:
    def __init__(self, seed: int = 0):
        self._cards = [Card(r, s) for s, r in product(Suit, range(1, 14))]
        random.Random(seed).shuffle(self._cards)

    def __iter__(self):
        return self

    def __next__(self) -> Card:
        try:
            return self._cards.pop()
        except IndexError:
            raise StopIteration from None

    def __len__(self):
        return len(self._cards)


W, H, THICK = 0.7, 1.0, 0.012
LEAN = math.radians(18)


@register()
def playing_card(rank: int = 1, suit: str = 'SPADES') -> Shape:
    ink = Suit[suit].ink
    face = primitive_call('cube', {'scale': (W, H, THICK)}, color=(0.98, 0.98, 0.96))
    back = transform_shape(primitive_call('cube', {'scale': (W * 0.9, H * 0.92, 0.004)}, color=(0.15, 0.25, 0.6)), translation_matrix((0, 0, -THICK / 2)))
    cols = 1 if rank < 4 else 2
    rows = math.ceil(min(rank, 10) / cols)
    pips = []
    for k in range(min(rank, 10)):
        r, c = divmod(k, cols)
        x = 0 if cols == 1 else (c - 0.5) * W * 0.4
        y = 0 if rows == 1 else (r / (rows - 1) - 0.5) * H * 0.6
        pip = primitive_call('cube', {'scale': (0.07, 0.07, 0.004)}, color=ink)
        pip = transform_shape(pip, rotation_matrix(math.pi / 4, (0, 0, 1), (0, 0, 0)))
        pips.append(transform_shape(pip, translation_matrix((x, y, THICK / 2))))
    return concat_shapes(face, back, *pips)


def stood(card: Card, sign: int) -> Shape:
    s = transform_shape(library_call('playing_card', rank=card.rank, suit=card.suit.name), rotation_matrix(math.pi / 2, (0, 1, 0), (0, 0, 0)))
    s = transform_shape(s, translation_matrix((0, H / 2, 0)))
    foot = H * math.sin(LEAN)
    s = transform_shape(s, rotation_matrix(-sign * LEAN, (0, 0, 1), (0, 0, 0)))
    return transform_shape(s, translation_matrix((-sign * foot, 0, 0)))


def flat(card: Card) -> Shape:
    s = library_call('playing_card', rank=card.rank, suit=card.suit.name)
    s = transform_shape(s, rotation_matrix(math.pi / 2, (0, 0, 1), (0, 0, 0)))
    return transform_shape(s, rotation_matrix(-math.pi / 2, (1, 0, 0), (0, 0, 0)))


@register()
def house_of_cards(storeys: int = 4, seed: int = 21) -> Shape:
    deck = Deck(seed)
    pitch = 2 * H * math.sin(LEAN) + 0.04
    lift = H * math.cos(LEAN) + THICK * 2
    used, out = [], []
    for floor in range(storeys):
        n = storeys - floor
        for i in range(n):
            x = (i - (n - 1) / 2) * pitch
            pair = [next(deck) for _ in range(2)]
            used += pair
            out += [transform_shape(stood(c, s), translation_matrix((x, floor * lift, 0))) for c, s in zip(pair, (-1, 1))]
        for i in range(n - 1):
            used.append(c := next(deck))
            x = (i - (n - 2) / 2) * pitch
            out.append(transform_shape(flat(c), translation_matrix((x, (floor + 1) * lift - THICK, 0))))
    assert len(used) == storeys * (3 * storeys + 1) // 2, ' '.join(map(str, used))
    rest = len(deck)
    spare = primitive_call('cube', {'scale': (W, rest * THICK, H)}, color=(0.95, 0.95, 0.92))
    out.append(transform_shape(spare, translation_matrix((storeys * pitch * 0.8, rest * THICK / 2, 0.2))))
    return concat_shapes(*out)


@register()
def card_table(radius: float = 3.0) -> Shape:
    felt = primitive_call('cylinder', {'radius': radius, 'p0': (0, -0.1, 0), 'p1': (0, 0, 0)}, color=(0.1, 0.4, 0.22))
    rim = primitive_call('cylinder', {'radius': radius * 1.05, 'p0': (0, -0.2, 0), 'p1': (0, -0.05, 0)}, color=(0.4, 0.22, 0.1))
    return concat_shapes(felt, rim, library_call('house_of_cards'))
