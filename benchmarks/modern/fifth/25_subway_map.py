"""a 3D subway map with three lines, interchange stations and the shortest route highlighted"""
from helper import *
from collections import defaultdict
from dataclasses import dataclass, field
import heapq
import math
import re

NETWORK = """
# line color : station(x,z,depth) - ...
red    #d7263d : Airport(-6,-3,0) - Museum(-3,-2,1) - Central(0,0,2) - Opera(2,1,2) - Harbor(5,2,1)
blue   #1b6ca8 : Zoo(-4,4,1) - Park(-2,2,2) - Central(0,0,2) - University(2,-2,3) - Stadium(4,-4,1)
green  #2a9d55 : Museum(-3,-2,1) - Market(-1,-4,2) - University(2,-2,3) - Opera(2,1,2) - Lake(1,4,1) - Park(-2,2,2)
"""
STATION = re.compile(r'(?P<name>\w+)\((?P<xyz>[^)]*)\)')


def hex_color(text: str) -> tuple[float, ...]:
    return tuple(int(text[i:i + 2], 16) / 255 for i in (1, 3, 5))


@dataclass(order=True)
class Station:
    name: str
    position: tuple[float, float, float] = field(compare=False)
    lines: list[str] = field(default_factory=list, compare=False)

    @property
    def is_interchange(self) -> bool:
        return len(self.lines) > 1


class Network:
    def __init__(self, text: str):
        self.stations: dict[str, Station] = {}
        self.colors: dict[str, tuple[float, ...]] = {}
        self.edges: defaultdict[str, dict[str, str]] = defaultdict(dict)
        for raw in text.strip().splitlines():
            if not raw.strip() or raw.startswith('#'):
                continue
            head, _, tail = raw.partition(' : ')
            line, color = head.split()
            self.colors[line] = hex_color(color)
            self._add_line(line, tail)

    def _add_line(self, line: str, tail: str) -> None:
        previous = None
        for m in STATION.finditer(tail):
            x, z, depth = map(float, m['xyz'].split(','))
            station = self.stations.setdefault(m['name'], Station(m['name'], (x, -depth, z)))
            station.lines.append(line)
            if previous is not None:
                self.edges[previous][station.name] = line
                self.edges[station.name][previous] = line
            previous = station.name

    def distance(self, a: str, b: str) -> float:
        return math.dist(self.stations[a].position, self.stations[b].position)

    def route(self, start: str, goal: str, change_penalty: float = 2.0) -> list[str]:
        """Dijkstra over (station, line) so that a change of line costs something."""
        queue: list[tuple[float, str, str, tuple[str, ...]]] = [(0.0, start, '', (start,))]
        done: set[tuple[str, str]] = set()
        while queue:
            cost, here, line, path = heapq.heappop(queue)
            if here == goal:
                return list(path)
            if (here, line) in done:
                continue
            done.add((here, line))
            for there, via in self.edges[here].items():
                extra = change_penalty if line and via != line else 0.0
                heapq.heappush(queue, (cost + self.distance(here, there) + extra, there, via, (*path, there)))
        raise LookupError(f'no way from {start} to {goal}')


METRO = Network(NETWORK)


@register()
def track(a: str = 'Central', b: str = 'Opera', radius: float = 0.12, sleepers: bool = True) -> Shape:
    p, q = METRO.stations[a].position, METRO.stations[b].position
    tunnel = primitive_call('cylinder', shape_kwargs={'radius': radius, 'p0': p, 'p1': q}, color=METRO.colors[METRO.edges[a][b]])
    if not sleepers:
        return tunnel
    n = max(2, round(math.dist(p, q) / 0.6))
    rings = [tuple(u + (v - u) * k / n for u, v in zip(p, q)) for k in range(1, n)]
    return concat_shapes(tunnel, *[transform_shape(primitive_call('sphere', shape_kwargs={'radius': radius * 1.25}, color=(0.9, 0.9, 0.9)), translation_matrix(r)) for r in rings])


@register()
def station_marker(name: str = 'Central') -> Shape:
    s = METRO.stations[name]
    x, y, z = s.position
    r = 0.22 + 0.08 * (len(s.lines) - 1)
    discs = [primitive_call('cylinder', shape_kwargs={'radius': r, 'p0': (x, y - 0.06 + 0.12 * k, z), 'p1': (x, y + 0.06 + 0.12 * k, z)}, color=METRO.colors[line]) for k, line in enumerate(s.lines)]
    lift = primitive_call('cylinder', shape_kwargs={'radius': 0.03, 'p0': (x, y, z), 'p1': (x, 0.5, z)}, color=(0.6, 0.6, 0.65))
    sign = transform_shape(primitive_call('cube', shape_kwargs={'scale': (0.07 * len(name), 0.2, 0.05)}, color=(1, 1, 1) if s.is_interchange else (0.75, 0.8, 0.85)), translation_matrix((x, 0.6, z)))
    return concat_shapes(*discs, lift, sign)


@register()
def route_glow(start: str = 'Airport', goal: str = 'Stadium', penalty: float = 2.0) -> Shape:
    try:
        stops = METRO.route(start, goal, penalty)
    except LookupError as error:
        print(f'warning: {error}')
        return concat_shapes()
    points = [METRO.stations[s].position for s in stops]
    return concat_shapes(*(primitive_call('cylinder', shape_kwargs={'radius': 0.05, 'p0': (a[0], a[1] + 0.25, a[2]), 'p1': (b[0], b[1] + 0.25, b[2])}, color=(1, 0.85, 0.1)) for a, b in zip(points, points[1:])))


@register()
def subway_map() -> Shape:
    seen = sorted({tuple(sorted((a, b))) for a, nb in METRO.edges.items() for b in nb})
    tracks = [library_call('track', a=a, b=b, sleepers=(i % 2 == 0)) for i, (a, b) in enumerate(seen)]
    stations = [library_call('station_marker', name=s.name) for s in sorted(METRO.stations.values())]
    glow = library_call('route_glow', start='Airport', goal='Stadium')
    base = transform_shape(primitive_call('cube', shape_kwargs={'scale': (14, 0.1, 11)}, color=(0.18, 0.2, 0.24)), translation_matrix((0, -3.6, 0)))
    return concat_shapes(base, *tracks, *stations, glow)
