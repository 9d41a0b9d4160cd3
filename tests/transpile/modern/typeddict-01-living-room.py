from typing import TypedDict, NotRequired, Required, Literal
from helper import *

"""
a living room described by typed dictionaries
"""


class Furniture(TypedDict):
    kind: Literal["sofa", "table", "lamp", "shelf"]
    at: tuple[float, float]
    size: NotRequired[float]
    color: NotRequired[tuple[float, float, float]]


class Room(TypedDict, total=False):
    name: Required[str]
    furniture: list[Furniture]
    rug: float


LIVING_ROOM: Room = {
    "name": "living room",
    "furniture": [
        {"kind": "sofa", "at": (0.0, -1.5), "size": 2.2, "color": (0.3, 0.4, 0.6)},
        {"kind": "sofa", "at": (-2.4, 0.0)},
        {"kind": "table", "at": (0.0, 0.0)},
        {"kind": "lamp", "at": (2.0, -1.5), "size": 1.7},
        Furniture(kind="shelf", at=(2.2, 0.5), size=2.0),
    ],
    "rug": 1.6,
}


def box(scale, at, color) -> Shape:
    return transform_shape(primitive_call("cube", color=color, shape_kwargs={"scale": scale}), translation_matrix(at))


@register("piece of furniture")
def furniture(item: Furniture) -> Shape:
    size = item.get("size", 1.0)
    color = item.get("color", (0.55, 0.4, 0.25))
    kind = item["kind"]
    if kind == "sofa":
        parts = [box((size, 0.4, 0.8), (0, 0.3, 0), color), box((size, 0.5, 0.2), (0, 0.7, -0.3), color)]
        parts += [box((0.2, 0.6, 0.8), (side * size / 2, 0.4, 0), color) for side in (-1, 1)]
    elif kind == "table":
        parts = [box((size, 0.06, size * 0.7), (0, 0.45, 0), color)]
        parts += [box((0.06, 0.45, 0.06), (sx * size * 0.45, 0.22, sz * size * 0.3), color) for sx in (-1, 1) for sz in (-1, 1)]
    elif kind == "lamp":
        parts = [
            primitive_call("cylinder", color=(0.2, 0.2, 0.2), shape_kwargs={"radius": 0.04, "p0": (0, 0, 0), "p1": (0, size, 0)}),
            transform_shape(primitive_call("sphere", color=(1, 0.95, 0.7), shape_kwargs={"radius": 0.25}), translation_matrix((0, size, 0))),
        ]
    else:
        levels = int(size / 0.4)
        parts = [box((1.0, 0.05, 0.3), (0, 0.4 * (k + 1), 0), color) for k in range(levels)]
        parts += [box((0.05, size, 0.3), (sx * 0.5, size / 2, 0), color) for sx in (-1, 1)]
    return concat_shapes(*parts)


@register("furnished room")
def room() -> Shape:
    spec = LIVING_ROOM
    shapes = [box((6, 0.05, 5), (0, 0, 0), (0.7, 0.6, 0.45))]
    if "rug" in spec:
        shapes.append(primitive_call("cylinder", color=(0.7, 0.2, 0.25), shape_kwargs={"radius": spec["rug"], "p0": (0, 0.03, 0), "p1": (0, 0.06, 0)}))
    for item in spec["furniture"]:
        x, z = item["at"]
        shapes.append(transform_shape(library_call("furniture", item=item), translation_matrix((x, 0.03, z))))
    return concat_shapes(*shapes)
