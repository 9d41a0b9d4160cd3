"""
a medieval castle with towers, a gatehouse, battlements and banners
"""
from helper import *
import json
import math
from collections import ChainMap, namedtuple
from itertools import cycle
from types import SimpleNamespace

CONFIG = json.loads(r'''
{
  "defaults": {"kind": "round", "radius": 0.8, "height": 4.0, "roof": true},
  "walls": {"height": 2.2, "thickness": 0.4, "merlon": 0.3},
  "towers": [
    {"at": [-4, -4]},
    {"at": [4, -4], "height": 4.6},
    {"at": [4, 4], "roof": false},
    {"at": [-4, 4], "height": 3.6, "radius": 0.9}
  ],
  "keep": {"kind": "square", "height": 5.0, "radius": 1.4, "roof": false, "at": [0, -1]}
}
''', object_hook=dict)

Segment = namedtuple('Segment', 'start end gate', defaults=(False,))
STONE = (0.62, 0.6, 0.56)


def tower_spec(raw: dict) -> SimpleNamespace:
    return SimpleNamespace(**ChainMap(raw, CONFIG['defaults']))


def ring(points, gate_index: int):
    shifted = points[1:] + points[:1]
    for i, (a, b) in enumerate(zip(points, shifted, strict=True)):
        yield Segment(a, b, gate=i == gate_index)


@register()
def merlons(length: float = 4.0, size: float = 0.3) -> Shape:
    n = max(1, int(length // (2 * size)))
    pitch = length / n
    return loop(n, lambda i: transform_shape(primitive_call('cube', {'scale': (size, size, size)}, color=STONE),
                                             translation_matrix((-length / 2 + (i + 0.5) * pitch, size / 2, 0))))


@register()
def banner(color: tuple = (0.7, 0.1, 0.15), rows: int = 3) -> Shape:
    pole = primitive_call('cylinder', {'radius': 0.03, 'p0': (0, 0, 0), 'p1': (0, 1.2, 0)}, color=(0.3, 0.2, 0.1))
    cloth = [transform_shape(primitive_call('cube', {'scale': (0.6 - 0.12 * i, 0.12, 0.02)}, color=color),
                             translation_matrix(((0.6 - 0.12 * i) / 2, 1.1 - 0.12 * i, 0))) for i in range(rows)]
    return concat_shapes(pole, *cloth)


@register()
def tower(kind: str = 'round', radius: float = 0.8, height: float = 4.0, roof: bool = True) -> Shape:
    match kind, roof:
        case 'round', _:
            body = primitive_call('cylinder', {'radius': radius, 'p0': (0, 0, 0), 'p1': (0, height, 0)}, color=STONE)
        case 'square', _:
            body = transform_shape(primitive_call('cube', {'scale': (2 * radius, height, 2 * radius)}, color=STONE), translation_matrix((0, height / 2, 0)))
        case other, _:
            raise ValueError(f'unknown tower {other!r}')
    if roof:
        cone = loop(8, lambda i: primitive_call('cylinder', {'radius': radius * 1.15 * (1 - i / 8), 'p0': (0, height + 0.2 * i, 0), 'p1': (0, height + 0.2 * (i + 1), 0)},
                                                color=(0.25, 0.3, 0.45)))
        return concat_shapes(body, cone)
    n = 8
    crown = []
    for i in range(n):
        a = math.tau * i / n
        if kind == 'square':
            k = radius / max(abs(math.cos(a)), abs(math.sin(a)))
        else:
            k = radius * 0.9
        m = primitive_call('cube', {'scale': (0.3, 0.35, 0.3)}, color=STONE)
        crown.append(transform_shape(m, translation_matrix((k * math.cos(a), height + 0.17, k * math.sin(a)))))
    return concat_shapes(body, *crown)


@register()
def curtain_wall(length: float = 8.0, gate: bool = False) -> Shape:
    w = SimpleNamespace(**CONFIG['walls'])
    if not gate:
        body = transform_shape(primitive_call('cube', {'scale': (length, w.height, w.thickness)}, color=STONE), translation_matrix((0, w.height / 2, 0)))
    else:
        opening = 1.6
        side = (length - opening) / 2
        halves = [transform_shape(primitive_call('cube', {'scale': (side, w.height, w.thickness)}, color=STONE),
                                  translation_matrix((s * (opening + side) / 2, w.height / 2, 0))) for s in (-1, 1)]
        lintel = transform_shape(primitive_call('cube', {'scale': (opening, 0.5, w.thickness * 1.3)}, color=(0.5, 0.48, 0.45)), translation_matrix((0, w.height - 0.25, 0)))
        bars = [primitive_call('cylinder', {'radius': 0.04, 'p0': (x, 0.3, 0), 'p1': (x, w.height - 0.5, 0)}, color=(0.2, 0.2, 0.22))
                for x in (opening * (k / 6 - 0.5) for k in range(1, 6))]
        body = concat_shapes(*halves, lintel, *bars)
    top = transform_shape(library_call('merlons', length=length, size=w.merlon), translation_matrix((0, w.height, 0)))
    return concat_shapes(body, top)


@register()
def castle() -> Shape:
    specs = [tower_spec(t) for t in CONFIG['towers']] + [tower_spec(CONFIG['keep'])]
    flags = cycle([(0.7, 0.1, 0.15), (0.9, 0.75, 0.2)])
    parts = []
    for s, c in zip(specs, flags):
        t = library_call('tower', kind=s.kind, radius=s.radius, height=s.height, roof=s.roof)
        t = concat_shapes(t, transform_shape(library_call('banner', color=c), translation_matrix((0, compute_shape_max(t)[1] - 0.2, 0))))
        parts.append(transform_shape(t, translation_matrix((s.at[0], 0, s.at[1]))))
    for seg in ring([tuple(t['at']) for t in CONFIG['towers']], gate_index=2):
        (x0, z0), (x1, z1) = seg.start, seg.end
        wall = library_call('curtain_wall', length=math.dist(seg.start, seg.end), gate=seg.gate)
        pose = translation_matrix(((x0 + x1) / 2, 0, (z0 + z1) / 2)) @ rotation_matrix(-math.atan2(z1 - z0, x1 - x0), (0, 1, 0), (0, 0, 0))
        parts.append(transform_shape(wall, pose))
    hill = primitive_call('cylinder', {'radius': 8, 'p0': (0, -0.5, 0), 'p1': (0, 0, 0)}, color=(0.4, 0.58, 0.3))
    return concat_shapes(hill, *parts)
