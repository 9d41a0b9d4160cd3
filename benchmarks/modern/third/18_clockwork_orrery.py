"""
a brass orrery with planets, moons and gear train
"""
from helper import *
import math
from dataclasses import dataclass, field
from functools import singledispatch, wraps
from collections.abc import Callable


def centred(f: Callable[..., Shape]) -> Callable[..., Shape]:
    @wraps(f)
    def inner(*args, **kwargs):
        shape = f(*args, **kwargs)
        c = compute_shape_center(shape)
        return transform_shape(shape, translation_matrix((-c[0], 0, -c[2])))
    return inner


@dataclass
class Moon:
    radius: float
    orbit: float
    phase: float = 0.0


@dataclass
class Planet:
    name: str
    radius: float
    orbit: float
    period: float
    color: tuple[float, float, float]
    moons: list[Moon] = field(default_factory=list)


@dataclass
class Sun:
    radius: float


BRASS = (0.75, 0.6, 0.25)
SYSTEM = [
    Sun(0.6),
    Planet('mercury', 0.12, 1.2, 0.24, (0.6, 0.6, 0.6)),
    Planet('venus', 0.2, 1.8, 0.62, (0.9, 0.8, 0.5)),
    Planet('earth', 0.22, 2.5, 1.0, (0.2, 0.4, 0.8), [Moon(0.06, 0.4, 1.0)]),
    Planet('jupiter', 0.4, 3.6, 11.9, (0.8, 0.6, 0.4), [Moon(0.05, 0.6, k * 1.6) for k in range(3)]),
]


@singledispatch
def draw(body, year: float) -> Shape:
    raise TypeError(f'cannot draw {body!r}')


@draw.register
def _(body: Sun, year: float) -> Shape:
    return primitive_call('sphere', color=(1.0, 0.8, 0.2), shape_kwargs={'radius': body.radius})


@draw.register
def _(body: Moon, year: float) -> Shape:
    a = body.phase + year * 13
    ball = primitive_call('sphere', color=(0.8, 0.8, 0.8), shape_kwargs={'radius': body.radius})
    return transform_shape(ball, translation_matrix((body.orbit * math.cos(a), 0, body.orbit * math.sin(a))))


@draw.register
def _(body: Planet, year: float) -> Shape:
    ball = primitive_call('sphere', color=body.color, shape_kwargs={'radius': body.radius})
    stalk = primitive_call('cylinder', color=BRASS, shape_kwargs={'radius': 0.03, 'p0': (0, -1.2, 0), 'p1': (0, -body.radius, 0)})
    group = concat_shapes(ball, stalk, *[draw(m, year) for m in body.moons])
    arm = primitive_call('cylinder', color=BRASS, shape_kwargs={'radius': 0.04, 'p0': (-body.orbit, -1.2, 0), 'p1': (0, -1.2, 0)})
    moved = transform_shape(concat_shapes(group, arm), translation_matrix((body.orbit, 0, 0)))
    return transform_shape(moved, rotation_matrix(math.tau * year / body.period, (0, 1, 0), (0, 0, 0)))


@register()
@centred
def gear(teeth: int = 16, radius: float = 0.6, thickness: float = 0.12) -> Shape:
    disc = primitive_call('cylinder', color=BRASS, shape_kwargs={'radius': radius, 'p0': (0, 0, 0), 'p1': (0, thickness, 0)})
    tooth = transform_shape(primitive_call('cube', color=BRASS, shape_kwargs={'scale': (radius * 0.3, thickness, radius * 0.15)}), translation_matrix((radius, thickness / 2, 0)))
    return concat_shapes(disc, *[transform_shape(tooth, rotation_matrix(k * math.tau / teeth, (0, 1, 0), (0, 0, 0))) for k in range(teeth)])


@register()
def orrery(year: float = 0.35) -> Shape:
    bodies = [draw(b, year) for b in SYSTEM]
    post = primitive_call('cylinder', color=BRASS, shape_kwargs={'radius': 0.1, 'p0': (0, -2.4, 0), 'p1': (0, -0.5, 0)})
    gears = [transform_shape(library_call('gear', teeth=12 + 4 * k, radius=0.4 + 0.15 * k), translation_matrix((0, -1.4 - 0.2 * k, 0))) for k in range(4)]
    base = primitive_call('cylinder', color=(0.35, 0.2, 0.1), shape_kwargs={'radius': 1.5, 'p0': (0, -2.7, 0), 'p1': (0, -2.4, 0)})
    return concat_shapes(base, post, *gears, *bodies)
