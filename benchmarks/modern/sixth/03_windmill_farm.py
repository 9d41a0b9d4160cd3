"""a Dutch windmill beside a canal with tulip fields"""
from helper import *
import math

WHITE = (0.93, 0.92, 0.88)
BRICK = (0.5, 0.22, 0.16)
THATCH = (0.45, 0.36, 0.22)


def cyl(p0, p1, r, color):
    return primitive_call('cylinder', shape_kwargs={'radius': r, 'p0': p0, 'p1': p1}, color=color)


def box(scale, color):
    return primitive_call('cube', shape_kwargs={'scale': scale}, color=color)


@register("a tower that tapers in rings")
def tower(rings: int = 12, base: float = 1.5, top: float = 0.9, height: float = 4.0) -> Shape:
    step = height / rings

    def ring(i):
        t = i / (rings - 1)
        r = base * (1 - t) + top * t
        return cyl((0, i * step, 0), (0, (i + 1) * step, 0), r, BRICK if i < rings // 3 else THATCH)

    return loop(rings, ring)


@register("a sail: a lattice along +y")
def sail(length: float = 2.6, width: float = 0.5, bars: int = 9) -> Shape:
    spar = cyl((0, 0, 0), (0, length, 0), 0.05, WHITE)
    edge = cyl((width, 0.5, 0), (width, length, 0), 0.02, WHITE)
    lattice = []
    for i in range(bars):
        y = 0.5 + (length - 0.5) * i / (bars - 1)
        lattice.append(cyl((0, y, 0), (width, y, 0), 0.015, WHITE))
    cloth = transform_shape(box((width, length - 0.6, 0.01), (0.85, 0.8, 0.7)), translation_matrix((width / 2, length / 2 + 0.25, -0.02)))
    return concat_shapes(spar, edge, *lattice, cloth)


@register("four sails around a hub")
def rotor(sails: int = 4, angle: float = 15.0) -> Shape:
    hub = cyl((0, 0, -0.3), (0, 0, 0.1), 0.14, (0.3, 0.2, 0.15))
    blades = loop(sails, lambda i: transform_shape(
        library_call('sail'),
        rotation_matrix(math.radians(angle) + 2 * math.pi * i / sails, (0, 0, 1), (0, 0, 0))))
    return concat_shapes(hub, blades)


@register()
def windmill(height: float = 4.0) -> Shape:
    cap = transform_shape(primitive_call('sphere', shape_kwargs={'radius': 0.95}, color=(0.25, 0.17, 0.12)), scale_matrix(1.0, (0, 0, 0)))
    cap = transform_shape(cap, translation_matrix((0, height, 0)))
    door = transform_shape(box((0.6, 1.1, 0.1), (0.1, 0.35, 0.2)), translation_matrix((0, 0.55, 1.45)))
    window_at = [(0.0, 1.9, 1.28), (-0.35, 2.7, 1.08), (0.35, 2.7, 1.08)]
    windows = [transform_shape(box((0.3, 0.4, 0.12), WHITE), translation_matrix(p)) for p in window_at]
    gallery = cyl((0, 1.35, 0), (0, 1.42, 0), 1.8, (0.6, 0.45, 0.3))
    posts = loop(16, lambda i: transform_shape(
        cyl((1.75, 1.42, 0), (1.75, 1.8, 0), 0.025, WHITE),
        rotation_matrix(math.tau * i / 16, (0, 1, 0), (0, 0, 0))))
    wings = transform_shape(library_call('rotor'), translation_matrix((0, height + 0.1, 1.15)))
    return concat_shapes(library_call('tower', height=height), cap, door, *windows, gallery, posts, wings)


@register("one strip of tulips along x")
def tulip_strip(count: int = 14, color: tuple[float, float, float] = (0.9, 0.1, 0.2), spacing: float = 0.3) -> Shape:
    def tulip(i):
        stem = cyl((0, 0, 0), (0, 0.25, 0), 0.02, (0.2, 0.5, 0.2))
        cup = transform_shape(primitive_call('sphere', shape_kwargs={'radius': 0.07}, color=color), translation_matrix((0, 0.3, 0)))
        return transform_shape(concat_shapes(stem, cup), translation_matrix((i * spacing, 0, 0.05 * (-1) ** i)))
    return loop(count, tulip)


@register()
def windmill_farm() -> Shape:
    colors = [(0.9, 0.1, 0.2), (0.98, 0.8, 0.1), (0.95, 0.5, 0.7), (0.55, 0.2, 0.6)]
    ground = transform_shape(box((12, 0.2, 12), (0.4, 0.6, 0.3)), translation_matrix((0, -0.1, 0)))
    canal = transform_shape(box((12, 0.05, 1.6), (0.3, 0.5, 0.65)), translation_matrix((0, 0.01, 2.8)))
    strips = [
        transform_shape(library_call('tulip_strip', color=c), translation_matrix((-2.0, 0, 4.2 + 0.45 * k)))
        for k, c in enumerate(colors)
    ]
    mill = transform_shape(library_call('windmill'), translation_matrix((-1.5, 0, -1.5)))
    return concat_shapes(ground, canal, mill, *strips)
