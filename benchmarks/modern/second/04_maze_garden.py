"""
a hedge maze garden with a golden path to the fountain in its middle
"""
from helper import *
import heapq
import random
from collections import defaultdict
from functools import lru_cache
from itertools import count

Cell = tuple[int, int]
SIZE = 9
HEDGE = (0.13, 0.38, 0.15)


def neighbours(c: Cell, n: int = SIZE):
    for dx, dz in ((1, 0), (-1, 0), (0, 1), (0, -1)):
        if 0 <= (x := c[0] + dx) < n and 0 <= (z := c[1] + dz) < n:
            yield x, z


@lru_cache(maxsize=None)
def carve(seed: int, n: int = SIZE) -> dict[Cell, frozenset[Cell]]:
    rng = random.Random(seed)
    links: defaultdict[Cell, set[Cell]] = defaultdict(set)
    stack, seen = [(0, 0)], {(0, 0)}
    while stack:
        here = stack[-1]
        options = [c for c in neighbours(here, n) if c not in seen]
        if not options:
            stack.pop()
            continue
        nxt = rng.choice(options)
        links[here].add(nxt)
        links[nxt].add(here)
        seen.add(nxt)
        stack.append(nxt)
    return {k: frozenset(v) for k, v in links.items()}


def astar(links, start: Cell, goal: Cell) -> list[Cell]:
    h = lambda c: abs(c[0] - goal[0]) + abs(c[1] - goal[1])
    tie = count()
    frontier = [(h(start), next(tie), start)]
    came: dict[Cell, Cell | None] = {start: None}
    cost = {start: 0}
    while frontier:
        _, _, cur = heapq.heappop(frontier)
        if cur == goal:
            break
        for nb in sorted(links[cur]):
            new = cost[cur] + 1
            if new < cost.get(nb, float('inf')):
                cost[nb] = new
                came[nb] = cur
                heapq.heappush(frontier, (new + h(nb), next(tie), nb))
    else:
        raise RuntimeError('no way through the maze')
    path = []
    node: Cell | None = goal
    while node is not None:
        path.append(node)
        node = came[node]
    return path[::-1]


@register()
def hedge_segment(length: float = 1.0, height: float = 0.8, along_x: bool = True) -> Shape:
    dims = (length, height, 0.15) if along_x else (0.15, height, length)
    return transform_shape(primitive_call('cube', {'scale': dims}, color=HEDGE), translation_matrix((0, height / 2, 0)))


@register()
def maze_hedges(seed: int = 3) -> Shape:
    links = carve(seed)
    out = []
    for x in range(SIZE):
        for z in range(SIZE):
            if (x + 1, z) not in links[(x, z)] and not (x == SIZE - 1 and z == SIZE - 1):
                out.append(transform_shape(library_call('hedge_segment', along_x=False), translation_matrix((x + 0.5, 0, z))))
            if (x, z + 1) not in links[(x, z)]:
                out.append(transform_shape(library_call('hedge_segment'), translation_matrix((x, 0, z + 0.5))))
    for i in range(SIZE):
        out.append(transform_shape(library_call('hedge_segment'), translation_matrix((i, 0, -0.5))))
        if i > 0:
            out.append(transform_shape(library_call('hedge_segment', along_x=False), translation_matrix((-0.5, 0, i))))
    return concat_shapes(*out)


@register()
def golden_path(seed: int = 3) -> Shape:
    mid = (SIZE // 2, SIZE // 2)
    route = astar(carve(seed), (0, 0), mid)
    assert route[0] == (0, 0) and route[-1] == mid
    return concat_shapes(*(
        transform_shape(primitive_call('cube', {'scale': (0.5, 0.04, 0.5)}, color=(0.85, 0.7, 0.3)),
                        translation_matrix((x, 0.02, z)))
        for x, z in route))


@register()
def fountain(tiers: int = 3) -> Shape:
    def tier(i: int) -> Shape:
        r = 0.4 / (1 + i)
        y = 0.25 * i
        return concat_shapes(
            primitive_call('cylinder', {'radius': r, 'p0': (0, y, 0), 'p1': (0, y + 0.08, 0)}, color=(0.75, 0.75, 0.72)),
            primitive_call('cylinder', {'radius': r * 0.85, 'p0': (0, y + 0.08, 0), 'p1': (0, y + 0.1, 0)}, color=(0.4, 0.65, 0.85)),
            primitive_call('cylinder', {'radius': 0.05, 'p0': (0, y, 0), 'p1': (0, y + 0.3, 0)}, color=(0.7, 0.7, 0.68)))
    return loop(tiers, tier)


@register()
def maze_garden(seed: int = 3) -> Shape:
    hedges = library_call('maze_hedges', seed=seed)
    lawn = primitive_call('cube', {'scale': (SIZE + 1, 0.1, SIZE + 1)}, color=(0.45, 0.62, 0.32))
    c = SIZE // 2
    lawn = transform_shape(lawn, translation_matrix((c, -0.05, c)))
    water = transform_shape(library_call('fountain'), translation_matrix((c, 0, c)))
    return concat_shapes(lawn, hedges, library_call('golden_path', seed=seed), water)
