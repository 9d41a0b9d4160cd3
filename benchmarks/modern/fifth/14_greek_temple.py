"""a ruined greek temple with fluted columns, some of them broken"""
from helper import *
import numpy as np
import math

MARBLE = np.array([0.92, 0.89, 0.82])


def weathered(amount: float) -> tuple[float, float, float]:
    return tuple(float(c) for c in MARBLE * (1 - amount))


@register()
def drum(radius: float = 0.4, height: float = 0.6, flutes: int = 12, tone: float = 0.0) -> Shape:
    core = primitive_call('cylinder', shape_kwargs={'radius': radius * 0.92, 'p0': (0, 0, 0), 'p1': (0, height, 0)}, color=weathered(tone + 0.1))
    ridge = lambda i: primitive_call('cylinder', shape_kwargs={
        'radius': radius * 0.1,
        'p0': (radius * 0.9 * math.cos(2 * math.pi * i / flutes), 0, radius * 0.9 * math.sin(2 * math.pi * i / flutes)),
        'p1': (radius * 0.9 * math.cos(2 * math.pi * i / flutes), height, radius * 0.9 * math.sin(2 * math.pi * i / flutes)),
    }, color=weathered(tone))
    return concat_shapes(core, loop(flutes, ridge))


@register()
def column(drums: int = 6, radius: float = 0.4, drum_height: float = 0.6, capital: bool = True, broken_at: int = -1) -> Shape:
    shapes = [transform_shape(primitive_call('cube', shape_kwargs={'scale': (radius * 2.6, 0.15, radius * 2.6)}, color=weathered(0.05)), translation_matrix((0, 0.075, 0)))]
    standing = drums if broken_at < 0 else min(broken_at, drums)
    y = 0.15
    for k in range(standing):
        r = radius * (1 - 0.03 * k)
        shapes.append(transform_shape(library_call('drum', radius=r, height=drum_height, tone=0.02 * (k % 3)), translation_matrix((0, y, 0))))
        y += drum_height
    if standing == drums and capital:
        for k, widen in enumerate((1.0, 1.2, 1.4)):
            shapes.append(primitive_call('cylinder', shape_kwargs={'radius': radius * 0.85 * widen, 'p0': (0, y + 0.07 * k, 0), 'p1': (0, y + 0.07 * (k + 1), 0)}, color=weathered(0.03)))
        shapes.append(transform_shape(primitive_call('cube', shape_kwargs={'scale': (radius * 2.5, 0.12, radius * 2.5)}, color=weathered(0.0)), translation_matrix((0, y + 0.27, 0))))
    elif standing < drums:
        fallen = transform_shape(library_call('drum', radius=radius * 0.9, height=drum_height), rotation_matrix(math.pi / 2, (0, 0, 1), (0, 0, 0)))
        shapes.append(transform_shape(fallen, translation_matrix((radius * 3.2, radius, 0.3))))
    return concat_shapes(*shapes)


@register()
def steps(width: float = 8.0, depth: float = 12.0, count: int = 3, rise: float = 0.25) -> Shape:
    return loop(count, lambda i: transform_shape(
        primitive_call('cube', shape_kwargs={'scale': (width + 0.7 * (count - i), rise, depth + 0.7 * (count - i))}, color=weathered(0.08 * (count - i) / count)),
        translation_matrix((0, -rise * (count - i - 0.5), 0))))


@register()
def pediment(width: float = 7.6, height: float = 1.4, layers: int = 9, thickness: float = 0.6) -> Shape:
    tri = loop(layers, lambda i: transform_shape(
        primitive_call('cube', shape_kwargs={'scale': (width * (1 - (i + 0.5) / layers), height / layers, thickness)}, color=weathered(0.1 if 0 < i < layers - 1 else 0.0)),
        translation_matrix((0, height * (i + 0.5) / layers, 0))))
    slope = math.atan2(height, width / 2)
    cornices = []
    for s in (-1, 1):
        beam = primitive_call('cube', shape_kwargs={'scale': (math.hypot(height, width / 2), 0.15, thickness * 1.3)}, color=weathered(0))
        beam = transform_shape(beam, rotation_matrix(-s * slope, (0, 0, 1), (0, 0, 0)))
        cornices.append(transform_shape(beam, translation_matrix((s * width / 4, height / 2 + 0.05, 0))))
    return concat_shapes(tri, *cornices)


@register()
def colonnade(nx: int = 4, nz: int = 6, width: float = 7.0, depth: float = 11.0, seed: int = 432) -> Shape:
    rng = np.random.default_rng(seed)
    xs, zs = np.linspace(-width / 2, width / 2, nx), np.linspace(-depth / 2, depth / 2, nz)
    ring = [(x, z) for x in xs for z in zs if np.isclose(abs(x), width / 2) or np.isclose(abs(z), depth / 2)]
    ruined = set(rng.choice(len(ring), size=4, replace=False).tolist())
    out = []
    for index, (x, z) in enumerate(ring):
        front = np.isclose(z, depth / 2)
        broken = int(rng.integers(1, 5)) if index in ruined and not front else -1
        out.append(transform_shape(library_call('column', broken_at=broken), translation_matrix((x, 0, z))))
    return concat_shapes(*out)


@register()
def temple(width: float = 7.0, depth: float = 11.0) -> Shape:
    cols = library_call('colonnade', width=width, depth=depth)
    top = float(compute_shape_max(cols)[1])
    architrave = transform_shape(primitive_call('cube', shape_kwargs={'scale': (width + 1, 0.5, 0.9)}, color=weathered(0.04)), translation_matrix((0, top + 0.25, depth / 2)))
    triglyphs = loop(13, lambda i: transform_shape(primitive_call('cube', shape_kwargs={'scale': (0.2, 0.35, 0.1)}, color=(0.5, 0.6, 0.7)), translation_matrix((-width / 2 + width * i / 12, top + 0.25, depth / 2 + 0.48))))
    gable = transform_shape(library_call('pediment', width=width + 1), translation_matrix((0, top + 0.5, depth / 2)))
    ground = transform_shape(primitive_call('cube', shape_kwargs={'scale': (16, 0.2, 20)}, color=(0.6, 0.58, 0.35)), translation_matrix((0, -0.85, 0)))
    return concat_shapes(ground, library_call('steps', width=width + 1, depth=depth + 1), cols, architrave, triglyphs, gable)
