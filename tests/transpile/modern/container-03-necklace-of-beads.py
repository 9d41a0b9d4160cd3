from helper import *

"""
bead chains: a linked list with iterator protocol
"""

class Node:
    def __init__(self, color, size, next_node=None):
        self.color = color
        self.size = size
        self.next = next_node

class Chain:
    def __init__(self):
        self.head = None
        self.count = 0

    def push(self, color, size):
        self.head = Node(color, size, self.head)
        self.count += 1
        return self

    def reverse(self):
        previous, node = None, self.head
        while node:
            node.next, previous, node = previous, node, node.next
        self.head = previous
        return self

    def __iter__(self):
        return ChainIterator(self.head)

    def __len__(self):
        return self.count

    def __reversed__(self):
        return iter(list(self)[::-1])

    def __eq__(self, other):
        return isinstance(other, Chain) and len(self) == len(other) and all(a.size == b.size for a, b in zip(self, other))

class ChainIterator:
    def __init__(self, node):
        self.node = node

    def __iter__(self):
        return self

    def __next__(self):
        if self.node is None:
            raise StopIteration
        node, self.node = self.node, self.node.next
        return node

@register()
def hanging_chain(chain, span: float, sag: float) -> Shape:
    n = len(chain)
    shapes = []
    for i, bead in enumerate(chain):
        t = (i + 0.5) / n * 2 - 1
        bead_shape = primitive_call('sphere', color=bead.color, shape_kwargs={'radius': bead.size})
        shapes.append(transform_shape(bead_shape, translation_matrix((t * span / 2, sag * (t ** 2 - 1), 0))))
    return concat_shapes(*shapes)

@register()
def jewelry_stand() -> Shape:
    gold, pearl, ruby = (0.9, 0.75, 0.3), (0.95, 0.93, 0.9), (0.7, 0.05, 0.15)
    first, second = Chain(), Chain()
    for i in range(15):
        first.push((gold, pearl)[i % 2], 0.05 + 0.005 * i)
    for bead in reversed(first):
        second.push(ruby if bead.color == gold else pearl, bead.size)
    second.push(ruby, 0.15)
    same_before = first == second
    iterator = iter(first.reverse())
    largest = max(next(iterator).size, next(iterator, None).size)
    posts = [primitive_call('cylinder', color=(0.2, 0.2, 0.2), shape_kwargs={'radius': largest, 'p0': (x, -2, 0), 'p1': (x, 0.3, 0)}) for x in (-1.5, 1.5)]
    return concat_shapes(
        *posts,
        library_call('hanging_chain', chain=first, span=3, sag=0.7 if same_before else 0.8),
        library_call('hanging_chain', chain=second.reverse(), span=2.9, sag=1.5),
    )
