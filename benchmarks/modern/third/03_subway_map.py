"""
a model of a subway network laid out by forces, stations as discs
"""
from helper import *
import math
import random
from collections import defaultdict, deque

LINES = {
    'red': 'A B C D E F',
    'blue': 'G C H I E J',
    'green': 'K H D L',
}
COLORS = {'red': (0.85, 0.15, 0.15), 'blue': (0.15, 0.3, 0.8), 'green': (0.1, 0.6, 0.3)}


def build_graph(lines: dict[str, str]) -> dict[str, set[str]]:
    graph: dict[str, set[str]] = defaultdict(set)
    for stops in map(str.split, lines.values()):
        for a, b in zip(stops, stops[1:]):
            graph[a].add(b)
            graph[b].add(a)
    return graph


def layout(graph: dict[str, set[str]], steps: int = 60, k: float = 1.5) -> dict[str, tuple[float, float]]:
    rng = random.Random(5)
    pos = {name: (rng.uniform(-3, 3), rng.uniform(-3, 3)) for name in sorted(graph)}
    temperature = 1.0
    for _ in range(steps):
        moves = {name: [0.0, 0.0] for name in pos}
        for a in pos:
            for b in pos:
                if a == b:
                    continue
                dx, dy = pos[a][0] - pos[b][0], pos[a][1] - pos[b][1]
                d = math.hypot(dx, dy) or 1e-6
                f = k * k / d
                if b in graph[a]:
                    f -= d * d / k
                moves[a][0] += dx / d * f
                moves[a][1] += dy / d * f
        for name, (mx, my) in moves.items():
            length = math.hypot(mx, my) or 1e-6
            step = min(length, temperature)
            x, y = pos[name]
            pos[name] = (x + mx / length * step, y + my / length * step)
        temperature *= 0.95
    return pos


def distances(graph, start: str) -> dict[str, int]:
    seen = {start: 0}
    queue = deque([start])
    while queue:
        here = queue.popleft()
        for there in sorted(graph[here]):
            if there not in seen:
                seen[there] = seen[here] + 1
                queue.append(there)
    return seen


GRAPH = build_graph(LINES)
POSITIONS = layout(GRAPH)
HOPS = distances(GRAPH, 'A')


@register()
def station(name: str = 'A', base: float = 0.25) -> Shape:
    degree = len(GRAPH[name])
    platform = primitive_call('cylinder', color=(0.95, 0.95, 0.95), shape_kwargs={'radius': base + 0.05 * degree, 'p0': (0, 0, 0), 'p1': (0, 0.15, 0)})
    tower = primitive_call('cylinder', color=(0.3, 0.3, 0.35), shape_kwargs={'radius': 0.08, 'p0': (0, 0.15, 0), 'p1': (0, 0.3 + 0.15 * HOPS[name], 0)})
    return concat_shapes(platform, tower)


@register()
def track(a: tuple = (0, 0), b: tuple = (1, 0), color: tuple = (1, 0, 0), offset: float = 0.0) -> Shape:
    return primitive_call('cylinder', color=color, shape_kwargs={'radius': 0.07, 'p0': (a[0], 0.05 + offset, a[1]), 'p1': (b[0], 0.05 + offset, b[1])})


@register()
def subway() -> Shape:
    parts = []
    for n, (color, stops) in enumerate(LINES.items()):
        names = stops.split()
        parts += [library_call('track', a=POSITIONS[p], b=POSITIONS[q], color=COLORS[color], offset=0.02 * n) for p, q in zip(names, names[1:])]
    for name, (x, z) in POSITIONS.items():
        parts.append(transform_shape(library_call('station', name=name), translation_matrix((x, 0, z))))
    ground = transform_shape(primitive_call('cube', color=(0.8, 0.78, 0.72), shape_kwargs={'scale': (12, 0.1, 12)}), translation_matrix((0, -0.05, 0)))
    return concat_shapes(ground, *parts)
