"""a brass orrery: a mechanical model of the solar system"""
from helper import *
import math
from dataclasses import dataclass
from typing import Optional


@dataclass
class Planet:
    name: str
    orbit: float
    size: float
    color: tuple[float, float, float]
    longitude: float  # degrees
    moons: int = 0
    ring: Optional[float] = None


PLANETS = [
    Planet('Mercury', 0.6, 0.05, (0.6, 0.55, 0.5), 20),
    Planet('Venus', 0.9, 0.08, (0.9, 0.75, 0.45), 130),
    Planet('Earth', 1.25, 0.09, (0.2, 0.45, 0.8), 215, moons=1),
    Planet('Mars', 1.6, 0.065, (0.8, 0.35, 0.2), 300, moons=2),
    Planet('Jupiter', 2.15, 0.2, (0.8, 0.65, 0.5), 75, moons=4),
    Planet('Saturn', 2.75, 0.17, (0.88, 0.78, 0.55), 170, moons=3, ring=0.32),
]
BRASS = (0.8, 0.62, 0.25)


def bar(a, b, r, color=BRASS):
    return primitive_call('cylinder', shape_kwargs={'radius': r, 'p0': a, 'p1': b}, color=color)


@register("a ring of short rods in the xz plane")
def circle(radius: float = 1.0, wire: float = 0.01, pieces: int = 36) -> Shape:
    step = 2 * math.pi / pieces
    return loop(pieces, lambda i: bar(
        (radius * math.cos(i * step), 0, radius * math.sin(i * step)),
        (radius * math.cos((i + 1) * step), 0, radius * math.sin((i + 1) * step)), wire))


@register("a planet with its moons, at the origin")
def planet(size: float = 0.1, color: tuple[float, float, float] = (0.5, 0.5, 0.5), moons: int = 0, ring: float = 0.0) -> Shape:
    ball = primitive_call('sphere', shape_kwargs={'radius': size}, color=color)
    satellites = []
    for m in range(moons):
        r = size + 0.06 + 0.03 * m
        a = 2.4 * m + 0.7
        end = (r * math.cos(a), 0.0, r * math.sin(a))
        satellites.append(bar((0, 0, 0), end, 0.004))
        satellites.append(transform_shape(primitive_call('sphere', shape_kwargs={'radius': 0.018}, color=(0.8, 0.8, 0.8)), translation_matrix(end)))
    parts = [ball, *satellites]
    if ring:
        bands = [library_call('circle', radius=ring - 0.03 * k, wire=0.012, pieces=30) for k in range(3)]
        tilted = transform_shape(concat_shapes(*bands), rotation_matrix(math.radians(26), (1, 0, 0), (0, 0, 0)))
        parts.append(tilted)
    return concat_shapes(*parts)


@register("a gear with teeth, lying flat")
def gear(teeth: int = 20, radius: float = 0.3, thickness: float = 0.04) -> Shape:
    plate = bar((0, 0, 0), (0, thickness, 0), radius)

    def tooth(i):
        t = primitive_call('cube', shape_kwargs={'scale': (0.06, thickness, 0.03)}, color=BRASS)
        t = transform_shape(t, translation_matrix((radius + 0.02, thickness / 2, 0)))
        return transform_shape(t, rotation_matrix(2 * math.pi * i / teeth, (0, 1, 0), (0, 0, 0)))

    return concat_shapes(plate, loop(teeth, tooth))


@register("an arm that carries a planet around the central column")
def arm(index: int = 2, height: float = 1.0) -> Shape:
    p = PLANETS[index]
    level = 0.4 + 0.06 * index  # each arm turns on its own sleeve
    elbow = (p.orbit, level, 0)
    globe = transform_shape(
        library_call('planet', size=p.size, color=p.color, moons=p.moons, ring=p.ring or 0.0),
        translation_matrix((p.orbit, height, 0)))
    whole = concat_shapes(bar((0, level, 0), elbow, 0.018), bar(elbow, (p.orbit, height, 0), 0.012), globe)
    return transform_shape(whole, rotation_matrix(math.radians(p.longitude), (0, 1, 0), (0, 0, 0)))


@register()
def solar_system_orrery(height: float = 1.0) -> Shape:
    sun = transform_shape(primitive_call('sphere', shape_kwargs={'radius': 0.3}, color=(1.0, 0.8, 0.2)), translation_matrix((0, height, 0)))
    column = bar((0, 0, 0), (0, height, 0), 0.05)
    drum = primitive_call('cylinder', shape_kwargs={'radius': 0.7, 'p0': (0, -0.15, 0), 'p1': (0, 0.05, 0)}, color=(0.3, 0.17, 0.1))
    gears = loop(4, lambda i: transform_shape(
        library_call('gear', teeth=24 - 4 * i, radius=0.34 - 0.06 * i), translation_matrix((0, 0.08 + 0.07 * i, 0))))
    feet = loop(3, lambda i: transform_shape(
        primitive_call('sphere', shape_kwargs={'radius': 0.1}, color=BRASS),
        translation_matrix((0.55 * math.cos(math.tau * i / 3), -0.2, 0.55 * math.sin(math.tau * i / 3)))))
    arms = [library_call('arm', index=i, height=height) for i in range(len(PLANETS))]
    orbit_rings = [transform_shape(library_call('circle', radius=p.orbit, wire=0.004), translation_matrix((0, 0.06, 0))) for p in PLANETS if p.orbit > 0.7]
    return concat_shapes(sun, column, drum, gears, feet, *arms, *orbit_rings)
