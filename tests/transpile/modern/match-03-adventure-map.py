from enum import Enum
from helper import *

"""
an adventure map: log entries matched as mappings and values
"""


class Terrain(Enum):
    FOREST = "f"
    LAKE = "l"
    HILL = "h"


LOG = [
    {"event": "tile", "terrain": Terrain.FOREST, "pos": [0, 0], "trees": 4},
    {"event": "tile", "terrain": Terrain.LAKE, "pos": [1, 0]},
    {"event": "tile", "terrain": Terrain.HILL, "pos": [1, 1], "height": 1.2},
    {"event": "tile", "terrain": Terrain.HILL, "pos": [2, 0]},
    {"event": "move", "path": "EESW"},
    {"event": "treasure", "pos": [2, 1], "gold": 150},
    {"event": "treasure", "pos": [0, 1], "gold": 20},
    {"event": None},
    {"event": "tile", "terrain": Terrain.FOREST, "pos": [0, 1], "trees": 2},
]


def step(direction: str) -> tuple[int, int]:
    match direction:
        case "N": return (0, -1)
        case "S": return (0, 1)
        case "E": return (1, 0)
        case "W": return (-1, 0)
        case unknown: raise KeyError(unknown)


@register()
def tile(color: tuple, x: int, z: int, height: float = 0.2) -> Shape:
    return transform_shape(primitive_call('cube', color=color, shape_kwargs={'scale': (0.96, height, 0.96)}), translation_matrix((x, height / 2, z)))


@register()
def tree() -> Shape:
    return concat_shapes(
        primitive_call('cylinder', color=(0.4, 0.25, 0.1), shape_kwargs={'radius': 0.04, 'p0': (0, 0.2, 0), 'p1': (0, 0.5, 0)}),
        transform_shape(primitive_call('sphere', color=(0.1, 0.45, 0.15), shape_kwargs={'radius': 0.15}), translation_matrix((0, 0.6, 0))))


@register()
def interpret(entry: dict) -> Shape:
    match entry:
        case {"event": "tile", "terrain": Terrain.FOREST, "pos": [x, z], "trees": n}:
            trees = loop(n, lambda i: transform_shape(library_call('tree'), translation_matrix((x - 0.25 + 0.5 * (i % 2), 0, z - 0.25 + 0.5 * (i // 2)))))
            return concat_shapes(library_call('tile', color=(0.3, 0.6, 0.3), x=x, z=z), trees)
        case {"terrain": Terrain.LAKE, "pos": [x, z]}:
            return library_call('tile', color=(0.2, 0.4, 0.8), x=x, z=z, height=0.1)
        case {"terrain": Terrain.HILL as kind, "pos": [x, z], **rest}:
            return library_call('tile', color=(0.5, 0.45, 0.3), x=x, z=z, height=rest.get("height", 0.1 * len(kind.name)))
        case {"event": "move", "path": str(path)} if path.isalpha():
            x = z = 0
            marks = []
            for d in path:
                dx, dz = step(d)
                marks.append(primitive_call('cylinder', color=(0.9, 0.1, 0.1), shape_kwargs={'radius': 0.04, 'p0': (x, 1.5, z), 'p1': (x + dx, 1.5, z + dz)}))
                x, z = x + dx, z + dz
            return concat_shapes(*marks)
        case {"event": "treasure", "pos": (x, z), "gold": int(gold)}:
            return loop(gold // 10, lambda i: primitive_call('cylinder', color=(0.95, 0.8, 0.2), shape_kwargs={'radius': 0.15, 'p0': (x, 0.3 + 0.05 * i, z), 'p1': (x, 0.34 + 0.05 * i, z)}))
        case {"event": None}:
            return []
    raise ValueError(entry)


@register()
def adventure_map() -> Shape:
    return concat_shapes(*[library_call('interpret', entry=e) for e in LOG])
