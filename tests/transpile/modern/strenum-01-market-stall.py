from __future__ import annotations
from dataclasses import dataclass
from enum import Enum
from helper import *

"""
a market stall with crates of produce
"""


class Produce(str, Enum):
    APPLE = "apple"
    LEMON = "lemon"
    PLUM = "plum"
    LEEK = "leek"


STYLE: dict[str, dict] = {
    Produce.APPLE: {"color": (0.85, 0.15, 0.1), "radius": 0.08},
    Produce.LEMON: {"color": (0.95, 0.9, 0.2), "radius": 0.07},
    Produce.PLUM: {"color": (0.4, 0.1, 0.4), "radius": 0.06},
}


@dataclass
class Crate:
    kind: Produce
    rows: int = 3
    cols: int = 3

    @property
    def label(self) -> str:
        return f"{self.kind.value.upper()} x{self.rows * self.cols}"


@register("a crate full of one kind of produce")
def crate(kind: str, rows: int, cols: int) -> Shape:
    wood = (0.6, 0.45, 0.25)
    base = primitive_call("cube", color=wood, shape_kwargs={"scale": (cols * 0.18 + 0.05, 0.12, rows * 0.18 + 0.05)})
    items = []
    for r in range(rows):
        for c in range(cols):
            at = ((c - (cols - 1) / 2) * 0.18, 0.12, (r - (rows - 1) / 2) * 0.18)
            if kind == Produce.LEEK:  # str comparison works both ways
                item = primitive_call("cylinder", color=(0.5, 0.75, 0.35), shape_kwargs={"radius": 0.03, "p0": (0, 0, 0), "p1": (0, 0.3, 0)})
            else:
                style = STYLE[kind]
                item = primitive_call("sphere", color=style["color"], shape_kwargs={"radius": style["radius"]})
            items.append(transform_shape(item, translation_matrix(at)))
    return concat_shapes(base, *items)


@register("market stall")
def market_stall() -> Shape:
    crates = [Crate(Produce.APPLE), Crate(Produce.LEMON, cols=4), Crate(Produce("plum"), rows=2), Crate(Produce["LEEK"], 2, 5)]
    table = transform_shape(primitive_call("cube", color=(0.5, 0.35, 0.2), shape_kwargs={"scale": (4, 0.1, 1.2)}), translation_matrix((0, 0.9, 0)))
    shapes, x = [table], -1.5
    for c in crates:
        shapes.append(transform_shape(library_call("a crate full of one kind of produce", kind=c.kind.value, rows=c.rows, cols=c.cols), translation_matrix((x, 1.02, 0))))
        sign = primitive_call("cube", color=(1, 1, 1), shape_kwargs={"scale": (0.05 * len(c.label), 0.15, 0.02)})
        shapes.append(transform_shape(sign, translation_matrix((x, 0.8, 0.62))))
        x += 1.0
    awning = loop(8, lambda i: transform_shape(
        primitive_call("cube", color=(0.9, 0.2, 0.2) if i % 2 else (1, 1, 1), shape_kwargs={"scale": (0.5, 0.05, 1.6)}),
        translation_matrix((-1.75 + 0.5 * i, 2.4, 0.1)) @ rotation_matrix(0.2, (1, 0, 0), (0, 0, 0))))
    return concat_shapes(*shapes, awning)
