from helper import *

"""
an orchard of binary search trees walked by recursive generators
"""

class Node:
    def __init__(self, key, left=None, right=None):
        self.key, self.left, self.right = key, left, right

    def insert(self, key):
        side = "left" if key < self.key else "right"
        child = getattr(self, side)
        if child is None:
            setattr(self, side, Node(key))
        else:
            child.insert(key)

    def __iter__(self):
        if self.left:
            yield from self.left
        yield self.key
        if self.right:
            yield from self.right

    def layout(self, depth=0, x=0.0, spread=1.6):
        """Yields (node, x, y, parent position)."""
        here = (x, -depth * 0.8)
        yield self, here, None
        for child, sign in ((self.left, -1), (self.right, 1)):
            if child is not None:
                for node, position, parent in child.layout(depth + 1, x + sign * spread, spread / 2):
                    yield node, position, parent or here

def running_mean():
    """A coroutine: send numbers, receive the mean so far."""
    total, n, mean = 0.0, 0, None
    while True:
        value = yield mean
        total += value
        n += 1
        mean = total / n

def delegate(*trees):
    sizes = 0
    for tree in trees:
        size = yield from walk(tree)
        sizes += size
    return sizes

def walk(tree):
    n = 0
    for key in tree:
        yield key
        n += 1
    return n

@register()
def tree_shape(root: Node, mean: float) -> Shape:
    parts = []
    for node, (x, y), parent in root.layout():
        color = (0.9, 0.3, 0.2) if node.key > mean else (0.3, 0.6, 0.9)
        parts.append(transform_shape(primitive_call('sphere', color=color, shape_kwargs={'radius': 0.1 + 0.01 * node.key}), translation_matrix((x, y, 0))))
        if parent:
            parts.append(primitive_call('cylinder', color=(0.4, 0.3, 0.2), shape_kwargs={'radius': 0.03, 'p0': (*parent, 0), 'p1': (x, y, 0)}))
    return concat_shapes(*parts)

@register()
def orchard() -> Shape:
    trees = []
    for seed, *rest in ([8, 3, 10, 1, 6, 14, 4, 7], [5, 2, 9], [7, 12, 9, 15, 1]):
        root = Node(seed)
        for key in rest:
            root.insert(key)
        trees.append(root)
    mean = running_mean()
    next(mean)
    averages = []
    for root in trees:
        for key in root:
            average = mean.send(key)
        averages.append(average)
    mean.close()
    keys, generator = [], delegate(*trees)
    while True:
        try:
            keys.append(next(generator))
        except StopIteration as stop:
            count = stop.value
            break
    beads = [transform_shape(primitive_call('cube', color=(0.2, 0.7, 0.3), shape_kwargs={'scale': (0.2, 0.1 * k, 0.2)}), translation_matrix((0.3 * i, -4 + 0.05 * k, 1))) for i, k in enumerate(keys[:count])]
    return concat_shapes(*beads, *[transform_shape(library_call('tree_shape', root=r, mean=m), translation_matrix((5 * i, 0, 0))) for i, (r, m) in enumerate(zip(trees, averages))])
