from collections import namedtuple
from helper import *

"""
a three dimensional subway map
"""

Station = namedtuple("Station", "name x y lines", defaults=[()])
Line = namedtuple("Line", ["color", "depth"])

LINES = {"R": Line((0.9, 0.1, 0.1), 0.0), "G": Line((0.1, 0.7, 0.2), -0.6), "B": Line(color=(0.1, 0.3, 0.9), depth=-1.2)}

STATIONS = [
    Station("Airport", -3, 2, ("R",)),
    Station("Park", -1, 2, ("R", "G")),
    Station("Museum", 0, 1, ("R", "B")),
    Station("Opera", 1, 0, ("G", "B", "R")),
    Station("Harbor", 3, -1, ("B",)),
    Station("Stadium", 2, -2, ("G",)),
    Station(*"Depot 4 -3".split()[:1], 4, -3),
]

@register()
def platform(station) -> Shape:
    discs = []
    for name in station.lines:
        color, depth = LINES[name]
        discs.append(primitive_call('cylinder', color=(1, 1, 1), shape_kwargs={'radius': 0.2, 'p0': (0, depth - 0.04, 0), 'p1': (0, depth + 0.04, 0)}))
        discs.append(primitive_call('cylinder', color=color, shape_kwargs={'radius': 0.24, 'p0': (0, depth - 0.03, 0), 'p1': (0, depth + 0.03, 0)}))
    if len(station.lines) > 1:
        depths = [LINES[n].depth for n in station.lines]
        discs.append(primitive_call('cylinder', color=(0.3, 0.3, 0.3), shape_kwargs={'radius': 0.06, 'p0': (0, min(depths), 0), 'p1': (0, max(depths), 0)}))
    if not discs:
        discs.append(primitive_call('cube', color=(0.5, 0.5, 0.5), shape_kwargs={'scale': (0.4, 0.2, 0.4)}))
    return concat_shapes(*discs)

@register()
def tunnel(a: tuple, b: tuple, color: tuple) -> Shape:
    return primitive_call('cylinder', color=color, shape_kwargs={'radius': 0.08, 'p0': a, 'p1': b})

@register()
def subway_map() -> Shape:
    shapes = []
    for key, line in LINES.items():
        stops = [s for s in STATIONS if key in s.lines]
        for here, there in zip(stops, stops[1:]):
            shapes.append(library_call('tunnel', a=(here.x, line.depth, here.y), b=(there.x, line.depth, there.y), color=line.color))
    for s in STATIONS:
        shapes.append(transform_shape(library_call('platform', station=s), translation_matrix((s.x, 0, s.y))))
    last = STATIONS[-1]._replace(name="Yard", x=4.5)
    hub = max(STATIONS, key=lambda s: (len(s.lines), s.name))
    flag = primitive_call('cylinder', color=(0.9, 0.8, 0.1), shape_kwargs={'radius': 0.05, 'p0': (hub.x, 0, hub.y), 'p1': (last.x, 2, last.y)})
    name, x, y, _ = last
    sign = transform_shape(primitive_call('cube', color=(0.1, 0.1, 0.1), shape_kwargs={'scale': (0.2 * len(name), 0.2, 0.1)}), translation_matrix((x, 1, y)))
    return concat_shapes(*shapes, flag, sign)
