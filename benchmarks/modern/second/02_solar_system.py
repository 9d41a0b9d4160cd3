"""
an orrery of the solar system on a brass stand
"""
from helper import *
import json
import math
from datetime import date
from typing import NamedTuple
from functools import partial

TABLE = json.loads("""
[
  {"name": "mercury", "au": 0.39, "size": 0.06, "days": 88,    "rgb": [0.6, 0.55, 0.5]},
  {"name": "venus",   "au": 0.72, "size": 0.10, "days": 225,   "rgb": [0.9, 0.8, 0.55]},
  {"name": "earth",   "au": 1.0,  "size": 0.11, "days": 365,   "rgb": [0.2, 0.45, 0.85], "moons": 1},
  {"name": "mars",    "au": 1.52, "size": 0.08, "days": 687,   "rgb": [0.8, 0.35, 0.2], "moons": 2},
  {"name": "jupiter", "au": 5.2,  "size": 0.26, "days": 4333,  "rgb": [0.8, 0.65, 0.5], "moons": 4},
  {"name": "saturn",  "au": 9.58, "size": 0.22, "days": 10759, "rgb": [0.9, 0.8, 0.6], "ring": true}
]
""")

BRASS = (0.71, 0.55, 0.25)
EPOCH = date(2000, 1, 1)


class Planet(NamedTuple):
    name: str
    au: float
    size: float
    days: float
    rgb: tuple[float, float, float]
    moons: int = 0
    ring: bool = False

    @classmethod
    def from_row(cls, row: dict) -> 'Planet':
        return cls(**{**row, 'rgb': tuple(row['rgb'])})

    @property
    def arm(self) -> float:
        # compressed distances so that everything fits on the table
        return 0.6 + 0.75 * math.log1p(self.au)

    def angle_on(self, day: date) -> float:
        elapsed = (day - EPOCH).days
        return 2 * math.pi * ((elapsed / self.days) % 1.0)


PLANETS = sorted(map(Planet.from_row, TABLE), key=lambda p: p.au)
brass_rod = partial(primitive_call, 'cylinder', color=BRASS)


@register()
def planet_ball(index: int = 2) -> Shape:
    p = PLANETS[index]
    parts = [primitive_call('sphere', {'radius': p.size}, color=p.rgb)]
    for m in range(p.moons):
        theta = m * 2 * math.pi / p.moons + 0.4
        r = p.size * (1.5 + 0.25 * m)
        moon = primitive_call('sphere', {'radius': 0.025}, color=(0.85, 0.85, 0.8))
        parts.append(transform_shape(moon, translation_matrix((r * math.cos(theta), 0.02 * m, r * math.sin(theta)))))
    if p.ring:
        disc = primitive_call('cylinder', {'radius': p.size * 1.9, 'p0': (0, -0.008, 0), 'p1': (0, 0.008, 0)},
                              color=(0.8, 0.72, 0.55))
        parts.append(transform_shape(disc, rotation_matrix(math.radians(26.7), (1, 0, 0), (0, 0, 0))))
    return concat_shapes(*parts)


@register()
def orrery_arm(index: int = 2, level: float = 0.0, *, drop: float = 0.5) -> Shape:
    p = PLANETS[index]
    beam = brass_rod({'radius': 0.018, 'p0': (0, level, 0), 'p1': (p.arm, level, 0)})
    post = brass_rod({'radius': 0.014, 'p0': (p.arm, level, 0), 'p1': (p.arm, drop, 0)})
    collar = brass_rod({'radius': 0.09, 'p0': (0, level - 0.02, 0), 'p1': (0, level + 0.02, 0)})
    ball = transform_shape(library_call('planet_ball', index=index), translation_matrix((p.arm, drop, 0)))
    arm = concat_shapes(beam, post, collar, ball)
    turn = p.angle_on(date(2025, 6, 21))
    return transform_shape(arm, rotation_matrix(turn, (0, 1, 0), (0, 0, 0)))


@register()
def stand(height: float = 1.2) -> Shape:
    column = brass_rod({'radius': 0.06, 'p0': (0, -height, 0), 'p1': (0, 0.5, 0)})
    foot = brass_rod({'radius': 0.7, 'p0': (0, -height - 0.1, 0), 'p1': (0, -height, 0)})

    def claw(i: int) -> Shape:
        a = i * 2 * math.pi / 3
        leg = brass_rod({'radius': 0.04, 'p0': (0, -height * 0.6, 0), 'p1': (0.6 * math.cos(a), -height, 0.6 * math.sin(a))})
        return leg

    return concat_shapes(column, foot, loop(3, claw))


@register()
def orrery() -> Shape:
    sun = transform_shape(primitive_call('sphere', {'radius': 0.3}, color=(1.0, 0.8, 0.2)),
                          translation_matrix((0, 0.5, 0)))
    arms = [library_call('orrery_arm', index=i, level=-0.08 * i) for i, _ in enumerate(PLANETS)]
    return concat_shapes(library_call('stand'), sun, *arms)
