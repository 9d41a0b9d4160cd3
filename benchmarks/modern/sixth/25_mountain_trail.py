"""a mountain landscape with the easiest trail from the valley to the summit hut"""
from helper import *
import heapq
import math
from functools import lru_cache

N = 18
PEAKS = [(12.5, 4.5, 4.2, 3.5), (4.0, 3.0, 2.2, 2.5), (13.0, 13.5, 2.6, 3.0), (5.0, 12.0, 1.5, 2.8)]  # x, z, height, spread


@lru_cache(maxsize=None)
def elevation(x: int, z: int) -> float:
    hills = sum(h * math.exp(-((x - px) ** 2 + (z - pz) ** 2) / (2 * s * s)) for px, pz, h, s in PEAKS)
    return round(hills + 0.12 * math.sin(x * 1.7) * math.cos(z * 2.3) + 0.3, 3)


def cheapest(start: tuple[int, int], goal: tuple[int, int], steepness: float = 12.0):
    """Dijkstra's algorithm: a climb costs more than a detour."""
    best = {start: 0.0}
    previous = {}
    heap = [(0.0, start)]
    while heap:
        cost, (x, z) = heapq.heappop(heap)
        if (x, z) == goal:
            break
        if cost > best[(x, z)]:
            continue
        for dx, dz in ((1, 0), (-1, 0), (0, 1), (0, -1)):
            there = (x + dx, z + dz)
            if not (0 <= there[0] < N and 0 <= there[1] < N):
                continue
            slope = elevation(*there) - elevation(x, z)
            if (total := cost + 1 + steepness * slope * slope) < best.get(there, math.inf):
                best[there] = total
                previous[there] = (x, z)
                heapq.heappush(heap, (total, there))
    path = [goal]
    while path[-1] != start:
        path.append(previous[path[-1]])
    path.reverse()
    return path, best[goal]


def tint(h: float):
    for limit, color in ((0.6, (0.3, 0.5, 0.75)), (1.4, (0.35, 0.6, 0.3)), (2.4, (0.45, 0.5, 0.3)), (3.4, (0.5, 0.47, 0.45))):
        if h < limit:
            return color
    return (0.95, 0.96, 0.98)


def at(x: float, z: float, y: float):
    return (x - (N - 1) / 2, y, z - (N - 1) / 2)


@register("the land as columns")
def terrain() -> Shape:
    columns = []
    for i in range(N * N):
        z, x = divmod(i, N)
        h = elevation(x, z)
        column = primitive_call('cube', shape_kwargs={'scale': (1, h, 1)}, color=tint(h))
        columns.append(transform_shape(column, translation_matrix(at(x, z, h / 2))))
    return concat_shapes(*columns)


@register("a trail of red rods with posts")
def trail() -> Shape:
    path, cost = cheapest((0, N - 1), (12, 4))
    points = [at(x, z, elevation(x, z) + 0.08) for x, z in path]
    rods = [primitive_call('cylinder', shape_kwargs={'radius': 0.07, 'p0': a, 'p1': b}, color=(0.85, 0.2, 0.15)) for a, b in zip(points, points[1:])]
    posts = []
    for x, y, z in points[::4]:
        posts.append(primitive_call('cylinder', shape_kwargs={'radius': 0.05, 'p0': (x, y, z), 'p1': (x, y + 0.5, z)}, color=(0.95, 0.95, 0.9)))
    # the flag at the end is higher the more the way costs
    x, y, z = points[-1]
    mast = primitive_call('cylinder', shape_kwargs={'radius': 0.04, 'p0': (x, y, z), 'p1': (x, y + cost / 30, z)}, color=(0.2, 0.2, 0.2))
    return concat_shapes(*rods, *posts, mast)


@register()
def hut(size: float = 0.7) -> Shape:
    walls = transform_shape(primitive_call('cube', shape_kwargs={'scale': (size, size * 0.6, size)}, color=(0.5, 0.32, 0.18)), translation_matrix((0, size * 0.3, 0)))
    roof = [transform_shape(primitive_call('cube', shape_kwargs={'scale': (size * (1.2 - 0.3 * k), size * 0.12, size * 1.1)}, color=(0.7, 0.15, 0.12)),
                            translation_matrix((0, size * (0.66 + 0.12 * k), 0))) for k in range(4)]
    return concat_shapes(walls, *roof)


@register()
def mountain_trail() -> Shape:
    x, y, z = at(13, 4, elevation(13, 4))
    water = transform_shape(primitive_call('cube', shape_kwargs={'scale': (N, 0.4, N)}, color=(0.2, 0.4, 0.7)), translation_matrix((0, 0.2, 0)))
    return concat_shapes(library_call('terrain'), water, library_call('trail'), transform_shape(library_call('hut'), translation_matrix((x, y, z))))
