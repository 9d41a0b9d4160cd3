"""a hanging mobile that is the Huffman tree of a word: heavy letters hang near the top"""
from __future__ import annotations

import heapq
from collections import Counter
from dataclasses import dataclass
from itertools import count
from typing import Iterator, Union

from helper import *

WORD = "abracadabra alakazam"


@dataclass(frozen=True)
class Leaf:
    weight: int
    letter: str


@dataclass(frozen=True)
class Branch:
    weight: int
    left: Tree
    right: Tree


Tree = Union[Leaf, Branch]


def huffman(text: str) -> Tree:
    ticket = count()  # equal weights: the older tree first
    heap: list[tuple[int, int, Tree]] = [(n, next(ticket), Leaf(n, letter)) for letter, n in sorted(Counter(text).items())]
    heapq.heapify(heap)
    while len(heap) > 1:
        (m, _, a), (n, _, b) = heapq.heappop(heap), heapq.heappop(heap)
        heapq.heappush(heap, (m + n, next(ticket), Branch(m + n, a, b)))
    return heap[0][-1]


def codes(tree: Tree, prefix: str = '') -> Iterator[tuple[str, str]]:
    match tree:
        case Leaf(letter=letter):
            yield letter, prefix or '0'
        case Branch(left=left, right=right):
            yield from codes(left, prefix + '0')
            yield from codes(right, prefix + '1')


def leaves(tree: Tree) -> int:
    return 1 if isinstance(tree, Leaf) else leaves(tree.left) + leaves(tree.right)


TREE = huffman(WORD)
CODE = dict(codes(TREE))


def string(a, b, radius=0.012, color=(0.3, 0.3, 0.3)):
    return primitive_call('cylinder', shape_kwargs={'radius': radius, 'p0': a, 'p1': b}, color=color)


@register("a letter: a ball as heavy as it is frequent, with its code as a chain of beads")
def pendant(letter: str = 'a', weight: int = 1) -> Shape:
    hue = (ord(letter) * 37 % 100) / 100
    radius = 0.12 * weight ** (1 / 3)
    ball = transform_shape(primitive_call('sphere', shape_kwargs={'radius': radius}, color=(0.9 - 0.6 * hue, 0.3 + 0.5 * hue, 0.4)), translation_matrix((0, -0.3 - radius, 0)))
    beads = []
    for i, bit in enumerate(CODE.get(letter, '')):
        color = (0.1, 0.1, 0.12) if bit == '1' else (0.95, 0.95, 0.95)
        bead = primitive_call('sphere', shape_kwargs={'radius': 0.045}, color=color)
        beads.append(transform_shape(bead, translation_matrix((0, -0.42 - 2 * radius - 0.1 * i, 0))))
    return concat_shapes(string((0, 0, 0), (0, -0.3, 0)), ball, *beads)


def hang(tree: Tree, depth: int = 0) -> Shape:
    """A subtree whose string begins at the origin."""
    if isinstance(tree, Leaf):
        return library_call('pendant', letter=tree.letter, weight=tree.weight)
    span = 0.34 * leaves(tree)
    # the arms balance: weight times arm is equal on both sides
    arm_left = span * tree.right.weight / tree.weight
    arm_right = span - arm_left
    drop = 0.45
    bar = string((-arm_left, -drop, 0), (arm_right, -drop, 0), 0.02, (0.75, 0.6, 0.3))
    knob = transform_shape(primitive_call('sphere', shape_kwargs={'radius': 0.04}, color=(0.8, 0.2, 0.2)), translation_matrix((0, -drop, 0)))
    children = [transform_shape(hang(child, depth + 1), translation_matrix((x, -drop, 0.08 * (-1) ** depth)))
                for child, x in ((tree.left, -arm_left), (tree.right, arm_right))]
    return concat_shapes(string((0, 0, 0), (0, -drop, 0)), bar, knob, *children)


@register("the word below as a strip of bits: high and low blocks")
def bit_strip(per_row: int = 20, size: float = 0.14) -> Shape:
    bits = ''.join(CODE[c] for c in WORD)
    shapes = []
    for i, bit in enumerate(bits):
        row, column = divmod(i, per_row)
        h = size * (1.5 if bit == '1' else 0.5)
        block = primitive_call('cube', shape_kwargs={'scale': (size * 0.9, h, size * 0.9)}, color=(0.2, 0.35, 0.6) if bit == '1' else (0.8, 0.85, 0.9))
        shapes.append(transform_shape(block, translation_matrix(((column - (per_row - 1) / 2) * size, h / 2, row * size))))
    return concat_shapes(*shapes)


@register()
def huffman_mobile() -> Shape:
    ceiling = primitive_call('cylinder', shape_kwargs={'radius': 0.5, 'p0': (0, 0, 0), 'p1': (0, 0.1, 0)}, color=(0.9, 0.9, 0.9))
    return concat_shapes(ceiling, hang(TREE), transform_shape(library_call('bit_strip'), translation_matrix((0, -5.0, 0))))
