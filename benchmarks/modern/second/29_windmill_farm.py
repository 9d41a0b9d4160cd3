"""
a dutch windmill among rows of tulips
"""
from helper import *
import math
import random
from dataclasses import asdict, dataclass, field
from functools import partial, lru_cache
from itertools import groupby, product


@dataclass(kw_only=True)
class MillSpec:
    height: float = 3.2
    base: float = 1.1
    top: float = 0.75
    sails: int = 4
    turn: float = 0.3
    sail_length: float = field(default=0.0)

    def __post_init__(self):
        self.sail_length = self.sail_length or self.height * 0.68
        if self.sails < 2:
            raise ValueError('a mill needs two sails at least')

    def radius_at(self, t: float) -> float:
        return self.base + (self.top - self.base) * t


@lru_cache(maxsize=8)
def tulip_color(row: int) -> tuple[float, float, float]:
    rng = random.Random(row * 101)
    return rng.choice([(0.9, 0.15, 0.2), (0.98, 0.8, 0.15), (0.85, 0.4, 0.75), (0.98, 0.95, 0.92), (0.95, 0.5, 0.15)])


cyl = lambda r, a, b, color: primitive_call('cylinder', {'radius': r, 'p0': a, 'p1': b}, color=color)


@register()
def sail(length: float = 2.2, width: float = 0.45, slats: int = 9) -> Shape:
    spar = cyl(0.04, (0, 0, 0), (0, length, 0), (0.35, 0.22, 0.12))
    lattice = loop(slats, lambda i: transform_shape(
        primitive_call('cube', {'scale': (width, 0.025, 0.02)}, color=(0.5, 0.35, 0.2)),
        translation_matrix((width / 2, length * (0.2 + 0.8 * i / (slats - 1)), 0))))
    cloth = transform_shape(primitive_call('cube', {'scale': (width * 0.9, length * 0.8, 0.008)}, color=(0.93, 0.9, 0.82)),
                            translation_matrix((width / 2, length * 0.6, -0.01)))
    return concat_shapes(spar, lattice, cloth)


@register()
def mill_body(height: float = 3.2, base: float = 1.1, top: float = 0.75, courses: int = 8) -> Shape:
    spec = MillSpec(height=height, base=base, top=top)
    stones = [cyl(spec.radius_at(i / courses), (0, height * i / courses, 0), (0, height * (i + 1) / courses, 0),
                  (0.55, 0.32, 0.24) if i < 3 else (0.32, 0.24, 0.18)) for i in range(courses)]
    cap = transform_shape(primitive_call('sphere', {'radius': top * 1.05}, color=(0.25, 0.2, 0.16)), translation_matrix((0, height, 0)))
    gallery = cyl(base * 1.35, (0, height * 0.36, 0), (0, height * 0.38, 0), (0.5, 0.38, 0.24))
    door = transform_shape(primitive_call('cube', {'scale': (0.4, 0.8, 0.1)}, color=(0.2, 0.35, 0.25)), translation_matrix((0, 0.4, base)))
    windows = [transform_shape(primitive_call('cube', {'scale': (0.25, 0.3, 0.1)}, color=(0.95, 0.95, 0.9)), translation_matrix((0, h, spec.radius_at(h / height))))
               for h in (height * 0.5, height * 0.75)]
    return concat_shapes(*stones, cap, gallery, door, *windows)


@register()
def windmill(**options) -> Shape:
    spec = MillSpec(**options)
    settings = asdict(spec)
    body = library_call('mill_body', **{k: settings[k] for k in ('height', 'base', 'top')})
    hub_z = spec.top + 0.45
    wheel = loop(spec.sails, lambda i: transform_shape(
        library_call('sail', length=spec.sail_length),
        rotation_matrix(spec.turn + i * math.tau / spec.sails, (0, 0, 1), (0, 0, 0))))
    hub = cyl(0.1, (0, 0, -0.5), (0, 0, 0.08), (0.3, 0.2, 0.12))
    return concat_shapes(body, transform_shape(concat_shapes(wheel, hub), translation_matrix((0, spec.height, hub_z))))


@register()
def tulip(color: tuple = (0.9, 0.15, 0.2), height: float = 0.3) -> Shape:
    stem = cyl(0.012, (0, 0, 0), (0, height, 0), (0.25, 0.55, 0.2))
    cup = transform_shape(primitive_call('sphere', {'radius': 0.06}, color=color), translation_matrix((0, height, 0)))
    return concat_shapes(stem, cup)


@register()
def tulip_field(rows: int = 6, per_row: int = 14, seed: int = 9) -> Shape:
    jitter = partial(random.Random(seed).uniform, -0.04, 0.04)
    out = []
    for row, cells in groupby(product(range(rows), range(per_row)), key=lambda rc: rc[0]):
        for _, k in cells:
            t = library_call('tulip', color=tulip_color(row), height=0.3 + jitter())
            out.append(transform_shape(t, translation_matrix((k * 0.3 + jitter(), 0, row * 0.45 + jitter()))))
        bed = primitive_call('cube', {'scale': (per_row * 0.3 + 0.2, 0.06, 0.3)}, color=(0.35, 0.25, 0.16))
        out.append(transform_shape(bed, translation_matrix(((per_row - 1) * 0.15, 0, row * 0.45))))
    return concat_shapes(*out)


@register()
def windmill_farm() -> Shape:
    mill = library_call('windmill', height=3.4, turn=math.radians(20))
    tulips = library_call('tulip_field')
    cx, _, cz = compute_shape_center(tulips)
    tulips = transform_shape(tulips, translation_matrix((-cx, 0.03, 3.2 - cz)))
    canal = transform_shape(primitive_call('cube', {'scale': (8, 0.05, 0.8)}, color=(0.35, 0.55, 0.7)), translation_matrix((0, 0.02, 5.2)))
    meadow = transform_shape(primitive_call('cube', {'scale': (8, 0.1, 9)}, color=(0.42, 0.65, 0.33)), translation_matrix((0, -0.05, 1.6)))
    return concat_shapes(meadow, canal, mill, tulips)
