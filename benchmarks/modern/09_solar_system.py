"""the solar system with orbit rings, planets at today's rough angles"""
from helper import *
import json
import math
from datetime import date

TABLE = json.loads("""
[
  {"name": "Mercury", "au": 0.39, "r": 0.08, "period": 88,    "color": [0.6, 0.55, 0.5]},
  {"name": "Venus",   "au": 0.72, "r": 0.14, "period": 225,   "color": [0.9, 0.75, 0.4]},
  {"name": "Earth",   "au": 1.00, "r": 0.15, "period": 365,   "color": [0.2, 0.45, 0.85], "moons": 1},
  {"name": "Mars",    "au": 1.52, "r": 0.11, "period": 687,   "color": [0.8, 0.35, 0.2], "moons": 2},
  {"name": "Jupiter", "au": 5.20, "r": 0.45, "period": 4333,  "color": [0.8, 0.65, 0.5], "moons": 4},
  {"name": "Saturn",  "au": 9.58, "r": 0.38, "period": 10759, "color": [0.9, 0.8, 0.55], "rings": true},
  {"name": "Uranus",  "au": 19.2, "r": 0.25, "period": 30687, "color": [0.55, 0.8, 0.85]},
  {"name": "Neptune", "au": 30.0, "r": 0.25, "period": 60190, "color": [0.25, 0.35, 0.85]}
]
""")

EPOCH = date(2000, 1, 1)
NOW = date(2025, 6, 21)


def orbit_radius(au: float) -> float:
    return 1.2 + 2.2 * math.log1p(au)


@register()
def orbit_ring(radius: float, n: int = 48) -> Shape:
    def seg(i):
        a, b = (2 * math.pi * k / n for k in (i, i + 0.6))
        return primitive_call('cylinder', shape_kwargs={
            'radius': 0.012,
            'p0': (radius * math.cos(a), 0, radius * math.sin(a)),
            'p1': (radius * math.cos(b), 0, radius * math.sin(b))}, color=(0.5, 0.5, 0.55))
    return loop(n, seg)


@register()
def planet(name: str, r: float, color, moons: int = 0, rings: bool = False) -> Shape:
    shape = primitive_call('sphere', shape_kwargs={'radius': r}, color=tuple(color))
    if rings:
        disc = primitive_call('cylinder', shape_kwargs={'radius': r * 2, 'p0': (0, -0.01, 0), 'p1': (0, 0.01, 0)}, color=(0.8, 0.72, 0.55))
        shape = concat_shapes(shape, transform_shape(disc, rotation_matrix(math.radians(26.7), (0, 0, 1), (0, 0, 0))))
    for m in range(moons):
        ang = 2 * math.pi * m / max(moons, 1) + len(name)
        moon = primitive_call('sphere', shape_kwargs={'radius': r * 0.2}, color=(0.75, 0.75, 0.75))
        shape = concat_shapes(shape, transform_shape(moon, translation_matrix((1.6 * r * math.cos(ang), 0, 1.6 * r * math.sin(ang)))))
    return shape


@register()
def solar_system() -> Shape:
    elapsed = (NOW - EPOCH).days
    shapes = [primitive_call('sphere', shape_kwargs={'radius': 0.8}, color=(1.0, 0.85, 0.2))]
    for row in TABLE:
        extra = {k: row[k] for k in ('moons', 'rings') if k in row}
        body = library_call('planet', name=row['name'], r=row['r'], color=row['color'], **extra)
        theta = math.tau * ((elapsed % row['period']) / row['period'])
        R = orbit_radius(row['au'])
        shapes.append(library_call('orbit_ring', radius=R))
        shapes.append(transform_shape(body, translation_matrix((R * math.cos(theta), 0, -R * math.sin(theta)))))
    return concat_shapes(*shapes)
