"""a striped lighthouse on a rocky cliff above the sea"""
from helper import *
import math
import numpy as np


@register()
def tower(height: float = 6.0, bottom: float = 1.0, top: float = 0.6, stripes: int = 7) -> Shape:
    def band(i: int) -> Shape:
        t = i / stripes
        color = (0.85, 0.12, 0.12) if i % 2 else (0.96, 0.96, 0.94)
        radius = bottom + (top - bottom) * t
        return primitive_call('cylinder', shape_kwargs={'radius': radius, 'p0': (0, height * t, 0), 'p1': (0, height * (i + 1) / stripes, 0)}, color=color)

    door = transform_shape(primitive_call('cube', shape_kwargs={'scale': (0.45, 0.9, 0.2)}, color=(0.25, 0.15, 0.1)),
                           translation_matrix((0, 0.45, bottom - 0.02)))
    windows = []
    for i, h in enumerate(np.linspace(1.8, height - 0.8, 4)):
        r = bottom + (top - bottom) * h / height
        w = transform_shape(primitive_call('cube', shape_kwargs={'scale': (0.22, 0.35, 0.1)}, color=(0.2, 0.3, 0.4)), translation_matrix((0, h, r)))
        windows.append(transform_shape(w, rotation_matrix(i * math.pi / 3, (0, 1, 0), (0, 0, 0))))
    return concat_shapes(loop(stripes, band), door, *windows)


@register()
def gallery(radius: float = 0.95, posts: int = 14) -> Shape:
    deck = primitive_call('cylinder', shape_kwargs={'radius': radius, 'p0': (0, 0, 0), 'p1': (0, 0.1, 0)}, color=(0.2, 0.2, 0.22))
    ring = [(radius * 0.95 * math.cos(a), radius * 0.95 * math.sin(a)) for a in np.linspace(0, 2 * math.pi, posts + 1)]
    rails = []
    for (x0, z0), (x1, z1) in zip(ring, ring[1:]):
        rails.append(primitive_call('cylinder', shape_kwargs={'radius': 0.02, 'p0': (x0, 0.1, z0), 'p1': (x0, 0.5, z0)}, color=(0.15, 0.15, 0.15)))
        for y in (0.3, 0.5):
            rails.append(primitive_call('cylinder', shape_kwargs={'radius': 0.015, 'p0': (x0, y, z0), 'p1': (x1, y, z1)}, color=(0.15, 0.15, 0.15)))
    return concat_shapes(deck, *rails)


@register()
def lantern(radius: float = 0.5, beam_length: float = 5.0, beam_angle: float = 0.5) -> Shape:
    glass = primitive_call('cylinder', shape_kwargs={'radius': radius, 'p0': (0, 0, 0), 'p1': (0, 0.9, 0)}, color=(0.8, 0.9, 0.95))
    lamp = transform_shape(primitive_call('sphere', shape_kwargs={'radius': 0.3}, color=(1, 0.95, 0.6)), translation_matrix((0, 0.45, 0)))
    roof = loop(6, lambda i: primitive_call('cylinder', shape_kwargs={'radius': (radius + 0.1) * (1 - i / 6), 'p0': (0, 0.9 + 0.1 * i, 0), 'p1': (0, 1.0 + 0.1 * i, 0)}, color=(0.7, 0.1, 0.1)))
    beam = loop(10, lambda i: primitive_call('cylinder', shape_kwargs={
        'radius': 0.05 + 0.05 * i, 'p0': (radius + beam_length * i / 10, 0.45, 0), 'p1': (radius + beam_length * (i + 1) / 10, 0.45, 0)}, color=(1.0, 0.97, 0.75)))
    beam = transform_shape(beam, rotation_matrix(beam_angle, (0, 1, 0), (0, 0, 0)))
    return concat_shapes(glass, lamp, roof, beam)


@register()
def lighthouse(height: float = 6.0) -> Shape:
    body = library_call('tower', height=height)
    y = compute_shape_max(body)[1]
    return concat_shapes(body,
                         transform_shape(library_call('gallery'), translation_matrix((0, y, 0))),
                         transform_shape(library_call('lantern'), translation_matrix((0, y + 0.1, 0))))


@register()
def cliff(layers: int = 6, rocks: int = 11, height: float = 2.4, seed: int = 12) -> Shape:
    rng = np.random.default_rng(seed)
    out = []
    for layer in range(layers):
        y = -height * (layer + 0.5) / layers
        spread = 1.6 + 0.35 * layer
        angles = np.linspace(0, 2 * np.pi, rocks, endpoint=False) + rng.uniform(0, 0.4)
        sizes = rng.uniform(0.7, 1.3, size=(rocks, 3)) * np.array([1.1, height / layers * 1.6, 1.1])
        for a, s in zip(angles, sizes):
            grey = float(rng.uniform(0.32, 0.48))
            rock = primitive_call('cube', shape_kwargs={'scale': tuple(s)}, color=(grey, grey * 0.95, grey * 0.88))
            rock = transform_shape(rock, rotation_matrix(float(a), (0, 1, 0.1), (0, 0, 0)))
            out.append(transform_shape(rock, translation_matrix((spread * np.cos(a), y, spread * np.sin(a)))))
        out.append(primitive_call('cylinder', shape_kwargs={'radius': spread, 'p0': (0, y - 0.2, 0), 'p1': (0, y + height / layers / 2, 0)}, color=(0.36, 0.42, 0.3)))
    return concat_shapes(*out)


@register()
def sea(size: float = 14.0, level: float = -2.3, cells: int = 14) -> Shape:
    step = size / cells
    xs = (np.arange(cells) - (cells - 1) / 2) * step
    gx, gz = np.meshgrid(xs, xs)
    heights = 0.12 * np.sin(1.3 * gx + 0.4 * gz) + 0.08 * np.cos(0.9 * gz)
    tiles = []
    for x, z, h in zip(gx.ravel(), gz.ravel(), heights.ravel()):
        foam = 0.25 if h > 0.12 else 0.0
        tile = primitive_call('cube', shape_kwargs={'scale': (step, 0.5, step)}, color=(0.1 + foam, 0.35 + foam, 0.55 + foam))
        tiles.append(transform_shape(tile, translation_matrix((x, level + h - 0.25, z))))
    return concat_shapes(*tiles)


@register()
def coast_scene() -> Shape:
    return concat_shapes(library_call('sea'), library_call('cliff'), library_call('lighthouse'))
