from dataclasses import dataclass, field, fields, astuple
from typing import ClassVar
from helper import *

"""
mountain refuges ranked by altitude
"""


@dataclass(order=True, frozen=True)
class Refuge:
    altitude: int
    beds: int = field(compare=False)
    name: str = field(default="unnamed", compare=False)
    STYLE: ClassVar[dict] = {"wood": (0.45, 0.3, 0.15), "roof": (0.55, 0.1, 0.1)}

    @property
    def scale(self) -> float:
        return 0.5 + self.beds / 60


REFUGES = [
    Refuge(2450, 40, "Eagle"),
    Refuge(1890, 80, "Marmot"),
    Refuge(3120, 16, "Snow Cross"),
    Refuge(2450, 24),
    Refuge(2780, 30, "Ibex"),
]


@dataclass(frozen=True, slots=True)
class Peak:
    x: float
    height: float

    def __post_init__(self):
        if self.height <= 0:
            raise ValueError(f"bad height {self.height}")
        object.__setattr__(self, "x", round(self.x, 1))


@register()
def hut(scale: float) -> Shape:
    wood, roof = Refuge.STYLE["wood"], Refuge.STYLE["roof"]
    walls = transform_shape(primitive_call("cube", color=wood, shape_kwargs={"scale": (1, 0.6, 0.8)}), translation_matrix((0, 0.3, 0)))
    slopes = [transform_shape(primitive_call("cube", color=roof, shape_kwargs={"scale": (0.75, 0.05, 0.9)}),
                              translation_matrix((s * 0.28, 0.75, 0)) @ rotation_matrix(-s * 0.6, (0, 0, 1), (0, 0, 0))) for s in (-1, 1)]
    return transform_shape(concat_shapes(walls, *slopes), scale_matrix(scale, (0, 0, 0)))


@register()
def mountain(height: float, layers: int = 8) -> Shape:
    def layer(i: int) -> Shape:
        r = height * 0.5 * (1 - i / layers)
        snow = i >= layers - 2
        return primitive_call("cylinder", color=(0.95, 0.95, 1) if snow else (0.4, 0.42, 0.4), shape_kwargs={"radius": r, "p0": (0, i * height / layers, 0), "p1": (0, (i + 1) * height / layers, 0)})
    return loop(layers, layer)


@register()
def massif() -> Shape:
    ranked = sorted(REFUGES)
    assert ranked[0] < ranked[-1] and Refuge(2450, 1) == Refuge(2450, 99)
    shapes = []
    for k, refuge in enumerate(ranked):
        altitude, beds, name = astuple(refuge)
        h = altitude / 800
        shapes.append(transform_shape(library_call("hut", scale=refuge.scale), translation_matrix((2.5 * k, h, 1.2))))
        pole = primitive_call("cylinder", color=(0.6, 0.6, 0.6), shape_kwargs={"radius": 0.1, "p0": (2.5 * k, 0, 1.2), "p1": (2.5 * k, h, 1.2)})
        shapes.append(pole)
    for text in ("1.23:4", "5.07:-1", "6.49:5.5"):
        x, height = map(float, text.split(":"))
        try:
            peak = Peak(x, height)
        except ValueError as error:
            print(error, [f.name for f in fields(Peak)])
            continue
        shapes.append(transform_shape(library_call("mountain", height=peak.height), translation_matrix((peak.x, 0, -2))))
    return concat_shapes(*shapes)
