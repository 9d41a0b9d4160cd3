import heapq
from itertools import count
from collections import Counter
from helper import *

"""
a Huffman tree as a hanging sculpture
"""

def huffman(text):
    tiebreak = count()
    heap = [(n, next(tiebreak), ch) for ch, n in sorted(Counter(text).items())]
    heapq.heapify(heap)
    while len(heap) > 1:
        n1, _, left = heapq.heappop(heap)
        n2, _, right = heapq.heappop(heap)
        heapq.heappush(heap, (n1 + n2, next(tiebreak), (left, right)))
    return heap[0][2]

def codes(tree, prefix=""):
    if isinstance(tree, str):
        return {tree: prefix or "0"}
    left, right = tree
    return {**codes(left, prefix + "0"), **codes(right, prefix + "1")}

@register()
def subtree(tree, spread: float, level: int = 0) -> Shape:
    if isinstance(tree, str):
        shade = (ord(tree) % 13) / 13
        return primitive_call('sphere', color=(0.9, shade, 0.2), shape_kwargs={'radius': 0.2})
    knot = primitive_call('cube', color=(0.3, 0.3, 0.35), shape_kwargs={'scale': (0.15, 0.15, 0.15)})
    parts = [knot]
    for sign, child in zip((-1, 1), tree):
        offset = (sign * spread, -0.9, 0.2 * level * sign)
        parts.append(primitive_call('cylinder', color=(0.6, 0.6, 0.6), shape_kwargs={'radius': 0.03, 'p0': (0, 0, 0), 'p1': offset}))
        parts.append(transform_shape(library_call('subtree', tree=child, spread=spread * 0.55, level=level + 1), translation_matrix(offset)))
    return concat_shapes(*parts)

@register()
def code_strip(code: str) -> Shape:
    return loop(len(code), lambda i: transform_shape(
        primitive_call('cube', color=(0.1, 0.1, 0.1) if code[i] == "1" else (0.95, 0.95, 0.95), shape_kwargs={'scale': (0.2, 0.2, 0.1)}), translation_matrix((0.22 * i, 0, 0))))

@register()
def sculpture() -> Shape:
    text = "abracadabra simsalabim"
    tree = huffman(text)
    table = codes(tree)
    shapes = [library_call('subtree', tree=tree, spread=2.0)]
    ordered = sorted(table.items(), key=lambda item: (len(item[1]), item[1]))
    for k, (ch, code) in enumerate(ordered):
        shapes.append(transform_shape(library_call('code_strip', code=code), translation_matrix((4, -0.3 * k, 0))))
    bits = sum(len(table[ch]) for ch in text)
    merged = list(heapq.merge([1, 4, 9], [2, 4, 8], [len(table)]))
    smallest = heapq.heappushpop(merged, 0)
    bar = primitive_call('cube', color=(0.2, 0.5, 0.8), shape_kwargs={'scale': (bits / 20, 0.2, 0.1 * len(merged) + smallest)})
    return concat_shapes(*shapes, transform_shape(bar, translation_matrix((0, 1, 0))))
