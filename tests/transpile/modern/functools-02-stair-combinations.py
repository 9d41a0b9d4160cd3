from functools import cache, cmp_to_key, partialmethod
from helper import *

"""
towers that show how many ways there are to climb n steps
"""

@cache
def ways(n: int, jumps: tuple = (1, 2)) -> int:
    if n < 0:
        return 0
    if n == 0:
        return 1
    return sum(ways(n - j, jumps) for j in jumps)

@cache
def all_paths(n: int) -> tuple:
    if n == 0:
        return ((),)
    return tuple((j,) + rest for j in (1, 2) if j <= n for rest in all_paths(n - j))

def compare(a: tuple, b: tuple) -> int:
    """Shorter paths first, then those with a late long jump."""
    if len(a) != len(b):
        return len(a) - len(b)
    return (a > b) - (a < b)

class Tower:
    def __init__(self):
        self.levels = []

    def block(self, width: float, color: tuple):
        self.levels.append((width, color))

    wide = partialmethod(block, 0.9, (0.3, 0.5, 0.8))
    narrow = partialmethod(block, 0.5, (0.9, 0.6, 0.2))

    def draw(self) -> Shape:
        return loop(len(self.levels), lambda i: transform_shape(
            primitive_call('cube', color=self.levels[i][1], shape_kwargs={'scale': (self.levels[i][0], 0.4, self.levels[i][0])}), translation_matrix((0, 0.2 + 0.4 * i, 0))))

@register()
def path_tower(path: tuple) -> Shape:
    tower = Tower()
    for jump in path:
        (tower.narrow if jump == 1 else tower.wide)()
    return tower.draw()

@register()
def steps_exhibit(n: int = 6) -> Shape:
    paths = sorted(all_paths(n), key=cmp_to_key(compare))
    assert len(paths) == ways(n)
    cols = 5
    shapes = []
    for i, path in enumerate(paths):
        row, col = divmod(i, cols)
        shapes.append(transform_shape(library_call('path_tower', path=path), translation_matrix((1.2 * col, 0, 1.2 * row))))
    for k in range(1, 9):
        bar = 0.02 * ways(k, (1, 2, 3))
        shapes.append(transform_shape(primitive_call('cube', color=(0.2, 0.7, 0.4), shape_kwargs={'scale': (0.3, bar, 0.3)}), translation_matrix((0.5 * k, bar / 2, -1.2))))
    return concat_shapes(*shapes)
