from collections import defaultdict, deque
from helper import *

"""
a river delta: a flow network filled by breadth first traversal
"""

EDGES = [
    ("spring", "fall", 5), ("fall", "fork", 5), ("fork", "west", 2), ("fork", "east", 3),
    ("west", "marsh", 1), ("west", "bay", 1), ("east", "bay", 1), ("east", "port", 2), ("marsh", "sea", 1), ("bay", "sea", 2), ("port", "sea", 2),
]


def adjacency(edges) -> dict[str, list[tuple[str, int]]]:
    graph = defaultdict(list)
    for a, b, flow in edges:
        graph[a].append((b, flow))
    return graph


def levels(graph, start: str) -> dict[str, int]:
    depth = {start: 0}
    queue = deque([start])
    while queue:
        node = queue.popleft()
        for neighbor, _ in graph[node]:
            depth[neighbor] = max(depth.get(neighbor, 0), depth[node] + 1)
            queue.append(neighbor)
    return depth


def positions(depth: dict[str, int]) -> dict[str, tuple[float, float, float]]:
    rows: defaultdict[int, list[str]] = defaultdict(list)
    for name, d in depth.items():
        rows[d].append(name)
    return {name: (2.0 * (i - (len(names) - 1) / 2), 3 - 0.6 * d, 1.6 * d) for d, names in rows.items() for i, name in enumerate(names)}


@register()
def stream(a: tuple, b: tuple, flow: int) -> Shape:
    return primitive_call('cylinder', color=(0.2, 0.45, 0.8), shape_kwargs={'radius': 0.06 * flow, 'p0': a, 'p1': b})


@register()
def settlement(size: int) -> Shape:
    houses: deque = deque(maxlen=4)
    for i in range(size):
        house = primitive_call('cube', color=(0.8, 0.6, 0.4), shape_kwargs={'scale': (0.25, 0.2 + 0.05 * i, 0.25)})
        houses.append(transform_shape(house, translation_matrix((0.3 * i, 0.2, 0.5))))
    houses.rotate(1)
    return concat_shapes(*houses) if houses else []


@register()
def delta() -> Shape:
    graph = adjacency(EDGES)
    where = positions(levels(graph, "spring"))
    arriving = defaultdict(int)
    for _, b, flow in EDGES:
        arriving[b] += flow
    shapes = []
    for a, targets in list(graph.items()):
        for b, flow in targets:
            shapes.append(library_call('stream', a=where[a], b=where[b], flow=flow))
    for name, place in where.items():
        lake = primitive_call('sphere', color=(0.15, 0.35, 0.7), shape_kwargs={'radius': 0.15 + 0.05 * arriving[name]})
        shapes.append(transform_shape(concat_shapes(lake, library_call('settlement', size=len(name))), translation_matrix(place)))
    recent = deque(where, maxlen=3)
    recent.appendleft("source")
    recent.extend("ab")
    shapes.append(primitive_call('cylinder', color=(0.5, 0.5, 0.5), shape_kwargs={'radius': 0.1, 'p0': (0, 3, 0), 'p1': (0, 3 + 0.1 * sum(map(len, recent)), 0)}))
    return concat_shapes(*shapes)
