"""
a sculpture of the Huffman tree of the word "mississippi river"
"""
from __future__ import annotations
from helper import *
import heapq
from collections import Counter
from dataclasses import dataclass, field
from functools import total_ordering
from itertools import count

_serial = count()


@total_ordering
@dataclass(eq=False)
class Node:
    weight: int
    symbol: str | None = None
    left: Node | None = None
    right: Node | None = None
    order: int = field(default_factory=lambda: next(_serial))
    x: float = 0.0
    depth: int = 0

    @property
    def is_leaf(self) -> bool:
        return self.symbol is not None

    def __lt__(self, other: Node) -> bool:
        return (self.weight, self.order) < (other.weight, other.order)

    def __eq__(self, other) -> bool:
        return isinstance(other, Node) and self.order == other.order

    def __add__(self, other: Node) -> Node:
        return Node(self.weight + other.weight, left=self, right=other)

    def __iter__(self):
        if self.left: yield from self.left
        yield self
        if self.right: yield from self.right


def build(text: str) -> Node:
    heap = [Node(n, s) for s, n in sorted(Counter(text).items())]
    heapq.heapify(heap)
    while len(heap) > 1:
        a, b = heapq.heappop(heap), heapq.heappop(heap)
        heapq.heappush(heap, a + b)
    return heap.pop()


def layout(root: Node) -> Node:
    columns = count()

    def visit(node: Node, depth: int) -> float:
        node.depth = depth
        node.x = float(next(columns)) if node.is_leaf else sum(visit(c, depth + 1) for c in (node.left, node.right)) / 2
        return node.x

    visit(root, 0)
    return root


def codes(node: Node, prefix: str = '') -> dict[str, str]:
    if node.is_leaf:
        return {node.symbol: prefix or '0'}
    return codes(node.left, prefix + '0') | codes(node.right, prefix + '1')


@register()
def tree_node(weight: int = 1, leaf: bool = False) -> Shape:
    r = 0.16 + 0.05 * weight ** 0.5
    return primitive_call('sphere', {'radius': r}, color=(0.25, 0.65, 0.45) if leaf else (0.85, 0.6, 0.25))


@register()
def code_stack(bits: str = '0101', pitch: float = 0.22) -> Shape:
    palette = {'0': (0.9, 0.9, 0.92), '1': (0.15, 0.15, 0.2)}
    return concat_shapes(*[transform_shape(primitive_call('cube', {'scale': (0.3, pitch * 0.85, 0.3)}, color=palette[b]),
                                           translation_matrix((0, -i * pitch, 0))) for i, b in enumerate(bits)])


@register()
def huffman_tree(text: str = 'mississippi river', level: float = 1.1) -> Shape:
    root = layout(build(text))
    table = codes(root)
    encoded = ''.join(table[c] for c in text)
    assert len(encoded) < 8 * len(text), f'{len(encoded)} bits'
    where = lambda n: (n.x, -n.depth * level, 0.0)
    out = []
    for node in root:
        ball = library_call('tree_node', weight=node.weight, leaf=node.is_leaf)
        out.append(transform_shape(ball, translation_matrix(where(node))))
        for child in filter(None, (node.left, node.right)):
            out.append(primitive_call('cylinder', {'radius': 0.05, 'p0': where(node), 'p1': where(child)}, color=(0.5, 0.4, 0.3)))
        if node.is_leaf:
            x, y, z = where(node)
            out.append(transform_shape(library_call('code_stack', bits=table[node.symbol]), translation_matrix((x, y - 0.5, z))))
    return concat_shapes(*out)


@register()
def plinth(width: float = 8.0, height: float = 0.5) -> Shape:
    tiers = [(width + 1.0, 1.8), (width + 0.4, 1.3)]
    return concat_shapes(*(transform_shape(primitive_call('cube', {'scale': (w, height / 2, d)}, color=(0.35 + 0.1 * i,) * 3),
                                           translation_matrix((0, (i + 0.5) * height / 2, 0))) for i, (w, d) in enumerate(tiers)))


@register()
def huffman_sculpture() -> Shape:
    tree = library_call('huffman_tree')
    lo, size = compute_shape_min(tree), compute_shape_sizes(tree)
    centre = compute_shape_center(tree)
    tree = transform_shape(tree, translation_matrix((-centre[0], 0.7 - lo[1], 0)))
    posts = [primitive_call('cylinder', {'radius': 0.06, 'p0': (s * size[0] / 2, 0.4, -0.4), 'p1': (s * size[0] / 2, size[1] + 0.9, -0.4)}, color=(0.3, 0.3, 0.32))
             for s in (-1, 1)]
    beam = primitive_call('cylinder', {'radius': 0.06, 'p0': (-size[0] / 2, size[1] + 0.9, -0.4), 'p1': (size[0] / 2, size[1] + 0.9, -0.4)}, color=(0.3, 0.3, 0.32))
    return concat_shapes(library_call('plinth', width=float(size[0])), tree, *posts, beam)
