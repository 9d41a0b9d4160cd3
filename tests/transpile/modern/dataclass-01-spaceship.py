from __future__ import annotations
from dataclasses import dataclass, field, replace, asdict
from helper import *

"""
a squadron of spaceships that are variations of one design
"""


@dataclass
class Module:
    length: float
    radius: float = 0.4
    color: tuple[float, float, float] = (0.7, 0.72, 0.75)

    def draw(self, x: float) -> Shape:
        return primitive_call('cylinder', color=self.color, shape_kwargs={'radius': self.radius, 'p0': (x, 0, 0), 'p1': (x + self.length, 0, 0)})


@dataclass
class Cockpit(Module):
    glass: tuple[float, float, float] = (0.3, 0.7, 0.9)

    def draw(self, x: float) -> Shape:
        dome = transform_shape(primitive_call('sphere', color=self.glass, shape_kwargs={'radius': self.radius}), translation_matrix((x + self.length, 0, 0)))
        return concat_shapes(super().draw(x), dome)


@dataclass
class Engine(Module):
    thrust: float = 1.0
    nozzles: int = 3

    def __post_init__(self) -> None:
        self.color = (0.3, 0.3, 0.35)
        self.flame = 0.4 * self.thrust / self.nozzles

    def draw(self, x: float) -> Shape:
        flames = loop(self.nozzles, lambda i: primitive_call('cylinder', color=(1, 0.5, 0.1), shape_kwargs={
            'radius': 0.08, 'p0': (x, 0.2 * math.sin(2.1 * i), 0.2 * math.cos(2.1 * i)), 'p1': (x - self.flame, 0.2 * math.sin(2.1 * i), 0.2 * math.cos(2.1 * i))}))
        return concat_shapes(super().draw(x), flames)


@dataclass
class Ship:
    name: str
    modules: list[Module] = field(default_factory=list)
    wings: int = 2
    spare: dict = field(default_factory=dict, repr=False, compare=False)

    @property
    def length(self) -> float:
        return sum(m.length for m in self.modules)


@register()
def ship(design: Ship) -> Shape:
    x, parts = -design.length / 2, []
    for module in design.modules:
        parts.append(module.draw(x))
        x += module.length
    for w in range(design.wings):
        wing = transform_shape(primitive_call('cube', color=(0.8, 0.2, 0.2), shape_kwargs={'scale': (0.8, 0.05, 1.2)}), translation_matrix((0, 0, 0.9)))
        parts.append(transform_shape(wing, rotation_matrix(w * 2 * math.pi / design.wings, (1, 0, 0), (0, 0, 0))))
    return concat_shapes(*parts)


@register()
def squadron() -> Shape:
    hull = Module(1.5)
    base = Ship("scout", [Engine(0.6, thrust=3), hull, Cockpit(0.5, radius=0.3)])
    fleet = [base, replace(base, name="cargo", modules=[base.modules[0], *[replace(hull, radius=0.6 - 0.1 * k) for k in range(3)], base.modules[-1]]), replace(base, name="racer", wings=4)]
    fleet[2].modules = fleet[2].modules + [Module(0.2, 0.1)]
    print(asdict(fleet[0])["modules"][2]["glass"], base == fleet[2])
    return concat_shapes(*[transform_shape(library_call('ship', design=s), translation_matrix((0, 1.5 * k, 0.4 * len(s.name)))) for k, s in enumerate(fleet)])
