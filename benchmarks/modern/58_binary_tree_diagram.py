"""a balanced binary search tree drawn in 3D with glowing nodes and edges"""
from __future__ import annotations
from helper import *
from dataclasses import dataclass
from typing import Iterator, Optional, Sequence
from bisect import bisect_left
import operator


@dataclass
class TreeNode:
    key: int
    left: Optional[TreeNode] = None
    right: Optional[TreeNode] = None

    @classmethod
    def from_sorted(cls, keys: Sequence[int]) -> Optional[TreeNode]:
        if not keys:
            return None
        mid = len(keys) // 2
        return cls(keys[mid], cls.from_sorted(keys[:mid]), cls.from_sorted(keys[mid + 1:]))

    def __iter__(self) -> Iterator[int]:
        if self.left:
            yield from self.left
        yield self.key
        if self.right:
            yield from self.right

    @property
    def height(self) -> int:
        return 1 + max((c.height for c in (self.left, self.right) if c), default=0)

    def walk(self, depth: int = 0, parent: Optional[TreeNode] = None):
        yield self, depth, parent
        for child in (self.left, self.right):
            if child is not None:
                yield from child.walk(depth + 1, self)


PRIMES = [n for n in range(2, 60) if all(n % d for d in range(2, int(n ** 0.5) + 1))]
ROOT = TreeNode.from_sorted(PRIMES[:15])
ORDER = list(ROOT)
assert all(map(operator.lt, ORDER, ORDER[1:])), "in-order walk must be sorted"


def place(node: TreeNode, depth: int) -> tuple[float, float, float]:
    rank = bisect_left(ORDER, node.key)
    return ((rank - len(ORDER) / 2) * 0.8, (ROOT.height - depth) * 1.2, 0.3 * (-1) ** depth)


@register()
def node_ball(key: int, depth: int) -> Shape:
    t = depth / (ROOT.height - 1)
    ball = primitive_call('sphere', shape_kwargs={'radius': 0.32 - 0.05 * depth}, color=(0.95 - 0.7 * t, 0.3 + 0.5 * t, 0.35))
    bits = f"{key:b}"
    dots = [transform_shape(primitive_call('cube', shape_kwargs={'scale': (0.07, 0.07, 0.07)}, color=(1, 1, 1) if b == '1' else (0.1, 0.1, 0.1)),
                            translation_matrix(((i - (len(bits) - 1) / 2) * 0.09, 0.42 - 0.05 * depth, 0))) for i, b in enumerate(bits)]
    return concat_shapes(ball, *dots)


@register()
def edge(a, b) -> Shape:
    return primitive_call('cylinder', shape_kwargs={'radius': 0.04, 'p0': a, 'p1': b}, color=(0.6, 0.6, 0.65))


@register()
def binary_tree() -> Shape:
    where: dict[int, tuple] = {}
    out = []
    for node, depth, parent in ROOT.walk():
        where[node.key] = p = place(node, depth)
        out.append(transform_shape(library_call('node_ball', key=node.key, depth=depth), translation_matrix(p)))
        if parent:
            out.append(library_call('edge', a=where[parent.key], b=p))
    return concat_shapes(*out)
