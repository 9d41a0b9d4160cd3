"""a hedge maze with the shortest path marked by golden stones"""
from helper import *
from collections import deque

MAZE = """
#####################
#S..#.....#.........#
###.#.###.#.#####.#.#
#...#.#.....#...#.#.#
#.###.#######.#.#.#.#
#.....#.......#...#.#
#.#####.###########.#
#.......#...........#
#.#######.#########.#
#.........#........E#
#####################
""".strip()


class Grid:
    def __init__(self, text: str):
        self.rows = text.splitlines()
        self.height, self.width = len(self.rows), len(self.rows[0])

    def __getitem__(self, pos):
        r, c = pos
        return self.rows[r][c]

    def __iter__(self):
        for r, row in enumerate(self.rows):
            for c, ch in enumerate(row):
                yield (r, c), ch

    def find(self, target: str) -> tuple[int, int]:
        return next(pos for pos, ch in self if ch == target)

    def neighbors(self, pos):
        r, c = pos
        for dr, dc in ((0, 1), (1, 0), (0, -1), (-1, 0)):
            nxt = (r + dr, c + dc)
            if self[nxt] != '#':
                yield nxt

    def shortest_path(self):
        start, goal = self.find('S'), self.find('E')
        came_from = {start: None}
        queue = deque([start])
        while queue:
            cur = queue.popleft()
            if cur == goal:
                break
            for nxt in self.neighbors(cur):
                if nxt not in came_from:
                    came_from[nxt] = cur
                    queue.append(nxt)
        else:
            raise ValueError("maze has no solution")
        path = []
        node = goal
        while node is not None:
            path.append(node)
            node = came_from[node]
        return path[::-1]

    def world(self, pos, y=0.0):
        r, c = pos
        return (c - (self.width - 1) / 2, y, r - (self.height - 1) / 2)


GRID = Grid(MAZE)


@register()
def hedge(pos: tuple, height: float = 1.0) -> Shape:
    block = primitive_call('cube', shape_kwargs={'scale': (1, height, 1)}, color=(0.13, 0.42, 0.16))
    return transform_shape(block, translation_matrix(GRID.world(pos, height / 2)))


@register()
def stepping_stone(pos: tuple, radius: float = 0.18) -> Shape:
    x, _, z = GRID.world(pos)
    return primitive_call('cylinder', shape_kwargs={'radius': radius, 'p0': (x, 0, z), 'p1': (x, 0.05, z)}, color=(0.95, 0.78, 0.2))


@register()
def flag(pos: tuple, color=(0.9, 0.1, 0.1)) -> Shape:
    x, _, z = GRID.world(pos)
    pole = primitive_call('cylinder', shape_kwargs={'radius': 0.05, 'p0': (x, 0, z), 'p1': (x, 1.8, z)}, color=(0.8, 0.8, 0.8))
    cloth = primitive_call('cube', shape_kwargs={'scale': (0.6, 0.4, 0.03)}, color=color)
    return concat_shapes(pole, transform_shape(cloth, translation_matrix((x + 0.3, 1.6, z))))


@register()
def hedge_maze() -> Shape:
    lawn = primitive_call('cube', shape_kwargs={'scale': (GRID.width + 2, 0.1, GRID.height + 2)}, color=(0.55, 0.48, 0.35))
    walls = [library_call('hedge', pos=p) for p, ch in GRID if ch == '#']
    path = GRID.shortest_path()
    stones = [library_call('stepping_stone', pos=p) for p in path[1:-1]]
    flags = [library_call('flag', pos=path[0], color=(0.1, 0.4, 0.9)), library_call('flag', pos=path[-1])]
    return concat_shapes(transform_shape(lawn, translation_matrix((0, -0.05, 0))), *walls, *stones, *flags)
