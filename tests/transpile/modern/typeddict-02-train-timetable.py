from typing import TypedDict
from helper import *

"""
a railway diagram: stations as posts and trains as inclined lines
"""

class Stop(TypedDict):
    station: str
    minute: int

class Train(TypedDict):
    name: str
    color: Tuple[float, float, float]
    stops: List[Stop]

KM = {"Aville": 0.0, "Beeford": 4.0, "Ceeton": 7.5, "Deeham": 12.0}

def express(name: str, start: int, *, color=(0.9, 0.2, 0.2)) -> Train:
    return {"name": name, "color": color, "stops": [{"station": "Aville", "minute": start}, {"station": "Deeham", "minute": start + 9}]}

def local(name: str, start: int, **extra) -> Train:
    stops: List[Stop] = []
    for i, station in enumerate(reversed(KM) if extra.get("back") else KM):
        stops.append({"station": station, "minute": start + 5 * i})
        if 0 < i < len(KM) - 1:
            stops.append(Stop(station=station, minute=start + 5 * i + 1))
    return Train(name=name, color=extra.get("color", (0.2, 0.4, 0.9)), stops=stops)

@register()
def train_path(train: Train) -> Shape:
    points = [(KM[s["station"]] / 2, 0.2 * s["minute"], 0) for s in train["stops"]]
    segments = [
        primitive_call('cylinder', color=train["color"], shape_kwargs={'radius': 0.05, 'p0': a, 'p1': b})
        for a, b in zip(points[:-1], points[1:])
    ]
    knots = [transform_shape(primitive_call('sphere', color=(1, 1, 1), shape_kwargs={'radius': 0.09}), translation_matrix(p)) for p in points]
    return concat_shapes(*segments, *knots)

@register()
def diagram() -> Shape:
    trains = [local("L1", 0), express("E1", 6), local("L2", 12, back=True, color=(0.1, 0.6, 0.4)), express("E2", 18, color=(0.8, 0.5, 0.1))]
    last = max(stop["minute"] for train in trains for stop in train["stops"])
    posts = [primitive_call('cylinder', color=(0.4, 0.4, 0.4), shape_kwargs={'radius': 0.03, 'p0': (km / 2, 0, -0.1), 'p1': (km / 2, 0.2 * last, -0.1)}) for km in KM.values()]
    hours = [transform_shape(primitive_call('cube', color=(0.8, 0.8, 0.8), shape_kwargs={'scale': (6, 0.02, 0.02)}), translation_matrix((3, 0.2 * m, -0.2))) for m in range(0, last + 1, 5)]
    trains.sort(key=lambda t: (len(t["stops"]), t["name"]), reverse=True)
    layers = [transform_shape(library_call('train_path', train=t), translation_matrix((0, 0, 0.15 * k))) for k, t in enumerate(trains)]
    return concat_shapes(*posts, *hours, *layers)
