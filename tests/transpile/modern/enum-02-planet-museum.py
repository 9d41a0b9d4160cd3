"""Museum hall with eight planets on plinths; the planet data live in an Enum with tuple values."""
from __future__ import annotations

import math
from enum import Enum

from helper import *


class Planet(Enum):
    MERCURY = (0.38, (0.6, 0.55, 0.5), 0)
    VENUS = (0.95, (0.9, 0.75, 0.45), 0)
    EARTH = (1.0, (0.2, 0.4, 0.8), 1)
    MARS = (0.53, (0.8, 0.35, 0.2), 2)
    JUPITER = (11.2, (0.8, 0.65, 0.5), 4)
    SATURN = (9.45, (0.9, 0.8, 0.55), 7)
    URANUS = (4.0, (0.6, 0.85, 0.9), 5)
    NEPTUNE = (3.88, (0.25, 0.4, 0.85), 2)

    def __init__(self, earth_radii: float, color: tuple[float, float, float], moons: int) -> None:
        self.earth_radii = earth_radii
        self.color = color
        self.moons = moons

    @property
    def display_radius(self) -> float:
        return 0.2 + 0.12 * math.log1p(self.earth_radii)

    @classmethod
    def giants(cls) -> list[Planet]:
        return [p for p in cls if p.earth_radii > 3]

    def __str__(self) -> str:
        return self.name.title()


@register()
def exhibit(name: str) -> Shape:
    planet = Planet[name]
    r = planet.display_radius
    plinth = primitive_call('cylinder', color=(0.85, 0.85, 0.82), shape_kwargs={'radius': 0.3, 'p0': (0, 0, 0), 'p1': (0, 0.8, 0)})
    globe = transform_shape(primitive_call('sphere', color=planet.color, shape_kwargs={'radius': r}), translation_matrix((0, 0.85 + r, 0)))
    parts = [plinth, globe]
    for m in range(planet.moons):
        angle = 2 * math.pi * m / planet.moons
        moon = primitive_call('sphere', color=(0.75, 0.75, 0.75), shape_kwargs={'radius': 0.03})
        parts.append(transform_shape(moon, translation_matrix(((r + .1) * math.cos(angle), 0.85 + r, (r + .1) * math.sin(angle)))))
    if planet is Planet.SATURN:
        ring = primitive_call('cylinder', color=(0.8, 0.7, 0.5), shape_kwargs={'radius': r * 1.7, 'p0': (0, -0.01, 0), 'p1': (0, 0.01, 0)})
        parts.append(transform_shape(transform_shape(ring, rotation_matrix(0.4, (0, 0, 1), (0, 0, 0))), translation_matrix((0, 0.85 + r, 0))))
    # the label is as long as the printed name
    label = primitive_call('cube', color=(0.7, 0.6, 0.2), shape_kwargs={'scale': (0.06 * len(str(planet)), 0.12, 0.02)})
    parts.append(transform_shape(label, translation_matrix((0, 0.5, 0.32))))
    return concat_shapes(*parts)


@register()
def museum() -> Shape:
    floor = transform_shape(primitive_call('cube', color=(0.4, 0.3, 0.25), shape_kwargs={'scale': (13, 0.1, 4)}), translation_matrix((0, -0.05, 0)))
    row = loop(len(Planet), lambda i: transform_shape(
        library_call('exhibit', name=list(Planet)[i].name),
        translation_matrix((1.5 * (i - (len(Planet) - 1) / 2), 0, -0.5 if list(Planet)[i] in Planet.giants() else 0.5))))
    return concat_shapes(floor, row)
